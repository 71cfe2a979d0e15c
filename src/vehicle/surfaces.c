/* What the surfaces of soil geoms are of: the scene's `interface`. */
#include <string.h>

#include "vehicle/internal.h"

static bool names(const struct vehicle *vehicle, const struct scene_surface *surface, const struct soil_geom *geom)
{
	char name[256];
	vehicle_geom_name(vehicle, geom->geom, name, sizeof name);
	return vehicle_matches(&(struct scene_texts){(char **)&surface->geoms, 1}, name, false);
}

/* Returns true if MuJoCo's own contacts have no friction there, whatever the ground is: condim 1, with a priority above that of a ground. */
static bool slides(const struct vehicle *vehicle, const struct soil_geom *geom)
{
	return vehicle->model->geom_condim[geom->geom] == 1 && vehicle->model->geom_priority[geom->geom] > 0;
}

static bool any_names(const struct vehicle *vehicle, const struct soil_geom *geom)
{
	bool any = false;
	for (size_t i = 0; i < vehicle->scene->surface_count && !any; i++)
		any = names(vehicle, &vehicle->scene->surfaces[i], geom);
	return any;
}

struct soil_interface vehicle_surface(const struct vehicle *vehicle, const struct soil_geom *geom)
{
	struct soil_interface interface = {.has_friction = slides(vehicle, geom), .has_adhesion = slides(vehicle, geom)};
	for (size_t i = 0; i < vehicle->scene->surface_count; i++)
		if (names(vehicle, &vehicle->scene->surfaces[i], geom))
			interface = vehicle->scene->surfaces[i].interface;
	return interface;
}

enum status vehicle_check_surfaces(const struct vehicle *vehicle, const char *where)
{
	for (size_t i = 0; i < vehicle->scene->surface_count; i++) {
		bool any = false;
		for (size_t g = 0; g < vehicle->geom_count && !any; g++)
			any = names(vehicle, &vehicle->scene->surfaces[i], &vehicle->geoms[g]);
		if (!any)
			return fail_with(STATUS_INPUT, "%s: interface: %.64s names no geom that presses the ground; the first of them is %s", where, vehicle->scene->surfaces[i].geoms,
					 vehicle->geoms[0].name + strlen(vehicle->scene->name) + 1);
	}
	for (const struct soil_geom *geom = vehicle->geoms; geom < vehicle->geoms + vehicle->geom_count; geom++)
		if (slides(vehicle, geom) && !any_names(vehicle, geom))
			note("%s: %s slides on the soil without friction, as its condim 1 and its priority say; interface: {%s: rubber} takes the soil's own", where, geom->name,
			     geom->name + strlen(vehicle->scene->name) + 1);
	return STATUS_OK;
}
