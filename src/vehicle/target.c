/*
 * Sends a vehicle with a path to a place instead: its driver gets another way, from where the vehicle is. If the place is behind it, the way
 * begins with an arc, since pure pursuit does not turn round by itself.
 *
 * The way is not in the record; `at` is, below 0 if it is of such a way. So a rollback needs what vehicle_mark_ways kept, and a drive that
 * is resumed cannot go on with it: that is refused.
 */
#include <math.h>
#include <string.h>

#include "vehicle/internal.h"

#define RADIUS 2.5          /* of the arc, in wheelbases */
#define TURN (M_PI / 18)    /* between points of the arc */
#define TURNS 36            /* a whole circle */

/* Puts an arc to a side (1: left) into the way, until it looks at the place. Returns false if that lies within the circle. */
static bool arc(struct sent *sent, const double place[2], double heading, double radius, double side)
{
	sent->count = 1;
	for (int i = 0; i <= TURNS; i++) {
		double *last = sent->points[sent->count - 1], *next = sent->points[sent->count];
		const double off = remainder(atan2(place[1] - last[1], place[0] - last[0]) - heading, 2 * M_PI);
		if (fabs(off) <= TURN) {
			next[0] = place[0];
			next[1] = place[1];
			sent->count++;
			return true;
		}
		const double middle = heading + side * TURN / 2, chord = 2 * radius * sin(TURN / 2);
		next[0] = last[0] + chord * cos(middle);
		next[1] = last[1] + chord * sin(middle);
		heading += side * TURN;
		sent->count++;
	}
	return false;
}

static double fastest(const struct vehicle *vehicle, size_t count)
{
	double most = fabs(vehicle->scene->way.speed);
	for (size_t i = 0; vehicle->scene->speeds != NULL && i < count; i++)
		most = i == 0 ? fabs(vehicle->scene->speeds[i]) : fmax(most, fabs(vehicle->scene->speeds[i]));
	return most;
}

static void take_way(struct driver *driver)
{
	driver->points = driver->sent.is ? driver->sent.points : driver->route;
	driver->point_count = driver->sent.is ? driver->sent.count : driver->route_count;
}

bool vehicle_send(struct vehicles *vehicles, size_t index, double x, double y)
{
	struct vehicle *vehicle = &vehicles->list[index];
	struct driver *driver = &vehicle->driver;
	struct sent *sent = &driver->sent;
	const double place[2] = {x, y};
	double axes[9];
	if (vehicle->scene->driver != SCENE_FOLLOW || driver->route_count < 2)
		return false;
	vehicle_root_axes(vehicle, vehicle->data, axes);
	const double heading = atan2(axes[3], axes[0]), radius = RADIUS * vehicle_wheelbase(vehicle);
	for (int i = 0; i < 2; i++)
		sent->points[0][i] = vehicle->origin[i] + vehicle->data->xpos[3 * vehicle->root + i];
	const double off = remainder(atan2(y - sent->points[0][1], x - sent->points[0][0]) - heading, 2 * M_PI);
	const double side = off >= 0 ? 1 : -1;
	if (fabs(off) <= M_PI / 3) {
		memcpy(sent->points[1], place, sizeof place);
		sent->count = 2;
	} else if (!arc(sent, place, heading, radius, side)) {
		(void)arc(sent, place, heading, radius, -side); /* it is outside of the other circle */
	}
	sent->turns = vehicle->scene->way.speed < 0 && (!sent->is || (sent->fresh && sent->turns));
	sent->is = sent->fresh = true;
	sent->speed = fastest(vehicle, driver->route_count);
	driver->at = 0;
	driver->arrived = false;
	take_way(driver);
	return true;
}

bool vehicle_target(const struct vehicles *vehicles, size_t index, double place[2])
{
	const struct driver *driver = &vehicles->list[index].driver;
	if (!driver->sent.is)
		return false;
	memcpy(place, driver->sent.points[driver->sent.count - 1], 2 * sizeof *place);
	return true;
}

void vehicle_mark_ways(struct vehicles *vehicles)
{
	for (size_t v = 0; vehicles != NULL && v < vehicles->count; v++)
		vehicles->list[v].driver.marked = vehicles->list[v].driver.sent;
}

void vehicle_mark_ways_back(struct vehicles *vehicles)
{
	for (size_t v = 0; vehicles != NULL && v < vehicles->count; v++) {
		struct driver *driver = &vehicles->list[v].driver;
		driver->sent = driver->marked;
		take_way(driver);
	}
}

bool vehicle_wheel(const struct vehicles *vehicles, size_t vehicle, size_t number, const char **name, double *slip, double *sinkage)
{
	const struct soil_geom *geom = &vehicles->list[vehicle].geoms[number];
	*name = geom->name;
	*slip = geom->contact.state == FURROW_UNKNOWN ? (double)NAN : geom->contact.slip;
	*sinkage = geom->contact.state == FURROW_UNKNOWN ? 0 : fmax(geom->contact.sinkage, 0);
	return vehicle_turning_dof(geom) >= 0;
}
