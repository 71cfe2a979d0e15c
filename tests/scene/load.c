/* What a good scene becomes. */
#include "fixture.h"
#include "../support/program.h"

static struct scene *load(const char *text)
{
	struct scene *scene;
	if (load_text(text, NULL, 0, &scene) != STATUS_OK)
		fail_msg("%s", failure_message());
	return scene;
}

static void the_manuals_scene_has_the_values_it_says(void **state)
{
	struct scene *scene = load(example);
	assert_string_equal(scene->file, in_folder("scene.yaml"));
	assert_string_equal(scene->store, in_folder("world.furrow"));
	assert_int_equal(scene->soil_count, 0); /* box reads none */
	assert_true(scene->time_step == 0.02 && scene->end_time == 30 && scene->gravity == 9.81);
	assert_true(scene->spacing == 0.125);
	assert_int_equal(scene->coordinates, SCENE_LOCAL);
	assert_int_equal(scene->model, DEFORM_BOX_FILTER);
	assert_int_equal(scene->box_radius, 1);
	assert_int_equal(scene->box_repetitions, 1);
	assert_true(scene->disturbance);
	assert_int_equal(scene->outside, SCENE_STOP);
	assert_int_equal(scene->object_count, 1);
	const struct scene_object *wheel = &scene->objects[0];
	assert_string_equal(wheel->name, "front_left");
	assert_int_equal(wheel->shape.kind, SOIL_WHEEL);
	assert_true(wheel->shape.radius == 0.5 && wheel->shape.width == 0.4);
	assert_int_equal(wheel->path.count, 2);
	assert_true(wheel->path.points[0].x == 10 && wheel->path.points[0].y == 10);
	assert_true(wheel->path.points[1].x == 90 && wheel->path.points[1].y == 40);
	assert_true(wheel->path.speed == 5 && !wheel->path.loop && !wheel->path.timed);
	assert_true(wheel->sink == 0.1);
	assert_true(scene->view.present);
	assert_int_equal(scene->view.width, 1280);
	assert_int_equal(scene->view.height, 720);
	assert_int_equal(scene->view.aim.kind, SCENE_CHASE);
	assert_int_equal(scene->view.aim.object, 0);
	assert_true(scene->view.aim.back == 12 && scene->view.aim.up == 5);
	assert_int_equal(scene->view.images, 100);
	assert_int_equal(scene->view.samples, 1);
	assert_true(scene->view.pixel_error == 0);
	assert_int_equal(scene->slots, 256);
	assert_int_equal(scene->loaders, 2);
	assert_true(scene->prefetch == 1.5);
	assert_int_equal(strlen(scene->hash), 32);
	uint64_t view = EFFECT_BIT(EFFECT_TEXTURE) | EFFECT_BIT(EFFECT_DETAIL) | EFFECT_BIT(EFFECT_FOG) | EFFECT_BIT(EFFECT_SKY) |
			EFFECT_BIT(EFFECT_GEOMORPH) | EFFECT_BIT(EFFECT_SKIRTS);
	assert_int_equal(scene_effects(scene, 0), view | EFFECT_BIT(EFFECT_OF(DEFORM_NONE)) | EFFECT_BIT(EFFECT_OF(DEFORM_BOX_FILTER)) | EFFECT_BIT(EFFECT_DISTURBANCE) |
							 EFFECT_BIT(EFFECT_PYRAMID) | EFFECT_BIT(EFFECT_PICTURE) | EFFECT_BIT(EFFECT_NORMALS) |
							 EFFECT_BIT(EFFECT_IMAGES) | CACHE_EFFECTS);
	scene_destroy(scene);
}

static void what_is_absent_is_its_default_and_calls_for_nothing(void **state)
{
	struct scene *scene = load(minimal);
	assert_null(scene->store);
	assert_int_equal(scene->soil_count, 0);
	assert_null(scene->soil_map);
	assert_null(scene->srs);
	assert_true(scene->forces == 0);
	assert_true(scene->objects[0].load == 0 && scene->objects[0].slip == 0);
	assert_null(scene->objects[0].mesh);
	assert_int_equal(scene->objects[0].shape.grousers, 0);
	assert_true(scene->iterations == 0 && scene->interval == 0 && scene->depth == 0 && scene->bulldozing == 0);
	assert_true(scene->time_step == 0.02 && scene->gravity == 9.81 && scene->spacing == 0);
	assert_int_equal(scene->model, DEFORM_NONE);
	assert_false(scene->disturbance);
	assert_false(scene->view.present);
	assert_int_equal(scene->slots, 256);
	assert_int_equal(scene->loaders, 2);
	assert_true(scene->prefetch == 1.5 && scene->objects[0].sink == 0);
	assert_int_equal(scene_effects(scene, 0), EFFECT_BIT(EFFECT_OF(DEFORM_NONE)) | CACHE_EFFECTS);
	scene_destroy(scene);
}

