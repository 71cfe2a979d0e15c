/*
 * Marks and rollbacks when calls fail: the store holds what the last commit that was acknowledged left, an epoch's or a
 * rollback's (or, where a COMMIT failed, the next one's); and a rollback that is tried once more goes through.
 *
 * SQLite is short of memory throughout, so that also what is kept for the rollback goes through a file.
 */
#include "epochs.h"
#include "../support/program.h"

#define MOST 60

/* Epochs 1 and 2, a mark, epochs 3 and 4, a rollback, epoch 3 again, a rollback: what is there after each commit. */
static const int states[] = {0, 1, 2, 3, 4, 2, 3, 2};
enum { COMMITS = sizeof states / sizeof *states - 1, MARK_AFTER = 2, ROLLBACKS = 1 << 5 | 1 << 7 };

static enum status act(struct store *store, int commit)
{
	struct store_commit_result result;
	struct field field = field_make(LEVEL);
	enum status status;
	if (ROLLBACKS >> commit & 1) {
		status = store_rollback(store);
	} else {
		struct post_rect rect = {0};
		for (int number = 1; number <= states[commit]; number++)
			rect = dig(&field, number);
		status = field_commit(&field, rect, store, states[commit], &result);
	}
	field_free(&field);
	return status;
}

/* Once more, as the page cache would be asked to. */
static enum status act_again(struct store *store, int commit, bool forever, bool *unknown)
{
	enum status status = act(store, commit);
	if (status == STATUS_OK)
		return status;
	*unknown = strstr(failure_message(), "committing") != NULL || strstr(failure_message(), "rolling it back") != NULL;
	expect(told(status));
	status = act(store, commit);
	expect(status == STATUS_OK || (forever && told(status)));
	return status;
}

static enum status mark(struct store *store, bool forever)
{
	enum status status = store_mark(store);
	if (status == STATUS_OK)
		return status;
	expect(told(status));
	status = store_mark(store);
	expect(status == STATUS_OK || (forever && told(status)));
	return status;
}

static void look_at(const char *path, int done, bool unknown)
{
	struct store *store;
	struct store_check check;
	uint64_t hash;
	expect(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &store) == STATUS_OK);
	expect(store_verify(store, print_problem, NULL, NULL, &check) == STATUS_OK);
	expect(check.problems == 0);
	expect(store_content_hash(store, &hash) == STATUS_OK);
	bool next = unknown && done < COMMITS && hash == reference[states[done + 1]];
	expect(next || hash == reference[states[done]]);
	expect(store->commit == done + next);
	struct store_run run;
	expect(store_last_run(store, &run) == STATUS_OK);
	expect(run.step == states[done + next]);
	store_close(store);
}

static uint64_t trial(const void *user, const struct fault *fault)
{
	char path[256];
	struct store *store;
	int done = 0;
	bool unknown = false;
	snprintf(path, sizeof path, "%s", in_folder("trial.furrow"));
	remove_store(path);
	copy_file(in_folder("fresh"), path);
	expect(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &store) == STATUS_OK);
	expect(store_set_working_level(store, LEVEL) == STATUS_OK);
	fault_arm_for(fault);
	enum status status = STATUS_OK;
	while (done < COMMITS && status == STATUS_OK) {
		if (done == MARK_AFTER)
			status = mark(store, fault->forever);
		if (status == STATUS_OK)
			status = act_again(store, done + 1, fault->forever, &unknown);
		if (status == STATUS_OK) {
			done++;
			unknown = false;
		}
	}
	uint64_t calls = fault_disarm();
	expect(calls >= fault->nth || done == COMMITS);
	/* The writer itself goes on. */
	uint64_t hash;
	if (done < COMMITS && store->marked == (done >= MARK_AFTER)) {
		expect(act(store, ++done) == STATUS_OK);
		unknown = false;
	}
	expect(store_content_hash(store, &hash) == STATUS_OK);
	expect(hash == reference[states[done]] || (unknown && hash == reference[states[done + 1]]));
	store_close(store);
	look_at(path, done, unknown);
	return calls;
}

static void a_failed_rollback_leaves_what_was_and_goes_through_again(void **state)
{
	uint64_t ran = 0;
	sqlite3_soft_heap_limit64(1);
	for (int kind = FAULT_NONE + 1; kind < FAULT_KINDS; kind++)
		ran += sweep(trial, NULL, (enum fault_kind)kind, MOST);
	assert_true(ran > 300 / SWEEP_PART);
	sqlite3_soft_heap_limit64(0);
}

static int enter(void **state)
{
	if (folder_make(state) != 0)
		return -1;
	make_reference();
	return 0;
}

TEST_PROGRAM(rollback)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_failed_rollback_leaves_what_was_and_goes_through_again),
	};
	fault_install();
	return cmocka_run_group_tests(tests, enter, folder_remove);
}
