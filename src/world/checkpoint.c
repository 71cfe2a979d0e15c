/*
 * Checkpoints, and going back to the last one: ground, bodies, forces and time.
 *
 * After a checkpoint the store keeps what commits replace (store_mark), and a rollback drops the pages that changed. The
 * world's own state is copied here. A checkpoint that fails leaves the earlier one: the store's mark is the last that can fail. Touched posts, seen tiles and the bounds of what a view saw change are not set back. They only
 * save time, and may include too much. Ranges of offsets that were read from the store may include too little, since commits
 * narrow them. So they are forgotten, and read again.
 */
#include <string.h>

#include "world/internal.h"

struct checkpoint {
	int64_t step;
	double time;
	int64_t intervals;
	uint64_t revision;
	struct deform_tally tally;
	struct record *record;
	struct body *bodies;      /* body_count of them; all zero where a number has no body */
	size_t body_count;
	struct forces_saved *forces; /* NULL: nobody asks for any */
	struct carried_saved **carried; /* soil aboard: `carried_count` bodies */
	size_t carried_count;
	struct thrown_saved *thrown; /* NULL: nothing is thrown */
	bool begun; /* as world.begun */
};

void world_checkpoint_free(struct checkpoint *saved)
{
	if (saved == NULL)
		return;
	mem_free(saved->record);
	mem_free(saved->bodies);
	world_forces_saved_free(saved->forces);
	world_carried_saved_free(saved->carried, saved->carried_count);
	mem_free(saved->thrown);
	mem_free(saved);
}

static void *copy_of(const void *from, size_t bytes)
{
	void *copy = mem_alloc(bytes > 0 ? bytes : 1, 1);
	if (copy != NULL && bytes > 0)
		memcpy(copy, from, bytes);
	return copy;
}

static enum status save(struct world *world, struct checkpoint **out)
{
	const size_t objects = world->scene->object_count;
	struct checkpoint *saved = mem_calloc(1, sizeof *saved);
	TRY_MEM(saved, "a checkpoint");
	*saved = (struct checkpoint){
		.step = world->step,
		.time = world->time,
		.intervals = world->relaxation.intervals,
		.revision = world->changes.revision,
		.begun = world_has_begun(world),
		.record = copy_of(world->record, world_record_bytes_of(world->record, objects)),
		.bodies = mem_calloc(world->body_count + 1, sizeof *saved->bodies),
		.body_count = world->body_count,
	};
	enum status status;
	TRY_OR(failed, saved->record != NULL && saved->bodies != NULL ? STATUS_OK : fail_memory("a checkpoint"));
	for (size_t i = 0; i < world->body_count; i++)
		if (world->bodies[i] != NULL)
			saved->bodies[i] = *world->bodies[i];
	TRY_OR(failed, world_forces_save(world->forces, &saved->forces));
	TRY_OR(failed, world_carried_save(world, &saved->carried, &saved->carried_count));
	TRY_OR(failed, world_thrown_save(world, &saved->thrown));
	TRY_OR(failed, world_tally(world, &saved->tally));
	*out = saved;
	return STATUS_OK;
failed:
	world_checkpoint_free(saved);
	return status;
}

enum status world_checkpoint(struct world *world)
{
	struct checkpoint *saved = NULL;
	if (world_is_torn(world))
		return fail_with(STATUS_FAILED, "checkpoint: the last step failed half-way; roll back first, or close the world");
	TRY(world_hosts_commit(world));
	if (world_has_begun(world))
		TRY(page_cache_flush(world->resident.cache, world->record));
	TRY(save(world, &saved));
	enum status status;
	TRY_OR(failed, world->params.readonly ? STATUS_OK : resident_pages_mark(world->resident.pages));
	world_checkpoint_free(world->checkpoint);
	world->checkpoint = saved;
	return STATUS_OK;
failed:
	world_checkpoint_free(saved);
	return status;
}

enum status world_checkpoint_begun(struct world *world)
{
	struct checkpoint *saved = world->checkpoint;
	if (saved == NULL || saved->begun || world->params.attached == 0)
		return STATUS_OK;
	enum status status;
	TRY_OR(done, resident_pages_mark(world->resident.pages));
done:
	saved->begun = status == STATUS_OK;
	return status;
}

/* Sets active blocks and equilibrium heights back to those of the record. */
static enum status restore_deform(struct world *world, const struct checkpoint *saved)
{
	if (!world_changes_ground(world))
		return STATUS_OK;
	enum status status;
	TRY_OR(done, world_restore_tally(world, &saved->tally));
	for (size_t i = 0; i < saved->record->active_count; i++)
		TRY_OR(done, world_wake_block(world, saved->record->active[i]));
done:
	for (size_t i = 0; i < world->scene->object_count; i++) {
		const struct body *body = world->bodies[i];
		world_set_equilibrium(world, body, body->equilibrium - body->last.z);
	}
	return status;
}

static void restore_bodies(struct world *world, const struct checkpoint *saved)
{
	world_names_forget(world);
	for (size_t i = 0; i < world->body_count; i++) {
		struct body *body = world->bodies[i];
		if (body == NULL)
			continue;
		if (i < saved->body_count) {
			const bool told = body->host.rates_told;
			*body = saved->bodies[i];
			body->host.rates_told = told;
			continue;
		}
		world_body_free(body);
		world->bodies[i] = NULL;
	}
}

/* Bodies with paths go on from their place at the checkpoint. */
static enum status rewind_paths(struct world *world)
{
	int64_t *next = mem_calloc(world->scene->object_count + 1, sizeof *next);
	size_t count = 0;
	TRY_MEM(next, "going back");
	for (size_t i = 0; i < world->scene->object_count; i++)
		if (world->bodies[i]->kind == BODY_PATH)
			next[count++] = world->bodies[i]->next;
	resident_look_ahead_rewind(world->ahead, next, world->time);
	mem_free(next);
	return STATUS_OK;
}

enum status world_rollback(struct world *world)
{
	const struct checkpoint *saved = world->checkpoint;
	if (saved == NULL)
		return fail_with(STATUS_FAILED, "rollback: there is no checkpoint; make one first");
	const size_t objects = world->scene->object_count;
	TRY(world_has_begun(world) ? resident_pages_rollback(world->resident.pages) : STATUS_OK); /* else the ground is as it was */
	world_return_to(world, saved->begun);
	page_cache_hold(world->resident.cache, !saved->begun);
	world->step = saved->step;
	world->time = saved->time;
	world->relaxation.intervals = saved->intervals;
	memcpy(world->record, saved->record, world_record_bytes_of(world->record, objects));
	world_batches_forget(world); /* contacts of a step that failed */
	world_meetings_forget(world);
	world_happened_clear(world); /* it names bodies that may go now */
	restore_bodies(world, saved);
	world_carried_restore(world, saved->carried, saved->carried_count);
	world->near.stale = true;
	world_forces_restore(world->forces, saved->forces);
	world_thrown_restore(world, saved->thrown);
	world->events.count = world->rows.count = 0;
	resident_ground_forget_offsets(world->resident.ground); /* higher ground may be back than what was read since the checkpoint */
	resident_pyramid_forget(world->resident.pyramid);
	resident_newest_changed(world->resident.newest);
	world_changes_rollback(world, saved->revision);
	enum status status;
	TRY_OR(failed, restore_deform(world, saved));
	TRY_OR(failed, rewind_paths(world));
	return STATUS_OK;
failed:
	world_tear(world);
	return status;
}
