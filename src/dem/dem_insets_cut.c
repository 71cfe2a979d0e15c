/*
 * Cuts insets into tiles of all levels below 0, from the finest level up.
 *
 *   heights of a row of tiles -> posts of the insets of this level -> and over them every second post of the tiles below
 *
 * Invariants:
 *   1. A tile is emitted if it has at least one post of an inset. Others are HEIGHT_CODE_NODATA.
 *   2. A post that finer tiles have too is theirs, bit for bit, so each level is the decimation of the finer one.
 *   3. The first row of a row of tiles is the last row of the one before, so tiles agree on their edges.
 */
#include "dem_inset.h"

#include <math.h>
#include <string.h>

#include "dem_measure.h"

#define STRIP_POSTS (1 << 20) /* posts whose heights are computed at once, about */
#define UNKNOWN INT32_MAX     /* not a code of a height: those are at most 2147483000, or floats that are finite */

struct cutting {
	const struct dem_insets_cut *cut;
	const struct extent *extent;
	size_t side;
	int level;
	size_t depth;       /* insets of this level and coarser ones */
	uint32_t first, last; /* tile columns */
	int32_t *band;      /* side rows of a run of tiles */
	int32_t *edges[2];  /* the last row of codes of the row of tiles before, and of this one; UNKNOWN: not computed */
	int32_t *tile, *below; /* one tile each */
	double *heights;
};

/* --- a tile and those below it --- */

static bool may_cover(const struct dem_insets *insets, struct tile tile)
{
	const struct post_rect rect = tile_post_rect(&insets->extent, tile);
	for (size_t i = 0; i < insets->count; i++) {
		const struct inset *inset = &insets->list[i];
		const struct post_rect own = dem_inset_covered_rect(inset, inset->info.level);
		const int shift = tile.level - inset->info.level;
		if (shift >= 0 && !post_rect_empty(post_rect_intersect(
					  own, (struct post_rect){rect.x0 << shift, rect.y0 << shift, ((rect.x1 - 1) << shift) + 1,
								  ((rect.y1 - 1) << shift) + 1})))
			return true;
	}
	return false;
}

/* Lays every second post of the tiles below over `codes`. Widens the range and error by theirs. `below`: room for a tile. */
static enum status lay_below(const struct dem_insets_cut *cut, struct tile tile, int32_t *below, int32_t *codes, double *low, double *high,
			     double *error)
{
	const struct extent *extent = &cut->insets->extent;
	const size_t side = tile_posts(extent);
	for (unsigned i = 0; i < 4; i++) {
		const struct tile child = {tile.level - 1, 2 * tile.x + (i & 1), 2 * tile.y + (i >> 1)};
		double its_low, its_high, its_error;
		bool found = false;
		if (extent_has(extent, child) && may_cover(cut->insets, child))
			TRY(cut->get(cut->get_user, child, below, &its_low, &its_high, &its_error, &found));
		if (!found)
			continue;
		const size_t half = extent->cells / 2;
		int32_t *quarter = codes + (i >> 1) * half * side + (i & 1) * half;
		for (size_t y = 0; y <= half; y++)
			for (size_t x = 0; x <= half; x++) {
				int32_t *fine = &below[2 * y * side + 2 * x], *coarse = &quarter[y * side + x];
				if (*fine != HEIGHT_CODE_NODATA)
					*coarse = *fine;
				else
					*fine = *coarse; /* so that the loss beside the rim counts too */
			}
		*low = fmin(*low, its_low); /* fmin ignores NaN */
		*high = fmax(*high, its_high);
		*error = fmax(*error, its_error + dem_measure(below, extent->cells, cut->step).loss);
	}
	return STATUS_OK;
}

enum status dem_insets_finer(void *user, struct tile tile, int32_t *codes, double *low, double *high, double *error)
{
	const struct dem_insets_cut *cut = user;
	const size_t side = tile_posts(&cut->insets->extent);
	if (!may_cover(cut->insets, tile))
		return STATUS_OK;
	int32_t *below = mem_alloc(side * side, sizeof *below);
	TRY_MEM(below, "an inset");
	enum status status = lay_below(cut, tile, below, codes, low, high, error);
	mem_free(below);
	return status;
}

