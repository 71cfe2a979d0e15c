/*
 * One mesh tile of a globe: 65 x 65 heights as whole numbers.
 *
 * A tile's heights are 15-bit numbers between its least and its greatest height. So that tiles have the same heights on the edge
 * that they share, heights are multiples of a power of two, the tile's unit. On an edge they are multiples of the larger unit of its
 * tiles, in a corner of the largest of its four.
 *
 *  1. A tile's unit follows from its own samples alone, so that every order of work gives the same bytes.
 *  2. The unit leaves SPARE numbers. It is at most so many times finer than any tile's. So heights that are rounded to a neighbour's unit
 *     still fit.
 *  3. Where the terrain has no height, a sample has that of the cover (cover.c). Near the terrain it is fitted to the nearest sample that has
 *     a height. That too depends on samples, not on tiles.
 *  4. Units are at least 2^-10 m. Up to 16 km such heights are exact in the header's floats.
 */
#include "exchange/internal.h"

#define BORDER (EXCHANGE_SIDE + 2)
#define UNIT_LEAST (-10)
#define SPARE_BITS 11
#define SPARE (1 << SPARE_BITS)
#define SPAN_MOST (32767 - SPARE) /* of the 15 bits */
#define REACH 16 /* samples over which the cover is fitted to the terrain */
#define WIDE (BORDER + 2 * REACH)

struct exchange_steps {
	struct mutex mutex;
	struct key_map map;
};

enum status exchange_steps_create(struct exchange_steps **out)
{
	struct exchange_steps *steps = mem_calloc(1, sizeof *steps);
	*out = steps;
	TRY_MEM(steps, "heights of tiles");
	mutex_init(&steps->mutex);
	return STATUS_OK;
}

void exchange_steps_destroy(struct exchange_steps *steps)
{
	if (steps == NULL)
		return;
	key_map_finish(&steps->map);
	mutex_finish(&steps->mutex);
	mem_free(steps);
}

bool exchange_steps_find(struct exchange_steps *steps, uint64_t key, int *exponent)
{
	mutex_lock(&steps->mutex);
	const struct key_pair *pair = key_map_find(&steps->map, key);
	if (pair != NULL)
		*exponent = (int)pair->a;
	mutex_unlock(&steps->mutex);
	return pair != NULL;
}

enum status exchange_steps_put(struct exchange_steps *steps, uint64_t key, int exponent)
{
	mutex_lock(&steps->mutex);
	enum status status = key_map_put(&steps->map, key, exponent, 0);
	mutex_unlock(&steps->mutex);
	return status;
}

/* Returns the cover's height at sample `at` of those that were placed, which is sample (i, j) of the zoom level. */
static double covered(const struct exchange_maker *maker, size_t at, int64_t i, int64_t j)
{
	const struct exchange_sampler *sampler = &maker->sampler;
	const double spacing = extent_spacing(sampler->extent, sampler->zoom->level);
	double x = sampler->x[at] * spacing, y = sampler->y[at] * spacing;
	if (!isnan(x) && !isnan(y))
		return exchange_cover_at(maker->cover, x, y);
	exchange_place_degrees(&sampler->frame, sampler->zoom, (double)i, (double)j, &x, &y);
	return exchange_cover_degrees(maker->cover, &sampler->frame, x, y);
}

/* Finds the nearest sample within REACH that has a height. Returns false if there is none. *away: samples to it. */
static bool find_nearest(const double *heights, size_t at, size_t *nearest, double *away)
{
	int least = REACH * REACH + 1;
	for (int dy = -REACH; dy <= REACH; dy++)
		for (int dx = -REACH; dx <= REACH; dx++) {
			const size_t there = (size_t)((int64_t)at + dy * WIDE + dx);
			if (dx * dx + dy * dy >= least || isnan(heights[there]))
				continue;
			least = dx * dx + dy * dy;
			*nearest = there;
		}
	*away = sqrt(least);
	return least <= REACH * REACH;
}

