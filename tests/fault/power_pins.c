/*
 * A store that is branched and driven on, and one that is pruned, when the power is cut after any of their operations, as in power.c. A branch
 * that was made shows what it depends on, on every disk, and goes on doing so when the store is driven again. A prune loses nothing of a branch
 * that is there.
 */
#include "power_image.h"
#include "sides.h"
#include "../support/program.h"

#define NAME "p.furrow"

static char branched[256]; /* driven on, with two branches of which one is gone: copies of it and of its list */
static uint64_t branch_hash;

static void disk_path(char *path, size_t room, const char *in, const char *name)
{
	snprintf(path, room, "%s/%s", in_folder(in), name);
}

/* Commits once more. */
static enum status drive_on(const char *path, int number)
{
	struct store *store = NULL;
	struct store_commit_result result;
	struct field field = field_make(LEVEL);
	enum status status = store_open(path, &(struct store_options){.mode = STORE_WRITE}, &store);
	if (status == STATUS_OK)
		status = store_set_working_level(store, LEVEL);
	dig(&field, number);
	if (status == STATUS_OK)
		status = field_commit(&field, field_all(&field), store, number, &result);
	store_close(store);
	field_free(&field);
	return status;
}

static uint64_t seen(const char *path)
{
	struct store *store;
	uint64_t hash = 0;
	expect(store_open(path, &(struct store_options){.mode = STORE_READ}, &store) == STATUS_OK);
	expect(store_content_hash(store, &hash) == STATUS_OK);
	store_close(store);
	return hash;
}

/* All files of the disk. */
static uint64_t known_disk(void)
{
	static const char *const names[] = {NAME, "q.furrow", NAME PINS_SUFFIX, "r.furrow"};
	uint64_t hash = 0;
	for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
		char path[256];
		disk_path(path, sizeof path, "cut", names[i]);
		uint64_t bytes = known_bytes(path);
		hash = XXH3_64bits_withSeed(&bytes, sizeof bytes, hash);
	}
	return hash;
}

/* --- branched, and driven on --- */

static uint64_t cut_branch(uint64_t cut)
{
	char p[256], q[256];
	bool made = false;
	disk_path(p, sizeof p, "disk", NAME);
	disk_path(q, sizeof q, "disk", "q.furrow");
	folder_empty(in_folder("disk"));
	copy_file(base, p);
	name_trial("branch", cut, -1);
	power_begin(in_folder("disk"), cut);
	enum status status = store_create_overlay(q, p);
	made = status == STATUS_OK;
	if (made)
		status = drive_on(p, 5);
	uint64_t operations = power_end();
	expect(status == STATUS_OK || (operations >= cut && told(status)));
	for (uint32_t seed = 0; seed < SEEDS; seed++) {
		if (!long_run() && (cut + seed) % SEEDS != 0)
			continue; /* of four disks, which differ from cut to cut, one is looked at */
		image("branch", NAME, cut, seed);
		int *known = known_of(known_disk(), made, 0);
		if (*known >= 0)
			continue;
		disk_path(p, sizeof p, "cut", NAME);
		disk_path(q, sizeof q, "cut", "q.furrow");
		bool there = access(q, F_OK) == 0;
		expect(there || !made);
		if (there)
			expect(seen(q) == driven_hash);
		found_in(p);
		expect(drive_on(p, 3) == STATUS_OK && drive_on(p, 7) == STATUS_OK);
		if (there)
			expect(seen(q) == driven_hash);
		found_in(p);
		*known = 1;
	}
	return operations;
}

/* --- pruned --- */

static enum status ignore_pin(void *user, const struct store_pin *pin)
{
	return STATUS_OK;
}

static uint64_t cut_prune(uint64_t cut)
{
	static const char *const names[] = {NAME, NAME PINS_SUFFIX, "q.furrow"};
	char from[300], p[256], q[256];
	folder_empty(in_folder("disk"));
	for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
		snprintf(from, sizeof from, "%s-%s", branched, names[i]);
		disk_path(p, sizeof p, "disk", names[i]);
		copy_file(from, p);
	}
	disk_path(p, sizeof p, "disk", NAME);
	name_trial("prune", cut, -1);
	power_begin(in_folder("disk"), cut);
	enum status status = store_prune(p, ignore_pin, NULL);
	uint64_t operations = power_end();
	expect(status == STATUS_OK || (operations >= cut && told(status)));
	for (uint32_t seed = 0; seed < SEEDS; seed++) {
		if (!long_run() && (cut + seed) % SEEDS != 0)
			continue; /* of four disks, which differ from cut to cut, one is looked at */
		image("prune", NAME, cut, seed);
		int *known = known_of(known_disk(), 2, 0);
		if (*known >= 0)
			continue;
		disk_path(p, sizeof p, "cut", NAME);
		disk_path(q, sizeof q, "cut", "q.furrow");
		expect(seen(q) == branch_hash);
		found_in(p);
		expect(store_prune(p, ignore_pin, NULL) == STATUS_OK);
		expect(drive_on(p, 4) == STATUS_OK && seen(q) == branch_hash);
		*known = 1;
	}
	return operations;
}

static void a_power_cut_leaves_a_branch_what_it_depends_on(void **state)
{
	every_cut(cut_branch, 20);
}

static void a_power_cut_in_a_prune_loses_nothing_of_a_branch_that_is_there(void **state)
{
	every_cut(cut_prune, 10);
}

/* A store with two branches, of two revisions; the younger one is gone. */
static void make_branched(void)
{
	static const char *const names[] = {NAME, NAME PINS_SUFFIX, "q.furrow"};
	char p[256], q[256], to[300], r[256];
	snprintf(branched, sizeof branched, "%s/branched", folder);
	disk_path(p, sizeof p, "disk", NAME);
	disk_path(q, sizeof q, "disk", "q.furrow");
	disk_path(r, sizeof r, "disk", "r.furrow");
	copy_file(base, p);
	assert_ok(store_create_overlay(q, p));
	assert_ok(drive_on(p, 3));
	assert_ok(store_create_overlay(r, p));
	assert_ok(drive_on(p, 5));
	branch_hash = seen(q);
	assert_int_equal(unlink(r), 0);
	for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
		disk_path(p, sizeof p, "disk", names[i]);
		snprintf(to, sizeof to, "%s-%s", branched, names[i]);
		copy_file(p, to);
	}
}

static int enter(void **state)
{
	int failed = make_sides(state);
	failed += make_disk();
	if (failed == 0)
		make_branched();
	trial_unopened = true;
	return failed;
}

static int leave(void **state)
{
	return remove_disk() + folder_remove(state);
}

TEST_PROGRAM(power_pins)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_power_cut_leaves_a_branch_what_it_depends_on),
		cmocka_unit_test(a_power_cut_in_a_prune_loses_nothing_of_a_branch_that_is_there),
	};
	power_install();
	return cmocka_run_group_tests(tests, enter, leave);
}
