/*
 * render: pictures. It draws the tiles that terrain selected, each tile with one instanced draw. Shaders contain only the
 * effects that the scene names. It reads pictures back and writes PNGs. Call it on the GPU's thread.
 */
#ifndef FURROW_RENDER_H
#define FURROW_RENDER_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "base/plan.h"
#include "chart/chart.h"
#include "gpu/gpu.h"
#include "scene/scene.h"
#include "render/select.h"
#include "store/store.h"
#include "world/world.h"

struct render_camera {
	double eye[3], target[3]; /* absolute metres */
	double fov;               /* vertical, radians */
	double up[3];             /* direction that is up in the picture; all zero: the z axis */
};

struct render_imagery; /* imagery.h: the colours that the store has for the ground */

struct render_params {
	struct gpu *gpu;
	struct gpu_slots *slots;
	const struct extent *extent;
	int32_t reference;    /* metres */
	double low, high;     /* lowest and highest height of the terrain, for colours by height */
	int width, height;
	uint64_t effects;     /* EFFECT_BIT of each */
	bool disturbance;
	bool heals;           /* disturbance heals: the slots have PLANE_HEALED in place of it */
	const struct scene_vegetation *vegetation; /* must stay valid longer than the render; NULL: none is drawn */
	bool cover_by_class;  /* the slots have classes of soil, and vegetation differs between them */
	const struct scene_light *light; /* the planet and the sun; NULL: the default of a scene */
	/* for the effect splat: its soils are the classes in the slots. Must stay valid longer than the render; NULL: none */
	const struct scene *soils;
	struct render_imagery *imagery; /* with EFFECT_IMAGERY; must stay valid longer than the render. Plans do not need it */
	double imagery_budget; /* MB; for plans alone, as the next one */
	uint32_t loaders;     /* threads that read imagery */
	bool one_soil;        /* with the effect texture all ground looks like the first of `soils`, whatever class it has */
	double pixel_error;   /* pixels by which drawn ground may be wrong; 0: distance alone decides the detail (camera.c) */
	int samples;          /* samples for each pixel; 0 and 1: only the colour at the pixel's centre */
	/* objects that may be drawn, with EFFECT_OBJECTS; must stay valid longer than the render */
	const struct scene_object *objects;
	size_t object_count;
	size_t grains;        /* the most grains of soil that a picture shows; 0: none */
	bool heaps;           /* render_set_heaps will be called */
	bool layers;          /* render_show_layer will be called; plans do not count layers */
	bool measures;        /* render_measure will be called */
	bool classes;         /* the slots have classes of soil, which render_measure tells */
	/* Some pictures have the light of the drawn surface alone: render_set_truth. `only_truth`: all have. Both false: none has */
	bool truth, only_truth;
	/* Brings a slot up to date before it is drawn: resident_pages_show. `planes` false: only its base is needed. NULL: slots always are */
	enum status (*show)(void *user, uint32_t slot, bool planes);
	void *user;           /* passed to `show` */
};

/* Where one of the objects is. */
struct render_object {
	size_t object;           /* index into render_params.objects */
	double at[3];            /* its centre, absolute metres */
	double yaw, pitch, roll; /* radians, as soil_pose has them */
	bool posed;              /* `axes` count instead of the four angles: forward, left, up, with what it turned */
	double axes[3][3];
	double turned;           /* radians about its own left axis, forwards: of a wheel, or of a ball that rolls */
	bool painted;            /* it has this colour; false: the colours of its shape. The rim of a wheel stays metal */
	float colour[3];         /* albedo, linear */
	uint32_t number;         /* of the body in pictures of instances (world_instance_of); 0: none */
};

/* A grain of soil in the air. */
struct render_grain {
	double at[3], radius; /* absolute metres, metres */
	uint32_t number;      /* by which its form differs from that of others */
};

