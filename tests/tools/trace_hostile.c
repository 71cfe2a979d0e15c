/* Traces that are cut, damaged or made up: each is refused with what is wrong, and none is believed beyond its bytes. */
#include <xxhash.h>

#include "traces.h"
#include "../support/program.h"

/* --- bytes by hand --- */

static void put_number(struct bytes *bytes, uint64_t value)
{
	for (; value > 127; value /= 128)
		bytes->at[bytes->size++] = (uint8_t)(128 + value % 128);
	bytes->at[bytes->size++] = (uint8_t)value;
}

static void put_whole(struct bytes *bytes, uint64_t value, int count)
{
	for (; count > 0; count--, value >>= 8)
		bytes->at[bytes->size++] = (uint8_t)value;
}

static struct bytes header(uint32_t version)
{
	struct bytes bytes = {.size = 8};
	memcpy(bytes.at, "furrowPT", 8);
	put_whole(&bytes, version, 4);
	return bytes;
}

static void put_end(struct bytes *bytes, uint64_t accesses, uint64_t tiles)
{
	put_number(bytes, 1);
	put_whole(bytes, accesses, 8);
	put_whole(bytes, tiles, 8);
	put_whole(bytes, XXH3_64bits(bytes->at, bytes->size), 8);
}

/* A copy of just that size, so that a read past it is seen. */
static enum status parse(const struct bytes *bytes, size_t size, struct sim_accesses *accesses)
{
	uint8_t *copy = malloc(size);
	if (size > 0)
		memcpy(copy, bytes->at, size);
	enum status status = sim_accesses_parse("t", copy, size, accesses);
	free(copy);
	return status;
}

static void refused(const struct bytes *bytes, const char *why)
{
	struct sim_accesses accesses;
	assert_int_equal(parse(bytes, bytes->size, &accesses), STATUS_INPUT);
	if (strstr(failure_message(), why) == NULL)
		fail_msg("%s: says nothing of: %s", failure_message(), why);
	assert_null(accesses.tiles);
}

/* --- tests --- */

static void page_trace_cut_anywhere_is_refused(void **state)
{
	struct bytes bytes = small_trace();
	struct sim_accesses accesses;
	(void)state;
	assert_int_equal(parse(&bytes, bytes.size, &accesses), STATUS_OK);
	sim_accesses_finish(&accesses);
	for (size_t size = 0; size < bytes.size; size++) {
		assert_int_equal(parse(&bytes, size, &accesses), STATUS_INPUT);
		assert_non_null(strstr(failure_message(), size < 8 ? "is no trace" : "cut short"));
	}
}

static void page_trace_with_any_bit_changed_is_refused(void **state)
{
	struct bytes bytes = small_trace();
	struct sim_accesses accesses;
	(void)state;
	for (size_t bit = 0; bit < 8 * bytes.size; bit++) {
		bytes.at[bit / 8] ^= (uint8_t)(1 << bit % 8);
		assert_int_equal(parse(&bytes, bytes.size, &accesses), STATUS_INPUT);
		bytes.at[bit / 8] ^= (uint8_t)(1 << bit % 8);
	}
}

/* Each is the only thing wrong: the checksum is right. */
static void page_trace_says_what_is_wrong(void **state)
{
	struct bytes bytes = header(2);
	(void)state;
	put_end(&bytes, 0, 0);
	refused(&bytes, "version 2");

	bytes = header(1);
	put_number(&bytes, 0);
	put_whole(&bytes, 77, 8);
	put_number(&bytes, 2 << 3);
	put_whole(&bytes, 78, 8);
	put_end(&bytes, 2, 2);
	refused(&bytes, "a tile that has not come yet");

	bytes = header(1);
	put_number(&bytes, 0);
	put_whole(&bytes, 77, 8);
	put_number(&bytes, 1 << 3);
	put_whole(&bytes, 77, 8);
	put_end(&bytes, 2, 2);
	refused(&bytes, "comes as a new one");

	bytes = header(1);
	put_number(&bytes, 0);
	put_whole(&bytes, UINT64_C(1) << 62, 8);
	put_end(&bytes, 1, 1);
	refused(&bytes, "a key that no tile has");

	bytes = header(1);
	memset(bytes.at + bytes.size, 0xff, 9);
	bytes.size += 9;
	put_number(&bytes, 2);
	put_end(&bytes, 0, 0);
	refused(&bytes, "more than 64 bits");

	bytes = header(1);
	put_number(&bytes, (uint64_t)INT64_MAX << 1 | 1);
	put_number(&bytes, 1 << 1 | 1);
	put_end(&bytes, 0, 0);
	refused(&bytes, "a step beyond any");

	for (unsigned more = 0; more < 2; more++) {
		bytes = header(1);
		put_number(&bytes, 0);
		put_whole(&bytes, 77, 8);
		put_end(&bytes, 1 + more, 2 - more);
		refused(&bytes, "the accesses and tiles it says");
	}

	bytes = header(1);
	put_end(&bytes, 0, 0);
	put_number(&bytes, 1);
	refused(&bytes, "something follows");
}

