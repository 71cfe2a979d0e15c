/*
 * Images, and the host queue: versions of pages that are not in the store yet, or have only just been committed.
 *
 *     unused -> waiting (a read-back fills it) -> committing -> kept -> unused
 *
 * Every version is found by key, so that a load gets the newest one instead of the store's. A newer waiting version replaces an
 * older waiting one. A version that is being committed stays as it is (invariant 4). An image with a reader leaves its list,
 * but keeps its memory.
 *
 * Images for loads are made with the cache (9). Images for changed pages are made when first needed, at most queue_most. All
 * are freed with the cache. An image of a load returns to the pool when its upload is settled. An image of a changed page
 * returns when it is committed and no load can have missed it.
 */
#include "page/page_internal.h"

#include <assert.h>

enum status page_queue_init(struct page_queue *queue, const struct page_params *params)
{
	size_t buckets = 64;
	while (buckets < params->queue_most)
		buckets *= 2;
	TRY(mem_zeroed(&queue->buckets, buckets, sizeof *queue->buckets, "the page queue"));
	queue->mask = buckets - 1;
	return STATUS_OK;
}

static void list_free(struct page_cache *cache, struct page_host *host)
{
	const struct page_executor *executor = &cache->params.executor;
	while (host != NULL) {
		struct page_host *next = host->next;
		executor->destroy(executor->user, &host->image);
		mem_free(host);
		host = next;
	}
}

void page_queue_finish(struct page_cache *cache)
{
	struct page_queue *queue = &cache->queue;
	list_free(cache, queue->waiting.first);
	list_free(cache, queue->committing.first);
	list_free(cache, queue->kept.first);
	for (int kind = 0; kind < PAGE_IMAGE_KINDS; kind++)
		list_free(cache, queue->unused[kind]);
	mem_free(queue->buckets);
}

/* --- images --- */

static void give_back_locked(struct page_queue *queue, struct page_host *host)
{
	host->next = queue->unused[host->kind];
	queue->unused[host->kind] = host;
	queue->unused_count[host->kind]++;
}

enum status page_host_make(struct page_cache *cache, enum page_image_kind kind)
{
	const struct page_executor *executor = &cache->params.executor;
	struct page_host *host = mem_calloc(1, sizeof *host);
	TRY_MEM(host, "an image of a page");
	host->kind = kind;
	enum status status = executor->create(executor->user, kind, &host->image);
	if (status != STATUS_OK) {
		mem_free(host);
		return status;
	}
	mutex_lock(&cache->mutex);
	cache->queue.made[kind]++;
	if (kind == PAGE_CHANGED_IMAGE)
		cache->stats.queue_peak = cache->queue.made[kind];
	give_back_locked(&cache->queue, host);
	mutex_unlock(&cache->mutex);
	return STATUS_OK;
}

struct page_host *page_host_acquire_locked(struct page_cache *cache, enum page_image_kind kind,
					   uint64_t key)
{
	struct page_host *host = cache->queue.unused[kind];
	if (host == NULL)
		return NULL;
	cache->queue.unused[kind] = host->next;
	cache->queue.unused_count[kind]--;
	struct page_image image = {.key = key, .bytes = host->image.bytes, .memory = host->image.memory};
	*host = (struct page_host){.image = image, .kind = kind, .refs = 1};
	return host;
}

void page_host_release_locked(struct page_cache *cache, struct page_host *host)
{
	assert(host->refs > 0);
	if (--host->refs > 0)
		return;
	assert(host->place == PAGE_UNQUEUED && !host->filling);
	if (cache->params.executor.drop != NULL)
		cache->params.executor.drop(cache->params.executor.user, &host->image);
	give_back_locked(&cache->queue, host);
	condition_wake_all(&cache->work);
}

/* --- places --- */

static struct page_host_list *list_of(struct page_queue *queue, enum page_image_place place)
{
	assert(place != PAGE_UNQUEUED);
	return place == PAGE_WAITING      ? &queue->waiting
	       : place == PAGE_COMMITTING ? &queue->committing
					  : &queue->kept;
}

/* After `before`, or first if that is NULL. */
static void enter_locked(struct page_queue *queue, struct page_host *host,
			 enum page_image_place place, struct page_host *before)
{
	struct page_host_list *list = list_of(queue, place);
	host->place = place;
	host->prev = before;
	host->next = before != NULL ? before->next : list->first;
	*(before != NULL ? &before->next : &list->first) = host;
	*(host->next != NULL ? &host->next->prev : &list->last) = host;
	list->count++;
	struct page_host **bucket = &queue->buckets[key_hash(host->image.key) & queue->mask];
	host->hash_next = *bucket;
	*bucket = host;
}

static void leave_locked(struct page_queue *queue, struct page_host *host)
{
	struct page_host_list *list = list_of(queue, host->place);
	*(host->prev != NULL ? &host->prev->next : &list->first) = host->next;
	*(host->next != NULL ? &host->next->prev : &list->last) = host->prev;
	list->count--;
	struct page_host **at = &queue->buckets[key_hash(host->image.key) & queue->mask];
	while (*at != host)
		at = &(*at)->hash_next;
	*at = host->hash_next;
	host->place = PAGE_UNQUEUED;
}

