/* Mean, maximum, minimum and last value of columns of objects.csv and vehicles.csv, by object. A
 * file is read once for all results. */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/scene_error.h"
#include "study.h"

#define COLUMNS_MOST 1024
#define TIME_COLUMN 0
#define NAME_COLUMN 1

struct figure {
	size_t column;
	double sum, max, min, last;
	uint64_t count;
};

/* Cuts a line at its commas. Returns the number of cells. */
static size_t cut(char *line, char **cells)
{
	size_t count = 0;
	line[strcspn(line, "\r\n")] = '\0';
	for (char *at = line; at != NULL && count < COLUMNS_MOST;) {
		cells[count++] = at;
		at = strchr(at, ',');
		if (at != NULL)
			*at++ = '\0';
	}
	return count;
}

static enum status find_column(const struct study *study, const struct study_result *result, char **cells, size_t count,
			       size_t *column)
{
	struct scene_list list = {.length = 0};
	for (size_t i = 0; i < count; i++) {
		if (strcmp(cells[i], result->what) == 0) {
			*column = i;
			return STATUS_OK;
		}
		if (i != NAME_COLUMN)
			scene_list_add(&list, cells[i]);
	}
	return scene_error(study->file, result->node, "%s is no column; allowed: %s", result->what, list.text);
}

static enum status take_row(const struct study *study, const struct study_result *result, char **cells, size_t count,
			    struct figure *figure)
{
	double time, value;
	if (count <= figure->column || !parse_number(cells[TIME_COLUMN], &time) || time < result->after ||
	    cells[figure->column][0] == '\0')
		return STATUS_OK;
	if (!parse_number(cells[figure->column], &value))
		return scene_error(study->file, result->node, "column %s has %s; allowed: a column of numbers", result->what,
				   scene_quote(cells[figure->column]).text);
	figure->sum += value;
	figure->max = fmax(figure->max, value);
	figure->min = fmin(figure->min, value);
	figure->last = value;
	figure->count++;
	return STATUS_OK;
}

static enum status read_rows(const struct study *study, enum study_source source, FILE *file, struct figure *figures)
{
	char *line = NULL, *cells[COLUMNS_MOST];
	size_t size = 0;
	enum status status = STATUS_OK;
	for (uint64_t number = 0; getline(&line, &size, file) >= 0; number++) {
		const size_t count = cut(line, cells);
		for (size_t i = 0; i < study->result_count; i++) {
			const struct study_result *result = &study->results[i];
			if (result->source != source)
				continue;
			if (number == 0)
				TRY_OR(done, find_column(study, result, cells, count, &figures[i].column));
			else if (count > NAME_COLUMN && strcmp(cells[NAME_COLUMN], result->of) == 0)
				TRY_OR(done, take_row(study, result, cells, count, &figures[i]));
		}
	}
done:
	free(line);
	return status;
}

/* To 12 digits: the rows have 9. */
static enum status give_mean(const struct figure *figure, struct study_cell *cell)
{
	char text[40];
	snprintf(text, sizeof text, "%.12g", figure->sum / (double)figure->count);
	return study_cell_number(cell, strtod(text, NULL));
}

static enum status give(const struct study *study, size_t run, const struct study_result *result, const struct figure *figure,
			struct study_cell *cell)
{
	if (figure->count == 0) {
		note("run %s has no row of %s for %s: its cell is empty", study->runs[run].name, result->of, result->name);
		return STATUS_OK;
	}
	switch (result->take) {
	case STUDY_MEAN:
		return give_mean(figure, cell);
	case STUDY_MAX:
		return study_cell_number(cell, figure->max);
	case STUDY_MIN:
		return study_cell_number(cell, figure->min);
	default:
		return study_cell_number(cell, figure->last);
	}
}

static enum status read_file(const struct study *study, size_t run, enum study_source source, struct figure *figures)
{
	static const char *const names[] = {[STUDY_OBJECTS] = "objects", [STUDY_VEHICLES] = "vehicles"};
	char name[20], path[PATH_MAX];
	const struct study_result *wanted = NULL;
	for (size_t i = 0; i < study->result_count; i++)
		if (study->results[i].source == source)
			wanted = &study->results[i];
	if (wanted == NULL)
		return STATUS_OK;
	snprintf(name, sizeof name, "%s.csv", names[source]);
	FILE *file = input_open(study_path(study, run, name, path));
	if (file == NULL)
		return scene_error(study->file, wanted->node, "%s: %s; allowed: with output.%s in the scene", path, input_problem(),
				   source == STUDY_OBJECTS ? "forces" : "vehicles");
	enum status status;
	TRY_OR(done, read_rows(study, source, file, figures));
	if (ferror(file))
		TRY_OR(done, fail_with(STATUS_FAILED, "%s: cannot be read; check the disk", path));
done:
	fclose(file);
	return status;
}

enum status study_columns(const struct study *study, size_t run, struct study_cell *cells)
{
	struct figure figures[STUDY_RESULTS];
	for (size_t i = 0; i < study->result_count; i++)
		figures[i] = (struct figure){.column = SIZE_MAX, .max = -INFINITY, .min = INFINITY};
	TRY(read_file(study, run, STUDY_OBJECTS, figures));
	TRY(read_file(study, run, STUDY_VEHICLES, figures));
	for (size_t i = 0; i < study->result_count; i++)
		if (study->results[i].source != STUDY_RUN_JSON)
			TRY(give(study, run, &study->results[i], &figures[i], &cells[i]));
	return STATUS_OK;
}
