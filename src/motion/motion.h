/*
 * motion: paths, path samples, and the places where bodies and cameras will be. The look-ahead of `resident` loads what they will need.
 *
 * Pure: no store, no GL.
 */
#ifndef FURROW_MOTION_H
#define FURROW_MOTION_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "resident/resident.h"
#include "scene/scene.h"

/*
 * --- paths ---
 *
 * A path is divided once into path samples, one post spacing of the working level apart. They do not depend on the time step.
 *
 * The length along a path is the distance in three dimensions, plus the turn in radians times `turn_reach`. So turning in place
 * has a length too. Path sample i is at length i * post. The last one is at the path's end. Positions are kept relative to the
 * path's first point on the pose lattice. So a path has the same bits wherever it lies. Pure: no store, no GL. A struct track
 * is read-only after motion_track_create.
 */
struct track;

struct track_point {
	double time;             /* s */
	int64_t qx, qy;          /* 2^-20 m, local */
	double x, y, z;          /* metres, local; z only if the path gives it */
	double yaw, pitch, roll; /* radians; yaw is the direction of travel if the path gives none */
};

/*
 * Makes the route of a path: its waypoints in local metres, as a track takes them. What the path says of curves, turns, moves and of the path that
 * it is relative to is done. `points`: local metres, one for each of from->points. `name`: of the object, for messages. The caller frees it by
 * motion_route_finish. STATUS_INPUT: there is no such way beside the path. Pure; thread-safe.
 */
enum status motion_route_create(const struct scene_path *from, const char *name, const double (*points)[2], struct scene_path *route)
	FURROW_CHECKED;
void motion_route_finish(struct scene_path *route);

/* Makes a track of a path in local metres. `post`: metres between path samples. */
enum status motion_track_create(const struct scene_path *path, double post, double turn_reach, struct track **out) FURROW_CHECKED;
void motion_track_destroy(struct track *track);

int64_t motion_track_samples(const struct track *track); /* INT64_MAX for a loop */
/* Returns the most path samples that are due within any `seconds` of time. It is not too few, and at most two too many. */
double motion_track_most(const struct track *track, double seconds);
void motion_track_sample(const struct track *track, int64_t index, struct track_point *point);
double motion_track_sample_time(const struct track *track, int64_t index);
/* Returns the first path sample outside 0 .. width, 0 .. height (local metres). Returns -1 if all are inside. For a loop only
 * the first lap is checked, since all laps are alike. */
int64_t motion_track_leaves(const struct track *track, double width, double height);
/* Returns the greatest speed along the ground, m/s. */
double motion_track_fastest(const struct track *track);
/* Fills `places` with the path travelled until `time`, for a picture: its corners and the last place, in local metres. The path
 * between them is straight. For a loop it gives at most one lap. Returns the number of places, 1 to motion_track_corners(). */
size_t motion_track_corners(const struct track *track);
size_t motion_track_way(const struct track *track, double time, double (*places)[2]);
/* Fills `places` with the points of the ground that the scene's camera is at or looks at, at `time`, in local metres. Returns
 * their number, 0 to 2. `target`: the path of the body that the camera follows or is above. Any thread. */
size_t motion_track_camera_places(const struct scene_aim *aim, const struct scene_path *path, const struct track *target, double time,
			   double places[2][2]);
/* Gives the track's path samples to a look-ahead. The track must stay valid longer. */
struct look_ahead_path motion_track_ahead(const struct track *track);
/* Gives the place of the object at `time`, s. Before the path's start and after its end it rests there. */
void motion_track_at(const struct track *track, double time, struct track_point *point);

#endif
