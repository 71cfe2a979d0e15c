/*
 * LRU at every size in one pass (Mattson and others, 1970): an access hits with n slots if at most n
 * different tiles, its own among them, were asked for since it last was.
 *
 * Each tile's last access has a place in an order; a tree of sums (Fenwick's) over the places counts
 * those that come after another. When the places run out they are given anew to the tiles that are
 * there, of which there are at most half as many.
 */
#include "sim/internal.h"

struct order {
	uint32_t *sums;  /* the tree, from 1 */
	uint32_t *tiles; /* of each place */
	uint32_t *place; /* of each tile; 0: never asked for */
	uint32_t room, used, live;
};

static void mark(struct order *order, uint32_t place, uint32_t by)
{
	for (; place <= order->room; place += place & -place)
		order->sums[place] += by; /* by -1: modulo 2^32 */
}

static uint32_t marked_to(const struct order *order, uint32_t place)
{
	uint32_t sum = 0;
	for (; place > 0; place &= place - 1)
		sum += order->sums[place];
	return sum;
}

static void renumber(struct order *order)
{
	uint32_t used = 0;
	for (uint32_t i = 1; i <= order->used; i++) {
		uint32_t tile = order->tiles[i];
		if (order->place[tile] != i)
			continue;
		order->tiles[++used] = tile;
		order->place[tile] = used;
	}
	order->used = used;
	for (uint32_t i = 1; i <= order->room; i++)
		order->sums[i] = i <= used;
	for (uint32_t i = 1; i <= order->room; i++) {
		uint32_t above = i + (i & -i);
		if (above <= order->room)
			order->sums[above] += order->sums[i];
	}
}

/* How many different tiles since this one was last asked for, itself included; 0: it never was. */
static uint32_t touch(struct order *order, uint32_t tile)
{
	uint32_t depth = 0;
	if (order->used == order->room)
		renumber(order);
	if (order->place[tile] != 0) {
		depth = order->live - marked_to(order, order->place[tile] - 1);
		mark(order, order->place[tile], UINT32_MAX);
	} else {
		order->live++;
	}
	order->place[tile] = ++order->used;
	order->tiles[order->used] = tile;
	mark(order, order->used, 1);
	return depth;
}

enum status sim_lru(struct sim_run *run, const uint32_t *slots, size_t count, uint64_t *misses)
{
	const struct sim_accesses *accesses = run->accesses;
	size_t tiles = (size_t)accesses->tile_count, room = 2 * tiles + 2;
	enum status status = STATUS_OK;
	struct order order = {
		.sums = mem_calloc(room + 1, sizeof *order.sums),
		.tiles = mem_calloc(room + 1, sizeof *order.tiles),
		.place = mem_calloc(tiles + 1, sizeof *order.place),
		.room = (uint32_t)room,
	};
	uint64_t *at_depth = mem_calloc(tiles + 1, sizeof *at_depth); /* accesses */
	if (order.sums == NULL || order.tiles == NULL || order.place == NULL || at_depth == NULL)
		TRY_OR(done, fail_memory("the simulated cache"));
	for (size_t i = 0; i < accesses->count; i++) {
		TRY_OR(done, sim_tick(run, i));
		at_depth[touch(&order, accesses->tiles[i])]++;
	}
	for (size_t i = 0; i < count; i++) {
		misses[i] = accesses->count;
		for (size_t depth = 1; depth <= tiles && depth <= slots[i]; depth++)
			misses[i] -= at_depth[depth];
	}
done:
	mem_free_all(order.sums, order.tiles, order.place, at_depth);
	return status;
}
