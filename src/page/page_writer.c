/*
 * The writer thread: makes the commits that the owner hands over, one at a time.
 *
 *     idle -> (page_queue_begin_commit_locked, all read-backs settled) -> io.commit -> idle
 *
 * While a commit is in flight, only the writer reads its images, their array, the record and the snapshot. Nobody writes them.
 * After a failed commit its images wait in the queue again. The images of a commit that was given up for a rollback do so too, and
 * the rollback drops them.
 */
#include "page/page_internal.h"

#include <assert.h>

void *page_writer_body(void *argument)
{
	struct page_cache *cache = argument;
	thread_background();
	mutex_lock(&cache->mutex);
	while (!cache->stopping) {
		if (cache->commit != PAGE_COMMIT_WRITING) {
			condition_wait(&cache->work, &cache->mutex);
			continue;
		}
		size_t count = 0;
		for (struct page_host *host = cache->queue.committing.first; host != NULL;
		     host = host->next)
			cache->commit_images[count++] = &host->image;
		mutex_unlock(&cache->mutex);
		const struct page_io *io = &cache->params.io;
		const double began = clock_seconds();
		enum status status =
			io->commit(io->user, cache->commit_images, count, cache->commit_record,
				   cache->commit_snapshot != NULL ? &cache->commit_snapshot->image : NULL);
		mutex_lock(&cache->mutex);
		cache->commit_took = clock_seconds() - began;
		if (status == STATUS_OK) {
			cache->stats.commits++;
			cache->stats.writebacks += count;
		} else if (status != STATUS_INTERRUPTED || !cache->giving_up) {
			failure_capture(&cache->failure, status);
		}
		page_queue_end_commit_locked(cache, status == STATUS_OK);
		cache->commit = PAGE_COMMIT_NONE;
		assert(page_cache_sane_locked(cache));
		condition_wake_all(&cache->done);
	}
	mutex_unlock(&cache->mutex);
	return NULL;
}
