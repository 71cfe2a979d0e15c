/* Vehicles whose soil geoms are capsules, ellipsoids, meshes, cylinders that stand, and wheels that lean: they stand, and the soil carries
 * their weight. */
#include <math.h>

#include "drive.h"
#include "../support/program.h"

static const struct extent extent = {65, 65, 0.25, 64};

static double ground(int64_t x, int64_t y)
{
	(void)x;
	(void)y;
	return 100;
}

#define FOOT_FORMAT "<geom %s mass=\"5\" pos=\"%g %g %g\"/>"

/* A table of 50 kg on four feet. foot: a geom's attributes; down: its centre below the table. */
static void write_table(const char *foot, double down)
{
	char text[4096], feet[2048];
	size_t at = 0;
	for (int i = 0; i < 4; i++)
		at += (size_t)snprintf(feet + at, sizeof feet - at, FOOT_FORMAT, foot, i & 1 ? 0.4 : -0.4, i & 2 ? 0.3 : -0.3, -down);
	snprintf(text, sizeof text,
		 "<mujoco><option timestep=\"0.001\" integrator=\"implicit\"/><asset><mesh name=\"block\" vertex=\"-0.1 -0.08 -0.1  0.1 -0.08 -0.1  0.1 0.08 -0.1 "
		 "-0.1 0.08 -0.1  -0.14 -0.12 0.1  0.14 -0.12 0.1  0.14 0.12 0.1  -0.14 0.12 0.1\"/></asset><worldbody><body pos=\"0 0 0.5\"><freejoint/>"
		 "<geom type=\"box\" size=\"0.5 0.4 0.02\" mass=\"30\" contype=\"0\" conaffinity=\"0\"/>%s</body></worldbody></mujoco>", feet);
	support_write(support_path("model.xml"), text);
}

/* A plate on `across` times `across` feet. */
static void write_plate(int across, double mass)
{
	static char text[32768];
	size_t at = (size_t)snprintf(text, sizeof text, "<mujoco><option timestep=\"0.01\" integrator=\"implicit\"/><worldbody><body pos=\"0 0 0.5\"><freejoint/>"
							"<inertial pos=\"0 0 0\" mass=\"%g\" diaginertia=\"20 20 20\"/>", mass);
	for (int i = 0; i < across * across; i++)
		at += (size_t)snprintf(text + at, sizeof text - at, "<geom type=\"sphere\" size=\"0.05\" pos=\"%g %g -0.05\"/>", 0.15 * (i % across - (across - 1) / 2.0),
				       0.15 * (i / across - (across - 1) / 2.0));
	snprintf(text + at, sizeof text - at, "</body></worldbody></mujoco>");
	support_write(support_path("model.xml"), text);
}

/* A carriage that slides up and down only, with two wheels that lean outwards by `degrees` and do not turn by themselves. */
static void write_wheels(double degrees, const char *user)
{
	char text[4096];
	snprintf(text, sizeof text,
		 "<mujoco><size nuser_geom=\"3\"/><option timestep=\"0.001\" integrator=\"implicit\"/><worldbody><body name=\"carriage\" pos=\"0 0 0.5\">"
		 "<joint type=\"slide\" axis=\"1 0 0\"/><joint type=\"slide\" axis=\"0 1 0\"/><joint type=\"slide\" axis=\"0 0 1\"/><inertial pos=\"0 0 0\" mass=\"60\" diaginertia=\"5 5 5\"/>"
		 "<body pos=\"0 0.5 0\" euler=\"%g 0 0\"><joint axis=\"0 1 0\" damping=\"100\"/><geom type=\"cylinder\" size=\"0.32 0.12\" euler=\"90 0 0\" mass=\"20\" user=\"%s\"/></body>"
		 "<body pos=\"0 -0.5 0\" euler=\"%g 0 0\"><joint axis=\"0 1 0\" damping=\"100\"/><geom type=\"cylinder\" size=\"0.32 0.12\" euler=\"90 0 0\" mass=\"20\" user=\"%s\"/></body>"
		 "</body></worldbody></mujoco>", degrees, user, -degrees, user);
	support_write(support_path("model.xml"), text);
}

