/*
 * Law 7: an effect visits only where it has something to do, and what is left out would have changed nothing. Each scene is
 * driven twice, with all windows of all sweeps computed and as ever: rows, forces and figures are the same.
 */
#include "../support.h"

static const char *const models[] = {"none", "box", "sumner", "slippage", "scm"};
#define MODELS 5

static bool slides(int m)
{
	return m > 1;
}

/* --- ground --- */

static double flat(int64_t x, int64_t y)
{
	return 100 + (double)(x * y % 7) / 1024;
}

static double smooth(int64_t x, int64_t y)
{
	return 100 + 3 * sin((double)x * 0.11) * cos((double)y * 0.13);
}

static double cliff(int64_t x, int64_t y)
{
	return smooth(x, y) + (x > 40 + y % 3 ? 40 : 0);
}

static double holed(int64_t x, int64_t y)
{
	return (x / 5 + y / 7) % 4 == 0 ? (double)NAN : smooth(x, y);
}

/* --- drives --- */

/* A body that hops along: its lowest point is `low` below the ground at worst, `high` above at best. */
struct hops {
	support_height height;
	double spacing, x0, y0, vx, vy, reach, low, high, per, end;
	bool turns; /* it pitches too */
};

static void write_poses(const char *name, const struct hops *hops)
{
	FILE *file = fopen(support_path(name), "w");
	assert_non_null(file);
	for (int i = 0; i * 0.05 <= hops->end; i++) {
		double t = i * 0.05, there = t < hops->end / 2 ? t : hops->end - t; /* and back */
		double x = hops->x0 + hops->vx * there, y = hops->y0 + hops->vy * there;
		double ground = hops->height((int64_t)lrint(x / hops->spacing), (int64_t)lrint(y / hops->spacing));
		double up = fabs(sin(hops->per * t)) * (hops->low + hops->high) - hops->low;
		ground = isnan(ground) ? 100 : ground;
		fprintf(file, "%.17g,%.17g,%.17g,%.17g,%g,%g,0\n", t, x, y, ground + hops->reach + up, 20 * t, hops->turns ? 30 * sin(t) : 0);
	}
	assert_int_equal(fclose(file), 0);
}

/* One drive; `out`: its folder. NULL: skipped, without GL. */
static char *drive(const char *scene_path, const char *store, const char *out, bool everywhere, bool resume, int64_t steps)
{
	struct scene *scene;
	must(scene_load(scene_path, NULL, 0, &scene));
	struct api_params params = {.scene = scene, .store = store, .directory = support_path(out), .everywhere = everywhere,
				    .resume = resume, .steps = steps};
	struct api_result result;
	enum status status = api_drive(&params, &result);
	scene_destroy(scene);
	if (status == STATUS_NO_GL)
		skip();
	must(status);
	return result.json;
}

static char *text_of(const char *folder, const char *name)
{
	char path[160];
	snprintf(path, sizeof path, "%s/%s", support_path(folder), name);
	FILE *file = fopen(path, "r");
	if (file == NULL)
		return NULL;
	char *text = calloc(1, 1 << 22);
	size_t length = fread(text, 1, (1 << 22) - 1, file);
	assert_true(length < (1 << 22) - 1);
	fclose(file);
	return text;
}

static long long where(const char *json, const char *effect, const char *name)
{
	char quoted[64];
	const char *from = strstr(json, "\"where\"");
	snprintf(quoted, sizeof quoted, "\"%s\"", effect);
	assert_non_null(from);
	return support_figure(from, quoted, name);
}

static void same_forces(const char *a, const char *b)
{
	char *one = text_of(a, "objects.csv"), *other = text_of(b, "objects.csv");
	assert_int_equal(one == NULL, other == NULL);
	if (one != NULL) {
		assert_true(strlen(one) > 1000);
		assert_string_equal(one, other);
	}
	free(one);
	free(other);
}

static void same_figures(const char *a, const char *b)
{
	static const char *const names[] = {"removed", "raised", "net", "compacted"};
	for (int i = 0; i < 4; i++)
		assert_true(support_figure(a, "\"quanta\"", names[i]) == support_figure(b, "\"quanta\"", names[i]));
	const char *objects = strstr(a, "\"objects\""), *end = strstr(objects, "}\n\t}"), *others = strstr(b, "\"objects\"");
	if (end == NULL || strncmp(objects, others, (size_t)(end - objects)) != 0)
		fail_msg("objects: %.400s, not %.400s", others, objects);
	assert_true(support_figure(a, "\"refused_posts\"", "refused_posts") == support_figure(b, "\"refused_posts\"", "refused_posts"));
}

