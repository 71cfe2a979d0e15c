/* What deform_plan says is what a deform makes and runs: programs, memory and passes, exactly. */
#include <stdio.h>

#include "scene/scene.h"
#include "sliding.h"
#include "../support/program.h"
#include "../support/skip.h"

#define OBJECTS_MAX 6
#define NAMES_MAX 64

static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4};
static const struct soil_shape lugged = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4, .grousers = 9, .grouser_height = 0.06,
					 .grouser_thickness = 0.05};
static const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.6};
static const struct soil_shape pill = {.kind = SOIL_CAPSULE, .radius = 0.4, .length = 0.5}, egg = {.kind = SOIL_ELLIPSOID, .size = {0.6, 0.5, 0.4}};
static const struct soil_shape crate = {.kind = SOIL_BOX, .size = {1, 0.8, 0.6}};
static const struct soil_shape hall = {.kind = SOIL_BOX, .size = {34, 30, 1}}; /* of several windows */
static float corners[4][3] = {{-0.5f, -0.5f, 0.3f}, {0.6f, -0.4f, 0.3f}, {0, 0.6f, 0.3f}, {0.1f, 0, -0.4f}};
static uint32_t faces[4][3] = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
static const struct soil_mesh tetrahedron = {corners, faces, 4, 4, {-0.5, -0.5, -0.4}, {0.6, 0.6, 0.3}};
static const struct soil_shape cone = {.kind = SOIL_MESH, .mesh = &tetrahedron};

struct scenario {
	const char *name;
	enum deform_model model;
	bool dirt;
	int iterations, soils;
	double depth, relief;
	uint32_t tiles; /* 0: 3 */
	bool fixed;     /* contacts are computed in fixed regions */
	size_t count;
	struct deform_planned objects[OBJECTS_MAX];
};

/* --- what there was --- */

struct listing {
	size_t count;
	struct {
		char name[GPU_PROGRAM_NAME];
		uint64_t passes;
	} programs[NAMES_MAX];
};

static void list_one(void *user, const char *name, uint64_t passes)
{
	struct listing *list = user;
	assert_true(list->count < NAMES_MAX);
	snprintf(list->programs[list->count].name, GPU_PROGRAM_NAME, "%s", name);
	list->programs[list->count++].passes = passes;
}

static struct listing listing_of(void)
{
	struct listing list = {.count = 0};
	gpu_programs_each(test_gpu, list_one, &list);
	return list;
}

struct drive {
	const struct scenario *scenario;
	struct ground ground;
	uint64_t windows[OBJECTS_MAX], moved[OBJECTS_MAX], regions[OBJECTS_MAX], regions_moved[OBJECTS_MAX];
	uint64_t atlases;
};

/* --- a drive --- */

static void sweep_at(struct drive *drive, size_t object, double x, double y, double dx, double dy, double roll)
{
	const struct deform_planned *planned = &drive->scenario->objects[object];
	double z = soil_shape_reach(planned->shape, 0, 0) - 0.1;
	struct deform_contact sweep = {.shape = planned->shape, .from = ground_pose(&drive->ground, x, y, z)};
	sweep.to = ground_pose(&drive->ground, x + dx, y + dy, z);
	sweep.turned = dx * drive->ground.params.spacing / 0.5;
	sweep.to.roll = roll;
	assert_ok(deform_windows(drive->ground.deform, &sweep, drive->ground.windows, &drive->ground.window_count));
	if (deform_is_fixed(drive->ground.deform, drive->ground.windows, drive->ground.window_count)) {
		size_t regions;
		assert_ok(deform_fixed(drive->ground.deform, &sweep, &drive->ground.windows[0], drive->ground.tiles, drive->ground.tile_count, &regions));
		drive->regions[object] += regions;
		drive->regions_moved[object] += dx != 0 || dy != 0 ? regions : 0;
		return;
	}
	ground_sweep(&drive->ground, &sweep);
	const size_t computed = deform_windows_computed(drive->ground.windows, drive->ground.window_count);
	drive->windows[object] += computed;
	drive->moved[object] += dx != 0 || dy != 0 ? computed : 0;
	for (size_t i = 0; i < drive->ground.window_count; i++)
		assert_ok(deform_wake_swept(drive->ground.deform, &drive->ground.windows[i], (uint32_t)i));
}

