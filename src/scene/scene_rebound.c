/*
 * Tells how much the soil's rebound decides where the scene does not give elastic_stiffness.
 *
 * Soil that springs back behind a wheel's axle pushes it from behind. So the wheel sinks less, and its resistance is less than in
 * Bekker's rigid-plastic soil. Under the axle the pressure is p = k z^n, so the soil springs back by e = p / K_e. The rim is taken as a
 * parabola. So the contact is sqrt(2 r z) long ahead of the axle, and sqrt(2 r e) behind it:
 *
 *     load       = b p ((3 - n) / 3 sqrt(2 r z) + 2/3 sqrt(2 r e))
 *     resistance = b p (z / (n + 1) - e / 2)
 *
 * The towed wheel of furrow rig is within 8 % of this (tests/cli/rig.py).
 */
#include <math.h>
#include <stdio.h>

#include "scene/scene_check.h"

#define HALVINGS 50

struct wheel {
	double k, n, stiffness; /* of the soil */
	double width, radius, load;
};

static double pressure_at(const struct wheel *wheel, double sinkage)
{
	return wheel->k * pow(sinkage, wheel->n);
}

static double rebound_at(const struct wheel *wheel, double sinkage)
{
	return fmin(pressure_at(wheel, sinkage) / wheel->stiffness, sinkage);
}

static double borne(const struct wheel *wheel, double sinkage)
{
	const double across = 2 * wheel->radius;
	return wheel->width * pressure_at(wheel, sinkage) *
	       (fmax(3 - wheel->n, 0.1) / 3 * sqrt(across * sinkage) + 2. / 3 * sqrt(across * rebound_at(wheel, sinkage)));
}

/* Returns how deep the wheel is, m; at most its radius. */
static double sinkage_of(const struct wheel *wheel)
{
	double low = 0, high = wheel->radius;
	for (int i = 0; i < HALVINGS; i++) {
		const double middle = (low + high) / 2;
		*(borne(wheel, middle) < wheel->load ? &low : &high) = middle;
	}
	return low;
}

static double resistance_of(const struct wheel *wheel, double sinkage)
{
	return wheel->width * pressure_at(wheel, sinkage) * (sinkage / (wheel->n + 1) - rebound_at(wheel, sinkage) / 2);
}

static void find(const struct soil_numbers *soil, const struct soil_shape *shape, double load, struct scene_rebound *out)
{
	struct wheel wheel = {.k = soil->bekker_kc / shape->width + soil->bekker_kphi, .n = soil->bekker_n, .stiffness = soil->elastic_stiffness,
			      .width = shape->width, .radius = shape->radius, .load = load};
	out->sinkage = sinkage_of(&wheel);
	out->rebound = rebound_at(&wheel, out->sinkage);
	const double springs = resistance_of(&wheel, out->sinkage);
	wheel.stiffness = INFINITY;
	out->less = 1 - springs / resistance_of(&wheel, sinkage_of(&wheel));
}

static bool is_given(const struct scene *scene, int soil)
{
	bool given = scene_soil_given(scene, soil, "elastic_stiffness");
	for (int i = 0; i < scene->raster_count; i++)
		given = given || scene->rasters[i].number == SOIL_ELASTIC_STIFFNESS;
	return given;
}

void scene_rebound_look(const struct scene *scene, const char *key, const struct soil_shape *shape, double load, struct scene_rebound *worst)
{
	if (shape->kind != SOIL_WHEEL || !(load > 0) || !deform_model_reads(scene->model, "elastic_stiffness"))
		return;
	for (int i = 0; i < scene->soil_count; i++) {
		struct scene_rebound found = {.soil = i};
		if (is_given(scene, i))
			continue;
		find(&scene->soils[i], shape, load, &found);
		if (!(found.less > worst->less))
			continue;
		*worst = found;
		snprintf(worst->key, sizeof worst->key, "%s", key);
	}
}

void scene_rebound_advise(const struct scene *scene, const struct scene_rebound *worst, scene_advice_fn tell, void *user)
{
	char text[500];
	if (!(worst->less >= SCENE_REBOUND_TOLD))
		return;
	snprintf(text, sizeof text,
		 "soil.elastic_stiffness: is not given, so it is %g Pa/m: below %s the soil springs back by about %.2g of %.2g mm, and pushes it from behind: "
		 "the resistance is about %.0f %% less than in soil that does not spring back; give that of your soil (docs/SOILS.md)",
		 scene->soils[worst->soil].elastic_stiffness, worst->key, worst->rebound * 1e3, worst->sinkage * 1e3, worst->less * 100);
	tell(user, text);
}

void scene_advise_rebound(const struct scene *scene, scene_advice_fn tell, void *user)
{
	struct scene_rebound worst = {.less = 0};
	if (scene->forces == 0)
		return;
	for (size_t i = 0; i < scene->object_count; i++) {
		char key[160];
		snprintf(key, sizeof key, "objects.%s", scene->objects[i].name);
		scene_rebound_look(scene, key, &scene->objects[i].shape, scene->objects[i].load, &worst);
	}
	scene_rebound_advise(scene, &worst, tell, user);
}
