/*
 * The longest step that is stable.
 *
 * Soil that unloads is a spring of K_e A: its elastic stiffness times the area of the contact. A mass m on a spring k is stable for
 * steps below 2 sqrt(m / k), if its force is taken at the step's start. The coupling takes it at the step's end (coupling.c). So it is
 * stable beyond that, too, but then the motion is no longer the soil's. m is the least effective mass of a soil geom, straight up and
 * down, in the model's first pose. A is the contact's area where the geom carries its share of the weight. K_e A is the greatest of all soils: hard ground has
 * the stiffer spring, and soft soil the larger area. Of a raster it is that of its stiffest post. A layer over stiffer ground is stiffer than its soil is.
 */
#include <math.h>
#include <stdio.h>

#include "vehicle/internal.h"

/* Mass that a vertical force on the geom's middle moves. */
static double mass_of(const struct vehicle *vehicle, int geom)
{
	const mjModel *model = vehicle->model;
	double *row = vehicle->room, *solved = row + 3 * model->nv;
	mj_jacGeom(model, vehicle->data, row, NULL, geom);
	const double *up = row + 2 * model->nv;
	mj_solveM(model, vehicle->data, solved, up, 1);
	const double inverse = mju_dot(solved, up, model->nv);
	return inverse > 0 ? 1 / inverse : INFINITY;
}

/* Returns the area that an ellipsoid shows at a sinkage, on its flattest side. */
static double flattest(const double radii[3], double sinkage)
{
	const double least = fmin(radii[0], fmin(radii[1], radii[2])), up = fmax(1 - sinkage / least, 0);
	return M_PI * radii[0] * radii[1] * radii[2] / least * (1 - up * up);
}

static double of_box(const struct soil_mesh *mesh)
{
	double size[3];
	for (int k = 0; k < 3; k++)
		size[k] = mesh->high[k] - mesh->low[k];
	return fmax(size[0] * size[1], fmax(size[1] * size[2], size[2] * size[0]));
}

/* About the area in plan that touches at a sinkage. */
static double area_of(const struct soil_shape *shape, double sinkage)
{
	const double depth = fmin(fmax(sinkage, 0), shape->radius);
	const double half = sqrt(depth * (2 * shape->radius - depth)); /* of the chord of a circle */
	switch (shape->kind) {
	case SOIL_WHEEL:
		return shape->width * 2 * half;
	case SOIL_SPHERE:
		return M_PI * half * half;
	case SOIL_BOX:
		return shape->size[0] * shape->size[1];
	case SOIL_CAPSULE: /* lying */
		return M_PI * half * half + shape->length * 2 * half;
	case SOIL_CYLINDER: /* upright, or lying */
		return fmax(M_PI * shape->radius * shape->radius, shape->length * 2 * half);
	case SOIL_ELLIPSOID:
		return flattest(shape->size, sinkage);
	case SOIL_MESH: /* on the largest side of the box around it */
		return of_box(shape->mesh);
	default: {
		const double bound = soil_shape_bound(shape);
		return M_PI * bound * bound;
	}
	}
}

#define HARDLY 0.01      /* kg: what a geom that bears the vehicle has no less of, unless masses are missing */
#define PARTS_MOST 50.0 /* of a time_step: a model that needs more has a geom that is too light for its soil */

/* Shortens the longest step to what a soil of this stiffness, Pa/m, allows. */
static void allow(struct vehicle *vehicle, const struct scene *scene, const struct soil_numbers *soil, double stiffness)
{
	const double load = vehicle_mass(vehicle) * scene->gravity / (double)vehicle->standing_count;
	for (size_t i = 0; i < vehicle->geom_count; i++) {
		const struct soil_geom *geom = &vehicle->geoms[i];
		if (!geom->is_standing) /* its contact is implicit, too: it stays stable */
			continue;
		const double sinkage = soil_sinkage_guess(&geom->shape, soil, load), area = area_of(&geom->shape, sinkage), stiffens = soil_stiffens(&geom->shape, soil, sinkage), effective = mass_of(vehicle, geom->geom);
		const double step = 2 * sqrt(effective / (stiffness * stiffens * area));
		if (step >= vehicle->largest_step)
			continue;
		vehicle->largest_step = step;
		vehicle->largest_mass = effective;
		vehicle->largest_area = area;
		vehicle->largest_geom = i;
	}
}

