/* Which part of a post's cell a body bears, where others are over it too. See meet.h. */
#include "soil/law/meet.h"

#include <math.h>

#include "soil/law/face.h"
#include "soil/law/parts.h"
#include "soil/shape/body.h"

#define PLACES 8              /* along a side of a part: where it is decided who bears it */
#define LEVEL (8 * SOIL_UNIT) /* m: heights that differ by less are equal: poses and heights are rounded */
#define GAP 0.02              /* of the smaller body: a gap that is less is none */
#define ABREAST 0.05          /* of the smaller body: lowest places that differ by less are equally high */

static double yaw_of(const struct soil_body *body)
{
	return atan2(body->axis[1], body->axis[0]);
}

static double height_of(const struct soil_met *met)
{
	return met->body->centre[2] + lattice_offset_metres(met->raised);
}

/* Gives half the size of a body along the axes of another body's frame, m. */
static void put_extent(const struct soil_body *frame, const struct soil_body *body, double extent[2])
{
	struct soil_pose pose = body->motion->to;
	pose.yaw -= yaw_of(frame);
	soil_body_extent(body->motion->shape, &pose, extent);
}

/* Gives the place of a body in the frame of another one, m. */
static void put_middle(const struct soil_body *frame, const struct soil_body *body, double middle[2])
{
	const double east = body->centre[0] - frame->centre[0], north = body->centre[1] - frame->centre[1];
	middle[0] = frame->axis[0] * east + frame->axis[1] * north;
	middle[1] = frame->axis[0] * north - frame->axis[1] * east;
}

static struct soil_seen seen_from(const struct soil_met *self, const struct soil_met *other)
{
	const struct soil_body *a = self->body, *b = other->body;
	struct soil_seen seen = {.form = other->form, .own = own_of(other->form, other->form->kind)};
	double middle[2], extent[2];
	put_middle(a, b, middle);
	put_extent(a, b, extent);
	seen.turn[0] = (float)(a->axis[0] * b->axis[0] + a->axis[1] * b->axis[1]);
	seen.turn[1] = (float)(a->axis[1] * b->axis[0] - a->axis[0] * b->axis[1]);
	for (int k = 0; k < 2; k++) {
		seen.middle[k] = (float)middle[k];
		seen.reach[k] = (float)extent[k];
	}
	seen.at[0] = -(seen.turn[0] * seen.middle[0] - seen.turn[1] * seen.middle[1]);
	seen.at[1] = -(seen.turn[1] * seen.middle[0] + seen.turn[0] * seen.middle[1]);
	seen.above = (float)(height_of(other) - height_of(self));
	seen.lowest = seen.above - (other->form->kind == FORM_RASTER ? (float)soil_shape_bound(b->motion->shape) : other->form->reach);
	return seen;
}

/* Tells whether a form of any kind is above a place. */
static bool covers(const struct soil_form *f, float x, float y)
{
	switch (f->kind) {
	case FORM_RIM:
		return fabsf(x) <= f->radius && fabsf(aside_of(f, FORM_RIM, x, y)) <= f->half[1] + BESIDE;
	case FORM_BALL: {
		const float ahead = x + f->skew * y;
		return f->ahead_by * ahead * ahead + f->aside_by * y * y <= 1;
	}
	case FORM_RASTER: {
		const struct soil_fine *fine = &f->fine;
		const float east = (fine->axis[0] * x - fine->axis[1] * y - fine->x) * fine->by_step, north = (fine->axis[1] * x + fine->axis[0] * y - fine->y) * fine->by_step;
		const int32_t column = (int32_t)floorf(east + 0.5f), row = (int32_t)floorf(north + 0.5f);
		return column >= 0 && row >= 0 && column < fine->columns && row < fine->rows && fine->drawn[row * fine->stride + column] < 0.5f * FINE_NONE;
	}
	case FORM_CAPSULE:
		return is_above(f, FORM_CAPSULE, x, y);
	case FORM_END:
		return is_above(f, FORM_END, x, y);
	case FORM_BOX:
	case FORM_WALL:
		break;
	}
	return is_above(f, FORM_BOX, x, y);
}

static float height_in(const struct soil_form *f, float own, float x, float y)
{
	struct face face = {.height = 0};
	face_at(f, f->kind, own, x, y, &face);
	return face.height;
}

