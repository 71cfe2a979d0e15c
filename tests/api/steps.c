/* What furrow.h promises of steps: of one that fails before anything changed, of one whose rows have no room, and of the times that are told. */
#include "../support/near.h"
#include "rut.h"

#include "api/library.h"
#include "world/made.h"
#include "../support/program.h"

#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>

/* Two bodies at equal times. The one that drives east leaves the terrain after 0.4 s. */
#define LEAVING \
	"{\"scene\": 1, \"time_step\": 0.02, \"spacing\": 0.125, \"soil\": {\"name\": \"dry_sand\"}, \"redistribute\": {\"model\": \"scm\"}," \
	" \"objects\": [{\"name\": \"leaves\", \"shape\": {\"sphere\": {\"radius\": 0.5}}, \"sink\": 0.1," \
	" \"path\": {\"points\": [[30, 16], [34, 16]], \"speed\": 5}}, {\"name\": \"stays\", \"shape\": {\"sphere\": {\"radius\": 0.5}}, \"sink\": 0.1," \
	" \"path\": {\"points\": [[5, 10], [15, 10]], \"speed\": 5}}]}"

static enum status no_step(void *user, double until, enum status status)
{
	(void)user, (void)until, (void)status;
	return fail_with(STATUS_FAILED, "step: it fails; try another");
}

/* Fails a step when all of its path samples are placed. */
static void fail_late(struct furrow_world *world)
{
	const struct world_ranks ranks = {.step = no_step};
	world_made_set_ranks(world->world, &ranks);
	refused(FURROW_FAILED, furrow_step(world, 0.1));
	world_made_set_ranks(world->world, NULL);
}

static double *driven(const char *name, bool fails, struct furrow_info *info)
{
	struct furrow_world *world = hosted_world_over(name, LEAVING, hosted_flat);
	for (int i = 0; i < 15; i++) {
		if (fails && i % 5 == 0) {
			refused(FURROW_FAILED, furrow_step(world, 1));
			fail_late(world);
			assert_true(fabs(furrow_time(world) - 0.02 * i) < 1e-12);
		}
		done(furrow_step(world, 0));
	}
	double *offsets = hosted_read(world, FURROW_OFFSET, info);
	done(furrow_world_close(world));
	return offsets;
}

static void a_step_that_fails_before_anything_changed_changes_no_later_one(void **state)
{
	struct furrow_info info;
	double *failed = driven("failed.furrow", true, &info), *other = driven("other.furrow", false, &info);
	assert_true(other[128 * info.columns + 248] < -0.05 && other[80 * info.columns + 48] < -0.05);
	assert_memory_equal(failed, other, (size_t)(info.columns * info.rows) * sizeof *other);
	free(failed);
	free(other);
}

/* Path samples are 0.125 m apart, so that each force is of a multiple of 0.25 s. */
static void a_contact_on_a_path_has_the_time_of_its_path_sample(void **state)
{
	static const char scene[] = "{\"scene\": 1, \"time_step\": 0.05, \"spacing\": 0.125, \"soil\": {\"name\": \"dry_sand\"},"
				    " \"redistribute\": {\"model\": \"scm\"}, \"objects\": [{\"name\": \"ball\", \"shape\": {\"sphere\": {\"radius\": 0.5}},"
				    " \"sink\": 0.1, \"path\": {\"points\": [[10, 16], [20, 16]], \"speed\": 0.5}}]}";
	struct furrow_world *world = hosted_world_over("sample.furrow", scene, hosted_flat);
	struct furrow_contact before = {.time = NAN};
	furrow_body ball;
	done(furrow_body_find(world, "ball", &ball));
	assert_true(isnan(contact_of(world, ball).time)); /* no step was made */
	for (int i = 1; i <= 20; i++) {
		done(furrow_step(world, 0));
		const struct furrow_contact contact = contact_of(world, ball);
		assert_near(contact.time, 0.25 * floor(i / 5.0), 1e-9);
		if (contact.time == before.time)
			assert_memory_equal(contact.force, before.force, sizeof before.force);
		else
			assert_memory_not_equal(contact.force, before.force, sizeof before.force);
		before = contact;
	}
	done(furrow_world_close(world));
}

