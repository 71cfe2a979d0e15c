/*
 * Queries over a running drive: the same answers, to the bit, while a rut is in its slot alone, when it was evicted into the
 * queue, once it is committed, and over the store by itself; those of the posts that the store has. And a drive that is
 * asked all the time leaves what one leaves that is not.
 */
#include "rig.h"
#include "../support/program.h"

enum { POINTS = 1500, RAYS = 600, SLOTS = 6 };

static double hills_with_a_hole(int64_t x, int64_t y)
{
	return x > 100 && x < 110 && y > 90 && y < 97 ? (double)NAN : support_hills(x, y);
}

static double level_ground(int64_t x, int64_t y)
{
	return 100;
}

/* --- asking --- */

static struct resident_point points[POINTS];
static struct resident_ray rays[RAYS];

static void choose(void)
{
	uint64_t state = 11;
	for (int i = 0; i < POINTS + RAYS; i++) {
		double at[6];
		for (int k = 0; k < 6; k++) {
			state = state * 6364136223846793005u + 1442695040888963407u;
			at[k] = (double)(state >> 11) * 0x1p-53;
		}
		if (i < POINTS) /* every third at a post of the finest there is */
			points[i] = i % 3 == 0 ? (struct resident_point){floor(at[0] * 1024) / 8, floor(at[1] * 1024) / 8}
					       : (struct resident_point){at[0] * 130 - 1, at[1] * 130 - 1};
		else
			rays[i - POINTS] = (struct resident_ray){{at[0] * 128, at[1] * 128, 90 + 20 * at[2]},
								{at[3] - 0.5, at[4] - 0.5, 0.3 * (at[5] - 0.5)},
								at[5] < 0.2 ? (double)INFINITY : 60};
	}
}

struct answers {
	struct resident_height heights[POINTS];
	struct resident_hit hits[RAYS];
};

static struct answers before, after;

static void ask(struct newest *newest, struct answers *answers)
{
	memset(answers, 0, sizeof *answers);
	must(resident_newest_heights(newest, points, POINTS, answers->heights));
	must(resident_newest_rays(newest, rays, RAYS, answers->hits));
}

/* With nothing kept from before. */
static void ask_anew(struct rig *rig, struct answers *answers)
{
	resident_newest_destroy(rig->ground.newest);
	rig->ground.newest = NULL;
	must(resident_newest_create(rig->ground.store, rig->ground.pages, &rig->ground.newest));
	must(resident_newest_heights(rig->ground.newest, points, POINTS, answers->heights));
	ask(rig->ground.newest, answers);
}

static void check_same(const struct answers *a, const struct answers *b)
{
	for (int i = 0; i < POINTS; i++)
		assert_memory_equal(&a->heights[i], &b->heights[i], offsetof(struct resident_height, nodata) + sizeof a->heights[i].nodata); /* what follows is padding */
	for (int i = 0; i < RAYS; i++) {
		assert_int_equal(a->hits[i].hit, b->hits[i].hit);
		assert_true(a->hits[i].distance == b->hits[i].distance && a->hits[i].normal[0] == b->hits[i].normal[0] &&
			    a->hits[i].below == b->hits[i].below && tile_equal(a->hits[i].tile, b->hits[i].tile));
	}
}

static void look(void *user, const struct page_image *image)
{
	++*(size_t *)user;
}

/* How many tiles of the level are where; of the store those with offsets. */
static void places(struct rig *rig, size_t where[3])
{
	size_t looks = 0;
	memset(where, 0, 3 * sizeof *where);
	for (uint32_t y = 0; y < extent_tiles_y(&extent, rig->ground.level); y++)
		for (uint32_t x = 0; x < extent_tiles_x(&extent, rig->ground.level); x++) {
			struct tile tile = {rig->ground.level, x, y};
			enum page_newest place;
			uint32_t slot;
			double low, high;
			bool stored;
			must(page_cache_newest(rig->ground.cache, tile_key(tile), look, &looks, &place, &slot));
			must(store_read_offset_range(resident_ground_reader(rig->ground.ground), tile, &low, &high, &stored));
			where[place] += place != PAGE_NEWEST_STORED || stored;
		}
	assert_int_equal(looks, where[PAGE_NEWEST_QUEUED]);
}

/* Every slot goes to what is not deformed. */
static void evict(struct rig *rig)
{
	const struct tile others[SLOTS] = {{2, 0, 0}, {0, 0, 0}, {0, 1, 0}, {0, 2, 0}, {0, 0, 1}, {0, 0, 2}};
	uint64_t keys[SLOTS];
	uint32_t slots[SLOTS];
	for (int i = 0; i < SLOTS; i++)
		keys[i] = tile_key(others[i]);
	must(page_cache_pin_all(rig->ground.cache, keys, SLOTS, slots));
	for (int i = 0; i < SLOTS; i++)
		page_cache_unpin(rig->ground.cache, keys[i]);
}

