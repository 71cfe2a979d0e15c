/*
 * The owner's work list: uploads, and the read-backs that make room for them.
 *
 *     LOADED -> take a slot (free, or of the least recently used page that may go) -> upload
 *
 * A dirty page goes to the queue before its slot is given away. It counts as clean only when its read-back has begun. The
 * executor keeps the order, so an upload over it comes later. If anything fails on the way, its newest bits are still in its
 * slot or already wait. The executor is called without the mutex (8).
 */
#include "page/page_internal.h"

#include <assert.h>

/* Waits for the commit in flight, if there is one, and gives up loads ahead that keep images of committed pages. */
static enum status wait_for_images(struct page_cache *cache)
{
	mutex_lock(&cache->mutex);
	const enum status status = page_wait_for_commit_locked(cache, true);
	page_loads_abandon_late_locked(cache);
	mutex_unlock(&cache->mutex);
	TRY(status);
	return page_settle(cache);
}

/* Tells whether so few images are left that loads on their way need them all, each to replace a page. */
static bool are_few_locked(const struct page_cache *cache)
{
	const uint32_t few = cache->params.queue_few, made = cache->queue.made[PAGE_CHANGED_IMAGE];
	const uint32_t left = (few > made ? few - made : 0) + cache->queue.unused_count[PAGE_CHANGED_IMAGE];
	return few > 0 && left <= 1 + few / 32 + cache->table.urgent.count + cache->table.flights.count;
}

/* Takes an image for a changed page; NULL without failure only if `ahead`. Every page of a step has one, if the step changes no
 * more pages than promised. Fewer than twice queue_soft images wait before the step. The same bound holds for images that are
 * being committed, or kept after that. Those may be kept for the very loads that need slots now. So the wait for them comes
 * while there are images for these loads. */
static enum status take_image(struct page_cache *cache, uint64_t key, bool ahead,
			      struct page_host **out)
{
	const struct page_queue *queue = &cache->queue;
	*out = NULL;
	TRY(page_settle(cache));
	mutex_lock(&cache->mutex);
	const bool few = are_few_locked(cache), wait = few && (cache->commit != PAGE_COMMIT_NONE || queue->kept.count > 0);
	mutex_unlock(&cache->mutex);
	if (few && ahead)
		return STATUS_OK;
	if (wait)
		TRY(wait_for_images(cache));
	mutex_lock(&cache->mutex);
	*out = page_host_acquire_locked(cache, PAGE_CHANGED_IMAGE, key);
	const bool make = *out == NULL && queue->made[PAGE_CHANGED_IMAGE] < cache->params.queue_most;
	uint32_t waiting = queue->waiting.count;
	mutex_unlock(&cache->mutex);
	if (*out != NULL)
		return STATUS_OK;
	if (!make)
		return ahead ? STATUS_OK
			     : fail_with(STATUS_FAILED, "page cache: the queue is full, %u changed pages "
					 "wait for the step's end; raise cache.slots", waiting);
	TRY(page_host_make(cache, PAGE_CHANGED_IMAGE));
	mutex_lock(&cache->mutex);
	*out = page_host_acquire_locked(cache, PAGE_CHANGED_IMAGE, key);
	mutex_unlock(&cache->mutex);
	return STATUS_OK;
}

enum status page_take_changed_image(struct page_cache *cache, uint64_t key, struct page_host **out)
{
	return take_image(cache, key, false, out);
}

enum status page_read_back(struct page_cache *cache, struct page *page, bool ahead)
{
	assert(page->state == PAGE_RESIDENT && page->dirty); /* 3 */
	const struct page_executor *executor = &cache->params.executor;
	struct page_host *host;
	TRY(take_image(cache, page->key, ahead, &host));
	if (host == NULL)
		return STATUS_OK;
	const enum status status = executor->read_back(executor->user, page->slot, &host->image);
	mutex_lock(&cache->mutex);
	if (status == STATUS_OK) {
		page_busy_add_locked(cache, host, true);
		page_queue_wait_locked(cache, host);
		page->dirty = false;
		cache->table.dirty--;
	} else {
		failure_capture(&cache->failure, status);
		page_host_release_locked(cache, host);
	}
	mutex_unlock(&cache->mutex);
	return status;
}

/* Finds the least recently used page that may go. It has no prefetch request, or else its need is farthest off. A page that is
 * loaded ahead replaces no requested page, and no page that this step used. */
