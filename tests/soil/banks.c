/* Banks of cohesive soil come to rest at the angle at which a slope of their height is just stable, by Culmann's wedge. */
#include "blocks.h"
#include "../support/near.h"
#include "../support/program.h"
#include "soil/stability.h"

#define WITHIN (1.0 * M_PI / 180) /* of Culmann's angle */

/* A straight bank across a strip of ground. */
struct bank {
	const char *soil;
	double cohesion;                      /* Pa; below 0: the soil's own */
	double spacing, height, face, heading; /* m; m; degrees; degrees from a row of posts */
};

static struct soil_numbers soil_of(const struct bank *bank)
{
	struct soil_numbers soil;
	assert_ok(soil_named(bank->soil, &soil));
	soil.cohesion = bank->cohesion < 0 ? soil.cohesion : bank->cohesion;
	return soil;
}

/* Returns the row through the middle of the ground. Across rows a bank needs a strip of one block alone. */
static double middle_row(const struct bank *bank, const struct field *field)
{
	return bank->heading == 0 ? SOIL_BLOCK / 2 : (double)field->posts / 2;
}

/* Returns how far a post lies behind the middle of the face, m. */
static double behind(const struct bank *bank, const struct field *field, double x, double y)
{
	const double turn = bank->heading * M_PI / 180, middle = (double)field->posts / 2 - 0.37;
	return ((x - middle) * cos(turn) + (y - middle) * sin(turn)) * bank->spacing;
}

static void start(const struct bank *bank, struct field *field)
{
	const struct soil_numbers soil = soil_of(bank);
	const double rest = fmin(bank->face * M_PI / 180, atan(1 / fmax(0.1, soil_critical_cotangent(&soil, bank->height))));
	const int64_t blocks = (int64_t)ceil((3 * bank->height / tan(rest) + 2 * bank->height) / bank->spacing / SOIL_BLOCK) + 2, posts = blocks * SOIL_BLOCK;
	*field = (struct field){.posts = posts, .world = {0, 0, posts, posts}};
	field->base = ground_room(posts * posts, 4);
	field->offset = ground_room(posts * posts, 4);
	field->slope = ground_room(posts * posts, 4);
	field->contact = ground_room(posts * posts, 1);
	for (int64_t i = 0; i < posts * posts; i++) {
		const double at = behind(bank, field, (double)(i % posts), (double)(i / posts)) * tan(bank->face * M_PI / 180);
		const bool beyond = bank->heading == 0 && i / posts >= SOIL_BLOCK;
		field->base[i] = beyond ? BASE_NODATA : (int32_t)lrint(ldexp(10 - fmax(0, fmin(bank->height, at + bank->height / 2)), BASE_BITS));
	}
	const struct post_rect strip = {0, 0, posts, bank->heading == 0 ? SOIL_BLOCK : posts};
	assert_ok(soil_active_add_near(&field->active, field->world, 0, strip));
}

static double height_at(const struct field *field, double x, double y)
{
	const int64_t i = (int64_t)floor(x), j = (int64_t)floor(y);
	double sum = 0;
	for (int k = 0; k < 4; k++) {
		const size_t at = (size_t)((j + (k >> 1)) * field->posts + i + (k & 1));
		const double east = x - (double)i, north = y - (double)j;
		sum += (k & 1 ? east : 1 - east) * (k >> 1 ? north : 1 - north) * (ldexp(field->base[at], -BASE_BITS) + ldexp(field->offset[at], -OFFSET_BITS));
	}
	return sum;
}

/* Returns the mean angle of the face between a fifth and four fifths of its height, rad. */
static double angle_of(const struct bank *bank, const struct field *field)
{
	const double turn = bank->heading * M_PI / 180, middle = (double)field->posts / 2;
	double from = NAN, to = NAN;
	for (double along = -middle / 2; along < middle / 2; along += 0.1) {
		const double fallen = 10 - height_at(field, middle + along * cos(turn), middle_row(bank, field) + along * sin(turn));
		from = isnan(from) && fallen > 0.2 * bank->height ? along : from;
		to = isnan(to) && fallen > 0.8 * bank->height ? along : to;
	}
	return atan(0.6 * bank->height / ((to - from) * bank->spacing));
}

/* Returns the sum of offsets. The bank comes to rest. */
static int64_t settle(const struct bank *bank, struct field *field, enum cut cut, int intervals)
{
	const struct soil_numbers soil = soil_of(bank);
	struct soil_sliding rule;
	int64_t sum = 0;
	soil_sliding_prepare(&(struct soil_sliding_params){.soils = &soil, .soil_count = 1, .spacing = bank->spacing, .critical = soil_critical_difference_cohesive,
							   .cotangent = soil_critical_cotangent, .iterations = 8, .depth = INFINITY, .relief = 100}, &rule);
	for (int n = 0; n < intervals && field->active.count > 0; n++)
		interval_on_cpu(&rule, field, cut);
	for (int64_t i = 0; i < field->posts * field->posts; i++)
		sum += field->offset[i];
	return sum;
}

