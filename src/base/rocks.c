#include "base/rocks.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "base/lattice.h"
#include "base/memory.h"
#include "base/mix.h"

#define PLACE_BITS 13 /* places within a cell, and diameters, are counted in 2^-13 of its edge */
#define EDGE (1 << PLACE_BITS)
#define HALF (EDGE / 2)
#define SCALE_BITS 26
#define FULL 32768 /* of a height: all of it */
#define STEPS 4096 /* of an integral */

/* Outlines: A x^2 + 2 B x y + C y^2 = 15 r^2, with A C - B^2 = 225. So each has the area of a circle. The ratio of the axes is 1, 1.3 or
 * 1.7. */
static const int outlines[16][3] = {
	{15, 0, 15}, {13, 3, 18}, {18, 3, 13}, {13, -3, 18}, {18, -3, 13}, {25, 0, 9}, {9, 0, 25}, {17, 8, 17},
	{17, -8, 17}, {13, 3, 18}, {18, 3, 13}, {13, -3, 18}, {18, -3, 13}, {15, 0, 15}, {17, 8, 17}, {17, -8, 17},
};
/* Directions that facets face, of length 64 at most. */
static const int directions[16][2] = {
	{64, 0}, {59, 24}, {45, 45}, {24, 59}, {0, 64}, {-24, 59}, {-45, 45}, {-59, 24}, {-64, 0}, {-59, -24}, {-45, -45}, {-24, -59}, {0, -64}, {24, -59}, {45, -45}, {59, -24},
};

/* --- the law --- */

static double decay_of(const struct rocks_spec *spec)
{
	return 1.79 + 0.152 / spec->k;
}

double rocks_cover(const struct rocks_spec *spec, double diameter)
{
	const double q = decay_of(spec), from = fmax(diameter, spec->smallest);
	return spec->cover > 0 && from < spec->largest ? spec->cover * (exp(-q * from) - exp(-q * spec->largest)) : 0;
}

/* Returns the sum of the rocks' own areas on a square metre, of rocks of at least this diameter. */
static double areas(const struct rocks_spec *spec, double diameter)
{
	return -log1p(-rocks_cover(spec, diameter));
}

/* Returns how many rocks there are on a square metre whose diameter is between two near ones. */
static double number_between(const struct rocks_spec *spec, double low, double high)
{
	return (areas(spec, low) - areas(spec, high)) / (M_PI / 4 * (low * low + low * high + high * high) / 3);
}

double rocks_density(const struct rocks_spec *spec)
{
	const double ratio = pow(spec->largest / spec->smallest, 1.0 / STEPS);
	double sum = 0, low = spec->smallest;
	for (int i = 0; i < STEPS && spec->cover > 0; i++, low *= ratio)
		sum += number_between(spec, low, low * ratio);
	return sum;
}

/* --- making --- */

/* Fills the diameters of an octave, so that equally many rocks lie between each and the next. */
static void fill_knots(const struct rocks_spec *spec, double low, double high, double edge, struct rocks_octave *octave)
{
	double sums[STEPS + 1] = {0};
	for (int i = 0; i < STEPS; i++)
		sums[i + 1] = sums[i] + number_between(spec, low + (high - low) * i / STEPS, low + (high - low) * (i + 1) / STEPS);
	for (int knot = 0, i = 0; knot <= ROCKS_KNOTS; knot++) {
		const double sum = sums[STEPS] * knot / ROCKS_KNOTS;
		while (i + 1 < STEPS && sums[i + 1] < sum)
			i++;
		const double part = fmin(fmax((sum - sums[i]) / (sums[i + 1] - sums[i]), 0), 1);
		octave->knots[knot] = (uint32_t)lround((low + (high - low) * (i + part) / STEPS) / edge * EDGE);
	}
}

/* Fills the chances of numbers of rocks (Poisson). */
static void fill_counts(double mean, struct rocks_octave *octave)
{
	double chance = exp(-mean), sum = 0;
	for (int i = 0; i < ROCKS_COUNTS; i++) {
		sum += chance;
		chance *= mean / (i + 1);
		octave->counts[i] = i == ROCKS_COUNTS - 1 ? UINT32_MAX : (uint32_t)fmin(ldexp(sum, 32), UINT32_MAX);
	}
}

