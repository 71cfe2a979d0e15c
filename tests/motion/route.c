/* Curves, ways beside a path and delays, against closed forms. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "../support/near.h"
#include "motion/motion.h"
#include "../support/program.h"

#define MOST 64

/* A path of up to MOST points. */
struct made {
	struct scene_waypoint waypoints[MOST];
	double points[MOST][2];
	struct scene_path path, route;
};

static void add(struct made *made, double t, double x, double y)
{
	const size_t i = made->path.count++;
	made->path.points = made->waypoints;
	made->waypoints[i].t = t;
	made->points[i][0] = x;
	made->points[i][1] = y;
}

static struct scene_path *route_of(struct made *made)
{
	assert_int_equal(motion_route_create(&made->path, "it", (const double(*)[2])made->points, &made->route), STATUS_OK);
	return &made->route;
}

static struct track *track_of(const struct scene_path *route)
{
	struct track *track;
	assert_int_equal(motion_track_create(route, 0.125, 0.5, &track), STATUS_OK);
	return track;
}

static void at(const struct track *track, double time, double x, double y, double tolerance)
{
	struct track_point point;
	motion_track_at(track, time, &point);
	if (!(hypot(point.x - x, point.y - y) <= tolerance))
		fail_msg("after %g s it is at %.9g, %.9g, not at %.9g, %.9g", time, point.x, point.y, x, y);
}

static double length_of(const struct scene_path *path)
{
	double length = 0;
	for (size_t i = 1; i < path->count; i++)
		length += hypot(path->points[i].x - path->points[i - 1].x, path->points[i].y - path->points[i - 1].y);
	return length;
}

/* --- curves --- */

static void add_circle(struct made *made, size_t count, double radius, const double middle[2])
{
	for (size_t i = 0; i < count; i++) {
		const double angle = 2 * M_PI * (double)i / (double)count;
		add(made, 0, middle[0] + radius * cos(angle), middle[1] + radius * sin(angle));
	}
	made->path.loop = true;
	made->path.smooth = true;
	made->path.speed = 1;
}

/* How far the curve through points of a circle is off it. */
static double off_circle(size_t count, double radius, const double middle[2])
{
	struct made made = {.path = {.count = 0}};
	double worst = 0;
	add_circle(&made, count, radius, middle);
	const struct scene_path *route = route_of(&made);
	for (size_t i = 0; i < route->count; i++)
		worst = support_most(worst, fabs(hypot(route->points[i].x - middle[0], route->points[i].y - middle[1]) - radius));
	motion_route_finish(&made.route);
	return worst;
}

/* Its error falls as the fourth power of the distance of the points. */
static void a_curve_through_points_of_a_circle_is_the_circle(void **state)
{
	static const double places[][2] = {{0, 0}, {1000, -300}, {52000.5, 71000.25}};
	for (size_t i = 0; i < 3; i++) {
		const double few = off_circle(8, 20, places[i]), more = off_circle(16, 20, places[i]), most = off_circle(32, 20, places[i]);
		print_message("8 points: %.6f m, 16: %.6f m, 32: %.6f m\n", few, more, most);
		/* A program of another language has 0.1694, 0.0110 and 0.00069. */
		assert_near(few, 0.1694, 1e-4);
		assert_near(more, 0.0110, 1e-4);
		assert_near(most, 0.00069, 1e-5);
		assert_near(few / more, 16, 1.6);
		assert_near(more / most, 16, 1.6);
	}
}

static void a_curve_goes_through_all_points_and_turns_nowhere_at_once(void **state)
{
	struct made made = {.path = {.smooth = true, .speed = 2}};
	static const double corners[][2] = {{0, 0}, {10, 0}, {10, 10}, {10.5, 10.2}, {40, 10}, {40, -30}};
	for (size_t i = 0; i < 6; i++)
		add(&made, 0, corners[i][0], corners[i][1]);
	const struct scene_path *route = route_of(&made);
	size_t reached = 0; /* points come one after the other */
	for (size_t k = 0; k < route->count && reached < 6; k++)
		reached += hypot(route->points[k].x - corners[reached][0], route->points[k].y - corners[reached][1]) < 1e-12;
	assert_int_equal(reached, 6);
	assert_true(route->count > 60);
	double sharpest = 0;
	for (size_t k = 2; k < route->count; k++) {
		const struct scene_waypoint *a = &route->points[k - 2], *b = a + 1, *c = b + 1;
		const double turn = atan2(c->y - b->y, c->x - b->x) - atan2(b->y - a->y, b->x - a->x);
		sharpest = support_most(sharpest, fabs(remainder(turn, 2 * M_PI)));
	}
	assert_true(sharpest < 0.12);
	assert_true(length_of(route) > 10 + 10 && length_of(route) < 1.2 * (20 + 0.54 + 29.5 + 40));
	motion_route_finish(&made.route);
}

