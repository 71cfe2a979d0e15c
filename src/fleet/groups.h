/*
 * Which rank computes what in a step. Pure: every rank computes the same from what all ranks know.
 *
 * An item is a body, or some blocks where soil slides. It names the tiles that it may touch in the step. Items that share a tile are one
 * group, and so are those that are joined by others. A group belongs to one rank, with all its tiles. So what a step does in one group
 * does not depend on any other, and a group's rank does it in the scene's order.
 */
#ifndef FURROW_FLEET_GROUPS_H
#define FURROW_FLEET_GROUPS_H

#include "base/base.h"
#include "base/key_set.h"
#include "base/tile.h"

#define FLEET_NONE (-1) /* no rank */

struct fleet_item {
	uint32_t x0, y0, x1, y1; /* tiles of the working level, both ends included */
	int32_t owner;           /* the rank that has it; FLEET_NONE: none yet */
	uint32_t weight;         /* how much work it is */
	uint32_t group;          /* fleet_groups_make */
};

struct fleet_groups {
	/* The present step. */
	struct fleet_item *items;
	size_t item_count, item_room;
	struct key_set tiles;    /* keys of all tiles of items, by number: */
	uint64_t *tile_key;
	uint32_t *tile_group;
	struct fleet_group {
		uint32_t weight;
		int32_t rank;    /* the one that it belongs to */
	} *groups;
	size_t group_count;
	/* All steps so far. */
	struct key_set known;    /* tiles that have had an owner, by number: */
	int32_t *owner;
	size_t owner_room;
	uint64_t *loads;         /* of each rank, in the present step */
	/* scratch */
	uint32_t *parent;
	size_t tile_room, group_room; /* tile_room: of the three lists by a tile's number */
	uint64_t *shares;
	size_t share_room;
};

void fleet_groups_finish(struct fleet_groups *groups);
void fleet_groups_clear(struct fleet_groups *groups); /* removes the items of the last step */
enum status fleet_groups_add(struct fleet_groups *groups, const struct fleet_item *item) FURROW_CHECKED;
/* Makes groups of the items and gives each a rank: the one that has most of its work already. `balances`: where ranks have much more work
 * than others, groups move to others. Does not change owners. */
enum status fleet_groups_make(struct fleet_groups *groups, int level, int ranks, bool balances) FURROW_CHECKED;
/* The tiles and items of each group belong to its rank from now on. */
enum status fleet_groups_settle(struct fleet_groups *groups) FURROW_CHECKED;
/* Returns the rank that has a tile; FLEET_NONE: no rank ever had it. */
int32_t fleet_groups_owner(const struct fleet_groups *groups, uint64_t key);
/* Returns the rank to which a tile belongs in the present step; FLEET_NONE: no item names it. */
int32_t fleet_groups_rank(const struct fleet_groups *groups, uint64_t key);

#endif
