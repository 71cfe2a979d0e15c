/*
 * Random steps against a model: whatever the slots, loaders, faults and luck, every resident page shows
 * the newest bits (a coarse one those below it), each commit is the world at a step's end, what fails
 * is told, and nothing is lost.
 *
 * A seed is a trial of up to STEPS steps: how many slots and loaders, what a step does, what fails and
 * when, what is late. Threads add their own luck. Others, and more, by hand:
 *
 *     PAGE_SEED=1000 PAGE_STEPS=1000000 build-test/tests/test_page random
 */
#include "page/trial.h"

#include <stdlib.h>

#include "page/page_internal.h"
#include "../support/program.h"

enum { STEPS = 2000, TAKE_MOST = 6, ROUNDS_MOST = 3, STEP_PAGES = ROUNDS_MOST * TAKE_MOST + HELD_MOST };
#define STEPS_IN_ALL 30000

static uint64_t snapshots[STEPS + 1][FINE];

/* --- what a step does --- */

/* Nothing, few, more than there are slots, or the same again; each key once. */
static void wish(void)
{
	if (one_in(4)) {
		page_cache_want(trial.fake.cache, trial.wishes, trial.wish_count);
		return;
	}
	uint32_t first = below(FINE), stride = 1 + 2 * below(4), coarse = below(COARSES), coarses = 0;
	trial.wish_count = one_in(8) ? 0 : one_in(6) ? below(WISHES_MOST) : below(8);
	for (uint32_t i = 0; i < trial.wish_count; i++)
		trial.wishes[i] = coarses < COARSES && one_in(4) ? COARSE + (coarse + coarses++) % COARSES
								 : (first + stride * i) % FINE;
	page_cache_want(trial.fake.cache, trial.wishes, trial.wish_count);
}

static void draw(void)
{
	uint32_t near = below(FINE), slot;
	for (uint32_t i = below(8); i > 0; i--) {
		uint64_t key = some_key(near);
		if (page_cache_peek(trial.fake.cache, key, true, &slot))
			check_page(key, slot);
	}
}

/* Changed under a coarse page that is resident: the owner brings that up to date, as run does. */
static void change(uint64_t key, uint32_t slot)
{
	struct fake *fake = &trial.fake;
	uint32_t coarse;
	fake->slots[slot].version = fake->model[key] = 100 + ++trial.versions;
	page_cache_dirty(fake->cache, key);
	if (page_cache_peek(fake->cache, COARSE + key / FAMILY, false, &coarse))
		fake->slots[coarse].family[key % FAMILY] = fake->model[key];
}

static void let_go(uint64_t key, uint32_t slot)
{
	trial.fake.pins[slot]--;
	page_cache_unpin(trial.fake.cache, key);
}

/* Slots that must be there for a pin of the keys. */
static uint32_t needed(const uint64_t *keys, size_t count)
{
	uint64_t all[HELD_MOST + TAKE_MOST];
	uint32_t different = 0;
	for (size_t i = 0; i < trial.held_count + count; i++) {
		uint64_t key = i < trial.held_count ? trial.held[i].key : keys[i - trial.held_count];
		uint32_t at = 0;
		while (at < different && all[at] != key)
			at++;
		if (at == different)
			all[different++] = key;
	}
	return different;
}

static enum status visit(void)
{
	struct fake *fake = &trial.fake;
	uint64_t keys[TAKE_MOST];
	uint32_t slots[TAKE_MOST], near = below(FINE);
	size_t count = 1 + below(TAKE_MOST);
	for (size_t i = 0; i < count; i++)
		keys[i] = some_key(near);
	while (needed(keys, count) > trial.params.slots && !one_in(8))
		if (--count == 0)
			return STATUS_OK;
	bool fits = needed(keys, count) <= trial.params.slots;
	enum status status = page_cache_pin_all(fake->cache, keys, count, slots);
	if (is_sticky(status))
		return status;
	if (!fits) {
		assert_int_equal(status, STATUS_FAILED);
		assert_non_null(strstr(failure_message(), "raise cache.slots to at least"));
		return STATUS_OK;
	}
	if (status == STATUS_INPUT)
		return check_failed_load(keys, count);
	if (is_failed_upload(status))
		return STATUS_OK;
	if (status != STATUS_OK)
		return status;
	for (size_t i = 0; i < count; i++) {
		check_page(keys[i], slots[i]);
		fake->pins[slots[i]]++;
	}
	for (size_t i = 0; i < count; i++)
		if (keys[i] < FINE && one_in(2))
			change(keys[i], slots[i]);
	for (size_t i = 0; i < count; i++)
		if (trial.held_count < HELD_MOST && one_in(20))
			trial.held[trial.held_count++] = (struct held){keys[i], slots[i]};
		else
			let_go(keys[i], slots[i]);
	return STATUS_OK;
}

