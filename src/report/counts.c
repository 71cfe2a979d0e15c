/*
 * The "counts" of run.json: what a drive made and ran, named as in plans (base/plan.h).
 *
 * Lasting things (programs, textures, bytes, threads, units of memory) and the store's statements are counted from the
 * process's start, with warming up. Passes and units of work are counted from the first step.
 */
#include "base/json.h"
#include "base/plan.h"
#include "report/report.h"

static void add_program(void *user, const char *name, uint64_t passes)
{
	cJSON *program = cJSON_CreateObject();
	cJSON_AddStringToObject(program, "name", name);
	json_integer(program, "passes", (int64_t)passes);
	cJSON_AddItemToArray(user, program);
}

static void add_statements(cJSON *counts, const struct report *report)
{
	struct store_statements statements;
	store_statements(world_resident(report->world)->store, &statements);
	cJSON *tables = cJSON_AddObjectToObject(counts, "statements");
	for (int table = 0; table < STORE_TABLES; table++) {
		if (statements.read[table] == 0 && statements.written[table] == 0)
			continue;
		cJSON *object = cJSON_AddObjectToObject(tables, store_table_name((enum store_table)table));
		json_integer(object, "read", (int64_t)statements.read[table]);
		json_integer(object, "write", (int64_t)statements.written[table]);
	}
}

static void add_unit(cJSON *units, enum plan_unit unit, uint64_t count)
{
	json_integer(units, plan_unit_name(unit), (int64_t)count);
}

/* Tiles in host memory, and the memory of bearing soil; all are 0 where the home of pages is the GPU. */
static void add_host_units(cJSON *units, const struct report *report)
{
	struct resident_host_figures host = {.bases = 0};
	struct bearing_figures bearing = {.window_posts = 0};
	if (world_resident(report->world)->host != NULL)
		resident_host_figures(world_resident(report->world)->host, &host);
	if (world_bearing(report->world) != NULL)
		bearing_figures(world_bearing(report->world), &bearing);
	add_unit(units, PLAN_HOST_BASE, host.bases);
	add_unit(units, PLAN_HOST_CLASSES, host.classes);
	add_unit(units, PLAN_HOST_NUMBERS, host.levels);
	for (int plane = 0; plane < PLANES; plane++)
		add_unit(units, (enum plan_unit)(PLAN_HOST_OFFSET + plane), host.planes[plane]);
	add_unit(units, PLAN_WINDOW_POST, bearing.window_posts);
	add_unit(units, PLAN_WINDOW_SCRATCH, bearing.scratch_bytes);
	add_unit(units, PLAN_RESULT_POST, bearing.result_posts);
}

/* Returns all bytes that plans have lines of: textures and buffers of the GPU, and memory in the place of slots. */
static uint64_t all_bytes(const struct report *report, const struct gpu_stats *gpu, const struct resident_pages_io *io)
{
	struct bearing_figures bearing = {.bytes = 0};
	if (world_bearing(report->world) != NULL)
		bearing_figures(world_bearing(report->world), &bearing);
	return gpu->bytes + bearing.bytes + world_grains_bytes(report->world) + world_carried_bytes(report->world) + (world_resident(report->world)->host != NULL ? io->host_bytes : 0);
}

static void add_memory_units(cJSON *units, const struct report *report, const struct gpu_stats *gpu, const struct resident_pages_io *io,
			     const struct gpu_slots_figures *slots, const struct deform_figures *deform)
{
	add_unit(units, PLAN_BASE_SLOT, slots->base_slots);
	add_unit(units, PLAN_CLASS_SLOT, slots->class_slots);
	add_unit(units, PLAN_DEFORM_SLOT, slots->deform_slots);
	add_unit(units, PLAN_STATE_SLOT, slots->state_slots);
	add_unit(units, PLAN_BASE_ARRAY, slots->base_arrays);
	add_unit(units, PLAN_BASE_LAYER, slots->base_layers);
	add_unit(units, PLAN_DEFORM_ARRAY, slots->deform_arrays);
	add_unit(units, PLAN_DEFORM_LAYER, slots->deform_layers);
	add_unit(units, PLAN_PATCH, slots->patches);
	add_unit(units, PLAN_PAGE, io->changed_images);
	add_unit(units, PLAN_WINDOW_LAYER, deform->window_layers);
	add_unit(units, PLAN_RESULT_LAYER, deform->result_layers);
	add_unit(units, PLAN_RING, gpu->ring_segments);
	add_host_units(units, report);
}

static void add_object_units(cJSON *units, const struct report *report)
{
	cJSON *windows = cJSON_AddObjectToObject(units, plan_unit_name(PLAN_WINDOW));
	cJSON *moved = cJSON_AddObjectToObject(units, plan_unit_name(PLAN_MOVED));
	cJSON *regions = cJSON_AddObjectToObject(units, plan_unit_name(PLAN_REGION));
	cJSON *regions_moved = cJSON_AddObjectToObject(units, plan_unit_name(PLAN_REGION_MOVED));
	for (size_t i = 0; i < world_body_count(report->world); i++) {
		const struct body *body = world_body(report->world, i);
		if (body == NULL)
			continue;
		json_integer(windows, body->object->name, (int64_t)body->windows);
		json_integer(moved, body->object->name, (int64_t)body->windows_moved);
		json_integer(regions, body->object->name, (int64_t)body->regions);
		json_integer(regions_moved, body->object->name, (int64_t)body->regions_moved);
	}
}

