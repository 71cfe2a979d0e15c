#include "run/pages.h"

#include <assert.h>
#include <errno.h>
#include <string.h>
#include <unistd.h>

#include "run/ground.h"

#define FLAG_DEFORMED 1u
#define GROUND_TILES 4
#define EPOCH_BYTES ((size_t)16 << 20)

/* A loaded image's bytes: this, base posts or patch, and the planes: offset, dirt. A changed one's: the
 * planes alone. */
struct head {
	int shift; /* 0: the base is posts; else a patch to subdivide */
	uint32_t sub_x, sub_y;
};

struct layout {
	uint32_t cells;
	size_t posts;                /* of a tile */
	size_t base, planes, loaded; /* bytes: where they begin, and all of a loaded image */
	size_t dirt, changed;        /* bytes: from the planes' begin, and all of them */
};

struct pages {
	struct pages_params params;
	struct layout layout;
	struct page_cache *cache;
	struct ground *grounds[16]; /* one a loader */
	struct store_page *commit_pages; /* the writer's */
	size_t commit_room;
	double readback_ms;     /* the GPU's thread's, and */
	uint64_t host_bytes;
	struct mutex mutex;     /* guards io */
	struct pages_io io;
};

static struct layout layout_of(uint32_t cells, bool dirt)
{
	struct layout layout = {.cells = cells, .posts = (size_t)(cells + 1) * (cells + 1)};
	layout.dirt = layout.posts * sizeof(int32_t);
	layout.changed = layout.dirt + (dirt ? layout.posts : 0);
	layout.base = sizeof(struct head);
	layout.planes = layout.base + layout.posts * sizeof(int32_t);
	layout.loaded = layout.planes + layout.changed;
	return layout;
}

static struct head *head_of(const struct page_image *loaded)
{
	return loaded->bytes;
}

static int32_t *base_of(const struct pages *pages, const struct page_image *loaded)
{
	return (int32_t *)((char *)loaded->bytes + pages->layout.base);
}

static int32_t *offset_in(void *planes)
{
	return planes;
}

static uint8_t *dirt_in(const struct pages *pages, void *planes)
{
	return pages->params.dirt ? (uint8_t *)planes + pages->layout.dirt : NULL;
}

static void *loaded_planes(const struct pages *pages, const struct page_image *loaded)
{
	return (char *)loaded->bytes + pages->layout.planes;
}

/* --- loader threads --- */

static enum status load_base(struct pages *pages, struct ground *ground, struct tile tile,
			     struct page_image *image)
{
	struct head *head = head_of(image);
	*head = (struct head){0, 0, 0};
	if (tile.level < 0)
		return ground_patch(ground, tile, base_of(pages, image), &head->shift, &head->sub_x, &head->sub_y);
	return ground_posts(ground, tile, base_of(pages, image));
}

static enum status load_planes(struct pages *pages, struct ground *ground, struct tile tile,
			       struct page_image *image, const struct page_image *queued)
{
	image->flags = 0;
	image->overlays = tile.level > pages->params.level;
	void *planes = loaded_planes(pages, image);
	if (queued != NULL) {
		memcpy(planes, queued->bytes, pages->layout.changed);
		image->flags = FLAG_DEFORMED;
		return STATUS_OK;
	}
	if (tile.level < pages->params.level)
		return STATUS_OK;
	unsigned wanted = STORE_PLANE_OFFSET | (pages->params.dirt ? STORE_PLANE_DIRT : 0), present;
	enum status status = store_read_deformed(ground_reader(ground), tile, wanted, offset_in(planes),
						 dirt_in(pages, planes), &present);
	if (status == STATUS_OK && present != 0)
		image->flags = FLAG_DEFORMED;
	return status;
}

static enum status load(void *user, unsigned loader, struct page_image *image, const struct page_image *queued)
{
	struct pages *pages = user;
	struct ground *ground = pages->grounds[loader];
	struct tile tile = tile_from_key(image->key);
	double started = clock_seconds();
	enum status status = load_base(pages, ground, tile, image);
	if (status == STATUS_OK)
		status = load_planes(pages, ground, tile, image, queued);
	mutex_lock(&pages->mutex);
	if (status == STATUS_OK) {
		pages->io.tiles_read++;
		pages->io.bytes_read += (int64_t)pages->layout.loaded; /* as decoded */
	}
	pages->io.load_ms += (clock_seconds() - started) * 1e3;
	mutex_unlock(&pages->mutex);
	return status;
}

/* --- the writer thread --- */

/* What the writer thread makes the record's text of. */
struct describing {
	struct pages *pages;
	const struct record *record;
	char *state;
};

