/* Prefetching: it makes pins hits, and takes nothing from the step that runs. */
#include "page/fake.h"
#include "page/page_internal.h"
#include "../support/program.h"

/* Polls until a prefetched page is resident; its load must be on its way and not held. */
static void poll_until_resident(struct fake *fake, uint64_t key)
{
	while (!fake_resident(fake, key)) {
		assert_int_equal(page_cache_poll(fake->cache), STATUS_OK);
		sched_yield();
	}
}

/* Until so many are loaded, and nobody took them from there. */
static void await_loaded(struct fake *fake, unsigned count)
{
	for (unsigned loaded = 0; loaded < count; sched_yield()) {
		loaded = 0;
		mutex_lock(&fake->cache->mutex);
		for (const struct page *page = fake->cache->table.flights.first; page != NULL; page = page->next)
			loaded += page->state == PAGE_LOADED;
		mutex_unlock(&fake->cache->mutex);
	}
}

static void page_prefetched_and_polled_is_a_hit(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	(void)state;
	fake_start(&fake, &params);
	fake_want(&fake, 5);
	fake_want(&fake, 5);
	poll_until_resident(&fake, 5);
	assert_int_equal(page_cache_request_state(fake.cache), PAGE_REQUESTS_HERE);
	fake_want(&fake, 5);
	fake_visit(&fake, 5);
	struct page_stats stats = fake_stats(&fake);
	assert_int_equal(stats.prefetched, 1);
	assert_int_equal(stats.hits, 1);
	assert_int_equal(stats.misses, 0);
	assert_int_equal(stats.stalls, 0);
	fake_finish(&fake);
}

static void page_pin_of_a_prefetch_on_its_way_is_late(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	struct fake_opener opener;
	(void)state;
	fake_start(&fake, &params);
	fake_gate(&fake, 5 + 1, false);
	fake_want(&fake, 5);
	fake_await(&fake, 1, 0);
	fake_open_later(&opener, &fake, 1, 0);
	fake_visit(&fake, 5);
	thread_join(&opener.thread);
	struct page_stats stats = fake_stats(&fake);
	assert_int_equal(stats.misses, 1);
	assert_int_equal(stats.late, 1);
	assert_int_equal(stats.not_begun, 0);
	assert_int_equal(fake.loads_begun, 1);
	fake_finish(&fake);
}

/* Opens the gates once the owner waits for a page. */
static void *open_at_a_miss(void *argument)
{
	struct fake *fake = argument;
	for (uint64_t misses = 0; misses == 0;) {
		mutex_lock(&fake->cache->mutex);
		misses = fake->cache->stats.misses;
		mutex_unlock(&fake->cache->mutex);
		nanosleep(&(struct timespec){0, 100000}, NULL);
	}
	fake_gate(fake, 0, false);
	return NULL;
}

/* The only loader is busy with another page. */
static void page_pin_of_a_request_that_waits_for_a_loader_is_not_begun(void **state)
{
	static struct fake fake;
	const uint64_t keys[] = {5, 6};
	struct page_params params = fake_params(&fake, 4, 1);
	struct thread opener;
	(void)state;
	fake_start(&fake, &params);
	fake_gate(&fake, 5 + 1, false);
	page_cache_want(fake.cache, keys, 2);
	fake_await(&fake, 1, 0);
	assert_int_equal(thread_start(&opener, open_at_a_miss, &fake, "opener"), STATUS_OK);
	fake_visit(&fake, 6);
	thread_join(&opener);
	struct page_stats stats = fake_stats(&fake);
	assert_int_equal(stats.misses, 1);
	assert_int_equal(stats.late, 0);
	assert_int_equal(stats.not_begun, 1);
	fake_finish(&fake);
}

