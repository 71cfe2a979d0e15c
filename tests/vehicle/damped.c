/* Soil that damps very much, and is very stiff: a body that falls on it, or lies on it, never gains energy; where damping presses more than is summed, the drive ends with what to do. */
#include <math.h>

#include "drive.h"
#include "../support/program.h"

#define COUNT(array) (sizeof(array) / sizeof(array)[0])
#define GRAVITY 9.81

static const struct extent extent = {129, 129, 0.25, 64};

static double level(int64_t x, int64_t y)
{
	(void)x;
	(void)y;
	return 0;
}

struct fall {
	const char *shape;   /* and size */
	double damping, stiffness, kphi, mass, step, height, roll;
};

/* Drops a body. *rise: J, by how much its energy was ever above that at the start. *most: J, of energy that was put in. */
static enum status drop(const struct fall *fall, double *rise, double *most)
{
	static struct drive_row rows[2048];
	char text[1200], model[300];
	const char *store = support_path("world.furrow"), *scene = support_path("scene.yaml");
	support_store(store, extent, level);
	snprintf(model, sizeof model, "<mujoco><worldbody><body name=\"b\"><freejoint/><geom name=\"g\" %s mass=\"%g\"/></body></worldbody></mujoco>", fall->shape, fall->mass);
	support_write(support_path("model.xml"), model);
	snprintf(text, sizeof text, "scene: 1\nend_time: %g\ntime_step: %g\nspacing: 0.03125\nsoil: {bekker_kc: 0, bekker_kphi: %g, bekker_n: 1, cohesion: 1000, friction_angle: 30, "
				    "janosi_shear: 0.01, damping: %g, elastic_stiffness: %g}\nredistribute: {model: scm}\nvehicles:\n  - {name: v, model: model.xml, start: {at: [16, 16], "
				    "height: %g, roll: %g, settle: false}}\noutput: {vehicles: 2000}\n", sqrt(2 * fall->height / GRAVITY) + 0.4, fall->step, fall->kphi, fall->damping,
		 fall->stiffness, fall->height, fall->roll);
	support_write(scene, text);
	unlink(support_path("over.furrow"));
	const enum status status = make_drive(scene, store, NULL, &(struct drive_cut){.out = support_path("out"), .overlay = support_path("over.furrow")}, NULL);
	const size_t count = drive_rows(support_path("out/vehicles.csv"), "v", rows, COUNT(rows));
	assert_true(count > 2 || status != STATUS_OK);
	*rise = 0;
	*most = fall->mass * GRAVITY * fmax(fall->height, 0.01);
	for (size_t i = 1; i < count; i++)
		*rise = fmax(*rise, rows[i].kinetic - rows[0].kinetic + fall->mass * GRAVITY * (rows[i].z - rows[0].z) - rows[i].work);
	return status;
}

static const char box[] = "type=\"box\" size=\".25 .2 .1\"", ball[] = "type=\"sphere\" size=\".15\"", can[] = "type=\"cylinder\" size=\".15 .1\"";

static void a_fall_gains_no_energy(void **state)
{
	static const struct fall falls[] = {
		{box, 1e6, 1e9, 2e6, 20, 0.002, 0.5, 0}, {box, 1e6, 1e9, 1e9, 20, 0.01, 0.5, 0}, {box, 1e6, 1e9, 1e9, 2000, 0.01, 0, 0}, {box, 1e7, 1e9, 1e9, 20, 0.001, 1, 10},
		{box, 1e6, 1e10, 1e8, 60, 0.002, 2, 20}, {ball, 1e6, 1e9, 1e7, 100, 0.005, 1, 0}, {ball, 1e7, 1e10, 1e8, 5, 0.001, 0.3, 0}, {can, 1e6, 1e9, 2e8, 600, 0.01, 0.3, 30},
		{can, 1e5, 1e8, 1e6, 2, 0.002, 1, 10}, {box, 0, 1e9, 1e9, 20, 0.002, 0.5, 0}, {ball, 1e4, 1e9, 1e9, 3000, 0.001, 0.1, 0}, {box, 3e7, 1e9, 1e9, 50, 0.002, 0.2, 5},
	};
	(void)state;
	for (size_t i = 0; i < COUNT(falls); i++) {
		double rise, most;
		must(drop(&falls[i], &rise, &most));
		print_message("%s, %g Pa s/m, %g Pa/m: %.2e of its energy more\n", falls[i].shape, falls[i].damping, falls[i].stiffness, rise / most);
		assert_true(rise < 1e-3 * most);
	}
}

