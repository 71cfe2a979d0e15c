/*
 * What changes its rank before a step: tiles with their newest planes, bodies, and blocks where soil slides. All that goes from one rank to
 * another goes as one message:
 *
 *     tiles:   count, then for each: key, planes, packed size, LZ4 block of the planes
 *     bodies:  count, then struct world_moved of each, and the soil aboard it (aboard.c)
 *     blocks:  count, then struct soil_block of each
 *     grains:  count, then struct world_grain_moved of each
 *
 * Both ranks know from the groups that there is a message. A rank that cannot make one sends an empty message, and its failure is told in
 * the next exchange.
 */
#include "fleet/internal.h"

#include <lz4.h>
#include <string.h>

struct moving {
	struct fleet *fleet;
	int to;                  /* the rank that the present message goes to */
	struct fleet_bytes *out; /* by rank */
	bool *comes;             /* by rank: a message comes from it */
	uint64_t *keys;          /* tiles that go to `to` */
	size_t count, room;
	char *packed;            /* room for a packed tile; NULL: nothing goes from here */
};

/* --- what goes where --- */

static int32_t new_rank(const struct fleet *fleet, const struct fleet_item *item)
{
	return fleet->groups.groups[item->group].rank;
}

/* Finds from which ranks messages come, and to which they go. */
static void find_pairs(struct moving *moving, bool *goes)
{
	const struct fleet *fleet = moving->fleet;
	const struct fleet_groups *groups = &fleet->groups;
	const int32_t me = fleet->rank;
	for (size_t i = 0; i < groups->item_count; i++) {
		const int32_t from = groups->items[i].owner, to = new_rank(fleet, &groups->items[i]);
		if (from == me && to != me)
			goes[to] = true;
		if (from != me && from != FLEET_NONE && to == me)
			moving->comes[from] = true;
	}
	for (size_t i = 0; i < groups->tiles.count; i++) {
		const int32_t from = fleet_groups_owner(groups, groups->tile_key[i]), to = groups->groups[groups->tile_group[i]].rank;
		if (from == me && to != me)
			goes[to] = true;
		if (from != me && from != FLEET_NONE && to == me)
			moving->comes[from] = true;
	}
}

/* --- tiles --- */

static enum status list_tiles(struct moving *moving)
{
	const struct fleet_groups *groups = &moving->fleet->groups;
	moving->count = 0;
	for (size_t i = 0; i < groups->tiles.count; i++) {
		const uint64_t key = groups->tile_key[i];
		if (groups->groups[groups->tile_group[i]].rank != moving->to || fleet_groups_owner(groups, key) != moving->fleet->rank ||
		    !fleet_is_changed(moving->fleet, key))
			continue;
		TRY(mem_grow(&moving->keys, &moving->room, moving->count + 1, sizeof *moving->keys, "tiles that move"));
		moving->keys[moving->count++] = key;
	}
	return STATUS_OK;
}

static enum status put_tile(void *user, struct tile tile, unsigned planes, const void *bytes)
{
	struct moving *moving = user;
	struct fleet_bytes *out = &moving->out[moving->to];
	const size_t size = resident_pages_moved_bytes(world_resident(moving->fleet->world)->pages);
	const uint64_t key = tile_key(tile);
	int32_t packed = 0;
	if (planes != 0) {
		packed = LZ4_compress_default(bytes, moving->packed, (int)size, LZ4_compressBound((int)size));
		if (packed <= 0)
			return fail_with(STATUS_FAILED, "ranks: a tile cannot be packed; report this");
	}
	const uint32_t mask = planes;
	moving->fleet->tiles_moved++;
	TRY(fleet_put(out, &key, sizeof key));
	TRY(fleet_put(out, &mask, sizeof mask));
	TRY(fleet_put(out, &packed, sizeof packed));
	TRY(fleet_put(out, moving->packed, (size_t)packed));
	return fleet_note_changed(moving->fleet, key, false);
}

static enum status take_tiles(struct fleet *fleet, struct fleet_bytes *in, char *planes)
{
	const size_t size = resident_pages_moved_bytes(world_resident(fleet->world)->pages);
	uint32_t count;
	TRY(fleet_get(in, &count, sizeof count));
	for (uint32_t i = 0; i < count; i++) {
		uint64_t key;
		uint32_t mask;
		int32_t packed;
		TRY(fleet_get(in, &key, sizeof key));
		TRY(fleet_get(in, &mask, sizeof mask));
		TRY(fleet_get(in, &packed, sizeof packed));
		if (packed < 0 || (size_t)packed > in->size - in->at ||
		    (mask != 0 && LZ4_decompress_safe(in->bytes + in->at, planes, packed, (int)size) != (int)size))
			return fail_with(STATUS_FAILED, "ranks: a tile that another rank sent is damaged; start all ranks with the same version of furrow");
		in->at += (size_t)packed;
		TRY(world_tile_came(fleet->world, tile_from_key(key), mask, planes));
		TRY(fleet_note_changed(fleet, key, true));
	}
	return STATUS_OK;
}

