/* The table of effects: each described once, by what is there; what calls for each, and why. */
#include <math.h>

#include "fixture.h"
#include "gpu/shader_table.h"
#include "../support/program.h"

static const struct shader_text *shader(const char *path)
{
	const struct shader_text *text = gpu_shader_table;
	while (text->path != NULL && strcmp(text->path, path) != 0)
		text++;
	return text->path != NULL ? text : NULL;
}

static void every_effect_has_a_row_that_says_what_it_costs(void **state)
{
	for (int e = 0; e < EFFECT_COUNT; e++) {
		const struct effect_row *row = scene_effect_row((enum scene_effect)e);
		enum scene_effect found;
		assert_non_null(row->name);
		assert_true(row->key[0] != '\0' && row->what[0] != '\0' && row->limits[0] != '\0');
		assert_true(scene_effect_named(row->name, &found));
		assert_int_equal(found, e); /* each has a name of its own */
		for (size_t i = 0; row->shaders[i] != NULL; i++)
			if (shader(row->shaders[i]) == NULL || (i == 0 && strstr(shader(row->shaders[i])->text, row->define) == NULL))
				fail_msg("%s: no %s with %s", row->name, row->shaders[i], row->define);
	}
	enum scene_effect none;
	assert_false(scene_effect_named("normal", &none));
}

static void every_shader_that_is_a_stage_is_some_effects(void **state)
{
	for (const struct shader_text *text = gpu_shader_table; text->path != NULL; text++) {
		size_t length = strlen(text->path);
		bool used = strcmp(text->path + length - strlen(".frag"), ".frag") != 0;
		for (int e = 0; e < EFFECT_COUNT; e++)
			for (const char *const *path = scene_effect_row((enum scene_effect)e)->shaders; *path != NULL; path++)
				used = used || strcmp(*path, text->path) == 0;
		if (!used)
			fail_msg("%s: of no effect", text->path);
	}
}

static void every_parameter_is_a_key_with_a_range(void **state)
{
	for (int e = 0; e < EFFECT_COUNT; e++)
		for (const char *const *key = scene_effect_row((enum scene_effect)e)->parameters; *key != NULL; key++) {
			struct scene_parameter parameter;
			if (!scene_parameter(*key, &parameter))
				fail_msg("%s: the scene has no such key", *key);
			bool is_number = strstr(parameter.kind, "number") != NULL;
			if (is_number != isfinite(parameter.low) || is_number != (parameter.high > parameter.low))
				fail_msg("%s: %s without a range", *key, parameter.kind);
			assert_true((strcmp(parameter.kind, "word") == 0) == (parameter.words[0] != '\0'));
		}
}

static void a_parameter_is_what_the_scene_takes(void **state)
{
	struct scene_parameter parameter;
	assert_true(scene_parameter("redistribute.interval", &parameter));
	assert_string_equal(parameter.kind, "number");
	assert_string_equal(parameter.unit, "s");
	assert_true(parameter.low == 0 && parameter.above && parameter.high == 3600 && parameter.absent == 0.05);
	assert_true(scene_parameter("redistribute.depth", &parameter));
	assert_true(isnan(parameter.absent));
	assert_non_null(strstr(parameter.otherwise, "scm"));
	assert_true(scene_parameter("redistribute.undisturbed", &parameter));
	assert_string_equal(parameter.kind, "word");
	assert_string_equal(parameter.words, "stable, slides");
	assert_true(scene_parameter("objects[].shape.box.size[]", &parameter));
	assert_true(parameter.low == 0.001 && parameter.absent != parameter.absent && parameter.otherwise == NULL);
	assert_true(scene_parameter("cache.slots", &parameter));
	assert_string_equal(parameter.kind, "whole number");
	assert_true(parameter.absent == 256);
	assert_true(scene_parameter("objects[].path.loop", &parameter));
	assert_string_equal(parameter.kind, "switch");
	assert_true(scene_parameter("soil.classes", &parameter));
	assert_string_equal(parameter.kind, "list");
	assert_true(scene_parameter("soil.map", &parameter));
	assert_string_equal(parameter.kind, "text");
	assert_true(scene_parameter("view.camera", &parameter));
	assert_string_equal(parameter.kind, "mapping");
	static const char *const none[] = {"sloth", "cache.slot", "cache.slots.x", "cache[]", "objects[].sinks", "soil.map[]"};
	for (size_t i = 0; i < sizeof none / sizeof none[0]; i++)
		assert_false(scene_parameter(none[i], &parameter));
}

static const char quiet[] = "scene: 1\nend_time: 1\n"
			    "cache: {loaders: 0, prefetch: 0}\n"
			    "view: {camera: {eye: [1, 2, 3], target: [0, 0, 0]}}\n";
