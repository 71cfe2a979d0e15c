/*
 * Ground that is as steep as ground can be, in whole drives through four slots: what slides comes to rest, nothing is
 * lost on the way, and whether everything is resident does not show. And soils at the limits of what they may be.
 */
#include "hard.h"
#include "../support/program.h"

static const char *const few[] = {"cache.slots=4", "cache.loaders=1", "cache.prefetch=0", NULL};
static const char *const all[] = {"cache.slots=512", NULL};

/* A tower of 1,000 m on one post, and a cliff of as much: what they are made of is not loose. */
static double spike(int64_t x, int64_t y)
{
	return hard_rough(x, y) + (x == 64 && y == 64 ? 1000 : 0);
}

static double cliff(int64_t x, int64_t y)
{
	return hard_rough(x, y) + (x >= 64 ? 1000 : 0);
}

/* At spacing 1 the cliff is one post wide; objects pass along its foot and its brink, over it, and over the spike. */
static const char along[] =
	"time_step: 0.1\nend_time: 12\noutside: skip\nobjects:\n"
	"  - {name: foot, shape: {wheel: {radius: 2, width: 2}}, sink: 0.5, path: {points: [[62.5, 20], [62.5, 110]], speed: 20}}\n"
	"  - {name: brink, shape: {sphere: {radius: 2.5}}, sink: 0.5, path: {points: [[65, 110], [65, 20]], speed: 20}}\n"
	"  - {name: over, shape: {box: {size: [5, 4, 2]}}, sink: 0.3, path: {points: [[40, 64], [90, 64.3]], speed: 12}}\n";

static void a_spike_and_a_cliff_of_1000_m_are_driven_over_through_four_slots(void **state)
{
	const support_height heights[] = {spike, cliff};
	for (int i = 0; i < 2; i++)
		for (size_t m = 0; m < HARD_MODELS; m++) {
			const char *store = support_path("steep.furrow");
			uint64_t hashes[2];
			for (int k = 0; k < 2; k++) {
				support_store(store, hard_world, heights[i]);
				char *json = hard_drive(&hard_models[m], along, store, k == 0 ? few : all);
				assert_true(support_figure(json, "\"quanta\"", "removed") > 0);
				if (hard_models[m].conserves && strcmp(hard_models[m].name, "sheet") != 0) /* a sheet comes to rest as it moves */
					assert_int_equal(support_figure(json, "\"slide\"", "awake"), 0);
				mem_free(json);
				hashes[k] = support_hash(store);
			}
			assert_true(hashes[0] == hashes[1]);
		}
}

/* 32 m between posts: from one to the next the ground falls by 1,000 m. */
static double scarp(int64_t x, int64_t y)
{
	(void)y;
	return x >= 32 ? 1000 : 0;
}

static void a_cliff_of_1000_m_comes_to_rest_at_the_angle_of_repose(void **state)
{
	static const struct hard_model sand = {
		"slippage", "redistribute: {model: slippage, undisturbed: slides, iterations: 8, interval: 0.02}\nsoil: {name: dry_sand, cohesion: 0}\n", true};
	static const struct extent wide = {65, 33, 32, 32};
	const double stands = 32 * tan(28 * M_PI / 180);
	uint64_t hashes[2];
	for (int k = 0; k < 2; k++) {
		const char *store = support_path("scarp.furrow");
		support_store(store, wide, scarp);
		/* What passes by does no more than begin. */
		char *json = hard_drive(&sand, "time_step: 1\nend_time: 60\nobjects:\n"
					"  - {name: by, shape: {sphere: {radius: 1}}, sink: 0.01, path: {points: [[64, 64]], speed: 1}}\n",
					store, k == 0 ? few : all);
		mem_free(json);
		hashes[k] = support_hash(store);
		double *quanta = support_quanta(store, 0, (struct post_rect){0, 16, 65, 17});
		for (int x = 1; x < 65; x++) {
			double rise = scarp(x, 16) - scarp(x - 1, 16) + ldexp(quanta[x] - quanta[x - 1], -OFFSET_BITS);
			assert_true(rise > -1e-5 && rise < 1.01 * stands);
			if (x > 8 && x < 57) /* the talus is 59 posts wide */
				assert_true(rise > 0.97 * stands);
		}
		free(quanta);
	}
	assert_true(hashes[0] == hashes[1]);
}

