#include "base/status.h"

#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

#include "base/plain.h"

static _Thread_local char last_message[sizeof(((struct failure *)0)->message)];

enum status fail_with(enum status status, const char *format, ...)
{
	char text[sizeof last_message];
	va_list args;
	va_start(args, format);
	vsnprintf(text, sizeof text, format, args);
	va_end(args);
	/* The arguments may point into last_message itself, so it is copied. An error is one line. Nothing in it moves a
	 * terminal's cursor, whatever a file put into its text. */
	plain_line(text);
	memcpy(last_message, text, sizeof last_message);
	return status;
}

enum status fail_memory(const char *what)
{
	return fail_with(STATUS_FAILED, "%s: out of memory; free some memory or lower cache.slots", what);
}

const char *failure_message(void)
{
	return last_message;
}

void failure_capture(struct failure *failure, enum status status)
{
	failure->status = status;
	memcpy(failure->message, last_message, sizeof failure->message);
}

enum status failure_restore(const struct failure *failure)
{
	memcpy(last_message, failure->message, sizeof last_message);
	return failure->status;
}

int status_exit_code(enum status status)
{
	switch (status) {
	case STATUS_OK:
		return 0;
	case STATUS_FAILED:
		return 1;
	case STATUS_USAGE:
		return 2;
	case STATUS_INPUT:
		return 3;
	case STATUS_NO_GL:
		return 4;
	case STATUS_INTERRUPTED:
		return 130;
	}
	return 1;
}

static void (*_Atomic taker)(const char *text);

void note_to(void (*take)(const char *text))
{
	atomic_store(&taker, take);
}

void note(const char *format, ...)
{
	char text[512];
	va_list args;
	va_start(args, format);
	vsnprintf(text, sizeof text, format, args);
	va_end(args);
	plain_line(text);
	void (*take)(const char *text) = atomic_load(&taker);
	if (take != NULL)
		take(text);
	else
		fprintf(stderr, "furrow: note: %s\n", text);
}
