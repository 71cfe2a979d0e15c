/*
 * Makes stdout a stream that shows text of files as it is safe for a terminal. All commands print through it, so none needs to know
 * which text came from a store or a scene: see base/plain.h.
 */
#define _GNU_SOURCE /* fopencookie */
#include "screen.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/plain.h"

struct screen {
	char held[4]; /* the first bytes of a character that was cut by the end of a write */
	size_t count;
};

static struct screen screen;

static bool put(const char *bytes, size_t size)
{
	while (size > 0) {
		const ssize_t written = write(STDOUT_FILENO, bytes, size);
		if (written < 0 && errno == EINTR)
			continue;
		if (written < 0)
			return false;
		bytes += written;
		size -= (size_t)written;
	}
	return true;
}

/* Writes what is shown of some bytes, and holds the rest. `last`: nothing follows. */
static bool show(char *bytes, size_t size, bool last)
{
	char *to = bytes;
	size_t at = 0;
	screen.count = 0;
	while (at < size) {
		bool odd, cut;
		const size_t length = plain_next(bytes + at, size - at, &odd, &cut);
		if (cut && !last && size - at < sizeof screen.held) {
			screen.count = size - at;
			memcpy(screen.held, bytes + at, screen.count);
			break;
		}
		if (odd)
			*to++ = '?';
		else
			to = (char *)memmove(to, bytes + at, length) + length;
		at += length;
	}
	return put(bytes, (size_t)(to - bytes));
}

static ssize_t take(void *user, const char *bytes, size_t size)
{
	char part[4096];
	(void)user;
	for (size_t done = 0; done < size;) {
		const size_t before = screen.count, room = sizeof part - before, more = size - done < room ? size - done : room;
		memcpy(part, screen.held, before);
		memcpy(part + before, bytes + done, more);
		if (!show(part, before + more, false))
			return 0; /* an error, as fopencookie has it */
		done += more;
	}
	return (ssize_t)size;
}

static int finish(void *user)
{
	char rest[sizeof screen.held];
	const size_t count = screen.count;
	(void)user;
	memcpy(rest, screen.held, count);
	return show(rest, count, true) ? 0 : EOF;
}

void screen_begin(void)
{
	FILE *stream = fopencookie(NULL, "w", (cookie_io_functions_t){.write = take, .close = finish});
	if (stream == NULL)
		return; /* out of memory: what follows tells */
	if (isatty(STDOUT_FILENO))
		setvbuf(stream, NULL, _IOLBF, BUFSIZ);
	fflush(stdout);
	stdout = stream;
}

void screen_put(const char *text)
{
	for (; *text != '\0'; text++)
		putchar(*text == '\n' || *text == '\t' ? ' ' : *text);
}
