/* Many objects far from each other: a step does not wait for the commit of the one before, and slots change no row. */
#include "hard.h"
#include "../support/program.h"

enum { ACROSS = 12, OBJECTS = ACROSS * ACROSS };

static double plain(int64_t x, int64_t y)
{
	return 20 + (double)(x * 7 + y * 3 % 11) / 512;
}

/* Each on tiles of its own, 32 m wide; each crosses a tile's edge. */
static const char *scene_of(void)
{
	static char text[OBJECTS * 160 + 256];
	int length = snprintf(text, sizeof text, "scene: 1\ntime_step: 0.05\nend_time: 2\nspacing: 0.125\nredistribute: {model: box}\nobjects:\n");
	for (int i = 0; i < OBJECTS; i++) {
		const int x = 20 + i % ACROSS * 33, y = 16 + i / ACROSS * 33;
		length += snprintf(text + length, sizeof text - (size_t)length,
				   "  - {name: w%d, shape: {wheel: {radius: 0.5, width: 0.3}}, sink: 0.05, path: {points: [[%d, %d], [%d, %d]], speed: 6}}\n", i,
				   x, y, x + 14, y);
	}
	support_write(support_path("many.yaml"), text);
	return support_path("many.yaml");
}

static void many_objects_wait_for_no_commit(void **state)
{
	static const char *const all[] = {"cache.slots=1200", NULL}, *const few[] = {"cache.slots=64", NULL};
	static const struct extent wide = {513, 513, 1, 256};
	const char *store = support_path("all.furrow");
	(void)state;
	support_store(store, wide, plain);
	char *json = support_drive(scene_of(), store, all);
	const long long steps = support_figure(json, "{", "steps");
	assert_true(support_figure(json, "\"cache\"", "touched") > OBJECTS);
	/* Every second, or when the changed pages are twice those under the objects. */
	assert_true(support_figure(json, "\"io\"", "commits") <= steps / 4);
	mem_free(json);
	const uint64_t rows = support_hash(store);
	store = support_path("few.furrow");
	support_store(store, wide, plain);
	mem_free(support_drive(scene_of(), store, few));
	assert_true(support_hash(store) == rows);
	support_verify(store);
}

TEST_PROGRAM(many)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(many_objects_wait_for_no_commit),
	};
	return cmocka_run_group_tests_name("many objects", tests, support_enter, support_leave);
}
