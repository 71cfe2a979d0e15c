/* Sliding along lines: the laws that sliding keeps, and how fast it comes to rest. tests/soil/sliding.c compares its bits with the CPU's. */
#include "slab.h"
#include "../support/program.h"

static bool is_still(const struct slab *of, int i)
{
	return of->base[i] == BASE_NODATA || (of->contacts[i] & HELD) != 0;
}

static int64_t most(int64_t a, int64_t b)
{
	return a > b ? a : b;
}

/* The slab slides along lines, but the iteration after that does not count. */
static void slide_along_lines(struct ground *ground)
{
	slide_in_scratch(ground);
	gpu_texture_read(ground->deform->heights[0], 0, rect_of(RIM, RIM, N, N), slab.offset);
	for (int i = 0; i < N * N; i++)
		slab.offset[i] = is_still(&slab, i) ? before.offset[i] : (int32_t)((uint32_t)slab.offset[i] - 4u * (uint32_t)slab.base[i]);
}

static void start_round(struct ground *ground, int round)
{
	static struct soil_numbers soils[2];
	assert_ok(soil_named("dry_sand", &soils[0]));
	assert_ok(soil_named("snow_us", &soils[1]));
	soils[0].cohesion = 0;
	soils[1].unit_weight = 3000;
	soils[1].friction_angle = round % 7 == 6 ? 0 : soils[1].friction_angle;
	along_lines = true;
	stands = round % 4 > 1;
	tolerance = round % 5 == 4 ? 0.01 : 0;
	start(ground, DEFORM_SLIPPAGE, round % 2 ? 0.0625 : 0.5, 1, round >= 40 ? 0.2 : 0, soils, 1 + (round % 3 == 2));
	for (int i = 0; i < N * N; i++) {
		int rough = 1 << (4 + round % 17); /* to 4 m */
		bool hole = any_word() % 32 == 0;
		slab.base[i] = hole ? BASE_NODATA : (40 << 18) + (int32_t)(any_share() * rough);
		slab.offset[i] = hole ? 0 : (int32_t)(any_share() * rough);
		slab.contacts[i] = any_word() % 16 == 0 ? HELD : 0;
		slab.classes[i] = (uint8_t)(any_word() % (uint32_t)(1 + (round % 3 == 2)));
	}
	before = slab;
}

/* Where relaxing soil has a bottom too (from round 40 on): nothing slides from below it. */
static void the_sum_stays_and_the_potential_energy_never_rises(void **state)
{
	int64_t moved = 0;
	(void)state;
	need_gpu();
	for (int round = 0; round < 80; round++) {
		struct ground ground;
		start_round(&ground, round);
		wide sum = sum_of(&slab);
		int32_t least = round >= 40 ? -(int32_t)(0.2 * (1 << 20)) : INT32_MIN;
		wide energy = energy_of(&slab);
		for (int n = 0; n < 6; n++) {
			before = slab;
			if (n % 2 == 0)
				slide_along_lines(&ground);
			else
				slide_on_gpu(&ground);
			assert_true(sum_of(&slab) == sum);
			assert_true(energy_of(&slab) <= energy);
			energy = energy_of(&slab);
			for (int i = 0; i < N * N; i++) {
				moved += slab.offset[i] != before.offset[i];
				assert_true(slab.offset[i] >= before.offset[i] || slab.offset[i] >= least);
			}
		}
		ground_finish(&ground);
	}
	assert_true(moved > 10000);
}

/* A column of soil: how many calls until no difference is more than 1 mm too high. */
static int calls_to_rest(double spacing)
{
	struct ground ground;
	struct soil_numbers soil;
	assert_ok(soil_named("dry_sand", &soil));
	soil.cohesion = 0;
	stands = false;
	tolerance = 0;
	start(&ground, DEFORM_SLIPPAGE, spacing, 1, 0, &soil, 1);
	int wide_posts = (int)lrint(0.4 / spacing), calls = 0;
	int64_t critical[2] = {ground.deform->sliding.classes[0].critical[0], ground.deform->sliding.classes[0].critical[1]}, over = INT64_MAX;
	memset(&slab, 0, sizeof slab);
	for (int i = 0; i < N * N; i++)
		if (abs(i % N - N / 2) <= wide_posts / 2 && abs(i / N - N / 2) <= wide_posts / 2)
			slab.offset[i] = (int32_t)(0.3 * (1 << 20));
	for (; over > 1 << 10 && calls < 2000; calls++) {
		slide_on_gpu(&ground);
		over = 0;
		for (int i = N + 1; i < N * (N - 1) - 1; i++)
			for (int k = 0; k < 9; k++)
				if (k != 4)
					over = most(over, height_of(&slab, i) - height_of(&slab, i + k % 3 - 1 + (k / 3 - 1) * N) - critical[k % 2 == 0]);
	}
	ground_finish(&ground);
	return calls;
}

static void finer_posts_come_to_rest_in_few_more_calls(void **state)
{
	int calls[3], by_posts[3];
	(void)state;
	need_gpu();
	for (int k = 0; k < 3; k++) {
		along_lines = true;
		calls[k] = calls_to_rest(ldexp(1, -3 - k));
		along_lines = false;
		by_posts[k] = calls_to_rest(ldexp(1, -3 - k));
		print_message("posts 1/%d m: %d calls, %d from post to post\n", 8 << k, calls[k], by_posts[k]);
	}
	/* From post to post the calls grow with the square. */
	assert_true(by_posts[2] > 2 * by_posts[1] && calls[2] - calls[1] < 10 && calls[2] < by_posts[2] / 4);
}

static void ground_at_rest_stays(void **state)
{
	struct ground ground;
	(void)state;
	need_gpu();
	for (int round = 0; round < 12; round++) {
		int calls = 0;
		start_round(&ground, round);
		/* First it comes to rest by the rule from post to post alone. */
		ground.deform->params.along_lines = false;
		do {
			before = slab;
			slide_on_gpu(&ground);
		} while (memcmp(&before, &slab, sizeof slab) != 0 && ++calls < 6000);
		ground.deform->params.along_lines = true;
		slide_on_gpu(&ground);
		if (calls < 6000 && memcmp(&before, &slab, sizeof slab) != 0)
			fail_msg("round %d: it was at rest after %d calls, and moves", round, calls);
		ground_finish(&ground);
	}
}

TEST_PROGRAM(lines)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_sum_stays_and_the_potential_energy_never_rises),
		cmocka_unit_test(finer_posts_come_to_rest_in_few_more_calls),
		cmocka_unit_test(ground_at_rest_stays),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
