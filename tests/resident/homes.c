/*
 * What pages do besides loading and committing, in both homes: they go back to a mark, move to another process, and make what their plan says.
 * One script of changes leaves the same rows in both. Host memory comes first in each test: without GL the other home skips it.
 */
#include "../support/program.h"
#include "planes_rig.h"

static int32_t saved[SIDE][SIDE][PLANES][POSTS];

static void begin(struct rig *rig, const char *path, bool host)
{
	support_store(path, extent, support_hills);
	rig_open(rig, path, ALL, true, host);
}

/* Changes some pages, and ends the step. */
static void change(struct rig *rig, int64_t step)
{
	for (int i = 0; i < 4; i++) {
		const uint32_t x = random_word() % SIDE, y = random_word() % SIDE;
		const uint64_t key = tile_key((struct tile){LEVEL, x, y});
		uint32_t slot;
		must(page_cache_pin(rig->cache, key, &slot));
		change_page(rig, slot, x, y);
		page_cache_unpin(rig->cache, key);
	}
	const int64_t tallies[3] = {rig->tallied += (int64_t)random_word(), 1, 2};
	memcpy(rig->tallies, tallies, sizeof tallies);
	if (rig->host == NULL)
		gpu_buffer_write(rig->tally, 0, sizeof tallies, tallies);
	rig->record->step = step;
	must(page_cache_end_step(rig->cache, rig->record));
}

/* Every page of the working level is what `truth` says. */
static void check_all(struct rig *rig)
{
	for (uint32_t y = 0; y < SIDE; y++)
		for (uint32_t x = 0; x < SIDE; x++) {
			const uint64_t key = tile_key((struct tile){LEVEL, x, y});
			uint32_t slot;
			must(page_cache_pin(rig->cache, key, &slot));
			check_page(rig, slot, x, y, ALL, true);
			page_cache_unpin(rig->cache, key);
		}
}

/* --- going back --- */

static void go_back(bool host)
{
	const char *path = support_path("back.furrow");
	struct rig rig;
	struct resident_pages_io at_mark, io;
	memset(truth, 0, sizeof truth);
	begin(&rig, path, host);
	assert_int_equal(resident_pages_rollback(rig.pages), STATUS_FAILED); /* there is no mark yet */
	for (int64_t step = 1; step <= 12; step++)
		change(&rig, step);
	must(page_cache_flush(rig.cache, rig.record));
	must(resident_pages_mark(rig.pages));
	resident_pages_io(rig.pages, &at_mark);
	const int64_t tallied = rig.tallied;
	memcpy(saved, truth, sizeof saved);
	for (int again = 0; again < 3; again++) {
		for (int64_t step = 13; step <= 13 + 4 * again; step++)
			change(&rig, step);
		if (again == 1)
			must(page_cache_flush(rig.cache, rig.record));
		must(resident_pages_rollback(rig.pages));
		rig.tallied = tallied;
		memcpy(truth, saved, sizeof truth);
		resident_pages_io(rig.pages, &io);
		assert_memory_equal(&io.sums, &at_mark.sums, sizeof io.sums);
		assert_int_equal(io.step, 12);
		check_all(&rig);
	}
	/* Another process wrote the store: here it is the same. */
	must(page_cache_flush(rig.cache, rig.record));
	must(resident_pages_forget(rig.pages));
	check_all(&rig);
	change(&rig, 13);
	must(page_cache_flush(rig.cache, rig.record));
	rig_close(&rig);
	support_verify(path);
	rig_open(&rig, path, ALL, true, true);
	check_all(&rig);
	rig_close(&rig);
}

static void pages_go_back_to_a_mark(void **state)
{
	go_back(true);
	go_back(false);
}

/* --- moves --- */

struct moved {
	struct {
		struct tile tile;
		unsigned planes;
		char *bytes;
	} pages[SIDE * SIDE];
	size_t count, bytes;
};

static enum status take(void *user, struct tile tile, unsigned planes, const void *bytes)
{
	struct moved *moved = user;
	char *copy = malloc(moved->bytes);
	assert_non_null(copy);
	if (planes != 0)
		memcpy(copy, bytes, moved->bytes);
	moved->pages[moved->count].tile = tile;
	moved->pages[moved->count].planes = planes;
	moved->pages[moved->count++].bytes = copy;
	return STATUS_OK;
}

