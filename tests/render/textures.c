/* The ground's textures: they repeat without an edge, are of the brightness they say, level on the whole, and not flat. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../support/near.h"
#include "render/textures.h"
#include "../support/program.h"

#define SIZE RENDER_GROUND_SIZE
#define TEXELS ((size_t)SIZE * SIZE)

static const enum render_ground kinds[RENDER_GROUNDS] = {RENDER_GRASS, RENDER_SOIL, RENDER_ROCK, RENDER_SAND, RENDER_SNOW, RENDER_WIDE};
static uint8_t *texels;

static int fill(void **state)
{
	texels = malloc(4 * TEXELS * RENDER_GROUNDS);
	return texels != NULL && render_textures_fill(kinds, RENDER_GROUNDS, texels) == STATUS_OK ? 0 : -1;
}

static int drop(void **state)
{
	free(texels);
	return 0;
}

static int at(int layer, uint32_t x, uint32_t y, int channel)
{
	return texels[4 * (TEXELS * (size_t)layer + (size_t)(y % SIZE) * SIZE + x % SIZE) + (size_t)channel];
}

/* The mean step between two columns, or rows, of a layer. */
static double step_at(int layer, uint32_t line, bool column)
{
	double sum = 0;
	for (uint32_t i = 0; i < SIZE; i++)
		for (int c = 0; c < 4; c++)
			sum += column ? abs(at(layer, line, i, c) - at(layer, line + 1, i, c)) : abs(at(layer, i, line, c) - at(layer, i, line + 1, c));
	return sum / (4 * SIZE);
}

static void each_repeats_without_an_edge(void **state)
{
	for (int layer = 0; layer < RENDER_GROUNDS; layer++)
		for (int column = 0; column < 2; column++) {
			double most = 0, sum = 0;
			for (uint32_t line = 0; line < SIZE; line++) {
				double step = step_at(layer, line, column);
				most = support_most(most, step);
				sum += step;
			}
			assert_true(most < 1.8 * sum / SIZE); /* an edge may be anywhere: noise is shifted */
		}
}

static void each_has_the_mean_it_says_and_is_level(void **state)
{
	for (int layer = 0; layer < RENDER_GROUNDS; layer++) {
		double sum[4] = {0}, apart = 0;
		for (size_t i = 0; i < 4 * TEXELS; i++)
			sum[i % 4] += texels[4 * TEXELS * (size_t)layer + i];
		for (size_t i = 0; i < TEXELS; i++)
			apart += fabs(texels[4 * (TEXELS * (size_t)layer + i)] - sum[0] / TEXELS);
		assert_true(fabs(sum[0] / TEXELS - 127.5) < 4);
		assert_true(fabs(sum[2] / TEXELS - 127.5) < 1 && fabs(sum[3] / TEXELS - 127.5) < 1);
		assert_true(apart / TEXELS > 2); /* there is something to see */
	}
}

/* What is broad is what the eye finds when it repeats: squares of an eighth are nearly alike. */
static void none_is_patchy(void **state)
{
	enum { PART = SIZE / 8 };
	for (int layer = 0; layer < RENDER_WIDE; layer++)
		for (uint32_t square = 0; square < 64; square++) {
			double sum = 0;
			for (uint32_t y = 0; y < PART; y++)
				for (uint32_t x = 0; x < PART; x++)
					sum += at(layer, square % 8 * PART + x, square / 8 * PART + y, 0);
			assert_true(fabs(sum / (PART * PART) - 127.5) < 0.16 * 127.5);
		}
}

static void they_are_always_the_same(void **state)
{
	uint8_t *again = malloc(4 * TEXELS);
	assert_non_null(again);
	for (int layer = 0; layer < RENDER_GROUNDS; layer++) {
		assert_int_equal(render_textures_fill(&kinds[layer], 1, again), STATUS_OK);
		assert_memory_equal(again, texels + 4 * TEXELS * (size_t)layer, 4 * TEXELS);
	}
	free(again);
}

static void a_level_is_the_means_of_the_one_before(void **state)
{
	uint8_t squares[2][4][4][4];
	for (size_t i = 0; i < sizeof squares; i++)
		((uint8_t *)squares)[i] = (uint8_t)(i * 37 % 251);
	uint8_t before[sizeof squares], *now = (uint8_t *)squares;
	memcpy(before, squares, sizeof squares);
	render_textures_halve(now, 4, 2);
	for (int i = 0; i < 2 * 2 * 2 * 4; i++) {
		int c = i % 4, x = i / 4 % 2, y = i / 8 % 2, square = i / 16, from = square * 64 + 2 * y * 16 + 2 * x * 4 + c;
		assert_int_equal(now[i], (before[from] + before[from + 4] + before[from + 16] + before[from + 20] + 2) / 4);
	}
}

TEST_PROGRAM(textures)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(each_repeats_without_an_edge),
		cmocka_unit_test(each_has_the_mean_it_says_and_is_level),
		cmocka_unit_test(none_is_patchy),
		cmocka_unit_test(they_are_always_the_same),
		cmocka_unit_test(a_level_is_the_means_of_the_one_before),
	};
	return cmocka_run_group_tests(tests, fill, drop);
}
