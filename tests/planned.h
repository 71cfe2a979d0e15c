/* A drive's plan, put together from its parts' lines. */
#ifndef FURROW_TESTS_PLANNED_H
#define FURROW_TESTS_PLANNED_H

#include "deform/deform.h"
#include "render/render.h"
#include "run/pages.h"
#include "run/scout.h"
#include "support.h"

static inline void planned(const struct scene *scene, const char *path, struct plan *plan)
{
	struct store *store;
	must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	const struct store_meta *meta = store_meta(store);
	int level = 0;
	bool was = store_has_working_level(store, &level);
	if (scene->spacing > 0)
		level = world_level_for(&meta->world, scene->spacing);
	struct deform_params params = {
		.world = &meta->world, .level = level, .model = scene->model, .box_radius = scene->box_radius,
		.box_repetitions = scene->box_repetitions, .soil_count = scene->soil_count, .iterations = scene->iterations,
		.depth = scene->depth, .stands = scene->undisturbed == SCENE_STANDS, .bulldozing = scene->bulldozing,
		.dirt = scene->dirt, .relief = isnan(meta->low) ? 0 : meta->high - meta->low,
	};
	memcpy(params.soils, scene->soils, sizeof params.soils);
	struct deform_planned objects[64];
	assert_true(scene->object_count <= 64);
	for (size_t i = 0; i < scene->object_count; i++) {
		const struct scene_object *object = &scene->objects[i];
		objects[i] = (struct deform_planned){&object->shape, object->load, object->path.count > 1};
		params.carriers += object->load > 0;
	}
	unsigned planes = pages_planes_of(scene, was);
	bool deformed = planes != 0;
	*plan = (struct plan){NULL, 0, 0, false};
	deform_plan(&params, objects, scene->object_count, scene->forces > 0, plan);
	const char *effect = plan->count > 0 ? plan->lines[0].effect : NULL;
	gpu_slots_plan(meta->world.cells, planes, scene->soil_map != NULL && scene->object_count > 0, level < 0,
		       deformed && scene->view.present, effect, plan);
	if (scene->view.present)
		render_plan(&(struct render_params){.world = &meta->world, .width = scene->view.width, .height = scene->view.height,
						    .effects = scene->view.effects, .dirt = scene->dirt},
			    deformed, level < 0, plan);
	pages_plan(scene, meta->world.cells, was, plan);
	scout_plan(scene->prefetch, scene->object_count, plan);
	must(plan_status(plan));
	store_close(store);
}

#endif
