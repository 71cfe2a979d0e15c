/*
 * The lower envelope of each shape in closed form, in doubles.
 *
 * A round shape is cut by upright planes along its axis. `a` is a place along the axis in plan, `v` across it, s and c the sine and cosine
 * of the axis' slope. A plane at v cuts a strip of half-width R = sqrt(r^2 - v^2) about the axis. The lower end lies where
 * a <= R s - h c. The side, z = (a s - R) / c, goes on from there to a = R s + h c. A capsule's upper end lies beyond.
 */
#include "soil/shape/lower_envelope.h"

#include <math.h>
#include <string.h>

#define LEVEL_LEAST 1e-9 /* an axis whose length in plan is less is upright */

static double dot(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void soil_shape_axis(const struct soil_shape *shape, const struct soil_pose *pose, double axis[3])
{
	/* Of soil_axes with no turn: of a wheel the second without pitch, of others the third. */
	const double cy = cos(pose->yaw), sy = sin(pose->yaw), cr = cos(pose->roll), sr = sin(pose->roll);
	double own[3] = {-sy * cr, cy * cr, sr};
	if (shape->kind != SOIL_WHEEL) {
		const double cp = cos(pose->pitch), sp = sin(pose->pitch);
		own[0] = sy * sr - cy * sp * cr;
		own[1] = -cy * sr - sy * sp * cr;
		own[2] = cp * cr;
	}
	const double sign = own[2] < 0 ? -1 : 1;
	for (int k = 0; k < 3; k++)
		axis[k] = sign * own[k];
}

void soil_ellipsoid_of(const double radii[3], double axes[3][3], double rise[2], double *lift, double inside[3])
{
	double m[3][3];
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 3; k++) {
			m[i][k] = 0;
			for (int j = 0; j < 3; j++)
				m[i][k] += axes[j][i] * axes[j][k] * radii[j] * radii[j];
		}
	double plan = m[0][0] * m[1][1] - m[0][1] * m[0][1];
	inside[0] = m[1][1] / plan;
	inside[1] = -m[0][1] / plan;
	inside[2] = m[0][0] / plan;
	rise[0] = inside[0] * m[0][2] + inside[1] * m[1][2];
	rise[1] = inside[1] * m[0][2] + inside[2] * m[1][2];
	/* The square of its height in the middle, which is the determinant over that in plan. */
	*lift = radii[0] * radii[1] * radii[2] / sqrt(plan);
}

void soil_lower_of(const struct soil_shape *shape, const struct soil_pose *pose, struct lower_envelope *lower)
{
	bool wheel = shape->kind == SOIL_WHEEL;
	*lower = (struct lower_envelope){.shape = shape, .radius = shape->radius, .half = (wheel ? shape->width : shape->length) / 2, .turn = pose->turn};
	soil_axes(pose->yaw, wheel ? 0 : pose->pitch, pose->roll, 0, lower->axes);
	soil_shape_axis(shape, pose, lower->axis);
	lower->level = hypot(lower->axis[0], lower->axis[1]);
	bool upright = lower->level < LEVEL_LEAST;
	lower->along[0] = upright ? 1 : lower->axis[0] / lower->level;
	lower->along[1] = upright ? 0 : lower->axis[1] / lower->level;
	if (shape->kind == SOIL_ELLIPSOID)
		soil_ellipsoid_of(shape->size, lower->axes, lower->rise, &lower->lift, lower->inside);
}

/* Fills a place by its height and the slopes of the lower envelope there. */
static bool by_slope(double z, double east, double north, struct lower_place *place)
{
	double up = 1 / sqrt(1 + east * east + north * north);
	*place = (struct lower_place){z, {-east * up, -north * up, up}};
	return true;
}

/* The lower side of a ball whose centre is (x, y) from the place, and `above` the shape's centre. */
static bool ball_at(const struct lower_envelope *u, double x, double y, double above, struct lower_place *place)
{
	double radius = u->radius, squares = radius * radius - x * x - y * y;
	if (squares < -2 * radius * u->beside)
		return false;
	double up = sqrt(fmax(squares, 0));
	*place = (struct lower_place){above - up, {x / radius, y / radius, up / radius}};
	return true;
}

static bool round_at(const struct lower_envelope *u, double x, double y, struct lower_place *place)
{
	double a = x * u->along[0] + y * u->along[1], v = y * u->along[0] - x * u->along[1], r = u->radius;
	double s = u->axis[2], c = u->level;
	if (fabs(v) > r + u->beside)
		return false;
	double strip = sqrt(fmax(r * r - v * v, 0));
	bool capsule = u->shape->kind == SOIL_CAPSULE, low = a <= strip * s - u->half * c, high = a > strip * s + u->half * c;
	if (capsule && (low || high)) {
		double end = low ? -u->half : u->half;
		return ball_at(u, u->axis[0] * end - x, u->axis[1] * end - y, s * end, place);
	}
	if (!capsule && fabs(a) > u->half * c + strip * s + u->beside)
		return false;
	if (low && s > 0) {
		place->z = (-u->half - a * c) / s;
		memcpy(place->normal, u->axis, sizeof place->normal);
		return true;
	}
	/* From the place to the axis, across it. */
	double along = strip * s / r, across = v / r;
	place->z = (a * s - strip) / c;
	place->normal[0] = -along * u->along[0] + across * u->along[1];
	place->normal[1] = -along * u->along[1] - across * u->along[0];
	place->normal[2] = strip * c / r;
	return true;
}

