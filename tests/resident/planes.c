/*
 * The soil's state through slots, pages and store: the same bits whether a page stayed in its slot, left it and
 * came back from the queue, or was read from the store by another process; coarser levels carry none of it. Posts are read
 * the same wherever they are.
 * With it goes what was compacted, read from a buffer on the GPU, and classes of soil beside the base. All of this with pages in slots of the
 * GPU, and in host memory.
 */
#include "../support/program.h"
#include "planes_rig.h"

static int32_t truth_at(enum plane plane, int64_t x, int64_t y)
{
	const uint32_t tx = (uint32_t)(x / CELLS < SIDE ? x / CELLS : SIDE - 1), ty = (uint32_t)(y / CELLS < SIDE ? y / CELLS : SIDE - 1);
	const int64_t i = (y - ty * CELLS) * (CELLS + 1) + x - tx * CELLS;
	const int32_t *posts = truth[ty][tx][plane];
	return plane_bytes(plane) == 1 ? ((const uint8_t *)posts)[i] : posts[i];
}

static double posts[257 * 257], base[257 * 257];

/* What is read of a layer is what `truth` says, `finer` levels below it, wherever the newest posts are. */
static void check_posts(struct newest *newest, struct post_rect rect, enum store_layer layer, enum plane plane, int finer)
{
	const int64_t width = rect.x1 - rect.x0;
	const bool surface = layer == STORE_SURFACE;
	must(resident_read_posts(newest, layer, LEVEL - finer, rect, posts));
	must(resident_read_posts(newest, STORE_BASE, LEVEL - finer, rect, base));
	for (int64_t i = 0; i < width * (rect.y1 - rect.y0); i++) {
		int64_t x = rect.x0 + i % width, y = rect.y0 + i / width;
		if (finer > 0 && (x % 2 != 0 || y % 2 != 0))
			continue;
		int32_t post = finer > 0 ? truth_at(plane, x / 2, y / 2) : truth_at(plane, x << -finer, y << -finer);
		double value = layer == STORE_UNITS    ? post
			       : plane == PLANE_SHEAR ? ldexp(plane_shear(post, store_shear_part(layer)), -PLANE_SHEAR_BITS)
						      : plane_value(plane, post);
		assert_true(posts[i] == (surface ? base[i] + value : value));
	}
}

static void check_newest(struct newest *newest)
{
	const struct post_rect all = {0, 0, 257, 257}, half = {0, 0, 129, 129}, some = {61, 30, 100, 131};
	resident_newest_changed(newest);
	check_posts(newest, all, STORE_SURFACE, PLANE_OFFSET, 0);
	check_posts(newest, all, STORE_OFFSET, PLANE_OFFSET, 0);
	check_posts(newest, some, STORE_UNITS, PLANE_OFFSET, 0);
	check_posts(newest, some, STORE_SOIL, PLANE_DISTURBANCE, 0);
	check_posts(newest, all, STORE_DEPOSITED, PLANE_DEPOSITED, 0);
	check_posts(newest, some, STORE_PLASTIC_SINKAGE, PLANE_PLASTIC_SINKAGE, 0);
	check_posts(newest, all, STORE_SHEAR, PLANE_SHEAR, 0);
	check_posts(newest, some, STORE_SHEAR_EAST, PLANE_SHEAR, 0);
	check_posts(newest, all, STORE_SHEAR_NORTH, PLANE_SHEAR, 0);
	check_posts(newest, half, STORE_SURFACE, PLANE_OFFSET, -1);
	check_posts(newest, half, STORE_SOIL, PLANE_DISTURBANCE, -1);
	check_posts(newest, some, STORE_SURFACE, PLANE_OFFSET, 1);
	check_posts(newest, some, STORE_SHEAR_NORTH, PLANE_SHEAR, 1);
	assert_int_equal(resident_read_posts(newest, STORE_SHEAR, LEVEL + 1, half, posts), STATUS_INPUT);
	/* Outside there is nothing. */
	must(resident_read_posts(newest, STORE_OFFSET, LEVEL, (struct post_rect){-3, 255, 0, 259}, posts));
	for (int i = 0; i < 3 * 4; i++)
		assert_true(isnan(posts[i]));
}

static void one_step(struct rig *rig, int64_t step)
{
	for (int i = 0; i < 5; i++) {
		uint32_t x = random_word() % SIDE, y = random_word() % SIDE, slot;
		uint64_t key = tile_key((struct tile){LEVEL, x, y});
		must(page_cache_pin(rig->cache, key, &slot));
		check_page(rig, slot, x, y, ALL, true);
		if (i % 2 == 0)
			change_page(rig, slot, x, y);
		page_cache_unpin(rig->cache, key);
	}
	const int64_t tallies[3] = {rig->tallied += (int64_t)random_word() - (1 << 29), 7, 9};
	memcpy(rig->tallies, tallies, sizeof tallies);
	if (rig->host == NULL)
		gpu_buffer_write(rig->tally, 0, sizeof tallies, tallies);
	rig->record->step = step;
	must(page_cache_end_step(rig->cache, rig->record));
}

