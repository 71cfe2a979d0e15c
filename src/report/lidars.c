/*
 * Lidars: ranges along rays over the ground, vehicles and objects. For each a folder lidars/NAME with
 *
 *     lidar.json   what it is, and the angles of its rays
 *     poses.tum    where it was at each frame
 *     000000.npy   a frame: float32, rows x columns, m; the highest row first. inf: nothing in its range; nan: dropped
 *
 * All rays of a frame are of one time. Noise and dropouts follow from the seed, the lidar's name, the frame and the ray alone.
 */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/aside.h"
#include "base/json.h"
#include "base/limits.h"
#include "base/noise.h"
#include "report/poses.h"
#include "report/ray_shapes.h"
#include "report/rows_file.h"
#include "report/sensors.h"

#define PATH 4400 /* bytes */
#define HEADER "# timestamp tx ty tz qx qy qz qw\n"

struct lidar {
	const struct scene_lidar *scene;
	FILE *poses;
};

/* An object of the scene, where it is in a frame. */
struct thing {
	const struct soil_shape *shape;
	double at[3], axes[3][3], bound;
};

struct report_lidars {
	struct world *world;
	struct vehicles *vehicles; /* NULL: none */
	const char *directory;
	struct lidar *list;
	size_t count;
	struct thing *things;
	size_t thing_count;
	struct resident_ray *rays;
	struct resident_hit *hits;
	struct vehicle_ray *bodies;
	float *ranges;
};

static void path_of(const struct report_lidars *lidars, const struct scene_lidar *lidar, const char *name, char path[PATH])
{
	snprintf(path, PATH, "%s/" REPORT_LIDARS "/%s/%s", lidars->directory, lidar->name, name);
}

static enum status failed(const char *path)
{
	return fail_with(STATUS_FAILED, "%s: %s; %s", path, input_problem(), limits_advice(errno, "give a folder that can be written"));
}

/* --- rays --- */

/* Radians, from forward to the left. Around the whole circle, the last column is not the first one again. */
static double azimuth_of(const struct scene_lidar *lidar, int column)
{
	const bool whole = lidar->fov[0] >= 2 * M_PI * (1 - 1e-12);
	const int steps = whole ? lidar->columns : lidar->columns - 1;
	return steps > 0 ? -lidar->fov[0] / 2 + lidar->fov[0] * column / steps : 0;
}

/* Returns the angle of a row's rays above the lidar's plane, rad. Row 0 is the highest. */
static double elevation_of(const struct scene_lidar *lidar, int row)
{
	return lidar->rows > 1 ? lidar->fov[1] / 2 - lidar->fov[1] * row / (lidar->rows - 1) : 0;
}