static enum status put_tile(struct cutting *cutting, struct tile tile)
{
	const struct dem_insets_cut *cut = cutting->cut;
	struct dem_tile out = {.tile = tile, .codes = cutting->tile, .low = (double)NAN, .high = (double)NAN};
	TRY(dem_inset_misfit(cut->insets, tile, cutting->tile, cut->step, &out.misfit, &out.source));
	TRY(lay_below(cut, tile, cutting->below, cutting->tile, &out.low, &out.high, &out.error));
	const struct dem_measure measure = dem_measure(cutting->tile, cutting->extent->cells, cut->step);
	if (isnan(measure.low))
		return STATUS_OK;
	out.low = fmin(out.low, measure.low);
	out.high = fmax(out.high, measure.high);
	return cut->emit(cut->emit_user, &out);
}

/* --- a run of tiles in a row --- */

static enum status refuse(const struct cutting *cutting, double height)
{
	return fail_with(STATUS_INPUT, "an inset at level %d: its height %.17g m cannot be stored with a step of %g m; give another "
			 "--max-error, or name that value with --nodata", cutting->level, height, cutting->cut->step);
}

static bool stored_here(const struct cutting *cutting, int64_t x, int64_t y)
{
	for (size_t i = cutting->depth; i-- > 0 && cutting->cut->insets->list[i].info.level == cutting->level;)
		if (dem_inset_covers(&cutting->cut->insets->list[i], cutting->level, x, y))
			return true;
	return false;
}

/* Computes one row of codes; x0 is the first post of the run. */
static enum status take_row(const struct cutting *cutting, int64_t x0, int64_t y, const double *heights, int64_t count, int32_t *codes)
{
	const double step = cutting->cut->step;
	for (int64_t i = 0; i < count; i++) {
		const double height = step == 0 ? (double)(float)heights[i] : heights[i];
		codes[i] = HEIGHT_CODE_NODATA;
		if (stored_here(cutting, x0 + i, y) && !height_code_encode(height, step, &codes[i]))
			return refuse(cutting, height);
	}
	return STATUS_OK;
}

/* Computes the codes of a run of tiles; `rect` are its posts. */
static enum status fill_band(struct cutting *cutting, struct post_rect rect)
{
	const struct extent *extent = cutting->extent;
	const int64_t width = rect.x1 - rect.x0, strip = STRIP_POSTS / width > 0 ? STRIP_POSTS / width : 1;
	const struct post_rect world = {0, 0, extent_posts(extent->width, cutting->level), extent_posts(extent->height, cutting->level)};
	const struct post_rect in = post_rect_intersect(rect, world);
	for (int64_t i = 0; i < width * (int64_t)cutting->side; i++)
		cutting->band[i] = HEIGHT_CODE_NODATA;
	if (cutting->depth == 0 || cutting->cut->insets->list[cutting->depth - 1].info.level != cutting->level)
		return STATUS_OK;
	for (int64_t y = in.y0; y < in.y1; y += strip) {
		const struct post_rect part = {in.x0, y, in.x1, y + strip < in.y1 ? y + strip : in.y1};
		TRY(dem_inset_heights(cutting->cut->insets, cutting->depth, cutting->level, part, cutting->heights));
		for (int64_t row = part.y0; row < part.y1; row++)
			TRY(take_row(cutting, in.x0, row, cutting->heights + (row - y) * (in.x1 - in.x0), in.x1 - in.x0,
				     cutting->band + (row - rect.y0) * width + in.x0 - rect.x0));
	}
	return STATUS_OK;
}

static enum status cut_run(struct cutting *cutting, uint32_t y, uint32_t first, uint32_t last)
{
	const int64_t cells = cutting->extent->cells;
	const struct post_rect rect = {first * cells, y * cells, (last + 1) * cells + 1, y * cells + cells + 1};
	const size_t width = (size_t)(rect.x1 - rect.x0), at = (size_t)(first - cutting->first) * (size_t)cells;
	TRY(fill_band(cutting, rect));
	for (size_t x = 0; x < width; x++)
		if (cutting->edges[0][at + x] != UNKNOWN)
			cutting->band[x] = cutting->edges[0][at + x];
	memcpy(cutting->edges[1] + at, cutting->band + (size_t)cells * width, width * sizeof *cutting->band);
	for (uint32_t x = first; x <= last; x++) {
		for (size_t row = 0; row < cutting->side; row++)
			memcpy(cutting->tile + row * cutting->side, cutting->band + row * width + (size_t)(x - first) * (size_t)cells,
			       cutting->side * sizeof *cutting->tile);
		TRY(put_tile(cutting, (struct tile){cutting->level, x, y}));
	}
	return STATUS_OK;
}

