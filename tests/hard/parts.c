/* A wheel in two parts, twin wheels, a plate in four: what is one body to an eye is one to the soil, in any order and on any tiles. */
#include <math.h>

#include "hard.h"
#include "../support/near.h"
#include "../support/program.h"

static double flat(int64_t x, int64_t y)
{
	(void)x, (void)y;
	return 20;
}

static const struct hard_model *scm(void)
{
	return &hard_models[HARD_MODELS - 1];
}

/* Sums over bodies, in the mean of their rows from a time on, and how deep the deepest is. */
struct row {
	double force[3], sinkage;
};

static struct row mean_rows(const char *const *names, size_t count, double from)
{
	char path[200];
	snprintf(path, sizeof path, "%s/objects.csv", support_path("out"));
	char *text = support_text(path);
	struct row sum = {.sinkage = 0};
	for (size_t i = 0; i < count; i++) {
		double sums[4] = {0}, rows = 0;
		char called[40];
		snprintf(called, sizeof called, ",%s,", names[i]);
		for (char *line = strchr(text, '\n'); line != NULL && line[1] != '\0'; line = strchr(line + 1, '\n')) {
			char *at = strchr(line + 1, ','), *rest;
			if (at == NULL || strncmp(at, called, strlen(called)) != 0)
				continue;
			rest = at + strlen(called);
			const bool counts = strtod(line + 1, NULL) >= from;
			for (int k = 0; k < 7; k++) { /* x, y, z, sinkage, fx, fy, fz */
				const double number = strtod(rest, &rest);
				rest++;
				if (k >= 3 && counts)
					sums[k - 3] += number;
			}
			rows += counts;
		}
		assert_true(rows > 0);
		for (int k = 0; k < 3; k++)
			sum.force[k] += sums[1 + k] / rows;
		sum.sinkage = support_most(sum.sinkage, sums[0] / rows);
	}
	free(text);
	return sum;
}

static const char *store_of(const char *name, uint32_t tile)
{
	const char *store = support_path(name);
	support_store(store, (struct extent){129, 129, 0.25, tile}, flat);
	return store;
}

/* A wheel of 0.24 m, or its halves, on a path with a heading. */
static void wheels(char *text, size_t size, double spacing, double heading, double load, double gap, int parts, bool swapped)
{
	const double c = cos(heading), s = sin(heading), width = parts == 1 ? 0.24 : 0.12;
	int length = snprintf(text, size, "spacing: %g\ntime_step: 0.05\nend_time: 2.3\nobjects:\n", spacing);
	for (int n = 0; n < parts; n++) {
		const int i = swapped ? parts - 1 - n : n;
		const double aside = parts == 1 ? 0 : (i == 0 ? 1 : -1) * (0.06 + gap / 2), x = 12.02 - aside * s, y = 13.03 + aside * c;
		length += snprintf(text + length, size - (size_t)length,
				   "  - {name: %s, shape: {wheel: {radius: 0.3, width: %g}}, load: %g, slip: 0.2, path: {points: [[%.9g, %.9g], [%.9g, %.9g]], speed: 1}}\n",
				   parts == 1 ? "one" : i == 0 ? "left" : "right", width, load / parts, x, y, x + 2 * c, y + 2 * s);
	}
}

static const char *const one[] = {"one"}, *const halves[] = {"left", "right"};

static void the_halves_of_a_wheel_bear_and_leave_a_rut_as_the_wheel(void **state)
{
	static const double spacings[] = {0.0625, 0.03125}, headings[] = {0, 0.5};
	(void)state;
	for (int i = 0; i < 4; i++) {
		char text[2048];
		wheels(text, sizeof text, spacings[i / 2], headings[i % 2], 900, 0, 1, false);
		mem_free(hard_drive(scm(), text, store_of("one.furrow", 64), NULL));
		const struct row whole = mean_rows(one, 1, 1);
		wheels(text, sizeof text, spacings[i / 2], headings[i % 2], 900, 0, 2, false);
		mem_free(hard_drive(scm(), text, store_of("two.furrow", 64), NULL));
		const struct row parts = mean_rows(halves, 2, 1);
		print_message("%g m, heading %g: %.4g %.4g %.4g N and %.4g mm; in halves %.4g %.4g %.4g N and %.4g mm\n", spacings[i / 2], headings[i % 2],
			      whole.force[0], whole.force[1], whole.force[2], whole.sinkage * 1e3, parts.force[0], parts.force[1], parts.force[2], parts.sinkage * 1e3);
		for (int k = 0; k < 3; k++)
			assert_true(fabs(whole.force[k] - parts.force[k]) < 0.02 * 900);
		assert_true(fabs(whole.sinkage - parts.sinkage) < 0.02 * whole.sinkage);
		/* No ridge between them. Beside the middle soil slides back into the rut, so how the heaps lie shows there. */
		const int level = spacings[i / 2] < 0.05 ? -3 : -2;
		const double by = 0.25 / spacings[i / 2];
		const struct post_rect around = {(int64_t)(48 * by), (int64_t)(50 * by), (int64_t)(56 * by), (int64_t)(57 * by)};
		double *a = support_quanta(support_path("one.furrow"), level, around), *b = support_quanta(support_path("two.furrow"), level, around), worst = 0, deepest = 0;
		for (int64_t k = 0; k < (around.x1 - around.x0) * (around.y1 - around.y0); k++) {
			const double x = (double)(around.x0 + k % (around.x1 - around.x0)) * spacings[i / 2] - 12.02, y = (double)(around.y0 + k / (around.x1 - around.x0)) * spacings[i / 2] - 13.03;
			const double c = cos(headings[i % 2]), s = sin(headings[i % 2]), along = c * x + s * y, aside = c * y - s * x;
			if (fabs(aside) < 0.055 && along > 0.4 && along < 1.5) {
				worst = support_most(worst, fabs(a[k] - b[k]) / (1 << OFFSET_BITS));
				deepest = support_least(deepest, a[k] / (1 << OFFSET_BITS));
			}
		}
		print_message("the rut differs by up to %.3g mm\n", worst * 1e3);
		assert_true(deepest < -0.5 * whole.sinkage && worst < 0.04 * whole.sinkage);
		free(a);
		free(b);
	}
}

