/*
 * The law of the soil model scm at one post, in doubles: the same as shaders/lib/scm_post.glsl, which says what each part is for. Here it also
 * gives how the force changes with the body's place and with its velocity.
 */
#ifndef FURROW_DEFORM_PROBE_LAW_H
#define FURROW_DEFORM_PROBE_LAW_H

#include "deform/probe/form.h"
#include "deform/probe/patch.h"

/* What does not change from post to post. */
struct probe_law {
	const struct probe_form *form;
	const struct deform_patch *patch;
	double above_zero;  /* m: height of the body's centre above the patch's zero */
	double by_width;    /* 1 / b */
	double lowest;      /* m: the body is nowhere lower, from its centre */
	double surface[2];  /* of the body: adhesion, Pa, and tangent of its friction angle */
	bool own[2];        /* the soil's own cohesion, friction counts in their place */
};

/* The soil at one place, in the body's frame. Amounts are those of the place's share of a post's area. */
struct probe_place {
	double arm[3], normal[3]; /* m from the body's centre; unit, of the stresses */
	double across[2][3];      /* two unit vectors along the surface: forwards, and to the left */
	double area;              /* of the surface, posts */
	double ground;            /* area of the ground that bears, in posts */
	double stress, strength;  /* Pa: normal, with damping; the most that shear can be */
	double mobilised[2];      /* shear along `across`, as a share of the strength */
	double holds;             /* growth of the strength with the normal stress */
	double sinks;             /* Pa/m: growth of the normal stress as the body's surface goes down by a metre */
	double damps;             /* Pa s/m: growth of the normal stress with the speed along the normal */
	double shears[2][2];      /* 1/m: how `mobilised` grows with a way along `across` */
	double dragged[2];        /* Pa: shear stress of damping along `across` */
	double drags[2][2];       /* Pa s/m: growth of that with the speed along `across` */
	double bends[3];          /* 1/m: second derivatives of the surface's height: xx, xy, yy */
};

struct probe_bearing {
	int count;                /* places that bear: 0 .. 2 */
	struct probe_place places[2];
	bool has_brim;            /* a cylinder that leans: its lower end bears beside the cell */
	struct probe_place brim;
	bool sides[4];            /* sides of the body that end the cell's part: behind, ahead, right, left */
	double share;             /* of a post's area that the body covers */
	double sinkage;           /* m below the base, of the post */
};

/* Tells whether a post may bear: of a wheel or a cylinder whose sides are known. height: of the ground, with all that a cell adds. */
static inline bool deform_law_in_strip(const struct probe_form *form, const double at[2], double height, double reach)
{
	const double leans = fabs(form->lean), away = probe_most(fabs(at[0]) - reach, 0);
	if (fabs(at[1]) > probe_most(form->half[1], 0.5 * form->step_aside) + leans * form->radius + 1e-3 * form->spacing)
		return false;
	if (form->kind == DEFORM_WHEEL)
		return height >= 0 || away * away + height * height <= form->outer * form->outer;
	const double side = height * form->level - form->lean * at[1] + leans * (reach + form->step_aside);
	return away <= form->outer && (side >= 0 || away * away + side * side <= form->outer * form->outer);
}

/* Returns false for a post that surely bears nothing. It says yes for some others, too. */
static inline bool deform_law_may_bear(const struct probe_law *law, size_t number, const double at[2])
{
	const struct probe_form *form = law->form;
	const struct probe_post *ground = &law->patch->posts[number];
	const double reach = form->half_across + 0.5 * form->spacing, slack = (fabs(ground->rise[0]) + fabs(ground->rise[1])) * (reach + form->step_aside);
	const double height = ground->height - law->above_zero + slack + 1e-3 * form->spacing;
	if (ground->hole)
		return false;
	if (form->kind == DEFORM_WHEEL || probe_strips(form))
		return deform_law_in_strip(form, at, height, reach);
	if (form->kind != DEFORM_SPHERE)
		return height > law->lowest;
	const double away = probe_most(sqrt(at[0] * at[0] + at[1] * at[1]) - 1.5 * reach, 0);
	return height >= 0 || away * away + height * height <= form->radius * form->radius;
}

/* `number`: of the post in the patch. `at`: its place in the body's frame. */
void deform_law_bearing(const struct probe_law *law, size_t number, const double at[2], struct probe_bearing *bearing);
/* Returns true if the body is below the ground at a post. *height: of its lower envelope there, above the patch's zero. */
bool deform_law_touches(const struct probe_law *law, size_t number, const double at[2], double *height);

#endif
