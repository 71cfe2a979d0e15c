/* furrow_probe beside what the GPU tells of the same motion, beside closed forms, and beside its own differences; what it does not know. */
#include "../support/near.h"
#include "probing.h"
#include "../support/program.h"

/* --- beside the GPU --- */

static const char *const shapes[] = {probing_wheel, probing_ball, probing_box};
static const char *const names[] = {"wheel", "sphere", "box"};

/* A way: the body sinks to a depth, then moves on at an angle. */
struct way {
	double degrees, turns, depth; /* turns: of a wheel's rim, for each metre of way */
};

/* The state after a number of steps. Its lowest point is so deep below the slope, along the normal. */
static struct furrow_state state_at(const struct way *way, int shape, double spacing, int step)
{
	const double c = cos(way->degrees * DEGREES), s = sin(way->degrees * DEGREES), tilt = atan(probing_slope), pace = 0.15 * spacing;
	const double down = (way->depth + 0.002) / 24, moved = pace * (step > 24 ? step - 24 : 0), sunk = -0.002 + down * (step < 24 ? step : 24);
	const double x = 30.0173 + moved * c, y = 30.0071 + moved * s, turn = shape == 0 ? way->turns * moved / 0.25 : 0;
	const double reach = shape == 2 ? 0.1 + fabs(probing_slope) * (0.15 * fabs(c) + 0.1 * fabs(s)) : 0.25 / cos(tilt);
	const double half = way->degrees * DEGREES / 2, spin = step > 24 && shape == 0 ? way->turns * pace / 0.25 / 0.01 : 0;
	const double speed = step > 24 ? pace / 0.01 : 0, sinks = step > 0 && step <= 24 ? down / cos(tilt) / 0.01 : 0;
	return (struct furrow_state){
		.pose = {{x, y, probing_base + probing_slope * x + reach - sunk / cos(tilt)},
			 {cos(half) * cos(turn / 2), -sin(half) * sin(turn / 2), cos(half) * sin(turn / 2), sin(half) * cos(turn / 2)}},
		.linear = {speed * c, speed * s, probing_slope * speed * c - sinks},
		.angular = {-s * spin, c * spin, 0},
	};
}

/* Returns the worst difference of a component: as a share of the vertical force, or of half of the greatest; moments over 0.25 m. */
static double worst_on(const struct probing_ground *ground, const struct way *way, int shape, bool faces)
{
	probing_more = faces ? ", faces: on" : ", faces: off";
	struct furrow_world *world = probing_world(ground);
	double worst = 0, greatest = 10;
	furrow_body body;
	done(furrow_body_add(world, shapes[shape], &body));
	for (int step = 0; step < 56; step++) {
		const struct furrow_state state = state_at(way, shape, ground->spacing, step);
		struct furrow_contact told;
		if (step == 0)
			done(furrow_place(world, body, &state.pose));
		const struct furrow_contact probed = probing_ask(world, body, &state);
		probing_step(world, body, &state, 0);
		done(furrow_get_contacts(world, 1, &body, &told, sizeof told));
		greatest = support_most(greatest, told.force[2]);
		const double by = fmax(told.force[2], 0.5 * greatest);
		/* Whether faces slide is told by how their friction adds up, which is near its limit. */
		assert_true(told.force[2] < 0.002 * greatest || probed.state == told.state || faces);
		for (int k = 0; k < 3; k++)
			worst = support_most(worst, support_most(fabs(probed.force[k] - told.force[k]), fabs(probed.moment[k] - told.moment[k]) / 0.25) / by);
		assert_true(told.state == FURROW_AIR || fabs(probed.area - told.area) < 0.02 * told.area + 0.4 * ground->spacing * ground->spacing);
		if (step == 24) { /* a query commits; what follows is one straight motion */
			struct furrow_point point;
			done(furrow_points(world, 1, (const double[]){5, 5}, &point));
		}
	}
	done(furrow_world_close(world));
	probing_more = "";
	return worst;
}

