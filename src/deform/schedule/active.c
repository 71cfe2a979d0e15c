/*
 * The set of active blocks. An interval visits each of them once. The last iteration of a visit or of a contact writes flags
 * for each block: where soil still moves in it (flags.glsl). The host reads the flags when their fence has passed.
 *
 * An iteration reads only near posts. So a block stays at rest in the next interval if no soil moved within `rim` posts of
 * it in the last iteration. A block is therefore active after a visit if its own flags say so, or a neighbour's flags for the
 * side towards it. It is also active if it was activated since. A contact also flags posts whose neighbours it could not
 * read (SOIL.md).
 *
 * A period is the time between two visits. Invariants:
 * (1) `blocks` holds all blocks in which the next interval may change something. These are the blocks that the last visit
 * with known flags left active (`known`), and the blocks activated since. For a contact with unknown flags, all
 * blocks that it wrote are included.
 * (2) `visits` holds the visits whose flags are still unknown, oldest first. For each of them the set is widened by one
 * block all round. That is enough, since soil moves less than a block in an interval (the rim is less than a block).
 * (3) Flags of a period's contacts are in `contact_flags` from word 0, in the order of `swept`, until they are asked
 * for. Words behind them are zero, or flags of a window that was not scattered.
 * (4) Staging buffers are made once. When a visit or a period ends, its staging buffer goes to the end of the array.
 * (5) `touched` holds every post that changed since the deform was made, and every post that deform_touch named. While flags
 * are on their way, the posts that they may name are in `maybe`.
 * (6) While flags are on their way, invariants 1 and 2 keep more blocks active than necessary. As a rule a visit of such a block changes
 * nothing, since its soil is at rest. An earlier drive with another soil may have left soil that is not (params.unsettled). Then an
 * interval first waits for all flags.
 * A contact changes only posts that it writes. A contact above the undisturbed ground changes only posts that changed
 * before. A visit changes only posts within `iterations` posts of a changed one: where two posts exchange soil, one of the
 * two has changed before. The flags tell which parts of blocks changed.
 */
#include "deform/schedule/active.h"

#include <assert.h>
#include <string.h>

enum status deform_active_create(struct deform *deform)
{
	TRY(mem_zeroed(&deform->active, 1, sizeof *deform->active, "the awake blocks"));
	struct gpu *gpu = deform->params.gpu;
	TRY(gpu_buffer_create(gpu, GPU_STORAGE, CONTACT_BYTES, NULL, &deform->active->contact_flags));
	for (int i = 0; i < VISITS; i++)
		TRY(gpu_staging_create(gpu, VISIT_BYTES, &deform->active->visits[i].flags));
	for (int i = 0; i <= VISITS; i++)
		TRY(gpu_staging_create(gpu, PERIOD_BYTES, &deform->active->periods[i].flags));
	return STATUS_OK;
}

void deform_active_plan(const char *effect, struct plan *plan)
{
	deform_plan_buffer(plan, effect, 1, CONTACT_BYTES, "sweeps' flags");
	deform_plan_buffer(plan, effect, VISITS, VISITS * VISIT_BYTES, "blocks' flags on their way");
	deform_plan_buffer(plan, effect, VISITS + 1, (VISITS + 1) * PERIOD_BYTES, "sweeps' flags on their way");
}

void deform_active_destroy(struct active *active)
{
	if (active == NULL)
		return;
	for (size_t i = 0; i < VISITS; i++) {
		deform_active_visit_finish(&active->visits[i]);
		gpu_staging_destroy(active->visits[i].flags);
	}
	for (size_t i = 0; i <= VISITS; i++) {
		deform_active_period_finish(&active->periods[i]);
		gpu_staging_destroy(active->periods[i].flags);
	}
	gpu_buffer_destroy(active->contact_flags);
	soil_block_set_finish(&active->known);
	soil_block_set_finish(&active->blocks);
	soil_block_set_finish(&active->next);
	deform_touched_finish(&active->touched);
	deform_touched_finish(&active->maybe);
	mem_free(active);
}

