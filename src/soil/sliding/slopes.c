/*
 * Finds how high slopes are. A cohesive soil is stable up to Culmann's height. This is the height of a whole slope, not of the step
 * between two posts. Over blocks each post finds how far its slope rises above it and falls below it: its extents.
 *
 * A slope is followed by hops of 8, 4, 2 and 1 posts in eight directions. Each hop leads to a post that is higher (or lower) by
 * more than the angle of friction gives. The first hop goes on with the extents that the interval before left in the plane `slope`.
 * So each interval follows a slope by 8 to 15 posts more, and in the end over its whole height, at any spacing. Extents of a post depend on
 * posts that are higher or lower alone. So they come to rest where heights are at rest. The height of a post's slope gives the critical
 * difference there.
 *
 * The plane keeps extents of posts beside which soil could slide. There a neighbour differs by more than the least critical difference. If undisturbed
 * ground is stable it also differs by more than the bases do. Other posts keep 0. So a change never spreads over undisturbed ground.
 *
 * Rows are computed only in the spans of columns that are near such posts.
 */

#include <string.h>

#include "soil/sliding/sliding.h"

#define ALIGN 64

static const int ways[8][2] = {{0, -1}, {-1, 0}, {1, 0}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}}; /* four axial, four diagonal */

/* Posts of the planes' rectangle, with its width. */
struct slopes {
	const struct sliding_field *field;
	int32_t *surfaces;    /* 4 base + offset; SLIDING_STILL: no data */
	uint32_t *extents[2]; /* 2^-9 m: how far the slope rises above the post (low 16 bits) and falls below it; in turn by hop */
	size_t width, height, left, below; /* of the planes; where the field begins */
	struct sliding_span *steep;        /* of each row of the field: columns in which a neighbour is steep, or extents are kept */
	int32_t least[2];                  /* no smaller difference slides in any slope */
};

static size_t rounded(size_t bytes)
{
	return (bytes + ALIGN - 1) / ALIGN * ALIGN;
}

size_t soil_sliding_slopes_bytes(const struct soil_sliding *rule, const struct soil_planes *planes)
{
	size_t width = (size_t)(planes->rect.x1 - planes->rect.x0), height = (size_t)(planes->rect.y1 - planes->rect.y0);
	return rule->reach > 0 ? 3 * rounded(width * height * sizeof(int32_t)) + rounded(height * sizeof(struct sliding_span)) : 0;
}

/* Returns the columns of a row that a hop must compute, counted from the planes' first column. They are at most `near` posts from a steep
 * post, and lie within the field and `after` posts around it. */
static struct sliding_span span_at(const struct slopes *slopes, size_t row, int64_t after, int64_t near)
{
	const struct sliding_field *field = slopes->field;
	int64_t first = INT32_MAX, end = 0, y = (int64_t)row - (int64_t)slopes->below, left = (int64_t)slopes->left;
	int64_t low = y - near > 0 ? y - near : 0, high = y + near < (int64_t)field->height ? y + near + 1 : (int64_t)field->height;
	for (int64_t i = low; i < high; i++) {
		first = slopes->steep[i].first < first ? slopes->steep[i].first : first;
		end = slopes->steep[i].end > end ? slopes->steep[i].end : end;
	}
	if (first >= end)
		return (struct sliding_span){0, 0};
	first = first - near > -after ? first - near : -after;
	end = end + near < (int64_t)field->width + after ? end + near : (int64_t)field->width + after;
	return (struct sliding_span){(int32_t)(left + first), (int32_t)(left + end)};
}

/* Parameters of a hop over a row. */
struct hop {
	const int32_t *surfaces;
	const uint32_t *extents;
	const uint8_t *classes; /* NULL: one soil */
	int32_t rises[SOIL_CLASSES][2];
	ptrdiff_t way, stride;
	bool first; /* extents are those of the interval before: they count at the hop's end alone */
};

SOIL_INLINED uint32_t least_of(uint32_t a, uint32_t b)
{
	return a < b ? a : b;
}

