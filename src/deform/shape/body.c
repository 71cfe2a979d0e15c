/* Converts the motion of a wheel, sphere or box to whole numbers, from which shaders compute its lower envelope. */
#include "deform/shape/body.h"

#include <math.h>
#include <string.h>

/* Converts fixed-point units to metres, rounded once. */
static long double metres(int64_t units)
{
	return ldexpl((long double)units, -OFFSET_BITS);
}

long double deform_body_from_post(int64_t place, int64_t post, double spacing)
{
	double whole = (double)post * spacing, rest = fma((double)post, spacing, -whole);
	return metres(place) - whole - rest;
}

static int64_t anchor_of(int64_t place, double spacing)
{
	return (int64_t)floor(lattice_offset_metres(place) / spacing);
}

struct body_motion deform_body_motion_of(const struct deform_pose *from, const struct deform_pose *to,
				  const struct body_frame *frame)
{
	int64_t x = anchor_of(to->x, frame->spacing), y = anchor_of(to->y, frame->spacing);
	return (struct body_motion){
		.x0 = frame->x0 - x,
		.y0 = frame->y0 - y,
		.x = deform_body_from_post(from->x, x, frame->spacing),
		.y = deform_body_from_post(from->y, y, frame->spacing),
		.dx = metres(to->x - from->x),
		.dy = metres(to->y - from->y),
		.z = from->z - frame->zero,
		.dz = to->z - from->z,
	};
}

/* Computes how far a post lies from (m->x, m->y) along the direction (c, s), as an affine function of the post's position. The
 * distance is multiplied by `factor`; then `plus` is added. `scale` and `shift`: as in deform_functional_of. */
static struct functional along(const struct body_motion *m, long double c, long double s, double spacing,
			       long double factor, long double plus, int scale, int shift)
{
	struct affine value = {(-(m->x * c + m->y * s)) * factor + plus, spacing * c * factor, spacing * s * factor};
	return deform_functional_of(value, scale, shift, m->x0, m->y0);
}

/* Returns how many fraction bits distances may have, so that the object and its motion stay below 2^30. Farther posts are clamped. */
static int fine_bits(const struct body_motion *m, long double size)
{
	int bits = 29 - ilogbl((hypotl(m->dx, m->dy) + size) * 1.001L);
	return bits < 40 ? bits : 40;
}

/* Computes rise / length as a factor of at most 30 bits and its shift. */
static void slope_of(int64_t rise, int64_t length, int32_t *factor, int32_t *shift)
{
	*factor = 0;
	*shift = 1;
	if (rise == 0 || length == 0)
		return;
	long double slope = (long double)rise / (long double)length;
	int bits = 27 - ilogbl(slope);
	bits = bits < 60 ? bits : 60;
	bits = bits > 1 ? bits : 1;
	*factor = (int32_t)llrintl(ldexpl(slope, bits));
	*shift = bits;
}

static void fill_round(struct body *body, const struct body_motion *m, long double radius, long double half_width,
		       long double length, int fine)
{
	int64_t run = llrintl(ldexpl(length, fine));
	body->a[0] = (int32_t)llrintl(ldexpl(radius, fine));
	body->a[1] = (int32_t)llrintl(ldexpl(half_width, fine));
	body->a[2] = (int32_t)run;
	long double rise = metres(m->dz);
	body->a[3] = run != 0 ? (int32_t)llrintl(ldexpl(rise / hypotl(rise, length), 28)) : 0;
	body->b[0] = (int32_t)m->z;
	body->b[1] = (int32_t)m->dz;
	slope_of(m->dz, run, &body->b[2], &body->b[3]);
	body->c[0] = 2 << (fine < OFFSET_BITS ? OFFSET_BITS - fine : 0);
	body->c[3] = 1 + (fine > OFFSET_BITS ? fine - OFFSET_BITS : 0);
}

