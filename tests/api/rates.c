/* Velocities of a host's bodies that it does not give are those of its poses, and a note tells where both differ by far. */
#include "hosted.h"
#include "../support/program.h"

#define RADIUS 0.5
#define SLIP 0.2
enum { SPEEDS = 3, WAYS = 3, STEPS = 6, BODIES = SPEEDS * WAYS * 2 };

static const char wheel[] = "{shape: {wheel: {radius: 0.5, width: 0.4}}}", box[] = "{shape: {box: {size: [0.5, 0.5, 0.5]}}}";
static const double nothing[3] = {NAN, NAN, NAN};

/* A wheel that has rolled for `seconds`: its heading, and how far it turned about its axle since the start. */
static struct furrow_state rolled(double x, double y, double yaw, double speed, double spin, double seconds)
{
	const double c = cos(yaw / 2), s = sin(yaw / 2), turn = spin * seconds / 2;
	struct furrow_state state = hosted_state(x + speed * seconds * cos(yaw), y + speed * seconds * sin(yaw), 100 + RADIUS - 0.05);
	const double q[4] = {c * cos(turn), -s * sin(turn), c * sin(turn), s * cos(turn)}; /* about z, then about its own y */
	memcpy(state.pose.orientation, q, sizeof q);
	const double linear[3] = {speed * cos(yaw), speed * sin(yaw), 0}, angular[3] = {-spin * sin(yaw), spin * cos(yaw), 0};
	memcpy(state.linear, linear, sizeof linear);
	memcpy(state.angular, angular, sizeof angular);
	return state;
}

static void unknow(struct furrow_state *state)
{
	memcpy(state->linear, nothing, sizeof nothing);
	memcpy(state->angular, nothing, sizeof nothing);
}

/* N along the way. */
static double pull_of(const struct furrow_contact *contact, double yaw)
{
	return contact->force[0] * cos(yaw) + contact->force[1] * sin(yaw);
}

/* Pairs of wheels on the same soil, one with its velocities and one with its poses alone: at three speeds, in three directions. */
static void a_wheel_pulls_the_same_by_its_poses_alone(void **state)
{
	static const double speeds[SPEEDS] = {0.2, 0.6, 1.5}, yaws[WAYS] = {0, 0.9, -2.2}, steps[] = {0.002, 0.01, 0.05};
	for (size_t k = 0; k < sizeof steps / sizeof *steps; k++) {
		struct furrow_world *world = hosted_world("pairs.furrow");
		furrow_body bodies[BODIES];
		struct furrow_state to[BODIES];
		struct furrow_contact contacts[BODIES];
		for (int i = 0; i < BODIES; i++) {
			const struct furrow_state from = rolled(3 + 3 * (i % 9), 4 + 8 * (i / 9), yaws[i % WAYS], 0, 0, 0);
			done(furrow_body_add(world, wheel, &bodies[i]));
			done(furrow_place(world, bodies[i], &from.pose));
		}
		for (int step = 1; step <= STEPS; step++) {
			for (int i = 0; i < BODIES; i++) {
				const double speed = speeds[i % 9 / WAYS], spin = speed / (RADIUS * (1 - SLIP));
				to[i] = rolled(3 + 3 * (i % 9), 4 + 8 * (i / 9), yaws[i % WAYS], speed, spin, step * steps[k]);
				if (i >= 9)
					unknow(&to[i]);
			}
			done(furrow_set_states(world, BODIES, bodies, to));
			done(furrow_step(world, steps[k]));
			done(furrow_get_contacts(world, BODIES, bodies, contacts, sizeof *contacts));
			for (int i = 0; i < 9; i++) {
				const double given = pull_of(&contacts[i], yaws[i % WAYS]), posed = pull_of(&contacts[9 + i], yaws[i % WAYS]);
				assert_true(contacts[i].state != FURROW_AIR && isfinite(posed));
				assert_true(fabs(posed - given) <= 1e-6 * fabs(contacts[i].force[2]));
				/* The closed form of its slip: 1 - v / (w r). */
				assert_true(fabs(contacts[9 + i].slip - SLIP) < 1e-6);
			}
		}
		done(furrow_world_close(world));
	}
}

static void expect(const double got[3], double x, double y, double z)
{
	const double want[3] = {x, y, z};
	for (int k = 0; k < 3; k++)
		assert_true(fabs(got[k] - want[k]) < 1e-9);
}

static void move(struct furrow_world *world, furrow_body body, double x, double seconds)
{
	struct furrow_state to = hosted_state(x, 10, 100.6);
	unknow(&to);
	done(furrow_set_states(world, 1, &body, &to));
	done(furrow_step(world, seconds));
}

