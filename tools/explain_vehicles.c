/* furrow explain: the numbers of each soil, and the soil geoms and actuators of each vehicle, with where each number and control comes from. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "explain.h"
#include "explain_layout.h"

/* Prints what was written to the stream, and frees it. */
static void print_wrapped(FILE *stream, char **text)
{
	if (fclose(stream) == 0)
		layout_wrapped(*text, 4);
	free(*text);
}

/* --- soils --- */

const char *explain_number_from(const struct scene *scene, int soil, const char *key)
{
	const bool guess = strcmp(key, "elastic_stiffness") == 0 || strcmp(key, "damping") == 0; /* all named soils have one number */
	/* A weight that comes of density and gravity, or a density of a weight. */
	const bool density = scene_soil_given(scene, soil, "density"), weight = scene_soil_given(scene, soil, "unit_weight");
	const bool follows = (strcmp(key, "unit_weight") == 0 && (density || scene->gravity_given)) || (strcmp(key, "density") == 0 && weight);
	if (scene_soil_given(scene, soil, key))
		return "scene";
	return guess || follows || strncmp(scene->soil_names[soil], "unnamed", 7) == 0 ? "default" : "name";
}

bool explain_number(const struct scene *scene, int soil, size_t index, const char **key, double *value)
{
	if (!scene_soil_number(&scene->soils[soil], index, key, value))
		return false;
	if (!deform_model_reads(scene->model, *key))
		*value = NAN;
	return true;
}

static void add_numbers(FILE *stream, const struct scene *scene, int soil, const char *from, const char *title)
{
	const char *key;
	double value;
	bool any = false;
	for (size_t i = 0; explain_number(scene, soil, i, &key, &value); i++) {
		char path[64];
		struct scene_parameter parameter = {.unit = NULL};
		if (isnan(value) || strcmp(explain_number_from(scene, soil, key), from) != 0)
			continue;
		snprintf(path, sizeof path, "soil.%s", key);
		(void)scene_parameter(path, &parameter);
		fprintf(stream, "%s %s %.9g%s%s", any ? "," : title, key, value, parameter.unit != NULL ? " " : "", parameter.unit != NULL ? parameter.unit : "");
		any = true;
	}
	if (any)
		fputc(';', stream);
}

/* The numbers of what the soil lies over. */
static void add_below(FILE *stream, const struct scene *scene, int soil)
{
	const struct soil_numbers *over = scene->soils[soil].over;
	const char *key;
	double value;
	bool any = false;
	for (size_t i = 0; over != NULL && !soil_is_rigid(over) && scene_soil_number(over, i, &key, &value); i++) {
		if (isnan(value) || !deform_model_reads(scene->model, key))
			continue;
		fprintf(stream, "%s %s %.9g", any ? "," : " below", key, value);
		any = true;
	}
	if (any)
		fputc(';', stream);
}

static bool same_layer(const struct scene *scene, int a, int b)
{
	const struct soil_numbers *one = &scene->soils[a], *other = &scene->soils[b];
	if (one->over == NULL || other->over == NULL)
		return one->over == other->over;
	return one->thickness == other->thickness && strcmp(scene->base_names[a], scene->base_names[b]) == 0;
}

/* Tells whether explain prints the same of both. */
static bool same_soil(const struct scene *scene, int a, int b)
{
	const char *key;
	double one, other;
	if (strcmp(scene->soil_names[a], scene->soil_names[b]) != 0 || !same_layer(scene, a, b))
		return false;
	for (size_t i = 0; explain_number(scene, a, i, &key, &one); i++) {
		explain_number(scene, b, i, &key, &other);
		if ((one != other && !(isnan(one) && isnan(other))) || strcmp(explain_number_from(scene, a, key), explain_number_from(scene, b, key)) != 0)
			return false;
	}
	return true;
}

