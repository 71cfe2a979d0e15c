/*
 * Pushes from outside: a force F for a time t gives a vehicle in the air the momentum F t, whatever the step; by a table and by a host, to the same
 * bits after a rollback. And what a wheel's surface is of decides what it pulls.
 */
#include <math.h>

#include "../api/hosted.h"
#include "../support/program.h"
#include "drive.h"
#include "rig.h"

static const struct extent extent = {129, 129, 0.25, 128};

static double ground(int64_t x, int64_t y)
{
	(void)x, (void)y;
	return 100;
}

/* A block on springs that are so long that it never leaves them: a frame that stands on the ground, and a free rider that slides on it without friction. */
static const char sled[] =
	"<mujoco><option timestep=\"0.002\"/><worldbody><body name=\"frame\" pos=\"0 0 0.25\"><freejoint/>"
	"<geom name=\"foot\" type=\"box\" size=\"1 1 0.25\" mass=\"5000\"/><body name=\"rider\" pos=\"0 0 1\">"
	"<joint name=\"x\" type=\"slide\" axis=\"1 0 0\"/><joint name=\"y\" type=\"slide\" axis=\"0 1 0\"/><joint name=\"turn\" axis=\"0 0 1\"/>"
	"<inertial pos=\"0 0 0\" mass=\"20\" diaginertia=\"2 2 4\"/></body></body></worldbody></mujoco>";

static void prepare(const char *more, const char *pushes)
{
	char text[1024];
	support_write(support_path("model.xml"), sled);
	if (pushes != NULL)
		support_write(support_path("pushes.csv"), pushes);
	snprintf(text, sizeof text, "scene: 1\nend_time: 1\ntime_step: 0.004\nspacing: 0.25\nsoil: {name: dry_sand}\nredistribute: {model: scm}\nvehicles:\n"
				    "  - {name: v, model: model.xml, start: {at: [15, 15]}, soil: [foot]%s}\noutput: {vehicles: 50}\n", more);
	support_write(support_path("scene.yaml"), text);
	support_store(support_path("world.furrow"), extent, ground);
}

/* Columns q:x, q:y, q:turn of the last rows of vehicles.csv. */
static void last_joints(double values[3], double before[3])
{
	char *text = support_text(support_path("out/vehicles.csv")), *line = text, *last = NULL, *other = NULL;
	for (; line != NULL && *line != '\0'; line = strchr(line, '\n') != NULL ? strchr(line, '\n') + 1 : NULL) {
		other = last;
		last = line;
	}
	for (int which = 0; which < 2; which++) {
		char *at = which == 0 ? last : other;
		assert_non_null(at);
		for (int i = 0; i < 13; i++)
			at = strchr(at, ',') + 1;
		assert_int_equal(sscanf(at, "%lf,%lf,%lf", &(which == 0 ? values : before)[0], &(which == 0 ? values : before)[1], &(which == 0 ? values : before)[2]), 3);
	}
	free(text);
}

static void a_table_brings_its_momentum(void **state)
{
	double now[3], before[3];
	(void)state;
	/* 100 N for 0.1237 s, which is no whole number of steps, then 40 N back for 0.1 s; beside it a moment of 8 N m for 0.25 s. */
	prepare(", pushes: pushes.csv", "t,body,fx,fy,fz,tx,ty,tz\n0.1001,rider,100,-50,0,0,0,8\n0.2238,rider,-40,0,0,0,0,8\n0.3238,rider,0,0,0,0,0,8\n0.3501,rider,0,0,0,0,0,0\n");
	must(make_drive(support_path("scene.yaml"), support_path("world.furrow"), NULL, &(struct drive_cut){.out = support_path("out")}, NULL));
	last_joints(now, before);
	const double wanted[3] = {(100 * 0.1237 - 40 * 0.1) / 20, -50 * 0.1237 / 20, 8 * 0.25 / 4};
	for (int i = 0; i < 3; i++) {
		const double rate = (now[i] - before[i]) * 50;
		print_message("momentum %d: %.6f, wanted %.6f\n", i, rate, wanted[i]);
		assert_true(fabs(rate - wanted[i]) < 0.002 * fabs(wanted[i]));
	}
}

