/* `--set KEY=VALUE`. */
#include "fixture.h"
#include "../support/program.h"

static void a_setting_replaces_or_adds_what_its_key_names(void **state)
{
	const struct scene_setting settings[] = {
		{"cache.slots", "16"},
		{"objects.front_left.sink", "0.05"},
		{"objects.front_left.path.points", "[[1, 2], [3, 4], [5, 6]]"},
		{"view.camera", "{over: front_left, height: 7}"},
		{"view.effects", "[fog]"},
		{"redistribute.repetitions", "2"},
		{"attributes.0", "disturbance"},
		{"store", "/abs/other.furrow"},
	};
	struct scene *scene;
	assert_int_equal(load_text(example, settings, sizeof settings / sizeof settings[0], &scene),
			 STATUS_OK);
	assert_int_equal(scene->slots, 16);
	assert_int_equal(scene->loaders, 2);
	assert_true(scene->objects[0].sink == 0.05);
	assert_int_equal(scene->objects[0].path.count, 3);
	assert_true(scene->objects[0].path.points[2].y == 6);
	assert_int_equal(scene->view.aim.kind, SCENE_OVERHEAD);
	assert_int_equal(scene->view.effects, EFFECT_BIT(EFFECT_FOG));
	assert_int_equal(scene->box_repetitions, 2);
	assert_string_equal(scene->store, "/abs/other.furrow");
	scene_destroy(scene);
}

static void a_setting_makes_the_mapping_it_needs(void **state)
{
	const struct scene_setting settings[] = {{"cache.slots", "9"}, {"redistribute.model", "box"}};
	struct scene *scene;
	assert_int_equal(load_text(minimal, settings, 2, &scene), STATUS_OK);
	assert_int_equal(scene->slots, 9);
	assert_int_equal(scene->model, DEFORM_BOX_FILTER);
	scene_destroy(scene);
}

static void null_takes_a_key_away(void **state)
{
	const struct scene_setting settings[] = {{"view", "null"}, {"gravity", "~"}, {"output", "null"}};
	struct scene *scene;
	assert_int_equal(load_text(example, settings, 3, &scene), STATUS_OK);
	assert_false(scene->view.present);
	assert_true(scene->gravity == 9.81);
	scene_destroy(scene);
}

static const char *told(const struct scene *scene, const char *key)
{
	const char *text = NULL;
	for (size_t i = 0; i < scene->value_count; i++)
		if (strcmp(scene->values[i].key, key) == 0) {
			assert_null(text); /* once */
			text = scene->values[i].text;
		}
	return text;
}

static void all_settings_are_told_as_text(void **state)
{
	const struct scene_setting settings[] = {
		{"cache.slots", "16"},
		{"objects.front_left.sink", "0.05"},
		{"objects.front_left.path.points", "[[1, 2], [3, 4]]"},
		{"attributes.0", "dirt"},
		{"store", "\"a: \\\"b\\\" <c>.furrow\""},
	};
	struct scene *scene;
	assert_int_equal(load_text(example, settings, sizeof settings / sizeof settings[0], &scene), STATUS_OK);
	assert_string_equal(told(scene, "cache.slots"), "16");
	assert_string_equal(told(scene, "objects.front_left.sink"), "0.05");
	assert_string_equal(told(scene, "objects.front_left.path.points"), "[[1, 2], [3, 4]]");
	assert_string_equal(told(scene, "attributes.disturbance"), "{}");
	assert_string_equal(told(scene, "store"), "\"a: \\\"b\\\" <c>.furrow\"");
	assert_null(told(scene, "objects.front_left.name"));
	assert_null(told(scene, "objects"));
	scene_destroy(scene);
}

