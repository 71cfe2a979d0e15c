/*
 * An interval of relaxation. Active blocks are parted into regions: blocks of a row one beside the other, on one column of tiles. Every region is
 * computed from the ground before the interval, and put back when all have been computed.
 */
#include <string.h>

#include "bearing/internal.h"

#define REGION_BLOCKS 7

static struct post_rect posts_of(struct post_rect blocks)
{
	return (struct post_rect){blocks.x0 * SOIL_BLOCK, blocks.y0 * SOIL_BLOCK, blocks.x1 * SOIL_BLOCK, blocks.y1 * SOIL_BLOCK};
}

static uint64_t posts_in(struct post_rect rect)
{
	return (uint64_t)(rect.x1 - rect.x0) * (uint64_t)(rect.y1 - rect.y0);
}

static void finish_region(struct bearing *bearing, struct bearing_region *region)
{
	if (region->offset != NULL)
		bearing->results -= posts_in(region->writes);
	region->offset = region->deposited = region->slope = NULL;
}

static void finish_regions(struct bearing *bearing)
{
	for (size_t i = 0; i < bearing->region_count; i++)
		finish_region(bearing, &bearing->regions[i]);
	bearing->region_count = 0;
}

static enum status add_region(struct bearing *bearing, struct post_rect blocks)
{
	TRY(mem_grow(&bearing->regions, &bearing->region_room, bearing->region_count + 1, sizeof *bearing->regions, "relaxation"));
	const int64_t rim = bearing_interval_rim(bearing);
	const struct post_rect posts = posts_of(blocks), reads = post_rect_grown(posts, rim);
	bearing->regions[bearing->region_count++] = (struct bearing_region){.blocks = blocks, .reads = reads, .writes = post_rect_intersect(posts, bearing->world)};
	return STATUS_OK;
}

/* Blocks of the list, sorted by row, then by column. */
static int by_row(const void *a, const void *b)
{
	const struct soil_block *p = a, *q = b;
	if (p->y != q->y)
		return p->y < q->y ? -1 : 1;
	return p->x < q->x ? -1 : p->x > q->x;
}

static enum status cut(struct bearing *bearing)
{
	const size_t count = bearing->active.count;
	const int64_t cells = bearing->params.extent->cells;
	struct soil_block *blocks = mem_alloc(count, sizeof *blocks);
	enum status status = STATUS_OK;
	TRY_MEM(blocks, "relaxation");
	memcpy(blocks, bearing->active.blocks, count * sizeof *blocks);
	qsort(blocks, count, sizeof *blocks, by_row);
	for (size_t first = 0, last; first < count; first = last) {
		for (last = first + 1; last < count && last - first < REGION_BLOCKS && blocks[last].y == blocks[first].y && blocks[last].x == blocks[last - 1].x + 1 &&
				       blocks[last].x * SOIL_BLOCK / cells == blocks[first].x * SOIL_BLOCK / cells;)
			last++;
		TRY_OR(done, add_region(bearing, (struct post_rect){blocks[first].x, blocks[first].y, blocks[last - 1].x + 1, blocks[first].y + 1}));
	}
done:
	mem_free(blocks);
	return status;
}

/* Makes room for what all regions will have computed. */
static enum status need_results(struct bearing *bearing)
{
	const size_t planes = 1 + ((bearing->planes & PLANE_BIT(PLANE_DEPOSITED)) != 0) + ((bearing->planes & PLANE_BIT(PLANE_SLOPE)) != 0);
	size_t numbers = 0;
	for (size_t i = 0; i < bearing->region_count; i++) {
		bearing->regions[i].at = numbers;
		numbers += planes * (size_t)posts_in(bearing->regions[i].writes);
	}
	if (numbers <= bearing->memory_room)
		return STATUS_OK;
	mem_free(bearing->memory);
	bearing->memory_room = 0;
	TRY(mem_make(&bearing->memory, numbers, sizeof *bearing->memory, "relaxation"));
	bearing->memory_room = numbers;
	return STATUS_OK;
}

