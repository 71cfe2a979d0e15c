/* Implements the regions that regions.h describes. */
#include "deform/schedule/regions.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

void deform_regions_finish(struct regions *regions)
{
	mem_free_all(regions->regions, regions->runs, regions->owners, regions->shelves);
	*regions = (struct regions){.room = 0};
}

static enum status need(struct regions *regions, size_t blocks)
{
	size_t room = regions->room != 0 ? regions->room : 64;
	while (room < blocks)
		room *= 2;
	if (room == regions->room)
		return STATUS_OK;
	deform_regions_finish(regions);
	regions->regions = mem_alloc(room, sizeof *regions->regions);
	regions->runs = mem_alloc(room, sizeof *regions->runs);
	regions->owners = mem_alloc(room, sizeof *regions->owners);
	regions->shelves = mem_alloc(room, sizeof *regions->shelves);
	if (regions->regions == NULL || regions->runs == NULL || regions->owners == NULL || regions->shelves == NULL) {
		deform_regions_finish(regions);
		return fail_memory("the awake blocks");
	}
	regions->room = room;
	return STATUS_OK;
}

static uint32_t aligned(uint32_t posts)
{
	return (posts + REGION_ALIGN - 1) / REGION_ALIGN * REGION_ALIGN;
}

uint32_t deform_region_blocks(const struct region_limits *limits)
{
	return (limits->side - aligned(limits->rim) - limits->rim) / SOIL_BLOCK;
}

/* --- which blocks belong together --- */

/* Returns the place of a block that no region has yet; set->count if there is no such block. */
static size_t free_place(const struct soil_block_set *set, const struct regions *regions, int64_t x, int64_t y)
{
	size_t place = soil_block_set_place(set, (struct soil_block){x, y});
	return place < set->count && regions->owners[place] == 0 ? place : set->count;
}

static int64_t free_blocks(const struct soil_block_set *set, const struct regions *regions, const struct region *in)
{
	int64_t count = 0;
	for (int64_t y = in->y; y < in->y + in->rows; y++)
		for (int64_t x = in->x; x < in->x + in->columns; x++)
			count += free_place(set, regions, x, y) < set->count;
	return count;
}

static int64_t posts_of(const struct region *region, int64_t rim)
{
	return (SOIL_BLOCK * (int64_t)region->columns + 2 * rim) * (SOIL_BLOCK * (int64_t)region->rows + 2 * rim);
}

/* Adds rows and columns to a region as long as that costs fewer posts than regions of one block for the blocks in them. */
static void grow(const struct soil_block_set *set, const struct regions *regions, const struct region_limits *limits, struct region *region)
{
	static const struct region one = {.columns = 1, .rows = 1};
	const uint32_t most = deform_region_blocks(limits);
	int64_t best;
	do {
		const struct region wider[4] = {
			{.x = region->x - 1, .y = region->y, .columns = 1, .rows = region->rows},
			{.x = region->x + region->columns, .y = region->y, .columns = 1, .rows = region->rows},
			{.x = region->x, .y = region->y - 1, .columns = region->columns, .rows = 1},
			{.x = region->x, .y = region->y + region->rows, .columns = region->columns, .rows = 1},
		};
		struct region next = *region;
		best = 0;
		for (int i = 0; i < 4; i++) {
			struct region with = *region;
			with.x -= i == 0;
			with.y -= i == 2;
			with.columns += i < 2;
			with.rows += i >= 2;
			if (with.columns > most || with.rows > most)
				continue;
			int64_t gain = free_blocks(set, regions, &wider[i]) * posts_of(&one, limits->rim) - posts_of(&with, limits->rim) +
				       posts_of(region, limits->rim);
			if (gain > best) {
				best = gain;
				next = with;
			}
		}
		*region = next;
	} while (best > 0);
}

static void take(const struct soil_block_set *set, struct regions *regions, const struct region *region)
{
	for (int64_t y = region->y; y < region->y + region->rows; y++)
		for (int64_t x = region->x; x < region->x + region->columns; x++) {
			size_t place = free_place(set, regions, x, y);
			if (place < set->count)
				regions->owners[place] = region->number + 1;
		}
}

/* --- where they lie in atlases --- */

static int by_height(const void *pa, const void *pb)
{
	const struct region *a = pa, *b = pb;
	if (a->rows != b->rows)
		return a->rows > b->rows ? -1 : 1;
	if (a->columns != b->columns)
		return a->columns > b->columns ? -1 : 1;
	return a->number < b->number ? -1 : 1;
}

static int by_atlas(const void *pa, const void *pb)
{
	const struct region *a = pa, *b = pb;
	if (a->atlas != b->atlas)
		return a->atlas < b->atlas ? -1 : 1;
	return a->number < b->number ? -1 : 1;
}

