/* What run.json says was run: version, scene, store, trace, and the notes on them. So a folder explains itself later. */
#include <stdio.h>
#include <stdlib.h>

#include "base/json.h"
#include "report/report.h"

#define GROUNDLESS_SHARE 0.01 /* of an object's path samples; more are told */

/* Adds a path that holds from any folder; null without one. As it was given, if the file is not there. */
static void add_path(cJSON *object, const char *name, const char *path)
{
	char *whole = path != NULL ? realpath(path, NULL) : NULL;
	json_string(object, name, whole != NULL ? whole : path);
	free(whole);
}

static void add_note(void *user, const char *text)
{
	cJSON *notes = user;
	cJSON *note = cJSON_CreateString(text);
	if (!cJSON_AddItemToArray(notes, note))
		cJSON_Delete(note);
}

void report_groundless(const struct world *world, scene_advice_fn tell, void *user)
{
	char text[440], count[60];
	for (size_t i = 0; world_params(world)->ranks == NULL && i < world_scene(world)->object_count; i++) {
		const struct body *body = world_body(world, i);
		const bool all = body->skipped == body->next;
		if (body->kind != BODY_PATH || (double)body->skipped <= GROUNDLESS_SHARE * (double)body->next)
			continue;
		if (all)
			snprintf(count, sizeof count, "all %lld", (long long)body->skipped);
		else
			snprintf(count, sizeof count, "%lld of %lld", (long long)body->skipped, (long long)body->next);
		snprintf(text, sizeof text, "objects.%.200s.path: %s path samples had no ground, so the object pressed nothing%s; lead the path over the "
					    "terrain, or fill its holes (furrow import --fill)", body->object->name, count, all ? "" : " there");
		tell(user, text);
	}
}

void report_asked(cJSON *root, const struct report *report)
{
	const struct world *world = report->world;
	const struct scene *scene = world_scene(world);
	char hash[20];
	cJSON_AddStringToObject(root, "version", FURROW_VERSION);
	cJSON *told = cJSON_AddObjectToObject(root, "scene");
	cJSON_AddStringToObject(told, "file", scene->file);
	cJSON_AddStringToObject(told, "hash", scene->hash);
	cJSON *values = cJSON_AddObjectToObject(told, "values");
	for (size_t i = 0; i < scene->value_count; i++)
		cJSON_AddStringToObject(values, scene->values[i].key, scene->values[i].text);
	cJSON *store = cJSON_AddObjectToObject(root, "store");
	add_path(store, "file", world_params(world)->ranks != NULL ? world_params(world)->ranks->over : world_facts(world)->path);
	add_path(store, "base", store_base_path(world_resident(world)->store));
	snprintf(hash, sizeof hash, "%016llx", (unsigned long long)store_base_hash(world_resident(world)->store));
	cJSON_AddStringToObject(store, "base_hash", hash);
	if (world_facts(world)->began.low < 0 || world_facts(world)->began.high > 0) {
		cJSON *began = cJSON_AddObjectToObject(store, "began_on");
		json_number(began, "deepest", -world_facts(world)->began.low);
		json_number(began, "highest", world_facts(world)->began.high);
	}
	if (store_copy_path(world_resident(world)->store) != NULL)
		add_path(store, "staged", store_copy_path(world_resident(world)->store));
	add_path(root, "trace", page_trace_path(world_resident(world)->trace));
	cJSON *notes = cJSON_AddArrayToObject(root, "notes");
	if (report->advised) {
		world_advise(world, add_note, notes);
		vehicle_advise(report->vehicles, world, add_note, notes);
		report_sun_advise(world, add_note, notes);
		report_pictures_advise(scene, world_step_count(world), add_note, notes);
		report_end_notes(report, add_note, notes);
	} else {
		scene_advise_units(scene, add_note, notes);
	}
}
