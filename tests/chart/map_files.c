/* The files of maps, and what is written in them: numbers, names of systems, text on pictures. No GL. */
#include "drawn.h"
#include "../support/program.h"
#include "../support/skip.h"

/* --- numbers and names --- */

static void numbers_are_written_for_people(void **state)
{
	static const struct {
		double value, step;
		const char *text;
	} cases[] = {{0, 1, "0"},
		     {-0.4, 1, "0"},
		     {-12, 1,
		      "\xe2\x88\x92"
		      "12"},
		     {1234, 1, "1234"},
		     {12345, 1,
		      "12\xe2\x80\xaf"
		      "345"},
		     {-4649776.5, 0.5,
		      "\xe2\x88\x92"
		      "4\xe2\x80\xaf"
		      "649\xe2\x80\xaf"
		      "776.5"},
		     {0.05, 0.01, "0.05"},
		     {1e9, 1e8,
		      "1\xe2\x80\xaf"
		      "000\xe2\x80\xaf"
		      "000\xe2\x80\xaf"
		      "000"}};
	char text[64];
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		chart_number(cases[i].value, cases[i].step, text, sizeof text);
		assert_string_equal(text, cases[i].text);
	}
	chart_length(0.02, text, sizeof text);
	assert_string_equal(text, "2 cm");
	chart_length(5000, text, sizeof text);
	assert_string_equal(text, "5 km");
	chart_length(0.0625, text, sizeof text);
	assert_string_equal(text, "6.25 cm");
	chart_length(2e7, text, sizeof text);
	assert_string_equal(text, "20\xe2\x80\xaf"
				  "000 km");
}

static void the_name_of_a_system_is_read_from_any_text(void **state)
{
	static const char *const cases[][2] = {
		{"", ""},
		{"PROJCRS[\"WGS 84 / UTM zone 33N\",BASEGEOGCRS[\"WGS 84\",ID[\"EPSG\",4326]],ID[\"EPSG\",32633]]",
		 "WGS 84 / UTM zone 33N (EPSG:32633)"},
		{"PROJCS[\"a \"\"b\"\" [\",AUTHORITY[\"X\",\"7\"]]", "a \"b\" [ (X:7)"},
		{"PROJCS[\"open", "open"},
		{"PROJCS[\"x\",ID[", "x"},
		{"PROJCS[\"x\",ID[\"EPSG\"", "x"},
		{"[[[[]]]]]]]\"", ""},
		{"PROJCRS[\"unnamed\",BASEGEOGCRS[\"NAD27\",DATUM[\"North American Datum 1927\"]],CONVERSION[\"UTM zone 10N\"]]",
		 "unnamed, UTM zone 10N on NAD27"},
		{"PROJCS[\"unknown\",GEOGCS[\"unknown\",DATUM[\"D \"\"DATUM[\"]],PROJECTION[\"Transverse_Mercator\"]]", "unnamed, on D \"DATUM["},
		{"PROJCS[\"unnamed\",GEOGCS[\"unknown\",DATUM[\"unknown\"]]]", "unnamed"},
		{"PROJCRS[\"unnamed\",BASEGEOGCRS[", "unnamed"},
	};
	char text[160];
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		chart_system_name(cases[i][0], text, sizeof text);
		assert_string_equal(text, cases[i][1]);
	}
}

/* --- files --- */

static size_t read_file(const char *path, char *bytes, size_t room)
{
	FILE *file = fopen(path, "rb");
	assert_non_null(file);
	const size_t size = fread(bytes, 1, room, file);
	fclose(file);
	assert_true(size > 0 && size < room);
	return size;
}

static enum status write_map(const char *name)
{
	struct chart_raster_params params = asked(0, STORE_OFFSET);
	struct chart_raster raster;
	must(chart_raster_create(&params, &raster));
	struct chart_map map = plain(400);
	map.raster = &raster;
	map.meta = params.meta;
	enum status status = chart_map_write(&map, support_path(name), NULL);
	chart_raster_finish(&raster);
	return status;
}

/* The same holds for SVG and PDF of two processes; within one Cairo counts on. */
static void the_same_map_is_the_same_file(void **state)
{
	enum { ROOM = 4 << 20 };
	char *bytes[2] = {malloc(ROOM), malloc(ROOM)};
	must(write_map("a.png"));
	must(write_map("b.PNG"));
	const size_t size = read_file(support_path("a.png"), bytes[0], ROOM);
	assert_int_equal(read_file(support_path("b.PNG"), bytes[1], ROOM), size);
	assert_memory_equal(bytes[0], bytes[1], size);
	free(bytes[0]);
	free(bytes[1]);
}