static void make_octave(const struct rocks_spec *spec, double low, double high, double spacing, int edge, struct rocks_octave *octave)
{
	const double metres = ldexp(spacing, edge);
	*octave = (struct rocks_octave){
		.key = mix_bits(mix_bits(spec->seed) + (uint32_t)(edge + 64)),
		.edge = edge,
		.scale = (uint32_t)lround(ldexp(metres, SCALE_BITS - PLACE_BITS)),
	};
	fill_knots(spec, low, high, metres, octave);
	double square = 0;
	for (int i = 0; i < ROCKS_KNOTS; i++) {
		const double a = octave->knots[i], b = octave->knots[i + 1];
		square += (a * a + a * b + b * b) / 3 / ROCKS_KNOTS;
	}
	fill_counts((areas(spec, low) - areas(spec, high)) * ldexp(1, 2 * PLACE_BITS) / (M_PI / 4 * square), octave);
}

void rocks_make(const struct rocks_spec *spec, double spacing, struct rocks *rocks)
{
	*rocks = (struct rocks){.spacing = spacing};
	if (!(spec->cover > 0))
		return;
	assert(rocks_good(spec));
	int edge = (int)ceil(log2(spec->largest / 0.75 / spacing));
	for (double high = spec->largest; high > spec->smallest && rocks->count < ROCKS_OCTAVES; edge--) {
		const double low = fmax(ldexp(0.375 * spacing, edge), spec->smallest);
		if (low < high)
			make_octave(spec, low, high, spacing, edge, &rocks->octaves[rocks->count++]);
		high = fmin(low, high);
	}
	rocks->highest = spec->largest * ROCKS_HEIGHT_MOST;
}

bool rocks_any(const struct rocks *rocks)
{
	return rocks != NULL && rocks->count > 0;
}

double rocks_bound(const struct rocks *rocks)
{
	return rocks_any(rocks) ? rocks->highest * (1 + 1e-3) + ldexp(1, -BASE_BITS) : 0;
}

/* The sides are as steep as 4 heights in a radius, and a cell's triangles are off by at most half its edge along them. */
double rocks_error(const struct rocks *rocks, int level)
{
	return rocks_any(rocks) && level > rocks->finest ? fmin(rocks_bound(rocks), 2 * ldexp(rocks->spacing, level)) : 0;
}

/* --- one rock --- */

struct made {
	int x, y;         /* its middle within the cell */
	int diameter;
	int height;       /* 2^-18 m */
	uint32_t shape, facets;
};

static uint32_t cell_hash(const struct rocks_octave *octave, uint32_t x, uint32_t y)
{
	return mix_bits(mix_bits(octave->key + x) + y);
}

static int count_of(const struct rocks_octave *octave, uint32_t hash)
{
	int count = 0;
	while (count < ROCKS_COUNTS - 1 && hash >= octave->counts[count])
		count++;
	return count;
}

static struct made make(const struct rocks_octave *octave, uint32_t hash, int index)
{
	const uint32_t a = mix_bits(hash ^ (uint32_t)(index + 1) * 0x9e3779b9u), b = mix_bits(a + 0x85ebca6bu);
	const uint32_t *knot = &octave->knots[b >> 26];
	const int diameter = (int)(knot[0] + (((knot[1] - knot[0]) * ((b >> 16) & 1023u) + 512) >> 10));
	return (struct made){
		.x = (int)(a & (EDGE - 1)),
		.y = (int)(a >> PLACE_BITS & (EDGE - 1)),
		.diameter = diameter,
		.height = (int)((((uint32_t)diameter * (24u + (b & 15u)) >> 6) * octave->scale) >> (SCALE_BITS - BASE_BITS)),
		.shape = a >> 26 & 15u,
		.facets = mix_bits(b + 0xc2b2ae35u),
	};
}

/* Returns how far a facet lets the rock rise at (x, y) from its middle, of FULL. */
static int facet_at(uint32_t facet, int x, int y, int diameter)
{
	const int *to = directions[facet & 15u];
	const int bias = 1 << 18, top = 24576 + (int)(facet >> 4 & 7u) * 1024, slope = 1 + (int)(facet >> 7 & 3u);
	const int along = (int)((uint32_t)(x * to[0] + y * to[1] + bias) * 1024u / (uint32_t)diameter) - (int)((uint32_t)bias * 1024u / (uint32_t)diameter);
	return top - (along * slope >> 3);
}

