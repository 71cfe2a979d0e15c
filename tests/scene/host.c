/* Scenes and objects as text, for a host: what it may leave out, and what is checked all the same. */
#include "fixture.h"

#include "base/thread.h"
#include "../support/program.h"

static struct scene *load_as(const char *text, enum scene_reader reader)
{
	struct scene *scene;
	if (scene_load_text(text, folder, NULL, 0, reader, &scene) != STATUS_OK)
		fail_msg("%s", failure_message());
	return scene;
}

static struct scene *hosted(const char *text)
{
	return load_as(text, SCENE_HOST);
}

static void a_text_is_the_scene_that_its_file_is(void **state)
{
	struct scene *file, *text = load_as(example, SCENE_COMMAND);
	assert_int_equal(load_text(example, NULL, 0, &file), STATUS_OK);
	assert_string_equal(text->hash, file->hash);
	assert_string_equal(text->store, file->store);
	assert_string_equal(text->file, "scene text");
	assert_true(text->end_time == 30 && !text->hosted);
	scene_destroy(text);
	scene_destroy(file);
}

static void a_text_knows_its_folder_and_without_one_the_processs(void **state)
{
	static const char text[] = "{store: a.furrow}";
	char before[4096], whole[4200], now[4200];
	struct scene *scene;
	assert_non_null(getcwd(before, sizeof before));
	assert_int_equal(chdir(folder), 0);
	assert_non_null(getcwd(now, sizeof now - 100));
	assert_int_equal(scene_load_text(text, NULL, NULL, 0, SCENE_HOST, &scene), STATUS_OK);
	snprintf(whole, sizeof whole, "%.4000s/a.furrow", now);
	assert_string_equal(scene->store, whole);
	write_text("poses.csv", "0,1,2\n1,2,3\n");
	assert_int_equal(chdir(before), 0);
	/* The process is elsewhere now; the scene's files are where they were. */
	struct scene_object object;
	assert_int_equal(scene_object_parse(scene, "{shape: {sphere: {radius: 1}}, path: {file: poses.csv}}", &object), STATUS_OK);
	assert_int_equal(object.path.count, 2);
	scene_object_finish(&object);
	scene_destroy(scene);
	scene = hosted(text);
	assert_string_equal(scene->store, in_folder("a.furrow"));
	scene_destroy(scene);
	assert_int_equal(scene_load_text("{store: /b/c}", folder, NULL, 0, SCENE_HOST, &scene), STATUS_OK);
	assert_string_equal(scene->store, "/b/c");
	scene_destroy(scene);
	assert_int_equal(unlink(in_folder("poses.csv")), 0);
}

static void json_is_a_scene(void **state)
{
	struct scene *scene = hosted(
		"{\n\t\"scene\": 1,\"time_step\":1e-3, \"gravity\": 1.62E+0,\n \"store\": \"caf\\u00e9\\/\\\"a\\\".furrow\",\r\n"
		"\"soil\":{\"name\":\"lunar\",\"cohesion\":1.7e+02},\"redistribute\":{\"model\":\"scm\"},\n"
		"\"objects\":[{\"name\":\"w\",\"shape\":{\"wheel\":{\"radius\":0.25,\"width\":0.2}},\n"
		"\"path\":{\"points\":[[1,2],[3,4]],\"speed\":1,\"loop\":true}}],\"attributes\":[]}");
	assert_true(scene->time_step == 1e-3 && scene->gravity == 1.62 && scene->soils[0].cohesion == 170);
	assert_string_equal(scene->store, in_folder("caf\xc3\xa9/\"a\".furrow"));
	assert_true(scene->objects[0].path.loop);
	scene_destroy(scene);
	static const struct {
		const char *text, *says;
	} wrong[] = {
		{"{\"time_step\": NaN}", "scene text:1: time_step: \"NaN\" is not a number; allowed: a number, 1e-06 to 3600"},
		{"{\"time_step\": Infinity}", ":1: time_step: \"Infinity\" is not a number"},
		{"{\n\"spacing\": 1.0E+20}", ":2: spacing: 1.0E+20 is out of range; allowed: above 0 to 1000000"},
		{"{\"spacing\": \"0.5\"}", "spacing: \"0.5\" is not a number"},
		{"{\"spaceing\": 1}", "spaceing: unknown key"},
		{"[]", "scene text:1: not a scene"},
		{"", "scene text:1: nothing is written"},
		{"{\"soil\": null}", "soil: is a single value"},
	};
	for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
		assert_int_equal(scene_load_text(wrong[i].text, folder, NULL, 0, SCENE_HOST, &scene), STATUS_INPUT);
		assert_null(scene);
		assert_says(wrong[i].says);
	}
}

