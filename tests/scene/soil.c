/* Soils and maps of soils in a scene: what they become, and what is refused. */
#include "soil.h"
#include "../support/program.h"

#define DEGREE (3.14159265358979323846 / 180)

#define EVERY \
	"bekker_kc: -100, bekker_kphi: 2000, bekker_n: 1.5, cohesion: 7, friction_angle: 30, janosi_shear: 0.03, " \
	"elastic_stiffness: 4e6, damping: 5, density: 1630, unit_weight: 16000, face_strength: 8e5, face_cohesion: 700, repose: 31, theta_in: 41, theta_out: 21, " \
	"theta_stop: 22, roughness: 0.1, compression: 0.25, compaction: 0.75"

static void a_soil_by_name_is_that_of_the_table(void **state)
{
	static const char *const names[] = {"dry_sand", "sandy_loam_15", "lete_sand", "snow_us", "lunar"};
	for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
		struct soil_numbers known;
		struct scene *scene = load_edited(base, "dry_sand", names[i]);
		assert_int_equal(soil_named(names[i], &known), STATUS_OK);
		assert_int_equal(scene->soil_count, 1);
		assert_memory_equal(&scene->soils[0], &known, sizeof known);
		assert_null(scene->soil_map);
		scene_destroy(scene);
	}
	refuse("dry_sand", "wet_sand", ":3: soil.name: \"wet_sand\" is unknown; allowed: dry_sand, sandy_loam_15, ");
	refuse("dry_sand", "wet_sand", ", lunar, rock, asphalt, concrete, ice, sand, mud, snow");
	refuse("soil: {name: dry_sand}", "soil: dry_sand", ":3: soil: is a single value; allowed: a mapping of name");
	refuse("soil: {name: dry_sand}\n", "", ":3: redistribute.model: scm needs a soil, and none is given; write "
					       "soil: {name: dry_sand}");
}

static void every_parameter_may_be_given_and_counts_over_the_names(void **state)
{
	const struct soil_numbers all = {
		.bekker_kc = -100, .bekker_kphi = 2000, .bekker_n = 1.5, .cohesion = 7, .friction_angle = 30 * DEGREE,
		.janosi_shear = 0.03, .elastic_stiffness = 4e6, .damping = 5, .density = 1630, .unit_weight = 16000, .face_strength = 8e5, .face_cohesion = 700, .repose = 31 * DEGREE,
		.theta_in = 41 * DEGREE, .theta_out = 21 * DEGREE, .theta_stop = 22 * DEGREE, .roughness = 0.1,
		.compression = 0.25, .thickness = (double)NAN, .compaction = 0.75};
	static const char *const soils[] = {EVERY, "name: lunar, " EVERY};
	for (size_t i = 0; i < 2; i++) {
		struct scene *scene = load_edited(base, "name: dry_sand", soils[i]);
		assert_memory_equal(&scene->soils[0], &all, sizeof all);
		scene_destroy(scene);
	}
	struct soil_numbers sand;
	assert_int_equal(soil_named("dry_sand", &sand), STATUS_OK);
	struct scene *scene = load_edited(base, "dry_sand", "dry_sand, friction_angle: 33, cohesion: 0");
	assert_true(scene->soils[0].friction_angle == 33 * DEGREE && scene->soils[0].cohesion == 0);
	assert_true(scene->soils[0].repose == sand.repose && scene->soils[0].bekker_n == sand.bekker_n);
	scene_destroy(scene);
	scene = load_edited(base, "{name: dry_sand}\nredistribute: {model: scm}",
			    "{bekker_kc: 0, bekker_kphi: 1, bekker_n: 1, cohesion: 0, friction_angle: 33, janosi_shear: 1, "
			    "elastic_stiffness: 1, damping: 0}\nredistribute: {model: scm}");
	assert_true(scene->soils[0].repose == 33 * DEGREE);
	scene_destroy(scene);
	/* Two more have the value of all named soils. */
	static const char *const both[] = {"", ", elastic_stiffness: 4e7, damping: 30000"};
	char hashes[2][33];
	for (int i = 0; i < 2; i++) {
		char soil[200];
		snprintf(soil, sizeof soil, "{bekker_kc: 0, bekker_kphi: 1e6, bekker_n: 1, cohesion: 0, friction_angle: 33, janosi_shear: 0.02%s}", both[i]);
		scene = load_edited(base, "{name: dry_sand}", soil);
		assert_true(scene->soils[0].elastic_stiffness == sand.elastic_stiffness && scene->soils[0].damping == sand.damping);
		strcpy(hashes[i], scene->hash);
		scene_destroy(scene);
	}
	assert_string_equal(hashes[0], hashes[1]);
}

