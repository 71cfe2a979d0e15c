/*
 * The simulated policies against second ones written for being plain: pages in arrays in the order of
 * their queues, every rule as it is said, nothing shared. OPT also against every choice there is.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "sim/sim.h"
#include "../support/program.h"

enum { ACCESSES_MOST = 6000, TILES_MOST = 400 };

static uint32_t asked[ACCESSES_MOST];

/* --- an array in the order of a queue: the oldest first --- */

struct row {
	uint32_t pages[TILES_MOST];
	int uses[TILES_MOST];
	int count;
};

static int find(const struct row *row, uint32_t page)
{
	for (int i = 0; i < row->count; i++)
		if (row->pages[i] == page)
			return i;
	return -1;
}

static void drop(struct row *row, int at)
{
	row->count--;
	memmove(&row->pages[at], &row->pages[at + 1], (size_t)(row->count - at) * sizeof *row->pages);
	memmove(&row->uses[at], &row->uses[at + 1], (size_t)(row->count - at) * sizeof *row->uses);
}

static void append(struct row *row, uint32_t page, int uses)
{
	row->pages[row->count] = page;
	row->uses[row->count++] = uses;
}

static struct row rows[4];
static double target;
static bool evicted, in_b1, in_b2;
static int ghost_hit_at;

/* --- the second ones: true for a hit --- */

static bool plain_lru(int slots, int i)
{
	int at = find(&rows[0], asked[i]);
	if (at >= 0)
		drop(&rows[0], at);
	else if (rows[0].count == slots)
		drop(&rows[0], 0);
	append(&rows[0], asked[i], 0);
	return at >= 0;
}

static bool plain_clock(int slots, int i)
{
	struct row *row = &rows[0];
	int at = find(row, asked[i]);
	if (at >= 0) {
		row->uses[at] = row->uses[at] + 1 < 1 ? row->uses[at] + 1 : 1;
		return true;
	}
	while (row->count + 1 > slots) {
		while (row->uses[0] >= 1) {
			uint32_t page = row->pages[0];
			int uses = row->uses[0] - 1;
			drop(row, 0);
			append(row, page, uses);
		}
		drop(row, 0);
	}
	append(row, asked[i], 0);
	return false;
}

static void plain_arc_replace(void)
{
	struct row *t1 = &rows[0], *t2 = &rows[1];
	bool first = (t1->count > 0 && (t1->count > target || (t1->count == target && in_b2))) || t2->count == 0;
	struct row *from = first ? t1 : t2, *to = first ? &rows[2] : &rows[3];
	append(to, from->pages[0], 0);
	drop(from, 0);
}

static bool plain_arc(int slots, int i)
{
	struct row *t1 = &rows[0], *t2 = &rows[1], *b1 = &rows[2], *b2 = &rows[3];
	uint32_t page = asked[i];
	int where = -1;
	for (int row = 0; row < 4; row++)
		if (find(&rows[row], page) >= 0)
			where = row;
	if (where >= 0) {
		in_b1 = where == 2;
		in_b2 = where == 3;
		if (in_b1 || in_b2)
			ghost_hit_at = i;
		double one = b1->count, two = b2->count;
		if (in_b1) {
			double delta = two / one > 1 ? two / one : 1;
			target = target + delta < slots ? target + delta : slots;
		}
		if (in_b2) {
			double delta = one / two > 1 ? one / two : 1;
			target = target - delta > 0 ? target - delta : 0;
		}
		drop(&rows[where], find(&rows[where], page));
		if (where < 2) {
			append(t2, page, 0);
			return true;
		}
	}
	bool ghost = ghost_hit_at == i && (in_b1 || in_b2);
	while (t1->count + t2->count + 1 > slots) {
		if (ghost) {
			plain_arc_replace();
		} else if (t1->count + b1->count + 1 > slots) {
			if (b1->count > 0) {
				drop(b1, 0);
				plain_arc_replace();
			} else {
				drop(t1, 0);
			}
		} else {
			if (t1->count + b1->count + t2->count + b2->count >= 2 * slots && b2->count > 0)
				drop(b2, 0);
			plain_arc_replace();
		}
	}
	append(ghost ? t2 : t1, page, 0);
	if (ghost)
		in_b1 = in_b2 = false;
	return false;
}