/* Between posts a metre apart a slope of H is atan(H / d): by Culmann's wedge this clay stands to 2.289 m there. */
#define STANDS 2.289

static double height; /* of a ledge that lies within one block of those that sleep and wake */

static double ledge(int64_t x, int64_t y)
{
	return 20 + (x >= 42 && x <= 54 && y >= 42 && y <= 54 ? height : 0);
}

static void a_cut_with_cohesion_stands_to_the_edge_of_failure_and_slips_above(void **state)
{
	static const struct hard_model clay = {
		"slippage", "redistribute: {model: slippage, undisturbed: slides}\n"
			    "soil: {cohesion: 4140, friction_angle: 13, unit_weight: 16000}\n", true};
	for (int over = 0; over < 2; over++) {
		const char *store = support_path("ledge.furrow");
		height = STANDS + (over ? 0.01 : -0.01);
		support_store(store, hard_world, ledge);
		/* What goes by on top sets nothing off; it only wakes the ground. */
		char *json = hard_drive(&clay, "end_time: 30\nobjects:\n"
					"  - {name: by, shape: {sphere: {radius: 1.2}}, sink: 0.01, path: {points: [[48, 48]], speed: 1}}\n",
					store, few);
		assert_int_equal(support_figure(json, "\"slide\"", "awake"), 0);
		mem_free(json);
		double *quanta = support_quanta(store, 0, (struct post_rect){38, 38, 59, 59});
		int moved = 0, steep = 0;
		for (int y = 1; y < 20; y++)
			for (int x = 1; x < 20; x++) {
				double here = ledge(x + 38, y + 38) + ldexp(quanta[y * 21 + x], -OFFSET_BITS);
				double east = ledge(x + 39, y + 38) + ldexp(quanta[y * 21 + x + 1], -OFFSET_BITS);
				moved += quanta[y * 21 + x] != 0 && abs(x - 10) + abs(y - 10) > 4;
				steep += fabs(here - east) > STANDS + 0.001;
			}
		assert_int_equal(moved > 0, over);
		assert_int_equal(steep, 0);
		free(quanta);
	}
}

/* A bank of 3 m at 60 degrees, askew. No two neighbours differ by as much as stands between two posts. */
static double bank(int64_t x, int64_t y)
{
	return 20 + fmax(0, fmin(3, ((double)x * 0.8 + (double)y * 0.6 - 90) * 0.25 * tan(M_PI / 3)));
}

static void a_bank_falls_alike_in_tiles_of_8_and_64_cells(void **state)
{
	static const struct hard_model sand = {
		"slippage", "redistribute: {model: slippage, undisturbed: slides, iterations: 2}\nsoil: {name: dry_sand}\n", true};
	static const char *const slots[] = {"cache.slots=36", NULL};
	const struct post_rect posts = {0, 0, 129, 129};
	double *quanta[2];
	for (int k = 0; k < 2; k++) {
		const char *store = support_path("bank.furrow");
		support_store(store, (struct extent){129, 129, 0.25, k == 0 ? 8 : 64}, bank);
		char *json = hard_drive(&sand, "time_step: 0.1\nend_time: 4\nobjects:\n"
					"  - {name: foot, shape: {box: {size: [1.5, 1, 1]}}, sink: 0.4, path: {points: [[12, 12], [20, 4]], speed: 4}}\n",
					store, k == 0 ? slots : all);
		mem_free(json);
		quanta[k] = support_quanta(store, 0, posts);
	}
	double low = 0;
	for (int i = 0; i < 129 * 129; i++) {
		assert_true(quanta[0][i] == quanta[1][i]);
		low = i / 129 > 90 ? fmin(low, ldexp(quanta[0][i], -OFFSET_BITS)) : low; /* far from the object */
	}
	assert_true(low < -0.1);
	free(quanta[0]);
	free(quanta[1]);
}

