#include "base/relief.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "base/lattice.h"
#include "base/memory.h"
#include "base/mix.h"

#define UNIT_BITS 24                     /* heights are summed in 2^-24 m */
#define FINER (UNIT_BITS - BASE_BITS)
/* The variance of an area is 2/9 of that of a level's midpoints, and all levels together have twice that of the first. So the midpoints of
 * the first level have 1.5 times the roughness. */
#define FIRST 1.5

/* --- random numbers --- */

/* Returns the random numbers of two edges of the coarser level: to the east of a post (low 16 bits), and to its north. */
static uint32_t edges_of(uint32_t key, uint32_t x, uint32_t y)
{
	return mix_bits(mix_bits(key + x) + y);
}

/* Returns half the height of an edge's midpoint. `number`: 16 bits. */
static int32_t half_height(uint32_t number, int32_t amplitude)
{
	return (int32_t)(((int64_t)(2 * (int32_t)number - 65535) * amplitude) >> 16);
}

/* --- making --- */

static int32_t amplitude_of(double rms)
{
	/* Twice (2 n - 65535) / 65536 is uniform between -2 and 2: its root mean square is 2 / sqrt(3). */
	return (int32_t)lround(ldexp(rms * sqrt(3) / 2, UNIT_BITS));
}

void relief_make(const struct relief_spec *spec, double spacing, int finest, struct relief *relief)
{
	assert(finest >= TILE_LEVEL_MIN && spec->classes <= RELIEF_CLASSES);
	*relief = (struct relief){.coarsest = finest - 1, .finest = finest, .classes = spec->classes};
	for (int level = -1; level >= finest; level--) {
		const int band = -1 - level;
		relief->keys[band] = mix_bits(mix_bits(spec->seed) + (uint32_t)band);
		for (int i = 0; i < spec->classes; i++) {
			const struct relief_waves *waves = &spec->waves[i];
			double step = ldexp(spacing, level), first = step;
			if (waves->roughness <= 0 || step > waves->wavelength / 2)
				continue;
			while (2 * first <= waves->wavelength / 2) /* perhaps a level that the source has */
				first *= 2;
			relief->amplitudes[i][band] = amplitude_of(FIRST * waves->roughness * sqrt(step / first));
			if (relief->amplitudes[i][band] > 0 && relief->coarsest < level)
				relief->coarsest = level;
		}
	}
}

bool relief_any(const struct relief *relief)
{
	return relief != NULL && relief->classes > 0 && relief->coarsest >= relief->finest;
}

bool relief_has_level(const struct relief *relief, int level)
{
	return relief_any(relief) && level <= relief->coarsest;
}

/* Returns the amplitude of the roughest class. */
static int32_t most_of(const struct relief *relief, int band)
{
	int32_t most = 0;
	for (int i = 0; i < relief->classes; i++)
		most = relief->amplitudes[i][band] > most ? relief->amplitudes[i][band] : most;
	return most;
}

double relief_bound(const struct relief *relief, int from)
{
	double sum = 0;
	if (!relief_any(relief))
		return 0;
	for (int level = relief->coarsest; level >= relief->finest; level--)
		if (level < from)
			sum += 4.0 * most_of(relief, -1 - level); /* of a middle: half of four midpoints, each at most twice the amplitude */
	return sum > 0 ? ldexp(sum, -UNIT_BITS) + ldexp(1, -BASE_BITS) : 0;
}

double relief_rms(const struct relief *relief, int from)
{
	double sum = 0;
	if (!relief_any(relief))
		return 0;
	for (int level = relief->coarsest; level >= relief->finest; level--)
		if (level < from) {
			double rms = ldexp(most_of(relief, -1 - level), -UNIT_BITS) * 2 / sqrt(3);
			sum += rms * rms * 2 / 9;
		}
	return sqrt(sum);
}

/* The midpoints of a band have the variance s^2. Along an edge of a cell neighbouring posts of the band differ by a midpoint: s^2. Along
 * the cell's middle they differ by -(3 a + b + c + d) / 2: 3 s^2. At t from edge to middle the difference is interpolated between both,
 * and has (1 - 3 t + 5 t^2) s^2. Posts of the finest level divide that way into `parts`. Their mean is 7/6 + 5 / (6 parts^2). */
