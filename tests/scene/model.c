/* What a scene says of its soil model and of bodies on soil: parameters, loads, slip, grousers, meshes, forces, and the hash. */
#include "soil.h"
#include "../support/program.h"
#include "../support/skip.h"

static void a_model_has_its_own_parameters_with_their_defaults(void **state)
{
	static const struct {
		const char *model;
		enum deform_model is;
		double depth, bulldozing, slip_sinkage, loosening;
	} models[] = {{"sumner", DEFORM_SUMNER, (double)INFINITY, 0, 0, 0},
		      {"slippage", DEFORM_SLIPPAGE, (double)INFINITY, 0, 0, 0},
		      {"scm", DEFORM_SCM, 0, 0.5, 1.35, 0}};
	for (size_t i = 0; i < 3; i++) {
		struct scene *scene = load_edited(base, "scm", models[i].model);
		assert_int_equal(scene->model, models[i].is);
		assert_int_equal(scene->iterations, 1);
		assert_true(scene->interval == 0.05 && scene->depth == models[i].depth);
		assert_true(scene->bulldozing == models[i].bulldozing && scene->slip_sinkage == models[i].slip_sinkage && scene->loosening == models[i].loosening && scene->hardening == 0 && scene->tolerance == 0);
		scene_destroy(scene);
	}
	struct scene *scene = load_edited(base, "model: scm", "model: scm, iterations: 5, interval: 0.5, depth: 1.5, bulldozing: 0.25, slip_sinkage: 0.5, tolerance: 0.01");
	assert_int_equal(scene->iterations, 5);
	assert_true(scene->interval == 0.5 && scene->depth == 1.5 && scene->bulldozing == 0.25 && scene->slip_sinkage == 0.5 && scene->tolerance == 0.01);
	assert_int_equal(scene->normals, SCENE_BODY);
	scene_destroy(scene);
	scene = load_edited(base, "model: scm", "model: scm, normals: ground");
	assert_int_equal(scene->normals, SCENE_GROUND);
	scene_destroy(scene);
	refuse("model: scm", "model: scm, radius: 2", ":4: redistribute.radius: is no parameter of model scm; allowed with: box");
	refuse("model: scm", "model: none, repetitions: 2", "repetitions: is no parameter of model none; allowed with: box");
	refuse("model: scm", "model: box, iterations: 2", "is no parameter of model box; allowed with: sumner, slippage, scm");
	refuse("model: scm", "model: none, interval: 2", "interval: is no parameter of model none");
	refuse("model: scm", "model: box, tolerance: 0", "tolerance: is no parameter of model box; allowed with: sumner, slippage, scm");
	refuse("model: scm", "model: box, depth: 2", "depth: is no parameter of model box");
	refuse("model: scm", "model: slippage, regions: fixed", "regions: is no parameter of model slippage; allowed with: none, box");
	refuse("model: scm", "model: scm, regions: window", "regions: is no parameter of model scm; allowed with: none, box");
	refuse("model: scm", "model: sumner, bulldozing: 1", "is no parameter of model sumner; allowed with: scm");
	refuse("model: scm", "model: slippage, tension: 1", "is no parameter of model slippage; allowed with: sheet");
	refuse("model: scm", "model: sheet, bulldozing: 0", "is no parameter of model sheet; allowed with: scm");
	refuse("model: scm", "model: slippage, bulldozing: 0", "is no parameter of model slippage; allowed with: scm");
	refuse("model: scm", "model: slippage, slip_sinkage: 1", "is no parameter of model slippage; allowed with: scm");
	refuse("model: scm", "model: slippage, normals: ground", "normals: is no parameter of model slippage; allowed with: scm");
	refuse("model: scm", "model: scm, normals: up", "\"up\" is unknown; allowed: body, ground");
	refuse("model: scm", "model: mud", ":4: redistribute.model: \"mud\" is unknown; allowed: none, box, sumner, slippage, scm");
}

