/* Named soils: which models may have them, what is said of one that lacks a number, and the docs' table of them. DOCS: the folder
 * of docs. */
#include <math.h>

#include "fixture.h"
#include "soil/soil.h"
#include "../support/near.h"
#include "../support/program.h"

static const char *const models[] = {"none", "box", "sumner", "slippage", "scm"};

/* What each kind of soil has. */
static const char *const by_wong[] = {"sandy_loam_15", "sandy_loam_22", "clayey_38", "heavy_clay_25", "heavy_clay_40", "lean_clay_22",
				      "lete_sand", "upland_loam_51", "snow_us", "snow_sweden", "lunar"};
static const char *const by_sumner[] = {"sand", "mud", "snow"};
static const char *const hard[] = {"rock", "asphalt", "concrete", "ice"};
#define COUNT(array) (sizeof(array) / sizeof(array)[0])

static const char scm_reads[] = "bekker_kc, bekker_kphi, bekker_n, cohesion, friction_angle, janosi_shear";
static const char slippage_reads[] = "cohesion, friction_angle, unit_weight";
static const char sumner_reads[] = "theta_in, theta_out, theta_stop, roughness, compression";
static const char wongs[] = "name one of dry_sand, sandy_loam_15, sandy_loam_22, clayey_38, heavy_clay_25, heavy_clay_40, "
			    "lean_clay_22, lete_sand, upland_loam_51, snow_us, snow_sweden, lunar";
static const char and_hard[] = ", rock, asphalt, concrete, ice"; /* scm's alone */
static const char sumners[] = "name one of dry_sand, sand, mud, snow";

/* A scene of that soil, as it is written after "soil: ". */
static enum status load_soil(const char *soil, const char *model, struct scene **scene)
{
	char text[1024];
	snprintf(text, sizeof text,
		 "scene: 1\nend_time: 1\nsoil: %s\nredistribute: {model: %s}\nobjects:\n  - name: a\n"
		 "    shape: {wheel: {radius: 0.5, width: 0.4}}\n    path: {points: [[1, 2]], speed: 3}\n", soil, model);
	return load_text(text, NULL, 0, scene);
}

static void take(const char *soil, const char *model, struct scene **scene)
{
	if (load_soil(soil, model, scene) != STATUS_OK)
		fail_msg("%s, model %s: %s", soil, model, failure_message());
}

/* `says` is the end of the message. */
static void refuse(const char *soil, const char *model, const char *says)
{
	struct scene *scene;
	enum status status = load_soil(soil, model, &scene);
	if (status != STATUS_INPUT)
		fail_msg("%s, model %s, gives %d", soil, model, status);
	assert_null(scene);
	const char *message = without_columns(failure_message());
	size_t length = strlen(message);
	if (length < strlen(says) || strcmp(message + length - strlen(says), says) != 0)
		fail_msg("\"%s\" does not end in \"%s\"", failure_message(), says);
}

static const char *named(const char *name)
{
	static char soil[80];
	snprintf(soil, sizeof soil, "{name: %s}", name);
	return soil;
}

static void refuse_named(const char *name, const char *model, const char *missing, const char *instead)
{
	char says[700];
	snprintf(says, sizeof says, "scene.yaml:3: soil.name: %s has no %s, which model %s reads; give these beside the name, or %s%s",
		 name, missing, model, instead, strcmp(model, "scm") == 0 ? and_hard : "");
	refuse(named(name), model, says);
}

