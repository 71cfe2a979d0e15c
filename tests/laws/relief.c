/*
 * The laws with relief under the wheels: the same rows with the fewest slots and with all, the same posts on any tiles, pages or
 * pictures beside, and by class of soil too.
 */
#include "../support/program.h"

#include "raised.h"

static const char scene_text[] = RAISED("relief: {roughness: 0.06, wavelength: 3, seed: 7}");

static void the_fewest_slots_leave_the_same_rows_as_all_resident(void **state)
{
	check_slots(scene_file(scene_text), "\"relief\"");
}

static void tiles_of_64_and_256_give_the_same_posts(void **state)
{
	check_tiles(scene_file(scene_text));
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
	mem_free(support_drive(scene, other, (const char *[]){"end_time=2", "relief.seed=8", NULL}));
	must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	struct store_reader *reader;
	struct store_numbers numbers;
	double *posts = malloc(sizeof *posts * 129 * 129);
	must(store_reader_create(store, &reader));
	must(store_count(store, &numbers));
	assert_int_equal(numbers.base_tiles, 4 + 1);
	must(store_read_posts(reader, STORE_BASE, 0, (struct post_rect){0, 0, 129, 129}, posts));
	for (int64_t i = 0; i < 129 * 129; i++)
		assert_true(posts[i] == level_ground(i % 129, i / 129));
	assert_true(store_base_hash(store) == before);
	free(posts);
	store_reader_destroy(reader);
	store_close(store);
	assert_true(support_hash(path) != support_hash(other));
}

TEST_PROGRAM(relief)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_fewest_slots_leave_the_same_rows_as_all_resident),
		cmocka_unit_test(tiles_of_64_and_256_give_the_same_posts),
		cmocka_unit_test(the_base_is_never_written),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
