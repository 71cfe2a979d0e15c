#include "base/plane.h"

#include <assert.h>
#include <math.h>

#include "base/lattice.h"

static const struct {
	const char *name, *layer;
	size_t bytes;
} planes[PLANES] = {
	[PLANE_OFFSET] = {"offset", "offset", 4},
	[PLANE_DISTURBANCE] = {"dirt", "dirt", 1},
	[PLANE_DEPOSITED] = {"heaped", "deposited", 4},
	[PLANE_PLASTIC_SINKAGE] = {"pressed", "plastic_sinkage", 4},
	[PLANE_SHEAR] = {"shear", "shear", 4},
	[PLANE_DUG] = {"dug", "dug", 4},
	[PLANE_SETTLED] = {"settled", "settled", 4},
	[PLANE_LOOSE] = {"loose", "loose", 4},
	[PLANE_FLOOR] = {"floor", "floor", 4},
	[PLANE_DENSITY] = {"density", "density", 4},
	[PLANE_SLOPE] = {"slope", "slope", 4},
	[PLANE_HEALED] = {"healed", "healed", 4},
	[PLANE_RISEN] = {"risen", "risen", 4},
	[PLANE_GROWN] = {"grown", "grown", 4},
};

size_t plane_bytes(enum plane plane)
{
	assert((unsigned)plane < PLANES);
	return planes[plane].bytes;
}

const char *plane_name(enum plane plane)
{
	assert((unsigned)plane < PLANES);
	return planes[plane].name;
}

const char *plane_layer(enum plane plane)
{
	assert((unsigned)plane < PLANES);
	return planes[plane].layer;
}

double plane_value(enum plane plane, int32_t post)
{
	if (plane == PLANE_SHEAR)
		return ldexp(hypot(plane_shear(post, PLANE_SHEAR_EAST), plane_shear(post, PLANE_SHEAR_NORTH)), -PLANE_SHEAR_BITS);
	if (plane == PLANE_SLOPE)
		return ldexp((uint32_t)post & 0xffff, -PLANE_SLOPE_BITS) + ldexp((uint32_t)post >> 16, -PLANE_SLOPE_BITS);
	if (PLANE_MARKS & PLANE_BIT(plane))
		return ldexp(post, -PLANE_TIME_BITS);
	return plane == PLANE_DISTURBANCE ? post : lattice_offset_metres(post);
}

int32_t plane_shear(int32_t post, enum plane_shear_part part)
{
	const uint32_t bits = (uint32_t)post;
	const int32_t east = (int32_t)((bits & 0xffff) ^ 0x8000) - 0x8000, north = (int32_t)((bits >> 16) ^ 0x8000) - 0x8000;
	return part == PLANE_SHEAR_EAST ? east : part == PLANE_SHEAR_NORTH ? north : (int32_t)lround(hypot(east, north));
}

int32_t plane_mark(int32_t now, int32_t shades, int32_t whole)
{
	assert(shades >= 0 && shades <= PLANE_MARK_MOST && whole >= PLANE_MARK_MOST && whole <= PLANE_WHOLE_MOST);
	return now + (int32_t)(((int64_t)shades * whole + PLANE_MARK_MOST - 1) / PLANE_MARK_MOST);
}

int32_t plane_mark_left(int32_t until, int32_t now, int32_t whole)
{
	const int64_t left = (int64_t)until - now;
	if (whole <= 0 || left <= 0)
		return 0;
	return left < whole ? (int32_t)(left * PLANE_MARK_MOST / whole) : PLANE_MARK_MOST;
}

int32_t plane_mark_whole(const struct plane_marks *marks, enum plane plane)
{
	return plane == PLANE_HEALED ? marks->heals : plane == PLANE_RISEN ? marks->rises : plane == PLANE_GROWN ? marks->grows : 0;
}
