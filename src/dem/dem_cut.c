/*
 * Cuts posts into tiles of every level, in one pass.
 *
 *   posts -> a band of rows -> tiles of level 0 -> every second post into the tile above -> ...
 *
 * The terrain is processed in panels from west to east, and each panel from south to north. So a band is never wider than
 * memory allows. Most terrains are one panel.
 *
 * A tile is open while it is put together from the tiles below it. If a tile is at most as wide as a panel, one row of its
 * level is open at once. If it is wider, one column is open: one of its tiles is in memory, and the others are in a temporary
 * file. That is because the height of a terrain has no limit.
 *
 * Invariants:
 *   1. A tile is emitted as soon as the last tile below it was. So it comes after all tiles that it covers, and the order
 *      depends only on the terrain's size.
 *   2. Posts beyond the terrain are nodata.
 *   3. The first row of a band is the last row of the band before.
 */
#include "dem/dem.h"

#include <assert.h>
#include <math.h>

#include "dem_measure.h"
#include "dem_scratch.h"

#define STRIP_POSTS (1 << 20) /* posts: about so many heights are requested at once, as doubles */
#define PANEL_POSTS (1 << 23) /* posts: the most in a band; open tiles need about as many again */

struct open {
	bool begun;
	int32_t *codes; /* the posts so far; the memory is used again for the next tile in this place */
	double low, high, error; /* metres, over all tiles below this one; low and high are NaN while there is no data */
};

struct cutting {
	const struct dem_cut *cut;
	const struct extent *extent;
	size_t posts;        /* in a tile */
	int coarsest;
	int panel_level;     /* a tile of this level is as wide as a panel */
	int64_t panel;       /* the panel being cut */
	int64_t x0, width;   /* the first post of the panel, and how many posts it is wide */
	int64_t stride;      /* posts in a row of the band */
	int32_t *band;       /* cells + 1 rows */
	uint32_t filled;     /* rows */
	uint32_t tile_y;     /* of the band */
	int32_t *tile;       /* a tile of the band, cut out to be emitted */
	struct misfit *misfits; /* of the band's tiles so far */
	double *heights;
	double *rounded; /* a row of them, rounded */
	int64_t strip;       /* rows that `heights` has room for */
	int64_t rows_done;   /* rows done so far, over all panels */
	struct open *open[TILE_LEVEL_MAX + 1]; /* open tiles by level; level 0 has none */
	/* For levels whose tiles are wider than a panel. `held`: the tile whose codes are in memory. `first`: where the codes of
	 * the level begin in the temporary file, in tiles. */
	struct open *held[TILE_LEVEL_MAX + 1];
	int64_t first[TILE_LEVEL_MAX + 1]; /* tiles */
	struct dem_scratch scratch;
};

static int64_t smaller(int64_t a, int64_t b)
{
	return a < b ? a : b;
}

static int64_t open_count(const struct cutting *cutting, int level)
{
	return level <= cutting->panel_level
		       ? smaller((int64_t)1 << (cutting->panel_level - level), extent_tiles_x(cutting->extent, level))
		       : extent_tiles_y(cutting->extent, level);
}

static struct open *open_at(const struct cutting *cutting, struct tile tile)
{
	int64_t at = tile.level <= cutting->panel_level
			     ? tile.x - (cutting->panel << (cutting->panel_level - tile.level))
			     : tile.y;
	return &cutting->open[tile.level][at];
}

static void codes_clear(int32_t *codes, int64_t count)
{
	for (int64_t i = 0; i < count; i++)
		codes[i] = HEIGHT_CODE_NODATA;
}

static enum status move_codes(struct cutting *cutting, int level, struct open *open, bool write)
{
	int64_t tile = cutting->first[level] + (open - cutting->open[level]);
	size_t bytes = cutting->posts * sizeof *open->codes;
	return dem_scratch_move(&cutting->scratch, write, open->codes, bytes, tile * (int64_t)bytes);
}

/* Makes room in memory for the codes of this tile, and reads them if there are any. If needed, the tile of this level that was in
 * memory before is written to the temporary file. */
static enum status hold(struct cutting *cutting, int level, struct open *open)
{
	struct open *before = cutting->held[level];
	if (level <= cutting->panel_level || before == open)
		return STATUS_OK;
	if (before != NULL && before->begun) {
		if (cutting->scratch.file < 0)
			TRY(dem_scratch_open(&cutting->scratch, "cutting tiles"));
		TRY(move_codes(cutting, level, before, true));
	}
	if (before != NULL) {
		open->codes = before->codes;
		before->codes = NULL;
	}
	cutting->held[level] = open;
	return open->begun ? move_codes(cutting, level, open, false) : STATUS_OK;
}

