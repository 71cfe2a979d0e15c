/* Commits of all ranks, and the end of a run. */
#include "fleet/internal.h"

#include <math.h>
#include <string.h>

/* --- the record --- */

struct sharing {
	struct fleet *fleet;
	struct soil_block *blocks; /* of other ranks */
	size_t count, room;
};

static enum status put_bodies(struct fleet *fleet)
{
	const struct world *world = fleet->world;
	uint32_t count = 0;
	const size_t at = fleet->sent.size;
	TRY(fleet_put(&fleet->sent, &count, sizeof count));
	for (size_t i = 0; i < world_scene(world)->object_count; i++) {
		struct world_moved moved;
		if (!world_ranked(world, i) || world_body(world, i)->elsewhere)
			continue;
		world_body_pack(world, i, &moved);
		TRY(fleet_put(&fleet->sent, &moved, sizeof moved));
		count++;
	}
	memcpy(fleet->sent.bytes + at, &count, sizeof count);
	return STATUS_OK;
}

static enum status put_blocks(struct fleet *fleet)
{
	const struct soil_block *blocks = NULL;
	size_t many = 0;
	TRY(world_active_blocks(fleet->world, &blocks, &many));
	const uint32_t count = (uint32_t)many;
	TRY(fleet_put(&fleet->sent, &count, sizeof count));
	return fleet_put(&fleet->sent, blocks, many * sizeof *blocks);
}

static enum status get_bodies(struct fleet *fleet, int rank, struct fleet_bytes *bytes)
{
	uint32_t count;
	TRY(fleet_get(bytes, &count, sizeof count));
	for (uint32_t i = 0; i < count; i++) {
		struct world_moved moved;
		TRY(fleet_get(bytes, &moved, sizeof moved));
		if (rank != fleet->rank)
			TRY(world_body_unpack(fleet->world, &moved, false));
	}
	return STATUS_OK;
}

static enum status get_blocks(struct sharing *sharing, int rank, struct fleet_bytes *bytes)
{
	uint32_t count;
	TRY(fleet_get(bytes, &count, sizeof count));
	for (uint32_t i = 0; i < count; i++) {
		struct soil_block block;
		TRY(fleet_get(bytes, &block, sizeof block));
		if (rank == sharing->fleet->rank)
			continue;
		TRY(mem_grow(&sharing->blocks, &sharing->room, sharing->count + 1, sizeof *sharing->blocks, "active blocks"));
		sharing->blocks[sharing->count++] = block;
	}
	return STATUS_OK;
}

static enum status get_all(void *user, int rank, struct fleet_bytes *bytes)
{
	struct sharing *sharing = user;
	TRY(fleet_rows_get(sharing->fleet, bytes));
	TRY(get_bodies(sharing->fleet, rank, bytes));
	TRY(fleet_aboard_get_all(sharing->fleet, rank, bytes, false));
	TRY(fleet_grains_get_share(sharing->fleet, rank, bytes));
	return get_blocks(sharing, rank, bytes);
}

/* Puts this rank's part of the record together, when its last commit is done: so no rank is ahead by more than one commit. */
static enum status put_record(struct fleet *fleet)
{
	const struct fleet_wait wait = fleet_wait_begin();
	enum status status = page_cache_await_commit(world_resident(fleet->world)->cache);
	fleet_wait_end(fleet, wait);
	TRY(status);
	TRY(fleet_begin(fleet, FLEET_COMMIT, STATUS_OK));
	TRY(fleet_rows_put(fleet));
	TRY(put_bodies(fleet));
	TRY(fleet_aboard_put_all(fleet, false));
	TRY(fleet_grains_put_share(fleet));
	return put_blocks(fleet);
}

enum status fleet_share_record(struct fleet *fleet, enum status status)
{
	struct sharing sharing = {.fleet = fleet};
	struct fleet_told told;
	if (status == STATUS_OK)
		status = put_record(fleet);
	TRY_OR(done, fleet_tell(fleet, FLEET_COMMIT, status, &told, get_all, &sharing));
	TRY_OR(done, fleet_grains_check(fleet));
	TRY_OR(done, fleet_rows_write(fleet, INFINITY)); /* rows are in the file before the commit that goes with them */
	TRY_OR(done, world_record_ranks(fleet->world, sharing.blocks, sharing.count));
done:
	mem_free(sharing.blocks);
	return status;
}

enum status fleet_commit(struct fleet *fleet, enum status status)
{
	TRY(fleet_share_record(fleet, status));
	return world_begin_commit(fleet->world);
}

enum status fleet_end(void *user, enum status status)
{
	struct fleet *fleet = user;
	struct fleet_told told;
	const enum status mine = status == STATUS_INTERRUPTED ? STATUS_OK : status;
	struct failure failure;
	fleet->busy = fleet->plans > 0 ? clock_process_seconds() - fleet->began - fleet->spun : 0;
	if (!fleet->failed) {
		const enum status put = mine == STATUS_OK ? fleet_begin(fleet, FLEET_END, STATUS_OK) : mine;
		const enum status any = fleet_tell(fleet, FLEET_END, put, &told, NULL, NULL);
		status = any != STATUS_OK ? any : status;
	}
	if (world_is_torn(fleet->world))
		return status;
	failure_capture(&failure, status);
	const enum status shared = fleet_share_record(fleet, STATUS_OK);
	if (shared != STATUS_OK)
		world_tear(fleet->world);
	if (status == STATUS_OK || status == STATUS_INTERRUPTED)
		return shared != STATUS_OK ? shared : status == STATUS_OK ? STATUS_OK : failure_restore(&failure);
	return failure_restore(&failure);
}
