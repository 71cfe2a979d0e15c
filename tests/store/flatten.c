/* Flattened chains: one plain store with the same content, row for row; whatever stops the work, nothing of it is left. */
#include "chain.h"
#include "../support/program.h"

static char flat[256];

static int enter(void **state)
{
	if (folder_make(state) != 0)
		return -1;
	snprintf(flat, sizeof flat, "%s/flat.furrow", folder);
	return 0;
}

static enum status keep_progress(void *user, int64_t done, int64_t total)
{
	int64_t *last = user;
	assert_true(done == last[0] + 1 && done <= total && (last[1] == 0 || last[1] == total));
	last[0] = done;
	last[1] = total;
	return STATUS_OK;
}

struct row_sum {
	uint64_t rows, sum;
};

static enum status add_entry(void *user, const struct row_entry *entry)
{
	struct row_sum *sum = user;
	sum->rows++;
	sum->sum += (entry->key ^ entry->hash) * 0x9e3779b97f4a7c15u + (uint64_t)entry->revision * 0xc2b2ae3d27d4eb4fu + entry->size;
	return STATUS_OK;
}

/* Keys, hashes, sizes and revisions of all rows. */
static void assert_same_rows(struct store *a, struct store *b, bool revisions)
{
	for (int table = 0; table < ROW_TABLES; table++) {
		struct row_sum sums[2] = {{0}};
		assert_ok(store_rows_each(store_table(a, (enum row_table)table), (enum row_table)table, 0, INT64_MAX, add_entry, &sums[0]));
		assert_ok(store_rows_each(store_table(b, (enum row_table)table), (enum row_table)table, 0, INT64_MAX, add_entry, &sums[1]));
		assert_int_equal(sums[0].rows, sums[1].rows);
		if (revisions)
			assert_true(sums[0].sum == sums[1].sum);
	}
}

static void assert_flat(const char *over, const char *copy)
{
	struct store_run runs[2];
	int64_t last[2] = {0};
	unlink(flat);
	assert_ok(store_flatten(over, flat, false, keep_progress, last));
	assert_true(last[0] > 0 && last[0] == last[1]);
	assert_int_equal(files_of("flat.furrow"), 1);
	struct store *chain = open_store(over, STORE_READ), *one = open_store(flat, STORE_READ);
	assert_null(store_base_path(one));
	assert_int_equal(store_depth(one), 0);
	assert_true(store_base_hash(one) == store_base_hash(chain));
	assert_true(content(one) == content(chain));
	assert_same_rows(chain, one, true);
	struct store_check check = verified(one);
	assert_int_equal(check.tiles, last[0]);
	assert_ok(store_last_run(chain, &runs[0]));
	assert_ok(store_last_run(one, &runs[1]));
	assert_int_equal(one->commit, chain->commit);
	assert_true((runs[0].scene_hash == NULL) == (runs[1].scene_hash == NULL));
	if (runs[0].scene_hash != NULL) {
		assert_string_equal(runs[0].scene_hash, runs[1].scene_hash);
		assert_string_equal(runs[0].state, runs[1].state);
		assert_int_equal(runs[0].step, runs[1].step);
	}
	assert_string_equal(one->meta.sources, chain->meta.sources);
	assert_string_equal(one->meta.insets, chain->meta.insets);
	store_close(chain);
	if (copy != NULL) { /* the same drives in one file */
		struct store *witness = open_store(copy, STORE_READ);
		assert_true(content(one) == content(witness));
		assert_same_rows(witness, one, false);
		store_close(witness);
	}
	store_close(one);
}

static void a_flat_chain_is_the_store_that_had_all_drives(void **state)
{
	for (uint32_t seed = 1; seed <= 3; seed++) {
		struct chain chain = chain_make("flatten", 700 * seed);
		int depth = (int)(seed == 3 ? DEPTH : seed);
		chain_grow(&chain, depth, 3);
		for (int i = 1; i < depth; i++)
			assert_flat(chain.paths[i], NULL);
		assert_flat(chain.paths[depth], chain.copy);
		/* What comes then is the same, too. */
		struct store *one = open_store(flat, STORE_WRITE), *copy = open_store(chain.copy, STORE_WRITE);
		assert_ok(store_set_working_level(one, -1));
		for (int i = 0; i < 3; i++)
			chain_drive(&chain, one, copy);
		assert_true(content(one) == content(copy));
		verified(one);
		store_close(one);
		store_close(copy);
		chain_free(&chain);
	}
}

static void one_over_a_plain_base_and_one_never_driven_become_flat(void **state)
{
	const char *base = in_folder("base.furrow"), *over = in_folder("over.furrow");
	make_both(base, over);
	assert_flat(over, base);
	/* Ruts that the base gets later are none of an overlay over it alone. */
	struct store *store = open_store(over, STORE_WRITE);
	dig(store, 4, 2);
	store_close(store);
	store = open_store(base, STORE_WRITE);
	dig(store, 9, 3);
	store_close(store);
	assert_flat(over, NULL);
}

