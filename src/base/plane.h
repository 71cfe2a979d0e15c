/*
 * The planes: what deformation keeps for each post, in a slot, in a page's bytes and in the store.
 *
 * Every deformed tile has the offset plane. It has other planes if a scene needs them. A set of planes is a mask of bits 1 <<
 * PLANE_*. Texels are integers. A missing plane reads as zeros.
 */
#ifndef FURROW_BASE_PLANE_H
#define FURROW_BASE_PLANE_H

#include <stddef.h>
#include <stdint.h>

enum plane {
	PLANE_OFFSET,          /* int32, 2^-20 m: height = base + offset */
	PLANE_DISTURBANCE,     /* uint8: disturbance, how much the soil was compressed */
	PLANE_DEPOSITED,       /* int32, 2^-20 m: deposited thickness of relaxing soil on the base; negative where soil slid away */
	PLANE_PLASTIC_SINKAGE, /* int32, 2^-20 m: plastic sinkage, the largest sinkage so far along the surface's normal */
	PLANE_SHEAR,           /* uint16, 2^-16 m: shear displacement under contact so far; 65535: this much or more */
	PLANES
};

/* Return the bytes of a post, and the name: "offset", "dirt", ... Pure. */
size_t plane_bytes(enum plane plane);
const char *plane_name(enum plane plane);
/* Returns the value of a post in metres; for disturbance the stored number. Pure. */
double plane_value(enum plane plane, int32_t post);

#define PLANE_BIT(plane) (1u << (plane))

#endif