static void plain_s3fifo_evict(int slots, int small_size, int ghost_size)
{
	struct row *small = &rows[0], *main_row = &rows[1], *ghost = &rows[2];
	evicted = true;
	if (main_row->count > slots - small_size || small->count == 0) {
		while (main_row->count > 0) {
			uint32_t page = main_row->pages[0];
			int uses = main_row->uses[0];
			drop(main_row, 0);
			if (uses < 1)
				return;
			append(main_row, page, (uses < 3 ? uses : 3) - 1);
		}
		return;
	}
	while (small->count > 0) {
		uint32_t page = small->pages[0];
		int uses = small->uses[0];
		drop(small, 0);
		if (uses >= 2) {
			append(main_row, page, 0);
			continue;
		}
		if (find(ghost, page) < 0 && ghost_size > 0) {
			if (ghost->count == ghost_size)
				drop(ghost, 0);
			append(ghost, page, 0);
		}
		return;
	}
}

static bool plain_s3fifo(int slots, int i)
{
	struct row *small = &rows[0], *main_row = &rows[1], *ghost = &rows[2];
	int small_size = slots / 10, ghost_size = slots * 9 / 10; /* in whole numbers */
	uint32_t page = asked[i];
	int at = find(small, page);
	if (at >= 0) {
		small->uses[at]++;
		return true;
	}
	bool remembered = (at = find(ghost, page)) >= 0;
	if (remembered)
		drop(ghost, at);
	at = find(main_row, page);
	if (at >= 0) {
		main_row->uses[at]++;
		return true;
	}
	if (1 > small_size)
		return false;
	while (small->count + main_row->count + 1 > slots)
		plain_s3fifo_evict(slots, small_size, ghost_size);
	if (remembered)
		append(main_row, page, 0);
	else if (1 >= small_size)
		return false;
	else if (!evicted && small->count >= small_size)
		append(main_row, page, 0);
	else
		append(small, page, 0);
	return false;
}

static int accesses_now;

static int next_use(uint32_t page, int after)
{
	int i = after + 1;
	while (i < accesses_now && asked[i] != page)
		i++;
	return i;
}

static bool plain_opt(int slots, int i)
{
	struct row *row = &rows[0];
	if (find(row, asked[i]) >= 0)
		return true;
	if (row->count == slots) {
		int last = 0;
		for (int at = 1; at < row->count; at++)
			if (next_use(row->pages[at], i) > next_use(row->pages[last], i))
				last = at;
		drop(row, last);
	}
	append(row, asked[i], 0);
	return false;
}

static uint64_t plain(enum sim_policy policy, int slots)
{
	static bool (*const policies[SIM_POLICIES])(int, int) = {plain_lru, plain_clock, plain_arc, plain_s3fifo,
								  plain_opt};
	uint64_t misses = 0;
	memset(rows, 0, sizeof rows);
	target = 0;
	evicted = in_b1 = in_b2 = false;
	ghost_hit_at = -1;
	for (int i = 0; i < accesses_now; i++)
		misses += !policies[policy](slots, i);
	return misses;
}

/* --- traces --- */

static uint64_t chance = 0x9e3779b97f4a7c15u;

static uint32_t draw(uint32_t below)
{
	chance ^= chance << 13;
	chance ^= chance >> 7;
	chance ^= chance << 17;
	return (uint32_t)(chance >> 20) % below;
}

enum shape { UNIFORM, LOOP, SKEWED, SCAN, WALK, PHASES, SHAPES };

/* What a tile's number is here need not be the order in which it comes. */
static void make(enum shape shape, int count, uint32_t tiles)
{
	uint32_t at = draw(tiles), base = 0;
	accesses_now = count;
	for (int i = 0; i < count; i++) {
		uint32_t page = 0;
		switch (shape) {
		case UNIFORM: page = draw(tiles); break;
		case LOOP: page = (uint32_t)i % tiles; break;
		case SKEWED: page = draw(1 + draw(1 + draw(tiles))); break;
		case SCAN: page = i % 7 == 0 ? (uint32_t)(i / 7) % tiles : draw(1 + tiles / 8); break;
		case WALK: at = (at + tiles + draw(3) - 1) % tiles; page = draw(9) == 0 ? draw(tiles) : at; break;
		default: base = draw(200) == 0 ? draw(tiles) : base; page = (base + draw(1 + tiles / 4)) % tiles; break;
		}
		asked[i] = page;
	}
}

