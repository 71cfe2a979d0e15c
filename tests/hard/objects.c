/* Objects that are too small, too large, too fast, in the wrong place or in each other's way, under every model. */
#include "../long.h"
#include "../support/near.h"
#include "hard.h"
#include "../support/program.h"

/* Every other model in turn. */
#define EACH_MODEL(model) \
	for (const struct hard_model *model = hard_models; model < hard_models + HARD_MODELS; model++) \
		if (by_turn((size_t)(model - hard_models), 2))

/* --- what a drive changed --- */

struct changes {
	size_t lowered, raised;     /* posts */
	double low, high;           /* metres: the lowest and the highest offset */
	struct post_rect under;     /* around all posts that were lowered */
	struct post_rect all;       /* around all posts that were changed */
};

static void around(struct post_rect *rect, int64_t x, int64_t y)
{
	bool first = rect->x1 == 0;
	rect->x0 = first || x < rect->x0 ? x : rect->x0;
	rect->y0 = first || y < rect->y0 ? y : rect->y0;
	rect->x1 = first || x >= rect->x1 ? x + 1 : rect->x1;
	rect->y1 = first || y >= rect->y1 ? y + 1 : rect->y1;
}

/* Of the posts of `rect` at this level. */
static struct changes changes_of(const char *store, int level, struct post_rect rect)
{
	struct changes changes = {0};
	double *quanta = support_quanta(store, level, rect);
	int64_t width = rect.x1 - rect.x0;
	for (int64_t i = 0; i < width * (rect.y1 - rect.y0); i++) {
		double metres = quanta[i] / (1 << OFFSET_BITS);
		if (isnan(metres) || metres == 0)
			continue;
		changes.lowered += metres < 0;
		changes.raised += metres > 0;
		changes.low = support_least(changes.low, metres);
		changes.high = support_most(changes.high, metres);
		around(&changes.all, rect.x0 + i % width, rect.y0 + i / width);
		if (metres < 0)
			around(&changes.under, rect.x0 + i % width, rect.y0 + i / width);
	}
	free(quanta);
	return changes;
}

/* Whether `inner` lies in `outer`, made larger by so many posts. */
static bool lies_in(struct post_rect inner, struct post_rect outer, int64_t more)
{
	return inner.x0 >= outer.x0 - more && inner.y0 >= outer.y0 - more && inner.x1 <= outer.x1 + more && inner.y1 <= outer.y1 + more;
}

static bool is_box(const struct hard_model *model)
{
	return strcmp(model->name, "box") == 0;
}

static bool is_sumner(const struct hard_model *model)
{
	return strcmp(model->name, "sumner") == 0;
}

/* Its ground bends beside what presses it. */
static bool bends(const struct hard_model *model)
{
	return strcmp(model->name, "sheet") == 0;
}

/* --- too small, too large, in the wrong place --- */

/* One that stands on a post, one that moves over three, and one between posts. */
static void an_object_smaller_than_a_post_presses_one_at_most(void **state)
{
	static const struct post_rect way = {40, 40, 43, 41};
	EACH_MODEL(model) {
		const char *store = hard_store("tiny.furrow");
		char *json = hard_drive(model, "end_time: 2\nobjects:\n"
				"  - {name: on, shape: {sphere: {radius: 0.01}}, sink: 0.01, path: {points: [[40, 40], [42, 40]], speed: 1}}\n"
				"  - {name: stands, shape: {sphere: {radius: 0.01}}, sink: 0.01, path: {points: [[80, 80]], speed: 1}}\n"
				"  - {name: off, shape: {sphere: {radius: 0.01}}, sink: 0.01, path: {points: [[60.5, 60.5]], speed: 1}}\n",
				store, NULL);
		struct changes one = changes_of(store, 0, (struct post_rect){70, 70, 90, 90});
		if (bends(model)) { /* and comes back behind what moves */
			struct changes end = changes_of(store, 0, (struct post_rect){30, 30, 50, 50});
			assert_true(one.low < -0.009 && one.low > -0.011 && lies_in(one.all, (struct post_rect){80, 80, 81, 81}, 3));
			assert_true(end.low < -0.009 && end.low > -0.011 && lies_in(end.all, (struct post_rect){42, 40, 43, 41}, 3));
			mem_free(json);
			continue;
		}
		assert_int_equal(one.lowered, 1);
		assert_true(one.under.x0 == 80 && one.under.y0 == 80 && one.low < -0.009 && one.low > -0.011);
		assert_true(model->conserves || one.raised == 0);
		/* Another at each step of its way. Smoothing reaches one post farther; what was pressed aside two, a band's least width. */
		struct changes three = changes_of(store, 0, (struct post_rect){30, 30, 50, 50});
		assert_true(is_box(model) ? three.lowered >= 3 : three.lowered == 3);
		assert_true(lies_in(three.under, way, is_box(model)) && lies_in(three.all, way, model->conserves ? 2 : is_box(model)));
		assert_true(model->conserves || three.raised == 0);
		/* Between posts nothing is under it. */
		struct changes none = changes_of(store, 0, (struct post_rect){56, 56, 66, 66});
		assert_true(none.lowered == 0 && none.raised == 0);
		mem_free(json);
	}
}

