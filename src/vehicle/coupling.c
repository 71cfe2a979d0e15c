/*
 * The soil's forces on the soil geoms of one vehicle, in the steps of the engine.
 *
 * The world has linearised each contact where the coupling step ends if the velocity stays u0: F = F0 + K x + C (u - u0). Here x is the
 * displacement from there, and u the velocity. Each has six numbers: of the body's origin, and about local axes. So a steady motion has
 * the soil's own force, and K and C act on what changes it. (Linearised at the step's start, K acted on all of a wheel's way and turn.)
 * The force is taken at the end of the engine's step h, as an implicit step does. A step of the engine that ends t before the coupling
 * step has x + t u0 in place of x. Let u' be the velocity without soil, A_ij = J_i (M + h D)^-1 J_j^T the inverse
 * effective mass. D is the damping that the engine takes at the step's end, too. Of K and C only the parts are used that resist motion:
 * symmetric, without eigenvalues above 0. So no stiffness makes the step unstable. Then
 *
 *     u = u' + h sum_j A_ij F_j,    F_i = F0_i + K_i (x_i + h u_i) + C_i (u_i - u0_i)
 *
 * which is one system of linear equations for all geoms that touch. Equality constraints and limits of joints are not in A.
 *
 * A belt (VEHICLES.md) is a surface that runs over its body along the body's own x axis e. A hinge drives it, by r for each radian of its
 * angle a. The soil shears this surface. So x and u are those of the surface: x is less by r (a - a0) e, and u by r a' e. J has the
 * same: in the column of the hinge its first three rows are -r e. By virtual work J^T then gives the hull its force and the hinge the torque
 * -r e F. Where the lower envelope leans, e F has normal stress in it, and the belt's pull has not. This difference, as the probe told it, is
 * a torque besides.
 *
 * Soil aboard a geom is a load: a mass m at a place r of the geom, found at the coupling step's start. It is in the same system, as one more contact:
 *
 *     F = -m g - m (u - u_h) / h
 *
 * of the velocity at r, with u_h at the engine step's start. So the load has weight and inertia, and no step is unstable by it. Without soil aboard it is absent.
 *
 * Shear of the soil is elastic at rest and would swing for ever. So along the ground each contact is damped at about half of what is
 * critical. Only changes of the velocity v at the contact are: -c (v - w), where w follows v within some periods of the swing. A
 * wheel that slips steadily feels nothing of it, and a body at rest does not creep. It is a dashpot in series with a spring, so it
 * gives no energy.
 */
#include <math.h>

#include "vehicle/internal.h"
#include "vehicle/linear.h"

#define DAMPING 0.5     /* of what is critical */
#define PERIODS 4.0     /* w follows within this many swings / 2 pi */
#define HELD 1e-12      /* 1/kg: an inverse mass that is rounding alone: its joints do not let it move that way */
#define LIGHT 0.25      /* of the mass that the contact carries: the least inverse mass is that of a body as many times heavier */

/* One contact in an engine step. */
struct contact {
	struct soil_geom *geom;
	double stiffness[6][6], damping[6][6]; /* the parts that resist */
	double gain[6][6];      /* dF / du, with the damping of shear */
	double along[2][6];     /* two directions along the ground at the contact, as what gives the velocity there of u */
	double direction[2][3]; /* the same two, in local axes */
	double critical[2], pace[2]; /* N s/m: c; 1/s: how fast w follows */
	double arm[3];          /* m: from the origin to the contact */
	double forward[3];      /* the body's own x axis */
	bool is_load;           /* not a contact, but the soil aboard the geom */
};

struct step {
	struct vehicle *vehicle;
	struct contact *list;   /* of geoms that touch, and then loads; room for all soil geoms */
	size_t touching;        /* of them that touch */
	size_t count, rows;     /* rows: 6 count */
	double h;               /* s */
	double later;           /* s: of the coupling step after this step of the engine */
	double *mass, *jacobian, *solved, *inverse, *system, *force, *free;
};

