/*
 * The design's laws over whole drives, on a scene whose wheels cross tile corners: one terrain of
 * 513 x 513 posts 2 m apart, driven at 0.25 m (level -3), so that tiles of 256 cells are 64 m wide.
 */
#include "../long.h"
#include "../support.h"
#include "../support/program.h"

static const struct extent extent = {513, 513, 2, 256};

static const char scene_text[] =
	"scene: 1\n"
	"time_step: 0.05\n"
	"end_time: 55\n"
	"spacing: 0.25\n"
	"redistribute: {model: box}\n"
	"attributes: [dirt]\n"
	"objects:\n"
	/* Through the corners of four tiles at (64, 64), (128, 128) ... and back across the edges. */
	"  - {name: a, shape: {wheel: {radius: 0.9, width: 0.7}}, sink: 0.2,\n"
	"     path: {points: [[20, 20], [1000, 1000], [990, 40], [30, 990]], speed: 60}}\n"
	"  - {name: b, shape: {sphere: {radius: 2.5}}, sink: 0.5,\n"
	"     path: {points: [[64, 900], [64, 100], [960, 128], [128, 140]], speed: 40}}\n"
	"  - {name: c, shape: {box: {size: [3, 2, 1], belt: true}}, sink: 0.3,\n"
	"     path: {points: [[500, 20], [512, 1000]], speed: 20}}\n";

#define FACES "scm with faces" /* `b` and `c` slide */
#define SHEET "sheet" /* all bodies go deeper than it yields */
#define BENT "sheet on the GPU"

static bool is_sheet(const char *name)
{
	return strncmp(name, SHEET, strlen(SHEET)) == 0;
}

static bool slides(const char *name)
{
	return strcmp(name, "none") != 0 && strcmp(name, "box") != 0 && !is_sheet(name);
}

/* Enough where few tiles matter: `b` turns at (64, 100) and crosses the rut that `a` left near (102, 102). */
#define SHORT "end_time=24"

/* What a drive is told: its model, a soil if it has one, up to three things more or NULL, and whether all of the paths are driven. */
static const char *const *under(const char *name, const char *a, const char *b, const char *c, bool whole)
{
	static char text[48];
	static const char *told[11];
	const bool faces = strcmp(name, FACES) == 0, bent = strcmp(name, BENT) == 0;
	int count = 0;
	snprintf(text, sizeof text, "redistribute.model=%s", faces ? "scm" : bent ? SHEET : name);
	told[count++] = text;
	if (faces)
		told[count++] = "redistribute.faces=on";
	if (bent)
		told[count++] = "compute=gpu";
	if (is_sheet(name)) {
		told[count++] = "redistribute.yield=0.1";
		told[count++] = "redistribute.rut=0.7";
	}
	if (slides(name))
		told[count++] = "soil.name=dry_sand";
	if (slides(name) || bent) {
		told[count++] = "end_time=5"; /* every interval, and every bend, costs */
	} else if (!whole) {
		told[count++] = SHORT;
	}
	told[count++] = a;
	told[count++] = b;
	told[count++] = c;
	told[count] = NULL;
	return told;
}

static const char *const models[] = {"none", "box", "sumner", "slippage", "scm", FACES, SHEET, BENT};
#define MODELS 8

static const char *fresh_store(const char *name, struct extent shape)
{
	const char *path = support_path(name);
	support_store(path, shape, support_hills);
	return path;
}

static const char *scene_file(void)
{
	const char *path = support_path("scene.yaml");
	support_write(path, scene_text);
	return path;
}

