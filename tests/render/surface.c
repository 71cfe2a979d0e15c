/* What the ground and the sky look like: by body, by the sun, by the soil map, by what was pressed. Skipped without GL. */
#include "gpu_rig.h"
#include "render/internal.h"
#include "../support/program.h"

#define WIDTH 160
#define HEIGHT 90
#define CELLS 64
#define POSTS (CELLS + 1)
#define TEXTURE EFFECT_BIT(EFFECT_TEXTURE)
#define DETAIL EFFECT_BIT(EFFECT_DETAIL)
#define SKY EFFECT_BIT(EFFECT_SKY)
#define FOG EFFECT_BIT(EFFECT_FOG)
#define SPLAT EFFECT_BIT(EFFECT_SPLAT)

static const struct extent extent = {65, 65, 4, CELLS};

/* One tile of 256 m, as a test makes it. */
struct shot {
	uint64_t effects;
	struct scene_light light;
	double (*height)(double x, double y);
	double low, high;       /* as the whole terrain is said to be */
	double eye[3], target[3];
	const struct scene *soils;
	bool one_soil;
	uint8_t (*soil)(int x, int y);
	int32_t (*offset)(int x, int y);
	uint8_t (*dirt)(int x, int y);
};

static uint8_t pixels[HEIGHT][WIDTH][4];

static struct scene_light light_of(enum scene_body body)
{
	struct scene_light light = scene_light_default();
	light.body = body;
	return light;
}

static void take(const struct shot *shot)
{
	static int32_t posts[POSTS][POSTS], offset[POSTS][POSTS];
	static uint8_t classes[POSTS][POSTS], dirt[POSTS][POSTS];
	static struct render_selection selection;
	struct gpu_slots *slots;
	struct gpu_staging *staging;
	struct render *render;
	for (int y = 0; y < POSTS; y++)
		for (int x = 0; x < POSTS; x++) {
			posts[y][x] = lattice_base_relative(shot->height(x * extent.spacing, y * extent.spacing), 0);
			classes[y][x] = shot->soil != NULL ? shot->soil(x, y) : 0;
			offset[y][x] = shot->offset != NULL ? shot->offset(x, y) : 0;
			dirt[y][x] = shot->dirt != NULL ? shot->dirt(x, y) : 0;
		}
	assert_ok(gpu_slots_create(gpu, CELLS, 1, shot->dirt != NULL ? PLANE_BIT(PLANE_DISTURBANCE) : 0, &slots));
	assert_ok(staged_upload_base(gpu, slots, CELLS, 0, *posts));
	if (shot->offset != NULL)
		assert_ok(staged_upload_deform(gpu, slots, CELLS, 0, *offset, *dirt));
	assert_ok(staged_from(gpu, classes, sizeof classes, &staging));
	assert_ok(gpu_slots_upload_classes(slots, 0, staging, STAGED_AT));
	gpu_staging_destroy(staging);
	assert_ok(render_create(&(struct render_params){
		.gpu = gpu, .slots = slots, .extent = &extent, .low = shot->low, .high = shot->high, .width = WIDTH, .height = HEIGHT,
		.effects = shot->effects, .disturbance = shot->dirt != NULL, .light = &shot->light, .soils = shot->soils, .one_soil = shot->one_soil,
	}, &render));
	selection.draw_count = 1;
	selection.draws[0] = (struct render_draw){.quadrants = 15, .finest = true, .low = shot->low, .high = shot->high};
	struct render_camera camera = {.fov = 0.9};
	memcpy(camera.eye, shot->eye, sizeof camera.eye);
	memcpy(camera.target, shot->target, sizeof camera.target);
	assert_ok(render_frame(render, &camera, &selection));
	gpu_texture_read(render->screen->colour, 0, (struct gpu_rect){0, 0, WIDTH, HEIGHT}, pixels);
	render_destroy(render);
	gpu_slots_destroy(slots);
}

/* Of a part of the picture. */
static void mean_of(int x0, int y0, int x1, int y1, double rgb[3])
{
	rgb[0] = rgb[1] = rgb[2] = 0;
	for (int y = y0; y < y1; y++)
		for (int x = x0; x < x1; x++)
			for (int c = 0; c < 3; c++)
				rgb[c] += pixels[y][x][c];
	for (int c = 0; c < 3; c++)
		rgb[c] /= (x1 - x0) * (y1 - y0);
}