/* A wheel that may lean is level, too. */
static void sweep(struct drive *drive, size_t object, double x, double y, double dx, double dy)
{
	sweep_at(drive, object, x, y, dx, dy, 0);
	if (drive->scenario->objects[object].leans)
		sweep_at(drive, object, x, y, dx, dy, 0.2);
}

/* Standing, straight on, aside, and just beyond the world's edge; then the ground slides with all of them at rest on it. */
static void go(struct drive *drive)
{
	const struct scenario *scenario = drive->scenario;
	struct deform_rest rests[OBJECTS_MAX];
	double middle = (double)drive->ground.posts / 2;
	for (size_t i = 0; i < scenario->count; i++) {
		const struct deform_planned *planned = &scenario->objects[i];
		double x = middle - 25 + 10 * (double)i, reach = 2 * soil_shape_reach(planned->shape, 0, 0) / drive->ground.params.spacing;
		sweep(drive, i, x, middle, 0, 0);
		if (planned->moves) {
			sweep(drive, i, x, middle, 1, 0);
			sweep(drive, i, x + 1, middle, -0.3, 1);
			sweep(drive, i, -reach, middle, 0, 1);
		}
		rests[i] = (struct deform_rest){.shape = planned->shape, .pose = ground_pose(&drive->ground, x + 0.7, middle + 1,
											     soil_shape_reach(planned->shape, 0, 0) - 0.1)};
	}
	for (int n = 0; n < 3; n++) {
		assert_ok(deform_wake(drive->ground.deform, scenario->tiles > 0 ? all_of(&drive->ground) : drive->ground.windows[0].write));
		drive->atlases += ground_interval(&drive->ground, rests, scenario->count).atlases;
		gpu_finish(test_gpu);
		for (size_t i = 0; i < scenario->count; i++)
			sweep(drive, i, middle - 25 + 10 * (double)i, middle, 0, 0);
	}
}

/* --- against the plan --- */

static uint64_t units_of(const struct drive *drive, const struct plan_line *line)
{
	struct deform_figures figures;
	struct gpu_slots_figures slots;
	deform_figures(drive->ground.deform, &figures);
	gpu_slots_figures(drive->ground.slots, &slots);
	switch (line->unit) {
	case PLAN_ONCE:
		return 1;
	case PLAN_BASE_SLOT:
		return slots.base_slots;
	case PLAN_DEFORM_SLOT:
		return slots.deform_slots;
	case PLAN_STATE_SLOT:
		return slots.state_slots;
	case PLAN_RING:
		return test_gpu->stats.ring_segments;
	case PLAN_WINDOW_LAYER:
		return figures.window_layers;
	case PLAN_RESULT_LAYER:
		return figures.result_layers;
	case PLAN_WINDOW:
		return drive->windows[line->object];
	case PLAN_MOVED:
		return drive->moved[line->object];
	case PLAN_REGION:
		return drive->regions[line->object];
	case PLAN_REGION_MOVED:
		return drive->regions_moved[line->object];
	case PLAN_FACETS:
		return figures.facets;
	case PLAN_HELD:
		return figures.held;
	case PLAN_RESTING:
		return figures.resting;
	case PLAN_ATLAS:
		return drive->atlases;
	default:
		fail_msg("%s: unit %s of what is never counted here", line->name, plan_unit_name(line->unit));
		return 0;
	}
}

static void check_memory(const struct drive *drive, const struct plan *plan)
{
	uint64_t textures = 0, bytes = 0;
	for (size_t i = 0; i < plan->count; i++) {
		const struct plan_line *line = &plan->lines[i];
		if (line->kind == PLAN_TEXTURE)
			textures += (uint64_t)line->amount * units_of(drive, line);
		if (line->kind == PLAN_TEXTURE || line->kind == PLAN_BUFFER)
			bytes += line->bytes * units_of(drive, line);
	}
	if (textures != test_gpu->stats.textures || bytes != test_gpu->stats.bytes)
		fail_msg("%s: %llu textures, %llu bytes in all; %u and %llu are there", drive->scenario->name, (unsigned long long)textures,
			 (unsigned long long)bytes, test_gpu->stats.textures, (unsigned long long)test_gpu->stats.bytes);
}

