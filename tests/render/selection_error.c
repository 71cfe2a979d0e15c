/* Selection by error on the screen (Equation 3): against its definition at every point, where it spends tiles, how it
 * is fitted, and what a source may say without harm. */
#include "selection_fake.h"
#include "../support/program.h"

static struct render_selection selection;

/* A camera of `focal` pixels that allows so many of error. */
static void by_error(double focal, double pixels, struct render_view *view)
{
	view->by_error = true;
	view->radius = focal / pixels;
}

static void random_scene(uint64_t *random, struct fake *fake, struct render_view *view)
{
	random_fake(random, fake);
	fake->resident_of = 100;
	random_view(fake, random, view);
	by_error(400, 0.2 * pow(100, unit(random)), view);
}

static bool in_frustum(const struct render_view *view, const double point[3])
{
	return render_box_visible(view->planes, point, point);
}

/* How many draws show a point, and the last of them. */
static int drawn_at(const struct fake *fake, const double point[3], struct tile *tile)
{
	int times = 0;
	for (size_t k = 0; k < selection.draw_count; k++) {
		const struct render_draw *draw = &selection.draws[k];
		double side = extent_spacing(&fake->extent, draw->tile.level) * fake->extent.cells;
		double u = point[0] / side - draw->tile.x, v = point[1] / side - draw->tile.y;
		if (u < 0 || v < 0 || u >= 1 || v >= 1 || !(draw->quadrants >> ((u >= 0.5 ? 1 : 0) + (v >= 0.5 ? 2 : 0)) & 1))
			continue;
		times++;
		*tile = draw->tile;
	}
	return times;
}

static struct tile child_at(const struct fake *fake, struct tile tile, double x, double y)
{
	double side = extent_spacing(&fake->extent, tile.level - 1) * fake->extent.cells;
	return (struct tile){tile.level - 1, (uint32_t)(x / side), (uint32_t)(y / side)};
}

/* The tile that Equation 3 asks for at a point: the first from the top whose error is small enough, or that has
 * nothing finer there. */
static struct tile asked_for(struct fake *fake, const struct render_view *view, double focal, double pixels, double x,
			     double y)
{
	struct tile tile = {extent_coarsest(&fake->extent), 0, 0};
	for (;;) {
		double low[3], high[3];
		render_box(&fake->extent, tile, low, high);
		assert_true(fake_bounds(fake, tile, &low[2], &high[2]));
		double distance = render_box_distance(view->eye, low, high);
		if (!fake_divisible(fake, tile) || fake_error(fake, tile) * focal <= pixels * distance)
			return tile;
		struct tile child = child_at(fake, tile, x, y);
		if (!exists(fake, child))
			return tile;
		tile = child;
	}
}

static void every_visible_point_has_the_tile_that_its_error_asks_for(void **state)
{
	uint64_t random = 21;
	size_t seen = 0, levels[40] = {0};
	for (int round = 0; round < 200; round++) {
		struct fake fake;
		struct render_view view;
		double focal = 300 + 500 * unit(&random), pixels = 0.2 * pow(100, unit(&random));
		random_scene(&random, &fake, &view);
		by_error(focal, pixels, &view);
		struct render_source source = source_of(&fake);
		render_select(&fake.extent, &view, &source, &selection);
		if (selection.draw_count > RENDER_DRAWS_MAX / 2)
			continue;
		for (int i = 0; i < 400; i++) {
			double point[3] = {(double)(fake.extent.width - 1) * fake.extent.spacing * unit(&random),
					   (double)(fake.extent.height - 1) * fake.extent.spacing * unit(&random), 0};
			point[2] = fake_height(point[0], point[1]);
			if (!in_frustum(&view, point))
				continue;
			struct tile tile = asked_for(&fake, &view, focal, pixels, point[0], point[1]);
			struct tile drawn;
			assert_int_equal(drawn_at(&fake, point, &drawn), 1);
			assert_true(tile_key(drawn) == tile_key(tile));
			seen++;
			levels[tile.level + 16]++;
		}
	}
	size_t kinds = 0;
	for (int i = 0; i < 40; i++)
		kinds += levels[i] > 50;
	assert_true(seen > 10000 && kinds >= 6);
}

