/*
 * render: the picture. Draws what terrain selected from the slots, in one instanced draw a tile,
 * with only the effects the scene names compiled in; reads it back and writes PNGs.
 * For the GPU's thread. And maps, drawn on the CPU.
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
	double up[3];             /* what is up in the picture; all 0: z is */
};

struct render_params {
	struct gpu *gpu;
	struct gpu_slots *slots;
	const struct extent *extent;
	int32_t reference;    /* metres */
	double low, high;     /* of the terrain, for colours by height */
	int width, height;
	uint64_t effects;     /* EFFECT_BIT of each */
	bool dirt;
	const struct scene_light *light; /* where it is, and the sun; NULL: as a scene that says nothing */
	const struct scene *soils; /* for splat: whose soils the slots' classes are; must outlive the picture. NULL: none */
	double pixel_error;   /* pixels a picture's ground may be off by; 0: its detail goes by the radii (camera.c) */
	int samples;          /* a pixel; 0 as 1: its colour is of its middle */
	const struct scene_object *objects; /* that there may be, with EFFECT_OBJECTS; they outlive the picture */
	size_t object_count;
	bool layers;          /* render_show_layer will be called: the plan knows nothing of it */
};

/* Where one of them is. */
struct render_object {
	size_t object;           /* of render_params.objects */
	double at[3];            /* its centre, absolute metres */
	double yaw, pitch, roll; /* radians, as deform_pose has them */
	double turned;           /* radians about its own left, forwards: of a wheel, of a ball that rolls */
};

