/* Overlays over overlays: a chain is the store that it would have been in one file. */
#include "chain.h"
#include "../support/program.h"

static enum status take_key(void *user, uint64_t key)
{
	uint64_t **to = user;
	*(*to)++ = key;
	return STATUS_OK;
}

/* Every plane of every tile, every list of tiles, every height. */
static void assert_same_reads(struct store *a, struct store *b)
{
	struct store *stores[2] = {a, b};
	struct store_reader *readers[2];
	static uint64_t keys[2][4096];
	for (int i = 0; i < 2; i++)
		assert_ok(store_reader_create(stores[i], &readers[i]));
	for (int level = -1; level <= extent_coarsest(&extent); level++)
		for (int plane = 0; plane < PLANES; plane++) {
			uint64_t *ends[2] = {keys[0], keys[1]};
			for (int i = 0; i < 2; i++)
				assert_ok(store_each_plane(readers[i], (enum plane)plane, level, take_key, &ends[i]));
			size_t count = (size_t)(ends[0] - keys[0]);
			assert_int_equal(count, ends[1] - keys[1]);
			assert_memory_equal(keys[0], keys[1], count * sizeof **keys);
		}
	for (uint32_t i = 0; i < 70; i++) {
		static int32_t posts[2][PLANES][POSTS];
		unsigned present[2];
		for (int side = 0; side < 2; side++) {
			void *planes[PLANES];
			for (int plane = 0; plane < PLANES; plane++)
				planes[plane] = posts[side][plane];
			assert_ok(store_read_deformed(readers[side], (struct tile){-1, i % 10, i / 10}, (1u << PLANES) - 1, planes, &present[side]));
		}
		assert_int_equal(present[0], present[1]);
		assert_memory_equal(posts[0], posts[1], sizeof posts[0]);
		struct store_sample samples[2];
		memset(samples, 0, sizeof samples);
		for (int side = 0; side < 2; side++)
			assert_ok(store_sample(readers[side], 0.37 + 2.1 * i, 0.2 + 1.37 * i, &samples[side]));
		assert_memory_equal(&samples[0], &samples[1], sizeof samples[0]);
	}
	for (int i = 0; i < 2; i++)
		store_reader_destroy(readers[i]);
}

static void assert_same(struct store *over, struct store *copy)
{
	struct store_numbers numbers[2];
	struct store_run runs[2];
	struct store_check checks[2] = {verified(over), verified(copy)};
	assert_true(content(over) == content(copy));
	assert_memory_equal(&checks[0], &checks[1], sizeof checks[0]);
	assert_ok(store_count(over, &numbers[0]));
	assert_ok(store_count(copy, &numbers[1]));
	assert_memory_equal(numbers[0].plane_tiles, numbers[1].plane_tiles, sizeof numbers[0].plane_tiles);
	assert_memory_equal(numbers[0].plane_bytes, numbers[1].plane_bytes, sizeof numbers[0].plane_bytes);
	assert_int_equal(numbers[0].commits, numbers[1].commits);
	assert_ok(store_last_run(over, &runs[0]));
	assert_ok(store_last_run(copy, &runs[1]));
	assert_int_equal(runs[0].step, runs[1].step);
	assert_same_reads(over, copy);
}

static void random_drives_in_a_chain_are_the_same_drives_in_one_store(void **state)
{
	for (uint32_t seed = 1; seed <= 4; seed++) {
		struct chain chain = chain_make("drives", 1000 * seed);
		for (int depth = 1; depth <= DEPTH; depth++) {
			if (depth == 1)
				chain_grow(&chain, 1, 3);
			else
				assert_ok(store_create_overlay(chain.paths[depth], chain.paths[depth - 1]));
			struct store *over = open_store(chain.paths[depth], STORE_WRITE), *copy = open_store(chain.copy, STORE_WRITE);
			assert_ok(store_set_working_level(over, -1));
			for (int i = 0; i < 4 && depth > 1; i++)
				chain_drive(&chain, over, copy);
			assert_same(over, copy);
			store_close(over);
			store_close(copy);
		}
		/* Once more, by who only reads. */
		struct store *over = open_store(chain.paths[DEPTH], STORE_READ), *copy = open_store(chain.copy, STORE_READ);
		assert_same(over, copy);
		store_close(over);
		store_close(copy);
		chain_free(&chain);
	}
}

