/*
 * Overlays that depend on a store go on reading what they depend on, whatever is done to the store: it keeps what it replaces, or what would
 * destroy it is refused.
 */
#include "chain.h"
#include "../support/program.h"

/* Digs somewhere and commits. Another seed is another rut. */
static void drive(const char *path, uint32_t seed, int commits)
{
	struct store *store = open_store(path, STORE_WRITE);
	struct field field = field_make(-1);
	struct store_commit_result result;
	struct store_reader *reader;
	assert_ok(store_set_working_level(store, -1));
	assert_ok(store_reader_create(store, &reader));
	for (uint32_t y = 0; y < extent_tiles_y(&extent, -1); y++)
		for (uint32_t x = 0; x < extent_tiles_x(&extent, -1); x++) {
			static int32_t planes[PLANES][POSTS];
			void *to[PLANES];
			unsigned present;
			for (int plane = 0; plane < PLANES; plane++)
				to[plane] = planes[plane];
			assert_ok(store_read_deformed(reader, (struct tile){-1, x, y}, (1u << PLANES) - 1, to, &present));
			for (int plane = 0; plane < PLANES; plane++)
				for (int64_t row = 0; row < SIDE; row++)
					memcpy((char *)field.planes[plane] + (size_t)((y * 16 + row) * field.width + x * 16) * plane_bytes((enum plane)plane),
					       (char *)to[plane] + (size_t)row * SIDE * plane_bytes((enum plane)plane), SIDE * plane_bytes((enum plane)plane));
		}
	store_reader_destroy(reader);
	for (int i = 0; i < commits; i++) {
		int64_t x = mix(seed, (uint32_t)i, 1) % 140, y = mix(seed, (uint32_t)i, 2) % 90;
		field_dig(&field, x, y, 9, seed + (uint32_t)i);
		assert_ok(field_commit(&field, around(x, y, 9), store, 1 + i, &result));
	}
	store_close(store);
	field_free(&field);
}

static uint64_t seen(const char *path)
{
	struct store *store = open_store(path, STORE_READ);
	struct store_reader *reader;
	uint64_t hash = content(store);
	double before[40 * 30], layered[40 * 30];
	verified(store);
	/* A reader has connections of its own. */
	assert_ok(store_reader_create(store, &reader));
	assert_ok(store_read_posts(reader, STORE_OFFSET, 1, (struct post_rect){0, 0, 38, 26}, before));
	assert_ok(store_read_posts(reader, STORE_OFFSET, -1, (struct post_rect){0, 0, 40, 30}, layered));
	for (int i = 0; i < 38 * 26; i++)
		hash ^= (uint64_t)(int64_t)(before[i] * 1048576) * (2 * (uint64_t)i + 1);
	for (int i = 0; i < 40 * 30; i++)
		hash ^= (uint64_t)(int64_t)(layered[i] * 1048576) * (2 * (uint64_t)i + 3);
	store_reader_destroy(reader);
	store_close(store);
	return hash;
}

static const char *in(const char *name)
{
	static char paths[64][128];
	static int next;
	char *path = paths[next++ % 64];
	snprintf(path, sizeof paths[0], "%s", in_folder(name));
	return path;
}

struct counted {
	int states[4], all;
	int64_t revision;
};

static enum status count_pin(void *user, const struct store_pin *pin)
{
	struct counted *counted = user;
	counted->states[pin->state]++;
	counted->all++;
	counted->revision = pin->revision;
	return STATUS_OK;
}

static struct counted pins_of(const char *path)
{
	struct counted counted = {.all = 0};
	struct store *store = open_store(path, STORE_READ);
	assert_ok(store_each_pin(store, count_pin, &counted));
	store_close(store);
	return counted;
}

static int64_t rows_kept(const char *path)
{
	int64_t rows = 0;
	struct store *store = open_store(path, STORE_READ);
	if (store->version >= STORE_VERSION_PINS)
		assert_ok(store_sql_integer(store->db, path, "SELECT count(*) FROM replaced", &rows));
	store_close(store);
	return rows;
}

