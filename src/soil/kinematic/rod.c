/*
 * Lower envelopes of shapes that are round about an axis: a cylinder, a capsule, a wheel whose axle is not level. shaders/lib/envelope.glsl
 * tells what the numbers and the functionals of their struct body are. The envelope is the
 * lowest of the shape where it starts and where it ends, and of what it passes through. Two bodies bound that below: what its two ends pass
 * through, and the flat face that the lowest line of its side passes through.
 */
#include "soil/kinematic/closed.h"
#include "soil/kinematic/rows.h"

/* Places of LANES posts across and along the axis; heights of the axis and of a cylinder's lower end plane there. */
struct places {
	int32_t v[LANES], a[LANES], axis[LANES], end[LANES];
};

SOIL_INLINED void places_of(const struct body *body, int32_t x, int32_t y, struct places *p)
{
	lane_values(&body->f[0], x, y, p->v);
	lane_values(&body->f[1], x, y, p->a);
	lane_values(&body->f[2], x, y, p->axis);
	lane_values(&body->f[3], x, y, p->end);
}

/* The lower envelope of the shape at one time, above its centre at the start. `moved`: by how much v, a, axis and end, and the centre's height,
 * have changed since the start. Lowers `lowest` to it. */
SOIL_INLINED void at_rest(const struct body *body, bool capsule, const struct places *p, const int32_t moved[4], int32_t centre,
				 int32_t lowest[LANES])
{
	const int32_t r = body->a[0], half = body->a[1], sine = body->a[2], side_by = body->b[2];
	const int32_t ball_by = body->d[1], ball_up = body->d[3];
	const int side_shift = body->b[3], ball_shift = capsule ? body->d[2] : 1;
	EACH_LANE(i) {
		const int32_t v = p->v[i] - moved[0], a = p->a[i] - moved[1];
		const int32_t across = lane_clamp(v, -r, r);
		const int64_t squares = lane_product(r, r) - lane_product(across, across);
		const int32_t strip = lane_root(squares), middle = lane_scaled(strip, sine, 28);
		const int32_t side = lane_sum(lane_sum(p->axis[i], moved[2]), -lane_scaled(strip, side_by, side_shift));
		bool covered = v == across;
		int32_t there = side;
		if (capsule) {
			const bool low = a <= middle - half, high = a > middle + half;
			const int32_t beyond = low ? a + half : a - half, along = lane_clamp(beyond, -strip, strip);
			const int64_t below = squares - lane_product(along, along);
			const int32_t bottom = lane_root(below < 0 ? 0 : below);
			const int32_t ball = lane_sum(lane_sum(centre, low ? -ball_up : ball_up), -lane_scaled(bottom, ball_by, ball_shift));
			there = (low | high) ? ball : side;
			covered = covered & ((beyond == along) | !(low | high));
		} else {
			there = ((sine > 0) & (a <= middle - half)) ? lane_sum(p->end[i], moved[3]) : side;
			covered = covered & (lane_size(a) <= middle + half);
		}
		lowest[i] = (covered & (there < lowest[i])) ? there : lowest[i];
	}
}

/* Lowers `lowest` to the lower envelope of a capsule's end while it moves. Functionals f[0], f[1]: a post's place across and along the end's
 * motion. `above`: height of the end. */
SOIL_INLINED void ball_moves(const struct body *body, const struct functional *f, int32_t above, int32_t x, int32_t y, int32_t lowest[LANES])
{
	const int32_t r = body->a[0], length = body->a[3], sine = body->e[0], rise_by = body->e[1], ball_by = body->d[1];
	const int rise_shift = body->e[2], ball_shift = body->d[2];
	int32_t across[LANES], along[LANES];
	lane_values(&f[0], x, y, across);
	lane_values(&f[1], x, y, along);
	EACH_LANE(i) {
		const int32_t q = lane_clamp(across[i], -r, r), u = along[i];
		const int64_t squares = lane_product(r, r) - lane_product(q, q);
		const int32_t ring = lane_root(squares), low = lane_most(u - length, -ring), high = lane_least(u, ring);
		const int32_t from = lane_most(lane_least(lane_scaled(ring, sine, 28), high), low);
		const int64_t below = squares - lane_product(from, from);
		const int32_t bottom = lane_root(below < 0 ? 0 : below);
		const int32_t z = lane_sum(lane_sum(above, lane_scaled(u - from, rise_by, rise_shift)), -lane_scaled(bottom, ball_by, ball_shift));
		lowest[i] = ((across[i] == q) & (low <= high) & (z < lowest[i])) ? z : lowest[i];
	}
}

