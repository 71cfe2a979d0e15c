/*
 * The gathering of a run when calls fail: the overlay is as it was or as it is to be, each failure is told, and the same can be done
 * again. A part that cannot be made is absent.
 */
#include "lockstep.h"
#include "../support/program.h"

#define MOST 16

static void make_trial(void)
{
	mkdir(in_folder("trial"), 0777);
	remove_file(in_folder("trial"), "over.furrow");
	copy_all(in_folder("driven"), in_folder("trial"));
}

static uint64_t trial_gather(const void *user, const struct fault *fault)
{
	int64_t commit;
	char in[256];
	snprintf(in, sizeof in, "%s", in_folder("trial"));
	make_trial();
	fault_arm_for(fault);
	trial_unopened = true; /* parts are opened again and again */
	enum status status = gather_in(in, &commit);
	uint64_t calls = fault_disarm();
	expect(status == STATUS_OK || told(status));
	expect(calls >= fault->nth || status == STATUS_OK);
	int found = ground_in(in);
	expect(found == COMMITS - 1 || (found == 0 && status != STATUS_OK));
	expect(gather_in(in, &commit) == STATUS_OK && commit == 1 && ground_in(in) == COMMITS - 1);
	return calls;
}

static uint64_t trial_part(const void *user, const struct fault *fault)
{
	char path[300], over[256];
	struct store *store;
	snprintf(path, sizeof path, "%s/part.furrow", folder);
	snprintf(over, sizeof over, "%s/ready/over.furrow", folder);
	remove_store(path);
	fault_arm_for(fault);
	enum status status = store_create_part(path, over, &(struct store_part){3, 0, 1});
	uint64_t calls = fault_disarm();
	expect(status == STATUS_OK || told(status));
	expect(calls >= fault->nth || status == STATUS_OK);
	expect(access(path, F_OK) == 0 || status != STATUS_OK);
	if (access(path, F_OK) == 0) {
		expect(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &store) == STATUS_OK);
		expect(store_set_working_level(store, LEVEL) == STATUS_OK && commit(store, -1, 1) == STATUS_OK);
		store_close(store);
	} else {
		expect(files_of("part.furrow") == 0 || fault->kind == FAULT_CALL_UNLINK);
	}
	return calls;
}

static void a_run_is_gathered_whole_or_not_at_all(void **state)
{
	sweep_kinds(trial_gather, MOST);
}

static void a_part_is_whole_or_absent(void **state)
{
	sweep_kinds(trial_part, MOST);
}

static int leave(void **state)
{
	remove_file(in_folder("trial"), "over.furrow");
	for (int i = 0; i < PARTS; i++)
		remove_file(in_folder("trial"), names[i]);
	return rmdir(in_folder("trial")) + remove_runs(state);
}

TEST_PROGRAM(gather)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_run_is_gathered_whole_or_not_at_all),
		cmocka_unit_test(a_part_is_whole_or_absent),
	};
	fault_install();
	return cmocka_run_group_tests(tests, make_runs, leave);
}
