/* study.csv: a row for each run, with its values and its results; and the plots. */
#include <ctype.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/aside.h"
#include "base/json.h"
#include "scene/scene_error.h"
#include "study.h"

enum status study_cell_number(struct study_cell *cell, double number)
{
	char text[40];
	snprintf(text, sizeof text, "%.15g", number);
	if (strtod(text, NULL) != number)
		snprintf(text, sizeof text, "%.17g", number);
	cell->number = number;
	return mem_text(&cell->text, text, "results of the study");
}

/* Finds what a dotted path means. Keys may have dots themselves. *deepest: what the path leads to
 * before it is lost. */
static const cJSON *find(const cJSON *at, const char *path, const cJSON **deepest)
{
	if (path[0] == '\0')
		return at;
	*deepest = at;
	const cJSON *child;
	size_t index = 0;
	cJSON_ArrayForEach(child, at)
	{
		char number[24];
		snprintf(number, sizeof number, "%zu", index++);
		const char *key = cJSON_IsArray(at) ? number : child->string;
		const size_t length = key != NULL ? strlen(key) : 0;
		if (length == 0 || strncmp(path, key, length) != 0 || (path[length] != '.' && path[length] != '\0'))
			continue;
		const cJSON *found = find(child, path + length + (path[length] == '.'), deepest);
		if (found != NULL)
			return found;
	}
	return NULL;
}

static struct scene_list keys_of(const cJSON *at)
{
	struct scene_list list = {.length = 0};
	const cJSON *child;
	cJSON_ArrayForEach(child, at) if (child->string != NULL) scene_list_add(&list, child->string);
	return list;
}

static enum status take_from_json(const struct study *study, const struct study_result *result, const cJSON *json,
				  struct study_cell *cell)
{
	const cJSON *deepest = json, *found = find(json, result->what, &deepest);
	if (found == NULL && cJSON_IsNull(deepest)) /* a run that has none of it */
		return STATUS_OK;
	if (found == NULL || cJSON_IsObject(found) || cJSON_IsArray(found)) {
		struct scene_list list = keys_of(found != NULL ? found : deepest);
		return scene_error(study->file, result->node, "%s %s run.json; allowed: %s", result->what,
				   found != NULL ? "is no single value of" : "is not in",
				   list.length > 0 ? list.text : "a path to one value");
	}
	if (cJSON_IsNumber(found))
		return study_cell_number(cell, found->valuedouble);
	const char *text = cJSON_IsString(found) ? found->valuestring
			   : cJSON_IsBool(found) ? (cJSON_IsTrue(found) ? "true" : "false")
						 : NULL;
	if (text != NULL && (cell->text = mem_strdup(text)) == NULL)
		return fail_memory("results of the study");
	return STATUS_OK;
}

static enum status take_run(struct study *study, size_t run, struct study_cell *cells)
{
	cJSON *json = study_run_json(study, run);
	enum status status = STATUS_OK;
	if (json == NULL)
		return fail_with(STATUS_FAILED, "runs/%s/run.json: cannot be read; run the study again", study->runs[run].name);
	for (size_t i = 0; i < study->result_count; i++)
		if (study->results[i].source == STUDY_RUN_JSON)
			TRY_OR(done, take_from_json(study, &study->results[i], json, &cells[i]));
done:
	cJSON_Delete(json);
	TRY(status);
	return study_columns(study, run, cells);
}

/* --- what is written --- */

static void write_cell(const char *text, FILE *file)
{
	if (strpbrk(text, ",\"\n\r") == NULL) {
		fputs(text, file);
		return;
	}
	fputc('"', file);
	for (const char *c = text; *c != '\0'; c++)
		fprintf(file, "%s%c", *c == '"' ? "\"" : "", *c);
	fputc('"', file);
}

static void write_rows(const struct study *study, const struct study_cell *cells, FILE *file)
{
	fputs("run,folder,state", file);
	for (size_t i = 0; i < study->parameter_count; i++) {
		fputc(',', file);
		write_cell(study->parameters[i].name, file);
	}
	for (size_t i = 0; i < study->result_count; i++) {
		fputc(',', file);
		write_cell(study->results[i].name, file);
	}
	fputc('\n', file);
	for (size_t run = 0; run < study->run_count; run++) {
		fprintf(file, "%zu,%s,%s", run + 1, study->runs[run].name, study_state_name(study->runs[run].state));
		for (size_t i = 0; i < study->parameter_count; i++) {
			fputc(',', file);
			write_cell(study_value(study, run, i), file);
		}
		for (size_t i = 0; i < study->result_count; i++) {
			const char *text = cells[run * study->result_count + i].text;
			fputc(',', file);
			write_cell(text != NULL ? text : "", file);
		}
		fputc('\n', file);
	}
}

/* DIR/RESULT-over-X-by-Y.svg */
static void plot_path(const struct study *study, const struct study_plot *plot, char *path)
{
	char name[150];
	const char *y = study->results[plot->y].name, *x = study->parameters[plot->x].name;
	if (plot->by != SIZE_MAX)
		snprintf(name, sizeof name, "%.40s-over-%.40s-by-%.40s", y, x, study->parameters[plot->by].name);
	else
		snprintf(name, sizeof name, "%.40s-over-%.40s", y, x);
	for (char *c = name; *c != '\0'; c++)
		if (!isalnum((unsigned char)*c) && strchr("._-", *c) == NULL)
			*c = '_';
	snprintf(path, PATH_MAX, "%.3900s/%s.svg", study->directory, name);
}

static enum status write_csv(const struct study *study, const struct study_cell *cells)
{
	char path[PATH_MAX];
	struct aside aside = {.path = NULL};
	snprintf(path, sizeof path, "%.4000s/study.csv", study->directory);
	enum status status;
	TRY_OR(done, aside_begin(&aside, path));
	write_rows(study, cells, aside.file);
done:
	return aside_end(&aside, true, status);
}

static enum status write_plot(const struct study *study, const struct study_plot *plot, const struct study_cell *cells)
{
	char path[PATH_MAX];
	struct aside aside = {.path = NULL};
	plot_path(study, plot, path);
	enum status status;
	TRY_OR(done, aside_begin(&aside, path));
	TRY_OR(done, study_plot_write(study, plot, cells, aside.file));
done:
	return aside_end(&aside, false, status);
}

enum status study_check_run(struct study *study, size_t run)
{
	struct study_cell cells[STUDY_RESULTS] = {{.text = NULL}};
	enum status status = take_run(study, run, cells);
	for (size_t i = 0; i < study->result_count; i++)
		mem_free(cells[i].text);
	return status;
}

enum status study_collect(struct study *study)
{
	const size_t count = study->run_count * study->result_count;
	struct study_cell *cells = mem_calloc(count, sizeof *cells);
	TRY_MEM(cells, "results of the study");
	for (size_t i = 0; i < count; i++)
		cells[i].number = NAN;
	enum status status;
	for (size_t run = 0; run < study->run_count; run++)
		if (study->runs[run].state == STUDY_COMPLETE && study->result_count > 0)
			TRY_OR(done, take_run(study, run, &cells[run * study->result_count]));
	TRY_OR(done, write_csv(study, cells));
	for (size_t i = 0; i < study->plot_count; i++)
		TRY_OR(done, write_plot(study, &study->plots[i], cells));
done:
	for (size_t i = 0; i < count; i++)
		mem_free(cells[i].text);
	mem_free(cells);
	return status;
}
