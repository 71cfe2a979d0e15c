/* What keys and clicks in the window of furrow view do to the drive and to the eye. */
#include <math.h>
#include <string.h>

#include "view.h"

bool view_watched(const struct viewer *viewer, const struct drive *drive, size_t *number)
{
	const struct scene *scene = drive_scene(drive);
	const int aimed = scene->view.aim.vehicle;
	const bool follows = viewer->eye.mode == VIEW_MODE_FOLLOW && viewer->eye.object >= scene->object_count;
	*number = follows ? viewer->eye.object : scene->object_count + (aimed > 0 ? (size_t)aimed - 1 : 0);
	return *number < drive_followed_count(drive);
}

void view_camera_now(const struct viewer *viewer, const struct drive *drive, struct render_camera *camera)
{
	if (viewer->eye.mode == VIEW_MODE_SCENE)
		drive_scene_camera(drive, camera);
	else
		view_eye_camera(&viewer->eye, camera);
}

enum status view_ground_at(const struct viewer *viewer, struct drive *drive, double x, double y, struct resident_hit *hit)
{
	struct render_camera camera;
	int width, height;
	struct resident_ray ray = {.length = INFINITY};
	*hit = (struct resident_hit){.hit = false};
	window_size(viewer->window, &width, &height);
	view_camera_now(viewer, drive, &camera);
	view_ray(&camera, width, height, x, y, ray.direction);
	memcpy(ray.origin, camera.eye, sizeof ray.origin);
	return drive_rays(drive, &ray, 1, hit);
}

/* --- following --- */

void view_follow(struct viewer *viewer, const struct drive *drive, size_t number)
{
	const size_t count = drive_followed_count(drive);
	struct view_eye *eye = &viewer->eye;
	eye->swing = 0;
	if (number < count) {
		struct drive_followed followed;
		struct render_camera camera;
		drive_followed(drive, number, &followed);
		if (eye->fov == 0) { /* no picture was drawn yet */
			drive_scene_camera(drive, &camera);
			view_eye_take(eye, &camera);
		}
		eye->mode = VIEW_MODE_FOLLOW;
		eye->object = number;
		viewer_tell(viewer, "follows %.60s", followed.name);
		return;
	}
	eye->mode = VIEW_MODE_FLY;
	viewer_tell(viewer, count > 0 ? "flies" : "there is no object to follow");
}

void view_follow_named(struct viewer *viewer, const struct drive *drive)
{
	struct drive_followed followed;
	for (size_t i = 0; viewer->follow != NULL && i < drive_followed_count(drive); i++) {
		drive_followed(drive, i, &followed);
		if (strcmp(followed.name, viewer->follow) == 0) {
			view_follow(viewer, drive, i);
			break;
		}
	}
	viewer->follow = NULL;
}

/* --- going back --- */

enum status view_mark(struct viewer *viewer, struct drive *drive)
{
	TRY(drive_checkpoint(drive));
	viewer->marked = true;
	viewer->marked_time = drive_time(drive);
	viewer_tell(viewer, "marked %.2f s", viewer->marked_time);
	return STATUS_OK;
}

enum status view_go_back(struct viewer *viewer, struct drive *drive)
{
	if (!viewer->marked) {
		viewer_tell(viewer, "there is no mark to go back to: C sets one");
		return STATUS_OK;
	}
	TRY(drive_rollback(drive));
	viewer_tell(viewer, "back at %.2f s", viewer->marked_time);
	return STATUS_OK;
}

/* --- sending --- */

enum status view_send(struct viewer *viewer, struct drive *drive, double x, double y)
{
	struct resident_hit hit;
	struct drive_followed followed;
	size_t number;
	if (!view_watched(viewer, drive, &number)) {
		viewer_tell(viewer, "there is no vehicle to send");
		return STATUS_OK;
	}
	TRY(view_ground_at(viewer, drive, x, y, &hit));
	drive_followed(drive, number, &followed);
	if (!hit.hit)
		viewer_tell(viewer, "there is no ground");
	else if (drive_send(drive, number, hit.point[0], hit.point[1]))
		viewer_tell(viewer, "%.40s goes to %.2f, %.2f", followed.name, hit.point[0], hit.point[1]);
	else
		viewer_tell(viewer, "%.40s cannot be sent: its driver follows no path", followed.name);
	return STATUS_OK;
}

/* Returns true if the map is there; *place: what is shown there, metres. */
static bool on_map(const struct viewer *viewer, double x, double y, double place[2])
{
	const struct view_map *map = &viewer->map;
	int width, height;
	window_size(viewer->window, &width, &height);
	if (!viewer->shows_map || map->zoom <= 0)
		return false;
	const double right = (x + 0.5 - map->x) / map->zoom, up = (height - 0.5 - y - map->y) / map->zoom;
	place[0] = (right - 0.5) * map->metres;
	place[1] = (up - 0.5) * map->metres;
	return right >= 0 && up >= 0 && right < map->width && up < map->height;
}

enum status view_pick(struct viewer *viewer, struct drive *drive, double x, double y)
{
	double place[2], at[3], yaw, least = INFINITY;
	size_t nearest = 0;
	if (!on_map(viewer, x, y, place))
		return view_send(viewer, drive, x, y);
	for (size_t i = 0; i < drive_followed_count(drive); i++) {
		drive_place(drive, i, at, &yaw);
		const double away = hypot(at[0] - place[0], at[1] - place[1]);
		nearest = away < least ? i : nearest;
		least = fmin(away, least);
	}
	view_follow(viewer, drive, nearest);
	return STATUS_OK;
}

void view_show_map(struct viewer *viewer)
{
	viewer->shows_map = !viewer->shows_map;
	viewer->again = true;
	if (!viewer->shows_map || viewer->map.shade != NULL)
		return;
	if (view_map_make(&viewer->map, viewer->store) == STATUS_OK)
		return;
	viewer->shows_map = false;
	viewer_tell(viewer, "no map: %.80s", failure_message());
}