static void a_text_has_a_size(void **state)
{
	size_t size = (1u << 20) + 1;
	char *text = room_for(size + 1);
	struct scene *scene;
	struct scene_object object;
	memset(text, '#', size);
	text[size] = '\0';
	assert_int_equal(scene_load_text(text, folder, NULL, 0, SCENE_HOST, &scene), STATUS_INPUT);
	assert_says("scene text: it is too large; allowed: 1048576 bytes");
	scene = hosted("{}");
	assert_int_equal(scene_object_parse(scene, text, &object), STATUS_INPUT);
	assert_says("object text: it is too large");
	scene_destroy(scene);
	free(text);
}

static void a_host_may_leave_out_what_the_command_needs(void **state)
{
	struct scene *scene = hosted("{}");
	assert_true(scene->hosted && isinf(scene->end_time) && scene->time_step == 0.02);
	assert_int_equal(scene->object_count, 0);
	assert_true((scene_effects(scene, 0) & EFFECT_BIT(EFFECT_OF(DEFORM_NONE))) != 0);
	scene_destroy(scene);
	scene = hosted("{\"spacing\": 0.02, \"soil\": {\"name\": \"lunar\"}, \"redistribute\": {\"model\": \"scm\"}}");
	assert_int_equal(scene->model, DEFORM_SCM);
	assert_int_equal(scene->soil_count, 1);
	assert_true(scene->spacing == 0.02);
	assert_true((scene_effects(scene, 0) & EFFECT_BIT(EFFECT_OF(DEFORM_SCM))) != 0);
	scene_destroy(scene);
	scene = hosted("objects: [{shape: {sphere: {radius: 1}}}, {name: body-1, shape: {sphere: {radius: 1}}},"
		       "{shape: {wheel: {radius: 1, width: 1}}, path: {points: [[1, 2]], speed: 1}}]");
	assert_string_equal(scene->objects[0].name, "body-2");
	assert_string_equal(scene->objects[1].name, "body-1");
	assert_string_equal(scene->objects[2].name, "body-3");
	assert_int_equal(scene->objects[0].path.count, 0);
	assert_int_equal(scene->objects[2].path.count, 1);
	scene_destroy(scene);
	scene = hosted("{view: {effects: [sky]}}"); /* the host has a camera of its own */
	assert_true(scene->view.present && scene->view.effects == EFFECT_BIT(EFFECT_SKY));
	scene_destroy(scene);
}

static void nothing(void *user, const char *text)
{
	fail_msg("%s", text);
}

static void advice_takes_bodies_without_paths_and_no_end(void **state)
{
	struct scene *scene = hosted("{objects: [{shape: {sphere: {radius: 1}}}, {name: a, shape: {sphere: {radius: 1}}, path: {points: "
				     "[[1, 2]], speed: 1}}], view: {camera: {fixed: {eye: [1, 2, 3], target: [0, 0, 0]}}, images: 5, effects: "
				     "[objects]}, soil: {name: lunar}, redistribute: {model: scm}, output: {forces: 10}}");
	scene_advise(scene, 0.1, nothing, NULL);
	scene_destroy(scene);
	scene = hosted("{redistribute: {model: box}, outside: skip, coordinates: store}");
	scene_advise(scene, 0.1, nothing, NULL);
	scene_destroy(scene);
}

