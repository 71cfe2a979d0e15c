/* The codec of tiles: every post back, whatever the posts. That hostile bytes do no harm: tests/fuzz/blob.c. */
#include "fixture.h"

#include "store/codec_kernels.h"
#include "store/codec_widths.h"
#include "../support/program.h"

#define CODEC_SIDE 65
#define CODEC_POSTS (CODEC_SIDE * CODEC_SIDE)

static uint64_t random_state = 88172645463325252ull;

static uint32_t random_bits(void)
{
	random_state ^= random_state << 13;
	random_state ^= random_state >> 7;
	random_state ^= random_state << 17;
	return (uint32_t)(random_state >> 16);
}

enum pattern { NOISE, SMOOTH, FLAT, STEPS, EXTREMES, SPARSE, SCALED, FAR_SCALED, PATTERNS };

static void fill(int32_t *posts, enum pattern pattern, uint32_t side)
{
	static const int32_t extremes[] = {INT32_MIN + 1, INT32_MAX, 0, -1, 1, INT32_MIN + 2};
	for (uint32_t i = 0; i < side * side; i++) {
		uint32_t x = i % side, y = i / side;
		switch (pattern) {
		case NOISE:
			posts[i] = (int32_t)random_bits();
			break;
		case SMOOTH:
			posts[i] = (int32_t)(1e6 + 2e4 * sin(x / 20.0) * cos(y / 15.0)) + (int32_t)(random_bits() % 8);
			break;
		case FLAT:
			posts[i] = -7;
			break;
		case STEPS:
			posts[i] = (int32_t)(x / 16 * 1000 + y / 16 * 77);
			break;
		case SCALED: /* multiples of 512 beside a number that is none */
			posts[i] = 77 + 512 * ((int32_t)(1e4 * sin(x / 20.0)) + (int32_t)(random_bits() % 8));
			break;
		case FAR_SCALED: /* of the highest bit alone */
			posts[i] = random_bits() % 2 ? INT32_MAX : -1;
			break;
		case EXTREMES:
			posts[i] = extremes[random_bits() % 6];
			break;
		default:
			posts[i] = random_bits() % 50 == 0 ? (int32_t)(random_bits() % 100000) - 50000 : 0;
		}
	}
}

enum hole { HOLE_NONE, HOLE_SOME, HOLE_BLOCK, HOLE_EDGE, HOLE_ALL, HOLES };

static void punch(int32_t *posts, enum hole hole, uint32_t side)
{
	for (uint32_t i = 0; i < side * side; i++) {
		uint32_t x = i % side, y = i / side;
		if ((hole == HOLE_SOME && random_bits() % 7 == 0) ||
		    (hole == HOLE_BLOCK && x >= side / 4 && x < side / 2 && y >= side / 4 && y < side / 2) ||
		    (hole == HOLE_EDGE && (x > side / 3 || y > side / 2)) || hole == HOLE_ALL)
			posts[i] = CODEC_NODATA;
	}
}

/* Every second post, into the upper right quarter of a tile; nothing else of it is written. */
static void check_half(struct codec *codec, int64_t id, const void *bytes, size_t size, const int32_t *posts, int32_t *back)
{
	const size_t side = codec->side, half = (side - 1) / 2;
	int32_t *whole = malloc(side * side * sizeof *whole);
	memset(back, 0x33, side * side * sizeof *back);
	assert_true(store_codec_decode_half(codec, id, bytes, size, back + half * side + half, side, whole));
	for (size_t y = 0; y < side; y++)
		for (size_t x = 0; x < side; x++)
			assert_int_equal(back[y * side + x], x < half || y < half ? 0x33333333 : posts[2 * (y - half) * side + 2 * (x - half)]);
	free(whole);
}

/* By both kinds of inner loops, whichever this machine would choose. */
static void check_decode(struct codec *codec, int64_t id, const void *bytes, size_t size, const int32_t *posts)
{
	const struct codec_kernels *kernels[] = {&store_codec_plain, store_codec_kernels_best()};
	size_t count = (size_t)codec->side * codec->side;
	int32_t *back = malloc(count * sizeof *back);
	for (int i = 0; i < 2; i++) {
		codec->kernels = kernels[i];
		memset(back, 0x33, count * sizeof *back);
		assert_true(store_codec_decode(codec, id, bytes, size, back));
		assert_memory_equal(posts, back, count * sizeof *posts);
		check_half(codec, id, bytes, size, posts, back);
	}
	free(back);
}

