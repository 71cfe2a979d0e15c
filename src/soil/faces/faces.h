/*
 * The faces of a body: what soil pushes on them from every side as it slides. They count beside the law of the lower envelope (law/bear.h), in the
 * share that slid.h tells. A contact, its search for the equilibrium height and a probe add the same faces. FACES.md has the law.
 */
#ifndef FURROW_SOIL_FACES_H
#define FURROW_SOIL_FACES_H

#include "soil/faces/facets.h"
#include "soil/faces/wedge.h"
#include "soil/law/bear.h"

/* Facets that push, in arrays of whole blocks; m from the body's centre in its frame. */
#define FACES_EACH(EACH) \
	EACH(x) EACH(y) EACH(z)             /* middle */ \
	EACH(nx) EACH(ny) EACH(nz)          /* outward normal */ \
	EACH(whole)                         /* area of the facet, m2 */ \
	EACH(under)                         /* 1: it bears the body: FACET_UNDER, and a side that looks down; 0: it is another side */ \
	EACH(share)                         /* area that pushes, m2 */ \
	EACH(known)                         /* of a block's first facet: 1: the numbers of the next three lines are known (push.h); else they are 0 */ \
	EACH(px) EACH(py) EACH(pz)          /* force for each pascal, m2: share times alpha */ \
	EACH(weight) EACH(cohesive)         /* of its wedge: struct soil_wedge */ \
	EACH(into) EACH(thrown)             /* how fast it moves into the soil, m/s; force of the soil's inertia if all of it is in soil, N */ \
	EACH(sole) EACH(faces_way)          /* 1: it faces down; how much it faces the way in which the body slides, 0 .. 1 */ \
	EACH(tall)                          /* half of its height, m */ \
	EACH(pressure) EACH(steepens)        /* at a height: Pa for each unit of alpha; how that grows with depth, Pa/m */ \
	EACH(deep) EACH(found_deep)         /* at a height: depth of its middle below the ground that pushes it, and below that as the body found it, m */ \
	EACH(heap)                          /* height of the heap upon the wedge ahead, m */
/* Numbers of a soil for footing.c. */
struct soil_footing {
	float by_depth, by_width, by_cohesion; /* Pa/m, Pa/m, Pa: parts of its bearing capacity */
	float by_both, upright;                /* 1 / (Nc tan phi); 1 - h */
	float k_c, k_phi, n;                   /* Bekker's */
};

struct soil_faces {
	size_t count, room; /* count: a multiple of POSTS_LANES; 0: no facet pushes */
#define FACES_ARRAY(name) float *name;
	FACES_EACH(FACES_ARRAY)
#undef FACES_ARRAY
	float *memory;
	/* The surface of the soil over a rectangle of posts around the body, row by row: m above the centre at motion->to. */
	struct post_rect rect;
	/* surface: as it is. found: as the body finds it, without its own heap. ahead: that ahead of each post. under_from: where a facet that looks down counts its
	 * depth from. heap_ahead: height of the heap ahead. inside: how much of the post is in the body. since, until: ways in the body from its front, and to its rear.
	 * ground: the base. envelope: the body's lower one. All m above the centre. cover: share of the post's cell that the body is above.
	 * over_base: `ahead` above the base. laid: deposited and not dug by slip; laid_ahead: the same ahead, without the body's own heap; m. */
#define FACES_PLANES_EACH(EACH) \
	EACH(surface) EACH(found) EACH(ahead) EACH(under_from) EACH(heap_ahead) EACH(inside) EACH(since) EACH(until) EACH(ground) EACH(offset) EACH(envelope) EACH(cover) \
	EACH(over_base) EACH(laid) EACH(laid_ahead)
#define FACES_PLANE(name) float *name;
	FACES_PLANES_EACH(FACES_PLANE)
#undef FACES_PLANE
	size_t posts;
	float *planes;
	struct soil_facets_cache cache;
	float xi, cohesion, by_modulus, unit_weight, wedge_length; /* of the soil below the body: N/m3, Pa, 1/m, N/m3; length of a wedge over its depth */
	struct soil_wedge wedge;
	struct soil_footing footing;
	float beyond;         /* m: so far ahead of the body the ground is as the body finds it */
	float inertia;        /* lambda rho of the soil, kg/m3 */
	float tangent;        /* of the friction along the body's surface */
	float d[2];           /* direction in which it slides, east and north; 0: none */
};

/* Returns how much of a facet is in soil, 0 .. 1. deep: depth of its middle; tall: half of its height; size: of a level facet, which is borne whole from this depth on; m. */
SOIL_INLINED float soil_facet_in(float deep, float tall, float size)
{
	return clamped((deep + tall) / most(2 * tall, size), 0, 1);
}

/* Gives the direction in which a body slides, in its frame. */
SOIL_INLINED void soil_faces_way(const struct soil_body *body, const struct soil_faces *faces, float way[2])
{
	const float c = (float)body->axis[0], s = (float)body->axis[1];
	way[0] = c * faces->d[0] + s * faces->d[1];
	way[1] = c * faces->d[1] - s * faces->d[0];
}

/* Finds the recent motion of a body at the end of its motion, and lists the facets that push. Sets form->recent, form->last and form->scooped. Reads the surface around
 * the body. planes NULL: no facet pushes. STATUS_MEMORY. */
enum status soil_faces_begin(const struct soil_law *law, const struct soil_planes *planes, const struct soil_body *body, struct post_rect below, struct soil_form *form,
			     struct soil_faces *faces) FURROW_CHECKED;
/* Finds from where depths count with the centre raised by so many fixed-point units: those of the facets, and of posts as gathered for soil_bear. Sets form->sole. */
void soil_faces_look(const struct soil_planes *planes, const struct soil_body *body, struct soil_form *form, struct soil_posts *posts, int32_t raised, struct soil_faces *faces);
/* Adds what the facets push at that height, as soil_bear does. */
void soil_faces_add(const struct soil_body *body, const struct soil_form *form, float share, struct soil_faces *faces, struct soil_sums *sums,
		    struct soil_changes *changes);
void soil_faces_finish(struct soil_faces *faces);
size_t soil_faces_bytes(const struct soil_faces *faces);

#endif
