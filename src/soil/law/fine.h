/*
 * The raster of a mesh: its lower envelope at places closer together than posts, and what the mesh covers of the cells of posts. Drawn once a contact.
 *
 *  1. place:   vertices are turned, and put in places of the raster (fine.c);
 *  2. draw:    each triangle that looks down lowers the places below it (fine.c);
 *  3. outline: the edges between triangles that look down and others give the exact part of each cell that is covered, and how far the mesh
 *              reaches along its motion (outline.c). Steep walls are not drawn, as they are narrower than places where they are in soil: they bear
 *              beside the cells that have their lower edges (brims.c);
 *  4. beside:  places beside the mesh get heights that go on from its edge (beside.c);
 *  5. motion:  how much lower the mesh was above each place during its motion (passed.c). The raster is pushed back along the motion. If the mesh turned
 *              and is not round about that axis, it is drawn anew in its earlier attitudes (fine.c).
 *
 * A mesh that is open, or that no turning of its triangles makes closed, has no outline. There the places count that it covers.
 */
#ifndef FURROW_SOIL_FINE_H
#define FURROW_SOIL_FINE_H

#include "soil/law/form.h"
#include "soil/law/surface.h"

#define FINE_ENOUGH 44       /* a mesh so many posts wide has a place for each post. Otherwise */
#define FINE_ACROSS 50       /* at least so many places lie across it, */
#define FINE_PARTS_MOST 7    /* unless a post is parted in more than this */
#define FINE_ROUND 5e-4f     /* a mesh is round about its axis if turning moves its surface by less than this share of its reach */
#define FINE_TURNS 0.06f     /* rad between the attitudes of a mesh that is not, at most, */
#define FINE_ATTITUDES 16    /* unless these are more */
#define FINE_WALL ((float)FORM_WALL_LEAST) /* z of a normal. A smooth piece of the surface that is steeper everywhere is a wall, if it rises from an edge of another */

/* Where a triangle looks: not down; down; down, and it is part of a wall. */
enum { FINE_UP, FINE_SOLE, FINE_SIDE };

/* Scratch memory of rasters. Zero it before the first use. */
struct soil_fine_work {
	struct soil_surfaces surfaces;
	const struct soil_surface *surface;
	/* Vertices: places to the east and north, heights in m. looks: of triangles. */
	float *u, *v, *z;
	uint8_t *looks;
	bool any_wall;
	float *walls;    /* raster of places */
	struct soil_brim *brims;
	uint32_t *onward; /* of vertices: the next one of the outline */
	/* Rasters of places; of cells, row by row; of strips along the motion. */
	float *drawn, *heights, *less, *since, *swept;
	float *sums[5];
	float *areas, *middles[2], *lows, *passed, *earlier[2];
	float *earlier_u, *earlier_v, *earlier_z;
	float *front, *rear;
	float *row; /* of places: three rows */
	void *memory;
	size_t room; /* bytes */
};

/* Draws the mesh of a form of kind FORM_RASTER, and sets form->fine, which points into `work`. STATUS_MEMORY: no room. */
enum status soil_fine_draw(const struct soil_body *body, struct soil_form *form, struct soil_fine_work *work) FURROW_CHECKED;
void soil_fine_finish(struct soil_fine_work *work);

/* The steps, for fine.c. */
void soil_fine_outline(const struct soil_fine_work *work, struct soil_fine *fine);
/* Finds the walls of the mesh in its attitude: sets looks, any_wall and the numbers of pieces. own: the object's axes. */
void soil_fine_walls(struct soil_fine_work *work, const double own[3][3]);
/* Marks the triangles that look down in another attitude, and are parts of walls. */
void soil_fine_mark(const struct soil_fine_work *work);
/* Sets the brims of cells. After soil_fine_outline, as covered posts are known then. */
void soil_fine_brims(const struct soil_fine_work *work, struct soil_fine *fine);
/* Sets the heights of all places from the drawn ones. bound: m: no height is farther from 0. */
void soil_fine_beside(const struct soil_fine_work *work, const struct soil_fine *fine, float bound);
/* Sets `passed` from the swept raster as it is. */
void soil_fine_passed(const struct soil_fine_work *work, const struct soil_fine *fine);
/* Sets `lows` from the swept raster. */
void soil_fine_lows(const struct soil_fine_work *work, const struct soil_fine *fine);
/* Sets `less` from `swept`. */
void soil_fine_less(const struct soil_fine_work *work, struct soil_fine *fine);
void soil_fine_swept(const struct soil_fine_work *work, const struct soil_form *form, struct soil_fine *fine);

#endif
