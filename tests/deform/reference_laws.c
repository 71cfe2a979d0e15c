/* The reference alone: it neither makes nor loses soil, and its rules give what a hand computes for a few posts. */
#include "../support/near.h"
#include "reference_rig.h"
#include "../support/program.h"

/* Heights of the surface, squared: the potential energy but for factors. */
static double energy(const struct reference_ground *ground)
{
	double sum = 0;
	for (int i = 0; i < ground->width * ground->height; i++)
		sum += pow(ground->base[i] + ground->offset[i], 2);
	return sum;
}

/* Back and forth over rough ground with a hole in it. */
static void soil_is_neither_made_nor_lost(void **state)
{
	(void)state;
	static const enum deform_model models[] = {DEFORM_NONE, DEFORM_SUMNER, DEFORM_SLIPPAGE, DEFORM_SCM};
	struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4};
	for (size_t m = 0; m < sizeof models / sizeof *models; m++) {
		struct reference_ground ground = made(48, 24, 0.1);
		struct deform_params params = with(models[m], "dry_sand");
		struct reference_forces forces;
		ground.left = 100;
		ground.bottom = 20;
		ground.hole[POST(24, 11)] = true;
		for (int i = 0; i < 48 * 24; i++)
			ground.base[i] = 0.1 * any_height();
		struct deform_contact sweep = {.shape = &wheel, .from = at(&ground, 8, 12, 0.4), .to = at(&ground, 8, 12, 0.4)};
		double lowest = 0;
		for (int i = 0; i <= 60; i++) {
			double turn = i <= 30 ? i : 60 - i;
			sweep.from = sweep.to;
			sweep.to = at(&ground, 8 + turn, 12, 0.4 - 0.002 * turn);
			sweep.turned = 0.1;
			swept(&ground, &params, &sweep, &forces);
			for (int p = 0; p < 48 * 24; p++)
				lowest = support_least(lowest, ground.offset[p]);
		}
		assert_true(lowest < -0.1);
		assert_true(fabs(reference_volume(&ground)) < 1e-12);
		assert_true(ground.offset[POST(24, 11)] == 0);
		assert_true(models[m] == DEFORM_SLIPPAGE ? ground.compacted == 0 : ground.compacted > 0.05);
		double highest = 0;
		for (int p = 0; p < 48 * 24; p++)
			highest = support_most(highest, ground.offset[p]);
		assert_true(models[m] == DEFORM_NONE ? highest == 0 : highest > 0.01);
		reference_ground_finish(&ground);
	}
}

static void lay(struct reference_ground *ground, const struct deform_params *params, const struct deform_contact *sweep)
{
	struct reference_laying laying;
	assert_int_equal(reference_spread(ground, params, sweep, &laying), STATUS_OK);
	assert_true(!laying.undecided);
}