/* The place and the axes forward, left, up of a lidar now. */
static void stand(const struct report_lidars *lidars, const struct scene_lidar *lidar, double at[3], double axes[3][3])
{
	double own[3][3], of[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, origin[3] = {0, 0, 0};
	soil_axes(lidar->yaw, lidar->pitch, lidar->roll, 0, own);
	if (lidar->vehicle > 0)
		vehicle_frame(lidars->vehicles, (size_t)lidar->vehicle - 1, lidar->body, origin, of);
	for (int i = 0; i < 3; i++) {
		at[i] = origin[i] + of[3 * i] * lidar->at[0] + of[3 * i + 1] * lidar->at[1] + of[3 * i + 2] * lidar->at[2];
		for (int a = 0; a < 3; a++)
			axes[a][i] = of[3 * i] * own[a][0] + of[3 * i + 1] * own[a][1] + of[3 * i + 2] * own[a][2];
	}
}

static enum status find_things(struct report_lidars *lidars)
{
	const struct scene *scene = world_scene(lidars->world);
	lidars->thing_count = 0;
	for (size_t i = 0; i < scene->object_count; i++) {
		const struct body *body = world_body(lidars->world, i);
		struct thing *thing = &lidars->things[lidars->thing_count];
		struct track_point point;
		int64_t height;
		bool known;
		if (body == NULL || body->track == NULL)
			continue;
		motion_track_at(body->track, world_time(lidars->world), &point);
		TRY(render_object_height(lidars->world, body, &point, &height, &known));
		if (!known)
			continue;
		*thing = (struct thing){.shape = &scene->objects[i].shape, .at = {point.x, point.y, lattice_offset_metres(height)}, .bound = soil_shape_bound(&scene->objects[i].shape)};
		soil_axes(point.yaw, thing->shape->kind != SOIL_WHEEL ? point.pitch : 0, point.roll, 0, thing->axes);
		lidars->thing_count++;
	}
	return STATUS_OK;
}

static double to_things(const struct report_lidars *lidars, const double origin[3], const double way[3])
{
	double first = INFINITY;
	for (size_t i = 0; i < lidars->thing_count; i++) {
		const struct thing *thing = &lidars->things[i];
		const double between[3] = {origin[0] - thing->at[0], origin[1] - thing->at[1], origin[2] - thing->at[2]};
		double from[3], along[3], square = 0, across = 0;
		for (int a = 0; a < 3; a++) {
			from[a] = between[0] * thing->axes[a][0] + between[1] * thing->axes[a][1] + between[2] * thing->axes[a][2];
			along[a] = way[0] * thing->axes[a][0] + way[1] * thing->axes[a][1] + way[2] * thing->axes[a][2];
			square += from[a] * from[a];
			across += from[a] * along[a];
		}
		if (square - across * across <= thing->bound * thing->bound) /* the ray passes its ball */
			first = fmin(first, report_ray_shape(thing->shape, from, along));
	}
	return first;
}

static enum status measure(struct report_lidars *lidars, const struct scene_lidar *lidar, const double at[3], double axes[3][3], int64_t frame)
{
	const size_t count = (size_t)lidar->columns * (size_t)lidar->rows;
	for (size_t i = 0; i < count; i++) {
		const double azimuth = azimuth_of(lidar, (int)(i % (size_t)lidar->columns)), elevation = elevation_of(lidar, (int)(i / (size_t)lidar->columns));
		const double own[3] = {cos(elevation) * cos(azimuth), cos(elevation) * sin(azimuth), sin(elevation)};
		struct resident_ray *ray = &lidars->rays[i];
		*ray = (struct resident_ray){.origin = {at[0], at[1], at[2]}, .length = lidar->farthest};
		for (int k = 0; k < 3; k++)
			ray->direction[k] = own[0] * axes[0][k] + own[1] * axes[1][k] + own[2] * axes[2][k];
		memcpy(lidars->bodies[i].origin, ray->origin, sizeof ray->origin);
		memcpy(lidars->bodies[i].way, ray->direction, sizeof ray->direction);
	}
	TRY(world_rays(lidars->world, lidars->rays, count, lidars->hits));
	TRY(vehicle_rays(lidars->vehicles, lidar->vehicle > 0 ? (size_t)lidar->vehicle - 1 : SIZE_MAX, lidar->body, lidars->bodies, count));
	TRY(find_things(lidars));
	const uint64_t stream = noise_stream(noise_stream(world_scene(lidars->world)->noise_seed, "lidar"), lidar->name), drops = noise_stream(stream, "dropout");
	for (size_t i = 0; i < count; i++) {
		const uint64_t number = (uint64_t)frame * count + i;
		double range = fmin(lidars->hits[i].hit ? lidars->hits[i].distance : INFINITY, lidars->bodies[i].distance);
		range = fmin(range, to_things(lidars, lidars->rays[i].origin, lidars->rays[i].direction));
		if (!(range >= lidar->nearest && range <= lidar->farthest))
			range = INFINITY;
		else if (lidar->noise > 0)
			range = fmax(range + lidar->noise * noise_normal(stream, number), 0);
		if (lidar->dropout > 0 && noise_even(drops, number) < lidar->dropout)
			range = (double)NAN;
		/* the writer wants the lowest row first, as of a picture */
		lidars->ranges[(size_t)(lidar->rows - 1) * (size_t)lidar->columns - i + 2 * (i % (size_t)lidar->columns)] = (float)range;
	}
	return STATUS_OK;
}

/* --- files --- */

static enum status write_pose(const struct report_lidars *lidars, const struct lidar *lidar, const double at[3], double axes[3][3])
{
	double q[4];
	char path[PATH];
	report_quaternion(axes, q);
	if (fprintf(lidar->poses, "%.9f %.9f %.9f %.9f %.12f %.12f %.12f %.12f\n", world_time(lidars->world), at[0], at[1], at[2], q[0], q[1], q[2], q[3]) > 0 && fflush(lidar->poses) == 0)
		return STATUS_OK;
	path_of(lidars, lidar->scene, "poses.tum", path);
	return failed(path);
}

static enum status write_frame(struct report_lidars *lidars, const struct lidar *lidar, int64_t frame)
{
	const struct scene_lidar *scene = lidar->scene;
	double at[3], axes[3][3];
	char path[PATH], name[40];
	stand(lidars, scene, at, axes);
	TRY(measure(lidars, scene, at, axes, frame));
	snprintf(name, sizeof name, "%06lld.npy", (long long)frame);
	path_of(lidars, scene, name, path);
	TRY(render_npy_write(path, &(struct render_array){.values = lidars->ranges, .width = (uint32_t)scene->columns, .height = (uint32_t)scene->rows, .channels = 1, .kind = 'f', .bytes = 4}));
	return write_pose(lidars, lidar, at, axes);
}

enum status report_lidars_write(struct report_lidars *lidars)
{
	for (size_t i = 0; lidars != NULL && i < lidars->count; i++) {
		const int64_t frame = scene_frame_at(lidars->list[i].scene->rate, world_scene(lidars->world)->time_step, world_steps_done(lidars->world));
		if (frame >= 0)
			TRY(write_frame(lidars, &lidars->list[i], frame));
	}
	return STATUS_OK;
}

void report_lidar_add(struct cJSON *to, const struct scene *scene, const struct scene_lidar *lidar)
{
	double own[3][3], q[4];
	soil_axes(lidar->yaw, lidar->pitch, lidar->roll, 0, own);
	report_quaternion(own, q);
	cJSON_AddStringToObject(to, "name", lidar->name);
	if (lidar->vehicle > 0)
		cJSON_AddStringToObject(to, "on", scene->vehicles[lidar->vehicle - 1].name);
	if (lidar->body != NULL)
		cJSON_AddStringToObject(to, "body", lidar->body);
	json_numbers(to, "position", lidar->at, 3);
	json_numbers(to, "orientation", q, 4);
	json_integer(to, "columns", lidar->columns);
	json_integer(to, "rows", lidar->rows);
	json_number(to, "rate", lidar->rate);
	json_number(to, "nearest", lidar->nearest);
	json_number(to, "farthest", lidar->farthest);
	json_number(to, "noise", lidar->noise);
	json_number(to, "dropout", lidar->dropout);
	json_integer(to, "noise_seed", scene->noise_seed);
}

static enum status write_json(const struct report_lidars *lidars, const struct scene_lidar *lidar)
{
	char path[PATH];
	struct aside aside;
	cJSON *root = cJSON_CreateObject();
	TRY_MEM(root, "lidar.json");
	report_lidar_add(root, world_scene(lidars->world), lidar);
	cJSON *azimuths = cJSON_AddArrayToObject(root, "azimuths"), *elevations = cJSON_AddArrayToObject(root, "elevations");
	for (int i = 0; i < lidar->columns; i++)
		cJSON_AddItemToArray(azimuths, cJSON_CreateNumber(azimuth_of(lidar, i)));
	for (int i = 0; i < lidar->rows; i++)
		cJSON_AddItemToArray(elevations, cJSON_CreateNumber(elevation_of(lidar, i)));
	char *text = json_text(root);
	cJSON_Delete(root);
	TRY_MEM(text, "lidar.json");
	path_of(lidars, lidar, "lidar.json", path);
	enum status status = aside_begin(&aside, path);
	if (status == STATUS_OK) {
		fprintf(aside.file, "%s\n", text); /* a failure returns when the file is completed */
		status = aside_end(&aside, false, STATUS_OK);
	}
	cJSON_free(text);
	return status;
}

/* --- life --- */

static enum status make_folder(const char *path)
{
	return mkdir(path, 0777) == 0 || errno == EEXIST ? STATUS_OK : failed(path);
}

static enum status open_one(const struct report_lidars *lidars, struct lidar *lidar)
{
	char path[PATH];
	path_of(lidars, lidar->scene, "", path);
	TRY(make_folder(path));
	TRY(write_json(lidars, lidar->scene));
	path_of(lidars, lidar->scene, "poses.tum", path);
	return report_rows_file_open(lidars->world, path, HEADER, true, &lidar->poses, NULL);
}

static enum status open_all(struct report_lidars *lidars, const struct scene *scene)
{
	char path[PATH];
	size_t most = 0;
	snprintf(path, sizeof path, "%s/" REPORT_LIDARS, lidars->directory);
	TRY(make_folder(path));
	TRY(mem_zeroed(&lidars->list, scene->lidar_count, sizeof *lidars->list, "the lidars"));
	TRY(mem_zeroed(&lidars->things, scene->object_count + 1, sizeof *lidars->things, "the lidars"));
	for (size_t i = 0; i < scene->lidar_count; i++) {
		const size_t rays = (size_t)scene->lidars[i].columns * (size_t)scene->lidars[i].rows;
		most = rays > most ? rays : most;
		lidars->list[lidars->count++].scene = &scene->lidars[i];
		TRY(open_one(lidars, &lidars->list[i]));
	}
	TRY(mem_make(&lidars->rays, most, sizeof *lidars->rays, "the lidars"));
	TRY(mem_make(&lidars->hits, most, sizeof *lidars->hits, "the lidars"));
	TRY(mem_zeroed(&lidars->bodies, most, sizeof *lidars->bodies, "the lidars"));
	return mem_make(&lidars->ranges, most, sizeof *lidars->ranges, "the lidars");
}

enum status report_lidars_open(struct world *world, struct vehicles *vehicles, const char *directory, struct report_lidars **out)
{
	*out = NULL;
	if (world_scene(world)->lidar_count == 0)
		return STATUS_OK;
	struct report_lidars *lidars = mem_calloc(1, sizeof *lidars);
	TRY_MEM(lidars, "the lidars");
	*lidars = (struct report_lidars){.world = world, .vehicles = vehicles, .directory = directory};
	const enum status status = open_all(lidars, world_scene(world));
	if (status == STATUS_OK)
		*out = lidars;
	else
		report_lidars_close(lidars);
	return status;
}

void report_lidars_close(struct report_lidars *lidars)
{
	if (lidars == NULL)
		return;
	for (size_t i = 0; i < lidars->count; i++)
		if (lidars->list[i].poses != NULL)
			fclose(lidars->list[i].poses);
	mem_free_all(lidars->list, lidars->things, lidars->rays, lidars->hits, lidars->bodies, lidars->ranges, lidars);
}
