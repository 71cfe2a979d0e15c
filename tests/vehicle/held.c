/*
 * Whole vehicles beside the rig, which carries one wheel. A vehicle that a spring holds slips more and more as the spring pulls harder: at each
 * slip it pulls what the rig says for its wheels. The steepest slope that it climbs is the one on which they pull their weight's share
 * along the slope at most. Its wheels run in tracks of their own, so that none rolls in another one's rut. The rig's soil has no damping,
 * so the soil here has none.
 */
#include <math.h>
#include <string.h>

#include "../long.h"
#include "../support/program.h"
#include "drive.h"
#include "trials/trials.h"

#define RADIUS 0.32
#define G 9.81
#define MASS 100.0     /* kg for each wheel, that of the wheel with it */
#define SPACING 0.03125
#define AXLES_APART 1.6 /* m */
#define ROWS_MOST 4000

static const struct extent extent = {193, 65, 0.25, 128};
static double slope; /* tangent */

static double ground(int64_t x, int64_t y)
{
	(void)y;
	return 100 + slope * extent.spacing * (double)x;
}

struct vehicle_kind {
	size_t axles;
	const char *joints; /* of its chassis */
};

static void write_model(const struct vehicle_kind *kind)
{
	char text[8192];
	int at = snprintf(text, sizeof text,
			  "<mujoco><option timestep=\"0.002\" integrator=\"implicit\"/><worldbody><body name=\"chassis\" pos=\"0 0 %g\">%s"
			  "<inertial pos=\"0 0 0\" mass=\"%g\" diaginertia=\"60 120 120\"/>", RADIUS, kind->joints, 70.0 * 2 * (double)kind->axles);
	for (size_t i = 0; i < 2 * kind->axles; i++) {
		const double ahead = AXLES_APART * ((double)(kind->axles - 1) / 2 - (double)(i / 2)), aside = (i % 2 ? -1 : 1) * (0.5 + 0.7 * (double)(i / 2));
		at += snprintf(text + at, sizeof text - (size_t)at,
			       "<body pos=\"%g %g 0\"><joint name=\"turn_%zu\" axis=\"0 1 0\"/><geom type=\"cylinder\" size=\"%g 0.12\" euler=\"90 0 0\" mass=\"30\"/></body>",
			       ahead, aside, i, RADIUS);
	}
	at += snprintf(text + at, sizeof text - (size_t)at, "</body></worldbody><actuator>");
	for (size_t i = 0; i < 2 * kind->axles; i++)
		at += snprintf(text + at, sizeof text - (size_t)at, "<velocity name=\"drive_%zu\" joint=\"turn_%zu\" kv=\"100000\"/>", i, i);
	snprintf(text + at, sizeof text - (size_t)at, "</actuator></mujoco>");
	support_write(support_path("held.xml"), text);
}

/* Drives the vehicle with all wheels turning alike, and reads its rows. Returns their number. *stuck: it ended so. */
static size_t drive(const struct vehicle_kind *kind, const char *soil, double turns, double seconds, struct drive_row *rows, bool *stuck)
{
	char text[2048] = "t", *json = NULL;
	const char *store = support_path("world.furrow");
	write_model(kind);
	for (size_t i = 0; i < 2 * kind->axles; i++)
		sprintf(text + strlen(text), ",drive_%zu", i);
	for (int row = 0; row < 2; row++) {
		sprintf(text + strlen(text), "\n%d", 2 * row);
		for (size_t i = 0; i < 2 * kind->axles; i++)
			sprintf(text + strlen(text), ",%g", row * turns);
	}
	support_write(support_path("controls.csv"), text);
	snprintf(text, sizeof text, "scene: 1\nend_time: %g\ntime_step: 0.002\nspacing: %g\nsoil: {name: %s, damping: 0}\nredistribute: {model: scm}\n"
				    "vehicles:\n  - {name: v, model: held.xml, start: {at: [8, 8]}, driver: {controls: controls.csv}}\n"
				    "stuck: {after: 2, below: 0.02}\noutput: {vehicles: 20}\n", seconds, SPACING, soil);
	support_write(support_path("scene.yaml"), text);
	support_store(store, extent, ground);
	must(make_drive(support_path("scene.yaml"), store, NULL, &(struct drive_cut){.out = support_path("out")}, &json));
	*stuck = strstr(json, "\"stuck\"") != NULL && strstr(strstr(json, "\"ended\""), "\"stuck\"") < strchr(strstr(json, "\"ended\""), ',');
	mem_free(json);
	return drive_rows(support_path("out/vehicles.csv"), "v", rows, ROWS_MOST);
}

static enum status keep(void *user, const struct rig_row *row)
{
	struct rig_row **next = user;
	*(*next)++ = *row;
	return STATUS_OK;
}

static void ask_rig(const char *soil, const double *loads, size_t load_count, const double *slips, size_t slip_count, struct rig_row *rows)
{
	struct rig_found found;
	const struct rig_params params = {.shape = "wheel: {radius: 0.32, width: 0.24}", .soils = &soil, .soil_count = 1, .loads = loads, .load_count = load_count,
					  .slips = slips, .slip_count = slip_count, .spacing = SPACING, .folder = support_path("")};
	must(trials_rig_run(&params, &found, keep, &rows));
}