static void without_a_name_all_that_the_model_needs_must_be_given(void **state)
{
	refuse("name: dry_sand", "cohesion: 3, bekker_n: 1", ":3: soil: model scm needs bekker_kc, bekker_kphi, friction_angle, "
							    "janosi_shear too; allowed: a name, or");
	refuse("{name: dry_sand}\nredistribute: {model: scm", "{cohesion: 3}\nredistribute: {model: slippage",
	       ":3: soil: model slippage needs friction_angle, unit_weight too");
	refuse("{name: dry_sand}\nredistribute: {model: scm", "{}\nredistribute: {model: sumner",
	       ":3: soil: model sumner needs theta_in, theta_out, theta_stop, roughness, compression too");
	refuse("name: dry_sand", "bekker_kc: 1, bekker_kphi: 1, bekker_n: 1, cohesion: 1, friction_angle: 0, janosi_shear: 1, "
				 "elastic_stiffness: 1, damping: 1", ":3: soil: without friction it needs repose too; allowed: above 0 to 89");
	struct scene *scene = load_edited(base, "{name: dry_sand}\nredistribute: {model: scm",
					  "{cohesion: 3, friction_angle: 0, unit_weight: 1}\nredistribute: {model: slippage");
	assert_true(scene->soils[0].cohesion == 3 && scene->soils[0].friction_angle == 0);
	scene_destroy(scene);
	scene = load_edited(base, "{name: dry_sand}\nredistribute: {model: scm",
			    "{theta_in: 90, theta_out: 20, theta_stop: 20, roughness: 0.2, compression: 1}\n"
			    "redistribute: {model: sumner");
	assert_true(fabs(scene->soils[0].theta_in - 90 * DEGREE) < 1e-15 && scene->soils[0].roughness == 0.2);
	scene_destroy(scene);
}

