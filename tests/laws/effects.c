/* Law 7: an effect that the scene does not name costs nothing; one that it names, only itself. */
#include "../support.h"

static const struct world world = {129, 129, 1, 64};

static const char bare[] =
	"scene: 1\ntime_step: 0.1\nend_time: 4\n"
	"objects:\n"
	"  - {name: a, shape: {sphere: {radius: 1.5}}, sink: 0.3, path: {points: [[20, 20], [100, 90]], speed: 10}}\n";

struct figures {
	long long displace, redistribute, attributes, pyramid, render, programs, soil;
};

static struct figures drive(const char *extra)
{
	const char *scene = support_path("effects.yaml"), *store = support_path("effects.furrow");
	char text[2048];
	snprintf(text, sizeof text, "%s%s", bare, extra);
	support_write(scene, text);
	support_store(store, world, support_hills);
	char *json = support_drive(scene, store, NULL);
	struct figures figures = {
		.displace = support_figure(json, "\"passes\"", "displace"),
		.redistribute = support_figure(json, "\"passes\"", "redistribute"),
		.attributes = support_figure(json, "\"passes\"", "attributes"),
		.pyramid = support_figure(json, "\"passes\"", "pyramid"),
		.render = support_figure(json, "\"passes\"", "render"),
		.programs = support_figure(json, "\"programs\"", "programs"),
	};
	mem_free(json);
	struct store *opened;
	struct store_numbers numbers;
	must(store_open(store, &(struct store_options){.mode = STORE_READ}, &opened));
	must(store_count(opened, &numbers));
	figures.soil = 0;
	for (int plane = PLANE_DIRT; plane < PLANES; plane++)
		figures.soil += numbers.plane_tiles[plane];
	store_close(opened);
	return figures;
}

static void a_bare_scene_displaces_and_nothing_else(void **state)
{
	struct figures figures = drive("");
	assert_true(figures.displace > 0);
	assert_int_equal(figures.redistribute, 0);
	assert_int_equal(figures.attributes, 0);
	assert_int_equal(figures.pyramid, 0);
	assert_int_equal(figures.render, 0);
	assert_int_equal(figures.programs, 2); /* the underside, and what it presses */
	assert_int_equal(figures.soil, 0);
}

static void each_effect_adds_its_own_rows_only(void **state)
{
	struct figures none = drive(""), box = drive("redistribute: {model: box}\n"),
		       dirt = drive("attributes: [dirt]\n");
	assert_int_equal(box.displace, none.displace);
	assert_true(box.redistribute > 0);
	assert_int_equal(box.attributes, 0);
	assert_int_equal(box.programs, none.programs + 1);
	assert_int_equal(box.soil, 0);
	assert_int_equal(dirt.displace, none.displace);
	assert_int_equal(dirt.redistribute, 0);
	assert_true(dirt.attributes > 0);
	assert_int_equal(dirt.programs, none.programs + 1);
	assert_true(dirt.soil > 0);
}

static double level(int64_t x, int64_t y)
{
	return 100 + (double)(x * y % 7) / 1024;
}

static void a_resting_object_runs_no_pass(void **state)
{
	static const char *const models[] = {"box", "sumner", "slippage", "scm"};
	for (int m = 0; m < 4; m++) {
		char text[64];
		snprintf(text, sizeof text, "soil: {name: sand}\nredistribute: {model: %s}\n", models[m]);
		drive(text + (m == 0 ? strlen("soil: {name: sand}\n") : 0)); /* writes the scene */
		/* The path takes 10.6 s at 10 m/s; stopped at its end, and with the ground come to rest, further steps add
		 * nothing. */
		const char *scene = support_path("effects.yaml"), *store = support_path("effects.furrow");
		long long passes[2];
		const char *const ends[] = {"end_time=40", "end_time=80"};
		for (int i = 0; i < 2; i++) {
			support_store(store, world, level);
			char *json = support_drive(scene, store, (const char *[]){ends[i], NULL});
			passes[i] = support_figure(json, "\"passes\"", "redistribute");
			if (m > 0)
				assert_int_equal(support_figure(json, "\"slide\"", "awake"), 0);
			mem_free(json);
		}
		assert_true(passes[0] > 100);
		assert_int_equal(passes[0], passes[1]);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_bare_scene_displaces_and_nothing_else),
		cmocka_unit_test(each_effect_adds_its_own_rows_only),
		cmocka_unit_test(a_resting_object_runs_no_pass),
	};
	return cmocka_run_group_tests_name("effects", tests, support_enter, support_leave);
}
