/* A growing list of what will be used; see plan.h. */
#include "base/plan.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "base/memory.h"

static bool is_there(const struct plan *plan, enum plan_kind kind, const char *name)
{
	for (size_t i = 0; i < plan->count; i++)
		if (plan->lines[i].kind == kind && strcmp(plan->lines[i].name, name) == 0)
			return true;
	return false;
}

void plan_add(struct plan *plan, const struct plan_line *line, const char *name)
{
	struct plan_line added = *line;
	snprintf(added.name, sizeof added.name, "%s", name);
	bool one = line->kind == PLAN_PROGRAM || line->kind == PLAN_PLANE || line->kind == PLAN_THREAD;
	if (plan->failed || (one && is_there(plan, line->kind, added.name)))
		return;
	plan->failed = mem_grow(&plan->lines, &plan->room, plan->count + 1, sizeof *plan->lines, "the plan") != STATUS_OK;
	if (!plan->failed)
		plan->lines[plan->count++] = added;
}

enum status plan_status(const struct plan *plan)
{
	return plan->failed ? fail_memory("the plan") : STATUS_OK;
}

void plan_finish(struct plan *plan)
{
	mem_free(plan->lines);
	*plan = (struct plan){.lines = NULL};
}

const char *plan_kind_name(enum plan_kind kind)
{
	static const char *const names[PLAN_KINDS] = {
		[PLAN_PLANE] = "plane", [PLAN_PROGRAM] = "program", [PLAN_PASS] = "pass", [PLAN_TEXTURE] = "texture",
		[PLAN_BUFFER] = "buffer", [PLAN_THREAD] = "thread", [PLAN_STATEMENT] = "statement",
	};
	assert((unsigned)kind < PLAN_KINDS);
	return names[kind];
}

const char *plan_unit_name(enum plan_unit unit)
{
	static const char *const names[PLAN_UNITS] = {
		[PLAN_ONCE] = "once", [PLAN_BASE_SLOT] = "base_slot", [PLAN_CLASS_SLOT] = "class_slot",
		[PLAN_DEFORM_SLOT] = "deform_slot", [PLAN_STATE_SLOT] = "state_slot",
		[PLAN_BASE_ARRAY] = "base_array", [PLAN_BASE_LAYER] = "base_layer", [PLAN_DEFORM_ARRAY] = "deform_array",
		[PLAN_DEFORM_LAYER] = "deform_layer", [PLAN_PATCH] = "patch",
		[PLAN_PAGE] = "page", [PLAN_WINDOW_LAYER] = "window_layer", [PLAN_RESULT_LAYER] = "result_layer",
		[PLAN_RING] = "ring",
		[PLAN_HOST_BASE] = "host_base", [PLAN_HOST_CLASSES] = "host_classes", [PLAN_HOST_NUMBERS] = "host_numbers",
		[PLAN_HOST_OFFSET] = "host_offset", [PLAN_HOST_DISTURBANCE] = "host_dirt", [PLAN_HOST_DEPOSITED] = "host_heaped",
		[PLAN_HOST_SINKAGE] = "host_pressed", [PLAN_HOST_SHEAR] = "host_shear", [PLAN_HOST_DUG] = "host_dug",
		[PLAN_HOST_SETTLED] = "host_settled", [PLAN_HOST_LOOSE] = "host_loose", [PLAN_HOST_FLOOR] = "host_floor", [PLAN_HOST_DENSITY] = "host_density",
		[PLAN_HOST_SLOPE] = "host_slope", [PLAN_HOST_HEALED] = "host_healed", [PLAN_HOST_RISEN] = "host_risen", [PLAN_HOST_GROWN] = "host_grown",
		[PLAN_WINDOW_POST] = "window_post", [PLAN_WINDOW_SCRATCH] = "window_scratch", [PLAN_RESULT_POST] = "result_post",
		[PLAN_WINDOW] = "window", [PLAN_MOVED] = "moved", [PLAN_BATCH] = "batch", [PLAN_BATCH_DRAW] = "batch_draw",
		[PLAN_BATCH_STORE] = "batch_store", [PLAN_BATCH_ENVELOPE] = "batch_underside",
		[PLAN_FACETS] = "facets",
		[PLAN_HELD] = "held", [PLAN_RESTING] = "resting", [PLAN_ATLAS] = "atlas", [PLAN_DECIMATED] = "decimated",
		[PLAN_SUBDIVIDED] = "subdivided", [PLAN_DRAWN] = "drawn", [PLAN_OBJECTS] = "objects",
		[PLAN_SHADOWED] = "shadowed", [PLAN_FRAME] = "frame", [PLAN_LOADED] = "loaded",
		[PLAN_LOADED_COARSER] = "loaded_coarser", [PLAN_READ] = "read", [PLAN_RANGE] = "range",
		[PLAN_OFFSET_RANGE] = "offset_range",
		[PLAN_COMMITTED] = "committed", [PLAN_COMMITTED_COARSER] = "committed_coarser",
		[PLAN_CHANGED] = "changed", [PLAN_LEFT] = "left", [PLAN_INHERITED] = "inherited", [PLAN_KEPT] = "kept", [PLAN_SOUGHT] = "sought",
		[PLAN_COMMIT] = "epoch",
	};
	assert((unsigned)unit < PLAN_UNITS);
	return names[unit];
}