static void a_probe_tells_what_the_gpu_does(void **state)
{
	static const struct {
		struct probing_ground ground;
		double depth;
	} rows[] = {
		{{"probe.furrow", "dry_sand", 0.015625, 0, 100, 0, 0, false}, 0.02}, {{"probe.furrow", "dry_sand", 0.03125, 0, 100, 0, 0, false}, 0.02},
		{{"probe.furrow", "dry_sand", 0.0625, 0, 100, 0, 0, false}, 0.02}, {{"probe.furrow", "lunar", 0.03125, 0, 8000, 0, 0, false}, 0.03},
		{{"probe.furrow", "lete_sand", 0.03125, 0, -8000, 0, 0, false}, 0.006}, {{"probe.furrow", "dry_sand", 0.03125, 10, 100, 0, 0, false}, 0.02},
		{{"probe.furrow", "sandy_loam_15", 0.03125, 20, 100, 0, 0, false}, 0.01},
	};
	static const struct way ways[] = {{0, 1.25, 0}, {30, 0.8, 0}};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
		for (int shape = 0; shape < 3; shape++)
			for (int k = 0; k < 2; k++) {
				const struct way way = {ways[k].degrees, ways[k].turns, rows[i].depth};
				const bool faces = (i + (size_t)shape + (size_t)k) % 2 == 1;
				const double worst = support_most(worst_on(&rows[i].ground, &way, shape, false), faces ? worst_on(&rows[i].ground, &way, shape, true) : 0);
				print_message("%s, %g m, slope %g, %s at %g degrees%s: %.3f %%\n", rows[i].ground.soil, rows[i].ground.spacing,
					      rows[i].ground.degrees, names[shape], way.degrees, faces ? ", also with faces" : "", worst * 100);
				/* A box that slides aslant on a slope remembers the hollow that it left only roughly. */
				assert_true(worst < (shape == 2 && rows[i].ground.degrees > 0 && way.degrees > 0 ? 0.03 : 0.005));
			}
}

/* --- beside closed forms --- */

/* dry_sand: Bekker's numbers, and the elastic stiffness that is the default. */
static double sand_pressure(double width, double sinkage)
{
	return fmin((0.99e3 / width + 1528.43e3) * pow(sinkage, 1.1), 4e7 * sinkage);
}

static void a_plate_and_a_wheel_bear_as_their_closed_forms(void **state)
{
	for (int k = 0; k < 3; k++) {
		struct furrow_world *world = probing_world(&(struct probing_ground){"form.furrow", "dry_sand", 0.015625 * (1 << k), 0, 100, 0, 0, false});
		furrow_body plate, wheel;
		done(furrow_body_add(world, probing_box, &plate));
		done(furrow_body_add(world, probing_wheel, &wheel));
		for (int deep = 5; deep <= 25; deep += 10) {
			const double sinkage = deep * 1e-3;
			struct furrow_state at[2] = {hosted_state(20.003, 20.011, 100.1 - sinkage), hosted_state(25.003, 25.011, 100.25 - sinkage)};
			done(furrow_place(world, plate, &at[0].pose));
			done(furrow_place(world, wheel, &at[1].pose));
			const struct furrow_contact still = probing_ask(world, plate, &at[0]), round = probing_ask(world, wheel, &at[1]);
			at[0].linear[2] = -1e-9; /* it goes on down, too slowly for damping */
			const struct furrow_contact flat = probing_ask(world, plate, &at[0]);
			const double wanted = sand_pressure(0.2, sinkage) * 0.3 * 0.2;
			double arc = 0;
			const int parts = 20000;
			const double reach = sqrt(0.25 * 0.25 - (0.25 - sinkage) * (0.25 - sinkage));
			for (int i = 0; i < parts; i++) {
				const double x = reach * ((i + 0.5) / parts);
				arc += 2 * reach / parts * 0.2 * sand_pressure(0.2, sqrt(0.25 * 0.25 - x * x) - 0.25 + sinkage);
			}
			assert_near(flat.force[2], wanted, 1e-3 * wanted);
			assert_near(flat.area, 0.06, 1e-6);
			assert_near(flat.normal_force, flat.force[2], 1e-5 * wanted);
			assert_near(flat.shear_limit, 1.04e3 * 0.06 + wanted * tan(28 * DEGREES), 1e-3 * wanted);
			assert_near(flat.sinkage, sinkage, 2e-6);
			/* A plate at rest springs back: K_e A. One that goes on down yields: n p A / z downwards, and as it tips about its edges. */
			assert_near(still.stiffness[2][2], -4e7 * 0.06, 2e-3 * 4e7 * 0.06);
			const double grows = -1.1 * wanted / sinkage;
			assert_near(flat.stiffness[2][2], grows, 2e-3 * fabs(grows));
			/* As it tips, its lower face also slides by its distance from the centre. */
			const double tips = grows * 0.2 * 0.2 / 12 - flat.shear_limit / 0.02 * 0.1 * 0.1;
			assert_near(flat.stiffness[3][3], tips, (k == 2 ? 0.1 : 0.05) * fabs(tips));
			print_message("%g m, %d mm: plate %.2f N (%.2f), wheel %.2f N (%.2f)\n", 0.015625 * (1 << k), deep, flat.force[2], wanted,
				      round.force[2], arc);
			assert_near(round.force[2], arc, (k == 2 ? 0.02 : 0.005) * arc);
		}
		done(furrow_world_close(world));
	}
}

