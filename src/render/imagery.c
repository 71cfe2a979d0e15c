/*
 * Imagery: its texture, its cache of pages, and the threads that read them.
 *
 *     the store -> (loader thread: read, decode) -> staging buffer -> (upload, begun and not waited for) -> a place in the texture
 *
 * A page small enough shares a layer with others. Then the layer's side is a power of two, and the shader rounds places in a page to
 * 1/256 of a texel. So a lookup gives the same bits wherever the page lies.
 */
#include "render/imagery.h"

#include <math.h>
#include <string.h>

#define LAYER_SIDE 2048u  /* texels along a side of a layer that several pages share, at most */
#define ALONE 200u        /* a page with a longer side has a layer of its own */
#define LAYERS_MOST 2048u /* every driver has so many */
#define SLOTS_LEAST 4u

/* --- where pages lie --- */

static uint32_t slots_of(const struct extent *extent, double budget)
{
	const double side = extent->cells + 1, count = floor(budget * 1e6 / (4 * side * side));
	const uint32_t across = side > ALONE ? 1 : LAYER_SIDE / (uint32_t)side;
	const double most = (double)across * across * LAYERS_MOST;
	return (uint32_t)fmax(fmin(count, fmin(most, 1 << 20)), SLOTS_LEAST);
}

/* Gives the texture's side, its layers, and how many pages lie along a side. */
static void place_pages(const struct extent *extent, uint32_t slots, uint32_t *side, uint32_t *layers, uint32_t *across)
{
	const uint32_t page = extent->cells + 1;
	*side = page;
	*across = 1;
	if (page <= ALONE) {
		for (*side = 1; *side < page; *side *= 2)
			;
		while (*side < LAYER_SIDE && (*side / page) * (*side / page) < slots)
			*side *= 2;
		*across = *side / page;
	}
	*layers = (slots + *across * *across - 1) / (*across * *across);
}

static struct gpu_rect rect_of(const struct render_imagery *imagery, uint32_t slot, uint32_t *layer)
{
	const uint32_t page = imagery->extent.cells + 1, in_layer = slot % (imagery->across * imagery->across);
	*layer = slot / (imagery->across * imagery->across);
	return (struct gpu_rect){in_layer % imagery->across * page, in_layer / imagery->across * page, page, page};
}

static size_t page_bytes(const struct extent *extent)
{
	return 4 * (size_t)(extent->cells + 1) * (extent->cells + 1);
}

/* --- loader threads --- */

/* Multiplies colours by their opacity. Those with opacity 0 are 0 already. So the mean of neighbours is right at an edge. */
static void multiply_by_opacity(uint8_t *pixels, size_t count)
{
	for (uint8_t *pixel = pixels; pixel < pixels + 4 * count; pixel += 4)
		for (int c = 0; c < 3 && pixel[3] > 0 && pixel[3] < 255; c++)
			pixel[c] = (uint8_t)((pixel[c] * pixel[3] + 127) / 255);
}

static enum status load(void *user, unsigned loader, struct page_image *image, const struct page_image *queued)
{
	struct render_imagery *imagery = user;
	const size_t side = imagery->extent.cells + 1;
	bool found;
	TRY(store_imagery_read(imagery->loaders[loader].reader, tile_from_key(image->key), image->bytes, &found));
	if (found)
		multiply_by_opacity(image->bytes, side * side);
	return STATUS_OK;
}

/* --- the GPU's thread --- */

static enum status create_image(void *user, enum page_image_kind kind, struct page_image *image)
{
	struct render_imagery *imagery = user;
	struct gpu_staging *staging;
	TRY(gpu_staging_create(imagery->gpu, page_bytes(&imagery->extent), &staging));
	image->memory = staging;
	image->bytes = gpu_staging_bytes(staging);
	return STATUS_OK;
}

static void destroy_image(void *user, struct page_image *image)
{
	gpu_staging_destroy(image->memory);
}

static enum status upload(void *user, uint32_t slot, struct page_image *image)
{
	struct render_imagery *imagery = user;
	uint32_t layer;
	const struct gpu_rect rect = rect_of(imagery, slot, &layer);
	gpu_texture_upload_from(imagery->texture, layer, rect, image->memory, 0);
	return gpu_check(imagery->gpu, "uploading imagery");
}

