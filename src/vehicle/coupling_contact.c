/* One contact of a geom with the soil in a step of the engine: its force, and how that answers a change of the velocities. coupling.c tells how. */
#include <math.h>

#include "vehicle/coupling.h"
#include "vehicle/linear.h"

#define DAMPING 0.5     /* of what is critical */
#define PERIODS 4.0     /* w follows within this many swings / 2 pi */
#define HELD 1e-12      /* 1/kg: an inverse mass that is rounding alone: its joints do not let it move that way */
#define CUT 2.0         /* damping has so many times the whole force: what is summed was cut */
#define LIGHT 0.25      /* of the mass that the contact carries: the least inverse mass is that of a body as many times heavier */

/* Two directions along the ground: as a wheel heads, and across. */
static void set_directions(struct contact *contact)
{
	const struct soil_geom *geom = contact->geom;
	const double *normal = geom->contact.normal;
	const bool wheel = geom->shape.kind == SOIL_WHEEL;
	double axes[3][3], across[3];
	world_axes(geom->now.pose.orientation, axes);
	if (wheel) /* along its axle: its own x axis turns with it */
		mju_addScl3(across, axes[1], normal, -mju_dot3(axes[1], normal));
	else
		mju_cross(across, normal, axes[0]);
	if (mju_norm3(across) < 0.1) /* its forward axis is normal to the ground; a wheel lies on its side */
		mju_cross(across, normal, axes[wheel ? 0 : 1]);
	mju_normalize3(across);
	mju_copy3(contact->direction[1], across);
	mju_cross(contact->direction[0], across, normal);
	for (int i = 0; i < 3; i++)
		contact->arm[i] = isfinite(geom->contact.point[i]) ? geom->contact.point[i] - geom->now.pose.position[i] : 0;
	for (int k = 0; k < 2; k++) {
		mju_copy3(contact->along[k], contact->direction[k]);
		mju_cross(contact->along[k] + 3, contact->arm, contact->direction[k]);
	}
	if (wheel) /* as it turns about an axle that leans, its rim goes up and down, not aside */
		mju_addToScl3(contact->along[1] + 3, axes[1], -mju_dot3(axes[1], contact->along[1] + 3));
}

/* Finds the damping of shear: from the stiffness of the soil along each direction, and the mass that it moves. */
static void set_damping(const struct vehicle *vehicle, struct contact *contact, double (*work)[2])
{
	const double(*stiffness)[6] = (const double(*)[6])contact->geom->contact.stiffness;
	const double carried = contact->geom->contact.normal_force / mju_norm3(vehicle->model->opt.gravity); /* kg */
	double inverses[2];
	vehicle_coupling_inverse_masses(vehicle, contact, work, inverses);
	for (int k = 0; k < 2; k++) {
		const double inverse = inverses[k];
		double spring = 0;
		for (int i = 0; i < 3; i++)
			for (int j = 0; j < 3; j++)
				spring -= contact->direction[k][i] * stiffness[i][j] * contact->direction[k][j];
		contact->critical[k] = contact->pace[k] = 0;
		if (!(spring > 0 && inverse > HELD))
			continue;
		/* Several contacts share the mass. What joints and motors hold nearly still seems heavy. Its swing would be slow, and w would lag behind
		 * a steady slip for minutes. */
		const double shared = fmax(inverse * (double)vehicle->touching, carried > 0 ? LIGHT / carried : 0);
		contact->critical[k] = DAMPING * 2 * sqrt(spring / shared);
		contact->pace[k] = sqrt(spring * shared) / PERIODS;
	}
}

/* How far the body, or the belt's lower run, has moved and turned since its contact was linearised. */
static void displacement(const struct step *step, const struct contact *contact, double moved[6])
{
	const struct soil_geom *geom = contact->geom;
	struct furrow_state state = geom->from;
	struct furrow_belt belt = geom->from_belt;
	double back[4], turn[4];
	if (!step->as_asked)
		vehicle_geom_state(step->vehicle, geom, &state, &belt);
	for (int i = 0; i < 3; i++)
		moved[i] = state.pose.position[i] - geom->now.pose.position[i] -
			   (belt.travel - geom->now_belt.travel) * contact->forward[i];
	mju_negQuat(back, geom->now.pose.orientation);
	mju_mulQuat(turn, state.pose.orientation, back);
	mju_quat2Vel(moved + 3, turn, 1);
}