static void a_draw_tells_its_error_and_that_of_all_above_it(void **state)
{
	uint64_t random = 22;
	size_t checked = 0;
	for (int round = 0; round < 100; round++) {
		struct fake fake;
		struct render_view view;
		random_scene(&random, &fake, &view);
		struct render_source source = source_of(&fake);
		render_select(&fake.extent, &view, &source, &selection);
		int coarsest = extent_coarsest(&fake.extent);
		double low = 0, high = 0;
		assert_true(fake_bounds(&fake, (struct tile){coarsest, 0, 0}, &low, &high));
		for (size_t i = 0; i < selection.draw_count; i++) {
			const struct render_draw *draw = &selection.draws[i];
			for (int k = 0; k < RENDER_STRIDES; k++) {
				int level = draw->tile.level + k;
				double top = fake_error(&fake, (struct tile){coarsest, 0, 0});
				if (level <= coarsest)
					assert_true(draw->errors[k] == fake_error(&fake, tile_ancestor(draw->tile, level)));
				else
					assert_true(draw->errors[k] == fmax(top, high - low));
				assert_true(k == 0 || draw->errors[k] >= draw->errors[k - 1]);
				checked++;
			}
		}
	}
	assert_true(checked > 1000);
}

static void allowed_less_a_view_is_nowhere_coarser(void **state)
{
	uint64_t random = 23;
	size_t grown = 0;
	for (int round = 0; round < 100; round++) {
		struct fake fake;
		struct render_view view;
		random_scene(&random, &fake, &view);
		struct render_source source = source_of(&fake);
		int levels[50];
		for (int i = 0; i < 50; i++)
			levels[i] = TILE_LEVEL_MIN;
		for (double pixels = 1; pixels <= 64; pixels *= 2) {
			by_error(400, pixels, &view);
			render_select(&fake.extent, &view, &source, &selection);
			if (selection.draw_count > RENDER_DRAWS_MAX / 2)
				continue; /* some were left undivided for want of room */
			uint64_t places = 99;
			for (int i = 0; i < 50; i++) {
				struct tile tile;
				double point[3] = {(double)(fake.extent.width - 1) * fake.extent.spacing * unit(&places),
						   (double)(fake.extent.height - 1) * fake.extent.spacing * unit(&places), 0};
				point[2] = fake_height(point[0], point[1]);
				if (!in_frustum(&view, point))
					continue;
				assert_int_equal(drawn_at(&fake, point, &tile), 1);
				assert_true(tile.level >= levels[i]);
				grown += levels[i] > TILE_LEVEL_MIN && tile.level > levels[i];
				levels[i] = tile.level;
			}
		}
	}
	assert_true(grown > 500);
}

/* --- where tiles are spent --- */

static double no_error(void *user, struct tile tile)
{
	return 0;
}

/* 30 m high, along x = 512: where that is in a tile, any coarser one is off by all of it. */
static double cliff_error(void *user, struct tile tile)
{
	double side = ldexp(8, tile.level);
	return tile.level > 0 && tile.x * side <= 512 && (tile.x + 1) * side >= 512 ? 30 : 0;
}

static void flat_ground_takes_few_tiles_and_a_cliff_many(void **state)
{
	struct fake fake = {.extent = {1025, 1025, 1, 8}, .seed = 4, .resident_of = 100, .root_resident = true};
	struct render_source source = source_of(&fake);
	struct render_view view;
	const double eye[3] = {480, 400, 60}, target[3] = {520, 560, 0};
	look(eye, target, 0, &view);
	by_error(600, 1, &view);
	source.error = no_error;
	render_select(&fake.extent, &view, &source, &selection);
	assert_int_equal(selection.draw_count, 1);
	source.error = cliff_error;
	render_select(&fake.extent, &view, &source, &selection);
	size_t fine = 0;
	for (size_t i = 0; i < selection.draw_count; i++) {
		bool at_cliff = cliff_error(NULL, tile_ancestor(selection.draws[i].tile, selection.draws[i].tile.level + 1)) > 0;
		fine += selection.draws[i].tile.level == 0;
		assert_true(at_cliff); /* divided for nothing else */
	}
	assert_true(fine > 20);
}

/* Tiles of level 8 before the place that is looked at. */
static uint32_t shift;

static double shifted_error(void *user, struct tile tile)
{
	if (tile.level > 8)
		return INFINITY;
	tile.x -= shift << (8 - tile.level);
	uint64_t place = (uint64_t)tile.x << 32 ^ (uint64_t)tile.y << 6 ^ (uint64_t)tile.level; /* x may have wrapped */
	return tile.level > 0 ? ldexp(0.2 + (double)(mix(place) % 100) / 100, tile.level - 1) : 0;
}

static bool flat_bounds(void *user, struct tile tile, double *low, double *high)
{
	*low = 0;
	*high = 10;
	return tile.level >= 0;
}

