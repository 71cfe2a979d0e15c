/*
 * The surface of a mesh: vertices that lie in one place are one, triangles know their neighbours, and all look outwards. It is made once for each mesh
 * and kept in scratch memory, so a contact does no more than compare the mesh with the copy.
 */
#ifndef FURROW_SOIL_SURFACE_H
#define FURROW_SOIL_SURFACE_H

#include "soil/soil.h"

struct soil_surface {
	uint32_t vertex_count, triangle_count;
	float *x, *y, *z;          /* vertices, m, in the object's own axes */
	uint32_t (*corners)[3];    /* indices of vertices; counterclockwise as seen from outside, if it is closed */
	int32_t (*across)[3];      /* the triangle across the edge from a corner to the next; -1: none, or it is not closed */
	bool closed;               /* each edge has two triangles, and all can look outwards */
	float *turned[3];          /* room for the vertices in an attitude */
	/* Only if it is closed. Triangles that turn little at their common edges make up a smooth piece. */
	float (*normals)[3];       /* of triangles: outwards */
	uint32_t *pieces;          /* of triangles */
	uint32_t piece_count;
	float *level, *top;        /* room for numbers of pieces in an attitude */
	bool drum;                 /* it is round about `axis`, which goes through the object's centre, and has flat ends; m */
	double axis[3], radius, width;
	bool even;                 /* the drum's facets are so narrow that it counts as round. Then `mean` is its radius: that of a circle with the area of its
				    * outline */
	double mean;
	bool block;                /* it is a block along the object's axes; m */
	double sides[3];
	/* What it was made of, to know the mesh again. */
	float (*source)[3];
	uint32_t (*source_triangles)[3];
	uint32_t source_vertices, source_count;
	void *memory;
};

#define SURFACES 8
/* Surfaces that were made. Zero it before the first use. */
struct soil_surfaces {
	struct soil_surface kept[SURFACES];
	unsigned next; /* the one that a new mesh replaces */
};

/* Gives the surface of a mesh, valid until another mesh is asked for. STATUS_MEMORY: no room. */
enum status soil_surface_of(struct soil_surfaces *surfaces, const struct soil_mesh *mesh, const struct soil_surface **out) FURROW_CHECKED;
void soil_surfaces_finish(struct soil_surfaces *surfaces);
size_t soil_surfaces_bytes(const struct soil_surfaces *surfaces); /* of all that are kept */

#endif