static void page_prefetch_never_evicts_what_the_step_pinned(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	(void)state;
	fake_start(&fake, &params);
	fake_visit(&fake, 9);
	fake_end_step(&fake, 1);
	fake_gate(&fake, 7 + 1, false);
	fake_want(&fake, 7); /* may take the slot of 9, if nobody else does */
	fake_await(&fake, 2, 0);
	fake_gate(&fake, 0, false);
	/* The one loader is done with 7 when it takes 0. */
	for (uint64_t key = 0; key < 4; key++)
		fake_visit(&fake, key);
	assert_int_equal(page_cache_poll(fake.cache), STATUS_OK);
	for (uint64_t key = 0; key < 4; key++)
		assert_true(fake_resident(&fake, key));
	assert_false(fake_resident(&fake, 7));
	fake_want(&fake, 8); /* not honoured: nothing can go for it */
	assert_int_equal(page_cache_request_state(fake.cache), PAGE_REQUESTS_SHORT);
	assert_int_equal(fake_stats(&fake).prefetched, 1);
	fake_end_step(&fake, 2);
	fake_pin(&fake, 0);
	fake_want(&fake, 7); /* may take that of 1, the oldest of those not pinned */
	poll_until_resident(&fake, 7);
	assert_true(fake_resident(&fake, 0));
	assert_false(fake_resident(&fake, 1));
	fake_finish(&fake);
}

static void page_prefetch_evicts_dirty_pages_only_into_room(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	(void)state;
	params.queue_soft = 100;
	params.queue_most = 4;
	fake_start(&fake, &params);
	for (uint64_t key = 0; key < 7; key++)
		fake_change(&fake, key);
	fake_end_step(&fake, 1); /* three wait, four are dirty in their slots */
	assert_int_equal(fake.commits_begun, 0);
	fake_want(&fake, 20);
	poll_until_resident(&fake, 20);
	fake_visit(&fake, 20);
	page_cache_want(fake.cache, (const uint64_t[]){21, 22}, 2);
	fake_await(&fake, 10, 0);
	for (int i = 0; i < 100; i++) {
		assert_int_equal(page_cache_poll(fake.cache), STATUS_OK);
		sched_yield();
	}
	assert_int_equal(fake.read_backs, 4);
	for (uint64_t key = 4; key < 7; key++)
		assert_true(fake_resident(&fake, key));
	assert_int_equal(fake_stats(&fake).stalls, 7);
	fake_check_nothing_is_lost(&fake);
	fake_finish(&fake);
}

/* In the order of the list, whatever was asked for before; and what is not in it is not loaded. */
static void page_wishes_are_loaded_soonest_first_and_cancelled(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 8, 1);
	(void)state;
	fake_start(&fake, &params);
	fake_gate(&fake, 1 + 1, false);
	page_cache_want(fake.cache, (const uint64_t[]){1, 2, 3, 4}, 4);
	fake_await(&fake, 1, 0);
	page_cache_want(fake.cache, (const uint64_t[]){6, 4, 3}, 3); /* 1 is stale, 2 never begins */
	assert_int_equal(fake_stats(&fake).cancelled, 2);
	fake_gate(&fake, 0, false);
	poll_until_resident(&fake, 3);
	const uint64_t expected[] = {1, 6, 4, 3};
	assert_memory_equal(fake.loaded, expected, sizeof expected);
	assert_int_equal(fake.loads_begun, 4);
	assert_false(fake_resident(&fake, 1));
	assert_int_equal(page_cache_request_state(fake.cache), PAGE_REQUESTS_HERE);
	page_cache_want(fake.cache, NULL, 0);
	assert_int_equal(page_cache_request_state(fake.cache), PAGE_REQUESTS_HERE);
	assert_true(fake_resident(&fake, 3)); /* it stays, as what was used */
	fake_finish(&fake);
}

