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
	/* Marks that fade. A post has the time at which its mark is gone, int32, in quarter seconds of the store's time; 0: it never had one */
	PLANE_HEALED, /* disturbance that heals */
	PLANE_RISEN,  /* stems that a body bent */
	PLANE_GROWN,  /* cover that slip tore */
	PLANES
};

/* Return the bytes of a post, and the name: "offset", "dirt", ... Pure. */
size_t plane_bytes(enum plane plane);
const char *plane_name(enum plane plane);
/* Returns its name as a layer of exports and maps: "deposited" for "heaped", "plastic_sinkage" for "pressed". Pure. */
const char *plane_layer(enum plane plane);
/* Returns the value of a post in metres; for disturbance the stored number; for shear its amount, as a share of the soil's strength.
 * For slope it is the height of the whole slope. For a mark that fades it is the time at which it is gone, s. Pure. */
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

/*
 * A mark fades evenly. It has PLANE_MARK_MOST shades, and the darkest one takes `whole` quarter seconds. So a plane needs no change as time goes on. A new
 * mark replaces an older one if it is gone later.
 */
#define PLANE_MARKS (PLANE_BIT(PLANE_HEALED) | PLANE_BIT(PLANE_RISEN) | PLANE_BIT(PLANE_GROWN))
#define PLANE_TIME_BITS 2 /* binary digits of seconds behind the point */
#define PLANE_MARK_MOST 255
#define PLANE_TIME_MOST (1 << 30)  /* the latest time: 8.5 years */
#define PLANE_WHOLE_MOST (1 << 29) /* the most that a mark takes: 4.25 years */
/* The time of a store, and what its darkest marks take, quarter seconds; 0: no such marks are kept. */
struct plane_marks {
	int32_t now, heals, rises, grows;
};
/* Returns when a mark of so many shades that is made at `now` is gone. whole: PLANE_MARK_MOST to PLANE_WHOLE_MOST. Pure. */
int32_t plane_mark(int32_t now, int32_t shades, int32_t whole);
/* Returns the shades that a mark still has at `now`, 0 to PLANE_MARK_MOST; whole 0: none. Pure. */
int32_t plane_mark_left(int32_t until, int32_t now, int32_t whole);
/* Returns what a mark of such a plane takes; 0: it is none of these planes, or none is kept. Pure. */
int32_t plane_mark_whole(const struct plane_marks *marks, enum plane plane);

#endif
