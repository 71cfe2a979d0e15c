/* Creates and destroys pages, and tells their memory and figures. */
#include <assert.h>

#include "resident/pages_internal.h"

#define GROUND_TILES 4
#define ALIGN sizeof(int32_t) /* bytes of a plane, whatever is before it */
#define COMMIT_BYTES ((size_t)16 << 20)

size_t resident_pages_plane_room(const struct pages_layout *layout, enum plane plane)
{
	return (layout->posts * plane_bytes(plane) + ALIGN - 1) / ALIGN * ALIGN;
}

struct pages_layout resident_pages_layout_of(uint32_t cells, unsigned planes, bool classes, bool numbers)
{
	struct pages_layout layout = {.cells = cells, .posts = (size_t)(cells + 1) * (cells + 1)};
	for (int plane = 0; plane < PLANES; plane++) {
		layout.places[plane] = layout.changed;
		if (planes & PLANE_BIT(plane))
			layout.changed += resident_pages_plane_room(&layout, plane);
	}
	layout.base = sizeof(struct pages_head);
	layout.planes = layout.base + layout.posts * sizeof(int32_t);
	layout.numbers = layout.planes + layout.changed;
	layout.classes = layout.numbers + (numbers ? PAGES_NUMBER_BYTES * layout.posts : 0);
	layout.loaded = layout.classes + (classes ? layout.posts : 0);
	return layout;
}

/* Returns the number of changed pages that start a commit. More pages cost less each, but need memory. Pages that change step after step
 * must not start one: each step would wait for the one before. */
static uint32_t commit_pages_most(const struct pages_params *params, const struct pages_layout *layout)
{
	enum { LEAST = 4, MOST = 64 };
	size_t fit = layout->changed > 0 ? COMMIT_BYTES / layout->changed : MOST;
	uint32_t pages = fit < LEAST ? LEAST : fit > MOST ? MOST : (uint32_t)fit;
	pages = pages > 2 * params->work_pages ? pages : 2 * params->work_pages;
	return pages < params->count ? pages : params->count;
}

/* Returns how many images of changed pages are made without a wait. There is always one for each page that objects change in a step,
 * and half as many more. */
static uint32_t images_of(const struct pages_params *params, uint32_t soft)
{
	enum { LEAST = 16 };
	const uint32_t least = params->work_pages + params->work_pages / 2 + LEAST, enough = PAGE_QUEUE_MOST(soft, 0);
	const uint32_t images = params->images > 0 && params->images < enough ? params->images : enough;
	return images > least ? images : least;
}

/* Commits that are begun for all ranks come some steps later, and pages come from other ranks besides. */
#define RANKS_MORE 4

/* Returns how many images may be made at all: `enough` are never all needed. Only so many are allowed as there is memory for, but always a step's
 * own besides those that are being committed. */
static uint64_t most_images(const struct pages_params *params, const struct pages_layout *layout, uint32_t few, uint64_t enough)
{
	const uint64_t fit = params->queue_bytes > 0 && layout->changed > 0 ? params->queue_bytes / layout->changed : UINT64_MAX, least = 2 * (uint64_t)few;
	const uint64_t most = fit > least ? fit : least;
	return enough > most ? most : enough > few ? enough : few;
}

static struct page_params cache_params(const struct pages_params *params, const struct pages_layout *layout)
{
	uint32_t soft = commit_pages_most(params, layout);
	const uint32_t few = images_of(params, soft);
	const uint64_t most = most_images(params, layout, few, PAGE_QUEUE_MOST(soft, params->step_pages) * (params->commits_begun ? RANKS_MORE : 1));
	soft = soft < few - few / 4 ? soft : few - few / 4; /* the rest is for the step that starts the commit */
	return (struct page_params){
		.slots = params->count,
		.loaders = params->loaders,
		.queue_soft = soft,
		.queue_most = (uint32_t)most,
		.queue_few = few,
		.commit_age = params->commit_age,
		.commits_begun = params->commits_begun,
		.begin_commit = params->begin_commit,
		.begin_commit_user = params->user,
		.record_bytes = params->record.bytes,
		.trace = params->trace,
	};
}

