/* Traces: what is noted comes back, nothing half-made is left, and nothing but traces is replaced. */
#include <sys/resource.h>
#include <sys/stat.h>

#include "traces.h"
#include "../support/program.h"

static int files_there(void)
{
	char command[96], line[16];
	snprintf(command, sizeof command, "ls -A '%s' | wc -l", folder);
	FILE *pipe = popen(command, "r");
	assert_non_null(fgets(line, sizeof line, pipe));
	pclose(pipe);
	return atoi(line);
}

/* --- tests --- */

enum { MANY = 300000, TILES = 5000 };

static void page_trace_gives_back_what_was_noted(void **state)
{
	static uint64_t keys[MANY], steps[MANY];
	static uint8_t flags[MANY];
	static bool seen[TILES];
	struct page_trace *trace;
	struct sim_accesses accesses;
	uint64_t step = 0, counts[4] = {0}, distinct = 0;
	(void)state;
	memset(seen, 0, sizeof seen);
	assert_int_equal(page_trace_create(in_folder("a"), &trace), STATUS_OK);
	for (int i = 0; i < MANY; i++) {
		step += draw(100) == 0 ? draw(2) == 0 ? 1 : draw(UINT32_MAX) : 0;
		uint64_t tile = draw(1 + draw(TILES));
		distinct += !seen[tile];
		seen[tile] = true;
		keys[i] = (UINT64_C(1) << 62) - 1 - tile * 0x1234567;
		steps[i] = step;
		flags[i] = (uint8_t)draw(4);
		counts[flags[i]]++;
		page_trace_access(trace, step, keys[i], flags[i] & 1 ? PAGE_ACCESS_DRAW : PAGE_ACCESS_PIN,
				  (flags[i] & 2) != 0);
	}
	assert_int_equal(page_trace_status(trace), STATUS_OK);
	assert_int_equal(access(in_folder("a"), F_OK), -1); /* not before it is whole */
	assert_int_equal(page_trace_publish(trace), STATUS_OK);
	page_trace_destroy(trace);
	assert_int_equal(files_there(), 1);
	assert_int_equal(sim_accesses_read(in_folder("a"), &accesses), STATUS_OK);
	assert_int_equal(accesses.count, MANY);
	assert_int_equal(accesses.tile_count, distinct);
	uint32_t next = 0;
	for (int i = 0; i < MANY; i++) {
		assert_true(accesses.tiles[i] <= next); /* in the order in which they come */
		next += accesses.tiles[i] == next;
		assert_int_equal(accesses.keys[accesses.tiles[i]], keys[i]);
		assert_int_equal(accesses.steps[i], steps[i]);
	}
	assert_int_equal(accesses.misses[PAGE_ACCESS_PIN], counts[0]);
	assert_int_equal(accesses.misses[PAGE_ACCESS_DRAW], counts[1]);
	assert_int_equal(accesses.hits[PAGE_ACCESS_PIN], counts[2]);
	assert_int_equal(accesses.hits[PAGE_ACCESS_DRAW], counts[3]);
	sim_accesses_finish(&accesses);
}

static void page_trace_takes_two_bytes_an_access_of_a_few_hundred_tiles(void **state)
{
	struct page_trace *trace;
	struct stat found;
	(void)state;
	assert_int_equal(page_trace_create(in_folder("a"), &trace), STATUS_OK);
	for (uint64_t i = 0; i < 100000; i++)
		page_trace_access(trace, i / 100, draw(400), PAGE_ACCESS_PIN, true);
	assert_int_equal(page_trace_publish(trace), STATUS_OK);
	page_trace_destroy(trace);
	assert_int_equal(stat(in_folder("a"), &found), 0);
	assert_true(found.st_size < 2 * 100000 + 1000 + 8 * 400 + 100);
}

static void page_trace_of_nothing_is_whole(void **state)
{
	struct page_trace *trace;
	struct sim_accesses accesses;
	(void)state;
	assert_int_equal(page_trace_create(in_folder("a"), &trace), STATUS_OK);
	assert_int_equal(page_trace_publish(trace), STATUS_OK);
	page_trace_destroy(trace);
	assert_int_equal(sim_accesses_read(in_folder("a"), &accesses), STATUS_OK);
	assert_int_equal(accesses.count, 0);
	sim_accesses_finish(&accesses);
}

