/*
 * Presses a body into the ground: its equilibrium height, the forces on it, and the new state of the posts that it touches. See SOIL.md.
 *
 * The new state is whole numbers. So a post that a body has left, or presses anew by the same pose, keeps its bits.
 */
#include "soil/press.h"

#include "soil/bearing.h"
#include "soil/law/after.h"

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

static void put_post(const struct soil_press *press, const struct soil_planes *planes, size_t at, const struct soil_after *a, int i, struct patch_row *row)
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

static void commit(const struct soil_press *press, const struct bearing *b, const struct soil_kept *kept, int32_t raised, struct soil_pressed *out)
{
	const struct soil_posts *posts = b->posts;
	const struct soil_planes *planes = b->planes;
	const float axis[2] = {(float)b->body.axis[0], (float)b->body.axis[1]};
	struct patch_row row = {.y = INT64_MIN, .first = INT64_MAX, .last = INT64_MIN};
	struct post_rect near = {INT64_MAX, INT64_MAX, INT64_MIN, INT64_MIN}; /* posts that the body may have freed */
	for (size_t first = 0; first < posts->count; first += POSTS_LANES) {
		struct soil_after after;
		soil_after(&b->form, axis, raised, posts, first, kept, (float)b->law->bulldozing, &after);
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

/* --- contact and feel --- */

/* Finds the body's height and evaluates the law there. Returns false if there is no ground below it. */
static bool evaluate(struct bearing *b, int32_t start, struct soil_height *height, struct soil_sums *sums, struct soil_kept *kept)
{
	*height = (struct soil_height){.share = 1, .state = SOIL_TOUCHING};
	*sums = (struct soil_sums){.deepest = 0};
	if (b->motion->load > 0)
		soil_height_find(b, start, height);
	else
		soil_bearing_gather(b, 0);
	if (height->state == SOIL_AIR || b->posts->count == 0)
		return false;
	soil_bearing_evaluate(b, height->raised, height->share, sums, kept, NULL);
	return true;
}

enum status soil_press_body(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, const struct soil_press *press,
			    struct soil_work *work, struct soil_pressed *out)
{
	struct bearing b;
	struct soil_height height;
	struct soil_sums sums;
	enum status status = soil_bearing_begin(law, planes, motion, work, AFTER_SHEAR_ENDS * law->spacing, &b);
	if (status != STATUS_OK)
		return status;
	*out = (struct soil_pressed){.reached = {0, 0, 0, 0}};
	soil_measured_begin(&out->measured);
	if (evaluate(&b, press->start, &height, &sums, &work->kept))
		commit(press, &b, &work->kept, height.raised, out);
	soil_bearing_tell(&b, &sums, height.raised, height.state, &out->forces);
	out->raised = height.raised;
	out->tries = height.tries;
	return STATUS_OK;
}

enum status soil_feel(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, int32_t start, struct soil_work *work,
		      struct soil_forces *out)
{
	struct bearing b;
	struct soil_height height;
	struct soil_sums sums;
	enum status status = soil_bearing_begin(law, planes, motion, work, 0, &b);
	if (status != STATUS_OK)
		return status;
	evaluate(&b, start, &height, &sums, NULL);
	soil_bearing_tell(&b, &sums, height.raised, height.state, out);
	return STATUS_OK;
}
