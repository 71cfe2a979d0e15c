/*
 * Pages whose home is host memory. An image is a tile. A loader decodes into it; then it changes places with the tile that was in the slot. An
 * image that waits for a commit shares the planes of the slot.
 *
 * A commit must write zeros where the store has a plane and the page has none any more. So an image of a changed page has every plane of
 * params.planes, if need be the zeros that all share.
 */
#include <string.h>

#include "resident/pages_internal.h"

static struct host_tile *tile_of(const struct page_image *image)
{
	return image->memory;
}

static enum status create(struct pages *pages, enum page_image_kind kind, struct page_image *image)
{
	image->bytes = kind == PAGE_SNAPSHOT_IMAGE ? mem_calloc(1, PAGES_TALLY_BYTES) : NULL;
	image->memory = kind == PAGE_SNAPSHOT_IMAGE ? NULL : mem_calloc(1, sizeof(struct host_tile));
	if (image->bytes == NULL && image->memory == NULL)
		return fail_memory("an image of a page");
	pages->host_bytes += kind == PAGE_SNAPSHOT_IMAGE ? PAGES_TALLY_BYTES : 0;
	return STATUS_OK;
}

static void destroy(struct pages *pages, struct page_image *image)
{
	if (image->memory != NULL)
		resident_host_tile_finish(pages->params.host, image->memory);
	mem_free_all(image->memory, image->bytes);
}

static void drop(struct pages *pages, struct page_image *image)
{
	if (image->memory != NULL)
		resident_host_tile_drop(pages->params.host, image->memory, ~0u);
}

static enum status base(struct pages *pages, struct ground *ground, struct page_image *image)
{
	int32_t *posts;
	TRY(resident_host_tile_base(pages->params.host, tile_of(image), &posts));
	return resident_ground_posts(ground, tile_from_key(image->key), posts);
}

static enum status room(struct pages *pages, struct page_image *image, uint8_t **classes, uint8_t **numbers)
{
	if (classes != NULL)
		TRY(resident_host_tile_classes(pages->params.host, tile_of(image), classes));
	if (numbers != NULL)
		TRY(resident_host_tile_levels(pages->params.host, tile_of(image), numbers));
	return STATUS_OK;
}

static enum status planes(struct pages *pages, struct page_image *image, unsigned mask, bool zeros, void *into[PLANES])
{
	struct host_tile *tile = tile_of(image);
	TRY(resident_host_tile_write(pages->params.host, tile, mask));
	for (int plane = 0; plane < PLANES; plane++)
		if (mask & PLANE_BIT(plane))
			into[plane] = tile->planes[plane]->posts;
	image->flags |= zeros ? mask : 0;
	return STATUS_OK;
}

static void keep(struct pages *pages, struct page_image *image, unsigned present)
{
	resident_host_tile_drop(pages->params.host, tile_of(image), ~present);
	image->flags = present;
}

static void copy(struct pages *pages, struct page_image *image, const struct page_image *queued)
{
	resident_host_tile_share(pages->params.host, tile_of(queued), tile_of(image), 0);
	image->flags = queued->flags;
}

static enum status fill(struct pages *pages, struct page_image *image, const void *bytes)
{
	struct host_slots *slots = pages->params.host;
	struct host_tile *tile = tile_of(image);
	const struct host_tile none = {.base = NULL};
	if (bytes == NULL) {
		resident_host_tile_share(slots, &none, tile, pages->planes);
		return STATUS_OK;
	}
	TRY(resident_host_tile_write(slots, tile, pages->planes));
	for (int plane = 0; plane < PLANES; plane++)
		if (pages->planes & PLANE_BIT(plane))
			memcpy(tile->planes[plane]->posts, (const char *)bytes + pages->layout.places[plane],
			       pages->layout.posts * plane_bytes((enum plane)plane));
	return STATUS_OK;
}

static const void *plane_of(const struct pages *pages, const struct page_image *changed, enum plane plane)
{
	return tile_of(changed)->planes[plane]->posts;
}

static enum status upload(struct pages *pages, uint32_t slot, struct page_image *image)
{
	struct host_slots *slots = pages->params.host;
	struct host_entry *entry = host_entry(slots, slot);
	const struct host_tile loaded = *tile_of(image);
	resident_host_tile_drop(slots, &entry->tile, ~0u);
	*tile_of(image) = entry->tile; /* its memory is for the next load */
	*entry = (struct host_entry){.tile = loaded, .classed = pages_have_classes(pages, tile_from_key(image->key))};
	return STATUS_OK;
}

static enum status read_back(struct pages *pages, uint32_t slot, struct page_image *image)
{
	resident_host_tile_share(pages->params.host, &host_entry(pages->params.host, slot)->tile, tile_of(image), pages->planes);
	return STATUS_OK;
}

static enum status snapshot(struct pages *pages, struct page_image *image)
{
	return pages->params.tally(pages->params.user, image->bytes);
}

static enum status settled(const struct pages *pages, const struct page_image *image, bool *settled)
{
	*settled = true;
	return STATUS_OK;
}

static enum status read_plane(const struct pages *pages, uint32_t slot, enum plane plane, void *posts)
{
	const struct host_slots *slots = pages->params.host;
	const void *held = host_tile_plane(slots, &host_entry(slots, slot)->tile, plane);
	const size_t bytes = slots->posts * plane_bytes(plane);
	if (held != NULL)
		memcpy(posts, held, bytes);
	else
		memset(posts, 0, bytes);
	return STATUS_OK;
}

static bool is_deformed(const struct pages *pages, uint32_t slot)
{
	const struct host_tile *tile = &host_entry(pages->params.host, slot)->tile;
	for (int plane = 0; plane < PLANES; plane++)
		if (tile->planes[plane] != NULL)
			return true;
	return false;
}

const struct pages_home resident_pages_host = {
	.create = create, .destroy = destroy, .drop = drop, .base = base, .room = room, .planes = planes, .keep = keep, .copy = copy,
	.fill = fill, .plane = plane_of, .upload = upload, .read_back = read_back, .snapshot = snapshot, .settled = settled, .read_plane = read_plane,
	.is_deformed = is_deformed,
};