static void a_soil_goes_with_the_models_that_it_has_the_numbers_for(void **state)
{
	size_t names = 0;
	while (soil_name(names) != NULL)
		names++;
	assert_int_equal(names, 1 + COUNT(by_wong) + COUNT(by_sumner) + COUNT(hard));
	for (size_t m = 0; m < COUNT(models); m++) {
		struct scene *scene;
		take("{name: dry_sand}", models[m], &scene);
		assert_int_equal(scene->soil_count, m < 2 ? 0 : 1);
		scene_destroy(scene);
		for (size_t i = 0; i < COUNT(by_wong); i++) {
			if (strcmp(models[m], "sumner") == 0) {
				refuse_named(by_wong[i], models[m], sumner_reads, sumners);
				continue;
			}
			take(named(by_wong[i]), models[m], &scene);
			scene_destroy(scene);
		}
		for (size_t i = 0; i < COUNT(by_sumner); i++) {
			if (m > 2) {
				refuse_named(by_sumner[i], models[m], strcmp(models[m], "scm") == 0 ? scm_reads : slippage_reads, wongs);
				continue;
			}
			take(named(by_sumner[i]), models[m], &scene);
			scene_destroy(scene);
		}
		for (size_t i = 0; i < COUNT(hard); i++) {
			if (strcmp(models[m], "scm") != 0) {
				char says[200];
				snprintf(says, sizeof says, "soil.name: %s is hard ground, into which nothing sinks, and model %s presses into all ground; write redistribute: {model: scm}",
					 hard[i], models[m]);
				refuse(named(hard[i]), models[m], says);
				continue;
			}
			take(named(hard[i]), models[m], &scene);
			assert_true(soil_is_hard(&scene->soils[0]));
			/* Its text is of the same soil. */
			struct scene *again;
			char *text = scene_soil_text(&scene->soils[0], scene->model);
			assert_non_null(text);
			take(text, models[m], &again);
			assert_true(soil_is_hard(&again->soils[0]) && fabs(again->soils[0].friction_angle / scene->soils[0].friction_angle - 1) < 1e-12);
			mem_free(text);
			scene_destroy(again);
			scene_destroy(scene);
		}
	}
}

static void only_what_the_model_reads_and_the_soil_lacks_is_asked_for(void **state)
{
	struct scene *scene;
	refuse("{name: snow_us, depth: 0.1}", "scm", ": soil.depth: unknown key; a soil that ends somewhere has a thickness, and lies over another or over rigid ground: write {name: snow_us, "
	       "thickness: 0.1, over: rigid}; redistribute.depth is how deep soil slides");
	refuse("{name: mud, cohesion: 5000}", "slippage", ": mud has no friction_angle, unit_weight, which model slippage reads; give these "
	       "beside the name, or name one of dry_sand, sandy_loam_15, sandy_loam_22, clayey_38, heavy_clay_25, heavy_clay_40, lean_clay_22, "
	       "lete_sand, upland_loam_51, snow_us, snow_sweden, lunar");
	refuse("{name: lunar, theta_in: 40, theta_out: 30, theta_stop: 40, roughness: 0.1}", "sumner",
	       ": lunar has no compression, which model sumner reads; give these beside the name, or name one of dry_sand, sand, mud, snow");
	take("{name: mud, cohesion: 5000, friction_angle: 12, unit_weight: 17000}", "slippage", &scene);
	assert_string_equal(scene->soil_names[0], "mud");
	assert_true(scene->soils[0].cohesion == 5000 && scene->soils[0].unit_weight == 17000);
	/* What nobody gave, and nobody reads, is not made up. */
	assert_true(isnan(scene->soils[0].bekker_n) && isnan(scene->soils[0].damping));
	scene_destroy(scene);
	take("{name: snow, bekker_kc: 1000, bekker_kphi: 2e5, bekker_n: 1.5, cohesion: 900, friction_angle: 21, janosi_shear: 0.03}", "scm", &scene);
	assert_true(scene->soils[0].repose == scene->soils[0].friction_angle);
	assert_true(scene->soils[0].elastic_stiffness == SOIL_USUAL_STIFFNESS && scene->soils[0].damping == SOIL_USUAL_DAMPING);
	scene_destroy(scene);
	refuse("{name: snow, bekker_kc: 1000, bekker_kphi: 2e5, bekker_n: 1.5, cohesion: 900, friction_angle: 0, janosi_shear: 0.03, "
	       "elastic_stiffness: 4e7, damping: 3e4}", "scm", ": soil: without friction it needs repose too; allowed: above 0 to 89");
}