/* --- bodies --- */

/* Items of bodies come first, in the order of the bodies that have an area. */
static enum status put_bodies(struct moving *moving)
{
	struct fleet *fleet = moving->fleet;
	struct world *world = fleet->world;
	struct fleet_bytes *out = &moving->out[moving->to];
	uint32_t count = 0;
	const size_t at = out->size;
	TRY(fleet_put(out, &count, sizeof count));
	for (size_t i = 0; i < fleet->owner_count; i++) {
		struct world_moved moved;
		if (fleet->next[i] != moving->to || fleet->owners[i] != fleet->rank || !world_ranked(world, i))
			continue;
		world_body_pack(world, i, &moved);
		world_body_here(world, i, false);
		fleet->bodies_moved++;
		TRY(fleet_put(out, &moved, sizeof moved));
		if (world_carried_moves(world, i) > 0)
			TRY(fleet_aboard_put(fleet, out, i));
		count++;
	}
	memcpy(out->bytes + at, &count, sizeof count);
	return STATUS_OK;
}

static enum status take_bodies(struct fleet *fleet, struct fleet_bytes *in)
{
	uint32_t count;
	TRY(fleet_get(in, &count, sizeof count));
	for (uint32_t i = 0; i < count; i++) {
		struct world_moved moved;
		TRY(fleet_get(in, &moved, sizeof moved));
		TRY(world_body_unpack(fleet->world, &moved, true));
		if (world_carried_moves(fleet->world, (size_t)moved.number) > 0)
			TRY(fleet_aboard_get(fleet, in, true, true));
	}
	return STATUS_OK;
}

/* --- blocks --- */

static bool block_stays(void *user, struct soil_block block)
{
	struct moving *moving = user;
	const struct fleet *fleet = moving->fleet;
	const struct fleet_item item = fleet_block_item(fleet, block, fleet->intervals);
	return fleet_groups_rank(&fleet->groups, tile_key((struct tile){world_resident(fleet->world)->level, item.x0, item.y0})) == fleet->rank;
}

/* Appends the blocks that go to each rank to the messages. */
static enum status put_each_block(struct moving *moving, const struct soil_block *blocks, size_t count, uint32_t *counts)
{
	struct fleet *fleet = moving->fleet;
	for (int pass = 0; pass < 2; pass++) {
		for (int r = 0; r < fleet->ranks && pass == 1; r++)
			if (moving->out[r].size > 0)
				TRY(fleet_put(&moving->out[r], &counts[r], sizeof counts[r]));
		for (size_t i = 0; i < count; i++) {
			const struct fleet_item item = fleet_block_item(fleet, blocks[i], fleet->intervals);
			const int32_t rank = fleet_groups_rank(&fleet->groups, tile_key((struct tile){world_resident(fleet->world)->level, item.x0, item.y0}));
			if (rank == fleet->rank || rank == FLEET_NONE)
				continue;
			fleet->blocks_moved += pass;
			if (pass == 0)
				counts[rank]++;
			else
				TRY(fleet_put(&moving->out[rank], &blocks[i], sizeof blocks[i]));
		}
	}
	return STATUS_OK;
}

static enum status put_blocks(struct moving *moving)
{
	struct fleet *fleet = moving->fleet;
	const struct soil_block *blocks = NULL;
	size_t count = 0;
	bool any = false;
	uint32_t *counts = mem_calloc((size_t)fleet->ranks, sizeof *counts);
	TRY_MEM(counts, "blocks that move");
	enum status status;
	TRY_OR(done, world_active_blocks(fleet->world, &blocks, &count));
	TRY_OR(done, put_each_block(moving, blocks, count, counts));
	for (int r = 0; r < fleet->ranks; r++)
		any = any || counts[r] > 0;
	if (any)
		TRY_OR(done, world_active_keep(fleet->world, block_stays, moving));
done:
	mem_free(counts);
	return status;
}

static enum status take_blocks(struct fleet *fleet, struct fleet_bytes *in)
{
	uint32_t count;
	TRY(fleet_get(in, &count, sizeof count));
	for (uint32_t i = 0; i < count; i++) {
		struct soil_block block;
		TRY(fleet_get(in, &block, sizeof block));
		TRY(world_wake_block(fleet->world, block));
	}
	return STATUS_OK;
}

/* --- all of it --- */

