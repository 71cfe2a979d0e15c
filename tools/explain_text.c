/* furrow explain, for a person: sections of lines, each with what calls for it in one column at the right. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "explain.h"
#include "explain_layout.h"

static void line_reason(const struct scene *scene, const struct plan_line *line, char *text, size_t size)
{
	explain_reason(scene, line->effect, text, size);
}

static bool is_of(const struct plan_line *line, enum plan_kind kind)
{
	return line->kind == kind;
}

static bool same_effect(const struct plan_line *a, const struct plan_line *b)
{
	return a->effect == b->effect || (a->effect != NULL && b->effect != NULL && strcmp(a->effect, b->effect) == 0);
}

static size_t count_of(const struct plan *plan, enum plan_kind kind)
{
	size_t count = 0;
	for (size_t i = 0; i < plan->count; i++)
		count += is_of(&plan->lines[i], kind);
	return count;
}

/* --- what it is over --- */

static void print_head(const struct scene *scene, const struct report_plan *plan)
{
	if (plan->store != NULL)
		printf("%s over %s%s\n", scene->file, plan->store, plan->deformed ? ", which is deformed already" : "");
	else
		printf("%s over no store%s%s%s\n  assumed: one of little relief that is not deformed, with posts and tiles as follow\n",
		       scene->file, plan->missing != NULL ? ": " : "", plan->missing != NULL ? plan->missing : "",
		       plan->missing != NULL ? " is not there" : "");
	printf("  posts %g m apart (level %d) in tiles of %u x %u cells", plan->spacing, plan->level, plan->cells, plan->cells);
	if (plan->window_tiles > 0)
		printf("; a window touches at most %zu", plan->window_tiles);
	if (plan->batch_windows > 0)
		printf("\n  contacts that share no post are computed together, up to %zu at once; that takes %s more", plan->batch_windows,
		       layout_bytes(plan->batch_bytes).text);
	printf("\n  %s step%s", layout_number((uint64_t)plan->steps).text, plan->steps == 1 ? "" : "s");
	if (plan->pictures > 0)
		printf(", %s picture%s: one every %s steps", layout_number((uint64_t)plan->pictures).text, plan->pictures == 1 ? "" : "s",
		       layout_number((uint64_t)plan->picture_steps).text);
	puts("");
}

static void print_effects(const struct scene *scene, const struct report_plan *plan)
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

static void print_rasters(const struct report_plan *plan)
{
	if (plan->raster_count > 0)
		puts("\nnumbers of the soil at each post");
	for (int i = 0; i < plan->raster_count; i++) {
		const struct world_raster *raster = &plan->rasters[i];
		char what[160];
		snprintf(what, sizeof what, "  %-17s %.6g to %.6g%s%s in steps of %.4g", raster->key, raster->low, raster->high,
			 raster->unit != NULL ? " " : "", raster->unit != NULL ? raster->unit : "", raster->step);
		layout_row(what, raster->path);
	}
}

/* --- what is made --- */

static void print_planes(const struct scene *scene, const struct report_plan *plan)
{
	uint64_t bytes = 0;
	for (size_t i = 0; i < plan->plan.count; i++)
		if (is_of(&plan->plan.lines[i], PLAN_PLANE))
			bytes += plan->plan.lines[i].bytes;
	printf("\nplanes: %s bytes a post\n", layout_number(bytes).text);
	for (int called = 0; called < 2; called++) /* what every drive has comes first */
		for (size_t i = 0; i < plan->plan.count; i++) {
			const struct plan_line *line = &plan->plan.lines[i];
			char what[160], why[160];
			if (!is_of(line, PLAN_PLANE) || (line->effect != NULL) != called)
				continue;
			snprintf(what, sizeof what, "  %-12s %llu", line->name, (unsigned long long)line->bytes);
			line_reason(scene, line, why, sizeof why);
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
	return is_of(b, PLAN_PROGRAM) && files_length(b->name) == length && strncmp(a->name, b->name, length) == 0;
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
		line_reason(scene, line, why, sizeof why);
		layout_row(what, why);
	}
}

static void print_programs(const struct scene *scene, const struct plan *plan)
{
	printf("\nprograms: %zu\n", count_of(plan, PLAN_PROGRAM));
	for (size_t i = 0; i < plan->count; i++)
		if (is_of(&plan->lines[i], PLAN_PROGRAM))
			print_variants(scene, plan, i);
}

/* --- what is run --- */

