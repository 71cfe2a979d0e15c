/*
 * render: pictures. It draws the tiles that terrain selected, in one instanced draw a tile. Only the effects that the scene
 * names are compiled in. It reads the picture back and writes PNGs. For the GPU's thread. It also draws maps, on the CPU.
 */
#ifndef FURROW_RENDER_H
#define FURROW_RENDER_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "base/plan.h"
#include "gpu/gpu.h"
#include "scene/scene.h"
#include "store/store.h"
#include "terrain/terrain.h"
#include "world/world.h"

struct render_camera {
	double eye[3], target[3]; /* absolute metres */
	double fov;               /* vertical, radians */
	double up[3];             /* direction that is up in the picture; all 0: z */
};

struct render_params {
	struct gpu *gpu;
	struct gpu_slots *slots;
	const struct extent *extent;
	int32_t reference;    /* metres */
	double low, high;     /* lowest and highest height of the terrain, for colours by height */
	int width, height;
	uint64_t effects;     /* EFFECT_BIT of each */
	bool disturbance;
	const struct scene_light *light; /* the planet and the sun; NULL: the default of a scene */
	const struct scene *soils; /* for splat: its soils are the classes in the slots; must outlive the picture. NULL: none */
	double pixel_error;   /* pixels by which drawn ground may be off; 0: radii decide its detail (camera.c) */
	int samples;          /* samples a pixel; 0 and 1: the colour at the pixel's centre */
	const struct scene_object *objects; /* objects that may be drawn, with EFFECT_OBJECTS; they outlive the picture */
	size_t object_count;
	bool layers;          /* render_show_layer will be called; the plan does not count it */
};

/* Where one of the objects is. */
struct render_object {
	size_t object;           /* index into render_params.objects */
	double at[3];            /* its centre, absolute metres */
	double yaw, pitch, roll; /* radians, as deform_pose has them */
	double turned;           /* radians about its own left axis, forwards: of a wheel, or of a ball that rolls */
};

/* What the colours of the ground show. */
enum render_layer_kind {
	RENDER_NATURAL, /* its natural look */
	RENDER_OFFSETS, /* metres above and below the base */
	RENDER_DISTURBANCE,    /* disturbance from 0 to 1; 0 where none is kept */
	RENDER_HEIGHTS, /* metres */
	RENDER_SLOPES,  /* degrees */
	RENDER_TILES,   /* each tile in the colour of its level */
	RENDER_LAYERS
};
struct render_layer {
	enum render_layer_kind kind;
	double low, high; /* range of the colours, low < high; not used for natural and tiles */
};

struct render;

/* Adds the plan's lines of such a picture. Ignores gpu, slots, reference, low and high. `deformed`: some tile is or may be
 * deformed. `divided`: the working level is below 0, and tiles there are drawn. Pure. */
void render_plan(const struct render_params *params, bool deformed, bool divided, struct plan *plan);

/* Checks that the driver can draw so many samples a pixel. STATUS_INPUT: it cannot; the message names its limit. */
enum status render_check_samples(const struct gpu *gpu, int samples) FURROW_CHECKED;
/* Makes what draws the pictures. Also checks the samples, as render_check_samples does. */
enum status render_create(const struct render_params *params, struct render **out) FURROW_CHECKED;
void render_destroy(struct render *render);
/* Sets the size of the next frames, in pixels. The last frame is lost. After a failure only render_destroy may be called. */
enum status render_resize(struct render *render, uint32_t width, uint32_t height) FURROW_CHECKED;
/* Links every program that pictures of such ground can need. Arguments as render_plan's. */
enum status render_warm(struct render *render, bool deformed, bool divided) FURROW_CHECKED;
/* Draws once with each of these programs, since drivers compile the rest at a program's first draw. The content of the picture
 * is undefined until the next frame. This counts as passes, and as a frame of overdraw. Arguments as render_warm's. */
enum status render_draw_unseen(struct render *render, bool deformed, bool divided) FURROW_CHECKED;
/* Fills the view that terrain_select needs for this camera. */
void render_view(const struct render *render, const struct render_camera *camera, struct terrain_view *view);
/* render_set_objects sets the objects that pictures show from now on, each at most once; none before. It copies them. Without
 * EFFECT_OBJECTS no object is shown; then render_shows_objects is false, and places need not be computed. */
bool render_shows_objects(const struct render *render);
void render_set_objects(struct render *render, const struct render_object *objects, size_t count);
enum status render_frame(struct render *render, const struct render_camera *camera,
			 const struct terrain_selection *selection) FURROW_CHECKED;
/* Sets the layer from the next frame on; natural before the first call. A layer has light and shape, but no haze and no
 * texture. */
