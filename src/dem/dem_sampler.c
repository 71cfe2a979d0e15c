/*
 * Samples a raster at the posts of a lattice, by blocks. A block is small, so that little of the raster lies below it even where
 * it lies slanted. Where too much of the raster lies below a block, the block is halved.
 */
#include "dem_gdal.h"

#include "base/wide.h"

#define BLOCK_ROWS 64
#define SAME_SPAN 1.01 /* a mean of so few posts of the raster is one post */
#define PART_POSTS (1 << 22) /* most posts of the raster in memory for one block, unless it is a single post */

struct dem_sampler {
	struct dem_layers *layers; /* the raster; not owned */
	int64_t width, height;     /* of the raster, posts */
	struct dem_map *map;
	struct dem_kernel kernel;
	bool single;
	bool shifted; /* the posts are posts of the raster, off by `shift` columns and rows */
	int64_t shift[2];
	double *columns, *rows; /* of the posts of a block, on the raster */
	double *part;
	size_t room; /* posts of `part` */
};

void dem_sampler_destroy(struct dem_sampler *sampler)
{
	if (sampler == NULL)
		return;
	dem_map_destroy(sampler->map);
	mem_free_all(sampler->columns, sampler->rows, sampler->part, sampler);
}

enum status dem_sampler_create(const struct dem_sampling *sampling, struct dem_sampler **out)
{
	struct dem_sampler *sampler = mem_calloc(1, sizeof *sampler);
	TRY_MEM(sampler, sampling->name);
	sampler->layers = sampling->layers;
	sampler->width = sampling->raster->width;
	sampler->height = sampling->raster->height;
	sampler->single = sampling->single;
	sampler->kernel = (struct dem_kernel){sampling->method, {sampling->span[0], sampling->span[1]}};
	size_t posts = (size_t)DEM_BLOCK_SIDE * BLOCK_ROWS;
	sampler->columns = mem_alloc(posts, sizeof *sampler->columns);
	sampler->rows = mem_alloc(posts, sizeof *sampler->rows);
	enum status status;
	TRY_OR(failed, sampler->columns != NULL && sampler->rows != NULL ? STATUS_OK : fail_memory(sampling->name));
	TRY_OR(failed, dem_map_create(sampling->posts, sampling->raster, sampling->name, &sampler->map));
	double shift[2];
	sampler->shifted = sampling->span[0] < SAME_SPAN && sampling->span[1] < SAME_SPAN && dem_map_shift(sampler->map, &shift[0], &shift[1]) &&
			   fabs(shift[0]) < 1e15 && fabs(shift[1]) < 1e15;
	for (int i = 0; sampler->shifted && i < 2; i++)
		sampler->shift[i] = (int64_t)shift[i];
	*out = sampler;
	return STATUS_OK;
failed:
	dem_sampler_destroy(sampler);
	return status;
}

bool dem_sampler_copies(const struct dem_sampler *sampler)
{
	return sampler->shifted;
}

void dem_sampler_place(const struct dem_sampler *sampler, int64_t x, int64_t y, double *column, double *row)
{
	dem_map_rect(sampler->map, (struct post_rect){x, y, x + 1, y + 1}, column, row);
}

bool dem_sampler_copied(const struct dem_sampler *sampler, struct post_rect rect, struct post_rect *from)
{
	int64_t dx = sampler->shift[0], dy = sampler->shift[1];
	*from = (struct post_rect){rect.x0 + dx, rect.y0 + dy, rect.x1 + dx, rect.y1 + dy};
	return sampler->shifted && from->x0 >= 0 && from->y0 >= 0 && from->x1 <= sampler->width && from->y1 <= sampler->height;
}

