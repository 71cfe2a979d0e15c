/*
 * page, inside: the structures that one mutex guards, and the invariants between its sections.
 *
 * The states of a page (a key that the cache knows; ABSENT means: no page) and of an image (host bytes):
 *
 *          want, pin            loader takes it      io.load returns        upload
 *     ABSENT ---------> WANTED ---------> LOADING ---------> LOADED ---------> RESIDENT
 *       ^                  |                 |                 |                  |
 *       +--- abandoned ----+-- once stale ---+---- failed -----+---- evicted -----+
 *                                                                                 | if dirty:
 *          +-- commit failed --+                                        read back |
 *          v                   |   commit returned   oldest load is newer         |
 *       waiting ------> committing --------> kept --------> unused       waiting <+
 *
 * A rollback makes dirty RESIDENT pages, and pages that changed, ABSENT. It makes waiting images unused.
 *
 * Invariants, which asserts name:
 *
 *   1. A page is in one list: resident, urgent or requested (WANTED), or flights (LOADING, LOADED).
 *   2. A page has a slot exactly when RESIDENT, and no slot has two pages.
 *   3. A pinned or dirty page is RESIDENT. While it is dirty its newest bits are in its slot.
 *   4. A key has at most one image waiting, one committing and one kept, each newer than the next.
 *   5. A commit takes every waiting image and every dirty page, between two steps; one at a time.
 *   6. A kept image is visible while a load is running that began before the commit returned. Without such a load
 *      nothing is kept.
 *   7. A page LOADING belongs to its loader. The owner only marks it urgent or stale. The loader drops a stale page. Every
 *      other page that it loaded belongs to the owner.
 *   8. Only the owner thread uses slots and dirty pages. So it may walk the resident list, and execute, without the mutex.
 *   9. At most three images a loader are in flight, and at most two of them for prefetch requests. So a pin is always
 *      served. A load needs no slot until it is uploaded.
 *  10. An image that the executor has begun to fill or to read is in `busy`, in the order begun. Until it is settled it
 *      is neither read nor used again. That is: no load of its key begins, and no commit with it is handed over. While an
 *      image is being filled, no page with `overlays` is uploaded.
 */
#ifndef FURROW_PAGE_INTERNAL_H
#define FURROW_PAGE_INTERNAL_H

#include "base/key_set.h"
#include "page/page.h"

#define PAGE_NO_SLOT UINT32_MAX
#define PAGE_PIN_MOST 64
#define PAGE_FLIGHTS_PER_LOADER 3
#define PAGE_REQUESTS_PER_LOADER 2

enum page_image_place { PAGE_UNQUEUED, PAGE_KEPT, PAGE_COMMITTING, PAGE_WAITING };

/* Host bytes. The queue finds them by key, and readers count references. With no `refs` they return to the pool. */
struct page_host {
	struct page_image image;
	enum page_image_kind kind;
	enum page_image_place place;
	bool filling;           /* a read-back into it is not settled */
	uint32_t refs;          /* 1 for its list or for who fills it, 1 for each reader, 1 for `busy` */
	uint64_t kept_until;    /* KEPT: for loads whose `begun` is at most this */
	struct failure failure; /* LOADED: what io.load returned */
	struct page_host *prev, *next, *hash_next;
	struct page_host *visit_next; /* the owner's, in page_cache_each_queued */
	struct page_host *busy_next;  /* the owner's */
};

struct page_host_list {
	struct page_host *first, *last; /* oldest first */
	uint32_t count;
};

enum page_state { PAGE_WANTED, PAGE_LOADING, PAGE_LOADED, PAGE_RESIDENT };

struct page {
	uint64_t key;
	enum page_state state;
	bool urgent; /* not RESIDENT: a pin waits for it */
	bool stale;  /* LOADING: drop it when it comes */
	bool dirty;
	uint32_t slot, pins;
	uint64_t used_in;       /* the last step it was pinned or drawn in */
	uint64_t requested_in;     /* number of the last request list that had it, and its place there */
	size_t requested_at;
	uint64_t polled;        /* LOADED: the last poll that could not make it resident */
	uint64_t begun;         /* LOADING, LOADED: the clock of loads when it was taken */
	struct page_host *host; /* LOADING, LOADED */
	struct page *prev, *next, *hash_next;
};