static void they_are_those_since_the_last_step(void **state)
{
	struct furrow_world *world = hosted_world("since.furrow");
	furrow_body body;
	struct furrow_state now, to = hosted_state(10.02, 10, 100.6);
	const struct furrow_pose place = hosted_pose(10, 10, 100.6), there = hosted_pose(20, 10, 100.6);
	done(furrow_body_add(world, box, &body));
	done(furrow_place(world, body, &place));
	/* From the place on; of several the last; step(0) is a time_step of 0.01 s. */
	unknow(&to);
	done(furrow_set_states(world, 1, &body, &to));
	move(world, body, 10.01, 0);
	done(furrow_get_states(world, 1, &body, &now));
	expect(now.linear, 1, 0, 0);
	expect(now.angular, 0, 0, 0);
	done(furrow_checkpoint(world));
	/* Who is not set does not move. */
	done(furrow_step(world, 0));
	done(furrow_get_states(world, 1, &body, &now));
	expect(now.linear, 0, 0, 0);
	/* From the checkpoint on, after a rollback. */
	move(world, body, 11, 0.5);
	done(furrow_rollback(world));
	move(world, body, 10.03, 0.01);
	done(furrow_get_states(world, 1, &body, &now));
	expect(now.linear, 2, 0, 0);
	/* From a new place on, not from the old one. */
	done(furrow_place(world, body, &there));
	done(furrow_get_states(world, 1, &body, &now));
	expect(now.linear, 0, 0, 0);
	move(world, body, 20.03, 0.01);
	done(furrow_get_states(world, 1, &body, &now));
	expect(now.linear, 3, 0, 0);
	/* One of the two may be given; turned by 0.2 rad about z in 0.1 s. */
	to = hosted_state(20.03, 10, 100.6);
	to.pose.orientation[0] = cos(0.1);
	to.pose.orientation[3] = sin(0.1);
	memcpy(to.angular, nothing, sizeof nothing);
	to.linear[2] = 7;
	done(furrow_set_states(world, 1, &body, &to));
	done(furrow_step(world, 0.1));
	done(furrow_get_states(world, 1, &body, &now));
	expect(now.linear, 0, 0, 7);
	expect(now.angular, 0, 0, 2);
	to.linear[1] = (double)NAN;
	misused(furrow_set_states(world, 1, &body, &to));
	to.linear[1] = (double)INFINITY;
	misused(furrow_set_states(world, 1, &body, &to));
	done(furrow_world_close(world));
}

/* A probe of poses alone is that of a step of time_step. */
static void a_probe_takes_them_from_the_poses(void **state)
{
	struct furrow_world *world = hosted_world("probe.furrow");
	furrow_body body;
	struct furrow_contact given, posed;
	struct furrow_state to = rolled(10, 10, 0.5, 0, 0, 0);
	done(furrow_body_add(world, wheel, &body));
	done(furrow_place(world, body, &to.pose));
	done(furrow_set_states(world, 1, &body, &to));
	done(furrow_step(world, 0));
	to = rolled(10, 10, 0.5, 0.5, 1.25, 0.01);
	done(furrow_probe(world, 1, &body, &to, &given, sizeof given));
	unknow(&to);
	done(furrow_probe(world, 1, &body, &to, &posed, sizeof posed));
	for (int k = 0; k < 3; k++)
		assert_true(fabs(given.force[k] - posed.force[k]) < 1e-6 * given.force[2]);
	assert_true(fabs(posed.slip - SLIP) < 1e-6);
	done(furrow_world_close(world));
}

static int told;
static char last[512];

static void listen(int level, const char *message, void *user)
{
	told++;
	snprintf(last, sizeof last, "%s", message);
}

static void velocities_that_contradict_the_poses_are_told_once(void **state)
{
	struct furrow_world *world = hosted_world("notes.furrow");
	furrow_body bodies[4]; /* 0: as it says; 1: at rest, it says; 2: turns by more than half a turn; 3: a wheel that nobody turns */
	for (int i = 0; i < 4; i++) {
		const struct furrow_state from = rolled(10, 4 + 4 * i, 0, 0, 0, 0);
		done(furrow_body_add(world, i == 3 ? wheel : box, &bodies[i]));
		done(furrow_place(world, bodies[i], &from.pose));
	}
	furrow_set_log(listen, NULL);
	told = 0;
	for (int step = 1; step <= 8; step++) {
		struct furrow_state to[4];
		for (int i = 0; i < 4; i++)
			to[i] = rolled(10, 4 + 4 * i, 0, 0.5, i == 2 ? 280 : i == 3 ? 0 : 1, step * 0.01);
		memset(to[1].linear, 0, sizeof to[1].linear);
		memcpy(to[2].angular, nothing, sizeof nothing);
		to[3].angular[1] = 1;
		if (step == 1) /* an impact: its poses and its velocity differ in one step */
			to[0].linear[0] = 0;
		done(furrow_set_states(world, 4, bodies, to));
		done(furrow_step(world, 0.01));
		if (step == 1) {
			assert_int_equal(told, 1);
			assert_non_null(strstr(last, "body-3: its poses turn by"));
		}
		if (step == 3) {
			assert_int_equal(told, 2);
			assert_non_null(strstr(last, "body-2: its linear velocity is given as 0 m/s, and its poses move at 0.5 m/s"));
		}
	}
	assert_int_equal(told, 2);
	furrow_set_log(NULL, NULL);
	done(furrow_world_close(world));
}

TEST_PROGRAM(rates)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_wheel_pulls_the_same_by_its_poses_alone),
		cmocka_unit_test(they_are_those_since_the_last_step),
		cmocka_unit_test(a_probe_takes_them_from_the_poses),
		cmocka_unit_test(velocities_that_contradict_the_poses_are_told_once),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