enum status bearing_interval_begin(struct bearing *bearing, const struct deform_rest *objects, size_t count, struct bearing_interval *interval)
{
	const struct soil_block *blocks;
	size_t block_count;
	finish_regions(bearing);
	*interval = (struct bearing_interval){bearing->active.count, 0};
	soil_block_set_clear(&bearing->next);
	TRY(bearing_active_blocks(bearing, &blocks, &block_count));
	if (block_count == 0)
		return STATUS_OK;
	TRY(bearing_hold_begin(bearing, objects, count));
	TRY(cut(bearing));
	TRY(need_results(bearing));
	interval->regions = bearing->region_count;
	return STATUS_OK;
}

struct post_rect bearing_interval_reads(const struct bearing *bearing, size_t region)
{
	return bearing->regions[region].reads;
}

struct post_rect bearing_interval_writes(const struct bearing *bearing, size_t region)
{
	return bearing->regions[region].writes;
}

enum status bearing_interval_start(struct bearing *bearing, size_t region)
{
	const struct post_rect reads = bearing->main->regions[region].reads;
	TRY(bearing_window_need(bearing, reads));
	bearing_window_clear(bearing); /* posts of no tile are beyond the world */
	return STATUS_OK;
}

void bearing_interval_gather(struct bearing *bearing, const struct tile_slot *held, size_t count)
{
	bearing_window_gather(bearing, held, count, true, false);
}

enum status bearing_interval_slide(struct bearing *bearing, size_t number)
{
	struct bearing_region *region = &bearing->main->regions[number];
	struct soil_planes *planes = &bearing->window.planes;
	const size_t width = (size_t)(region->writes.x1 - region->writes.x0), height = (size_t)(region->writes.y1 - region->writes.y0);
	struct soil_roofs roofs;
	bearing_roofs_clear(bearing);
	TRY(bearing_hold_near(bearing));
	soil_active_close(&bearing->main->active, planes);
	bearing->slid++;
	soil_slide_region_below(&bearing->rule, planes, region->blocks, bearing_roofs(bearing, &roofs), bearing->window.scratch, bearing->window.words);
	TRY(soil_active_add_words(&bearing->next, bearing->world, region->blocks, bearing->window.words));
	region->offset = bearing->main->memory + region->at;
	int32_t *const next = region->offset + width * height;
	region->deposited = planes->deposited != NULL ? next : NULL;
	region->slope = planes->slope != NULL ? next + (region->deposited != NULL ? width * height : 0) : NULL;
	bearing->results += posts_in(region->writes);
	for (size_t row = 0; row < height; row++) {
		const size_t at = ((size_t)(region->writes.y0 - planes->rect.y0) + row) * planes->width + (size_t)(region->writes.x0 - planes->rect.x0);
		memcpy(region->offset + row * width, planes->offset + at, width * sizeof *region->offset);
		if (planes->deposited != NULL)
			memcpy(region->deposited + row * width, planes->deposited + at, width * sizeof *region->deposited);
		if (planes->slope != NULL)
			memcpy(region->slope + row * width, planes->slope + at, width * sizeof *region->slope);
	}
	return STATUS_OK;
}

enum status bearing_interval_scatter(struct bearing *bearing, size_t number, const struct tile_slot *held, size_t count)
{
	const unsigned planes = bearing->planes & (PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DEPOSITED) | PLANE_BIT(PLANE_SLOPE));
	struct bearing_region *region = &bearing->regions[number];
	const struct soil_planes from = {.rect = region->writes, .width = (size_t)(region->writes.x1 - region->writes.x0), .offset = region->offset, .deposited = region->deposited,
					 .slope = region->slope};
	enum status status = STATUS_OK;
	for (size_t i = 0; i < count; i++)
		TRY_OR(done, resident_host_write(bearing->slots, held[i].slot, planes));
	resident_host_scatter(bearing->slots, held, count, &from, region->writes, planes);
done:
	finish_region(bearing, region);
	return status;
}

enum status bearing_interval_end(struct bearing *bearing)
{
	const struct soil_block_set was = bearing->active;
	bearing->active = bearing->next;
	bearing->next = was;
	finish_regions(bearing);
	return STATUS_OK;
}