void render_show_layer(struct render *render, const struct render_layer *layer);
uint64_t render_triangles(const struct render *render); /* of the last frame */
/* Returns the number of frames whose overdraw is known now and was not returned before. *overdraw: summed over these frames,
 * the samples of ground that passed the depth test, divided by the samples of the picture. 1: ground fills the picture and no
 * part was drawn twice. A driver that takes more samples than asked for makes it larger by that factor. */
uint64_t render_take_overdraw(struct render *render, double *overdraw);
/* Draws of the last frame. `drawn`: tiles; `deformed`: tiles whose draw reads an offset. */
struct render_tiles {
	uint64_t drawn, deformed;
	uint64_t objects;  /* draws of objects (PLAN_OBJECTS) */
	uint64_t shadowed; /* 1: with shadows (PLAN_SHADOWED) */
};
void render_tiles(const struct render *render, struct render_tiles *tiles);
/* Begins to read the last frame into staging, 4 bytes a pixel: sRGB and alpha, row 0 at the bottom. The next frame may be drawn
 * at once. */
void render_read_into(struct render *render, struct gpu_staging *staging);
/* Waits for the last frame and copies it. Either pointer may be NULL. `depth`: m along the view direction, INFINITY: sky.
 * `depth` needs one sample a pixel. */
enum status render_read(struct render *render, uint8_t *pixels, float *depth) FURROW_CHECKED;
/* Writes such pixels to a PNG without alpha: as PATH.part, then renamed. Removes it on failure. Any thread. */
enum status render_png_write(const char *path, const uint8_t *pixels, uint32_t width, uint32_t height) FURROW_CHECKED;
/* Writes the last frame to a PNG, and waits for all of it. */
enum status render_write_png(struct render *render, const char *path) FURROW_CHECKED;

/* --- on the CPU: canvases, and maps of a store. No GL. Any thread; one thread at a time uses a canvas or a map raster --- */

struct render_colour {
	uint8_t r, g, b, a; /* sRGB; a: 255 is opaque */
};

/* Returns the colour of a value in a layer. `t`: 0 at the layer's low end to 1 at its high end. Not for natural and tiles.
 * Pictures add light and shade. */
struct render_colour render_layer_colour(enum render_layer_kind kind, double t);

/* RGBA8 pixels, rows from the lowest up, as GL reads pictures back. A canvas may wrap pixels of the caller. Pixels of
 * render_canvas_create are freed by render_canvas_finish, which also takes a canvas that is all zero. Places are in pixels from
 * the lower left corner; whole numbers are corners of pixels. Parts outside the canvas are not drawn. */
struct render_canvas {
	uint8_t *pixels;
	uint32_t width, height;
};
enum status render_canvas_create(uint32_t width, uint32_t height, struct render_colour fill, struct render_canvas *out)
	FURROW_CHECKED;
void render_canvas_finish(struct render_canvas *canvas);
void render_canvas_box(const struct render_canvas *canvas, int x0, int y0, int x1, int y1, struct render_colour colour);
void render_canvas_disc(const struct render_canvas *canvas, double x, double y, double radius, struct render_colour colour);
/* Draws a line through the points, with round ends and corners. `count` 0: nothing, 1: a dot. */
enum status render_canvas_path(const struct render_canvas *canvas, const double (*points)[2], size_t count, double width,
			       struct render_colour colour) FURROW_CHECKED;
/* Draws one line of text. Each letter has a cell of 6 x 10 pixels times `scale`, which is at least 1. The lower left corner of
 * the first cell is at (x, y). An outline of `scale` pixels goes around it, unless it is fully transparent. `text` is UTF-8.
 * Characters outside ASCII are drawn as question marks. */
#define RENDER_LETTER_WIDTH 6
#define RENDER_LETTER_HEIGHT 10
void render_canvas_text(const struct render_canvas *canvas, int x, int y, int scale, const char *text,
			struct render_colour colour, struct render_colour outline);
int render_text_width(const char *text, int scale); /* pixels */
/* Writes the canvas as a PNG without alpha, under another name first, then renamed. */
enum status render_canvas_write(const struct render_canvas *canvas, const char *path) FURROW_CHECKED;

/* A sun, as a few directions that soften its light. Angles in radians, the azimuth clockwise from north. */
#define RENDER_AZIMUTH (M_PI * 315 / 180)
#define RENDER_ALTITUDE (M_PI / 4)
#define RENDER_SUNS 4
struct render_sun {
	double toward[RENDER_SUNS][3];
};
void render_sun_of(double azimuth, double altitude, struct render_sun *sun);
/* Returns how light ground of this slope is, 0 to 1. `east`, `north`: rise in metres a metre. NaN for NaN. */
double render_shade(const struct render_sun *sun, double east, double north);
/* Computes slopes at width x rows posts `spacing` metres apart. `heights` has one post more at each side; NaN: nodata. */
void render_slopes(const double *heights, int64_t width, int64_t rows, double spacing, double *east, double *north);

