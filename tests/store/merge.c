/* Merges: two overlays driven over disjoint ground are both drives in one store, row for row; what both changed is refused. */
#include "chain.h"
#include "../support/program.h"

/* Digs into a store and into the field of all. `side` 0 keeps to the west, 1 to the east. */
static void drive_side(struct chain *chain, struct field *field, struct store *store, struct store *copy, int side)
{
	struct store_commit_result result;
	int64_t radius = 1 + chain_draw(chain, 12);
	int64_t cx = side == 0 ? 14 + chain_draw(chain, 40) : 95 + chain_draw(chain, 40), cy = 10 + chain_draw(chain, 80);
	uint32_t seed = chain_draw(chain, 1000);
	struct field *fields[2] = {field, &chain->field};
	for (int i = 0; i < 2; i++)
		field_dig(fields[i], cx, cy, radius, seed);
	assert_ok(field_commit(field, around(cx, cy, radius), store, ++chain->step, &result));
	assert_ok(field_commit(&chain->field, around(cx, cy, radius), copy, chain->step, &result));
	struct store_run run = {.scene_hash = "abc", .state = "{}", .compacted = 3 + side};
	assert_ok(store_commit(store, NULL, 0, &run, &result));
	assert_ok(store_commit(copy, NULL, 0, &run, &result));
}

/* `ruts`: the store that both begin with is deformed, and a side fills what it finds. */
static void merge_of_disjoint(uint32_t seed, bool ruts, bool deep)
{
	struct chain chain = chain_make("merge", seed);
	struct store *copy, *store;
	struct store_conflicts conflicts;
	char paths[2][256], merged[256];
	struct field fields[2] = {field_make(-1), field_make(-1)};
	for (int i = 0; i < 2; i++)
		snprintf(paths[i], sizeof paths[i], "%s/side%d.furrow", folder, i);
	snprintf(merged, sizeof merged, "%s/merged.furrow", folder);
	unlink(paths[0]);
	unlink(paths[1]);
	unlink(merged);
	if (ruts)
		chain_grow(&chain, deep ? 2 : 0, 2);
	struct field start = field_make(-1); /* what both begin with */
	for (int plane = 0; plane < PLANES; plane++)
		memcpy(start.planes[plane], chain.field.planes[plane], (size_t)(start.width * start.height) * plane_bytes((enum plane)plane));
	copy = open_store(chain.copy, STORE_WRITE);
	assert_ok(store_set_working_level(copy, -1));
	for (int i = 0; i < 2; i++) {
		assert_ok(store_create_overlay(paths[i], chain.paths[ruts && deep ? 2 : 0]));
		store = open_store(paths[i], STORE_WRITE);
		assert_ok(store_set_working_level(store, -1));
		for (int plane = 0; plane < PLANES; plane++)
			memcpy(fields[i].planes[plane], start.planes[plane],
			       (size_t)(start.width * start.height) * plane_bytes((enum plane)plane));
		for (int n = 0; n < 4; n++)
			drive_side(&chain, &fields[i], store, copy, i);
		store_close(store);
	}
	for (int turn = 0; turn < 2; turn++) { /* in either order */
		assert_ok(store_merge(paths[turn], paths[1 - turn], merged, &conflicts));
		store = open_store(merged, STORE_READ);
		assert_int_equal(conflicts.posts, 0);
		assert_true(content(store) == content(copy));
		verified(store);
		store_close(store);
		assert_status(store_merge(paths[0], paths[1], merged, &conflicts), STATUS_INPUT);
		assert_non_null(strstr(failure_message(), "exists"));
		unlink(merged);
	}
	store_close(copy);
	field_free(&start);
	for (int i = 0; i < 2; i++)
		field_free(&fields[i]);
	chain_free(&chain);
}

static void disjoint_drives_become_both_in_one_store(void **state)
{
	for (uint32_t seed = 1; seed <= 3; seed++) {
		merge_of_disjoint(100 * seed, false, false);
		merge_of_disjoint(100 * seed + 7, true, false);
		merge_of_disjoint(100 * seed + 9, true, true);
	}
}

static void what_both_changed_is_refused_unless_it_is_the_same(void **state)
{
	char base[256], paths[2][256], merged[256];
	struct store_conflicts conflicts;
	struct store_commit_result result;
	snprintf(base, sizeof base, "%s/base.furrow", folder);
	snprintf(merged, sizeof merged, "%s/merged.furrow", folder);
	make_store(base);
	for (int same = 0; same < 2; same++) {
		unlink(merged);
		for (int i = 0; i < 2; i++) {
			struct field field = field_make(-1);
			snprintf(paths[i], sizeof paths[i], "%s/both%d.furrow", folder, i);
			unlink(paths[i]);
			assert_ok(store_create_overlay(paths[i], base));
			struct store *store = open_store(paths[i], STORE_WRITE);
			assert_ok(store_set_working_level(store, -1));
			field_dig(&field, 20 + 60 * i, 40, 4, 1);
			field_dig(&field, 70, 70, 5, same ? 9 : 9 + (uint32_t)i);
			assert_ok(field_commit(&field, field_all(&field), store, 1, &result));
			store_close(store);
			field_free(&field);
		}
		enum status status = store_merge(paths[0], paths[1], merged, &conflicts);
		if (same) {
			assert_ok(status);
			struct store *store = open_store(merged, STORE_WRITE);
			verified(store);
			store_close(store);
			continue;
		}
		assert_status(status, STATUS_INPUT);
		assert_int_equal(files_of("merged"), 0);
		assert_true(conflicts.places > 0 && conflicts.posts >= 100 && conflicts.level == -1);
		for (int64_t i = 0; i < conflicts.places; i++) /* within what both dug */
			assert_true(conflicts.rects[i].x0 >= 65 && conflicts.rects[i].x1 <= 76 && conflicts.rects[i].y0 >= 65 && conflicts.rects[i].y1 <= 76);
	}
}

static void what_cannot_be_merged_is_refused(void **state)
{
	const char *base = in_folder("base.furrow"), *bare = in_folder("bare.furrow"), *out = in_folder("out.furrow");
	struct store_conflicts conflicts;
	make_store(base);
	unlink(bare);
	assert_ok(store_create_overlay(bare, base));
	assert_status(store_merge(base, bare, out, &conflicts), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "whole store"));
	assert_status(store_merge(bare, bare, out, &conflicts), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "drive them"));
	assert_status(store_merge(bare, in_folder("absent"), in_folder("out.furrow"), &conflicts), STATUS_INPUT);
	assert_int_equal(files_of("out.furrow"), 0);
}

TEST_PROGRAM(merge)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(disjoint_drives_become_both_in_one_store),
		cmocka_unit_test(what_both_changed_is_refused_unless_it_is_the_same),
		cmocka_unit_test(what_cannot_be_merged_is_refused),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
