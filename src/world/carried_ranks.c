/* Soil aboard bodies goes to other ranks: with its body, for the record, and where each rank moves the body. */
#include <string.h>

#include "world/internal.h"

#define POSE_NUMBERS 5 /* placed, yaw, pitch, roll, turn */

size_t world_carried_moves(const struct world *world, size_t number)
{
	const struct body *body = world_body(world, number);
	return body != NULL && body->carried != NULL ? POSE_NUMBERS + soil_carried_numbers(&body->object->shape, world->resident.spacing) : 0;
}

void world_carried_pack(const struct world *world, size_t number, int64_t *numbers)
{
	const struct soil_carried *from = world_body(world, number)->carried;
	const double pose[] = {from->yaw, from->pitch, from->roll, from->turn};
	numbers[0] = from->placed;
	memcpy(numbers + 1, pose, sizeof pose);
	soil_carried_save(from, numbers + POSE_NUMBERS);
}

enum status world_carried_unpack(struct world *world, size_t number, const int64_t *numbers, bool places)
{
	struct soil_carried *to = world_body(world, number)->carried;
	double pose[POSE_NUMBERS - 1];
	if (!soil_carried_load(numbers + POSE_NUMBERS, to))
		return fail_with(STATUS_FAILED, "ranks: the soil aboard a body that came is damaged; start all ranks with the same version of furrow");
	memcpy(pose, numbers + 1, sizeof pose);
	if (places && numbers[0] != 0)
		soil_carried_place(to, &(struct soil_pose){.yaw = pose[0], .pitch = pose[1], .roll = pose[2], .turn = pose[3]});
	return STATUS_OK;
}

enum status world_carried_tell(const struct world *world)
{
	bool any = false;
	for (size_t i = 0; world->ranks != NULL && i < world->body_count && !any; i++)
		any = world->bodies[i] != NULL && world->bodies[i]->carried != NULL && world->bodies[i]->kind == BODY_VEHICLE;
	return any ? world->ranks->loads(world->ranks->user) : STATUS_OK;
}
