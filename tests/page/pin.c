/* Pins: what is resident, what is evicted, what is refused. */
#include "page/fake.h"
#include "../support/program.h"

static void page_pin_shows_the_bits_of_the_store(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	(void)state;
	fake_start(&fake, &params);
	fake.store[3] = fake.model[3] = 42;
	fake_visit(&fake, 3);
	fake_visit(&fake, 3);
	struct page_stats stats = fake_stats(&fake);
	assert_int_equal(stats.misses, 1);
	assert_int_equal(stats.hits, 1);
	assert_true(stats.stalls <= 1);
	assert_int_equal(fake.loads_begun, 1);
	fake_finish(&fake);
}

static void page_evicts_the_least_recently_used(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	(void)state;
	fake_start(&fake, &params);
	for (uint64_t key = 0; key < 4; key++)
		fake_visit(&fake, key);
	fake_visit(&fake, 0); /* order: 1 2 3 0 */
	uint32_t slot;
	assert_true(page_cache_peek(fake.cache, 1, false, &slot)); /* changes nothing */
	assert_true(page_cache_peek(fake.cache, 2, true, &slot));  /* order: 1 3 0 2 */
	fake_visit(&fake, 10);
	assert_false(fake_resident(&fake, 1));
	fake_visit(&fake, 11);
	assert_false(fake_resident(&fake, 3));
	fake_visit(&fake, 12);
	assert_false(fake_resident(&fake, 0));
	assert_true(fake_resident(&fake, 2));
	assert_int_equal(fake_stats(&fake).evictions, 3);
	fake_finish(&fake);
}

static void page_pinned_is_never_evicted(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 2);
	(void)state;
	fake_start(&fake, &params);
	uint32_t held = fake_pin(&fake, 0); /* the executor asserts that nothing goes there */
	fake_pin(&fake, 0);
	fake_unpin(&fake, 0); /* pins count */
	for (uint64_t key = 1; key < 40; key++) {
		fake_visit(&fake, key);
		uint32_t slot;
		assert_true(page_cache_peek(fake.cache, 0, false, &slot));
		assert_int_equal(slot, held);
	}
	fake_unpin(&fake, 0);
	for (uint64_t key = 1; key < 5; key++)
		fake_visit(&fake, key);
	assert_false(fake_resident(&fake, 0));
	fake_finish(&fake);
}

static void page_four_slots_and_one_loader_serve_steps_of_four(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	(void)state;
	fake_start(&fake, &params);
	for (uint64_t step = 0; step < 200; step++) {
		uint64_t first = step * 3 % (FINE - 4);
		uint64_t keys[] = {first + 2, first, first + 3, first + 1};
		uint32_t slots[4];
		assert_int_equal(page_cache_pin_all(fake.cache, keys, 4, slots), STATUS_OK);
		for (int i = 0; i < 4; i++) {
			assert_int_equal(fake.slots[slots[i]].key, keys[i]);
			assert_int_equal(fake.slots[slots[i]].version, fake.model[keys[i]]);
			fake.slots[slots[i]].version = ++fake.model[keys[i]];
			page_cache_dirty(fake.cache, keys[i]);
		}
		for (int i = 0; i < 4; i++)
			page_cache_unpin(fake.cache, keys[i]);
		fake_end_step(&fake, step);
	}
	fake_flush(&fake, 200);
	fake_finish(&fake);
}

static void page_five_keys_in_four_slots_are_refused(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	const uint64_t keys[] = {1, 2, 3, 4, 5}, again[] = {1, 2, 1, 3, 4};
	uint32_t slots[5];
	(void)state;
	fake_start(&fake, &params);
	assert_int_equal(page_cache_pin_all(fake.cache, keys, 5, slots), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "cache.slots to at least 5"));
	/* A key that is there twice needs one slot, and two unpins. */
	assert_int_equal(page_cache_pin_all(fake.cache, again, 5, slots), STATUS_OK);
	assert_int_equal(slots[0], slots[2]);
	assert_int_equal(page_cache_pin(fake.cache, 5, slots), STATUS_FAILED);
	page_cache_unpin(fake.cache, 1);
	assert_int_equal(page_cache_pin(fake.cache, 5, slots), STATUS_FAILED);
	page_cache_unpin(fake.cache, 1);
	assert_int_equal(page_cache_pin(fake.cache, 5, slots), STATUS_OK);
	assert_int_equal(page_cache_pin_all(fake.cache, &again[2], 3, slots), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "cache.slots to at least 5"));
	fake_finish(&fake);
}