static void page_trace_replaces_traces_only(void **state)
{
	struct page_trace *trace;
	struct bytes before = small_trace();
	(void)state;
	write_file(in_folder("text"), "a store, say", 12);
	assert_int_equal(page_trace_create(in_folder("text"), &trace), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "is no trace"));
	assert_int_equal(read_file(in_folder("text")).size, 12);
	write_file(in_folder("new.part"), "a letter", 8);
	assert_int_equal(page_trace_create(in_folder("new"), &trace), STATUS_FAILED);
	assert_int_equal(read_file(in_folder("new.part")).size, 8);
	assert_int_equal(remove(in_folder("new.part")), 0);
	assert_int_equal(page_trace_create(folder, &trace), STATUS_FAILED);
	assert_int_equal(page_trace_create(in_folder("no/where"), &trace), STATUS_FAILED);
	/* One that is given up leaves the older one as it was. */
	assert_int_equal(page_trace_create(in_folder("small"), &trace), STATUS_OK);
	page_trace_access(trace, 1, 2, PAGE_ACCESS_PIN, false);
	page_trace_destroy(trace);
	struct bytes after = read_file(in_folder("small"));
	assert_int_equal(after.size, before.size);
	assert_memory_equal(after.at, before.at, after.size);
	assert_int_equal(files_there(), 2);
	/* What a killed drive left is written over. */
	write_file(in_folder("small.part"), before.at, 100);
	assert_int_equal(page_trace_create(in_folder("small"), &trace), STATUS_OK);
	assert_int_equal(page_trace_publish(trace), STATUS_OK);
	page_trace_destroy(trace);
	assert_int_equal(files_there(), 2);
	struct sim_accesses accesses;
	assert_int_equal(sim_accesses_read(in_folder("small"), &accesses), STATUS_OK);
	assert_int_equal(accesses.count, 0);
	sim_accesses_finish(&accesses);
}

static void page_trace_has_one_writer(void **state)
{
	struct page_trace *trace, *second;
	(void)state;
	assert_int_equal(page_trace_create(in_folder("a"), &trace), STATUS_OK);
	page_trace_access(trace, 1, 2, PAGE_ACCESS_PIN, false);
	assert_int_equal(page_trace_create(in_folder("a"), &second), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "another drive"));
	assert_int_equal(page_trace_publish(trace), STATUS_OK);
	page_trace_destroy(trace);
	struct sim_accesses accesses;
	assert_int_equal(sim_accesses_read(in_folder("a"), &accesses), STATUS_OK);
	assert_int_equal(accesses.count, 1);
	sim_accesses_finish(&accesses);
}

/* A file of 16 tiles, each once in 16 accesses, one byte an access, and what comes before and after. */
enum { FULL = 200000, FULL_BYTES = PAGE_TRACE_HEADER + FULL + 16 * 8 + 1 + 3 * 8 };

/* The file may not grow beyond so many bytes: at the first, in the middle, at the last ones, and just so. */
static void page_trace_on_a_full_disk_says_so_and_leaves_nothing(void **state)
{
	const rlim_t limits[] = {5, 1 << 16, (1 << 16) + 100, FULL_BYTES - 25, FULL_BYTES - 1, FULL_BYTES};
	struct rlimit before;
	(void)state;
	assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
	for (size_t i = 0; i < sizeof limits / sizeof *limits; i++) {
		struct page_trace *trace = NULL;
		struct rlimit limit = {limits[i], before.rlim_max};
		assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
		enum status created = page_trace_create(in_folder("a"), &trace);
		assert_int_equal(created, STATUS_OK);
		for (uint64_t n = 0; n < FULL; n++)
			page_trace_access(trace, 0, n % 16, PAGE_ACCESS_PIN, true);
		enum status status = page_trace_status(trace);
		enum status published = page_trace_publish(trace);
		char message[512];
		snprintf(message, sizeof message, "%s", failure_message());
		enum status again = published != STATUS_OK ? page_trace_publish(trace) : published;
		page_trace_destroy(trace);
		assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
		if (limits[i] == FULL_BYTES) {
			assert_int_equal(published, STATUS_OK);
			continue;
		}
		assert_int_equal(status, i < 3 ? STATUS_FAILED : STATUS_OK);
		assert_int_equal(published, STATUS_FAILED);
		assert_int_equal(again, STATUS_FAILED);
		assert_non_null(strstr(message, "File too large"));
		assert_non_null(strstr(message, in_folder("a")));
		assert_int_equal(files_there(), 0);
	}
}

