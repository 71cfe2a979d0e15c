/*
 * Laws 1, 4 and 6 for epochs: whatever fails, the store then holds exactly what the last epoch that
 * was acknowledged left (or, where a COMMIT failed, that one), and the next epoch goes through.
 *
 * Exhaustive over every kind of call but memory, SQLite's and ours, of which some hundred are tried
 * (MOST).
 */
#include "epochs.h"
#include "../support/program.h"

#define MOST 80

struct way {
	bool durable_full, killed;
};

/* What a kill now would leave: the file and its WAL, whose index the next that opens it makes anew. */
static void copy_as_killed(const char *path)
{
	const char *killed = in_folder("killed.furrow");
	remove_store(killed);
	copy_file(path, killed);
	const char *wal = in_folder("trial.furrow-wal");
	if (access(wal, F_OK) == 0)
		copy_file(wal, in_folder("killed.furrow-wal"));
}

static enum status open_and_drive(const struct way *way, const char *path, bool forever, struct outcome *outcome)
{
	struct store *store;
	struct store_options options = {.mode = STORE_WRITE, .durable_full = way->durable_full};
	enum status status = store_open(path, &options, &store);
	if (status != STATUS_OK)
		return status;
	status = store_set_working_level(store, LEVEL);
	assert_int_equal(status, STATUS_OK);
	drive(store, forever, outcome);
	if (way->killed)
		copy_as_killed(path);
	store_close(store);
	return STATUS_OK;
}

static uint64_t trial(const void *user, const struct fault *fault)
{
	const struct way *way = user;
	const char *path = in_folder("trial.furrow");
	struct outcome outcome = {0};
	remove_store(path);
	copy_file(in_folder("fresh"), path);
	fault_arm_for(fault);
	enum status status = open_and_drive(way, path, fault->forever, &outcome);
	uint64_t calls = fault_disarm();
	expect(status == STATUS_OK || told(status));
	expect(calls >= fault->nth || outcome.acknowledged == EPOCHS);
	if (status == STATUS_OK && way->killed)
		path = in_folder("killed.furrow");
	go_on(path, look(path, outcome.acknowledged, outcome.acknowledged + outcome.unknown));
	expect(files_of(strrchr(path, '/') + 1) == 1);
	return calls;
}

static void every_call(struct way way, int first, int last, enum lasting lasting)
{
	uint64_t ran = 0;
	for (int kind = first; kind <= last; kind++)
		ran += sweep_lasting(trial, &way, (enum fault_kind)kind, kind >= FAULT_MEMORY ? MOST : UINT64_MAX, lasting);
	assert_true(ran > 100 / SWEEP_PART);
}

static void a_failed_epoch_leaves_the_one_before(void **state)
{
	every_call((struct way){false, false}, FAULT_NONE + 1, FAULT_KINDS - 1, BOTH);
}

static void a_failed_epoch_leaves_the_one_before_when_every_commit_is_synced(void **state)
{
	every_call((struct way){true, false}, FAULT_NONE + 1, FAULT_KINDS - 1, ONE_BY_ONE);
}

static void a_failed_epoch_and_then_a_kill_leave_the_one_before(void **state)
{
	every_call((struct way){false, true}, FAULT_TORN_WRITE, FAULT_TRUNCATE, ONE_BY_ONE);
	every_call((struct way){true, true}, FAULT_TORN_WRITE, FAULT_TRUNCATE, IN_TURN);
}

static int enter(void **state)
{
	if (folder_make(state) != 0)
		return -1;
	make_reference();
	return 0;
}

TEST_PROGRAM(write_back)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_failed_epoch_leaves_the_one_before),
		cmocka_unit_test(a_failed_epoch_leaves_the_one_before_when_every_commit_is_synced),
		cmocka_unit_test(a_failed_epoch_and_then_a_kill_leave_the_one_before),
	};
	fault_install();
	return cmocka_run_group_tests(tests, enter, folder_remove);
}
