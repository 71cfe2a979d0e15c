/* How far off a view takes tiles to be drawn: the store's errors, ruts at once and about right, and what was committed. */
#include "../support/near.h"
#include "view_rig.h"
#include "../support/program.h"

static void rig_open_with(struct rig *rig, double pixel_error, int level)
{
	if (level < 0)
		rig_lay_straight();
	rig_open(rig, 128, 0, 0);
	rig_lay_hills();
	render_view_destroy(rig->view);
	rig->scene.view.pixel_error = pixel_error;
	rig_at_level(rig, level);
	must(render_view_create(rig->world, false, &rig->view));
}

static double error_of(struct rig *rig, struct tile tile)
{
	double error = -1;
	must(render_view_error(rig->view, tile, false, &error));
	return error;
}

/* The rig's sphere, its lowest point `sink` under the ground at a place. */
static struct event event_at(struct rig *rig, double x, double y, double sink)
{
	struct event event = {.contact = true, .sinkage = sink, .pose = {.x = lattice_offset(x), .y = lattice_offset(y)}};
	int64_t ground;
	bool any;
	must(resident_ground_height(rig->made.resident.ground, event.pose.x, event.pose.y, &ground, &any));
	assert_true(any);
	event.pose.z = ground + lattice_offset(rig->object.shape.radius - sink);
	return event;
}

static void press(struct rig *rig, struct tile tile, double x, double y, double sink)
{
	struct event event = event_at(rig, x, y, sink);
	int64_t cx = (int64_t)(x / rig->made.resident.spacing), cy = (int64_t)(y / rig->made.resident.spacing), r = (int64_t)ceil(0.5 / rig->made.resident.spacing);
	const struct post_rect under = {cx - r, cy - r, cx + r + 2, cy + r + 2};
	const struct world_touch touch = {
		.shape = &rig->object.shape,
		.pose = event.pose,
		.depth = sink,
		.area = {event.pose.z - lattice_offset(rig->object.shape.radius), under, under},
	};
	must(render_view_contact(rig->view, &touch));
	must(render_view_deformed(rig->view, tile));
	must(render_view_contact(rig->view, NULL));
}

static void without_a_pixel_error_no_errors_are_kept(void **state)
{
	struct rig rig;
	rig_open(&rig, 16, 0, 0);
	assert_null(rig.view->errors);
	press(&rig, (struct tile){0, 3, 2}, 50, 40, 0.1);
	must(render_view_frame(rig.view, NULL, false));
	rig_close(&rig);
}

static void a_bases_error_is_the_stores_and_no_less_than_what_it_covers(void **state)
{
	struct rig rig;
	rig_open_with(&rig, 1, 0);
	int coarsest = extent_coarsest(&extent);
	size_t rough = 0;
	for (int level = 0; level <= coarsest; level++)
		for (uint32_t y = 0; y < extent_tiles_y(&extent, level); y++)
			for (uint32_t x = 0; x < extent_tiles_x(&extent, level); x++) {
				struct tile tile = {level, x, y};
				struct store_range range;
				must(store_read_base_range(resident_ground_reader(rig.made.resident.ground), tile, &range));
				double error = error_of(&rig, tile);
				assert_true(error == range.error && error_of(&rig, tile) == error);
				assert_true(level > 0 || error == 0);
				if (level < coarsest)
					assert_true(error_of(&rig, tile_ancestor(tile, level + 1)) >= error);
				rough += error > 0;
			}
	assert_true(rough > 300);
	rig_close(&rig);
}

/* Of tiles of `level` and up, over a place. */
static void chain(struct rig *rig, int level, double x, double y, double errors[16])
{
	double side = extent_spacing(&extent, level) * CELLS;
	struct tile tile = {level, (uint32_t)(x / side), (uint32_t)(y / side)};
	for (int i = 0; level + i <= extent_coarsest(&extent); i++)
		errors[i] = error_of(rig, tile_ancestor(tile, level + i));
}

