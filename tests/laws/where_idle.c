/* Law 7: what nothing touches costs nothing. A body that never comes down, settled soil, and effects that the scene does not name
 * run no pass. */
#include "where.h"
#include "../support/program.h"

static void what_never_comes_down_costs_nothing(void **state)
{
	static const char rest[] = "end_time: 4\nspacing: 0.25\nobjects:\n"
				   "  - {name: fly, shape: {sphere: {radius: 1}}, path: {file: fly.csv}}\n%s";
	static const char view[] = "view: {size: [64, 48], camera: {overhead: {over: fly, height: 60}}, effects: [texture], images: 1}\n";
	for (int m = 0; m < MODELS; m++) {
		char text[512];
		const char *windows = slides(m) ? models[m] : "displace";
		long long programs[2];
		for (int down = 0; down < 2; down++) {
			write_poses("fly.csv", &(struct hops){smooth, 2, 40, 61, 20, 0.3, 1, down ? 0.3 : -1, 2, 1, 4, false});
			snprintf(text, sizeof text, rest, view);
			const char *store = support_path("fly.furrow"), *scene = scene_of("fly.yaml", m, text);
			support_store(store, extent, smooth);
			uint64_t before = support_hash(store);
			char *json = drive(scene, store, "out", false, false, 0);
			programs[down] = support_figure(json, "\"programs\"", "programs");
			assert_int_equal(support_hash(store) != before, down);
			/* Bearing soil is computed on the CPU: it runs no pass. */
			const bool passes = down && m < 4;
			assert_int_equal(support_figure(json, "\"passes\"", "displace") > 0, passes);
			assert_int_equal(support_figure(json, "\"passes\"", "redistribute") > 0, passes && m > 0);
			assert_int_equal(support_figure(json, "\"passes\"", "attributes") > 0, passes && m == 1);
			assert_int_equal(support_figure(json, "\"passes\"", "pyramid") > 0, passes);
			assert_int_equal(support_figure(json, "\"io\"", "tiles_written") > 0, down);
			/* An untouched tile has no planes, and none of its draws reads one. */
			assert_int_equal(where(json, "slots", "visited") > 0, down);
			assert_int_equal(where(json, "draw", "visited") > 0, down);
			assert_int_equal(where(json, "pyramid", "visited") > 0, down);
			assert_true(where(json, "draw", "possible") > where(json, "draw", "visited"));
			assert_true(where(json, "slots", "possible") > where(json, "slots", "visited"));
			assert_true(where(json, "pyramid", "possible") > where(json, "pyramid", "visited"));
			assert_true(where(json, windows, "possible") > 100);
			assert_int_equal(where(json, windows, "visited") > 0, down);
			if (m == 1)
				assert_int_equal(where(json, "box", "visited") > 0, down);
			if (m == 1 || m == 4)
				assert_int_equal(where(json, "dirt", "visited"), where(json, windows, "visited"));
			if (slides(m))
				assert_int_equal(where(json, "spread", "visited"), where(json, windows, "visited"));
			if (slides(m))
				assert_int_equal(where(json, m == 2 ? "shed" : "slide", "visited"), support_figure(json, "\"slide\"", "visited"));
			mem_free(json);
		}
		assert_int_equal(programs[0], programs[1]); /* made beforehand: where it comes down only the drive shows */
	}
}

