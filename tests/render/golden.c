/*
 * Golden pictures: one small world, a picture for each effect, held to a PNG kept beside this file that somebody has looked
 * at. Made on llvmpipe; elsewhere more is allowed, since edges and filters are the driver's. What does not hold is left in a
 * folder: the picture, and how far off each pixel is. GOLDEN: the folder of PNGs; GOLDEN_WRITE: a folder to write new ones to,
 * nothing is then held to anything. Skipped without GL.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../gpu/staged.h"
#include "../support/program.h"
#include "../support/skip.h"
#include "soil/carried.h"
#include "render/internal.h"

#define WIDTH 320
#define HEIGHT 180
#define PIXELS (WIDTH * HEIGHT)
#define CELLS 64
#define POSTS (CELLS + 1)
#define SIDE 257 /* posts of the world */
#define SLOTS 48
#define FAR_OFF 12 /* of 255: a pixel that differs by more is another one */

#define TEXTURE EFFECT_BIT(EFFECT_TEXTURE)
#define DETAIL EFFECT_BIT(EFFECT_DETAIL)
#define FOG EFFECT_BIT(EFFECT_FOG)
#define SKY EFFECT_BIT(EFFECT_SKY)
#define GEOMORPH EFFECT_BIT(EFFECT_GEOMORPH)
#define SKIRTS EFFECT_BIT(EFFECT_SKIRTS)
#define SPLAT EFFECT_BIT(EFFECT_SPLAT)
#define OBJECTS EFFECT_BIT(EFFECT_OBJECTS)
#define SHADOW EFFECT_BIT(EFFECT_SHADOW)

#define DEGREES (M_PI / 180)

static const struct extent extent = {SIDE, SIDE, 8, CELLS};
/* The tile with the rut: 8 m, posts 0.125 m apart. */
static const struct tile rutted = {-6, 75, 65};
#define MIDDLE_X 604.0
#define MIDDLE_Y 524.0

static struct gpu *gpu; /* NULL: no GL */
static char left[] = "/tmp/furrow-golden-XXXXXX"; /* where pictures that do not hold are left */
static bool leaves;
static double heights[SIDE][SIDE]; /* metres; NaN: nodata */

/* --- the world: hills and a mountain, a hole, a rut --- */

static double clamped(double low, double high, double x)
{
	return fmin(fmax(x, low), high);
}

/* -1 .. 1, of whole numbers alone. */
static double strewn(int64_t i, int64_t j)
{
	uint32_t h = (uint32_t)i * 2654435761u ^ (uint32_t)j * 2246822519u;
	h ^= h >> 15;
	h *= 2654435761u;
	h ^= h >> 13;
	return (double)(h >> 8) * 0x1p-23 - 1;
}

static void fill_heights(void)
{
	for (int j = 0; j < SIDE; j++)
		for (int i = 0; i < SIDE; i++) {
			double x = i * extent.spacing, y = j * extent.spacing, from = hypot(x - MIDDLE_X, y - MIDDLE_Y);
			double up = hypot(x - 1150, y - 1650) / 600, beside = hypot(x - 1750, y - 1300) / 260;
			double rough = 0.1 + 9 * clamped(0, 1, (from - 100) / 300) * clamped(0.15, 1, (1500 - x - y) / 500);
			double height = 100 + 9 * sin(x / 71) * cos(y / 53) * clamped(0.15, 1, from / 250) + rough * strewn(i, j);
			heights[j][i] = height + 800 * exp(-up * up) + 350 * exp(-beside * beside);
			if (hypot((x - 710) / 70, (y - 700) / 60) < 1)
				heights[j][i] = (double)NAN;
		}
}