/* `raster`: what is told of the raster that was looked at last. */
static enum status check(const struct vehicle *vehicle, const struct scene *scene, const char *raster)
{
	char where[VEHICLE_WHERE];
	if (scene->time_step <= vehicle->largest_step)
		return STATUS_OK;
	vehicle_where(vehicle, scene, where);
	return fail_with(STATUS_INPUT, "%s: time_step: %g s is longer than %s s, the longest that is stable (%s: %.3g kg on %.3g m2 of soil%s); give "
				       "%sat most that", where, scene->time_step, number_at_most(vehicle->largest_step, 3).text, vehicle->geoms[vehicle->largest_geom].name,
			 vehicle->largest_mass, vehicle->largest_area, raster, vehicle->largest_mass < HARDLY ? "its link the mass that it has, or " : "");
}

void vehicle_find_bound(struct vehicle *vehicle, const struct scene *scene)
{
	vehicle->largest_step = INFINITY;
	for (int i = 0; i < scene->soil_count; i++)
		allow(vehicle, scene, &scene->soils[i], scene->soils[i].elastic_stiffness);
}

enum status vehicle_divide_step(struct vehicles *vehicles)
{
	const struct scene *scene = vehicles->scene;
	const struct vehicle *shortest = &vehicles->list[0];
	for (size_t v = 1; v < vehicles->all; v++)
		if (vehicles->list[v].largest_step < shortest->largest_step)
			shortest = &vehicles->list[v];
	const double parts = ceil(scene->time_step / shortest->largest_step * (1 - 1e-12));
	if (!(parts > 1))
		return STATUS_OK;
	if (!(parts <= PARTS_MOST))
		return check(shortest, scene, "");
	vehicles->divided = *scene;
	vehicles->divided.time_step = scene->time_step / parts;
	vehicles->scene = &vehicles->divided;
	note("time_step: %g s is longer than %s s, the longest that is stable (%s: %.3g kg on %.3g m2 of soil): each is made in %g steps of %.4g s", scene->time_step,
	     number_at_most(shortest->largest_step, 3).text, shortest->geoms[shortest->largest_geom].name, shortest->largest_mass, shortest->largest_area, parts,
	     vehicles->divided.time_step);
	return STATUS_OK;
}

/* The stiffest post of a raster may be of any soil. */
static enum status check_raster(struct vehicle *vehicle, const struct scene *scene, const struct world_raster *raster)
{
	char told[120];
	for (int i = 0; i < scene->soil_count; i++)
		allow(vehicle, scene, &scene->soils[i], raster->high);
	snprintf(told, sizeof told, "; soil.rasters.%s has at most %g %s", raster->key, raster->high, raster->unit);
	return check(vehicle, scene, told);
}

/* The thinnest layer is the stiffest. */
static enum status check_thickness(struct vehicle *vehicle, const struct scene *scene, const struct world_raster *raster)
{
	char told[120];
	for (int i = 0; i < scene->soil_count; i++) {
		struct soil_numbers soil = scene->soils[i];
		soil.thickness = raster->low;
		if (soil.over != NULL)
			allow(vehicle, scene, &soil, soil.elastic_stiffness);
	}
	snprintf(told, sizeof told, "; soil.rasters.%s has at least %g %s", raster->key, raster->low, raster->unit);
	return check(vehicle, scene, told);
}

enum status vehicle_check_rasters(struct vehicles *vehicles, const struct world *world)
{
	const struct scene *scene = world_scene(world);
	const size_t all = vehicles != NULL ? vehicles->all : 0;
	for (int i = 0; world_resident(world)->soil_rasters != NULL && i < scene->raster_count; i++) {
		const struct world_raster raster = world_raster(world, i);
		for (size_t v = 0; v < all && scene->rasters[i].number == SOIL_ELASTIC_STIFFNESS; v++)
			TRY(check_raster(&vehicles->list[v], scene, &raster));
		for (size_t v = 0; v < all && scene->rasters[i].number == SOIL_THICKNESS; v++)
			TRY(check_thickness(&vehicles->list[v], scene, &raster));
	}
	return STATUS_OK;
}