static void wrong_tables_are_refused(void **state)
{
	static const struct {
		const char *text, *says;
	} cases[] = {
		{"", "pushes.csv:0: no row; allowed: at least one"},
		{"t,fx\n", ":1: another header; allowed: t,body,fx,fy,fz or"},
		{"t,body,fx,fy,fz\n", "no row; allowed: at least one"},
		{"t,body,fx,fy,fz\n0,hull,1,2,3\n", ":2: hull names no body of the model; there are: carriage, wheel"},
		{"t,body,fx,fy,fz\n0,wheel,1,2\n", ":2: another number of columns"},
		{"t,body,fx,fy,fz\n0,wheel,1,2,3,4\n", ":2: another number of columns"},
		{"t,body,fx,fy,fz\n0,wheel,1,nan,3\n", ":2: nan; allowed: numbers"},
		{"t,body,fx,fy,fz\n0,wheel,1,,3\n", "; allowed: numbers"},
		{"t,body,fx,fy,fz\n-1,wheel,1,0,3\n", ":2: t is below 0"},
		{"t,body,fx,fy,fz\n1,wheel,1,0,3\n0,carriage,1,1,1\n1,wheel,0,0,0\n", ":4: t does not grow"},
	};
	(void)state;
	rig_model("", "", "");
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		support_write(support_path("pushes.csv"), cases[i].text);
		rig_refused("time_step: 0.002", ", pushes: pushes.csv", STATUS_INPUT, cases[i].says);
	}
	rig_refused("time_step: 0.002", ", interface: {track*: steel}", STATUS_INPUT, "interface: track* names no geom that presses the ground; the first of them is wheel");
	rig_refused("time_step: 0.002", ", forward: +y, up: y", STATUS_INPUT, "forward: looks where up: y looks");
	rig_refused("time_step: 0.002", ", driver: {path: {points: [[1, 1], [2, 2]]}, drive: [drive]}", STATUS_INPUT, "has no speed; allowed: exactly one of speed, speeds");
	rig_refused("time_step: 0.002", ", driver: {path: {points: [[1, 1], [2, 2]], speeds: [1, -1]}, drive: [drive]}", STATUS_INPUT, "speeds[1]: -1 goes no way on");
	rig_refused("time_step: 0.002", ", driver: {path: {points: [[1, 1], [2, 2]], speeds: [1]}, drive: [drive]}", STATUS_INPUT, "has 1; allowed: one for each of points");
	rig_refused("time_step: 0.002", ", driver: {path: {points: [[1, 1], [2, 2]], speed: 1, stop: [[2, 1]]}, drive: [drive]}", STATUS_INPUT, "ends before it begins");
	rig_refused("time_step: 0.002", ", driver: {path: {points: [[1, 1], [2, 2]], speed: 0}, drive: [drive]}", STATUS_INPUT, "0 goes no way");
}

static void run(struct furrow_world *world, size_t rider, double values[3])
{
	const double force[3] = {30, 0, 0}, torque[3] = {0, 0, 2};
	done(furrow_set_force(world, 0, rider, force, torque));
	for (int i = 0; i < 50; i++)
		done(furrow_step(world, 0));
	done(furrow_set_force(world, 0, rider, NULL, NULL));
	for (int i = 0; i < 50; i++)
		done(furrow_step(world, 0));
	done(furrow_get_joints(world, 0, 3, values, NULL));
}

static void a_host_pushes_to_the_same_bits(void **state)
{
	struct furrow_world *world = NULL;
	double first[3], again[3], rates[3];
	size_t rider = 0;
	const double endless[3] = {INFINITY, 0, 0};
	(void)state;
	prepare("", NULL);
	const struct furrow_open open = {.size = sizeof open, .scene_file = support_path("scene.yaml"), .store = support_path("world.furrow"), .overlay = support_path("over.furrow")};
	done(furrow_world_open(&open, &world));
	while (strcmp(furrow_vehicle_part(world, 0, FURROW_MODEL_BODY, rider), "rider") != 0)
		rider++;
	assert_null(furrow_vehicle_part(world, 0, FURROW_MODEL_BODY, rider + 1));
	done(furrow_checkpoint(world));
	run(world, rider, first);
	done(furrow_get_joints(world, 0, 3, NULL, rates));
	print_message("pushed by a host: %.6f m/s, %.6f rad/s\n", rates[0], rates[2]);
	assert_true(fabs(rates[0] - 30 * 0.2 / 20) < 0.002 * 0.3 && fabs(rates[2] - 2 * 0.2 / 4) < 0.002 * 0.1);
	done(furrow_rollback(world));
	run(world, rider, again);
	assert_memory_equal(first, again, sizeof first);
	misused(furrow_set_force(world, 0, rider + 1, NULL, NULL));
	misused(furrow_set_force(world, 0, rider, endless, NULL));
	misused(furrow_set_force(world, 1, rider, NULL, NULL));
	done(furrow_world_close(world));
}