static void check_programs(const struct drive *drive, const struct plan *plan)
{
	struct listing linked = listing_of();
	size_t planned = 0;
	for (size_t i = 0; i < plan->count; i++) {
		if (plan->lines[i].kind != PLAN_PROGRAM)
			continue;
		bool there = false;
		for (size_t k = 0; k < linked.count; k++)
			there = there || strcmp(linked.programs[k].name, plan->lines[i].name) == 0;
		if (!there)
			fail_msg("%s: %s is planned, and not linked", drive->scenario->name, plan->lines[i].name);
		planned++;
	}
	for (size_t k = 0; k < linked.count && planned != linked.count; k++) {
		bool there = false;
		for (size_t i = 0; i < plan->count; i++)
			there = there || (plan->lines[i].kind == PLAN_PROGRAM && strcmp(linked.programs[k].name, plan->lines[i].name) == 0);
		if (!there)
			fail_msg("%s: %s is linked, and not planned", drive->scenario->name, linked.programs[k].name);
	}
	assert_int_equal(planned, linked.count);
}

/* Each of them ran since. */
static void check_ran(const struct drive *drive, const struct listing *before)
{
	struct listing now = listing_of();
	assert_int_equal(now.count, before->count);
	for (size_t i = 0; i < now.count; i++)
		/* Programs of windows are there too, for contacts that do not fit four regions. */
		if (now.programs[i].passes == before->programs[i].passes && !(drive->scenario->fixed && strstr(now.programs[i].name, "REGION") == NULL))
			fail_msg("%s: %s never ran", drive->scenario->name, now.programs[i].name);
}

static void check_passes(const struct drive *drive, const struct plan *plan, const struct gpu_stats *before)
{
	for (int stage = 0; stage < GPU_STAGES; stage++) {
		uint64_t planned = 0, passes = test_gpu->stats.passes[stage] - before->passes[stage];
		for (size_t i = 0; i < plan->count; i++)
			if (plan->lines[i].kind == PLAN_PASS && strcmp(plan->lines[i].name, gpu_stage_name((enum gpu_stage)stage)) == 0)
				planned += (uint64_t)plan->lines[i].amount * units_of(drive, &plan->lines[i]);
		if (planned != passes)
			fail_msg("%s: %llu passes of %s are planned, %llu ran", drive->scenario->name, (unsigned long long)planned,
				 gpu_stage_name((enum gpu_stage)stage), (unsigned long long)passes);
	}
}

static void check_effects(const struct plan *plan)
{
	for (size_t i = 0; i < plan->count; i++) {
		bool known = false;
		for (int e = 0; e < EFFECT_COUNT && plan->lines[i].effect != NULL; e++)
			known = known || strcmp(scene_effect_row((enum scene_effect)e)->name, plan->lines[i].effect) == 0;
		if (!known)
			fail_msg("%s: is called for by %s, which is no effect", plan->lines[i].name, plan->lines[i].effect);
	}
}

