/*
 * The facets of a moving body: of a mesh, and of a wheel's grousers. The GPU and the CPU draw the same ones. Pure.
 */
#ifndef FURROW_SOIL_FACETS_H
#define FURROW_SOIL_FACETS_H

#include "soil/shape/body.h"
#include "soil/shape/facet.h"

/* A body's motion over a window. */
struct facets_motion {
	const struct soil_shape *shape;
	const struct soil_pose *from, *to; /* the start; the end, whose attitude counts. The same for a body that does not move */
	double turned;                     /* wheel: rad that it turns forwards during the motion */
	struct body_frame frame;           /* its yaw is not read */
	int32_t width, height;             /* posts of the window from the frame's first one on */
};

/* Receives a facet, which is valid during the call. */
typedef void (*facets_fn)(void *user, const struct facet *facet);

/* Calls `draw` for each triangle of a mesh that is above a post of the window. `corners`: room for the mesh's vertices. */
void soil_mesh_facets(const struct facets_motion *motion, struct facet_corner *corners, facets_fn draw, void *user);
/* Calls `draw` for each facet of a wheel's grousers that is above a post of the window. */
void soil_grouser_facets(const struct facets_motion *motion, facets_fn draw, void *user);

#endif
