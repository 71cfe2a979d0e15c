/* map.png of whole drives: what is on it, that it costs the drive nothing, and that it comes however a drive ends. */
#include "../support.h"
#include "../support/program.h"
#include "../support/skip.h"

#include <png.h>
#include <sys/stat.h>

#include "render/render.h"

static const struct extent extent = {161, 161, 1, 32};

static double level_ground(int64_t x, int64_t y)
{
	return 100;
}

#define PATH "path: {points: [[40, 40], [90, 40], [90, 70]], speed: 20}"
#define SCENE_OF(slots, end, more, path) \
	"scene: 1\n" \
	"time_step: 0.1\n" \
	"end_time: " end "\n" \
	"spacing: 0.25\n" \
	"redistribute: {model: none}\n" more \
	"cache: {slots: " slots ", prefetch: 0, loaders: 0}\n" \
	"objects:\n" \
	"  - {name: ball, shape: {sphere: {radius: 3}}, sink: 0.5, " path "}\n"
#define SCENE(end, more, path) SCENE_OF("12", end, more, path)

struct drive_asked {
	const char *out;
	bool map, resume;
	int64_t steps;
};

static enum status drive(const char *scene_text, const char *store, struct drive_asked asked, struct drive_result *result)
{
	struct scene *scene;
	support_write(support_path("scene.yaml"), scene_text);
	must(scene_load(support_path("scene.yaml"), NULL, 0, &scene));
	struct drive_params params = {.scene = scene, .store = support_path(store), .directory = support_path(asked.out),
				    .map = asked.map, .resume = asked.resume, .steps = asked.steps};
	enum status status = drive_run(&params, result);
	scene_destroy(scene);
	if (status == STATUS_NO_GL)
		skip_since("no GL");
	return status;
}

static const char *fresh(const char *name)
{
	unlink(support_path(name));
	support_store(support_path(name), extent, level_ground);
	return name;
}

static const char *in_out(const char *out, const char *name)
{
	char path[32];
	snprintf(path, sizeof path, "%s/%s", out, name);
	return support_path(path);
}

struct picture {
	uint8_t *pixels; /* RGB, row 0 the highest */
	int width, height;
};

static struct picture read_picture(const char *path)
{
	png_image image = {.version = PNG_IMAGE_VERSION};
	assert_true(png_image_begin_read_from_file(&image, path));
	image.format = PNG_FORMAT_RGB;
	struct picture picture = {malloc(PNG_IMAGE_SIZE(image)), (int)image.width, (int)image.height};
	assert_true(png_image_finish_read(&image, NULL, picture.pixels, 0, NULL));
	return picture;
}

static bool is_rut(const uint8_t *p)
{
	return p[2] > p[0] + 60 && p[2] > p[1] + 40;
}

static bool is_way(const uint8_t *p) /* the first object's green over its rut, or its dot; its name is darker */
{
	return p[0] < 40 && p[1] > 130 && p[1] > p[2] + 20;
}

struct box {
	int left, top, right, bottom, count;
};

static struct box find(const struct picture *picture, bool (*is)(const uint8_t *), int high)
{
	struct box box = {picture->width, picture->height, -1, -1, 0};
	for (int y = 0; y < high; y++)
		for (int x = 0; x < picture->width; x++) {
			if (!is(picture->pixels + 3 * (y * picture->width + x)))
				continue;
			box.left = x < box.left ? x : box.left;
			box.right = x > box.right ? x : box.right;
			box.top = y < box.top ? y : box.top;
			box.bottom = y > box.bottom ? y : box.bottom;
			box.count++;
		}
	return box;
}

/* The row at the frame's lower edge: the last one that is dark for the most part. Below it is the legend, which has such colours too. */
static int frame_bottom(const struct picture *picture)
{
	int y = picture->height, dark = 0;
	while (y > 0 && dark < picture->width * 2 / 5) {
		y--;
		dark = 0;
		for (int x = 0; x < picture->width; x++)
			dark += picture->pixels[3 * (y * picture->width + x)] < 100;
	}
	assert_true(y > picture->height / 3);
	return y - 4;
}