struct least {
	double visited, most; /* shares of the windows due that are computed: more than, less than */
};

/* Both ways over stores made alike. */
static void the_same_either_way(struct extent extent, support_height height, const char *scene, const char *first_scene,
				struct least least)
{
	const char *all = support_path("all.furrow"), *few = support_path("few.furrow");
	const char *const stores[2] = {all, few};
	const char *const outs[2] = {"out-all", "out-few"};
	char *jsons[2];
	for (int i = 0; i < 2; i++) {
		support_store(stores[i], extent, height);
		if (first_scene != NULL)
			mem_free(drive(first_scene, stores[i], "out-first", true, false, 0));
		jsons[i] = drive(scene, stores[i], outs[i], i == 0, false, 0);
	}
	support_verify(few);
	assert_true(support_hash(all) == support_hash(few));
	same_forces(outs[0], outs[1]);
	same_figures(jsons[0], jsons[1]);
	/* The first is of the windows. */
	long long due = support_figure(jsons[0], "\"where\"", "possible"), visited = support_figure(jsons[1], "\"where\"", "visited");
	assert_int_equal(support_figure(jsons[0], "\"where\"", "visited"), due);
	assert_int_equal(support_figure(jsons[1], "\"where\"", "possible"), due);
	if (!((double)visited > least.visited * (double)due && (double)visited < least.most * (double)due))
		fail_msg("%lld of %lld windows, not from %g to %g of them", visited, due, least.visited, least.most);
	mem_free(jsons[0]);
	mem_free(jsons[1]);
}

/* A scene of a model; forces where it has them. */
static const char *scene_of(const char *name, int m, const char *rest)
{
	char text[2048];
	snprintf(text, sizeof text, "scene: 1\ntime_step: 0.1\n%sredistribute: {model: %s}\n%s%s%s",
		 slides(m) ? "soil: {name: sand, bekker_kc: 990, bekker_kphi: 1528430, bekker_n: 1.1, cohesion: 0, friction_angle: 28, "
			     "janosi_shear: 0.02, elastic_stiffness: 4e7, damping: 3e4, unit_weight: 16000, repose: 28}\n" : "",
		 models[m], m == 4 ? "output: {forces: 20}\n" : "", m == 1 || m == 4 ? "attributes: [dirt]\n" : "", rest);
	const char *path = support_path(name);
	support_write(path, text);
	return path;
}

/* --- laws --- */

static const char hopping[] =
	"end_time: 4\nspacing: 0.25\noutside: skip\nobjects:\n"
	"  - {name: ball, shape: {sphere: {radius: 1.2}}, path: {file: ball.csv}}\n"
	"  - {name: lugs, shape: {wheel: {radius: 0.9, width: 0.7, lugs: 9, lug_height: 0.1, lug_thickness: 0.3}}, path: {file: wheel.csv}}\n"
	"  - {name: block, shape: {box: {size: [3, 2, 1]}}, path: {file: block.csv}}\n"
	"  - {name: parked, shape: {sphere: {radius: 2}}, sink: 0.5, path: {points: [[60, 58], [61, 58]], speed: 5}}\n";

static void write_hops(support_height height)
{
	write_poses("ball.csv", &(struct hops){height, 2, 30, 30, 12, 11, 1.2, 0.4, 3, 1.7, 4, false});
	write_poses("wheel.csv", &(struct hops){height, 2, 90, 40, -9, 8, 1.0, 0.2, 2, 2.3, 4, false});
	write_poses("block.csv", &(struct hops){height, 2, 40, 90, 11, -10, 0.9, 0.1, 4, 1.1, 4, true});
}

static const struct extent extent = {129, 129, 2, 32};

/* Over hills and their own ruts, over cliffs and holes, under every model. */
static void what_hops_leaves_the_same_rows(void **state)
{
	static const support_height heights[] = {support_hills, flat, cliff, holed};
	for (int h = 0; h < 4; h++)
		for (int m = 0; m < MODELS; m++) {
			write_hops(heights[h]);
			/* Where soil slides a tile that was touched is looked at, and the next to it then is touched. */
			the_same_either_way(extent, heights[h], scene_of("hops.yaml", m, hopping), NULL,
					    (struct least){0.05, slides(m) ? 1.01 : 0.8});
		}
}

