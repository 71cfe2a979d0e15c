/* Exports on a machine that fails: each failure is told, nothing half-made is left in place, and the next run completes the same files. */
#include <sys/stat.h>

#include "exchange/exchange.h"
#include "support.h"
#include "../support/program.h"

static double hills(int64_t x, int64_t y)
{
	return 40 + 6 * sin((double)x / 9) * cos((double)y / 11) + (double)x / 16;
}

static struct store *small_store(void)
{
	struct store *store;
	support_store(support_path("small.furrow"), (struct extent){33, 33, 1, 16}, hills);
	must(store_open(support_path("small.furrow"), &(struct store_options){.mode = STORE_READ}, &store));
	return store;
}

static void leaflet(void)
{
	(void)mkdir(support_path("leaflet"), 0777);
	support_write(support_path("leaflet/leaflet.js"), "L = 0;\n");
	support_write(support_path("leaflet/leaflet.css"), "a {}\n");
}

static struct exchange_tiles_params tiles_params(struct store *store, const char *directory)
{
	static char path[128], beside[128]; /* support_path uses its texts again */
	snprintf(path, sizeof path, "%s", support_path(directory));
	snprintf(beside, sizeof beside, "%s", support_path("leaflet"));
	struct exchange_tiles_params params = {
		.store = store, .directory = path, .title = "small", .since = -1, .exaggerate = 1, .jobs = 1, .leaflet = beside,
	};
	chart_sun_of(CHART_AZIMUTH, CHART_ALTITUDE, &params.sun);
	return params;
}

/* Runs a command of the shell in the test's folder. */
static bool shell(const char *command)
{
	char text[512];
	snprintf(text, sizeof text, "cd '%s' && %s", support_folder, command);
	return system(text) == 0;
}

static bool told(enum status status)
{
	const char *message = failure_message();
	return status != STATUS_OK && strchr(message, ':') != NULL && strchr(message, ';') != NULL;
}

/* Each run fails one allocation later than the run before, and goes on from what that has completed. */
static void every_failing_allocation_of_tiles_is_told(void **state)
{
	struct store *store = small_store();
	struct exchange_tiles_result result;
	leaflet();
	struct exchange_tiles_params params = tiles_params(store, "right");
	must(exchange_tiles(&params, &result));
	int64_t all = 0;
	for (int set = 0; set < EXCHANGE_SETS; set++)
		all += result.made[set];
	assert_true(all > 20);
	uint64_t nth = 1, failed = 0;
	bool whole = false;
	params = tiles_params(store, "tiles");
	for (int round = 0; round < 3; round++) {
		for (; !whole; nth++) {
			(void)mem_fail_nth(nth, 0);
			enum status status = exchange_tiles(&params, &result);
			whole = mem_fail_nth(0, 0) < nth;
			assert_true(whole == (status == STATUS_OK));
			assert_true(whole || told(status));
			failed += !whole;
			assert_true(access(support_path("tiles/furrow-tiles.json"), F_OK) == (whole ? 0 : -1));
		}
		assert_true(shell("diff -r right tiles >/dev/null"));
		assert_true(shell("rm -r tiles"));
		nth = 40 * (uint64_t)(round + 1); /* further into a whole export */
		whole = false;
	}
	assert_true(failed > 100);
	store_close(store);
}