/* The part of a post's cell that a body bears: a middle, and two half sides. */
struct cell {
	float middle[2], side[2][2];
};

static struct cell cell_of(const struct soil_form *f, const struct soil_posts *p, size_t i)
{
	const float x = p->x[i], y = p->y[i], step = f->step_aside;
	float sizes[2] = {1, 1};
	struct cell cell = {.middle = {x + p->middle_x[i], y + p->middle_y[i]}};
	if (f->kind == FORM_BOX && f->half[0] > 0) {
		const struct part along = part_of(x - step, x, x + step, f->half[0], step), across = part_of(y - step, y, y + step, f->half[1], step);
		sizes[0] = most(along.high - along.low, 0);
		sizes[1] = most(across.high - across.low, 0);
	} else if (f->kind == FORM_RIM) {
		sizes[1] = p->share[i];
	} else if (f->kind == FORM_RASTER) {
		sizes[0] = sizes[1] = sqrtf(p->share[i]);
	}
	for (int k = 0; k < 2; k++) {
		cell.side[0][k] = 0.5f * sizes[0] * f->cut[0][k];
		cell.side[1][k] = 0.5f * sizes[1] * f->cut[1][k];
	}
	if (f->kind == FORM_RIM) {
		cell.side[0][0] = f->half_across;
		cell.side[0][1] = 0;
	}
	return cell;
}

/* Returns how high a body is at a place of the frame, m above the frame's centre. FINE_NONE: it is not above it. */
static float height_over(const struct soil_seen *s, float x, float y)
{
	const float u = s->turn[0] * x - s->turn[1] * y + s->at[0], v = s->turn[1] * x + s->turn[0] * y + s->at[1];
	return covers(s->form, u, v) ? height_in(s->form, s->own, u, v) + s->above : FINE_NONE;
}

/* Returns which share of a place a body bears that is `height` m above its own centre there. */
static float share_at(const struct soil_seen *others, size_t count, float x, float y, float height)
{
	float lowest = height, all = 0;
	for (size_t k = 0; k < count; k++)
		lowest = least(lowest, height_over(&others[k], x, y));
	const float own = clamped(1 - (height - lowest) / LEVEL, 0, 1);
	if (own == 0)
		return 0;
	for (size_t k = 0; k < count; k++)
		all += clamped(1 - (height_over(&others[k], x, y) - lowest) / LEVEL, 0, 1);
	return own / (own + all);
}

/* Leaves what the body bears of a part with so many places along a side. Returns its share of the part. */
static float part_left(const struct soil_form *f, const struct soil_seen *others, size_t count, const struct cell *cell, float own, int places, float middle[2])
{
	float sum = 0, moments[2] = {0, 0}, count_own = 0;
	const float from = places == 3 ? 1 : 1 - 1 / (float)places, step = 2 * from / (float)(places - 1); /* three: to the very edges */
	for (int j = 0; j < places; j++)
		for (int i = 0; i < places; i++) {
			const float s = (float)i * step - from, t = (float)j * step - from;
			const float x = cell->middle[0] + s * cell->side[0][0] + t * cell->side[1][0], y = cell->middle[1] + s * cell->side[0][1] + t * cell->side[1][1];
			if (!covers(f, x, y)) /* a post at the edge bears a whole cell */
				continue;
			count_own++;
			const float share = share_at(others, count, x, y, height_in(f, own, x, y));
			sum += share;
			moments[0] += share * (x - cell->middle[0]);
			moments[1] += share * (y - cell->middle[1]);
		}
	for (int k = 0; k < 2; k++)
		middle[k] = moments[k] / most(sum, 1e-9f);
	return count_own > 0 ? sum / count_own : 1;
}

/* Tells whether another body may bear a part of a post's cell. */
static bool is_near(const struct soil_seen *s, const struct soil_posts *p, size_t i, float far)
{
	return fabsf(p->x[i] - s->middle[0]) <= s->reach[0] + far && fabsf(p->y[i] - s->middle[1]) <= s->reach[1] + far &&
	       s->lowest < (float)p->ground[i] * SOIL_UNIT + far;
}

void soil_meet_see(const struct soil_met *self, const struct soil_met *others, size_t count, struct soil_seen *seen)
{
	for (size_t k = 0; k < count; k++)
		seen[k] = seen_from(self, &others[k]);
}

