/* Which posts and which parts of their cells a probed body covers, how low it is there, and how long it has been. */
#include <math.h>

#include "deform/probe/face.h"


#define HALVINGS 30 /* of the share of a motion */

/* --- the lower envelope --- */

/* Gives the lower envelope above a place in the end pose. *away is above 0 if the body was lower there shortly before, below 0 if it was
 * higher. */
static bool placed(const struct probe_form *form, const double at[2], double *height, double *away)
{
	struct lower_place place;
	if (!soil_lower_at(&form->lower, form->axis[0] * at[0] - form->axis[1] * at[1], form->axis[1] * at[0] + form->axis[0] * at[1], &place))
		return false;
	const double *n = place.normal, ahead = form->axis[0] * n[0] + form->axis[1] * n[1], aside = form->axis[0] * n[1] - form->axis[1] * n[0];
	*height = place.z;
	*away = form->way[0] * ahead + form->way[1] * aside + form->way[2] * n[2];
	return true;
}

/* The same at a share of the motion, back from its end. */
static bool placed_before(const struct probe_form *form, const double at[2], double share, double *height, double *away)
{
	const double there[2] = {at[0] + share * form->way[0], at[1] + share * form->way[1]};
	if (!placed(form, there, height, away))
		return false;
	*height -= share * form->way[2];
	return true;
}

/* Returns the lowest height of a convex body above a place during its motion. The height is a convex function of the time. now: at the
 * end. away: what placed gave. */
static double lowest_of(const struct probe_form *form, const double at[2], double now, double away)
{
	double lowest = now, height, inside = 0, outside = 1;
	if (form->way[0] == 0 && form->way[1] == 0)
		return now - fmax(form->way[2], 0);
	if (away <= 0)
		return now;
	if (placed_before(form, at, 1, &height, &away)) {
		lowest = fmin(lowest, height);
		if (away >= 0)
			return lowest;
	}
	for (int k = 0; k < HALVINGS; k++) {
		const double middle = 0.5 * (inside + outside);
		const bool over = placed_before(form, at, middle, &height, &away);
		lowest = over ? fmin(lowest, height) : lowest;
		*(over && away > 0 ? &inside : &outside) = middle;
	}
	return lowest;
}

static bool over_ball(const struct probe_form *form, const double at[2], double *height)
{
	const double r = form->radius, squares = at[0] * at[0] + (form->kind == SOIL_SPHERE ? at[1] * at[1] : 0);
	*height = -probe_root(r * r - squares);
	return squares <= r * r * (1 + 1e-12) && (form->kind == SOIL_SPHERE || fabs(at[1]) <= form->half[1] + PROBE_BESIDE);
}

/* Adds what is known only at posts. */
static bool lower(bool over, double low, double *height)
{
	if (low < INFINITY)
		*height = over ? probe_least(*height, low) : low;
	return over || low < INFINITY;
}

bool deform_form_rests(const struct probe_form *form, size_t number, const double at[2], double *height)
{
	bool over = false;
	double away;
	if (form->kind == SOIL_WHEEL || form->kind == SOIL_SPHERE)
		over = over_ball(form, at, height);
	else if (form->kind != SOIL_MESH)
		over = placed(form, at, height, &away);
	return form->low.rests != NULL ? lower(over, form->low.rests[number], height) : over;
}

bool deform_form_over(const struct probe_form *form, size_t number, const double at[2], double *height, double *lowest)
{
	bool over = false;
	double away = 0, since;
	*lowest = INFINITY;
	if (form->kind == SOIL_WHEEL || form->kind == SOIL_SPHERE) {
		over = over_ball(form, at, height);
		*lowest = *height - (form->run > 0 ? probe_lowered(form, at, form->run, 0, &since) : probe_most(form->way[2], 0));
	} else if (form->kind != SOIL_MESH) {
		over = placed(form, at, height, &away);
		*lowest = over ? lowest_of(form, at, *height, away) : INFINITY;
	}
	if (form->low.rests == NULL)
		return over;
	*lowest = over ? probe_least(*lowest, form->low.lowest[number]) : form->low.lowest[number];
	return lower(over, form->low.rests[number], height);
}

/* The slope at a post between two others: no more than twice each of them. */
static double middle_slope(double before, double after)
{
	const double least = 2 * probe_least(fabs(before), fabs(after));
	return before * after > 0 ? probe_clamp(0.5 * (before + after), -least, least) : 0;
}

void deform_form_own(const struct probe_form *form, size_t number, double own[2])
{
	own[0] = own[1] = 0;
	if (form->kind == SOIL_CYLINDER && !probe_strips(form))
		own[0] = 2 * form->half_axis * form->level < 0.25 * form->spacing ? 1 : 2;
	if (form->kind != SOIL_MESH || !(form->low.rests[number] < INFINITY))
		return;
	for (int k = 0; k < 2; k++) {
		const size_t next = k == 0 ? 1 : form->low.width;
		const double here = form->low.rests[number], before = form->low.rests[number - next], after = form->low.rests[number + next];
		const double low = before < INFINITY ? here - before : 0, high = after < INFINITY ? after - here : 0;
		own[k] = (before < INFINITY && after < INFINITY ? middle_slope(low, high) : low + high) / form->spacing;
	}
}

/* --- the time --- */