static void finish_field(struct field *field)
{
	mem_free(field->base);
	mem_free(field->offset);
	mem_free(field->slope);
	mem_free(field->contact);
	soil_block_set_finish(&field->active);
}

static void check(const struct bank *bank)
{
	const struct soil_numbers soil = soil_of(bank);
	const double stable = atan(1 / soil_critical_cotangent(&soil, bank->height)), wanted = fmin(bank->face * M_PI / 180, stable > 0 ? stable : M_PI / 2);
	struct field field;
	start(bank, &field);
	const int64_t sum = settle(bank, &field, ONE_REGION, 20000);
	const double angle = angle_of(bank, &field);
	assert_int_equal(field.active.count, 0);
	assert_int_equal(sum, 0);
	if (!(fabs(angle - wanted) <= WITHIN))
		fail_msg("%s, %g Pa, %g m apart, %g m high, %g degrees, heading %g: rests at %.2f degrees, not %.2f", bank->soil, soil.cohesion, bank->spacing, bank->height,
			 bank->face, bank->heading, angle * 180 / M_PI, wanted * 180 / M_PI);
	finish_field(&field);
}

static void a_bank_comes_to_rest_at_culmanns_angle_for_its_height(void **state)
{
	(void)state;
	static const struct bank banks[] = {
		{"dry_sand", -1, 0.06, 1, 50, 0}, {"dry_sand", -1, 0.06, 1, 90, 0}, {"dry_sand", -1, 0.06, 2, 70, 0}, {"dry_sand", -1, 0.12, 2, 80, 22.5},
		{"dry_sand", -1, 0.12, 2, 60, 45}, {"upland_loam_51", -1, 0.06, 3, 80, 0}, {"clayey_38", -1, 0.06, 2, 85, 0}, {"dry_sand", -1, 0.03, 1, 75, 0},
		{"dry_sand", 300, 0.06, 1, 60, 0}, {"lete_sand", -1, 0.12, 2, 70, 22.5},
	};
	for (size_t i = 0; i < sizeof banks / sizeof *banks; i++)
		check(&banks[i]);
}

static void a_high_bank_comes_to_rest_at_culmanns_angle_at_every_spacing(void **state)
{
	(void)state;
	static const struct bank banks[] = {
		{"dry_sand", -1, 0.06, 3, 60, 0}, {"dry_sand", -1, 0.03, 1.5, 60, 0}, {"dry_sand", -1, 0.015, 1, 70, 0},
	};
	for (size_t i = 0; i < sizeof banks / sizeof *banks; i++)
		check(&banks[i]);
}

/* One region or many: the same bits, on the way and at rest. */
static void a_falling_bank_is_the_same_in_any_cut(void **state)
{
	(void)state;
	const struct bank bank = {"dry_sand", -1, 0.12, 2, 70, 22.5};
	struct field whole, cut;
	start(&bank, &whole);
	start(&bank, &cut);
	for (int n = 0; n < 12; n++) {
		settle(&bank, &whole, ONE_REGION, 3);
		settle(&bank, &cut, n % 2 ? RUNS : ONE_BLOCK_EACH, 3);
		const size_t bytes = (size_t)(whole.posts * whole.posts) * 4;
		assert_memory_equal(whole.offset, cut.offset, bytes);
		assert_memory_equal(whole.slope, cut.slope, bytes);
		assert_int_equal(whole.active.count, cut.active.count);
	}
	finish_field(&whole);
	finish_field(&cut);
}

/* Where undisturbed ground is stable nothing is kept of it, and nothing falls. */
static void an_undisturbed_bank_stays_and_keeps_nothing(void **state)
{
	(void)state;
	const struct bank bank = {"dry_sand", -1, 0.06, 3, 80, 0};
	const struct soil_numbers soil = soil_of(&bank);
	struct soil_sliding rule;
	struct field field;
	soil_sliding_prepare(&(struct soil_sliding_params){.soils = &soil, .soil_count = 1, .spacing = bank.spacing, .critical = soil_critical_difference_cohesive,
							   .cotangent = soil_critical_cotangent, .iterations = 2, .depth = INFINITY, .relief = 100,
							   .undisturbed_stable = true}, &rule);
	start(&bank, &field);
	interval_on_cpu(&rule, &field, ONE_REGION);
	assert_int_equal(field.active.count, 0);
	for (int64_t i = 0; i < field.posts * field.posts; i++)
		assert_true(field.offset[i] == 0 && field.slope[i] == 0);
	finish_field(&field);
}

TEST_PROGRAM(banks)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_bank_comes_to_rest_at_culmanns_angle_for_its_height),
		cmocka_unit_test(a_high_bank_comes_to_rest_at_culmanns_angle_at_every_spacing),
		cmocka_unit_test(a_falling_bank_is_the_same_in_any_cut),
		cmocka_unit_test(an_undisturbed_bank_stays_and_keeps_nothing),
	};
	return cmocka_run_group_tests_name("soil/banks", tests, NULL, NULL);
}