/* Multiplies rotations and moments by a length. */
static void scale(const double from[6][6], double length, double to[6][6])
{
	for (int i = 0; i < 6; i++)
		for (int j = 0; j < 6; j++)
			to[i][j] = from[i][j] * ((i < 3 ? 1 : length) * (j < 3 ? 1 : length));
}

static void scale_back(const double from[6][6], double length, double to[6][6])
{
	for (int i = 0; i < 6; i++)
		for (int j = 0; j < 6; j++)
			to[i][j] = i < 3 && j < 3 ? from[i][j] : from[i][j] / ((i < 3 ? 1 : length) * (j < 3 ? 1 : length));
}

/* Copies the parts of the contacts' matrices that resist. Rotations are measured in lengths of the body, so that they compare with ways. */
static void take_resisting(struct vehicle *vehicle)
{
	_Static_assert(VEHICLE_ABREAST % 2 == 0, "two matrices of a contact");
	double(*list[VEHICLE_ABREAST])[6];
	size_t listed = 0;
	for (size_t i = 0; i < vehicle->touching; i++) {
		struct contact *contact = &vehicle->contacts[i];
		const struct furrow_contact *from = &contact->geom->contact;
		const double length = soil_shape_bound(&contact->geom->shape);
		scale_back(from->stiffness, length, contact->stiffness);
		scale_back(from->damping, length, contact->damping);
		list[listed++] = contact->stiffness;
		list[listed++] = contact->damping;
		if (listed < VEHICLE_ABREAST && i + 1 < vehicle->touching)
			continue;
		vehicle_make_negative(list, listed);
		listed = 0;
	}
	for (size_t i = 0; i < vehicle->touching; i++) {
		struct contact *contact = &vehicle->contacts[i];
		const double length = soil_shape_bound(&contact->geom->shape);
		scale((const double(*)[6])contact->stiffness, length, contact->stiffness);
		scale((const double(*)[6])contact->damping, length, contact->damping);
	}
}

/* Adds the damping of shear to the force and to the gain. */
static void damp(struct contact *contact, const double u[6])
{
	for (int k = 0; k < 2; k++) {
		const double *along = contact->along[k], mean = mju_dot3(contact->geom->mean, contact->direction[k]);
		const double changed = dot6(along, u) - mean;
		double resists[6];
		for (int i = 0; i < 6; i++)
			resists[i] = contact->critical[k] * along[i];
		for (int i = 0; i < 6; i++)
			contact->force[i] -= resists[i] * changed;
		for (int j = 0; j < 6; j++)
			for (int i = 0; i < 6; i++)
				contact->gain[j][i] -= resists[i] * along[j];
	}
}

/* Fills force and gain of a load. The velocity at its place is [1, -r x] u. */
static void fill_load(const struct step *step, struct contact *contact)
{
	const double *r = contact->geom->load_at, weight = contact->geom->load;
	const double at[3][6] = {{1, 0, 0, 0, r[2], -r[1]}, {0, 1, 0, -r[2], 0, r[0]}, {0, 0, 1, r[1], -r[0], 0}};
	const double rate = weight / (mju_norm3(step->vehicle->model->opt.gravity) * step->h);
	for (int i = 0; i < 6; i++) {
		contact->force[i] = -weight * at[2][i];
		for (int j = 0; j < 6; j++)
			contact->gain[i][j] = -rate * (at[0][i] * at[0][j] + at[1][i] * at[1][j] + at[2][i] * at[2][j]);
	}
}

/* Finds whether a contact's force was cut to what can be summed. `at`: the velocity of its force. The contact's own matrix tells, since the part of it that resists has
 * half of how sinking adds shear, along the normal. */
static void find_cut(const struct step *step, const struct contact *contact, const double at[6])
{
	const struct furrow_contact *from = &contact->geom->contact;
	const double whole = mju_dot3(from->force, from->normal);
	double damps = 0;
	if (!(whole > step->cut))
		return;
	for (int i = 0; i < 3; i++)
		damps += from->normal[i] * dot6(from->damping[i], at);
	if (!(damps > CUT * whole) || (step->vehicle->cut != NULL && step->vehicle->cut_share <= whole / damps))
		return;
	step->vehicle->cut = contact->geom;
	step->vehicle->cut_share = whole / damps;
}

