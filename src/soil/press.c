/*
 * Presses a body into the ground: its equilibrium height, the forces on it, and the new state of the posts that it touches. See SOIL.md.
 *
 * The new state is whole numbers. So a post that a body has left, or presses anew by the same pose, keeps its bits.
 */
#include "soil/press.h"

#include <stdlib.h>

#include "soil/law/bear.h"
#include "soil/shape/body.h"

#define CARRIED_MOST (1 << 23)    /* fixed-point units: the most that one post gives away */
#define OFFSET_MOST (1 << 30)         /* fixed-point units: 1024 m */

struct soil_work {
	struct soil_posts posts;
	struct soil_kept kept;
	size_t kept_room;
};

enum status soil_work_create(struct soil_work **out)
{
	*out = mem_calloc(1, sizeof **out);
	return *out != NULL ? STATUS_OK : fail_memory("bearing soil");
}

void soil_work_destroy(struct soil_work *work)
{
	if (work == NULL)
		return;
	soil_posts_finish(&work->posts);
	mem_free(work->kept.more);
	mem_free(work);
}

static enum status need(struct soil_work *work, struct post_rect below)
{
	const size_t count = (size_t)(below.x1 - below.x0) * (size_t)(below.y1 - below.y0);
	enum status status = soil_posts_need(&work->posts, count);
	if (status != STATUS_OK || work->kept_room >= work->posts.capacity)
		return status;
	const size_t room = work->posts.capacity;
	float *memory = mem_realloc(work->kept.more, 3 * room, sizeof *memory);
	if (memory == NULL)
		return fail_memory("bearing soil");
	work->kept = (struct soil_kept){memory, memory + room, memory + 2 * room};
	work->kept_room = room;
	return STATUS_OK;
}

/* --- the width of the contact patch --- */

/* Returns 1 / b, b the width of the contact patch, 1/m. 0: it follows from the number of posts that the body touches. */
static double width_of(const struct soil_motion *motion, const struct soil_body *body)
{
	const struct soil_shape *shape = motion->shape;
	if (shape->kind == SOIL_WHEEL || shape->kind == SOIL_CYLINDER) { /* between a level wheel and a round plate */
		const double squares = body->lower.axis[2] * body->lower.axis[2];
		return (1 - squares) / (shape->kind == SOIL_WHEEL ? shape->width : shape->length) + squares / shape->radius;
	}
	return shape->kind == SOIL_BOX ? 1 / fmin(shape->size[0], shape->size[1]) : 0;
}

/* Returns 1 / b for the posts that the body touches at a height. b is the radius of a round plate of their area. */
static float counted_width(const struct soil_posts *posts, const struct soil_form *form, int32_t raised)
{
	int32_t count = 0;
	for (size_t i = 0; i < posts->count; i++)
		count += (posts->over[i] > 0) & ((float)(posts->ground[i] - raised) * SOIL_UNIT - form->beyond > posts->height[i] + posts->above[i]);
	const float area = (float)(count > 1 ? count : 1) * form->spacing * form->spacing;
	return 1 / sqrtf(area * 0.31830989f);
}

/* --- the equilibrium height --- */

/* A bracket begins with at most 2^28 units. At most 5 times it is parted by a geometric mean, and 28 times by the arithmetic one. Before each of
 * these come at most 3 tries that part it worse. So the search always ends, as a rule after a few tries. */
#define TRIES (4 * (5 + 28))
#define NOWHERE INT32_MIN

/* Heights are fixed-point units above motion->to.z. */
struct search {
	int32_t raised;
	float share;             /* of the load that the soil carries there; not quite 1, since heights are whole units */
	enum soil_state state;
	struct soil_sums sums;
	float by_width;
	int tries;
};