/* What is wished for goes last, the farthest need first; a wish pushes out nothing that is wished. */
static void page_wished_pages_stay(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	(void)state;
	fake_start(&fake, &params);
	for (uint64_t key = 0; key < 4; key++)
		fake_visit(&fake, key);
	fake_end_step(&fake, 1);
	page_cache_want(fake.cache, (const uint64_t[]){0, 2, 1}, 3);
	fake_visit(&fake, 10); /* for 3, though that was used last */
	assert_false(fake_resident(&fake, 3));
	fake_visit(&fake, 11); /* for 10, which nobody wishes for */
	assert_false(fake_resident(&fake, 10));
	uint32_t held = fake_pin(&fake, 11);
	(void)held;
	assert_int_equal(page_cache_request_state(fake.cache), PAGE_REQUESTS_HERE);
	fake_visit(&fake, 12); /* for 1: it is needed last */
	assert_false(fake_resident(&fake, 1));
	assert_true(fake_resident(&fake, 0) && fake_resident(&fake, 2));
	assert_int_equal(page_cache_request_state(fake.cache), PAGE_REQUESTS_SHORT);
	fake_unpin(&fake, 11);
	fake_end_step(&fake, 2);
	/* Four wishes for four slots: the fifth is not honoured, and none goes for another. */
	page_cache_want(fake.cache, (const uint64_t[]){0, 2, 20, 21, 22}, 5);
	poll_until_resident(&fake, 20);
	poll_until_resident(&fake, 21);
	assert_true(fake_resident(&fake, 0) && fake_resident(&fake, 2));
	for (int i = 0; i < 100; i++)
		assert_int_equal(page_cache_poll(fake.cache), STATUS_OK);
	assert_false(fake_resident(&fake, 22));
	assert_int_equal(page_cache_request_state(fake.cache), PAGE_REQUESTS_SHORT);
	fake_finish(&fake);
}

/* Those that were honoured have lost their room since: what is there stays, and the last one waits. */
static void page_wish_pushes_out_no_other(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 2);
	(void)state;
	fake_start(&fake, &params);
	fake_gate(&fake, 2 + 1, false);
	page_cache_want(fake.cache, (const uint64_t[]){0, 1, 2}, 3);
	poll_until_resident(&fake, 0);
	poll_until_resident(&fake, 1);
	fake_pin(&fake, 10);
	fake_pin(&fake, 11);
	fake_gate(&fake, 0, false);
	await_loaded(&fake, 1);
	assert_int_equal(page_cache_poll(fake.cache), STATUS_OK);
	assert_true(fake_resident(&fake, 0) && fake_resident(&fake, 1));
	assert_false(fake_resident(&fake, 2));
	assert_int_equal(page_cache_request_state(fake.cache), PAGE_REQUESTS_COMING);
	fake_unpin(&fake, 11);
	fake_end_step(&fake, 1);
	poll_until_resident(&fake, 2); /* for 11 */
	assert_false(fake_resident(&fake, 11));
	assert_int_equal(page_cache_request_state(fake.cache), PAGE_REQUESTS_HERE);
	fake_finish(&fake);
}

/* A loader that had no room for another goes on when a load before it is uploaded, or cannot be, though
 * the executor still has that image. */
static void page_next_wish_is_loaded_while_uploads_are_on_their_way(void **state)
{
	(void)state;
	for (int failing = 0; failing < 2; failing++) {
		static struct fake fake;
		struct page_params params = fake_params(&fake, 8, 1);
		fake_start(&fake, &params);
		page_cache_want(fake.cache, (const uint64_t[]){1, 2, 3}, 3);
		await_loaded(&fake, 2);
		assert_int_equal(fake.loads_begun, 2);
		fake.settle_after = 1000;
		fake.fail_upload = failing ? 1 + 1 : 0;
		assert_int_equal(page_cache_poll(fake.cache), failing ? STATUS_NO_GL : STATUS_OK);
		fake_await(&fake, 3, 0);
		fake_finish(&fake);
	}
}

/* A wish whose load is given up, since it would have to be done again, is no longer here. */
static void page_wish_that_outlives_two_epochs_is_short(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 8, 2);
	(void)state;
	fake_start(&fake, &params);
	fake_gate(&fake, COARSE + 1, false);
	fake_want(&fake, COARSE);
	fake_await(&fake, 1, 0);
	for (uint64_t record = 1; record < 3; record++) {
		assert_int_equal(page_cache_request_state(fake.cache), PAGE_REQUESTS_COMING);
		fake_change(&fake, 0);
		fake_flush(&fake, record);
	}
	assert_int_equal(page_cache_request_state(fake.cache), PAGE_REQUESTS_SHORT);
	fake_gate(&fake, 0, false);
	while (page_cache_request_state(fake.cache) != PAGE_REQUESTS_HERE) {
		fake_want(&fake, COARSE);
		assert_int_equal(page_cache_poll(fake.cache), STATUS_OK);
		sched_yield();
	}
	assert_true(fake_resident(&fake, COARSE));
	fake_finish(&fake);
}

