/*
 * Parts of a run and their gathering: whatever tiles go from part to part, and wherever the run ends, the gathered overlay has the rows
 * of one that got the same commits itself.
 */
#include "parts.h"
#include "../support/program.h"

static char base[256];
static const struct relief_spec relief = {.seed = 7, .classes = 1, .waves = {{0.05, 4}}};

static void assert_same_record(const char *path, const char *copy)
{
	struct store *one = open_store(path, STORE_READ), *other = open_store(copy, STORE_READ);
	struct store_run runs[2];
	assert_ok(store_last_run(one, &runs[0]));
	assert_ok(store_last_run(other, &runs[1]));
	assert_string_equal(runs[0].scene_hash, runs[1].scene_hash);
	assert_string_equal(runs[0].state, runs[1].state);
	assert_string_equal(runs[0].what, runs[1].what);
	assert_int_equal(runs[0].step, runs[1].step);
	assert_true(runs[0].time == runs[1].time);
	store_close(one);
	store_close(other);
}

/* Gathers a run. Some parts may be one commit ahead. Afterwards it is as the copy, and gathering it again changes nothing. */
static void gathers_as_the_copy(uint32_t count, uint32_t seed, int ruts, int steps, uint32_t ahead, unsigned carried)
{
	struct run run = run_make(base, count, seed, ruts);
	struct store_commit_result result, again;
	struct store *over = open_store(run.over, STORE_READ);
	int64_t before = over->commit;
	store_close(over);
	run.field.carried = carried;
	run.relief = ruts == 0 ? &relief : NULL;
	run_open(&run);
	for (int i = 0; i < steps; i++)
		run_step(&run, count, true);
	if (ahead > 0)
		run_step(&run, ahead, false);
	for (uint32_t i = 0; i < count; i++)
		verified(run.stores[i]);
	run_close(&run);
	assert_ok(run_gather(&run, count, steps, &result));
	assert_int_equal(result.commit, steps > 0 ? before + 1 : 0);
	uint64_t hash = hash_at(run.over);
	if (hash != hash_at(run.copy))
		fail_msg("%u parts, seed %u, %d ruts, %d steps, %u ahead: not the ground of the same commits in one overlay", count, seed, ruts, steps,
			 ahead);
	if (steps > 0)
		assert_same_record(run.over, run.copy);
	assert_ok(run_gather(&run, count > 1 ? count - 1 : 1, steps, &again));
	assert_int_equal(again.commit, result.commit);
	assert_true(hash_at(run.over) == hash);
	run_free(&run);
}

static void parts_gather_to_what_one_overlay_would_have(void **state)
{
	static const uint32_t counts[] = {1, 2, 3, 8};
	for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
		for (uint32_t seed = 0; seed < 2; seed++)
			gathers_as_the_copy(counts[i], 100 * counts[i] + seed, seed == 0 ? 0 : 3, 4, seed == 1 ? counts[i] / 2 : 0, SEVERAL);
}

static void a_run_that_ends_early_is_gathered(void **state)
{
	for (int steps = 0; steps < 3; steps++)
		for (uint32_t ahead = 0; ahead < 3; ahead++)
			gathers_as_the_copy(3, 7 * (uint32_t)steps + ahead, steps, steps, ahead, SEVERAL);
}

/* Its pages drop the soil's state of an earlier drive, and what tiles beside them share with it. */
static void a_run_without_the_soils_state_drops_what_is_there(void **state)
{
	const unsigned fewer[] = {PLANE_BIT(PLANE_OFFSET), PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DISTURBANCE),
				  SEVERAL & ~PLANE_BIT(PLANE_SHEAR)};
	for (uint32_t i = 0; i < 5; i++)
		gathers_as_the_copy(2 + i % 2, 300 + i, 1 + (int)i % 2, 1 + (int)i % 3, i % 2, fewer[i % 3]);
}

/* --- what is refused --- */

static struct run driven(uint32_t seed, int steps)
{
	struct run run = run_make(base, 3, seed, 1);
	run_open(&run);
	for (int i = 0; i < steps; i++)
		run_step(&run, 3, true);
	run_close(&run);
	return run;
}

/* Nothing is changed, and the message names the file and what to do. */
static void refused(struct run *run, uint32_t count, const char *names, const char *why)
{
	struct store_commit_result result;
	uint64_t before = hash_at(run->over);
	assert_status(run_gather(run, count, run->step, &result), STATUS_INPUT);
	const char *message = failure_message();
	if (strstr(message, names) == NULL || strstr(message, why) == NULL || strstr(message, "; ") == NULL)
		fail_msg("does not name %s or say '%s': %s", names, why, message);
	assert_true(hash_at(run->over) == before);
}

