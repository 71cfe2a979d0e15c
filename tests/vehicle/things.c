/*
 * Things of a scene's `world`, and vehicles of several bodies: a wall stops a vehicle, a crate is pushed, a trailer follows its hitch, a winch
 * pulls a vehicle that is stuck, and one that is far away changes nothing.
 */
#include <math.h>

#include "../support/near.h"
#include "drive.h"
#include "../support/program.h"

static const struct extent extent = {257, 257, 0.25, 64};

static double flat(int64_t x, int64_t y)
{
	(void)x, (void)y;
	return 20;
}

/* A carriage on four wheels that one motor each turns. `more`: further bodies and what else the model has. */
#define WHEEL(name, x, y) \
	"<body pos=\"" x " " y " -0.1\"><joint name=\"" name "\" axis=\"0 1 0\" damping=\"1\"/><geom name=\"wheel_" name "\" type=\"cylinder\" size=\"0.25 0.1\" euler=\"90 0 0\" mass=\"10\"/></body>"
#define SERVO(name) "<velocity name=\"drive_" name "\" joint=\"" name "\" kv=\"200\" forcerange=\"-60 60\"/>"
#define TRUCK(inside, more, actuators) \
	"<mujoco><option timestep=\"0.004\" integrator=\"implicitfast\"/><worldbody><body name=\"truck\" pos=\"0 0 0.5\"><freejoint/>" \
	"<geom name=\"hull\" type=\"box\" size=\"0.6 0.3 0.1\" pos=\"0 0 0.05\" mass=\"80\"/>" \
	WHEEL("fl", "0.45", "0.42") WHEEL("fr", "0.45", "-0.42") WHEEL("rl", "-0.45", "0.42") WHEEL("rr", "-0.45", "-0.42") inside "</body>" more \
	"<actuator>" SERVO("fl") SERVO("fr") SERVO("rl") SERVO("rr") actuators "</actuator></mujoco>"

static const char truck[] = TRUCK("", "</worldbody>", "");
static const char towing[] = TRUCK("", "<body name=\"trailer\" pos=\"-1.6 0 0.45\"><freejoint/><geom name=\"bed\" type=\"box\" size=\"0.5 0.3 0.08\" mass=\"40\"/>"
				       "<geom name=\"bar\" type=\"box\" size=\"0.25 0.03 0.03\" pos=\"0.7 0 0\" mass=\"2\" contype=\"0\" conaffinity=\"0\"/>"
				       WHEEL("tl", "0", "0.42") WHEEL("tr", "0", "-0.42") "</body></worldbody>"
				       "<equality><connect name=\"hitch\" body1=\"trailer\" body2=\"truck\" anchor=\"0.95 0 0.05\"/></equality>", "");
/* Its wheels are free; a winch on its bow pulls at a place of the world, 6 m ahead. */
static const char winching[] = TRUCK("<site name=\"bow\" pos=\"0.6 0 0\"/>", "<site name=\"anchor\" pos=\"6 0 0.5\"/></worldbody>"
				     "<tendon><spatial name=\"rope\"><site site=\"anchor\"/><site site=\"bow\"/></spatial></tendon>",
				     "<motor name=\"winch\" tendon=\"rope\" gear=\"-1\"/>");

static void write_scene(const char *vehicles, const char *things, const char *more)
{
	char text[3000];
	snprintf(text, sizeof text, "scene: 1\nend_time: 2\ntime_step: 0.004\nspacing: 0.25\nsoil: {name: dry_sand, damping: 30000, elastic_stiffness: 4e7}\n"
				    "redistribute: {model: scm}\n%sworld: things.xml\nvehicles:\n%soutput: {vehicles: 50, forces: 50}\n%s", things != NULL ? "" : "#", vehicles, more);
	support_write(support_path("scene.yaml"), text);
	if (things != NULL)
		support_write(support_path("things.xml"), things);
	support_store(support_path("world.furrow"), extent, flat);
}

static enum status try_drive(const char *const *settings, const char *out)
{
	char overlay[64];
	snprintf(overlay, sizeof overlay, "%s.furrow", out);
	unlink(support_path(overlay));
	char *const over = strdup(support_path(overlay)), *const to = strdup(support_path(out)), *const scene = strdup(support_path("scene.yaml"));
	const enum status status = make_drive(scene, support_path("world.furrow"), settings, &(struct drive_cut){.out = to, .overlay = over}, NULL);
	free(over);
	free(to);
	free(scene);
	return status;
}

static struct drive_row rows[4000];

static const struct drive_row *last_row(const char *out, const char *name, const struct drive_row **first)
{
	char path[64];
	snprintf(path, sizeof path, "%s/vehicles.csv", out);
	const size_t count = drive_rows(support_path(path), name, rows, 4000);
	assert_true(count > 10);
	if (first != NULL)
		*first = &rows[0];
	return &rows[count - 1];
}

