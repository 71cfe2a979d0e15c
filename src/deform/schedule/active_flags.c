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
	deform_block_set_finish(&period->woken);
	*period = (struct period){.flags = period->flags};
}

/* Returns the north-eastern block of the world. */
static struct deform_block last_block(const struct deform *deform)
{
	const struct extent *extent = deform->params.extent;
	return (struct deform_block){(extent_posts(extent->width, deform->params.level) - 1) / DEFORM_BLOCK,
				     (extent_posts(extent->height, deform->params.level) - 1) / DEFORM_BLOCK};
}

enum status deform_active_add(const struct deform *deform, struct block_set *set, int64_t x, int64_t y)
{
	struct deform_block last = last_block(deform);
	if (x < 0 || y < 0 || x > last.x || y > last.y)
		return STATUS_OK;
	return deform_block_set_add(set, (struct deform_block){x, y});
}

static enum status add_all(struct block_set *set, const struct block_set *from)
{
	enum status status = STATUS_OK;
	for (size_t i = 0; i < from->count && status == STATUS_OK; i++)
		status = deform_block_set_add(set, from->blocks[i]);
	return status;
}

/* Adds the blocks that the flags of block (x, y) keep active. Bit 0: the block itself, then W, E, S, N, SW, SE, NW, NE. */
static enum status add_word(const struct deform *deform, struct block_set *set, int64_t x, int64_t y, uint32_t flags)
{
	static const int ways[9][2] = {{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
	enum status status = STATUS_OK;
	for (int way = 0; way < 9 && status == STATUS_OK; way++)
		if (flags & 1u << way)
			status = deform_active_add(deform, set, x + ways[way][0], y + ways[way][1]);
	return status;
}

static enum status add_visited(struct deform *deform, struct block_set *set, const struct visit *visit)
{
	struct touched *touched = &deform->active->touched;
	const uint32_t *flags = gpu_staging_bytes(visit->flags);
	enum status status = STATUS_OK;
	for (size_t i = 0; i < visit->count && status == STATUS_OK; i++) {
		status = add_word(deform, set, visit->visited[i].x, visit->visited[i].y, flags[i]);
		if (status == STATUS_OK && deform->params.touched && flags[i] >> CHANGED != 0)
			status = deform_touched_grow(touched, touched, visit->visited[i], deform->params.iterations, flags[i] >> CHANGED);
	}
	return status;
}

static int64_t block_of(int64_t post)
{
	return post >= 0 ? post / DEFORM_BLOCK : -((DEFORM_BLOCK - 1 - post) / DEFORM_BLOCK);
}

struct block_grid deform_active_grid(struct post_rect write)
{
	struct block_grid grid = {.x = block_of(write.x0), .y = block_of(write.y0)};
	grid.columns = (uint32_t)(block_of(write.x1 - 1) - grid.x + 1);
	grid.rows = (uint32_t)(block_of(write.y1 - 1) - grid.y + 1);
	return grid;
}

/* Adds to `touched` the parts of one block that a contact changed. */
static enum status add_changed(struct deform *deform, struct post_rect write, struct deform_block block, uint32_t parts)
{
	enum status status = STATUS_OK;
	for (int part = 0; parts >> part != 0 && status == STATUS_OK; part++)
		if (parts >> part & 1)
			status = deform_touched_add(&deform->active->touched, post_rect_intersect(write, deform_touched_part(block, part)));
	return status;
}

/* Adds what a period's contacts have activated and touched. Their flags must be here. */
static enum status add_swept(struct deform *deform, struct period *period)
{
	const uint32_t *flags = gpu_staging_bytes(period->flags);
	enum status status = STATUS_OK;
	for (size_t i = 0; i < period->count; i++) {
		struct block_grid grid = deform_active_grid(period->swept[i].write);
		for (uint32_t k = 0; k < grid.columns * grid.rows && status == STATUS_OK; k++, flags++) {
			int64_t x = grid.x + k % grid.columns, y = grid.y + k / grid.columns;
			status = add_word(deform, &period->woken, x, y, *flags);
			if (status == STATUS_OK && deform->params.touched)
				status = add_changed(deform, period->swept[i].write, (struct deform_block){x, y}, *flags >> CHANGED);
		}
	}
	period->asked = false;
	period->count = 0;
	return status;
}

struct post_rect deform_wakes(const struct deform *deform, struct post_rect changed)
{
	int64_t rim = deform_slide_rim(deform);
	struct deform_block last = last_block(deform);
	int64_t x0 = block_of(changed.x0 - rim), y0 = block_of(changed.y0 - rim), x1 = block_of(changed.x1 - 1 + rim);
	int64_t y1 = block_of(changed.y1 - 1 + rim);
	x0 = x0 > 0 ? x0 : 0;
	y0 = y0 > 0 ? y0 : 0;
	x1 = x1 < last.x ? x1 : last.x;
	y1 = y1 < last.y ? y1 : last.y;
	return (struct post_rect){x0 * DEFORM_BLOCK, y0 * DEFORM_BLOCK, (x1 + 1) * DEFORM_BLOCK, (y1 + 1) * DEFORM_BLOCK};
}

enum status deform_active_add_near(const struct deform *deform, struct block_set *set, struct post_rect changed)
{
	const struct post_rect posts = deform_wakes(deform, changed);
	enum status status = STATUS_OK;
	for (int64_t y = posts.y0 / DEFORM_BLOCK; y < posts.y1 / DEFORM_BLOCK; y++)
		for (int64_t x = posts.x0 / DEFORM_BLOCK; x < posts.x1 / DEFORM_BLOCK && status == STATUS_OK; x++)
			status = deform_block_set_add(set, (struct deform_block){x, y});
	return status;
}

static enum status add_period(const struct deform *deform, struct block_set *set, const struct period *period)
{
	enum status status = add_all(set, &period->woken);
	for (size_t i = 0; i < period->count && status == STATUS_OK; i++)
		status = deform_active_add_near(deform, set, period->swept[i].write);
	return status;
}

/* Adds all posts that contacts of the oldest period wrote, since the period ends and their flags were not read. */
static enum status add_all_swept(struct deform *deform)
{
	const struct period *period = &deform->active->periods[0];
	enum status status = STATUS_OK;
	for (size_t i = 0; i < period->count && deform->params.touched && status == STATUS_OK; i++)
		status = deform_touched_add(&deform->active->touched, period->swept[i].write);
	return status;
}

enum status deform_active_widen(const struct deform *deform, struct block_set *set)
{
	enum status status = STATUS_OK;
	size_t count = set->count;
	for (size_t i = 0; i < count; i++)
		for (int k = 0; k < 9 && status == STATUS_OK; k++)
			status = deform_active_add(deform, set, set->blocks[i].x + k % 3 - 1, set->blocks[i].y + k / 3 - 1);
	return status;
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
	enum status status = STATUS_OK;
	for (size_t i = 0; i < visit->count && status == STATUS_OK; i++) {
		status = deform_touched_grow(&active->maybe, &active->maybe, visit->visited[i], by, TOUCHED_PARTS);
		if (status == STATUS_OK)
			status = deform_touched_grow(&active->maybe, &active->touched, visit->visited[i], by, TOUCHED_PARTS);
	}
	return status;
}

/* Builds `maybe` again from all contacts and visits with unknown flags, in their order. It may become smaller, since other flags
 * have come. */
static enum status guess_anew(struct deform *deform)
{
	struct active *active = deform->active;
	enum status status = STATUS_OK;
	deform_touched_clear(&active->maybe);
	for (size_t i = 0; i <= active->visit_count && status == STATUS_OK; i++) {
		for (size_t k = 0; k < active->periods[i].count && status == STATUS_OK; k++)
			status = deform_active_maybe_swept(active, &active->periods[i].swept[k]);
		if (status == STATUS_OK && i < active->visit_count)
			status = deform_active_maybe_visited(deform, &active->visits[i]);
	}
	return status;
}

/* Reads all flags whose fence has passed. *came: there were some. */
static enum status take_flags(struct deform *deform, bool *came)
{
	struct active *active = deform->active;
	enum status status = STATUS_OK;
	*came = false;
	for (size_t i = 0; i <= active->visit_count && status == STATUS_OK; i++)
		if (active->periods[i].asked && gpu_staging_idle(active->periods[i].flags)) {
			status = add_swept(deform, &active->periods[i]);
			*came = true;
		}
	while (active->visit_count > 0 && status == STATUS_OK && gpu_staging_idle(active->visits[0].flags)) {
		deform_block_set_clear(&active->known);
		status = add_all_swept(deform);
		if (status == STATUS_OK)
			status = add_visited(deform, &active->known, &active->visits[0]);
		deform_active_visit_finish(&active->visits[0]);
		deform_active_period_finish(&active->periods[0]);
		hand_on(active);
		*came = true;
	}
	return status;
}

enum status deform_active_settle(struct deform *deform, bool *came)
{
	struct active *active = deform->active;
	enum status status = take_flags(deform, came);
	if (!*came || status != STATUS_OK)
		return status;
	deform_block_set_clear(&active->next);
	status = add_all(&active->next, &active->known);
	for (size_t i = 0; i <= active->visit_count && status == STATUS_OK; i++) {
		if (i > 0)
			status = deform_active_widen(deform, &active->next);
		if (status == STATUS_OK)
			status = add_period(deform, &active->next, &active->periods[i]);
	}
	struct block_set was = active->blocks;
	active->blocks = active->next;
	active->next = was;
	if (status == STATUS_OK && deform->params.touched)
		status = guess_anew(deform);
	return status == STATUS_OK ? gpu_check(deform->params.gpu, "the awake blocks") : status;
}

enum status deform_active_wait(struct deform *deform)
{
	bool came;
	gpu_finish(deform->params.gpu);
	return deform_active_settle(deform, &came);
}