static void a_view_without_objects_deforms_nothing(void **state)
{
	struct scene *scene = load("scene: 1\nend_time: 1\nattributes: [disturbance]\n"
				   "redistribute: {model: box, radius: 2, repetitions: 3}\n"
				   "view: {camera: {fixed: {eye: [1, 2, 3], target: [4, 5, -6]}}}\n");
	assert_int_equal(scene->view.aim.kind, SCENE_FIXED);
	assert_true(scene->view.aim.eye[2] == 3 && scene->view.aim.target[2] == -6);
	assert_int_equal(scene->view.width, 1280);
	assert_int_equal(scene->box_radius, 2);
	assert_int_equal(scene->box_repetitions, 3);
	assert_int_equal(scene_effects(scene, 0), EFFECT_BIT(EFFECT_PICTURE) | EFFECT_BIT(EFFECT_NORMALS) | EFFECT_BIT(EFFECT_PYRAMID) | EFFECT_BIT(EFFECT_LOADERS));
	scene_destroy(scene);
}

static void a_camera_may_be_written_flat_or_under_its_name(void **state)
{
	static const char *const cameras[] = {"{over: front_left, height: 40}",
					      "{overhead: {over: front_left, height: 40}}"};
	for (size_t i = 0; i < 2; i++) {
		char *text = edited(example, "{chase: front_left, back: 12, up: 5}", cameras[i]);
		struct scene *scene = load(text);
		assert_int_equal(scene->view.aim.kind, SCENE_OVERHEAD);
		assert_int_equal(scene->view.aim.object, 0);
		assert_true(scene->view.aim.over_height == 40);
		scene_destroy(scene);
		free(text);
	}
	char *text = edited(example, "{chase: front_left, back: 12, up: 5}",
			    "{eye: [1, 2, 3], target: [0, 0, 0]}");
	struct scene *scene = load(text);
	assert_int_equal(scene->view.aim.kind, SCENE_FIXED);
	scene_destroy(scene);
	free(text);
}

static void an_srs_is_whatever_is_neither_local_nor_store(void **state)
{
	char *text = edited(example, "coordinates: local", "coordinates: EPSG:4326");
	struct scene *scene = load(text);
	assert_int_equal(scene->coordinates, SCENE_SRS);
	assert_string_equal(scene->srs, "EPSG:4326");
	scene_destroy(scene);
	free(text);
	text = edited(example, "coordinates: local", "coordinates: store");
	scene = load(text);
	assert_int_equal(scene->coordinates, SCENE_STORE);
	assert_null(scene->srs);
	scene_destroy(scene);
	free(text);
}

static void the_hash_is_of_what_the_ground_becomes(void **state)
{
	static const struct {
		const char *from, *to;
		bool same;
	} edits[] = {
		{"slots: 256", "slots: 16", true},
		{"images: 100", "images: 1", true},
		{"images: 100", "pixel_error: 2.5", true},
		{"images: 100", "samples: 8", true},
		{"images: 100", "body: mars", true},
		{"images: 100", "sun: {azimuth: 90, height: 5, colour: [1, 0.5, 0.2]}", true},
		{"# they act in", "# or not, they act in", true},
		{"store: world", "store: other", true},
		{"end_time: 30", "end_time: 60", true},
		{"speed: 5", "speed: 5.0", true},
		{"speed: 5", "speed: 6", false},
		{"sink: 0.1", "sink: 0.2", false},
		{"[90, 40]", "[90, 41]", false},
		{"time_step: 0.02", "time_step: 0.01", false},
		{"radius: 0.5", "radius: 0.6", false},
		{"name: front_left", "name: front_left2", false},
		{"spacing: 0.125", "spacing: 0.25", false},
		{"dry_sand", "lunar", true}, /* box reads no soil */
		{"soil: {name: dry_sand}", "", true},
		{"grousers: 0", "grousers: 4", false},
		{"grousers: 0", "grousers: 0", true},
		{"view:", "output: {forces: 0}\nview:", true},
		{"model: box", "model: none", false},
		{"model: box", "model: box, radius: 2", false},
		{"attributes: [disturbance]", "attributes: []", false},
		{"coordinates: local", "coordinates: store", false},
		{"outside: stop", "outside: skip", false},
		{"loop: false", "loop: true", false},
	};
	struct scene *first = load(example);
	for (size_t i = 0; i < sizeof edits / sizeof edits[0]; i++) {
		char *text = edited(example, edits[i].from, edits[i].to), *whole = text;
		if (strstr(edits[i].to, "front_left2") != NULL) {
			whole = edited(text, "chase: front_left", "chase: front_left2");
			free(text);
		}
		struct scene *scene = load(whole);
		if ((strcmp(scene->hash, first->hash) == 0) != edits[i].same)
			fail_msg("%s: the hash is wrong to %s", edits[i].to,
				 edits[i].same ? "differ" : "be the same");
		scene_destroy(scene);
		free(whole);
	}
	scene_destroy(first);
}