/* A map raster: one pixel for each post of `level`, row 0 south. */
struct render_map_raster {
	uint32_t width, height;
	int level;
	double spacing;        /* metres a pixel */
	struct post_rect rect; /* of posts of `level` */
	float *shade;          /* 0 to 1; NaN: nodata */
	float *values;         /* metres: the value of the largest size within the pixel; 0: none */
	double flat;           /* the shade of ground without slope */
};
struct render_map_raster_params {
	struct store_reader *reader;
	const struct store_meta *meta;
	bool deformed;         /* the store has a working level, `working` */
	int working;
	enum store_layer layer; /* STORE_OFFSET, STORE_DEPOSITED, STORE_PLASTIC_SINKAGE or STORE_SHEAR */
	int level;             /* level of the pixels, TILE_LEVEL_MIN to the coarsest */
	struct post_rect rect; /* not empty, within the terrain; held whole in memory, 8 to 12 bytes a pixel */
	struct render_sun sun;
	double exaggerate;     /* factor of heights for the shading; 1: none */
	uint64_t tiles_most;   /* most tiles of the offset to read; a coarser level is used if there are more. 0: all. STORE_OFFSET only */
	store_progress_fn progress; /* NULL: no progress is told; return another status than STATUS_OK to stop */
	void *progress_user;
};
/* Makes a map raster. On failure `out` is all zero. */
enum status render_map_raster_create(const struct render_map_raster_params *params, struct render_map_raster *out) FURROW_CHECKED;
void render_map_raster_finish(struct render_map_raster *raster); /* also takes one that is all zero */
/* Gives each pixel the largest value among its neighbours. Lines of one pixel become three pixels wide. */
enum status render_map_raster_widen(struct render_map_raster *raster) FURROW_CHECKED;

/* Returns the end of a legend for values up to `size`, above 0: the least round number that is no smaller. */
double render_round_range(double size);

/* A map layout: a title, the map in a frame, and below it a legend of colours, a scale bar and a north arrow. */
enum render_ramp { RENDER_RAMP_SIGNED, RENDER_RAMP_GREEN, RENDER_RAMP_ROSE };
struct render_range {
	double low, high; /* metres: the ends of the ramp. `low` is below 0 for the signed ramp, else 0 */
};
struct render_map_layout {
	const struct render_map_raster *raster;
	const char *title, *subtitle; /* above the map: left, and right if there is room */
	const char *layer;            /* the legend's title */
	enum render_ramp ramp;
	struct render_range range; /* both 0: taken from the values, so that 99.9 % of them are within */
	uint32_t side;             /* pixels: a map whose longer side is smaller is enlarged to about this, by a whole factor */
};
/* The map's place on the canvas. A place `east` metres east of the world's south-west post is at x + east * scale; north alike. */
struct render_placed {
	double x, y, scale;
	int left, low, right, high; /* pixels of the canvas that are the map */
	int unit;                   /* the scale of its letters */
};
/* Makes a canvas with the map on it. The caller may then draw on it, even over the map's edges. render_map_layout_frame adds the
 * frame. */
enum status render_map_layout_create(const struct render_map_layout *layout, struct render_canvas *canvas, struct render_placed *placed)
	FURROW_CHECKED;
enum status render_map_layout_frame(const struct render_map_layout *layout, const struct render_canvas *canvas,
			       const struct render_placed *placed) FURROW_CHECKED;

/*
 * --- the view of a world ---
 *
 * The pictures that a scene's `view` asks for. It selects tiles for the camera, finds those that are resident, and draws them.
 * It reads the world. It changes only which pages are requested and used. For the world's thread.
 */
struct view;

/* Makes a view. `watched`: somebody looks at every picture; then no picture waits for its tiles, and layers can be shown. The
 * world's pages must have been started. */
enum status render_view_create(struct world *world, bool watched, struct view **out) FURROW_CHECKED;
void render_view_destroy(struct view *view); /* takes NULL */
/* Fills the parameters of a picture of this world, except gpu, slots, reference, low, high and layers. Pure. */
void render_view_params(const struct world *world, struct render_params *params);
/* Links and runs every program once, so that no step pays for it. If a picture may follow any step, it also loads what the
 * first picture needs and draws it. */