static enum status settled(void *user, const struct page_image *image, bool *is)
{
	struct render_imagery *imagery = user;
	*is = gpu_staging_idle(image->memory);
	return gpu_check(imagery->gpu, "uploading imagery");
}

enum status render_imagery_poll(struct render_imagery *imagery)
{
	TRY(page_cache_poll(imagery->cache));
	return page_cache_end_step(imagery->cache, "");
}

enum status render_imagery_want(struct render_imagery *imagery, const uint64_t *keys, size_t count)
{
	struct imagery_pages *wanted = &imagery->wanted;
	const struct imagery_pages *lists[2] = {&imagery->lacking, &(struct imagery_pages){.keys = (uint64_t *)keys, .count = count}};
	key_set_clear(&imagery->seen);
	wanted->count = 0;
	for (int k = 0; k < 2; k++)
		for (size_t i = 0; i < lists[k]->count && wanted->count < imagery->slots; i++) {
			const uint64_t key = lists[k]->keys[i];
			if (key_set_has(&imagery->seen, key))
				continue;
			TRY(key_set_add(&imagery->seen, key));
			TRY(mem_grow(&wanted->keys, &wanted->room, wanted->count + 1, sizeof *wanted->keys, "imagery"));
			wanted->keys[wanted->count++] = key;
		}
	page_cache_want(imagery->cache, wanted->keys, wanted->count);
	return STATUS_OK;
}

/* Waits for the pages of the group. */
static enum status pin_group(struct render_imagery *imagery)
{
	const struct imagery_pages *group = &imagery->group;
	while (imagery->pinned < group->count) {
		const size_t left = group->count - imagery->pinned, count = left < PAGE_PIN_MOST ? left : PAGE_PIN_MOST;
		TRY(page_cache_pin_all(imagery->cache, group->keys + imagery->pinned, count, imagery->places + imagery->pinned));
		imagery->pinned += count;
	}
	return STATUS_OK;
}

/* Finds those that are there, and notes the others. */
static enum status look_for_group(struct render_imagery *imagery)
{
	const struct imagery_pages *group = &imagery->group;
	struct imagery_pages *lacking = &imagery->lacking;
	for (size_t i = 0; i < group->count; i++) {
		if (page_cache_peek(imagery->cache, group->keys[i], true, &imagery->places[i]))
			continue;
		imagery->places[i] = IMAGERY_NO_SLOT;
		TRY(mem_grow(&lacking->keys, &lacking->room, lacking->count + 1, sizeof *lacking->keys, "imagery"));
		lacking->keys[lacking->count++] = group->keys[i];
	}
	return STATUS_OK;
}

enum status render_imagery_bring(struct render_imagery *imagery)
{
	TRY(mem_grow(&imagery->places, &imagery->place_room, imagery->group.count, sizeof *imagery->places, "imagery"));
	return imagery->complete ? pin_group(imagery) : look_for_group(imagery);
}

void render_imagery_release(struct render_imagery *imagery)
{
	for (size_t i = 0; i < imagery->pinned; i++)
		page_cache_unpin(imagery->cache, imagery->group.keys[i]);
	imagery->pinned = 0;
	imagery->group.count = 0;
	key_set_clear(&imagery->keys);
}

/* --- life --- */

enum status render_imagery_check(const struct store *store)
{
	if (store == NULL)
		return STATUS_OK;
	if (!store_has_imagery(store, NULL, NULL))
		return fail_with(STATUS_INPUT, "view.effects: imagery: %s has no imagery; add some with furrow import --imagery PICTURE.tif -o %s, or leave imagery out of the effects",
				 store_file_path(store), store_file_path(store));
	return store_imagery_check(store_file_path(store));
}

