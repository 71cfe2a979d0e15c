/*
 * page: decides which tiles are resident, and keeps what was changed until it is committed.
 *
 * It knows neither GL nor SQLite. The owner (one thread, the one that owns GL) asks for pages by
 * key, executes the work the cache hands it ("upload 7", "read back 9"), and says when a step is
 * over. Loader threads call io.load, one writer thread calls io.commit; both outside the mutex.
 * The owner begins an upload or a read-back and does not wait for it: the cache asks later whether
 * it is settled, and until then leaves its image alone.
 *
 * Every function is for the owner thread unless it says otherwise.
 *
 *     ABSENT -> LOADING -> LOADED -> (upload) -> RESIDENT -> (read back, if dirty) -> ABSENT
 *                                                   |  ^                 |
 *                                                  pin unpin             v
 *                                                      queue (filling -> full) -> committing -> gone
 *
 * The page that goes for another is the least recently used one that is not pinned; one that is
 * wished for goes only if there is no other. Use is a pin, or a picture's peek.
 */
#ifndef FURROW_PAGE_H
#define FURROW_PAGE_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

/* A page's bytes on the host. What they mean is the io's and the executor's business. */
/* All planes; those a step changes; what else goes into an epoch. */
enum page_image_kind { PAGE_LOADED_IMAGE, PAGE_CHANGED_IMAGE, PAGE_SNAPSHOT_IMAGE, PAGE_IMAGE_KINDS };
struct page_image {
	uint64_t key;
	unsigned flags; /* the io's own: which planes are filled */
	bool overlays;  /* set by io.load: its upload looks at the queue's versions of other pages */
	void *bytes;    /* executor.create's */
	void *memory;   /* executor.create's own */
};

struct page_io {
	void *user;
	/* A loader thread (0 .. loaders - 1; the owner is 0 without loaders): fill `image`. `queued` is
	 * the newest version of this page that is not in the store yet, or NULL: the planes it has are
	 * newer than the store's. */
	enum status (*load)(void *user, unsigned loader, struct page_image *image,
			    const struct page_image *queued);
	/* The writer thread: commit `images`, `record` and the snapshot (NULL: there is none) as one epoch,
	 * all or nothing. */
	enum status (*commit)(void *user, const struct page_image *const *images, size_t count,
			      const void *record, const struct page_image *snapshot);
};

/* What the owner does to slots and to the memory that feeds them; all in the order it is asked. */
struct page_executor {
	void *user;
	/* Sets image->bytes and image->memory; kept until destroy, which may wait. */
	enum status (*create)(void *user, enum page_image_kind kind, struct page_image *image);
	void (*destroy)(void *user, struct page_image *image);
	/* Begin to fill the slot from the image, or the image from the slot. */
	enum status (*upload)(void *user, uint32_t slot, struct page_image *image);
	enum status (*read_back)(void *user, uint32_t slot, struct page_image *image);
	/* Begin to fill the image from what is no page's and changes with the steps, as it is when an epoch
	 * begins. NULL: there is nothing such. */
	enum status (*snapshot)(void *user, struct page_image *image);
	/* Whether what was begun last with this image is over; never waits. */
	enum status (*settled)(void *user, const struct page_image *image, bool *settled);
};

struct page_params {
	uint32_t slots;   /* at least 1 */
	uint32_t loaders; /* threads; 0: the owner loads, and nothing ahead of time */
	/* Changed pages (dirty, or waiting for a commit) at which page_cache_end_step starts an epoch;
	 * at twice as many it waits for the one in flight. */
	uint32_t queue_soft;
	uint32_t queue_most; /* images for changed pages: PAGE_QUEUE_MOST; needing more is STATUS_FAILED */
	double epoch_age;    /* seconds after which a change is committed; 0: only by their number */
	size_t record_bytes; /* of the run's record, copied at each epoch */
	/* The owner, before the record of an epoch is taken; NULL: nothing to do. */
	enum status (*before_epoch)(void *user);
	void *before_epoch_user;
	struct page_io io;
	struct page_executor executor;
	struct page_trace *trace; /* every access is noted there; NULL: nowhere */
};
/* Enough for any step that changes `step_pages` pages: as many wait, at most, as are committed. */
#define PAGE_QUEUE_MOST(soft, step_pages) (2 * (2 * (soft) + (step_pages)))
/* The threads' names. */
#define PAGE_WRITER_THREAD "furrow-write"
#define PAGE_LOADER_THREAD "furrow-load"
/* Images for loads, made at once and kept. */
uint32_t page_load_images(uint32_t loaders);