static double flat(int64_t x, int64_t y)
{
	(void)x, (void)y;
	return 20;
}

/* Its rim is within an offset's range, and its middle is not. */
static void what_is_half_within_an_offsets_range_is_half_refused(void **state)
{
	const char *poses = support_path("half.csv");
	support_write(poses, "t,x,y,z\n0,60.04,60.07,-990\n");
	for (size_t m = 0; m < HARD_MODELS; m++) {
		char rest[512];
		const char *store = support_path("half.furrow");
		support_store(store, hard_world, flat);
		snprintf(rest, sizeof rest, "end_time: 0.1\nspacing: 0.5\nobjects:\n"
			 "  - {name: moon, shape: {sphere: {radius: 20}}, path: {file: %s}}\n", poses);
		char *json = hard_drive(&hard_models[m], rest, store, NULL);
		assert_true(support_figure(json, "{", "refused_posts") > 1000);
		assert_true(support_figure(json, "\"quanta\"", "removed") > INT64_C(1000) << OFFSET_BITS);
		mem_free(json);
		double *quanta = support_quanta(store, -1, (struct post_rect){79, 79, 162, 162});
		for (int i = 0; i < 83 * 83; i++)
			assert_true(quanta[i] >= -(double)(1 << 30));
		free(quanta);
	}
}

/* Each alone at an end of what it may be (scene/soil tests what lies beyond). The ground is flat: it stands under any. */
static void soils_at_the_limits_of_their_parameters_leave_numbers(void **state)
{
	static const struct { const char *model, *soil; } limits[] = {
		{"scm", "bekker_n: 1e-9"}, {"scm", "bekker_n: 3"}, {"scm", "bekker_kphi: 1e12"}, {"scm", "bekker_kphi: 0, bekker_kc: 1e-9"},
		{"scm", "bekker_kc: 1e12"}, {"scm", "cohesion: 1e9"}, {"scm", "cohesion: 0"}, {"scm", "friction_angle: 89"},
		{"scm", "friction_angle: 0, repose: 1e-9"}, {"scm", "repose: 89"}, {"scm", "janosi_shear: 1e-9"}, {"scm", "janosi_shear: 10"},
		{"scm", "elastic_stiffness: 1e-3"}, {"scm", "elastic_stiffness: 1e12"}, {"scm", "damping: 1e12"}, {"scm", "damping: 0"},
		{"slippage", "friction_angle: 0, cohesion: 0"}, {"slippage", "friction_angle: 0"}, {"slippage", "friction_angle: 89, cohesion: 0"},
		{"slippage", "cohesion: 1e9"}, {"slippage", "cohesion: 1e-9"}, {"slippage", "unit_weight: 1e-9"}, {"slippage", "unit_weight: 1e6"},
		{"sumner", "theta_out: 1e-9, theta_stop: 1e-9"}, {"sumner", "theta_stop: 90"}, {"sumner", "theta_out: 90, theta_stop: 90, theta_in: 90"},
		{"sumner", "theta_in: 1e-9"}, {"sumner", "roughness: 0.2"}, {"sumner", "roughness: 1e-9"}, {"sumner", "compression: 0"},
		{"sumner", "compression: 1"},
	};
	char store[160];
	snprintf(store, sizeof store, "%s", support_path("limits.furrow"));
	support_store(store, hard_world, flat);
	for (size_t i = 0; i < sizeof limits / sizeof limits[0]; i++) {
		char text[256];
		struct store *opened;
		snprintf(text, sizeof text, "redistribute: {model: %s}\nsoil: {name: dry_sand, %s}\n%s", limits[i].model, limits[i].soil,
			 strcmp(limits[i].model, "scm") == 0 ? "output: {forces: 20}\n" : "");
		const struct hard_model model = {limits[i].model, text, true};
		char *json = hard_drive(&model, strcmp(limits[i].model, "scm") == 0
			? "end_time: 1\nobjects:\n"
			  "  - {name: wheel, shape: {wheel: {radius: 1.5, width: 2}}, load: 8000, slip: 0.4, path: {points: [[40, 40], [48, 42]], speed: 6}}\n"
			  "  - {name: ball, shape: {sphere: {radius: 2}}, sink: 0.4, path: {points: [[60, 40], [66, 42]], speed: 6}}\n"
			: "end_time: 1\nobjects:\n"
			  "  - {name: ball, shape: {sphere: {radius: 2}}, sink: 0.4, path: {points: [[60, 40], [66, 42]], speed: 6}}\n", store, few);
		/* A share of nothing, and all. */
		if (strcmp(limits[i].soil, "compression: 0") == 0)
			assert_int_equal(support_figure(json, "\"quanta\"", "compacted"), 0);
		if (strcmp(limits[i].soil, "compression: 1") == 0)
			assert_int_equal(support_figure(json, "\"quanta\"", "compacted"), support_figure(json, "\"quanta\"", "removed"));
		mem_free(json);
		must(store_open(store, &(struct store_options){.mode = STORE_WRITE}, &opened));
		must(store_reset(opened, true));
		store_close(opened);
	}
}

