/* run.json says every number of each soil that a drive had, and each object's load and slip. */
#include "../support.h"
#include "../support/near.h"
#include "../support/program.h"

#include <cJSON.h>

static const struct extent extent = {65, 65, 1, 64};

static double flat(int64_t x, int64_t y)
{
	return 10;
}

static void write_classes(void)
{
	const struct dem_raster raster = {.path = support_path("soils.png"), .width = 65, .height = 65, .type = DEM_UINT8, .spacing = 1};
	struct dem_writer *writer;
	double row[65];
	for (int x = 0; x < 65; x++)
		row[x] = x < 30 ? 3 : 40;
	must(dem_writer_create(&raster, &writer));
	for (int y = 0; y < 65; y++)
		must(dem_writer_rows(writer, 1, row));
	must(dem_writer_publish(writer));
	dem_writer_destroy(writer);
}

/* run.json of a short drive over such a soil; `object` ends the object. */
static cJSON *drive(const char *model, const char *soil, const char *object)
{
	char text[1024];
	const char *store = support_path("world.furrow");
	snprintf(text, sizeof text,
		 "scene: 1\ntime_step: 0.1\nend_time: 0.2\n%sredistribute: {model: %s}\nobjects:\n"
		 "  - {name: ball, shape: {wheel: {radius: 1, width: 1}}, path: {points: [[30, 30], [31, 30]], speed: 4}%s}\n", soil, model, object);
	support_write(support_path("scene.yaml"), text);
	support_store(store, extent, flat);
	char *json = support_drive(support_path("scene.yaml"), store, NULL);
	cJSON *root = cJSON_Parse(json);
	assert_non_null(root);
	mem_free(json);
	return root;
}

static const cJSON *soils_of(const cJSON *root, int count)
{
	const cJSON *soils = cJSON_GetObjectItemCaseSensitive(root, "soils");
	assert_true(cJSON_IsArray(soils));
	assert_int_equal(cJSON_GetArraySize(soils), count);
	return soils;
}

/* A soil has this name, this class (-1: null; -2: no such key) and exactly these numbers. */
static void assert_soil(const cJSON *soil, const char *name, int class, const char *numbers)
{
	const cJSON *said = cJSON_GetObjectItemCaseSensitive(soil, "class");
	cJSON *wanted = cJSON_Parse(numbers);
	assert_non_null(wanted);
	assert_string_equal(cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(soil, "name")), name);
	if (class == -2)
		assert_null(said);
	else if (class == -1)
		assert_true(cJSON_IsNull(said));
	else
		assert_near(cJSON_GetNumberValue(said), class, 0);
	assert_int_equal(cJSON_GetArraySize(soil), cJSON_GetArraySize(wanted) + (class == -2 ? 1 : 2));
	const cJSON *number;
	cJSON_ArrayForEach(number, wanted) {
		const cJSON *is = cJSON_GetObjectItemCaseSensitive(soil, number->string);
		if (!cJSON_IsNumber(is) || is->valuedouble != number->valuedouble)
			fail_msg("%s of %s: %g, not %g", number->string, name, is != NULL ? is->valuedouble : (double)NAN, number->valuedouble);
	}
	cJSON_Delete(wanted);
}

#define LUNAR(cohesion) \
	"{\"bekker_kc\": 1400, \"bekker_kphi\": 820000, \"bekker_n\": 1, \"cohesion\": " cohesion ", \"friction_angle\": 35, " \
	"\"janosi_shear\": 0.018, \"elastic_stiffness\": 4e7, \"damping\": 3e4, \"density\": 1543.21, \"unit_weight\": 2500, \"repose\": 35}"

static void a_drive_tells_its_soil_its_load_and_its_slip(void **state)
{
	cJSON *root = drive("scm", "soil: {name: lunar, cohesion: 300}\n", ", load: 4000, slip: 0.25");
	assert_soil(cJSON_GetArrayItem(soils_of(root, 1), 0), "lunar", -2, LUNAR("300"));
	const cJSON *ball = cJSON_GetObjectItem(cJSON_GetObjectItem(root, "objects"), "ball");
	assert_true(cJSON_GetNumberValue(cJSON_GetObjectItem(ball, "load")) == 4000);
	assert_true(cJSON_GetNumberValue(cJSON_GetObjectItem(ball, "slip")) == 0.25);
	cJSON_Delete(root);
	/* Given by numbers alone: what was not given is not there. */
	root = drive("slippage", "soil: {cohesion: 0, friction_angle: 29, unit_weight: 15000}\n", ", sink: 0.2");
	assert_soil(cJSON_GetArrayItem(soils_of(root, 1), 0), "unnamed", -2,
		    "{\"cohesion\": 0, \"friction_angle\": 29, \"unit_weight\": 15000, \"repose\": 29}");
	ball = cJSON_GetObjectItem(cJSON_GetObjectItem(root, "objects"), "ball");
	assert_true(cJSON_IsNull(cJSON_GetObjectItem(ball, "load")));
	assert_true(cJSON_GetNumberValue(cJSON_GetObjectItem(ball, "slip")) == 0);
	cJSON_Delete(root);
}

static void a_drive_on_a_map_tells_each_of_its_soils(void **state)
{
	write_classes();
	cJSON *root = drive("slippage", "soil: {map: soils.png, classes: {3: lunar, 40: {cohesion: 9, friction_angle: 31, unit_weight: 15000}}, "
			    "default: {name: mud, cohesion: 1, friction_angle: 10, unit_weight: 17000, theta_in: 80, theta_out: 60, theta_stop: 70}}\n",
			    ", sink: 0.2");
	const cJSON *soils = soils_of(root, 3);
	assert_soil(cJSON_GetArrayItem(soils, 0), "mud", -1,
		    "{\"cohesion\": 1, \"friction_angle\": 10, \"unit_weight\": 17000, \"repose\": 10, \"theta_in\": 80, \"theta_out\": 60, "
		    "\"theta_stop\": 70, \"roughness\": 0.2, \"compression\": 0.59}");
	assert_soil(cJSON_GetArrayItem(soils, 1), "lunar", 3, LUNAR("170"));
	assert_soil(cJSON_GetArrayItem(soils, 2), "unnamed_40", 40,
		    "{\"cohesion\": 9, \"friction_angle\": 31, \"unit_weight\": 15000, \"repose\": 31}");
	cJSON_Delete(root);
}

static void a_model_that_reads_no_soil_has_none(void **state)
{
	cJSON *root = drive("box", "soil: {name: mud}\n", "");
	soils_of(root, 0);
	cJSON_Delete(root);
}

TEST_PROGRAM(soils)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_drive_tells_its_soil_its_load_and_its_slip),
		cmocka_unit_test(a_drive_on_a_map_tells_each_of_its_soils),
		cmocka_unit_test(a_model_that_reads_no_soil_has_none),
	};
	return cmocka_run_group_tests_name("report/soils", tests, support_enter, support_leave);
}
