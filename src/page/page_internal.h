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
#define PAGE_FLIGHTS_PER_LOADER 3
#define PAGE_REQUESTS_PER_LOADER 2

enum page_image_place { PAGE_UNQUEUED, PAGE_KEPT, PAGE_COMMITTING, PAGE_WAITING };

/* A page's image in CPU memory. The queue finds it by key. refs counts its users. At 0 it goes back to the list of unused
 * images. */
struct page_host {
	struct page_image image;
	enum page_image_kind kind;
	enum page_image_place place;
	bool filling;           /* a read-back into this image is not finished */
	uint32_t refs;          /* users: its list or the thread that fills it, each reader, and `busy` */
	uint64_t kept_until;    /* KEPT: the image is kept for loads whose `begun` is at most this number */
	struct failure failure; /* LOADED: the result of io.load */
	struct page_host *prev, *next, *hash_next;
	struct page_host *visit_next; /* used by the owner in page_cache_each_queued */
	struct page_host *busy_next;  /* next in struct page_busy; used by the owner */
};

struct page_host_list {
	struct page_host *first, *last; /* oldest first */
	uint32_t count;
};

enum page_state { PAGE_WANTED, PAGE_LOADING, PAGE_LOADED, PAGE_RESIDENT };

struct page {
	uint64_t key;
	enum page_state state;
	bool urgent; /* not RESIDENT yet, and a pin waits for it */
	bool stale;  /* LOADING: drop the page when its load ends */
	bool dirty;
	uint32_t slot, pins;
	uint64_t used_in;       /* number of the last step in which it was pinned or drawn */
	/* number of the last list of prefetch requests with this page; requested_at: its index in that list */
	uint64_t requested_in;
	size_t requested_at;
	uint64_t polled;        /* LOADED: number of the last poll that could not make it resident */
	uint64_t begun;         /* LOADING, LOADED: value of load_clock when its load began */
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
	struct page *pages, *unused; /* pages: all page structs; unused: the free ones, linked by hash_next */
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
	struct page_host *unused[PAGE_IMAGE_KINDS]; /* images that nobody uses, by kind, linked by `next` */
	uint32_t unused_count[PAGE_IMAGE_KINDS];
	uint32_t made[PAGE_IMAGE_KINDS];
	uint32_t filling;            /* images with a read-back that is not settled */
	uint32_t commit_filling;      /* images in `committing` with a read-back that is not settled */
};

/* Images whose transfers the executor has begun and that are not settled, oldest first. Used by the owner. */
struct page_busy {
	struct page_host *first, *last;
};