static double brightness(int x0, int y0, int x1, int y1)
{
	double rgb[3];
	mean_of(x0, y0, x1, y1, rgb);
	return 0.3 * rgb[0] + 0.6 * rgb[1] + 0.1 * rgb[2];
}

static double flat(double x, double y)
{
	return 100;
}

static double hills(double x, double y)
{
	return 100 + 25 * sin(x / 23) * cos(y / 31);
}

/* Straight down from 150 m: the whole picture is ground; 0.9 rad are 145 m high, 257 m wide. */
#define DOWN .low = 0, .high = 200, .eye = {128, 128, 250}, .target = {128, 128.001, 100}
#define UP .low = 0, .high = 200, .eye = {128, 128, 150}, .target = {20, 200, 250}

static void no_green_on_mars_and_grass_on_earth(void **state)
{
	need_gpu();
	double rgb[3];
	take(&(struct shot){.effects = TEXTURE | DETAIL, .light = light_of(SCENE_EARTH), .height = flat, DOWN});
	mean_of(0, 0, WIDTH, HEIGHT, rgb);
	assert_true(rgb[1] > rgb[0] && rgb[1] > rgb[2] + 20);
	const uint64_t all[] = {0, TEXTURE, TEXTURE | DETAIL, TEXTURE | FOG};
	for (int i = 0; i < 4; i++) {
		take(&(struct shot){.effects = all[i], .light = light_of(SCENE_MARS), .height = i % 2 ? flat : hills, DOWN});
		mean_of(0, 0, WIDTH, HEIGHT, rgb);
		assert_true(rgb[0] > 60 && rgb[1] < 0.85 * rgb[0] && rgb[2] < 0.9 * rgb[1]);
		for (int k = 0; k < WIDTH * HEIGHT; k++)
			assert_true(pixels[k / WIDTH][k % WIDTH][1] <= pixels[k / WIDTH][k % WIDTH][0] + 1);
	}
}

static void moon_is_grey_under_a_black_sky(void **state)
{
	need_gpu();
	double rgb[3];
	take(&(struct shot){.effects = TEXTURE | DETAIL, .light = light_of(SCENE_MOON), .height = hills, DOWN});
	mean_of(0, 0, WIDTH, HEIGHT, rgb);
	assert_true(rgb[1] > 40 && fabs(rgb[0] - rgb[1]) < 8 && fabs(rgb[1] - rgb[2]) < 8);
	int lit = 0;
	take(&(struct shot){.effects = TEXTURE | SKY, .light = light_of(SCENE_MOON), .height = flat, UP});
	for (int y = 60; y < HEIGHT; y++)
		for (int x = 0; x < WIDTH; x++)
			lit += pixels[y][x][0] + pixels[y][x][1] + pixels[y][x][2] > 6;
	assert_true(lit < 100); /* stars */
	/* Fog is of air. */
	static uint8_t clear[HEIGHT][WIDTH][4];
	const struct shot far = {.effects = TEXTURE, .light = light_of(SCENE_MOON), .height = hills, .low = 0, .high = 200,
				 .eye = {5, 5, 130}, .target = {200, 200, 90}};
	struct shot fogged = far;
	fogged.effects |= FOG;
	take(&far);
	memcpy(clear, pixels, sizeof clear);
	take(&fogged);
	int apart = 0; /* but for dither */
	for (int i = 0; i < WIDTH * HEIGHT; i++)
		apart += abs(pixels[i / WIDTH][i % WIDTH][0] - clear[i / WIDTH][i % WIDTH][0]) > 2;
	assert_int_equal(apart, 0);
}

static void each_sky_is_its_own(void **state)
{
	need_gpu();
	double earth[3], mars[3];
	take(&(struct shot){.effects = SKY, .light = light_of(SCENE_EARTH), .height = flat, UP});
	mean_of(0, 60, WIDTH, HEIGHT, earth);
	take(&(struct shot){.effects = SKY, .light = light_of(SCENE_MARS), .height = flat, UP});
	mean_of(0, 60, WIDTH, HEIGHT, mars);
	assert_true(earth[2] > earth[0] + 20);
	assert_true(mars[0] > mars[2] + 20);
}