static enum status go_on(void *user, int64_t done, int64_t total)
{
	int64_t *seen = user;
	assert_true(done >= *seen && done <= total);
	*seen = done;
	return STATUS_OK;
}

static void simulate(enum sim_policy policy, uint32_t tiles, const uint32_t *slots, size_t count, uint64_t *misses)
{
	uint64_t *steps = calloc((size_t)accesses_now + 1, sizeof *steps), *keys = calloc(tiles, sizeof *keys);
	struct sim_accesses accesses = {
		.count = (size_t)accesses_now, .tiles = asked, .steps = steps, .tile_count = tiles, .keys = keys};
	int64_t seen = 0;
	assert_int_equal(sim_misses(&accesses, policy, slots, count, go_on, &seen, misses), STATUS_OK);
	free(steps);
	free(keys);
}

static const uint32_t sizes[] = {1, 2, 3, 4, 5, 8, 10, 15, 19, 20, 21, 27, 30, 40, 55, 64, 99, 128, 200, 399, 400, 1000};
enum { SIZES = sizeof sizes / sizeof *sizes };

static void same_as_plain(enum sim_policy policy, int count)
{
	for (int shape = 0; shape < SHAPES; shape++)
		for (uint32_t tiles = 1; tiles <= TILES_MOST; tiles = tiles * 3 + 1) {
			uint64_t misses[SIZES];
			make((enum shape)shape, count, tiles);
			simulate(policy, tiles, sizes, SIZES, misses);
			for (int i = 0; i < SIZES; i++) {
				uint64_t expected = plain(policy, (int)sizes[i]);
				if (misses[i] != expected)
					fail_msg("shape %d, %u tiles, %u slots: %d misses, should be %d", shape, tiles, sizes[i],
						 (int)misses[i], (int)expected);
			}
		}
}

/* --- tests --- */

static void sim_lru_is_the_plain_one(void **state)
{
	(void)state;
	same_as_plain(SIM_LRU, ACCESSES_MOST);
}

static void sim_clock_is_the_plain_one(void **state)
{
	(void)state;
	same_as_plain(SIM_CLOCK, ACCESSES_MOST);
}

static void sim_arc_is_the_plain_one(void **state)
{
	(void)state;
	same_as_plain(SIM_ARC, ACCESSES_MOST);
}

static void sim_s3fifo_is_the_plain_one(void **state)
{
	(void)state;
	same_as_plain(SIM_S3FIFO, ACCESSES_MOST);
}

static void sim_opt_is_the_plain_one(void **state)
{
	(void)state;
	same_as_plain(SIM_OPT, 1200);
}

/* The fewest misses from access i on with `resident` in, a bit a tile, over every victim there is. */
static int fewest[20][1 << 6];

static int best(int i, unsigned resident, int slots)
{
	if (i == accesses_now)
		return 0;
	unsigned bit = 1u << asked[i];
	int *known = &fewest[i][resident];
	if (*known >= 0)
		return *known;
	if ((resident & bit) != 0)
		return *known = best(i + 1, resident, slots);
	if (__builtin_popcount(resident) < slots)
		return *known = 1 + best(i + 1, resident | bit, slots);
	int least = accesses_now + 1;
	for (unsigned victim = 1; victim <= resident; victim <<= 1)
		if ((resident & victim) != 0) {
			int misses = 1 + best(i + 1, (resident & ~victim) | bit, slots);
			least = misses < least ? misses : least;
		}
	return *known = least;
}

static void sim_opt_misses_least_of_every_choice_there_is(void **state)
{
	const uint32_t few[] = {1, 2, 3, 4, 5, 6};
	(void)state;
	for (int round = 0; round < 400; round++) {
		uint64_t misses[6];
		make((enum shape)(round % SHAPES), 8 + (int)draw(12), 2 + draw(5));
		simulate(SIM_OPT, 6, few, 6, misses);
		for (int i = 0; i < 6; i++) {
			memset(fewest, -1, sizeof fewest);
			assert_int_equal(misses[i], best(0, 0, (int)few[i]));
		}
	}
}