/* A ball on one post: by the distance of each post from it, less half a post. */
static void what_is_lifted_goes_around_by_its_distance(void **state)
{
	(void)state;
	struct reference_ground ground = made(9, 9, 0.5);
	struct deform_params params = with(DEFORM_SLIPPAGE, "dry_sand");
	const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 1};
	struct deform_contact sweep = {.shape = &ball, .from = at(&ground, 4, 4, 0), .to = at(&ground, 4, 4, 0)};
	ground.contact[POST(4, 4)] = REFERENCE_SWEPT;
	ground.carried[POST(4, 4)] = 1;
	lay(&ground, &params, &sweep);
	/* The band is as wide as the ball's radius, 128 64ths of a post. Its profile rises to 42 of them, is level, and falls. Halves of
	 * them: distances are rounded down to whole ones. */
	double weights[5] = {16, 21, 16, 8.5, 0};
	const int away[5][2] = {{1, 0}, {1, 1}, {2, 0}, {2, 1}, {2, 2}}, times[5] = {4, 4, 4, 8, 4};
	double sum = 0, all = 0;
	for (int k = 0; k < 5; k++)
		sum += weights[k] * times[k];
	for (int k = 0; k < 5; k++)
		for (int turn = 0; turn < 8; turn++) {
			int x = away[k][turn % 2] * (turn & 2 ? -1 : 1), y = away[k][1 - turn % 2] * (turn & 4 ? -1 : 1);
			assert_true(fabs(ground.offset[POST(4 + x, 4 + y)] - weights[k] / sum) < 1e-12);
			assert_true(ground.heaped[POST(4 + x, 4 + y)] == ground.offset[POST(4 + x, 4 + y)]);
		}
	for (int i = 0; i < 81; i++)
		all += ground.offset[i];
	assert_true(fabs(all - 1) < 1e-12 && ground.carried[POST(4, 4)] == 0);
	/* Holes and what is not written take nothing: the others take it all. Without any the soil is compacted. */
	memset(ground.offset, 0, 81 * sizeof *ground.offset);
	ground.hole[POST(5, 4)] = true;
	ground.written = (struct post_rect){3, 3, 9, 9};
	ground.carried[POST(4, 4)] = 1;
	lay(&ground, &params, &sweep);
	assert_true(ground.offset[POST(5, 4)] == 0 && ground.offset[POST(2, 4)] == 0);
	sum = 2 * weights[2] + 2 * weights[0] + weights[0] + 4 * weights[1] + 4 * weights[3];
	assert_true(fabs(ground.offset[POST(4, 6)] - weights[2] / sum) < 1e-12);
	ground.written = (struct post_rect){4, 4, 5, 5};
	ground.carried[POST(4, 4)] = 3;
	lay(&ground, &params, &sweep);
	assert_true(ground.confined == 0.75 && ground.compacted == 0.75);
	reference_ground_finish(&ground);
}

/* Sums beside the four faces of a wheel: west, east, south, north of what it touches. The last one: north and south, but beyond its radius
 * behind its axle, or ahead of post `last`. */
static void lay_beside(const struct deform_contact *sweep, int last, double sums[5])
{
	struct reference_ground ground = made(41, 41, 0.05);
	struct deform_params params = with(DEFORM_SLIPPAGE, "dry_sand");
	for (int y = 18; y <= 22; y++)
		for (int x = 17; x <= 22; x++) {
			ground.contact[POST(x, y)] = REFERENCE_SWEPT;
			ground.carried[POST(x, y)] = 0.01;
		}
	lay(&ground, &params, sweep);
	memset(sums, 0, 5 * sizeof *sums);
	for (int i = 0; i < 41 * 41; i++) {
		int x = i % 41, y = i / 41, face = y < 18 ? 2 : y > 22 ? 3 : x < 17 ? 0 : 1;
		sums[face > 1 && (x < 10 || x > last) ? 4 : face] += ground.offset[i] / 0.3;
	}
	reference_ground_finish(&ground);
}

static void a_wheel_lays_beside_its_way_and_a_sledge_ahead(void **state)
{
	(void)state;
	struct reference_ground ground = made(41, 41, 0.05);
	const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.53, .width = 0.26};
	const struct soil_shape box = {.kind = SOIL_BOX, .size = {0.3, 0.25, 0.2}};
	struct deform_contact sweep = {.shape = &wheel, .from = at(&ground, 19, 20, 0), .to = at(&ground, 20, 20, 0)};
	double sums[5];
	reference_ground_finish(&ground);
	const double ways[][5] = {{0, 0, 0.5, 0.5, 0}, {0, 0.5, 0.25, 0.25, 0}, {0, 0.125, 0.4375, 0.4375, 0}};
	for (int k = 0; k < 3; k++) { /* it rolls; it is locked; half of its way it slides */
		sweep.turned = k == 0 ? 0.05 / 0.53 : k == 1 ? 0 : 0.025 / 0.53;
		lay_beside(&sweep, 13, sums); /* five eighths of its radius behind its axle */
		for (int i = 0; i < 5; i++)
			assert_true(fabs(sums[i] - ways[k][i]) < 1e-6);
	}
	/* Aside: half on the side to which it goes, a quarter before and behind it. */
	sweep.from.x = sweep.to.x;
	sweep.from.y -= lattice_offset(0.05);
	lay_beside(&sweep, 23, sums);
	assert_true(fabs(sums[3] - 0.5) < 1e-6 && fabs(sums[0] - 0.25) < 1e-6 && fabs(sums[1] - 0.25) < 1e-6 && sums[2] == 0);
	/* A box that goes west. */
	sweep = (struct deform_contact){.shape = &box, .from = sweep.to, .to = sweep.to};
	sweep.from.x += lattice_offset(0.05);
	lay_beside(&sweep, 40, sums);
	assert_true(fabs(sums[0] - 0.5) < 1e-6 && sums[1] == 0 && fabs(sums[2] - 0.25) < 1e-6 && fabs(sums[3] - 0.25) < 1e-6);
}

