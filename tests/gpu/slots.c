/* Planes in slots: they are allocated when first needed and reused, and return the bits that were loaded. */
#include "slots.h"
#include "../support/program.h"

#define ALL ((1u << PLANES) - 1)

static uint32_t textures_alive(void)
{
	struct gpu_stats stats;
	gpu_stats(test_gpu, &stats);
	return stats.textures;
}

static void planes_are_allocated_when_first_needed_and_reused(void **state)
{
	enum { N = 16, POSTS = (N + 1) * (N + 1) };
	int32_t *posts, offset[POSTS], zeros[POSTS] = {0};
	uint8_t dirt[POSTS];
	struct gpu_slots *slots;
	(void)state;
	need_gpu();
	posts = random_ints(POSTS);
	assert_ok(gpu_slots_create(test_gpu, N, 100, PLANE_BIT(PLANE_DISTURBANCE), &slots));
	assert_int_equal(textures_alive(), 0);
	assert_null(gpu_slots_get(slots, 7)->base);
	assert_ok(staged_upload_base(test_gpu, slots, N, 7, posts));
	assert_ok(staged_upload_base(test_gpu, slots, N, 7, posts));
	assert_int_equal(textures_alive(), 1);
	gpu_texture_read(gpu_slots_get(slots, 7)->base, 0, rect_of(0, 0, N + 1, N + 1), offset);
	assert_memory_equal(offset, posts, sizeof offset);
	assert_null(gpu_slots_get(slots, 7)->target);

	memset(dirt, 9, sizeof dirt);
	assert_ok(staged_upload_deform(test_gpu, slots, N, 7, posts, dirt));
	assert_int_equal(textures_alive(), 3);
	assert_ok(gpu_slots_deform(slots, 7)); /* has one: keeps what is in it */
	assert_ok(staged_read_deform(test_gpu, slots, N, 7, offset, dirt));
	assert_memory_equal(offset, posts, sizeof offset);
	assert_int_equal(dirt[POSTS - 1], 9);
	struct gpu_texture *home = gpu_slots_get(slots, 7)->planes[PLANE_OFFSET];

	gpu_slots_undeform(slots, 7);
	gpu_slots_undeform(slots, 7);
	assert_null(gpu_slots_get(slots, 7)->planes[PLANE_OFFSET]);
	assert_null(gpu_slots_get(slots, 7)->planes[PLANE_DISTURBANCE]);
	assert_null(gpu_slots_get(slots, 7)->target);
	assert_ok(staged_read_deform(test_gpu, slots, N, 7, offset, dirt));
	assert_memory_equal(offset, zeros, sizeof offset);

	assert_ok(gpu_slots_deform(slots, 50)); /* another slot takes it over, zeroed */
	assert_ptr_equal(gpu_slots_get(slots, 50)->planes[PLANE_OFFSET], home);
	assert_int_equal(textures_alive(), 3);
	assert_ok(staged_read_deform(test_gpu, slots, N, 50, offset, dirt));
	assert_memory_equal(offset, zeros, sizeof offset);
	assert_memory_equal(dirt, zeros, sizeof dirt);

	memset(dirt, 9, sizeof dirt);
	assert_ok(staged_upload_deform(test_gpu, slots, N, 50, posts, dirt));
	assert_ok(staged_upload_deform(test_gpu, slots, N, 50, posts, NULL)); /* no dirt given: clean */
	assert_ok(staged_read_deform(test_gpu, slots, N, 50, offset, dirt));
	assert_memory_equal(dirt, zeros, sizeof dirt);
	struct gpu_slots_bytes bytes;
	gpu_slots_bytes(slots, &bytes);
	assert_int_equal(bytes.base, POSTS * 4);
	assert_int_equal(bytes.planes[PLANE_OFFSET], POSTS * 4);
	assert_int_equal(bytes.planes[PLANE_DISTURBANCE], POSTS);
	gpu_slots_destroy(slots);
	assert_int_equal(textures_alive(), 0);
	mem_free(posts);
}

static void without_dirt_there_is_no_dirt_plane(void **state)
{
	enum { N = 8, POSTS = (N + 1) * (N + 1) };
	int32_t offset[POSTS];
	uint8_t dirt[POSTS], zeros[POSTS] = {0};
	struct gpu_slots *slots;
	(void)state;
	need_gpu();
	assert_ok(gpu_slots_create(test_gpu, N, 2, 0, &slots));
	assert_ok(gpu_slots_deform(slots, 0));
	assert_null(gpu_slots_get(slots, 0)->planes[PLANE_DISTURBANCE]);
	assert_int_equal(textures_alive(), 1);
	memset(dirt, 1, sizeof dirt);
	assert_ok(staged_read_deform(test_gpu, slots, N, 0, offset, dirt));
	assert_memory_equal(dirt, zeros, sizeof dirt);
	gpu_slots_destroy(slots);
}

