/* The set of active blocks: what becomes active near a change, and what stays so after an interval. */
#include "soil/soil.h"

static int64_t block_of(int64_t post)
{
	return post >> 5;
}

static int64_t most_of(int64_t a, int64_t b)
{
	return a > b ? a : b;
}

static int64_t least_of(int64_t a, int64_t b)
{
	return a < b ? a : b;
}

enum status soil_active_add(struct soil_block_set *set, struct post_rect world, struct soil_block block)
{
	if (block.x < 0 || block.y < 0 || block.x > block_of(world.x1 - 1) || block.y > block_of(world.y1 - 1))
		return STATUS_OK;
	return soil_block_set_add(set, block);
}

struct post_rect soil_active_near(struct post_rect world, int64_t rim, struct post_rect changed)
{
	int64_t x0 = most_of(block_of(changed.x0 - rim), 0), y0 = most_of(block_of(changed.y0 - rim), 0);
	int64_t x1 = least_of(block_of(changed.x1 - 1 + rim), block_of(world.x1 - 1)), y1 = least_of(block_of(changed.y1 - 1 + rim), block_of(world.y1 - 1));
	return (struct post_rect){x0 * SOIL_BLOCK, y0 * SOIL_BLOCK, (x1 + 1) * SOIL_BLOCK, (y1 + 1) * SOIL_BLOCK};
}

enum status soil_active_add_near(struct soil_block_set *set, struct post_rect world, int64_t rim, struct post_rect changed)
{
	const struct post_rect posts = soil_active_near(world, rim, changed);
	for (int64_t y = posts.y0 / SOIL_BLOCK; y < posts.y1 / SOIL_BLOCK; y++)
		for (int64_t x = posts.x0 / SOIL_BLOCK; x < posts.x1 / SOIL_BLOCK; x++)
			TRY(soil_block_set_add(set, (struct soil_block){x, y}));
	return STATUS_OK;
}

enum status soil_active_add_word(struct soil_block_set *set, struct post_rect world, struct soil_block block, uint32_t word)
{
	static const int ways[9][2] = {{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
	for (int way = 0; way < 9; way++)
		if (word & 1u << way)
			TRY(soil_active_add(set, world, (struct soil_block){block.x + ways[way][0], block.y + ways[way][1]}));
	return STATUS_OK;
}

enum status soil_active_add_words(struct soil_block_set *set, struct post_rect world, struct post_rect blocks, const uint32_t *words)
{
	for (int64_t y = blocks.y0; y < blocks.y1; y++)
		for (int64_t x = blocks.x0; x < blocks.x1; x++)
			TRY(soil_active_add_word(set, world, (struct soil_block){x, y}, *words++));
	return STATUS_OK;
}

void soil_active_close(const struct soil_block_set *set, const struct soil_planes *planes)
{
	const struct post_rect all = planes->rect;
	for (int64_t by = block_of(all.y0); by * SOIL_BLOCK < all.y1; by++)
		for (int64_t bx = block_of(all.x0); bx * SOIL_BLOCK < all.x1; bx++) {
			if (soil_block_set_has(set, (struct soil_block){bx, by}))
				continue;
			const int64_t x = bx * SOIL_BLOCK, y = by * SOIL_BLOCK;
			const struct post_rect posts = post_rect_intersect((struct post_rect){x, y, x + SOIL_BLOCK, y + SOIL_BLOCK}, all);
			for (int64_t row = posts.y0; row < posts.y1; row++)
				for (int64_t at = posts.x0; at < posts.x1; at++)
					planes->contact[(size_t)(row - all.y0) * planes->width + (size_t)(at - all.x0)] |= SOIL_CLOSED;
		}
}