/* Each at its limits, which are taken, and beyond, which is told with them. */
static void limits_are_taken_and_what_is_beyond_is_not(void **state)
{
	static const struct {
		const char *from, *format; /* of the base; of the value */
		const char *good[3], *bad[3], *says;
	} limits[] = {
		{"dry_sand", "dry_sand, bekker_kc: %s", {"-1e5", "1e12"}, {"-1.1e12", "1.1e12", ".nan"}, "soil.bekker_kc: "},
		{"dry_sand", "dry_sand, bekker_kc: %s", {"0"}, {"-2e12", "2e12"}, "allowed: -1e+12 to 1e+12"},
		{"dry_sand", "dry_sand, bekker_kphi: %s", {"0", "1e12"}, {"-1", "1.1e12"}, "allowed: 0 to 1e+12"},
		{"dry_sand", "dry_sand, bekker_n: %s", {"1e-9", "3"}, {"0", "3.01", "-1"}, "allowed: above 0 to 3"},
		{"dry_sand", "dry_sand, cohesion: %s", {"0", "1e9"}, {"-1", "1.1e9"}, "allowed: 0 to 1000000000"},
		{"dry_sand", "dry_sand, friction_angle: %s", {"0", "89"}, {"-0.1", "89.1"}, "allowed: 0 to 89"},
		{"dry_sand", "dry_sand, repose: %s", {"0.001", "89"}, {"0", "-1", "89.1"}, "allowed: above 0 to 89"},
		{"dry_sand", "dry_sand, janosi_shear: %s", {"1e-6", "10"}, {"0", "10.1"}, "allowed: above 0 to 10"},
		{"dry_sand", "dry_sand, elastic_stiffness: %s", {"1", "1e12"}, {"0", "1.1e12"}, "allowed: above 0 to 1e+12"},
		{"dry_sand", "dry_sand, damping: %s", {"0", "1e12"}, {"-1", "1.1e12"}, "allowed: 0 to 1e+12"},
		{"dry_sand", "dry_sand, unit_weight: %s", {"1", "1e6"}, {"0", "1.1e6"}, "allowed: above 0 to 1000000"},
		{"dry_sand", "dry_sand, density: %s", {"0.1", "1e5"}, {"0", "1.1e5"}, "kg/m3; allowed: above 0 to 100000"},
		{"dry_sand", "dry_sand, face_strength: %s", {"1e-3", "1e12"}, {"0", "1.1e12"}, "allowed: above 0 to 1e+12"},
		{"dry_sand", "dry_sand, face_cohesion: %s", {"0", "1e9"}, {"-1", "1.1e9"}, "allowed: 0 to 1000000000"},
		{"dry_sand", "dry_sand, theta_in: %s", {"0.1", "90"}, {"0", "90.1"}, "allowed: above 0 to 90"},
		{"dry_sand", "dry_sand, theta_out: %s", {"0.1", "90"}, {"0", "90.1"}, "allowed: above 0 to 90"},
		{"dry_sand", "dry_sand, theta_stop: %s", {"0.1", "90"}, {"0", "90.1"}, "allowed: above 0 to 90"},
		{"dry_sand", "dry_sand, roughness: %s", {"1e-3", "0.2"}, {"0", "0.21"}, "come to rest; allowed: above 0 to 0.2"},
		{"dry_sand", "dry_sand, compression: %s", {"0", "1"}, {"-0.1", "1.1"}, "allowed: 0 to 1"},
		{"dry_sand", "dry_sand, cohesion: %s", {"5"}, {".inf", "nan", "1e999"}, "soil.cohesion: "},
		{"model: scm", "model: scm, iterations: %s", {"1", "8"}, {"0", "9"}, "allowed: 1 to 8"},
		{"model: scm", "model: scm, interval: %s", {"1e-6", "3600"}, {"0", "3601"}, "allowed: above 0 to 3600"},
		{"model: scm", "model: scm, depth: %s", {"0", "1024"}, {"-1", ".inf", "1025"}, "0 to 1024"},
		{"model: scm", "model: scm, tolerance: %s", {"0", "1"}, {"-0.1", "1.1", "nan"}, "0 to 1"},
		{"model: scm", "model: scm, bulldozing: %s", {"0", "1"}, {"-0.1", "1.1"}, "allowed: 0 to 1"},
		{"model: scm", "model: scm, loosening: %s", {"0", "0.99"}, {"-0.1", "1"}, "allowed: 0 to 0.99"},
		{"model: scm", "model: scm, hardening: %s", {"0", "10"}, {"-0.1", "10.1"}, "allowed: 0 to 10"},
		{"model: scm", "model: scm, inertia: %s", {"0", "10"}, {"-0.1", "10.1"}, "allowed: 0 to 10"},
		{"dry_sand", "dry_sand, compaction: %s", {"0", "1"}, {"-0.1", "1.1"}, "allowed: 0 to 1"},
		{"model: scm", "model: scm, slip_sinkage: %s", {"0", "10"}, {"-0.1", "10.1"}, "allowed: 0 to 10"},
		{"0.4}", "0.4, grousers: %s}", {"0", "128"}, {"-1", "129"}, "allowed: 0 to 128"},
		{"0.4}", "0.4, grousers: 4, grouser_height: %s}", {"1e-3", "0.5"}, {"0", "0.51"}, "allowed: above 0 to "},
		{"0.4}", "0.4, grousers: 4, grouser_thickness: %s}", {"1e-3", "1000"}, {"0", "1001"}, "allowed: above 0 to 1000"},
		{"3}\n", "3}\n    load: %s\n", {"1e-3", "1e9"}, {"0", "-1", "1.1e9"}, "allowed: above 0 to 1000000000"},
		{"3}\n", "3}\n    interface: {friction_angle: %s}\n", {"0", "89"}, {"-0.1", "89.1", "nan"}, "objects[0].interface.friction_angle: "},
		{"3}\n", "3}\n    interface: {adhesion: %s}\n", {"0", "1e9"}, {"-1", "1.1e9", ".inf"}, "objects[0].interface.adhesion: "},
		{"3}\n", "3}\n    slip: %s\n", {"-1000", "0.99"}, {"-1001", "1", "nan"}, "objects[0].slip: "},
		{"3}\n", "3}\noutput: {forces: %s}\n", {"0", "0.1", "1e6"}, {"-1", "1.1e6"}, "allowed: 0 to 1000000"},
		{"3}\n", "3}\noutput: {forces: 1, delay: %s}\n", {"0", "64"}, {"-1", "65"}, "allowed: 0 to 64"},
		{"wheel: {radius: 0.5, width: 0.4}", "mesh: {file: a.obj, scale: %s}", {NULL}, {"0", "1001"},
		 "allowed: above 0 to 1000"},
	};
	for (size_t i = 0; i < sizeof limits / sizeof limits[0]; i++) {
		char value[200];
		for (size_t k = 0; k < 3 && limits[i].good[k] != NULL; k++) {
			snprintf(value, sizeof value, limits[i].format, limits[i].good[k]);
			scene_destroy(load_edited(base, limits[i].from, value));
		}
		for (size_t k = 0; k < 3 && limits[i].bad[k] != NULL; k++) {
			snprintf(value, sizeof value, limits[i].format, limits[i].bad[k]);
			refuse(limits[i].from, value, limits[i].says);
		}
	}
}