static void a_surface_has_friction_and_adhesion_each_alone(void **state)
{
	static const struct {
		const char *text;
		struct soil_interface wanted;
	} cases[] = {
		{"", {.has_friction = false}},
		{"    interface: {}\n", {.has_friction = false}},
		{"    interface: {friction_angle: 18}\n", {.has_friction = true, .friction_angle = 18 * M_PI / 180}},
		{"    interface: {adhesion: 250}\n", {.has_adhesion = true, .adhesion = 250}},
		{"    interface: {adhesion: 0, friction_angle: 0}\n", {true, true, 0, 0}},
	};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		char with[120];
		snprintf(with, sizeof with, "3}\n%s", cases[i].text);
		struct scene *scene = load_edited(base, "3}\n", with);
		const struct soil_interface *got = &scene->objects[0].interface;
		assert_true(got->has_friction == cases[i].wanted.has_friction && got->has_adhesion == cases[i].wanted.has_adhesion);
		assert_true(fabs(got->friction_angle - cases[i].wanted.friction_angle) < 1e-15 && got->adhesion == cases[i].wanted.adhesion);
		scene_destroy(scene);
	}
	refuse("scm}\nobjects:\n  - name: a\n", "slippage}\nobjects:\n  - name: a\n    interface: {adhesion: 1}\n",
	       ":7: objects[0].interface: model slippage does not depend on it; allowed with: redistribute: {model: scm}");
	refuse("3}\n", "3}\n    interface: {friction: 1}\n", ":9: objects[0].interface.friction: unknown key; allowed: friction_angle, adhesion");
	refuse("3}\n", "3}\n    interface: 20\n", ":9: objects[0].interface: is a single value; allowed: a mapping of friction_angle, adhesion");
}

static void a_load_takes_the_place_of_a_sinkage(void **state)
{
	struct scene *scene = load_edited(base, "3}\n", "3}\n    load: 4000\n    slip: -0.25\n");
	assert_true(scene->objects[0].load == 4000 && scene->objects[0].sink == 0 && scene->objects[0].slip == -0.25);
	assert_int_equal(scene_effects(scene, 0), EFFECT_BIT(EFFECT_OF(DEFORM_SCM)) | EFFECT_BIT(EFFECT_SPREAD) | EFFECT_BIT(EFFECT_SLIDE) |
							 EFFECT_BIT(EFFECT_LOAD) | EFFECT_BIT(EFFECT_FORCES) | CACHE_EFFECTS);
	char reason[80];
	scene_effect_reason(scene, EFFECT_FORCES, reason, sizeof reason); /* forces are summed for the load */
	assert_string_equal(reason, "objects.a.load");
	scene_destroy(scene);
	refuse("3}\n", "3}\n    load: 1\n    sink: 0\n", ":9: objects[0].load: sink is given too; allowed: one of sink, load");
	refuse("scm}\nobjects:\n  - name: a\n", "box}\nobjects:\n  - name: a\n    load: 4\n", ":7: objects[0].load: model box computes no "
	       "force that carries it; allowed with: redistribute: {model: scm, sheet}");
	refuse("scm}\nobjects:\n  - name: a\n", "sumner}\nobjects:\n  - name: a\n    load: 4\n", "model sumner computes no force");
	refuse("scm}\nobjects:\n  - name: a\n", "sumner}\nobjects:\n  - name: a\n    slip: 0.1\n", ":7: objects[0].slip: model sumner does "
	       "not depend on it; allowed with: redistribute: {model: scm}");
	refuse("wheel: {radius: 0.5, width: 0.4}}\n", "sphere: {radius: 0.5}}\n    slip: 0\n", ":8: objects[0].slip: only a wheel or a belt "
											 "slips; allowed with: wheel, or belt: true of a box or a mesh");
	write_text("poses.csv", "0,1,2,3\n");
	refuse("{points: [[1, 2]], speed: 3}\n", "{file: poses.csv}\n    load: 4\n", ":9: objects[0].load: its poses say z already; allowed with");
	write_text("poses.csv", "0,1,2\n");
	scene = load_edited(base, "{points: [[1, 2]], speed: 3}\n", "{file: poses.csv}\n    load: 4\n");
	assert_true(scene->objects[0].load == 4);
	scene_destroy(scene);
	unlink(in_folder("poses.csv"));
}

