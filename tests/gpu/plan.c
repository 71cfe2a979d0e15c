/* What gpu_slots_plan says is what slots make and run, exactly; and programs by their names. */
#include <stdio.h>

#include "gpu_test.h"
#include "staged.h"
#include "../support/program.h"

enum { CELLS = 16, COUNT = 9, POSTS = (CELLS + 1) * (CELLS + 1) };
#define STATE_PLANES (PLANE_BIT(PLANE_DEPOSITED) | PLANE_BIT(PLANE_PLASTIC_SINKAGE) | PLANE_BIT(PLANE_SHEAR))

struct asked {
	unsigned planes;
	bool classes, divides, decimates, arrays;
};

static int32_t zeros[POSTS];

static void use_base(struct gpu_slots *slots, uint32_t slot, const struct asked *asked)
{
	struct gpu_staging *staging;
	if (asked->divides && slot % 2 == 0)
		assert_ok(staged_subdivide_base(test_gpu, slots, CELLS, slot, zeros, 1, 0, 0));
	else
		assert_ok(staged_upload_base(test_gpu, slots, CELLS, slot, zeros));
	assert_ok(staged_from(test_gpu, zeros, sizeof zeros, &staging));
	if (asked->classes)
		assert_ok(gpu_slots_upload_classes(slots, slot, staging, STAGED_AT));
	gpu_staging_destroy(staging);
}

/* Tiles come and go: some divided, some deformed as they come, some later, and coarser ones that follow. */
static void use(struct gpu_slots *slots, const struct asked *asked)
{
	const struct gpu_rect all = rect_of(0, 0, CELLS + 1, CELLS + 1);
	for (uint32_t i = 0; i < 40; i++) {
		uint32_t slot = any_word() % (COUNT - 2), coarse = COUNT - 2;
		gpu_slots_undeform(slots, slot);
		use_base(slots, slot, asked);
		if (i % 3 == 0)
			assert_ok(staged_upload_deform(test_gpu, slots, CELLS, slot, zeros, NULL));
		if (i % 3 != 1)
			assert_ok(gpu_slots_deform(slots, slot));
		if (asked->decimates && i % 2 == 0)
			assert_ok(gpu_slots_decimate(slots, slot, all, 1, coarse, 0, 0));
	}
}

static uint64_t units_of(const struct gpu_slots *slots, enum plan_unit unit)
{
	struct gpu_slots_figures figures;
	gpu_slots_figures(slots, &figures);
	switch (unit) {
	case PLAN_BASE_SLOT:
		return figures.base_slots;
	case PLAN_CLASS_SLOT:
		return figures.class_slots;
	case PLAN_DEFORM_SLOT:
		return figures.deform_slots;
	case PLAN_STATE_SLOT:
		return figures.state_slots;
	case PLAN_BASE_ARRAY:
		return figures.base_arrays;
	case PLAN_BASE_LAYER:
		return figures.base_layers;
	case PLAN_DEFORM_ARRAY:
		return figures.deform_arrays;
	case PLAN_DEFORM_LAYER:
		return figures.deform_layers;
	case PLAN_PATCH:
		return figures.patches;
	case PLAN_RING:
		return test_gpu->stats.ring_segments;
	case PLAN_SUBDIVIDED:
		return figures.subdivided;
	case PLAN_DECIMATED:
		return figures.decimated;
	default:
		fail_msg("unit %s is none of slots", plan_unit_name(unit));
		return 0;
	}
}

struct found {
	const struct plan *plan;
	size_t count;
	uint64_t passes;
};

static void find_in_plan(void *user, const char *name, uint64_t passes)
{
	struct found *found = user;
	for (size_t i = 0; i < found->plan->count; i++)
		if (found->plan->lines[i].kind == PLAN_PROGRAM && strcmp(found->plan->lines[i].name, name) == 0)
			found->count++;
	found->passes += passes;
}

static size_t planned_programs(const struct plan *plan)
{
	size_t programs = 0;
	for (size_t i = 0; i < plan->count; i++)
		programs += plan->lines[i].kind == PLAN_PROGRAM;
	return programs;
}

static void check(const struct gpu_slots *slots, const struct plan *plan, bool used)
{
	uint64_t textures = 0, bytes = 0, passes[GPU_STAGES] = {0}, all = 0;
	for (size_t i = 0; i < plan->count; i++) {
		const struct plan_line *line = &plan->lines[i];
		if (used && line->unit != PLAN_ONCE && line->unit != PLAN_RING && units_of(slots, line->unit) == 0)
			fail_msg("%s of %s is planned, and never was", line->name, plan_unit_name(line->unit));
		if (line->kind == PLAN_TEXTURE)
			textures += (uint64_t)line->amount * units_of(slots, line->unit);
		if (line->kind == PLAN_TEXTURE || line->kind == PLAN_BUFFER)
			bytes += line->bytes * units_of(slots, line->unit);
		for (int stage = 0; stage < GPU_STAGES && line->kind == PLAN_PASS; stage++)
			if (strcmp(line->name, gpu_stage_name((enum gpu_stage)stage)) == 0)
				passes[stage] += (uint64_t)line->amount * units_of(slots, line->unit);
	}
	assert_int_equal(textures, test_gpu->stats.textures);
	assert_int_equal(bytes, test_gpu->stats.bytes);
	for (int stage = 0; stage < GPU_STAGES; stage++) {
		assert_int_equal(passes[stage], test_gpu->stats.passes[stage]);
		all += passes[stage];
	}
	struct found found = {.plan = plan};
	gpu_programs_each(test_gpu, find_in_plan, &found);
	assert_int_equal(found.count, test_gpu->stats.programs);
	assert_int_equal(found.count, planned_programs(plan));
	assert_int_equal(found.passes, all);
	assert_true(!used || found.count == 0 || all > 0);
}

