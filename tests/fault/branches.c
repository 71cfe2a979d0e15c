/*
 * Merges, flattened chains and relinks when calls fail: the new file is whole or absent, a store that was to be replaced is whole as it
 * was or as it is to be, an overlay names its old base or the new one, and each failure is told.
 */
#include "epochs.h"

#define MOST 16

static char base[256], sides[2][256], lost[256]; /* lost: side 0, whose base is gone */
static uint64_t merged_hash, side_hash, fresh_hash;

static void drive_side(const char *path, int number)
{
	struct store *store;
	struct store_commit_result result;
	struct field field = field_make(LEVEL);
	for (int i = 1; i <= 2; i++)
		dig(&field, i);
	assert_ok(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &store));
	assert_ok(store_set_working_level(store, LEVEL));
	for (int i = 1; i <= 2 && number == 0; i++)
		assert_ok(field_commit(&field, field_all(&field), store, i, &result));
	if (number > 0)
		assert_ok(field_commit(&field, dig(&field, number), store, number, &result));
	store_close(store);
	field_free(&field);
}

static uint64_t content_of(const char *path)
{
	struct store *store = open_store(path, STORE_READ);
	uint64_t hash = content(store);
	verified(store);
	store_close(store);
	return hash;
}

static int enter(void **state)
{
	struct store_conflicts conflicts;
	if (folder_make(state) != 0)
		return -1;
	snprintf(base, sizeof base, "%s/base.furrow", folder);
	make_store(base);
	copy_file(base, in_folder("fresh"));
	fresh_hash = content_of(base);
	drive_side(base, 0);
	for (int i = 0; i < 2; i++) {
		snprintf(sides[i], sizeof sides[i], "%s/side%d.furrow", folder, i);
		assert_ok(store_create_overlay(sides[i], base));
		drive_side(sides[i], 3 + 2 * i);
	}
	side_hash = content_of(sides[0]);
	assert_ok(store_merge(sides[0], sides[1], in_folder("reference.furrow"), &conflicts));
	merged_hash = content_of(in_folder("reference.furrow"));
	assert_true(merged_hash != side_hash && side_hash != fresh_hash && merged_hash != fresh_hash);
	snprintf(lost, sizeof lost, "%s/lost.furrow", folder);
	copy_file(sides[0], lost);
	raw_sql(lost, "UPDATE meta SET value = 'gone.furrow' WHERE key = 'base_path'");
	return 0;
}

/* Opens what is there as its next writer would. */
static uint64_t found_in(const char *path)
{
	struct store *store;
	struct store_check check;
	uint64_t hash;
	expect(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &store) == STATUS_OK);
	expect(store_verify(store, print_problem, NULL, NULL, &check) == STATUS_OK && check.problems == 0);
	expect(store_content_hash(store, &hash) == STATUS_OK);
	store_close(store);
	return hash;
}

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

static void sweep_all(trial_fn trial)
{
	uint64_t ran = 0;
	for (int kind = FAULT_NONE + 1; kind < FAULT_KINDS; kind++)
		ran += sweep_lasting(trial, NULL, (enum fault_kind)kind, MOST, IN_TURN);
	assert_true(ran > 100);
}

static void a_merge_is_whole_or_absent(void **state)
{
	sweep_all(trial_merge);
}

static void a_flat_store_replaces_another_whole_or_not_at_all(void **state)
{
	sweep_all(trial_flatten);
}

static void an_overlay_names_its_old_base_or_the_new_one(void **state)
{
	sweep_all(trial_relink);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_merge_is_whole_or_absent),
		cmocka_unit_test(a_flat_store_replaces_another_whole_or_not_at_all),
		cmocka_unit_test(an_overlay_names_its_old_base_or_the_new_one),
	};
	fault_install();
	return cmocka_run_group_tests(tests, enter, folder_remove);
}
