/* What tests of objects in pictures share: four shapes, one tile of ground, and a picture of them. */
#ifndef FURROW_TESTS_OBJECTS_RIG_H
#define FURROW_TESTS_OBJECTS_RIG_H

#include "gpu_rig.h"
#include "render/objects.h"

#define WIDTH 256
#define HEIGHT 144
#define CELLS 64
#define POSTS (CELLS + 1)
#define GROUND 8000.0 /* metres */
#define OBJECTS EFFECT_BIT(EFFECT_OBJECTS)
#define SHADOW EFFECT_BIT(EFFECT_SHADOW)

/* Tiles are 16 m wide. */
static const struct extent extent = {40000001, 40000001, 0.25, CELLS};
static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4};
static const struct soil_shape lugged = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4, .grousers = 11, .grouser_height = 0.06, .grouser_thickness = 0.09};
static const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.6};
static const struct soil_shape box = {.kind = SOIL_BOX, .size = {1.2, 0.5, 0.3}};

static struct gpu_slots *slots;
static struct render *render;
static struct scene_object objects[4];
static struct render_selection selection;
static int64_t away; /* tiles east and north */
static int samples = 1; /* a pixel */

/* --- pictures of one tile, or of nothing, with objects --- */

static inline double flat(double x, double y)
{
	return GROUND;
}

/* `height` NULL: no ground at all. */
static inline void begin(uint64_t effects, double (*height)(double x, double y), const struct soil_shape *shapes, size_t count)
{
	static int32_t base[POSTS * POSTS];
	struct render_params params = {
		.gpu = gpu, .extent = &extent, .reference = 8192, .low = GROUND - 1, .high = GROUND + 4, .width = WIDTH,
		.height = HEIGHT, .effects = effects, .objects = objects, .object_count = count, .samples = samples,
	};
	for (size_t i = 0; i < count; i++)
		objects[i] = (struct scene_object){.name = "it", .shape = shapes[i]};
	assert_ok(gpu_slots_create(gpu, CELLS, 1, 0, &slots));
	params.slots = slots;
	assert_ok(render_create(&params, &render));
	for (int k = 0; height != NULL && k < POSTS * POSTS; k++)
		base[k] = lattice_base_relative(height(k % POSTS * extent.spacing, k / POSTS * extent.spacing), 8192);
	assert_ok(staged_upload_base(gpu, slots, CELLS, 0, base));
	selection.draw_count = height != NULL;
	selection.draws[0] = (struct render_draw){
		.tile = {0, (uint32_t)away, (uint32_t)away}, .quadrants = 15, .finest = true, .low = GROUND - 1, .high = GROUND + 4,
	};
}

static inline void end(void)
{
	render_destroy(render);
	gpu_slots_destroy(slots);
	render = NULL;
	slots = NULL;
}

/* Places are from the tile's corner, and from the ground. */
static inline struct render_camera camera_at(const double eye[3], const double target[3])
{
	double east = (double)away * 16;
	return (struct render_camera){{east + eye[0], east + eye[1], GROUND + eye[2]},
				      {east + target[0], east + target[1], GROUND + target[2]}, 0.9, {0}};
}

static inline struct render_object posed(size_t object, double x, double y, double z)
{
	double east = (double)away * 16;
	return (struct render_object){.object = object, .at = {east + x, east + y, GROUND + z}};
}

static inline uint8_t *draw(const struct render_camera *camera, const struct render_object *shown, size_t count)
{
	render_set_objects(render, shown, count);
	assert_ok(render_frame(render, camera, &selection));
	uint8_t *pixels = test_malloc(4 * WIDTH * HEIGHT);
	gpu_texture_read(render->screen->colour, 0, (struct gpu_rect){0, 0, WIDTH, HEIGHT}, pixels);
	return pixels;
}

static inline int luminance(const uint8_t *pixels, int x, int y)
{
	const uint8_t *p = pixels + 4 * (WIDTH * y + x);
	return 2 * p[0] + 5 * p[1] + p[2];
}

static inline double difference(const uint8_t *a, const uint8_t *b)
{
	double sum = 0;
	for (int i = 0; i < 4 * WIDTH * HEIGHT; i++)
		sum += abs(a[i] - b[i]);
	return sum / (4 * WIDTH * HEIGHT);
}

#endif