/* What passes above it works on ground that has not come to rest, too. */
static void loose_ground_slides_under_what_flies(void **state)
{
	static const char flying[] = "end_time: 1.5\nobjects:\n  - {name: fly, shape: {sphere: {radius: 6}}, path: {file: fly.csv}}\n";
	char soil[256];
	write_poses("fly.csv", &(struct hops){support_hills, 2, 30, 61, 80, 30, 6, -9, 10, 1, 1.5, false});
	for (int m = 2; m < MODELS - 1; m++) {
		snprintf(soil, sizeof soil, "scene: 1\ntime_step: 0.1\nsoil: {name: sand, cohesion: 0, friction_angle: 10, unit_weight: 16000}\n"
			 "redistribute: {model: %s, undisturbed: slides}\n%s", models[m], flying);
		support_write(support_path("loose.yaml"), soil);
		the_same_either_way(extent, support_hills, support_path("loose.yaml"), NULL, (struct least){0.5, 1.01});
	}
}

/* Rims that earlier drives have piled up, or this one does: above the base, and a body that flies between the two. */
static void what_flies_into_a_rim_presses_it(void **state)
{
	static const char digs[] = "end_time: 4\nspacing: 0.25\nobjects:\n"
				   "  - {name: dig, shape: {box: {size: [4, 4, 4]}}, sink: 1.6, path: {points: [[60, 60], [66, 60]], speed: 8}}\n";
	static const char flies[] = "end_time: 4\nspacing: 0.25\nobjects:\n"
				    "  - {name: fly, shape: {box: {size: [0.5, 0.5, 0.5]}}, path: {file: fly.csv}}\n";
	write_poses("fly.csv", &(struct hops){flat, 2, 40, 61, 20, 0.3, 0.25, -0.05, 0.06, 1, 4, false});
	const char *first = scene_of("first.yaml", 3, digs);
	for (int m = 0; m < MODELS; m++) {
		the_same_either_way(extent, flat, scene_of("fly.yaml", m, flies), first, (struct least){0.1, 1});
		struct store_check check = support_verify(support_path("few.furrow"));
		assert_int_equal(check.finest, -3);
	}
	/* Its own: it digs, rises just above the ground beside, and comes through what it heaped. */
	for (int m = 2; m < MODELS; m++) {
		FILE *file = fopen(support_path("fly.csv"), "w");
		assert_non_null(file);
		fprintf(file, "0,40,61,100.3\n1,60,61,100.3\n1.2,60,61,98.3\n1.4,63,61,98.3\n1.6,63,61,104\n2,56,61,104\n2.2,56,61,100.3\n4,70,61,100.3\n");
		assert_int_equal(fclose(file), 0);
		the_same_either_way(extent, flat, scene_of("own.yaml", m, flies), NULL, (struct least){0.3, 1.01});
	}
}

/* 64 m posts, as in laws.c: 156,000 of them are 9,984 km. */
static double strip(int64_t x, int64_t y)
{
	return 50 + (double)((x % 16) * (x % 16) % 11) + 0.37 * (double)y;
}

static void ten_thousand_kilometres_out_too(void **state)
{
	static const struct extent far = {160001, 4, 64, 256};
	double out = 156000.0 * 64;
	char text[512];
	snprintf(text, sizeof text, "end_time: 4\nspacing: 0.125\nobjects:\n"
		 "  - {name: ball, shape: {sphere: {radius: 0.6}}, path: {file: far.csv}}\n");
	write_poses("far.csv", &(struct hops){strip, 64, out + 100.3, 64, 6, 0.5, 0.6, 8, 12, 3.1, 4, false});
	for (int m = 0; m < MODELS; m++)
		the_same_either_way(far, strip, scene_of("far.yaml", m, text), NULL, (struct least){0.1, slides(m) ? 1.01 : 0.95});
}

/* --- over soil that was touched, and beside it --- */

static const struct extent lawn = {65, 65, 0.5, 64};

/* A foot: down 3 cm, 0.4 s there, up and on; `back`: it turns half-way and treads between its own prints. */
static void write_steps(const char *name, double x, double y, double stride, double lift, bool back)
{
	FILE *file = fopen(support_path(name), "w");
	assert_non_null(file);
	for (int i = 0; i <= 80; i++) {
		int step = i / 8;
		double swing = i % 8 < 4 ? 0 : (i % 8 - 3) / 5.0, gone = step + swing;
		double along = back && gone > 5 ? 10.4 - gone : gone;
		fprintf(file, "%.17g,%.17g,%.17g,%.17g,0,%.17g,0\n", i * 0.1, x + stride * along, y,
			100.02 + lift * sin(M_PI * swing), 20 * sin(2 * M_PI * swing));
	}
	assert_int_equal(fclose(file), 0);
}

