/* Vehicles on the ground that touch each other: one pushes another one, one carries another one, and some only stand side by side. */
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

/* A wheel on a carriage that keeps it upright, with a long beam in front. */
static const char wheel[] =
	"<mujoco><option timestep=\"0.002\" integrator=\"implicit\"/><worldbody><body name=\"carriage\" pos=\"0 0 0.5\">"
	"<joint type=\"slide\" axis=\"1 0 0\"/><joint type=\"slide\" axis=\"0 0 1\"/><inertial pos=\"0 0 0\" mass=\"70\" diaginertia=\"1 1 1\"/>"
	"<geom name=\"beam\" type=\"box\" pos=\"0.75 0 -0.2\" size=\"0.75 0.2 0.05\"/>"
	"<body><joint name=\"turn\" axis=\"0 1 0\"/><geom name=\"wheel\" type=\"cylinder\" size=\"0.32 0.12\" euler=\"90 0 0\" mass=\"30\"/></body></body>"
	"</worldbody><actuator><velocity name=\"drive\" joint=\"turn\" kv=\"500\"/></actuator></mujoco>";
static const char block[] =
	"<mujoco><option timestep=\"0.002\"/><worldbody><body pos=\"0 0 0.15\"><freejoint/>"
	"<geom name=\"block\" type=\"box\" size=\"0.3 0.25 0.15\" mass=\"%g\"/></body></worldbody></mujoco>";
/* Its top hangs above a block; its feet sink until it lies on the block. */
static const char table[] =
	"<mujoco><option timestep=\"0.002\"/><worldbody><body pos=\"0 0 0.35\"><freejoint/>"
	"<geom name=\"top\" type=\"box\" size=\"0.5 0.2 0.04\" mass=\"%g\"/><geom name=\"left\" type=\"box\" pos=\"0.45 0 -0.2\" size=\"0.03 0.05 0.15\" mass=\"1\"/>"
	"<geom name=\"right\" type=\"box\" pos=\"-0.45 0 -0.2\" size=\"0.03 0.05 0.15\" mass=\"1\"/></body></worldbody></mujoco>";

static const char front[] = "scene: 1\nend_time: 2\ntime_step: 0.002\nspacing: 0.0625\nsoil: {name: dry_sand}\nredistribute: {model: scm}\n"
			    "output: {forces: 500, vehicles: 500}\nvehicles:\n";

static void write_model(const char *name, const char *form, double mass)
{
	char text[2048];
	snprintf(text, sizeof text, form, mass);
	support_write(support_path(name), text);
}

static void write_scene(const char *vehicles)
{
	char text[2048];
	snprintf(text, sizeof text, "%s%s", front, vehicles);
	support_write(support_path("scene.yaml"), text);
	support_store(support_path("world.furrow"), extent, flat);
}

static void drive(const char *const *settings, const char *out)
{
	must(make_drive(support_path("scene.yaml"), support_path("world.furrow"), settings, &(struct drive_cut){.out = support_path(out)}, NULL));
}

/* The wheel at 10, 16 m, and the block in front of it, in a direction. */
static void write_push(double mass, double speed, double yaw, bool swapped)
{
	char one[256], other[256], both[640];
	const double ahead = 1.5 + 0.3 + 0.1, c = cos(yaw * M_PI / 180), s = sin(yaw * M_PI / 180);
	support_write(support_path("wheel.xml"), wheel);
	write_model("block.xml", block, mass);
	snprintf(one, sizeof one, "  - {name: one, model: wheel.xml, start: {at: [10, 16], yaw: %g}, soil: [wheel], driver: {hold: {drive: %g}}}\n", yaw,
		 speed / 0.32);
	snprintf(other, sizeof other, "  - {name: other, model: block.xml, start: {at: [%.9g, %.9g], yaw: %g}}\n", 10 + ahead * c, 16 + ahead * s, yaw);
	snprintf(both, sizeof both, "%s%s", swapped ? other : one, swapped ? one : other);
	write_scene(both);
}

struct force {
	double t, along, up;
};

/* The soil's forces on a body, along a direction. */
static size_t read_forces(const char *path, const char *name, double yaw, struct force *forces, size_t most)
{
	char *text = support_text(path), called[64];
	size_t count = 0;
	for (char *line = strchr(text, '\n'); line != NULL && line[1] != '\0' && count < most; line = strchr(line + 1, '\n')) {
		double t, fx, fy, fz;
		assert_int_equal(sscanf(line + 1, "%lf,%63[^,],%*[^,],%*[^,],%*[^,],%*[^,],%lf,%lf,%lf", &t, called, &fx, &fy, &fz), 5);
		if (strcmp(called, name) == 0)
			forces[count++] = (struct force){t, fx * cos(yaw * M_PI / 180) + fy * sin(yaw * M_PI / 180), fz};
	}
	free(text);
	return count;
}

