/*
 * A view and the slots it lives in: it settles in any number of them, looks ahead without touching
 * anything, and asks for what it needs in the order of need.
 */
#include <time.h>

#include "view_rig.h"
#include "../support/program.h"

static void nap(void)
{
	nanosleep(&(struct timespec){0, 1000000}, NULL);
}

/* A step in which nothing is deformed, and its picture. */
static void step(struct rig *rig, double time_step)
{
	must(page_cache_poll(rig->made.resident.cache));
	must(resident_look_ahead_step(rig->made.ahead, rig->made.time));
	rig->made.step++;
	rig_at(rig, rig->made.time + time_step);
	must(page_cache_end_step(rig->made.resident.cache, rig->record));
	must(render_view_frame(rig->view, NULL, false));
}

static uint64_t traffic(struct rig *rig)
{
	struct page_stats stats;
	page_cache_stats(rig->made.resident.cache, &stats);
	return stats.prefetched + stats.evictions + stats.misses;
}

/* --- slots --- */

/* A budget below the visible set does not spin. */
static void a_still_view_settles_in_any_number_of_slots(void **state)
{
	const uint32_t counts[] = {4, 8, 16, 64, 400};
	size_t drawn = 0;
	for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
		struct rig rig;
		rig_open(&rig, counts[i], 0, 1.5);
		struct view *view = rig.view;
		int frames = 0;
		uint64_t before = 0;
		for (int quiet = 0; quiet < 30; quiet++) {
			assert_true(frames++ < 100000); /* or it never comes to rest */
			step(&rig, 0.02);
			nap();
			assert_true(view->selection->draw_count > 0);
			if (traffic(&rig) != before || view->selection->wanted_count > 0) /* a loader may have no processor for a while */
				quiet = 0;
			before = traffic(&rig);
		}
		/* All of the picture that fits is there, and so it stays. */
		assert_true(view->selection->needed <= view->budget && view->budget < counts[i]);
		assert_true(view->selection->draw_count >= drawn);
		drawn = view->selection->draw_count;
		struct render_view_figures at_rest, later;
		render_view_figures(view, &at_rest);
		for (int k = 0; k < 20; k++)
			step(&rig, 0.02);
		assert_int_equal(traffic(&rig), before);
		render_view_figures(view, &later);
		assert_int_equal(later.coarsened, counts[i] < 400 ? frames + 20 : 0);
		assert_int_equal(later.starved - at_rest.starved, counts[i] < 400 ? 20 : 0);
		rig_close(&rig);
	}
	assert_true(drawn > 50);
}

static void a_picture_that_is_kept_has_all_that_fits(void **state)
{
	const uint32_t counts[] = {4, 8, 64, 400};
	for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
		struct rig rig;
		rig_open(&rig, counts[i], 0, 0);
		must(render_view_frame(rig.view, NULL, true));
		assert_int_equal(rig.view->selection->wanted_count, 0);
		struct render_view_figures figures;
		render_view_figures(rig.view, &figures);
		assert_int_equal(figures.starved, counts[i] < 400);
		rig_close(&rig);
	}
}

/* --- ahead --- */

struct residents {
	uint64_t keys[1024];
	size_t count;
};

static void resident(void *user, uint64_t key, uint32_t slot, bool dirty)
{
	struct residents *residents = user;
	residents->keys[residents->count++] = key;
}

/* Steps until the view has nothing to wish for at this time. */
static void load_wishes(struct rig *rig)
{
	for (int tries = 0;; tries++) {
		assert_true(tries < 100000);
		resident_requests_clear(&rig->requests);
		must(render_view_requests(rig->view, &rig->requests));
		if (rig->requests.count == 0)
			return;
		const uint64_t *keys;
		size_t count = resident_requests_order(&rig->requests, &keys);
		page_cache_want(rig->made.resident.cache, keys, count);
		nap();
		must(page_cache_poll(rig->made.resident.cache));
	}
}

static uint64_t starved_frames(double prefetch)
{
	struct rig rig;
	rig_open(&rig, 128, 25, prefetch);
	must(render_view_warm(rig.view));
	for (int i = 0; i < 150; i++) {
		load_wishes(&rig); /* whatever was wished for is there in time */
		step(&rig, 0.1);
	}
	struct render_view_figures figures;
	render_view_figures(rig.view, &figures);
	assert_int_equal(figures.coarsened, 0);
	rig_close(&rig);
	return figures.starved;
}