static void damping_beyond_what_is_summed_is_refused(void **state)
{
	static const struct fall falls[] = {
		{box, 1e9, 1e9, 1e9, 20, 0.001, 0.5, 0}, {box, 2.9e9, 3.3e9, 3.3e6, 22, 0.005, 0, 10}, {can, 4.6e8, 1.1e9, 1.7e9, 2400, 0.001, 5, 30}, {can, 1.1e9, 5.9e8, 4.8e7, 89, 0.005, 2, 30},
	};
	(void)state;
	for (size_t i = 0; i < COUNT(falls); i++) {
		struct fall less = falls[i];
		double rise, most;
		assert_int_equal(drop(&falls[i], &rise, &most), STATUS_FAILED);
		assert_true(rise < 1e-3 * most);
		const char *told = failure_message(), *advice = strstr(told, "of at most ");
		assert_non_null(strstr(told, "vehicles.v.g: soil.damping presses a post with more than 134 MPa"));
		assert_non_null(advice);
		less.damping = strtod(advice + strlen("of at most "), NULL);
		assert_true(less.damping > 0 && less.damping < falls[i].damping);
		must(drop(&less, &rise, &most)); /* what was advised is enough */
		assert_true(rise < 1e-3 * most);
	}
}

/* What slides on soil that damps: its shear grows as it sinks, and that is no damping along the normal. Returns where it is at the end, m. */
static double slide(const char *model, double damping)
{
	static struct drive_row rows[256];
	char text[900];
	const char *store = support_path("world.furrow"), *scene = support_path("scene.yaml");
	support_store(store, extent, level);
	support_write(support_path("model.xml"), model);
	snprintf(text, sizeof text, "scene: 1\nend_time: 0.5\ntime_step: 0.005\nspacing: 0.0078125\nsoil: {name: dry_sand, damping: %g}\nredistribute: {model: scm}\nvehicles:\n"
				    "  - {name: v, model: model.xml, start: {at: [16, 16], speed: 2}}\noutput: {vehicles: 200}\n", damping);
	support_write(scene, text);
	unlink(support_path("over.furrow"));
	must(make_drive(scene, store, NULL, &(struct drive_cut){.out = support_path("out"), .overlay = support_path("over.furrow")}, NULL));
	const size_t count = drive_rows(support_path("out/vehicles.csv"), "v", rows, COUNT(rows));
	assert_true(count > 2);
	return rows[count - 1].x - 16;
}

static void what_slides_drives(void **state)
{
	static const double dampings[] = {30000, 3e5}, masses[] = {300, 2000};
	(void)state;
	for (int i = 0; i < 2; i++) {
		char model[300];
		snprintf(model, sizeof model, "<mujoco><worldbody><body name=\"b\"><freejoint/><geom name=\"g\" type=\"box\" size=\".5 .2 .1\" mass=\"%g\"/></body></worldbody></mujoco>",
			 masses[i]);
		const double way = slide(model, dampings[i]);
		print_message("%g kg, %g Pa s/m: %.3f m\n", masses[i], dampings[i], way);
		assert_true(way > 0.15 && way < 0.9);
	}
}

TEST_PROGRAM(damped)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_fall_gains_no_energy),
		cmocka_unit_test(what_slides_drives),
		cmocka_unit_test(damping_beyond_what_is_summed_is_refused),
	};
	return cmocka_run_group_tests_name("vehicles on soil that damps very much", tests, support_enter, support_leave);
}