/* --- stiffness and damping --- */

/* Set down: it sank slowly, and sinks on, a little to the side. */
static void stiffness_and_damping_are_how_the_force_changes(void **state)
{
	static const double slopes[] = {0, 12};
	for (int k = 0; k < 2; k++)
		for (int shape = 0; shape < 3; shape++) {
			probing_more = ", faces: off";
			struct furrow_world *world = probing_world(&(struct probing_ground){"stiff.furrow", "dry_sand", 0.015625, slopes[k], 100, 0, 0, false});
			const struct way way = {20, 1, 0.015};
			furrow_body body;
			done(furrow_body_add(world, shapes[shape], &body));
			for (int step = 0; step <= 24; step++) {
				const struct furrow_state at = state_at(&way, shape, 0.015625, step);
				if (step == 0)
					done(furrow_place(world, body, &at.pose));
				probing_step(world, body, &at, 0);
			}
			struct furrow_state at = state_at(&way, shape, 0.015625, 24);
			at.pose.position[0] += 2e-4;
			at.pose.position[2] -= 6e-4;
			at.linear[0] = 0.0005;
			at.linear[2] = -0.02;
			const unsigned freedoms = shape == 0 ? 0x17 : 0x3f; /* a wheel's axle stays level */
			const struct probing_off stiffness = probing_off_by(world, body, &at, freedoms, false), damping = probing_off_by(world, body, &at, freedoms & 0x17, true);
			print_message("%s, slope %g: stiffness %.3f (%.2f .. %.2f), damping %.3f (%.2f .. %.2f)\n", names[shape], slopes[k], stiffness.worst,
				      stiffness.least, stiffness.most, damping.worst, damping.least, damping.most);
			const struct furrow_contact contact = probing_ask(world, body, &at);
			for (int i = 0; i < 6; i++)
				assert_true(contact.stiffness[i][i] < 0 && contact.damping[i][i] <= 0);
			assert_true(stiffness.worst < 0.4 && stiffness.least > 0.75 && stiffness.most < 1.3);
			assert_true(damping.worst < 0.35 && damping.least > 0.9 && damping.most < 1.45);
			done(furrow_world_close(world));
			probing_more = "";
		}
}

/* --- what it changes, and what it does not know --- */

/* Drives a wheel, and asks about it at each step if `asks`. Returns the store's hash and the sum of the forces that were told. */
static uint64_t drive(const char *name, bool asks, int slots, double *sum)
{
	struct furrow_world *world = probing_world(&(struct probing_ground){name, "dry_sand", 0.03125, 5, 100, slots, 0, false});
	const struct way way = {20, 1.25, 0.02};
	furrow_body body;
	*sum = 0;
	done(furrow_body_add(world, probing_wheel, &body));
	for (int step = 0; step < 60; step++) {
		const struct furrow_state at = state_at(&way, 0, 0.03125, step);
		struct furrow_contact told;
		if (step == 0)
			done(furrow_place(world, body, &at.pose));
		if (asks) {
			const struct furrow_contact once = probing_ask(world, body, &at);
			struct furrow_state other = at;
			other.pose.position[2] -= 0.01;
			other.pose.position[0] += 0.02;
			probing_ask(world, body, &other);
			const struct furrow_contact again = probing_ask(world, body, &at);
			assert_memory_equal(&once, &again, sizeof once);
			*sum += 3 * once.force[0] + once.moment[1];
		}
		probing_step(world, body, &at, 0);
		done(furrow_get_contacts(world, 1, &body, &told, sizeof told));
		*sum += told.force[2];
	}
	done(furrow_world_close(world));
	return support_hash(support_path(name));
}

