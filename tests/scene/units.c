/* Notes of numbers that are probably in another unit: one below each border, none at it and above. */
#include <dirent.h>

#include "fixture.h"
#include "../support/program.h"
#include "../support/skip.h"

static const char scm[] = "scene: 1\nend_time: 10\ntime_step: 0.1\n"
			  "soil: {name: dry_sand}\n"
			  "redistribute: {model: scm}\n"
			  "objects:\n"
			  "  - {name: a, shape: {wheel: {radius: 0.5, width: 0.3}}, path: {points: [[0, 0], [30, 0]], speed: 3}}\n"
			  "  - {name: b, shape: {wheel: {radius: 0.5, width: 0.3}}, path: {points: [[0, 9], [30, 9]], speed: 3}}\n"
			  "view: {camera: {chase: a}, images: 50}\n";

struct heard {
	int count;
	char text[800];
};

static void hear(void *user, const char *text)
{
	struct heard *heard = user;
	heard->count++;
	snprintf(heard->text, sizeof heard->text, "%s", text);
	assert_null(strchr(text, '\n'));
	assert_non_null(strstr(text, "; "));
}

static struct heard heard_of(const char *text, const struct scene_setting *settings, size_t count)
{
	struct scene *scene;
	struct heard heard = {.count = 0}, all = {.count = 0};
	if (load_text(text, settings, count, &scene) != STATUS_OK)
		fail_msg("%s", failure_message());
	scene_advise_units(scene, hear, &heard);
	scene_advise(scene, 0, hear, &all);
	assert_true(all.count >= heard.count);
	scene_destroy(scene);
	return heard;
}

/* `value` at `key` of the scene above; `says`: what the one note has in it; NULL: there is none. */
static void noted(const char *key, const char *value, const char *says)
{
	const struct scene_setting setting = {key, value};
	const struct heard heard = heard_of(scm, &setting, 1);
	if (heard.count != (says != NULL))
		fail_msg("%s: %s: %d notes: %s", key, value, heard.count, heard.text);
	if (says != NULL && strstr(heard.text, says) == NULL)
		fail_msg("\"%s\" does not say \"%s\"", heard.text, says);
	/* No number that the note tells to give is noted again. */
	for (const char *at = value[0] != '{' && value[0] != '[' ? strstr(heard.text, "give ") : NULL; at != NULL; at = strstr(at + 1, "give ")) {
		char given[64];
		if (sscanf(at, "give %63[0-9.e+-]", given) != 1)
			continue;
		const struct scene_setting again = {key, given};
		const struct heard once_more = heard_of(scm, &again, 1);
		if (once_more.count != 0)
			fail_msg("%s: %s is told to be given, and then: %s", key, given, once_more.text);
	}
}

static void angles_in_radians(void **state)
{
	noted("soil.friction_angle", "0.5", "--set soil.friction_angle: soil.friction_angle: 0.5 degrees is less than soils have, and probably "
					    "in radians; the unit is degrees: give 28.65");
	noted("soil.friction_angle", "1.599", "give 89");
	noted("soil.friction_angle", "0.02", "0.02 degrees is less than soils have; the unit is degrees: give 0 for none");
	noted("soil.friction_angle", "1.6", NULL);
	noted("soil.friction_angle", "1.61", NULL);
	noted("soil.repose", "0.6", "soil.repose: 0.6 degrees");
	noted("soil.repose", "1.6", NULL);
	noted("soil", "{name: dry_sand, friction_angle: 0, repose: 30}", NULL); /* none, in any unit */
}

static void cohesion_in_kilopascals(void **state)
{
	noted("soil.cohesion", "1.04", "soil.cohesion: 1.04 Pa is less than soils have, and probably in kPa; the unit is Pa: give 1040,");
	noted("soil.cohesion", "49.9", "give 49900");
	noted("soil.cohesion", "0.02", "0.02 Pa is less than soils have; the unit is Pa: give 0 for none");
	noted("soil.cohesion", "50", NULL);
	noted("soil.cohesion", "50.1", NULL);
	noted("soil.cohesion", "0", NULL);
}

static void moduli_in_kilonewtons(void **state)
{
	noted("soil.bekker_kphi", "5", "5 N/m^(n+2) is less than soils have; the unit is N/m^(n+2): give more, ");
	noted("soil.bekker_kphi", "1528.43", "--set soil.bekker_kphi: soil.bekker_kphi: 1528.43 N/m^(n+2) is less than soils have, and probably in "
					     "kN/m^(n+2); the unit is N/m^(n+2): give 1528430");
	noted("soil", "{name: dry_sand, bekker_kphi: 5301, bekker_kc: 102}", "give 5301000, and bekker_kc 102000");
	noted("soil", "{name: dry_sand, bekker_kphi: 43.12, bekker_kc: -2.5}", "give 43120, and bekker_kc -2500");
	noted("soil.bekker_kphi", "9999", "give 9999000");
	noted("soil.bekker_kphi", "10000", NULL);
	noted("soil.bekker_kphi", "0", NULL);
	noted("soil.bekker_kc", "0.99", NULL);
	noted("soil", "{name: dry_sand, bekker_kphi: 100, bekker_kc: 2e5}", NULL);
}

