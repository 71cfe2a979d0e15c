/* Each thing that is wrong with a scene is told with its line, its key and what is allowed. */
#include "fixture.h"
#include "../support/program.h"

/* `from` of the manual's scene becomes `to`; the message must hold `says`. */
static const struct {
	const char *from, *to, *says;
} cases[] = {
	/* unknown keys, missing keys, keys written twice */
	{"spacing: 0.125", "spaceing: 0.125", ":6: spaceing: unknown key; allowed: scene, store, "},
	{"slots: 256", "slot: 256", ":23: cache.slot: unknown key; allowed: slots, memory, loaders, prefetch"},
	{"name: dry_sand", "nam: dry_sand", ":8: soil.nam: unknown key; allowed: name, bekker_kc"},
	{"radius: 0.5", "diameter: 0.5", ":14: objects[0].shape.wheel.diameter: unknown key; allowed: "
					 "radius, width, grousers"},
	{"loop: false", "lop: false", ":15: objects[0].path.lop: unknown key; allowed: points, speed"},
	{"sink: 0.1", "sinks: 0.1", ":16: objects[0].sinks: unknown key; allowed: name, shape, path, sink"},
	{"images: 100", "image: 100", ":22: view.image: unknown key; allowed: size, camera"},
	{"back: 12", "behind: 12", ":20: view.camera.behind: unknown key; allowed: chase"},
	{"model: box", "model: box, compression: 1", ":9: redistribute.compression: unknown key"},
	{"scene: 1 ", "", "scene: is missing"},
	{"end_time: 30", "", "end_time: is missing"},
	{"name: front_left\n    shape", "shape", ":13: objects[0].name: is missing"},
	{", width: 0.4", "", ":14: objects[0].shape.wheel.width: is missing"},
	{"{model: box}", "{}", ":9: redistribute.model: is missing"},
	{"time_step: 0.02", "store: b", ":3: store: is written twice"},
	{"slots: 256", "loaders: 3", ":23: cache.loaders: is written twice"},
	{"{model: box}", "{model: scm}\ncompute: gpu", ":10: compute: model scm is computed by the CPU alone; allowed with it: cpu"},
	{"{model: box}", "{model: box, regions: fixed}\ncompute: cpu", ":9: redistribute.regions: fixed regions are of the GPU, and compute: cpu asks for the CPU; take one of them away"},
	{"{model: box}", "{model: box, regions: dynamic}", ":9: redistribute.regions: \"dynamic\" is unknown; allowed: window, fixed"},
	{"{model: box}", "{model: box}\ncompute: both", ":10: compute: \"both\" is unknown; allowed: gpu, cpu"},
	/* wrong types */
	{"scene: 1", "scene: one", ":1: scene: \"one\" is not a whole number; allowed: a whole number, 1"},
	{"scene: 1", "scene: \"1\"", ":1: scene: \"1\" is not a whole number"},
	{"scene: 1", "scene: 1.0", ":1: scene: \"1.0\" is not a whole number"},
	{"end_time: 30", "end_time: [30]", ":4: end_time: is a list; allowed: a number, above 0 to"},
	{"end_time: 30", "end_time: 30 s", ":4: end_time: \"30 s\" is not a number"},
	{"end_time: 30", "end_time: .inf", ":4: end_time: \".inf\" is not a number"},
	{"end_time: 30", "end_time: nan", ":4: end_time: \"nan\" is not a number"},
	{"end_time: 30", "end_time: 0x10", ":4: end_time: \"0x10\" is not a number"},
	{"end_time: 30", "end_time: 1e", ":4: end_time: \"1e\" is not a number"},
	{"end_time: 30", "end_time:", ":4: end_time: \"\" is not a number"},
	{"gravity: 9.81", "gravity: {earth: 1}", ":5: gravity: is a mapping; allowed: a number"},
	{"store: world.furrow", "store: [a]", ":2: store: is a list; allowed: text"},
	{"store: world.furrow", "store:", ":2: store: is empty; allowed: text"},
	{"{name: dry_sand}", "dry_sand", ":8: soil: is a single value; allowed: a mapping of name"},
	{"{model: box}", "box", ":9: redistribute: is a single value; allowed: a mapping of model"},
	{"[disturbance]", "disturbance", ":10: attributes: is a single value; allowed: a list or a mapping"},
	{"[[10, 10], [90, 40]]", "[10, 10]", ":15: objects[0].path.points[0]: is a single value; "
					     "allowed: a list of 2"},
	{"[90, 40]", "[90, 40, 1]", ":15: objects[0].path.points[1]: holds 3; allowed: a list of 2"},
	{"[90, 40]", "[90, up]", ":15: objects[0].path.points[1][1]: \"up\" is not a number"},
	{"[[10, 10], [90, 40]]", "[]", ":15: objects[0].path.points: holds 0; allowed: a list of at "
				       "least 1"},
	{"loop: false", "loop: maybe", ":15: objects[0].path.loop: \"maybe\" is unknown; allowed: true, "
				       "false"},
	{"[1280, 720]", "[1280]", ":19: view.size: holds 1; allowed: a list of 2"},
	{"[1280, 720]", "[1280, 7.5]", ":19: view.size[1]: \"7.5\" is not a whole number"},
	{"images: 100", "images: 010", ":22: view.images: \"010\" is not a whole number"},
	{"- name: front_left\n    shape", "- [1]\n  - shape", ":13: objects[0]: is a list; allowed: a mapping"},
	/* out of range */
	{"scene: 1", "scene: 2", ":1: scene: 2 is no version of the format that is known; allowed: 1"},
	{"time_step: 0.02", "time_step: 0", ":3: time_step: 0 is out of range; allowed: 1e-06 to 3600"},
	{"time_step: 0.02", "time_step: -0.02", ":3: time_step: -0.02 is out of range"},
	{"end_time: 30", "end_time: -1", ":4: end_time: -1 is out of range; allowed: above 0"},
	{"end_time: 30", "end_time: 1e999", ":4: end_time: 1e999 is out of range"},
	{"gravity: 9.81", "gravity: 1e-400", ":5: gravity: 1e-400 is out of range"},
	{"gravity: 9.81", "gravity: -9.81", ":5: gravity: -9.81 is out of range"},
	{"spacing: 0.125", "spacing: 0", ":6: spacing: 0 is out of range"},
	{"{name: dry_sand}", "{friction_angle: 90}", ":8: soil.friction_angle: 90 is out of range; "
						     "allowed: 0 to 89"},
	{"model: box", "model: box, radius: 5", ":9: redistribute.radius: 5 is out of range; allowed: 1 to 4"},
	{"model: box", "model: box, radius: 0", ":9: redistribute.radius: 0 is out of range"},
	{"model: box", "model: box, repetitions: 9", ":9: redistribute.repetitions: 9 is out of range; "
						     "allowed: 1 to 8"},
	{"radius: 0.5", "radius: 0", ":14: objects[0].shape.wheel.radius: 0 is out of range"},
	{"radius: 0.5", "radius: 1500", ":14: objects[0].shape.wheel.radius: 1500 is out of range, and the unit is m, not mm; allowed: 0.001 to 1000"},
	{"{name: dry_sand}", "{janosi_shear: 25}", ":8: soil.janosi_shear: 25 is out of range, and the unit is m, not cm or mm; allowed: above 0 to 10"},
	{"width: 0.4", "width: -0.4", ":14: objects[0].shape.wheel.width: -0.4 is out of range"},
	{"speed: 5", "speed: 0", ":15: objects[0].path.speed: 0 is out of range; allowed: above 0"},
	{"[90, 40]", "[90, 4e10]", ":15: objects[0].path.points[1][1]: 4e10 is out of range"},
	{"sink: 0.1", "sink: -0.1", ":16: objects[0].sink: -0.1 is out of range; allowed: 0 to 1000"},
	{"[1280, 720]", "[1280, 9000]", ":19: view.size[1]: 9000 is out of range; allowed: 1 to 8192"},
	{"[1280, 720]", "[0, 720]", ":19: view.size[0]: 0 is out of range"},
	{"images: 100", "pixel_error: 0", ":22: view.pixel_error: 0 is out of range; allowed: above 0 to 64"},
	{"images: 100", "pixel_error: 64.5", ":22: view.pixel_error: 64.5 is out of range"},
	{"images: 100", "pixel_error: -1", ":22: view.pixel_error: -1 is out of range"},
	{"images: 100", "pixel_error: fine", ":22: view.pixel_error: \"fine\" is not a number"},
	{"images: 100", "samples: 0", ":22: view.samples: 0 is out of range; allowed: 1 to 8"},
	{"images: 100", "samples: 16", ":22: view.samples: 16 is out of range"},
	{"images: 100", "samples: 3", ":22: view.samples: 3 is no number of samples; allowed: 1, 2, 4, 8"},
	{"images: 100", "samples: 2.5", ":22: view.samples: "},
	{"images: 100", "body: venus", ":22: view.body: \"venus\" is unknown; allowed: earth, mars, moon"},
	{"images: 100", "body: 3", ":22: view.body: \"3\" is unknown; allowed: earth, mars, moon"},
	{"images: 100", "sun: 35", ":22: view.sun: is a single value; allowed: a mapping of azimuth"},
	{"images: 100", "sun: {hight: 35}", ":22: view.sun.hight: unknown key; allowed: azimuth, height, time, at, colour"},
	{"images: 100", "sun: {height: 91}", ":22: view.sun.height: 91 is out of range; allowed: 0 to 90"},
	{"images: 100", "sun: {height: -1}", ":22: view.sun.height: -1 is out of range"},
	{"images: 100", "sun: {azimuth: 361}", ":22: view.sun.azimuth: 361 is out of range; allowed: 0 to 360"},
	{"images: 100", "sun: {time: noon}", ":22: view.sun.time: \"noon\" is no time; allowed: UTC from 1900 to 2100, as 2026-11-27T16:00:00Z"},
	{"images: 100", "sun: {time: 2026-02-28T12:00:00}", ":22: view.sun.time: \"2026-02-28T12:00:00\" has no Z at its end; end it with Z: UTC"},
	{"images: 100", "sun: {time: 2026-02-29T12:00:00Z}", ":22: view.sun.time: \"2026-02-29T12:00:00Z\" is no time: its month has no day 29; "},
	{"images: 100", "sun: {time: 2026-13-01T12:00:00Z}", ":22: view.sun.time: \"2026-13-01T12:00:00Z\" is no time; allowed: UTC from"},
	{"images: 100", "sun: {colour: [1, 1]}", ":22: view.sun.colour: holds 2; allowed: a list of 3"},
	{"images: 100", "sun: {colour: [1, 1, -0.5]}", ":22: view.sun.colour[2]: -0.5 is out of range; allowed: 0 to 10"},
	{"images: 100", "sun: {colour: red}", ":22: view.sun.colour: is a single value; allowed: a list of 3"},
	{"images: 100", "images: -1", ":22: view.images: -1 is out of range; allowed: 0 to"},
	{"slots: 256", "memory: 512", ":23: cache.memory: \"512\" is no number of bytes; give a number and one of MB, GB, MiB, GiB, as in 512 MB"},
	{"slots: 256", "memory: 512 kB", ":23: cache.memory: \"512 kB\" is no number of bytes"},
	{"slots: 256", "memory: 1.5.2 GB", ":23: cache.memory: \"1.5.2 GB\" is no number of bytes"},
	{"slots: 256", "memory: -512 MB", ":23: cache.memory: \"-512 MB\" is no number of bytes"},
	{"slots: 256", "memory: 0 MB", ":23: cache.memory: \"0 MB\" is out of range; allowed: above 0 to 1e6 GB"},
	{"slots: 256", "memory: 99999999999 GB", ":23: cache.memory: \"99999999999 GB\" is out of range"},
	{"slots: 256", "slots: 256, memory: 512 MB", ":23: cache.memory: it cannot be given beside cache.slots, which it decides; remove one of the two"},
	{"slots: 256", "slots: 3", ":23: cache.slots: 3 is out of range; allowed: 4 to 65536"},
	{"slots: 256", "slots: 99999999999999999999", ":23: cache.slots: 99999999999999999999 is out of"},
	{"loaders: 2", "loaders: 17", ":23: cache.loaders: 17 is out of range; allowed: 0 to 16"},
	{"prefetch: 1.5", "prefetch: -1", ":23: cache.prefetch: -1 is out of range; allowed: 0 to"},
	/* unknown words */
	{"model: box", "model: bxo", ":9: redistribute.model: \"bxo\" is unknown; allowed: none, box"},
	{"outside: stop", "outside: ignore", ":11: outside: \"ignore\" is unknown; allowed: stop, skip"},
	{"[disturbance]", "[dust]", ":10: attributes[0]: \"dust\" is unknown; allowed: disturbance, vegetation"},
	{"fog, sky", "fogg, sky", ":21: view.effects[2]: \"fogg\" is unknown; allowed: texture, detail, "
				  "fog, sky, geomorph, skirts"},
	{"fog, sky", "dirt, sky", ":21: view.effects[2]: \"dirt\" is unknown"},
	{"dry_sand", "wet_sand", ":8: soil.name: \"wet_sand\" is unknown; allowed: dry_sand, sandy_loam_15"},
	/* what does not go together */
	{"[disturbance]", "[disturbance, disturbance]", ":10: attributes[1]: disturbance is named twice"},
	{"fog, sky", "texture, sky", ":21: view.effects[2]: \"texture\" is named twice"},
	{"model: box", "model: none, radius: 2", ":9: redistribute.radius: is no parameter of model none"},
	{"{wheel: {radius: 0.5, width: 0.4, grousers: 0}}", "{}", ":14: objects[0].shape: names 0 shapes; "
							      "allowed: exactly one of wheel, sphere, box, mesh, cylinder, capsule, ellipsoid"},
	{"{wheel: {radius: 0.5, width: 0.4, grousers: 0}}", "{mesh: {}}", ":14: objects[0].shape.mesh.file: is missing"},
	{"grousers: 0}", "grousers: 0}, sphere: {radius: 1}", ":14: objects[0].shape: names 2 shapes"},
	{"points: [[10, 10], [90, 40]], ", "", ":15: objects[0].path: names neither points nor file"},
	{"speed: 5", "file: a.csv", ":15: objects[0].path: names both points and file"},
	{"speed: 5, ", "", ":15: objects[0].path: has no speed"},
	{"points: [[10, 10], [90, 40]]", "file: a.csv", ":15: objects[0].path.speed: does not go with a file"},
	{"points: [[10, 10], [90, 40]], speed: 5, loop: false", "file: absent.csv",
	 ":15: objects[0].path.file: \"absent.csv\": No such file"},
	{"name: front_left", "name: front left", ":13: objects[0].name: \"front left\" is not a name; "
						 "allowed: A-Z"},
	{"view:", "  - name: front_left\n    shape: {sphere: {radius: 1}}\n"
		  "    path: {points: [[1, 1]], speed: 1}\nview:",
	 ":18: objects[1].name: \"front_left\" is the name of another object"},
	{"chase: front_left, ", "", ":20: view.camera: names 0 cameras; allowed: exactly one of chase"},
	{"back: 12, up: 5", "over: front_left, height: 4", ":20: view.camera: names 2 cameras"},
	{"chase: front_left", "chase: rear", ":20: view.camera.chase: \"rear\" is no object; allowed: "
					     "front_left"},
	{"chase: front_left", "over: front_left, height: 3", ":20: view.camera.back: is not of this camera"},
	{"{chase: front_left, back: 12, up: 5}", "{over: front_left}", ":20: view.camera.overhead.height: "
								       "is missing"},
	{"{chase: front_left, back: 12, up: 5}", "{fixed: {eye: [1, 2, 3], target: [1, 2, 3]}}",
	 ":20: view.camera.fixed.target: is the eye"},
	{"back: 12, up: 5", "back: 0, up: 0", ":20: view.camera: stands in its object"},
	/* what is not a scene, or not YAML */
	{"{name: dry_sand}", "{name: dry_sand", "not YAML: "},
	{"time_step", "\ttime_step", "not YAML: "},
	{"{name: dry_sand}", "&a {name: dry_sand}", ":8: an anchor or a tag"},
	{"{name: dry_sand}", "*a", ":8: an alias"},
	{"end_time: 30", "end_time: !!int 30", ":4: an anchor or a tag"},
	{"store: world.furrow", "store: \"a\\0b\"", ":2: a control character"},
	{"store: world.furrow", "store: \"\\x93\"", ":2: a control character"},
	{"store: world.furrow", "store: \"\\x85\"", ":2: a control character"},
	{"store: world.furrow", "store: \"\\u2028\"", ":2: a control character"},
	{"store: world.furrow", "store: \"\\ufeff\"", ":2: a control character"},
	{"store: world.furrow", "store: \"\\uffff\"", ":2: a control character"},
	{"store: world.furrow", "? [a]\n: b", ":2: a key that is no text"},
	{"store: world.furrow", "--- a", ":2: a second document begins"},
};

