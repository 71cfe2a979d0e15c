/* Soils that differ from a named one, for a spread of its numbers. */
#include <math.h>

#include "trials/trials.h"

char *trials_soil_varied(const char *soil, const double factor[3])
{
	struct scene *scene;
	if (trials_soil_scene(soil, &scene) != STATUS_OK)
		return NULL;
	struct soil_numbers varied = scene->soils[0];
	const enum deform_model model = scene->model;
	scene_destroy(scene);
	varied.cohesion *= factor[0];
	varied.friction_angle = atan(tan(varied.friction_angle) * factor[1]);
	varied.bekker_kc *= factor[2];
	varied.bekker_kphi *= factor[2];
	return trials_soil_text(&varied, model);
}
