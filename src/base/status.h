/*
 * Statuses, and the one message that goes with a failure.
 *
 * The code that detects an error writes the whole message, once: "WHAT: WHY; WHAT TO DO". All callers above only return the
 * status. Each thread has its own message. A worker that fails copies its message into a struct failure. The thread that
 * reports it restores it.
 */
#ifndef FURROW_BASE_STATUS_H
#define FURROW_BASE_STATUS_H

#include <stdarg.h>
#include <stddef.h>

enum status {
	STATUS_OK = 0,
	STATUS_FAILED = -1,      /* failed while running: exit 1 */
	STATUS_USAGE = -2,       /* wrong usage: exit 2 */
	STATUS_INPUT = -3,       /* bad input: missing, unreadable, corrupt, out of range: exit 3 */
	STATUS_NO_GL = -4,       /* no usable GL: exit 4 */
	STATUS_INTERRUPTED = -5, /* Ctrl-C: exit 130 */
};

#define FURROW_CHECKED __attribute__((warn_unused_result))

/*
 * Early return. A function that fails returns at once, so that what follows reads as what is done, not as what is done unless.
 *
 * TRY: the function holds nothing. A failure of `call` is returned.
 * TRY_MEM: the same where an allocation gave NULL. `got`: the pointer, or that all of several are there. `what`: of which it is memory.
 * TRY_OR: the function holds something. A failure of `call` goes to `label`. There the function lets go of all it holds, and returns its variable
 * `status`.
 */
#define TRY(call) \
	do { \
		const enum status tried_ = (call); \
		if (tried_ != STATUS_OK) \
			return tried_; \
	} while (0)
#define TRY_MEM(got, what) \
	do { \
		if (!(got)) \
			return fail_memory(what); \
	} while (0)
#define TRY_OR(label, call) \
	do { \
		status = (call); \
		if (status != STATUS_OK) \
			goto label; \
	} while (0)

#define FURROW_PRINTF(at, first) __attribute__((format(printf, at, first)))

/* A failure carried from one thread to another. */
struct failure {
	enum status status;
	char message[4096 + 512]; /* room for a long path and what is wrong with it */
};

/* Sets this thread's message and returns `status`, so that `return fail_with(...)` reads well. */
enum status fail_with(enum status status, const char *format, ...) FURROW_PRINTF(2, 3);
/* The same for a failed allocation of `what`. */
enum status fail_memory(const char *what);
/* This thread's last message; "" if there was none. Valid until the next fail_with() here. */
const char *failure_message(void);

void failure_capture(struct failure *failure, enum status status);
enum status failure_restore(const struct failure *failure);

/* 0, 1, 2, 3, 4 or 130: the command's exit status. */
int status_exit_code(enum status status);

/* Tells something that is no failure: one line on stderr, "furrow: note: ...", unless note_to() set a receiver. Any thread. */
void note(const char *format, ...) FURROW_PRINTF(1, 2);
/* Sets who gets the text of each note, without a newline, on the thread that tells it. NULL: stderr. For the whole process. */
void note_to(void (*take)(const char *text));

#endif