/* Windows that were due along a path of two or three posts. */
static long long windows_of(const struct hard_model *model, const char *store, const char *shape, const char *path)
{
	char rest[256];
	snprintf(rest, sizeof rest, "end_time: 2\nspacing: 0.125\nobjects:\n  - {name: it, shape: {%s}, sink: 0.2, path: {points: %s, speed: 1}}\n",
		 shape, path);
	char *json = hard_drive(model, rest, store, NULL);
	long long due = support_figure(json, "\"where\"", "possible"); /* the first is of windows */
	assert_true(support_figure(json, "\"quanta\"", "removed") > 0);
	mem_free(json);
	return due;
}

/* A small object is worked on in one window for each post of its path. So is a large one where soil goes from post to post: its window
 * is gathered in parts. */
static void an_object_larger_than_a_window_is_worked_on_in_several(void **state)
{
	static const struct {
		const char *shape, *path;
	} large[] = {
		{"sphere: {radius: 20}", "[[50, 60], [50.5, 60.25]]"},
		{"box: {size: [40, 34, 2]}", "[[80, 70], [80.25, 70]]"},
	};
	const struct post_rect world = {0, 0, 1025, 1025};
	EACH_MODEL(model)
		for (int i = 0; i < 2; i++) {
			const char *store = hard_store("huge.furrow");
			long long small = windows_of(model, store, "sphere: {radius: 0.6}", large[i].path);
			store = hard_store("huge.furrow");
			long long all = windows_of(model, store, large[i].shape, large[i].path);
			assert_true(small >= 3 && (model->conserves ? all == small : all % small == 0 && all / small >= 4));
			/* A plate presses more posts from west to east than a window has. */
			struct post_rect under = changes_of(store, -3, world).under;
			assert_true(i == 0 || (under.x1 - under.x0 > 256 && under.y1 - under.y0 > 256));
		}
}

static void outside_the_world_nothing_happens_and_it_is_counted(void **state)
{
	EACH_MODEL(model) {
		const char *store = hard_store("outside.furrow");
		uint64_t before = support_hash(store);
		char *json = hard_drive(model, "end_time: 3\noutside: skip\nobjects:\n"
				"  - {name: lost, shape: {wheel: {radius: 0.9, width: 0.7}}, sink: 0.2,\n"
				"     path: {points: [[-500, -500], [-400, 900]], speed: 40}}\n", store, NULL);
		assert_int_equal(support_figure(json, "\"quanta\"", "removed"), 0);
		assert_true(support_figure(json, "\"lost\"", "skipped") > 50);
		assert_true(support_hash(store) == before);
		mem_free(json);
	}
}

static double holed(int64_t x, int64_t y)
{
	return x > 30 && x < 50 && y > 20 && y < 70 ? (double)NAN : hard_rough(x, y);
}