static enum status random_step(void)
{
	enum status status = STATUS_OK;
	stir();
	for (uint32_t rounds = 1 + below(ROUNDS_MOST); rounds > 0 && status == STATUS_OK; rounds--) {
		if (one_in(2))
			wish();
		if (one_in(3))
			draw();
		status = visit();
		if (status == STATUS_OK && below(4) < trial.polls)
			status = poll();
	}
	for (size_t i = 0; i < trial.held_count && status == STATUS_OK; i++) {
		if (trial.held[i].key < FINE && one_in(3))
			change(trial.held[i].key, trial.held[i].slot);
		if (!one_in(8))
			continue;
		let_go(trial.held[i].key, trial.held[i].slot);
		trial.held[i--] = trial.held[--trial.held_count];
	}
	return status;
}

static void check_stored(void)
{
	mutex_lock(&trial.fake.mutex);
	assert_memory_equal(trial.fake.store, trial.fake.model, sizeof trial.fake.store);
	mutex_unlock(&trial.fake.mutex);
}

/* --- marks and rollbacks --- */

static enum status mark(void)
{
	enum status status = page_cache_flush(trial.fake.cache, &trial.step);
	if (status != STATUS_OK)
		return status;
	check_stored();
	memcpy(trial.mark, trial.fake.model, sizeof trial.mark);
	return STATUS_OK;
}

/* Now and then it fails. */
static enum status back(void *user)
{
	struct fake *fake = &trial.fake;
	if (one_in(4))
		return fail_with(STATUS_INPUT, "the store does not go back");
	mutex_lock(&fake->mutex);
	memcpy(fake->store, trial.mark, sizeof fake->store);
	mutex_unlock(&fake->mutex);
	return STATUS_OK;
}

/* Also some that did not, as a caller may who knows it no better. */
static bool changed(void *user, uint64_t key)
{
	const uint64_t *model = trial.fake.model;
	bool same = key < FINE ? model[key] == trial.mark[key]
			       : memcmp(&model[(key - COARSE) * FAMILY], &trial.mark[(key - COARSE) * FAMILY],
					FAMILY * sizeof *model) == 0;
	return !same || one_in(30);
}

static void dropped(void *user, uint64_t key)
{
	assert_false(fake_resident(&trial.fake, key));
	trial.dropped++;
}

static enum status roll_back(void)
{
	struct fake *fake = &trial.fake;
	const struct page_rollback rollback = {.back = back, .changed = changed, .dropped = dropped};
	while (trial.held_count > 0) {
		trial.held_count--;
		let_go(trial.held[trial.held_count].key, trial.held[trial.held_count].slot);
	}
	enum status status = page_cache_rollback(fake->cache, &rollback);
	if (status == STATUS_INPUT)
		return STATUS_OK;
	if (status != STATUS_OK)
		return status;
	memcpy(fake->model, trial.mark, sizeof fake->model);
	mutex_lock(&fake->mutex);
	memcpy(snapshots[trial.step], fake->model, sizeof fake->model); /* the step ends as the mark was */
	mutex_unlock(&fake->mutex);
	trial.rollbacks++;
	check_all();
	if (one_in(3))
		check_stored();
	return STATUS_OK;
}

static enum status end_step(void)
{
	struct fake *fake = &trial.fake;
	enum status status = STATUS_OK;
	trial.step++;
	mutex_lock(&fake->mutex);
	memcpy(snapshots[trial.step], fake->model, sizeof fake->model);
	trial.moved++;
	mutex_unlock(&fake->mutex);
	if (one_in(150)) {
		status = page_cache_flush(fake->cache, &trial.step);
		if (status == STATUS_OK)
			check_stored();
	}
	if (status == STATUS_OK && one_in(60))
		status = mark();
	if (status == STATUS_OK)
		status = page_cache_end_step(fake->cache, &trial.step);
	return status == STATUS_OK && one_in(40) ? roll_back() : status;
}

/* --- a trial --- */

