/*
 * What has bitten other caches, by name:
 *
 *     a late load overwrites a newer page                  here
 *     the cleaner clears a page dirtied since its copy     here
 *     a load races its own eviction                        here
 *     a coarser level goes stale after an edit             tests/resident/coarser.c, tests/store/commits.c
 *     a tile's min and max go stale after an edit          tests/store/ranges.c, tests/render/view.c
 *     a budget below the visible set spins                 tests/render/view.c, tests/page/prefetch.c
 */
#include "page/fake.h"

#include "page/page_internal.h"
#include "../support/program.h"

/* --- a late load overwrites a newer page --- */

/* A load that got a queued image keeps it, though it is committed and its memory wanted. */
static void page_late_load_overwrites_no_newer_page(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 2);
	(void)state;
	params.queue_soft = 1;
	fake_start(&fake, &params);
	fake_change(&fake, 0);
	fake_push_out(&fake, 4, 10);
	fake_gate(&fake, 0 + 1, true);
	fake_end_step(&fake, 0);
	uint64_t record = 1;
	fake_want(&fake, 0);
	fake_await(&fake, 6, 1); /* both are held; the load reads what the commit writes */
	fake_gate(&fake, 0 + 1, false);
	assert_int_equal(page_cache_flush(fake.cache, &record), STATUS_OK);
	for (uint64_t key = 30; key < 60; key++)
		fake_change(&fake, key);
	assert_int_equal(page_cache_flush(fake.cache, &record), STATUS_OK);
	fake_gate(&fake, 0, false);
	fake_visit(&fake, 0);
	fake_flush(&fake, 2);
	fake_finish(&fake);
}

static void page_committed_image_is_visible_to_loads_that_began_before(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 2);
	(void)state;
	params.queue_soft = 1;
	fake_start(&fake, &params);
	fake_gate(&fake, COARSE + 1, false);
	fake_want(&fake, COARSE); /* has read 0 from the store, and is held */
	fake_await(&fake, 1, 0);
	fake_change(&fake, 0);
	fake_flush(&fake, 1);
	assert_int_equal(fake_queued(&fake, 0).count, 1); /* it may have missed this */
	fake_gate(&fake, COARSE + 1 + 1, false);
	page_cache_want(fake.cache, (const uint64_t[]){COARSE, COARSE + 1}, 2); /* this one cannot have */
	fake_await(&fake, 3, 0);
	uint32_t slot = fake_pin(&fake, COARSE);
	assert_int_equal(fake.slots[slot].family[0], 101);
	assert_int_equal(fake_queued(&fake, 0).count, 0); /* though the other one is on its way */
	fake_unpin(&fake, COARSE);
	fake_gate(&fake, 0, false);
	fake_visit(&fake, COARSE + 1);
	fake_change(&fake, 0);
	fake_flush(&fake, 2);
	assert_int_equal(fake_queued(&fake, 0).count, 0); /* no load on its way at all */
	fake_finish(&fake);
}

/* What would make the cache keep more than one epoch is loaded again instead. */
static void page_load_that_outlives_two_epochs_is_repeated(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 8, 2);
	struct fake_opener opener;
	(void)state;
	fake_start(&fake, &params);
	fake_gate(&fake, COARSE + 1, false);
	fake_want(&fake, COARSE);
	fake_await(&fake, 1, 0);
	for (uint64_t round = 1; round < 20; round++) {
		for (uint64_t i = 0; i < 5; i++)
			fake_change(&fake, (round - 1) * 5 + i);
		fake_flush(&fake, round);
	}
	assert_true(fake_stats(&fake).queue_peak <= 2 * 5);
	fake_open_later(&opener, &fake, 6, 0);
	uint32_t slot = fake_pin(&fake, COARSE);
	thread_join(&opener.thread);
	for (unsigned i = 0; i < FAMILY; i++)
		assert_int_equal(fake.slots[slot].family[i], fake.model[i]);
	assert_int_equal(fake_queued(&fake, 0).count, 0);
	fake_finish(&fake);
}

/* --- the cleaner clears a page dirtied since its copy --- */