/* After an amount: "a window". */
static const char *each_of(enum plan_unit unit)
{
	static const char *const words[PLAN_UNITS] = {
		[PLAN_ONCE] = "once",
		[PLAN_BASE_SLOT] = "a tile in a slot",
		[PLAN_CLASS_SLOT] = "a tile in a slot, with classes",
		[PLAN_NUMBER_SLOT] = "a tile in a slot, with numbers of the soil",
		[PLAN_DEFORM_SLOT] = "a deformed tile in a slot",
		[PLAN_STATE_SLOT] = "a deformed tile of the working level",
		[PLAN_BASE_ARRAY] = "an array of tiles in slots",
		[PLAN_BASE_LAYER] = "a layer of one",
		[PLAN_DEFORM_ARRAY] = "an array of deformed tiles in slots",
		[PLAN_DEFORM_LAYER] = "a layer of one",
		[PLAN_PATCH] = "a base interpolated at once",
		[PLAN_PAGE] = "a changed page on its way",
		[PLAN_WINDOW_LAYER] = "a window of one sweep",
		[PLAN_RESULT_LAYER] = "256 x 256 posts of blocks that slide",
		[PLAN_PROBED] = "a post near a soil geom",
		[PLAN_RING] = "a segment of parameters",
		[PLAN_WINDOW] = "a window",
		[PLAN_MOVED] = "a window that it moved over",
		[PLAN_BATCH] = "a batch of windows",
		[PLAN_BATCH_DRAW] = "an array, or bodies of a kind, in a batch",
		[PLAN_BATCH_SEARCH] = "a search for bodies of a kind in a batch",
		[PLAN_BATCH_STORE] = "an array that a batch writes",
		[PLAN_BATCH_ENVELOPE] = "a draw of undersides in a batch",
		[PLAN_FACETS] = "a draw of triangles",
		[PLAN_HELD] = "a block of soil that slides under an object",
		[PLAN_RESTING] = "a window of an object at rest",
		[PLAN_ATLAS] = "an atlas of blocks that slide",
		[PLAN_DECIMATED] = "a change brought to a coarser tile",
		[PLAN_SUBDIVIDED] = "a base interpolated",
		[PLAN_DRAWN] = "a tile drawn",
		[PLAN_OBJECTS] = "objects drawn at once",
		[PLAN_SHADOWED] = "a picture with shadows",
		[PLAN_FRAME] = "a picture",
		[PLAN_LOADED] = "a tile loaded",
		[PLAN_LOADED_COARSER] = "a coarser tile loaded",
		[PLAN_READ] = "a base read",
		[PLAN_RANGE] = "a range of heights asked",
		[PLAN_OFFSET_RANGE] = "a range of offsets asked",
		[PLAN_COMMITTED] = "a tile committed",
		[PLAN_COMMITTED_COARSER] = "a coarser tile committed",
		[PLAN_CHANGED] = "a row that changed",
		[PLAN_LEFT] = "a row that an earlier drive left",
		[PLAN_KEPT] = "a row that the history keeps",
		[PLAN_SOUGHT] = "a look into the history",
		[PLAN_INHERITED] = "a further look into a file under the overlay",
		[PLAN_COMMIT] = "an epoch",
	};
	return words[unit];
}

static bool same_pass(const struct plan_line *a, const struct plan_line *b)
{
	return a->unit == b->unit && a->amount == b->amount && strcmp(a->name, b->name) == 0 && same_effect(a, b);
}

/* The passes of each object, in the order of the plan. */
struct passes {
	const struct report_plan *all;
	size_t *first; /* its first line, by object + 1; the plan's number of lines: it has none */
	size_t *next;  /* by line: the next line of the same object */
};

static void list_passes(const struct passes *passes)
{
	const struct plan *plan = &passes->all->plan;
	for (size_t i = 0; i <= passes->all->body_count; i++)
		passes->first[i] = plan->count;
	for (size_t i = plan->count; i-- > 0;) {
		if (!is_of(&plan->lines[i], PLAN_PASS))
			continue;
		size_t *first = &passes->first[plan->lines[i].object + 1];
		passes->next[i] = *first;
		*first = i;
	}
}

/* The nth pass of an object (-1: of none), or NULL. */
static const struct plan_line *pass_of(const struct passes *passes, int object, size_t nth)
{
	const struct plan *plan = &passes->all->plan;
	size_t line = passes->first[object + 1];
	while (line < plan->count && nth-- > 0)
		line = passes->next[line];
	return line < plan->count ? &plan->lines[line] : NULL;
}

