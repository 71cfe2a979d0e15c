/*
 * How wrong pictures are, and what that costs: the same cameras over one terrain with ruts, at pixel errors from
 * 0.25 to 16 and by the radii, each beside the true picture. A JSON line each.
 *
 * The true picture allows a millionth of a pixel: then every tile with any relief in it is drawn at its finest
 * level, and each of its posts is a vertex. (The lines of it are checked for that: no draw above level 0.) "psnr" is over
 * all cameras' pixels together, red, green and blue; "worst" the largest difference of one of those. "bytes" are
 * what the tiles that the pictures need take in slots, "ms_step" a frame drawn to its end, the median over cameras
 * and repetitions.
 *
 * The ground between posts of the source is smooth, so the true picture needs most tiles of the working level that the camera sees. Tiles
 * of the default size are few enough for that.
 *
 * bench_picture_error [--quick | --png FOLDER]. --quick: two settings, once each. --png: also writes each picture.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"
#include "render/internal.h"
#include "render/view.h"
#include "world/made.h"

#define WIDTH 640
#define HEIGHT 360
#define PIXELS ((size_t)WIDTH * HEIGHT)
#define SLOTS 1024
#define CELLS 256
#define REPEATS 9
#define TRUTH 1e-6
#define DARK 64 /* of 255: pictures whose mean red, green and blue is lower are dark */

/* Places in metres; z above the ground there. */
static const struct {
	const char *name;
	double eye[3], target[3];
} cameras[] = {
	{"chase", {230.5, 262.6, 3.2}, {250, 271, 0}},
	{"beside", {301, 275, 1.7}, {294, 284, 0}},
	{"above", {285, 290, 60}, {285, 292, 0}},
	{"along", {180, 200, 6}, {330, 380, 0}},
	{"hill", {500, 500, 12}, {760, 800, 30}},
	{"overview", {40, 40, 140}, {400, 420, 0}},
};
#define CAMERAS (sizeof cameras / sizeof *cameras)

static const double pixel_errors[] = {0, 0.25, 0.5, 1, 2, 4, 8, 16}; /* 0: by the radii */

struct rig {
	struct world *world;
	struct world_made made;
	struct scene scene;
	FILE *commit_log;
	struct view *view;
};

/* Four wheels, as the demonstration's: an S over 300 m. */
static void make_ruts(const char *store)
{
	static char text[16384];
	int used = snprintf(text, sizeof text, "scene: 1\ntime_step: 0.05\nend_time: 45\nspacing: 0.125\nredistribute: {model: box}\n"
			    "attributes: [dirt]\ncache: {slots: 128}\nobjects:\n");
	for (int wheel = 0; wheel < 4; wheel++) {
		double side = wheel % 2 == 0 ? -1 : 1, lag = wheel / 2 * 3;
		used += snprintf(text + used, sizeof text - (size_t)used,
				 "  - {name: w%d, shape: {wheel: {radius: 0.5, width: 0.4}}, sink: 0.15, path: {speed: 8, points: [", wheel);
		for (int i = 0; i <= 50; i++) {
			double s = 6 * i + 10 - lag, bend = 25 * sin(s / 40), turn = atan(25.0 / 40 * cos(s / 40));
			double u = s - side * sin(turn), v = bend + side * cos(turn);
			used += snprintf(text + used, sizeof text - (size_t)used, "%s[%.3f, %.3f]", i > 0 ? ", " : "",
					 190 + (u - v) * M_SQRT1_2, 190 + (u + v) * M_SQRT1_2);
		}
		used += snprintf(text + used, sizeof text - (size_t)used, "]}}\n");
	}
	mem_free(bench_drive(text, store));
}

static enum status before_read_back(void *user, struct tile tile, uint32_t slot)
{
	return STATUS_OK; /* nothing is dirty here */
}