static void a_probe_changes_nothing(void **state)
{
	double with, without, few;
	const uint64_t asked = drive("asked.furrow", true, 0, &with), left = drive("left.furrow", false, 0, &without);
	assert_true(asked == left);
	/* The same bits through 8 slots and 256. */
	drive("few.furrow", true, 8, &few);
	double many;
	assert_true(drive("few.furrow", true, 8, &few) == drive("many.furrow", true, 256, &many));
	assert_true(few == many && few == with);
}

/* Posts are computed in batches. Which bodies are asked about in one call, and in which order, changes no bit. */
static void each_body_has_the_same_bits_in_any_company(void **state)
{
	static const int orders[][3] = {{0, 1, 2}, {2, 0, 1}, {1, 2, 0}};
	const struct probing_ground ground = {"probe.furrow", "dry_sand", 0.03125, 10, 100, 0, 0, false};
	struct furrow_world *world = probing_world(&ground);
	furrow_body bodies[3];
	struct furrow_state states[3];
	struct furrow_contact alone[3];
	for (int shape = 0; shape < 3; shape++) {
		const struct way way = {15.0 * shape, 1.1, 0.02};
		states[shape] = state_at(&way, shape, ground.spacing, 30);
		states[shape].pose.position[1] += 2 * shape;
		done(furrow_body_add(world, shapes[shape], &bodies[shape]));
		done(furrow_place(world, bodies[shape], &states[shape].pose));
		alone[shape] = probing_ask(world, bodies[shape], &states[shape]);
		assert_true(alone[shape].force[2] > 0);
	}
	for (int order = 0; order < 3; order++) {
		furrow_body asked[3];
		struct furrow_state asks[3];
		struct furrow_contact told[3];
		for (int i = 0; i < 3; i++) {
			asked[i] = bodies[orders[order][i]];
			asks[i] = states[orders[order][i]];
		}
		done(furrow_probe(world, 3, asked, asks, told, sizeof *told));
		for (int i = 0; i < 3; i++) {
			const struct furrow_contact *one = &alone[orders[order][i]];
			assert_memory_equal(told[i].force, one->force, sizeof one->force);
			assert_memory_equal(told[i].moment, one->moment, sizeof one->moment);
			assert_memory_equal(told[i].stiffness, one->stiffness, sizeof one->stiffness);
			assert_memory_equal(told[i].damping, one->damping, sizeof one->damping);
		}
	}
	done(furrow_world_close(world));
}

