/*
 * Pins make pages resident now. A peek tells whether they are.
 *
 * A pin counts the slots first. The wanted pages and the pages already pinned must fit, so that an eviction always finds a
 * page. Then it asks for all pages, and pins each one as soon as it is resident. So none is evicted for another one of the same
 * call. If anything fails, all of it is undone.
 */
#include "page/page_internal.h"

#include <assert.h>

struct request {
	const uint64_t *keys;
	uint32_t *slots;
	size_t count;
	bool held[PAGE_PIN_MOST], hit[PAGE_PIN_MOST];
	size_t asked;
	bool stalled;
};

static bool repeated(const struct request *request, size_t i)
{
	for (size_t j = 0; j < i; j++)
		if (request->keys[j] == request->keys[i])
			return true;
	return false;
}

static enum status check_room_locked(const struct page_cache *cache, const struct request *request)
{
	uint32_t needed = cache->table.pinned, slots = cache->params.slots;
	for (size_t i = 0; i < request->count; i++) {
		const struct page *page = page_table_find_locked(&cache->table, request->keys[i]);
		needed += !repeated(request, i) && (page == NULL || page->pins == 0);
	}
	if (needed <= slots)
		return STATUS_OK;
	return fail_with(STATUS_FAILED,
			 "page cache: %u pages must be resident at once and there are %u slots; "
			 "raise cache.slots to at least %u",
			 needed, slots, needed);
}

static void hold_locked(struct page_cache *cache, struct request *request, size_t i,
			struct page *page)
{
	struct page_table *table = &cache->table;
	table->pinned += page->pins++ == 0;
	page_use_locked(cache, page);
	key_set_put(&cache->touched, page->key);
	request->slots[i] = page->slot;
	request->held[i] = true;
}

/* Counts the access. After it the page is resident and pinned, or being loaded. */
static void ask_locked(struct page_cache *cache, struct request *request, size_t i)
{
	struct page *page = page_table_find_locked(&cache->table, request->keys[i]);
	request->asked++;
	if (page != NULL && page->state == PAGE_RESIDENT) {
		request->hit[i] = true;
		cache->stats.hits++;
		hold_locked(cache, request, i, page);
		return;
	}
	cache->stats.misses++;
	cache->stats.not_begun += page != NULL && page->state == PAGE_WANTED;
	cache->stats.late += page != NULL && page->state != PAGE_WANTED;
	/* A prefetch that failed is retried; a stale load is asked for again once it is gone. */
	if (page != NULL && page->state == PAGE_LOADED && !page->urgent &&
	    page->host->failure.status != STATUS_OK) {
		page_loads_abandon_locked(cache, page);
		page = NULL;
	}
	if (page == NULL)
		page_loads_want_locked(cache, request->keys[i], true);
	else if (!page->stale)
		page_loads_make_urgent_locked(cache, page);
}

/* Waits until a wanted page is LOADED; *loaded NULL when all are held. */
static enum status next_loaded_locked(struct page_cache *cache, struct request *request,
				      struct page **loaded)
{
	for (;;) {
		bool waiting = false;
		for (size_t i = 0; i < request->count; i++) {
			if (request->held[i])
				continue;
			struct page *page = page_table_find_locked(&cache->table, request->keys[i]);
			*loaded = page;
			if (page != NULL && page->state == PAGE_LOADED)
				return STATUS_OK;
			if (page == NULL)
				page_loads_want_locked(cache, request->keys[i], true);
			if (page != NULL && page->state == PAGE_RESIDENT)
				hold_locked(cache, request, i, page);
			else
				waiting = true;
		}
		*loaded = NULL;
		if (!waiting)
			return STATUS_OK;
		double began = clock_seconds();
		if (cache->params.loaders == 0 && page_load_next_locked(cache, 0)) {
			cache->stats.stalls += !request->stalled;
			cache->stats.stall_ms += (clock_seconds() - began) * 1e3;
			request->stalled = true;
			continue;
		}
		TRY(page_stall_locked(cache, &request->stalled));
	}
}

/* Releases the mutex while the page is installed. */
static enum status install_locked(struct page_cache *cache, struct page *page)
{
	bool later;
	mutex_unlock(&cache->mutex);
	const enum status status = page_install(cache, page, &later);
	mutex_lock(&cache->mutex);
	return status;
}

