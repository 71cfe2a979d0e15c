/*
 * Soil that is brought to a post or taken from it by no body, as a heap that is poured by hand. Pure.
 *
 * Invariant: the offset changes by the amount, to the unit. Nothing else of a post has a volume.
 */
#ifndef FURROW_BEARING_POUR_H
#define FURROW_BEARING_POUR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/plane.h"

#define BEARING_POUR_MOST (700 << 20) /* 2^-20 m: an offset that a pour leaves is at most so far from 0. Below what can slide */

/*
 * Changes post `at` of these planes by an amount, 2^-20 m; below 0 soil is taken. Planes that are not kept are NULL; the offset is there.
 *
 * Soil that comes loose lies as soil that slid there: it raises offset and deposited thickness alone. Soil that comes dense lies as ground that nothing has
 * touched. What is taken comes off loose layers first. Where more is taken, the new surface is ground that nothing has touched.
 */
void bearing_pour(void *const planes[PLANES], size_t at, int32_t amount, bool loose);

#endif