/* Values that are too long differ where the whole texts differ, and stay UTF-8. */
static void a_long_value_is_cut_and_has_a_hash(void **state)
{
	char points[2][3000] = {"[", "["}, told_first[1000];
	for (int k = 0; k < 2; k++) {
		for (int i = 0; i < 200; i++)
			snprintf(points[k] + strlen(points[k]), sizeof points[k] - strlen(points[k]), "[%d, %d], ", i, i == 190 ? k : 7);
		strcat(points[k], "[1, 2]]");
		const struct scene_setting setting = {"objects.front_left.path.points", points[k]};
		struct scene *scene;
		assert_int_equal(load_text(example, &setting, 1, &scene), STATUS_OK);
		const char *text = told(scene, setting.key);
		assert_true(strlen(text) == 400 && strncmp(text, points[k], 300) == 0 && strstr(text, " bytes, hash ") != NULL);
		if (k == 0)
			snprintf(told_first, sizeof told_first, "%s", text);
		else
			assert_string_not_equal(text, told_first);
		scene_destroy(scene);
	}
	char name[1400] = "";
	for (int i = 0; i < 300; i++)
		strcat(name, i % 7 == 0 ? "x" : "\xc3\xa4");
	struct scene *scene;
	assert_int_equal(load_text(example, &(struct scene_setting){"store", name}, 1, &scene), STATUS_OK);
	const char *text = told(scene, "store"), *cut = strstr(text, " ... (");
	assert_non_null(cut);
	assert_true(cut[-1] == 'x' || ((unsigned char)cut[-1] == 0xa4 && (unsigned char)cut[-2] == 0xc3));
	scene_destroy(scene);
}

static void a_later_setting_wins(void **state)
{
	const struct scene_setting settings[] = {{"cache.slots", "2"}, {"cache.slots", "8"}};
	struct scene *scene;
	assert_int_equal(load_text(example, settings, 2, &scene), STATUS_OK);
	assert_int_equal(scene->slots, 8);
	scene_destroy(scene);
}

#define TEN "abcdefghij"
#define LONG_KEY TEN TEN TEN TEN TEN TEN TEN TEN TEN TEN TEN TEN TEN TEN TEN TEN "k"

static void a_wrong_setting_is_told_as_one(void **state)
{
	static const struct {
		struct scene_setting setting;
		const char *says;
	} cases[] = {
		{{"cache.slots", "2"}, "scene.yaml: --set cache.slots: cache.slots: 2 is out of range; "
				       "allowed: 4 to 65536"},
		{{"cache.slot", "8"}, "--set cache.slot: cache.slot: unknown key; allowed: slots"},
		{{"cach.slots", "8"}, "--set cach.slots: cach: unknown key"},
		{{"objects.rear.sink", "1"}, "--set objects.rear.sink: \"rear\" is not in the list; "
					     "allowed: front_left"},
		{{"objects.0.sink", "1"}, "\"0\" is not in the list"},
		{{"attributes.3", "dirt"}, "\"3\" is not in the list; allowed: 0"},
		{{"end_time.x", "1"}, "\"x\" is below a single value"},
		{{"", "1"}, "is no key"},
		{{"cache.", "1"}, "is no key"},
		{{".", "1"}, "is no key"},
		{{"a.b.c.d.e.f.g.h.i", "1"}, "is too deep"},
		{{LONG_KEY, "1"}, "the key has 161 bytes; allowed: at most 160"},
		{{"end_time", ""}, "--set end_time: nothing is written here"},
		{{"end_time", "[1"}, "--set end_time: not YAML"},
		{{"end_time", "*a"}, "--set end_time: an alias"},
		{{"end_time", "null"}, "end_time: is missing"},
		{{"redistribute", "{radius: 2}"}, "--set redistribute: redistribute.model: is missing"},
		{{"redistribute.model", "mud"}, "\"mud\" is unknown; allowed: none, box, sumner, slippage, scm"},
		{{"objects.front_left.load", "1"}, "--set objects.front_left.load: objects[0].load: sink is given too"},
		{{"soil.classes", "{1: lunar}"}, "--set soil.classes: soil.classes: is of a map, and there is none"},
		{{"view.camera.chase", "b"}, "--set view.camera.chase: view.camera.chase: \"b\" is no object"},
	};
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		struct scene *scene;
		assert_int_equal(load_text(example, &cases[i].setting, 1, &scene), STATUS_INPUT);
		assert_null(scene);
		assert_says(cases[i].says);
	}
}

TEST_PROGRAM(set)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_setting_replaces_or_adds_what_its_key_names),
		cmocka_unit_test(a_setting_makes_the_mapping_it_needs),
		cmocka_unit_test(null_takes_a_key_away),
		cmocka_unit_test(all_settings_are_told_as_text),
		cmocka_unit_test(a_long_value_is_cut_and_has_a_hash),
		cmocka_unit_test(a_later_setting_wins),
		cmocka_unit_test(a_wrong_setting_is_told_as_one),
	};
	return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
