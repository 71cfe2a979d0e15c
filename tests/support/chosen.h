/* Kills and power cuts: a run takes two cases of each file, chosen by the hash of the commit, so that all come up over some commits.
 * `sh tools/test.sh long` takes all. */
#ifndef FURROW_TESTS_SUPPORT_CHOSEN_H
#define FURROW_TESTS_SUPPORT_CHOSEN_H

#include "../long.h"
#include "skip.h"

/* Whether case `index` of `count` is one of the two; without a commit's hash the first two are. */
static inline bool chosen(size_t index, size_t count)
{
	return long_run() || (index + count - commit_number() % count) % count < 2;
}

#define chosen_or_skip(index, count)                                                               \
	do {                                                                                       \
		if (!chosen(index, count))                                                         \
			skip_since("for sh tools/test.sh long");                                   \
	} while (0)

#endif
