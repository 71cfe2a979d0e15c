/* furrow explain: bodies, and what they and all else run. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "explain.h"
#include "explain_layout.h"
#include "soil/kinematic/sheet.h"

bool explain_same_effect(const struct plan_line *a, const struct plan_line *b)
{
	return a->effect == b->effect || (a->effect != NULL && b->effect != NULL && strcmp(a->effect, b->effect) == 0);
}

size_t explain_count(const struct plan *plan, enum plan_kind kind)
{
	size_t count = 0;
	for (size_t i = 0; i < plan->count; i++)
		count += plan->lines[i].kind == kind;
	return count;
}

/* Returns the words that stand after an amount: "a window" in "8 a window". */
const char *explain_each_of(enum plan_unit unit)
{
	static const char *const words[PLAN_UNITS] = {
		[PLAN_ONCE] = "once",
		[PLAN_BASE_SLOT] = "a tile in a slot",
		[PLAN_CLASS_SLOT] = "a tile in a slot, with classes",
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
		[PLAN_RING] = "a segment of parameters",
		[PLAN_HOST_BASE] = "a tile in memory",
		[PLAN_HOST_CLASSES] = "a tile in memory with classes of soil",
		[PLAN_HOST_NUMBERS] = "a tile in memory with numbers of the soil",
		[PLAN_HOST_OFFSET] = "a deformed tile in memory",
		[PLAN_HOST_DISTURBANCE] = "a deformed tile in memory",
		[PLAN_HOST_DEPOSITED] = "a tile in memory with loose soil",
		[PLAN_HOST_SINKAGE] = "a tile in memory that was borne on",
		[PLAN_HOST_SHEAR] = "a tile in memory that was sheared",
		[PLAN_HOST_DUG] = "a tile in memory that was dug",
		[PLAN_HOST_SETTLED] = "a tile in memory that was borne on",
		[PLAN_HOST_LOOSE] = "a tile in memory that was borne on",
		[PLAN_HOST_FLOOR] = "a tile in memory that was borne on",
		[PLAN_HOST_DENSITY] = "a tile in memory that was passed over",
		[PLAN_HOST_SLOPE] = "a tile in memory whose soil slides",
		[PLAN_HOST_HEALED] = "a tile in memory with marks that fade",
		[PLAN_HOST_RISEN] = "a tile in memory with pressed plants",
		[PLAN_HOST_GROWN] = "a tile in memory with torn plants",
		[PLAN_WINDOW_POST] = "a post of the largest window",
		[PLAN_WINDOW_SCRATCH] = "a byte of scratch memory beside it",
		[PLAN_RESULT_POST] = "a post of blocks that slide",
		[PLAN_WINDOW] = "a window",
		[PLAN_MOVED] = "a window that it moved over",
		[PLAN_REGION] = "a fixed region, of four at most",
		[PLAN_REGION_MOVED] = "a fixed region that it moved over, of four at most",
		[PLAN_BATCH] = "a batch of windows",
		[PLAN_BATCH_DRAW] = "an array, or bodies of a kind, in a batch",
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
	return a->unit == b->unit && a->amount == b->amount && strcmp(a->name, b->name) == 0 && explain_same_effect(a, b);
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
		if (plan->lines[i].kind != PLAN_PASS)
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
	if (all->bodies[a].shape->kind != all->bodies[b].shape->kind || (all->bodies[a].contacts > 0) != (all->bodies[b].contacts > 0) ||
	    (all->bodies[a].contacts < 0) != (all->bodies[b].contacts < 0))
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
		snprintf(what, sizeof what, "    %-10s %2lld %s", line->name, (long long)line->amount, explain_each_of(line->unit));
		explain_reason(scene, line->effect, why, sizeof why);
		layout_row(what, why);
	}
}

/* A soil geom's contacts depend on the motion. */
static void print_contacts(const double contacts[2], bool each, bool bearing)
{
	printf(": about %.3g", contacts[0]);
	if (contacts[1] > 1.005 * contacts[0])
		printf(" to %.3g", contacts[1]);
	printf(" contacts a metre%s,\n    where it rolls without slip or slides on the level; more where it slips, sinks or turns back,\n"
	       "    at most one a time step; %s at each over ground\n", each ? " each" : "", bearing ? "one window, on the CPU," : "a window or more");
}

/* Prints the sums of an object's passes, by what they are run for. */
static void print_sums(const struct passes *passes, int object, const char *before)
{
	const struct plan_line *line;
	char text[1024] = "";
	size_t used = 0;
	for (int unit = 0; unit < PLAN_UNITS; unit++) {
		int64_t sum = 0;
		for (size_t nth = 0; (line = pass_of(passes, object, nth)) != NULL; nth++)
			sum += (int)line->unit == unit ? line->amount : 0;
		if (sum > 0 && used < sizeof text)
			used += (size_t)snprintf(text + used, sizeof text - used, "%s%lld %s", used > 0 ? ", " : before, (long long)sum,
						 explain_each_of((enum plan_unit)unit));
	}
	if (used > 0 && object >= 0)
		printf("    %s\n", text);
	else if (used > 0)
		layout_wrapped(text, 4);
}