static const uint8_t *pixel(const struct picture *picture, double x, double y)
{
	return picture->pixels + 3 * ((int)y * picture->width + (int)x);
}

static void ruts_and_the_way_are_where_they_were_driven(void **state)
{
	struct drive_result result;
	must(drive(SCENE("5", "", PATH), fresh("a.furrow"), (struct drive_asked){.out = "a", .map = true}, &result));
	assert_true(result.map);
	mem_free(result.json);
	struct picture picture = read_picture(in_out("a", "map.png"));
	int high = frame_bottom(&picture);
	struct box ruts = find(&picture, is_rut, high), way = find(&picture, is_way, high);
	/* A rut of 2 x sqrt(3^2 - 2.5^2) = 3.3 m: 53.3 x 33.3 m, and its bend goes from the south-west to the north-east. */
	double scale = (ruts.right - ruts.left + 1) / 53.3, half = 3.3 / 2 * scale;
	assert_true(scale > 3);
	assert_true(fabs(ruts.bottom - ruts.top + 1 - 33.3 * scale) < 0.8 * scale);
	assert_true(is_rut(pixel(&picture, ruts.left + 20 * scale, ruts.bottom - 0.3 * half)));
	assert_true(is_rut(pixel(&picture, ruts.right - 0.4 * half, ruts.top + 10 * scale)));
	assert_false(is_rut(pixel(&picture, ruts.left + half, ruts.top + 10 * scale)));
	/* The way is within it, from its first point to its last: a straight line of green along both legs. */
	assert_true(fabs(way.left - (ruts.left + half)) < 1.5 * scale && fabs(way.right - (ruts.right - half)) < 1.5 * scale);
	assert_true(fabs(way.top - (ruts.top + half)) < 1.5 * scale && fabs(way.bottom - (ruts.bottom - half)) < 1.5 * scale);
	assert_true(way.count > 60 * scale);
	for (double t = 4; t < 50; t += 0.5) {
		double x = ruts.left + half + t * scale, y = ruts.bottom + 1 - half;
		bool found = false;
		for (int i = -2; i <= 2; i++)
			found |= is_way(pixel(&picture, x, y + i)) || pixel(&picture, x, y + i)[1] > 200; /* the edge of the name's letters */
		assert_true(found);
	}
	free(picture.pixels);
}

/* What run.json counts is the same, and so are the store's rows. */
static void a_map_costs_the_drive_nothing(void **state)
{
	struct drive_result with, without;
	/* No tile is evicted: whether one is read again depends on whether its write has ended. */
	const char *text = SCENE_OF("512", "5", "", PATH);
	must(drive(text, fresh("b.furrow"), (struct drive_asked){.out = "b", .map = true}, &with));
	uint64_t hash = support_hash(support_path("b.furrow"));
	must(drive(text, fresh("c.furrow"), (struct drive_asked){.out = "c"}, &without));
	assert_true(!without.map && access(in_out("c", "map.png"), F_OK) != 0);
	static const char *const tables[] = {"\"base\":", "\"offset\":"};
	for (size_t i = 0; i < 2; i++) {
		const char *a = strstr(strstr(with.json, "\"statements\""), tables[i]);
		const char *b = strstr(strstr(without.json, "\"statements\""), tables[i]);
		assert_int_equal(support_figure(a, tables[i], "read"), support_figure(b, tables[i], "read"));
	}
	assert_true(hash == support_hash(support_path("c.furrow")));
	mem_free(with.json);
	mem_free(without.json);
}

static size_t read_file(const char *path, char *bytes, size_t room)
{
	FILE *file = fopen(path, "rb");
	assert_non_null(file);
	size_t size = fread(bytes, 1, room, file);
	fclose(file);
	assert_true(size > 0 && size < room);
	return size;
}

static void assert_same_file(const char *a, const char *b)
{
	enum { ROOM = 4 << 20 };
	char *bytes[2] = {malloc(ROOM), malloc(ROOM)};
	size_t size = read_file(a, bytes[0], ROOM);
	assert_int_equal(read_file(b, bytes[1], ROOM), size);
	assert_memory_equal(bytes[0], bytes[1], size);
	free(bytes[0]);
	free(bytes[1]);
}

