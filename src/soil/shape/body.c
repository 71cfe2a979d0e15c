/* Converts the motion of a shape to whole numbers, from which shaders compute its lower envelope. */
#include "soil/shape/body.h"

#include <math.h>
#include <string.h>

#include "soil/shape/lower_envelope.h"

/* Converts fixed-point units to metres, rounded once. */
static long double metres(int64_t units)
{
	return by_power((long double)units, -OFFSET_BITS);
}

long double soil_body_from_post(int64_t place, int64_t post, double spacing)
{
	double whole = (double)post * spacing, rest = fma((double)post, spacing, -whole);
	return metres(place) - whole - rest;
}

static int64_t anchor_of(int64_t place, double spacing)
{
	return (int64_t)floor(lattice_offset_metres(place) / spacing);
}

struct body_motion soil_body_motion_of(const struct soil_pose *from, const struct soil_pose *to,
				  const struct body_frame *frame)
{
	int64_t x = anchor_of(to->x, frame->spacing), y = anchor_of(to->y, frame->spacing);
	return (struct body_motion){
		.x0 = frame->x0 - x,
		.y0 = frame->y0 - y,
		.x = soil_body_from_post(from->x, x, frame->spacing),
		.y = soil_body_from_post(from->y, y, frame->spacing),
		.dx = metres(to->x - from->x),
		.dy = metres(to->y - from->y),
		.z = from->z - frame->zero,
		.dz = to->z - from->z,
	};
}

/* Computes how far a post lies from (m->x, m->y) along the direction (c, s), as an affine function of the post's position. The
 * distance is multiplied by `factor`; then `plus` is added. `scale` and `shift`: as in soil_functional_of. */
static struct functional along(const struct body_motion *m, long double c, long double s, double spacing,
			       long double factor, long double plus, int scale, int shift)
{
	struct affine value = {(-(m->x * c + m->y * s)) * factor + plus, spacing * c * factor, spacing * s * factor};
	return soil_functional_of(value, scale, shift, m->x0, m->y0);
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
	*factor = (int32_t)llrintl(by_power(slope, bits));
	*shift = bits;
}

/* Computes a ratio as a factor of at most 28 bits and its shift. */
static void ratio_of(long double ratio, int32_t *factor, int32_t *shift)
{
	*factor = 0;
	*shift = 1;
	if (ratio == 0)
		return;
	int bits = 27 - ilogbl(ratio);
	*shift = bits < 1 ? 1 : bits < 62 ? bits : 62;
	*factor = (int32_t)llrintl(by_power(ratio, *shift));
}

static void fill_round(struct body *body, const struct body_motion *m, long double radius, long double half_width,
		       long double length, int fine)
{
	int64_t run = llrintl(by_power(length, fine));
	body->a[0] = (int32_t)llrintl(by_power(radius, fine));
	body->a[1] = (int32_t)llrintl(by_power(half_width, fine));
	body->a[2] = (int32_t)run;
	long double rise = metres(m->dz);
	body->a[3] = run != 0 ? (int32_t)llrintl(by_power(rise / hypotl(rise, length), 28)) : 0;
	body->b[0] = (int32_t)m->z;
	body->b[1] = (int32_t)m->dz;
	slope_of(m->dz, run, &body->b[2], &body->b[3]);
	body->c[0] = 2 << (fine < OFFSET_BITS ? OFFSET_BITS - fine : 0);
	body->c[3] = 1 + (fine > OFFSET_BITS ? fine - OFFSET_BITS : 0);
}

static void wheel_of(const struct soil_shape *shape, const struct body_motion *m, const struct body_frame *frame, struct body *body)
{
	long double c = frame->yaw[0], s = frame->yaw[1];
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
	if (llrintl(by_power(dv, fine)) != 0) {
		body->c[1] = 1;
		body->f[2] = along(m, -s, c, frame->spacing, 1 / dv, -half / dv, 28, 12);
		body->f[3] = along(m, -s, c, frame->spacing, 1 / dv, half / dv, 28, 12);
	}
}

