/*
 * page: decides which tiles are resident (in a slot), and keeps changed tiles until they are committed.
 *
 * It uses neither GL nor SQLite itself. It does not know whether slots are of the GPU or in host memory. It has one owner: the thread
 * that owns the slots. The owner asks for pages by key. It executes the work that the cache gives it ("upload 7", "read back 9"), and
 * says when a step is over. Loader threads call io.load, and one writer thread calls io.commit, both without holding the mutex. The
 * owner begins an upload or a read-back and does not wait for it. The cache asks later if the transfer is settled (finished). Until
 * then it does not touch the image.
 *
 * Call every function on the owner thread, unless its comment says otherwise.
 *
 *     ABSENT -> LOADING -> LOADED -> (upload) -> RESIDENT -> (read back, if dirty) -> ABSENT
 *                                                   |  ^                 |
 *                                                  pin unpin             v
 *                                                      queue (filling -> full) -> committing -> gone
 *
 * A page that needs a slot evicts the least recently used page that is not pinned. Pages with a prefetch request are evicted
 * last. Pinning a page uses it, and so does drawing it (a peek with `use`).
 */
#ifndef FURROW_PAGE_H
#define FURROW_PAGE_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

/* A page's bytes in CPU memory. Only the io and the executor know their layout. */
/* Loaded image: has all planes. Changed image: has the planes that a step changes. Snapshot image: has other data that is
 * committed with the pages. */
enum page_image_kind { PAGE_LOADED_IMAGE, PAGE_CHANGED_IMAGE, PAGE_SNAPSHOT_IMAGE, PAGE_IMAGE_KINDS };
struct page_image {
	uint64_t key;
	unsigned flags; /* set by the io: which planes are filled */
	bool overlays;  /* set by io.load: its upload reads the queued versions of other pages */
	void *bytes;    /* allocated by executor.create */
	void *memory;   /* private data of executor.create */
};

struct page_io {
	void *user;
	/* Fills `image`. Called on loader thread `loader`, 0 .. loaders - 1; if there are no loaders, on the owner thread as 0.
	 * `queued`: the newest version of this page that is not in the store yet, or NULL. Its planes are newer than those in
	 * the store. */
	enum status (*load)(void *user, unsigned loader, struct page_image *image,
			    const struct page_image *queued);
	/* Commits `images`, `record` and `snapshot` (may be NULL) in one transaction. Called on the writer thread. NULL: no page is ever
	 * dirty, and there is no writer thread. */
	enum status (*commit)(void *user, const struct page_image *const *images, size_t count,
			      const void *record, const struct page_image *snapshot);
};

/* The work on slots and on images, done by the owner. Transfers take effect in the order of the calls. */
struct page_executor {
	void *user;
	/* Sets image->bytes and image->memory, which stay until `destroy`. `destroy` may wait. */
	enum status (*create)(void *user, enum page_image_kind kind, struct page_image *image);
	void (*destroy)(void *user, struct page_image *image);
	/* Begins to fill the slot from the image, or the image from the slot. */
	enum status (*upload)(void *user, uint32_t slot, struct page_image *image);
	enum status (*read_back)(void *user, uint32_t slot, struct page_image *image);
	/* Begins to fill the image with data that belongs to no page and changes with the steps, as it is when a commit begins.
	 * NULL: there is no such data. */
	enum status (*snapshot)(void *user, struct page_image *image);
	/* Tells whether the last transfer of this image has finished. Never waits. */
	enum status (*settled)(void *user, const struct page_image *image, bool *settled);
	/* Nobody uses what the image holds any more. Called on any thread that uses the cache, with its mutex held. So it must be
	 * quick, and must not call the cache. Its last transfer has settled, unless the cache is being destroyed. NULL: nothing to do. */
	void (*drop)(void *user, struct page_image *image);
};