/* Laws 1 and 4: verify compares shared posts and every level; law 3: the fewest slots against all. */
static void the_fewest_slots_leave_the_same_rows_as_all_resident(void **state)
{
	const char *scene = scene_file();
	for (int m = 0; m < MODELS; m++) {
		if (!by_turn((size_t)m, 2))
			continue;
		const char *few = fresh_store("few.furrow", extent), *all = fresh_store("all.furrow", extent);
		/* All of it where smoothing reads beyond what is pressed. */
		bool whole = strcmp(models[m], "box") == 0;
		char *json = support_drive(scene, few, under(models[m], "cache.slots=4", "cache.loaders=1", "cache.prefetch=0", whole));
		int most = whole ? 100 : 10;
		assert_true(support_figure(json, "\"cache\"", "touched") > most);
		assert_true(support_figure(json, "\"cache\"", "evictions") > most);
		assert_true(support_figure(json, "\"cache\"", "writebacks") > most);
		mem_free(json);
		json = support_drive(scene, all, under(models[m], "cache.slots=512", "cache.loaders=3", "cache.prefetch=2", whole));
		assert_int_equal(support_figure(json, "\"cache\"", "evictions"), 0);
		mem_free(json);
		struct store_check check = support_verify(few);
		assert_int_equal(check.finest, -3);
		/* `slippage` compacts nothing: it is but moved. */
		int64_t sum = check.offset_sum[-3 - TILE_LEVEL_MIN];
		assert_true(strcmp(models[m], "slippage") == 0 ? sum == 0 : sum < 0);
		support_verify(all);
		assert_true(support_hash(few) == support_hash(all));
	}
}

static void the_same_drive_twice_leaves_the_same_rows(void **state)
{
	const char *scene = scene_file();
	const char *one = fresh_store("one.furrow", extent), *two = fresh_store("two.furrow", extent);
	uint64_t before = support_hash(one);
	mem_free(support_drive(scene, one, (const char *[]){SHORT, NULL}));
	mem_free(support_drive(scene, two, (const char *[]){SHORT, NULL}));
	assert_true(support_hash(one) == support_hash(two));
	assert_true(support_hash(one) != before);
}

static void tiles_of_64_and_512_give_the_same_posts(void **state)
{
	const char *scene = scene_file();
	const uint32_t sizes[] = {64, 256, 512};
	struct post_rect rect = {0, 0, 1024, 4097}; /* the western quarter */
	for (int m = 0; m < MODELS; m++) {
		if (!by_turn((size_t)m, 2))
			continue;
		double *first = NULL;
		for (int i = 0; i < 3; i++) {
			/* The smallest with each model; of the others, each with every other. */
			if (i > 0 && !long_or_part((size_t)m, (size_t)i, 2))
				continue;
			struct extent shape = extent;
			shape.cells = sizes[i];
			const char *path = fresh_store("tiles.furrow", shape);
			mem_free(support_drive(scene, path, under(models[m], "cache.slots=64", NULL, NULL, false)));
			support_verify(path);
			double *quanta = support_quanta(path, -3, rect);
			size_t touched = 0;
			for (int64_t k = 0; k < (rect.x1 - rect.x0) * rect.y1; k++)
				touched += quanta[k] != 0;
			assert_true(touched > 10000);
			if (first == NULL) {
				first = quanta;
				continue;
			}
			assert_memory_equal(quanta, first, (size_t)((rect.x1 - rect.x0) * rect.y1) * sizeof *quanta);
			free(quanta);
		}
		free(first);
	}
}

/* Law 10, and with objects that meet within a step: who comes first is a matter of time alone. */
static void no_time_step_shows_in_the_rut(void **state)
{
	const char *scene = support_path("meet.yaml");
	support_write(scene, "scene: 1\nend_time: 8\nspacing: 0.25\nobjects:\n"
			     /* Two behind one another, and one across the way of both. */
			     "  - {name: rear, shape: {wheel: {radius: 0.9, width: 0.7}}, sink: 0.2,\n"
			     "     path: {points: [[40, 40], [400, 300]], speed: 20}}\n"
			     "  - {name: front, shape: {wheel: {radius: 0.9, width: 0.9}}, sink: 0.3,\n"
			     "     path: {points: [[42, 41.5], [402, 301.5]], speed: 20}}\n"
			     "  - {name: across, shape: {sphere: {radius: 1.5}}, sink: 0.4,\n"
			     "     path: {points: [[40, 47], [60, 47], [40, 44], [400, 302]], speed: 20}}\n");
	const char *const steps[] = {"time_step=0.1", "time_step=0.01", "time_step=0.37", "time_step=0.001"};
	for (int m = 1; m < MODELS; m++) {
		if (!by_turn((size_t)m, 2))
			continue;
		uint64_t first = 0;
		for (int i = 0; i < 4; i++) {
			/* Of the two steps between the longest and the shortest, each with every other model; a sheet has a step of a second instead. */
			const bool other = i == 1 + m % 2, sheet = is_sheet(models[m]);
			if (other && !sheet)
				continue;
			const char *path = fresh_store("step.furrow", extent);
			mem_free(support_drive(scene, path, under(models[m], other ? "time_step=1" : steps[i], NULL, NULL, true)));
			uint64_t hash = support_hash(path);
			if (i == 0)
				first = hash;
			if (hash != first)
				fail_msg("%s, %s: other rows", models[m], steps[i]);
		}
	}
}

