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
	PLANE_SHEAR,           /* two int16, 2^-15: mobilised shear, to the east in the low half, to the north in the high half */
	PLANE_DUG,             /* int32, 2^-20 m: what slip has dug in all contacts */
	/* What a post remembers of loose layers: src/soil/law/memory.h */
	PLANE_SETTLED, /* int32, 2^-20 m: the deposited thickness when a body last touched the post. What is deposited beyond it is loose */
	PLANE_LOOSE,   /* int32, 2^-20 m: thickness of a loose layer that a body has touched and not used up, down to the floor */
	PLANE_FLOOR,   /* int32, 2^-20 m: plastic sinkage of the floor below that layer */
	PLANE_DENSITY, /* int32, 2^-20: how dense passes have made the soil: a share of what `soil.compaction` left open */
	PLANE_SLOPE,   /* two uint16, 2^-9 m: how far a post's slope rises above it; in the high half: falls below it */
	PLANES
};

/* Return the bytes of a post, and the name: "offset", "dirt", ... Pure. */
size_t plane_bytes(enum plane plane);
const char *plane_name(enum plane plane);
/* Returns its name as a layer of exports and maps: "deposited" for "heaped", "plastic_sinkage" for "pressed". Pure. */
const char *plane_layer(enum plane plane);
/* Returns the value of a post in metres; for disturbance the stored number; for shear its amount, as a share of the soil's strength.
 * For slope it is the height of the whole slope. Pure. */
double plane_value(enum plane plane, int32_t post);

/*
 * Mobilised shear: by what share of its strength the soil of a post is sheared, as a vector of at most 1. It is the elastic part of
 * the shear displacement, in units of the soil's shear modulus K. A post without contact has none.
 */
#define PLANE_SHEAR_BITS 15
#define PLANE_SHEAR_MOST 32767 /* of either half of a post */
enum plane_shear_part { PLANE_SHEAR_EAST, PLANE_SHEAR_NORTH, PLANE_SHEAR_AMOUNT };
/* Returns a part of a post of PLANE_SHEAR, 2^-15. Pure. */
int32_t plane_shear(int32_t post, enum plane_shear_part part);

#define PLANE_SLOPE_BITS 9 /* binary digits of heights of slopes behind the point */

#define PLANE_BIT(plane) (1u << (plane))

#endif