static void each_soil_of_a_map_is_held_to_it(void **state)
{
	struct scene *scene;
	write_text("m.png", "m");
	refuse("{map: m.png, classes: {1: lunar, 9: sand}, default: dry_sand}", "slippage",
	       ":3: soil.classes[1].name: sand has no cohesion, friction_angle, unit_weight, which model slippage reads; give these beside the "
	       "name, or name one of dry_sand, sandy_loam_15, sandy_loam_22, clayey_38, heavy_clay_25, heavy_clay_40, lean_clay_22, lete_sand, "
	       "upland_loam_51, snow_us, snow_sweden, lunar");
	refuse("{map: m.png, classes: {1: mud}, default: lunar}", "sumner",
	       ":3: soil.default.name: lunar has no theta_in, theta_out, theta_stop, roughness, compression, which model sumner reads; give "
	       "these beside the name, or name one of dry_sand, sand, mud, snow");
	/* A picture reads no numbers. */
	take("{map: m.png, classes: {1: mud}, default: lunar}", "box", &scene);
	scene_destroy(scene);
	take("{map: m.png, classes: {4: lunar, 200: {cohesion: 0, friction_angle: 30, unit_weight: 15000}}, default: {cohesion: 1, "
	     "friction_angle: 20, unit_weight: 15000}}", "slippage", &scene);
	assert_string_equal(scene->soil_names[0], "unnamed");
	assert_string_equal(scene->soil_names[1], "lunar");
	assert_string_equal(scene->soil_names[2], "unnamed_200");
	assert_int_equal(scene_soil_value(scene, 0), -1);
	assert_int_equal(scene_soil_value(scene, 1), 4);
	assert_int_equal(scene_soil_value(scene, 2), 200);
	scene_destroy(scene);
	unlink(in_folder("m.png"));
}

/* What soil weighs: its unit_weight; or density and gravity, where the scene gives one of them; or as its name says. Faces have their strength of it. */
static void a_soil_weighs_by_its_density_and_gravity(void **state)
{
	static const char own[] = "bekker_kc: 0, bekker_kphi: 1e6, bekker_n: 1, cohesion: 0, friction_angle: 29, janosi_shear: 0.02";
	static const struct {
		const char *soil, *model, *gravity;
		double density, weight;
	} rows[] = {
		{"name: dry_sand", "scm", "", 1631, 16000}, {"name: lunar", "scm", "", 1543.21, 2500}, {"name: lunar", "slippage", "", 1543.21, 2500},
		{"name: lunar", "scm", "gravity: 1.62\n", 1543.21, 2500}, {"name: lunar", "scm", "gravity: 9.81\n", 1543.21, 15138.9},
		{"name: dry_sand", "slippage", "gravity: 3.71\n", 1631, 6051.01}, {"name: dry_sand, density: 1400", "scm", "", 1400, 13734},
		{"name: dry_sand, unit_weight: 8000", "scm", "gravity: 4\n", 2000, 8000}, {"name: dry_sand, unit_weight: 8000, density: 1500", "scm", "gravity: 4\n", 1500, 8000},
		{own, "scm", "", 1600, 15696}, {own, "scm", "gravity: 1.62\n", 1600, 2592}, {"cohesion: 0, friction_angle: 30, density: 1500", "slippage", "gravity: 2\n", 1500, 3000},
	};
	for (size_t i = 0; i < COUNT(rows); i++) {
		char text[800];
		struct scene *scene;
		snprintf(text, sizeof text, "scene: 1\nend_time: 1\n%ssoil: {%s}\nredistribute: {model: %s}\nobjects:\n  - name: a\n"
					    "    shape: {wheel: {radius: 0.5, width: 0.4}}\n    path: {points: [[1, 2]], speed: 3}\n",
			 rows[i].gravity, rows[i].soil, rows[i].model);
		if (load_text(text, NULL, 0, &scene) != STATUS_OK)
			fail_msg("%s", failure_message());
		const struct soil_numbers *soil = &scene->soils[0];
		const double m = tan(soil->friction_angle) < 0.3 ? 0.3 : tan(soil->friction_angle) > 0.9 ? 0.9 : tan(soil->friction_angle);
		assert_near(soil->density, rows[i].density, 1e-3);
		assert_near(soil->unit_weight, rows[i].weight, 1e-6 * rows[i].weight);
		assert_near(soil_face_strength(soil), rows[i].weight * (894 * m * m * m - 386 * m * m + 89 * m), 1e-3 * rows[i].weight);
		scene_destroy(scene);
	}
	/* An example of the paper's formula; the ends of its range; and a strength that is given. */
	struct soil_numbers soil = {.unit_weight = 1330 * 9.81, .friction_angle = 29 * M_PI / 180, .face_strength = (double)NAN};
	assert_near(soil_face_strength(&soil) / 1.083e6, 1, 5e-4);
	soil.friction_angle = 0;
	assert_near(soil_face_strength(&soil), 1330 * 9.81 * (894 * 0.027 - 386 * 0.09 + 89 * 0.3), 1e-3);
	soil.friction_angle = 60 * M_PI / 180;
	assert_near(soil_face_strength(&soil), 1330 * 9.81 * (894 * 0.729 - 386 * 0.81 + 89 * 0.9), 1e-2);
	soil.face_strength = 7;
	assert_near(soil_face_strength(&soil), 7, 0);
}