static void wheel_of(const struct deform_shape *shape, const struct deform_pose *to, const struct body_motion *m,
		     const struct body_frame *frame, struct body *body)
{
	long double c = cosl(to->yaw), s = sinl(to->yaw);
	long double du = m->dx * c + m->dy * s, dv = m->dy * c - m->dx * s;
	if (du < 0) { /* a wheel has no front, so let it roll forwards */
		c = -c;
		s = -s;
		du = -du;
		dv = -dv;
	}
	int fine = fine_bits(m, fmax(shape->radius, shape->width / 2));
	long double half = shape->width / 2.0L;
	fill_round(body, m, shape->radius, half, du, fine);
	body->f[0] = along(m, c, s, frame->spacing, 1, 0, fine, 12);
	body->f[1] = along(m, -s, c, frame->spacing, 1, 0, fine, 12);
	if (llrintl(ldexpl(dv, fine)) != 0) {
		body->c[1] = 1;
		body->f[2] = along(m, -s, c, frame->spacing, 1 / dv, -half / dv, 28, 12);
		body->f[3] = along(m, -s, c, frame->spacing, 1 / dv, half / dv, 28, 12);
	}
}

static void sphere_of(const struct deform_shape *shape, const struct body_motion *m, const struct body_frame *frame,
		      struct body *body)
{
	long double length = hypotl(m->dx, m->dy);
	long double c = length > 0 ? m->dx / length : 1, s = length > 0 ? m->dy / length : 0;
	int fine = fine_bits(m, shape->radius);
	fill_round(body, m, shape->radius, 0, length, fine);
	body->f[0] = along(m, c, s, frame->spacing, 1, 0, fine, 12);
	body->f[1] = along(m, -s, c, frame->spacing, 1, 0, fine, 12);
}

void deform_body_axes(const double size[3], double yaw, double pitch, double roll, double axes[3][3])
{
	double cy = cos(yaw), sy = sin(yaw), cp = cos(pitch), sp = sin(pitch), cr = cos(roll), sr = sin(roll);
	/* Yaw first, then pitch (nose up), then roll (right side down). */
	const double turned[3][3] = {
		{cy * cp, sy * cp, sp},
		{-sy * cr - cy * sp * sr, cy * cr - sy * sp * sr, cp * sr},
		{sy * sr - cy * sp * cr, -cy * sr - sy * sp * cr, cp * cr},
	};
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 3; k++)
			axes[i][k] = turned[i][k] * size[i] / 2;
}

void deform_axes(double yaw, double pitch, double roll, double turn, double axes[3][3])
{
	const double unit[3] = {2, 2, 2}; /* of which half is one */
	double c = cos(turn), s = sin(turn);
	deform_body_axes(unit, yaw, pitch, roll, axes);
	for (int k = 0; k < 3; k++) {
		double forward = axes[0][k], up = axes[2][k];
		axes[0][k] = c * forward - s * up;
		axes[2][k] = s * forward + c * up;
	}
}