/* Returns the highest height at which the body touches the ground; NOWHERE: there is none below it. */
static int32_t first_contact(const struct soil_posts *posts)
{
	float highest = -1e9f;
	for (size_t i = 0; i < posts->count; i++)
		highest = most(highest, posts->share[i] > 0 ? posts->room[i] : -1e9f);
	return highest > -1e8f ? (int32_t)ceilf(highest * 1048576.0f) + 1 : NOWHERE;
}

/* Newton's method in the logarithms of force and depth: force is about a power of depth. */
static int32_t stepped(int32_t top, int32_t at, double share, double grows, int32_t depth)
{
	const double z = top - at, power = fmin(fmax(z * grows / fmax(share, 1e-6), 0.1), 1e6);
	const double step = z * exp2(fmin(fmax(-log2(fmax(share, 1e-6)) / power, -20), 20));
	return top - (int32_t)lround(fmin(step, depth));
}

/* Takes force as a power of depth through two tries. Returns the height at which it is the load. */
static int32_t between(int32_t top, int32_t first, int32_t second, double at_first, double at_second)
{
	const double near = top - first > 1 ? top - first : 1, far = top - second > 1 ? top - second : 1, rise = log2(at_second / at_first);
	const double part = fabs(rise) > 1e-9 ? -log2(at_first) / rise : 0.5;
	return top - (int32_t)lround(fmin(near * exp2(log2(far / near) * fmin(fmax(part, -20), 20)), 1e9));
}

/* Returns a height between two depths below the first contact: at the geometric mean if the depths differ much, else at the mean. */
static int32_t middle(int32_t shallow, int32_t deep, int32_t top)
{
	const double least_depth = shallow > 8 ? shallow : 8;
	return top - (deep > 8 * least_depth ? (int32_t)sqrt(least_depth * (double)deep) : shallow + (deep - shallow) / 2);
}

struct pressed_body {
	const struct soil_law *law;
	const struct soil_planes *planes;
	const struct soil_motion *motion;
	struct soil_body body;
	struct soil_form form;
	struct soil_posts *posts;
	double by_width;   /* 0: counted */
	int32_t gathered;  /* the least height for which the posts were gathered */
};

/* Gathers the posts for heights from `least` on, if that is not done. */
static void gather(struct pressed_body *b, int32_t lowest)
{
	if (lowest >= b->gathered)
		return;
	b->gathered = lowest;
	soil_posts_gather(b->law, b->planes, &b->body, &b->form, lowest, b->posts);
}

static float put_width(struct pressed_body *b, int32_t raised)
{
	const float by_width = b->by_width > 0 ? (float)b->by_width : counted_width(b->posts, &b->form, raised);
	soil_posts_width(by_width, b->posts);
	return by_width;
}

static int32_t clamp_to(int64_t value, int64_t low, int64_t high)
{
	return (int32_t)(value < low ? low : value > high ? high : value);
}

