#include "base/plane.h"

#include <assert.h>
#include <math.h>

#include "base/lattice.h"

static const struct {
	const char *name;
	size_t bytes;
} planes[PLANES] = {
	[PLANE_OFFSET] = {"offset", 4},	  [PLANE_DISTURBANCE] = {"dirt", 1},	[PLANE_DEPOSITED] = {"heaped", 4},
	[PLANE_PLASTIC_SINKAGE] = {"pressed", 4}, [PLANE_SHEAR] = {"shear", 2},
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

double plane_value(enum plane plane, int32_t post)
{
	return plane == PLANE_DISTURBANCE ? post : plane == PLANE_SHEAR ? ldexp(post, -16) : lattice_offset_metres(post);
}