/* A drive of no step: its pages, its view, and nothing that presses. */
static void open_rig(struct rig *rig, const char *store)
{
	struct resident *ground = &rig->made.resident;
	*rig = (struct rig){.scene = {
		.end_time = 1, .slots = SLOTS, .loaders = 2, .disturbance = true,
		.view = {.present = true, .width = WIDTH, .height = HEIGHT, .aim = {SCENE_FIXED, .target = {1, 1, 0}},
			 .light = scene_light_default(),
			 .effects = EFFECT_BIT(EFFECT_TEXTURE) | EFFECT_BIT(EFFECT_DETAIL) | EFFECT_BIT(EFFECT_FOG) | EFFECT_BIT(EFFECT_SKY) |
				    EFFECT_BIT(EFFECT_GEOMORPH) | EFFECT_BIT(EFFECT_SKIRTS)},
	}};
	bench_must(store_open(store, &(struct store_options){.mode = STORE_READ}, &ground->store));
	ground->meta = store_meta(ground->store);
	if (!store_has_working_level(ground->store, &ground->level))
		bench_must(fail_with(STATUS_FAILED, "%s: no rut was made; look at the drive", store));
	ground->was_deformed = true;
	ground->spacing = extent_spacing(&ground->meta->extent, ground->level);
	rig->made.scene = &rig->scene;
	rig->made.slots = SLOTS;
	rig->made.loaders = 2;
	rig->world = world_made(&rig->made);
	if (rig->world == NULL)
		bench_must(fail_memory("a world"));
	const unsigned planes = world_planes(rig->world);
	rig->commit_log = tmpfile();
	if (rig->commit_log == NULL)
		bench_must(fail_with(STATUS_FAILED, "/tmp: no file can be made; free some space"));
	bench_must(gpu_create(&(struct gpu_params){.draws = true}, &ground->gpu));
	bench_must(gpu_slots_create(ground->gpu, CELLS, SLOTS, planes, &ground->slots));
	bench_must(resident_ground_create(ground->store, 64, &ground->ground));
	bench_must(resident_pages_create(&(struct pages_params){.gpu = ground->gpu, .store = ground->store, .slots = ground->slots, .planes = planes,
						       .level = ground->level, .count = SLOTS, .loaders = 2, .step_pages = 16,
						       .record = world_record_pages(&rig->scene), .commit_log = rig->commit_log, .commit_age = 1000,
						       .before_read_back = before_read_back},
				&ground->pages));
	ground->cache = resident_pages_cache(ground->pages);
	world_made_set(rig->world, &rig->made);
}

static void close_rig(struct rig *rig)
{
	const struct resident *ground = &rig->made.resident;
	world_made_free(rig->world);
	resident_pages_destroy(ground->pages);
	resident_ground_destroy(ground->ground);
	gpu_slots_destroy(ground->slots);
	gpu_destroy(ground->gpu);
	store_close(ground->store);
	fclose(rig->commit_log);
}

static void place(struct rig *rig, size_t camera)
{
	const double *from[2] = {cameras[camera].eye, cameras[camera].target};
	double *to[2] = {rig->scene.view.aim.eye, rig->scene.view.aim.target};
	for (int i = 0; i < 2; i++) {
		int64_t height;
		bool any;
		bench_must(resident_ground_height(rig->made.resident.ground, lattice_offset(from[i][0]), lattice_offset(from[i][1]), &height, &any));
		to[i][0] = from[i][0];
		to[i][1] = from[i][1];
		to[i][2] = from[i][2] + lattice_offset_metres(height);
	}
}

struct figures {
	double ms[CAMERAS * REPEATS];
	size_t timed;
	double triangles, tiles, bytes; /* a frame */
	size_t deformed;                /* tiles with ruts, of all frames */
};

static double slot_bytes(const struct rig *rig, size_t *deformed)
{
	const struct render_selection *selection = rig->view->selection;
	double posts = (CELLS + 1) * (CELLS + 1), bytes = (double)selection->needed * posts * sizeof(int32_t);
	for (size_t i = 0; i < selection->draw_count; i++)
		if (gpu_slots_get(rig->made.resident.slots, selection->draws[i].slot)->target != NULL) {
			bytes += posts * (sizeof(int32_t) + 1); /* offset and dirt */
			++*deformed;
		}
	return bytes;
}

/* Every camera's picture, into pixels[camera]. */
static void draw(struct rig *rig, double pixel_error, int repeats, const char *folder, uint8_t *pixels, struct figures *figures)
{
	const bool truth = pixel_error == TRUTH;
	*figures = (struct figures){.tiles = 0};
	rig->scene.view.pixel_error = pixel_error;
	bench_must(render_view_create(rig->world, false, &rig->view));
	struct view *view = rig->view;
	for (size_t i = 0; i < CAMERAS; i++) {
		place(rig, i);
		bench_must(render_view_warm(view));
		gpu_finish(rig->made.resident.gpu);
		for (int k = 0; k < repeats; k++) {
			double began = clock_seconds();
			bench_must(render_view_frame(view, NULL, false));
			gpu_finish(rig->made.resident.gpu);
			figures->ms[figures->timed++] = (clock_seconds() - began) * 1e3;
		}
		const struct render_selection *selection = view->selection;
		if (view->coarse || selection->wanted_count > 0)
			bench_must(fail_with(STATUS_FAILED, "%s: its picture needs %zu tiles and %d are too few; give more SLOTS",
					     cameras[i].name, selection->needed, SLOTS));
		for (size_t k = 0; k < selection->draw_count && truth; k++)
			if (selection->draws[k].tile.level > 0)
				bench_must(fail_with(STATUS_FAILED, "%s: a true picture with a coarse tile; look at its error",
						     cameras[i].name));
		gpu_texture_read(view->render->screen->colour, 0, (struct gpu_rect){0, 0, WIDTH, HEIGHT}, pixels + i * PIXELS * 4);
		figures->triangles += (double)render_triangles(view->render) / CAMERAS;
		figures->tiles += (double)selection->draw_count / CAMERAS;
		figures->bytes += slot_bytes(rig, &figures->deformed) / CAMERAS;
		if (folder != NULL) {
			char path[4096];
			snprintf(path, sizeof path, "%s/%s-%g.png", folder, cameras[i].name, pixel_error);
			bench_must(render_write_png(view->render, path));
		}
	}
	render_view_destroy(view);
	rig->view = NULL;
}