static void sphere_of(const struct soil_shape *shape, const struct body_motion *m, const struct body_frame *frame,
		      struct body *body)
{
	long double length = hypotl(m->dx, m->dy);
	long double c = length > 0 ? m->dx / length : 1, s = length > 0 ? m->dy / length : 0;
	int fine = fine_bits(m, shape->radius);
	fill_round(body, m, shape->radius, 0, length, fine);
	body->f[0] = along(m, c, s, frame->spacing, 1, 0, fine, 12);
	body->f[1] = along(m, -s, c, frame->spacing, 1, 0, fine, 12);
}

static int32_t clamped(long double value)
{
	return (int32_t)llrintl(fmaxl(fminl(value, 0x1p30L), -0x1p30L));
}

/*
 * A shape that is round about an axis: a cylinder, a capsule, a wheel with camber. Lengths along the axis in plan are `a`, across it `v`,
 * from the centre at the start. Its lower envelope while it moves is the lowest of these:
 * - its lower envelopes where it starts and where it ends;
 * - the lower sides of what its two ends pass through: the rims of a cylinder, the balls of a capsule;
 * - the flat face that the lowest line along its side passes through.
 */
struct rod {
	const struct body_motion *m;
	long double spacing, radius, half;   /* half: of the axis' straight part */
	long double c, s, e[2];              /* the axis: its part in plan, and its rise; the direction in plan */
	long double da, dv, dz;              /* motion */
	int fine;
};

/* An affine function a x + v y + plus, scaled. */
static struct functional rod_along(const struct rod *rod, long double a, long double v, long double plus, int scale)
{
	return along(rod->m, a * rod->e[0] - v * rod->e[1], a * rod->e[1] + v * rod->e[0], rod->spacing, 1, plus, scale, 12);
}

/* Fills the flat face: f[7] its height, f[8] and f[9] where it lies. */
static void rod_face(const struct rod *rod, struct body *body)
{
	long double n[3] = {-rod->s * rod->dv, rod->s * rod->da - rod->c * rod->dz, rod->c * rod->dv};
	long double size = sqrtl(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]), sign = n[2] < 0 ? -1 : 1;
	if (!(fabsl(n[2]) > 1e-6L * size) || rod->c * rod->half < 1e-6L)
		return; /* it is upright, or no face */
	for (int k = 0; k < 3; k++)
		n[k] *= sign / size;
	long double r = rod->radius, skew = rod->da / rod->dv, by = 1 / (rod->c * rod->half);
	body->f[7] = rod_along(rod, -n[0] / n[2], -n[1] / n[2], -r / n[2], OFFSET_BITS);
	body->f[8] = rod_along(rod, by, -skew * by, (n[0] - n[1] * skew) * r * by, 28);
	body->f[9] = rod_along(rod, 0, 2 / rod->dv, 2 * r * n[1] / rod->dv - 1, 28);
	body->d[0] = 1;
}

/* Fills the motion of the ends. `k`: s for a rim, 1 for a ball. The lower end: f[4] across its motion, f[5] along it, f[6] a rim's height
 * in the middle. The upper end: f[10] to f[12]. */
static void rod_ends(const struct rod *rod, long double k, struct body *body)
{
	long double n = hypotl(rod->da, k * rod->dv), c = rod->c, s = rod->s;
	body->a[3] = (int32_t)llrintl(by_power(n, rod->fine));
	if (body->a[3] == 0)
		return;
	for (int end = 0; end < 2; end++) {
		long double from = (end == 0 ? 1 : -1) * rod->half * c; /* the end is at a = -from */
		long double across[3] = {-rod->dv / n, rod->da / n, -from * rod->dv / n}, ahead[3] = {rod->da / n, k * k * rod->dv / n, from * rod->da / n};
		struct functional *f = &body->f[end == 0 ? 4 : 10];
		long double tilt = c * s * rod->dv / n, rises = rod->dz / n, middle = (end == 0 ? -1 : 1) * rod->half * s;
		f[0] = rod_along(rod, across[0], across[1], across[2], rod->fine);
		f[1] = rod_along(rod, ahead[0], ahead[1], ahead[2], rod->fine);
		f[2] = rod_along(rod, tilt * across[0] + rises * ahead[0], tilt * across[1] + rises * ahead[1],
				 tilt * across[2] + rises * ahead[2] + middle, OFFSET_BITS);
	}
	body->e[0] = (int32_t)llrintl(by_power(rod->dz / hypotl(rod->dz, n), 28));
	slope_of(rod->m->dz, body->a[3], &body->e[1], &body->e[2]);
	ratio_of(by_power((c * rod->da + k * rod->dz) / n, OFFSET_BITS - rod->fine), &body->d[1], &body->d[2]);
}