static void a_file_that_cannot_be_written_is_told(void **state)
{
	struct store *store = small_store();
	struct exchange_tiles_result result;
	leaflet();
	struct exchange_tiles_params params = tiles_params(store, "right");
	must(exchange_tiles(&params, &result));
	params = tiles_params(store, "tiles");
	/* A file stands where a folder has to be, and a folder where a file has to be. */
	static const char *const in_the_way[][2] = {
		{"mkdir tiles && touch tiles/furrow-tiles.x tiles/terrain", "rm tiles/terrain"},
		{"touch tiles/furrow-tiles.x && mkdir -p tiles/mesh/0/0/0.terrain/x", "rm -r tiles/mesh"},
		{"touch tiles/furrow-tiles.x && mkdir -p tiles/index.html/x", "rm -r tiles/index.html"},
		{"rm -f tiles/furrow-tiles.journal && mkdir tiles/furrow-tiles.journal", "rmdir tiles/furrow-tiles.journal"},
		{"mkdir -p tiles/furrow-tiles.json/x", "rm -r tiles/furrow-tiles.json"},
	};
	for (size_t i = 0; i < sizeof in_the_way / sizeof *in_the_way; i++) {
		assert_true(shell(in_the_way[i][0]));
		enum status status = exchange_tiles(&params, &result);
		assert_true(told(status));
		assert_true(shell(in_the_way[i][1]));
	}
	must(exchange_tiles(&params, &result));
	assert_true(shell("rm tiles/furrow-tiles.x && diff -r right tiles >/dev/null"));
	store_close(store);
}

static enum status stop_later(void *user, int64_t done, int64_t total)
{
	int *left = user;
	assert_true(done >= 0 && done <= total);
	return --*left >= 0 ? STATUS_OK : fail_with(STATUS_INTERRUPTED, "a test: it stops; go on");
}

static void every_failure_of_a_mesh_leaves_no_file(void **state)
{
	struct store *store = small_store();
	struct store_reader *reader;
	must(store_reader_create(store, &reader));
	static const char *const names[] = {"m.obj", "m.glb", "m.stl"};
	for (size_t i = 0; i < 3; i++) {
		struct exchange_mesh_result result;
		struct exchange_mesh_params params = {.reader = reader, .meta = store_meta(store), .path = support_path(names[i]), .rect = {0, 0, 33, 33}};
		uint64_t nth = 1;
		for (bool whole = false; !whole; nth++) {
			(void)mem_fail_nth(nth, 0);
			enum status status = exchange_mesh(&params, &result);
			whole = mem_fail_nth(0, 0) < nth;
			assert_true(whole == (status == STATUS_OK));
			assert_true(whole || told(status));
			assert_int_equal(access(params.path, F_OK), whole ? 0 : -1);
		}
		assert_true(nth > 6);
		assert_int_equal(unlink(params.path), 0);
		int left = 1;
		params.progress = stop_later;
		params.progress_user = &left;
		assert_int_equal(exchange_mesh(&params, &result), STATUS_INTERRUPTED);
		assert_int_equal(access(params.path, F_OK), -1);
		params.progress = NULL;
		params.path = "/dev/full.obj/none.obj";
		assert_true(told(exchange_mesh(&params, &result)));
	}
	store_reader_destroy(reader);
	store_close(store);
}

static void a_full_disk_is_told(void **state)
{
	struct store *store = small_store();
	struct store_reader *reader;
	must(store_reader_create(store, &reader));
	/* The file that is written aside is a link to a device that is always full. */
	static const char *const names[][2] = {{"f.obj", "f.obj.part"}, {"f.glb", "f.glb.part"}, {"f.stl", "f.stl.part"}};
	for (size_t i = 0; i < 3; i++) {
		struct exchange_mesh_result result;
		struct exchange_mesh_params params = {.reader = reader, .meta = store_meta(store), .path = support_path(names[i][0]), .rect = {0, 0, 33, 33}};
		assert_int_equal(symlink("/dev/full", support_path(names[i][1])), 0);
		assert_true(told(exchange_mesh(&params, &result)));
		assert_int_equal(access(params.path, F_OK), -1);
	}
	store_reader_destroy(reader);
	store_close(store);
}

TEST_PROGRAM(faults)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_failing_allocation_of_tiles_is_told),
		cmocka_unit_test(a_file_that_cannot_be_written_is_told),
		cmocka_unit_test(every_failure_of_a_mesh_leaves_no_file),
		cmocka_unit_test(a_full_disk_is_told),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
