/* What a drive counted, held to its plan: run.json's "counts" against lines times units. */
#ifndef FURROW_TESTS_COUNTS_H
#define FURROW_TESTS_COUNTS_H

#include "base/json.h"
#include "base/plan.h"
#include "scene/scene.h"
#include "support.h"

static inline const cJSON *counts_get(const cJSON *object, const char *name)
{
	const cJSON *found = cJSON_GetObjectItemCaseSensitive(object, name);
	if (found == NULL)
		print_error("counts have no %s\n", name);
	assert_non_null(found);
	return found;
}

static inline int64_t counts_integer(const cJSON *object, const char *name)
{
	const cJSON *found = counts_get(object, name);
	assert_true(cJSON_IsNumber(found));
	return (int64_t)found->valuedouble;
}

/* How many of the line's unit there were: of its object, or of its table. */
static inline int64_t counts_unit(const cJSON *counts, const struct plan_line *line, const struct scene *scene)
{
	const cJSON *unit = counts_get(counts_get(counts, "units"), plan_unit_name(line->unit));
	if (line->unit == PLAN_CHANGED || line->unit == PLAN_LEFT || line->unit == PLAN_INHERITED ||
	    line->unit == PLAN_KEPT)
		return counts_integer(unit, strchr(line->name, ' ') + 1);
	if (!cJSON_IsObject(unit))
		return (int64_t)unit->valuedouble;
	if (line->object >= 0)
		return counts_integer(unit, scene->objects[line->object].name);
	int64_t all = 0;
	for (const cJSON *object = unit->child; object != NULL; object = object->next)
		all += (int64_t)object->valuedouble;
	return all;
}

/* Of the lines of a kind (and a name, unless NULL): amounts, or bytes, times units. */
static inline int64_t counts_planned(const struct plan *plan, const cJSON *counts, const struct scene *scene,
				     enum plan_kind kind, const char *name, bool bytes)
{
	int64_t sum = 0;
	for (size_t i = 0; i < plan->count; i++) {
		const struct plan_line *line = &plan->lines[i];
		if (line->kind != kind || (name != NULL && strcmp(line->name, name) != 0))
			continue;
		int64_t units = line->unit == PLAN_ONCE ? 1 : counts_unit(counts, line, scene);
		sum += units * (bytes ? (int64_t)line->bytes : line->amount);
	}
	return sum;
}

static inline int counts_differ(const char *what, const char *name, int64_t counted, int64_t planned)
{
	if (counted != planned)
		print_error("%s %s: %lld counted, %lld planned\n", what, name, (long long)counted, (long long)planned);
	return counted != planned;
}

/* Each name of a kind, once in the plan or not at all in what was counted. */
static inline int counts_check_names(const struct plan *plan, enum plan_kind kind, const cJSON *counted, const char *key)
{
	int problems = 0;
	for (size_t i = 0; i < plan->count; i++)
		if (plan->lines[i].kind == kind) {
			int found = 0;
			for (const cJSON *item = counted->child; item != NULL; item = item->next)
				found += strcmp(counts_get(item, key)->valuestring, plan->lines[i].name) == 0;
			problems += counts_differ(plan_kind_name(kind), plan->lines[i].name, found, 1);
		}
	return problems;
}

static inline int counts_check_statements(const struct plan *plan, const cJSON *counts, const struct scene *scene)
{
	int problems = 0;
	const cJSON *tables = counts_get(counts, "statements");
	for (int table = 0; table < STORE_TABLES; table++) {
		const char *name = store_table_name((enum store_table)table), *const verbs[] = {"read", "write"};
		const cJSON *counted = cJSON_GetObjectItemCaseSensitive(tables, name);
		for (int i = 0; i < 2; i++) {
			char full[64];
			snprintf(full, sizeof full, "%s %s", verbs[i], name);
			problems += counts_differ("statements", full, counted != NULL ? counts_integer(counted, verbs[i]) : 0,
						  counts_planned(plan, counts, scene, PLAN_STATEMENT, full, false));
		}
	}
	return problems;
}

/* Prints what is not as planned; how many such there are. */
static inline int counts_check(const struct plan *plan, const cJSON *counts, const struct scene *scene)
{
	const cJSON *programs = counts_get(counts, "programs"), *passes = counts_get(counts, "passes");
	int problems = counts_check_names(plan, PLAN_PROGRAM, programs, "name");
	problems += counts_differ("programs", "in all", cJSON_GetArraySize(programs),
				  counts_planned(plan, counts, scene, PLAN_PROGRAM, NULL, false));
	problems += counts_differ("programs", "unplanned", counts_integer(counts, "unplanned"), 0);
	for (int i = 0; i < GPU_STAGES; i++) {
		const char *name = gpu_stage_name((enum gpu_stage)i);
		const cJSON *counted = cJSON_GetObjectItemCaseSensitive(passes, name);
		problems += counts_differ("passes", name, counted != NULL ? (int64_t)counted->valuedouble : 0,
					  counts_planned(plan, counts, scene, PLAN_PASS, name, false));
	}
	problems += counts_differ("textures", "in all", counts_integer(counts, "textures"),
				  counts_planned(plan, counts, scene, PLAN_TEXTURE, NULL, false));
	problems += counts_differ("bytes", "in all", counts_integer(counts, "bytes"),
				  counts_planned(plan, counts, scene, PLAN_TEXTURE, NULL, true) +
					  counts_planned(plan, counts, scene, PLAN_BUFFER, NULL, true));
	problems += counts_differ("threads", "in all", counts_integer(counts, "threads"),
				  counts_planned(plan, counts, scene, PLAN_THREAD, NULL, false));
	return problems + counts_check_statements(plan, counts, scene);
}

#endif