/* Gives the samples of a tile that have no height one; the first sample placed is (i0, j0). `wide` has WIDE x WIDE. */
static void fill_holes(struct exchange_maker *maker, const double *wide, int64_t i0, int64_t j0)
{
	for (size_t y = 0; y < BORDER; y++)
		for (size_t x = 0; x < BORDER; x++) {
			const size_t at = (y + REACH) * WIDE + x + REACH;
			size_t nearest = 0;
			double height = wide[at], away;
			if (isnan(height)) {
				height = covered(maker, at, i0 + (int64_t)(x + REACH), j0 + (int64_t)(y + REACH));
				if (find_nearest(wide, at, &nearest, &away)) /* it has a position, so it needs no number */
					height += (wide[nearest] - covered(maker, nearest, 0, 0)) * (1 - away / (REACH + 1));
			}
			maker->heights[y * BORDER + x] = height;
		}
}

/* Reads the heights of a tile with one more sample on each side. Rows from the south. Where there is no terrain they are the cover's. */
static enum status read_heights(struct exchange_maker *maker, const struct exchange_zoom *zoom, int64_t x, int64_t y)
{
	const int64_t i0 = x * EXCHANGE_CELLS - 1, j0 = y * EXCHANGE_CELLS - 1;
	double *wide = maker->slopes; /* free until slopes are taken */
	bool holes = false;
	TRY(exchange_sampler_place(&maker->sampler, zoom, i0, j0, BORDER, BORDER));
	TRY(exchange_sampler_read(&maker->sampler, STORE_SURFACE, maker->heights));
	for (size_t k = 0; k < (size_t)BORDER * BORDER; k++)
		holes = holes || isnan(maker->heights[k]);
	if (!holes)
		return STATUS_OK;
	TRY(exchange_sampler_place(&maker->sampler, zoom, i0 - REACH, j0 - REACH, WIDE, WIDE));
	TRY(exchange_sampler_read(&maker->sampler, STORE_SURFACE, wide));
	fill_holes(maker, wide, i0 - REACH, j0 - REACH);
	return STATUS_OK;
}

/* The height of a tile's own sample. */
static double height_at(const struct exchange_maker *maker, size_t i, size_t j)
{
	return maker->heights[(j + 1) * BORDER + i + 1];
}

/* The least exponent of a unit whose numbers hold heights that differ by `span`. */
static int exponent_of(double span)
{
	int exponent = UNIT_LEAST;
	while (ldexp(SPAN_MOST - 1, exponent) < span)
		exponent++;
	return exponent;
}

/* The exponent of the tile whose heights were read. */
static int own_exponent(const struct exchange_maker *maker)
{
	double low = INFINITY, high = -INFINITY;
	for (size_t j = 0; j < EXCHANGE_SIDE; j++)
		for (size_t i = 0; i < EXCHANGE_SIDE; i++) {
			low = fmin(low, height_at(maker, i, j));
			high = fmax(high, height_at(maker, i, j));
		}
	/* No tile spans more than this: the cover may go a little beyond the heights of the base, and a drive below them. */
	const struct store_meta *meta = maker->sampler.frame.meta;
	const int coarsest = exponent_of(2 * (meta->high - meta->low) + 8192), own = exponent_of(high - low);
	return own > coarsest - SPARE_BITS ? own : coarsest - SPARE_BITS;
}

/* Finds the exponents of the 3 x 3 tiles around one; those that are not there have the least. Leaves the heights of the middle one. */
static enum status find_exponents(struct exchange_maker *maker, const struct exchange_zoom *zoom, struct tile tile, int exponents[3][3])
{
	bool middle = false; /* its heights are in the maker */
	for (int k = 0; k < 9; k++) {
		int64_t x = (int64_t)tile.x + (k + 4) % 9 % 3 - 1, y = (int64_t)tile.y + (k + 4) % 9 / 3 - 1;
		int *exponent = &exponents[(k + 4) % 9 / 3][(k + 4) % 9 % 3];
		*exponent = UNIT_LEAST;
		if (!exchange_zoom_has(zoom, x, y) || exchange_steps_find(maker->steps, exchange_zoom_key(zoom, x, y), exponent))
			continue;
		TRY(read_heights(maker, zoom, x, y));
		middle = k == 0;
		*exponent = own_exponent(maker);
		TRY(exchange_steps_put(maker->steps, exchange_zoom_key(zoom, x, y), *exponent));
	}
	return middle ? STATUS_OK : read_heights(maker, zoom, tile.x, tile.y);
}

