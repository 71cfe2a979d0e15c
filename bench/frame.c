/*
 * What a frame costs: each effect alone and all, by level budget, at three sizes; of ground that is being deformed beside
 * the same at rest; with few slots beside all. A JSON line each; the last says whether the bar is met.
 *
 * Two views of one ridged terrain of 2049 x 2049 posts with ruts: "chase", behind a wheel as the demonstration has it,
 * and "high", over the whole of it. All lines of a table are drawn in turn, round after round, each frame timed by the wall
 * clock around a finish: "ms" are medians over rounds, "over" the median of what a line took beyond another of its
 * round. "levels" null: by the radii.
 *
 * Deforming: four wheels press and move between frames, one step of 1/25 s each. "at_rest" is the same frame again, "untouched"
 * that of a drive whose wheels never came down; "pyramid" brings coarser tiles up to date, which only a picture
 * asks for; "step" is what was pressed. What deformation adds to a frame is (frame + pyramid) / at_rest.
 *
 * "imagery" is all beside all with imagery of 0.125 m, of random colours, in one run.
 *
 * Many frames in a row, without a finish between them, give the fps at 1920 x 1080 on hardware.
 *
 * bench_frame [--quick] [--png FOLDER] [--table NAME]: fewer rounds; pictures are kept; one table, and no word of the bar.
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"
#include "imagery.h"
#include "record.h"
#include "render/internal.h"
#include "render/view.h"
#include "world/made.h"

enum { POSTS = 2049, CELLS = 256, SLOTS = 320, FEW_SLOTS = 20, ROUNDS_MOST = 25, LOOKS_MOST = 32 };
#define SPACING 0.125
#define MOMENT 20.0 /* s: when the chase is looked at */
#define STEP 0.04
#define BAR_MS 40.0
#define BAR_TRIANGLES 120000
#define BAR_DEFORMING 1.1

#define BIT(NAME) EFFECT_BIT(EFFECT_##NAME)
#define ALL (BIT(TEXTURE) | BIT(DETAIL) | BIT(FOG) | BIT(SKY) | BIT(GEOMORPH) | BIT(SKIRTS))
#define BAR_EFFECTS (BIT(TEXTURE) | BIT(FOG) | BIT(GEOMORPH))
static const struct {
	const char *name;
	uint64_t effects;
} sets[] = {
	{"none", 0}, {"texture", BIT(TEXTURE)}, {"texture, detail", BIT(TEXTURE) | BIT(DETAIL)}, {"fog", BIT(FOG)}, {"sky", BIT(SKY)},
	{"geomorph", BIT(GEOMORPH)}, {"skirts", BIT(SKIRTS)}, {"texture, fog, geomorph", BAR_EFFECTS}, {"all", ALL},
	/* only in the table of imagery */
	{"all, imagery", ALL | BIT(IMAGERY)},
};
#define SETS (sizeof sets / sizeof *sets - 1)

static const int sizes[][2] = {{640, 360}, {1280, 720}, {1920, 1080}};
static const double budgets[] = {0, 8, 4, 1}; /* pixels; 0: by the radii */
enum { CHASE, HIGH, VIEWS };
static const char *const view_names[] = {"chase", "high"};

static int rounds = 15;
static const char *folder; /* of pictures; NULL: none are kept */
static struct gpu *gpu;

/* --- terrain, ruts, drives --- */

