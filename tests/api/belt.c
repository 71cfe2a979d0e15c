/* A host's body with a belt: it moves as the host says, its belt runs as furrow_set_belts says, and the soil draws it. */
#include <math.h>

#include "hosted.h"
#include "../support/program.h"

#define SCENE                                                                                                            \
	"{scene: 1, time_step: 0.01, spacing: 0.0625, soil: {name: dry_sand}, redistribute: {model: scm, bulldozing: 0, " \
	"slip_sinkage: 0}, cache: {slots: 64}}"
#define TRACK "{shape: {box: {size: [1.2, 0.3, 0.5], belt: true}}}"

static const double length = 1.2, width = 0.3, speed = 0.5; /* m, m, m/s */
static const double cohesion = 1040, friction = 28 * M_PI / 180, modulus = 0.02; /* dry_sand */


static struct furrow_state state_at(double way, double yaw)
{
	struct furrow_state state = hosted_state(8 + way * cos(yaw), 8 + way * sin(yaw), 100.22);
	state.pose.orientation[0] = cos(yaw / 2);
	state.pose.orientation[3] = sin(yaw / 2);
	state.linear[0] = speed * cos(yaw);
	state.linear[1] = speed * sin(yaw);
	return state;
}

/* Goes on in steps, and tells the contact of the last. *belt: m that the belt has run so far, and how fast it runs. */
static struct furrow_contact go(struct furrow_world *world, furrow_body track, double yaw, double from, double to, double step,
				struct furrow_belt *belt)
{
	struct furrow_contact contact, probed;
	const int steps = (int)lround((to - from) / (speed * step));
	const double travel = belt->travel;
	done(furrow_set_belts(world, 1, &track, belt));
	for (int i = 1; i <= steps; i++) {
		const struct furrow_state state = state_at(from + i * speed * step, yaw);
		belt->travel = travel + i * belt->speed * step;
		done(furrow_set_belts(world, 1, &track, belt));
		if (i == steps)
			done(furrow_probe(world, 1, &track, &state, &probed, sizeof probed));
		done(furrow_set_states(world, 1, &track, &state));
		done(furrow_step(world, step));
	}
	done(furrow_get_contacts(world, 1, &track, &contact, sizeof contact));
	/* A probe of that state told as much before. Longer steps make several contacts. */
	for (int k = 0; k < 3 && speed * step < 0.0625; k++)
		if (!(fabs(probed.force[k] - contact.force[k]) < 0.006 * contact.force[2]))
			fail_msg("force %d: %g N, by a probe %g", k, contact.force[k], probed.force[k]);
	assert_true(isnan(contact.slip) ? isnan(probed.slip) : fabs(probed.slip - contact.slip) < 1e-9);
	return contact;
}

static furrow_body put_track(struct furrow_world *world, double yaw)
{
	furrow_body track = -1;
	const struct furrow_state at = state_at(0, yaw);
	done(furrow_body_add(world, TRACK, &track));
	done(furrow_place(world, track, &at.pose));
	done(furrow_step(world, 0));
	return track;
}

static double along(const struct furrow_contact *contact, double yaw)
{
	return contact->force[0] * cos(yaw) + contact->force[1] * sin(yaw);
}

/* As tests/bearing/belt.c; here in steps that are shorter than a post, and longer. */
static void a_belt_draws_at_every_step(void **state)
{
	static const double slips[] = {0.1, 0.3, 0.5}, steps[] = {0.01, 0.04, 0.25}, yaws[] = {0, 0.3, 0.8};
	(void)state;
	for (int k = 0; k < 9; k++) {
		const double slip = slips[k % 3], yaw = yaws[(k + k / 3) % 3];
		struct furrow_belt belt = {3, speed / (1 - slip)};
		struct furrow_world *world = hosted_world_over("belt.furrow", SCENE, hosted_flat);
		const furrow_body track = put_track(world, yaw);
		struct furrow_contact contact;
		contact = go(world, track, yaw, 0, 1.75, steps[k / 3], &belt);
		const double strength = length * width * cohesion + contact.force[2] * tan(friction);
		const double wanted = strength * (1 - modulus / (slip * length) * (1 - exp(-slip * length / modulus)));
		print_message("steps of %g s, slip %g: %.1f N for %.1f\n", steps[k / 3], slip, along(&contact, yaw), wanted);
		assert_int_equal(contact.state, FURROW_TOUCHING);
		assert_true(fabs(contact.slip - slip) < 1e-9);
		if (!(fabs(along(&contact, yaw) / wanted - 1) < 0.01))
			fail_msg("steps of %g s, slip %g, yaw %g: %g N, wanted %g", steps[k / 3], slip, yaw, along(&contact, yaw), wanted);
		done(furrow_world_close(world));
	}
}

/* A belt that stays where it is is dragged, one that runs as the body goes is not felt, and one that runs backwards brakes. */
static void a_belt_runs_as_it_is_told(void **state)
{
	struct furrow_belt belt = {0, 0};
	struct furrow_contact contact;
	(void)state;
	struct furrow_world *world = hosted_world_over("belt.furrow", SCENE, hosted_flat);
	const furrow_body track = put_track(world, 0);
	contact = go(world, track, 0, 0, 1.5, 0.05, &belt);
	assert_true(contact.force[0] < -0.5 * contact.force[2] * tan(friction) && isnan(contact.slip));
	belt.speed = speed / 0.7;
	contact = go(world, track, 0, 1.5, 3, 0.05, &belt);
	assert_true(contact.force[0] > 0.5 * contact.force[2] * tan(friction));
	belt.speed = speed;
	contact = go(world, track, 0, 3, 5, 0.05, &belt);
	assert_true(fabs(contact.force[0]) < 2e-3 * contact.force[2] && fabs(contact.slip) < 1e-12);
	belt.speed = -speed;
	contact = go(world, track, 0, 5, 6.5, 0.05, &belt);
	assert_true(contact.force[0] < -0.5 * contact.force[2] * tan(friction) && fabs(contact.slip - 2) < 1e-9);
	done(furrow_world_close(world));
}

/* What a checkpoint had is back: how far the belt had run, and the shear below it. */
static void a_rollback_leaves_the_belt_as_it_was(void **state)
{
	struct furrow_belt belt = {0, speed / 0.8};
	struct furrow_contact first, second;
	(void)state;
	struct furrow_world *world = hosted_world_over("belt.furrow", SCENE, hosted_flat);
	const furrow_body track = put_track(world, 0.3);
	go(world, track, 0.3, 0, 1, 0.02, &belt);
	done(furrow_checkpoint(world));
	const struct furrow_belt then = belt;
	first = go(world, track, 0.3, 1, 2, 0.02, &belt);
	done(furrow_rollback(world));
	belt = then;
	second = go(world, track, 0.3, 1, 2, 0.02, &belt);
	assert_memory_equal(first.force, second.force, sizeof first.force);
	assert_memory_equal(first.moment, second.moment, sizeof first.moment);
	assert_true(first.slip == second.slip);
	done(furrow_world_close(world));
}

TEST_PROGRAM(belt)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_belt_draws_at_every_step),
		cmocka_unit_test(a_belt_runs_as_it_is_told),
		cmocka_unit_test(a_rollback_leaves_the_belt_as_it_was),
	};
	return cmocka_run_group_tests_name("api/belt", tests, support_enter, support_leave);
}
