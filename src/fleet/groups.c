#include "fleet/groups.h"

#include <string.h>

void fleet_groups_finish(struct fleet_groups *groups)
{
	mem_free(groups->items);
	key_set_finish(&groups->tiles);
	mem_free_all(groups->tile_key, groups->tile_group, groups->groups);
	key_set_finish(&groups->known);
	mem_free_all(groups->owner, groups->loads, groups->parent, groups->shares);
	*groups = (struct fleet_groups){.items = NULL};
}

void fleet_groups_clear(struct fleet_groups *groups)
{
	groups->item_count = groups->group_count = 0;
	key_set_clear(&groups->tiles);
}

enum status fleet_groups_add(struct fleet_groups *groups, const struct fleet_item *item)
{
	TRY(mem_grow(&groups->items, &groups->item_room, groups->item_count + 1, sizeof *groups->items, "groups of bodies"));
	groups->items[groups->item_count++] = *item;
	return STATUS_OK;
}

/* --- groups --- */

static uint32_t root_of(uint32_t *parent, uint32_t tile)
{
	while (parent[tile] != tile)
		tile = parent[tile] = parent[parent[tile]];
	return tile;
}

/* The smaller number becomes the root, so that roots do not depend on the order of joins. */
static void join(uint32_t *parent, uint32_t a, uint32_t b)
{
	a = root_of(parent, a);
	b = root_of(parent, b);
	if (a < b)
		parent[b] = a;
	else
		parent[a] = b;
}

static enum status number_of(struct fleet_groups *groups, uint64_t key, uint32_t *number)
{
	bool fresh;
	TRY(key_set_number(&groups->tiles, key, number, &fresh));
	if (!fresh)
		return STATUS_OK;
	if (*number >= groups->tile_room) {
		const size_t more = mem_room(groups->tile_room, *number + 1);
		TRY(mem_resize(&groups->parent, more, sizeof *groups->parent, "groups of bodies"));
		TRY(mem_resize(&groups->tile_group, more, sizeof *groups->tile_group, "groups of bodies"));
		TRY(mem_resize(&groups->tile_key, more, sizeof *groups->tile_key, "groups of bodies"));
		groups->tile_room = more;
	}
	groups->parent[*number] = *number;
	groups->tile_key[*number] = key;
	return STATUS_OK;
}

/* Joins the tiles of an item. Its `group` becomes the number of its first tile. */
static enum status join_item(struct fleet_groups *groups, struct fleet_item *item, int level)
{
	uint32_t first = 0, number = 0;
	for (uint32_t y = item->y0; y <= item->y1; y++)
		for (uint32_t x = item->x0; x <= item->x1; x++) {
			TRY(number_of(groups, tile_key((struct tile){level, x, y}), &number));
			if (x == item->x0 && y == item->y0)
				first = number;
			else
				join(groups->parent, first, number);
		}
	item->group = first;
	return STATUS_OK;
}

/* Numbers the groups in the order of their first tiles, and sets that of each tile and item. */
static enum status number_groups(struct fleet_groups *groups)
{
	for (uint32_t i = 0; i < groups->tiles.count; i++) {
		const uint32_t root = root_of(groups->parent, i);
		if (root != i) { /* a root has the smallest number of its group, so it came before */
			groups->tile_group[i] = groups->tile_group[root];
			continue;
		}
		TRY(mem_grow(&groups->groups, &groups->group_room, groups->group_count + 1, sizeof *groups->groups, "groups of bodies"));
		groups->tile_group[i] = (uint32_t)groups->group_count;
		groups->groups[groups->group_count++] = (struct fleet_group){0, FLEET_NONE};
	}
	for (size_t i = 0; i < groups->item_count; i++) {
		struct fleet_item *item = &groups->items[i];
		item->group = groups->tile_group[item->group];
		groups->groups[item->group].weight += item->weight;
	}
	return STATUS_OK;
}

/* --- ranks --- */