/* Returns when all pages of the request are held. */
static enum status hold_all_locked(struct page_cache *cache, struct request *request)
{
	for (;;) {
		struct page *page;
		TRY(next_loaded_locked(cache, request, &page));
		if (page == NULL)
			return STATUS_OK;
		page_loads_make_urgent_locked(cache, page);
		TRY(install_locked(cache, page));
	}
}

static void undo_locked(struct page_cache *cache, const struct request *request)
{
	for (size_t i = 0; i < request->count; i++) {
		struct page *page = page_table_find_locked(&cache->table, request->keys[i]);
		if (request->held[i])
			cache->table.pinned -= --page->pins == 0;
		else if (page != NULL && page->state != PAGE_RESIDENT)
			page_loads_abandon_locked(cache, page);
	}
}

enum status page_cache_pin_all(struct page_cache *cache, const uint64_t *keys, size_t count,
			       uint32_t *slots)
{
	assert(page_owner(cache) && count <= PAGE_PIN_MOST);
	struct request request = {.keys = keys, .slots = slots, .count = count};
	mutex_lock(&cache->mutex);
	assert(page_cache_sane_locked(cache));
	enum status status;
	TRY_OR(unlock, page_sticky_locked(cache));
	TRY_OR(unlock, check_room_locked(cache, &request));
	TRY_OR(unlock, key_set_reserve(&cache->touched, count));
	for (size_t i = 0; i < count; i++)
		ask_locked(cache, &request, i);
	status = hold_all_locked(cache, &request);
	if (status != STATUS_OK)
		undo_locked(cache, &request);
	assert(page_cache_sane_locked(cache));
unlock:
	mutex_unlock(&cache->mutex);
	for (size_t i = 0; i < request.asked; i++)
		page_trace_access(cache->params.trace, cache->step - 1, keys[i], PAGE_ACCESS_PIN, request.hit[i]);
	return status;
}

enum status page_cache_pin(struct page_cache *cache, uint64_t key, uint32_t *slot)
{
	return page_cache_pin_all(cache, &key, 1, slot);
}

void page_cache_unpin(struct page_cache *cache, uint64_t key)
{
	assert(page_owner(cache));
	mutex_lock(&cache->mutex);
	struct page *page = page_table_find_locked(&cache->table, key);
	assert(page != NULL && page->pins > 0);
	cache->table.pinned -= --page->pins == 0;
	mutex_unlock(&cache->mutex);
}

void page_cache_dirty(struct page_cache *cache, uint64_t key)
{
	assert(page_owner(cache));
	mutex_lock(&cache->mutex);
	struct page *page = page_table_find_locked(&cache->table, key);
	assert(page != NULL && page->pins > 0);
	cache->table.dirty += !page->dirty;
	page->dirty = true;
	if (cache->dirty_since == 0)
		cache->dirty_since = clock_seconds();
	mutex_unlock(&cache->mutex);
}

/* --- without waiting --- */

bool page_cache_peek(struct page_cache *cache, uint64_t key, bool use, uint32_t *slot)
{
	assert(page_owner(cache));
	mutex_lock(&cache->mutex);
	struct page *page = page_table_find_locked(&cache->table, key);
	bool resident = page != NULL && page->state == PAGE_RESIDENT;
	if (resident) {
		*slot = page->slot;
		if (use)
			page_use_locked(cache, page);
	}
	mutex_unlock(&cache->mutex);
	if (use)
		page_trace_access(cache->params.trace, cache->step - 1, key, PAGE_ACCESS_DRAW, resident);
	return resident;
}

/* Returns a LOADED page that this poll has not tried yet. */
static struct page *first_loaded_locked(const struct page_cache *cache)
{
	struct page *page = cache->table.flights.first;
	while (page != NULL && (page->state != PAGE_LOADED || page->polled == cache->polls))
		page = page->next;
	return page;
}

enum status page_cache_poll(struct page_cache *cache)
{
	assert(page_owner(cache));
	enum status status = page_settle(cache);
	mutex_lock(&cache->mutex);
	assert(page_cache_sane_locked(cache));
	cache->polls++;
	TRY_OR(unlock, status);
	TRY_OR(unlock, page_sticky_locked(cache));
	for (struct page *page; (page = first_loaded_locked(cache)) != NULL;) {
		page->polled = cache->polls;
		TRY_OR(unlock, install_locked(cache, page));
	}
unlock:
	mutex_unlock(&cache->mutex);
	return status;
}