static void a_parent_that_is_driven_on_keeps_what_its_branches_stand_on(void **state)
{
	const char *p = in("p.furrow"), *q = in("q.furrow"), *r = in("r.furrow"), *s = in("s.furrow"), *late = in("late.furrow");
	make_store(p);
	drive(p, 1, 3);
	assert_ok(store_create_overlay(q, p));
	assert_ok(store_create_overlay(r, p));
	drive(q, 2, 2);
	assert_ok(store_create_overlay(s, q)); /* a branch of a branch */
	const uint64_t sq = seen(q), sr = seen(r), ss = seen(s);
	drive(p, 3, 4);
	assert_true(seen(q) == sq && seen(r) == sr && seen(s) == ss);
	drive(q, 4, 3);
	drive(p, 5, 2);
	assert_true(seen(s) == ss && seen(r) == sr);
	assert_ok(store_create_overlay(late, p)); /* one at a later revision */
	const uint64_t sl = seen(late), sp = seen(p), sq2 = seen(q);
	drive(p, 6, 3);
	drive(r, 7, 2); /* a branch over a revision that is not the present one is driven itself */
	const uint64_t sr2 = seen(r);
	drive(p, 8, 2);
	assert_true(seen(late) == sl && seen(s) == ss && seen(r) == sr2 && seen(q) == sq2 && seen(p) != sp);
	struct counted counted = pins_of(p);
	assert_int_equal(counted.all, 3);
	assert_int_equal(counted.states[STORE_PIN_THERE], 3);
	assert_int_equal(pins_of(q).all, 1);
	assert_true(rows_kept(p) > 0);
}

static void whatever_changes_a_parent_keeps_it(void **state)
{
	const char *p = in("w.furrow"), *q = in("wq.furrow"), *between = in("wb.furrow");
	int64_t revision;
	struct store *store;
	struct store_commit_result result;
	make_store(p);
	drive(p, 1, 2);
	store = open_store(p, STORE_WRITE);
	assert_ok(store_snapshot(store, "early"));
	store_close(store);
	drive(p, 2, 2);
	assert_ok(store_create_overlay(q, p));
	const uint64_t sq = seen(q);
	store = open_store(p, STORE_WRITE); /* a restore */
	assert_ok(store_restore(store, "early", &revision));
	store_close(store);
	assert_true(seen(q) == sq);
	store = open_store(p, STORE_WRITE); /* a rollback */
	struct field field = field_make(-1);
	assert_ok(store_mark(store));
	field_dig(&field, 40, 40, 30, 77);
	assert_ok(field_commit(&field, field_all(&field), store, 9, &result));
	assert_ok(store_create_overlay(between, p)); /* while it is written; of what is rolled back then */
	const uint64_t sbetween = seen(between);
	assert_ok(store_rollback(store));
	assert_ok(field_commit(&field, field_all(&field), store, 10, &result));
	store_close(store);
	field_free(&field);
	assert_true(seen(q) == sq && seen(between) == sbetween);
	assert_int_equal(unlink(between), 0);
	struct counted counted = {.all = 0};
	assert_ok(store_prune(p, count_pin, &counted));
	assert_true(seen(q) == sq);
	store = open_store(p, STORE_WRITE); /* a reset is refused, and says what would be lost */
	assert_status(store_reset(store, false), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "wq.furrow"));
	assert_non_null(strstr(failure_message(), "1 snapshot"));
	assert_non_null(strstr(failure_message(), "--force"));
	store_close(store);
	assert_true(seen(q) == sq);
	struct store_meta meta = terrain_meta(); /* so is a new store in its place */
	assert_status(store_create(p, &meta, STORE_OVERWRITE, &store), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "wq.furrow"));
	assert_true(seen(q) == sq);
	const char *flat = in("wf.furrow");
	assert_ok(store_flatten(q, flat, STORE_OVERWRITE_NOT, NULL, NULL));
	assert_status(store_flatten(q, p, STORE_OVERWRITE, NULL, NULL), STATUS_INPUT);
	store = open_store(p, STORE_WRITE);
	assert_ok(store_reset(store, true));
	store_close(store);
	assert_status(store_open(q, &(struct store_options){.mode = STORE_READ}, &store), STATUS_INPUT);
	assert_int_equal(access(in("w.furrow-pins"), F_OK), -1);
	assert_int_equal(rows_kept(p), 0);
	drive(p, 3, 4); /* numbers of revisions begin anew: nothing is taken for what it was */
	assert_status(store_open(q, &(struct store_options){.mode = STORE_READ}, &store), STATUS_INPUT);
}