static void slots_make_and_run_what_is_planned(void **state)
{
	static const struct asked cases[] = {
		{PLANE_BIT(PLANE_OFFSET), false, false, false, false},
		{PLANE_BIT(PLANE_DISTURBANCE), false, false, true, false},
		{PLANE_BIT(PLANE_OFFSET), false, true, true, false},
		{STATE_PLANES, true, false, false, false},
		{STATE_PLANES | PLANE_BIT(PLANE_DISTURBANCE), true, true, true, false},
		{PLANE_BIT(PLANE_OFFSET), false, true, false, true},
		{STATE_PLANES | PLANE_BIT(PLANE_DISTURBANCE), true, true, true, true},
	};
	(void)state;
	need_gpu();
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		const struct asked *asked = &cases[i];
		struct plan plan = {.lines = NULL};
		struct gpu_slots *slots;
		close_gpu(NULL);
		assert_int_equal(open_gpu(NULL), 0); /* of no programs */
		gpu_slots_plan(CELLS, asked->planes, asked->classes, asked->divides, asked->arrays, asked->decimates, "displace", &plan);
		assert_ok(plan_status(&plan));
		assert_ok(gpu_slots_create(test_gpu, CELLS, COUNT, asked->planes, &slots));
		if (asked->arrays)
			assert_ok(gpu_slots_in_arrays(slots));
		assert_ok(gpu_slots_warm(slots, asked->divides, asked->decimates));
		check(slots, &plan, false);
		gpu_seal(test_gpu);
		use(slots, asked);
		assert_int_equal(test_gpu->stats.unplanned, 0);
		check(slots, &plan, true);
		gpu_slots_destroy(slots);
		plan_finish(&plan);
	}
}

/* Once a deform slot has one plane of state it has all that there may be. */
static void state_planes_come_together(void **state)
{
	struct gpu_slots *slots;
	struct gpu_slots_figures figures;
	(void)state;
	need_gpu();
	assert_ok(gpu_slots_create(test_gpu, CELLS, 2, STATE_PLANES, &slots));
	assert_ok(staged_upload_planes(test_gpu, slots, CELLS, 0, (const void *const[PLANES]){[PLANE_PLASTIC_SINKAGE] = zeros}));
	assert_ok(staged_upload_deform(test_gpu, slots, CELLS, 1, zeros, NULL));
	for (int plane = 0; plane < PLANES; plane++)
		assert_int_equal(gpu_slots_get(slots, 0)->planes[plane] != NULL, plane == PLANE_OFFSET || (STATE_PLANES & PLANE_BIT(plane)) != 0);
	gpu_slots_figures(slots, &figures);
	assert_int_equal(figures.deform_slots, 2);
	assert_int_equal(figures.state_slots, 1);
	gpu_slots_destroy(slots);
}

struct last {
	char name[GPU_PROGRAM_NAME];
	uint64_t passes;
	size_t count;
};

static void keep_first(void *user, const char *name, uint64_t passes)
{
	struct last *last = user;
	if (last->count++ > 0)
		return;
	snprintf(last->name, sizeof last->name, "%s", name);
	last->passes = passes;
}

static void programs_are_listed_by_their_names(void **state)
{
	const struct gpu_program_request request = {.vertex = "full.vert", .fragment = "decimate.frag", .defines = {"DISTURBANCE", "DEPTH 3"}};
	struct gpu_program *program;
	struct last last = {.count = 0};
	char name[GPU_PROGRAM_NAME], small[12];
	(void)state;
	gpu_program_name(&request, name, sizeof name);
	assert_string_equal(name, "full.vert decimate.frag DISTURBANCE DEPTH 3");
	gpu_program_name(&request, small, sizeof small);
	assert_string_equal(small, "full.vert d");
	need_gpu();
	assert_ok(gpu_program_get(test_gpu, &request, &program));
	gpu_programs_each(test_gpu, keep_first, &last);
	assert_string_equal(last.name, name);
	assert_int_equal(last.passes, 0);
	assert_int_equal(last.count, test_gpu->stats.programs);
}

static void a_program_linked_behind_the_seal_is_counted(void **state)
{
	struct gpu_program_request request = {.vertex = "full.vert", .fragment = "decimate.frag", .defines = {"DISTURBANCE", "DEPTH 4"}};
	struct gpu_program *program;
	struct gpu_stats stats;
	(void)state;
	need_gpu();
	close_gpu(NULL);
	assert_int_equal(open_gpu(NULL), 0);
	assert_ok(gpu_program_get(test_gpu, &request, &program));
	gpu_seal(test_gpu);
	assert_ok(gpu_program_get(test_gpu, &request, &program)); /* it is there */
	gpu_stats(test_gpu, &stats);
	assert_int_equal(stats.unplanned, 0);
	for (int i = 0; i < 2; i++) {
		request.defines[1] = i == 0 ? "DEPTH 5" : "DEPTH 6";
		assert_ok(gpu_program_get(test_gpu, &request, &program));
	}
	gpu_stats(test_gpu, &stats);
	assert_int_equal(stats.unplanned, 2);
}

TEST_PROGRAM(plan)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(programs_are_listed_by_their_names),
		cmocka_unit_test(state_planes_come_together),
		cmocka_unit_test(slots_make_and_run_what_is_planned),
		cmocka_unit_test(a_program_linked_behind_the_seal_is_counted),
	};
	return cmocka_run_group_tests_name("gpu/plan", tests, open_gpu, close_gpu);
}
