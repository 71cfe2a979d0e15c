/* Write-back: the queue, epochs, and what a load sees of what is not committed. hazards.c goes on. */
#include "page/fake.h"
#include "../support/program.h"

static void page_reads_its_own_write_while_its_commit_is_blocked(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	(void)state;
	params.queue_soft = 1;
	fake_start(&fake, &params);
	fake_change(&fake, 0);
	fake_push_out(&fake, 4, 10);
	assert_int_equal(fake_queued(&fake, 0).count, 1);
	fake_visit(&fake, 0); /* waiting: the store still has 100 */
	fake_gate(&fake, 0, true);
	fake_end_step(&fake, 1);
	fake_await(&fake, 0, 1);
	fake_push_out(&fake, 4, 20);
	fake_visit(&fake, 0); /* committing */
	fake_change(&fake, 0);
	fake_push_out(&fake, 4, 10);
	assert_int_equal(fake_queued(&fake, 0).count, 2);
	assert_int_equal(fake_queued(&fake, 0).version, 102); /* oldest first */
	fake_visit(&fake, 0); /* committing and a newer one waiting */
	assert_int_equal(fake_stored(&fake, 0), 100);
	fake_gate(&fake, 0, false);
	fake_flush(&fake, 2);
	fake_finish(&fake);
}

static void page_evicted_in_a_step_is_committed_with_the_rest_of_it(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	(void)state;
	params.queue_soft = 2;
	fake_start(&fake, &params);
	for (uint64_t key = 0; key < 8; key++) /* 4 of them are pushed out, past queue_soft */
		fake_change(&fake, key);
	assert_int_equal(fake.read_backs, 4);
	assert_int_equal(fake_stats(&fake).commits, 0);
	assert_int_equal(fake.commits_begun, 0);
	fake_gate(&fake, 0, true);
	fake_end_step(&fake, 1);
	fake_await(&fake, 0, 1);
	assert_int_equal(fake.read_backs, 8);
	fake_gate(&fake, 0, false);
	fake_flush(&fake, 2);
	struct page_stats stats = fake_stats(&fake);
	assert_int_equal(stats.writebacks, 8);
	assert_int_equal(stats.queue_peak, 8);
	fake_finish(&fake);
}

static void page_newer_version_replaces_the_one_that_waits(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	(void)state;
	fake_start(&fake, &params);
	for (int i = 0; i < 20; i++) {
		fake_change(&fake, 0);
		fake_push_out(&fake, 4, 10);
		assert_int_equal(fake_queued(&fake, 0).count, 1);
		fake_end_step(&fake, 1);
	}
	assert_int_equal(fake_stats(&fake).queue_peak, 2); /* the newer is there before the older goes */
	fake_flush(&fake, 2);
	assert_int_equal(fake_stats(&fake).writebacks, 1);
	fake_finish(&fake);
}

/* A step that changes more than the queue was made for. */
static void page_queue_full_in_a_step_is_refused_and_nothing_lost(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 2);
	uint64_t record = 1;
	uint32_t slot;
	(void)state;
	params.queue_soft = 2;
	params.queue_most = 3;
	fake_start(&fake, &params);
	for (uint64_t key = 0; key < 7; key++)
		fake_change(&fake, key);
	assert_int_equal(page_cache_pin(fake.cache, 7, &slot), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "raise cache.slots"));
	fake_visit(&fake, 6); /* not sticky: what is resident can be used */
	assert_int_equal(page_cache_end_step(fake.cache, &record), STATUS_FAILED);
	assert_int_equal(fake.commits_begun, 0);
	fake_check_nothing_is_lost(&fake);
	fake_finish(&fake);
}

