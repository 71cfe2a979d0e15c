/* Strips beside the faces of the rectangle around the patch: which posts they have in each row, and the weights of these posts. */
#include <math.h>

#include "soil/laying/strips.h"
#include "soil/lanes.h"

#define HALF_POST (1 << 15)
#define NARROWEST 128 /* 2^-6 post: two posts, so that there is a post in it */
#define FINER 10      /* places of 2^-16 post have so many more bits than lengths of 2^-6 post */

/* Returns floor(sqrt(value)); value < 2^62. */
static int32_t whole_root(uint64_t value)
{
	uint64_t root = (uint64_t)sqrt((double)value);
	while (root * root > value)
		root--;
	while ((root + 1) * (root + 1) <= value)
		root++;
	return (int32_t)root;
}

static int32_t lesser(int32_t a, int32_t b)
{
	return a < b ? a : b;
}

static int32_t greater(int32_t a, int32_t b)
{
	return a > b ? a : b;
}

void soil_strip_band(struct laying_field *field, const struct soil_measured *measured, const struct soil_laid soils[SOIL_CLASSES])
{
	const struct soil_laying *laying = field->laying;
	int32_t factor = 0, *rectangle = field->rectangle;
	/* Of the soils that are carried, the least steep one makes the widest band. */
	for (int i = 0; i < SOIL_CLASSES; i++)
		if (measured->classes >> i & 1)
			factor = greater(factor, soils[i].factor);
	for (int k = 0; k < 2; k++) {
		rectangle[2 * k] = measured->most[k] + HALF_POST;
		rectangle[2 * k + 1] = measured->least[k] - HALF_POST;
	}
	if (laying->half_width > 0) {
		rectangle[2] = laying->half_width;
		rectangle[3] = -laying->half_width;
	}
	const uint32_t along = (uint32_t)(rectangle[0] - rectangle[1]) >> FINER, across = (uint32_t)(rectangle[2] - rectangle[3]) >> FINER;
	/* The cross-section of the soil beside a metre of the patch's contour is this length times the depth. */
	const uint32_t beside = ((across * (uint32_t)(65536 - laying->along)) >> 17) + ((along * (uint32_t)laying->along) >> 17);
	const int32_t reaches = (int32_t)(laying->around ? (along >> 1) * across / (along + across) : beside);
	const int64_t square = (int64_t)lesser(measured->deep, SOIL_HOLLOW_MOST) * reaches * factor;
	field->band = lesser(greater(whole_root((uint64_t)square >> 24), greater(reaches / 4, NARROWEST)), laying->widest);
}

/* Adds the strip at one side of the rectangle that gives to the face whose places along `axis` are above 0, or not. */
static void add(const struct laying_field *field, int axis, int sign, bool above, int32_t low, int32_t high, struct strip *strips, int *count)
{
	const int face = 2 * axis + (above ? 0 : 1);
	const int32_t edge = field->rectangle[2 * axis + (sign < 0)];
	struct strip strip = {.face = face, .axis = axis, .sign = sign, .edge = edge};
	/* A post in the band is at least 2^-6 post from each of its edges. */
	const int32_t near = 1 << FINER, far = (field->band << FINER) - 1;
	strip.low[axis] = greater(sign > 0 ? edge + near : edge - far, above ? 1 : INT32_MIN);
	strip.high[axis] = lesser(sign > 0 ? edge + far : edge - near, above ? INT32_MAX : 0);
	strip.low[1 - axis] = low;
	strip.high[1 - axis] = high;
	if (strip.low[axis] <= strip.high[axis] && low <= high && field->laying->shares[face] != 0)
		strips[(*count)++] = strip;
}

/* Beside the ends, or the sides, of the rectangle. Those of one face come in the order of x. */
static void add_both(const struct laying_field *field, int axis, int32_t low, int32_t high, struct strip *strips, int *count)
{
	const int32_t step = axis == 0 ? field->laying->axis[0] : -field->laying->axis[1]; /* of the frame's place, by post */
	for (int k = 0; k < 2; k++) {
		const int sign = (k == 0) == (step >= 0) ? -1 : 1;
		add(field, axis, sign, true, low, high, strips, count);
		add(field, axis, sign, false, low, high, strips, count);
	}
}

int soil_strips(const struct laying_field *field, struct strip strips[STRIPS_MOST])
{
	const struct soil_laying *laying = field->laying;
	const int32_t *rectangle = field->rectangle;
	int32_t low = rectangle[1], high = rectangle[0]; /* beside the sides */
	int count = 0;
	if (laying->goes_on > 0) {
		low = -laying->beside;
		high = laying->goes_on - laying->beside - 1;
	} else if (laying->goes_on < 0) {
		low = laying->beside + laying->goes_on + 1;
		high = laying->beside;
	} else if (laying->beside != INT32_MAX) {
		low = greater(low, -laying->beside);
		high = lesser(high, laying->beside);
	}
	add_both(field, 0, rectangle[3], rectangle[2], strips, &count);
	add_both(field, 1, low, high, strips, &count);
	return count;
}

