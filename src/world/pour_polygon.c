/* A volume of soil that lies evenly on the posts in a polygon. */
#include <math.h>
#include <stdlib.h>

#include "world/internal.h"

#define UNITS 0x1p20 /* of a metre */

struct area {
	struct post_rect rect;
	int32_t *amounts;
};

struct polygon {
	size_t count;
	const double *xy;
	double spacing;
	double *crossings; /* room for `count` */
};

static int by_size(const void *a, const void *b)
{
	const double p = *(const double *)a, q = *(const double *)b;
	return (p > q) - (p < q);
}

/* Finds where the outline crosses a row of posts, from west to east. Of an edge its southern end counts, and not its northern one. */
static size_t cross(const struct polygon *polygon, int64_t row)
{
	const double y = (double)row * polygon->spacing;
	size_t crossings = 0;
	for (size_t i = 0; i < polygon->count; i++) {
		const double *a = &polygon->xy[2 * i], *b = &polygon->xy[2 * ((i + 1) % polygon->count)];
		if ((a[1] <= y) != (b[1] <= y))
			polygon->crossings[crossings++] = a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
	}
	qsort(polygon->crossings, crossings, sizeof *polygon->crossings, by_size);
	return crossings;
}

/* Sets the amounts of posts in the polygon to 1. Returns their number. */
static int64_t mark(const struct polygon *polygon, struct area *area)
{
	const struct post_rect rect = area->rect;
	const int64_t width = rect.x1 - rect.x0;
	int64_t posts = 0;
	for (int64_t y = rect.y0; y < rect.y1; y++) {
		const size_t crossings = cross(polygon, y);
		for (size_t i = 0; i + 1 < crossings; i += 2) {
			const int64_t first = (int64_t)ceil(polygon->crossings[i] / polygon->spacing), end = (int64_t)ceil(polygon->crossings[i + 1] / polygon->spacing);
			for (int64_t x = first > rect.x0 ? first : rect.x0; x < end && x < rect.x1; x++, posts++)
				area->amounts[(y - rect.y0) * width + x - rect.x0] = 1;
		}
	}
	return posts;
}

/* Parts an amount evenly among the marked posts. The first of them, in row order, get what is left. */
static void part(struct area *area, int64_t posts, int64_t amount)
{
	const struct post_rect rect = area->rect;
	const size_t count = (size_t)(rect.x1 - rect.x0) * (size_t)(rect.y1 - rect.y0);
	const int64_t each = amount / posts, sign = amount < 0 ? -1 : 1;
	int64_t left = llabs(amount % posts);
	for (size_t i = 0; i < count; i++) {
		if (area->amounts[i] == 0)
			continue;
		area->amounts[i] = (int32_t)(each + (left > 0 ? sign : 0));
		left--;
	}
}

static enum status check_polygon(const struct world *world, size_t count, const double *xy, double volume, double bounds[4])
{
	const struct extent *extent = &world->resident.meta->extent;
	if (count < 3)
		return fail_with(STATUS_USAGE, "xy: %zu corners make no polygon; give at least 3", count);
	if (!isfinite(volume))
		return fail_with(STATUS_USAGE, "volume: %g is none; give m3, below 0: taken", volume);
	for (size_t i = 0; i < count; i++) {
		const double x = xy[2 * i], y = xy[2 * i + 1];
		if (!isfinite(x) || !isfinite(y))
			return fail_with(STATUS_USAGE, "xy[%zu]: %g, %g is no place; give finite numbers, m", i, x, y);
		if (!extent_holds(extent, x, y))
			return fail_with(STATUS_INPUT, "pour: corner %zu of the polygon, %.10g, %.10g m, is off the terrain, which goes from 0, 0 to %.10g, %.10g m; "
				       "move it onto the terrain", i, x, y, (double)(extent->width - 1) * extent->spacing, (double)(extent->height - 1) * extent->spacing);
		bounds[0] = i == 0 ? x : fmin(bounds[0], x);
		bounds[1] = i == 0 ? y : fmin(bounds[1], y);
		bounds[2] = i == 0 ? x : fmax(bounds[2], x);
		bounds[3] = i == 0 ? y : fmax(bounds[3], y);
	}
	return STATUS_OK;
}

static enum status fill(const struct polygon *polygon, double volume, struct area *area)
{
	const int64_t posts = area->amounts != NULL ? mark(polygon, area) : 0;
	const double amount = volume / (polygon->spacing * polygon->spacing) * UNITS, most = (double)posts * (double)(INT32_MAX - 1);
	if (posts == 0)
		return fail_with(STATUS_INPUT, "pour: the polygon has no post in it, and posts are %g m apart; give a larger one", polygon->spacing);
	if (!(fabs(amount) < most))
		return fail_with(STATUS_INPUT, "pour: %g m3 over %lld posts are more than 2048 m at each; give less, or a larger polygon", volume, (long long)posts);
	part(area, posts, llround(amount));
	return STATUS_OK;
}

enum status world_pour_polygon(const struct world *world, size_t count, const double *xy, double volume, struct post_rect *rect, int32_t **amounts)
{
	struct area area = {.amounts = NULL};
	double bounds[4] = {0};
	TRY(check_polygon(world, count, xy, volume, bounds));
	const double spacing = world->resident.spacing;
	area.rect = (struct post_rect){(int64_t)ceil(bounds[0] / spacing), (int64_t)ceil(bounds[1] / spacing), (int64_t)floor(bounds[2] / spacing) + 1,
				       (int64_t)floor(bounds[3] / spacing) + 1};
	TRY(world_pour_rect(world, area.rect));
	struct polygon polygon = {count, xy, spacing, mem_alloc(count, sizeof *polygon.crossings)};
	TRY_MEM(polygon.crossings, "a polygon");
	enum status status = STATUS_OK;
	if (!post_rect_empty(area.rect)) {
		area.amounts = mem_calloc((size_t)(area.rect.x1 - area.rect.x0) * (size_t)(area.rect.y1 - area.rect.y0), sizeof *area.amounts);
		TRY_OR(done, area.amounts != NULL ? STATUS_OK : fail_memory("posts"));
	}
	TRY_OR(done, fill(&polygon, volume, &area));
	*rect = area.rect;
	*amounts = area.amounts;
	area.amounts = NULL;
done:
	mem_free_all(polygon.crossings, area.amounts);
	return status;
}
