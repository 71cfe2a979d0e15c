/* Rays over the bodies of vehicles, and over the things of the scene's `world`. */
#include <math.h>

#include "vehicle/senses.h"

#define BEHIND 1e-6 /* m: a ray goes on so far behind what is taken away */
#define AWAY_MOST 64 /* floors and other things that are taken away, along one ray */

/* What a model has in its own world is not in the scene: load.c. MuJoCo still knows its shapes. */
static bool is_away(const struct vehicles *vehicles, int geom)
{
	const struct vehicle *of = vehicle_of_geom(vehicles, geom);
	return vehicle_is_fixed(vehicles->model, geom) && (of == NULL || !of->is_world || vehicles->model->geom_type[geom] == mjGEOM_PLANE);
}

double vehicle_ray(const struct vehicles *vehicles, const double origin[3], const double way[3], int excluded, double normal[3])
{
	double from[3], gone = 0;
	mju_copy3(from, origin);
	for (int turn = 0; turn < AWAY_MOST; turn++) {
		int geom = -1;
		const double distance = mj_ray(vehicles->model, vehicles->data, from, way, NULL, 1, excluded, &geom, normal);
		if (distance < 0 || geom < 0)
			return INFINITY;
		gone += distance;
		if (!is_away(vehicles, geom))
			return gone;
		gone += BEHIND;
		mju_addScl3(from, origin, way, gone);
	}
	return INFINITY;
}

struct casting {
	const struct vehicles *vehicles;
	struct vehicle_ray *rays;
	size_t count;
	int excluded;
};

static void cast(void *argument)
{
	const struct casting *casting = argument;
	for (size_t i = 0; i < casting->count; i++) {
		struct vehicle_ray *ray = &casting->rays[i];
		double origin[3];
		mju_sub3(origin, ray->origin, casting->vehicles->origin);
		ray->distance = vehicle_ray(casting->vehicles, origin, ray->way, casting->excluded, ray->normal);
	}
}

enum status vehicle_rays(struct vehicles *vehicles, size_t index, const char *body, struct vehicle_ray *rays, size_t count)
{
	if (vehicles == NULL) {
		for (size_t i = 0; i < count; i++)
			rays[i].distance = INFINITY;
		return STATUS_OK;
	}
	struct casting casting = {vehicles, rays, count, -1};
	if (index != SIZE_MAX)
		casting.excluded = body != NULL ? vehicle_find_part(&vehicles->list[index], mjOBJ_BODY, body) : vehicles->list[index].root;
	return vehicle_guard("rays over vehicles", cast, &casting);
}

void vehicle_frame(const struct vehicles *vehicles, size_t index, const char *body, double at[3], double axes[9])
{
	const struct vehicle *vehicle = &vehicles->list[index];
	const mjData *data = vehicle->data;
	const int number = body != NULL ? vehicle_find_part(vehicle, mjOBJ_BODY, body) : vehicle->root;
	mju_add3(at, vehicle->origin, data->xpos + 3 * number);
	if (body == NULL)
		vehicle_root_axes(vehicle, data, axes);
	else
		mju_copy(axes, data->xmat + 9 * number, 9);
}