/* Worked by hand. */
static void sim_small_cases(void **state)
{
	static const struct {
		const char *trace;
		uint32_t slots;
		uint64_t misses[SIM_POLICIES]; /* LRU, CLOCK, ARC, S3-FIFO, OPT */
	} cases[] = {
		{"", 2, {0, 0, 0, 0, 0}},
		{"a", 1, {1, 1, 1, 1, 1}},
		{"abab", 1, {4, 4, 4, 4, 4}},
		{"abcabcabc", 2, {9, 9, 9, 9, 6}},
		/* LRU drops a for c, the others spare it. */
		{"aabcab", 2, {5, 4, 4, 6, 4}},
		/* ARC: the second b comes from B1, so that the target is 1 and a goes to B2 for it; a comes from there. */
		{"abacabad", 2, {5, 5, 6, 8, 5}},
		/* S3-FIFO: 2 in the small queue, the next 18 in the main one at once. */
		{"abcdefghijklmnopqrst", 20, {20, 20, 20, 20, 20}},
		{"abcdefghijklmnopqrstabcdefghijklmnopqrst", 20, {20, 20, 20, 20, 20}},
	};
	(void)state;
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		accesses_now = (int)strlen(cases[i].trace);
		for (int n = 0; n < accesses_now; n++)
			asked[n] = (uint32_t)(cases[i].trace[n] - 'a');
		for (int policy = 0; policy < SIM_POLICIES; policy++) {
			uint64_t misses;
			simulate((enum sim_policy)policy, 26, &cases[i].slots, 1, &misses);
			if (misses != cases[i].misses[policy])
				fail_msg("%s, policy %d: %d misses", cases[i].trace, policy, (int)misses);
		}
	}
}

static enum status stop(void *user, int64_t done, int64_t total)
{
	int *left = user;
	return --*left > 0 ? STATUS_OK : fail_with(STATUS_INTERRUPTED, "stopped");
}

static void sim_stops_when_told(void **state)
{
	const uint32_t slots[] = {4, 8, 16};
	(void)state;
	make(UNIFORM, 100, 20);
	uint64_t steps[100] = {0}, keys[20] = {0}, misses[3];
	struct sim_accesses accesses = {.count = 100, .tiles = asked, .steps = steps, .tile_count = 20, .keys = keys};
	for (int policy = 0; policy < SIM_POLICIES; policy++) {
		int left = policy == SIM_LRU ? 1 : 2;
		assert_int_equal(sim_misses(&accesses, (enum sim_policy)policy, slots, 3, stop, &left, misses),
				 STATUS_INTERRUPTED);
		assert_int_equal(left, 0);
	}
}

static void sim_without_memory_says_so(void **state)
{
	const uint32_t slots[] = {4, 8};
	(void)state;
	make(UNIFORM, 100, 20);
	uint64_t steps[100] = {0}, keys[20] = {0}, misses[2];
	struct sim_accesses accesses = {.count = 100, .tiles = asked, .steps = steps, .tile_count = 20, .keys = keys};
	for (int policy = 0; policy < SIM_POLICIES; policy++) {
		enum status status = STATUS_FAILED;
		for (uint64_t nth = 1; status != STATUS_OK; nth++) {
			int64_t seen = 0;
			mem_fail_nth(nth, 0);
			status = sim_misses(&accesses, (enum sim_policy)policy, slots, 2, go_on, &seen, misses);
			mem_fail_nth(0, 0);
			assert_true(nth < 10 && (status == STATUS_FAILED || nth > 2));
		}
	}
}

TEST_PROGRAM(sim)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(sim_lru_is_the_plain_one),
		cmocka_unit_test(sim_clock_is_the_plain_one),
		cmocka_unit_test(sim_arc_is_the_plain_one),
		cmocka_unit_test(sim_s3fifo_is_the_plain_one),
		cmocka_unit_test(sim_opt_is_the_plain_one),
		cmocka_unit_test(sim_opt_misses_least_of_every_choice_there_is),
		cmocka_unit_test(sim_small_cases),
		cmocka_unit_test(sim_stops_when_told),
		cmocka_unit_test(sim_without_memory_says_so),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
