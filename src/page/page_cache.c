/*
 * The page cache: which tiles are resident, and what was changed until it is committed.
 *
 *     ABSENT -> LOADING -> LOADED -> (upload) -> RESIDENT -> ABSENT
 *                                                  | dirty: read back into an image
 *                                                  v
 *                                  waiting -> committing -> kept -> gone
 *
 * Invariants:
 *  1. A slot belongs to at most one page; a page has a slot only when RESIDENT.
 *  2. A pinned page is RESIDENT.
 *  3. A dirty page is RESIDENT; its newest bits are in its slot.
 *  4. A key has at most one waiting image and at most one committing image; the waiting one is newer.
 *  5. An epoch takes every waiting image and every dirty page at once, at a step's end.
 *  6. A committed image is kept while a load is on its way that began before the commit returned.
 */
#include "page/page.h"

#include <assert.h>
#include <pthread.h>
#include <string.h>

#define NO_SLOT UINT32_MAX
#define PIN_MOST 64

enum page_state { PAGE_LOADING, PAGE_LOADED, PAGE_RESIDENT };

struct image {
	struct page_image page;
	uint32_t refs;        /* held by a load that reads it */
	uint64_t kept_until;  /* committed: kept for loads begun up to here */
	struct image *next;
};

struct page {
	uint64_t key;
	enum page_state state;
	uint32_t slot, pins;
	bool dirty, urgent, taken, prefetched;
	uint64_t step;         /* last step it was pinned in */
	uint64_t begun;        /* load clock when its load began */
	struct image *image;   /* LOADING, LOADED */
	struct failure failure; /* of its load */
	struct page *hash_next, *request_next, *older, *newer;
};

struct list { /* of images, oldest first */
	struct image *first, *last;
	uint32_t count;
};

struct loader {
	struct page_cache *cache;
	unsigned number;
	struct thread thread;
};

struct page_cache {
	struct page_params params;
	pthread_t owner;
	struct mutex mutex;
	struct condition work, done; /* to the workers; to the owner */
	bool stopping;
	struct page **buckets;
	uint32_t bucket_mask;
	struct page *oldest, *newest; /* RESIDENT, by use */
	uint32_t *free_slots, free_count;
	struct page *requests_first, *requests_last;
	uint32_t loading, prefetching; /* pages LOADING or LOADED; of these prefetched */
	struct image *free_images;
	uint32_t images; /* allocated */
	struct list waiting, committing, kept;
	const struct page_image **handed; /* to io.commit */
	uint32_t handed_room;
	void *record;
	bool commit_busy;
	double dirty_since; /* 0: nothing uncommitted */
	uint64_t load_clock, step;
	struct failure failure; /* sticky */
	uint64_t *touched;
	size_t touched_count, touched_room;
	struct page_stats stats;
	struct loader *loaders;
	struct thread writer;
};

static size_t hash(uint64_t key)
{
	return (size_t)((key * 0x9e3779b97f4a7c15ull) >> 24);
}

static struct page *find_locked(struct page_cache *cache, uint64_t key)
{
	struct page *page = cache->buckets[hash(key) & cache->bucket_mask];
	while (page != NULL && page->key != key)
		page = page->hash_next;
	return page;
}

static void forget_locked(struct page_cache *cache, struct page *page)
{
	struct page **at = &cache->buckets[hash(page->key) & cache->bucket_mask];
	while (*at != page)
		at = &(*at)->hash_next;
	*at = page->hash_next;
	mem_free(page);
}

/* --- images --- */

static void list_append(struct list *list, struct image *image)
{
	image->next = NULL;
	if (list->last != NULL)
		list->last->next = image;
	else
		list->first = image;
	list->last = image;
	list->count++;
}

static struct image *list_take(struct list *list, uint64_t key)
{
	struct image **at = &list->first, *before = NULL;
	while (*at != NULL && (*at)->page.key != key) {
		before = *at;
		at = &(*at)->next;
	}
	struct image *image = *at;
	if (image == NULL)
		return NULL;
	*at = image->next;
	if (list->last == image)
		list->last = before;
	list->count--;
	return image;
}