/* However fast things change, at most so much waits: the step's end waits for the commit instead. */
static void page_many_changes_wait_for_the_commit_in_flight(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	struct fake_opener opener;
	(void)state;
	params.queue_soft = 3;
	params.queue_most = PAGE_QUEUE_MOST(3, 7);
	fake_start(&fake, &params);
	for (uint64_t key = 0; key < 7; key++)
		fake_change(&fake, key);
	fake_gate(&fake, 0, true);
	fake_end_step(&fake, 1);
	fake_await(&fake, 0, 1);
	for (uint64_t key = 10; key < 15; key++)
		fake_change(&fake, key);
	fake_end_step(&fake, 2); /* five: it goes on, or nobody would ever open the gate */
	fake_change(&fake, 15);
	uint64_t stalls = fake_stats(&fake).stalls;
	fake_open_later(&opener, &fake, 0, 1);
	fake_end_step(&fake, 3);
	thread_join(&opener.thread);
	assert_in_range(fake_stats(&fake).commits, 1, 2);
	assert_in_range(fake_stats(&fake).stalls, stalls, stalls + 1);
	assert_true(fake_stats(&fake).queue_peak <= 7 + 6);
	fake_flush(&fake, 2);
	assert_int_equal(fake_stats(&fake).writebacks, 13);
	fake_finish(&fake);
}

/* Evictions wait for the commit in flight before they make more images than are usual. */
static void page_evictions_wait_for_images_of_the_commit_in_flight(void **state)
{
	enum { PAGES = 12, SLOTS = 2, FEW = 16 };
	static const uint32_t fews[] = {0, FEW};
	uint32_t peaks[2];
	(void)state;
	for (int i = 0; i < 2; i++) {
		static struct fake fake;
		struct page_params params = fake_params(&fake, SLOTS, 1);
		struct fake_opener opener;
		params.queue_soft = 100; /* no commit but this */
		params.queue_most = PAGE_QUEUE_MOST(100, PAGES);
		params.queue_few = fews[i];
		params.commit_age = 1e-9;
		fake_start(&fake, &params);
		for (uint64_t key = 0; key < PAGES; key++)
			fake_change(&fake, key);
		fake_gate(&fake, 0, true);
		fake_end_step(&fake, 1);
		fake_await(&fake, 0, 1);
		uint64_t stalls = fake_stats(&fake).stalls;
		if (fews[i] > 0)
			fake_open_later(&opener, &fake, 0, 1);
		for (uint64_t key = 0; key < PAGES; key++)
			fake_change(&fake, key);
		if (fews[i] > 0)
			thread_join(&opener.thread);
		else
			fake_gate(&fake, 0, false);
		peaks[i] = fake_stats(&fake).queue_peak;
		assert_true(i == 0 || fake_stats(&fake).stalls > stalls);
		fake_flush(&fake, 2);
		fake_check_nothing_is_lost(&fake);
		fake_finish(&fake);
	}
	assert_true(peaks[0] > FEW);
	assert_true(peaks[1] <= FEW);
}

/* --- an executor that takes its time --- */

/* Evicted and wanted again at once: the load waits until the read-back is there. */
static void page_wanted_while_it_is_read_back_waits_for_that(void **state)
{
	static struct fake fake;
	(void)state;
	for (uint32_t loaders = 0; loaders < 3; loaders++) {
		struct page_params params = fake_params(&fake, 4, loaders);
		fake_start(&fake, &params);
		fake.settle_after = 5;
		for (int i = 0; i < 20; i++) {
			fake_change(&fake, 0);
			fake_push_out(&fake, 4, 10 + 4 * (uint64_t)(i % 2));
		}
		fake_flush(&fake, 1);
		fake_finish(&fake);
	}
}

/* An epoch is handed over when the last of its read-backs is there, and not before. */
static void page_epoch_waits_for_its_read_backs_without_stopping_the_steps(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 8, 1);
	(void)state;
	params.queue_soft = 4;
	fake_start(&fake, &params);
	fake.settle_after = 3;
	for (uint64_t key = 0; key < 5; key++)
		fake_change(&fake, key);
	uint64_t stalls = fake_stats(&fake).stalls;
	fake_end_step(&fake, 1); /* asks once */
	unsigned polls = 0;
	for (; fake_stats(&fake).commits == 0 && polls < 1000000; polls++) {
		if (polls == 0)
			assert_int_equal(fake.commits_begun, 0);
		assert_int_equal(page_cache_poll(fake.cache), STATUS_OK);
		sched_yield();
	}
	assert_true(polls >= 3 && polls < 1000000);
	assert_int_equal(fake_stats(&fake).stalls, stalls);
	fake_flush(&fake, 2);
	fake_finish(&fake);
}

