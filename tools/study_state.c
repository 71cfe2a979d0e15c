/* How far the runs of a study are: run.json of each, and study.json of all. */
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/aside.h"
#include "base/json.h"
#include "scene/scene_file.h"
#include "study.h"

#define JSON_BYTES ((size_t)64 << 20)

static const char *const state_names[] = {"waiting", "begun", "interrupted", "failed", "complete"};

const char *study_state_name(enum study_state state)
{
	return state_names[state];
}

static cJSON *json_read(const char *path)
{
	char *text;
	size_t length;
	if (access(path, R_OK) != 0 || scene_file_read(path, path, JSON_BYTES, &text, &length) != STATUS_OK)
		return NULL;
	cJSON *json = cJSON_Parse(text);
	mem_free(text);
	return json;
}

void study_look(struct study *study, size_t index)
{
	struct study_run *run = &study->runs[index];
	char path[PATH_MAX];
	cJSON *json = json_read(study_path(study, index, "run.json", path));
	const char *ended = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(json, "ended"));
	const cJSON *seconds = cJSON_GetObjectItemCaseSensitive(json, "seconds");
	run->state = access(study_path(study, index, "log.txt", path), F_OK) == 0 ? STUDY_BEGUN : STUDY_WAITING;
	for (int i = STUDY_INTERRUPTED; i <= STUDY_COMPLETE && ended != NULL; i++)
		if (strcmp(ended, state_names[i]) == 0)
			run->state = (enum study_state)i;
	for (int i = 0; i < SCENE_STOPS && ended != NULL; i++) /* nothing is left to drive */
		if (strcmp(ended, scene_stop_name((enum scene_stop)i)) == 0)
			run->state = STUDY_COMPLETE;
	run->seconds = cJSON_IsNumber(seconds) ? seconds->valuedouble : 0;
	cJSON_Delete(json);
}

static void add_run(const struct study *study, size_t index, cJSON *list)
{
	const struct study_run *run = &study->runs[index];
	cJSON *row = cJSON_CreateObject();
	cJSON_AddItemToArray(list, row);
	json_integer(row, "number", (int64_t)index + 1);
	cJSON_AddStringToObject(row, "folder", run->name);
	cJSON_AddStringToObject(row, "state", state_names[run->state]);
	if (run->error != NULL)
		cJSON_AddStringToObject(row, "error", run->error);
	if (run->seconds > 0)
		json_number(row, "seconds", run->seconds);
	cJSON *values = cJSON_AddObjectToObject(row, "values");
	for (size_t i = 0; i < study->parameter_count; i++)
		cJSON_AddStringToObject(values, study->parameters[i].name, study_value(study, index, i));
}

char *study_manifest_text(const struct study *study)
{
	static const char *const designs[] = {"grid", "list", "hypercube"};
	const char *slash = strrchr(study->file, '/');
	char file[PATH_MAX];
	snprintf(file, sizeof file, "%.3000s%.1000s", study->folder, slash != NULL ? slash + 1 : study->file);
	cJSON *json = cJSON_CreateObject();
	json_integer(json, "study", 1);
	cJSON_AddStringToObject(json, "file", file);
	cJSON_AddStringToObject(json, "scene", study->scene);
	cJSON_AddStringToObject(json, "design", designs[study->design]);
	if (study->design == STUDY_HYPERCUBE)
		json_integer(json, "seed", (int64_t)study->seed);
	cJSON *states = cJSON_AddObjectToObject(json, "states");
	for (int i = STUDY_WAITING; i <= STUDY_COMPLETE; i++) {
		int64_t count = 0;
		for (size_t run = 0; run < study->run_count; run++)
			count += study->runs[run].state == (enum study_state)i;
		json_integer(states, state_names[i], count);
	}
	study_add_results(study, json);
	cJSON *list = cJSON_AddArrayToObject(json, "runs");
	for (size_t run = 0; run < study->run_count; run++)
		add_run(study, run, list);
	char *text = json_text(json);
	cJSON_Delete(json);
	return text;
}

enum status study_manifest(const struct study *study)
{
	char path[PATH_MAX];
	struct aside aside = {.path = NULL};
	char *text = study_manifest_text(study);
	TRY_MEM(text, "study.json");
	snprintf(path, sizeof path, "%.4000s/study.json", study->directory);
	enum status status;
	TRY_OR(done, aside_begin(&aside, path));
	fprintf(aside.file, "%s\n", text);
done:
	status = aside_end(&aside, true, status);
	cJSON_free(text);
	return status;
}

/* Gives the runs the names that study.json has for them. */
static enum status take_names(struct study *study, const cJSON *json, const char *told)
{
	const cJSON *runs = cJSON_GetObjectItemCaseSensitive(json, "runs"), *row;
	size_t index = 0;
	if (!cJSON_IsArray(runs) || (size_t)cJSON_GetArraySize(runs) != study->run_count)
		return fail_with(STATUS_INPUT, "%s: does not have the runs of study.yaml; run furrow study again", told);
	cJSON_ArrayForEach(row, runs)
	{
		const char *name = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(row, "folder"));
		if (name == NULL || strlen(name) >= sizeof study->runs->name || strspn(name, "0123456789abcdef-") != strlen(name) ||
		    name[0] == '\0')
			return fail_with(STATUS_INPUT, "%s: run %zu has no folder; run furrow study again", told, index + 1);
		snprintf(study->runs[index].name, sizeof study->runs->name, "%s", name);
		study_look(study, index++);
	}
	return STATUS_OK;
}

/* Reads the copy of the study that is in its folder. `file`: the path it was read from at first. */
static enum status read_copy(struct study *study, const char *directory, const char *file)
{
	const size_t room = strlen(directory) + sizeof "/study.yaml";
	char *copy = mem_alloc(room, 1);
	TRY_MEM(copy, "paths of the study");
	snprintf(copy, room, "%s/study.yaml", directory);
	enum status status = study_read(copy, file, study);
	const bool kept = study_keep(study, copy) != NULL;
	TRY(status);
	return kept ? STATUS_OK : fail_memory("paths of the study");
}

enum status study_reopen(struct study *study, const char *directory)
{
	char manifest[PATH_MAX];
	*study = (struct study){.file = NULL};
	snprintf(manifest, sizeof manifest, "%.4000s/study.json", directory);
	cJSON *json = json_read(manifest);
	const char *file = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(json, "file"));
	enum status status;
	if (file == NULL)
		TRY_OR(done, fail_with(STATUS_INPUT, "%s: is no study's; give the folder that furrow study was given with -o", directory));
	TRY_OR(done, read_copy(study, directory, file));
	if ((study->directory = realpath(directory, NULL)) == NULL)
		TRY_OR(done, fail_with(STATUS_FAILED, "%s: cannot be found; give a folder that can be read", directory));
	TRY_OR(done, take_names(study, json, manifest));
done:
	cJSON_Delete(json);
	return status;
}
