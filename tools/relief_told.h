/* What commands that read a store without a scene say of relief that they cannot show. */
#ifndef FURROW_TOOLS_RELIEF_TOLD_H
#define FURROW_TOOLS_RELIEF_TOLD_H

#include "store/store.h"

void relief_tell_missing(const char *path, const struct store *store); /* a note, where the store's relief depends on classes */

#endif
