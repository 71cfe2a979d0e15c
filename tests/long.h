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

/* A number that is another with each commit: the first eight digits of its hash, which tools/test.sh gives. Without them 0. */
static inline size_t commit_number(void)
{
	const char *commit = getenv("FURROW_COMMIT");
	return commit != NULL ? (size_t)strtoul(commit, NULL, 16) : 0;
}

/* Tests of many like cases take one of `part` of them, other ones with other commits, so that all come up in turn; in the long run all. */
static inline bool by_turn(size_t index, size_t part)
{
	return long_run() || (index + commit_number()) % part == 0;
}

/* Tests of many pairs take a part of them, so that each value of both comes up. */
static inline bool long_or_part(size_t one, size_t other, size_t part)
{
	return by_turn(one + other, part);
}

#endif
