/*
 * Bodies that a host moves up and down. Soil gives back no more than its elastic energy, at every spacing and for rows of every length. And a
 * host that integrates implicitly, by a probe's stiffness, stops a falling ball as deep as one that takes short steps.
 */
#include "../support/near.h"
#include "../support/program.h"
#include "probing.h"

static const char box[] = "{shape: {box: {size: [0.3, 0.3, 0.3]}}}", ball[] = "{shape: {sphere: {radius: 0.15}}}";

/* Moves the box straight up or down, and returns the work of the soil on it, J: told by contacts, and by probes before each step. */
static void move(struct furrow_world *world, furrow_body body, double *z, double to, int steps, double *force, double work[2])
{
	const double by = (to - *z) / steps;
	double probed_before = *force;
	for (int i = 0; i < steps; i++) {
		struct furrow_contact told;
		struct furrow_state state = hosted_state(20.013, 20.007, *z + by);
		const struct furrow_contact probed = probing_ask(world, body, &state);
		probing_step(world, body, &state, 0.01);
		done(furrow_get_contacts(world, 1, &body, &told, sizeof told));
		work[0] += 0.5 * (*force + told.force[2]) * by;
		work[1] += 0.5 * (probed_before + probed.force[2]) * by;
		*force = told.force[2];
		probed_before = probed.force[2];
		*z += by;
	}
}

static void a_raised_box_gives_back_the_elastic_energy(void **state)
{
	static const double spacings[] = {0.0625, 0.03125, 0.015625};
	const double most = (0.99e3 / 0.3 + 1528.43e3) * pow(0.05, 1.1) * 0.09, elastic = most * most / (2 * 4e7 * 0.09);
	for (int i = 0; i < 3; i++)
		for (int few = 0; few < 2; few++) {
			const struct probing_ground ground = {"raised.furrow", "dry_sand, damping: 0", spacings[i], 0, 100, 0, 0, true};
			struct furrow_world *world = probing_world(&ground);
			furrow_body body;
			double z = 100.151, force = 0, pressed[2] = {0, 0}, back[2] = {0, 0};
			done(furrow_body_add(world, box, &body));
			const struct furrow_state start = hosted_state(20.013, 20.007, z);
			done(furrow_place(world, body, &start.pose));
			move(world, body, &z, 100.1, few ? 15 : 510, &force, pressed);
			assert_near(force, most, 1e-3 * most);
			move(world, body, &z, 100.103, 600, &force, back);
			assert_true(force == 0);
			print_message("%g m, %d steps: pressed by %.2f J, gives back %.3f J by contacts, %.3f J by probes; elastic %.3f J\n", spacings[i], few ? 15 : 510, -pressed[0],
				      back[0], back[1], elastic);
			assert_near(back[0], elastic, 0.01 * elastic);
			assert_near(back[1], elastic, 0.01 * elastic);
			done(furrow_world_close(world));
		}
}

/* Lets a ball fall until it stops, and returns how deep it is then, m. */
static double stop_depth(bool implicit, double step)
{
	const double mass = 20;
	struct furrow_world *world = probing_world(&(struct probing_ground){"ball.furrow", "dry_sand", 0.015625, 0, 100, 0, step, true});
	furrow_body body;
	struct furrow_state at = hosted_state(20.013, 20.007, 100.152);
	at.linear[2] = -2;
	done(furrow_body_add(world, ball, &body));
	done(furrow_place(world, body, &at.pose));
	for (int i = 0; i < 100000 && at.linear[2] < 0; i++) {
		const struct furrow_contact contact = probing_ask(world, body, &at);
		const double k = implicit ? contact.stiffness[2][2] : 0, c = implicit ? contact.damping[2][2] : 0;
		const double pull = contact.force[2] - mass * 9.81 + step * k * at.linear[2];
		at.linear[2] += step * pull / (mass - step * c - step * step * k);
		at.pose.position[2] += step * at.linear[2];
		probing_step(world, body, &at, step);
	}
	done(furrow_world_close(world));
	return 100.15 - at.pose.position[2];
}

static void an_implicit_host_stops_a_ball_as_deep_as_short_steps_do(void **state)
{
	const double depth = stop_depth(false, 5e-5), coarse = stop_depth(true, 1e-3), fine = stop_depth(true, 5e-4);
	print_message("short steps: %.3f mm; implicit, 1 ms: %.3f mm, 0.5 ms: %.3f mm\n", depth * 1e3, coarse * 1e3, fine * 1e3);
	assert_near(coarse, depth, 0.01 * depth);
	assert_near(fine, depth, 0.01 * depth);
}