/* Were they asked for one by one, the second load would not begin, and the gate never open. */
static void page_pin_all_asks_for_all_before_it_waits(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 3);
	const uint64_t keys[] = {1, 2, 3};
	uint32_t slots[3];
	struct fake_opener opener;
	(void)state;
	fake_start(&fake, &params);
	fake_gate(&fake, UINT64_MAX, false);
	fake_open_later(&opener, &fake, 3, 0);
	assert_int_equal(page_cache_pin_all(fake.cache, keys, 3, slots), STATUS_OK);
	thread_join(&opener.thread);
	assert_int_equal(fake_stats(&fake).stalls, 1);
	fake_finish(&fake);
}

static void page_failed_load_fails_its_pin_once(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 2);
	const uint64_t keys[] = {0, 1, 2, 3}, others[] = {10, 11, 12, 13};
	uint32_t slots[4];
	(void)state;
	fake_start(&fake, &params);
	fake_visit(&fake, 0); /* held before the failure comes */
	fake.fail_load = 2 + 1;
	assert_int_equal(page_cache_pin_all(fake.cache, keys, 4, slots), STATUS_INPUT);
	assert_string_equal(failure_message(), "tile 2: checksum; run furrow verify");
	mutex_lock(&fake.mutex);
	fake.fail_load = 0;
	mutex_unlock(&fake.mutex);
	/* It left no pin behind, and is forgotten. */
	assert_int_equal(page_cache_pin_all(fake.cache, others, 4, slots), STATUS_OK);
	for (int i = 0; i < 4; i++)
		page_cache_unpin(fake.cache, others[i]);
	assert_int_equal(page_cache_pin_all(fake.cache, keys, 4, slots), STATUS_OK);
	fake_finish(&fake);
}

static void page_failed_upload_leaves_its_slot_free(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 2, 1);
	uint32_t slot;
	(void)state;
	fake_start(&fake, &params);
	fake_change(&fake, 0);
	fake_change(&fake, 1);
	fake.fail_upload = 2 + 1;
	assert_int_equal(page_cache_pin(fake.cache, 2, &slot), STATUS_NO_GL);
	fake.fail_upload = 0;
	fake_pin(&fake, 1);
	fake_pin(&fake, 2);
	fake_flush(&fake, 1);
	fake_finish(&fake);
}

static void page_touched_counts_different_pages(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 2);
	(void)state;
	fake_start(&fake, &params);
	for (int round = 0; round < 3; round++)
		for (uint64_t key = 0; key < FINE; key++) {
			fake_visit(&fake, key);
			fake_visit(&fake, key);
		}
	for (uint64_t i = 0; i < FINE / FAMILY; i++)
		fake_visit(&fake, COARSE + i);
	struct page_stats stats = fake_stats(&fake);
	assert_int_equal(stats.touched, FINE + FINE / FAMILY);
	assert_int_equal(stats.hits, 3 * FINE);
	assert_int_equal(stats.misses, 3 * FINE + FINE / FAMILY);
	assert_int_equal(fake.images[PAGE_LOADED_IMAGE], 6);
	assert_int_equal(stats.queue_peak, 0);
	fake_finish(&fake);
}

TEST_PROGRAM(pin)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(page_pin_shows_the_bits_of_the_store),
		cmocka_unit_test(page_evicts_the_least_recently_used),
		cmocka_unit_test(page_pinned_is_never_evicted),
		cmocka_unit_test(page_four_slots_and_one_loader_serve_steps_of_four),
		cmocka_unit_test(page_five_keys_in_four_slots_are_refused),
		cmocka_unit_test(page_pin_all_asks_for_all_before_it_waits),
		cmocka_unit_test(page_failed_load_fails_its_pin_once),
		cmocka_unit_test(page_failed_upload_leaves_its_slot_free),
		cmocka_unit_test(page_touched_counts_different_pages),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
