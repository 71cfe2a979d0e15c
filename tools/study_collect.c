/* What a study collects: python/furrow/studies.py reads it from the runs, and writes study.csv and the plots. It gets the text of study.json. */
#include <math.h>

#include "base/json.h"
#include "python.h"
#include "study.h"

/* Asks Python to do something with the study. */
static enum status ask_python(const struct study *study, const char *what, const char *run, FILE *output, bool *missing)
{
	char *text = study_manifest_text(study);
	TRY_MEM(text, "study.json");
	const enum status status = python_ask("studies", (const char *const[]){what, study->directory, run, NULL}, text, output, missing);
	cJSON_free(text);
	return status;
}

/* Without Python nothing is collected, and the study's end says so. */
enum status study_check_run(struct study *study, size_t run)
{
	char number[24];
	bool missing;
	if (study->result_count == 0)
		return STATUS_OK;
	snprintf(number, sizeof number, "%zu", run + 1);
	const enum status status = ask_python(study, "check", number, NULL, &missing);
	return missing ? STATUS_OK : status;
}

enum status study_collect(struct study *study)
{
	bool missing;
	return ask_python(study, "collect", NULL, stdout, &missing);
}

/* --- what study.json says of it --- */

void study_add_results(const struct study *study, struct cJSON *json)
{
	static const char *const sources[] = {"run", "objects", "vehicles"}, *const takes[] = {"mean", "max", "min", "last"};
	cJSON *parameters = cJSON_AddArrayToObject(json, "parameters"), *results = cJSON_AddArrayToObject(json, "results");
	cJSON *plots = cJSON_AddArrayToObject(json, "plots");
	for (const struct study_parameter *p = study->parameters; p < study->parameters + study->parameter_count; p++) {
		cJSON *one = cJSON_CreateObject();
		cJSON_AddItemToArray(parameters, one);
		cJSON_AddStringToObject(one, "name", p->name);
		cJSON_AddStringToObject(one, "scale", p->logarithmic ? "log" : "linear");
		cJSON_AddBoolToObject(one, "range", p->values == NULL);
	}
	for (const struct study_result *result = study->results; result < study->results + study->result_count; result++) {
		char path[160], at[400];
		cJSON *one = cJSON_CreateObject();
		cJSON_AddItemToArray(results, one);
		cJSON_AddStringToObject(one, "name", result->name);
		cJSON_AddStringToObject(one, sources[result->source], result->what);
		if (result->source != STUDY_RUN_JSON) {
			cJSON_AddStringToObject(one, "of", result->of);
			cJSON_AddStringToObject(one, "take", takes[result->take]);
			json_number(one, "after", result->after);
		}
		scene_node_path(result->node, false, path, sizeof path);
		snprintf(at, sizeof at, "%.200s:%d:%d: %s", study->file, result->node->place.line, result->node->place.column, path);
		cJSON_AddStringToObject(one, "at", at);
	}
	for (const struct study_plot *plot = study->plots; plot < study->plots + study->plot_count; plot++) {
		cJSON *one = cJSON_CreateObject();
		cJSON_AddItemToArray(plots, one);
		cJSON_AddStringToObject(one, "x", study->parameters[plot->x].name);
		cJSON_AddStringToObject(one, "y", study->results[plot->y].name);
		if (plot->by != SIZE_MAX)
			cJSON_AddStringToObject(one, "by", study->parameters[plot->by].name);
	}
}