/* The column of the key, or of an entry of a list; of text that is no YAML, where that begins. Both count from 1, and columns count characters. */
static void each_mistake_is_told_with_its_column(void **state)
{
	static const struct {
		const char *from, *to, *says;
	} columns[] = {
		{"spacing: 0.125", "spaceing: 0.125", "scene.yaml:6:1: spaceing: unknown key"},
		{"radius: 0.5", "diameter: 0.5", "scene.yaml:14:21: objects[0].shape.wheel.diameter: unknown key"},
		{"[90, 40]", "[90, 4e10]", "scene.yaml:15:36: objects[0].path.points[1][1]: 4e10 is out of range"},
		{"sink: 0.1", "sink: 0.1\n    sink: 0.2", "scene.yaml:17:5: objects[0].sink: is written twice"},
		{"front_left\n", "\"a\xc3\xa4\xf0\x9f\x9a\x9c\", sunk: 1\n", "scene.yaml:13:16: not YAML"},
		{"{name: dry_sand}", "{name: *a}", "scene.yaml:8:14: an alias"},
		{"model: box", "model: bocks", "scene.yaml:9:16: redistribute.model: \"bocks\" is unknown"},
	};
	for (size_t i = 0; i < sizeof columns / sizeof columns[0]; i++) {
		char *text = edited(example, columns[i].from, columns[i].to);
		struct scene *scene;
		assert_int_equal(load_text(text, NULL, 0, &scene), STATUS_INPUT);
		if (strstr(failure_message(), columns[i].says) == NULL)
			fail_msg("\"%s\" does not say \"%s\"", failure_message(), columns[i].says);
		free(text);
	}
}

