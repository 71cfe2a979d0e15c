/*
 * What is checked before the first run of a study starts: that each run can begin, and that its results have what they are read from. Which values
 * of run.json and of vehicles.csv there are is known from the first run that is complete.
 */
#include <string.h>

#include "command.h"
#include "report/report.h"
#include "scene/scene_error.h"
#include "study.h"

/* "load: 400, soil: dry_sand" */
static void print_values(const struct study *study, size_t run, char *text, size_t size)
{
	size_t used = 0;
	text[0] = '\0';
	for (size_t i = 0; i < study->parameter_count && used < size; i++)
		used += (size_t)snprintf(text + used, size - used, "%s%.60s: %.80s", i > 0 ? ", " : "", study->parameters[i].name,
					 study_value(study, run, i));
}

void study_refuse(const struct study *study, struct study_refused *refused, size_t run)
{
	if (refused->count == 0)
		snprintf(refused->why, sizeof refused->why, "%s", failure_message());
	if (refused->count < STUDY_NAMED) {
		char values[240];
		print_values(study, run, values, sizeof values);
		snprintf(refused->named[refused->count], sizeof refused->named[0], "%zu (%s)", run + 1, values);
	}
	refused->count++;
}

enum status study_tell_refused(const struct study *study, const struct study_refused *refused)
{
	char named[STUDY_NAMED * sizeof refused->named[0] + 64];
	size_t used = 0;
	if (refused->count == 0)
		return STATUS_OK;
	if (refused->count == 1)
		return fail_with(STATUS_INPUT, "%s: run %s: %s", study->file, refused->named[0], refused->why);
	for (size_t i = 0; i < refused->count && i < STUDY_NAMED; i++)
		used += (size_t)snprintf(named + used, sizeof named - used, "%s%s", i > 0 ? ", " : "", refused->named[i]);
	if (refused->count > STUDY_NAMED)
		snprintf(named + used, sizeof named - used, " and %zu more", refused->count - STUDY_NAMED);
	return fail_with(STATUS_INPUT, "%s: %zu of %zu runs cannot begin: %s: of the first: %s", study->file, refused->count, study->run_count, named,
			 refused->why);
}

static bool has_object(const struct scene *scene, const char *name)
{
	for (size_t i = 0; i < scene->object_count; i++)
		if (strcmp(scene->objects[i].name, name) == 0)
			return true;
	return scene->vehicle_count > 0; /* rows are of its geoms, too */
}

static bool has_vehicle(const struct scene *scene, const char *name)
{
	for (size_t i = 0; i < scene->vehicle_count; i++)
		if (strcmp(scene->vehicles[i].name, name) == 0)
			return true;
	return false;
}

void study_seek_results(const struct study *study, const struct scene *scene, enum study_found *found)
{
	for (size_t i = 0; i < study->result_count; i++) {
		const struct study_result *result = &study->results[i];
		const bool objects = result->source == STUDY_OBJECTS;
		const bool name = result->source == STUDY_RUN_JSON || (objects ? has_object(scene, result->of) : has_vehicle(scene, result->of));
		const bool rows = result->source == STUDY_RUN_JSON || (objects ? scene->forces : scene->vehicle_rows) > 0;
		const enum study_found here = name && rows ? STUDY_ROWS : name ? STUDY_NAME : STUDY_NOTHING;
		found[i] = here > found[i] ? here : found[i];
	}
}

enum status study_check_sought(const struct study *study, const enum study_found *found)
{
	for (size_t i = 0; i < study->result_count; i++) {
		const struct study_result *result = &study->results[i];
		const bool objects = result->source == STUDY_OBJECTS;
		if (objects && !report_objects_column(result->what))
			return scene_error(study->file, result->node, "%s is no column; allowed: %s", result->what, report_objects_columns());
		if (found[i] == STUDY_NOTHING)
			return scene_error(study->file, result->node, "no run has %s among its %s; allowed: a name that the scene has", result->of,
					   objects ? "objects" : "vehicles");
		if (found[i] == STUDY_NAME)
			return scene_error(study->file, result->node, "no run writes such rows; allowed with: %s above 0, in the scene or under set",
					   objects ? "output.forces" : "output.vehicles");
	}
	return STATUS_OK;
}

static enum status check_run(struct study *study, size_t run)
{
	struct settings settings = {.count = 0};
	struct scene *scene = NULL;
	const char *store;
	enum status status;
	TRY_OR(done, study_settings(study, run, &settings, &store));
	TRY_OR(done, scene_load(study->scene, settings.list, settings.count, &scene));
	TRY_OR(done, report_check(scene, store));
done:
	scene_destroy(scene);
	return status;
}

enum status study_check_runs(struct study *study)
{
	struct study_refused refused = {.count = 0};
	struct progress progress;
	enum status status = STATUS_OK;
	progress_start(&progress, "study: checking", "runs");
	for (size_t run = 0; run < study->run_count; run++) {
		if (study->runs[run].state == STUDY_COMPLETE)
			continue;
		status = check_run(study, run);
		if (status == STATUS_INPUT)
			study_refuse(study, &refused, run);
		else
			TRY_OR(done, status);
		TRY_OR(done, progress_step(&progress, (int64_t)run + 1, (int64_t)study->run_count));
	}
done:
	progress_end(&progress);
	TRY(status);
	return study_tell_refused(study, &refused);
}
