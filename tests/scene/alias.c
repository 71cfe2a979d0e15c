/* Former names of keys and words: taken, the same scene, and told by the present name. */
#include "fixture.h"
#include "../support/program.h"

static const char scm[] = "{scene: 1, end_time: 1, soil: {name: lunar}, redistribute: {model: scm, undisturbed: stands}, attributes: [dirt],\n"
			  "objects: [{name: a, shape: {wheel: {radius: 1, width: 1, lugs: 9, lug_height: 0.1, lug_thickness: 0.2}},\n"
			  "path: {points: [[1, 2]], speed: 1}}]}";

static const struct {
	const char *former, *now; /* as `scm` has it, and as it is written now */
} pairs[] = {
	{"lugs: 9", "grousers: 9"},
	{"lug_height: 0.1", "grouser_height: 0.1"},
	{"lug_thickness: 0.2", "grouser_thickness: 0.2"},
	{"[dirt]", "[disturbance]"},
	{"undisturbed: stands", "undisturbed: stable"},
};
#define PAIRS (sizeof pairs / sizeof pairs[0])

static void assert_same(const struct scene *a, const struct scene *b)
{
	assert_string_equal(a->hash, b->hash);
	assert_memory_equal(&a->objects[0].shape, &b->objects[0].shape, sizeof a->objects[0].shape);
	assert_true(a->disturbance == b->disturbance && a->undisturbed == b->undisturbed);
}

static struct scene *load(const char *text, const struct scene_setting *settings, size_t count)
{
	struct scene *scene;
	if (load_text(text, settings, count, &scene) != STATUS_OK)
		fail_msg("%s", failure_message());
	return scene;
}

static void each_former_name_makes_the_same_scene(void **state)
{
	struct scene *former = load(scm, NULL, 0);
	assert_true(former->disturbance && former->objects[0].shape.grousers == 9 && former->objects[0].shape.grouser_height == 0.1 &&
		    former->objects[0].shape.grouser_thickness == 0.2);
	for (size_t i = 0; i < PAIRS; i++) {
		char *text = edited(scm, pairs[i].former, pairs[i].now);
		struct scene *scene = load(text, NULL, 0);
		assert_same(scene, former);
		scene_destroy(scene);
		free(text);
	}
	scene_destroy(former);
}

static void a_setting_finds_a_key_by_either_name(void **state)
{
	static const char *const keys[] = {"objects.a.shape.wheel.lugs", "objects.a.shape.wheel.grousers"};
	static const char *const wheels[] = {"objects.a.shape.wheel", "{radius: 1, width: 1, lugs: 3}"};
	char *now = edited(scm, "lugs: 9", "grousers: 9");
	const char *const texts[] = {scm, now};
	for (size_t t = 0; t < 2; t++)
		for (size_t k = 0; k < 2; k++) {
			struct scene *scene = load(texts[t], &(struct scene_setting){keys[k], "5"}, 1);
			assert_int_equal(scene->objects[0].shape.grousers, 5);
			scene_destroy(scene);
			const struct scene_setting none[] = {{keys[k], "null"},
							     {"objects.a.shape.wheel.lug_height", "null"},
							     {"objects.a.shape.wheel.grouser_thickness", "null"}};
			scene = load(texts[t], none, 3);
			assert_int_equal(scene->objects[0].shape.grousers, 0);
			scene_destroy(scene);
		}
	struct scene *scene = load(now, &(struct scene_setting){wheels[0], wheels[1]}, 1);
	assert_int_equal(scene->objects[0].shape.grousers, 3);
	scene_destroy(scene);
	scene = load(now, &(struct scene_setting){"redistribute.undisturbed", "stands"}, 1);
	assert_int_equal(scene->undisturbed, SCENE_STABLE);
	scene_destroy(scene);
	free(now);
}

