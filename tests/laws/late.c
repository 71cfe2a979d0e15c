/*
 * A GPU that is behind: what it sends is found not to be there at the first looks. On a software driver a transfer is over at once, so
 * only this test sees that there. Rows are the same however late it comes, also over ground that another soil left steep.
 *
 * Linked with --wrap for the three functions below.
 */
#include "where.h"

#include "gpu/gpu.h"
#include "../support/program.h"

#define UNDER_WAY 256

void __wrap_gpu_buffer_read_into(struct gpu_buffer *buffer, size_t offset, size_t bytes, struct gpu_staging *staging, size_t staging_offset);
bool __wrap_gpu_staging_idle(struct gpu_staging *staging);
void __wrap_gpu_finish(struct gpu *gpu);
void __real_gpu_buffer_read_into(struct gpu_buffer *buffer, size_t offset, size_t bytes, struct gpu_staging *staging, size_t staging_offset);
bool __real_gpu_staging_idle(struct gpu_staging *staging);
void __real_gpu_finish(struct gpu *gpu);

static int looks_most; /* a transfer is not over at up to so many looks */
static struct {
	const struct gpu_staging *staging;
	int looks;
} under_way[UNDER_WAY];
static size_t count;
static uint32_t state;

void __wrap_gpu_buffer_read_into(struct gpu_buffer *buffer, size_t offset, size_t bytes, struct gpu_staging *staging, size_t staging_offset)
{
	size_t i = 0;
	__real_gpu_buffer_read_into(buffer, offset, bytes, staging, staging_offset);
	while (i < count && under_way[i].staging != staging)
		i++;
	assert_true(i < UNDER_WAY);
	count += i == count;
	state = state * 1664525 + 1013904223;
	under_way[i].staging = staging;
	under_way[i].looks = looks_most > 0 ? (int)((state >> 8) % (uint32_t)looks_most) : 0;
}

bool __wrap_gpu_staging_idle(struct gpu_staging *staging)
{
	for (size_t i = 0; i < count; i++)
		if (under_way[i].staging == staging && under_way[i].looks > 0) {
			under_way[i].looks--;
			return false;
		}
	return __real_gpu_staging_idle(staging);
}

void __wrap_gpu_finish(struct gpu *gpu)
{
	__real_gpu_finish(gpu);
	count = 0;
}

static const char digs[] = "end_time: 4\nspacing: 0.25\nobjects:\n"
			   "  - {name: dig, shape: {box: {size: [4, 4, 4]}}, sink: 1.6, path: {points: [[60, 60], [66, 60]], speed: 8}}\n";
static const char rolls[] = "end_time: 3\nspacing: 0.25\nobjects:\n"
			    "  - {name: fly, shape: {box: {size: [0.5, 0.5, 0.5]}}, path: {file: fly.csv}}\n"
			    "  - {name: roll, shape: {wheel: {radius: 0.8, width: 0.6}}, sink: 0.2, path: {points: [[50, 63], [70, 60]], speed: 8}}\n";

/* Drives with flags that come after up to `looks` looks. Returns the hash of the rows. */
static uint64_t rows_of(const char *scene, const char *first, int looks)
{
	const char *store = support_path("late.furrow");
	support_store(store, extent, flat);
	looks_most = 0;
	if (first != NULL)
		mem_free(drive(first, store, "out-first", false, false, 0));
	looks_most = looks;
	count = 0;
	state = (uint32_t)looks;
	mem_free(drive(scene, store, "out", false, false, 0));
	support_verify(store);
	return support_hash(store);
}

static void however_late_flags_come_rows_are_the_same(void **unused)
{
	(void)unused;
	write_poses("fly.csv", &(struct hops){flat, 1, 40, 61, 20, 0.3, 0.25, -0.05, 0.06, 1, 3, false});
	for (int over = 0; over < 2; over++) /* over ground that slippage left, and over fresh ground */
		for (int m = 2; m < MODELS - 1; m++) { /* of scm the GPU sends nothing */
			const char *first = over == 0 ? scene_of("first.yaml", 3, digs) : NULL;
			const char *scene = scene_of("late.yaml", m, rolls);
			const uint64_t at_once = rows_of(scene, first, 0);
			for (int looks = 3; looks < 100; looks *= 5)
				if (rows_of(scene, first, looks) != at_once)
					fail_msg("%s over %s ground, up to %d looks: other rows", models[m], over == 0 ? "dug" : "fresh", looks);
		}
}

TEST_PROGRAM(late)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(however_late_flags_come_rows_are_the_same),
	};
	return cmocka_run_group_tests_name("late", tests, support_enter, support_leave);
}
