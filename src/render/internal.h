/* What the files of render share. */
#ifndef FURROW_RENDER_INTERNAL_H
#define FURROW_RENDER_INTERNAL_H

#include <assert.h>

#include "render/render.h"
#include "render/textures.h"

/* Metres after which the ground's pattern repeats: a multiple of every scale that it uses. */
#define RENDER_PATTERN_PERIOD 16384.0
#define RENDER_FAR 200000.0 /* metres */
#define RENDER_NEAR 0.05
/* Metres after which the ground's textures repeat, turned by (2, 1) and by (3, 1). */
#define RENDER_GROUND_NEAR 8.0
#define RENDER_GROUND_FAR 512.0

/* shaders/lib/picture.glsl's block, std140. */
struct picture_params {
	float project[16];
	float right[4], up[4], forward[4];
	float sun[4];
	float haze[4];
	float relief[4];
	float origin[4];
	float pattern[4];
	float corner_squares[4];
	float ground[4];
	float detail[4];
	float sunlight[4], tint[4];
	float soils[DEFORM_SOILS][4];
	int32_t tile[4];
	float layer[4]; /* read by programs with LAYER alone */
	float reaches[TERRAIN_STRIDES]; /* read by programs with REACHES alone */
};

/* A camera's orthonormal axes and the size of a pixel. */
struct render_axes {
	double forward[3], right[3], up[3];
	double focal; /* pixels a unit of tangent */
};
void render_axes(const struct render *render, const struct render_camera *camera, struct render_axes *axes);
/* Returns the distance from the eye, per metre of spacing, from which on a spacing is fine enough for the mesh. By radii. */
double render_mesh_reach(const struct render_axes *axes);
#define RENDER_RUT_REACH 1.5 /* factor of that distance where vertices are near enough to show ruts: camera.c */
/* Fills the distances from the eye, metres, from which on each stride of a tile, 2^0 to 2^11, is fine enough. They never become
 * smaller with the stride. */
void render_reaches(const struct render *render, const struct render_axes *axes, const struct terrain_draw *draw,
		    double reaches[TERRAIN_STRIDES]);

/* --- blocks.c: which parts of a tile are drawn at which stride --- */
#define RENDER_BLOCK_CELLS 8
#define RENDER_SKIRT_SOUTH (1u << 24)
#define RENDER_SKIRT_NORTH (1u << 25)
#define RENDER_SKIRT_WEST (1u << 26)
#define RENDER_SKIRT_EAST (1u << 27)

/* Blocks as the vertex shader reads them. From bit 0 on: x and y in blocks of its stride, 10 bits each. Then log2 of the stride,
 * 4 bits. Then a bit for each edge that needs a skirt. */
struct render_blocks {
	uint32_t *blocks;
	size_t count, capacity;
};
uint32_t render_block_cells(const struct extent *extent);
/* Returns the number of indices of a block's mesh. */
uint32_t render_index_count(uint32_t cells, bool skirts);
/* Blocks that the GPU holds at once: more than any tile has. */
#define RENDER_BLOCKS_ROOM ((size_t)1 << 15)
static_assert(RENDER_BLOCKS_ROOM >= (size_t)(TILE_CELLS_MAX / RENDER_BLOCK_CELLS) * (TILE_CELLS_MAX / RENDER_BLOCK_CELLS),
	      "a tile's blocks fit");
/* Appends the visible blocks of a draw, each at the coarsest stride whose reach it is beyond. */
enum status render_blocks_add(struct render_blocks *blocks, const struct extent *extent, const struct terrain_view *view,
			      const double reaches[TERRAIN_STRIDES], const struct terrain_draw *draw) FURROW_CHECKED;

/* --- programs.c --- */
/* Returns the effects, without those that have nothing to show. */
uint64_t render_effects(const struct render_params *params);
/* Kinds of tiles, each with a program: not deformed; deformed; deformed and below level 0. The last also reads its level-0 tile,
 * for the broad shape. A tile below level 0 that is not deformed is rare. It is drawn as a deformed one. */
enum { RENDER_PLAIN, RENDER_OFFSET, RENDER_LEVEL0, RENDER_VARIANTS };
enum status render_tile_program(struct render *render, unsigned variant, struct gpu_program **out) FURROW_CHECKED;
enum status render_sky_program(struct render *render, struct gpu_program **out) FURROW_CHECKED;

