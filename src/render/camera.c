/*
 * A camera's axes, the view that terrain selects by, and how coarse a mesh may be at which distance. In doubles.
 *
 * By radii, the size on the screen counts. A tile is divided while its posts are more than 6 pixels apart. It is drawn in cells of
 * up to 32 pixels. Flat ground is cut as finely as a cliff, and nothing bounds how wrong a picture is.
 *
 * With a pixel error, height counts. A tile, or a stride within it, is as coarse as that error allows.
 */
#include <math.h>
#include <string.h>

#include "render/internal.h"

/* Most pixels of a post's spacing: beyond, a finer tile is asked for. Most pixels of a mesh cell: beyond, its stride is halved.
 * Tiles are finer than the mesh, since light is computed from their posts. */
#define PIXELS_A_POST 6.0
#define PIXELS_A_CELL 32.0
/* Below this, blocks of one stride would be too small beside their distance to slide in time. */
#define REACH_LEAST 24.0
/* Ruts are finer than the ground. So the mesh is cut more finely where vertices are near enough to show a rut. This depends only on
 * how far apart they are, so that vertices on a shared edge slide alike. shaders/lib/picture.glsl has it too. */
#define RUT_CELL 0.3f /* metres */
/* By pixel error: the least reach of a stride, in its spacings, and as a factor of the reach of the stride before. Vertices slide
 * to a stride from 0.8 of its reach on (shaders/terrain.vert). */
#define ERROR_REACH_LEAST 10.0
#define REACHES_APART 1.25
#define REACH_MOST 1e30 /* metres; a float has room to compute with it */

static double normalise(double v[3])
{
	double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
	for (int i = 0; i < 3; i++)
		v[i] = length > 0 ? v[i] / length : 0;
	return length;
}

void render_axes(const struct render *render, const struct render_camera *camera, struct render_axes *axes)
{
	double *f = axes->forward, *r = axes->right;
	for (int i = 0; i < 3; i++)
		f[i] = camera->target[i] - camera->eye[i];
	if (normalise(f) == 0)
		f[1] = 1;
	const double *u = camera->up;
	const bool upright = u[0] == 0 && u[1] == 0 && u[2] == 0;
	r[0] = upright ? f[1] : f[1] * u[2] - f[2] * u[1];
	r[1] = upright ? -f[0] : f[2] * u[0] - f[0] * u[2];
	r[2] = upright ? 0 : f[0] * u[1] - f[1] * u[0];
	if (normalise(r) < 1e-9) { /* straight up or down: north is the picture's top */
		r[0] = 1;
		r[1] = 0;
	}
	axes->up[0] = r[1] * f[2] - r[2] * f[1];
	axes->up[1] = r[2] * f[0] - r[0] * f[2];
	axes->up[2] = r[0] * f[1] - r[1] * f[0];
	axes->focal = render->height / 2.0 / tan(camera->fov / 2);
}

double render_mesh_reach(const struct render_axes *axes)
{
	return fmax(axes->focal / PIXELS_A_CELL, REACH_LEAST);
}

void render_reaches(const struct render *render, const struct render_axes *axes, const struct terrain_draw *draw,
		    double reaches[TERRAIN_STRIDES])
{
	double spacing = extent_spacing(&render->extent, draw->tile.level);
	for (int k = 0; k < TERRAIN_STRIDES; k++) {
		double apart = spacing * (1 << k);
		if (render->pixel_error <= 0) {
			reaches[k] = apart * render_mesh_reach(axes) * ((float)apart <= RUT_CELL ? RENDER_RUT_REACH : 1);
			continue;
		}
		/* A stride of 2^k is the surface k levels above, so that level's error decides (Equation 3). But a vertex slides to a
		 * new stride over the last fifth of the way. The way must be so long that it does not overtake its neighbours. */
		double reach = draw->errors[k] * (axes->focal / render->pixel_error);
		if (k > 0)
			reach = fmax(reach, fmax(ERROR_REACH_LEAST * apart, REACHES_APART * reaches[k - 1]));
		reaches[k] = fmin(reach, REACH_MOST);
	}
}

void render_view(const struct render *render, const struct render_camera *camera, struct terrain_view *view)
{
	struct render_axes axes;
	render_axes(render, camera, &axes);
	memcpy(view->eye, camera->eye, sizeof view->eye);
	terrain_frustum(camera->eye, axes.forward, axes.right, axes.up, camera->fov,
			(double)render->width / render->height, RENDER_FAR, view->planes);
	view->by_error = render->pixel_error > 0;
	view->radius = view->by_error ? axes.focal / render->pixel_error :
					fmax(axes.focal / PIXELS_A_POST, RENDER_RUT_REACH * render_mesh_reach(&axes)) / render->extent.cells;
	view->finest = TILE_LEVEL_MIN;
}