/* All of one tile's planes, each with bits of its own. */
struct tile_planes {
	void *planes[PLANES];
};

static struct tile_planes random_planes(uint32_t cells)
{
	struct tile_planes tile;
	for (int plane = 0; plane < PLANES; plane++)
		tile.planes[plane] = random_bytes(staged_posts(cells) * plane_bytes(plane));
	return tile;
}

static void free_planes(struct tile_planes tile)
{
	for (int plane = 0; plane < PLANES; plane++)
		mem_free(tile.planes[plane]);
}

/* That the slot has the given planes of `tile`, and zeros for the others. */
static void assert_planes(struct gpu_slots *slots, uint32_t cells, uint32_t slot, struct tile_planes tile, unsigned given)
{
	struct tile_planes read = random_planes(cells);
	assert_ok(staged_read_planes(test_gpu, slots, cells, slot, read.planes));
	for (int plane = 0; plane < PLANES; plane++) {
		size_t bytes = staged_posts(cells) * plane_bytes(plane);
		if (!(given & PLANE_BIT(plane)))
			memset(tile.planes[plane], 0, bytes);
		assert_memory_equal(read.planes[plane], tile.planes[plane], bytes);
	}
	free_planes(read);
}

static void every_plane_comes_back_the_same_bits(void **state)
{
	enum { CELLS = 16 };
	(void)state;
	need_gpu();
	for (unsigned planes = 0; planes <= ALL; planes += 7) {
		struct gpu_slots *slots;
		struct tile_planes tile = random_planes(CELLS);
		const void *given[PLANES];
		assert_ok(gpu_slots_create(test_gpu, CELLS, 2, planes, &slots));
		assert_int_equal(gpu_slots_planes(slots), planes | PLANE_BIT(PLANE_OFFSET));
		assert_ok(staged_upload_planes(test_gpu, slots, CELLS, 0, (const void *const *)tile.planes));
		assert_int_equal(textures_alive(), __builtin_popcount(planes | PLANE_BIT(PLANE_OFFSET)));
		assert_planes(slots, CELLS, 0, tile, planes | PLANE_BIT(PLANE_OFFSET));

			/* Over it another of which not all are given: the others are zeros. */
		struct tile_planes next = random_planes(CELLS);
		unsigned some = PLANE_BIT(PLANE_OFFSET) | (any_word() & ALL);
		for (int plane = 0; plane < PLANES; plane++)
			given[plane] = some & PLANE_BIT(plane) ? next.planes[plane] : NULL;
		assert_ok(staged_upload_planes(test_gpu, slots, CELLS, 0, given));
		for (int plane = PLANE_DEPOSITED; plane < PLANES; plane++)
			assert_int_equal(gpu_slots_get(slots, 0)->planes[plane] != NULL, /* all, or none but the drawn ones */
					 ((some & planes & ~GPU_DRAWN_PLANES) != 0 || (GPU_DRAWN_PLANES & PLANE_BIT(plane)) != 0) && (planes >> plane & 1) != 0);
		assert_planes(slots, CELLS, 0, next, some & gpu_slots_planes(slots));
		gpu_slots_destroy(slots);
		free_planes(tile);
		free_planes(next);
	}
}

