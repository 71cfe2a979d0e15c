/*
 * The law of the soil model scm at posts, in doubles: the same as shaders/lib/scm_post.glsl, which says what each part is for. A post is taken
 * into a lane of a batch, and a batch is computed at once (lanes.h).
 */
#ifndef FURROW_DEFORM_PROBE_LAW_H
#define FURROW_DEFORM_PROBE_LAW_H

#include "deform/probe/form.h"
#include "deform/probe/lanes.h"
#include "deform/probe/patch.h"

/* What does not change from post to post. */
struct probe_law {
	struct probe_form form;
	const struct deform_patch *patch;
	double above_zero;  /* m: height of the body's centre above the patch's zero */
	double by_width;    /* 1 / b */
	double lowest;      /* m: the body is nowhere lower, from its centre */
	double surface[2];  /* of the body: adhesion, Pa, and tangent of its friction angle */
	double own[2];      /* 1: the soil's own cohesion, friction counts in their place */
};

/* Tells whether a post may bear: of a wheel or a cylinder whose sides are known. height: of the ground, with all that a cell adds. */
static inline bool deform_law_in_strip(const struct probe_form *form, const double at[2], double height, double reach)
{
	const double leans = fabs(form->lean), away = probe_most(fabs(at[0]) - reach, 0);
	if (fabs(at[1]) > probe_most(form->half[1], 0.5 * form->step_aside) + leans * form->radius + 1e-3 * form->spacing)
		return false;
	if (form->kind == SOIL_WHEEL)
		return height >= 0 || away * away + height * height <= form->outer * form->outer;
	const double side = height * form->level - form->lean * at[1] + leans * (reach + form->step_aside);
	return away <= form->outer && (side >= 0 || away * away + side * side <= form->outer * form->outer);
}

/* Returns false for a post that surely bears nothing. It says yes for some others, too. */
static inline bool deform_law_may_bear(const struct probe_law *law, size_t number, const double at[2])
{
	const struct probe_form *form = &law->form;
	const struct probe_post *ground = &law->patch->posts[number];
	const double reach = form->half_across + 0.5 * form->spacing, slack = (fabs(ground->rise[0]) + fabs(ground->rise[1])) * (reach + form->step_aside);
	const double height = ground->height - law->above_zero + slack + 1e-3 * form->spacing;
	if (ground->hole)
		return false;
	if (form->kind == SOIL_WHEEL || probe_strips(form))
		return deform_law_in_strip(form, at, height, reach);
	if (form->kind != SOIL_SPHERE)
		return height > law->lowest;
	const double away = probe_most(sqrt(at[0] * at[0] + at[1] * at[1]) - 1.5 * reach, 0);
	return height >= 0 || away * away + height * height <= form->radius * form->radius;
}

/* Puts a post into the next lane, unless it surely bears nothing. number: of the post in the patch; at: its place in the body's frame. */
void deform_law_take(const struct probe_law *law, size_t number, const double at[2], struct lanes *lanes);
/* Computes what the posts of a batch remember, and which part of their cells bears. That is `share`, and `first` to `last` of the line across the
 * cell. A post with share 0 bears nothing. Returns false if none of them bears. */
bool deform_law_bear(const struct probe_law *law, struct lanes *lanes);
/* Gives the largest sinkage that a place of each cell remembers, m, vertically. x, y: the places; depth: of the body there; rise: of the ground
 * there from the post. */
void deform_law_remembered(const struct probe_form *form, const struct lanes *lanes, const double x[LANES], const double y[LANES],
			   const double depth[LANES], const double rise[LANES], double remembered[LANES]);
/* Returns true if the body is below the ground at a post. *height: of its lower envelope there, above the patch's zero. */
bool deform_law_touches(const struct probe_law *law, size_t number, const double at[2], double *height);

#endif
