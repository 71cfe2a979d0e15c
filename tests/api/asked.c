/* What a host asks beside the scene: settings and advice of an opening, the measures of a shape, and the pull of a belt on a path. */
#include <math.h>
#include <stddef.h>

#include "hosted.h"
#include "../support/program.h"

#define TRACK_SCENE \
	"{scene: 1, time_step: 0.1, spacing: 0.125, soil: {name: dry_sand}, redistribute: {model: scm}, objects: [" \
	"{name: track, shape: {box: {size: [1.6, 0.5, 0.3], belt: true}}, load: 3000, slip: 0.2, path: {points: [[8, 8], [12, 8]], speed: 1}}, " \
	"{name: ball, shape: {sphere: {radius: 0.5}}, load: 1000, path: {points: [[8, 16], [12, 16]], speed: 1}}]}"

static struct heard {
	int all, wanted;
	const char *text; /* part of the note that is waited for */
} heard;

static void listen(int level, const char *message, void *user)
{
	heard.all++;
	heard.wanted += strstr(message, heard.text) != NULL;
}

static void settings_are_those_of_the_scene(void **state)
{
	struct furrow_world *world = NULL;
	struct furrow_info info = {.size = sizeof info};
	const char *store = support_path("settings.furrow");
	support_store(store, hosted_extent, hosted_flat);
	struct furrow_open open = hosted_open(HOSTED_SCENE, store);
	open.settings = "gravity=3.7\ntime_step=0.25\n";
	done(furrow_world_open(&open, &world));
	done(furrow_info(world, &info));
	assert_true(info.gravity == 3.7 && info.time_step == 0.25);
	done(furrow_world_close(world));

	open.settings = "gravity";
	misused(furrow_world_open(&open, &world));
	assert_non_null(strstr(furrow_last_error(), "gravity"));
	open.settings = "=3";
	misused(furrow_world_open(&open, &world));
	open.settings = "no_such_key=3";
	refused(FURROW_INPUT, furrow_world_open(&open, &world));
	open.size = offsetof(struct furrow_open, settings); /* a host that was built before them */
	done(furrow_world_open(&open, &world));
	done(furrow_world_close(world));
}

/* Opens the world of a ball that is too narrow for its posts, and counts the notes on that. */
static int notes_of(bool advise)
{
	struct furrow_world *world = NULL;
	const char *store = support_path("advice.furrow");
	support_store(store, hosted_extent, hosted_flat);
	struct furrow_open open = hosted_open("{scene: 1, time_step: 0.1, spacing: 0.25, soil: {name: dry_sand}, redistribute: {model: scm}, objects: ["
					      "{name: ball, shape: {sphere: {radius: 0.05}}, load: 10, path: {points: [[8, 8], [12, 8]], speed: 1}}]}", store);
	heard = (struct heard){.text = "objects.ball.shape: "};
	open.advise = advise;
	furrow_set_log(listen, NULL);
	done(furrow_world_open(&open, &world));
	furrow_set_log(NULL, NULL);
	done(furrow_world_close(world));
	return heard.wanted;
}

static void advice_is_told_who_asks(void **state)
{
	assert_int_equal(notes_of(false), 0);
	assert_true(notes_of(true) > 0);
}

static void a_shape_has_measures(void **state)
{
	struct furrow_shape shape = {.size = sizeof shape};
	done(furrow_measure("{shape: {wheel: {radius: 0.25, width: 0.1}}}", &shape));
	assert_true(shape.radius == 0.25 && shape.width == 0.1 && !shape.belt);
	assert_true(fabs(shape.bound - hypot(0.25, 0.05)) < 1e-3);
	done(furrow_measure("{shape: {box: {size: [1.6, 0.5, 0.3], belt: true}}}", &shape));
	assert_true(isnan(shape.radius) && isnan(shape.width) && shape.belt);
	assert_true(shape.bound >= hypot(hypot(0.8, 0.25), 0.15) - 1e-6);
	const struct furrow_shape before = shape;
	refused(FURROW_INPUT, furrow_measure("{shape: {cube: 1}}", &shape));
	misused(furrow_measure(NULL, &shape));
	misused(furrow_measure(HOSTED_BALL, NULL));
	shape.size = 0;
	misused(furrow_measure(HOSTED_BALL, &shape));
	assert_true(shape.bound == before.bound);
}

static void a_belt_on_a_path_tells_its_pull(void **state)
{
	struct furrow_world *world = hosted_world_over("pull.furrow", TRACK_SCENE, hosted_flat);
	const furrow_body bodies[] = {0, 1};
	struct furrow_contact contacts[2];
	unsigned char old[2 * sizeof *contacts];
	const size_t first = offsetof(struct furrow_contact, pull);
	for (int i = 0; i < 20; i++)
		done(furrow_step(world, 0));
	done(furrow_get_contacts(world, 2, bodies, contacts, sizeof *contacts));
	assert_true(contacts[0].pull > 0 && contacts[0].pull < 3000);
	assert_true(isnan(contacts[1].pull) && contacts[1].force[2] > 0);
	/* A host that was built before it has shorter entries, one behind the other. */
	memset(old, 0xa5, sizeof old);
	done(furrow_get_contacts(world, 2, bodies, (struct furrow_contact *)old, first));
	assert_memory_equal(old, &contacts[0], offsetof(struct furrow_contact, slip));
	assert_memory_equal(old + first, &contacts[1], offsetof(struct furrow_contact, slip));
	assert_int_equal(old[2 * first], 0xa5);
	misused(furrow_get_contacts(world, 2, bodies, contacts, first - sizeof(double)));
	done(furrow_world_close(world));
}

TEST_PROGRAM(asked)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(settings_are_those_of_the_scene),
		cmocka_unit_test(advice_is_told_who_asks),
		cmocka_unit_test(a_shape_has_measures),
		cmocka_unit_test(a_belt_on_a_path_tells_its_pull),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