static const char *describe(void *user, const struct store_epoch_result *result)
{
	struct describing *describing = user;
	const struct pages_params *params = &describing->pages->params;
	const struct pages_io *io = &describing->pages->io; /* of these the writer's alone */
	describing->state = record_print(describing->record, params->scene, io->below + result->below,
					 io->above + result->above);
	return describing->state;
}

static enum status acknowledge(struct pages *pages, int64_t epoch, int64_t step)
{
	FILE *log = pages->params.epochs;
	if (fprintf(log, "epoch %lld step %lld\n", (long long)epoch, (long long)step) < 0 || fflush(log) != 0)
		return fail_with(STATUS_FAILED, "epochs.log: %s; free some disk space", strerror(errno));
	return STATUS_OK;
}

static enum status commit(void *user, const struct page_image *const *images, size_t count, const void *bytes)
{
	struct pages *pages = user;
	const struct record *record = bytes;
	double started = clock_seconds();
	if (count > pages->commit_room) {
		struct store_page *room = mem_realloc(pages->commit_pages, count, sizeof *room);
		if (room == NULL)
			return fail_memory("an epoch");
		pages->commit_pages = room;
		pages->commit_room = count;
	}
	for (size_t i = 0; i < count; i++)
		pages->commit_pages[i] = (struct store_page){
			.tile = tile_from_key(images[i]->key),
			.planes = STORE_PLANE_OFFSET | (pages->params.dirt ? STORE_PLANE_DIRT : 0),
			.offset = offset_in(images[i]->bytes),
			.dirt = dirt_in(pages, images[i]->bytes),
		};
	struct describing describing = {pages, record, NULL};
	struct store_run run = {
		.scene_hash = pages->params.scene->hash,
		.step = record->step,
		.time = record->time,
		.describe = describe,
		.user = &describing,
	};
	struct store_epoch_result result;
	enum status status = store_epoch(pages->params.store, pages->commit_pages, count, &run, &result);
	mem_free(describing.state);
	if (status != STATUS_OK)
		return status;
	status = acknowledge(pages, result.epoch, record->step);
	if (status == STATUS_OK)
		status = store_bound_wal(pages->params.store);
	mutex_lock(&pages->mutex);
	pages->io.commits++;
	pages->io.tiles_written += result.tiles_written;
	pages->io.bytes_written += result.bytes_written;
	pages->io.below += result.below;
	pages->io.above += result.above;
	pages->io.writeback_ms += (clock_seconds() - started) * 1e3;
	mutex_unlock(&pages->mutex);
	return status;
}

/* --- the GPU's thread --- */

struct overlay {
	struct pages *pages;
	struct page_image *image;
	struct tile tile;
	uint32_t slot;
	enum status status;
};

/* The posts of `fine` that are posts of `coarse` too: where they go. steps levels apart. */
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
	void *planes = loaded_planes(pages, overlay->image);
	if (!(overlay->image->flags & FLAG_DEFORMED)) {
		memset(planes, 0, pages->layout.changed);
		overlay->image->flags |= FLAG_DEFORMED;
	}
	uint32_t step = 1u << steps;
	for (uint32_t y = 0; y < rect.height; y += step)
		for (uint32_t x = 0; x < rect.width; x += step) {
			size_t from = (rect.y + y) * stride + rect.x + x, to = (to_y + y / step) * stride + to_x + x / step;
			offset_in(planes)[to] = offset_in(fine->bytes)[from];
			if (pages->params.dirt)
				dirt_in(pages, planes)[to] = dirt_in(pages, fine->bytes)[from];
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
	overlay->status = gpu_slots_deform(slots, overlay->slot);
	if (overlay->status == STATUS_OK)
		overlay->status = gpu_slots_decimate(slots, slot, rect, steps, overlay->slot, to_x, to_y);
}

/* Where the dirt is in an image whose planes begin at `planes`. */
static size_t dirt_place(const struct pages *pages, size_t planes)
{
	return pages->params.dirt ? planes + pages->layout.dirt : GPU_NO_PLANE;
}

