/*
 * Rows of posts to tiles of every level, in one pass from south to north.
 *
 *   rows -> band 0 -> tiles of level 0 -> every second row and post -> band 1 -> ... -> coarsest
 *
 * A level holds one band: (cells + 1) rows as wide as its tiles. A full band is cut, decimated into
 * the next level's and begun again with its last row, which is the next tiles' first.
 *
 * Invariants: (1) a band's tiles are emitted before any of its rows reaches the coarser band, so a
 * tile comes after all it covers; (2) posts beyond the terrain are nodata in every band; (3) what is
 * known of a tile's subtree lies in its level's `under` until the tile is emitted.
 */
#include "dem/dem.h"

#include <assert.h>
#include <math.h>

#define STRIP_POSTS (1 << 20) /* of doubles asked for at once, about */

/* What the tiles below one tile hold. */
struct under {
	double low, high, error; /* metres; low and high NaN while there is no data */
};

struct band {
	uint32_t tiles_x, tiles_y;
	int64_t width;       /* posts: tiles_x * cells + 1 */
	uint32_t filled;     /* rows, of cells + 1 */
	uint32_t tile_y;     /* of the band being filled */
	int32_t *codes;      /* cells + 1 rows */
	struct under *under; /* tiles_x; NULL at level 0 */
};

struct cut {
	const struct world *world;
	double step;
	dem_tile_fn emit;
	void *emit_user;
	int coarsest;
	struct band bands[TILE_LEVEL_MAX + 1];
	int32_t *codes; /* of the tile being emitted */
	double low, high; /* over all posts so far */
};

static enum status band_full(struct cut *cut, int level);

static void widen(struct under *range, double low, double high)
{
	if (isnan(low))
		return;
	range->low = isnan(range->low) || low < range->low ? low : range->low;
	range->high = isnan(range->high) || high > range->high ? high : range->high;
}

static void codes_clear(int32_t *codes, int64_t count)
{
	for (int64_t i = 0; i < count; i++)
		codes[i] = HEIGHT_CODE_NODATA;
}

static void codes_range(const int32_t *codes, size_t count, double step, struct under *range)
{
	int32_t low = INT32_MAX, high = INT32_MIN;
	bool any = false;
	for (size_t i = 0; i < count; i++) {
		if (codes[i] == HEIGHT_CODE_NODATA)
			continue;
		any = true;
		low = codes[i] < low ? codes[i] : low;
		high = codes[i] > high ? codes[i] : high;
	}
	/* Codes keep the order of heights, so the extremes are the decoded codes'. */
	if (any)
		widen(range, height_code_metres(low, step), height_code_metres(high, step));
}

/* How far a post is off the mean of the posts that are left when it is decimated away. */
static double off_mean(double step, int32_t post, const int32_t *kept, int count)
{
	if (post == HEIGHT_CODE_NODATA)
		return 0;
	double sum = 0;
	for (int i = 0; i < count; i++) {
		if (kept[i] == HEIGHT_CODE_NODATA)
			return 0;
		sum += height_code_metres(kept[i], step);
	}
	return fabs(height_code_metres(post, step) - sum / count);
}

/* What decimating this tile loses: most that a post is off the bilinear surface of its even posts. */
static double decimation_error(const int32_t *codes, uint32_t cells, double step)
{
	size_t stride = cells + 1;
	double most = 0;
	for (uint32_t y = 0; y < cells + 1; y++) {
		for (uint32_t x = (y & 1) ? 0 : 1; x < cells + 1; x += (y & 1) ? 1 : 2) {
			const int32_t *p = codes + y * stride + x;
			double off;
			if ((x & 1) != 0 && (y & 1) != 0)
				off = off_mean(step, *p, (int32_t[]){p[-(ptrdiff_t)stride - 1],
					p[-(ptrdiff_t)stride + 1], p[stride - 1], p[stride + 1]}, 4);
			else if ((x & 1) != 0)
				off = off_mean(step, *p, (int32_t[]){p[-1], p[1]}, 2);
			else
				off = off_mean(step, *p, (int32_t[]){p[-(ptrdiff_t)stride], p[stride]}, 2);
			most = off > most ? off : most;
		}
	}
	return most;
}

