/*
 * Which blocks are awake. They are visited once an interval; the last iteration of a visit, and that of a sweep, say of
 * each block where soil still moves (flags.glsl), in buffers that are read when their fences have passed.
 *
 * Where no soil moved in the last iteration within `rim` posts of a block, none within it moves in the next
 * interval, since each iteration looks only so far. So a block is awake after a visit if its own flags say so,
 * or a neighbour's for the side that is towards it, or if it was woken since. A sweep's flags count what it could not
 * look at, too (SOIL.md).
 *
 * Invariants: (1) `blocks` holds all blocks in which the next interval may change something: what the last visit whose
 * flags are here left awake (`known`), and what was woken in the period since; of sweeps whose flags are not here all that
 * they wrote. (2) Visits whose flags are not here yet are in `visits`, oldest first; what is awake at each is widened by
 * one block all round, which is farther than change comes in an interval (the rim is less than a block). (3) The words of
 * a period's sweeps are those of `sweeps` from word 0, in the order of `swept`, until they are asked for; behind them all is
 * zero, or flags of a window that nobody scattered. (4) Stagings are made once and handed on: a visit's and a period's
 * that is over goes behind those that are to come. (5) Every post that is other than it was when the deform was made, or that
 * deform_touch named, is in `touched`; or, while flags are on their way that are to say so, in `maybe`. A sweep changes what it
 * writes; one above the undisturbed ground nothing where nothing was changed before; a visit what lies within
 * `iterations` posts, one an iteration, of what was changed before, since of two posts that exchange soil one has risen or
 * sunk. Of each the flags say which parts of blocks it was.
 */
#include <assert.h>
#include <string.h>

#include "deform/block_set.h"
#include "deform/internal.h"
#include "deform/touched.h"

#define VISITS 3 /* under way at most: then it is waited for */
#define SWEEP_WORDS 8192 /* of sweeps between two intervals; those beyond wake all that they write */
#define WINDOW_BLOCKS ((SIDE / DEFORM_BLOCK + 1) * (SIDE / DEFORM_BLOCK + 1)) /* that a window lies on, at most */

#define SWEEPS_BYTES ((SWEEP_WORDS + WINDOW_BLOCKS) * sizeof(uint32_t))
#define PERIOD_BYTES (SWEEP_WORDS * sizeof(uint32_t))
#define VISIT_BYTES (DEFORM_BLOCKS_MAX * sizeof(uint32_t))
#define CHANGED 16 /* flags.glsl: from this bit on, the parts that were changed */

struct visit {
	struct gpu_staging *flags;    /* DEFORM_BLOCKS_MAX words */
	struct deform_block *visited; /* in the order of their flags */
	size_t count;
};

/* A window whose flags are not here yet. */
struct swept {
	struct post_rect write;
	bool above;
};

/* From one visit to the next. */
struct period {
	struct block_set woken;
	struct swept *swept;       /* `count` of them */
	size_t count, room;
	struct gpu_staging *flags; /* SWEEP_WORDS: theirs, if they are asked for */
	bool asked;
};

struct awake {
	struct block_set known, blocks, next;
	struct visit visits[VISITS];
	size_t visit_count;
	struct period periods[VISITS + 1]; /* [0] since what is known, [i + 1] since visits[i] */
	struct gpu_buffer *sweeps;         /* SWEEP_WORDS, and a window's that nobody reads */
	uint32_t used;                     /* of them, in this period */
	struct touched touched, maybe;     /* empty unless it is asked for */
};

/* Blocks on which a window lies, counted through from the south-west. */
struct block_grid {
	int64_t x, y; /* the first */
	uint32_t columns, rows;
};

enum status awake_create(struct deform *deform)
{
	deform->awake = mem_calloc(1, sizeof *deform->awake);
	if (deform->awake == NULL)
		return fail_memory("the awake blocks");
	struct gpu *gpu = deform->params.gpu;
	enum status status = gpu_buffer_create(gpu, GPU_STORAGE, SWEEPS_BYTES, NULL, &deform->awake->sweeps);
	for (int i = 0; i < VISITS && status == STATUS_OK; i++)
		status = gpu_staging_create(gpu, VISIT_BYTES, &deform->awake->visits[i].flags);
	for (int i = 0; i <= VISITS && status == STATUS_OK; i++)
		status = gpu_staging_create(gpu, PERIOD_BYTES, &deform->awake->periods[i].flags);
	return status;
}

