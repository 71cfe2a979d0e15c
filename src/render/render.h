/*
 * render: the picture. Draws what terrain selected from the slots, in one instanced draw a tile,
 * with only the effects the scene names compiled in; reads it back and writes PNGs.
 * For the GPU's thread.
 */
#ifndef FURROW_RENDER_H
#define FURROW_RENDER_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "base/plan.h"
#include "gpu/gpu.h"
#include "scene/scene.h"
#include "terrain/terrain.h"

struct render_camera {
	double eye[3], target[3]; /* absolute metres */
	double fov;               /* vertical, radians */
};

struct render_params {
	struct gpu *gpu;
	struct gpu_slots *slots;
	const struct world *world;
	int32_t reference;    /* metres */
	double low, high;     /* of the terrain, for colours by height */
	int width, height;
	uint64_t effects;     /* EFFECT_BIT of each */
	bool dirt;
	double pixel_error;   /* pixels a picture's ground may be off by; 0: its detail goes by the radii (camera.c) */
	int samples;          /* a pixel; 0 as 1: its colour is of its middle */
};

struct render;

/* The lines of such a picture (gpu, slots, reference, low and high are not looked at). `deformed`: some tile is or may
 * be; `divided`: the working level is below 0, and tiles there are drawn. Pure. */
void render_plan(const struct render_params *params, bool deformed, bool divided, struct plan *plan);

/* STATUS_INPUT: the driver draws with fewer samples a pixel; says how many. */
enum status render_check_samples(const struct gpu *gpu, int samples) FURROW_CHECKED;
/* Checks its samples too. */
enum status render_create(const struct render_params *params, struct render **out) FURROW_CHECKED;
void render_destroy(struct render *render);
/* Links every program that pictures of such ground can ask for: arguments as render_plan's. */
enum status render_warm(struct render *render, bool deformed, bool divided) FURROW_CHECKED;
/* The view terrain_select needs for this camera. */
void render_view(const struct render *render, const struct render_camera *camera, struct terrain_view *view);
enum status render_frame(struct render *render, const struct render_camera *camera,
			 const struct terrain_selection *selection) FURROW_CHECKED;
uint64_t render_triangles(const struct render *render); /* of the last frame */
/* Tiles of the last frame, and those of them whose draw reads an offset. */
struct render_tiles {
	uint64_t drawn, deformed;
};
void render_tiles(const struct render *render, struct render_tiles *tiles);
/* Begins to read the last frame into staging of 4 bytes a pixel: sRGB and alpha, row 0 at the bottom. Another may be drawn
 * at once. */
void render_read_into(struct render *render, struct gpu_staging *staging);
/* Such pixels to a file, without alpha: written as PATH.part, then renamed; nothing is left of what fails. Any thread. */
enum status render_png_write(const char *path, const uint8_t *pixels, uint32_t width, uint32_t height) FURROW_CHECKED;
/* Writes the last frame, and waits for all of it. */
enum status render_write_png(struct render *render, const char *path) FURROW_CHECKED;

#endif