/* Prints how many posts are below the bodies, if that is known of all. */
static void print_below(const double over[2], double spacing, bool each)
{
	if (!(over[0] > 0) || !isfinite(over[0]))
		return;
	char least[24], most[24];
	snprintf(least, sizeof least, "%.2g", over[0] / spacing);
	snprintf(most, sizeof most, "%.2g", over[1] / spacing);
	printf("    %s", least);
	if (over[1] > 1.005 * over[0])
		printf(" to %s", most);
	printf(" post%s below %s: the soil bears it over about %.2g m\n",
	       strcmp(least, "1") == 0 && strcmp(most, "1") == 0 ? "" : "s", each ? "each" : "it", over[0]);
}

/* The object or the soil geom, and those like it, where it is the first of them. */
static void print_object(const struct scene *scene, const struct passes *passes, size_t first, bool all)
{
	const struct report_plan *plan = passes->all;
	size_t alike = 0;
	uint64_t least = UINT64_MAX, most = 0;
	double contacts[2] = {INFINITY, 0}, over[2] = {INFINITY, 0};
	for (size_t i = 0; i < plan->body_count; i++) {
		if (!are_alike(passes, (int)first, (int)i))
			continue;
		if (i < first)
			return;
		alike++;
		contacts[0] = fmin(contacts[0], plan->bodies[i].contacts);
		contacts[1] = fmax(contacts[1], plan->bodies[i].contacts);
		over[0] = fmin(over[0], plan->bodies[i].over);
		over[1] = fmax(over[1], plan->bodies[i].over);
		if (i >= scene->object_count)
			continue;
		least = plan->samples[i] < least ? plan->samples[i] : least;
		most = plan->samples[i] > most ? plan->samples[i] : most;
	}
	printf("  %s", plan->bodies[first].name);
	if (alike > 1)
		printf(" and %zu like it", alike - 1);
	if (contacts[0] < 0) {
		printf(": %s the ground only where %s\n", alike > 1 ? "touch" : "touches", alike > 1 ? "they come down" : "it comes down");
	} else if (contacts[1] > 0) {
		print_contacts(contacts, alike > 1, plan->bearing);
	} else {
		printf(": %s", layout_number(least).text);
		if (most > least)
			printf(" to %s", layout_number(most).text);
		printf(" %s%s, %s on ground\n", most == 1 ? "path sample" : "path samples", alike > 1 ? " each" : "",
		       plan->bearing ? "one window each, on the CPU," : "a window or more each");
	}
	if (all) {
		print_passes_of(scene, passes, (int)first);
		return;
	}
	print_below(over, plan->spacing, alike > 1);
	print_sums(passes, (int)first, "passes: ");
}

static void print_besides(const struct scene *scene, const struct passes *passes, bool all)
{
	if (pass_of(passes, -1, 0) == NULL)
		return;
	if (!all) {
		print_sums(passes, -1, passes->all->body_count > 0 ? "passes besides: " : "passes: ");
		return;
	}
	if (passes->all->body_count > 0)
		puts("  besides");
	print_passes_of(scene, passes, -1);
}

static void print_all_passes(const struct scene *scene, const struct report_plan *plan, bool all)
{
	const struct passes passes = {
		.all = plan,
		.first = mem_alloc(plan->body_count + 1, sizeof *passes.first),
		.next = mem_alloc(plan->plan.count, sizeof *passes.next),
	};
	if (passes.first != NULL && passes.next != NULL) {
		list_passes(&passes);
		for (size_t i = 0; i < plan->body_count; i++)
			print_object(scene, &passes, i, all);
		print_besides(scene, &passes, all);
	} else {
		puts("  out of memory: they cannot be listed");
	}
	mem_free_all(passes.first, passes.next);
}

/* Tells what a contact with an elastic sheet costs. On the CPU it has no passes. */
static void print_sheet(const struct scene *scene, double spacing)
{
	struct soil_sheet sheet;
	const double length = sqrt(scene->tension / scene->stiffness);
	if (!deform_is_elastic(scene->model) || !(spacing > 0) || length > SOIL_SHEET_POSTS * spacing)
		return;
	soil_sheet_prepare(&sheet, length, scene->yield, scene->rut, spacing);
	printf("  the sheet bends over %.3g m, %.3g posts: each contact makes %d rounds over all posts within %d of the body\n", length, length / spacing, sheet.rounds,
	       (int)sheet.reach);
}

/* Bearing soil has bodies, and may have no pass. With --all, passes are listed by body. */
static void print_section(const struct scene *scene, const struct report_plan *plan, bool all)
{
	const bool passes = explain_count(&plan->plan, PLAN_PASS) > 0, bodies = plan->body_count > 0;
	if (!passes && !(bodies && plan->bearing))
		return;
	puts(!passes ? "\nbodies" : bodies && !all ? "\nbodies, and passes" : "\npasses");
	print_all_passes(scene, plan, all);
	if (bodies)
		print_sheet(scene, plan->spacing);
}

void explain_passes_text(const struct scene *scene, const struct report_plan *plan)
{
	print_section(scene, plan, true);
}

void explain_bodies_text(const struct scene *scene, const struct report_plan *plan)
{
	print_section(scene, plan, false);
}
