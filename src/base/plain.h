/*
 * Text of files, as it is shown. A store, a scene or a table may hold characters that move a terminal's cursor, change its title, or
 * turn the direction of writing. Such characters are odd here, and are not shown: control characters (C0, DEL, C1) and those that
 * set a direction. A new line and a tab are not odd.
 */
#ifndef FURROW_BASE_PLAIN_H
#define FURROW_BASE_PLAIN_H

#include <stdbool.h>
#include <stddef.h>

/* Returns how many bytes the character at `at` has, of the `left` that there are. *odd: it is not shown. *cut: the bytes end within it,
 * so that more are needed to know; may be NULL. */
size_t plain_next(const char *at, size_t left, bool *odd, bool *cut);
/* Makes one line of a text: odd characters become '?' or a space, and so do new lines and tabs. The text becomes no longer. */
void plain_line(char *text);

#endif