static void check_sane(const struct sim_accesses *accesses)
{
	uint64_t counted = 0;
	for (int kind = 0; kind < PAGE_ACCESS_KINDS; kind++)
		counted += accesses->hits[kind] + accesses->misses[kind];
	assert_int_equal(counted, accesses->count);
	for (size_t i = 0; i < accesses->count; i++) {
		assert_true(accesses->tiles[i] < accesses->tile_count);
		assert_true(i == 0 || accesses->steps[i - 1] <= accesses->steps[i]);
	}
	for (uint32_t i = 0; i < accesses->tile_count; i++)
		for (uint32_t j = 0; j < i; j++)
			assert_true(accesses->keys[i] != accesses->keys[j]);
}

/* Hostile files that know the checksum: read or refused, never believed beyond their bytes. */
static void page_trace_survives_whatever_is_in_it(void **state)
{
	struct bytes whole = small_trace();
	unsigned taken = 0;
	(void)state;
	for (int round = 0; round < 60000; round++) {
		struct bytes bytes = whole;
		struct sim_accesses accesses;
		bytes.size -= 8;
		if (round % 2 == 0) {
			bytes = header(1);
			for (uint64_t records = draw(30); records > 0; records--)
				bytes.at[bytes.size++] = (uint8_t)(draw(3) == 0 ? draw(256) : draw(16));
			put_number(&bytes, 1);
			put_whole(&bytes, draw(20), 8);
			put_whole(&bytes, draw(3), 8);
		}
		for (uint64_t changes = draw(4); changes > 0; changes--)
			bytes.at[PAGE_TRACE_HEADER + draw(bytes.size - PAGE_TRACE_HEADER)] = (uint8_t)draw(256);
		put_whole(&bytes, XXH3_64bits(bytes.at, bytes.size), 8);
		enum status status = parse(&bytes, bytes.size, &accesses);
		assert_true(status == STATUS_OK || status == STATUS_INPUT);
		if (status != STATUS_OK)
			continue;
		taken++;
		check_sane(&accesses);
		sim_accesses_finish(&accesses);
	}
	assert_true(taken > 1000);
}

static void page_trace_that_is_none_is_refused(void **state)
{
	struct sim_accesses accesses;
	(void)state;
	assert_int_equal(sim_accesses_read(in_folder("absent"), &accesses), STATUS_INPUT);
	assert_int_equal(sim_accesses_read(folder, &accesses), STATUS_INPUT);
	write_file(in_folder("text"), "time,obj_id\n1,2\n", 16);
	assert_int_equal(sim_accesses_read(in_folder("text"), &accesses), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "is no trace"));
}

TEST_PROGRAM(trace_hostile)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup_teardown(page_trace_cut_anywhere_is_refused, enter, leave),
		cmocka_unit_test_setup_teardown(page_trace_with_any_bit_changed_is_refused, enter, leave),
		cmocka_unit_test_setup_teardown(page_trace_says_what_is_wrong, enter, leave),
		cmocka_unit_test_setup_teardown(page_trace_survives_whatever_is_in_it, enter, leave),
		cmocka_unit_test_setup_teardown(page_trace_that_is_none_is_refused, enter, leave),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
