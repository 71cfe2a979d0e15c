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

static void write_part(FILE *stream, const struct scene_law_part *part)
{
	const bool bars = strcmp(part->part, "bars") == 0, under = bars || strcmp(part->part, "rim") == 0 || strcmp(part->part, "underside") == 0;
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

static void write_cost(FILE *stream, const struct scene_laws *laws)
{
	if (isnan(laws->posts))
		return;
	fprintf(stream, "; %.2g posts over its %s: its level force may be off by %s%d %%%s", laws->posts, laws->wheel ? "radius" : "depth",
		laws->beyond ? "more than " : "about ", laws->error, laws->wheel ? " of its load" : "");
	if (laws->finer > 0)
		fprintf(stream, ", at %g m by %d %%", laws->finer, laws->finer_error);
}

/* What is told of a body behind its name. NULL: no memory. Free it. */
static char *text_of(const struct scene_laws *laws)
{
	char *text = NULL;
	size_t size = 0;
	FILE *stream = open_memstream(&text, &size);
	if (stream == NULL)
		return NULL;
	if (laws->slides > 0)
		fprintf(stream, "slides %.2g of its way; ", laws->slides);
	for (size_t i = 0; i < laws->count; i++) {
		fputs(i > 0 ? "; " : "", stream);
		write_part(stream, &laws->parts[i]);
	}
	write_cost(stream, laws);
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

static void tell(void *user, const char *name, const struct scene_laws *laws)
{
	struct told *told = user;
	char *text = text_of(laws);
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
		puts("\nlaws");
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

typedef void (*laws_fn)(void *user, const char *name, const struct scene_laws *laws);

/* Calls `each` for each object and each soil geom of a vehicle that has laws. */
static void each_body(const struct scene *scene, const struct report_plan *plan, laws_fn each, void *user)
{
	struct scene_laws laws;
	for (size_t i = 0; i < scene->object_count; i++)
		if (scene_laws_of(scene, &scene->objects[i], plan->spacing, &laws))
			each(user, scene->objects[i].name, &laws);
	for (size_t v = 0; v < vehicle_count(plan->vehicles); v++) {
		struct vehicle_info info;
		vehicle_info(plan->vehicles, v, &info);
		for (size_t g = 0; g < info.geom_count; g++) {
			struct vehicle_geom geom;
			vehicle_geom(plan->vehicles, v, g, plan->spacing, &geom);
			if (scene_laws_of_shape(scene, geom.shape, plan->spacing, &laws))
				each(user, geom.name, &laws);
		}
	}
}

void explain_laws_text(const struct scene *scene, const struct report_plan *plan)
{
	struct told told = {.count = 0};
	each_body(scene, plan, tell, &told);
	print_told(&told);
}

/* --- JSON --- */

static void add(void *root, const char *name, const struct scene_laws *laws)
{
	cJSON *object = cJSON_AddObjectToObject(root, name), *parts = cJSON_AddArrayToObject(object, "parts");
	json_number(object, "slides", laws->slides);
	for (size_t i = 0; i < laws->count; i++) {
		cJSON *part = cJSON_CreateObject();
		cJSON_AddItemToArray(parts, part);
		cJSON_AddStringToObject(part, "part", laws->parts[i].part);
		json_number(part, "faces", laws->parts[i].faces);
	}
	if (isnan(laws->posts))
		return;
	json_number(object, laws->wheel ? "posts_over_radius" : "posts_over_depth", laws->posts);
	json_number(object, "error", laws->error / 100.0);
	cJSON_AddBoolToObject(object, "beyond", laws->beyond);
	if (laws->finer > 0) {
		cJSON *finer = cJSON_AddObjectToObject(object, "finer");
		json_number(finer, "spacing", laws->finer);
		json_number(finer, "error", laws->finer_error / 100.0);
	}
}

void explain_laws_json(cJSON *root, const struct scene *scene, const struct report_plan *plan)
{
	each_body(scene, plan, add, cJSON_AddObjectToObject(root, "laws"));
}