/* Only what the scene calls for is named. */
static void no_other_effect_is_told(void **state)
{
	static const char rest[] = "end_time: 1\nobjects:\n"
				   "  - {name: a, shape: {sphere: {radius: 1.5}}, sink: 0.3, path: {points: [[20, 20], [30, 30]], speed: 10}}\n";
	static const char *const told[] = {"displace", "box", "sumner", "slippage", "scm", "spread", "shed", "slide", "dirt", "pyramid",
					   "draw", "slots", "sheet"};
	static const bool wanted[SHEET + 1][13] = {
		{true, false, false, false, false, false, false, false, false, false, false, true},
		{true, true, false, false, false, false, false, false, true, false, false, true},
		{false, false, true, false, false, true, true, false, false, false, false, true},
		{false, false, false, true, false, true, false, true, false, false, false, true},
		{false, false, false, false, true, true, false, true, true, false, false, true},
		{false, false, false, false, false, false, false, false, false, false, false, true, true},
	};
	for (int m = 0; m <= SHEET; m++) {
		const char *store = support_path("told.furrow");
		support_store(store, extent, smooth);
		char *json = drive(scene_of("told.yaml", m, rest), store, "out", false, false, 0), *from = strstr(json, "\"where\"");
		strstr(from, "}\n\t}")[0] = '\0';
		for (int i = 0; i < 13; i++) {
			char quoted[32];
			snprintf(quoted, sizeof quoted, "\"%s\"", told[i]);
			assert_int_equal(strstr(from, quoted) != NULL, wanted[m][i]);
		}
		mem_free(json);
	}
}

static void settled_soil_is_not_relaxed(void **state)
{
	for (int m = 2; m < MODELS; m++) {
		long long visited[2];
		bool repeats = false;
		for (int i = 0; i < 2; i++) {
			char rest[256];
			snprintf(rest, sizeof rest, "end_time: %d\nspacing: 0.5\nobjects:\n"
				 "  - {name: a, shape: {sphere: {radius: 3}}, sink: %g, path: {points: [[50, 50], [60, 52]], speed: 10}}\n",
				 30 << i, m == 2 ? 2.5 : 1.0); /* sumner loses most of what it displaces, so its rims are low */
			const char *store = support_path("settled.furrow");
			support_store(store, extent, flat);
			char *json = drive(scene_of("settled.yaml", m, rest), store, "out", false, false, 0);
			visited[i] = where(json, m == 2 ? "shed" : "slide", "visited");
			assert_int_equal(support_figure(json, "\"slide\"", "awake"), 0);
			repeats = support_counts_repeat(json);
			mem_free(json);
		}
		assert_true(visited[0] > 0 && llabs(visited[1] - visited[0]) <= (repeats ? 0 : visited[0] / 20));
	}
}

/* A tolerance ends slides sooner, loses nothing, and is no tolerance at 0. */
static void what_is_tolerated_sleeps_sooner(void **state)
{
	static const char *const tolerances[] = {"0", "0.001", "0.01"};
	for (int m = 3; m < MODELS; m++) {
		long long visited[3];
		uint64_t hashes[3];
		for (int i = 0; i < 3; i++) {
			char rest[512];
			snprintf(rest, sizeof rest, "scene: 1\ntime_step: 0.1\nend_time: 10\nspacing: 0.125\nsoil: {name: dry_sand, cohesion: 0}\n"
				 "redistribute: {model: %s, tolerance: %s}\nobjects:\n"
				 "  - {name: a, shape: {sphere: {radius: 1.5}}, sink: 0.5, path: {points: [[50, 50], [70, 58]], speed: 5}}\n",
				 models[m], tolerances[i]);
			const char *store = support_path("tolerated.furrow"), *scene = support_path("tolerated.yaml");
			support_write(scene, rest);
			support_store(store, extent, flat);
			char *json = drive(scene, store, "out", false, false, 0);
			visited[i] = where(json, "slide", "visited");
			hashes[i] = support_hash(store);
			assert_true(support_figure(json, "\"quanta\"", "net") == -support_figure(json, "\"quanta\"", "compacted"));
			support_verify(store);
			mem_free(json);
		}
		assert_true(visited[0] > visited[1] && visited[1] > visited[2]);
		assert_true(hashes[0] != hashes[1] && hashes[1] != hashes[2]);
	}
}

TEST_PROGRAM(where_idle)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_never_comes_down_costs_nothing),
		cmocka_unit_test(no_other_effect_is_told),
		cmocka_unit_test(settled_soil_is_not_relaxed),
		cmocka_unit_test(what_is_tolerated_sleeps_sooner),
	};
	return cmocka_run_group_tests_name("where", tests, support_enter, support_leave);
}