static void an_iteration_slides_an_eighth_of_what_is_too_steep(void **state)
{
	(void)state;
	struct reference_ground ground = made(5, 5, 1);
	struct deform_params params = with(DEFORM_SCM, "dry_sand");
	double moved, steep = tan(params.soils[0].repose), spike = 4;
	/* Only what is loose may slide: all of it; then half a metre of it. */
	for (int loose = 0; loose < 2; loose++) {
		memset(ground.offset, 0, 25 * sizeof *ground.offset);
		memset(ground.heaped, 0, 25 * sizeof *ground.heaped);
		ground.offset[12] = spike;
		ground.heaped[12] = loose == 0 ? spike : 0.5;
		assert_int_equal(reference_slide(&ground, &params, 1, 0, &moved), STATUS_OK);
		double axial = fmin(spike - steep, loose == 0 ? spike : 0.5) / 8;
		double diagonal = fmin(spike - sqrt(2) * steep, loose == 0 ? spike : 0.5) / 8;
		assert_true(fabs(ground.offset[13] - axial) < 1e-15 && fabs(ground.offset[7] - axial) < 1e-15);
		assert_true(fabs(ground.offset[18] - diagonal) < 1e-15 && fabs(ground.heaped[6] - diagonal) < 1e-15);
		assert_true(ground.offset[14] == 0);
		assert_true(fabs(ground.offset[12] - (spike - 4 * axial - 4 * diagonal)) < 1e-14);
		assert_true(fabs(moved - 4 * axial - 4 * diagonal) < 1e-14);
	}
	/* What is tolerated stays, to the last bit of it; a hair more, and it slides as ever. */
	for (int more = 0; more < 2; more++) {
		memset(ground.offset, 0, 25 * sizeof *ground.offset);
		ground.offset[12] = ground.heaped[12] = steep + 0.25 + more * 1e-9;
		params.tolerance = 0.25;
		assert_int_equal(reference_slide(&ground, &params, 1, 0, &moved), STATUS_OK);
		assert_true(fabs(ground.offset[13] - more * 0.25 / 8) < 1e-9 && ground.offset[6] == 0);
	}
	params.tolerance = 0;
	memset(ground.heaped, 0, 25 * sizeof *ground.heaped);
	/* A held post neither gives nor takes, a hole and the rim take nothing. */
	memset(ground.offset, 0, 25 * sizeof *ground.offset);
	ground.offset[12] = ground.heaped[12] = spike;
	ground.contact[13] = REFERENCE_HELD;
	ground.hole[11] = true;
	ground.written = (struct post_rect){0, 2, 5, 5};
	assert_int_equal(reference_slide(&ground, &params, 1, 0, &moved), STATUS_OK);
	assert_true(ground.offset[13] == 0 && ground.offset[11] == 0 && ground.offset[7] == 0 && ground.offset[17] > 0);
	ground.contact[12] = REFERENCE_HELD;
	double before = ground.offset[12];
	assert_int_equal(reference_slide(&ground, &params, 1, 0, &moved), STATUS_OK);
	assert_true(ground.offset[12] == before);
	reference_ground_finish(&ground);
}

