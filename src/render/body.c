/*
 * Where the ground is: on the Earth, on Mars or on the Moon. shaders/lib/body.glsl says how it looks there. This file has what
 * depends on the scene: the sun's colour at its height, the look of a map's soils, and the textures.
 */
#include <math.h>
#include <string.h>

#include "render/internal.h"

static const struct celestial_body {
	const char *define;
	enum render_ground kinds[RENDER_GROUND_LAYERS];
	double sunlight[3]; /* at the default height; light where a white that faces the Earth's sun is 2.6 */
	double air;         /* haze beside the Earth's */
	double reddens;     /* the sun through how much of the Earth's air */
	float background[4];
	float snow[3];      /* snow_colours of lib/body.glsl */
} bodies[] = {
	[SCENE_EARTH] = {NULL, {RENDER_SAND, RENDER_GRASS, RENDER_SOIL, RENDER_ROCK, RENDER_SNOW, RENDER_WIDE},
			 {2.6, 2.34, 1.95}, 1, 1, {0.56f, 0.67f, 0.80f, 1}, {0.72f, 0.76f, 0.82f}},
	[SCENE_MARS] = {"MARS", {RENDER_SAND, RENDER_SAND, RENDER_SOIL, RENDER_ROCK, RENDER_SNOW, RENDER_WIDE},
			{2.3, 2.0, 1.66}, 1.3, 0.1, {0.66f, 0.47f, 0.28f, 1}, {0.70f, 0.64f, 0.60f}},
	[SCENE_MOON] = {"MOON", {RENDER_SNOW, RENDER_SNOW, RENDER_SOIL, RENDER_SOIL, RENDER_SNOW, RENDER_WIDE},
			{3.6, 3.5, 3.34}, 0, 0, {0, 0, 0, 1}, {0.160f, 0.156f, 0.150f}},
};

/*
 * Soils by the beginning of their names: the layer that each looks like, and its tint on the Earth. Others look like plain soil. What is
 * smooth has the grain of snow, and an albedo in place of the tint.
 */
enum { LIKE_SAND, LIKE_SOIL = 2, LIKE_ROCK, LIKE_SNOW, SMOOTH };
static const struct soil {
	const char *begins;
	int like;
	float tint[3];
} soils[] = {
	{"dry_sand", LIKE_SAND, {1, 1, 1}},
	{"lete_sand", LIKE_SAND, {0.70f, 0.66f, 0.60f}},
	{"sandy_loam", LIKE_SOIL, {1.30f, 1.25f, 1.15f}},
	{"sand", LIKE_SAND, {1, 1, 1}},
	{"mud", LIKE_SOIL, {0.45f, 0.45f, 0.48f}},
	{"clayey", LIKE_SOIL, {1.25f, 0.88f, 0.70f}},
	{"heavy_clay", LIKE_SOIL, {0.95f, 0.72f, 0.62f}},
	{"lean_clay", LIKE_SOIL, {1.45f, 1.20f, 1.00f}},
	{"upland_loam", LIKE_SOIL, {0.62f, 0.62f, 0.62f}},
	{"snow", LIKE_SNOW, {1, 1, 1}},
	{"ice", SMOOTH, {0.42f, 0.50f, 0.57f}},
	{"rock", LIKE_ROCK, {1, 1, 1}},
	{"asphalt", SMOOTH, {0.052f, 0.052f, 0.053f}},
	{"concrete", SMOOTH, {0.31f, 0.30f, 0.28f}},
	{"lunar", SMOOTH, {0.124f, 0.120f, 0.114f}},
	{"", LIKE_SOIL, {1, 1, 1}},
};

/* Off the Earth a soil has the hue of that planet. */
static void fill_soil(const char *name, enum scene_body on, float out[4])
{
	const bool earth = on == SCENE_EARTH;
	const float *snow = bodies[on].snow;
	const struct soil *soil = soils;
	while (strncmp(name, soil->begins, strlen(soil->begins)) != 0)
		soil++;
	for (int i = 0; i < 3; i++) {
		out[i] = earth ? soil->tint[i] : (soil->tint[0] + soil->tint[1] + soil->tint[2]) / 3;
		out[i] /= soil->like == SMOOTH ? (earth ? snow[i] : snow[1]) : 1;
	}
	out[3] = (float)(soil->like == SMOOTH ? LIKE_SNOW : soil->like);
}

