/* How furrow explain sets what it tells: see explain_layout.h. */
#include "explain_layout.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

enum { COLUMNS = 100, REASONS = 56 }; /* where reasons begin, where what is before leaves room */

void layout_row(const char *what, const char *why)
{
	int room = COLUMNS - (int)strlen(" <- ") - (int)strlen(why);
	while (strlen(what) > COLUMNS) { /* a program with many defines */
		int cut = COLUMNS;
		while (cut > 0 && what[cut] != ' ')
			cut--;
		if (cut == 0)
			break;
		printf("%.*s\n", cut, what);
		what += cut;
	}
	if ((int)strlen(what) > room)
		printf("%s\n%*s <- %s\n", what, REASONS, "", why);
	else
		printf("%-*s <- %s\n", REASONS < room ? REASONS : room, what, why);
}

struct layout_text layout_number(uint64_t number)
{
	struct layout_text out;
	char digits[24];
	size_t length = (size_t)snprintf(digits, sizeof digits, "%llu", (unsigned long long)number), to = 0;
	for (size_t i = 0; i < length; i++) {
		if (i > 0 && (length - i) % 3 == 0)
			out.text[to++] = ',';
		out.text[to++] = digits[i];
	}
	out.text[to] = '\0';
	return out;
}

struct layout_text layout_bytes(uint64_t bytes)
{
	static const char *const units[] = {"bytes", "KiB", "MiB", "GiB", "TiB"};
	double size = (double)bytes;
	size_t unit = 0;
	struct layout_text out;
	if (bytes < 10000)
		snprintf(out.text, sizeof out.text, "%.32s bytes", layout_number(bytes).text);
	while (bytes >= 10000 && size >= 999.5 && unit + 1 < sizeof units / sizeof *units) {
		size /= 1024;
		unit++;
	}
	if (bytes >= 10000)
		snprintf(out.text, sizeof out.text, "%.3g %s", size, units[unit]);
	return out;
}

void layout_wrapped(const char *text, int indent)
{
	int column = printf("  ");
	for (bool first = true; *text != '\0'; first = false) {
		int length = (int)strcspn(text, " ");
		if (!first && column + 1 + length > COLUMNS)
			column = printf("\n%*s", indent, "") - 1;
		else if (!first)
			column += printf(" ");
		column += printf("%.*s", length, text);
		text += length + strspn(text + length, " ");
	}
	putchar('\n');
}