enum status render_view_warm(struct view *view) FURROW_CHECKED;
/* Draws a picture of the present. `image`: waits for the tiles that it needs, and begins to write it to `pictures`. */
struct pictures;
enum status render_view_frame(struct view *view, struct pictures *pictures, bool image) FURROW_CHECKED;
/* Call after a step without a picture. Passes on pictures that are being read back, and requests tiles for the next picture. */
enum status render_view_between(struct view *view, struct pictures *pictures) FURROW_CHECKED;
/* Call after the last step. Waits for what the GPU still counts. */
void render_view_settle(struct view *view);
/* Returns the view as a watcher of its world, for world_watch. */
struct world_watcher render_view_watcher(struct view *view);
enum status render_view_deformed(struct view *view, struct tile tile) FURROW_CHECKED;
enum status render_view_contact(struct view *view, const struct event *event, const struct contact_area *area) FURROW_CHECKED;
enum status render_view_requests(struct view *view, struct requests *requests) FURROW_CHECKED;
void render_view_reach_at_least(struct view *view, double metres);
struct render_view_figures {
	double triangles;   /* triangles a frame */
	double overdraw;    /* samples of ground drawn, divided by the picture's: mean of the frames that were counted; NaN: none was */
	uint64_t frames;    /* pictures drawn */
	uint64_t starved;   /* frames drawn coarser than asked for: a coarser tile was drawn instead, or detail was reduced */
	uint64_t coarsened; /* frames whose detail was reduced to fit the slots */
	uint64_t naps;      /* waits of written pictures for their tiles, */
	double nap_ms;      /* and their time, without the world's stalls and waits for ranges */
	struct render_tiles tiles; /* draws of tiles, objects and shadows */
};
void render_view_figures(const struct view *view, struct render_view_figures *figures);
/* For a host that watches: */
void render_view_look_from(struct view *view, const struct render_camera *camera); /* NULL: the scene's camera */
void render_view_scene_camera(struct view *view, struct render_camera *camera);    /* the scene's camera, now */
void render_view_show_layer(struct view *view, const struct render_layer *layer);
enum status render_view_resize(struct view *view, uint32_t width, uint32_t height) FURROW_CHECKED; /* from the next picture on */
/* Draws the whole picture now, from the camera given to render_view_look_from, and waits for it. `pixels`: RGBA as in
 * render_view_read_into. `depth`: m along the view direction, INFINITY: sky, rows from the lowest up; needs one sample a pixel.
 * Either may be NULL. */
enum status render_view_picture(struct view *view, uint8_t *pixels, float *depth) FURROW_CHECKED;
bool render_view_lacks(const struct view *view);         /* the last picture was drawn before all its tiles were resident */
uint64_t render_view_triangles(const struct view *view); /* of the last picture */
/* Begins to read the last picture into staging: 4 x width x height bytes. */
void render_view_read_into(struct view *view, struct gpu_staging *staging);

/*
 * --- pictures that are written ---
 *
 * Takes pictures from the GPU to their files while steps go on: frame-NNNNNN.png of a folder. Each is written under another
 * name, then renamed. For the GPU's thread. It has one thread of its own, which writes.
 *
 * After a failure to read back or to write, every later call returns that failure with its message. Pictures begun before it
 * are still tried. In the end each picture is complete or missing.
 */
/* Most pictures in memory at once, from read-back to written file. */
#define PICTURES_ROOM 3
#define PICTURES_THREAD "furrow-images"

/* Adds the plan's lines of pictures of this size. Pure. */
void render_pictures_plan(uint32_t width, uint32_t height, struct plan *plan);

/* Makes it for pictures of this size and starts its thread. `directory` stays the caller's and must outlive it. */
enum status render_pictures_create(struct gpu *gpu, const char *directory, uint32_t width, uint32_t height,
			    struct pictures **out) FURROW_CHECKED;
/* Finishes all pictures that were begun and stops the thread. After it call only render_pictures_figures and
 * render_pictures_destroy. */
void render_pictures_stop(struct pictures *pictures);
void render_pictures_destroy(struct pictures *pictures); /* takes NULL; stops first */

/* The following functions do nothing for NULL, except render_pictures_figures. */
/* Begins to write the last frame, as the picture after `step` steps. If PICTURES_ROOM are unfinished, it waits for the first. */
enum status render_pictures_begin(struct pictures *pictures, struct render *render, int64_t step) FURROW_CHECKED;
/* Passes finished read-backs to the thread. Never waits. Call it once a step. */
enum status render_pictures_poll(struct pictures *pictures) FURROW_CHECKED;
/* Waits until the GPU has read back all pictures that were begun, and marks them. */
void render_pictures_mark(struct pictures *pictures);
/* Waits until all pictures marked last are in their files. Any thread. */
enum status render_pictures_await(struct pictures *pictures) FURROW_CHECKED;

struct render_pictures_figures {
	uint64_t written, waits; /* files written; times that a call waited */
	double wait_ms;
};
void render_pictures_figures(struct pictures *pictures, struct render_pictures_figures *figures);

#endif