static const char object[] = "scene: 1\nend_time: 1\n"
			     "cache: {loaders: 0, prefetch: 0}\n"
			     "objects:\n"
			     "  - {name: a, shape: {wheel: {radius: 1, width: 1}}, path: {points: [[1, 2], [9, 2]], speed: 3}}\n";

static const char seen[] = "scene: 1\nend_time: 1\n"
			   "cache: {loaders: 0, prefetch: 0}\n"
			   "view: {camera: {chase: a}}\n"
			   "objects:\n"
			   "  - {name: a, shape: {wheel: {radius: 1, width: 1}}, path: {points: [[1, 2], [9, 2]], speed: 3}}\n";

static const char plate[] = "scene: 1\nend_time: 1\n"
			    "cache: {loaders: 0, prefetch: 0}\n"
			    "soil: {name: dry_sand}\n"
			    "redistribute: {model: scm}\n"
			    "objects:\n"
			    "  - {name: a, shape: {box: {size: [1, 1, 1]}}, path: {points: [[1, 2], [9, 2]], speed: 3}}\n";

static const char rolls[] = "scene: 1\nend_time: 1\n"
			    "cache: {loaders: 0, prefetch: 0}\n"
			    "soil: {name: dry_sand}\n"
			    "redistribute: {model: scm}\n"
			    "objects:\n"
			    "  - {name: a, shape: {wheel: {radius: 0.4, width: 0.2}}, path: {points: [[1, 2], [9, 2]], speed: 3}}\n";

/* Each in turn: what it adds to the bare scene, and why; and nothing more. */
static void each_key_calls_for_its_own(void **state)
{
	static const struct {
		const char *bare, *key, *value;
		uint64_t adds;
		const char *reason; /* of the first of them */
	} keys[] = {
		{object, "redistribute.model", "box", EFFECT_BIT(EFFECT_OF(DEFORM_BOX_FILTER)), "redistribute.model: box"},
		{object, "attributes", "[disturbance]", EFFECT_BIT(EFFECT_DISTURBANCE), "attributes.disturbance"},
		{object, "attributes", "{vegetation: {}}", EFFECT_BIT(EFFECT_VEGETATION), "attributes.vegetation"},
		{object, "objects.a.shape.wheel.grousers", "5", EFFECT_BIT(EFFECT_GROUSERS), "objects.a.shape.wheel.grousers"},
		{rolls, "objects.a.shape.wheel.tyre", "{stiffness: 1e5, load: 900}", EFFECT_BIT(EFFECT_TYRES), "objects.a.shape.wheel.tyre"},
		{plate, "objects.a.carry", "true", EFFECT_BIT(EFFECT_CARRIED), "objects.a.carry"},
		{object, "cache.loaders", "3", EFFECT_BIT(EFFECT_LOADERS), "cache.loaders: 3"},
		{object, "cache.prefetch", "0.5", EFFECT_BIT(EFFECT_PREFETCH), "cache.prefetch: 0.5"},
		{object, "view.camera.chase", "a", EFFECT_BIT(EFFECT_PYRAMID) | EFFECT_BIT(EFFECT_PICTURE) | EFFECT_BIT(EFFECT_NORMALS), "view"},
		{quiet, "view.images", "4", EFFECT_BIT(EFFECT_IMAGES), "view.images: 4"},
		{quiet, "cameras", "[{name: c, kind: fixed, rate: 1, pose: {at: [1, 2, 3]}}]", EFFECT_BIT(EFFECT_CAMERAS), "cameras"},
		{quiet, "view.exposure", "auto", EFFECT_BIT(EFFECT_LIGHT), "view.exposure"},
		{quiet, "view.samples", "4", EFFECT_BIT(EFFECT_ANTIALIAS), "view.samples: 4"},
		{quiet, "view.samples", "1", 0, NULL},
		{quiet, "view.effects", "[fog]", EFFECT_BIT(EFFECT_FOG), "view.effects.fog"},
		{quiet, "view.effects", "[sky]", EFFECT_BIT(EFFECT_SKY), "view.effects.sky"},
		{quiet, "view.effects", "[texture]", EFFECT_BIT(EFFECT_TEXTURE), "view.effects.texture"},
		{quiet, "view.effects", "[splat]", EFFECT_BIT(EFFECT_SPLAT), "view.effects.splat"},
		{quiet, "view.effects", "[skirts]", EFFECT_BIT(EFFECT_SKIRTS), "view.effects.skirts"},
		{quiet, "view.effects", "[terrain_shadow]", EFFECT_BIT(EFFECT_TERRAIN_SHADOW), "view.effects.terrain_shadow"},
		{quiet, "view.effects", "[imagery]", EFFECT_BIT(EFFECT_IMAGERY), "view.effects.imagery"},
		{seen, "view.effects", "[objects]", EFFECT_BIT(EFFECT_OBJECTS), "view.effects.objects"},
		{seen, "view.effects", "[objects, shadow]", EFFECT_BIT(EFFECT_OBJECTS) | EFFECT_BIT(EFFECT_SHADOW), "view.effects.objects"},
		{seen, "view.effects", "[shadow]", 0, NULL}, /* of nothing that is drawn */
		{quiet, "view.effects", "[objects, shadow]", 0, NULL},
		{quiet, "attributes", "[disturbance]", 0, NULL},
		{quiet, "redistribute.model", "box", 0, NULL},
		{quiet, "cache.prefetch", "3", 0, NULL},
	};
	for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++) {
		struct scene *bare, *with;
		char reason[160];
		assert_int_equal(load_text(keys[i].bare, NULL, 0, &bare), STATUS_OK);
		assert_int_equal(load_text(keys[i].bare, &(struct scene_setting){keys[i].key, keys[i].value}, 1, &with), STATUS_OK);
		assert_int_equal(scene_effects(with, 0), scene_effects(bare, 0) | keys[i].adds);
		assert_int_equal(scene_effects(bare, 0) & keys[i].adds, 0);
		for (int e = EFFECT_COUNT - 1; e >= 0 && keys[i].adds != 0; e--)
			if ((keys[i].adds >> e & 1) != 0)
				scene_effect_reason(with, (enum scene_effect)e, reason, sizeof reason);
		if (keys[i].adds != 0)
			assert_string_equal(reason, keys[i].reason);
		scene_destroy(with);
		scene_destroy(bare);
	}
}