SOIL_INLINED void hop(const struct hop *hop, size_t first, size_t end, uint32_t *restrict to, bool classes, bool begins)
{
	const int32_t *restrict surfaces = hop->surfaces;
	const uint32_t *restrict extents = hop->extents;
	const uint8_t *restrict class = hop->classes;
	SOIL_APART
	for (ptrdiff_t x = (ptrdiff_t)first; x < (ptrdiff_t)end; x++) {
		int32_t surface = surfaces[x], up = begins ? 0 : (int32_t)(extents[x] & 0xffffu), down = begins ? 0 : (int32_t)(extents[x] >> 16);
		int soil = classes ? class[x] < SOIL_CLASSES ? class[x] : SOIL_CLASSES - 1 : 0;
		int32_t axial = hop->rises[soil][0], diagonal = hop->rises[soil][1];
#pragma GCC unroll 8
		for (int k = 0; k < 8; k++) {
			ptrdiff_t at = x + hop->way * (ways[k][0] + ways[k][1] * hop->stride);
			int32_t other = surfaces[at], difference = (int32_t)((uint32_t)other - (uint32_t)surface), sign = difference >> 31;
			int32_t high = (int32_t)(((uint32_t)difference ^ (uint32_t)sign) - (uint32_t)sign), least = k < 4 ? axial : diagonal;
			int32_t by = high >> 11, on_up = (int32_t)(extents[at] & 0xffffu) + by, on_down = (int32_t)(extents[at] >> 16) + by;
			int32_t open = (int32_t)(surface != SLIDING_STILL) & (int32_t)(other != SLIDING_STILL) & (int32_t)(high > least);
			int32_t rises = open & (int32_t)(sign == 0) & (int32_t)(on_up > up), falls = open & (int32_t)(sign != 0) & (int32_t)(on_down > down);
			up = rises != 0 ? on_up : up;
			down = falls != 0 ? on_down : down;
		}
		to[x] = least_of((uint32_t)up, 0xffffu) | least_of((uint32_t)down, 0xffffu) << 16;
	}
}

SOIL_LANES static void hop_row(const struct hop *by, size_t first, size_t end, uint32_t *to)
{
	if (by->classes != NULL)
		hop(by, first, end, to, true, by->first);
	else if (by->first)
		hop(by, first, end, to, false, true);
	else
		hop(by, first, end, to, false, false);
}

SOIL_LANES static void surface_row(const int32_t *restrict base, const int32_t *restrict offset, size_t count, int32_t *restrict to)
{
	SOIL_APART
	for (size_t x = 0; x < count; x++)
		to[x] = base[x] == BASE_NODATA ? SLIDING_STILL : (int32_t)((uint32_t)base[x] * 4u + (uint32_t)offset[x]);
}

/* Returns the axial critical difference in a slope, fixed-point units. height: of the slope, 2^-9 m. The cotangent is interpolated
 * between the two nearest known heights. */
static int32_t in_slope(const struct soil_sliding *rule, const struct soil_sliding_class *class, int32_t height)
{
	height = height < 16 ? 16 : height > 0x1ffff ? 0x1ffff : height;
	int octave = 31 - __builtin_clz((unsigned)height), digits = height << (17 - octave);
	int i = (octave - 4) * 8 + ((digits >> 14) & 7), low = class->slope[i];
	int32_t cotangent = low + ((class->slope[i + 1] - low) * ((digits >> 6) & 255) >> 8);
	if (cotangent <= 0)
		return 1 << 30;
	return rule->apart / cotangent < 1 << 30 ? rule->apart / cotangent : 1 << 30;
}

/* Returns the posts over which the hops after this one go. */
static int64_t after(int number)
{
	return soil_sliding_way(number) - 1;
}