static void twin_wheels_leave_the_same_bits_in_any_order_and_on_any_tiles(void **state)
{
	static const uint32_t tiles[] = {64, 8, 32};
	double *first = NULL;
	(void)state;
	for (int i = 0; i < 3; i++)
		for (int swapped = 0; swapped < 2; swapped++) {
			char text[2048];
			wheels(text, sizeof text, 0.0625, 0.5, 900, 0.05, 2, swapped != 0);
			const char *store = store_of("twins.furrow", tiles[i]);
			mem_free(hard_drive(scm(), text, store, (const char *const[]){i == 1 ? "cache.slots=40" : "cache.slots=200", NULL}));
			double *quanta = support_quanta(store, -2, (struct post_rect){180, 200, 240, 260});
			if (first != NULL) {
				assert_memory_equal(quanta, first, 60 * 60 * sizeof *quanta);
				free(quanta);
			} else {
				first = quanta;
			}
		}
	free(first);
}

/* Soil bears from below alone. Of faces a plate's front half counts its depth from the ground ahead, and its rear half from the rut. So each part of a plate would
 * have a front half of its own. */
static void a_plate_in_four_parts_is_a_plate(void **state)
{
	static const struct hard_model below = {"scm", "redistribute: {model: scm, faces: off}\nsoil: {name: dry_sand}\noutput: {forces: 20}\n", true};
	(void)state;
	static const char *const parts[] = {"a", "b", "c", "d"};
	for (int over = 0; over < 2; over++) {
		char text[2048];
		const double more = over ? 0.03 : 0;
		snprintf(text, sizeof text, "spacing: 0.03125\nend_time: 1\nobjects:\n  - {name: one, shape: {box: {size: [0.6, 0.4, 0.2]}}, sink: 0.02, path: {points: [[12.01, 13.02], [12.31, 13.12]], speed: 1}}\n");
		mem_free(hard_drive(&below, text, store_of("one.furrow", 64), NULL));
		const struct row whole = mean_rows(one, 1, 0.15);
		int length = snprintf(text, sizeof text, "spacing: 0.03125\nend_time: 1\nobjects:\n");
		const double heading = atan2(0.1, 0.3), c = cos(heading), s = sin(heading);
		for (int i = 0; i < 4; i++) {
			const double ahead = (i & 1 ? 1 : -1) * (0.15 - more / 2), aside = (i & 2 ? 1 : -1) * (0.1 - more / 2);
			const double x = 12.01 + c * ahead - s * aside, y = 13.02 + s * ahead + c * aside;
			length += snprintf(text + length, sizeof text - (size_t)length,
					   "  - {name: %s, shape: {box: {size: [%g, %g, 0.2]}}, sink: 0.02, path: {points: [[%.9g, %.9g], [%.9g, %.9g]], speed: 1}}\n", parts[i], 0.3 + more,
					   0.2 + more, x, y, x + 0.3, y + 0.1);
		}
		mem_free(hard_drive(&below, text, store_of("four.furrow", 64), NULL));
		const struct row four = mean_rows(parts, 4, 0.15);
		print_message("%g m over each other: %.4g %.4g %.4g N; of one plate %.4g %.4g %.4g N\n", more, four.force[0], four.force[1], four.force[2], whole.force[0],
			      whole.force[1], whole.force[2]);
		for (int k = 0; k < 3; k++)
			assert_true(fabs(whole.force[k] - four.force[k]) < 0.02 * whole.force[2]);
	}
}

TEST_PROGRAM(parts)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_halves_of_a_wheel_bear_and_leave_a_rut_as_the_wheel),
		cmocka_unit_test(twin_wheels_leave_the_same_bits_in_any_order_and_on_any_tiles),
		cmocka_unit_test(a_plate_in_four_parts_is_a_plate),
	};
	return cmocka_run_group_tests_name("bodies in parts", tests, support_enter, support_leave);
}