static void it_says_what_it_does_not_know(void **state)
{
	struct furrow_world *world = probing_world(&(struct probing_ground){"unknown.furrow", "dry_sand", 0.03125, 0, 100, 0, 0, false});
	struct furrow_state at = hosted_state(20, 20, 100.24);
	furrow_body body;
	done(furrow_body_add(world, probing_wheel, &body));
	/* It has no place yet. */
	struct furrow_contact contact = probing_ask(world, body, &at);
	assert_int_equal(contact.state, FURROW_UNKNOWN);
	assert_true(isnan(contact.force[2]) && isnan(contact.stiffness[2][2]) && isnan(contact.damping[0][0]));
	done(furrow_place(world, body, &at.pose));
	contact = probing_ask(world, body, &at);
	assert_int_equal(contact.state, FURROW_TOUCHING);
	assert_true(contact.force[2] > 0 && contact.time == 0 && isnan(contact.slip) && contact.normal[2] > 0.999);
	at.pose.position[0] += 2 * 0.03125;
	assert_int_equal(probing_ask(world, body, &at).state, FURROW_TOUCHING);
	at.pose.position[0] += 1;
	assert_int_equal(probing_ask(world, body, &at).state, FURROW_TOUCHING);
	at.pose.position[0] = -5;
	contact = probing_ask(world, body, &at);
	assert_int_equal(contact.state, FURROW_UNKNOWN);
	assert_true(isnan(contact.force[2]));
	at = hosted_state(20, 20, 100.3);
	contact = probing_ask(world, body, &at);
	assert_int_equal(contact.state, FURROW_AIR);
	assert_true(contact.force[2] == 0 && contact.area == 0 && contact.stiffness[2][2] == 0);
	/* A wheel whose axle is not level, a velocity that is no number, a body that is gone. */
	at.linear[1] = NAN;
	misused(furrow_probe(world, 1, &body, &at, &contact, sizeof contact));
	at = hosted_state(20, 20, 100.24);
	at.pose.orientation[0] = 2;
	misused(furrow_probe(world, 1, &body, &at, &contact, sizeof contact));
	done(furrow_body_remove(world, body));
	at = hosted_state(20, 20, 100.24);
	misused(furrow_probe(world, 1, &body, &at, &contact, sizeof contact));
	done(furrow_world_close(world));
}

/* A body that follows its path, one that was not placed, and every body under another soil model. */
static void states_are_checked_where_nothing_is_known(void **state)
{
	static const char *const scenes[] = {
		"{\"spacing\": 0.125, \"soil\": {\"name\": \"dry_sand\"}, \"redistribute\": {\"model\": \"scm\"}, \"objects\": [{\"name\": \"ball\","
		" \"shape\": {\"sphere\": {\"radius\": 0.5}}, \"sink\": 0.1, \"path\": {\"points\": [[10, 16], [20, 16]], \"speed\": 1}}]}",
		"{\"spacing\": 0.125, \"soil\": {\"name\": \"dry_sand\"}, \"redistribute\": {\"model\": \"scm\"}, \"objects\": [{\"name\": \"ball\","
		" \"shape\": {\"sphere\": {\"radius\": 0.5}}}]}",
		"{\"spacing\": 0.125, \"redistribute\": {\"model\": \"box\"}, \"objects\": [{\"name\": \"ball\", \"shape\": {\"sphere\": {\"radius\": 0.5}}}]}",
	};
	const struct furrow_state good = hosted_state(16, 16, 100.5);
	for (int i = 0; i < 3; i++) {
		struct furrow_world *world = hosted_world_over("unknown.furrow", scenes[i], hosted_flat);
		struct furrow_contact contact;
		struct furrow_state wrong = good;
		furrow_body ball;
		done(furrow_body_find(world, "ball", &ball));
		if (i == 2)
			done(furrow_place(world, ball, &good.pose));
		assert_int_equal(probing_ask(world, ball, &good).state, FURROW_UNKNOWN);
		wrong.pose.position[0] = NAN;
		misused(furrow_probe(world, 1, &ball, &wrong, &contact, sizeof contact));
		wrong = good;
		wrong.pose.orientation[0] = 2;
		misused(furrow_probe(world, 1, &ball, &wrong, &contact, sizeof contact));
		wrong = good;
		wrong.angular[2] = INFINITY;
		misused(furrow_probe(world, 1, &ball, &wrong, &contact, sizeof contact));
		done(furrow_world_close(world));
	}
}

static void after_a_rollback_it_knows_the_ground_as_it_was(void **state)
{
	struct furrow_world *world = probing_world(&(struct probing_ground){"back.furrow", "dry_sand", 0.03125, 0, 100, 0, 0, false});
	struct furrow_state at = hosted_state(20, 20, 100.24), deep = hosted_state(20, 20, 100.2);
	furrow_body body;
	done(furrow_body_add(world, probing_wheel, &body));
	done(furrow_place(world, body, &at.pose));
	probing_step(world, body, &at, 0);
	done(furrow_checkpoint(world));
	const struct furrow_contact before = probing_ask(world, body, &at);
	probing_step(world, body, &deep, 0);
	/* The soil was pressed, and bears less. */
	assert_true(probing_ask(world, body, &at).force[2] < 0.5 * before.force[2]);
	done(furrow_rollback(world));
	const struct furrow_contact after = probing_ask(world, body, &at);
	assert_memory_equal(&before.force, &after.force, sizeof before.force);
	done(furrow_world_close(world));
}