size_t vehicle_coupling_room(const struct vehicle *vehicle)
{
	const size_t rows = 6 * (vehicle->geom_count + vehicle->carrying_count), nv = (size_t)vehicle->model->nv;
	return nv * nv + 2 * rows * nv + 2 * rows * rows + 2 * rows + 8 * nv + 64;
}

enum status vehicle_make_room(struct vehicle *vehicle)
{
	vehicle->room = mem_calloc(vehicle_coupling_room(vehicle), sizeof *vehicle->room);
	vehicle->contacts = mem_calloc(vehicle->geom_count + vehicle->carrying_count, sizeof *vehicle->contacts);
	return vehicle->room != NULL && vehicle->contacts != NULL ? STATUS_OK : fail_memory("a vehicle");
}

static bool touches(const struct soil_geom *geom)
{
	return geom->contact.state == FURROW_TOUCHING || geom->contact.state == FURROW_SLIDES || geom->contact.state == FURROW_SUNK;
}

static double dot6(const double a[6], const double b[6])
{
	double sum = 0;
	for (int i = 0; i < 6; i++)
		sum += a[i] * b[i];
	return sum;
}

/* --- what a step needs of the engine --- */

static void lay_out(struct step *step)
{
	double *room = step->vehicle->room;
	const size_t nv = (size_t)step->vehicle->model->nv;
	step->mass = room;
	step->jacobian = step->mass + nv * nv;
	step->solved = step->jacobian + step->rows * nv;
	step->inverse = step->solved + step->rows * nv;
	step->system = step->inverse + step->rows * step->rows;
	step->force = step->system + step->rows * step->rows;
	step->free = step->force + step->rows;
}

/* A motor at its greatest force does not give more when it is slower: the engine takes none of its damping then. */
static bool is_at_limit(const struct vehicle *vehicle, int actuator)
{
	const double *range = vehicle->model->actuator_forcerange + 2 * actuator, force = vehicle->data->actuator_force[vehicle->model->actuator_outadr[actuator]];
	return vehicle->model->actuator_forcelimited[actuator] && (force <= range[0] || force >= range[1]);
}

/* Damping of the joints, which the engine's steps take at their end. With the implicit integrators that of motors is, too. */
static double damping_of(const struct vehicle *vehicle, int dof)
{
	const mjModel *model = vehicle->model;
	double damping = model->dof_damping[dof];
	for (int i = 0; i < model->nactuator && (model->opt.integrator == mjINT_IMPLICIT || model->opt.integrator == mjINT_IMPLICITFAST); i++) {
		const double *gear = vehicle_gear(model, i);
		if (model->actuator_trntype[i] == mjTRN_JOINT && model->jnt_dofadr[model->actuator_trnid[2 * i]] == dof &&
		    model->actuator_biastype[i] == mjBIAS_AFFINE && !is_at_limit(vehicle, i))
			damping -= model->actuator_biasprm[i * mjNBIAS + 2] * gear[0] * gear[0];
	}
	return damping > 0 ? damping : 0;
}

/* M + h D */
static void fill_mass(const struct step *step, double *mass)
{
	const mjModel *model = step->vehicle->model;
	mj_fullM(model, step->vehicle->data, mass);
	for (int i = 0; i < model->nv; i++)
		mass[i * model->nv + i] += step->h * damping_of(step->vehicle, i);
}

