/* Intervals of sliding on the CPU, over ground of all posts of a small world, for the tests of active blocks. */
#ifndef FURROW_TESTS_SOIL_BLOCKS_H
#define FURROW_TESTS_SOIL_BLOCKS_H

#include "../deform/ground.h"
#include "soil/soil.h"

/* Ground on the CPU: all posts of the world. */
struct field {
	int64_t posts; /* along a side */
	int32_t *base, *offset, *deposited, *slope; /* deposited, slope: NULL: not kept */
	uint8_t *classes, *contact;         /* classes: NULL: one soil */
	struct soil_block_set active;
	struct post_rect world;
};

/* How active blocks are cut into regions. */
enum cut { ONE_BLOCK_EACH, RUNS, ONE_REGION, CUTS };

/* A region with planes of its own. */
struct region {
	struct post_rect blocks;
	struct soil_planes planes;
	uint32_t *words;
};

static inline void gather(const struct field *field, int64_t rim, struct region *region)
{
	const struct post_rect blocks = region->blocks;
	struct soil_planes *planes = &region->planes;
	planes->rect = (struct post_rect){blocks.x0 * SOIL_BLOCK - rim, blocks.y0 * SOIL_BLOCK - rim, blocks.x1 * SOIL_BLOCK + rim, blocks.y1 * SOIL_BLOCK + rim};
	planes->width = (size_t)(planes->rect.x1 - planes->rect.x0);
	const int64_t count = (int64_t)planes->width * (planes->rect.y1 - planes->rect.y0);
	planes->base = ground_room(count, 4);
	planes->offset = ground_room(count, 4);
	planes->deposited = field->deposited != NULL ? ground_room(count, 4) : NULL;
	planes->classes = field->classes != NULL ? ground_room(count, 1) : NULL;
	planes->slope = field->slope != NULL ? ground_room(count, 4) : NULL;
	planes->contact = ground_room(count, 1);
	region->words = ground_room((blocks.x1 - blocks.x0) * (blocks.y1 - blocks.y0), sizeof *region->words);
	for (int64_t i = 0; i < count; i++) {
		int64_t x = planes->rect.x0 + i % (int64_t)planes->width, y = planes->rect.y0 + i / (int64_t)planes->width, at = y * field->posts + x;
		bool inside = x >= 0 && y >= 0 && x < field->posts && y < field->posts;
		planes->base[i] = inside ? field->base[at] : BASE_NODATA;
		planes->offset[i] = inside ? field->offset[at] : 0;
		planes->contact[i] = inside ? field->contact[at] : 0;
		if (planes->deposited != NULL)
			planes->deposited[i] = inside ? field->deposited[at] : 0;
		if (planes->slope != NULL)
			planes->slope[i] = inside ? field->slope[at] : 0;
		if (planes->classes != NULL)
			planes->classes[i] = inside ? field->classes[at] : 0;
	}
	soil_active_close(&field->active, planes);
}

static inline void scatter(struct field *field, const struct region *region)
{
	const struct post_rect blocks = region->blocks, all = region->planes.rect;
	const struct post_rect posts = post_rect_intersect((struct post_rect){blocks.x0 * SOIL_BLOCK, blocks.y0 * SOIL_BLOCK, blocks.x1 * SOIL_BLOCK,
									       blocks.y1 * SOIL_BLOCK}, field->world);
	for (int64_t y = posts.y0; y < posts.y1; y++)
		for (int64_t x = posts.x0; x < posts.x1; x++) {
			size_t from = (size_t)(y - all.y0) * region->planes.width + (size_t)(x - all.x0);
			bool active = soil_block_set_has(&field->active, (struct soil_block){x / SOIL_BLOCK, y / SOIL_BLOCK});
			if (!active) {
				assert_int_equal(field->offset[y * field->posts + x], region->planes.offset[from]);
				continue;
			}
			field->offset[y * field->posts + x] = region->planes.offset[from];
			if (field->deposited != NULL)
				field->deposited[y * field->posts + x] = region->planes.deposited[from];
			if (field->slope != NULL)
				field->slope[y * field->posts + x] = region->planes.slope[from];
		}
}

static inline void finish(struct region *region)
{
	mem_free(region->planes.base);
	mem_free(region->planes.offset);
	mem_free(region->planes.deposited);
	mem_free(region->planes.slope);
	mem_free(region->planes.classes);
	mem_free(region->planes.contact);
	mem_free(region->words);
}

static inline size_t cut_into(const struct soil_block_set *active, enum cut cut, struct region *regions)
{
	size_t count = 0;
	for (size_t i = 0; i < active->count; i++) {
		const struct soil_block at = active->blocks[i];
		const struct post_rect one = {at.x, at.y, at.x + 1, at.y + 1};
		if (cut == ONE_REGION && count > 0) {
			regions[0].blocks = post_rect_around(regions[0].blocks, one);
			continue;
		}
		if (cut == RUNS && soil_block_set_has(active, (struct soil_block){at.x - 1, at.y}))
			continue;
		struct post_rect run = one;
		while (cut == RUNS && soil_block_set_has(active, (struct soil_block){run.x1, at.y}))
			run.x1++;
		regions[count++] = (struct region){.blocks = run};
	}
	return count;
}

/* Regions come in any order: none reads what another one writes. */
static inline void interval_on_cpu(const struct soil_sliding *rule, struct field *field, enum cut cut)
{
	struct region *regions = ground_room((int64_t)field->active.count + 1, sizeof *regions);
	struct soil_block_set next = {.count = 0};
	soil_block_set_sort(&field->active);
	size_t count = cut_into(&field->active, cut, regions);
	for (size_t i = 0; i < count; i++)
		gather(field, soil_sliding_rim(rule), &regions[i]);
	for (size_t left = count; left > 0; left--) {
		size_t k = any_word() % left;
		struct region *region = &regions[k], last = regions[left - 1];
		void *scratch = ground_room((int64_t)soil_sliding_scratch(rule, &region->planes), 1);
		soil_slide_region(rule, &region->planes, region->blocks, scratch, region->words);
		mem_free(scratch);
		scatter(field, region);
		assert_ok(soil_active_add_words(&next, field->world, region->blocks, region->words));
		finish(region);
		*region = last;
	}
	mem_free(regions);
	soil_block_set_finish(&field->active);
	field->active = next;
	soil_block_set_sort(&field->active);
}

static double scale; /* of heights, m */
static bool is_cliffed;

static inline int32_t hills(int64_t x, int64_t y)
{
	uint32_t h = (uint32_t)x * 2654435761u ^ (uint32_t)y * 2246822519u;
	double height = 0.4 * sin((double)x * 0.11 + 1) * cos((double)y * 0.07) + (x + 2 * y > 150 ? 0.6 : 0) + ldexp(h >> 8, -28);
	height += fmax(0, fmin(1.5, 0.6 * (12 - hypot((double)x - 40, (double)y - 60))));
	height += is_cliffed && x > 90 ? 1600 / scale : 0;
	return x % 37 == 5 && y % 29 < 3 ? BASE_NODATA : (int32_t)lrint(ldexp(height * scale, BASE_BITS));
}

#endif
