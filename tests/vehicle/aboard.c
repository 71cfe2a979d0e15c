/* A geom of a vehicle carries soil: it weighs and resists in the engine, comes into rows and run.json, and goes on to the same bits after cuts, kills and rollbacks. */
#include <math.h>
#include <signal.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "../api/hosted.h"
#include "../comma.h"
#include "../support/near.h"
#include "../support/program.h"
#include "drive.h"
#include "vehicle/vehicle.h"

extern char **environ;

#define ARM 50.0 /* kg that the hoist of tray.xml lifts */
#define HOIST 4e5 /* N/m: its stiffness */
#define STEP 0.002

static const struct extent extent = {129, 129, 0.25, 32};

/* A low ridge across the way. Tiles are 8 m wide, and the tray begins on the border of two. */
static double ground(int64_t x, int64_t y)
{
	(void)y;
	const double along = fabs((double)x - 65) / 6;
	return 50 + (along < 1 ? 0.05 * (1 - along) : 0);
}

/* It digs, lifts, holds still until 5 s, is jerked up by 10 mm, and tips. */
static const char controls[] = "t,along,lift,tip\n0,0,0,0\n0.5,0,0.06,0.35\n1.5,0.3,-0.08,0.35\n3,1.0,-0.1,0.05\n3.5,1.05,0.3,0\n5,1.05,0.3,0\n5.002,1.05,0.31,0\n"
			       "5.5,1.05,0.31,0\n6.5,1.05,0.4,1.2\n7,1.05,0.4,1.2\n";

static void write_scene(const char *carries, double damping)
{
	char text[1024], path[512], joint[64];
	snprintf(path, sizeof path, "%s/tray.xml", getenv("MODELS"));
	char *model = support_text(path), *at = strstr(model, "axis=\"0 0 1\" damping=\"4000\"");
	assert_non_null(at);
	snprintf(joint, sizeof joint, "axis=\"0 0 1\" damping=\"%04.0f\"", damping);
	memcpy(at, joint, strlen(joint));
	support_write(support_path("model.xml"), model);
	free(model);
	support_write(support_path("controls.csv"), controls);
	snprintf(text, sizeof text, "scene: 1\nend_time: 7\ntime_step: 0.002\nsoil: {name: dry_sand, damping: 30000}\nspacing: 0.0625\nredistribute: {model: scm}\n"
				    "vehicles:\n  - name: digger\n    model: model.xml\n    start: {at: [15.9, 15.9], yaw: 20}\n    soil: [tray]\n    carry: %s\n"
				    "    driver: {controls: controls.csv}\noutput: {forces: 500, vehicles: 500}\n", carries);
	support_write(support_path("scene.yaml"), text);
}

static void prepare(double damping)
{
	write_scene("[tray]", damping);
	support_store(support_path("ground.furrow"), extent, ground);
}

/* --- what is refused --- */

static void refused_with(const char *carries, const char *says)
{
	struct vehicles *vehicles;
	write_scene(carries, 4000);
	struct scene *scene = support_scene(support_path("scene.yaml"), NULL);
	assert_int_equal(vehicle_load(scene, &vehicles), STATUS_INPUT);
	if (strstr(failure_message(), says) == NULL)
		print_error("%s\n", failure_message());
	assert_non_null(strstr(failure_message(), says));
	scene_destroy(scene);
}

static void what_cannot_carry_is_refused(void **state)
{
	(void)state;
	refused_with("[hoist]", "carry: hoist does not press the ground, so no soil comes onto it; name it in soil, too, or leave it out of carry");
	refused_with("[shovel]", "carry: shovel names no geom of a body that moves; the model has: carriage, hoist, tray");
}

/* --- rows --- */

struct row {
	double t, carried, weight, lift, force; /* s, m3, N, m, N */
};

static size_t read_rows(const char *out, struct row *rows, size_t most)
{
	char path[256];
	size_t count = 0;
	snprintf(path, sizeof path, "%s/vehicles.csv", out);
	char *text = support_text(path);
	assert_non_null(strstr(text, ",kinetic,work,carried,carried_weight,q:along,q:lift,q:tip,u:along,u:lift,u:tip,f:along,f:lift,f:tip\n"));
	for (char *line = strchr(text, '\n'); line != NULL && line[1] != '\0' && count < most; line = strchr(line + 1, '\n')) {
		struct row *r = &rows[count++];
		assert_int_equal(sscanf(line + 1, "%lf,%*[^,],%*[^,],%*[^,],%*[^,],%*[^,],%*[^,],%*[^,],%*[^,],%*[^,],%*[^,],%*[^,],%*[^,],%lf,%lf,%*[^,],%lf,%*[^,],%*[^,],"
						  "%*[^,],%*[^,],%*[^,],%lf", &r->t, &r->carried, &r->weight, &r->lift, &r->force), 5);
	}
	free(text);
	return count;
}