static void every_post_comes_back(void **state)
{
	static const uint32_t sides[] = {9, 17, 65, 257};
	bool seen[CODEC_COUNT] = {false};
	for (size_t s = 0; s < 4; s++)
		for (int effort = CODEC_FAST; effort < CODEC_EFFORTS; effort++) {
			uint32_t side = sides[s];
			struct codec codec;
			assert_ok(store_codec_init(&codec, side, (enum codec_effort)effort));
			int32_t *posts = malloc(side * side * sizeof *posts);
			for (int pattern = 0; pattern < PATTERNS; pattern++)
				for (int hole = 0; hole < HOLES; hole++) {
					const void *bytes;
					size_t size;
					fill(posts, (enum pattern)pattern, side);
					punch(posts, (enum hole)hole, side);
					enum codec_id id = store_codec_encode(&codec, posts, &bytes, &size);
					assert_true(size <= store_codec_bound(&codec));
					seen[id] = true;
					void *exact = malloc(size); /* so that a read beyond it is seen */
					memcpy(exact, bytes, size);
					check_decode(&codec, id, exact, size, posts);
					free(exact);
				}
			store_codec_finish(&codec);
			free(posts);
		}
	for (int id = 0; id < CODEC_BELOW; id++)
		assert_true(seen[id]);
}

/* Widths that no terrain has, in any order, so that each is cut out at every place of a block. */
static void every_width_unpacks_alike_everywhere(void **state)
{
	const struct codec_kernels *best = store_codec_kernels_best();
	enum { BLOCKS = 40 };
	for (int round = 0; round < 2000; round++) {
		uint8_t widths[BLOCKS];
		size_t bytes = 0;
		for (int i = 0; i < BLOCKS; i++)
			bytes += 2 * (size_t)(widths[i] = (uint8_t)(random_bits() % 33));
		uint8_t *packed = malloc(bytes + CODEC_SLACK);
		for (size_t i = 0; i < bytes + CODEC_SLACK; i++)
			packed[i] = (uint8_t)random_bits();
		uint32_t plain[BLOCKS * CODEC_BLOCK], fast[BLOCKS * CODEC_BLOCK];
		store_codec_plain.unpack(packed, widths, BLOCKS, plain);
		best->unpack(packed, widths, BLOCKS, fast);
		assert_memory_equal(plain, fast, sizeof plain);
		free(packed);
	}
}

static void sums_are_alike_everywhere(void **state)
{
	const struct codec_kernels *best = store_codec_kernels_best();
	static uint32_t rest[CODEC_POSTS];
	static int32_t plain[CODEC_POSTS], fast[CODEC_POSTS];
	for (uint32_t side = 9; side <= CODEC_SIDE; side = 2 * side - 1)
		for (int slope = 0; slope < 2; slope++) {
			for (uint32_t i = 0; i < side * side; i++)
				rest[i] = random_bits();
			const int32_t *before = (const int32_t *)rest + 3 * side; /* any row */
			store_codec_plain.sum(rest, side, side, before, slope != 0, plain);
			best->sum(rest, side, 5, before, slope != 0, fast);
			best->sum(rest + 5 * side, side, side - 5, fast + 4 * side, slope != 0, fast + 5 * side);
			assert_memory_equal(plain, fast, side * side * sizeof *plain);
		}
}

