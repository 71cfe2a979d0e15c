/* Soils that differ from a named one, for a spread of its numbers. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mobility/mobility.h"

#define RADIANS (3.14159265358979323846 / 180)

static double varied(const char *key, double value, const double factor[3])
{
	if (strcmp(key, "cohesion") == 0)
		return value * factor[0];
	if (strcmp(key, "friction_angle") == 0)
		return atan(tan(value * RADIANS) * factor[1]) / RADIANS;
	if (strcmp(key, "bekker_kc") == 0 || strcmp(key, "bekker_kphi") == 0)
		return value * factor[2];
	return value;
}

char *mobility_soil_varied(const char *soil, const double factor[3])
{
	struct scene *scene;
	char *text = NULL, *made = NULL;
	size_t length;
	if (rig_soil_scene(soil, &scene) != STATUS_OK)
		return NULL;
	FILE *stream = open_memstream(&text, &length);
	const char *key, *comma = "";
	double value;
	for (size_t i = 0; stream != NULL && scene_soil_number(&scene->soils[0], i, &key, &value); i++) {
		if (isnan(value))
			continue;
		fprintf(stream, "%s%s: %.17g", *comma == '\0' ? "{" : comma, key, varied(key, value, factor));
		comma = ", ";
	}
	scene_destroy(scene);
	int failed = stream == NULL || fputs("}", stream) < 0;
	failed |= stream != NULL && fclose(stream) != 0;
	if (failed) {
		free(text);
		text = NULL;
	}
	if (text != NULL)
		made = mem_strdup(text);
	free(text);
	if (made == NULL)
		(void)fail_memory("a soil");
	return made;
}
