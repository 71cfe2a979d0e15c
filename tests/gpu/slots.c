/* Slots: allocated when needed, reused, and their passes the same as base's pure functions. */
#include "gpu_test.h"
#include "staged.h"

static int32_t *random_ints(size_t count)
{
	int32_t *values = mem_alloc(count, sizeof *values);
	assert_non_null(values);
	for (size_t i = 0; i < count; i++)
		values[i] = any_int();
	return values;
}

static uint8_t *random_bytes(size_t count)
{
	uint8_t *values = mem_alloc(count, 1);
	assert_non_null(values);
	for (size_t i = 0; i < count; i++)
		values[i] = (uint8_t)any_word();
	return values;
}

/* lattice_decimate_i32, for a plane of bytes. */
static void decimate_bytes(const uint8_t *fine, uint32_t cells, uint32_t qx, uint32_t qy, uint8_t *coarse)
{
	uint32_t half = cells / 2, stride = cells + 1;
	for (uint32_t y = 0; y <= half; y++)
		for (uint32_t x = 0; x <= half; x++)
			coarse[(qy * half + y) * stride + qx * half + x] = fine[2 * y * stride + 2 * x];
}

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
	for (unsigned planes = 0; planes <= ALL; planes++) {
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
			assert_int_equal(gpu_slots_get(slots, 0)->planes[plane] != NULL,
					 (some & planes & ~GPU_DRAWN_PLANES) != 0 && (planes >> plane & 1) != 0); /* all, or none */
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
	assert_planes(slots, CELLS, 0, tile, GPU_DRAWN_PLANES);
	free_planes(tile);
	tile = random_planes(CELLS);
	assert_ok(staged_upload_planes(test_gpu, slots, CELLS, 0, (const void *const *)tile.planes));
	gpu_slots_bytes(slots, &bytes);
	assert_int_equal(bytes.planes[PLANE_PLASTIC_SINKAGE], TILE * 4);
	assert_int_equal(bytes.planes[PLANE_SHEAR], TILE * 2);

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

static void subdivision_is_that_of_base_at_every_level(void **state)
{
	(void)state;
	need_gpu();
	for (uint32_t n = 8; n <= 64; n *= 2) {
		size_t posts = (size_t)(n + 1) * (n + 1);
		int32_t *expected = mem_alloc(posts, sizeof *expected), *read = mem_alloc(posts, sizeof *read);
		struct gpu_slots *slots;
		assert_non_null(expected);
		assert_non_null(read);
		assert_ok(gpu_slots_create(test_gpu, n, 3, 0, &slots));
		for (int shift = 1; shift <= 14; shift++) {
			for (int i = 0; i < 6; i++) { /* more than there are scratch textures */
				uint32_t stride = lattice_patch_posts(n, shift), tiles = (1u << shift) > n ? (1u << shift) / n : 1;
				uint32_t sub_x = i == 0 ? tiles - 1 : any_word() % tiles, sub_y = i == 1 ? tiles - 1 : any_word() % tiles;
				int32_t *patch = random_ints((size_t)stride * stride);
				lattice_subdivide(patch, n, shift, sub_x * n, sub_y * n, expected);
				assert_ok(staged_subdivide_base(test_gpu, slots, n, (uint32_t)i % 3, patch, shift, sub_x * n, sub_y * n));
				gpu_texture_read(gpu_slots_get(slots, (uint32_t)i % 3)->base, 0, rect_of(0, 0, n + 1, n + 1), read);
				assert_memory_equal(read, expected, posts * sizeof *read);
				mem_free(patch);
			}
		}
		assert_ok(gpu_check(test_gpu, "subdivision"));
		gpu_slots_destroy(slots);
		mem_free(expected);
		mem_free(read);
	}
}

/* More patches than there are scratch textures, all in one staging, and nobody waits between. */
static void patches_in_flight_do_not_mix(void **state)
{
	enum { CELLS = 16, COUNT = 12, SIDE = CELLS / 2 + 1, PATCH = SIDE * SIDE, TILE = (CELLS + 1) * (CELLS + 1) };
	int32_t expected[TILE], read[TILE];
	struct gpu_staging *staging;
	struct gpu_slots *slots;
	(void)state;
	need_gpu();
	for (int direct = 0; direct < 2; direct++) {
		assert_int_equal(lattice_patch_posts(CELLS, 1), SIDE);
		assert_ok(gpu_slots_create(test_gpu, CELLS, COUNT, 0, &slots));
		int32_t *patches = random_ints(COUNT * PATCH);
		assert_ok(staged_from(test_gpu, patches, COUNT * PATCH * sizeof *patches, &staging));
		staging->direct = direct == 1;
		for (uint32_t i = 0; i < COUNT; i++)
			assert_ok(gpu_slots_subdivide_base(slots, i, staging, STAGED_AT + i * PATCH * sizeof *patches, 1, 0, 0));
		for (uint32_t i = 0; i < COUNT; i++) {
			lattice_subdivide(patches + i * PATCH, CELLS, 1, 0, 0, expected);
			gpu_texture_read(gpu_slots_get(slots, i)->base, 0, rect_of(0, 0, CELLS + 1, CELLS + 1), read);
			assert_memory_equal(read, expected, sizeof read);
		}
		gpu_staging_destroy(staging);
		gpu_slots_destroy(slots);
		mem_free(patches);
	}
}

/* A fine tile, a coarse one over it, and what base makes of them. */
enum { N = 32, POSTS = (N + 1) * (N + 1) };
struct pair {
	struct gpu_slots *slots;
	int32_t *fine, *coarse, read[POSTS];
	uint8_t *fine_dirt, *coarse_dirt, read_dirt[POSTS];
};

static void pair_init(struct pair *pair)
{
	pair->fine = random_ints(POSTS);
	pair->coarse = random_ints(POSTS);
	pair->fine_dirt = random_bytes(POSTS);
	pair->coarse_dirt = random_bytes(POSTS);
	assert_ok(gpu_slots_create(test_gpu, N, 2, PLANE_BIT(PLANE_DISTURBANCE), &pair->slots));
	assert_ok(staged_upload_deform(test_gpu, pair->slots, N, 0, pair->fine, pair->fine_dirt));
	assert_ok(staged_upload_deform(test_gpu, pair->slots, N, 1, pair->coarse, pair->coarse_dirt));
}

static void pair_check(struct pair *pair)
{
	assert_ok(staged_read_deform(test_gpu, pair->slots, N, 1, pair->read, pair->read_dirt));
	assert_memory_equal(pair->read, pair->coarse, sizeof pair->read);
	assert_memory_equal(pair->read_dirt, pair->coarse_dirt, sizeof pair->read_dirt);
}

static void pair_finish(struct pair *pair)
{
	gpu_slots_destroy(pair->slots);
	mem_free(pair->fine);
	mem_free(pair->coarse);
	mem_free(pair->fine_dirt);
	mem_free(pair->coarse_dirt);
}

static void decimation_of_a_tile_is_that_of_base(void **state)
{
	struct pair pair;
	(void)state;
	need_gpu();
	pair_init(&pair);
	for (uint32_t quadrant = 0; quadrant < 4; quadrant++) {
		uint32_t qx = quadrant & 1, qy = quadrant >> 1;
		assert_ok(gpu_slots_decimate(pair.slots, 0, rect_of(0, 0, N + 1, N + 1), 1, 1, qx * N / 2, qy * N / 2));
		lattice_decimate_i32(pair.fine, N, qx, qy, pair.coarse);
		decimate_bytes(pair.fine_dirt, N, qx, qy, pair.coarse_dirt);
		pair_check(&pair);
	}
	pair_finish(&pair);
}

static void decimation_writes_the_changed_posts_and_no_others(void **state)
{
	struct pair pair;
	(void)state;
	need_gpu();
	pair_init(&pair);
	for (int i = 0; i < 200; i++) {
		/* Up to 2^5 = N and beyond it, where one post is kept. */
		int steps = 1 + i % 8;
		uint32_t every = 1u << steps, x = any_word() % (N + 1), y = any_word() % (N + 1);
		if (every <= N) {
			x = x / every * every;
			y = y / every * every;
		}
		struct gpu_rect rect = rect_of(x, y, any_word() % (N + 2 - x), any_word() % (N + 2 - y));
		uint32_t columns = (rect.width + every - 1) / every, rows = (rect.height + every - 1) / every;
		uint32_t to_x = any_word() % (N + 2 - columns), to_y = any_word() % (N + 2 - rows);
		assert_ok(gpu_slots_decimate(pair.slots, 0, rect, steps, 1, to_x, to_y));
		for (uint32_t row = 0; row < rows; row++) {
			for (uint32_t column = 0; column < columns; column++) {
				size_t from = (y + row * every) * (N + 1) + x + column * every;
				size_t to = (to_y + row) * (N + 1) + to_x + column;
				if (columns == 0 || rows == 0)
					continue;
				pair.coarse[to] = pair.fine[from];
				pair.coarse_dirt[to] = pair.fine_dirt[from];
			}
		}
		pair_check(&pair);
	}
	pair_finish(&pair);
}

static void decimation_through_levels_is_decimation_by_steps(void **state)
{
	int32_t direct[POSTS], stepwise[POSTS];
	struct gpu_slots *slots;
	(void)state;
	need_gpu();
	int32_t *fine = random_ints(POSTS);
	assert_ok(gpu_slots_create(test_gpu, N, 4, 0, &slots));
	assert_ok(staged_upload_deform(test_gpu, slots, N, 0, fine, NULL));
	assert_ok(gpu_slots_decimate(slots, 0, rect_of(0, 0, N + 1, N + 1), 2, 3, 0, 0));
	assert_ok(gpu_slots_decimate(slots, 0, rect_of(0, 0, N + 1, N + 1), 1, 1, 0, 0));
	assert_ok(gpu_slots_decimate(slots, 1, rect_of(0, 0, N / 2 + 1, N / 2 + 1), 1, 2, 0, 0));
	assert_ok(staged_read_deform(test_gpu, slots, N, 3, direct, NULL));
	assert_ok(staged_read_deform(test_gpu, slots, N, 2, stepwise, NULL));
	assert_memory_equal(direct, stepwise, sizeof direct);
	gpu_slots_destroy(slots);
	mem_free(fine);
}

static void an_untouched_fine_tile_decimates_as_zeros(void **state)
{
	struct pair pair;
	(void)state;
	need_gpu();
	pair_init(&pair);
	gpu_slots_undeform(pair.slots, 0);
	assert_ok(gpu_slots_decimate(pair.slots, 0, rect_of(0, 0, N + 1, N + 1), 1, 1, N / 2, 0));
	for (size_t y = 0; y <= N / 2; y++) {
		memset(pair.coarse + y * (N + 1) + N / 2, 0, (N / 2 + 1) * sizeof *pair.coarse);
		memset(pair.coarse_dirt + y * (N + 1) + N / 2, 0, N / 2 + 1);
	}
	pair_check(&pair);
	gpu_slots_undeform(pair.slots, 1);
	assert_ok(gpu_slots_decimate(pair.slots, 0, rect_of(0, 0, N + 1, N + 1), 1, 1, 0, 0));
	assert_null(gpu_slots_get(pair.slots, 1)->target);
	pair_finish(&pair);
}

/* Any allocation of the host may fail; nothing leaks and the next try succeeds. */
static void a_failed_allocation_loses_nothing(void **state)
{
	enum { M = 8, COUNT = (M + 1) * (M + 1) };
	int32_t posts[COUNT] = {1}, read[COUNT], zeros[COUNT] = {0};
	const size_t places[PLANES] = {STAGED_AT, GPU_NO_PLANE, GPU_NO_PLANE, STAGED_AT, GPU_NO_PLANE};
	struct gpu_staging *staging;
	(void)state;
	need_gpu();
	assert_ok(staged_from(test_gpu, posts, sizeof posts, &staging));
	for (uint64_t nth = 1;; nth++) {
		struct gpu_slots *slots = NULL;
		mem_fail_nth(nth, 0);
		enum status status = gpu_slots_create(test_gpu, M, 2, ALL, &slots);
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

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_failed_allocation_loses_nothing), /* first: while no program is linked */
		cmocka_unit_test(planes_are_allocated_when_first_needed_and_reused),
		cmocka_unit_test(without_dirt_there_is_no_dirt_plane),
		cmocka_unit_test(every_plane_comes_back_the_same_bits),
		cmocka_unit_test(state_planes_are_those_of_the_working_level),
		cmocka_unit_test(classes_are_there_once_they_are_loaded),
		cmocka_unit_test(subdivision_is_that_of_base_at_every_level),
		cmocka_unit_test(patches_in_flight_do_not_mix),
		cmocka_unit_test(decimation_of_a_tile_is_that_of_base),
		cmocka_unit_test(decimation_writes_the_changed_posts_and_no_others),
		cmocka_unit_test(decimation_through_levels_is_decimation_by_steps),
		cmocka_unit_test(an_untouched_fine_tile_decimates_as_zeros),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
