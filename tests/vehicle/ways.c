/*
 * Vehicles on paths: each way of steering comes to the end of straight lines, curves, an S and a closed loop, and stands there. The speed is held,
 * on the level and on slopes, whatever kind of actuator drives. Backward, along its origin, with stops, and with axes that look another way.
 */
#include <math.h>

#include "../long.h"
#include "../support/program.h"
#include "drive.h"

#define POINTS_MOST 64
#define ROWS 4000
#define X 20.0
#define Y 32.0

static double slope; /* tangent, rising to the east */

static const struct extent extent = {385, 257, 0.25, 128};

static double ground(int64_t x, int64_t y)
{
	(void)y;
	return 100 + slope * extent.spacing * (double)x;
}

enum shape { LINE, CURVE, S, LOOP, SHAPES };
static const char *const shape_names[] = {"line", "curve", "S", "loop"};

struct way {
	double points[POINTS_MOST][2], length;
	size_t count;
};

/* A way of a shape, so wide that a vehicle can take it at the speed. */
static struct way way_of(enum shape shape, double speed)
{
	struct way way = {.length = 0};
	const double size = fmax(0.4, fabs(speed) / 2), radius = 6 * size;
	const size_t last = shape == LINE ? 1 : shape == LOOP ? 48 : 24;
	for (size_t i = 0; i <= last; i++) {
		const double share = (double)i / (double)last, turn = share * (shape == CURVE ? M_PI / 2 : 2 * M_PI);
		const double x = shape == LINE ? 16 * size * share : shape == S ? 20 * size * share : radius * sin(turn);
		const double y = shape == LINE ? 0 : shape == S ? 1.5 * size * (1 - cos(turn)) : radius * (1 - cos(turn));
		way.points[way.count][0] = X + x;
		way.points[way.count++][1] = Y - 2 * radius * (shape == LOOP) + y;
	}
	for (size_t i = 1; i < way.count; i++)
		way.length += hypot(way.points[i][0] - way.points[i - 1][0], way.points[i][1] - way.points[i - 1][1]);
	return way;
}

struct drive {
	const char *model, *steer; /* of tests/vehicle; actuators that steer */
	double middle;             /* m: from its origin to the place that follows */
	double speed;
	enum shape shape;
	const char *driver, *vehicle, *path; /* more keys of the driver, the vehicle and the path, with a comma before each */
	const char *drives;        /* in place of the model's velocity servos: MJCF with two %s for the wheel's name; NULL: none */
	double yaw, seconds;       /* seconds: 0: as long as the way takes */
};

/* Writes the model, with other actuators that drive if they are given. */
static void write_model(const struct drive *drive)
{
	char path[512];
	snprintf(path, sizeof path, "%s/%s.xml", getenv("MODELS"), drive->model);
	char *text = support_text(path);
	FILE *to = fopen(support_path("model.xml"), "w");
	assert_non_null(to);
	for (char *line = strtok(text, "\n"); line != NULL; line = strtok(NULL, "\n")) {
		const char *wheel = strstr(line, "joint=\"turn_");
		if (drive->drives == NULL || strstr(line, "<velocity") == NULL) {
			fprintf(to, "%s\n", line);
			continue;
		}
		const char name[3] = {wheel[strlen("joint=\"turn_")], wheel[strlen("joint=\"turn_") + 1], '\0'};
		char other[512];
		snprintf(other, sizeof other, drive->drives, name, name);
		fprintf(to, "%s\n", other);
	}
	fclose(to);
	free(text);
}

static struct drive_row rows[ROWS];

/* Drives, and returns the number of rows. */
static size_t go(const struct drive *drive, struct way *way)
{
	const char *store = support_path("world.furrow");
	char points[4096] = "";
	*way = way_of(drive->shape, drive->speed);
	for (size_t i = 0; i < way->count; i++)
		snprintf(points + strlen(points), sizeof points - strlen(points), "%s[%.4f, %.4f]", i > 0 ? ", " : "", way->points[i][0], way->points[i][1]);
	const double speed = fabs(drive->speed), seconds = drive->seconds > 0 ? drive->seconds : way->length / speed + 1.5 * speed + 8;
	FILE *to = fopen(support_path("scene.yaml"), "w");
	assert_non_null(to);
	fprintf(to, "scene: 1\nend_time: %g\ntime_step: 0.004\nspacing: 0.0625\nsoil: {name: dry_sand, damping: 0}\nredistribute: {model: scm, faces: off}\n"
		    "vehicles:\n  - {name: v, model: model.xml, start: {at: [%.4f, %.4f], yaw: %g}, soil: [wheel_*]%s, driver: {path: {points: [%s]%s", seconds,
		way->points[0][0], way->points[0][1], drive->yaw, drive->vehicle != NULL ? drive->vehicle : "", points, drive->path != NULL ? drive->path : "");
	if (drive->path == NULL || strstr(drive->path, "speeds") == NULL)
		fprintf(to, ", speed: %g", drive->speed);
	fprintf(to, "}, steer: %s, drive: [drive_*]%s}}\noutput: {vehicles: 20}\n", drive->steer, drive->driver != NULL ? drive->driver : "");
	fclose(to);
	write_model(drive);
	support_store(store, extent, ground);
	must(make_drive(support_path("scene.yaml"), store, NULL, &(struct drive_cut){.out = support_path("out")}, NULL));
	return drive_rows(support_path("out/vehicles.csv"), "v", rows, ROWS);
}