static void a_rut_that_is_filled_again_is_stored_as_zeros(void **state)
{
	const char *base = in_folder("base.furrow"), *child = in_folder("child.furrow");
	struct field field = field_make(-1);
	struct store_commit_result result;
	struct store_numbers numbers;
	make_store(base);
	unlink(child);
	struct store *plain = open_store(base, STORE_READ);
	store_close(plain);
	struct store *store = open_store(base, STORE_WRITE);
	dig(store, 1, 2);
	store_close(store);
	assert_ok(store_create_overlay(child, base));
	store = open_store(child, STORE_WRITE);
	uint64_t before = content(store);
	int64_t rows, own;
	assert_ok(store_count(store, &numbers));
	rows = numbers.plane_tiles[PLANE_OFFSET];
	assert_true(rows > 4);
	assert_ok(field_commit(&field, field_all(&field), store, 3, &result));
	assert_ok(store_count(store, &numbers));
	for (int plane = 0; plane < PLANES; plane++)
		assert_int_equal(numbers.plane_tiles[plane], 0);
	assert_int_equal(result.changed[PLANE_OFFSET], rows);
	assert_ok(store_sql_integer(store->db, child, "SELECT count(*) FROM \"offset\" WHERE low = 0 AND high = 0", &own));
	assert_int_equal(own, rows); /* coarser ones, too */
	verified(store);
	/* As the parent again: no row is the child's own any more. */
	for (int i = 0; i < 2; i++)
		field_dig(&field, 30 + 25 * i, 60 - 10 * i, 12, 1 + (uint32_t)i);
	/* dig() begins each commit with an empty field. */
	field_clear(&field);
	store_close(store);
	assert_ok(store_open(child, &writing, &store));
	assert_ok(store_reset(store, true));
	assert_true(content(store) == before);
	assert_int_equal(store->commit, 2);
	assert_ok(store_sql_integer(store->db, child, "SELECT count(*) FROM \"offset\"", &own));
	assert_int_equal(own, 0);
	store_close(store);
	field_free(&field);
}

static void a_row_that_is_the_parent_s_again_is_not_kept_twice(void **state)
{
	const char *base = in_folder("base.furrow"), *child = in_folder("child.furrow");
	struct field field = field_make(-1), other = field_make(-1);
	struct store_commit_result result;
	int64_t own;
	make_store(base);
	unlink(child);
	struct store *store = open_store(base, STORE_WRITE);
	assert_ok(store_set_working_level(store, -1));
	field_dig(&field, 70, 50, 30, 5);
	field_dig(&other, 90, 40, 30, 6);
	assert_ok(field_commit(&field, field_all(&field), store, 1, &result));
	store_close(store);
	assert_ok(store_create_overlay(child, base));
	store = open_store(child, STORE_WRITE);
	uint64_t before = content(store);
	assert_ok(field_commit(&field, field_all(&field), store, 2, &result));
	assert_int_equal(result.tiles_written, 0);
	assert_ok(field_commit(&other, field_all(&other), store, 3, &result));
	assert_true(content(store) != before);
	verified(store);
	assert_ok(field_commit(&field, field_all(&field), store, 4, &result));
	assert_true(content(store) == before);
	for (int table = ROW_OFFSET; table < ROW_TABLES; table++) {
		char sql[64];
		snprintf(sql, sizeof sql, "SELECT count(*) FROM %s", store_rows_sql_name((enum row_table)table));
		assert_ok(store_sql_integer(store->db, child, sql, &own));
		assert_int_equal(own, 0);
	}
	verified(store);
	store_close(store);
	field_free(&field);
	field_free(&other);
}

