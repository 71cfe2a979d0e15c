/* The sun of a time and a place. It moves with the simulated time. */
#include <math.h>

#include "dem/dem.h"
#include "render/view.h"

#define DAY 86400.0
#define NORTH 1e-4 /* degrees, about 10 m on the Earth */

/* Finds the longitude and latitude of the terrain's middle, and the way of true north there. */
static enum status place_in(struct view *view, struct dem_globe *globe)
{
	const struct store_meta *meta = view->world->meta;
	const double spacing = meta->extent.spacing;
	double x[2] = {meta->origin[0] + (double)(meta->extent.width - 1) * spacing / 2}, y[2] = {meta->origin[1] + (double)(meta->extent.height - 1) * spacing / 2};
	dem_globe_to_degrees(globe, 1, x, y);
	view->light.longitude = x[0] * M_PI / 180;
	view->light.latitude = y[0] * M_PI / 180;
	x[1] = x[0];
	y[1] = fmin(y[0] + NORTH, 90);
	y[0] = y[1] - NORTH;
	if (!isfinite(view->light.longitude) || !isfinite(view->light.latitude))
		return fail_with(STATUS_INPUT, "view.sun.time: the middle of the store has no longitude and latitude; give view.sun.at");
	dem_globe_from_degrees(globe, 2, x, y);
	view->north = isfinite(x[1] - x[0] + y[1] - y[0]) ? atan2(x[1] - x[0], y[1] - y[0]) : 0;
	return STATUS_OK;
}

enum status render_view_find_place(struct view *view)
{
	struct dem_globe *globe = NULL;
	view->light = view->world->scene->view.light;
	if (!view->light.timed || view->light.placed)
		return STATUS_OK;
	enum status status = view->world->meta->srs[0] != '\0' ? dem_globe_create(view->world->meta->srs, &globe) : STATUS_OK;
	if (status != STATUS_OK)
		return status;
	if (globe == NULL)
		return fail_with(STATUS_INPUT, "view.sun.time: the store has no reference system, so where it is is not known; give view.sun.at");
	status = place_in(view, globe);
	dem_globe_destroy(globe);
	return status;
}

void render_view_move_sun(struct view *view)
{
	const struct scene_light *light = &view->light;
	double azimuth, height;
	if (!light->timed)
		return;
	scene_sun_at(light->body, light->days + view->world->time / DAY, light->longitude, light->latitude, &azimuth, &height);
	render_move_sun(view->render, azimuth + view->north, height);
}
