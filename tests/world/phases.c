/* The phases of a world: which arrows there are, that no other can be taken, and a world that goes through all of them. */
#include "../support.h"
#include "../support/program.h"

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include "world/internal.h"

/* A second list of the arrows, in the order of phases. */
static const char *const allowed[WORLD_PHASES][WORLD_PHASES] = {
	[WORLD_OPENED] = {[WORLD_STARTED] = "world_start", [WORLD_ENDED] = "world_stop"},
	[WORLD_STARTED] = {[WORLD_WARM] = "world_warm", [WORLD_ENDED] = "world_stop"},
	[WORLD_WARM] = {[WORLD_READY] = "world_begin", [WORLD_ENDED] = "world_stop"},
	[WORLD_READY] = {[WORLD_STEPPING] = "world_begin_run", [WORLD_TORN] = "world_tear", [WORLD_ENDED] = "world_stop"},
	[WORLD_STEPPING] = {[WORLD_READY] = "world_rollback", [WORLD_TORN] = "world_tear", [WORLD_ENDED] = "world_stop"},
	[WORLD_TORN] = {[WORLD_READY] = "world_mend", [WORLD_STEPPING] = "world_mend", [WORLD_ENDED] = "world_stop"},
};

static void the_table_has_these_arrows_and_no_other(void **state)
{
	size_t count = 0;
	for (enum world_phase from = 0; from < WORLD_PHASES; from++)
		for (enum world_phase to = 0; to < WORLD_PHASES; to++) {
			const char *by = world_phase_arrow(from, to);
			assert_int_equal(by != NULL, allowed[from][to] != NULL);
			if (by != NULL)
				assert_string_equal(by, allowed[from][to]);
			count += by != NULL;
		}
	assert_int_equal(count, 15);
}

/* Enters a phase in a child. Returns the signal that ended it; 0: it came to the end. */
static int signal_of(enum world_phase from, enum world_phase to)
{
	int ended;
	fflush(NULL);
	const pid_t child = fork();
	if (child == 0) {
		struct world world = {.phase = from};
		setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0});
		signal(SIGABRT, SIG_DFL);
		if (freopen("/dev/null", "w", stderr) == NULL)
			_exit(2);
		world_enter(&world, to);
		_exit(world.phase == to ? 0 : 3);
	}
	assert_int_equal(waitpid(child, &ended, 0), child);
	assert_true(WIFSIGNALED(ended) || WEXITSTATUS(ended) == 0);
	return WIFSIGNALED(ended) ? WTERMSIG(ended) : 0;
}

static void each_other_arrow_ends_in_the_assert(void **state)
{
#ifdef NDEBUG
	skip_since("built without asserts");
#endif
	for (enum world_phase from = 0; from < WORLD_PHASES; from++)
		for (enum world_phase to = 0; to < WORLD_PHASES; to++)
			if (signal_of(from, to) != (allowed[from][to] != NULL ? 0 : SIGABRT))
				fail_msg("%s to %s", world_phase_name(from), world_phase_name(to));
}

/* --- a world that lives --- */

static const struct extent extent = {65, 65, 0.25, 32};

/* The CPU computes its ground, so that no GL is needed. */
static const char scene_text[] =
	"scene: 1\ntime_step: 0.05\nend_time: 1\nspacing: 0.125\n"
	"soil: {name: dry_sand}\nredistribute: {model: scm}\n"
	"objects:\n"
	"  - {name: ball, shape: {sphere: {radius: 0.5}}, sink: 0.1, path: {points: [[4, 4], [9, 9]], speed: 2}}\n";

static double flat(int64_t x, int64_t y)
{
	(void)x, (void)y;
	return 10;
}

static enum status others_agree(void *user, double until, enum status status)
{
	(void)user, (void)until;
	return status;
}

static bool may_read(void *user, uint64_t key)
{
	(void)user, (void)key;
	return true;
}

static enum status no_change(void *user, uint64_t key)
{
	(void)user, (void)key;
	return fail_with(STATUS_FAILED, "change: it fails; try another");
}

