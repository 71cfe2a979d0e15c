/*
 * Pictures of pages whose home is host memory: slots of the GPU mirror the tiles that are drawn.
 *
 *     a mirror:  stale after a load (everything) or a change (a rectangle of planes) -> shown
 */
#include "resident/pages_internal.h"

void resident_pages_mirror(struct pages *pages, struct gpu *gpu, struct gpu_slots *slots)
{
	struct host_slots *host = pages->params.host;
	assert(host != NULL);
	pages->params.gpu = gpu;
	pages->params.slots = slots;
	for (uint32_t i = 0; i < host->count; i++)
		host->entries[i].shown_base = host->entries[i].shown_planes = false;
}

static enum status show_base(struct pages *pages, uint32_t slot, struct host_entry *entry)
{
	struct gpu_slots *slots = pages->params.slots;
	enum status status;
	TRY_OR(done, gpu_slots_put_base(slots, slot, entry->tile.base));
	if (entry->classed && pages->params.classes_drawn)
		TRY_OR(done, gpu_slots_put_classes(slots, slot, entry->tile.classes));
done:
	entry->shown_base = status == STATUS_OK;
	return status;
}

static enum status show_planes(struct pages *pages, uint32_t slot, struct host_entry *entry)
{
	const struct host_slots *host = pages->params.host;
	const struct gpu_rect whole = {0, 0, host->cells + 1, host->cells + 1};
	const void *planes[PLANES];
	bool any = false;
	for (int plane = 0; plane < PLANES; plane++) {
		planes[plane] = host_tile_plane(host, &entry->tile, plane);
		any = any || entry->tile.planes[plane] != NULL;
	}
	enum status status = STATUS_OK;
	if (any)
		status = gpu_slots_put_drawn(pages->params.slots, slot, entry->shown_planes ? entry->changed : whole, planes);
	else
		gpu_slots_undeform(pages->params.slots, slot);
	entry->shown_planes = status == STATUS_OK;
	if (status == STATUS_OK)
		entry->changed = (struct gpu_rect){.width = 0};
	return status;
}

enum status resident_pages_show(struct pages *pages, uint32_t slot, bool planes)
{
	if (pages->params.host == NULL)
		return STATUS_OK;
	assert(pages->params.slots != NULL);
	struct host_entry *entry = host_entry(pages->params.host, slot);
	TRY(entry->shown_base ? STATUS_OK : show_base(pages, slot, entry));
	if (planes && (!entry->shown_planes || entry->changed.width > 0))
		TRY(show_planes(pages, slot, entry));
	return STATUS_OK;
}

bool resident_pages_is_deformed(const struct pages *pages, uint32_t slot)
{
	return pages->home->is_deformed(pages, slot);
}
