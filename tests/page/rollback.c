/*
 * Rollbacks: whatever is on its way when it comes (a load, a read-back, a commit), every page then shows what the store
 * went back to, and what did not change stays resident.
 */
#include "page/fake.h"
#include "../support/program.h"

struct going {
	struct fake *fake;
	uint64_t mark[FINE];
	bool fails, dropped[FINE], coarse_dropped, told[FINE];
	unsigned calls;
};

static void tell(void *user, uint64_t key)
{
	((bool *)user)[key] = true;
}

static enum status back(void *user)
{
	struct going *going = user;
	page_cache_each_changed(going->fake->cache, tell, going->told);
	going->calls++;
	if (going->fails)
		return fail_with(STATUS_FAILED, "store: the disk is gone; look for it");
	mutex_lock(&going->fake->mutex);
	memcpy(going->fake->store, going->mark, sizeof going->mark);
	mutex_unlock(&going->fake->mutex);
	return STATUS_OK;
}

static bool changed(void *user, uint64_t key)
{
	const struct going *going = user;
	const uint64_t *model = going->fake->model;
	if (key < FINE)
		return model[key] != going->mark[key];
	return memcmp(&model[(key - COARSE) * FAMILY], &going->mark[(key - COARSE) * FAMILY], FAMILY * sizeof *model) != 0;
}

static void dropped(void *user, uint64_t key)
{
	struct going *going = user;
	if (key < FINE)
		going->dropped[key] = true;
	else
		going->coarse_dropped = true;
}

static enum status roll_back(struct going *going)
{
	const struct page_rollback rollback = {going, back, changed, dropped};
	enum status status = page_cache_rollback(going->fake->cache, &rollback);
	if (status == STATUS_OK)
		memcpy(going->fake->model, going->mark, sizeof going->mark);
	return status;
}

static struct going mark(struct fake *fake)
{
	struct going going = {.fake = fake};
	fake_flush(fake, 1);
	memcpy(going.mark, fake->model, sizeof going.mark);
	return going;
}

/* The versions that a model's counter gives come again after a rollback: these do not. */
static void change_to(struct fake *fake, uint64_t key, uint64_t version)
{
	fake->model[key] = version - 1;
	uint32_t slot, coarse;
	assert_int_equal(page_cache_pin(fake->cache, key, &slot), STATUS_OK);
	fake->slots[slot].version = ++fake->model[key];
	page_cache_dirty(fake->cache, key);
	page_cache_unpin(fake->cache, key);
	if (page_cache_peek(fake->cache, COARSE + key / FAMILY, false, &coarse))
		fake->slots[coarse].family[key % FAMILY] = version;
}

static void check_coarse(struct fake *fake, uint64_t number)
{
	uint32_t slot = fake_pin(fake, COARSE + number);
	assert_memory_equal(fake->slots[slot].family, &fake->model[number * FAMILY], FAMILY * sizeof *fake->model);
	fake_unpin(fake, COARSE + number);
}

static void page_rollback_drops_what_changed_and_nothing_else(void **state)
{
	for (uint32_t loaders = 0; loaders < 3; loaders++) {
		static struct fake fake;
		struct page_params params = fake_params(&fake, 16, loaders);
		fake_start(&fake, &params);
		fake_change(&fake, 0);
		for (uint64_t key = 0; key < 10; key++)
			fake_visit(&fake, key);
		check_coarse(&fake, 0);
		check_coarse(&fake, 1);
		struct going going = mark(&fake);
		change_to(&fake, 1, 200); /* committed, and still resident */
		fake_flush(&fake, 2);
		change_to(&fake, 2, 201); /* dirty */
		unsigned loads = fake.loads_begun;
		assert_int_equal(roll_back(&going), STATUS_OK);
		assert_true(going.told[2] && !going.told[1]);
		for (uint64_t key = 0; key < 10; key++) {
			assert_int_equal(going.dropped[key], key == 1 || key == 2);
			assert_int_equal(fake_resident(&fake, key), key != 1 && key != 2);
		}
		assert_true(going.coarse_dropped && !fake_resident(&fake, COARSE) && fake_resident(&fake, COARSE + 1));
		for (uint64_t key = 0; key < 10; key++)
			fake_visit(&fake, key);
		check_coarse(&fake, 0);
		check_coarse(&fake, 1);
		assert_int_equal(fake.loads_begun, loads + 3);
		fake_flush(&fake, 3);
		assert_int_equal(fake_stats(&fake).writebacks, 2); /* those before: nothing that was dropped */
		fake_finish(&fake);
	}
}

/* Changed, evicted, and loaded again from the queue: clean in its slot, and never committed. */
static void page_rollback_drops_what_was_loaded_from_the_queue(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 2);
	fake_start(&fake, &params);
	struct going going = mark(&fake);
	change_to(&fake, 0, 200);
	fake_push_out(&fake, 4, 10);
	change_to(&fake, 1, 201);
	fake.settle_after = 5; /* this one is being filled */
	fake_push_out(&fake, 4, 20);
	fake_visit(&fake, 0);
	assert_false(fake_resident(&fake, 1));
	/* The caller knows of commits alone. */
	fake.model[0] = going.mark[0];
	assert_int_equal(roll_back(&going), STATUS_OK);
	assert_true(going.dropped[0] && !fake_resident(&fake, 0));
	fake_visit(&fake, 0);
	fake_visit(&fake, 1);
	fake_flush(&fake, 2);
	assert_int_equal(fake_stats(&fake).writebacks, 0);
	fake_finish(&fake);
}

