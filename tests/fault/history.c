/*
 * Commits that keep what they replace, snapshots, restores and branches when calls fail: the store holds what the last of them that was
 * acknowledged left (or, where a COMMIT failed, the next one), and every revision that it keeps is what it was.
 */
#include "epochs.h"
#include "../support/program.h"

#define MOST 16

/* What is done, and the epochs that the ground then has. */
enum act { EPOCH, SNAPSHOT, RESTORE, REOPEN };
static const struct {
	enum act act;
	const char *text; /* of a snapshot, or what is restored */
	int state;
} acts[] = {
	{EPOCH, NULL, 1}, {EPOCH, NULL, 2}, {SNAPSHOT, "two", 2}, {EPOCH, NULL, 3}, {REOPEN, NULL, 3}, {EPOCH, NULL, 4},
	{RESTORE, "two", 2}, {EPOCH, NULL, 3}, {RESTORE, "0", 0},
};
enum { ACTS = sizeof acts / sizeof *acts, REOPENED = 4 };

static enum status commit(struct store *store, int number)
{
	struct store_commit_result result;
	struct field field = field_make(LEVEL);
	struct post_rect rect = {0};
	for (int i = 1; i <= number; i++)
		rect = dig(&field, i);
	enum status status = field_commit(&field, rect, store, number, &result);
	field_free(&field);
	return status;
}

static enum status open_as(const char *path, int act, struct store **store)
{
	/* Until it is opened again each revision is kept, then only what a snapshot names. */
	const struct store_options options = {.mode = STORE_WRITE, .keep_history = act < REOPENED};
	enum status status = store_open(path, &options, store);
	return status == STATUS_OK ? store_set_working_level(*store, LEVEL) : status;
}

static enum status once(struct store **store, const char *path, int act)
{
	int64_t revision;
	switch (acts[act].act) {
	case EPOCH:
		return commit(*store, acts[act].state);
	case SNAPSHOT:
		return store_snapshot(*store, acts[act].text);
	case RESTORE:
		return store_restore(*store, acts[act].text, &revision);
	default:
		store_close(*store);
		*store = NULL;
		return open_as(path, act, store);
	}
}

/* Once more, as a person would. A snapshot whose COMMIT failed may be there. */
static enum status again(struct store **store, const char *path, int act, bool forever, bool *unknown)
{
	enum status status = once(store, path, act);
	if (status == STATUS_OK)
		return status;
	const char *message = failure_message();
	*unknown = strstr(message, "committing") != NULL || strstr(message, "restoring it") != NULL || strstr(message, "naming") != NULL;
	expect(told(status));
	if (*store == NULL)
		status = open_as(path, act, store);
	else
		status = once(store, path, act);
	if (status == STATUS_INPUT && acts[act].act == SNAPSHOT && *unknown)
		return STATUS_OK;
	expect(status == STATUS_OK || (forever && told(status)));
	return status;
}

static enum status look_at_revision(void *user, const struct store_revision *revision)
{
	int64_t **to = user;
	*(*to)++ = revision->revision;
	return STATUS_OK;
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
	int state = done > 0 ? acts[done - 1].state : 0;
	expect(hash == reference[state] || (unknown && hash == reference[acts[done].state]));
	/* Back, through all that is kept: each is one of the grounds that there were. */
	int64_t revisions[32], *end = revisions;
	expect(store_log(store, look_at_revision, &end) == STATUS_OK);
	for (int64_t *at = revisions; at < end; at++) {
		char text[24];
		int64_t revision;
		bool known = false;
		snprintf(text, sizeof text, "%lld", (long long)*at);
		expect(store_restore(store, text, &revision) == STATUS_OK);
		expect(store_content_hash(store, &hash) == STATUS_OK);
		for (int number = 0; number <= EPOCHS; number++)
			known |= hash == reference[number];
		expect(known && (*at > 3 || hash == reference[*at]));
	}
	store_close(store);
}

static uint64_t trial(const void *user, const struct fault *fault)
{
	char path[256];
	struct store *store = NULL;
	int done = 0;
	bool unknown = false;
	snprintf(path, sizeof path, "%s", in_folder("trial.furrow"));
	remove_store(path);
	copy_file(in_folder("fresh"), path);
	expect(open_as(path, 0, &store) == STATUS_OK);
	fault_arm_for(fault);
	trial_unopened = true; /* it is opened again */
	enum status status = STATUS_OK;
	while (done < ACTS && status == STATUS_OK) {
		status = again(&store, path, done, fault->forever, &unknown);
		if (status == STATUS_OK) {
			done++;
			unknown = false;
		}
	}
	uint64_t calls = fault_disarm();
	expect(calls >= fault->nth || done == ACTS);
	store_close(store);
	look_at(path, done, unknown);
	return calls;
}

static void what_is_kept_is_kept_whatever_fails(void **state)
{
	uint64_t ran = 0;
	for (int kind = FAULT_NONE + 1; kind < FAULT_KINDS; kind++)
		ran += sweep_lasting(trial, NULL, (enum fault_kind)kind, MOST, IN_TURN);
	assert_true(ran > 100 / SWEEP_PART);
}

/* A branch is made whole, or not at all. */
static uint64_t trial_branch(const void *user, const struct fault *fault)
{
	const char *path = in_folder("branch.furrow");
	struct store *store;
	uint64_t hash;
	remove_store(path);
	fault_arm_for(fault);
	trial_unopened = true;
	enum status status = store_create_overlay(path, user);
	uint64_t calls = fault_disarm();
	expect(status == STATUS_OK || told(status));
	expect(calls >= fault->nth || status == STATUS_OK);
	if (access(path, F_OK) != 0) {
		expect(status != STATUS_OK && (files_of("branch.furrow") == 0 || fault->kind == FAULT_CALL_UNLINK));
		return calls;
	}
	expect(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &store) == STATUS_OK);
	expect(store_content_hash(store, &hash) == STATUS_OK && hash == reference[2]);
	store_close(store);
	return calls;
}

static void a_branch_is_made_whole_or_not_at_all(void **state)
{
	char base[256];
	uint64_t ran = 0;
	struct store *store;
	snprintf(base, sizeof base, "%s", in_folder("base.furrow"));
	copy_file(in_folder("fresh"), base);
	assert_ok(open_as(base, 0, &store));
	assert_ok(commit(store, 1));
	assert_ok(commit(store, 2));
	store_close(store);
	for (int kind = FAULT_NONE + 1; kind < FAULT_KINDS; kind++)
		ran += sweep_lasting(trial_branch, base, (enum fault_kind)kind, 6 * MOST, IN_TURN);
	assert_true(ran > 100 / SWEEP_PART);
}

static int enter(void **state)
{
	if (folder_make(state) != 0)
		return -1;
	make_reference();
	return 0;
}

TEST_PROGRAM(history)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_is_kept_is_kept_whatever_fails),
		cmocka_unit_test(a_branch_is_made_whole_or_not_at_all),
	};
	fault_install();
	return cmocka_run_group_tests(tests, enter, folder_remove);
}
