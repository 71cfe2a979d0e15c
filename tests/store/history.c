/*
 * History: a model that remembers the content of every revision says which can be restored, and to what. Commits, rollbacks, snapshots
 * and restores come at random, with and without keep_history, in a plain store and in an overlay over ruts.
 */
#include "marked.h"
#include "../support/program.h"

struct past {
	bool kept, named;
	uint64_t hash;
	struct store_run run;
	char scene_hash[16], state[64];
	int64_t compacted;
	struct field field;
};

struct story {
	struct store *store;
	char path[256];
	struct field field;
	struct past revisions[REVISIONS];
	int64_t present, step, first; /* first: the revision at which the file began */
	int64_t compacted;
	bool each;
	uint32_t seed;
};

static uint32_t any(struct story *story, uint32_t below)
{
	return mix(story->seed++, 11, 111) % below;
}

/* The content as it is now is that of the present revision. */
static void remember(struct story *story)
{
	struct past *past = &story->revisions[story->present];
	assert_true(story->present < REVISIONS);
	past->hash = content(story->store);
	past->compacted = story->compacted;
	if (past->field.offset != NULL)
		field_free(&past->field);
	past->field = field_make(LEVEL);
	field_copy(&past->field, &story->field);
	assert_ok(store_last_run(story->store, &past->run));
	if (past->run.scene_hash == NULL)
		return;
	snprintf(past->scene_hash, sizeof past->scene_hash, "%s", past->run.scene_hash);
	snprintf(past->state, sizeof past->state, "%s", past->run.state);
	past->run.scene_hash = past->scene_hash;
	past->run.state = past->state;
}

static void open_story(struct story *story, bool each)
{
	const struct store_options options = {.mode = STORE_WRITE, .keep_history = each, .scene = "rut.yaml"};
	assert_ok(store_open(story->path, &options, &story->store));
	assert_ok(store_set_working_level(story->store, LEVEL));
	assert_int_equal(story->store->commit, story->present);
	story->each = each;
}

static void commit(struct story *story)
{
	struct store_commit_result result;
	int64_t cx = any(story, 150), cy = any(story, 100), radius = 1 + any(story, 20);
	struct post_rect rect = around(cx, cy, radius);
	if (any(story, 8) == 0) {
		field_clear(&story->field);
		rect = field_all(&story->field);
	} else {
		field_dig(&story->field, cx, cy, radius, any(story, 1000));
	}
	story->revisions[story->present].kept |= story->each;
	assert_ok(field_commit(&story->field, rect, story->store, ++story->step, &result));
	story->present++;
	assert_int_equal(result.commit, story->present);
	if (any(story, 4) == 0) {
		struct store_run run = {.scene_hash = "abd", .step = ++story->step, .time = 0.125, .state = "[1]", .compacted = 7 - any(story, 20)};
		story->revisions[story->present].kept |= story->each;
		remember(story);
		assert_ok(store_commit(story->store, NULL, 0, &run, &result));
		story->compacted += run.compacted;
		story->present++;
	}
	remember(story);
}

static void rollback(struct story *story)
{
	int64_t at = story->present;
	assert_ok(store_mark(story->store));
	for (uint32_t i = any(story, 3); i > 0; i--)
		commit(story);
	if (story->present == at)
		return;
	story->revisions[story->present].kept |= story->each;
	assert_ok(store_rollback(story->store));
	story->present++;
	field_copy(&story->field, &story->revisions[at].field);
	story->compacted = story->revisions[at].compacted;
	assert_true(content(story->store) == story->revisions[at].hash);
	remember(story);
}

static void snapshot(struct story *story)
{
	char name[32];
	snprintf(name, sizeof name, "at-%d", (int)story->present);
	struct past *past = &story->revisions[story->present];
	enum status status = store_snapshot(story->store, name);
	assert_status(status, past->named ? STATUS_INPUT : STATUS_OK);
	past->kept = past->named = true;
	assert_int_equal(story->store->commit, story->present);
	assert_true(content(story->store) == past->hash);
}

