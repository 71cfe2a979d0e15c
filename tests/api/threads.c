/* Several worlds on several threads at once; under ThreadSanitizer, too. */
#include "hosted.h"
#include "../support/program.h"
#include "../support/skip.h"

#include <pthread.h>
#include <stdatomic.h>

#define WORLDS 2
#define STEPS 20

/* One thread's world. Checks come when it has ended: cmocka belongs to the main thread. */
struct life {
	const char *store;
	struct furrow_world *world; /* NULL: the thread opens and closes one */
	double y;
	furrow_status status;
	char message[512];
	double offset;
};

static furrow_status live(struct life *life, struct furrow_world *world)
{
	furrow_body ball;
	const struct furrow_pose pose = hosted_pose(10, life->y, 100.5);
	furrow_status status = furrow_body_add(world, HOSTED_BALL, &ball);
	if (status == FURROW_OK)
		status = furrow_place(world, ball, &pose);
	for (int i = 0; i < STEPS && status == FURROW_OK; i++) {
		const struct furrow_state body_state = hosted_state(10 + 0.1 * i, life->y, 100.4);
		struct furrow_contact contact;
		status = furrow_set_states(world, 1, &ball, &body_state);
		if (status == FURROW_OK)
			status = furrow_step(world, 0);
		if (status == FURROW_OK)
			status = furrow_get_contacts(world, 1, &ball, &contact, sizeof contact);
		if (status == FURROW_OK && i == STEPS / 2)
			status = furrow_checkpoint(world);
	}
	const double xy[2] = {11, life->y};
	struct furrow_point point;
	if (status == FURROW_OK)
		status = furrow_points(world, 1, xy, &point);
	if (status == FURROW_OK)
		life->offset = point.offset;
	return status;
}

static void *run(void *user)
{
	struct life *life = user;
	struct furrow_world *world = life->world;
	const struct furrow_open open = hosted_open(HOSTED_SCENE, life->store);
	life->status = world != NULL ? FURROW_OK : furrow_world_open(&open, &world);
	if (life->status == FURROW_OK)
		life->status = live(life, world);
	snprintf(life->message, sizeof life->message, "%s", furrow_last_error());
	if (life->world == NULL && world != NULL && furrow_world_close(world) != FURROW_OK)
		life->status = FURROW_FAILED;
	return NULL;
}

static void ended(const struct life *life)
{
	if (life->status == FURROW_NO_GL)
		skip_since("no GL");
	if (life->status != FURROW_OK)
		print_error("%s\n", life->message);
	assert_int_equal(life->status, FURROW_OK);
	assert_true(life->offset < -0.05);
}

static _Atomic int notes;

static void count_note(int level, const char *message, void *user)
{
	atomic_fetch_add(&notes, 1);
}

static void two_worlds_on_two_threads_do_as_they_would_alone(void **state)
{
	struct life lives[WORLDS] = {{.store = support_path("a.furrow"), .y = 10}, {.store = support_path("b.furrow"), .y = 20}};
	uint64_t alone[WORLDS];
	pthread_t threads[WORLDS];
	for (int i = 0; i < WORLDS; i++) {
		support_store(lives[i].store, hosted_extent, hosted_flat);
		run(&lives[i]);
		ended(&lives[i]);
		alone[i] = support_hash(lives[i].store);
		support_store(lives[i].store, hosted_extent, hosted_flat);
	}
	assert_true(alone[0] != alone[1]);
	for (int i = 0; i < WORLDS; i++)
		assert_int_equal(pthread_create(&threads[i], NULL, run, &lives[i]), 0);
	for (int i = 0; i < 50; i++) { /* meanwhile the log comes and goes */
		furrow_set_log(i % 2 == 0 ? count_note : NULL, NULL);
		usleep(2000);
	}
	furrow_set_log(NULL, NULL);
	for (int i = 0; i < WORLDS; i++)
		assert_int_equal(pthread_join(threads[i], NULL), 0);
	for (int i = 0; i < WORLDS; i++) {
		ended(&lives[i]);
		assert_true(support_hash(lives[i].store) == alone[i]);
	}
}

static void a_world_goes_from_thread_to_thread(void **state)
{
	struct life life = {.store = "", .world = hosted_world("passed.furrow"), .y = 16};
	pthread_t thread;
	assert_int_equal(pthread_create(&thread, NULL, run, &life), 0);
	assert_int_equal(pthread_join(thread, NULL), 0);
	ended(&life);
	done(furrow_step(life.world, 0));
	done(furrow_world_close(life.world));
}

static void *fail_here(void *user)
{
	furrow_step(NULL, 0);
	snprintf(user, 512, "%s", furrow_last_error());
	return NULL;
}

static void a_message_is_of_its_thread(void **state)
{
	char there[512] = "";
	pthread_t thread;
	struct furrow_world *world = NULL;
	misused(furrow_world_open(NULL, &world));
	char here[512];
	snprintf(here, sizeof here, "%s", furrow_last_error());
	assert_int_equal(pthread_create(&thread, NULL, fail_here, there), 0);
	assert_int_equal(pthread_join(thread, NULL), 0);
	assert_string_equal(furrow_last_error(), here);
	assert_string_not_equal(there, here);
	assert_true(strlen(there) > 0);
}

TEST_PROGRAM(threads)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_message_is_of_its_thread),
		cmocka_unit_test(a_world_goes_from_thread_to_thread),
		cmocka_unit_test(two_worlds_on_two_threads_do_as_they_would_alone),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
