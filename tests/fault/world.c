/*
 * Half-made worlds: whatever fails while a world is opened, started, warmed, begun, stepped and ended, the call that was made says so, the phase stays
 * one of the table, and world_finish frees what there is. The store verifies afterwards.
 *
 * The world alone, without a drive around it. The CPU computes its ground, so that no GL is needed.
 */
#include "../support.h"
#include "../support/program.h"
#include "world/world.h"

#include "epochs.h"

#define MOST 60

static const struct extent extent_of_world = {65, 65, 0.25, 32};

static const char scene_text[] =
	"scene: 1\ntime_step: 0.05\nend_time: 1\nspacing: 0.125\n"
	"soil: {name: dry_sand}\nredistribute: {model: scm}\noutput: {forces: 20}\ncache: {loaders: 1}\n"
	"objects:\n"
	"  - {name: ball, shape: {sphere: {radius: 0.5}}, sink: 0.1, path: {points: [[4, 4], [9, 9]], speed: 2}}\n";

static double flat(int64_t x, int64_t y)
{
	(void)x, (void)y;
	return 10;
}

static struct scene *scene;
static uint64_t hash_stepped;

/* Goes as far as it can. *out: the world, whole or half made; NULL: there is none. */
static enum status live(struct world **out, bool overlay)
{
	const struct world_params params = {
		.scene = scene,
		.store = in_folder("trial.furrow"),
		.overlay = overlay ? in_folder("trial.overlay") : NULL,
		.rows = true,
	};
	TRY(world_open(&params, out));
	struct world *world = *out;
	TRY(world_start(world));
	TRY(world_start_pages(world, NULL, NULL));
	TRY(world_warm(world));
	world_seal(world);
	TRY(world_begin(world));
	TRY(world_step(world));
	return world_end(world, true);
}

/* *phase: the one in which it ended, before it was stopped. */
static enum status live_and_finish(bool overlay, enum world_phase *phase)
{
	struct world *world = NULL;
	struct failure failure;
	enum status status = live(&world, overlay);
	*phase = world != NULL ? world_phase(world) : WORLD_OPENED;
	failure_capture(&failure, status);
	world_stop(world);
	expect(world == NULL || world_phase(world) == WORLD_ENDED);
	world_finish(world, status);
	return failure_restore(&failure);
}

static void fresh(void)
{
	remove_store(in_folder("trial.furrow"));
	remove_store(in_folder("trial.overlay"));
	copy_file(in_folder("fresh"), in_folder("trial.furrow"));
}

static void verify(enum status status)
{
	struct store *store;
	struct store_check check;
	uint64_t hash;
	expect(store_open(in_folder("trial.furrow"), &(struct store_options){.mode = STORE_READ}, &store) == STATUS_OK);
	expect(store_verify(store, print_problem, NULL, NULL, &check) == STATUS_OK);
	expect(check.problems == 0);
	expect(store_content_hash(store, &hash) == STATUS_OK);
	expect(status != STATUS_OK || hash == hash_stepped);
	store_close(store);
}

static bool phases[WORLD_PHASES]; /* in which a trial failed */

static uint64_t trial(const void *user, const struct fault *fault)
{
	enum world_phase phase;
	fresh();
	fault_arm_for(fault);
	const enum status status = live_and_finish(false, &phase);
	const uint64_t calls = fault_disarm();
	expect(status == STATUS_OK || told(status));
	expect(calls >= fault->nth || status == STATUS_OK);
	phases[phase] = phases[phase] || status != STATUS_OK;
	verify(status);
	return calls;
}

/* An overlay that was made for it goes with it, or is whole. */
static uint64_t trial_with_overlay(const void *user, const struct fault *fault)
{
	enum world_phase phase;
	fresh();
	fault_arm_for(fault);
	const enum status status = live_and_finish(true, &phase);
	const uint64_t calls = fault_disarm();
	expect(status == STATUS_OK || told(status));
	expect(calls >= fault->nth || status == STATUS_OK);
	expect(status != STATUS_OK || access(in_folder("trial.overlay"), F_OK) == 0);
	return calls;
}

static void a_half_made_world_ends_clean(void **state)
{
	uint64_t ran = 0;
	for (int kind = FAULT_NONE + 1; kind < FAULT_KINDS; kind++)
		ran += kind == FAULT_MEMORY ? sweep(trial, NULL, FAULT_MEMORY, UINT64_MAX / 2)
					    : sweep_lasting(trial, NULL, (enum fault_kind)kind, MOST, IN_TURN);
	assert_true(ran > 100 / SWEEP_PART);
	assert_true(phases[WORLD_OPENED] && phases[WORLD_STARTED]);
}

static void so_does_one_with_an_overlay(void **state)
{
	static const enum fault_kind kinds[] = {FAULT_WRITE, FAULT_OPEN, FAULT_CALL_OPEN, FAULT_CALL_SYNC, FAULT_MEMORY, FAULT_SQLITE_MEMORY};
	uint64_t ran = 0;
	for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
		ran += sweep_lasting(trial_with_overlay, NULL, kinds[i], MOST, ONE_BY_ONE);
	assert_true(ran > 30 / SWEEP_PART);
}

static int enter(void **state)
{
	enum world_phase phase;
	if (folder_make(state) != 0)
		return -1;
	support_store(in_folder("fresh"), extent_of_world, flat);
	must(scene_load_text(scene_text, NULL, NULL, 0, SCENE_COMMAND, &scene));
	fresh();
	must(live_and_finish(false, &phase));
	assert_int_equal(phase, WORLD_STEPPING);
	struct store *store = open_store(in_folder("trial.furrow"), STORE_READ);
	hash_stepped = content(store);
	store_close(store);
	return 0;
}

static int leave(void **state)
{
	scene_destroy(scene);
	return folder_remove(state);
}

TEST_PROGRAM(world)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_half_made_world_ends_clean),
		cmocka_unit_test(so_does_one_with_an_overlay),
	};
	fault_install();
	return cmocka_run_group_tests(tests, enter, leave);
}