static void restore(struct story *story, int64_t to)
{
	char text[32];
	int64_t revision;
	struct past *past = &story->revisions[to];
	snprintf(text, sizeof text, past->named && any(story, 2) == 0 ? "at-%d" : "%d", (int)to);
	enum status status = store_restore(story->store, text, &revision);
	if (!past->kept && to != story->present) {
		assert_status(status, STATUS_INPUT);
		assert_non_null(strstr(failure_message(), "keeps no"));
		return;
	}
	assert_ok(status);
	assert_int_equal(revision, to);
	if (to != story->present) {
		story->revisions[story->present].kept = true;
		story->present++;
	}
	assert_true(content(story->store) == past->hash);
	assert_run(story->store, &past->run);
	if (to != story->present)
		field_copy(&story->field, &past->field);
	story->compacted = past->compacted;
	assert_ok(store_set_working_level(story->store, LEVEL));
	remember(story);
}

struct listed {
	struct story *story;
	int64_t last, count;
};

static enum status check_listed(void *user, const struct store_revision *revision)
{
	struct listed *listed = user;
	struct story *story = listed->story;
	if (strcmp(revision->file, story->path) != 0)
		return STATUS_OK;
	const struct past *past = &story->revisions[revision->revision];
	assert_true(revision->revision < listed->last);
	assert_true(past->kept || revision->present);
	assert_int_equal(revision->present, revision->revision == story->present);
	assert_int_equal(revision->names[0] != '\0', past->named);
	listed->last = revision->revision;
	listed->count++;
	return STATUS_OK;
}

static void check(struct story *story)
{
	struct listed listed = {story, REVISIONS, 0};
	struct store_numbers numbers;
	int64_t kept = 0;
	assert_int_equal(verified(story->store).compacted, story->compacted);
	assert_true(content(story->store) == story->revisions[story->present].hash);
	for (int64_t i = story->first; i <= story->present; i++)
		kept += story->revisions[i].kept;
	assert_ok(store_count(story->store, &numbers));
	assert_int_equal(numbers.revisions, kept);
	assert_ok(store_log(story->store, check_listed, &listed));
	assert_true(listed.count >= kept);
}

static void tell(struct story *story, int events)
{
	for (int i = 0; i < events; i++) {
		uint32_t what = any(story, 12);
		if (what < 5)
			commit(story);
		else if (what < 7)
			rollback(story);
		else if (what < 9)
			snapshot(story);
		else if (what < 11)
			restore(story, story->first + any(story, (uint32_t)(story->present - story->first + 1)));
		else {
			store_close(story->store);
			open_story(story, any(story, 2) == 0);
		}
		check(story);
	}
	for (int64_t i = story->first, last = story->present; i <= last; i++)
		restore(story, i);
	check(story);
	store_close(story->store);
	for (int64_t i = 0; i < REVISIONS; i++)
		if (story->revisions[i].field.offset != NULL)
			field_free(&story->revisions[i].field);
	field_free(&story->field);
}

static void every_kept_revision_comes_back_row_for_row(void **state)
{
	static struct story story;
	for (uint32_t seed = 1; seed <= 3; seed++) {
		story = (struct story){.field = field_make(LEVEL), .seed = 10000 * seed};
		snprintf(story.path, sizeof story.path, "%s", in_folder("story.furrow"));
		make_store(story.path);
		assert_ok(store_open(story.path, &(struct store_options){.mode = STORE_WRITE}, &story.store));
		remember(&story); /* of a store that was never deformed */
		store_close(story.store);
		open_story(&story, seed != 2);
		tell(&story, 40);
	}
}

static void so_it_does_in_an_overlay_over_ruts(void **state)
{
	static struct story story;
	char base[256];
	snprintf(base, sizeof base, "%s", in_folder("under.furrow"));
	for (uint32_t seed = 4; seed <= 5; seed++) {
		story = (struct story){.field = field_make(LEVEL), .seed = 10000 * seed};
		make_store(base);
		snprintf(story.path, sizeof story.path, "%s", base);
		open_story(&story, true);
		commit(&story);
		commit(&story);
		store_close(story.store);
		snprintf(story.path, sizeof story.path, "%s", in_folder("over.furrow"));
		unlink(story.path);
		assert_ok(store_create_overlay(story.path, base));
		for (int64_t i = 0; i < story.present; i++)
			story.revisions[i].kept = false; /* its parent's */
		story.first = story.present;
		open_story(&story, seed == 4);
		remember(&story);
		tell(&story, 30);
	}
}

