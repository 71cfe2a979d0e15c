/*
 * What the prefetcher brings: objects are led over their tracks as a drive leads them, and the ground's waits counted.
 * Where a test waits for the prefetcher after each step there must be none.
 */
#include "../support.h"
#include "../support/program.h"

#include "damage.h"
#include "motion/motion.h"
#include "resident/prefetcher.h"

/* 32 x 32 tiles of 32 m. */
static const struct extent extent = {1025, 1025, 1, 32};
static const double post = 0.25;
static const char *store_path;

enum { MOST = 12 };

struct party {
	struct store *store;
	struct ground *ground;
	struct prefetcher *prefetcher;
	struct track *tracks[MOST];
	size_t count;
	int64_t next[MOST];
	uint64_t unread; /* heights that could not be had */
	unsigned threads; /* 0: by the number of objects */
};

static struct track *track_of(struct scene_path path, const double (*points)[2])
{
	struct scene_waypoint waypoints[8] = {{0}};
	struct track *track;
	if (path.points == NULL)
		path.points = waypoints;
	for (size_t i = 0; i < path.count; i++) {
		path.points[i].x = points[i][0];
		path.points[i].y = points[i][1];
	}
	must(motion_track_create(&path, post, 1, &track));
	return track;
}

static void party_open(struct party *party, uint32_t tiles)
{
	*party = (struct party){.count = 0};
	must(store_open(store_path, &(struct store_options){.mode = STORE_READ}, &party->store));
	must(resident_ground_create(party->store, tiles, &party->ground));
}

static void party_join(struct party *party, struct track *track)
{
	party->tracks[party->count++] = track;
}

static void list_bodies(const struct party *party, struct look_ahead_body bodies[MOST])
{
	for (size_t i = 0; i < party->count; i++)
		bodies[i] = (struct look_ahead_body){.path = motion_track_ahead(party->tracks[i])};
}

/* As a drive has it: a quarter of the ground is not the prefetcher's. */
static void party_scout(struct party *party, uint32_t tiles, double prefetch, double end)
{
	struct look_ahead_body bodies[MOST];
	list_bodies(party, bodies);
	const struct look_ahead_params params = {
		.store = party->store,
		.ground = party->ground,
		.tiles = tiles - tiles / 4,
		.bodies = bodies,
		.count = party->count,
		.spacing = post,
		.prefetch = prefetch,
		.end = end,
		.threads = party->threads,
	};
	must(resident_prefetcher_create(&params, &party->prefetcher));
}

static void party_close(struct party *party)
{
	resident_prefetcher_destroy(party->prefetcher);
	for (size_t i = 0; i < party->count; i++)
		motion_track_destroy(party->tracks[i]);
	resident_ground_destroy(party->ground);
	store_close(party->store);
}

static uint64_t waits(const struct party *party)
{
	struct resident_ground_figures figures;
	resident_ground_figures(party->ground, &figures);
	return figures.waits;
}

static uint64_t reads(const struct party *party)
{
	struct resident_ground_figures figures;
	resident_ground_figures(party->ground, &figures);
	return figures.reads;
}

/* A height, checked against the posts it comes from. */
static void stand(struct party *party, const struct track_point *point)
{
	int64_t height;
	bool any;
	if (resident_ground_height(party->ground, point->qx, point->qy, &height, &any) != STATUS_OK) {
		party->unread++;
		return;
	}
	assert_int_equal(any, point->x >= 0 && point->x <= 1024 && point->y >= 0 && point->y <= 1024);
	if (!any)
		return;
	int64_t cx = (int64_t)fmin(point->x, 1023), cy = (int64_t)fmin(point->y, 1023);
	double u = point->x - (double)cx, v = point->y - (double)cy, expected = 0;
	for (int k = 0; k < 4; k++)
		expected += round(support_hills(cx + k % 2, cy + k / 2) * 1024) / 1024 * (k % 2 ? u : 1 - u) * (k / 2 ? v : 1 - v);
	assert_true(fabs(lattice_offset_metres(height) - expected) < 1e-5);
}

