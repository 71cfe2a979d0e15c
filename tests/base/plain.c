/* Text of files as it is shown: no character of it moves a cursor. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdlib.h>
#include <string.h>

#include "base/base.h"
#include "base/json.h"
#include "base/plain.h"
#include "../support/program.h"

static void a_line_has_no_odd_characters(void **state)
{
	static const char *const lines[][2] = {
		{"plain", "plain"},
		{"", ""},
		{"a\nb\tc", "a b c"},
		{"\x1b]0;title\x07", " ]0;title "},
		{"\x1b[2J\x7f", " [2J "},
		{"\xc2\x9b" "2J", "?2J"},                         /* CSI, a C1 control */
		{"\x9b" "2J", "?2J"},                             /* the same in Latin-1 */
		{"a\xe2\x80\xae" "b\xe2\x81\xa6" "c\xd8\x9c", "a?b?c?"}, /* right to left */
		{"a\xe2\x80\xa8" "b", "a?b"},                     /* a line separator */
		{"Gr\xc3\xb6\xc3\x9f" "e \xe2\x82\xac \xf0\x9f\x98\x80", "Gr\xc3\xb6\xc3\x9f" "e \xe2\x82\xac \xf0\x9f\x98\x80"},
		{"\xe4\xb8\x80", "\xe4\xb8\x80"}, /* its later bytes alone would be C1 */
		{"cut \xe2\x80", "cut \xe2\x80"},
		{"\xfc", "\xfc"}, /* Latin-1 */
	};
	for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
		char text[64];
		strcpy(text, lines[i][0]);
		plain_line(text);
		assert_string_equal(text, lines[i][1]);
		(void)fail_with(STATUS_INPUT, "%s", lines[i][0]);
		assert_string_equal(failure_message(), lines[i][1]);
	}
}

static char noted[64];

static void take(const char *text)
{
	strcpy(noted, text);
}

static void notes_are_lines(void **state)
{
	note_to(take);
	note("a%sb", "\x1b[2J\n");
	note_to(NULL);
	assert_string_equal(noted, "a [2J b");
}

static void json_escapes_them(void **state)
{
	static const char odd[] = "a\x1b\x7f\xc2\x9b\xe2\x80\xae\xe4\xb8\x80";
	cJSON *root = cJSON_CreateString(odd);
	char *text = json_text(root);
	assert_string_equal(text, "\"a\\u001b\\u007f\\u009b\\u202e\xe4\xb8\x80\"");
	cJSON *again = cJSON_Parse(text);
	assert_string_equal(again->valuestring, odd);
	cJSON_Delete(again);
	cJSON_Delete(root);
	cJSON_free(text);
}

TEST_PROGRAM(plain)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_line_has_no_odd_characters),
		cmocka_unit_test(notes_are_lines),
		cmocka_unit_test(json_escapes_them),
	};
	return cmocka_run_group_tests_name("base/plain", tests, NULL, NULL);
}
