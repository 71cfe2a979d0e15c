/* Paths that follow others, and objects that are given once for many places. */
#include "fixture.h"
#include "../support/program.h"

#include <math.h>

#define BEGIN "scene: 1\nend_time: 1\nobjects:\n"
#define SHAPE "shape: {sphere: {radius: 1}}"

static struct scene *loaded(const char *text)
{
	struct scene *scene;
	if (load_text(text, NULL, 0, &scene) != STATUS_OK)
		fail_msg("%s", failure_message());
	return scene;
}

static void refused(const char *text, const char *says)
{
	struct scene *scene;
	assert_int_equal(load_text(text, NULL, 0, &scene), STATUS_INPUT);
	assert_says(says);
}

static void chains_of_leaders_add_up(void **state)
{
	/* Followers may stand before their leaders. */
	struct scene *scene = loaded(BEGIN
		"  - {name: last, " SHAPE ", path: {relative_to: middle, offset: [-1, 0.5], delay: 2}}\n"
		"  - {name: middle, " SHAPE ", path: {relative_to: first, offset: [-4, 0.25]}}\n"
		"  - {name: first, " SHAPE ", path: {points: [[1, 2], [3, 4]], speed: 5, smooth: true, rotate: 90, offset: [7, 8], delay: 3}}\n"
		"  - {name: beside, " SHAPE ", path: {relative_to: middle}}\n");
	static const double beside[4][2] = {{-5, 0.75}, {-4, 0.25}, {0, 0}, {-4, 0.25}}, delay[4] = {5, 3, 3, 3};
	for (size_t i = 0; i < 4; i++) {
		const struct scene_path *path = &scene->objects[i].path;
		assert_true(path->count == 2 && path->points[1].y == 4 && path->speed == 5 && path->smooth);
		assert_true(path->offset[0] == 7 && path->offset[1] == 8 && fabs(path->rotate - M_PI / 2) < 1e-15);
		assert_true(path->beside[0] == beside[i][0] && path->beside[1] == beside[i][1] && path->delay == delay[i]);
	}
	scene_destroy(scene);
}

enum { MOST = 4096 }; /* objects of a scene */

/* As long as a scene may be. It takes as long as as many objects apart; it took minutes. */
static void a_chain_of_all_objects_is_followed(void **state)
{
	static char text[600000];
	size_t used = (size_t)snprintf(text, sizeof text, BEGIN "  - {name: o0, " SHAPE ", path: {points: [[1, 2], [3, 4]], speed: 5}}\n");
	for (int i = 1; i < MOST; i++)
		used += (size_t)snprintf(text + used, sizeof text - used, "  - {name: o%d, " SHAPE ", path: {relative_to: o%d, offset: [-1, 0.5], delay: 0.25}}\n", i, i - 1);
	assert_true(used < sizeof text - 1);
	struct scene *scene = loaded(text);
	assert_int_equal(scene->object_count, MOST);
	for (int i = 0; i < MOST; i++) {
		const struct scene_path *path = &scene->objects[i].path;
		assert_true(path->beside[0] == -i && path->beside[1] == 0.5 * i && path->delay == 0.25 * i && path->points[1].x == 3);
	}
	scene_destroy(scene);
}

