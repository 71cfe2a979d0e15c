/* A host rolls a wheel, a cylinder and a mesh of a wheel alike: the soil bears them alike. */
#include "probing.h"
#include "../support/program.h"

#define RADIUS 0.3
#define WIDTH 0.2
#define FACETS 96
#define ROW 0.005 /* m */

static const struct extent extent = {129, 129, 0.2, 32};

/* Means of what contacts tell, over the second half of the way: force and moment along the heading, to its left and up; m. */
struct told {
	double force[3], moment[3], sinkage;
};

/* digs: slip_sinkage; half as much bulldozing. */
static struct furrow_world *open_world(const char *soil, double spacing, double digs)
{
	char scene[300];
	struct furrow_world *world = NULL;
	const char *store = support_path("round.furrow");
	snprintf(scene, sizeof scene, "{scene: 1, time_step: %g, spacing: %g, soil: {name: %s}, redistribute: {model: scm, slip_sinkage: %g, bulldozing: %g}, cache: {slots: 64}}", ROW, spacing, soil, digs, digs / 2);
	support_store(store, extent, hosted_flat);
	const struct furrow_open open = hosted_open(scene, store);
	done(furrow_world_open(&open, &world));
	assert_non_null(world);
	return world;
}

/* Rolls a body with a slip of 0.2, `sunk` metres below the level ground. lies: its own z is its axle. */
static struct told roll(const char *shape, bool lies, const char *soil, double spacing, double heading, double sunk, double digs)
{
	struct furrow_world *world = open_world(soil, spacing, digs);
	const double c = cos(heading), s = sin(heading), turns = 1 / (RADIUS * (1 - 0.2));
	const int rows = (int)lround(0.6 / ROW);
	furrow_body body;
	char text[400];
	struct told told = {.sinkage = 0};
	int count = 0;
	snprintf(text, sizeof text, "{shape: {%s}}", shape);
	done(furrow_body_add(world, text, &body));
	for (int i = 0; i <= rows; i++) {
		struct furrow_contact contact;
		struct furrow_state state = hosted_state(10.013 + c * i * ROW, 10.007 + s * i * ROW, 100 + RADIUS - sunk);
		if (lies)
			probing_turn((const double[]){1, 0, 0}, M_PI / 2, state.pose.orientation);
		probing_turn((const double[]){0, 1, 0}, i * ROW * turns, state.pose.orientation);
		probing_turn((const double[]){0, 0, 1}, heading, state.pose.orientation);
		if (i == 0) {
			done(furrow_place(world, body, &state.pose));
			continue;
		}
		state.linear[0] = c; /* a row takes as many seconds as it has metres */
		state.linear[1] = s;
		state.angular[0] = -s * turns;
		state.angular[1] = c * turns;
		probing_step(world, body, &state, ROW);
		done(furrow_get_contacts(world, 1, &body, &contact, sizeof contact));
		if (2 * i <= rows)
			continue;
		const double *f = contact.force, *m = contact.moment;
		const double forces[3] = {c * f[0] + s * f[1], c * f[1] - s * f[0], f[2]}, moments[3] = {c * m[0] + s * m[1], c * m[1] - s * m[0], m[2]};
		for (int k = 0; k < 3; k++) {
			told.force[k] += forces[k];
			told.moment[k] += moments[k];
		}
		told.sinkage += contact.sinkage;
		count++;
	}
	done(furrow_world_close(world));
	for (int k = 0; k < 3; k++) {
		told.force[k] /= count;
		told.moment[k] /= count;
	}
	told.sinkage /= count;
	return told;
}

/* Returns the largest difference: of forces as a share of the force, of moments as a share of the force times the radius, and of the sinkage. */
static double difference(const struct told *one, const struct told *other)
{
	const double *f = one->force, size = sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
	double most = fabs(other->sinkage / one->sinkage - 1);
	for (int k = 0; k < 3; k++) {
		most = support_most(most, fabs(other->force[k] - f[k]) / size);
		most = support_most(most, fabs(other->moment[k] - one->moment[k]) / (size * RADIUS));
	}
	return most;
}

static const double spacings[] = {0.05, 0.025}, headings[] = {0, 0.41};

static void a_host_rolls_a_cylinder_as_a_wheel(void **state)
{
	static const char *const soils[] = {"dry_sand", "lean_clay_22"};
	char wheel[100], cylinder[100];
	(void)state;
	snprintf(wheel, sizeof wheel, "wheel: {radius: %g, width: %g}", RADIUS, WIDTH);
	snprintf(cylinder, sizeof cylinder, "cylinder: {radius: %g, length: %g}", RADIUS, WIDTH);
	for (int i = 0; i < 16; i++) {
		const char *soil = soils[i / 8];
		const double spacing = spacings[i / 2 % 2], heading = headings[i % 2], digs = i / 4 % 2;
		const struct told one = roll(wheel, false, soil, spacing, heading, 0.015, digs), other = roll(cylinder, true, soil, spacing, heading, 0.015, digs);
		print_message("%s, %g m, heading %g, slip_sinkage %g: wheel %.1f %.1f %.1f N; cylinder differs by %.4f %%\n", soil, spacing, heading, digs, one.force[0],
			      one.force[1], one.force[2], 100 * difference(&one, &other));
		assert_true(one.force[2] > 50);
		assert_true(difference(&one, &other) < 1e-3);
	}
}

/* In sand, where the width of the patch hardly counts. The posts of 5 cm see the mesh and its hollow in steps. */
static void a_host_rolls_a_mesh_as_a_wheel(void **state)
{
	char wheel[100], drum[300];
	(void)state;
	hosted_write_drum(RADIUS * sqrt(2 * M_PI / FACETS / sin(2 * M_PI / FACETS)), WIDTH, FACETS); /* the prism has the wheel's area */
	snprintf(wheel, sizeof wheel, "wheel: {radius: %g, width: %g}", RADIUS, WIDTH);
	snprintf(drum, sizeof drum, "mesh: {file: %s}", support_path("drum.obj"));
	for (int i = 0; i < 8; i++) {
		const double spacing = spacings[i / 2 % 2], heading = headings[i % 2], digs = i / 4;
		const struct told one = roll(wheel, false, "dry_sand", spacing, heading, 0.02, digs), other = roll(drum, false, "dry_sand", spacing, heading, 0.02, digs);
		print_message("%g m, heading %g, slip_sinkage %g: wheel %.1f %.1f %.1f N; mesh of %d facets differs by %.2f %%\n", spacing, heading, digs, one.force[0],
			      one.force[1], one.force[2], FACETS, 100 * difference(&one, &other));
		assert_true(difference(&one, &other) < (spacing > 0.03 ? 0.05 : 0.02));
	}
}

TEST_PROGRAM(round)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_host_rolls_a_cylinder_as_a_wheel),
		cmocka_unit_test(a_host_rolls_a_mesh_as_a_wheel),
	};
	return cmocka_run_group_tests_name("api/round", tests, support_enter, support_leave);
}