/* --- a wheel that reverses --- */

#define WAY 0.25 /* m before it reverses, and after */

/* Drives a wheel that bears 500 N with a slip of 0.2, first forwards, then back. pulls: the pull after it reversed, at every 5 mm. *jump: its largest
 * change from row to row. *first: what the soil bears in the first row back, N. NAN in place of a pull: a contact that is due since the wheel rises lets the
 * soil bear less or more than 500 N there. */
static void reverse(double row, double pulls[8], double *jump, double *first)
{
	struct furrow_world *world = probing_world(&(struct probing_ground){"reverse.furrow", "dry_sand, damping: 0", 0.03125, 0, 100, 0, row / 0.25, true});
	const int steps = (int)lround(WAY / row), each = (int)lround(0.005 / row);
	furrow_body body;
	double z = 100.299, turn = 0, before = 0;
	*jump = 0;
	struct furrow_state at = hosted_state(20.013, 20.007, 100.301);
	done(furrow_body_add(world, "{shape: {wheel: {radius: 0.3, width: 0.2}}}", &body));
	done(furrow_place(world, body, &at.pose));
	for (int i = 0; i < steps + 8 * each; i++) {
		const double way = i < steps ? 1 : -1;
		struct furrow_contact told;
		at.linear[0] = 0.25 * way;
		at.angular[1] = at.linear[0] / (0.3 * (1 - 0.2));
		at.pose.position[0] += row * way;
		turn += row * way / (0.3 * (1 - 0.2));
		at.pose.orientation[0] = cos(turn / 2);
		at.pose.orientation[2] = sin(turn / 2);
		double low = z - 0.005, high = z + 0.002; /* of its height, at which the soil carries it */
		for (int k = 0; k < 24; k++) {
			at.pose.position[2] = z = 0.5 * (low + high);
			*(probing_ask(world, body, &at).force[2] > 500 ? &low : &high) = z;
		}
		at.pose.position[2] = z;
		probing_step(world, body, &at, row / 0.25);
		done(furrow_get_contacts(world, 1, &body, &told, sizeof told));
		if (i >= steps)
			*jump = support_most(*jump, fabs(told.force[0] - before));
		if (i == steps)
			*first = told.force[2];
		before = told.force[0];
		if (i >= steps && (i - steps + 1) % each == 0)
			pulls[(i - steps) / each] = fabs(told.force[2] - 500) < 5 ? told.force[0] : NAN;
	}
	done(furrow_world_close(world));
}

static void a_wheel_that_reverses_pulls_the_other_way_bit_by_bit(void **state)
{
	double rows[8], fine[8], finest[8], jumps[3], first[3];
	int compared = 0;
	reverse(0.005, rows, &jumps[0], &first[0]);
	reverse(0.00125, fine, &jumps[1], &first[1]);
	reverse(0.00025, finest, &jumps[2], &first[2]);
	for (int i = 0; i < 8; i++)
		print_message("%d mm back: %.1f N in rows of 5 mm, %.1f N in rows of 1.25 mm, %.1f N in rows of 0.25 mm\n", 5 * (i + 1), rows[i], fine[i], finest[i]);
	print_message("from row to row at most %.1f, %.1f and %.1f N; in the first row the soil bears %.1f, %.1f and %.1f N\n", jumps[0], jumps[1], jumps[2], first[0], first[1],
		      first[2]);
	for (int i = 0; i < 8; i++) {
		if (isnan(rows[i]) || isnan(fine[i]))
			continue;
		assert_near(rows[i], fine[i], 12);
		compared++;
	}
	assert_true(compared >= 6);
	for (int i = 0; i < 3; i++)
		assert_near(first[i], 500, 5);
	assert_true(jumps[2] < 25);
}

TEST_PROGRAM(raised)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_raised_box_gives_back_the_elastic_energy),
		cmocka_unit_test(a_wheel_that_reverses_pulls_the_other_way_bit_by_bit),
		cmocka_unit_test(an_implicit_host_stops_a_ball_as_deep_as_short_steps_do),
	};
	return cmocka_run_group_tests_name("api/raised", tests, support_enter, support_leave);
}