/* The same for a cylinder's end, whose rim passes over a post twice. f[2]: height of the rim's middle. */
SOIL_INLINED void rim_moves(const struct body *body, const struct functional *f, int32_t x, int32_t y, int32_t lowest[LANES])
{
	const int32_t r = body->a[0], sine = body->a[2], length = body->a[3], lift_by = body->d[1];
	const int lift_shift = body->d[2];
	int32_t across[LANES], along[LANES], middle[LANES];
	lane_values(&f[0], x, y, across);
	lane_values(&f[1], x, y, along);
	lane_values(&f[2], x, y, middle);
	EACH_LANE(i) {
		const int32_t q = lane_clamp(across[i], -r, r), ring = lane_root(lane_product(r, r) - lane_product(q, q));
		const int32_t apart = lane_scaled(ring, sine, 28), lift = lane_scaled(ring, lift_by, lift_shift);
		const int32_t first = lane_sum(along[i], -apart), second = lane_sum(along[i], apart);
		const int32_t low = lane_sum(middle[i], -lift), high = lane_sum(middle[i], lift);
		const bool covered = across[i] == q;
		const int32_t once = (covered & (first >= 0) & (first <= length) & (low < lowest[i])) ? low : lowest[i];
		lowest[i] = (covered & (second >= 0) & (second <= length) & (high < once)) ? high : once;
	}
}

SOIL_INLINED void face_moves(const struct body *body, int32_t x, int32_t y, int32_t lowest[LANES])
{
	int32_t height[LANES], one[LANES], other[LANES];
	lane_values(&body->f[7], x, y, height);
	lane_values(&body->f[8], x, y, one);
	lane_values(&body->f[9], x, y, other);
	EACH_LANE(i) {
		const int32_t far = lane_most(lane_size(one[i]), lane_size(other[i]));
		lowest[i] = ((far <= ENVELOPE_ONE) & (height[i] < lowest[i])) ? height[i] : lowest[i];
	}
}

SOIL_INLINED void rod(const struct body *body, bool capsule, int32_t x, int32_t y, int32_t *out)
{
	static const int32_t still[4];
	struct places p;
	int32_t lowest[LANES];
	EACH_LANE(i)
		lowest[i] = ENVELOPE_REACH;
	places_of(body, x, y, &p);
	at_rest(body, capsule, &p, still, 0, lowest);
	if (body->b[1] != 0 || body->c[0] != 0 || body->c[1] != 0)
		at_rest(body, capsule, &p, body->c, body->b[1], lowest);
	if (body->a[3] != 0 && capsule) {
		ball_moves(body, &body->f[4], -body->d[3], x, y, lowest);
		ball_moves(body, &body->f[10], body->d[3], x, y, lowest);
	} else if (body->a[3] != 0) {
		rim_moves(body, &body->f[4], x, y, lowest);
		rim_moves(body, &body->f[10], x, y, lowest);
	}
	if (body->d[0] != 0)
		face_moves(body, x, y, lowest);
	EACH_LANE(i)
		out[i] = lowest[i] != ENVELOPE_REACH ? lane_sum(body->b[0], lowest[i]) : UNDER_NONE;
}

static SOIL_LANES void cylinders(const struct closed_form *s, const struct closed_posts *posts, size_t stride, int32_t *under, int32_t *rest)
{
	for (int row = 0; row < posts->rows; row++)
		for (int first = 0; first < posts->count; first += LANES) {
			const size_t at = (size_t)row * stride + (size_t)first;
			rod(&s->motion, false, posts->x + first, posts->y + row, under + at);
			rod(&s->end, false, posts->x + first, posts->y + row, rest + at);
		}
}

static SOIL_LANES void capsules(const struct closed_form *s, const struct closed_posts *posts, size_t stride, int32_t *under, int32_t *rest)
{
	for (int row = 0; row < posts->rows; row++)
		for (int first = 0; first < posts->count; first += LANES) {
			const size_t at = (size_t)row * stride + (size_t)first;
			rod(&s->motion, true, posts->x + first, posts->y + row, under + at);
			rod(&s->end, true, posts->x + first, posts->y + row, rest + at);
		}
}

void soil_closed_rod(const struct closed_form *shape, const struct closed_posts *posts, size_t stride, int32_t *under, int32_t *rest)
{
	(shape->form == SOIL_CAPSULE ? capsules : cylinders)(shape, posts, stride, under, rest);
}
