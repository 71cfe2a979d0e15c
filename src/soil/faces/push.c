/* Finds which facets of a body push on the soil as it slides, and the force of each for a unit of strength and depth. */
#include "soil/faces/push.h"

#include "soil/faces/footing.h"
#include "soil/faces/resist.h"
#include "soil/faces/slid.h"
#include "soil/faces/trend.h"

#define LANES POSTS_LANES
#define EACH_LANE for (int i = 0; i < LANES; i++)
#define TRAILS 0.1f   /* n . v: a facet of the lower envelope that trails by more does not push */
#define SIDE_FULL 0.1f /* n . v: a side that moves into the soil by more pushes whole */
#define STEEP 0.3f     /* level part of v: a side that goes up or down more steeply pushes less. A body that sinks is borne from below */
#define FACES_WAY 0.3f /* n . way: a facet that faces the way by more counts its depth from the ground ahead */
#define FOLLOWS 2.0f   /* soil follows a rim that spins at most so many times as fast as the body goes */

#define SOLE_FROM 0.5f /* -n_z: a flat side of a body that looks down more than that bears it, as a standing cylinder's end does, */
#define SOLE_WHOLE 0.8f /* and wholly from here on */

/* A block of facets in the frame. */
struct facet_lanes {
	float at[3][LANES], normal[3][LANES], area[LANES], under[LANES]; /* under: 1: it bears the body, 0: it is a side */
	float pushes[LANES]; /* area that pushes */
};

/* Gives the recent motion of a place of the body, m for each m of its way. normal: a belt runs along it. A belt grips: soil follows it whole. */
SOIL_INLINED void motion_at(const struct soil_form *f, const struct soil_recent *m, const float at[3], const float normal[3], float moves[3])
{
	float rolled[3], turned[3], belt[3];
	cross3(m->rolling, at, rolled);
	cross3(m->turning, at, turned);
	cross3(f->belt, normal, belt);
	const float went = sqrtf(dot3(m->way, m->way)), ran = sqrtf(dot3(m->rolling, m->rolling)) * f->rim_reach;
	const float rolls = either(FOLLOWS * went < ran, FOLLOWS * went / most(ran, 1e-12f), 1);
	for (int k = 0; k < 3; k++)
		moves[k] = m->way[k] + rolls * rolled[k] + m->ran * belt[k] + turned[k];
}

/* Gives the area of a facet that pushes, m2, and its direction of motion. moves: of its place, for each metre of the body's way; lately: the same of the last bit
 * of it. A facet that backs off does not push: it loses its force within a bit of the way. */
SOIL_INLINED float share_of(const struct soil_form *f, const float at[3], const float normal[3], float area, float under, const float moves[3], const float lately[3], float v[3])
{
	const float size = sqrtf(dot3(moves, moves)), by = 1 / most(size, 1e-9f);
	for (int k = 0; k < 3; k++)
		v[k] = moves[k] * by;
	const float into = least(dot3(normal, v), dot3(normal, lately)), level = sqrtf(v[0] * v[0] + v[1] * v[1]);
	const float slid = slid_at(f, at[0], at[1]), below = faces_share(slid) * clamped(1 + into * (1 / TRAILS), 0, 1);
	const float beside = clamped(into * (1 / SIDE_FULL), 0, 1) * least(level * (1 / STEEP), 1) * clamped((slid - SLID_LEAST) * (1 / SLID_SIDES), 0, 1);
	return either(size > 1e-6f, under * below + (1 - under) * beside, 0) * area;
}

/* Gives the force of a facet for each pascal, m2. */
SOIL_INLINED void force_of(const struct soil_form *f, const float at[3], const float normal[3], float area, float under, const float moves[3], const float lately[3],
			   float tangent, float force[3])
{
	float v[3], alpha[3];
	const float share = share_of(f, at, normal, area, under, moves, lately, v);
	resist_alpha(normal, v, tangent, alpha);
	for (int k = 0; k < 3; k++)
		force[k] = share * alpha[k];
}