static void hold_to_plan(const struct scenario *scenario)
{
	struct drive drive = {.scenario = scenario};
	struct plan plan = {.lines = NULL};
	struct deform_figures figures;
	assert_ok(gpu_create(&(struct gpu_params){.draws = false}, &test_gpu)); /* no programs yet */
	struct soil_numbers soils[SOIL_CLASSES];
	for (int i = 0; i < SOIL_CLASSES; i++)
		assert_ok(soil_named("dry_sand", &soils[i]));
	ground_init(&drive.ground, &(struct ground_params){
		.cells = 32, .tiles = scenario->tiles != 0 ? scenario->tiles : 3, .spacing = 0.125, .height = conserve_rough,
		.model = scenario->model, .dirt = scenario->dirt, .repetitions = 3, .iterations = scenario->iterations, .soils = soils,
		.soil_count = scenario->soils, .depth = scenario->depth, .relief = scenario->relief, .fixed = scenario->fixed,
	});
	struct deform_params params = drive.ground.deform->params;
	params.gpu = NULL;
	params.slots = NULL;
	deform_plan(&params, scenario->objects, scenario->count, &plan);
	check_effects(&plan);
	for (size_t i = 0; i < scenario->count; i++)
		assert_ok(deform_warm(drive.ground.deform, &scenario->objects[i]));
	check_programs(&drive, &plan);
	gpu_slots_plan(32, deform_planes(scenario->model, scenario->dirt, deform_memory(&params)), false, GPU_UNDIVIDED, false, false, "displace", &plan);
	assert_ok(plan_status(&plan));
	check_memory(&drive, &plan);
	deform_figures(drive.ground.deform, &figures);
	assert_true(figures.facets == 0 && figures.held == 0 && figures.resting == 0 && figures.atlases == 0);
	const struct gpu_stats before = test_gpu->stats;
	const struct listing warmed = listing_of();
	gpu_seal(test_gpu);
	go(&drive);
	assert_int_equal(test_gpu->stats.unplanned, 0);
	check_programs(&drive, &plan);
	check_ran(&drive, &warmed);
	check_memory(&drive, &plan);
	check_passes(&drive, &plan, &before);
	deform_figures(drive.ground.deform, &figures);
	assert_int_equal(figures.atlases, drive.atlases);
	assert_true(!deform_conserves(scenario->model) || (figures.held > 0 && figures.atlases > 0));
	assert_true(!scenario->fixed || drive.regions[scenario->count - 1] > 0);
	if (scenario->tiles > 0) /* it grew */
		assert_true(figures.window_layers > 1 && (!deform_conserves(scenario->model) || figures.result_layers > 1));
	plan_finish(&plan);
	ground_finish(&drive.ground);
	gpu_destroy(test_gpu);
	test_gpu = NULL;
}

static int find_gl(void **state)
{
	static bool there;
	int failed = open_gpu(state);
	there = test_gpu != NULL;
	*state = there ? &there : NULL;
	close_gpu(NULL);
	return failed;
}

#define need_gl()                                                                                  \
	do {                                                                                       \
		if (*state == NULL)                                                                \
			skip_since("no GL");                                                       \
	} while (0)

static void hold_all_to_plan(const struct scenario *scenarios, size_t count)
{
	for (size_t i = 0; i < count; i++)
		hold_to_plan(&scenarios[i]);
}

static void compaction_runs_what_is_planned(void **state)
{
	static const struct scenario scenarios[] = {
		{"none, a wheel", DEFORM_NONE, .count = 1, .objects = {{&wheel, true}}},
		{"none, a box with dirt", DEFORM_NONE, .dirt = true, .count = 1, .objects = {{&crate, true}}},
		{"none, a wheel that leans", DEFORM_NONE, .count = 1, .objects = {{&wheel, true, true}}},
		{"none, an ellipsoid and a capsule", DEFORM_NONE, .count = 2, .objects = {{&egg, false}, {&pill, true}}},
		{"none, a mesh", DEFORM_NONE, .count = 1, .objects = {{&cone, true}}},
		{"none, lugs and a sphere with dirt", DEFORM_NONE, .dirt = true, .count = 2, .objects = {{&lugged, true}, {&ball, true}}},
		{"box, two wheels of which one stands", DEFORM_BOX_FILTER, .count = 2, .objects = {{&wheel, false}, {&wheel, true}}},
		{"box, a wheel that stands", DEFORM_BOX_FILTER, .count = 1, .objects = {{&lugged, false}}},
		{"box, all with dirt", DEFORM_BOX_FILTER, .dirt = true, .count = 5,
		 .objects = {{&wheel, true}, {&ball, true}, {&crate, true}, {&cone, true}, {&lugged, false}}},
		{"box, of several windows", DEFORM_BOX_FILTER, .tiles = 10, .count = 1, .objects = {{&hall, true}}},
		{"none, in fixed regions, with dirt", DEFORM_NONE, .dirt = true, .fixed = true, .count = 4,
		 .objects = {{&crate, true}, {&cone, true}, {&lugged, true}, {&wheel, true, true}}},
		{"box, in fixed regions", DEFORM_BOX_FILTER, .fixed = true, .count = 2, .objects = {{&wheel, false}, {&ball, true}}},
		{"box, in fixed regions, and in several windows", DEFORM_BOX_FILTER, .fixed = true, .tiles = 10, .count = 2, .objects = {{&hall, true}, {&wheel, true}}},
	};
	need_gl();
	hold_all_to_plan(scenarios, sizeof scenarios / sizeof *scenarios);
}