/* A picture's use protects as a pin's does: a budget below what is drawn does not spin. */
static void page_prefetch_never_evicts_what_is_drawn(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	uint32_t slot;
	(void)state;
	fake_start(&fake, &params);
	for (uint64_t key = 0; key < 4; key++)
		fake_visit(&fake, key);
	for (uint64_t frame = 1; frame < 20; frame++) {
		fake_end_step(&fake, frame);
		for (uint64_t key = 0; key < 4; key++)
			assert_true(page_cache_peek(fake.cache, key, true, &slot));
		page_cache_want(fake.cache, (const uint64_t[]){10, 11, 12, 13}, 4);
		assert_int_equal(page_cache_poll(fake.cache), STATUS_OK);
		sched_yield();
	}
	assert_int_equal(fake.loads_begun, 4);
	assert_int_equal(fake_stats(&fake).evictions, 0);
	fake_finish(&fake);
}

/* Without loaders the owner loads what it pins, and nothing ahead. */
static void page_without_loaders_the_owner_loads(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 0);
	(void)state;
	fake_start(&fake, &params);
	fake_want(&fake, 5);
	assert_int_equal(page_cache_request_state(fake.cache), PAGE_REQUESTS_HERE);
	assert_int_equal(page_cache_poll(fake.cache), STATUS_OK);
	assert_int_equal(fake.loads_begun, 0);
	for (uint64_t key = 0; key < 20; key++)
		fake_change(&fake, key);
	fake.fail_load = 30 + 1;
	uint32_t slot;
	assert_int_equal(page_cache_pin(fake.cache, 30, &slot), STATUS_INPUT);
	fake_flush(&fake, 1);
	struct page_stats stats = fake_stats(&fake);
	assert_int_equal(stats.misses, 21);
	assert_int_equal(stats.stalls, 21);
	fake_finish(&fake);
}

static void page_failed_prefetch_is_silent_and_retried(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	(void)state;
	fake_start(&fake, &params);
	fake.fail_load = 5 + 1;
	page_cache_want(fake.cache, (const uint64_t[]){5, 6}, 2);
	poll_until_resident(&fake, 6); /* the one loader was done with 5 before */
	assert_false(fake_resident(&fake, 5));
	fake_want(&fake, 5);
	fake_await(&fake, 3, 0); /* the loader fails with 5 again, and only then loads 7 */
	fake_visit(&fake, 7);
	mutex_lock(&fake.mutex);
	fake.fail_load = 0;
	mutex_unlock(&fake.mutex);
	fake_visit(&fake, 5);
	fake_finish(&fake);
}

/* Nothing of either list has begun, and every slot is taken: all of both are known at once. */
static void page_wish_lists_may_have_nothing_in_common(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, SLOTS_MOST, 1);
	uint64_t keys[2][SLOTS_MOST];
	(void)state;
	fake_start(&fake, &params);
	for (uint64_t key = 0; key < SLOTS_MOST; key++) {
		fake_visit(&fake, key);
		keys[0][key] = 2000 + key;
		keys[1][key] = 3000 + key;
	}
	fake_end_step(&fake, 1);
	keys[0][0] = COARSE; /* the one that is begun */
	fake_gate(&fake, COARSE + 1, false);
	page_cache_want(fake.cache, keys[0], SLOTS_MOST);
	fake_await(&fake, SLOTS_MOST + 1, 0);
	page_cache_want(fake.cache, keys[1], SLOTS_MOST);
	page_cache_want(fake.cache, NULL, 0);
	fake_gate(&fake, 0, false);
	fake_finish(&fake);
}

