/* furrow.h: queries about the newest ground. */
#include "api/library.h"

#include <math.h>
#include <string.h>

/* Offsets smaller than this are rounding errors of the base: twice the lattice's 2^-18 m. */
#define OFFSET_NOISE 0x1p-17

static enum status points_of(size_t count, const double *xy, struct resident_point *points)
{
	for (size_t i = 0; i < count; i++) {
		const double x = xy[2 * i], y = xy[2 * i + 1];
		if (!isfinite(x) || !isfinite(y))
			return fail_with(STATUS_USAGE, "xy[%zu]: %g, %g is no place; give finite numbers, m", i, x, y);
		points[i] = (struct resident_point){x, y};
	}
	return STATUS_OK;
}

static enum status tell_point(struct furrow_world *world, const struct resident_point *at, const struct resident_height *height,
			      struct furrow_point *point)
{
	*point = (struct furrow_point){.height = height->bilinear, .offset = NAN, .nodata = isnan(height->bilinear)};
	memcpy(point->normal, height->normal, sizeof point->normal);
	if (point->nodata) {
		point->normal[0] = point->normal[1] = point->normal[2] = NAN;
		return STATUS_OK;
	}
	int64_t base;
	bool any;
	int soil = 0;
	TRY(resident_ground_height(world_resident(world->world)->ground, lattice_offset(at->x), lattice_offset(at->y), &base, &any));
	if (any) {
		point->offset = height->bilinear - lattice_offset_metres(base);
		point->offset = fabs(point->offset) <= OFFSET_NOISE ? 0 : point->offset;
	}
	TRY(world_soil_at(world->world, at->x, at->y, &soil));
	point->soil = soil;
	return STATUS_OK;
}

static enum status points_once(struct furrow_world *world, size_t count, const struct resident_point *at, struct resident_height *heights,
			       struct furrow_point *points)
{
	TRY(api_library_settle(world));
	TRY(world_heights(world->world, at, count, heights));
	for (size_t i = 0; i < count; i++)
		TRY(tell_point(world, &at[i], &heights[i], &points[i]));
	return STATUS_OK;
}

static enum status find_points(struct furrow_world *world, size_t count, const double *xy, struct furrow_point *points)
{
	TRY(api_library_need_count(count, sizeof *points));
	if (count == 0)
		return STATUS_OK;
	TRY(api_library_need(xy, "xy"));
	TRY(api_library_need(points, "points"));
	struct resident_point *at = mem_alloc(count, sizeof *at);
	struct resident_height *heights = mem_alloc(count, sizeof *heights);
	int tries = 0;
	enum status status;
	TRY_OR(done, at != NULL && heights != NULL ? points_of(count, xy, at) : fail_memory("points"));
	do
		status = points_once(world, count, at, heights, points);
	while (api_library_again(world, ++tries, &status));
done:
	mem_free(at);
	mem_free(heights);
	return status;
}

furrow_status furrow_points(struct furrow_world *world, size_t count, const double *xy, struct furrow_point *points)
{
	struct library_call call;
	enum status status;
	TRY_OR(done, api_library_enter(&call, world));
	TRY_OR(done, find_points(world, count, xy, points));
done:
	return api_library_leave(&call, status);
}

static enum status rays_of(size_t count, const double *origin, const double *direction, struct resident_ray *rays)
{
	for (size_t i = 0; i < count; i++, origin += 3, direction += 3) {
		double sum = 0, length = 0;
		for (int k = 0; k < 3; k++) {
			sum += fabs(origin[k]) + fabs(direction[k]);
			length += fabs(direction[k]);
		}
		if (!isfinite(sum) || length == 0)
			return fail_with(STATUS_USAGE, "ray %zu: it is no ray; give finite numbers, and a direction that is not 0", i);
		rays[i] = (struct resident_ray){.length = INFINITY};
		memcpy(rays[i].origin, origin, sizeof rays[i].origin);
		memcpy(rays[i].direction, direction, sizeof rays[i].direction);
	}
	return STATUS_OK;
}

static void tell_hit(const struct resident_hit *from, struct furrow_hit *hit)
{
	*hit = (struct furrow_hit){{NAN, NAN, NAN}, {NAN, NAN, NAN}, NAN, from->hit};
	if (!from->hit)
		return;
	memcpy(hit->position, from->point, sizeof hit->position);
	memcpy(hit->normal, from->normal, sizeof hit->normal);
	hit->distance = from->distance;
}

static enum status rays_once(struct furrow_world *world, size_t count, const struct resident_ray *rays, struct resident_hit *found)
{
	TRY(api_library_settle(world));
	return world_rays(world->world, rays, count, found);
}