enum page_commit {
	PAGE_COMMIT_NONE,
	PAGE_COMMIT_FILLING,    /* begun; some read-backs of its images are not settled */
	PAGE_COMMIT_WRITING, /* the writer thread is committing */
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
	bool held;             /* the end of a step begins no commit */
	struct page_table table;
	struct page_queue queue;
	struct key_set touched; /* the keys that were ever pinned */
	uint64_t load_clock; /* number of loads begun so far */
	uint64_t step;       /* number of steps begun so far; `used_in` of a page that was never used is 0 */
	uint64_t request_list;  /* number of lists of prefetch requests so far */
	bool requests_kept;    /* since the last list, no page of it was evicted or left out */
	uint64_t polls;
	struct page_busy busy;
	enum page_commit commit;
	const struct page_image **commit_images; /* room for queue_most */
	void *commit_record;
	struct page_host *commit_snapshot; /* the only image for snapshots, in no list; NULL: there is none */
	double dirty_since;     /* clock_seconds of the oldest change that no commit contains yet; 0: there is none */
	double commit_took;     /* s that the last commit took the writer */
	_Atomic bool giving_up; /* a rollback waits for the commit in flight, which may stop early */
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

/* Only for assert: checks the invariants above as far as this is possible without calling the executor. */
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

/* Waits until no commit is in flight. `stall`: a step waits, so it counts as a stall. Returns early with a failure of the
 * threads. */
enum status page_wait_for_commit_locked(struct page_cache *cache, bool stall) FURROW_CHECKED;
bool page_commit_is_due_locked(const struct page_cache *cache);
/* Begins a commit, after the one in flight. */
enum status page_start_commit(struct page_cache *cache, const void *record, bool stall) FURROW_CHECKED;

/* --- page_queue.c --- */

enum status page_queue_init(struct page_queue *queue,
			    const struct page_params *params) FURROW_CHECKED;
void page_queue_finish(struct page_cache *cache);
/* Makes one more image of this kind, unused. On the owner's thread. */
enum status page_host_make(struct page_cache *cache, enum page_image_kind kind) FURROW_CHECKED;
/* Takes an unused image and sets refs to 1. Returns NULL if there is none. */
struct page_host *page_host_acquire_locked(struct page_cache *cache, enum page_image_kind kind,
					   uint64_t key);
void page_host_release_locked(struct page_cache *cache, struct page_host *host);
struct page_host *page_queue_find_locked(const struct page_queue *queue, uint64_t key,
					 enum page_image_place place);
/* Returns the newest queued version of a page, which may not be in the store yet. Returns NULL if there is none. */
struct page_host *page_queue_newest_locked(const struct page_queue *queue, uint64_t key);
/* Puts an image into the queue; the queue takes over the caller's reference. An older waiting version of the page is replaced. */
void page_queue_wait_locked(struct page_cache *cache, struct page_host *host);
void page_queue_begin_commit_locked(struct page_cache *cache);
void page_queue_end_commit_locked(struct page_cache *cache, bool committed);
/* Releases all waiting images without committing them. */
void page_queue_drop_waiting_locked(struct page_cache *cache);
void page_queue_drop_waiting_one_locked(struct page_cache *cache, uint64_t key); /* the same for one page, if it has one */
/* Releases the kept images that no running load needs: all running loads began after their commit. */
void page_queue_release_kept_locked(struct page_cache *cache);

/* --- page_busy.c: transfers that the executor has begun and that are not settled --- */

void page_busy_add_locked(struct page_cache *cache, struct page_host *host, bool filling);
/* Keeps a failure of the executor, so that it is sticky, and returns it. Call without the mutex. */
enum status page_executor_failed(struct page_cache *cache, enum status status) FURROW_CHECKED;
/* Releases images whose transfers are settled. Does not wait. Failures are sticky. */
enum status page_settle(struct page_cache *cache) FURROW_CHECKED;
/* Waits on the owner's thread until a thread or the executor may have made progress. Returns early with a sticky failure. */
enum status page_wait_locked(struct page_cache *cache) FURROW_CHECKED;
/* As page_wait_locked, but counts as a stall. `*stalled`: this stall was counted before, so only its time is added. */
enum status page_stall_locked(struct page_cache *cache, bool *stalled) FURROW_CHECKED;

/* --- page_newest.c --- */

/* Finds the newest queued image of a page, waits until it is filled, and adds a reference to it. *host is NULL if nothing is queued. The
 * caller releases it. */
enum status page_hold_newest(struct page_cache *cache, uint64_t key, struct page_host **host) FURROW_CHECKED;

/* --- page_loader.c --- */

void *page_loader_body(void *loader);
/* Takes the next page and loads it, with the mutex released meanwhile. Returns false if there is no page to take. */
bool page_load_next_locked(struct page_cache *cache, unsigned loader);
/* Adds a page with state WANTED. It must be ABSENT before. */
struct page *page_loads_want_locked(struct page_cache *cache, uint64_t key, bool urgent);
void page_loads_make_urgent_locked(struct page_cache *cache, struct page *page);
/* Drops a page that is not RESIDENT: at once, or if it is LOADING, when its load ends. */
void page_loads_abandon_locked(struct page_cache *cache, struct page *page);
/* Abandons the loads that need kept images, except loads that a pin waits for. So the kept images are released. */
void page_loads_abandon_late_locked(struct page_cache *cache);
/* Takes a LOADED page out of the list `flights`. If it has a slot now, it goes to the list of resident pages; otherwise it is
 * forgotten. */
void page_loads_land_locked(struct page_cache *cache, struct page *page, uint32_t slot);
/* Returns the number of running loads for prefetch requests. */
uint32_t page_loads_ahead_locked(const struct page_cache *cache);
/* Returns the `begun` of the oldest running load that may still become resident. Returns UINT64_MAX if there is none. */
uint64_t page_loads_oldest_locked(const struct page_cache *cache);

/* --- page_rollback.c --- */

/* Makes a RESIDENT page ABSENT. What only its slot has is lost. */
void page_drop_locked(struct page_cache *cache, struct page *page);

/* --- page_writer.c --- */

void *page_writer_body(void *cache);

/* --- page_evict.c: the owner's work list --- */

/* Begins to read a dirty page back. The page is clean then, and its image waits for a commit. If there is no free image, it
 * stays dirty; with `ahead` this is not a failure. A failure of the executor is sticky. */
enum status page_read_back(struct page_cache *cache, struct page *page, bool ahead) FURROW_CHECKED;
/* Takes an image for a changed page. STATUS_FAILED: the queue is full. */
enum status page_take_changed_image(struct page_cache *cache, uint64_t key, struct page_host **out) FURROW_CHECKED;
/* Makes a LOADED page RESIDENT, or ABSENT on failure. If the load of a prefetch request failed and no pin waits for it, this is
 * not a failure. `*later`: the page cannot be made resident yet. */
enum status page_install(struct page_cache *cache, struct page *page, bool *later) FURROW_CHECKED;

/* --- page_request.c --- */

/* Marks the page as the most recently used. */
void page_use_locked(struct page_cache *cache, struct page *page);
bool page_requested(const struct page_cache *cache, const struct page *page);

#endif