static void paths_that_cannot_be_followed_are_refused(void **state)
{
	static const struct {
		const char *objects, *says;
	} cases[] = {
		{"  - {name: a, " SHAPE ", path: {relative_to: b}}\n", ":4: objects[0].path.relative_to: \"b\" is no object, and there is no other; add it to objects"},
		{"  - {name: a, " SHAPE ", path: {relative_to: b}}\n  - {name: c, " SHAPE ", path: {points: [[1, 1]], speed: 1}}\n", "\"b\" is no object; allowed: c"},
		{"  - {name: a, " SHAPE ", path: {relative_to: a}}\n", "objects[0].path.relative_to: leads back to a itself; allowed: a chain that ends"},
		{"  - {name: a, " SHAPE ", path: {relative_to: b}}\n  - {name: b, " SHAPE ", path: {relative_to: a}}\n", "leads back to a itself"},
		{"  - {name: a, " SHAPE ", path: {relative_to: b, speed: 3}}\n", "objects[0].path.speed: does not go with relative_to"},
		{"  - {name: a, " SHAPE ", path: {relative_to: b, rotate: 3}}\n", "objects[0].path.rotate: does not go with relative_to"},
		{"  - {name: a, " SHAPE ", path: {relative_to: b, points: [[1, 1]]}}\n", "objects[0].path: names both points and relative_to"},
		{"  - {name: a, " SHAPE ", path: {points: [[1, 1]], speed: 1, line: 2}}\n", "objects[0].path.line: does not go with points; allowed with: a file"},
		{"  - {name: a, " SHAPE ", path: {points: [[1, 1]], speed: 1, delay: -1}}\n", "objects[0].path.delay: "},
		{"  - {name: a, " SHAPE ", path: {file: none.gpx}}\n", "\"none.gpx\": there is no such file; name a GPX or GeoJSON file"},
	};
	char text[600];
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		snprintf(text, sizeof text, "%s%s", BEGIN, cases[i].objects);
		refused(text, cases[i].says);
	}
}

/* --- templates --- */

#define CAR "  template:\n" \
	    "    - {name: body, " SHAPE ", path: {points: [[0, 0], [40, 0]], speed: 2, offset: [1, 1]}}\n" \
	    "    - {name: left, " SHAPE ", path: {relative_to: body, offset: [1, 0.8]}}\n"

static void a_template_is_written_out(void **state)
{
	struct scene *scene = loaded(BEGIN CAR "  at: [[0, 5], [10, 20, 90], [30, 0]]\n  every: 4\n");
	static const char *const names[] = {"body-1", "left-1", "body-2", "left-2", "body-3", "left-3"};
	static const double offsets[3][2] = {{1, 6}, {11, 21}, {31, 1}};
	assert_int_equal(scene->object_count, 6);
	for (size_t i = 0; i < 6; i++) {
		const struct scene_path *path = &scene->objects[i].path;
		assert_string_equal(scene->objects[i].name, names[i]);
		assert_true(path->offset[0] == offsets[i / 2][0] && path->offset[1] == offsets[i / 2][1]);
		assert_true(path->delay == 4 * (double)(i / 2));
		assert_true(fabs(path->rotate - (i / 2 == 1 ? M_PI / 2 : 0)) < 1e-15);
		assert_true(path->beside[1] == (i % 2 ? 0.8 : 0));
	}
	scene_destroy(scene);
}

static void a_grid_goes_row_by_row(void **state)
{
	struct scene *scene = loaded("scene: 1\nend_time: 1\nobjects:\n"
				     "  - {name: alone, " SHAPE ", path: {points: [[1, 1]], speed: 1}}\n"
				     "  - template: {name: w, " SHAPE ", path: {points: [[0, 0]], speed: 1}}\n"
				     "    at: {rows: 2, columns: 3, step: [5, 7], from: [100, 200]}\n"
				     "  - {name: after, " SHAPE ", path: {points: [[1, 1]], speed: 1}}\n");
	assert_int_equal(scene->object_count, 8);
	assert_string_equal(scene->objects[0].name, "alone");
	assert_string_equal(scene->objects[6].name, "w-6");
	assert_string_equal(scene->objects[7].name, "after");
	for (size_t i = 0; i < 6; i++) {
		const double *offset = scene->objects[1 + i].path.offset;
		assert_true(offset[0] == 100 + 5 * (double)(i % 3) && offset[1] == 200 + 7 * (double)(i / 3));
	}
	scene_destroy(scene);
}

/* A convoy: copies that follow an object outside the template are moved in the axes of its way. */
static void a_template_may_follow_another_object(void **state)
{
	struct scene *scene = loaded(BEGIN "  - {name: lead, " SHAPE ", path: {points: [[0, 0], [9, 0]], speed: 1}}\n"
				     "  - {template: {name: truck, " SHAPE ", path: {relative_to: lead, offset: [-8, 0]}}, at: [[0, 0], [-8, 0], [-16, 0.5]]}\n");
	assert_int_equal(scene->object_count, 4);
	assert_true(scene->objects[1].path.beside[0] == -8 && scene->objects[3].path.beside[0] == -24 && scene->objects[3].path.beside[1] == 0.5);
	scene_destroy(scene);
}

