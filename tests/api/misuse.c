/* What no host may do: use a world in a forked child, leave `progress` by longjmp, or step beyond all time. Each is told, and nothing waits. */
#include <setjmp.h>
#include <sys/wait.h>

#include "hosted.h"
#include "../support/program.h"
#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

/* Number of the first check that fails; 0: none does. Each call is refused, with a message that says why. */
static int in_child(struct furrow_world *world, furrow_body ball)
{
	const double xy[2] = {10, 10};
	const struct furrow_state to = hosted_state(10, 10, 100.4);
	struct furrow_info info = {.size = sizeof info};
	struct furrow_contact contact;
	struct furrow_point point;
	struct furrow_state now;
	furrow_body found;
	const furrow_status got[] = {
		furrow_step(world, 0),
		furrow_points(world, 1, xy, &point),
		furrow_probe(world, 1, &ball, &to, &contact, sizeof contact),
		furrow_set_states(world, 1, &ball, &to),
		furrow_get_states(world, 1, &ball, &now),
		furrow_body_add(world, HOSTED_BALL, &found),
		furrow_body_find(world, "body-1", &found),
		furrow_checkpoint(world),
		furrow_rollback(world),
		furrow_info(world, &info),
		furrow_world_close(world),
		furrow_world_close(world),
	};
	for (size_t i = 0; i < sizeof got / sizeof *got; i++)
		if (got[i] != FURROW_USAGE)
			return 1 + (int)i;
	struct furrow_world *own = NULL;
	struct furrow_open open = hosted_open(HOSTED_SCENE, support_path("fork.furrow"));
	open.readonly = true;
	if (strstr(furrow_last_error(), "program of its own") == NULL || furrow_world_open(&open, &own) != FURROW_USAGE || own != NULL)
		return 100;
	return strstr(furrow_last_error(), "program of its own") != NULL ? 0 : 101;
}

static void a_forked_child_is_refused_and_never_waits(void **state)
{
	const char *store = support_path("fork.furrow"), *output = support_path("fork-out");
	int ended, pipe_of[2];
	char byte;
	support_store(store, hosted_extent, hosted_flat);
	struct furrow_open open = hosted_open(HOSTED_SCENE, store);
	open.output = output;
	struct furrow_world *world = NULL;
	done(furrow_world_open(&open, &world));
	const furrow_body ball = hosted_ball(world, 10, 10);
	hosted_move(world, ball, 10, 10, 100.4);
	assert_int_equal(pipe(pipe_of), 0);
	const pid_t child = fork();
	if (child == 0) {
		alarm(20); /* who waits is killed, and fails the test */
		const int wrong = in_child(world, ball);
		close(pipe_of[1]);
		(void)!read(pipe_of[0], &byte, 1); /* lives on, until the parent has opened the store again */
		_exit(wrong);
	}
	close(pipe_of[0]);
	hosted_move(world, ball, 10.05, 10, 100.4);
	done(furrow_world_close(world));
	/* The child may not have let go yet. */
	furrow_status status = FURROW_FAILED;
	for (int i = 0; i < 2000 && status == FURROW_FAILED; i++) {
		usleep(10000);
		status = furrow_world_open(&open, &world);
	}
	done(status);
	done(furrow_world_close(world));
	close(pipe_of[1]);
	assert_int_equal(waitpid(child, &ended, 0), child);
	assert_int_equal(ended, 0);
}

static jmp_buf out;

static bool leave(double share, void *user)
{
	longjmp(out, 1);
}

/* The leak checker does not look at what is allocated from now on, or does again. */
static void keep_leaks(bool kept)
{
#ifdef __SANITIZE_ADDRESS__
	if (kept)
		__lsan_disable();
	else
		__lsan_enable();
#endif
}

static void a_longjmp_out_of_progress_is_told(void **state)
{
	const char *raster = support_path("left.r16"), *store = support_path("left.furrow"), *other = support_path("other.furrow");
	static const char options[] = "{spacing: 1}";
	FILE *file = fopen(raster, "wb");
	assert_non_null(file);
	for (int i = 0; i < 64 * 64 * 2; i++)
		fputc(i % 7, file);
	assert_int_equal(fclose(file), 0);
	const char *const sources[] = {raster};
	keep_leaks(true); /* what the import had is lost */
	if (setjmp(out) == 0) {
		(void)!furrow_import(sources, 1, store, options, leave, NULL);
		print_error("%s\n", furrow_last_error());
		fail();
	}
	keep_leaks(false);
	/* That store stays locked, and it is told by whom. Everything else goes on. */
	refused(FURROW_FAILED, furrow_import(sources, 1, store, options, NULL, NULL));
	assert_non_null(strstr(furrow_last_error(), "this process"));
	done(furrow_import(sources, 1, other, options, NULL, NULL));
}

static void no_step_leads_beyond_what_time_can_tell(void **state)
{
	struct furrow_world *world = hosted_world("long.furrow");
	static const double longest[] = {1e300, 1.7e308, 1.0000001e9, 4e9};
	for (size_t i = 0; i < sizeof longest / sizeof *longest; i++) {
		misused(furrow_step(world, longest[i]));
		assert_non_null(strstr(furrow_last_error(), "give 1e+09 s or less"));
	}
	assert_true(furrow_time(world) == 0);
	done(furrow_step(world, 9e8));
	misused(furrow_step(world, 2e8));
	assert_non_null(strstr(furrow_last_error(), "give 1e+08 s or less"));
	done(furrow_step(world, 1e8));
	misused(furrow_step(world, 0.01));
	misused(furrow_step(world, 0));
	done(furrow_world_close(world));
}

static void no_step_passes_more_of_a_path_than_memory_has(void **state)
{
	static const char scene[] = "{scene: 1, spacing: 0.25, time_step: 0.1, redistribute: {model: box}, objects: [{name: w, shape: {sphere: {radius: 0.5}},"
				    " sink: 0.1, path: {points: [[4, 4], [28, 28]], speed: 5, loop: true}}]}";
	struct furrow_world *world = hosted_world_over("loop.furrow", scene, hosted_flat);
	misused(furrow_step(world, 1e8));
	assert_non_null(strstr(furrow_last_error(), "path samples"));
	assert_true(furrow_time(world) == 0);
	done(furrow_step(world, 20));
	done(furrow_world_close(world));
}

TEST_PROGRAM(misuse)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_forked_child_is_refused_and_never_waits),
		cmocka_unit_test(a_longjmp_out_of_progress_is_told),
		cmocka_unit_test(no_step_leads_beyond_what_time_can_tell),
		cmocka_unit_test(no_step_passes_more_of_a_path_than_memory_has),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
