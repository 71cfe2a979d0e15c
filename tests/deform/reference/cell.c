/*
 * The cell of a post: what of it the object covers, and what that bears. Stresses act along the object's underside, on its own area;
 * or along the ground's normal. They are summed at two places of Gauss's rule, on the line across the cell on which the depth changes.
 */
#include <math.h>

#include "deform/reference/scm.h"

#define STEEPEST 19.974984
#define LEAST 1.2e-6 /* m: what rounding to 2^-20 m may do to a sinkage, and to a height */

/* The object in its end pose, seen from above. Places are from its centre. */
struct form {
	const struct soil_shape *shape;
	double forward[2];      /* unit vector */
	double half[2];         /* half of its size forwards and to the left; 0: it has no straight sides there */
	double way[3], run;     /* its motion; how much of that is forwards, of a wheel; all, of a sphere */
	double faces[3][3];     /* box: lower faces: height at the centre, rise to the east and to the north */
	double rim, dig;        /* time of the rim, or of a belt, of the soil's, to shear and to dig; 0: they are the same */
	double level;           /* of a belt: how much of the body's left axis is level */
};

struct underside {
	double z, rise[2];
};

static bool is_round(const struct form *form)
{
	return form->shape->kind == SOIL_WHEEL || form->shape->kind == SOIL_SPHERE;
}

/* A unit vector of the box's, in the world. */
static struct vector axis_of(const struct soil_pose *pose, int k)
{
	double cy = cos(pose->yaw), sy = sin(pose->yaw), cp = cos(pose->pitch), sp = sin(pose->pitch);
	double cr = cos(pose->roll), sr = sin(pose->roll);
	struct vector v = k == 0 ? (struct vector){1, 0, 0} : k == 1 ? (struct vector){0, cr, sr} : (struct vector){0, -sr, cr};
	v = (struct vector){cp * v.x - sp * v.z, v.y, sp * v.x + cp * v.z};
	return (struct vector){cy * v.x - sy * v.y, sy * v.x + cy * v.y, v.z};
}

static void box_form(const struct soil_pose *pose, struct form *form)
{
	const double *size = form->shape->size;
	for (int k = 0; k < 3; k++) {
		struct vector axis = axis_of(pose, k);
		bool upright = fabs(axis.z) < 1e-6;
		form->faces[k][0] = upright ? -INFINITY : -size[k] / 2 / fabs(axis.z);
		form->faces[k][1] = upright ? 0 : -axis.x / axis.z;
		form->faces[k][2] = upright ? 0 : -axis.y / axis.z;
	}
	if (pose->pitch != 0 && pose->roll != 0)
		return;
	form->half[0] = (fabs(cos(pose->pitch)) * size[0] + fabs(sin(pose->pitch)) * size[2]) / 2;
	form->half[1] = (fabs(cos(pose->roll)) * size[1] + fabs(sin(pose->roll)) * size[2]) / 2;
}

/* Posts pass by the way in plan. The body goes, and digs, along the ground. */
static void put_times(struct form *form, double ran, double length, double ahead)
{
	const double ways[2] = {length, reference_along(length, ahead, form->way[2])}, run = fabs(ran);
	double *times[2] = {&form->rim, &form->dig};
	for (int k = 0; k < 2; k++) {
		double share = run > 0.1 * ways[k] ? fmax(ways[k] / run, 0.1) : 10;
		*times[k] = length > 0 ? 1 + (share - 1) * pow(ahead / length, 2) : 1;
	}
}