/* One step: the stations due until `until`, then word of it. */
static void step(struct party *party, double until, bool wait)
{
	for (size_t i = 0; i < party->count; i++)
		for (struct track_point point; party->next[i] < motion_track_samples(party->tracks[i]); party->next[i]++) {
			if (motion_track_sample_time(party->tracks[i], party->next[i]) > until)
				break;
			motion_track_sample(party->tracks[i], party->next[i], &point);
			stand(party, &point);
		}
	if (party->prefetcher == NULL)
		return;
	resident_prefetcher_tell(party->prefetcher, until);
	if (wait)
		resident_prefetcher_wait(party->prefetcher);
}

/* Leads them all until `end`; returns the waits. */
static uint64_t lead(struct party *party, double dt, double end)
{
	if (party->prefetcher != NULL)
		resident_prefetcher_wait(party->prefetcher);
	for (int64_t i = 1; (double)(i - 1) * dt < end; i++)
		step(party, fmin((double)i * dt, end), true);
	return waits(party);
}

static struct track *diagonal(double speed)
{
	/* Through tile corners, along an edge and back across the edges. */
	static const double points[][2] = {{10, 10}, {1010, 1010}, {1010, 320}, {20, 320}, {30, 990}, {31, 20}};
	return track_of((struct scene_path){.count = 6, .speed = speed}, points);
}

static void no_step_reads_what_the_scout_could_bring(void **state)
{
	const double prefetches[] = {0.2, 1.5, 100, 3600};
	struct party party;
	party_open(&party, 16);
	party_join(&party, diagonal(40));
	assert_true(lead(&party, 0.05, 120) > 100); /* by itself */
	party_close(&party);
	for (int i = 0; i < 4; i++) {
		party_open(&party, 16);
		party_join(&party, diagonal(40));
		party_scout(&party, 16, prefetches[i], 120);
		assert_int_equal(lead(&party, 0.05, 120), 0);
		party_close(&party);
	}
	/* With hardly any room, and in long steps: never so far ahead that what is needed sooner goes. */
	party_open(&party, 6);
	party_join(&party, diagonal(40));
	party_scout(&party, 6, 3600, 120);
	assert_int_equal(lead(&party, 0.4, 120), 0);
	party_close(&party);
}

static void corners_that_are_cut_are_not_missed(void **state)
{
	/* Just beside the diagonals, half a metre of a third tile at each corner. */
	const double points[][2] = {{10.3, 10}, {1010.3, 1010}, {1010, 14.3}, {14, 1010.3}, {20, 700}, {700, 20.4}};
	struct party party;
	party_open(&party, 24);
	party_join(&party, track_of((struct scene_path){.count = 6, .speed = 40}, points));
	party_scout(&party, 24, 1.5, 130);
	assert_int_equal(lead(&party, 0.05, 130), 0);
	party_close(&party);
}

/* Four tiles under a loop, and the 26 of a line that passes on. */
static void nothing_is_read_twice_without_need(void **state)
{
	const double near[][2] = {{20, 20}, {40, 20}, {40, 40}, {20, 40}}, line[][2] = {{200, 16}, {1000, 16}};
	struct party party;
	party_open(&party, 16);
	party_join(&party, track_of((struct scene_path){.count = 4, .speed = 5, .loop = true}, near));
	party_join(&party, track_of((struct scene_path){.count = 2, .speed = 20}, line));
	party_scout(&party, 16, 8, 40);
	assert_int_equal(lead(&party, 0.1, 40), 0);
	assert_int_equal(reads(&party), 4 + 26);
	party_close(&party);
}