static void what_no_soil_can_be_is_refused(void **state)
{
	/* b: 0.4 m, the wheel's width. */
	refuse("dry_sand", "dry_sand, bekker_kphi: 1000, bekker_kc: -400", ":3: soil.bekker_kc: bekker_kc / b + bekker_kphi is 0 "
									  "under a, whose b is 0.4 m; allowed: above 0");
	scene_destroy(load_edited(base, "dry_sand", "dry_sand, bekker_kphi: 1000, bekker_kc: -399"));
	refuse("dry_sand}\nredistribute: {model: scm}\nobjects:\n  - name: a\n    shape: {wheel: {radius: 0.5, width: 0.4}}",
	       "dry_sand, bekker_kphi: 1000, bekker_kc: -400}\nredistribute: {model: scm}\nobjects:\n  - name: a\n"
	       "    shape: {box: {size: [0.5, 0.3, 0.1]}}", "whose b is 0.3 m");
	refuse("dry_sand", "dry_sand, bekker_kphi: 0, bekker_kc: 0", ":3: soil.bekker_kc: bekker_kc and bekker_kphi bear nothing");
	refuse("{name: dry_sand}\nredistribute: {model: scm", "{name: dry_sand, theta_stop: 20}\nredistribute: {model: sumner",
	       ":3: soil.theta_stop: theta_stop is below theta_out; allowed: 24.98 to 90");
	refuse("{name: dry_sand}\nredistribute: {model: scm", "{name: dry_sand, theta_out: 80}\nredistribute: {model: sumner",
	       ":3: soil.theta_out: theta_stop is below theta_out; allowed: 80 to 90");
}

static const char mapped[] = "{map: soils.png, classes: {1: lunar, 7: {name: lete_sand, cohesion: 500}, 255: snow_us}, default: clayey_38}";