static void one_pushes_another_one(void **state)
{
	static const double cases[][3] = {{20, 0.25, 0}, {30, 0.5, 30}, {60, 1, 90}}; /* kg, m/s, degrees */
	static struct drive_row one[1100], other[1100];
	static struct force wheels[1100], blocks[1100];
	(void)state;
	for (int i = 0; i < 3; i++) {
		const double mass = cases[i][0], yaw = cases[i][2], c = cos(yaw * M_PI / 180), s = sin(yaw * M_PI / 180);
		write_push(mass, cases[i][1], yaw, false);
		drive(NULL, "out");
		const size_t count = drive_rows(support_path("out/vehicles.csv"), "one", one, 1100);
		assert_int_equal(count, 1001);
		assert_int_equal(drive_rows(support_path("out/vehicles.csv"), "other", other, 1100), count);
		assert_int_equal(read_forces(support_path("out/objects.csv"), "one.wheel", yaw, wheels, 1100), count);
		assert_int_equal(read_forces(support_path("out/objects.csv"), "other.block", yaw, blocks, 1100), count);
		/* The momentum of both is what the soil gave them: their forces on each other add nothing. */
		double given = 0, worst = 0, pushed = 0, most = 0;
		for (size_t r = 1; r < count; r++) {
			const double speeds[2] = {one[r].vx * c + one[r].vy * s, other[r].vx * c + other[r].vy * s};
			given += 0.002 * (wheels[r].along + blocks[r].along);
			pushed -= 0.002 * blocks[r].along;
			most = support_most(most, fabs(100 * speeds[0]) + mass * fabs(speeds[1]));
			worst = support_most(worst, fabs(100 * speeds[0] + mass * speeds[1] - given));
		}
		const double way = (other[count - 1].x - other[0].x) * c + (other[count - 1].y - other[0].y) * s;
		print_message("%g kg at %g m/s, %g degrees: pushed by %.3f m; the soil took %.1f N s from it; %.2g N s of %.1f are not the soil's\n", mass,
			      cases[i][1], yaw, way, pushed, worst, most);
		assert_true(way > 0.05 && pushed > 0);
		assert_true(worst < 1e-5 * most);
		/* They stay in touch. */
		const double apart = hypot(other[count - 1].x - one[count - 1].x, other[count - 1].y - one[count - 1].y);
		assert_true(apart > 1.78 && apart < 1.82);
	}
}

static void the_order_of_vehicles_does_not_matter(void **state)
{
	static struct drive_row rows[2][1100];
	(void)state;
	for (int i = 0; i < 2; i++) {
		write_push(30, 0.5, 30, i == 1);
		drive(NULL, "out");
		assert_int_equal(drive_rows(support_path("out/vehicles.csv"), "other", rows[i], 1100), 1001);
	}
	/* The forces between vehicles are the same bits, and bodies meet the ground together. */
	double worst = 0, early = 0;
	for (int r = 0; r < 1001; r++) {
		const double off = hypot(rows[0][r].x - rows[1][r].x, rows[0][r].y - rows[1][r].y) + fabs(rows[0][r].z - rows[1][r].z);
		early = r <= 500 ? fmax(early, off) : early;
		worst = support_most(worst, off);
	}
	print_message("in the other order the block is %.3g m elsewhere after a second, %.3g m after two\n", early, worst);
	assert_true(early == 0 && worst == 0);
}

static void resumed_it_goes_on_to_the_same_bits(void **state)
{
	const char *store = support_path("world.furrow"), *scene = support_path("scene.yaml");
	const char *whole = support_path("a.furrow"), *parts = support_path("b.furrow"), *outs[] = {support_path("a"), support_path("b")};
	(void)state;
	write_push(30, 0.5, 30, false);
	must(make_drive(scene, store, NULL, &(struct drive_cut){whole, outs[0], false, 0}, NULL));
	must(make_drive(scene, store, NULL, &(struct drive_cut){parts, outs[1], false, 333}, NULL));
	must(make_drive(scene, store, (const char *const[]){"cache.slots=9", "cache.loaders=1", NULL}, &(struct drive_cut){parts, outs[1], true, 400}, NULL));
	must(make_drive(scene, store, NULL, &(struct drive_cut){parts, outs[1], true, 0}, NULL));
	char *a = support_text(support_path("a/vehicles.csv")), *b = support_text(support_path("b/vehicles.csv"));
	assert_string_equal(a, b);
	assert_true(support_hash(whole) == support_hash(parts));
	free(a);
	free(b);
}

