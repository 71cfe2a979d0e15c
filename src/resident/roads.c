/*
 * Roads, as straight parts with a half width. A post lies on a road if it is within the half width of a part, ends included. That depends on the post
 * and on the part alone, so tiles and levels agree. Later parts lie over earlier ones.
 *
 * Parts follow each other along their lines. So runs of them lie close together, and a run that is far from a rectangle is passed over whole.
 */
#include "resident/roads.h"

#include <math.h>
#include <string.h>

#define RUN 32 /* parts */

struct box {
	double low[2], high[2]; /* m */
};

struct roads {
	struct road_part *parts;
	struct box *runs; /* of each RUN parts */
	size_t count;
};

static struct box box_of(const struct road_part *part)
{
	struct box box;
	for (int i = 0; i < 2; i++) {
		box.low[i] = fmin(part->from[i], part->to[i]) - part->half_width;
		box.high[i] = fmax(part->from[i], part->to[i]) + part->half_width;
	}
	return box;
}

static void join(struct box *box, const struct box *other)
{
	for (int i = 0; i < 2; i++) {
		box->low[i] = fmin(box->low[i], other->low[i]);
		box->high[i] = fmax(box->high[i], other->high[i]);
	}
}

static bool meet(const struct box *a, const struct box *b)
{
	return a->low[0] <= b->high[0] && b->low[0] <= a->high[0] && a->low[1] <= b->high[1] && b->low[1] <= a->high[1];
}

enum status resident_roads_create(const struct road_part *parts, size_t count, struct roads **out)
{
	const size_t runs = (count + RUN - 1) / RUN;
	*out = NULL;
	if (count == 0)
		return STATUS_OK;
	struct roads *roads = mem_calloc(1, sizeof *roads);
	TRY_MEM(roads, "roads");
	roads->parts = mem_alloc(count, sizeof *parts);
	roads->runs = mem_alloc(runs, sizeof *roads->runs);
	if (roads->parts == NULL || roads->runs == NULL) {
		resident_roads_destroy(roads);
		return fail_memory("roads");
	}
	memcpy(roads->parts, parts, count * sizeof *parts);
	roads->count = count;
	for (size_t i = 0; i < count; i++) {
		const struct box box = box_of(&parts[i]);
		if (i % RUN == 0)
			roads->runs[i / RUN] = box;
		else
			join(&roads->runs[i / RUN], &box);
	}
	*out = roads;
	return STATUS_OK;
}

void resident_roads_destroy(struct roads *roads)
{
	if (roads != NULL)
		mem_free_all(roads->parts, roads->runs, roads);
}

static bool is_on(const struct road_part *part, double x, double y)
{
	const double along[2] = {part->to[0] - part->from[0], part->to[1] - part->from[1]}, to[2] = {x - part->from[0], y - part->from[1]};
	const double length2 = along[0] * along[0] + along[1] * along[1];
	const double share = length2 > 0 ? fmin(fmax((to[0] * along[0] + to[1] * along[1]) / length2, 0), 1) : 0;
	const double off[2] = {to[0] - share * along[0], to[1] - share * along[1]};
	return off[0] * off[0] + off[1] * off[1] <= part->half_width * part->half_width;
}

/* Narrows low .. high to where the part's endless strip crosses the line at y, and a little more. */
static void narrow(const struct road_part *part, double y, double *low, double *high)
{
	const double along[2] = {part->to[0] - part->from[0], part->to[1] - part->from[1]}, length = hypot(along[0], along[1]);
	if (!(fabs(along[1]) > 1e-3 * length))
		return;
	const double middle = part->from[0] + (y - part->from[1]) * along[0] / along[1], reach = part->half_width * length / fabs(along[1]);
	*low = fmax(*low, middle - reach);
	*high = fmin(*high, middle + reach);
}

static void paint_part(const struct road_part *part, double spacing, struct post_rect rect, uint8_t *classes)
{
	const struct box box = box_of(part);
	const int64_t y0 = (int64_t)fmax((double)rect.y0, floor(box.low[1] / spacing)), y1 = (int64_t)fmin((double)rect.y1, ceil(box.high[1] / spacing) + 1);
	for (int64_t y = y0; y < y1; y++) {
		double low = box.low[0], high = box.high[0];
		narrow(part, (double)y * spacing, &low, &high);
		const int64_t x0 = (int64_t)fmax((double)rect.x0, floor(low / spacing) - 1), x1 = (int64_t)fmin((double)rect.x1, ceil(high / spacing) + 2);
		for (int64_t x = x0; x < x1; x++)
			if (is_on(part, (double)x * spacing, (double)y * spacing))
				classes[(y - rect.y0) * (rect.x1 - rect.x0) + (x - rect.x0)] = part->soil;
	}
}

void resident_roads_paint(const struct roads *roads, double spacing, struct post_rect rect, uint8_t *classes)
{
	if (roads == NULL)
		return;
	const struct box asked = {{(double)rect.x0 * spacing, (double)rect.y0 * spacing}, {(double)(rect.x1 - 1) * spacing, (double)(rect.y1 - 1) * spacing}};
	for (size_t i = 0; i < roads->count; i++) {
		if (i % RUN == 0 && !meet(&roads->runs[i / RUN], &asked)) {
			i += RUN - 1;
			continue;
		}
		paint_part(&roads->parts[i], spacing, rect, classes);
	}
}
