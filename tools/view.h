/* furrow view: what its files share. */
#ifndef FURROW_TOOLS_VIEW_H
#define FURROW_TOOLS_VIEW_H

#include "command.h"
#include "drive/drive.h"
#include "settings.h"
#include "window.h"

/* --- view_keys.c: the one table of keys --- */
enum view_action {
	VIEW_FORWARD, VIEW_BACK, VIEW_LEFT, VIEW_RIGHT, VIEW_DOWN, VIEW_UP, VIEW_ACTIONS_HELD,
	VIEW_FOLLOW = VIEW_ACTIONS_HELD, VIEW_RESET, VIEW_PAUSE, VIEW_ONE_STEP, VIEW_SLOWER, VIEW_FASTER,
	VIEW_DROP, VIEW_SHAPE, VIEW_LAYER, VIEW_SNAPSHOT, VIEW_LINE, VIEW_HELP, VIEW_END, VIEW_NOTHING
};
/* `which` of the action's keys it is, from 0: a layer's number. */
enum view_action view_action_of(int key, int *which);
bool view_action_held(const struct window *window, enum view_action action);
/* Lines of the help, "KEYS  what they do"; NULL: no more. */
const char *view_help(size_t line);
/* The same as one text, for --help. */
extern const char view_keys_text[];

/* --- view_camera.c: where the eye is --- */
enum view_mode { VIEW_MODE_SCENE, VIEW_MODE_FOLLOW, VIEW_MODE_FLY };
struct view_eye {
	enum view_mode mode;
	size_t object;      /* followed: number of drive_followed */
	double eye[3], fov; /* metres, radians: as the last picture had them, in every mode */
	double yaw, pitch;  /* of the look, radians: from east to north, upwards */
	double back, up;    /* following: metres behind and above */
	double swing;       /* following: radians around, from straight behind */
};
/* Takes its place and look from a camera. */
void view_eye_take(struct view_eye *eye, const struct render_camera *camera);
void view_eye_camera(const struct view_eye *eye, struct render_camera *camera);
/* The mouse was dragged so far over a picture so high, pixels. */
void view_eye_drag(struct view_eye *eye, int dx, int dy, int height);
/* Flies on for some seconds: shares of 1 forwards, to the right and up, at a speed by its height above the ground. */
void view_eye_fly(struct view_eye *eye, const double way[3], double seconds, double above, bool fast);
/* Behind an object at `place`, turned so far; over some seconds it swings round. And then over it, and over the ground there,
 * with the look on it. */
void view_eye_follow(struct view_eye *eye, const double place[3], double yaw, double seconds);
void view_eye_rise(struct view_eye *eye, const double place[3], double ground);
/* No nearer to the ground than it may be. */
#define VIEW_CLEAR 0.3 /* metres */
void view_eye_clear(struct view_eye *eye, double ground);
/* From the eye through a pixel of a picture, counted from its top left; a unit vector. */
void view_ray(const struct render_camera *camera, int width, int height, double x, double y, double ray[3]);

/* --- view_host.c: the host of the drive --- */
struct viewer {
	struct window *window;
	struct view_eye eye;
	double fly_before;            /* clock, s: of the last turn */
	bool paused, one, ended;
	int pace;                     /* a power of two; VIEW_PACE_MOST: as fast as it can */
	enum render_layer_kind layer;
	enum world_drop_shape shape;
	struct chart_pen *pen;        /* for text on the picture; NULL: this process sets none */
	bool line, help, snapshot;
	bool again;                   /* the picture is to be drawn anew */
	double titled, titled_time;   /* clock, s: when the title was written; s of the drive then */
	double rate;                  /* s of the drive in a second of the clock, between the last two titles; NaN: not known */
	const char *told;             /* what the line of figures says at its end, until: */
	double told_until;
	int64_t steps, pictures, drops, snapshots; /* steps: of the scene */
	char message[96];
};
#define VIEW_PACE_LEAST (-6)
#define VIEW_PACE_MOST 7
void viewer_init(struct viewer *viewer, struct window *window, const struct scene *scene);
struct drive_host viewer_host(struct viewer *viewer);

/* --- view_picture.c: what is drawn over the picture --- */
/* `followed`: whose speed, slip and sinkage it tells; NULL: there is no vehicle. */
void view_figures_text(const struct viewer *viewer, const struct drive_figures *figures, const struct drive_followed *followed, char *text, size_t size);
/* The line of figures, the legend of a layer, the help. Rows from the lowest. Without a pen nothing. */
enum status view_draw_over(const struct viewer *viewer, const struct drive_figures *figures, const struct drive_followed *followed, uint8_t *pixels, uint32_t width, uint32_t height)
	FURROW_CHECKED;

/* --- view_scene.c: the scene as it is viewed --- */
/* With a view, if it has none of its own: the one table of defaults is there. */
enum status view_scene_load(const char *path, struct settings *settings, struct scene **out) FURROW_CHECKED;

#endif