/* The surface at every post of the level is what the store says. */
static void check_posts(const char *path, struct newest *newest, int level)
{
	struct store *store;
	struct store_reader *reader;
	int finest = level < 0 ? level : 0;
	int64_t side = extent_posts(extent.width, finest);
	double *values = malloc((size_t)(side * side) * sizeof *values);
	struct resident_point *all = malloc((size_t)(side * side) * sizeof *all);
	struct resident_height *heights = malloc((size_t)(side * side) * sizeof *heights);
	size_t fine = 0;
	must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	must(store_reader_create(store, &reader));
	must(store_read_posts(reader, STORE_SURFACE, finest, (struct post_rect){0, 0, side, side}, values));
	for (int64_t i = 0; i < side * side; i++)
		all[i] = (struct resident_point){(double)(i % side) * extent_spacing(&extent, finest),
						(double)(i / side) * extent_spacing(&extent, finest)};
	must(resident_newest_heights(newest, all, (size_t)(side * side), heights));
	for (int64_t i = 0; i < side * side; i++) {
		if (isnan(values[i]))
			assert_true(isnan(heights[i].bilinear)); /* of a cell with a hole one triangle may be there */
		else if (heights[i].level == finest)
			assert_true(heights[i].height == values[i] && heights[i].bilinear == values[i]);
		else
			assert_true(fabs(heights[i].bilinear - values[i]) <= 0x1p-18); /* between posts of a coarser level */
		fine += heights[i].level == finest;
	}
	assert_true(fine > 0 && (finest == 0 || fine < (size_t)(side * side)));
	free(values);
	free(all);
	free(heights);
	store_reader_destroy(reader);
	store_close(store);
}

static void in_this_home(int level, bool host)
{
	const char *path = support_path("newest.furrow");
	struct rig rig;
	struct newest *alone;
	struct store *store;
	size_t where[3];
	rig_open(&rig, path, &(struct rig_params){.ground = hills_with_a_hole, .level = level, .slots = SLOTS, .commit_age = 0, .host = host});
	choose();
	ask_anew(&rig, &before);
	/* One step's rut, and a tile that was touched and left as it was. */
	roll(&rig, 7);
	uint32_t slot, tiles = extent_tiles_x(&extent, level);
	uint64_t key = tile_key((struct tile){level, tiles - 1, 0});
	must(page_cache_pin(rig.ground.cache, key, &slot));
	rig_touch(&rig, slot);
	page_cache_dirty(rig.ground.cache, key);
	page_cache_unpin(rig.ground.cache, key);
	end_step(&rig);
	places(&rig, where);
	assert_true(where[PAGE_NEWEST_SLOT] >= 2 && where[PAGE_NEWEST_QUEUED] == 0);
	ask(rig.ground.newest, &after);
	size_t changed = 0, levels = 0;
	for (int i = 0; i < POINTS; i++) {
		changed += memcmp(&before.heights[i], &after.heights[i], sizeof before.heights[i]) != 0;
		levels += after.heights[i].level != 0;
	}
	assert_true(changed > 0 && changed < POINTS / 2 && (levels > 0) == (level < 0));
	before = after;
	ask_anew(&rig, &after);
	check_same(&before, &after);
	evict(&rig);
	places(&rig, where);
	assert_true(where[PAGE_NEWEST_SLOT] == 0 && where[PAGE_NEWEST_QUEUED] >= 2);
	ask_anew(&rig, &after);
	check_same(&before, &after);
	must(page_cache_flush(rig.ground.cache, rig.record));
	ask_anew(&rig, &after);
	check_same(&before, &after);
	ask(rig.ground.newest, &after);
	check_same(&before, &after);
	check_posts(path, rig.ground.newest, level);
	must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	must(resident_newest_create(store, NULL, &alone));
	ask(alone, &after);
	check_same(&before, &after);
	check_posts(path, alone, level);
	resident_newest_destroy(alone);
	store_close(store);
	rig_close(&rig);
}

/* Host memory first: without GL the other one skips the test. */
static void wherever_it_is(int level)
{
	in_this_home(level, true);
	in_this_home(level, false);
}

static void at_the_source_s_level(void **state)
{
	wherever_it_is(0);
}

static void below_it(void **state)
{
	wherever_it_is(-1);
}

static void far_below_it(void **state)
{
	wherever_it_is(-2);
}

static void above_it(void **state)
{
	wherever_it_is(1);
}

