/*
 * Soil in flight. A grain belongs to the rank that has the ground on which it may come down before the next plan. So it names the tiles of that ground, as an active
 * block does, and goes where they go. Scenes that throw soil make a plan before each step (horizon_of in step.c).
 *
 * One process has room for WORLD_THROWN_MOST grains; what is more flies with the one that left last. Ranks cannot tell which one that is, so they end there. Where bodies
 * carry, a fall may be one grain as soon as half as many fly, so ranks end there.
 */
#include "fleet/internal.h"

#include <stdlib.h>

/* --- who has the ground --- */

static bool tiles_of_grain(const struct fleet *fleet, size_t number, struct fleet_item *item)
{
	return fleet_tiles_of(fleet, world_grain_area(fleet->world, number, fleet->until), item);
}

static int by_tiles(const void *a, const void *b)
{
	const struct fleet_link *p = a, *q = b;
	const uint32_t first[] = {p->y0, p->x0, p->y1, p->x1}, second[] = {q->y0, q->x0, q->y1, q->x1};
	for (int k = 0; k < 4; k++)
		if (first[k] != second[k])
			return first[k] < second[k] ? -1 : 1;
	return 0;
}

enum status fleet_grains_put_links(struct fleet *fleet)
{
	const size_t count = world_grains_here(fleet->world);
	const uint64_t most = world_grains_most_here(fleet->world);
	size_t links = 0;
	uint32_t told = 0;
	TRY(mem_grow(&fleet->grain_links, &fleet->grain_link_room, count, sizeof *fleet->grain_links, "soil in flight"));
	for (size_t i = 0; i < count; i++) {
		struct fleet_item item;
		if (tiles_of_grain(fleet, i, &item))
			fleet->grain_links[links++] = (struct fleet_link){item.x0, item.y0, item.x1, item.y1, 1};
	}
	if (links > 1)
		qsort(fleet->grain_links, links, sizeof *fleet->grain_links, by_tiles);
	for (size_t i = 0; i < links; i++)
		if (i == 0 || by_tiles(&fleet->grain_links[i], &fleet->grain_links[told - 1]) != 0)
			fleet->grain_links[told++] = fleet->grain_links[i];
	TRY(fleet_put(&fleet->sent, &most, sizeof most));
	TRY(fleet_put(&fleet->sent, &told, sizeof told));
	return fleet_put(&fleet->sent, fleet->grain_links, told * sizeof *fleet->grain_links);
}

enum status fleet_grains_get_links(struct fleet *fleet, int rank, struct fleet_bytes *bytes)
{
	uint64_t most;
	uint32_t links;
	TRY(fleet_get(bytes, &most, sizeof most));
	fleet->grains = rank == 0 ? most : fleet->grains + most;
	TRY(fleet_get(bytes, &links, sizeof links));
	for (uint32_t i = 0; i < links; i++) {
		struct fleet_link link;
		TRY(fleet_get(bytes, &link, sizeof link));
		TRY(fleet_groups_add(&fleet->groups, &(struct fleet_item){link.x0, link.y0, link.x1, link.y1, rank, link.weight, 0}));
	}
	return STATUS_OK;
}

enum status fleet_grains_check(struct fleet *fleet)
{
	const uint64_t most = world_carries(fleet->world) ? WORLD_THROWN_MOST / 2 : WORLD_THROWN_MOST;
	if (fleet->grains <= most)
		return STATUS_OK;
	fleet->failed = true; /* all ranks know it */
	world_tear(fleet->world);
	return fail_with(STATUS_FAILED, "redistribute.thrown: ranks: more than %d grains fly at once, and then all of them would have to be on one rank; drive with one "
					"process, or take thrown away", (int)most);
}

enum status fleet_grains_allowed(const struct fleet *fleet)
{
	const struct world *world = fleet->world;
	if (world_grains_most(world) == 0 || !world_carries(world) || world_scene(world)->soil_count < 2)
		return STATUS_OK;
	return fail_with(STATUS_INPUT, "redistribute.thrown: ranks: a grain that comes down on a body with carry has the soil that was thrown most, and a rank knows only its own share of "
				       "that; drive with one process, or over one soil, or take thrown or carry away");
}

/* --- moving --- */

