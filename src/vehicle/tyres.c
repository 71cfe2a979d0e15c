/* Gives wheels of a vehicle their tyres, as the scene's `tyres` says. What a tyre does is in src/soil/law/tyre.h. */
#include <math.h>
#include <stdio.h>

#include "vehicle/internal.h"

/* The load of each soil geom on level ground, N. Of a model that does not stand each has the same. */
static double load_of(const struct vehicle *vehicle, const struct scene *scene, const struct soil_geom *geom)
{
	return vehicle_mass(vehicle) * scene->gravity * (geom->share > 0 ? geom->share : 1 / (double)vehicle->standing_count);
}

static enum status set_tyre(const struct vehicle *vehicle, const struct scene *scene, const struct scene_tyre *tyre, struct soil_geom *geom)
{
	struct soil_tyre_told told = tyre->told;
	told.load = isnan(told.load) ? load_of(vehicle, scene, geom) : told.load;
	if (!(told.load > 0))
		return fail_with(STATUS_INPUT, "%s: it bears no weight on level ground, so its tyre has no load at which to be as stiff as told; give load in tyres", geom->name);
	geom->shape.width = isnan(tyre->width) ? geom->shape.width : tyre->width;
	told.damping = isnan(told.damping) ? scene_tyre_damping(&told, scene->gravity) : told.damping;
	return soil_tyre_set(geom->name, &told, &geom->shape, NULL);
}

static enum status no_wheel(const struct vehicle *vehicle, const char *pattern, const char *where)
{
	char names[200] = "";
	size_t length = 0;
	for (size_t g = 0; g < vehicle->geom_count && length + 80 < sizeof names; g++) {
		char name[64];
		vehicle_geom_name(vehicle, vehicle->geoms[g].geom, name, sizeof name);
		if (vehicle->geoms[g].shape.kind == SOIL_WHEEL)
			length += (size_t)snprintf(names + length, sizeof names - length, "%s%s", length > 0 ? ", " : "", name);
	}
	return fail_with(STATUS_INPUT, "%s: tyres: %.64s names no wheel that presses the ground; its wheels: %s", where, pattern, length > 0 ? names : "none");
}

enum status vehicle_make_tyres(struct vehicle *vehicle, const struct scene *scene)
{
	const struct scene_vehicle *from = vehicle->scene;
	char where[VEHICLE_WHERE];
	if (from->tyre_count == 0)
		return STATUS_OK;
	vehicle_where(vehicle, scene, where);
	TRY(vehicle_find_own_shares(vehicle, scene));
	for (size_t i = 0; i < from->tyre_count; i++) {
		const struct scene_texts pattern = {.list = &from->tyres[i].geom, .count = 1};
		bool any = false;
		for (size_t g = 0; g < vehicle->geom_count; g++) {
			struct soil_geom *geom = &vehicle->geoms[g];
			char name[256];
			vehicle_geom_name(vehicle, geom->geom, name, sizeof name);
			if (geom->shape.kind != SOIL_WHEEL || !vehicle_matches(&pattern, name, false))
				continue;
			any = true;
			if (geom->shape.tyre.stiffness == 0)
				TRY(set_tyre(vehicle, scene, &from->tyres[i], geom));
		}
		if (!any)
			return no_wheel(vehicle, from->tyres[i].geom, where);
	}
	for (size_t g = 0; g < vehicle->geom_count; g++)
		vehicle->geoms[g].share = 0; /* found again where it is asked for */
	return STATUS_OK;
}