struct page_stats {
	uint64_t hits, misses;    /* accesses by page_cache_pin that found it resident, or not */
	uint64_t prefetched;      /* loads begun for a wish */
	uint64_t cancelled;       /* wishes given up before they were resident */
	uint64_t late;            /* misses whose load had begun and was not in its slot yet */
	uint64_t not_begun;       /* misses that were requested ahead and whose load had not begun */
	uint64_t evictions;       /* pages that gave up their slot */
	uint64_t writebacks;      /* pages committed */
	uint64_t stalls;          /* times the owner waited: for a page, for the queue, for an epoch */
	double stall_ms;
	uint64_t touched;         /* different pages ever pinned */
	uint64_t commits;         /* epochs whose commit returned */
	uint32_t queue_peak;      /* images of changed pages made */
};

struct page_cache;

enum status page_cache_create(const struct page_params *params, struct page_cache **out) FURROW_CHECKED;
/* Stops the threads, after what each is at; commits nothing. Then only page_cache_stats and page_cache_destroy. */
void page_cache_stop(struct page_cache *cache);
/* This thread is the owner from now on; another one was, and does not use the cache meanwhile. Takes NULL. */
void page_cache_adopt(struct page_cache *cache);
/* The same, and all it has. Takes NULL. */
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

/* The whole wish list, soonest needed first, each key once: these are loaded ahead, in this order, as far
 * as there are slots that this step has not used, and stay if anything else can go. What was wished
 * before and is not in the list is cancelled. */
void page_cache_want(struct page_cache *cache, const uint64_t *keys, size_t count);
/* How far the last list is: some of it is on its way; or all is resident, so that until it changes it
 * need not be given again; or neither, for want of slots, or since a load failed or something else
 * had to have a slot. */
enum page_wishes { PAGE_WISHES_COMING, PAGE_WISHES_HERE, PAGE_WISHES_SHORT };
enum page_wishes page_cache_wishes(struct page_cache *cache);
/* True, with its slot, if resident now; no wait, no load, no pin. With `use` it becomes the most
 * recently used. The slot is valid until the next call that can evict (pin, poll). */
bool page_cache_peek(struct page_cache *cache, uint64_t key, bool use, uint32_t *slot);
/* Executes the work that is ready (finished loads become resident), without waiting. */
enum status page_cache_poll(struct page_cache *cache) FURROW_CHECKED;

/* The step is over and every page is consistent: starts an epoch if enough changed or a change is
 * old enough. `record` (world_record_bytes) goes into it. Dirty pages are read back as they are now and
 * committed in the background; they are clean unless dirtied again. Sticky failures surface here. */
enum status page_cache_end_step(struct page_cache *cache, const void *record) FURROW_CHECKED;
/* Commits everything and waits for it. */
enum status page_cache_flush(struct page_cache *cache, const void *record) FURROW_CHECKED;

/* True while a rollback waits for the commit in flight, which need not end then: io.commit may fail with STATUS_INTERRUPTED, having
 * changed nothing, and that is no failure. Any thread. */
bool page_cache_gives_up(struct page_cache *cache);
/* Goes back to an earlier state of the store, between two steps. All for the owner thread. After page_cache_flush, and in
 * `back`, the writer thread is idle until the next epoch begins: the owner may use what io.commit writes to. */
struct page_rollback {
	void *user;
	/* The store goes back. Nothing reads it whose result is used. If it fails, it must be what it was. What will be lost,
	 * though it was never committed, is what page_cache_each_changed() tells still. */
	enum status (*back)(void *user);
	/* After that, of a resident page that was committed: whether a load may bring now what is not in its slot. */
	bool (*changed)(void *user, uint64_t key);
	/* The page was resident, and is no more. */
	void (*dropped)(void *user, uint64_t key);
};
/* Waits for the epoch in flight, then goes back. What was changed and not committed is lost, loads and wishes are given up,
 * pages that changed are dropped, and read again when they are asked for; all others stay where they are. Nothing that is
 * dropped may be pinned. Sticky failures surface here; if it fails, no change is lost, and it may be called again. */