static void run_hop(const struct slopes *slopes, int number)
{
	const struct soil_sliding *rule = slopes->field->rule;
	const struct soil_planes *planes = slopes->field->planes;
	/* In an iteration the posts beside those that slid may become steep. */
	const int64_t later = after(number), near = later + rule->iterations + 1;
	struct hop by = {.way = soil_sliding_way(number), .stride = (ptrdiff_t)slopes->width, .first = number == 0};
	for (int i = 0; i < rule->class_count; i++)
		for (int k = 0; k < 2; k++) {
			int64_t rise = by.way * (int64_t)rule->classes[i].rise[k];
			by.rises[i][k] = (int32_t)(rise < 1 << 30 ? rise : 1 << 30);
		}
	for (size_t y = 0; y < slopes->height; y++) {
		int64_t row = (int64_t)y - (int64_t)slopes->below;
		if (row < -later || row >= (int64_t)slopes->field->height + later)
			continue;
		const struct sliding_span span = span_at(slopes, y, later, near);
		by.surfaces = slopes->surfaces + y * slopes->width;
		by.extents = (number == 0 ? (const uint32_t *)planes->slope : slopes->extents[(number + 1) % 2]) + y * slopes->width;
		by.classes = planes->classes != NULL ? planes->classes + y * planes->width : NULL;
		if (span.first < span.end)
			hop_row(&by, (size_t)span.first, (size_t)span.end, slopes->extents[number % 2] + y * slopes->width);
	}
}

/* Returns the size of a difference of two posts; 0: one has no data. */
static uint32_t apart(int32_t a, int32_t b)
{
	const uint32_t difference = (uint32_t)a - (uint32_t)b;
	return a == SLIDING_STILL || b == SLIDING_STILL ? 0 : difference < 1u << 31 ? difference : 0 - difference;
}

/*
 * Returns the share of a slope's steepness that its steepest pair of posts has, 2^-10. A slope that heads by t from an axis falls by g d cos t between
 * neighbours along it. Between diagonal ones it falls by sqrt(2) g d cos(45 - t). The larger cosine is 1 along an axis or a diagonal, and 0.924 between
 * them. With the tangent q of the smaller angle it is 1 - q^2 / 2 + 3 q^4 / 8, within 0.002.
 */
static int32_t share_of_steepest(const int32_t *surface, ptrdiff_t stride)
{
	const uint32_t east = apart(surface[1], surface[-1]), north = apart(surface[stride], surface[-stride]);
	uint32_t high = east > north ? east : north, low = east > north ? north : east;
	if (high == 0)
		return 1 << 10;
	const int bits = 31 - __builtin_clz(high), drop = bits > 20 ? bits - 20 : 0;
	high >>= drop;
	low >>= drop;
	const uint32_t axial = (low << 10) / high, diagonal = ((1024 - axial) << 10) / (1024 + axial), least = least_of(axial, diagonal), square = least * least >> 10;
	return (int32_t)(1024 - (square >> 1) + (3 * square * square >> 13));
}

/* Lowers the critical differences of posts to those of their slopes. */
static void lower_critical(struct sliding_field *field, const struct slopes *slopes)
{
	const struct soil_sliding *rule = field->rule;
	const struct soil_planes *planes = field->planes;
	const uint32_t *extents = slopes->extents[(SOIL_SLOPE_HOPS - 1) % 2];
	for (size_t y = 0; y < field->height; y++) {
		const size_t row = y + slopes->below;
		const struct sliding_span span = span_at(slopes, row, 0, rule->iterations + 1);
		for (int32_t x = span.first; x < span.end; x++) {
			uint32_t extent = extents[row * slopes->width + (size_t)x];
			int class = planes->classes != NULL ? planes->classes[row * planes->width + (size_t)x] : 0;
			class = class < SOIL_CLASSES ? class : SOIL_CLASSES - 1;
			int32_t limit = in_slope(rule, &rule->classes[class], (int32_t)((extent & 0xffffu) + (extent >> 16)));
			const int32_t share = share_of_steepest(slopes->surfaces + row * slopes->width + (size_t)x, (ptrdiff_t)slopes->width);
			limit = (limit >> 10) * share + ((limit & 1023) * share >> 10);
			limit = limit > rule->slope_least ? limit : rule->slope_least;
			int32_t *axial = &field->critical[0][y * field->stride + ((size_t)x - slopes->left)];
			int32_t *diagonal = &field->critical[1][y * field->stride + ((size_t)x - slopes->left)];
			*axial = *axial < limit ? *axial : limit;
			*diagonal = *diagonal < soil_sliding_diagonal(limit) ? *diagonal : soil_sliding_diagonal(limit);
		}
	}
}