static void over_nodata_no_soil_is_lost_into_the_hole(void **state)
{
	EACH_MODEL(model) {
		const char *store = support_path("holed.furrow");
		support_store(store, hard_world, holed);
		char *json = hard_drive(model, "end_time: 6\nspacing: 0.25\noutside: skip\nobjects:\n"
				"  - {name: a, shape: {wheel: {radius: 0.9, width: 0.7}}, sink: 0.3, path: {points: [[20, 40], [70, 44]], speed: 10}}\n"
				"  - {name: b, shape: {sphere: {radius: 2}}, sink: 0.3, path: {points: [[50.2, 30], [50.2, 60]], speed: 8}}\n",
				store, NULL);
		assert_true(support_figure(json, "\"a\"", "skipped") > 10);
		assert_true(support_figure(json, "\"quanta\"", "removed") > 0);
		double *quanta = support_quanta(store, -2, (struct post_rect){31 * 4, 21 * 4, 49 * 4, 69 * 4});
		for (int i = 0; i < 18 * 4 * 48 * 4; i++)
			assert_true(quanta[i] == 0 || isnan(quanta[i]));
		free(quanta);
		mem_free(json);
	}
}

static void half_over_the_edge_of_the_world_soil_stays_inside(void **state)
{
	EACH_MODEL(model) {
		const char *store = hard_store("edge.furrow");
		char *json = hard_drive(model, "end_time: 6\nspacing: 0.25\noutside: skip\nobjects:\n"
				"  - {name: rim, shape: {wheel: {radius: 0.9, width: 0.7}}, sink: 0.3, path: {points: [[0, 20], [0, 60]], speed: 10}}\n"
				"  - {name: corner, shape: {sphere: {radius: 3}}, sink: 0.5, path: {points: [[124, 124], [132, 132]], speed: 4}}\n",
				store, NULL);
		assert_true(support_figure(json, "\"quanta\"", "removed") > 0);
		assert_true(support_figure(json, "\"corner\"", "skipped") > 5);
		/* The outermost posts too: all of the western way, and the corner. */
		assert_true(changes_of(store, -2, (struct post_rect){0, 80, 1, 240}).lowered > 150);
		assert_int_equal(changes_of(store, -2, (struct post_rect){512, 512, 513, 513}).lowered, 1);
		mem_free(json);
	}
}

static void a_hundred_metres_in_one_step_leave_the_rut_of_a_slow_drive(void **state)
{
	EACH_MODEL(model) {
		double *first = NULL;
		struct post_rect rect = {0, 0, 512, 512};
		const char *const steps[] = {"time_step=1", "time_step=0.02"};
		for (int i = 0; i < 2; i++) {
			const char *store = hard_store("fast.furrow");
			mem_free(hard_drive(model, "end_time: 1\nspacing: 0.25\nobjects:\n"
				"  - {name: bullet, shape: {wheel: {radius: 0.9, width: 0.7}}, sink: 0.2,\n"
				"     path: {points: [[10, 10], [110, 20.5]], speed: 101}}\n", store, (const char *[]){steps[i], NULL}));
			double *quanta = support_quanta(store, -2, rect);
			if (first == NULL)
				first = quanta;
			else {
				assert_memory_equal(quanta, first, 512 * 512 * sizeof *quanta);
				free(quanta);
			}
		}
		free(first);
	}
}

/* After the first contact, and what it set sliding, nothing is computed: no pass, no contact of soil that bears. */
static void standing_still_costs_nothing(void **state)
{
	EACH_MODEL(model) {
		long long work[2];
		bool repeats = false;
		const char *const ends[] = {"end_time=20", "end_time=60"};
		for (int i = 0; i < 2; i++) {
			char *json = hard_drive(model, "time_step: 0.1\nend_time: 10\nspacing: 0.25\nobjects:\n"
				"  - {name: stone, shape: {sphere: {radius: 1.5}}, sink: 0.3, path: {points: [[40, 40]], speed: 1}}\n"
				"  - {name: slab, shape: {box: {size: [3, 2, 1]}}, sink: 0.1, path: {points: [[60.3, 40.2]], speed: 1}}\n",
				hard_store("still.furrow"), (const char *[]){ends[i], NULL});
			work[i] = support_figure(json, "\"passes\"", "displace") + support_figure(json, "\"passes\"", "redistribute") +
				  support_figure(json, "\"computed\"", "contacts") + support_figure(json, "\"computed\"", "feels") +
				  support_figure(json, "\"computed\"", "regions");
			repeats = support_counts_repeat(json);
			mem_free(json);
		}
		assert_true(work[0] > 0 && llabs(work[1] - work[0]) <= (repeats ? 0 : work[0] / 2));
	}
}