struct page_host *page_queue_find_locked(const struct page_queue *queue, uint64_t key,
					 enum page_image_place place)
{
	struct page_host *host = queue->buckets[key_hash(key) & queue->mask];
	while (host != NULL && (host->image.key != key || host->place != place))
		host = host->hash_next;
	return host;
}

struct page_host *page_queue_newest_locked(const struct page_queue *queue, uint64_t key)
{
	struct page_host *newest = NULL;
	for (struct page_host *host = queue->buckets[key_hash(key) & queue->mask]; host != NULL;
	     host = host->hash_next)
		if (host->image.key == key && (newest == NULL || host->place > newest->place))
			newest = host;
	return newest;
}

static void drop_version_locked(struct page_cache *cache, uint64_t key, enum page_image_place place)
{
	struct page_host *host = page_queue_find_locked(&cache->queue, key, place);
	if (host == NULL)
		return;
	leave_locked(&cache->queue, host);
	page_host_release_locked(cache, host);
}

void page_queue_wait_locked(struct page_cache *cache, struct page_host *host)
{
	struct page_queue *queue = &cache->queue;
	drop_version_locked(cache, host->image.key, PAGE_WAITING);
	enter_locked(queue, host, PAGE_WAITING, queue->waiting.last);
}

/* --- commits --- */

void page_queue_begin_commit_locked(struct page_cache *cache)
{
	struct page_queue *queue = &cache->queue;
	assert(queue->committing.count == 0); /* 5 */
	while (queue->waiting.first != NULL) {
		struct page_host *host = queue->waiting.first;
		leave_locked(queue, host);
		enter_locked(queue, host, PAGE_COMMITTING, queue->committing.last);
		queue->commit_filling += host->filling;
	}
	if (cache->commit_snapshot != NULL) {
		cache->commit_snapshot->place = PAGE_COMMITTING;
		queue->commit_filling += cache->commit_snapshot->filling;
	}
	cache->commit = queue->commit_filling > 0 ? PAGE_COMMIT_FILLING : PAGE_COMMIT_WRITING;
}

static void put_back_locked(struct page_cache *cache, struct page_host *host)
{
	if (page_queue_find_locked(&cache->queue, host->image.key, PAGE_WAITING) != NULL)
		page_host_release_locked(cache, host);
	else
		enter_locked(&cache->queue, host, PAGE_WAITING, NULL);
}

void page_queue_end_commit_locked(struct page_cache *cache, bool committed)
{
	struct page_queue *queue = &cache->queue;
	while (queue->committing.first != NULL) {
		struct page_host *host =
			committed ? queue->committing.first : queue->committing.last;
		leave_locked(queue, host);
		if (committed) {
			drop_version_locked(cache, host->image.key, PAGE_KEPT);
			host->kept_until = cache->load_clock;
			enter_locked(queue, host, PAGE_KEPT, queue->kept.last);
		} else {
			put_back_locked(cache, host);
		}
	}
	if (cache->commit_snapshot != NULL)
		cache->commit_snapshot->place = PAGE_UNQUEUED;
	page_queue_release_kept_locked(cache);
}

void page_queue_drop_waiting_locked(struct page_cache *cache)
{
	struct page_queue *queue = &cache->queue;
	while (queue->waiting.first != NULL) {
		struct page_host *host = queue->waiting.first;
		leave_locked(queue, host);
		page_host_release_locked(cache, host); /* one that is filled keeps its memory until that is settled */
	}
}

void page_queue_drop_waiting_one_locked(struct page_cache *cache, uint64_t key)
{
	drop_version_locked(cache, key, PAGE_WAITING);
}

void page_queue_release_kept_locked(struct page_cache *cache)
{
	struct page_queue *queue = &cache->queue;
	uint64_t oldest = page_loads_oldest_locked(cache);
	while (queue->kept.first != NULL && queue->kept.first->kept_until < oldest) {
		struct page_host *host = queue->kept.first;
		leave_locked(queue, host);
		page_host_release_locked(cache, host);
	}
}

/* --- looking at it --- */

void page_cache_each_queued(struct page_cache *cache, page_image_fn fn, void *user)
{
	assert(page_owner(cache));
	struct page_queue *queue = &cache->queue;
	struct page_host_list *lists[] = {&queue->kept, &queue->committing, &queue->waiting};
	struct page_host *first = NULL, **end = &first, *next;
	mutex_lock(&cache->mutex);
	for (int i = 0; i < 3; i++)
		for (struct page_host *host = lists[i]->first; host != NULL; host = host->next) {
			if (host->filling)
				continue;
			host->refs++;
			*end = host;
			end = &host->visit_next;
		}
	*end = NULL;
	mutex_unlock(&cache->mutex);
	for (struct page_host *host = first; host != NULL; host = host->visit_next)
		fn(user, &host->image);
	mutex_lock(&cache->mutex);
	for (struct page_host *host = first; host != NULL; host = next) {
		next = host->visit_next;
		page_host_release_locked(cache, host);
	}
	mutex_unlock(&cache->mutex);
}