/* Without loaders the GPU's thread reads. */
static uint32_t reader_count(const struct pages_params *params)
{
	return params->loaders > 0 ? params->loaders : 1;
}

enum status resident_pages_create(const struct pages_params *params, struct pages **out)
{
	struct pages *pages = mem_calloc(1, sizeof *pages);
	TRY_MEM(pages, "the page cache");
	assert(params->loaders <= sizeof pages->grounds / sizeof *pages->grounds);
	assert(params->host == NULL || (params->planes & ~resident_host_planes(params->host)) == 0);
	pages->params = *params;
	pages->io.sums = params->before;
	mutex_init(&pages->mutex);
	pages->home = params->host != NULL ? &resident_pages_host : &resident_pages_gpu;
	pages->planes = params->planes;
	pages->layout = resident_pages_layout_of(store_meta(params->store)->extent.cells, pages->planes, params->classes != NULL,
						 params->numbers != NULL);
	enum status status = STATUS_OK;
	for (uint32_t i = 0; i < reader_count(params) && status == STATUS_OK; i++)
		status = resident_ground_create(params->store, GROUND_TILES, &pages->grounds[i]);
	struct page_params cache = cache_params(params, &pages->layout);
	cache.io = resident_pages_io_of(pages);
	cache.executor = resident_pages_executor_of(pages);
	if (status == STATUS_OK)
		status = page_cache_create(&cache, &pages->cache);
	if (status != STATUS_OK) {
		resident_pages_destroy(pages);
		return status;
	}
	*out = pages;
	return STATUS_OK;
}

void resident_pages_destroy(struct pages *pages)
{
	if (pages == NULL)
		return;
	page_cache_destroy(pages->cache);
	for (uint32_t i = 0; i < reader_count(&pages->params); i++)
		resident_ground_destroy(pages->grounds[i]);
	store_reader_destroy(pages->marked.reader);
	store_reader_destroy(pages->moved.reader);
	mem_free_all(pages->moved.bytes, pages->commit_pages);
	mutex_finish(&pages->mutex);
	mem_free(pages);
}

void resident_pages_stop(struct pages *pages)
{
	page_cache_stop(pages->cache);
}

struct page_cache *resident_pages_cache(struct pages *pages)
{
	return pages->cache;
}

void resident_pages_volume(struct pages *pages, const struct resident_volume *volume)
{
	mutex_lock(&pages->mutex);
	pages->volume = *volume;
	mutex_unlock(&pages->mutex);
}

void resident_pages_io(struct pages *pages, struct resident_pages_io *io)
{
	mutex_lock(&pages->mutex);
	*io = pages->io;
	mutex_unlock(&pages->mutex);
	io->readback_ms = pages->readback_ms;
	io->host_bytes = pages->host_bytes;
	if (pages->params.host != NULL) {
		struct resident_host_figures host;
		resident_host_figures(pages->params.host, &host);
		io->host_bytes += host.bytes;
	}
	io->changed_images = pages->changed_images;
	for (uint32_t i = 0; i < reader_count(&pages->params); i++) {
		struct resident_ground_figures figures;
		resident_ground_figures(pages->grounds[i], &figures);
		io->counts.bases += (int64_t)figures.reads;
		io->counts.ranges += (int64_t)figures.ranges;
	}
}

void resident_pages_budget(const struct pages_params *params, uint32_t cells, struct resident_pages_budget *budget)
{
	const struct pages_layout layout = resident_pages_layout_of(cells, params->planes, params->classes != NULL, params->numbers != NULL);
	struct page_params cache = cache_params(params, &layout);
	uint64_t plane = layout.posts * sizeof(int32_t);
	*budget = (struct resident_pages_budget){
		.slots = params->count * (plane + layout.loaded - layout.planes),
		.loads = page_load_images(params->loaders) * (uint64_t)layout.loaded + (params->snapshot != NULL || params->tally != NULL ? PAGES_TALLY_BYTES : 0),
		.queue = cache.queue_most * (uint64_t)layout.changed,
		.queue_few = cache.queue_few * (uint64_t)layout.changed,
		.images_few = cache.queue_few,
		.ground = reader_count(params) * (GROUND_TILES + 1) * plane,
	};
}