struct page_list {
	struct page *first, *last; /* oldest first */
	uint32_t count;
};

struct page_table {
	struct page **buckets;
	size_t mask;
	struct page *pages, *unused; /* all pages that can be known; unused ones are linked by hash_next */
	struct page_list resident;   /* in order of use */
	struct page_list urgent, requested, flights;
	uint32_t pinned; /* pages with a pin */
	uint32_t used;   /* resident pages used in this step */
	uint32_t dirty;
	uint32_t *free_slots, free_count;
};

struct page_queue {
	struct page_host **buckets;
	size_t mask;
	struct page_host_list waiting, committing, kept;
	struct page_host *unused[PAGE_IMAGE_KINDS]; /* by kind; by next */
	uint32_t made[PAGE_IMAGE_KINDS];
	uint32_t filling;            /* images with a read-back that is not settled */
	uint32_t commit_filling;      /* of those, committing */
};

/* The owner's: images that the executor is working on. */
struct page_busy {
	struct page_host *first, *last;
};

enum page_commit {
	PAGE_COMMIT_NONE,
	PAGE_COMMIT_FILLING,    /* begun; some of its read-backs are not settled */
	PAGE_COMMIT_WRITING, /* the writer's */
};

struct page_loader {
	struct page_cache *cache;
	unsigned number;
	struct thread thread;
};

struct page_cache {
	struct page_params params;
	pthread_t owner;
	struct mutex mutex;
	struct condition work; /* for loaders and writer: there is work, or they must stop */
	struct condition done; /* for the owner: a load or a commit has ended */
	bool stopping;
	struct page_table table;
	struct page_queue queue;
	struct key_set touched; /* the keys that were ever pinned */
	uint64_t load_clock; /* loads taken so far */
	uint64_t step;       /* steps begun so far: pages that were never used say 0 */
	uint64_t request_list;  /* lists so far */
	bool requests_kept;    /* no page of the last list was lost or left out since */
	uint64_t polls;
	struct page_busy busy;
	enum page_commit commit;
	const struct page_image **commit_images; /* room for queue_most */
	void *commit_record;
	struct page_host *commit_snapshot; /* the only one, always referenced, in no list; NULL: none */
	double dirty_since;     /* clock_seconds of the oldest change that is in no commit; 0: none */
	_Atomic bool giving_up; /* a rollback waits for the commit in flight, which need not be made */
	struct failure failure; /* sticky */
	struct page_stats stats;
	struct page_loader *loaders;
	struct thread writer;
};

static inline bool page_owner(const struct page_cache *cache)
{
	return pthread_equal(cache->owner, pthread_self()) != 0;
}

/* Returns the sticky failure, if there is one. Otherwise it leaves the thread's message unchanged. */
static inline enum status page_sticky_locked(const struct page_cache *cache)
{
	return cache->failure.status == STATUS_OK ? STATUS_OK : failure_restore(&cache->failure);
}

/* For assert only: checks all invariants above that can be seen without executing. */
bool page_cache_sane_locked(const struct page_cache *cache);

/* --- page_table.c --- */

enum status page_table_init(struct page_table *table,
			    const struct page_params *params) FURROW_CHECKED;
void page_table_finish(struct page_table *table);
struct page *page_table_find_locked(const struct page_table *table, uint64_t key);
struct page *page_table_add_locked(struct page_table *table, uint64_t key, struct page_list *list);
void page_table_forget_locked(struct page_table *table, struct page *page, struct page_list *list);
void page_list_append(struct page_list *list, struct page *page);
void page_list_remove(struct page_list *list, struct page *page);

/* --- page_cache.c --- */

/* Waits until no commit is in flight; this is a stall if a step waits. A failure of the threads ends the wait. */
enum status page_wait_for_commit_locked(struct page_cache *cache, bool stall) FURROW_CHECKED;

/* --- page_queue.c --- */

enum status page_queue_init(struct page_queue *queue,
			    const struct page_params *params) FURROW_CHECKED;
