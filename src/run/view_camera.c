/* Where the camera is: a function of the track and of the ground, at any time. */
#include <math.h>
#include <string.h>

#include "run/view.h"

static double ground_at(const struct view *view, double x, double y, double otherwise)
{
	int64_t height;
	bool any;
	if (ground_height(view->drive->ground, lattice_offset(x), lattice_offset(y), &height, &any) != STATUS_OK || !any)
		return otherwise;
	return lattice_offset_metres(height);
}

size_t view_places(const void *user, double time, double places[2][2])
{
	const struct drive *drive = user;
	const struct scene_view *wish = &drive->scene->view;
	if (wish->camera == SCENE_FIXED)
		return 0;
	const struct rider *rider = &drive->riders[wish->target_object];
	struct track_point now, before;
	track_at(rider->track, time, &now);
	places[0][0] = now.x;
	places[0][1] = now.y;
	if (wish->camera == SCENE_OVERHEAD)
		return 1;
	/* Behind along the chord of the last stretch, which turns slower than the path does. Where poses are timed, at the speed
	 * of the last second. */
	double speed = rider->object->path.speed;
	if (rider->object->path.timed) {
		track_at(rider->track, time - 1, &before);
		speed = hypot(now.x - before.x, now.y - before.y) / fmin(fmax(time, 1e-3), 1);
	}
	double back = fmin(time, 1.5 * wish->back / fmax(speed, 0.1));
	track_at(rider->track, time - back, &before);
	double dx = now.x - before.x, dy = now.y - before.y, length = hypot(dx, dy);
	if (rider->object->path.loop || length < 0.1 * wish->back || back <= 0) {
		dx = cos(now.yaw);
		dy = sin(now.yaw);
		length = 1;
	}
	places[1][0] = now.x - dx / length * wish->back;
	places[1][1] = now.y - dy / length * wish->back;
	return 2;
}

void view_place_camera(const struct view *view, double time, struct render_camera *camera)
{
	const struct drive *drive = view->drive;
	const struct scene_view *wish = &drive->scene->view;
	double places[2][2];
	if (view->free) {
		*camera = view->camera;
		return;
	}
	camera->fov = 0.9;
	if (view_places(drive, time, places) == 0) {
		memcpy(camera->eye, wish->eye, sizeof camera->eye);
		memcpy(camera->target, wish->target, sizeof camera->target);
		return;
	}
	double middle = (drive->meta->low + drive->meta->high) / 2;
	double ground = ground_at(view, places[0][0], places[0][1], isnan(middle) ? 0 : middle);
	camera->target[0] = places[0][0];
	camera->target[1] = places[0][1];
	camera->target[2] = ground;
	if (wish->camera == SCENE_OVERHEAD) {
		/* A hair off the vertical, so that north is up. */
		camera->eye[0] = places[0][0];
		camera->eye[1] = places[0][1] - 0.02 * wish->over_height;
		camera->eye[2] = ground + wish->over_height;
		return;
	}
	camera->eye[0] = places[1][0];
	camera->eye[1] = places[1][1];
	double below = ground_at(view, camera->eye[0], camera->eye[1], ground);
	camera->eye[2] = fmax(ground, below) + wish->up;
}
