/* Reads a study file: the scene, what is varied, and how. Everything that is not known is refused
 * with its line. */
#include <math.h>
#include <string.h>

#include "scene/scene_error.h"
#include "scene/scene_file.h"
#include "study.h"

/* Gives the parameter its keys: those that `names` has for it, or its name. */
static enum status take_keys(const struct study *study, struct study_parameter *parameter)
{
	const struct scene_node *names = scene_node_child(study->root, "names");
	const struct scene_node *node = names != NULL ? scene_node_child(names, parameter->name) : NULL;
	parameter->key_count = 1;
	parameter->keys[0] = node != NULL && node->kind == SCENE_SCALAR ? node->text : parameter->name;
	if (node == NULL || node->kind == SCENE_SCALAR)
		return STATUS_OK;
	parameter->key_count = 0;
	for (const struct scene_node *key = node->first; key != NULL; key = key->next) {
		if (node->kind != SCENE_SEQUENCE || key->kind != SCENE_SCALAR || key->text[0] == '\0')
			return scene_error(study->file, key, "is no key of a scene; allowed: names joined by dots");
		if (parameter->key_count == SETTINGS_MAX)
			return scene_error(study->file, node, "has too many keys; allowed: %d", SETTINGS_MAX);
		parameter->keys[parameter->key_count++] = key->text;
	}
	return parameter->key_count > 0 ? STATUS_OK : scene_error(study->file, node, "names no key; allowed: one or more");
}

static enum status take_list(struct study *study, const struct scene_node *node, struct study_parameter *parameter)
{
	if (node->count == 0 || node->count > STUDY_VALUES)
		return scene_error(study->file, node, "has %zu values; allowed: 1 to %d", node->count, STUDY_VALUES);
	TRY(mem_zeroed(&parameter->values, node->count, sizeof *parameter->values, "values of the study"));
	for (const struct scene_node *value = node->first; value != NULL; value = value->next) {
		TRY(study_yaml(study, value, &parameter->values[parameter->value_count]));
		for (size_t i = 0; i < parameter->value_count && study->design == STUDY_GRID; i++)
			if (strcmp(parameter->values[i], parameter->values[parameter->value_count]) == 0)
				return scene_error(study->file, value, "is written twice; allowed: each value once");
		parameter->value_count++;
	}
	return STATUS_OK;
}

static enum status take_range(struct study *study, const struct scene_node *node, struct study_parameter *parameter)
{
	static const char *const of_grid[] = {"from", "to", "count", "scale", NULL}, *const of_cube[] = {"from", "to", "scale",
													 "whole", NULL};
	static const char *const scales[] = {"linear", "log", NULL}, *const truths[] = {"false", "true", NULL};
	const bool grid = study->design == STUDY_GRID;
	double count = 0;
	int scale = 0, whole = 0;
	parameter->from = parameter->to = NAN;
	TRY(study_only(study, node, grid ? of_grid : of_cube));
	TRY(study_number(study, node, "from", -1e300, 1e300, &parameter->from));
	TRY(study_number(study, node, "to", -1e300, 1e300, &parameter->to));
	TRY(study_number(study, node, "count", 2, STUDY_VALUES, &count));
	TRY(study_choice(study, node, "scale", scales, &scale));
	TRY(study_choice(study, node, "whole", truths, &whole));
	parameter->logarithmic = scale == 1;
	parameter->whole = whole == 1;
	if (!(parameter->from < parameter->to))
		return scene_error(study->file, node, "is no range; allowed: from and to, with from below to");
	if (parameter->logarithmic && !(parameter->from > 0))
		return scene_error(study->file, node, "has a logarithmic scale from %g; allowed: from above 0", parameter->from);
	if (parameter->whole && (parameter->logarithmic || parameter->from != floor(parameter->from) || parameter->to != floor(parameter->to)))
		return scene_error(study->file, node, "is no range of whole numbers; allowed: whole from and to, linear");
	if (grid && (count < 2 || count != floor(count)))
		return scene_error(study->file, node, "says no whole count; allowed: count: 2 to %d", STUDY_VALUES);
	parameter->value_count = (size_t)count;
	return STATUS_OK;
}

