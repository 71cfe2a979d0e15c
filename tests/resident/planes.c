/*
 * The soil's state through slots, pages and store: the same bits whether a page stayed in its slot, left it and
 * came back from the queue, or was read from the store by another process; coarser levels carry none of it. Posts are read
 * the same wherever they are.
 * With it goes what was compacted, read from a buffer on the GPU, and classes of soil beside the base. All of this with pages in slots of the
 * GPU, and in host memory.
 */
#include "../gpu/staged.h"
#include "../support.h"
#include "../support/program.h"
#include "../support/skip.h"

#include "resident/resident.h"
#include "world/record.h"

enum { CELLS = 32, LEVEL = -1, SIDE = 8, POSTS = (CELLS + 1) * (CELLS + 1), SLOTS = 12 };
#define ALL ((1u << PLANES) - 1)
static const struct extent extent = {129, 129, 1, CELLS};
static const struct scene scene = {.slots = SLOTS, .hash = "0"};

struct rig {
	struct store *store;
	struct gpu *gpu;
	struct gpu_slots *slots;
	struct gpu_buffer *tally; /* NULL: none */
	struct host_slots *host;  /* NULL: the home is the GPU */
	int64_t tallies[3];       /* with a home in host memory */
	struct pages *pages;
	struct resident_pages_budget most;
	struct page_cache *cache;
	struct record *record;
	FILE *commit_log;
	int64_t tallied;
};

static int32_t truth[SIDE][SIDE][PLANES][POSTS]; /* texels of any size */

static enum status before_read_back(void *user, struct tile tile, uint32_t slot)
{
	return STATUS_OK;
}

static enum status snapshot(void *user, struct gpu_staging *staging)
{
	const struct rig *rig = user;
	gpu_buffer_read_into(rig->tally, 0, PAGES_TALLY_BYTES, staging, 0);
	return gpu_check(rig->gpu, "the tally");
}

static enum status tally(void *user, uint8_t *bytes)
{
	const struct rig *rig = user;
	memset(bytes, 0, PAGES_TALLY_BYTES);
	memcpy(bytes, rig->tallies, sizeof rig->tallies);
	return STATUS_OK;
}

static uint8_t class_of(struct tile tile, int post)
{
	return (uint8_t)((tile.x * 5 + tile.y * 3 + (unsigned)post) & 15);
}

static enum status classes_of(void *user, unsigned loader, struct tile tile, uint8_t *classes)
{
	assert_int_equal(tile.level, LEVEL);
	for (int i = 0; i < POSTS; i++)
		classes[i] = class_of(tile, i);
	return STATUS_OK;
}

static uint8_t number_of(struct tile tile, int byte)
{
	return (uint8_t)(tile.x * 11 + tile.y * 13 + (unsigned)byte * 7);
}

static enum status numbers_of(void *user, unsigned loader, struct tile tile, uint8_t *numbers)
{
	assert_int_equal(tile.level, LEVEL);
	for (int i = 0; i < PAGES_NUMBER_BYTES * POSTS; i++)
		numbers[i] = number_of(tile, i);
	return STATUS_OK;
}

static void open_gpu(struct rig *rig, unsigned planes, bool soil)
{
	enum status status = gpu_create(&(struct gpu_params){.draws = false}, &rig->gpu);
	if (status == STATUS_NO_GL) {
		store_close(rig->store);
		skip_since("no GL");
	}
	must(status);
	must(gpu_slots_create(rig->gpu, CELLS, SLOTS, planes, &rig->slots));
	if (soil)
		must(gpu_buffer_create(rig->gpu, GPU_STORAGE, PAGES_TALLY_BYTES, NULL, &rig->tally));
}

static void rig_open(struct rig *rig, const char *path, unsigned planes, bool soil, bool host)
{
	*rig = (struct rig){.commit_log = tmpfile(), .record = calloc(1, world_record_bytes(0))};
	assert_true(rig->commit_log != NULL && rig->record != NULL);
	must(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &rig->store));
	must(store_set_working_level(rig->store, LEVEL));
	if (host)
		must(resident_host_create(CELLS, SLOTS, planes, &rig->host));
	else
		open_gpu(rig, planes, soil);
	const struct pages_params params = {
		.store = rig->store,
		.gpu = rig->gpu,
		.slots = rig->slots,
		.host = rig->host,
		.planes = planes | PLANE_BIT(PLANE_OFFSET),
		.level = LEVEL,
		.count = SLOTS,
		.loaders = 2,
		.step_pages = 16,
		.record = world_record_pages(&scene),
		.commit_log = rig->commit_log,
		.commit_age = 0.01,
		.before_read_back = before_read_back,
		.snapshot = soil ? snapshot : NULL,
		.tally = soil ? tally : NULL,
		.classes = soil ? classes_of : NULL,
		.numbers = soil ? numbers_of : NULL,
		.user = rig,
	};
	must(resident_pages_create(&params, &rig->pages));
	resident_pages_budget(&params, CELLS, &rig->most);
	rig->cache = resident_pages_cache(rig->pages);
}