static void fill_jacobians(const struct step *step)
{
	const mjModel *model = step->vehicle->model;
	mjData *data = step->vehicle->data;
	const size_t nv = (size_t)model->nv;
	for (size_t i = 0; i < step->count; i++) {
		double *rows = step->jacobian + 6 * i * nv;
		const struct soil_geom *geom = step->list[i].geom;
		mj_jacGeom(model, data, rows, rows + 3 * nv, geom->geom);
		for (size_t k = 0; k < 3 && geom->shape.belt; k++)
			rows[k * nv + (size_t)geom->dof] -= geom->sprocket * step->list[i].forward[k];
	}
	mju_copy(step->solved, step->jacobian, (int)(step->rows * nv));
	vehicle_solve_rows(step->mass, step->solved, step->rows, nv);
	for (size_t r = 0; r < step->rows; r++)
		for (size_t c = 0; c < step->rows; c++)
			step->inverse[r * step->rows + c] = mju_dot(step->solved + r * nv, step->jacobian + c * nv, (int)nv);
}

/* The velocities at the step's end without soil. */
static void fill_free(const struct step *step)
{
	const struct vehicle *vehicle = step->vehicle;
	const int nv = vehicle->model->nv;
	for (size_t r = 0; r < step->rows; r++) {
		const double *row = step->jacobian + r * (size_t)nv, *solved = step->solved + r * (size_t)nv;
		step->free[r] = mju_dot(row, vehicle->data->qvel, nv) + step->h * mju_dot(solved, vehicle->data->qfrc_smooth, nv);
	}
}

/* --- one contact --- */

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
static void set_damping(struct step *step, size_t index)
{
	struct contact *contact = &step->list[index];
	const double(*stiffness)[6] = (const double(*)[6])contact->geom->contact.stiffness;
	const double carried = contact->geom->contact.normal_force / mju_norm3(step->vehicle->model->opt.gravity); /* kg */
	for (int k = 0; k < 2; k++) {
		const double *along = contact->along[k];
		double spring = 0, inverse = 0;
		for (int i = 0; i < 3; i++)
			for (int j = 0; j < 3; j++)
				spring -= contact->direction[k][i] * stiffness[i][j] * contact->direction[k][j];
		for (size_t i = 0; i < 6; i++)
			for (size_t j = 0; j < 6; j++)
				inverse += along[i] * step->inverse[(6 * index + i) * step->rows + 6 * index + j] * along[j];
		contact->critical[k] = contact->pace[k] = 0;
		if (!(spring > 0 && inverse > HELD))
			continue;
		/* Several contacts share the mass. What joints and motors hold nearly still seems heavy. Its swing would be slow, and w would lag behind
		 * a steady slip for minutes. */
		const double shared = fmax(inverse * (double)step->touching, carried > 0 ? LIGHT / carried : 0);
		contact->critical[k] = DAMPING * 2 * sqrt(spring / shared);
		contact->pace[k] = sqrt(spring * shared) / PERIODS;
	}
}

/* How far the body, or the belt's lower run, has moved and turned since its contact was linearised. */
static void displacement(const struct vehicle *vehicle, const struct contact *contact, double moved[6])
{
	const struct soil_geom *geom = contact->geom;
	struct furrow_state state;
	struct furrow_belt belt;
	double back[4], turn[4];
	vehicle_geom_state(vehicle, geom, &state, &belt);
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
			to[i][j] = from[i][j] / ((i < 3 ? 1 : length) * (j < 3 ? 1 : length));
}

/* Copies the parts of the contacts' matrices that resist. Rotations are measured in lengths of the body, so that they compare with ways. */
static void take_resisting(struct step *step)
{
	_Static_assert(VEHICLE_ABREAST % 2 == 0, "two matrices of a contact");
	double(*list[VEHICLE_ABREAST])[6];
	size_t listed = 0;
	for (size_t i = 0; i < step->touching; i++) {
		struct contact *contact = &step->list[i];
		const struct furrow_contact *from = &contact->geom->contact;
		const double length = soil_shape_bound(&contact->geom->shape);
		scale_back(from->stiffness, length, contact->stiffness);
		scale_back(from->damping, length, contact->damping);
		list[listed++] = contact->stiffness;
		list[listed++] = contact->damping;
		if (listed < VEHICLE_ABREAST && i + 1 < step->touching)
			continue;
		vehicle_make_negative(list, listed);
		listed = 0;
	}
	for (size_t i = 0; i < step->touching; i++) {
		struct contact *contact = &step->list[i];
		const double length = soil_shape_bound(&contact->geom->shape);
		scale((const double(*)[6])contact->stiffness, length, contact->stiffness);
		scale((const double(*)[6])contact->damping, length, contact->damping);
	}
}

