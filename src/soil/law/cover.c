/* Which posts and which parts of their cells a body covers, how low it is there, and how low it was during its motion. */
#include "soil/law/cover.h"

#include "soil/law/cover_box.h"
#include "soil/law/cover_fine.h"
#include "soil/law/face.h"
#include "soil/law/grousers.h"
#include "soil/law/parts.h"

#define HALVINGS 14        /* of the share of a motion: to within 1e-4 of its length */

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
		const bool beside = (fabsf(x) < f->outer + f->half_across) & (between | ((fabsf(x) > r) & inside));
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
	SOIL_APART
	for (int i = 0; i < POSTS_LANES; i++) {
		const float x = p->x[b + i], y = p->y[b + i];
		struct face face = {.height = 0};
		float since;
		face_at(f, kind, 0, x, y, &face);
		p->height[b + i] = face.height;
		p->slope_x[b + i] = face.slope[0];
		p->slope_y[b + i] = face.slope[1];
		p->lowered[b + i] = lowered_at(f, kind, x, y, f->run, 0, rim_bottom(f, 0), 0, &since);
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

/* --- other forms --- */

/* A pose of a body during its motion, above a place. */
struct passing {
	float height, rises; /* m; rises: of the height with the share of the motion, back from its end */
	bool above;
};

SOIL_INLINED struct passing passing_at(const struct soil_form *f, enum soil_form_kind kind, float own, float x, float y, float share)
{
	const float u = x + share * f->way[0], v = y + share * f->way[1];
	struct face face = {.height = 0};
	face_at(f, kind, own, u, v, &face);
	return (struct passing){face.height - share * f->way[2], face.slope[0] * f->way[0] + face.slope[1] * f->way[1] - f->way[2], is_above(f, kind, u, v)};
}

/* Finds the lowest heights of a convex body above posts during its motion: a convex function of the time. A body that was above a post only in the
 * middle of its motion is not found: path samples are a post apart. */
SOIL_INLINED void put_lowest(const struct soil_form *restrict f, enum soil_form_kind kind, struct soil_posts *restrict p, size_t b)
{
	float from[POSTS_LANES], to[POSTS_LANES], low[POSTS_LANES], above[POSTS_LANES], seeks[POSTS_LANES];
	uint32_t any = 0;
	SOIL_APART
	for (int i = 0; i < POSTS_LANES; i++) {
		const struct passing now = passing_at(f, kind, p->own[b + i], p->x[b + i], p->y[b + i], 0);
		const struct passing then = passing_at(f, kind, p->own[b + i], p->x[b + i], p->y[b + i], 1);
		const bool stays = now.above & (now.rises >= 0), came = then.above & (then.rises <= 0);
		above[i] = either(now.above, 1, 0);
		from[i] = 0;
		to[i] = 1;
		low[i] = least(either(now.above, now.height, FINE_NONE), either(then.above & !stays, then.height, FINE_NONE));
		seeks[i] = either(stays | came | !(now.above | then.above), 0, 1);
	}
	SOIL_WHOLE
	for (int i = 0; i < POSTS_LANES; i++)
		any |= seeks[i] > 0 ? 1 : 0;
	for (int k = 0; k < HALVINGS && any != 0; k++)
		for (int i = 0; i < POSTS_LANES; i++) {
			const float middle = 0.5f * (from[i] + to[i]);
			const struct passing is = passing_at(f, kind, p->own[b + i], p->x[b + i], p->y[b + i], middle);
			const float earlier = either(is.above, either(is.rises < 0, 1, 0), 1 - above[i]);
			low[i] = either(is.above & (seeks[i] > 0), least(low[i], is.height), low[i]);
			from[i] = either(earlier > 0, middle, from[i]);
			to[i] = either(earlier > 0, to[i], middle);
		}
	SOIL_APART
	for (int i = 0; i < POSTS_LANES; i++) {
		const bool was = (low[i] < 0.5f * FINE_NONE) & (p->base[b + i] != BASE_NODATA);
		p->swept[b + i] = either(was, 1, 0);
		p->lowered[b + i] = either(was, most(p->height[b + i] - low[i], 0), 0);
	}
}

SOIL_INLINED void cover_lanes(const struct soil_form *restrict f, enum soil_form_kind kind, struct soil_posts *restrict p, size_t b)
{
	const float own = own_of(f, kind);
	SOIL_APART
	for (int i = 0; i < POSTS_LANES; i++) {
		const float x = p->x[b + i], y = p->y[b + i], over = either(is_above(f, kind, x, y) & (p->base[b + i] != BASE_NODATA), 1, 0);
		struct face face = {.height = 0};
		face_at(f, kind, own, x, y, &face);
		p->own[b + i] = own;
		p->over[b + i] = p->share[b + i] = p->swept[b + i] = over;
		p->height[b + i] = face.height;
		p->slope_x[b + i] = face.slope[0];
		p->slope_y[b + i] = face.slope[1];
		p->print[b + i] = height_at(f, kind, own, x + f->way[0], y + f->way[1]);
		p->above[b + i] = p->lowered[b + i] = p->middle_x[b + i] = p->middle_y[b + i] = 0;
		p->side_behind[b + i] = p->side_ahead[b + i] = p->side_right[b + i] = p->side_left[b + i] = 0;
	}
	if (f->way[0] != 0 || f->way[1] != 0 || f->way[2] != 0)
		put_lowest(f, kind, p, b);
}

/* Sets the parts that posts bear of a box' length and width. */
SOIL_INLINED void put_box_parts(const struct soil_form *restrict f, struct soil_posts *restrict p, size_t b)
{
	SOIL_APART
	for (int i = 0; i < POSTS_LANES; i++) {
		const float x = p->x[b + i], y = p->y[b + i], over = p->over[b + i], along_step = f->step_aside;
		const struct part across = part_of(y - along_step, y, y + along_step, f->half[1], along_step);
		const struct part along = part_of(x - along_step, x, x + along_step, f->half[0], along_step);
		const float side = 0.5f * (across.low + across.high) * over, ahead = 0.5f * (along.low + along.high) * over;
		p->share[b + i] = most(across.high - across.low, 0) * most(along.high - along.low, 0) * over;
		p->middle_x[b + i] = side * f->cut[1][0] + ahead * f->cut[0][0];
		p->middle_y[b + i] = side * f->cut[1][1] + ahead * f->cut[0][1];
		p->side_right[b + i] = across.begins * over;
		p->side_left[b + i] = across.ends * over;
		p->side_behind[b + i] = along.begins * over;
		p->side_ahead[b + i] = along.ends * over;
	}
}

SOIL_CLONED static void cover_box(const struct soil_form *restrict f, struct soil_posts *restrict p, size_t b)
{
	cover_lanes(f, FORM_BOX, p, b);
	if (f->half[0] > 0)
		put_box_parts(f, p, b);
	for (int i = 0; i < POSTS_LANES; i++) {
		p->half_line[b + i] = f->half_across;
		p->edge_long[b + i] = p->edge_x[b + i] = p->edge_y[b + i] = 0;
		p->other_long[b + i] = p->other_x[b + i] = p->other_y[b + i] = 0;
	}
}

SOIL_CLONED static void cover_capsule(const struct soil_form *restrict f, struct soil_posts *restrict p, size_t b)
{
	cover_lanes(f, FORM_CAPSULE, p, b);
}

SOIL_CLONED static void cover_end(const struct soil_form *restrict f, struct soil_posts *restrict p, size_t b)
{
	cover_lanes(f, FORM_END, p, b);
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
	case FORM_WALL:
		break;
	}
	return -f->reach;
}

