/* Shared by the files of src/render. */
#ifndef FURROW_RENDER_INTERNAL_H
#define FURROW_RENDER_INTERNAL_H

#include <assert.h>

#include "render/render.h"
#include "render/textures.h"

/* The pattern of the ground repeats after so many metres. It is a multiple of every scale in the pattern. */
#define RENDER_PATTERN_PERIOD 16384.0
#define RENDER_FAR 200000.0 /* metres */
#define RENDER_NEAR 0.05
/* The textures of the ground repeat after so many metres. They are turned by the directions (2, 1) and (3, 1). */
#define RENDER_GROUND_NEAR 8.0
#define RENDER_GROUND_FAR 512.0

#define RENDER_SHADES RENDER_SHADE_MAPS
#define RENDER_SHADE_SIZE 1024u /* texels along a side of each */

#define RENDER_IMAGERY_LEVELS 32

/* The uniform block of shaders/lib/picture.glsl, std140. */
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
	float soils[SOIL_CLASSES][4];
	int32_t tile[4];
	float layer[4]; /* only for programs with the define LAYER or IMAGERY, of which no program has both */
	float reaches[RENDER_STRIDES]; /* only for programs with the define REACHES */
	float shade_across[4], shade_along[4];
	float shade_middle[RENDER_SHADES][4], shade_scale[RENDER_SHADES][4];
	/* only for programs with the define HEALS or VEGETATION */
	int32_t marks[4];
	float plants[4];
	float cover[SOIL_CLASSES / 4][4];
	float imagery[RENDER_IMAGERY_LEVELS][2][4]; /* only for programs with the define IMAGERY, which have it at this place whatever else they have */
};
#define RENDER_PARAMS_BYTES offsetof(struct picture_params, imagery) /* of other programs */
static_assert(RENDER_PARAMS_BYTES == 864, "lib/picture.glsl has this offset");

/* A camera's axes (unit vectors, at right angles), and the size of its pixels. */
struct render_axes {
	double forward[3], right[3], up[3];
	double focal; /* focal length in pixels */
};
void render_axes(const struct render *render, const struct render_camera *camera, struct render_axes *axes);
/* Returns a distance from the eye, in metres for each metre of spacing. From this distance on, a spacing is fine enough for the
 * mesh. Used if distance alone decides the detail. */
double render_mesh_reach(const struct render *render, const struct render_axes *axes);
#define RENDER_RUT_REACH 1.5 /* up to this factor times that distance, vertices are dense enough to show ruts: camera.c */
/* Fills the distance from the eye, in metres, from which on each stride of a tile (2^0 to 2^11) is fine enough. The distances
 * never decrease with the stride. */
void render_reaches(const struct render *render, const struct render_axes *axes, const struct render_draw *draw,
		    double reaches[RENDER_STRIDES]);

/* --- blocks.c: which parts (blocks) of a tile are drawn, and at which stride --- */
#define RENDER_BLOCK_CELLS 8
#define RENDER_SKIRT_SOUTH (1u << 24)
#define RENDER_SKIRT_NORTH (1u << 25)
#define RENDER_SKIRT_WEST (1u << 26)
#define RENDER_SKIRT_EAST (1u << 27)

/* One word for each block, read by terrain.vert. Bits 0-9 and 10-19: x and y of the block in its tile, counted in blocks of its
 * own size. Bits 20-23: log2 of its stride (it draws every stride-th post). Bits 24-27: edges that need a skirt,
 * RENDER_SKIRT_*. */
struct render_blocks {
	uint32_t *blocks;
	size_t count, capacity;
};
uint32_t render_block_cells(const struct extent *extent);
/* Returns the number of indices of a block's mesh. */
uint32_t render_index_count(uint32_t cells, bool skirts);
/* Most blocks in GPU memory at once. No tile has more. */
#define RENDER_BLOCKS_ROOM ((size_t)1 << 15)
static_assert(RENDER_BLOCKS_ROOM >= (size_t)(TILE_CELLS_MAX / RENDER_BLOCK_CELLS) * (TILE_CELLS_MAX / RENDER_BLOCK_CELLS),
	      "a tile's blocks fit");
