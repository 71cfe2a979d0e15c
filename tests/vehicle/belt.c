/*
 * A vehicle on a belt: a hinge drives it, and the soil pulls it as the closed form of a rigid track says (Wong, Theory of Ground Vehicles):
 * (A c + W tan phi) (1 - K / (i l) (1 - exp(-i l / K))). Its body only slides forward and up, so that it stays level. Soil bears from below alone: a belt that brakes
 * as it is set off would sink a little deeper with faces, and pull with that.
 */
#include <math.h>

#include "drive.h"
#include "rig.h"
#include "vehicle/internal.h"
#include "../long.h"
#include "../support/program.h"

#define LENGTH 1.2
#define WIDTH 0.3
#define RADIUS 0.2
#define MASS 300.0
#define BEGIN 3.0 /* s: from then on it pulls */

static const struct extent extent = {129, 65, 0.25, 128};

static double slope; /* tangent */

static double ground(int64_t x, int64_t y)
{
	(void)y;
	return 100 + slope * extent.spacing * (double)x;
}

/* %s in turn: the sprocket's axis, what custom has. */
static const char model[] =
	"<mujoco><option timestep=\"0.002\" integrator=\"implicit\"/>%s<worldbody><body name=\"hull\" pos=\"0 0 0.5\">"
	"<joint name=\"x\" type=\"slide\" axis=\"1 0 0\"/><joint name=\"z\" type=\"slide\" axis=\"0 0 1\"/>"
	"<geom name=\"track\" type=\"box\" size=\"0.6 0.15 0.25\" mass=\"290\"/><body name=\"sprocket\" pos=\"-0.5 0 0\">"
	"<joint name=\"turn\" axis=\"0 %s 0\"/><inertial pos=\"0 0 0\" mass=\"10\" diaginertia=\"0.5 0.5 0.5\"/></body></body></worldbody>"
	"<actuator><velocity name=\"drive\" joint=\"turn\" kv=\"2000000\"/><motor name=\"pull\" joint=\"x\"/></actuator></mujoco>";
static const char belt[] = "<custom><text name=\"belt:track\" data=\"turn\"/><numeric name=\"belt:track\" data=\"0.2\"/></custom>";

struct trial {
	const char *soil;
	double spacing, turns, share; /* m, rad/s, of the weight: what it pulls */
	bool right;                   /* the sprocket's axis looks to the right */
};

static void write_scene(const struct trial *trial, double pull, double seconds)
{
	char text[2048];
	const double turns = trial->right ? -trial->turns : trial->turns;
	snprintf(text, sizeof text, model, belt, trial->right ? "-1" : "1");
	support_write(support_path("track.xml"), text);
	snprintf(text, sizeof text, "t,drive,pull\n0,0,0\n1,%g,0\n%g,%g,%g\n", turns, BEGIN, turns, -pull);
	support_write(support_path("controls.csv"), text);
	snprintf(text, sizeof text, "scene: 1\nend_time: %g\ntime_step: 0.002\nspacing: %g\nsoil: {name: %s, damping: 0}\n"
				    "redistribute: {model: scm, slip_sinkage: 0, bulldozing: 0, faces: off}\n"
				    "vehicles:\n  - {name: v, model: track.xml, start: {at: [8, 8]}, driver: {controls: controls.csv}}\n"
				    "output: {vehicles: 20}\n", seconds, trial->spacing, trial->soil);
	support_write(support_path("scene.yaml"), text);
}