static struct row row_at(const struct row *rows, size_t count, double t)
{
	const size_t index = (size_t)lround(t / STEP);
	assert_true(index < count && fabs(rows[index].t - t) < 1e-6);
	return rows[index];
}

static long long quanta(const char *json, const char *key)
{
	char name[32];
	snprintf(name, sizeof name, "\"%s\":", key);
	const char *volume = strstr(json, "\"quanta\""), *at = volume != NULL ? strstr(volume, name) : NULL;
	assert_non_null(at);
	return atoll(at + strlen(name));
}

static struct row whole[4000];
static size_t whole_count;

/* Times between the upward passings of the middle, s: the first and the last of some. */
static double period(const struct row *rows, size_t count, double from, double to)
{
	const double middle = row_at(rows, count, to).lift;
	double first = 0, last = 0;
	int passings = 0;
	for (size_t i = (size_t)lround(from / STEP); i < (size_t)lround(to / STEP) && passings < 4; i++)
		if (rows[i].lift < middle && rows[i + 1].lift >= middle) {
			last = rows[i].t + STEP * (middle - rows[i].lift) / (rows[i + 1].lift - rows[i].lift);
			first = passings++ == 0 ? last : first;
		}
	assert_true(passings >= 2);
	return (last - first) / (passings - 1);
}

static void its_load_weighs_and_is_sluggish(void **state)
{
	const struct drive_cut cut = {support_path("a.furrow"), support_path("a"), false, 0};
	char *json;
	(void)state;
	prepare(1200);
	assert_int_equal(make_drive(support_path("scene.yaml"), support_path("ground.furrow"), NULL, &cut, &json), STATUS_OK);
	const size_t count = whole_count = read_rows(cut.out, whole, sizeof whole / sizeof *whole);
	assert_int_equal(count, 3501);
	const struct row held = row_at(whole, count, 4.99), later = row_at(whole, count, 5.49), dug = row_at(whole, count, 3), end = row_at(whole, count, 7);
	const double mass = held.weight / 9.81, beside = period(whole, count, 5.01, 5.45), swing = 2 * M_PI * sqrt((ARM + mass) / HOIST);
	print_message("%.4g l dug, %.4g l lifted, %.6g N; the hoist pulls %.7g N more than for itself; it swings in %.4g s, by its mass in %.4g s, without the load's in %.4g s\n",
		      1e3 * dug.carried, 1e3 * held.carried, held.weight, held.force - ARM * 9.81, beside, swing, 2 * M_PI * sqrt(ARM / HOIST));
	assert_true(held.carried > 0.008 && held.carried < dug.carried);
	assert_true(held.carried == later.carried && held.weight == later.weight);
	assert_near(held.weight, held.carried * 16000, 1e-3 * held.weight); /* dry_sand */
	assert_near(held.force - ARM * 9.81, held.weight, 1e-3 * held.weight);
	assert_near(beside, swing, 0.04 * swing);
	assert_true(mass > 0.2 * ARM); /* so that the swing tells */
	assert_true(end.carried == 0 && end.weight == 0);
	assert_true(quanta(json, "net") + quanta(json, "compacted") + quanta(json, "carried") == quanta(json, "added"));
	assert_int_equal(quanta(json, "carried"), 0);
	assert_non_null(strstr(json, "\"digger.tray\""));
	mem_free(json);
}

/* --- the same bits --- */

static void assert_like_the_whole(const char *overlay, const char *out)
{
	assert_same_rows(support_path("a"), out, 1000);
	assert_true(support_hash(support_path("a.furrow")) == support_hash(overlay));
}

