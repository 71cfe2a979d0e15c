/*
 * Reads the flags of contacts and visits once their fences have passed: which blocks are active, and which posts were
 * touched. Until then it takes the largest sets that the flags can name. The invariants are in schedule/active.c.
 */
#include <string.h>

#include "deform/schedule/active.h"

void deform_active_visit_finish(struct visit *visit)
{
	mem_free(visit->visited);
	*visit = (struct visit){.flags = visit->flags};
}

void deform_active_period_finish(struct period *period)
{
	mem_free(period->swept);
	soil_block_set_finish(&period->woken);
	*period = (struct period){.flags = period->flags};
}

static struct post_rect world_of(const struct deform *deform)
{
	const struct extent *extent = deform->params.extent;
	return (struct post_rect){0, 0, extent_posts(extent->width, deform->params.level), extent_posts(extent->height, deform->params.level)};
}

enum status deform_active_add(const struct deform *deform, struct soil_block_set *set, int64_t x, int64_t y)
{
	return soil_active_add(set, world_of(deform), (struct soil_block){x, y});
}

static enum status add_all(struct soil_block_set *set, const struct soil_block_set *from)
{
	for (size_t i = 0; i < from->count; i++)
		TRY(soil_block_set_add(set, from->blocks[i]));
	return STATUS_OK;
}

static enum status add_visited(struct deform *deform, struct soil_block_set *set, const struct visit *visit)
{
	struct touched *touched = &deform->active->touched;
	const uint32_t *flags = gpu_staging_bytes(visit->flags);
	for (size_t i = 0; i < visit->count; i++) {
		TRY(soil_active_add_word(set, world_of(deform), visit->visited[i], flags[i]));
		if (deform->params.touched && flags[i] >> CHANGED != 0)
			TRY(deform_touched_grow(touched, touched, visit->visited[i], deform->params.iterations, flags[i] >> CHANGED));
	}
	return STATUS_OK;
}

struct block_grid deform_active_grid(struct post_rect write)
{
	const struct post_rect blocks = soil_slide_blocks(write);
	return (struct block_grid){blocks.x0, blocks.y0, (uint32_t)(blocks.x1 - blocks.x0), (uint32_t)(blocks.y1 - blocks.y0)};
}

/* Adds to `touched` the parts of one block that a contact changed. */
static enum status add_changed(struct deform *deform, struct post_rect write, struct soil_block block, uint32_t parts)
{
	for (int part = 0; parts >> part != 0; part++)
		if (parts >> part & 1)
			TRY(deform_touched_add(&deform->active->touched, post_rect_intersect(write, deform_touched_part(block, part))));
	return STATUS_OK;
}

/* Adds what a period's contacts have activated and touched. */
static enum status add_flagged(struct deform *deform, struct period *period)
{
	const uint32_t *flags = gpu_staging_bytes(period->flags);
	for (size_t i = 0; i < period->count; i++) {
		struct block_grid grid = deform_active_grid(period->swept[i].write);
		for (uint32_t k = 0; k < grid.columns * grid.rows; k++, flags++) {
			int64_t x = grid.x + k % grid.columns, y = grid.y + k / grid.columns;
			TRY(soil_active_add_word(&period->woken, world_of(deform), (struct soil_block){x, y}, *flags));
			if (deform->params.touched)
				TRY(add_changed(deform, period->swept[i].write, (struct soil_block){x, y}, *flags >> CHANGED));
		}
	}
	return STATUS_OK;
}

/* Takes the flags of a period's contacts, which must be here. */
static enum status add_swept(struct deform *deform, struct period *period)
{
	enum status status = add_flagged(deform, period);
	period->asked = false;
	period->count = 0;
	return status;
}

struct post_rect deform_wakes(const struct deform *deform, struct post_rect changed)
{
	return soil_active_near(world_of(deform), deform_slide_rim(deform), changed);
}

enum status deform_active_add_near(const struct deform *deform, struct soil_block_set *set, struct post_rect changed)
{
	return soil_active_add_near(set, world_of(deform), deform_slide_rim(deform), changed);
}

static enum status add_period(const struct deform *deform, struct soil_block_set *set, const struct period *period)
{
	TRY(add_all(set, &period->woken));
	for (size_t i = 0; i < period->count; i++)
		TRY(deform_active_add_near(deform, set, period->swept[i].write));
	return STATUS_OK;
}

/* Adds all posts that contacts of the oldest period wrote, since the period ends and their flags were not read. */
static enum status add_all_swept(struct deform *deform)
{
	const struct period *period = &deform->active->periods[0];
	for (size_t i = 0; i < period->count && deform->params.touched; i++)
		TRY(deform_touched_add(&deform->active->touched, period->swept[i].write));
	return STATUS_OK;
}

