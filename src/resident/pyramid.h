/*
 * Keeps resident coarser tiles up to date with what changed at the working level, on the GPU.
 * Changes of a step are gathered as one rectangle a tile and decimated once, before anybody looks or
 * the tile leaves its slot.
 */
#ifndef FURROW_RUN_PYRAMID_H
#define FURROW_RUN_PYRAMID_H

#include "base/base.h"
#include "gpu/gpu.h"
#include "page/page.h"

struct pyramid;

enum status pyramid_create(const struct extent *extent, int level, struct gpu_slots *slots, struct pyramid **out)
	FURROW_CHECKED;
void pyramid_destroy(struct pyramid *pyramid);
/* Posts of `rect` (global) changed in this tile. */
enum status pyramid_changed(struct pyramid *pyramid, struct tile tile, struct post_rect rect) FURROW_CHECKED;
/* Brings the tile's resident ancestors up to date; nothing if it did not change. */
enum status pyramid_flush_tile(struct pyramid *pyramid, struct page_cache *cache, struct tile tile, uint32_t slot)
	FURROW_CHECKED;
/* All of them, at a step's end. */
enum status pyramid_flush(struct pyramid *pyramid, struct page_cache *cache) FURROW_CHECKED;
struct pyramid_figures {
	uint64_t updated, resident; /* coarser tiles, both summed over the steps */
};
void pyramid_figures(const struct pyramid *pyramid, struct pyramid_figures *figures);

#endif
