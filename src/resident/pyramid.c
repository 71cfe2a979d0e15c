#include "resident/host_slots.h"

#include "base/key_set.h"

struct change {
	struct tile tile;
	struct post_rect rect; /* within the tile's posts, global */
};

struct pyramid {
	const struct extent *extent;
	int level, coarsest;
	struct gpu_slots *slots;
	struct host_slots *host; /* NULL: the home is slots */
	struct change *changes;
	size_t count, room;
	struct key_set updated; /* in this step */
	struct resident_pyramid_figures figures;
};

enum status resident_pyramid_create(const struct extent *extent, int level, struct gpu_slots *slots, struct host_slots *host,
				    struct pyramid **out)
{
	struct pyramid *pyramid = mem_calloc(1, sizeof *pyramid);
	TRY_MEM(pyramid, "the pyramid");
	*pyramid = (struct pyramid){.extent = extent, .level = level, .coarsest = extent_coarsest(extent), .slots = slots, .host = host};
	*out = pyramid;
	return STATUS_OK;
}

void resident_pyramid_destroy(struct pyramid *pyramid)
{
	if (pyramid == NULL)
		return;
	key_set_finish(&pyramid->updated);
	mem_free_all(pyramid->changes, pyramid);
}

enum status resident_pyramid_changed(struct pyramid *pyramid, struct tile tile, struct post_rect rect)
{
	rect = post_rect_intersect(rect, tile_post_rect(pyramid->extent, tile));
	for (size_t i = 0; i < pyramid->count; i++)
		if (tile_equal(pyramid->changes[i].tile, tile)) {
			pyramid->changes[i].rect = post_rect_around(pyramid->changes[i].rect, rect);
			return STATUS_OK;
		}
	TRY(mem_grow(&pyramid->changes, &pyramid->room, pyramid->count + 1, sizeof *pyramid->changes, "the pyramid"));
	pyramid->changes[pyramid->count++] = (struct change){tile, rect};
	return STATUS_OK;
}

static enum status decimate(struct pyramid *pyramid, struct page_cache *cache, const struct change *change,
			    uint32_t slot)
{
	struct post_rect own = tile_post_rect(pyramid->extent, change->tile);
	if (pyramid->host != NULL && !post_rect_empty(change->rect))
		resident_host_changed(pyramid->host, slot, (struct gpu_rect){
			(uint32_t)(change->rect.x0 - own.x0), (uint32_t)(change->rect.y0 - own.y0),
			(uint32_t)(change->rect.x1 - change->rect.x0), (uint32_t)(change->rect.y1 - change->rect.y0)});
	for (int level = pyramid->level + 1; level <= pyramid->coarsest; level++) {
		int steps = level - pyramid->level;
		int64_t x0 = lattice_align(change->rect.x0, steps), y0 = lattice_align(change->rect.y0, steps);
		if (x0 >= change->rect.x1 || y0 >= change->rect.y1)
			return STATUS_OK; /* no post of this level changed, and so none of a coarser one */
		struct tile above = tile_ancestor(change->tile, level);
		uint32_t coarse;
		if (!page_cache_peek(cache, tile_key(above), false, &coarse))
			continue;
		int64_t cells = pyramid->extent->cells;
		struct gpu_rect rect = {(uint32_t)(x0 - own.x0), (uint32_t)(y0 - own.y0),
					(uint32_t)(change->rect.x1 - x0), (uint32_t)(change->rect.y1 - y0)};
		TRY(host_or_gpu_decimate(pyramid->host, pyramid->slots, slot, rect, steps, coarse, (uint32_t)((x0 >> steps) - above.x * cells),
					 (uint32_t)((y0 >> steps) - above.y * cells)));
		TRY(key_set_add(&pyramid->updated, tile_key(above)));
	}
	return STATUS_OK;
}

enum status resident_pyramid_flush_tile(struct pyramid *pyramid, struct page_cache *cache, struct tile tile, uint32_t slot)
{
	for (size_t i = 0; i < pyramid->count; i++)
		if (tile_equal(pyramid->changes[i].tile, tile)) {
			struct change change = pyramid->changes[i];
			pyramid->changes[i] = pyramid->changes[--pyramid->count];
			return decimate(pyramid, cache, &change, slot);
		}
	return STATUS_OK;
}

static void count_coarser(void *user, uint64_t key, uint32_t slot, bool dirty)
{
	struct pyramid *pyramid = user;
	if (tile_from_key(key).level <= pyramid->level)
		return;
	pyramid->figures.resident++;
	/* A tile that was updated and has left its slot since is not counted. */
	pyramid->figures.updated += key_set_has(&pyramid->updated, key);
}

enum status resident_pyramid_flush(struct pyramid *pyramid, struct page_cache *cache)
{
	enum status status = STATUS_OK;
	while (pyramid->count > 0) {
		struct change change = pyramid->changes[--pyramid->count];
		uint32_t slot;
		/* A page that left its slot was updated before it was read back. */
		if (page_cache_peek(cache, tile_key(change.tile), false, &slot))
			TRY_OR(done, decimate(pyramid, cache, &change, slot));
	}
done:
	page_cache_each_resident(cache, count_coarser, pyramid);
	key_set_clear(&pyramid->updated);
	return status;
}

void resident_pyramid_figures(const struct pyramid *pyramid, struct resident_pyramid_figures *figures)
{
	*figures = pyramid->figures;
}

void resident_pyramid_forget(struct pyramid *pyramid)
{
	if (pyramid != NULL)
		pyramid->count = 0;
}
