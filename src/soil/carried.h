/*
 * Soil that a body carries: a plate, a bucket, a blade (Onoue and Nishita's height spans).
 *
 * A grid of cells goes and yaws with the body. Each cell has so much soil above the body's upper envelope, its highest surface in plan. Cells are as large as
 * posts, so a fixed-point unit of a cell is one of a post. A body that only goes and yaws changes no cell. When it pitches or rolls, the envelope below the cells
 * changes. Soil remains above its place, and slides where it is too steep. It falls where the body is no longer below it.
 *
 * Soil comes aboard in two ways. Where the body newly passes below ground, a contact gives what lies above the envelope (soil_carried_add). And soil slides from
 * ground beside the body that is higher than the load (soil_carried_settle). It leaves over the edges.
 *
 * Invariants: (1) Cells, classes and total agree to the unit. (2) What leaves the cells is on the ground, and the reverse, to the unit. (3) Nothing depends on tiles,
 * windows or threads: the order of cells decides. One thread at a time uses one struct.
 */
#ifndef FURROW_SOIL_CARRIED_H
#define FURROW_SOIL_CARRIED_H

#include "soil/soil.h"

#define CARRIED_OPEN INT32_MIN /* a top: the body is not below the cell */

struct soil_carried {
	const struct soil_shape *shape; /* must live as long */
	struct soil_mesh mirrored;      /* of a mesh: with its z negated */
	double spacing;                 /* m */
	int half, side;                 /* cells: side = 2 half + 1; the body's centre is in the middle one */
	int32_t *amounts;               /* side x side, row by row, fixed-point units: of soil aboard, */
	int32_t *tops;                  /* height of the upper envelope above the body's centre; CARRIED_OPEN */
	int32_t *before;                /* the same before the attitude changed */
	int32_t *falls;                 /* soil that the body does not hold up any more, until it is put on the ground */
	int32_t *changes;               /* for soil_carried_settle: of each cell in an iteration, */
	ptrdiff_t *posts;               /* and the post beside the body with which it exchanges soil, in the planes; -1: none */
	void *scratch;                  /* struct soil_carried_cells: shares of cells, and sills between them */
	double yaw, pitch, roll, turn;  /* for which `tops` are */
	double heading;                 /* of the cells above the body's yaw, rad: 0, or pi after an attitude was told by its other angles */
	bool placed;                    /* tops are known */
	bool unsettled;                 /* soil may go on sliding */
	int64_t total;                  /* fixed-point units, summed over amounts and falls */
	int64_t classes[SOIL_CLASSES];  /* of it, by class of soil */
	/* NULL: no soil flies. Else, of each cell, what left the body there until soil_carried_fallen; and how high above the body's centre that was */
	int32_t *fell, *fell_from;
	int64_t fell_total, fell_classes[SOIL_CLASSES];
	int32_t *caught;                /* of each cell, what came down there, until soil_carried_keep */
	int64_t caught_total;
};

/* Makes it for a shape, empty. STATUS_MEMORY. destroy takes NULL. */
enum status soil_carried_create(const struct soil_shape *shape, double spacing, struct soil_carried **out) FURROW_CHECKED;
void soil_carried_destroy(struct soil_carried *carried);
/* From now on soil that leaves the body from so far above the ground does not land at once. It waits in `fell`, and is not in `total` any more. STATUS_MEMORY. */
#define SOIL_FALLS_FROM 0.1 /* m; chosen: as far as a grain falls in 0.14 s */
enum status soil_carried_let_fly(struct soil_carried *carried) FURROW_CHECKED;
/* Calls `take` for each cell from which soil fell, in the order of cells, and forgets it. from: where it left, 2^-20 m, as in struct soil_pose. */
void soil_carried_fallen(struct soil_carried *carried, const struct soil_pose *pose, void (*take)(void *user, const int64_t from[3], int32_t amount), void *user);
/* Tells whether a grain comes down onto the soil aboard, or onto the body, on its way between two places, 2^-20 m. Then it waits for soil_carried_keep. A cell that is
 * full catches none. */
bool soil_carried_catch(struct soil_carried *carried, const struct soil_pose *pose, const int64_t before[3], const int64_t now[3], int64_t volume);
/* Takes what was caught aboard, as soil of a class. */
void soil_carried_keep(struct soil_carried *carried, int class);

/* Returns how much of each cell is above the body, in 64ths of a cell. */
const uint8_t *soil_carried_shares(const struct soil_carried *carried);

/* Moves it to a pose of its body: finds the upper envelope if the attitude changed. */
void soil_carried_place(struct soil_carried *carried, const struct soil_pose *pose);
/* Returns the height of the upper envelope above the body's centre at a post, fixed-point units; CARRIED_OPEN: the body is not below it. */
int32_t soil_carried_top_at(const struct soil_carried *carried, const struct soil_pose *pose, int64_t x, int64_t y);
/* Puts soil of a post aboard, of which the body is below. amount: fixed-point units, 0 or more. Returns how much of it fits. */
int32_t soil_carried_add(struct soil_carried *carried, const struct soil_pose *pose, int64_t x, int64_t y, int32_t amount, int class);

/* Returns the posts that soil_carried_settle may read and change. */
struct post_rect soil_carried_reach(const struct soil_carried *carried, const struct soil_pose *pose);
/* Lets soil slide aboard, over the edges, and from the ground onto the body, until it rests or for some iterations. pose: where the body is, to which
 * soil_carried_place moved it. planes: offset and deposited of posts of `written` change; their contact tells posts that bodies hold. reference: m, of bases. Returns a
 * rectangle around the changed posts; empty: none. */
struct post_rect soil_carried_settle(struct soil_carried *carried, const struct soil_pose *pose, const struct soil_sliding *rule, const struct soil_planes *planes, int32_t reference,
				     struct post_rect written);
/* Puts all soil aboard on the ground below it. The same arguments. What finds no ground stays aboard. */
struct post_rect soil_carried_drop(struct soil_carried *carried, const struct soil_pose *pose, const struct soil_planes *planes, int32_t reference, struct post_rect written);

/* Computes the force of the load on the body, N, down; and its moment about the body's centre, N m, east and north. weights: of each class, N/m3. Adds to both. */
void soil_carried_weigh(const struct soil_carried *carried, const double weights[SOIL_CLASSES], double force[3], double moment[3]);

/* A part of a body: its place and axes (forward, left, up) in the axes of the whole. */
struct soil_part {
	const struct soil_shape *shape; /* box or mesh; others have no part in it */
	double at[3], axes[3][3];       /* m; unit vectors */
};
/* Computes the struck capacity of a body at level attitude, m3: the volume between its upper envelope and a straightedge that rests on it (struck.c). It is 0 where
 * no wall is around a hollow. Sampled 512 times along the longer side. Any thread. STATUS_MEMORY. */
enum status soil_struck_capacity(const struct soil_part *parts, size_t count, double *capacity) FURROW_CHECKED;

/* Its state as whole numbers, for a record, and back. Where the body is follows from soil_carried_place. load returns false if they contradict each other. */
size_t soil_carried_numbers(const struct soil_shape *shape, double spacing);
void soil_carried_save(const struct soil_carried *carried, int64_t *numbers);
bool soil_carried_load(const int64_t *numbers, struct soil_carried *carried);

#endif
