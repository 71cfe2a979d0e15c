/* Soil that a host brings or takes, and soil in flight. A part of world.h. */
#ifndef FURROW_WORLD_MOVED_H
#define FURROW_WORLD_MOVED_H

#include "base/base.h"

struct world;

/* --- soil that is brought and taken --- */

struct world_pour {
	struct post_rect rect;  /* posts of the working level */
	const int32_t *amounts; /* 2^-20 m of each post, row by row from the south-west; below 0: taken */
	int soil;               /* index among the scene's soils; below 0: that of each post */
	bool loose;             /* it comes loose, and may slide; false: it lies as ground that nothing has touched */
	bool looks;             /* only finds out whether it would be refused, in a readonly world too; nothing changes */
};
/* Changes the ground by these amounts between two steps. The record counts their sum as added. After STATUS_INPUT or STATUS_USAGE nothing has
 * changed. STATUS_INPUT: the rectangle goes beyond the terrain, or lies on too many tiles. Or a post with an amount is a hole, or has another class in
 * the soil map. Or it lies below a body in the ground, or would be too far off its base. STATUS_USAGE: the world is readonly, has several
 * processes, or no such soil. */
enum status world_pour(struct world *world, const struct world_pour *pour) FURROW_CHECKED;
/* Checks a rectangle before its amounts are made. STATUS_INPUT: it goes beyond the terrain, or lies on more tiles than may change at once. */
enum status world_pour_rect(const struct world *world, struct post_rect rect) FURROW_CHECKED;
/* Parts a volume, m3, below 0: taken, evenly among the posts in a polygon. `xy`: count x 2, local metres. Gives the rectangle around it and the amounts,
 * which the caller frees with mem_free. To the unit they are the volume; first posts in row order get what is left. STATUS_USAGE: fewer than 3 corners,
 * a number that is not finite. STATUS_INPUT: a corner is off the terrain, no post is in the polygon, or the volume is too large for it. */
enum status world_pour_polygon(const struct world *world, size_t count, const double *xy, double volume, struct post_rect *rect, int32_t **amounts)
	FURROW_CHECKED;
/* Returns by how much pours have raised or lowered a post at most since the world was opened, m. A rollback does not lower it. */
double world_poured(const struct world *world);

/* --- what a world is --- */

const struct scene *world_scene(const struct world *world);
const struct world_params *world_params(const struct world *world); /* those that it was opened with; without `store`, `overlay` and `staged` */
double world_time(const struct world *world);        /* s of simulated time since the scene's start */
int64_t world_steps_done(const struct world *world); /* since the scene's start */

/* --- thrown soil --- */

/* Soil in flight (redistribute.thrown). Volumes are fixed-point units: 2^-20 m of height at one post. thrown = landed + lost + flying. */
struct world_thrown_figures {
	size_t grains;                         /* in flight */
	int64_t thrown, landed, lost, flying;  /* lost: over the world's edge, in a hole, or where no post was free */
	double mass;                           /* kg: of what was thrown */
};
/* Fills the figures of the drive so far. Returns false if the scene throws no soil. */
bool world_thrown_figures(const struct world *world, struct world_thrown_figures *figures);
struct world_grain {
	double at[3];  /* local metres; z absolute */
	double radius; /* m: of a ball of its volume */
	uint32_t number; /* of any kind: it stays the same while the grain flies */
};
#define WORLD_THROWN_MOST 16384 /* grains in flight at once */
/* Returns how many there may be: WORLD_THROWN_MOST, or 0 if the scene throws no soil. */
size_t world_grains_most(const struct world *world);
uint64_t world_grains_bytes(const struct world *world); /* memory that is kept for them */
/* Gives where grains are at world_time, at most `room`. Returns how many are in flight. */
size_t world_grains(const struct world *world, size_t room, struct world_grain *grains);

#endif