/* Adds the damping of shear to the force and to the gain. */
static void damp(struct contact *contact, const double *free, double *force)
{
	for (int k = 0; k < 2; k++) {
		const double *along = contact->along[k], mean = mju_dot3(contact->geom->mean, contact->direction[k]);
		for (int i = 0; i < 6; i++) {
			force[i] -= contact->critical[k] * along[i] * (dot6(along, free) - mean);
			for (int j = 0; j < 6; j++)
				contact->gain[i][j] -= contact->critical[k] * along[i] * along[j];
		}
	}
}

/* Fills the same for a load. The velocity at its place is [1, -r x] u. */
static void fill_load(struct step *step, size_t index)
{
	struct contact *contact = &step->list[index];
	const struct vehicle *vehicle = step->vehicle;
	const double *r = contact->geom->load_at, weight = contact->geom->load, *free = step->free + 6 * index;
	const double at[3][6] = {{1, 0, 0, 0, r[2], -r[1]}, {0, 1, 0, -r[2], 0, r[0]}, {0, 0, 1, r[1], -r[0], 0}};
	const double rate = weight / (mju_norm3(vehicle->model->opt.gravity) * step->h);
	const size_t nv = (size_t)vehicle->model->nv;
	double *force = step->force + 6 * index;
	for (size_t i = 0; i < 6; i++) {
		force[i] = -weight * at[2][i];
		for (size_t j = 0; j < 6; j++) {
			contact->gain[i][j] = -rate * (at[0][i] * at[0][j] + at[1][i] * at[1][j] + at[2][i] * at[2][j]);
			force[i] += contact->gain[i][j] * (free[j] - mju_dot(step->jacobian + (6 * index + j) * nv, vehicle->data->qvel, (int)nv));
		}
	}
}

/* Fills the force without what the other forces change, for one contact. */
static void fill_rows(struct step *step, size_t index)
{
	struct contact *contact = &step->list[index];
	if (contact->is_load) {
		fill_load(step, index);
		return;
	}
	const struct soil_geom *geom = contact->geom;
	const double *free = step->free + 6 * index, h = step->h;
	double *force = step->force + 6 * index, moved[6], at[6];
	displacement(step->vehicle, contact, moved);
	for (int i = 0; i < 3; i++) {
		at[i] = geom->now.linear[i] - geom->now_belt.speed * contact->forward[i];
		at[3 + i] = geom->now.angular[i];
		force[i] = geom->contact.force[i];
		force[3 + i] = geom->contact.moment[i];
	}
	for (int i = 0; i < 6; i++) {
		for (int j = 0; j < 6; j++) {
			force[i] += contact->stiffness[i][j] * (moved[j] + step->later * at[j] + h * free[j]) + contact->damping[i][j] * (free[j] - at[j]);
			contact->gain[i][j] = h * contact->stiffness[i][j] + contact->damping[i][j];
		}
	}
	damp(contact, free, force);
}

static void fill_system(struct step *step)
{
	take_resisting(step);
	for (size_t i = 0; i < step->count; i++)
		fill_rows(step, i);
	for (size_t r = 0; r < step->rows; r++) {
		const double *gain = step->list[r / 6].gain[r % 6];
		for (size_t c = 0; c < step->rows; c++) {
			double sum = 0;
			for (size_t k = 0; k < 6; k++)
				sum += gain[k] * step->inverse[(r - r % 6 + k) * step->rows + c];
			step->system[r * step->rows + c] = (r == c) - step->h * sum;
		}
	}
}

