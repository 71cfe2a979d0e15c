/* A soil by itself: from a name or YAML to its numbers, back to YAML, and with other numbers. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "deform/deform.h"
#include "scene/scene.h"

static bool in_braces(const char *text)
{
	return text[strspn(text, " ")] == '{';
}

enum status scene_soil_alone(const char *soil, struct scene **out)
{
	const size_t room = strlen(soil) + 64;
	char *text = mem_alloc(room, 1);
	TRY_MEM(text, "a soil");
	snprintf(text, room, in_braces(soil) ? "{soil: %s, redistribute: {model: scm}}" : "{soil: {name: %s}, redistribute: {model: scm}}", soil);
	enum status status = scene_load_text(text, NULL, NULL, 0, SCENE_HOST, out);
	mem_free(text);
	if (status != STATUS_INPUT)
		return status;
	char why[512];
	snprintf(why, sizeof why, "%s", scene_text_reason(failure_message()));
	return fail_with(status, "soil %s: %.400s", soil, why);
}

#define HARD "name: rock" /* hard ground yields to nothing, which no number of a scene says */

/* Writes the numbers that the model reads, each after a comma or, the first one, after `comma`. */
static int put_numbers(FILE *stream, const struct soil_numbers *soil, enum deform_model model, const char *comma)
{
	const char *key;
	double value;
	const bool hard = soil_is_hard(soil);
	int failed = hard ? fprintf(stream, "%s%s", comma, HARD) < 0 : 0;
	comma = hard ? ", " : comma;
	for (size_t i = 0; scene_soil_number(soil, i, &key, &value); i++) {
		if (isnan(value) || !deform_model_reads(model, key) || (hard && (strcmp(key, "bekker_kphi") == 0 || strcmp(key, "repose") == 0)))
			continue;
		failed |= fprintf(stream, "%s%s: %.17g", comma, key, value) < 0;
		comma = ", ";
	}
	return failed;
}

char *scene_soil_text(const struct soil_numbers *soil, enum deform_model model)
{
	char *text = NULL, *made = NULL;
	size_t length;
	FILE *stream = open_memstream(&text, &length);
	if (stream == NULL) {
		(void)fail_memory("a soil");
		return NULL;
	}
	int failed = fputc('{', stream) < 0;
	failed |= put_numbers(stream, soil, model, "");
	if (soil->over != NULL && soil_is_rigid(soil->over))
		failed |= fprintf(stream, ", thickness: %.17g, over: %s", soil->thickness, SCENE_RIGID) < 0;
	else if (soil->over != NULL) {
		failed |= fprintf(stream, ", thickness: %.17g, over: {", soil->thickness) < 0;
		failed |= put_numbers(stream, soil->over, model, "");
		failed |= fputc('}', stream) < 0;
	}
	failed |= fputc('}', stream) < 0;
	failed |= fclose(stream) != 0;
	if (!failed)
		made = mem_strdup(text);
	free(text);
	if (made == NULL)
		(void)fail_memory("a soil");
	return made;
}

char *scene_soil_varied(const char *soil, const double factor[3])
{
	struct scene *scene;
	if (scene_soil_alone(soil, &scene) != STATUS_OK)
		return NULL;
	struct soil_numbers varied = scene->soils[0];
	const enum deform_model model = scene->model;
	varied.cohesion *= factor[0];
	varied.friction_angle = atan(tan(varied.friction_angle) * factor[1]);
	varied.bekker_kc *= factor[2];
	varied.bekker_kphi *= factor[2];
	char *text = scene_soil_text(&varied, model); /* it reads what the soil lies over, which is the scene's */
	scene_destroy(scene);
	return text;
}