void page_queue_finish(struct page_cache *cache);
/* On the owner's thread: makes one more image of the kind, in the pool. */
enum status page_host_make(struct page_cache *cache, enum page_image_kind kind) FURROW_CHECKED;
/* Returns an image from the pool with one reference; NULL: the pool is empty. */
struct page_host *page_host_acquire_locked(struct page_cache *cache, enum page_image_kind kind,
					   uint64_t key);
void page_host_release_locked(struct page_cache *cache, struct page_host *host);
struct page_host *page_queue_find_locked(const struct page_queue *queue, uint64_t key,
					 enum page_image_place place);
/* Returns the newest version that the store may not have, or NULL. */
struct page_host *page_queue_newest_locked(const struct page_queue *queue, uint64_t key);
/* Puts an image into the queue, with the caller's reference. It replaces an older waiting version. */
void page_queue_wait_locked(struct page_cache *cache, struct page_host *host);
void page_queue_begin_commit_locked(struct page_cache *cache);
void page_queue_end_commit_locked(struct page_cache *cache, bool committed);
/* Releases all waiting images, though they were never committed. */
void page_queue_drop_waiting_locked(struct page_cache *cache);
/* Releases kept images that every running load is newer than. */
void page_queue_release_kept_locked(struct page_cache *cache);

/* --- page_busy.c: transfers that the executor has begun --- */

void page_busy_add_locked(struct page_cache *cache, struct page_host *host, bool filling);
/* Releases images whose transfers are settled. Does not wait. Failures are sticky. */
enum status page_settle(struct page_cache *cache) FURROW_CHECKED;
/* Waits on the owner's thread until a thread or the executor may have made progress. Sticky failures end it. */
enum status page_wait_locked(struct page_cache *cache) FURROW_CHECKED;
/* The same, counted as a stall. `*stalled` says whether this wait was counted before. */
enum status page_stall_locked(struct page_cache *cache, bool *stalled) FURROW_CHECKED;

/* --- page_loader.c --- */

void *page_loader_body(void *loader);
/* Takes the next page and loads it, with the mutex released meanwhile. Returns false if there is no page to take. */
bool page_load_next_locked(struct page_cache *cache, unsigned loader);
/* The page is ABSENT. */
struct page *page_loads_want_locked(struct page_cache *cache, uint64_t key, bool urgent);
void page_loads_make_urgent_locked(struct page_cache *cache, struct page *page);
/* Drops a page that is not RESIDENT: now, or when its load ends. */
void page_loads_abandon_locked(struct page_cache *cache, struct page *page);
/* Releases kept images by abandoning the loads that need them, except loads that a pin waits for. */
void page_loads_abandon_late_locked(struct page_cache *cache);
/* Takes a LOADED page out of the flights. It enters the LRU list if it has a slot now; otherwise it is forgotten. */
void page_loads_land_locked(struct page_cache *cache, struct page *page, uint32_t slot);
/* Running loads for prefetch requests. */
uint32_t page_loads_ahead_locked(const struct page_cache *cache);
/* Returns when the oldest load began that will become resident; UINT64_MAX: no load is running. */
uint64_t page_loads_oldest_locked(const struct page_cache *cache);

/* --- page_writer.c --- */

void *page_writer_body(void *cache);

/* --- page_evict.c: the owner's work list --- */

/* Begins to read a dirty page back. It is clean then, and its image waits. Without a free image it stays dirty, which is no
 * failure with `ahead`. A failure of the executor is sticky. */
enum status page_read_back(struct page_cache *cache, struct page *page, bool ahead) FURROW_CHECKED;
/* Makes a LOADED page RESIDENT, or on failure ABSENT. A requested page that is not urgent becomes ABSENT without a failure if
 * its load failed. `*later`: it cannot be made resident yet. */
enum status page_install(struct page_cache *cache, struct page *page, bool *later) FURROW_CHECKED;

/* --- page_request.c --- */

/* Marks the page as the most recently used. */
void page_use_locked(struct page_cache *cache, struct page *page);
bool page_requested(const struct page_cache *cache, const struct page *page);

#endif