static void what_the_owner_reads_for_itself_costs_no_more_than_it_pushed_out(void **state)
{
	const double points[][2] = {{48, 48}, {144, 48}, {144, 112}, {48, 112}}; /* ten tiles */
	struct party party;
	party_open(&party, 16);
	party_join(&party, track_of((struct scene_path){.count = 4, .speed = 40, .loop = true}, points));
	party_scout(&party, 16, 9, 100);
	assert_int_equal(lead(&party, 0.1, 20), 0);
	assert_int_equal(reads(&party), 10);
	for (int i = 0; i < 10; i++) {
		struct track_point point = {.x = 650 + 32 * i, .y = 650};
		point.qx = lattice_offset(point.x);
		point.qy = lattice_offset(point.y);
		stand(&party, &point);
	}
	assert_int_equal(reads(&party), 20);
	resident_prefetcher_tell(party.prefetcher, 22);
	resident_prefetcher_wait(party.prefetcher);
	assert_int_equal(reads(&party), 20 + 4);
	party_close(&party);
}

/* A drive faster than real time has it look farther. */
static void it_looks_as_far_as_it_is_told(void **state)
{
	const double points[][2] = {{48, 48}, {976, 48}}; /* a tile each 1.6 s */
	struct party party;
	party_open(&party, 64);
	party_join(&party, track_of((struct scene_path){.count = 2, .speed = 20}, points));
	party_scout(&party, 48, 2, 100);
	resident_prefetcher_wait(party.prefetcher);
	uint64_t before = reads(&party);
	assert_in_range(before, 1, 4);
	resident_prefetcher_reach(party.prefetcher, 32);
	resident_prefetcher_tell(party.prefetcher, 2);
	resident_prefetcher_wait(party.prefetcher);
	assert_in_range(reads(&party), before + 18, before + 23);
	party_close(&party);
}

static void many_objects_share_a_small_ground(void **state)
{
	static const unsigned threads[] = {1, 2, 3, 8};
	for (int k = 0; k < 4; k++) {
		struct party party;
		party_open(&party, 48);
		party.threads = threads[k];
		for (int i = 0; i < 8; i++) {
			const double points[][2] = {{20 + 100 * i, 16}, {110 + 90 * i, 1000}, {1000 - 80 * i, 40}};
			party_join(&party, track_of((struct scene_path){.count = 3, .speed = 5 + 3 * i}, points));
		}
		party_scout(&party, threads[k] == 1 ? 32 : 48, 100, 60);
		assert_int_equal(lead(&party, 0.1, 60), 0);
		party_close(&party);
	}
}

static void a_loop_is_followed_round_and_round(void **state)
{
	const double points[][2] = {{30, 30}, {200, 40}, {180, 170}};
	for (int small = 0; small < 2; small++) {
		struct party party;
		party_open(&party, small ? 8 : 64);
		party_join(&party, track_of((struct scene_path){.count = 3, .speed = 30, .loop = true}, points));
		party_scout(&party, small ? 8 : 64, 2, 100);
		assert_int_equal(lead(&party, 0.1, 100), 0);
		assert_true(party.next[0] > 5 * 500 / 0.25);
		party_close(&party);
	}
}

static void a_timed_path_is_followed_through_its_rests_and_leaps(void **state)
{
	/* It begins late, rests, leaps 700 m within 0.1 s, and turns where it stands. */
	struct scene_waypoint waypoints[] = {{.t = 3}, {.t = 5}, {.t = 20}, {.t = 20.1}, {.t = 25, .yaw = 3}, {.t = 40}};
	const double points[][2] = {{100, 100}, {180, 120}, {180, 120}, {700, 600}, {700, 600}, {900, 100}};
	for (int attitude = 0; attitude < 2; attitude++) {
		struct party party;
		party_open(&party, 48);
		struct scene_path path = {.points = waypoints, .count = 6, .timed = true, .has_attitude = attitude};
		party_join(&party, track_of(path, points));
		party_scout(&party, 48, 1, 45);
		assert_int_equal(lead(&party, 0.05, 45), 0);
		assert_int_equal(party.next[0], motion_track_samples(party.tracks[0]));
		party_close(&party);
	}
}

