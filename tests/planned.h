/* A drive's plan, and the effects that it calls for. */
#ifndef FURROW_TESTS_PLANNED_H
#define FURROW_TESTS_PLANNED_H

#include "drive/drive.h"
#include "support.h"

static bool planned_history; /* the drives keep a history */

static inline uint64_t planned(const struct scene *scene, const char *path, struct plan *plan)
{
	struct report_plan whole;
	must(report_plan(scene, path, planned_history, &whole));
	uint64_t effects = whole.effects;
	*plan = whole.plan;
	whole.plan = (struct plan){.lines = NULL};
	report_plan_finish(&whole);
	return effects;
}

#endif