/* Four wheels, as the demonstration's: an S over 300 m. */
static const char *scene_text(void)
{
	static char text[16384];
	int used = snprintf(text, sizeof text, "scene: 1\ntime_step: %g\nend_time: 30\nspacing: %g\nredistribute: {model: box}\n"
			    "attributes: [dirt]\ncache: {slots: %d}\nobjects:\n", STEP, SPACING, SLOTS);
	for (int wheel = 0; wheel < 4; wheel++) {
		double side = wheel % 2 == 0 ? -1 : 1, lag = wheel / 2 * 3;
		used += snprintf(text + used, sizeof text - (size_t)used,
				 "  - {name: w%d, shape: {wheel: {radius: 0.5, width: 0.4}}, sink: 0.15, path: {speed: 8, points: [", wheel);
		for (int i = 0; i <= 50; i++) {
			double s = 6 * i + 10 - lag, bend = 25 * sin(s / 40), turn = atan(25.0 / 40 * cos(s / 40));
			double u = s - side * sin(turn), v = bend + side * cos(turn);
			used += snprintf(text + used, sizeof text - (size_t)used, "%s[%.3f, %.3f]", i > 0 ? ", " : "",
					 700 + (u - v) * M_SQRT1_2, 500 + (u + v) * M_SQRT1_2);
		}
		used += snprintf(text + used, sizeof text - (size_t)used, "]}}\n");
	}
	return text;
}

/* A drive that is stepped from here: nothing of it is committed. `overlay` NULL: nothing of it is changed either. */
struct rig {
	struct world *world;    /* it is opened and not started: the bench makes slots and pages, since all rigs share one GL context */
	struct world_made made;
	struct scene *scene;
	FILE *commit_log;
};

static enum status before_read_back(void *user, struct tile tile, uint32_t slot)
{
	return STATUS_OK; /* nothing leaves its slot here */
}

static void open_rig(struct rig *rig, const char *store, const char *overlay, uint32_t slots)
{
	struct resident *ground = &rig->made.resident;
	const char *path = bench_path("rig.yaml");
	FILE *file = fopen(path, "w");
	if (file == NULL || fputs(scene_text(), file) < 0 || fclose(file) != 0)
		bench_must(fail_with(STATUS_FAILED, "%s: cannot be written; free some space", path));
	*rig = (struct rig){.scene = NULL};
	bench_must(scene_load(path, NULL, 0, &rig->scene));
	rig->scene->slots = slots;
	rig->scene->loaders = 2;
	rig->scene->view = (struct scene_view){.present = true, .width = sizes[1][0], .height = sizes[1][1], .effects = ALL,
					       .aim = {SCENE_CHASE, .object = 2, .back = 13, .up = 3.2}, .imagery_budget = 128, .light = scene_light_default()};
	bench_must(world_open(&(struct world_params){.scene = rig->scene, .store = store, .overlay = overlay, .readonly = overlay == NULL}, &rig->world));
	world_made_get(rig->world, &rig->made);
	rig->made.time = MOMENT;
	rig->commit_log = tmpfile();
	if (rig->commit_log == NULL)
		bench_must(fail_with(STATUS_FAILED, "/tmp: no file can be made; free some space"));
	unsigned planes = world_planes(rig->world);
	ground->gpu = gpu;
	bench_must(gpu_slots_create(gpu, CELLS, slots, planes, &ground->slots));
	bench_must(resident_pages_create(&(struct pages_params){.gpu = gpu, .store = ground->store, .slots = ground->slots, .planes = planes,
						       .level = ground->level, .count = slots, .loaders = 2, .step_pages = 16,
						       .record = world_record_pages(rig->scene), .commit_log = rig->commit_log, .commit_age = 1e6,
						       .before_read_back = before_read_back},
				&ground->pages));
	ground->cache = resident_pages_cache(ground->pages);
	world_made_set(rig->world, &rig->made);
}

/* The GL context stays. Nothing is committed. */
static void close_rig(struct rig *rig)
{
	rig->made.resident.gpu = NULL;
	world_made_set(rig->world, &rig->made);
	world_finish(rig->world, STATUS_INTERRUPTED);
	fclose(rig->commit_log);
	scene_destroy(rig->scene);
}

static void aim(struct rig *rig, int view)
{
	struct scene_view *wish = &rig->scene->view;
	wish->aim.kind = view == CHASE ? SCENE_CHASE : SCENE_FIXED;
	double middle = 0.5 * (POSTS - 1), high = rig->made.resident.meta->high;
	const double eye[3] = {0.1 * middle, 0.1 * middle, high + 350}, target[3] = {middle, middle, rig->made.resident.meta->low};
	memcpy(wish->aim.eye, eye, sizeof eye);
	memcpy(wish->aim.target, target, sizeof target);
}