static enum status begin_tile(const struct cutting *cutting, struct open *open)
{
	if (open->codes == NULL)
		open->codes = mem_alloc(cutting->posts, sizeof *open->codes);
	TRY_MEM(open->codes, "cutting tiles");
	codes_clear(open->codes, (int64_t)cutting->posts);
	open->begun = true;
	open->low = open->high = (double)NAN;
	open->error = 0;
	return STATUS_OK;
}

static void widen(struct open *open, double low, double high, double error)
{
	open->error = error > open->error ? error : open->error;
	if (isnan(low))
		return;
	open->low = isnan(open->low) || low < open->low ? low : open->low;
	open->high = isnan(open->high) || high > open->high ? high : open->high;
}

/* Emits a tile, then adds every second post of it to the tile above. `loss`: the error that leaving out the other posts makes,
 * metres. If the tile above is complete now, it is emitted too. */
static enum status finish_tile(struct cutting *cutting, const struct dem_tile *tile, double loss)
{
	TRY(cutting->cut->emit(cutting->cut->emit_user, tile));
	if (tile->tile.level == cutting->coarsest)
		return STATUS_OK;
	struct tile at = tile->tile, above = tile_ancestor(at, at.level + 1);
	struct open *open = open_at(cutting, above);
	TRY(hold(cutting, above.level, open));
	if (!open->begun)
		TRY(begin_tile(cutting, open));
	const struct extent *extent = cutting->extent;
	lattice_decimate_i32(tile->codes, extent->cells, at.x & 1, at.y & 1, open->codes);
	widen(open, tile->low, tile->high, tile->error + loss);
	bool last = ((at.x & 1) != 0 || at.x + 1 == extent_tiles_x(extent, at.level)) &&
		    ((at.y & 1) != 0 || at.y + 1 == extent_tiles_y(extent, at.level));
	if (!last)
		return STATUS_OK;
	open->begun = false;
	struct dem_tile next = {.tile = above, .codes = open->codes, .low = open->low, .high = open->high, .error = open->error};
	loss = above.level < cutting->coarsest ? dem_measure(open->codes, extent->cells, cutting->cut->step).loss : 0;
	return finish_tile(cutting, &next, loss);
}

/* --- bands --- */

/* Copies the codes of tile number i of the band into `to`. */
static void band_tile(const struct cutting *cutting, int64_t i, int32_t *to)
{
	size_t side = tile_posts(cutting->extent);
	for (size_t y = 0; y < side; y++)
		memcpy(to + y * side, cutting->band + (int64_t)y * cutting->stride + i * cutting->extent->cells,
		       side * sizeof *to);
}

static int64_t band_tiles(const struct cutting *cutting)
{
	return (cutting->stride - 1) / cutting->extent->cells;
}

static struct tile band_tile_at(const struct cutting *cutting, int64_t i)
{
	return (struct tile){0, (uint32_t)(cutting->x0 / cutting->extent->cells + i), cutting->tile_y};
}

static enum status band_full(struct cutting *cutting)
{
	uint32_t cells = cutting->extent->cells;
	assert(cutting->filled == cells + 1);
	for (int64_t i = 0; i < band_tiles(cutting); i++) {
		const struct dem_cut *cut = cutting->cut;
		struct dem_tile tile = {
			.tile = band_tile_at(cutting, i), .codes = cutting->tile, .low = (double)NAN, .high = (double)NAN};
		band_tile(cutting, i, cutting->tile);
		tile.misfit = cutting->misfits[i];
		tile.source = tile.misfit;
		if (cut->measure != NULL) {
			tile.source = (struct misfit){0};
			TRY(cut->measure(cut->measure_user, &tile, &tile.source));
		}
		if (cut->finer != NULL)
			TRY(cut->finer(cut->finer_user, tile.tile, cutting->tile, &tile.low, &tile.high, &tile.error));
		struct dem_measure measure = dem_measure(cutting->tile, cells, cut->step);
		tile.low = fmin(tile.low, measure.low); /* fmin ignores NaN */
		tile.high = fmax(tile.high, measure.high);
		TRY(finish_tile(cutting, &tile, measure.loss));
	}
	memcpy(cutting->band, cutting->band + cells * cutting->stride,
	       (size_t)cutting->stride * sizeof *cutting->band);
	cutting->filled = 1;
	cutting->tile_y++;
	memset(cutting->misfits, 0, (size_t)band_tiles(cutting) * sizeof *cutting->misfits);
	return STATUS_OK;
}

