/* The state of vehicles as numbers of the run's record, so that a resumed drive goes on to the same bits. */
#include <math.h>
#include <string.h>

#include "vehicle/internal.h"
#include "vehicle/settle.h"
#include "vehicle/start.h"

#define OWN 16       /* numbers of a vehicle itself, */
#define TRAIL (2 + 2 * VEHICLE_TRAIL) /* of its trail, */
#define GEOM_OWN 19  /* of a soil geom, without its body in the world */

size_t vehicle_state_numbers(const struct vehicle *vehicle)
{
	const struct owned *own = &vehicle->own;
	return OWN + TRAIL + vehicle_lies_numbers(vehicle) + range_count(own->qpos) + 2 * range_count(own->dof) + range_count(own->act) + vehicle->geom_count * (GEOM_OWN + WORLD_BODY_NUMBERS);
}

static double *put(double *to, const double *from, size_t count)
{
	if (count > 0)
		memcpy(to, from, count * sizeof *to);
	return to + count;
}

static const double *take(const double *from, double *to, size_t count)
{
	if (count > 0)
		memcpy(to, from, count * sizeof *to);
	return from + count;
}

static double *save_geom(const struct world *world, const struct soil_geom *geom, double *to)
{
	const struct furrow_state *touched = &geom->touched;
	*to++ = geom->is_touched;
	*to++ = geom->touched_belt.travel;
	*to++ = geom->work;
	to = put(to, touched->pose.position, 3);
	to = put(to, touched->pose.orientation, 4);
	to = put(to, touched->linear, 3);
	to = put(to, touched->angular, 3);
	to = put(to, geom->mean, 3);
	world_body_save(world, geom->number, to);
	return to + WORLD_BODY_NUMBERS;
}

/* Places that are not used are 0. */
static double *save_trail(const struct trail *trail, double *to)
{
	*to++ = (double)trail->count;
	*to++ = trail->apart;
	for (size_t i = 0; i < VEHICLE_TRAIL; i++)
		for (int k = 0; k < 2; k++)
			*to++ = i < trail->count ? trail->places[i][k] : 0;
	return to;
}

static double *save_one(const struct vehicles *vehicles, const struct vehicle *vehicle, double *to)
{
	const struct owned *owned = &vehicle->own;
	const mjData *data = vehicle->data;
	const struct driver *driver = &vehicle->driver;
	const double own[OWN] = {vehicle->checksum[0], vehicle->checksum[1], vehicle->begun, vehicle->settle_seconds, vehicle->calm,
				 vehicle->work, vehicle->distance, vehicle->slow, vehicle->origin[2], vehicle->lift, data->time, driver->at,
				 driver->sum, driver->arrived, driver->speed, driver->turn};
	to = put(to, own, OWN);
	to = save_trail(&vehicle->trail, to);
	to = vehicle_save_lies(vehicle, to);
	to = put(to, data->qpos + owned->qpos.first, range_count(owned->qpos));
	to = put(to, data->qvel + owned->dof.first, range_count(owned->dof));
	to = put(to, data->qacc_warmstart + owned->dof.first, range_count(owned->dof));
	to = put(to, data->act + owned->act.first, range_count(owned->act));
	for (size_t g = 0; g < vehicle->geom_count; g++)
		to = save_geom(vehicles->world, &vehicle->geoms[g], to);
	return to;
}

void vehicle_save(const struct vehicles *vehicles, double *numbers)
{
	for (size_t v = 0; v < vehicles->count; v++)
		numbers = save_one(vehicles, &vehicles->list[v], numbers);
}

static enum status damaged(const struct vehicles *vehicles, const struct vehicle *vehicle, const char *why)
{
	return fail_with(STATUS_INPUT, "%s: what its last drive left to go on from does not fit vehicles.%s: %s; drive without --resume",
			 world_facts(vehicles->world)->path, vehicle->scene->name, why);
}