/* A block that is dragged over the ground is held back by W tan delta, or by the soil's own strength if that is less. What comes under its front is not
 * sheared yet: Janosi's law takes at most K / length of it. */
static void a_surface_decides_what_holds(void **state)
{
	static const char block[] =
		"<mujoco><option timestep=\"0.002\" integrator=\"implicit\"/><worldbody><body name=\"block\" pos=\"0 0 0.25\"><joint name=\"x\" type=\"slide\" axis=\"1 0 0\"/>"
		"<joint name=\"z\" type=\"slide\" axis=\"0 0 1\"/><geom name=\"foot\" type=\"box\" size=\"0.5 0.5 0.25\" mass=\"400\"/></body></worldbody>"
		"<actuator><velocity name=\"drag\" joint=\"x\" kv=\"1e6\"/></actuator></mujoco>";
	static const struct {
		const char *interface;
		double degrees;
	} surfaces[] = {{"", 0}, {", interface: {foot: rubber}", 0}, {", interface: {foot: steel}", 17}, {", interface: {foot: {friction_angle: 10, adhesion: 0}}", 10}};
	struct soil_numbers soil;
	double held[4];
	(void)state;
	must(soil_named("dry_sand", &soil));
	for (size_t i = 0; i < 4; i++) {
		static struct drive_row rows[200];
		char text[1024];
		support_write(support_path("model.xml"), block);
		support_write(support_path("controls.csv"), "t,drag\n0,0\n0.2,0.05\n");
		snprintf(text, sizeof text, "scene: 1\nend_time: 3\ntime_step: 0.004\nspacing: 0.125\nsoil: {name: dry_sand, damping: 0}\n"
					    "redistribute: {model: scm, slip_sinkage: 0, bulldozing: 0, faces: off}\nvehicles:\n"
					    "  - {name: v, model: model.xml, start: {at: [15, 15]}, soil: [foot]%s, driver: {controls: controls.csv}}\noutput: {vehicles: 20}\n",
			 surfaces[i].interface);
		support_write(support_path("scene.yaml"), text);
		support_store(support_path("world.furrow"), extent, ground);
		must(make_drive(support_path("scene.yaml"), support_path("world.furrow"), NULL, &(struct drive_cut){.out = support_path("out")}, NULL));
		const size_t count = drive_rows(support_path("out/vehicles.csv"), "v", rows, 200);
		const struct drive_row *from = &rows[count * 3 / 4], *to = &rows[count - 1];
		held[i] = (to->work - from->work) / (to->x - from->x);
		const double wanted = 400 * 9.81 * tan(surfaces[i].degrees * M_PI / 180);
		print_message("\"%s\": held back by %.1f N, W tan delta %.1f\n", surfaces[i].interface, held[i], wanted);
		if (surfaces[i].degrees > 0)
			assert_true(held[i] < wanted && held[i] > (1 - soil.janosi_shear) * wanted);
	}
	assert_true(held[0] == held[1] && held[0] > 1.5 * held[2]); /* rubber is rough */
}

TEST_PROGRAM(pushes)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_table_brings_its_momentum),
		cmocka_unit_test(wrong_tables_are_refused),
		cmocka_unit_test(a_host_pushes_to_the_same_bits),
		cmocka_unit_test(a_surface_decides_what_holds),
	};
	return cmocka_run_group_tests_name("pushes and surfaces", tests, support_enter, support_leave);
}
