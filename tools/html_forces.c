/*
 * Forces along the ground, and energy into the soil, of the rows of objects.csv:
 *
 *     traction = F . t                 t: the direction of the way along the ground as it was, in space: of the centre's way, raised by the sinkage
 *     grade    = W t_z                 W: the load; without one the soil's upward force, as of a vehicle's wheel
 *     drawbar  = traction - grade      what is left to pull with. On level ground it is the traction
 *
 * and between two rows, with the means of F and M:
 *
 *     push     = F . dp                dp: the way of the centre, in space. F without the weight of soil aboard
 *     soil     = torque - push         of a vehicle the soil's part is the column `work`, and the torque's work follows from it
 *     torque   = -(M . a) ds / (r (1 - slip))      only of a wheel; a: its axle, to the left; ds: its way along the ground
 *     axle's torque = -(M . a)         of a wheel, and of a vehicle's soil geom; a: level, to the left of the way
 *     Of a shape that carries soil, and does not turn by itself, the column `work` has its turns, too: push = -work.
 *     by slip  = slip x torque         a wheel with the torque's force T / r loses T / r x slip x rim's way to slip (Wong, ch. 4)
 *
 * F, M: the soil's force and moment on the object.
 */
#include <math.h>

#include "html_row.h"

#define SLIP_MOST 0.99  /* above it a wheel turns almost in place, so its angle cannot be computed from its way */
#define TURN_WAY 0.05   /* m in plan from which the direction of the way is taken */
#define SLOPE_WAY 0.25  /* m in plan: the slope is a mean over once to twice that */
#define LOSS_WAY 0.1    /* m in plan over which the energy for each metre is a mean */