/* A load on its way for two epochs keeps the first one's images, and is given up for the second. */
static void page_wish_given_up_for_an_epoch_is_not_here(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	(void)state;
	fake_start(&fake, &params);
	fake_change(&fake, 1);
	fake_gate(&fake, 5 + 1, false);
	fake_want(&fake, 5);
	fake_await(&fake, 2, 0);
	fake_flush(&fake, 1);
	assert_int_equal(page_cache_request_state(fake.cache), PAGE_REQUESTS_COMING);
	fake_flush(&fake, 2);
	assert_int_equal(page_cache_request_state(fake.cache), PAGE_REQUESTS_SHORT);
	assert_int_equal(fake_stats(&fake).cancelled, 1);
	fake_gate(&fake, 0, false);
	while (!fake_resident(&fake, 5)) {
		fake_want(&fake, 5);
		assert_int_equal(page_cache_poll(fake.cache), STATUS_OK);
		sched_yield();
	}
	fake_finish(&fake);
}

/* Opens the gate when a pin has asked for a page that no loader took. */
static void *open_on_urgent(void *argument)
{
	struct fake *fake = argument;
	for (bool asked = false; !asked; sched_yield()) {
		mutex_lock(&fake->cache->mutex);
		asked = fake->cache->table.urgent.count > 0;
		mutex_unlock(&fake->cache->mutex);
	}
	fake_gate(fake, 0, false);
	return NULL;
}

static void page_pins_overtake_prefetches(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 8, 1);
	struct thread opener;
	(void)state;
	fake_start(&fake, &params);
	fake_gate(&fake, 1 + 1, false);
	page_cache_want(fake.cache, (const uint64_t[]){1, 2, 3}, 3);
	fake_await(&fake, 1, 0);
	assert_int_equal(fake_stats(&fake).prefetched, 1);
	assert_int_equal(thread_start(&opener, open_on_urgent, &fake, "opener"), STATUS_OK);
	fake_visit(&fake, 4);
	thread_join(&opener);
	fake_visit(&fake, 2);
	assert_int_equal(fake.loaded[1], 4);
	assert_int_equal(fake.loaded[2], 2);
	fake_finish(&fake);
}

/* Two prefetches wait for the one loader, unpolled; a pin of many pages is served all the same. */
static void page_prefetches_that_nobody_polls_do_not_starve_pins(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 16, 1);
	uint64_t keys[16];
	uint32_t slots[16];
	(void)state;
	fake_start(&fake, &params);
	page_cache_want(fake.cache, (const uint64_t[]){100, 101, 102}, 3);
	fake_await(&fake, 2, 0);
	sched_yield();
	fake_visit(&fake, 102); /* wished for, and no loader will take it as that */
	for (uint64_t i = 0; i < 16; i++)
		keys[i] = i;
	assert_int_equal(page_cache_pin_all(fake.cache, keys, 16, slots), STATUS_OK);
	assert_int_equal(page_cache_poll(fake.cache), STATUS_OK); /* every slot is pinned */
	assert_false(fake_resident(&fake, 102));
	assert_false(fake_resident(&fake, 100));
	assert_int_equal(fake.images[PAGE_LOADED_IMAGE], 3);
	fake_finish(&fake);
}

TEST_PROGRAM(prefetch)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(page_prefetched_and_polled_is_a_hit),
		cmocka_unit_test(page_pin_of_a_prefetch_on_its_way_is_late),
		cmocka_unit_test(page_pin_of_a_request_that_waits_for_a_loader_is_not_begun),
		cmocka_unit_test(page_prefetch_never_evicts_what_the_step_pinned),
		cmocka_unit_test(page_prefetch_evicts_dirty_pages_only_into_room),
		cmocka_unit_test(page_wishes_are_loaded_soonest_first_and_cancelled),
		cmocka_unit_test(page_wished_pages_stay),
		cmocka_unit_test(page_wish_pushes_out_no_other),
		cmocka_unit_test(page_next_wish_is_loaded_while_uploads_are_on_their_way),
		cmocka_unit_test(page_wish_that_outlives_two_epochs_is_short),
		cmocka_unit_test(page_prefetch_never_evicts_what_is_drawn),
		cmocka_unit_test(page_without_loaders_the_owner_loads),
		cmocka_unit_test(page_failed_prefetch_is_silent_and_retried),
		cmocka_unit_test(page_wish_lists_may_have_nothing_in_common),
		cmocka_unit_test(page_wish_given_up_for_an_epoch_is_not_here),
		cmocka_unit_test(page_pins_overtake_prefetches),
		cmocka_unit_test(page_prefetches_that_nobody_polls_do_not_starve_pins),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