struct page_params {
	uint32_t slots;   /* at least 1 */
	uint32_t loaders; /* threads; 0: the owner loads, and nothing is loaded ahead */
	/* If so many pages are changed (dirty, or waiting for a commit), page_cache_end_step starts a commit. At twice as many
	 * it waits for the commit in flight. */
	uint32_t queue_soft;
	uint32_t queue_most; /* images for changed pages: PAGE_QUEUE_MOST. If more are needed: STATUS_FAILED */
	/* Before more images than these are made, a page that must go waits for the commit in flight. 0: queue_most */
	uint32_t queue_few;
	/* s after which a change is committed; 0: only the number of changed pages counts. After a commit that took long, four times as long */
	double commit_age;
	bool commits_begun;   /* true: only page_cache_begin_commit and page_cache_flush begin commits */
	size_t record_bytes; /* size of the run's record, which is copied at each commit */
	/* Called on the owner's thread, before a commit takes the record. May be NULL. */
	enum status (*begin_commit)(void *user);
	void *begin_commit_user;
	struct page_io io;
	struct page_executor executor;
	struct page_trace *trace; /* notes every access; may be NULL */
};
/* Number of images that is enough if a step changes at most `step_pages` pages. At most half of them wait; the other half is
 * being committed. */
#define PAGE_QUEUE_MOST(soft, step_pages) (2 * (2 * (soft) + (step_pages)))
/* Names of the threads. */
#define PAGE_WRITER_THREAD "furrow-write"
#define PAGE_LOADER_THREAD "furrow-load"
/* Returns the number of images for loads. They are made at the start and kept. */
uint32_t page_load_images(uint32_t loaders);

struct page_stats {
	uint64_t hits, misses;    /* page_cache_pin found the page resident, or did not */
	uint64_t prefetched;      /* loads begun for a prefetch request */
	uint64_t cancelled;       /* prefetch requests given up before the page was resident */
	uint64_t late;            /* misses whose load had begun, but was not in its slot yet */
	uint64_t not_begun;       /* misses with a prefetch request whose load had not begun */
	uint64_t evictions;       /* pages that gave up their slot */
	uint64_t writebacks;      /* pages committed */
	uint64_t stalls;          /* times the owner waited: for a page, for the queue, for a commit */
	double stall_ms;
	uint64_t touched;         /* different pages ever pinned */
	uint64_t commits;         /* calls of io.commit that have returned */
	uint32_t queue_peak;      /* images of changed pages made */
};

struct page_cache;

enum status page_cache_create(const struct page_params *params, struct page_cache **out) FURROW_CHECKED;
/* Stops the threads after their current work. Commits nothing. Afterwards call only page_cache_stats and page_cache_destroy. */
void page_cache_stop(struct page_cache *cache);
/* Makes the calling thread the owner. The earlier owner must not use the cache at the same time. cache may be NULL. */
void page_cache_adopt(struct page_cache *cache);
/* Stops the threads as page_cache_stop does, and frees everything. cache may be NULL. */
void page_cache_destroy(struct page_cache *cache);

/* Makes a page resident and pins it. If the page must be loaded, waits for that (a stall) and executes other work meanwhile. A
 * page pinned twice must be unpinned twice. STATUS_FAILED: every slot is pinned. */
enum status page_cache_pin(struct page_cache *cache, uint64_t key, uint32_t *slot) FURROW_CHECKED;
#define PAGE_PIN_MOST 512
/* Pins several pages, at most PAGE_PIN_MOST. Requests all loads before it waits for the first. */
enum status page_cache_pin_all(struct page_cache *cache, const uint64_t *keys, size_t count,
			       uint32_t *slots) FURROW_CHECKED;
void page_cache_unpin(struct page_cache *cache, uint64_t key);
/* Marks a pinned page as dirty: it now differs from the store. */
void page_cache_dirty(struct page_cache *cache, uint64_t key);

/* Sets the prefetch requests: the whole list, soonest needed first, each key once. The pages are loaded ahead in this order,
 * into slots that this step does not use. Other pages are evicted before them. Requests of the earlier list that are not in the
 * new one are cancelled. */
void page_cache_want(struct page_cache *cache, const uint64_t *keys, size_t count);
/* State of the last list of prefetch requests. COMING: some pages are being loaded. HERE: all pages are resident, so the same
 * list need not be given again. SHORT: neither. Slots are missing, a load failed, or a requested page was evicted for another
 * one. */