static double east_side(double x, double y)
{
	return x > 128 ? 228 - 0.4 * x : 100 + 0.6 * x; /* a ridge from south to north */
}

static void the_sun_turns_the_shading(void **state)
{
	need_gpu();
	struct shot shot = {.light = light_of(SCENE_EARTH), .height = east_side, DOWN};
	shot.low = 90;
	double west[2], east[2];
	for (int i = 0; i < 2; i++) {
		shot.light.azimuth = i == 0 ? M_PI / 2 : 3 * M_PI / 2;
		take(&shot);
		west[i] = brightness(20, 10, 60, 80);
		east[i] = brightness(100, 10, 140, 80);
	}
	assert_true(east[0] > west[0] + 20 && west[1] > east[1] + 20);
	/* Higher is brighter on level ground; low it is redder; a colour is what it says. */
	double high[3], low[3], green[3];
	shot.height = flat;
	shot.light.height = 60 * M_PI / 180;
	take(&shot);
	mean_of(0, 0, WIDTH, HEIGHT, high);
	shot.light.height = 6 * M_PI / 180;
	take(&shot);
	mean_of(0, 0, WIDTH, HEIGHT, low);
	shot.light.coloured = true;
	shot.light.colour[1] = 2;
	shot.light.height = 60 * M_PI / 180;
	take(&shot);
	mean_of(0, 0, WIDTH, HEIGHT, green);
	assert_true(high[1] > low[1] + 20);
	assert_true(green[1] > 1.5 * green[0]);
	struct picture_params noon, evening;
	render_body_fill(&(struct scene_light){.height = 60 * M_PI / 180}, NULL, &noon);
	render_body_fill(&(struct scene_light){.height = 2 * M_PI / 180}, NULL, &evening);
	assert_true(evening.sunlight[2] / evening.sunlight[0] < 0.4f * noon.sunlight[2] / noon.sunlight[0]);
}

static double slope_up(double x, double y)
{
	return 10 * x / 256;
}

static void snow_lies_only_high(void **state)
{
	need_gpu();
	/* The same ground, as the lowest and as the highest of a mountain. */
	double rgb[3], up[3];
	struct shot shot = {.effects = TEXTURE, .light = light_of(SCENE_EARTH), .height = slope_up, DOWN};
	shot.eye[2] = 150;
	shot.target[2] = 0;
	shot.low = -800;
	shot.high = 2400;
	take(&shot);
	mean_of(0, 0, WIDTH, HEIGHT, rgb);
	shot.low = -3000;
	shot.high = 20;
	take(&shot);
	mean_of(0, 0, WIDTH, HEIGHT, up);
	assert_true(up[2] > 150 && up[2] > up[0] - 10);
	assert_true(rgb[2] < 0.6 * up[2]);
	/* Nor where the highest is no mountain, nor on Mars. */
	shot.low = -150;
	take(&shot);
	mean_of(0, 0, WIDTH, HEIGHT, rgb);
	assert_true(rgb[2] < 0.6 * up[2]);
	shot.low = -3000;
	shot.light = light_of(SCENE_MARS);
	take(&shot);
	mean_of(0, 0, WIDTH, HEIGHT, rgb);
	assert_true(rgb[2] < 0.7 * rgb[0]);
}

static uint8_t a_square(int x, int y)
{
	return x >= 24 && x < 40 && y >= 24 && y < 40;
}