/* Soil aboard a body, as struct soil_carried has it: side x side cells, row by row. Rows go along `heading`, and the first one is on their right. */
struct render_heap {
	double at[3];    /* absolute metres: the middle of the middle cell, where tops are 0 */
	double ground;   /* absolute metres: of the ground below, whose look the soil has */
	double heading;  /* rad, from east to north */
	double spacing;  /* m: of cells */
	int side;
	int class;       /* of the soil */
	const int32_t *amounts, *tops;
	const uint8_t *shares; /* how much of each cell is above the body, of RENDER_HEAP_SHARES; NULL: all of each */
};
#define RENDER_HEAP_SHARES 64

/* What the colours of the ground show. */
enum render_layer_kind {
	RENDER_NATURAL, /* the natural look of the ground */
	RENDER_OFFSETS, /* metres above and below the base */
	RENDER_DISTURBANCE,    /* disturbance from 0 to 1; 0 if the slots have no disturbance */
	RENDER_HEIGHTS, /* metres */
	RENDER_SLOPES,  /* degrees */
	RENDER_TILES,   /* each tile in the colour of its level */
	RENDER_LAYERS
};
struct render_layer {
	enum render_layer_kind kind;
	double low, high; /* values at the ends of the colour range, low < high; not used for natural and tiles */
};

struct render;

/* Adds the plan's lines of pictures with these params. Ignores gpu, slots, reference, low and high. `deformed`: some tile is or
 * may be deformed. `divided`: the working level is below 0, and such tiles are drawn. `smooth`: also those that nothing deformed, if
 * they are interpolated. Pure. */
void render_plan(const struct render_params *params, bool deformed, bool divided, bool smooth, struct plan *plan);

/* Checks that pictures can show the imagery of the store. STATUS_INPUT: it has none. STATUS_FAILED: this build cannot read it. `store` NULL: no
 * store is known, and nothing is refused. */
enum status render_imagery_check(const struct store *store) FURROW_CHECKED;
/* Checks that the driver can draw so many samples a pixel. STATUS_INPUT: it cannot; the message names its limit. */
enum status render_check_samples(const struct gpu *gpu, int samples) FURROW_CHECKED;
/* Makes the programs and buffers for pictures. Also checks the samples, as render_check_samples does. */
enum status render_create(const struct render_params *params, struct render **out) FURROW_CHECKED;
void render_destroy(struct render *render);
/* Sets the size of the next frames, in pixels. The last frame is lost. After a failure only render_destroy may be called. */
enum status render_resize(struct render *render, uint32_t width, uint32_t height) FURROW_CHECKED;
/* Links every program that such pictures can need. Arguments as for render_plan. */
enum status render_warm(struct render *render, bool deformed, bool divided, bool smooth) FURROW_CHECKED;
/* Draws once with each of these programs, because drivers finish compiling at the first draw. The picture is undefined until
 * the next frame. This counts as passes, and as a frame of overdraw. Arguments as for render_warm. */
enum status render_draw_unseen(struct render *render, bool deformed, bool divided, bool smooth) FURROW_CHECKED;
/* Fills the view that render_select needs for this camera. */
void render_view(const struct render *render, const struct render_camera *camera, struct render_view *view);
/* render_set_objects copies the objects that pictures show from now on, each at most once. Before the first call there are
 * none. Without EFFECT_OBJECTS none is shown: render_shows_objects returns false, and their places need not be computed. */
bool render_shows_objects(const struct render *render);
void render_set_objects(struct render *render, const struct render_object *objects, size_t count);
/* Copies the grains that pictures show from now on, at most render_params.grains. Without those it does nothing. */
void render_set_grains(struct render *render, const struct render_grain *grains, size_t count);
/* Sets the soil aboard bodies that pictures show from now on. The lists are read in this call alone. Without render_params.heaps it does nothing. STATUS_MEMORY. */
enum status render_set_heaps(struct render *render, const struct render_heap *heaps, size_t count) FURROW_CHECKED;
enum status render_frame(struct render *render, const struct render_camera *camera,
			 const struct render_selection *selection) FURROW_CHECKED;
/* Sets the time at which marks that fade are shown, from the next frame on. At the start none is left. */
void render_set_marks(struct render *render, const struct plane_marks *marks);
/* Sets the layer that pictures show from the next frame on. At the start it is RENDER_NATURAL. Other layers have light and
 * shade, but no haze and no texture. */
