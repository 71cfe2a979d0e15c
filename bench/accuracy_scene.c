/*
 * The ground of bench_accuracy is a function: a slope, hills and roughness, every wave running its own way.
 *
 *   slope   0.15, to the east-north-east: 5 m of relief over the world's 32 m, so that a format that spreads its codes
 *           over the relief (R8: 20 mm a code) is put to it as by any real tile
 *   8, 5 m  hills that posts of 1 m still follow: what spacing loses there is little
 *   2.3, 1.3 m  humps of a wheel's size: posts of 1 m do not see them
 *   0.7, 0.45, 0.3 m  clods: seen by posts of 1/8 m and finer
 *
 * The mean height is 20 m above the lattice's reference (a multiple of 1024 m): a real place is up to 512 m from it.
 *
 * No two posts at any spacing differ by more than soil stands (tan 28 degrees): so undisturbed ground has nothing to
 * slide, and whether it `stands` or `slides` is the same. The soil has no cohesion, since what cohesive soil stands
 * depends on how far posts are apart (SOIL.md), and a truth at another spacing would be of another soil.
 *
 * The path is a loop that crosses itself: straight on, three quarters of a circle, and back at a right angle through its
 * own rut; turned against the lattice, so that no edge lies along posts.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "intake/intake.h"
#include "accuracy.h"
#include "bench.h"

#define MEAN 20.0
#define CENTRE_X 14.9 /* where it crosses itself: near tiles' edges at 16 m and at 12 m */
#define CENTRE_Y 12.9
#define TURNED 0.35   /* rad */
#define BEND 0.8      /* m: the circle's radius */
#define ENDS 1.2      /* m before and behind the crossing */
enum { ARC = 36, POINTS = ARC + 3 };

static const struct {
	double length, amplitude, direction, phase; /* m, m, rad, rad */
} waves[] = {
	{8.0, 0.10, 0.4, 0.3},    {5.0, 0.04, 2.1, 1.9},   {2.3, 0.015, 1.2, 4.0},  {1.3, 0.006, 2.8, 0.7},
	{0.7, 0.0025, 0.9, 2.2},  {0.45, 0.0012, 1.9, 5.1}, {0.3, 0.0008, 2.5, 3.3},
};
#define WAVES (sizeof waves / sizeof waves[0])
static const double slope[2] = {0.135, 0.065};

double accuracy_height(double x, double y)
{
	double height = MEAN + slope[0] * (x - ACCURACY_WORLD / 2) + slope[1] * (y - ACCURACY_WORLD / 2);
	for (size_t i = 0; i < WAVES; i++)
		height += waves[i].amplitude * sin(2 * M_PI / waves[i].length * (x * cos(waves[i].direction) +
										     y * sin(waves[i].direction)) +
						   waves[i].phase);
	return height;
}

double accuracy_steepest(void)
{
	double steepest = hypot(slope[0], slope[1]);
	for (size_t i = 0; i < WAVES; i++)
		steepest += 2 * M_PI * waves[i].amplitude / waves[i].length;
	return steepest;
}

const char *accuracy_described(void)
{
	static char text[1024];
	int length = snprintf(text, sizeof text,
			      "mean %g slope %g %g; path centre %g %g turned %g bend %g ends %g in %d; wheel %g x %g sunk %g; "
			      "speed %g; dry_sand without cohesion; waves",
			      MEAN, slope[0], slope[1], CENTRE_X, CENTRE_Y, TURNED, BEND, ENDS, ARC, ACCURACY_RADIUS,
			      ACCURACY_WIDTH, ACCURACY_SINK, ACCURACY_SPEED);
	for (size_t i = 0; i < WAVES; i++)
		length += snprintf(text + length, sizeof text - (size_t)length, " %g:%g:%g:%g", waves[i].length,
				   waves[i].amplitude, waves[i].direction, waves[i].phase);
	return text;
}

struct ground {
	double spacing;
	bool floats; /* a lossless store holds floats */
};

static enum status posts(void *user, struct post_rect rect, double *heights)
{
	const struct ground *ground = user;
	for (int64_t y = rect.y0; y < rect.y1; y++)
		for (int64_t x = rect.x0; x < rect.x1; x++) {
			double height = accuracy_height((double)x * ground->spacing, (double)y * ground->spacing);
			*heights++ = ground->floats ? (double)(float)height : height;
		}
	return STATUS_OK;
}

