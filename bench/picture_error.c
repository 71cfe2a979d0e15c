/*
 * How wrong pictures are, and what that costs: the same cameras over one terrain with ruts, at pixel errors from
 * 0.25 to 16 and by the radii, each beside the true picture. A JSON line each.
 *
 * The true picture allows a millionth of a pixel: then every tile with any relief in it is drawn at its finest
 * level, and each of its posts is a vertex. (The lines of it are checked for that: no draw above level 0.) "psnr" is over
 * all cameras' pixels together, red, green and blue; "worst" the largest difference of one of those. "bytes" are
 * what the tiles that the pictures need take in slots, "ms_step" a frame drawn to its end: the mean over the cameras, of
 * which "ms_runs" has each run and "ms_step" the median. Settings take turns.
 *
 * The second study, samples, turns view.samples by the radii. Its true picture has SHARP x SHARP pixels with MOST_SAMPLES samples each in place of one,
 * whose mean is taken in linear light.
 *
 * The ground between posts of the source is smooth, so the true picture needs most tiles of the working level that the camera sees. Tiles
 * of the default size are few enough for that.
 *
 * bench_picture_error [--quick | --png FOLDER]. --quick: two settings of each study, two runs. --png: also writes each picture.
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
#define REPEATS 5
#define SHARP 3
#define MOST_SAMPLES 4 /* that llvmpipe draws */
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

/* pixel_error 0: by the radii. A study's settings follow each other. */
static const struct setting {
	double pixel_error;
	int samples;
	bool of_samples, in_quick;
} settings[] = {
	{0, 1, false, true},  {0.25, 1, false, false}, {0.5, 1, false, false}, {1, 1, false, false},
	{2, 1, false, false}, {4, 1, false, true},     {8, 1, false, false},   {16, 1, false, false},
	{0, 1, true, true},   {0, 2, true, false},     {0, MOST_SAMPLES, true, true},
};
#define SETTINGS (sizeof settings / sizeof *settings)

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
	double ms[REPEATS]; /* mean over the cameras */
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

/* Every camera's picture, into pixels[camera], and its time into ms[run] unless it is a truth. sharp: so many pixels each way in place of one. */
static void draw(struct rig *rig, const struct setting *setting, int run, int sharp, const char *folder, uint8_t *pixels, struct figures *figures)
{
	const bool truth = setting->pixel_error == TRUTH, timed = !truth && sharp == 1;
	rig->scene.view.pixel_error = setting->pixel_error;
	rig->scene.view.samples = setting->samples;
	rig->scene.view.width = WIDTH * sharp;
	rig->scene.view.height = HEIGHT * sharp;
	bench_must(render_view_create(rig->world, false, &rig->view));
	struct view *view = rig->view;
	figures->ms[run] = figures->triangles = figures->tiles = figures->bytes = 0;
	for (size_t i = 0; i < CAMERAS; i++) {
		place(rig, i);
		bench_must(render_view_warm(view));
		gpu_finish(rig->made.resident.gpu);
		if (timed) {
			double began = clock_seconds();
			bench_must(render_view_frame(view, NULL, false));
			gpu_finish(rig->made.resident.gpu);
			figures->ms[run] += (clock_seconds() - began) * 1e3 / CAMERAS;
		}
		const struct render_selection *selection = view->selection;
		if (view->coarse || selection->wanted_count > 0)
			bench_must(fail_with(STATUS_FAILED, "%s: its picture needs %zu tiles and %d are too few; give more SLOTS",
					     cameras[i].name, selection->needed, SLOTS));
		for (size_t k = 0; k < selection->draw_count && truth; k++)
			if (selection->draws[k].tile.level > 0)
				bench_must(fail_with(STATUS_FAILED, "%s: a true picture with a coarse tile; look at its error",
						     cameras[i].name));
		gpu_texture_read(view->render->screen->colour, 0, (struct gpu_rect){0, 0, WIDTH * sharp, HEIGHT * sharp},
				 pixels + i * PIXELS * 4 * (size_t)(sharp * sharp));
		figures->triangles += (double)render_triangles(view->render) / CAMERAS;
		figures->tiles += (double)selection->draw_count / CAMERAS;
		figures->bytes += slot_bytes(rig, &figures->deformed) / CAMERAS;
		if (folder != NULL && run == 0) {
			char path[4096];
			snprintf(path, sizeof path, "%s/%s-%g-%d.png", folder, cameras[i].name, setting->pixel_error, setting->samples);
			bench_must(render_write_png(view->render, path));
		}
	}
	render_view_destroy(view);
	rig->view = NULL;
}

static double linear(uint8_t code)
{
	double share = code / 255.0;
	return share <= 0.04045 ? share / 12.92 : pow((share + 0.055) / 1.055, 2.4);
}

static uint8_t coded(double light)
{
	return (uint8_t)lround(255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1 / 2.4) - 0.055));
}

