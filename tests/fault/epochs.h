/* Epochs whose every state is known, driven over a store, and what must be found of them. */
#ifndef FURROW_TEST_FAULT_EPOCHS_H
#define FURROW_TEST_FAULT_EPOCHS_H

#include "sweep.h"

#define LEVEL -1
enum { EPOCHS = 6 };

static uint64_t reference[EPOCHS + 2]; /* by epochs done */

/* What epoch `number` (from 1) changes: posts around the corner of four tiles. Epoch 4 fills what 2
 * and 3 dug, so that rows go. */
static UNUSED struct post_rect dig(struct field *field, int number)
{
	int64_t cx = 16 * (number == 4 ? 2 : number), cy = 16 * (1 + number % 4);
	struct post_rect rect = around(cx, cy, number == 4 ? 40 : 7);
	if (number != 4) {
		field_dig(field, cx, cy, 7, (uint32_t)number);
		return rect;
	}
	field_clear(field);
	return field_all(field);
}

struct outcome {
	int acknowledged;
	int checkpointed; /* of them */
	bool unknown;     /* the COMMIT of the next one failed */
};

static UNUSED enum status one_epoch(struct store *store, struct field *field, int number)
{
	struct store_commit_result result;
	struct post_rect rect = dig(field, number);
	enum status status = field_commit(field, rect, store, number, &result);
	expect(status == STATUS_OK || told(status));
	if (status == STATUS_OK)
		expect(result.commit == number);
	return status;
}

/* Tries what failed once more, as the page cache would be asked to; once is all a fault may cost. */
static UNUSED void drive(struct store *store, bool forever, struct outcome *outcome)
{
	struct field field = field_make(LEVEL);
	for (int number = 1; number <= EPOCHS; number++) {
		struct store_commit_result result;
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
		expect(result.commit == number);
		outcome->unknown = false;
		outcome->acknowledged = number;
		if (number % 2 == 0) {
			status = store_checkpoint(store);
			expect(status == STATUS_OK || told(status));
			if (status == STATUS_OK)
				outcome->checkpointed = number;
		}
	}
	field_free(&field);
}

static UNUSED void remove_store(const char *path)
{
	static const char *const suffixes[] = {"", "-wal", "-shm", "-journal"};
	for (size_t i = 0; i < sizeof suffixes / sizeof *suffixes; i++) {
		char file[300];
		snprintf(file, sizeof file, "%s%s", path, suffixes[i]);
		unlink(file);
	}
}

/* What is there now, checked: from `least` to `most` epochs. Returns how many. */
static UNUSED int look(const char *path, int least, int most)
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
	int epochs = (int)numbers.commits;
	expect(epochs >= least && epochs <= most && epochs <= EPOCHS);
	expect(hash == reference[epochs]);
	expect(epochs == 0 || numbers.last_run.step == epochs);
	store_close(store);
	return epochs;
}

/* The epoch after those that are there. */
static UNUSED void go_on(const char *path, int epochs)
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
	field_free(&field);
}

/* A store that was never deformed, "fresh", and what it is after every epoch. */
static UNUSED void make_reference(void)
{
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
}

#endif