static enum status start(struct render_imagery *imagery, struct store *store, uint32_t loaders)
{
	uint32_t side, layers;
	place_pages(&imagery->extent, imagery->slots, &side, &layers, &imagery->across);
	TRY(gpu_texture_create_filtered(imagery->gpu, GPU_RGBA8, side, layers, &imagery->texture));
	for (int i = 0; i < IMAGERY_TABLES; i++)
		TRY(gpu_texture_create(imagery->gpu, GPU_RGBA32F, IMAGERY_TABLE_SIDE, IMAGERY_TABLE_SIDE, 0, &imagery->tables[i]));
	TRY(mem_make(&imagery->vectors, IMAGERY_VECTORS * 4, sizeof *imagery->vectors, "imagery"));
	const uint32_t readers = loaders > 0 ? loaders : 1;
	TRY(mem_zeroed(&imagery->loaders, readers, sizeof *imagery->loaders, "imagery"));
	for (; imagery->loader_count < readers; imagery->loader_count++)
		TRY(store_reader_create(store, &imagery->loaders[imagery->loader_count].reader));
	const struct page_params params = {
		.slots = imagery->slots,
		.loaders = loaders,
		.queue_soft = 1,
		.queue_most = PAGE_QUEUE_MOST(1, 1),
		.record_bytes = 1,
		.io = {imagery, load, NULL},
		.executor = {.user = imagery, .create = create_image, .destroy = destroy_image, .upload = upload, .settled = settled},
	};
	return page_cache_create(&params, &imagery->cache);
}

enum status render_imagery_create(struct gpu *gpu, struct store *store, double budget, uint32_t loaders, struct render_imagery **out)
{
	TRY(render_imagery_check(store));
	struct render_imagery *imagery = mem_calloc(1, sizeof *imagery);
	TRY_MEM(imagery, "imagery");
	imagery->gpu = gpu;
	imagery->extent = store_meta(store)->extent;
	imagery->coarsest = extent_coarsest(&imagery->extent);
	imagery->slots = slots_of(&imagery->extent, budget);
	store_has_imagery(store, &imagery->finest, NULL);
	enum status status = start(imagery, store, loaders);
	if (status != STATUS_OK) {
		render_imagery_destroy(imagery);
		return status;
	}
	*out = imagery;
	return STATUS_OK;
}

void render_imagery_destroy(struct render_imagery *imagery)
{
	if (imagery == NULL)
		return;
	page_cache_destroy(imagery->cache);
	for (uint32_t i = 0; i < imagery->loader_count; i++)
		store_reader_destroy(imagery->loaders[i].reader);
	for (int i = 0; i < IMAGERY_TABLES; i++)
		gpu_texture_destroy(imagery->tables[i]);
	gpu_texture_destroy(imagery->texture);
	for (size_t i = 0; i < imagery->draw_room; i++)
		mem_free(imagery->draws[i].pages.keys);
	key_set_finish(&imagery->keys);
	key_set_finish(&imagery->seen);
	mem_free_all(imagery->group.keys, imagery->lacking.keys, imagery->wanted.keys, imagery->places, imagery->vectors, imagery->loaders, imagery->draws, imagery);
}

void render_imagery_plan(const struct extent *extent, double budget, uint32_t loaders, struct plan *plan)
{
	const char *effect = scene_effect_row(EFFECT_IMAGERY)->name;
	uint32_t side, layers, across;
	place_pages(extent, slots_of(extent, budget), &side, &layers, &across);
	plan_add(plan, &(struct plan_line){.kind = PLAN_TEXTURE, .unit = PLAN_ONCE, .effect = effect, .object = -1, .amount = 1,
					   .bytes = gpu_texture_bytes(GPU_RGBA8, side, side, layers, 1)}, "imagery");
	plan_add(plan, &(struct plan_line){.kind = PLAN_TEXTURE, .unit = PLAN_ONCE, .effect = effect, .object = -1, .amount = IMAGERY_TABLES,
					   .bytes = IMAGERY_TABLES * gpu_texture_bytes(GPU_RGBA32F, IMAGERY_TABLE_SIDE, IMAGERY_TABLE_SIDE, 0, 1)}, "tables of imagery");
	const uint32_t loads = page_load_images(loaders);
	plan_add(plan, &(struct plan_line){.kind = PLAN_BUFFER, .unit = PLAN_ONCE, .effect = effect, .object = -1, .amount = loads,
					   .bytes = loads * page_bytes(extent)}, "loads: imagery");
	if (loaders > 0)
		plan_add(plan, &(struct plan_line){.kind = PLAN_THREAD, .effect = effect, .object = -1, .amount = loaders}, PAGE_LOADER_THREAD);
}
