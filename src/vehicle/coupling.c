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
 */
#include <math.h>

#include "vehicle/internal.h"
#include "vehicle/linear.h"
#include "vehicle/powertrain.h"

#define DAMPING 0.5     /* of what is critical */
#define PERIODS 4.0     /* w follows within this many swings / 2 pi */
#define HELD 1e-12      /* 1/kg: an inverse mass that is rounding alone: its joints do not let it move that way */
#define CUT 2.0         /* damping has so many times the whole force: what is summed was cut */
#define CUT_PRESSURE 7e7 /* Pa on a post: nothing is cut below that: a post is cut where one of three components has 134 MPa */
#define CUT_SHARE 0.1   /* of the damping that would just be summed: what is advised */
#define LIGHT 0.25      /* of the mass that the contact carries: the least inverse mass is that of a body as many times heavier */
#define LONE_MOST 6     /* freedoms of a lone body */
#define BRAKE 1e12      /* kg m2: inertia of a wheel that does not turn, */
#define BRAKE_SOFT 1e6  /* or times its own, where constraints act: with more, MuJoCo's solver of constraints does not converge */

/* One contact in an engine step. */
struct contact {
	struct soil_geom *geom;
	double stiffness[6][6], damping[6][6]; /* the parts that resist */
	double gain[6][6];      /* dF / du, with the damping of shear */
	double force[6];        /* N, N m: F(v); once it is at its limit, that */
	double along[2][6];     /* two directions along the ground at the contact, as what gives the velocity there of u */
	double direction[2][3]; /* the same two, in local axes */
	double critical[2], pace[2]; /* N s/m: c; 1/s: how fast w follows */
	double arm[3];          /* m: from the origin to the contact */
	double forward[3];      /* the body's own x axis */
	double *rows;           /* 6 x chain_count: J; owned by the vehicle */
	bool is_load;           /* not a contact, but the soil aboard the geom */
	bool is_limited;        /* at its limit: `force` is all of it */
};

/* A step of the engine, for one vehicle. */
struct step {
	struct vehicle *vehicle;
	double h;               /* s */
	double later;           /* s: of the coupling step after this step of the engine */
	double cut;             /* N: no smaller force was cut */
};

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

/* --- what moves a geom --- */

/* Lists a freedom and those above it. Returns their number. list NULL: only counts. */
static int list_chain(const mjModel *model, int dof, int *list)
{
	int count = 0;
	for (int i = dof; i >= 0; i = model->dof_parentid[i])
		count++;
	for (int i = dof, at = count; i >= 0 && list != NULL; i = model->dof_parentid[i])
		list[--at] = i;
	return count;
}

static int last_dof(const mjModel *model, int body)
{
	while (body > 0 && model->body_dofnum[body] == 0)
		body = model->body_parentid[body];
	return body > 0 ? model->body_dofadr[body] + model->body_dofnum[body] - 1 : -1;
}

static bool is_above(const mjModel *model, int dof, int below)
{
	while (below > dof)
		below = model->dof_parentid[below];
	return below == dof;
}

/* Finds the place of a pair of freedoms in M, row >= column; -1: M has none. */
static int place_in_mass(const mjModel *model, int row, int column)
{
	const int from = model->M_rowadr[row], count = model->M_rownnz[row];
	for (int i = 0; i < count; i++)
		if (model->M_colind[from + i] == column)
			return from + i;
	return -1;
}

static enum status find_places(const struct vehicle *vehicle, struct soil_geom *geom)
{
	const mjModel *model = vehicle->model;
	const int count = geom->chain_count;
	TRY(mem_make(&geom->places, (size_t)(count * (count + 1) / 2) + 1, sizeof *geom->places, "a vehicle"));
	for (int a = 0, at = 0; a < count; a++)
		for (int b = 0; b <= a; b++, at++) {
			geom->places[at] = place_in_mass(model, geom->chain[a], geom->chain[b]);
			if (geom->places[at] >= 0 || (geom->apart && a == count - 1))
				continue;
			geom->lone = true;
			if (geom->apart || count > LONE_MOST)
				return fail_with(STATUS_FAILED, "%s: MuJoCo's inertia has no room for how the soil couples its joints; add a body below its own", geom->name);
		}
	return STATUS_OK;
}

