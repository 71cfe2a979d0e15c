/*
 * Decides which parts of a tile are drawn at which stride, the distance between drawn posts. A tile is a quadtree of blocks. Each
 * block is a grid of the same number of cells. A block is divided while it is nearer than its stride's reach. A block is not drawn
 * if its box is outside the picture.
 */
#include <math.h>
#include <string.h>

#include "render/internal.h"

struct splitter {
	struct render_blocks *blocks;
	const struct render_view *view;
	const struct render_draw *draw;
	const double *reaches;
	double spacing;
	double west, south;  /* metres, of the tile */
	double limit[2];     /* the world's last post */
	uint32_t side, cells; /* along a block, and the tile */
	size_t first;        /* of this tile's blocks */
};

uint32_t render_block_cells(const struct extent *extent)
{
	uint32_t half = extent->cells / 2;
	return half < RENDER_BLOCK_CELLS ? half : RENDER_BLOCK_CELLS;
}

static enum status append(struct render_blocks *blocks, uint32_t block)
{
	TRY(mem_grow(&blocks->blocks, &blocks->capacity, blocks->count + 1, sizeof *blocks->blocks, "the picture's blocks"));
	blocks->blocks[blocks->count++] = block;
	return STATUS_OK;
}

/* Finds how far the block's ground reaches once its vertices have slid, metres. They slide south-west, onto posts of the coarsest
 * stride that any part of the block may have begun to become (terrain.vert's morph). */
static void slide_west_and_south(const struct splitter *s, const double low[3], const double high[3], double out[3])
{
	double far = 0, reach;
	int most = __builtin_ctz(s->cells) - 1, power = 0;
	for (int i = 0; i < 3; i++)
		far += pow(fmax(fabs(low[i] - s->view->eye[i]), fabs(high[i] - s->view->eye[i])), 2);
	far = 1.001 * sqrt(far);
	while (power < most && s->reaches[power + 1] <= far)
		power++;
	reach = s->reaches[power < most ? power + 1 : most];
	for (power += power < most; power < most && s->reaches[power + 1] <= reach;)
		power++;
	double step = s->spacing * (1 << power);
	out[0] = s->west + floor((low[0] - s->west) / step) * step;
	out[1] = s->south + floor((low[1] - s->south) / step) * step;
	out[2] = low[2];
}

static enum status split(struct splitter *s, uint32_t x, uint32_t y, int stride)
{
	double size = s->side * s->spacing * (1 << stride);
	double low[3] = {s->west + x * size, s->south + y * size, s->draw->low};
	double high[3] = {fmin(low[0] + size, s->limit[0]), fmin(low[1] + size, s->limit[1]), s->draw->high};
	double slid[3];
	slide_west_and_south(s, low, high, slid);
	if (low[0] >= s->limit[0] || low[1] >= s->limit[1] || !render_box_visible(s->view->planes, slid, high))
		return STATUS_OK;
	double distance = render_box_distance(s->view->eye, low, high);
	if (stride > 0 && distance < s->reaches[stride]) {
		/* The nearest first, since they hide what is behind. */
		uint32_t nearest = (s->view->eye[0] >= low[0] + size / 2 ? 1u : 0u) |
				   (s->view->eye[1] >= low[1] + size / 2 ? 2u : 0u);
		for (uint32_t i = 0; i < 4; i++)
			TRY(split(s, 2 * x + ((i ^ nearest) & 1), 2 * y + ((i ^ nearest) >> 1), stride - 1));
		return STATUS_OK;
	}
	return append(s->blocks, x | y << 10 | (uint32_t)stride << 20);
}

/* Marks edges that need a skirt. An edge needs none if the neighbouring block is of the same tile and has the same stride. */
static void add_skirts(struct splitter *s, uint32_t *edge_strides, uint32_t across)
{
	uint32_t *blocks = s->blocks->blocks;
	memset(edge_strides, 0xff, (size_t)across * across * sizeof *edge_strides);
	for (size_t i = s->first; i < s->blocks->count; i++) {
		uint32_t stride = blocks[i] >> 20 & 15, x = (blocks[i] & 1023) << stride, y = (blocks[i] >> 10 & 1023) << stride;
		for (uint32_t v = 0; v < 1u << stride; v++)
			for (uint32_t u = 0; u < 1u << stride; u++)
				edge_strides[(y + v) * across + x + u] = stride;
	}
	double side = s->side * s->spacing;
	for (size_t i = s->first; i < s->blocks->count; i++) {
		uint32_t stride = blocks[i] >> 20 & 15, x = (blocks[i] & 1023) << stride, y = (blocks[i] >> 10 & 1023) << stride;
		uint32_t size = 1u << stride;
		/* Nor where the world ends. */
		if (y == 0 ? s->south > 0 : edge_strides[(y - 1) * across + x] != stride)
			blocks[i] |= RENDER_SKIRT_SOUTH;
		if (x == 0 ? s->west > 0 : edge_strides[y * across + x - 1] != stride)
			blocks[i] |= RENDER_SKIRT_WEST;
		if (s->south + (y + size) * side < s->limit[1] &&
		    (y + size >= across || edge_strides[(y + size) * across + x] != stride))
			blocks[i] |= RENDER_SKIRT_NORTH;
		if (s->west + (x + size) * side < s->limit[0] &&
		    (x + size >= across || edge_strides[y * across + x + size] != stride))
			blocks[i] |= RENDER_SKIRT_EAST;
	}
}

enum status render_blocks_add(struct render_blocks *blocks, const struct extent *extent, const struct render_view *view,
			      const double reaches[RENDER_STRIDES], const struct render_draw *draw)
{
	uint32_t side = render_block_cells(extent), across = extent->cells / side;
	double spacing = extent_spacing(extent, draw->tile.level);
	struct splitter s = {
		.blocks = blocks, .view = view, .draw = draw, .spacing = spacing, .reaches = reaches,
		.west = draw->tile.x * spacing * extent->cells, .south = draw->tile.y * spacing * extent->cells,
		.limit = {(double)(extent->width - 1) * extent->spacing, (double)(extent->height - 1) * extent->spacing},
		.side = side, .cells = extent->cells, .first = blocks->count,
	};
	int stride = 0;
	while (across >> stride > 2)
		stride++;
	for (uint32_t i = 0; i < 4; i++)
		if (draw->quadrants >> i & 1)
			TRY(split(&s, i & 1, i >> 1, stride));
	if (blocks->count == s.first)
		return STATUS_OK;
	uint32_t *strides = mem_alloc((size_t)across * across, sizeof *strides);
	TRY_MEM(strides, "the picture's blocks");
	add_skirts(&s, strides, across);
	mem_free(strides);
	return STATUS_OK;
}