static struct image *image_get_locked(struct page_cache *cache, uint64_t key)
{
	struct image *image = cache->free_images;
	if (image != NULL) {
		cache->free_images = image->next;
	} else {
		image = mem_calloc(1, sizeof *image);
		if (image != NULL && (image->page.bytes = mem_alloc(cache->params.page_bytes, 1)) == NULL) {
			mem_free(image);
			image = NULL;
		}
		if (image == NULL)
			return NULL;
		cache->images++;
		cache->stats.host_bytes += cache->params.page_bytes;
	}
	void *bytes = image->page.bytes;
	*image = (struct image){.page = {.key = key, .bytes = bytes}};
	return image;
}

static void image_put_locked(struct page_cache *cache, struct image *image)
{
	image->next = cache->free_images;
	cache->free_images = image;
}

static struct image *newest_image_locked(struct page_cache *cache, uint64_t key)
{
	const struct list *lists[] = {&cache->waiting, &cache->committing, &cache->kept};
	for (int i = 0; i < 3; i++) {
		struct image *found = NULL;
		for (struct image *image = lists[i]->first; image != NULL; image = image->next)
			if (image->page.key == key)
				found = image;
		if (found != NULL)
			return found;
	}
	return NULL;
}

/* Releases committed images that no load on its way can have missed. */
static void release_kept_locked(struct page_cache *cache)
{
	uint64_t oldest = UINT64_MAX;
	if (cache->loading > 0)
		for (uint32_t i = 0; i <= cache->bucket_mask; i++)
			for (struct page *page = cache->buckets[i]; page != NULL; page = page->hash_next)
				if (page->state != PAGE_RESIDENT && page->taken && page->begun < oldest)
					oldest = page->begun;
	struct list left = {NULL, NULL, 0};
	struct image *next;
	for (struct image *image = cache->kept.first; image != NULL; image = next) {
		next = image->next;
		if (image->refs == 0 && image->kept_until < oldest)
			image_put_locked(cache, image);
		else
			list_append(&left, image);
	}
	cache->kept = left;
}

/* --- order of use --- */

static void unlink_locked(struct page_cache *cache, struct page *page)
{
	*(page->older != NULL ? &page->older->newer : &cache->oldest) = page->newer;
	*(page->newer != NULL ? &page->newer->older : &cache->newest) = page->older;
	page->older = page->newer = NULL;
}

static void link_newest_locked(struct page_cache *cache, struct page *page)
{
	page->older = cache->newest;
	page->newer = NULL;
	*(cache->newest != NULL ? &cache->newest->newer : &cache->oldest) = page;
	cache->newest = page;
}

/* --- loaders --- */

static void request_locked(struct page_cache *cache, struct page *page)
{
	page->request_next = NULL;
	if (cache->requests_last != NULL)
		cache->requests_last->request_next = page;
	else
		cache->requests_first = page;
	cache->requests_last = page;
	condition_wake_all(&cache->work);
}

static struct page *take_request_locked(struct page_cache *cache)
{
	struct page *before = NULL, *page = cache->requests_first, *found = NULL, *found_before = NULL;
	for (; page != NULL; before = page, page = page->request_next)
		if (found == NULL || (page->urgent && !found->urgent)) {
			found = page;
			found_before = before;
		}
	if (found == NULL)
		return NULL;
	*(found_before != NULL ? &found_before->request_next : &cache->requests_first) = found->request_next;
	if (cache->requests_last == found)
		cache->requests_last = found_before;
	return found;
}

static void *loader_body(void *argument)
{
	struct loader *loader = argument;
	struct page_cache *cache = loader->cache;
	mutex_lock(&cache->mutex);
	for (;;) {
		struct page *page = NULL;
		while (!cache->stopping && (page = take_request_locked(cache)) == NULL)
			condition_wait(&cache->work, &cache->mutex);
		if (cache->stopping)
			break;
		page->taken = true;
		page->begun = ++cache->load_clock;
		struct image *queued = newest_image_locked(cache, page->key);
		if (queued != NULL)
			queued->refs++;
		struct page_image *image = &page->image->page;
		mutex_unlock(&cache->mutex);
		enum status status = cache->params.io.load(cache->params.io.user, loader->number, image,
							   queued != NULL ? &queued->page : NULL);
		mutex_lock(&cache->mutex);
		if (queued != NULL)
			queued->refs--;
		failure_capture(&page->failure, status);
		page->state = PAGE_LOADED;
		condition_wake_all(&cache->done);
	}
	mutex_unlock(&cache->mutex);
	return NULL;
}