static struct period *this_period(struct active *active)
{
	return &active->periods[active->visit_count];
}

/* Starts the transfer of the flags of all contacts since the last visit. */
static void ask_swept(struct deform *deform)
{
	struct active *active = deform->active;
	struct period *period = this_period(active);
	if (period->count == 0 || period->asked)
		return;
	period->asked = true;
	gpu_buffer_read_into(active->contact_flags, 0, active->used * sizeof(uint32_t), period->flags, 0);
	/* A window that was not scattered may have left flags behind them. */
	uint32_t dirty = active->used + WINDOW_BLOCKS;
	gpu_buffer_clear(active->contact_flags, 0, (dirty < CONTACT_WORDS ? dirty : CONTACT_WORDS) * sizeof(uint32_t));
	active->used = 0;
}

/* True if flags of a visit, or of contacts, are still on their way. */
static bool are_under_way(const struct active *active)
{
	bool are = active->visit_count > 0;
	for (size_t i = 0; i <= active->visit_count; i++)
		are = are || active->periods[i].asked;
	return are;
}

struct place_flags deform_active_flags(struct deform *deform, const struct deform_window *window, uint32_t layer)
{
	struct active *active = deform->active;
	struct layer *scratch = &deform->scratch[layer];
	const struct post_rect read = window->read, write = window->write;
	const struct extent *extent = deform->params.extent;
	int64_t posts_x = extent_posts(extent->width, deform->params.level);
	int64_t posts_y = extent_posts(extent->height, deform->params.level);
	struct block_grid grid = deform_active_grid(write);
	int32_t step = (int32_t)deform_slide_step(deform);
	assert(grid.columns * grid.rows <= WINDOW_BLOCKS);
	scratch->flagged = deform->contacts_flag && scratch->alone && !this_period(active)->asked &&
			   grid.columns * grid.rows <= CONTACT_WORDS - active->used;
	return (struct place_flags){
		.words = active->contact_flags,
		.first = scratch->flagged ? active->used : CONTACT_WORDS,
		.columns = grid.columns,
		.from = {(int32_t)(read.x0 - grid.x * SOIL_BLOCK), (int32_t)(read.y0 - grid.y * SOIL_BLOCK)},
		/* Beyond the world there is no soil, so at its border all neighbours were looked at. */
		.step = step,
		.sides = {write.x0 > 0 ? step : 0, write.y0 > 0 ? step : 0, write.x1 < posts_x ? step : 0, write.y1 < posts_y ? step : 0},
	};
}

struct gpu_buffer *deform_active_words(const struct deform *deform)
{
	return deform->active->contact_flags;
}

static enum status keep_swept(struct period *period, struct swept window)
{
	TRY(mem_grow(&period->swept, &period->room, period->count + 1, sizeof *period->swept, "the awake blocks"));
	period->swept[period->count++] = window;
	return STATUS_OK;
}

enum status deform_wake_swept(struct deform *deform, const struct deform_window *window, uint32_t layer)
{
	struct active *active = deform->active;
	if (active == NULL || post_rect_empty(window->write))
		return STATUS_OK;
	struct layer *scratch = &deform->scratch[layer];
	const struct swept swept = {window->write, scratch->above};
	if (!scratch->flagged) {
		TRY(deform_touch(deform, window->write));
		return deform_wake(deform, window->write);
	}
	scratch->flagged = false;
	struct block_grid grid = deform_active_grid(window->write);
	TRY(keep_swept(this_period(active), swept));
	if (deform->params.touched)
		TRY(deform_active_maybe_swept(active, &swept));
	active->used += grid.columns * grid.rows;
	return deform_active_add_near(deform, &active->blocks, window->write);
}

enum status deform_wake_block(struct deform *deform, struct soil_block block)
{
	struct active *active = deform->active;
	if (active == NULL)
		return STATUS_OK;
	TRY(deform_active_add(deform, &active->blocks, block.x, block.y));
	return deform_active_add(deform, &this_period(active)->woken, block.x, block.y);
}