/* The soil does not pull, and its shear has a limit. */
static void limit(struct contact *contact, double force[6])
{
	const struct furrow_contact *from = &contact->geom->contact;
	const double normal = mju_dot3(force, from->normal), before = mju_dot3(from->force, from->normal);
	double shear[3], given[3];
	if (!(normal > 0)) {
		mju_zero(force, 6);
		return;
	}
	mju_addScl3(shear, force, from->normal, -normal);
	mju_addScl3(given, from->force, from->normal, -before);
	const double most = fmax(isfinite(from->shear_limit) ? from->shear_limit : 0, mju_norm3(given)) * (before > 0 ? fmax(normal / before, 0) : 1);
	const double is = mju_norm3(shear);
	if (!(before > 0) || is <= most)
		return;
	double less[3], moment[3];
	mju_scl3(less, shear, most / is - 1);
	mju_cross(moment, contact->arm, less);
	for (int i = 0; i < 3; i++) {
		force[i] += less[i];
		force[3 + i] += moment[i];
	}
}

/* w goes on: it follows the velocity at the contact at the step's end. */
static void follow(const struct step *step, size_t index)
{
	const struct contact *contact = &step->list[index];
	double end[6];
	for (size_t i = 0; i < 6; i++) {
		end[i] = step->free[6 * index + i];
		for (size_t c = 0; c < step->rows; c++)
			end[i] += step->h * step->inverse[(6 * index + i) * step->rows + c] * step->force[c];
	}
	double mean[3] = {0, 0, 0};
	for (int k = 0; k < 2; k++) {
		const double was = mju_dot3(contact->geom->mean, contact->direction[k]), share = step->h * contact->pace[k];
		mju_addToScl3(mean, contact->direction[k], was + (dot6(contact->along[k], end) - was) * share / (1 + share));
	}
	mju_copy3(contact->geom->mean, mean);
}

/* The body's own x axis, along which a belt runs. */
static void set_forward(struct contact *contact)
{
	double axes[3][3];
	world_axes(contact->geom->now.pose.orientation, axes);
	mju_copy3(contact->forward, axes[0]);
}

/* Lists the geoms that touch, and finds what all of a step needs. Returns false if the mass has no inverse. */
static bool begin(struct step *step)
{
	struct vehicle *vehicle = step->vehicle;
	step->list = vehicle->contacts;
	for (size_t i = 0; i < vehicle->geom_count; i++) {
		struct soil_geom *geom = &vehicle->geoms[i];
		mju_zero(geom->force, 6);
		if (touches(geom))
			step->list[step->count++] = (struct contact){.geom = geom};
		else
			mju_zero3(geom->mean);
	}
	step->touching = step->count;
	for (size_t i = 0; i < vehicle->geom_count && vehicle->carrying_count > 0; i++)
		if (vehicle->geoms[i].load > 0)
			step->list[step->count++] = (struct contact){.geom = &vehicle->geoms[i], .is_load = true};
	step->rows = 6 * step->count;
	lay_out(step);
	if (step->count == 0)
		return true;
	fill_mass(step, step->mass);
	for (size_t i = 0; i < step->count; i++)
		set_forward(&step->list[i]);
	const bool whole = vehicle_factor(step->mass, (size_t)vehicle->model->nv);
	fill_jacobians(step);
	for (size_t i = 0; i < step->touching; i++) {
		set_directions(&step->list[i]);
		set_damping(step, i);
	}
	return whole;
}

/* What of a belt's pull is not in the force along its body's x axis, as a torque on its hinge. Adds it to forces of the joints. Returns it. */
static double turn_back(const struct contact *contact, double *forces)
{
	const struct soil_geom *geom = contact->geom;
	if (!geom->shape.belt || !isfinite(geom->contact.pull))
		return 0;
	const double torque = -geom->sprocket * (geom->contact.pull - mju_dot3(geom->contact.force, contact->forward));
	forces[geom->dof] += torque;
	return torque;
}