static void a_map_gives_each_value_its_soil(void **state)
{
	write_text("soils.png", "any bytes");
	struct scene *scene = load_edited(base, "{name: dry_sand}", mapped);
	struct soil_numbers known;
	assert_int_equal(scene->soil_count, 4);
	assert_string_equal(scene->soil_map, in_folder("soils.png"));
	for (int value = 0; value < 256; value++)
		assert_int_equal(scene->soil_class[value], value == 1 ? 1 : value == 7 ? 2 : value == 255 ? 3 : 0);
	assert_int_equal(soil_named("clayey_38", &known), STATUS_OK);
	assert_memory_equal(&scene->soils[0], &known, sizeof known);
	assert_int_equal(soil_named("lete_sand", &known), STATUS_OK);
	known.cohesion = 500;
	assert_memory_equal(&scene->soils[2], &known, sizeof known);
	assert_int_equal(scene_effects(scene, 0) & EFFECT_BIT(EFFECT_SOIL_MAP), EFFECT_BIT(EFFECT_SOIL_MAP));
	char hash[33];
	strcpy(hash, scene->hash);
	scene_destroy(scene);
	/* The same as a list, and with settings. */
	scene = load_edited(base, "{name: dry_sand}", "{map: soils.png, classes: [{value: 1, name: lunar}, {value: 7, name: lete_sand, "
			    "cohesion: 500}, {value: 255, name: snow_us}], default: {name: clayey_38}}");
	assert_string_equal(scene->hash, hash);
	scene_destroy(scene);
	const struct scene_setting settings[] = {{"soil.classes.1", "dry_sand"}, {"soil.classes.7.cohesion", "9"},
						 {"soil.classes.255", "null"}, {"soil.classes.2", "{name: dry_sand, roughness: 0.1}"},
						 {"soil.default", "lunar"}};
	char *text = edited(base, "{name: dry_sand}", mapped);
	assert_int_equal(load_text(text, settings, 5, &scene), STATUS_OK);
	free(text);
	assert_int_equal(scene->soil_count, 4);
	assert_int_equal(scene->soil_class[255], 0);
	assert_int_equal(scene->soil_class[2], 3);
	assert_true(scene->soils[2].cohesion == 9 && scene->soils[3].roughness == 0.1);
	assert_true(scene->soils[0].unit_weight == 2500);
	scene_destroy(scene);
	/* What the raster holds counts, not what it is called. */
	write_text("soils.png", "other bytes");
	scene = load_edited(base, "{name: dry_sand}", mapped);
	assert_string_not_equal(scene->hash, hash);
	scene_destroy(scene);
	unlink(in_folder("soils.png"));
	write_text("other.png", "any bytes");
	text = edited(mapped, "soils.png", "other.png");
	scene = load_edited(base, "{name: dry_sand}", text);
	assert_string_equal(scene->hash, hash);
	scene_destroy(scene);
	free(text);
	unlink(in_folder("other.png"));
}