static void page_rollback_waits_for_the_commit_in_flight(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 2);
	struct fake_opener opener;
	params.queue_soft = 0;
	fake_start(&fake, &params);
	struct going going = mark(&fake);
	fake_gate(&fake, 0, true);
	change_to(&fake, 0, 200);
	fake.settle_after = 4; /* its read-back takes its time, too */
	fake_end_step(&fake, 2);
	change_to(&fake, 0, 201); /* dirty again meanwhile */
	fake_open_later(&opener, &fake, 0, 2);
	assert_int_equal(roll_back(&going), STATUS_OK);
	thread_join(&opener.thread);
	assert_int_equal(fake.commits_begun, 2);
	assert_int_equal(fake_stats(&fake).writebacks, 1);
	fake_visit(&fake, 0);
	fake_flush(&fake, 3);
	fake_finish(&fake);
}

/* The commit in flight ends early, is no failure, and nothing of it is lost if the rollback fails. */
static void page_rollback_gives_the_commit_in_flight_up(void **state)
{
	for (int fails = 0; fails < 2; fails++) {
		static struct fake fake;
		struct page_params params = fake_params(&fake, 4, 2);
		params.queue_soft = 0;
		fake_start(&fake, &params);
		struct going going = mark(&fake);
		fake.gives_up = true;
		fake_gate(&fake, 0, true);
		change_to(&fake, 0, 200);
		fake_end_step(&fake, 2);
		fake_await(&fake, 0, 2);
		going.fails = fails > 0;
		assert_int_equal(roll_back(&going), fails ? STATUS_FAILED : STATUS_OK);
		assert_int_equal(fake_stats(&fake).writebacks, 0);
		assert_false(page_cache_gives_up(fake.cache));
		fake_gate(&fake, 0, false);
		fake_visit(&fake, 0);
		fake_flush(&fake, 3);
		assert_int_equal(fake_stats(&fake).writebacks, fails);
		fake_finish(&fake);
	}
}

/* A load that had read the store before, or what waited, comes after. */
static void page_load_that_began_before_a_rollback_is_dropped(void **state)
{
	for (int coarse = 0; coarse < 2; coarse++)
		for (int committed = 0; committed < 2; committed++) {
			static struct fake fake;
			struct page_params params = fake_params(&fake, 4, 2);
			uint64_t requested = coarse ? COARSE : 0;
			fake_start(&fake, &params);
			struct going going = mark(&fake);
			change_to(&fake, 0, 200);
			if (committed)
				fake_flush(&fake, 2);
			fake_push_out(&fake, 4, 10);
			unsigned loads = fake.loads_begun;
			fake_gate(&fake, requested + 1, false);
			fake_end_step(&fake, 3);
			page_cache_want(fake.cache, (const uint64_t[]){requested, 30}, 2);
			fake_await(&fake, loads + 1, 0);
			assert_int_equal(roll_back(&going), STATUS_OK);
			assert_int_not_equal(page_cache_request_state(fake.cache), PAGE_REQUESTS_HERE);
			fake_gate(&fake, 0, false);
			fake_visit(&fake, 0);
			check_coarse(&fake, 0);
			fake_flush(&fake, 4);
			fake_finish(&fake);
		}
}

static void page_rollback_that_fails_loses_nothing(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 2);
	fake_start(&fake, &params);
	struct going going = mark(&fake);
	change_to(&fake, 0, 200);
	fake_push_out(&fake, 4, 10);
	change_to(&fake, 1, 201);
	going.fails = true;
	assert_int_equal(roll_back(&going), STATUS_FAILED);
	assert_true(going.told[0] && going.told[1]);
	fake_visit(&fake, 0);
	fake_visit(&fake, 1);
	going.fails = false;
	assert_int_equal(roll_back(&going), STATUS_OK); /* once more */
	fake_visit(&fake, 0);
	/* A commit that failed is told, and the store is not taken back. */
	change_to(&fake, 2, 202);
	fake.fail_commits = 1;
	const uint64_t record = 5;
	assert_int_equal(page_cache_flush(fake.cache, &record), STATUS_FAILED);
	going.calls = 0;
	assert_int_equal(roll_back(&going), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "disk is full"));
	assert_int_equal(going.calls, 0);
	fake_finish(&fake);
}

/* Every slot is free for others again, and so is every image. */
static void page_rollback_gives_all_slots_back(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 6, 2);
	fake_start(&fake, &params);
	struct going going = mark(&fake);
	for (uint64_t round = 0; round < 30; round++) {
		for (uint64_t i = 0; i < 8; i++)
			change_to(&fake, (round * 3 + i) % 16, 1000 + round * 100 + i);
		assert_int_equal(roll_back(&going), STATUS_OK);
		for (uint64_t key = 0; key < 16; key++)
			fake_visit(&fake, key);
	}
	assert_true(fake_stats(&fake).queue_peak <= 8);
	fake_finish(&fake);
}

TEST_PROGRAM(rollback)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(page_rollback_drops_what_changed_and_nothing_else),
		cmocka_unit_test(page_rollback_drops_what_was_loaded_from_the_queue),
		cmocka_unit_test(page_rollback_waits_for_the_commit_in_flight),
		cmocka_unit_test(page_rollback_gives_the_commit_in_flight_up),
		cmocka_unit_test(page_load_that_began_before_a_rollback_is_dropped),
		cmocka_unit_test(page_rollback_that_fails_loses_nothing),
		cmocka_unit_test(page_rollback_gives_all_slots_back),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
