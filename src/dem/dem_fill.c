/*
 * Fills holes smoothly from their edges. Each hole gets the shape of a membrane, computed on a cascade of grids.
 *
 *     posts -> means of 2 x 2 -> ... -> one cell; then, from the coarsest down: holes start from the
 *     coarser grid's bilinear surface and are relaxed (each hole the mean of its neighbours)
 *
 * The grids are in a temporary file and are processed row by row. So memory grows only with the length of a row. A filled
 * height lies between the lowest and highest height around the hole. Posts with data are not changed.
 */
#include "dem_internal.h"

#include "dem_scratch.h"

#define LEVELS_MAX 32
#define PASSES 12 /* of relaxation a grid: half of them from the south, half from the north */

struct level {
	int64_t width, height, start; /* cells; first float in the file */
};

struct fill {
	struct dem_grid grid;
	struct dem_grid *source;
	struct dem_scratch scratch;
	int levels;
	struct level level[LEVELS_MAX];
	float *rows[3]; /* of level 0's width */
	uint8_t *known; /* one row: 1 where a cell has data */
};

/* Returns where a row of the `known` bytes of this grid is in the file. 1: the cell has data; 0: it was a hole. */
static int64_t known_offset(const struct fill *fill, int level, int64_t y)
{
	const struct level *top = &fill->level[fill->levels - 1], *at = &fill->level[level];
	int64_t floats = top->start + top->width * top->height;
	return floats * (int64_t)sizeof(float) + at->start + y * at->width;
}

static int64_t row_offset(const struct fill *fill, int level, int64_t y)
{
	const struct level *at = &fill->level[level];
	return (at->start + y * at->width) * (int64_t)sizeof(float);
}

static enum status row_move(const struct fill *fill, bool write, int level, int64_t y, float *row)
{
	return dem_scratch_move(&fill->scratch, write, row,
				(size_t)fill->level[level].width * sizeof *row, row_offset(fill, level, y));
}

static enum status known_move(const struct fill *fill, bool write, int level, int64_t y)
{
	return dem_scratch_move(&fill->scratch, write, fill->known, (size_t)fill->level[level].width,
				known_offset(fill, level, y));
}

static enum status put_row(struct fill *fill, int level, int64_t y, float *row)
{
	for (int64_t x = 0; x < fill->level[level].width; x++)
		fill->known[x] = !isnan(row[x]);
	TRY(row_move(fill, true, level, y, row));
	return known_move(fill, true, level, y);
}

static enum status load_posts(struct fill *fill, bool *any, bool *holes)
{
	double *heights = mem_alloc((size_t)fill->grid.width, sizeof *heights);
	TRY_MEM(heights, "filling holes");
	enum status status = STATUS_OK;
	for (int64_t y = 0; y < fill->grid.height; y++) {
		TRY_OR(done, fill->source->read(fill->source, (struct post_rect){0, y, fill->grid.width, y + 1}, heights));
		for (int64_t x = 0; x < fill->grid.width; x++) {
			fill->rows[0][x] = (float)heights[x];
			*any = *any || !isnan(heights[x]);
			*holes = *holes || isnan(heights[x]);
		}
		TRY_OR(done, put_row(fill, 0, y, fill->rows[0]));
	}
done:
	mem_free(heights);
	return status;
}

/* Cells of `level` are means of what is known of the four below. */
static enum status coarsen(struct fill *fill, int level)
{
	const struct level *fine = &fill->level[level - 1], *here = &fill->level[level];
	for (int64_t y = 0; y < here->height; y++) {
		int64_t count = 2 * y + 1 < fine->height ? 2 : 1;
		for (int64_t i = 0; i < count; i++)
			TRY(row_move(fill, false, level - 1, 2 * y + i, fill->rows[i]));
		for (int64_t x = 0; x < here->width; x++) {
			double sum = 0;
			int known = 0;
			for (int64_t i = 0; i < count; i++)
				for (int64_t j = 2 * x; j < fine->width && j < 2 * x + 2; j++)
					if (!isnan(fill->rows[i][j])) {
						sum += (double)fill->rows[i][j];
						known++;
					}
			fill->rows[2][x] = known > 0 ? (float)(sum / known) : NAN;
		}
		TRY(put_row(fill, level, y, fill->rows[2]));
	}
	return STATUS_OK;
}

/* Finds the coarse cells on both sides of a fine cell, clamped at the edges. */
static void between(int64_t fine, int64_t count, int64_t *low, int64_t *high, double *part)
{
	double at = ((double)fine - 0.5) / 2;
	*low = (int64_t)floor(at);
	*part = at - (double)*low;
	*high = *low + 1 < count ? *low + 1 : count - 1;
	*low = *low < 0 ? 0 : *low;
}

/* Holes of `level` from the grid above, which has none. */
static enum status refine(struct fill *fill, int level)
{
	const struct level *here = &fill->level[level], *above = &fill->level[level + 1];
	for (int64_t y = 0; y < here->height; y++) {
		int64_t low, high, west, east;
		double v, u;
		between(y, above->height, &low, &high, &v);
		TRY(row_move(fill, false, level, y, fill->rows[2]));
		TRY(row_move(fill, false, level + 1, low, fill->rows[0]));
		TRY(row_move(fill, false, level + 1, high, fill->rows[1]));
		for (int64_t x = 0; x < here->width; x++) {
			if (!isnan(fill->rows[2][x]))
				continue;
			between(x, above->width, &west, &east, &u);
			double south = (double)fill->rows[0][west] * (1 - u) + (double)fill->rows[0][east] * u;
			double north = (double)fill->rows[1][west] * (1 - u) + (double)fill->rows[1][east] * u;
			fill->rows[2][x] = (float)(south * (1 - v) + north * v);
		}
		TRY(row_move(fill, true, level, y, fill->rows[2]));
	}
	return STATUS_OK;
}

