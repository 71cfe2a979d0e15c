/* The lower envelope of a probed body over a batch of posts. */
#include "deform/probe/over.h"

#include "deform/probe/face.h"

/* Returns true for a wheel, and for a cylinder whose side alone bears: a rim, which may lean. */
static bool is_rim(const struct probe_form *form)
{
	return form->kind == SOIL_WHEEL || probe_strips(form);
}

static void put_face(struct lane_faces *faces, int i, const struct probe_face *face)
{
	faces->height[i] = face->height;
	for (int k = 0; k < 2; k++)
		faces->slope[k][i] = face->slope[k];
	for (int k = 0; k < 3; k++)
		faces->normal[k][i] = face->normal[k];
}

/* --- at the posts --- */

LANES_CLONED static void wheel_parts(const struct probe_form *restrict form, struct lanes *restrict l)
{
	const double size = form->half[1], step = form->step_aside, by_step = form->by_step, r = form->radius, reach = r + form->half_across;
	const bool narrow = 2 * size < step;
	for (int i = 0; i < LANES; i++) {
		const double x = fabs(l->at[0][i]), y = l->at[1][i], low = (-size - y) * by_step, high = (size - y) * by_step;
		const bool begins = !(fabs(y - step) <= size + PROBE_BESIDE), ends = !(fabs(y + step) <= size + PROBE_BESIDE), over = l->over[i] > 0;
		const bool near = narrow & (fabs(y - 1e-4 * step) <= 0.5 * step), beside = (x < reach) & (near | ((x > r) & (fabs(y) <= size)));
		const bool alone = narrow & !over;
		const double first = alone ? low : begins ? probe_most(low, -1) : -0.5, last = alone ? high : ends ? probe_least(high, 1) : 0.5;
		l->share[i] = (over | beside) ? probe_most(last - first, 0) : 0;
		l->middle[0][i] = 0.5 * (first + last) * form->cut[1][0];
		l->middle[1][i] = 0.5 * (first + last) * form->cut[1][1];
		l->sides[0][i] = l->sides[1][i] = 0;
		l->sides[2][i] = begins ? 1 : 0;
		l->sides[3][i] = ends ? 1 : 0;
	}
}

LANES_CLONED static void wheel_posts(const struct probe_form *restrict form, struct lanes *restrict l)
{
	const double r = form->radius, squares = r * r * (1 + 1e-12), size = form->half[1] + PROBE_BESIDE;
	const double sinks = form->run > 0 ? 0 : probe_most(form->way[2], 0); /* a wheel that goes straight down was higher, or lower, above all posts */
	deform_over_faces(form, l, l->at[0], l->at[1], &l->face);
	for (int i = 0; i < LANES; i++) {
		l->own[0][i] = l->own[1][i] = 0;
		l->rests[i] = l->face.height[i];
		l->lowest[i] = l->face.height[i] - sinks;
	}
	for (int i = 0; i < LANES && form->run > 0; i++) {
		double since;
		l->lowest[i] -= probe_lowered_on(form, r * r, r, l->at[0][i], form->run, 0, &since);
	}
	for (int i = 0; i < LANES; i++) {
		const double x = l->at[0][i];
		const double ahead = x * x <= squares ? 1 : 0, aside = fabs(l->at[1][i]) <= size ? 1 : 0;
		l->over[i] = ahead * aside;
	}
	for (int i = 0; i < LANES && form->low.rests != NULL; i++) {
		const double rests = form->low.rests[l->number[i]], lowest = form->low.lowest[l->number[i]];
		const bool over = l->over[i] > 0;
		l->lowest[i] = over ? probe_least(l->lowest[i], lowest) : lowest;
		l->rests[i] = over ? probe_least(l->rests[i], rests) : rests;
		l->over[i] = over || rests < INFINITY ? 1 : 0;
	}
}

/* Sets share to 0 for a post whose part of the cell is surely above the ground. */
LANES_CLONED static void drop_wheel(const struct probe_form *restrict form, struct lanes *restrict l)
{
	const double reach = form->half_across, r = form->radius;
	for (int i = 0; i < LANES; i++) {
		const double x = l->rise[0][i], near = probe_most(fabs(l->at[0][i] + l->middle[0][i]) - reach, 0);
		const double above = x * l->middle[0][i] + l->rise[1][i] * l->middle[1][i] + fabs(x) * reach + probe_root(r * r - near * near);
		l->share[i] = probe_either(l->depth[i] + probe_most(above + l->face.height[i], 0) > 0, l->share[i], 0);
	}
}

