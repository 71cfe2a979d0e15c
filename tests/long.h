/* What runs in `sh tools/test.sh long` alone, since it costs much for what it finds. */
#ifndef FURROW_TESTS_LONG_H
#define FURROW_TESTS_LONG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>

static inline bool long_run(void)
{
	return getenv("FURROW_LONG") != NULL;
}

/* Tests of many pairs take a part of them, so that each value of both comes up; in the long run all of them. */
static inline bool long_or_part(size_t one, size_t other, size_t part)
{
	return long_run() || (one + other) % part == 0;
}

#endif