static void assert_no_coarser_state(struct rig *rig)
{
	for (int level = LEVEL + 1; level <= extent_coarsest(&extent); level++) {
		uint32_t slot;
		struct tile tile = {level, 0, 0};
		must(page_cache_pin(rig->cache, tile_key(tile), &slot));
		struct host_slot held;
		if (rig->host != NULL)
			resident_host_get(rig->host, slot, &held);
		for (int plane = PLANE_DISTURBANCE; plane < PLANES; plane++) {
			const bool there = rig->host != NULL ? held.planes[plane] != NULL : gpu_slots_get(rig->slots, slot)->planes[plane] != NULL;
			assert_true(there == ((GPU_DRAWN_PLANES & PLANE_BIT(plane)) != 0));
		}
		page_cache_unpin(rig->cache, tile_key(tile));
	}
}

/* Of these planes, as a process finds them that opens it; `soil`: with classes. */
static void check_store(const char *path, unsigned planes, unsigned stored, bool soil, bool host)
{
	struct rig rig;
	rig_open(&rig, path, planes, soil, host);
	for (uint32_t y = 0; y < SIDE; y++)
		for (uint32_t x = 0; x < SIDE; x++) {
			uint32_t slot;
			must(page_cache_pin(rig.cache, tile_key((struct tile){LEVEL, x, y}), &slot));
			check_page(&rig, slot, x, y, stored, soil);
			page_cache_unpin(rig.cache, tile_key((struct tile){LEVEL, x, y}));
		}
	rig_close(&rig);
}

static uint64_t bytes_of_slots(struct rig *rig)
{
	struct gpu_slots_bytes bytes;
	struct resident_host_figures figures;
	if (rig->host != NULL) {
		resident_host_figures(rig->host, &figures);
		return figures.bytes;
	}
	gpu_slots_bytes(rig->slots, &bytes);
	uint64_t taken = bytes.base + bytes.classes;
	for (int plane = 0; plane < PLANES; plane++)
		taken += bytes.planes[plane];
	return taken;
}

static void comes_back(bool host)
{
	const char *path = support_path("planes.furrow");
	struct rig rig;
	struct resident_pages_io io;
	support_store(path, extent, support_hills);
	memset(truth, 0, sizeof truth);
	rig_open(&rig, path, ALL, true, host);
	struct newest *newest;
	must(resident_newest_create(rig.store, rig.pages, &newest));
	for (int64_t step = 1; step <= 60; step++) {
		one_step(&rig, step);
		if (step % 6 == 1)
			check_newest(newest);
	}
	assert_no_coarser_state(&rig);
	must(page_cache_flush(rig.cache, rig.record));
	check_newest(newest);
	resident_newest_destroy(newest);
	resident_pages_io(rig.pages, &io);
	assert_true(io.commits > 3);
	assert_int_equal(io.sums.compacted, rig.tallied);
	struct store_numbers numbers;
	must(store_count(rig.store, &numbers));
	assert_int_equal(numbers.compacted, rig.tallied);
	const struct resident_pages_budget most = rig.most;
	uint64_t post = sizeof(int32_t) + 7; /* the base, and what else a slot has */
	for (int plane = 0; plane < PLANES; plane++)
		post += plane_bytes((enum plane)plane);
	/* In host memory images and slots share their planes. */
	assert_true(bytes_of_slots(&rig) <= most.slots + (host ? most.loads + most.queue : 0) && most.slots <= (uint64_t)SLOTS * (POSTS * post));
	rig_close(&rig);
	check_store(path, ALL, ALL, true, host);
	check_store(path, ALL, ALL, true, true);
	/* Who needs no state reads none and makes no room for it. */
	check_store(path, PLANE_BIT(PLANE_DISTURBANCE), PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DISTURBANCE), false, host);
	check_store(path, 0, PLANE_BIT(PLANE_OFFSET), false, host);
}

/* Host memory first: without GL the other one skips the test. */
static void state_comes_back_the_same_bits(void **state)
{
	comes_back(true);
	comes_back(false);
}

TEST_PROGRAM(planes)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(state_comes_back_the_same_bits),
	};
	return cmocka_run_group_tests_name("planes", tests, support_enter, support_leave);
}