static enum status restore_geom(struct vehicles *vehicles, struct soil_geom *geom, const double **from)
{
	struct furrow_state *touched = &geom->touched;
	geom->is_touched = *(*from)++ != 0;
	geom->touched_belt.travel = *(*from)++;
	geom->work = *(*from)++;
	*from = take(*from, touched->pose.position, 3);
	*from = take(*from, touched->pose.orientation, 4);
	*from = take(*from, touched->linear, 3);
	*from = take(*from, touched->angular, 3);
	*from = take(*from, geom->mean, 3);
	geom->contact = world_contact_unknown();
	enum status status = world_body_restore(vehicles->world, geom->number, *from);
	geom->aloft = !geom->stands && **from == 0;
	*from += WORLD_BODY_NUMBERS;
	return status;
}

/* Returns false if it is none. */
static bool restore_trail(struct trail *trail, const double *from)
{
	if (!(from[0] >= 0 && from[0] <= VEHICLE_TRAIL && from[0] == floor(from[0]) && from[1] >= 0))
		return false;
	trail->count = (size_t)from[0];
	trail->apart = from[1];
	memcpy(trail->places, from + 2, sizeof trail->places);
	return true;
}

static enum status restore_one(struct vehicles *vehicles, struct vehicle *vehicle, const double **numbers)
{
	const struct owned *owned = &vehicle->own;
	mjData *data = vehicle->data;
	struct driver *driver = &vehicle->driver;
	const double *n = *numbers, *from = n + OWN + TRAIL;
	if (n[0] != vehicle->checksum[0] || n[1] != vehicle->checksum[1])
		return damaged(vehicles, vehicle, "its model is another one now, or was read by another MuJoCo");
	if (!restore_trail(&vehicle->trail, n + OWN) || !(n[2] >= 0 && n[2] <= VEHICLE_DRIVES) || !(n[11] >= 0 && n[11] <= fmax((double)driver->point_count - 1, 0)))
		return damaged(vehicles, vehicle, "numbers out of range");
	const bool is_placed = vehicle->begun > 0; /* it goes back to a checkpoint: its model is turned and lifted already */
	vehicle->begun = n[2];
	vehicle->settle_seconds = n[3];
	vehicle->calm = n[4];
	vehicle->work = n[5];
	vehicle->distance = n[6];
	vehicle->slow = n[7];
	vehicle->origin[2] = n[8];
	vehicle->lift = n[9];
	driver->at = n[11];
	driver->sum = n[12];
	driver->arrived = n[13] != 0;
	driver->speed = n[14];
	driver->turn = n[15];
	from = vehicle_restore_lies(vehicle, from);
	if (vehicle->begun > 0 && !is_placed)
		TRY(vehicle_replace(vehicles, vehicle));
	data->time = n[10];
	memset(data->warning, 0, sizeof data->warning);
	from = take(from, data->qpos + owned->qpos.first, range_count(owned->qpos));
	from = take(from, data->qvel + owned->dof.first, range_count(owned->dof));
	from = take(from, data->qacc_warmstart + owned->dof.first, range_count(owned->dof));
	from = take(from, data->act + owned->act.first, range_count(owned->act));
	for (size_t g = 0; g < vehicle->geom_count; g++)
		TRY(restore_geom(vehicles, &vehicle->geoms[g], &from));
	*numbers = from;
	return STATUS_OK;
}

enum status vehicle_restore(struct vehicles *vehicles, const double *numbers)
{
	for (size_t v = 0; v < vehicles->count; v++) {
		struct vehicle *vehicle = &vehicles->list[v];
		TRY(restore_one(vehicles, vehicle, &numbers));
		if (vehicle->begun == 0)
			continue;
		/* What the last step left beside its state. */
		vehicle_find_places(vehicle);
		mj_crb(vehicle->model, vehicle->data);
		mj_factorM(vehicle->model, vehicle->data);
	}
	vehicle_show(vehicles);
	return STATUS_OK;
}