/* The last place of a body in objects.csv. */
static void last_place(const char *out, const char *name, double place[3])
{
	char path[64], called[64];
	snprintf(path, sizeof path, "%s/objects.csv", out);
	char *text = support_text(support_path(path));
	int found = 0;
	for (char *line = strchr(text, '\n'); line != NULL && line[1] != '\0'; line = strchr(line + 1, '\n')) {
		double t, at[3];
		assert_int_equal(sscanf(line + 1, "%lf,%63[^,],%lf,%lf,%lf", &t, called, &at[0], &at[1], &at[2]), 5);
		if (strcmp(called, name) == 0) {
			memcpy(place, at, sizeof at);
			found++;
		}
	}
	free(text);
	assert_true(found > 1);
}

#define TRUCK_AT(name, model, at, speed) \
	"  - {name: " name ", model: " model ", start: {at: " at "}, soil: [wheel_*], driver: {hold: {drive_fl: " speed ", drive_fr: " speed ", drive_rl: " speed ", drive_rr: " speed "}}}\n"

static void a_wall_stops_a_vehicle_and_a_crate_is_pushed(void **state)
{
	static const char wall[] = "<mujoco><worldbody><geom name=\"floor\" type=\"plane\" size=\"9 9 1\" pos=\"0 0 21\"/><geom name=\"wall\" type=\"box\" size=\"0.2 3 1\" pos=\"15.4 16.013 20.5\"/></worldbody></mujoco>";
	static const char crate[] = "<mujoco><worldbody><body name=\"crate\" pos=\"15.1 16.013 20.4\"><freejoint/><geom type=\"box\" size=\"0.3 0.4 0.4\" mass=\"15\"/></body></worldbody></mujoco>";
	double place[3];
	(void)state;
	support_write(support_path("truck.xml"), truck);
	write_scene(TRUCK_AT("car", "truck.xml", "[14.013, 16.013]", "4"), NULL, "");
	must(try_drive(NULL, "alone"));
	const double free_way = last_row("alone", "car", NULL)->x;
	write_scene(TRUCK_AT("car", "truck.xml", "[14.013, 16.013]", "4"), wall, "");
	must(try_drive(NULL, "walled"));
	const double stopped = last_row("walled", "car", NULL)->x;
	write_scene(TRUCK_AT("car", "truck.xml", "[14.013, 16.013]", "4"), crate, "");
	must(try_drive(NULL, "pushing"));
	const double pushed = last_row("pushing", "car", NULL)->x;
	last_place("pushing", "world.crate", place);
	print_message("alone to %.3f m; before a wall at 15.2 to %.3f m; behind a crate to %.3f m, the crate to %.3f m, %.3f m\n", free_way, stopped, pushed, place[0], place[2]);
	assert_true(free_way > 15.0);
	/* Its bow is 0.6 m ahead; wheels 0.7. A contact gives way by less than a millimetre or two. */
	assert_true(fabs(stopped + 0.7 - 15.2) < 0.02);
	assert_true(pushed < free_way - 0.05 && place[0] > 15.4 && place[0] > pushed + 0.9 - 0.01);
	assert_true(fabs(place[2] - 20.4) < 0.1); /* it lies on the soil and does not fall through it */
}

static void what_starts_inside_a_thing_is_refused(void **state)
{
	static const char wall[] = "<mujoco><worldbody><geom name=\"wall\" type=\"box\" size=\"0.2 3 1\" pos=\"14.5 16.013 20.5\"/></worldbody></mujoco>";
	static const char buried[] = "<mujoco><worldbody><body name=\"crate\" pos=\"18 16 19.7\"><freejoint/><geom type=\"box\" size=\"0.3 0.4 0.4\" mass=\"15\"/></body></worldbody></mujoco>";
	(void)state;
	support_write(support_path("truck.xml"), truck);
	write_scene(TRUCK_AT("car", "truck.xml", "[14.013, 16.013]", "4"), wall, "");
	assert_int_equal(try_drive(NULL, "out"), STATUS_INPUT);
	print_message("%s\n", failure_message());
	assert_non_null(strstr(failure_message(), "vehicles.car.start: its geom "));
	assert_non_null(strstr(failure_message(), " m inside wall of world; move the start"));
	write_scene(TRUCK_AT("car", "truck.xml", "[14.013, 16.013]", "4"), buried, "");
	assert_int_equal(try_drive(NULL, "out"), STATUS_INPUT);
	print_message("%s\n", failure_message());
	assert_non_null(strstr(failure_message(), "world: world.crate starts 0.7 m under ground at 18, 16 m; raise it"));
}