static void radii_in_millimetres(void **state)
{
	noted("objects", "[{name: a, shape: {wheel: {radius: 320, width: 240}}, path: {points: [[9, 9]], speed: 1}}]",
	      "objects[0].shape.wheel.radius: 320 m is large, and perhaps in mm; the unit is m: if it is in mm give 0.32");
	noted("objects", "[{name: a, shape: {sphere: {radius: 21}}, path: {points: [[9, 9]], speed: 1}}]", "if it is in mm give 0.021");
	noted("objects", "[{name: a, shape: {sphere: {radius: 20}}, path: {points: [[9, 9]], speed: 1}}]", NULL);
}

static void shear_in_centimetres_or_millimetres(void **state)
{
	noted("soil.janosi_shear", "2", "soil.janosi_shear: 2 m is more than soils have, and probably in cm or mm; the unit is m: if it is in cm give 0.02, "
					"if it is in mm give 0.002");
	noted("soil.janosi_shear", "0.16", "give 0.0016");
	noted("soil.janosi_shear", "0.15", NULL);
}

/* Not the numbers of a name when they are written out, and each of them when it is in the units of Wong's table. */
static void named_soils_get_none_but_in_the_units_of_their_table(void **state)
{
	const char *name;
	for (size_t i = 0; (name = soil_name(i)) != NULL; i++) {
		struct soil_numbers soil;
		char text[320];
		assert_int_equal(soil_named(name, &soil), STATUS_OK);
		if (isnan(soil.bekker_n) || soil_is_hard(&soil))
			continue;
		for (int table = 0; table < 2; table++) {
			const double kilo = table ? 1e3 : 1, centi = table ? 100 : 1;
			snprintf(text, sizeof text, "{name: %s, bekker_kc: %.9g, bekker_kphi: %.9g, janosi_shear: %.9g}", name, soil.bekker_kc / kilo,
				 soil.bekker_kphi / kilo, soil.janosi_shear * centi);
			const struct scene_setting setting = {"soil", text};
			const struct heard heard = heard_of(scm, &setting, 1);
			if (heard.count != 2 * table)
				fail_msg("%s: %d notes: %s", text, heard.count, heard.text);
		}
	}
}

static void surfaces_are_doubted_as_soils_are(void **state)
{
	noted("objects.a.interface.friction_angle", "0.35", "--set objects.a.interface.friction_angle: objects[0].interface.friction_angle: 0.35 degrees is "
							     "less than soils have, and probably in radians; the unit is degrees: give 20.05");
	noted("objects.a.interface.friction_angle", "1.6", NULL);
	noted("objects.b.interface", "{friction_angle: 0}", NULL);
	noted("objects.b.interface.adhesion", "0.4", "objects[1].interface.adhesion: 0.4 Pa is less than soils have, and probably in kPa; the unit is Pa: "
						      "give 400, or 0 for none");
	noted("objects.a.interface.adhesion", "50", NULL);
	noted("objects.a.interface", "{adhesion: 0}", NULL);
}

static void loads_in_kilonewtons_or_kilograms(void **state)
{
	noted("objects.a.load", "4", "objects[0].load: 4 N on a wheel of 0.5 m radius is less than the wheel's own weight; the unit is N: if it "
				     "is in kN give 4000, if it is in kg give 39.24");
	noted("objects.a.load", "9.99", "9.99 N");
	noted("objects.a.load", "10", NULL);
	noted("objects.a.load", "10.1", NULL);
	noted("objects.a", "{name: a, shape: {wheel: {radius: 0.25, width: 0.2}}, path: {points: [[0, 0]], speed: 3}, load: 9}", "0.25 m radius");
	noted("objects.a", "{name: a, shape: {wheel: {radius: 0.249, width: 0.2}}, path: {points: [[0, 0]], speed: 3}, load: 9}", NULL);
	noted("objects.a", "{name: a, shape: {sphere: {radius: 0.5}}, path: {points: [[0, 0]], speed: 3}, load: 9}", NULL);
	/* Wheels that are alike get one note. */
	const struct scene_setting both[] = {{"objects.a.load", "4"}, {"objects.b.load", "4"}};
	struct heard heard = heard_of(scm, both, 2);
	assert_int_equal(heard.count, 1);
	assert_non_null(strstr(heard.text, "radius, as 1 other has, is less"));
	const struct scene_setting apart[] = {{"objects.a.load", "4"}, {"objects.b.load", "5"}};
	assert_int_equal(heard_of(scm, apart, 2).count, 2);
}