/* --- looks: a line of a table --- */

struct look {
	struct rig *rig;
	const char *effects;
	const int *size;
	double budget;
	int camera;
	struct view *view;
	double ms[ROUNDS_MOST], triangles;
	struct render_tiles tiles;
	bool starved; /* coarser than asked for, in its last frame */
};

static void open_look(struct look *look, struct rig *rig, int camera, const int *size, double budget, size_t set)
{
	*look = (struct look){.rig = rig, .effects = sets[set].name, .size = size, .budget = budget, .camera = camera};
	aim(rig, camera);
	rig->scene->view.width = size[0];
	rig->scene->view.height = size[1];
	rig->scene->view.pixel_error = budget;
	rig->scene->view.effects = sets[set].effects;
	bench_must(render_view_create(rig->world, false, &look->view));
	bench_must(render_view_warm(look->view));
}

static double frame(struct look *look)
{
	aim(look->rig, look->camera);
	gpu_finish(gpu);
	uint64_t starved = look->view->starved;
	double began = clock_seconds();
	bench_must(render_view_frame(look->view, NULL, false));
	gpu_finish(gpu);
	double ms = (clock_seconds() - began) * 1e3;
	look->starved = look->view->starved > starved;
	look->triangles = (double)render_triangles(look->view->render);
	render_tiles(look->view->render, &look->tiles);
	return ms;
}

static void save(const struct look *look, const char *table)
{
	char path[4096];
	if (folder == NULL)
		return;
	snprintf(path, sizeof path, "%s/%s-%s-%d-%g-%s.png", folder, table, view_names[look->camera], look->size[1], look->budget,
		 look->effects);
	for (char *c = path + strlen(folder); *c != '\0'; c++)
		*c = *c == ' ' || *c == ',' ? '_' : *c;
	bench_must(render_write_png(look->view->render, path));
}

/* All looks in turn, each round beginning with the next one. A picture that is not whole is drawn until it is. */
static void take(struct look *looks, size_t count, const char *table)
{
	for (size_t i = 0; i < count; i++) {
		frame(&looks[i]);
		save(&looks[i], table);
	}
	for (int round = 0; round < rounds; round++)
		for (size_t i = 0; i < count; i++) {
			struct look *look = &looks[(i + (size_t)round) % count];
			look->ms[round] = frame(look);
		}
}

static double median(const double *values)
{
	double sorted[ROUNDS_MOST];
	memcpy(sorted, values, (size_t)rounds * sizeof *values);
	return bench_median(sorted, (size_t)rounds);
}

static double median_over(const double *values, const double *others)
{
	double apart[ROUNDS_MOST];
	for (int i = 0; i < rounds; i++)
		apart[i] = values[i] - others[i];
	return bench_median(apart, (size_t)rounds);
}

/* A figure of the record. `more`: what a key has behind the effects' names. */
static void keep(const char *view, const int size[2], const char *effects, const char *more, const char *unit, const double *values, int count)
{
	char key[160];
	double sorted[ROUNDS_MOST];
	int used = snprintf(key, sizeof key, "%s.%dx%d.", view, size[0], size[1]);
	for (; *effects != '\0'; effects++) /* "texture, fog" is texture_fog */
		if (*effects != ',')
			key[used++] = *effects == ' ' ? '_' : *effects;
	snprintf(key + used, sizeof key - (size_t)used, "%s", more);
	memcpy(sorted, values, (size_t)count * sizeof *sorted);
	bench_record_add(key, unit, sorted, (size_t)count);
}

