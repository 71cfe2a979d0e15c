/* Which posts and which parts of their cells a body covers, how low it is there, and how low it was during its motion. */
#include "soil/law/cover.h"

#include "soil/law/face.h"

#define HALVINGS 14        /* of the share of a motion: to within 1e-4 of its length */
#define BESIDE 2e-6f       /* m: a post nearer to a side lies below it */

/* --- parts of cells --- */

/* What a post bears across a body with straight sides: from low to high, in posts from this post. */
struct part {
	float low, high;
	float begins, ends; /* 1: at that side the body ends */
};

/* here: the post's place across the strip; lower, upper: of the posts next to it; size: half the strip's width; m. A part goes half way to the next
 * post that the body covers too, or to the strip's side, but no farther than that post. */
SOIL_INLINED struct part part_of(float lower, float here, float upper, float size, float step)
{
	const float closest = 0.25f * step;
	const bool begins = !(fabsf(lower) <= size + BESIDE), ends = !(fabsf(upper) <= size + BESIDE);
	const float low = most((-size - here) / most(here - lower, closest), -1), high = least((size - here) / most(upper - here, closest), 1);
	return (struct part){either(begins, low, -0.5f), either(ends, high, 0.5f), either(begins, 1, 0), either(ends, 1, 0)};
}

/* Sets what a rim covers. A rim that is narrower than the spacing may pass between two posts: the nearer one bears it. A rim that has sunk nearly to
 * its axle reaches into the cells of posts in front of it. */
SOIL_CLONED static void cover_rim(const struct soil_form *restrict f, struct soil_posts *restrict p, size_t b)
{
	const float size = f->half[1], step = f->step_aside, by_step = f->by_step, r = f->radius, far = r * r * (1 + 1e-6f), back = r + f->run;
	const bool narrow = 2 * size < step;
	SOIL_APART
	for (int i = 0; i < POSTS_LANES; i++) {
		const float x = p->x[b + i], y = p->y[b + i], hole = either(p->base[b + i] == BASE_NODATA, 0, 1);
		const float here = aside_of(f, FORM_RIM, x, y), lower = aside_of(f, FORM_RIM, x - f->cut[1][0], y - f->cut[1][1]);
		const float upper = aside_of(f, FORM_RIM, x + f->cut[1][0], y + f->cut[1][1]);
		const struct part part = part_of(lower, here, upper, size, step);
		const bool inside = fabsf(here) <= size + BESIDE, is_over = (x * x <= far) & inside;
		const bool between = narrow & (fabsf(here - 1e-4f * step) <= 0.5f * step);
		const bool beside = (fabsf(x) < r + f->half_across) & (between | ((fabsf(x) > r) & inside));
		const bool alone = narrow & !is_over;
		const float low = either(alone, (-size - here) * by_step, part.low), high = either(alone, (size - here) * by_step, part.high);
		const float middle = 0.5f * (low + high), passed_low = -size - most(f->way[1], 0), passed_high = size - least(f->way[1], 0);
		p->over[b + i] = either(is_over, hole, 0);
		p->share[b + i] = either(is_over | beside, most(high - low, 0) * hole, 0);
		p->middle_x[b + i] = middle * f->cut[1][0];
		p->middle_y[b + i] = middle * f->cut[1][1];
		p->side_right[b + i] = part.begins;
		p->side_left[b + i] = part.ends;
		p->side_behind[b + i] = p->side_ahead[b + i] = 0;
		p->swept[b + i] = either((x <= r) & (x >= -back) & (here >= passed_low - BESIDE) & (here <= passed_high + BESIDE), hole, 0);
	}
}

/* Sets height, slope, lowered, print and room of a form whose circles tell how it moved. */
SOIL_INLINED void lower_round(const struct soil_form *restrict f, enum soil_form_kind kind, struct soil_posts *restrict p, size_t b)
{
	const float sinks = either(f->run > 0, 0, most(f->way[2], 0));
	SOIL_APART
	for (int i = 0; i < POSTS_LANES; i++) {
		const float x = p->x[b + i], y = p->y[b + i];
		struct face face = {.height = 0};
		float since;
		face_at(f, kind, 0, x, y, &face);
		p->height[b + i] = face.height;
		p->slope_x[b + i] = face.slope[0];
		p->slope_y[b + i] = face.slope[1];
		p->lowered[b + i] = lowered_at(f, kind, x, y, f->run, 0, &since) + sinks;
		p->print[b + i] = height_at(f, kind, 0, x + f->way[0], y + f->way[1]);
		p->own[b + i] = p->above[b + i] = 0;
	}
}