static enum status emit_tile(struct cut *cut, int level, uint32_t x)
{
	const struct band *band = &cut->bands[level];
	uint32_t cells = cut->world->cells;
	size_t posts = (size_t)cells + 1;
	for (size_t y = 0; y < posts; y++)
		memcpy(cut->codes + y * posts, band->codes + y * (size_t)band->width + (size_t)x * cells,
		       posts * sizeof *cut->codes);
	struct under under = {(double)NAN, (double)NAN, 0};
	if (level == 0)
		codes_range(cut->codes, posts * posts, cut->step, &under);
	else
		under = band->under[x];
	struct dem_tile tile = {
		.tile = {level, x, band->tile_y},
		.codes = cut->codes,
		.low = under.low,
		.high = under.high,
		.error = under.error,
	};
	enum status status = cut->emit(cut->emit_user, &tile);
	if (status != STATUS_OK || level == cut->coarsest)
		return status;
	struct under *above = &cut->bands[level + 1].under[x / 2];
	double error = under.error + decimation_error(cut->codes, cells, cut->step);
	widen(above, under.low, under.high);
	above->error = error > above->error ? error : above->error;
	return STATUS_OK;
}

/* Every second row of a full band, of which row 0 is there already unless it is the first. */
static enum status decimate_band(struct cut *cut, int level)
{
	const struct band *fine = &cut->bands[level];
	struct band *coarse = &cut->bands[level + 1];
	for (uint32_t y = fine->tile_y > 0 ? 2 : 0; y <= cut->world->cells; y += 2) {
		const int32_t *from = fine->codes + (int64_t)y * fine->width;
		int32_t *to = coarse->codes + (int64_t)coarse->filled * coarse->width;
		int64_t count = (fine->width + 1) / 2;
		for (int64_t x = 0; x < count; x++)
			to[x] = from[2 * x];
		codes_clear(to + count, coarse->width - count);
		coarse->filled++;
	}
	return coarse->filled == cut->world->cells + 1 ? band_full(cut, level + 1) : STATUS_OK;
}

static enum status band_full(struct cut *cut, int level)
{
	struct band *band = &cut->bands[level];
	assert(band->filled == cut->world->cells + 1);
	for (uint32_t x = 0; x < band->tiles_x; x++) {
		enum status status = emit_tile(cut, level, x);
		if (status != STATUS_OK)
			return status;
	}
	if (level < cut->coarsest) {
		enum status status = decimate_band(cut, level);
		if (status != STATUS_OK)
			return status;
	}
	memcpy(band->codes, band->codes + (int64_t)cut->world->cells * band->width,
	       (size_t)band->width * sizeof *band->codes);
	band->filled = 1;
	band->tile_y++;
	for (uint32_t x = 0; band->under != NULL && x < band->tiles_x; x++)
		band->under[x] = (struct under){(double)NAN, (double)NAN, 0};
	return STATUS_OK;
}

/* What is north of the terrain, up to the coarsest tile's north edge. */
static enum status finish_bands(struct cut *cut)
{
	for (int level = 0; level <= cut->coarsest; level++) {
		struct band *band = &cut->bands[level];
		while (band->tile_y < band->tiles_y) {
			uint32_t left = cut->world->cells + 1 - band->filled;
			codes_clear(band->codes + (int64_t)band->filled * band->width, left * band->width);
			band->filled += left;
			enum status status = band_full(cut, level);
			if (status != STATUS_OK)
				return status;
		}
	}
	return STATUS_OK;
}

static enum status refuse_height(double height, double step, int64_t x, int64_t y)
{
	if (!isfinite(height))
		return fail_with(STATUS_INPUT, "post %lld, %lld: its height is infinite; name that value "
				 "with --nodata or repair the source", (long long)x, (long long)y);
	if (step == 0)
		return fail_with(STATUS_INPUT, "post %lld, %lld: its height %.17g is not exact in 32 bits, "
				 "which a lossless store keeps; give a --max-error above 0",
				 (long long)x, (long long)y, height);
	return fail_with(STATUS_INPUT, "post %lld, %lld: its height %.17g m is too far from zero for a step "
			 "of %g m; give a larger --max-error, or name that value with --nodata",
			 (long long)x, (long long)y, height, step);
}

