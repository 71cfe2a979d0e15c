/*
 * The list of bodies, by number. Each of the scene's objects gets its path as path samples in local metres, and a place in the record.
 *
 * Invariants:
 * - A body stays where it is in memory until it is freed.
 * - A number is given out once. bodies[number] is NULL for a body that was added and that a rollback removed.
 */
#include <assert.h>
#include <math.h>
#include <stdio.h>

#include "dem/dem.h"
#include "world/internal.h"

#define LEAST_STEP 1e-6 /* s, of a scene's time_step */

/* Puts the scene's line and key before the message of a failed dem_transform from `srs`: `key`, or coordinates if no point is convertible. */
static enum status tell_key(const struct world *world, const char *srs, int line, const char *key, enum status status)
{
	char why[600], at[16] = "";
	snprintf(why, sizeof why, "%s", failure_message());
	if (dem_transform(srs, world->resident.meta->srs, 0, NULL, NULL) != STATUS_OK)
		key = "coordinates";
	else if (line > 0)
		snprintf(at, sizeof at, ":%d", line);
	return fail_with(status, "%s%s: %s: %s", world->scene->file, at, key, why);
}

/* Converts points to local metres, in place: of the globe if `degrees`, otherwise of the scene's coordinates. `line`, `key`: of the scene, for
 * messages; line 0: unknown. */
static enum status to_local(const struct world *world, bool degrees, int line, const char *key, size_t count, double *x, double *y)
{
	const struct scene *scene = world->scene;
	const char *srs = degrees ? DEM_SRS_DEGREES : scene->coordinates == SCENE_SRS ? scene->srs : NULL;
	if (srs != NULL && world->resident.meta->srs[0] == '\0' && degrees)
		return fail_with(STATUS_INPUT, "a path in longitude and latitude: the store has no reference system and lies nowhere on the globe; "
					       "give points in metres, or import again with --s-srs EPSG:..., if its coordinates are of a system");
	if (srs != NULL && world->resident.meta->srs[0] == '\0')
		return fail_with(STATUS_INPUT, "%s: coordinates: %s, but the store has no reference system; take coordinates away, and give paths in metres from "
					       "its south-west post, or import again with --s-srs EPSG:..., if its coordinates are of a system", scene->file, srs);
	enum status status = srs != NULL ? dem_transform(srs, world->resident.meta->srs, count, x, y) : STATUS_OK;
	if (status != STATUS_OK)
		return tell_key(world, srs, line, key, status);
	for (size_t i = 0; i < count && (srs != NULL || scene->coordinates == SCENE_STORE); i++) {
		x[i] -= world->resident.meta->origin[0];
		y[i] -= world->resident.meta->origin[1];
	}
	return status;
}

enum status world_no_ground(const struct world *world, const char *name, bool degrees, double x, double y, double time)
{
	const bool hole = extent_holds(&world->resident.meta->extent, x, y);
	const enum scene_coordinates coordinates = world->scene->coordinates;
	const char *srs = degrees ? DEM_SRS_DEGREES : coordinates == SCENE_SRS ? world->scene->srs : "the store's system";
	char given[160] = "";
	if (degrees || coordinates != SCENE_LOCAL) {
		double east = x + world->resident.meta->origin[0], north = y + world->resident.meta->origin[1];
		if (degrees || coordinates == SCENE_SRS ? dem_transform(world->resident.meta->srs, srs, 1, &east, &north) == STATUS_OK : true)
			snprintf(given, sizeof given, ", which is %.10g, %.10g in %.80s,", east, north, srs);
	}
	return fail_with(STATUS_FAILED, "%s: no ground under it at %.3f, %.3f m%s after %.3f s: it is %s; move its path%s, or set outside: skip", name, x, y, given,
			 time, hole ? "over a hole of the terrain" : "off the terrain", hole ? ", import with holes filled (furrow import --fill)" : "");
}

enum status world_start_point(const struct world *world, const struct scene_vehicle *vehicle, double to[2])
{
	char key[300];
	snprintf(key, sizeof key, "vehicles.%.270s.start.at", vehicle->name);
	to[0] = vehicle->at[0];
	to[1] = vehicle->at[1];
	return to_local(world, false, vehicle->line, key, 1, &to[0], &to[1]);
}

/* Converts the path's points to local metres: points[count][2], whose memory also has room for x and y apart. */
static enum status local_points(const struct world *world, const struct scene_path *path, const char *name, double (*points)[2])
{
	double *x = points[path->count], *y = x + path->count;
	for (size_t i = 0; i < path->count; i++) {
		x[i] = path->points[i].x;
		y[i] = path->points[i].y;
	}
	char key[300];
	snprintf(key, sizeof key, "%.280s: path", name);
	enum status status = to_local(world, path->degrees, path->line, key, path->count, x, y);
	for (size_t i = 0; i < path->count; i++) {
		points[i][0] = x[i];
		points[i][1] = y[i];
	}
	return status;
}

enum status world_route(const struct world *world, const struct scene_path *path, const char *name, struct scene_path *route)
{
	double(*points)[2] = mem_alloc(2 * path->count, sizeof *points);
	TRY_MEM(points, "a path");
	enum status status;
	TRY_OR(done, local_points(world, path, name, points));
	TRY_OR(done, motion_route_create(path, name, (const double(*)[2])points, route));
done:
	mem_free(points);
	return status;
}