static void relax_row(float *row, const float *south, const float *north, const uint8_t *known,
		      int64_t width)
{
	for (int64_t x = 0; x < width; x++) {
		if (known[x])
			continue;
		double sum = 0;
		int count = 0;
		if (x > 0) {
			sum += (double)row[x - 1];
			count++;
		}
		if (x + 1 < width) {
			sum += (double)row[x + 1];
			count++;
		}
		if (south != NULL) {
			sum += (double)*(south + x);
			count++;
		}
		if (north != NULL) {
			sum += (double)*(north + x);
			count++;
		}
		if (count > 0)
			row[x] = (float)(sum / count);
	}
}

/* One pass: sets each hole to the mean of its neighbours, row by row. `from_north`: the order of the rows. */
static enum status relax(struct fill *fill, int level, bool from_north)
{
	const struct level *here = &fill->level[level];
	float *behind = fill->rows[0], *row = fill->rows[1], *ahead = fill->rows[2];
	int64_t step = from_north ? -1 : 1, y = from_north ? here->height - 1 : 0;
	TRY(row_move(fill, false, level, y, row));
	for (int64_t i = 0; i < here->height; i++, y += step) {
		bool first = i == 0, last = i + 1 == here->height;
		if (!last)
			TRY(row_move(fill, false, level, y + step, ahead));
		TRY(known_move(fill, false, level, y));
		if (memchr(fill->known, 0, (size_t)here->width) != NULL) {
			relax_row(row, first ? NULL : behind, last ? NULL : ahead, fill->known, here->width);
			TRY(row_move(fill, true, level, y, row));
		}
		float *spare = behind;
		behind = row;
		row = ahead;
		ahead = spare;
	}
	return STATUS_OK;
}

static enum status solve(struct fill *fill)
{
	bool any = false, holes = false;
	TRY(load_posts(fill, &any, &holes));
	if (!any)
		return fail_with(STATUS_INPUT, "filling holes: the sources hold no data at all; give others");
	for (int level = 1; holes && level < fill->levels; level++)
		TRY(coarsen(fill, level));
	for (int level = fill->levels - 2; holes && level >= 0; level--) {
		TRY(refine(fill, level));
		for (int pass = 0; pass < PASSES; pass++)
			TRY(relax(fill, level, pass % 2 != 0));
	}
	return STATUS_OK;
}

static enum status fill_read(struct dem_grid *grid, struct post_rect rect, double *heights)
{
	struct fill *fill = (struct fill *)grid;
	int64_t width = rect.x1 - rect.x0;
	TRY(fill->source->read(fill->source, rect, heights));
	for (int64_t y = rect.y0; y < rect.y1; y++, heights += width) {
		TRY(row_move(fill, false, 0, y, fill->rows[0]));
		for (int64_t x = 0; x < width; x++)
			if (isnan(heights[x]))
				heights[x] = (double)fill->rows[0][rect.x0 + x];
	}
	return STATUS_OK;
}

static enum status fill_misfit(struct dem_grid *grid, const struct dem_part *surface, const int64_t ends[2], struct misfit *misfit)
{
	struct fill *fill = (struct fill *)grid;
	return fill->source->misfit(fill->source, surface, ends, misfit);
}

static void fill_destroy(struct dem_grid *grid)
{
	struct fill *fill = (struct fill *)grid;
	dem_grid_destroy(fill->source);
	dem_scratch_close(&fill->scratch);
	for (int i = 0; i < 3; i++)
		mem_free(fill->rows[i]);
	mem_free_all(fill->known, fill);
}

enum status dem_fill_create(struct dem_grid *grid, struct dem_grid **out)
{
	struct fill *fill = mem_calloc(1, sizeof *fill);
	if (fill == NULL) {
		dem_grid_destroy(grid);
		return fail_memory("filling holes");
	}
	/* The result has the source's properties. It takes over the source's texts and frees them. */
	fill->grid = *grid;
	fill->grid.read = fill_read;
	fill->grid.destroy = fill_destroy;
	fill->grid.misfit = grid->misfit != NULL ? fill_misfit : NULL;
	grid->srs = grid->vertical = grid->projected = NULL;
	grid->files = grid->finer = (struct dem_list){0};
	grid->finer_sets = NULL;
	fill->source = grid;
	fill->scratch.file = -1;
	int64_t width = grid->width, height = grid->height, start = 0;
	for (;;) {
		fill->level[fill->levels++] = (struct level){width, height, start};
		start += width * height;
		if (width == 1 && height == 1)
			break;
		width = (width + 1) / 2;
		height = (height + 1) / 2;
	}
	enum status status;
	TRY_OR(failed, dem_scratch_open(&fill->scratch, "filling holes"));
	fill->known = mem_alloc((size_t)grid->width, 1);
	for (int i = 0; i < 3; i++) {
		fill->rows[i] = mem_alloc((size_t)grid->width, sizeof *fill->rows[i]);
		if (fill->rows[i] == NULL || fill->known == NULL)
			TRY_OR(failed, fail_memory("filling holes"));
	}
	TRY_OR(failed, solve(fill));
	*out = &fill->grid;
	return STATUS_OK;
failed:
	dem_grid_destroy(&fill->grid);
	return status;
}
