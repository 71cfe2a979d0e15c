/* A run of two parts, what it is after each commit, and its gathering. */
#ifndef FURROW_TEST_FAULT_LOCKSTEP_H
#define FURROW_TEST_FAULT_LOCKSTEP_H

#include "epochs.h"

enum { PARTS = 2, COMMITS = 3 };

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

/* "ready": an overlay and its parts. "driven": the same after the run, part 0 one commit ahead. */
static int make_runs(void **state)
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
	return 0;
}

static void remove_file(const char *in, const char *name)
{
	char path[300];
	snprintf(path, sizeof path, "%s/%s", in, name);
	remove_store(path);
}

static int remove_runs(void **state)
{
	const char *const folders[] = {in_folder("ready"), in_folder("driven")};
	for (int i = 0; i < 2; i++) {
		remove_file(folders[i], "over.furrow");
		for (int part = 0; part < PARTS; part++)
			remove_file(folders[i], names[part]);
		if (rmdir(folders[i]) != 0)
			return -1;
	}
	return folder_remove(state);
}

#endif
