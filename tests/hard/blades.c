/* What a blade pushes is laid where it is pushed to: on the trailing side of a yawed one, into hollows ahead of one that levels, and no higher than it stands. */
#include <math.h>

#include "../support/near.h"
#include "hard.h"
#include "../support/program.h"

#define DEGREES (M_PI / 180)
#define MIDDLE 8.03 /* m, of all ways */
#define LITRES(spacing) (1e3 * ldexp((spacing) * (spacing), -OFFSET_BITS))

static double flat(int64_t x, int64_t y)
{
	(void)x, (void)y;
	return 20;
}

/* Bumps of 5 cm, a metre from crest to crest. Their mean height is 20 m. */
static double bumps(int64_t x, int64_t y)
{
	return 20 + 0.05 * sin(2 * M_PI * (double)x * 0.125) * sin(2 * M_PI * (double)y * 0.125);
}

/* A blade on its way: m, degrees. deep: below 20 m. */
struct blade {
	double size[3], deep, yaw, heading, way, spacing, bulldozing;
	const char *soil;
};

/* What it leaves, by place: ahead of the blade's end and to the left of its way, m; offsets and heights in m. */
struct ground {
	int64_t side;
	double spacing, *quanta;
	struct blade blade;
};

static int level_of(double spacing)
{
	return -(int)lround(log2(0.125 / spacing));
}

static struct ground drive(const struct blade *b, double (*height)(int64_t, int64_t), char **json)
{
	char rest[700], model[200], poses[300];
	const double c = cos(b->heading * DEGREES), s = sin(b->heading * DEGREES), z = 20 + b->size[2] / 2 - b->deep, half = b->way / 2;
	snprintf(poses, sizeof poses, "t,x,y,z,yaw,pitch,roll\n0,%.9g,%.9g,%.9g,%.9g,0,0\n%g,%.9g,%.9g,%.9g,%.9g,0,0\n", MIDDLE - half * c, MIDDLE - half * s, z,
		 b->yaw + b->heading, b->way, MIDDLE + half * c, MIDDLE + half * s, z, b->yaw + b->heading);
	support_write(support_path("blade.csv"), poses);
	snprintf(model, sizeof model, "redistribute: {model: scm, faces: on, bulldozing: %g}\nsoil: {name: %s}\noutput: {forces: 5}\n", b->bulldozing, b->soil);
	snprintf(rest, sizeof rest,
		 "spacing: %g\ntime_step: 0.1\nend_time: %g\nobjects:\n  - {name: blade, shape: {box: {size: [%g, %g, %g]}}, path: {file: %s}}\n", b->spacing,
		 b->way, b->size[0], b->size[1], b->size[2], "blade.csv");
	const char *store = support_path("blade.furrow");
	support_store(store, (struct extent){129, 129, 0.125, 32}, height);
	const struct hard_model scm = {"scm", model, true};
	*json = hard_drive(&scm, rest, store, NULL);
	const int64_t side = (int64_t)lround(16 / b->spacing);
	return (struct ground){side, b->spacing, support_quanta(store, level_of(b->spacing), (struct post_rect){0, 0, side, side}), *b};
}

static double offset_at(const struct ground *ground, int64_t i, double *ahead, double *left)
{
	const double x = (double)(i % ground->side) * ground->spacing - MIDDLE, y = (double)(i / ground->side) * ground->spacing - MIDDLE;
	const double c = cos(ground->blade.heading * DEGREES), s = sin(ground->blade.heading * DEGREES);
	*ahead = x * c + y * s - ground->blade.way / 2;
	*left = y * c - x * s;
	return ldexp(ground->quanta[i], -OFFSET_BITS);
}

static void a_yawed_blade_lays_to_its_trailing_side(void **state)
{
	static const double yaws[] = {30, -30, 30, 45}, headings[] = {0, 22.5, 260, 135}, spacings[] = {0.0625, 0.0625, 0.03125, 0.0625};
	(void)state;
	for (int i = 0; i < 4; i++) {
		const struct blade blade = {{0.2, 2, 0.5}, 0.05, yaws[i], headings[i], 4, spacings[i], 0.5, i == 1 ? "lunar" : "dry_sand"};
		char *json;
		const struct ground ground = drive(&blade, flat, &json);
		double sums[2] = {0};
		for (int64_t k = 0; k < ground.side * ground.side; k++) {
			double ahead, left;
			const double offset = offset_at(&ground, k, &ahead, &left);
			sums[left < 0] += offset > 0 ? offset : 0;
		}
		const double trailing = sums[yaws[i] < 0] / (sums[0] + sums[1]);
		print_message("yaw %g, heading %g, %g m: %.1f %% to the trailing side\n", yaws[i], headings[i], spacings[i], 100 * trailing);
		assert_true(trailing > 0.85);
		mem_free(json);
		free(ground.quanta);
	}
}

