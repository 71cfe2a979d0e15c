/* A test that skips says why. The run fails for it, unless the reason begins with SKIP_ELSEWHERE (tests/summary.py). */
#ifndef FURROW_TESTS_SUPPORT_SKIP_H
#define FURROW_TESTS_SUPPORT_SKIP_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

/* Begins the reason where tools/packages.sh does not install what is missing, so that the run may pass: a file of a person's own, a
 * device, another driver. A machine without OpenGL is not among them: packages.sh installs Mesa's. */
#define SKIP_ELSEWHERE "not on this machine: "

/* Ends the test as skipped, and prints the reason: a string literal. */
#define skip_since(reason)                                                                         \
	do {                                                                                       \
		print_message("skipped '%s'\n", reason);                                           \
		skip();                                                                            \
	} while (0)

#endif
