/*
 * A trial of the page cache: what there is by a seed, what must hold after every step, and what goes
 * wrong or comes late meanwhile. random.c says what a step does.
 */
#ifndef FURROW_TESTS_PAGE_TRIAL_H
#define FURROW_TESTS_PAGE_TRIAL_H

#include "page/fake.h"

#include <stdio.h>

enum { HELD_MOST = 4, WISHES_MOST = FINE, COARSES = FINE / FAMILY };
#define PATIENCE 2e-4 /* s the owner may stand still before a gate opens: it may be waiting for that */

/* Those that are sticky, once a trial; others come and go. */
enum fault { NO_FAULT, FAILED_COMMIT, FAILED_READ_BACK, FAILED_SETTLE };

struct held {
	uint64_t key;
	uint32_t slot;
};

struct trial {
	struct fake fake;
	struct page_params params;
	uint64_t seed, luck;
	uint64_t step;
	enum fault fault;
	uint64_t fault_step;
	bool running, gated;
	unsigned polls; /* of four chances to poll */
	struct held held[HELD_MOST];
	size_t held_count;
	uint64_t versions;   /* given so far: each once, so that what was rolled back is never taken for what came after */
	uint64_t mark[FINE]; /* what a rollback returns to */
	uint64_t rollbacks, dropped;
	uint64_t wishes[WISHES_MOST]; /* the last list */
	size_t wish_count;
	struct thread opener;
	uint64_t moved; /* by fake.mutex, and the next: steps so far */
	bool over;
};

static struct trial trial;

/* Numbers of neighbouring seeds have nothing in common. */
static inline uint32_t below(uint32_t bound)
{
	uint64_t mixed = trial.luck += 0x9e3779b97f4a7c15ull;
	mixed = (mixed ^ mixed >> 30) * 0xbf58476d1ce4e5b9ull;
	mixed = (mixed ^ mixed >> 27) * 0x94d049bb133111ebull;
	return (uint32_t)((mixed ^ mixed >> 31) >> 32) % bound;
}

static inline bool one_in(uint32_t count)
{
	return below(count) == 0;
}

static inline uint64_t some_key(uint32_t near)
{
	return one_in(4) ? COARSE + below(COARSES) : (near + below(12)) % FINE;
}

/* --- what must hold --- */

static inline void check_page(uint64_t key, uint32_t slot)
{
	const struct content *content = &trial.fake.slots[slot];
	assert_int_equal(content->key, key);
	if (key < FINE)
		assert_int_equal(content->version, trial.fake.model[key]);
	else
		assert_memory_equal(content->family, &trial.fake.model[(key - COARSE) * FAMILY],
				    sizeof content->family);
}

static inline void check_resident(void *user, uint64_t key, uint32_t slot, bool dirty)
{
	uint32_t *count = user;
	assert_true(slot < trial.params.slots);
	assert_true(key < FINE || !dirty);
	check_page(key, slot);
	++*count;
}

static inline void check_all(void)
{
	struct fake *fake = &trial.fake;
	uint32_t resident = 0, slot;
	page_cache_each_resident(fake->cache, check_resident, &resident);
	assert_true(resident <= trial.params.slots);
	for (size_t i = 0; i < trial.held_count; i++) {
		assert_true(page_cache_peek(fake->cache, trial.held[i].key, false, &slot));
		assert_int_equal(slot, trial.held[i].slot);
	}
	assert_int_equal(fake->images[PAGE_LOADED_IMAGE], page_load_images(trial.params.loaders));
	assert_true(fake->images[PAGE_CHANGED_IMAGE] <= trial.params.queue_most);
	assert_int_equal(fake_stats(fake).queue_peak, fake->images[PAGE_CHANGED_IMAGE]);
	enum page_request_state wishes = page_cache_request_state(fake->cache);
	if (trial.params.loaders == 0)
		assert_int_equal(wishes, PAGE_REQUESTS_HERE);
	else if (wishes == PAGE_REQUESTS_HERE)
		for (size_t i = 0; i < trial.wish_count; i++)
			assert_true(fake_resident(fake, trial.wishes[i]));
}

/* --- what fails --- */

