/*
 * Laws 1, 4 and 6 for epochs: whatever fails, the store then holds exactly what the last epoch that
 * was acknowledged left (or, where a COMMIT failed, that one), and the next epoch goes through.
 *
 * Exhaustive over every kind of call but memory, SQLite's and ours, of which some hundred are tried
 * (MOST).
 */
#include "sweep.h"

#include <sys/wait.h>

#define MOST 60
#define LEVEL -1
enum { EPOCHS = 6 };

static uint64_t reference[EPOCHS + 2]; /* by epochs done */

/* What epoch `number` (from 1) changes: posts around the corner of four tiles. Epoch 4 fills what 2
 * and 3 dug, so that rows go. */
static struct post_rect dig(struct field *field, int number)
{
	int64_t cx = 16 * (number == 4 ? 2 : number), cy = 16 * (1 + number % 4);
	struct post_rect rect = around(cx, cy, number == 4 ? 40 : 7);
	if (number != 4) {
		field_dig(field, cx, cy, 7, (uint32_t)number);
		return rect;
	}
	size_t posts = (size_t)(field->width * field->height);
	memset(field->offset, 0, posts * sizeof *field->offset);
	memset(field->dirt, 0, posts);
	return field_all(field);
}

struct outcome {
	int acknowledged;
	bool unknown; /* the COMMIT of the next one failed */
};

static enum status one_epoch(struct store *store, struct field *field, int number)
{
	struct store_epoch_result result;
	struct post_rect rect = dig(field, number);
	enum status status = field_commit(field, rect, store, number, &result);
	expect(status == STATUS_OK || told(status));
	if (status == STATUS_OK)
		expect(result.epoch == number);
	return status;
}

/* Tries what failed once more, as the page cache would be asked to; once is all a fault may cost. */
static void drive(struct store *store, bool forever, struct outcome *outcome)
{
	struct field field = field_make(LEVEL);
	for (int number = 1; number <= EPOCHS; number++) {
		struct store_epoch_result result;
		struct post_rect rect = dig(&field, number);
		enum status status = field_commit(&field, rect, store, number, &result);
		if (status != STATUS_OK) {
			outcome->unknown = strstr(failure_message(), "committing") != NULL;
			expect(told(status));
			status = field_commit(&field, rect, store, number, &result);
			expect(status == STATUS_OK || (forever && told(status)));
		}
		if (status != STATUS_OK)
			break;
		expect(result.epoch == number);
		outcome->unknown = false;
		outcome->acknowledged = number;
		if (number % 2 == 0) {
			status = store_checkpoint(store);
			expect(status == STATUS_OK || told(status));
		}
	}
	field_free(&field);
}

struct way {
	bool durable_full, killed;
};

static enum status open_and_drive(const struct way *way, const char *path, bool forever, struct outcome *outcome)
{
	struct store *store;
	struct store_options options = {STORE_WRITE, way->durable_full};
	enum status status = store_open(path, &options, &store);
	if (status != STATUS_OK)
		return status;
	status = store_set_working_level(store, LEVEL);
	assert_int_equal(status, STATUS_OK);
	drive(store, forever, outcome);
	if (!way->killed)
		store_close(store);
	return STATUS_OK;
}

/* What is there now, checked; returns how many epochs. */
static int look(const char *path, const struct outcome *outcome)
{
	struct store *store;
	struct store_check check;
	struct store_numbers numbers;
	uint64_t hash;
	expect(store_open(path, &(struct store_options){.mode = STORE_READ}, &store) == STATUS_OK);
	expect(store_verify(store, print_problem, NULL, NULL, &check) == STATUS_OK);
	expect(check.problems == 0);
	expect(store_count(store, &numbers) == STATUS_OK);
	expect(store_content_hash(store, &hash) == STATUS_OK);
	int epochs = (int)numbers.epochs;
	expect(epochs == outcome->acknowledged || (outcome->unknown && epochs == outcome->acknowledged + 1));
	expect(hash == reference[epochs]);
	expect(epochs == 0 || numbers.last_run.step == epochs);
	store_close(store);
	return epochs;
}