static void begin(uint64_t seed)
{
	static const char *const faults[] = {"no", "a commit's", "a read-back's", "the executor's"};
	struct fake *fake = &trial.fake;
	memset(&trial, 0, sizeof trial);
	trial.seed = seed;
	trial.luck = seed << 32;
	trial.running = true;
	uint32_t soft = one_in(2) ? below(6) : below(41);
	trial.params = fake_params(fake, 2 + (one_in(3) ? below(63) : below(10)), (uint32_t)(seed % 5));
	trial.params.queue_soft = soft;
	trial.params.queue_most = PAGE_QUEUE_MOST(soft, STEP_PAGES);
	trial.params.queue_few = one_in(2) ? 1 + below(trial.params.queue_most) : 0;
	if (one_in(2))
		trial.params.executor.snapshot = fake_snapshot;
	trial.fault = one_in(3) ? (enum fault)(1 + below(3)) : NO_FAULT;
	trial.fault_step = below(STEPS);
	trial.gated = one_in(2);
	trial.polls = below(5);
	print_message("seed %llu: %u slots, %u loaders, queue of %u, %s gates, %s failure at step %u\n",
		      (unsigned long long)seed, trial.params.slots, trial.params.loaders, soft,
		      trial.gated ? "with" : "no", faults[trial.fault], (unsigned)trial.fault_step);
	fflush(NULL);
	fake_start(fake, &trial.params);
	fake->snapshots = (const uint64_t(*)[FINE])snapshots;
	memcpy(trial.mark, fake->model, sizeof trial.mark);
	assert_int_equal(thread_start(&trial.opener, open_gates, fake, "opener"), STATUS_OK);
}

/* Everything that was begun comes to its end; `wishes`: they too. */
static void come_to_rest(bool wishes)
{
	struct fake *fake = &trial.fake;
	fake->fail_upload = 0;
	fake->fail_settle = false;
	fake_gate(fake, 0, false);
	while (trial.held_count > 0) {
		const struct held *held = &trial.held[--trial.held_count];
		let_go(held->key, held->slot);
	}
	for (bool busy = true; busy;) {
		enum status status = page_cache_poll(fake->cache);
		assert_true(status == STATUS_OK || is_sticky(status));
		mutex_lock(&fake->cache->mutex);
		busy = fake->cache->commit != PAGE_COMMIT_NONE || fake->cache->queue.filling > 0;
		mutex_unlock(&fake->cache->mutex);
		busy |= wishes && page_cache_request_state(fake->cache) == PAGE_REQUESTS_COMING;
		sched_yield();
	}
}

static void check_end(void)
{
	struct fake *fake = &trial.fake;
	uint32_t slot;
	fake_gate(fake, 0, false);
	enum status status = page_cache_flush(fake->cache, &trial.step);
	if (trial.fault != NO_FAULT && status != STATUS_OK) {
		assert_true(is_sticky(status));
		assert_true(is_sticky(page_cache_end_step(fake->cache, &trial.step)));
		assert_true(is_sticky(page_cache_pin(fake->cache, 0, &slot)));
		assert_true(is_sticky(page_cache_poll(fake->cache)));
		come_to_rest(false);
		assert_true(is_sticky(page_cache_flush(fake->cache, &trial.step)));
	} else {
		assert_int_equal(status, STATUS_OK);
		check_stored();
		assert_int_equal(page_cache_end_step(fake->cache, &trial.step), STATUS_OK);
		come_to_rest(true);
	}
	check_all();
	fake_check_nothing_is_lost(fake);
}

/* Returns the steps taken. */
static uint64_t try_seed(uint64_t seed)
{
	struct fake *fake = &trial.fake;
	begin(seed);
	enum status status = STATUS_OK;
	while (trial.step < STEPS && status == STATUS_OK) {
		status = random_step();
		if (status == STATUS_OK)
			status = end_step();
		check_all();
	}
	assert_true(status == STATUS_OK || is_sticky(status));
	check_end();
	mutex_lock(&fake->mutex);
	trial.over = true;
	condition_wake_all(&fake->changed);
	mutex_unlock(&fake->mutex);
	thread_join(&trial.opener);
	fake_finish(fake);
	trial.running = false;
	return trial.step;
}

static uint64_t number(const char *name, uint64_t otherwise)
{
	const char *text = getenv(name);
	return text != NULL ? strtoull(text, NULL, 10) : otherwise;
}

static void page_random_steps_agree_with_the_model(void **state)
{
	uint64_t steps = 0, rollbacks = 0, dropped_in_all = 0, seed = number("PAGE_SEED", 1), all = number("PAGE_STEPS", STEPS_IN_ALL);
	(void)state;
	for (; steps < all; seed++) {
		steps += try_seed(seed);
		rollbacks += trial.rollbacks;
		dropped_in_all += trial.dropped;
	}
	print_message("%llu steps, %llu rollbacks that dropped %llu pages\n", (unsigned long long)steps,
		      (unsigned long long)rollbacks, (unsigned long long)dropped_in_all);
}

static int say_which(void **state)
{
	(void)state;
	if (trial.running)
		print_error("again: PAGE_SEED=%llu PAGE_STEPS=1; it failed in step %llu\n",
			    (unsigned long long)trial.seed, (unsigned long long)trial.step + 1);
	return 0;
}

TEST_PROGRAM(random)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_teardown(page_random_steps_agree_with_the_model, say_which),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