enum status deform_active_widen(const struct deform *deform, struct soil_block_set *set)
{
	size_t count = set->count;
	for (size_t i = 0; i < count; i++)
		for (int k = 0; k < 9; k++)
			TRY(deform_active_add(deform, set, set->blocks[i].x + k % 3 - 1, set->blocks[i].y + k / 3 - 1));
	return STATUS_OK;
}

/* Ends the oldest visit and the period before it. Their staging buffers go to the ends of the arrays. */
static void hand_on(struct active *active)
{
	const struct visit visit = active->visits[0];
	const struct period period = active->periods[0];
	memmove(active->visits, active->visits + 1, (VISITS - 1) * sizeof *active->visits);
	memmove(active->periods, active->periods + 1, VISITS * sizeof *active->periods);
	active->visits[VISITS - 1] = visit;
	active->periods[VISITS] = period;
	active->visit_count--;
}

bool deform_active_is_touched(const struct active *active, struct post_rect rect)
{
	return deform_touched_any(&active->touched, rect) || deform_touched_any(&active->maybe, rect);
}

enum status deform_active_maybe_swept(struct active *active, const struct swept *swept)
{
	return !swept->above || deform_active_is_touched(active, swept->write) ? deform_touched_add(&active->maybe, swept->write) : STATUS_OK;
}

enum status deform_active_maybe_visited(struct deform *deform, const struct visit *visit)
{
	struct active *active = deform->active;
	int64_t by = deform->params.iterations;
	for (size_t i = 0; i < visit->count; i++) {
		TRY(deform_touched_grow(&active->maybe, &active->maybe, visit->visited[i], by, TOUCHED_PARTS));
		TRY(deform_touched_grow(&active->maybe, &active->touched, visit->visited[i], by, TOUCHED_PARTS));
	}
	return STATUS_OK;
}

/* Builds `maybe` again from all contacts and visits with unknown flags, in their order. It may become smaller, since other flags
 * have come. */
static enum status guess_anew(struct deform *deform)
{
	struct active *active = deform->active;
	deform_touched_clear(&active->maybe);
	for (size_t i = 0; i <= active->visit_count; i++) {
		for (size_t k = 0; k < active->periods[i].count; k++)
			TRY(deform_active_maybe_swept(active, &active->periods[i].swept[k]));
		if (i < active->visit_count)
			TRY(deform_active_maybe_visited(deform, &active->visits[i]));
	}
	return STATUS_OK;
}

/* Ends the oldest visit, whose flags must be here. */
static enum status end_visit(struct deform *deform)
{
	struct active *active = deform->active;
	enum status status;
	soil_block_set_clear(&active->known);
	TRY_OR(done, add_all_swept(deform));
	TRY_OR(done, add_visited(deform, &active->known, &active->visits[0]));
done:
	deform_active_visit_finish(&active->visits[0]);
	deform_active_period_finish(&active->periods[0]);
	hand_on(active);
	return status;
}

/* Reads all flags whose fence has passed. *came: there were some. */
static enum status take_flags(struct deform *deform, bool *came)
{
	struct active *active = deform->active;
	*came = false;
	for (size_t i = 0; i <= active->visit_count; i++)
		if (active->periods[i].asked && gpu_staging_idle(active->periods[i].flags)) {
			*came = true;
			TRY(add_swept(deform, &active->periods[i]));
		}
	while (active->visit_count > 0 && gpu_staging_idle(active->visits[0].flags)) {
		*came = true;
		TRY(end_visit(deform));
	}
	return STATUS_OK;
}

/* Collects in `next` the blocks that are active after what is known now. */
static enum status collect_next(struct deform *deform)
{
	struct active *active = deform->active;
	soil_block_set_clear(&active->next);
	TRY(add_all(&active->next, &active->known));
	for (size_t i = 0; i <= active->visit_count; i++) {
		if (i > 0)
			TRY(deform_active_widen(deform, &active->next));
		TRY(add_period(deform, &active->next, &active->periods[i]));
	}
	return STATUS_OK;
}

enum status deform_active_settle(struct deform *deform, bool *came)
{
	struct active *active = deform->active;
	TRY(take_flags(deform, came));
	if (!*came)
		return STATUS_OK;
	enum status status = collect_next(deform);
	struct soil_block_set was = active->blocks;
	active->blocks = active->next;
	active->next = was;
	TRY(status);
	if (deform->params.touched)
		TRY(guess_anew(deform));
	return gpu_check(deform->params.gpu, "the awake blocks");
}

enum status deform_active_wait(struct deform *deform)
{
	bool came;
	gpu_finish(deform->params.gpu);
	return deform_active_settle(deform, &came);
}
