/* resident: the ground that is in memory. */
#ifndef FURROW_RESIDENT_H
#define FURROW_RESIDENT_H

#include "resident/ground.h"
#include "resident/newest.h"
#include "resident/pages.h"
#include "resident/pyramid.h"
#include "resident/soil_map.h"

#endif