static void damage(const char *path, const char *sql)
{
	static char kept[300];
	snprintf(kept, sizeof kept, "%s.kept", path);
	copy_file(path, kept);
	raw_sql(path, sql);
}

static void mend(const char *path)
{
	char kept[300];
	snprintf(kept, sizeof kept, "%s.kept", path);
	copy_file(kept, path);
	unlink(kept);
}

static void a_damaged_part_is_refused(void **state)
{
	static const struct { const char *sql, *why; } cases[] = {
		{"UPDATE \"offset\" SET hash = hash + 1 WHERE key = (SELECT min(key) FROM \"offset\")", "its hash is wrong"},
		{"UPDATE heaped SET blob = x'00' WHERE key = (SELECT min(key) FROM heaped)", "its hash is wrong"},
		{"UPDATE history SET revision = 99 WHERE plane = 0", "it is damaged"},
		{"UPDATE history SET hash = 1 WHERE plane = 0", "it is damaged"},
		{"UPDATE run SET scene_hash = 'other'", "of another scene"},
		{"UPDATE run SET step = step + 1", "of step"},
		{"UPDATE run SET time = time + 1", "of step"},
		{"UPDATE run SET epoch = epoch + 2", "one commit apart at most"},
		{"UPDATE run SET epoch = epoch - 2", "its history is not its own"},
		{"UPDATE meta SET value = value + 1 WHERE key = 'part_run'", "of another run"},
		{"UPDATE meta SET value = value + 1 WHERE key = 'part_count'", "of another run"},
		{"UPDATE meta SET value = 1 WHERE key = 'part_index'", "each part once"},
		{"UPDATE meta SET value = 3 WHERE key = 'part_index'", "its header is wrong at 'part_index'"},
		{"UPDATE meta SET value = 'x' WHERE key = 'part_run'", "its header is wrong at 'part_run'"},
		{"UPDATE meta SET value = value + 1 WHERE key = 'parent_hash'", "of another run"},
		{"UPDATE meta SET value = value + 1 WHERE key = 'base_hash'", "its header is not that of"},
		{"UPDATE meta SET value = 3.5 WHERE key = 'spacing'", "its header is not that of"},
		{"UPDATE meta SET value = -2 WHERE key = 'working'", "its history is not its own"},
		{"DELETE FROM meta WHERE key = 'part_run'", "not a part"},
		{"DELETE FROM run; DELETE FROM revision", "one commit apart at most"},
	};
	struct run run = driven(40, 3);
	struct store_commit_result result;
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		damage(run.paths[2], cases[i].sql);
		refused(&run, 3, run.paths[2], cases[i].why);
		mend(run.paths[2]);
	}
	damage(run.paths[0], "DELETE FROM revision; UPDATE run SET epoch = epoch + 1");
	refused(&run, 3, run.paths[0], "keeps no revision");
	mend(run.paths[0]);
	assert_ok(run_gather(&run, 3, 3, &result));
	assert_true(hash_at(run.over) == hash_at(run.copy));
	run_free(&run);
}

static void a_part_of_something_else_is_refused(void **state)
{
	struct run run = driven(50, 2);
	struct store_commit_result result;
	char kept[256];
	refused(&run, 2, "part", "is missing");
	/* Two files with one page of the same commit. */
	copy_file(run.paths[1], in_folder("one.kept"));
	copy_file(run.paths[0], run.paths[1]);
	raw_sql(run.paths[1], "UPDATE meta SET value = 1 WHERE key = 'part_index'");
	refused(&run, 3, run.paths[1], "and so has that of");
	/* An overlay that is no part, and a store. */
	snprintf(kept, sizeof kept, "%s", run.paths[1]);
	snprintf(run.paths[1], sizeof run.paths[1], "%s", run.copy);
	refused(&run, 3, run.copy, "not a part");
	snprintf(run.paths[1], sizeof run.paths[1], "%s", base);
	refused(&run, 3, base, "not a part");
	snprintf(run.paths[1], sizeof run.paths[1], "%s", in_folder("none.furrow"));
	refused(&run, 3, "none.furrow", "No such file");
	snprintf(run.paths[1], sizeof run.paths[1], "%s", kept);
	copy_file(in_folder("one.kept"), run.paths[1]);
	/* What they are over was driven since. */
	copy_file(run.over, in_folder("over.kept"));
	struct store *over = open_store(run.over, STORE_WRITE);
	assert_ok(store_set_working_level(over, LEVEL));
	assert_ok(field_commit(&run.field, field_all(&run.field), over, 1, &result));
	store_close(over);
	refused(&run, 3, run.over, "has changed since");
	copy_file(in_folder("over.kept"), run.over);
	/* They can be opened no more when that is gone, and are gathered when it is back. */
	assert_int_equal(rename(run.over, in_folder("over.moved")), 0);
	assert_refused(run.paths[0], "over.furrow");
	assert_int_equal(rename(in_folder("over.moved"), run.over), 0);
	assert_ok(run_gather(&run, 3, 2, &result));
	assert_refused(run.paths[0], "has changed since");
	assert_true(hash_at(run.over) == hash_at(run.copy));
	unlink(in_folder("one.kept"));
	unlink(in_folder("over.kept"));
	run_free(&run);
}