/* Whether it is the trial's sticky failure, which ends it. */
static inline bool is_sticky(enum status status)
{
	static const struct {
		enum status status;
		const char *message;
	} faults[] = {
		[FAILED_COMMIT] = {STATUS_FAILED, "store: disk is full; free some space"},
		[FAILED_READ_BACK] = {STATUS_NO_GL, "GL: the context is lost; restart"},
		[FAILED_SETTLE] = {STATUS_NO_GL, "GL: the context is lost; restart"},
	};
	return trial.fault != NO_FAULT && trial.step >= trial.fault_step &&
	       status == faults[trial.fault].status &&
	       strcmp(failure_message(), faults[trial.fault].message) == 0;
}

static inline bool is_failed_upload(enum status status)
{
	return trial.fake.fail_upload != 0 && status == STATUS_NO_GL &&
	       strcmp(failure_message(), "GL: out of memory; lower cache.slots") == 0;
}

static inline enum status poll(void)
{
	enum status status = page_cache_poll(trial.fake.cache);
	return is_failed_upload(status) ? STATUS_OK : status;
}

/* A pin that failed for a load that did: it is of one of the keys; fails while they do, then no more. */
static inline enum status check_failed_load(const uint64_t *keys, size_t count)
{
	struct fake *fake = &trial.fake;
	int key;
	size_t at = 0;
	uint32_t slot;
	assert_int_equal(sscanf(failure_message(), "tile %d: checksum", &key), 1);
	while (at < count && keys[at] != (uint64_t)key)
		at++;
	assert_true(at < count);
	bool fails = (fake->fail_loads >> key % 64 & 1) != 0; /* the owner's to change */
	enum status status = page_cache_pin(fake->cache, keys[at], &slot);
	if (is_sticky(status))
		return status;
	if (is_failed_upload(status))
		return STATUS_OK;
	assert_int_equal(status, fails ? STATUS_INPUT : STATUS_OK);
	if (fails)
		return STATUS_OK;
	check_page(keys[at], slot);
	page_cache_unpin(fake->cache, keys[at]);
	return STATUS_OK;
}

static inline void stir(void)
{
	struct fake *fake = &trial.fake;
	if (one_in(4)) /* mostly little: each time it is asked in vain, the owner naps */
		fake->settle_after = !one_in(4) ? 0 : one_in(4) ? below(13) : below(3);
	if (one_in(40))
		trial.polls = below(5);
	if (one_in(50))
		fake->fail_upload = one_in(2) ? some_key(below(FINE)) + 1 : 0;
	if (trial.fault == FAILED_READ_BACK && trial.step == trial.fault_step)
		fake->fail_read_back = UINT64_MAX;
	if (trial.fault == FAILED_SETTLE && trial.step == trial.fault_step)
		fake->fail_settle = true;
	mutex_lock(&fake->mutex);
	if (trial.fault == FAILED_COMMIT && trial.step == trial.fault_step)
		fake->fail_commits = 1;
	if (one_in(20))
		fake->yields = below(8);
	if (one_in(25))
		fake->fail_loads = one_in(2) ? 1ull << below(64) | 1ull << below(64) | 1ull << below(64) : 0;
	if (trial.gated && one_in(10)) {
		fake->hold_load = one_in(3) ? 0 : one_in(8) ? UINT64_MAX : some_key(below(FINE)) + 1;
		fake->hold_commits = one_in(3);
		condition_wake_all(&fake->changed);
	}
	mutex_unlock(&fake->mutex);
}

/* Opens what is held once the owner stands still. */
static inline void *open_gates(void *argument)
{
	struct fake *fake = argument;
	mutex_lock(&fake->mutex);
	while (!trial.over) {
		if (fake->hold_load == 0 && !fake->hold_commits) {
			condition_wait(&fake->changed, &fake->mutex);
			continue;
		}
		uint64_t at = trial.moved;
		double since = clock_seconds();
		while (trial.moved == at && clock_seconds() - since < PATIENCE)
			condition_wait_for(&fake->changed, &fake->mutex, PATIENCE);
		if (trial.moved != at)
			continue;
		fake->hold_load = 0;
		fake->hold_commits = false;
		condition_wake_all(&fake->changed);
	}
	mutex_unlock(&fake->mutex);
	return NULL;
}

#endif