static struct form form_of(const struct reference_ground *ground, const struct deform_contact *sweep)
{
	struct form form = {.shape = sweep->shape, .forward = {cos(sweep->to.yaw), sin(sweep->to.yaw)}};
	struct vector way = reference_way_at(sweep, 0, (struct vector){0, 0, 0});
	double length = hypot(way.x, way.y), ahead = way.x * form.forward[0] + way.y * form.forward[1];
	form.way[0] = way.x;
	form.way[1] = way.y;
	form.way[2] = way.z;
	if (sweep->shape->kind == SOIL_SPHERE) {
		form.run = length;
		form.forward[0] = length > 0 ? way.x / length : 1;
		form.forward[1] = length > 0 ? way.y / length : 0;
	} else if (sweep->shape->kind == SOIL_BOX) {
		box_form(&sweep->to, &form);
	} else if (sweep->shape->kind == SOIL_WHEEL) {
		put_times(&form, sweep->shape->radius * sweep->turned, length, ahead);
		form.run = fabs(ahead);
		form.half[1] = sweep->shape->width / 2;
		for (int k = 0; k < 2; k++)
			form.forward[k] *= ahead < 0 ? -1 : 1;
	}
	if (sweep->shape->belt) {
		double axes[3][3];
		put_times(&form, sweep->turned, length, ahead);
		soil_axes(sweep->to.yaw, sweep->to.pitch, sweep->to.roll, 0, axes);
		form.level = hypot(axes[1][0], axes[1][1]);
	}
	if (ground->ground_normals)
		form.rim = form.dig = 0;
	return form;
}

/* Forwards, and to the left. */
static void seen(const struct form *form, const double at[2], double out[2])
{
	out[0] = at[0] * form->forward[0] + at[1] * form->forward[1];
	out[1] = at[1] * form->forward[0] - at[0] * form->forward[1];
}

/* The radius of the circle that a round object is cut in, along its motion. */
static double ring_squared(const struct form *form, const double at[2])
{
	double place[2], aside;
	seen(form, at, place);
	aside = form->shape->kind == SOIL_SPHERE ? place[1] : 0;
	return fmax(form->shape->radius * form->shape->radius - aside * aside, 0);
}

/* The underside; `own`: its rise where only the posts tell. */
static struct underside underside_at(const struct form *form, const double at[2], const double own[2])
{
	struct underside below = {own[0] * at[0] + own[1] * at[1], {own[0], own[1]}};
	double place[2];
	seen(form, at, place);
	if (is_round(form)) {
		double up = sqrt(fmax(ring_squared(form, at) - place[0] * place[0], 0)), steep = fmax(up, form->shape->radius / STEEPEST);
		bool ball = form->shape->kind == SOIL_SPHERE;
		below.z = -up;
		for (int k = 0; k < 2; k++)
			below.rise[k] = (ball ? at[k] : place[0] * form->forward[k]) / steep;
	} else if (form->shape->kind == SOIL_BOX) {
		below.z = -INFINITY;
		for (int k = 0; k < 3; k++) {
			double z = form->faces[k][0] + form->faces[k][1] * at[0] + form->faces[k][2] * at[1];
			if (z > below.z)
				below = (struct underside){z, {form->faces[k][1], form->faces[k][2]}};
		}
	}
	return below;
}

/* How much lower a round object was above a place, on its last `back` metres, than it is now. */
static double was_lower(const struct form *form, const double at[2], double back)
{
	if (!is_round(form) || form->run <= 0)
		return 0;
	double place[2], squares = ring_squared(form, at), ring = sqrt(squares), rise = form->way[2] / form->run;
	seen(form, at, place);
	/* The lowest point of a circle that climbs lies before its middle. */
	double x = fmin(fmax(ring * rise / hypot(1, rise), place[0]), place[0] + back);
	x = fmin(fmax(x, -ring), ring);
	return fmax(0, sqrt(fmax(squares - x * x, 0)) + rise * (x - place[0]) - sqrt(fmax(squares - place[0] * place[0], 0)));
}

/* For how much of the contact, back from its end, the object has been deeper than `stays`. Below 0: it is not at the end. Above 1: it was
 * before, too, if it moved as now. */