static enum status find_chain(const struct vehicle *vehicle, struct soil_geom *geom)
{
	const mjModel *model = vehicle->model;
	const int last = last_dof(model, model->geom_bodyid[geom->geom]), hinge = geom->shape.belt ? geom->dof : -1;
	int lowest = last;
	geom->hinge_at = -1;
	geom->apart = hinge >= 0 && last >= 0 && !is_above(model, hinge, last) && !is_above(model, last, hinge);
	if (hinge >= 0 && !geom->apart && hinge > last)
		lowest = hinge;
	const int count = list_chain(model, lowest, NULL);
	TRY(mem_make(&geom->chain, (size_t)count + 2, sizeof *geom->chain, "a vehicle"));
	geom->chain_count = list_chain(model, lowest, geom->chain);
	if (geom->apart)
		geom->chain[geom->chain_count++] = hinge;
	for (int i = 0; i < geom->chain_count && hinge >= 0; i++)
		if (geom->chain[i] == hinge)
			geom->hinge_at = i;
	return find_places(vehicle, geom);
}

enum status vehicle_make_room(struct vehicle *vehicle)
{
	size_t numbers = 0;
	for (size_t i = 0; i < vehicle->geom_count; i++) {
		TRY(find_chain(vehicle, &vehicle->geoms[i]));
		numbers += 6 * (size_t)vehicle->geoms[i].chain_count * (vehicle->geoms[i].carries ? 2 : 1);
	}
	vehicle->contacts = mem_calloc(vehicle->geom_count + vehicle->carrying_count + 1, sizeof *vehicle->contacts);
	vehicle->rows = mem_calloc(numbers + 1, sizeof *vehicle->rows);
	return vehicle->contacts != NULL && vehicle->rows != NULL ? STATUS_OK : fail_memory("a vehicle");
}

/* Fills J of each contact. `wide`: room for 6 nv numbers. */
static void fill_jacobians(struct vehicle *vehicle, double *wide)
{
	const mjModel *model = vehicle->model;
	double *next = vehicle->rows;
	for (size_t i = 0; i < vehicle->contact_count; i++) {
		struct contact *contact = &vehicle->contacts[i];
		const struct soil_geom *geom = contact->geom;
		contact->rows = next;
		next += 6 * geom->chain_count;
		mj_jacGeom(model, vehicle->data, wide, wide + 3 * model->nv, geom->geom);
		for (int k = 0; k < 6; k++)
			for (int c = 0; c < geom->chain_count; c++)
				contact->rows[k * geom->chain_count + c] = wide[k * model->nv + geom->chain[c]];
		for (int k = 0; k < 3 && geom->shape.belt; k++)
			contact->rows[k * geom->chain_count + geom->hinge_at] -= geom->sprocket * contact->forward[k];
	}
}

/* u = J v */
static void velocity_of(const struct contact *contact, const double *v, double u[6])
{
	const int count = contact->geom->chain_count;
	for (int k = 0; k < 6; k++) {
		u[k] = 0;
		for (int c = 0; c < count; c++)
			u[k] += contact->rows[k * count + c] * v[contact->geom->chain[c]];
	}
}

/* Adds J^T F to forces of the joints. */
static void add_force(const struct contact *contact, const double force[6], double *forces)
{
	const int count = contact->geom->chain_count;
	for (int c = 0; c < count; c++)
		for (int k = 0; k < 6; k++)
			forces[contact->geom->chain[c]] += contact->rows[k * count + c] * force[k];
}

/* --- the inertia --- */

/* Fills -h J^T G J of a lone geom: n x n. */
static void lone_gain(const struct contact *contact, double h, double *matrix)
{
	const int n = contact->geom->chain_count;
	for (int a = 0; a < n; a++)
		for (int b = 0; b < n; b++) {
			double sum = 0;
			for (int i = 0; i < 6; i++)
				for (int j = 0; j < 6; j++)
					sum -= h * contact->rows[i * n + a] * contact->gain[i][j] * contact->rows[j * n + b];
			matrix[a * n + b] = sum;
		}
}