/* --- held by a spring --- */

static void held(size_t axles, const char *soil, double pull)
{
	static struct drive_row rows[ROWS_MOST];
	static const double slips[] = {0.1, 0.2, 0.35};
	const double stiffness = pull * 2 * (double)axles / 9, turns = 2, mass = MASS * 2 * (double)axles, load = MASS * G; /* N/m: all its pull at 9 m */
	const size_t around = 8; /* rows: means over 0.8 s */
	char joints[300];
	bool stuck;
	struct rig_row told[3];
	slope = 0;
	snprintf(joints, sizeof joints, "<joint name=\"x\" type=\"slide\" axis=\"1 0 0\" stiffness=\"%g\"/><joint name=\"z\" type=\"slide\" axis=\"0 0 1\"/>", stiffness);
	const size_t count = drive(&(struct vehicle_kind){axles, joints}, soil, turns, 32, rows, &stuck);
	ask_rig(soil, &load, 1, slips, 3, told);
	assert_true(count > 100);
	for (size_t k = 0, i = 60 + around; k < 3; k++) { /* its wheels turn evenly after 2 s, 40 rows */
		double slip = 0;
		for (; i + around < count; i++) {
			slip = 1 - (rows[i + around].x - rows[i - around].x) / (rows[i + around].t - rows[i - around].t) / (turns * RADIUS);
			if (slip >= slips[k])
				break;
		}
		assert_true(slip >= slips[k] && slip < slips[k] + 0.03);
		const double half = rows[i + around].t - rows[i].t, gains = (rows[i + around].x - 2 * rows[i].x + rows[i - around].x) / (half * half);
		const double pulls = (stiffness * (rows[i].x - rows[0].x) + mass * gains) / (2 * (double)axles);
		print_message("%zu wheels, %s: each pulls %.1f N at slip %.3f, the rig's %.1f\n", 2 * axles, soil, pulls, slip, told[k].drawbar);
		assert_true(fabs(pulls - told[k].drawbar) < 0.05 * told[k].drawbar);
	}
}

static void a_vehicle_on_a_spring_pulls_as_the_rig_says(void **state)
{
	(void)state;
	if (by_turn(0, 2))
		held(2, "dry_sand", 240);
	if (long_run())
		held(2, "lunar", 360);
	if (by_turn(1, 2))
		held(3, "sandy_loam_15", 280);
}

/* --- the steepest slope --- */

#define GOES_LEAST 0.1 /* of the rim's speed: a vehicle that is slower makes no way */

/* Returns the slope, as a tangent, on which two wheels in front and two behind pull at this slip what the weight asks, as the rig tells it. */
static double climbed_at(const char *soil, double slip)
{
	double tangent = 0.25, shift = 0;
	for (int round = 0; round < 3; round++) {
		const double load = MASS * G / sqrt(1 + tangent * tangent), loads[2] = {load - shift, load + shift};
		struct rig_row told[2];
		ask_rig(soil, loads, 2, &slip, 1, told);
		/* All wheels' torques turn the chassis, so they lift its front axle. */
		shift = (told[0].torque + told[1].torque) / AXLES_APART;
		tangent = (told[0].drawbar + told[1].drawbar) / (2 * load);
	}
	return tangent;
}

/* Returns the way in the last half of a drive up a slope, as a share of the rim's. */
static double climb(const char *soil, double share, bool *stuck)
{
	static struct drive_row rows[ROWS_MOST];
	const struct vehicle_kind kind = {2, "<joint name=\"x\" type=\"slide\" axis=\"1 0 0\"/><joint name=\"z\" type=\"slide\" axis=\"0 0 1\"/>"
					     "<joint name=\"pitch\" axis=\"0 1 0\"/>"};
	const double turns = 1.25;
	slope = share * climbed_at(soil, 1 - GOES_LEAST);
	const size_t count = drive(&kind, soil, turns, 16, rows, stuck);
	const struct drive_row *from = &rows[count / 2], *to = &rows[count - 1];
	const double goes = hypot(to->x - from->x, to->z - from->z) / (to->t - from->t) / (turns * RADIUS);
	print_message("%s: %.2f degrees, %.2f of the steepest that the rig tells: goes at %.3f of the rim's speed%s\n", soil, atan(slope) / M_PI * 180, share, goes,
		      *stuck ? ", stuck" : "");
	return goes;
}

static void the_steepest_slope_is_the_rigs(void **state)
{
	static const char *const soils[] = {"dry_sand", "lunar"};
	(void)state;
	for (size_t i = 0; i < (long_run() ? 2 : 1); i++) {
		bool stuck;
		assert_true(climb(soils[i], 0.95, &stuck) > GOES_LEAST);
		assert_false(stuck);
		assert_true(climb(soils[i], 1.05, &stuck) < GOES_LEAST);
		assert_true(stuck);
	}
}

TEST_PROGRAM(held)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_vehicle_on_a_spring_pulls_as_the_rig_says),
		cmocka_unit_test(the_steepest_slope_is_the_rigs),
	};
	return cmocka_run_group_tests_name("whole vehicles beside the rig", tests, support_enter, support_leave);
}
