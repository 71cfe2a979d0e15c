/* Probing: src/soil/probe.c. Its outward part is in soil.h. */
#ifndef FURROW_SOIL_PROBE_H
#define FURROW_SOIL_PROBE_H

#include "soil/soil.h"

#endif
