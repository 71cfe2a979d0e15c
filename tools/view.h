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
	VIEW_MARK, VIEW_BACK_TO, VIEW_SEND, VIEW_GRAPH, VIEW_MAP, VIEW_DROP, VIEW_SHAPE, VIEW_LAYER, VIEW_SNAPSHOT, VIEW_LINE, VIEW_HELP, VIEW_END, VIEW_NOTHING
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
/* The other way: where a place is on the picture. Returns false if it lies behind the eye. */
bool view_project(const struct render_camera *camera, int width, int height, const double place[3], double *x, double *y);

/* --- view_track.c: what is remembered of a drive --- */
#define VIEW_SPAN 10.0   /* s: so long back goes the graph */
#define VIEW_SAMPLES 500
#define VIEW_WHEELS 8    /* of one vehicle */
#define VIEW_PLACES 256  /* of one way */
struct view_sample {
	double time, slip[VIEW_WHEELS], sinkage[VIEW_WHEELS]; /* s; slip: NaN: it does not turn; m */
};
struct view_way {
	double places[VIEW_PLACES][2], times[VIEW_PLACES], apart; /* m, s, m: least distance between two */
	size_t count;
};
struct view_track {
	struct view_way *ways;  /* of all that can be followed; NULL: none yet */
	size_t count;
	size_t of;              /* whose wheels these are: number of drive_followed */
	size_t wheels, samples; /* samples: the oldest first */
	char names[VIEW_WHEELS][24];
	struct view_sample list[VIEW_SAMPLES];
};
/* Adds what is there now. What was later than now is forgotten: the drive has gone back. `of`: whose wheels; a number beyond all: of none. */
enum status view_track_take(struct view_track *track, const struct drive *drive, size_t of) FURROW_CHECKED;
void view_track_finish(struct view_track *track);

/* --- view_map.c: the map in a corner --- */
struct view_map {
	uint8_t *shade;            /* 0 to 255, row 0 the lowest; NULL: not made yet */
	uint32_t width, height;    /* pixels */
	double metres;             /* of a pixel */
	/* Where it is in the window since the last picture, from its lower left; zoom 0: nowhere. */
	int x, y;
	double zoom;               /* pixels of the window for one of the map */
};
/* Makes it from a store that is open elsewhere. */
enum status view_map_make(struct view_map *map, const char *path) FURROW_CHECKED;
void view_map_finish(struct view_map *map);

/* --- view_host.c: the host of the drive --- */
struct viewer {
	struct window *window;
	struct view_eye eye;
	double fly_before;            /* clock, s: of the last turn */
	bool paused, ended;
	int ones;                     /* single steps that were asked for and not made yet */
	int pace;                     /* a power of two; VIEW_PACE_MOST: as fast as it can */
	enum render_layer_kind layer;
	enum world_drop_shape shape;
	struct chart_pen *pen;        /* for text on the picture; NULL: this process sets none */
	bool line, help, snapshot, graph, shows_map;
	bool marked;                  /* there is a mark to go back to */
	double marked_time;           /* s of the drive */
	const char *follow;           /* --follow, until it is done; NULL: nothing is to be followed */
	const char *store;            /* path, for the map */
	struct view_track track;
	struct view_map map;
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
void viewer_finish(struct viewer *viewer);
/* Says something at the end of the line of figures, for some seconds. */
void viewer_tell(struct viewer *viewer, const char *format, ...) FURROW_PRINTF(2, 3);
struct drive_host viewer_host(struct viewer *viewer);

/* --- view_act.c: what keys and clicks do to the drive --- */
/* Gives the number of the vehicle whose figures are told: the one that the eye follows, or the scene's camera, or the first. Returns false if there is none. */
bool view_watched(const struct viewer *viewer, const struct drive *drive, size_t *number);
void view_camera_now(const struct viewer *viewer, const struct drive *drive, struct render_camera *camera);
/* The ground that a pixel of the window shows, counted from its top left. */
enum status view_ground_at(const struct viewer *viewer, struct drive *drive, double x, double y, struct resident_hit *hit) FURROW_CHECKED;
void view_follow(struct viewer *viewer, const struct drive *drive, size_t number);
/* Takes --follow. */
void view_follow_named(struct viewer *viewer, const struct drive *drive);
enum status view_mark(struct viewer *viewer, struct drive *drive) FURROW_CHECKED;
enum status view_go_back(struct viewer *viewer, struct drive *drive) FURROW_CHECKED;
/* A click with the left button, or T: on the map it follows, elsewhere it sends the vehicle there. */
enum status view_pick(struct viewer *viewer, struct drive *drive, double x, double y) FURROW_CHECKED;
enum status view_send(struct viewer *viewer, struct drive *drive, double x, double y) FURROW_CHECKED;
void view_show_map(struct viewer *viewer);

/* --- view_inset.c: marks of targets, the graph and the map over the picture --- */
enum status view_draw_targets(const struct viewer *viewer, struct drive *drive, uint8_t *pixels, uint32_t width, uint32_t height) FURROW_CHECKED;
/* `top`: pixels above which there is text. */
enum status view_draw_map(struct viewer *viewer, const struct drive *drive, uint8_t *pixels, uint32_t width, uint32_t height, int top) FURROW_CHECKED;
enum status view_draw_graph(const struct viewer *viewer, const struct drive *drive, uint8_t *pixels, uint32_t width, uint32_t height) FURROW_CHECKED;

/* --- view_picture.c: what is drawn over the picture --- */
/* `followed`: whose speed, slip and sinkage it tells; NULL: there is no vehicle. */
void view_figures_text(const struct viewer *viewer, const struct drive_figures *figures, const struct drive_followed *followed, char *text, size_t size);
/* The line of figures, the legend of a layer, the help. Rows from the lowest. Without a pen nothing. *top: pixels above which there is text. */
enum status view_draw_over(const struct viewer *viewer, const struct drive_figures *figures, const struct drive_followed *followed, uint8_t *pixels, uint32_t width, uint32_t height,
			   int *top) FURROW_CHECKED;

/* --- view_scene.c: the scene as it is viewed --- */
/* With a view, if it has none of its own: the one table of defaults is there. */
enum status view_scene_load(const char *path, struct settings *settings, struct scene **out) FURROW_CHECKED;

#endif