void render_show_layer(struct render *render, const struct render_layer *layer);
/*
 * Shadows of the terrain, with EFFECT_TERRAIN_SHADOW. Before render_frame of the same camera: call render_shade_begin, and for each of the
 * RENDER_SHADE_MAPS maps render_shade_view, select tiles for that view, and call render_shade_draw. render_shade_view returns false if the
 * map is not needed. `ground`: height of the ground below the camera, m. Each draw counts its tiles in render_tiles.
 */
#define RENDER_SHADE_MAPS 4
void render_shade_begin(struct render *render);
bool render_shade_view(const struct render *render, const struct render_camera *camera, double ground, int map, struct render_view *view);
enum status render_shade_draw(struct render *render, const struct render_camera *camera, int map, const struct render_view *view,
			      const struct render_selection *selection) FURROW_CHECKED;
/* Draws the last frame again as numbers. A pixel has four floats: the normal east and north, the height above the eye (m), and a code.
 * Codes: 0 is sky, and 1 + class the soil of the ground or aboard a body. -1 - 2 n is the body with the number n; -2 - 2 n is the same where its normal points down. A grain has the number 0. Of slots without classes the class is 0. The depth
 * texture becomes the same again. Counts as a frame in render_tiles. */
enum status render_measure(struct render *render, const struct render_camera *camera, const struct render_selection *selection) FURROW_CHECKED;
uint64_t render_triangles(const struct render *render); /* returns the triangles of the last frame */
/* Returns the number of frames whose overdraw became known since the last call. *overdraw: sum over these frames of the samples
 * of ground that passed the depth test, divided by the samples of the picture. 1 for a frame: ground fills the picture and is
 * drawn once. If the driver uses more samples than asked for, the result is larger by that factor. */
uint64_t render_take_overdraw(struct render *render, double *overdraw);
/* Counts of the last frame. `drawn`: tiles. `deformed`: tiles that are drawn with offsets. */
struct render_tiles {
	uint64_t drawn, deformed;
	uint64_t objects;  /* draws of objects (PLAN_OBJECTS) */
	uint64_t shadowed; /* 1: with shadows (PLAN_SHADOWED) */
};
void render_tiles(const struct render *render, struct render_tiles *tiles);
/* Sets whether frames from the next one on have the light of the drawn surface alone, as depth shows it. Each triangle then has one light, and
 * textures have no detail. At the start it is render_params.only_truth. False colours do not change. Only what render_params allows may be set. */
void render_set_truth(struct render *render, bool truth);
/* Moves the sun, from the next frame on. Azimuth clockwise from the store's north, and height, rad. */
void render_move_sun(struct render *render, double azimuth, double height);
/* Sets the exposure, from the next frame on. */
void render_expose_by(struct render *render, enum scene_exposure exposure, double ev);
double render_exposed(const struct render *render); /* returns the factor by which the last frame's light was exposed */
/* Begins to read the last frame into a staging buffer, the bottom row first. Colour: sRGB and alpha, 4 bytes for each pixel. Depth: a
 * float of the depth texture; with several samples for each pixel, of what render_measure drew. Other images: what render_measure drew, 16 bytes for each pixel. The next
 * frame may be drawn at once. */
void render_read_into(struct render *render, enum scene_image image, struct gpu_staging *staging);
/* Waits for the last frame and copies it. Either pointer may be NULL. `depth`: metres along the view direction, INFINITY: sky.
 * `depth` can only be read with one sample for each pixel. */
enum status render_read(struct render *render, uint8_t *pixels, float *depth) FURROW_CHECKED;
/* Writes the last frame to a PNG, and waits for all of it. */
enum status render_write_png(struct render *render, const char *path) FURROW_CHECKED;

/* Returns the colour of a value in a layer. `t`: 0 at the layer's low end, 1 at its high end. Not for natural and tiles. The
 * result is without light and shade. */
struct chart_colour render_layer_colour(enum render_layer_kind kind, double t);

