#include "base/lattice.h"

#include <assert.h>
#include <math.h>

int64_t lattice_base(double metres)
{
	return llround(ldexp(metres, BASE_BITS));
}

int64_t lattice_offset(double metres)
{
	return llround(ldexp(metres, OFFSET_BITS));
}

double lattice_base_metres(int64_t base)
{
	return ldexp((double)base, -BASE_BITS);
}

double lattice_offset_metres(int64_t offset)
{
	return ldexp((double)offset, -OFFSET_BITS);
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

void lattice_subdivide(const int32_t *patch, uint32_t cells, int shift, uint32_t sub_x,
		       uint32_t sub_y, int32_t *posts)
{
	uint32_t stride = lattice_patch_posts(cells, shift), mask = (1u << shift) - 1;
	for (uint32_t y = 0; y <= cells; y++) {
		uint32_t py = sub_y + y, cy = py >> shift, fy = py & mask;
		if (cy == stride - 1) { /* the last row of posts belongs to the last cell */
			cy--;
			fy = mask + 1;
		}
		for (uint32_t x = 0; x <= cells; x++) {
			uint32_t px = sub_x + x, cx = px >> shift, fx = px & mask;
			if (cx == stride - 1) {
				cx--;
				fx = mask + 1;
			}
			const int32_t *p = patch + (size_t)cy * stride + cx;
			posts[(size_t)y * (cells + 1) + x] =
				lattice_interpolate(p[0], p[1], p[stride], p[stride + 1], fx, fy, shift);
		}
	}
}

void lattice_decimate_i32(const int32_t *fine, uint32_t cells, uint32_t qx, uint32_t qy, int32_t *coarse)
{
	uint32_t half = cells / 2, stride = cells + 1;
	for (uint32_t y = 0; y <= half; y++)
		for (uint32_t x = 0; x <= half; x++)
			coarse[(size_t)(qy * half + y) * stride + qx * half + x] = fine[(size_t)2 * y * stride + 2 * x];
}