static void looking_ahead_a_moving_picture_lacks_less(void **state)
{
	uint64_t without = starved_frames(0), with = starved_frames(2);
	print_message("starved frames: %d without, %d with\n", (int)without, (int)with);
	assert_true(without >= 15);
	assert_true(with * 5 <= without);
}

static void wishes_are_what_is_lacking_now_then_what_will_be(void **state)
{
	struct rig rig;
	rig_open(&rig, 128, 25, 2);
	struct view *view = rig.view;
	size_t soon = 0, ahead = 0;
	for (int i = 0; i < 60; i++) {
		must(page_cache_poll(rig.made.resident.cache));
		rig_at(&rig, rig.made.time + 0.1);
		must(page_cache_end_step(rig.made.resident.cache, rig.record));
		must(render_view_frame(view, NULL, false));
		/* What the frame lacked, before it looked ahead. */
		struct render_camera camera;
		render_view_place_camera(view, rig.made.time, &camera);
		must(render_view_select(view, &camera, false));
		resident_requests_clear(&rig.requests);
		must(render_view_requests(view, &rig.requests));
		const struct request *wishes = rig.requests.requests;
		size_t count = rig.requests.count, lacking = view->selection->wanted_count;
		assert_true(count >= lacking && view->seen.count <= view->room);
		for (size_t k = 0; k < count; k++) {
			uint32_t slot;
			assert_false(page_cache_peek(rig.made.resident.cache, wishes[k].key, false, &slot));
			if (k < lacking) {
				assert_true(wishes[k].key == view->selection->wanted[k]);
				assert_true(wishes[k].time == rig.made.time);
			} else {
				assert_true(wishes[k].time > rig.made.time && wishes[k].time <= rig.made.time + 2);
			}
			assert_true(k == 0 || wishes[k].time >= wishes[k - 1].time);
		}
		soon += lacking;
		ahead += count - lacking;
		if (i % 3 == 0)
			load_wishes(&rig);
	}
	assert_true(soon > 10 && ahead > 10);
	rig_close(&rig);
}

static void wishes_ahead_are_soonest_first_and_end_with_the_room(void **state)
{
	struct rig rig;
	rig_open(&rig, 64, 25, 2);
	struct view *view = rig.view;
	uint64_t keys[6];
	for (uint32_t i = 0; i < 6; i++)
		keys[i] = tile_key((struct tile){0, i, 1});
	rig_at(&rig, 1);
	view->room = 4;
	view->ahead[0] = (struct view_look){.time = 3, .count = 2, .keys = {keys[0], keys[1]}};
	view->ahead[1] = (struct view_look){.time = 1, .count = 1, .keys = {keys[2]}}; /* has passed */
	view->ahead[2] = (struct view_look){.time = 2, .count = 2, .keys = {keys[3], keys[0]}};
	view->ahead[3] = (struct view_look){.time = 2.5, .count = 3, .keys = {keys[3], keys[4], keys[5]}};
	must(render_view_requests(view, &rig.requests));
	const struct { uint64_t key; double time; } expected[] = {{keys[3], 2}, {keys[0], 2}, {keys[4], 2.5}, {keys[5], 2.5}};
	assert_int_equal(rig.requests.count, 4);
	for (size_t i = 0; i < 4; i++) {
		assert_true(rig.requests.requests[i].key == expected[i].key);
		assert_true(rig.requests.requests[i].time == expected[i].time);
	}
	rig_close(&rig);
}

static size_t below_zero(const struct view *view)
{
	size_t count = 0;
	for (int i = 0; i < VIEW_LOOKS; i++)
		for (size_t k = 0; k < view->ahead[i].count; k++)
			count += tile_from_key(view->ahead[i].keys[k]).level < 0;
	return count;
}

