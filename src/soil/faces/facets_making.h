/* How facets are made: each shape puts its facets one by one. They are counted first, then written. For files facets_*.c. */
#ifndef FURROW_SOIL_FACES_FACETS_MAKING_H
#define FURROW_SOIL_FACES_FACETS_MAKING_H

#include <math.h>

#include "soil/faces/facets.h"

#define FACETS_CIRCLE 16  /* a circle has at least so many sectors */
#define FACETS_LEAST 1e-5 /* a size is at least this share of how far a body reaches */

struct facets_gather;
struct facets_mesh;

struct facets_making {
	const struct soil_shape *shape;
	double size;                  /* m: the longest side */
	size_t count;                 /* facets so far */
	struct soil_facets *into;     /* where they are written; NULL: they are only counted */
	const struct facets_mesh *mesh; /* of a mesh: its triangles */
	struct facets_gather *gather; /* facets of a mesh that look alike become one there; NULL: not */
};

/* Returns true if there are too many facets. Then a shape need not put the others. */
static inline bool facets_full(const struct facets_making *m)
{
	return m->count > SOIL_FACETS_MOST;
}

/* Returns into how many parts a length is divided, at least one. So many that facets are too many count as that. */
static inline int facets_parts(double length, double size)
{
	return (int)fmin(fmax(ceil(length / size * (1 - 1e-12)), 1), SOIL_FACETS_MOST + 1);
}

/* Returns into how many sectors a circle is divided: a multiple of 4. least: of these at least so many. */
static inline int facets_sectors(double radius, double size, double least)
{
	return 4 * (int)fmin(fmax(ceil(fmax(2 * M_PI * radius / size * (1 - 1e-12), least) / 4), 1), SOIL_FACETS_MOST / 4 + 1);
}

/* Adds a facet. at: m. vector: its outward normal times its area, m2; no length: no facet. */
void soil_facets_put(struct facets_making *m, const double at[3], const double vector[3], enum soil_facet_kind kind);

/* A rectangle: its middle, and half of each side as vectors. It looks along their cross product. */
void soil_facets_put_rectangle(struct facets_making *m, const double middle[3], const double half[2][3], enum soil_facet_kind kind);
/* Shapes that are round: facets_round.c. */
void soil_facets_put_drum(struct facets_making *m, int axis, double radius, double length);
void soil_facets_put_ball(struct facets_making *m, const double half[3], double straight);

/* Meshes: facets_mesh.c. begin: STATUS_FAILED: out of memory. many: the triangles are so many, or so small, that their facets must be gathered. */
enum status soil_facets_mesh_begin(const struct soil_mesh *mesh, double size, struct facets_mesh **out, bool *both, bool *many) FURROW_CHECKED;
void soil_facets_mesh_end(struct facets_mesh *mesh); /* takes NULL */
void soil_facets_put_mesh(struct facets_making *m);

/* Gathering: facets_gather.c. create: STATUS_FAILED: out of memory. */
enum status soil_facets_gather_create(struct facets_gather **out) FURROW_CHECKED;
void soil_facets_gather_destroy(struct facets_gather *gather); /* takes NULL */
void soil_facets_gather_clear(struct facets_gather *gather);
/* Adds a part of the surface. Returns true if it is the first of its facet. size: m. */
bool soil_facets_gather_add(struct facets_gather *gather, double size, const double at[3], const double vector[3], enum soil_facet_kind kind);
/* Writes all facets. m->gather is not asked. */
void soil_facets_gather_put(const struct facets_gather *gather, struct facets_making *m);

#endif