/* How far the place that follows is from the end of the way, in plan. */
static double missed(const struct drive *drive, const struct way *way, const struct drive_row *row)
{
	const double yaw = row->yaw * M_PI / 180, *end = way->points[way->count - 1];
	return hypot(row->x + drive->middle * cos(yaw) - end[0], row->y + drive->middle * sin(yaw) - end[1]);
}

/* The mean speed over a part of the way to the east, along the slope. */
static double speed_between(size_t count, double from, double to)
{
	const struct drive_row *first = NULL, *last = NULL;
	for (size_t i = 0; i < count; i++) {
		first = first == NULL && rows[i].x >= from ? &rows[i] : first;
		last = last == NULL && rows[i].x >= to ? &rows[i] : last;
	}
	assert_true(first != NULL && last != NULL && last->t > first->t);
	return (last->x - first->x) * sqrt(1 + slope * slope) / (last->t - first->t);
}

static const struct drive steered[] = {
	{.model = "steers_front", .steer = "[steer_*]", .middle = -0.6},
	{.model = "steers_rear", .steer = "[steer_*]", .middle = 0.6},
	{.model = "steers_four", .steer = "[steer_fl]"},
	{.model = "steers_articulated", .steer = "[bend]", .middle = 0.2},
	{.model = "steers_rack", .steer = "[rack]", .middle = -0.6},
	{.model = "steers_skid", .steer = "[]"},
};

static void each_comes_to_its_end(void **state)
{
	static const double speeds[] = {0.5, 2, 5};
	(void)state;
	slope = 0;
	for (size_t m = 0; m < sizeof steered / sizeof *steered; m++)
		for (size_t v = 0; v < 3; v++)
			for (size_t shape = 0; shape < SHAPES; shape++) {
				struct drive drive = steered[m];
				struct way way;
				if (!by_turn(m + 5 * v + 7 * shape, 12))
					continue;
				drive.speed = speeds[v];
				drive.shape = (enum shape)shape;
				const size_t count = go(&drive, &way);
				const struct drive_row *end = &rows[count - 1];
				const double miss = missed(&drive, &way, end);
				print_message("%s, %s at %g m/s: %.3f m from its end, at %.4f m/s\n", drive.model, shape_names[shape], drive.speed, miss,
					      hypot(end->vx, end->vy));
				assert_true(miss < 0.2);
				assert_true(hypot(end->vx, end->vy) < 0.02);
			}
}

static void a_speed_is_held_whatever_drives(void **state)
{
	static const struct {
		const char *name, *drives;
	} kinds[] = {
		{"velocity servos", NULL},
		{"motors", "<motor name=\"drive_%s\" joint=\"turn_%s\" ctrlrange=\"-150 150\"/>"},
		{"dcmotors", "<dcmotor name=\"drive_%s\" joint=\"turn_%s\" motorconst=\"2\" resistance=\"0.3\"/>"},
		{"pids", "<pid name=\"drive_%s\" joint=\"turn_%s\" kp=\"500\" kv=\"100\"/>"},
		{"intvelocity", "<intvelocity name=\"drive_%s\" joint=\"turn_%s\" kp=\"1000\" kv=\"20\"/>"},
		{"position", "<position name=\"drive_%s\" joint=\"turn_%s\" kp=\"500\" kv=\"20\"/>"},
	};
	static const double speeds[] = {0.5, 1, 2}, slopes[] = {0, 10, -10};
	(void)state;
	for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
		for (size_t s = 0; s < 3; s++)
			for (size_t v = 0; v < 3; v++) {
				struct drive drive = {.model = "steers_front", .steer = "[steer_*]", .middle = -0.6, .speed = speeds[v], .drives = kinds[k].drives};
				struct way way;
				if (!by_turn(k + 2 * s + 3 * v, 9))
					continue;
				slope = tan(slopes[s] * M_PI / 180);
				const size_t count = go(&drive, &way);
				const double speed = speed_between(count, X + 0.45 * way.length, X + 0.6 * way.length), miss = missed(&drive, &way, &rows[count - 1]);
				print_message("%s on %g degrees: %.4f for %g m/s, %.3f m from its end\n", kinds[k].name, slopes[s], speed, speeds[v], miss);
				assert_true(fabs(speed - speeds[v]) < 0.05 * speeds[v]);
				assert_true(miss < 0.2); /* and it holds there */
			}
	slope = 0;
}