static void find_height(struct pressed_body *b, int32_t start, struct search *s)
{
	const double load = b->motion->load, unit = (double)b->form.spacing * (double)b->form.spacing / (double)BEAR_UNITS_A_PASCAL / load;
	const double reach = soil_shape_reach(b->motion->shape, b->motion->to.pitch, b->motion->to.roll);
	const double deepest = 2 * (b->motion->shape->kind == SOIL_MESH ? soil_shape_bound(b->motion->shape) : reach);
	const int32_t depth = (int32_t)fmin(ldexp(deepest, OFFSET_BITS), 0x1p28);
	gather(b, start - (int32_t)fmin(ldexp(0.2 * reach, OFFSET_BITS), 0x1p27));
	int32_t top = first_contact(b->posts);
	if (top == NOWHERE) {
		gather(b, -(1 << 30));
		top = first_contact(b->posts);
	}
	*s = (struct search){.share = 1, .state = top == NOWHERE ? SOIL_AIR : SOIL_SUNK};
	if (top == NOWHERE)
		return;
	int32_t low = top - depth, high = top, before = 0;
	double at_low = 1e30, at_high = 0, at_before = 0, carried = 1;
	int64_t last = 2 * (int64_t)depth;
	int stalls = 0;
	bool done = false;
	s->raised = clamp_to(start, low + 1, high - 1);
	for (s->tries = 0; s->tries < TRIES && !done; s->tries++) {
		gather(b, s->raised);
		s->by_width = put_width(b, s->raised);
		soil_bear(&b->form, b->posts, s->raised, 1, &s->sums, NULL, NULL);
		const double share = (double)s->sums.force[2] * unit, grows_here = s->sums.grows * unit * (double)SOIL_UNIT;
		const bool bears = share >= 1;
		s->state = bears ? SOIL_TOUCHING : s->state;
		carried = bears ? share : carried;
		low = bears ? s->raised : low;
		high = bears ? high : s->raised;
		at_low = bears ? share : at_low;
		at_high = bears ? at_high : share;
		const int64_t width = (int64_t)high - low;
		const bool both = at_low < 1e30 && at_high > 1e-6;
		/* The height is found if the next step is shorter than half a unit, or if the bracket is one unit wide. */
		const double gap = abs(s->raised - before) > 1 ? abs(s->raised - before) : 1, chord = s->tries > 0 ? fabs((share - at_before) / gap) : grows_here;
		const bool there = fabs(share - 1) <= 0.5 * fmin(grows_here, chord);
		s->state = there ? SOIL_TOUCHING : s->state;
		carried = there ? share : carried;
		done = there || width <= 1;
		/* The first step is one of Newton's method, and so are those that stay in the bracket. */
		const bool known = s->tries > 0 && fmin(share, at_before) > 1e-6 && s->raised != before;
		int32_t next = known ? between(top, before, s->raised, at_before, share) : stepped(top, s->raised, share, grows_here, depth);
		const bool out_of = next <= low || next >= high;
		next = out_of && both ? between(top, high, low, at_high, at_low) : next;
		/* If three steps in a row do not halve the bracket, the next try is in its middle. */
		stalls = 2 * width > last ? stalls + 1 : 0;
		const bool lags = stalls >= 3 || share <= 1e-6 || (out_of && !both && at_low < 1e30);
		stalls = lags ? 0 : stalls;
		last = width;
		before = s->raised;
		at_before = share;
		next = clamp_to(lags ? middle(top - high, top - low, top) : next, low + 1, high - 1 > low + 1 ? high - 1 : low + 1);
		s->raised = there ? s->raised : done ? low : next;
	}
	s->raised = done ? s->raised : low;
	s->share = (float)carried;
}

/* --- the new state of posts --- */

/* What a block of posts becomes. */
struct after {
	int32_t offset[POSTS_LANES], deposited[POSTS_LANES], sinkage[POSTS_LANES], shear[POSTS_LANES], dug[POSTS_LANES], carried[POSTS_LANES], lost[POSTS_LANES];
	uint8_t touched[POSTS_LANES], held[POSTS_LANES], refused[POSTS_LANES], ends[POSTS_LANES];
};

SOIL_INLINED int32_t whole_units(float metres)
{
	return whole_of(clamped(metres * 1048576.0f, -2e9f, 2e9f));
}

/* Tells whether a body whose lower envelope has this sinkage is in contact. largest: the largest sinkage so far; plastic: its plastic part, m. */
SOIL_INLINED bool in_contact(int32_t sunk, int32_t largest, float plastic)
{
	return (sunk > 0) & ((sunk >= largest) | ((float)sunk * SOIL_UNIT > plastic));
}

SOIL_INLINED int32_t sinkage_of(float up, int32_t depth)
{
	return whole_of(clamped(up * (float)depth, 0, 1.9e9f));
}

SOIL_INLINED int32_t larger(int32_t a, int32_t b)
{
	return a > b ? a : b;
}

SOIL_INLINED int32_t smaller(int32_t a, int32_t b)
{
	return a < b ? a : b;
}