/* Adds the visible blocks of a draw. Each block gets the coarsest stride that is fine enough at the block's distance. */
enum status render_blocks_add(struct render_blocks *blocks, const struct extent *extent, const struct render_view *view,
			      const double reaches[RENDER_STRIDES], const struct render_draw *draw) FURROW_CHECKED;

/* --- programs.c --- */
/* Returns the effects of params, without those that would show nothing. */
uint64_t render_effects(const struct render_params *params);
/* Adds the define of pictures with truth to a request of the ground, in place of that of detail. */
void render_request_truth(struct gpu_program_request *request);
/* Kinds of tiles; each has its own program. PLAIN: not deformed. OFFSET: deformed. LEVEL0: deformed and below level 0. SMOOTH: not
 * deformed and below level 0. The last two also read the tile that they are interpolated from, so that light does not show its cells.
 * Numbers and shadows have the ground as it is, so for them these two are drawn as OFFSET and PLAIN. */
enum { RENDER_PLAIN, RENDER_OFFSET, RENDER_LEVEL0, RENDER_SMOOTH, RENDER_VARIANTS };
enum status render_tile_program(struct render *render, unsigned variant, struct gpu_program **out) FURROW_CHECKED;
enum status render_sky_program(struct render *render, struct gpu_program **out) FURROW_CHECKED;

/* --- apron.c: the ground beyond the terrain, a part of EFFECT_SKY --- */
/* Draws it behind what was drawn. Nothing is drawn where the selection's coarsest tile is not resident. `params`: those of the frame; values
 * for a tile are overwritten. */
enum status render_apron_draw(struct render *render, const struct render_camera *camera, const struct render_axes *axes,
			      const struct render_selection *selection, struct picture_params *params) FURROW_CHECKED;
/* Draws it from a texture like a base, outside the picture: `params` make it invisible. This compiles the program. */
enum status render_apron_draw_unseen(struct render *render, struct gpu_texture *base, const struct picture_params *params) FURROW_CHECKED;
enum status render_apron_warm(struct render *render) FURROW_CHECKED;
void render_apron_plan(const struct render_params *params, struct plan *plan);
/* Fills the parts of a tile's parameters that say how high the eye is: origin[3] and tile[2]. */
void render_fill_height(const struct render *render, const struct render_camera *camera, struct picture_params *params);

/* --- objects.c --- */
struct render_objects;
struct render_grains;
struct render_heaps;
/* Makes render->objects, or sets it to NULL if no object is shown. Call render_objects_destroy even after a failure. */
enum status render_objects_create(struct render *render, const struct render_params *params) FURROW_CHECKED;
void render_objects_destroy(struct render_objects *objects); /* objects may be NULL */
bool render_objects_cast(const struct render_objects *objects); /* some object may cast a shadow; objects may be NULL */
bool render_objects_are_cast(const struct render_params *params); /* the same, before they are made */
void render_objects_plan(const struct render_params *params, struct plan *plan);
enum status render_objects_warm(struct render *render) FURROW_CHECKED;
/* Draws an object and a shadow, if there are any, but outside the picture: `params` make them invisible. This compiles the
 * programs. */
enum status render_objects_draw_unseen(struct render *render, const struct picture_params *params) FURROW_CHECKED;
/* Call this after the ground was drawn and before the sky. `params`: those of the frame; values for a tile are overwritten. */
enum status render_objects_draw(struct render *render, const struct render_camera *camera, const struct render_axes *axes,
				const struct render_view *view, struct picture_params *params) FURROW_CHECKED;

/* --- grains.c; render->grains is NULL if none are shown --- */
enum status render_grains_create(struct render *render, const struct render_params *params) FURROW_CHECKED;
void render_grains_destroy(struct render_grains *grains); /* grains may be NULL */
void render_grains_plan(const struct render_params *params, struct plan *plan);
enum status render_grains_warm(struct render *render) FURROW_CHECKED;
/* As render_objects_draw_unseen and render_objects_draw. Call the first only if there are grains. */
enum status render_grains_draw_unseen(struct render *render, const struct picture_params *params) FURROW_CHECKED;
enum status render_grains_draw(struct render *render, const struct render_camera *camera, struct picture_params *params) FURROW_CHECKED;