static void selection_by_error_does_not_depend_on_where_the_world_lies(void **state)
{
	struct fake fake = {.extent = {40000001, 1025, 0.25, 256}, .seed = 4, .resident_of = 100, .root_resident = true};
	const struct render_source source = {&fake, flat_bounds, fake_resident, fake_divisible, shifted_error, NULL};
	uint64_t keys[2][RENDER_DRAWS_MAX];
	size_t counts[2];
	for (int far = 0; far < 2; far++) {
		shift = far ? 609 : 1;
		const double eye[3] = {shift * 16384.0 + 700, 40, 60}, target[3] = {shift * 16384.0 + 800, 90, 0};
		struct render_view view;
		look(eye, target, 0, &view);
		by_error(500, 1, &view);
		render_select(&fake.extent, &view, &source, &selection);
		counts[far] = 0;
		for (size_t i = 0; i < selection.draw_count; i++) {
			struct tile tile = selection.draws[i].tile;
			if (tile.level > 8 || tile.x >> (8 - tile.level) != shift)
				continue;
			tile.x -= shift << (8 - tile.level);
			keys[far][counts[far]++] = tile_key(tile);
		}
	}
	assert_true(counts[0] > 20);
	assert_int_equal(counts[0], counts[1]);
	assert_memory_equal(keys[0], keys[1], counts[0] * sizeof keys[0][0]);
}

/* --- fitting, and sources that say anything --- */

static double wild_error(void *user, struct tile tile)
{
	const struct fake *fake = user;
	static const double wild[] = {NAN, -1, -INFINITY, INFINITY, 1e308, 1e-308, 0, 0.3, 5, 50};
	return wild[mix(tile_key(tile) ^ fake->seed) % 10];
}

static void check_fit(struct fake *fake, const struct render_source *source, const struct render_view *wished, size_t budget,
		      size_t *cut)
{
	struct render_view view = *wished;
	render_select(&fake->extent, wished, source, &selection);
	bool fits = render_fit(&fake->extent, source, budget, &view);
	assert_int_equal(fits, selection.needed <= budget);
	if (fits)
		return;
	++*cut;
	assert_true(view.by_error && (view.radius < wished->radius || view.finest > wished->finest));
	render_select(&fake->extent, &view, source, &selection);
	assert_true(selection.needed <= budget);
	/* Any finer needs too many. */
	if (view.finest > wished->finest)
		view.finest--;
	else
		view.radius = nextafter(view.radius, INFINITY);
	render_select(&fake->extent, &view, source, &selection);
	assert_true(selection.needed > budget);
}

static void a_view_by_error_is_fitted_as_finely_as_it_can_be(void **state)
{
	uint64_t random = 24;
	size_t cut = 0;
	for (int round = 0; round < 300; round++) {
		struct fake fake;
		struct render_view view;
		random_scene(&random, &fake, &view);
		struct render_source source = source_of(&fake);
		check_fit(&fake, &source, &view, 1 + (size_t)(40 * unit(&random) * unit(&random)), &cut);
	}
	assert_true(cut > 80);
}

static void whatever_a_source_calls_an_error_each_point_is_drawn_once(void **state)
{
	uint64_t random = 25;
	size_t seen = 0, cut = 0;
	for (int round = 0; round < 200; round++) {
		struct fake fake;
		struct render_view view;
		random_scene(&random, &fake, &view);
		fake.resident_of = (unsigned)(101 * unit(&random));
		struct render_source source = source_of(&fake);
		source.error = wild_error;
		render_select(&fake.extent, &view, &source, &selection);
		for (size_t i = 0; i < selection.draw_count; i++)
			for (int k = 0; k < RENDER_STRIDES; k++)
				assert_true(selection.draws[i].errors[k] >= (k > 0 ? selection.draws[i].errors[k - 1] : 0));
		for (int i = 0; i < 300; i++) {
			double point[3] = {(double)(fake.extent.width - 1) * fake.extent.spacing * unit(&random),
					   (double)(fake.extent.height - 1) * fake.extent.spacing * unit(&random), 0};
			struct tile tile;
			point[2] = fake_height(point[0], point[1]);
			if (!in_frustum(&view, point))
				continue;
			assert_int_equal(drawn_at(&fake, point, &tile), 1);
			seen++;
		}
		check_fit(&fake, &source, &view, 1 + (size_t)(20 * unit(&random)), &cut);
	}
	assert_true(seen > 5000 && cut > 20);
}

TEST_PROGRAM(selection_error)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_visible_point_has_the_tile_that_its_error_asks_for),
		cmocka_unit_test(a_draw_tells_its_error_and_that_of_all_above_it),
		cmocka_unit_test(allowed_less_a_view_is_nowhere_coarser),
		cmocka_unit_test(flat_ground_takes_few_tiles_and_a_cliff_many),
		cmocka_unit_test(selection_by_error_does_not_depend_on_where_the_world_lies),
		cmocka_unit_test(a_view_by_error_is_fitted_as_finely_as_it_can_be),
		cmocka_unit_test(whatever_a_source_calls_an_error_each_point_is_drawn_once),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