static void each_class_is_shown_where_it_is(void **state)
{
	need_gpu();
	struct scene soils = {.soil_count = 2, .soil_names = {"mud", "dry_sand"}};
	struct shot shot = {.effects = TEXTURE | DETAIL | SPLAT, .light = light_of(SCENE_EARTH), .height = flat, .soils = &soils,
			    .soil = a_square, DOWN};
	take(&shot);
	/* 1.6 m a pixel: 128 m is the picture's middle, sand 32 m around it. */
	double sand = brightness(64, 29, 96, 61), mud = fmax(brightness(0, 0, 50, HEIGHT), brightness(110, 0, WIDTH, HEIGHT));
	assert_true(sand > 1.6 * mud);
	for (int y = 2; y < HEIGHT - 2; y++)
		for (int x = 2; x < WIDTH - 2; x++) {
			double dx = fabs((x + 0.5 - WIDTH / 2.0) * 1.612), dy = fabs((y + 0.5 - HEIGHT / 2.0) * 1.612), away = fmax(dx, dy);
			double bright = brightness(x - 2, y - 2, x + 3, y + 3);
			if (away < 25)
				assert_true(bright > mud + 0.4 * (sand - mud));
			else if (away > 40)
				assert_true(bright < mud + 0.5 * (sand - mud));
		}
	/* Names decide, not numbers; snow is white, and what has no name is soil. */
	double rgb[3];
	strcpy(soils.soil_names[1], "snow_us");
	take(&shot);
	mean_of(70, 35, 90, 55, rgb);
	assert_true(rgb[2] > 150);
	strcpy(soils.soil_names[1], "");
	take(&shot);
	mean_of(70, 35, 90, 55, rgb);
	assert_true(rgb[0] > rgb[2] + 15 && brightness(70, 35, 90, 55) > 1.2 * mud);
	/* Without splat the map is nowhere to be seen. */
	shot.effects &= ~SPLAT;
	take(&shot);
	assert_true(fabs(brightness(64, 29, 96, 61) - brightness(0, 0, 50, HEIGHT)) < 20);
}

static double tall(double x, double y)
{
	return 100 + 95 * sin(x / 23) * cos(y / 31); /* steep, and from the lowest to the highest of the terrain */
}

/* Without a map the one soil of a scene has its look, whatever classes are there, on steep and high ground too. */
static void one_soil_looks_like_its_name(void **state)
{
	need_gpu();
	static const char *const names[] = {"dry_sand", "lunar", "snow_us", "clayey_38", "asphalt", "concrete", "sandy_loam_15"};
	enum { SAND, LUNAR, SNOW, CLAY, ASPHALT, CONCRETE, LOAM, NAMES };
	double is[NAMES][3], light[NAMES];
	for (int hilly = 0; hilly < 2; hilly++) {
		for (int i = 0; i < NAMES; i++) {
			struct scene soils = {.soil_count = 1};
			strcpy(soils.soil_names[0], names[i]);
			struct shot shot = {.effects = TEXTURE | DETAIL, .light = light_of(SCENE_EARTH), .height = hilly ? tall : flat, .soils = &soils,
					    .one_soil = true, .soil = a_square, DOWN};
			take(&shot);
			mean_of(5, 5, WIDTH - 5, HEIGHT - 5, is[i]);
			light[i] = brightness(5, 5, WIDTH - 5, HEIGHT - 5);
			if (!hilly) /* the class 1 in its middle is not seen */
				assert_true(fabs(brightness(64, 29, 96, 61) - light[i]) < 12);
		}
		/* Sand is yellowish, loam and clay are brown, the rest is grey or white. */
		assert_true(is[SAND][0] > is[SAND][2] + 12 && is[SAND][1] > is[SAND][2] + 8);
		assert_true(is[LOAM][0] > is[LOAM][2] + 20 && is[CLAY][0] > is[CLAY][1] + 20 && is[CLAY][1] > is[CLAY][2] + 10);
		for (int i = LUNAR; i < NAMES; i++)
			if (i == LUNAR || i == SNOW || i == ASPHALT || i == CONCRETE)
				assert_true(fmax(fmax(is[i][0], is[i][1]), is[i][2]) < fmin(fmin(is[i][0], is[i][1]), is[i][2]) + 22);
		assert_true(light[SNOW] > light[SAND] && light[SAND] > light[LUNAR] + 15 && light[CONCRETE] > light[LUNAR] + 15);
		assert_true(light[ASPHALT] < light[LUNAR] - 15 && light[ASPHALT] < light[CLAY]);
	}
	/* On the Moon its regolith is grey, and not black. */
	struct scene soils = {.soil_count = 1, .soil_names = {"lunar"}};
	take(&(struct shot){.effects = TEXTURE, .light = light_of(SCENE_MOON), .height = flat, .soils = &soils, .one_soil = true, DOWN});
	assert_true(brightness(5, 5, WIDTH - 5, HEIGHT - 5) > 60);
}

