/* The sun of a time and a place. It moves with the simulated time. */
#include <math.h>

#include "dem/dem.h"
#include "render/view.h"

#define DAY 86400.0
#define NORTH 1e-4 /* degrees, about 10 m on the Earth */

/* Finds the longitude and latitude of the terrain's middle, and the way of true north there. */
static enum status place_in(const struct store_meta *meta, struct dem_globe *globe, struct render_sun *sun)
{
	const double spacing = meta->extent.spacing;
	double x[2] = {meta->origin[0] + (double)(meta->extent.width - 1) * spacing / 2}, y[2] = {meta->origin[1] + (double)(meta->extent.height - 1) * spacing / 2};
	dem_globe_to_degrees(globe, 1, x, y);
	sun->light.longitude = x[0] * M_PI / 180;
	sun->light.latitude = y[0] * M_PI / 180;
	x[1] = x[0];
	y[1] = fmin(y[0] + NORTH, 90);
	y[0] = y[1] - NORTH;
	if (!isfinite(sun->light.longitude) || !isfinite(sun->light.latitude))
		return fail_with(STATUS_INPUT, "view.sun.time: the middle of the store has no longitude and latitude; give view.sun.at");
	dem_globe_from_degrees(globe, 2, x, y);
	sun->north = isfinite(x[1] - x[0] + y[1] - y[0]) ? atan2(x[1] - x[0], y[1] - y[0]) : 0;
	return STATUS_OK;
}

enum status render_sun_find(const struct scene_light *light, const struct store_meta *meta, struct render_sun *out)
{
	struct dem_globe *globe = NULL;
	*out = (struct render_sun){.light = *light};
	if (!light->timed || light->placed)
		return STATUS_OK;
	if (meta->srs[0] != '\0')
		TRY(dem_globe_create(meta->srs, &globe));
	if (globe == NULL)
		return fail_with(STATUS_INPUT, "view.sun.time: the store has no reference system, so where it is is not known; give view.sun.at");
	enum status status = place_in(meta, globe, out);
	dem_globe_destroy(globe);
	return status;
}

void render_sun_at(const struct render_sun *sun, double time, double *azimuth, double *height)
{
	const struct scene_light *light = &sun->light;
	*azimuth = light->azimuth;
	*height = light->height;
	if (!light->timed)
		return;
	scene_sun_at(light->body, light->days + time / DAY, light->longitude, light->latitude, azimuth, height);
	*azimuth += sun->north;
}

void render_view_move_sun(struct view *view)
{
	double azimuth, height;
	if (!view->sun.light.timed)
		return;
	render_sun_at(&view->sun, world_time(view->world), &azimuth, &height);
	render_move_sun(view->render, azimuth, height);
}
