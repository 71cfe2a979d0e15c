/*
 * Makes and destroys a codec, which packs tiles (FORMAT.md describes the bytes). The steps of encoding are:
 *
 *   posts -> holes predicted -> minus the prediction -> without common zero bits -> zigzag -> widths by 16 -> bits [-> LZ4]
 *                                                               -> byte planes -> zstd
 *     or, in levels (codec_levels.h): -> widths by 8, coded -> bits
 *
 * Invariants:
 *   1. All arithmetic on posts is modulo 2^32, so that every int32 comes back.
 *   2. A hole's residual is 0. So the mask is used only once all posts are decoded.
 *   3. A length or a width from a blob is checked before use: against the rest of the blob, and against the plane's own size.
 */
#include "store/codec.h"

#include <assert.h>
#include <lz4.h>
#include <zstd.h>

#include "store/codec_levels.h"
#include "store/codec_widths.h"

static size_t larger(size_t a, size_t b)
{
	return a > b ? a : b;
}

enum status store_codec_init(struct codec *codec, uint32_t side, enum codec_effort effort)
{
	assert(side > 8 && side % 8 == 1); /* the kernels take eight posts at once */
	*codec = (struct codec){.side = side, .effort = effort, .kernels = store_codec_kernels_best()};
	size_t posts = plane_posts(codec), blocks = plane_blocks(codec);
	size_t head = 1 + 4 + 1 + CODEC_LENGTH_BYTES + (size_t)LZ4_compressBound((int)mask_bytes(codec));
	size_t level_count = level_blocks(LEVELS_TOP, side - 1), widths = 2 * (CODEC_LENGTH_BYTES + store_widths_bound(level_count));
	codec->room = head + blocks * (1 + 4 * CODEC_BLOCK) + 2 * CODEC_SLACK;
	codec->squeezed_room = larger(CODEC_LENGTH_BYTES + (size_t)LZ4_compressBound((int)codec->room),
				      head + 1 + ZSTD_compressBound(4 * posts));
	codec->squeezed_room = larger(codec->squeezed_room, head + widths + level_count * 4 * LEVELS_BLOCK);
	codec->grids = mem_alloc(level_room(side - 1) + 1, sizeof *codec->grids);
	codec->edges = mem_alloc(3 * (size_t)side + LEVELS_BLOCK, sizeof *codec->edges);
	for (int slope = 0; slope < 2; slope++) {
		codec->orders[slope] = mem_alloc(blocks * CODEC_BLOCK, sizeof *codec->orders[slope]);
		codec->widths[slope] = mem_alloc(larger(blocks, level_count), 1);
	}
	codec->filled = mem_alloc(posts, sizeof *codec->filled);
	codec->mask = mem_alloc(mask_bytes(codec), 1);
	codec->body = mem_alloc(codec->room, 1);
	codec->squeezed = mem_alloc(codec->squeezed_room, 1);
	codec->zstd_in = ZSTD_createDCtx();
	if (effort == CODEC_SMALL)
		codec->zstd_out = ZSTD_createCCtx();
	if (codec->orders[0] != NULL && codec->orders[1] != NULL && codec->widths[0] != NULL &&
	    codec->widths[1] != NULL && codec->filled != NULL && codec->grids != NULL && codec->edges != NULL && codec->mask != NULL &&
	    codec->body != NULL && codec->squeezed != NULL && codec->zstd_in != NULL &&
	    (effort != CODEC_SMALL || codec->zstd_out != NULL))
		return STATUS_OK;
	store_codec_finish(codec);
	return fail_memory("the tile codec");
}

void store_codec_finish(struct codec *codec)
{
	for (int slope = 0; slope < 2; slope++)
		mem_free_all(codec->orders[slope], codec->widths[slope]);
	mem_free_all(codec->grids, codec->edges, codec->filled, codec->mask, codec->body, codec->squeezed);
	ZSTD_freeDCtx(codec->zstd_in);
	ZSTD_freeCCtx(codec->zstd_out);
	*codec = (struct codec){0};
}

size_t store_codec_bound(const struct codec *codec)
{
	return codec->squeezed_room;
}