static enum status upload(void *user, uint32_t slot, struct page_image *image)
{
	struct pages *pages = user;
	struct gpu_slots *slots = pages->params.slots;
	struct gpu_staging *staging = image->memory;
	const struct layout *layout = &pages->layout;
	struct head *head = head_of(image);
	struct overlay overlay = {pages, image, tile_from_key(image->key), slot, STATUS_OK};
	if (image->overlays)
		page_cache_each_queued(pages->cache, overlay_queued, &overlay);
	enum status status =
		head->shift == 0 ? gpu_slots_upload_base(slots, slot, staging, layout->base)
				 : gpu_slots_subdivide_base(slots, slot, staging, layout->base, head->shift,
							    head->sub_x, head->sub_y);
	if (status != STATUS_OK)
		return status;
	if (image->flags & FLAG_DEFORMED)
		status = gpu_slots_upload_deform(slots, slot, staging, layout->planes,
						 dirt_place(pages, layout->planes));
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
	enum status status =
		pages->params.before_read_back(pages->params.user, tile_from_key(image->key), slot);
	if (status == STATUS_OK)
		status = gpu_slots_read_deform(pages->params.slots, slot, image->memory, 0, dirt_place(pages, 0));
	image->flags = FLAG_DEFORMED;
	pages->readback_ms += (clock_seconds() - started) * 1e3;
	return status;
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
	size_t bytes = kind == PAGE_LOADED_IMAGE ? pages->layout.loaded : pages->layout.changed;
	struct gpu_staging *staging;
	enum status status = gpu_staging_create(pages->params.gpu, bytes, &staging);
	if (status != STATUS_OK)
		return status;
	image->memory = staging;
	image->bytes = gpu_staging_bytes(staging);
	pages->host_bytes += bytes;
	return STATUS_OK;
}

static void destroy_image(void *user, struct page_image *image)
{
	gpu_staging_destroy(image->memory);
}

/* --- life --- */

/* Changed pages for an epoch: more make it cheaper a page, and take memory. */
static uint32_t epoch_pages(uint32_t slots, const struct layout *layout)
{
	enum { LEAST = 4, MOST = 64 };
	size_t fit = EPOCH_BYTES / layout->changed;
	uint32_t pages = fit < LEAST ? LEAST : fit > MOST ? MOST : (uint32_t)fit;
	return pages < slots ? pages : slots;
}

static struct page_params cache_params(const struct pages_params *params, const struct layout *layout)
{
	uint32_t soft = epoch_pages(params->count, layout);
	return (struct page_params){
		.slots = params->count,
		.loaders = params->loaders,
		.queue_soft = soft,
		.queue_most = PAGE_QUEUE_MOST(soft, params->step_pages),
		.epoch_age = params->epoch_age,
		.record_bytes = record_bytes(params->scene->object_count),
		.trace = params->trace,
	};
}

/* Without loaders the GPU's thread reads. */
static uint32_t reader_count(const struct pages_params *params)
{
	return params->loaders > 0 ? params->loaders : 1;
}

enum status pages_create(const struct pages_params *params, struct pages **out)
{
	struct pages *pages = mem_calloc(1, sizeof *pages);
	if (pages == NULL)
		return fail_memory("the page cache");
	assert(params->loaders <= sizeof pages->grounds / sizeof *pages->grounds);
	pages->params = *params;
	pages->io.below = params->below;
	pages->io.above = params->above;
	mutex_init(&pages->mutex);
	pages->layout = layout_of(store_meta(params->store)->world.cells, params->dirt);
	enum status status = STATUS_OK;
	for (uint32_t i = 0; i < reader_count(params) && status == STATUS_OK; i++)
		status = ground_create(params->store, GROUND_TILES, &pages->grounds[i]);
	struct page_params cache = cache_params(params, &pages->layout);
	cache.io = (struct page_io){pages, load, commit};
	cache.executor = (struct page_executor){pages, create_image, destroy_image, upload, read_back, settled};
	if (status == STATUS_OK)
		status = page_cache_create(&cache, &pages->cache);
	if (status != STATUS_OK) {
		pages_destroy(pages);
		return status;
	}
	*out = pages;
	return STATUS_OK;
}

void pages_destroy(struct pages *pages)
{
	if (pages == NULL)
		return;
	page_cache_destroy(pages->cache);
	for (uint32_t i = 0; i < reader_count(&pages->params); i++)
		ground_destroy(pages->grounds[i]);
	mem_free(pages->commit_pages);
	mutex_finish(&pages->mutex);
	mem_free(pages);
}

struct page_cache *pages_cache(struct pages *pages)
{
	return pages->cache;
}

void pages_io(struct pages *pages, struct pages_io *io)
{
	mutex_lock(&pages->mutex);
	*io = pages->io;
	mutex_unlock(&pages->mutex);
	io->readback_ms = pages->readback_ms;
	io->host_bytes = pages->host_bytes;
}

void pages_budget(const struct pages *pages, struct pages_budget *budget)
{
	const struct pages_params *params = &pages->params;
	const struct layout *layout = &pages->layout;
	struct page_params cache = cache_params(params, layout);
	uint64_t plane = layout->posts * sizeof(int32_t);
	*budget = (struct pages_budget){
		.slots = params->count * (plane + layout->changed),
		.loads = page_load_images(params->loaders) * (uint64_t)layout->loaded,
		.queue = cache.queue_most * (uint64_t)layout->changed,
		.ground = reader_count(params) * (GROUND_TILES + 1) * plane,
	};
}
