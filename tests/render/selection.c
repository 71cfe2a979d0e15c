/* Which tiles a view draws: coverage, stand-ins, order and bounds, over random worlds. */
#include "selection_fake.h"
#include "../support/program.h"

static struct render_selection selection;

static int times_drawn(const struct extent *extent, double x, double y)
{
	int times = 0;
	for (size_t i = 0; i < selection.draw_count; i++) {
		const struct render_draw *draw = &selection.draws[i];
		double side = extent_spacing(extent, draw->tile.level) * extent->cells;
		double u = x / side - draw->tile.x, v = y / side - draw->tile.y;
		if (u < 0 || v < 0 || u >= 1 || v >= 1)
			continue;
		times += draw->quadrants >> ((u >= 0.5 ? 1 : 0) + (v >= 0.5 ? 2 : 0)) & 1;
	}
	return times;
}

static bool in_frustum(const struct render_view *view, const double point[3])
{
	return render_box_visible(view->planes, point, point);
}

/* How many of a grid's points were in view; each of those must be drawn once. */
static size_t check_coverage(const struct fake *fake, const struct render_view *view)
{
	size_t seen = 0;
	double w = (double)(fake->extent.width - 1) * fake->extent.spacing;
	double h = (double)(fake->extent.height - 1) * fake->extent.spacing;
	for (int j = 0; j < 61; j++)
		for (int i = 0; i < 61; i++) {
			double point[3] = {w * (i + 0.37) / 61, h * (j + 0.61) / 61, 0};
			point[2] = fake_height(point[0], point[1]);
			int times = times_drawn(&fake->extent, point[0], point[1]);
			assert_true(times <= 1);
			if (in_frustum(view, point)) {
				assert_int_equal(times, 1);
				seen++;
			}
		}
	return seen;
}

static void every_visible_point_is_drawn_exactly_once(void **state)
{
	uint64_t random = 1;
	size_t seen = 0, drawn = 0, wanted = 0;
	for (int round = 0; round < 300; round++) {
		struct fake fake;
		struct render_view view;
		random_fake(&random, &fake);
		random_view(&fake, &random, &view);
		struct render_source source = source_of(&fake);
		render_select(&fake.extent, &view, &source, &selection);
		seen += check_coverage(&fake, &view);
		drawn += selection.draw_count;
		wanted += selection.wanted_count;
	}
	assert_true(seen > 50000 && drawn > 1000 && wanted > 1000);
}

static void draws_are_resident_and_come_near_to_far(void **state)
{
	uint64_t random = 2;
	for (int round = 0; round < 200; round++) {
		struct fake fake;
		struct render_view view;
		random_fake(&random, &fake);
		random_view(&fake, &random, &view);
		struct render_source source = source_of(&fake);
		render_select(&fake.extent, &view, &source, &selection);
		for (size_t i = 0; i < selection.draw_count; i++) {
			const struct render_draw *draw = &selection.draws[i];
			uint32_t slot;
			assert_true(fake_resident(&fake, draw->tile, &slot));
			assert_int_equal(slot, draw->slot);
			assert_true(draw->quadrants >= 1 && draw->quadrants <= 15);
			assert_true(i == 0 || draw->distance >= draw[-1].distance);
			assert_int_equal(draw->finest, !fake_divisible(&fake, draw->tile));
			if (draw->tile.level >= 0)
				assert_int_equal(draw->ground, draw->slot);
		}
		int level = TILE_LEVEL_MAX;
		for (size_t i = 0; i < selection.wanted_count; i++) {
			struct tile tile = tile_from_key(selection.wanted[i]);
			uint32_t slot;
			assert_false(fake_resident(&fake, tile, &slot));
			assert_true(tile.level <= level);
			level = tile.level;
			for (size_t k = 0; k < i; k++)
				assert_true(selection.wanted[k] != selection.wanted[i]);
		}
	}
}