static void state_planes_are_those_of_the_working_level(void **state)
{
	enum { CELLS = 16, COUNT = 3, TILE = (CELLS + 1) * (CELLS + 1) };
	struct gpu_slots *slots;
	struct gpu_slots_bytes bytes;
	(void)state;
	need_gpu();
	struct tile_planes tile = random_planes(CELLS);
	assert_ok(gpu_slots_create(test_gpu, CELLS, COUNT, ALL, &slots));
	assert_ok(staged_upload_deform(test_gpu, slots, CELLS, 0, tile.planes[PLANE_OFFSET], tile.planes[PLANE_DISTURBANCE]));
	assert_null(gpu_slots_get(slots, 0)->planes[PLANE_PLASTIC_SINKAGE]); /* it had none in the store */
	assert_ok(gpu_slots_decimate(slots, 0, rect_of(0, 0, CELLS + 1, CELLS + 1), 1, 1, 0, 0));
	gpu_slots_bytes(slots, &bytes);
	assert_int_equal(bytes.planes[PLANE_OFFSET], 2 * TILE * 4);
	assert_int_equal(bytes.planes[PLANE_DEPOSITED] + bytes.planes[PLANE_PLASTIC_SINKAGE] + bytes.planes[PLANE_SHEAR], 0);

	assert_ok(gpu_slots_deform(slots, 0)); /* about to be written: all, and those it had as they were */
	assert_non_null(gpu_slots_get(slots, 0)->planes[PLANE_SHEAR]);
	assert_planes(slots, CELLS, 0, tile, PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DISTURBANCE));
	free_planes(tile);
	tile = random_planes(CELLS);
	assert_ok(staged_upload_planes(test_gpu, slots, CELLS, 0, (const void *const *)tile.planes));
	gpu_slots_bytes(slots, &bytes);
	assert_int_equal(bytes.planes[PLANE_PLASTIC_SINKAGE], TILE * 4);
	assert_int_equal(bytes.planes[PLANE_SHEAR], TILE * 4);

	/* A coarser tile that takes over such a deform slot shows nothing of it. */
	gpu_slots_undeform(slots, 0);
	gpu_slots_undeform(slots, 1);
	assert_ok(gpu_slots_deform(slots, 2)); /* the one with state planes */
	assert_planes(slots, CELLS, 2, tile, 0);
	gpu_slots_undeform(slots, 2);
	for (uint32_t i = 0; i < 2; i++)
		assert_ok(staged_upload_deform(test_gpu, slots, CELLS, i, tile.planes[PLANE_OFFSET], NULL));
	assert_null(gpu_slots_get(slots, 0)->planes[PLANE_DEPOSITED]);
	assert_null(gpu_slots_get(slots, 1)->planes[PLANE_DEPOSITED]);
	gpu_slots_bytes(slots, &bytes);
	assert_int_equal(bytes.planes[PLANE_OFFSET], 2 * TILE * 4);
	assert_int_equal(bytes.planes[PLANE_PLASTIC_SINKAGE], TILE * 4);

	/* However they change hands: never more of a plane than there are slots. */
	for (int i = 0; i < 100; i++) {
		uint32_t slot = any_word() % COUNT;
		gpu_slots_undeform(slots, slot);
		if (i % 3 == 0)
			assert_ok(gpu_slots_deform(slots, slot));
		else
			assert_ok(staged_upload_deform(test_gpu, slots, CELLS, slot, tile.planes[PLANE_OFFSET], NULL));
	}
	gpu_slots_bytes(slots, &bytes);
	for (int plane = 0; plane < PLANES; plane++)
		assert_in_range(bytes.planes[plane], 0, COUNT * TILE * plane_bytes((enum plane)plane));
	gpu_slots_destroy(slots);
	free_planes(tile);
}

static void classes_are_there_once_they_are_loaded(void **state)
{
	enum { CELLS = 16, TILE = (CELLS + 1) * (CELLS + 1) };
	uint8_t read[TILE];
	struct gpu_slots *slots;
	struct gpu_slots_bytes bytes;
	struct gpu_staging *staging;
	(void)state;
	need_gpu();
	uint8_t *classes = random_bytes(TILE);
	assert_ok(gpu_slots_create(test_gpu, CELLS, 2, 0, &slots));
	assert_null(gpu_slots_get(slots, 1)->classes);
	assert_ok(staged_from(test_gpu, classes, TILE, &staging));
	assert_ok(gpu_slots_upload_classes(slots, 1, staging, STAGED_AT));
	gpu_texture_read(gpu_slots_get(slots, 1)->classes, 0, rect_of(0, 0, CELLS + 1, CELLS + 1), read);
	assert_memory_equal(read, classes, sizeof read);
	assert_null(gpu_slots_get(slots, 0)->classes);
	gpu_slots_bytes(slots, &bytes);
	assert_int_equal(bytes.classes, TILE);
	gpu_staging_destroy(staging);
	gpu_slots_destroy(slots);
	mem_free(classes);
}

