/*
 * What furrow_probe tells of a state is what the step tells when the body is set there: law 13. Bodies with a load slide, yaw and roll. So they sink, rise
 * and leave dips, and contacts are due at any time.
 */
#include "../support/near.h"
#include "../support/program.h"
#include "probing.h"

#define LOAD 500.0 /* N */
#define SECONDS 0.016

struct motion {
	const char *name, *shape;
	double reach;                 /* m */
	double linear[3], angular[3]; /* m/s, rad/s */
	double off;                   /* of the load: a contact that ends in this step differs from the probe by its own steps */
};

/* Returns by how much the step and the probe before it differ at most, as a share of the load. */
static double off_of(const struct motion *motion, double spacing)
{
	struct furrow_world *world = NULL;
	struct furrow_state at = hosted_state(20.013, 20.007, 100 + motion->reach);
	char scene[200];
	double off = 0;
	furrow_body body;
	const char *store = support_path("told.furrow");
	snprintf(scene, sizeof scene, "{scene: 1, time_step: %g, spacing: %g, soil: {name: dry_sand}, redistribute: {model: scm}, cache: {slots: 64}}", SECONDS, spacing);
	support_store(store, probing_extent, hosted_flat);
	const struct furrow_open open = hosted_open(scene, store);
	done(furrow_world_open(&open, &world));
	assert_non_null(world);
	done(furrow_body_add(world, motion->shape, &body));
	done(furrow_place(world, body, &at.pose));
	memcpy(at.linear, motion->linear, sizeof at.linear);
	memcpy(at.angular, motion->angular, sizeof at.angular);
	for (int i = 0; i < 60; i++) {
		struct furrow_contact told;
		for (int k = 0; k < 3; k++) {
			const double axis[3] = {k == 0, k == 1, k == 2};
			at.pose.position[k] += motion->linear[k] * SECONDS;
			probing_turn(axis, motion->angular[k] * SECONDS, at.pose.orientation);
		}
		double low = at.pose.position[2] - 0.01, high = at.pose.position[2] + 0.01;
		for (int n = 0; n < 30; n++) {
			at.pose.position[2] = 0.5 * (low + high);
			*(probing_ask(world, body, &at).force[2] > LOAD ? &low : &high) = at.pose.position[2];
		}
		const struct furrow_contact probed = probing_ask(world, body, &at);
		probing_step(world, body, &at, SECONDS);
		done(furrow_get_contacts(world, 1, &body, &told, sizeof told));
		for (int k = 0; k < 3; k++)
			off = support_most(off, fabs(told.force[k] - probed.force[k]) / LOAD);
	}
	done(furrow_world_close(world));
	return off;
}

static void a_step_tells_what_the_probe_before_it_told(void **state)
{
	static const struct motion motions[] = {
		{"a wheel that slides aside", "{shape: {wheel: {radius: 0.3, width: 0.2}}}", 0.3, {0, 0.25, 0}, {0, 0, 0}, 0.01},
		{"a wheel that slips", "{shape: {wheel: {radius: 0.3, width: 0.2}}}", 0.3, {0.25, 0, 0}, {0, 1.04, 0}, 0.01},
		{"a wheel that is locked", "{shape: {wheel: {radius: 0.3, width: 0.2}}}", 0.3, {0.25, 0, 0}, {0, 0, 0}, 0.03},
		{"a ball that rolls", probing_ball, 0.25, {0.25, 0, 0}, {0, 1, 0}, 0.01},
		{"a box that yaws", probing_box, 0.1, {0, 0, 0}, {0, 0, 1}, 0.015},
		{"a box that slides", probing_box, 0.1, {0.25, 0, 0}, {0, 0, 0}, 0.08}, /* known: it turns back by rounding, and its force steps there */
	};
	(void)state;
	for (int i = 0; i < 6; i++)
		for (int k = 0; k < 2; k++) {
			const double off = off_of(&motions[i], 0.03125 / (1 << k));
			print_message("posts %g m, %s: off by at most %.2f %% of the load\n", 0.03125 / (1 << k), motions[i].name, 100 * off);
			assert_true(off < motions[i].off);
		}
}

TEST_PROGRAM(told)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_step_tells_what_the_probe_before_it_told),
	};
	return cmocka_run_group_tests_name("api/told", tests, support_enter, support_leave);
}