/* Every page moves from one to the other; those that were not deformed, too. */
static void move(bool from_host, bool to_host)
{
	const char *other = support_path("to.furrow");
	struct rig from, to;
	struct moved moved = {.count = 0};
	uint64_t keys[SIDE * SIDE];
	memset(truth, 0, sizeof truth);
	begin(&to, other, to_host);
	for (int64_t step = 1; step <= 8; step++) /* what it has from before */
		change(&to, step);
	must(page_cache_flush(to.cache, to.record));
	change(&to, 9);
	memset(truth, 0, sizeof truth);
	begin(&from, support_path("from.furrow"), from_host);
	for (int64_t step = 1; step <= 6; step++)
		change(&from, step);
	must(page_cache_flush(from.cache, from.record));
	for (int64_t step = 7; step <= 10; step++)
		change(&from, step);
	moved.bytes = resident_pages_moved_bytes(from.pages);
	assert_int_equal(moved.bytes, resident_pages_moved_bytes(to.pages));
	for (uint32_t i = 0; i < SIDE * SIDE; i++)
		keys[i] = tile_key((struct tile){LEVEL, i % SIDE, i / SIDE});
	/* The other one gives up all that it has, so that it may be put. */
	struct moved none = {.bytes = moved.bytes};
	must(resident_pages_take(to.pages, keys, SIDE * SIDE, take, &none));
	must(resident_pages_take(from.pages, keys, SIDE * SIDE, take, &moved));
	assert_true(none.count == SIDE * SIDE && moved.count == SIDE * SIDE);
	size_t empty = 0;
	for (size_t i = 0; i < moved.count; i++) {
		empty += moved.pages[i].planes == 0;
		must(resident_pages_put(to.pages, moved.pages[i].tile, moved.pages[i].planes, moved.pages[i].bytes));
		if (i == SIDE * SIDE / 2)
			must(page_cache_flush(to.cache, to.record));
	}
	assert_true(empty > 10);
	check_all(&to);
	must(page_cache_flush(to.cache, to.record));
	check_all(&to);
	for (size_t i = 0; i < SIDE * SIDE; i++) {
		free(moved.pages[i].bytes);
		free(none.pages[i].bytes);
	}
	rig_close(&from);
	rig_close(&to);
	support_verify(other);
	rig_open(&to, other, ALL, true, true);
	check_all(&to);
	rig_close(&to);
}

static void pages_move_with_all_planes(void **state)
{
	move(true, true);
	move(true, false);
	move(false, true);
}

/* --- one script --- */

static uint64_t run_script(const char *path, bool host)
{
	struct rig rig;
	struct resident_pages_io io;
	luck = 12345;
	memset(truth, 0, sizeof truth);
	begin(&rig, path, host);
	for (int64_t step = 1; step <= 40; step++) {
		change(&rig, step);
		if (step % 10 == 0)
			must(page_cache_flush(rig.cache, rig.record));
	}
	check_all(&rig);
	resident_pages_io(rig.pages, &io);
	assert_int_equal(io.sums.compacted, rig.tallied);
	assert_int_equal(io.step, 40);
	resident_pages_stop(rig.pages);
	rig_close(&rig);
	return support_hash(path);
}

static void one_script_leaves_the_same_rows(void **state)
{
	const uint64_t host = run_script(support_path("one.furrow"), true);
	assert_true(host == run_script(support_path("other.furrow"), false));
}

/* --- threads --- */

enum { HANDS = 4, WINDOW = 40 };

struct hand {
	struct rig *rig;
	struct tile_slot held[4];
	struct post_rect rect;
	struct thread thread;
};

/* Adds one to the offset of each post of a window, and its step to the disturbance. */
static void *press(void *argument)
{
	struct hand *hand = argument;
	int32_t offset[WINDOW * WINDOW], base[WINDOW * WINDOW];
	uint8_t disturbance[WINDOW * WINDOW];
	const struct soil_planes planes = {.rect = hand->rect, .width = WINDOW, .base = base, .offset = offset, .disturbance = disturbance};
	resident_host_gather(hand->rig->host, hand->held, 4, &planes);
	for (int i = 0; i < WINDOW * WINDOW; i++) {
		offset[i]++;
		disturbance[i]++;
	}
	resident_host_scatter(hand->rig->host, hand->held, 4, &planes, hand->rect, PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DISTURBANCE));
	return NULL;
}