static void check(const struct trial *trial)
{
	static struct drive_row rows[2000];
	const char *store = support_path("world.furrow");
	const double weight = MASS * 9.81, pull = trial->share * weight, seconds = BEGIN + 3 / (RADIUS * trial->turns);
	struct soil_numbers soil;
	must(soil_named(trial->soil, &soil));
	write_scene(trial, pull, seconds);
	slope = 0;
	support_store(store, extent, ground);
	must(make_drive(support_path("scene.yaml"), store, NULL, &(struct drive_cut){.out = support_path("out")}, NULL));
	const size_t count = drive_rows(support_path("out/vehicles.csv"), "v", rows, 2000);
	assert_true(count > 30);
	const struct drive_row *from = &rows[count - count / 4], *to = &rows[count - 1];
	const double ran = RADIUS * trial->turns * (to->t - from->t), slip = 1 - (to->x - from->x) / ran, modulus = soil.janosi_shear;
	const double strength = LENGTH * WIDTH * soil.cohesion + weight * tan(soil.friction_angle);
	const double wanted = strength * (1 - modulus / (slip * LENGTH) * (1 - exp(-slip * LENGTH / modulus)));
	print_message("%s, posts %g m: pulls %.1f N at slip %.4f, the closed form %.1f; its motor %.1f\n", trial->soil, trial->spacing, pull, slip, wanted,
		      (to->work - from->work + pull * (to->x - from->x)) / ran);
	assert_true(slip > 0 && slip < 0.7);
	assert_true(fabs(wanted - pull) < 0.005 * pull);
	/* The motors' work is that on the belt, less what the pull takes. So the hinge's torque is the pull times the sprocket's radius. */
	assert_true(fabs((to->work - from->work + pull * (to->x - from->x)) / ran - pull) < 0.005 * pull);
	assert_true(fabs(to->z - from->z) < 1e-3);
}

static void it_pulls_as_a_rigid_track(void **state)
{
	static const struct trial trials[] = {
		{"dry_sand", 0.0625, 2.5, 0.3, false}, {"dry_sand", 0.03125, 2.5, 0.5, true}, {"sandy_loam_15", 0.0625, 2.5, 0.5, false},
		{"lunar", 0.0625, 4, 0.6, false},
	};
	(void)state;
	for (size_t i = 0; i < sizeof trials / sizeof *trials; i++)
		if (by_turn(i, 2))
			check(&trials[i]);
}

/* --- up a slope --- */

/* What a rigid track at a slip shears, where its pressure grows evenly to its rear, as its load does that acts behind its middle. */
static double effort(const struct soil_numbers *soil, double length, double width, double load, double behind, double slip)
{
	const int parts = 2000;
	double sum = 0;
	for (int k = 0; k < parts; k++) {
		const double x = (k + 0.5) / parts, share = 1 + 12 * behind / length * (x - 0.5), slid = slip * x * length / soil->janosi_shear;
		sum += (soil->cohesion * length * width + load * share * tan(soil->friction_angle)) * (1 - exp(-slid)) / parts;
	}
	return sum;
}

struct turned {
	double t, x, angle;
};

/* The rows of the shipped vehicle: when, where, and the angle of its left sprocket. */
static size_t read_turned(struct turned *rows, size_t most)
{
	char *text = support_text(support_path("out/vehicles.csv"));
	size_t count = 0;
	for (char *line = strchr(text, '\n'); line != NULL && line[1] != '\0' && count < most; line = strchr(line + 1, '\n'))
		count += sscanf(line + 1, "%lf,%*[^,],%lf,%*f,%*f,%*f,%*f,%*f,%*f,%*f,%*f,%*f,%*f,%lf", &rows[count].t, &rows[count].x, &rows[count].angle) == 3;
	free(text);
	return count;
}