/* Writes which classes of the map and whether roads or rocks have this soil, and along what share of the paths they lie. */
static void add_classes(FILE *stream, const struct scene *scene, const struct report_plan *plan, int soil)
{
	double share = 0;
	bool any = false;
	if (!scene_has_classes(scene))
		return;
	for (int i = 1; i <= scene->soil_count; i++) { /* the default, which is the first, comes last */
		const int other = i % scene->soil_count;
		if (!same_soil(scene, soil, other))
			continue;
		if (other == 0)
			fprintf(stream, "%s%s", any ? " and " : " (", scene->soil_map != NULL ? "default" : scene->road_count > 0 ? "off the roads" : "off the rocks");
		else if (scene_soil_value(scene, other) < 0)
			fprintf(stream, "%s%s", any ? ", " : " (", other == scene->rocks_soil ? "rocks" : "roads");
		else
			fprintf(stream, "%s%d", any ? ", " : " (class ", scene_soil_value(scene, other));
		share += plan->soils[other];
		any = true;
	}
	if (plan->soils_known)
		fprintf(stream, "; %.3g %% of the paths", 100 * share);
	fputc(')', stream);
}

static void print_soil(const struct scene *scene, const struct report_plan *plan, int soil)
{
	for (int i = 0; i < soil; i++)
		if (same_soil(scene, i, soil))
			return;
	char *text = NULL;
	size_t size = 0;
	FILE *stream = open_memstream(&text, &size);
	if (stream == NULL)
		return;
	fprintf(stream, "%s", scene->soil_names[soil]);
	if (scene->soils[soil].over != NULL)
		fprintf(stream, ", %.9g m over %s", scene->soils[soil].thickness, scene->base_names[soil]);
	add_classes(stream, scene, plan, soil);
	fputc(':', stream);
	add_numbers(stream, scene, soil, "scene", " the scene's");
	add_numbers(stream, scene, soil, "name", " the name's");
	add_numbers(stream, scene, soil, "default", " defaults");
	add_below(stream, scene, soil);
	fseek(stream, -1, SEEK_CUR);
	fputc('\0', stream);
	print_wrapped(stream, &text);
}

void explain_soils_text(const struct scene *scene, const struct report_plan *plan)
{
	if (deform_model_row(scene->model)->numbers == NULL)
		return;
	puts("\nsoil");
	for (int i = 0; i < scene->soil_count; i++)
		print_soil(scene, plan, i);
	if (scene->soil_map != NULL && plan->soils_known && plan->unmapped > 0)
		printf("  soil.map has no value along %.3g %% of the paths: the default soil is there\n", 100 * plan->unmapped);
}

/* --- vehicles --- */

void explain_geom(const struct soil_shape *shape, char *text, size_t size)
{
	const double *s = shape->size;
	switch (shape->kind) {
	case SOIL_WHEEL:
		if (shape->tyre.stiffness > 0)
			snprintf(text, size, "wheel, radius %.4g m, width %.4g m, a tyre that its load presses by %.3g m on rigid ground", shape->radius, shape->width, shape->tyre.deflection);
		else
			snprintf(text, size, "wheel, radius %.4g m, width %.4g m", shape->radius, shape->width);
		return;
	case SOIL_SPHERE:
		snprintf(text, size, "sphere, radius %.4g m", shape->radius);
		return;
	case SOIL_BOX:
		snprintf(text, size, "box%s, %.4g x %.4g x %.4g m", shape->belt ? " with a belt" : "", s[0], s[1], s[2]);
		return;
	case SOIL_CYLINDER:
	case SOIL_CAPSULE:
		snprintf(text, size, "%s, radius %.4g m, length %.4g m", shape->kind == SOIL_CYLINDER ? "cylinder" : "capsule", shape->radius, shape->length);
		return;
	case SOIL_ELLIPSOID:
		snprintf(text, size, "ellipsoid, half axes %.4g, %.4g, %.4g m", s[0], s[1], s[2]);
		return;
	default:
		snprintf(text, size, "mesh of %u triangles", shape->mesh->triangle_count);
	}
}

/* Writes the names of all soil geoms that have the shape of geom `first`. Writes nothing if an earlier geom has that shape: these names are written
 * already. */
static void add_geoms(FILE *stream, const struct report_plan *plan, size_t vehicle, size_t first, size_t count)
{
	char shape[160], other[160];
	struct vehicle_geom geom;
	bool any = false;
	vehicle_geom(plan->vehicles, vehicle, first, plan->spacing, &geom);
	explain_geom(geom.shape, shape, sizeof shape);
	for (size_t i = 0; i < count; i++) {
		vehicle_geom(plan->vehicles, vehicle, i, plan->spacing, &geom);
		explain_geom(geom.shape, other, sizeof other);
		if (strcmp(shape, other) != 0)
			continue;
		if (i < first)
			return;
		fprintf(stream, "%s %s", any ? "," : first > 0 ? ";" : "", geom.name);
		any = true;
	}
	fprintf(stream, " (%s)", shape);
}

