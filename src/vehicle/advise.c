/* Advice on vehicles: which spacing their wheels need, and which numbers of the soil they feel that the scene does not give. */
#include <math.h>
#include <stdio.h>

#include "vehicle/vehicle.h"

#define SAME_GRAVITY 0.02 /* gravities that differ by a smaller share are the same: 9.8, 9.81 and 9.80665 are all the Earth's */

/* Returns over how many metres the soil bears a soil geom. 0: not known, since it is neither a wheel nor a sphere. */
static double bears_over(const struct scene *scene, const struct vehicle_info *vehicle, const struct vehicle_geom *geom)
{
	if (geom->shape->kind != SOIL_WHEEL && geom->shape->kind != SOIL_SPHERE)
		return 0;
	return scene_bears_over(scene, geom->shape, vehicle->mass * scene->gravity / (double)vehicle->standing_count, 0);
}

double vehicle_bears_over(const struct vehicles *vehicles, size_t vehicle, size_t number, const struct scene *scene)
{
	struct vehicle_info info;
	struct vehicle_geom geom;
	vehicle_info(vehicles, vehicle, &info);
	vehicle_geom(vehicles, vehicle, number, 1, &geom);
	return bears_over(scene, &info, &geom);
}

static double across(const struct soil_shape *shape)
{
	return shape->kind == SOIL_WHEEL ? shape->width : 2 * shape->radius;
}

/* Bars of a wheel cut soil out and carry it, and pull by that. Without faces they are part of its outline alone: VALIDATION.md, "A measured wheel". */
static void advise_grousers(const char *key, const struct soil_shape *shape, bool faces, size_t alike, double spacing, scene_advice_fn tell, void *user)
{
	char grousers[216], text[400], others[40] = "";
	if (shape->grousers == 0)
		return;
	if (alike > 0)
		snprintf(others, sizeof others, ", as %zu other%s", alike, alike > 1 ? "s" : "");
	snprintf(text, sizeof text, "%s: has grousers%s: where such a wheel slips it pulls less here than a smooth one, and more in tests; give redistribute.faces: on",
		 key, others);
	if (!faces)
		tell(user, text);
	snprintf(grousers, sizeof grousers, "%s: grousers", key);
	scene_advise_grousers(grousers, shape, 0, alike, spacing, tell, user);
}

static void advise_vehicle(const struct scene *scene, const struct vehicles *vehicles, size_t number, double spacing, scene_advice_fn tell, void *user)
{
	struct vehicle_info info;
	vehicle_info(vehicles, number, &info);
	if (info.told_sunk != NULL)
		tell(user, info.told_sunk);
	for (size_t i = 0; i < info.geom_count; i++) {
		struct vehicle_geom geom;
		char key[200];
		vehicle_geom(vehicles, number, i, spacing, &geom);
		snprintf(key, sizeof key, "vehicles.%s", geom.name);
		if (geom.hull)
			continue;
		if (geom.shape->kind == SOIL_BOX) /* a blade, a foot */
			scene_advise_narrow(key, fmin(geom.shape->size[0], geom.shape->size[1]), 0, spacing, tell, user);
		const double over = bears_over(scene, &info, &geom);
		size_t alike = 0;
		bool first = over > 0;
		for (size_t k = 0; k < info.geom_count && first; k++) {
			struct vehicle_geom other;
			vehicle_geom(vehicles, number, k, spacing, &other);
			if (k == i || other.hull || other.shape->kind != geom.shape->kind || bears_over(scene, &info, &other) != over ||
			    across(other.shape) != across(geom.shape))
				continue;
			first = k > i;
			alike++;
		}
		if (!first)
			continue;
		scene_advise_narrow(key, across(geom.shape), alike, spacing, tell, user);
		advise_grousers(key, geom.shape, scene->faces == SCENE_FACES_ON, alike, spacing, tell, user);
		scene_advise_posts_below(key, geom.shape, over, alike, spacing, tell, user);
		if (scene->vehicles[number].driver == SCENE_FOLLOW && scene->vehicles[number].way.speed != 0 && deform_tells_forces(scene->model))
			scene_advise_scatter(key, geom.shape->radius, alike, spacing, fabs(scene->vehicles[number].way.speed), scene->gravity, tell, user);
	}
}

static void advise_damping(const struct scene *scene, scene_advice_fn tell, void *user)
{
	for (int i = 0; i < scene->soil_count; i++) {
		char text[240];
		if (scene->soils[i].damping == 0 || scene_soil_given(scene, i, "damping") || (scene->rocks_soil > 0 && i == scene->rocks_soil))
			continue;
		snprintf(text, sizeof text, "soil.damping: is not given, so it is %g Pa s/m: it adds slip, more at a higher speed; furrow rig and "
					    "furrow mobility have no damping: for the same as there give 0", scene->soils[i].damping);
		tell(user, text);
		return;
	}
}

/* Tells of the wheel whose resistance the soil's rebound changes most. */
static void advise_rebound(const struct vehicles *vehicles, const struct scene *scene, double spacing, scene_advice_fn tell, void *user)
{
	struct scene_rebound worst = {.less = 0};
	for (size_t i = 0; i < vehicle_count(vehicles); i++) {
		struct vehicle_info info;
		vehicle_info(vehicles, i, &info);
		for (size_t k = 0; k < info.geom_count; k++) {
			struct vehicle_geom geom;
			char key[200];
			vehicle_geom(vehicles, i, k, spacing, &geom);
			snprintf(key, sizeof key, "vehicles.%s", geom.name);
			if (!geom.hull)
				scene_rebound_look(scene, key, geom.shape, info.mass * scene->gravity / (double)info.standing_count, &worst);
		}
	}
	scene_rebound_advise(scene, &worst, tell, user);
}

/* Tells of the first vehicle whose model has a gravity that it does not get. */
static void advise_gravity(const struct vehicles *vehicles, const struct world *world, scene_advice_fn tell, void *user)
{
	const double used = world_scene(world)->gravity;
	for (size_t i = 0; world_assumes_gravity(world) && i < vehicle_count(vehicles); i++) {
		struct vehicle_info info;
		char text[300];
		vehicle_info(vehicles, i, &info);
		const double *own = info.own_gravity, most = hypot(hypot(own[0], own[1]), own[2]);
		if (most == 0 || hypot(hypot(own[0], own[1]), own[2] + used) <= SAME_GRAVITY * used)
			continue;
		snprintf(text, sizeof text, "gravity: it is not given, so vehicles weigh as on the Earth, %g m/s2 straight down; that of the model of %.64s, "
					    "%g %g %g, does not count; give gravity: %s", used, info.name, own[0], own[1], own[2],
				     number_exact(most).text);
		tell(user, text);
		return;
	}
}

void vehicle_advise(const struct vehicles *vehicles, const struct world *world, scene_advice_fn tell, void *user)
{
	const struct scene *scene = world_scene(world);
	const double spacing = world_resident(world)->spacing;
	advise_gravity(vehicles, world, tell, user);
	if (vehicle_count(vehicles) > 0)
		advise_damping(scene, tell, user);
	advise_rebound(vehicles, scene, spacing, tell, user);
	for (size_t i = 0; i < vehicle_count(vehicles); i++)
		advise_vehicle(scene, vehicles, i, spacing, tell, user);
}