static struct page *find_victim(const struct page_cache *cache, bool ahead)
{
	struct page *farthest = NULL;
	for (struct page *page = cache->table.resident.first; page != NULL; page = page->next) {
		bool requested = page_requested(cache, page);
		if (page->pins > 0 || (ahead && (requested || page->used_in == cache->step)))
			continue;
		if (!requested)
			return page;
		if (farthest == NULL || page->requested_at > farthest->requested_at)
			farthest = page;
	}
	return farthest;
}

/* Takes a slot for a page; PAGE_NO_SLOT without failure only if `ahead`. */
static enum status take_slot(struct page_cache *cache, bool ahead, uint32_t *slot)
{
	struct page_table *table = &cache->table;
	mutex_lock(&cache->mutex);
	*slot = table->free_count > 0 ? table->free_slots[--table->free_count] : PAGE_NO_SLOT;
	mutex_unlock(&cache->mutex);
	if (*slot != PAGE_NO_SLOT)
		return STATUS_OK;
	struct page *page = find_victim(cache, ahead);
	assert(page != NULL || ahead); /* page_cache_pin_all counted the slots */
	if (page == NULL)
		return STATUS_OK;
	if (page->dirty) {
		TRY(page_read_back(cache, page, ahead));
		if (page->dirty)
			return STATUS_OK;
	}
	mutex_lock(&cache->mutex);
	*slot = page->slot;
	table->used -= page->used_in == cache->step;
	cache->requests_kept = cache->requests_kept && !page_requested(cache, page);
	page_table_forget_locked(table, page, &table->resident);
	cache->stats.evictions++;
	mutex_unlock(&cache->mutex);
	return STATUS_OK;
}

/* Tells whether the image may be uploaded. An image with `overlays` needs all read-backs to be settled (10). */
static enum status wait_for_fills(struct page_cache *cache, const struct page_host *host, bool ahead,
				  bool *ready)
{
	enum status status = STATUS_OK;
	bool stalled = false;
	mutex_lock(&cache->mutex);
	while (host->image.overlays && cache->queue.filling > 0 && !ahead)
		TRY_OR(done, page_stall_locked(cache, &stalled));
done:
	*ready = !host->image.overlays || cache->queue.filling == 0;
	mutex_unlock(&cache->mutex);
	return status;
}

/* Takes a slot and uploads the page's image into it. *slot: PAGE_NO_SLOT if there is none yet. *begun: whether the executor was
 * asked to upload. */
static enum status upload(struct page_cache *cache, struct page_host *host, bool ahead, uint32_t *slot, bool *begun)
{
	const struct page_executor *executor = &cache->params.executor;
	bool ready;
	TRY(take_slot(cache, ahead, slot));
	if (*slot == PAGE_NO_SLOT) /* the page that it replaces is being read back */
		return STATUS_OK;
	TRY(wait_for_fills(cache, host, ahead, &ready));
	if (!ready)
		return STATUS_OK;
	*begun = true;
	return executor->upload(executor->user, *slot, &host->image);
}

enum status page_install(struct page_cache *cache, struct page *page, bool *later)
{
	assert(page->state == PAGE_LOADED);
	struct page_host *host = page->host;
	const bool unloaded = host->failure.status != STATUS_OK;
	uint32_t slot = PAGE_NO_SLOT;
	bool begun = false;
	mutex_lock(&cache->mutex);
	const bool ahead = !page->urgent;
	mutex_unlock(&cache->mutex);
	const enum status status = unloaded ? failure_restore(&host->failure) : upload(cache, host, ahead, &slot, &begun);
	const bool uploaded = begun && status == STATUS_OK;
	*later = !begun && status == STATUS_OK;
	mutex_lock(&cache->mutex);
	if (slot != PAGE_NO_SLOT && !uploaded)
		cache->table.free_slots[cache->table.free_count++] = slot;
	if (!*later) {
		if (begun) /* also after a failure, since the executor may still read the image */
			page_busy_add_locked(cache, host, false);
		cache->requests_kept = cache->requests_kept && uploaded;
		page_loads_land_locked(cache, page, uploaded ? slot : PAGE_NO_SLOT);
	}
	mutex_unlock(&cache->mutex);
	if (unloaded && ahead)
		return STATUS_OK;
	TRY(status);
	return page_settle(cache);
}