static void a_trailer_follows_its_hitch(void **state)
{
	const struct drive_row *first;
	double wheel[3];
	(void)state;
	support_write(support_path("truck.xml"), truck);
	support_write(support_path("towing.xml"), towing);
	write_scene(TRUCK_AT("car", "truck.xml", "[14.013, 16.013]", "4") TRUCK_AT("tow", "towing.xml", "[14.013, 20.013]", "4"), NULL, "");
	must(try_drive(NULL, "out"));
	const double alone = last_row("out", "car", NULL)->x;
	const struct drive_row *last = last_row("out", "tow", &first);
	last_place("out", "tow.wheel_tl", wheel);
	print_message("alone to %.3f m; with a trailer to %.3f m, the trailer's wheel at %.3f m\n", alone, last->x, wheel[0]);
	assert_true(last->x > first->x + 0.5 && last->x < alone);
	/* The trailer's axle was 1.6 m behind the truck's middle. */
	assert_true(fabs(last->x - wheel[0] - 1.6) < 0.02);
}

static void a_winch_pulls_a_vehicle_that_stands(void **state)
{
	const struct drive_row *first;
	(void)state;
	support_write(support_path("winching.xml"), winching);
	write_scene("  - {name: slack, model: winching.xml, start: {at: [14.013, 16.013]}, soil: [wheel_*], driver: {hold: {winch: 0}}}\n"
		    "  - {name: pulled, model: winching.xml, start: {at: [14.013, 20.013]}, soil: [wheel_*], driver: {hold: {winch: 600}}}\n", NULL, "");
	must(try_drive(NULL, "out"));
	const struct drive_row *last = last_row("out", "slack", &first);
	const double slack = last->x - first->x;
	last = last_row("out", "pulled", &first);
	print_message("without pull %.4f m, by the winch %.4f m\n", slack, last->x - first->x);
	assert_true(fabs(slack) < 0.01 && last->x - first->x > 0.1);
}

/* One model has one state. What is wrong with one vehicle must not be told of another one. */
static void what_fails_is_told_of_the_right_vehicle(void **state)
{
	static const char *const values[] = {"9e9", "2e10"}, *const says[] = {"bad: its motion diverged", "bad: control 1 of its actuators is"};
	char vehicles[600];
	(void)state;
	support_write(support_path("truck.xml"), truck);
	support_write(support_path("bad.xml"), "<mujoco><option timestep=\"0.004\"/><worldbody><body pos=\"0 0 0.5\"><freejoint/><geom name=\"ball\" type=\"sphere\" size=\"0.3\" mass=\"20\"/>"
					       "<body><joint name=\"turn\"/><geom size=\"0.1\" mass=\"1\" contype=\"0\" conaffinity=\"0\"/></body></body></worldbody>"
					       "<actuator><motor name=\"turn\" joint=\"turn\" gear=\"1e9\"/></actuator></mujoco>");
	for (int i = 0; i < 4; i++) {
		snprintf(vehicles, sizeof vehicles, TRUCK_AT("%s", "truck.xml", "[14.013, 16.013]", "4") "  - {name: bad, model: bad.xml, start: {at: [14.013, 26.013]}, driver: {hold: {turn: %s}}}\n",
			 i < 2 ? "a" : "z", values[i % 2]);
		write_scene(vehicles, NULL, "");
		assert_int_equal(try_drive(NULL, "out"), STATUS_FAILED);
		print_message("%s\n", failure_message());
		assert_non_null(strstr(failure_message(), says[i % 2]));
	}
}

static double greatest_difference(const char *a, const char *b, const char *name)
{
	static struct drive_row one[4000];
	char path[64];
	double most = 0;
	snprintf(path, sizeof path, "%s/vehicles.csv", a);
	const size_t count = drive_rows(support_path(path), name, one, 4000);
	snprintf(path, sizeof path, "%s/vehicles.csv", b);
	assert_int_equal(drive_rows(support_path(path), name, rows, 4000), count);
	assert_true(count > 10);
	for (size_t i = 0; i < count; i++)
		most = support_most(most, hypot(hypot(one[i].x - rows[i].x, one[i].y - rows[i].y), one[i].z - rows[i].z));
	return most;
}