/* The mean of SHARP x SHARP pixels, in linear light. */
static void shrink(const uint8_t *sharp, uint8_t *pixels)
{
	double light[256];
	for (int code = 0; code < 256; code++)
		light[code] = linear((uint8_t)code);
	for (size_t i = 0; i < CAMERAS * HEIGHT; i++)
		for (size_t x = 0; x < WIDTH; x++)
			for (size_t channel = 0; channel < 4; channel++) {
				double sum = 0;
				for (size_t k = 0; k < SHARP * SHARP; k++)
					sum += light[sharp[(((i * SHARP + k / SHARP) * WIDTH + x) * SHARP + k % SHARP) * 4 + channel]];
				pixels[(i * WIDTH + x) * 4 + channel] = coded(sum / (SHARP * SHARP));
			}
}

/* Returns the sum of red, green and blue over all cameras' pixels. */
static double sum_of(const uint8_t *pixels)
{
	double sum = 0;
	for (size_t i = 0; i < 4 * PIXELS * CAMERAS; i++)
		sum += i % 4 < 3 ? pixels[i] : 0;
	return sum;
}

static void print(const struct rig *rig, const struct setting *setting, const uint8_t *truth, const uint8_t *pixels, struct figures *figures, int runs)
{
	double sum = 0;
	int worst = 0;
	char knob[64] = "\"pixel_error\": null";
	for (size_t i = 0; i < 4 * PIXELS * CAMERAS; i++) {
		int apart = abs(truth[i] - pixels[i]); /* alpha is 255 in both */
		sum += apart * apart;
		worst = apart > worst ? apart : worst;
	}
	double psnr = 10 * log10(255.0 * 255 / (sum / (3.0 * PIXELS * CAMERAS)));
	if (setting->of_samples)
		snprintf(knob, sizeof knob, "\"samples\": %d", setting->samples);
	else if (setting->pixel_error > 0)
		snprintf(knob, sizeof knob, "\"pixel_error\": %g", setting->pixel_error);
	printf("{\"bench\": \"accuracy\", \"study\": \"%s\", \"knobs\": {%s}, \"default\": %s, \"truth\": \"%s\", "
	       "\"picture\": {\"psnr\": %.2f, \"worst\": %d}, \"ms_runs\": [",
	       setting->of_samples ? "samples" : "pixel_error", knob, setting->pixel_error == 0 && setting->samples == 1 ? "true" : "false",
	       setting->of_samples ? "9 pixels of 4 samples in place of one" : "every post a vertex", psnr, worst);
	for (int run = 0; run < runs; run++)
		printf("%s%.3f", run > 0 ? ", " : "", figures->ms[run]);
	printf("], \"ms_step\": %.4f, \"bytes\": %.0f, \"triangles\": %.0f, \"tiles\": %.1f, \"gl\": \"%s\"}\n",
	       bench_median(figures->ms, (size_t)runs), figures->bytes, figures->triangles, figures->tiles, gpu_info(rig->made.resident.gpu)->renderer);
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
	const int runs = quick ? 2 : REPEATS;
	uint8_t *truth = mem_alloc(CAMERAS * PIXELS, 4), *smooth = mem_alloc(CAMERAS * PIXELS, 4), *sharp = mem_alloc(CAMERAS * PIXELS * SHARP * SHARP, 4);
	uint8_t *pixels = mem_alloc(CAMERAS * PIXELS * SETTINGS, 4); /* of each setting */
	if (truth == NULL || pixels == NULL || smooth == NULL || sharp == NULL)
		bench_must(fail_memory("the pictures"));
	static struct figures figures[SETTINGS], unused;
	draw(&rig, &(struct setting){.pixel_error = TRUTH, .samples = 1}, 0, 1, folder, truth, &unused);
	if (unused.deformed == 0)
		bench_must(fail_with(STATUS_FAILED, "no picture has a rut; look at the planes of the slots"));
	if (sum_of(truth) < DARK * 3.0 * PIXELS * CAMERAS)
		bench_must(fail_with(STATUS_FAILED, "the true pictures are dark; look at the light"));
	draw(&rig, &(struct setting){.samples = MOST_SAMPLES}, 0, SHARP, NULL, sharp, &unused);
	shrink(sharp, smooth);
	for (int run = 0; run < runs; run++)
		for (size_t i = 0; i < SETTINGS; i++)
			if (!quick || settings[i].in_quick)
				draw(&rig, &settings[i], run, 1, folder, pixels + i * CAMERAS * PIXELS * 4, &figures[i]);
	for (size_t i = 0; i < SETTINGS; i++)
		if (!quick || settings[i].in_quick)
			print(&rig, &settings[i], settings[i].of_samples ? smooth : truth, pixels + i * CAMERAS * PIXELS * 4, &figures[i], runs);
	mem_free(truth);
	mem_free(smooth);
	mem_free(sharp);
	mem_free(pixels);
	close_rig(&rig);
	return 0;
}
