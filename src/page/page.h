/*
 * page: decides which tiles are resident, and keeps what was changed until it is committed.
 *
 * It knows neither GL nor SQLite. The owner (one thread, the one that owns GL) asks for pages by
 * key, executes the work list the cache emits ("upload 7", "read back 9"), and says when a step is
 * over. Loader threads call io.load, one writer thread calls io.commit; both outside the mutex.
 *
 * Every function is for the owner thread unless it says otherwise.
 *
 *     ABSENT -> LOADING -> LOADED -> (upload) -> RESIDENT -> (read back, if dirty) -> ABSENT
 *                                                   |  ^                 |
 *                                                  pin unpin             v
 *                                                              queue -> committing -> gone
 */
#ifndef FURROW_PAGE_H
#define FURROW_PAGE_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

/* A page's bytes on the host. What they mean is the io's and the executor's business. */
struct page_image {
	uint64_t key;
	unsigned flags; /* the io's own: which planes are filled, kind of base */
	void *bytes;    /* params.page_bytes, owned by the cache */
};

struct page_io {
	void *user;
	/* A loader thread (0 .. loaders - 1): fill `image`. `queued` is the newest version of this page
	 * that is not in the store yet, or NULL: its read-back planes are newer than the store's. */
	enum status (*load)(void *user, unsigned loader, struct page_image *image,
			    const struct page_image *queued);
	/* The writer thread: commit `images` and `record` as one epoch, all or nothing. */
	enum status (*commit)(void *user, const struct page_image *const *images, size_t count,
			      const void *record);
};

/* The work list: what the owner must do to slots, in this order. */
enum page_work_kind {
	PAGE_UPLOAD,    /* fill slot `slot` from `image` */
	PAGE_READ_BACK, /* fill `image` (what changed: the io knows which planes) from slot `slot` */
};
struct page_executor {
	void *user;
	enum status (*execute)(void *user, enum page_work_kind kind, uint32_t slot,
			       struct page_image *image);
};

struct page_params {
	uint32_t slots;   /* at least 1 */
	uint32_t loaders; /* threads, at least 1 */
	size_t page_bytes;
	uint32_t queue_soft; /* pages waiting for a commit at which page_cache_end_step starts an epoch */
	uint32_t queue_hard; /* the bound: more than this is STATUS_FAILED */
	double epoch_age;    /* seconds after which a change is committed; 0: only on a full queue */
	size_t record_bytes; /* of the run's record, copied at each epoch */
	struct page_io io;
	struct page_executor executor;
};

struct page_stats {
	uint64_t hits, misses;    /* accesses by page_cache_pin that found it resident, or not */
	uint64_t prefetched;      /* loads begun by page_cache_prefetch */
	uint64_t late;            /* misses whose load was already on its way */
	uint64_t evictions;       /* pages that gave up their slot */
	uint64_t writebacks;      /* pages committed */
	uint64_t stalls;          /* times the owner waited for a page */
	double stall_ms;
	uint64_t touched;         /* different pages ever pinned */
	uint64_t commits;         /* epochs whose commit returned */
	uint32_t queue_peak;      /* pages waiting for a commit, at most */
	uint64_t host_bytes;      /* host buffers allocated */
};

struct page_cache;

enum status page_cache_create(const struct page_params *params, struct page_cache **out) FURROW_CHECKED;
/* Stops the threads; commits nothing. Takes NULL. */
void page_cache_destroy(struct page_cache *cache);

/* Resident and pinned on return: waits for the load if it must (counted as a stall), runs the work
 * list meanwhile. STATUS_FAILED if every slot is pinned. Pins count. */
enum status page_cache_pin(struct page_cache *cache, uint64_t key, uint32_t *slot) FURROW_CHECKED;
/* Several at once: all are requested before the first is waited for. At most 64. */
enum status page_cache_pin_all(struct page_cache *cache, const uint64_t *keys, size_t count,
			       uint32_t *slots) FURROW_CHECKED;
void page_cache_unpin(struct page_cache *cache, uint64_t key);
/* The pinned page now differs from the store. */
void page_cache_dirty(struct page_cache *cache, uint64_t key);

/* Asks for a page without waiting; ignored when nothing can be evicted for it. */
void page_cache_prefetch(struct page_cache *cache, uint64_t key);
/* True, with its slot, if resident now; no wait, no load, no pin. With `use` it becomes the most
 * recently used. The slot is valid until the next call that can evict (pin, prefetch, poll). */
bool page_cache_peek(struct page_cache *cache, uint64_t key, bool use, uint32_t *slot);
/* Executes the work that is ready (finished loads become resident), without waiting. */
enum status page_cache_poll(struct page_cache *cache) FURROW_CHECKED;

/* The step is over and every page is consistent: starts an epoch if the queue is full enough or a
 * change is old enough. `record` (record_bytes) goes into it. Dirty pages are read back now and
 * committed in the background; they are clean unless dirtied again. Sticky failures surface here. */
enum status page_cache_end_step(struct page_cache *cache, const void *record) FURROW_CHECKED;
/* Commits everything and waits for it. */
enum status page_cache_flush(struct page_cache *cache, const void *record) FURROW_CHECKED;

/* Versions of pages that a load which began before now may have missed: those waiting for a commit,
 * and those committed after the oldest load still on its way began. Oldest first. An executor that
 * uploads a coarser level overlays them, and then what each_resident shows. */
typedef void (*page_image_fn)(void *user, const struct page_image *image);
void page_cache_each_queued(struct page_cache *cache, page_image_fn fn, void *user);
/* Resident pages, any order. */
typedef void (*page_resident_fn)(void *user, uint64_t key, uint32_t slot, bool dirty);
void page_cache_each_resident(struct page_cache *cache, page_resident_fn fn, void *user);

void page_cache_stats(struct page_cache *cache, struct page_stats *stats);

#endif
