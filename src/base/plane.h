/*
 * What deformation keeps of a post, a plane each: in a slot, in a page's bytes, in the store.
 *
 * The offset plane is there wherever a tile is deformed; the others where a scene calls for them. A
 * set of planes is a mask of bits 1 << PLANE_*. Texels are integers; a plane that is not there reads
 * as zeros.
 */
#ifndef FURROW_BASE_PLANE_H
#define FURROW_BASE_PLANE_H

#include <stddef.h>
#include <stdint.h>

enum plane {
	PLANE_OFFSET,  /* int32, 2^-20 m: height = base + offset */
	PLANE_DIRT,    /* uint8: how much the soil was pressed */
	PLANE_HEAPED,  /* int32, 2^-20 m: loose soil laid on (or slid from) the base; may be below 0 */
	PLANE_PRESSED, /* int32, 2^-20 m: the largest sinkage so far, along the surface's normal */
	PLANE_SHEAR,   /* uint16, 2^-16 m: shear displacement under contact so far; 65535: no less than that */
	PLANES
};

/* Bytes a post, and the name: "offset", "dirt", ... Pure. */
size_t plane_bytes(enum plane plane);
const char *plane_name(enum plane plane);
/* What a post of it means: metres; dirt as it is. Pure. */
double plane_value(enum plane plane, int32_t post);

#define PLANE_BIT(plane) (1u << (plane))

#endif