/* The first arrays have 8 layers, then 8 more. There are no more layers than slots. */
static void slots_in_arrays_hold_their_own_tiles(void **state)
{
	enum { CELLS = 512, COUNT = 20, SIDE = CELLS + 1 };
	int32_t *posts = random_ints((size_t)SIDE * SIDE), at;
	struct gpu_slots *slots;
	struct gpu_slots_bytes bytes;
	struct gpu_slots_figures figures;
	(void)state;
	need_gpu();
	assert_ok(gpu_slots_create(test_gpu, CELLS, COUNT, PLANE_BIT(PLANE_DISTURBANCE), &slots));
	assert_ok(gpu_slots_in_arrays(slots));
	for (uint32_t i = 0; i < COUNT; i++) {
		const uint32_t slot = i * 7 % COUNT;
		posts[SIDE + 1] = 1000 + (int32_t)slot;
		assert_ok(staged_upload_base(test_gpu, slots, CELLS, slot, posts));
		if (i == 11)
			gpu_slots_figures(slots, &figures);
	}
	assert_int_equal(figures.base_arrays, 2);
	assert_int_equal(figures.base_layers, 16);
	assert_ok(gpu_slots_deform(slots, 3));
	gpu_slots_figures(slots, &figures);
	gpu_slots_bytes(slots, &bytes);
	assert_int_equal(figures.base_arrays, 3);
	assert_int_equal(figures.base_layers, COUNT);
	assert_int_equal(figures.deform_layers, 8);
	assert_int_equal(bytes.base, (uint64_t)COUNT * SIDE * SIDE * 4);
	assert_int_equal(bytes.planes[PLANE_OFFSET], (uint64_t)8 * SIDE * SIDE * 4);
	assert_int_equal(bytes.planes[PLANE_DISTURBANCE], (uint64_t)8 * SIDE * SIDE);
	for (uint32_t slot = 0; slot < COUNT; slot++) {
		gpu_texture_read(gpu_slots_get(slots, slot)->base, 0, rect_of(1, 1, 1, 1), &at);
		assert_int_equal(at, 1000 + (int32_t)slot);
	}
	gpu_slots_destroy(slots);
	assert_int_equal(textures_alive(), 0);
	mem_free(posts);
}

/* Any allocation of the host may fail; nothing leaks and the next try succeeds. */
static void check_failures(bool arrays)
{
	enum { M = 8, COUNT = (M + 1) * (M + 1) };
	int32_t posts[COUNT] = {1}, read[COUNT], zeros[COUNT] = {0};
	const size_t places[PLANES] = {STAGED_AT, GPU_NO_PLANE, GPU_NO_PLANE, STAGED_AT, GPU_NO_PLANE};
	struct gpu_staging *staging;
	assert_ok(staged_from(test_gpu, posts, sizeof posts, &staging));
	for (uint64_t nth = 1;; nth++) {
		struct gpu_slots *slots = NULL;
		mem_fail_nth(nth, 0);
		enum status status = gpu_slots_create(test_gpu, M, 2, ALL, &slots);
		if (status == STATUS_OK && arrays)
			status = gpu_slots_in_arrays(slots);
		if (status == STATUS_OK)
			status = gpu_slots_upload_base(slots, 0, staging, STAGED_AT);
		if (status == STATUS_OK)
			status = gpu_slots_subdivide_base(slots, 0, staging, STAGED_AT, 1, 0, 0);
		if (status == STATUS_OK)
			status = gpu_slots_upload_deform(slots, 0, staging, places);
		if (status == STATUS_OK)
			status = gpu_slots_upload_classes(slots, 0, staging, STAGED_AT);
		if (status == STATUS_OK)
			status = gpu_slots_deform(slots, 0);
		if (status == STATUS_OK)
			status = gpu_slots_decimate(slots, 0, rect_of(0, 0, M + 1, M + 1), 1, 1, 0, 0);
		bool reached = mem_fail_nth(0, 0) >= nth;
		assert_int_equal(status, reached ? STATUS_FAILED : STATUS_OK);
		if (slots != NULL) {
			assert_ok(staged_upload_deform(test_gpu, slots, M, 0, posts, NULL));
			assert_ok(gpu_slots_deform(slots, 0));
			assert_ok(staged_read_deform(test_gpu, slots, M, 0, read, NULL));
			assert_memory_equal(read, posts, sizeof read);
			assert_ok(staged_read_planes(test_gpu, slots, M, 0, (void *[PLANES]){[PLANE_PLASTIC_SINKAGE] = read}));
			assert_memory_equal(read, zeros, sizeof read);
		}
		gpu_slots_destroy(slots);
		assert_int_equal(textures_alive(), 0);
		if (!reached)
			break;
	}
	gpu_staging_destroy(staging);
}

static void a_failed_allocation_loses_nothing(void **state)
{
	(void)state;
	need_gpu();
	check_failures(false);
	check_failures(true);
}

TEST_PROGRAM(slots)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_failed_allocation_loses_nothing), /* first: while no program is linked */
		cmocka_unit_test(planes_are_allocated_when_first_needed_and_reused),
		cmocka_unit_test(without_dirt_there_is_no_dirt_plane),
		cmocka_unit_test(every_plane_comes_back_the_same_bits),
		cmocka_unit_test(state_planes_are_those_of_the_working_level),
		cmocka_unit_test(classes_are_there_once_they_are_loaded),
		cmocka_unit_test(slots_in_arrays_hold_their_own_tiles),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
