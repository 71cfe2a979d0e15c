/* furrow explain: by which law the soil presses on the parts of each body, and what the spacing costs where it slides. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "explain.h"
#include "explain_layout.h"
#include "json.h"

#define UNDER "Bekker and Janosi"
#define FACES "3D-RFT"
#define TOLD_MOST 8 /* kinds of bodies */

/* --- text --- */

static void write_part(FILE *stream, const struct scene_pressed_part *part)
{
	const bool under = strcmp(part->part, "rim") == 0 || strcmp(part->part, "underside") == 0;
	fprintf(stream, "%s: ", part->part);
	if (isnan(part->faces))
		fputs(under ? UNDER ", " FACES " where it slides" : FACES " where it slides", stream);
	else if (part->faces == 0)
		fputs(under ? UNDER : "nothing", stream);
	else if (part->faces == 1)
		fputs(FACES, stream);
	else
		fprintf(stream, "%.0f %% " UNDER ", %.0f %% " FACES, 100 * (1 - part->faces), 100 * part->faces);
}

static void write_cost(FILE *stream, const struct scene_pressed *pressed)
{
	if (isnan(pressed->posts))
		return;
	fprintf(stream, "; %.2g posts over its %s: its level force may be off by %s%d %%%s", pressed->posts, pressed->wheel ? "radius" : "depth",
		pressed->beyond ? "more than " : "about ", pressed->error, pressed->wheel ? " of its load" : "");
	if (pressed->finer > 0)
		fprintf(stream, ", at %g m by %d %%", pressed->finer, pressed->finer_error);
}

/* What is told of a body behind its name. NULL: no memory. Free it. */
static char *text_of(const struct scene_pressed *pressed)
{
	char *text = NULL;
	size_t size = 0;
	FILE *stream = open_memstream(&text, &size);
	if (stream == NULL)
		return NULL;
	if (pressed->slides > 0)
		fprintf(stream, "slides %.2g of its way; ", pressed->slides);
	for (size_t i = 0; i < pressed->count; i++) {
		fputs(i > 0 ? "; " : "", stream);
		write_part(stream, &pressed->parts[i]);
	}
	write_cost(stream, pressed);
	if (fclose(stream) == 0)
		return text;
	free(text);
	return NULL;
}

/* Bodies that are told the same are told of once. */
struct told {
	char *texts[TOLD_MOST];
	char names[TOLD_MOST][140];
	size_t others[TOLD_MOST], count, more;
};

static void tell(struct told *told, const char *name, const struct scene_pressed *pressed)
{
	char *text = text_of(pressed);
	if (text == NULL)
		return;
	for (size_t i = 0; i < told->count; i++)
		if (strcmp(told->texts[i], text) == 0) {
			told->others[i]++;
			free(text);
			return;
		}
	if (told->count == TOLD_MOST) {
		told->more++;
		free(text);
		return;
	}
	snprintf(told->names[told->count], sizeof told->names[0], "%s", name);
	told->texts[told->count++] = text;
}

static void print_told(struct told *told)
{
	if (told->count > 0)
		puts("\nwhat presses");
	for (size_t i = 0; i < told->count; i++) {
		char *line = NULL;
		size_t size = 0;
		FILE *stream = open_memstream(&line, &size);
		if (stream == NULL)
			continue;
		fprintf(stream, "%s", told->names[i]);
		if (told->others[i] > 0)
			fprintf(stream, " and %zu other%s", told->others[i], told->others[i] > 1 ? "s" : "");
		fprintf(stream, ": %s", told->texts[i]);
		if (fclose(stream) == 0)
			layout_wrapped(line, 4);
		free(line);
	}
	if (told->more > 0)
		printf("  and %zu more bodies: --json has them all\n", told->more);
	for (size_t i = 0; i < told->count; i++)
		free(told->texts[i]);
}

void explain_pressed_text(const struct scene *scene, const struct report_plan *plan)
{
	struct told told = {.count = 0};
	struct scene_pressed pressed;
	for (size_t i = 0; i < scene->object_count; i++)
		if (scene_pressed(scene, &scene->objects[i], plan->spacing, &pressed))
			tell(&told, scene->objects[i].name, &pressed);
	for (size_t v = 0; v < vehicle_count(plan->vehicles); v++) {
		struct vehicle_info info;
		vehicle_info(plan->vehicles, v, &info);
		for (size_t g = 0; g < info.geom_count; g++) {
			struct vehicle_geom geom;
			vehicle_geom(plan->vehicles, v, g, plan->spacing, &geom);
			if (scene_pressed_shape(scene, geom.shape, plan->spacing, &pressed))
				tell(&told, geom.name, &pressed);
		}
	}
	print_told(&told);
}

/* --- JSON --- */

static void add(cJSON *root, const char *name, const struct scene_pressed *pressed)
{
	cJSON *object = cJSON_AddObjectToObject(root, name), *parts = cJSON_AddArrayToObject(object, "parts");
	json_number(object, "slides", pressed->slides);
	for (size_t i = 0; i < pressed->count; i++) {
		cJSON *part = cJSON_CreateObject();
		cJSON_AddItemToArray(parts, part);
		cJSON_AddStringToObject(part, "part", pressed->parts[i].part);
		json_number(part, "faces", pressed->parts[i].faces);
	}
	if (isnan(pressed->posts))
		return;
	json_number(object, pressed->wheel ? "posts_over_radius" : "posts_over_depth", pressed->posts);
	json_number(object, "error", pressed->error / 100.0);
	cJSON_AddBoolToObject(object, "beyond", pressed->beyond);
	if (pressed->finer > 0) {
		cJSON *finer = cJSON_AddObjectToObject(object, "finer");
		json_number(finer, "spacing", pressed->finer);
		json_number(finer, "error", pressed->finer_error / 100.0);
	}
}

void explain_pressed_json(cJSON *root, const struct scene *scene, const struct report_plan *plan)
{
	struct scene_pressed pressed;
	cJSON *object = cJSON_AddObjectToObject(root, "pressed");
	for (size_t i = 0; i < scene->object_count; i++)
		if (scene_pressed(scene, &scene->objects[i], plan->spacing, &pressed))
			add(object, scene->objects[i].name, &pressed);
	for (size_t v = 0; v < vehicle_count(plan->vehicles); v++) {
		struct vehicle_info info;
		vehicle_info(plan->vehicles, v, &info);
		for (size_t g = 0; g < info.geom_count; g++) {
			struct vehicle_geom geom;
			vehicle_geom(plan->vehicles, v, g, plan->spacing, &geom);
			if (scene_pressed_shape(scene, geom.shape, plan->spacing, &pressed))
				add(object, geom.name, &pressed);
		}
	}
}
