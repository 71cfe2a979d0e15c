/* Finding the host's MuJoCo. */
#ifndef FURROW_PLUGIN_HOST_H
#define FURROW_PLUGIN_HOST_H

#include <stdbool.h>

/* Fills plugin_host from the library of MuJoCo that loads the plugin. Returns false if this process has none of the version of our headers; where it has another
 * one that library has warned. */
bool plugin_find_host(void);

#endif