/* Fills force and gain of a contact. */
static void fill_contact(const struct step *step, struct contact *contact)
{
	const struct soil_geom *geom = contact->geom;
	const double h = step->h;
	double *force = contact->force, moved[6], at[6], u[6], goes[6], gains[6]; /* way and change of the velocity at the step's end */
	vehicle_coupling_velocity(contact, step->vehicle->data->qvel, u);
	displacement(step, contact, moved);
	for (int i = 0; i < 3; i++) {
		at[i] = geom->now.linear[i] - geom->now_belt.speed * contact->forward[i];
		at[3 + i] = geom->now.angular[i];
		force[i] = geom->contact.force[i];
		force[3 + i] = geom->contact.moment[i];
	}
	find_cut(step, contact, at);
	for (int j = 0; j < 6; j++) {
		goes[j] = moved[j] + step->later * at[j] + h * u[j];
		gains[j] = u[j] - at[j];
	}
	/* Both matrices are symmetric, to the bit. */
	for (int j = 0; j < 6; j++)
		for (int i = 0; i < 6; i++) {
			force[i] += contact->stiffness[j][i] * goes[j] + contact->damping[j][i] * gains[j];
			contact->gain[j][i] = h * contact->stiffness[j][i] + contact->damping[j][i];
		}
	damp(contact, u);
}

void vehicle_coupling_fill(const struct step *step)
{
	struct vehicle *vehicle = step->vehicle;
	for (size_t i = 0; i < vehicle->touching; i++) {
		set_directions(&vehicle->contacts[i]);
		set_damping(vehicle, &vehicle->contacts[i], (double(*)[2])vehicle->room);
	}
	take_resisting(vehicle);
	for (size_t i = 0; i < vehicle->contact_count; i++)
		if (vehicle->contacts[i].is_load)
			fill_load(step, &vehicle->contacts[i]);
		else
			fill_contact(step, &vehicle->contacts[i]);
}

bool vehicle_coupling_limit(const struct contact *contact, double force[6])
{
	const struct furrow_contact *from = &contact->geom->contact;
	const double normal = mju_dot3(force, from->normal), before = mju_dot3(from->force, from->normal);
	double shear[3], given[3];
	if (!(normal > 0)) {
		mju_zero(force, 6);
		return true;
	}
	mju_addScl3(shear, force, from->normal, -normal);
	mju_addScl3(given, from->force, from->normal, -before);
	const double most = fmax(isfinite(from->shear_limit) ? from->shear_limit : 0, mju_norm3(given)) * (before > 0 ? fmax(normal / before, 0) : 1);
	const double is = mju_norm3(shear);
	if (!(before > 0) || is <= most)
		return false;
	double less[3], moment[3];
	mju_scl3(less, shear, most / is - 1);
	mju_cross(moment, contact->arm, less);
	for (int i = 0; i < 3; i++) {
		force[i] += less[i];
		force[3 + i] += moment[i];
	}
	return true;
}

void vehicle_coupling_follow(const struct contact *contact, double h, const double end[6])
{
	double mean[3] = {0, 0, 0};
	for (int k = 0; k < 2; k++) {
		const double was = mju_dot3(contact->geom->mean, contact->direction[k]), share = h * contact->pace[k];
		mju_addToScl3(mean, contact->direction[k], was + (dot6(contact->along[k], end) - was) * share / (1 + share));
	}
	mju_copy3(contact->geom->mean, mean);
}

void vehicle_coupling_set_forward(struct contact *contact)
{
	double axes[3][3];
	world_axes(contact->geom->now.pose.orientation, axes);
	mju_copy3(contact->forward, axes[0]);
}

double vehicle_coupling_turn_back(const struct contact *contact)
{
	const struct soil_geom *geom = contact->geom;
	if (!geom->shape.belt || !isfinite(geom->contact.pull))
		return 0;
	return -geom->sprocket * (geom->contact.pull - mju_dot3(geom->contact.force, contact->forward));
}