/* A step fails when it has changed the ground. */
static void tear(struct world *world)
{
	const struct world_ranks failing = {.step = others_agree, .has = may_read, .changes = no_change};
	world->ranks = &failing;
	assert_int_equal(world_step(world), STATUS_FAILED);
	world->ranks = NULL;
}

static void a_world_goes_through_all_phases(void **state)
{
	const char *path = support_path("scene.yaml"), *store = support_path("phases.furrow");
	struct world *world = NULL;
	support_store(store, extent, flat);
	support_write(path, scene_text);
	struct scene *scene = support_scene(path, NULL);
	must(world_open(&(struct world_params){.scene = scene, .store = store}, &world));
	assert_int_equal(world_phase(world), WORLD_OPENED);
	must(world_start(world));
	assert_int_equal(world_phase(world), WORLD_STARTED);
	must(world_start_pages(world, NULL, NULL));
	assert_int_equal(world_phase(world), WORLD_STARTED);
	must(world_warm(world));
	assert_int_equal(world_phase(world), WORLD_WARM);
	world_tear(world); /* no step can be made yet, so there is nothing to tear */
	assert_int_equal(world_phase(world), WORLD_WARM);
	world_seal(world);
	must(world_begin(world)); /* a run that no host steps commits its start at once */
	assert_int_equal(world_phase(world), WORLD_STEPPING);
	must(world_step(world));
	assert_int_equal(world_phase(world), WORLD_STEPPING);
	assert_false(world_is_torn(world));
	assert_int_equal(world_steps_done(world), 1);
	tear(world);
	assert_int_equal(world_phase(world), WORLD_TORN);
	assert_true(world_is_torn(world));
	assert_int_equal(world_steps_done(world), 1);
	must(world_end(world, false)); /* nothing of the torn step is committed */
	assert_int_equal(world_phase(world), WORLD_TORN);
	world_stop(world);
	assert_int_equal(world_phase(world), WORLD_ENDED);
	world_finish(world, STATUS_FAILED);
	scene_destroy(scene);
	support_verify(store);
}

/* A host's world has committed nothing before its first step. A rollback leads from a torn step to where the checkpoint was. */
static void a_hosts_world_is_ready_before_it_steps_and_after_a_rollback(void **state)
{
	const char *store = support_path("hosted.furrow");
	struct scene *scene;
	struct world *world = NULL;
	support_store(store, extent, flat);
	must(scene_load_text(scene_text, NULL, NULL, 0, SCENE_HOST, &scene));
	const uint64_t before = support_hash(store);
	must(world_open(&(struct world_params){.scene = scene, .store = store}, &world));
	must(world_start(world));
	must(world_start_pages(world, NULL, NULL));
	must(world_warm(world));
	must(world_begin(world));
	assert_int_equal(world_phase(world), WORLD_READY);
	must(world_checkpoint(world));
	assert_int_equal(world_phase(world), WORLD_READY);
	must(world_step_to(world, 0.05));
	assert_int_equal(world_phase(world), WORLD_STEPPING);
	tear(world);
	assert_int_equal(world_phase(world), WORLD_TORN);
	must(world_rollback(world));
	assert_int_equal(world_phase(world), WORLD_READY);
	assert_int_equal(world_steps_done(world), 0);
	must(world_step_to(world, 0.05));
	must(world_checkpoint(world));
	tear(world);
	must(world_rollback(world));
	assert_int_equal(world_phase(world), WORLD_STEPPING);
	assert_int_equal(world_steps_done(world), 1);
	must(world_end(world, true));
	world_stop(world);
	assert_int_equal(world_phase(world), WORLD_ENDED);
	world_finish(world, STATUS_OK);
	scene_destroy(scene);
	assert_true(support_hash(store) != before);
	support_verify(store);
}

TEST_PROGRAM(phases)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_table_has_these_arrows_and_no_other),
		cmocka_unit_test(each_other_arrow_ends_in_the_assert),
		cmocka_unit_test(a_world_goes_through_all_phases),
		cmocka_unit_test(a_hosts_world_is_ready_before_it_steps_and_after_a_rollback),
	};
	return cmocka_run_group_tests_name("phases", tests, support_enter, support_leave);
}
