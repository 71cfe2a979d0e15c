/* Contacts in fixed regions leave the same bits as contacts in windows, in at most four passes for each object and stage. */
#include "ground.h"
#include "../support/program.h"

static const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.9}, crate = {.kind = SOIL_BOX, .size = {1.2, 0.8, 0.6}};
static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.8, .width = 0.5}, egg = {.kind = SOIL_ELLIPSOID, .size = {0.9, 0.6, 0.5}};
static const struct soil_shape barrel = {.kind = SOIL_CYLINDER, .radius = 0.5, .length = 0.8}, pill = {.kind = SOIL_CAPSULE, .radius = 0.4, .length = 0.5};
static const struct soil_shape lugged = {.kind = SOIL_WHEEL, .radius = 0.7, .width = 0.5, .grousers = 9, .grouser_height = 0.1, .grouser_thickness = 0.1};
static float corners[][3] = {{-0.6f, -0.5f, -0.5f}, {0.8f, -0.4f, -0.3f}, {0.1f, 0.9f, -0.4f}, {0.0f, 0.1f, 0.6f}};
static uint32_t sides[][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
static const struct soil_mesh tetrahedron = {
	.vertices = corners, .vertex_count = 4, .triangles = sides, .triangle_count = 4, .low = {-0.6f, -0.5f, -0.5f}, .high = {0.8f, 0.9f, 0.6f},
};
static const struct soil_shape stone = {.kind = SOIL_MESH, .mesh = &tetrahedron};
static const struct soil_shape *const shapes[] = {&wheel, &ball, &lugged, &crate, &barrel, &stone, &pill, &egg};
#define SHAPES (sizeof shapes / sizeof *shapes)

static int32_t holed(int64_t x, int64_t y)
{
	return (x * 5 + y * 3) % 61 == 0 ? BASE_NODATA : (int32_t)(20000 * sin((double)x * 0.2) * cos((double)y * 0.3));
}

/* A contact around a post of the block. moves: it goes up to a spacing in any direction. */
static struct deform_contact any_contact(const struct ground *ground, const struct soil_shape *shape, double x, double y, bool moves)
{
	const double spacing = ground->params.spacing, z = soil_shape_reach(shape, 0, 0) - 0.3 + 0.1 * any_share();
	struct deform_contact contact = {.shape = shape, .from = ground_pose(ground, x + any_share(), y + any_share(), z)};
	contact.to = contact.from;
	if (!moves)
		return contact;
	contact.from.yaw = contact.to.yaw = 4 * any_share();
	if (any_word() % 4 == 0)
		contact.to.roll = 0.2 * any_share();
	contact.to.x += lattice_offset(spacing * any_share());
	contact.to.y += lattice_offset(spacing * any_share());
	contact.to.z += lattice_offset(0.02 * any_share());
	contact.turned = 0.3 * any_share();
	return contact;
}

/* Computes a contact in fixed regions. Returns how many regions it was drawn in; 0: it was not, but in windows. */
static size_t press(struct ground *ground, const struct deform_contact *contact)
{
	size_t written = 0;
	assert_ok(deform_windows(ground->deform, contact, ground->windows, &ground->window_count));
	if (!deform_is_fixed(ground->deform, ground->windows, ground->window_count)) {
		ground_sweep(ground, contact);
		return 0;
	}
	assert_ok(deform_fixed(ground->deform, contact, &ground->windows[0], ground->tiles, ground->tile_count, &written));
	assert_true(written >= 1 && written <= 4);
	return written;
}

/* Both have the same in all planes, and counted the same. Returns how many posts have an offset. */
static size_t assert_alike(struct ground *windows, struct ground *fixed)
{
	const size_t posts = (size_t)(windows->posts * windows->posts);
	struct deform_tally tallies[2];
	size_t changed = 0;
	for (int plane = 0; plane < PLANES; plane++) {
		if (!(windows->deform->planes & PLANE_BIT(plane)))
			continue;
		int32_t *first = ground_plane(windows, (enum plane)plane), *second = ground_plane(fixed, (enum plane)plane);
		for (size_t i = 0; i < posts; i++) {
			if (first[i] != second[i])
				fail_msg("%s differs at post %zu, %zu: %d by windows, %d in regions", plane_name((enum plane)plane), i % (size_t)windows->posts,
					 i / (size_t)windows->posts, first[i], second[i]);
			changed += plane == PLANE_OFFSET && first[i] != 0;
		}
		mem_free(first);
		mem_free(second);
	}
	assert_ok(deform_tally(windows->deform, &tallies[0]));
	assert_ok(deform_tally(fixed->deform, &tallies[1]));
	assert_memory_equal(&tallies[0], &tallies[1], sizeof tallies[0]);
	return changed;
}

static void init_both(const struct ground_params *params, struct ground *windows, struct ground *fixed)
{
	struct ground_params of = *params;
	ground_init(windows, &of);
	of.fixed = true;
	ground_init(fixed, &of);
}

/* Contacts on the corner of four tiles, on sides, within one, and beyond the world. What one leaves, the next one finds. */
static void check(const struct ground_params *params)
{
	static const double at[][2] = {{1, 1}, {1, 0.5}, {0.5, 1}, {0.6, 0.45}, {2, 1}, {2, 1.5}, {0.01, 0.5}, {2.99, 2.99}, {1, 2.98}};
	struct ground windows, fixed;
	size_t drawn[5] = {0};
	init_both(params, &windows, &fixed);
	for (size_t i = 0; i < 3 * sizeof at / sizeof *at; i++) {
		const size_t where = i % (sizeof at / sizeof *at);
		const double *place = at[where == 6 && params->first > 0 ? 3 : where]; /* west of the block there is no tile, unless the world ends there */
		const struct deform_contact contact = any_contact(&windows, shapes[any_word() % SHAPES], place[0] * params->cells, place[1] * params->cells,
								  i % 4 != 0);
		ground_sweep(&windows, &contact);
		drawn[press(&fixed, &contact)]++;
	}
	assert_int_equal(drawn[0], 0);
	assert_true(drawn[1] > 0 && drawn[2] > 0 && drawn[4] > 0);
	assert_true(assert_alike(&windows, &fixed) > 40);
	ground_finish(&windows);
	ground_finish(&fixed);
}

static void fixed_regions_leave_the_bits_of_windows(void **state)
{
	static const struct ground_params grounds[] = {
		{.cells = 64, .spacing = 0.25, .model = DEFORM_NONE},
		{.cells = 64, .spacing = 0.1, .model = DEFORM_NONE, .dirt = true},
		{.cells = 64, .spacing = 0.25, .model = DEFORM_BOX_FILTER, .dirt = true},
		{.cells = 64, .spacing = 0.125, .model = DEFORM_BOX_FILTER, .radius = 2, .repetitions = 3},
		{.cells = 128, .spacing = 0.09, .model = DEFORM_BOX_FILTER, .radius = 4, .repetitions = 2, .dirt = true},
		{.cells = 64, .spacing = 0.2, .model = DEFORM_BOX_FILTER, .radius = 1, .repetitions = 8},
		{.cells = 64, .spacing = 0.2, .model = DEFORM_BOX_FILTER, .radius = 3, .repetitions = 1},
	};
	(void)state;
	need_gpu();
	for (size_t i = 0; i < sizeof grounds / sizeof *grounds; i++) {
		struct ground_params params = grounds[i];
		params.tiles = 3;
		params.first = (int64_t)(i % 2) * 5000;
		params.height = holed;
		for (int round = 0; round < 3; round++)
			check(&params);
	}
}

/* A contact of more than one window, or on more than two tiles in a row, is left to windows. */
static void what_does_not_fit_four_regions_is_computed_by_windows(void **state)
{
	static const struct soil_shape hall = {.kind = SOIL_BOX, .size = {80, 70, 1}}, plank = {.kind = SOIL_BOX, .size = {12, 1, 1}};
	const struct ground_params params = {.cells = 32, .tiles = 12, .spacing = 0.25, .model = DEFORM_BOX_FILTER, .height = holed};
	struct ground windows, fixed;
	(void)state;
	need_gpu();
	init_both(&params, &windows, &fixed);
	const struct {
		const struct soil_shape *shape;
		bool drawn;
	} cases[] = {{&hall, false}, {&plank, false}, {&wheel, true}, {&hall, false}};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		struct deform_contact contact = any_contact(&windows, cases[i].shape, 6 * 32 + 16, 6 * 32 + 16, false);
		contact.to.x += lattice_offset(0.2);
		ground_sweep(&windows, &contact);
		assert_int_equal(press(&fixed, &contact) > 0, cases[i].drawn);
	}
	assert_true(assert_alike(&windows, &fixed) > 40);
	ground_finish(&windows);
	ground_finish(&fixed);
}

