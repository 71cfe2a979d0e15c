/* Groups of bodies that share tiles, and the ranks that they get: against a plain second way, on random items. */
#include "../support.h"
#include "../support/program.h"
#include "fleet/groups.h"

#define LEVEL (-3)
enum { MOST = 60, SIDE = 24 };

static uint32_t state = 1;

static uint32_t next(uint32_t below)
{
	state = state * 1664525u + 1013904223u;
	return (state >> 8) % below;
}

static bool share(const struct fleet_item *a, const struct fleet_item *b)
{
	return a->x0 <= b->x1 && b->x0 <= a->x1 && a->y0 <= b->y1 && b->y0 <= a->y1;
}

/* together[i][j]: items i and j are joined, perhaps by others. */
static void join_all(const struct fleet_item *items, size_t count, bool together[MOST][MOST])
{
	for (size_t i = 0; i < count; i++)
		for (size_t j = 0; j < count; j++)
			together[i][j] = share(&items[i], &items[j]);
	for (size_t k = 0; k < count; k++)
		for (size_t i = 0; i < count; i++)
			for (size_t j = 0; j < count; j++)
				together[i][j] = together[i][j] || (together[i][k] && together[k][j]);
}

static void make_items(struct fleet_item *items, size_t count, int ranks)
{
	for (size_t i = 0; i < count; i++) {
		const uint32_t x = next(SIDE), y = next(SIDE);
		items[i] = (struct fleet_item){x, y, x + next(3), y + next(2), (int32_t)next((uint32_t)ranks + 1) - 1, 1 + next(4), 0};
	}
}

static void add_all(struct fleet_groups *groups, const struct fleet_item *items, size_t count)
{
	fleet_groups_clear(groups);
	for (size_t i = 0; i < count; i++)
		assert_int_equal(fleet_groups_add(groups, &items[i]), STATUS_OK);
}

static void items_that_share_tiles_are_one_group(void **test)
{
	static bool together[MOST][MOST];
	struct fleet_item items[MOST];
	struct fleet_groups groups = {.items = NULL};
	for (int turn = 0; turn < 300; turn++) {
		const size_t count = 1 + next(MOST - 1);
		make_items(items, count, 3);
		join_all(items, count, together);
		add_all(&groups, items, count);
		assert_int_equal(fleet_groups_make(&groups, LEVEL, 3, turn % 2 == 0), STATUS_OK);
		for (size_t i = 0; i < count; i++)
			for (size_t j = 0; j < count; j++)
				assert_int_equal(groups.items[i].group == groups.items[j].group, together[i][j]);
		uint64_t all = 0, loads = 0;
		for (size_t i = 0; i < count; i++) {
			const struct fleet_item *item = &groups.items[i];
			const int32_t rank = groups.groups[item->group].rank;
			assert_in_range(rank, 0, 2);
			all += item->weight;
			for (uint32_t y = item->y0; y <= item->y1; y++)
				for (uint32_t x = item->x0; x <= item->x1; x++)
					assert_int_equal(fleet_groups_rank(&groups, tile_key((struct tile){LEVEL, x, y})), rank);
		}
		for (int r = 0; r < 3; r++)
			loads += groups.loads[r];
		assert_int_equal(all, loads);
	}
	fleet_groups_finish(&groups);
}

/* Without balancing, a group goes to the rank that had most of it, and tiles of other groups keep their owner. */
static void groups_follow_their_owners(void **test)
{
	struct fleet_item items[MOST];
	struct fleet_groups groups = {.items = NULL};
	make_items(items, MOST, 4);
	for (int step = 0; step < 40; step++) {
		add_all(&groups, items, MOST);
		assert_int_equal(fleet_groups_make(&groups, LEVEL, 4, false), STATUS_OK);
		for (size_t g = 0; g < groups.group_count; g++) {
			uint64_t shares[4] = {0};
			for (size_t i = 0; i < MOST; i++)
				if (groups.items[i].group == g && items[i].owner >= 0)
					shares[items[i].owner] += 1 + items[i].weight;
			for (int r = 0; r < 4; r++)
				assert_true(shares[groups.groups[g].rank] >= shares[r]);
		}
		const uint64_t away = tile_key((struct tile){LEVEL, 1000, 1000});
		assert_int_equal(fleet_groups_owner(&groups, away), FLEET_NONE);
		assert_int_equal(fleet_groups_settle(&groups), STATUS_OK);
		for (size_t i = 0; i < MOST; i++) {
			struct fleet_item *item = &items[i];
			item->owner = groups.items[i].owner;
			assert_int_equal(fleet_groups_owner(&groups, tile_key((struct tile){LEVEL, item->x0, item->y0})), item->owner);
			const uint32_t by = next(2);
			item->x0 += by;
			item->x1 += by;
		}
	}
	fleet_groups_finish(&groups);
}

static void work_is_balanced(void **test)
{
	struct fleet_groups groups = {.items = NULL};
	/* All began on rank 0: separate bodies of one weight. */
	fleet_groups_clear(&groups);
	for (uint32_t i = 0; i < 40; i++)
		assert_int_equal(fleet_groups_add(&groups, &(struct fleet_item){4 * i, 0, 4 * i, 0, 0, 1, 0}), STATUS_OK);
	assert_int_equal(fleet_groups_make(&groups, LEVEL, 4, false), STATUS_OK);
	assert_int_equal(groups.loads[0], 40);
	assert_int_equal(fleet_groups_make(&groups, LEVEL, 4, true), STATUS_OK);
	for (int r = 0; r < 4; r++)
		assert_in_range(groups.loads[r], 8, 12);
	fleet_groups_finish(&groups);
	/* Nobody has them: all ranks get as many. */
	for (uint32_t i = 0; i < 40; i++)
		assert_int_equal(fleet_groups_add(&groups, &(struct fleet_item){4 * i, 0, 4 * i, 0, FLEET_NONE, 1, 0}), STATUS_OK);
	assert_int_equal(fleet_groups_make(&groups, LEVEL, 3, false), STATUS_OK);
	for (int r = 0; r < 3; r++)
		assert_in_range(groups.loads[r], 13, 14);
	fleet_groups_finish(&groups);
}

static void no_items_make_no_groups(void **test)
{
	struct fleet_groups groups = {.items = NULL};
	fleet_groups_clear(&groups);
	assert_int_equal(fleet_groups_make(&groups, LEVEL, 8, true), STATUS_OK);
	assert_int_equal(groups.group_count, 0);
	assert_int_equal(fleet_groups_settle(&groups), STATUS_OK);
	fleet_groups_finish(&groups);
}

TEST_PROGRAM(groups)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(items_that_share_tiles_are_one_group),
		cmocka_unit_test(groups_follow_their_owners),
		cmocka_unit_test(work_is_balanced),
		cmocka_unit_test(no_items_make_no_groups),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