static void settings_reach_the_template(void **state)
{
	const struct scene_setting settings[] = {{"objects.template.path.speed", "9"}, {"objects.every", "1"}};
	struct scene *scene;
	assert_int_equal(load_text("scene: 1\nend_time: 1\nobjects:\n  template: {name: w, " SHAPE ", path: {points: [[0, 0]], speed: 1}}\n  at: [[1, 2], [3, 4]]\n",
				   settings, 2, &scene), STATUS_OK);
	assert_true(scene->objects[0].path.speed == 9 && scene->objects[1].path.speed == 9 && scene->objects[1].path.delay == 1);
	scene_destroy(scene);
}

static void a_wrong_template_is_refused(void **state)
{
	static const struct {
		const char *objects, *says;
	} cases[] = {
		{"  template: {name: w, " SHAPE ", path: {points: [[0, 0]], speed: 1}}\n", ":3: objects[0]: says no places of a template; needed: at:"},
		{"  template: {name: w, " SHAPE "}\n  at: [[1]]\n", ":5: objects[0].at[0]: is no place; allowed: [east, north] in m"},
		{"  template: {name: w, " SHAPE "}\n  at: [[1, x]]\n", ":5: objects[0].at[0]: is no place"},
		{"  template: {name: w, " SHAPE "}\n  at: {rows: 2}\n", ":5: objects[0].at: is no grid; allowed: {rows: 1 or more"},
		{"  template: {name: w, " SHAPE "}\n  at: {rows: 0, step: [1, 1]}\n", "objects[0].at.rows: is no grid"},
		{"  template: {name: w, " SHAPE "}\n  at: {row: 2, step: [1, 1]}\n", "objects[0].at.row: unknown key; allowed: rows, columns, step, from"},
		{"  template: {name: w, " SHAPE "}\n  at: {rows: 4000, columns: 4000, step: [1, 1]}\n", ":3: objects[0]: makes too many objects; allowed: 4096 in all"},
		{"  template: {name: w, " SHAPE "}\n  at: [[1, 2]]\n  every: -1\n", "objects[0].every: is no time between copies"},
		{"  template: {name: w, " SHAPE "}\n  at: [[1, 2]]\n  name: w\n", ":6: objects[0].name: does not go beside template"},
		{"  template: wheel\n  at: [[1, 2]]\n", "objects[0].template: is no object"},
		{"  template: {name: w, " SHAPE ", path: {points: [[0, 0]], speed: 1}, sinks: 3}\n  at: [[1, 2], [2, 3]]\n", ":4: objects[0].sinks: unknown key"},
		{"  template: {name: w, " SHAPE ", path: {points: [[0, 0]], speed: 1, offset: [a, 1]}}\n  at: [[1, 2], [2, 3]]\n", "objects[0].path.offset[0]: \"a\" is not a number"},
	};
	char text[600];
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		snprintf(text, sizeof text, "%s%s", BEGIN, cases[i].objects);
		refused(text, cases[i].says);
	}
}

static void memory_that_is_out_is_told(void **state)
{
	write_text("scene.yaml", BEGIN CAR "  at: [[0, 5], [10, 20, 90]]\n  every: 4\n");
	assert_memory_is_told(NULL, 0, false);
	assert_memory_is_told(NULL, 0, true);
	unlink(in_folder("scene.yaml"));
}

TEST_PROGRAM(paths)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(chains_of_leaders_add_up),
		cmocka_unit_test(a_chain_of_all_objects_is_followed),
		cmocka_unit_test(paths_that_cannot_be_followed_are_refused),
		cmocka_unit_test(a_template_is_written_out),
		cmocka_unit_test(a_grid_goes_row_by_row),
		cmocka_unit_test(a_template_may_follow_another_object),
		cmocka_unit_test(settings_reach_the_template),
		cmocka_unit_test(a_wrong_template_is_refused),
		cmocka_unit_test(memory_that_is_out_is_told),
	};
	return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
