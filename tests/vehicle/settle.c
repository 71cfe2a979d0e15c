/*
 * A vehicle that is set down and left alone sinks as deep as soil carries it at rest, and stays there: on level ground and on slopes.
 */
#include <math.h>

#include "drive.h"
#include "../support/program.h"
#include "vehicle/settle.h"

static const struct extent extent = {65, 65, 0.25, 64};
static double slope; /* tangent */

static double ground(int64_t x, int64_t y)
{
	(void)y;
	return 100 + slope * 0.25 * (double)x;
}

static void write_scene(const char *model, const char *more)
{
	char text[2048];
	snprintf(text, sizeof text, "scene: 1\nend_time: 4\ntime_step: 0.002\nspacing: 0.03125\nsoil: {name: dry_sand}\nredistribute: {model: scm}\n"
				    "vehicles:\n  - {name: v, model: %s, start: {at: [8, 8]}%s}\noutput: {forces: 20, vehicles: 20}\n", model, more);
	support_write(support_path("scene.yaml"), text);
}

static size_t drive(const char *const *settings, struct drive_row *rows, size_t most)
{
	const char *store = support_path("world.furrow");
	support_store(store, extent, ground);
	must(make_drive(support_path("scene.yaml"), store, settings, &(struct drive_cut){.out = support_path("out")}, NULL));
	return drive_rows(support_path("out/vehicles.csv"), "v", rows, most);
}

static void copy_model(const char *name)
{
	char path[512];
	snprintf(path, sizeof path, "%s/%s", getenv("MODELS"), name);
	char *text = support_text(path);
	support_write(support_path(name), text);
	free(text);
}

struct law {
	double modulus, n, cohesion, tangent, shear; /* SI; `shear`: K */
};

/*
 * Vertical force of a wheel that was pressed straight down, on both sides of its lowest point. Stresses act along its own normals. A place
 * of the rim that is d deep has slid d sin(theta) along the soil, theta being its angle, and the soil's shear holds it up.
 */
static double two_sided(double depth, double radius, double width, const struct law *law)
{
	const double half = sqrt(depth * (2 * radius - depth));
	const int parts = 4000;
	double sum = 0;
	for (int i = 0; i < parts; i++) {
		const double x = half * (i + 0.5) / parts, d = fmax(depth - (radius - sqrt(radius * radius - x * x)), 0);
		const double stress = law->modulus * pow(d, law->n), sine = x / radius, tangent = sine / sqrt(1 - sine * sine);
		sum += stress + (law->cohesion + stress * law->tangent) * (1 - exp(-d * sine / law->shear)) * tangent;
	}
	return 2 * width * sum * half / parts;
}

static double depth_of(double load, double radius, double width, const struct law *law)
{
	double low = 1e-6, high = 0.99 * radius;
	for (int i = 0; i < 60; i++) {
		const double middle = (low + high) / 2;
		*(two_sided(middle, radius, width, law) < load ? &low : &high) = middle;
	}
	return low;
}

static void a_wheel_settles_at_the_two_sided_arc(void **state)
{
	static const struct {
		const char *soil, *gravity;
		double weight;
		struct law law;
	} cases[] = {
		{"soil={name: dry_sand}", "gravity=9.81", 981, {990 / 0.24 + 1528430, 1.1, 1040, 0.5317094, 0.02}},
		{"soil={name: dry_sand}", "gravity=3", 300, {990 / 0.24 + 1528430, 1.1, 1040, 0.5317094, 0.02}},
		{"soil={name: dry_sand, bekker_kc: 0, bekker_kphi: 200000, cohesion: 0, friction_angle: 30, janosi_shear: 0.01}", "gravity=9.81", 981,
		 {200000, 1.1, 0, 0.5773503, 0.01}},
		{"soil={name: lunar}", "gravity=1.62", 162, {1400 / 0.24 + 820000, 1, 170, 0.7002075, 0.018}},
	};
	(void)state;
	slope = 0;
	copy_model("one_wheel.xml");
	write_scene("one_wheel.xml", "");
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		struct drive_row rows[128];
		const char *const settings[] = {cases[i].soil, cases[i].gravity, "end_time=1", NULL};
		const size_t count = drive(settings, rows, 128);
		const double wanted = depth_of(cases[i].weight, 0.32, 0.24, &cases[i].law);
		const double is = 100 + 0.32 - rows[count - 1].z;
		print_message("%s: %.3f mm, the arc %.3f mm\n", cases[i].soil, is * 1e3, wanted * 1e3);
		assert_true(count == 21 && fabs(is - wanted) < 0.005 * wanted);
		/* It stays: its rows are all alike, and nothing moves. */
		for (size_t r = 0; r < count; r++)
			assert_true(fabs(rows[r].z - rows[0].z) < 1e-3 * wanted && rows[r].kinetic < 1e-9 * cases[i].weight);
		assert_true(fabs(rows[count - 1].z - rows[count - 2].z) < 1e-6);
		assert_true(hypot(rows[count - 1].x - rows[0].x, rows[count - 1].y - rows[0].y) < 1e-8);
	}
}