/* Cut while it digs, and while it holds its load, with few slots and with many. */
static void cut_it_goes_on_to_the_same_bits(void **state)
{
	static const char *const few[] = {"cache.slots=12", "cache.loaders=0", NULL};
	const char *scene = support_path("scene.yaml"), *store = support_path("ground.furrow"), *overlay = support_path("b.furrow"), *out = support_path("b");
	char *json;
	(void)state;
	must(make_drive(scene, store, NULL, &(struct drive_cut){overlay, out, false, 1107}, &json));
	assert_true(quanta(json, "carried") > 0);
	mem_free(json);
	must(make_drive(scene, store, few, &(struct drive_cut){overlay, out, true, 2201}, &json));
	assert_true(quanta(json, "carried") > 0);
	assert_true(quanta(json, "net") + quanta(json, "compacted") + quanta(json, "carried") == 0);
	mem_free(json);
	must(make_drive(scene, store, NULL, &(struct drive_cut){overlay, out, true, 0}, NULL));
	assert_like_the_whole(overlay, out);
}

/* Soil is aboard whenever it is killed. */
static void killed_it_goes_on_to_the_same_bits(void **state)
{
	const char *overlay = support_path("k.furrow"), *out = support_path("k");
	int kills = 0;
	(void)state;
	must(make_drive(support_path("scene.yaml"), support_path("ground.furrow"), NULL, &(struct drive_cut){overlay, out, false, 1503}, NULL));
	for (int i = 0; i < 3; i++) {
		pid_t child;
		char *const args[] = {"test_vehicle", "aboard", (char *)support_path("scene.yaml"), (char *)support_path("ground.furrow"), (char *)overlay, (char *)out,
				      "resume", NULL};
		assert_int_equal(posix_spawn(&child, "/proc/self/exe", NULL, NULL, args, environ), 0);
		kills += drive_killed(child, out, 150000 * (useconds_t)i);
	}
	if (kills == 0)
		print_message("each drive was complete before it could be killed\n");
	must(make_drive(support_path("scene.yaml"), support_path("ground.furrow"), NULL, &(struct drive_cut){overlay, out, true, 0}, NULL));
	assert_like_the_whole(overlay, out);
}

/* aboard SCENE STORE OVERLAY DIRECTORY resume: the drive that is killed. */
static int drive_alone(char *const args[])
{
	const struct drive_cut part = {args[2], args[3], strcmp(args[4], "resume") == 0, 0};
	return make_drive(args[0], args[1], NULL, &part, NULL) == STATUS_OK ? 0 : 1;
}

/* A host drives it, makes a checkpoint while the tray is full, lets it tip, and goes back. What it is told of the tray has the load. */
static void rolled_back_it_goes_on_to_the_same_bits(void **state)
{
	struct furrow_world *world = NULL;
	const struct furrow_open open = {.size = sizeof open, .scene_file = support_path("scene.yaml"), .store = support_path("ground.furrow"),
					 .overlay = support_path("r.furrow"), .output = support_path("r")};
	struct furrow_contact contact = {.state = FURROW_UNKNOWN};
	int32_t tray;
	(void)state;
	done(furrow_world_open(&open, &world));
	for (int i = 0; i < 2250; i++)
		done(furrow_step(world, 0));
	done(furrow_checkpoint(world));
	done(furrow_body_find(world, "digger.tray", &tray));
	for (int i = 0; i < 1200; i++) {
		done(furrow_step(world, 0));
		if (i > 0)
			continue;
		done(furrow_get_contacts(world, 1, &tray, &contact, sizeof contact));
		const struct row held = row_at(whole, whole_count, 4.5);
		assert_int_equal(contact.state, FURROW_AIR);
		assert_near(contact.carried, held.carried, 1e-8 * held.carried);
		assert_near(contact.force[2], -held.weight, 1e-6 * held.weight);
	}
	done(furrow_get_contacts(world, 1, &tray, &contact, sizeof contact));
	assert_true(contact.carried == 0);
	done(furrow_rollback(world));
	for (int i = 0; i < 1250; i++)
		done(furrow_step(world, 0));
	done(furrow_world_close(world));
	assert_same_rows(support_path("a"), support_path("r"), 1000);
	assert_true(support_hash(support_path("a.furrow")) == support_hash(support_path("r.furrow")));
}

TEST_PROGRAM(aboard)
{
	if (program_words[0] != NULL && program_words[1] != NULL)
		return drive_alone(program_words);
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_cannot_carry_is_refused),
		cmocka_unit_test(its_load_weighs_and_is_sluggish),
		cmocka_unit_test(cut_it_goes_on_to_the_same_bits),
		cmocka_unit_test(killed_it_goes_on_to_the_same_bits),
		cmocka_unit_test(rolled_back_it_goes_on_to_the_same_bits),
	};
	return cmocka_run_group_tests_name("geoms of vehicles that carry soil", tests, support_enter, support_leave);
}
