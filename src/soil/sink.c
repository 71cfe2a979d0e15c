/*
 * A body sinks into the ground: its equilibrium height, the forces on it, and the new state of the posts that it touches. See SOIL.md.
 *
 * The new state is whole numbers. So a post that a body has left, or that it touches again in the same pose, keeps its bits.
 */
#include "soil/sink.h"

#include <math.h>

#include "soil/contact.h"
#include "soil/law/after.h"

#define PART_WAY 0.02    /* of a motion: parts of one body go the same way to so much */
#define PART_TURNS 1e-3 /* rad: and head the same way */

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

static void put_post(const struct soil_sink *sink, const struct soil_planes *planes, size_t at, const struct soil_after *a, int i, struct patch_row *row,
		     struct soil_measured *measured)
{
	const int64_t x = planes->rect.x0 + (int64_t)(at % planes->width);
	planes->offset[at] = a->offset[i];
	planes->sinkage[at] = a->sinkage[i];
	if (planes->dug != NULL || planes->settled != NULL)
		planes->deposited[at] = a->deposited[i];
	if (planes->dug != NULL)
		planes->dug[at] = a->dug[i];
	if (planes->settled != NULL) {
		planes->settled[at] = a->deposited[i];
		planes->loose[at] = a->loose[i];
		planes->floor[at] = a->floor[i];
	}
	if (planes->density != NULL)
		planes->density[at] = a->density[i];
	planes->contact[at] |= (uint8_t)(SOIL_LOWERED | (a->held[i] ? SOIL_HELD : 0));
	const uint32_t class = planes->classes != NULL ? planes->classes[at] : 0;
	const int32_t deep = soil_depth_of(a->carried[i], a->offset[i], a->dug[i], sink->laying->rolls, sink->soils[0].share);
	row->first = x < row->first ? x : row->first;
	row->last = x > row->last ? x : row->last;
	row->carried += a->carried[i];
	row->givers += a->carried[i] > 0;
	row->classes |= a->carried[i] > 0 ? 1u << (class < SOIL_CLASSES ? class : SOIL_CLASSES - 1) : 0;
	row->deep = deep > row->deep ? deep : row->deep;
	if (sink->carried != NULL && sink->notes)
		sink->carried[at] = a->carried[i];
	if (!sink->laying->front || sink->carried == NULL)
		return;
	sink->carried[at] = a->carried[i];
	soil_measured_moments(measured, sink->laying, x, row->y, a->carried[i]);
	if (a->held[i]) {
		const int64_t highest = 4 * (int64_t)planes->base[at] + a->offset[i];
		measured->highest = highest > measured->highest ? highest : measured->highest;
	}
}

/* Takes the thrown share of what slip dug at a post out of what the post gives away. Returns it. */
static int32_t throw_off(const struct soil_sink *sink, const struct soil_planes *planes, size_t at, struct soil_after *a, int i)
{
	const int32_t digs = planes->dug != NULL ? a->dug[i] - planes->dug[at] : 0, gives = digs < a->carried[i] ? digs : a->carried[i];
	const int32_t thrown = gives > 0 ? (int32_t)(((int64_t)gives * sink->throws) >> 16) : 0;
	a->carried[i] -= thrown;
	return thrown;
}

/* Notes a post of a hollow below a body that pushes. */
static void put_hollow(const struct soil_sink *sink, const struct soil_planes *planes, size_t at, const struct soil_after *a, int i,
		       struct soil_measured *measured)
{
	const int64_t x = planes->rect.x0 + (int64_t)(at % planes->width), y = planes->rect.y0 + (int64_t)(at / planes->width);
	if (!sink->laying->front || sink->carried == NULL || (planes->contact[at] & (SOIL_LOWERED | SOIL_HELD)) != 0)
		return;
	planes->contact[at] |= SOIL_NEAR;
	sink->carried[at] = a->gap[i];
	measured->hollows = post_rect_joined(measured->hollows, (struct post_rect){x, y, x + 1, y + 1});
}

/* Tells whether a body changes a post to a state, where several touch it. The one that holds it does, else the one that was deepest there. */
static bool takes(const struct soil_claim *claim, const struct soil_after *a, size_t i)
{
	const int32_t rank = a->touched[i] ? 1 + a->held[i] : 0;
	if (claim->owner == 0 || rank != claim->rank)
		return claim->owner == 0 || rank > claim->rank;
	if (rank > 0 && a->sinkage[i] != claim->sinkage)
		return a->sinkage[i] > claim->sinkage;
	return rank > 0 && a->offset[i] < claim->offset;
}

/* Computes what a block of posts becomes. slides: share of the motion by which the body slides, and carries all that it displaces. */
static void block_after(const struct soil_work *work, size_t first, double slides, struct soil_after *after)
{
	const struct soil_contact *b = &work->contact;
	const float axis[2] = {(float)b->body.axis[0], (float)b->body.axis[1]};
	(b->posts->layered ? soil_after_layered : soil_after)(&b->form, axis, work->raised, b->posts, first, &work->kept, (float)b->law->bulldozing, (float)slides, after);
}

void soil_sink_claim(const struct soil_work *work, uint8_t number, struct soil_claim *claims)
{
	const struct soil_posts *posts = work->contact.posts;
	for (size_t first = 0; work->touches && first < posts->count; first += POSTS_LANES) {
		struct soil_after after;
		block_after(work, first, 0, &after);
		for (size_t i = 0; i < POSTS_LANES && first + i < posts->count; i++) {
			struct soil_claim *claim = &claims[posts->index[first + i]];
			if ((after.touched[i] || after.ends[i]) && takes(claim, &after, i))
				*claim = (struct soil_claim){after.sinkage[i], after.offset[i], (uint8_t)(after.touched[i] ? 1 + after.held[i] : 0), number};
		}
	}
}