/* A block of 60 kg on 15 degrees: shear grows until it holds, and then nothing creeps. */
static void a_block_holds_on_a_slope(void **state)
{
	struct drive_row rows[256];
	(void)state;
	support_write(support_path("block.xml"),
		      "<mujoco><option timestep=\"0.002\"/><worldbody><body pos=\"0 0 0.15\" euler=\"0 -15 0\"><freejoint/>"
		      "<geom name=\"block\" type=\"box\" size=\"0.3 0.25 0.15\" mass=\"60\"/></body></worldbody></mujoco>");
	write_scene("block.xml", "");
	slope = tan(15 * M_PI / 180);
	const size_t count = drive((const char *const[]){"end_time=8", "output.vehicles=10", NULL}, rows, 256);
	assert_int_equal(count, 81);
	const struct drive_row *last = &rows[80], *before = &rows[70];
	const double drift = hypot(last->x - before->x, last->z - before->z);
	print_message("slid %.2f mm before it held; drifts by %.3g um/s\n", 1e3 * hypot(rows[0].x - 8, 0), drift * 1e6);
	assert_true(drift < 1e-7);
	assert_true(last->kinetic < 1e-9);
	assert_true(fabs(last->pitch - 15) < 2);
}

/* A motor turns a mass for ever, and no time calms it: settling ends after 15 s of slowed and 10 s of free motion, and says so. */
/* Returns after how many seconds of settling a vehicle starts in which a torque, N m, turns something for ever. */
static double settled_after(const char *torque)
{
	struct drive_row rows[64];
	char *json, hold[100], control[100];
	support_write(support_path("spins.xml"),
		      "<mujoco><option timestep=\"0.005\"/><worldbody><body pos=\"0 0 0.15\"><freejoint/><geom type=\"box\" size=\"0.3 0.25 0.15\" mass=\"60\"/>"
		      "<body pos=\"0 0 0.3\"><joint name=\"spin\" axis=\"0 0 1\" damping=\"0.05\"/><geom type=\"sphere\" size=\"0.1\" mass=\"20\" contype=\"0\" conaffinity=\"0\"/></body></body></worldbody>"
		      "<actuator><motor name=\"spin\" joint=\"spin\"/></actuator></mujoco>");
	snprintf(hold, sizeof hold, ", driver: {hold: {spin: %s}}", torque);
	snprintf(control, sizeof control, "vehicles.v.start.controls={spin: %s}", torque);
	write_scene("spins.xml", hold);
	slope = 0;
	support_store(support_path("world.furrow"), extent, ground);
	must(make_drive(support_path("scene.yaml"), support_path("world.furrow"), (const char *const[]){control, "time_step=0.005", "end_time=0.1", NULL},
			&(struct drive_cut){.out = support_path("out")}, &json));
	const char *after = strstr(json, "\"settled_after\"");
	assert_non_null(after);
	const double seconds = strtod(strchr(after, ':') + 1, NULL);
	print_message("settled after %.3f s\n", seconds);
	assert_int_equal(drive_rows(support_path("out/vehicles.csv"), "v", rows, 64), 3);
	mem_free(json);
	return seconds;
}

static void what_turns_for_ever_starts(void **state)
{
	(void)state;
	assert_true(fabs(settled_after("1") - 25) < 0.1);
}

/* While it is slowed it moves at 1 mm/s: 25 s; then it is faster: 10 s more. */
static void what_trembles_by_little_starts_sooner(void **state)
{
	(void)state;
	assert_true(fabs(settled_after("0.0625") - 35) < 0.1);
}

/* How a speed goes up and down within a time of work. */
static double shake(int i)
{
	return 1.2 + sin(i);
}

/* It stands for a moment, again and again. */
static double bounce(int i)
{
	return i % 10 == 0 ? 0 : 1 + (i % 3);
}

/* It is slow once, before it trembles. */
static double slow_once(int i)
{
	return i == 40 ? 0.0001 : 1 + 0.2 * sin(i);
}

/* The first second is slower than all that follows. */
static double begins_slow(int i)
{
	return i < 10 ? 0.001 : 1;
}

/* Returns the work, s, after which a start fails whose speed falls from `speed` to `share` of it in each second of work; INFINITY: it does not within 100 s. */
static double work_until_failure(double speed, double share, double motion_by_work, double (*form)(int i))
{
	struct unrest unrest = {.samples = 0};
	for (int i = 0; i <= 1000; i++) {
		const double work = 0.1 * i;
		if (vehicle_unrest_fails(&unrest, speed * pow(share, work) * form(i), motion_by_work * work, work))
			return work;
	}
	return INFINITY;
}

static void a_start_that_trembles_fails_within_20_s_of_work(void **state)
{
	(void)state;
	static double (*const forms[])(int i) = {shake, bounce, slow_once, begins_slow};
	for (size_t k = 0; k < sizeof forms / sizeof forms[0]; k++) {
		assert_true(work_until_failure(0.03, 1, 1, forms[k]) >= 15 && work_until_failure(0.03, 1, 1, forms[k]) < 20);
		assert_true(work_until_failure(0.5, 0.99, 5, forms[k]) < 20);       /* it calms far too slowly */
		assert_true(work_until_failure(0.5, 1, 0.4, forms[k]) < 20);
		assert_true(isinf(work_until_failure(0.03, 0.9, 1, forms[k])));     /* it calms */
		assert_true(isinf(work_until_failure(0.0005, 1, 1, forms[k])));     /* by micrometres: the drive may begin */
		assert_true(work_until_failure(0.03, 1, 0.02, forms[k]) >= 50);     /* so heavy that it has not had time to calm */
	}
}

TEST_PROGRAM(settle)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_wheel_settles_at_the_two_sided_arc),
		cmocka_unit_test(a_block_holds_on_a_slope),
		cmocka_unit_test(what_turns_for_ever_starts),
		cmocka_unit_test(what_trembles_by_little_starts_sooner),
		cmocka_unit_test(a_start_that_trembles_fails_within_20_s_of_work),
	};
	return cmocka_run_group_tests_name("vehicles at rest", tests, support_enter, support_leave);
}
