/* A small import, as tools/intake.c does it, and what may be at PATH when it begins. */
#ifndef FURROW_TEST_FAULT_INTAKE_H
#define FURROW_TEST_FAULT_INTAKE_H

#include <sys/wait.h>

#include "dem/dem.h"
#include "known.h"

enum before { NOTHING, STORE, KILLED, BEFORES };

static uint64_t hash_before[BEFORES], hash_after;

static enum status posts_of(void *user, struct post_rect rect, double *heights)
{
	for (int64_t y = rect.y0; y < rect.y1; y++)
		for (int64_t x = rect.x0; x < rect.x1; x++) {
			int32_t code = terrain(x, y);
			*heights++ = code == HEIGHT_CODE_NODATA ? (double)NAN : code * STEP;
		}
	return STATUS_OK;
}

struct putting {
	struct store *store;
	int64_t passing; /* tiles that are there from before */
	int64_t left;    /* tiles until it is broken off; 0: never */
};

static enum status put_tile(void *user, const struct dem_tile *tile)
{
	struct putting *putting = user;
	struct store_range range = {tile->low, tile->high, tile->error};
	if (putting->passing-- > 0)
		return STATUS_OK;
	enum status status = store_put_base(putting->store, tile->tile, tile->codes, &range);
	return status == STATUS_OK && putting->left > 0 && --putting->left == 0 ? STATUS_INTERRUPTED : status;
}

static enum status known_tile(void *user, struct tile tile, int32_t *codes, bool *known)
{
	struct putting *putting = user;
	return store_get_base(putting->store, tile, codes, NULL, known);
}

/* *resumed: tiles of an import that was broken off and is gone on with; NULL: anew. `left`: tiles until it is
 * broken off as by Ctrl-C; 0: never. */
static enum status import_some(const char *path, int64_t *resumed, int64_t left)
{
	struct putting putting = {NULL, 0, left};
	struct store_meta meta = terrain_meta();
	meta.request = "this one";
	enum status status = resumed != NULL ? store_resume(path, &meta, true, &putting.store, resumed)
					     : store_create(path, &meta, true, &putting.store);
	if (status != STATUS_OK)
		return status;
	putting.passing = resumed != NULL ? *resumed : 0;
	putting.store->commit_bytes = 1000; /* some twenty commits */
	status = dem_cut(&(struct dem_cut){.extent = &extent, .step = meta.step, .posts = posts_of, .emit = put_tile,
					   .emit_user = &putting, .known = resumed != NULL ? known_tile : NULL,
					   .known_user = &putting});
	if (status == STATUS_INTERRUPTED)
		return store_suspend(putting.store);
	if (status == STATUS_OK)
		status = store_publish(putting.store);
	store_close(putting.store);
	return status;
}

static enum status import_from(const char *path, int64_t *resumed)
{
	return import_some(path, resumed, 0);
}

static UNUSED enum status import(const char *path)
{
	return import_from(path, NULL);
}

static UNUSED const char *beside(const char *path, const char *suffix)
{
	static char with[512];
	snprintf(with, sizeof with, "%s%s", path, suffix);
	return with;
}

/* The older store, larger than the new one, and what a killed writer left of it: with a WAL that holds
 * its epochs. */
static UNUSED void make_before(void)
{
	for (int before = STORE; before < BEFORES; before++) {
		const char *path = in_folder(before == STORE ? "store" : "killed");
		make_store(path);
		pid_t child = fork();
		if (child == 0) {
			struct store *store = open_store(path, STORE_WRITE);
			struct field field = field_make(-2);
			struct store_commit_result result;
			assert_ok(store_set_working_level(store, -2));
			field_dig(&field, 100, 90, 80, 5);
			assert_ok(field_commit(&field, field_all(&field), store, 1, &result));
			/* A part of it is in the file: without the rest of the WAL that is no store. */
			assert_ok(store_checkpoint(store));
			field_dig(&field, 150, 80, 60, 6);
			assert_ok(field_commit(&field, field_all(&field), store, 2, &result));
			if (before == STORE)
				store_close(store);
			_exit(0);
		}
		int ended;
		assert_int_equal(waitpid(child, &ended, 0), child);
		assert_int_equal(WEXITSTATUS(ended), 0);
		unlink(beside(path, "-shm"));
		unlink(beside(path, "-lock"));
		/* Of a copy: looking at it would tidy it. */
		copy_file(path, in_folder("looked"));
		if (before == KILLED)
			copy_file(beside(path, "-wal"), in_folder("looked-wal"));
		struct store *store = open_store(in_folder("looked"), STORE_READ);
		hash_before[before] = content(store);
		store_close(store);
	}
	assert_true(hash_before[STORE] == hash_before[KILLED]);
}

static UNUSED void put_before(const char *path, enum before before)
{
	unlink(path);
	unlink(beside(path, "-wal"));
	if (before != NOTHING)
		copy_file(in_folder(before == STORE ? "store" : "killed"), path);
	if (before == KILLED)
		copy_file(in_folder("killed-wal"), beside(path, "-wal"));
}

/* It verifies and is the one or the other; the same bytes are looked at once. */
static UNUSED void expect_one_of(const char *path, uint64_t one, uint64_t other)
{
	int *looked = known_of(known_bytes(path), one, other);
	if (*looked >= 0)
		return;
	struct store *store;
	struct store_check check;
	uint64_t found;
	expect(store_open(path, &(struct store_options){.mode = STORE_READ}, &store) == STATUS_OK);
	expect(store_verify(store, print_problem, NULL, NULL, &check) == STATUS_OK);
	expect(check.problems == 0);
	expect(store_content_hash(store, &found) == STATUS_OK);
	expect(found == one || found == other);
	store_close(store);
	*looked = 1;
}

static UNUSED void expect_store(const char *path, uint64_t hash)
{
	expect_one_of(path, hash, hash);
}

/* What an import is to make, and the stores before it. */
static UNUSED void make_imports(void)
{
	make_before();
	assert_ok(import(in_folder("whole.furrow")));
	struct store *store = open_store(in_folder("whole.furrow"), STORE_READ);
	hash_after = content(store);
	store_close(store);
}

#endif