enum page_request_state { PAGE_REQUESTS_COMING, PAGE_REQUESTS_HERE, PAGE_REQUESTS_SHORT };
enum page_request_state page_cache_request_state(struct page_cache *cache);
/* Returns true if the page is resident now, and gives its slot. Does not wait, load or pin. With `use` the page becomes the
 * most recently used. The slot is valid until the next call that can evict (pin, poll). */
bool page_cache_peek(struct page_cache *cache, uint64_t key, bool use, uint32_t *slot);
/* Executes the work that is ready: finished loads become resident. Does not wait. */
enum status page_cache_poll(struct page_cache *cache) FURROW_CHECKED;

/* Call this at the end of a step, when all pages are consistent. Starts a commit if enough pages changed or a change is old
 * enough. `record`: params.record_bytes bytes, committed with the pages. Dirty pages are read back as they are now and
 * committed in the background. After that they are clean, until a later step changes them. Also returns failures of the
 * threads. */
enum status page_cache_end_step(struct page_cache *cache, const void *record) FURROW_CHECKED;
/* While held, page_cache_end_step begins no commit. A cache is not held at first. */
void page_cache_hold(struct page_cache *cache, bool held);
/* Commits all changes with this record, and waits until it is done. */
enum status page_cache_flush(struct page_cache *cache, const void *record) FURROW_CHECKED;

/*
 * --- pages that move to the cache of another process ---
 *
 * Call these between two steps. A page is given with its newest planes, and this cache forgets it: no later commit writes it. What
 * was committed of it stays in the store, and the caller must not ask this cache for it before it is put back.
 */

/* image NULL: the newest version is in the store. */
typedef enum status (*page_taken_fn)(void *user, uint64_t key, const struct page_image *image);
/* Gives pages, each key once. Begins all read-backs before it waits for the first. On failure pages are lost from the cache, so the
 * run must end without a commit. */
enum status page_cache_take(struct page_cache *cache, const uint64_t *keys, size_t count, page_taken_fn fn, void *user) FURROW_CHECKED;
/* Puts a page into the queue, as the next commit is to write it. `fn` fills its image, that of a changed page, and sets its flags. If it
 * fails, nothing is put. */
typedef enum status (*page_fill_fn)(void *user, struct page_image *image);
enum status page_cache_put(struct page_cache *cache, uint64_t key, page_fill_fn fn, void *user) FURROW_CHECKED;

/* For a cache with params.commits_begun. Tells whether page_cache_end_step would have begun a commit without that. */
bool page_cache_commit_due(struct page_cache *cache);
enum status page_cache_await_commit(struct page_cache *cache) FURROW_CHECKED; /* waits until no commit is in flight */
/* Begins a commit of everything as the last step left it, after the one in flight. */
enum status page_cache_begin_commit(struct page_cache *cache, const void *record) FURROW_CHECKED;

/* Returns true while a rollback waits for the commit in flight. Then io.commit may stop early: it changes nothing and returns
 * STATUS_INTERRUPTED, which does not count as a failure. Any thread. */
bool page_cache_gives_up(struct page_cache *cache);
/* Functions for page_cache_rollback, all called on the owner thread. After page_cache_flush, and during `back`, the writer
 * thread is idle until the next commit begins. So the owner may then use the data that io.commit writes to. */
struct page_rollback {
	void *user;
	/* Sets the store back. Meanwhile no load reads the store, except loads whose result is dropped. On failure it must
	 * change nothing. page_cache_each_changed() still tells the changes that were never committed and will be lost. */
	enum status (*back)(void *user);
	/* Called after `back`, for each resident page that was committed. Returns true if loading the page now could give other
	 * values than those in its slot. */
	bool (*changed)(void *user, uint64_t key);
	/* Called after a resident page was dropped. */
	void (*dropped)(void *user, uint64_t key);
};
/* Waits for the commit in flight, then goes back to an earlier state of the store. Changes that were not committed are lost.
 * Loads and prefetch requests are cancelled. Pages that changed are dropped, and loaded again when they are asked for; other
 * pages stay resident. No dropped page may be pinned. Also returns failures of the threads. On failure no change is lost, and
 * the call may be repeated. */