static double dot(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double level_between(const double a[3], const double b[3])
{
	return hypot(b[0] - a[0], b[1] - a[1]);
}

static void copy(const double from[3], double to[3])
{
	for (int k = 0; k < 3; k++)
		to[k] = from[k];
}

/* The ground as it was, at this row: its height has an unknown but constant offset. */
static void ground_of(const struct html_row *row, double ground[3])
{
	copy(row->place, ground);
	ground[2] += row->sinkage;
}

/* Finds the direction of the way at this row. The slope is a mean over a longer way, since sinkage is as coarse as posts are. `went`: m in
 * plan since the row before. */
static void find_direction(const struct html_row *last, struct html_row *row, double went)
{
	double ground[3];
	ground_of(row, ground);
	copy(last->mark, row->mark);
	copy(last->older, row->older);
	copy(last->newer, row->newer);
	copy(last->tangent, row->tangent);
	row->moved = last->moved;
	const double level = level_between(row->mark, ground);
	if (!row->moved && went == 0) { /* what it sinks before it moves is no slope */
		copy(ground, row->mark);
		copy(ground, row->older);
		copy(ground, row->newer);
	}
	if (level < TURN_WAY)
		return;
	const double far = level_between(row->older, ground), slope = far > 0 ? (ground[2] - row->older[2]) / far : 0, length = sqrt(1 + slope * slope);
	row->tangent[0] = (ground[0] - row->mark[0]) / level / length;
	row->tangent[1] = (ground[1] - row->mark[1]) / level / length;
	row->tangent[2] = slope / length;
	row->moved = true;
	copy(ground, row->mark);
	if (level_between(row->newer, ground) >= SLOPE_WAY) {
		copy(row->newer, row->older);
		copy(ground, row->newer);
	}
}

/* The soil's force without the weight of what is aboard. */
static double cuts(const struct html_row *row, int axis)
{
	return row->force[axis] + (axis == 2 && isfinite(row->weight) ? row->weight : 0);
}

static double weight_of(const struct html_row *row)
{
	return row->load > 0 ? row->load : cuts(row, 2);
}

static void fill_forces(struct html_body *body, const struct html_row *row, const double tangent[3], size_t at)
{
	const double grade = weight_of(row) * tangent[2];
	body->values[HTML_TRACTION][at] = dot(row->force, tangent);
	body->values[HTML_GRADE][at] = grade;
	body->values[HTML_DRAWBAR][at] = dot(row->force, tangent) - grade;
	const double level = hypot(tangent[0], tangent[1]);
	if (row->radius > 0 || (isnan(row->radius) && isfinite(row->work))) /* a wheel, or a soil geom of a vehicle */
		body->values[HTML_TORQUE][at] = (row->moment[0] * tangent[1] - row->moment[1] * tangent[0]) / level;
	if (weight_of(row) > 0)
		body->steepest = fmax(body->steepest, fabs(tangent[2]));
}

/* Returns the work of the torque between two rows, J. NaN: not known. */
static double torque_between(const struct html_row *a, const struct html_row *b, double went)
{
	if (isnan(a->radius) || a->radius == 0)
		return a->radius;
	const double slip = (a->slip + b->slip) / 2;
	if (!(slip < SLIP_MOST))
		return (double)NAN;
	if (went == 0)
		return 0;
	const double axle[3] = {-(b->place[1] - a->place[1]) / went, (b->place[0] - a->place[0]) / went, 0};
	double moment[3];
	for (int k = 0; k < 3; k++)
		moment[k] = (a->moment[k] + b->moment[k]) / 2;
	const double rolled = a->flat ? went : hypot(went, b->place[2] - a->place[2]); /* as the world rolls it */
	return -dot(moment, axle) * rolled / (a->radius * (1 - slip));
}

/* Adds what happened between two rows. */
static void add_energy(struct html_energy *energy, const struct html_row *a, const struct html_row *b, double went)
{
	double push = 0, climb = 0;
	for (int k = 0; k < 3; k++)
		push += (cuts(a, k) + cuts(b, k)) / 2 * (b->place[k] - a->place[k]);
	climb = (weight_of(a) + weight_of(b)) / 2 * (b->place[2] - a->place[2]);
	const bool told = isfinite(a->work) && isfinite(b->work);
	if (told && a->radius == 0)
		push = a->work - b->work;
	const double soil = told ? b->work - a->work : torque_between(a, b, went) - push, torque = soil + push;
	const double slip = (a->slip + b->slip) / 2;
	energy->soil += soil / 1e3;
	energy->torque += torque / 1e3;
	energy->push += push / 1e3;
	energy->climb += climb / 1e3;
	energy->slip += torque > 0 && slip > 0 ? fmin(slip, 1) * torque / 1e3 : torque * 0; /* NaN stays */
}

/* Fills the energy for each metre since the row where it was known last, once there is enough way. */
static void fill_loss(struct html_body *body, struct html_row *row, size_t at)
{
	const double *way = body->way, *energy = body->values[HTML_ENERGY];
	body->values[HTML_LOSS][at] = (double)NAN;
	if (way[at] - way[row->paid] < LOSS_WAY)
		return;
	const double loss = 1e3 * (energy[at] - energy[row->paid]) / (way[at] - way[row->paid]);
	for (size_t i = row->paid == 0 ? 0 : row->paid + 1; i <= at; i++)
		body->values[HTML_LOSS][i] = loss;
	row->paid = at;
}

void html_forces_take(struct html_body *body, struct html_row *row, double went)
{
	const struct html_row *last = body->last;
	const size_t at = body->count;
	double *const *values = body->values;
	values[HTML_SINKAGE][at] = row->sinkage * 1e3;
	values[HTML_SLIP][at] = row->slip;
	values[HTML_VERTICAL][at] = row->force[2];
	values[HTML_TRACTION][at] = values[HTML_GRADE][at] = values[HTML_DRAWBAR][at] = values[HTML_LOSS][at] = values[HTML_TORQUE][at] = (double)NAN;
	row->radius = last->radius;
	row->flat = last->flat;
	if (at == 0) {
		ground_of(row, row->mark);
		copy(row->mark, row->older);
		copy(row->mark, row->newer);
		if (isnan(row->radius) && isnan(row->work))
			body->energy.soil = body->energy.torque = body->energy.slip = (double)NAN;
	} else {
		row->paid = last->paid;
		find_direction(last, row, went);
		add_energy(&body->energy, last, row, went);
	}
	values[HTML_ENERGY][at] = body->energy.soil;
	values[HTML_PUSH][at] = body->energy.push;
	if (at > 0)
		fill_loss(body, row, at);
	if (row->moved)
		fill_forces(body, row, row->tangent, at);
	if (row->moved && at == 1) /* the first row looks along the way to the second */
		fill_forces(body, last, row->tangent, 0);
}