/* Adds a diagonal that is at least as stiff. */
static void add_lone_gain(const struct contact *contact, double h, double *mass)
{
	const int n = contact->geom->chain_count;
	double matrix[LONE_MOST * LONE_MOST];
	lone_gain(contact, h, matrix);
	for (int a = 0; a < n; a++) {
		double sum = 0;
		for (int b = 0; b < n; b++) {
			const double product = matrix[a * n + a] * matrix[b * n + b];
			sum += product > 0 ? fabs(matrix[a * n + b]) * matrix[a * n + a] / sqrt(product) : 0;
		}
		mass[contact->geom->places[a * (a + 1) / 2 + a]] += sum;
	}
}

/* Adds -h J^T G J. */
static void add_gain(const struct contact *contact, double h, double *mass)
{
	const struct soil_geom *geom = contact->geom;
	const int count = geom->chain_count;
	const double factor = geom->apart ? -2 * h : -h;
	const int *place = geom->places;
	if (geom->lone) {
		add_lone_gain(contact, h, mass);
		return;
	}
	for (int a = 0; a < count; a++) {
		double gained[6];
		for (int i = 0; i < 6; i++) {
			gained[i] = 0;
			for (int j = 0; j < 6; j++)
				gained[i] += contact->gain[i][j] * contact->rows[j * count + a];
		}
		for (int b = 0; b <= a; b++, place++) {
			double sum = 0;
			for (int i = 0; i < 6; i++)
				sum += contact->rows[i * count + b] * gained[i];
			if (*place >= 0)
				mass[*place] += factor * sum;
		}
	}
}

double vehicle_damping_of(const struct vehicle *vehicle, int dof)
{
	const mjModel *model = vehicle->model;
	double damping = model->dof_damping[dof];
	const bool motors = model->opt.integrator == mjINT_IMPLICIT || model->opt.integrator == mjINT_IMPLICITFAST;
	for (int i = vehicle->own.actuator.first; i < vehicle->own.actuator.end && motors; i++) {
		const double *gear = vehicle_gear(model, i);
		if (model->actuator_trntype[i] == mjTRN_JOINT && model->jnt_dofadr[model->actuator_trnid[2 * i]] == dof &&
		    model->actuator_biastype[i] == mjBIAS_AFFINE)
			damping -= model->actuator_biasprm[i * mjNBIAS + 2] * gear[0] * gear[0];
	}
	return damping > 0 ? damping : 0;
}

static double *diagonal_of(const mjModel *model, double *mass, int dof)
{
	return mass + model->M_rowadr[dof] + model->M_rownnz[dof] - 1;
}

