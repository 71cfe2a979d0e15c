/* A vehicle with its brakes on is set down and left alone: it slides by a little until the soil's shear holds it, and then nothing moves. */
#include <math.h>

#include "drive.h"
#include "../support/program.h"

static const struct extent extent = {129, 129, 0.25, 64};
static double slope; /* tangent */

static double ground(int64_t x, int64_t y)
{
	(void)y;
	return 2 + slope * 0.25 * (double)x;
}

/* Writes a text with `from` replaced by `to`, which must be there. */
static void write_changed(const char *name, char *text, const char *from, const char *to)
{
	char *at = strstr(text, from), *out = calloc(1, strlen(text) + strlen(to) + 1);
	assert_non_null(at);
	assert_non_null(out);
	sprintf(out, "%.*s%s%s", (int)(at - text), text, to, at + strlen(from));
	support_write(support_path(name), out);
	free(out);
}

/* The model of a folder, with a stiff spring on each wheel instead of its motor. */
static void write_braked(const char *folder, const char *file, const char *joint, const char *held, const char *motor)
{
	char path[512];
	snprintf(path, sizeof path, "%s/%s", getenv(folder), file);
	char *text = support_text(path);
	write_changed("model.xml", text, joint, held);
	free(text);
	text = support_text(support_path("model.xml"));
	write_changed("model.xml", text, motor, "kv=\"0\"");
	free(text);
}

/* Tells how far it slid in all and drifted in the last second, m. */
static void drive(double degrees, double end, const char *name)
{
	static struct drive_row rows[512];
	char text[1024];
	const char *store = support_path("world.furrow"), *scene = support_path("scene.yaml");
	slope = tan(degrees * M_PI / 180);
	support_store(store, extent, ground);
	snprintf(text, sizeof text, "scene: 1\nend_time: %g\ntime_step: 0.002\nspacing: 0.0625\nsoil: {name: dry_sand}\nredistribute: {model: scm}\n"
				    "vehicles:\n  - {name: v, model: model.xml, start: {at: [16.013, 16.021]}, soil: [wheel*]}\noutput: {vehicles: 20}\n", end);
	support_write(scene, text);
	must(make_drive(scene, store, NULL, &(struct drive_cut){.out = support_path("out"), .overlay = support_path("over.furrow")}, NULL));
	unlink(support_path("over.furrow"));
	const size_t count = drive_rows(support_path("out/vehicles.csv"), "v", rows, 512);
	assert_true(count > 21);
	const struct drive_row *first = &rows[0], *before = &rows[count - 21], *last = &rows[count - 1];
	const double slid = hypot(hypot(last->x - first->x, last->y - first->y), last->z - first->z);
	const double drift = hypot(hypot(last->x - before->x, last->y - before->y), last->z - before->z);
	print_message("%s, %g degrees: slid %.3f mm, drifts by %.3g um/s, %.2g J\n", name, degrees, slid * 1e3, drift * 1e6, last->kinetic);
	assert_true(slid < 0.01 && drift < 1.5e-7 && last->kinetic < 1e-9);
}

static void one_wheel_rests(void **state)
{
	(void)state;
	write_braked("MODELS", "one_wheel.xml", "<joint name=\"turn\" axis=\"0 1 0\"/>",
		     "<joint name=\"turn\" axis=\"0 1 0\" stiffness=\"200000\" damping=\"2000\"/>", "kv=\"500\"");
	for (int degrees = 0; degrees <= 20; degrees += 10)
		drive(degrees, 12, "one wheel");
}

static void four_wheels_rest(void **state)
{
	(void)state;
	write_braked("SCENES", "vehicles/offroad.xml", "<joint axis=\"0 1 0\" armature=\"1\"/>",
		     "<joint axis=\"0 1 0\" armature=\"1\" stiffness=\"200000\" damping=\"2000\"/>", "kv=\"1500\"");
	drive(15, 8, "four wheels");
}

TEST_PROGRAM(rest)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(one_wheel_rests),
		cmocka_unit_test(four_wheels_rest),
	};
	return cmocka_run_group_tests_name("vehicles with their brakes on", tests, support_enter, support_leave);
}
