/* Models that do not look along x, or whose z does not look up: the first pose is turned, before anything is found in it. */
#include "vehicle/internal.h"

bool vehicle_scene_axes(const struct scene_vehicle *scene, double axes[9])
{
	static const double forwards[][3] = {[SCENE_PLUS_X] = {1, 0, 0}, [SCENE_MINUS_X] = {-1, 0, 0}, [SCENE_PLUS_Y] = {0, 1, 0}, [SCENE_MINUS_Y] = {0, -1, 0}};
	const double *forward = forwards[scene->forward], up[3] = {0, scene->y_up, !scene->y_up};
	double left[3];
	mju_cross(left, up, forward);
	for (int i = 0; i < 3; i++) {
		axes[3 * i] = forward[i];
		axes[3 * i + 1] = left[i];
		axes[3 * i + 2] = up[i];
	}
	return scene->forward != SCENE_PLUS_X || scene->y_up;
}

static void turn_pose(double *pos, double *quat, const double turn[4])
{
	double place[3], turned[4];
	mju_rotVecQuat(place, pos, turn);
	mju_mulQuat(turned, turn, quat);
	mju_copy3(pos, place);
	mju_copy4(quat, turned);
}

/* Finds what turns the model to x, y and z. Returns false if nothing does. */
static bool find_turn(const struct scene_vehicle *scene, double turn[4])
{
	double axes[9], back[9];
	if (scene == NULL || !vehicle_scene_axes(scene, axes))
		return false;
	for (int i = 0; i < 9; i++)
		back[i] = axes[3 * (i % 3) + i / 3];
	mju_mat2Quat(turn, back);
	return true;
}

void vehicle_turn_single(struct vehicle *vehicle)
{
	mjModel *model = vehicle->single;
	double turn[4];
	if (!find_turn(vehicle->scene, turn))
		return;
	for (int body = 1; body < model->nbody; body++) {
		if (model->body_parentid[body] != 0)
			continue;
		if (!vehicle_is_free(model, body)) {
			turn_pose(&model->body_pos[3 * body], &model->body_quat[4 * body], turn);
			continue;
		}
		const int at = model->jnt_qposadr[model->body_jntadr[body]];
		turn_pose(&vehicle->posed->qpos[at], &vehicle->posed->qpos[at + 3], turn);
		turn_pose(&model->qpos0[at], &model->qpos0[at + 3], turn);
	}
	mj_forward(model, vehicle->posed);
}

void vehicle_turn_fixed(struct vehicle *vehicle)
{
	mjModel *model = vehicle->model;
	double turn[4];
	if (!find_turn(vehicle->scene, turn))
		return;
	for (int body = vehicle->own.body.first; body < vehicle->own.body.end; body++)
		if (model->body_parentid[body] == 0 && !vehicle_is_free(model, body))
			turn_pose(&model->body_pos[3 * body], &model->body_quat[4 * body], turn);
	mj_forward(model, vehicle->data);
}

/* Finds forward, left and up, as columns, in the axes of a body. They are those of the first pose if the scene turns the model. Else they are the body's own. */
static void body_axes(const struct vehicle *vehicle, int body, double axes[9])
{
	const double *mat = &vehicle->data->xmat[9 * body];
	const bool turned = vehicle_scene_axes(vehicle->scene, axes);
	/* The model has been turned, so forward, left and up are x, y and z. The rows of `mat` are these axes in those of the body. */
	for (int i = 0; i < 9; i++)
		axes[i] = turned ? mat[3 * (i % 3) + i / 3] : i % 4 == 0;
}

void vehicle_set_root_axes(struct vehicle *vehicle)
{
	body_axes(vehicle, vehicle->root, vehicle->axes);
}

void vehicle_place_imu(struct vehicle *vehicle)
{
	mjModel *model = vehicle->model;
	const struct scene_imu *imu = &vehicle->scene->imu;
	const int site = imu->present ? vehicle_find_part(vehicle, mjOBJ_SITE, IMU_SITE) : -1;
	double axes[9];
	if (site < 0)
		return;
	if (imu->body == NULL)
		model->site_bodyid[site] = vehicle->root;
	body_axes(vehicle, model->site_bodyid[site], axes);
	mju_mulMatVec3(model->site_pos + 3 * site, axes, imu->at);
	mju_mat2Quat(model->site_quat + 4 * site, axes);
	model->site_sameframe[site] = mjSAMEFRAME_NONE;
	mj_kinematics(model, vehicle->data);
}