static void a_sheet_runs_what_is_planned(void **state)
{
	static const struct scenario scenarios[] = {
		{"sheet, a wheel that leans", DEFORM_SHEET, .count = 1, .objects = {{&wheel, true, true}}},
		{"sheet, a mesh alone", DEFORM_SHEET, .count = 1, .objects = {{&cone, true}}},
		{"sheet, all with dirt", DEFORM_SHEET, .dirt = true, .count = 5,
		 .objects = {{&wheel, true}, {&ball, true}, {&crate, true}, {&cone, true}, {&lugged, false}}},
		{"sheet, of several windows", DEFORM_SHEET, .tiles = 10, .count = 1, .objects = {{&hall, true}}},
	};
	need_gl();
	hold_all_to_plan(scenarios, sizeof scenarios / sizeof *scenarios);
}

static void sliding_runs_what_is_planned(void **state)
{
	static const struct scenario scenarios[] = {
		{"sumner, a wheel", DEFORM_SUMNER, .iterations = 1, .count = 1, .objects = {{&wheel, true}}},
		{"sumner, a box and a mesh, 3 iterations, 3 soils, dirt", DEFORM_SUMNER, .dirt = true, .iterations = 3, .soils = 3,
		 .relief = 10, .count = 2, .objects = {{&crate, true}, {&cone, false}}},
		{"slippage, lugs, 3 iterations", DEFORM_SLIPPAGE, .iterations = 3, .count = 1, .objects = {{&lugged, true}}},
		{"slippage, a sphere with a bottom, 2 soils, dirt", DEFORM_SLIPPAGE, .dirt = true, .iterations = 1, .soils = 2, .depth = 0.2,
		 .relief = 10, .count = 1, .objects = {{&ball, true}}},
		{"slippage, meshes alone", DEFORM_SLIPPAGE, .iterations = 2, .count = 2, .objects = {{&cone, true}, {&cone, false}}},
		{"slippage, of several windows", DEFORM_SLIPPAGE, .iterations = 2, .tiles = 10, .count = 1, .objects = {{&hall, true}}},
	};
	need_gl();
	hold_all_to_plan(scenarios, sizeof scenarios / sizeof *scenarios);
}

/* A plan is made without a GL, and its lines follow what is asked alone. */
static void nothing_is_planned_without_objects(void **state)
{
	struct plan plan = {.lines = NULL};
	struct deform_params params = {.model = DEFORM_SLIPPAGE, .soil_count = 1, .iterations = 1, .disturbance = true};
	const struct deform_planned object = {&wheel, true, false};
	(void)state;
	deform_plan(&params, NULL, 0, &plan);
	assert_int_equal(plan.count, 0);
	deform_plan(&params, &object, 1, &plan);
	assert_ok(plan_status(&plan));
	assert_true(plan.count > 20);
	check_effects(&plan);
	for (size_t i = 0; i < plan.count; i++)
		assert_true(strlen(plan.lines[i].name) + 1 < sizeof plan.lines[i].name); /* none is cut */
	plan_finish(&plan);
}

TEST_PROGRAM(plan)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(nothing_is_planned_without_objects),
		cmocka_unit_test(compaction_runs_what_is_planned),
		cmocka_unit_test(a_sheet_runs_what_is_planned),
		cmocka_unit_test(sliding_runs_what_is_planned),
	};
	return cmocka_run_group_tests_name("deform/plan", tests, find_gl, NULL);
}
