/* The state of vehicles as numbers of the run's record, so that a resumed drive goes on to the same bits. */
#include <math.h>
#include <string.h>

#include "vehicle/drives.h"
#include "vehicle/powertrain.h"
#include "vehicle/settle.h"
#include "vehicle/start.h"

#define OWN 16       /* numbers of a vehicle itself, */
#define TRAIL (2 + 2 * VEHICLE_TRAIL) /* of its trail, */
#define GEOM_OWN 19  /* of a soil geom, without its body in the world */

size_t vehicle_state_numbers(const struct vehicle *vehicle)
{
	const struct owned *own = &vehicle->own;
	return OWN + TRAIL + vehicle_lies_numbers(vehicle) + range_count(own->qpos) + 2 * range_count(own->dof) + range_count(own->act) + vehicle_train_numbers(vehicle) + DRIVE_STATE * vehicle->drive_count +
	       vehicle->geom_count * (GEOM_OWN + WORLD_BODY_NUMBERS);
}

/* Numbers that are saved, or restored. One list of what a state has serves both. */
struct record {
	double *to;         /* saves there; NULL: restores */
	const double *from;
};

static void carry(struct record *record, double *numbers, size_t count)
{
	if (record->to != NULL) {
		mju_copy(record->to, numbers, (int)count);
		record->to += count;
	} else {
		mju_copy(numbers, record->from, (int)count);
		record->from += count;
	}
}

static void carry_bool(struct record *record, bool *is)
{
	double number = *is;
	carry(record, &number, 1);
	*is = number != 0;
}

static void carry_geom(struct record *record, struct soil_geom *geom)
{
	struct furrow_state *touched = &geom->touched;
	carry_bool(record, &geom->is_touched);
	carry(record, &geom->touched_belt.travel, 1);
	carry(record, &geom->work, 1);
	carry(record, touched->pose.position, 3);
	carry(record, touched->pose.orientation, 4);
	carry(record, touched->linear, 3);
	carry(record, touched->angular, 3);
	carry(record, geom->mean, 3);
}

#define AT 11 /* of them: where the driver is on its path; of a way that is not the scene's (target.c) this is -1 less that */

/* The OWN numbers. */
static void carry_own(struct record *record, struct vehicle *vehicle)
{
	struct driver *driver = &vehicle->driver;
	double *const first[] = {&vehicle->checksum[0], &vehicle->checksum[1], &vehicle->begun, &vehicle->settle_seconds, &vehicle->calm, &vehicle->work,
				 &vehicle->distance, &vehicle->slow, &vehicle->origin[2], &vehicle->lift, &vehicle->data->time, &driver->at, &driver->sum};
	for (size_t i = 0; i < sizeof first / sizeof first[0]; i++)
		carry(record, first[i], 1);
	carry_bool(record, &driver->arrived);
	carry(record, &driver->speed, 1);
	carry(record, &driver->turn, 1);
}

static void carry_engine(struct record *record, struct vehicle *vehicle)
{
	const struct owned *own = &vehicle->own;
	mjData *data = vehicle->data;
	carry(record, data->qpos + own->qpos.first, range_count(own->qpos));
	carry(record, data->qvel + own->dof.first, range_count(own->dof));
	carry(record, data->qacc_warmstart + own->dof.first, range_count(own->dof));
	carry(record, data->act + own->act.first, range_count(own->act));
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

static double *save_one(const struct vehicles *vehicles, struct vehicle *vehicle, double *to)
{
	struct record record = {.to = to};
	carry_own(&record, vehicle);
	if (vehicle->driver.sent.is)
		to[AT] = -1 - to[AT];
	record.to = save_trail(&vehicle->trail, record.to);
	record.to = vehicle_save_lies(vehicle, record.to);
	carry_engine(&record, vehicle);
	record.to = vehicle_train_save(vehicle, record.to);
	record.to = vehicle_drives_save(vehicle, record.to);
	for (struct soil_geom *geom = vehicle->geoms; geom < vehicle->geoms + vehicle->geom_count; geom++) {
		carry_geom(&record, geom);
		world_body_save(vehicles->world, geom->number, record.to);
		record.to += WORLD_BODY_NUMBERS;
	}
	return record.to;
}

void vehicle_save(const struct vehicles *vehicles, double *numbers)
{
	for (size_t v = 0; v < vehicles->all; v++)
		numbers = save_one(vehicles, &vehicles->list[v], numbers);
}

static enum status damaged(const struct vehicles *vehicles, const struct vehicle *vehicle, const char *why)
{
	return fail_with(STATUS_INPUT, "%s: what its last drive left to go on from does not fit vehicles.%s: %s; drive without --resume",
			 world_facts(vehicles->world)->path, vehicle->scene->name, why);
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
	const double *n = *numbers;
	const bool sent = n[AT] < 0;
	struct record record = {.from = n};
	if (n[0] != vehicle->checksum[0] || n[1] != vehicle->checksum[1])
		return damaged(vehicles, vehicle, "its model is another one now, or was read by another MuJoCo");
	if (sent && !vehicle->driver.sent.is)
		return damaged(vehicles, vehicle, "furrow view sent it to a place, so it is off its path");
	const double at = vehicle->driver.sent.fresh || sent != vehicle->driver.sent.is ? 0 : sent ? -1 - n[AT] : n[AT];
	if (!restore_trail(&vehicle->trail, n + OWN) || !(n[2] >= 0 && n[2] <= VEHICLE_DRIVES) || !(at >= 0 && at <= fmax((double)vehicle->driver.point_count - 1, 0)))
		return damaged(vehicles, vehicle, "numbers out of range");
	const bool is_placed = vehicle->begun > 0; /* it goes back to a checkpoint: its model is turned and lifted already */
	carry_own(&record, vehicle);
	vehicle->driver.at = at;
	record.from = vehicle_restore_lies(vehicle, record.from + TRAIL);
	if (vehicle->begun > 0 && !is_placed)
		TRY(vehicle_replace(vehicles, vehicle));
	memset(vehicle->data->warning, 0, sizeof vehicle->data->warning);
	carry_engine(&record, vehicle);
	record.from = vehicle_train_restore(vehicle, record.from);
	record.from = vehicle_drives_restore(vehicle, record.from);
	for (struct soil_geom *geom = vehicle->geoms; geom < vehicle->geoms + vehicle->geom_count; geom++) {
		carry_geom(&record, geom);
		geom->contact = world_contact_unknown();
		geom->aloft = !geom->is_standing && record.from[0] == 0;
		TRY(world_body_restore(vehicles->world, geom->number, record.from));
		record.from += WORLD_BODY_NUMBERS;
	}
	*numbers = record.from;
	return STATUS_OK;
}

enum status vehicle_restore(struct vehicles *vehicles, const double *numbers)
{
	for (size_t v = 0; v < vehicles->all; v++)
		TRY(restore_one(vehicles, &vehicles->list[v], &numbers));
	if (vehicles->list[0].begun > 0) /* what the last step left beside its state */
		vehicle_find_inertia(vehicles);
	vehicle_show(vehicles);
	return STATUS_OK;
}
