/* Poses files: what they become, and what is refused with its line. */
#include <math.h>

#include "fixture.h"
#include "../support/program.h"

static const char with_poses[] = "scene: 1\n"
				 "end_time: 1\n"
				 "objects:\n"
				 "  - name: a\n"
				 "    shape: {box: {size: [1, 2, 3]}}\n"
				 "    path: {file: poses.csv}\n";

static enum status load(const char *poses, size_t length, struct scene **scene)
{
	write_bytes("poses.csv", poses, length);
	enum status status = load_text(with_poses, NULL, 0, scene);
	unlink(in_folder("poses.csv"));
	return status;
}

static void three_columns_are_a_path_in_time(void **state)
{
	static const char *const texts[] = {
		"t,x,y\n0,1,2\n0.5,3,4\n",	"0,1,2\n0.5,3,4",
		"t, x, y\r\n0, 1, 2\r\n\r\n0.5, 3, 4\r\n", "\xef\xbb\xbft,x,y\n0,1e0,+2\n0.5,3.0,4\n\n",
	};
	char first_hash[33] = "";
	for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
		struct scene *scene;
		if (load(texts[i], strlen(texts[i]), &scene) != STATUS_OK)
			fail_msg("%s", failure_message());
		const struct scene_path *path = &scene->objects[0].path;
		assert_int_equal(path->count, 2);
		assert_true(path->timed && !path->has_z && !path->has_attitude && !path->loop);
		assert_true(path->points[0].t == 0 && path->points[0].x == 1 && path->points[0].y == 2);
		assert_true(path->points[1].t == 0.5 && path->points[1].x == 3 && path->points[1].y == 4);
		if (i == 0)
			strcpy(first_hash, scene->hash);
		assert_string_equal(scene->hash, first_hash);
		scene_destroy(scene);
	}
}

static void attitude_is_degrees_in_the_file_and_radians_after(void **state)
{
	static const char text[] = "t,x,y,z,yaw,pitch,roll\n0,1,2,-3,90,-45,180\n";
	struct scene *scene;
	assert_int_equal(load(text, strlen(text), &scene), STATUS_OK);
	const struct scene_path *path = &scene->objects[0].path;
	assert_true(path->has_z && path->has_attitude);
	assert_true(path->points[0].z == -3);
	assert_true(fabs(path->points[0].yaw - M_PI / 2) < 1e-15);
	assert_true(fabs(path->points[0].pitch + M_PI / 4) < 1e-15);
	assert_true(fabs(path->points[0].roll - M_PI) < 1e-15);
	scene_destroy(scene);
}

/* One object with a shape and a path, and an attitude. */
static enum status load_turned(const char *shape, const char *path, const char *attitude, struct scene **scene)
{
	char text[600];
	snprintf(text, sizeof text, "scene: 1\nend_time: 1\nobjects:\n  - {name: a, shape: {%s}, path: {%s}, attitude: %s}\n", shape, path, attitude);
	return load_text(text, NULL, 0, scene);
}

static void an_object_is_turned_against_its_way(void **state)
{
	static const char line[] = "points: [[1, 2], [5, 2]], speed: 1", box[] = "box: {size: [1, 2, 3]}", wheel[] = "wheel: {radius: 1, width: 1}";
	char hashes[4][33];
	struct scene *scene;
	assert_int_equal(load_turned(box, line, "[90, -45, 30]", &scene), STATUS_OK);
	const double *attitude = scene->objects[0].path.attitude;
	assert_true(!scene->objects[0].path.has_attitude && scene_is_turned(&scene->objects[0]));
	assert_true(fabs(attitude[0] - M_PI / 2) < 1e-15 && fabs(attitude[1] + M_PI / 4) < 1e-15 && fabs(attitude[2] - M_PI / 6) < 1e-15);
	assert_true(fabs(scene_slip_way(&scene->objects[0], 3, 4, 1) - 5) < 1e-15);
	strcpy(hashes[0], scene->hash);
	scene_destroy(scene);
	/* A wheel's pitch turns it about its axle, which is nothing. */
	assert_int_equal(load_turned(wheel, line, "[0, 30, 0]", &scene), STATUS_OK);
	assert_true(!scene_is_turned(&scene->objects[0]) && fabs(scene_slip_way(&scene->objects[0], 3, 4, M_PI / 2) - 4) < 1e-15);
	strcpy(hashes[1], scene->hash);
	scene_destroy(scene);
	assert_int_equal(load_turned(wheel, line, "[0, 0, 0]", &scene), STATUS_OK);
	assert_string_equal(scene->hash, hashes[1]);
	scene_destroy(scene);
	assert_int_equal(load_turned(wheel, line, "[20, 0, 0]", &scene), STATUS_OK);
	assert_true(scene_slips(scene));
	assert_string_not_equal(scene->hash, hashes[1]);
	scene_destroy(scene);
	assert_int_equal(load_turned(box, line, "[90, -45, 31]", &scene), STATUS_OK);
	assert_string_not_equal(scene->hash, hashes[0]);
	scene_destroy(scene);
	write_bytes("poses.csv", "0,1,2,3,4,5,6\n", 14);
	assert_int_equal(load_turned(box, "file: poses.csv", "[90, 0, 0]", &scene), STATUS_INPUT);
	unlink(in_folder("poses.csv"));
	assert_says("objects[0].attitude: its poses say yaw, pitch and roll already; allowed with: points");
	assert_int_equal(load_turned(box, line, "[400, 0, 0]", &scene), STATUS_INPUT);
	assert_says("attitude[0]: 400 is out of range; allowed: -360 to 360");
	assert_int_equal(load_turned(box, line, "[4, 0]", &scene), STATUS_INPUT);
}