void awake_plan(const char *effect, struct plan *plan)
{
	deform_plan_buffer(plan, effect, 1, SWEEPS_BYTES, "sweeps' flags");
	deform_plan_buffer(plan, effect, VISITS, VISITS * VISIT_BYTES, "blocks' flags on their way");
	deform_plan_buffer(plan, effect, VISITS + 1, (VISITS + 1) * PERIOD_BYTES, "sweeps' flags on their way");
}

static void visit_finish(struct visit *visit)
{
	mem_free(visit->visited);
	*visit = (struct visit){.flags = visit->flags};
}

static void period_finish(struct period *period)
{
	mem_free(period->swept);
	block_set_finish(&period->woken);
	*period = (struct period){.flags = period->flags};
}

void awake_destroy(struct awake *awake)
{
	if (awake == NULL)
		return;
	for (size_t i = 0; i < VISITS; i++) {
		visit_finish(&awake->visits[i]);
		gpu_staging_destroy(awake->visits[i].flags);
	}
	for (size_t i = 0; i <= VISITS; i++) {
		period_finish(&awake->periods[i]);
		gpu_staging_destroy(awake->periods[i].flags);
	}
	gpu_buffer_destroy(awake->sweeps);
	block_set_finish(&awake->known);
	block_set_finish(&awake->blocks);
	block_set_finish(&awake->next);
	touched_finish(&awake->touched);
	touched_finish(&awake->maybe);
	mem_free(awake);
}

/* The blocks from which the world's posts are made. */
static struct deform_block last_block(const struct deform *deform)
{
	const struct world *world = deform->params.world;
	return (struct deform_block){(world_posts(world->width, deform->params.level) - 1) / DEFORM_BLOCK,
				     (world_posts(world->height, deform->params.level) - 1) / DEFORM_BLOCK};
}

static enum status add(const struct deform *deform, struct block_set *set, int64_t x, int64_t y)
{
	struct deform_block last = last_block(deform);
	if (x < 0 || y < 0 || x > last.x || y > last.y)
		return STATUS_OK;
	return block_set_add(set, (struct deform_block){x, y});
}

static enum status add_all(struct block_set *set, const struct block_set *from)
{
	enum status status = STATUS_OK;
	for (size_t i = 0; i < from->count && status == STATUS_OK; i++)
		status = block_set_add(set, from->blocks[i]);
	return status;
}