static void a_rollback_in_a_chain_brings_the_parent_s_rows_back(void **state)
{
	struct chain chain = chain_make("rollback", 77);
	chain_grow(&chain, 2, 3);
	assert_ok(store_create_overlay(chain.paths[3], chain.paths[2]));
	struct store *store = open_store(chain.paths[3], STORE_WRITE), *copy = open_store(chain.copy, STORE_WRITE);
	assert_ok(store_set_working_level(store, -1));
	for (int i = 0; i < 6; i++) {
		uint64_t before = content(store);
		assert_ok(store_mark(store));
		assert_ok(store_mark(copy));
		chain_drive(&chain, store, copy);
		chain_drive(&chain, store, copy);
		assert_ok(store_rollback(store));
		assert_ok(store_rollback(copy));
		assert_true(content(store) == before);
		assert_same(store, copy);
		/* From here on the field is ahead of the ground; a whole commit makes them one again. */
		struct store_commit_result result;
		assert_ok(field_commit(&chain.field, field_all(&chain.field), store, 90 + i, &result));
		assert_ok(field_commit(&chain.field, field_all(&chain.field), copy, 90 + i, &result));
	}
	store_close(store);
	store_close(copy);
	chain_free(&chain);
}

static enum status count_key(void *user, uint64_t key)
{
	++*(int64_t *)user;
	return STATUS_OK;
}

static void revisions_go_on_from_the_parent_s(void **state)
{
	struct chain chain = chain_make("revisions", 5);
	chain_grow(&chain, 2, 3);
	struct store *over = open_store(chain.paths[2], STORE_READ), *copy = open_store(chain.copy, STORE_READ);
	struct store_reader *readers[2];
	assert_ok(store_reader_create(over, &readers[0]));
	assert_ok(store_reader_create(copy, &readers[1]));
	assert_int_equal(over->commit, copy->commit);
	for (int64_t since = over->commit; since >= 0; since--) {
		int64_t counts[2] = {0, 0}, now[2];
		for (int i = 0; i < 2; i++)
			assert_ok(store_each_changed(readers[i], since, count_key, &counts[i], &now[i]));
		assert_int_equal(now[0], now[1]);
		/* A row that became its parent's again has the parent's revision: fewer may be told, as with rows that went. */
		assert_true(counts[0] <= counts[1] && (since < over->commit || counts[0] == 0));
	}
	store_reader_destroy(readers[0]);
	store_reader_destroy(readers[1]);
	store_close(over);
	store_close(copy);
	chain_free(&chain);
}

static void a_parent_is_not_written_while_a_child_is_open(void **state)
{
	struct chain chain = chain_make("held", 9);
	chain_grow(&chain, 2, 2);
	struct store *over = open_store(chain.paths[2], STORE_READ), *parent;
	struct store_reader *reader;
	assert_ok(store_reader_create(over, &reader));
	uint64_t before = content(over);
	assert_status(store_open(chain.paths[1], &writing, &parent), STATUS_FAILED);
	assert_true(content(over) == before);
	store_reader_destroy(reader);
	store_close(over);
	parent = open_store(chain.paths[1], STORE_WRITE);
	store_close(parent);
	chain_free(&chain);
}

TEST_PROGRAM(chain)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(random_drives_in_a_chain_are_the_same_drives_in_one_store),
		cmocka_unit_test(a_rut_that_is_filled_again_is_stored_as_zeros),
		cmocka_unit_test(a_row_that_is_the_parent_s_again_is_not_kept_twice),
		cmocka_unit_test(a_rollback_in_a_chain_brings_the_parent_s_rows_back),
		cmocka_unit_test(revisions_go_on_from_the_parent_s),
		cmocka_unit_test(a_parent_is_not_written_while_a_child_is_open),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