static double in_contact(const struct form *form, const double at[2], const double own[2], double depth, double stays, bool over)
{
	double place[2], speed[2], share = 1e3, before[2] = {at[0] + form->way[0], at[1] + form->way[1]};
	struct underside now = underside_at(form, at, own);
	double change = form->way[2] - underside_at(form, before, own).z + now.z;
	seen(form, at, place);
	seen(form, form->way, speed);
	if (is_round(form) && form->run > 0) {
		/* Where the circle, as high as now, is `stays` deep; then a step of Newton's for the height that it had. */
		double rise = form->way[2] / form->run, up = fmax(-now.z - depth + stays, form->shape->radius * 0.05);
		double first = sqrt(fmax(ring_squared(form, at) - up * up, 0)) - place[0];
		first -= rise * first / fmin(rise - (place[0] + first) / up, -0.05);
		share = first / form->run;
	} else if (change < 0) {
		share = (depth - stays) / -change;
	}
	for (int k = 0; k < 2; k++)
		if (over && form->half[k] > 0 && fabs(speed[k]) > 1e-9)
			share = fmin(share, fmax(form->half[k] - copysign(1, speed[k]) * place[k], 0) / fabs(speed[k]));
	return fmin(fmax(share, -4), 1e3);
}

struct part {
	double share, middle[2]; /* of a post's area; from the post */
};

/* Adds what of one direction a post bears: half way to the next post that is covered too, or to the side of the object. */
static void bear_side(const struct form *form, int side, const double place[2], double step, double spacing, bool over, struct part *part)
{
	double at = place[side];
	double size = form->half[side], covered = size + 1e-9;
	double low = fabs(at - step) <= covered ? -0.5 : fmax((-size - at) / step, -1), high = fabs(at + step) <= covered ? 0.5 : fmin((size - at) / step, 1);
	const double left[2] = {-form->forward[1], form->forward[0]}, *to = side == 0 ? form->forward : left;
	/* A wheel passes between two posts. Or it has sunk so deep that its rim reaches to a post before it. */
	bool wheel = form->shape->kind == SOIL_WHEEL, narrow = 2 * size < step;
	bool near = wheel && fabs(place[0]) < form->shape->radius + 0.5 * spacing * spacing / step;
	bool between = near && narrow && fabs(at - 1e-4 * step) <= 0.5 * step;
	bool before = near && fabs(place[0]) > form->shape->radius && fabs(at) <= size;
	if (!over && !(before && !narrow)) {
		low = between || before ? (-size - at) / step : 0;
		high = between || before ? (size - at) / step : 0;
	}
	part->share *= fmax(high - low, 0);
	int axis = fabs(to[0]) >= fabs(to[1]) ? 0 : 1;
	part->middle[axis] += (low + high) / 2 * spacing * copysign(1, to[axis]);
}

static struct part part_of(const struct form *form, const double at[2], double spacing, bool over)
{
	struct part part = {over ? 1 : 0, {0, 0}};
	double place[2], step = spacing * fmax(fabs(form->forward[0]), fabs(form->forward[1]));
	seen(form, at, place);
	for (int side = 1; side >= 0; side--)
		if (form->half[side] > 0) {
			part.share = side == 1 ? 1 : part.share;
			bear_side(form, side, place, step, spacing, over, &part);
		}
	return part;
}

/* The mean of two rises, but no more than twice each. */
static double slope_between(double before, double after)
{
	double least = 2 * fmin(fabs(before), fabs(after));
	return before * after > 0 ? fmin(fmax((before + after) / 2, -least), least) : 0;
}

/* What a slope is where only posts tell: between the neighbours that are covered. */
static void own_rise(const struct reference_ground *ground, const double *rests, int at, double own[2])
{
	for (int k = 0; k < 2; k++) {
		int step = k == 0 ? 1 : ground->width, place = k == 0 ? at % ground->width : at / ground->width;
		int low = place > 0 && rests[at - step] < INFINITY ? at - step : at;
		int high = place + 1 < (k == 0 ? ground->width : ground->height) && rests[at + step] < INFINITY ? at + step : at;
		double before = rests[at] - rests[low], after = rests[high] - rests[at];
		own[k] = (low == at ? after : high == at ? before : slope_between(before, after)) / ground->spacing;
	}
}

static struct vector unit_normal(const double rise[2])
{
	double steep = hypot(rise[0], rise[1]), less = steep > STEEPEST ? STEEPEST / steep : 1, length = hypot(1, less * steep);
	return (struct vector){-rise[0] * less / length, -rise[1] * less / length, 1 / length};
}

