/*
 * A plate that a host drags over the soil and turns back. Its shear goes over along Janosi's curve, in rows of any length: no row jumps.
 * So does the pull of a wheel with a load. There the ground is as the wheel left it, so a contact changes little of what the next probe tells.
 */
#include "../support/near.h"
#include "../support/program.h"
#include "probing.h"

#define LENGTH 0.3 /* m: of the plate along its way */
#define MODULUS 0.02 /* m: of shear, of dry sand */
#define WAY 0.25 /* m: before it turns back */
#define BACK 0.04

/* Returns the pull, as a share of the strength, when the plate went back by a way. A place at u from its front had been sheared over u. Since it turned
 * back it is sheared the other way, and at its rear it comes onto soil that holds no shear. */
static double janosi(double back)
{
	const double k = MODULUS, l = LENGTH, e = exp(-back / k), stays = e * (2 * (l - back) - k * (e - exp(-l / k))) - (l - back);
	return (stays - (back - k * (1 - e))) / l;
}

/* Slip digs nothing, and nothing is laid. Soil bears from below alone, as the curve has it. */
static struct furrow_world *open_world(double spacing, double seconds)
{
	char scene[300];
	struct furrow_world *world = NULL;
	const char *store = support_path("plate.furrow");
	snprintf(scene, sizeof scene,
		 "{scene: 1, time_step: %g, spacing: %g, soil: {name: dry_sand, damping: 0}, redistribute: {model: scm, slip_sinkage: 0, bulldozing: 0, faces: off}, cache: {slots: 64}}",
		 seconds, spacing);
	support_store(store, probing_extent, hosted_flat);
	const struct furrow_open open = hosted_open(scene, store);
	done(furrow_world_open(&open, &world));
	assert_non_null(world);
	return world;
}

/* Drags the plate there and back at one depth. *off: by how much its pull is off the curve at most, as a share of the strength. *jump: how many times as
 * much it changes in a row as the curve does over the first of these rows. */
static void drag_back(double spacing, double row, double *off, double *jump)
{
	struct furrow_world *world = open_world(spacing, row / 0.25);
	const int there = (int)lround(WAY / row), rows = there + (int)lround(BACK / row);
	const double stress = (0.99e3 / 0.2 + 1528.43e3) * pow(0.02, 1.1), strength = (1.04e3 + stress * tan(28 * DEGREES)) * LENGTH * 0.2;
	struct furrow_state at = hosted_state(20.013, 20.007, 100.1);
	double before = janosi(0);
	furrow_body body;
	done(furrow_body_add(world, "{shape: {box: {size: [0.3, 0.2, 0.2]}}}", &body));
	done(furrow_place(world, body, &at.pose));
	at.pose.position[2] = 100.08;
	*off = *jump = 0;
	for (int i = 0; i < rows; i++) {
		const double way = i < there ? 1 : -1, back = (i + 1 - there) * row;
		struct furrow_contact told;
		at.linear[0] = 0.25 * way;
		at.pose.position[0] += row * way;
		const struct furrow_contact probed = probing_ask(world, body, &at);
		probing_step(world, body, &at, row / 0.25);
		done(furrow_get_contacts(world, 1, &body, &told, sizeof told));
		if (i == there)
			assert_near(probed.force[0], told.force[0], 1e-3 * strength);
		const double share = -told.force[0] / strength;
		if (i >= there) {
			const double changes = janosi(0) - janosi(row); /* where the curve is steepest */
			*off = support_most(*off, fabs(share - janosi(back)));
			*jump = support_most(*jump, fabs(share - before) / changes);
		}
		before = share;
	}
	done(furrow_world_close(world));
}

static void a_plate_that_turns_back_follows_janosis_curve(void **state)
{
	static const double spacings[] = {0.03125, 0.015625, 0.0078125}, rows[] = {0.005, 0.00125};
	(void)state;
	for (int i = 0; i < 6; i++) {
		double off, jump;
		drag_back(spacings[i / 2], rows[i % 2], &off, &jump);
		print_message("posts %g m, rows of %g mm: off by up to %.2f %% of the strength; a row changes by up to %.2f times what the curve does at its steepest\n", spacings[i / 2], rows[i % 2] * 1e3,
			      100 * off, jump);
		assert_true(off < (spacings[i / 2] > 0.03 ? 0.15 : 0.05) && jump < 1.1);
	}
}