/* Level rays in a rut of level ground: all they meet is lower than any base. */
static void check_in_rut(struct newest *newest, double x, double y)
{
	for (int i = 0; i < 64; i++) {
		struct resident_ray ray = {{x, y, 99.9}, {cos(i * 0.1), sin(i * 0.1), 0}, INFINITY};
		struct resident_hit hit;
		must(resident_newest_rays(newest, &ray, 1, &hit));
		assert_true(hit.hit && !hit.below && hit.distance < 3);
		/* And from afar under it: into the rut from below. */
		ray.origin[0] += 40 * ray.direction[0];
		ray.origin[1] += 40 * ray.direction[1];
		ray.direction[0] *= -1;
		ray.direction[1] *= -1;
		must(resident_newest_rays(newest, &ray, 1, &hit));
		assert_true(hit.hit && hit.below && hit.distance > 37 && hit.distance < 40);
	}
}

static void check_rut(bool host)
{
	const char *path = support_path("level.furrow");
	struct rig rig;
	struct newest *alone;
	struct store *store;
	const double x = 64 + 50 * sin(0.35), y = 64 + 45 * sin(2.1 * 0.35);
	rig_open(&rig, path, &(struct rig_params){.ground = level_ground, .level = -1, .slots = SLOTS, .commit_age = 0, .host = host});
	roll(&rig, 7);
	end_step(&rig);
	must(resident_newest_create(rig.ground.store, rig.ground.pages, &rig.ground.newest));
	check_in_rut(rig.ground.newest, x, y);
	must(page_cache_flush(rig.ground.cache, rig.record));
	check_in_rut(rig.ground.newest, x, y);
	resident_newest_changed(rig.ground.newest);
	check_in_rut(rig.ground.newest, x, y);
	must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	must(resident_newest_create(store, NULL, &alone));
	check_in_rut(alone, x, y);
	resident_newest_destroy(alone);
	store_close(store);
	rig_close(&rig);
}

static void ruts_are_lower_than_their_base(void **state)
{
	check_rut(true);
	check_rut(false);
}

/* Asked between all steps, with 6 slots, commits on their way, and read-backs that are not over. */
static uint64_t world_all(const char *path, bool asked, bool host)
{
	struct rig rig;
	size_t moved = 0;
	rig_open(&rig, path, &(struct rig_params){.ground = hills_with_a_hole, .level = -1, .slots = SLOTS, .commit_age = 0.002, .host = host});
	choose();
	for (int step = 0; step < 120; step++) {
		roll(&rig, step);
		if (asked && step % 10 == 5) { /* before the step is over, too */
			ask(rig.ground.newest, &after);
			roll(&rig, step + 1);
			ask(rig.ground.newest, &before);
			moved += memcmp(before.heights, after.heights, sizeof after.heights) != 0;
			ask_anew(&rig, &after);
			check_same(&before, &after);
		} else if (step % 10 == 5) {
			roll(&rig, step + 1);
		}
		end_step(&rig);
		if (!asked)
			continue;
		ask(step % 20 == 0 ? (ask_anew(&rig, &before), rig.ground.newest) : rig.ground.newest, &after);
		if (step % 20 == 0)
			check_same(&before, &after);
		if (step % 8 == 7) {
			before = after;
			evict(&rig);
			ask_anew(&rig, &after);
			check_same(&before, &after);
		}
	}
	must(page_cache_flush(rig.ground.cache, rig.record));
	assert_true(!asked || moved > 5);
	if (asked)
		check_posts(path, rig.ground.newest, -1);
	rig_close(&rig);
	support_verify(path);
	return support_hash(path);
}

static void asking_changes_nothing(void **state)
{
	for (int host = 1; host >= 0; host--) {
		uint64_t asked = world_all(support_path("asked.furrow"), true, host == 1);
		assert_true(asked == world_all(support_path("left.furrow"), false, host == 1));
	}
}

/* The same as by the store's own sampling, which is between four posts. */
static void points_are_as_the_store_samples(void **state)
{
	const char *path = support_path("asked.furrow");
	struct store *store;
	struct store_reader *reader;
	struct newest *newest;
	size_t with = 0;
	must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	must(store_reader_create(store, &reader));
	must(resident_newest_create(store, NULL, &newest));
	choose();
	ask(newest, &before);
	for (int i = 0; i < POINTS; i++) {
		struct store_sample sample;
		must(store_sample(reader, points[i].x, points[i].y, &sample));
		assert_int_equal(sample.outside, before.heights[i].outside);
		assert_int_equal(sample.nodata, isnan(before.heights[i].bilinear));
		if (sample.nodata)
			continue;
		/* The store keeps the source's heights; these are on the lattice, and there finer posts are rounded. */
		assert_true(fabs(sample.height - before.heights[i].bilinear) <= 0x1p-17);
		with += sample.offset != 0;
	}
	assert_true(with > 0);
	resident_newest_destroy(newest);
	store_reader_destroy(reader);
	store_close(store);
}