static void each_mistake_is_told_with_line_key_and_what_is_allowed(void **state)
{
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		char *text = edited(example, cases[i].from, cases[i].to);
		struct scene *scene;
		enum status status = load_text(text, NULL, 0, &scene);
		free(text);
		if (status != STATUS_INPUT)
			fail_msg("\"%s\" gives %d: %s", cases[i].to, status, failure_message());
		assert_null(scene);
		assert_int_equal(strncmp(failure_message(), in_folder("scene.yaml"), strlen(folder) + 11), 0);
		assert_says(cases[i].says);
		assert_says("; ");
	}
}

static void what_is_no_scene_at_all_is_refused(void **state)
{
	static const struct {
		const char *text, *says;
	} whole[] = {
		{"", ":1: nothing is written here"},
		{"# only a comment\n", "nothing is written here"},
		{"- a\n- b\n", ":1: not a scene; allowed: a mapping"},
		{"scene\n", ":1: not a scene"},
		{"scene: 1\nend_time: 1\n", ":1: no object and no view"},
		{"scene: 1\nend_time: 1\nobjects: []\n", ":3: objects: no object and no view"},
		{"scene: 1\nend_time: 1\nview: {camera: {chase: a}}\n", "an object, of which there is none"},
		{"scene: 1\nend_time: 1\nview: {}\n", ":3: view.camera: is missing"},
	};
	struct scene *scene;
	for (size_t i = 0; i < sizeof whole / sizeof whole[0]; i++) {
		assert_int_equal(load_text(whole[i].text, NULL, 0, &scene), STATUS_INPUT);
		assert_null(scene);
		assert_says(whole[i].says);
	}
	assert_int_equal(scene_load(in_folder("absent.yaml"), NULL, 0, &scene), STATUS_INPUT);
	assert_says("absent.yaml: No such file");
	assert_int_equal(scene_load(folder, NULL, 0, &scene), STATUS_INPUT);
	assert_says("name a file that can be read");
}

static void the_first_mistake_of_the_file_is_the_one_told(void **state)
{
	char *late = edited(example, "slots: 256", "slots: 1");
	char *both = edited(late, "gravity: 9.81", "gravity: up");
	struct scene *scene;
	assert_int_equal(load_text(both, NULL, 0, &scene), STATUS_INPUT);
	assert_says(":5: gravity: ");
	free(late);
	free(both);
}

TEST_PROGRAM(refuse)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(each_mistake_is_told_with_its_column),
		cmocka_unit_test(each_mistake_is_told_with_line_key_and_what_is_allowed),
		cmocka_unit_test(what_is_no_scene_at_all_is_refused),
		cmocka_unit_test(the_first_mistake_of_the_file_is_the_one_told),
	};
	return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