/* Puts a region at the end of a shelf. Returns false if there is no room. */
static bool put(const struct region_limits *limits, struct shelf *shelf, struct region *region)
{
	uint32_t x = aligned(shelf->x + limits->rim), y = aligned(shelf->y + limits->rim);
	uint32_t right = x + SOIL_BLOCK * region->columns + limits->rim, top = y + SOIL_BLOCK * region->rows + limits->rim;
	if (right > limits->side || top > limits->side || (shelf->height != 0 && top - shelf->y > shelf->height))
		return false;
	region->atlas = shelf->atlas;
	region->at_x = x;
	region->at_y = y;
	shelf->x = right;
	shelf->height = shelf->height != 0 ? shelf->height : top - shelf->y;
	return true;
}

/* Places all regions, the highest first, each on one of the last shelves that has room. */
static void place_all(const struct region_limits *limits, struct regions *regions)
{
	enum { LAST = 16 };
	size_t count = 0;
	regions->atlas_count = 0;
	qsort(regions->regions, regions->region_count, sizeof *regions->regions, by_height);
	for (size_t i = 0; i < regions->region_count; i++) {
		bool placed = false;
		for (size_t k = count > LAST ? count - LAST : 0; k < count && !placed; k++)
			placed = put(limits, &regions->shelves[k], &regions->regions[i]);
		for (int fresh = count == 0; !placed; fresh++) {
			const struct shelf *last = count > 0 ? &regions->shelves[count - 1] : NULL;
			struct shelf next = {.atlas = (uint32_t)regions->atlas_count};
			if (fresh == 0)
				next = (struct shelf){.atlas = last->atlas, .y = last->y + last->height};
			placed = put(limits, &next, &regions->regions[i]);
			assert(placed || fresh == 0);
			if (placed)
				regions->shelves[count++] = next;
			regions->atlas_count += placed && fresh > 0;
		}
	}
	qsort(regions->regions, regions->region_count, sizeof *regions->regions, by_atlas);
}

/* --- runs --- */

static void add_run(struct regions *regions, struct run *run, uint32_t *slot)
{
	if (run->count == 0)
		return;
	assert(regions->run_count < regions->room);
	run->slot = *slot;
	*slot += run->count;
	regions->runs[regions->run_count++] = *run;
	run->count = 0;
}

static void add_runs(const struct soil_block_set *set, struct regions *regions, const struct region_limits *limits, uint32_t number,
		     uint32_t *slot)
{
	struct region *region = &regions->regions[number];
	region->first_run = (uint32_t)regions->run_count;
	for (int64_t y = region->y; y < region->y + region->rows; y++) {
		struct run run = {.region = number};
		for (int64_t x = region->x; x < region->x + region->columns; x++) {
			size_t place = soil_block_set_place(set, (struct soil_block){x, y});
			bool is = place < set->count && regions->owners[place] == region->number + 1;
			bool ends = !is || (*slot + run.count) % limits->in_row == 0 ||
				    x * SOIL_BLOCK / limits->cells != run.first.x * SOIL_BLOCK / limits->cells;
			if (ends)
				add_run(regions, &run, slot);
			if (is && run.count == 0)
				run.first = (struct soil_block){x, y};
			run.count += is;
		}
		add_run(regions, &run, slot);
	}
	region->run_count = (uint32_t)regions->run_count - region->first_run;
}

enum status deform_regions_cut(const struct soil_block_set *set, const struct region_limits *limits, struct regions *regions)
{
	regions->region_count = regions->run_count = regions->atlas_count = 0;
	TRY(need(regions, set->count));
	if (set->count == 0)
		return STATUS_OK;
	memset(regions->owners, 0, set->count * sizeof *regions->owners);
	for (size_t i = 0; i < set->count; i++) {
		if (regions->owners[i] != 0)
			continue;
		struct region *region = &regions->regions[regions->region_count];
		*region = (struct region){.x = set->blocks[i].x, .y = set->blocks[i].y, .columns = 1, .rows = 1,
					  .number = (uint32_t)regions->region_count};
		grow(set, regions, limits, region);
		take(set, regions, region);
		regions->region_count++;
	}
	place_all(limits, regions);
	uint32_t slot = 0;
	for (size_t i = 0; i < regions->region_count; i++)
		add_runs(set, regions, limits, (uint32_t)i, &slot);
	assert(slot == set->count);
	return STATUS_OK;
}

enum status deform_regions_one(struct soil_block block, const struct region_limits *limits, struct regions *regions)
{
	TRY(need(regions, 1));
	regions->regions[0] = (struct region){.x = block.x, .y = block.y, .columns = 1, .rows = 1, .run_count = 1};
	regions->runs[0] = (struct run){.first = block, .count = 1};
	regions->region_count = regions->run_count = 1;
	place_all(limits, regions);
	return STATUS_OK;
}