/* Mobilised shear of the frame as a post stores it. */
SOIL_INLINED int32_t shear_of(const float axis[2], float x, float y)
{
	const int32_t east = whole_of(clamped((axis[0] * x - axis[1] * y) * 32768, -32767, 32767));
	const int32_t north = whole_of(clamped((axis[1] * x + axis[0] * y) * 32768, -32767, 32767));
	return (int32_t)(((uint32_t)east & 0xffffu) | (uint32_t)north << 16);
}

SOIL_CLONED static void put_after(const struct soil_form *restrict f, const float axis[restrict 2], int32_t raised, const struct soil_posts *restrict posts, size_t b,
				  const struct soil_kept *restrict kept, const float bulldozing, struct after *restrict a)
{
	int32_t ground[POSTS_LANES], rests[POSTS_LANES], lowest[POSTS_LANES], deposited[POSTS_LANES], sinkage[POSTS_LANES], dug[POSTS_LANES], before[POSTS_LANES];
	float up[POSTS_LANES], by_up[POSTS_LANES], over[POSTS_LANES], swept[POSTS_LANES], more[POSTS_LANES];
	struct stress_soil soils[POSTS_LANES];
	const int32_t near = (int32_t)fminf(f->spacing * 2097152.0f, 1e9f);
	for (int i = 0; i < POSTS_LANES; i++) {
		const float height = posts->height[b + i] + posts->above[b + i] + f->beyond;
		ground[i] = posts->ground[b + i] - raised;
		rests[i] = whole_units(height);
		lowest[i] = whole_units(height - posts->lowered[b + i]);
		deposited[i] = posts->deposited[b + i];
		sinkage[i] = posts->sinkage[b + i];
		dug[i] = posts->digs[b + i];
		before[i] = posts->surface[b + i] - posts->ground[b + i] + deposited[i]; /* its offset */
		up[i] = posts->up[b + i];
		by_up[i] = posts->by_up[b + i];
		over[i] = posts->over[b + i];
		swept[i] = most(posts->swept[b + i], over[i]);
		more[i] = kept->more[b + i];
		soils[i] = (struct stress_soil){.k = posts->k[b + i], .n = posts->n[b + i], .elastic = posts->elastic[b + i], .by_elastic = posts->by_elastic[b + i]};
	}
	for (int i = 0; i < POSTS_LANES; i++) {
		const struct stress_soil *s = &soils[i];
		const float had = plastic_of(s, (float)sinkage[i] * SOIL_UNIT);
		const int32_t deepest = sinkage_of(up[i], ground[i] - lowest[i]), sunk = over[i] > 0 ? sinkage_of(up[i], ground[i] - rests[i]) : 0;
		const bool may = (swept[i] > 0) & (lowest[i] < ground[i]);
		const int32_t largest = larger(sinkage[i], deepest);
		const float plastic = plastic_of(s, (float)largest * SOIL_UNIT);
		const bool touched = may & in_contact(deepest, sinkage[i], had), held = touched & in_contact(sunk, largest, plastic);
		/* What slip digs. */
		const int32_t digs = held ? larger(smaller(whole_units(more[i]), ground[i] - rests[i] - 2), 0) : 0;
		const int32_t lowered = ground[i] - digs, remains = larger(sinkage[i] - whole_of(up[i] * (float)digs), 0);
		const float had_now = plastic_of(s, (float)remains * SOIL_UNIT);
		const int32_t largest_now = larger(remains, sinkage_of(up[i], lowered - lowest[i]));
		const float plastic_now = plastic_of(s, (float)largest_now * SOIL_UNIT);
		const bool held_now = digs > 0 ? in_contact(sinkage_of(up[i], lowered - rests[i]), largest_now, plastic_now) : held;
		const int32_t released = whole_units(plastic_now * by_up[i]), released_before = whole_units(had_now * by_up[i]);
		const int32_t sinks = held_now ? lowered - rests[i] : released, heap = deposited[i] - digs, offset = heap - sinks;
		const bool refused = touched & ((sinks > OFFSET_MOST) | (offset > OFFSET_MOST) | (offset < -OFFSET_MOST));
		const bool changes = touched & !refused;
		const int32_t flows = larger(released - released_before, 0), carries = (int32_t)least(bulldozing * (float)flows, (float)larger(CARRIED_MOST - digs, 0));
		a->touched[i] = changes;
		a->held[i] = changes & held_now;
		a->refused[i] = refused;
		a->offset[i] = offset;
		a->deposited[i] = heap;
		a->sinkage[i] = largest_now;
		a->dug[i] = dug[i] + digs;
		/* Only soil that the floor gives up is carried. What slip digs under a body that does not go down stays there, loosened. */
		a->carried[i] = changes ? larger(smaller(carries + smaller(digs, CARRIED_MOST), before[i] - offset), 0) : 0;
		a->lost[i] = changes ? before[i] - offset - a->carried[i] : 0;
		/* The body has just left the post, or comes next, and the shear that the post stores ends. Below a higher body that shear may belong to a
		 * second one, so it stays. */
		a->ends[i] = (swept[i] > 0) & (lowest[i] - (ground[i] - deposited[i] + before[i]) < near);
	}
	for (int i = 0; i < POSTS_LANES; i++)
		a->shear[i] = a->held[i] ? shear_of(axis, kept->shear_x[b + i], kept->shear_y[b + i]) : 0;
}