/* Reads the part of the raster in `rect`, which lies in it. */
static enum status read_part(struct dem_sampler *sampler, struct post_rect rect, bool *done)
{
	size_t posts = (size_t)((rect.x1 - rect.x0) * (rect.y1 - rect.y0));
	if (posts > sampler->room) {
		mem_free(sampler->part);
		sampler->part = mem_alloc(posts, sizeof *sampler->part);
		sampler->room = sampler->part != NULL ? posts : 0;
		TRY_MEM(sampler->part, "reading the sources");
	}
	return dem_layers_read(sampler->layers, rect, sampler->part, done);
}

static void put(struct dem_samples *samples, int64_t at, enum dem_sampled sampled, double height)
{
	if (sampled <= (enum dem_sampled)samples->sampled[at])
		return;
	samples->sampled[at] = (uint8_t)sampled;
	samples->heights[at] = height;
	if (samples->owners != NULL)
		samples->owners[at] = samples->owner;
}

/* The same for a run of posts. */
FURROW_WIDE static void put_heights(const double *heights, const uint8_t *sampled, int64_t count, double *to, uint8_t *known)
{
	for (int64_t i = 0; i < count; i++)
		to[i] = sampled[i] > known[i] ? heights[i] : to[i];
	for (int64_t i = 0; i < count; i++)
		known[i] = sampled[i] > known[i] ? sampled[i] : known[i];
}

static void put_run(struct dem_samples *samples, int64_t at, int64_t count, const double *heights, const uint8_t *sampled)
{
	for (int64_t i = 0; samples->owners != NULL && i < count; i++)
		samples->owners[at + i] = sampled[i] > samples->sampled[at + i] ? samples->owner : samples->owners[at + i];
	put_heights(heights, sampled, count, samples->heights + at, samples->sampled + at);
}

static int64_t index_of(const struct dem_samples *samples, int64_t x, int64_t y)
{
	return (y - samples->rect.y0) * (samples->rect.x1 - samples->rect.x0) + x - samples->rect.x0;
}

static enum status copy_block(struct dem_sampler *sampler, struct post_rect block, struct dem_samples *samples, bool *done)
{
	int64_t dx = sampler->shift[0], dy = sampler->shift[1];
	struct post_rect rect = {block.x0 + dx, block.y0 + dy, block.x1 + dx, block.y1 + dy};
	rect = post_rect_intersect(rect, (struct post_rect){0, 0, sampler->width, sampler->height});
	if (post_rect_empty(rect))
		return STATUS_OK;
	TRY(read_part(sampler, rect, done));
	const double *from = sampler->part;
	for (int64_t y = rect.y0; *done && y < rect.y1; y++)
		for (int64_t x = rect.x0; x < rect.x1; x++, from++)
			if (!isnan(*from))
				put(samples, index_of(samples, x - dx, y - dy), DEM_SAMPLED_WHOLE, *from);
	return STATUS_OK;
}

#define LANES 8 /* extremes of their own, so that the compiler makes vector code of them */

/* Widens low and high to the positions, ignoring NaN. */
FURROW_WIDE static void extremes(const double *positions, size_t count, double *low, double *high)
{
	double lows[LANES], highs[LANES];
	size_t whole = count - count % LANES;
	for (int k = 0; k < LANES; k++) {
		lows[k] = *low;
		highs[k] = *high;
	}
	for (size_t i = 0; i < whole; i += LANES)
		for (int k = 0; k < LANES; k++) {
			double at = positions[i + (size_t)k];
			lows[k] = at < lows[k] ? at : lows[k]; /* never for NaN */
			highs[k] = at > highs[k] ? at : highs[k];
		}
	for (size_t i = whole; i < count; i++) {
		lows[0] = positions[i] < lows[0] ? positions[i] : lows[0];
		highs[0] = positions[i] > highs[0] ? positions[i] : highs[0];
	}
	for (int k = 0; k < LANES; k++) {
		*low = lows[k] < *low ? lows[k] : *low;
		*high = highs[k] > *high ? highs[k] : *high;
	}
}

