/*
 * An iteration of sliding between each post and its eight neighbours. The amount depends on how much their difference of height exceeds the
 * critical one (SOIL.md, "Sliding").
 *
 * Each pair of posts is computed once, from the one in the south or west. `flows` of a row hold what goes from each of its posts to the post
 * in the east, north, north-east and north-west. A post's height changes by what it gave and got in two rows of flows. The flows of the next
 * row do not need the height of this one. So rows change in place.
 *
 * Two things keep ground at rest cheap, and change no bit.
 * (1) A post keeps its height if the iteration before changed none of the nine heights at and around it. What it gives and gets is then the
 * same as before, when the sum was 0. So each row has the span of columns that changed.
 * (2) A part of a row in which no difference exceeds the least critical one has no flow.
 */
#include <string.h>

#include "soil/sliding/sliding.h"

#define PART 64 /* posts */

/* --- flows --- */

/* A row of posts, and the next one to the north. */
struct rows {
	const int32_t *height, *north;
	const int32_t *ground, *floor, *ceiling;  /* read at the stride, too */
	const int32_t *axial, *diagonal;
	size_t stride;
	int32_t limits[2], least[2], tolerance;
};

SOIL_INLINED uint32_t high_of(uint32_t a, uint32_t b)
{
	int32_t difference = (int32_t)(a - b), sign = difference >> 31;
	return ((uint32_t)difference ^ (uint32_t)sign) - (uint32_t)sign;
}

/* Returns 1 if soil may slide between two posts. */
SOIL_INLINED uint32_t is_steep(int32_t a, int32_t b, int32_t least)
{
	return (uint32_t)((int32_t)high_of((uint32_t)a, (uint32_t)b) > least) & (uint32_t)(a != SLIDING_STILL) & (uint32_t)(b != SLIDING_STILL);
}

SOIL_LANES static bool any_steep(const int32_t *restrict height, const int32_t *restrict north, size_t first, size_t end, const int32_t least[2])
{
	const int32_t axial = least[0], diagonal = least[1];
	uint32_t any = 0;
	SOIL_APART
	for (size_t x = first; x < end; x++) {
		int32_t own = height[x];
		any |= is_steep(own, height[x + 1], axial) | is_steep(own, north[x], axial) | is_steep(own, north[x + 1], diagonal) |
		       is_steep(own, north[(ptrdiff_t)x - 1], diagonal);
	}
	return any != 0;
}

struct sliding_span soil_sliding_steep_span(const int32_t *height, size_t stride, size_t width, const int32_t least[2])
{
	struct sliding_span span = {0, 0};
	for (int32_t first = 0; first < (int32_t)width; first += PART) {
		int32_t end = first + PART < (int32_t)width ? first + PART : (int32_t)width;
		if (!any_steep(height, height + stride, (size_t)first, (size_t)end, least))
			continue;
		span.first = span.end == 0 ? first : span.first;
		span.end = end;
	}
	return span;
}

/* Numbers of two posts. */
struct pair {
	int32_t a, b, ground_a, ground_b, floor_a, floor_b, ceiling_a, ceiling_b, critical_a, critical_b, tolerance;
};

/* Returns what slides from a to b; below 0 from b to a. */
SOIL_INLINED int32_t flow_of(const struct pair *p, bool bounded, bool stood, bool roofed)
{
	int32_t difference = (int32_t)((uint32_t)p->a - (uint32_t)p->b), sign = difference >> 31;
	int32_t high = (int32_t)(((uint32_t)difference ^ (uint32_t)sign) - (uint32_t)sign);
	int32_t over = (int32_t)((uint32_t)high - (uint32_t)(sign != 0 ? p->critical_b : p->critical_a));
	int32_t amount = (int32_t)((uint32_t)over + 7u) >> 3, eighth = high >> 3;
	amount = amount < eighth ? amount : eighth;
	amount = amount < SLIDING_MOST ? amount : SLIDING_MOST;
	if (bounded) {
		int32_t loose = (int32_t)(sign != 0 ? (uint32_t)p->b - (uint32_t)p->floor_b : (uint32_t)p->a - (uint32_t)p->floor_a) >> 3;
		amount = amount < loose ? amount : loose;
	}
	if (roofed) { /* roofs.c */
		int32_t room = (int32_t)(sign != 0 ? (uint32_t)p->ceiling_a - (uint32_t)p->a : (uint32_t)p->ceiling_b - (uint32_t)p->b) >> 3;
		amount = amount < room ? amount : room;
	}
	if (stood) {
		uint32_t risen = (uint32_t)difference - ((uint32_t)p->ground_a - (uint32_t)p->ground_b);
		int32_t more = (int32_t)((risen ^ (uint32_t)sign) - (uint32_t)sign);
		amount = amount < more ? amount : more;
		over = over < more ? over : more;
	}
	amount = amount > 0 ? amount : 0;
	int32_t slides = (int32_t)(over > p->tolerance) & (int32_t)(p->a != SLIDING_STILL) & (int32_t)(p->b != SLIDING_STILL);
	amount = slides != 0 ? amount : 0;
	return (amount ^ sign) - sign;
}

