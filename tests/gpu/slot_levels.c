/* Subdivision of base heights and decimation of offsets in slots: the passes compute what the pure functions of base compute. */
#include "slots.h"
#include "../support/program.h"

/* lattice_decimate_i32, for a plane of bytes. */
static void decimate_bytes(const uint8_t *fine, uint32_t cells, uint32_t qx, uint32_t qy, uint8_t *coarse)
{
	uint32_t half = cells / 2, stride = cells + 1;
	for (uint32_t y = 0; y <= half; y++)
		for (uint32_t x = 0; x <= half; x++)
			coarse[(qy * half + y) * stride + qx * half + x] = fine[2 * y * stride + 2 * x];
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
	uint8_t *fine_disturbance, *coarse_dirt, read_dirt[POSTS];
};

static void pair_init(struct pair *pair)
{
	pair->fine = random_ints(POSTS);
	pair->coarse = random_ints(POSTS);
	pair->fine_disturbance = random_bytes(POSTS);
	pair->coarse_dirt = random_bytes(POSTS);
	assert_ok(gpu_slots_create(test_gpu, N, 2, PLANE_BIT(PLANE_DISTURBANCE), &pair->slots));
	assert_ok(staged_upload_deform(test_gpu, pair->slots, N, 0, pair->fine, pair->fine_disturbance));
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
	mem_free(pair->fine_disturbance);
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
		decimate_bytes(pair.fine_disturbance, N, qx, qy, pair.coarse_dirt);
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
				pair.coarse_dirt[to] = pair.fine_disturbance[from];
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

TEST_PROGRAM(slot_levels)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(subdivision_is_that_of_base_at_every_level),
		cmocka_unit_test(patches_in_flight_do_not_mix),
		cmocka_unit_test(decimation_of_a_tile_is_that_of_base),
		cmocka_unit_test(decimation_writes_the_changed_posts_and_no_others),
		cmocka_unit_test(decimation_through_levels_is_decimation_by_steps),
		cmocka_unit_test(an_untouched_fine_tile_decimates_as_zeros),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