/*
 * --- the view of a world ---
 *
 * Draws the pictures that a scene's `view` asks for. It selects tiles for the camera, finds those that are resident, and draws
 * them. It only reads the world, but requests and uses pages. Call it on the world's thread.
 */
struct view;

/* Makes a view. `watched`: somebody watches every picture, as in a window. Then no picture waits for its tiles, and layers can
 * be shown. The world's pages must have been started. */
enum status render_view_create(struct world *world, bool watched, struct view **out) FURROW_CHECKED;
void render_view_destroy(struct view *view); /* view may be NULL */
/* The scene's light with its place. */
struct render_sun {
	struct scene_light light;
	double north;           /* rad: true north, clockwise from the store's */
};
/* Finds the place of a light that has a time: the middle of the terrain, if the scene gives none. STATUS_INPUT: the store has no place
 * on a globe. */
enum status render_sun_find(const struct scene_light *light, const struct store_meta *meta, struct render_sun *out) FURROW_CHECKED;
/* Gives where the sun is at a time of the drive, s. Angles in rad: azimuth clockwise from the store's north, height above the horizon. */
void render_sun_at(const struct render_sun *sun, double time, double *azimuth, double *height);
/* Returns how many times as bright pictures get with `view.exposure: sun` under this light, 1 to 32. Pure. */
double render_sun_brightens(const struct scene_light *light);
/* Fills the parameters of a picture of this world, except gpu, slots, reference, low, high and layers. Pure. */
void render_view_params(const struct world *world, struct render_params *params);
/* Returns true if pictures have tiles below level 0 that nothing deformed. The ground between posts of level 0 is bilinear, and its
 * triangles would be too coarse. Where relief raises all levels below 0, they have heights of their own. Pure. */
bool render_view_smooths(const struct world *world);
/* Links and runs every program once, so that no step has to. If a picture may follow any step, it also loads the tiles of the
 * first picture and draws it. */
enum status render_view_warm(struct view *view) FURROW_CHECKED;
/* Draws the present picture. `image`: waits for the tiles that it needs, and begins to write it to `pictures`. */
struct pictures;
enum status render_view_frame(struct view *view, struct pictures *pictures, bool image) FURROW_CHECKED;
/* Call this after a step without a picture. Continues writing earlier pictures, and requests tiles for the next one. */
enum status render_view_between(struct view *view, struct pictures *pictures) FURROW_CHECKED;
/* Where a camera is: local metres, and unit vectors at right angles. */
struct render_pose {
	double eye[3], right[3], up[3], forward[3];
	double exposure;    /* of the frame: factor of the light */
	uint64_t triangles; /* of ground in the frame */
};
/* Takes the poses of frames as they are drawn. `camera`: index of the scene's camera. */
struct render_poses {
	void *user;
	enum status (*take)(void *user, size_t camera, int64_t frame, const struct render_pose *pose);
};
/* Draws the frames that the scene's cameras write after the present step, and begins to write them: DIR/cameras/NAME/IMAGE/NNNNNN.png.
 * Waits for the tiles of each. Does nothing if no camera has a frame now. `poses` may be NULL. */
