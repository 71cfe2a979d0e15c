/* The codec of tiles: every post back, whatever the posts; no harm, whatever the bytes. */
#include "fixture.h"

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

enum pattern { NOISE, SMOOTH, FLAT, STEPS, EXTREMES, SPARSE, PATTERNS };

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

static void every_post_comes_back(void **state)
{
	static const uint32_t sides[] = {9, 17, 65, 257};
	for (size_t s = 0; s < 4; s++) {
		uint32_t side = sides[s];
		struct codec codec;
		assert_ok(codec_init(&codec, side));
		int32_t *posts = malloc(side * side * sizeof *posts), *back = malloc(side * side * sizeof *back);
		bool seen[CODEC_COUNT] = {false};
		for (int pattern = 0; pattern < PATTERNS; pattern++)
			for (int hole = 0; hole < HOLES; hole++)
				for (int hard = 0; hard < 2; hard++) {
					const void *bytes;
					size_t size;
					fill(posts, (enum pattern)pattern, side);
					punch(posts, (enum hole)hole, side);
					enum codec_id id = codec_encode(&codec, posts, hard, &bytes, &size);
					assert_true(size <= codec_bound(&codec));
					seen[id] = true;
					void *exact = malloc(size); /* so that a read beyond it is seen */
					memcpy(exact, bytes, size);
					assert_true(codec_decode(&codec, id, exact, size, back));
					assert_memory_equal(posts, back, side * side * sizeof *posts);
					free(exact);
				}
		for (int id = 0; id < CODEC_COUNT; id++)
			assert_true(seen[id]);
		codec_finish(&codec);
		free(posts);
		free(back);
	}
}

static void a_hole_costs_the_posts_around_it_little(void **state)
{
	struct codec codec;
	assert_ok(codec_init(&codec, CODEC_SIDE));
	static int32_t posts[CODEC_POSTS];
	const void *bytes;
	size_t whole, holed;
	fill(posts, SMOOTH, CODEC_SIDE);
	codec_encode(&codec, posts, false, &bytes, &whole);
	punch(posts, HOLE_BLOCK, CODEC_SIDE);
	codec_encode(&codec, posts, false, &bytes, &holed);
	assert_true(holed < whole + whole / 2);
	codec_finish(&codec);
}

static void smooth_terrain_takes_less_than_a_byte_and_a_half_a_post(void **state)
{
	struct codec codec;
	assert_ok(codec_init(&codec, CODEC_SIDE));
	static int32_t posts[CODEC_POSTS];
	const void *bytes;
	size_t size;
	fill(posts, SMOOTH, CODEC_SIDE);
	codec_encode(&codec, posts, false, &bytes, &size);
	assert_true(size < CODEC_POSTS * 3 / 2);
	codec_finish(&codec);
}

/* Mutations of real blobs, cut and grown, under every id: only the sanitizers can tell harm. */
static void hostile_bytes_do_no_harm(void **state)
{
	struct codec codec;
	assert_ok(codec_init(&codec, CODEC_SIDE));
	static int32_t posts[CODEC_POSTS], back[CODEC_POSTS];
	int accepted = 0, refused = 0;
	for (int round = 0; round < 30000; round++) {
		const void *bytes;
		size_t size;
		fill(posts, (enum pattern)(random_bits() % PATTERNS), CODEC_SIDE);
		punch(posts, (enum hole)(random_bits() % HOLES), CODEC_SIDE);
		int64_t id = codec_encode(&codec, posts, false, &bytes, &size);
		size_t length = random_bits() % 4 == 0 ? random_bits() % (size + 64) : size;
		uint8_t *blob = malloc(length > 0 ? length : 1);
		memset(blob, 0x5a, length);
		memcpy(blob, bytes, length < size ? length : size);
		for (uint32_t i = random_bits() % 5; i > 0 && length > 0; i--) {
			size_t at = random_bits() % 3 == 0 ? random_bits() % (length < 12 ? length : 12)
							   : random_bits() % length;
			blob[at] = (uint8_t)random_bits();
		}
		if (random_bits() % 8 == 0)
			id = (int64_t)(random_bits() % 6) - 1;
		if (codec_decode(&codec, id, blob, length, back))
			accepted++;
		else
			refused++;
		free(blob);
		random_state += (uint64_t)round;
	}
	assert_true(accepted > 100 && refused > 100);
	codec_finish(&codec);
}

static void lengths_that_do_not_fit_are_refused(void **state)
{
	struct codec codec;
	assert_ok(codec_init(&codec, CODEC_SIDE));
	static int32_t posts[CODEC_POSTS], back[CODEC_POSTS];
	const void *bytes;
	size_t size;
	fill(posts, NOISE, CODEC_SIDE);
	assert_int_equal(codec_encode(&codec, posts, false, &bytes, &size), CODEC_PACKED);
	uint8_t *blob = malloc(size + 1);
	memcpy(blob, bytes, size);
	assert_false(codec_decode(&codec, CODEC_PACKED, blob, size - 1, back));
	assert_false(codec_decode(&codec, CODEC_PACKED, blob, size + 1, back));
	assert_false(codec_decode(&codec, CODEC_PACKED, blob, 0, back));
	assert_false(codec_decode(&codec, CODEC_LZ4, blob, size, back));
	assert_false(codec_decode(&codec, CODEC_CONSTANT, blob, size, back));
	assert_false(codec_decode(&codec, CODEC_COUNT, blob, size, back));
	assert_true(blob[1] == 32 && blob[2] == 32);
	blob[1] = 33; /* the first width; the second makes up for it */
	blob[2] = 31;
	assert_false(codec_decode(&codec, CODEC_PACKED, blob, size, back));
	blob[1] = blob[2] = 32;
	assert_true(codec_decode(&codec, CODEC_PACKED, blob, size, back));
	blob[0] = 2; /* an unknown flag */
	assert_false(codec_decode(&codec, CODEC_PACKED, blob, size, back));
	free(blob);
	codec_finish(&codec);
}

static void failed_allocations_are_told(void **state)
{
	struct codec codec;
	for (uint64_t nth = 1; nth <= 5; nth++) {
		mem_fail_nth(nth, 0);
		assert_status(codec_init(&codec, CODEC_SIDE), STATUS_FAILED);
	}
	mem_fail_nth(0, 0);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_post_comes_back),
		cmocka_unit_test(a_hole_costs_the_posts_around_it_little),
		cmocka_unit_test(smooth_terrain_takes_less_than_a_byte_and_a_half_a_post),
		cmocka_unit_test(hostile_bytes_do_no_harm),
		cmocka_unit_test(lengths_that_do_not_fit_are_refused),
		cmocka_unit_test(failed_allocations_are_told),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