/* The same passes of the same shape, whatever its size. */
static bool are_alike(const struct passes *passes, int a, int b)
{
	const struct report_plan *all = passes->all;
	const struct plan_line *of_a, *of_b;
	if (all->bodies[a].shape->kind != all->bodies[b].shape->kind || (all->bodies[a].contacts > 0) != (all->bodies[b].contacts > 0))
		return false;
	for (size_t nth = 0;; nth++) {
		of_a = pass_of(passes, a, nth);
		of_b = pass_of(passes, b, nth);
		if (of_a == NULL || of_b == NULL)
			return of_a == of_b;
		if (!same_pass(of_a, of_b))
			return false;
	}
}

static void print_passes_of(const struct scene *scene, const struct passes *passes, int object)
{
	const struct plan_line *line;
	for (size_t nth = 0; (line = pass_of(passes, object, nth)) != NULL; nth++) {
		char what[160], why[160];
		snprintf(what, sizeof what, "    %-10s %2lld %s", line->name, (long long)line->amount, each_of(line->unit));
		line_reason(scene, line, why, sizeof why);
		layout_row(what, why);
	}
}

/* A soil geom's contacts depend on the motion. */
static void print_contacts(const double contacts[2], bool each)
{
	printf(": about %.3g", contacts[0]);
	if (contacts[1] > 1.005 * contacts[0])
		printf(" to %.3g", contacts[1]);
	printf(" contacts a metre%s,\n    where it rolls without slip or slides on the level; more where it slips, sinks or turns back,\n"
	       "    at most one a time step; a window or more at each over ground\n", each ? " each" : "");
}

/* The object or the soil geom, and those like it, where it is the first of them. */
static void print_object(const struct scene *scene, const struct passes *passes, size_t first)
{
	const struct report_plan *plan = passes->all;
	size_t alike = 0;
	uint64_t least = UINT64_MAX, most = 0;
	double contacts[2] = {INFINITY, 0};
	for (size_t i = 0; i < plan->body_count; i++) {
		if (!are_alike(passes, (int)first, (int)i))
			continue;
		if (i < first)
			return;
		alike++;
		contacts[0] = fmin(contacts[0], plan->bodies[i].contacts);
		contacts[1] = fmax(contacts[1], plan->bodies[i].contacts);
		if (i >= scene->object_count)
			continue;
		least = plan->samples[i] < least ? plan->samples[i] : least;
		most = plan->samples[i] > most ? plan->samples[i] : most;
	}
	printf("  %s", plan->bodies[first].name);
	if (alike > 1)
		printf(" and %zu like it", alike - 1);
	if (contacts[1] > 0) {
		print_contacts(contacts, alike > 1);
		print_passes_of(scene, passes, (int)first);
		return;
	}
	printf(": %s", layout_number(least).text);
	if (most > least)
		printf(" to %s", layout_number(most).text);
	printf(" %s%s, a window or more each on ground\n", most == 1 ? "path sample" : "path samples", alike > 1 ? " each" : "");
	print_passes_of(scene, passes, (int)first);
}

static void print_passes(const struct scene *scene, const struct report_plan *plan)
{
	if (count_of(&plan->plan, PLAN_PASS) == 0)
		return;
	const struct passes passes = {
		.all = plan,
		.first = mem_alloc(plan->body_count + 1, sizeof *passes.first),
		.next = mem_alloc(plan->plan.count, sizeof *passes.next),
	};
	puts("\npasses");
	if (passes.first != NULL && passes.next != NULL) {
		list_passes(&passes);
		for (size_t i = 0; i < plan->body_count; i++)
			print_object(scene, &passes, i);
		if (pass_of(&passes, -1, 0) != NULL) {
			if (plan->body_count > 0)
				puts("  besides");
			print_passes_of(scene, &passes, -1);
		}
	} else {
		puts("  out of memory: they cannot be listed");
	}
	mem_free(passes.first);
	mem_free(passes.next);
}