static void a_resumed_drive_maps_all_of_it(void **state)
{
	struct drive_result result;
	const char *text = SCENE("4", "", "path: {points: [[40, 40], [90, 40], [90, 70]], speed: 40, loop: true}");
	must(drive(text, fresh("d.furrow"), (struct drive_asked){.out = "d", .map = true}, &result));
	mem_free(result.json);
	must(drive(text, fresh("d.furrow"), (struct drive_asked){.out = "e", .map = true, .steps = 13}, &result));
	mem_free(result.json);
	must(drive(text, "d.furrow", (struct drive_asked){.out = "e", .map = true, .resume = true}, &result));
	mem_free(result.json);
	assert_same_file(in_out("d", "map.png"), in_out("e", "map.png"));
	/* Nothing is left to do: a map that is there stays, one that is not is made. */
	support_write(in_out("e", "map.png"), "as it was");
	must(drive(text, "d.furrow", (struct drive_asked){.out = "e", .map = true, .resume = true}, &result));
	assert_false(result.map);
	mem_free(result.json);
	char bytes[16];
	assert_int_equal(read_file(in_out("e", "map.png"), bytes, sizeof bytes), 9);
	unlink(in_out("e", "map.png"));
	must(drive(text, "d.furrow", (struct drive_asked){.out = "e", .map = true, .resume = true}, &result));
	assert_true(result.map);
	mem_free(result.json);
	assert_same_file(in_out("d", "map.png"), in_out("e", "map.png"));
}

static void a_drive_that_fails_has_its_map(void **state)
{
	struct drive_result result;
	const char *text = SCENE("20", "", "path: {points: [[40, 40], [190, 40]], speed: 20}");
	support_write(support_path("old"), "");
	enum status status = drive(text, fresh("f.furrow"), (struct drive_asked){.out = "f", .map = true}, &result);
	assert_int_equal(status, STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "ball: no ground under it"));
	assert_true(result.map && strcmp(result.ended, "failed") == 0);
	mem_free(result.json);
	struct picture picture = read_picture(in_out("f", "map.png"));
	struct box ruts = find(&picture, is_rut, frame_bottom(&picture));
	assert_true(ruts.count > 1000);
	free(picture.pixels);
	/* Where the first step failed there is nothing to show. */
	status = drive(SCENE("20", "", "path: {points: [[500000, 4000000], [500010, 4000000]], speed: 20}"), fresh("f.furrow"),
		       (struct drive_asked){.out = "nothing", .map = true}, &result);
	assert_int_equal(status, STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "ball: no ground under it"));
	assert_true(!result.map && access(in_out("nothing", "map.png"), F_OK) != 0);
	mem_free(result.json);
}

static void a_map_that_cannot_be_written_is_the_failure_if_nothing_else_was(void **state)
{
	struct drive_result result;
	if (access("/dev/full", W_OK) != 0)
		skip_since(SKIP_ELSEWHERE "no /dev/full");
	mkdir(support_path("g"), 0777);
	assert_int_equal(symlink("/dev/full", in_out("g", "map.png.part")), 0);
	enum status status = drive(SCENE("3", "", PATH), fresh("g.furrow"), (struct drive_asked){.out = "g", .map = true}, &result);
	assert_int_equal(status, STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "map.png"));
	assert_non_null(strstr(failure_message(), "No space left"));
	assert_true(!result.map && strcmp(result.ended, "complete") == 0);
	assert_non_null(strstr(result.json, "\"complete\""));
	mem_free(result.json);
	assert_true(access(in_out("g", "map.png"), F_OK) != 0 && access(in_out("g", "map.png.part"), F_OK) != 0);
	assert_int_equal(access(in_out("g", "run.json"), F_OK), 0);
	support_verify(support_path("g.furrow"));
	/* What failed before is what is told. */
	assert_int_equal(symlink("/dev/full", in_out("g", "map.png.part")), 0);
	status = drive(SCENE("20", "", "path: {points: [[40, 40], [190, 40]], speed: 20}"), fresh("g.furrow"),
		       (struct drive_asked){.out = "g", .map = true}, &result);
	assert_int_equal(status, STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "ball: no ground under it"));
	assert_false(result.map);
	mem_free(result.json);
}