/* --- heaps.c; render->heaps is NULL if no body may carry soil --- */
enum status render_heaps_create(struct render *render, const struct render_params *params) FURROW_CHECKED;
void render_heaps_destroy(struct render_heaps *heaps); /* heaps may be NULL */
void render_heaps_plan(const struct render_params *params, struct plan *plan);
enum status render_heaps_warm(struct render *render) FURROW_CHECKED;
/* As render_objects_draw_unseen and render_objects_draw. Call them only if there are heaps. */
enum status render_heaps_draw_unseen(struct render *render, const struct picture_params *params) FURROW_CHECKED;
enum status render_heaps_draw(struct render *render, const struct render_camera *camera, const struct render_axes *axes, struct picture_params *params) FURROW_CHECKED;

/* --- shade_map.c: maps of the shadows that the terrain casts on itself --- */
struct render_shade;
/* Makes render->shade, or leaves it NULL without EFFECT_TERRAIN_SHADOW. */
enum status render_shade_create(struct render *render) FURROW_CHECKED;
void render_shade_destroy(struct render_shade *shade); /* shade may be NULL */
struct gpu_texture *render_shade_texture(const struct render_shade *shade); /* NULL for NULL */
struct gpu_target *render_shade_target(const struct render_shade *shade, int index);
/* Fills the projection of a map, from places relative to the eye. Call render_shade_view before. */
void render_shade_project(struct render *render, const double eye[3], int index, float matrix[16]);
/* Fills what shaders need to look into the maps. */
void render_shade_fill(const struct render *render, const double eye[3], struct picture_params *params);
void render_shade_plan(const struct render_params *params, struct plan *plan);

/* --- body.c: the look of the planet on which the ground is --- */
/* number of textures of the ground: sand, cover, soil, rock, snow, and one for ground seen from afar */
#define RENDER_GROUND_LAYERS 6
/* Fills the kind of texture of each layer. */
void render_body_textures(const struct scene_light *light, enum render_ground kinds[RENDER_GROUND_LAYERS]);
/* Returns the define that shaders need for this planet; NULL: none. */
/* Among effects (render_effects): all ground looks like the first soil. No effect of a scene has this bit. */
#define RENDER_ONE_SOIL (UINT64_C(1) << 63)
#define RENDER_ONE_SOIL_DEFINE "ONE_SOIL"
const char *render_body_define(const struct scene_light *light);
/* Fills sunlight, tint, and the look of soil classes. `soils` may be NULL. */
void render_body_fill(const struct scene_light *light, const struct scene *soils, struct picture_params *params);
/* Returns the factor of all light: 2^ev, and what makes level ground as bright as under the default sun, at most 32. For an exposure by the frame, what
 * `sun` would give: windows have that. */
double render_body_exposure(const struct scene_light *light);
/* --- expose.c: with EFFECT_LIGHT a frame is drawn as light, and exposed by its mean then --- */
struct render_screen;
const char *render_light_define(uint64_t effects); /* returns the define of programs that draw light; NULL: they draw colours */
enum gpu_format render_light_format(uint64_t effects); /* returns the format of what pictures are drawn into */
#define RENDER_METER 32u /* cells along each side of the light's sums */
#define RENDER_METER_BYTES ((uint64_t)RENDER_METER * RENDER_METER * 4)
/* Makes what a screen needs for it; does nothing without the effect. */
enum status render_expose_screen(struct render *render, struct render_screen *screen) FURROW_CHECKED;
void render_expose_screen_finish(struct render_screen *screen);
enum status render_expose_warm(struct render *render) FURROW_CHECKED;
void render_expose_plan(const struct render_params *params, struct plan *plan);
void render_expose_background(const struct render *render, float rgba[4]); /* turns the background's colour into light */
/* Exposes the frame that was drawn, and notes its exposure. */
enum status render_expose(struct render *render) FURROW_CHECKED;
double render_body_air(const struct scene_light *light); /* returns the haze relative to the Earth's; 0: no air */
void render_body_background(const struct scene_light *light, float rgba[4]); /* gives the colour where nothing is drawn */

/* --- files of pictures --- */
#define RENDER_PATH 4400 /* bytes of a path of a picture */
void render_depths(float *depth, size_t count); /* turns values of the depth texture into metres; INFINITY: sky */
/* picture_files.c: writes the files of a picture that was read back. Changes the bytes. Any thread. */
enum status render_picture_write(const char *directory, const struct render_picture *picture, void *bytes) FURROW_CHECKED;

