/* Probes evaluate the law once, at a given pose, and sum up how the force changes. They change nothing. */
#include "soil/probe.h"

#include <math.h>

#include "soil/contact.h"

/* Turns a matrix from the body's frame to east, north, up: rows, then columns. */
static void turn_matrix(const struct soil_contact *b, const double from[6][6], double to[6][6])
{
	double half[6][6];
	for (int i = 0; i < 6; i++)
		for (int k = 0; k < 6; k += 3)
			soil_contact_turn(b, &from[i][k], &half[i][k]);
	for (int k = 0; k < 6; k++)
		for (int i = 0; i < 6; i += 3) {
			const double column[3] = {half[i][k], half[i + 1][k], half[i + 2][k]};
			double turned[3];
			soil_contact_turn(b, column, turned);
			for (int j = 0; j < 3; j++)
				to[i + j][k] = turned[j];
		}
}

/* The moment is about the centre, which moves with the body. f: the force. */
static void move_centre(const double f[3], double stiffness[6][6])
{
	const double skew[3][3] = {{0, -f[2], f[1]}, {f[2], 0, -f[0]}, {-f[1], f[0], 0}};
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 3; k++)
			stiffness[3 + i][k] += skew[i][k];
}

static double length_of(const double v[3])
{
	return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static enum soil_state state_of(const struct soil_motion *motion, const struct soil_probed *out, const double sheared[3])
{
	if (!(out->area > 0))
		return SOIL_AIR;
	if (out->sinkage > 2 * soil_shape_reach(motion->shape, motion->to.pitch, motion->to.roll))
		return SOIL_SUNK;
	return length_of(sheared) > 0.99 * out->shear_limit ? SOIL_SLIDES : SOIL_TOUCHING;
}

static void tell(const struct soil_contact *b, const struct soil_sums *sums, const struct soil_changes *changes, struct soil_probed *out)
{
	struct soil_forces forces;
	soil_contact_tell(b, sums, 0, SOIL_TOUCHING, &forces);
	turn_matrix(b, changes->stiffness.at, out->stiffness);
	turn_matrix(b, changes->damping.at, out->damping);
	move_centre(forces.force, out->stiffness);
	const double length = length_of(changes->normal);
	soil_contact_turn(b, changes->normal, out->normal);
	for (int k = 0; k < 3; k++) {
		out->force[k] = forces.force[k];
		out->moment[k] = forces.moment[k];
		out->normal[k] = length > 0 ? out->normal[k] / length : (double)NAN;
	}
	out->pull = forces.pull;
	out->normal_force = changes->normal_force;
	out->shear_limit = changes->shear_limit;
	out->sinkage = forces.sinkage;
	out->area = forces.area;
	out->state = state_of(b->motion, out, changes->sheared);
}

static bool has_all(const struct soil_planes *planes, struct post_rect below)
{
	const struct post_rect has = planes->rect;
	return below.x0 > has.x0 && below.y0 > has.y0 && below.x1 < has.x1 && below.y1 < has.y1;
}

enum status soil_probe_among(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, const struct soil_work *const *others,
			      size_t count, struct soil_work *work, struct soil_probed *out)
{
	struct soil_contact *b = &work->contact;
	struct soil_sums sums = {.deepest = 0};
	struct soil_changes changes = {.normal_force = 0};
	*out = (struct soil_probed){.known = false};
	TRY(soil_contact_begin(law, planes, motion, work, 0, b));
	if (count > 0)
		TRY(soil_contact_meet(b, work, others, count, 0));
	if (!has_all(planes, b->below))
		return STATUS_OK;
	out->known = true;
	b->form.rates = 1; /* its velocity is known: soil below a body at rest springs back */
	soil_contact_gather(b, 0);
	if (b->posts->count > 0)
		soil_contact_evaluate(b, 0, 1, &sums, NULL, &changes);
	tell(b, &sums, &changes, out);
	return STATUS_OK;
}

enum status soil_probe(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, struct soil_work *work,
		       struct soil_probed *out)
{
	return soil_probe_among(law, planes, motion, NULL, 0, work, out);
}