static void one_that_is_far_away_changes_nothing(void **state)
{
	(void)state;
	support_write(support_path("truck.xml"), truck);
	write_scene(TRUCK_AT("car", "truck.xml", "[14.013, 16.013]", "4"), NULL, "");
	must(try_drive((const char *const[]){"end_time=1", NULL}, "alone"));
	write_scene(TRUCK_AT("car", "truck.xml", "[14.013, 16.013]", "4") TRUCK_AT("van", "truck.xml", "[14.013, 46.013]", "3"), NULL, "");
	must(try_drive((const char *const[]){"end_time=1", NULL}, "first"));
	write_scene(TRUCK_AT("car", "truck.xml", "[14.013, 16.013]", "4") TRUCK_AT("bus", "truck.xml", "[14.013, 46.013]", "3"), NULL, "");
	must(try_drive((const char *const[]){"end_time=1", NULL}, "second"));
	const double first = greatest_difference("alone", "first", "car"), second = greatest_difference("alone", "second", "car");
	print_message("a vehicle with another one far away: off by %.3g m; if the other one's name is first, by %.3g m\n", first, second);
	assert_true(first < 1e-9 && second < 1e-5);
}

static const char heap[] =
	"<mujoco><option timestep=\"0.004\"/><worldbody><body name=\"block\" pos=\"0 0 0.15\"><freejoint/>"
	"<geom type=\"box\" size=\"0.3 0.25 0.15\" mass=\"60\"/></body></worldbody></mujoco>";
/* Two blocks of `world` lie on one that is a vehicle. */
static void three_in_a_heap_come_to_rest(void **state)
{
	static const char things[] = "<mujoco><worldbody><body name=\"upper\" pos=\"14.1 16.05 20.46\"><freejoint/><geom type=\"box\" size=\"0.3 0.25 0.15\" mass=\"40\"/></body>"
				     "<body name=\"top\" pos=\"14.0 16.0 20.78\"><freejoint/><geom type=\"box\" size=\"0.2 0.25 0.15\" mass=\"30\"/></body></worldbody></mujoco>";
	double upper[3], top[3];
	(void)state;
	support_write(support_path("block.xml"), heap);
	write_scene("  - {name: low, model: block.xml, start: {at: [14.013, 16.013]}}\n", things, "");
	must(try_drive(NULL, "out"));
	const struct drive_row *last = last_row("out", "low", NULL), *before = last - 50;
	const double drift = hypot(hypot(last->x - before->x, last->y - before->y), last->z - before->z);
	last_place("out", "world.upper", upper);
	last_place("out", "world.top", top);
	print_message("the lowest at %.4f m drifts by %.3g um/s; upon it %.4f m and %.4f m\n", last->z, drift * 1e6, upper[2], top[2]);
	assert_true(drift < 1e-5);
	assert_true(fabs(upper[2] - last->z - 0.3) < 0.005 && fabs(top[2] - upper[2] - 0.3) < 0.005);
}

static void resumed_it_goes_on_to_the_same_bits(void **state)
{
	static const char crate[] = "<mujoco><worldbody><body name=\"crate\" pos=\"15.2 16.013 20.4\"><freejoint/><geom type=\"box\" size=\"0.3 0.4 0.4\" mass=\"15\"/></body>"
				    "<body name=\"arm\" pos=\"14 19 22\"><joint axis=\"0 1 0\" damping=\"1\"/><geom type=\"capsule\" fromto=\"0 0 0 0.8 0 0\" size=\"0.05\"/></body></worldbody></mujoco>";
	(void)state;
	support_write(support_path("truck.xml"), truck);
	write_scene(TRUCK_AT("car", "truck.xml", "[14.013, 16.013]", "4"), crate, "");
	const char *const settings[] = {"end_time=1.2", NULL};
	must(try_drive(settings, "whole"));
	char scene[128], over[128], out[128], store[128];
	snprintf(scene, sizeof scene, "%s", support_path("scene.yaml"));
	snprintf(over, sizeof over, "%s", support_path("parts.furrow"));
	snprintf(out, sizeof out, "%s", support_path("parts"));
	snprintf(store, sizeof store, "%s", support_path("world.furrow"));
	must(make_drive(scene, store, settings, &(struct drive_cut){.out = out, .overlay = over, .steps = 171}, NULL));
	must(make_drive(scene, store, settings, &(struct drive_cut){.out = out, .overlay = over, .resume = true}, NULL));
	char whole[128];
	snprintf(whole, sizeof whole, "%s", support_path("whole"));
	assert_same_rows(whole, out, 500);
}

TEST_PROGRAM(things)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_wall_stops_a_vehicle_and_a_crate_is_pushed),
		cmocka_unit_test(what_starts_inside_a_thing_is_refused),
		cmocka_unit_test(a_trailer_follows_its_hitch),
		cmocka_unit_test(a_winch_pulls_a_vehicle_that_stands),
		cmocka_unit_test(what_fails_is_told_of_the_right_vehicle),
		cmocka_unit_test(one_that_is_far_away_changes_nothing),
		cmocka_unit_test(three_in_a_heap_come_to_rest),
		cmocka_unit_test(resumed_it_goes_on_to_the_same_bits),
	};
	return cmocka_run_group_tests_name("things of the world", tests, support_enter, support_leave);
}