static void compare_row(struct cutting *cutting, const double *heights, const int32_t *codes)
{
	int64_t cells = cutting->extent->cells, tiles = band_tiles(cutting);
	bool joins = cutting->x0 > 0; /* the first column was the last one of the panel before */
	for (int64_t i = 0; i < tiles; i++) {
		int64_t from = i * cells + (i > 0 || joins), to = smaller((i + 1) * cells + 1, cutting->width);
		if (to > from)
			dem_measure_misfit(heights + from, codes + from, to - from, cutting->cut->step, &cutting->misfits[i]);
	}
}

static enum status refuse_height(double height, double step, int64_t x, int64_t y)
{
	if (!isfinite(height))
		return fail_with(STATUS_INPUT, "post %lld, %lld: its height is infinite; name that value "
				 "with --nodata or repair the source", (long long)x, (long long)y);
	if (step == 0)
		return fail_with(STATUS_INPUT, "post %lld, %lld: its height %.17g is not exact in 32 bits, "
				 "which a lossless store keeps; give --max-error %s or more",
				 (long long)x, (long long)y, height, number_at_least(fmax(fabs(height) * 1e-7, 1e-7), 1).text);
	return fail_with(STATUS_INPUT, "post %lld, %lld: its height %.17g m is too far from zero for a step "
			 "of %g m; give a larger --max-error, or name that value with --nodata",
			 (long long)x, (long long)y, height, step);
}

static enum status take_row(struct cutting *cutting, const double *heights, int64_t y)
{
	int32_t *codes = cutting->band + (int64_t)cutting->filled * cutting->stride;
	const double *kept = cutting->cut->rounded > 0 ? cutting->rounded : heights, to = cutting->cut->rounded;
	for (int64_t x = 0; to > 0 && x < cutting->width; x++)
		cutting->rounded[x] = nearbyint(heights[x] / to) * to;
	int64_t coded = height_code_row(kept, cutting->width, cutting->cut->step, codes);
	if (coded < cutting->width)
		return refuse_height(kept[coded], cutting->cut->step, cutting->x0 + coded, y);
	codes_clear(codes + cutting->width, cutting->stride - cutting->width);
	compare_row(cutting, heights, codes);
	cutting->filled++;
	return cutting->filled == cutting->extent->cells + 1 ? band_full(cutting) : STATUS_OK;
}

/* Fills the band with codes that an earlier, interrupted import has stored already. *known: true if it did; otherwise the band is
 * not usable unless it is filled from posts. */
static enum status take_known(struct cutting *cutting, bool *known)
{
	const struct dem_cut *cut = cutting->cut;
	size_t side = tile_posts(cutting->extent);
	int64_t tiles = band_tiles(cutting);
	*known = false;
	if (cut->known == NULL)
		return STATUS_OK;
	/* Tiles are stored in the order in which they are emitted. So if the last tile of the band is known, all are. */
	for (int64_t i = tiles - 1; i >= 0; i--) {
		TRY(cut->known(cut->known_user, band_tile_at(cutting, i), cutting->tile, known));
		if (!*known)
			return STATUS_OK;
		for (size_t y = 0; y < side; y++)
			memcpy(cutting->band + (int64_t)y * cutting->stride + i * cutting->extent->cells,
			       cutting->tile + y * side, side * sizeof *cutting->tile);
	}
	cutting->filled = cutting->extent->cells + 1;
	return STATUS_OK;
}

/* --- panels --- */

static enum status progress(struct cutting *cutting, int64_t rows, int64_t panels)
{
	const struct dem_cut *cut = cutting->cut;
	cutting->rows_done += rows;
	return cut->progress == NULL ? STATUS_OK
				     : cut->progress(cut->progress_user, cutting->rows_done,
						     cutting->extent->height * panels);
}

static enum status take_strip(struct cutting *cutting, int64_t y, int64_t rows)
{
	const struct dem_cut *cut = cutting->cut;
	struct post_rect rect = {cutting->x0, y, cutting->x0 + cutting->width, y + rows};
	TRY(cut->posts(cut->posts_user, rect, cutting->heights));
	for (int64_t row = 0; row < rows; row++)
		TRY(take_row(cutting, cutting->heights + row * cutting->width, y + row));
	return STATUS_OK;
}