/* Where on a line the depth of the underside, a parabola through three depths, exceeds what stays at its ends. */
static void deep_between(const double depths[3], const double stays[2], double half, double ends[2])
{
	double a = (depths[0] + depths[2] - 2 * depths[1]) / (2 * half * half), b = (depths[2] - depths[0]) / (2 * half);
	for (int end = 0; end < 2; end++) {
		double sign = end == 0 ? -1 : 1, c = depths[1] - stays[end], inside = b * b - 4 * a * c;
		ends[end] = sign * half;
		if (depths[2 * end] > stays[end])
			continue;
		double by = sqrt(fmax(inside, 0)) - sign * b;
		/* Its top misses by rounding alone. */
		if (a < 0 && inside <= 0 && inside >= 4 * a * LEAST) {
			ends[end] = fmin(fmax(-b / (2 * a), -half), half);
			continue;
		}
		ends[end] = inside < 0 || by <= 0 ? -sign * half : fmin(fmax(sign * 2 * c / by, -half), half);
	}
	ends[1] = fmax(ends[0], ends[1]);
}

struct cell {
	const struct reference_ground *ground;
	const struct soil_numbers *soil;
	const struct deform_contact *sweep;
	const struct form *form;
	double at[2], own[2];    /* the post */
	double stiffness, was;   /* of Bekker's curve; the largest sinkage before */
	struct vector normal;    /* of the ground */
	double share, slides;    /* of the contact; how far the surface slides in all of it */
	double sheared[2], since; /* before; contacts since it was first in contact, if the object always moved as now */
	bool over;               /* the object is above the post */
	double above;            /* how much higher the underside is than the form's */
	double lowered, back;
	double depth, stamped;   /* of the post; how much what it remembers has the shape of the underside */
};

static struct vector normal_here(const struct cell *cell, const struct underside *below)
{
	return cell->ground->ground_normals ? cell->normal : unit_normal(below->rise);
}

/* The surface's way along itself. */
static struct vector sliding(const struct cell *cell, struct vector arm, struct vector normal)
{
	const struct deform_contact *sweep = cell->sweep;
	struct vector way = reference_way_at(sweep, sweep->shape->belt ? 0 : sweep->turned, arm);
	if (sweep->shape->belt)
		way = plus(way, sweep->turned, reference_belt_along(&sweep->to, normal));
	return plus(way, -dot(way, normal), normal);
}

/* How fast the soil is pushed down; of a wheel as if it rolled without slip. */
static double pushed(const struct cell *cell, struct vector arm, struct vector normal)
{
	const struct deform_contact *sweep = cell->sweep;
	if (!(sweep->seconds > 0) || sweep->load > 0) /* what carries a load does not depend on its speed */
		return 0;
	struct vector way = reference_way_at(sweep, 0, (struct vector){0, 0, 0});
	double ahead = way.x * cos(sweep->to.yaw) + way.y * sin(sweep->to.yaw);
	double rolls = sweep->shape->kind == SOIL_WHEEL ? ahead / sweep->shape->radius : 0;
	return fmax(0, -dot(reference_way_at(sweep, rolls, arm), normal)) / sweep->seconds;
}

/* The largest sinkage at a place of the cell, vertically: what the post remembers, and what this contact did. */
static double largest_at(const struct cell *cell, const double at[2], double deep)
{
	double remembered = cell->was / cell->normal.z + cell->stamped * (deep - cell->depth);
	return fmax(remembered, deep + cell->lowered + was_lower(cell->form, at, cell->back));
}