/* On the triangles between the posts, each cell parted from south-west to north-east; metres of the world. */
static double height_at(double x, double y)
{
	int i = (int)clamped(0, SIDE - 2, floor(x / extent.spacing)), j = (int)clamped(0, SIDE - 2, floor(y / extent.spacing));
	double u = x / extent.spacing - i, v = y / extent.spacing - j;
	double sw = heights[j][i], ne = heights[j + 1][i + 1];
	if (u == 0 && v == 0)
		return sw;
	return u > v ? sw + u * (heights[j][i + 1] - sw) + v * (ne - heights[j][i + 1]) :
		       sw + v * (heights[j + 1][i] - sw) + u * (ne - heights[j + 1][i]);
}

/* How far a place is from the rut's middle, and along it; metres. */
static double beside_rut(double x, double y)
{
	return x - MIDDLE_X - 0.5 * sin((y - MIDDLE_Y) * 0.7);
}

static double offset_at(double x, double y)
{
	double across = fabs(beside_rut(x, y)), end = clamped(0, 1, (3.5 - fabs(y - MIDDLE_Y)) / 0.4);
	double grousers = 0.02 * (fabs(fmod(y * 4, 2) - 1) < 0.5);
	double deep = across < 0.31 ? -0.14 + grousers : across < 0.56 ? 0.045 : 0;
	return deep * end;
}

static uint8_t dirt_at(double x, double y)
{
	double across = fabs(beside_rut(x, y)), end = clamped(0, 1, (3.5 - fabs(y - MIDDLE_Y)) / 0.4);
	return (uint8_t)(across < 0.4 ? 255 * end : 0);
}

static uint8_t class_at(double x, double y)
{
	return (uint8_t)(hypot(x - 700, y - 700) < 130 ? 1 : y - 0.6 * x > 560 ? 2 : 0);
}

/* --- what is resident, for render_select --- */

struct golden {
	const char *name;
	uint64_t effects;
	double eye[3], target[3]; /* metres; up is above the ground there */
	double mean;              /* of 255: what it may be off by */
	double share;             /* of the pixels may be far off */
	bool deformed, dirt, replaces;
	int samples;
	double pixel_error;
	enum scene_body body;
	double azimuth, height; /* of the sun; height 0: as usual */
	enum render_layer_kind layer;
	bool bucket, grains; /* in place of the wheel and the ball: a full bucket; a wheel, and what it throws */
};

struct shown {
	const struct golden *golden;
	struct gpu_slots *slots;
	uint64_t keys[SLOTS];
	uint32_t count;
	double errors[3][4][4];
};

static bool is_above_rut(struct tile tile)
{
	return tile_key(tile_ancestor(rutted, tile.level)) == tile_key(tile);
}

static bool bounds(void *user, struct tile tile, double *low, double *high)
{
	const struct shown *shown = user;
	struct tile top = tile.level < 0 ? tile_ancestor(tile, 0) : tile;
	int side = CELLS << top.level;
	*low = INFINITY;
	*high = -INFINITY;
	for (int j = (int)top.y * side; j <= (int)(top.y + 1) * side && j < SIDE; j++)
		for (int i = (int)top.x * side; i <= (int)(top.x + 1) * side && i < SIDE; i++) {
			*low = fmin(*low, heights[j][i] - 0.2);
			*high = fmax(*high, heights[j][i] + 0.1);
		}
	return tile.level >= 0 || (shown->golden->deformed && is_above_rut(tile));
}

static bool resident(void *user, struct tile tile, uint32_t *slot)
{
	struct shown *shown = user;
	for (*slot = 0; *slot < shown->count; ++*slot)
		if (shown->keys[*slot] == tile_key(tile))
			return true;
	return false;
}

static bool divisible(void *user, struct tile tile)
{
	const struct shown *shown = user;
	return tile.level > 0 || (shown->golden->deformed && tile.level > rutted.level && is_above_rut(tile));
}