/* Returns how much air the sun shines through; 1: the air straight above (Kasten and Young 1989). Below the horizon: as upon it. */
static double air_mass(double height)
{
	height = fmax(height, 0);
	return 1 / (sin(height) + 0.50572 * pow(height * (180 / M_PI) + 6.07995, -1.6364));
}

static double sky_share(double height)
{
	if (height < 0)
		return 0.2 * fmax(1 + height / (12 * M_PI / 180), 0.02);
	return fmin(0.2 + 1.6 * sin(height), 1);
}

/* Returns the green light of level ground that is white. */
static double level_light(const struct scene_light *light, double height)
{
	static const double sky[] = {[SCENE_EARTH] = 0.50, [SCENE_MARS] = 0.34, [SCENE_MOON] = 0.012}; /* skylight of lib/body.glsl */
	const struct celestial_body *body = &bodies[light->body];
	const double more = air_mass(height) - air_mass(SCENE_SUN_HEIGHT), sun = body->sunlight[1] * exp(-body->reddens * 0.11 * more);
	return sun * fmax(sin(height), 0) + sky[light->body] * sky_share(height);
}

double render_body_exposure(const struct scene_light *light)
{
	const double by_ev = exp2(light->ev);
	if (light->exposure == SCENE_EXPOSURE_FIXED)
		return by_ev;
	return by_ev * fmin(level_light(light, SCENE_SUN_HEIGHT) / fmax(level_light(light, light->height), 1e-6), 32);
}

double render_sun_brightens(const struct scene_light *light)
{
	struct scene_light by_sun = *light;
	by_sun.exposure = SCENE_EXPOSURE_SUN;
	by_sun.ev = 0;
	return fmax(render_body_exposure(&by_sun), 1);
}

void render_body_textures(const struct scene_light *light, enum render_ground kinds[RENDER_GROUND_LAYERS])
{
	memcpy(kinds, bodies[light->body].kinds, sizeof bodies[light->body].kinds);
}

const char *render_body_define(const struct scene_light *light)
{
	return bodies[light->body].define;
}

void render_body_fill(const struct scene_light *light, const struct scene *scene, struct picture_params *params)
{
	static const double taken[3] = {0.05, 0.11, 0.215}; /* of the light, by the Earth's air above */
	const struct celestial_body *body = &bodies[light->body];
	double more = air_mass(light->height) - air_mass(SCENE_SUN_HEIGHT);
	for (int i = 0; i < 3; i++) {
		double sun = light->coloured ? 2.6 * light->colour[i] : body->sunlight[i] * exp(-body->reddens * taken[i] * more);
		params->sunlight[i] = (float)sun;
		params->tint[i] = (float)sqrt(sun / body->sunlight[i]);
	}
	/* A lower sun lights the sky less, and goes on to until it is 12 degrees below the horizon. */
	params->sunlight[3] = (float)sky_share(light->height);
	/* Below the horizon it lights no ground. Its disc is half a degree wide. */
	const double shown = fmin(fmax(0.5 + light->height / (0.533 * M_PI / 180), 0), 1);
	for (int i = 0; i < 3; i++)
		params->sunlight[i] *= (float)shown;
	for (int i = 0; i < 3 && light->height < 0; i++)
		params->tint[i] *= params->sunlight[3] / 0.2f;
	/* A soil that no model reads is not counted, and may be drawn: scene_draws_one_soil. */
	for (int i = 0; scene != NULL && (i == 0 || i < scene->soil_count); i++)
		fill_soil(scene->soil_names[i], light->body, params->soils[i]);
}

double render_body_air(const struct scene_light *light)
{
	return bodies[light->body].air;
}

void render_body_background(const struct scene_light *light, float rgba[4])
{
	memcpy(rgba, bodies[light->body].background, sizeof bodies[light->body].background);
}