static void the_shipped_vehicle_climbs_at_the_slip_of_its_slope(void **state)
{
	static const struct {
		const char *soil;
		double degrees;
	} trials[] = {{"dry_sand", 8}, {"dry_sand", 16}, {"dry_sand", 25}, {"sandy_loam_15", 12}, {"lunar", 20}};
	static struct turned rows[2000];
	const char *store = support_path("world.furrow");
	char text[2048], path[512];
	(void)state;
	snprintf(path, sizeof path, "%s/vehicles/tracked.xml", getenv("SCENES"));
	char *shipped = support_text(path);
	support_write(support_path("tracked.xml"), shipped);
	free(shipped);
	for (size_t i = 0; i < sizeof trials / sizeof *trials; i++) {
		const double angle = trials[i].degrees * M_PI / 180, weight = 1000 * 9.81, length = 1.9, width = 0.24;
		struct soil_numbers soil;
		must(soil_named(trials[i].soil, &soil));
		slope = tan(angle);
		support_store(store, extent, ground);
		snprintf(text, sizeof text, "scene: 1\nend_time: 10\ntime_step: 0.002\nspacing: 0.0625\nsoil: {name: %s, damping: 0}\n"
					    "redistribute: {model: scm, slip_sinkage: 0, bulldozing: 0, faces: off}\n" /* the closed form is that of the lower envelope */
					    "vehicles:\n  - {name: v, model: tracked.xml, start: {at: [8, 8]}, soil: [track_*], driver: {hold: {drive_left: 4, drive_right: 4}}}\n"
					    "output: {vehicles: 20}\n", trials[i].soil);
		support_write(support_path("scene.yaml"), text);
		must(make_drive(support_path("scene.yaml"), store, NULL, &(struct drive_cut){.out = support_path("out")}, NULL));
		const size_t count = read_turned(rows, 2000);
		assert_true(count == 201);
		const struct turned *from = &rows[120], *to = &rows[200];
		const double slip = 1 - (to->x - from->x) / cos(angle) / (0.2 * (to->angle - from->angle));
		const double wanted = effort(&soil, length, 2 * width, weight * cos(angle), 0.53 * tan(angle), slip);
		print_message("%s, %g degrees: slip %.4f, weight down the slope %.1f N, the track's effort %.1f N\n", trials[i].soil, trials[i].degrees, slip,
			      weight * sin(angle), wanted);
		/* A vehicle that rocks is a millimetre ahead or behind, of 3 m. */
		const double known = 3e-4, behind = 0.53 * tan(angle), most = effort(&soil, length, 2 * width, weight * cos(angle), behind, slip + known);
		const double least = effort(&soil, length, 2 * width, weight * cos(angle), behind, slip - known);
		assert_true(slip > known && weight * sin(angle) > 0.97 * least && weight * sin(angle) < 1.03 * most);
	}
}

static void a_belt_that_is_wrong_is_refused(void **state)
{
	static const struct {
		const char *custom, *says;
	} cases[] = {
		{"<custom><text name=\"belt:track\" data=\"turn\"/></custom>", "belt:track: the radius of its sprocket is 0 m; give a numeric"},
		{"<custom><numeric name=\"belt:track\" data=\"0.2\"/></custom>", "belt:track: \"\" is no hinge of the model; give a text"},
		{"<custom><text name=\"belt:track\" data=\"x\"/><numeric name=\"belt:track\" data=\"0.2\"/></custom>", "belt:track: \"x\" is no hinge"},
		{"<custom><text name=\"belt:track\" data=\"turn\"/><numeric name=\"belt:track\" data=\"-1\"/></custom>", "radius of its sprocket is -1 m"},
		{"<custom><text name=\"belt:tread\" data=\"turn\"/></custom>", "belt:tread: no soil geom of this name is a box"},
	};
	(void)state;
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		char text[2048];
		snprintf(text, sizeof text, model, cases[i].custom, "1");
		support_write(support_path("model.xml"), text);
		rig_refused("time_step: 0.002", "", STATUS_INPUT, cases[i].says);
	}
}

TEST_PROGRAM(belt)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(it_pulls_as_a_rigid_track),
		cmocka_unit_test(the_shipped_vehicle_climbs_at_the_slip_of_its_slope),
		cmocka_unit_test(a_belt_that_is_wrong_is_refused),
	};
	return cmocka_run_group_tests_name("a vehicle on a belt", tests, support_enter, support_leave);
}
