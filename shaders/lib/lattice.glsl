// The lattice's formulas, the same as in src/base/lattice.c. tests/gpu/lattice.c compares them.

#include "lib/int64.glsl"

const int BASE_NODATA = int(0x80000000u);

// Bilinear interpolation in a cell. Corners: a south-west, b south-east, c north-west, d north-east. The place is f / 2^shift of
// the cell, 0 <= f <= 2^shift, 0 <= shift <= 14. Returns the exact weighted sum rounded to nearest, halves up. Returns nodata
// if any corner with weight is nodata.
int lattice_interpolate(int a, int b, int c, int d, uvec2 f, int shift)
{
	uvec2 g = uvec2(1u << shift) - f;
	int wa = int(g.x * g.y), wb = int(f.x * g.y), wc = int(g.x * f.y), wd = int(f.x * f.y);
	if ((wa != 0 && a == BASE_NODATA) || (wb != 0 && b == BASE_NODATA) ||
	    (wc != 0 && c == BASE_NODATA) || (wd != 0 && d == BASE_NODATA))
		return BASE_NODATA;
	i64 sum = i64_add(i64_add(i64_mul(a, wa), i64_mul(b, wb)), i64_add(i64_mul(c, wc), i64_mul(d, wd)));
	if (shift == 0)
		return i64_to_int(sum);
	return i64_to_int(i64_sar(i64_add(sum, i64_shl(i64_from(1), 2 * shift - 1)), 2 * shift));
}