static void the_command_needs_them(void **state)
{
	static const struct {
		const char *text, *says;
	} cases[] = {
		{"{}", ":1: scene: is missing; add it: a whole number, 1"},
		{"{scene: 1}", ":1: end_time: is missing; add it: a number, above 0 to 1000000000, in s"},
		{"{scene: 1, end_time: 1}", ":1: no object and no view"},
		{"{scene: 1, end_time: 1, view: {effects: [sky]}}", "view.camera: is missing; add it: a mapping"},
		{"{scene: 1, end_time: 1, objects: [{shape: {sphere: {radius: 1}}}]}", "objects[0].name: is missing; add it: a text"},
		{"{scene: 1, end_time: 1, objects: [{name: a, shape: {sphere: {radius: 1}}}]}", "objects[0].path: is missing; add it: a mapping"},
	};
	struct scene *scene;
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		assert_int_equal(scene_load_text(cases[i].text, folder, NULL, 0, SCENE_COMMAND, &scene), STATUS_INPUT);
		assert_says(cases[i].says);
		assert_int_equal(load_text(cases[i].text, NULL, 0, &scene), STATUS_INPUT);
		assert_says(cases[i].says);
	}
	assert_int_equal(scene_load_text("{end_time: 0}", folder, NULL, 0, SCENE_HOST, &scene), STATUS_INPUT);
	assert_says("end_time: 0 is out of range");
}

static void an_object_is_checked_as_one_of_the_scene(void **state)
{
	static const char scm[] = "{soil: {name: lunar, bekker_kc: -9e4, bekker_kphi: 820000}, redistribute: {model: scm}, objects: [{name: w, shape: "
				  "{wheel: {radius: 1, width: 1}}}]}";
	static const char box[] = "{redistribute: {model: box}}";
	static const struct {
		const char *scene, *text, *says;
	} cases[] = {
		{scm, "", "object text:1: nothing is written"},
		{scm, "[1]", "object text:1: objects[0]: is a list; allowed: a mapping of name, shape, path"},
		{scm, "{shape: {sphere: {radius: 1}},\nsinks: 1}", "object text:2: objects[0].sinks: unknown key; allowed: name, shape"},
		{scm, "{name: a}", "object text:1: objects[0].shape: is missing"},
		{scm, "{shape: {sphere: {radius: -1}}}", "objects[0].shape.sphere.radius: -1 is out of range; allowed: 0.001 to 1000"},
		{scm, "{shape: {sphere: {radius: 1}, box: {size: [1, 1, 1]}}}", "objects[0].shape: names 2 shapes"},
		{scm, "{shape: {wheel: {radius: 1, width: 1, grouser_height: 0.1}}}", "objects[0].shape.wheel.grouser_height: is of grousers"},
		{scm, "{shape: {mesh: {file: none.obj}}}", "object text:1: objects[0].shape.mesh.file: \"none.obj\": No such file"},
		{scm, "{name: w, shape: {sphere: {radius: 1}}}", "objects[0].name: \"w\" is the name of another object"},
		{scm, "{name: a b, shape: {sphere: {radius: 1}}}", "objects[0].name: \"a b\" is not a name"},
		{scm, "{shape: {wheel: {radius: 1, width: 0.1}}}", "objects[0].shape: the soil does not bear it: bekker_kc / b + bekker_kphi is "
								   "-8e+04, and its b is 0.1 m; allowed: above 0"},
		{scm, "{shape: {sphere: {radius: 1}}, load: 5}", "objects[0].load: is for an object with a path"},
		{scm, "{shape: {sphere: {radius: 1}}, sink: 5}", "objects[0].sink: is for an object with a path"},
		{scm, "{shape: {wheel: {radius: 1, width: 1}}, slip: 0.5}", "objects[0].slip: is for an object with a path"},
		{scm, "{shape: {sphere: {radius: 1}}, slip: 0.5, path: {points: [[1, 1]], speed: 1}}", "objects[0].slip: only a wheel or a belt slips"},
		{scm, "{shape: {sphere: {radius: 1}}, sink: 1, load: 1, path: {points: [[1, 1]], speed: 1}}", "sink is given too"},
		{scm, "{shape: {sphere: {radius: 1}}, sink: 1, path: {file: z.csv}}", "objects[0].sink: its poses say z already"},
		{scm, "{shape: {sphere: {radius: 1}}, load: 1, path: {file: z.csv}}", "objects[0].load: its poses say z already"},
		{scm, "{shape: {sphere: {radius: 1}}, path: {points: [[1, 1]]}}", "objects[0].path: has no speed"},
		{scm, "{shape: {sphere: {radius: 1}}, path: {file: none.csv}}", "objects[0].path.file: \"none.csv\": No such file"},
		{box, "{shape: {sphere: {radius: 1}}, load: 1, path: {points: [[1, 1]], speed: 1}}", "objects[0].load: model box computes no force"},
		{box, "{shape: {sphere: {radius: 1}}, interface: {friction_angle: 9}}", "objects[0].interface: model box does not depend on it"},
		{box, "{shape: {wheel: {radius: 1, width: 1}}, slip: 0.1, path: {points: [[1, 1]], speed: 1}}", "model box does not depend on it"},
	};
	write_text("z.csv", "0,1,2,3\n");
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		struct scene *scene = hosted(cases[i].scene);
		struct scene_object object;
		assert_int_equal(scene_object_parse(scene, cases[i].text, &object), STATUS_INPUT);
		assert_says(cases[i].says);
		assert_null(object.name);
		scene_destroy(scene);
	}
	assert_int_equal(unlink(in_folder("z.csv")), 0);
}