/* A step of too many path samples is refused before anything changes, however many they are. */
static void a_step_of_too_many_path_samples_is_refused(void **state)
{
	static const char scene[] = "{\"scene\": 1, \"time_step\": 0.05, \"spacing\": 0.125, \"soil\": {\"name\": \"dry_sand\"},"
				    " \"redistribute\": {\"model\": \"scm\"}, \"objects\": [{\"name\": \"ball\", \"shape\": {\"sphere\": {\"radius\": 0.5}},"
				    " \"sink\": 0.1, \"path\": {\"points\": [[10, 16], [20, 16]], \"speed\": 10, \"loop\": true}}]}";
	struct furrow_world *world = hosted_world_over("many.furrow", scene, hosted_flat);
	refused(FURROW_USAGE, furrow_step(world, 12600)); /* a million posts of 0.125 m are 12,500 s of way */
	refused(FURROW_USAGE, furrow_step(world, 1e15));
	assert_true(furrow_time(world) == 0);
	done(furrow_step(world, 0));
	assert_true(fabs(furrow_time(world) - 0.05) < 1e-12);
	done(furrow_world_close(world));
}

/* --- rows --- */

#define ROWS \
	"{\"scene\": 1, \"time_step\": 0.02, \"spacing\": 0.125, \"soil\": {\"name\": \"dry_sand\"}, \"redistribute\": {\"model\": \"scm\"}," \
	" \"output\": {\"forces\": 50}, \"objects\": [{\"name\": \"ball\", \"shape\": {\"sphere\": {\"radius\": 0.5}}, \"sink\": 0.1," \
	" \"path\": {\"points\": [[10, 16], [20, 16]], \"speed\": 5}}]}"

/* Makes a step while no file may grow beyond what objects.csv has. */
static void step_without_room(struct furrow_world *world, const char *path)
{
	struct rlimit before, limit;
	struct stat file;
	assert_int_equal(stat(path, &file), 0);
	assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
	limit = before;
	limit.rlim_cur = (rlim_t)file.st_size;
	assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
	const furrow_status status = furrow_step(world, 0);
	assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
	assert_int_equal(status, FURROW_FAILED);
	assert_non_null(strstr(furrow_last_error(), "objects.csv"));
}

/* Drives eight steps, and leaves the text of objects.csv. */
static char *rows_of(const char *name, bool fails)
{
	char folder[4000], path[4096], store[64];
	snprintf(store, sizeof store, "%s.furrow", name);
	snprintf(folder, sizeof folder, "%s", support_path(name));
	snprintf(path, sizeof path, "%s/objects.csv", folder);
	support_store(support_path(store), hosted_extent, hosted_flat);
	struct furrow_open open = hosted_open(ROWS, support_path(store));
	open.output = folder;
	struct furrow_world *world;
	done(furrow_world_open(&open, &world));
	for (int i = 0; i < 4; i++)
		done(furrow_step(world, 0));
	done(furrow_checkpoint(world));
	if (fails) {
		done(furrow_step(world, 0));
		step_without_room(world, path);
		refused(FURROW_FAILED, furrow_step(world, 0)); /* not until it is rolled back */
		refused(FURROW_FAILED, furrow_checkpoint(world));
		done(furrow_rollback(world));
	}
	for (int i = 0; i < 4; i++)
		done(furrow_step(world, 0));
	done(furrow_world_close(world));
	return support_text(path);
}

static void a_step_whose_rows_have_no_room_is_rolled_back(void **state)
{
	signal(SIGXFSZ, SIG_IGN);
	char *failed = rows_of("no-room", true), *other = rows_of("room", false);
	assert_string_equal(failed, other);
	free(failed);
	free(other);
}

#define BALLS 17 /* more than the list of contacts has room for at first, so that it grows while others wait */

