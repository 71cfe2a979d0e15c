/* Where the eye of furrow view is, and what moves it. Plain geometry: it knows neither the window nor the drive. */
#include <math.h>

#include "view.h"

#define PITCH_MOST 1.55     /* radians: not quite straight up or down */
#define FLY_LEAST 4.0       /* m/s near the ground */
#define FLY_SHARE 1.0       /* and so much more a metre above it */
#define FLY_FAST 5.0        /* times, with Shift */
#define SWING_TIME 0.5      /* s: in which a follower has swung round by two thirds */
#define SWING_LEAST 1e-3    /* radians: that it is done in one go */
#define UP_LEAST 0.5        /* metres, of a follower */
#define UP_MOST 4.0         /* times its distance behind */

void view_eye_take(struct view_eye *eye, const struct render_camera *camera)
{
	double way[3];
	for (int i = 0; i < 3; i++) {
		eye->eye[i] = camera->eye[i];
		way[i] = camera->target[i] - camera->eye[i];
	}
	eye->fov = camera->fov;
	eye->yaw = way[0] != 0 || way[1] != 0 ? atan2(way[1], way[0]) : M_PI / 2;
	eye->pitch = fmin(fmax(atan2(way[2], hypot(way[0], way[1])), -PITCH_MOST), PITCH_MOST);
}

static void look(const struct view_eye *eye, double way[3])
{
	way[0] = cos(eye->pitch) * cos(eye->yaw);
	way[1] = cos(eye->pitch) * sin(eye->yaw);
	way[2] = sin(eye->pitch);
}

void view_eye_camera(const struct view_eye *eye, struct render_camera *camera)
{
	double way[3];
	look(eye, way);
	for (int i = 0; i < 3; i++) {
		camera->eye[i] = eye->eye[i];
		camera->target[i] = eye->eye[i] + 10 * way[i];
	}
	camera->fov = eye->fov;
}

void view_eye_drag(struct view_eye *eye, int dx, int dy, int height)
{
	double angle = eye->fov / fmax(height, 1); /* the ground stays about under the cursor */
	if (eye->mode == VIEW_MODE_FOLLOW) {
		eye->swing = remainder(eye->swing - 2 * dx * angle, 2 * M_PI);
		eye->up = fmin(fmax(eye->up + 2 * dy * angle * eye->back, UP_LEAST), UP_MOST * eye->back);
		return;
	}
	eye->yaw = remainder(eye->yaw + dx * angle, 2 * M_PI);
	eye->pitch = fmin(fmax(eye->pitch + dy * angle, -PITCH_MOST), PITCH_MOST);
}

void view_eye_fly(struct view_eye *eye, const double way[3], double seconds, double above, bool fast)
{
	double forward[3], speed = (FLY_LEAST + FLY_SHARE * fmax(above, 0)) * (fast ? FLY_FAST : 1);
	look(eye, forward);
	const double right[3] = {sin(eye->yaw), -cos(eye->yaw), 0};
	for (int i = 0; i < 3; i++)
		eye->eye[i] += speed * seconds * (way[0] * forward[i] + way[1] * right[i] + (i == 2 ? way[2] : 0));
}

void view_eye_follow(struct view_eye *eye, const double place[3], double yaw, double seconds)
{
	/* The look turns after the object: at a path's corner it does not jump. */
	double turn = remainder(yaw + eye->swing - eye->yaw, 2 * M_PI);
	eye->yaw = fabs(turn) < SWING_LEAST ? remainder(yaw + eye->swing, 2 * M_PI) :
					      remainder(eye->yaw + turn * (1 - exp(-seconds / SWING_TIME)), 2 * M_PI);
	eye->eye[0] = place[0] - eye->back * cos(eye->yaw);
	eye->eye[1] = place[1] - eye->back * sin(eye->yaw);
}

void view_eye_rise(struct view_eye *eye, const double place[3], double ground)
{
	eye->eye[2] = fmax(place[2], ground) + eye->up;
	eye->pitch = atan2(place[2] - eye->eye[2], eye->back);
}

void view_eye_clear(struct view_eye *eye, double ground)
{
	eye->eye[2] = fmax(eye->eye[2], ground + VIEW_CLEAR);
}

bool view_project(const struct render_camera *camera, int width, int height, const double place[3], double *x, double *y)
{
	struct view_eye eye;
	double forward[3], parts[3] = {0, 0, 0};
	view_eye_take(&eye, camera);
	look(&eye, forward);
	const double right[3] = {sin(eye.yaw), -cos(eye.yaw), 0};
	const double up[3] = {-sin(eye.pitch) * cos(eye.yaw), -sin(eye.pitch) * sin(eye.yaw), cos(eye.pitch)};
	const double focal = height / 2.0 / tan(camera->fov / 2);
	for (int i = 0; i < 3; i++) {
		const double to = place[i] - camera->eye[i];
		parts[0] += to * forward[i];
		parts[1] += to * right[i];
		parts[2] += to * up[i];
	}
	if (parts[0] < 0.05)
		return false;
	*x = width / 2.0 + focal * parts[1] / parts[0];
	*y = height / 2.0 - focal * parts[2] / parts[0];
	return true;
}

void view_ray(const struct render_camera *camera, int width, int height, double x, double y, double ray[3])
{
	struct view_eye eye;
	double forward[3], length = 0;
	view_eye_take(&eye, camera);
	look(&eye, forward);
	const double right[3] = {sin(eye.yaw), -cos(eye.yaw), 0};
	const double up[3] = {-sin(eye.pitch) * cos(eye.yaw), -sin(eye.pitch) * sin(eye.yaw), cos(eye.pitch)};
	double focal = height / 2.0 / tan(camera->fov / 2);
	for (int i = 0; i < 3; i++) {
		ray[i] = forward[i] + ((x - width / 2.0) * right[i] + (height / 2.0 - y) * up[i]) / focal;
		length += ray[i] * ray[i];
	}
	for (int i = 0; i < 3; i++)
		ray[i] /= sqrt(length);
}