/* Gives the least differences that slide in any slope: axial, diagonal. */
static void least_in_slopes(const struct soil_sliding *rule, int32_t least[2])
{
	least[0] = rule->slope_least;
	least[1] = soil_sliding_diagonal(rule->slope_least);
	for (int i = 0; i < rule->class_count; i++)
		for (int k = 0; k < 2; k++)
			least[k] = rule->classes[i].critical[k] < least[k] ? rule->classes[i].critical[k] : least[k];
}

void soil_sliding_least_in_slopes(struct sliding_field *field)
{
	int32_t in_slopes[2];
	least_in_slopes(field->rule, in_slopes);
	for (int k = 0; k < 2; k++)
		field->least[k] = soil_sliding_with_tolerance(field->rule, in_slopes[k]);
}

/* A row of extents that are kept. */
struct kept_row {
	const int32_t *surfaces, *offsets; /* offsets NULL: undisturbed ground is not stable */
	const uint32_t *extents;
	uint32_t *kept;
	uint8_t *changed; /* of each post: 1 or 0 */
	ptrdiff_t stride;
	int32_t least[2];
};

/* Keeps the extents of posts beside which soil could slide if the slope was high enough. Two heights differ by more than their bases as much as their
 * offsets differ. */
SOIL_INLINED void keep_posts(const struct kept_row *row, size_t width, bool stood)
{
	const int32_t *restrict surfaces = row->surfaces, *restrict offsets = row->offsets;
	const uint32_t *restrict extents = row->extents;
	uint32_t *restrict kept = row->kept;
	uint8_t *restrict changed = row->changed;
	const int32_t axial = row->least[0], diagonal = row->least[1];
	SOIL_APART
	for (ptrdiff_t x = 0; x < (ptrdiff_t)width; x++) {
		int32_t own = surfaces[x], could = 0;
#pragma GCC unroll 8
		for (int k = 0; k < 8; k++) {
			ptrdiff_t at = x + ways[k][0] + ways[k][1] * row->stride;
			int32_t other = surfaces[at], difference = (int32_t)((uint32_t)own - (uint32_t)other), sign = difference >> 31, more = 1;
			int32_t high = (int32_t)(((uint32_t)difference ^ (uint32_t)sign) - (uint32_t)sign);
			if (stood)
				more = (int32_t)((((uint32_t)offsets[x] - (uint32_t)offsets[at]) ^ (uint32_t)sign) - (uint32_t)sign);
			could |= (int32_t)(other != SLIDING_STILL) & (int32_t)(high > (k < 4 ? axial : diagonal)) & (int32_t)(more > 0);
		}
		uint32_t extent = (could & (int32_t)(own != SLIDING_STILL)) != 0 ? extents[x] : 0;
		changed[x] = (uint8_t)(extent != kept[x]);
		kept[x] = extent;
	}
}

SOIL_LANES static void keep_row(const struct kept_row *row, size_t width)
{
	if (row->offsets != NULL)
		keep_posts(row, width, true);
	else
		keep_posts(row, width, false);
}