static void rod_of(const struct soil_shape *shape, const struct soil_pose *to, const struct body_motion *m, const struct body_frame *frame,
		   struct body *body)
{
	struct lower_envelope u;
	bool capsule = shape->kind == SOIL_CAPSULE;
	soil_lower_of(shape, to, &u);
	struct rod rod = {.m = m, .spacing = frame->spacing, .radius = u.radius, .half = u.half, .c = u.level, .s = u.axis[2],
			  .e = {u.along[0], u.along[1]}, .dz = metres(m->dz)};
	rod.da = m->dx * rod.e[0] + m->dy * rod.e[1];
	rod.dv = m->dy * rod.e[0] - m->dx * rod.e[1];
	rod.fine = fine_bits(m, hypotl(rod.radius, rod.half) + (capsule ? rod.radius : 0));
	/* So little that no post sees it. */
	bool level = !capsule && rod.s * rod.radius < 1e-6L, upright = rod.c * rod.half < 1e-6L;
	body->a[0] = (int32_t)llrintl(by_power(rod.radius, rod.fine));
	body->a[1] = upright ? 0 : (int32_t)llrintl(by_power(rod.c * rod.half, rod.fine));
	body->a[2] = level ? 0 : (int32_t)llrintl(by_power(rod.s, 28));
	body->b[0] = (int32_t)m->z;
	body->b[1] = (int32_t)m->dz;
	body->c[0] = (int32_t)llrintl(by_power(rod.dv, rod.fine));
	body->c[1] = (int32_t)llrintl(by_power(rod.da, rod.fine));
	body->c[2] = upright ? 0 : clamped(by_power(rod.dz - rod.da * rod.s / rod.c, OFFSET_BITS));
	body->c[3] = level || capsule ? 0 : clamped(by_power(rod.dz + rod.da * rod.c / rod.s, OFFSET_BITS));
	body->f[0] = rod_along(&rod, 0, 1, 0, rod.fine);
	body->f[1] = rod_along(&rod, 1, 0, 0, rod.fine);
	body->b[3] = 1;
	if (!upright) {
		body->f[2] = rod_along(&rod, rod.s / rod.c, 0, 0, OFFSET_BITS);
		ratio_of(by_power(1 / rod.c, OFFSET_BITS - rod.fine), &body->b[2], &body->b[3]);
	}
	if (!level && !capsule)
		body->f[3] = rod_along(&rod, -rod.c / rod.s, 0, -rod.half / rod.s, OFFSET_BITS);
	rod_ends(&rod, capsule ? 1 : rod.s, body);
	rod_face(&rod, body);
	if (!capsule)
		return;
	ratio_of(by_power(1, OFFSET_BITS - rod.fine), &body->d[1], &body->d[2]);
	body->d[3] = (int32_t)llrintl(by_power(rod.half * rod.s, OFFSET_BITS));
}