static void what_is_refused_is_counted_once_however_many_windows_see_it(void **state)
{
	const char *poses = support_path("moon.csv");
	support_write(poses, "t,x,y,z\n0,60.04,60.07,-1500\n");
	long long under = 0;
	for (int y = 0; y <= 128 * 8; y++)
		for (int x = 0; x <= 128 * 8; x++)
			under += hypot(x / 8.0 - 60.04, y / 8.0 - 60.07) < 20;
	for (size_t m = 0; m < HARD_MODELS; m++) {
		char rest[512];
		snprintf(rest, sizeof rest, "end_time: 1\nspacing: 0.125\nobjects:\n"
			 "  - {name: moon, shape: {sphere: {radius: 20}}, path: {file: %s}}\n", poses);
		char *json = hard_drive(&hard_models[m], rest, hard_store("moon.furrow"), NULL);
		assert_int_equal(support_figure(json, "{", "refused_posts"), under);
		mem_free(json);
	}
}

/* Steeper by itself than its soil stands: an object that touches it sets some of it going. */
static double scree(int64_t x, int64_t y)
{
	return 20 + (double)((x * 7 + y * 3) % 11 / 9);
}

static void ground_that_is_too_steep_by_itself_loses_nothing(void **state)
{
	static const struct hard_model models[] = {
		{"slippage", "redistribute: {model: slippage}\nsoil: {name: dry_sand, cohesion: 0}\n", true},
		{"sumner", "redistribute: {model: sumner}\nsoil: {name: sand}\n", true},
	};
	for (int m = 0; m < 2; m++) {
		const char *store = support_path("scree.furrow");
		support_store(store, hard_world, scree);
		mem_free(hard_drive(&models[m], "time_step: 0.05\nend_time: 0.05\nspacing: 0.25\nobjects:\n"
				    "  - {name: a, shape: {wheel: {radius: 0.8, width: 0.7}}, sink: 0.25, path: {points: [[12, 20]], speed: 1}}\n",
				    store, NULL));
	}
}

TEST_PROGRAM(slopes)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_spike_and_a_cliff_of_1000_m_are_driven_over_through_four_slots),
		cmocka_unit_test(a_cliff_of_1000_m_comes_to_rest_at_the_angle_of_repose),
		cmocka_unit_test(a_cut_with_cohesion_stands_to_the_edge_of_failure_and_slips_above),
		cmocka_unit_test(a_bank_falls_alike_in_tiles_of_8_and_64_cells),
		cmocka_unit_test(what_is_refused_is_counted_once_however_many_windows_see_it),
		cmocka_unit_test(what_is_half_within_an_offsets_range_is_half_refused),
		cmocka_unit_test(ground_that_is_too_steep_by_itself_loses_nothing),
		cmocka_unit_test(soils_at_the_limits_of_their_parameters_leave_numbers),
	};
	return cmocka_run_group_tests_name("hard slopes", tests, support_enter, support_leave);
}
