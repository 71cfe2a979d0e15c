/*
 * Parts of a run and their gathering: whatever tiles go from part to part, and wherever the run ends, the gathered overlay has the rows
 * of one that got the same commits itself.
 */
#include "parts.h"

static char base[256];

static void assert_same_record(const char *path, const char *copy)
{
	struct store *one = open_store(path, STORE_READ), *other = open_store(copy, STORE_READ);
	struct store_run runs[2];
	assert_ok(store_last_run(one, &runs[0]));
	assert_ok(store_last_run(other, &runs[1]));
	assert_string_equal(runs[0].scene_hash, runs[1].scene_hash);
	assert_string_equal(runs[0].state, runs[1].state);
	assert_string_equal(runs[0].what, runs[1].what);
	assert_int_equal(runs[0].step, runs[1].step);
	assert_true(runs[0].time == runs[1].time);
	store_close(one);
	store_close(other);
}

/* Gathers a run. Some parts may be one commit ahead. Afterwards it is as the copy, and gathering it again changes nothing. */
static void gathers_as_the_copy(uint32_t count, uint32_t seed, int ruts, int steps, uint32_t ahead, unsigned carried)
{
	struct run run = run_make(base, count, seed, ruts);
	struct store_commit_result result, again;
	struct store *over = open_store(run.over, STORE_READ);
	int64_t before = over->commit;
	store_close(over);
	run.field.carried = carried;
	run_open(&run);
	for (int i = 0; i < steps; i++)
		run_step(&run, count, true);
	if (ahead > 0)
		run_step(&run, ahead, false);
	for (uint32_t i = 0; i < count; i++)
		verified(run.stores[i]);
	run_close(&run);
	assert_ok(run_gather(&run, count, steps, &result));
	assert_int_equal(result.commit, steps > 0 ? before + 1 : 0);
	uint64_t hash = hash_at(run.over);
	if (hash != hash_at(run.copy))
		fail_msg("%u parts, seed %u, %d ruts, %d steps, %u ahead: not the ground of the same commits in one overlay", count, seed, ruts, steps,
			 ahead);
	if (steps > 0)
		assert_same_record(run.over, run.copy);
	assert_ok(run_gather(&run, count > 1 ? count - 1 : 1, steps, &again));
	assert_int_equal(again.commit, result.commit);
	assert_true(hash_at(run.over) == hash);
	run_free(&run);
}

static void parts_gather_to_what_one_overlay_would_have(void **state)
{
	static const uint32_t counts[] = {1, 2, 3, 8};
	for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
		for (uint32_t seed = 0; seed < 3; seed++)
			gathers_as_the_copy(counts[i], 100 * counts[i] + seed, seed == 0 ? 0 : 3, 5, seed == 2 ? counts[i] / 2 : 0, SEVERAL);
}

static void a_run_that_ends_early_is_gathered(void **state)
{
	for (int steps = 0; steps < 3; steps++)
		for (uint32_t ahead = 0; ahead < 3; ahead++)
			gathers_as_the_copy(3, 7 * (uint32_t)steps + ahead, steps, steps, ahead, SEVERAL);
}

/* Its pages drop the soil's state of an earlier drive, and what tiles beside them share with it. */
static void a_run_without_the_soils_state_drops_what_is_there(void **state)
{
	const unsigned fewer[] = {PLANE_BIT(PLANE_OFFSET), PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DISTURBANCE),
				  SEVERAL & ~PLANE_BIT(PLANE_SHEAR)};
	for (uint32_t i = 0; i < 6; i++)
		gathers_as_the_copy(2 + i % 2, 300 + i, 1 + (int)i % 2, 1 + (int)i % 3, i % 2, fewer[i % 3]);
}

static int enter(void **state)
{
	int failed = folder_make(state);
	snprintf(base, sizeof base, "%s/base.furrow", folder);
	make_store(base);
	return failed;
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(parts_gather_to_what_one_overlay_would_have),
		cmocka_unit_test(a_run_that_ends_early_is_gathered),
		cmocka_unit_test(a_run_without_the_soils_state_drops_what_is_there),
	};
	return cmocka_run_group_tests(tests, enter, folder_remove);
}