/* An ellipsoid is a sphere that was stretched, and then sheared along the vertical. The sphere's radius is the largest half axis in plan. */
static void ellipsoid_of(const struct soil_shape *shape, const struct soil_pose *to, const struct body_motion *m,
			 const struct body_frame *frame, struct body *body)
{
	struct lower_envelope u;
	soil_lower_of(shape, to, &u);
	const double *q = u.inside;
	long double wide = hypotl((q[0] - q[2]) / 2, q[1]), r = 1 / sqrtl((q[0] + q[2]) / 2 - wide), moved = hypotl(m->dx, m->dy);
	long double x = moved > 0 ? m->dx / moved : 1, y = moved > 0 ? m->dy / moved : 0;
	long double by_x = q[0] * x + q[1] * y, by_y = q[1] * x + q[2] * y, stretched = r * sqrtl(x * by_x + y * by_y);
	long double length = moved * stretched, cross = r * r * sqrtl((long double)q[0] * q[2] - (long double)q[1] * q[1]) / stretched;
	int fine = 29 - ilogbl((length + r) * 1.001L);
	fine = fine < 40 ? fine : 40;
	int64_t run = llrintl(by_power(length, fine));
	long double rise = metres(m->dz) - u.rise[0] * m->dx - u.rise[1] * m->dy, as_sphere = rise * r / u.lift;
	body->a[0] = (int32_t)llrintl(by_power(r, fine));
	body->a[2] = (int32_t)run;
	body->a[3] = run != 0 ? (int32_t)llrintl(by_power(as_sphere / hypotl(as_sphere, length), 28)) : 0;
	body->b[0] = (int32_t)m->z;
	body->b[1] = (int32_t)m->dz;
	slope_of(llrintl(by_power(rise, OFFSET_BITS)), run, &body->b[2], &body->b[3]);
	ratio_of(by_power(u.lift / r, OFFSET_BITS - fine), &body->c[0], &body->c[3]);
	body->f[0] = along(m, r * r * by_x / stretched, r * r * by_y / stretched, frame->spacing, 1, 0, fine, 12);
	body->f[1] = along(m, -cross * y, cross * x, frame->spacing, 1, 0, fine, 12);
	body->f[2] = along(m, u.rise[0], u.rise[1], frame->spacing, 1, 0, OFFSET_BITS, 12);
}

/* Most angles are 0: of a wheel its pitch, and what a body has not turned. */
static void turn_of(double angle, double *c, double *s)
{
	*c = angle == 0 ? 1 : cos(angle);
	*s = angle == 0 ? angle : sin(angle);
}

void soil_body_axes(const double size[3], double yaw, double pitch, double roll, double axes[3][3])
{
	double cy, sy, cp, sp, cr, sr;
	turn_of(yaw, &cy, &sy);
	turn_of(pitch, &cp, &sp);
	turn_of(roll, &cr, &sr);
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

void soil_axes(double yaw, double pitch, double roll, double turn, double axes[3][3])
{
	const double unit[3] = {2, 2, 2}; /* of which half is one */
	double c, s;
	turn_of(turn, &c, &s);
	soil_body_axes(unit, yaw, pitch, roll, axes);
	for (int k = 0; k < 3; k++) {
		double forward = axes[0][k], up = axes[2][k];
		axes[0][k] = c * forward - s * up;
		axes[2][k] = s * forward + c * up;
	}
}

static void box_of(const struct soil_shape *shape, const struct soil_pose *to, const struct body_motion *m,
		   const struct body_frame *frame, struct body *body)
{
	double g[4][3];
	soil_body_axes(shape->size, to->yaw, to->pitch, to->roll, g);
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
			body->f[planes++] = soil_functional_of(plane, OFFSET_BITS, 12, m->x0, m->y0);
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
		body->f[6 + slabs++] = soil_functional_of(slab, 28, 12, m->x0, m->y0);
	}
	body->c[1] = planes;
	body->c[2] = slabs;
}

void soil_body_of(const struct soil_shape *shape, const struct soil_pose *from, const struct soil_pose *to,
	     const struct body_frame *frame, struct body *body)
{
	struct body_motion m = soil_body_motion_of(from, to, frame);
	memset(body, 0, sizeof *body);
	switch (shape->kind) {
	case SOIL_WHEEL:
		if (to->roll == 0)
			wheel_of(shape, &m, frame, body);
		else
			rod_of(shape, to, &m, frame, body);
		break;
	case SOIL_CYLINDER:
	case SOIL_CAPSULE:
		rod_of(shape, to, &m, frame, body);
		break;
	case SOIL_ELLIPSOID:
		ellipsoid_of(shape, to, &m, frame, body);
		break;
	case SOIL_SPHERE:
		sphere_of(shape, &m, frame, body);
		break;
	case SOIL_BOX:
		box_of(shape, to, &m, frame, body);
		break;
	case SOIL_MESH:
	case SOIL_SHAPES:
		break; /* it has no closed form */
	}
}