/* Presses all balls in a step in which this allocation fails; 0: none. */
static furrow_status press_all(struct furrow_world *world, const furrow_body balls[BALLS], uint64_t nth)
{
	struct furrow_state states[BALLS];
	for (int i = 0; i < BALLS; i++)
		states[i] = hosted_state(3 + 1.5 * i, 16, 100.4);
	done(furrow_set_states(world, BALLS, balls, states));
	mem_fail_nth(nth, false);
	const furrow_status status = furrow_step(world, 0);
	mem_fail_nth(0, false);
	return status;
}

static void a_rollback_forgets_contacts_that_wait(void **state)
{
	struct furrow_world *world = hosted_world("waiting.furrow");
	furrow_body balls[BALLS];
	done(furrow_step(world, 0));
	for (int i = 0; i < BALLS; i++)
		balls[i] = hosted_ball(world, 3 + 1.5 * i, 16);
	done(furrow_checkpoint(world));
	uint64_t torn = 0;
	for (uint64_t nth = 1; press_all(world, balls, nth) != FURROW_OK; nth++) {
		if (!world_is_torn(world->world))
			continue;
		torn++;
		done(furrow_rollback(world));
		for (int i = 0; i < BALLS; i++)
			assert_true(point_at(world, 3 + 1.5 * i, 16).offset == 0);
	}
	assert_true(torn > 0);
	assert_true(point_at(world, 3, 16).offset < -0.05);
	done(furrow_world_close(world));
}

/* All whole steps are committed, so that closing it succeeds. */
static void a_world_that_is_torn_when_it_is_closed_has_failed(void **state)
{
	char folder[4000], path[4096];
	snprintf(folder, sizeof folder, "%s", support_path("torn"));
	snprintf(path, sizeof path, "%s/run.json", folder);
	support_store(support_path("torn.furrow"), hosted_extent, hosted_flat);
	struct furrow_open open = hosted_open(ROWS, support_path("torn.furrow"));
	open.output = folder;
	struct furrow_world *world;
	done(furrow_world_open(&open, &world));
	done(furrow_step(world, 0));
	done(furrow_checkpoint(world));
	world_tear(world->world);
	done(furrow_world_close(world));
	char *text = support_text(path);
	assert_non_null(strstr(text, "\"failed\""));
	free(text);
}

/* --- what a view is still to learn --- */

/* A touch names the shape of its body, and a rollback frees bodies that were added since the checkpoint. */
static void a_rollback_forgets_touches_of_bodies_that_go(void **state)
{
	static uint8_t rgb[48][64][3];
	const double half = sqrt(0.5);
	const struct furrow_camera camera = {sizeof camera, {{10, 16, 110}, {half, 0, half, 0}}, 0.8, 64, 48};
	struct furrow_world *world = hosted_world("touches.furrow");
	done(furrow_checkpoint(world));
	const furrow_body ball = hosted_ball(world, 10, 16);
	done(furrow_render(world, &camera, rgb[0][0], NULL));
	hosted_move(world, ball, 10, 16, 100.4);
	hosted_move(world, ball, 10.01, 16, 100.4); /* too little for a contact in the step */
	assert_int_equal(world_happened(world->world)->touch_count, 0);
	point_at(world, 12, 16); /* makes that contact */
	assert_int_equal(world_happened(world->world)->touch_count, 1);
	done(furrow_rollback(world));
	assert_int_equal(world_happened(world->world)->touch_count, 0);
	assert_int_equal(world_happened(world->world)->change_count, 0);
	done(furrow_render(world, &camera, rgb[0][0], NULL));
	done(furrow_world_close(world));
}

TEST_PROGRAM(steps)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_step_that_fails_before_anything_changed_changes_no_later_one),
		cmocka_unit_test(a_contact_on_a_path_has_the_time_of_its_path_sample),
		cmocka_unit_test(a_step_of_too_many_path_samples_is_refused),
		cmocka_unit_test(a_step_whose_rows_have_no_room_is_rolled_back),
		cmocka_unit_test(a_rollback_forgets_contacts_that_wait),
		cmocka_unit_test(a_world_that_is_torn_when_it_is_closed_has_failed),
		cmocka_unit_test(a_rollback_forgets_touches_of_bodies_that_go),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