static enum status take_row(struct cut *cut, const double *heights, int64_t y)
{
	struct band *band = &cut->bands[0];
	int32_t *codes = band->codes + (int64_t)band->filled * band->width;
	double low = cut->low, high = cut->high;
	for (int64_t x = 0; x < cut->world->width; x++) {
		if (!height_code_encode(heights[x], cut->step, &codes[x]))
			return refuse_height(heights[x], cut->step, x, y);
		if (codes[x] == HEIGHT_CODE_NODATA)
			continue;
		double metres = height_code_metres(codes[x], cut->step);
		low = metres < low ? metres : low;
		high = metres > high ? metres : high;
	}
	codes_clear(codes + cut->world->width, band->width - cut->world->width);
	cut->low = low;
	cut->high = high;
	band->filled++;
	return band->filled == cut->world->cells + 1 ? band_full(cut, 0) : STATUS_OK;
}

static void cut_finish(struct cut *cut)
{
	for (int level = 0; level <= cut->coarsest; level++) {
		mem_free(cut->bands[level].codes);
		mem_free(cut->bands[level].under);
	}
	mem_free(cut->codes);
}

static enum status cut_init(struct cut *cut)
{
	const struct world *world = cut->world;
	size_t posts = (size_t)world->cells + 1;
	cut->codes = mem_alloc(posts * posts, sizeof *cut->codes);
	if (cut->codes == NULL)
		return fail_memory("cutting tiles");
	for (int level = 0; level <= cut->coarsest; level++) {
		struct band *band = &cut->bands[level];
		band->tiles_x = world_tiles_x(world, level);
		band->tiles_y = world_tiles_y(world, level);
		band->width = (int64_t)band->tiles_x * world->cells + 1;
		band->codes = mem_alloc(posts * (size_t)band->width, sizeof *band->codes);
		if (level > 0)
			band->under = mem_alloc(band->tiles_x, sizeof *band->under);
		if (band->codes == NULL || (level > 0 && band->under == NULL))
			return fail_memory("cutting tiles");
		for (uint32_t x = 0; level > 0 && x < band->tiles_x; x++)
			band->under[x] = (struct under){(double)NAN, (double)NAN, 0};
	}
	return STATUS_OK;
}

enum status dem_cut(const struct world *world, double step, dem_rows_fn rows, void *rows_user,
		    dem_tile_fn emit, void *emit_user, dem_progress_fn progress, void *progress_user)
{
	const char *problem = world_problem(world);
	if (problem != NULL)
		return fail_with(STATUS_INPUT, "terrain of %lld x %lld posts: %s; import another size",
				 (long long)world->width, (long long)world->height, problem);
	struct cut cut = {
		.world = world,
		.step = step,
		.emit = emit,
		.emit_user = emit_user,
		.coarsest = world_coarsest(world),
		.low = (double)INFINITY,
		.high = -(double)INFINITY,
	};
	int64_t strip = STRIP_POSTS / world->width;
	strip = strip < 1 ? 1 : strip > world->cells ? world->cells : strip;
	double *heights = mem_alloc((size_t)strip * (size_t)world->width, sizeof *heights);
	enum status status = heights != NULL ? cut_init(&cut) : fail_memory("cutting tiles");
	for (int64_t y = 0; status == STATUS_OK && y < world->height; y += strip) {
		int64_t count = world->height - y < strip ? world->height - y : strip;
		status = rows(rows_user, y, count, heights);
		for (int64_t row = 0; status == STATUS_OK && row < count; row++)
			status = take_row(&cut, heights + row * world->width, y + row);
		if (status == STATUS_OK && progress != NULL)
			status = progress(progress_user, y + count, world->height);
	}
	if (status == STATUS_OK)
		status = finish_bands(&cut);
	cut_finish(&cut);
	mem_free(heights);
	return status;
}