/* The most that the tile's bilinear surface is off a post it leaves out. */
static double error_of(void *user, struct tile tile)
{
	struct shown *shown = user;
	if (tile.level <= 0)
		return 0;
	double *error = &shown->errors[tile.level][tile.y][tile.x];
	int step = 1 << tile.level, side = CELLS * step;
	for (int j = (int)tile.y * side; *error == 0 && j < (int)(tile.y + 1) * side; j++)
		for (int i = (int)tile.x * side; i < (int)(tile.x + 1) * side; i++) {
			int x = i / step * step, y = j / step * step;
			double u = (double)(i - x) / step, v = (double)(j - y) / step;
			double south = heights[y][x] * (1 - u) + heights[y][x + step] * u;
			double north = heights[y + step][x] * (1 - u) + heights[y + step][x + step] * u;
			*error = fmax(*error, fabs(south * (1 - v) + north * v - heights[j][i]));
		}
	return *error;
}

static void must(enum status status)
{
	if (status != STATUS_OK)
		fail_msg("%s", failure_message());
}

static void load(struct shown *shown, struct tile tile)
{
	static int32_t base[POSTS][POSTS], offset[POSTS][POSTS];
	static uint8_t dirt[POSTS][POSTS], classes[POSTS][POSTS];
	struct gpu_staging *staging;
	double spacing = extent_spacing(&extent, tile.level);
	bool deformed = shown->golden->deformed && is_above_rut(tile);
	assert_true(shown->count < SLOTS);
	for (int j = 0; j < POSTS; j++)
		for (int i = 0; i < POSTS; i++) {
			double x = (tile.x * (double)CELLS + i) * spacing, y = (tile.y * (double)CELLS + j) * spacing;
			base[j][i] = lattice_base_relative(height_at(x, y), 0);
			offset[j][i] = (int32_t)lattice_offset(offset_at(x, y));
			dirt[j][i] = dirt_at(x, y);
			classes[j][i] = class_at(x, y);
		}
	must(staged_upload_base(gpu, shown->slots, CELLS, shown->count, *base));
	if (deformed)
		must(staged_upload_deform(gpu, shown->slots, CELLS, shown->count, *offset, shown->golden->dirt ? *dirt : NULL));
	must(staged_from(gpu, classes, sizeof classes, &staging));
	must(gpu_slots_upload_classes(shown->slots, shown->count, staging, STAGED_AT));
	gpu_staging_destroy(staging);
	shown->keys[shown->count++] = tile_key(tile);
}

static void select_all(struct shown *shown, const struct render_view *view, struct render_selection *selection)
{
	const struct render_source source = {shown, bounds, resident, divisible, error_of, NULL};
	/* What stands in is no part of a complete picture, so that nobody wants it. */
	for (uint32_t i = 0; shown->golden->replaces && i < 4; i++)
		load(shown, (struct tile){1, i % 2, i / 2});
	for (;;) {
		size_t loaded = 0;
		render_select(&extent, view, &source, selection);
		for (size_t i = 0; i < selection->wanted_count; i++) {
			struct tile tile = tile_from_key(selection->wanted[i]);
			bool missing = shown->golden->replaces && tile.level == 0 && (tile.x + tile.y) % 2 > 0;
			if (!missing)
				load(shown, tile);
			loaded += !missing;
		}
		if (loaded == 0)
			break;
	}
}

/* --- drawing --- */

/* A bucket of plates, 0.8 x 1 x 0.5 m, open in front and above: its corners by plate. */
#define PLATES 4
static float bucket_corners[8 * PLATES][3];
static uint32_t bucket_triangles[12 * PLATES][3];
static const struct soil_mesh bucket = {.vertices = bucket_corners, .triangles = bucket_triangles, .vertex_count = 8 * PLATES, .triangle_count = 12 * PLATES, .low = {-0.4, -0.5, -0.25}, .high = {0.4, 0.5, 0.25}};