/* Returns the sum of red, green and blue over all cameras' pixels. */
static double sum_of(const uint8_t *pixels)
{
	double sum = 0;
	for (size_t i = 0; i < 4 * PIXELS * CAMERAS; i++)
		sum += i % 4 < 3 ? pixels[i] : 0;
	return sum;
}

static void print(const struct rig *rig, double pixel_error, const uint8_t *truth, const uint8_t *pixels, struct figures *figures)
{
	double sum = 0;
	int worst = 0;
	char knob[32] = "null";
	for (size_t i = 0; i < 4 * PIXELS * CAMERAS; i++) {
		int apart = abs(truth[i] - pixels[i]); /* alpha is 255 in both */
		sum += apart * apart;
		worst = apart > worst ? apart : worst;
	}
	double psnr = 10 * log10(255.0 * 255 / (sum / (3.0 * PIXELS * CAMERAS)));
	if (pixel_error > 0)
		snprintf(knob, sizeof knob, "%g", pixel_error);
	printf("{\"bench\": \"accuracy\", \"study\": \"pixel_error\", \"knobs\": {\"pixel_error\": %s}, \"default\": %s, "
	       "\"picture\": {\"psnr\": %.2f, \"worst\": %d}, \"ms_step\": %.3f, \"bytes\": %.0f, \"triangles\": %.0f, \"tiles\": %.1f, "
	       "\"gl\": \"%s\"}\n",
	       knob, pixel_error > 0 ? "false" : "true", psnr, worst, bench_median(figures->ms, figures->timed), figures->bytes,
	       figures->triangles, figures->tiles, gpu_info(rig->made.resident.gpu)->renderer);
	fflush(stdout);
}

int main(int argc, char **argv)
{
	const char *folder = argc == 3 && strcmp(argv[1], "--png") == 0 ? argv[2] : NULL;
	const bool quick = argc == 2 && strcmp(argv[1], "--quick") == 0;
	if (argc != 1 && folder == NULL && !quick) {
		fprintf(stderr, "usage: bench_picture_error [--quick | --png FOLDER]\n");
		return 2;
	}
	/* Before the drive that makes the ruts: what opens the display first decides whether llvmpipe has raster threads. */
	struct gpu *first;
	bench_must(gpu_create(&(struct gpu_params){.draws = true}, &first));
	gpu_destroy(first);
	const char *store = bench_path("picture.furrow");
	struct dem_synth synth = {DEM_SYNTH_RIDGED, 1025, 1025, 1, 120, 7};
	bench_store(store, &synth, CELLS);
	make_ruts(store);
	struct rig rig;
	open_rig(&rig, store);
	uint8_t *truth = mem_alloc(CAMERAS * PIXELS, 4), *pixels = mem_alloc(CAMERAS * PIXELS, 4);
	if (truth == NULL || pixels == NULL)
		bench_must(fail_memory("the pictures"));
	struct figures figures;
	draw(&rig, TRUTH, 0, folder, truth, &figures);
	if (figures.deformed == 0)
		bench_must(fail_with(STATUS_FAILED, "no picture has a rut; look at the planes of the slots"));
	if (sum_of(truth) < DARK * 3.0 * PIXELS * CAMERAS)
		bench_must(fail_with(STATUS_FAILED, "the true pictures are dark; look at the light"));
	for (size_t i = 0; i < sizeof pixel_errors / sizeof *pixel_errors; i++) {
		if (quick && pixel_errors[i] != 0 && pixel_errors[i] != 4)
			continue;
		draw(&rig, pixel_errors[i], quick ? 1 : REPEATS, folder, pixels, &figures);
		print(&rig, pixel_errors[i], truth, pixels, &figures);
	}
	mem_free(truth);
	mem_free(pixels);
	close_rig(&rig);
	return 0;
}