static void an_object_becomes_what_the_scene_would_make_of_it(void **state)
{
	static const char entry[] = "{name: w, shape: {wheel: {radius: 0.25, width: 0.2, grousers: 12}}, path: {points: [[1, 2], [3, 4]], speed: 2}, load: 9, "
				    "interface: {adhesion: 40}}";
	char whole[400];
	snprintf(whole, sizeof whole, "{soil: {name: lunar}, redistribute: {model: scm}, objects: [%s]}", entry);
	struct scene *with = hosted(whole), *without = hosted("{soil: {name: lunar}, redistribute: {model: scm}}");
	struct scene_object object, body;
	assert_int_equal(scene_object_parse(without, entry, &object), STATUS_OK);
	assert_string_equal(object.name, "w");
	assert_memory_equal(&object.shape, &with->objects[0].shape, sizeof object.shape);
	assert_true(object.load == 9 && object.path.speed == 2 && object.path.count == 2);
	assert_memory_equal(object.path.points, with->objects[0].path.points, 2 * sizeof *object.path.points);
	assert_int_equal(scene_object_effects(&object), EFFECT_BIT(EFFECT_GROUSERS) | EFFECT_BIT(EFFECT_LOAD));
	assert_int_equal(scene_object_parse(with, "{\"shape\": {\"sphere\": {\"radius\": 5e-1}}}", &body), STATUS_OK);
	assert_string_equal(body.name, "body-1");
	assert_true(object.interface.has_adhesion && object.interface.adhesion == 40 && !object.interface.has_friction && !body.interface.has_adhesion);
	assert_true(body.path.count == 0 && body.path.points == NULL && body.shape.radius == 0.5);
	assert_int_equal(scene_object_effects(&body), 0);
	scene_destroy(with);
	scene_destroy(without);
	scene_object_finish(&object);
	scene_object_finish(&body);
}

/* --- several threads --- */

struct loader {
	struct thread thread;
	const char *model, *says;
	int wrong;
};