/* Writes what each geom bears on level ground: N, and its share of the weight. Returns false if that is not known. */
static bool add_loads(FILE *stream, const struct report_plan *plan, size_t vehicle, const struct vehicle_info *info)
{
	struct vehicle_geom geom;
	for (size_t i = 0; i < info->geom_count; i++) {
		vehicle_geom(plan->vehicles, vehicle, i, plan->spacing, &geom);
		if (isnan(geom.share))
			return false;
		fprintf(stream, "%s %s %.4g N (%.1f %%)", i > 0 ? "," : "", geom.name, geom.share * info->mass * info->gravity, 100 * geom.share);
	}
	return true;
}

static void add_actuators(FILE *stream, const struct report_plan *plan, size_t vehicle, size_t count, const char *key, const char *title)
{
	bool any = false;
	for (size_t i = 0; i < count; i++) {
		const char *name = vehicle_actuator_name(plan->vehicles, vehicle, i), *by = vehicle_actuator_key(plan->vehicles, vehicle, i);
		if (by != key && (by == NULL || key == NULL || strcmp(by, key) != 0))
			continue;
		fprintf(stream, "%s %s", any ? "," : title, name[0] != '\0' ? name : "(without a name)");
		any = true;
	}
	if (any)
		fputc(';', stream);
}

static void print_vehicle(const struct report_plan *plan, size_t vehicle)
{
	static const char *const keys[] = {"steer", "drive", "controls", "hold"};
	struct vehicle_info info;
	char *text = NULL;
	size_t size = 0;
	vehicle_info(plan->vehicles, vehicle, &info);
	FILE *stream = open_memstream(&text, &size);
	if (stream != NULL) {
		fprintf(stream, "%s: %.6g kg, %zu soil geom%s, %zu actuator%s, %d engine step%s in a time step; time_step at most %s s (%s: %.3g kg on %.3g m2)",
			info.name, info.mass, info.geom_count, info.geom_count == 1 ? "" : "s", info.actuator_count, info.actuator_count == 1 ? "" : "s", info.engine_steps,
			info.engine_steps == 1 ? "" : "s", number_at_most(info.largest_step, 3).text,
			info.largest_geom, info.largest_mass, info.largest_area);
		print_wrapped(stream, &text);
	}
	stream = open_memstream(&text, &size);
	if (stream != NULL) {
		fputs("soil geoms:", stream);
		for (size_t i = 0; i < info.geom_count; i++)
			add_geoms(stream, plan, vehicle, i, info.geom_count);
		print_wrapped(stream, &text);
	}
	stream = open_memstream(&text, &size);
	if (stream != NULL) {
		fputs("load on level ground:", stream);
		if (!add_loads(stream, plan, vehicle, &info)) {
			rewind(stream);
			fputs("load on level ground: not known: the model does not stand in its first pose", stream);
		}
		print_wrapped(stream, &text);
	}
	stream = info.actuator_count > 0 ? open_memstream(&text, &size) : NULL;
	if (stream == NULL)
		return;
	fputs("actuators:", stream);
	for (size_t k = 0; k < sizeof keys / sizeof *keys; k++) {
		char title[40];
		snprintf(title, sizeof title, " driver.%s:", keys[k]);
		add_actuators(stream, plan, vehicle, info.actuator_count, keys[k], title);
	}
	add_actuators(stream, plan, vehicle, info.actuator_count, NULL, " no key, so 0:");
	fseek(stream, -1, SEEK_CUR);
	fputc('\0', stream);
	print_wrapped(stream, &text);
}

void explain_vehicles_text(const struct report_plan *plan)
{
	if (vehicle_count(plan->vehicles) > 0)
		puts("\nvehicles");
	for (size_t i = 0; i < vehicle_count(plan->vehicles); i++)
		print_vehicle(plan, i);
}
