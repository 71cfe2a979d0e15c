/*
 * The laws with rocks under the wheels: the same rows with the fewest slots and with all, the same posts on any tiles, pages or
 * pictures beside. The base is never written.
 */
#include "../support/program.h"

#include "raised.h"

static const char scene_text[] = RAISED("ground: {rocks: {cover: 0.2, largest: 3, smallest: 0.5, seed: 7}}");

static void the_fewest_slots_leave_the_same_rows_as_all_resident(void **state)
{
	check_slots(scene_file(scene_text), "\"rocks\"");
}

static void tiles_of_64_and_256_give_the_same_posts(void **state)
{
	check_tiles(scene_file(scene_text));
}

/* Where the GPU deforms, its tiles have the same rocks as those of the CPU. */
static void the_cpu_and_the_gpu_leave_the_same_rows(void **state)
{
	static const char *const both[] = {"box", "slippage", "sheet"};
	const char *scene = scene_file(scene_text);
	for (int m = 0; m < 3; m++) {
		const char *cpu = fresh("cpu.furrow", 64), *gpu = fresh("gpu.furrow", 64);
		mem_free(support_drive(scene, cpu, with(both[m], "compute=cpu", "end_time=1")));
		mem_free(support_drive(scene, gpu, with(both[m], "end_time=1", NULL)));
		support_verify(gpu);
		assert_true(support_hash(cpu) == support_hash(gpu));
	}
}

/* Level 0 of the store is what it was, bit for bit; only offsets and their like are written; another seed makes other ruts. */
static void the_base_is_never_written(void **state)
{
	const char *scene = scene_file(scene_text), *path = fresh("one.furrow", 64), *other = fresh("other.furrow", 64);
	struct store *store;
	must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	const uint64_t before = store_base_hash(store);
	store_close(store);
	mem_free(support_drive(scene, path, (const char *[]){"end_time=2", NULL}));
	mem_free(support_drive(scene, other, (const char *[]){"end_time=2", "ground.rocks.seed=8", NULL}));
	must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	struct store_reader *reader;
	struct store_numbers numbers;
	int32_t posts[65 * 65];
	must(store_reader_create(store, &reader));
	must(store_count(store, &numbers));
	assert_int_equal(numbers.base_tiles, 4 + 1);
	for (uint32_t tile = 0; tile < 4; tile++) {
		must(store_read_base(reader, (struct tile){0, tile % 2, tile / 2}, posts, NULL));
		for (int64_t i = 0; i < 65 * 65; i++)
			assert_true(height_code_metres(posts[i], store_meta(store)->step) == level_ground(tile % 2 * 64 + i % 65, tile / 2 * 64 + i / 65));
	}
	assert_true(store_base_hash(store) == before);
	store_reader_destroy(reader);
	store_close(store);
	assert_true(support_hash(path) != support_hash(other));
}

TEST_PROGRAM(rocks)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_fewest_slots_leave_the_same_rows_as_all_resident),
		cmocka_unit_test(tiles_of_64_and_256_give_the_same_posts),
		cmocka_unit_test(the_cpu_and_the_gpu_leave_the_same_rows),
		cmocka_unit_test(the_base_is_never_written),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
