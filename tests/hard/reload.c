/*
 * A second pass over a rut that was read back from the store leaves the same bits as one over a rut that never left its
 * slots: offsets, and the soil's memory with them.
 */
#include "hard.h"
#include "../support/program.h"

/* The first wheel leaves the world, and the ground comes to rest, before the second sets down where the first was. */
static const char first_pass[] =
	"  - {name: first, shape: {wheel: {radius: 0.6, width: 0.5}}, sink: 0.12,\n"
	"     path: {points: [[70, 60.2], [133, 61]], speed: 12}}\n";
static const char second_pass[] =
	"  - {name: second, shape: {wheel: {radius: 0.6, width: 0.5, lugs: 8, lug_height: 0.03}}, sink: 0.16, path: {file: second.csv}}\n";

static const char *scene_of(const struct hard_model *model, bool first, bool second)
{
	static char rest[1024];
	support_write(support_path("second.csv"), "t,x,y\n12,75.3,59.3\n18,127,61.2\n18.5,127,60.8\n");
	snprintf(rest, sizeof rest, "time_step: 0.1\nend_time: %d\nspacing: 0.125\noutside: skip\nobjects:\n%s%s", second ? 20 : 12,
		 first ? first_pass : "", second ? second_pass : "");
	return hard_scene(model, rest);
}

static void a_pass_over_a_reloaded_rut_leaves_the_bits_of_one_over_a_resident_rut(void **state)
{
	static const char *const all[] = {"cache.slots=512", NULL};
	static const char *const few[] = {"cache.slots=4", "cache.loaders=1", "cache.prefetch=0", NULL};
	for (const struct hard_model *model = hard_models; model < hard_models + HARD_MODELS; model++) {
		const char *store = hard_store("resident.furrow");
		char *json = support_drive(scene_of(model, true, true), store, all);
		assert_int_equal(support_figure(json, "\"cache\"", "evictions"), 0);
		mem_free(json);
		uint64_t resident = support_hash(store);

		store = hard_store("evicted.furrow");
		json = support_drive(scene_of(model, true, true), store, few);
		assert_true(support_figure(json, "\"cache\"", "evictions") > 10);
		mem_free(json);
		if (support_hash(store) != resident)
			fail_msg("%s: other rows with evictions", model->name);

		store = hard_store("reloaded.furrow");
		mem_free(support_drive(scene_of(model, true, false), store, all));
		uint64_t between = support_hash(store);
		json = support_drive(scene_of(model, false, true), store, all);
		assert_true(support_figure(json, "\"quanta\"", "removed") > 0);
		mem_free(json);
		support_verify(store);
		assert_true(support_hash(store) != between);
		if (support_hash(store) != resident)
			fail_msg("%s: other rows over a rut from the store", model->name);

		/* It is the rut that shows, and what is remembered of it. */
		store = hard_store("alone.furrow");
		mem_free(support_drive(scene_of(model, false, true), store, all));
		assert_true(support_hash(store) != resident);
	}
}

TEST_PROGRAM(reload)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_pass_over_a_reloaded_rut_leaves_the_bits_of_one_over_a_resident_rut),
	};
	return cmocka_run_group_tests_name("hard reload", tests, support_enter, support_leave);
}