bool soil_meet_share(const struct soil_form *f, const struct soil_seen *seen, size_t count, struct soil_posts *p)
{
	const float own = own_of(f, f->kind), far = 1.5f * f->spacing;
	bool took = false;
	for (size_t i = 0; i < p->count && count > 0; i++) {
		bool near = false;
		for (size_t k = 0; k < count && p->share[i] > 0 && !near; k++)
			near = is_near(&seen[k], p, i, far);
		if (!near)
			continue;
		const struct cell cell = cell_of(f, p, i);
		float middle[2], left = part_left(f, seen, count, &cell, own, 3, middle);
		if (left >= 1)
			continue;
		if (left > 0)
			left = part_left(f, seen, count, &cell, own, PLACES, middle);
		took = true;
		p->share[i] *= left;
		p->middle_x[i] += middle[0];
		p->middle_y[i] += middle[1];
	}
	return took;
}

/* --- bodies that abut --- */

/* A rectangle in the frame, along its axes. */
struct span {
	double low[2], high[2];
};

static double overlap(const struct span *a, const struct span *b, int axis)
{
	return fmin(a->high[axis], b->high[axis]) - fmax(a->low[axis], b->low[axis]);
}

/* Tells whether a body abuts the whole along one axis: beside its own body, with no gap. */
static bool is_beside(const struct span *own, const struct span *other, const struct span *all, int axis)
{
	const int beside = 1 - axis;
	const double least_beside = fmin(own->high[beside] - own->low[beside], other->high[beside] - other->low[beside]);
	const double gap = GAP * fmin(own->high[axis] - own->low[axis], other->high[axis] - other->low[axis]);
	return overlap(own, other, beside) >= 0.5 * least_beside && overlap(all, other, axis) >= -gap;
}

static double lowest_of(const struct soil_met *met)
{
	const struct soil_motion *motion = met->body->motion;
	return height_of(met) - soil_shape_reach(motion->shape, motion->to.pitch, motion->to.roll);
}

/* Gives a body's rectangle. Returns false if it is not about as low as `self`. */
static bool span_of(const struct soil_met *self, const struct soil_met *other, double own, struct span *span)
{
	double middle[2], size[2];
	put_middle(self->body, other->body, middle);
	put_extent(self->body, other->body, size);
	*span = (struct span){{middle[0] - size[0], middle[1] - size[1]}, {middle[0] + size[0], middle[1] + size[1]}};
	return fabs(lowest_of(other) - lowest_of(self)) <= ABREAST * 2 * fmin(fmin(size[0], size[1]), own);
}

void soil_meet_whole(const struct soil_met *self, const struct soil_met *others, size_t count, bool across, const double own[2], bool *abuts,
		     struct soil_whole *whole)
{
	double extent[2];
	put_extent(self->body, self->body, extent);
	const struct span mine = {{-extent[0], -extent[1]}, {extent[0], extent[1]}};
	struct span all = mine, other;
	bool grows = true;
	for (size_t i = 0; i < count; i++)
		abuts[i] = false;
	for (size_t pass = 0; pass < count && grows; pass++) {
		grows = false;
		for (size_t i = 0; i < count; i++) {
			if (abuts[i] || !span_of(self, &others[i], fmin(extent[0], extent[1]), &other))
				continue;
			/* What lies at a corner abuts both neighbours. */
			for (int axis = 0; axis < 2; axis++) {
				if (!is_beside(&mine, &other, &all, axis) || (across && axis == 0 && overlap(&mine, &other, 0) <= 0))
					continue;
				abuts[i] = grows = true;
				all.low[axis] = fmin(all.low[axis], other.low[axis]);
				all.high[axis] = fmax(all.high[axis], other.high[axis]);
			}
		}
	}
	const double wide = (all.high[1] - all.low[1]) / (2 * extent[1]), along = (all.high[0] - all.low[0]) / (2 * extent[0]);
	*whole = (struct soil_whole){.wider = sqrt(along * wide)};
	for (int axis = 0; axis < 2; axis++) {
		whole->more[axis][0] = -extent[axis] - all.low[axis];
		whole->more[axis][1] = all.high[axis] - extent[axis];
	}
	if (across)
		whole->wider = wide;
	else if (own[0] > 0)
		whole->wider = fmin(own[0] * along, own[1] * wide) / fmin(own[0], own[1]);
}
