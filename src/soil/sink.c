/*
 * A body sinks into the ground: its equilibrium height, the forces on it, and the new state of the posts that it touches. See SOIL.md.
 *
 * The new state is whole numbers. So a post that a body has left, or that it touches again in the same pose, keeps its bits.
 */
#include "soil/sink.h"

#include "soil/contact.h"

#define CARRIED_MOST (1 << 23)    /* fixed-point units: the most that one post gives away */
#define SHEAR_ENDS 2.0                /* posts: where a body is less far above the surface, the shear that a post stores ends */
#define OFFSET_MOST (1 << 30)         /* fixed-point units: 1024 m */

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
	const int32_t near = (int32_t)fminf((float)SHEAR_ENDS * f->spacing * 1048576.0f, 1e9f);
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

static void put_post(const struct soil_sink *sink, const struct soil_planes *planes, size_t at, const struct after *a, int i, struct patch_row *row)
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
	const int32_t deep = soil_depth_of(a->carried[i], a->offset[i], a->dug[i], sink->laying->rolls, sink->soils[0].share);
	row->first = x < row->first ? x : row->first;
	row->last = x > row->last ? x : row->last;
	row->carried += a->carried[i];
	row->givers += a->carried[i] > 0;
	row->classes |= a->carried[i] > 0 ? 1u << (class < SOIL_CLASSES ? class : SOIL_CLASSES - 1) : 0;
	row->deep = deep > row->deep ? deep : row->deep;
}

static void commit(const struct soil_sink *sink, const struct soil_contact *b, const struct soil_kept *kept, int32_t raised, struct soil_imprint *out)
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
				end_row(sink->laying, &row, &out->measured);
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
				put_post(sink, planes, at, &after, (int)i, &row);
		}
	}
	end_row(sink->laying, &row, &out->measured);
	out->reached = near.x0 < near.x1 ? near : out->measured.patch;
	if (near.x0 < near.x1 && !post_rect_empty(out->measured.patch))
		out->reached = post_rect_around(near, out->measured.patch);
}

/* --- contact and feel --- */

/* Finds the body's height and evaluates the law there. Returns false if there is no ground below it. */
static bool evaluate(struct soil_contact *b, int32_t start, struct soil_height *height, struct soil_sums *sums, struct soil_kept *kept)
{
	*height = (struct soil_height){.share = 1, .state = SOIL_TOUCHING};
	*sums = (struct soil_sums){.deepest = 0};
	if (b->motion->load > 0)
		soil_height_find(b, start, height);
	else
		soil_contact_gather(b, 0);
	if (height->state == SOIL_AIR || b->posts->count == 0)
		return false;
	soil_contact_evaluate(b, height->raised, height->share, sums, kept, NULL);
	return true;
}

enum status soil_sink_body(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, const struct soil_sink *sink,
			    struct soil_work *work, struct soil_imprint *out)
{
	struct soil_contact b;
	struct soil_height height;
	struct soil_sums sums;
	enum status status = soil_contact_begin(law, planes, motion, work, SHEAR_ENDS * law->spacing, &b);
	if (status != STATUS_OK)
		return status;
	*out = (struct soil_imprint){.reached = {0, 0, 0, 0}};
	soil_measured_begin(&out->measured);
	if (evaluate(&b, sink->start, &height, &sums, &work->kept))
		commit(sink, &b, &work->kept, height.raised, out);
	soil_contact_tell(&b, &sums, height.raised, height.state, &out->forces);
	out->raised = height.raised;
	out->tries = height.tries;
	return STATUS_OK;
}

enum status soil_feel(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, int32_t start, struct soil_work *work,
		      struct soil_forces *out)
{
	struct soil_contact b;
	struct soil_height height;
	struct soil_sums sums;
	enum status status = soil_contact_begin(law, planes, motion, work, 0, &b);
	if (status != STATUS_OK)
		return status;
	evaluate(&b, start, &height, &sums, NULL);
	soil_contact_tell(&b, &sums, height.raised, height.state, out);
	return STATUS_OK;
}