enum status page_cache_rollback(struct page_cache *cache, const struct page_rollback *rollback) FURROW_CHECKED;

/* Versions of pages that a load which began before now may have missed: those waiting for a commit,
 * and those committed after the oldest load still on its way began. Oldest first. An executor that
 * uploads an image that `overlays` looks at them, and then at what each_resident shows; all are
 * filled then. At other times one whose read-back is not settled is not shown. */
typedef void (*page_image_fn)(void *user, const struct page_image *image);
void page_cache_each_queued(struct page_cache *cache, page_image_fn fn, void *user);
/* Resident pages, any order. */
typedef void (*page_resident_fn)(void *user, uint64_t key, uint32_t slot, bool dirty);
void page_cache_each_resident(struct page_cache *cache, page_resident_fn fn, void *user);

/* Where the newest version of a page is, between two steps. With PAGE_NEWEST_QUEUED `fn` was called with its image, filled:
 * waits for its read-back if that is not settled. With PAGE_NEWEST_SLOT it is in `*slot`, dirty. Nothing is used, loaded or counted. */
enum page_newest { PAGE_NEWEST_STORED, PAGE_NEWEST_QUEUED, PAGE_NEWEST_SLOT };
enum status page_cache_newest(struct page_cache *cache, uint64_t key, page_image_fn fn, void *user, enum page_newest *newest,
			      uint32_t *slot) FURROW_CHECKED;
/* Every page whose newest version may not be in the store, some twice. `fn` may not ask the cache for anything. */
typedef void (*page_key_fn)(void *user, uint64_t key);
void page_cache_each_changed(struct page_cache *cache, page_key_fn fn, void *user);

void page_cache_stats(struct page_cache *cache, struct page_stats *stats);

/*
 * --- traces: what was asked of a cache, kept to judge it by ---
 *
 * An access is a key of a pin or a peek with `use`. A trace is written beside its file and is that
 * file only once it is whole. One thread at a time a trace. Its file:
 *
 *     header   8 bytes "furrowPT", uint32 version, little-endian
 *     records  each begins with a number in LEB128 (7 bits a byte, low bits first):
 *       tile << 3 | resident << 2 | kind << 1     an access. Tiles are numbered from 0 in the order in
 *                                                 which they first come; the first of a tile is followed
 *                                                 by its key, a uint64
 *       steps << 1 | 1, steps > 0                 the accesses that follow are so many steps later
 *       1                                         the end, followed by three uint64: how many accesses,
 *                                                 how many tiles, and the XXH3 of all bytes before itself
 *
 * A drive comes back to the tiles it lately had, and has few in all: of a million accesses most name
 * one of a few hundred tiles, which is two bytes, where key, step and flags in full would be 16.
 */
#define PAGE_TRACE_MAGIC "furrowPT"
#define PAGE_TRACE_VERSION 1
#define PAGE_TRACE_HEADER 12   /* bytes */
#define PAGE_TRACE_KEY_BITS 62 /* tile_key's */

enum page_access { PAGE_ACCESS_PIN, PAGE_ACCESS_DRAW, PAGE_ACCESS_KINDS };
struct page_trace;

/* STATUS_FAILED if `path` cannot be written, or is there and is no trace. */
enum status page_trace_create(const char *path, struct page_trace **out) FURROW_CHECKED;
/* `step` never falls; `key` is below 2^62; `resident`: the cache had it. A failure is kept for
 * page_trace_status, and nothing more is noted. Takes NULL: nothing. */
void page_trace_access(struct page_trace *trace, uint64_t step, uint64_t key, enum page_access kind,
		       bool resident);
/* What went wrong so far. Takes NULL. */
enum status page_trace_status(const struct page_trace *trace) FURROW_CHECKED;
/* Makes the trace whole and puts it in place; nothing may be noted after. Takes NULL. */
enum status page_trace_publish(struct page_trace *trace) FURROW_CHECKED;
/* Leaves nothing behind unless it was published. Takes NULL. */
void page_trace_destroy(struct page_trace *trace);

#endif