static void levels_are_alike_everywhere(void **state)
{
	enum { BLOCKS = 17, ROWS = 5, STRIDE = 8 * BLOCKS + 5 };
	const struct codec_kernels *kernels[] = {&store_codec_plain, store_codec_kernels_best()};
	static int32_t coarse[8 * BLOCKS + 3], grid[2][ROWS * STRIDE], made[2][16 * BLOCKS + 1], before[STRIDE], after[STRIDE];
	for (int round = 0; round < 4000; round++) {
		uint8_t widths[2 * BLOCKS], most[2];
		uint8_t packed[2 * BLOCKS * 32 + CODEC_SLACK];
		const size_t count = 1 + random_bits() % BLOCKS;
		const unsigned widest = round % 3 == 0 ? 33 : round % 3 == 1 ? 17 : 26;
		const bool cubic = random_bits() % 2;
		const uint8_t *end[2][3];
		for (int i = 0; i < 2 * BLOCKS; i++)
			widths[i] = (uint8_t)(random_bits() % widest);
		for (size_t i = 0; i < sizeof packed; i++)
			packed[i] = (uint8_t)random_bits();
		for (int i = 0; i < 8 * BLOCKS + 3; i++)
			coarse[i] = (int32_t)random_bits() >> round % 32;
		for (int i = 0; i < STRIDE; i++) {
			before[i] = (int32_t)random_bits();
			after[i] = (int32_t)random_bits();
		}
		for (int i = 0; i < ROWS * STRIDE; i++)
			grid[0][i] = grid[1][i] = (int32_t)random_bits() >> round % 32;
		for (int k = 0; k < 2; k++) {
			end[k][0] = kernels[k]->spread(coarse + 1, packed, widths, count, cubic, made[k]);
			end[k][1] = kernels[k]->between(grid[k], STRIDE, before, after, packed, widths, count, cubic);
		}
		assert_memory_equal(made[0], made[1], 16 * count * sizeof *made[0]);
		assert_memory_equal(grid[0], grid[1], sizeof grid[0]);
		for (int k = 0; k < 2; k++)
			end[k][2] = kernels[k]->level(packed, widths, count, made[k]);
		assert_memory_equal(made[0], made[1], 8 * count * sizeof *made[0]);
		for (int i = 0; i < 3; i++)
			assert_ptr_equal(end[0][i], end[1][i]);
		assert_int_equal(end[0][2] - packed, kernels[1]->total(widths, count, &most[1]));
		assert_int_equal(kernels[0]->total(widths, 2 * BLOCKS, &most[0]), kernels[1]->total(widths, 2 * BLOCKS, &most[1]));
		assert_int_equal(most[0], most[1]);
	}
}

/* Every set of symbols comes back, in few and in many; what is cut short or has another code does no harm. */
static void widths_come_back(void **state)
{
	enum { COUNT = 5000 };
	static uint8_t symbols[COUNT], back[COUNT];
	for (int round = 0; round < 400; round++) {
		const size_t count = round < 200 ? 8 + (size_t)round : COUNT - (size_t)round;
		const unsigned used = 1 + random_bits() % WIDTHS_SYMBOLS;
		uint32_t counts[WIDTHS_SYMBOLS] = {0};
		struct widths_code code;
		struct widths_table table;
		for (size_t i = 0; i < count; i++) {
			unsigned symbol = random_bits() % used;
			symbols[i] = (uint8_t)(round % 2 && random_bits() % 16 ? symbol / 16 : symbol);
			counts[symbols[i]]++;
		}
		store_widths_plan(counts, &code);
		uint8_t *bytes = malloc(store_widths_bound(count)), *to = store_widths_put_table(&code, bytes);
		const uint8_t *from = bytes;
		size_t left = (size_t)(to - bytes);
		assert_true(store_widths_get_table(&from, &left, &table));
		assert_ptr_equal(from, to);
		size_t size = (size_t)(store_widths_put(&code, symbols, count, to) - to);
		assert_true((size_t)(to - bytes) + size <= store_widths_bound(count));
		uint8_t *exact = malloc(size); /* so that a read beyond it is seen */
		memcpy(exact, to, size);
		memset(back, 0xee, sizeof back);
		assert_true(store_widths_get(&table, exact, size, back, count));
		assert_memory_equal(symbols, back, count);
		for (size_t i = count; i < COUNT; i++)
			assert_int_equal(back[i], 0xee);
		bool short_one = store_widths_get(&table, exact, size / 2, back, count);
		assert_false(short_one && size / 2 < 6);
		free(exact);
		free(bytes);
	}
}

static void codes_that_are_none_are_refused(void **state)
{
	static const uint8_t bad[][6] = {
		{0}, {1, 0x01}, {66, 0x11}, /* too few symbols, too many */
		{2, 0x01}, {2, 0x21}, {4, 0x11, 0x11}, {4, 0x11, 0x10}, /* not all codes used, or more than there are */
		{3, 0x91, 0x02}, {6, 0x11, 0x11}, /* nine bits; cut short */
	};
	struct widths_table table;
	for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
		const uint8_t *from = bad[i];
		size_t left = i + 1 < sizeof bad / sizeof *bad ? 6 : 3;
		assert_false(store_widths_get_table(&from, &left, &table));
	}
}