void soil_sink_commit(const struct soil_work *work, const struct soil_sink *sink, const struct soil_sink_shared *shared, struct soil_imprint *out)
{
	const struct soil_contact *b = &work->contact;
	const struct soil_posts *posts = b->posts;
	const struct soil_planes *planes = b->planes;
	struct patch_row row = {.y = INT64_MIN, .first = INT64_MAX, .last = INT64_MIN};
	struct post_rect near = {INT64_MAX, INT64_MAX, INT64_MIN, INT64_MIN}; /* posts that the body may have freed */
	out->reached = (struct post_rect){0, 0, 0, 0};
	soil_measured_begin(&out->measured);
	if (!work->touches)
		return;
	for (size_t first = 0; first < posts->count; first += POSTS_LANES) {
		struct soil_after after;
		block_after(work, first, sink->laying->front ? sink->laying->slides : 0, &after);
		for (size_t i = 0; i < POSTS_LANES && first + i < posts->count; i++) {
			const size_t at = (size_t)posts->index[first + i];
			const int64_t y = planes->rect.y0 + (int64_t)(at / planes->width);
			if (shared != NULL && shared->claims != NULL && shared->claims[at].owner != shared->number)
				continue;
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
			if (after.touched[i] && sink->throws > 0)
				out->thrown += throw_off(sink, planes, at, &after, (int)i);
			if (after.touched[i])
				put_post(sink, planes, at, &after, (int)i, &row, &out->measured);
			if (after.below[i])
				put_hollow(sink, planes, at, &after, (int)i, &out->measured);
			if (after.touched[i] && shared != NULL)
				shared->owners[at] = shared->number;
		}
	}
	end_row(sink->laying, &row, &out->measured);
	out->reached = near.x0 < near.x1 ? near : out->measured.patch;
	if (near.x0 < near.x1 && !post_rect_empty(out->measured.patch))
		out->reached = post_rect_around(near, out->measured.patch);
}

/* --- a body --- */

enum status soil_sink_begin(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, int32_t start, struct soil_work *work)
{
	work->raised = motion->load > 0 ? start : 0;
	work->touches = false;
	return soil_contact_begin(law, planes, motion, work, fmax(AFTER_SHEAR_ENDS * law->spacing, motion->hollows), &work->contact);
}

enum status soil_sink_meet(struct soil_work *work, const struct soil_work *const *others, size_t count)
{
	return soil_contact_meet(&work->contact, work, others, count, work->raised);
}

/* Tells whether two motions in plan differ by less than a part of their length. */
bool soil_sink_is_part(const struct soil_work *work, size_t index, const struct soil_work *other)
{
	const struct soil_contact *a = &work->contact, *b = &other->contact;
	const struct soil_pose *from[2] = {&a->motion->from, &b->motion->from}, *to[2] = {&a->motion->to, &b->motion->to};
	const double ways[2][2] = {{(double)(to[0]->x - from[0]->x), (double)(to[0]->y - from[0]->y)}, {(double)(to[1]->x - from[1]->x), (double)(to[1]->y - from[1]->y)}};
	const double apart = hypot(ways[0][0] - ways[1][0], ways[0][1] - ways[1][1]), turned = remainder(to[0]->yaw - to[1]->yaw, 2 * M_PI);
	return work->abuts[index] && a->motion->jumped == b->motion->jumped && fabs(turned) < PART_TURNS &&
	       apart <= PART_WAY * hypot(ways[0][0], ways[0][1]) + 2;
}

void soil_sink_widen(const struct soil_work *work, struct soil_laying *laying)
{
	const struct soil_contact *b = &work->contact;
	const double post = 65536 / b->law->spacing, right = (double)(b->form.enters[1][0] - b->form.half[1]), left = (double)(b->form.enters[1][1] - b->form.half[1]);
	if (laying->half_width > 0) {
		laying->at[1] -= (int32_t)lround(0.5 * (left - right) * post);
		laying->half_width += (int32_t)lround(0.5 * (left + right) * post);
	}
	laying->widest = (int32_t)fmin(ceil(laying->widest * b->wider), 64 * SOIL_BAND_POSTS);
}

bool soil_sink_shares(const struct soil_work *work)
{
	return work->contact.shares;
}

void soil_sink_find(struct soil_work *work, struct soil_imprint *out)
{
	struct soil_contact *b = &work->contact;
	struct soil_height height = {.share = 1, .state = SOIL_TOUCHING};
	struct soil_sums sums = {.deepest = 0};
	*out = (struct soil_imprint){.reached = {0, 0, 0, 0}};
	if (b->motion->load > 0)
		soil_height_find(b, work->raised, &height);
	else
		soil_contact_gather(b, 0);
	work->touches = height.state != SOIL_AIR && b->posts->count > 0;
	work->raised = height.raised;
	if (work->touches)
		soil_contact_evaluate(b, height.raised, height.share, &sums, &work->kept, NULL);
	soil_contact_tell(b, &sums, height.raised, height.state, &out->forces);
	out->raised = height.raised;
	out->tries = height.tries;
}

enum status soil_sink_body(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, const struct soil_sink *sink,
			    struct soil_work *work, struct soil_imprint *out)
{
	TRY(soil_sink_begin(law, planes, motion, sink->start, work));
	soil_sink_find(work, out);
	soil_sink_commit(work, sink, NULL, out);
	return STATUS_OK;
}