static void *load_again_and_again(void *argument)
{
	struct loader *loader = argument;
	char text[400];
	snprintf(text, sizeof text, "{soil: {name: dry_sand}, redistribute: {model: %s}, objects: [{shape: {mesh: {file: %s.obj}}}]}", loader->model,
		 loader->model);
	for (int i = 0; i < 50; i++) {
		struct scene *scene = NULL, *none = NULL;
		if (scene_load_text(text, folder, NULL, 0, SCENE_HOST, &scene) != STATUS_OK ||
		    strcmp(deform_model_row(scene->model)->name, loader->model) != 0 ||
		    scene->objects[0].mesh->triangle_count != (strcmp(loader->model, "scm") == 0 ? 1 : 2))
			loader->wrong++;
		if (scene_load_text(loader->says, folder, NULL, 0, SCENE_HOST, &none) != STATUS_INPUT ||
		    strncmp(strstr(failure_message(), "1:2: ") + 5, loader->says + 1, 3) != 0)
			loader->wrong++;
		scene_destroy(scene);
	}
	return NULL;
}

static void threads_load_scenes_at_once(void **state)
{
	struct loader loaders[2] = {{.model = "scm", .says = "{abc: 1}"}, {.model = "sumner", .says = "{def: 1}"}};
	write_text("scm.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
	write_text("sumner.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n");
	struct scene *scene;
	if (scene_load_text("{objects: [{shape: {mesh: {file: scm.obj}}}]}", folder, NULL, 0, SCENE_HOST, &scene) != STATUS_OK) {
		assert_says("reads no meshes");
		goto out;
	}
	scene_destroy(scene);
	for (int i = 0; i < 2; i++)
		assert_int_equal(thread_start(&loaders[i].thread, load_again_and_again, &loaders[i], "loader"), STATUS_OK);
	for (int i = 0; i < 2; i++)
		thread_join(&loaders[i].thread);
	assert_int_equal(loaders[0].wrong + loaders[1].wrong, 0);
out:
	assert_int_equal(unlink(in_folder("scm.obj")) + unlink(in_folder("sumner.obj")), 0);
}

static void failing_memory_is_told(void **state)
{
	struct scene *scene, *base = hosted("{objects: [{shape: {sphere: {radius: 1}}}]}");
	struct scene_object object;
	enum status status;
	uint64_t nth = 0;
	do {
		mem_fail_nth(++nth, false);
		status = scene_load_text("{store: a, objects: [{shape: {sphere: {radius: 1}}}]}", NULL, NULL, 0, SCENE_HOST, &scene);
		mem_fail_nth(0, false);
		assert_true(status == STATUS_OK || status == STATUS_FAILED);
		if (status != STATUS_OK)
			assert_says("out of memory");
	} while (status != STATUS_OK);
	assert_true(nth > 20);
	scene_destroy(scene);
	nth = 0;
	do {
		mem_fail_nth(++nth, false);
		status = scene_object_parse(base, "{shape: {sphere: {radius: 1}}, path: {points: [[1, 2]], speed: 1}}", &object);
		mem_fail_nth(0, false);
		assert_true(status == STATUS_OK || status == STATUS_FAILED);
	} while (status != STATUS_OK);
	assert_true(nth > 20);
	scene_object_finish(&object);
	scene_destroy(base);
}

TEST_PROGRAM(host)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_text_is_the_scene_that_its_file_is),
		cmocka_unit_test(a_text_knows_its_folder_and_without_one_the_processs),
		cmocka_unit_test(json_is_a_scene),
		cmocka_unit_test(a_text_has_a_size),
		cmocka_unit_test(a_host_may_leave_out_what_the_command_needs),
		cmocka_unit_test(advice_takes_bodies_without_paths_and_no_end),
		cmocka_unit_test(the_command_needs_them),
		cmocka_unit_test(an_object_is_checked_as_one_of_the_scene),
		cmocka_unit_test(an_object_becomes_what_the_scene_would_make_of_it),
		cmocka_unit_test(threads_load_scenes_at_once),
		cmocka_unit_test(failing_memory_is_told),
	};
	return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