static void a_branch_goes_over_to_the_flat_store(void **state)
{
	struct chain chain = chain_make("over", 12);
	chain_grow(&chain, 3, 2);
	struct store *store = open_store(chain.paths[3], STORE_READ);
	uint64_t before = content(store);
	store_close(store);
	assert_flat(chain.paths[2], NULL);
	assert_ok(store_relink(chain.paths[3], flat));
	for (int i = 0; i < 3; i++)
		unlink(chain.paths[i]);
	store = open_store(chain.paths[3], STORE_READ);
	assert_int_equal(store_depth(store), 1);
	assert_true(content(store) == before);
	verified(store);
	store_close(store);
	chain_free(&chain);
}

static enum status stop_late(void *user, int64_t done, int64_t total)
{
	return done >= total - *(const int64_t *)user ? fail_with(STATUS_INTERRUPTED, "flat: interrupted; run it again") : STATUS_OK;
}

static void assert_kept(const char *over, const char *out, bool overwrite, enum status wanted, const char *why)
{
	int before = files_of("");
	assert_status(store_flatten(over, out, overwrite, NULL, NULL), wanted);
	if (strstr(failure_message(), why) == NULL || strstr(failure_message(), "; ") == NULL)
		fail_msg("does not say '%s': %s", why, failure_message());
	assert_int_equal(files_of(""), before);
}

static void what_is_in_the_way_is_kept_and_what_is_damaged_is_refused(void **state)
{
	struct chain chain = chain_make("refused", 21);
	char kept[256];
	size_t sizes[2];
	snprintf(kept, sizeof kept, "%s/kept", folder);
	chain_grow(&chain, 2, 2);
	unlink(flat);
	assert_kept(chain.paths[0], flat, false, STATUS_INPUT, "store of its own");
	assert_kept(in_folder("absent"), flat, false, STATUS_INPUT, "No such file");
	for (int i = 0; i <= 2; i++)
		assert_kept(chain.paths[2], chain.paths[i], true, STATUS_INPUT, "file of the chain");
	assert_kept(chain.paths[2], in_folder("nowhere/flat.furrow"), false, STATUS_INPUT, "No such file");
	/* Another store is replaced only if asked, and then whole. */
	make_store(flat);
	char *bytes[2] = {bytes_of(flat, &sizes[0])};
	assert_kept(chain.paths[2], flat, false, STATUS_INPUT, "--overwrite");
	for (int64_t left = 0; left < 60; left += 29)
		assert_status(store_flatten(chain.paths[2], flat, true, stop_late, &left), STATUS_INTERRUPTED);
	bytes[1] = bytes_of(flat, &sizes[1]);
	assert_int_equal(sizes[0], sizes[1]);
	assert_memory_equal(bytes[0], bytes[1], sizes[0]);
	assert_int_equal(files_of("flat.furrow"), 1);
	free(bytes[0]);
	free(bytes[1]);
	assert_ok(store_flatten(chain.paths[2], flat, true, NULL, NULL));
	/* A row that is damaged, or is another, in a file of the chain. */
	static const char *const edits[] = {
		"UPDATE base SET blob = zeroblob(length(blob)) WHERE key = (SELECT min(key) FROM base)",
		"DELETE FROM base WHERE key = (SELECT max(key) FROM base)",
		"UPDATE base SET (low, high, error, codec, hash, blob) = (SELECT low, high, error, codec, hash, blob FROM base ORDER BY key LIMIT 1) "
		"WHERE key = (SELECT max(key) FROM base)",
		"INSERT INTO base SELECT key + 1048576, low, high, error, codec, revision, hash, blob FROM base LIMIT 1",
	};
	copy_file(chain.paths[0], kept);
	unlink(flat);
	for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
		copy_file(kept, chain.paths[0]);
		raw_sql(chain.paths[0], edits[i]);
		assert_kept(chain.paths[2], flat, false, STATUS_INPUT, "; ");
	}
	/* A row of another store, whole in itself: only the hash of the base tells. */
	copy_file(kept, chain.paths[0]);
	struct store *store = open_store(chain.paths[0], STORE_WRITE);
	int32_t codes[POSTS];
	struct row row;
	bool found;
	struct tile tile = {0, 1, 1};
	assert_ok(store_rows_read(&store->rows, ROW_BASE, tile, codes, &row, &found));
	codes[100]++;
	store_rows_encode(&store->rows, ROW_BASE, codes, &row);
	assert_ok(store_rows_put(&store->rows, ROW_BASE, &row));
	store_close(store);
	assert_kept(chain.paths[2], flat, false, STATUS_INPUT, "base rows are not those");
	copy_file(kept, chain.paths[0]);
	assert_flat(chain.paths[2], chain.copy);
	chain_free(&chain);
}

TEST_PROGRAM(flatten)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_flat_chain_is_the_store_that_had_all_drives),
		cmocka_unit_test(one_over_a_plain_base_and_one_never_driven_become_flat),
		cmocka_unit_test(a_branch_goes_over_to_the_flat_store),
		cmocka_unit_test(what_is_in_the_way_is_kept_and_what_is_damaged_is_refused),
	};
	return cmocka_run_group_tests(tests, enter, folder_remove);
}
