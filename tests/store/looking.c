/*
 * Who only looks changes nothing (law 16): no byte of a file, and no file beside it. That also holds where a killed writer left files beside
 * the store, and where nothing can be written. And what is read is right, whoever writes meanwhile.
 */
#include <errno.h>
#include <grp.h>
#include <sys/wait.h>
#include <xxhash.h>

#include "fixture.h"
#include "../support/program.h"

/* What a killed writer left beside FILE, or what somebody copied of it. */
enum { WAL = 1, SHM = 2, EMPTY = 4 };
static const unsigned lefts[] = {0, EMPTY, WAL, WAL | SHM, EMPTY | SHM};
#define LEFTS (sizeof lefts / sizeof *lefts)

static uint64_t hash_of(const char *path)
{
	static char bytes[1 << 21];
	FILE *file = fopen(path, "rb");
	if (file == NULL)
		return 0;
	const size_t size = fread(bytes, 1, sizeof bytes, file);
	fclose(file);
	return XXH3_64bits(bytes, size) | 1;
}

/* The files of a store. Only who reads a WAL by SQLite's own way uses -shm, which is no content. */
struct files {
	uint64_t file, wal;
	int count;
};

static struct files files_of_store(const char *path)
{
	char wal[300];
	snprintf(wal, sizeof wal, "%s-wal", path);
	return (struct files){hash_of(path), hash_of(wal), files_of(strrchr(path, '/') + 1)};
}

static void assert_same(struct files before, const char *path)
{
	const struct files now = files_of_store(path);
	assert_true(now.file == before.file);
	assert_true(now.wal == before.wal);
	assert_int_equal(now.count, before.count);
}

static void copy_beside(const char *from, const char *to, const char *suffix)
{
	char a[320], b[320];
	snprintf(a, sizeof a, "%s%s", from, suffix);
	snprintf(b, sizeof b, "%s%s", to, suffix);
	copy_file(a, b);
}

/* Makes a store with one commit in its WAL alone, as a killed writer leaves it. Returns whether that commit is there. */
static bool leave(const char *name, unsigned left, char *path, size_t room)
{
	static unsigned number;
	char from[300];
	struct store_commit_result result;
	snprintf(from, sizeof from, "%s", in_folder("writer.furrow"));
	snprintf(path, room, "%s/%s-%u.furrow", folder, name, number++);
	make_store(from);
	struct store *store = open_store(from, STORE_WRITE);
	struct field field = field_make(-1);
	assert_ok(store_set_working_level(store, -1));
	field_dig(&field, 40, 40, 9, 7);
	assert_ok(field_commit(&field, field_all(&field), store, 1, &result));
	copy_file(from, path);
	if (left & WAL)
		copy_beside(from, path, "-wal");
	if (left & SHM)
		copy_beside(from, path, "-shm");
	if (left & EMPTY) {
		char wal[320];
		snprintf(wal, sizeof wal, "%s-wal", path);
		fclose(fopen(wal, "w"));
	}
	field_free(&field);
	store_close(store);
	return left & WAL;
}

/* Reads all there is, and tells whether tile (-1, 2, 2) has a rut. */
static bool has_rut(struct store *store)
{
	int32_t codes[POSTS], offset[POSTS];
	unsigned present;
	struct store_reader *reader;
	struct store_sample sample;
	struct store_check check;
	assert_ok(store_reader_create(store, &reader));
	assert_ok(store_read_base(reader, (struct tile){0, 1, 1}, codes, NULL));
	assert_ok(store_read_deformed(reader, (struct tile){-1, 2, 2}, PLANE_BIT(PLANE_OFFSET), (void *[PLANES]){offset}, &present));
	assert_ok(store_sample(reader, 40, 40, &sample));
	assert_ok(store_verify(store, print_problem, NULL, NULL, &check));
	assert_int_equal(check.problems, 0);
	store_reader_destroy(reader);
	return present != 0;
}

static void looking_leaves_what_a_killed_writer_left(void **state)
{
	char path[256];
	for (size_t i = 0; i < LEFTS; i++) {
		const bool rut = leave("left", lefts[i], path, sizeof path);
		const struct files before = files_of_store(path);
		struct store *store = open_store(path, STORE_READ);
		assert_int_equal(has_rut(store), rut);
		store_close(store);
		assert_same(before, path);
		/* A store that could be written, and was not. */
		assert_ok(store_open(path, &(struct store_options){.mode = STORE_WRITE, .late = true}, &store));
		assert_int_equal(has_rut(store), rut);
		assert_ok(store_mark(store));
		store_close(store);
		assert_same(before, path);
	}
}

/* As another user, if this one may write everywhere. */
static void as_reader(const char *path, bool rut)
{
	const uid_t nobody = 65534;
	struct store *store = NULL;
	if (geteuid() == 0 && (setgroups(0, NULL) != 0 || setgid(nobody) != 0 || setuid(nobody) != 0))
		_exit(3);
	if (access(path, W_OK) == 0 || store_open(path, &(struct store_options){.mode = STORE_READ}, &store) != STATUS_OK) {
		fprintf(stderr, "%s: %s\n", path, failure_message());
		_exit(4);
	}
	const bool right = has_rut(store) == rut;
	store_close(store);
	_exit(right ? 0 : 5);
}

