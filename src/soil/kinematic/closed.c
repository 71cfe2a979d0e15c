/* Lower envelopes of a wheel, a sphere, an ellipsoid and a box at posts of a row. See closed.h. */
#include "soil/kinematic/closed.h"

#include "soil/kinematic/rows.h"

/* Functionals 0 and 1: a post's place along and across the motion, from the centre at the start. 2 and 3: the times at which the two sides of a
 * wheel that moves sideways pass over the post. Those count only then. */
SOIL_INLINED void wheel(const struct body *body, bool sideways, int32_t x, int32_t y, int32_t *out)
{
	const int32_t r = body->a[0], half = body->a[1], length = body->a[2], sine = body->a[3];
	const int32_t z = body->b[0], rise_all = body->b[1], rise_by = body->b[2], units_by = body->c[0];
	const int rise_shift = body->b[3], units_shift = body->c[3];
	const int32_t tangent = lane_scaled(r, sine, 28);
	int32_t along[LANES], across[LANES], p[LANES], q[LANES];
	lane_values(&body->f[0], x, y, along);
	lane_values(&body->f[1], x, y, across);
	if (sideways) {
		lane_values(&body->f[2], x, y, p);
		lane_values(&body->f[3], x, y, q);
	}
	EACH_LANE(i) {
		const int32_t u = along[i];
		int32_t first = 0, last = ENVELOPE_ONE;
		if (sideways) {
			first = lane_most(0, lane_least(p[i], q[i]));
			last = lane_least(ENVELOPE_ONE, lane_most(p[i], q[i]));
		}
		bool covered = sideways ? first <= last : lane_size(across[i]) <= half;
		first = lane_clamp(first, 0, ENVELOPE_ONE);
		last = lane_clamp(last, 0, ENVELOPE_ONE);
		/* `from`: distance from the centre to the post at the time when the wheel is lowest there. That is where the wheel is tangent to its
		 * motion. */
		const int32_t at_last = u - lane_scaled(last, length, 28), at_first = u - lane_scaled(first, length, 28);
		const int32_t low = lane_most(at_last, -r), high = lane_least(at_first, r);
		covered = covered & (low <= high);
		const int32_t from = lane_clamp(lane_most(lane_least(tangent, high), low), -r, r);
		/* A known time gives the rise more exactly than a place: a wheel may slide aside while it hardly rolls. */
		const bool lasts = (from == at_last) & ((from != at_first) | (rise_all < 0)), timed = lasts | (from == at_first);
		const int32_t by_time = lane_scaled(lasts ? last : first, rise_all, 28), by_place = lane_scaled(u - from, rise_by, rise_shift);
		const int32_t up = lane_root(lane_product(r, r) - lane_product(from, from));
		const int32_t height = lane_sum(lane_sum(z, timed ? by_time : by_place), -lane_scaled(up, units_by, units_shift));
		out[i] = covered ? height : UNDER_NONE;
	}
}

/* The same for a motion of no length. */
SOIL_INLINED void wheel_at_rest(const struct body *body, int32_t x, int32_t y, int32_t *out)
{
	const int32_t r = body->a[0], half = body->a[1], z = lane_sum(body->b[0], lane_least(body->b[1], 0)), units_by = body->c[0];
	const int units_shift = body->c[3];
	int32_t along[LANES], across[LANES];
	lane_values(&body->f[0], x, y, along);
	lane_values(&body->f[1], x, y, across);
	EACH_LANE(i) {
		const int32_t from = lane_clamp(along[i], -r, r);
		const int32_t up = lane_root(lane_product(r, r) - lane_product(from, from));
		const int32_t height = lane_sum(z, -lane_scaled(up, units_by, units_shift));
		out[i] = ((along[i] == from) & (lane_size(across[i]) <= half)) ? height : UNDER_NONE;
	}
}