static enum status put(void *user, const struct dem_tile *tile)
{
	struct store_range range = {tile->low, tile->high, tile->error};
	return store_put_base(user, tile->tile, tile->codes, &range);
}

static void make(const char *path, double spacing, double max_error)
{
	int64_t side = (int64_t)(ACCURACY_WORLD / spacing) + 1;
	struct ground ground = {spacing, max_error == 0};
	struct store_meta meta = {
		.extent = {side, side, spacing, 256},
		.step = intake_step(max_error, 0, false),
		.max_error = max_error,
		.srs = "",
		.vertical = "",
		.sources = "a function",
	};
	struct store *store;
	bench_must(store_create(path, &meta, true, &store));
	bench_must(dem_cut(&(struct dem_cut){.extent = &meta.extent, .step = meta.step, .posts = posts, .posts_user = &ground,
					     .emit = put, .emit_user = store}));
	bench_must(store_publish(store));
	store_close(store);
}

const char *accuracy_store(double spacing, double max_error)
{
	static struct {
		double spacing, max_error;
		char path[128];
	} made[64];
	static size_t count;
	for (size_t i = 0; i < count; i++)
		if (made[i].spacing == spacing && made[i].max_error == max_error)
			return made[i].path;
	if (count == sizeof made / sizeof made[0])
		bench_must(fail_with(STATUS_FAILED, "bench: more stores than expected; raise their number"));
	char name[32];
	snprintf(name, sizeof name, "%zu.furrow", count);
	made[count].spacing = spacing;
	made[count].max_error = max_error;
	snprintf(made[count].path, sizeof made[count].path, "%s", bench_path(name));
	make(made[count].path, spacing, max_error);
	return made[count++].path;
}

/* The path's point, before it is turned and set down at the centre. */
static void point_of(int i, double *x, double *y)
{
	double angle = (-0.5 + 1.5 * (i - 1) / ARC) * M_PI;
	*x = i == 0 ? -ENDS : i == POINTS - 1 ? 0 : BEND + BEND * cos(angle);
	*y = i == 0 ? 0 : i == POINTS - 1 ? -ENDS : BEND + BEND * sin(angle);
}

const char *accuracy_model_name(enum deform_model model)
{
	return deform_model_row(model)->name;
}

struct scene *accuracy_scene(enum deform_model model, int laps, const struct scene_setting *settings, size_t count)
{
	const char *path = bench_path("scene.yaml");
	FILE *file = fopen(path, "w");
	if (file == NULL)
		bench_must(fail_with(STATUS_FAILED, "%s: cannot be written; free some space", path));
	fprintf(file, "scene: 1\nend_time: 0.001\nsoil: {name: dry_sand, cohesion: 0}\n");
	if (model != DEFORM_MODEL_DEFAULT)
		fprintf(file, "redistribute: {model: %s}\n", accuracy_model_name(model));
	fprintf(file, "objects:\n  - name: wheel\n    shape: {wheel: {radius: %g, width: %g}}\n    sink: %g\n    path:\n"
		      "      speed: %g\n      points:\n        [",
		ACCURACY_RADIUS, ACCURACY_WIDTH, ACCURACY_SINK, ACCURACY_SPEED);
	for (int lap = 0; lap < laps; lap++)
		for (int i = 0; i < POINTS; i++) {
			double x, y;
			point_of(i, &x, &y);
			fprintf(file, "%s[%.9f, %.9f]", lap + i > 0 ? ", " : "", CENTRE_X + x * cos(TURNED) - y * sin(TURNED),
				CENTRE_Y + x * sin(TURNED) + y * cos(TURNED));
		}
	fprintf(file, "]\n");
	if (ferror(file) != 0 || fclose(file) != 0)
		bench_must(fail_with(STATUS_FAILED, "%s: cannot be written; free some space", path));
	struct scene *scene;
	bench_must(scene_load(path, settings, count, &scene));
	return scene;
}

struct track *accuracy_track(const struct scene *scene, double spacing)
{
	const struct scene_path *path = &scene->objects[0].path;
	struct track *track;
	bench_must(motion_track_create(path, spacing, ACCURACY_RADIUS, &track));
	return track;
}

double accuracy_ends(const struct track *track)
{
	return ceil(motion_track_sample_time(track, motion_track_samples(track) - 1) * 10) / 10;
}
