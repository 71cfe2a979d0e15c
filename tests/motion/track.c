/* Paths flattened into stations. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "motion/motion.h"
#include "../support/near.h"
#include "../support/program.h"

static struct track *track_of(struct scene_path *path, const double (*points)[2])
{
	struct track *track;
	for (size_t i = 0; i < path->count; i++) {
		path->points[i].x = points[i][0];
		path->points[i].y = points[i][1];
	}
	assert_int_equal(motion_track_create(path, 0.25, 1, &track), STATUS_OK);
	return track;
}

static void stations_are_one_post_apart_and_the_last_is_the_end(void **state)
{
	struct scene_waypoint waypoints[3] = {{0}};
	const double points[][2] = {{0, 0}, {3, 4}, {3, 5.1}};
	struct scene_path path = {.points = waypoints, .count = 3, .speed = 2};
	struct track *track = track_of(&path, points);
	int64_t count = motion_track_samples(track);
	assert_int_equal(count, 24 + 2); /* 6.1 m: 24 whole posts, the first, and the rest */
	struct track_point point, before;
	motion_track_sample(track, 0, &before);
	assert_true(before.x == 0 && before.y == 0 && before.time == 0);
	for (int64_t i = 1; i < count; i++) {
		motion_track_sample(track, i, &point);
		double step = hypot(point.x - before.x, point.y - before.y);
		assert_true(fabs(step - (i + 1 < count ? 0.25 : 0.1)) < 3e-6); /* places are the pose lattice's */
		assert_true(fabs(point.time - (i + 1 < count ? (double)i * 0.125 : 3.05)) < 1e-6);
		assert_true(fabs(point.yaw - (i < 20 ? atan2(4, 3) : M_PI / 2)) < 1e-12);
		before = point;
	}
	assert_true(point.x == 3 && point.qy == lattice_offset(5.1));
	motion_track_destroy(track);
}

static void a_path_is_the_same_to_the_bit_wherever_it_lies(void **state)
{
	struct scene_waypoint waypoints[2] = {{0}};
	const double out = 9984000;
	const double near[][2] = {{100.3, 40}, {130.1, 71.7}}, far[][2] = {{out + 100.3, 40}, {out + 130.1, 71.7}};
	struct scene_path path = {.points = waypoints, .count = 2, .speed = 3};
	struct track *a = track_of(&path, near), *b = track_of(&path, far);
	assert_int_equal(motion_track_samples(a), motion_track_samples(b));
	for (int64_t i = 0; i < motion_track_samples(a); i++) {
		struct track_point p, q;
		motion_track_sample(a, i, &p);
		motion_track_sample(b, i, &q);
		assert_true(q.qx - p.qx == lattice_offset(out) && q.qy == p.qy);
		assert_true(p.time == q.time && p.yaw == q.yaw);
	}
	motion_track_destroy(a);
	motion_track_destroy(b);
}