static enum status find_hits(struct furrow_world *world, size_t count, const double *origin, const double *direction, struct furrow_hit *hits)
{
	TRY(api_library_need_count(count, sizeof *hits));
	if (count == 0)
		return STATUS_OK;
	TRY(api_library_need(origin, "origin"));
	TRY(api_library_need(direction, "direction"));
	TRY(api_library_need(hits, "hits"));
	struct resident_ray *rays = mem_alloc(count, sizeof *rays);
	struct resident_hit *found = mem_alloc(count, sizeof *found);
	int tries = 0;
	enum status status;
	TRY_OR(done, rays != NULL && found != NULL ? rays_of(count, origin, direction, rays) : fail_memory("rays"));
	do
		status = rays_once(world, count, rays, found);
	while (api_library_again(world, ++tries, &status));
	for (size_t i = 0; i < count && status == STATUS_OK; i++)
		tell_hit(&found[i], &hits[i]);
done:
	mem_free(rays);
	mem_free(found);
	return status;
}

furrow_status furrow_rays(struct furrow_world *world, size_t count, const double *origin, const double *direction, struct furrow_hit *hits)
{
	struct library_call call;
	enum status status;
	TRY_OR(done, api_library_enter(&call, world));
	TRY_OR(done, find_hits(world, count, origin, direction, hits));
done:
	return api_library_leave(&call, status);
}

/* --- posts --- */

#define DISTURBANCE_MOST 255.0

static enum store_layer layer_of(enum furrow_layer layer)
{
	switch (layer) {
	case FURROW_SURFACE:
		break;
	case FURROW_BASE:
		return STORE_BASE;
	case FURROW_OFFSET:
		return STORE_OFFSET;
	case FURROW_DEPOSITED:
		return STORE_DEPOSITED;
	case FURROW_SINKAGE:
		return STORE_PLASTIC_SINKAGE;
	case FURROW_DISTURBANCE:
		return STORE_SOIL;
	case FURROW_BENT:
		return STORE_RISEN;
	case FURROW_TORN:
		return STORE_GROWN;
	case FURROW_SHEAR_X:
		return STORE_SHEAR_EAST;
	case FURROW_SHEAR_Y:
		return STORE_SHEAR_NORTH;
	}
	return STORE_SURFACE;
}

static enum status check_read(const struct furrow_world *world, enum furrow_layer layer, int level, uint32_t columns, uint32_t rows,
			      const double *posts, size_t row_stride)
{
	const int coarsest = extent_coarsest(&world_resident(world->world)->meta->extent);
	TRY(api_library_need(posts, "posts"));
	if ((int)layer < 0 || (int)layer > (int)FURROW_TORN)
		return fail_with(STATUS_USAGE, "layer: %d is none; give one of enum furrow_layer", (int)layer);
	if (level < world_resident(world->world)->level || level > coarsest)
		return fail_with(STATUS_USAGE, "level: %d is not kept; give %d to %d", level, world_resident(world->world)->level, coarsest);
	if (row_stride < columns)
		return fail_with(STATUS_USAGE, "row_stride: %zu posts are less than the %u of a row; give at least as many", row_stride, columns);
	if (row_stride > PTRDIFF_MAX / sizeof *posts / rows)
		return fail_with(STATUS_USAGE, "row_stride: %zu posts in each of %u rows are more than memory has; give those of your array", row_stride,
				 rows);
	return STATUS_OK;
}

static void fill_nan(double *posts, size_t columns, size_t rows, size_t stride)
{
	for (size_t r = 0; r < rows; r++)
		for (size_t c = 0; c < columns; c++)
			posts[r * stride + c] = NAN;
}

/* Makes shares of posts that were read: of disturbance the stored number, of marks that fade when they are gone. healed: the latter of disturbance. */
static void share(const struct furrow_world *world, enum store_layer layer, size_t count, const double *healed, double *values)
{
	const struct plane_marks marks = world_marks_at(world->world, world_time(world->world));
	const enum plane plane = layer == STORE_RISEN ? PLANE_RISEN : layer == STORE_GROWN ? PLANE_GROWN : PLANE_HEALED;
	for (size_t i = 0; i < count; i++) {
		const double until = healed != NULL ? healed[i] : layer == STORE_SOIL ? 0 : values[i];
		const int32_t left = isnan(until) ? 0 : plane_mark_left((int32_t)ldexp(until, PLANE_TIME_BITS), marks.now, plane_mark_whole(&marks, plane));
		const double kept = layer == STORE_SOIL ? fmax(values[i], left) : left;
		values[i] = isnan(values[i]) ? values[i] : kept / DISTURBANCE_MOST;
	}
}

/* Reads posts; marks as shares. others: room for as many. */
static enum status read_part(struct furrow_world *world, enum store_layer layer, int level, struct post_rect part, double *values, double *others)
{
	const bool heals = layer == STORE_SOIL && world_marks_at(world->world, 0).heals > 0;
	TRY(world_read_posts(world->world, layer, level, part, values));
	if (heals)
		TRY(world_read_posts(world->world, STORE_HEALED, level, part, others));
	if (layer == STORE_SOIL || layer == STORE_RISEN || layer == STORE_GROWN)
		share(world, layer, (size_t)(part.x1 - part.x0) * (size_t)(part.y1 - part.y0), heals ? others : NULL, values);
	return STATUS_OK;
}