static void an_overlay_that_was_moved_or_copied_is_found_and_one_that_is_gone_is_dropped(void **state)
{
	const char *p = in("m.furrow"), *q = in("mq.furrow"), *r = in("mr.furrow"), *q2 = in("mq2.furrow"), *base = in("mb.furrow");
	make_store(p);
	assert_ok(store_create_overlay(base, p)); /* of the base alone */
	drive(p, 1, 2);
	assert_ok(store_create_overlay(q, p));
	drive(p, 2, 2);
	assert_ok(store_create_overlay(r, p));
	drive(p, 3, 2);
	const uint64_t sq = seen(q), sr = seen(r), sb = seen(base);
	const int64_t kept = rows_kept(p);
	assert_int_equal(rename(q, q2), 0);
	struct counted counted = pins_of(p);
	assert_true(counted.all == 3 && counted.states[STORE_PIN_MOVED] == 1 && counted.states[STORE_PIN_THERE] == 2);
	memset(&counted, 0, sizeof counted);
	assert_ok(store_prune(p, count_pin, &counted));
	assert_int_equal(counted.states[STORE_PIN_MOVED], 1);
	assert_int_equal(pins_of(p).states[STORE_PIN_THERE], 3);
	assert_true(seen(q2) == sq);
	/* Two copies; the first is removed. */
	copy_file(q2, q);
	assert_int_equal(unlink(q2), 0);
	memset(&counted, 0, sizeof counted);
	assert_ok(store_prune(p, count_pin, &counted));
	assert_true(seen(q) == sq && rows_kept(p) == kept);
	/* The older one goes; the younger one needs some of what was kept for both. */
	assert_int_equal(unlink(q), 0);
	memset(&counted, 0, sizeof counted);
	assert_ok(store_prune(p, count_pin, &counted));
	assert_true(counted.states[STORE_PIN_GONE] == 1 && counted.all == 3);
	assert_true(rows_kept(p) < kept && rows_kept(p) > 0);
	drive(p, 4, 3);
	assert_true(seen(r) == sr && seen(base) == sb);
	assert_int_equal(unlink(r), 0);
	assert_ok(store_prune(p, count_pin, &counted));
	assert_int_equal(rows_kept(p), 0);
	assert_true(seen(base) == sb);
	assert_int_equal(access(in("m.furrow-pins"), F_OK), -1); /* no list without a line */
	drive(p, 5, 1);
	assert_int_equal(rows_kept(p), 0);
}

static void the_younger_of_two_goes_and_the_older_still_reads(void **state)
{
	const char *p = in("y.furrow"), *q = in("yq.furrow"), *r = in("yr.furrow");
	struct counted counted = {.all = 0};
	make_store(p);
	drive(p, 1, 2);
	assert_ok(store_create_overlay(q, p));
	drive(p, 2, 1);
	assert_ok(store_create_overlay(r, p));
	const uint64_t sq = seen(q);
	drive(p, 3, 3);
	assert_int_equal(unlink(r), 0);
	assert_ok(store_prune(p, count_pin, &counted));
	assert_true(seen(q) == sq);
	drive(p, 4, 4);
	assert_true(seen(q) == sq);
}

/* Reading never writes: neither the store nor a list. Making an overlay leaves the store as it is. */
static void a_store_that_is_branched_or_read_has_the_same_bytes(void **state)
{
	const char *p = in("b.furrow"), *q = in("bq.furrow"), *kept = in("kept");
	char command[700];
	make_store(p);
	drive(p, 1, 2);
	copy_file(p, kept);
	assert_ok(store_create_overlay(q, p));
	drive(q, 2, 2);
	assert_int_equal(pins_of(p).all, 1);
	snprintf(command, sizeof command, "cmp -s %s %s", p, kept);
	assert_int_equal(system(command), 0);
	drive(p, 3, 2);
	copy_file(p, kept);
	const uint64_t sq = seen(q);
	struct counted counted = {.all = 0};
	assert_ok(store_prune(p, count_pin, &counted)); /* nothing to prune */
	snprintf(command, sizeof command, "cmp -s %s %s", p, kept);
	assert_int_equal(system(command), 0);
	assert_true(seen(q) == sq);
	assert_int_equal(unlink(in("b.furrow-pins")), 0); /* the list is lost: what is kept stays, and prune finds the overlay */
	drive(p, 4, 2);
	assert_true(seen(q) == sq);
	assert_ok(store_prune(p, count_pin, &counted));
	assert_int_equal(pins_of(p).states[STORE_PIN_THERE], 1);
}