static void box_of(const struct deform_shape *shape, const struct deform_pose *to, const struct body_motion *m,
		   const struct body_frame *frame, struct body *body)
{
	double g[4][3];
	deform_body_axes(shape->size, to->yaw, to->pitch, to->roll, g);
	/* In fixed-point units above the zero, and in metres along the ground. */
	g[3][0] = (double)m->dx / 2;
	g[3][1] = (double)m->dy / 2;
	g[3][2] = (double)metres(m->dz) / 2;
	long double x = m->x + m->dx / 2, y = m->y + m->dy / 2;
	long double z = metres(m->z) + metres(m->dz) / 2;
	int planes = 0, slabs = 0;
	for (int p = 0; p < 4; p++)
		for (int q = p + 1; q < 4; q++) {
			long double n[3];
			for (int k = 0; k < 3; k++)
				n[k] = (long double)g[p][(k + 1) % 3] * g[q][(k + 2) % 3] -
				       (long double)g[p][(k + 2) % 3] * g[q][(k + 1) % 3];
			long double size = sqrtl(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
			if (size == 0 || fabsl(n[2]) < 1e-6L * size)
				continue; /* not a plane, or a vertical one, which is one of the slabs */
			long double support = 0;
			for (int k = 0; k < 4; k++)
				support += fabsl(n[0] * g[k][0] + n[1] * g[k][1] + n[2] * g[k][2]);
			long double gx = -n[0] / n[2], gy = -n[1] / n[2], low = z - support / fabsl(n[2]);
			struct affine plane = {low - gx * x - gy * y, gx * frame->spacing, gy * frame->spacing};
			body->f[planes++] = deform_functional_of(plane, OFFSET_BITS, 12, m->x0, m->y0);
		}
	for (int p = 0; p < 4; p++) {
		long double nx = -g[p][1], ny = g[p][0], half = 0;
		if (nx == 0 && ny == 0)
			continue;
		for (int k = 0; k < 4; k++)
			half += fabsl(nx * g[k][0] + ny * g[k][1]);
		if (half < 1e-12L * hypotl(nx, ny))
			continue; /* it has no width here, and the other slabs bound the box */
		nx /= half;
		ny /= half;
		struct affine slab = {-nx * x - ny * y, nx * frame->spacing, ny * frame->spacing};
		body->f[6 + slabs++] = deform_functional_of(slab, 28, 12, m->x0, m->y0);
	}
	body->c[1] = planes;
	body->c[2] = slabs;
}

void deform_body_of(const struct deform_shape *shape, const struct deform_pose *from, const struct deform_pose *to,
	     const struct body_frame *frame, struct body *body)
{
	struct body_motion m = deform_body_motion_of(from, to, frame);
	memset(body, 0, sizeof *body);
	switch (shape->kind) {
	case DEFORM_WHEEL:
		wheel_of(shape, to, &m, frame, body);
		break;
	case DEFORM_SPHERE:
		sphere_of(shape, &m, frame, body);
		break;
	case DEFORM_BOX:
		box_of(shape, to, &m, frame, body);
		break;
	case DEFORM_MESH:
	case DEFORM_SHAPES:
		break; /* it has no closed form */
	}
}

double deform_body_wheel_radius(const struct deform_shape *shape)
{
	return shape->grousers > 0 ? hypot(shape->radius + shape->grouser_height, shape->grouser_thickness / 2) : shape->radius;
}

/* Computes the extent of a mesh: that of its bounding box. */
static void mesh_extent(const struct deform_mesh *mesh, const struct deform_pose *pose, double extent[2])
{
	const double unit[3] = {2, 2, 2};
	double axes[3][3];
	deform_body_axes(unit, pose->yaw, pose->pitch, pose->roll, axes);
	for (int k = 0; k < 2; k++) {
		double low = 0, high = 0;
		for (int i = 0; i < 3; i++) {
			low += fmin(axes[i][k] * mesh->low[i], axes[i][k] * mesh->high[i]);
			high += fmax(axes[i][k] * mesh->low[i], axes[i][k] * mesh->high[i]);
		}
		extent[k] = fmax(fabs(low), fabs(high));
	}
}

void deform_body_extent(const struct deform_shape *shape, const struct deform_pose *pose, double extent[2])
{
	double axes[3][3];
	extent[0] = extent[1] = shape->radius;
	if (shape->kind == DEFORM_WHEEL) {
		double radius = deform_body_wheel_radius(shape);
		extent[0] = fabs(cos(pose->yaw)) * radius + fabs(sin(pose->yaw)) * shape->width / 2;
		extent[1] = fabs(sin(pose->yaw)) * radius + fabs(cos(pose->yaw)) * shape->width / 2;
	} else if (shape->kind == DEFORM_MESH) {
		mesh_extent(shape->mesh, pose, extent);
	} else if (shape->kind == DEFORM_BOX) {
		deform_body_axes(shape->size, pose->yaw, pose->pitch, pose->roll, axes);
		for (int k = 0; k < 2; k++)
			extent[k] = fabs(axes[0][k]) + fabs(axes[1][k]) + fabs(axes[2][k]);
	}
}