SOIL_INLINED void flows_of(const struct rows *rows, size_t first, size_t end, int32_t *const flows[4], bool classes, bool bounded, bool stood,
			   bool roofed)
{
	const int32_t *restrict height = rows->height, *restrict north = rows->north;
	const int32_t *restrict ground = rows->ground, *restrict floor = rows->floor, *restrict ceiling = rows->ceiling;
	const int32_t *restrict axial = rows->axial, *restrict diagonal = rows->diagonal;
	int32_t *restrict to_east = flows[0], *restrict to_north = flows[1], *restrict to_north_east = flows[2], *restrict to_north_west = flows[3];
	const int32_t limit = rows->limits[0], limit_diagonal = rows->limits[1], tolerance = rows->tolerance;
	const ptrdiff_t up = (ptrdiff_t)rows->stride;
	SOIL_APART
	for (ptrdiff_t x = (ptrdiff_t)first; x < (ptrdiff_t)end; x++) {
#define PAIR(neighbour, at, k) &(const struct pair){ \
	.a = height[x], .b = neighbour, .tolerance = tolerance, \
	.ground_a = stood ? ground[x] : 0, .ground_b = stood ? ground[at] : 0, \
	.floor_a = bounded ? floor[x] : 0, .floor_b = bounded ? floor[at] : 0, \
	.ceiling_a = roofed ? ceiling[x] : 0, .ceiling_b = roofed ? ceiling[at] : 0, \
	.critical_a = classes ? (k ? diagonal[x] : axial[x]) : k ? limit_diagonal : limit, \
	.critical_b = classes ? (k ? diagonal[at] : axial[at]) : k ? limit_diagonal : limit}
		to_east[x] = flow_of(PAIR(height[x + 1], x + 1, 0), bounded, stood, roofed);
		to_north[x] = flow_of(PAIR(north[x], x + up, 0), bounded, stood, roofed);
		to_north_east[x] = flow_of(PAIR(north[x + 1], x + up + 1, 1), bounded, stood, roofed);
		to_north_west[x] = flow_of(PAIR(north[x - 1], x + up - 1, 1), bounded, stood, roofed);
#undef PAIR
	}
}

typedef void (*flows_fn)(const struct rows *rows, size_t first, size_t end, int32_t *const flows[4]);
#define FLOWS(name, classes, bounded, stood) \
	SOIL_LANES static void name(const struct rows *rows, size_t first, size_t end, int32_t *const flows[4]) \
	{ \
		flows_of(rows, first, end, flows, classes, bounded, stood, false); \
	} \
	SOIL_LANES static void name##_roofed(const struct rows *rows, size_t first, size_t end, int32_t *const flows[4]) \
	{ \
		flows_of(rows, first, end, flows, classes, bounded, stood, true); \
	}
FLOWS(flows_plain, false, false, false)
FLOWS(flows_stood, false, false, true)
FLOWS(flows_bounded, false, true, false)
FLOWS(flows_bounded_stood, false, true, true)
FLOWS(flows_classes, true, false, false)
FLOWS(flows_classes_stood, true, false, true)
FLOWS(flows_classes_bounded, true, true, false)
FLOWS(flows_classes_bounded_stood, true, true, true)

static flows_fn flows_for(const struct sliding_field *field)
{
	static const flows_fn all[2][2][2][2] = {
		{{{flows_plain, flows_stood}, {flows_bounded, flows_bounded_stood}}, {{flows_classes, flows_classes_stood}, {flows_classes_bounded, flows_classes_bounded_stood}}},
		{{{flows_plain_roofed, flows_stood_roofed}, {flows_bounded_roofed, flows_bounded_stood_roofed}},
		 {{flows_classes_roofed, flows_classes_stood_roofed}, {flows_classes_bounded_roofed, flows_classes_bounded_stood_roofed}}}};
	return all[field->ceilings != NULL][field->critical[0] != NULL][field->floors != NULL][field->grounds != NULL];
}

/* --- changes --- */

/* Changes heights by the flows of their row and of the row before. Returns whether any changed. */
SOIL_INLINED bool change_by(int32_t *restrict height, int32_t *const own[4], int32_t *const before[4], size_t first, size_t end,
			       uint8_t *restrict moved, bool tells)
{
	const int32_t *restrict east = own[0], *restrict north = own[1], *restrict north_east = own[2], *restrict north_west = own[3];
	const int32_t *restrict south = before[1], *restrict south_west = before[2], *restrict south_east = before[3];
	int32_t any = 0;
	SOIL_APART
	for (ptrdiff_t x = (ptrdiff_t)first; x < (ptrdiff_t)end; x++) {
		int32_t west = east[x - 1], from_south_west = south_west[x - 1], from_south_east = south_east[x + 1];
		int32_t change = west + south[x] + from_south_west + from_south_east - east[x] - north[x] - north_east[x] - north_west[x];
		height[x] = (int32_t)((uint32_t)height[x] + (uint32_t)change);
		any |= change;
		if (tells) {
			int32_t all = west | south[x] | from_south_west | from_south_east | east[x] | north[x] | north_east[x] | north_west[x];
			moved[x] = (uint8_t)(all != 0);
		}
	}
	return any != 0;
}

