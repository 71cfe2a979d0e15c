/*
 * What a driven wheel pulls when nothing guides it, beside the rig, which carries the same wheel at a given slip. The rig's soil has no
 * damping. So the soil here has none, or the wheel is slow.
 */
#include <math.h>

#include "../support/near.h"
#include "deform/reference/reference.h"
#include "drive.h"
#include "trials/trials.h"
#include "../long.h"
#include "../support/program.h"

#define RADIUS 0.32
#define WIDTH 0.24
#define MASS 100.0
#define WAY 3.0   /* m: how far its rim goes */
#define BEGIN 2.5 /* s: from then on it pulls */

static const struct extent extent = {129, 65, 0.25, 128};
static double slope; /* tangent */

static double ground(int64_t x, int64_t y)
{
	(void)y;
	return 100 + slope * 0.25 * (double)x;
}

static const char model[] =
	"<mujoco><option timestep=\"0.002\" integrator=\"implicit\"/><worldbody><body name=\"carriage\" pos=\"0 0 0.5\">"
	"<joint name=\"x\" type=\"slide\" axis=\"1 0 0\"/><joint name=\"z\" type=\"slide\" axis=\"0 0 1\"/>"
	"<inertial pos=\"0 0 0\" mass=\"70\" diaginertia=\"1 1 1\"/><body euler=\"%g 0 0\"><joint name=\"turn\" axis=\"0 1 0\"/>"
	"<geom name=\"wheel\" type=\"cylinder\" size=\"0.32 0.12\" euler=\"90 0 0\" mass=\"30\"/></body></body></worldbody>"
	"<actuator><velocity name=\"drive\" joint=\"turn\" kv=\"100000\"/><motor name=\"pull\" joint=\"x\"/></actuator></mujoco>";

struct trial {
	const char *soil, *more; /* its name, and other keys */
	double spacing, gravity, turns; /* rad/s */
	double share;   /* of the weight: what it pulls on the level; 0: the slope alone pulls it back */
	double degrees; /* how steep the ground is */
	double camber;  /* degrees */
};

/* The mean of a column of objects.csv over its last `rows`. */
static double told(const char *column, size_t rows)
{
	char *text = support_text(support_path("out/objects.csv")), *end = text + strlen(text);
	double sum = 0;
	int commas = 0;
	const char *name = strstr(text, column);
	assert_non_null(name);
	for (const char *c = text; c <= name; c++)
		commas += *c == ',';
	for (size_t row = 0; row < rows; row++) {
		end[-1] = '\0';
		char *at = strrchr(text, '\n') + 1;
		end = at;
		for (int k = 0; k < commas; k++)
			at = strchr(at, ',') + 1;
		sum += strtod(at, NULL);
	}
	free(text);
	return sum / (double)rows;
}

/* Drives the wheel until its motion is steady. Returns its slip. The drive tells the same. */
static double drive(const struct trial *trial)
{
	static struct drive_row rows[2000];
	const char *store = support_path("world.furrow");
	const double pull = trial->share * MASS * trial->gravity, seconds = BEGIN + WAY / (RADIUS * trial->turns);
	char text[2048];
	slope = tan(trial->degrees * M_PI / 180);
	snprintf(text, sizeof text, model, trial->camber);
	support_write(support_path("wheel.xml"), text);
	snprintf(text, sizeof text, "t,drive,pull\n0,0,0\n1,%g,0\n%g,%g,%g\n", trial->turns, BEGIN, trial->turns, -pull);
	support_write(support_path("controls.csv"), text);
	snprintf(text, sizeof text, "scene: 1\nend_time: %g\ntime_step: 0.002\nspacing: %g\ngravity: %g\nsoil: {name: %s%s}\nredistribute: {model: scm%s}\n"
				    "vehicles:\n  - {name: v, model: wheel.xml, start: {at: [8, 8]}, driver: {controls: controls.csv}}\n"
				    "output: {vehicles: 20, forces: 20}\n", seconds, trial->spacing, trial->gravity, trial->soil, trial->more,
		 trial->camber != 0 ? ", faces: off" : ""); /* as the integral has it: the patch of a cambered wheel turns on the ground, so it slides */
	support_write(support_path("scene.yaml"), text);
	support_store(store, extent, ground);
	must(make_drive(support_path("scene.yaml"), store, NULL, &(struct drive_cut){.out = support_path("out")}, NULL));
	const size_t count = drive_rows(support_path("out/vehicles.csv"), "v", rows, 2000);
	assert_true(count > 30);
	const struct drive_row *from = &rows[count - count / 4], *to = &rows[count - 1];
	const double way = (to->x - from->x) / cos(trial->degrees * M_PI / 180);
	const double slip = 1 - way / (trial->turns * RADIUS * (to->t - from->t));
	if (!(fabs(told(",slip,", count / 4) - slip) <= 0.003))
		fail_msg("%s, %g degrees: a slip of %.4f, but it came and turned %.4f", trial->soil, trial->degrees, told(",slip,", count / 4), slip);
	return slip;
}

