/*
 * Energy and step size. A body that falls on the soil never has more energy than it began with, and springs back no higher than the
 * soil's elastic part lets it. What a motor does is found again in the soil, in height and in motion. A shorter time step changes where a
 * vehicle comes to by less and less.
 */
#include <math.h>

#include "../support/near.h"
#include "drive.h"
#include "../support/program.h"

static const struct extent extent = {129, 129, 0.25, 64};

static double flat(int64_t x, int64_t y)
{
	(void)x, (void)y;
	return 20;
}

static size_t drive(const char *keys, const char *vehicle, const char *const *settings, struct drive_row *rows, size_t most)
{
	char text[2048];
	const char *store = support_path("world.furrow");
	snprintf(text, sizeof text, "scene: 1\nend_time: 3\ntime_step: 0.002\nspacing: 0.0625\nsoil: {name: dry_sand}\nredistribute: {model: scm}\n%s\n"
				    "vehicles:\n  - {name: v, %s}\noutput: {vehicles: 500}\n", keys, vehicle);
	support_write(support_path("scene.yaml"), text);
	support_store(store, extent, flat);
	must(make_drive(support_path("scene.yaml"), store, settings, &(struct drive_cut){.out = support_path("out")}, NULL));
	return drive_rows(support_path("out/vehicles.csv"), "v", rows, most);
}

/* A block hangs on a slide that a motor pulls up; when the motor lets go, it falls by half a metre. */
static void a_fall_ends_in_the_soil(void **state)
{
	static struct drive_row rows[4000];
	(void)state;
	support_write(support_path("block.xml"),
		      "<mujoco><option timestep=\"0.0005\"/><worldbody><body pos=\"0 0 0.2\"><joint name=\"z\" type=\"slide\" axis=\"0 0 1\"/>"
		      "<geom name=\"block\" type=\"box\" size=\"0.3 0.3 0.2\" mass=\"60\"/></body></worldbody>"
		      "<actuator><motor name=\"lift\" joint=\"z\"/></actuator></mujoco>");
	/* 981 N for 0.4 s lift 60 kg by about half a metre; its weight is 588.6 N. */
	support_write(support_path("controls.csv"), "t,lift\n0,981\n0.4,981\n0.4001,0\n");
	const size_t count = drive("", "model: block.xml, start: {at: [16, 16]}, driver: {controls: controls.csv}",
				   (const char *const[]){"time_step=0.0005", "output.vehicles=2000", "end_time=1.8", NULL}, rows, 4000);
	assert_int_equal(count, 3601);
	double highest = 0, after = 0;
	size_t top = 0, bottom = 0;
	for (size_t i = 1; i < count; i++)
		if (rows[i].z > rows[top].z)
			top = i;
	highest = rows[top].z - rows[0].z;
	for (bottom = top; bottom + 1 < count && rows[bottom + 1].z <= rows[bottom].z;)
		bottom++;
	for (size_t i = bottom; i < count; i++)
		after = support_most(after, rows[i].z - rows[bottom].z);
	print_message("rose by %.3f m, sank by %.1f mm, sprang back by %.2f mm\n", highest, (rows[0].z - rows[bottom].z) * 1e3, after * 1e3);
	assert_true(highest > 0.4 && rows[bottom].z < rows[0].z);
	/* Mechanical energy above that at rest: never more than the motor's work. The soil only takes. MuJoCo's Euler steps move by the
	 * velocity at their end, so in free flight height is off by half a step's way. */
	for (size_t i = 0; i < count; i++) {
		const double weight = 60 * 9.81, own = 0.5 * 0.0005 * weight * fabs(rows[i].vz);
		const double energy = rows[i].kinetic + weight * (rows[i].z - rows[0].z), work = rows[i].work;
		if (!(energy <= work + own + 0.001 * rows[top].work + 0.02))
			fail_msg("%g J at %g s, and the motor did %g J", energy, rows[i].t, work);
	}
	/* It springs back by no more than the elastic energy at its lowest place, F^2 / (2 K_e A), lifts it. */
	const double sank = 20.2 - rows[bottom].z, force = 0.36 * (990 / 0.6 + 1528430) * pow(sank, 1.1), elastic = force * force / (2 * 4e7 * 0.36);
	print_message("%.1f mm deep it has %.1f J of elastic energy, and rises by %.2f J\n", sank * 1e3, elastic, 60 * 9.81 * after);
	assert_true(60 * 9.81 * after < elastic);
	assert_true(rows[count - 1].kinetic < 1e-6);
}

