/* The "where" of run.json: the regions in which an effect worked, and those in which it might have worked. api.h has the units. */
#include "base/json.h"
#include "report/report.h"

static void add(cJSON *where, const char *name, uint64_t visited, uint64_t possible)
{
	cJSON *effect = cJSON_AddObjectToObject(where, name);
	json_integer(effect, "visited", (int64_t)visited);
	json_integer(effect, "possible", (int64_t)possible);
}

static void add_windows(cJSON *where, const struct report *report, const struct gpu_stats *gpu)
{
	const enum deform_model model = world_scene(report->world)->model;
	const uint64_t used = world_effects(report->world);
	for (int effect = EFFECT_MODEL; effect <= EFFECT_VEGETATION; effect++) {
		uint64_t visited = world_counts(report->world)->windows.computed;
		if ((effect > EFFECT_SPREAD && effect < EFFECT_DISTURBANCE) || (used >> effect & 1) == 0)
			continue;
		if (deform_model_row(model)->smooths && effect == (int)EFFECT_OF(model)) /* not where an object is only at rest */
			visited = gpu->passes[GPU_SMOOTH] / (uint64_t)world_scene(report->world)->box_repetitions;
		add(where, scene_effect_row((enum scene_effect)effect)->name, visited, world_counts(report->world)->windows.due);
	}
}

static void add_slots(cJSON *where, const struct report *report)
{
	struct gpu_slots_figures slots;
	struct resident_host_in_slots in;
	if (world_resident(report->world)->host != NULL) {
		resident_host_in_slots(world_resident(report->world)->host, &in);
		add(where, "slots", in.deformed, in.bases);
		return;
	}
	gpu_slots_figures(world_resident(report->world)->slots, &slots);
	add(where, "slots", slots.deform_slots, slots.base_slots);
}

void report_where(cJSON *root, const struct report *report, const struct gpu_stats *gpu)
{
	cJSON *where = cJSON_AddObjectToObject(root, "where");
	add_windows(where, report, gpu);
	for (int effect = EFFECT_SHED; effect <= EFFECT_SLIDE; effect++)
		if (world_effects(report->world) >> effect & 1)
			add(where, scene_effect_row((enum scene_effect)effect)->name, world_counts(report->world)->visited, world_counts(report->world)->possible);
	if (report->view != NULL) {
		struct resident_pyramid_figures pyramid;
		struct render_view_figures view;
		resident_pyramid_figures(world_resident(report->world)->pyramid, &pyramid);
		render_view_figures(report->view, &view);
		add(where, "pyramid", pyramid.updated, pyramid.resident);
		add(where, "draw", view.tiles.deformed, view.tiles.drawn);
	}
	add_slots(where, report);
}
