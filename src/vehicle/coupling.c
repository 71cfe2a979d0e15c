/*
 * The soil's forces on the soil geoms of all vehicles, in the steps of the engine.
 *
 * The world has linearised each contact where the coupling step ends if the velocity stays u0: F = F0 + K x + C (u - u0). Here x is the
 * displacement from there, and u the velocity. Each has six numbers: of the body's origin, and about local axes. So a steady motion has
 * the soil's own force, and K and C act on what changes it. (Linearised at the step's start, K acted on all of a wheel's way and turn.)
 * The force is taken at the end of the engine's step h, as an implicit step does. A step of the engine that ends t before the coupling
 * step has x + t u0 in place of x. Of K and C only the parts are used that resist motion: symmetric, without eigenvalues above 0. So no
 * stiffness makes the step unstable.
 *
 * u = J v, where v are the velocities of the joints. At the end of the step they are v + h a:
 *
 *     F = F(v) + G J h a,    F(v) = F0 + K (x + h J v) + C (J v - u0),    G = h K + C
 *
 * F acts on the joints as J^T F. So MuJoCo gets F(v) as a force that is applied, and M - h J^T G J as its inertia M. Then its accelerations are
 * right, with all its own forces, constraints and contacts. J of a geom has numbers only for the freedoms from the root of its tree to the geom. M has
 * room for all pairs of these. So there is no other system of equations, and what MuJoCo solves knows how the soil answers.
 *
 * A post bears no more than can be summed. If damping alone has more than that, F0 is less than C u0, and C takes away more than F0 has.
 * Then the soil hardly brakes a body, and throws it up later. Such a contact ends the drive.
 *
 * The soil does not pull, and its shear has a limit. A contact whose force at the end is beyond that gets the force at the limit, without G. Then
 * the step is made once more.
 *
 * A belt (VEHICLES.md) is a surface that runs over its body along the body's own x axis e. A hinge drives it, by r for each radian of its
 * angle a. The soil shears this surface. So x and u are those of the surface: x is less by r (a - a0) e, and u by r a' e. J has the
 * same: in the column of the hinge its first three rows are -r e. By virtual work J^T then gives the hull its force and the hinge the torque
 * -r e F. Where the lower envelope leans, e F has normal stress in it, and the belt's pull has not. This difference, as the probe told it, is
 * a torque besides. Where the hinge is neither below nor above the geom's body, M has no room for their products. Then both parts of J^T G J
 * count twice, which is at least as stiff.
 *
 * A body that moves freely and has no other joint, such as a ball, is lone: its part of M has the diagonal alone. There the step is first made with a
 * diagonal that is at least as stiff. It tells the sum q of all forces. Then the few equations of that body are solved as a whole, for all its
 * contacts. The step is made once more, with their forces.
 *
 * Soil aboard a geom is a load: a mass m at a place r of the geom, found at the coupling step's start. It is one more contact:
 *
 *     F = -m g - m (u - u_h) / h
 *
 * of the velocity at r, with u_h at the engine step's start. So the load has weight and inertia, and no step is unstable by it. Without soil aboard it is absent.
 *
 * Shear of the soil is elastic at rest and would swing for ever. So along the ground each contact is damped at about half of what is
 * critical. Only changes of the velocity v at the contact are: -c (v - w), where w follows v within some periods of the swing. A
 * wheel that slips steadily feels nothing of it, and a body at rest does not creep. It is a dashpot in series with a spring, so it
 * gives no energy.
 *
 * Brakes of wheels, while vehicles settle, are inertia of the wheels' freedoms.
 */#include <math.h>

#include "vehicle/coupling.h"
#include "vehicle/powertrain.h"

#define CUT_PRESSURE 7e7 /* Pa on a post: nothing is cut below that: a post is cut where one of three components has 134 MPa */
#define CUT_SHARE 0.1   /* of the damping that would just be summed: what is advised */

static bool touches(const struct soil_geom *geom)
{
	return geom->contact.state == FURROW_TOUCHING || geom->contact.state == FURROW_SLIDES || geom->contact.state == FURROW_SUNK;
}