/* The epoch after those that are there. */
static void go_on(const char *path, int epochs)
{
	struct store *store;
	struct field field = field_make(LEVEL);
	uint64_t hash;
	for (int number = 1; number <= epochs; number++)
		dig(&field, number);
	expect(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &store) == STATUS_OK);
	expect(store_set_working_level(store, LEVEL) == STATUS_OK);
	expect(one_epoch(store, &field, epochs + 1) == STATUS_OK);
	expect(store_content_hash(store, &hash) == STATUS_OK);
	expect(hash == reference[epochs + 1]);
	store_close(store);
	expect(files_of("trial.furrow") == 1);
	field_free(&field);
}

/* In a child that is then gone without having closed anything. */
static uint64_t drive_killed(const struct way *way, const char *path, const struct fault *fault,
			     struct outcome *outcome)
{
	int pipes[2];
	struct {
		struct outcome outcome;
		uint64_t calls;
	} report;
	assert_int_equal(pipe(pipes), 0);
	pid_t child = fork();
	if (child == 0) {
		struct outcome mine = {0, false};
		fault_arm_for(fault);
		enum status status = open_and_drive(way, path, fault->forever, &mine);
		expect(status == STATUS_OK || told(status));
		report.outcome = mine;
		report.calls = fault_disarm();
		_exit(write(pipes[1], &report, sizeof report) == sizeof report ? 0 : 1);
	}
	close(pipes[1]);
	fault_now = *fault;
	expect(read(pipes[0], &report, sizeof report) == sizeof report);
	close(pipes[0]);
	int ended;
	expect(waitpid(child, &ended, 0) == child);
	*outcome = report.outcome;
	return report.calls;
}

static uint64_t trial(const void *user, const struct fault *fault)
{
	const struct way *way = user;
	const char *path = in_folder("trial.furrow");
	struct outcome outcome = {0, false};
	uint64_t calls;
	unlink(path);
	copy_file(in_folder("fresh"), path);
	if (way->killed) {
		calls = drive_killed(way, path, fault, &outcome);
	} else {
		fault_arm_for(fault);
		enum status status = open_and_drive(way, path, fault->forever, &outcome);
		calls = fault_disarm();
		expect(status == STATUS_OK || told(status));
	}
	expect(calls >= fault->nth || outcome.acknowledged == EPOCHS);
	go_on(path, look(path, &outcome));
	return calls;
}

static void every_call(struct way way, int first, int last)
{
	uint64_t ran = 0;
	for (int kind = first; kind <= last; kind++)
		ran += sweep(trial, &way, (enum fault_kind)kind, kind >= FAULT_MEMORY ? MOST : UINT64_MAX);
	assert_true(ran > 100);
}

static void a_failed_epoch_leaves_the_one_before(void **state)
{
	every_call((struct way){false, false}, FAULT_NONE + 1, FAULT_KINDS - 1);
}

static void a_failed_epoch_leaves_the_one_before_when_every_commit_is_synced(void **state)
{
	every_call((struct way){true, false}, FAULT_NONE + 1, FAULT_KINDS - 1);
}

static void a_failed_epoch_and_then_a_kill_leave_the_one_before(void **state)
{
	every_call((struct way){false, true}, FAULT_WRITE, FAULT_TRUNCATE);
	every_call((struct way){true, true}, FAULT_WRITE, FAULT_TRUNCATE);
}

static int enter(void **state)
{
	if (folder_make(state) != 0)
		return -1;
	make_store(in_folder("fresh"));
	copy_file(in_folder("fresh"), in_folder("reference"));
	struct store *store = open_store(in_folder("reference"), STORE_WRITE);
	reference[0] = content(store);
	assert_ok(store_set_working_level(store, LEVEL));
	struct field field = field_make(LEVEL);
	for (int number = 1; number <= EPOCHS + 1; number++) {
		assert_ok(one_epoch(store, &field, number));
		reference[number] = content(store);
		for (int other = 0; other < number; other++)
			assert_true(reference[other] != reference[number]);
	}
	field_free(&field);
	verified(store);
	store_close(store);
	return 0;
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_failed_epoch_leaves_the_one_before),
		cmocka_unit_test(a_failed_epoch_leaves_the_one_before_when_every_commit_is_synced),
		cmocka_unit_test(a_failed_epoch_and_then_a_kill_leave_the_one_before),
	};
	fault_install();
	return cmocka_run_group_tests(tests, enter, folder_remove);
}