SOIL_CLONED static void lower_rim(const struct soil_form *restrict f, struct soil_posts *restrict p, size_t b)
{
	lower_round(f, FORM_RIM, p, b);
}

SOIL_CLONED static void lower_ball(const struct soil_form *restrict f, struct soil_posts *restrict p, size_t b)
{
	lower_round(f, FORM_BALL, p, b);
}

SOIL_CLONED static void cover_ball(const struct soil_form *restrict f, struct soil_posts *restrict p, size_t b)
{
	SOIL_APART
	for (int i = 0; i < POSTS_LANES; i++) {
		const float x = p->x[b + i], y = p->y[b + i], hole = either(p->base[b + i] == BASE_NODATA, 0, 1);
		/* The place in the motion where the post is nearest to the middle. */
		const float nearest = clamped(-(x * f->by_way[0] + y * f->by_way[1]), 0, 1), u = x + nearest * f->way[0], v = y + nearest * f->way[1];
		const float ahead = x + f->skew * y, then = u + f->skew * v;
		const float over = either(f->ahead_by * ahead * ahead + f->aside_by * y * y <= 1 + 1e-6f, hole, 0);
		p->over[b + i] = p->share[b + i] = over;
		p->swept[b + i] = either(f->ahead_by * then * then + f->aside_by * v * v <= 1 + 1e-6f, hole, 0);
		p->middle_x[b + i] = p->middle_y[b + i] = 0;
		p->side_behind[b + i] = p->side_ahead[b + i] = p->side_right[b + i] = p->side_left[b + i] = 0;
	}
}

/* --- other forms, post by post, in doubles --- */

/* Gives the lower envelope above a place, in the body's frame. *away is above 0 if the body was lower there shortly before. */
static bool placed(const struct soil_body *body, double x, double y, double *height, double *away)
{
	const double c = body->axis[0], s = body->axis[1], *way = body->way;
	struct lower_place place;
	if (!soil_lower_at(&body->lower, c * x - s * y, s * x + c * y, &place))
		return false;
	const double *n = place.normal;
	*height = place.z;
	*away = way[0] * (c * n[0] + s * n[1]) + way[1] * (c * n[1] - s * n[0]) + way[2] * n[2];
	return true;
}

/* The same at a share of the motion, back from its end. */
static bool placed_before(const struct soil_body *body, double x, double y, double share, double *height, double *away)
{
	const bool over = placed(body, x + share * body->way[0], y + share * body->way[1], height, away);
	*height -= share * body->way[2];
	return over;
}

/* Finds the lowest height of a convex body above a place during its motion. The height is a convex function of the time. A body that was above the
 * place only in the middle of its motion is not found: path samples are a post apart. */
static bool lowest_of(const struct soil_body *body, double x, double y, double *lowest)
{
	double height, away, from = 0, to = 1;
	*lowest = INFINITY;
	const bool now = placed_before(body, x, y, 0, &height, &away);
	*lowest = now ? height : *lowest;
	if (now && away <= 0)
		return true;
	const bool before = placed_before(body, x, y, 1, &height, &away);
	*lowest = before ? fmin(*lowest, height) : *lowest;
	if ((before && away >= 0) || (!now && !before))
		return before;
	for (int k = 0; k < HALVINGS; k++) {
		const double middle = 0.5 * (from + to);
		const bool over = placed_before(body, x, y, middle, &height, &away);
		*lowest = over ? fmin(*lowest, height) : *lowest;
		*((over ? away > 0 : !now) ? &from : &to) = middle;
	}
	return true;
}

/* Returns the part of a box' length or width that a post bears, and cuts the part's middle. */
static struct part part_along(float at, float size, float step)
{
	return part_of(at - step, at, at + step, size, step);
}

static void put_box_part(const struct soil_form *f, struct soil_posts *p, size_t i)
{
	if (!(f->half[0] > 0) || !(p->share[i] > 0))
		return;
	const struct part across = part_along(p->y[i], f->half[1], f->step_aside), along = part_along(p->x[i], f->half[0], f->step_aside);
	p->share[i] = most(across.high - across.low, 0) * most(along.high - along.low, 0);
	for (int k = 0; k < 2; k++) {
		float *middle = k == 0 ? &p->middle_x[i] : &p->middle_y[i];
		*middle = 0.5f * (across.low + across.high) * f->cut[1][k] + 0.5f * (along.low + along.high) * f->cut[0][k];
	}
	p->side_right[i] = across.begins;
	p->side_left[i] = across.ends;
	p->side_behind[i] = along.begins;
	p->side_ahead[i] = along.ends;
}