struct turned {
	double t, x, z, angle, kinetic, work, force;
};

/* What the rows tell of the wheel: its angle and its actuator's force from vehicles.csv, and from objects.csv what it did on the soil. */
static size_t read_turned(struct turned *rows, size_t most)
{
	char *text = support_text(support_path("out/vehicles.csv"));
	size_t count = 0;
	for (char *line = strchr(text, '\n'); line != NULL && line[1] != '\0' && count < most; line = strchr(line + 1, '\n'))
		count += sscanf(line + 1, "%lf,%*[^,],%lf,%*f,%lf,%*f,%*f,%*f,%*f,%*f,%*f,%lf,%lf,%*f,%*f,%lf,%*f,%lf", &rows[count].t, &rows[count].x, &rows[count].z,
				&rows[count].kinetic, &rows[count].work, &rows[count].angle, &rows[count].force) == 7;
	free(text);
	return count;
}

/* A motor drives a wheel from rest, without damping anywhere. Then its work is energy in the soil, in height and in motion. And the energy in the
 * soil is the integral of the soil's force over the way and of its moment over the angle, which the rows tell too. */
static void the_motor_s_work_is_in_the_soil_in_height_and_in_motion(void **state)
{
	static struct drive_row unused[2000];
	static struct turned rows[2000];
	(void)state;
	support_write(support_path("wheel.xml"), "<mujoco><option timestep=\"0.0005\"/><worldbody><body name=\"carriage\" pos=\"0 0 0.5\">"
		      "<joint type=\"slide\" axis=\"1 0 0\"/><joint type=\"slide\" axis=\"0 0 1\"/><inertial pos=\"0 0 0\" mass=\"70\" diaginertia=\"1 1 1\"/>"
		      "<body><joint name=\"turn\" axis=\"0 1 0\"/><geom name=\"wheel\" type=\"cylinder\" size=\"0.32 0.12\" euler=\"90 0 0\" mass=\"30\"/>"
		      "</body></body></worldbody><actuator><general name=\"drive\" joint=\"turn\" gainprm=\"0.5\" gear=\"2\"/></actuator></mujoco>");
	const size_t told = drive("", "model: wheel.xml, start: {at: [10, 16]}, driver: {hold: {drive: 70}}",
				  (const char *const[]){"time_step=0.0005", "end_time=1.2", "output={vehicles: 1000, forces: 1000}", NULL}, unused, 2000);
	const size_t count = read_turned(rows, 2000);
	assert_int_equal(count, 1201);
	assert_int_equal(told, count);
	char *text = support_text(support_path("out/objects.csv"));
	double integral = 0, soil = 0, before[4] = {0, 0, 0, 0};
	size_t at = 0;
	for (char *line = strchr(text, '\n'); line != NULL && line[1] != '\0'; line = strchr(line + 1, '\n'), at++) {
		double x, z, now[4]; /* fx, fz, ty */
		assert_true(at < count);
		assert_int_equal(sscanf(line + 1, "%*f,%*[^,],%lf,%*f,%lf,%*f,%lf,%*f,%lf,%*f,%lf,%*f,%*f,%*f,,%*[^,],%*[^,],%*f,%lf", &x, &z, &now[0], &now[1], &now[2], &soil), 6);
		for (int k = 0; k < 3 && at > 0; k++) {
			const struct turned *a = &rows[at - 1], *b = &rows[at];
			const double by[3] = {b->x - a->x, b->z - a->z, b->angle - a->angle};
			integral -= (before[k] + now[k]) / 2 * by[k];
		}
		memcpy(before, now, sizeof before);
	}
	free(text);
	assert_int_equal(at, count);
	const struct turned *end = &rows[count - 1];
	const double lifted = 100 * 9.81 * (end->z - rows[0].z), moving = end->kinetic - rows[0].kinetic;
	print_message("the motor did %.2f J: soil %.2f (by rows %.2f), height %.2f, motion %.2f\n", end->work, soil, integral, lifted, moving);
	assert_true(end->work > 50 && soil > 0.2 * end->work && moving > 0.05 * end->work);
	assert_true(fabs(soil + lifted + moving - end->work) < 0.0005 * end->work);
	assert_true(fabs(integral - soil) < 0.01 * soil);
	/* A control of 70 is a force of 35 N m, which the gear doubles at the hinge. */
	for (size_t i = 1; i < count; i++)
		assert_true(rows[i].force == 35 && fabs(rows[i].work - 70 * (rows[i].angle - rows[0].angle)) < 0.005 * end->work);
}