static void print_look(const char *table, const struct look *look, const struct look *over)
{
	char budget[32] = "null";
	double ms = median(look->ms);
	if (look->budget > 0)
		snprintf(budget, sizeof budget, "%g", look->budget);
	printf("{\"bench\": \"frame\", \"table\": \"%s\", \"view\": \"%s\", \"size\": [%d, %d], \"effects\": \"%s\", \"levels\": %s, "
	       "\"slots\": %u, \"ms\": %.2f, \"over\": %.2f, \"fps\": %.1f, \"triangles\": %.0f, \"tiles\": %" PRIu64 ", \"coarser\": %s, "
	       "\"gl\": \"%s\"}\n",
	       table, view_names[look->camera], look->size[0], look->size[1], look->effects, budget, look->rig->scene->slots, ms,
	       median_over(look->ms, over->ms), 1e3 / ms, look->triangles, look->tiles.drawn, look->starved ? "true" : "false",
	       gpu_info(gpu)->renderer);
	fflush(stdout);
}

static void finish_looks(struct look *looks, size_t count)
{
	for (size_t i = 0; i < count; i++)
		render_view_destroy(looks[i].view);
}

/* --- tables --- */

struct bar {
	double ms, triangles; /* the worse of the views */
	double deforming;
};

/* Over the frame without effects. */
static void effects_table(struct rig *rig, struct bar *bar)
{
	static struct look looks[SETS];
	for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
		for (int view = 0; view < VIEWS; view++) {
			for (size_t i = 0; i < SETS; i++)
				open_look(&looks[i], rig, view, sizes[s], 0, i);
			take(looks, SETS, "effects");
			for (size_t i = 0; i < SETS; i++) {
				print_look("effects", &looks[i], &looks[0]);
				keep(view_names[view], sizes[s], looks[i].effects, "", "ms", looks[i].ms, rounds);
				keep(view_names[view], sizes[s], looks[i].effects, ".triangles", "", &(double){looks[i].triangles}, 1);
				if (sets[i].effects != BAR_EFFECTS || sizes[s][1] != 720)
					continue;
				bar->ms = fmax(bar->ms, median(looks[i].ms));
				bar->triangles = fmax(bar->triangles, looks[i].triangles);
			}
			finish_looks(looks, SETS);
		}
}

/* Over the same by the radii. */
static void levels_table(struct rig *rig)
{
	enum { BUDGETS = sizeof budgets / sizeof *budgets };
	static struct look looks[BUDGETS];
	for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
		for (int view = 0; view < VIEWS; view++) {
			for (size_t i = 0; i < BUDGETS; i++)
				open_look(&looks[i], rig, view, sizes[s], budgets[i], SETS - 1);
			take(looks, BUDGETS, "levels");
			for (size_t i = 0; i < BUDGETS; i++)
				print_look("levels", &looks[i], &looks[0]);
			finish_looks(looks, BUDGETS);
		}
}

/* Over the same with all resident. */
static void slots_table(struct rig *all, struct rig *few)
{
	static struct look looks[2];
	for (int view = 0; view < VIEWS; view++) {
		open_look(&looks[0], all, view, sizes[1], 0, SETS - 1);
		open_look(&looks[1], few, view, sizes[1], 0, SETS - 1);
		take(looks, 2, "slots");
		for (size_t i = 0; i < 2; i++)
			print_look("slots", &looks[i], &looks[0]);
		finish_looks(looks, 2);
	}
}

/* Over the same without imagery. */
static void imagery_table(struct rig *rig)
{
	static struct look looks[2];
	for (int view = 0; view < VIEWS; view++) {
		double ratio[ROUNDS_MOST];
		for (size_t i = 0; i < 2; i++)
			open_look(&looks[i], rig, view, sizes[1], 0, SETS - 1 + i);
		take(looks, 2, "imagery");
		for (size_t i = 0; i < 2; i++)
			print_look("imagery", &looks[i], &looks[0]);
		for (int i = 0; i < rounds; i++)
			ratio[i] = looks[1].ms[i] / looks[0].ms[i];
		printf("{\"bench\": \"frame\", \"table\": \"imagery\", \"view\": \"%s\", \"ratio\": %.3f}\n", view_names[view], bench_median(ratio, (size_t)rounds));
		keep(view_names[view], sizes[1], "all, imagery", ".ratio", "times", ratio, rounds);
		finish_looks(looks, 2);
	}
}

/* --- deforming --- */

static void set_time(struct rig *rig, double time)
{
	rig->made.time = time;
	world_made_set(rig->world, &rig->made);
}

