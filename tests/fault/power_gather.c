/*
 * Parts of a run when the power is cut after any operation of their commits, of their gathering and of their removal, as in power.c. A
 * kill is the cut after which the disk holds everything. From whatever is left the run's last common commit is gathered, or was already.
 * It is at least the last one that all parts acknowledged.
 */
#include "power_image.h"
#include "epochs.h"

enum { PARTS = 2, COMMITS = 3, IMAGES = 4 };

static const char *const names[PARTS] = {"part0.furrow", "part1.furrow"};
static uint64_t grounds[COMMITS + 1]; /* of the overlay, by commits of the run */

/* --- a run --- */

static void copy_all(const char *from, const char *to)
{
	static const char *const files[] = {"over.furrow", "part0.furrow", "part1.furrow"};
	for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
		char one[300], other[300];
		snprintf(one, sizeof one, "%s/%s", from, files[i]);
		snprintf(other, sizeof other, "%s/%s", to, files[i]);
		copy_file(one, other);
	}
}

/* Commit `number` of a part, or of all parts together (-1). Tiles go to the other part with each commit; the last is empty in part 1. */
static enum status commit(struct store *store, int part, int number)
{
	static int32_t texels[70][2][POSTS];
	struct store_page pages[70];
	struct store_commit_result result;
	struct field field = field_make(LEVEL);
	size_t count = 0;
	for (int i = 1; i <= number; i++)
		dig(&field, i);
	for (uint32_t y = 1; y < 5; y++)
		for (uint32_t x = 0; x < 5; x++) {
			struct tile tile = {LEVEL, x, y};
			int owner = number == COMMITS ? 0 : (int)(x + y + (uint32_t)number) % PARTS;
			if (part >= 0 && owner != part)
				continue;
			field_tile_plane(&field, tile, PLANE_OFFSET, texels[count][0]);
			field_tile_plane(&field, tile, PLANE_DEPOSITED, texels[count][1]);
			pages[count] = (struct store_page){.tile = tile};
			pages[count].planes[PLANE_OFFSET] = texels[count][0];
			pages[count].planes[PLANE_DEPOSITED] = texels[count][1];
			count++;
		}
	const struct store_run run = {.scene_hash = "abc", .step = number, .time = number, .state = "{}", .compacted = part < 0 ? 5 : 2 + part};
	enum status status = store_commit(store, pages, count, &run, &result);
	field_free(&field);
	return status;
}

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

/* --- its gathering --- */

static const char *describe(void *user, const struct store_run *runs, size_t count, const struct store_commit_result *result)
{
	(void)user;
	(void)result;
	return count == PARTS ? runs[0].state : NULL;
}

/* Gathers those parts in the folder that are there. */
static enum status gather_in(const char *in, int64_t *commit)
{
	char over[300], paths[PARTS][300];
	const char *parts[PARTS];
	size_t count = 0;
	struct store_commit_result result;
	snprintf(over, sizeof over, "%s/over.furrow", in);
	for (int i = 0; i < PARTS; i++) {
		snprintf(paths[i], sizeof paths[i], "%s/%s", in, names[i]);
		if (access(paths[i], F_OK) == 0)
			parts[count++] = paths[i];
	}
	enum status status = store_gather(over, parts, count, &(struct store_gathering){.describe = describe}, &result);
	*commit = result.commit;
	return status;
}

/* Returns of how many commits of the run the overlay is. */
static int ground_in(const char *in)
{
	char path[300];
	struct store *store;
	struct store_check check;
	struct store_run run;
	uint64_t hash;
	snprintf(path, sizeof path, "%s/over.furrow", in);
	expect(store_open(path, &(struct store_options){.mode = STORE_READ}, &store) == STATUS_OK);
	expect(store_verify(store, print_problem, NULL, NULL, &check) == STATUS_OK && check.problems == 0);
	expect(store_content_hash(store, &hash) == STATUS_OK);
	expect(store_last_run(store, &run) == STATUS_OK);
	int commits = 0;
	while (commits < COMMITS && grounds[commits] != hash)
		commits++;
	expect(grounds[commits] == hash);
	expect(commits == 0 || run.step == commits);
	store_close(store);
	return commits;
}

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

static void every_cut(uint64_t (*trial)(uint64_t cut), uint64_t least)
{
	uint64_t cut = 1;
	while (trial(cut) >= cut)
		cut++;
	assert_true(cut > least);
	tell_counts(cut);
}

static void a_power_cut_leaves_parts_that_can_be_gathered(void **state)
{
	every_cut(cut_commits, 100);
}

static void a_power_cut_leaves_what_was_gathered_or_the_parts(void **state)
{
	every_cut(cut_gathering, 20);
}

/* "ready": an overlay and its parts. "driven": the same after the run, part 0 one commit ahead. */
static int enter(void **state)
{
	char base[256], over[256], path[300];
	struct store *store;
	if (folder_make(state) != 0 || mkdir(in_folder("ready"), 0777) != 0 || mkdir(in_folder("driven"), 0777) != 0)
		return -1;
	snprintf(base, sizeof base, "%s/base.furrow", folder);
	snprintf(over, sizeof over, "%s/ready/over.furrow", folder);
	make_store(base);
	assert_ok(store_create_overlay(over, base));
	for (uint32_t i = 0; i < PARTS; i++) {
		snprintf(path, sizeof path, "%s/ready/%s", folder, names[i]);
		assert_ok(store_create_part(path, over, &(struct store_part){12345, i, PARTS}));
	}
	copy_all(in_folder("ready"), in_folder("driven"));
	snprintf(path, sizeof path, "%s/direct.furrow", folder);
	assert_ok(store_create_overlay(path, base));
	store = open_store(path, STORE_WRITE);
	assert_ok(store_set_working_level(store, LEVEL));
	grounds[0] = content(store);
	for (int number = 1; number <= COMMITS; number++) {
		assert_ok(commit(store, -1, number));
		grounds[number] = content(store);
		assert_true(grounds[number] != grounds[number - 1]);
	}
	store_close(store);
	for (int i = 0; i < PARTS; i++) {
		snprintf(path, sizeof path, "%s/driven/%s", folder, names[i]);
		store = open_store(path, STORE_WRITE);
		assert_ok(store_set_working_level(store, LEVEL));
		for (int number = 1; number <= COMMITS - i; number++)
			assert_ok(commit(store, i, number));
		store_close(store);
	}
	trial_unopened = true;
	return make_disk();
}

static int leave(void **state)
{
	folder_empty(in_folder("ready"));
	folder_empty(in_folder("driven"));
	return remove_disk() + rmdir(in_folder("ready")) + rmdir(in_folder("driven")) + folder_remove(state);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_power_cut_leaves_parts_that_can_be_gathered),
		cmocka_unit_test(a_power_cut_leaves_what_was_gathered_or_the_parts),
	};
	power_install();
	return cmocka_run_group_tests(tests, enter, leave);
}