static void looking_ahead_the_ground_is_divided_where_the_objects_will_be(void **state)
{
	struct rig rig;
	rig_lay_straight();
	rig_open(&rig, 128, 25, 2);
	rig_lay_hills();
	for (int i = 0; i < VIEW_LOOKS; i++)
		must(render_view_look_ahead(rig.view));
	assert_int_equal(below_zero(rig.view), 0);
	rig_at_level(&rig, -2);
	start_look_ahead(&rig);
	must(resident_look_ahead_step(rig.made.ahead, rig.made.time));
	for (int i = 0; i < VIEW_LOOKS; i++)
		must(render_view_look_ahead(rig.view));
	assert_true(below_zero(rig.view) >= 8);
	/* Not yet: the picture of now has nothing finer than the ground. */
	must(render_view_frame(rig.view, NULL, false));
	const struct view_look *now = rig.view->now;
	assert_true(now->count > 20);
	for (size_t i = 0; i < now->count; i++)
		assert_true(tile_from_key(now->keys[i]).level >= 0);
	assert_int_equal(rig.view->deformed.count, 0);
	rig_close(&rig);
}

/* Ground that nothing deformed: finer tiles are drawn where the ground bends between its posts, and nowhere else. */
static void bent_ground_is_drawn_finely_and_straight_ground_is_not(void **state)
{
	for (int straight = 0; straight < 2; straight++)
		for (int level = 0; level >= -3; level--) {
			struct rig rig;
			if (straight)
				rig_lay_straight();
			rig_open(&rig, 400, 0, 0);
			rig_lay_hills();
			rig_at_level(&rig, level);
			rig.scene.view.aim.eye[2] = 107; /* near the ground */
			must(render_view_frame(rig.view, NULL, true));
			const struct render_selection *selection = rig.view->selection;
			size_t finer = 0;
			int finest = 0;
			for (size_t i = 0; i < selection->draw_count; i++) {
				const struct render_draw *draw = &selection->draws[i];
				double bend = 0;
				finer += draw->tile.level < 0;
				finest = draw->tile.level < finest ? draw->tile.level : finest;
				assert_true(draw->tile.level >= level && draw->ground_level == (draw->tile.level < 0 ? 0 : draw->tile.level));
				if (draw->tile.level < 0)
					must(render_view_bend(rig.view, draw->tile, &bend));
				assert_true(draw->tile.level >= 0 || bend > 0.0001);
			}
			assert_int_equal(finest, straight ? 0 : level);
			assert_true(straight ? finer == 0 : level == 0 || finer >= 4);
			assert_int_equal(selection->wanted_count, 0);
			assert_false(rig.view->coarse);
			rig_close(&rig);
		}
}

static void however_far_it_looks_an_object_wishes_for_no_more_than_the_slots(void **state)
{
	struct rig rig;
	rig_open(&rig, 8, 25, 1000);
	rig_at_level(&rig, -4);
	start_look_ahead(&rig);
	for (; rig.made.time < 2; rig_at(&rig, rig.made.time + 0.1)) {
		must(resident_look_ahead_step(rig.made.ahead, rig.made.time));
		size_t count = 0, next = 0;
		for (size_t i = 0; i < resident_look_ahead_requests(rig.made.ahead)->count; i++) {
			count += tile_from_key(resident_look_ahead_requests(rig.made.ahead)->requests[i].key).level == -4;
			next += tile_from_key(resident_look_ahead_requests(rig.made.ahead)->requests[i].key).level == -4 &&
				resident_look_ahead_requests(rig.made.ahead)->requests[i].time <= rig.made.time + 0.05;
		}
		assert_true(next > 0 && count < 8 + 4); /* the last station has a window of four */
	}
	rig_close(&rig);
}

static void looking_ahead_marks_nothing_used(void **state)
{
	struct rig rig;
	rig_open(&rig, 128, 25, 2);
	must(render_view_warm(rig.view));
	for (int i = 0; i < 40; i++) {
		step(&rig, 0.1);
		load_wishes(&rig);
		struct residents before = {.count = 0}, after = {.count = 0};
		page_cache_each_resident(rig.made.resident.cache, resident, &before);
		must(render_view_look_ahead(rig.view));
		resident_requests_clear(&rig.requests);
		must(render_view_requests(rig.view, &rig.requests));
		page_cache_each_resident(rig.made.resident.cache, resident, &after);
		/* Least recently used first: the order is the marks. */
		assert_memory_equal(&before, &after, sizeof before);
	}
	rig_close(&rig);
}