static void rig_close(struct rig *rig)
{
	resident_pages_destroy(rig->pages);
	resident_host_destroy(rig->host);
	gpu_buffer_destroy(rig->tally);
	gpu_slots_destroy(rig->slots);
	gpu_destroy(rig->gpu);
	store_close(rig->store);
	fclose(rig->commit_log);
	free(rig->record);
}

/* Reads what the slot has. A plane that it lacks is zeros. *soil: it has classes and numbers. */
static void read_slot(struct rig *rig, uint32_t slot, int32_t texels[PLANES][POSTS], uint8_t *classes, uint8_t *numbers, bool *soil)
{
	const struct gpu_rect whole = {0, 0, CELLS + 1, CELLS + 1};
	void *into[PLANES];
	if (rig->host != NULL) {
		struct host_slot held;
		resident_host_get(rig->host, slot, &held);
		for (int plane = 0; plane < PLANES; plane++) {
			const size_t bytes = POSTS * plane_bytes((enum plane)plane);
			if (held.planes[plane] != NULL)
				memcpy(texels[plane], held.planes[plane], bytes);
			else
				memset(texels[plane], 0, bytes);
		}
		*soil = held.classes != NULL;
		assert_true(*soil == (held.levels != NULL));
		if (*soil) {
			memcpy(classes, held.classes, POSTS);
			memcpy(numbers, held.levels, PAGES_NUMBER_BYTES * POSTS);
		}
		return;
	}
	const struct gpu_slot *held = gpu_slots_get(rig->slots, slot);
	for (int plane = 0; plane < PLANES; plane++)
		into[plane] = texels[plane];
	must(staged_read_planes(rig->gpu, rig->slots, CELLS, slot, into));
	*soil = held->classes != NULL;
	assert_true(*soil == (held->numbers != NULL));
	if (*soil) {
		gpu_texture_read(held->numbers, 0, whole, numbers);
		gpu_texture_read(held->classes, 0, whole, classes);
	}
}

/* The page as it is now is what `truth` says, of these planes. */
static void check_page(struct rig *rig, uint32_t slot, uint32_t x, uint32_t y, unsigned planes, bool soil)
{
	static int32_t texels[PLANES][POSTS];
	static uint8_t classes[POSTS], numbers[PAGES_NUMBER_BYTES * POSTS];
	bool has_soil;
	read_slot(rig, slot, texels, classes, numbers, &has_soil);
	for (int plane = 0; plane < PLANES; plane++)
		if (planes & PLANE_BIT(plane))
			assert_memory_equal(texels[plane], truth[y][x][plane], POSTS * plane_bytes((enum plane)plane));
	assert_true(has_soil == soil);
	if (!soil)
		return;
	for (int i = 0; i < PAGES_NUMBER_BYTES * POSTS; i++)
		assert_int_equal(numbers[i], number_of((struct tile){LEVEL, x, y}, i));
	for (int i = 0; i < POSTS; i++)
		assert_int_equal(classes[i], class_of((struct tile){LEVEL, x, y}, i));
}

static uint32_t random_word(void)
{
	static uint64_t luck = 88172645463325252;
	luck = luck * 6364136223846793005 + 1442695040888963407;
	return (uint32_t)(luck >> 33);
}

/* New bits inside the tile: its edges stay zero, as its neighbours have them. */
static void change_page(struct rig *rig, uint32_t slot, uint32_t x, uint32_t y)
{
	struct gpu_rect all = {0, 0, CELLS + 1, CELLS + 1};
	must(rig->host != NULL ? resident_host_write(rig->host, slot, ALL) : gpu_slots_deform(rig->slots, slot));
	for (int plane = 0; plane < PLANES; plane++)
		for (int i = 0; i < POSTS; i++) {
			int px = i % (CELLS + 1), py = i / (CELLS + 1);
			bool inside = px > 0 && py > 0 && px < CELLS && py < CELLS;
			uint32_t value = inside ? random_word() & (plane == PLANE_SHEAR ? 0x7fff7fff : 0x7fffffff) : 0;
			if (plane_bytes((enum plane)plane) == 1)
				((uint8_t *)truth[y][x][plane])[i] = (uint8_t)value;
			else
				truth[y][x][plane][i] = (int32_t)value;
		}
	for (int plane = 0; plane < PLANES; plane++)
		if (rig->host != NULL)
			memcpy(resident_host_plane(rig->host, slot, (enum plane)plane), truth[y][x][plane], POSTS * plane_bytes((enum plane)plane));
		else
			gpu_texture_upload(gpu_slots_get(rig->slots, slot)->planes[plane], 0, all, truth[y][x][plane]);
	page_cache_dirty(rig->cache, tile_key((struct tile){LEVEL, x, y}));
}

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
			assert_true(there == (plane == PLANE_DISTURBANCE));
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
	uint64_t taken = bytes.base + bytes.classes + bytes.numbers;
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
	/* In host memory images and slots share their planes. */
	assert_true(bytes_of_slots(&rig) <= most.slots + (host ? most.loads + most.queue : 0) && most.slots <= (uint64_t)SLOTS * (POSTS * 32));
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
