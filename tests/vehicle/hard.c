/* Vehicles on hard ground. A sled on four balls rests on a slope below the friction angle. Above it slides as Coulomb has it, whatever the spacing and the heading. */
#include <math.h>

#include "drive.h"
#include "../support/program.h"

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

static const struct extent extent = {129, 129, 0.25, 64};
static double slope[2]; /* rise to the east and to the north */

static double ground(int64_t x, int64_t y)
{
	return 200 + 0.25 * (slope[0] * (double)x + slope[1] * (double)y);
}

/* Returns how far a sled has slid after `end` seconds, m, and *kinetic at the end, J. heading: of the fall line's upper end, degrees from east. */
static double slide(const char *soil, double degrees, double heading, double spacing, double end, double *kinetic)
{
	static struct drive_row rows[512];
	char text[1024];
	const char *store = support_path("world.furrow"), *scene = support_path("scene.yaml");
	slope[0] = tan(degrees * M_PI / 180) * cos(heading * M_PI / 180);
	slope[1] = tan(degrees * M_PI / 180) * sin(heading * M_PI / 180);
	support_store(store, extent, ground);
	support_write(support_path("model.xml"), "<mujoco><option timestep=\"0.001\"/><worldbody><body name=\"sled\"><freejoint/><geom type=\"box\" size=\".4 .4 .05\" mass=\"100\" pos=\"0 0 .2\"/>"
						 "<geom name=\"a\" type=\"sphere\" size=\".2\" pos=\".4 .4 0\" mass=\"1\"/><geom name=\"b\" type=\"sphere\" size=\".2\" pos=\".4 -.4 0\" mass=\"1\"/>"
						 "<geom name=\"c\" type=\"sphere\" size=\".2\" pos=\"-.4 .4 0\" mass=\"1\"/><geom name=\"d\" type=\"sphere\" size=\".2\" pos=\"-.4 -.4 0\" mass=\"1\"/></body></worldbody></mujoco>");
	snprintf(text, sizeof text, "scene: 1\nend_time: %g\ntime_step: 0.001\nspacing: %g\nsoil: {name: %s}\nredistribute: {model: scm}\n"
				    "vehicles:\n  - {name: v, model: model.xml, start: {at: [16.013, 16.021], yaw: %g, pitch: %g, settle: false}}\noutput: {vehicles: 20}\n", end, spacing, soil, heading, degrees);
	support_write(scene, text);
	must(make_drive(scene, store, NULL, &(struct drive_cut){.out = support_path("out"), .overlay = support_path("over.furrow")}, NULL));
	unlink(support_path("over.furrow"));
	const size_t count = drive_rows(support_path("out/vehicles.csv"), "v", rows, 512);
	assert_true(count > 2);
	const struct drive_row *first = &rows[0], *last = &rows[count - 1];
	*kinetic = last->kinetic;
	return hypot(hypot(last->x - first->x, last->y - first->y), last->z - first->z);
}

static void a_sled_slides_as_coulomb_says(void **state)
{
	static const struct {
		const char *soil;
		double tangent, degrees, heading, spacing;
	} rows[] = {
		{"rock", 0.6494, 40, 0, 0.0625}, {"rock", 0.6494, 40, 0, 0.125}, {"rock", 0.6494, 40, 37, 0.0625}, {"asphalt", 0.65, 36, 120, 0.0625},
		{"concrete", 0.75, 45, 200, 0.0625}, {"ice", 0.1, 12, 300, 0.0625}, {"ice", 0.1, 8, 0, 0.03125}, {"rock", 0.6494, 45, 333, 0.03125},
		{"rock", 0.6494, 40, 0, 0.03125}, {"rock", 0.6494, 40, 0, 0.015625}, {"rock", 0.6494, 40, 90, 0.015625}, {"rock", 0.6494, 40, 45, 0.015625},
	};
	(void)state;
	for (size_t i = 0; i < COUNT(rows); i++) {
		/* A ball shears the ground below it anew over its patch of 4 cm: by Janosi that is 0.98 of the friction. On posts that are wider than the patch it is less. */
		const double angle = rows[i].degrees * M_PI / 180;
		double kinetic;
		const double slid = slide(rows[i].soil, rows[i].degrees, rows[i].heading, rows[i].spacing, 1, &kinetic);
		const double share = (9.81 * sin(angle) - 2 * slid) / (9.81 * cos(angle) * rows[i].tangent);
		print_message("%s, %g degrees to %g, posts of %g m: slid %.3f m, with %.4f of the friction\n", rows[i].soil, rows[i].degrees, rows[i].heading, rows[i].spacing, slid, share);
		assert_true(share > 0.985 - 2.2 * rows[i].spacing && share < 1.01);
	}
}

static void below_the_friction_angle_it_rests(void **state)
{
	static const struct {
		const char *soil;
		double degrees, heading;
	} rows[] = {{"rock", 28, 0}, {"asphalt", 25, 73}, {"concrete", 30, 200}, {"ice", 4, 10}, {"rock", 0, 0}};
	(void)state;
	for (size_t i = 0; i < COUNT(rows); i++) {
		double kinetic;
		const double slid = slide(rows[i].soil, rows[i].degrees, rows[i].heading, 0.0625, 2, &kinetic);
		print_message("%s, %g degrees: slid %.2f mm, %.2g J\n", rows[i].soil, rows[i].degrees, slid * 1e3, kinetic);
		assert_true(slid < 0.03 && kinetic < 1e-3);

	}
}

TEST_PROGRAM(hard)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_sled_slides_as_coulomb_says),
		cmocka_unit_test(below_the_friction_angle_it_rests),
	};
	return cmocka_run_group_tests_name("vehicles on hard ground", tests, support_enter, support_leave);
}
