/*
 * Computes a camera's axes, the view that render_select needs, and how coarse a mesh may be at which distance. All in doubles.
 *
 * Without a pixel error, the distance of posts on the screen decides. A tile is divided while its posts are more than 6 pixels
 * apart. The mesh is drawn in cells of up to 32 pixels. Flat ground is cut as finely as a cliff, and the error is not bounded.
 *
 * With a pixel error, the error of height on the screen decides. A tile, and a stride within it, is as coarse as the error allows.
 * A stride is the distance between two vertices of the mesh, in posts. The reach of a stride is the distance from the camera beyond
 * which the mesh has this stride or a coarser one.
 */
#include <math.h>
#include <string.h>

#include "render/internal.h"

/* If posts are more pixels apart than this, a finer tile is selected. If a mesh cell is wider than this, its stride is halved. Tiles
 * are finer than the mesh, since light is computed from their posts. */
#define PIXELS_A_POST 6.0
#define PIXELS_A_CELL 32.0
/* The same with truth, where each triangle has one light. Not finer than tiles are selected. */
#define PIXELS_A_TRUE_CELL 10.0
/* The least reach of a stride, in its spacings. Below it, the zone in which vertices move to the next stride would be too narrow. */
#define REACH_LEAST 24.0
/* Ruts are finer than the ground. So strides up to this length have a longer reach, which shows ruts from farther away. The reach
 * depends only on the stride's length, so that vertices on an edge of two tiles move alike. shaders/lib/picture.glsl has it too. */
#define RUT_CELL 0.3f /* metres */
/* With a pixel error: the least reach of a stride, in its spacings, and as a multiple of the reach of the next finer stride. Between
 * 0.8 of a reach and the reach, vertices move to the coarser stride (shaders/terrain.vert). */
#define ERROR_REACH_LEAST 10.0
#define REACHES_APART 1.25
#define REACH_MOST 1e30 /* metres; small enough that floats do not overflow */

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
	axes->focal = render->screen->height / 2.0 / tan(camera->fov / 2);
}

double render_mesh_reach(const struct render *render, const struct render_axes *axes)
{
	return fmax(axes->focal / (render->truth ? PIXELS_A_TRUE_CELL : PIXELS_A_CELL), REACH_LEAST);
}

void render_reaches(const struct render *render, const struct render_axes *axes, const struct render_draw *draw,
		    double reaches[RENDER_STRIDES])
{
	double spacing = extent_spacing(&render->extent, draw->tile.level);
	for (int k = 0; k < RENDER_STRIDES; k++) {
		double apart = spacing * (1 << k);
		if (render->pixel_error <= 0) {
			reaches[k] = apart * render_mesh_reach(render, axes) * ((float)apart <= RUT_CELL ? RENDER_RUT_REACH : 1);
			continue;
		}
		/* A stride of 2^k posts shows the surface of the level k levels above. So the error of that level decides (Equation 3).
		 * But the zones of two strides, in which vertices move, must not overlap. So each reach is at least 1.25 of the one
		 * before. */
		double reach = draw->errors[k] * (axes->focal / render->pixel_error);
		if (k > 0)
			reach = fmax(reach, fmax(ERROR_REACH_LEAST * apart, REACHES_APART * reaches[k - 1]));
		reaches[k] = fmin(reach, REACH_MOST);
	}
}

void render_view(const struct render *render, const struct render_camera *camera, struct render_view *view)
{
	struct render_axes axes;
	render_axes(render, camera, &axes);
	memcpy(view->eye, camera->eye, sizeof view->eye);
	render_frustum(camera->eye, axes.forward, axes.right, axes.up, camera->fov,
			(double)render->screen->width / render->screen->height, RENDER_FAR, view->planes);
	view->by_error = render->pixel_error > 0;
	view->radius = view->by_error ? axes.focal / render->pixel_error :
					fmax(axes.focal / PIXELS_A_POST, RENDER_RUT_REACH * render_mesh_reach(render, &axes)) / render->extent.cells;
	view->finest = TILE_LEVEL_MIN;
}
