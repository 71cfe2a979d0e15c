/* Finds the place of a camera that follows a body: a function of the path and time. */
#include <math.h>

#include "motion/motion.h"

size_t motion_track_camera_places(const struct scene_aim *aim, const struct scene_path *path, const struct track *target, double time,
			   double places[2][2])
{
	if (aim->kind == SCENE_FIXED)
		return 0;
	struct track_point now, before;
	motion_track_at(target, time, &now);
	places[0][0] = now.x;
	places[0][1] = now.y;
	if (aim->kind == SCENE_OVERHEAD)
		return 1;
	/* The camera is behind along the chord of the last stretch, which turns slower than the path. Timed poses use the speed
	 * of the last second. */
	double speed = path->speed;
	if (path->timed) {
		motion_track_at(target, time - 1, &before);
		speed = hypot(now.x - before.x, now.y - before.y) / fmin(fmax(time, 1e-3), 1);
	}
	double back = fmin(time, 1.5 * aim->back / fmax(speed, 0.1));
	motion_track_at(target, time - back, &before);
	double dx = now.x - before.x, dy = now.y - before.y, length = hypot(dx, dy);
	if (path->loop || length < 0.1 * aim->back || back <= 0) {
		dx = cos(now.yaw);
		dy = sin(now.yaw);
		length = 1;
	}
	places[1][0] = now.x - dx / length * aim->back;
	places[1][1] = now.y - dy / length * aim->back;
	return 2;
}
