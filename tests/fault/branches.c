/*
 * Merges, flattened chains, relinks and copies of a base when calls fail: the new file is whole or absent, a store that was to be replaced is
 * whole as it was or as it is to be, an overlay names its old base or the new one, and each failure is told.
 */
#include "sides.h"
#include "../support/program.h"

#define MOST 16

static uint64_t trial_merge(const void *user, const struct fault *fault)
{
	struct store_conflicts conflicts;
	char path[256];
	snprintf(path, sizeof path, "%s/trial.furrow", folder);
	remove_store(path);
	fault_arm_for(fault);
	enum status status = store_merge(sides[0], sides[1], path, &conflicts);
	uint64_t calls = fault_disarm();
	expect(status == STATUS_OK || told(status));
	expect(calls >= fault->nth || status == STATUS_OK);
	expect(conflicts.posts == 0);
	if (access(path, F_OK) == 0)
		expect(found_in(path) == merged_hash);
	else
		expect(status != STATUS_OK && (files_of("trial.furrow") == 0 || fault->kind == FAULT_CALL_UNLINK));
	return calls;
}

/* Over another store, which is replaced. */
static uint64_t trial_flatten(const void *user, const struct fault *fault)
{
	char path[256];
	snprintf(path, sizeof path, "%s/flat.furrow", folder);
	remove_store(path);
	copy_file(in_folder("fresh"), path);
	fault_arm_for(fault);
	enum status status = store_flatten(sides[0], path, true, NULL, NULL);
	uint64_t calls = fault_disarm();
	expect(status == STATUS_OK || told(status));
	expect(calls >= fault->nth || status == STATUS_OK);
	uint64_t hash = found_in(path);
	expect(hash == side_hash || (hash == fresh_hash && status != STATUS_OK));
	expect(files_of("flat.furrow") == 1 || fault->kind == FAULT_CALL_UNLINK);
	return calls;
}

static uint64_t trial_relink(const void *user, const struct fault *fault)
{
	char path[256];
	struct store *store;
	snprintf(path, sizeof path, "%s/found.furrow", folder);
	remove_store(path);
	copy_file(lost, path);
	fault_arm_for(fault);
	enum status status = store_relink(path, base);
	uint64_t calls = fault_disarm();
	expect(status == STATUS_OK || told(status));
	expect(calls >= fault->nth || status == STATUS_OK);
	if (status != STATUS_OK && store_open(path, &(struct store_options){.mode = STORE_READ}, &store) != STATUS_OK) {
		expect(strstr(failure_message(), "gone.furrow") != NULL && strstr(failure_message(), "furrow relink") != NULL);
		expect(store_relink(path, base) == STATUS_OK);
	} else if (status != STATUS_OK) {
		store_close(store);
	}
	expect(found_in(path) == side_hash);
	return calls;
}

/* A new copy; and one that is there, which is checked. */
static uint64_t trial_stage(const void *user, const struct fault *fault)
{
	const bool again = user != NULL;
	struct store_staged staged = {.original = NULL};
	bool made = false;
	assert_ok(store_stage_name(sides[0], folder, &staged));
	remove_store(staged.copy);
	if (again)
		assert_ok(store_stage(&staged, NULL, NULL, &made));
	store_staged_finish(&staged);
	made = false;
	fault_arm_for(fault);
	enum status status = store_stage_name(sides[0], folder, &staged);
	if (status == STATUS_OK)
		status = store_stage(&staged, NULL, NULL, &made);
	uint64_t calls = fault_disarm();
	expect(status == STATUS_OK || told(status) || (again && status == STATUS_INPUT));
	expect(calls >= fault->nth || status == STATUS_OK);
	expect(!made || (status == STATUS_OK && !again));
	store_staged_finish(&staged);
	assert_ok(store_stage_name(sides[0], folder, &staged));
	if (access(staged.copy, F_OK) == 0)
		expect(content_of(staged.copy) == driven_hash);
	else
		expect(status != STATUS_OK && !again);
	expect(store_stage(&staged, NULL, NULL, &made) == STATUS_OK && content_of(staged.copy) == driven_hash);
	store_staged_finish(&staged);
	return calls;
}

/* A parent with an overlay is driven on. What the overlay depends on is kept with what replaces it, or nothing is replaced. */
static uint64_t trial_driven_on(const void *user, const struct fault *fault)
{
	char path[256], over[256];
	struct store *store = NULL;
	struct store_commit_result result;
	struct field field = field_make(LEVEL);
	snprintf(path, sizeof path, "%s/on.furrow", folder);
	snprintf(over, sizeof over, "%s/over-on.furrow", folder);
	remove_store(path);
	remove_store(over);
	unlink(in_folder("on.furrow" PINS_SUFFIX));
	copy_file(base, path);
	assert_ok(store_create_overlay(over, path));
	dig(&field, 6);
	fault_arm_for(fault);
	enum status status = store_open(path, &(struct store_options){.mode = STORE_WRITE}, &store);
	if (status == STATUS_OK)
		status = store_set_working_level(store, LEVEL);
	for (int i = 5; i < 7 && status == STATUS_OK; i++)
		status = field_commit(&field, field_all(&field), store, i, &result);
	store_close(store);
	uint64_t calls = fault_disarm();
	field_free(&field);
	expect(status == STATUS_OK || told(status));
	expect(calls >= fault->nth || status == STATUS_OK);
	expect(found_in(over) == driven_hash);
	found_in(path);
	return calls;
}

static void what_an_overlay_depends_on_is_kept_whatever_fails(void **state)
{
	sweep_kinds(trial_driven_on, 2 * MOST);
}

static void a_merge_is_whole_or_absent(void **state)
{
	sweep_kinds(trial_merge, MOST);
}

static void a_flat_store_replaces_another_whole_or_not_at_all(void **state)
{
	sweep_kinds(trial_flatten, MOST);
}

static void an_overlay_names_its_old_base_or_the_new_one(void **state)
{
	sweep_kinds(trial_relink, MOST);
}

static void a_copy_of_the_base_is_whole_or_absent(void **state)
{
	sweep_kinds(trial_stage, MOST);
	uint64_t ran = 0;
	for (int kind = FAULT_NONE + 1; kind < FAULT_KINDS; kind++)
		ran += sweep_lasting(trial_stage, sides, (enum fault_kind)kind, MOST, ONE_BY_ONE);
	assert_true(ran > 30 / SWEEP_PART);
}

TEST_PROGRAM(branches)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_merge_is_whole_or_absent),
		cmocka_unit_test(a_flat_store_replaces_another_whole_or_not_at_all),
		cmocka_unit_test(an_overlay_names_its_old_base_or_the_new_one),
		cmocka_unit_test(a_copy_of_the_base_is_whole_or_absent),
		cmocka_unit_test(what_an_overlay_depends_on_is_kept_whatever_fails),
	};
	fault_install();
	return cmocka_run_group_tests(tests, make_sides, folder_remove);
}
