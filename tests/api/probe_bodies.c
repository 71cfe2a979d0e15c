/* furrow_probe beside what the GPU tells, and beside its own differences, of bodies of every shape in any attitude: wheels with camber and
 * grousers, cylinders, capsules, ellipsoids, meshes. */
#include "../long.h"
#include "../support/near.h"
#include "../support/program.h"
#include "probing.h"

static char foot[300]; /* a mesh: write_foot */

struct probed {
	const char *name, *shape;
	bool wheel;
	double roll, pitch;  /* degrees */
	double within;       /* of the vertical force */
	bool commits;        /* each step changes the ground */
	double coarsest;     /* m: the coarsest spacing at which posts tell of it */
};

/* A way: the body sinks to a depth, then moves on at an angle to its heading. */
struct way {
	double heading, aside, turns, depth; /* degrees; turns: of a wheel's rim, for each metre of way */
};

#define SINKS 16 /* steps down, then it moves on */
#define STEPS 40

/* Heading, then roll, then pitch or the turn of a wheel. reach: height of its centre above the slope where it nearly touches. */
static struct furrow_state state_at(const struct probed *body, const struct way *way, double reach, double spacing, int step)
{
	const double yaw = way->heading * DEGREES, roll = body->roll * DEGREES, c = cos(yaw + way->aside * DEGREES), s = sin(yaw + way->aside * DEGREES);
	const double tilt = cos(atan(probing_slope)), pace = (body->commits ? 0.6 : 0.15) * spacing, down = (way->depth + 0.002) / SINKS;
	const double moved = pace * (step > SINKS ? step - SINKS : 0), sunk = -0.002 + down * (step < SINKS ? step : SINKS);
	const double turn = body->wheel ? way->turns * moved / 0.25 : -body->pitch * DEGREES;
	const double spin = step > SINKS && body->wheel ? way->turns * pace / 0.25 / 0.01 : 0, speed = step > SINKS ? pace / 0.01 : 0;
	const double sinks = step > 0 && step <= SINKS ? down / tilt / 0.01 : 0, x = 30.0173 + moved * c, y = 30.0071 + moved * s;
	struct furrow_state state = {
		.pose = {{x, y, probing_base + probing_slope * x + reach - sunk / tilt}, {cos(turn / 2), 0, sin(turn / 2), 0}},
		.linear = {speed * c, speed * s, probing_slope * speed * c - sinks},
		.angular = {-sin(yaw) * cos(roll) * spin, cos(yaw) * cos(roll) * spin, sin(roll) * spin},
	};
	probing_turn((const double[]){1, 0, 0}, roll, state.pose.orientation);
	probing_turn((const double[]){0, 0, 1}, yaw, state.pose.orientation);
	return state;
}

/* Finds the height of its centre above the slope where it just touches, and a little more. */
static double reach_of(struct furrow_world *world, const struct probed *body, const struct way *way, double spacing)
{
	double low = 0.05, high = 0.8;
	furrow_body number;
	done(furrow_body_add(world, body->shape, &number));
	struct furrow_state state = state_at(body, way, high, spacing, 0);
	done(furrow_place(world, number, &state.pose));
	for (int k = 0; k < 30; k++) {
		const double middle = (low + high) / 2;
		state = state_at(body, way, middle, spacing, 0);
		*(probing_ask(world, number, &state).state == FURROW_AIR ? &high : &low) = middle;
	}
	done(furrow_body_remove(world, number));
	return high + 0.002;
}

static void commit(struct furrow_world *world)
{
	struct furrow_point point;
	done(furrow_points(world, 1, (const double[]){5, 5}, &point)); /* a query commits */
}

struct off {
	double rests, moves; /* the worst difference while it sinks, and while it moves */
};

/* Returns the worst difference of a component as a share of `by`; moments over 0.25 m. */
static double difference(const struct furrow_contact *probed, const struct furrow_contact *told, double by)
{
	double worst = 0;
	for (int k = 0; k < 3; k++)
		worst = support_most(worst, support_most(fabs(probed->force[k] - told->force[k]), fabs(probed->moment[k] - told->moment[k]) / 0.25) / by);
	return worst;
}