static void a_hole_costs_the_posts_around_it_little(void **state)
{
	struct codec codec;
	assert_ok(store_codec_init(&codec, CODEC_SIDE, CODEC_FAST));
	static int32_t posts[CODEC_POSTS];
	const void *bytes;
	size_t whole, holed;
	fill(posts, SMOOTH, CODEC_SIDE);
	store_codec_encode(&codec, posts, &bytes, &whole);
	punch(posts, HOLE_BLOCK, CODEC_SIDE);
	store_codec_encode(&codec, posts, &bytes, &holed);
	assert_true(holed < whole + whole / 2);
	store_codec_finish(&codec);
}

static void smooth_terrain_takes_less_than_a_byte_a_post(void **state)
{
	struct codec codec;
	assert_ok(store_codec_init(&codec, CODEC_SIDE, CODEC_FAST));
	static int32_t posts[CODEC_POSTS];
	const void *bytes;
	size_t size;
	fill(posts, SMOOTH, CODEC_SIDE);
	store_codec_encode(&codec, posts, &bytes, &size);
	assert_true(size < CODEC_POSTS);
	store_codec_finish(&codec);
}

/* Between rows it bends: where the difference of two rows grows from post to post, by as much each time. */
/* A country in whole metres takes no more bytes in a store whose step an inset made finer. */
static void a_common_factor_of_two_costs_one_byte(void **state)
{
	struct codec codec;
	static int32_t posts[CODEC_POSTS], scaled[CODEC_POSTS];
	const void *bytes;
	size_t plain, more;
	for (int effort = CODEC_FAST; effort < CODEC_EFFORTS; effort++)
		for (enum hole hole = HOLE_NONE; hole <= HOLE_BLOCK; hole++) {
			assert_ok(store_codec_init(&codec, CODEC_SIDE, (enum codec_effort)effort));
			fill(posts, SMOOTH, CODEC_SIDE);
			punch(posts, hole, CODEC_SIDE);
			for (int i = 0; i < CODEC_POSTS; i++)
				scaled[i] = posts[i] == CODEC_NODATA ? CODEC_NODATA : posts[i] * 512;
			store_codec_encode(&codec, posts, &bytes, &plain);
			store_codec_encode(&codec, scaled, &bytes, &more);
			assert_int_equal(more, plain + 1);
			store_codec_finish(&codec);
		}
}

static void the_order_of_residuals_that_packs_better_is_taken(void **state)
{
	struct codec codec;
	assert_ok(store_codec_init(&codec, CODEC_SIDE, CODEC_FAST));
	static int32_t posts[CODEC_POSTS];
	const void *bytes;
	size_t bent, rough;
	for (int32_t i = 0; i < CODEC_POSTS; i++) {
		int32_t x = i % CODEC_SIDE, y = i / CODEC_SIDE;
		posts[i] = 3 * x * x * y;
	}
	store_codec_encode(&codec, posts, &bytes, &bent);
	assert_true(bent < CODEC_POSTS * 3 / 4); /* else ten bits a post */
	for (int32_t i = 0; i < CODEC_POSTS; i++)
		posts[i] = (int32_t)(random_bits() % 16);
	store_codec_encode(&codec, posts, &bytes, &rough);
	assert_true(rough < CODEC_POSTS * 7 / 8 + 600); /* six bits and widths; else seven */
	store_codec_finish(&codec);
}

