/* Bodies of vehicles: their soil geoms. The vehicle computes their forces. */
#include <math.h>

#include "world/internal.h"

#define OWN (WORLD_BODY_NUMBERS - SOIL_TREND_NUMBERS)

void world_body_of_vehicle(struct world *world, int32_t number)
{
	world_body_hosted(world, (size_t)number)->kind = BODY_VEHICLE;
}

enum status world_body_tell(struct world *world, int32_t number, const struct furrow_state *state, const struct world_force *force,
			    double slip)
{
	struct body *body = world_body_hosted(world, (size_t)number);
	enum status status = world_attitude(&body->object->shape, body->object->name, &state->pose, &body->host.shown);
	body->host.force = *force;
	body->host.force.z = body->host.shown.z;
	body->host.slip = slip;
	return status;
}

void world_body_save(const struct world *world, int32_t number, double numbers[WORLD_BODY_NUMBERS])
{
	const struct body *body = world_body_hosted(world, (size_t)number);
	const struct soil_pose *last = &body->last;
	const struct furrow_state *now = &body->host.now;
	const double all[OWN] = {
		body->host.placed, body->has_last, (double)last->x, (double)last->y, (double)last->z, last->yaw, last->pitch, last->roll,
		last->turn, body->host.since, body->distance, body->sinkage, body->host.stamped,
		now->pose.position[0], now->pose.position[1], now->pose.position[2],
		now->pose.orientation[0], now->pose.orientation[1], now->pose.orientation[2], now->pose.orientation[3],
		now->linear[0], now->linear[1], now->linear[2], now->angular[0], now->angular[1], now->angular[2],
	};
	double trend[SOIL_TREND_NUMBERS];
	soil_trend_save(&body->trend, trend);
	for (int i = 0; i < WORLD_BODY_NUMBERS; i++)
		numbers[i] = !body->host.placed ? 0 : i < OWN ? all[i] : trend[i - OWN];
}

enum status world_body_restore(struct world *world, int32_t number, const double numbers[WORLD_BODY_NUMBERS])
{
	struct body *body = world_body_hosted(world, (size_t)number);
	struct soil_pose pose;
	const double *n = numbers;
	if (n[0] == 0) {
		if (!body->host.placed)
			return STATUS_OK;
		/* It was set down since then. What it did to the ground was taken back. */
		body->host.placed = body->has_last = body->host.has_next = false;
		body->host.fresh = true;
		body->trend = (struct soil_trend){.whole = {.ran = 0}};
		world->near.stale = true;
		return STATUS_OK;
	}
	struct furrow_state now = {.pose = {{n[13], n[14], n[15]}, {n[16], n[17], n[18], n[19]}}, .linear = {n[20], n[21], n[22]},
				   .angular = {n[23], n[24], n[25]}};
	if (world_attitude(&body->object->shape, body->object->name, &now.pose, &pose) != STATUS_OK || fabs(n[2]) > 0x1p52 ||
	    fabs(n[3]) > 0x1p52 || fabs(n[4]) > 0x1p52)
		return world_record_damaged(world->facts.path, "where a vehicle is");
	body->host.placed = world->unplaced = true;
	body->has_last = n[1] != 0;
	body->last = (struct soil_pose){(int64_t)n[2], (int64_t)n[3], (int64_t)n[4], n[5], n[6], n[7], n[8]};
	soil_trend_load(n + OWN, &body->trend);
	body->host.since = n[9];
	body->distance = n[10];
	body->sinkage = n[11];
	body->host.stamped = n[12];
	body->host.now = now;
	body->host.belt = (struct furrow_belt){.travel = n[8]};
	world->near.stale = true;
	body->host.has_next = false;
	body->host.fresh = !body->has_last;
	return STATUS_OK;
}