/* Adds a parameter. The new one is the last; *out is its place. */
static enum status add_parameter(struct study *study, const struct scene_node *node, struct study_parameter **out)
{
	if (study->parameter_count == STUDY_PARAMETERS)
		return scene_error(study->file, node, "is one parameter too many; allowed: %d", STUDY_PARAMETERS);
	struct study_parameter *parameter = *out = &study->parameters[study->parameter_count++];
	*parameter = (struct study_parameter){.name = node->key, .node = node};
	return take_keys(study, parameter);
}

static enum status take_parameters(struct study *study, const struct scene_node *node)
{
	if (node->kind != SCENE_MAPPING || node->count == 0)
		return scene_error(study->file, node, "has no parameters; allowed: a mapping of keys to values");
	for (const struct scene_node *child = node->first; child != NULL; child = child->next) {
		struct study_parameter *parameter;
		TRY(add_parameter(study, child, &parameter));
		if (child->kind == SCENE_SCALAR)
			return scene_error(study->file, child,
					   "is a single value; allowed: a list, or a range {from, to, ...}; what all runs have is under `set`");
		TRY(child->kind == SCENE_SEQUENCE ? take_list(study, child, parameter) : take_range(study, child, parameter));
	}
	return STATUS_OK;
}

/* Runs that are written out one by one. All name the same parameters. */
static enum status take_runs(struct study *study, const struct scene_node *node)
{
	if (node->kind != SCENE_SEQUENCE || node->count == 0 || node->count > STUDY_RUNS)
		return scene_error(study->file, node, "has %zu runs; allowed: a list of 1 to %d mappings", node->count, STUDY_RUNS);
	const struct scene_node *first = node->first;
	for (const struct scene_node *run = first; run != NULL; run = run->next)
		if (run->kind != SCENE_MAPPING || run->count == 0 || run->count != first->count)
			return scene_error(study->file, run,
					   "does not have the keys of the first run; allowed: the "
					   "same in all");
	for (const struct scene_node *child = first->first; child != NULL; child = child->next) {
		struct study_parameter *parameter;
		TRY(add_parameter(study, child, &parameter));
		if ((parameter->values = mem_calloc(node->count, sizeof *parameter->values)) == NULL)
			return fail_memory("values of the study");
		for (const struct scene_node *run = first; run != NULL; run = run->next) {
			const struct scene_node *value = scene_node_child(run, child->key);
			if (value == NULL)
				return scene_error(study->file, run, "lacks %s; allowed: the same keys in all runs", child->key);
			TRY(study_yaml(study, value, &parameter->values[parameter->value_count++]));
		}
	}
	return STATUS_OK;
}

static enum status take_hypercube(struct study *study, const struct scene_node *node)
{
	static const char *const keys[] = {"count", "seed", "parameters", NULL};
	double count = 0, seed = 0;
	TRY(study_only(study, node, keys));
	TRY(study_number(study, node, "count", 1, STUDY_RUNS, &count));
	TRY(study_number(study, node, "seed", 0, 9007199254740991.0, &seed));
	const struct scene_node *parameters = scene_node_child(node, "parameters");
	if (count < 1 || count != floor(count) || seed != floor(seed) || parameters == NULL)
		return scene_error(study->file, node,
				   "is no sample; allowed: count (a whole number), seed (a whole "
				   "number), parameters");
	study->run_count = (size_t)count;
	study->seed = (uint64_t)seed;
	return take_parameters(study, parameters);
}

static enum status take_design(struct study *study)
{
	static const char *const designs[] = {"grid", "list", "hypercube"};
	const struct scene_node *found = NULL;
	for (int i = 0; i < 3; i++) {
		const struct scene_node *node = scene_node_child(study->root, designs[i]);
		if (node != NULL && found != NULL)
			return scene_error(study->file, node, "is a second design; allowed: one of grid, list, hypercube");
		if (node != NULL) {
			found = node;
			study->design = (enum study_design)i;
		}
	}
	if (found == NULL)
		return scene_error(study->file, study->root, "says not what is varied; allowed: one of grid, list, hypercube");
	switch (study->design) {
	case STUDY_GRID:
		return take_parameters(study, found);
	case STUDY_LIST:
		return take_runs(study, found);
	default:
		return take_hypercube(study, found);
	}
}