void vehicle_couple(struct vehicle *vehicle, double h, double later)
{
	mjData *data = vehicle->data;
	struct step step = {.vehicle = vehicle, .h = h, .later = later};
	const bool whole = begin(&step);
	if (step.count == 0)
		return;
	fill_free(&step);
	fill_system(&step);
	if (!whole || !vehicle_solve(step.system, step.force, step.rows))
		for (size_t r = 0; r < step.rows; r++) /* told as a motion that diverges */
			step.force[r] = NAN;
	for (size_t i = 0; i < step.touching; i++) {
		double *force = step.force + 6 * i;
		limit(&step.list[i], force);
		mju_copy(step.list[i].geom->force, force, 6);
	}
	const size_t nv = (size_t)vehicle->model->nv;
	for (size_t r = 0; r < step.rows; r++)
		mju_addToScl(data->qfrc_applied, step.jacobian + r * nv, step.force[r], (int)nv);
	for (size_t i = 0; i < step.touching; i++) {
		step.list[i].geom->pulled = turn_back(&step.list[i], data->qfrc_applied);
		follow(&step, i);
	}
}

void vehicle_couple_work(struct vehicle *vehicle, double h, const double *before)
{
	const size_t nv = (size_t)vehicle->model->nv;
	const double *after = vehicle->data->qvel, *row = vehicle->room + nv * nv; /* the Jacobians that vehicle_couple laid out */
	for (size_t i = 0; i < vehicle->geom_count; i++) {
		struct soil_geom *geom = &vehicle->geoms[i];
		double power = 0;
		if (!touches(geom))
			continue;
		for (int k = 0; k < 6; k++, row += nv)
			power += geom->force[k] * (mju_dot(row, before, (int)nv) + mju_dot(row, after, (int)nv)) / 2;
		if (geom->shape.belt)
			power += geom->pulled * (before[geom->dof] + after[geom->dof]) / 2;
		geom->work -= power * h;
	}
}

/* M + h D - h J^T G J, by which the soil's forces answer a change of the velocities. */
static void fill_inertia(const struct step *step, double *inertia)
{
	const size_t nv = (size_t)step->vehicle->model->nv;
	fill_mass(step, inertia);
	for (size_t r = 0; r < step->rows; r++)
		for (size_t c = 0; c < 6; c++) {
			const double gain = step->h * step->list[r / 6].gain[r % 6][c];
			const double *left = step->jacobian + r * nv, *right = step->jacobian + (r - r % 6 + c) * nv;
			for (size_t i = 0; i < nv; i++)
				mju_addToScl(inertia + i * nv, right, -gain * left[i], (int)nv);
		}
}

bool vehicle_find_response(struct vehicle *vehicle, double seconds, double *inertia, double *velocity)
{
	const mjData *data = vehicle->data;
	const int nv = vehicle->model->nv;
	struct step step = {.vehicle = vehicle, .h = seconds};
	const bool whole = begin(&step);
	/* The soil's forces at the velocities of now. */
	for (size_t r = 0; r < step.rows; r++)
		step.free[r] = mju_dot(step.jacobian + r * (size_t)nv, data->qvel, nv);
	take_resisting(&step);
	for (size_t i = 0; i < step.count; i++)
		fill_rows(&step, i);
	fill_inertia(&step, inertia);
	mju_copy(velocity, data->qfrc_smooth, nv);
	for (size_t r = 0; r < step.rows; r++)
		mju_addToScl(velocity, step.jacobian + r * (size_t)nv, step.force[r], nv);
	for (size_t i = 0; i < step.touching; i++)
		(void)turn_back(&step.list[i], velocity);
	if (!vehicle_factor(inertia, (size_t)nv))
		return false;
	vehicle_solve_factored(inertia, velocity, (size_t)nv);
	mju_scl(velocity, velocity, seconds, nv);
	mju_addTo(velocity, data->qvel, nv);
	return whole;
}