static void a_rut_is_at_once_part_of_the_error_of_all_above_it_and_of_nothing_else(void **state)
{
	const enum deform_model models[] = {DEFORM_BOX_FILTER, DEFORM_SLIPPAGE};
	for (int m = 0; m < 2; m++) {
		struct rig rig;
		rig_open_with(&rig, 1, -3);
		rig.scene.model = models[m];
		int count = extent_coarsest(&extent) + 4;
		double before[16], after[16], beside[16], later[16];
		struct tile tile = {-3, 50, 40}; /* 2 m: around (101, 81) */
		chain(&rig, -3, 101, 81, before);
		press(&rig, tile, 101, 81, 0.1);
		chain(&rig, -3, 101, 81, after);
		chain(&rig, -3, 300, 300, beside);
		assert_true(after[0] == 0); /* nothing is finer */
		for (int i = 1; i < count; i++) {
			double more = after[i] - before[i], deep = m == 0 ? 0.1 : 0.2;
			assert_true(more >= deep - 1e-9 && more < 4 * deep); /* rough ground */
			assert_true(after[i] >= after[i - 1]);
		}
		for (int i = 0; i < 3; i++) /* up to level 0 it has parents of its own */
			assert_true(beside[i] == 0);
		/* Less deep changes nothing; deeper does. */
		press(&rig, tile, 101, 81, 0.05);
		chain(&rig, -3, 101, 81, later);
		assert_memory_equal(later, after, (size_t)count * sizeof *after);
		press(&rig, (struct tile){-3, 51, 40}, 103, 81, 0.6);
		chain(&rig, -3, 101, 81, later);
		assert_true(later[1] >= 0.6 && later[0] == 0);
		/* Soil that slides by itself: as deep as anything pressed. */
		chain(&rig, -3, 300, 300, before);
		must(render_view_deformed(rig.view, (struct tile){-3, 150, 150}));
		chain(&rig, -3, 301, 301, after);
		assert_true(after[1] >= 0.6 && before[1] == 0);
		rig_close(&rig);
	}
}

static double height(struct rig *rig, double x, double y)
{
	int64_t ground;
	bool any;
	must(resident_ground_height(rig->made.resident.ground, lattice_offset(x), lattice_offset(y), &ground, &any));
	assert_true(any);
	return lattice_offset_metres(ground);
}

/* How deep the rig's sphere presses where it presses deepest, its lowest point `sink` under the ground. */
static double deepest(struct rig *rig, double x, double y, double sink)
{
	double r = rig->object.shape.radius, bottom = height(rig, x, y) - sink, deep = 0;
	for (double v = -r; v <= r; v += r / 16)
		for (double u = -r; u <= r; u += r / 16)
			if (u * u + v * v < r * r)
				deep = support_most(deep, height(rig, x + u, y + v) - (bottom + r - sqrt(r * r - u * u - v * v)));
	return deep;
}

static void a_rut_counts_about_as_deep_as_it_is(void **state)
{
	struct rig rig;
	rig_open_with(&rig, 1, -3);
	double most = 0;
	for (uint32_t i = 0; i < 100; i++) {
		double errors[16], x = 5.0 + 5 * i, y = 250, deep = deepest(&rig, x, y, 0.1);
		press(&rig, (struct tile){-3, (uint32_t)(x / 2), 125}, x, y, 0.1);
		chain(&rig, -3, x, y, errors);
		assert_true(errors[1] >= 0.1 - 1e-9 && errors[1] > 0.7 * deep && errors[1] < 1.1 * deep);
		most = support_most(most, deep);
	}
	assert_true(most > 0.4);
	rig_close(&rig);
}

static size_t wanted_at(const struct view *view, int level)
{
	size_t count = 0;
	for (size_t i = 0; i < view->selection->wanted_count; i++)
		count += tile_from_key(view->selection->wanted[i]).level == level;
	return count;
}

static void a_rut_is_drawn_finely_where_its_depth_is_seen_and_not_where_not(void **state)
{
	struct rig rig;
	rig_open_with(&rig, 1, -3);
	struct view *view = rig.view;
	double z = height(&rig, 101, 81), focal = 90 / tan(0.45);
	struct render_camera camera = {{101, 81, 0}, {101.1, 81, z}, 0.9, {0}};
	press(&rig, (struct tile){-3, 50, 40}, 101, 81, 0.1);
	double errors[16];
	chain(&rig, -3, 101, 81, errors);
	/* The box is wider than the rut, by what an object may do. */
	double reach = view->reach + 3;
	camera.eye[2] = z + 0.9 * errors[1] * focal;
	must(render_view_select(view, &camera, true));
	assert_true(wanted_at(view, -3) == 1);
	camera.eye[2] = z + 1.1 * errors[1] * focal + reach;
	must(render_view_select(view, &camera, true));
	assert_true(wanted_at(view, -3) == 0);
	rig_close(&rig);
}