static double holed_ground(int64_t x, int64_t y)
{
	return x > 60 && x < 100 && y > 30 && y < 50 ? (double)NAN : 100 + (double)(x % 7);
}

/* Over holes, off the terrain, standing still, at the edge, on the smallest terrain. */
static void odd_drives_have_maps(void **state)
{
	static const struct {
		struct extent extent;
		const char *path;
	} cases[] = {
		{{161, 161, 1, 32}, "path: {points: [[40, 40], [130, 40], [900, 900]], speed: 100}"},
		{{161, 161, 1, 32}, "path: {points: [[80, 80]], speed: 1}"},
		{{161, 161, 1, 32}, "path: {points: [[0, 0], [0, 160]], speed: 100}"},
		{{161, 161, 1, 32}, "path: {points: [[-500, -500], [-300, -500]], speed: 100}"},
		{{2, 2, 8, 32}, "path: {points: [[1, 1], [7, 7]], speed: 4}"},
		{{2, 200, 8, 32}, "path: {points: [[4, 10], [4, 1500]], speed: 1000}"},
	};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		struct drive_result result;
		char text[1024];
		snprintf(text, sizeof text, SCENE("2", "outside: skip\n", "%s"), cases[i].path);
		unlink(support_path("h.furrow"));
		support_store(support_path("h.furrow"), cases[i].extent, holed_ground);
		must(drive(text, "h.furrow", (struct drive_asked){.out = "h", .map = true}, &result));
		assert_true(result.map);
		mem_free(result.json);
		struct picture picture = read_picture(in_out("h", "map.png"));
		assert_true(picture.width <= 1500 && picture.height <= 1500 && picture.width > 100 && picture.height > 60);
		free(picture.pixels);
	}
}

static void a_vehicle_s_ruts_fill_the_map_and_its_way_is_between_them(void **state)
{
	char text[2048];
	snprintf(text, sizeof text,
		 "scene: 1\ntime_step: 0.002\nend_time: 2\nspacing: 0.25\nsoil: {name: dry_sand}\nredistribute: {model: scm}\nvehicles:\n"
		 "  - {name: car, model: %s/vehicles/offroad.xml, start: {at: [100, 60], yaw: 30}, soil: [wheel_*],\n"
		 "     driver: {path: {points: [[100, 60], [117, 70]], speed: 3}, steer: [steer_*], drive: [drive_*]}}\n",
		 getenv("SCENES"));
	struct drive_result result;
	const enum status status = drive(text, fresh("car.furrow"), (struct drive_asked){.out = "car", .map = true}, &result);
	if (status == STATUS_INPUT && strstr(failure_message(), "no MuJoCo") != NULL)
		skip_since("this build has no MuJoCo");
	must(status);
	assert_non_null(strstr(result.json, "\"way\""));
	mem_free(result.json);
	struct picture picture = read_picture(in_out("car", "map.png"));
	const int high = frame_bottom(&picture);
	const struct box ruts = find(&picture, is_rut, high), way = find(&picture, is_way, high);
	/* 3 m of 160: of the whole terrain they would be a fiftieth. */
	assert_true(ruts.right - ruts.left > picture.width / 4 && ruts.right - ruts.left < picture.width * 9 / 10);
	assert_true(way.count > 50 && way.left > ruts.left && way.right < ruts.right && way.top > ruts.top && way.bottom < ruts.bottom);
	free(picture.pixels);
}

TEST_PROGRAM(map)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(ruts_and_the_way_are_where_they_were_driven),
		cmocka_unit_test(a_map_costs_the_drive_nothing),
		cmocka_unit_test(a_resumed_drive_maps_all_of_it),
		cmocka_unit_test(a_drive_that_fails_has_its_map),
		cmocka_unit_test(a_map_that_cannot_be_written_is_the_failure_if_nothing_else_was),
		cmocka_unit_test(odd_drives_have_maps),
		cmocka_unit_test(a_vehicle_s_ruts_fill_the_map_and_its_way_is_between_them),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