/* --- a level --- */

static void forget_edge(const struct cutting *cutting, int32_t *edge)
{
	const size_t count = (size_t)(cutting->last - cutting->first + 1) * cutting->extent->cells + 1;
	for (size_t i = 0; i < count; i++)
		edge[i] = UNKNOWN;
}

/* Cuts a row of tiles, in runs of those that an inset may have. */
static enum status cut_row(struct cutting *cutting, uint32_t y)
{
	for (uint32_t x = cutting->first; x <= cutting->last;) {
		uint32_t end = x;
		while (end <= cutting->last && may_cover(cutting->cut->insets, (struct tile){cutting->level, end, y}))
			end++;
		if (end > x)
			TRY(cut_run(cutting, y, x, end - 1));
		x = end + 1;
	}
	int32_t *before = cutting->edges[0];
	cutting->edges[0] = cutting->edges[1];
	cutting->edges[1] = before;
	forget_edge(cutting, before);
	return STATUS_OK;
}

static enum status make_room(struct cutting *cutting)
{
	const size_t columns = (size_t)(cutting->last - cutting->first + 1) * cutting->extent->cells + 1, posts = cutting->side * cutting->side;
	const size_t strip = STRIP_POSTS > columns ? STRIP_POSTS : columns;
	cutting->band = mem_alloc(cutting->side * columns, sizeof *cutting->band);
	cutting->edges[0] = mem_alloc(columns, sizeof *cutting->edges[0]);
	cutting->edges[1] = mem_alloc(columns, sizeof *cutting->edges[1]);
	cutting->tile = mem_alloc(posts, sizeof *cutting->tile);
	cutting->below = mem_alloc(posts, sizeof *cutting->below);
	cutting->heights = mem_alloc(strip, sizeof *cutting->heights);
	return cutting->band != NULL && cutting->edges[0] != NULL && cutting->edges[1] != NULL && cutting->tile != NULL &&
			       cutting->below != NULL && cutting->heights != NULL
		       ? STATUS_OK
		       : fail_memory("cutting insets");
}

static void free_room(struct cutting *cutting)
{
	mem_free_all(cutting->band, cutting->edges[0], cutting->edges[1], cutting->tile, cutting->below, cutting->heights);
}

static enum status cut_level(const struct dem_insets_cut *cut, int level)
{
	const struct dem_insets *insets = cut->insets;
	struct cutting cutting = {.cut = cut, .extent = &insets->extent, .side = tile_posts(&insets->extent), .level = level};
	struct post_rect all = {0, 0, 0, 0};
	struct tile first, last;
	for (size_t i = 0; i < insets->count; i++) {
		const struct inset *inset = &insets->list[i];
		cutting.depth += inset->info.level >= level;
		if (inset->info.level > level)
			continue;
		const struct post_rect rect = dem_inset_covered_rect(inset, inset->info.level);
		const int shift = level - inset->info.level;
		const struct post_rect own = {rect.x0 >> shift, rect.y0 >> shift, (rect.x1 >> shift) + 1, (rect.y1 >> shift) + 1};
		all = post_rect_joined(all, own);
	}
	if (!tile_range_of(&insets->extent, level, all, &first, &last))
		return STATUS_OK;
	cutting.first = first.x;
	cutting.last = last.x;
	enum status status;
	TRY_OR(done, make_room(&cutting));
	forget_edge(&cutting, cutting.edges[0]);
	forget_edge(&cutting, cutting.edges[1]);
	for (uint32_t y = first.y; y <= last.y; y++) {
		if (cut->progress != NULL)
			TRY_OR(done, cut->progress(cut->progress_user, 0, insets->extent.height));
		TRY_OR(done, cut_row(&cutting, y));
	}
done:
	free_room(&cutting);
	return status;
}

enum status dem_insets_cut(const struct dem_insets_cut *cut)
{
	int finest = 0;
	for (size_t i = 0; i < cut->insets->count; i++)
		finest = cut->insets->list[i].info.level < finest ? cut->insets->list[i].info.level : finest;
	for (int level = finest; level < 0; level++) {
		TRY(cut_level(cut, level));
		if (cut->settle != NULL)
			TRY(cut->settle(cut->get_user));
	}
	return STATUS_OK;
}