static void page_dirtied_while_being_committed_is_committed_again(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	(void)state;
	params.queue_soft = 0;
	fake_start(&fake, &params);
	fake_gate(&fake, 0, true);
	fake_change(&fake, 0);
	fake_end_step(&fake, 1);
	fake_await(&fake, 0, 1);
	fake_change(&fake, 0); /* still resident, and dirty again */
	fake_gate(&fake, 0, false);
	fake_flush(&fake, 2);
	assert_int_equal(fake_stored(&fake, 0), 102);
	assert_int_equal(fake_stats(&fake).writebacks, 2);
	fake_flush(&fake, 3); /* clean now: the record alone */
	assert_int_equal(fake_stats(&fake).writebacks, 2);
	assert_int_equal(fake_stats(&fake).commits, 3);
	fake_finish(&fake);
}

/* The copy itself takes its time: what it has is the page at the step's end, and the page stays dirty. */
static void page_dirtied_while_it_is_copied_is_committed_again(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	(void)state;
	params.queue_soft = 0;
	fake_start(&fake, &params);
	fake.settle_after = 3;
	fake_change(&fake, 0);
	fake_end_step(&fake, 1);
	assert_int_equal(fake.cache->queue.filling, 1);
	fake_change(&fake, 0);
	while (fake_stats(&fake).commits == 0) {
		assert_int_equal(page_cache_poll(fake.cache), STATUS_OK);
		sched_yield();
	}
	assert_int_equal(fake_stored(&fake, 0), 101);
	fake.settle_after = 0;
	fake_push_out(&fake, 4, 10); /* so it cannot be forgotten either */
	assert_int_equal(fake_queued(&fake, 0).version, 102);
	fake_flush(&fake, 2);
	assert_int_equal(fake_stats(&fake).writebacks, 2);
	fake_finish(&fake);
}

/* What goes with an epoch beside its pages is as the step left it, and no commit begins before it is there. */
static void page_snapshot_is_of_the_step_that_is_committed(void **state)
{
	(void)state;
	for (int dirty = 0; dirty < 2; dirty++) {
		static struct fake fake;
		struct page_params params = fake_params(&fake, 4, 1);
		params.queue_soft = 0;
		params.executor.snapshot = fake_snapshot;
		fake_start(&fake, &params);
		fake.settle_after = 3;
		for (uint64_t step = 1; step <= 3; step++) {
			uint64_t commits = fake_stats(&fake).commits;
			if (dirty)
				fake_change(&fake, 0);
			fake_end_step(&fake, step);
			assert_int_equal(fake.cache->queue.filling, 1 + dirty);
			mutex_lock(&fake.mutex);
			assert_int_equal(fake.commits_begun, commits);
			mutex_unlock(&fake.mutex);
			if (dirty) /* the steps go on meanwhile */
				fake_change(&fake, 0);
			while (fake_stats(&fake).commits == commits) {
				assert_int_equal(page_cache_poll(fake.cache), STATUS_OK);
				sched_yield();
			}
			mutex_lock(&fake.mutex);
			assert_false(fake.commit_differs);
			mutex_unlock(&fake.mutex);
		}
		fake_flush(&fake, 4);
		assert_int_equal(fake_sum(fake.store), fake_sum(fake.model));
		fake_finish(&fake);
	}
}

static void page_snapshot_that_fails_is_sticky(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	const uint64_t record = 1;
	uint32_t slot;
	(void)state;
	params.queue_soft = 0;
	params.executor.snapshot = fake_snapshot;
	fake_start(&fake, &params);
	fake_change(&fake, 0);
	fake.fail_snapshot = true;
	assert_int_equal(page_cache_end_step(fake.cache, &record), STATUS_NO_GL);
	fake.fail_snapshot = false;
	assert_int_equal(page_cache_end_step(fake.cache, &record), STATUS_NO_GL);
	assert_int_equal(page_cache_pin(fake.cache, 1, &slot), STATUS_NO_GL);
	assert_int_equal(fake.commits_begun, 0);
	fake_finish(&fake);
}

/* --- a load races its own eviction --- */