static void a_loop_returns_to_its_start_for_ever(void **state)
{
	struct scene_waypoint waypoints[4] = {{0}};
	const double points[][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
	struct scene_path path = {.points = waypoints, .count = 4, .speed = 1, .loop = true};
	struct track *track = track_of(&path, points);
	assert_true(motion_track_samples(track) == INT64_MAX);
	struct track_point first, again;
	for (int64_t i = 0; i < 16; i++) {
		motion_track_sample(track, i, &first);
		motion_track_sample(track, i + 16 * 1000, &again);
		assert_true(first.x == again.x && first.y == again.y);
		assert_true(fabs(again.time - first.time - 4000) < 1e-9);
	}
	motion_track_at(track, 4003.5, &again);
	assert_true(fabs(again.x) < 1e-6 && fabs(again.y - 0.5) < 1e-6);
	motion_track_destroy(track);
}

static void a_timed_path_keeps_its_times_and_turns_the_short_way(void **state)
{
	struct scene_waypoint waypoints[3] = {
		{1, 0, 0, 10, 3.0, 0, 0}, {3, 0, 0, 10, -3.0, 0.5, 0}, {4, 0, 0, 8, -3.0, 0.5, 0}};
	const double points[][2] = {{0, 0}, {0, 0}, {0, 0}};
	struct scene_path path = {.points = waypoints, .count = 3, .timed = true, .has_z = true, .has_attitude = true};
	struct track *track = track_of(&path, points);
	struct track_point point;
	motion_track_at(track, 2, &point);
	assert_true(fabs(fabs(remainder(point.yaw, 2 * M_PI)) - M_PI) < 1e-9);
	assert_true(fabs(point.pitch - 0.25) < 1e-12 && point.z == 10);
	motion_track_at(track, 3.5, &point);
	assert_true(fabs(point.z - 9) < 1e-12);
	/* Turning in place is travel too, and so is sinking. */
	assert_true(motion_track_samples(track) > 8);
	double last = 0;
	for (int64_t i = 0; i < motion_track_samples(track); i++) {
		double time = motion_track_sample_time(track, i);
		assert_true(time >= 1 && time <= 4 && time >= last);
		last = time;
	}
	assert_true(last == 4);
	motion_track_destroy(track);
}

static void an_attitude_turns_a_body_against_its_way(void **state)
{
	struct scene_waypoint waypoints[3] = {{0}};
	const double points[][2] = {{0, 0}, {4, 0}, {4, 4}};
	struct scene_path path = {.points = waypoints, .count = 3, .speed = 1, .attitude = {0.5, -0.2, 0.1}};
	struct track *track = track_of(&path, points);
	struct track_point point;
	for (double t = 0.5; t < 8; t += 1) {
		motion_track_at(track, t, &point);
		assert_true(fabs(point.yaw - (t < 4 ? 0.5 : M_PI / 2 + 0.5)) < 1e-12);
		assert_true(point.pitch == -0.2 && point.roll == 0.1);
	}
	motion_track_destroy(track);
	/* Waypoints with an attitude of their own have it. */
	path = (struct scene_path){.points = waypoints, .count = 3, .timed = true, .has_attitude = true, .attitude = {0}};
	track = track_of(&path, points);
	motion_track_at(track, 0, &point);
	assert_true(point.yaw == 0 && point.pitch == 0);
	motion_track_destroy(track);
}

static void a_timed_path_that_stands_still_is_there_from_when_it_came(void **state)
{
	struct scene_waypoint waypoints[4] = {{.t = 1}, {.t = 2}, {.t = 4}, {.t = 9}};
	const double points[][2] = {{0, 0}, {0, 0}, {5, 0}, {5, 0}};
	struct scene_path path = {.points = waypoints, .count = 4, .timed = true};
	struct track *track = track_of(&path, points);
	int64_t last = motion_track_samples(track) - 1;
	assert_int_equal(last, 20);
	assert_true(motion_track_sample_time(track, 0) == 1);
	assert_true(fabs(motion_track_sample_time(track, 10) - 3) < 1e-9);
	assert_true(motion_track_sample_time(track, last) == 4);
	assert_true(fabs(motion_track_fastest(track) - 2.5) < 1e-9);
	motion_track_destroy(track);
	path.count = 2;
	track = track_of(&path, points);
	assert_int_equal(motion_track_samples(track), 1);
	assert_true(motion_track_sample_time(track, 0) == 1);
	motion_track_destroy(track);
}

/* Rows far apart, with a right angle: no body slides along its way sideways. */
static void without_yaws_a_timed_path_looks_the_way_it_goes(void **state)
{
	struct scene_waypoint waypoints[6] = {{.t = 0}, {.t = 1}, {.t = 5}, {.t = 9}, {.t = 10}, {.t = 12}};
	const double points[][2] = {{1, 1}, {1, 1}, {1, 9}, {9, 9}, {9, 9}, {7, 9}}, yaws[] = {90, 90, 0, 0, 180};
	struct scene_path path = {.points = waypoints, .count = 6, .timed = true};
	struct track *track = track_of(&path, points);
	for (int i = 0; i < 5; i++)
		for (int k = 1; k < 4; k++) {
			struct track_point point;
			motion_track_at(track, waypoints[i].t + 0.25 * k * (waypoints[i + 1].t - waypoints[i].t), &point);
			assert_near(point.yaw, yaws[i] * M_PI / 180, 1e-12);
		}
	motion_track_destroy(track);
}

static void a_single_point_is_one_station(void **state)
{
	struct scene_waypoint waypoint = {0};
	const double points[][2] = {{5, 6}};
	struct scene_path path = {.points = &waypoint, .count = 1, .speed = 0};
	struct track *track = track_of(&path, points);
	assert_int_equal(motion_track_samples(track), 1);
	struct track_point point;
	motion_track_at(track, 100, &point);
	assert_true(point.x == 5 && point.y == 6);
	motion_track_destroy(track);
}

/* The slow way round: station by station. */
/* The most samples within any time, against a count at each sample. */
static void the_most_samples_of_an_interval_are_known(void **state)
{
	struct scene_waypoint waypoints[6] = {{0}};
	const double points[][2] = {{0, 0}, {1, 0}, {9, 0}, {9, 0}, {9, 30}, {10, 30}}, times[] = {0, 4, 5, 9, 9 + 1e-9, 30};
	for (int timed = 0; timed < 2; timed++) {
		struct scene_path path = {.points = waypoints, .count = 6, .speed = 3, .timed = timed != 0, .delay = 2};
		for (int i = 0; i < 6; i++)
			waypoints[i].t = times[i];
		struct track *track = track_of(&path, points);
		const int64_t samples = motion_track_samples(track);
		for (double seconds = 1e-12; seconds < 100; seconds *= 3) {
			int64_t most = 0;
			for (int64_t i = 0; i < samples; i++) {
				int64_t due = 1;
				while (i + due < samples && motion_track_sample_time(track, i + due) <= motion_track_sample_time(track, i) + seconds)
					due++;
				most = due > most ? due : most;
			}
			const double told = motion_track_most(track, seconds);
			if (!(told >= (double)most - 1e-3 && told <= (double)most + 2))
				fail_msg("%d: within %g s %g, counted %lld", timed, seconds, told, (long long)most);
		}
		motion_track_destroy(track);
	}
}

static int64_t first_outside(const struct track *track, int64_t count, double width, double height)
{
	for (int64_t i = 0; i < count; i++) {
		struct track_point point;
		motion_track_sample(track, i, &point);
		if (point.x < 0 || point.y < 0 || point.x > width || point.y > height)
			return i;
	}
	return -1;
}

static void where_a_path_leaves_is_found(void **state)
{
	struct scene_waypoint waypoints[6] = {{0}};
	static const struct {
		double points[6][2];
		size_t count;
		bool loop;
	} paths[] = {
		{{{1, 1}, {9, 9}}, 2, false},
		{{{0, 0}, {10, 8}}, 2, false}, /* the edge is ground */
		{{{1, 1}, {11, 1}}, 2, false},
		{{{1, 1}, {1, 1}, {1, -3}, {5, 5}}, 4, false},
		{{{-1, 1}, {5, 1}}, 2, false},
		{{{-1, 4}, {12, 4}}, 2, false}, /* across, from outside */
		{{{-1, 2}, {2, -1}}, 2, false},
		{{{5, 4}, {5, 8.1}}, 2, false}, /* by less than a post, at its end */
		{{{5, 5}, {5, 8.1}, {5, 5}}, 3, false}, /* by less than a post, between two stations */
		{{{12, 4}}, 1, false},
		{{{5, 4}}, 1, false},
		{{{1, 1}, {5, 1}, {5, 7}, {1, 12}}, 4, true},
		{{{1, 1}, {9, 1}, {9, 7}, {1, 7}}, 4, true},
		{{{1, 1}, {1, 7.9}, {-0.2, 7.9}, {1, 7.9}}, 4, true},
	};
	int outside = 0;
	for (size_t i = 0; i < sizeof paths / sizeof *paths; i++) {
		struct scene_path path = {.points = waypoints, .count = paths[i].count, .speed = 1, .loop = paths[i].loop};
		struct track *track = track_of(&path, paths[i].points);
		int64_t count = motion_track_samples(track), found = motion_track_leaves(track, 10, 8);
		assert_int_equal(found, first_outside(track, paths[i].loop ? 1000 : count, 10, 8));
		outside += found >= 0;
		motion_track_destroy(track);
	}
	assert_int_equal(outside, 10);
}

static void assert_way(const struct track *track, double time, size_t count, const double (*wanted)[2])
{
	double places[8][2];
	assert_true(motion_track_corners(track) <= 8);
	assert_int_equal(motion_track_way(track, time, places), count);
	for (size_t i = 0; i < count; i++)
		assert_true(hypot(places[i][0] - wanted[i][0], places[i][1] - wanted[i][1]) < 1e-5);
}

static void a_way_has_its_corners_and_ends_where_the_object_is(void **state)
{
	struct scene_waypoint waypoints[3] = {{.t = 1}, {.t = 5}, {.t = 6}};
	const double points[][2] = {{10, 10}, {40, 50}, {40, 10}};
	struct scene_path path = {.points = waypoints, .count = 3, .speed = 10};
	struct track *track = track_of(&path, points);
	assert_way(track, 0, 2, (const double[][2]){{10, 10}, {10, 10}});
	assert_way(track, 2.5, 2, (const double[][2]){{10, 10}, {25, 30}});
	assert_way(track, 7, 3, (const double[][2]){{10, 10}, {40, 50}, {40, 30}});
	assert_way(track, 100, 3, (const double[][2]){{10, 10}, {40, 50}, {40, 10}});
	motion_track_destroy(track);
	path.loop = true; /* 120 m: 12 s */
	track = track_of(&path, points);
	assert_way(track, 10, 4, (const double[][2]){{10, 10}, {40, 50}, {40, 10}, {30, 10}});
	assert_way(track, 1e9, 4, (const double[][2]){{10, 10}, {40, 50}, {40, 10}, {10, 10}});
	motion_track_destroy(track);
	path.loop = false;
	path.timed = true;
	track = track_of(&path, points);
	assert_way(track, 0.5, 2, (const double[][2]){{10, 10}, {10, 10}});
	assert_way(track, 3, 2, (const double[][2]){{10, 10}, {25, 30}});
	assert_way(track, 5.5, 3, (const double[][2]){{10, 10}, {40, 50}, {40, 30}});
	assert_way(track, 6, 3, (const double[][2]){{10, 10}, {40, 50}, {40, 10}});
	motion_track_destroy(track);
}

TEST_PROGRAM(track)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(stations_are_one_post_apart_and_the_last_is_the_end),
		cmocka_unit_test(a_path_is_the_same_to_the_bit_wherever_it_lies),
		cmocka_unit_test(a_loop_returns_to_its_start_for_ever),
		cmocka_unit_test(a_timed_path_keeps_its_times_and_turns_the_short_way),
		cmocka_unit_test(an_attitude_turns_a_body_against_its_way),
		cmocka_unit_test(a_timed_path_that_stands_still_is_there_from_when_it_came),
		cmocka_unit_test(without_yaws_a_timed_path_looks_the_way_it_goes),
		cmocka_unit_test(a_single_point_is_one_station),
		cmocka_unit_test(where_a_path_leaves_is_found),
		cmocka_unit_test(the_most_samples_of_an_interval_are_known),
		cmocka_unit_test(a_way_has_its_corners_and_ends_where_the_object_is),
	};
	return cmocka_run_group_tests_name("track", tests, NULL, NULL);
}