/* A step keeps all its path samples in memory, and they cannot be given up between. A host says itself how long a step is. */
static enum status check_samples(const struct world *world, const struct body *body)
{
	const double step = world->scene->time_step, most = motion_track_most(body->track, step);
	char shorter[64] = "";
	double fits = step;
	if (most <= WORLD_SAMPLES_MOST)
		return STATUS_OK;
	while (fits >= LEAST_STEP && motion_track_most(body->track, fits) > WORLD_SAMPLES_MOST)
		fits /= 2;
	if (fits >= LEAST_STEP)
		snprintf(shorter, sizeof shorter, "a time_step of %s or less, ", number_at_most(fits, 3).text);
	return fail_with(STATUS_INPUT, "objects.%s.path: %.3g path samples are due in one step of %g s, and %d is the most; give %s%s, or a coarser spacing than %g m",
			 body->object->name, most, step, WORLD_SAMPLES_MOST, shorter, body->object->path.timed ? "its rows more time" : "less speed", world->resident.spacing);
}

static enum status make_track(const struct world *world, struct body *body)
{
	const struct soil_shape *shape = &body->object->shape;
	const double turn_reach = shape->kind == SOIL_WHEEL ? shape->radius : soil_shape_bound(shape);
	struct scene_path route;
	enum status status = world_route(world, &body->object->path, body->object->name, &route);
	if (status != STATUS_OK)
		return status;
	status = motion_track_create(&route, world->resident.spacing, turn_reach, &body->track);
	motion_route_finish(&route);
	return status == STATUS_OK && !world->scene->hosted ? check_samples(world, body) : status;
}

/* --- the list --- */

const struct body *world_body(const struct world *world, size_t number)
{
	return world_body_at(world, number);
}

struct body *world_body_at(const struct world *world, size_t number)
{
	if (number == WORLD_DROPPED)
		return world->dropping;
	return number < world->body_count ? world->bodies[number] : NULL;
}

size_t world_body_count(const struct world *world)
{
	return world->body_count;
}

bool world_follows_path(const struct world *world, size_t number)
{
	const struct body *body = world_body(world, number);
	return body != NULL && body->kind == BODY_PATH;
}

static enum status make_room(struct world *world)
{
	if (world->body_count < world->body_room)
		return STATUS_OK;
	if (world->body_count >= INT32_MAX / 2)
		return fail_with(STATUS_FAILED, "bodies: too many were added; close the world and open it again");
	const size_t room = mem_room(world->body_room, world->body_count + 1);
	TRY(mem_resize(&world->bodies, room, sizeof *world->bodies, "a body"));
	TRY(mem_resize(&world->relaxation.rests, room, sizeof *world->relaxation.rests, "a body"));
	world->body_room = room;
	return STATUS_OK;
}

enum status world_list_body(struct world *world, enum body_kind kind, const struct scene_object *object, struct scene_object *owned)
{
	TRY(make_room(world));
	struct body *body = mem_calloc(1, sizeof *body);
	TRY_MEM(body, "a body");
	body->kind = kind;
	body->object = object;
	body->host.owned = owned;
	if (world_is_hosted(body)) {
		body->host.stamped = 1;
		for (int i = 0; i < 3; i++)
			body->host.now.pose.position[i] = NAN;
	}
	world->bodies[world->body_count++] = body;
	return STATUS_OK;
}

enum status world_make_bodies(struct world *world)
{
	const struct scene *scene = world->scene;
	const size_t carried = world_carried_numbers(world), grains = world_grains_most(world);
	TRY(mem_zeroed(&world->record, 1, world_record_bytes_with(scene->object_count, world->params.attached) + carried * sizeof(int64_t) + grains * sizeof(struct bearing_grain), "the objects"));
	world->record->attached_count = world->params.attached;
	world->record->carried_count = carried;
	world->record->thrown.room = grains;
	TRY(world_thrown_make(world));
	uint32_t loaded_bodies = 0;
	for (size_t i = 0; i < scene->object_count; i++) {
		const struct scene_object *object = &scene->objects[i];
		TRY(world_list_body(world, object->path.count == 0 ? BODY_HOST : BODY_PATH, object, NULL));
		TRY(soil_shape_check(&object->shape, world->resident.spacing));
		TRY(world_carried_make(world, world->bodies[i]));
		if (object->path.count == 0)
			continue;
		world->bodies[i]->loaded_body = object->load > 0 ? ++loaded_bodies : 0;
		TRY(make_track(world, world->bodies[i]));
	}
	world_carried_record(world, world->record);
	return STATUS_OK;
}

void world_body_free(struct body *body)
{
	if (body == NULL)
		return;
	motion_track_destroy(body->track);
	soil_carried_destroy(body->carried);
	if (body->host.owned != NULL)
		scene_object_finish(body->host.owned);
	mem_free_all(body->host.owned, body);
}

void world_free_bodies(struct world *world)
{
	for (size_t i = 0; i < world->body_count; i++)
		world_body_free(world->bodies[i]);
	world->body_count = 0;
	world_names_free(world);
	world_thrown_free(world->thrown);
	world->thrown = NULL;
	mem_free_all(world->bodies, world->relaxation.rests, world->record);
}

void world_place(const struct world *world, size_t body, double place[3], double *yaw)
{
	const struct scene_path *path = &world->bodies[body]->object->path;
	struct track_point point;
	int64_t height;
	bool any;
	assert(body < world->scene->object_count);
	motion_track_at(world->bodies[body]->track, world->time, &point);
	place[0] = point.x;
	place[1] = point.y;
	place[2] = path->has_z ? point.z : world->resident.meta->low;
	if (resident_ground_height(world->resident.ground, point.qx, point.qy, &height, &any) == STATUS_OK && any)
		place[2] = fmax(lattice_offset_metres(height), path->has_z ? point.z : -INFINITY);
	*yaw = point.yaw;
}