/* Evicted, and wanted again before the executor has copied it: no load begins until it has. */
static void page_evicted_and_wanted_at_once_is_read_from_its_copy(void **state)
{
	(void)state;
	for (uint32_t loaders = 0; loaders < 3; loaders++)
		for (int requested = 0; requested < 2 && (requested == 0 || loaders > 0); requested++) {
			static struct fake fake;
			struct page_params params = fake_params(&fake, 4, loaders);
			fake_start(&fake, &params);
			fake_change(&fake, 0);
			fake_push_out(&fake, 3, 10);
			fake.settle_after = 6;
			fake_visit(&fake, 20); /* in its slot */
			assert_false(fake_resident(&fake, 0));
			assert_int_equal(fake.cache->queue.filling, 1);
			assert_int_equal(fake_queued(&fake, 0).count, 0); /* not shown: it is rubbish yet */
			unsigned loads = fake.loads_begun;
			fake_end_step(&fake, 1);
			if (requested) {
				fake_want(&fake, 0);
				for (int i = 0; i < 1000; i++)
					sched_yield();
				mutex_lock(&fake.mutex);
				assert_int_equal(fake.loads_begun, loads);
				mutex_unlock(&fake.mutex);
				while (!fake_resident(&fake, 0))
					assert_int_equal(page_cache_poll(fake.cache), STATUS_OK);
			}
			fake_change(&fake, 0);
			fake_flush(&fake, 2);
			assert_int_equal(fake_stored(&fake, 0), 102);
			fake_finish(&fake);
		}
}

/* Opens the gates when the owner has to wait. */
static void *open_when_stalled(void *argument)
{
	struct fake *fake = argument;
	for (bool stalled = false; !stalled; sched_yield()) {
		mutex_lock(&fake->cache->mutex);
		stalled = fake->cache->stats.stalls > 0;
		mutex_unlock(&fake->cache->mutex);
	}
	fake_gate(fake, 0, false);
	return NULL;
}

/* Wished for, given up, changed below, and pinned while the first load still runs: that one is dropped
 * when it comes, however soon it is wished for again, and the pin has a load of its own. */
static void page_pinned_while_its_given_up_load_runs_is_loaded_again(void **state)
{
	(void)state;
	for (int again = 0; again < 2; again++) {
		static struct fake fake;
		struct page_params params = fake_params(&fake, 8, 2);
		struct thread opener;
		fake_start(&fake, &params);
		fake_gate(&fake, COARSE + 1, false);
		fake_want(&fake, COARSE);
		fake_await(&fake, 1, 0); /* it has read the family as it was */
		page_cache_want(fake.cache, NULL, 0);
		fake_change(&fake, 0);
		fake_flush(&fake, 1);
		assert_int_equal(fake_queued(&fake, 0).count, 0); /* nothing is kept for it */
		if (again) {
			fake_want(&fake, COARSE);
			assert_int_equal(page_cache_request_state(fake.cache), PAGE_REQUESTS_SHORT);
		}
		unsigned loads = fake.loads_begun;
		mutex_lock(&fake.cache->mutex);
		fake.cache->stats.stalls = 0;
		mutex_unlock(&fake.cache->mutex);
		assert_int_equal(thread_start(&opener, open_when_stalled, &fake, "opener"), STATUS_OK);
		uint32_t slot = fake_pin(&fake, COARSE);
		thread_join(&opener);
		for (unsigned i = 0; i < FAMILY; i++)
			assert_int_equal(fake.slots[slot].family[i], fake.model[i]);
		assert_int_equal(fake.loads_begun, loads + 1);
		fake_unpin(&fake, COARSE);
		fake_finish(&fake);
	}
}

TEST_PROGRAM(hazards)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(page_late_load_overwrites_no_newer_page),
		cmocka_unit_test(page_committed_image_is_visible_to_loads_that_began_before),
		cmocka_unit_test(page_load_that_outlives_two_epochs_is_repeated),
		cmocka_unit_test(page_dirtied_while_being_committed_is_committed_again),
		cmocka_unit_test(page_dirtied_while_it_is_copied_is_committed_again),
		cmocka_unit_test(page_snapshot_is_of_the_step_that_is_committed),
		cmocka_unit_test(page_snapshot_that_fails_is_sticky),
		cmocka_unit_test(page_evicted_and_wanted_at_once_is_read_from_its_copy),
		cmocka_unit_test(page_pinned_while_its_given_up_load_runs_is_loaded_again),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
