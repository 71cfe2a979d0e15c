/*
 * Goes back to an earlier state of the store. Everything newer is dropped, and read again when it is asked for. The order is:
 *
 * - no commit is in flight; the one that is need not be made,
 * - running loads are given up,
 * - the store goes back,
 * - waiting images, and pages that are dirty or have changed, are dropped.
 *
 * If a step of this fails, only loads were dropped, and they are asked for again. While the store goes back no page is wanted,
 * so no loader reads it. A load that began earlier is stale, and is dropped when it ends.
 */
#include "page/page_internal.h"

#include <assert.h>

static void give_up_loads_locked(struct page_cache *cache)
{
	struct page_table *table = &cache->table;
	struct page *next;
	assert(table->urgent.count == 0);
	while (table->requested.first != NULL) {
		page_loads_abandon_locked(cache, table->requested.first);
		cache->stats.cancelled++;
	}
	for (struct page *page = table->flights.first; page != NULL; page = next) {
		next = page->next;
		if (page->stale)
			continue;
		page_loads_abandon_locked(cache, page);
		cache->stats.cancelled++;
	}
	assert(cache->queue.kept.count == 0); /* 6 */
}

void page_drop_locked(struct page_cache *cache, struct page *page)
{
	struct page_table *table = &cache->table;
	assert(page->pins == 0);
	table->dirty -= page->dirty;
	page->dirty = false;
	table->used -= page->used_in == cache->step;
	cache->requests_kept = cache->requests_kept && !page_requested(cache, page);
	table->free_slots[table->free_count++] = page->slot;
	page_table_forget_locked(table, page, &table->resident);
}

/* Tells whether its newest bits are in its slot, or were read back from there and wait. */
static bool uncommitted(struct page_cache *cache, const struct page *page)
{
	mutex_lock(&cache->mutex);
	bool waits = page_queue_newest_locked(&cache->queue, page->key) != NULL;
	mutex_unlock(&cache->mutex);
	return page->dirty || waits;
}

/* Only the owner uses resident pages (8), so this needs no mutex. */
static void drop_pages(struct page_cache *cache, const struct page_rollback *rollback)
{
	struct page *next;
	for (struct page *page = cache->table.resident.first; page != NULL; page = next) {
		uint64_t key = page->key;
		next = page->next;
		if (!uncommitted(cache, page) && !rollback->changed(rollback->user, key))
			continue;
		mutex_lock(&cache->mutex);
		page_drop_locked(cache, page);
		mutex_unlock(&cache->mutex);
		rollback->dropped(rollback->user, key);
	}
}

bool page_cache_gives_up(struct page_cache *cache)
{
	return cache->giving_up;
}

enum status page_cache_rollback(struct page_cache *cache, const struct page_rollback *rollback)
{
	assert(page_owner(cache));
	mutex_lock(&cache->mutex);
	assert(page_cache_sane_locked(cache));
	cache->giving_up = true;
	const enum status status = page_wait_for_commit_locked(cache, false);
	cache->giving_up = false;
	if (status == STATUS_OK)
		give_up_loads_locked(cache);
	mutex_unlock(&cache->mutex);
	TRY(status);
	TRY(rollback->back(rollback->user));
	drop_pages(cache, rollback);
	mutex_lock(&cache->mutex);
	page_queue_drop_waiting_locked(cache);
	cache->dirty_since = 0;
	assert(page_cache_sane_locked(cache));
	mutex_unlock(&cache->mutex);
	return STATUS_OK;
}
