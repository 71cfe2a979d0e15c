/* Converts a host's pose, a place and a quaternion, to the pose of deform: yaw, pitch, roll and a wheel's turn. */
#include <math.h>
#include <string.h>

#include "world/internal.h"

/* Greatest slope of a wheel's axle that counts as rounding, so that the axle is level: sine of the angle. */
#define LEVEL 5e-6
/* Greatest difference of a quaternion's length from 1. */
#define UNIT 1e-3
#define PLACE_MOST 1e9   /* m, along x and y */
#define HEIGHT_MOST 1e6  /* m */

void world_axes(const double q[4], double axes[3][3])
{
	const double w = q[0], x = q[1], y = q[2], z = q[3];
	const double rows[3][3] = {
		{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
		{2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
		{2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)},
	};
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 3; k++)
			axes[i][k] = rows[i][k];
}

/* Computes a wheel's pose. Its turn is the angle of its own x axis below its heading, seen along its axle. */
static void wheel_of(const double axes[3][3], struct soil_pose *pose)
{
	double level[3][3];
	soil_wheel_attitude(axes[1], &pose->yaw, &pose->roll);
	if (fabs(axes[1][2]) <= LEVEL)
		pose->roll = 0;
	soil_axes(pose->yaw, 0, pose->roll, 0, level);
	double along = 0, up = 0;
	for (int k = 0; k < 3; k++) {
		along += axes[0][k] * level[0][k];
		up += axes[0][k] * level[2][k];
	}
	pose->turn = atan2(-up, along);
}

double world_spin(const struct soil_pose *pose, const double angular[3])
{
	double axes[3][3];
	soil_axes(pose->yaw, 0, pose->roll, 0, axes);
	return axes[1][0] * angular[0] + axes[1][1] * angular[1] + axes[1][2] * angular[2];
}

static enum status find_attitude(const struct soil_shape *shape, const char *name, const struct furrow_pose *from, struct soil_pose *pose)
{
	double q[4], length = 0, axes[3][3];
	for (int i = 0; i < 4; i++)
		length += from->orientation[i] * from->orientation[i];
	length = sqrt(length);
	for (int i = 0; i < 3; i++)
		if (!(fabs(from->position[i]) <= (i < 2 ? PLACE_MOST : HEIGHT_MOST)))
			return fail_with(STATUS_USAGE, "%s: its place is %g, %g, %g m; give numbers within 1e9 m, and a height within 1e6 m",
					 name, from->position[0], from->position[1], from->position[2]);
	if (!(fabs(length - 1) <= UNIT))
		return fail_with(STATUS_USAGE, "%s: its orientation has length %g; give a unit quaternion w, x, y, z", name, length);
	for (int i = 0; i < 4; i++)
		q[i] = from->orientation[i] / length;
	*pose = (struct soil_pose){
		.x = lattice_offset(from->position[0]),
		.y = lattice_offset(from->position[1]),
		.z = lattice_offset(from->position[2]),
	};
	if (shape->kind == SOIL_SPHERE)
		return STATUS_OK;
	world_axes(q, axes);
	if (shape->kind == SOIL_WHEEL) {
		wheel_of((const double(*)[3])axes, pose);
		return STATUS_OK;
	}
	pose->pitch = atan2(axes[0][2], hypot(axes[0][0], axes[0][1]));
	/* Nose straight up or down: the whole turn about the vertical becomes yaw. */
	if (hypot(axes[0][0], axes[0][1]) < 1e-9) {
		pose->yaw = atan2(-axes[1][0], axes[1][1]);
		return STATUS_OK;
	}
	pose->yaw = atan2(axes[0][1], axes[0][0]);
	pose->roll = atan2(axes[1][2], axes[2][2]);
	return STATUS_OK;
}

/*
 * What was computed last. A step asks for the pose of each body several times. It follows from the kind of the body's shape and the numbers of
 * `from` alone. So each thread keeps the poses that it found last, by a hash of these numbers.
 */
#define KEPT 64 /* a power of two */
struct kept_attitude {
	struct furrow_pose from;
	enum soil_shape_kind kind;
	bool known;
	struct soil_pose pose;
};

static struct kept_attitude *kept_of(const struct furrow_pose *from)
{
	static _Thread_local struct kept_attitude kept[KEPT];
	uint64_t numbers[7], hash = 0;
	_Static_assert(sizeof numbers == sizeof *from, "all its numbers");
	memcpy(numbers, from, sizeof numbers);
	for (int i = 0; i < 7; i++)
		hash = (hash ^ numbers[i]) * 0x9e3779b97f4a7c15u;
	return &kept[hash >> 58];
}

enum status world_attitude(const struct soil_shape *shape, const char *name, const struct furrow_pose *from, struct soil_pose *pose)
{
	struct kept_attitude *kept = kept_of(from);
	if (!kept->known || kept->kind != shape->kind || memcmp(&kept->from, from, sizeof *from) != 0) {
		kept->known = false;
		TRY(find_attitude(shape, name, from, &kept->pose));
		kept->from = *from;
		kept->kind = shape->kind;
		kept->known = true;
	}
	*pose = kept->pose;
	return STATUS_OK;
}

/* A velocity, or three NaN in its place. */
static bool is_rate(const double rate[3])
{
	return (isfinite(rate[0]) && isfinite(rate[1]) && isfinite(rate[2])) || (isnan(rate[0]) && isnan(rate[1]) && isnan(rate[2]));
}

enum status world_state_check(const struct soil_shape *shape, const char *name, const struct furrow_state *state, struct soil_pose *pose)
{
	if (!is_rate(state->linear) || !is_rate(state->angular))
		return fail_with(STATUS_USAGE, "%s: a velocity is not a finite number; give m/s and rad/s, or three NaN for what the poses give", name);
	return world_attitude(shape, name, &state->pose, pose);
}

void world_orientation(const struct soil_pose *pose, double q[4])
{
	double axes[3][3];
	soil_axes(pose->yaw, pose->pitch, pose->roll, pose->turn, axes);
	/* Shepperd's method finds the largest of the four first, so that it never divides by a small number. */
	const double m[3][3] = {
		{axes[0][0], axes[1][0], axes[2][0]},
		{axes[0][1], axes[1][1], axes[2][1]},
		{axes[0][2], axes[1][2], axes[2][2]},
	};
	const double trace = m[0][0] + m[1][1] + m[2][2];
	int most = 0;
	double greatest = trace;
	for (int i = 0; i < 3; i++)
		if (m[i][i] > greatest) {
			greatest = m[i][i];
			most = i + 1;
		}
	const double root = sqrt(fmax(1 + 2 * greatest - trace, 0));
	if (most == 0) {
		q[0] = sqrt(1 + trace) / 2;
		q[1] = (m[2][1] - m[1][2]) / (4 * q[0]);
		q[2] = (m[0][2] - m[2][0]) / (4 * q[0]);
		q[3] = (m[1][0] - m[0][1]) / (4 * q[0]);
		return;
	}
	const int i = most - 1, j = (i + 1) % 3, k = (i + 2) % 3;
	q[1 + i] = root / 2;
	q[0] = (m[k][j] - m[j][k]) / (2 * root);
	q[1 + j] = (m[j][i] + m[i][j]) / (2 * root);
	q[1 + k] = (m[k][i] + m[i][k]) / (2 * root);
}