/* How far a vehicle moved in the last second. */
static double drift(const char *name)
{
	static struct drive_row rows[4000];
	const size_t count = drive_rows(support_path("out/vehicles.csv"), name, rows, 4000);
	assert_true(count > 501);
	const struct drive_row *last = &rows[count - 1], *before = &rows[count - 501];
	return hypot(hypot(last->x - before->x, last->y - before->y), last->z - before->z);
}

/* How far a vehicle stands from where it was set, at the end. */
static double aside(const char *name, double x, double y)
{
	static struct drive_row rows[4000];
	const size_t count = drive_rows(support_path("out/vehicles.csv"), name, rows, 4000);
	return hypot(rows[count - 1].x - x, rows[count - 1].y - y);
}

/* Where one ends the next one begins: the soil bears them as one body, so none is pushed aside. */
static void side_by_side_they_stand(void **state)
{
	(void)state;
	write_model("block.xml", block, 60);
	write_scene("  - {name: a, model: block.xml, start: {at: [10.013, 16.013]}}\n  - {name: b, model: block.xml, start: {at: [10.613, 16.013]}}\n"
		    "  - {name: c, model: block.xml, start: {at: [10.213, 16.513]}}\n");
	drive((const char *const[]){"end_time=2", NULL}, "out");
	print_message("they drift by %.3g, %.3g, %.3g um/s\n", drift("a") * 1e6, drift("b") * 1e6, drift("c") * 1e6);
	/* A row tells 1e-7 m. */
	assert_true(drift("a") < 5e-7 && drift("b") < 5e-7 && drift("c") < 5e-7);
	assert_true(aside("a", 10.013, 16.013) < 2e-6 && aside("b", 10.613, 16.013) < 2e-6 && aside("c", 10.213, 16.513) < 2e-6);
}

/* A table whose top lies on a block: the block carries most of it, and both are at rest. */
static void one_carries_another_one(void **state)
{
	static const double masses[] = {20, 60, 100};
	static struct force feet[2][4000], below[4000];
	(void)state;
	for (int i = 0; i < 3; i++) {
		write_model("block.xml", block, 60);
		write_model("table.xml", table, masses[i]);
		write_scene("  - {name: a, model: block.xml, start: {at: [10.013, 16.013]}}\n"
			    "  - {name: t, model: table.xml, start: {at: [10.013, 16.013]}, soil: [left, right]}\n");
		drive((const char *const[]){"end_time=2", NULL}, "out");
		const size_t count = read_forces(support_path("out/objects.csv"), "a.block", 0, below, 4000);
		assert_int_equal(read_forces(support_path("out/objects.csv"), "t.left", 0, feet[0], 4000), count);
		assert_int_equal(read_forces(support_path("out/objects.csv"), "t.right", 0, feet[1], 4000), count);
		const double on_feet = feet[0][count - 1].up + feet[1][count - 1].up, on_block = below[count - 1].up;
		const double weight = 9.81 * (60 + masses[i] + 2);
		print_message("a table of %g kg: %.3f N on its feet, %.3f N under the block, %.3f N of weight; drift %.3g, %.3g um/s\n", masses[i] + 2, on_feet,
			      on_block, weight, drift("a") * 1e6, drift("t") * 1e6);
		assert_true(fabs(on_feet + on_block - weight) < 1e-3 * weight);
		assert_true(on_block > 9.81 * 60 * 1.02);
		/* The soil under its narrow feet lets it swing by some micrometres. */
		assert_true(drift("a") < 5e-6 && drift("t") < 5e-6);
	}
}

static void one_that_starts_inside_another_one_is_refused(void **state)
{
	(void)state;
	write_model("block.xml", block, 60);
	write_scene("  - {name: a, model: block.xml, start: {at: [10.013, 16.013]}}\n  - {name: b, model: block.xml, start: {at: [10.5, 16.1]}}\n");
	assert_int_equal(make_drive(support_path("scene.yaml"), support_path("world.furrow"), NULL, &(struct drive_cut){.out = support_path("out")}, NULL),
			 STATUS_INPUT);
	print_message("%s\n", failure_message());
	assert_non_null(strstr(failure_message(), ".yaml:10: vehicles.b.start: its geom block starts 0.113 m inside block of vehicles.a; move"));
}

TEST_PROGRAM(touch)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(one_pushes_another_one),
		cmocka_unit_test(the_order_of_vehicles_does_not_matter),
		cmocka_unit_test(resumed_it_goes_on_to_the_same_bits),
		cmocka_unit_test(side_by_side_they_stand),
		cmocka_unit_test(one_carries_another_one),
		cmocka_unit_test(one_that_starts_inside_another_one_is_refused),
	};
	return cmocka_run_group_tests_name("vehicles that touch", tests, support_enter, support_leave);
}
