/*
 * Soil that falls off bodies with `carry`, where the scene has redistribute.thrown: on. What leaves a body high above the ground flies as grains, with the velocity of the body at that
 * place. Grains that come down on a body that carries are aboard then, whoever they come from.
 *
 * Invariants: (1) What left a body is in flight before anything else happens, so a record and a checkpoint never miss it. (2) What a body catches in a tick comes aboard after all grains of
 * it were looked at. So their order does not show.
 */
#include <math.h>

#include "world/internal.h"

#define MOMENT 0x1p-6  /* s over which the velocity of a body on its path is measured */
#define GRAIN_SHARE 0.065 /* of a post's spacing: the height of soil at a post that fills a ball of a quarter of the spacing */

/* Where a body on its path is, and its axes. Without a height of its own its height counts as 0. */
static void path_at(const struct body *body, double time, double place[3], double axes[3][3])
{
	struct track_point point;
	motion_track_at(body->track, time, &point);
	place[0] = point.x;
	place[1] = point.y;
	place[2] = body->object->path.has_z ? point.z : 0;
	soil_axes(point.yaw, point.pitch, point.roll, 0, axes);
}

/* Computes how fast a place of a body moves along its path. from_centre: m. */
static void path_speed(const struct body *body, double time, const double from_centre[3], double speed[3])
{
	double now[3], then[3], axes[3][3], before[3][3], own[3] = {0, 0, 0};
	if (time < MOMENT)
		return;
	path_at(body, time, now, axes);
	path_at(body, time - MOMENT, then, before);
	for (int a = 0; a < 3; a++)
		for (int k = 0; k < 3; k++)
			own[a] += axes[a][k] * from_centre[k];
	for (int k = 0; k < 3; k++)
		speed[k] = (now[k] + from_centre[k] - then[k] - own[0] * before[0][k] - own[1] * before[1][k] - own[2] * before[2][k]) / MOMENT;
}

/* The same for a body that a host moves. */
static void host_speed(const struct body *body, const double from_centre[3], double speed[3])
{
	const double *v = body->host.now.linear, *w = body->host.now.angular, *r = from_centre;
	const double all[3] = {v[0] + w[1] * r[2] - w[2] * r[1], v[1] + w[2] * r[0] - w[0] * r[2], v[2] + w[0] * r[1] - w[1] * r[0]};
	for (int k = 0; k < 3; k++)
		speed[k] = isfinite(all[k]) ? all[k] : 0;
}

struct falling {
	struct world *world;
	const struct body *body;
	const struct soil_pose *pose;
	double time;
};

static void take(void *user, const int64_t from[3], int32_t amount)
{
	const struct falling *falling = user;
	struct world *world = falling->world;
	const double spacing = world->resident.spacing;
	const struct soil_pose *pose = falling->pose;
	const double from_centre[3] = {lattice_offset_metres(from[0] - pose->x), lattice_offset_metres(from[1] - pose->y), lattice_offset_metres(from[2] - pose->z)};
	struct bearing_grain grains[FALL_GRAINS];
	struct bearing_fall fall = {.from = {from[0], from[1], from[2]}, .spread = spacing / 2, .seconds = world->scene->interval, .volume = amount,
				    .most = lattice_offset(GRAIN_SHARE * spacing) + 1};
	if (falling->body->kind == BODY_PATH)
		path_speed(falling->body, falling->time, from_centre, fall.speed);
	else
		host_speed(falling->body, from_centre, fall.speed);
	const int64_t now = llround(falling->time * 0x1p20);
	world_thrown_add(world, grains, (size_t)bearing_fall_grains(&fall, now, grains));
}

void world_falls_take(struct world *world, struct body *body, const struct soil_pose *pose, double time)
{
	if (body == NULL || body->carried == NULL || body->carried->fell_total == 0)
		return;
	struct falling falling = {world, body, pose, time};
	world_thrown_count(world, body->carried->fell_classes);
	soil_carried_fallen(body->carried, pose, take, &falling);
}

/* --- bodies below grains --- */

/* Gives where a body that carries is. Returns false if it cannot catch. */
static bool pose_of(const struct body *body, struct soil_pose *pose)
{
	if (body == NULL || body->carried == NULL || body->carried->fell == NULL || !body->has_last || body->elsewhere || body->host.removed || !body->carried->placed)
		return false;
	*pose = body->last;
	pose->z += body->loaded_body > 0 ? body->raised : 0;
	return true;
}

bool world_falls_caught(struct world *world, const int64_t before[3], const int64_t now[3], int64_t volume)
{
	bool caught = false;
	for (size_t i = 0; i < world->body_count && !caught; i++) {
		struct soil_pose pose;
		caught = pose_of(world->bodies[i], &pose) && soil_carried_catch(world->bodies[i]->carried, &pose, before, now, volume);
	}
	return caught;
}

void world_falls_aboard(struct world *world, int class)
{
	for (size_t i = 0; i < world->body_count; i++)
		if (world->bodies[i] != NULL && world->bodies[i]->carried != NULL)
			soil_carried_keep(world->bodies[i]->carried, class);
}