static void a_full_disk_is_told_and_leaves_nothing(void **state)
{
	static const char *const endings[] = {"png", "svg", "pdf"};
	if (access("/dev/full", W_OK) != 0)
		skip_since(SKIP_ELSEWHERE "no /dev/full");
	for (size_t i = 0; i < 3; i++) {
		char name[16], part[24];
		snprintf(name, sizeof name, "full.%s", endings[i]);
		snprintf(part, sizeof part, "%s.part", name);
		assert_int_equal(symlink("/dev/full", support_path(part)), 0);
		assert_int_equal(write_map(name), STATUS_FAILED);
		assert_non_null(strstr(failure_message(), name));
		assert_non_null(strstr(failure_message(), "No space left"));
		assert_true(access(support_path(name), F_OK) != 0 && access(support_path(part), F_OK) != 0);
		/* A folder that is not there. */
		snprintf(name, sizeof name, "no/map.%s", endings[i]);
		assert_int_equal(write_map(name), STATUS_FAILED);
	}
	assert_int_equal(write_map("map.jpg"), STATUS_USAGE);
}

static void running_out_of_memory_is_told(void **state)
{
	static const char *const names[] = {"out.png", "out.svg"};
	const double places[2][2] = {{40, 40}, {200, 90}};
	const struct chart_way way = {"way", places, 2, false};
	for (size_t i = 0; i < 2; i++) {
		struct chart_raster_params params = asked(1, STORE_PLASTIC_SINKAGE);
		enum status status = STATUS_FAILED;
		for (uint64_t nth = 1; status != STATUS_OK; nth++) {
			struct chart_raster raster = {.width = 0};
			mem_fail_nth(nth, 0);
			status = chart_raster_create(&params, &raster);
			if (status == STATUS_OK)
				status = chart_raster_widen(&raster);
			struct chart_map map = plain(200);
			map.raster = &raster;
			map.meta = params.meta;
			map.ramp = CHART_RAMP_GREEN;
			map.ways = &way;
			map.way_count = 1;
			if (status == STATUS_OK)
				status = chart_map_write(&map, support_path(names[i]), NULL);
			mem_fail_nth(0, 0);
			assert_true(status == STATUS_OK ? nth > 10 : status == STATUS_FAILED);
			assert_true((access(support_path(names[i]), F_OK) == 0) == (status == STATUS_OK));
			chart_raster_finish(&raster);
		}
	}
}

/* --- text on pictures --- */

static void a_pen_writes_where_it_is_told(void **state)
{
	struct chart_pen *pen;
	must(chart_pen_create(&pen));
	static uint8_t bytes[4 * 200 * 60];
	for (size_t i = 0; i < sizeof bytes; i++)
		bytes[i] = i % 4 == 3 ? 255 : 0;
	const struct chart_pixels pixels = {bytes, 200, 60};
	const struct chart_colour white = {255, 255, 255, 255};
	const int width = chart_pen_width(pen, 20, "Hxg \xd0\x96");
	assert_true(width > 20 && width < 120 && chart_pen_width(pen, 40, "Hxg \xd0\x96") > 1.8 * width);
	must(chart_pen_write(pen, &pixels, 30, 15, 20, "Hxg \xd0\x96", white));
	int inked = 0;
	for (int y = 0; y < 60; y++)
		for (int x = 0; x < 200; x++) {
			const bool ink = bytes[4 * (y * 200 + x)] > 60;
			inked += ink;
			assert_true(!ink || (x >= 28 && x <= 32 + width && y >= 15 && y < 35));
		}
	assert_true(inked > 100);
	/* Outside, partly and wholly. */
	must(chart_pen_write(pen, &pixels, -20, -10, 20, "outside", white));
	must(chart_pen_write(pen, &pixels, 1000, 1000, 20, "outside", white));
	must(chart_pen_write(pen, &pixels, 0, 0, 20, "", white));
	chart_box(&pixels, INT32_MIN, INT32_MIN, INT32_MAX, INT32_MAX, white);
	for (size_t i = 0; i < sizeof bytes; i++)
		assert_int_equal(bytes[i], 255);
	chart_pen_destroy(pen);
	chart_pen_destroy(NULL);
}

TEST_PROGRAM(map_files)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(numbers_are_written_for_people),
		cmocka_unit_test(the_name_of_a_system_is_read_from_any_text),
		cmocka_unit_test(the_same_map_is_the_same_file),
		cmocka_unit_test(a_full_disk_is_told_and_leaves_nothing),
		cmocka_unit_test(running_out_of_memory_is_told),
		cmocka_unit_test(a_pen_writes_where_it_is_told),
	};
	return cmocka_run_group_tests(tests, enter, leave);
}