enum status page_cache_rollback(struct page_cache *cache, const struct page_rollback *rollback) FURROW_CHECKED;

/* Calls `fn` with versions of pages that a load begun earlier may have missed, oldest first. These are the versions that wait
 * for a commit, and those committed after the oldest running load began.
 *
 * When the executor uploads an image with `overlays`, it reads these, and then the pages that page_cache_each_resident gives.
 * At that time all images are filled. At other times, images whose read-back is not settled are left out. */
typedef void (*page_image_fn)(void *user, const struct page_image *image);
void page_cache_each_queued(struct page_cache *cache, page_image_fn fn, void *user);
/* Calls `fn` with each resident page, in any order. */
typedef void (*page_resident_fn)(void *user, uint64_t key, uint32_t slot, bool dirty);
void page_cache_each_resident(struct page_cache *cache, page_resident_fn fn, void *user);

/* Finds the newest version of a page, between two steps. PAGE_NEWEST_QUEUED: `fn` was called with its image, after waiting for
 * the read-back. PAGE_NEWEST_SLOT: the newest version is in `*slot` (dirty). PAGE_NEWEST_STORED: it is in the store. Loads
 * nothing, and counts as neither a use nor an access. */
enum page_newest { PAGE_NEWEST_STORED, PAGE_NEWEST_QUEUED, PAGE_NEWEST_SLOT };
enum status page_cache_newest(struct page_cache *cache, uint64_t key, page_image_fn fn, void *user, enum page_newest *newest,
			      uint32_t *slot) FURROW_CHECKED;
/* Calls `fn` with every page whose newest version may not be in the store; some pages come twice. `fn` must not call the cache. */
typedef void (*page_key_fn)(void *user, uint64_t key);
void page_cache_each_changed(struct page_cache *cache, page_key_fn fn, void *user);

void page_cache_stats(struct page_cache *cache, struct page_stats *stats);

/*
 * --- traces: the accesses to a cache, to judge replacement policies by ---
 *
 * An access is the key of a pin, or of a peek with `use`. A trace is written beside its file and gets the file's name only when
 * it is complete. One thread at a time uses a trace. The file:
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
 * A drive uses few tiles, and the same ones again and again. Of a million accesses most name one of a few hundred tiles. Such
 * an access takes two bytes. Key, step and flags in full would take 16.
 */
#define PAGE_TRACE_MAGIC "furrowPT"
#define PAGE_TRACE_VERSION 1
#define PAGE_TRACE_HEADER 12   /* bytes */
#define PAGE_TRACE_KEY_BITS 62 /* tile_key's */

enum page_access { PAGE_ACCESS_PIN, PAGE_ACCESS_DRAW, PAGE_ACCESS_KINDS };
struct page_trace;

/* Begins a trace. STATUS_FAILED if `path` cannot be written, or is an existing file that is not a trace. */
enum status page_trace_create(const char *path, struct page_trace **out) FURROW_CHECKED;
/* Adds an access to the trace. `step` must not decrease; `key` is below 2^62; `resident`: the cache had the page. After a
 * failure it adds nothing more, and page_trace_status returns the failure. trace may be NULL. */
void page_trace_access(struct page_trace *trace, uint64_t step, uint64_t key, enum page_access kind,
		       bool resident);
/* Returns the first failure so far. trace may be NULL. */
enum status page_trace_status(const struct page_trace *trace) FURROW_CHECKED;
/* Returns the path that the trace gets. trace may be NULL; then NULL. */
const char *page_trace_path(const struct page_trace *trace);
/* Completes the trace and renames it to its path. Add no access afterwards. trace may be NULL. */
enum status page_trace_publish(struct page_trace *trace) FURROW_CHECKED;
/* Frees the trace, and removes its file unless it was published. trace may be NULL. */
void page_trace_destroy(struct page_trace *trace);

#endif
