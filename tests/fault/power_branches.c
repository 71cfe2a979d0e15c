/*
 * Merges, flattened chains and relinks when the power is cut after any of their operations, as in power.c; a kill is the cut after which
 * the disk holds everything. The new file is whole or absent, a store that was to be replaced is whole as it was or as it is to be, an
 * overlay names its old base or the new one; and each can be done anew over what is left.
 */
#include "power_image.h"
#include "sides.h"
#include "../support/program.h"

/* Of six disks, which differ from cut to cut, one is gone on from. */
static bool goes_on(uint64_t cut, uint32_t seed)
{
	return (cut + seed) % 6 == 0;
}

/* Does it with the power cut at an operation. Returns the number of operations. *status: what was returned. */
static uint64_t cut_one(const char *what, const char *name, const char *before, uint64_t cut, enum status (*act)(const char *path),
			enum status *status)
{
	char path[256];
	snprintf(path, sizeof path, "%s/%s", in_folder("disk"), name);
	folder_empty(in_folder("disk"));
	if (before != NULL)
		copy_file(before, path);
	name_trial(what, cut, -1);
	power_begin(in_folder("disk"), cut);
	*status = act(path);
	uint64_t operations = power_end();
	expect(*status == STATUS_OK || (operations >= cut && told(*status)));
	return operations;
}

/* --- merge --- */

static enum status merge_at(const char *path)
{
	struct store_conflicts conflicts;
	return store_merge(sides[0], sides[1], path, &conflicts);
}

static uint64_t cut_merge(uint64_t cut)
{
	enum status status;
	uint64_t operations = cut_one("merge", "trial.furrow", NULL, cut, merge_at, &status);
	for (uint32_t seed = 0; seed < SEEDS; seed++) {
		const char *found = image("merge", "trial.furrow", cut, seed);
		bool there = access(found, F_OK) == 0, again = goes_on(cut, seed);
		expect(there || status != STATUS_OK);
		int *seen = known_of(known_bytes(found), again, 0);
		if (*seen >= 0)
			continue;
		if (there)
			expect(found_in(found) == merged_hash);
		else if (again) {
			expect(merge_at(found) == STATUS_OK);
			expect(found_in(found) == merged_hash);
			expect(access(in_folder("cut/trial.furrow.part"), F_OK) != 0);
		}
		*seen = 1;
	}
	return operations;
}

/* --- flatten, over another store --- */

static enum status flatten_at(const char *path)
{
	return store_flatten(sides[0], path, true, NULL, NULL);
}

static uint64_t cut_flatten(uint64_t cut)
{
	enum status status;
	uint64_t operations = cut_one("flatten", "flat.furrow", in_folder("fresh"), cut, flatten_at, &status);
	for (uint32_t seed = 0; seed < SEEDS; seed++) {
		const char *found = image("flatten", "flat.furrow", cut, seed);
		bool again = goes_on(cut, seed);
		int *seen = known_of(known_bytes(found), again, status == STATUS_OK);
		if (*seen >= 0)
			continue;
		uint64_t hash = found_in(found);
		expect(hash == side_hash || (hash == fresh_hash && status != STATUS_OK));
		if (again) {
			expect(flatten_at(found) == STATUS_OK);
			expect(found_in(found) == side_hash);
		}
		*seen = 1;
	}
	return operations;
}

/* --- relink --- */

static enum status relink_at(const char *path)
{
	return store_relink(path, base);
}

static uint64_t cut_relink(uint64_t cut)
{
	enum status status;
	uint64_t operations = cut_one("relink", "found.furrow", lost, cut, relink_at, &status);
	for (uint32_t seed = 0; seed < SEEDS; seed++) {
		struct store *store;
		const char *found = image("relink", "found.furrow", cut, seed);
		int *seen = known_of(known_bytes(found), status == STATUS_OK, 0);
		if (*seen >= 0)
			continue;
		if (store_open(found, &(struct store_options){.mode = STORE_READ}, &store) == STATUS_OK) {
			store_close(store);
		} else {
			expect(status != STATUS_OK && strstr(failure_message(), "gone.furrow") != NULL);
			expect(relink_at(found) == STATUS_OK);
		}
		expect(found_in(found) == side_hash);
		*seen = 1;
	}
	return operations;
}

static void a_power_cut_leaves_a_whole_merge_or_none(void **state)
{
	every_cut(cut_merge, 10);
}

static void a_power_cut_leaves_the_flat_store_or_the_one_it_was_to_replace(void **state)
{
	every_cut(cut_flatten, 10);
}

static void a_power_cut_leaves_an_overlay_with_a_base(void **state)
{
	every_cut(cut_relink, 3);
}

static int enter(void **state)
{
	int failed = make_sides(state);
	trial_unopened = true;
	return failed + make_disk();
}

static int leave(void **state)
{
	return remove_disk() + folder_remove(state);
}

TEST_PROGRAM(power_branches)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_power_cut_leaves_a_whole_merge_or_none),
		cmocka_unit_test(a_power_cut_leaves_the_flat_store_or_the_one_it_was_to_replace),
		cmocka_unit_test(a_power_cut_leaves_an_overlay_with_a_base),
	};
	power_install();
	return cmocka_run_group_tests(tests, enter, leave);
}
