/*
 * Moves pages into slots and out of them, on the owner's thread. Transfers are begun here, and later settled.
 *
 * When a page coarser than the working level becomes resident, newer values are laid over it. First come the versions that are
 * not in the store yet, then the pages that are dirty in a slot. So it is the decimation of the finer level (law 4), also
 * between two commits.
 */

#include "resident/pages_internal.h"

struct overlay {
	struct pages *pages;
	struct page_image *image;
	struct tile tile;
	uint32_t slot;
	enum status status;
};

/* Finds where the posts of `fine` that are also posts of `coarse` go. The levels are `steps` apart. */
static bool overlaps(const struct pages *pages, struct tile fine, struct tile coarse, int *steps, uint32_t *to_x,
		     uint32_t *to_y, struct gpu_rect *rect)
{
	if (fine.level != pages->params.level || fine.level >= coarse.level ||
	    !tile_equal(tile_ancestor(fine, coarse.level), coarse))
		return false;
	uint64_t cells = pages->layout.cells, step = (uint64_t)1 << (*steps = coarse.level - fine.level);
	/* First post of the fine tile, in its own posts from the coarse tile's first post. */
	uint64_t x = fine.x * cells - (uint64_t)coarse.x * cells * step,
		 y = fine.y * cells - (uint64_t)coarse.y * cells * step;
	uint64_t skip_x = (step - x % step) % step, skip_y = (step - y % step) % step;
	if (skip_x > cells || skip_y > cells)
		return false;
	*to_x = (uint32_t)((x + skip_x) / step);
	*to_y = (uint32_t)((y + skip_y) / step);
	*rect = (struct gpu_rect){(uint32_t)skip_x, (uint32_t)skip_y, (uint32_t)(cells + 1 - skip_x),
				  (uint32_t)(cells + 1 - skip_y)};
	return true;
}

static enum status copy_posts(struct pages *pages, const struct page_image *fine, struct gpu_rect rect, int steps, struct page_image *coarse,
			      uint32_t to_x, uint32_t to_y)
{
	const size_t stride = pages->layout.cells + 1, step = (size_t)1 << steps;
	void *into[PLANES];
	TRY(pages->home->planes(pages, coarse, pages->planes & GPU_DRAWN_PLANES, true, into));
	const unsigned drawn = pages->planes & GPU_DRAWN_PLANES;
	for (int plane = 0; plane < PLANES; plane++) {
		if (!(drawn & PLANE_BIT(plane)))
			continue;
		const void *posts = pages->home->plane(pages, fine, (enum plane)plane);
		const bool narrow = plane_bytes((enum plane)plane) == 1;
		for (size_t y = 0; y < rect.height; y += step)
			for (size_t x = 0; x < rect.width; x += step) {
				const size_t from = (rect.y + y) * stride + rect.x + x, to = (to_y + y / step) * stride + to_x + x / step;
				if (narrow)
					((uint8_t *)into[plane])[to] = ((const uint8_t *)posts)[from];
				else
					((int32_t *)into[plane])[to] = ((const int32_t *)posts)[from];
			}
	}
	return STATUS_OK;
}

static void overlay_queued(void *user, const struct page_image *fine)
{
	struct overlay *overlay = user;
	int steps;
	uint32_t to_x, to_y;
	struct gpu_rect rect;
	if (overlay->status == STATUS_OK && overlaps(overlay->pages, tile_from_key(fine->key), overlay->tile, &steps, &to_x, &to_y, &rect))
		overlay->status = copy_posts(overlay->pages, fine, rect, steps, overlay->image, to_x, to_y);
}

static void overlay_resident(void *user, uint64_t key, uint32_t slot, bool dirty)
{
	struct overlay *overlay = user;
	int steps;
	uint32_t to_x, to_y;
	struct gpu_rect rect;
	if (overlay->status != STATUS_OK || !dirty ||
	    !overlaps(overlay->pages, tile_from_key(key), overlay->tile, &steps, &to_x, &to_y, &rect))
		return;
	const struct pages_params *params = &overlay->pages->params;
	overlay->status = host_or_gpu_decimate(params->host, params->slots, slot, rect, steps, overlay->slot, to_x, to_y);
}

static enum status upload(void *user, uint32_t slot, struct page_image *image)
{
	struct pages *pages = user;
	struct overlay overlay = {pages, image, tile_from_key(image->key), slot, STATUS_OK};
	const bool overlays = image->overlays;
	if (overlays)
		page_cache_each_queued(pages->cache, overlay_queued, &overlay);
	enum status status = overlay.status == STATUS_OK ? pages->home->upload(pages, slot, image) : overlay.status;
	if (status == STATUS_OK && overlays)
		page_cache_each_resident(pages->cache, overlay_resident, &overlay);
	return status == STATUS_OK ? overlay.status : status;
}

static enum status read_back(void *user, uint32_t slot, struct page_image *image)
{
	struct pages *pages = user;
	double started = clock_seconds();
	enum status status;
	TRY_OR(done, pages->params.before_read_back(pages->params.user, tile_from_key(image->key), slot));
	TRY_OR(done, pages->home->read_back(pages, slot, image));
done:
	image->flags = pages->planes;
	pages->readback_ms += (clock_seconds() - started) * 1e3;
	return status;
}

static enum status snapshot(void *user, struct page_image *image)
{
	struct pages *pages = user;
	return pages->home->snapshot(pages, image);
}

static enum status settled(void *user, const struct page_image *image, bool *settled)
{
	const struct pages *pages = user;
	return pages->home->settled(pages, image, settled);
}

static enum status create_image(void *user, enum page_image_kind kind, struct page_image *image)
{
	struct pages *pages = user;
	TRY(pages->home->create(pages, kind, image));
	pages->changed_images += kind == PAGE_CHANGED_IMAGE;
	return STATUS_OK;
}

static void destroy_image(void *user, struct page_image *image)
{
	struct pages *pages = user;
	pages->home->destroy(pages, image);
}

static void drop(void *user, struct page_image *image)
{
	struct pages *pages = user;
	pages->home->drop(pages, image);
}

struct page_executor resident_pages_executor_of(struct pages *pages)
{
	return (struct page_executor){
		.user = pages,
		.create = create_image,
		.destroy = destroy_image,
		.upload = upload,
		.read_back = read_back,
		.snapshot = pages_have_tally(&pages->params) ? snapshot : NULL,
		.settled = settled,
		.drop = pages->home->drop != NULL ? drop : NULL,
	};
}