static enum status keep(void *user, const struct rig_row *row)
{
	*(struct rig_row *)user = *row;
	return STATUS_OK;
}

/* Returns what a wheel without camber pulls on the rig at the slip of the trial. */
static double check(const struct trial *trial)
{
	const double weight = MASS * trial->gravity, angle = trial->degrees * M_PI / 180, load = weight * cos(angle), slip = drive(trial);
	const double wanted = trial->share * weight + weight * sin(angle);
	struct rig_row row = {.drawbar = NAN};
	struct rig_found found;
	const struct rig_params params = {.shape = "wheel: {radius: 0.32, width: 0.24}", .soils = &trial->soil, .soil_count = 1, .loads = &load,
					  .load_count = 1, .slips = &slip, .slip_count = 1, .spacing = trial->spacing, .folder = support_path("")};
	must(trials_rig_run(&params, &found, keep, &row));
	print_message("%s%s, posts %g m, %g degrees, camber %g: pulls %.1f N at slip %.4f, the rig %.1f N (%.1f %% of the weight more)\n", trial->soil, trial->more, trial->spacing,
		      trial->degrees, trial->camber, wanted, slip, row.drawbar, (row.drawbar - wanted) / weight * 100);
	assert_true(slip > 0 && slip < 0.7 && row.state == RIG_STEADY);
	assert_true(fabs(row.drawbar - wanted) < 0.04 * wanted);
	return row.drawbar;
}

/* How much more a wheel pulls with camber, a share, by the integral of tests/deform/reference/leaning.c, at this slip and load. */
static double leaning_pulls_more(const struct trial *trial, double slip)
{
	double pulls[2];
	struct soil_numbers soil;
	must(soil_named(trial->soil, &soil));
	for (int i = 0; i < 2; i++) {
		struct reference_leaning wheel = {.radius = RADIUS, .width = WIDTH, .camber = i * fabs(trial->camber) * M_PI / 180,
						  .rolls = true, .turned = reference_turned(slip)};
		wheel.sinkage = reference_leaning_sinkage(&soil, &wheel, MASS * trial->gravity);
		pulls[i] = reference_leaning(&soil, &wheel).force[0];
	}
	return pulls[1] / pulls[0] - 1;
}

/* Each level wheel beside the rig, and two of them again with camber. A cambered wheel pulls as much at another slip. The rig says what
 * an upright one pulls at that slip, so both its pulls tell what camber changes. */
static void it_pulls_on_the_level_as_on_the_rig_and_with_a_little_camber_as_the_integral_says(void **state)
{
	static const struct trial trials[] = {
		{"dry_sand", ", damping: 0", 0.015625, 9.81, 1.25, 0.2, 0, 0}, {"sandy_loam_15", ", damping: 0", 0.015625, 9.81, 2, 0.25, 0, 0},
		{"lunar", "", 0.015625, 1.62, 0.15, 0.2, 0, 0},
	};
	static const double cambers[] = {1, 0, -3}; /* degrees; 0: not again */
	(void)state;
	for (size_t i = 0; i < sizeof trials / sizeof *trials; i++) {
		if (!by_turn(i, 2))
			continue;
		struct trial leaning = trials[i];
		const double upright = check(&trials[i]);
		leaning.camber = cambers[i];
		if (cambers[i] == 0)
			continue;
		const double more = upright / check(&leaning) - 1; /* what it pulls, beside an upright wheel at its slip */
		const double wanted = leaning_pulls_more(&leaning, told(",slip,", 10));
		print_message("%s, camber %g: pulls %.2f %% more than without, by the integral %.2f %%\n", trials[i].soil, cambers[i], 100 * more, 100 * wanted);
		/* Posts of half the width give 2.2 and -0.2 %. 3 degrees raise one side of the wheel by more than it sinks into this soil. */
		assert_near(more, wanted, 0.01);
	}
}

static void it_climbs_as_the_rig_says(void **state)
{
	static const struct trial trials[] = {
		{"dry_sand", ", damping: 0", 0.015625, 9.81, 1.25, 0, 8, 0}, {"dry_sand", ", damping: 0", 0.015625, 9.81, 1.25, 0, 14, 0},
		{"sandy_loam_15", ", damping: 0", 0.015625, 9.81, 2, 0, 11, 0},
	};
	(void)state;
	for (size_t i = 0; i < sizeof trials / sizeof *trials; i++)
		if (by_turn(i, 2))
			check(&trials[i]);
}

TEST_PROGRAM(pull)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(it_pulls_on_the_level_as_on_the_rig_and_with_a_little_camber_as_the_integral_says),
		cmocka_unit_test(it_climbs_as_the_rig_says),
	};
	return cmocka_run_group_tests_name("pull of a driven wheel beside the rig", tests, support_enter, support_leave);
}