/* Only a box and a mesh have a belt, and it is in the hash. */
static void a_belt_slips(void **state)
{
	struct scene *plain = load_edited(base, "wheel: {radius: 0.5, width: 0.4}}\n", "box: {size: [2, 0.4, 0.6]}}\n");
	struct scene *stands = load_edited(base, "wheel: {radius: 0.5, width: 0.4}}\n", "box: {size: [2, 0.4, 0.6], belt: false}}\n");
	struct scene *runs = load_edited(base, "wheel: {radius: 0.5, width: 0.4}}\n", "box: {size: [2, 0.4, 0.6], belt: true}}\n    slip: 0.2\n");
	struct scene *same = load_edited(base, "wheel: {radius: 0.5, width: 0.4}}\n", "box: {size: [2, 0.4, 0.6], belt: true}}\n");
	assert_true(!plain->objects[0].shape.belt && !stands->objects[0].shape.belt && runs->objects[0].shape.belt);
	assert_true(runs->objects[0].slip == 0.2 && same->objects[0].slip == 0);
	assert_string_equal(plain->hash, stands->hash);
	assert_string_not_equal(plain->hash, same->hash);
	assert_string_not_equal(runs->hash, same->hash);
	scene_destroy(plain);
	scene_destroy(stands);
	scene_destroy(runs);
	scene_destroy(same);
	refuse("wheel: {radius: 0.5, width: 0.4}}\n", "box: {size: [2, 0.4, 0.6], belt: false}}\n    slip: 0.2\n", "objects[0].slip: only a wheel or a belt slips");
	refuse("wheel: {radius: 0.5, width: 0.4}}\n", "box: {size: [2, 0.4, 0.6], belt: 2}}\n", "objects[0].shape.box.belt: ");
	refuse("wheel: {radius: 0.5, width: 0.4}}\n", "sphere: {radius: 0.5, belt: true}}\n", "objects[0].shape.sphere.belt: unknown key");
}

static void lugs_have_a_height_and_a_thickness(void **state)
{
	struct scene *scene = load_edited(base, "0.4}", "0.4, grousers: 12}");
	const struct soil_shape *shape = &scene->objects[0].shape;
	assert_int_equal(shape->grousers, 12);
	assert_true(shape->grouser_height == 0.025 && shape->grouser_thickness == 0.05);
	assert_true((scene_effects(scene, 0) >> EFFECT_GROUSERS & 1) == 1);
	scene_destroy(scene);
	scene = load_edited(base, "0.4}", "0.4, grousers: 1, grouser_height: 0.5, grouser_thickness: 0.2}");
	shape = &scene->objects[0].shape;
	assert_true(shape->grousers == 1 && shape->grouser_height == 0.5 && shape->grouser_thickness == 0.2);
	scene_destroy(scene);
	refuse("0.4}", "0.4, grouser_height: 0.1}", ":7: objects[0].shape.wheel.grouser_height: is of grousers, and the wheel has none; allowed with: grousers above 0");
	refuse("0.4}", "0.4, grousers: 0, grouser_thickness: 0.1}", ":7: objects[0].shape.wheel.grouser_thickness: is of grousers");
	refuse("0.4}", "0.4, grousers: 2, grouser_height: 0.6}", ":7: objects[0].shape.wheel.grouser_height: 0.6 is out of range; allowed: above 0 to "
							 "the wheel's radius, 0.5");
	refuse("0.4}", "0.4, grousers: 2.5}", "\"2.5\" is not a whole number; allowed: a whole number, 0 to 128");
}