static void press(struct rig *rig, double until)
{
	bench_must(world_made_contacts(rig->world, until));
	rig->made.time = until;
}

static void start_pressing(struct rig *rig)
{
	struct resident *ground = &rig->made.resident;
	struct deform_params params;
	world_made_deform_params(rig->world, &params);
	params.gpu = gpu;
	params.slots = ground->slots;
	params.reference = resident_ground_reference(ground->store);
	bench_must(deform_create(&params, &rig->made.deform));
	bench_must(resident_pyramid_create(&ground->meta->extent, ground->level, ground->slots, NULL, &ground->pyramid));
	set_time(rig, 0);
}

static void deform_table(struct rig *rig, struct rig *untouched, struct bar *bar)
{
	static struct look moving, without;
	double step[ROUNDS_MOST], pyramid[ROUNDS_MOST], frames[ROUNDS_MOST], at_rest[ROUNDS_MOST], both[ROUNDS_MOST], ratio[ROUNDS_MOST];
	int before = (int)(1.5 / STEP);
	start_pressing(rig);
	set_time(untouched, 0);
	open_look(&moving, rig, CHASE, sizes[1], 0, SETS - 1);
	open_look(&without, untouched, CHASE, sizes[1], 0, SETS - 1);
	for (int i = -before; i < rounds; i++) {
		double until = (i + before + 1) * STEP, times[3];
		gpu_finish(gpu);
		times[0] = clock_seconds();
		press(rig, until);
		gpu_finish(gpu);
		times[1] = clock_seconds();
		bench_must(resident_pyramid_flush(rig->made.resident.pyramid, rig->made.resident.cache));
		gpu_finish(gpu);
		times[2] = clock_seconds();
		set_time(untouched, until);
		double first = frame(&moving), again = frame(&moving), never = frame(&without);
		if (i < 0)
			continue;
		step[i] = (times[1] - times[0]) * 1e3;
		pyramid[i] = (times[2] - times[1]) * 1e3;
		frames[i] = first;
		at_rest[i] = again;
		both[i] = first + pyramid[i];
		ratio[i] = both[i] / again;
		without.ms[i] = never;
	}
	bar->deforming = median(ratio);
	printf("{\"bench\": \"frame\", \"table\": \"deforming\", \"view\": \"chase\", \"size\": [%d, %d], \"effects\": \"all\", "
	       "\"wheels\": 4, \"untouched\": %.2f, \"at_rest\": %.2f, \"frame\": %.2f, \"pyramid\": %.2f, \"frame_and_pyramid\": %.2f, "
	       "\"step\": %.2f, \"ratio\": %.3f, \"triangles\": %.0f, \"tiles\": %" PRIu64 ", \"gl\": \"%s\"}\n",
	       sizes[1][0], sizes[1][1], median(without.ms), median(at_rest), median(frames), median(pyramid), median(both), median(step),
	       bar->deforming, moving.triangles, moving.tiles.drawn, gpu_info(gpu)->renderer);
	bench_record_add("deforming.ratio", "times", ratio, (size_t)rounds);
	bench_record_add("deforming.pyramid", "ms", pyramid, (size_t)rounds);
	save(&moving, "deforming");
	render_view_destroy(moving.view);
	render_view_destroy(without.view);
}

static void hardware_table(struct rig *rig)
{
	enum { IN_A_ROW = 200 };
	static struct look look;
	if (gpu_info(gpu)->software)
		return;
	for (int view = 0; view < VIEWS; view++) {
		open_look(&look, rig, view, sizes[2], 0, SETS - 1);
		frame(&look);
		double began = clock_seconds();
		for (int i = 0; i < IN_A_ROW; i++)
			bench_must(render_view_frame(look.view, NULL, false));
		gpu_finish(gpu);
		const double fps = IN_A_ROW / (clock_seconds() - began);
		keep(view_names[view], sizes[2], "all", ".in_a_row", "1/s", &fps, 1);
		printf("{\"bench\": \"frame\", \"table\": \"hardware\", \"view\": \"%s\", \"size\": [%d, %d], \"effects\": \"all\", "
		       "\"fps\": %.1f, \"triangles\": %" PRIu64 ", \"gl\": \"%s\"}\n",
		       view_names[view], sizes[2][0], sizes[2][1], fps,
		       render_triangles(look.view->render), gpu_info(gpu)->renderer);
		render_view_destroy(look.view);
	}
}