/* The vertical line above a place, cut by the three pairs of faces of a box with this centre and these half-axes' directions. */
static bool brick_at(double axes[3][3], const double half[3], const double middle[3], double beside, double x, double y, struct lower_place *place)
{
	double enter = -INFINITY, leave = INFINITY;
	const double at[3] = {x - middle[0], y - middle[1], 0};
	for (int k = 0; k < 3; k++) {
		double far = dot(axes[k], at), up = axes[k][2];
		if (fabs(up) < 1e-12) {
			if (fabs(far) > half[k] + beside)
				return false;
			continue;
		}
		double low = (-copysign(half[k], up) - far) / up, high = (copysign(half[k], up) - far) / up;
		if (low > enter) {
			enter = low;
			for (int i = 0; i < 3; i++)
				place->normal[i] = copysign(1, up) * axes[k][i];
		}
		leave = fmin(leave, high);
	}
	place->z = middle[2] + enter;
	return enter <= leave + beside;
}

static bool ellipsoid_at(const struct lower_envelope *u, double x, double y, struct lower_place *place)
{
	double left = 1 - (u->inside[0] * x * x + 2 * u->inside[1] * x * y + u->inside[2] * y * y);
	if (left < 0)
		return false;
	double root = sqrt(left), steep = u->lift / fmax(root, 1e-12);
	return by_slope(u->rise[0] * x + u->rise[1] * y - u->lift * root, u->rise[0] + steep * (u->inside[0] * x + u->inside[1] * y),
			u->rise[1] + steep * (u->inside[1] * x + u->inside[2] * y), place);
}

/* Keeps the lower of two places. */
static bool keep_lower(bool any, struct lower_place *place, bool found, const struct lower_place *other)
{
	if (found && (!any || other->z < place->z))
		*place = *other;
	return any || found;
}

static bool mesh_at(const struct lower_envelope *u, double x, double y, struct lower_place *place)
{
	const struct soil_mesh *mesh = u->shape->mesh;
	bool any = false;
	for (uint32_t t = 0; t < mesh->triangle_count; t++) {
		double at[3][3];
		struct lower_place here;
		for (int i = 0; i < 3; i++)
			for (int k = 0; k < 3; k++) {
				const float *vertex = mesh->vertices[mesh->triangles[t][i]];
				at[i][k] = vertex[0] * u->axes[0][k] + vertex[1] * u->axes[1][k] + vertex[2] * u->axes[2][k];
			}
		double px = at[1][0] - at[0][0], py = at[1][1] - at[0][1], qx = at[2][0] - at[0][0], qy = at[2][1] - at[0][1];
		double area = px * qy - py * qx, dx = x - at[0][0], dy = y - at[0][1];
		double p = (dx * qy - dy * qx) / area, q = (px * dy - py * dx) / area;
		if (!(fabs(area) > 1e-15) || p < 0 || q < 0 || p + q > 1)
			continue;
		double pz = at[1][2] - at[0][2], qz = at[2][2] - at[0][2];
		any = keep_lower(any, place, by_slope(at[0][2] + p * pz + q * qz, (pz * qy - qz * py) / area, (qz * px - pz * qx) / area, &here), &here);
	}
	return any;
}

/* Bars across a wheel's rim: the same as soil_bars gives. */
static bool grousers_at(const struct lower_envelope *u, double x, double y, bool any, struct lower_place *place)
{
	const struct soil_shape *shape = u->shape;
	double inner = sqrt(fmax(0, shape->radius * shape->radius - shape->grouser_thickness * shape->grouser_thickness / 4));
	double outer = shape->radius + shape->grouser_height;
	const double half[3] = {shape->grouser_thickness / 2, shape->width / 2, (outer - inner) / 2};
	for (int i = 0; i < shape->grousers; i++) {
		double angle = u->turn + i * (2 * M_PI / shape->grousers), s = sin(angle), c = cos(angle), axes[3][3], middle[3];
		struct lower_place here;
		for (int k = 0; k < 3; k++) {
			axes[0][k] = c * u->axes[0][k] - s * u->axes[2][k];
			axes[1][k] = u->axes[1][k];
			axes[2][k] = s * u->axes[0][k] + c * u->axes[2][k];
			middle[k] = -axes[2][k] * (inner + outer) / 2;
		}
		any = keep_lower(any, place, brick_at(axes, half, middle, u->beside, x, y, &here), &here);
	}
	return any;
}

bool soil_lower_at(const struct lower_envelope *u, double x, double y, struct lower_place *place)
{
	const double half[3] = {u->shape->size[0] / 2, u->shape->size[1] / 2, u->shape->size[2] / 2};
	double axes[3][3];
	switch (u->shape->kind) {
	case SOIL_WHEEL:
		return grousers_at(u, x, y, round_at(u, x, y, place), place);
	case SOIL_CYLINDER:
	case SOIL_CAPSULE:
		return round_at(u, x, y, place);
	case SOIL_SPHERE:
		return ball_at(u, -x, -y, 0, place);
	case SOIL_ELLIPSOID:
		return ellipsoid_at(u, x, y, place);
	case SOIL_BOX:
		memcpy(axes, u->axes, sizeof axes);
		return brick_at(axes, half, (const double[3]){0, 0, 0}, u->beside, x, y, place);
	case SOIL_MESH:
		return mesh_at(u, x, y, place);
	case SOIL_SHAPES:
		break;
	}
	return false;
}