static void a_mesh_is_read_beside_the_scene_and_counts_by_its_triangles(void **state)
{
	static const char obj[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n";
	static const char wheel[] = "wheel: {radius: 0.5, width: 0.4}", mesh[] = "mesh: {file: foot.obj}";
	char hash[33];
	struct scene *scene;
	refuse(wheel, mesh, ":7: objects[0].shape.mesh.file: \"foot.obj\": ");
	write_text("foot.obj", obj);
	char *text = edited(base, wheel, mesh);
	if (load_text(text, NULL, 0, &scene) != STATUS_OK) {
		assert_says("reads no meshes");
		free(text);
		unlink(in_folder("foot.obj"));
		skip_since("this build reads no meshes");
	}
	const struct scene_object *foot = &scene->objects[0];
	assert_int_equal(foot->shape.kind, SOIL_MESH);
	assert_ptr_equal(foot->shape.mesh, foot->mesh);
	assert_int_equal(foot->mesh->triangle_count, 4);
	assert_true(foot->mesh->high[2] == 1);
	assert_true((scene_effects(scene, 0) >> EFFECT_MESH & 1) == 1);
	strcpy(hash, scene->hash);
	scene_destroy(scene);
	scene = load_edited(base, wheel, "mesh: {file: foot.obj, scale: 2}");
	assert_true(scene->objects[0].mesh->high[2] == 2);
	assert_string_not_equal(scene->hash, hash);
	scene_destroy(scene);
	/* Its triangles, not its bytes or its name. */
	static const struct {
		const char *from, *to;
		bool same;
	} edits[] = {{"v 0 0 0", "# a foot\nv 0 0 0", true}, {"v 0 0 1", "v 0 0 2", false}, {"f 2 3 4\n", "", false}};
	for (size_t i = 0; i < 3; i++) {
		char *other = edited(obj, edits[i].from, edits[i].to);
		write_text("foot.obj", other);
		free(other);
		assert_int_equal(load_text(text, NULL, 0, &scene), STATUS_OK);
		assert_true((strcmp(scene->hash, hash) == 0) == edits[i].same);
		scene_destroy(scene);
	}
	/* What is refused after it was read does not keep it. */
	refuse("wheel: {radius: 0.5, width: 0.4}}\n", "mesh: {file: foot.obj}}\n    slip: 0.1\n", "only a wheel or a belt slips");
	free(text);
	unlink(in_folder("foot.obj"));
}

static void forces_are_of_scm_and_their_delay_has_no_effect(void **state)
{
	struct scene *scene = load_edited(base, "3}\n", "3}\noutput: {forces: 50}\n");
	assert_true(scene->forces == 50);
	assert_true((scene_effects(scene, 0) >> EFFECT_FORCES & 1) == 1);
	scene_destroy(scene);
	scene = load_edited(base, "3}\n", "3}\noutput: {forces: 0.5, delay: 0}\n");
	assert_true(scene->forces == 0.5);
	assert_int_equal(scene->unused_count, 1);
	assert_string_equal(scene->unused[0], "output.delay: forces are known at the end of their step; take it away");
	scene_destroy(scene);
	scene = load_edited(base, "3}\n", "3}\noutput: {}\n");
	assert_true(scene->forces == 0);
	assert_true((scene_effects(scene, 0) >> EFFECT_FORCES & 1) == 0);
	scene_destroy(scene);
	scene = load_edited(base, "scm}", "slippage}\noutput: {forces: 1}"); /* rows of places and sinkages */
	assert_true(scene->forces == 1);
	assert_false(scene_effects(scene, 0) >> EFFECT_FORCES & 1);
	scene_destroy(scene);
}

/* Slip is called for where some body may slip, and nowhere else. */
static void slip_is_of_bodies_that_may_slip(void **state)
{
	static const struct {
		const char *shape, *path;
		bool slips;
	} cases[] = {
		{"wheel: {radius: 0.5, width: 0.4}", "path: {points: [[1, 2], [9, 2]], speed: 3}", false},
		{"wheel: {radius: 0.5, width: 0.4}", "path: {points: [[1, 2], [3, 4], [7, 8]], speed: 3}", false},
		{"wheel: {radius: 0.5, width: 0.4}", "path: {points: [[1, 2]], speed: 3}", false},
		{"box: {size: [1, 1, 1]}", "path: {points: [[1, 2]], speed: 3}", false},
		{"wheel: {radius: 0.5, width: 0.4}", "slip: 0.2, path: {points: [[1, 2], [9, 2]], speed: 3}", true},
		{"wheel: {radius: 0.5, width: 0.4}", "path: {points: [[1, 2], [9, 2], [9, 5]], speed: 3}", true},
		{"wheel: {radius: 0.5, width: 0.4}", "path: {points: [[1, 2], [9, 2], [4, 2]], speed: 3}", true},
		{"wheel: {radius: 0.5, width: 0.4}", "path: {points: [[1, 2], [9, 2]], loop: true, speed: 3}", true},
		{"box: {size: [1, 1, 1]}", "path: {points: [[1, 2], [9, 2]], speed: 3}", true},
		{"sphere: {radius: 1}", "path: {points: [[1, 2], [9, 2]], speed: 3}", true},
	};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		char text[400];
		snprintf(text, sizeof text, "scene: 1\nend_time: 1\nsoil: {name: dry_sand}\nredistribute: {model: scm}\nobjects:\n  - {name: a, shape: {%s}, %s}\n",
			 cases[i].shape, cases[i].path);
		struct scene *scene;
		assert_int_equal(load_text(text, NULL, 0, &scene), STATUS_OK);
		assert_int_equal(scene_slips(scene), cases[i].slips);
		assert_int_equal(scene_effects(scene, 0) >> EFFECT_SLIP & 1, cases[i].slips);
		scene_destroy(scene);
	}
}