/* --- the writer --- */

static void *writer_body(void *argument)
{
	struct page_cache *cache = argument;
	mutex_lock(&cache->mutex);
	for (;;) {
		while (!cache->stopping && !cache->commit_busy)
			condition_wait(&cache->work, &cache->mutex);
		if (cache->stopping)
			break;
		uint32_t count = 0;
		for (struct image *image = cache->committing.first; image != NULL; image = image->next)
			cache->handed[count++] = &image->page;
		mutex_unlock(&cache->mutex);
		enum status status = cache->params.io.commit(cache->params.io.user, cache->handed, count, cache->record);
		mutex_lock(&cache->mutex);
		if (status == STATUS_OK) {
			cache->stats.commits++;
			cache->stats.writebacks += count;
			while (cache->committing.first != NULL) {
				struct image *image = list_take(&cache->committing, cache->committing.first->page.key);
				image->kept_until = cache->load_clock;
				list_append(&cache->kept, image);
			}
			release_kept_locked(cache);
		} else {
			failure_capture(&cache->failure, status);
			/* Not lost: back to waiting, unless a newer version already waits. */
			while (cache->committing.first != NULL) {
				struct image *image = list_take(&cache->committing, cache->committing.first->page.key);
				bool newer = false;
				for (struct image *i = cache->waiting.first; i != NULL; i = i->next)
					newer |= i->page.key == image->page.key;
				list_append(newer ? &cache->kept : &cache->waiting, image);
			}
		}
		cache->commit_busy = false;
		condition_wake_all(&cache->done);
	}
	mutex_unlock(&cache->mutex);
	return NULL;
}

/* --- the owner: slots --- */

static enum status no_image(void)
{
	return fail_memory("a page");
}

/* Reads a dirty page back into a waiting image, replacing an older waiting one. Lock not held. */
static enum status read_back(struct page_cache *cache, struct page *page)
{
	mutex_lock(&cache->mutex);
	struct image *image = image_get_locked(cache, page->key);
	mutex_unlock(&cache->mutex);
	if (image == NULL)
		return no_image();
	enum status status = cache->params.executor.execute(cache->params.executor.user, PAGE_READ_BACK, page->slot,
							    &image->page);
	mutex_lock(&cache->mutex);
	if (status != STATUS_OK) {
		image_put_locked(cache, image);
		mutex_unlock(&cache->mutex);
		return status;
	}
	struct image *older = list_take(&cache->waiting, page->key);
	if (older != NULL) { /* a load may still read it */
		older->kept_until = cache->load_clock;
		list_append(&cache->kept, older);
	}
	list_append(&cache->waiting, image);
	page->dirty = false;
	uint32_t queued = cache->waiting.count + cache->committing.count;
	if (queued > cache->stats.queue_peak)
		cache->stats.queue_peak = queued;
	mutex_unlock(&cache->mutex);
	return STATUS_OK;
}

static bool evictable(const struct page_cache *cache, const struct page *page, bool for_prefetch)
{
	return page->pins == 0 && (!for_prefetch || page->step + 1 < cache->step + 1);
}

/* Frees a slot by evicting the least recently used page that may go; NO_SLOT if none may. */
static enum status free_slot(struct page_cache *cache, bool for_prefetch, uint32_t *slot)
{
	if (cache->free_count > 0) {
		*slot = cache->free_slots[--cache->free_count];
		return STATUS_OK;
	}
	struct page *page = cache->oldest;
	while (page != NULL && !evictable(cache, page, for_prefetch))
		page = page->newer;
	*slot = NO_SLOT;
	if (page == NULL)
		return STATUS_OK;
	if (page->dirty) {
		uint32_t waiting = cache->waiting.count;
		if (waiting >= cache->params.queue_hard)
			return fail_with(STATUS_FAILED, "page cache: %u changed pages wait for a commit within one step; raise "
							"cache.slots",
					 waiting);
		enum status status = read_back(cache, page);
		if (status != STATUS_OK)
			return status;
	}
	mutex_lock(&cache->mutex);
	*slot = page->slot;
	unlink_locked(cache, page);
	forget_locked(cache, page);
	cache->stats.evictions++;
	mutex_unlock(&cache->mutex);
	return STATUS_OK;
}