SOIL_INLINED void place_block(const struct soil_facets *facets, size_t b, const float axes[3][3], struct facet_lanes *l)
{
	EACH_LANE {
		const float own[3] = {facets->x[b + (size_t)i], facets->y[b + (size_t)i], facets->z[b + (size_t)i]};
		const float out[3] = {facets->nx[b + (size_t)i], facets->ny[b + (size_t)i], facets->nz[b + (size_t)i]};
		for (int k = 0; k < 3; k++) {
			l->at[k][i] = own[0] * axes[0][k] + own[1] * axes[1][k] + own[2] * axes[2][k];
			l->normal[k][i] = out[0] * axes[0][k] + out[1] * axes[1][k] + out[2] * axes[2][k];
		}
		l->area[i] = facets->area[b + (size_t)i];
		const float looks = clamped((-l->normal[2][i] - SOLE_FROM) * (1 / (SOLE_WHOLE - SOLE_FROM)), 0, 1);
		l->under[i] = facets->kind[b + (size_t)i] == FACET_UNDER ? 1.0f : looks;
	}
}

SOIL_CLONED static void push_block(const struct soil_form *restrict f, const struct soil_facets *restrict facets, size_t b, const float axes[restrict 3][3],
				    struct facet_lanes *restrict l)
{
	place_block(facets, b, axes, l);
	EACH_LANE {
		const float at[3] = {l->at[0][i], l->at[1][i], l->at[2][i]}, normal[3] = {l->normal[0][i], l->normal[1][i], l->normal[2][i]};
		float moves[3], lately[3], v[3];
		motion_at(f, &f->recent, at, normal, moves);
		motion_at(f, &f->last, at, normal, lately);
		l->pushes[i] = share_of(f, at, normal, l->area[i], l->under[i], moves, lately, v);
	}
}

/* Sets force, and how fast a facet moves into the soil, and the force by which the inertia of that soil acts on it. */
SOIL_CLONED static void put_forces(const struct soil_form *restrict f, struct soil_faces *restrict faces, size_t b)
{
	float *const px = faces->px + b, *const py = faces->py + b, *const pz = faces->pz + b, *const pushes_into = faces->into + b, *const thrown = faces->thrown + b;
	SOIL_APART
	EACH_LANE {
		const size_t n = b + (size_t)i;
		const float at[3] = {faces->x[n], faces->y[n], faces->z[n]}, normal[3] = {faces->nx[n], faces->ny[n], faces->nz[n]};
		float moves[3], v[3], alpha[3], turned[3];
		motion_at(f, &f->recent, at, normal, moves);
		const float by = 1 / most(sqrtf(dot3(moves, moves)), 1e-9f), share = faces->share[n];
		for (int k = 0; k < 3; k++)
			v[k] = moves[k] * by;
		resist_alpha(normal, v, faces->tangent, alpha);
		px[i] = share * alpha[0];
		py[i] = share * alpha[1];
		pz[i] = share * alpha[2];
		cross3(f->turns, at, turned);
		const float into = most(dot3(f->goes, normal) + dot3(turned, normal), 0);
		pushes_into[i] = into;
		thrown[i] = faces->inertia * into * into * share;
	}
}

void soil_push_forces(const struct soil_form *form, struct soil_faces *faces, size_t first)
{
	if (faces->known[first] > 0)
		return;
	put_forces(form, faces, first);
	for (size_t n = first; n < first + LANES; n++)
		soil_wedge_at(&faces->wedge, faces->nz[n], &faces->weight[n], &faces->cohesive[n]);
	faces->known[first] = 1;
}

/* way: in which the body slides, plan, in the frame. */
static void keep(const struct facet_lanes *l, int i, const float way[2], struct soil_faces *faces)
{
	const size_t n = faces->count++;
	float *const to[2][3] = {{faces->x, faces->y, faces->z}, {faces->nx, faces->ny, faces->nz}};
	for (int k = 0; k < 3; k++) {
		to[0][k][n] = l->at[k][i];
		to[1][k][n] = l->normal[k][i];
	}
	faces->share[n] = l->pushes[i];
	faces->known[n] = faces->px[n] = faces->py[n] = faces->pz[n] = faces->weight[n] = faces->cohesive[n] = faces->into[n] = faces->thrown[n] = 0;
	faces->whole[n] = l->area[i];
	faces->under[n] = l->under[i];
	faces->tall[n] = 0.5f * sqrtf(l->area[i] * most(1 - l->normal[2][i] * l->normal[2][i], 0));
	faces->sole[n] = clamped(-l->normal[2][i], 0, 1);
	faces->faces_way[n] = clamped((l->normal[0][i] * way[0] + l->normal[1][i] * way[1]) * (1 / FACES_WAY), 0, 1);
}