double relief_slope(const struct relief *relief, int class, double spacing)
{
	double sum = 0;
	if (!relief_any(relief))
		return 0;
	for (int level = relief->coarsest; level >= relief->finest; level--) {
		const double parts = ldexp(1, level - relief->finest);
		const double slope = ldexp(relief->amplitudes[class][-1 - level], -UNIT_BITS) * 2 / sqrt(3) / ldexp(spacing, level);
		sum += slope * slope * (7 / 6.0 + 5 / (6 * parts * parts));
	}
	return sqrt(sum);
}

/* --- heights --- */

/* One level's detail of a rectangle. A cell is one of the coarser level; its side is `side` posts of the rectangle's level. */
struct band {
	uint32_t key;
	int depth;                    /* a cell has 2 << depth posts along a side */
	int shift;                   /* to bring all bands to one denominator */
	int64_t first_x, first_y;    /* column and row of the south-western cell, counted from the south-west of the terrain */
	int64_t cells_x;             /* how many cells there are, from west to east */
	const int32_t (*amplitudes)[RELIEF_BANDS];
	int index;
	const uint8_t *classes;      /* of the posts of the band's level, from the first cell's first post; NULL: class 0 everywhere */
};

/* Returns the amplitude at post (x, y) of the band's level. */
static int32_t amplitude_at(const struct band *band, int64_t x, int64_t y)
{
	if (band->classes == NULL)
		return band->amplitudes[0][band->index];
	const int64_t stride = 2 * band->cells_x + 1;
	return band->amplitudes[band->classes[(y - 2 * band->first_y) * stride + x - 2 * band->first_x]][band->index];
}

static int32_t east_of(const struct band *band, int64_t x, int64_t y)
{
	return half_height(edges_of(band->key, (uint32_t)x, (uint32_t)y) & 0xffff, amplitude_at(band, 2 * x + 1, 2 * y));
}

static int32_t north_of(const struct band *band, int64_t x, int64_t y)
{
	return half_height(edges_of(band->key, (uint32_t)x, (uint32_t)y) >> 16, amplitude_at(band, 2 * x, 2 * y + 1));
}

/* Adds the detail of posts x0 .. x1 - 1 of row y to the sums. */
static void add_row(const struct band *band, int64_t x0, int64_t x1, int64_t y, int64_t *sums)
{
	const int64_t q = (int64_t)1 << band->depth, side = 2 * q;
	const int64_t cy = y >> (band->depth + 1), v = y & (side - 1), b = v < q ? v : side - v;
	for (int64_t cx = x0 >> (band->depth + 1); cx * side < x1; cx++) {
		const int64_t south = east_of(band, cx, cy), north = east_of(band, cx, cy + 1);
		const int64_t west = north_of(band, cx, cy), east = north_of(band, cx + 1, cy);
		const int64_t middle = -(south + north + west + east) * b, near = 2 * (v < q ? south : north) * (q - b);
		const int64_t first = cx * side > x0 ? cx * side : x0, end = (cx + 1) * side < x1 ? (cx + 1) * side : x1;
		for (int64_t x = first; x < end; x++) {
			const int64_t u = x - cx * side, a = u < q ? u : side - u;
			sums[x - x0] += (a * (middle + near) + (q - a) * b * 2 * (u < q ? west : east)) * ((int64_t)1 << band->shift);
		}
	}
}

enum { PIECE = 256 }; /* posts that are summed at once */

static void fill_rows(const struct band *bands, int count, int deepest, struct post_rect rect, int32_t *heights)
{
	const int down = 2 * deepest + FINER;
	int64_t sums[PIECE];
	for (int64_t y = rect.y0; y < rect.y1; y++)
		for (int64_t x = rect.x0; x < rect.x1; x += PIECE) {
			const int64_t end = x + PIECE < rect.x1 ? x + PIECE : rect.x1;
			memset(sums, 0, sizeof sums);
			for (int i = 0; i < count; i++)
				add_row(&bands[i], x, end, y, sums);
			int32_t *out = heights + (y - rect.y0) * (rect.x1 - rect.x0) + (x - rect.x0);
			for (int64_t k = 0; k < end - x; k++)
				out[k] = (int32_t)((sums[k] + ((int64_t)1 << (down - 1))) >> down);
		}
}

