/*
 * Random steps against a model: whatever the slots, loaders and luck, a pin shows the newest bits,
 * a coarse page shows the newest bits below it, and each commit is the world at a step's end.
 */
#include "page/fake.h"

enum { STEPS = 1500, TAKE_MOST = 6 };

static uint64_t snapshots[STEPS + 1][FINE];

struct random {
	uint64_t state;
};

static uint32_t below(struct random *random, uint32_t bound)
{
	random->state = random->state * 6364136223846793005ull + 1442695040888963407ull;
	return (uint32_t)(random->state >> 33) % bound;
}

static void check_coarse(struct fake *fake, uint32_t slot)
{
	const struct content *coarse = &fake->slots[slot];
	const uint64_t *fine = &fake->model[(coarse->key - COARSE) * FAMILY];
	for (unsigned i = 0; i < FAMILY; i++)
		assert_int_equal(coarse->family[i], fine[i]);
}

/* Changed under a coarse page that is resident: the owner brings that up to date, as run does. */
static void change(struct fake *fake, uint64_t key, uint32_t slot)
{
	uint32_t coarse;
	fake->slots[slot].version = ++fake->model[key];
	page_cache_dirty(fake->cache, key);
	if (page_cache_peek(fake->cache, COARSE + key / FAMILY, false, &coarse))
		fake->slots[coarse].family[key % FAMILY] = fake->model[key];
}

/* Up to six pages, each once. */
static void wish(struct fake *fake, struct random *random)
{
	uint64_t keys[6], first = below(random, FINE - 12), coarse = below(random, FINE / FAMILY - 3);
	size_t count = below(random, 7);
	for (size_t i = 0; i < count; i++)
		keys[i] = i % 3 == 2 ? COARSE + coarse + i / 3 : first + 2 * i;
	page_cache_want(fake->cache, keys, count);
}

static enum status random_step(struct fake *fake, struct random *random, uint32_t slots)
{
	uint64_t keys[TAKE_MOST];
	uint32_t taken[TAKE_MOST], center = below(random, FINE);
	size_t count = 1 + below(random, slots < TAKE_MOST ? slots : TAKE_MOST);
	fake->settle_after = below(random, 4) == 0 ? below(random, 12) : 0;
	if (below(random, 3) != 0)
		wish(fake, random);
	for (size_t i = 0; i < count; i++)
		keys[i] = below(random, 4) == 0 ? COARSE + below(random, FINE / FAMILY)
						: (center + below(random, 12)) % FINE;
	enum status status = page_cache_pin_all(fake->cache, keys, count, taken);
	if (status != STATUS_OK)
		return status;
	for (size_t i = 0; i < count; i++) {
		assert_int_equal(fake->slots[taken[i]].key, keys[i]);
		fake->pins[taken[i]]++;
	}
	for (size_t i = 0; i < count; i++)
		if (keys[i] >= COARSE)
			check_coarse(fake, taken[i]);
		else
			assert_int_equal(fake->slots[taken[i]].version, fake->model[keys[i]]);
	for (size_t i = 0; i < count; i++)
		if (keys[i] < FINE && below(random, 2) == 0)
			change(fake, keys[i], taken[i]);
	for (size_t i = 0; i < count; i++) {
		fake->pins[taken[i]]--;
		page_cache_unpin(fake->cache, keys[i]);
	}
	return below(random, 3) == 0 ? page_cache_poll(fake->cache) : STATUS_OK;
}

static enum status end_step(struct fake *fake, uint64_t step)
{
	mutex_lock(&fake->mutex);
	memcpy(snapshots[step], fake->model, sizeof fake->model);
	mutex_unlock(&fake->mutex);
	return page_cache_end_step(fake->cache, &step);
}

static void run(uint64_t seed, uint32_t slots, uint32_t loaders, uint32_t soft, unsigned fail_after)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, slots, loaders);
	struct random random = {seed};
	enum status status = STATUS_OK;
	params.queue_soft = soft;
	params.queue_most = PAGE_QUEUE_MOST(soft, TAKE_MOST);
	fake_start(&fake, &params);
	fake.snapshots = (const uint64_t(*)[FINE])snapshots;
	fake.yields = 1 + below(&random, 8);
	uint64_t step = 0;
	while (step < STEPS && status == STATUS_OK) {
		if (fail_after != 0 && step == fail_after) {
			mutex_lock(&fake.mutex);
			fake.fail_commits = 1;
			mutex_unlock(&fake.mutex);
		}
		status = random_step(&fake, &random, slots);
		if (status == STATUS_OK)
			status = end_step(&fake, ++step);
	}
	if (fail_after == 0) {
		assert_int_equal(status, STATUS_OK);
		fake_flush(&fake, step);
	} else {
		assert_int_equal(page_cache_flush(fake.cache, &step), STATUS_FAILED);
		assert_string_equal(failure_message(), "store: disk is full; free some space");
	}
	struct page_stats stats = fake_stats(&fake);
	assert_true(stats.queue_peak <= params.queue_most);
	assert_int_equal(fake.images[PAGE_LOADED_IMAGE], page_load_images(loaders));
	fake_check_nothing_is_lost(&fake);
	fake_finish(&fake);
}

static void page_random_steps_agree_with_the_model(void **state)
{
	static const uint32_t slots[] = {4, 5, 7, 12, 33, 64}, soft[] = {0, 1, 5, 40};
	(void)state;
	uint64_t seed = 1;
	for (size_t i = 0; i < sizeof slots / sizeof *slots; i++)
		for (uint32_t loaders = 0; loaders <= 3; loaders++, seed++)
			run(seed, slots[i], loaders, soft[seed % 4], 0);
}

static void page_random_steps_lose_nothing_when_a_commit_fails(void **state)
{
	static const uint32_t slots[] = {4, 6, 16, 64};
	(void)state;
	uint64_t seed = 100;
	for (size_t i = 0; i < sizeof slots / sizeof *slots; i++)
		for (unsigned after = 1; after < 200; after += 60, seed++)
			run(seed, slots[i], 1 + (uint32_t)i % 3, (uint32_t)after % 7, after);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(page_random_steps_agree_with_the_model),
		cmocka_unit_test(page_random_steps_lose_nothing_when_a_commit_fails),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
