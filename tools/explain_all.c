/* furrow explain --all: effects, planes, programs, threads, statements and buffers, each with what calls for it at the right. */
#include <stdio.h>
#include <string.h>

#include "explain.h"
#include "explain_layout.h"

void explain_effects_text(const struct scene *scene, const struct report_plan *plan)
{
	puts("\neffects");
	for (int e = 0; e < EFFECT_COUNT; e++) {
		const struct effect_row *effect = scene_effect_row((enum scene_effect)e);
		char what[160], why[160];
		if ((plan->effects >> e & 1) == 0)
			continue;
		snprintf(what, sizeof what, "  %-9s %s", effect->name, effect->what);
		scene_effect_reason(scene, (enum scene_effect)e, why, sizeof why);
		layout_row(what, why);
	}
}

/* --- what is made --- */

void explain_planes_text(const struct scene *scene, const struct report_plan *plan)
{
	uint64_t bytes = 0;
	for (size_t i = 0; i < plan->plan.count; i++)
		if (plan->plan.lines[i].kind == PLAN_PLANE)
			bytes += plan->plan.lines[i].bytes;
	printf("\nplanes: %s bytes a post\n", layout_number(bytes).text);
	for (int called = 0; called < 2; called++) /* what every drive has comes first */
		for (size_t i = 0; i < plan->plan.count; i++) {
			const struct plan_line *line = &plan->plan.lines[i];
			char what[160], why[160];
			if (line->kind != PLAN_PLANE || (line->effect != NULL) != called)
				continue;
			snprintf(what, sizeof what, "  %-12s %llu", line->name, (unsigned long long)line->bytes);
			explain_reason(scene, line->effect, why, sizeof why);
			layout_row(what, why);
		}
}

/* The two files that a program's name begins with. */
static size_t files_length(const char *name)
{
	size_t first = strcspn(name, " ");
	return first + (name[first] != '\0') + strcspn(name + first + (name[first] != '\0'), " ");
}

static bool same_files(const struct plan_line *a, const struct plan_line *b)
{
	size_t length = files_length(a->name);
	return b->kind == PLAN_PROGRAM && files_length(b->name) == length && strncmp(a->name, b->name, length) == 0;
}

/* Programs of the same files together, where the first of them is; each variant on a line of its own if there are more. */
static void print_variants(const struct scene *scene, const struct plan *plan, size_t first)
{
	const struct plan_line *head = &plan->lines[first];
	size_t length = files_length(head->name), variants = 0;
	char what[160], why[160];
	for (size_t i = 0; i < plan->count; i++) {
		variants += same_files(head, &plan->lines[i]);
		if (i < first && same_files(head, &plan->lines[i]))
			return;
	}
	if (variants > 1)
		printf("  %.*s\n", (int)length, head->name);
	for (size_t i = first; i < plan->count; i++) {
		const struct plan_line *line = &plan->lines[i];
		const char *defines = line->name + length;
		if (!same_files(head, line))
			continue;
		if (variants > 1)
			snprintf(what, sizeof what, "     %s", defines[0] != '\0' ? defines : " plain");
		else
			snprintf(what, sizeof what, "  %s", line->name);
		explain_reason(scene, line->effect, why, sizeof why);
		layout_row(what, why);
	}
}

void explain_programs_text(const struct scene *scene, const struct plan *plan)
{
	printf("\nprograms: %zu\n", explain_count(plan, PLAN_PROGRAM));
	for (size_t i = 0; i < plan->count; i++)
		if (plan->lines[i].kind == PLAN_PROGRAM)
			print_variants(scene, plan, i);
}

/* --- what is run --- */

void explain_threads_text(const struct scene *scene, const struct plan *plan)
{
	int64_t threads = 0;
	for (size_t i = 0; i < plan->count; i++)
		threads += plan->lines[i].kind == PLAN_THREAD ? plan->lines[i].amount : 0;
	printf("\nthreads: %lld besides the one that steps\n", (long long)threads);
	for (size_t i = 0; i < plan->count; i++) {
		const struct plan_line *line = &plan->lines[i];
		char what[160], why[160];
		if (line->kind != PLAN_THREAD)
			continue;
		snprintf(what, sizeof what, "  %-12s %lld", line->name, (long long)line->amount);
		explain_reason(scene, line->effect, why, sizeof why);
		layout_row(what, why);
	}
}

/* Lines of one table together, where the first of them is; its name once. */
static void print_table(const struct scene *scene, const struct plan *plan, size_t first)
{
	const char *name = plan->lines[first].name;
	for (size_t i = 0; i < plan->count; i++) {
		const struct plan_line *line = &plan->lines[i];
		char what[160], why[160];
		if (line->kind != PLAN_STATEMENT || strcmp(line->name, name) != 0)
			continue;
		if (i < first)
			return;
		snprintf(what, sizeof what, "  %-14s %lld %s", i == first ? name : "", (long long)line->amount, explain_each_of(line->unit));
		explain_reason(scene, line->effect, why, sizeof why);
		layout_row(what, why);
	}
}

void explain_tables_text(const struct scene *scene, const struct plan *plan)
{
	puts("\ntables");
	for (size_t i = 0; i < plan->count; i++)
		if (plan->lines[i].kind == PLAN_STATEMENT)
			print_table(scene, plan, i);
}

/* --- what it takes --- */

bool explain_is_memory(const struct plan_line *line)
{
	return line->kind == PLAN_TEXTURE || line->kind == PLAN_BUFFER;
}

/* What of a unit is there for one reason, where its first line is. */
static void print_bytes(const struct scene *scene, const struct plan *plan, size_t first)
{
	const struct plan_line *head = &plan->lines[first];
	uint64_t bytes = 0;
	char what[160], why[160], other[160];
	explain_reason(scene, head->effect, why, sizeof why);
	for (size_t i = 0; i < plan->count; i++) {
		const struct plan_line *line = &plan->lines[i];
		if (!explain_is_memory(line) || line->unit != head->unit)
			continue;
		if (!explain_same_effect(line, head)) {
			explain_reason(scene, line->effect, other, sizeof other);
			if (strcmp(other, why) != 0)
				continue;
		}
		if (i < first)
			return;
		bytes += line->bytes;
	}
	snprintf(what, sizeof what, "  %-12s %s", layout_bytes(bytes).text, explain_each_of(head->unit));
	if (bytes > 0)
		layout_row(what, why);
}

void explain_bytes_text(const struct scene *scene, const struct plan *plan)
{
	for (int unit = 0; unit < PLAN_UNITS; unit++)
		for (size_t i = 0; i < plan->count; i++)
			if (explain_is_memory(&plan->lines[i]) && (int)plan->lines[i].unit == unit)
				print_bytes(scene, plan, i);
}

void explain_not_run_text(const struct report_plan *plan)
{
	char names[1024] = "";
	size_t used = 0;
	for (int e = 0; e < EFFECT_COUNT; e++)
		if ((plan->effects >> e & 1) == 0)
			used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", used > 0 ? ", " : "",
						 scene_effect_row((enum scene_effect)e)->name);
	puts("\nnot run");
	layout_wrapped(names, 2);
}