/* Adds one place, `area` m2 of the ground, where the underside is `deep` below it. */
static void add_place(const struct cell *cell, const double at[2], double deep, double area, struct cell_force *out)
{
	const struct soil_numbers *soil = cell->soil;
	struct underside below = underside_at(cell->form, at, cell->own);
	struct vector normal = normal_here(cell, &below), arm = {at[0], at[1], below.z + cell->above};
	double ca = cell->normal.z, most = ca * largest_at(cell, at, deep), sunk = ca * deep;
	if (sunk <= 0)
		return;
	double yields = fmin(cell->stiffness * pow(most, soil->bekker_n), soil->elastic_stiffness * most);
	double plastic = reference_stays(soil, cell->stiffness, most);
	double share = sunk >= most - LEAST ? 1 : fmin(fmax((sunk - plastic) / fmax(most - plastic, 1e-9), 0), 1);
	if (share <= 0)
		return;
	double stress = yields * share;
	double damped = stress + soil->damping * pushed(cell, arm, normal) * fmin(4 * share, 1) * fmin(4 * most / soil->janosi_shear, 1);
	const double *way = cell->form->way;
	double squares = way[0] * way[0] + way[1] * way[1];
	double later = squares > 0 ? ((at[0] - cell->at[0]) * way[0] + (at[1] - cell->at[1]) * way[1]) / squares : 0;
	/* Places ahead came into contact later. A post that has slid less than since then was below the object when it began to move. */
	double mobilised = hypot(cell->sheared[0], cell->sheared[1]);
	double before = mobilised > 0.9999 ? 1e3 : -log(1 - mobilised); /* in units of the shear modulus */
	if (cell->over && cell->since > 1)
		later *= fmin(1, before * soil->janosi_shear / fmax(cell->slides * (cell->since - 1), 1e-9));
	struct vector along = sliding(cell, arm, normal);
	double moved = sqrt(dot(along, along)), slid = cell->slides * fmax(cell->share - later, 0) / fmax(moved, 1e-9), after[2];
	struct vector sheared = reference_shear(cell->sheared, normal, plus((struct vector){0, 0, 0}, slid, along), soil->janosi_shear, after);
	double on = cell->ground->ground_normals ? area : area / normal.z; /* of the surface that the stresses act on */
	struct vector force = plus((struct vector){0, 0, 0}, damped * on, normal);
	force = plus(force, -reference_strength(soil, &cell->sweep->interface, damped) * on, sheared);
	out->force = plus(out->force, 1, force);
	out->moment = plus(out->moment, 1, cross(arm, force));
	out->normal += stress * normal.z * on;
	out->area += area;
}

/* Returns whether a post that the object is not above may bear it: only a wheel, and only near it. */
static bool may_bear_beside(const struct reference_ground *ground, const struct deform_contact *sweep, int at)
{
	const double far = sweep->shape->radius + sweep->shape->width + 2 * ground->spacing;
	double east = (double)(ground->left + at % ground->width) * ground->spacing - lattice_offset_metres(sweep->to.x);
	double north = (double)(ground->bottom + at / ground->width) * ground->spacing - lattice_offset_metres(sweep->to.y);
	return sweep->shape->kind == SOIL_WHEEL && fabs(east) < far && fabs(north) < far;
}