static void lengths_that_do_not_fit_are_refused(void **state)
{
	struct codec codec;
	assert_ok(store_codec_init(&codec, CODEC_SIDE, CODEC_FAST));
	static int32_t posts[CODEC_POSTS], back[CODEC_POSTS];
	const void *bytes;
	size_t size;
	fill(posts, NOISE, CODEC_SIDE);
	assert_int_equal(store_codec_encode(&codec, posts, &bytes, &size), CODEC_PACKED);
	uint8_t *blob = malloc(size + 1);
	memcpy(blob, bytes, size);
	assert_false(store_codec_decode(&codec, CODEC_PACKED, blob, size - 1, back));
	assert_false(store_codec_decode(&codec, CODEC_PACKED, blob, size + 1, back));
	assert_false(store_codec_decode(&codec, CODEC_PACKED, blob, 0, back));
	assert_false(store_codec_decode(&codec, CODEC_LZ4, blob, size, back));
	assert_false(store_codec_decode(&codec, CODEC_CONSTANT, blob, size, back));
	assert_false(store_codec_decode(&codec, CODEC_COUNT, blob, size, back));
	assert_false(store_codec_decode(&codec, CODEC_ZSTD, blob, size, back));
	uint8_t *widths = blob + 5; /* after the flags and the first post; noise needs a byte each */
	assert_true(widths[0] == 32 && widths[1] == 32);
	widths[0] = 33; /* the second makes up for it */
	widths[1] = 31;
	assert_false(store_codec_decode(&codec, CODEC_PACKED, blob, size, back));
	widths[0] = widths[1] = 32;
	assert_true(store_codec_decode(&codec, CODEC_PACKED, blob, size, back));
	blob[0] |= 8; /* an unknown flag */
	assert_false(store_codec_decode(&codec, CODEC_PACKED, blob, size, back));
	free(blob);
	store_codec_finish(&codec);
}

static void levels_that_are_cut_short_or_changed_are_refused(void **state)
{
	struct codec codec;
	static int32_t posts[CODEC_POSTS], back[CODEC_POSTS];
	const void *bytes;
	size_t size, refused = 0;
	assert_ok(store_codec_init(&codec, CODEC_SIDE, CODEC_GROUND));
	fill(posts, SMOOTH, CODEC_SIDE);
	punch(posts, HOLE_BLOCK, CODEC_SIDE);
	assert_int_equal(store_codec_encode(&codec, posts, &bytes, &size), CODEC_LEVELS);
	uint8_t *blob = malloc(size + 1);
	memcpy(blob, bytes, size);
	assert_true(store_codec_decode(&codec, CODEC_LEVELS, blob, size, back));
	assert_false(store_codec_decode(&codec, CODEC_LEVELS, blob, size + 1, back));
	for (size_t some = 0; some < size; some++) {
		uint8_t *exact = malloc(some);
		memcpy(exact, blob, some);
		assert_false(store_codec_decode(&codec, CODEC_LEVELS, exact, some, back));
		free(exact);
	}
	for (size_t i = 0; i < 400; i++) /* what is changed decodes to other posts, or not at all */
		for (int bit = 0; bit < 8; bit++) {
			blob[i] ^= (uint8_t)(1u << bit);
			refused += !store_codec_decode(&codec, CODEC_LEVELS, blob, size, back);
			blob[i] ^= (uint8_t)(1u << bit);
		}
	assert_in_range(refused, 400, 3200);
	free(blob);
	store_codec_finish(&codec);
}

static void failed_allocations_are_told(void **state)
{
	struct codec codec;
	for (uint64_t nth = 1; nth <= 10; nth++) {
		mem_fail_nth(nth, 0);
		assert_status(store_codec_init(&codec, CODEC_SIDE, CODEC_FAST), STATUS_FAILED);
	}
	mem_fail_nth(0, 0);
}

TEST_PROGRAM(codec)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_post_comes_back),
		cmocka_unit_test(every_width_unpacks_alike_everywhere),
		cmocka_unit_test(sums_are_alike_everywhere),
		cmocka_unit_test(levels_are_alike_everywhere),
		cmocka_unit_test(widths_come_back),
		cmocka_unit_test(codes_that_are_none_are_refused),
		cmocka_unit_test(a_hole_costs_the_posts_around_it_little),
		cmocka_unit_test(smooth_terrain_takes_less_than_a_byte_a_post),
		cmocka_unit_test(a_common_factor_of_two_costs_one_byte),
		cmocka_unit_test(the_order_of_residuals_that_packs_better_is_taken),
		cmocka_unit_test(lengths_that_do_not_fit_are_refused),
		cmocka_unit_test(levels_that_are_cut_short_or_changed_are_refused),
		cmocka_unit_test(failed_allocations_are_told),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