static void what_a_frame_drew_was_used_last(void **state)
{
	struct rig rig;
	rig_open(&rig, 128, 25, 2);
	must(render_view_warm(rig.view));
	for (int i = 0; i < 40; i++) {
		load_wishes(&rig);
		step(&rig, 0.1);
		struct residents residents = {.count = 0};
		page_cache_each_resident(rig.made.resident.cache, resident, &residents);
		const struct view_look *now = rig.view->now;
		uint32_t slot;
		size_t drawn = 0;
		for (size_t k = 0; k < now->count; k++)
			drawn += page_cache_peek(rig.made.resident.cache, now->keys[k], false, &slot);
		struct key_set last = {.count = 0};
		for (size_t k = residents.count - drawn - 1; k < residents.count; k++) /* and the coarsest */
			must(key_set_add(&last, residents.keys[k]));
		for (size_t k = 0; k < now->count; k++)
			assert_true(key_set_has(&last, now->keys[k]) ||
				    !page_cache_peek(rig.made.resident.cache, now->keys[k], false, &slot));
		key_set_finish(&last);
	}
	rig_close(&rig);
}

static void note_program(void *user, const char *name, uint64_t passes)
{
	size_t *count = user;
	if (strstr(name, "terrain.") == NULL && strstr(name, "sky.") == NULL && strstr(name, "object.") == NULL &&
	    strstr(name, "shadow.") == NULL)
		return;
	if (passes == 0)
		print_error("never drawn: %s\n", name);
	assert_true(passes > 0);
	++*count;
}

/* Also with those of what is not there yet: nothing is deformed, and no object is in the picture. */
static void every_program_of_a_picture_has_drawn_before_the_first_step(void **state)
{
	struct rig rig;
	size_t count = 0;
	rig_open(&rig, 64, 0, 0);
	render_view_destroy(rig.view);
	rig.scene.view.effects = EFFECT_BIT(EFFECT_SKY) | EFFECT_BIT(EFFECT_OBJECTS) | EFFECT_BIT(EFFECT_SHADOW);
	rig.made.resident.level = -2;
	rig_set(&rig);
	must(render_view_create(rig.world, false, &rig.view));
	must(render_view_warm(rig.view));
	gpu_programs_each(rig.made.resident.gpu, note_program, &count);
	assert_int_equal(count, 7);
	/* None of it is a picture of the drive's. */
	struct render_view_figures figures;
	render_view_settle(rig.view);
	render_view_figures(rig.view, &figures);
	assert_true(isnan(figures.overdraw) && figures.tiles.drawn == 0 && figures.triangles == 0);
	must(render_view_frame(rig.view, NULL, false));
	render_view_settle(rig.view);
	render_view_figures(rig.view, &figures);
	assert_true(figures.overdraw > 0.1 && figures.overdraw < 2 && rig.view->overdraw_frames == 1);
	rig_close(&rig);
}

/* --- the camera --- */

static void the_camera_ahead_is_the_camera_when_that_time_has_come(void **state)
{
	struct rig rig;
	rig_open(&rig, 64, 25, 2);
	struct render_camera ahead, then;
	rig_at(&rig, 3);
	render_view_place_camera(rig.view, 5, &ahead);
	rig_at(&rig, 5);
	render_view_place_camera(rig.view, 5, &then);
	assert_memory_equal(&ahead, &then, sizeof then);
	render_view_place_camera(rig.view, 3, &then);
	assert_true(hypot(then.eye[0] - ahead.eye[0], then.eye[1] - ahead.eye[1]) > 49);
	rig_close(&rig);
}

/* --- ranges --- */

/* As start_look_ahead does, with its thread. */
static void start_bringing(struct rig *rig)
{
	resident_look_ahead_destroy(rig->made.ahead);
	rig_make_look_ahead(rig);
	rig_serve_look_ahead(rig);
}

static uint64_t range_waits(const struct rig *rig)
{
	struct resident_ground_figures figures;
	resident_ground_figures(rig->made.resident.ground, &figures);
	return figures.range_waits;
}