/* A row of the patch as it is measured for laying. */
struct patch_row {
	int64_t y, first, last, carried;
	uint32_t givers, classes;
	int32_t deep;
};

static void end_row(const struct soil_laying *laying, struct patch_row *row, struct soil_measured *measured)
{
	if (row->first <= row->last)
		soil_measured_add(measured, laying, row->y, row->first, row->last, row->carried, row->givers, row->classes, row->deep);
	*row = (struct patch_row){.y = row->y, .first = INT64_MAX, .last = INT64_MIN};
}

static void put_post(const struct soil_press *press, const struct soil_planes *planes, size_t at, const struct after *a, int i, struct patch_row *row)
{
	const int64_t x = planes->rect.x0 + (int64_t)(at % planes->width);
	planes->offset[at] = a->offset[i];
	planes->sinkage[at] = a->sinkage[i];
	if (planes->dug != NULL) {
		planes->deposited[at] = a->deposited[i];
		planes->dug[at] = a->dug[i];
	}
	planes->contact[at] |= (uint8_t)(SOIL_LOWERED | (a->held[i] ? SOIL_HELD : 0));
	const uint32_t class = planes->classes != NULL ? planes->classes[at] : 0;
	const int32_t deep = soil_depth_of(a->carried[i], a->offset[i], a->dug[i], press->laying->rolls, press->soils[0].share);
	row->first = x < row->first ? x : row->first;
	row->last = x > row->last ? x : row->last;
	row->carried += a->carried[i];
	row->givers += a->carried[i] > 0;
	row->classes |= a->carried[i] > 0 ? 1u << (class < SOIL_CLASSES ? class : SOIL_CLASSES - 1) : 0;
	row->deep = deep > row->deep ? deep : row->deep;
}