static enum status pack(struct moving *moving, const bool *goes)
{
	struct fleet *fleet = moving->fleet;
	bool any = false;
	for (int r = 0; r < fleet->ranks; r++)
		any = any || goes[r];
	if (!any)
		return STATUS_OK;
	moving->packed = mem_alloc((size_t)LZ4_compressBound((int)resident_pages_moved_bytes(world_resident(fleet->world)->pages)) + 1, 1);
	TRY_MEM(moving->packed, "tiles that move");
	for (int r = 0; r < fleet->ranks; r++) {
		if (!goes[r])
			continue;
		moving->to = r;
		TRY(list_tiles(moving));
		const uint32_t count = (uint32_t)moving->count;
		TRY(fleet_put(&moving->out[r], &count, sizeof count));
		TRY(resident_pages_take(world_resident(fleet->world)->pages, moving->keys, moving->count, put_tile, moving));
		TRY(put_bodies(moving));
	}
	TRY(put_blocks(moving));
	return fleet_grains_move(fleet, moving->out);
}

static enum status unpack(struct fleet *fleet, const struct fleet_message *message, char *planes)
{
	struct fleet_bytes in = {.bytes = message->bytes, .size = message->size};
	if (message->size == 0) {
		world_tear(fleet->world);
		return fail_with(STATUS_FAILED, "rank %d: it could not send its ground; look at what that rank says", message->rank);
	}
	TRY(take_tiles(fleet, &in, planes));
	TRY(take_bodies(fleet, &in));
	TRY(take_blocks(fleet, &in));
	return fleet_grains_take(fleet, &in);
}

/* Sets where each body is from now on. Bodies that nobody had yet begin here, or elsewhere. */
static void settle_bodies(struct fleet *fleet)
{
	for (size_t i = 0; i < fleet->owner_count; i++) {
		if (!world_ranked(fleet->world, i))
			continue;
		world_body_here(fleet->world, i, fleet->next[i] == fleet->rank);
		fleet->owners[i] = fleet->next[i];
	}
}

/* Finds the next rank of each body. Items of bodies come first, in the order of bodies. */
static void find_next(struct fleet *fleet)
{
	size_t at = 0;
	if (mem_grow(&fleet->next, &fleet->next_room, fleet->owner_count, sizeof *fleet->next, "the ranks of bodies") != STATUS_OK)
		fleet_comm_give_up("out of memory");
	for (size_t i = 0; i < fleet->owner_count; i++) {
		fleet->next[i] = fleet->owners[i];
		if (at < fleet->planned_count && fleet->planned_bodies[at] == i)
			fleet->next[i] = new_rank(fleet, &fleet->groups.items[at++]);
	}
}

static enum status exchange(struct moving *moving, const bool *goes, enum status status)
{
	struct fleet *fleet = moving->fleet;
	const size_t ranks = (size_t)fleet->ranks, size = resident_pages_moved_bytes(world_resident(fleet->world)->pages);
	struct fleet_message *out = mem_calloc(ranks, sizeof *out), *in = mem_calloc(ranks, sizeof *in);
	char *planes = mem_alloc(size > 0 ? size : 1, 1);
	size_t out_count = 0, in_count = 0;
	if (out == NULL || in == NULL || planes == NULL) {
		mem_free_all(out, in, planes);
		fleet_comm_give_up("out of memory");
	}
	for (int r = 0; r < fleet->ranks; r++) {
		if (goes[r]) {
			out[out_count++] = (struct fleet_message){r, moving->out[r].bytes, status == STATUS_OK ? moving->out[r].size : 0};
			fleet->bytes_moved += (int64_t)moving->out[r].size;
		}
		if (moving->comes[r])
			in[in_count++].rank = r;
	}
	const struct fleet_wait wait = fleet_wait_begin();
	fleet_comm_move(out, out_count, in, in_count);
	fleet_wait_end(fleet, wait);
	/* In the order of ranks, so that what comes is the same in every run. */
	for (size_t i = 0; i < in_count; i++) {
		if (status == STATUS_OK)
			status = unpack(fleet, &in[i], planes);
		mem_free(in[i].bytes);
	}
	mem_free_all(out, in, planes);
	return status;
}

enum status fleet_move(struct fleet *fleet, enum status status)
{
	const size_t ranks = (size_t)fleet->ranks;
	bool *goes = mem_calloc(ranks, sizeof *goes);
	struct moving moving = {
		.fleet = fleet,
		.out = mem_calloc(ranks, sizeof *moving.out),
		.comes = mem_calloc(ranks, sizeof *moving.comes),
	};
	if (goes == NULL || moving.out == NULL || moving.comes == NULL)
		fleet_comm_give_up("out of memory");
	find_next(fleet);
	find_pairs(&moving, goes);
	if (status == STATUS_OK)
		status = pack(&moving, goes);
	bool any = false;
	for (int r = 0; r < fleet->ranks; r++)
		any = any || goes[r] || moving.comes[r];
	TRY_OR(done, any ? exchange(&moving, goes, status) : status);
	settle_bodies(fleet);
	TRY_OR(done, fleet_groups_settle(&fleet->groups));
done:
	for (int r = 0; r < fleet->ranks; r++)
		mem_free(moving.out[r].bytes);
	mem_free_all(moving.out, moving.comes, moving.keys, moving.packed, goes);
	return status;
}