enum status deform_wake(struct deform *deform, struct post_rect changed)
{
	struct active *active = deform->active;
	if (active == NULL || post_rect_empty(changed))
		return STATUS_OK;
	TRY(deform_active_add_near(deform, &active->blocks, changed));
	return deform_active_add_near(deform, &this_period(active)->woken, changed);
}

enum status deform_active_blocks(struct deform *deform, const struct soil_block **blocks, size_t *count)
{
	struct active *active = deform->active;
	*count = 0;
	if (active == NULL)
		return STATUS_OK;
	bool came;
	TRY(deform_active_settle(deform, &came));
	/* Some of them may be active only because their flags are still unknown. */
	if (active->blocks.count > DEFORM_BLOCKS_MAX) {
		ask_swept(deform);
		TRY(deform_active_wait(deform));
	}
	if (active->blocks.count > DEFORM_BLOCKS_MAX)
		return fail_with(STATUS_FAILED, "soil: the ground slides in more than %d blocks of %d x %d posts at once; choose a "
						"soil that stands steeper, a coarser spacing, or model none", DEFORM_BLOCKS_MAX, SOIL_BLOCK, SOIL_BLOCK);
	soil_block_set_sort(&active->blocks);
	*blocks = active->blocks.blocks;
	*count = active->blocks.count;
	return STATUS_OK;
}

enum status deform_active_visit(struct deform *deform, const struct soil_block_set **blocks)
{
	const struct soil_block *list;
	size_t count;
	bool came;
	ask_swept(deform);
	TRY(deform_active_settle(deform, &came));
	if (deform->params.unsettled ? are_under_way(deform->active) : deform->active->visit_count == VISITS)
		TRY(deform_active_wait(deform));
	*blocks = &deform->active->blocks;
	return deform_active_blocks(deform, &list, &count);
}

bool deform_active_is_visited(const struct deform *deform, struct soil_block block)
{
	return soil_block_set_has(&deform->active->blocks, block);
}

uint32_t deform_active_word(const struct deform *deform, struct soil_block block)
{
	return (uint32_t)soil_block_set_place(&deform->active->blocks, block);
}

enum status deform_active_visited(struct deform *deform, struct gpu_buffer *flags)
{
	struct active *active = deform->active;
	size_t count = active->blocks.count;
	assert(count > 0 && active->visit_count < VISITS);
	struct visit *visit = &active->visits[active->visit_count];
	TRY(mem_make(&visit->visited, count, sizeof *visit->visited, "the awake blocks"));
	memcpy(visit->visited, active->blocks.blocks, count * sizeof *visit->visited);
	visit->count = count;
	active->visit_count++;
	if (deform->params.touched)
		TRY(deform_active_maybe_visited(deform, visit));
	gpu_buffer_read_into(flags, 0, count * sizeof(uint32_t), visit->flags, 0);
	bool came;
	TRY(deform_active_settle(deform, &came));
	return came ? STATUS_OK : deform_active_widen(deform, &active->blocks);
}

enum status deform_active_forget(struct deform *deform)
{
	struct active *active = deform->active;
	ask_swept(deform);
	enum status status = deform_active_wait(deform);
	assert(status != STATUS_OK || active->visit_count == 0);
	soil_block_set_clear(&active->known);
	soil_block_set_clear(&active->blocks);
	soil_block_set_clear(&active->next);
	deform_active_period_finish(&active->periods[0]);
	return status;
}

enum status deform_forget_active(struct deform *deform)
{
	return deform->active != NULL ? deform_active_forget(deform) : STATUS_OK;
}

enum status deform_touch(struct deform *deform, struct post_rect rect)
{
	return deform->params.touched ? deform_touched_add(&deform->active->touched, rect) : STATUS_OK;
}

enum status deform_is_touched(struct deform *deform, struct post_rect rect, bool *is)
{
	const struct active *active = deform->active;
	bool came;
	assert(deform->params.touched);
	enum status status = deform_active_settle(deform, &came);
	*is = deform_active_is_touched(active, rect);
	return status;
}