static void shorter_steps_converge(void **state)
{
	static struct drive_row rows[2000];
	static const char *const steps[] = {"0.008", "0.004", "0.002", "0.001"};
	double x[4], z[4];
	(void)state;
	for (int i = 0; i < 4; i++) {
		char model[1024], settings[2][64];
		snprintf(model, sizeof model, "<mujoco><option timestep=\"%s\" integrator=\"implicit\"/><worldbody><body name=\"carriage\" pos=\"0 0 0.5\">"
			 "<joint type=\"slide\" axis=\"1 0 0\"/><joint type=\"slide\" axis=\"0 0 1\"/><inertial pos=\"0 0 0\" mass=\"70\" diaginertia=\"1 1 1\"/>"
			 "<body><joint name=\"turn\" axis=\"0 1 0\"/><geom name=\"wheel\" type=\"cylinder\" size=\"0.32 0.12\" euler=\"90 0 0\" mass=\"30\"/>"
			 "</body></body></worldbody><actuator><velocity name=\"drive\" joint=\"turn\" kv=\"500\"/></actuator></mujoco>", steps[i]);
		support_write(support_path("wheel.xml"), model);
		snprintf(settings[0], sizeof settings[0], "time_step=%s", steps[i]);
		snprintf(settings[1], sizeof settings[1], "output.vehicles=20");
		const size_t count = drive("", "model: wheel.xml, start: {at: [10, 16]}, driver: {hold: {drive: 2}}",
					   (const char *const[]){settings[0], settings[1], NULL}, rows, 2000);
		x[i] = rows[count - 1].x;
		z[i] = rows[count - 1].z;
		print_message("%s s: came to %.5f m, %.3f mm deep\n", steps[i], x[i], (20.32 - z[i]) * 1e3);
	}
	assert_true(x[3] - 10 > 1.2);
	/* Where contacts fall between posts changes with the step, too: it moves the wheel's way by some millimetres. */
	static const double ways[3] = {0.016, 0.013, 0.006}, depths[3] = {1e-3, 4e-4, 2e-4};
	for (int i = 0; i < 3; i++)
		assert_true(fabs(x[i] - x[3]) < ways[i] * (x[3] - 10) && fabs(z[i] - z[3]) < depths[i]);
}

TEST_PROGRAM(energy)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_fall_ends_in_the_soil),
		cmocka_unit_test(the_motor_s_work_is_in_the_soil_in_height_and_in_motion),
		cmocka_unit_test(shorter_steps_converge),
	};
	return cmocka_run_group_tests_name("energy and steps of vehicles", tests, support_enter, support_leave);
}