/* --- objects.c --- */
struct render_objects;
/* Makes render->objects; NULL if no object is shown. Call render_objects_destroy even after a failure. */
enum status render_objects_create(struct render *render, const struct render_params *params) FURROW_CHECKED;
void render_objects_destroy(struct render_objects *objects); /* takes NULL */
/* Says that the picture's textures were replaced. */
enum status render_objects_retarget(struct render *render) FURROW_CHECKED;
void render_objects_plan(const struct render_params *params, struct plan *plan);
enum status render_objects_warm(struct render *render) FURROW_CHECKED;
/* Draws an object and a shadow, if there are any, with `params` that show nothing. */
enum status render_objects_draw_unseen(struct render *render, const struct picture_params *params) FURROW_CHECKED;
/* Call it after the ground is drawn and before the sky. `params`: of the frame; changes what is of a tile. */
enum status render_objects_draw(struct render *render, const struct render_camera *camera, const struct render_axes *axes,
				const struct terrain_view *view, struct picture_params *params) FURROW_CHECKED;

/* --- body.c: where the ground is --- */
#define RENDER_GROUND_LAYERS 6 /* of the ground's textures: sand, cover, soil, rock, snow, and what is seen from afar */
/* Fills the kind of texture of each layer. */
void render_body_textures(const struct scene_light *light, enum render_ground kinds[RENDER_GROUND_LAYERS]);
/* Returns the define of its shaders; NULL: none. */
const char *render_body_define(const struct scene_light *light);
/* Fills sunlight, tint, and how the classes of a map look (`soils` may be NULL). */
void render_body_fill(const struct scene_light *light, const struct scene *soils, struct picture_params *params);
double render_body_air(const struct scene_light *light); /* haze, beside the Earth's; 0: there is none */
void render_body_background(const struct scene_light *light, float rgba[4]); /* where nothing is drawn */

/* --- ramp.c --- */
/* Returns the colour to lay over ground for `t`, -1 to 1. Only the signed ramp reads the sign. 0 is fully transparent. */
struct render_colour render_ramp(enum render_ramp ramp, double t);
/* Returns the place of a value on a ramp, -1 to 1. A value out of the range is beyond that. */
double render_ramp_place(const struct render_range *range, double value);
/* Returns the colour of ground of a shade (NaN: nodata) under a colour. `flat`: the shade that keeps a colour as it is. */
struct render_colour render_ground_colour(double shade, double flat, struct render_colour over);

/* --- font.c --- */
size_t render_text_letters(const char *text);

/* --- map_raster.c --- */
/* Finds the size, metres, that `share` of all pixels with values do not exceed, and the lowest and highest value, or 0. */
enum status render_map_raster_spread(const struct render_map_raster *raster, double share, double *size, double *low,
				 double *high) FURROW_CHECKED;

/* --- map_layout.c --- */
double render_round_length(double most); /* the largest number up to `most` that is 1, 2 or 5 times a power of ten */

struct render {
	struct gpu *gpu;
	struct gpu_slots *slots;
	struct extent extent;
	int32_t reference;
	double low, high;
	uint32_t width, height;
	uint64_t effects;
	bool disturbance;
	double pixel_error; /* 0: by radii */
	struct scene_light light;
	const struct scene *soils; /* with SPLAT: the scene whose classes are drawn; or NULL */
	struct gpu_texture *colour, *depth, *ground; /* the picture, its depth, and the textures of the ground; `ground` NULL without TEXTURE */
	struct gpu_target *target; /* what is drawn into: depth, and colour or drawn */
	uint32_t samples;          /* samples a pixel, of target and depth */
	struct gpu_texture *drawn; /* becomes `colour` when all is drawn; NULL with 1 sample */
	struct gpu_target *resolved; /* draws into `colour`; NULL with 1 sample */
	struct gpu_buffer *indices, *instances;
	uint32_t index_count;
	struct render_blocks blocks;
	uint64_t triangles;
	struct gpu_counter *ground_samples; /* of the ground's draws */
	struct render_objects *objects; /* NULL: none is shown */
	struct render_tiles tiles; /* of the last frame */
	struct gpu_program *tile_programs[RENDER_VARIANTS]; /* NULL: not yet linked */
	bool layers;
	struct render_layer layer;
	struct gpu_program *layer_programs[RENDER_VARIANTS]; /* the same, in false colours */
};

#endif