#define LOAD 500.0 /* N */
#define RADIUS 0.3 /* m */

/* Sets the height at which the soil bears the load. */
static void settle(struct furrow_world *world, furrow_body body, struct furrow_state *at)
{
	double low = at->pose.position[2] - 0.01, high = at->pose.position[2] + 0.01;
	for (int i = 0; i < 30; i++) {
		at->pose.position[2] = 0.5 * (low + high);
		*(probing_ask(world, body, at).force[2] > LOAD ? &low : &high) = at->pose.position[2];
	}
}

struct jumps {
	double pull, told, after; /* N, at most: from row to row; step and probe before it; step and probe after it */
};

/* A wheel rolls there and back under its load, with a slip of 0.2, in rows of 5 mm. turned: its host turns its poses too. */
static struct jumps roll_back(double spacing, bool turned)
{
	struct furrow_world *world = NULL;
	char scene[200];
	const char *store = support_path("wheel.furrow");
	const double row = 0.005, axle[3] = {0, 1, 0};
	snprintf(scene, sizeof scene, "{scene: 1, time_step: 0.02, spacing: %g, soil: {name: dry_sand}, redistribute: {model: scm}, cache: {slots: 64}}", spacing);
	support_store(store, probing_extent, hosted_flat);
	const struct furrow_open open = hosted_open(scene, store);
	done(furrow_world_open(&open, &world));
	assert_non_null(world);
	struct furrow_state at = hosted_state(20.013, 20.007, 100 + RADIUS);
	struct jumps jumps = {0};
	double before = NAN;
	furrow_body body;
	done(furrow_body_add(world, "{shape: {wheel: {radius: 0.3, width: 0.2}}}", &body));
	done(furrow_place(world, body, &at.pose));
	for (int i = 0; i < 100; i++) {
		const double way = i < 60 ? row : -row, turn = way / (0.8 * RADIUS);
		struct furrow_contact told;
		at.pose.position[0] += way;
		at.linear[0] = way / 0.02;
		at.angular[1] = turn / 0.02;
		if (turned)
			probing_turn(axle, turn, at.pose.orientation);
		settle(world, body, &at);
		const struct furrow_contact probed = probing_ask(world, body, &at);
		probing_step(world, body, &at, 0.02);
		done(furrow_get_contacts(world, 1, &body, &told, sizeof told));
		const struct furrow_contact after = probing_ask(world, body, &at);
		if (i >= 55) {
			jumps.pull = support_most(jumps.pull, fabs(told.force[0] - before));
			jumps.told = support_most(jumps.told, fabs(told.force[2] - probed.force[2]));
			jumps.after = support_most(jumps.after, fabs(told.force[2] - after.force[2]));
		}
		before = told.force[0];
	}
	done(furrow_world_close(world));
	return jumps;
}

static void a_wheel_that_turns_back_pulls_less_by_and_by(void **state)
{
	static const double spacings[] = {0.03125, 0.015625, 0.0078125}, told[] = {90, 30, 13}, after[] = {100, 80, 50}; /* N */
	(void)state;
	for (int i = 0; i < 6; i++) {
		const struct jumps jumps = roll_back(spacings[i / 2], i % 2);
		print_message("posts %g m%s: its pull changes by up to %.1f N from row to row; a step differs by up to %.2f N from the probe before it, %.1f N after it\n", spacings[i / 2],
			      i % 2 ? ", poses turn" : "", jumps.pull, jumps.told, jumps.after);
		assert_true(jumps.pull < 40);
		assert_true(jumps.told < told[i / 2] && jumps.after < after[i / 2]);
	}
}

TEST_PROGRAM(reversal)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_plate_that_turns_back_follows_janosis_curve),
		cmocka_unit_test(a_wheel_that_turns_back_pulls_less_by_and_by),
	};
	return cmocka_run_group_tests_name("api/reversal", tests, support_enter, support_leave);
}