/* The textures that a picture is drawn into (screen.c). */
struct render_screen {
	uint32_t width, height;
	uint32_t samples;            /* samples for each pixel in target and depth */
	struct gpu_texture *colour, *depth;
	struct gpu_target *target;   /* draws into `depth`, and into `drawn`, or `colour` if `drawn` is NULL */
	/* colours with several samples for each pixel, resolved into `colour` at the end of a frame; NULL with 1 sample */
	struct gpu_texture *drawn;
	struct gpu_target *resolved; /* target with `colour`; NULL with 1 sample */
	struct gpu_texture *numbers; /* NULL unless render_measure may be called */
	struct gpu_texture *single;  /* depth of one sample for each pixel, if `depth` has several and `numbers` is there; else NULL */
	struct gpu_target *measure;  /* draws into `numbers`, and `single` or `depth` */
	/* With EFFECT_LIGHT, else NULL */
	struct gpu_texture *light;   /* the frame as light, of one sample for each pixel */
	struct gpu_texture *meter;   /* sums of its luminance (expose.c) */
	struct gpu_target *exposed, *metered; /* targets with `colour` and `meter` */
	/* For shadows of objects; NULL: no object casts one */
	struct gpu_texture *umbra;   /* the ground without the sun's light */
	struct gpu_target *ground;   /* `target` and `umbra` */
	struct gpu_target *over;     /* the same without depth */
};
/* Fills `screen` for pictures of this size. Call render_screen_finish even after a failure; it keeps the sizes. */
enum status render_screen_init(struct render *render, uint32_t width, uint32_t height, uint32_t samples, struct render_screen *screen)
	FURROW_CHECKED;
/* Makes what render_measure draws into, unless the screen has it: of one sample for each pixel. */
enum status render_screen_measures(struct render *render, struct render_screen *screen) FURROW_CHECKED;
void render_screen_finish(struct render_screen *screen);

struct render {
	struct gpu *gpu;
	struct gpu_slots *slots;
	enum status (*show)(void *user, uint32_t slot, bool planes); /* NULL: slots are always up to date */
	void *user;
	struct extent extent;
	int32_t reference;
	double low, high;
	uint64_t effects;
	bool disturbance, heals, cover_by_class; /* as in render_params */
	const struct scene_vegetation *vegetation;
	struct plane_marks marks;
	double pixel_error; /* pixels; 0: distance alone decides the detail */
	struct scene_light light;
	const struct scene *soils; /* scene whose soil classes are drawn, for the effect SPLAT; or NULL */
	struct gpu_texture *ground;   /* textures of the ground; NULL without the effect TEXTURE */
	struct render_screen own;     /* of the size that the render was made with */
	struct render_screen *screen; /* what is drawn into: `own`, or another of the caller's */
	struct gpu_buffer *indices;
	struct gpu_list *instances;
	uint32_t index_count;
	struct render_blocks blocks;
	uint64_t triangles;
	double exposed; /* factor of the last frame's light */
	struct gpu_counter *ground_samples; /* counts samples of the ground */
	struct render_objects *objects; /* NULL: no objects are shown */
	struct render_grains *grains; /* NULL: no grains are shown */
	struct render_heaps *heaps;   /* NULL: no soil aboard bodies is shown */
	struct render_tiles tiles; /* counts of the last frame */
	struct gpu_program *tile_programs[2][RENDER_VARIANTS]; /* without and with truth; NULL: not yet linked */
	bool truths[2]; /* pictures without and with truth may be drawn */
	bool truth;     /* the next frame has it */
	struct render_shade *shade;    /* NULL: the terrain casts no shadows */
	struct gpu_target *shading;    /* of the map that is drawn now; NULL: none */
	struct gpu_program *shade_programs[RENDER_VARIANTS];
	bool measures, classes; /* as in render_params */
	bool measuring;         /* numbers are drawn now, not colours */
	struct gpu_program *measure_programs[RENDER_VARIANTS];
	bool layers;
	struct render_imagery *imagery; /* the caller's; NULL without EFFECT_IMAGERY */
	struct render_layer layer;
	struct gpu_program *layer_programs[RENDER_VARIANTS]; /* the same for false colours (layers) */
};

#endif
