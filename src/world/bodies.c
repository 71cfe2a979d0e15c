/* Makes the bodies: each gets its path as path samples in local metres, and a place in the record. */
#include <assert.h>
#include <math.h>

#include "dem/dem.h"
#include "world/internal.h"

enum status world_local_point(const struct world *world, const double from[2], double to[2])
{
	const struct scene *scene = world->scene;
	to[0] = from[0];
	to[1] = from[1];
	if (scene->coordinates == SCENE_SRS) {
		if (world->meta->srs[0] == '\0')
			return fail_with(STATUS_INPUT, "coordinates: %s, but the store has no reference system; use local", scene->srs);
		enum status status = dem_transform(scene->srs, world->meta->srs, 1, &to[0], &to[1]);
		if (status != STATUS_OK)
			return status;
	}
	if (scene->coordinates != SCENE_LOCAL) {
		to[0] -= world->meta->origin[0];
		to[1] -= world->meta->origin[1];
	}
	return STATUS_OK;
}

/* Turns the whole path about its first point, and moves it. Quarter turns are exact. */
static void move_points(const struct scene_path *path, double (*points)[2])
{
	const double quarters = path->rotate / (M_PI / 2), first[2] = {points[0][0], points[0][1]};
	double c = cos(path->rotate), s = sin(path->rotate);
	if (fabs(quarters - round(quarters)) < 1e-12) {
		c = round(c);
		s = round(s);
	}
	for (size_t i = 0; i < path->count; i++) {
		const double x = points[i][0] - first[0], y = points[i][1] - first[1];
		points[i][0] = first[0] + (c * x - s * y) + path->offset[0];
		points[i][1] = first[1] + (s * x + c * y) + path->offset[1];
	}
}

/* Converts the path's points to local metres. */
static enum status local_points(const struct world *world, const struct scene_path *path, double (*points)[2])
{
	for (size_t i = 0; i < path->count; i++) {
		enum status status = world_local_point(world, (const double[]){path->points[i].x, path->points[i].y}, points[i]);
		if (status != STATUS_OK)
			return status;
	}
	if (path->rotate != 0 || path->offset[0] != 0 || path->offset[1] != 0)
		move_points(path, points);
	return STATUS_OK;
}

enum status world_make_bodies(struct world *world)
{
	const struct scene *scene = world->scene;
	world->bodies = mem_calloc(scene->object_count + 1, sizeof *world->bodies);
	world->relaxation.rests = mem_calloc(scene->object_count + 1, sizeof *world->relaxation.rests);
	world->record = mem_calloc(1, world_record_bytes_with(scene->object_count, world->params.attached.count));
	if (world->bodies == NULL || world->relaxation.rests == NULL || world->record == NULL)
		return fail_memory("the objects");
	world->record->attached_count = world->params.attached.count;
	uint32_t loaded_bodies = 0;
	for (size_t i = 0; i < scene->object_count; i++) {
		struct body *body = &world->bodies[i];
		body->object = &scene->objects[i];
		body->loaded_body = body->object->load > 0 ? ++loaded_bodies : 0;
		if (body->object->path.count == 0) { /* the host's */
			enum status fits = deform_shape_check(&body->object->shape, world->spacing);
			if (fits != STATUS_OK)
				return fits;
			continue;
		}
		const struct deform_shape *shape = &body->object->shape;
		const struct scene_path *path = &body->object->path;
		enum status status = deform_shape_check(shape, world->spacing);
		double(*points)[2] = mem_alloc(path->count, sizeof *points);
		if (status == STATUS_OK && points == NULL)
			status = fail_memory("a path");
		if (status == STATUS_OK)
			status = local_points(world, path, points);
		double turn_reach = shape->kind == DEFORM_WHEEL ? shape->radius : deform_shape_bound(shape);
		if (status == STATUS_OK)
			status = motion_track_create(path, (const double(*)[2])points, world->spacing, turn_reach, &body->track);
		mem_free(points);
		if (status != STATUS_OK)
			return status;
	}
	return world_make_hosts(world);
}

void world_free_bodies(struct world *world)
{
	world_free_hosts(world);
	for (size_t i = 0; world->bodies != NULL && i < world->scene->object_count; i++)
		motion_track_destroy(world->bodies[i].track);
	mem_free(world->bodies);
	mem_free(world->relaxation.rests);
	mem_free(world->record);
}

void world_place(const struct world *world, size_t body, double place[3], double *yaw)
{
	const struct scene_path *path = &world->bodies[body].object->path;
	struct track_point point;
	int64_t height;
	bool any;
	assert(body < world->scene->object_count);
	motion_track_at(world->bodies[body].track, world->time, &point);
	place[0] = point.x;
	place[1] = point.y;
	place[2] = path->has_z ? point.z : world->meta->low;
	if (resident_ground_height(world->ground, point.qx, point.qy, &height, &any) == STATUS_OK && any)
		place[2] = fmax(lattice_offset_metres(height), path->has_z ? point.z : -INFINITY);
	*yaw = point.yaw;
}