/* --- the docs' table --- */

struct text {
	char *bytes;
	size_t length, room;
};

static void add(struct text *text, const char *format, ...) FURROW_PRINTF(2, 3);
static void add(struct text *text, const char *format, ...)
{
	va_list arguments;
	va_start(arguments, format);
	text->length += (size_t)vsnprintf(text->bytes + text->length, text->room - text->length, format, arguments);
	va_end(arguments);
	assert_true(text->length < text->room);
}

static void add_cell(struct text *text, double value)
{
	if (isnan(value))
		add(text, " — |");
	else
		add(text, " %.7g |", value);
}

/* A table of those numbers that the soil `like` has, and of the soils that have any of them. */
static void add_table(struct text *text, const struct soil_numbers *like)
{
	const char *key, *name;
	double has, value;
	size_t columns = 0;
	add(text, "| name |");
	for (size_t i = 0; scene_soil_number(like, i, &key, &has); i++) {
		char path[80];
		struct scene_parameter parameter;
		if (isnan(has))
			continue;
		snprintf(path, sizeof path, "soil.%s", key);
		assert_true(scene_parameter(path, &parameter));
		add(text, parameter.unit != NULL ? " `%s`, %s |" : " `%s` |", key, parameter.unit);
		columns++;
	}
	add(text, "\n| --- |");
	for (size_t i = 0; i < columns; i++)
		add(text, " --- |");
	for (size_t n = 0; (name = soil_name(n)) != NULL; n++) {
		struct soil_numbers soil;
		struct text line = {(char[1024]){""}, 0, 1024};
		bool any = false;
		assert_int_equal(soil_named(name, &soil), STATUS_OK);
		for (size_t i = 0; scene_soil_number(like, i, &key, &has); i++)
			if (!isnan(has) && scene_soil_number(&soil, i, &key, &value)) {
				any = any || !isnan(value);
				add_cell(&line, value);
			}
		if (any)
			add(text, "\n| %s |%s", name, line.bytes);
	}
	add(text, "\n");
}

/* The text of a page of the docs. Valid until the next call. */
static const char *page_of(const char *name)
{
	static char page[1 << 17];
	char path[512];
	const char *docs = getenv("DOCS");
	assert_non_null(docs);
	snprintf(path, sizeof path, "%s/%s", docs, name);
	FILE *file = fopen(path, "r");
	assert_non_null(file);
	size_t got = fread(page, 1, sizeof page - 1, file);
	fclose(file);
	assert_true(got > 0 && got < sizeof page - 1);
	page[got] = 0;
	return page;
}

/* The page has this table. */
static void page_has(const char *name, const struct text *table)
{
	if (strstr(page_of(name), table->bytes) != NULL)
		return;
	fputs(table->bytes, stderr);
	fail_msg("%s does not have the table that stands above; put it there", name);
}

static void the_docs_have_every_number_of_every_named_soil(void **state)
{
	static char bytes[1 << 15];
	struct soil_numbers wong, sumner;
	assert_int_equal(soil_named("lunar", &wong), STATUS_OK);
	assert_int_equal(soil_named("mud", &sumner), STATUS_OK);
	const struct soil_numbers *const tables[] = {&wong, &sumner};
	for (size_t i = 0; i < COUNT(tables); i++) {
		struct text text = {bytes, 0, sizeof bytes};
		add_table(&text, tables[i]);
		add(&text, "\n"); /* it has no row more */
		page_has("SOILS.md", &text);
	}
}

/* A number of a soil by its key; NAN: it has none. Fails if no soil has such a number. */
static double number_of(const struct soil_numbers *soil, const char *key)
{
	const char *name;
	double value;
	for (size_t i = 0; scene_soil_number(soil, i, &name, &value); i++)
		if (strcmp(name, key) == 0)
			return value;
	fail_msg("a model reads %s, and no soil has such a number", key);
	return (double)NAN;
}

