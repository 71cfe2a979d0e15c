/* Faults: every allocation fails once, and the threads are stopped in the middle of things. */
#include "page/fake.h"
#include "../support/program.h"

/* A short run; the first failure ends it. Only steps that ended count, but none is torn here:
 * `model` changes only when the page has been pinned. */
static enum status short_run(struct fake *fake)
{
	uint64_t record = 0;
	enum status status = STATUS_OK;
	for (uint64_t step = 0; step < 12 && status == STATUS_OK; step++) {
		const uint64_t keys[] = {step, step + 1, step + 13, step + 14};
		uint32_t slots[4];
		fake_want(fake, step + 2);
		status = page_cache_pin_all(fake->cache, keys, 4, slots);
		for (int i = 0; i < 4 && status == STATUS_OK; i++) {
			fake->slots[slots[i]].version = ++fake->model[keys[i]];
			page_cache_dirty(fake->cache, keys[i]);
			page_cache_unpin(fake->cache, keys[i]);
		}
		if (status == STATUS_OK)
			status = page_cache_end_step(fake->cache, &record);
		if (status == STATUS_OK)
			status = page_cache_poll(fake->cache);
	}
	return status == STATUS_OK ? page_cache_flush(fake->cache, &record) : status;
}

static void page_failed_allocations_lose_nothing(void **state)
{
	(void)state;
	for (int forever = 0; forever < 2; forever++) {
		unsigned failures = 0, refused = 0;
		for (uint64_t nth = 1;; nth++) {
			static struct fake fake;
			struct page_params params = fake_params(&fake, 5, 2);
			fake_init(&fake);
			mem_fail_nth(nth, forever);
			enum status status = page_cache_create(&params, &fake.cache);
			refused += status != STATUS_OK;
			if (status == STATUS_OK)
				status = short_run(&fake);
			bool reached = mem_fail_nth(0, 0) >= nth;
			if (status != STATUS_OK) {
				failures++;
				assert_int_equal(status, STATUS_FAILED);
				assert_non_null(strstr(failure_message(), "out of memory"));
			}
			if (fake.cache != NULL)
				fake_flush(&fake, 99);
			fake_finish(&fake);
			if (!reached)
				break;
		}
		assert_true(refused >= 5);
		assert_true(failures > refused);
	}
}

static void page_destroy_waits_for_loads_and_commits_on_their_way(void **state)
{
	(void)state;
	for (int round = 0; round < 20; round++) {
		static struct fake fake;
		struct page_params params = fake_params(&fake, 8, 2);
		struct fake_opener opener;
		params.queue_soft = 0;
		fake_start(&fake, &params);
		fake_change(&fake, 0);
		fake_gate(&fake, UINT64_MAX, true);
		fake_end_step(&fake, 1);
		page_cache_want(fake.cache, (const uint64_t[]){10, 11, 12, 13}, 4);
		fake_await(&fake, 3, 1);
		fake_open_later(&opener, &fake, 3, 1);
		page_cache_destroy(fake.cache); /* sanitizers see what it would leave behind */
		thread_join(&opener.thread);
		fake.cache = NULL;
		assert_int_equal(fake.store[0], 101); /* that commit had begun */
		fake_finish(&fake);
	}
	page_cache_destroy(NULL);
}

static void page_destroy_commits_nothing(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	(void)state;
	fake_start(&fake, &params);
	for (uint64_t key = 0; key < 8; key++)
		fake_change(&fake, key);
	page_cache_destroy(fake.cache);
	fake.cache = NULL;
	assert_int_equal(fake.commits_begun, 0);
	fake_finish(&fake);
}

TEST_PROGRAM(faults)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(page_failed_allocations_lose_nothing),
		cmocka_unit_test(page_destroy_waits_for_loads_and_commits_on_their_way),
		cmocka_unit_test(page_destroy_commits_nothing),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