/* The inverse mass along a direction at a contact: y^T M^-1 y with y = J^T along. M is factored, L^T D L. `work`: chain_count numbers. */
static double inverse_mass(const struct vehicle *vehicle, const struct contact *contact, const double along[6], double *work)
{
	const mjData *data = vehicle->data;
	const struct soil_geom *geom = contact->geom;
	const int count = geom->chain_count;
	double sum = 0;
	for (int c = 0; c < count; c++) {
		work[c] = 0;
		for (int k = 0; k < 6; k++)
			work[c] += contact->rows[k * count + c] * along[k];
	}
	for (int c = count - 1; c >= 0; c--) {
		const int *places = geom->places + c * (c + 1) / 2;
		for (int b = 0; b < c; b++)
			if (places[b] >= 0)
				work[b] -= data->qLD[places[b]] * work[c];
		sum += work[c] * work[c] * data->qLDiagInv[geom->chain[c]];
	}
	return sum;
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
static void set_damping(const struct vehicle *vehicle, struct contact *contact, double *work)
{
	const double(*stiffness)[6] = (const double(*)[6])contact->geom->contact.stiffness;
	const double carried = contact->geom->contact.normal_force / mju_norm3(vehicle->model->opt.gravity); /* kg */
	for (int k = 0; k < 2; k++) {
		double spring = 0;
		for (int i = 0; i < 3; i++)
			for (int j = 0; j < 3; j++)
				spring -= contact->direction[k][i] * stiffness[i][j] * contact->direction[k][j];
		const double inverse = inverse_mass(vehicle, contact, contact->along[k], work);
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
		for (int i = 0; i < 6; i++) {
			contact->force[i] -= contact->critical[k] * along[i] * (dot6(along, u) - mean);
			for (int j = 0; j < 6; j++)
				contact->gain[i][j] -= contact->critical[k] * along[i] * along[j];
		}
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
	velocity_of(contact, step->vehicle->data->qvel, u);
	displacement(step->vehicle, contact, moved);
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
	for (int i = 0; i < 6; i++)
		for (int j = 0; j < 6; j++) {
			force[i] += contact->stiffness[i][j] * goes[j] + contact->damping[i][j] * gains[j];
			contact->gain[i][j] = h * contact->stiffness[i][j] + contact->damping[i][j];
		}
	damp(contact, u);
}

/* The soil does not pull, and its shear has a limit. Returns true if the force is another one by that. */
static bool limit(const struct contact *contact, double force[6])
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

/* w goes on: it follows the velocity at the contact at the step's end. */
static void follow(const struct contact *contact, double h, const double *after)
{
	double end[6], mean[3] = {0, 0, 0};
	velocity_of(contact, after, end);
	for (int k = 0; k < 2; k++) {
		const double was = mju_dot3(contact->geom->mean, contact->direction[k]), share = h * contact->pace[k];
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

/* What of a belt's pull is not in the force along its body's x axis, as a torque on its hinge. */
static double turn_back(const struct contact *contact)
{
	const struct soil_geom *geom = contact->geom;
	if (!geom->shape.belt || !isfinite(geom->contact.pull))
		return 0;
	return -geom->sprocket * (geom->contact.pull - mju_dot3(geom->contact.force, contact->forward));
}

/* --- a step --- */

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
		set_forward(&vehicle->contacts[i]);
}

/* Finds forces and gains of all contacts of a vehicle. M + h D is factored. */
static void fill_contacts(const struct step *step)
{
	struct vehicle *vehicle = step->vehicle;
	for (size_t i = 0; i < vehicle->touching; i++) {
		set_directions(&vehicle->contacts[i]);
		set_damping(vehicle, &vehicle->contacts[i], vehicle->room);
	}
	take_resisting(vehicle);
	for (size_t i = 0; i < vehicle->contact_count; i++)
		if (vehicle->contacts[i].is_load)
			fill_load(step, &vehicle->contacts[i]);
		else
			fill_contact(step, &vehicle->contacts[i]);
}

/* Returns true if the vehicle has equalities, limits, friction of joints, or tendons, or touches another one. */
static bool is_constrained(const struct vehicle *vehicle)
{
	const mjModel *model = vehicle->model;
	const mjData *data = vehicle->data;
	bool any = range_count(vehicle->own.equality) > 0 || range_count(vehicle->own.tendon) > 0;
	for (int i = vehicle->own.joint.first; i < vehicle->own.joint.end && !any; i++)
		any = model->jnt_limited[i];
	for (int i = vehicle->own.dof.first; i < vehicle->own.dof.end && !any; i++)
		any = model->dof_frictionloss[i] > 0 || (data->nefc > 0 && (data->nisland == 0 || data->dof_island[i] >= 0));
	return any;
}

/* Holds braked wheels still: adds an inertia to their hinges that no torque of a vehicle can turn. */
static void brake(const struct vehicle *vehicle, double *mass)
{
	const bool constrained = is_constrained(vehicle);
	for (size_t g = 0; g < vehicle->geom_count; g++) {
		const struct soil_geom *geom = &vehicle->geoms[g];
		const int dof = vehicle_turning_dof(geom);
		bool again = dof < 0; /* several geoms may share a hinge */
		for (size_t before = 0; before < g && !again; before++)
			again = vehicle_turning_dof(&vehicle->geoms[before]) == dof;
		if (!again)
			*diagonal_of(vehicle->model, mass, dof) += constrained ? BRAKE_SOFT * vehicle->model->dof_M0[dof] : BRAKE;
	}
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
			add_force(contact, contact->force, data->qfrc_applied);
			if (!contact->is_limited)
				add_gain(contact, h, data->M);
			if (!contact->is_load && contact->geom->shape.belt)
				data->qfrc_applied[contact->geom->dof] += contact->geom->pulled = turn_back(contact);
		}
		if (!drives)
			brake(vehicle, data->M);
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
		fill_jacobians(vehicle, vehicles->room);
		any = any || vehicle->touching > 0;
		for (int i = vehicle->own.dof.first; i < vehicle->own.dof.end; i++)
			*diagonal_of(model, data->M, i) += h * vehicle_damping_of(vehicle, i) + (vehicle_train_holds(vehicle, i) ? BRAKE_SOFT * model->dof_M0[i] : 0);
	}
	if (any)
		mj_factorM(model, data);
	for (size_t v = 0; v < vehicles->all; v++)
		fill_contacts(&(struct step){&vehicles->list[v], h, later, CUT_PRESSURE * spacing * spacing});
	apply(vehicles, h, drives);
}

/*
 * Solves the equations of the lone body of a contact, from the change of the velocities that the stiffer diagonal has let. All its contacts get the
 * forces of that solution, at their limits. Returns false if there is no solution.
 */
static bool solve_lone(const struct vehicles *vehicles, struct vehicle *vehicle, const struct soil_geom *geom, double h, const double *change)
{
	const mjModel *model = vehicles->model;
	const int n = geom->chain_count;
	double matrix[LONE_MOST * LONE_MOST] = {0}, rate[LONE_MOST], part[LONE_MOST * LONE_MOST];
	for (int a = 0; a < n; a++) {
		const int dof = geom->chain[a];
		const double damped = h * vehicle_damping_of(vehicle, dof);
		matrix[a * n + a] = *diagonal_of(model, vehicles->mass, dof) + damped;
		rate[a] = (*diagonal_of(model, vehicles->data->M, dof) + damped) * change[dof] / h; /* q, with the forces of the contacts */
	}
	for (size_t i = 0; i < vehicle->contact_count; i++) {
		const struct contact *contact = &vehicle->contacts[i];
		if (contact->geom->chain[0] != geom->chain[0] || contact->is_limited)
			continue;
		lone_gain(contact, h, part);
		mju_addTo(matrix, part, n * n);
	}
	if (!vehicle_solve(matrix, rate, (size_t)n))
		return false;
	for (size_t i = 0; i < vehicle->contact_count; i++) {
		struct contact *contact = &vehicle->contacts[i];
		double u[6];
		if (contact->geom->chain[0] != geom->chain[0] || contact->is_limited)
			continue;
		for (int k = 0; k < 6; k++) {
			u[k] = 0;
			for (int c = 0; c < n; c++)
				u[k] += contact->rows[k * n + c] * h * rate[c];
		}
		for (int k = 0; k < 6; k++)
			contact->force[k] += dot6(contact->gain[k], u);
		contact->is_limited = true;
		if (!contact->is_load)
			limit(contact, contact->force);
	}
	return true;
}

/* Finds the force of a contact once the velocities have changed. */
static void force_after(const struct contact *contact, const double *change, double force[6])
{
	double u[6];
	mju_copy(force, contact->force, 6);
	if (contact->is_limited)
		return;
	velocity_of(contact, change, u);
	for (int k = 0; k < 6; k++)
		force[k] += dot6(contact->gain[k], u);
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
				again |= solve_lone(vehicles, vehicle, vehicle->contacts[i].geom, h, change);
		for (size_t i = 0; i < vehicle->touching; i++) {
			struct contact *contact = &vehicle->contacts[i];
			double *force = contact->geom->force;
			force_after(contact, change, force);
			if (contact->is_limited || !limit(contact, force))
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
			follow(contact, h, after);
			velocity_of(contact, before, from);
			velocity_of(contact, after, to);
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
			add_force(contact, force, forces);
			if (!contact->is_load && contact->geom->shape.belt)
				forces[contact->geom->dof] += contact->geom->pulled;
		}
}