static const char walking[] =
	"end_time: 8\nspacing: 0.03125\n%sobjects:\n"
	"  - {name: left, shape: {box: {size: [0.3, 0.12, 0.1]}}, path: {file: left.csv}}\n"
	"  - {name: right, shape: {box: {size: [0.25, 0.1, 0.1]}}, path: {file: right.csv}}\n";

static const char *walk(int m, const char *more)
{
	char text[1024];
	snprintf(text, sizeof text, walking, more);
	return scene_of("walk.yaml", m, text);
}

/* A foot swings over its own print, beside the other's, and over ground where none was. */
static void what_walks_is_aloft_between_its_prints(void **state)
{
	static const struct {
		double lift, apart, most;
		bool back;
		const char *more;
	} walks[] = {
		{0.2, 0.6, 0.97, false, ""}, {0.2, 0.6, 0.97, false, "cache: {slots: 4}\n"}, {0.07, 0.2, 1.01, false, ""},
		{0.15, 0.25, 1.01, true, ""},
	};
	for (int m = 2; m < MODELS; m++)
		for (size_t i = 0; i < sizeof walks / sizeof *walks; i++) {
			write_steps("left.csv", 10.03, 12.01, 0.9, walks[i].lift, walks[i].back);
			write_steps("right.csv", 9.55, 12.01 + walks[i].apart, 0.9, walks[i].lift, walks[i].back);
			const char *scene = walk(m, walks[i].more);
			the_same_either_way(lawn, flat, scene, NULL, (struct least){0.2, walks[i].most});
			/* Again, where it walked: all of those tiles count as touched. */
			if (i == 0)
				the_same_either_way(lawn, flat, scene, scene, (struct least){0.2, 1.01});
		}
}

/* Up, and down again a little beside: through rims that are above the ground as it was, and over soil that still slides. */
static void what_bounces_over_its_own_rims_leaves_the_same(void **state)
{
	static const char rest[] =
		"end_time: 6\nspacing: 0.0625\nobjects:\n"
		"  - {name: ball, shape: {sphere: {radius: 0.4}}, path: {file: ball.csv}}\n"
		"  - {name: slab, shape: {box: {size: [14, 1, 0.2]}}, path: {file: slab.csv}}\n";
	static const support_height heights[] = {flat, holed};
	for (int h = 0; h < 2; h++)
		for (int m = 2; m < MODELS; m++) {
			write_poses("ball.csv", &(struct hops){heights[h], 0.5, 10, 10, 0.7, 0.3, 0.4, 0.15, 0.5, 3.3, 6, false});
			/* Several windows. */
			write_poses("slab.csv", &(struct hops){heights[h], 0.5, 16, 14, 0.2, 1.9, 0.1, 0.1, 0.7, 1.3, 6, false});
			char text[1024];
			snprintf(text, sizeof text, "%s%s", rest, h == 1 ? "outside: skip\n" : "");
			the_same_either_way(lawn, heights[h], scene_of("bounce.yaml", m, text), NULL, (struct least){0.2, 1.01});
		}
}

/* --- to the post, and to less than a millimetre --- */

static int64_t spike_x, spike_y;

static double spike(int64_t x, int64_t y)
{
	return x == spike_x && y == spike_y ? 110 : 100;
}

/* How much of the ground one station presses, and how many windows it computes. */
static long long pressed_on_the_way(const char *shape, double x, double y, double from, double z, double pitch, const char *spacing,
				    long long *windows)
{
	char text[512];
	const char *store = support_path("one.furrow");
	support_store(store, (struct extent){65, 65, 1, 64}, spike);
	FILE *file = fopen(support_path("one.csv"), "w");
	assert_non_null(file);
	fprintf(file, "0,%.17g,%.17g,%.17g,0,%.17g,0\n1,%.17g,%.17g,%.17g,0,%.17g,0\n", x, y, from, pitch, x, y, z, pitch);
	assert_int_equal(fclose(file), 0);
	snprintf(text, sizeof text, "end_time: 1\nspacing: %s\nobjects:\n  - {name: a, shape: %s, path: {file: one.csv}}\n", spacing, shape);
	char *json = drive(scene_of("one.yaml", 0, text), store, "out", false, false, 0);
	long long removed = support_figure(json, "\"quanta\"", "removed");
	*windows = where(json, "displace", "visited");
	mem_free(json);
	return removed;
}

