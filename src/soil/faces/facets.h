/*
 * The whole surface of a body as small flat facets: for a law in which soil acts on each part of a surface.
 *
 * A facet is a place, an outward unit normal and an area. The place of a facet of a flat face is the middle of its area. The facets of a curved face
 * are its true sectors: they have its area, and their places are on it. A mesh has its own triangles, cut into parts where they are large.
 *
 *  1. The sum of normal times area is zero, to the rounding of floats, for every closed body.
 *  2. The sum of (place . normal) area / 3 is the volume. The error falls with the square of the size of facets.
 *  3. The facets of a wheel, cylinder, sphere, capsule, ellipsoid or box lie as mirror images about each of the body's own planes.
 *  4. The arrays go on to a multiple of SOIL_FACETS_LANES with facets without area, whose normal is up.
 *
 * Grousers have no facets: with them a wheel counts as a drum (shape/bars.h).
 *
 * A mesh is closed if each edge has two triangles that can agree. It is also closed if its triangles, as they are wound, leave no open border that
 * matters. Then its facets look outwards, whether it is wound clockwise or not. An open mesh has facets for both directions. Facets of a closed piece of
 * a mesh inside another piece remain.
 */
#ifndef FURROW_SOIL_FACES_FACETS_H
#define FURROW_SOIL_FACES_FACETS_H

#include "soil/soil.h"

#define SOIL_FACETS_LANES 16
#define SOIL_FACETS_MOST 60000 /* facets of one body. With a size that would make more, a larger size is taken */

/*
 * FACET_UNDER: the rim of a wheel, and all of a body that is no side.
 * FACET_SIDE:  flat ends of wheels and cylinders, walls of boxes, and what of a mesh is within 3 degrees of upright in its own axes.
 */
enum soil_facet_kind { FACET_UNDER, FACET_SIDE };

/* Zero it before the first use. */
struct soil_facets {
	size_t count, room;             /* facets; what the arrays have room for, a multiple of SOIL_FACETS_LANES */
	float *x, *y, *z, *nx, *ny, *nz, *area; /* m, 1, m2; in the body's own axes: x forward, y left, z up */
	uint8_t *kind;                  /* enum soil_facet_kind */
	double size;                    /* m: the longest that a facet is; the size that was asked for, or a larger one */
	bool gathered;                  /* the mesh has very many or very small triangles: each facet is the sum of all that look alike within `size` */
	bool both;                      /* an open mesh: facets look in both directions */
	double low[3], high[3];         /* m: the box along the body's own axes that holds its surface */
	double reach;                   /* m: no place of the surface is farther from the body's centre */
	void *memory;
};

/* Makes the facets of a body in place of those that `facets` has. size: m, above 0: the longest that a facet may be in each of
 * two directions at right angles. A circle always has 16 sectors or more. Out of memory: STATUS_FAILED, and `facets` is empty. Any thread; `facets`
 * belongs to one. */
enum status soil_facets_of(const struct soil_shape *shape, double size, struct soil_facets *facets) FURROW_CHECKED;
void soil_facets_finish(struct soil_facets *facets);
size_t soil_facets_bytes(const struct soil_facets *facets);

#define SOIL_FACETS_KEPT 8
/* Facets that were made, by what a shape is, not by where it lies. Zero it before the first use. One thread. */
struct soil_facets_cache {
	struct soil_facets_entry {
		struct soil_facets facets;
		struct soil_shape shape; /* its mesh is `mesh` */
		struct soil_mesh mesh;   /* a copy */
		double size;             /* that was asked for, m */
		uint64_t asked;          /* when it was asked for last; 0: empty */
	} kept[SOIL_FACETS_KEPT];
	uint64_t asked;
};

/* Gives the facets of a body as soil_facets_of makes them. They are valid until SOIL_FACETS_KEPT - 1 others have been asked for. Out of memory:
 * STATUS_FAILED, and *out is NULL. */
enum status soil_facets_kept(struct soil_facets_cache *cache, const struct soil_shape *shape, double size, const struct soil_facets **out) FURROW_CHECKED;
void soil_facets_cache_finish(struct soil_facets_cache *cache);
size_t soil_facets_cache_bytes(const struct soil_facets_cache *cache); /* of all that are kept */

#endif
