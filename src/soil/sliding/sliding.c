/*
 * Sliding over a window after a contact, and over a region of active blocks.
 *
 * Invariants: (1) The two posts of a pair exchange the same amount of soil. So the sum over the posts changes only by the laid soil that
 * is not compacted. (2) No soil leaves the posts in which it may slide. (3) What is computed for a pair depends on its two posts alone, so
 * it is the same in every window and region. (4) The GPU's shaders compute the same bits.
 */
#include <assert.h>
#include <string.h>

#include "soil/sliding/sliding.h"

#define LINES_MOST 256 /* posts along a side of a window: in a larger one soil does not slide along lines */

/* Pass by pass the directions. The order changes from path sample to path sample, so that in the end no direction comes first. Each is among
 * the first two in half of the orders. */
static const int orders[8][4] = {{0, 1, 2, 3}, {0, 2, 1, 3}, {2, 3, 0, 1}, {3, 1, 2, 0}, {1, 0, 3, 2}, {1, 3, 0, 2}, {3, 2, 1, 0}, {2, 0, 3, 1}};

int soil_sliding_direction(struct post_rect written, int pass)
{
	return orders[(written.x0 + 2 * written.y0) & 7][pass];
}

static size_t most_of(size_t a, size_t b)
{
	return a > b ? a : b;
}

size_t soil_sliding_scratch(const struct soil_sliding *rule, const struct soil_planes *planes)
{
	struct sliding_field field;
	size_t window = soil_sliding_field_init(&field, rule, planes, planes->rect, false, NULL);
	size_t region = soil_sliding_field_init(&field, rule, planes, planes->rect, true, NULL);
	return most_of(window, region) + most_of(soil_sliding_slopes_bytes(rule, planes), soil_sliding_end_bytes(field.width)) + 64;
}

/* Scratch memory begins at a multiple of 64 bytes. */
static void *aligned(void *scratch)
{
	return (void *)(((uintptr_t)scratch + 63) / 64 * 64);
}

struct post_rect soil_slide_blocks(struct post_rect posts)
{
	return (struct post_rect){posts.x0 >> 5, posts.y0 >> 5, ((posts.x1 - 1) >> 5) + 1, ((posts.y1 - 1) >> 5) + 1};
}

struct post_rect soil_slide_posts(struct post_rect written, struct post_rect reached, int64_t around)
{
	if (post_rect_empty(reached))
		return (struct post_rect){written.x0, written.y0, written.x0, written.y0};
	return post_rect_intersect(post_rect_grown(reached, around), written);
}

/* Soil slides along lines, and then the slopes that the flags need are measured. */
static void before_last(struct sliding_field *field, const struct soil_slide_window *window)
{
	const struct post_rect all = field->planes->rect;
	bool large = all.x1 - all.x0 > LINES_MOST || all.y1 - all.y0 > LINES_MOST;
	soil_sliding_close_roofs(field);
	for (int i = 0; i < field->rule->directions && !large; i++)
		soil_sliding_along(field, soil_sliding_direction(window->written, i));
	soil_sliding_open_roofs(field);
	for (size_t y = 0; y < field->height && field->steeps != NULL; y++)
		soil_sliding_steep_row(field, y, field->steeps + y * field->width);
}

void soil_slide_window(const struct soil_sliding *rule, const struct soil_planes *planes, const struct soil_slide_window *window, void *scratch,
		       uint32_t *words, struct soil_slid *slid)
{
	soil_slide_window_below(rule, planes, window, NULL, scratch, words, slid);
}

void soil_slide_window_below(const struct soil_sliding *rule, const struct soil_planes *planes, const struct soil_slide_window *window,
			     const struct soil_roofs *roofs, void *scratch, uint32_t *words, struct soil_slid *slid)
{
	const struct post_rect written = window->written, posts = window->posts, world = window->world;
	const struct post_rect blocks = soil_slide_blocks(written);
	struct sliding_field field;
	memset(words, 0, (size_t)((blocks.x1 - blocks.x0) * (blocks.y1 - blocks.y0)) * sizeof *words);
	if (post_rect_empty(posts))
		return;
	scratch = aligned(scratch);
	size_t used = soil_sliding_field_init(&field, rule, planes, posts, false, scratch);
	field.deposits = window->deposits;
	field.roofs = roofs;
	soil_sliding_begin(&field, slid);
	soil_sliding_put_roofs(&field);
	if (rule->steep)
		soil_sliding_part_steep(&field);
	soil_sliding_all_dirty(&field);
	for (int i = 0; i < rule->iterations; i++) {
		bool last = i == rule->iterations - 1;
		if (last)
			before_last(&field, window);
		if (rule->shed != NULL)
			soil_sliding_shed(&field, 0, last, true);
		else
			soil_sliding_iterate(&field, 0, last);
	}
	/* Beyond the world there is no soil, so at its border all neighbours were looked at. */
	const struct sliding_end end = {
		.window = true,
		.borders = {posts.x0 != written.x0 || written.x0 > world.x0, posts.y0 != written.y0 || written.y0 > world.y0,
			    posts.x1 != written.x1 || written.x1 < world.x1, posts.y1 != written.y1 || written.y1 < world.y1},
		.loaded = window->loaded,
		.blocks = blocks,
		.words = words,
	};
	soil_sliding_end(&field, &end, (char *)scratch + used);
}

void soil_slide_region(const struct soil_sliding *rule, const struct soil_planes *planes, struct post_rect blocks, void *scratch, uint32_t *words)
{
	soil_slide_region_below(rule, planes, blocks, NULL, scratch, words);
}

void soil_slide_region_below(const struct soil_sliding *rule, const struct soil_planes *planes, struct post_rect blocks, const struct soil_roofs *roofs,
			     void *scratch, uint32_t *words)
{
	const int64_t by = (int64_t)rule->step * rule->iterations;
	const struct post_rect posts = {blocks.x0 * SOIL_BLOCK - by, blocks.y0 * SOIL_BLOCK - by, blocks.x1 * SOIL_BLOCK + by, blocks.y1 * SOIL_BLOCK + by};
	struct sliding_field field;
	struct soil_slid unused = {.compacted = 0};
	assert(planes->rect.x0 <= posts.x0 - rule->steep - rule->reach && planes->rect.x1 >= posts.x1 + rule->steep + rule->reach);
	assert(planes->rect.y0 <= posts.y0 - rule->steep - rule->reach && planes->rect.y1 >= posts.y1 + rule->steep + rule->reach);
	memset(words, 0, (size_t)((blocks.x1 - blocks.x0) * (blocks.y1 - blocks.y0)) * sizeof *words);
	scratch = aligned(scratch);
	size_t used = soil_sliding_field_init(&field, rule, planes, posts, true, scratch);
	field.roofs = roofs;
	soil_sliding_begin(&field, &unused);
	soil_sliding_put_roofs(&field);
	if (rule->steep)
		soil_sliding_part_steep(&field);
	if (rule->reach > 0) {
		soil_sliding_least_in_slopes(&field);
		if (!soil_sliding_slopes(&field, (size_t)by, (char *)scratch + used))
			return;
	}
	soil_sliding_all_dirty(&field);
	for (int i = 0; i < rule->iterations; i++) {
		const bool last = i == rule->iterations - 1;
		if (rule->shed != NULL)
			soil_sliding_shed(&field, 2 * (size_t)i + 2, last, false);
		else
			soil_sliding_iterate(&field, (size_t)i + 1, last);
	}
	const struct sliding_end end = {.trim = (size_t)by, .blocks = blocks, .words = words};
	soil_sliding_end(&field, &end, (char *)scratch + used);
}