static void what_is_wrong_with_a_map_is_told(void **state)
{
	static const struct {
		const char *soil, *says;
	} cases[] = {
		{"{map: m.png}", ":3: soil.map: has no classes; write {map: FILE"},
		{"{map: m.png, default: lunar}", ":3: soil.map: has no classes; write {map: FILE"},
		{"{name: lunar, classes: {1: lunar}}", ":3: soil.classes: is of a map, and there is none; allowed with: map"},
		{"{name: lunar, default: lunar}", ":3: soil.default: is of a map, and there is none"},
		{"{map: m.png, classes: {1: lunar}, default: lunar, name: lunar}", ":3: soil.map: does not go with a soil beside it"},
		{"{map: m.png, classes: {1: lunar}, default: lunar, cohesion: 1}", ":3: soil.map: does not go with a soil beside it"},
		{"{map: m.png, classes: {1: moon}, default: lunar}", ":3: soil.classes[0].name: \"moon\" is unknown; allowed: dry_sand"},
		{"{map: m.png, classes: {1: lunar}, default: moon}", ":3: soil.default.name: \"moon\" is unknown; allowed: dry_sand"},
		{"{map: m.png, classes: {256: lunar}, default: lunar}", ":3: soil.classes[0].value: 256 is out of range; allowed: 0 to 255"},
		{"{map: m.png, classes: {-1: lunar}, default: lunar}", "soil.classes[0].value: -1 is out of range; allowed: 0 to 255"},
		{"{map: m.png, classes: {one: lunar}, default: lunar}", "soil.classes[0].value: \"one\" is not a whole number"},
		{"{map: m.png, classes: {1: lunar, 1: mud}, default: lunar}", "soil.classes.1: is written twice"},
		{"{map: m.png, classes: {1: lunar, +1: mud}, default: lunar}", "soil.classes[1].value: 1 is another class; allowed: each value once"},
		{"{map: m.png, classes: {1: {value: 2, name: mud}}, default: lunar}", "value: is said by the key"},
		{"{map: m.png, classes: {1: {colour: red}}, default: lunar}", "soil.classes[0].colour: unknown key; allowed: value, name"},
		{"{map: m.png, classes: {1: {cohesion: -1}}, default: lunar}", "soil.classes[0].cohesion: -1 is out of range; allowed: 0 to"},
		{"{map: m.png, classes: {1: lunar}, default: {roughness: 0.3}}", "soil.default.roughness: 0.3 is out of the range in which "
										 "slides come to rest; allowed: above 0 to 0.2"},
		{"{map: m.png, classes: {1: {cohesion: 1}}, default: lunar}", ":3: soil.classes[0]: model scm needs bekker_kc, "},
		{"{map: m.png, classes: {1: [lunar]}, default: lunar}", "is a list; allowed: a mapping of value, name"},
		{"{map: m.png, classes: {}, default: lunar}", ":3: soil.classes: holds 0; allowed: a list of 1 to 15"},
		{"{map: m.png, classes: lunar, default: lunar}", ":3: soil.classes: is a single value; allowed: a list of 1 to 15"},
		{"{map: m.png, classes: {1: lunar}, default: [lunar]}", ":3: soil.default: is a list; allowed: a mapping of name"},
		{"{map: m.png, classes: {1: lunar, 2: {name: lunar, bekker_kc: -4e5}}, default: lunar}",
		 ":3: soil.classes[1].bekker_kc: bekker_kc / b + bekker_kphi is -1.8e+05 under a"},
		{"{map: absent.png, classes: {1: lunar}, default: lunar}", ":3: soil.map: \"absent.png\": No such file"},
		{"{map: /dev/zero, classes: {1: lunar}, default: lunar}", ":3: soil.map: \"/dev/zero\": not a file; "},
		{"{map: \"\", classes: {1: lunar}, default: lunar}", ":3: soil.map: is empty; allowed: text"},
	};
	write_text("m.png", "m");
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
		refuse("{name: dry_sand}", cases[i].soil, cases[i].says);
	char classes[400] = "{map: m.png, default: lunar, classes: {";
	for (int i = 0; i < 15; i++)
		snprintf(classes + strlen(classes), sizeof classes - strlen(classes), "%d: clayey_38%s", i * 17, i < 14 ? ", " : "}}");
	struct scene *scene = load_edited(base, "{name: dry_sand}", classes);
	assert_int_equal(scene->soil_count, SOIL_CLASSES);
	assert_int_equal(scene->soil_class[14 * 17], 15);
	scene_destroy(scene);
	strcpy(classes + strlen(classes) - 2, ", 3: clayey_38}}");
	refuse("{name: dry_sand}", classes, ":3: soil.classes: holds 16; allowed: a list of 1 to 15");
	assert_int_equal(mkfifo(in_folder("pipe"), 0600), 0);
	refuse("{name: dry_sand}", "{map: pipe, classes: {1: lunar}, default: lunar}", "\"pipe\": not a file; ");
	unlink(in_folder("pipe"));
	unlink(in_folder("m.png"));
}

static const char rasters[] = "{name: dry_sand, rasters: {friction_angle: phi.png, cohesion: c.png}}";