/* A LOADED page becomes RESIDENT, or ABSENT if its load failed or nothing may go for it. */
static enum status install(struct page_cache *cache, struct page *page)
{
	enum status status = page->failure.status;
	uint32_t slot = NO_SLOT;
	if (status != STATUS_OK)
		failure_restore(&page->failure);
	else
		status = free_slot(cache, !page->urgent, &slot);
	if (status == STATUS_OK && slot != NO_SLOT)
		status = cache->params.executor.execute(cache->params.executor.user, PAGE_UPLOAD, slot, &page->image->page);
	mutex_lock(&cache->mutex);
	image_put_locked(cache, page->image);
	page->image = NULL;
	cache->loading--;
	cache->prefetching -= page->prefetched;
	if (status == STATUS_OK && slot != NO_SLOT) {
		page->state = PAGE_RESIDENT;
		page->slot = slot;
		link_newest_locked(cache, page);
	} else {
		if (slot != NO_SLOT)
			cache->free_slots[cache->free_count++] = slot;
		forget_locked(cache, page);
	}
	release_kept_locked(cache);
	mutex_unlock(&cache->mutex);
	return status;
}

static struct page *find_loaded_locked(struct page_cache *cache)
{
	if (cache->loading == 0)
		return NULL;
	for (uint32_t i = 0; i <= cache->bucket_mask; i++)
		for (struct page *page = cache->buckets[i]; page != NULL; page = page->hash_next)
			if (page->state == PAGE_LOADED)
				return page;
	return NULL;
}

static struct page *begin_load_locked(struct page_cache *cache, uint64_t key, bool urgent)
{
	struct page *page = mem_calloc(1, sizeof *page);
	struct image *image = page != NULL ? image_get_locked(cache, key) : NULL;
	if (image == NULL) {
		mem_free(page);
		return NULL;
	}
	*page = (struct page){.key = key, .slot = NO_SLOT, .urgent = urgent, .prefetched = !urgent, .image = image};
	struct page **bucket = &cache->buckets[hash(key) & cache->bucket_mask];
	page->hash_next = *bucket;
	*bucket = page;
	cache->loading++;
	cache->prefetching += !urgent;
	request_locked(cache, page);
	return page;
}

enum status page_cache_poll(struct page_cache *cache)
{
	assert(pthread_equal(cache->owner, pthread_self()));
	for (;;) {
		mutex_lock(&cache->mutex);
		struct page *page = find_loaded_locked(cache);
		mutex_unlock(&cache->mutex);
		if (page == NULL)
			return STATUS_OK;
		bool urgent = page->urgent;
		enum status status = install(cache, page);
		if (status != STATUS_OK && urgent)
			return status;
	}
}

static enum status note_touched(struct page_cache *cache, uint64_t key)
{
	if (2 * (cache->touched_count + 1) > cache->touched_room) {
		size_t room = cache->touched_room != 0 ? 2 * cache->touched_room : 1024;
		uint64_t *touched = mem_calloc(room, sizeof *touched);
		if (touched == NULL)
			return no_image();
		for (size_t i = 0; i < cache->touched_room; i++) {
			if (cache->touched[i] == 0)
				continue;
			size_t at = hash(cache->touched[i]) & (room - 1);
			while (touched[at] != 0)
				at = (at + 1) & (room - 1);
			touched[at] = cache->touched[i];
		}
		mem_free(cache->touched);
		cache->touched = touched;
		cache->touched_room = room;
	}
	size_t at = hash(key + 1) & (cache->touched_room - 1);
	while (cache->touched[at] != 0 && cache->touched[at] != key + 1)
		at = (at + 1) & (cache->touched_room - 1);
	if (cache->touched[at] == 0) {
		cache->touched[at] = key + 1;
		cache->touched_count++;
		cache->stats.touched++;
	}
	return STATUS_OK;
}