/* An overlay that an older Furrow made is in no list. */
static void an_overlay_that_the_list_lacks_is_listed_by_a_drive_of_it_and_by_prune(void **state)
{
	const char *p = in("o.furrow"), *q = in("oq.furrow"), *r = in("or.furrow");
	struct counted counted = {.all = 0};
	make_store(p);
	drive(p, 1, 2);
	assert_ok(store_create_overlay(q, p));
	assert_ok(store_create_overlay(r, p));
	assert_int_equal(unlink(in("o.furrow-pins")), 0);
	assert_int_equal(pins_of(p).states[STORE_PIN_FOUND], 2);
	drive(q, 2, 1);
	assert_true(pins_of(p).states[STORE_PIN_THERE] == 1 && pins_of(p).states[STORE_PIN_FOUND] == 1);
	assert_ok(store_prune(p, count_pin, &counted));
	assert_int_equal(pins_of(p).states[STORE_PIN_THERE], 2);
	const uint64_t sq = seen(q), sr = seen(r);
	drive(p, 3, 2);
	assert_true(seen(q) == sq && seen(r) == sr);
}

static void a_store_with_pins_can_be_moved_merged_and_flattened(void **state)
{
	const char *p = in("x.furrow"), *q = in("xq.furrow"), *r = in("xr.furrow"), *joined = in("xj.furrow"), *flat = in("xf.furrow"),
		   *moved = in("x2.furrow");
	struct store_conflicts conflicts;
	make_store(p);
	drive(p, 1, 2);
	assert_ok(store_create_overlay(q, p));
	drive(q, 20, 1);
	const uint64_t sq = seen(q);
	drive(p, 30, 3);
	assert_ok(store_flatten(q, flat, STORE_OVERWRITE_NOT, NULL, NULL));
	assert_true(seen(flat) == sq);
	/* A copy on another disk is of what the branch depends on, not of what the parent holds now. */
	struct store_staged staged;
	struct store *store;
	bool made;
	assert_ok(store_stage_name(q, folder, &staged));
	assert_ok(store_stage(&staged, NULL, NULL, &made));
	assert_ok(store_open(q, &(struct store_options){.mode = STORE_READ, .staged = &staged}, &store));
	struct store *plain = open_store(flat, STORE_READ);
	assert_true(made && store_copy_path(store) != NULL && content(store) == content(plain));
	store_close(plain);
	store_close(store);
	store_staged_finish(&staged);
	/* Both are merged over what both have: the older revision. */
	assert_ok(store_create_overlay(r, p));
	enum status merged = store_merge(q, r, joined, &conflicts);
	if (merged == STATUS_OK) {
		store = open_store(joined, STORE_READ);
		verified(store);
		store_close(store);
	} else {
		assert_true(conflicts.posts > 0);
	}
	assert_int_equal(rename(p, moved), 0);
	assert_int_equal(rename(in("x.furrow-pins"), in("x2.furrow-pins")), 0);
	assert_ok(store_relink(q, moved));
	assert_true(seen(q) == sq);
	drive(moved, 40, 2);
	assert_true(seen(q) == sq);
}

static void a_list_that_is_none_is_refused(void **state)
{
	const char *p = in("l.furrow"), *q = in("lq.furrow"), *r = in("lr.furrow");
	struct store *store;
	struct counted counted = {.all = 0};
	make_store(p);
	drive(p, 1, 1);
	assert_ok(store_create_overlay(q, p));
	const uint64_t sq = seen(q);
	const char *list = in("l.furrow-pins");
	static const char *const edits[] = {
		"UPDATE pin SET path = 'a' || char(10)",
		"UPDATE pin SET path = ''",
		"UPDATE pin SET revision = -3",
		"CREATE TABLE more(x)",
		"PRAGMA application_id = 5",
	};
	const char *kept = in("lkept");
	copy_file(list, kept);
	for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
		copy_file(kept, list);
		raw_sql(list, edits[i]);
		store = open_store(p, STORE_READ);
		assert_status(store_each_pin(store, count_pin, &counted), STATUS_INPUT);
		assert_non_null(strstr(failure_message(), "l.furrow-pins"));
		store_close(store);
		assert_true(seen(q) == sq);
	}
	copy_file(kept, list);
	raw_sql(list, "UPDATE pin SET hash = hash + 1"); /* one that lies keeps nothing */
	drive(p, 2, 1);
	assert_int_equal(rows_kept(p), 0);
	assert_status(store_open(q, &(struct store_options){.mode = STORE_READ}, &store), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "changed since"));
	assert_int_equal(unlink(list), 0);
	assert_int_equal(symlink(in("elsewhere"), list), 0);
	assert_status(store_create_overlay(r, p), STATUS_INPUT);
	assert_int_equal(access(in("elsewhere"), F_OK), -1);
	assert_int_equal(access(r, F_OK), -1);
	assert_int_equal(unlink(list), 0);
	assert_status(store_create_overlay(in("l\nr.furrow"), p), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "control characters"));
	assert_int_equal(files_of("l\n"), 0);
	assert_int_equal(mkfifo(list, 0600), 0);
	assert_status(store_create_overlay(r, p), STATUS_INPUT);
	assert_int_equal(unlink(list), 0);
}