/* Differences are shares of the vertical force, or of half of the greatest. */
static struct off worst_on(const struct probing_ground *ground, const struct probed *body, const struct way *way)
{
	struct furrow_world *world = probing_world(ground);
	struct off off = {0, 0};
	double greatest = 15;
	furrow_body number;
	done(furrow_body_add(world, body->shape, &number));
	const double reach = reach_of(world, body, way, ground->spacing);
	for (int step = 0; step < STEPS; step++) {
		const struct furrow_state state = state_at(body, way, reach, ground->spacing, step);
		struct furrow_contact told;
		if (step == 0)
			done(furrow_place(world, number, &state.pose));
		const struct furrow_contact probed = probing_ask(world, number, &state);
		probing_step(world, number, &state, 0);
		done(furrow_get_contacts(world, 1, &number, &told, sizeof told));
		greatest = support_most(greatest, told.force[2]);
		double *worst = step > SINKS ? &off.moves : &off.rests;
		/* Just above the ground only the slope of a mesh reaches below it, in some cells. Not every contact there is computed. */
		if (body->shape != foot || (told.state != FURROW_AIR && probed.state != FURROW_AIR) || greatest > 15)
			*worst = support_most(*worst, difference(&probed, &told, support_most(told.force[2], 0.5 * greatest)));
		if (step == SINKS || body->commits)
			commit(world);
	}
	assert_true(greatest > 15);
	done(furrow_world_close(world));
	return off;
}

static const char plain[] = "{shape: {wheel: {radius: 0.25, width: 0.2}}}", drum[] = "{shape: {cylinder: {radius: 0.25, length: 0.4}}}",
		  lugged[] = "{shape: {wheel: {radius: 0.25, width: 0.2, grousers: 18, grouser_height: 0.02, grouser_thickness: 0.03}}}",
		  peg[] = "{shape: {cylinder: {radius: 0.1, length: 0.3}}}", pill[] = "{shape: {capsule: {radius: 0.12, length: 0.3}}}",
		  egg[] = "{shape: {ellipsoid: {radii: [0.3, 0.2, 0.15]}}}";

/* What slides slowly is damped more by a probe than by the GPU. Below a steep cylinder few posts tell of both its end and its side. Between
 * two contacts a probe remembers how deep a grouser was, which the GPU does not: so each step of grousers is a contact. */
static const struct probed bodies[] = {
	{"camber of 0.05 degrees", plain, true, 0.05, 0, 0.005, false, 1}, {"camber of -0.2", plain, true, -0.2, 0, 0.0055, false, 1},
	{"camber of 1", plain, true, 1, 0, 0.005, false, 1}, {"camber of 3", plain, true, 3, 0, 0.005, false, 1},
	{"camber of -9", plain, true, -9, 0, 0.006, false, 1}, {"camber of 23", plain, true, 23, 0, 0.006, false, 1}, {"grousers", lugged, true, 0, 0, 0.006, true, 1},
	{"grousers and camber of 9", lugged, true, 9, 0, 0.01, true, 0.04}, {"cylinder that lies", drum, false, 90, 0, 0.012, false, 1},
	{"cylinder that leans", drum, false, 78, 0, 0.007, false, 1}, {"steep cylinder", peg, false, 25, 0, 0.07, false, 0.02},
	{"upright cylinder", peg, false, 0, 0, 0.03, false, 1}, {"upright capsule", pill, false, 0, 0, 0.02, false, 1},
	{"capsule that leans", pill, false, 50, 10, 0.02, false, 1}, {"capsule that lies", pill, false, 90, 0, 0.02, false, 1},
	{"ellipsoid", egg, false, 0, 0, 0.02, false, 1}, {"ellipsoid that leans", egg, false, 20, 30, 0.02, false, 1},
	/* Edges between facets move over the posts. */
	{"mesh", foot, false, 0, 0, 0.03, false, 1}, {"mesh that leans", foot, false, 7, -11, 0.01, false, 1},
};

/* A block that grows wider upwards. */
static void write_foot(void)
{
	static const char text[] = "v 0.12 0.1 -0.1\nv -0.1 0.1 -0.1\nv -0.1 -0.1 -0.1\nv 0.12 -0.1 -0.1\nv 0.2 0.15 0.1\nv -0.2 0.15 0.1\nv -0.2 -0.15 0.1\nv 0.2 -0.15 0.1\n"
				   "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
	support_write(support_path("foot.obj"), text);
	snprintf(foot, sizeof foot, "{shape: {mesh: {file: %s}}}", support_path("foot.obj"));
}