static double summit(int64_t x, int64_t y)
{
	return support_hills(x, y) + 8000;
}

static double trench(int64_t x, int64_t y)
{
	return support_hills(x, y) - 11000;
}

static void a_summit_and_a_trench_are_as_exact_as_sea_level(void **state)
{
	const char *scene = scene_file();
	const support_height heights[] = {support_hills, summit, trench};
	struct post_rect rect = {0, 0, 2048, 2048};
	size_t bytes = (size_t)(rect.x1 * rect.y1) * sizeof(double);
	double *first = NULL;
	for (int i = 0; i < 3; i++) {
		const char *path = support_path("height.furrow");
		support_store(path, extent, heights[i]);
		mem_free(support_drive(scene, path, (const char *[]){"end_time=8", NULL}));
		double *quanta = support_quanta(path, -3, rect);
		if (first == NULL) {
			first = quanta;
			continue;
		}
		assert_memory_equal(quanta, first, bytes);
		free(quanta);
	}
	free(first);
}

/* 64 m posts, the same every 16 of them; 160,001 of them are 10,240 km. */
static double strip(int64_t x, int64_t y)
{
	return 50 + (double)((x % 16) * (x % 16) % 11) + 0.37 * (double)y;
}

static void ten_thousand_kilometres_out_the_bits_are_the_same(void **state)
{
	const struct extent far = {160001, 4, 64, 256};
	const double out = 156000.0 * 64; /* metres, a multiple of the strip's period */
	const char *path = support_path("far.furrow"), *scene = support_path("far.yaml");
	support_store(path, far, strip);
	char text[768];
	snprintf(text, sizeof text,
		 "scene: 1\ntime_step: 0.05\nend_time: 6\nspacing: 0.125\nredistribute: {model: box}\nobjects:\n"
		 "  - {name: near, shape: {wheel: {radius: 0.5, width: 0.4}}, sink: 0.001,\n"
		 "     path: {points: [[100.3, 40], [130.1, 71.7]], speed: 8}}\n"
		 "  - {name: far, shape: {wheel: {radius: 0.5, width: 0.4}}, sink: 0.001,\n"
		 "     path: {points: [[%.17g, 40], [%.17g, 71.7]], speed: 8}}\n",
		 /* the same places to the last bit the lattice keeps */
		 out + 100.3, out + 130.1);
	support_write(scene, text);
	mem_free(support_drive(scene, path, NULL));
	int level = -9;
	int64_t shift = (int64_t)(out / 0.125);
	struct post_rect near = {780, 300, 1070, 600}, away = {near.x0 + shift, near.y0, near.x1 + shift, near.y1};
	double *a = support_quanta(path, level, near), *b = support_quanta(path, level, away);
	size_t count = (size_t)((near.x1 - near.x0) * (near.y1 - near.y0)), touched = 0;
	for (size_t i = 0; i < count; i++)
		touched += a[i] != 0;
	assert_true(touched > 300);
	assert_memory_equal(a, b, count * sizeof *a);
	free(a);
	free(b);
}

TEST_PROGRAM(laws)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_fewest_slots_leave_the_same_rows_as_all_resident),
		cmocka_unit_test(the_same_drive_twice_leaves_the_same_rows),
		cmocka_unit_test(tiles_of_64_and_512_give_the_same_posts),
		cmocka_unit_test(no_time_step_shows_in_the_rut),
		cmocka_unit_test(a_summit_and_a_trench_are_as_exact_as_sea_level),
		cmocka_unit_test(ten_thousand_kilometres_out_the_bits_are_the_same),
	};
	return cmocka_run_group_tests_name("laws", tests, support_enter, support_leave);
}