static void use_locked(struct page_cache *cache, struct page *page)
{
	unlink_locked(cache, page);
	link_newest_locked(cache, page);
}

/* Counts the access and sees to it that the page is resident or on its way, urgently. */
static enum status demand(struct page_cache *cache, uint64_t key)
{
	enum status status = note_touched(cache, key);
	if (status != STATUS_OK)
		return status;
	mutex_lock(&cache->mutex);
	status = failure_restore(&cache->failure);
	struct page *page = find_locked(cache, key);
	if (page != NULL && page->state == PAGE_RESIDENT) {
		cache->stats.hits++;
	} else {
		cache->stats.misses++;
		if (page != NULL) {
			cache->stats.late++;
			page->urgent = true;
		} else if (status == STATUS_OK && begin_load_locked(cache, key, true) == NULL) {
			status = no_image();
		}
	}
	mutex_unlock(&cache->mutex);
	return status;
}

/* Waits until the page is resident, pins it. */
static enum status take(struct page_cache *cache, uint64_t key, uint32_t *slot)
{
	double began = 0;
	for (;;) {
		mutex_lock(&cache->mutex);
		struct page *page = find_locked(cache, key);
		if (page != NULL && page->state == PAGE_RESIDENT) {
			page->pins++;
			page->step = cache->step;
			use_locked(cache, page);
			*slot = page->slot;
			if (began > 0)
				cache->stats.stall_ms += (clock_seconds() - began) * 1e3;
			mutex_unlock(&cache->mutex);
			return STATUS_OK;
		}
		if (page == NULL) { /* its load failed for another who asked, or it was pushed out again */
			page = begin_load_locked(cache, key, true);
			if (page == NULL) {
				mutex_unlock(&cache->mutex);
				return no_image();
			}
		}
		page->urgent = true;
		if (page->state == PAGE_LOADING && began == 0) {
			began = clock_seconds();
			cache->stats.stalls++;
		}
		while (page->state == PAGE_LOADING)
			condition_wait(&cache->done, &cache->mutex);
		mutex_unlock(&cache->mutex);
		enum status status = install(cache, page);
		if (status != STATUS_OK)
			return status;
		mutex_lock(&cache->mutex);
		bool there = find_locked(cache, key) != NULL;
		mutex_unlock(&cache->mutex);
		if (!there)
			return fail_with(STATUS_FAILED, "page cache: all %u slots are pinned; raise cache.slots to at least %u",
					 cache->params.slots, cache->params.slots + 1);
	}
}

enum status page_cache_pin_all(struct page_cache *cache, const uint64_t *keys, size_t count, uint32_t *slots)
{
	assert(pthread_equal(cache->owner, pthread_self()) && count <= PIN_MOST);
	enum status status = STATUS_OK;
	size_t taken = 0;
	if (count > cache->params.slots)
		return fail_with(STATUS_FAILED, "page cache: %zu pages are needed at once and there are %u slots; raise "
						"cache.slots to at least %zu",
				 count, cache->params.slots, count);
	for (size_t i = 0; i < count && status == STATUS_OK; i++)
		status = demand(cache, keys[i]);
	/* Those that are there first, so that a sibling's upload cannot push them out. */
	bool held[PIN_MOST] = {false};
	for (size_t i = 0; i < count && status == STATUS_OK; i++) {
		mutex_lock(&cache->mutex);
		struct page *page = find_locked(cache, keys[i]);
		held[i] = page != NULL && page->state == PAGE_RESIDENT;
		mutex_unlock(&cache->mutex);
		if (held[i])
			status = take(cache, keys[i], &slots[i]);
	}
	for (size_t i = 0; i < count && status == STATUS_OK; i++)
		if (!held[i]) {
			status = take(cache, keys[i], &slots[i]);
			held[i] = status == STATUS_OK;
		}
	for (size_t i = 0; i < count && status != STATUS_OK; i++, taken++)
		if (held[i]) {
			struct failure failure;
			failure_capture(&failure, status);
			page_cache_unpin(cache, keys[i]);
			failure_restore(&failure);
		}
	return status;
}