static void a_probe_tells_what_the_gpu_does(void **state)
{
	static const struct {
		struct probing_ground ground;
		double depth;
	} rows[] = {
		{{"probe.furrow", "dry_sand", 0.015625, 0, 100, 0, 0, false}, 0.02}, {{"probe.furrow", "dry_sand", 0.03125, 0, 100, 0, 0, false}, 0.02},
		{{"probe.furrow", "dry_sand", 0.0625, 0, 100, 0, 0, false}, 0.02}, {{"probe.furrow", "lunar", 0.03125, 0, 8000, 0, 0, false}, 0.03},
		{{"probe.furrow", "clayey_38", 0.015625, 0, 100, 0, 0, false}, 0.01},
		{{"probe.furrow", "lete_sand", 0.03125, 10, -8000, 0, 0, false}, 0.006}, {{"probe.furrow", "sandy_loam_15", 0.03125, 20, 100, 0, 0, false}, 0.01},
	};
	static const struct way ways[] = {{0, 0, 1.25, 0}, {44, 0, 1, 0}, {22.5, 20, 0.8, 0}};
	const bool all = getenv("PROBE_ALL") != NULL;
	write_foot();
	for (size_t b = 0; b < sizeof bodies / sizeof *bodies; b++)
		for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
			for (size_t k = 0; k < 3; k++) {
				const struct probing_ground *ground = &rows[i].ground;
				struct way way = ways[k];
				/* Of a mesh all headings: in one of them alone its motion is a whole number of places of its raster. */
				const bool one = !all && bodies[b].shape != foot;
				if (!long_or_part(b, i, 2) || (one && k != (b + i) % 3) || ground->spacing > bodies[b].coarsest)
					continue;
				way.depth = rows[i].depth;
				const struct off off = worst_on(ground, &bodies[b], &way);
				print_message("%s, %s, %g m, slope %g, heading %g: %.3f %% as it sinks, %.3f %% as it moves\n", bodies[b].name,
					      ground->soil, ground->spacing, ground->degrees, way.heading, off.rests * 100, off.moves * 100);
				assert_true(fmax(off.rests, off.moves) < bodies[b].within);
			}
}

/* Set down: it sank slowly, and sinks on, a little to the side. */
static void stiffness_and_damping_are_how_the_force_changes(void **state)
{
	static const struct way way = {20, 0, 1, 0.015};
	const struct probing_ground ground = {"stiff.furrow", "dry_sand", 0.015625, 6, 100, 0, 0, false};
	write_foot();
	for (size_t b = 0; b < sizeof bodies / sizeof *bodies; b++) {
		probing_more = ", faces: off";
		struct furrow_world *world = probing_world(&ground);
		probing_more = "";
		struct furrow_state at;
		furrow_body number;
		done(furrow_body_add(world, bodies[b].shape, &number));
		const double reach = reach_of(world, &bodies[b], &way, ground.spacing);
		for (int step = 0; step <= SINKS; step++) {
			at = state_at(&bodies[b], &way, reach, ground.spacing, step);
			if (step == 0)
				done(furrow_place(world, number, &at.pose));
			probing_step(world, number, &at, 0);
		}
		at.pose.position[0] += 2e-4;
		at.pose.position[2] -= 6e-4;
		at.linear[0] = 0.0005;
		at.linear[2] = -0.02;
		const struct probing_off stiffness = probing_off_by(world, number, &at, 0x07, false), damping = probing_off_by(world, number, &at, 0x07, true);
		const struct probing_off turning = probing_off_by(world, number, &at, 0x3f, false);
		print_message("%s: stiffness %.3f (%.2f .. %.2f), with turns %.3f (%.2f .. %.2f), damping %.3f (%.2f .. %.2f)\n", bodies[b].name,
			      stiffness.worst, stiffness.least, stiffness.most, turning.worst, turning.least, turning.most, damping.worst, damping.least, damping.most);
		const struct furrow_contact contact = probing_ask(world, number, &at);
		for (int i = 0; i < 6; i++)
			assert_true(contact.stiffness[i][i] < 0 && contact.damping[i][i] <= 0);
		/* How the edges between facets of a mesh move over the posts is left out. A wheel's force does not know that it turns about other axes than its axle. */
		const bool mesh = bodies[b].shape == foot, leaning_mesh = mesh && bodies[b].roll != 0;
		assert_true(stiffness.worst < (leaning_mesh ? 0.7 : mesh ? 0.45 : 0.4) && stiffness.least > 0.75 && stiffness.most < (leaning_mesh ? 3.3 : mesh ? 1.8 : 1.3));
		assert_true(bodies[b].wheel || leaning_mesh || turning.most < (mesh ? 1.8 : 1.5));
		assert_true(bodies[b].wheel || leaning_mesh || (bodies[b].shape == peg && bodies[b].roll == 0 ? turning.worst < 0.65 && turning.least > 0.55 : turning.worst < 0.45 && turning.least > 0.75));
		/* Where the damping of what settles falls with the speed, it is told as constant. */
		assert_true(damping.least > 0.7);
		done(furrow_world_close(world));
	}
}

TEST_PROGRAM(probe_bodies)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_probe_tells_what_the_gpu_does),
		cmocka_unit_test(stiffness_and_damping_are_how_the_force_changes),
	};
	return cmocka_run_group_tests_name("api/probe_bodies", tests, support_enter, support_leave);
}