/* A coarse page shows what was evicted just before it came, though that is still being read back. */
static void page_overlay_waits_for_read_backs(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	(void)state;
	fake_start(&fake, &params);
	fake.settle_after = 4;
	for (uint64_t key = 0; key < FAMILY; key++)
		fake_change(&fake, key);
	uint32_t slot = fake_pin(&fake, COARSE); /* takes the slot of 0 */
	for (unsigned i = 0; i < FAMILY; i++)
		assert_int_equal(fake.slots[slot].family[i], fake.model[i]);
	fake_unpin(&fake, COARSE);
	fake_change(&fake, 4);
	fake_end_step(&fake, 1);
	fake_want(&fake, COARSE + 1); /* ahead: installed later, and whole as well */
	fake_await(&fake, FAMILY + 3, 0);
	fake_change(&fake, 5);
	fake_change(&fake, 6);
	fake_change(&fake, 7);
	fake_end_step(&fake, 2);
	while (!page_cache_peek(fake.cache, COARSE + 1, false, &slot))
		assert_int_equal(page_cache_poll(fake.cache), STATUS_OK);
	for (unsigned i = 0; i < FAMILY; i++)
		assert_int_equal(fake.slots[slot].family[i], fake.model[FAMILY + i]);
	fake_flush(&fake, 3);
	fake_finish(&fake);
}

/* A pin that has to wait for read-backs sleeps, and says that it waited: here once more than for its load. */
static void page_pin_that_waits_for_read_backs_is_a_stall(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 0);
	(void)state;
	fake_start(&fake, &params);
	for (uint64_t key = 0; key < FAMILY; key++)
		fake_change(&fake, key);
	fake.settle_after = 5;
	uint64_t stalls = fake_stats(&fake).stalls;
	fake_visit(&fake, COARSE);
	assert_int_equal(fake_stats(&fake).stalls, stalls + 2);
	fake_flush(&fake, 1);
	fake_finish(&fake);
}

/* What an executor that failed has read is not committed. */
static void page_read_back_that_never_settles_is_not_committed(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	uint64_t record = 1;
	(void)state;
	params.queue_soft = 0;
	fake_start(&fake, &params);
	fake.settle_after = 1;
	fake_change(&fake, 0);
	fake.fail_settle = true;
	assert_int_equal(page_cache_end_step(fake.cache, &record), STATUS_NO_GL);
	assert_int_equal(page_cache_poll(fake.cache), STATUS_NO_GL);
	assert_int_equal(page_cache_flush(fake.cache, &record), STATUS_NO_GL);
	assert_int_equal(fake.commits_begun, 0);
	assert_int_equal(fake_stored(&fake, 0), 100);
	fake_finish(&fake);
}

static void page_failed_commit_is_sticky_and_keeps_every_image(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	uint64_t record = 1;
	uint32_t slot;
	(void)state;
	fake_start(&fake, &params);
	for (uint64_t key = 0; key < 6; key++)
		fake_change(&fake, key);
	fake.fail_commits = 1;
	for (int i = 0; i < 3; i++) {
		fail_with(STATUS_USAGE, "another");
		assert_int_equal(page_cache_flush(fake.cache, &record), STATUS_FAILED);
		assert_string_equal(failure_message(), "store: disk is full; free some space");
		fail_with(STATUS_USAGE, "another");
		assert_int_equal(page_cache_end_step(fake.cache, &record), STATUS_FAILED);
		assert_string_equal(failure_message(), "store: disk is full; free some space");
		fail_with(STATUS_USAGE, "another");
		assert_int_equal(page_cache_pin(fake.cache, 5, &slot), STATUS_FAILED);
		assert_string_equal(failure_message(), "store: disk is full; free some space");
		assert_int_equal(page_cache_poll(fake.cache), STATUS_FAILED);
	}
	assert_int_equal(fake.commits_begun, 1);
	for (uint64_t key = 0; key < 6; key++) {
		assert_int_equal(fake_queued(&fake, key).count, 1);
		assert_int_equal(fake_queued(&fake, key).version, fake.model[key]);
	}
	fake_finish(&fake);
}