static void what_will_be_deformed_counts_as_deep_as_anything_yet(void **state)
{
	struct rig rig;
	double error;
	rig_open_with(&rig, 1, -3);
	must(render_view_error(rig.view, (struct tile){-2, 5, 5}, true, &error));
	assert_true(error == 0);
	press(&rig, (struct tile){-3, 50, 40}, 101, 81, 0.3);
	must(render_view_error(rig.view, (struct tile){-2, 5, 5}, true, &error));
	assert_true(error >= 0.3);
	must(render_view_error(rig.view, (struct tile){-3, 5, 5}, true, &error));
	assert_true(error == 0);
	rig_close(&rig);
}

/* Hills without a rut: triangles between posts are off the bilinear ground, down to the working level. */
static void bent_ground_counts_as_far_as_it_bends(void **state)
{
	struct rig rig;
	rig_open(&rig, 128, 0, 0);
	render_view_destroy(rig.view);
	rig.scene.view.pixel_error = 1;
	rig.made.resident.level = -3;
	rig_set(&rig);
	must(render_view_create(rig.world, false, &rig.view));
	for (uint32_t i = 0; i < 20; i++) {
		double errors[16], bend, before = INFINITY;
		chain(&rig, -3, 7 + 20 * i, 300, errors);
		assert_true(errors[0] == 0);
		for (int level = 0; level >= -2; level--) {
			double side = extent_spacing(&extent, level) * CELLS;
			must(resident_ground_bend(rig.made.resident.ground, (struct tile){level, (uint32_t)((7 + 20 * i) / side), (uint32_t)(300 / side)}, &bend));
			assert_true(errors[level + 3] == bend && bend > 0 && bend <= before / 4);
			before = bend;
		}
	}
	rig_close(&rig);
}

/* A pit and a heap in two tiles of one parent, of a store that was deformed before. */
static void what_was_committed_is_known_exactly(void **state)
{
	struct rig rig;
	struct store *store;
	struct store_commit_result result;
	double before[16], after[16];
	rig_open_with(&rig, 1, 0);
	chain(&rig, 0, 50, 40, before);
	rig_close(&rig);
	int32_t pit[(CELLS + 1) * (CELLS + 1)] = {0}, heap[(CELLS + 1) * (CELLS + 1)] = {0};
	must(store_open(support_path("view.furrow"), &(struct store_options){.mode = STORE_WRITE}, &store));
	must(store_set_working_level(store, 0));
	pit[5 * (CELLS + 1) + 7] = (int32_t)lattice_offset(-0.75);
	heap[9 * (CELLS + 1) + 7] = (int32_t)lattice_offset(0.25);
	const struct store_page pages[2] = {{.tile = {0, 2, 2}, .planes = {[PLANE_OFFSET] = pit}},
					    {.tile = {0, 3, 2}, .planes = {[PLANE_OFFSET] = heap}}};
	const struct store_run run = {.scene_hash = "0", .step = 1, .state = "{}"};
	must(store_commit(store, pages, 2, &run, &result));
	store_close(store);
	rig_open_with(&rig, 1, 0);
	chain(&rig, 0, 50, 40, after);
	assert_true(after[0] == 0);
	for (int i = 1; i <= extent_coarsest(&extent); i++)
		assert_true(after[i] == before[i] + 1);
	rig_close(&rig);
}

TEST_PROGRAM(view_errors)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(without_a_pixel_error_no_errors_are_kept),
		cmocka_unit_test(a_bases_error_is_the_stores_and_no_less_than_what_it_covers),
		cmocka_unit_test(a_rut_is_at_once_part_of_the_error_of_all_above_it_and_of_nothing_else),
		cmocka_unit_test(a_rut_counts_about_as_deep_as_it_is),
		cmocka_unit_test(a_rut_is_drawn_finely_where_its_depth_is_seen_and_not_where_not),
		cmocka_unit_test(what_will_be_deformed_counts_as_deep_as_anything_yet),
		cmocka_unit_test(what_was_committed_is_known_exactly),
		cmocka_unit_test(bent_ground_counts_as_far_as_it_bends),
	};
	return cmocka_run_group_tests_name("view_errors", tests, support_enter, support_leave);
}
