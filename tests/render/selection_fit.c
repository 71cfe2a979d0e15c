/* Fitting a view into fewer tiles: never more than the budget, no coarser than it must be, and only
 * what is furthest for its size is given up. */
#include "selection_fake.h"
#include "../support/program.h"

static struct render_selection selection;

static bool nothing_resident(void *user, struct tile tile, uint32_t *slot)
{
	return false;
}

static void random_scene(uint64_t *random, struct fake *fake, struct render_view *view)
{
	random_fake(random, fake);
	fake->resident_of = 100;
	random_view(fake, random, view);
}

static size_t distinct(const struct fake *fake)
{
	/* Tiles of the complete picture: drawn, grounds, the coarsest. */
	uint64_t keys[2 * RENDER_DRAWS_MAX + 1];
	size_t count = 0;
	keys[count++] = tile_key((struct tile){extent_coarsest(&fake->extent), 0, 0});
	for (size_t i = 0; i < 2 * selection.draw_count; i++) {
		const struct render_draw *draw = &selection.draws[i / 2];
		struct tile tile = i % 2 == 0 || draw->tile.level >= 0 ? draw->tile : tile_ancestor(draw->tile, 0);
		uint64_t key = tile_key(tile);
		bool again = false;
		for (size_t k = 0; k < count && !again; k++)
			again = keys[k] == key;
		if (!again)
			keys[count++] = key;
	}
	return count;
}

static void what_a_picture_needs_is_counted_and_wanted_once_each(void **state)
{
	uint64_t random = 11;
	size_t below = 0;
	for (int round = 0; round < 200; round++) {
		struct fake fake;
		struct render_view view;
		random_scene(&random, &fake, &view);
		struct render_source source = source_of(&fake);
		render_select(&fake.extent, &view, &source, &selection);
		size_t needed = selection.needed;
		assert_int_equal(needed, distinct(&fake));
		for (size_t i = 0; i < selection.draw_count; i++) {
			below += selection.draws[i].tile.level < 0;
			assert_false(selection.draws[i].replaces);
		}
		/* The same picture, whatever is resident; without anything, all of it is wanted. */
		source.resident = nothing_resident;
		render_select(&fake.extent, &view, &source, &selection);
		assert_int_equal(selection.needed, needed);
		assert_int_equal(selection.draw_count, 0);
		assert_int_equal(selection.wanted_count, needed);
		for (size_t i = 1; i < selection.wanted_count; i++)
			assert_true(tile_from_key(selection.wanted[i]).level <= tile_from_key(selection.wanted[i - 1]).level);
	}
	assert_true(below > 100);
}

static void what_only_stands_in_is_told_from_what_is_needed(void **state)
{
	uint64_t random = 12;
	size_t standing = 0;
	for (int round = 0; round < 200; round++) {
		struct fake fake;
		struct render_view view;
		random_scene(&random, &fake, &view);
		fake.resident_of = 60;
		struct render_source source = source_of(&fake);
		render_select(&fake.extent, &view, &source, &selection);
		static struct render_selection all;
		source.resident = nothing_resident;
		render_select(&fake.extent, &view, &source, &all);
		for (size_t i = 0; i < selection.draw_count; i++) {
			bool needed = false;
			for (size_t k = 0; k < all.wanted_count && !needed; k++)
				needed = all.wanted[k] == tile_key(selection.draws[i].tile);
			assert_int_equal(selection.draws[i].replaces, !needed);
			standing += !needed;
		}
	}
	assert_true(standing > 200);
}

/* The radius grown by one step at the least, or the next level let in: needs more than the budget. */
static bool could_be_finer(const struct fake *fake, const struct render_view *wished, const struct render_view *fitted,
			   size_t budget)
{
	struct render_source source = source_of((struct fake *)fake);
	struct render_view finer = *fitted;
	if (fitted->finest > wished->finest) {
		finer.finest--; /* of the tiles the eye is inside */
	} else {
		finer.radius = nextafter(fitted->radius, INFINITY);
	}
	render_select(&fake->extent, &finer, &source, &selection);
	return selection.needed <= budget;
}

static void a_fitted_view_needs_no_more_than_the_budget_and_is_as_fine_as_it_can_be(void **state)
{
	uint64_t random = 13;
	size_t cut = 0, floors = 0, whole = 0;
	for (int round = 0; round < 400; round++) {
		struct fake fake;
		struct render_view wished, view;
		random_scene(&random, &fake, &wished);
		struct render_source source = source_of(&fake);
		size_t budget = 1 + (size_t)(40 * unit(&random) * unit(&random));
		render_select(&fake.extent, &wished, &source, &selection);
		size_t needed = selection.needed;
		view = wished;
		bool fits = render_fit(&fake.extent, &source, budget, &view);
		assert_int_equal(fits, needed <= budget);
		if (fits) {
			assert_memory_equal(&view, &wished, sizeof view);
			whole++;
			continue;
		}
		cut++;
		floors += view.finest > wished.finest;
		assert_true(view.radius < wished.radius || view.finest > wished.finest);
		render_select(&fake.extent, &view, &source, &selection);
		assert_true(selection.needed <= budget);
		assert_false(could_be_finer(&fake, &wished, &view, budget));
		/* Fitted again it is the same; and what is resident does not matter. */
		struct render_view again = wished;
		fake.resident_of = 0;
		assert_false(render_fit(&fake.extent, &source, budget, &again));
		assert_memory_equal(&again, &view, sizeof view);
	}
	assert_true(cut > 100 && floors > 20 && whole > 20);
}

static void fitting_a_view_of_very_many_tiles_costs_what_the_budget_does(void **state)
{
	/* Far more tiles than there is room for anywhere. */
	struct fake fake = {.extent = {4097, 4097, 1, 8}, .seed = 4, .resident_of = 100, .root_resident = true};
	struct render_source source = source_of(&fake);
	struct render_view view;
	const double eye[3] = {2048, 2048, 900}, target[3] = {2048.1, 2048, 0};
	look(eye, target, 10000, &view);
	for (size_t budget = 1; budget <= RENDER_DRAWS_MAX; budget *= 4) {
		struct render_view fitted = view;
		assert_false(render_fit(&fake.extent, &source, budget, &fitted));
		render_select(&fake.extent, &fitted, &source, &selection);
		assert_true(selection.needed <= budget && selection.needed * 8 >= budget);
		assert_true(selection.visited + selection.culled <= 16 * budget);
	}
}

static void without_ground_there_is_nothing_to_fit(void **state)
{
	struct fake fake = {.extent = {65, 65, 1, 8}};
	struct render_source source = source_of(&fake);
	struct render_view view;
	const double eye[3] = {32, 32, 60}, away[3] = {32, 32, 160};
	look(eye, away, 5, &view);
	assert_true(render_fit(&fake.extent, &source, 1, &view));
	render_select(&fake.extent, &view, &source, &selection);
	assert_int_equal(selection.needed, 1);
}

TEST_PROGRAM(selection_fit)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_a_picture_needs_is_counted_and_wanted_once_each),
		cmocka_unit_test(what_only_stands_in_is_told_from_what_is_needed),
		cmocka_unit_test(a_fitted_view_needs_no_more_than_the_budget_and_is_as_fine_as_it_can_be),
		cmocka_unit_test(fitting_a_view_of_very_many_tiles_costs_what_the_budget_does),
		cmocka_unit_test(without_ground_there_is_nothing_to_fit),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