static void it_drives_backward(void **state)
{
	(void)state;
	for (size_t m = 0; m < sizeof steered / sizeof *steered; m++) {
		struct drive drive = steered[m];
		struct way way;
		if (!by_turn(m, 3))
			continue;
		drive.speed = -1;
		drive.shape = S;
		drive.yaw = 180;
		const size_t count = go(&drive, &way);
		const double miss = missed(&drive, &way, &rows[count - 1]);
		print_message("%s backward: %.3f m from its end, yaw %.1f\n", drive.model, miss, rows[count - 1].yaw);
		assert_true(miss < 0.2 && fabs(rows[count - 1].yaw) > 165);
	}
}

static void its_origin_follows(void **state)
{
	(void)state;
	for (size_t m = 0; m < 3; m++) {
		struct drive drive = steered[m];
		struct way way;
		drive.speed = 1;
		drive.shape = CURVE;
		drive.driver = ", follow: origin";
		const size_t count = go(&drive, &way);
		const double along = missed(&drive, &way, &rows[count - 1]);
		drive.middle = 0;
		const double miss = missed(&drive, &way, &rows[count - 1]);
		print_message("%s: its origin %.3f m from its end, its axle %.3f m\n", drive.model, miss, along);
		assert_true(miss < 0.2 && (m == 2 || along > 0.4));
	}
}

static void it_stops_and_goes_at_the_speeds_of_its_points(void **state)
{
	struct drive drive = {.model = "steers_front", .steer = "[steer_*]", .middle = -0.6, .speed = 1, .path = ", stop: [[4, 8]]"};
	struct way way;
	(void)state;
	size_t count = go(&drive, &way);
	double stood = 0;
	for (size_t i = 0; i < count; i++)
		stood = rows[i].t > 5.7 && rows[i].t < 8 ? fmax(stood, hypot(rows[i].vx, rows[i].vy)) : stood;
	assert_true(stood < 0.02 && missed(&drive, &way, &rows[count - 1]) < 0.2);
	drive.path = ", speeds: [0.5, 1.5]"; /* 1 m/s in the middle of its way */
	drive.seconds = 20;
	count = go(&drive, &way);
	for (double at = 2; at <= 5; at++) {
		const double speed = speed_between(count, X + at - 0.1 + 0.6, X + at + 0.1 + 0.6); /* the axle is 0.6 m behind */
		assert_true(fabs(speed / (0.5 + at / way.length) - 1) < 0.07);
	}
	assert_true(missed(&drive, &way, &rows[count - 1]) < 0.2);
}

static void other_axes_drive_alike(void **state)
{
	static const struct {
		const char *name, *keys;
	} models[] = {{"steers_front", NULL}, {"looks_y", ", forward: +y"}, {"looks_back", ", forward: -x, up: y"}};
	double ends[3][2];
	(void)state;
	for (size_t m = 0; m < 3; m++) {
		struct drive drive = {.model = models[m].name, .steer = "[steer_*]", .middle = -0.6, .speed = 1, .shape = S, .vehicle = models[m].keys};
		struct way way;
		const struct drive_row *end = &rows[go(&drive, &way) - 1];
		print_message("%s: %.4f, %.4f, roll %.3f pitch %.3f yaw %.3f\n", drive.model, end->x, end->y, end->roll, end->pitch, end->yaw);
		assert_true(missed(&drive, &way, end) < 0.2 && fabs(end->roll) < 2 && fabs(end->pitch) < 2 && fabs(end->yaw) < 10);
		ends[m][0] = end->x;
		ends[m][1] = end->y;
	}
	for (size_t m = 1; m < 3; m++)
		assert_true(hypot(ends[m][0] - ends[0][0], ends[m][1] - ends[0][1]) < 0.03);
}

TEST_PROGRAM(ways)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(each_comes_to_its_end),
		cmocka_unit_test(a_speed_is_held_whatever_drives),
		cmocka_unit_test(it_drives_backward),
		cmocka_unit_test(its_origin_follows),
		cmocka_unit_test(it_stops_and_goes_at_the_speeds_of_its_points),
		cmocka_unit_test(other_axes_drive_alike),
	};
	return cmocka_run_group_tests_name("vehicles on paths", tests, support_enter, support_leave);
}