enum status page_cache_pin(struct page_cache *cache, uint64_t key, uint32_t *slot)
{
	return page_cache_pin_all(cache, &key, 1, slot);
}

void page_cache_unpin(struct page_cache *cache, uint64_t key)
{
	mutex_lock(&cache->mutex);
	struct page *page = find_locked(cache, key);
	assert(page != NULL && page->pins > 0);
	page->pins--;
	mutex_unlock(&cache->mutex);
}

void page_cache_dirty(struct page_cache *cache, uint64_t key)
{
	mutex_lock(&cache->mutex);
	struct page *page = find_locked(cache, key);
	assert(page != NULL && page->pins > 0);
	page->dirty = true;
	if (cache->dirty_since == 0)
		cache->dirty_since = clock_seconds();
	mutex_unlock(&cache->mutex);
}

void page_cache_prefetch(struct page_cache *cache, uint64_t key)
{
	mutex_lock(&cache->mutex);
	if (find_locked(cache, key) == NULL && cache->prefetching < 2 * cache->params.loaders &&
	    cache->failure.status == STATUS_OK && begin_load_locked(cache, key, false) != NULL)
		cache->stats.prefetched++;
	mutex_unlock(&cache->mutex);
}

bool page_cache_peek(struct page_cache *cache, uint64_t key, bool use, uint32_t *slot)
{
	mutex_lock(&cache->mutex);
	struct page *page = find_locked(cache, key);
	bool resident = page != NULL && page->state == PAGE_RESIDENT;
	if (resident) {
		*slot = page->slot;
		if (use)
			use_locked(cache, page);
	}
	mutex_unlock(&cache->mutex);
	return resident;
}

/* --- the owner: epochs --- */

static void wait_for_commit_locked(struct page_cache *cache)
{
	while (cache->commit_busy)
		condition_wait(&cache->done, &cache->mutex);
}

static enum status start_epoch(struct page_cache *cache, const void *record)
{
	mutex_lock(&cache->mutex);
	wait_for_commit_locked(cache);
	enum status status = failure_restore(&cache->failure);
	struct page *page = cache->oldest;
	mutex_unlock(&cache->mutex);
	for (; page != NULL && status == STATUS_OK; page = page->newer)
		if (page->dirty)
			status = read_back(cache, page);
	if (status != STATUS_OK)
		return status;
	mutex_lock(&cache->mutex);
	if (cache->waiting.count > cache->handed_room) {
		const struct page_image **handed =
			mem_realloc(cache->handed, cache->waiting.count, sizeof *cache->handed);
		if (handed == NULL) {
			mutex_unlock(&cache->mutex);
			return no_image();
		}
		cache->handed = handed;
		cache->handed_room = cache->waiting.count;
	}
	cache->committing = cache->waiting;
	cache->waiting = (struct list){NULL, NULL, 0};
	memcpy(cache->record, record, cache->params.record_bytes);
	cache->commit_busy = true;
	cache->dirty_since = 0;
	condition_wake_all(&cache->work);
	mutex_unlock(&cache->mutex);
	return STATUS_OK;
}

enum status page_cache_end_step(struct page_cache *cache, const void *record)
{
	assert(pthread_equal(cache->owner, pthread_self()));
	mutex_lock(&cache->mutex);
	cache->step++;
	enum status status = failure_restore(&cache->failure);
	uint32_t soft = cache->params.queue_soft, hard = cache->params.queue_hard;
	bool full = cache->waiting.count >= soft;
	bool old = cache->params.epoch_age > 0 && cache->dirty_since > 0 &&
		   clock_seconds() - cache->dirty_since > cache->params.epoch_age;
	bool must_wait = cache->waiting.count > (soft + hard) / 2;
	bool start = (full || old) && (!cache->commit_busy || must_wait);
	mutex_unlock(&cache->mutex);
	return status == STATUS_OK && start ? start_epoch(cache, record) : status;
}

enum status page_cache_flush(struct page_cache *cache, const void *record)
{
	enum status status = start_epoch(cache, record);
	mutex_lock(&cache->mutex);
	wait_for_commit_locked(cache);
	if (status == STATUS_OK)
		status = failure_restore(&cache->failure);
	mutex_unlock(&cache->mutex);
	return status;
}