static void messages_have_the_present_name_and_both_are_refused(void **state)
{
	static const struct {
		const char *from, *to, *says;
	} cases[] = {
		{"lugs: 9", "lugs: 900", ":2: objects[0].shape.wheel.grousers: 900 is out of range; allowed: 0 to 128"},
		{"lugs: 9,", "lugs: 9, grousers: 9,", ":2: objects[0].shape.wheel.lugs: is the former name of grousers, and both are given; "
						      "allowed: grousers alone"},
		{"lugs: 9,", "grousers: 9, lugs: 9,", ":2: objects[0].shape.wheel.lugs: is the former name of grousers, and both"},
		{"lug_height: 0.1", "lug_height: 0.1, grouser_height: 0.1", "wheel.lug_height: is the former name of grouser_height, and both"},
		{"lug_thickness: 0.2", "lug_thickness: 0.2, grouser_thickness: 0.1", "wheel.lug_thickness: is the former name of grouser_thickness"},
		{"[dirt]", "[dirt, disturbance]", ":1: attributes[1]: disturbance is named twice"},
		{"undisturbed: stands", "undisturbed: stand", "\"stand\" is unknown; allowed: stable, slides"},
		{"radius: 1,", "radius: 1, lug: 1,", "wheel.lug: unknown key; allowed: radius, width, grousers, grouser_height, grouser_thickness"},
		/* Of other places they are no names. */
		{"end_time: 1", "end_time: 1, lugs: 1", ":1: lugs: unknown key; allowed: scene, store"},
		{"name: a", "name: a, sink: dirt", "sink: \"dirt\" is not a number"},
	};
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		char *text = edited(scm, cases[i].from, cases[i].to);
		struct scene *scene;
		assert_int_equal(load_text(text, NULL, 0, &scene), STATUS_INPUT);
		assert_says(cases[i].says);
		free(text);
	}
	struct scene *scene;
	const struct scene_setting both = {"objects.a.shape.wheel", "{radius: 1, width: 1, lugs: 3, grousers: 3}"};
	assert_int_equal(load_text(scm, &both, 1, &scene), STATUS_INPUT);
	assert_says("--set objects.a.shape.wheel: objects[0].shape.wheel.lugs: is the former name of grousers");
	/* A name is text of the scene's own. */
	char *text = edited(scm, "name: a", "name: dirt");
	scene = load(text, NULL, 0);
	assert_string_equal(scene->objects[0].name, "dirt");
	scene_destroy(scene);
	free(text);
}

static void an_object_of_a_hosts_may_use_them(void **state)
{
	struct scene *scene;
	struct scene_object object;
	assert_int_equal(scene_load_text("{}", folder, NULL, 0, SCENE_HOST, &scene), STATUS_OK);
	assert_int_equal(scene_object_parse(scene, "{shape: {wheel: {radius: 1, width: 1, lugs: 7}}}", &object), STATUS_OK);
	assert_int_equal(object.shape.grousers, 7);
	scene_object_finish(&object);
	scene_destroy(scene);
}

static void names_of_layers_have_theirs(void **state)
{
	static const char *const layers[][2] = {{"heaped", "deposited"}, {"pressed", "plastic_sinkage"}, {"quanta", "fixed_point"},
						{"dirt", "disturbance"}, {"surface", "surface"}, {"deposited", "deposited"}};
	for (size_t i = 0; i < sizeof layers / sizeof layers[0]; i++)
		assert_string_equal(scene_name_now(layers[i][0]), layers[i][1]);
}

static void failing_memory_is_told(void **state)
{
	write_text("scene.yaml", scm);
	const struct scene_setting setting = {"objects.a.shape.wheel.lugs", "5"};
	assert_memory_is_told(&setting, 1, false);
	unlink(in_folder("scene.yaml"));
}

TEST_PROGRAM(alias)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(each_former_name_makes_the_same_scene),
		cmocka_unit_test(a_setting_finds_a_key_by_either_name),
		cmocka_unit_test(messages_have_the_present_name_and_both_are_refused),
		cmocka_unit_test(an_object_of_a_hosts_may_use_them),
		cmocka_unit_test(names_of_layers_have_theirs),
		cmocka_unit_test(failing_memory_is_told),
	};
	return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