/* A run that was killed while its parts were made, or before each had its first commit, has nothing to gather. */
static void a_run_without_a_common_commit_leaves_nothing(void **state)
{
	struct run run = driven(60, 0);
	struct store_commit_result result = {.commit = 7};
	uint64_t before = hash_at(run.over);
	for (uint32_t count = 0; count <= 3; count++) {
		assert_ok(run_gather(&run, count, 0, &result));
		assert_int_equal(result.commit, 0);
	}
	run_open(&run);
	run_step(&run, 2, false);
	run_close(&run);
	for (uint32_t count = 0; count <= 3; count++) {
		assert_ok(run_gather(&run, count, 0, &result));
		assert_int_equal(result.commit, 0);
	}
	assert_true(hash_at(run.over) == before);
	run_free(&run);
}

static const char *describe_none(void *user, const struct store_run *runs, size_t count, const struct store_commit_result *result)
{
	(void)user;
	(void)runs;
	(void)count;
	(void)result;
	return NULL;
}

static void a_gathering_without_a_record_changes_nothing(void **state)
{
	struct run run = driven(70, 2);
	struct store_commit_result result;
	const char *parts[] = {run.paths[0], run.paths[1], run.paths[2]};
	uint64_t before = hash_at(run.over);
	assert_status(store_gather(run.over, parts, 3, &(struct store_gathering){.describe = describe_none}, &result), STATUS_FAILED);
	assert_true(hash_at(run.over) == before);
	assert_ok(run_gather(&run, 3, 2, &result));
	assert_true(hash_at(run.over) == hash_at(run.copy));
	run_free(&run);
}

/* A gathering is a commit: a revision that has a name can be returned to. */
static void a_gathering_can_be_undone(void **state)
{
	struct run run = run_make(base, 3, 80, 2);
	struct store_commit_result result;
	int64_t revision;
	uint64_t before = hash_at(run.over);
	struct store *over = open_store(run.over, STORE_WRITE);
	assert_ok(store_snapshot(over, "before"));
	store_close(over);
	run_open(&run);
	run_step(&run, 3, true);
	run_step(&run, 3, true);
	run_close(&run);
	assert_ok(run_gather(&run, 3, 2, &result));
	assert_true(hash_at(run.over) == hash_at(run.copy));
	over = open_store(run.over, STORE_WRITE);
	assert_ok(store_restore(over, "before", &revision));
	assert_true(content(over) == before);
	store_close(over);
	run_free(&run);
}

static void a_part_stays_a_part(void **state)
{
	struct run run = driven(90, 1);
	struct store *part = open_store(run.paths[1], STORE_WRITE);
	int64_t revision;
	assert_status(store_mark(part), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "part 1 of"));
	assert_status(store_restore(part, "1", &revision), STATUS_INPUT);
	store_close(part);
	assert_status(store_open(run.paths[1], &(struct store_options){.mode = STORE_WRITE, .keep_history = true}, &part), STATUS_USAGE);
	assert_status(store_create_part(run.paths[1], run.over, &(struct store_part){1, 0, 1}), STATUS_INPUT);
	assert_status(store_create_part(in_folder("new.furrow"), run.over, &(struct store_part){1, 2, 2}), STATUS_USAGE);
	assert_status(store_create_part(in_folder("new.furrow"), run.over, &(struct store_part){1, 0, 0}), STATUS_USAGE);
	run_free(&run);
}

static int enter(void **state)
{
	int failed = folder_make(state);
	snprintf(base, sizeof base, "%s/base.furrow", folder);
	make_store(base);
	return failed;
}

TEST_PROGRAM(gather)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(parts_gather_to_what_one_overlay_would_have),
		cmocka_unit_test(a_run_that_ends_early_is_gathered),
		cmocka_unit_test(a_run_without_the_soils_state_drops_what_is_there),
		cmocka_unit_test(a_damaged_part_is_refused),
		cmocka_unit_test(a_part_of_something_else_is_refused),
		cmocka_unit_test(a_run_without_a_common_commit_leaves_nothing),
		cmocka_unit_test(a_gathering_without_a_record_changes_nothing),
		cmocka_unit_test(a_gathering_can_be_undone),
		cmocka_unit_test(a_part_stays_a_part),
	};
	return cmocka_run_group_tests(tests, enter, folder_remove);
}