static void a_sun_that_leaves_the_picture_black(void **state)
{
	noted("view.sun.height", "0.6", "view.sun.height: 0.6 degrees above the horizon: level ground is drawn almost black; the unit is degrees: "
					"if it is in radians give 34.38, else give 10 or more, a brighter view.sun.colour, or view.exposure: sun");
	noted("view.sun.height", "9.9", "the unit is degrees: give 10 or more");
	noted("view.sun.height", "0", "the unit is degrees: give 10 or more");
	noted("view.sun.height", "10", NULL);
	noted("view.sun.height", "10.1", NULL);
	noted("view.sun", "{height: 5, colour: [1, 1, 1]}", "5 degrees");
	noted("view.sun", "{height: 5, colour: [1, 2.5, 1]}", NULL); /* as bright as above 10 degrees */
	noted("view.sun.azimuth", "3", NULL);
	const struct scene_setting exposed[] = {{"view.sun.height", "5"}, {"view.exposure", "sun"}};
	assert_int_equal(heard_of(scm, exposed, 2).count, 0);
}

static void what_the_model_does_not_read_gets_no_such_note(void **state)
{
	const struct scene_setting box[] = {{"redistribute.model", "box"}, {"soil", "{cohesion: 1, friction_angle: 0.5}"}};
	assert_int_equal(heard_of(scm, box, 2).count, 0);
	const struct scene_setting sumner[] = {{"redistribute.model", "sumner"}, {"soil", "{name: sand, cohesion: 1}"}};
	assert_int_equal(heard_of(scm, sumner, 2).count, 0);
	const struct scene_setting slippage[] = {{"redistribute.model", "slippage"}, {"soil.cohesion", "1"}, {"soil.bekker_kphi", "1"}, {"soil.janosi_shear", "1"}};
	assert_int_equal(heard_of(scm, slippage, 4).count, 1);
}

static void a_note_names_the_line_and_the_column(void **state)
{
	char *text = edited(scm, "dry_sand}", "dry_sand, cohesion: 2, friction_angle: 0.4}");
	const struct heard heard = heard_of(text, NULL, 0);
	assert_int_equal(heard.count, 2);
	assert_non_null(strstr(heard.text, "scene.yaml:4:37: soil.friction_angle: 0.4 degrees"));
	free(text);
}

static void every_class_of_a_map_is_looked_at(void **state)
{
	write_text("classes.png", "not read here");
	char *text = edited(scm, "{name: dry_sand}", "{map: classes.png, classes: {1: dry_sand, 2: {name: lunar, cohesion: 5}}, "
						     "default: {name: lunar, friction_angle: 0.5}}");
	const struct heard heard = heard_of(text, NULL, 0);
	assert_int_equal(heard.count, 2);
	assert_non_null(strstr(heard.text, "soil.classes[1].cohesion: 5 Pa"));
	free(text);
	unlink(in_folder("classes.png"));
}

static bool ends_in(const char *name, const char *end)
{
	size_t length = strlen(name), most = strlen(end);
	return length > most && strcmp(name + length - most, end) == 0;
}

static void shipped_scenes_get_none(void **state)
{
	const char *scenes = getenv("SCENES");
	if (scenes == NULL)
		skip_since("the scenes that ship are not named");
	DIR *directory = opendir(scenes);
	assert_non_null(directory);
	int seen = 0;
	for (struct dirent *entry; (entry = readdir(directory)) != NULL;) {
		char path[1024];
		struct scene *scene;
		struct heard heard = {.count = 0};
		if (!ends_in(entry->d_name, ".yaml"))
			continue;
		seen++;
		snprintf(path, sizeof path, "%s/%s", scenes, entry->d_name);
		if (scene_load(path, NULL, 0, &scene) != STATUS_OK) {
			assert_says("this build reads no meshes");
			continue;
		}
		scene_advise_units(scene, hear, &heard);
		if (heard.count > 0)
			fail_msg("%s", heard.text);
		scene_destroy(scene);
	}
	closedir(directory);
	assert_true(seen >= 8);
}

static void memory_that_runs_out_is_told(void **state)
{
	const struct scene_setting settings[] = {{"soil.cohesion", "1"}, {"objects.a.load", "4"}, {"view.sun.height", "1"},
						   {"objects.b.interface.friction_angle", "1"}, {"soil.janosi_shear", "2"}, {"soil.bekker_kphi", "5e3"}};
	write_text("scene.yaml", scm);
	assert_memory_is_told(settings, 6, false);
	assert_memory_is_told(settings, 6, true);
	unlink(in_folder("scene.yaml"));
}

TEST_PROGRAM(units)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(angles_in_radians),
		cmocka_unit_test(cohesion_in_kilopascals),
		cmocka_unit_test(moduli_in_kilonewtons),
		cmocka_unit_test(radii_in_millimetres),
		cmocka_unit_test(shear_in_centimetres_or_millimetres),
		cmocka_unit_test(named_soils_get_none_but_in_the_units_of_their_table),
		cmocka_unit_test(surfaces_are_doubted_as_soils_are),
		cmocka_unit_test(loads_in_kilonewtons_or_kilograms),
		cmocka_unit_test(a_sun_that_leaves_the_picture_black),
		cmocka_unit_test(what_the_model_does_not_read_gets_no_such_note),
		cmocka_unit_test(a_note_names_the_line_and_the_column),
		cmocka_unit_test(every_class_of_a_map_is_looked_at),
		cmocka_unit_test(shipped_scenes_get_none),
		cmocka_unit_test(memory_that_runs_out_is_told),
	};
	return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
