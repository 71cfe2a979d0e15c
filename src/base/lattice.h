/*
 * The absolute integer lattice of heights, and the pure functions over it.
 *
 *     base    int32, 2^-18 m, relative to a reference that is a multiple of 1024 m (BASE_NODATA: a hole)
 *     offset  int32, 2^-20 m; a post without data has offset 0
 *     pose    int64, 2^-20 m
 *
 * shaders/lib/lattice.glsl holds the same formulas; tests/gpu compares them bit for bit.
 */
#ifndef FURROW_BASE_LATTICE_H
#define FURROW_BASE_LATTICE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define BASE_BITS 18
#define OFFSET_BITS 20
#define BASE_NODATA INT32_MIN
#define REFERENCE_STEP 1024 /* metres */

/* Returns the nearest lattice value, halves away from zero. `metres` must be finite and below 2^40. */
int64_t lattice_base(double metres);
int64_t lattice_offset(double metres);
double lattice_base_metres(int64_t base);
double lattice_offset_metres(int64_t offset);

/* Returns the reference in metres, a multiple of 1024, for posts from `low` to `high` metres. */
int32_t lattice_reference(double low, double high);
/* Returns true if all heights from `low` to `high` fit int32 relative to their reference. */
bool lattice_fits(double low, double high);

/* Returns a height relative to `reference` (metres). NaN becomes BASE_NODATA. */
int32_t lattice_base_relative(double metres, int32_t reference);

/*
 * Interpolates bilinearly in a cell. Corners: a (south-west), b (south-east), c (north-west), d (north-east). The place is (fx,
 * fy) / 2^shift of the cell, with 0 <= fx, fy <= 2^shift and 0 <= shift <= 14.
 *
 * The weighted sum is exact in 64 bits, and rounded to nearest (halves up). The result is nodata if a corner with weight is.
 */
int32_t lattice_interpolate(int32_t a, int32_t b, int32_t c, int32_t d, uint32_t fx, uint32_t fy,
			    int shift);

/*
 * Fills a tile of a level below zero, (cells + 1)^2 posts, from the patch of level-0 posts around it.
 *
 * `patch` is patch_posts x patch_posts, with patch_posts = lattice_patch_posts(cells, shift). Its first post is the level-0
 * post at or south-west of the tile's first post. (sub_x, sub_y) is the tile's first post within the patch's first cell, in
 * 2^-shift of a cell. It is 0 unless 2^shift > cells.
 */
uint32_t lattice_patch_posts(uint32_t cells, int shift);
/* Returns post (x, y) of a level `shift` levels finer than the side x side posts. Both levels count from their first post. */
int32_t lattice_finer(const int32_t *posts, uint32_t side, int shift, uint64_t x, uint64_t y);
/*
 * Fills the posts of a tile that have no data, by interpolation between those of a tile above it,
 * `shift` levels coarser. Both are (cells + 1)^2 posts. (x, y): the tile's first post, counted in
 * its own posts from the coarse tile's first one. Called from the finest level above to the
 * coarsest, it gives each post the value of the finest level that has one there. `more`: what is
 * added to the posts that it fills; NULL: nothing. Returns how many posts are left without.
 */
size_t lattice_fill(const int32_t *coarse, uint32_t cells, int shift, uint64_t x, uint64_t y,
		    const int32_t *more, int32_t *posts);
void lattice_subdivide(const int32_t *patch, uint32_t cells, int shift, uint32_t sub_x,
		       uint32_t sub_y, int32_t *posts);

/* Returns the weighted sum of the values. If a value is NaN but its weight is at most `beside`, it is left out. */
double lattice_weighted(const double *values, const double *weights, int count, double beside);
/* Interpolates between the corners of a cell: south-west, south-east, north-west, north-east. (u, v): position in the cell, 0
 * to 1. */
double lattice_bilinear(const double corners[4], double u, double v, double beside);

/* Returns the first multiple of 2^steps that is at least v. */
int64_t lattice_align(int64_t v, int steps);

/*
 * Decimation: writes every second post of a fine tile (cells + 1 squared) into its quadrant of the
 * coarse tile that covers it. (qx, qy) is 0 or 1: the fine tile's low bits.
 */
void lattice_decimate_i32(const int32_t *fine, uint32_t cells, uint32_t qx, uint32_t qy,
			  int32_t *coarse);

#endif