/* Four windows lie on the same four tiles, and share no post. Meanwhile commits write what steps before left, and loaders load. */
static void threads_write_windows_that_share_no_post(void **state)
{
	const char *path = support_path("threads.furrow");
	enum { STEPS = 60, STEPS_MOST = 100 * STEPS };
	struct resident_pages_io io = {.commits = 0};
	int steps = 0;
	struct rig rig;
	memset(truth, 0, sizeof truth);
	begin(&rig, path, true);
	struct hand hands[HANDS];
	/* More steps, if they are so fast that few commits were made beside them. */
	for (int step = 1; step <= STEPS || (io.commits <= 3 && step <= STEPS_MOST); steps = step++) {
		uint64_t keys[4], beside = tile_key((struct tile){LEVEL, (uint32_t)step % 3, (uint32_t)step % SIDE});
		uint32_t slots[4], slot;
		page_cache_want(rig.cache, &beside, 1);
		for (uint32_t i = 0; i < 4; i++)
			keys[i] = tile_key((struct tile){LEVEL, 3 + i % 2, 3 + i / 2});
		must(page_cache_pin_all(rig.cache, keys, 4, slots));
		for (uint32_t i = 0; i < 4; i++)
			must(resident_host_write(rig.host, slots[i], ALL));
		for (int h = 0; h < HANDS; h++) {
			const int64_t x = h % 2 == 0 ? 100 : 140, y = h / 2 == 0 ? 110 : 150, side = h % 2 == 0 ? WINDOW : 15;
			hands[h] = (struct hand){.rig = &rig, .rect = {x, y, x + side, y + (h / 2 == 0 ? WINDOW : 8)}};
			for (uint32_t i = 0; i < 4; i++)
				hands[h].held[i] = (struct tile_slot){tile_from_key(keys[i]), slots[i]};
		}
		for (int h = 0; h < HANDS; h++)
			must(thread_start(&hands[h].thread, press, &hands[h], "hand"));
		for (int h = 0; h < HANDS; h++)
			thread_join(&hands[h].thread);
		for (uint32_t i = 0; i < 4; i++) {
			page_cache_dirty(rig.cache, keys[i]);
			page_cache_unpin(rig.cache, keys[i]);
		}
		rig.record->step = step;
		must(page_cache_end_step(rig.cache, rig.record));
		if (step % 7 == 0) { /* all leave their slots */
			for (uint32_t i = 0; i < SLOTS; i++) {
				const uint64_t key = tile_key((struct tile){LEVEL, i % SIDE, i / SIDE});
				must(page_cache_pin(rig.cache, key, &slot));
				page_cache_unpin(rig.cache, key);
			}
		}
		resident_pages_io(rig.pages, &io);
	}
	assert_true(io.commits > 3);
	must(page_cache_flush(rig.cache, rig.record));
	rig_close(&rig);
	support_verify(path);
	double *units = support_quanta(path, LEVEL, (struct post_rect){96, 96, 161, 161});
	for (int i = 0; i < 65 * 65; i++) {
		const int x = 96 + i % 65, y = 96 + i / 65;
		bool in = false;
		for (int h = 0; h < HANDS; h++)
			in = in || (x >= hands[h].rect.x0 && x < hands[h].rect.x1 && y >= hands[h].rect.y0 && y < hands[h].rect.y1);
		assert_true(units[i] == (in ? steps : 0));
	}
	free(units);
}

/* --- plans --- */

static uint64_t units_of(const struct resident_host_figures *figures, enum plan_unit unit)
{
	if (unit >= PLAN_HOST_OFFSET && unit < PLAN_HOST_OFFSET + PLANES)
		return figures->planes[unit - PLAN_HOST_OFFSET];
	return unit == PLAN_ONCE           ? 1
	       : unit == PLAN_HOST_BASE    ? figures->bases
	       : unit == PLAN_HOST_CLASSES ? figures->classes
	       : unit == PLAN_HOST_NUMBERS ? figures->levels
					   : 0;
}

static void what_is_made_is_planned(void **state)
{
	struct rig rig;
	struct plan plan = {.lines = NULL};
	struct resident_host_figures figures;
	struct resident_pages_io io;
	uint64_t bytes = 0;
	memset(truth, 0, sizeof truth);
	begin(&rig, support_path("planned.furrow"), true);
	for (int64_t step = 1; step <= 30; step++)
		change(&rig, step);
	must(page_cache_flush(rig.cache, rig.record));
	resident_pages_plan(&(struct pages_planned){.cells = CELLS, .planes = ALL, .loaders = 2, .deforms = true, .classes = true, .numbers = true,
						    .host = true, .classes_effect = "classes", .numbers_effect = "numbers"}, &plan);
	must(plan_status(&plan));
	resident_host_figures(rig.host, &figures);
	for (size_t i = 0; i < plan.count; i++)
		if (plan.lines[i].kind == PLAN_BUFFER) {
			assert_true(units_of(&figures, plan.lines[i].unit) > 0);
			bytes += plan.lines[i].bytes * units_of(&figures, plan.lines[i].unit);
		}
	resident_pages_io(rig.pages, &io);
	assert_int_equal(bytes, io.host_bytes);
	assert_int_equal(bytes, figures.bytes + PAGES_TALLY_BYTES);
	assert_true(figures.planes[PLANE_DUG] < SIDE * SIDE && figures.bases <= SLOTS + page_load_images(2));
	plan_finish(&plan);
	rig_close(&rig);
}

TEST_PROGRAM(homes)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(pages_go_back_to_a_mark),
		cmocka_unit_test(pages_move_with_all_planes),
		cmocka_unit_test(one_script_leaves_the_same_rows),
		cmocka_unit_test(threads_write_windows_that_share_no_post),
		cmocka_unit_test(what_is_made_is_planned),
	};
	return cmocka_run_group_tests_name("homes", tests, support_enter, support_leave);
}