/* Lists the geoms that touch, and the loads. */
static void list_contacts(struct vehicle *vehicle)
{
	vehicle->contact_count = 0;
	for (size_t i = 0; i < vehicle->geom_count; i++) {
		struct soil_geom *geom = &vehicle->geoms[i];
		mju_zero(geom->force, 6);
		geom->pulled = 0;
		if (touches(geom))
			vehicle->contacts[vehicle->contact_count++] = (struct contact){.geom = geom};
		else
			mju_zero3(geom->mean);
	}
	vehicle->touching = vehicle->contact_count;
	for (size_t i = 0; i < vehicle->geom_count && vehicle->carrying_count > 0; i++)
		if (vehicle->geoms[i].load > 0)
			vehicle->contacts[vehicle->contact_count++] = (struct contact){.geom = &vehicle->geoms[i], .is_load = true};
	for (size_t i = 0; i < vehicle->contact_count; i++)
		vehicle_coupling_set_forward(&vehicle->contacts[i]);
}

/* Puts forces and gains of all contacts into qfrc_applied and M. */
static void apply(struct vehicles *vehicles, double h, bool drives)
{
	const mjModel *model = vehicles->model;
	mjData *data = vehicles->data;
	mju_copy(data->M, vehicles->mass, (int)model->nC);
	mju_zero(data->qfrc_applied, model->nv);
	for (size_t v = 0; v < vehicles->all; v++) {
		struct vehicle *vehicle = &vehicles->list[v];
		for (size_t i = 0; i < vehicle->contact_count; i++) {
			const struct contact *contact = &vehicle->contacts[i];
			vehicle_coupling_add_force(contact, contact->force, data->qfrc_applied);
			if (!contact->is_limited)
				vehicle_coupling_add_gain(contact, h, data->M);
			if (!contact->is_load && contact->geom->shape.belt)
				data->qfrc_applied[contact->geom->dof] += contact->geom->pulled = vehicle_coupling_turn_back(contact);
		}
		if (!drives)
			vehicle_coupling_brake(vehicle, data->M);
	}
	mj_factorM(model, data);
	if (data->nefc > 0 && (model->opt.solver == mjSOL_PGS || model->opt.noslip_iterations > 0))
		mj_projectConstraint(model, data);
}

void vehicle_couple(struct vehicles *vehicles, double h, double later, bool drives)
{
	const double spacing = vehicles->world != NULL ? world_resident(vehicles->world)->spacing : 0; /* without a world nothing touches */
	const mjModel *model = vehicles->model;
	mjData *data = vehicles->data;
	bool any = false;
	mju_copy(vehicles->mass, data->M, (int)model->nC);
	for (size_t v = 0; v < vehicles->all; v++) {
		struct vehicle *vehicle = &vehicles->list[v];
		list_contacts(vehicle);
		vehicle_coupling_fill_jacobians(vehicle, vehicles->room);
		any = any || vehicle->touching > 0;
		vehicle_coupling_dampings(vehicle, vehicles->room);
		for (int i = vehicle->own.dof.first; i < vehicle->own.dof.end; i++)
			*vehicle_coupling_diagonal(model, data->M, i) += h * vehicles->room[i] + (vehicle_train_holds(vehicle, i) ? BRAKE_SOFT * model->dof_M0[i] : 0);
	}
	if (any)
		mj_factorM(model, data);
	for (size_t v = 0; v < vehicles->all; v++)
		vehicle_coupling_fill(&(struct step){&vehicles->list[v], h, later, CUT_PRESSURE * spacing * spacing, vehicles->as_asked});
	vehicles->as_asked = false;
	apply(vehicles, h, drives);
}

/* Finds the force of a contact once the velocities have changed. */
static void force_after(const struct contact *contact, const double *change, double force[6])
{
	double u[6];
	mju_copy(force, contact->force, 6);
	if (contact->is_limited)
		return;
	vehicle_coupling_velocity(contact, change, u);
	vehicle_coupling_answer(contact, u, force);
}