/* --- unloading --- */

/* Sinks a body that heads `yaw` until it bears 2 kN, and commits that. */
static struct furrow_state sunk_by_load(struct furrow_world *world, const char *shape, double reach, double yaw, furrow_body *body)
{
	const double up[3] = {0, 0, 1};
	struct furrow_state state = hosted_state(15.013, 15.007, 0);
	state.pose.position[2] = probing_base + probing_slope * 15.013 + reach / cos(atan(probing_slope));
	probing_turn(up, yaw, state.pose.orientation);
	done(furrow_body_add(world, shape, body));
	done(furrow_place(world, *body, &state.pose));
	do {
		state.pose.position[2] -= 0.002;
		probing_step(world, *body, &state, 0);
	} while (probing_ask(world, *body, &state).force[2] < 2000);
	done(furrow_checkpoint(world));
	return state;
}

/* A body that moved by a tenth of a millimetre or so before it rises is unloaded no more stiffly. It may be softer: a part of it left the soil. */
static void unloading_is_as_stiff_after_any_short_way(void **state)
{
	static const struct {
		const char *shape;
		double reach;
	} bodies[] = {{probing_wheel, 0.25}, {probing_ball, 0.25}, {"{shape: {ellipsoid: {radii: [0.3, 0.2, 0.25]}}}", 0.25}};
	static const double slopes[] = {0, 10, 20}, yaws[] = {0, 40, 90}, ways[] = {1e-5, 6e-5, 3e-4};
	(void)state;
	double stiffest = 0;
	for (size_t s = 0; s < 3; s++) {
		struct furrow_world *world = probing_world(&(struct probing_ground){"unload.furrow", "dry_sand", 0.03125, slopes[s], 100, 0, 0, false});
		for (size_t n = 0; n < 9; n++) {
			furrow_body body;
			const struct furrow_state sunk = sunk_by_load(world, bodies[n / 3].shape, bodies[n / 3].reach, yaws[n % 3] * DEGREES, &body);
			double still = 0;
			for (size_t k = 0; k <= 24; k++) { /* the first does not move aside */
				const double way = k == 0 ? 0 : ways[k % 3], angle = (double)k / 3 * M_PI / 4;
				struct furrow_state low = sunk;
				low.pose.position[0] += way * cos(angle);
				low.pose.position[1] += way * sin(angle);
				low.pose.position[2] += probing_slope * way * cos(angle) + 5e-5;
				struct furrow_state high = low;
				high.pose.position[2] += 1e-4;
				const double drop = probing_ask(world, body, &low).force[2] - probing_ask(world, body, &high).force[2];
				still = k == 0 ? drop : still;
				stiffest = support_most(stiffest, drop / still);
			}
			done(furrow_body_remove(world, body));
		}
		done(furrow_world_close(world));
	}
	print_message("unloading after a short way: %.3f times as stiff at most\n", stiffest);
	assert_true(stiffest < 1.1);
}

TEST_PROGRAM(probe)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_probe_tells_what_the_gpu_does),
		cmocka_unit_test(a_plate_and_a_wheel_bear_as_their_closed_forms),
		cmocka_unit_test(stiffness_and_damping_are_how_the_force_changes),
		cmocka_unit_test(a_probe_changes_nothing),
		cmocka_unit_test(each_body_has_the_same_bits_in_any_company),
		cmocka_unit_test(it_says_what_it_does_not_know),
		cmocka_unit_test(states_are_checked_where_nothing_is_known),
		cmocka_unit_test(after_a_rollback_it_knows_the_ground_as_it_was),
		cmocka_unit_test(unloading_is_as_stiff_after_any_short_way),
	};
	return cmocka_run_group_tests_name("api/probe", tests, support_enter, support_leave);
}