static void paths_may_leave_the_world_and_touch_its_last_posts(void **state)
{
	const double points[][2] = {{-300, 500}, {500, 500}, {1024, 1024}, {1024, 600}, {1100, -50}, {600, 0}, {0, 0}, {0, 1024}};
	struct party party;
	party_open(&party, 16);
	party_join(&party, track_of((struct scene_path){.count = 8, .speed = 35}, points));
	const double away[][2] = {{-1e6, 4e5}, {5e6, 4e5}};
	party_join(&party, track_of((struct scene_path){.count = 2, .speed = 50}, away));
	party_scout(&party, 16, 2, 150);
	assert_int_equal(lead(&party, 0.1, 150), 0);
	party_close(&party);
}

/* As a chase: 60 m behind on the track, and where the object is. */
static size_t camera(const void *user, double time, double places[2][2])
{
	const struct party *party = user;
	struct track_point point;
	for (int i = 0; i < 2; i++) {
		motion_track_at(party->tracks[0], time - 2 * i, &point);
		places[i][0] = point.x;
		places[i][1] = point.y + 70 * i;
	}
	return 2;
}

static void the_camera_finds_its_ground_too(void **state)
{
	for (int told = 0; told < 2; told++) {
		struct party party;
		party_open(&party, 32);
		party_join(&party, diagonal(30));
		struct look_ahead_body bodies[MOST];
		list_bodies(&party, bodies);
		const struct look_ahead_params params = {
			.store = party.store,
			.ground = party.ground,
			.tiles = 24,
			.bodies = bodies,
			.count = 1,
			.spacing = post,
			.camera = told ? camera : NULL,
			.camera_user = &party,
			.camera_speed = 30,
			.prefetch = 1.5,
			.end = 100,
		};
		must(resident_prefetcher_create(&params, &party.prefetcher));
		resident_prefetcher_wait(party.prefetcher);
		for (int i = 1; i <= 1000; i++) {
			double places[2][2];
			step(&party, i * 0.1, true);
			camera(&party, i * 0.1, places);
			for (int k = 0; k < 2; k++) {
				struct track_point point = {.qx = lattice_offset(places[k][0]), .qy = lattice_offset(places[k][1]),
							    .x = places[k][0], .y = places[k][1]};
				point.x = lattice_offset_metres(point.qx);
				point.y = lattice_offset_metres(point.qy);
				stand(&party, &point);
			}
		}
		assert_int_equal(waits(&party) == 0, told);
		party_close(&party);
	}
}

static void a_tile_that_cannot_be_read_is_left_to_who_needs_it(void **state)
{
	const char *path = store_path;
	store_path = support_path("damaged.furrow");
	support_store(store_path, extent, support_hills);
	damage(store_path, (struct tile){0, 5, 5});
	struct party party;
	party_open(&party, 16);
	party_join(&party, diagonal(40));
	party_scout(&party, 16, 3, 20);
	assert_int_equal(lead(&party, 0.05, 20), 0); /* all others were brought */
	assert_true(party.unread > 100);
	assert_false(resident_ground_touch(party.ground, (struct tile){0, 5, 5}));
	party_close(&party);
	store_path = path;
}

static void it_goes_on_beside_an_owner_who_does_not_wait(void **state)
{
	for (uint32_t tiles = 2; tiles <= 32; tiles *= 4) {
		struct party party;
		party_open(&party, tiles);
		party.threads = tiles == 2 ? 1 : 2;
		party_join(&party, diagonal(40));
		party_join(&party, diagonal(90));
		party_scout(&party, tiles, 5, 100);
		for (int i = 1; i <= 400; i++)
			step(&party, i * 0.25, false);
		resident_prefetcher_wait(party.prefetcher);
		party_close(&party);
	}
}

static void it_stops_wherever_it_is(void **state)
{
	for (int i = 0; i < 30; i++) {
		struct party party;
		party_open(&party, 64);
		party.threads = 1 + (unsigned)i % 2;
		party_join(&party, diagonal(40));
		party_join(&party, diagonal(33));
		party_scout(&party, 64, 3600, 3600);
		if (i % 3 > 0)
			step(&party, i, i % 3 == 2);
		party_close(&party);
	}
}

