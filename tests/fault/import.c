/*
 * Law 6 for an import: whatever fails, PATH has what it had before, or the whole store.
 *
 * Exhaustive over every kind of call but SQLite's allocations, of which some hundred are tried
 * (MOST): there are thousands, nearly all in the same few functions.
 */
#include "intake.h"
#include "../support/program.h"

#define MOST 80

/* An import that failed or was done leaves nothing aside, unless the disk refuses to remove it. */
static void expect_nothing_aside(const char *path, const struct fault *fault)
{
	if (fault->kind == FAULT_CALL_UNLINK)
		unlink(beside(path, ".part"));
	expect(access(beside(path, ".part"), F_OK) != 0);
	if (fault->kind == FAULT_CALL_UNLINK)
		unlink(beside(path, "-lock"));
	expect(access(beside(path, "-lock"), F_OK) != 0);
}

/* What an import cannot do without: it is never passed over. */
static bool must_be_told(enum fault_kind kind)
{
	return kind == FAULT_WRITE || kind == FAULT_FULL || kind == FAULT_TORN_WRITE || kind == FAULT_CALL_SYNC ||
	       kind == FAULT_CALL_RENAME;
}

static uint64_t trial(const void *user, const struct fault *fault)
{
	enum before before = *(const enum before *)user;
	const char *path = in_folder("trial.furrow");
	put_before(path, before);
	fault_arm_for(fault);
	enum status status = import(path);
	uint64_t calls = fault_disarm();
	/* Renamed, but the folder was not synced: told, and it may be there after all. */
	bool in_place = status == STATUS_FAILED && strstr(failure_message(), "is in place") != NULL;
	expect(status == STATUS_OK || told(status));
	expect(calls >= fault->nth ? status != STATUS_OK || !must_be_told(fault->kind) : status == STATUS_OK);
	expect_nothing_aside(path, fault);
	if (status == STATUS_OK || in_place)
		expect_store(path, hash_after);
	else if (before == NOTHING)
		expect(access(path, F_OK) != 0);
	else
		expect_store(path, hash_before[before]);
	/* What this one left is not in the next one's way. */
	if (status != STATUS_OK && before == NOTHING && fault->forever) {
		expect(import(path) == STATUS_OK);
		expect_store(path, hash_after);
	}
	return calls;
}

/* Every call over an empty path fails both once and for good; over either store it does the one or the other. */
static void every_call(enum before before)
{
	static const enum lasting lasting[BEFORES] = {[NOTHING] = BOTH, [STORE] = ONE_BY_ONE, [KILLED] = IN_TURN};
	uint64_t ran = 0;
	for (int kind = FAULT_NONE + 1; kind < FAULT_KINDS; kind++)
		ran += sweep_lasting(trial, &before, (enum fault_kind)kind, kind == FAULT_SQLITE_MEMORY ? MOST : UINT64_MAX, lasting[before]);
	assert_true(ran > 100 / SWEEP_PART);
}

static void a_failed_import_leaves_nothing(void **state)
{
	every_call(NOTHING);
}

static void a_failed_import_leaves_the_store_it_was_to_replace(void **state)
{
	every_call(STORE);
}

static void a_failed_import_leaves_the_epochs_of_a_killed_writer(void **state)
{
	every_call(KILLED);
}

/* --- one that goes on --- */

static uint64_t resume_trial(const void *user, const struct fault *fault)
{
	const char *path = in_folder("trial.furrow");
	int64_t tiles = 0;
	put_before(path, NOTHING);
	unlink(beside(path, ".part-journal"));
	copy_file(in_folder("broken.part"), beside(path, ".part"));
	fault_arm_for(fault);
	enum status status = import_from(path, &tiles);
	uint64_t calls = fault_disarm();
	bool in_place = access(path, F_OK) == 0;
	expect(status == STATUS_OK || told(status));
	expect(calls >= fault->nth ? status != STATUS_OK || !must_be_told(fault->kind) : status == STATUS_OK);
	expect(status != STATUS_OK || (in_place && tiles == 20));
	if (fault->kind == FAULT_CALL_UNLINK)
		unlink(beside(path, "-lock"));
	expect(access(beside(path, "-lock"), F_OK) != 0);
	/* What was there is there, and is gone on from. */
	if (!in_place) {
		expect(access(beside(path, ".part"), F_OK) == 0);
		expect(import_from(path, &tiles) == STATUS_OK);
		expect(tiles >= 20);
	}
	expect_store(path, hash_after);
	expect(access(beside(path, ".part"), F_OK) != 0);
	return calls;
}

static void a_failed_import_that_went_on_loses_nothing(void **state)
{
	uint64_t ran = 0;
	assert_ok(import_some(in_folder("broken"), NULL, 20));
	for (int kind = FAULT_NONE + 1; kind < FAULT_KINDS; kind++)
		ran += sweep(resume_trial, NULL, (enum fault_kind)kind, kind == FAULT_SQLITE_MEMORY ? MOST : UINT64_MAX);
	assert_true(ran > 100 / SWEEP_PART);
}

static int enter(void **state)
{
	if (folder_make(state) != 0)
		return -1;
	make_imports();
	return 0;
}

TEST_PROGRAM(import)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_failed_import_leaves_nothing),
		cmocka_unit_test(a_failed_import_leaves_the_store_it_was_to_replace),
		cmocka_unit_test(a_failed_import_leaves_the_epochs_of_a_killed_writer),
		cmocka_unit_test(a_failed_import_that_went_on_loses_nothing),
	};
	fault_install();
	return cmocka_run_group_tests(tests, enter, folder_remove);
}