bool vehicle_couple_end(struct vehicles *vehicles, double h, const double *before, bool drives)
{
	const int nv = vehicles->model->nv;
	double *change = vehicles->room;
	bool again = false;
	mju_sub(change, vehicles->data->qvel, before, nv);
	for (size_t v = 0; v < vehicles->all; v++) {
		struct vehicle *vehicle = &vehicles->list[v];
		for (size_t i = 0; i < vehicle->contact_count; i++)
			if (vehicle->contacts[i].geom->lone && !vehicle->contacts[i].is_limited)
				again |= vehicle_coupling_solve_lone(vehicles, vehicle, vehicle->contacts[i].geom, h, change);
		for (size_t i = 0; i < vehicle->touching; i++) {
			struct contact *contact = &vehicle->contacts[i];
			double *force = contact->geom->force;
			force_after(contact, change, force);
			if (contact->is_limited || !vehicle_coupling_limit(contact, force))
				continue;
			contact->is_limited = again = true;
			mju_copy(contact->force, force, 6);
		}
	}
	if (again)
		apply(vehicles, h, drives);
	return again;
}

void vehicle_couple_tell(struct vehicles *vehicles, const double *before)
{
	double *change = vehicles->room;
	mju_sub(change, vehicles->data->qvel, before, vehicles->model->nv);
	for (size_t v = 0; v < vehicles->all; v++)
		for (size_t i = 0; i < vehicles->list[v].touching; i++)
			force_after(&vehicles->list[v].contacts[i], change, vehicles->list[v].contacts[i].geom->force);
}

enum status vehicle_check_summed(const struct vehicles *vehicles)
{
	for (const struct vehicle *vehicle = vehicles->list; vehicle < vehicles->list + vehicles->all; vehicle++) {
		const struct scene *scene = vehicles->scene;
		const struct soil_geom *geom = vehicle->cut;
		double most = 0;
		if (geom == NULL)
			continue;
		for (int i = 0; i < scene->soil_count; i++)
			most = fmax(most, scene->soils[i].damping);
		return fail_with(STATUS_FAILED, "%s%s: soil.damping presses a post with more than 134 MPa, the most that is summed, at %.3g m/s and %.3f, %.3f m, after %.6g s: "
						"with less than the whole force the ground would give way; give soil.damping (now %g Pa s/m) of at most %s",
				 vehicle->is_world ? "" : "vehicles.", geom->name, mju_norm3(geom->now.linear), geom->now.pose.position[0], geom->now.pose.position[1],
				 world_time(vehicles->world), most, number_at_most(CUT_SHARE * vehicle->cut_share * most, 2).text);
	}
	return STATUS_OK;
}

void vehicle_couple_done(struct vehicles *vehicles, double h, const double *before, bool tells)
{
	const double *after = vehicles->data->qvel;
	for (size_t v = 0; v < vehicles->all; v++) {
		struct vehicle *vehicle = &vehicles->list[v];
		for (size_t i = 0; i < vehicle->touching; i++) {
			const struct contact *contact = &vehicle->contacts[i];
			struct soil_geom *geom = contact->geom;
			double from[6], to[6], power = 0;
			vehicle_coupling_velocity(contact, before, from);
			vehicle_coupling_velocity(contact, after, to);
			vehicle_coupling_follow(contact, h, to);
			for (int k = 0; k < 6; k++)
				power += geom->force[k] * (from[k] + to[k]) / 2;
			if (geom->shape.belt)
				power += geom->pulled * (before[geom->dof] + after[geom->dof]) / 2;
			geom->work -= tells ? power * h : 0;
		}
	}
	mju_copy(vehicles->data->M, vehicles->mass, (int)vehicles->model->nC);
}

void vehicle_couple_forces(const struct vehicles *vehicles, const double *before, double *forces)
{
	const int nv = vehicles->model->nv;
	double *change = vehicles->room;
	mju_sub(change, vehicles->data->qvel, before, nv);
	mju_zero(forces, nv);
	for (size_t v = 0; v < vehicles->all; v++)
		for (size_t i = 0; i < vehicles->list[v].contact_count; i++) {
			const struct contact *contact = &vehicles->list[v].contacts[i];
			double force[6];
			force_after(contact, change, force);
			vehicle_coupling_add_force(contact, force, forces);
			if (!contact->is_load && contact->geom->shape.belt)
				forces[contact->geom->dof] += contact->geom->pulled;
		}
}