static void page_trace_without_memory_says_so_and_leaves_nothing(void **state)
{
	(void)state;
	bool failed = true;
	for (uint64_t nth = 1; failed; nth++) {
		struct page_trace *trace = NULL;
		struct sim_accesses accesses;
		mem_fail_nth(nth, 0);
		enum status status = page_trace_create(in_folder("a"), &trace);
		for (uint64_t i = 0; status == STATUS_OK && i < 2000; i++)
			page_trace_access(trace, 0, i, PAGE_ACCESS_PIN, false);
		if (status == STATUS_OK)
			status = page_trace_publish(trace);
		page_trace_destroy(trace);
		assert_int_equal(access(in_folder("a"), F_OK), status == STATUS_OK ? 0 : -1);
		if (status == STATUS_OK)
			status = sim_accesses_read(in_folder("a"), &accesses);
		mem_fail_nth(0, 0);
		failed = status != STATUS_OK;
		if (!failed)
			sim_accesses_finish(&accesses);
		unlink(in_folder("a"));
		assert_int_equal(files_there(), 0);
		assert_true(nth < 100 && (failed || nth > 12));
	}
}

static void page_cache_notes_every_access(void **state)
{
	static struct fake fake;
	struct page_params params = fake_params(&fake, 4, 1);
	struct sim_accesses accesses;
	const uint64_t keys[] = {5, 7}, expected[] = {5, 7, 5, 9, 7, 6}, steps[] = {0, 0, 0, 0, 1, 1};
	uint32_t slots[2], slot;
	(void)state;
	assert_int_equal(page_trace_create(in_folder("a"), &params.trace), STATUS_OK);
	fake_start(&fake, &params);
	assert_int_equal(page_cache_pin_all(fake.cache, keys, 2, slots), STATUS_OK);
	page_cache_unpin(fake.cache, 5);
	page_cache_unpin(fake.cache, 7);
	fake_visit(&fake, 5);
	assert_false(page_cache_peek(fake.cache, 9, true, &slot));
	assert_false(page_cache_peek(fake.cache, 10, false, &slot)); /* none: nobody uses it */
	fake_end_step(&fake, 1);
	assert_true(page_cache_peek(fake.cache, 7, true, &slot));
	fake.fail_load = 6 + 1;
	assert_int_equal(page_cache_pin(fake.cache, 6, &slot), STATUS_INPUT); /* asked for all the same */
	struct page_stats stats = fake_stats(&fake);
	fake_finish(&fake);
	assert_int_equal(page_trace_publish(params.trace), STATUS_OK);
	page_trace_destroy(params.trace);
	assert_int_equal(sim_accesses_read(in_folder("a"), &accesses), STATUS_OK);
	assert_int_equal(accesses.count, 6);
	for (int i = 0; i < 6; i++) {
		assert_int_equal(accesses.keys[accesses.tiles[i]], expected[i]);
		assert_int_equal(accesses.steps[i], steps[i]);
	}
	assert_int_equal(accesses.hits[PAGE_ACCESS_PIN], stats.hits);
	assert_int_equal(accesses.misses[PAGE_ACCESS_PIN], stats.misses);
	assert_int_equal(stats.hits, 1);
	assert_int_equal(accesses.hits[PAGE_ACCESS_DRAW], 1);
	assert_int_equal(accesses.misses[PAGE_ACCESS_DRAW], 1);
	sim_accesses_finish(&accesses);
}

TEST_PROGRAM(trace)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup_teardown(page_trace_gives_back_what_was_noted, enter, leave),
		cmocka_unit_test_setup_teardown(page_trace_takes_two_bytes_an_access_of_a_few_hundred_tiles, enter, leave),
		cmocka_unit_test_setup_teardown(page_trace_of_nothing_is_whole, enter, leave),
		cmocka_unit_test_setup_teardown(page_trace_replaces_traces_only, enter, leave),
		cmocka_unit_test_setup_teardown(page_trace_has_one_writer, enter, leave),
		cmocka_unit_test_setup_teardown(page_trace_on_a_full_disk_says_so_and_leaves_nothing, enter, leave),
		cmocka_unit_test_setup_teardown(page_trace_without_memory_says_so_and_leaves_nothing, enter, leave),
		cmocka_unit_test_setup_teardown(page_cache_notes_every_access, enter, leave),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