void soil_push(const struct soil_body *body, const struct soil_form *form, const struct soil_facets *facets, const float axes[3][3], float tangent, struct soil_faces *faces)
{
	struct facet_lanes lanes;
	float way[2];
	soil_faces_way(body, faces, way);
	const bool flat = soil_footing_is(form);
	faces->count = 0;
	faces->tangent = tangent;
	for (size_t b = 0; b < facets->count; b += LANES) {
		push_block(form, facets, b, axes, &lanes);
		for (int i = 0; i < LANES; i++)
			if (lanes.pushes[i] > 0 || (flat && lanes.under[i] * lanes.area[i] * -lanes.normal[2][i] > 0))
				keep(&lanes, i, way, faces);
	}
	/* The last block is filled with facets that push nothing. */
	memset(&lanes, 0, sizeof lanes);
	for (int i = 0; i < LANES; i++)
		lanes.normal[2][i] = 1;
	while (faces->count % LANES != 0)
		keep(&lanes, 0, way, faces);
}

#define STEP 0.01f /* of a motion, by which a quotient of differences is taken */

/* The facets stand side by side in the lanes, as in push_block. */
SOIL_CLONED static void change_block(const struct soil_form *restrict f, const struct soil_faces *restrict faces, size_t b, float by_modulus, float changes[restrict 3][3][LANES])
{
	float means[2][3][LANES], before[3][LANES];
	EACH_LANE {
		const size_t n = b + (size_t)i;
		const float at[3] = {faces->x[n], faces->y[n], faces->z[n]}, normal[3] = {faces->nx[n], faces->ny[n], faces->nz[n]};
		float moves[3], lately[3], force[3];
		motion_at(f, &f->recent, at, normal, moves);
		motion_at(f, &f->last, at, normal, lately);
		force_of(f, at, normal, faces->whole[n], faces->under[n], moves, lately, faces->tangent, force);
		for (int k = 0; k < 3; k++) {
			means[0][k][i] = moves[k];
			means[1][k][i] = lately[k];
			before[k][i] = force[k];
		}
	}
	/* The lanes are the loops of vectors. This one is not unrolled: what it calls is large. */
	_Pragma("GCC unroll 1") for (int which = 0; which < 6; which++) {
		const int mean = which / 3, j = which % 3;
		float moved[2][3][LANES], by[LANES];
		memcpy(moved, means, sizeof moved);
		EACH_LANE {
			const float m[3] = {means[mean][0][i], means[mean][1][i], means[mean][2][i]}, step = STEP * most(sqrtf(dot3(m, m)), 0.1f);
			by[i] = by_modulus * (mean == 0 ? 1 : TREND_LAST) / step;
			moved[mean][j][i] += step;
		}
		EACH_LANE {
			const size_t n = b + (size_t)i;
			const float at[3] = {faces->x[n], faces->y[n], faces->z[n]}, normal[3] = {faces->nx[n], faces->ny[n], faces->nz[n]};
			const float moves[3] = {moved[0][0][i], moved[0][1][i], moved[0][2][i]}, lately[3] = {moved[1][0][i], moved[1][1][i], moved[1][2][i]};
			float after[3];
			force_of(f, at, normal, faces->whole[n], faces->under[n], moves, lately, faces->tangent, after);
			for (int k = 0; k < 3; k++)
				changes[k][j][i] = (mean == 0 ? 0 : changes[k][j][i]) + (after[k] - before[k][i]) * by[i];
		}
	}
}

/* A function with copies for several instruction sets keeps its name in the shared library whatever its visibility is: the copies stay behind this one. */
void soil_push_changes(const struct soil_form *form, const struct soil_faces *faces, size_t first, float by_modulus, float changes[3][3][POSTS_LANES])
{
	change_block(form, faces, first, by_modulus, changes);
}