/* The exponent of a sample: the greatest of the tiles that share it. */
static int exponent_at(int exponents[3][3], size_t i, size_t j)
{
	int greatest = UNIT_LEAST;
	for (int dy = j == 0 ? 0 : 1; dy <= (j == EXCHANGE_CELLS ? 2 : 1); dy++)
		for (int dx = i == 0 ? 0 : 1; dx <= (i == EXCHANGE_CELLS ? 2 : 1); dx++)
			greatest = exponents[dy][dx] > greatest ? exponents[dy][dx] : greatest;
	return greatest;
}

static void fill_heights(const struct exchange_maker *maker, int exponents[3][3], struct exchange_quantized *out)
{
	double low = INFINITY, *values = maker->slopes; /* free until slopes are taken */
	int own = exponents[1][1];
	for (size_t j = 0; j < EXCHANGE_SIDE; j++)
		for (size_t i = 0; i < EXCHANGE_SIDE; i++) {
			int exponent = exponent_at(exponents, i, j);
			double value = ldexp(nearbyint(ldexp(height_at(maker, i, j), -exponent)), exponent);
			values[j * EXCHANGE_SIDE + i] = value;
			low = fmin(low, value);
		}
	out->unit = ldexp(1, own);
	out->minimum = low;
	for (size_t k = 0; k < (size_t)EXCHANGE_SIDE * EXCHANGE_SIDE; k++) {
		double number = ldexp(values[k] - low, -own);
		assert(number >= 0 && number <= 32767 && number == floor(number));
		out->heights[k] = (uint16_t)number;
	}
}

enum status exchange_mesh_tile(struct exchange_maker *maker, const struct exchange_zoom *zoom, struct tile tile)
{
	struct exchange_quantized *mesh = maker->mesh;
	const struct exchange_frame *frame = &maker->sampler.frame;
	int exponents[3][3];
	TRY(find_exponents(maker, zoom, tile, exponents));
	fill_heights(maker, exponents, mesh);
	double *east = maker->slopes, *north = maker->slopes + (size_t)EXCHANGE_SIDE * EXCHANGE_SIDE, j0 = (double)tile.y * EXCHANGE_CELLS;
	chart_slopes(maker->heights, EXCHANGE_SIDE, EXCHANGE_SIDE, 1, east, north);
	for (size_t j = 0; j < EXCHANGE_SIDE; j++) {
		double step_east, step_north;
		exchange_place_steps(frame, zoom, j0 + (double)j, &step_east, &step_north);
		for (size_t i = 0; i < EXCHANGE_SIDE; i++) {
			size_t at = j * EXCHANGE_SIDE + i;
			/* At a pole samples lie upon each other, and no slope goes east. */
			mesh->slopes[at][0] = (float)(isnan(east[at]) || step_east < 1e-6 ? 0 : east[at] / step_east);
			mesh->slopes[at][1] = (float)(isnan(north[at]) ? 0 : north[at] / step_north);
		}
	}
	for (int k = 0; k < 2; k++) {
		double degree = ldexp(180, -zoom->z);
		mesh->bounds[2 * k] = ((double)tile.x + k) * degree - 180;
		mesh->bounds[2 * k + 1] = ((double)tile.y + k) * degree - 90;
	}
	maker->bytes.size = 0;
	TRY(exchange_quantized_write(mesh, frame, &maker->bytes));
	return exchange_maker_put(maker, EXCHANGE_MESH, tile);
}
