/*
 * Moves pages into slots and out of them, on the GPU's thread. Transfers are begun here, and later settled.
 *
 * When a page coarser than the working level becomes resident, newer values are laid over it. First come the versions that are
 * not in the store yet, then the pages that are dirty in a slot. So it is the decimation of the finer level (law 4), also
 * between two commits.
 */
#include <string.h>

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

static void copy_post(const struct pages *pages, void *fine, size_t from, void *coarse, size_t to)
{
	((int32_t *)pages_plane(pages, coarse, PLANE_OFFSET))[to] = ((int32_t *)pages_plane(pages, fine, PLANE_OFFSET))[from];
	if (pages->planes & PLANE_BIT(PLANE_DISTURBANCE))
		((uint8_t *)pages_plane(pages, coarse, PLANE_DISTURBANCE))[to] = ((uint8_t *)pages_plane(pages, fine, PLANE_DISTURBANCE))[from];
}

static void overlay_queued(void *user, const struct page_image *fine)
{
	struct overlay *overlay = user;
	struct pages *pages = overlay->pages;
	int steps;
	uint32_t to_x, to_y;
	struct gpu_rect rect;
	if (!overlaps(pages, tile_from_key(fine->key), overlay->tile, &steps, &to_x, &to_y, &rect))
		return;
	size_t stride = pages->layout.cells + 1;
	void *planes = pages_planes(pages, overlay->image);
	if (overlay->image->flags == 0)
		memset(planes, 0, pages->layout.changed);
	overlay->image->flags = pages->planes & GPU_DRAWN_PLANES;
	uint32_t step = 1u << steps;
	for (uint32_t y = 0; y < rect.height; y += step)
		for (uint32_t x = 0; x < rect.width; x += step) {
			size_t from = (rect.y + y) * stride + rect.x + x, to = (to_y + y / step) * stride + to_x + x / step;
			copy_post(pages, fine->bytes, from, planes, to);
		}
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
	struct gpu_slots *slots = overlay->pages->params.slots;
	overlay->status = gpu_slots_decimate(slots, slot, rect, steps, overlay->slot, to_x, to_y);
}

/* Finds where the wanted planes are in an image whose planes begin at `planes`. */
static void places_of(const struct pages *pages, unsigned wanted, size_t planes, size_t places[PLANES])
{
	for (int plane = 0; plane < PLANES; plane++)
		places[plane] = wanted & PLANE_BIT(plane) ? planes + pages->layout.places[plane] : GPU_NO_PLANE;
}

static enum status upload(void *user, uint32_t slot, struct page_image *image)
{
	struct pages *pages = user;
	struct gpu_slots *slots = pages->params.slots;
	struct gpu_staging *staging = image->memory;
	const struct pages_layout *layout = &pages->layout;
	struct pages_head *head = pages_head(image);
	struct overlay overlay = {pages, image, tile_from_key(image->key), slot, STATUS_OK};
	const struct relief *relief = store_relief(pages->params.store);
	if (image->overlays)
		page_cache_each_queued(pages->cache, overlay_queued, &overlay);
	enum status status =
		head->shift == 0 ? gpu_slots_upload_base(slots, slot, staging, layout->base)
		: relief_any(relief)
			? gpu_slots_subdivide_relief(slots, slot, staging, layout->base,
						     head->sub_x, head->sub_y, overlay.tile, relief)
			: gpu_slots_subdivide_base(slots, slot, staging, layout->base, head->shift,
						   head->sub_x, head->sub_y);
	if (status != STATUS_OK)
		return status;
	if (pages_have_classes(pages, overlay.tile))
		status = gpu_slots_upload_classes(slots, slot, staging, layout->classes);
	if (status == STATUS_OK && pages_have_numbers(pages, overlay.tile))
		status = gpu_slots_upload_numbers(slots, slot, staging, layout->numbers);
	if (status != STATUS_OK)
		return status;
	size_t places[PLANES];
	places_of(pages, image->flags, layout->planes, places);
	if (image->flags != 0)
		status = gpu_slots_upload_deform(slots, slot, staging, places);
	else
		gpu_slots_undeform(slots, slot);
	if (status == STATUS_OK && image->overlays)
		page_cache_each_resident(pages->cache, overlay_resident, &overlay);
	return status == STATUS_OK ? overlay.status : status;
}

static enum status read_back(void *user, uint32_t slot, struct page_image *image)
{
	struct pages *pages = user;
	double started = clock_seconds();
	size_t places[PLANES];
	places_of(pages, pages->planes, 0, places);
	enum status status =
		pages->params.before_read_back(pages->params.user, tile_from_key(image->key), slot);
	if (status == STATUS_OK)
		status = gpu_slots_read_deform(pages->params.slots, slot, image->memory, places);
	image->flags = pages->planes;
	pages->readback_ms += (clock_seconds() - started) * 1e3;
	return status;
}

static enum status snapshot(void *user, struct page_image *image)
{
	struct pages *pages = user;
	return pages->params.snapshot(pages->params.user, image->memory);
}

static enum status settled(void *user, const struct page_image *image, bool *settled)
{
	const struct pages *pages = user;
	*settled = gpu_staging_idle(image->memory);
	return *settled ? gpu_check(pages->params.gpu, "uploads and read-backs") : STATUS_OK;
}

static enum status create_image(void *user, enum page_image_kind kind, struct page_image *image)
{
	struct pages *pages = user;
	const size_t sizes[PAGE_IMAGE_KINDS] = {
		[PAGE_LOADED_IMAGE] = pages->layout.loaded,
		[PAGE_CHANGED_IMAGE] = pages->layout.changed,
		[PAGE_SNAPSHOT_IMAGE] = PAGES_TALLY_BYTES,
	};
	size_t bytes = sizes[kind];
	struct gpu_staging *staging;
	enum status status = gpu_staging_create(pages->params.gpu, bytes, &staging);
	if (status != STATUS_OK)
		return status;
	image->memory = staging;
	image->bytes = gpu_staging_bytes(staging);
	pages->host_bytes += bytes;
	pages->changed_images += kind == PAGE_CHANGED_IMAGE;
	return STATUS_OK;
}

static void destroy_image(void *user, struct page_image *image)
{
	gpu_staging_destroy(image->memory);
}

struct page_executor resident_pages_executor_of(struct pages *pages)
{
	return (struct page_executor){
		.user = pages,
		.create = create_image,
		.destroy = destroy_image,
		.upload = upload,
		.read_back = read_back,
		.snapshot = pages->params.snapshot != NULL ? snapshot : NULL,
		.settled = settled,
	};
}