static double until_beyond(double at, double size, double speed)
{
	return size > 0 && fabs(speed) > 1e-9 ? fmax(size - at * copysign(1, speed), 0) / fabs(speed) : 1e3;
}

/* When the circle in which the body is cut along its motion leaves the place. gains: as in deform_form_share. */
static double share_of_ring(const struct probe_form *form, const double at[2], double gains)
{
	double squares, ahead;
	probe_ring(form, at, &squares, &ahead);
	const double level = gains / form->lift - probe_root(squares - ahead * ahead);
	const double moves = form->run * form->run + form->plunge * form->plunge;
	const double nears = ahead * form->run + level * form->plunge, beyond = ahead * ahead + level * level - squares;
	const double root = nears * nears - moves * beyond;
	if (!(moves > 0))
		return 1e3;
	return root >= 0 ? -beyond / fmax(nears + sqrt(root), 1e-18) : -4;
}

double deform_form_share(const struct probe_form *form, const double own[2], const double at[2], double depth, double stays,
			 const struct probe_face *now, bool over)
{
	const double gains = depth - stays;
	double share = 1e3;
	if (probe_is_round(form)) {
		share = share_of_ring(form, at, gains);
	} else {
		const double before[2] = {at[0] + form->way[0], at[1] + form->way[1]};
		const double speed = probe_height_at(form, own, before) - now->height - form->way[2];
		if (speed > 0)
			share = gains / speed;
	}
	if (form->kind == SOIL_BOX && over)
		share = fmin(share, until_beyond(at[0], form->half[0], form->way[0]));
	if (form->half[1] > 0 && over)
		share = fmin(share, until_beyond(probe_aside(form, at), form->half[1], form->way[1]));
	return fmin(fmax(share, -4), 1e3);
}

/* --- parts of cells --- */

/* Adds one direction: what the post bears of a strip, half way to the next post that is covered too, or to the strip's side. */
static void part_of(const struct probe_form *form, double at, double size, double part[2], bool sides[2])
{
	sides[0] = !(fabs(at - form->step_aside) <= size + PROBE_BESIDE);
	sides[1] = !(fabs(at + form->step_aside) <= size + PROBE_BESIDE);
	part[0] = sides[0] ? fmax((-size - at) * form->by_step, -1) : -0.5;
	part[1] = sides[1] ? fmin((size - at) * form->by_step, 1) : 0.5;
}

/* As part_of. The sides of a cylinder that leans are not straight. */
static void part_between(const struct probe_form *form, const double at[2], double part[2], bool sides[2])
{
	const double *cut = form->cut[1], below[2] = {at[0] - cut[0], at[1] - cut[1]}, beyond[2] = {at[0] + cut[0], at[1] + cut[1]};
	const double here = probe_aside(form, at), lower = probe_aside(form, below), upper = probe_aside(form, beyond), size = form->half[1];
	const double least = 0.25 * form->step_aside;
	sides[0] = !(fabs(lower) <= size + PROBE_BESIDE);
	sides[1] = !(fabs(upper) <= size + PROBE_BESIDE);
	part[0] = sides[0] ? fmax((-size - here) / fmax(here - lower, least), -1) : -0.5;
	part[1] = sides[1] ? fmin((size - here) / fmax(upper - here, least), 1) : 0.5;
}

static bool bears_beside(const struct probe_form *form, const double at[2], double aside, bool narrow)
{
	const bool between = narrow && fabs(aside - 1e-4 * form->step_aside) <= 0.5 * form->step_aside;
	return (form->kind == SOIL_WHEEL || form->kind == SOIL_CYLINDER) && fabs(at[0]) < form->radius + form->half_across &&
	       (between || (fabs(at[0]) > form->radius && fabs(aside) <= form->half[1]));
}

/* Gives the part across a body whose sides are known. Returns its share. */
static double part_across(const struct probe_form *form, const double at[2], bool over, double middle[2], bool sides[2])
{
	const double size = form->half[1], aside = probe_aside(form, at);
	const bool narrow = 2 * size < form->step_aside;
	double part[2];
	if (form->kind == SOIL_CYLINDER) {
		part_between(form, at, part, sides);
		over = over && fabs(aside) <= size + PROBE_BESIDE;
	} else {
		part_of(form, at[1], size, part, sides);
	}
	if (!over && !bears_beside(form, at, aside, narrow))
		return 0;
	if (!over && narrow) {
		part[0] = (-size - aside) * form->by_step;
		part[1] = (size - aside) * form->by_step;
	}
	for (int k = 0; k < 2; k++)
		middle[k] = 0.5 * (part[0] + part[1]) * form->cut[1][k];
	return fmax(part[1] - part[0], 0);
}

double deform_form_part(const struct probe_form *form, const double at[2], bool over, double middle[2], bool sides[4])
{
	double share = over ? 1 : 0;
	middle[0] = middle[1] = 0;
	sides[0] = sides[1] = sides[2] = sides[3] = false;
	if (form->half[1] > 0)
		share = part_across(form, at, over, middle, sides + 2);
	if (form->kind == SOIL_BOX && form->half[0] > 0 && form->half[1] > 0) {
		double part[2];
		part_of(form, at[0], form->half[0], part, sides);
		share *= fmax(part[1] - part[0], 0);
		for (int k = 0; k < 2; k++)
			middle[k] += 0.5 * (part[0] + part[1]) * form->cut[0][k];
	}
	return share;
}
