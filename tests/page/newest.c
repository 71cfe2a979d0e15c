/*
 * Where the newest version of a page is, and what it is: dirty in its slot, in the queue, though its read-back is not over
 * yet, or in the store; against the model, while pages come, change, go and are committed. Looking changes nothing.
 */
#include "page/fake.h"
#include "../support/program.h"

static void take_version(void *user, const struct page_image *image)
{
	*(uint64_t *)user = ((const struct content *)image->bytes)->version;
}

static enum page_newest check_newest(struct fake *fake, uint64_t key)
{
	enum page_newest where;
	uint32_t slot = UINT32_MAX;
	uint64_t version = 0;
	assert_int_equal(page_cache_newest(fake->cache, key, take_version, &version, &where, &slot), STATUS_OK);
	if (where == PAGE_NEWEST_SLOT)
		version = fake->slots[slot].version;
	else if (where == PAGE_NEWEST_STORED)
		version = fake_stored(fake, key);
	assert_int_equal(version, fake->model[key]);
	return where;
}

static void mark(void *user, uint64_t key)
{
	((bool *)user)[key] = true;
}

/* All that the store may not have are told. */
static void check_changed(struct fake *fake)
{
	bool changed[FINE] = {false};
	page_cache_each_changed(fake->cache, mark, changed);
	for (uint64_t key = 0; key < FINE; key++)
		assert_true(changed[key] || fake_stored(fake, key) == fake->model[key]);
}

static void page_newest_is_found_wherever_it_is(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 2);
	fake_start(&fake, &params);
	assert_int_equal(check_newest(&fake, 0), PAGE_NEWEST_STORED);
	fake_change(&fake, 0);
	assert_int_equal(check_newest(&fake, 0), PAGE_NEWEST_SLOT);
	fake.settle_after = 3;
	fake_push_out(&fake, 4, 10);
	assert_false(fake_resident(&fake, 0));
	assert_int_equal(check_newest(&fake, 0), PAGE_NEWEST_QUEUED); /* waited for: the image has other bytes until then */
	fake.settle_after = 0;
	fake_visit(&fake, 0);
	assert_int_equal(check_newest(&fake, 0), PAGE_NEWEST_QUEUED); /* in a slot, and clean */
	fake_change(&fake, 0);
	assert_int_equal(check_newest(&fake, 0), PAGE_NEWEST_SLOT); /* the one that waits is older */
	fake_flush(&fake, 1);
	assert_int_equal(check_newest(&fake, 0), PAGE_NEWEST_STORED);
	fake_finish(&fake);
}

static void page_newest_that_is_committed_is_found(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 2);
	params.queue_soft = 1;
	fake_start(&fake, &params);
	fake_change(&fake, 0);
	fake_gate(&fake, 0, true);
	fake_end_step(&fake, 1);
	fake_await(&fake, 0, 1);
	check_changed(&fake);
	assert_int_equal(check_newest(&fake, 0), PAGE_NEWEST_QUEUED);
	fake_change(&fake, 0);
	assert_int_equal(check_newest(&fake, 0), PAGE_NEWEST_SLOT);
	fake_gate(&fake, 0, false);
	fake_flush(&fake, 2);
	fake_finish(&fake);
}

static void page_newest_is_the_models(void **state)
{
	static struct fake fake;
	uint64_t random = 1, seen[3] = {0};
	struct page_params params = fake_params(&fake, 6, 2);
	params.queue_soft = 3;
	fake_start(&fake, &params);
	for (uint64_t step = 1; step <= 600; step++) {
		for (int i = 0; i < 4; i++) {
			random = random * 6364136223846793005u + 1442695040888963407u;
			fake.settle_after = random >> 60 < 8 ? 0 : (unsigned)(random >> 60) - 7;
			if (random >> 59 & 1)
				fake_change(&fake, random >> 40 & 15);
			else
				fake_visit(&fake, random >> 40 & 31);
		}
		struct page_stats before = fake_stats(&fake);
		check_changed(&fake);
		for (uint64_t key = 0; key < 32; key++)
			seen[check_newest(&fake, key)]++;
		struct page_stats after = fake_stats(&fake);
		after.writebacks = before.writebacks; /* the writer's */
		after.commits = before.commits;
		assert_memory_equal(&before, &after, sizeof before);
		fake_end_step(&fake, step);
	}
	assert_true(seen[PAGE_NEWEST_STORED] > 100 && seen[PAGE_NEWEST_QUEUED] > 100 && seen[PAGE_NEWEST_SLOT] > 100);
	fake_flush(&fake, 601);
	fake_finish(&fake);
}

static void page_newest_that_fails_is_told(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 2);
	enum page_newest where;
	uint32_t slot;
	uint64_t version;
	fake_start(&fake, &params);
	fake_change(&fake, 0);
	fake.settle_after = 3;
	fake_push_out(&fake, 4, 10);
	fake.fail_settle = true;
	assert_int_equal(page_cache_newest(fake.cache, 0, take_version, &version, &where, &slot), STATUS_NO_GL);
	fake_finish(&fake);
}

TEST_PROGRAM(newest)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(page_newest_is_found_wherever_it_is),
		cmocka_unit_test(page_newest_that_is_committed_is_found),
		cmocka_unit_test(page_newest_is_the_models),
		cmocka_unit_test(page_newest_that_fails_is_told),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