/* Limits x, a range of whole numbers, to those with low <= from + x * step <= high, or about one more at each end. */
static void limit_to(double low, double high, double from, double step, double *first, double *last)
{
	if (step == 0) {
		if (from < low || from > high)
			*last = *first - 1;
		return;
	}
	const double a = (low - from) / step, b = (high - from) / step;
	*first = fmax(*first, floor(fmin(a, b)));
	*last = fmin(*last, ceil(fmax(a, b)));
}

/* Finds the rows that a strip may have posts in. */
static void find_rows(const struct laying_field *field, struct strip *strip)
{
	const struct soil_laying *laying = field->laying;
	const double c = laying->axis[0], s = laying->axis[1], by = 1 / (c * c + s * s);
	double first = INFINITY, last = -INFINITY;
	for (int corner = 0; corner < 4; corner++) {
		const double x = (double)(corner & 1 ? strip->high[0] : strip->low[0]) - laying->at[0];
		const double y = (double)(corner & 2 ? strip->high[1] : strip->low[1]) - laying->at[1];
		const double row = (x * s + y * c) * by;
		first = fmin(first, row);
		last = fmax(last, row);
	}
	const double origin = (double)(laying->y - field->y0);
	const double from = fmax(floor(first + origin), 0), to = fmin(ceil(last + origin) + 1, field->height);
	strip->first_row = to > from ? (int)from : 0;
	strip->rows = to > from ? (int)(to - from) : 0;
}

/* A run of posts: how far its first one is from the edge of the patch, and how much farther each next one is. */
struct weighed_run {
	int32_t from_edge, step;
	int32_t band;
	uint32_t sum, heaviest; /* results */
};

SOIL_LANES static void weigh(struct weighed_run *run, int count, const uint8_t *contact, const int32_t *base, uint16_t *weights)
{
	const int32_t first = run->from_edge, step = run->step, band = run->band, level = band / 3;
	int32_t sum = 0, heaviest = 0;
	for (int i = 0; i < count; i++) {
		const int32_t from_edge = (first + i * step) >> FINER, from_end = band - from_edge;
		const int32_t least = from_edge < from_end ? from_edge : from_end, weight = least < level ? least : level;
		const bool open = (contact[i] & (SOIL_LOWERED | SOIL_HELD)) == 0 && base[i] != BASE_NODATA;
		const int32_t gets = open ? weight : 0;
		weights[i] = (uint16_t)gets;
		sum += gets;
		heaviest = gets > heaviest ? gets : heaviest;
	}
	run->sum = (uint32_t)sum;
	run->heaviest = (uint32_t)heaviest;
}

static bool has(const struct strip *strip, int32_t x, int32_t y)
{
	return x >= strip->low[0] && x <= strip->high[0] && y >= strip->low[1] && y <= strip->high[1];
}

/* Returns the posts of a strip in a row. from: the place of the row's first post; steps: from post to post. */
static struct strip_run run_of(const struct laying_field *field, const struct strip *strip, const int32_t from[2], const int32_t steps[2])
{
	double first = 0, last = field->width - 1;
	for (int k = 0; k < 2; k++)
		limit_to(strip->low[k], strip->high[k], from[k], steps[k], &first, &last);
	if (last < first)
		return (struct strip_run){0, 0};
	struct strip_run run = {(int32_t)first, (int32_t)(last - first) + 1};
	/* The limits may be off by a post or so. The strip is convex, so only the ends of the run can be outside. */
	while (run.count > 0 && !has(strip, from[0] + run.first * steps[0], from[1] + run.first * steps[1])) {
		run.first++;
		run.count--;
	}
	for (int32_t end = run.first + run.count - 1; run.count > 0; run.count--, end--)
		if (has(strip, from[0] + end * steps[0], from[1] + end * steps[1]))
			break;
	return run;
}

void soil_strip_beside(const struct laying_field *field, struct strip *strip, struct strip_run *runs)
{
	const struct soil_laying *laying = field->laying;
	const int axis = strip->axis, sign = strip->sign;
	const int32_t steps[2] = {laying->axis[0], -laying->axis[1]};
	find_rows(field, strip);
	strip->runs = runs;
	for (int k = 0; k < strip->rows; k++) {
		const int row = strip->first_row + k;
		const int32_t from[2] = {soil_laying_place(laying, field->x0, field->y0 + row, 0), soil_laying_place(laying, field->x0, field->y0 + row, 1)};
		const struct strip_run run = runs[k] = run_of(field, strip, from, steps);
		if (run.count == 0)
			continue;
		struct weighed_run weighed = {sign * (from[axis] + run.first * steps[axis] - strip->edge), sign * steps[axis], field->band, 0, 0};
		const size_t at = (size_t)row * field->stride + (size_t)run.first;
		weigh(&weighed, run.count, field->contact + at, field->base + at, field->weights + (size_t)row * (size_t)field->width + run.first);
		strip_add_row(strip, row, weighed.sum, weighed.heaviest);
	}
}
