/*
 * Loading ahead: when all of a drive's paths is within sight, everything it will touch is there before its
 * first step, and nothing else is.
 */
#include "support.h"
#include "../support/program.h"

static const struct extent extent = {.cells = 64, .width = 513, .height = 385, .spacing = 1};

static const char wheels[] =
	"scene: 1\n"
	"time_step: 0.05\n"
	"end_time: 40\n"
	"spacing: 0.25\n"
	"redistribute: {model: box, repetitions: 2}\n"
	"objects:\n"
	"  - {name: one, shape: {wheel: {radius: 0.5, width: 0.4}}, sink: 0.1,\n"
	"     path: {points: [[20, 20], [200.3, 31.7], [190, 160], [64, 64], [63.9, 200]], speed: 20}}\n"
	"  - {name: round, shape: {sphere: {radius: 1.1}}, sink: 0.3,\n"
	"     path: {points: [[300, 120], [330, 120], [330, 150], [300, 150]], speed: 9, loop: true}}\n";

static const char plates[] = /* larger than a tile, deep in the ground, turned as they go, over the world's edge */
	"scene: 1\n"
	"time_step: 0.37\n"
	"end_time: 12\n"
	"outside: skip\n"
	"attributes: [dirt]\n"
	"objects:\n"
	"  - {name: plate, shape: {box: {size: [90, 40, 2]}}, path: {file: plate.csv}}\n"
	"  - {name: over, shape: {box: {size: [3, 2, 1]}}, sink: 0.2,\n"
	"     path: {points: [[480, 300], [540, 320], [500, 380]], speed: 10}}\n";

/* `slots`: fewer than there are tiles, or nothing would be loaded ahead. */
static void expect_all_there(const char *text, const char *slots, const char *loaders)
{
	const char *store = support_path("world.furrow"), *scene = support_path("scene.yaml");
	const char *settings[] = {slots, "cache.prefetch=3600", loaders, NULL};
	support_store(store, extent, support_hills);
	support_write(support_path("plate.csv"), "t,x,y,z,yaw,pitch,roll\n0,100,100,91,0,0,0\n5,200,220,92,1.4,0.1,0\n"
						 "6,200,220,92,-1,0,0.1\n12,333,190,90,-2,0,0\n");
	support_write(scene, text);
	char *json = support_drive(scene, store, settings);
	long long touched = support_figure(json, "\"cache\"", "touched");
	assert_true(touched > 10);
	assert_int_equal(support_figure(json, "\"cache\"", "misses"), 0);
	assert_int_equal(support_figure(json, "\"cache\"", "stalls"), 0);
	assert_int_equal(support_figure(json, "\"cache\"", "evictions"), 0);
	assert_int_equal(support_figure(json, "\"cache\"", "prefetched"), touched);
	mem_free(json);
	unlink(store);
}

static void all_that_wheels_will_touch_is_there_and_nothing_else(void **state)
{
	expect_all_there(wheels, "cache.slots=1024", "cache.loaders=2");
	expect_all_there(wheels, "cache.slots=1024", "cache.loaders=1");
}

static void all_that_plates_will_touch_is_there_and_nothing_else(void **state)
{
	expect_all_there(plates, "cache.slots=60", "cache.loaders=3");
}

TEST_PROGRAM(look_ahead)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(all_that_wheels_will_touch_is_there_and_nothing_else),
		cmocka_unit_test(all_that_plates_will_touch_is_there_and_nothing_else),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