static enum status read_rows(struct furrow_world *world, enum store_layer layer, int level, struct post_rect rect, double *posts, size_t stride)
{
	const size_t columns = (size_t)(rect.x1 - rect.x0);
	const int64_t at_once = columns < 65536 ? 65536 / (int64_t)columns + 1 : 1; /* rows: a block of memory of about half a MB */
	const int64_t all = rect.y1 - rect.y0;
	const size_t room = (size_t)(at_once < all ? at_once : all) * columns;
	double *values = mem_alloc(2 * room, sizeof *values);
	enum status status;
	TRY_OR(done, values != NULL ? STATUS_OK : fail_memory("posts"));
	for (int64_t y = rect.y0; y < rect.y1; y += at_once) {
		const int64_t end = y + at_once < rect.y1 ? y + at_once : rect.y1;
		TRY_OR(done, read_part(world, layer, level, (struct post_rect){rect.x0, y, rect.x1, end}, values, values + room));
		for (int64_t r = y; r < end; r++)
			memcpy(posts + (size_t)(r - rect.y0) * stride, values + (size_t)(r - y) * columns, columns * sizeof *posts);
	}
done:
	mem_free(values);
	return status;
}

/* rect: the posts that exist; none may. Layers of the soil are kept at the world's own level alone. */
static enum status read_once(struct furrow_world *world, enum store_layer layer, int level, struct post_rect rect, double *posts, size_t stride)
{
	TRY(api_library_settle(world));
	if (post_rect_empty(rect) || (layer >= STORE_DEPOSITED && level != world_resident(world->world)->level))
		return STATUS_OK;
	return read_rows(world, layer, level, rect, posts, stride);
}

static enum status read_posts(struct furrow_world *world, enum furrow_layer layer, int level, int64_t column, int64_t row, uint32_t columns,
			      uint32_t rows, double *posts, size_t row_stride)
{
	if (columns == 0 || rows == 0)
		return STATUS_OK;
	TRY(check_read(world, layer, level, columns, rows, posts, row_stride));
	const enum store_layer kept = layer_of(layer);
	const struct extent *extent = &world_resident(world->world)->meta->extent;
	const struct post_rect all = {0, 0, extent_posts(extent->width, level), extent_posts(extent->height, level)};
	struct post_rect rect = {column, row, column, row};
	/* Posts beyond the terrain do not exist. So a sum that would overflow is never needed. */
	if (column < all.x1 && row < all.y1 && column > -(int64_t)columns && row > -(int64_t)rows)
		rect = post_rect_intersect((struct post_rect){column, row, column + columns, row + rows}, all);
	fill_nan(posts, columns, rows, row_stride);
	double *first = posts + (size_t)(rect.y0 - row) * row_stride + (size_t)(rect.x0 - column);
	int tries = 0;
	enum status status;
	do
		status = read_once(world, kept, level, rect, first, row_stride);
	while (api_library_again(world, ++tries, &status));
	return status;
}

furrow_status furrow_read(struct furrow_world *world, enum furrow_layer layer, int level, int64_t column, int64_t row, uint32_t columns,
			  uint32_t rows, double *posts, size_t row_stride)
{
	struct library_call call;
	enum status status;
	TRY_OR(done, api_library_enter(&call, world));
	TRY_OR(done, read_posts(world, layer, level, column, row, columns, rows, posts, row_stride));
done:
	return api_library_leave(&call, status);
}

static enum status find_changes(struct furrow_world *world, uint64_t since, struct furrow_rect *rects, size_t *count, uint64_t *now)
{
	TRY(api_library_need(count, "count"));
	TRY(api_library_need_count(*count, sizeof *rects));
	if (*count > 0)
		TRY(api_library_need(rects, "rects"));
	TRY(api_library_settle(world));
	struct post_rect *found = *count > 0 ? mem_alloc(*count, sizeof *found) : NULL;
	TRY_MEM(found != NULL || *count == 0, "rectangles");
	uint64_t revision = 0;
	enum status status;
	TRY_OR(done, world_changes_since(world->world, since, found, count, &revision));
	for (size_t i = 0; i < *count; i++)
		rects[i] = (struct furrow_rect){found[i].x0, found[i].y0, found[i].x1 - found[i].x0, found[i].y1 - found[i].y0};
done:
	if (now != NULL)
		*now = revision;
	mem_free(found);
	return status;
}

furrow_status furrow_changes(struct furrow_world *world, uint64_t since, struct furrow_rect *rects, size_t *count, uint64_t *now)
{
	struct library_call call;
	enum status status;
	TRY_OR(done, api_library_enter(&call, world));
	TRY_OR(done, find_changes(world, since, rects, count, now));
done:
	return api_library_leave(&call, status);
}