static void rasters_are_in_the_order_of_their_numbers_and_their_bytes_count(void **state)
{
	struct scene *plain = load_edited(base, "{name: dry_sand}", "{name: dry_sand}");
	char hash[33];
	write_text("c.png", "any bytes");
	write_text("phi.png", "some bytes");
	struct scene *scene = load_edited(base, "{name: dry_sand}", rasters);
	assert_int_equal(plain->raster_count, 0);
	assert_int_equal(scene->raster_count, 2);
	assert_true(scene->rasters[0].number == SOIL_COHESION && scene->rasters[1].number == SOIL_FRICTION_ANGLE);
	assert_string_equal(scene->rasters[0].path, in_folder("c.png"));
	assert_string_equal(scene->rasters[1].path, in_folder("phi.png"));
	assert_memory_equal(&scene->soils[0], &plain->soils[0], sizeof scene->soils[0]);
	assert_int_equal(scene_effects(scene, 0) ^ scene_effects(plain, 0), EFFECT_BIT(EFFECT_SOIL_RASTERS));
	assert_string_not_equal(scene->hash, plain->hash);
	strcpy(hash, scene->hash);
	scene_destroy(scene);
	/* In any order, by any name; but each for its own number, and with its own bytes. */
	write_text("a.png", "any bytes");
	write_text("b.png", "some bytes");
	static const struct {
		const char *soil;
		bool same;
	} others[] = {
		{"{name: dry_sand, rasters: {cohesion: c.png, friction_angle: phi.png}}", true},
		{"{name: dry_sand, rasters: {cohesion: a.png, friction_angle: b.png}}", true},
		{"{name: dry_sand, rasters: {cohesion: b.png, friction_angle: a.png}}", false},
		{"{name: dry_sand, rasters: {cohesion: a.png, janosi_shear: b.png}}", false},
		{"{name: dry_sand, rasters: {cohesion: a.png}}", false},
		{"{map: a.png, classes: {1: lunar}, default: dry_sand, rasters: {cohesion: a.png, friction_angle: b.png}}", false},
	};
	for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
		scene = load_edited(base, "{name: dry_sand}", others[i].soil);
		assert_int_equal(strcmp(scene->hash, hash) == 0, others[i].same);
		scene_destroy(scene);
	}
	write_text("c.png", "other bytes");
	scene = load_edited(base, "{name: dry_sand}", rasters);
	assert_string_not_equal(scene->hash, hash);
	scene_destroy(scene);
	/* None of them are given: the hash is that of ever. */
	scene = load_edited(base, "{name: dry_sand}", "{name: dry_sand, rasters: {}}");
	assert_string_equal(scene->hash, plain->hash);
	scene_destroy(scene);
	scene_destroy(plain);
	static const char *const files[] = {"a.png", "b.png", "c.png", "phi.png"};
	for (size_t i = 0; i < 4; i++)
		unlink(in_folder(files[i]));
}

static void what_is_wrong_with_rasters_is_told(void **state)
{
	static const struct {
		const char *soil, *says;
	} cases[] = {
		{"{name: dry_sand, rasters: c.png}", ":3: soil.rasters: is a single value; allowed: a mapping of bekker_kc, bekker_kphi, "},
		{"{name: dry_sand, rasters: {repose: c.png}}", ":3: soil.rasters.repose: unknown key; allowed: bekker_kc, bekker_kphi, bekker_n, "
							       "cohesion, friction_angle, janosi_shear, elastic_stiffness"},
		{"{name: dry_sand, rasters: {cohesion: [1]}}", ":3: soil.rasters.cohesion: is a list; allowed: text"},
		{"{name: dry_sand, rasters: {cohesion: absent.png}}", ":3: soil.rasters.cohesion: \"absent.png\": No such file"},
		{"{name: dry_sand, rasters: {cohesion: /dev/zero}}", ":3: soil.rasters.cohesion: \"/dev/zero\": not a file; "},
		{"{name: dry_sand, rasters: {bekker_kc: c.png, bekker_kphi: c.png, bekker_n: c.png, cohesion: c.png, friction_angle: c.png}}",
		 ":3: soil.rasters.friction_angle: is one raster too many; allowed: at most 4"},
		{"{rasters: {cohesion: c.png}}", ":3: soil: model scm needs bekker_kc, "},
		{"{name: mud, rasters: {cohesion: c.png}}", ":3: soil.name: mud has no "},
		{"{name: lunar, map: c.png, classes: {1: lunar}, default: lunar, rasters: {cohesion: c.png}}",
		 ":3: soil.map: does not go with a soil beside it; allowed: map, classes, default, rasters"},
	};
	write_text("c.png", "c");
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
		refuse("{name: dry_sand}", cases[i].soil, cases[i].says);
	refuse("{name: dry_sand}\nredistribute: {model: scm", "{name: dry_sand, rasters: {cohesion: c.png}}\nredistribute: {model: slippage",
	       ":3: soil.rasters: model slippage reads a soil's numbers by class alone; allowed with: scm; or give soil.map");
	refuse("{name: dry_sand}\nredistribute: {model: scm", "{name: dry_sand, rasters: {cohesion: c.png}}\nredistribute: {model: sumner",
	       ":3: soil.rasters: model sumner reads ");
	/* What reads no soil does not look for its rasters. */
	struct scene *scene = load_edited(base, "{name: dry_sand}\nredistribute: {model: scm",
					  "{name: dry_sand, rasters: {cohesion: absent.png}}\nredistribute: {model: box");
	assert_int_equal(scene->raster_count, 0);
	assert_int_equal(scene->unused_count, 1);
	scene_destroy(scene);
	unlink(in_folder("c.png"));
}