static void finer_posts_than_the_sources_are_interpolated(void **state)
{
	struct scene *scene;
	char reason[80];
	assert_int_equal(load_text(object, NULL, 0, &scene), STATUS_OK);
	assert_int_equal(scene_effects(scene, -1), scene_effects(scene, 0) | EFFECT_BIT(EFFECT_SUBDIVIDE));
	assert_int_equal(scene_effects(scene, 2), scene_effects(scene, 0));
	scene_effect_reason(scene, EFFECT_SUBDIVIDE, reason, sizeof reason);
	assert_string_equal(reason, "the store's working level");
	scene_destroy(scene);
	assert_int_equal(load_text(object, &(struct scene_setting){"spacing", "0.25"}, 1, &scene), STATUS_OK);
	scene_effect_reason(scene, EFFECT_SUBDIVIDE, reason, sizeof reason);
	assert_string_equal(reason, "spacing: 0.25");
	scene_destroy(scene);
}

static void pictures_are_counted_by_the_step(void **state)
{
#define BALL "scene: 1\nend_time: 1\nobjects: [{name: ball, shape: {sphere: {radius: 1}}, path: {points: [[1, 1], [2, 2]], speed: 1}}]\n"
	static const struct {
		const char *text;
		double pixels;
	} cases[] = {
		{BALL, 0},
		{BALL "view: {size: [200, 100], camera: {overhead: {over: ball, height: 9}}}\n", 0}, /* a window alone shows it */
		{BALL "view: {size: [200, 100], camera: {overhead: {over: ball, height: 9}}, images: 50}\n", 400},
		{BALL "time_step: 0.01\ncameras: [{name: a, kind: overhead, on: ball, height: 9, size: [200, 100], rate: 10}]\n", 2000},
		/* Normals are drawn a second time. */
		{BALL "time_step: 0.01\ncameras: [{name: a, kind: overhead, on: ball, height: 9, size: [200, 100], rate: 10, "
		 "images: [normals]}]\n", 4000},
	};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		struct scene *scene = NULL;
		if (load_text(cases[i].text, NULL, 0, &scene) != STATUS_OK)
			fail_msg("%s: %s", cases[i].text, failure_message());
		if (!(fabs(scene_pixels_a_step(scene) - cases[i].pixels) <= 1e-9))
			fail_msg("%s: %g pixels", cases[i].text, scene_pixels_a_step(scene));
		scene_destroy(scene);
	}
#undef BALL
}

TEST_PROGRAM(effects)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_effect_has_a_row_that_says_what_it_costs),
		cmocka_unit_test(every_shader_that_is_a_stage_is_some_effects),
		cmocka_unit_test(every_parameter_is_a_key_with_a_range),
		cmocka_unit_test(a_parameter_is_what_the_scene_takes),
		cmocka_unit_test(each_key_calls_for_its_own),
		cmocka_unit_test(pictures_are_counted_by_the_step),
		cmocka_unit_test(finer_posts_than_the_sources_are_interpolated),
	};
	return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