static long long pressed_by(const char *shape, double x, double y, double z, double pitch, const char *spacing, long long *windows)
{
	return pressed_on_the_way(shape, x, y, z, z, pitch, spacing, windows);
}

/* The one post it touches, at each of its corners; the ground under its middle is 10 m lower. */
static void a_single_post_at_the_rim_counts(void **state)
{
	long long windows;
	for (int i = 0; i < 4; i++) {
		spike_x = 30 + (i % 2 == 0 ? -4 : 4);
		spike_y = 30 + (i / 2 == 0 ? -4 : 4);
		assert_true(pressed_by("{box: {size: [8, 8, 2]}}", 30, 30, 110, 0, "1", &windows) > 0);
		/* To a tenth of a millimetre. */
		assert_true(pressed_by("{box: {size: [8, 8, 2]}}", 30, 30, 111 - 1e-4, 0, "1", &windows) > 0);
		assert_int_equal(pressed_by("{box: {size: [8, 8, 2]}}", 30, 30, 111 + 1e-4, 0, "1", &windows), 0);
		assert_int_equal(windows, 0);
		/* From far above, onto it: the station before, a post away, is clear of it. */
		assert_true(pressed_on_the_way("{box: {size: [8, 8, 2]}}", 30, 30, 140.5, 110.6, 0, "1", &windows) > 0);
		/* What is between two posts of the source, the higher of which lies without. */
		double in = i % 2 == 0 ? -1 : 1;
		assert_true(pressed_by("{box: {size: [8, 8, 2]}}", 30 - in * 0.8, 30, 102, 0, "0.125", &windows) > 0);
		spike_x += (int64_t)(i % 2 == 0 ? -2 : 2);
		assert_int_equal(pressed_by("{box: {size: [8, 8, 2]}}", 30, 30, 110, 0, "1", &windows), 0);
		assert_int_equal(windows, 0);
	}
}

/* A body of several windows, of which the post is in one. */
static void a_post_counts_in_whichever_window(void **state)
{
	long long windows;
	for (int i = 0; i < 4; i++) {
		spike_x = 30 + (i % 2 == 0 ? -4 : 4);
		spike_y = 30 + (i / 2 == 0 ? -4 : 4);
		assert_true(pressed_by("{box: {size: [8.5, 8.5, 2]}}", 30, 30, 110, 0, "0.03125", &windows) > 0);
		assert_true(windows >= 4);
	}
	spike_x = 25; /* nearer than 25.75 m, and 0 m higher there */
	assert_int_equal(pressed_by("{box: {size: [8.5, 8.5, 2]}}", 30, 30, 111.5, 0, "0.03125", &windows), 0);
	assert_int_equal(windows, 0);
}

/* Every shape by its lowest point: a tenth of a millimetre into the ground it presses; as much above it is not looked at. */
static void the_lowest_point_decides(void **state)
{
	static const struct {
		const char *shape;
		double reach, pitch;
	} shapes[] = {
		{"{sphere: {radius: 3}}", 3, 0},
		{"{wheel: {radius: 3, width: 4}}", 3, 0},
		{"{box: {size: [8, 8, 2]}}", 1, 0},
		{"{box: {size: [8, 8, 2]}}", 3.2, 36.869897645844021}, /* its edge over a post, with the x below */
		/* On the corners of a bar: 3.1 m down, 0.5 m to either side of it. */
		{"{wheel: {radius: 3, width: 4, lugs: 4, lug_height: 0.1, lug_thickness: 1}}", 3.1, 0},
	};
	spike_x = -1;
	for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
		long long windows;
		assert_true(pressed_by(shapes[i].shape, shapes[i].pitch > 0 ? 30.1 : 30, 30, 100 + shapes[i].reach - 1e-4, shapes[i].pitch, "0.0625", &windows) > 0);
		assert_int_equal(windows, 1);
		assert_int_equal(pressed_by(shapes[i].shape, shapes[i].pitch > 0 ? 30.1 : 30, 30, 100 + shapes[i].reach + 1e-4, shapes[i].pitch, "0.0625", &windows), 0);
		assert_int_equal(windows, i == 4 ? 1 : 0);
	}
	/* Turned by 45 degrees of its way a bar's corner is hypot(3.1, 0.5) = 3.14006 m down. */
	long long windows;
	assert_int_equal(pressed_by(shapes[4].shape, 30, 30, 100 + 3.1402, 0, "0.0625", &windows), 0);
	assert_int_equal(windows, 0);
}