/* Functionals 0 and 1 as of a wheel. An ellipsoid is a sphere that was stretched, and then sheared along the vertical by functional 2. */
SOIL_INLINED void ball(const struct body *body, bool sheared, int32_t x, int32_t y, int32_t *out)
{
	const int32_t r = body->a[0], length = body->a[2], sine = body->a[3], z = body->b[0], rise_by = body->b[2], units_by = body->c[0];
	const int rise_shift = body->b[3], units_shift = body->c[3];
	const bool stays = length == 0;
	const int32_t dropped = lane_least(body->b[1], 0);
	int32_t along[LANES], across[LANES], shear[LANES];
	lane_values(&body->f[0], x, y, along);
	lane_values(&body->f[1], x, y, across);
	if (sheared)
		lane_values(&body->f[2], x, y, shear);
	EACH_LANE(i) {
		const int32_t u = along[i], v = lane_clamp(across[i], -r, r);
		const int64_t squares = lane_product(r, r) - lane_product(v, v);
		const int32_t ring = lane_root(squares);
		const int32_t low = lane_most(u - length, -ring), high = lane_least(u, ring);
		const int32_t from = lane_most(lane_least(lane_scaled(ring, sine, 28), high), low);
		const int64_t below = squares - lane_product(from, from);
		const int32_t bottom = lane_root(below < 0 ? 0 : below);
		const int32_t rise = stays ? dropped : lane_scaled(u - from, rise_by, rise_shift);
		const int32_t height = lane_sum(lane_sum(z, rise), -lane_scaled(bottom, units_by, units_shift));
		out[i] = ((across[i] == v) & (low <= high)) ? (sheared ? lane_sum(height, shear[i]) : height) : UNDER_NONE;
	}
}

/* A moving box is a zonotope. The post must lie inside all slabs, functionals 6 and on. The height is the highest of the lower planes,
 * functionals 0 and on. */
SOIL_INLINED void box(const struct body *body, int32_t x, int32_t y, int32_t *out)
{
	const int planes = body->c[1], slabs = body->c[2];
	int32_t height[LANES], outside[LANES], values[LANES];
	EACH_LANE(i) {
		height[i] = -ENVELOPE_REACH;
		outside[i] = 0;
	}
	for (int k = 0; k < slabs; k++) {
		lane_values(&body->f[6 + k], x, y, values);
		EACH_LANE(i)
			outside[i] |= lane_size(values[i]) > ENVELOPE_ONE;
	}
	for (int k = 0; k < planes; k++) {
		lane_values(&body->f[k], x, y, values);
		EACH_LANE(i)
			height[i] = lane_most(height[i], values[i]);
	}
	EACH_LANE(i)
		out[i] = outside[i] ? UNDER_NONE : height[i];
}

#define EACH_LANES(posts, stride, expression) \
	for (int row = 0; row < (posts)->rows; row++) \
		for (int first = 0; first < (posts)->count; first += LANES) { \
			const int32_t x = (posts)->x + first, y = (posts)->y + row; \
			const size_t at = (size_t)row * (stride) + (size_t)first; \
			expression; \
		}

static SOIL_LANES void wheels(const struct closed_form *s, const struct closed_posts *posts, size_t stride, int32_t *under, int32_t *rest)
{
	EACH_LANES(posts, stride, wheel(&s->motion, false, x, y, under + at); wheel_at_rest(&s->end, x, y, rest + at))
}

static SOIL_LANES void sideways_wheels(const struct closed_form *s, const struct closed_posts *posts, size_t stride, int32_t *under, int32_t *rest)
{
	EACH_LANES(posts, stride, wheel(&s->motion, true, x, y, under + at); wheel_at_rest(&s->end, x, y, rest + at))
}

static SOIL_LANES void spheres(const struct closed_form *s, const struct closed_posts *posts, size_t stride, int32_t *under, int32_t *rest)
{
	EACH_LANES(posts, stride, ball(&s->motion, false, x, y, under + at); ball(&s->end, false, x, y, rest + at))
}

static SOIL_LANES void ellipsoids(const struct closed_form *s, const struct closed_posts *posts, size_t stride, int32_t *under, int32_t *rest)
{
	EACH_LANES(posts, stride, ball(&s->motion, true, x, y, under + at); ball(&s->end, true, x, y, rest + at))
}

static SOIL_LANES void boxes(const struct closed_form *s, const struct closed_posts *posts, size_t stride, int32_t *under, int32_t *rest)
{
	EACH_LANES(posts, stride, box(&s->motion, x, y, under + at); box(&s->end, x, y, rest + at))
}

void soil_closed(const struct closed_form *shape, const struct closed_posts *posts, size_t stride, int32_t *under, int32_t *rest)
{
	switch (shape->form) {
	case SOIL_WHEEL:
		(shape->motion.c[1] != 0 ? sideways_wheels : wheels)(shape, posts, stride, under, rest);
		break;
	case SOIL_SPHERE:
		spheres(shape, posts, stride, under, rest);
		break;
	case SOIL_ELLIPSOID:
		ellipsoids(shape, posts, stride, under, rest);
		break;
	case SOIL_BOX:
		boxes(shape, posts, stride, under, rest);
		break;
	case SOIL_CYLINDER:
	case SOIL_CAPSULE:
		soil_closed_rod(shape, posts, stride, under, rest);
		break;
	case SOIL_MESH:
	case SOIL_SHAPES:
		break; /* it has no closed form */
	}
}
