/*
 * A slow disk: each read of a store takes a while. Whatever the step's thread waits for is in run.json, and so is most of the
 * time that the disk adds to a drive. Where each write takes a while, changed pages wait in memory, within the bound that is told.
 */
#include "../support.h"
#include "../support/program.h"

#include <pthread.h>
#include <sqlite3.h>
#include <time.h>

#include "drive/drive.h"
#include "through.h"

#define DELAY 10 /* ms a read */
#define WRITE_DELAY 2 /* ms a write */
#define WAITS 65536

static const struct extent extent = {1025, 1025, 1, 32};

static const char scene_text[] =
	"scene: 1\n"
	"time_step: 0.1\n"
	"end_time: 4\n"
	"spacing: 1\n"
	"redistribute: {model: box}\n"
	"objects:\n"
	"  - {name: a, shape: {sphere: {radius: 2.5}}, sink: 0.5, path: {points: [[40, 60], [900, 800]], speed: 200}}\n"
	"view:\n"
	"  size: [64, 36]\n"
	"  camera: {chase: a, back: 14, up: 9}\n"
	"  images: 8\n";

/* --- the disk --- */

static sqlite3_vfs *real, slow_vfs;
static sqlite3_io_methods methods;
static pthread_t steps_thread;
static bool slow, slow_writes;
static struct {
	double at, ms;
} waits[WAITS]; /* of the step's thread */
static size_t wait_count;

static int slow_read(sqlite3_file *file, void *bytes, int count, sqlite3_int64 at)
{
	double began = clock_seconds();
	if (slow)
		nanosleep(&(struct timespec){0, DELAY * 1000000}, NULL);
	if (slow && pthread_equal(pthread_self(), steps_thread)) {
		assert_true(wait_count < WAITS);
		waits[wait_count].at = began;
		waits[wait_count++].ms = (clock_seconds() - began) * 1e3;
	}
	return through_methods.xRead(file, bytes, count, at);
}

static int slow_write(sqlite3_file *file, const void *bytes, int count, sqlite3_int64 at)
{
	if (slow_writes)
		nanosleep(&(struct timespec){0, WRITE_DELAY * 1000000}, NULL);
	return through_methods.xWrite(file, bytes, count, at);
}

static int slow_open(sqlite3_vfs *vfs, const char *name, sqlite3_file *file, int flags, int *out)
{
	struct through *opened = (struct through *)file;
	opened->base.pMethods = NULL;
	opened->real = (sqlite3_file *)(opened + 1);
	int code = real->xOpen(real, name, opened->real, flags, out);
	if (opened->real->pMethods != NULL)
		opened->base.pMethods = &methods;
	return code;
}

static void install(void)
{
	methods = through_methods;
	methods.xRead = slow_read;
	methods.xWrite = slow_write;
	real = sqlite3_vfs_find(NULL);
	slow_vfs = *real;
	slow_vfs.szOsFile = (int)sizeof(struct through) + real->szOsFile;
	slow_vfs.zName = "slow";
	slow_vfs.xOpen = slow_open;
	assert_int_equal(sqlite3_vfs_register(&slow_vfs, 1), SQLITE_OK);
	steps_thread = pthread_self();
}

/* --- drives --- */

struct figures {
	double seconds, warm_seconds;            /* s */
	double stall_ms, range_wait_ms, nap_ms, image_wait_ms;
	long long range_waits, naps;
	double uncounted_ms; /* reads of the step's thread in the loop, that are in none of the waits */
	double read_ms;      /* all of them */
};

static double number(const char *json, const char *after, const char *name)
{
	char quoted[64];
	const char *at = strstr(json, after);
	assert_non_null(at);
	snprintf(quoted, sizeof quoted, "\"%s\":", name);
	at = strstr(at, quoted);
	assert_non_null(at);
	return atof(at + strlen(quoted));
}

static struct figures drive(const char *const *settings)
{
	const char *scene = support_path("scene.yaml"), *store = support_path("slow.furrow");
	support_write(scene, scene_text);
	wait_count = 0;
	double entered = clock_seconds();
	char *json = support_drive(scene, store, settings);
	struct figures figures = {
		.seconds = number(json, "{", "seconds"),
		.warm_seconds = number(json, "\"warm_up\"", "seconds"),
		.stall_ms = number(json, "\"cache\"", "stall_ms"),
		.range_wait_ms = number(json, "\"cache\"", "range_wait_ms"),
		.range_waits = (long long)number(json, "\"cache\"", "range_waits"),
		.naps = (long long)number(json, "\"view\"", "naps"),
		.nap_ms = number(json, "\"view\"", "nap_ms"),
		.image_wait_ms = number(json, "\"view\"", "image_wait_ms"),
	};
	mem_free(json);
	double began = entered + figures.warm_seconds + 0.002, ended = began + figures.seconds - 0.004; /* but for rounding */
	for (size_t i = 0; i < wait_count; i++)
		if (waits[i].at > began && waits[i].at < ended)
			figures.read_ms += waits[i].ms;
	figures.uncounted_ms = figures.read_ms - figures.stall_ms - figures.range_wait_ms;
	print_message("%.2f s after %.2f s; stalls %.0f ms, ranges %.0f ms, naps %.0f ms; reads %.0f ms\n", figures.seconds,
		      figures.warm_seconds, figures.stall_ms, figures.range_wait_ms, figures.nap_ms, figures.read_ms);
	return figures;
}

