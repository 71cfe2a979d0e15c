/* A rut of a millimetre has the same bits wherever it lies (law 9), under every model. */
#include "hard.h"
#include "../support/program.h"

static const char *one_millimetre(const char *coordinates, double x, double y)
{
	static char text[512];
	snprintf(text, sizeof text, "time_step: 0.05\nend_time: 2\nspacing: 0.0625\n%sobjects:\n"
		 "  - {name: wheel, shape: {wheel: {radius: 0.5, width: 0.4}}, sink: 0.001,\n"
		 "     path: {points: [[%.17g, %.17g], [%.17g, %.17g]], speed: 1.5}}\n",
		 coordinates, x + 20.3125, y + 20.125, x + 22.8125, y + 21.625);
	return text;
}

#define SIDE 96

/* The rut's posts; its south-west post is (x, y) metres from the store's. */
static double *rut(const char *store, double x, double y)
{
	int64_t x0 = (int64_t)((x + 19) * 16), y0 = (int64_t)((y + 19) * 16);
	return support_quanta(store, -4, (struct post_rect){x0, y0, x0 + SIDE, y0 + SIDE});
}

static void same(double *first, double *other)
{
	size_t touched = 0;
	for (int i = 0; i < SIDE * SIDE; i++)
		touched += first[i] != 0;
	assert_true(touched > 20);
	assert_memory_equal(first, other, SIDE * SIDE * sizeof *first);
	free(other);
}

static double flat_8000(int64_t x, int64_t y)
{
	return hard_rough(x, y) + 8000;
}

static double flat_trench(int64_t x, int64_t y)
{
	return hard_rough(x, y) - 11000;
}

static void a_millimetre_on_a_summit_and_in_a_trench_is_the_same_bits(void **state)
{
	const support_height heights[] = {hard_rough, flat_8000, flat_trench};
	for (size_t m = 0; m < HARD_MODELS; m++) {
		double *first = NULL;
		for (int i = 0; i < 3; i++) {
			const char *store = support_path("height.furrow");
			support_store(store, hard_world, heights[i]);
			mem_free(hard_drive(&hard_models[m], one_millimetre("", 0, 0), store, NULL));
			double *posts = rut(store, 0, 0);
			if (first == NULL)
				first = posts;
			else
				same(first, posts);
		}
		free(first);
	}
}

static void ten_thousand_kilometres_from_the_origin_of_the_crs_it_is_the_same_bits(void **state)
{
	for (size_t m = 0; m < HARD_MODELS; m++) {
		const char *here = support_path("here.furrow"), *there = support_path("there.furrow");
		support_store(here, hard_world, hard_rough);
		support_store_at(there, hard_world, hard_rough, 1e7, -1e7);
		mem_free(hard_drive(&hard_models[m], one_millimetre("coordinates: store\n", 0, 0), here, NULL));
		mem_free(hard_drive(&hard_models[m], one_millimetre("coordinates: store\n", 1e7, -1e7), there, NULL));
		double *first = rut(here, 0, 0);
		same(first, rut(there, 0, 0));
		free(first);
	}
}

/* 64 m posts, the same every 16 of them; 160,001 of them are 10,240 km. */
static double strip(int64_t x, int64_t y)
{
	return 50 + (double)((x % 16) * (x % 16) % 11) + 0.37 * (double)y;
}

static void ten_thousand_kilometres_along_the_terrain_it_is_the_same_bits(void **state)
{
	const struct extent far = {160001, 4, 64, 256};
	const double out = 156000.0 * 64; /* a multiple of the strip's period */
	const char *store = support_path("far.furrow");
	support_store(store, far, strip);
	for (size_t m = 0; m < HARD_MODELS; m++) {
		struct store *opened;
		mem_free(hard_drive(&hard_models[m], one_millimetre("", 0, 0), store, NULL));
		double *first = rut(store, 0, 0);
		must(store_open(store, &(struct store_options){.mode = STORE_WRITE}, &opened));
		must(store_reset(opened, true));
		store_close(opened);
		mem_free(hard_drive(&hard_models[m], one_millimetre("", out, 0), store, NULL));
		same(first, rut(store, out, 0));
		free(first);
		must(store_open(store, &(struct store_options){.mode = STORE_WRITE}, &opened));
		must(store_reset(opened, true));
		store_close(opened);
	}
}

TEST_PROGRAM(places)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_millimetre_on_a_summit_and_in_a_trench_is_the_same_bits),
		cmocka_unit_test(ten_thousand_kilometres_from_the_origin_of_the_crs_it_is_the_same_bits),
		cmocka_unit_test(ten_thousand_kilometres_along_the_terrain_it_is_the_same_bits),
	};
	return cmocka_run_group_tests_name("hard places", tests, support_enter, support_leave);
}