/* Keeps the extents of posts of the field, less `trim` on each side. Marks in field->steeps posts whose extents changed. */
static void keep(struct sliding_field *field, const struct slopes *slopes, size_t trim)
{
	memset(field->steeps, 0, field->width * field->height);
	for (size_t y = trim; y < field->height - trim; y++) {
		struct sliding_span span = span_at(slopes, y + slopes->below, 0, 1);
		const int32_t left = (int32_t)(slopes->left + trim), right = (int32_t)(slopes->left + field->width - trim);
		span.first = span.first > left ? span.first : left;
		span.end = span.end < right ? span.end : right;
		if (span.first >= span.end)
			continue;
		const size_t at = (y + slopes->below) * slopes->width + (size_t)span.first;
		const struct kept_row row = {
			.surfaces = slopes->surfaces + at,
			.offsets = field->rule->undisturbed_stable ? field->planes->offset + at : NULL,
			.extents = slopes->extents[(SOIL_SLOPE_HOPS - 1) % 2] + at,
			.kept = (uint32_t *)field->planes->slope + at,
			.changed = field->steeps + y * field->width + ((size_t)span.first - slopes->left),
			.stride = (ptrdiff_t)slopes->width,
			.least = {slopes->least[0], slopes->least[1]},
		};
		keep_row(&row, (size_t)(span.end - span.first));
	}
}

SOIL_LANES static bool any_kept(const int32_t *restrict kept, size_t width)
{
	int32_t any = 0;
	SOIL_APART
	for (size_t x = 0; x < width; x++)
		any |= kept[x];
	return any != 0;
}

/* Returns the columns of a row of the field in which a neighbour is steep, or extents are kept. */
static struct sliding_span steep_span(const struct slopes *slopes, size_t row)
{
	const struct sliding_field *field = slopes->field;
	const size_t at = (row + slopes->below) * slopes->width + slopes->left;
	struct sliding_span span = soil_sliding_steep_span(slopes->surfaces + at, slopes->width, field->width, slopes->least);
	const int32_t *kept = field->planes->slope + at;
	int32_t first = 0, end = any_kept(kept, field->width) ? (int32_t)field->width : 0;
	while (first < end && kept[first] == 0)
		first++;
	while (end > first && kept[end - 1] == 0)
		end--;
	return soil_sliding_both(span, (struct sliding_span){first, end});
}

/* Finds the heights of rows of the planes. */
static void find_surfaces(const struct slopes *slopes, size_t first, size_t end)
{
	const struct soil_planes *planes = slopes->field->planes;
	for (size_t y = first; y < end; y++)
		surface_row(planes->base + y * planes->width, planes->offset + y * planes->width, slopes->width, slopes->surfaces + y * slopes->width);
}

bool soil_sliding_slopes(struct sliding_field *field, size_t trim, void *scratch)
{
	const struct soil_planes *planes = field->planes;
	struct slopes slopes = {
		.field = field,
		.width = (size_t)(planes->rect.x1 - planes->rect.x0),
		.height = (size_t)(planes->rect.y1 - planes->rect.y0),
		.left = (size_t)(field->rect.x0 - planes->rect.x0),
		.below = (size_t)(field->rect.y0 - planes->rect.y0),
	};
	const size_t bytes = rounded(slopes.width * slopes.height * sizeof(int32_t));
	bool any = false;
	slopes.surfaces = scratch;
	slopes.extents[0] = (void *)((char *)scratch + bytes);
	slopes.extents[1] = (void *)((char *)scratch + 2 * bytes);
	slopes.steep = (void *)((char *)scratch + 3 * bytes);
	least_in_slopes(field->rule, slopes.least);
	find_surfaces(&slopes, slopes.below, slopes.below + field->height + 1);
	for (size_t y = 0; y < field->height; y++) {
		slopes.steep[y] = steep_span(&slopes, y);
		any = any || slopes.steep[y].first < slopes.steep[y].end;
	}
	if (!any)
		return false;
	find_surfaces(&slopes, 0, slopes.below);
	find_surfaces(&slopes, slopes.below + field->height + 1, slopes.height);
	for (int number = 0; number < SOIL_SLOPE_HOPS; number++)
		run_hop(&slopes, number);
	lower_critical(field, &slopes);
	keep(field, &slopes, trim);
	return true;
}