static void z_alone_is_allowed(void **state)
{
	struct scene *scene;
	assert_int_equal(load("0,1,2,3\n", 8, &scene), STATUS_OK);
	assert_true(scene->objects[0].path.has_z && !scene->objects[0].path.has_attitude);
	scene_destroy(scene);
}

static void each_mistake_has_its_line(void **state)
{
	static const struct {
		const char *text, *says;
	} cases[] = {
		{"", "poses.csv: no pose; allowed: at least one row"},
		{"t,x,y\n", "poses.csv: no pose"},
		{"t,x,y\n0,1\n", "poses.csv:2: not 3, 4 or 7 columns"},
		{"0,1,2,3,4\n", "poses.csv:1: not 3, 4 or 7 columns"},
		{"0,1,2,3,4,5,6,7\n", "poses.csv:1: not 3, 4 or 7 columns"},
		{"t,x,y\n0,1,2\n1,2,3,4\n", "poses.csv:3: 4 columns; allowed: 3"},
		{"t,y,x\n0,1,2\n", "poses.csv:1: not the names of the columns"},
		{"time,x,y\n0,1,2\n", "poses.csv:1: not the names of the columns"},
		{"0,1,2\n\nt,x,y\n", "poses.csv:3: t: \"t\" is not a number"},
		{"0,1,2\n1,a,2\n", "poses.csv:2: x: \"a\" is not a number"},
		{"0,1,2\n1,,2\n", "poses.csv:2: x: \"\" is not a number"},
		{"0,1,nan\n", "poses.csv:1: y: \"nan\" is not a number"},
		{"0,1,0x1\n", "poses.csv:1: y: \"0x1\" is not a number"},
		{"0,1,1e999\n", "poses.csv:1: y: 1e999 is out of range"},
		{"-1,1,2\n", "poses.csv:1: t: -1 is out of range; allowed: 0 to"},
		{"0,1,2\n1,1,2\n1,5,2\n", "poses.csv:3: t: 1 does not grow; allowed: above 1"},
		{"0,1,2\n2,1,2\n1,5,2\n", "poses.csv:3: t: 1 does not grow; allowed: above 2"},
		{"0,1,2,3,1e9,0,0\n", "poses.csv:1: yaw: 1e9 is out of range"},
	};
	struct scene *scene;
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		assert_int_equal(load(cases[i].text, strlen(cases[i].text), &scene), STATUS_INPUT);
		assert_null(scene);
		assert_says(cases[i].says);
	}
	assert_int_equal(load("0,1,2\n1,\0,2\n", 12, &scene), STATUS_INPUT);
	assert_says("poses.csv:2: a NUL byte");
}

static void many_poses_all_arrive(void **state)
{
	const size_t count = 20000;
	char *text = room_for(count * 32);
	size_t length = 0;
	for (size_t i = 0; i < count; i++)
		length += (size_t)sprintf(text + length, "%zu,%zu.5,-%zu\n", i, i, i);
	struct scene *scene;
	assert_int_equal(load(text, length, &scene), STATUS_OK);
	assert_int_equal(scene->objects[0].path.count, count);
	assert_true(scene->objects[0].path.points[count - 1].y == -(double)(count - 1));
	scene_destroy(scene);
	free(text);
}

TEST_PROGRAM(poses)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(three_columns_are_a_path_in_time),
		cmocka_unit_test(attitude_is_degrees_in_the_file_and_radians_after),
		cmocka_unit_test(an_object_is_turned_against_its_way),
		cmocka_unit_test(z_alone_is_allowed),
		cmocka_unit_test(each_mistake_has_its_line),
		cmocka_unit_test(many_poses_all_arrive),
	};
	return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