static void a_curve_along_a_line_is_the_line(void **state)
{
	struct made made = {.path = {.smooth = true, .speed = 1}};
	for (int i = 0; i < 5; i++)
		add(&made, 0, 3 * i, 4 * i);
	const struct scene_path *route = route_of(&made);
	assert_near(length_of(route), 20, 1e-12);
	for (size_t k = 0; k < route->count; k++)
		assert_near(route->points[k].y * 3, route->points[k].x * 4, 1e-12);
	motion_route_finish(&made.route);
}

/* Places of the lattice: moved by them, the path samples move by as much, bit by bit. */
static void a_curve_and_a_way_beside_have_the_same_bits_at_any_place(void **state)
{
	static const double moves[][2] = {{0, 0}, {4096, 8192}, {-1024.5, 65536.25}};
	struct track *tracks[3];
	for (size_t i = 0; i < 3; i++) {
		struct made made = {.path = {.smooth = true, .speed = 2, .beside = {1.25, 0.7}}};
		static const double corners[][2] = {{0, 0}, {10, 0}, {14, 10}, {40, 11}};
		for (size_t k = 0; k < 4; k++)
			add(&made, 0, corners[k][0] + moves[i][0], corners[k][1] + moves[i][1]);
		tracks[i] = track_of(route_of(&made));
		motion_route_finish(&made.route);
	}
	assert_true(motion_track_samples(tracks[0]) > 300);
	for (size_t i = 1; i < 3; i++) {
		assert_int_equal(motion_track_samples(tracks[i]), motion_track_samples(tracks[0]));
		for (int64_t k = 0; k < motion_track_samples(tracks[0]); k++) {
			struct track_point a, b;
			motion_track_sample(tracks[0], k, &a);
			motion_track_sample(tracks[i], k, &b);
			assert_true(b.qx - a.qx == lattice_offset(moves[i][0]) && b.qy - a.qy == lattice_offset(moves[i][1]));
			assert_true(a.yaw == b.yaw && a.time == b.time);
		}
	}
	for (size_t i = 0; i < 3; i++)
		motion_track_destroy(tracks[i]);
}

static void a_curve_keeps_times_and_heights_at_its_points(void **state)
{
	struct made made = {.path = {.smooth = true, .timed = true, .has_z = true}};
	static const double rows[][4] = {{1, 0, 0, 5}, {3, 10, 0, 6}, {5, 10, 0, 7}, {9, 20, 10, 8}};
	for (size_t i = 0; i < 4; i++) {
		add(&made, rows[i][0], rows[i][1], rows[i][2]);
		made.waypoints[i].z = rows[i][3];
	}
	struct track *track = track_of(route_of(&made));
	struct track_point point;
	for (size_t i = 0; i < 4; i++) {
		at(track, rows[i][0], rows[i][1], rows[i][2], 1e-6);
		motion_track_at(track, rows[i][0], &point);
		assert_near(point.z, rows[i][3], 1e-6);
	}
	at(track, 4, 10, 0, 1e-6); /* it pauses */
	for (size_t i = 1; i < made.route.count; i++)
		assert_true(made.route.points[i].t > made.route.points[i - 1].t);
	motion_track_destroy(track);
	motion_route_finish(&made.route);
}

/* --- beside --- */

static void a_line_has_lines_beside_it(void **state)
{
	static const double offsets[][2] = {{0, 1}, {0, -2}, {-5, 0}, {3, 0.5}};
	for (size_t i = 0; i < 4; i++) {
		const double ahead = offsets[i][0], left = offsets[i][1];
		struct made made = {.path = {.speed = 5, .beside = {ahead, left}}};
		add(&made, 0, 100, 100);
		add(&made, 0, 130, 140);
		struct track *track = track_of(route_of(&made));
		for (double t = 0; t <= 10; t += 0.7) /* along 0.6, 0.8 */
			at(track, t, 100 + 0.6 * (5 * t + ahead) - 0.8 * left, 100 + 0.8 * (5 * t + ahead) + 0.6 * left, 2e-6);
		motion_track_destroy(track);
		motion_route_finish(&made.route);
	}
}