static void a_grader_leaves_no_hollow(void **state)
{
	static const double headings[] = {0, 22.5, 60};
	(void)state;
	for (int i = 0; i < 3; i++) {
		const struct blade blade = {{0.2, 2, 0.5}, 0, 0, headings[i], 12, 0.0625, 1, "dry_sand"};
		char *json;
		const struct ground ground = drive(&blade, bumps, &json);
		double deepest = 0, highest = 0;
		for (int64_t k = 0; k < ground.side * ground.side; k++) {
			double ahead, left;
			const double offset = offset_at(&ground, k, &ahead, &left), x = (double)(k % ground.side) / 2, y = (double)(k / ground.side) / 2;
			/* Posts of the store lie twice as far apart; between them ground is bilinear. */
			const double low[2] = {floor(x), floor(y)}, part[2] = {x - low[0], y - low[1]};
			double base = 0;
			for (int corner = 0; corner < 4; corner++)
				base += (corner & 1 ? part[0] : 1 - part[0]) * (corner & 2 ? part[1] : 1 - part[1]) *
					(bumps((int64_t)low[0] + (corner & 1), (int64_t)low[1] + (corner >> 1)) - 20);
			/* In the first metres there is not yet a heap to fill hollows with. */
			if (fabs(left) < 0.85 && ahead > -5 && ahead < -0.4) {
				deepest = support_least(deepest, base + offset);
				highest = support_most(highest, base + offset);
			}
		}
		print_message("heading %g: from %.2f to %.2f mm\n", headings[i], 1e3 * deepest, 1e3 * highest);
		assert_true(deepest > -0.01 && highest < 0.001);
		mem_free(json);
		free(ground.quanta);
	}
}

/* Heap ahead of a box: litres. Its crest rises from both ends by half of the tangent of repose, and it falls ahead by sqrt(3) / 2 of it. */
static double heap_of(const struct blade *blade, double *crest)
{
	char *json;
	const struct ground ground = drive(blade, flat, &json);
	double sum = 0;
	*crest = 0;
	for (int64_t k = 0; k < ground.side * ground.side; k++) {
		double ahead, left;
		const double offset = offset_at(&ground, k, &ahead, &left);
		if (ahead > blade->size[0] / 2 && ahead < 1 && fabs(left) < blade->size[1] / 2) {
			sum += offset > 0 ? offset : 0;
			*crest = support_most(*crest, offset);
		}
	}
	mem_free(json);
	free(ground.quanta);
	return 1e3 * sum * blade->spacing * blade->spacing;
}

static void the_wedge_ahead_of_a_box_saturates(void **state)
{
	static const double spacings[] = {0.0625, 0.03125, 0.015625}, headings[] = {0, 30, 45, 77, 200};
	/* So a box of 1 m in soil that stands at 28 degrees has so much above the ground, however deep it goes. */
	const double tangent = tan(28 * DEGREES), rise = 0.5 * tangent, above = 0.5 * rise, whole = 1e3 * pow(above, 3) / (3 * rise) / (sqrt(0.75) * tangent);
	double crest;
	(void)state;
	for (int i = 0; i < 7; i++) {
		struct blade blade = {{0.5, 1, 0.4}, 0.05, 0, headings[i < 3 ? 0 : i - 2], 1.5, i < 3 ? spacings[2 - i] : 0.03125, 0.5, "dry_sand"};
		const double early = heap_of(&blade, &crest), first = crest;
		blade.way = 4;
		const double late = heap_of(&blade, &crest);
		print_message("%g m, heading %g: %.3f l and %.0f mm after 1.5 m, %.3f l and %.0f mm after 4 m\n", blade.spacing, blade.heading, early, 1e3 * first, late, 1e3 * crest);
		assert_true(fabs(late / early - 1) < 0.03);
		assert_true(fabs(late / whole - 1) < (blade.spacing > 0.05 ? 0.06 : 0.03) && crest < above);
	}
}

/* Whatever `bulldozing` is, what a blade pushes is carried whole, and no soil is made. */
static void what_a_blade_pushes_is_not_compacted(void **state)
{
	static const double bulldozing[] = {0, 0.5, 1};
	(void)state;
	for (int i = 0; i < 3; i++) {
		const struct blade blade = {{0.2, 1, 0.5}, 0.05, 0, 10, 3, 0.0625, bulldozing[i], "dry_sand"};
		char *json;
		const struct ground ground = drive(&blade, flat, &json);
		const long long removed = support_figure(json, "\"quanta\"", "removed"), raised = support_figure(json, "\"quanta\"", "raised");
		print_message("bulldozing %g: removes %.2f l, raises %.2f l\n", bulldozing[i], (double)removed * LITRES(0.0625), (double)raised * LITRES(0.0625));
		/* It was set down into the ground: that is pressed. */
		assert_true(raised <= removed && (double)(removed - raised) * LITRES(0.0625) < 1.1e3 * 0.3 * 1.06 * 0.05);
		mem_free(json);
		free(ground.quanta);
	}
}

TEST_PROGRAM(blades)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_yawed_blade_lays_to_its_trailing_side),
		cmocka_unit_test(a_grader_leaves_no_hollow),
		cmocka_unit_test(the_wedge_ahead_of_a_box_saturates),
		cmocka_unit_test(what_a_blade_pushes_is_not_compacted),
	};
	return cmocka_run_group_tests_name("blades", tests, support_enter, support_leave);
}
