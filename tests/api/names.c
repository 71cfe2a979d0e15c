/* Names of bodies, and many of them: the first that is free, gone with the body, back after a rollback. */
#include "hosted.h"
#include "../support/program.h"

#define SCENE "{\"scene\": 1, \"spacing\": 0.25, \"redistribute\": {\"model\": \"box\"}, \"objects\": [" \
	      "{\"name\": \"held\", \"shape\": {\"sphere\": {\"radius\": 0.3}}}]}"

static furrow_body add(struct furrow_world *world, const char *name)
{
	char text[160];
	furrow_body body;
	snprintf(text, sizeof text, "{%s%s%sshape: {sphere: {radius: 0.3}}}", name != NULL ? "name: " : "", name != NULL ? name : "", name != NULL ? ", " : "");
	done(furrow_body_add(world, text, &body));
	return body;
}

static void expect(struct furrow_world *world, const char *name, furrow_body body)
{
	furrow_body found = 0;
	if (body >= 0) {
		done(furrow_body_find(world, name, &found));
		assert_int_equal(found, body);
	} else {
		refused(FURROW_INPUT, furrow_body_find(world, name, &found));
		assert_int_equal(found, -1);
	}
}

static void names_come_and_go_with_bodies(void **state)
{
	struct furrow_world *world = hosted_world_over("names.furrow", SCENE, hosted_flat);
	furrow_body taken;
	expect(world, "held", 0);
	const furrow_body one = add(world, NULL), two = add(world, NULL), four = add(world, "body-4"), three = add(world, NULL), five = add(world, NULL);
	expect(world, "body-1", one);
	expect(world, "body-2", two);
	expect(world, "body-3", three);
	expect(world, "body-4", four);
	expect(world, "body-5", five);
	expect(world, "body-05", -1);
	refused(FURROW_INPUT, furrow_body_add(world, "{name: held, shape: {sphere: {radius: 1}}}", &taken));
	refused(FURROW_INPUT, furrow_body_add(world, "{name: body-3, shape: {sphere: {radius: 1}}}", &taken));
	done(furrow_checkpoint(world));
	done(furrow_body_remove(world, two));
	done(furrow_body_remove(world, four));
	expect(world, "body-2", -1);
	const furrow_body again = add(world, NULL), last = add(world, NULL), sixth = add(world, NULL);
	expect(world, "body-2", again);
	expect(world, "body-4", last);
	expect(world, "body-6", sixth);
	done(furrow_body_remove(world, 0));
	expect(world, "held", -1);
	done(furrow_rollback(world));
	expect(world, "held", 0);
	expect(world, "body-2", two);
	expect(world, "body-4", four);
	expect(world, "body-6", -1);
	misused(furrow_body_remove(world, again));
	expect(world, "body-6", add(world, NULL));
	done(furrow_world_close(world));
}

/* Linear in their number: this takes minutes if each looks at all others. */
static void a_hundred_thousand_bodies_are_added_found_and_removed(void **state)
{
	enum { MANY = 100000, FEW = 4000 };
	struct furrow_world *world = hosted_world_over("many.furrow", SCENE, hosted_flat);
	static furrow_body bodies[MANY];
	for (int i = 0; i < MANY; i++)
		bodies[i] = add(world, NULL);
	for (int i = 0; i < MANY; i += 1000) {
		char name[32];
		snprintf(name, sizeof name, "body-%d", i + 1);
		expect(world, name, bodies[i]);
	}
	/* Those that share tiles are set together, however many they are. */
	static struct furrow_state states[FEW];
	for (int i = 0; i < FEW; i++) {
		states[i] = hosted_state(4 + i % 100 * 0.2, 4 + i / 100 * 0.2, 200);
		done(furrow_place(world, bodies[i], &states[i].pose));
	}
	done(furrow_set_states(world, FEW, bodies, states));
	done(furrow_step(world, 0));
	for (int i = MANY - 1; i >= 0; i--)
		done(furrow_body_remove(world, bodies[i]));
	expect(world, "body-1", -1);
	expect(world, "body-1", add(world, NULL));
	done(furrow_world_close(world));
}

TEST_PROGRAM(names)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(names_come_and_go_with_bodies),
		cmocka_unit_test(a_hundred_thousand_bodies_are_added_found_and_removed),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
