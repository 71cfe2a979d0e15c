/* The plan of a drive's pages: threads, staging memory, statements. */
#include <stdio.h>
#include <string.h>

#include "resident/pages_internal.h"

/* Returns the effect of the plan's line for that plane; NULL: only earlier drives left it. */
static const char *effect_of(const struct plan *plan, enum plane plane)
{
	for (size_t i = 0; i < plan->count; i++)
		if (plan->lines[i].kind == PLAN_PLANE && strcmp(plan->lines[i].name, plane_name(plane)) == 0)
			return plan->lines[i].effect;
	return NULL;
}

static void add_threads(const struct pages_planned *planned, struct plan *plan)
{
	plan_add(plan, &(struct plan_line){.kind = PLAN_THREAD, .object = -1, .amount = 1}, PAGE_WRITER_THREAD);
	if (planned->loaders > 0)
		plan_add(plan, &(struct plan_line){.kind = PLAN_THREAD, .effect = planned->loaders_effect, .object = -1,
						   .amount = planned->loaders}, PAGE_LOADER_THREAD);
}

static void add_staging(struct plan *plan, enum plan_unit unit, const char *effect, int64_t amount, uint64_t bytes,
			const char *what, const char *of)
{
	char name[64];
	snprintf(name, sizeof name, "%s: %s", what, of);
	plan_add(plan, &(struct plan_line){.kind = PLAN_BUFFER, .unit = unit, .effect = effect, .object = -1, .amount = amount,
					   .bytes = (uint64_t)amount * bytes}, name);
}

/* Adds each buffer by its parts, since each plane has its own reason. */
static void add_images(const struct pages_planned *planned, const struct pages_layout *layout,
		       const char *const effects[PLANES], struct plan *plan)
{
	uint32_t loads = page_load_images(planned->loaders);
	add_staging(plan, PLAN_ONCE, NULL, loads, layout->planes, "loads", "base");
	for (int plane = 0; plane < PLANES; plane++)
		if (planned->planes & PLANE_BIT(plane)) {
			size_t bytes = resident_pages_plane_room(layout, (enum plane)plane);
			add_staging(plan, PLAN_ONCE, effects[plane], loads, bytes, "loads", plane_name((enum plane)plane));
			add_staging(plan, PLAN_PAGE, effects[plane], 1, bytes, "changes", plane_name((enum plane)plane));
		}
	if (layout->loaded > layout->classes)
		add_staging(plan, PLAN_ONCE, planned->classes_effect, loads, layout->loaded - layout->classes, "loads", "classes");
	if (layout->classes > layout->numbers)
		add_staging(plan, PLAN_ONCE, planned->numbers_effect, loads, layout->classes - layout->numbers, "loads", "numbers");
}

void resident_pages_plan(const struct pages_planned *planned, struct plan *plan)
{
	const unsigned planes = planned->planes;
	const char *effects[PLANES];
	struct pages_layout layout = resident_pages_layout_of(planned->cells, planes, planned->classes, planned->numbers);
	for (int plane = 0; plane < PLANES; plane++)
		effects[plane] = effect_of(plan, (enum plane)plane);
	add_threads(planned, plan);
	if (planned->host)
		resident_host_plan(planned->cells, planes, planned->classes ? planned->classes_effect : NULL,
				   planned->numbers ? planned->numbers_effect : NULL, effects, plan);
	else
		add_images(planned, &layout, effects, plan);
	if (planned->deforms)
		add_staging(plan, PLAN_ONCE, effects[PLANE_OFFSET], 1, PAGES_TALLY_BYTES, "changes", "tally");
	store_plan_reads(plan, STORE_BASE_TABLE, 1, PLAN_READ, NULL);
	const char *picture = planned->picture_effect;
	bool shown = planned->picture && planned->was_deformed;
	if (planned->picture)
		store_plan_reads(plan, STORE_BASE_TABLE, 1, PLAN_RANGE, picture);
	/* Which tiles they are. */
	if (shown)
		store_plan_reads(plan, STORE_OFFSET_TABLE, 1, PLAN_ONCE, picture);
	/* Bounds of the drawn ground. Under models that raise nothing, also bounds for objects in the air. */
	if (shown || planned->lowers)
		store_plan_reads(plan, STORE_OFFSET_TABLE, 1, PLAN_OFFSET_RANGE, shown ? picture : effects[PLANE_OFFSET]);
	for (int plane = 0; plane < PLANES; plane++) {
		enum store_table table = (enum store_table)(STORE_OFFSET_TABLE + plane);
		if (planes & PLANE_BIT(plane))
			store_plan_reads(plan, table, 1, PLAN_LOADED, effects[plane]);
		if (planes & GPU_DRAWN_PLANES & PLANE_BIT(plane))
			store_plan_reads(plan, table, 1, PLAN_LOADED_COARSER, effects[plane]);
	}
	/* Looked for in the overlay first. */
	for (int plane = 0; plane < PLANES && planned->inherits && planned->was_deformed; plane++)
		store_plan_reads(plan, (enum store_table)(STORE_OFFSET_TABLE + plane), 1, PLAN_INHERITED, effects[plane]);
	/* How deep its ruts are. */
	if (planned->was_deformed)
		store_plan_reads(plan, STORE_OFFSET_TABLE, 1, PLAN_ONCE, NULL);
	/* The last drive's record, to see whether it could have been resumed. */
	store_plan_reads(plan, STORE_RUN_TABLE, 1, PLAN_ONCE, NULL);
	store_commit_plan(planned->deforms ? planes : 0, planned->was_deformed, effects, plan);
	if (planned->history)
		store_history_plan(planes, effects, plan);
}
