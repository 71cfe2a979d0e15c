/*
 * For tests that drive each scene twice: once with all windows of all contacts computed, and once as ever. What is left out the
 * second time must change nothing: rows, forces and figures are the same.
 */
#ifndef FURROW_TESTS_WHERE_H
#define FURROW_TESTS_WHERE_H

#include "../support.h"
#include "../support/skip.h"

static const char *const models[] = {"none", "box", "sumner", "slippage", "scm", "sheet"};
#define MODELS 5
#define SHEET 5 /* soil does not slide in it; some tests have it beside the others */

static inline bool slides(int m)
{
	return m > 1 && m != SHEET;
}

/* --- ground --- */

static inline double flat(int64_t x, int64_t y)
{
	return 100 + (double)(x * y % 7) / 1024;
}

static inline double smooth(int64_t x, int64_t y)
{
	return 100 + 3 * sin((double)x * 0.11) * cos((double)y * 0.13);
}

static inline double holed(int64_t x, int64_t y)
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

static inline void write_poses(const char *name, const struct hops *hops)
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
static inline char *drive(const char *scene_path, const char *store, const char *out, bool everywhere, bool resume, int64_t steps)
{
	struct scene *scene;
	must(scene_load(scene_path, NULL, 0, &scene));
	struct drive_params params = {.scene = scene, .store = store, .directory = support_path(out), .everywhere = everywhere,
				    .resume = resume, .steps = steps};
	struct drive_result result;
	enum status status = drive_run(&params, &result);
	scene_destroy(scene);
	if (status == STATUS_NO_GL)
		skip_since("no GL");
	must(status);
	return result.json;
}

static inline char *text_of(const char *folder, const char *name)
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

static inline long long where(const char *json, const char *effect, const char *name)
{
	char quoted[64];
	const char *from = strstr(json, "\"where\"");
	snprintf(quoted, sizeof quoted, "\"%s\"", effect);
	assert_non_null(from);
	return support_figure(from, quoted, name);
}

static inline void same_forces(const char *a, const char *b)
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

static inline void same_figures(const char *a, const char *b)
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
static inline void the_same_either_way(struct extent extent, support_height height, const char *scene, const char *first_scene,
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
	const double most = support_counts_repeat(jsons[1]) ? least.most : 1.01;
	if (!((double)visited > least.visited * (double)due && (double)visited < most * (double)due))
		fail_msg("%lld of %lld windows, not from %g to %g of them", visited, due, least.visited, least.most);
	mem_free(jsons[0]);
	mem_free(jsons[1]);
}

/* A scene of a model; forces where it has them. */
static inline const char *scene_of(const char *name, int m, const char *rest)
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

static inline void write_hops(support_height height)
{
	write_poses("ball.csv", &(struct hops){height, 2, 30, 30, 12, 11, 1.2, 0.4, 3, 1.7, 4, false});
	write_poses("wheel.csv", &(struct hops){height, 2, 90, 40, -9, 8, 1.0, 0.2, 2, 2.3, 4, false});
	write_poses("block.csv", &(struct hops){height, 2, 40, 90, 11, -10, 0.9, 0.1, 4, 1.1, 4, true});
}

static const struct extent extent = {129, 129, 2, 32};

#endif
