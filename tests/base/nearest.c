/* The word that a mistyped one was meant to be, against a second, plain count of changes. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "base/nearest.h"
#include "../support/program.h"

static const char *found(const char *word)
{
	static const char *const words[] = {"import", "info", "export", "end_time", "time_step", "wheel", "dry_sand", "o", "load", "bekker_kc", "bekker_kphi"};
	struct nearest nearest = nearest_begin(word);
	for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
		nearest_offer(&nearest, words[i]);
	return nearest.found;
}

static void typing_errors_are_seen(void **state)
{
	assert_string_equal(found("exprt"), "export");
	assert_string_equal(found("improt"), "import");
	assert_string_equal(found("endtime"), "end_time");
	assert_string_equal(found("whel"), "wheel");
	assert_string_equal(found("weheel"), "wheel");
	assert_string_equal(found("drysand"), "dry_sand");
	assert_string_equal(found("laod"), "load");
	assert_string_equal(found("inof"), "info");
	assert_string_equal(found("bekker_kfi"), "bekker_kphi"); /* kc is as near, and ends otherwise */
	assert_string_equal(found("bekker_k"), "bekker_kc");
}

static void other_words_are_not_near(void **state)
{
	static const char *const others[] = {"", "x", "on", "lunar", "tyre", "resolution", "a_word_of_so_many_letters_that_no_word_can_be_near_it"};
	for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
		assert_null(found(others[i]));
}

/* By its definition: the fewest changes, tried one after another. */
static size_t plainly(const char *a, const char *b)
{
	if (*a == '\0' || *b == '\0')
		return strlen(a) + strlen(b);
	size_t best = plainly(a + 1, b + 1) + (*a != *b), other = plainly(a + 1, b) + 1;
	best = other < best ? other : best;
	other = plainly(a, b + 1) + 1;
	best = other < best ? other : best;
	if (a[1] != '\0' && b[1] != '\0' && a[0] == b[1] && a[1] == b[0]) {
		other = plainly(a + 2, b + 2) + 1;
		best = other < best ? other : best;
	}
	return best;
}

static void changes_are_counted_as_defined(void **state)
{
	uint32_t random = 7;
	for (int n = 0; n < 3000; n++) {
		char words[2][8] = {"", ""};
		for (int k = 0; k < 2; k++)
			for (int i = 0, length = (int)((random = random * 1664525 + 1013904223) >> 24) % 7; i < length; i++)
				words[k][i] = (char)('a' + ((random = random * 1664525 + 1013904223) >> 24) % 3);
		struct nearest nearest = nearest_begin(words[0]);
		nearest.changes = 100;
		nearest_offer(&nearest, words[1]);
		assert_int_equal(nearest.changes, plainly(words[0], words[1]));
	}
}

static void the_question_ends_a_message(void **state)
{
	struct nearest nearest = nearest_begin("exprt");
	assert_string_equal(nearest_ask(&nearest).text, "");
	nearest_offer(&nearest, "export");
	assert_string_equal(nearest_ask(&nearest).text, "; did you mean export?");
}

TEST_PROGRAM(nearest)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(typing_errors_are_seen),
		cmocka_unit_test(other_words_are_not_near),
		cmocka_unit_test(changes_are_counted_as_defined),
		cmocka_unit_test(the_question_ends_a_message),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