/* Gives the part of the raster that a block needs; the block's positions are computed. It is empty if the block lies beside it. */
static struct post_rect part_below(const struct dem_sampler *sampler, size_t posts)
{
	double low[2] = {(double)INFINITY, (double)INFINITY}, high[2] = {-(double)INFINITY, -(double)INFINITY};
	extremes(sampler->columns, posts, &low[0], &high[0]);
	extremes(sampler->rows, posts, &low[1], &high[1]);
	int64_t size[2] = {sampler->width, sampler->height}, from[2], to[2];
	for (int i = 0; i < 2; i++) {
		double reach = (double)dem_kernel_reach(&sampler->kernel, i), most = (double)size[i];
		if (!(high[i] >= -0.5) || !(low[i] <= most - 0.5))
			return (struct post_rect){0, 0, 0, 0};
		from[i] = (int64_t)fmax(0, floor(low[i]) - reach);
		to[i] = (int64_t)fmin(most, floor(high[i]) + reach + 1);
	}
	return (struct post_rect){from[0], from[1], to[0], to[1]};
}

static bool all_whole(const struct dem_samples *samples, struct post_rect block)
{
	for (int64_t y = block.y0; y < block.y1; y++)
		for (int64_t x = block.x0; x < block.x1; x++)
			if (samples->sampled[index_of(samples, x, y)] != DEM_SAMPLED_WHOLE)
				return false;
	return true;
}

static enum status sample_block(struct dem_sampler *sampler, struct post_rect block, struct dem_samples *samples, bool *done)
{
	if (all_whole(samples, block))
		return STATUS_OK;
	if (sampler->shifted)
		return copy_block(sampler, block, samples, done);
	int64_t width = block.x1 - block.x0, rows = block.y1 - block.y0;
	dem_map_rect(sampler->map, block, sampler->columns, sampler->rows);
	struct post_rect rect = part_below(sampler, (size_t)(width * rows));
	if (post_rect_empty(rect))
		return STATUS_OK;
	if ((rect.x1 - rect.x0) * (rect.y1 - rect.y0) > PART_POSTS && width * rows > 1) {
		struct post_rect first = block, second = block;
		if (width >= rows)
			first.x1 = second.x0 = block.x0 + width / 2;
		else
			first.y1 = second.y0 = block.y0 + rows / 2;
		TRY(sample_block(sampler, first, samples, done));
		return *done ? sample_block(sampler, second, samples, done) : STATUS_OK;
	}
	TRY(read_part(sampler, rect, done));
	if (!*done)
		return STATUS_OK;
	const struct dem_part part = {sampler->part, rect};
	const double *columns = sampler->columns, *of_rows = sampler->rows;
	for (int64_t y = block.y0; y < block.y1; y++, columns += width, of_rows += width) {
		double heights[DEM_BLOCK_SIDE];
		uint8_t sampled[DEM_BLOCK_SIDE];
		dem_kernel_run(&sampler->kernel, &part, width, columns, of_rows, heights, sampled);
		for (int64_t x = 0; sampler->single && x < width; x++)
			heights[x] = (double)(float)heights[x];
		put_run(samples, index_of(samples, block.x0, y), width, heights, sampled);
	}
	return STATUS_OK;
}

static int64_t next_multiple(int64_t value, int64_t step, int64_t most)
{
	int64_t next = (value / step + 1) * step;
	return next < most ? next : most;
}

enum status dem_sampler_read(struct dem_sampler *sampler, struct dem_samples *samples, struct post_rect part, bool *done)
{
	*done = true;
	for (int64_t y = part.y0; y < part.y1; y = next_multiple(y, BLOCK_ROWS, part.y1))
		for (int64_t x = part.x0; x < part.x1 && *done; x = next_multiple(x, DEM_BLOCK_SIDE, part.x1)) {
			struct post_rect block = {x, y, next_multiple(x, DEM_BLOCK_SIDE, part.x1), next_multiple(y, BLOCK_ROWS, part.y1)};
			TRY(sample_block(sampler, block, samples, done));
		}
	return STATUS_OK;
}
