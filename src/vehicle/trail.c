/*
 * Where a vehicle went in the whole drive, for maps. The trail has a fixed size. Its points are some distance apart. When it is full, every
 * second point is dropped and the distance is doubled.
 */
#include <math.h>

#include "vehicle/internal.h"

#define APART 0.02 /* m between the points of a new trail */

static void place_of(const struct vehicle *vehicle, double place[2])
{
	for (int i = 0; i < 2; i++)
		place[i] = vehicle->origin[i] + vehicle->data->xpos[3 * vehicle->root + i];
}

static void thin(struct trail *trail)
{
	size_t kept = 0;
	for (size_t i = 0; i < trail->count; i += 2, kept++)
		for (int k = 0; k < 2; k++)
			trail->places[kept][k] = trail->places[i][k];
	trail->count = kept;
	trail->apart *= 2;
}

void vehicle_trail_add(struct vehicle *vehicle)
{
	struct trail *trail = &vehicle->trail;
	double place[2];
	place_of(vehicle, place);
	if (trail->count == 0)
		trail->apart = APART;
	else if (hypot(place[0] - trail->places[trail->count - 1][0], place[1] - trail->places[trail->count - 1][1]) < trail->apart)
		return;
	if (trail->count == VEHICLE_TRAIL)
		thin(trail);
	for (int k = 0; k < 2; k++)
		trail->places[trail->count][k] = place[k];
	trail->count++;
}

size_t vehicle_trail(const struct vehicles *vehicles, size_t index, double (*places)[2])
{
	const struct vehicle *vehicle = &vehicles->list[index];
	const struct trail *trail = &vehicle->trail;
	for (size_t i = 0; i < trail->count; i++)
		for (int k = 0; k < 2; k++)
			places[i][k] = trail->places[i][k];
	if (trail->count > 0)
		place_of(vehicle, places[trail->count]);
	return trail->count > 0 ? trail->count + 1 : 0;
}