/* Returns the sum of the vertical forces in the last rows of objects.csv. *least: the least of them. */
static double carried(double *least)
{
	char *text = support_text(support_path("out/objects.csv"));
	double last = -1, sum = 0;
	for (char *line = strchr(text, '\n'); line != NULL && line[1] != '\0'; line = strchr(line + 1, '\n')) {
		double t, fz;
		assert_int_equal(sscanf(line + 1, "%lf,%*[^,],%*f,%*f,%*f,%*f,%*f,%*f,%lf", &t, &fz), 2);
		*least = t > last ? fz : fmin(*least, fz);
		sum = t > last ? fz : sum + fz;
		last = t;
	}
	free(text);
	return sum;
}

static void drive(double time_step, double seconds)
{
	const char *store = support_path("world.furrow");
	char text[512];
	snprintf(text, sizeof text, "scene: 1\nend_time: %g\ntime_step: %g\nspacing: 0.03125\nsoil: {name: dry_sand}\nredistribute: {model: scm}\n"
				    "vehicles:\n  - {name: v, model: model.xml, start: {at: [8.01, 8.02], yaw: 20}}\noutput: {forces: 20, vehicles: 20}\n",
		 seconds, time_step);
	support_write(support_path("scene.yaml"), text);
	support_store(store, extent, ground);
	must(make_drive(support_path("scene.yaml"), store, NULL, &(struct drive_cut){.out = support_path("out")}, NULL));
}

/* still: how far it may move, m. */
static void stands(const char *what, double mass, double still)
{
	struct drive_row rows[64];
	double least = 0;
	drive(0.001, 0.6);
	const size_t count = drive_rows(support_path("out/vehicles.csv"), "v", rows, 64);
	const double weight = mass * 9.81, sum = carried(&least);
	print_message("%s: %.2f N of %.2f N, the least %.2f N, %.3g J, moved by %.3g m\n", what, sum, weight, least, rows[count - 1].kinetic,
		      fabs(rows[count - 1].z - rows[0].z));
	assert_true(count == 13 && fabs(sum - weight) < (strncmp(what, "capsules", 8) == 0 ? 0.004 : 0.002) * weight && least > 0.1 * weight);
	assert_true(rows[count - 1].kinetic < 1e-6 * weight && fabs(rows[count - 1].z - rows[0].z) < still);
}

static void feet_of_every_shape_carry_their_load(void **state)
{
	(void)state;
	write_table("type=\"capsule\" size=\"0.08 0.15\"", 0.2);
	stands("capsules", 50, 2e-5);
	write_table("type=\"capsule\" size=\"0.08 0.15\" euler=\"50 0 30\"", 0.2);
	stands("capsules that lean", 50, 2e-5);
	write_table("type=\"ellipsoid\" size=\"0.15 0.1 0.08\" euler=\"0 15 10\"", 0.2);
	stands("ellipsoids", 50, 2e-5);
	write_table("type=\"cylinder\" size=\"0.08 0.15\"", 0.2);
	stands("cylinders", 50, 2e-5);
	write_table("type=\"cylinder\" size=\"0.08 0.15\" euler=\"90 0 0\"", 0.2);
	stands("cylinders that lie", 50, 2e-5);
	write_table("type=\"mesh\" mesh=\"block\"", 0.2);
	stands("meshes", 50, 2e-5);
}

static void each_of_a_hundred_feet_carries_its_load(void **state)
{
	(void)state;
	const double weight = 200 * 9.81;
	double least = 0;
	write_plate(10, 200);
	drive(0.01, 0.1);
	const double sum = carried(&least);
	print_message("a hundred feet: %.2f N of %.2f N, the least %.2f N\n", sum, weight, least);
	assert_true(fabs(sum - weight) < 0.002 * weight && least > 0.5 * weight / 100);
}

static void wheels_that_lean_carry_their_load(void **state)
{
	(void)state;
	write_wheels(0, "0");
	stands("wheels", 100, 2e-5);
	write_wheels(9, "0");
	stands("wheels that lean by 9 degrees", 100, 2e-5);
	write_wheels(-3, "0");
	stands("wheels that lean by -3 degrees", 100, 2e-5);
	write_wheels(0, "20 0.02 0.03");
	stands("wheels with grousers", 100, 2e-4);
}

TEST_PROGRAM(shapes)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(feet_of_every_shape_carry_their_load),
		cmocka_unit_test(each_of_a_hundred_feet_carries_its_load),
		cmocka_unit_test(wheels_that_lean_carry_their_load),
	};
	return cmocka_run_group_tests_name("vehicle/shapes", tests, support_enter, support_leave);
}