static void looking_ahead_waits_for_no_range_at(int level)
{
	struct rig rig;
	rig_open(&rig, 400, 25, 2);
	rig_at_level(&rig, level);
	start_look_ahead(&rig);
	start_bringing(&rig);
	struct view *view = rig.view;
	bool guessed = true;
	for (int tries = 0; guessed; tries++) {
		assert_true(tries < 100000);
		guessed = false;
		for (int i = 0; i < VIEW_LOOKS; i++) {
			must(render_view_look_ahead(view));
			guessed = guessed || view->guessed;
		}
		assert_true(tries > 0 || guessed);
		assert_true(guessed == (view->missing_count > 0));
		render_view_ask_ranges(view);
		nap();
	}
	/* Nothing stands in for the coarsest tile's: it is read. */
	assert_true(range_waits(&rig) <= 1);
	rig_at(&rig, view->ahead[1].time);
	must(render_view_frame(view, NULL, true));
	assert_true(view->now->count > 10);
	assert_true(range_waits(&rig) <= 1);
	rig_close(&rig);
}

static void looking_ahead_waits_for_no_range(void **state)
{
	looking_ahead_waits_for_no_range_at(0);
	looking_ahead_waits_for_no_range_at(-2);
}

/* It is drawn with the ranges of coarser tiles, and again when its own have come: then it is as if they had been read. */
static void a_picture_in_a_window_waits_for_no_range(void **state)
{
	struct rig rig;
	rig_open(&rig, 400, 0, 2);
	start_bringing(&rig);
	struct view *view = rig.view;
	must(render_view_frame(view, NULL, false));
	assert_true(view->guessed && render_view_lacks(view));
	for (int tries = 0; render_view_lacks(view); tries++) {
		assert_true(tries < 100000);
		step(&rig, 0.02);
		nap();
	}
	assert_true(range_waits(&rig) <= 1);
	static struct render_selection seen, read;
	seen = *view->selection;
	struct render_camera camera;
	render_view_place_camera(view, rig.made.time, &camera);
	key_cache_finish(&view->ranges);
	view->ranges = (struct key_cache){.most = 1024};
	resident_look_ahead_stop(rig.made.ahead);
	resident_ground_destroy(rig.made.resident.ground);
	must(resident_ground_create(rig.made.resident.store, 16, &rig.made.resident.ground));
	rig_set(&rig);
	must(render_view_select(view, &camera, false));
	read = *view->selection;
	assert_true(range_waits(&rig) > 20 && seen.draw_count > 50);
	assert_int_equal(read.draw_count, seen.draw_count);
	for (size_t i = 0; i < seen.draw_count; i++)
		assert_true(tile_equal(read.draws[i].tile, seen.draws[i].tile) && read.draws[i].quadrants == seen.draws[i].quadrants);
	rig_close(&rig);
}

TEST_PROGRAM(view)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_still_view_settles_in_any_number_of_slots),
		cmocka_unit_test(a_picture_that_is_kept_has_all_that_fits),
		cmocka_unit_test(looking_ahead_a_moving_picture_lacks_less),
		cmocka_unit_test(wishes_are_what_is_lacking_now_then_what_will_be),
		cmocka_unit_test(wishes_ahead_are_soonest_first_and_end_with_the_room),
		cmocka_unit_test(looking_ahead_the_ground_is_divided_where_the_objects_will_be),
		cmocka_unit_test(bent_ground_is_drawn_finely_and_straight_ground_is_not),
		cmocka_unit_test(however_far_it_looks_an_object_wishes_for_no_more_than_the_slots),
		cmocka_unit_test(looking_ahead_marks_nothing_used),
		cmocka_unit_test(what_a_frame_drew_was_used_last),
		cmocka_unit_test(every_program_of_a_picture_has_drawn_before_the_first_step),
		cmocka_unit_test(the_camera_ahead_is_the_camera_when_that_time_has_come),
		cmocka_unit_test(looking_ahead_waits_for_no_range),
		cmocka_unit_test(a_picture_in_a_window_waits_for_no_range),
	};
	return cmocka_run_group_tests_name("view", tests, support_enter, support_leave);
}