static void sumner_sheds_a_share_of_the_mean(void **state)
{
	(void)state;
	struct reference_ground ground = made(5, 5, 1);
	struct deform_params params = with(DEFORM_SUMNER, "mud"); /* out and stop 1.1, in 1.57, roughness 0.2 */
	double moved, steep = tan(1.1);
	/* Six neighbours 4 m lower, two 1 m lower: these are not too steep. */
	ground.offset[12] = 4;
	ground.offset[11] = ground.offset[13] = 3;
	assert_int_equal(reference_slide(&ground, &params, 1, 0, &moved), STATUS_OK);
	assert_true(4 > steep * sqrt(2) && 3 > steep && 1 < steep);
	double each = 0.2 * 4 / 6;
	assert_true(fabs(ground.offset[12] - (4 - 0.8)) < 1e-14);
	/* It takes its share; 11 and 13 shed to their own, of 3 m and of fewer neighbours on the diagonal. */
	assert_true(ground.offset[7] > each - 1e-14);
	assert_true(fabs(reference_volume(&ground) - 10) < 1e-13);
	/* Beside what is held it stands at theta_in: nearly upright. */
	memset(ground.offset, 0, 25 * sizeof *ground.offset);
	ground.offset[12] = 4;
	ground.contact[12] = REFERENCE_HELD;
	assert_int_equal(reference_slide(&ground, &params, 1, 0, &moved), STATUS_OK);
	assert_true(moved == 0);
	/* And what is steeper than theta_out but not than theta_stop rests: sand. */
	struct deform_params sand = with(DEFORM_SUMNER, "sand");
	ground.contact[12] = 0;
	ground.offset[12] = 0.7;
	assert_true(0.7 > tan(0.436) && 0.7 < tan(0.8));
	assert_int_equal(reference_slide(&ground, &sand, 1, 0, &moved), STATUS_OK);
	assert_true(moved == 0);
	ground.offset[12] = 1.1;
	assert_int_equal(reference_slide(&ground, &sand, 1, 0, &moved), STATUS_OK);
	assert_true(fabs(moved - 0.22) < 1e-14);
	/* Nor what is within a tolerance of it. */
	memset(ground.offset, 0, 25 * sizeof *ground.offset);
	ground.offset[12] = 1.1;
	sand.tolerance = 1.1 - tan(sand.soils[0].theta_stop) + 1e-9;
	assert_int_equal(reference_slide(&ground, &sand, 1, 0, &moved), STATUS_OK);
	assert_true(moved == 0);
	sand.tolerance -= 2e-9;
	assert_int_equal(reference_slide(&ground, &sand, 1, 0, &moved), STATUS_OK);
	assert_true(fabs(moved - 0.22) < 1e-14);
	reference_ground_finish(&ground);
}

static void sliding_only_ever_lowers_the_potential_energy(void **state)
{
	(void)state;
	static const struct {
		enum deform_model model;
		const char *soil;
	} cases[] = {{DEFORM_SLIPPAGE, "dry_sand"}, {DEFORM_SLIPPAGE, "clayey_38"}, {DEFORM_SUMNER, "sand"}, {DEFORM_SCM, "dry_sand"}};
	for (size_t c = 0; c < sizeof cases / sizeof *cases; c++)
		for (int spike = 0; spike < 2; spike++) {
			struct reference_ground ground = made(24, 24, 0.25);
			struct deform_params params = with(cases[c].model, cases[c].soil);
			params.depth = INFINITY;
			double moved, first = 0;
			for (int i = 0; i < 24 * 24; i++)
				ground.base[i] = spike ? (i == POST(12, 12) ? 1000 : 0) : 100 * any_height();
			for (int i = 0; i < 400; i++) {
				double before = energy(&ground);
				assert_int_equal(reference_slide(&ground, &params, 1, 0, &moved), STATUS_OK);
				assert_true(energy(&ground) <= before * (1 + 1e-15));
				first = i == 0 ? moved : first;
			}
			assert_true(first > 1 && moved < first / 2);
			assert_true(fabs(reference_volume(&ground)) < 1e-9);
			reference_ground_finish(&ground);
		}
}

TEST_PROGRAM(reference_laws)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(soil_is_neither_made_nor_lost),
		cmocka_unit_test(what_is_lifted_goes_around_by_its_distance),
		cmocka_unit_test(a_wheel_lays_beside_its_way_and_a_sledge_ahead),
		cmocka_unit_test(an_iteration_slides_an_eighth_of_what_is_too_steep),
		cmocka_unit_test(sumner_sheds_a_share_of_the_mean),
		cmocka_unit_test(sliding_only_ever_lowers_the_potential_energy),
	};
	return cmocka_run_group_tests_name("deform/reference_laws", tests, NULL, NULL);
}