/* What is kept is told by bytes, and a reset drops it. */
static void history_has_a_price_and_an_end(void **state)
{
	const char *path = in_folder("price.furrow");
	struct store_numbers numbers;
	struct field field = field_make(LEVEL);
	struct store_commit_result result;
	int64_t revision;
	make_store(path);
	struct store *store;
	assert_ok(store_open(path, &(struct store_options){.mode = STORE_WRITE, .keep_history = true}, &store));
	assert_ok(store_set_working_level(store, LEVEL));
	for (int i = 0; i < 12; i++) { /* a rut that grows within few tiles */
		field_dig(&field, 40 + 2 * i, 50, 2, (uint32_t)i);
		assert_ok(field_commit(&field, around(40 + 2 * i, 50, 3), store, i, &result));
	}
	assert_ok(store_count(store, &numbers));
	assert_int_equal(numbers.revisions, 12); /* 0 to 11; 12 is there */
	assert_true(numbers.history_rows > 12 && numbers.history_bytes > 0);
	/* A change costs what was changed, not the tile. */
	assert_true(numbers.history_bytes / numbers.history_rows < POSTS);
	assert_status(store_set_working_level(store, LEVEL + 1), STATUS_INPUT);
	assert_ok(store_restore(store, "0", &revision));
	assert_false(store_has_working_level(store, NULL));
	assert_status(store_set_working_level(store, LEVEL + 1), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "history"));
	assert_ok(store_reset(store, true));
	assert_ok(store_count(store, &numbers));
	assert_int_equal(numbers.revisions + numbers.history_rows + numbers.snapshots, 0);
	assert_ok(store_set_working_level(store, LEVEL + 1));
	store_close(store);
	field_free(&field);
}

static void names_that_are_none_are_refused(void **state)
{
	const char *path = in_folder("names.furrow");
	static const char *const names[] = {"", "12", "a b", "a,b", "-x", "tab\t", "line\n",
					    "0123456789012345678901234567890123456789012345678901234567890123x"};
	make_store(path);
	struct store *store = open_store(path, STORE_WRITE);
	int64_t revision;
	for (size_t i = 0; i < sizeof names / sizeof *names; i++)
		assert_status(store_snapshot(store, names[i]), STATUS_INPUT);
	assert_ok(store_snapshot(store, "as-imported"));
	assert_status(store_snapshot(store, "as-imported"), STATUS_INPUT);
	assert_status(store_restore(store, "nothing", &revision), STATUS_INPUT);
	assert_status(store_restore(store, "7", &revision), STATUS_INPUT);
	assert_status(store_restore(store, "-1", &revision), STATUS_INPUT);
	assert_status(store_restore(store, "99999999999999999999", &revision), STATUS_INPUT);
	verified(store);
	store_close(store);
}

static void damage_in_a_history_is_found(void **state)
{
	static const char *const edits[] = {
		"UPDATE history SET blob = zeroblob(length(blob)) WHERE revision = 2",
		"UPDATE history SET revision = revision + 100",
		"UPDATE history SET form = 2",
		"UPDATE history SET key = key + 65536",
		"UPDATE history SET plane = plane + 1 WHERE plane = 11",
		"DELETE FROM revision WHERE revision = 2",
		"INSERT INTO snapshot VALUES('x', 77, 0, '')",
	};
	const char *path = in_folder("damage.furrow"), *kept = in_folder("kept");
	make_store(path);
	struct store *store;
	assert_ok(store_open(path, &(struct store_options){.mode = STORE_WRITE, .keep_history = true}, &store));
	dig(store, 1, 4);
	verified(store);
	store_close(store);
	copy_file(path, kept);
	for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
		struct store_check check;
		int64_t revision;
		copy_file(kept, path);
		raw_sql(path, edits[i]);
		store = open_store(path, STORE_WRITE);
		assert_ok(store_verify(store, NULL, NULL, NULL, &check));
		assert_true(check.problems > 0);
		enum status status = store_restore(store, "1", &revision);
		assert_true(status == STATUS_OK || status == STATUS_INPUT);
		store_close(store);
	}
}

TEST_PROGRAM(history)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_kept_revision_comes_back_row_for_row),
		cmocka_unit_test(so_it_does_in_an_overlay_over_ruts),
		cmocka_unit_test(history_has_a_price_and_an_end),
		cmocka_unit_test(names_that_are_none_are_refused),
		cmocka_unit_test(damage_in_a_history_is_found),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