static void add_table_units(cJSON *units, const struct report *report, const struct pages_counts *pages)
{
	unsigned planes = world_planes(report->world);
	cJSON *changed = cJSON_AddObjectToObject(units, plan_unit_name(PLAN_CHANGED));
	cJSON *left = cJSON_AddObjectToObject(units, plan_unit_name(PLAN_LEFT));
	for (int plane = 0; plane < PLANES; plane++) {
		json_integer(changed, plane_name((enum plane)plane), pages->changed[plane]);
		if (!((planes | GPU_DRAWN_PLANES) & PLANE_BIT(plane)))
			json_integer(left, plane_name((enum plane)plane), pages->looked_up[plane]);
	}
	json_integer(changed, store_table_name(STORE_META_TABLE), pages->header);
	struct store_statements statements;
	store_statements(world_resident(report->world)->store, &statements);
	cJSON *inherited = cJSON_AddObjectToObject(units, plan_unit_name(PLAN_INHERITED));
	cJSON *kept = cJSON_AddObjectToObject(units, plan_unit_name(PLAN_KEPT));
	for (int plane = 0; plane < PLANES; plane++) {
		json_integer(inherited, plane_name((enum plane)plane), (int64_t)statements.inherited[STORE_OFFSET_TABLE + plane]);
		json_integer(kept, plane_name((enum plane)plane), (int64_t)statements.kept[STORE_OFFSET_TABLE + plane]);
	}
	json_integer(kept, store_table_name(STORE_HISTORY_TABLE), (int64_t)statements.kept[STORE_HISTORY_TABLE]);
	json_integer(kept, store_table_name(STORE_REVISION_TABLE), (int64_t)statements.kept[STORE_REVISION_TABLE]);
	add_unit(units, PLAN_SOUGHT, statements.sought);
}

static void add_units(cJSON *counts, const struct report *report, const struct gpu_stats *gpu, const struct resident_pages_io *io)
{
	struct gpu_slots_figures slots;
	struct deform_figures deform = {.window_layers = 0};
	struct resident_ground_figures ground;
	struct render_view_figures view = {.frames = 0};
	if (report->view != NULL)
		render_view_figures(report->view, &view);
	gpu_slots_figures(world_resident(report->world)->slots, &slots);
	if (world_deform(report->world) != NULL)
		deform_figures(world_deform(report->world), &deform);
	resident_ground_figures(world_resident(report->world)->ground, &ground);
	cJSON *units = cJSON_AddObjectToObject(counts, "units");
	add_memory_units(units, report, gpu, io, &slots, &deform);
	add_object_units(units, report);
	add_unit(units, PLAN_BATCH, deform.batches);
	add_unit(units, PLAN_BATCH_DRAW, deform.batch_draws);
	add_unit(units, PLAN_BATCH_STORE, deform.batch_stores);
	add_unit(units, PLAN_BATCH_ENVELOPE, deform.batch_envelopes);
	add_unit(units, PLAN_FACETS, deform.facets);
	add_unit(units, PLAN_HELD, deform.held);
	add_unit(units, PLAN_RESTING, deform.resting);
	add_unit(units, PLAN_ATLAS, deform.atlases);
	add_unit(units, PLAN_DECIMATED, slots.decimated - world_counts(report->world)->warmed.slots.decimated);
	add_unit(units, PLAN_SUBDIVIDED, slots.subdivided - world_counts(report->world)->warmed.slots.subdivided);
	add_unit(units, PLAN_DRAWN, view.tiles.drawn);
	add_unit(units, PLAN_OBJECTS, view.tiles.objects);
	add_unit(units, PLAN_SHADOWED, view.tiles.shadowed);
	add_unit(units, PLAN_FRAME, view.frames);
	add_unit(units, PLAN_LOADED, (uint64_t)io->counts.loaded);
	add_unit(units, PLAN_LOADED_COARSER, (uint64_t)io->counts.loaded_coarser);
	add_unit(units, PLAN_READ, (uint64_t)io->counts.bases + ground.reads);
	add_unit(units, PLAN_RANGE, (uint64_t)io->counts.ranges + ground.ranges);
	add_unit(units, PLAN_OFFSET_RANGE, ground.offset_ranges);
	add_unit(units, PLAN_COMMITTED, (uint64_t)io->counts.committed);
	add_unit(units, PLAN_COMMITTED_COARSER, (uint64_t)io->counts.committed_coarser);
	add_table_units(units, report, &io->counts);
	add_unit(units, PLAN_COMMIT, (uint64_t)io->commits);
}

void report_counts(cJSON *root, const struct report *report, const struct gpu_stats *gpu, const struct resident_pages_io *io)
{
	cJSON *counts = cJSON_AddObjectToObject(root, "counts");
	gpu_programs_each(world_resident(report->world)->gpu, add_program, cJSON_AddArrayToObject(counts, "programs"));
	json_integer(counts, "unplanned", gpu->unplanned);
	json_integer(counts, "textures", gpu->textures);
	json_integer(counts, "bytes", (int64_t)all_bytes(report, gpu, io));
	json_integer(counts, "threads", report->threads);
	cJSON *passes = cJSON_AddObjectToObject(counts, "passes");
	for (int stage = 0; stage < GPU_STAGES; stage++)
		if (gpu->passes[stage] > 0)
			json_integer(passes, gpu_stage_name((enum gpu_stage)stage), (int64_t)gpu->passes[stage]);
	add_statements(counts, report);
	add_units(counts, report, gpu, io);
}
