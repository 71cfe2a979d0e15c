/*
 * Law 6 for a whole drive: whatever fails under it, it ends with STATUS_FAILED and says why, and the
 * store verifies and has every epoch that was acknowledged; or it ends well and has all.
 *
 * A drive takes its time: MOST Ns of each kind that a disk or a full one has are tried, spread over
 * the calls a drive makes. The threads' order makes each of them another drive.
 */
#include "../support.h"
#include "../support/program.h"
#include "../support/skip.h"

#include "sweep.h"

#define MOST 10

static const struct extent hills = {129, 129, 2, 32};

static const char *const scene_texts[] = {
	"scene: 1\n"
	"time_step: 0.1\n"
	"end_time: 6\n"
	"spacing: 1\n"
	"redistribute: {model: box}\n"
	"attributes: [dirt]\n"
	"cache: {slots: 5, loaders: 2}\n"
	"objects:\n"
	"  - {name: a, shape: {sphere: {radius: 2.5}}, sink: 0.5,\n"
	"     path: {points: [[20, 20], [230, 230], [230, 30], [30, 220]], speed: 100}}\n",
	/* The soil's planes, forces on their way, and ground that slides on. */
	"scene: 1\n"
	"time_step: 0.1\n"
	"end_time: 3\n"
	"spacing: 1\n"
	"soil: {name: dry_sand}\n"
	"redistribute: {model: scm, bulldozing: 0.5, iterations: 1}\n"
	"output: {forces: 10}\n"
	"cache: {slots: 9, loaders: 2}\n"
	"objects:\n"
	"  - {name: a, shape: {wheel: {radius: 2.5, width: 3}}, load: 40000, slip: 0.2,\n"
	"     path: {points: [[20, 20], [230, 230], [230, 30], [30, 220]], speed: 100}}\n",
};

static uint64_t hash_driven;

static enum status drive(struct drive_result *result)
{
	struct scene *scene;
	enum status status = scene_load(in_folder("scene.yaml"), NULL, 0, &scene);
	if (status != STATUS_OK)
		return status;
	struct drive_params params = {.scene = scene, .store = in_folder("trial.furrow"), .directory = in_folder("out")};
	status = drive_run(&params, result);
	scene_destroy(scene);
	return status;
}

static int acknowledged(void)
{
	FILE *log = fopen(in_folder("out/epochs.log"), "r");
	int lines = 0;
	if (log == NULL)
		return 0;
	for (int c; (c = getc(log)) != EOF;)
		lines += c == '\n';
	fclose(log);
	return lines;
}

static void look(enum status status)
{
	struct store *store;
	struct store_check check;
	struct store_numbers numbers;
	uint64_t hash;
	expect(store_open(in_folder("trial.furrow"), &(struct store_options){.mode = STORE_READ}, &store) == STATUS_OK);
	expect(store_verify(store, print_problem, NULL, NULL, &check) == STATUS_OK);
	expect(check.problems == 0);
	expect(store_count(store, &numbers) == STATUS_OK);
	expect(numbers.commits == acknowledged() || (status != STATUS_OK && numbers.commits == acknowledged() + 1));
	expect(store_content_hash(store, &hash) == STATUS_OK);
	expect(status != STATUS_OK || hash == hash_driven);
	store_close(store);
}

static void fresh(void)
{
	unlink(in_folder("out/epochs.log"));
	unlink(in_folder("out/run.json"));
	unlink(in_folder("out/volume.csv"));
	unlink(in_folder("trial.furrow-wal"));
	copy_file(in_folder("fresh"), in_folder("trial.furrow"));
}

static uint64_t trial(const void *user, const struct fault *fault)
{
	struct drive_result result = {0};
	fresh();
	fault_arm_for(fault);
	enum status status = drive(&result);
	uint64_t calls = fault_disarm();
	expect(status == STATUS_OK || told(status));
	expect(calls >= fault->nth || status == STATUS_OK);
	expect(status == STATUS_OK || strcmp(result.ended, "failed") == 0);
	/* Of a drive that began, run.json tells the same. */
	expect(result.json == NULL ||
	       strstr(result.json, status == STATUS_OK ? "\"complete\"" : "\"failed\"") != NULL);
	mem_free(result.json);
	look(status);
	return calls;
}

static void every_fault(const char *scene, int most, enum lasting lasting)
{
	static const enum fault_kind kinds[] = {FAULT_READ, FAULT_WRITE, FAULT_FULL, FAULT_TORN_WRITE, FAULT_OPEN,
						FAULT_SHARED, FAULT_SQLITE_MEMORY};
	uint64_t ran = 0;
	struct drive_result result;
	support_write(in_folder("scene.yaml"), scene);
	fault_arm_for(&(struct fault){FAULT_NONE, UINT64_MAX, false});
	fresh();
	enum status status = drive(&result);
	fault_disarm();
	if (status == STATUS_NO_GL)
		skip_since("no GL");
	assert_ok(status);
	assert_true(support_figure(result.json, "\"cache\"", "writebacks") > 20);
	mem_free(result.json);
	struct store *store = open_store(in_folder("trial.furrow"), STORE_READ);
	hash_driven = content(store);
	store_close(store);
	assert_true(acknowledged() >= 3);
	for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
		ran += sweep_lasting(trial, NULL, kinds[i], most, lasting);
	assert_true((uint64_t)ran > 3 * (uint64_t)most / SWEEP_PART);
}

static void a_drive_whose_store_fails_says_so_and_loses_nothing(void **state)
{
	every_fault(scene_texts[0], MOST, BOTH);
}

static void so_does_one_with_the_soils_state_and_forces(void **state)
{
	every_fault(scene_texts[1], MOST / 3, ONE_BY_ONE);
}

static int enter(void **state)
{
	if (folder_make(state) != 0)
		return -1;
	support_store(in_folder("fresh"), hills, support_hills);
	return 0;
}

static int leave(void **state)
{
	unlink(in_folder("out/epochs.log"));
	unlink(in_folder("out/objects.csv"));
	unlink(in_folder("out/run.json"));
	unlink(in_folder("out/volume.csv"));
	rmdir(in_folder("out"));
	return folder_remove(state);
}

TEST_PROGRAM(drive)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_drive_whose_store_fails_says_so_and_loses_nothing),
		cmocka_unit_test(so_does_one_with_the_soils_state_and_forces),
	};
	fault_install();
	return cmocka_run_group_tests(tests, enter, leave);
}