/* The way beside a corner has its own corner where both offset lines meet, and is abreast of the path before it and after it. */
static void beside_a_corner_the_lines_meet(void **state)
{
	for (double left = -2; left <= 2; left += 0.5) {
		struct made made = {.path = {.speed = 1, .beside = {0, left}}};
		add(&made, 0, 0, 0);
		add(&made, 0, 10, 0);
		add(&made, 0, 10, 20);
		struct track *track = track_of(route_of(&made));
		struct track_point point;
		at(track, 0, 0, left, 2e-6);
		at(track, 10, 10 - left, left, 2e-6);
		at(track, 5, (10 - left) / 2, left, 2e-6);
		at(track, 30, 10 - left, 20, 2e-6);
		motion_track_at(track, 9, &point);
		assert_near(point.yaw, 0, 1e-6); /* it turns at the corner, as the path does */
		motion_track_at(track, 11, &point);
		assert_near(point.yaw, M_PI / 2, 1e-6);
		motion_track_destroy(track);
		motion_route_finish(&made.route);
	}
}

/* Wheels of a car on a circle: each on its own circle, all at the same angle of it at any time, lap after lap. */
static void beside_a_circle_are_circles(void **state)
{
	static const double middle[2] = {50, 60};
	struct made round = {.path = {.count = 0}};
	add_circle(&round, 48, 20, middle);
	const double lap = length_of(route_of(&round)) + hypot(round.route.points[0].x - round.route.points[round.route.count - 1].x,
							       round.route.points[0].y - round.route.points[round.route.count - 1].y);
	motion_route_finish(&round.route);
	assert_near(lap, 40 * M_PI, 0.01);
	for (int i = 0; i < 9; i++) {
		const double ahead = (i / 3 - 1) * 3.0, left = (i % 3 - 1) * 1.5;
		struct made made = {.path = {.beside = {ahead, left}}};
		add_circle(&made, 48, 20, middle);
		struct track *track = track_of(route_of(&made));
		for (double t = 0; t < 3 * lap; t += lap / 7) {
			const double angle = (t + ahead) / lap * 2 * M_PI;
			at(track, t, middle[0] + (20 - left) * cos(angle), middle[1] + (20 - left) * sin(angle), 0.01);
		}
		motion_track_destroy(track);
		motion_route_finish(&made.route);
	}
}

/* A file without attitudes that pauses: what follows behind pauses, too, and at the same time. */
static void what_follows_pauses_with_it(void **state)
{
	struct made made = {.path = {.timed = true, .beside = {-4, 0}, .delay = 2}};
	add(&made, 1, 0, 0);
	add(&made, 6, 10, 0);
	add(&made, 9, 10, 0);
	add(&made, 19, 10, 10);
	struct track *track = track_of(route_of(&made));
	assert_near(motion_track_sample_time(track, 0), 3, 1e-12);
	at(track, 3, -4, 0, 1e-6);
	at(track, 8, 6, 0, 1e-6);
	at(track, 10, 6, 0, 1e-6);
	at(track, 11, 6, 0, 1e-6);
	at(track, 13, 8, 0, 1e-6);
	at(track, 15, 10, 0, 1e-6); /* 4 m later it is at the corner */
	at(track, 21, 10, 6, 1e-6);
	assert_near(motion_track_sample_time(track, motion_track_samples(track) - 1), 21, 1e-12);
	motion_track_destroy(track);
	motion_route_finish(&made.route);
}

static void with_attitudes_it_is_fixed_to_the_body(void **state)
{
	struct made made = {.path = {.timed = true, .has_z = true, .has_attitude = true, .beside = {2, 1}}};
	add(&made, 0, 10, 10);
	add(&made, 4, 10, 10);
	made.waypoints[1].yaw = M_PI / 2; /* it turns in place */
	add(&made, 8, 10, 20);
	made.waypoints[2].yaw = M_PI / 2;
	made.waypoints[2].pitch = 0.3; /* nose up */
	struct track *track = track_of(route_of(&made));
	struct track_point point;
	for (double t = 0; t <= 4; t += 0.25) {
		const double yaw = t / 4 * M_PI / 2;
		at(track, t, 10 + 2 * cos(yaw) - sin(yaw), 10 + 2 * sin(yaw) + cos(yaw), 2e-3 /* a chord of 2 degrees is 0.4 mm off */);
		motion_track_at(track, t, &point);
		assert_near(point.yaw, yaw, 1e-9);
		assert_near(point.z, 0, 1e-6);
	}
	at(track, 8, 10 - 1, 20 + 2 * cos(0.3), 2e-6);
	motion_track_at(track, 8, &point);
	assert_near(point.z, 2 * sin(0.3), 2e-6);
	assert_near(point.pitch, 0.3, 1e-12);
	motion_track_destroy(track);
	motion_route_finish(&made.route);
}