static void add_numbers(struct text *text, const char *const *numbers)
{
	if (numbers == NULL)
		add(text, " no number |");
	for (size_t i = 0; numbers != NULL && numbers[i] != NULL; i++)
		add(text, "%s `%s`%s", i > 0 ? "," : "", numbers[i], numbers[i + 1] == NULL ? " |" : "");
}

/* The named soils that have all of these numbers. */
static void add_soils(struct text *text, const char *const *numbers)
{
	const char *name, *before = " ";
	for (size_t n = 0; numbers != NULL && (name = soil_name(n)) != NULL; n++) {
		struct soil_numbers soil;
		bool whole = true;
		assert_int_equal(soil_named(name, &soil), STATUS_OK);
		for (size_t i = 0; numbers[i] != NULL; i++)
			whole = whole && (!isnan(number_of(&soil, numbers[i])) || strncmp(numbers[i], "face_", 5) == 0 || strcmp(numbers[i], "compaction") == 0); /* these have formulas, or are 0 */
		if (whole)
			add(text, "%s%s", before, name);
		before = whole ? ", " : before;
	}
	add(text, numbers == NULL ? " all |" : " |");
}

static void the_docs_have_every_model_as_its_row_says(void **state)
{
	static char bytes[1 << 14];
	struct text uses = {bytes, 0, sizeof bytes / 2}, reads = {bytes + sizeof bytes / 2, 0, sizeof bytes / 2};
	add(&uses, "| model | what the ground does | volume |\n| --- | --- | --- |\n");
	add(&reads, "| model | reads | soils that have it |\n| --- | --- | --- |\n");
	for (int m = 0; m < DEFORM_MODELS; m++) {
		const struct soil_model *model = deform_model_row((enum deform_model)m);
		add(&uses, "| `%s` | %s | %s |\n", model->name, model->use, model->volume);
		add(&reads, "| `%s` |", model->name);
		add_numbers(&reads, model->numbers);
		add_soils(&reads, model->numbers);
		add(&reads, "\n");
	}
	add(&uses, "\n"); /* they have no row more */
	add(&reads, "\n");
	page_has("DRIVES.md", &uses);
	page_has("SOILS.md", &uses);
	page_has("SOILS.md", &reads);
}

/* What a row says of a scene is of a scene: keys, words, effects. */
static void every_row_names_what_a_scene_knows(void **state)
{
	struct scene_parameter parameter;
	enum scene_effect effect;
	for (int m = 0; m < DEFORM_MODELS; m++) {
		const enum deform_model number = (enum deform_model)m;
		const struct soil_model *model = deform_model_row(number);
		char key[80];
		for (size_t i = 0; model->keys != NULL && model->keys[i] != NULL; i++) {
			snprintf(key, sizeof key, "redistribute.%s", model->keys[i]);
			assert_true(scene_parameter(key, &parameter));
		}
		assert_true(scene_effect_named(model->effect.name, &effect) && effect == EFFECT_OF(m));
		assert_true(scene_effect_named(deform_displace_effect(number), &effect));
		assert_true(scene_effect_named(deform_contact_effect(number), &effect));
		assert_true(model->slide == NULL || scene_effect_named(deform_slide_effect(number), &effect));
		/* Soil that slides has strengths, and a rule by which it does. */
		assert_int_equal(model->slide != NULL, model->numbers != NULL);
		assert_int_equal(model->slide != NULL, deform_model_takes(number, "iterations"));
		assert_int_equal(model->smooths, deform_model_takes(number, "radius"));
		assert_true(scene_parameter("redistribute.model", &parameter) && strstr(parameter.words, model->name) != NULL);
	}
}

TEST_PROGRAM(soils)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_soil_goes_with_the_models_that_it_has_the_numbers_for),
		cmocka_unit_test(only_what_the_model_reads_and_the_soil_lacks_is_asked_for),
		cmocka_unit_test(each_soil_of_a_map_is_held_to_it),
		cmocka_unit_test(a_soil_weighs_by_its_density_and_gravity),
		cmocka_unit_test(the_docs_have_every_number_of_every_named_soil),
		cmocka_unit_test(the_docs_have_every_model_as_its_row_says),
		cmocka_unit_test(every_row_names_what_a_scene_knows),
	};
	return cmocka_run_group_tests_name("scene/soils", tests, make_folder, drop_folder);
}
