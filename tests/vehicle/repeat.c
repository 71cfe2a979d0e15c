/* A drive of a vehicle is the same to the bit: twice, through few slots and many, and cut by a resume or a kill. */
#include <signal.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include "drive.h"
#include "../support/program.h"

extern char **environ;

static const struct extent extent = {129, 129, 0.25, 32};

/* A low ridge across the way, so that wheels load and unload. Tiles are 8 m wide: the way crosses their borders. */
static double ground(int64_t x, int64_t y)
{
	(void)y;
	const double along = fabs((double)x - 68) / 6;
	return 50 + (along < 1 ? 0.15 * (1 - along) : 0);
}

/* Wheels, and belts that climb the ridge. */
static const struct {
	const char *name, *keys, *driver, *slots; /* slots: as few as its windows need */
	double x, work; /* it gets beyond this place, and does so much at least */
} vehicles[] = {
	{"rover", "gravity: 1.62\nsoil: {name: lunar}", "speed: 0.3}, steer: [steer_*]", "cache.slots=8", 16, 5},
	{"tracked", "soil: {name: sandy_loam_15}", "speed: 0.7}", "cache.slots=16", 17.5, 1000},
};

static void prepare(const char *store, int vehicle)
{
	char text[2048], path[512];
	snprintf(path, sizeof path, "%s/vehicles/%s.xml", getenv("SCENES"), vehicles[vehicle].name);
	char *model = support_text(path);
	support_write(support_path("model.xml"), model);
	free(model);
	snprintf(text, sizeof text, "scene: 1\nend_time: 6\ntime_step: 0.002\n%s\nspacing: 0.0625\n"
				    "redistribute: {model: scm}\nvehicles:\n  - name: driven\n    model: model.xml\n    start: {at: [15, 15.5], yaw: 20}\n"
				    "    soil: [wheel_*, track_*]\n    driver: {path: {points: [[15, 15.5], [20, 17]], %s, drive: [drive_*]}\n"
				    "output: {forces: 20, vehicles: 50}\n", vehicles[vehicle].keys, vehicles[vehicle].driver);
	support_write(support_path("scene.yaml"), text);
	support_store(store, extent, ground);
}

/* A resumed drive knows the way of its earlier parts. */
static void assert_same_ways(const char *a, const char *b)
{
	const char *outs[] = {a, b};
	char *ways[2];
	for (int i = 0; i < 2; i++) {
		char path[256];
		snprintf(path, sizeof path, "%s/run.json", outs[i]);
		char *text = support_text(path), *vehicle = strstr(text, "\"vehicles\":"), *way = vehicle != NULL ? strstr(vehicle, "\"way\":") : NULL;
		assert_non_null(way);
		*strstr(way, "\"soils\":") = '\0';
		ways[i] = strdup(way);
		free(text);
	}
	assert_true(strlen(ways[0]) > 200);
	assert_string_equal(ways[0], ways[1]);
	free(ways[0]);
	free(ways[1]);
}

static void drive_again(int vehicle)
{
	const char *const few[] = {vehicles[vehicle].slots, "cache.loaders=0", NULL};
	struct drive_row rows[512];
	char path[256];
	const char *store = support_path("world.furrow"), *scene = support_path("scene.yaml");
	const char *overlays[] = {support_path("a.furrow"), support_path("b.furrow"), support_path("c.furrow"), support_path("d.furrow")};
	const char *outs[] = {support_path("a"), support_path("b"), support_path("c"), support_path("d")};
	prepare(store, vehicle);
	must(make_drive(scene, store, NULL, &(struct drive_cut){overlays[0], outs[0], false, 0}, NULL));
	must(make_drive(scene, store, NULL, &(struct drive_cut){overlays[1], outs[1], false, 0}, NULL));
	must(make_drive(scene, store, few, &(struct drive_cut){overlays[2], outs[2], false, 0}, NULL));
	/* Cut after an odd number of steps, twice. */
	must(make_drive(scene, store, NULL, &(struct drive_cut){overlays[3], outs[3], false, 777}, NULL));
	must(make_drive(scene, store, few, &(struct drive_cut){overlays[3], outs[3], true, 1500}, NULL));
	must(make_drive(scene, store, NULL, &(struct drive_cut){overlays[3], outs[3], true, 0}, NULL));
	for (int i = 1; i < 4; i++) {
		assert_same_rows(outs[0], outs[i], 1000);
		assert_same_ways(outs[0], outs[i]);
		assert_true(support_hash(overlays[0]) == support_hash(overlays[i]));
	}
	snprintf(path, sizeof path, "%s/vehicles.csv", outs[0]);
	const size_t count = drive_rows(path, "driven", rows, 512);
	assert_int_equal(count, 301);
	print_message("at %g, %g m after 6 s, %g J\n", rows[count - 1].x, rows[count - 1].y, rows[count - 1].work);
	assert_true(rows[count - 1].x > vehicles[vehicle].x && rows[count - 1].work > vehicles[vehicle].work);
	for (int i = 0; i < 4; i++)
		unlink(overlays[i]);
}

static void the_same_bits_however_it_is_driven(void **state)
{
	(void)state;
	drive_again(0);
}

static void so_are_those_of_belts(void **state)
{
	(void)state;
	drive_again(1);
}

static void killed_it_goes_on_to_the_same_bits(void **state)
{
	const char *store = support_path("world.furrow"), *scene = support_path("scene.yaml");
	const char *whole = support_path("w.furrow"), *cut = support_path("k.furrow"), *outs[] = {support_path("w"), support_path("k")};
	(void)state;
	prepare(store, 0);
	must(make_drive(scene, store, NULL, &(struct drive_cut){whole, outs[0], false, 0}, NULL));
	int kills = 0;
	for (int i = 0; i < 4; i++) {
		/* A program of its own: a hardware driver does not work in a fork of a process that has used it. */
		pid_t child;
		char *const args[] = {"test_vehicle", "repeat", (char *)scene, (char *)store, (char *)cut, (char *)outs[1], i > 0 ? "resume" : "begin", NULL};
		assert_int_equal(posix_spawn(&child, "/proc/self/exe", NULL, NULL, args, environ), 0);
		kills += drive_killed(child, outs[1], 70000 * (useconds_t)i);
	}
	if (kills == 0)
		print_message("each drive was complete before it could be killed\n");
	must(make_drive(scene, store, NULL, &(struct drive_cut){cut, outs[1], true, 0}, NULL));
	assert_same_rows(outs[0], outs[1], 1000);
	assert_true(support_hash(whole) == support_hash(cut));
}

/* repeat SCENE STORE OVERLAY DIRECTORY begin|resume: the drive that is killed. */
static int drive_alone(char *const args[])
{
	const struct drive_cut part = {args[2], args[3], strcmp(args[4], "resume") == 0, 0};
	char *json = NULL;
	const bool done = make_drive(args[0], args[1], NULL, &part, &json) == STATUS_OK;
	mem_free(json);
	return done ? 0 : 1;
}

TEST_PROGRAM(repeat)
{
	if (program_words[0] != NULL && program_words[1] != NULL)
		return drive_alone(program_words);
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_same_bits_however_it_is_driven),
		cmocka_unit_test(so_are_those_of_belts),
		cmocka_unit_test(killed_it_goes_on_to_the_same_bits),
	};
	return cmocka_run_group_tests_name("drives of vehicles again", tests, support_enter, support_leave);
}
