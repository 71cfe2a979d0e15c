/* No ground stands inside a body: what a blade pushes against a parked plate goes around it, or over it, whatever the heading, the spacing and the tiles. */
#include <math.h>

#include "hard.h"
#include "../support/near.h"
#include "../support/program.h"

#define MIDDLE_X 8.03 /* m: of the plate */
#define MIDDLE_Y 8.02
#define LOW 20.0      /* m: the ground */

static const double plate[3] = {1, 2, 0.1};

static double flat(int64_t x, int64_t y)
{
	(void)x, (void)y;
	return LOW;
}

struct parked {
	double gap, pitch, heading, spacing; /* m below the plate's lowest place; degrees */
	uint32_t cells;
	const char *soil;
	const char *model, *compute; /* NULL: scm; otherwise a kinematic model, and what computes it: cpu, gpu */
};

/* Writes a path on which a body goes towards the plate along the heading, from so far to so near. */
static void write_path(const char *name, const struct parked *p, double z, double pitch, double far, double near)
{
	char text[400];
	const double c = cos(p->heading * M_PI / 180), s = sin(p->heading * M_PI / 180);
	snprintf(text, sizeof text, "t,x,y,z,yaw,pitch,roll\n0,%.9g,%.9g,%.9g,%.9g,%.9g,0\n3,%.9g,%.9g,%.9g,%.9g,%.9g,0\n", MIDDLE_X - far * c, MIDDLE_Y - far * s, z, p->heading,
		 pitch, MIDDLE_X - near * c, MIDDLE_Y - near * s, z, p->heading, pitch);
	support_write(support_path(name), text);
}

/* Returns litres of ground above the plate's lower side and below its upper one, a cell or more from its edge. beside: ground beside it that is higher
 * than its lowest place by a third of its thickness, l. */
static double inside(const struct parked *p, double z, const char *store, double *beside)
{
	const int64_t side = (int64_t)lround(16 / p->spacing);
	double *quanta = support_quanta(store, -(int)lround(log2(0.25 / p->spacing)), (struct post_rect){0, 0, side, side}), sum = 0;
	const double c = cos(p->heading * M_PI / 180), s = sin(p->heading * M_PI / 180), t = tan(p->pitch * M_PI / 180), cp = cos(p->pitch * M_PI / 180);
	*beside = 0;
	for (int64_t i = 0; i < side * side; i++) {
		const double x = (double)(i % side) * p->spacing - MIDDLE_X, y = (double)(i / side) * p->spacing - MIDDLE_Y;
		const double ahead = x * c + y * s, left = y * c - x * s, ground = LOW + ldexp(quanta[i], -OFFSET_BITS), half = plate[0] / 2 * cp - plate[2] / 2 * fabs(t) * cp;
		const double low = z + t * ahead - plate[2] / 2 / cp, high = low + plate[2] / cp;
		if (fabs(ahead) < half - p->spacing && fabs(left) < plate[1] / 2 - p->spacing)
			sum += fmin(fmax(ground - low, 0), high - low);
		else if (ahead < -plate[0] / 2 - p->spacing && ahead > -plate[0] && fabs(left) < plate[1] / 2)
			*beside += fmax(ground - z + plate[2] / 6, 0);
	}
	mem_free(quanta);
	*beside *= 1e3 * p->spacing * p->spacing;
	return 1e3 * sum * p->spacing * p->spacing;
}

/* carried: fixed-point units that the plate has aboard then; NULL: it does not carry. */
static double park(const struct parked *p, double *beside, long long *carried)
{
	const char *store = support_path("inside.furrow");
	const double z = LOW + p->gap + plate[2] / 2 * cos(p->pitch * M_PI / 180) + plate[0] / 2 * fabs(sin(p->pitch * M_PI / 180));
	char model[200], rest[700];
	support_store(store, (struct extent){65, 65, 0.25, p->cells}, flat);
	write_path("plate.csv", p, z, p->pitch, 0, 0);
	write_path("blade.csv", p, LOW + 0.15, 0, 2.9, 0.85);
	snprintf(model, sizeof model, p->model != NULL ? "redistribute: {model: %s}\nsoil: {name: %s}\ncompute: %s\n" : "redistribute: {model: %s, bulldozing: 1}\nsoil: {name: %s}\noutput: {forces: 5}\n",
		 p->model != NULL ? p->model : "scm", p->soil, p->compute);
	snprintf(rest, sizeof rest,
		 "spacing: %g\ntime_step: 0.1\nend_time: 3.5\nobjects:\n  - {name: plate, shape: {box: {size: [1, 2, 0.1]}}, carry: %s, path: {file: plate.csv}}\n"
		 "  - {name: blade, shape: {box: {size: [0.2, 2, 0.6]}}, path: {file: blade.csv}}\n", p->spacing,
		 carried != NULL ? "true" : "false");
	const struct hard_model scm = {p->model != NULL ? p->model : carried == NULL ? "scm" : "scm with carry", model, carried == NULL};
	char *json = hard_drive(&scm, rest, store, NULL);
	if (carried != NULL) {
		const struct store_check check = support_verify(store);
		*carried = support_figure(json, "\"quanta\"", "carried");
		assert_int_equal(check.offset_sum[-(int)lround(log2(0.25 / p->spacing)) - TILE_LEVEL_MIN] + support_figure(json, "\"quanta\"", "compacted") + *carried, 0);
	}
	mem_free(json);
	return inside(p, z, store, beside);
}