/* Finds the rank of each grain, and counts those that go to each rank. Grains beyond the terrain stay. */
static void find_ranks(const struct fleet *fleet, size_t count, int32_t *rank, bool *stays, uint32_t *counts)
{
	const int level = world_resident(fleet->world)->level;
	for (size_t i = 0; i < count; i++) {
		struct fleet_item item;
		rank[i] = tiles_of_grain(fleet, i, &item) ? fleet_groups_rank(&fleet->groups, tile_key((struct tile){level, item.x0, item.y0})) : fleet->rank;
		stays[i] = rank[i] == fleet->rank || rank[i] == FLEET_NONE;
		if (!stays[i])
			counts[rank[i]]++;
	}
}

static enum status put_all(struct fleet *fleet, struct fleet_bytes *out, size_t count, const int32_t *rank, const bool *stays, const uint32_t *counts)
{
	for (int r = 0; r < fleet->ranks; r++)
		if (out[r].size > 0)
			TRY(fleet_put(&out[r], &counts[r], sizeof counts[r]));
	for (size_t i = 0; i < count; i++) {
		struct world_grain_moved moved;
		if (stays[i])
			continue;
		world_grain_pack(fleet->world, i, &moved);
		TRY(fleet_put(&out[rank[i]], &moved, sizeof moved));
	}
	return STATUS_OK;
}

enum status fleet_grains_move(struct fleet *fleet, struct fleet_bytes *out)
{
	const size_t count = world_grains_here(fleet->world);
	uint32_t *counts = mem_calloc((size_t)fleet->ranks, sizeof *counts);
	int32_t *rank = mem_alloc(count + 1, sizeof *rank);
	bool *stays = mem_alloc(count + 1, sizeof *stays);
	enum status status;
	TRY_OR(done, counts != NULL && rank != NULL && stays != NULL ? STATUS_OK : fail_memory("soil in flight"));
	find_ranks(fleet, count, rank, stays, counts);
	TRY_OR(done, put_all(fleet, out, count, rank, stays, counts));
	if (count > 0)
		world_grains_keep(fleet->world, stays);
done:
	mem_free_all(counts, rank, stays);
	return status;
}

enum status fleet_grains_take(struct fleet *fleet, struct fleet_bytes *in)
{
	uint32_t count;
	TRY(fleet_get(in, &count, sizeof count));
	for (uint32_t i = 0; i < count; i++) {
		struct world_grain_moved moved;
		TRY(fleet_get(in, &moved, sizeof moved));
		TRY(world_grain_unpack(fleet->world, &moved));
	}
	return STATUS_OK;
}

/* --- the record --- */

enum status fleet_grains_put_share(struct fleet *fleet)
{
	const struct world *world = fleet->world;
	const uint64_t most = world_grains_most_here(fleet->world);
	const uint32_t count = (uint32_t)world_grains_here(world);
	int64_t sums[WORLD_THROWN_SUMS];
	TRY(fleet_put(&fleet->sent, &most, sizeof most));
	if (world_grains_most(world) == 0)
		return STATUS_OK;
	world_thrown_share(world, sums);
	TRY(fleet_put(&fleet->sent, sums, sizeof sums));
	TRY(fleet_put(&fleet->sent, &count, sizeof count));
	for (uint32_t i = 0; i < count; i++) {
		struct world_grain_moved moved;
		world_grain_pack(world, i, &moved);
		TRY(fleet_put(&fleet->sent, &moved, sizeof moved));
	}
	return STATUS_OK;
}

enum status fleet_grains_get_share(struct fleet *fleet, int rank, struct fleet_bytes *bytes)
{
	struct world *world = fleet->world;
	uint64_t most;
	uint32_t count;
	int64_t sums[WORLD_THROWN_SUMS];
	TRY(fleet_get(bytes, &most, sizeof most));
	fleet->grains = rank == 0 ? most : fleet->grains + most;
	if (rank == 0)
		world_thrown_others_begin(world);
	if (world_grains_most(world) == 0)
		return STATUS_OK;
	TRY(fleet_get(bytes, sums, sizeof sums));
	if (rank != fleet->rank)
		world_thrown_others_sums(world, sums);
	TRY(fleet_get(bytes, &count, sizeof count));
	for (uint32_t i = 0; i < count; i++) {
		struct world_grain_moved moved;
		TRY(fleet_get(bytes, &moved, sizeof moved));
		if (rank != fleet->rank)
			TRY(world_thrown_others_grain(world, &moved));
	}
	return STATUS_OK;
}
