/* Reads the time of a scene's sun. */
#ifndef FURROW_SCENE_SUN_H
#define FURROW_SCENE_SUN_H

#include <stdbool.h>

/* Reads a time such as "2026-11-27T16:00:00Z", from 1900 to 2100. *days: since 2000-01-01 12:00, UTC. Returns false if it is none. */
bool scene_sun_time(const char *text, double *days);

#endif