/* From before there were soils: what a record of then says must still be found to be the same scene. */
static void a_scene_of_earlier_models_keeps_its_hash(void **state)
{
	struct scene *scene = load(minimal);
	assert_string_equal(scene->hash, "0ea1a9a657162712342febeafb989b12");
	scene_destroy(scene);
	char *text = edited(example, "soil: {name: dry_sand}\n", "");
	scene = load(text);
	assert_string_equal(scene->hash, "dd22223eb9db9e26c1a16f70935571a3");
	scene_destroy(scene);
	free(text);
}

/* A soil counts with every number that its name had when hashes were first kept, read by the model or not. */
static void a_scene_of_soil_keeps_its_hash(void **state)
{
	static const struct {
		const char *soil, *hash;
	} soils[] = {
		{"soil: {name: lunar}\nredistribute: {model: scm}\n", "94e23d2977fa781df3e2749b512c3fac"},
		{"soil: {name: lete_sand, cohesion: 0}\nredistribute: {model: scm}\n", "269e2b85d818791bd70c733fcad088a3"},
		{"soil: {name: clayey_38}\nredistribute: {model: slippage}\n", "e67bfc17a7b4ac528a12ca5838162059"},
		{"soil: {name: dry_sand}\nredistribute: {model: sumner}\n", "1b8f635b3767aaadf5ea05765c678a4f"},
		{"soil: {name: sand}\nredistribute: {model: sumner}\n", "1b8f635b3767aaadf5ea05765c678a4f"},
		{"soil: {name: mud, theta_in: 80}\nredistribute: {model: sumner}\n", "23562b35c9276b36e85f66c392c776ac"},
		{"soil: {name: snow}\nredistribute: {model: sumner}\n", "c850c6de171ee85d232ec844f414c21f"},
		{"soil: {theta_in: 46, theta_out: 25, theta_stop: 46, roughness: 0.2, compression: 0.3}\nredistribute: {model: sumner}\n", "621373b190132f9c8474c80dd6106a40"},
		{"soil: {cohesion: 0, friction_angle: 30, unit_weight: 16000}\nredistribute: {model: slippage}\n", "a5a773020e634f0a48938cacf8d2c9ea"},
	};
	for (size_t i = 0; i < sizeof soils / sizeof soils[0]; i++) {
		char *text = edited(minimal, "end_time: 1\n", "end_time: 1\nSOIL");
		char *whole = edited(text, "SOIL", soils[i].soil);
		struct scene *scene = load(whole);
		assert_string_equal(scene->hash, soils[i].hash);
		scene_destroy(scene);
		free(whole);
		free(text);
	}
}

TEST_PROGRAM(load)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_manuals_scene_has_the_values_it_says),
		cmocka_unit_test(what_is_absent_is_its_default_and_calls_for_nothing),
		cmocka_unit_test(a_view_without_objects_deforms_nothing),
		cmocka_unit_test(a_camera_may_be_written_flat_or_under_its_name),
		cmocka_unit_test(an_srs_is_whatever_is_neither_local_nor_store),
		cmocka_unit_test(the_hash_is_of_what_the_ground_becomes),
		cmocka_unit_test(a_scene_of_earlier_models_keeps_its_hash),
		cmocka_unit_test(a_scene_of_soil_keeps_its_hash),
	};
	return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
