/* Pages whose home is a slot of the GPU. An image is a staging buffer, with the layout of pages_internal.h. */
#include <string.h>

#include "resident/pages_internal.h"

static struct pages_head *head_of(const struct page_image *loaded)
{
	return loaded->bytes;
}

static int32_t *base_of(const struct pages *pages, const struct page_image *loaded)
{
	return (int32_t *)((char *)loaded->bytes + pages->layout.base);
}

/* A loaded image has planes after its base, a changed image at its beginning. */
static void *loaded_plane(const struct pages *pages, const struct page_image *loaded, int plane)
{
	return (char *)loaded->bytes + pages->layout.planes + pages->layout.places[plane];
}

static enum status create(struct pages *pages, enum page_image_kind kind, struct page_image *image)
{
	const size_t sizes[PAGE_IMAGE_KINDS] = {
		[PAGE_LOADED_IMAGE] = pages->layout.loaded,
		[PAGE_CHANGED_IMAGE] = pages->layout.changed,
		[PAGE_SNAPSHOT_IMAGE] = PAGES_TALLY_BYTES,
	};
	struct gpu_staging *staging;
	TRY(gpu_staging_create(pages->params.gpu, sizes[kind], &staging));
	image->memory = staging;
	image->bytes = gpu_staging_bytes(staging);
	pages->host_bytes += sizes[kind];
	return STATUS_OK;
}

static void destroy(struct pages *pages, struct page_image *image)
{
	gpu_staging_destroy(image->memory);
}

static enum status base(struct pages *pages, struct ground *ground, struct page_image *image)
{
	const struct tile tile = tile_from_key(image->key);
	struct pages_head *head = head_of(image);
	*head = (struct pages_head){0, 0, 0};
	if (tile.level < 0)
		return resident_ground_patch(ground, tile, base_of(pages, image), &head->shift, &head->sub_x, &head->sub_y);
	return resident_ground_posts(ground, tile, base_of(pages, image));
}

static enum status room(struct pages *pages, struct page_image *image, uint8_t **classes, uint8_t **numbers)
{
	if (classes != NULL)
		*classes = (uint8_t *)image->bytes + pages->layout.classes;
	assert(numbers == NULL); /* contacts that read them are computed in host memory */
	return STATUS_OK;
}

static enum status planes(struct pages *pages, struct page_image *image, unsigned mask, bool zeros, void *into[PLANES])
{
	for (int plane = 0; plane < PLANES; plane++) {
		if (!(mask & PLANE_BIT(plane)))
			continue;
		into[plane] = loaded_plane(pages, image, plane);
		if (zeros && !(image->flags & PLANE_BIT(plane)))
			memset(into[plane], 0, resident_pages_plane_room(&pages->layout, (enum plane)plane));
	}
	image->flags |= zeros ? mask : 0;
	return STATUS_OK;
}

static void keep(struct pages *pages, struct page_image *image, unsigned present)
{
	image->flags = present;
}

static void copy(struct pages *pages, struct page_image *image, const struct page_image *queued)
{
	memcpy((char *)image->bytes + pages->layout.planes, queued->bytes, pages->layout.changed);
	image->flags = queued->flags;
}

static enum status fill(struct pages *pages, struct page_image *image, const void *bytes)
{
	if (bytes != NULL)
		memcpy(image->bytes, bytes, pages->layout.changed);
	else
		memset(image->bytes, 0, pages->layout.changed);
	return STATUS_OK;
}

static const void *plane_of(const struct pages *pages, const struct page_image *changed, enum plane plane)
{
	return pages_plane(pages, changed->bytes, plane);
}

/* Finds where the wanted planes are in an image whose planes begin at `planes`. */
static void places_of(const struct pages *pages, unsigned wanted, size_t planes, size_t places[PLANES])
{
	for (int plane = 0; plane < PLANES; plane++)
		places[plane] = wanted & PLANE_BIT(plane) ? planes + pages->layout.places[plane] : GPU_NO_PLANE;
}

static enum status upload_base(struct pages *pages, uint32_t slot, struct page_image *image)
{
	struct gpu_slots *slots = pages->params.slots;
	struct gpu_staging *staging = image->memory;
	const struct pages_head *head = head_of(image);
	const struct relief *relief = store_relief(pages->params.store);
	const size_t at = pages->layout.base;
	if (head->shift == 0)
		return gpu_slots_upload_base(slots, slot, staging, at);
	if (relief_any(relief))
		return gpu_slots_subdivide_relief(slots, slot, staging, at, head->sub_x, head->sub_y, tile_from_key(image->key), relief);
	return gpu_slots_subdivide_base(slots, slot, staging, at, head->shift, head->sub_x, head->sub_y);
}

static enum status upload(struct pages *pages, uint32_t slot, struct page_image *image)
{
	struct gpu_slots *slots = pages->params.slots;
	const struct pages_layout *layout = &pages->layout;
	const struct tile tile = tile_from_key(image->key);
	size_t places[PLANES];
	TRY(upload_base(pages, slot, image));
	if (pages_have_classes(pages, tile))
		TRY(gpu_slots_upload_classes(slots, slot, image->memory, layout->classes));
	places_of(pages, image->flags, layout->planes, places);
	if (image->flags != 0)
		return gpu_slots_upload_deform(slots, slot, image->memory, places);
	gpu_slots_undeform(slots, slot);
	return STATUS_OK;
}

static enum status read_back(struct pages *pages, uint32_t slot, struct page_image *image)
{
	size_t places[PLANES];
	places_of(pages, pages->planes, 0, places);
	return gpu_slots_read_deform(pages->params.slots, slot, image->memory, places);
}

static enum status snapshot(struct pages *pages, struct page_image *image)
{
	return pages->params.snapshot(pages->params.user, image->memory);
}

static enum status settled(const struct pages *pages, const struct page_image *image, bool *settled)
{
	*settled = gpu_staging_idle(image->memory);
	return *settled ? gpu_check(pages->params.gpu, "uploads and read-backs") : STATUS_OK;
}

static enum status read_plane(const struct pages *pages, uint32_t slot, enum plane plane, void *posts)
{
	const struct gpu_slot *held = gpu_slots_get(pages->params.slots, slot);
	const uint32_t side = pages->layout.cells + 1;
	if (held->planes[plane] == NULL)
		memset(posts, 0, pages->layout.posts * plane_bytes(plane));
	else
		gpu_texture_read(held->planes[plane], 0, (struct gpu_rect){0, 0, side, side}, posts);
	return gpu_check(pages->params.gpu, "reading the ground for a query");
}

static bool is_deformed(const struct pages *pages, uint32_t slot)
{
	return gpu_slots_get(pages->params.slots, slot)->target != NULL;
}

const struct pages_home resident_pages_gpu = {
	.create = create, .destroy = destroy, .base = base, .room = room, .planes = planes, .keep = keep, .copy = copy, .fill = fill, .plane = plane_of,
	.upload = upload, .read_back = read_back, .snapshot = snapshot, .settled = settled, .read_plane = read_plane, .is_deformed = is_deformed,
};