/* Each key is set once, and not more of them than a drive takes. */
static enum status check_keys(const struct study *study)
{
	const char *keys[SETTINGS_MAX];
	size_t count = 0;
	for (size_t i = 0; i < study->set_count; i++)
		keys[count++] = study->set[i].key;
	for (size_t i = 0; i < study->parameter_count; i++)
		for (size_t k = 0; k < study->parameters[i].key_count; k++) {
			const struct study_parameter *parameter = &study->parameters[i];
			if (count == SETTINGS_MAX)
				return scene_error(study->file, parameter->node, "sets one key too many; allowed: %d in all",
						   SETTINGS_MAX);
			for (size_t j = 0; j < count; j++)
				if (strcmp(keys[j], parameter->keys[k]) == 0)
					return scene_error(study->file, parameter->node,
							   "sets %s, which is set elsewhere; "
							   "allowed: each key once",
							   parameter->keys[k]);
			keys[count++] = parameter->keys[k];
		}
	const struct scene_node *names = scene_node_child(study->root, "names");
	for (const struct scene_node *name = names != NULL ? names->first : NULL; name != NULL; name = name->next) {
		size_t i = 0;
		while (i < study->parameter_count && strcmp(study->parameters[i].name, name->key) != 0)
			i++;
		if (i == study->parameter_count)
			return scene_error(study->file, name,
					   "is no parameter of the study; allowed: names that the "
					   "design uses");
	}
	return STATUS_OK;
}

static enum status take_set(struct study *study)
{
	const struct scene_node *set = scene_node_child(study->root, "set");
	if (set != NULL && set->kind != SCENE_MAPPING)
		return scene_error(study->file, set, "is no mapping; allowed: keys of the scene, with their values");
	for (const struct scene_node *child = set != NULL ? set->first : NULL; child != NULL; child = child->next) {
		if (study->set_count == SETTINGS_MAX || strcmp(child->key, "store") == 0)
			return scene_error(study->file, child,
					   "cannot be set here; allowed: %d keys of the scene; "
					   "`store` beside `scene`",
					   SETTINGS_MAX);
		study->set[study->set_count].key = child->key;
		TRY(study_yaml(study, child, &study->set[study->set_count++].value));
	}
	return STATUS_OK;
}

static enum status take_paths(struct study *study)
{
	const char *scene, *store;
	TRY(study_text(study, study->root, "scene", &scene));
	TRY(study_text(study, study->root, "store", &store));
	if (scene == NULL)
		return scene_error(study->file, study->root, "names no scene; allowed: scene: FILE");
	study->scene = study_keep(study, scene_file_beside(study->folder, scene));
	study->store = store != NULL ? study_keep(study, scene_file_beside(study->folder, store)) : NULL;
	return study->scene != NULL && (store == NULL || study->store != NULL) ? STATUS_OK : fail_memory("paths of the study");
}

enum status study_read(const char *path, const char *beside, struct study *study)
{
	static const char *const keys[] = {"study", "scene",	 "store",   "set",   "names", "grid",
					   "list",  "hypercube", "results", "plots", NULL};
	double version = 0;
	*study = (struct study){.file = path};
	TRY(scene_file_read(path, path, SCENE_BYTES, &study->text, &study->length));
	TRY(scene_folder_of(beside != NULL ? beside : path, true, &study->folder));
	TRY(scene_tree_parse(path, NULL, study->text, study->length, &study->root));
	TRY(study_only(study, study->root, keys));
	TRY(study_number(study, study->root, "study", 1, 1, &version));
	if (version != 1)
		return scene_error(path, study->root, "says no version; allowed: study: 1");
	const struct scene_node *names = scene_node_child(study->root, "names");
	if (names != NULL && names->kind != SCENE_MAPPING)
		return scene_error(path, names, "is no mapping; allowed: a name, and the keys of the scene that it sets");
	if ((study->parameters = mem_calloc(STUDY_PARAMETERS, sizeof *study->parameters)) == NULL)
		return fail_memory("parameters of the study");
	TRY(take_paths(study));
	TRY(take_set(study));
	TRY(take_design(study));
	TRY(check_keys(study));
	TRY(study_expand(study));
	return study_read_results(study);
}