static void each_model_calls_for_its_own_effects(void **state)
{
	static const struct {
		const char *model;
		uint64_t effects;
	} models[] = {
		{"none", EFFECT_BIT(EFFECT_OF(DEFORM_NONE))},
		{"box", EFFECT_BIT(EFFECT_OF(DEFORM_NONE)) | EFFECT_BIT(EFFECT_OF(DEFORM_BOX_FILTER))},
		{"sumner", EFFECT_BIT(EFFECT_OF(DEFORM_SUMNER)) | EFFECT_BIT(EFFECT_SPREAD) | EFFECT_BIT(EFFECT_SHED)},
		{"slippage", EFFECT_BIT(EFFECT_OF(DEFORM_SLIPPAGE)) | EFFECT_BIT(EFFECT_SPREAD) | EFFECT_BIT(EFFECT_SLIDE)},
		{"sheet", EFFECT_BIT(EFFECT_OF(DEFORM_SHEET))},
		{"scm", EFFECT_BIT(EFFECT_OF(DEFORM_SCM)) | EFFECT_BIT(EFFECT_SPREAD) | EFFECT_BIT(EFFECT_SLIDE)},
	};
	for (size_t i = 0; i < sizeof models / sizeof models[0]; i++) {
		struct scene *scene = load_edited(base, "scm", models[i].model);
		assert_int_equal(scene_effects(scene, 0), models[i].effects | CACHE_EFFECTS);
		scene_destroy(scene);
	}
}

