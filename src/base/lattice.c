#include "base/lattice.h"

#include <assert.h>
#include <math.h>

int64_t lattice_base(double metres)
{
	return llround(metres * (1 << BASE_BITS));
}

int64_t lattice_offset(double metres)
{
	return llround(metres * (1 << OFFSET_BITS));
}

double lattice_base_metres(int64_t base)
{
	return (double)base * (1.0 / (1 << BASE_BITS));
}

double lattice_offset_metres(int64_t offset)
{
	return (double)offset * (1.0 / (1 << OFFSET_BITS));
}

int32_t lattice_reference(double low, double high)
{
	double middle = (low + high) / 2;
	return (int32_t)(llround(middle / REFERENCE_STEP) * REFERENCE_STEP);
}

bool lattice_fits(double low, double high)
{
	if (!isfinite(low) || !isfinite(high) || fabs(low) > 1e8 || fabs(high) > 1e8)
		return false;
	double reference = lattice_reference(low, high), limit = ldexp(1, 31 - BASE_BITS) - 1;
	return low - reference > -limit && high - reference < limit;
}

int32_t lattice_base_relative(double metres, int32_t reference)
{
	if (isnan(metres))
		return BASE_NODATA;
	int64_t value = lattice_base(metres) - (int64_t)reference * (1 << BASE_BITS);
	assert(value > INT32_MIN && value <= INT32_MAX);
	return (int32_t)value;
}

int32_t lattice_interpolate(int32_t a, int32_t b, int32_t c, int32_t d, uint32_t fx, uint32_t fy,
			    int shift)
{
	uint32_t side = 1u << shift;
	uint32_t wa = (side - fx) * (side - fy), wb = fx * (side - fy), wc = (side - fx) * fy, wd = fx * fy;
	if ((wa != 0 && a == BASE_NODATA) || (wb != 0 && b == BASE_NODATA) ||
	    (wc != 0 && c == BASE_NODATA) || (wd != 0 && d == BASE_NODATA))
		return BASE_NODATA;
	int64_t sum = (int64_t)a * wa + (int64_t)b * wb + (int64_t)c * wc + (int64_t)d * wd;
	if (shift == 0)
		return (int32_t)sum;
	return (int32_t)((sum + ((int64_t)1 << (2 * shift - 1))) >> (2 * shift));
}

uint32_t lattice_patch_posts(uint32_t cells, int shift)
{
	uint32_t span = cells >> shift;
	return (span > 0 ? span : 1) + 1;
}

int32_t lattice_finer(const int32_t *posts, uint32_t side, int shift, uint64_t x, uint64_t y)
{
	const uint32_t part = (1u << shift) - 1;
	uint64_t cx = x >> shift, cy = y >> shift;
	uint32_t fx = (uint32_t)x & part, fy = (uint32_t)y & part;
	if (shift == 0)
		return posts[y * side + x];
	if (cx == side - 1) { /* the last posts belong to the last cell */
		cx--;
		fx = part + 1;
	}
	if (cy == side - 1) {
		cy--;
		fy = part + 1;
	}
	const int32_t *p = posts + cy * side + cx;
	return lattice_interpolate(p[0], p[1], p[side], p[side + 1], fx, fy, shift);
}

size_t lattice_fill(const int32_t *coarse, uint32_t cells, int shift, uint64_t x, uint64_t y,
		    const int32_t *more, int32_t *posts)
{
	const uint32_t side = cells + 1;
	size_t left = 0;
	for (uint32_t row = 0; row < side; row++)
		for (uint32_t column = 0; column < side; column++) {
			const size_t at = (size_t)row * side + column;
			if (posts[at] == BASE_NODATA) {
				posts[at] = lattice_finer(coarse, side, shift, x + column, y + row);
				if (more != NULL && posts[at] != BASE_NODATA)
					posts[at] += more[at];
			}
			left += posts[at] == BASE_NODATA;
		}
	return left;
}

void lattice_subdivide(const int32_t *patch, uint32_t cells, int shift, uint32_t sub_x,
		       uint32_t sub_y, int32_t *posts)
{
	const uint32_t side = lattice_patch_posts(cells, shift);
	for (uint32_t y = 0; y <= cells; y++)
		for (uint32_t x = 0; x <= cells; x++)
			posts[(size_t)y * (cells + 1) + x] = lattice_finer(patch, side, shift, (uint64_t)sub_x + x, (uint64_t)sub_y + y);
}

double lattice_weighted(const double *values, const double *weights, int count, double beside)
{
	double sum = 0;
	for (int i = 0; i < count; i++)
		if (weights[i] > beside || (weights[i] != 0 && !isnan(values[i])))
			sum += weights[i] * values[i];
	return sum;
}

double lattice_bilinear(const double corners[4], double u, double v, double beside)
{
	const double areas[4] = {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
	return lattice_weighted(corners, areas, 4, beside);
}

int64_t lattice_align(int64_t v, int steps)
{
	int64_t mask = ((int64_t)1 << steps) - 1;
	return (v + mask) & ~mask;
}

void lattice_decimate_i32(const int32_t *fine, uint32_t cells, uint32_t qx, uint32_t qy, int32_t *coarse)
{
	uint32_t half = cells / 2, stride = cells + 1;
	for (uint32_t y = 0; y <= half; y++)
		for (uint32_t x = 0; x <= half; x++)
			coarse[(size_t)(qy * half + y) * stride + qx * half + x] = fine[(size_t)2 * y * stride + 2 * x];
}