/* A bar turned until a corner points down. */
static void a_bar_of_a_wheel_reaches_farther_than_its_height(void **state)
{
	double turn = atan(0.5 / 3.1), way = 3 * turn;
	char rest[512];
	snprintf(rest, sizeof rest, "end_time: 1\nspacing: 0.0625\nobjects:\n"
		 "  - {name: a, shape: {wheel: {radius: 3, width: 4, lugs: 4, lug_height: 0.1, lug_thickness: 1}}, path: {file: bar.csv}}\n");
	FILE *file = fopen(support_path("bar.csv"), "w");
	assert_non_null(file);
	fprintf(file, "0,30,30,%.17g,0,0,0\n1,%.17g,30,%.17g,0,0,0\n", 100 + 3.13, 30 + 2 * way, 100 + 3.13);
	assert_int_equal(fclose(file), 0);
	spike_x = -1;
	the_same_either_way((struct extent){65, 65, 1, 64}, spike, scene_of("bar.yaml", 0, rest), NULL, (struct least){0.5, 1.1});
	assert_true(support_verify(support_path("few.furrow")).offset_sum[-4 - TILE_LEVEL_MIN] < 0);
}

/* --- what is resumed --- */

static void what_is_resumed_in_the_air_goes_on_the_same(void **state)
{
	static const int64_t stops[] = {7, 17, 18, 25, 33};
	static const int ms[] = {1, 3, 4};
	for (int i = 0; i < 3; i++) {
		write_hops(smooth);
		const char *scene = scene_of("hops.yaml", ms[i], hopping);
		const char *whole = support_path("all.furrow"), *parts = support_path("few.furrow");
		support_store(whole, extent, smooth);
		support_store(parts, extent, smooth);
		char *json = drive(scene, whole, "out-all", true, false, 0), *resumed = NULL;
		for (int k = 0; k < 5; k++)
			mem_free(drive(scene, parts, "out-few", false, k > 0, stops[k]));
		resumed = drive(scene, parts, "out-few", false, true, 0);
		assert_true(support_hash(whole) == support_hash(parts));
		same_forces("out-all", "out-few");
		same_figures(json, resumed);
		mem_free(json);
		mem_free(resumed);
	}
}

static void what_walks_is_resumed_over_its_prints(void **state)
{
	static const int64_t stops[] = {6, 13, 27, 41, 55};
	const char *whole = support_path("all.furrow"), *parts = support_path("few.furrow");
	write_steps("left.csv", 10.03, 12.01, 0.9, 0.15, true);
	write_steps("right.csv", 9.55, 12.21, 0.9, 0.15, true);
	for (int m = 2; m < MODELS; m++) {
		const char *scene = walk(m, "cache: {slots: 4}\n");
		support_store(whole, lawn, flat);
		support_store(parts, lawn, flat);
		char *json = drive(scene, whole, "out-all", true, false, 0);
		for (int k = 0; k < 5; k++)
			mem_free(drive(scene, parts, "out-few", false, k > 0, stops[k]));
		char *resumed = drive(scene, parts, "out-few", false, true, 0);
		assert_true(support_hash(whole) == support_hash(parts));
		same_forces("out-all", "out-few");
		same_figures(json, resumed);
		mem_free(json);
		mem_free(resumed);
	}
}

/* It pressed the ground, left the world, and has come back to hang above other ground: nothing acts on it, and a resumed drive
 * knows that. */
static void what_parks_in_the_air_is_told_so_when_resumed(void **state)
{
	static const char rest[] = "end_time: 4\nspacing: 0.5\noutside: skip\nobjects:\n"
				   "  - {name: back, shape: {sphere: {radius: 1}}, path: {file: back.csv}}\n";
	const char *all = support_path("all.furrow"), *few = support_path("few.furrow"), *scene = scene_of("back.yaml", 4, rest);
	support_write(support_path("back.csv"), "0,8,100,100.7\n0.5,-9,100,100.7\n1,-9,180,104\n1.5,8,180,104\n");
	support_store(all, extent, flat);
	support_store(few, extent, flat);
	char *json = drive(scene, all, "out-all", true, false, 0), *csv = text_of("out-all", "objects.csv");
	mem_free(drive(scene, few, "out-few", false, false, 20));
	char *resumed = drive(scene, few, "out-few", false, true, 0);
	assert_non_null(strstr(csv, "\n3,back,8,180,104,0,0,0,0,0,0,0,0,0,"));
	same_forces("out-all", "out-few");
	same_figures(json, resumed);
	assert_true(support_hash(all) == support_hash(few));
	mem_free(json);
	mem_free(resumed);
	free(csv);
}

