/* Gives the path samples of a track to a look-ahead. */
#include "motion/motion.h"

static double sample_time(const void *track, int64_t index)
{
	return motion_track_sample_time(track, index);
}

static void sample_of(const void *track, int64_t index, struct look_ahead_sample *sample)
{
	struct track_point point;
	motion_track_sample(track, index, &point);
	*sample = (struct look_ahead_sample){
		.time = point.time,
		.x = point.x,
		.y = point.y,
		.pose = {.x = point.qx, .y = point.qy, .yaw = point.yaw, .pitch = point.pitch, .roll = point.roll},
	};
}

struct look_ahead_path motion_track_ahead(const struct track *track)
{
	return (struct look_ahead_path){track, motion_track_samples(track), sample_time, sample_of};
}