static void what_is_kept_is_verified(void **state)
{
	const char *p = in("v.furrow"), *q = in("vq.furrow");
	struct store *store;
	struct store_check check;
	make_store(p);
	drive(p, 1, 2);
	assert_ok(store_create_overlay(q, p));
	drive(p, 2, 3);
	store = open_store(q, STORE_READ);
	const uint64_t was = content(store);
	store_close(store);
	store = open_store(p, STORE_READ);
	verified(store);
	store_close(store);
	static const char *const edits[] = {
		"DELETE FROM replaced",
		"UPDATE replaced SET low = low + 1",
		"UPDATE pinned SET compacted = compacted + 1",
		"UPDATE pinned SET hash = hash + 1",
		"UPDATE replaced SET blob = x'00'",
		"UPDATE replaced SET blob = NULL",
		"UPDATE replaced SET codec = 'x'",
		"UPDATE replaced SET codec = 99",
		"UPDATE replaced SET hash = 'x', revision = NULL",
		"UPDATE replaced SET low = 'a', high = x'01'",
		"UPDATE replaced SET key = -key",
		"UPDATE replaced SET plane = plane + 20",
		"DELETE FROM replaced WHERE plane = 4",
		"UPDATE pinned SET working = 99",
		"UPDATE pinned SET working = 'x'",
		"UPDATE pinned SET compacted = 'x'",
		"UPDATE pinned SET relief = x'00'",
		"UPDATE pinned SET relief = '{}'",
		"UPDATE pinned SET revision = 1000",
		"UPDATE pinned SET revision = -5",
	};
	const char *kept = in("vkept");
	copy_file(p, kept);
	for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
		copy_file(kept, p);
		raw_sql(p, edits[i]);
		check.problems = 0;
		enum status status = store_open(p, &(struct store_options){.mode = STORE_READ}, &store);
		if (status == STATUS_OK) {
			assert_ok(store_verify(store, print_problem, NULL, &check, &check));
			store_close(store);
		}
		if (check.problems == 0 && status == STATUS_OK)
			fail_msg("not found: %s", edits[i]);
		/* The branch is as it was, or refused. */
		status = store_open(q, &(struct store_options){.mode = STORE_READ}, &store);
		if (status == STATUS_OK) {
			uint64_t hash = 0;
			status = store_content_hash(store, &hash);
			assert_true(status != STATUS_OK || hash == was);
			store_close(store);
		}
		assert_true(status == STATUS_OK || status == STATUS_INPUT);
	}
}

TEST_PROGRAM(pins)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_parent_that_is_driven_on_keeps_what_its_branches_stand_on),
		cmocka_unit_test(whatever_changes_a_parent_keeps_it),
		cmocka_unit_test(an_overlay_that_was_moved_or_copied_is_found_and_one_that_is_gone_is_dropped),
		cmocka_unit_test(the_younger_of_two_goes_and_the_older_still_reads),
		cmocka_unit_test(a_store_that_is_branched_or_read_has_the_same_bytes),
		cmocka_unit_test(an_overlay_that_the_list_lacks_is_listed_by_a_drive_of_it_and_by_prune),
		cmocka_unit_test(a_store_with_pins_can_be_moved_merged_and_flattened),
		cmocka_unit_test(a_list_that_is_none_is_refused),
		cmocka_unit_test(what_is_kept_is_verified),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