enum status render_view_cameras(struct view *view, struct pictures *pictures, const struct render_poses *poses) FURROW_CHECKED;
#define RENDER_CAMERAS "cameras" /* folder of the cameras' folders */
/* STATUS_INPUT if the pictures of the scene's cameras take more than `memory` bytes. 0: not known. */
enum status render_cameras_fit(const struct scene *scene, uint64_t memory) FURROW_CHECKED;
/* Makes the folders of the cameras' pictures, if they do not exist. */
enum status render_cameras_folders(const struct scene *scene, const char *directory) FURROW_CHECKED;
/* Adds the plan's lines of the cameras' screens. Pure. */
void render_cameras_plan(const struct scene *scene, struct plan *plan);
/* Call this after the last step. Waits for results that the GPU is still counting. */
void render_view_settle(struct view *view);
/* Takes what happened in the world since the last call. Call it before a commit takes the record. Pictures call it themselves. */
enum status render_view_update(struct view *view) FURROW_CHECKED;
/* Tells the world, before a step, which tiles pictures will need: world_prefetch. */
enum status render_view_prefetch(struct view *view) FURROW_CHECKED;
enum status render_view_deformed(struct view *view, struct tile tile) FURROW_CHECKED;
/* The next tiles that deform belong to this contact; NULL: to relaxation. */
enum status render_view_contact(struct view *view, const struct world_touch *touch) FURROW_CHECKED;
enum status render_view_requests(struct view *view, struct requests *requests) FURROW_CHECKED;
void render_view_reach_at_least(struct view *view, double metres);
struct render_view_figures {
	double triangles;   /* triangles for each frame */
	/* samples of ground drawn, divided by the picture's samples: mean over the frames that were counted; NaN: none was
	 * counted */
	double overdraw;
	uint64_t frames;    /* pictures drawn */
	uint64_t starved;   /* frames drawn coarser than asked for: a coarser tile was drawn instead, or detail was reduced */
	uint64_t coarsened; /* frames whose detail was reduced to fit the slots */
	uint64_t naps;      /* how often a picture to be written waited for its tiles */
	double nap_ms;      /* time of these waits, without the world's stalls and waits for ranges */
	struct render_tiles tiles; /* draws of tiles, objects and shadows */
};
void render_view_figures(const struct view *view, struct render_view_figures *figures);
/* For a host whose view is watched: */
void render_view_look_from(struct view *view, const struct render_camera *camera); /* NULL: the scene's camera */
void render_view_scene_camera(struct view *view, struct render_camera *camera);    /* the scene's camera, now */
void render_view_show_layer(struct view *view, const struct render_layer *layer);
enum status render_view_resize(struct view *view, uint32_t width, uint32_t height) FURROW_CHECKED; /* from the next picture on */
/* Makes what draws bodies anew if the host has added some since. Call render_view_resize after it: the size is the scene's again. */
enum status render_view_follow_bodies(struct view *view) FURROW_CHECKED;
/* Draws the whole picture now, from the camera given to render_view_look_from, and waits for it. `pixels`: RGBA as in
 * render_view_read_into. `depth`: m along the view direction, INFINITY: sky, rows from the lowest up; needs one sample a pixel.
 * Either may be NULL. */
enum status render_view_picture(struct view *view, uint8_t *pixels, float *depth) FURROW_CHECKED;
bool render_view_lacks(const struct view *view);         /* true: the last picture was drawn before all its tiles were resident */
uint64_t render_view_triangles(const struct view *view); /* triangles of the last picture */
/* Begins to read the last picture into staging: 4 x width x height bytes. */
void render_view_read_into(struct view *view, struct gpu_staging *staging);

/*
 * --- pictures that are written ---
 *
 * Writes pictures to files in a folder while steps go on: frame-NNNNNN.png, and the frames of cameras. Each file is written under another name, then
 * renamed. Call it on the GPU's thread. A thread of its own does the writing.
 *
 * If reading back or writing fails, every later call returns that failure with its message. Pictures begun before the failure
 * are still tried. In the end each picture is complete or missing.
 */
/* Most pictures in memory at once, from read-back to written file. */
#define PICTURES_ROOM 3
#define PICTURES_THREAD "furrow-images"