LANES_CLONED void deform_over_wheel(const struct probe_form *restrict form, struct lanes *restrict l)
{
	wheel_posts(form, l);
	wheel_parts(form, l);
	for (int i = 0; i < LANES; i++)
		l->depth[i] = l->height[i] - probe_either(l->over[i] > 0, l->rests[i], l->face.height[i]);
	drop_wheel(form, l);
}

bool deform_over_post(const struct probe_form *form, struct lanes *l, int i)
{
	/* The lower edge of a cylinder that leans lies up to a post beside the line. */
	const double reach = form->half_across + (form->kind == SOIL_CYLINDER ? form->step_aside : 0);
	const double at[2] = {l->at[0][i], l->at[1][i]}, x = l->rise[0][i], y = l->rise[1][i];
	struct probe_face face;
	double own[2], middle[2], rests = 0, lowest = 0;
	bool sides[4];
	const bool over = deform_form_over(form, l->number[i], at, &rests, &lowest);
	const double share = deform_form_part(form, at, over, middle, sides);
	if (!(share > 0))
		return false;
	deform_form_own(form, l->number[i], own);
	probe_face_at(form, own, at, &face);
	const double there[2] = {at[0] + middle[0], at[1] + middle[1]}, depth = l->height[i] - (over ? rests : face.height);
	const double above = x * middle[0] + y * middle[1] + sqrt(x * x + y * y) * reach - probe_lowest_near(form, own, there, reach);
	if (!(depth + probe_most(above + face.height, 0) > 0))
		return false;
	put_face(&l->face, i, &face);
	l->over[i] = over ? 1 : 0;
	l->rests[i] = over ? rests : 0;
	l->lowest[i] = over ? lowest : 0;
	l->share[i] = share;
	l->depth[i] = depth;
	for (int k = 0; k < 2; k++) {
		l->own[k][i] = own[k];
		l->middle[k][i] = middle[k];
	}
	for (int k = 0; k < 4; k++)
		l->sides[k][i] = sides[k] ? 1 : 0;
	return true;
}

/* When the circle of a rim, and then its side, leaves a post. */
LANES_CLONED static void rim_passed(const struct probe_form *restrict form, struct lanes *restrict l)
{
	const double moves = form->run * form->run + form->plunge * form->plunge, squares = form->radius * form->radius, speed = fabs(form->way[1]);
	const double to = copysign(1, form->way[1]), by_speed = speed > 1e-9 ? 1 / speed : 0, never = speed > 1e-9 ? 0 : 1e3;
	for (int i = 0; i < LANES; i++) {
		const double ahead = l->at[0][i], level = (l->depth[i] - l->plastic[i] * l->by_up[i]) / form->lift - probe_root(squares - ahead * ahead);
		const double nears = ahead * form->run + level * form->plunge, beyond = ahead * ahead + level * level - squares;
		const double root = nears * nears - moves * beyond, leaves = -beyond / probe_most(nears + probe_root(root), 1e-18);
		l->passed[i] = probe_either(root >= 0, leaves, -4);
	}
	for (int i = 0; i < LANES && !(moves > 0); i++)
		l->passed[i] = 1e3;
	for (int i = 0; i < LANES; i++) {
		const double y = l->at[1][i] - form->lean * probe_half_strip(form, l->at[0][i]);
		const double aside = probe_most(form->half[1] - y * to, 0) * by_speed + never;
		l->passed[i] = probe_clamp(probe_least(l->passed[i], probe_either(l->over[i] > 0, aside, 1e3)), -4, 1e3);
	}
}

LANES_CLONED void deform_over_passed(const struct probe_form *form, struct lanes *l)
{
	if (is_rim(form)) {
		rim_passed(form, l);
		return;
	}
	for (int i = 0; i < LANES; i++) {
		const double own[2] = {l->own[0][i], l->own[1][i]}, at[2] = {l->at[0][i], l->at[1][i]};
		const struct probe_face face = {.height = l->face.height[i]};
		l->passed[i] = deform_form_share(form, own, at, l->depth[i], l->plastic[i] * l->by_up[i], &face, l->over[i] > 0);
	}
}