/* Every allocation fails in turn: told, and what is asked again is answered. */
static void without_memory(void **state)
{
	struct store *store;
	bool whole = false;
	must(store_open(support_path("asked.furrow"), &(struct store_options){.mode = STORE_READ}, &store));
	for (uint64_t nth = 1; !whole; nth++) {
		struct newest *newest = NULL;
		mem_fail_nth(nth, 0);
		enum status status = resident_newest_create(store, NULL, &newest);
		if (status == STATUS_OK)
			status = resident_newest_heights(newest, points, POINTS, after.heights);
		if (status == STATUS_OK)
			status = resident_newest_rays(newest, rays, RAYS, after.hits);
		mem_fail_nth(0, 0);
		whole = status == STATUS_OK;
		assert_true(whole || status == STATUS_FAILED);
		if (newest != NULL) {
			ask(newest, &after);
			check_same(&before, &after);
		}
		resident_newest_destroy(newest);
		assert_true(nth < 1000);
	}
	store_close(store);
}

/* What a drive has of its start stays; what the store has since is found once the ranges were forgotten. */
static void ranges_of_offsets_stay_until_they_are_forgotten(void **state)
{
	struct rig rig;
	rig_open(&rig, support_path("ranges.furrow"), &(struct rig_params){.ground = level_ground, .slots = SLOTS});
	struct ground *ground = rig.ground.ground;
	const struct tile top = {extent_coarsest(&extent), 0, 0};
	struct resident_ground_figures first, last;
	double low, high, lowest, highest;
	bool found;
	must(resident_ground_offset_range(ground, top, &low, &high, &found));
	assert_true(!found && low == 0 && high == 0);
	resident_ground_figures(ground, &first);
	roll(&rig, 7);
	end_step(&rig);
	must(page_cache_flush(rig.ground.cache, rig.record));
	must(store_read_offset_range(resident_ground_reader(ground), top, &lowest, &highest, &found));
	assert_true(found && lowest < -0.3);
	must(resident_ground_offset_range(ground, top, &low, &high, &found));
	assert_true(!found && low == 0 && high == 0);
	resident_ground_figures(ground, &last);
	assert_true(last.range_waits == first.range_waits && last.offset_ranges == first.offset_ranges);
	resident_ground_forget_offsets(ground);
	must(resident_ground_offset_range(ground, top, &low, &high, &found));
	assert_true(found && low == lowest && high == fmax(highest, 0));
	resident_ground_figures(ground, &last);
	assert_int_equal(last.range_waits, first.range_waits + 1);
	rig_close(&rig);
}

static void bounds_hold_what_was_added_in_a_tile_and_above(void **state)
{
	struct offset_bounds bounds = {.extent = &extent};
	const struct tile tile = {0, 3, 2}, beside = {0, 2, 2};
	const int coarsest = extent_coarsest(&extent);
	double low = 0, high = 0;
	assert_false(resident_bounds_widen(&bounds, tile, &low, &high));
	must(resident_bounds_add(&bounds, tile, -2, 1));
	must(resident_bounds_add(&bounds, beside, -1, 3));
	must(resident_bounds_add(&bounds, tile, -0.5, 0.5)); /* narrows nothing */
	for (int level = 0; level <= coarsest; level++) {
		low = high = 0;
		assert_true(resident_bounds_widen(&bounds, tile_ancestor(tile, level), &low, &high));
		assert_true(low == -2 && high == (level > 0 ? 3 : 1));
	}
	low = -5, high = 0;
	assert_true(resident_bounds_widen(&bounds, beside, &low, &high));
	assert_true(low == -5 && high == 3);
	assert_false(resident_bounds_widen(&bounds, (struct tile){0, 0, 0}, &low, &high));
	resident_bounds_clear(&bounds);
	assert_false(resident_bounds_widen(&bounds, (struct tile){coarsest, 0, 0}, &low, &high));
	must(resident_bounds_add(&bounds, beside, -1, 0));
	low = high = 0;
	assert_true(resident_bounds_widen(&bounds, (struct tile){coarsest, 0, 0}, &low, &high) && low == -1 && high == 0);
	resident_bounds_finish(&bounds);
}

TEST_PROGRAM(newest)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(at_the_source_s_level), cmocka_unit_test(below_it),
		cmocka_unit_test(far_below_it),          cmocka_unit_test(above_it),
		cmocka_unit_test(ruts_are_lower_than_their_base),
		cmocka_unit_test(asking_changes_nothing), cmocka_unit_test(points_are_as_the_store_samples),
		cmocka_unit_test(without_memory),
		cmocka_unit_test(ranges_of_offsets_stay_until_they_are_forgotten),
		cmocka_unit_test(bounds_hold_what_was_added_in_a_tile_and_above),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