static void cover_post(const struct soil_body *body, const struct soil_form *f, struct soil_posts *p, size_t i)
{
	const float x = p->x[i], y = p->y[i];
	const bool hole = p->base[i] == BASE_NODATA;
	double height = 0, away, lowest = 0;
	struct face face = {.height = 0};
	const bool over = !hole && placed(body, (double)x, (double)y, &height, &away), swept = !hole && lowest_of(body, (double)x, (double)y, &lowest);
	p->own[i] = f->kind == FORM_END ? (2 * f->half_axis * f->level < 0.25f * f->spacing ? 1 : 2) : 0;
	face_at(f, f->kind, p->own[i], x, y, &face);
	p->over[i] = p->share[i] = over ? 1 : 0;
	p->swept[i] = swept ? 1 : 0;
	p->height[i] = over ? (float)height : face.height;
	p->slope_x[i] = face.slope[0];
	p->slope_y[i] = face.slope[1];
	p->lowered[i] = swept ? most((float)((double)p->height[i] - lowest), 0) : 0;
	p->above[i] = 0;
	p->print[i] = height_at(f, f->kind, p->own[i], x + f->way[0], y + f->way[1]);
	p->middle_x[i] = p->middle_y[i] = 0;
	p->side_behind[i] = p->side_ahead[i] = p->side_right[i] = p->side_left[i] = 0;
	if (f->kind == FORM_BOX)
		put_box_part(f, p, i);
}

/* --- when a cell can be touched --- */

/* Returns a height that the lower envelope is nowhere below, at places up to `reach` from a place. */
SOIL_INLINED float lowest_near(const struct soil_form *f, enum soil_form_kind kind, float x, float y, float reach)
{
	switch (kind) {
	case FORM_RIM:
		return (f->lean * y - fabsf(f->lean) * (reach + f->step_aside) - half_strip(f, most(fabsf(x) - reach, 0))) * f->lift;
	case FORM_BALL: {
		const float ahead = x + f->skew * y, near = most(sqrtf(f->ahead_by * ahead * ahead + f->aside_by * y * y) - reach * f->shrinks, 0);
		return f->tilt[0] * x + f->tilt[1] * y - sqrtf(f->tilt[0] * f->tilt[0] + f->tilt[1] * f->tilt[1]) * reach - f->drop * root(1 - near * near);
	}
	case FORM_BOX: {
		float lowest = -1e9f;
		for (int k = 0; k < 3; k++) {
			const float *face = f->faces[k];
			lowest = most(lowest, face[0] + face[1] * x + face[2] * y - reach * sqrtf(face[1] * face[1] + face[2] * face[2]));
		}
		return lowest;
	}
	case FORM_CAPSULE:
	case FORM_END:
	case FORM_RASTER:
		break;
	}
	return -f->reach;
}

SOIL_INLINED void room_of(const struct soil_form *restrict f, enum soil_form_kind kind, struct soil_posts *restrict p, size_t b)
{
	SOIL_APART
	for (int i = 0; i < POSTS_LANES; i++) {
		const float x = p->rise_x[b + i], y = p->rise_y[b + i], steep = sqrtf(x * x + y * y) * f->half_across;
		const float across = x * p->middle_x[b + i] + y * p->middle_y[b + i], ground = (float)p->ground[b + i] * SOIL_UNIT;
		const float lowest = lowest_near(f, kind, p->x[b + i] + p->middle_x[b + i], p->y[b + i] + p->middle_y[b + i], f->half_across);
		const float room = ground + most(across + steep - lowest, most(-p->height[b + i], -lowest)) - p->above[b + i] + 4 * SOIL_LEAST;
		p->room[b + i] = either(p->share[b + i] > 0, room, -1e9f);
	}
}

SOIL_CLONED static void put_room(const struct soil_form *restrict f, struct soil_posts *restrict p, size_t b)
{
	if (f->kind == FORM_RIM)
		room_of(f, FORM_RIM, p, b);
	else if (f->kind == FORM_BALL)
		room_of(f, FORM_BALL, p, b);
	else if (f->kind == FORM_BOX)
		room_of(f, FORM_BOX, p, b);
	else
		room_of(f, FORM_RASTER, p, b);
}

void soil_cover(const struct soil_body *body, const struct soil_form *form, struct soil_posts *posts)
{
	for (size_t b = 0; b < posts->count; b += POSTS_LANES) {
		if (form->kind == FORM_RIM) {
			cover_rim(form, posts, b);
			lower_rim(form, posts, b);
		} else if (form->kind == FORM_BALL) {
			cover_ball(form, posts, b);
			lower_ball(form, posts, b);
		}
		for (size_t i = b; i < b + POSTS_LANES && form->kind != FORM_RIM && form->kind != FORM_BALL; i++)
			cover_post(body, form, posts, i);
		put_room(form, posts, b);
	}
}