/* What the ground's colours tell. */
enum render_layer_kind {
	RENDER_NATURAL, /* what it looks like */
	RENDER_OFFSETS, /* metres above and below the base */
	RENDER_DIRT,    /* 0 clean to 1; where no dirt is kept: clean */
	RENDER_HEIGHTS, /* metres */
	RENDER_SLOPES,  /* degrees */
	RENDER_TILES,   /* each tile, in the colour of its level */
	RENDER_LAYERS
};
struct render_layer {
	enum render_layer_kind kind;
	double low, high; /* what the colours range over, low < high; of natural and tiles no matter */
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
/* Frames from the next one on are of so many pixels; the last is gone. After a failure only render_destroy is left. */
enum status render_resize(struct render *render, uint32_t width, uint32_t height) FURROW_CHECKED;
/* Links every program that pictures of such ground can ask for: arguments as render_plan's. */
enum status render_warm(struct render *render, bool deformed, bool divided) FURROW_CHECKED;
/* Draws with each of them once, beside the picture: drivers compile the rest at a program's first draw. What the picture
 * shows until the next frame is undefined. Counts as passes, and as a frame of overdraw. Arguments as render_warm's. */
enum status render_draw_unseen(struct render *render, bool deformed, bool divided) FURROW_CHECKED;
/* The view terrain_select needs for this camera. */
void render_view(const struct render *render, const struct render_camera *camera, struct terrain_view *view);
/* What of the objects the pictures from now on show, each at most once; none before. Copied. Without EFFECT_OBJECTS
 * nothing is, and nobody need find out where they are. */
bool render_shows_objects(const struct render *render);
void render_set_objects(struct render *render, const struct render_object *objects, size_t count);
enum status render_frame(struct render *render, const struct render_camera *camera,
			 const struct terrain_selection *selection) FURROW_CHECKED;
/* From the next frame on; natural until then. Light and shape stay; haze and texture go. */
void render_show_layer(struct render *render, const struct render_layer *layer);
uint64_t render_triangles(const struct render *render); /* of the last frame */
/* Of the frames of which that is known by now, and was not told before, how many there are; *overdraw: summed over them, the
 * samples of ground that passed the depth test, over the picture's. 1: the ground fills the picture and no part of it was
 * drawn over. A driver that takes more samples than it was asked for makes it so much larger. */
uint64_t render_take_overdraw(struct render *render, double *overdraw);
/* Tiles of the last frame, and those of them whose draw reads an offset. */
struct render_tiles {
	uint64_t drawn, deformed;
	uint64_t objects;  /* draws of objects (PLAN_OBJECTS) */
	uint64_t shadowed; /* 1: with shadows (PLAN_SHADOWED) */
};
void render_tiles(const struct render *render, struct render_tiles *tiles);
/* Begins to read the last frame into staging of 4 bytes a pixel: sRGB and alpha, row 0 at the bottom. Another may be drawn
 * at once. */
void render_read_into(struct render *render, struct gpu_staging *staging);
/* Waits for the last frame and copies it. Either may be NULL. `depth`: m along the view direction, INFINITY: sky; one sample a
 * pixel only. */
enum status render_read(struct render *render, uint8_t *pixels, float *depth) FURROW_CHECKED;
/* Such pixels to a file, without alpha: written as PATH.part, then renamed; nothing is left of what fails. Any thread. */
enum status render_png_write(const char *path, const uint8_t *pixels, uint32_t width, uint32_t height) FURROW_CHECKED;
/* Writes the last frame, and waits for all of it. */
enum status render_write_png(struct render *render, const char *path) FURROW_CHECKED;

/* --- on the CPU: canvases, and maps of a store. No GL; any thread, each canvas and survey by one at a time --- */

struct render_colour {
	uint8_t r, g, b, a; /* sRGB; a: 255 is opaque */
};

/* What a value is coloured by a layer, of natural and tiles nothing: `t` from 0, its low end, to 1. In a picture light and
 * shade come on top. */
struct render_colour render_layer_colour(enum render_layer_kind kind, double t);

/* RGBA8 pixels, rows from the lowest up, as GL reads pictures back. May be made of any such pixels; those of
 * render_canvas_create are freed by render_canvas_finish (of one that is all zero, too). Places are in pixels from the
 * lower left corner, of corners between pixels; what lies beyond is not drawn. */
struct render_canvas {
	uint8_t *pixels;
	uint32_t width, height;
};
enum status render_canvas_create(uint32_t width, uint32_t height, struct render_colour fill, struct render_canvas *out)
	FURROW_CHECKED;
void render_canvas_finish(struct render_canvas *canvas);
void render_canvas_box(const struct render_canvas *canvas, int x0, int y0, int x1, int y1, struct render_colour colour);
void render_canvas_disc(const struct render_canvas *canvas, double x, double y, double radius, struct render_colour colour);
/* A line through the points, round at its ends and corners; `count` 0: nothing, 1: a dot. */
enum status render_canvas_path(const struct render_canvas *canvas, const double (*points)[2], size_t count, double width,
			       struct render_colour colour) FURROW_CHECKED;
/* One line of letters, each in a cell of 6 x 10 pixels times `scale` (at least 1), the lower left corner of the first at
 * (x, y); with an outline of `scale` pixels around, unless that is all transparent. UTF-8; what is not ASCII is a question mark. */
#define RENDER_LETTER_WIDTH 6
#define RENDER_LETTER_HEIGHT 10
void render_canvas_text(const struct render_canvas *canvas, int x, int y, int scale, const char *text,
			struct render_colour colour, struct render_colour outline);
int render_text_width(const char *text, int scale); /* pixels */
/* As a PNG, without its alpha; aside and renamed. */
enum status render_canvas_write(const struct render_canvas *canvas, const char *path) FURROW_CHECKED;

/* A sun and what softens it; radians, the azimuth clockwise from north. */
#define RENDER_AZIMUTH (M_PI * 315 / 180)
#define RENDER_ALTITUDE (M_PI / 4)
#define RENDER_SUNS 4
struct render_sun {
	double toward[RENDER_SUNS][3];
};
void render_sun_of(double azimuth, double altitude, struct render_sun *sun);
/* How light ground of a slope is (metres a metre), 0 to 1; NaN of NaN. */
double render_shade(const struct render_sun *sun, double east, double north);
/* Slopes at width x rows posts `spacing` metres apart; `heights` has a post more at each side, NaN: nodata. */
void render_slopes(const double *heights, int64_t width, int64_t rows, double spacing, double *east, double *north);

/* What a map shows of a store: a pixel a post of `level`, row 0 south. */
struct render_survey {
	uint32_t width, height;
	int level;
	double spacing;        /* metres a pixel */
	struct post_rect rect; /* of posts of `level` */
	float *shade;          /* 0 to 1; NaN: nodata */
	float *values;         /* metres: the largest, whatever its sign, within the pixel; 0: none */
	double flat;           /* the shade of level ground */
};
struct render_survey_params {
	struct store_reader *reader;
	const struct store_meta *meta;
	bool deformed;         /* the store has a working level: */
	int working;
	enum store_layer layer; /* STORE_OFFSET, STORE_HEAPED, STORE_PRESSED or STORE_SHEAR */
	int level;             /* of the pixels, TILE_LEVEL_MIN to the coarsest */
	struct post_rect rect; /* not empty, within the terrain; all of it is held at once, 8 to 12 bytes a pixel */
	struct render_sun sun;
	double exaggerate;     /* heights are shaded as if times so many; 1 */
	uint64_t tiles_most;   /* read of the offset at most, at a coarser level if need be; 0: all. STORE_OFFSET only */
	store_progress_fn progress; /* NULL: not told; return other than STATUS_OK to stop */
	void *progress_user;
};
/* On failure `out` is all zero. */
enum status render_survey_create(const struct render_survey_params *params, struct render_survey *out) FURROW_CHECKED;
void render_survey_finish(struct render_survey *survey); /* of one that is all zero too */
/* Each pixel takes the largest value beside it: lines of one pixel are then three wide. */
enum status render_survey_widen(struct render_survey *survey) FURROW_CHECKED;

/* The end of a legend for values up to `size`, above 0: the least number with a round half that is no smaller. */
double render_round_range(double size);

/* A map as it is printed: title, map in a frame, and below it a legend of colours, a scale bar, north. */
enum render_ramp { RENDER_RAMP_SIGNED, RENDER_RAMP_GREEN, RENDER_RAMP_ROSE };
struct render_range {
	double low, high; /* metres: the ramp's ends. low is below 0 for the signed ramp, 0 for others */
};
struct render_sheet {
	const struct render_survey *survey;
	const char *title, *subtitle; /* above: left, and right if there is room */
	const char *layer;            /* the legend's title */
	enum render_ramp ramp;
	struct render_range range; /* both 0: by the values, so that all but a thousandth are within */
	uint32_t side;             /* a map smaller than this on its long side is enlarged to about that, by a whole factor */
};
/* The map's place on the canvas: a metre east and north of the world's south-west post is at x + east * scale, ... */
struct render_placed {
	double x, y, scale;
	int left, low, right, high; /* pixels of the canvas that are the map */
	int unit;                   /* the scale of its letters */
};
/* Makes a canvas with the map on it; what is then drawn there (over its edges too) is framed by render_sheet_frame. */
enum status render_sheet_create(const struct render_sheet *sheet, struct render_canvas *canvas, struct render_placed *placed)
	FURROW_CHECKED;
enum status render_sheet_frame(const struct render_sheet *sheet, const struct render_canvas *canvas,
			       const struct render_placed *placed) FURROW_CHECKED;

/*
 * --- the view of a world ---
 *
 * The picture that a scene's `view` asks for: what terrain selected for the camera, what the cache has of it, what is drawn.
 * It reads the world and changes nothing of it but which pages are requested and used. For the world's thread.
 */
struct view;

/* `watched`: somebody looks at every picture, so that none waits for its tiles, and layers are shown. The world must have been
 * started with its pages. */
enum status render_view_create(struct world *world, bool watched, struct view **out) FURROW_CHECKED;
void render_view_destroy(struct view *view); /* takes NULL */
/* What a picture of this world is made with. Without gpu, slots, reference, low, high and layers. Pure. */
void render_view_params(const struct world *world, struct render_params *params);
/* Links and runs every program once, so that no step pays for that. Where a picture may come after any step, loads what the
 * first one needs and draws it. */
enum status render_view_warm(struct view *view) FURROW_CHECKED;
/* Draws the picture of now. `image`: waits for what the picture needs, and begins to write it to `pictures`. */
struct pictures;
enum status render_view_frame(struct view *view, struct pictures *pictures, bool image) FURROW_CHECKED;
/* After a step of which no picture is drawn: hands on pictures that are on their way, and looks ahead to the next. */
enum status render_view_between(struct view *view, struct pictures *pictures) FURROW_CHECKED;
/* After the last step: waits for what the GPU still counts. */
void render_view_settle(struct view *view);
/* The view as a watcher of its world: for world_watch. */
struct world_watcher render_view_watcher(struct view *view);
enum status render_view_deformed(struct view *view, struct tile tile) FURROW_CHECKED;
enum status render_view_pressed(struct view *view, const struct event *event, const struct contact_area *area) FURROW_CHECKED;
enum status render_view_requests(struct view *view, struct requests *requests) FURROW_CHECKED;
void render_view_reach_at_least(struct view *view, double metres);
struct render_view_figures {
	double triangles;   /* a frame */
	double overdraw;    /* samples of ground drawn, over the picture's: a frame, of those that could be counted; NaN: of none */
	uint64_t frames;    /* pictures drawn */
	uint64_t starved;   /* frames drawn coarser than asked for: a tile stood in, or coarsened */
	uint64_t coarsened; /* frames cut to what the slots hold */
	uint64_t naps;      /* written pictures that waited for their tiles; */
	double nap_ms;      /* how long, without what the world counts as stalls and waits for ranges */
	struct render_tiles tiles; /* draws of tiles, objects and shadows */
};
void render_view_figures(const struct view *view, struct render_view_figures *figures);
/* For who watches: */
void render_view_look_from(struct view *view, const struct render_camera *camera); /* NULL: the scene's camera */
void render_view_scene_camera(struct view *view, struct render_camera *camera);    /* the scene's camera, now */
void render_view_show_layer(struct view *view, const struct render_layer *layer);
enum status render_view_resize(struct view *view, uint32_t width, uint32_t height) FURROW_CHECKED; /* from the next picture on */
/* Draws the whole picture now, from the camera that render_view_look_from gave, and waits for it. `pixels`: RGBA as render_view_read_into's;
 * `depth`: m along the view direction, INFINITY: sky, rows from the lowest; only of pictures of one sample a pixel. Either may be
 * NULL. */
enum status render_view_picture(struct view *view, uint8_t *pixels, float *depth) FURROW_CHECKED;
bool render_view_lacks(const struct view *view);         /* the last picture was drawn before all its tiles had come */
uint64_t render_view_triangles(const struct view *view); /* of the last picture */
/* Begins to bring the last picture: gpu_texture_read_into, 4 x width x height bytes. */
void render_view_read_into(struct view *view, struct gpu_staging *staging);

/*
 * --- pictures that are written ---
 *
 * Pictures that are kept, on their way from the GPU to their files while steps go on: frame-NNNNNN.png of a folder, each
 * written aside and renamed. For the GPU's thread; one thread of its own writes.
 *
 * A failure to read back or to write is kept, with its whole message, and returned by every call from then on. What was
 * begun before is tried all the same: when it is over, each picture is whole or not there.
 */
/* What is kept at once, from the picture that is read back to the one that is written. */
#define PICTURES_ROOM 3
#define PICTURES_THREAD "furrow-images"

/* The lines of pictures of so many pixels. Pure. */
void render_pictures_plan(uint32_t width, uint32_t height, struct plan *plan);

/* Of so many pixels. The folder's name stays the caller's and must outlive it. */
enum status render_pictures_create(struct gpu *gpu, const char *directory, uint32_t width, uint32_t height,
			    struct pictures **out) FURROW_CHECKED;
/* Ends what was begun and stops the thread; then only render_pictures_figures and render_pictures_destroy. */
void render_pictures_stop(struct pictures *pictures);
void render_pictures_destroy(struct pictures *pictures); /* takes NULL; stops first */

/* All of these but render_pictures_figures take NULL, of which nothing is asked. */
/* Begins with the last frame, the picture after so many steps. Waits if PICTURES_ROOM are under way, for the first. */
enum status render_pictures_begin(struct pictures *pictures, struct render *render, int64_t step) FURROW_CHECKED;
/* Hands on what the GPU is done with. Never waits; call it once a step. */
enum status render_pictures_poll(struct pictures *pictures) FURROW_CHECKED;
/* Marks all that were begun, when the GPU is done with them, which is waited for. */
void render_pictures_mark(struct pictures *pictures);
/* Any thread: waits until what was marked last is in its files. */
enum status render_pictures_await(struct pictures *pictures) FURROW_CHECKED;

struct render_pictures_figures {
	uint64_t written, waits; /* files; times that a call waited */
	double wait_ms;
};
void render_pictures_figures(struct pictures *pictures, struct render_pictures_figures *figures);

#endif