/* Finds the bands, and how many bytes the classes of all of them take. */
static int find_bands(const struct relief *relief, int level, int from, struct post_rect rect, struct band bands[RELIEF_BANDS], size_t *bytes)
{
	const int coarsest = relief->coarsest < from - 1 ? relief->coarsest : from - 1;
	int count = 0;
	*bytes = 0;
	for (int at = coarsest; at >= level && at >= relief->finest; at--, count++) {
		const int depth = at - level;
		struct band *band = &bands[count];
		*band = (struct band){
			.key = relief->keys[-1 - at],
			.depth = depth,
			.shift = 2 * (coarsest - at),
			.first_x = rect.x0 >> ((depth + 1)),
			.first_y = rect.y0 >> ((depth + 1)),
			.amplitudes = relief->amplitudes,
			.index = -1 - at,
		};
		const int64_t cells_y = ((rect.y1 - 1) >> ((depth + 1))) - band->first_y + 1;
		band->cells_x = ((rect.x1 - 1) >> ((depth + 1))) - band->first_x + 1;
		*bytes += (size_t)(2 * band->cells_x + 1) * (size_t)(2 * cells_y + 1);
	}
	return count;
}

/* Reads the classes of all bands, one after the other. */
static enum status read_classes(const struct relief *relief, int level, struct post_rect rect, struct band *bands, int count, uint8_t *classes)
{
	for (int i = 0; i < count; i++) {
		struct band *band = &bands[i];
		const int64_t cells_y = ((rect.y1 - 1) >> (band->depth + 1)) - band->first_y + 1;
		const struct post_rect posts = {2 * band->first_x, 2 * band->first_y, 2 * (band->first_x + band->cells_x) + 1,
						2 * (band->first_y + cells_y) + 1};
		band->classes = classes;
		TRY(relief->map->read(relief->map->user, level + band->depth, posts, classes));
		for (int64_t k = 0; k < (posts.x1 - posts.x0) * (posts.y1 - posts.y0); k++)
			assert(classes[k] < relief->classes);
		classes += (posts.x1 - posts.x0) * (posts.y1 - posts.y0);
	}
	return STATUS_OK;
}

enum status relief_heights(const struct relief *relief, int level, int from, struct post_rect rect, int32_t *heights)
{
	struct band bands[RELIEF_BANDS];
	size_t bytes = 0;
	assert(!post_rect_empty(rect) && rect.x0 >= 0 && rect.y0 >= 0);
	const int count = relief_any(relief) ? find_bands(relief, level, from, rect, bands, &bytes) : 0;
	if (count == 0) {
		memset(heights, 0, (size_t)(rect.x1 - rect.x0) * (size_t)(rect.y1 - rect.y0) * sizeof *heights);
		return STATUS_OK;
	}
	uint8_t *classes = NULL;
	enum status status = STATUS_OK;
	if (relief->classes > 1) {
		TRY(mem_make(&classes, bytes, 1, "relief"));
		TRY_OR(done, read_classes(relief, level, rect, bands, count, classes));
	}
	fill_rows(bands, count, bands[0].depth, rect, heights);
done:
	mem_free(classes);
	return status;
}

int relief_parts(const struct relief *relief, int level, int from, int64_t x, int64_t y, struct relief_part parts[RELIEF_BANDS], int *down)
{
	struct band bands[RELIEF_BANDS];
	size_t bytes;
	const int count = relief_any(relief) ? find_bands(relief, level, from, (struct post_rect){x, y, x + 1, y + 1}, bands, &bytes) : 0;
	*down = count > 0 ? 2 * bands[0].depth + FINER : FINER;
	for (int i = 0; i < count; i++) {
		const struct band *band = &bands[i];
		const int64_t part = ((int64_t)2 << band->depth) - 1;
		parts[i] = (struct relief_part){
			.key = band->key,
			.amplitude = relief->amplitudes[0][band->index],
			.depth = band->depth,
			.cell = {(uint32_t)band->first_x, (uint32_t)band->first_y},
			.rest = {(uint32_t)(x & part), (uint32_t)(y & part)},
		};
	}
	return count;
}