/* s of the loop in which nothing is waited for. */
static double busy(const struct figures *figures)
{
	return figures->seconds - (figures->stall_ms + figures->range_wait_ms + figures->nap_ms + figures->image_wait_ms) / 1e3;
}

/* Over ground that is deformed already, so that ranges of offsets are looked up too. */
static void make_store(void)
{
	support_store(support_path("slow.furrow"), extent, support_hills);
	drive((const char *const[]){NULL});
}

static void whatever_the_steps_thread_waits_for_is_counted(void **state)
{
	static const char *const settings[][4] = {
		{"cache.slots=512", "cache.loaders=1", "cache.prefetch=0", NULL},
		{"cache.slots=512", "cache.loaders=0", "cache.prefetch=0", NULL},
		{"cache.slots=512", "cache.loaders=2", "cache.prefetch=1.5", NULL},
	};
	make_store();
	for (size_t i = 0; i < sizeof settings / sizeof *settings; i++) {
		struct figures fast = drive(settings[i]);
		slow = true;
		struct figures found = drive(settings[i]);
		slow = false;
		assert_true(found.uncounted_ms <= 1);
		if (i < 2)
			assert_true(found.range_waits > 20 && found.range_wait_ms > 5 * DELAY);
		double added = found.seconds - fast.seconds;
		assert_true(i == 2 || added > 0.5);
		assert_true(busy(&found) - busy(&fast) < 0.5 + 0.3 * fmax(added, 0));
	}
}

/* Most ranges are there when a picture asks for them. */
static void what_looks_ahead_brings_the_ranges(void **state)
{
	make_store();
	slow = true;
	struct figures without = drive((const char *const[]){"cache.slots=512", "cache.prefetch=0", NULL});
	struct figures with = drive((const char *const[]){"cache.slots=512", "cache.prefetch=1.5", NULL});
	slow = false;
	print_message("waits for ranges: %lld without, %lld with\n", without.range_waits, with.range_waits);
	assert_true(with.range_waits < without.range_waits);
}

/* Four bodies come to new tiles in every step, and there are few slots. */
static const char hurried_text[] =
	"scene: 1\n"
	"time_step: 0.1\n"
	"end_time: 0.8\n"
	"spacing: 1\n"
	"cache: {slots: 16}\n"
	"objects:\n"
	"  - {name: a, shape: {sphere: {radius: 2.5}}, sink: 0.5, path: {points: [[20, 120], [900, 120]], speed: 1000}}\n"
	"  - {name: b, shape: {sphere: {radius: 2.5}}, sink: 0.5, path: {points: [[20, 320], [900, 320]], speed: 1000}}\n"
	"  - {name: c, shape: {sphere: {radius: 2.5}}, sink: 0.5, path: {points: [[20, 520], [900, 520]], speed: 1000}}\n"
	"  - {name: d, shape: {sphere: {radius: 2.5}}, sink: 0.5, path: {points: [[20, 720], [900, 720]], speed: 1000}}\n";

static uint64_t hurry(double *queue, double *peak, double *commits)
{
	const char *scene = support_path("hurried.yaml"), *store = support_path("hurried.furrow");
	support_write(scene, hurried_text);
	support_store(store, extent, support_hills);
	char *json = support_drive(scene, store, (const char *const[]){NULL});
	*queue = number(json, "\"budget\"", "queue");
	*peak = number(json, "\"units\"", "page") * 33 * 33 * sizeof(int32_t); /* the offset alone is changed */
	*commits = number(json, "\"io\"", "commits");
	mem_free(json);
	support_verify(store);
	return support_hash(store);
}

/* Where memory is short a step waits for the disk, and no more images of changed pages are made than are told. Nothing is lost. */
static void the_queue_stays_within_the_memory_that_there_is(void **state)
{
	double wide, bound, peak, commits;
	const uint64_t whole = hurry(&wide, &peak, &commits);
	assert_true(peak > 0 && peak <= wide);
	mem_pretend_usable(400000);
	slow_writes = true;
	const uint64_t slowly = hurry(&bound, &peak, &commits);
	slow_writes = false;
	mem_pretend_usable(0);
	print_message("at most %.0f bytes in the queue, of %.0f without a bound; %.0f were used, in %.0f commits\n", bound, wide, peak, commits);
	assert_true(bound < wide && bound < 1000000);
	assert_true(peak > 0 && peak <= bound && commits > 1);
	assert_true(slowly == whole);
}

static int prepare(void **state)
{
	install();
	return support_enter(state);
}

TEST_PROGRAM(slow)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(whatever_the_steps_thread_waits_for_is_counted),
		cmocka_unit_test(what_looks_ahead_brings_the_ranges),
		cmocka_unit_test(the_queue_stays_within_the_memory_that_there_is),
	};
	return cmocka_run_group_tests_name("slow", tests, prepare, support_leave);
}
