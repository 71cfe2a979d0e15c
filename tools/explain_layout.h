/* How furrow explain sets what it tells on a page of 100 columns. */
#ifndef FURROW_TOOLS_EXPLAIN_LAYOUT_H
#define FURROW_TOOLS_EXPLAIN_LAYOUT_H

#include <stdint.h>

struct layout_text {
	char text[48];
};
struct layout_text layout_number(uint64_t number); /* 1234567: "1,234,567" */
struct layout_text layout_bytes(uint64_t bytes);   /* three places: "4.26 MiB" */

/* Prints one line of a section: what, and why in a column to its right; two lines where they do not fit. */
void layout_row(const char *what, const char *why);
/* Prints words from column 2 on; lines that follow the first begin at column `indent`. */
void layout_wrapped(const char *text, int indent);

#endif