/* The hole is what lies above its underside, as deep as that. What slides into a hole comes from around it. */
static void starting_deep_inside_the_ground_is_a_hole_and_no_more(void **state)
{
	/* Posts that are under it, or within a wheel's reach of its way. */
	static const struct post_rect mole = {117, 118, 164, 139}, buried = {276, 276, 285, 285};
	EACH_MODEL(model) {
		const char *store = hard_store("inside.furrow");
		char *json = hard_drive(model, "end_time: 3\nspacing: 0.25\nobjects:\n"
				"  - {name: mole, shape: {wheel: {radius: 0.9, width: 0.7}}, sink: 5, path: {points: [[30, 30], [40, 34]], speed: 5}}\n"
				"  - {name: buried, shape: {box: {size: [2, 2, 1]}}, sink: 30, path: {points: [[70, 70]], speed: 5}}\n",
				store, NULL);
		assert_true(support_figure(json, "\"quanta\"", "removed") > 0);
		struct changes rut = changes_of(store, -2, (struct post_rect){0, 0, 220, 513});
		struct changes shaft = changes_of(store, -2, (struct post_rect){220, 0, 513, 513});
		/* Sumner's sand has no cohesion, and fills most of it at once. */
		assert_true(is_sumner(model) ? rut.low < -1.5 : rut.low < -4.9);
		assert_true(is_sumner(model) ? shaft.low < -4 : shaft.low < -29.9);
		assert_true(rut.low > -5.1 && shaft.low > -30.1);
		assert_true(lies_in(rut.all, mole, model->conserves ? 8 : is_box(model)));
		assert_true(lies_in(shaft.all, buried, model->conserves ? 24 : 0));
		if (!is_sumner(model) && !bends(model)) {
			assert_int_equal(shaft.lowered, 9 * 9);
			/* Behind the wheel nothing is laid: the wall of 5 m there slides in. Under slippage all walls do: they are higher than the
			 * soil can hold. */
			int walls = strcmp(model->name, "slippage") == 0 ? 8 : 0;
			assert_true(lies_in(rut.under, mole, (model->conserves ? 2 : 1) + walls) && lies_in(shaft.under, buried, walls));
		}
		assert_true(model->conserves || (rut.raised == 0 && shaft.raised == 0));
		mem_free(json);
	}
}

static void two_that_overlap_in_one_step_each_order_repeats(void **state)
{
	static const char *const orders[] = {
		"  - {name: a, shape: {wheel: {radius: 0.9, width: 0.7}}, sink: 0.2, path: {points: [[30, 30], [60, 31]], speed: 10}}\n"
		"  - {name: b, shape: {sphere: {radius: 1.2}}, sink: 0.3, path: {points: [[60, 30.5], [30, 30.5]], speed: 10}}\n",
		"  - {name: b, shape: {sphere: {radius: 1.2}}, sink: 0.3, path: {points: [[60, 30.5], [30, 30.5]], speed: 10}}\n"
		"  - {name: a, shape: {wheel: {radius: 0.9, width: 0.7}}, sink: 0.2, path: {points: [[30, 30], [60, 31]], speed: 10}}\n",
	};
	EACH_MODEL(model)
		for (int order = 0; order < 2; order++) {
			uint64_t hashes[2];
			for (int i = 0; i < 2; i++) {
				char rest[1024];
				snprintf(rest, sizeof rest, "time_step: 3\nend_time: 3\nspacing: 0.25\nobjects:\n%s", orders[order]);
				const char *store = hard_store("two.furrow");
				mem_free(hard_drive(model, rest, store, NULL));
				hashes[i] = support_hash(store);
			}
			assert_true(hashes[0] == hashes[1]);
		}
}