/* What is written of a frame. */
struct render_picture {
	enum scene_image image; /* what is read back; SCENE_IMAGE_NORMALS: what render_measure drew */
	uint32_t width, height;
	unsigned images;        /* of what render_measure drew: bit 1 << enum scene_image of each that is written */
	double unit;            /* depth and height: metres of 1 in the 16-bit PNG */
	double low;             /* height: metres at 0 of that */
	double eye;             /* height: of the camera, m */
	double exposure;        /* the factor of the light */
	uint64_t triangles;     /* of ground in it; 0: it shows none */
	uint32_t vehicles[2];   /* class: numbers of the bodies of vehicles, from the first until before the second */
	int64_t frame;          /* below 0: `name` is the file, without its ending */
	char name[80];          /* in the folder; a camera's own folder, with a folder for each image, if it has frames */
};
/* Light, times the exposure, of the largest number in a picture of linear light. A white surface that faces the Earth's sun at its default height has 2.6. */
#define RENDER_LINEAR_FULL 4.0
/* The unit and the zero of 16-bit pictures of height over a terrain between these heights, m. 0 is below all ground. */
void render_height_scale(double low, double high, double *unit, double *zero);
/* Returns the bytes of the largest picture that the scene writes; 0: it writes none. Pure. */
size_t render_pictures_bytes(const struct scene *scene);
/* Adds the plan's lines of pictures of at most so many bytes. `effect`: the effect that calls for them. Pure. */
void render_pictures_plan(size_t bytes, enum scene_effect effect, struct plan *plan);

/* Prepares for pictures of at most so many bytes and starts the writing thread. The caller owns `directory`, which must stay valid
 * until render_pictures_destroy. */
enum status render_pictures_create(struct gpu *gpu, const char *directory, size_t bytes, struct pictures **out) FURROW_CHECKED;
/* Finishes all pictures that were begun and stops the thread. Afterwards call only render_pictures_figures and
 * render_pictures_destroy. */
void render_pictures_stop(struct pictures *pictures);
void render_pictures_destroy(struct pictures *pictures); /* stops first; pictures may be NULL */

/* The following functions do nothing for NULL, except render_pictures_figures. */
/* Begins to write the last frame as the picture after `step` steps. If PICTURES_ROOM pictures are unfinished, waits for the
 * first of them. */
enum status render_pictures_begin(struct pictures *pictures, struct render *render, int64_t step) FURROW_CHECKED;
/* The same for any picture of the last frame. Its folder exists. */
enum status render_pictures_add(struct pictures *pictures, struct render *render, const struct render_picture *picture) FURROW_CHECKED;
/* Passes pictures that were read back to the writing thread. Never waits. Call it once for each step. */
enum status render_pictures_poll(struct pictures *pictures) FURROW_CHECKED;
/* Waits until all pictures that were begun are read back, and marks them. */
void render_pictures_mark(struct pictures *pictures);
/* Waits until all pictures of the last render_pictures_mark are in their files. Any thread. */
enum status render_pictures_await(struct pictures *pictures) FURROW_CHECKED;

struct render_pictures_figures {
	uint64_t written, waits; /* files written; times that a call waited */
	double wait_ms;
	uint64_t black;          /* pictures of colours of which RENDER_BLACK_SHARE is no brighter than RENDER_BLACK in any channel */
	char first_black[160];   /* the file of the first of them, in the run's folder, */
	double dark;             /* and what share of its pixels is so dark, 0 .. 1 */
	uint64_t white;          /* the same of pictures that are no darker than RENDER_WHITE in all channels */
	char first_white[160];
	double bright;
	bool groundless_black, groundless_white; /* these first ones show no ground */
	double exposed_white;    /* exposure of first_white */
};
#define RENDER_BLACK 10u         /* of 255: what looks black on a screen */
#define RENDER_WHITE 250u
#define RENDER_BLACK_SHARE 0.95  /* beyond the terrain there may be sky */
void render_pictures_figures(struct pictures *pictures, struct render_pictures_figures *figures);

/* Numbers of the pixels, the lowest row first, without padding. */
struct render_array {
	const void *values;
	uint32_t width, height;
	unsigned channels;
	char kind;      /* NumPy's: f or u */
	unsigned bytes; /* of a number */
};
/* npy.c: writes the array with the highest row first. Its shape is (height, width), or (height, width, channels). Any thread. */
enum status render_npy_write(const char *path, const struct render_array *array) FURROW_CHECKED;

/* view_objects.c: finds the height of a body's centre now, 2^-20 m, where its path has it at `point`, as pictures show it. *known is false if there is no
 * ground below it and it was never on the ground. */
struct body;
struct track_point;
enum status render_object_height(struct world *world, const struct body *body, const struct track_point *point, int64_t *height, bool *known) FURROW_CHECKED;

#endif