static int32_t a_print(int x, int y)
{
	return x >= 24 && x < 40 ? -(1 << 17) : 0; /* an eighth of a metre */
}

static uint8_t north_half(int x, int y)
{
	return y > 32 ? 255 : 0;
}

/* Light of a part of the picture, of one colour, before the film's curve (shaders/lib/tone.glsl) and sRGB. */
static double light_of_part(int x0, int y0, int x1, int y1, int c)
{
	double sum = 0;
	for (int y = y0; y < y1; y++)
		for (int x = x0; x < x1; x++) {
			const double s = pixels[y][x][c] / 255.0, film = s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4);
			const double a = 2.51 - 2.43 * film, b = 0.03 - 0.59 * film;
			sum += (-b + sqrt(b * b + 4 * a * 0.14 * film)) / (2 * a);
		}
	return sum / ((x1 - x0) * (y1 - y0));
}

static int32_t no_print(int x, int y)
{
	return 0;
}

/* Wet soil on the Earth, disturbed soil on the Moon: ratios of the light that are published (docs/CAMERAS.md). The sun is low, so nothing shines. */
static void disturbed_ground_has_published_albedo(void **state)
{
	need_gpu();
	static const double albedo[3] = {(0.130 + 0.270) / 2, (0.105 + 0.240) / 2, (0.075 + 0.200) / 2}; /* low_colour and high_colour of lib/body.glsl */
	struct shot shot = {.light = light_of(SCENE_EARTH), .height = flat, .offset = no_print, .dirt = north_half, DOWN};
	shot.light.height = 15 * M_PI / 180;
	take(&shot);
	for (int c = 0; c < 3; c++) {
		/* What comes through the film, is scattered, and goes out, at once or after it was reflected back. */
		const double in = 1 - pow(0.33 / 2.33, 2), back = 0.472;
		double out = 0, turns = albedo[c];
		for (int i = 0; i < 40; i++, turns *= albedo[c] * back)
			out += in * turns * (1 - back);
		const double ratio = light_of_part(20, 50, 140, 85, c) / light_of_part(20, 5, 140, 40, c);
		assert_true(fabs(ratio / (out / albedo[c]) - 1) < 0.02);
	}
	shot.light = light_of(SCENE_MOON);
	shot.offset = a_print;
	take(&shot);
	const double beside = light_of_part(5, 5, 45, 40, 1), print = light_of_part(68, 5, 92, 40, 1) / beside, worst = light_of_part(68, 50, 92, 85, 1) / beside;
	assert_true(fabs(print - 0.85) < 0.01 && fabs(worst - 0.70) < 0.01);
}

static void pressed_ground_is_darker_and_darkest_where_it_is_dirty(void **state)
{
	need_gpu();
	for (int i = 0; i < 3; i++) {
		const uint64_t effects[] = {0, TEXTURE, TEXTURE | DETAIL};
		take(&(struct shot){.effects = effects[i], .light = light_of(i == 2 ? SCENE_MOON : SCENE_EARTH), .height = flat, .offset = a_print,
				    .dirt = north_half, DOWN});
		double clean = brightness(68, 5, 92, 40), dirty = brightness(68, 50, 92, 85), beside = brightness(5, 5, 45, 40);
		assert_true(clean < 0.95 * beside && dirty < 0.95 * clean);
	}
}

TEST_PROGRAM(surface)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(no_green_on_mars_and_grass_on_earth),
		cmocka_unit_test(moon_is_grey_under_a_black_sky),
		cmocka_unit_test(each_sky_is_its_own),
		cmocka_unit_test(the_sun_turns_the_shading),
		cmocka_unit_test(snow_lies_only_high),
		cmocka_unit_test(each_class_is_shown_where_it_is),
		cmocka_unit_test(one_soil_looks_like_its_name),
		cmocka_unit_test(disturbed_ground_has_published_albedo),
		cmocka_unit_test(pressed_ground_is_darker_and_darkest_where_it_is_dirty),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