static void print_threads(const struct scene *scene, const struct plan *plan)
{
	int64_t threads = 0;
	for (size_t i = 0; i < plan->count; i++)
		threads += is_of(&plan->lines[i], PLAN_THREAD) ? plan->lines[i].amount : 0;
	printf("\nthreads: %lld besides the one that steps\n", (long long)threads);
	for (size_t i = 0; i < plan->count; i++) {
		const struct plan_line *line = &plan->lines[i];
		char what[160], why[160];
		if (!is_of(line, PLAN_THREAD))
			continue;
		snprintf(what, sizeof what, "  %-12s %lld", line->name, (long long)line->amount);
		line_reason(scene, line, why, sizeof why);
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
		if (!is_of(line, PLAN_STATEMENT) || strcmp(line->name, name) != 0)
			continue;
		if (i < first)
			return;
		snprintf(what, sizeof what, "  %-14s %lld %s", i == first ? name : "", (long long)line->amount, each_of(line->unit));
		line_reason(scene, line, why, sizeof why);
		layout_row(what, why);
	}
}

static void print_tables(const struct scene *scene, const struct plan *plan)
{
	puts("\ntables");
	for (size_t i = 0; i < plan->count; i++)
		if (is_of(&plan->lines[i], PLAN_STATEMENT))
			print_table(scene, plan, i);
}

/* --- what it takes --- */

static bool is_memory(const struct plan_line *line)
{
	return is_of(line, PLAN_TEXTURE) || is_of(line, PLAN_BUFFER);
}

/* What of a unit is there for one reason, where its first line is. */
static void print_bytes(const struct scene *scene, const struct plan *plan, size_t first)
{
	const struct plan_line *head = &plan->lines[first];
	uint64_t bytes = 0;
	char what[160], why[160], other[160];
	line_reason(scene, head, why, sizeof why);
	for (size_t i = 0; i < plan->count; i++) {
		const struct plan_line *line = &plan->lines[i];
		if (!is_memory(line) || line->unit != head->unit)
			continue;
		if (!same_effect(line, head)) {
			line_reason(scene, line, other, sizeof other);
			if (strcmp(other, why) != 0)
				continue;
		}
		if (i < first)
			return;
		bytes += line->bytes;
	}
	snprintf(what, sizeof what, "  %-12s %s", layout_bytes(bytes).text, each_of(head->unit));
	if (bytes > 0)
		layout_row(what, why);
}

static void print_memory(const struct scene *scene, const struct report_plan *plan)
{
	const uint64_t few = plan->most.slots + plan->most.loads + plan->most.queue_few + plan->most.ground;
	char most[640], asked[96] = "";
	puts("\nmemory");
	for (int unit = 0; unit < PLAN_UNITS; unit++)
		for (size_t i = 0; i < plan->plan.count; i++)
			if (is_memory(&plan->plan.lines[i]) && (int)plan->plan.lines[i].unit == unit)
				print_bytes(scene, &plan->plan, i);
	if (scene->memory > 0)
		snprintf(asked, sizeof asked, " of cache.memory: %s", layout_bytes(scene->memory).text);
	snprintf(most, sizeof most, "for tiles %s%s (%s in %u slots, %s in loads, %s in %u tiles of base heights and those of loaders%s, %s in "
				    "%u changed tiles) while no more changed tiles are on their way; %s in the worst step that there can be",
		 layout_bytes(few).text, asked, layout_bytes(plan->most.slots).text, plan->tiles.slots, layout_bytes(plan->most.loads).text,
		 layout_bytes(plan->most.ground).text, plan->tiles.ground, plan->tiles.queries > 0 ? " and queries" : "",
		 layout_bytes(plan->most.queue_few).text, plan->tiles.changed,
		 layout_bytes(few + plan->most.queue - plan->most.queue_few).text);
	layout_wrapped(most, 4);
}

static void print_not_run(const struct report_plan *plan)
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

static void print_notes(const struct report_plan *plan)
{
	if (plan->note_count > 0)
		puts("\nnotes");
	for (size_t i = 0; i < plan->note_count; i++)
		layout_wrapped(plan->notes[i], 4);
}

void explain_text(const struct scene *scene, const struct report_plan *plan)
{
	print_head(scene, plan);
	print_notes(plan);
	print_effects(scene, plan);
	print_rasters(plan);
	explain_soils_text(scene);
	explain_vehicles_text(plan);
	explain_sun_text(plan);
	explain_cameras_text(scene, plan);
	print_planes(scene, plan);
	print_programs(scene, &plan->plan);
	print_passes(scene, plan);
	print_threads(scene, &plan->plan);
	print_tables(scene, &plan->plan);
	print_memory(scene, plan);
	print_not_run(plan);
	if (plan->note_count > 0) /* a terminal shows the end */
		printf("\n%zu note%s: see the top\n", plan->note_count, plan->note_count == 1 ? "" : "s");
}
