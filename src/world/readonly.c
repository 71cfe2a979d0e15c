/*
 * A readonly world follows its store: another process may write that. Each query sees the last commit, whole.
 *
 *   world_follow -> the query -> world_has_moved: then once more, as it may have seen parts of two commits
 *
 * Everything that was read before is dropped when there is a new commit. A world with vehicles does not follow: its ground has what their
 * setting down did to it, in memory alone.
 */
#include "world/internal.h"

static bool follows(const struct world *world)
{
	return world->params.readonly && world->params.attached == 0;
}

static enum status note_changed(void *user, uint64_t key)
{
	struct world *world = user;
	const struct tile tile = tile_from_key(key);
	return world_changed(world, tile, tile_post_rect(&world->resident.meta->extent, tile));
}

enum status world_follow(struct world *world)
{
	bool moved = false;
	enum status status = STATUS_OK;
	if (!follows(world))
		return STATUS_OK;
	if (world->follower == NULL)
		status = store_reader_create(world->resident.store, &world->follower);
	if (status == STATUS_OK)
		status = store_follow(world->follower, note_changed, world, &moved);
	if (status != STATUS_OK || !moved)
		return status;
	world_changes_end(world);
	status = resident_pages_forget(world->resident.pages);
	resident_ground_forget_offsets(world->resident.ground);
	resident_pyramid_forget(world->resident.pyramid);
	resident_newest_changed(world->resident.newest);
	return status;
}

enum status world_has_moved(struct world *world, bool *moved)
{
	*moved = false;
	return follows(world) && world->follower != NULL ? store_has_moved(world->follower, moved) : STATUS_OK;
}