static void what_stands_has_something_beside_it(void **state)
{
	struct made made = {.path = {.speed = 1, .beside = {3, -1}}};
	add(&made, 0, 7, 8);
	struct track *track = track_of(route_of(&made));
	at(track, 5, 10, 7, 1e-6);
	motion_track_destroy(track);
	motion_route_finish(&made.route);
}

static void too_tight_a_turn_is_refused(void **state)
{
	static const struct {
		double points[4][2], left;
		const char *says;
	} cases[] = {
		{{{100, 0}, {110, 0}, {100, 0.1}, {100, 5}}, 1, "objects.it.path: the path that it is relative to turns back at 110, 0 m, and 1 m beside it"},
		{{{0, 0}, {10, 0}, {10, 1}, {0, 1}}, 3, "turns tightly at 10, 0 m, and 3 m beside it there is no way"},
	};
	for (size_t i = 0; i < 2; i++) {
		struct made made = {.path = {.speed = 1, .beside = {0, cases[i].left}}};
		for (size_t k = 0; k < 4; k++)
			add(&made, 0, cases[i].points[k][0], cases[i].points[k][1]);
		assert_int_equal(motion_route_create(&made.path, "it", (const double(*)[2])made.points, &made.route), STATUS_INPUT);
		assert_non_null(strstr(failure_message(), cases[i].says));
		/* On the path itself anything is possible. */
		made.path.beside[0] = -2;
		made.path.beside[1] = 0;
		route_of(&made);
		motion_route_finish(&made.route);
	}
}

static void a_delay_moves_all_times(void **state)
{
	for (int loop = 0; loop < 2; loop++) {
		struct made made = {.path = {.speed = 2, .loop = loop != 0}}, later = made;
		later.path.delay = 7.5;
		for (int i = 0; i < 2; i++) {
			add(i ? &made : &later, 0, 0, 0);
			add(i ? &made : &later, 0, 10, 0);
			add(i ? &made : &later, 0, 10, 10);
		}
		struct track *a = track_of(route_of(&made)), *b = track_of(route_of(&later));
		if (!loop)
			assert_int_equal(motion_track_samples(a), motion_track_samples(b));
		const int64_t count = loop ? 200 : motion_track_samples(a);
		assert_true(count > 50);
		for (int64_t i = 0; i < count; i++) {
			assert_near(motion_track_sample_time(b, i), motion_track_sample_time(a, i) + 7.5, 1e-9);
		}
		struct track_point point;
		for (double t = 0; t < 30; t += 0.3) {
			motion_track_at(a, t, &point);
			at(b, t + 7.5, point.x, point.y, 1e-6);
		}
		at(b, 3, 0, 0, 0);
		motion_track_destroy(a);
		motion_track_destroy(b);
		motion_route_finish(&made.route);
		motion_route_finish(&later.route);
	}
}

static void memory_that_is_out_is_told(void **state)
{
	struct made made = {.path = {.speed = 1, .smooth = true, .beside = {-1, 1}}};
	add(&made, 0, 0, 0);
	add(&made, 0, 50, 0);
	add(&made, 0, 90, 80);
	enum status status;
	uint64_t nth = 0;
	do {
		mem_fail_nth(++nth, false);
		status = motion_route_create(&made.path, "it", (const double(*)[2])made.points, &made.route);
		mem_fail_nth(0, 0);
		if (status != STATUS_OK)
			assert_int_equal(status, STATUS_FAILED);
	} while (status != STATUS_OK && nth < 100);
	assert_int_equal(status, STATUS_OK);
	assert_true(nth > 4);
	motion_route_finish(&made.route);
}

TEST_PROGRAM(route)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_curve_through_points_of_a_circle_is_the_circle),
		cmocka_unit_test(a_curve_goes_through_all_points_and_turns_nowhere_at_once),
		cmocka_unit_test(a_curve_along_a_line_is_the_line),
		cmocka_unit_test(a_curve_and_a_way_beside_have_the_same_bits_at_any_place),
		cmocka_unit_test(a_curve_keeps_times_and_heights_at_its_points),
		cmocka_unit_test(a_line_has_lines_beside_it),
		cmocka_unit_test(beside_a_corner_the_lines_meet),
		cmocka_unit_test(beside_a_circle_are_circles),
		cmocka_unit_test(what_follows_pauses_with_it),
		cmocka_unit_test(with_attitudes_it_is_fixed_to_the_body),
		cmocka_unit_test(what_stands_has_something_beside_it),
		cmocka_unit_test(too_tight_a_turn_is_refused),
		cmocka_unit_test(a_delay_moves_all_times),
		cmocka_unit_test(memory_that_is_out_is_told),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
