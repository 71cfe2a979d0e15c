/*
 * A path flattened once into stations one working post apart, whatever the time step.
 *
 * Length along a path is travel in three dimensions plus, so that turning in place counts, the turn
 * in radians times `turn_reach`. Station i lies at length i * post; the last one at the path's end.
 * Places are kept relative to the path's first point on the pose lattice, so that a path is the same
 * to the bit wherever it lies. Pure: no store, no GL. A struct track is read-only after track_create.
 */
#ifndef FURROW_RUN_TRACK_H
#define FURROW_RUN_TRACK_H

#include "base/base.h"
#include "scene/scene.h"

struct track;

struct track_point {
	double time;             /* s */
	int64_t qx, qy;          /* 2^-20 m, local */
	double x, y, z;          /* metres, local; z only if the path gives it */
	double yaw, pitch, roll; /* radians; yaw is the direction of travel if the path gives none */
};

/* `points` are local metres, in the order of path->points. */
enum status track_create(const struct scene_path *path, const double (*points)[2], double post,
			 double turn_reach, struct track **out) FURROW_CHECKED;
void track_destroy(struct track *track);

int64_t track_stations(const struct track *track); /* INT64_MAX for a loop */
void track_station(const struct track *track, int64_t index, struct track_point *point);
double track_station_time(const struct track *track, int64_t index);
/* The first station that is not within 0 .. width, 0 .. height of the local metres; -1: all are. Of a loop, of its first lap,
 * which all others are like. */
int64_t track_leaves(const struct track *track, double width, double height);
/* The fastest it goes along the ground, m/s. */
double track_fastest(const struct track *track);
/* Where it was until `time`, for a picture: its corners and where it is, local metres, straight lines between them; of a loop,
 * no more than one lap. Returns how many, 1 to track_corners(). */
size_t track_corners(const struct track *track);
size_t track_way(const struct track *track, double time, double (*places)[2]);
/* Where the object is at `time` (held at the path's ends). */
void track_at(const struct track *track, double time, struct track_point *point);

#endif