static void no_ground_stands_inside_a_parked_plate(void **state)
{
	static const struct parked cases[] = {
		{0, 0, 0, 0.0625, 32, "dry_sand", NULL, NULL},       {0.02, 0, 0, 0.0625, 32, "dry_sand", NULL, NULL},   {0.02, 0, 22.5, 0.0625, 64, "dry_sand", NULL, NULL},
		{-0.02, 0, 260, 0.03125, 32, "lunar", NULL, NULL},   {0.05, 0, 135, 0.03125, 16, "dry_sand", NULL, NULL}, {0, 8, 10, 0.0625, 32, "dry_sand", NULL, NULL},
		{0, -8, 300, 0.03125, 32, "lunar", NULL, NULL},
	};
	(void)state;
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		const struct parked *p = &cases[i];
		double beside;
		const double litres = park(p, &beside, NULL);
		print_message("%g m gap, pitch %g, heading %g, %g m: %.6f l of ground inside the plate, %.1f l against it\n", p->gap, p->pitch, p->heading, p->spacing, litres, beside);
		assert_true(beside > 5); /* the soil came to it */
		assert_true(litres < 1e-3);
	}
}

static void kinematic_models_leave_no_ground_inside_a_parked_plate(void **state)
{
	static const struct parked cases[] = {
		{0, 0, 0, 0.0625, 32, "dry_sand", "slippage", "cpu"},      {0, 0, 0, 0.0625, 32, "dry_sand", "slippage", "gpu"},
		{0, 0, 0, 0.0625, 32, "sand, compression: 0", "sumner, iterations: 3", "cpu"},           {0, 0, 0, 0.0625, 32, "sand, compression: 0", "sumner, iterations: 3", "gpu"},
		{0.02, 0, 22.5, 0.0625, 64, "dry_sand", "slippage", "cpu"}, {0.02, 0, 22.5, 0.0625, 64, "dry_sand", "slippage", "gpu"},
		{0.08, 0, 135, 0.03125, 32, "sand, compression: 0", "sumner", "cpu"},       {0.08, 0, 135, 0.03125, 32, "sand, compression: 0", "sumner", "gpu"},
		{0, 8, 10, 0.0625, 16, "dry_sand", "slippage", "cpu"},  {0, 8, 10, 0.0625, 16, "dry_sand", "slippage", "gpu"},
	};
	(void)state;
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		const struct parked *p = &cases[i];
		double beside;
		const double litres = park(p, &beside, NULL);
		print_message("%s on the %s, %g m gap, pitch %g, heading %g, %g m: %.6f l of ground inside the plate, %.1f l against it\n", p->model, p->compute, p->gap, p->pitch,
			      p->heading, p->spacing, litres, beside);
		assert_true(beside > 5); /* the soil came to it */
		assert_true(litres < 1e-3);
	}
}

static void what_is_higher_than_a_plate_that_carries_slides_onto_it(void **state)
{
	static const struct parked cases[] = {{-0.09, 0, 0, 0.0625, 32, "dry_sand", NULL, NULL}, {-0.09, 0, 22.5, 0.03125, 32, "lunar", NULL, NULL}, {-0.09, 0, 135, 0.0625, 16, "dry_sand", NULL, NULL}};
	(void)state;
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		const struct parked *p = &cases[i];
		long long carried;
		double beside;
		const double litres = park(p, &beside, &carried), aboard = 1e3 * ldexp((double)carried, -OFFSET_BITS) * p->spacing * p->spacing;
		print_message("heading %g, %g m: %.3f l aboard, %.6f l of ground inside the plate, %.1f l against it\n", p->heading, p->spacing, aboard, litres, beside);
		assert_true(aboard > 1);
		assert_true(litres < 1e-3);
	}
}

TEST_PROGRAM(inside)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(no_ground_stands_inside_a_parked_plate),
		cmocka_unit_test(kinematic_models_leave_no_ground_inside_a_parked_plate),
		cmocka_unit_test(what_is_higher_than_a_plate_that_carries_slides_onto_it),
	};
	return cmocka_run_group_tests_name("inside", tests, support_enter, support_leave);
}