SOIL_LANES static bool change(int32_t *height, int32_t *const own[4], int32_t *const before[4], size_t first, size_t end)
{
	return change_by(height, own, before, first, end, NULL, false);
}

SOIL_LANES static bool change_and_tell(int32_t *height, int32_t *const own[4], int32_t *const before[4], size_t first, size_t end, uint8_t *moved)
{
	return change_by(height, own, before, first, end, moved, true);
}

void soil_sliding_all_dirty(struct sliding_field *field)
{
	for (size_t y = 0; y < field->height + 2; y++)
		field->dirty[y] = (struct sliding_span){0, (int32_t)field->width};
}

/* Returns the columns whose posts may change in this iteration. Row y of the field is row y + 1 of the spans. */
static struct sliding_span wanted(const struct sliding_field *field, size_t y, struct sliding_span within, bool last)
{
	if (last)
		return within;
	return soil_sliding_wider(soil_sliding_both(soil_sliding_both(field->dirty[y], field->dirty[y + 1]), field->dirty[y + 2]), within);
}

/* Computes the flows of a row within a span. Returns the columns that may have some. Elsewhere in the span flows are 0. */
static struct sliding_span flow(const struct sliding_field *field, flows_fn flows, size_t y, struct sliding_span span, int32_t *const to[4])
{
	const size_t at = y * field->stride;
	const struct rows rows = {
		.height = field->heights + at,
		.north = field->heights + at + field->stride,
		.ground = field->grounds != NULL ? field->grounds + at : NULL,
		.floor = field->floors != NULL ? field->floors + at : NULL,
		.ceiling = field->ceilings != NULL ? field->ceilings + at : NULL,
		.axial = field->critical[0] != NULL ? field->critical[0] + at : NULL,
		.diagonal = field->critical[1] != NULL ? field->critical[1] + at : NULL,
		.stride = field->stride,
		.limits = {field->limits[0], field->limits[1]},
		.tolerance = field->rule->tolerance,
	};
	struct sliding_span has = {0, 0};
	for (int32_t first = span.first; first < span.end; first += PART) {
		int32_t end = first + PART < span.end ? first + PART : span.end;
		if (any_steep(rows.height, rows.north, (size_t)first, (size_t)end, field->least)) {
			flows(&rows, (size_t)first, (size_t)end, to);
			has = soil_sliding_both(has, (struct sliding_span){first, end});
			continue;
		}
		for (int way = 0; way < 4; way++)
			memset(to[way] + first, 0, (size_t)(end - first) * sizeof **to);
	}
	return has;
}

void soil_sliding_iterate(struct sliding_field *field, size_t trim, bool last)
{
	const flows_fn flows = flows_for(field);
	const struct sliding_span whole = {0, (int32_t)field->width}, none = {0, 0};
	const struct sliding_span within = {(int32_t)trim, (int32_t)(field->width - trim)};
	struct sliding_span before = none; /* columns of flows of the row before */
	const size_t bottom = trim, top = field->height - trim;
	for (size_t y = 0; y < field->height + 2; y++)
		field->next[y] = none;
	if (last)
		memset(field->moved, 0, field->width * field->height);
	/* The flows of the row before the first one of the field. */
	for (int way = 0; way < 4; way++)
		memset(field->flows[1][way] - 16, 0, field->stride * sizeof(int32_t));
	for (size_t y = bottom > 0 ? bottom - 1 : 0; y < top; y++) {
		int32_t *const *own = field->flows[y % 2], *const *south = field->flows[1 - y % 2];
		struct sliding_span here = y >= bottom ? wanted(field, y, within, last) : none;
		struct sliding_span after = y + 1 < top ? wanted(field, y + 1, within, last) : none;
		struct sliding_span span = soil_sliding_wider(soil_sliding_both(here, after), whole);
		struct sliding_span has = flow(field, flows, y, span, own);
		struct sliding_span changes = soil_sliding_wider(soil_sliding_both(has, before), within);
		before = has;
		changes.first = changes.first > here.first ? changes.first : here.first;
		changes.end = changes.end < here.end ? changes.end : here.end;
		if (y < bottom || soil_sliding_is_empty(changes))
			continue;
		for (int32_t first = changes.first; first < changes.end; first += PART) {
			int32_t end = first + PART < changes.end ? first + PART : changes.end, *height = field->heights + y * field->stride;
			bool any = last ? change_and_tell(height, own, south, (size_t)first, (size_t)end, field->moved + y * field->width)
					: change(height, own, south, (size_t)first, (size_t)end);
			if (any)
				field->next[y + 1] = soil_sliding_both(field->next[y + 1], (struct sliding_span){first, end});
		}
	}
	struct sliding_span *dirty = field->dirty;
	field->dirty = field->next;
	field->next = dirty;
}
