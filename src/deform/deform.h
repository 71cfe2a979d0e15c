/*
 * deform: what an object does to the ground, on the GPU, in the dissertation's four stages over one
 * window: gather, displace, redistribute, scatter (with attributes).
 *
 * Results are integers and the same on every driver: an object's underside is evaluated at each
 * post from affine functionals of the post's place in the window (affine.h), in 64-bit
 * fixed point. They do not depend on tiles: a window knows only global posts. For the GPU's thread.
 */
#ifndef FURROW_DEFORM_H
#define FURROW_DEFORM_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "gpu/gpu.h"

enum deform_shape_kind { DEFORM_WHEEL, DEFORM_SPHERE, DEFORM_BOX };

struct deform_shape {
	enum deform_shape_kind kind;
	double radius;  /* wheel, sphere: metres */
	double width;   /* wheel: metres along its axis */
	double size[3]; /* box: metres along its own x (forward), y (left), z (up) */
};

/* The object's centre, and its attitude: yaw about z from east to north, then pitch (nose up), then
 * roll (right side down), radians. A wheel's axis is its own y; it rolls along its own x. */
struct deform_pose {
	int64_t x, y, z; /* 2^-20 m from the south-west post; z absolute */
	double yaw, pitch, roll;
};

/* A translation with the attitude of `to`. A first contact has from == to. */
struct deform_sweep {
	const struct deform_shape *shape;
	struct deform_pose from, to;
};

enum deform_model { DEFORM_NONE, DEFORM_BOX_FILTER };

struct deform_params {
	struct gpu *gpu;
	struct gpu_slots *slots;
	const struct world *world; /* must outlive the deform */
	int level;                 /* the working level */
	int32_t reference;         /* metres: of the bases in the slots */
	enum deform_model model;
	int box_radius;      /* posts, 1 .. 4 */
	int box_repetitions; /* 1 .. 8 */
	bool dirt;
};

struct deform;

/* STATUS_INPUT, with the limit, if the shape cannot be simulated at this spacing. */
enum status deform_shape_check(const struct deform_shape *shape, double spacing) FURROW_CHECKED;
/* Height of the lowest point below the centre for this attitude, metres (positive). */
double deform_shape_reach(const struct deform_shape *shape, double pitch, double roll);

enum status deform_create(const struct deform_params *params, struct deform **out) FURROW_CHECKED;
void deform_destroy(struct deform *deform);

/* The posts one sweep changes (`write`) and those it reads to do so. At most DEFORM_WINDOW_POSTS a
 * side; a larger object takes several windows, cut on a rule of global posts. */
#define DEFORM_WINDOW_POSTS 256
#define DEFORM_WINDOWS_MAX 16
struct deform_window {
	struct post_rect read, write;
};
/* 0 windows: the sweep lies outside the world. STATUS_INPUT: more than DEFORM_WINDOWS_MAX needed, or a
 * wheel whose axis is not level (roll). */
enum status deform_windows(struct deform *deform, const struct deform_sweep *sweep,
			   struct deform_window *windows, size_t *count) FURROW_CHECKED;

/* A resident, pinned tile of the working level. */
struct deform_tile {
	struct tile tile;
	uint32_t slot;
};

/* Gather, displace, redistribute: into the window's own layer. `tiles`: all that hold a post of
 * `read`. Nothing is changed in them. */
enum status deform_compute(struct deform *deform, const struct deform_sweep *sweep,
			   const struct deform_window *window, uint32_t layer,
			   const struct deform_tile *tiles, size_t count) FURROW_CHECKED;
/* Compiles and runs what a sweep of this shape will, over a window beyond the world: a driver's first
 * draw of a program can take a tenth of a second. Changes nothing. */
enum status deform_warm(struct deform *deform, const struct deform_shape *shape) FURROW_CHECKED;
/* Scatter `write` to every tile that holds a post of it; gives them deform slots. */
enum status deform_scatter(struct deform *deform, const struct deform_window *window, uint32_t layer,
			   const struct deform_tile *tiles, size_t count) FURROW_CHECKED;

/* Posts at which a depth beyond an offset's range was refused since the start. Blocks: at the end. */
enum status deform_refused(struct deform *deform, uint64_t *posts) FURROW_CHECKED;

#endif