/* --- places of a cell that are not its post --- */

LANES_CLONED void deform_over_faces(const struct probe_form *restrict form, const struct lanes *restrict l, const double x[restrict LANES],
		       const double y[restrict LANES], struct lane_faces *restrict faces)
{
	struct probe_face face;
	if (form->kind == SOIL_WHEEL) {
		for (int i = 0; i < LANES; i++) {
			const double at[2] = {x[i], y[i]};
			probe_wheel_face(form, at, &face);
			put_face(faces, i, &face);
		}
		return;
	}
	if (probe_strips(form)) {
		for (int i = 0; i < LANES; i++) {
			const double at[2] = {x[i], y[i]};
			probe_side_face(form, at, &face);
			put_face(faces, i, &face);
		}
		return;
	}
	for (int i = 0; i < LANES; i++) {
		const double own[2] = {l->own[0][i], l->own[1][i]}, at[2] = {x[i], y[i]};
		probe_face_at(form, own, at, &face);
		put_face(faces, i, &face);
	}
}

LANES_CLONED void deform_over_heights(const struct probe_form *restrict form, const struct lanes *restrict l, const double x[restrict LANES],
			 const double y[restrict LANES], double height[restrict LANES])
{
	if (is_rim(form)) {
		for (int i = 0; i < LANES; i++)
			height[i] = (form->lean * y[i] - probe_half_strip(form, x[i])) * form->lift;
		return;
	}
	for (int i = 0; i < LANES; i++) {
		const double own[2] = {l->own[0][i], l->own[1][i]}, at[2] = {x[i], y[i]};
		height[i] = probe_height_at(form, own, at);
	}
}

LANES_CLONED void deform_over_bends(const struct probe_form *restrict form, const struct lanes *restrict l, const double x[restrict LANES],
		       const double y[restrict LANES], const struct lane_faces *restrict faces, double bends[restrict 3][LANES],
		       double ends[restrict LANES])
{
	if (is_rim(form)) {
		for (int i = 0; i < LANES; i++) {
			const double up = faces->normal[2][i] / form->level;
			bends[0][i] = form->lift * form->by_radius / (up * up * up);
			bends[1][i] = bends[2][i] = ends[i] = 0;
		}
		return;
	}
	for (int i = 0; i < LANES; i++) {
		const double own[2] = {l->own[0][i], l->own[1][i]}, at[2] = {x[i], y[i]};
		const struct probe_face face = {.normal = {faces->normal[0][i], faces->normal[1][i], faces->normal[2][i]}};
		double b[3];
		probe_bends_at(form, own, at, &face, b);
		ends[i] = probe_bears_by_end(form, own, at) ? 1 : 0;
		for (int k = 0; k < 3; k++)
			bends[k][i] = b[k];
	}
}

LANES_CLONED void deform_over_lowered(const struct probe_form *restrict form, const struct lanes *restrict l, const double x[restrict LANES],
			 const double y[restrict LANES], double lowered[restrict LANES], double since[restrict LANES])
{
	const double by_run = form->run > 0 ? 1 / form->run : 0;
	if (!probe_is_round(form)) {
		for (int i = 0; i < LANES; i++) {
			lowered[i] = l->lowered[i];
			since[i] = l->lowered[i] > 0 ? 1 : 0;
		}
	} else if (!(form->run > 0)) {
		for (int i = 0; i < LANES; i++)
			lowered[i] = since[i] = 0;
	} else if (is_rim(form)) {
		for (int i = 0; i < LANES; i++) {
			double way;
			lowered[i] = probe_lowered_on(form, form->radius * form->radius, form->radius, x[i], l->back[i], l->rise[0][i], &way);
			since[i] = probe_least(way * by_run, 1);
		}
	} else {
		for (int i = 0; i < LANES; i++) {
			const double at[2] = {x[i], y[i]};
			double way;
			lowered[i] = probe_lowered(form, at, l->back[i], l->rise[0][i], &way);
			since[i] = probe_least(way * by_run, 1);
		}
	}
}
