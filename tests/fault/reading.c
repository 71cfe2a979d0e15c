/*
 * Reading a store on a machine that fails: what is read is right, or the machine is told of. It is
 * never the store that is called damaged, unless what was read of it was.
 *
 * Exhaustive over opening, a reader, posts, a check and the hash, but for SQLite's allocations (of
 * 2,500; all of them were tried once).
 */
#include "epochs.h"
#include "../support/program.h"

#define MOST 400

struct seen {
	double values[40 * 40];
	struct store_numbers numbers;
	struct store_check check;
	uint64_t hash;
	bool run_right;
};

static const struct post_rect rect = {10, 10, 50, 50};

static enum status read_reader(struct store *store, struct seen *seen)
{
	struct store_reader *reader;
	enum status status = store_reader_create(store, &reader);
	if (status != STATUS_OK)
		return status;
	status = store_read_posts(reader, STORE_SURFACE, LEVEL, rect, seen->values);
	store_reader_destroy(reader);
	return status;
}

/* Everything that one that only reads can ask. */
static enum status see(const char *path, struct seen *seen)
{
	struct store *store;
	enum status status = store_open(path, &(struct store_options){.mode = STORE_READ}, &store);
	if (status != STATUS_OK)
		return status;
	status = read_reader(store, seen);
	if (status == STATUS_OK)
		status = store_count(store, &seen->numbers);
	if (status == STATUS_OK)
		status = store_verify(store, NULL, NULL, NULL, &seen->check);
	if (status == STATUS_OK)
		status = store_content_hash(store, &seen->hash);
	/* Its texts go with the store. */
	const char *state = seen->numbers.last_run.state;
	seen->run_right = state != NULL && strcmp(state, "{\"poses\":[]}") == 0;
	store_close(store);
	return status;
}

static struct seen right;

static uint64_t trial(const void *user, const struct fault *fault)
{
	static struct seen seen;
	const char *path = user;
	seen = (struct seen){.hash = 0};
	fault_arm_for(fault);
	/* Half of a page that reads as zeros is damage. */
	trial_unopened |= fault->kind == FAULT_SHORT_READ;
	enum status status = see(path, &seen);
	uint64_t calls = fault_disarm();
	expect(status == STATUS_OK || told(status));
	expect(calls >= fault->nth || status == STATUS_OK);
	if (status != STATUS_OK)
		return calls;
	/* What has a hash, and the rest where the disk does not lie. */
	expect(memcmp(seen.values, right.values, sizeof seen.values) == 0);
	expect(seen.hash == right.hash || seen.check.problems > 0);
	if (fault->kind == FAULT_SHORT_READ)
		return calls;
	expect(seen.hash == right.hash && seen.run_right);
	expect(seen.numbers.commits == right.numbers.commits && seen.numbers.plane_tiles[PLANE_OFFSET] == right.numbers.plane_tiles[PLANE_OFFSET]);
	/* A check tells of a page that cannot be read as of one that is wrong. */
	expect(fault->kind == FAULT_READ || seen.check.problems == 0);
	return calls;
}

static void every_call(const char *path, uint64_t most)
{
	static const enum fault_kind kinds[] = {FAULT_READ, FAULT_OPEN, FAULT_ACCESS, FAULT_SIZE, FAULT_LOCK,
						FAULT_SHARED, FAULT_MEMORY, FAULT_SQLITE_MEMORY, FAULT_SHORT_READ};
	uint64_t ran = 0;
	for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
		ran += sweep(trial, path, kinds[i], kinds[i] == FAULT_SQLITE_MEMORY && most > MOST ? MOST : most);
	assert_true(ran > 100 / SWEEP_PART);
}

static void what_is_read_is_right_or_the_machine_is_told_of(void **state)
{
	every_call(in_folder("driven"), UINT64_MAX);
}

/* As a drive's loaders read: beside a writer, from the WAL. */
static void so_it_is_beside_a_writer(void **state)
{
	char path[256];
	snprintf(path, sizeof path, "%s", in_folder("written"));
	copy_file(in_folder("fresh"), path);
	struct store *store = open_store(path, STORE_WRITE);
	struct field field = field_make(LEVEL);
	assert_ok(store_set_working_level(store, LEVEL));
	for (int number = 1; number <= EPOCHS; number++)
		assert_ok(one_epoch(store, &field, number));
	field_free(&field);
	every_call(path, UINT64_MAX);
	store_close(store);
}

/* The same epochs, in a plain store and two overlays over it: one of them is all zeros over what is under it. */
static void so_it_is_through_a_chain(void **state)
{
	char paths[3][256];
	struct field field = field_make(LEVEL);
	for (int i = 0; i < 3; i++) {
		snprintf(paths[i], sizeof paths[i], "%s/chain%d", folder, i);
		if (i == 0)
			copy_file(in_folder("fresh"), paths[0]);
		else
			assert_ok(store_create_overlay(paths[i], paths[i - 1]));
		struct store *store = open_store(paths[i], STORE_WRITE);
		assert_ok(store_set_working_level(store, LEVEL));
		for (int number = i * EPOCHS / 3 + 1; number <= (i + 1) * EPOCHS / 3; number++)
			assert_ok(one_epoch(store, &field, number));
		assert_true(content(store) == reference[(i + 1) * EPOCHS / 3]);
		store_close(store);
	}
	field_free(&field);
	every_call(paths[2], MOST);
}

static int enter(void **state)
{
	if (folder_make(state) != 0)
		return -1;
	make_reference();
	copy_file(in_folder("fresh"), in_folder("driven"));
	struct store *store = open_store(in_folder("driven"), STORE_WRITE);
	struct field field = field_make(LEVEL);
	assert_ok(store_set_working_level(store, LEVEL));
	for (int number = 1; number <= EPOCHS; number++)
		assert_ok(one_epoch(store, &field, number));
	field_free(&field);
	store_close(store);
	assert_ok(see(in_folder("driven"), &right));
	assert_true(right.hash == reference[EPOCHS] && right.check.problems == 0);
	return 0;
}

TEST_PROGRAM(reading)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_is_read_is_right_or_the_machine_is_told_of),
		cmocka_unit_test(so_it_is_beside_a_writer),
		cmocka_unit_test(so_it_is_through_a_chain),
	};
	fault_install();
	return cmocka_run_group_tests(tests, enter, folder_remove);
}
