/*
 * Transfers that the executor has begun and not finished: uploads that still read their image, and read-backs that still fill
 * theirs (10). They finish in order, so only the first one is tested.
 */
#include "page/page_internal.h"

#define NAP 1e-4 /* s between two tests of the executor, which wakes nobody */

void page_busy_add_locked(struct page_cache *cache, struct page_host *host, bool filling)
{
	struct page_busy *busy = &cache->busy;
	host->refs++;
	host->filling = filling;
	cache->queue.filling += filling;
	host->busy_next = NULL;
	*(busy->last != NULL ? &busy->last->busy_next : &busy->first) = host;
	busy->last = host;
}

static void settle_first_locked(struct page_cache *cache)
{
	struct page_busy *busy = &cache->busy;
	struct page_queue *queue = &cache->queue;
	struct page_host *host = busy->first;
	busy->first = host->busy_next;
	if (busy->first == NULL)
		busy->last = NULL;
	if (host->filling) {
		host->filling = false;
		queue->filling--;
		queue->commit_filling -= host->place == PAGE_COMMITTING;
	}
	if (cache->commit == PAGE_COMMIT_FILLING && queue->commit_filling == 0)
		cache->commit = PAGE_COMMIT_WRITING;
	page_host_release_locked(cache, host);
	condition_wake_all(&cache->work);
}

enum status page_executor_failed(struct page_cache *cache, enum status status)
{
	mutex_lock(&cache->mutex);
	failure_capture(&cache->failure, status);
	mutex_unlock(&cache->mutex);
	return status;
}

enum status page_settle(struct page_cache *cache)
{
	const struct page_executor *executor = &cache->params.executor;
	while (cache->busy.first != NULL) {
		bool settled = false;
		const enum status status = executor->settled(executor->user, &cache->busy.first->image, &settled);
		if (status != STATUS_OK)
			return page_executor_failed(cache, status);
		if (!settled)
			return STATUS_OK;
		mutex_lock(&cache->mutex);
		settle_first_locked(cache);
		mutex_unlock(&cache->mutex);
	}
	return STATUS_OK;
}

enum status page_wait_locked(struct page_cache *cache)
{
	const struct page_host *first = cache->busy.first;
	if (first == NULL) {
		condition_wait(&cache->done, &cache->mutex);
		return page_sticky_locked(cache);
	}
	mutex_unlock(&cache->mutex);
	const enum status settled = page_settle(cache);
	mutex_lock(&cache->mutex);
	TRY(settled);
	/* A thread may have signalled meanwhile: never sleep long. */
	if (cache->busy.first == first)
		condition_wait_for(&cache->done, &cache->mutex, NAP);
	return page_sticky_locked(cache);
}

enum status page_stall_locked(struct page_cache *cache, bool *stalled)
{
	cache->stats.stalls += !*stalled;
	*stalled = true;
	double began = clock_seconds();
	enum status status = page_wait_locked(cache);
	cache->stats.stall_ms += (clock_seconds() - began) * 1e3;
	return status;
}