static void what_cannot_be_written_can_be_read(void **state)
{
	char path[256], beside[300];
	int ended;
	for (size_t i = 0; i < LEFTS; i++) {
		const bool rut = leave("closed", lefts[i], path, sizeof path);
		static const char *const suffixes[] = {"", "-wal", "-shm"};
		const struct files before = files_of_store(path);
		for (int k = 0; k < 3; k++) {
			snprintf(beside, sizeof beside, "%s%s", path, suffixes[k]);
			chmod(beside, 0444);
		}
		assert_int_equal(chmod(folder, 0555), 0);
		const pid_t child = fork();
		if (child == 0)
			as_reader(path, rut);
		assert_int_equal(waitpid(child, &ended, 0), child);
		assert_int_equal(chmod(folder, 0755), 0);
		if (ended != 0)
			print_error("left %u: %d\n", lefts[i], ended);
		assert_int_equal(ended, 0);
		assert_same(before, path);
	}
}

/* What was opened before somebody wrote tells what was written, from the next read on. */
static void a_reader_sees_who_begins_to_write(void **state)
{
	char path[256];
	int32_t offset[POSTS];
	unsigned present;
	struct store_commit_result result;
	for (size_t i = 0; i < LEFTS; i++)
		for (int own = 0; own < 2; own++) {
			struct store *looking, *writing;
			struct store_reader *reader;
			struct field field = field_make(-1);
			(void)leave("begins", lefts[i], path, sizeof path);
			const struct store_options late = {.mode = STORE_WRITE, .late = true};
			if (own)
				assert_ok(store_open(path, &late, &looking));
			else
				looking = open_store(path, STORE_READ);
			assert_ok(store_reader_create(looking, &reader));
			assert_ok(store_read_deformed(reader, (struct tile){-1, 0, 0}, PLANE_BIT(PLANE_OFFSET), (void *[PLANES]){offset}, &present));
			assert_int_equal(offset[3 * SIDE + 3], 0);
			if (own)
				writing = looking;
			else
				assert_ok(store_open(path, &late, &writing));
			if (!store_has_working_level(writing, NULL))
				assert_ok(store_set_working_level(writing, -1));
			field_dig(&field, 3, 3, 3, 9);
			assert_ok(field_commit(&field, around(3, 3, 3), writing, 2, &result));
			assert_ok(store_read_deformed(reader, (struct tile){-1, 0, 0}, PLANE_BIT(PLANE_OFFSET), (void *[PLANES]){offset}, &present));
			assert_int_equal(offset[3 * SIDE + 3], field.offset[3 * field.width + 3]);
			if (!own) {
				store_close(writing);
				assert_ok(store_read_deformed(reader, (struct tile){-1, 0, 0}, PLANE_BIT(PLANE_OFFSET), (void *[PLANES]){offset}, &present));
				assert_int_equal(offset[3 * SIDE + 3], field.offset[3 * field.width + 3]);
			}
			store_reader_destroy(reader);
			store_close(looking);
			field_free(&field);
		}
}

/* A store that was opened late is the writer's from then on, and has its bytes until it is begun. An overlay that was made for it goes again. */
static void a_late_store_is_written_when_it_is_begun(void **state)
{
	const char *path = in_folder("late.furrow"), *over = in_folder("late-over.furrow");
	const struct store_options late = {.mode = STORE_WRITE, .late = true};
	struct store *store, *other;
	struct store_commit_result result;
	struct field field = field_make(-1);
	make_store(path);
	const struct files before = files_of_store(path);
	fclose(fopen(in_folder("late.furrow-lock"), "w")); /* a killed writer left it: it locks nothing, and stays */
	const struct files left = files_of_store(path);
	assert_ok(store_open(path, &late, &store));
	store_close(store);
	assert_same(left, path);
	assert_int_equal(unlink(in_folder("late.furrow-lock")), 0);
	assert_ok(store_open(path, &late, &store));
	assert_status(store_open(path, &late, &other), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "this process"));
	store_close(store);
	assert_same(before, path);
	assert_ok(store_open_overlay(over, path, &late, &store));
	store_close(store);
	assert_int_equal(access(over, F_OK), -1);
	assert_status(store_open_overlay(over, path, &(struct store_options){.mode = STORE_READ}, &store), STATUS_INPUT);
	assert_int_equal(access(over, F_OK), -1);
	assert_ok(store_open_overlay(over, path, &late, &store));
	assert_ok(store_set_working_level(store, -1));
	field_dig(&field, 40, 40, 9, 7);
	assert_ok(field_commit(&field, field_all(&field), store, 1, &result));
	store_close(store);
	assert_int_equal(access(over, F_OK), 0);
	assert_same(before, path);
	store = open_store(over, STORE_READ);
	assert_true(has_rut(store));
	store_close(store);
	field_free(&field);
}

TEST_PROGRAM(looking)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(looking_leaves_what_a_killed_writer_left),
		cmocka_unit_test(what_cannot_be_written_can_be_read),
		cmocka_unit_test(a_reader_sees_who_begins_to_write),
		cmocka_unit_test(a_late_store_is_written_when_it_is_begun),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