static enum status cut_panel(struct cutting *cutting, int64_t panels)
{
	const struct extent *extent = cutting->extent;
	int64_t cells = extent->cells, y = 0;
	cutting->filled = 0;
	cutting->tile_y = 0;
	while (y < extent->height) {
		bool known = false;
		int64_t band_end = smaller(cutting->tile_y * cells + cells + 1, extent->height);
		if (cutting->filled == (cutting->tile_y > 0)) /* a new band begins */
			TRY(take_known(cutting, &known));
		int64_t rows = known ? band_end - y : smaller(band_end - y, cutting->strip);
		TRY(known ? band_full(cutting) : take_strip(cutting, y, rows));
		y += rows;
		TRY(progress(cutting, rows, panels));
	}
	/* Fill the last band with nodata, from the terrain's north edge to the north edge of the last tiles. */
	while (cutting->tile_y < extent_tiles_y(extent, 0)) {
		int64_t left = cells + 1 - cutting->filled;
		codes_clear(cutting->band + (int64_t)cutting->filled * cutting->stride, left * cutting->stride);
		cutting->filled += (uint32_t)left;
		TRY(band_full(cutting));
	}
	return STATUS_OK;
}

static enum status cutting_init(struct cutting *cutting)
{
	const struct extent *extent = cutting->extent;
	int64_t most = PANEL_POSTS / extent->cells, asked = cutting->cut->panel_posts;
	most = asked > 0 && asked < most ? asked : most;
	cutting->posts = (size_t)tile_posts(extent) * tile_posts(extent);
	cutting->coarsest = extent_coarsest(extent);
	while (cutting->panel_level < cutting->coarsest &&
	       (int64_t)extent->cells << (cutting->panel_level + 1) <= most)
		cutting->panel_level++;
	int64_t tiles = smaller((int64_t)1 << cutting->panel_level, extent_tiles_x(extent, 0));
	cutting->stride = tiles * extent->cells + 1;
	cutting->strip = STRIP_POSTS / smaller(cutting->stride, extent->width);
	cutting->strip = cutting->strip < 1 ? 1 : smaller(cutting->strip, extent->cells);
	cutting->heights = mem_alloc((size_t)(cutting->strip * cutting->stride), sizeof *cutting->heights);
	cutting->band = mem_alloc((size_t)(tile_posts(extent) * cutting->stride), sizeof *cutting->band);
	cutting->tile = mem_alloc(cutting->posts, sizeof *cutting->tile);
	cutting->misfits = mem_calloc((size_t)tiles, sizeof *cutting->misfits);
	cutting->rounded = mem_alloc((size_t)cutting->stride, sizeof *cutting->rounded);
	bool whole = cutting->rounded != NULL && cutting->misfits != NULL && cutting->heights != NULL && cutting->band != NULL && cutting->tile != NULL;
	for (int level = 1; level <= cutting->coarsest; level++) {
		cutting->open[level] = mem_calloc((size_t)open_count(cutting, level), sizeof *cutting->open[level]);
		whole = whole && cutting->open[level] != NULL;
		cutting->first[level] = level == 1 ? 0 : cutting->first[level - 1] + open_count(cutting, level - 1);
	}
	return whole ? STATUS_OK : fail_memory("cutting tiles");
}

static void cutting_finish(struct cutting *cutting)
{
	for (int level = 1; level <= cutting->coarsest; level++) {
		for (int64_t i = 0; cutting->open[level] != NULL && i < open_count(cutting, level); i++)
			mem_free(cutting->open[level][i].codes);
		mem_free(cutting->open[level]);
	}
	dem_scratch_close(&cutting->scratch);
	mem_free_all(cutting->heights, cutting->rounded, cutting->band, cutting->tile, cutting->misfits);
}

enum status dem_cut(const struct dem_cut *cut)
{
	const struct extent *extent = cut->extent;
	const char *problem = extent_problem(extent);
	if (problem != NULL)
		return fail_with(STATUS_INPUT, "terrain of %lld x %lld posts: %s; import another size",
				 (long long)extent->width, (long long)extent->height, problem);
	struct cutting cutting = {.cut = cut, .extent = extent, .scratch = {.file = -1}};
	enum status status;
	TRY_OR(done, cutting_init(&cutting));
	int64_t span = (int64_t)extent->cells << cutting.panel_level, tiles_x = extent_tiles_x(extent, 0);
	int64_t panels = (tiles_x * extent->cells + span - 1) / span;
	for (int64_t panel = 0; panel < panels; panel++) {
		cutting.panel = panel;
		cutting.x0 = panel * span;
		cutting.width = smaller(span + 1, extent->width - cutting.x0);
		cutting.stride = smaller(span, tiles_x * extent->cells - cutting.x0) + 1;
		TRY_OR(done, cut_panel(&cutting, panels));
	}
done:
	cutting_finish(&cutting);
	return status;
}