/* What a block's flags keep awake: bit 0 the block itself, then W, E, S, N, SW, SE, NW, NE. */
static enum status add_word(const struct deform *deform, struct block_set *set, int64_t x, int64_t y, uint32_t flags)
{
	static const int ways[9][2] = {{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
	enum status status = STATUS_OK;
	for (int way = 0; way < 9 && status == STATUS_OK; way++)
		if (flags & 1u << way)
			status = add(deform, set, x + ways[way][0], y + ways[way][1]);
	return status;
}

static enum status add_visited(struct deform *deform, struct block_set *set, const struct visit *visit)
{
	struct touched *touched = &deform->awake->touched;
	const uint32_t *flags = gpu_staging_bytes(visit->flags);
	enum status status = STATUS_OK;
	for (size_t i = 0; i < visit->count && status == STATUS_OK; i++) {
		status = add_word(deform, set, visit->visited[i].x, visit->visited[i].y, flags[i]);
		if (status == STATUS_OK && deform->params.touched && flags[i] >> CHANGED != 0)
			status = touched_grow(touched, touched, visit->visited[i], deform->params.iterations, flags[i] >> CHANGED);
	}
	return status;
}

static int64_t block_of(int64_t post)
{
	return post >= 0 ? post / DEFORM_BLOCK : -((DEFORM_BLOCK - 1 - post) / DEFORM_BLOCK);
}

static struct block_grid grid_of(struct post_rect write)
{
	struct block_grid grid = {.x = block_of(write.x0), .y = block_of(write.y0)};
	grid.columns = (uint32_t)(block_of(write.x1 - 1) - grid.x + 1);
	grid.rows = (uint32_t)(block_of(write.y1 - 1) - grid.y + 1);
	return grid;
}

/* What a sweep has changed in one of its blocks. */
static enum status add_changed(struct deform *deform, struct post_rect write, struct deform_block block, uint32_t parts)
{
	enum status status = STATUS_OK;
	for (int part = 0; parts >> part != 0 && status == STATUS_OK; part++)
		if (parts >> part & 1)
			status = touched_add(&deform->awake->touched, post_rect_intersect(write, touched_part(block, part)));
	return status;
}

/* Its sweeps' flags are here. */
static enum status add_swept(struct deform *deform, struct period *period)
{
	const uint32_t *flags = gpu_staging_bytes(period->flags);
	enum status status = STATUS_OK;
	for (size_t i = 0; i < period->count; i++) {
		struct block_grid grid = grid_of(period->swept[i].write);
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

/* All blocks in which something changes within an interval if posts in here do. */
static enum status add_near(const struct deform *deform, struct block_set *set, struct post_rect changed)
{
	const struct post_rect posts = deform_wakes(deform, changed);
	enum status status = STATUS_OK;
	for (int64_t y = posts.y0 / DEFORM_BLOCK; y < posts.y1 / DEFORM_BLOCK; y++)
		for (int64_t x = posts.x0 / DEFORM_BLOCK; x < posts.x1 / DEFORM_BLOCK && status == STATUS_OK; x++)
			status = block_set_add(set, (struct deform_block){x, y});
	return status;
}

static enum status add_period(const struct deform *deform, struct block_set *set, const struct period *period)
{
	enum status status = add_all(set, &period->woken);
	for (size_t i = 0; i < period->count && status == STATUS_OK; i++)
		status = add_near(deform, set, period->swept[i].write);
	return status;
}

/* The oldest period is over, and what its sweeps have changed nobody has looked at. */
static enum status add_all_swept(struct deform *deform)
{
	const struct period *period = &deform->awake->periods[0];
	enum status status = STATUS_OK;
	for (size_t i = 0; i < period->count && deform->params.touched && status == STATUS_OK; i++)
		status = touched_add(&deform->awake->touched, period->swept[i].write);
	return status;
}

static enum status widen(const struct deform *deform, struct block_set *set)
{
	enum status status = STATUS_OK;
	size_t count = set->count;
	for (size_t i = 0; i < count; i++)
		for (int k = 0; k < 9 && status == STATUS_OK; k++)
			status = add(deform, set, set->blocks[i].x + k % 3 - 1, set->blocks[i].y + k / 3 - 1);
	return status;
}

/* The oldest visit is over, and the period before it. */
static void hand_on(struct awake *awake)
{
	const struct visit visit = awake->visits[0];
	const struct period period = awake->periods[0];
	memmove(awake->visits, awake->visits + 1, (VISITS - 1) * sizeof *awake->visits);
	memmove(awake->periods, awake->periods + 1, VISITS * sizeof *awake->periods);
	awake->visits[VISITS - 1] = visit;
	awake->periods[VISITS] = period;
	awake->visit_count--;
}

static bool is_touched(const struct awake *awake, struct post_rect rect)
{
	return touched_any(&awake->touched, rect) || touched_any(&awake->maybe, rect);
}

static enum status maybe_swept(struct awake *awake, const struct swept *swept)
{
	return !swept->above || is_touched(awake, swept->write) ? touched_add(&awake->maybe, swept->write) : STATUS_OK;
}

static enum status maybe_visited(struct deform *deform, const struct visit *visit)
{
	struct awake *awake = deform->awake;
	int64_t by = deform->params.iterations;
	enum status status = STATUS_OK;
	for (size_t i = 0; i < visit->count && status == STATUS_OK; i++) {
		status = touched_grow(&awake->maybe, &awake->maybe, visit->visited[i], by, TOUCHED_PARTS);
		if (status == STATUS_OK)
			status = touched_grow(&awake->maybe, &awake->touched, visit->visited[i], by, TOUCHED_PARTS);
	}
	return status;
}

/* All whose flags are not here, in their order: they may have changed less than was thought, since others did. */
static enum status guess_anew(struct deform *deform)
{
	struct awake *awake = deform->awake;
	enum status status = STATUS_OK;
	touched_clear(&awake->maybe);
	for (size_t i = 0; i <= awake->visit_count && status == STATUS_OK; i++) {
		for (size_t k = 0; k < awake->periods[i].count && status == STATUS_OK; k++)
			status = maybe_swept(awake, &awake->periods[i].swept[k]);
		if (status == STATUS_OK && i < awake->visit_count)
			status = maybe_visited(deform, &awake->visits[i]);
	}
	return status;
}

/* Takes in the flags that have come. */
static enum status take_flags(struct deform *deform, bool *came)
{
	struct awake *awake = deform->awake;
	enum status status = STATUS_OK;
	*came = false;
	for (size_t i = 0; i <= awake->visit_count && status == STATUS_OK; i++)
		if (awake->periods[i].asked && gpu_staging_idle(awake->periods[i].flags)) {
			status = add_swept(deform, &awake->periods[i]);
			*came = true;
		}
	while (awake->visit_count > 0 && status == STATUS_OK && gpu_staging_idle(awake->visits[0].flags)) {
		block_set_clear(&awake->known);
		status = add_all_swept(deform);
		if (status == STATUS_OK)
			status = add_visited(deform, &awake->known, &awake->visits[0]);
		visit_finish(&awake->visits[0]);
		period_finish(&awake->periods[0]);
		hand_on(awake);
		*came = true;
	}
	return status;
}

/* Looks whether flags have come; then the set anew. */
static enum status settle(struct deform *deform, bool *came)
{
	struct awake *awake = deform->awake;
	enum status status = take_flags(deform, came);
	if (!*came || status != STATUS_OK)
		return status;
	block_set_clear(&awake->next);
	status = add_all(&awake->next, &awake->known);
	for (size_t i = 0; i <= awake->visit_count && status == STATUS_OK; i++) {
		if (i > 0)
			status = widen(deform, &awake->next);
		if (status == STATUS_OK)
			status = add_period(deform, &awake->next, &awake->periods[i]);
	}
	struct block_set was = awake->blocks;
	awake->blocks = awake->next;
	awake->next = was;
	if (status == STATUS_OK && deform->params.touched)
		status = guess_anew(deform);
	return status == STATUS_OK ? gpu_check(deform->params.gpu, "the awake blocks") : status;
}

static enum status wait(struct deform *deform)
{
	bool came;
	gpu_finish(deform->params.gpu);
	return settle(deform, &came);
}

static struct period *this_period(struct awake *awake)
{
	return &awake->periods[awake->visit_count];
}

/* Sends for the flags of what was swept since the last visit. */
static void ask_swept(struct deform *deform)
{
	struct awake *awake = deform->awake;
	struct period *period = this_period(awake);
	if (period->count == 0 || period->asked)
		return;
	period->asked = true;
	gpu_buffer_read_into(awake->sweeps, 0, awake->used * sizeof(uint32_t), period->flags, 0);
	/* And what a window that nobody scattered has left behind them. */
	uint32_t dirty = awake->used + WINDOW_BLOCKS;
	gpu_buffer_clear(awake->sweeps, 0, (dirty < SWEEP_WORDS ? dirty : SWEEP_WORDS) * sizeof(uint32_t));
	awake->used = 0;
}

struct place_flags awake_flags(struct deform *deform, const struct deform_window *window, uint32_t layer)
{
	struct awake *awake = deform->awake;
	struct layer *scratch = &deform->scratch[layer];
	const struct post_rect read = window->read, write = window->write;
	const struct world *world = deform->params.world;
	int64_t posts_x = world_posts(world->width, deform->params.level);
	int64_t posts_y = world_posts(world->height, deform->params.level);
	struct block_grid grid = grid_of(write);
	int32_t step = (int32_t)deform_slide_step(deform);
	assert(grid.columns * grid.rows <= WINDOW_BLOCKS);
	scratch->flagged = deform->sweeps_flag && scratch->alone && !this_period(awake)->asked &&
			   grid.columns * grid.rows <= SWEEP_WORDS - awake->used;
	return (struct place_flags){
		.words = awake->sweeps,
		.first = scratch->flagged ? awake->used : SWEEP_WORDS,
		.columns = grid.columns,
		.from = {(int32_t)(read.x0 - grid.x * DEFORM_BLOCK), (int32_t)(read.y0 - grid.y * DEFORM_BLOCK)},
		/* Nothing lies beyond the world. */
		.looked = {write.x0 > 0 ? (int32_t)(write.x0 - read.x0) + step : 0,
			   write.y0 > 0 ? (int32_t)(write.y0 - read.y0) + step : 0,
			   (int32_t)(write.x1 - read.x0) - (write.x1 < posts_x ? step : 0),
			   (int32_t)(write.y1 - read.y0) - (write.y1 < posts_y ? step : 0)},
		.loaded = scratch->loaded,
	};
}

static enum status keep_swept(struct period *period, struct swept window)
{
	if (period->count == period->room) {
		size_t room = period->room != 0 ? 2 * period->room : 64;
		struct swept *swept = mem_realloc(period->swept, room, sizeof *swept);
		if (swept == NULL)
			return fail_memory("the awake blocks");
		period->swept = swept;
		period->room = room;
	}
	period->swept[period->count++] = window;
	return STATUS_OK;
}

enum status deform_wake_swept(struct deform *deform, const struct deform_window *window, uint32_t layer)
{
	struct awake *awake = deform->awake;
	if (awake == NULL || post_rect_empty(window->write))
		return STATUS_OK;
	struct layer *scratch = &deform->scratch[layer];
	const struct swept swept = {window->write, scratch->above};
	if (!scratch->flagged) {
		enum status status = deform_touch(deform, window->write);
		return status == STATUS_OK ? deform_wake(deform, window->write) : status;
	}
	scratch->flagged = false;
	struct block_grid grid = grid_of(window->write);
	enum status status = keep_swept(this_period(awake), swept);
	if (status == STATUS_OK && deform->params.touched)
		status = maybe_swept(awake, &swept);
	if (status != STATUS_OK)
		return status;
	awake->used += grid.columns * grid.rows;
	return add_near(deform, &awake->blocks, window->write);
}

enum status deform_wake_block(struct deform *deform, struct deform_block block)
{
	struct awake *awake = deform->awake;
	if (awake == NULL)
		return STATUS_OK;
	enum status status = add(deform, &awake->blocks, block.x, block.y);
	return status == STATUS_OK ? add(deform, &this_period(awake)->woken, block.x, block.y) : status;
}

enum status deform_wake(struct deform *deform, struct post_rect changed)
{
	struct awake *awake = deform->awake;
	if (awake == NULL || post_rect_empty(changed))
		return STATUS_OK;
	enum status status = add_near(deform, &awake->blocks, changed);
	return status == STATUS_OK ? add_near(deform, &this_period(awake)->woken, changed) : status;
}

enum status deform_awake(struct deform *deform, const struct deform_block **blocks, size_t *count)
{
	struct awake *awake = deform->awake;
	*count = 0;
	if (awake == NULL)
		return STATUS_OK;
	bool came;
	enum status status = settle(deform, &came);
	/* Some of so many may be so only because their flags are not here yet. */
	if (status == STATUS_OK && awake->blocks.count > DEFORM_BLOCKS_MAX) {
		ask_swept(deform);
		status = wait(deform);
	}
	if (status == STATUS_OK && awake->blocks.count > DEFORM_BLOCKS_MAX)
		status = fail_with(STATUS_FAILED, "soil: the ground slides in more than %d blocks of %d x %d posts at once; choose a "
						  "soil that stands steeper, a coarser spacing, or model none", DEFORM_BLOCKS_MAX,
				   DEFORM_BLOCK, DEFORM_BLOCK);
	if (status != STATUS_OK)
		return status;
	block_set_sort(&awake->blocks);
	*blocks = awake->blocks.blocks;
	*count = awake->blocks.count;
	return STATUS_OK;
}

enum status awake_visit(struct deform *deform, const struct deform_block **blocks, size_t *count)
{
	enum status status = deform->awake->visit_count == VISITS ? wait(deform) : STATUS_OK;
	if (status != STATUS_OK)
		return status;
	ask_swept(deform);
	return deform_awake(deform, blocks, count);
}

bool awake_is_visited(const struct deform *deform, struct deform_block block)
{
	return block_set_has(&deform->awake->blocks, block);
}

enum status awake_visited(struct deform *deform, struct gpu_buffer *flags)
{
	struct awake *awake = deform->awake;
	size_t count = awake->blocks.count;
	assert(count > 0 && awake->visit_count < VISITS);
	struct visit *visit = &awake->visits[awake->visit_count];
	visit->visited = mem_alloc(count, sizeof *visit->visited);
	if (visit->visited == NULL)
		return fail_memory("the awake blocks");
	memcpy(visit->visited, awake->blocks.blocks, count * sizeof *visit->visited);
	visit->count = count;
	awake->visit_count++;
	enum status status = deform->params.touched ? maybe_visited(deform, visit) : STATUS_OK;
	if (status != STATUS_OK)
		return status;
	gpu_buffer_read_into(flags, 0, count * sizeof(uint32_t), visit->flags, 0);
	bool came;
	status = settle(deform, &came);
	return status == STATUS_OK && !came ? widen(deform, &awake->blocks) : status;
}

enum status deform_touch(struct deform *deform, struct post_rect rect)
{
	return deform->params.touched ? touched_add(&deform->awake->touched, rect) : STATUS_OK;
}

enum status deform_is_touched(struct deform *deform, struct post_rect rect, bool *is)
{
	const struct awake *awake = deform->awake;
	bool came;
	assert(deform->params.touched);
	enum status status = settle(deform, &came);
	*is = is_touched(awake, rect);
	return status;
}