/* Gives each group to the rank that has most of its work, at equal work to the lowest. */
static enum status follow_owners(struct fleet_groups *groups, int ranks)
{
	const size_t count = groups->group_count * (size_t)ranks;
	TRY(mem_grow(&groups->shares, &groups->share_room, count + 1, sizeof *groups->shares, "groups of bodies"));
	memset(groups->shares, 0, count * sizeof *groups->shares);
	for (size_t i = 0; i < groups->item_count; i++) {
		const struct fleet_item *item = &groups->items[i];
		if (item->owner >= 0)
			groups->shares[item->group * (size_t)ranks + (size_t)item->owner] += 1 + (uint64_t)item->weight;
	}
	for (size_t g = 0; g < groups->group_count; g++) {
		uint64_t most = 0;
		for (int r = 0; r < ranks; r++) {
			const uint64_t share = groups->shares[g * (size_t)ranks + (size_t)r];
			if (share > most) {
				most = share;
				groups->groups[g].rank = r;
			}
		}
	}
	return STATUS_OK;
}

/* Gives groups that nobody has to ranks, as many as each should have, in the order of the scene. So those that begin beside each other in
 * the scene are on one rank. */
static void give_new(struct fleet_groups *groups, int ranks)
{
	uint64_t total = 0, given = 0;
	for (size_t g = 0; g < groups->group_count; g++)
		total += groups->groups[g].rank == FLEET_NONE ? 1 + (uint64_t)groups->groups[g].weight : 0;
	for (size_t g = 0; g < groups->group_count; g++) {
		struct fleet_group *group = &groups->groups[g];
		if (group->rank != FLEET_NONE)
			continue;
		group->rank = (int32_t)(given * (uint64_t)ranks / total);
		given += 1 + (uint64_t)group->weight;
	}
}

static void add_loads(struct fleet_groups *groups, int ranks)
{
	memset(groups->loads, 0, (size_t)ranks * sizeof *groups->loads);
	for (size_t g = 0; g < groups->group_count; g++)
		groups->loads[groups->groups[g].rank] += groups->groups[g].weight;
}

/* Moves groups from ranks that have more than an eighth above the mean to the rank that has least. */
static void balance(struct fleet_groups *groups, int ranks)
{
	uint64_t total = 0;
	for (int r = 0; r < ranks; r++)
		total += groups->loads[r];
	const uint64_t mean = total / (uint64_t)ranks, most = mean + mean / 8 + 1;
	for (size_t g = 0; g < groups->group_count; g++) {
		struct fleet_group *group = &groups->groups[g];
		int least = 0;
		if (groups->loads[group->rank] <= most || group->weight == 0)
			continue;
		for (int r = 1; r < ranks; r++)
			least = groups->loads[r] < groups->loads[least] ? r : least;
		if (groups->loads[least] + group->weight > most)
			continue;
		groups->loads[group->rank] -= group->weight;
		groups->loads[least] += group->weight;
		group->rank = least;
	}
}

enum status fleet_groups_make(struct fleet_groups *groups, int level, int ranks, bool balances)
{
	groups->group_count = 0;
	if (groups->loads == NULL)
		TRY(mem_zeroed(&groups->loads, (size_t)ranks, sizeof *groups->loads, "groups of bodies"));
	for (size_t i = 0; i < groups->item_count; i++)
		TRY(join_item(groups, &groups->items[i], level));
	TRY(number_groups(groups));
	TRY(follow_owners(groups, ranks));
	give_new(groups, ranks);
	add_loads(groups, ranks);
	if (balances)
		balance(groups, ranks);
	return STATUS_OK;
}

enum status fleet_groups_settle(struct fleet_groups *groups)
{
	for (size_t i = 0; i < groups->item_count; i++)
		groups->items[i].owner = groups->groups[groups->items[i].group].rank;
	for (size_t i = 0; i < groups->tiles.count; i++) {
		uint32_t number;
		bool fresh;
		TRY(key_set_number(&groups->known, groups->tile_key[i], &number, &fresh));
		TRY(mem_grow(&groups->owner, &groups->owner_room, (size_t)number + 1, sizeof *groups->owner, "groups of bodies"));
		groups->owner[number] = groups->groups[groups->tile_group[i]].rank;
	}
	return STATUS_OK;
}

int32_t fleet_groups_owner(const struct fleet_groups *groups, uint64_t key)
{
	uint32_t number;
	return key_set_find(&groups->known, key, &number) ? groups->owner[number] : FLEET_NONE;
}

int32_t fleet_groups_rank(const struct fleet_groups *groups, uint64_t key)
{
	uint32_t number;
	return key_set_find(&groups->tiles, key, &number) ? groups->groups[groups->tile_group[number]].rank : FLEET_NONE;
}