void soil_wheel_attitude(const double axle[3], double *yaw, double *roll)
{
	double level = hypot(axle[0], axle[1]);
	*yaw = level > 1e-9 ? atan2(-axle[0], axle[1]) : 0;
	*roll = atan2(axle[2], level);
}

enum soil_shape_kind soil_kind_in(const struct soil_shape *shape, const struct soil_pose *pose)
{
	return shape->kind == SOIL_WHEEL && pose->roll != 0 ? SOIL_CYLINDER : shape->kind;
}

double soil_body_wheel_radius(const struct soil_shape *shape)
{
	return shape->grousers > 0 ? hypot(shape->radius + shape->grouser_height, shape->grouser_thickness / 2) : shape->radius;
}

/* Computes the extent of a mesh: that of its bounding box. */
static void mesh_extent(const struct soil_mesh *mesh, const struct soil_pose *pose, double extent[2])
{
	const double unit[3] = {2, 2, 2};
	double axes[3][3];
	soil_body_axes(unit, pose->yaw, pose->pitch, pose->roll, axes);
	for (int k = 0; k < 2; k++) {
		double low = 0, high = 0;
		for (int i = 0; i < 3; i++) {
			low += fmin(axes[i][k] * mesh->low[i], axes[i][k] * mesh->high[i]);
			high += fmax(axes[i][k] * mesh->low[i], axes[i][k] * mesh->high[i]);
		}
		extent[k] = fmax(fabs(low), fabs(high));
	}
}

void soil_body_extent(const struct soil_shape *shape, const struct soil_pose *pose, double extent[2])
{
	double axes[3][3], axis[3];
	extent[0] = extent[1] = shape->radius;
	if (soil_kind_in(shape, pose) == SOIL_CYLINDER || shape->kind == SOIL_CAPSULE) {
		bool wheel = shape->kind == SOIL_WHEEL;
		double radius = wheel ? soil_body_wheel_radius(shape) : shape->radius;
		soil_shape_axis(shape, pose, axis);
		for (int k = 0; k < 2; k++)
			extent[k] = fabs(axis[k]) * (wheel ? shape->width : shape->length) / 2 +
				    radius * (shape->kind == SOIL_CAPSULE ? 1 : sqrt(1 - fmin(axis[k] * axis[k], 1)));
	} else if (shape->kind == SOIL_ELLIPSOID) {
		const double whole[3] = {2 * shape->size[0], 2 * shape->size[1], 2 * shape->size[2]};
		soil_body_axes(whole, pose->yaw, pose->pitch, pose->roll, axes);
		for (int k = 0; k < 2; k++)
			extent[k] = hypot(hypot(axes[0][k], axes[1][k]), axes[2][k]);
	} else if (shape->kind == SOIL_WHEEL) {
		double radius = soil_body_wheel_radius(shape);
		extent[0] = fabs(cos(pose->yaw)) * radius + fabs(sin(pose->yaw)) * shape->width / 2;
		extent[1] = fabs(sin(pose->yaw)) * radius + fabs(cos(pose->yaw)) * shape->width / 2;
	} else if (shape->kind == SOIL_MESH) {
		mesh_extent(shape->mesh, pose, extent);
	} else if (shape->kind == SOIL_BOX) {
		soil_body_axes(shape->size, pose->yaw, pose->pitch, pose->roll, axes);
		for (int k = 0; k < 2; k++)
			extent[k] = fabs(axes[0][k]) + fabs(axes[1][k]) + fabs(axes[2][k]);
	}
}