/* Law 10. Poses are prescribed: also scm's, whose rates are those of the path and not of the steps. */
static void time_steps_of_a_tenth_a_hundredth_and_a_thousandth_leave_the_same_bits(void **state)
{
	const char *const steps[] = {"time_step=0.1", "time_step=0.01", "time_step=0.001"};
	EACH_MODEL(model) {
		uint64_t first = 0;
		for (int i = 0; i < 3; i++) {
			const char *store = hard_store("step.furrow");
			mem_free(hard_drive(model, "end_time: 3\nspacing: 0.25\nobjects:\n"
				"  - {name: rear, shape: {wheel: {radius: 0.9, width: 0.7}}, sink: 0.2, path: {points: [[20, 20], [50, 42]], speed: 10}}\n"
				"  - {name: across, shape: {sphere: {radius: 1.5}}, sink: 0.4, path: {points: [[20, 27], [40, 27], [50, 20]], speed: 9}}\n",
				store, (const char *[]){steps[i], NULL}));
			uint64_t hash = support_hash(store);
			if (i == 0)
				first = hash;
			assert_true(hash == first);
		}
	}
}

static void every_model_works_from_one_metre_to_a_sixty_fourth(void **state)
{
	const char *const spacings[] = {"spacing=1", "spacing=0.25", "spacing=0.0625", "spacing=0.015625"};
	EACH_MODEL(model)
		for (int i = 0; i < 4; i++) {
			char *json = hard_drive(model, "end_time: 0.5\nspacing: 1\nobjects:\n"
				"  - {name: wheel, shape: {wheel: {radius: 0.9, width: 0.8}}, sink: 0.2, path: {points: [[40, 40], [41, 40.4]], speed: 3}}\n",
				hard_store("spacing.furrow"), (const char *[]){spacings[i], NULL});
			assert_true(support_figure(json, "\"quanta\"", "removed") > 0);
			mem_free(json);
		}
}

static void beyond_an_offsets_range_it_is_refused_counted_and_nothing_is_lost(void **state)
{
	const char *poses = support_path("deep.csv");
	support_write(poses, "t,x,y,z\n0,40,40,-1500\n1,44,41,-1500\n");
	EACH_MODEL(model) {
		char rest[512];
		snprintf(rest, sizeof rest, "end_time: 1\nspacing: 0.25\nobjects:\n"
			 "  - {name: deep, shape: {sphere: {radius: 1.5}}, path: {file: %s}}\n", poses);
		char *json = hard_drive(model, rest, hard_store("deep.furrow"), NULL);
		assert_true(support_figure(json, "{", "refused_posts") > 0);
		assert_int_equal(support_figure(json, "\"quanta\"", "removed"), 0);
		mem_free(json);
	}
}

TEST_PROGRAM(objects)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(an_object_smaller_than_a_post_presses_one_at_most),
		cmocka_unit_test(an_object_larger_than_a_window_is_worked_on_in_several),
		cmocka_unit_test(outside_the_world_nothing_happens_and_it_is_counted),
		cmocka_unit_test(over_nodata_no_soil_is_lost_into_the_hole),
		cmocka_unit_test(half_over_the_edge_of_the_world_soil_stays_inside),
		cmocka_unit_test(a_hundred_metres_in_one_step_leave_the_rut_of_a_slow_drive),
		cmocka_unit_test(standing_still_costs_nothing),
		cmocka_unit_test(starting_deep_inside_the_ground_is_a_hole_and_no_more),
		cmocka_unit_test(two_that_overlap_in_one_step_each_order_repeats),
		cmocka_unit_test(time_steps_of_a_tenth_a_hundredth_and_a_thousandth_leave_the_same_bits),
		cmocka_unit_test(every_model_works_from_one_metre_to_a_sixty_fourth),
		cmocka_unit_test(beyond_an_offsets_range_it_is_refused_counted_and_nothing_is_lost),
	};
	return cmocka_run_group_tests_name("hard objects", tests, support_enter, support_leave);
}