static void print_bar(const struct bar *bar)
{
	bool fast = bar->ms <= BAR_MS, few = bar->triangles <= BAR_TRIANGLES, cheap = bar->deforming < BAR_DEFORMING;
	printf("{\"bench\": \"frame\", \"bar\": {\"ms\": %g, \"triangles\": %d, \"deforming\": %g}, \"ms\": %.2f, \"triangles\": %.0f, "
	       "\"deforming\": %.3f, \"met\": %s, \"gl\": \"%s\"}\n",
	       BAR_MS, BAR_TRIANGLES, BAR_DEFORMING, bar->ms, bar->triangles, bar->deforming, fast && few && cheap ? "true" : "false",
	       gpu_info(gpu)->renderer);
}

static void keep_path(char *copy, const char *name)
{
	snprintf(copy, 128, "%s", bench_path(name));
}

static bool asked(const char *only, const char *table)
{
	return only == NULL || strcmp(only, table) == 0;
}

int main(int argc, char **argv)
{
	const char *only = NULL;
	bench_record_begin("frame", &argc, argv);
	for (int i = 1; i < argc; i++) {
		bool quick = strcmp(argv[i], "--quick") == 0, more = i + 1 < argc;
		bool png = more && strcmp(argv[i], "--png") == 0, table = more && strcmp(argv[i], "--table") == 0;
		if (!quick && !png && !table) {
			fprintf(stderr, "usage: bench_frame [--quick] [--png FOLDER] [--table effects|levels|slots|imagery|deforming] [--figures FILE]\n");
			return 2;
		}
		rounds = quick ? 5 : rounds;
		folder = png ? argv[++i] : folder;
		only = table ? argv[++i] : only;
	}
	/* Before the drive that makes the ruts: what opens the display first decides whether llvmpipe has raster threads. */
	bench_must(gpu_create(&(struct gpu_params){.draws = true}, &gpu));
	gpu_destroy(gpu);
	struct dem_synth synth = {DEM_SYNTH_RIDGED, POSTS, POSTS, 1, 160, 7};
	char plain[128], rutted[128], overlays[2][128];
	keep_path(plain, "plain.furrow");
	keep_path(rutted, "rutted.furrow");
	keep_path(overlays[0], "a.overlay");
	keep_path(overlays[1], "b.overlay");
	bench_store(plain, &synth, CELLS);
	bench_store(rutted, &synth, CELLS);
	mem_free(bench_drive(scene_text(), rutted));
	if (asked(only, "imagery") && store_imagery_possible())
		bench_imagery(rutted);
	bench_must(gpu_create(&(struct gpu_params){.draws = true}, &gpu));
	struct bar bar = {0};
	static struct rig a, b;
	open_rig(&a, rutted, NULL, SLOTS);
	if (asked(only, "effects"))
		effects_table(&a, &bar);
	if (asked(only, "levels"))
		levels_table(&a);
	if (asked(only, "imagery") && store_imagery_possible())
		imagery_table(&a);
	if (only == NULL)
		hardware_table(&a);
	if (asked(only, "slots")) {
		open_rig(&b, rutted, NULL, FEW_SLOTS);
		slots_table(&a, &b);
		close_rig(&b);
	}
	close_rig(&a);
	if (asked(only, "deforming")) {
		open_rig(&a, plain, overlays[0], SLOTS);
		open_rig(&b, plain, overlays[1], SLOTS);
		deform_table(&a, &b, &bar);
		close_rig(&b);
		close_rig(&a);
	}
	if (only == NULL)
		print_bar(&bar);
	bench_record_end(gpu_info(gpu)->renderer);
	gpu_destroy(gpu);
	return 0;
}