static void with_everything_resident_each_point_has_the_level_its_distance_asks_for(void **state)
{
	uint64_t random = 3;
	size_t checked = 0;
	for (int round = 0; round < 150; round++) {
		struct fake fake;
		struct render_view view;
		random_fake(&random, &fake);
		fake.resident_of = 100;
		random_view(&fake, &random, &view);
		struct render_source source = source_of(&fake);
		render_select(&fake.extent, &view, &source, &selection);
		assert_int_equal(selection.wanted_count, 0);
		assert_int_equal(selection.ideal, selection.draw_count);
		for (size_t i = 0; i < selection.draw_count; i++) {
			const struct render_draw *draw = &selection.draws[i];
			double side = extent_spacing(&fake.extent, draw->tile.level) * fake.extent.cells;
			/* A tile that is near is drawn only where nothing finer is. */
			if (draw->distance < view.radius * side && draw->tile.level > 0)
				assert_true(false);
			if (draw->tile.level == extent_coarsest(&fake.extent))
				continue;
			/* And its parent was near, or it would not have been divided. */
			double low[3], high[3];
			struct tile parent = tile_ancestor(draw->tile, draw->tile.level + 1);
			render_box(&fake.extent, parent, low, high);
			assert_true(fake_bounds(&fake, parent, &low[2], &high[2]));
			assert_true(render_box_distance(view.eye, low, high) < view.radius * 2 * side);
			checked++;
		}
	}
	assert_true(checked > 1000);
}

static void a_coarser_tile_stands_in_for_what_is_not_resident(void **state)
{
	struct fake fake = {.extent = {257, 257, 1, 64}, .seed = 9, .root_resident = true};
	struct render_source source = source_of(&fake);
	struct render_view view;
	const double eye[3] = {128, 128, 60}, target[3] = {128.1, 128, 0};
	look(eye, target, 2, &view);
	render_select(&fake.extent, &view, &source, &selection);
	assert_int_equal(selection.draw_count, 1);
	assert_int_equal(selection.draws[0].tile.level, 2);
	assert_true(selection.ideal > 1);
	assert_int_equal(selection.wanted_count, selection.ideal);
	assert_true(check_coverage(&fake, &view) > 0);
}

static void without_the_coarsest_nothing_is_drawn_and_it_is_wanted_first(void **state)
{
	struct fake fake = {.extent = {257, 257, 1, 64}, .seed = 9};
	struct render_source source = source_of(&fake);
	struct render_view view;
	const double eye[3] = {128, 128, 60}, target[3] = {128.1, 128, 0};
	look(eye, target, 2, &view);
	render_select(&fake.extent, &view, &source, &selection);
	assert_int_equal(selection.draw_count, 0);
	assert_true(selection.wanted[0] == tile_key((struct tile){2, 0, 0}));
}

static void full_arrays_stop_division_and_leave_no_hole(void **state)
{
	/* A radius so large that the picture asks for far more tiles than there is room for. */
	struct fake fake = {.extent = {1025, 1025, 1, 8}, .seed = 4, .resident_of = 100, .root_resident = true};
	struct render_source source = source_of(&fake);
	struct render_view view;
	const double eye[3] = {-20, -20, 60}, target[3] = {400, 400, 0};
	look(eye, target, 1000, &view);
	for (unsigned share = 100; share >= 90; share -= 10) {
		fake.resident_of = share;
		render_select(&fake.extent, &view, &source, &selection);
		assert_true(selection.draw_count <= RENDER_DRAWS_MAX);
		assert_true(selection.wanted_count <= RENDER_DRAWS_MAX);
		if (share == 100)
			assert_true(selection.draw_count > RENDER_DRAWS_MAX / 2);
		assert_true(check_coverage(&fake, &view) > 500);
	}
}

