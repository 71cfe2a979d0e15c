/*
 * Parts of a run when the power is cut after any operation of their commits, of their gathering and of their removal, as in power.c. A
 * kill is the cut after which the disk holds everything. From whatever is left the run's last common commit is gathered, or was already.
 * It is at least the last one that all parts acknowledged.
 */
#include "lockstep.h"
#include "power_image.h"
#include "../support/program.h"

enum { IMAGES = 4 };

struct ends {
	int least, most; /* commits of the run that may be found */
};

/* As in a run of two processes: each waits until the other has finished the commit before. */
static struct ends drive_parts(const char *in)
{
	struct store *stores[PARTS] = {NULL};
	int acknowledged[PARTS] = {0}, unknown[PARTS] = {0};
	enum status status = STATUS_OK;
	for (int i = 0; i < PARTS && status == STATUS_OK; i++) {
		char path[300];
		snprintf(path, sizeof path, "%s/%s", in, names[i]);
		status = store_open(path, &(struct store_options){.mode = STORE_WRITE}, &stores[i]);
		if (status == STATUS_OK)
			status = store_set_working_level(stores[i], LEVEL);
	}
	for (int number = 1; number <= COMMITS && status == STATUS_OK; number++)
		for (int i = 0; i < PARTS && status == STATUS_OK; i++) {
			status = commit(stores[i], i, number);
			acknowledged[i] += status == STATUS_OK;
			unknown[i] = status != STATUS_OK && strstr(failure_message(), "committing") != NULL;
		}
	expect(status == STATUS_OK || told(status));
	for (int i = 0; i < PARTS; i++)
		store_close(stores[i]);
	struct ends ends = {COMMITS, COMMITS};
	for (int i = 0; i < PARTS; i++) {
		ends.least = acknowledged[i] < ends.least ? acknowledged[i] : ends.least;
		ends.most = acknowledged[i] + unknown[i] < ends.most ? acknowledged[i] + unknown[i] : ends.most;
	}
	return ends;
}

/* --- cuts --- */

static uint64_t bytes_in(const char *in)
{
	char path[300];
	snprintf(path, sizeof path, "%s/over.furrow", in);
	uint64_t hash = known_bytes(path);
	for (int i = 0; i < PARTS; i++) {
		snprintf(path, sizeof path, "%s/%s", in, names[i]);
		const uint64_t both[] = {hash, known_bytes(path)};
		hash = XXH3_64bits(both, sizeof both);
	}
	return hash;
}

static uint64_t cut_commits(uint64_t cut)
{
	char disk[256], left[256];
	snprintf(disk, sizeof disk, "%s/disk", folder);
	snprintf(left, sizeof left, "%s/cut", folder);
	folder_empty(disk);
	copy_all(in_folder("ready"), disk);
	name_trial("commits", cut, -1);
	power_begin(disk, cut);
	struct ends ends = drive_parts(disk);
	uint64_t operations = power_end();
	expect(operations >= cut || ends.least == COMMITS);
	for (uint32_t seed = 0; seed < IMAGES; seed++) {
		int64_t commit;
		image("commits", "over.furrow", cut, seed);
		int *seen = known_of(bytes_in(left), (uint64_t)ends.least, (uint64_t)ends.most);
		if (*seen >= 0)
			continue;
		expect(gather_in(left, &commit) == STATUS_OK);
		*seen = ground_in(left);
		expect(*seen >= ends.least && *seen <= ends.most);
		expect((commit > 0) == (*seen > 0));
		if (seed == 1)
			expect(gather_in(left, &commit) == STATUS_OK && ground_in(left) == *seen);
	}
	return operations;
}

static uint64_t cut_gathering(uint64_t cut)
{
	char disk[256], left[256];
	int64_t commit;
	snprintf(disk, sizeof disk, "%s/disk", folder);
	snprintf(left, sizeof left, "%s/cut", folder);
	folder_empty(disk);
	copy_all(in_folder("driven"), disk);
	name_trial("gathering", cut, -1);
	power_begin(disk, cut);
	enum status status = gather_in(disk, &commit);
	for (int i = 0; i < PARTS && status == STATUS_OK; i++) {
		char path[300];
		snprintf(path, sizeof path, "%s/%s", disk, names[i]);
		unlink(path);
	}
	uint64_t operations = power_end();
	expect(status == STATUS_OK || (operations >= cut && told(status)));
	for (uint32_t seed = 0; seed < IMAGES; seed++) {
		image("gathering", "over.furrow", cut, seed);
		int *seen = known_of(bytes_in(left), status == STATUS_OK, COMMITS + 1);
		if (*seen >= 0)
			continue;
		*seen = ground_in(left);
		/* The last commit of part 0 is not that of the run. */
		expect(*seen == COMMITS - 1 || (*seen == 0 && status != STATUS_OK));
		expect(gather_in(left, &commit) == STATUS_OK && ground_in(left) == COMMITS - 1);
	}
	return operations;
}

static void a_power_cut_leaves_parts_that_can_be_gathered(void **state)
{
	every_cut(cut_commits, 100);
}

static void a_power_cut_leaves_what_was_gathered_or_the_parts(void **state)
{
	every_cut(cut_gathering, 20);
}

static int enter(void **state)
{
	int failed = make_runs(state);
	trial_unopened = true;
	return failed + make_disk();
}

static int leave(void **state)
{
	return remove_disk() + remove_runs(state);
}

TEST_PROGRAM(power_gather)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_power_cut_leaves_parts_that_can_be_gathered),
		cmocka_unit_test(a_power_cut_leaves_what_was_gathered_or_the_parts),
	};
	power_install();
	return cmocka_run_group_tests(tests, enter, leave);
}
