/*
 * Wheels with more and more bars, on the rig, under one load. In tests of wheels in sand bars pull more than a smooth rim, and sink deeper where they spin:
 * Ding and others 2011 (Journal of Terramechanics 48, figure 9): 15 N without lugs, 24.5 N with 30 at slip 0.6. So more bars never pull less than none here.
 */
#include <math.h>

#include "../support.h"
#include "../long.h"
#include "../support/program.h"
#include "trials/trials.h"

static const int counts[] = {0, 6, 18, 36};
static const double slips[] = {0.2, 0.5, 0.8};
#define COUNTS (sizeof counts / sizeof *counts)
#define SLIPS (sizeof slips / sizeof *slips)

struct wheel {
	double radius, width, height, load; /* m, N; height: of its bars */
	const char *soil;
	double parts;                       /* posts over the radius */
};

struct rows {
	struct rig_row at[SLIPS];
	size_t count;
};

static enum status keep(void *user, const struct rig_row *row)
{
	struct rows *rows = user;
	rows->at[rows->count++] = *row;
	return STATUS_OK;
}

static struct rows rows_of(const struct wheel *wheel, int bars)
{
	char shape[160];
	struct rows rows = {.count = 0};
	struct rig_found found;
	snprintf(shape, sizeof shape, "wheel: {radius: %g, width: %g%s", wheel->radius, wheel->width, bars == 0 ? "}" : "");
	if (bars > 0)
		snprintf(shape + strlen(shape), sizeof shape - strlen(shape), ", grousers: %d, grouser_height: %g, grouser_thickness: 0.003}", bars, wheel->height);
	const struct rig_params params = {.shape = shape, .soils = &wheel->soil, .soil_count = 1, .loads = &wheel->load, .load_count = 1, .slips = slips, .slip_count = SLIPS,
					  .spacing = wheel->radius / wheel->parts, .way = 6 * wheel->radius, .settings = "redistribute.faces=on", .folder = support_path("")};
	must(trials_rig_run(&params, &found, keep, &rows));
	assert_int_equal(rows.count, SLIPS);
	return rows;
}

/* Checks rows of a wheel with more bars beside those with fewer, and with none. */
static void compare(const struct wheel *wheel, const struct rows *none, const struct rows *fewer, const struct rows *more, int bars)
{
	for (size_t i = 0; i < SLIPS; i++) {
		const struct rig_row *a = &none->at[i], *b = &fewer->at[i], *c = &more->at[i];
		print_message("%s, r %g m, %d bars of %g mm, slip %g: %.1f mm deep, pulls %.2f N (none %.2f N), torque %.3f N m\n", wheel->soil, wheel->radius, bars, wheel->height * 1e3,
			      slips[i], c->sinkage * 1e3, c->drawbar, a->drawbar, c->torque);
		/* A hundredth of the load is what posts cost. */
		assert_true(c->drawbar >= a->drawbar - 0.01 * wheel->load);
		assert_true(c->torque >= b->torque * 0.999);
		assert_true(c->sinkage >= a->sinkage * 0.98);
	}
}

static void more_bars_pull_no_less_than_none(void **state)
{
	static const struct wheel wheels[] = {
		{0.25, 0.2, 0.02, 500, "dry_sand", 16}, {0.08, 0.06, 0.005, 40, "dry_sand", 10}, {0.08, 0.06, 0.01, 40, "lunar", 10},
		{0.25, 0.2, 0.005, 500, "lunar", 16}, {0.25, 0.2, 0.01, 500, "lete_sand", 16}, {0.08, 0.06, 0.02, 40, "dry_sand", 10},
		{0.25, 0.2, 0.02, 500, "lunar", 16}, {0.08, 0.06, 0.01, 40, "lete_sand", 16}, {0.25, 0.2, 0.01, 1000, "dry_sand", 20},
	};
	(void)state;
	for (size_t k = 0; k < sizeof wheels / sizeof *wheels; k++) {
		if (!by_turn(k, 3))
			continue;
		const struct rows none = rows_of(&wheels[k], 0);
		struct rows fewer = none;
		for (size_t n = 1; n < COUNTS; n++) {
			const struct rows more = rows_of(&wheels[k], counts[n]);
			compare(&wheels[k], &none, &fewer, &more, counts[n]);
			fewer = more;
		}
	}
}

TEST_PROGRAM(bars)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(more_bars_pull_no_less_than_none),
	};
	return cmocka_run_group_tests_name("bars on a wheel", tests, support_enter, support_leave);
}
