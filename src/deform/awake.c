/*
 * Which blocks are awake. They are visited once an interval; the last iteration says of each where posts changed
 * (flags.glsl), in a buffer that is read when its fence has passed.
 *
 * Where nothing changed in the last iteration within `rim` posts of a block, nothing within it changes in the next
 * interval, since each iteration looks only so far. So a block is awake after a visit if its own flags say so,
 * or a neighbour's for the side that is towards it, or if it was woken since.
 *
 * Invariants: (1) `blocks` holds all blocks in which the next interval may change something. (2) Visits whose flags
 * are not here yet are in `visits`, oldest first; what follows from the last known one is widened by one block all
 * round for each of them, which is farther than change comes in an interval (the rim is less than a block).
 */
#include <assert.h>
#include <string.h>

#include "deform/block_set.h"
#include "deform/internal.h"

#define VISITS 3 /* under way at most: then it is waited for */

struct visit {
	struct gpu_staging *flags;
	struct deform_block *visited; /* in the order of their flags */
	size_t count;
	struct block_set woken;       /* since */
};

struct awake {
	struct block_set blocks, next;
	struct visit visits[VISITS];
	size_t visit_count;
};

enum status awake_create(struct deform *deform)
{
	deform->awake = mem_calloc(1, sizeof *deform->awake);
	return deform->awake != NULL ? STATUS_OK : fail_memory("the awake blocks");
}

static void visit_finish(struct visit *visit)
{
	gpu_staging_destroy(visit->flags);
	mem_free(visit->visited);
	block_set_finish(&visit->woken);
	memset(visit, 0, sizeof *visit);
}

void awake_destroy(struct awake *awake)
{
	if (awake == NULL)
		return;
	for (size_t i = 0; i < awake->visit_count; i++)
		visit_finish(&awake->visits[i]);
	block_set_finish(&awake->blocks);
	block_set_finish(&awake->next);
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

/* What a visit left awake: bit 0 the block itself, then W, E, S, N, SW, SE, NW, NE. */
static enum status add_flagged(const struct deform *deform, struct block_set *set, const struct visit *visit)
{
	static const int ways[9][2] = {{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
	const uint32_t *flags = gpu_staging_bytes(visit->flags);
	enum status status = STATUS_OK;
	for (size_t i = 0; i < visit->count; i++)
		for (int way = 0; way < 9 && status == STATUS_OK; way++)
			if (flags[i] & 1u << way)
				status = add(deform, set, visit->visited[i].x + ways[way][0], visit->visited[i].y + ways[way][1]);
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

/* Looks whether flags have come; then the set anew. */
static enum status settle(struct deform *deform, bool *came)
{
	struct awake *awake = deform->awake;
	enum status status = STATUS_OK;
	*came = false;
	while (awake->visit_count > 0 && status == STATUS_OK && gpu_staging_idle(awake->visits[0].flags)) {
		block_set_clear(&awake->next);
		status = add_flagged(deform, &awake->next, &awake->visits[0]);
		if (status == STATUS_OK)
			status = add_all(&awake->next, &awake->visits[0].woken);
		visit_finish(&awake->visits[0]);
		memmove(awake->visits, awake->visits + 1, --awake->visit_count * sizeof *awake->visits);
		*came = true;
	}
	if (!*came || status != STATUS_OK)
		return status;
	for (size_t i = 0; i < awake->visit_count && status == STATUS_OK; i++) {
		status = widen(deform, &awake->next);
		if (status == STATUS_OK)
			status = add_all(&awake->next, &awake->visits[i].woken);
	}
	struct block_set was = awake->blocks;
	awake->blocks = awake->next;
	awake->next = was;
	return status == STATUS_OK ? gpu_check(deform->params.gpu, "the awake blocks") : status;
}

static enum status wait(struct deform *deform)
{
	bool came;
	gpu_finish(deform->params.gpu);
	return settle(deform, &came);
}

enum status deform_wake_block(struct deform *deform, struct deform_block block)
{
	struct awake *awake = deform->awake;
	if (awake == NULL)
		return STATUS_OK;
	enum status status = add(deform, &awake->blocks, block.x, block.y);
	if (status == STATUS_OK && awake->visit_count > 0)
		status = add(deform, &awake->visits[awake->visit_count - 1].woken, block.x, block.y);
	return status;
}

enum status deform_wake(struct deform *deform, struct post_rect changed)
{
	if (deform->awake == NULL || post_rect_empty(changed))
		return STATUS_OK;
	int64_t rim = deform_slide_rim(deform);
	struct deform_block last = last_block(deform);
	int64_t x0 = changed.x0 - rim, y0 = changed.y0 - rim, x1 = (changed.x1 - 1 + rim) / DEFORM_BLOCK;
	int64_t y1 = (changed.y1 - 1 + rim) / DEFORM_BLOCK;
	x0 = x0 > 0 ? x0 / DEFORM_BLOCK : 0;
	y0 = y0 > 0 ? y0 / DEFORM_BLOCK : 0;
	enum status status = STATUS_OK;
	for (int64_t y = y0; y <= y1 && y <= last.y; y++)
		for (int64_t x = x0; x <= x1 && x <= last.x && status == STATUS_OK; x++)
			status = deform_wake_block(deform, (struct deform_block){x, y});
	return status;
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
	if (status == STATUS_OK && awake->blocks.count > DEFORM_BLOCKS_MAX && awake->visit_count > 0)
		status = wait(deform);
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
	return status == STATUS_OK ? deform_awake(deform, blocks, count) : status;
}

enum status awake_visited(struct deform *deform, struct gpu_buffer *flags)
{
	struct awake *awake = deform->awake;
	size_t count = awake->blocks.count;
	assert(count > 0 && awake->visit_count < VISITS);
	struct visit *visit = &awake->visits[awake->visit_count];
	visit->visited = mem_alloc(count, sizeof *visit->visited);
	enum status status = visit->visited != NULL ? STATUS_OK : fail_memory("the awake blocks");
	if (status == STATUS_OK)
		status = gpu_staging_create(deform->params.gpu, count * sizeof(uint32_t), &visit->flags);
	if (status != STATUS_OK) {
		visit_finish(visit);
		return status;
	}
	memcpy(visit->visited, awake->blocks.blocks, count * sizeof *visit->visited);
	visit->count = count;
	awake->visit_count++;
	gpu_buffer_read_into(flags, 0, count * sizeof(uint32_t), visit->flags, 0);
	bool came;
	status = settle(deform, &came);
	return status == STATUS_OK && !came ? widen(deform, &awake->blocks) : status;
}