struct cell_force reference_cell(const struct reference_ground *ground, const struct soil_numbers *soil, double stiffness,
				 const struct deform_contact *sweep, int at, const double *under, const double *rests, double lower, double since)
{
	struct cell_force out = {.normal = 0};
	bool over = rests[at] < INFINITY;
	if (!over && !may_bear_beside(ground, sweep, at))
		return out;
	struct form form = form_of(ground, sweep);
	double rest = rests[at], spacing = ground->spacing, centre = lattice_offset_metres(sweep->to.z) - lower;
	struct cell cell = {
		.ground = ground, .soil = soil, .sweep = sweep, .form = &form, .stiffness = stiffness, .was = ground->pressed[at], .sheared = {ground->shear[0][at], ground->shear[1][at]}, .over = over,
		.at = {(double)(ground->left + at % ground->width) * spacing - lattice_offset_metres(sweep->to.x),
		       (double)(ground->bottom + at / ground->width) * spacing - lattice_offset_metres(sweep->to.y)},
		.normal = reference_normal_at(ground, at),
	};
	struct part part = part_of(&form, cell.at, spacing, over);
	if (part.share <= 0)
		return out;
	if (sweep->shape->kind == SOIL_MESH)
		own_rise(ground, rests, at, cell.own);
	struct underside post = underside_at(&form, cell.at, cell.own);
	double depth = ground->base[at] + ground->heaped[at] - (over ? rest - lower : centre + post.z);
	double ca = cell.normal.z, hill[2] = {-cell.normal.x / ca, -cell.normal.y / ca};
	double seen_at[2];
	seen(&form, cell.at, seen_at);
	if (!over && fabs(seen_at[0]) > sweep->shape->radius && depth > 0)
		return out; /* before the rim of a wheel that has sunk to its axle */
	cell.above = over ? rest - lower - centre - post.z : 0;
	cell.lowered = over && !is_round(&form) ? rest - fmin(under[at], rest) : 0;
	cell.since = !isnan(since) ? since : in_contact(&form, cell.at, cell.own, depth, reference_stays(soil, stiffness, cell.was) / ca, over);
	cell.share = over ? fmin(cell.since, 1) : cell.since;
	out.since = cell.since;

	/* Half way of what it slid. */
	double halfway[2] = {cell.at[0] + fmax(cell.share, 0) / 2 * form.way[0], cell.at[1] + fmax(cell.share, 0) / 2 * form.way[1]};
	struct underside then = underside_at(&form, halfway, cell.own);
	struct vector normal = normal_here(&cell, &then), along = sliding(&cell, (struct vector){halfway[0], halfway[1], then.z + cell.above}, normal);
	double rim = form.rim > 0 ? form.rim * (sweep->shape->belt ? form.level : 1) / normal.z : 1;
	out.rim = form.dig > 0 ? form.dig : 1;
	cell.slides = sqrt(dot(along, along)) * rim;
	out.slid = plus((struct vector){0, 0, 0}, rim * fmax(cell.share, 0), along);
	out.normal_then = normal;

	/* The line across the cell. */
	bool wheel = sweep->shape->kind == SOIL_WHEEL;
	double grows[2] = {hill[0] - post.rise[0], hill[1] - post.rise[1]}, size = hypot(grows[0], grows[1]);
	double line[2] = {form.forward[0], form.forward[1]}, half = spacing / 2, depths[3], largest = 0, middle[2];
	if (wheel)
		half /= fmax(fabs(form.forward[0]), fabs(form.forward[1]));
	else if (size > 1e-4)
		for (int k = 0; k < 2; k++)
			line[k] = grows[k] / size;
	/* A body that hardly moved did not move before. */
	cell.back = over ? form.run + fmin(hypot(form.way[0], form.way[1]) / half, 1) * half : 1e3;
	cell.depth = depth;
	/* Below an object that hardly moves: an impression of it. Where it has passed: a rut. */
	cell.stamped = cell.was > 0 ? fmax(0, 1 - hypot(form.way[0], form.way[1]) / half) : 0;
	double deep = depth + post.z;
	for (int k = 0; k < 2; k++) {
		middle[k] = cell.at[k] + part.middle[k];
		deep += hill[k] * part.middle[k];
	}
	double mosts[3], stays[2], ends[2];
	for (int k = 0; k < 3; k++) {
		double t = (k - 1) * half, there[2] = {middle[0] + t * line[0], middle[1] + t * line[1]};
		depths[k] = deep + t * (hill[0] * line[0] + hill[1] * line[1]) - underside_at(&form, there, cell.own).z;
		mosts[k] = largest_at(&cell, there, depths[k]);
		largest = fmax(largest, mosts[k]);
	}
	for (int end = 0; end < 2; end++)
		stays[end] = mosts[2 * end] > fmax(depths[2 * end], 0) + LEAST ? reference_stays(soil, stiffness, ca * largest) / ca : 0;
	deep_between(depths, stays, half, ends);
	for (int k = 0; k < 2 && ends[1] > ends[0]; k++) {
		double t = (ends[0] + ends[1]) / 2 + (k - 0.5) * (ends[1] - ends[0]) / sqrt(3);
		double there[2] = {middle[0] + t * line[0], middle[1] + t * line[1]};
		double below = deep + t * (hill[0] * line[0] + hill[1] * line[1]) - underside_at(&form, there, cell.own).z;
		add_place(&cell, there, below, part.share * (ends[1] - ends[0]) / (4 * half) * spacing * spacing, &out);
	}
	return out;
}
