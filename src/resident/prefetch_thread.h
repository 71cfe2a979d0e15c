/*
 * One thread of a prefetcher. It loads tiles of the ground before its bodies, and the camera that follows one, need them. It also loads
 * ranges that pictures lack. Functions are as those of resident/prefetcher.h.
 */
#ifndef FURROW_RESIDENT_PREFETCH_THREAD_H
#define FURROW_RESIDENT_PREFETCH_THREAD_H

#include "resident/inset_areas.h"
#include "resident/prefetcher.h"

#define PREFETCH_THREAD "furrow-ahead"

struct prefetch_thread;

/* Makes what the thread needs. `params`: its bodies, which are copied, and tiles are its own share. Ignores params->threads.
 * `insets` must stay valid longer than the thread. */
enum status resident_prefetch_thread_create(const struct look_ahead_params *params, const struct inset_areas *insets, struct prefetch_thread **out)
	FURROW_CHECKED;
/* Starts it, once all `count` threads of the prefetcher are made; `all` must stay valid until they are stopped. */
enum status resident_prefetch_thread_start(struct prefetch_thread *ahead, struct prefetch_thread *const *all, size_t count) FURROW_CHECKED;
void resident_prefetch_thread_stop(struct prefetch_thread *ahead); /* it may not have been started */
/* Frees it, once all threads of the prefetcher are stopped. */
void resident_prefetch_thread_destroy(struct prefetch_thread *ahead); /* ahead may be NULL */
void resident_prefetch_thread_reach(struct prefetch_thread *ahead, double seconds);
void resident_prefetch_thread_tell(struct prefetch_thread *ahead, double time);
void resident_prefetch_thread_ranges(struct prefetch_thread *ahead, const struct ground_range_key *keys, size_t count);
uint64_t resident_prefetch_thread_ranges_done(struct prefetch_thread *ahead);
void resident_prefetch_thread_wait(struct prefetch_thread *ahead);

#endif