/* One pass for each stage and region. So an object has at most four for each stage, or four times the repetitions of smoothing. */
static void an_object_has_at_most_four_passes_for_each_stage(void **state)
{
	const struct ground_params params = {.cells = 64, .tiles = 3, .spacing = 0.25, .model = DEFORM_BOX_FILTER, .repetitions = 3, .dirt = true, .fixed = true};
	static const struct {
		double x, y;
		uint64_t regions;
	} cases[] = {{64, 64, 4}, {64, 32, 2}, {32, 128, 2}, {32, 32, 1}};
	struct ground ground;
	(void)state;
	need_gpu();
	ground_init(&ground, &params);
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		struct deform_contact contact = any_contact(&ground, &ball, cases[i].x, cases[i].y, false);
		struct gpu_stats before, after;
		contact.to.x += lattice_offset(0.1);
		gpu_stats(test_gpu, &before);
		assert_int_equal(press(&ground, &contact), cases[i].regions);
		gpu_stats(test_gpu, &after);
		assert_int_equal(after.passes[GPU_ENVELOPE] - before.passes[GPU_ENVELOPE], cases[i].regions);
		assert_int_equal(after.passes[GPU_CONTACT] - before.passes[GPU_CONTACT], cases[i].regions);
		assert_int_equal(after.passes[GPU_SMOOTH] - before.passes[GPU_SMOOTH], 3 * cases[i].regions);
		assert_int_equal(after.passes[GPU_DISTURBANCE] - before.passes[GPU_DISTURBANCE], cases[i].regions);
	}
	ground_finish(&ground);
}

/* Laying sums soil over a whole contact, so a model that conserves soil has no fixed regions. Nor has what the CPU alone computes, nor a sheet, which bends far around. */
static void models_that_conserve_soil_take_no_regions(void **state)
{
	(void)state;
	for (int model = 0; model < DEFORM_MODELS; model++)
		assert_int_equal(deform_takes_regions((enum deform_model)model), !deform_conserves((enum deform_model)model) && !deform_for_cpu((enum deform_model)model));
}

TEST_PROGRAM(fixed)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(fixed_regions_leave_the_bits_of_windows),
		cmocka_unit_test(what_does_not_fit_four_regions_is_computed_by_windows),
		cmocka_unit_test(an_object_has_at_most_four_passes_for_each_stage),
		cmocka_unit_test(models_that_conserve_soil_take_no_regions),
	};
	return cmocka_run_group_tests_name("fixed", tests, open_gpu, close_gpu);
}