static void a_level_zero_tile_is_wanted_for_those_drawn_below_it(void **state)
{
	struct fake fake = {.extent = {65, 65, 1, 64}, .seed = 4, .resident_of = 100, .root_resident = false,
			    .deepest = -2, .everything_below = true};
	struct render_source source = source_of(&fake);
	struct render_view view;
	const double eye[3] = {32, 32, 30}, target[3] = {32.1, 32, 0};
	look(eye, target, 50, &view);
	render_select(&fake.extent, &view, &source, &selection);
	assert_true(selection.draw_count > 1);
	assert_int_equal(selection.wanted_count, 1);
	for (size_t i = 0; i < selection.draw_count; i++) {
		assert_int_equal(selection.draws[i].tile.level, -2);
		assert_true(selection.draws[i].ground == RENDER_NO_SLOT);
	}
	fake.root_resident = true;
	render_select(&fake.extent, &view, &source, &selection);
	uint32_t slot;
	assert_true(fake_resident(&fake, (struct tile){0, 0, 0}, &slot));
	assert_int_equal(selection.draws[0].ground, slot);
}

/* An inset of level -1 in the western half; below it all is divided once more. */
static bool stored_in_the_west(void *user, struct tile tile)
{
	return tile.level == -1 && tile.x == 0;
}

static void a_tile_is_interpolated_from_the_inset_above_it(void **state)
{
	struct fake fake = {.extent = {65, 65, 1, 64}, .seed = 4, .resident_of = 100, .root_resident = true, .deepest = -2,
			    .everything_below = true};
	struct render_source source = source_of(&fake);
	struct render_view view;
	const double eye[3] = {32, 32, 30}, target[3] = {32.1, 32, 0};
	int of[2] = {0};
	look(eye, target, 50, &view);
	render_select(&fake.extent, &view, &source, &selection);
	const size_t without = selection.needed;
	source.stored = stored_in_the_west;
	render_select(&fake.extent, &view, &source, &selection);
	for (size_t i = 0; i < selection.draw_count; i++) {
		const struct render_draw *draw = &selection.draws[i];
		const int level = draw->tile.x < 2 ? -1 : 0;
		uint32_t slot;
		assert_int_equal(draw->tile.level, -2);
		assert_int_equal(draw->ground_level, level);
		assert_true(fake_resident(&fake, tile_ancestor(draw->tile, level), &slot));
		assert_int_equal(draw->ground, slot);
		of[level + 1]++;
	}
	assert_true(of[0] > 0 && of[1] > 0);
	/* the two tiles of the inset are needed beside those that are drawn */
	assert_int_equal(selection.needed, without + 2);
}

static void selection_does_not_depend_on_where_the_world_lies(void **state)
{
	/* Tiles about 10,000 km from the origin: the same tile is divided as near it. */
	struct fake fake = {.extent = {40000001, 1025, 0.25, 256}, .seed = 4, .resident_of = 100,
			    .root_resident = true};
	struct render_source source = source_of(&fake);
	size_t counts[2];
	for (int far = 0; far < 2; far++) {
		double x = far ? 9990016.0 : 16384.0; /* both multiples of a coarse tile's side */
		const double eye[3] = {x, 128, 60}, target[3] = {x + 100, 128, 0};
		struct render_view view;
		look(eye, target, 1, &view);
		render_select(&fake.extent, &view, &source, &selection);
		counts[far] = 0;
		for (size_t i = 0; i < selection.draw_count; i++)
			counts[far] += selection.draws[i].tile.level == 0;
	}
	assert_true(counts[0] > 4);
	assert_int_equal(counts[0], counts[1]);
}

TEST_PROGRAM(selection)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_visible_point_is_drawn_exactly_once),
		cmocka_unit_test(draws_are_resident_and_come_near_to_far),
		cmocka_unit_test(with_everything_resident_each_point_has_the_level_its_distance_asks_for),
		cmocka_unit_test(a_coarser_tile_stands_in_for_what_is_not_resident),
		cmocka_unit_test(without_the_coarsest_nothing_is_drawn_and_it_is_wanted_first),
		cmocka_unit_test(full_arrays_stop_division_and_leave_no_hole),
		cmocka_unit_test(a_level_zero_tile_is_wanted_for_those_drawn_below_it),
		cmocka_unit_test(a_tile_is_interpolated_from_the_inset_above_it),
		cmocka_unit_test(selection_does_not_depend_on_where_the_world_lies),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
