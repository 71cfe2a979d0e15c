/* Reads what a study collects and plots. */
#include <math.h>
#include <string.h>

#include "scene/scene_error.h"
#include "study.h"

#define GROUPS_MOST 24 /* values across a plot that are no numbers; python/furrow/studies.py has them, too */
#define SERIES_MOST 8

/* Returns true if a parameter has values that are no numbers, and more different ones than `most`. */
static bool has_too_many(const struct study *study, size_t parameter, size_t most)
{
	const char *names[GROUPS_MOST];
	size_t count = 0;
	double number;
	bool text = false;
	for (size_t run = 0; run < study->run_count && !text; run++)
		text = !parse_number(study_value(study, run, parameter), &number);
	for (size_t run = 0; run < study->run_count && text; run++) {
		const char *name = study_value(study, run, parameter);
		size_t i = 0;
		while (i < count && strcmp(names[i], name) != 0)
			i++;
		if (i == count && count == most)
			return true;
		if (i == count)
			names[count++] = name;
	}
	return false;
}

enum status study_plot_check(const struct study *study, const struct study_plot *plot, const struct scene_node *node)
{
	if (has_too_many(study, plot->x, GROUPS_MOST))
		return scene_error(study->file, node, "has %s across, which has more than %d values that are no numbers; allowed: another parameter as x",
				   study->parameters[plot->x].name, GROUPS_MOST);
	if (plot->by != SIZE_MAX && has_too_many(study, plot->by, SERIES_MOST))
		return scene_error(study->file, node, "is by %s, which has more than %d values that are no numbers; allowed: another parameter as by, or none",
				   study->parameters[plot->by].name, SERIES_MOST);
	return STATUS_OK;
}

static enum status take_result(const struct study *study, const struct scene_node *node, struct study_result *result)
{
	static const char *const keys[] = {"run", "objects", "vehicles", "of", "take", "after", NULL};
	static const char *const takes[] = {"mean", "max", "min", "last", NULL};
	static const char *const sources[] = {"run", "objects", "vehicles"};
	int given = 0, take = -1;
	*result = (struct study_result){.name = node->key, .node = node, .after = -INFINITY};
	TRY(study_only(study, node, keys));
	for (int i = 0; i < 3; i++) {
		const char *what;
		TRY(study_text(study, node, sources[i], &what));
		if (what != NULL) {
			result->source = (enum study_source)i;
			result->what = what;
			given++;
		}
	}
	if (given != 1)
		return scene_error(study->file, node, "says not where it is; allowed: one of run, objects, vehicles");
	TRY(study_text(study, node, "of", &result->of));
	TRY(study_choice(study, node, "take", takes, &take));
	TRY(study_number(study, node, "after", 0, 1e12, &result->after));
	result->take = (enum study_take)(take >= 0 ? take : 0);
	if (result->source == STUDY_RUN_JSON && (result->of != NULL || take >= 0 || isfinite(result->after)))
		return scene_error(study->file, node,
				   "has keys of a column; allowed: `run` alone, or a column of "
				   "objects or vehicles");
	if (result->source != STUDY_RUN_JSON && (result->of == NULL || take < 0))
		return scene_error(study->file, node,
				   "is no column's figure; allowed: with `of` (a name) and `take` "
				   "(mean, max, min, last)");
	for (size_t i = 0; i < study->parameter_count; i++)
		if (strcmp(study->parameters[i].name, result->name) == 0)
			return scene_error(study->file, node, "has the name of a parameter; allowed: another");
	return STATUS_OK;
}

static size_t parameter_named(const struct study *study, const char *name)
{
	size_t i = 0;
	while (i < study->parameter_count && strcmp(study->parameters[i].name, name) != 0)
		i++;
	return i;
}

static enum status take_parameter(const struct study *study, const struct scene_node *node, const char *key, size_t *out)
{
	const char *name;
	TRY(study_text(study, node, key, &name));
	if (name == NULL)
		return STATUS_OK;
	struct scene_list list = {.length = 0};
	for (size_t i = 0; i < study->parameter_count; i++)
		scene_list_add(&list, study->parameters[i].name);
	*out = parameter_named(study, name);
	return *out < study->parameter_count
		       ? STATUS_OK
		       : scene_error(study->file, scene_node_child(node, key), "is no parameter; allowed: %s", list.text);
}

static enum status take_plot(const struct study *study, const struct scene_node *node, struct study_plot *plot)
{
	static const char *const keys[] = {"x", "y", "by", NULL};
	const char *y = NULL;
	*plot = (struct study_plot){.x = SIZE_MAX, .by = SIZE_MAX, .y = 0};
	TRY(study_only(study, node, keys));
	TRY(take_parameter(study, node, "x", &plot->x));
	TRY(take_parameter(study, node, "by", &plot->by));
	TRY(study_text(study, node, "y", &y));
	if (y == NULL || plot->x == SIZE_MAX || plot->x == plot->by)
		return scene_error(study->file, node,
				   "is no plot; allowed: x (a parameter), y (a result), by "
				   "(another parameter)");
	struct scene_list list = {.length = 0};
	for (plot->y = 0; plot->y < study->result_count && strcmp(study->results[plot->y].name, y) != 0; plot->y++)
		scene_list_add(&list, study->results[plot->y].name);
	return plot->y < study->result_count
		       ? STATUS_OK
		       : scene_error(study->file, scene_node_child(node, "y"), "is no result of this study; give one of %s, or add it under results", list.text);
}

/* Without `plots`: each result over the first parameter, by the second where it has few enough values. */
static void plot_all(struct study *study)
{
	struct study_plot plot = {.x = 0, .by = study->parameter_count > 1 ? 1 : SIZE_MAX};
	if (study_plot_check(study, &plot, study->root) != STATUS_OK)
		plot.by = SIZE_MAX;
	if (study_plot_check(study, &plot, study->root) != STATUS_OK) {
		note("%s: no plot is drawn, since %s has too many values that are no numbers; name another parameter as x under plots", study->file,
		     study->parameters[0].name);
		return;
	}
	for (plot.y = 0; plot.y < study->result_count && plot.y < STUDY_PLOTS; plot.y++)
		study->plots[study->plot_count++] = plot;
}

enum status study_read_results(struct study *study)
{
	const struct scene_node *results = scene_node_child(study->root, "results"),
				*plots = scene_node_child(study->root, "plots");
	study->results = mem_calloc(STUDY_RESULTS, sizeof *study->results);
	study->plots = mem_calloc(STUDY_PLOTS, sizeof *study->plots);
	TRY_MEM(study->results != NULL && study->plots != NULL, "results of the study");
	if (results != NULL && (results->kind != SCENE_MAPPING || results->count > STUDY_RESULTS))
		return scene_error(study->file, results, "is no mapping; allowed: up to %d names, with what each is",
				   STUDY_RESULTS);
	for (const struct scene_node *node = results != NULL ? results->first : NULL; node != NULL; node = node->next) {
		TRY(take_result(study, node, &study->results[study->result_count]));
		study->result_count++;
	}
	if (plots == NULL) {
		plot_all(study);
		return STATUS_OK;
	}
	if (plots->kind != SCENE_SEQUENCE || plots->count > STUDY_PLOTS)
		return scene_error(study->file, plots, "is no list; allowed: up to %d plots", STUDY_PLOTS);
	for (const struct scene_node *node = plots->first; node != NULL; node = node->next) {
		TRY(take_plot(study, node, &study->plots[study->plot_count]));
		TRY(study_plot_check(study, &study->plots[study->plot_count], node));
		study->plot_count++;
	}
	return STATUS_OK;
}
