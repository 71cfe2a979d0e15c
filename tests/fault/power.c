/*
 * Law 6 when the power is cut: after any operation of an import and of a run of epochs, whatever of
 * the unsynced the disk then holds.
 *
 * Exhaustive over the operations; of what a disk may hold after each, SEEDS are tried: nothing that
 * was not synced, all of it, and some of it in some order. What was found of the same bytes before is not looked for again.
 */
#include "epochs.h"
#include "intake.h"
#include "power_image.h"
#include "../support/chosen.h"
#include "../support/program.h"

/* --- an import --- */

static int resumed; /* imports that went on from tiles that a power cut left */

static uint64_t cut_import(enum before before, uint64_t cut)
{
	char path[256];
	snprintf(path, sizeof path, "%s", in_folder("disk/trial.furrow"));
	folder_empty(in_folder("disk"));
	put_before(path, before);
	name_trial("import", cut, -1);
	power_begin(in_folder("disk"), cut);
	enum status status = import(path);
	uint64_t operations = power_end();
	expect(status == STATUS_OK || operations >= cut);
	expect(status == STATUS_OK || told(status));
	for (uint32_t seed = 0; seed < SEEDS; seed++) {
		const char *found = image("import", "trial.furrow", cut, seed);
		bool there = access(found, F_OK) == 0;
		expect(there || (before == NOTHING && status != STATUS_OK));
		uint64_t bytes = known_bytes(found);
		if (there)
			expect_one_of(found, status == STATUS_OK || before == NOTHING ? hash_after : hash_before[before],
				      hash_after);
		/* Of six disks, which differ from cut to cut, one is imported over anew and one is gone on from. */
		uint64_t turn = (seed + cut) % 6;
		if (turn > 1)
			continue;
		/* What is left of it is not in the next one's way, or is what it goes on from. */
		int64_t tiles = 0;
		int *gone_on = known_of(bytes, turn, UINT64_MAX);
		if (*gone_on >= 0) {
			resumed += *gone_on;
			continue;
		}
		expect(import_from(found, turn == 1 ? &tiles : NULL) == STATUS_OK);
		*gone_on = tiles > 0;
		resumed += *gone_on;
		expect_store(found, hash_after);
		expect(access(beside(found, ".part"), F_OK) != 0 && access(beside(found, "-wal"), F_OK) != 0);
	}
	return operations;
}

static void every_import_cut(enum before before)
{
	uint64_t cut = 1;
	while (cut_import(before, cut) >= cut)
		cut++;
	assert_true(cut > 50 && resumed > 20);
	tell_counts(cut);
}

static void a_power_cut_leaves_no_part_of_an_import(void **state)
{
	chosen_or_skip(0, 5);
	every_import_cut(NOTHING);
}

static void a_power_cut_leaves_the_store_or_the_one_it_was_to_replace(void **state)
{
	chosen_or_skip(1, 5);
	every_import_cut(STORE);
	every_import_cut(KILLED);
}

/* --- epochs --- */

/* Every revision that the store keeps is what it was. */
static void look_back(const char *path, int epochs)
{
	struct store *store;
	int64_t revision;
	uint64_t hash;
	expect(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &store) == STATUS_OK);
	for (int number = epochs - 1; number >= 0; number--) {
		char text[16];
		snprintf(text, sizeof text, "%d", number);
		expect(store_restore(store, text, &revision) == STATUS_OK);
		expect(store_content_hash(store, &hash) == STATUS_OK);
		expect(hash == reference[number]);
	}
	store_close(store);
}

static uint64_t cut_epochs(bool durable_full, bool keep_history, uint64_t cut)
{
	const char *what = keep_history ? "history" : durable_full ? "full" : "normal";
	char path[256];
	snprintf(path, sizeof path, "%s", in_folder("disk/trial.furrow"));
	struct outcome outcome = {0};
	struct store *store;
	folder_empty(in_folder("disk"));
	copy_file(in_folder("fresh"), path);
	name_trial(what, cut, -1);
	power_begin(in_folder("disk"), cut);
	const struct store_options options = {.mode = STORE_WRITE, .durable_full = durable_full, .keep_history = keep_history};
	enum status status = store_open(path, &options, &store);
	expect(status == STATUS_OK || told(status));
	if (status == STATUS_OK) {
		expect(store_set_working_level(store, LEVEL) == STATUS_OK);
		drive(store, true, &outcome);
		store_close(store);
	}
	uint64_t operations = power_end();
	/* Closing is a checkpoint too. */
	if (operations < cut)
		outcome.checkpointed = outcome.acknowledged;
	expect(operations >= cut || outcome.acknowledged == EPOCHS);
	int least = durable_full ? outcome.acknowledged : outcome.checkpointed;
	for (uint32_t seed = 0; seed < SEEDS; seed++) {
		const char *found = image(what, "trial.furrow", cut, seed);
		int most = outcome.acknowledged + outcome.unknown;
		uint64_t bytes = known_bytes(found);
		int *epochs = known_of(bytes, (uint64_t)least, (uint64_t)most);
		bool seen = *epochs >= 0;
		if (!seen)
			*epochs = look(found, least, most);
		if (!seen && keep_history)
			look_back(found, *epochs);
		int *gone_on = seed % 3 == 0 && !keep_history ? known_of(bytes, UINT64_MAX, 0) : NULL;
		if (gone_on != NULL && *gone_on < 0) {
			go_on(found, *epochs);
			*gone_on = 1;
		}
	}
	return operations;
}

static void every_epoch_cut(bool durable_full, bool keep_history)
{
	uint64_t cut = 1;
	while (cut_epochs(durable_full, keep_history, cut) >= cut)
		cut++;
	assert_true(cut > 50);
	tell_counts(cut);
}

static void a_power_cut_leaves_the_last_epoch_that_was_synced(void **state)
{
	chosen_or_skip(2, 5);
	every_epoch_cut(false, false);
}

static void a_power_cut_leaves_the_last_epoch_when_every_commit_is_synced(void **state)
{
	chosen_or_skip(3, 5);
	every_epoch_cut(true, false);
}

static void a_power_cut_leaves_the_history_of_what_it_leaves(void **state)
{
	chosen_or_skip(4, 5);
	every_epoch_cut(false, true);
}

static int enter(void **state)
{
	if (folder_make(state) != 0)
		return -1;
	trial_unopened = true;
	make_reference();
	make_imports();
	return make_disk();
}

static int leave(void **state)
{
	return remove_disk() + folder_remove(state);
}

TEST_PROGRAM(power)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_power_cut_leaves_no_part_of_an_import),
		cmocka_unit_test(a_power_cut_leaves_the_store_or_the_one_it_was_to_replace),
		cmocka_unit_test(a_power_cut_leaves_the_last_epoch_that_was_synced),
		cmocka_unit_test(a_power_cut_leaves_the_last_epoch_when_every_commit_is_synced),
		cmocka_unit_test(a_power_cut_leaves_the_history_of_what_it_leaves),
	};
	power_install();
	return cmocka_run_group_tests(tests, enter, leave);
}
