/* Commits of all ranks, probes, and the end of a run. */
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
	enum status status = STATUS_OK;
	uint32_t count = 0;
	const size_t at = fleet->sent.size;
	status = fleet_put(&fleet->sent, &count, sizeof count);
	for (size_t i = 0; i < world_scene(world)->object_count && status == STATUS_OK; i++) {
		struct world_moved moved;
		if (!world_ranked(world, i) || world_body(world, i)->elsewhere)
			continue;
		world_body_pack(world, i, &moved);
		status = fleet_put(&fleet->sent, &moved, sizeof moved);
		count++;
	}
	if (status == STATUS_OK)
		memcpy(fleet->sent.bytes + at, &count, sizeof count);
	return status;
}

static enum status put_blocks(struct fleet *fleet)
{
	const struct soil_block *blocks = NULL;
	size_t many = 0;
	enum status status = world_active_blocks(fleet->world, &blocks, &many);
	const uint32_t count = (uint32_t)many;
	if (status == STATUS_OK)
		status = fleet_put(&fleet->sent, &count, sizeof count);
	return status == STATUS_OK ? fleet_put(&fleet->sent, blocks, many * sizeof *blocks) : status;
}

static enum status get_bodies(struct fleet *fleet, int rank, struct fleet_bytes *bytes)
{
	uint32_t count;
	enum status status = fleet_get(bytes, &count, sizeof count);
	for (uint32_t i = 0; i < count && status == STATUS_OK; i++) {
		struct world_moved moved;
		status = fleet_get(bytes, &moved, sizeof moved);
		if (status == STATUS_OK && rank != fleet->rank)
			status = world_body_unpack(fleet->world, &moved, false);
	}
	return status;
}

static enum status get_blocks(struct sharing *sharing, int rank, struct fleet_bytes *bytes)
{
	uint32_t count;
	enum status status = fleet_get(bytes, &count, sizeof count);
	for (uint32_t i = 0; i < count && status == STATUS_OK; i++) {
		struct soil_block block;
		status = fleet_get(bytes, &block, sizeof block);
		if (status != STATUS_OK || rank == sharing->fleet->rank)
			continue;
		struct soil_block *more = fleet_grown(sharing->blocks, &sharing->room, sharing->count + 1, sizeof *more);
		if (more == NULL)
			return fail_memory("active blocks");
		sharing->blocks = more;
		sharing->blocks[sharing->count++] = block;
	}
	return status;
}

static enum status get_all(void *user, int rank, struct fleet_bytes *bytes)
{
	struct sharing *sharing = user;
	enum status status = fleet_rows_get(sharing->fleet, bytes);
	if (status == STATUS_OK)
		status = get_bodies(sharing->fleet, rank, bytes);
	return status == STATUS_OK ? get_blocks(sharing, rank, bytes) : status;
}

enum status fleet_share_record(struct fleet *fleet, enum status status)
{
	struct sharing sharing = {.fleet = fleet};
	struct fleet_told told;
	const struct fleet_wait wait = fleet_wait_begin();
	/* The exchange comes after each rank's last commit is done, so no rank is ahead by more than one commit. */
	if (status == STATUS_OK)
		status = page_cache_await_commit(world_resident(fleet->world)->cache);
	fleet_wait_end(fleet, wait);
	if (status == STATUS_OK)
		status = fleet_begin(fleet, FLEET_COMMIT, status);
	if (status == STATUS_OK)
		status = fleet_rows_put(fleet);
	if (status == STATUS_OK)
		status = put_bodies(fleet);
	if (status == STATUS_OK)
		status = put_blocks(fleet);
	status = fleet_tell(fleet, FLEET_COMMIT, status, &told, get_all, &sharing);
	if (status == STATUS_OK) /* rows are in the file before the commit that goes with them */
		status = fleet_rows_write(fleet, INFINITY);
	if (status == STATUS_OK)
		status = world_record_ranks(fleet->world, sharing.blocks, sharing.count);
	mem_free(sharing.blocks);
	return status;
}

enum status fleet_commit(struct fleet *fleet, enum status status)
{
	struct world *world = fleet->world;
	status = fleet_share_record(fleet, status);
	return status == STATUS_OK ? world_begin_commit(world) : status;
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

/* --- probes --- */

struct probing {
	struct fleet *fleet;
	struct furrow_contact *contacts;
	size_t count;
};

static enum status get_contacts(void *user, int rank, struct fleet_bytes *bytes)
{
	const struct probing *probing = user;
	uint32_t count;
	enum status status = fleet_get(bytes, &count, sizeof count);
	for (uint32_t i = 0; i < count && status == STATUS_OK; i++) {
		uint32_t at;
		struct furrow_contact contact;
		status = fleet_get(bytes, &at, sizeof at);
		if (status == STATUS_OK)
			status = fleet_get(bytes, &contact, sizeof contact);
		if (status == STATUS_OK && at >= probing->count)
			status = fail_with(STATUS_FAILED, "ranks: a contact came for a body that was not asked for; report this");
		if (status == STATUS_OK && rank != probing->fleet->rank)
			probing->contacts[at] = contact;
	}
	return status;
}

static bool is_here(const struct world *world, int32_t number)
{
	const struct body *body = world_body(world, (size_t)number);
	return body != NULL && body->kind != BODY_PATH && !body->elsewhere;
}

enum status fleet_probed(void *user, size_t count, const int32_t *numbers, struct furrow_contact *contacts, enum status status)
{
	struct fleet *fleet = user;
	struct probing probing = {fleet, contacts, count};
	struct fleet_told told;
	uint32_t here = 0;
	for (size_t i = 0; i < count; i++)
		here += is_here(fleet->world, numbers[i]);
	if (fleet->failed)
		return status;
	if (status == STATUS_OK)
		status = fleet_begin(fleet, FLEET_PROBE, status);
	if (status == STATUS_OK)
		status = fleet_put(&fleet->sent, &here, sizeof here);
	for (size_t i = 0; i < count && status == STATUS_OK; i++) {
		const uint32_t at = (uint32_t)i;
		if (!is_here(fleet->world, numbers[i]))
			continue;
		status = fleet_put(&fleet->sent, &at, sizeof at);
		if (status == STATUS_OK)
			status = fleet_put(&fleet->sent, &contacts[i], sizeof contacts[i]);
	}
	return fleet_tell(fleet, FLEET_PROBE, status, &told, get_contacts, &probing);
}