/* Changed again while its commit is about to fail: the newer version stays, in any order. */
static void page_failed_commit_does_not_bring_older_bits_back(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	uint64_t record = 2;
	(void)state;
	params.queue_soft = 0;
	fake_start(&fake, &params);
	fake.fail_commits = 1;
	fake_gate(&fake, 0, true);
	fake_change(&fake, 0);
	fake_change(&fake, 1);
	fake_end_step(&fake, 1);
	fake_await(&fake, 0, 1);
	fake_change(&fake, 0);
	fake_push_out(&fake, 4, 10);
	fake_gate(&fake, 0, false);
	assert_int_equal(page_cache_flush(fake.cache, &record), STATUS_FAILED);
	assert_int_equal(fake_queued(&fake, 0).count, 1);
	assert_int_equal(fake_queued(&fake, 0).version, 102);
	assert_int_equal(fake_queued(&fake, 1).version, 101);
	fake_finish(&fake);
}

static void page_failed_read_back_is_sticky_and_stays_dirty(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 2, 1);
	uint64_t record = 1;
	uint32_t slot;
	(void)state;
	fake_start(&fake, &params);
	fake_change(&fake, 0);
	fake_change(&fake, 1);
	fake.fail_read_back = 0 + 1;
	assert_int_equal(page_cache_pin(fake.cache, 2, &slot), STATUS_NO_GL);
	fake.fail_read_back = 0;
	assert_int_equal(page_cache_pin(fake.cache, 2, &slot), STATUS_NO_GL);
	assert_int_equal(page_cache_flush(fake.cache, &record), STATUS_NO_GL);
	assert_true(fake_resident(&fake, 0));
	assert_true(fake_resident(&fake, 1));
	fake_finish(&fake);
}

static void page_old_change_starts_an_epoch_and_a_young_one_does_not(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	(void)state;
	for (int old = 0; old < 2; old++) {
		params.commit_age = old ? 1e-12 : 1e9;
		fake_start(&fake, &params);
		fake_end_step(&fake, 0); /* nothing changed: no epoch, however old */
		fake_change(&fake, 0);
		fake_end_step(&fake, 1);
		if (old)
			fake_await(&fake, 0, 1);
		assert_int_equal(fake.read_backs, old);
		fake_flush(&fake, 2);
		assert_int_equal(fake_stats(&fake).commits, 1 + old);
		fake_finish(&fake);
	}
}

TEST_PROGRAM(write_back)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(page_reads_its_own_write_while_its_commit_is_blocked),
		cmocka_unit_test(page_evicted_in_a_step_is_committed_with_the_rest_of_it),
		cmocka_unit_test(page_newer_version_replaces_the_one_that_waits),
		cmocka_unit_test(page_queue_full_in_a_step_is_refused_and_nothing_lost),
		cmocka_unit_test(page_many_changes_wait_for_the_commit_in_flight),
		cmocka_unit_test(page_evictions_wait_for_images_of_the_commit_in_flight),
		cmocka_unit_test(page_wanted_while_it_is_read_back_waits_for_that),
		cmocka_unit_test(page_epoch_waits_for_its_read_backs_without_stopping_the_steps),
		cmocka_unit_test(page_overlay_waits_for_read_backs),
		cmocka_unit_test(page_pin_that_waits_for_read_backs_is_a_stall),
		cmocka_unit_test(page_read_back_that_never_settles_is_not_committed),
		cmocka_unit_test(page_failed_commit_is_sticky_and_keeps_every_image),
		cmocka_unit_test(page_failed_commit_does_not_bring_older_bits_back),
		cmocka_unit_test(page_failed_read_back_is_sticky_and_stays_dirty),
		cmocka_unit_test(page_old_change_starts_an_epoch_and_a_young_one_does_not),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
