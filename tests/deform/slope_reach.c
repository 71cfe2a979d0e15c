/* Where the height of slopes counts, a slope that grows in one block activates the blocks in which more of its posts lie, however far
 * from the change: active blocks alone do what all blocks would do. */
#include "sliding.h"
#include "../support/program.h"

/* A bank that lies half in the first block, half in the one beside it. In the first block it is hardly steeper than phi. In the other
 * one it is steep, but low enough to be stable. Soil slides there only once the bank has grown by the pile or the pit, both far away. */
enum { SIDE_POSTS = 65, PILE = 16, PIT = 20, MILD = 24, BORDER = 32, STEEP = 36 };

static const double spacing = 0.25, mild = 32 * M_PI / 180, steep = M_PI / 3;

static struct bank {
	bool north, mirrored; /* where the other block lies: east, north; mirrored: west, south */
	bool rises;           /* towards the other block */
	double pile;          /* m */
} bank;

/* Returns how far from the beginning of the bank's first block a post lies, towards the other block. */
static int64_t along(int64_t x, int64_t y)
{
	int64_t at = bank.north ? y : x;
	return bank.mirrored ? 2 * BORDER - 1 - at : at;
}

static int32_t bank_post(int64_t x, int64_t y)
{
	double at = (double)along(x, y);
	double height = spacing * (fmax(0, fmin(at, BORDER) - MILD) * tan(mild) + fmax(0, fmin(at, STEEP) - BORDER) * tan(steep));
	return (int32_t)lrint(ldexp((bank.rises ? height : -height) + (at < PILE ? bank.pile : 0), BASE_BITS));
}

static void start_bank(struct ground *ground, int iterations)
{
	struct soil_numbers soil;
	assert_ok(soil_named("dry_sand", &soil));
	soil.cohesion = 2600;
	ground_init(ground, &(struct ground_params){.cells = 32, .tiles = 2, .spacing = spacing, .model = DEFORM_SLIPPAGE, .soils = &soil,
						    .soil_count = 1, .iterations = iterations, .relief = 100, .height = bank_post});
	assert_int_equal(ground->posts, SIDE_POSTS);
}

/* Returns the nearest post to the border, counted from it, that changed in the first block. *beyond: posts changed in the other one. */
static int64_t nearest(const struct ground *ground, bool *beyond)
{
	int64_t least = BORDER;
	*beyond = false;
	for (int64_t i = 0; i < ground->posts * ground->posts; i++) {
		int64_t at = along(i % ground->posts, i / ground->posts);
		bool changed = ground->offset[i] != 0;
		*beyond = *beyond || (changed && at >= BORDER);
		least = changed && at < BORDER && BORDER - at < least ? BORDER - at : least;
	}
	return least;
}

/* Runs intervals until soil has slid beyond the border for some time. Both grounds stay the same. Soil slid there before any post within
 * the reach of one interval's iterations changed. */
static void run_beyond(struct ground *few, struct ground *all)
{
	int64_t near = BORDER, n = 0;
	size_t visited = 0, possible = 0;
	bool beyond = false;
	for (int64_t left = 5; left > 0; left -= beyond, n++) {
		visited += interval(few, NULL, 0);
		assert_ok(deform_wake(all->deform, all_of(all)));
		possible += interval(all, NULL, 0);
		assert_same(few, all, (int)n);
		if (!beyond)
			near = nearest(all, &beyond);
		assert_true(n < 40);
	}
	assert_true(near > few->params.iterations + 2);
	assert_true(visited < possible);
}

static void a_pile_that_slides_onto_a_slope_activates_its_other_block(void **state)
{
	(void)state;
	need_gpu();
	for (int round = 0; round < 8; round++) {
		struct ground few, all;
		bank = (struct bank){.pile = 8, .north = round & 1, .mirrored = round & 2};
		start_bank(&few, round < 4 ? 1 : 2);
		start_bank(&all, round < 4 ? 1 : 2);
		for (int64_t i = 0; i < 3; i++) {
			int64_t column = bank.mirrored;
			assert_ok(deform_wake_block(few.deform, bank.north ? (struct soil_block){i, column} : (struct soil_block){column, i}));
		}
		run_beyond(&few, &all);
		ground_finish(&few);
		ground_finish(&all);
	}
}

/* Half of the rounds: the contact's flags tell which blocks become active. The others: all blocks near what it wrote do. */
static void a_pit_at_the_foot_of_a_slope_activates_its_other_block(void **state)
{
	const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.6};
	(void)state;
	need_gpu();
	for (int round = 0; round < 8; round++) {
		struct ground few, all;
		bank = (struct bank){.rises = true, .north = round & 1, .mirrored = round & 2};
		const bool flags = round < 4;
		start_bank(&few, 1);
		start_bank(&all, 1);
		double at = bank.mirrored ? 2 * BORDER - 1 - PIT : PIT, aside = 10;
		struct deform_contact dig = ground_stand(&few, &ball, bank.north ? aside : at, bank.north ? at : aside, ball.radius - 1);
		ground_sweep(&few, &dig);
		ground_sweep(&all, &dig);
		assert_int_equal(few.window_count, 1);
		assert_ok(flags ? deform_wake_swept(few.deform, &few.windows[0], 0) : deform_wake(few.deform, few.windows[0].write));
		run_beyond(&few, &all);
		ground_finish(&few);
		ground_finish(&all);
	}
}

TEST_PROGRAM(slope_reach)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_pile_that_slides_onto_a_slope_activates_its_other_block),
		cmocka_unit_test(a_pit_at_the_foot_of_a_slope_activates_its_other_block),
	};
	return cmocka_run_group_tests_name("deform/slope_reach", tests, open_gpu, close_gpu);
}