static void commit(const struct soil_press *press, const struct pressed_body *b, const struct soil_kept *kept, int32_t raised, struct soil_pressed *out)
{
	const struct soil_posts *posts = b->posts;
	const struct soil_planes *planes = b->planes;
	const float axis[2] = {(float)b->body.axis[0], (float)b->body.axis[1]};
	struct patch_row row = {.y = INT64_MIN, .first = INT64_MAX, .last = INT64_MIN};
	struct post_rect near = {INT64_MAX, INT64_MAX, INT64_MIN, INT64_MIN}; /* posts that the body may have freed */
	for (size_t first = 0; first < posts->count; first += POSTS_LANES) {
		struct after after;
		put_after(&b->form, axis, raised, posts, first, kept, (float)b->law->bulldozing, &after);
		for (size_t i = 0; i < POSTS_LANES && first + i < posts->count; i++) {
			const size_t at = (size_t)posts->index[first + i];
			const int64_t y = planes->rect.y0 + (int64_t)(at / planes->width);
			if (y != row.y) {
				end_row(press->laying, &row, &out->measured);
				row.y = y;
			}
			if ((after.held[i] || after.ends[i]) && planes->shear != NULL)
				planes->shear[at] = after.shear[i];
			if (after.ends[i]) {
				const int64_t x = planes->rect.x0 + (int64_t)(at % planes->width);
				near.x0 = x < near.x0 ? x : near.x0;
				near.x1 = x + 1 > near.x1 ? x + 1 : near.x1;
				near.y0 = y < near.y0 ? y : near.y0;
				near.y1 = y + 1;
			}
			out->refused += after.refused[i];
			out->compacted += after.lost[i];
			if (after.touched[i])
				put_post(press, planes, at, &after, (int)i, &row);
		}
	}
	end_row(press->laying, &row, &out->measured);
	out->reached = near.x0 < near.x1 ? near : out->measured.patch;
	if (near.x0 < near.x1 && !post_rect_empty(out->measured.patch))
		out->reached = post_rect_around(near, out->measured.patch);
}

/* --- forces --- */

static void out_of_frame(const struct soil_body *body, const double v[3], double out[3])
{
	out[0] = body->axis[0] * v[0] - body->axis[1] * v[1];
	out[1] = body->axis[1] * v[0] + body->axis[0] * v[1];
	out[2] = v[2];
}

static void tell(const struct pressed_body *b, const struct search *s, struct soil_forces *forces)
{
	const double post = (double)b->form.spacing * (double)b->form.spacing, unit = post / (double)BEAR_UNITS_A_PASCAL;
	double force[3], moment[3];
	for (int k = 0; k < 3; k++) {
		force[k] = (double)s->sums.force[k] * unit;
		moment[k] = (double)s->sums.moment[k] * unit / (double)b->form.by_arm;
	}
	*forces = (struct soil_forces){
		.sinkage = lattice_offset_metres(s->sums.deepest), .area = (double)s->sums.area / (double)BEAR_AREA_UNITS * post, .pull = (double)s->sums.pull * unit,
		.z = b->motion->to.z + s->raised, .saturated = (uint32_t)s->sums.saturated, .state = s->state,
	};
	out_of_frame(&b->body, force, forces->force);
	out_of_frame(&b->body, moment, forces->moment);
}

static void prepare(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, struct soil_work *work, struct pressed_body *b)
{
	*b = (struct pressed_body){.law = law, .planes = planes, .motion = motion, .posts = &work->posts, .gathered = INT32_MAX};
	soil_form_of(law, motion, &b->body, &b->form);
	b->by_width = width_of(motion, &b->body);
}

enum status soil_press_body(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, const struct soil_press *press,
			    struct soil_work *work, struct soil_pressed *out)
{
	struct pressed_body b;
	struct search s = {.share = 1, .state = SOIL_TOUCHING};
	enum status status = need(work, soil_posts_below(law, motion));
	if (status != STATUS_OK)
		return status;
	prepare(law, planes, motion, work, &b);
	*out = (struct soil_pressed){.reached = {0, 0, 0, 0}};
	soil_measured_begin(&out->measured);
	if (motion->load > 0)
		find_height(&b, press->start, &s);
	else
		gather(&b, 0);
	put_width(&b, s.raised);
	if (s.state != SOIL_AIR && b.posts->count > 0) {
		soil_bear(&b.form, b.posts, s.raised, s.share, &s.sums, &work->kept, NULL);
		commit(press, &b, &work->kept, s.raised, out);
	}
	tell(&b, &s, &out->forces);
	out->raised = s.raised;
	out->tries = s.tries;
	return STATUS_OK;
}
