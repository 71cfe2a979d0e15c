/*
 * A host: who watches a drive while it goes on and may have a say in it, a window for one. Part of run/run.h.
 *
 * All of it is on the drive's thread, the one that called run_drive: nothing here may be called from elsewhere, nor but from
 * within a call of the host's. Between two calls of `turn` there are steps of the scene, as many as are due, and at most one
 * picture. What a host wishes decides when steps are made and what is seen; what they make of the ground it does not change.
 * What it drops does.
 */
#ifndef FURROW_RUN_HOST_H
#define FURROW_RUN_HOST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "render/render.h"

struct drive; /* what is driven */

enum run_go {
	RUN_ON,   /* steps, as the pace has it */
	RUN_ONE,  /* one step, now */
	RUN_HOLD, /* none; the picture goes on */
	RUN_STOP, /* the drive is over: all that was done is committed, STATUS_OK */
};

#define RUN_PICTURE_MOST 8192u /* pixels a side */

/* Filled before each turn with what the turn before left there; before the first with what is said here. */
struct run_wish {
	enum run_go go;               /* RUN_ON. After the scene's last step all but RUN_STOP is RUN_HOLD */
	double pace;                  /* 1: simulated seconds a second, above 0; INFINITY: as fast as it can */
	bool free;                    /* false: the scene's camera; true: this one */
	struct render_camera camera;
	enum render_layer_kind layer; /* RENDER_NATURAL */
	uint32_t width, height;       /* of the picture, pixels, 1 to RUN_PICTURE_MOST each: the scene's */
	bool again;                   /* a picture is drawn though nothing changed; false again when it is */
};

struct run_host {
	void *user;
	/* May use the functions below. Another status than STATUS_OK ends the drive as a failed step does. */
	enum status (*turn)(void *user, struct drive *drive, struct run_wish *wish);
	/* A picture is there: RGBA, sRGB, 4 x width x height bytes, row 0 the lowest; the host may change them, and has them
	 * until it returns. The pictures come in the order in which they were drawn, each at most one turn late on
	 * software, and never waited for elsewhere. None is drawn of what has not changed. */
	enum status (*picture)(void *user, struct drive *drive, uint8_t *pixels, uint32_t width, uint32_t height);
};

struct run_figures {
	double fps;               /* pictures, about the mean of the last second in which there were any */
	double frame_ms, step_ms; /* the last picture, until it was read back; the last step */
	uint32_t slots, slots_used;
	uint64_t hits, misses;    /* of the page cache, by steps */
	size_t dirty, queued;     /* pages changed since the last epoch; images that wait for a commit */
	uint64_t triangles;       /* of the last picture */
	int64_t step, steps;      /* done, of all */
	double time, end;         /* s, simulated */
	bool over;                /* the scene's last step is done */
	struct render_layer layer; /* of the last picture, and what its colours range over */
};
void run_figures(struct drive *drive, struct run_figures *figures);

const struct scene *run_scene(const struct drive *drive);
const struct store_meta *run_store(const struct drive *drive);
/* The scene's own camera, now. */
void run_scene_camera(const struct drive *drive, struct render_camera *camera);
/* Where an object of the scene is by its path, now: local metres, on the base; yaw in radians from east to north. */
void run_place(const struct drive *drive, size_t object, double place[3], double *yaw);

/* What is dropped: set down, pressed once and taken away. Its lowest point comes `sink` under the surface as it is; with a
 * load the soil decides. */
enum run_drop_shape {
	RUN_DROP_FIRST, /* the scene's first object's shape and sink or load; a wheel smooth or lugged as that is */
	RUN_DROP_BALL,  /* a ball */
	RUN_DROP_SHAPES
};
/* Presses now. *pressed false: there is no ground there, or the scene has no object, and nothing was done. The soil that
 * slides after it goes on sliding with the scene's time. */
enum status run_drop(struct drive *drive, enum run_drop_shape shape, double x, double y, double yaw, bool *pressed)
	FURROW_CHECKED;

#endif