/* Returns how far the undisturbed surface of what lies below a loose layer can be above the post's own, m: walls find that (below_loose). */
SOIL_INLINED float firm_above(const struct soil_form *f, const struct soil_posts *p, size_t i)
{
	const bool walls = f->kind == FORM_RASTER || (f->kind == FORM_RIM && f->lean != 0);
	return walls && p->loose[i] > 0 ? most((float)p->floor[i] * p->by_up[i] - (float)p->loose[i], 0) * SOIL_UNIT : 0;
}

SOIL_INLINED void room_of(const struct soil_form *restrict f, enum soil_form_kind kind, struct soil_posts *restrict p, size_t b)
{
	SOIL_APART
	for (int i = 0; i < POSTS_LANES; i++) {
		const float x = p->rise_x[b + i], y = p->rise_y[b + i], steep = sqrtf(x * x + y * y) * f->half_across;
		const float across = x * p->middle_x[b + i] + y * p->middle_y[b + i], ground = (float)p->ground[b + i] * SOIL_UNIT + firm_above(f, p, b + (size_t)i);
		const bool edge = kind == FORM_BOX && p->edge_long[b + i] + p->other_long[b + i] > 0; /* it may lie outside the cell */
		const float near = lowest_near(f, kind, p->x[b + i] + p->middle_x[b + i], p->y[b + i] + p->middle_y[b + i], kind == FORM_BOX ? most(f->half_across, p->half_line[b + i]) : f->half_across);
		const float lowest = either(edge, -f->reach, near);
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

/* The same as put_room for a raster. */
static void put_raster_room(const struct soil_form *f, struct soil_posts *p)
{
	for (size_t i = 0; i < p->count; i++) {
		const float steep = sqrtf(p->rise_x[i] * p->rise_x[i] + p->rise_y[i] * p->rise_y[i]) * f->half_across;
		const float across = p->rise_x[i] * p->middle_x[i] + p->rise_y[i] * p->middle_y[i], ground = (float)p->ground[i] * SOIL_UNIT + firm_above(f, p, i);
		if (p->share[i] > 0)
			p->room[i] = ground + most(across + steep, 0) - least(soil_cover_fine_low(f, p->x[i], p->y[i]), p->height[i]) + 4 * SOIL_LEAST;
	}
}

/* Covers all posts with a form. */
static void cover_all(const struct soil_form *form, struct soil_posts *posts)
{
	static void (*const covers[])(const struct soil_form *restrict, struct soil_posts *restrict, size_t) = {
		[FORM_RIM] = cover_rim, [FORM_BALL] = cover_ball, [FORM_CAPSULE] = cover_capsule, [FORM_BOX] = cover_box, [FORM_END] = cover_end,
	};
	for (size_t b = 0; b < posts->count; b += POSTS_LANES) {
		covers[form->kind](form, posts, b);
		if (form->kind == FORM_RIM)
			lower_rim(form, posts, b);
		else if (form->kind == FORM_BALL)
			lower_ball(form, posts, b);
	}
}

void soil_cover(const struct soil_body *body, const struct soil_form *form, struct soil_posts *posts)
{
	if (form->kind == FORM_RASTER)
		soil_cover_fine(form, posts);
	else
		cover_all(form, posts);
	if (form->kind == FORM_BOX && form->tilts > 0)
		soil_cover_box(body, form, posts);
	for (size_t i = 0; i < soil_posts_end(posts); i++)
		posts->bars[i] = FINE_NONE;
	if (form->grousers.rests != NULL)
		soil_grousers_cover(body, form, posts);
	for (size_t b = 0; b < posts->count; b += POSTS_LANES)
		put_room(form, posts, b);
	if (form->kind == FORM_RASTER)
		put_raster_room(form, posts);
}
