/*
 * Bodies that a window drops, between two steps. A body that is no part of the scene is set down once and taken away. It uses
 * the same contact as a path sample (contact.c). This is committed as a step is. The body is no larger than the scene's first
 * object, so the budget holds for it too.
 */
#include <math.h>

#include "world/internal.h"

/* A ball of a size whose print can be seen. */
#define BALL_RADIUS 0.5 /* m, or */
#define BALL_POSTS 4    /* of the working level, whichever is more */
#define SINK_SHARE 0.3  /* share of the height below its centre, if the scene gives no depth */

static struct scene_object dropped(const struct world *world, enum world_drop_shape shape)
{
	struct scene_object object = world->scene->objects[0];
	double bound = soil_shape_bound(&object.shape);
	if (shape == WORLD_DROP_BALL)
		object.shape = (struct soil_shape){
			.kind = SOIL_SPHERE,
			.radius = fmin(fmax(BALL_RADIUS, BALL_POSTS * world->resident.spacing), bound),
		};
	double reach = soil_shape_reach(&object.shape, 0, 0);
	if (!(object.sink > 0) || object.sink > reach)
		object.sink = SINK_SHARE * reach;
	return object;
}

enum status world_warm_drops(struct world *world)
{
	if (!world->params.drops || world->scene->object_count == 0 || world->deform == NULL)
		return STATUS_OK;
	const struct scene_object object = dropped(world, WORLD_DROP_BALL);
	const struct deform_planned planned = {&object.shape, false, false};
	return deform_warm(world->deform, &planned);
}

/* Finds the ground that it is set upon, as it is now, with ruts. */
static enum status surface(struct world *world, double x, double y, int64_t *height, bool *any)
{
	const struct resident_point point = {x, y};
	struct resident_height found = {.bilinear = NAN};
	*any = false;
	TRY(world_heights(world, &point, 1, &found));
	*any = !isnan(found.bilinear);
	if (*any)
		*height = lattice_offset(found.bilinear);
	return STATUS_OK;
}

/* Several drops at one place go deeper than any object of the scene. Bounding boxes of tiles must include this. */
static enum status tell_reach(struct world *world, const struct event *event, int64_t height, const struct soil_shape *shape)
{
	int64_t base;
	bool any;
	TRY(resident_ground_height(world->resident.ground, event->pose.x, event->pose.y, &base, &any));
	if (any)
		world_happened_reach(world, fabs(lattice_offset_metres(height - base)) + event->sinkage + 2 * soil_shape_bound(shape));
	return STATUS_OK;
}

/* Between steps the drive is consistent; during a drop it is not. */
static enum status touch(struct world *world, const struct event *event)
{
	world_tear(world);
	world->near.stale = true;
	TRY(world_contact(world, event));
	TRY(world_meetings_flush(world));
	TRY(world_let_go(world, world->dropping));
	return world_end_change(world);
}

enum status world_drop(struct world *world, enum world_drop_shape shape, double x, double y, double yaw, bool *landed)
{
	*landed = false;
	if (world->scene->object_count == 0)
		return STATUS_OK;
	const struct scene_object object = world->dropped = dropped(world, shape);
	struct body body = {.kind = BODY_DROPPED, .object = &world->dropped};
	struct event event = {
		.body = WORLD_DROPPED,
		.time = world->time,
		.contact = true,
		.next_time = INFINITY,
	};
	int64_t height = 0;
	enum status status = surface(world, x, y, &height, landed);
	if (status != STATUS_OK || !*landed)
		return status;
	event.pose = (struct soil_pose){.x = lattice_offset(x), .y = lattice_offset(y), .yaw = yaw};
	double reach = soil_shape_reach(&object.shape, 0, 0);
	double sink = scene_sinkage_guess(world->scene, &object);
	event.pose.z = height + lattice_offset(reach - sink);
	event.sinkage = sink;
	world->dropping = &body;
	status = tell_reach(world, &event, height, &object.shape);
	if (status == STATUS_OK)
		status = touch(world, &event);
	world->dropping = NULL;
	world->counts.drops++;
	return status;
}