/* Returns a rock's height at (x, y) from its middle, in 2^-18 m; 0 beside it. */
static int height_at(const struct made *rock, int x, int y)
{
	if (x < -HALF || x > HALF || y < -HALF || y > HALF)
		return 0;
	const int *line = outlines[rock->shape];
	const uint32_t all = (uint32_t)rock->diameter * (uint32_t)rock->diameter * 15u / 4u;
	const uint32_t out = (uint32_t)(line[0] * x * x + 2 * line[1] * x * y + line[2] * y * y);
	if (out >= all)
		return 0;
	const int in = (int)(((all - out) >> 11 << 15) / (all >> 11));
	int part = in * (2 * FULL - in) >> 15;
	for (int i = 0; i < 3; i++) {
		const int cut = facet_at(rock->facets >> 9 * i, x, y, rock->diameter);
		part = cut < part ? cut : part;
	}
	return (int)((uint64_t)(uint32_t)rock->height * (uint32_t)part >> 15);
}

/* --- posts --- */

/* Returns where a post lies within a cell whose edge has 2^depth posts. depth <= 0: at its corner. */
static int place_of(int64_t post, int depth)
{
	if (depth <= 0)
		return 0;
	const int64_t rest = post & (((int64_t)1 << depth) - 1);
	return (int)(depth <= PLACE_BITS ? rest << (PLACE_BITS - depth) : rest >> (depth - PLACE_BITS));
}

static int64_t cell_of(int64_t post, int depth)
{
	return depth >= 0 ? post >> depth : post * ((int64_t)1 << -depth);
}

/* Raises the posts around one rock of cell (cx, cy). */
static void raise_around(const struct made *rock, int64_t cx, int64_t cy, int depth, struct post_rect rect, int32_t *heights)
{
	const int64_t width = rect.x1 - rect.x0, side = (int64_t)1 << depth;
	/* The ellipse reaches at most 0.65 diameters far. */
	const int64_t reach = (((int64_t)rock->diameter * 83 / 128) << depth >> PLACE_BITS) + 2;
	const int64_t x = cx * side + ((int64_t)rock->x << depth >> PLACE_BITS), y = cy * side + ((int64_t)rock->y << depth >> PLACE_BITS);
	const struct post_rect in = post_rect_intersect((struct post_rect){x - reach, y - reach, x + reach + 1, y + reach + 1}, rect);
	for (int64_t row = in.y0; row < in.y1; row++) {
		const int dy = place_of(row, depth) - rock->y + (int)(cell_of(row, depth) - cy) * EDGE;
		int32_t *out = heights + (row - rect.y0) * width - rect.x0;
		for (int64_t column = in.x0; column < in.x1; column++) {
			const int dx = place_of(column, depth) - rock->x + (int)(cell_of(column, depth) - cx) * EDGE;
			const int32_t height = height_at(rock, dx, dy);
			out[column] = height > out[column] ? height : out[column];
		}
	}
}

/* Where a cell has at least two posts along its edge: rock by rock. */
static void raise_by_rocks(const struct rocks_octave *octave, int depth, struct post_rect rect, int32_t *heights)
{
	for (int64_t cy = ((rect.y0) >> depth) - 1; cy <= ((rect.y1 - 1) >> depth) + 1; cy++)
		for (int64_t cx = ((rect.x0) >> depth) - 1; cx <= ((rect.x1 - 1) >> depth) + 1; cx++) {
			const uint32_t hash = cell_hash(octave, (uint32_t)cx, (uint32_t)cy);
			const int count = count_of(octave, hash);
			for (int i = 0; i < count; i++) {
				const struct made rock = make(octave, hash, i);
				raise_around(&rock, cx, cy, depth, rect, heights);
			}
		}
}

