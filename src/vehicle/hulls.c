/*
 * Hulls: soil geoms that do not stand on the ground in the first pose, since they collide and are no wheels.
 *
 * A hull that is high above the ground is aloft: its body is not in the world, and no probe asks for it. In each step the posts below it are
 * compared with a plane at its lower side. That is all that it costs, and the motion of other geoms keeps its bits. The hull is put into the world
 * again, at its place, before it can touch. Its place and the ground alone decide whether it is aloft, so a resumed drive and a rollback find
 * the same.
 */
#include <math.h>

#include "vehicle/internal.h"

#define GROUNDED 0.01   /* m: a geom that is no higher than this above the lowest one is on the ground */
/* A hull is aloft if it is higher above the ground than this many posts, and than it moves in this many time steps besides. */
#define MARGIN_POSTS 0.5
#define MARGIN_STEPS 4.0

/* Things of `world` always count as standing: their rows tell where they are. */
void vehicle_find_standing(struct vehicle *vehicle)
{
	double ground = INFINITY;
	for (size_t g = 0; g < vehicle->geom_count; g++)
		ground = fmin(ground, vehicle_geom_lowest(vehicle, vehicle->geoms[g].geom));
	vehicle->standing_count = 0;
	for (size_t g = 0; g < vehicle->geom_count; g++) {
		struct soil_geom *geom = &vehicle->geoms[g];
		geom->is_standing = vehicle->is_world || vehicle->scene->soil.count > 0 || geom->carries || vehicle_turning_dof(geom) >= 0 ||
			       vehicle_geom_lowest(vehicle, geom->geom) <= ground + GROUNDED;
		geom->aloft = !geom->is_standing;
		vehicle->standing_count += geom->is_standing;
	}
}

/* The space above the box around a geom's lower side, along the box's most upright axis. `aabb`: middle and half sizes in the geom's axes. */
void vehicle_space_of(const struct vehicle *vehicle, int geom, const double place[3], const double mat[9], double margin, struct world_space *space)
{
	const mjtNum *aabb = &vehicle->model->geom_aabb[6 * geom];
	double middle[3], half[3] = {0, 0, 0};
	int up = 0;
	mju_mulMatVec3(middle, mat, aabb);
	mju_addTo3(middle, place);
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 3; k++)
			half[i] += fabs(mat[3 * i + k]) * aabb[3 + k];
	for (int k = 1; k < 3; k++)
		up = fabs(mat[6 + k]) > fabs(mat[6 + up]) ? k : up;
	for (int i = 0; i < 2; i++) {
		space->low[i] = middle[i] - half[i];
		space->high[i] = middle[i] + half[i];
		space->slope[i] = -mat[3 * i + up] / mat[6 + up];
	}
	mju_copy3(space->at, middle);
	space->at[2] -= aabb[3 + up] / fabs(mat[6 + up]) + margin;
	space->lowest = middle[2] - half[2] - margin;
}

/* Finds whether a hull is aloft at the end of the time step. Off the terrain it always is. */
static enum status find_aloft(const struct vehicles *vehicles, const struct vehicle *vehicle, const struct soil_geom *geom, bool *aloft)
{
	const double step = vehicles->scene->time_step, *state = geom->now.pose.orientation;
	const double bound = soil_shape_bound(&geom->shape), speed = mju_norm3(geom->now.linear) + bound * mju_norm3(geom->now.angular);
	struct world_space space;
	double axes[9], mat[9], depth;
	mju_quat2Mat(axes, state);
	mju_mulMatMatT(mat, axes, geom->axes, 3, 3, 3);
	vehicle_space_of(vehicle, geom->geom, geom->now.pose.position, mat, MARGIN_POSTS * world_resident(vehicles->world)->spacing + MARGIN_STEPS * step * speed, &space);
	TRY(world_reach_into(vehicles->world, &space, &depth));
	*aloft = depth < 0;
	return STATUS_OK;
}

struct furrow_contact vehicle_no_contact(const struct vehicles *vehicles)
{
	struct furrow_contact contact = world_contact_unknown();
	contact.state = FURROW_AIR;
	contact.time = world_time(vehicles->world);
	contact.sinkage = contact.area = contact.normal_force = contact.shear_limit = contact.carried = contact.slip_velocity = 0;
	mju_zero3(contact.force);
	mju_zero3(contact.moment);
	mju_zero(contact.stiffness[0], 36);
	mju_zero(contact.damping[0], 36);
	return contact;
}

/* Puts a hull into the world, where it is, at rest. Nothing lies between there and where it was before. */
static enum status put_down(const struct vehicles *vehicles, const struct vehicle *vehicle, struct soil_geom *geom)
{
	struct furrow_state state;
	vehicle_geom_state(vehicle, geom, &state, NULL);
	geom->is_touched = false;
	return world_body_place(vehicles->world, geom->number, &state.pose);
}

enum status vehicle_lift_hull(const struct vehicles *vehicles, const struct vehicle *vehicle, struct soil_geom *geom)
{
	bool aloft;
	if (geom->is_standing)
		return STATUS_OK;
	TRY(find_aloft(vehicles, vehicle, geom, &aloft));
	if (aloft == geom->aloft)
		return STATUS_OK;
	geom->aloft = aloft;
	geom->is_touched = false;
	return aloft ? world_body_lift(vehicles->world, geom->number) : put_down(vehicles, vehicle, geom);
}