/* --- nothing else --- */

static void what_never_comes_down_costs_nothing(void **state)
{
	static const char rest[] = "end_time: 4\nspacing: 0.25\nobjects:\n"
				   "  - {name: fly, shape: {sphere: {radius: 1}}, path: {file: fly.csv}}\n%s";
	static const char view[] = "view: {size: [64, 48], camera: {overhead: {over: fly, height: 60}}, effects: [texture], images: 1}\n";
	for (int m = 0; m < MODELS; m++) {
		char text[512];
		const char *windows = slides(m) ? models[m] : "displace";
		long long programs[2];
		for (int down = 0; down < 2; down++) {
			write_poses("fly.csv", &(struct hops){smooth, 2, 40, 61, 20, 0.3, 1, down ? 0.3 : -1, 2, 1, 4, false});
			snprintf(text, sizeof text, rest, view);
			const char *store = support_path("fly.furrow"), *scene = scene_of("fly.yaml", m, text);
			support_store(store, extent, smooth);
			uint64_t before = support_hash(store);
			char *json = drive(scene, store, "out", false, false, 0);
			programs[down] = support_figure(json, "\"programs\"", "programs");
			assert_int_equal(support_hash(store) != before, down);
			assert_int_equal(support_figure(json, "\"passes\"", "displace") > 0, down);
			assert_int_equal(support_figure(json, "\"passes\"", "redistribute") > 0, down && m > 0);
			assert_int_equal(support_figure(json, "\"passes\"", "attributes") > 0, down && (m == 1 || m == 4));
			assert_int_equal(support_figure(json, "\"passes\"", "pyramid") > 0, down);
			assert_int_equal(support_figure(json, "\"io\"", "tiles_written") > 0, down);
			/* An untouched tile has no planes, and none of its draws reads one. */
			assert_int_equal(where(json, "slots", "visited") > 0, down);
			assert_int_equal(where(json, "draw", "visited") > 0, down);
			assert_int_equal(where(json, "pyramid", "visited") > 0, down);
			assert_true(where(json, "draw", "possible") > where(json, "draw", "visited"));
			assert_true(where(json, "slots", "possible") > where(json, "slots", "visited"));
			assert_true(where(json, "pyramid", "possible") > where(json, "pyramid", "visited"));
			assert_true(where(json, windows, "possible") > 100);
			assert_int_equal(where(json, windows, "visited") > 0, down);
			if (m == 1)
				assert_int_equal(where(json, "box", "visited") > 0, down);
			if (m == 1 || m == 4)
				assert_int_equal(where(json, "dirt", "visited"), where(json, windows, "visited"));
			if (slides(m))
				assert_int_equal(where(json, "spread", "visited"), where(json, windows, "visited"));
			if (slides(m))
				assert_int_equal(where(json, m == 2 ? "shed" : "slide", "visited"), support_figure(json, "\"slide\"", "visited"));
			mem_free(json);
		}
		assert_int_equal(programs[0], programs[1]); /* made beforehand: where it comes down only the drive shows */
	}
}

/* Only what the scene calls for is named. */
static void no_other_effect_is_told(void **state)
{
	static const char rest[] = "end_time: 1\nobjects:\n"
				   "  - {name: a, shape: {sphere: {radius: 1.5}}, sink: 0.3, path: {points: [[20, 20], [30, 30]], speed: 10}}\n";
	static const char *const told[] = {"displace", "box", "sumner", "slippage", "scm", "spread", "shed", "slide", "dirt", "pyramid",
					   "draw", "slots"};
	static const bool wanted[MODELS][12] = {
		{true, false, false, false, false, false, false, false, false, false, false, true},
		{true, true, false, false, false, false, false, false, true, false, false, true},
		{false, false, true, false, false, true, true, false, false, false, false, true},
		{false, false, false, true, false, true, false, true, false, false, false, true},
		{false, false, false, false, true, true, false, true, true, false, false, true},
	};
	for (int m = 0; m < MODELS; m++) {
		const char *store = support_path("told.furrow");
		support_store(store, extent, smooth);
		char *json = drive(scene_of("told.yaml", m, rest), store, "out", false, false, 0), *from = strstr(json, "\"where\"");
		strstr(from, "}\n\t}")[0] = '\0';
		for (int i = 0; i < 12; i++) {
			char quoted[32];
			snprintf(quoted, sizeof quoted, "\"%s\"", told[i]);
			assert_int_equal(strstr(from, quoted) != NULL, wanted[m][i]);
		}
		mem_free(json);
	}
}

