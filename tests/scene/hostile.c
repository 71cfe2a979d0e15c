/* Text that was made to do harm, and memory that runs out. Random changes of scenes and poses: tests/fuzz/scene.c. */
#include <sys/stat.h>

#include "fixture.h"
#include "../support/program.h"

static void refuses(const void *bytes, size_t length, const char *says)
{
	struct scene *scene;
	write_bytes("scene.yaml", bytes, length);
	assert_int_equal(scene_load(in_folder("scene.yaml"), NULL, 0, &scene), STATUS_INPUT);
	unlink(in_folder("scene.yaml"));
	assert_null(scene);
	assert_says(says);
}

static void deep_nesting_is_refused(void **state)
{
	const size_t count = 500000;
	char *text = room_for(count);
	memset(text, '[', count);
	refuses(text, count, "scene.yaml:1: ");
	memset(text, '{', count);
	refuses(text, count, "scene.yaml:1: ");
	for (size_t i = 0; i + 1 < count; i += 2)
		memcpy(text + i, "- ", 2);
	refuses(text, count, "nested too deeply");
	free(text);
}

static void aliases_are_refused_so_that_none_can_multiply(void **state)
{
	static const char bomb[] = "a: &a [x, x]\nb: &b [*a, *a]\nc: &c [*b, *b]\nscene: *c\n";
	refuses(bomb, strlen(bomb), "scene.yaml:1: an anchor or a tag");
}

static void a_nul_byte_is_refused(void **state)
{
	refuses("scene: 1\n\0end_time: 1\n", 22, "a NUL byte");
	refuses("\xff\xfes\0:\0 \0", 8, "a NUL byte");
}

static void what_is_not_utf8_is_refused(void **state)
{
	refuses("scene: 1\nstore: \xff\xfe\n", 19, "not YAML");
}

static void a_huge_file_is_refused(void **state)
{
	const size_t count = (1u << 20) + 1;
	char *text = room_for(count);
	memset(text, '#', count);
	refuses(text, count, "the file is too large; allowed: 1048576 bytes");
	free(text);
}

static void a_mapping_of_very_many_keys_is_refused(void **state)
{
	char *text = room_for(100 * 16);
	size_t length = 0;
	for (int i = 0; i < 100; i++)
		length += (size_t)sprintf(text + length, "key%d: 1\n", i);
	refuses(text, length, "scene.yaml:65: too many keys");
	free(text);
}

static void a_long_message_is_still_one_line(void **state)
{
	char *text = room_for(70000);
	size_t length = (size_t)sprintf(text, "scene: 1\nend_time: 1\n\"");
	for (int i = 0; i < 20000; i++)
		length += (size_t)sprintf(text + length, "%s", i % 2 ? "\\n" : "\xc3\xa9");
	length += (size_t)sprintf(text + length, "\": 1\n");
	refuses(text, length, "scene.yaml:3: ");
	free(text);
}

static void a_message_holds_no_control_character(void **state)
{
	const struct scene_setting setting = {"a\x1b[2J\x7f\t..b", "1"};
	struct scene *scene;
	assert_int_equal(load_text(minimal, &setting, 1, &scene), STATUS_INPUT);
	assert_says("--set a [2J  ..b: ");
}

static void poses_that_are_no_file_are_refused(void **state)
{
	struct scene *scene;
	char *text = edited(minimal, "{points: [[1, 2]], speed: 3}", "{file: pipe}");
	assert_int_equal(mkfifo(in_folder("pipe"), 0600), 0);
	assert_int_equal(load_text(text, NULL, 0, &scene), STATUS_INPUT); /* and does not wait for a writer */
	assert_says("\"pipe\": not a file; ");
	unlink(in_folder("pipe"));
	free(text);
	text = edited(minimal, "{points: [[1, 2]], speed: 3}", "{file: /dev/zero}");
	assert_int_equal(load_text(text, NULL, 0, &scene), STATUS_INPUT);
	assert_says("\"/dev/zero\": not a file; ");
	free(text);
}

static void memory_that_runs_out_is_told_at_every_allocation(void **state)
{
	const struct scene_setting settings[] = {{"cache.slots", "16"}, {"view.images", "3"},
						 {"view.camera", "{over: front_left, height: 3}"}};
	char *points = edited(example, "view:", "  - name: b\n    shape: {sphere: {radius: 1}}\n"
						"    path: {file: poses.csv}\nview:");
	char *text = edited(points, "coordinates: local", "coordinates: EPSG:4326");
	write_text("scene.yaml", text);
	write_text("poses.csv", "0,1,2\n1,2,3\n");
	for (int forever = 0; forever < 2; forever++)
		assert_memory_is_told(settings, 3, forever == 1);
	unlink(in_folder("poses.csv"));
	unlink(in_folder("scene.yaml"));
	free(points);
	free(text);
}

TEST_PROGRAM(hostile)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(deep_nesting_is_refused),
		cmocka_unit_test(aliases_are_refused_so_that_none_can_multiply),
		cmocka_unit_test(a_nul_byte_is_refused),
		cmocka_unit_test(what_is_not_utf8_is_refused),
		cmocka_unit_test(a_huge_file_is_refused),
		cmocka_unit_test(a_mapping_of_very_many_keys_is_refused),
		cmocka_unit_test(a_long_message_is_still_one_line),
		cmocka_unit_test(a_message_holds_no_control_character),
		cmocka_unit_test(poses_that_are_no_file_are_refused),
		cmocka_unit_test(memory_that_runs_out_is_told_at_every_allocation),
	};
	return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