static void a_soil_that_no_model_reads_is_checked_and_costs_nothing(void **state)
{
	static const char *const models[] = {"none", "box"};
	for (size_t i = 0; i < 2; i++) {
		struct scene *with = load_edited(base, "scm", models[i]);
		char *text = edited(base, "soil: {name: dry_sand}\n", "");
		struct scene *without = load_edited(text, "scm", models[i]);
		assert_int_equal(with->soil_count, 0);
		assert_string_equal(with->hash, without->hash);
		scene_destroy(with);
		scene_destroy(without);
		free(text);
		/* And its map is not even looked for. */
		text = edited(base, "{name: dry_sand}", mapped);
		with = load_edited(text, "scm", models[i]);
		assert_null(with->soil_map);
		for (int value = 0; value < 256; value++)
			assert_int_equal(with->soil_class[value], 0);
		scene_destroy(with);
		free(text);
	}
	refuse("{name: dry_sand}\nredistribute: {model: scm}", "{name: wet_sand}\nredistribute: {model: box}", "\"wet_sand\" is unknown");
}

static void memory_that_runs_out_is_told_at_every_allocation(void **state)
{
	const struct scene_setting settings[] = {{"soil.classes.3", "clayey_38"}, {"objects.a.load", "40"}};
	char *text = edited(base, "{name: dry_sand}", mapped);
	write_text("scene.yaml", text);
	write_text("soils.png", "any bytes");
	assert_memory_is_told(settings, 2, false);
	unlink(in_folder("soils.png"));
	free(text);
	text = edited(base, "{name: dry_sand}", rasters);
	write_text("scene.yaml", text);
	write_text("c.png", "any bytes");
	write_text("phi.png", "some bytes");
	assert_memory_is_told(settings + 1, 1, false);
	unlink(in_folder("c.png"));
	unlink(in_folder("phi.png"));
	unlink(in_folder("scene.yaml"));
	free(text);
}

TEST_PROGRAM(soil)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_soil_by_name_is_that_of_the_table),
		cmocka_unit_test(every_parameter_may_be_given_and_counts_over_the_names),
		cmocka_unit_test(without_a_name_all_that_the_model_needs_must_be_given),
		cmocka_unit_test(limits_are_taken_and_what_is_beyond_is_not),
		cmocka_unit_test(what_no_soil_can_be_is_refused),
		cmocka_unit_test(a_map_gives_each_value_its_soil),
		cmocka_unit_test(what_is_wrong_with_a_map_is_told),
		cmocka_unit_test(rasters_are_in_the_order_of_their_numbers_and_their_bytes_count),
		cmocka_unit_test(what_is_wrong_with_rasters_is_told),
		cmocka_unit_test(a_soil_that_no_model_reads_is_checked_and_costs_nothing),
		cmocka_unit_test(memory_that_runs_out_is_told_at_every_allocation),
	};
	return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
