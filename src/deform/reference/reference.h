/*
 * The reference of deform: the same ground and the same objects in floating point on the CPU, by
 * brute force and in the plainest words. For tests and accuracy only; it shares nothing with what
 * it checks but the poses. Pure; any thread.
 */
#ifndef FURROW_DEFORM_REFERENCE_H
#define FURROW_DEFORM_REFERENCE_H

#include "deform/deform.h"

/* The lowest that the underside of the swept object is above (x, y), in metres from the start of the
 * sweep (its `from`): x, y along the ground and *z up. False if the object never is above it. */
bool reference_underside(const struct deform_sweep *sweep, long double x, long double y,
			 long double *z);

/* Ground of width x height posts, row 0 the southern: `box` of radius posts, once. In place. */
#define REFERENCE_SWEPT 1 /* contact: the sweep pressed the post */
#define REFERENCE_HELD 2  /* contact: the object rests on it at the end */
enum status reference_box(int width, int height, const int32_t *base, const uint8_t *contact, int radius,
			  int32_t *offset) FURROW_CHECKED;

#endif