static void what_cannot_be_had_is_said(void **state)
{
	struct party party;
	party_open(&party, 4);
	party_join(&party, diagonal(40));
	party_join(&party, diagonal(33));
	struct look_ahead_body bodies[MOST];
	list_bodies(&party, bodies);
	const struct look_ahead_params params = {.store = party.store, .ground = party.ground, .tiles = 3, .count = 2, .threads = 2, .spacing = post,
						 .bodies = bodies, .prefetch = 1, .end = 10};
	for (uint64_t nth = 1;; nth++) {
		struct prefetcher *prefetcher = NULL;
		mem_fail_nth(nth, 0);
		enum status status = resident_prefetcher_create(&params, &prefetcher);
		mem_fail_nth(0, 0);
		if (status == STATUS_OK) {
			assert_true(nth > 3);
			resident_prefetcher_destroy(prefetcher);
			break;
		}
		assert_int_equal(status, STATUS_FAILED);
		assert_null(prefetcher);
	}
	resident_prefetcher_destroy(NULL);
	party_close(&party);
}

/* --- whole drives --- */

static void no_prefetch_shows_in_what_a_drive_leaves(void **state)
{
	static const char scene_text[] = "scene: 1\ntime_step: 0.1\nend_time: 12\nspacing: 0.5\nobjects:\n"
					 "  - {name: a, shape: {wheel: {radius: 0.9, width: 0.7}}, sink: 0.2,\n"
					 "     path: {points: [[20, 20], [400, 380]], speed: 40}}\n"
					 "  - {name: b, shape: {sphere: {radius: 1.5}}, sink: 0.5,\n"
					 "     path: {points: [[64, 300], [64, 100], [300, 96]], speed: 25, loop: true}}\n";
	const char *scene = support_path("scene.yaml");
	support_write(scene, scene_text);
	const char *const settings[] = {"cache.prefetch=0", "cache.prefetch=1.5", "cache.prefetch=100"};
	const struct extent small = {513, 513, 1, 32};
	uint64_t first = 0;
	for (int i = 0; i < 3; i++) {
		const char *path = support_path("drive.furrow");
		support_store(path, small, support_hills);
		char *json = support_drive(scene, path, (const char *[]){settings[i], "cache.slots=256", NULL});
		/* Every new tile under an object is waited for where nobody goes ahead. */
		if (i == 0)
			assert_true(support_figure(json, "\"cache\"", "stalls") > support_figure(json, "\"cache\"", "misses"));
		mem_free(json);
		uint64_t hash = support_hash(path);
		first = i == 0 ? hash : first;
		assert_true(hash == first);
	}
}

static int enter(void **state)
{
	if (support_enter(state) != 0)
		return 1;
	store_path = support_path("scout.furrow");
	support_store(store_path, extent, support_hills);
	return 0;
}

TEST_PROGRAM(prefetcher)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(no_step_reads_what_the_scout_could_bring),
		cmocka_unit_test(corners_that_are_cut_are_not_missed),
		cmocka_unit_test(nothing_is_read_twice_without_need),
		cmocka_unit_test(what_the_owner_reads_for_itself_costs_no_more_than_it_pushed_out),
		cmocka_unit_test(it_looks_as_far_as_it_is_told),
		cmocka_unit_test(many_objects_share_a_small_ground),
		cmocka_unit_test(a_loop_is_followed_round_and_round),
		cmocka_unit_test(a_timed_path_is_followed_through_its_rests_and_leaps),
		cmocka_unit_test(paths_may_leave_the_world_and_touch_its_last_posts),
		cmocka_unit_test(the_camera_finds_its_ground_too),
		cmocka_unit_test(a_tile_that_cannot_be_read_is_left_to_who_needs_it),
		cmocka_unit_test(it_goes_on_beside_an_owner_who_does_not_wait),
		cmocka_unit_test(it_stops_wherever_it_is),
		cmocka_unit_test(what_cannot_be_had_is_said),
		cmocka_unit_test(no_prefetch_shows_in_what_a_drive_leaves),
	};
	return cmocka_run_group_tests_name("scout", tests, enter, support_leave);
}