static void settled_soil_is_not_relaxed(void **state)
{
	for (int m = 2; m < MODELS; m++) {
		long long visited[2];
		for (int i = 0; i < 2; i++) {
			char rest[256];
			snprintf(rest, sizeof rest, "end_time: %d\nspacing: 0.5\nobjects:\n"
				 "  - {name: a, shape: {sphere: {radius: 3}}, sink: 1, path: {points: [[50, 50], [60, 52]], speed: 10}}\n",
				 30 << i);
			const char *store = support_path("settled.furrow");
			support_store(store, extent, flat);
			char *json = drive(scene_of("settled.yaml", m, rest), store, "out", false, false, 0);
			visited[i] = where(json, m == 2 ? "shed" : "slide", "visited");
			assert_int_equal(support_figure(json, "\"slide\"", "awake"), 0);
			mem_free(json);
		}
		assert_true(visited[0] > 0 && visited[0] == visited[1]);
	}
}

/* A tolerance ends slides sooner, loses nothing, and is no tolerance at 0. */
static void what_is_tolerated_sleeps_sooner(void **state)
{
	static const char *const tolerances[] = {"0", "0.001", "0.01"};
	for (int m = 3; m < MODELS; m++) {
		long long visited[3];
		uint64_t hashes[3];
		for (int i = 0; i < 3; i++) {
			char rest[512];
			snprintf(rest, sizeof rest, "scene: 1\ntime_step: 0.1\nend_time: 10\nspacing: 0.125\nsoil: {name: dry_sand, cohesion: 0}\n"
				 "redistribute: {model: %s, tolerance: %s}\nobjects:\n"
				 "  - {name: a, shape: {sphere: {radius: 1.5}}, sink: 0.5, path: {points: [[50, 50], [70, 58]], speed: 5}}\n",
				 models[m], tolerances[i]);
			const char *store = support_path("tolerated.furrow"), *scene = support_path("tolerated.yaml");
			support_write(scene, rest);
			support_store(store, extent, flat);
			char *json = drive(scene, store, "out", false, false, 0);
			visited[i] = where(json, "slide", "visited");
			hashes[i] = support_hash(store);
			assert_true(support_figure(json, "\"quanta\"", "net") == -support_figure(json, "\"quanta\"", "compacted"));
			support_verify(store);
			mem_free(json);
		}
		assert_true(visited[0] > visited[1] && visited[1] > visited[2]);
		assert_true(hashes[0] != hashes[1] && hashes[1] != hashes[2]);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_hops_leaves_the_same_rows),
		cmocka_unit_test(loose_ground_slides_under_what_flies),
		cmocka_unit_test(what_flies_into_a_rim_presses_it),
		cmocka_unit_test(ten_thousand_kilometres_out_too),
		cmocka_unit_test(what_walks_is_aloft_between_its_prints),
		cmocka_unit_test(what_bounces_over_its_own_rims_leaves_the_same),
		cmocka_unit_test(a_single_post_at_the_rim_counts),
		cmocka_unit_test(a_post_counts_in_whichever_window),
		cmocka_unit_test(the_lowest_point_decides),
		cmocka_unit_test(a_bar_of_a_wheel_reaches_farther_than_its_height),
		cmocka_unit_test(what_is_resumed_in_the_air_goes_on_the_same),
		cmocka_unit_test(what_walks_is_resumed_over_its_prints),
		cmocka_unit_test(what_parks_in_the_air_is_told_so_when_resumed),
		cmocka_unit_test(what_never_comes_down_costs_nothing),
		cmocka_unit_test(no_other_effect_is_told),
		cmocka_unit_test(settled_soil_is_not_relaxed),
		cmocka_unit_test(what_is_tolerated_sleeps_sooner),
	};
	return cmocka_run_group_tests_name("where", tests, support_enter, support_leave);
}