/* Returns the height at one post. */
static int32_t height_of_post(const struct rocks_octave *octave, int depth, int64_t x, int64_t y)
{
	const int64_t cx = cell_of(x, depth), cy = cell_of(y, depth);
	const int px = place_of(x, depth), py = place_of(y, depth), west = px < HALF ? -1 : 0, south = py < HALF ? -1 : 0;
	int32_t highest = 0;
	for (int k = 0; k < 4; k++) {
		const int across = west + (k & 1), up = south + (k >> 1);
		const uint32_t hash = cell_hash(octave, (uint32_t)(cx + across), (uint32_t)(cy + up));
		const int count = count_of(octave, hash);
		for (int i = 0; i < count; i++) {
			const struct made rock = make(octave, hash, i);
			const int32_t height = height_at(&rock, px - across * EDGE - rock.x, py - up * EDGE - rock.y);
			highest = height > highest ? height : highest;
		}
	}
	return highest;
}

static void raise_by_posts(const struct rocks_octave *octave, int depth, struct post_rect rect, int32_t *heights)
{
	for (int64_t y = rect.y0; y < rect.y1; y++)
		for (int64_t x = rect.x0; x < rect.x1; x++, heights++) {
			const int32_t height = height_of_post(octave, depth, x, y);
			*heights = height > *heights ? height : *heights;
		}
}

void rocks_heights(const struct rocks *rocks, int level, struct post_rect rect, int32_t *heights)
{
	assert(!post_rect_empty(rect));
	memset(heights, 0, (size_t)(rect.x1 - rect.x0) * (size_t)(rect.y1 - rect.y0) * sizeof *heights);
	for (int i = 0; rocks_any(rocks) && i < rocks->count; i++) {
		const struct rocks_octave *octave = &rocks->octaves[i];
		const int depth = octave->edge - level;
		const int64_t posts = (rect.x1 - rect.x0) * (rect.y1 - rect.y0);
		if (depth >= 1 && posts > 4)
			raise_by_rocks(octave, depth, rect, heights);
		else
			raise_by_posts(octave, depth, rect, heights);
	}
}

enum status rocks_add(const struct rocks *rocks, int level, struct post_rect rect, int32_t *posts)
{
	const size_t count = (size_t)(rect.x1 - rect.x0) * (size_t)(rect.y1 - rect.y0);
	int32_t *heights = NULL;
	if (!rocks_any(rocks))
		return STATUS_OK;
	TRY(mem_make(&heights, count, sizeof *heights, "rocks"));
	rocks_heights(rocks, level, rect, heights);
	for (size_t i = 0; i < count; i++)
		posts[i] += posts[i] != BASE_NODATA ? heights[i] : 0;
	mem_free(heights);
	return STATUS_OK;
}

/* --- the list --- */

static bool each_of_octave(const struct rocks_octave *octave, double edge, const double box[4], bool (*fn)(void *user, const struct rock *rock), void *user)
{
	for (int64_t cy = (int64_t)floor(box[1] / edge); (double)cy * edge < box[3]; cy++)
		for (int64_t cx = (int64_t)floor(box[0] / edge); (double)cx * edge < box[2]; cx++) {
			const uint32_t hash = cell_hash(octave, (uint32_t)cx, (uint32_t)cy);
			const int count = count_of(octave, hash);
			for (int i = 0; i < count; i++) {
				const struct made made = make(octave, hash, i);
				const struct rock rock = {
					((double)cx + ldexp(made.x, -PLACE_BITS)) * edge,
					((double)cy + ldexp(made.y, -PLACE_BITS)) * edge,
					ldexp(made.diameter, -PLACE_BITS) * edge,
					lattice_base_metres(made.height),
				};
				const bool inside = rock.x >= box[0] && rock.y >= box[1] && rock.x < box[2] && rock.y < box[3];
				if (inside && !fn(user, &rock))
					return false;
			}
		}
	return true;
}

void rocks_each(const struct rocks *rocks, double x0, double y0, double x1, double y1, bool (*fn)(void *user, const struct rock *rock),
		void *user)
{
	const double box[4] = {x0, y0, x1, y1};
	for (int i = 0; rocks_any(rocks) && i < rocks->count; i++)
		if (!each_of_octave(&rocks->octaves[i], ldexp(rocks->spacing, rocks->octaves[i].edge), box, fn, user))
			return;
}