/* --- looking at it --- */

void page_cache_each_queued(struct page_cache *cache, page_image_fn fn, void *user)
{
	/* The lists change only under the mutex; what is in them stays until released there. */
	mutex_lock(&cache->mutex);
	const struct list *lists[] = {&cache->kept, &cache->committing, &cache->waiting};
	for (int i = 0; i < 3; i++)
		for (struct image *image = lists[i]->first; image != NULL; image = image->next)
			fn(user, &image->page);
	mutex_unlock(&cache->mutex);
}

void page_cache_each_resident(struct page_cache *cache, page_resident_fn fn, void *user)
{
	for (struct page *page = cache->oldest; page != NULL; page = page->newer)
		fn(user, page->key, page->slot, page->dirty);
}

void page_cache_stats(struct page_cache *cache, struct page_stats *stats)
{
	mutex_lock(&cache->mutex);
	*stats = cache->stats;
	mutex_unlock(&cache->mutex);
}

/* --- life --- */

enum status page_cache_create(const struct page_params *params, struct page_cache **out)
{
	struct page_cache *cache = mem_calloc(1, sizeof *cache);
	if (cache == NULL)
		return no_image();
	cache->params = *params;
	cache->owner = pthread_self();
	mutex_init(&cache->mutex);
	condition_init(&cache->work);
	condition_init(&cache->done);
	uint32_t buckets = 64;
	while (buckets < 2 * params->slots)
		buckets *= 2;
	cache->bucket_mask = buckets - 1;
	cache->buckets = mem_calloc(buckets, sizeof *cache->buckets);
	cache->free_slots = mem_calloc(params->slots, sizeof *cache->free_slots);
	cache->record = mem_calloc(params->record_bytes, 1);
	cache->loaders = mem_calloc(params->loaders, sizeof *cache->loaders);
	enum status status = STATUS_OK;
	if (cache->buckets == NULL || cache->free_slots == NULL || cache->record == NULL || cache->loaders == NULL)
		status = no_image();
	for (uint32_t i = 0; status == STATUS_OK && i < params->slots; i++)
		cache->free_slots[cache->free_count++] = params->slots - 1 - i;
	for (uint32_t i = 0; status == STATUS_OK && i < params->loaders; i++) {
		cache->loaders[i] = (struct loader){.cache = cache, .number = i};
		status = thread_start(&cache->loaders[i].thread, loader_body, &cache->loaders[i], "furrow-load");
	}
	if (status == STATUS_OK)
		status = thread_start(&cache->writer, writer_body, cache, "furrow-write");
	if (status != STATUS_OK) {
		page_cache_destroy(cache);
		return status;
	}
	*out = cache;
	return STATUS_OK;
}

static void free_images(struct image *image)
{
	while (image != NULL) {
		struct image *next = image->next;
		mem_free(image->page.bytes);
		mem_free(image);
		image = next;
	}
}

void page_cache_destroy(struct page_cache *cache)
{
	if (cache == NULL)
		return;
	mutex_lock(&cache->mutex);
	cache->stopping = true;
	condition_wake_all(&cache->work);
	mutex_unlock(&cache->mutex);
	for (uint32_t i = 0; cache->loaders != NULL && i < cache->params.loaders; i++)
		thread_join(&cache->loaders[i].thread);
	thread_join(&cache->writer);
	for (uint32_t i = 0; cache->buckets != NULL && i <= cache->bucket_mask; i++)
		for (struct page *page = cache->buckets[i], *next; page != NULL; page = next) {
			next = page->hash_next;
			if (page->image != NULL) {
				page->image->next = NULL;
				free_images(page->image);
			}
			mem_free(page);
		}
	free_images(cache->free_images);
	free_images(cache->waiting.first);
	free_images(cache->committing.first);
	free_images(cache->kept.first);
	mem_free(cache->buckets);
	mem_free(cache->free_slots);
	mem_free(cache->touched);
	mem_free(cache->handed);
	mem_free(cache->record);
	mem_free(cache->loaders);
	condition_finish(&cache->work);
	condition_finish(&cache->done);
	mutex_finish(&cache->mutex);
	mem_free(cache);
}