static void make_bucket(void)
{
	static const float plates[PLATES][6] = {{-0.4f, 0.4f, -0.5f, 0.5f, -0.25f, -0.22f}, {-0.4f, -0.37f, -0.5f, 0.5f, -0.25f, 0.25f},
						{-0.4f, 0.4f, -0.5f, -0.47f, -0.25f, 0.25f}, {-0.4f, 0.4f, 0.47f, 0.5f, -0.25f, 0.25f}};
	static const uint32_t sides[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
	for (uint32_t p = 0; p < PLATES; p++) {
		for (int i = 0; i < 8; i++)
			for (int k = 0; k < 3; k++)
				bucket_corners[8 * p + (uint32_t)i][k] = plates[p][2 * k + (i >> k & 1)];
		for (int i = 0; i < 12; i++)
			for (int k = 0; k < 3; k++)
				bucket_triangles[12 * p + (uint32_t)i][k] = 8 * p + sides[i][k];
	}
}

static const struct scene_object objects[3] = {
	{.name = "wheel", .shape = {.kind = SOIL_WHEEL, .radius = 0.45, .width = 0.5, .grousers = 14, .grouser_height = 0.05, .grouser_thickness = 0.07}},
	{.name = "ball", .shape = {.kind = SOIL_SPHERE, .radius = 0.5}},
	{.name = "bucket", .shape = {.kind = SOIL_MESH, .mesh = &bucket}},
};

static void place_objects(struct render *render)
{
	struct render_object placed[2] = {
		{.object = 0, .at = {MIDDLE_X + 0.3, MIDDLE_Y + 1, 0.35}, .yaw = 70 * DEGREES, .turned = 0.2},
		{.object = 1, .at = {MIDDLE_X + 2.6, MIDDLE_Y - 0.6, 0.47}, .yaw = 0.3, .turned = 0.8},
	};
	for (int i = 0; i < 2; i++)
		placed[i].at[2] += height_at(placed[i].at[0], placed[i].at[1]);
	render_set_objects(render, placed, 2);
}

/* A bucket in the air, yawed by -35 degrees, with a heap that falls from the back by 30 degrees. */
static void place_bucket(struct render *render)
{
	const double x = MIDDLE_X + 0.8, y = MIDDLE_Y + 0.3, z = height_at(x, y) + 0.6, yaw = -35 * DEGREES, spacing = 0.04;
	const struct soil_pose pose = {.x = lattice_offset(x), .y = lattice_offset(y), .z = lattice_offset(z), .yaw = yaw};
	const struct render_object placed = {.object = 2, .at = {x, y, z}, .yaw = yaw};
	struct soil_carried *carried;
	must(soil_carried_create(&objects[2].shape, spacing, &carried));
	soil_carried_place(carried, &pose);
	for (int row = 0; row < carried->side; row++)
		for (int column = 0; column < carried->side; column++) {
			const double along = (column - carried->half) * spacing, across = (row - carried->half) * spacing;
			const int32_t top = carried->tops[row * carried->side + column];
			const double soil = 0.24 - 0.577 * (along + 0.35) - 0.4 * across * across - lattice_offset_metres(top == CARRIED_OPEN ? 0 : top);
			if (top != CARRIED_OPEN && soil > 0)
				carried->amounts[row * carried->side + column] = (int32_t)(lattice_offset(soil) * soil_carried_shares(carried)[row * carried->side + column] / 64);
		}
	render_set_objects(render, &placed, 1);
	must(render_set_heaps(render, &(struct render_heap){.at = {x, y, z}, .ground = z - 0.6, .heading = yaw, .spacing = spacing, .side = carried->side, .amounts = carried->amounts, .tops = carried->tops, .shares = soil_carried_shares(carried)}, 1));
	soil_carried_destroy(carried);
}

#define GRAINS 600

/* A wheel that spins, and grains on their parabolas behind it. */
static void place_wheel_and_grains(struct render *render)
{
	static struct render_grain grains[GRAINS];
	const double x = MIDDLE_X + 0.4, y = MIDDLE_Y + 1, low = height_at(x, y) - 0.1;
	const struct render_object placed = {.object = 0, .at = {x, y, low + 0.45}, .yaw = 80 * DEGREES, .turned = 0.2};
	for (int i = 0; i < GRAINS; i++) {
		const double time = 0.6 * (i + 0.5) / GRAINS, angle = (35 + 8 * strewn(i, 1)) * DEGREES, speed = 4 + 0.4 * strewn(i, 2), aside = 0.22 * strewn(i, 3) + 0.3 * time * strewn(i, 4);
		const double back = 0.2 + speed * cos(angle) * time, up = 0.1 + speed * sin(angle) * time - 4.905 * time * time;
		const double c = cos(80 * DEGREES), s = sin(80 * DEGREES);
		grains[i] = (struct render_grain){{x - c * back - s * aside, y - s * back + c * aside, low + up}, 0.012 + 0.006 * strewn(i, 5), (uint32_t)i};
	}
	render_set_objects(render, &placed, 1);
	render_set_grains(render, grains, GRAINS);
}

static void draw(const struct golden *golden, uint8_t *pixels)
{
	static struct render_selection selection;
	const struct scene soils = {.soil_count = 3, .soil_names = {"upland_loam", "dry_sand", "clayey"}};
	struct shown shown = {.golden = golden};
	struct render *render;
	struct render_view view;
	struct scene_light light = scene_light_default();
	light.body = golden->body;
	if (golden->height > 0) {
		light.azimuth = golden->azimuth;
		light.height = golden->height;
	}
	must(gpu_slots_create(gpu, CELLS, SLOTS, golden->dirt ? PLANE_BIT(PLANE_DISTURBANCE) : 0, &shown.slots));
	const struct render_params params = {
		.gpu = gpu, .slots = shown.slots, .extent = &extent, .low = 0, .high = 820, .width = WIDTH, .height = HEIGHT,
		.effects = golden->effects, .disturbance = golden->dirt, .light = &light, .soils = &soils, .pixel_error = golden->pixel_error,
		.samples = golden->samples, .objects = objects, .object_count = golden->bucket ? 3 : 2, .heaps = golden->bucket, .grains = golden->grains ? GRAINS : 0, .layers = golden->layer != RENDER_NATURAL,
	};
	must(render_create(&params, &render));
	struct render_camera camera = {.fov = 0.9};
	memcpy(camera.eye, golden->eye, sizeof camera.eye);
	memcpy(camera.target, golden->target, sizeof camera.target);
	camera.eye[2] += height_at(camera.eye[0], camera.eye[1]);
	camera.target[2] += height_at(camera.target[0], camera.target[1]);
	render_view(render, &camera, &view);
	select_all(&shown, &view, &selection);
	(golden->bucket ? place_bucket : golden->grains ? place_wheel_and_grains : place_objects)(render);
	if (golden->layer != RENDER_NATURAL)
		render_show_layer(render, &(struct render_layer){golden->layer, -0.2, 0.2});
	must(render_frame(render, &camera, &selection));
	gpu_texture_read(render->screen->colour, 0, (struct gpu_rect){0, 0, WIDTH, HEIGHT}, pixels);
	must(gpu_check(gpu, "reading the picture back"));
	render_destroy(render);
	gpu_slots_destroy(shown.slots);
}

/* --- comparing --- */

/* RGB, the highest row first. False: it cannot be read. */
static bool read_png(const char *path, uint8_t *pixels)
{
	png_image image = {.version = PNG_IMAGE_VERSION};
	if (!png_image_begin_read_from_file(&image, path))
		return false;
	image.format = PNG_FORMAT_RGB;
	bool fits = image.width == WIDTH && image.height == HEIGHT;
	bool read = fits && png_image_finish_read(&image, NULL, pixels, 0, NULL);
	png_image_free(&image);
	return read;
}

/* Small, as these are kept. */
static void write_golden(const char *folder, const char *name, const uint8_t *pixels)
{
	static uint8_t rows[HEIGHT][WIDTH][3];
	char path[512];
	snprintf(path, sizeof path, "%s/%s.png", folder, name);
	for (int i = 0; i < PIXELS; i++)
		memcpy(rows[HEIGHT - 1 - i / WIDTH][i % WIDTH], pixels + 4 * i, 3);
	png_image image = {.version = PNG_IMAGE_VERSION, .width = WIDTH, .height = HEIGHT, .format = PNG_FORMAT_RGB};
	if (!png_image_write_to_file(&image, path, 0, rows, 0, NULL))
		fail_msg("%s: %s", path, image.message);
}

/* Eight times how far off each pixel is, at its place. */
static void leave_difference(const char *name, const uint8_t *golden, const uint8_t *pixels, char path[96])
{
	static uint8_t apart[4 * PIXELS];
	for (int i = 0; i < PIXELS; i++)
		for (int c = 0; c < 3; c++) {
			int off = 8 * abs(golden[3 * ((HEIGHT - 1 - i / WIDTH) * WIDTH + i % WIDTH) + c] - pixels[4 * i + c]);
			apart[4 * i + c] = (uint8_t)(off > 255 ? 255 : off);
		}
	snprintf(path, 96, "%s/%s-difference.png", left, name);
	must(chart_png_write(path, apart, WIDTH, HEIGHT));
}

static void compare(const struct golden *golden, const uint8_t *kept, const uint8_t *pixels)
{
	double sum = 0;
	int far = 0;
	for (int i = 0; i < PIXELS; i++) {
		int most = 0;
		for (int c = 0; c < 3; c++) {
			int off = abs(kept[3 * ((HEIGHT - 1 - i / WIDTH) * WIDTH + i % WIDTH) + c] - pixels[4 * i + c]);
			sum += off;
			most = off > most ? off : most;
		}
		far += most > FAR_OFF;
	}
	double mean = sum / (3.0 * PIXELS), share = far / (double)PIXELS, wider = gpu_info(gpu)->software ? 1 : 2;
	print_message("%s: mean difference %.3f, %.2f %% far off\n", golden->name, mean, 100 * share);
	if (mean <= wider * golden->mean && share <= wider * golden->share)
		return;
	char drawn[96], difference[96];
	if (!leaves && mkdtemp(left) == NULL)
		fail_msg("%s: cannot be made", left);
	leaves = true;
	snprintf(drawn, sizeof drawn, "%s/%s.png", left, golden->name);
	must(chart_png_write(drawn, pixels, WIDTH, HEIGHT));
	leave_difference(golden->name, kept, pixels, difference);
	fail_msg("%s: mean difference %.3f, may be %.3f; %.2f %% of pixels are far off, may be %.2f %%; drawn: %s, 8 x the difference: %s",
		 golden->name, mean, wider * golden->mean, 100 * share, 100 * wider * golden->share, drawn, difference);
}

static void is_as_its_golden(void **state)
{
	static uint8_t pixels[4 * PIXELS], kept[3 * PIXELS];
	const struct golden *golden = *state;
	const char *folder = getenv("GOLDEN"), *write = getenv("GOLDEN_WRITE");
	char path[512];
	if (gpu == NULL)
		skip_since("no GL");
	if (gpu_info(gpu)->samples_most < (uint32_t)golden->samples)
		skip_since(SKIP_ELSEWHERE "the driver has no pictures with so many samples");
	draw(golden, pixels);
	if (write != NULL) {
		write_golden(write, golden->name, pixels);
		return;
	}
	assert_non_null(folder);
	snprintf(path, sizeof path, "%s/%s.png", folder, golden->name);
	if (!read_png(path, kept))
		fail_msg("%s: no picture of %d x %d can be read there", path, WIDTH, HEIGHT);
	compare(golden, kept, pixels);
}

/* --- the pictures --- */

#define ALL (TEXTURE | DETAIL | FOG | SKY | GEOMORPH | SKIRTS)
/* From a hill to the mountain; beside the rut; over rough ground. */
#define WIDE .eye = {420, 330, 70}, .target = {1050, 1250, -280}
#define NEAR .eye = {601.2, 519.8, 1.9}, .target = {604.3, 524.6, 0}
#define BESIDE .eye = {603.4, 521.6, 1.2}, .target = {605.3, 524.6, 0.25}
#define CLOSE .eye = {602.8, 523.2, 0.8}, .target = {604.6, 524.9, 0.45}
#define RUT .eye = {603.1, 521.5, 1.2}, .target = {604.4, 524.4, 0}
#define FULL .eye = {606.2, 523.7, 1.55}, .target = {604.8, 524.3, 0.62}
#define BEHIND .eye = {602.4, 522.7, 1.0}, .target = {604.4, 524.4, 0.45}
#define ROUGH .eye = {200, 180, 45}, .target = {420, 420, -10}
#define SEAM .eye = {470, 110, 10}, .target = {520, 190, -6}
#define TIGHT .mean = 0.5, .share = 0.004

static const struct golden goldens[] = {
	{"none", 0, WIDE, TIGHT},
	{"texture", TEXTURE, WIDE, .mean = 0.25, .share = 0.002},
	{"detail", TEXTURE | DETAIL, NEAR, TIGHT},
	{"fog", TEXTURE | FOG, WIDE, TIGHT},
	{"sky", SKY, WIDE, TIGHT},
	{"geomorph", GEOMORPH, ROUGH, TIGHT},
	{"skirts", SKIRTS, SEAM, TIGHT, .replaces = true},
	{"splat", TEXTURE | SPLAT, WIDE, TIGHT},
	{"antialias", OBJECTS | SKY, CLOSE, TIGHT, .samples = 4},
	{"objects", OBJECTS, BESIDE, TIGHT, .deformed = true},
	{"shadow", OBJECTS | SHADOW, BESIDE, TIGHT, .deformed = true},
	{"pixel_error", SKIRTS | GEOMORPH, ROUGH, TIGHT, .pixel_error = 12},
	{"mars", ALL, WIDE, TIGHT, .body = SCENE_MARS},
	{"moon", ALL, WIDE, TIGHT, .body = SCENE_MOON},
	{"evening", ALL, WIDE, TIGHT, .azimuth = 270 * DEGREES, .height = 8 * DEGREES},
	{"rut", TEXTURE | DETAIL, RUT, TIGHT, .deformed = true, .dirt = true, .azimuth = 60 * DEGREES, .height = 30 * DEGREES},
	{"bucket", TEXTURE | DETAIL | SKY | OBJECTS | SHADOW, FULL, TIGHT, .deformed = true, .bucket = true, .azimuth = 200 * DEGREES, .height = 40 * DEGREES},
	{"bucket_splat", TEXTURE | SPLAT | FOG | OBJECTS, FULL, TIGHT, .bucket = true},
	{"grains", TEXTURE | DETAIL | SKY | OBJECTS | SHADOW, BEHIND, TIGHT, .deformed = true, .grains = true, .azimuth = 250 * DEGREES, .height = 40 * DEGREES},
	{"offsets", 0, NEAR, TIGHT, .deformed = true, .layer = RENDER_OFFSETS},
};
#define GOLDENS (sizeof goldens / sizeof *goldens)

static int open_gpu(void **state)
{
	fill_heights();
	make_bucket();
	enum status status = gpu_create(&(struct gpu_params){.draws = true}, &gpu);
	if (status == STATUS_NO_GL) {
		print_message("%s\n", failure_message());
		gpu = NULL;
		return 0;
	}
	return status == STATUS_OK ? 0 : -1;
}

static int close_gpu(void **state)
{
	gpu_destroy(gpu);
	return 0;
}

TEST_PROGRAM(golden)
{
	struct CMUnitTest tests[GOLDENS];
	for (size_t i = 0; i < GOLDENS; i++)
		tests[i] = (struct CMUnitTest){goldens[i].name, is_as_its_golden, NULL, NULL, (void *)(uintptr_t)&goldens[i]};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