static void the_hash_is_of_all_that_decides_how_the_ground_gives_way(void **state)
{
	static const struct {
		const char *from, *to;
		bool same;
	} edits[] = {
		{"3}\n", "3}\noutput: {forces: 50, delay: 4}\n", true},
		{"dry_sand", "dry_sand, bekker_n: 1.1", true}, /* as the name says */
		{"model: scm", "model: scm, iterations: 1, interval: 0.05, depth: 0, bulldozing: 0.5, slip_sinkage: 1.35, loosening: 0, hardening: 0, tolerance: 0", true},
		{"0.4}", "0.4, grousers: 0}", true},
		{"dry_sand", "lunar", false},
		{"dry_sand", "dry_sand, bekker_kc: 1", false},
		{"dry_sand", "dry_sand, repose: 1", false},
		{"dry_sand", "dry_sand, compression: 1", false},
		{"model: scm", "model: slippage", false},
		{"model: scm", "model: sheet", false},
		{"model: scm", "model: sheet, tension: 2001", false},
		{"model: scm", "model: sheet, stiffness: 50001", false},
		{"model: scm", "model: sheet, yield: 0.1", false},
		{"model: scm", "model: sheet, rut: 0.9", false},
		{"model: scm", "model: scm, iterations: 3", false},
		{"model: scm", "model: scm, interval: 0.03", false},
		{"model: scm", "model: scm, depth: 1", false},
		{"model: scm", "model: scm, tolerance: 0.001", false},
		{"model: scm", "model: scm, tolerance: 0.002", false},
		{"model: scm", "model: scm, bulldozing: 0.6", false},
		{"model: scm", "model: scm, slip_sinkage: 0", false},
		{"model: scm", "model: scm, loosening: 0.67", false},
		{"model: scm", "model: scm, hardening: 0.1", false},
		{"model: scm", "model: scm, normals: body", true},
		{"model: scm", "model: scm, inertia: 1", true},
		{"model: scm", "model: scm, faces: on, inertia: 0.5", false},
		{"dry_sand}\nredistribute: {model: scm", "dry_sand, unit_weight: 15000, density: 1540}\nredistribute: {model: scm, faces: on", false},
		{"model: scm", "model: scm, normals: ground", false},
		{"3}\n", "3}\n    load: 5\n", false},
		{"3}\n", "3}\n    slip: 0.1\n", false},
		{"3}\n", "3}\n    interface: {}\n", true},
		{"3}\n", "3}\n    interface: {friction_angle: 1}\n", false},
		{"3}\n", "3}\n    interface: {adhesion: 0}\n", false},
		{"3}\n", "3}\n    interface: {friction_angle: 0}\n", false},
		{"3}\n", "3}\n    interface: {friction_angle: 0, adhesion: 0}\n", false},
		{"0.4}", "0.4, grousers: 3}", false},
		{"0.4}", "0.4, grousers: 3, grouser_height: 0.1}", false},
		{"0.4}", "0.4, grousers: 3, grouser_thickness: 0.1}", false},
		{"{name: dry_sand}", "{map: scene.yaml, classes: {1: dry_sand}, default: dry_sand}", false},
		{"{name: dry_sand}", "{map: m.png, classes: {1: dry_sand}, default: dry_sand}", false},
		{"{name: dry_sand}", "{map: m.png, classes: {2: dry_sand}, default: dry_sand}", false},
	};
	char hashes[sizeof edits / sizeof edits[0]][33];
	struct scene *first = load_edited(base, "scene: 1", "scene: 1");
	write_text("m.png", "m");
	for (size_t i = 0; i < sizeof edits / sizeof edits[0]; i++) {
		struct scene *scene = load_edited(base, edits[i].from, edits[i].to);
		if ((strcmp(scene->hash, first->hash) == 0) != edits[i].same)
			fail_msg("%s: the hash is wrong to %s", edits[i].to, edits[i].same ? "differ" : "be the same");
		strcpy(hashes[i], scene->hash);
		for (size_t k = 0; k < i && !edits[i].same; k++)
			assert_string_not_equal(hashes[i], hashes[k]);
		scene_destroy(scene);
	}
	scene_destroy(first);
	unlink(in_folder("m.png"));
}

TEST_PROGRAM(model)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_model_has_its_own_parameters_with_their_defaults),
		cmocka_unit_test(a_surface_has_friction_and_adhesion_each_alone),
		cmocka_unit_test(a_load_takes_the_place_of_a_sinkage),
		cmocka_unit_test(a_belt_slips),
		cmocka_unit_test(lugs_have_a_height_and_a_thickness),
		cmocka_unit_test(a_mesh_is_read_beside_the_scene_and_counts_by_its_triangles),
		cmocka_unit_test(forces_are_of_scm_and_their_delay_has_no_effect),
		cmocka_unit_test(slip_is_of_bodies_that_may_slip),
		cmocka_unit_test(each_model_calls_for_its_own_effects),
		cmocka_unit_test(the_hash_is_of_all_that_decides_how_the_ground_gives_way),
	};
	return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
