/*
 * A histogram of durations, of fixed size. So a drive of hours needs no more memory than a drive of seconds. Count, mean,
 * smallest and largest are exact. The relative error of a percentile is at most TIMES_ERROR. One thread; no allocation.
 */
#ifndef FURROW_RUN_TIMES_H
#define FURROW_RUN_TIMES_H

#include <stdint.h>

enum { TIMES_OCTAVES = 40, TIMES_PARTS = 128 };

#define TIMES_ERROR (0.5 / TIMES_PARTS) /* relative */
/* Limits of values, in ms (61 ns and 18 hours). A value outside is counted as the nearer limit. */
#define TIMES_LEAST 0x1p-14
#define TIMES_MOST (TIMES_LEAST * (double)((uint64_t)1 << TIMES_OCTAVES))

/* An empty histogram is all zero. */
struct times {
	uint64_t count;
	double sum, least, most; /* ms */
	uint64_t buckets[TIMES_OCTAVES * TIMES_PARTS];
};

void times_add(struct times *times, double ms); /* below 0 counts as 0: some machines' clocks go back */
double times_mean(const struct times *times);   /* NaN if empty, also for times_percentile */
/* Returns a percentile. share 0: the smallest, 1: the largest; both are exact. */
double times_percentile(const struct times *times, double share);
/* Calls `tell` for each range of durations, from the shortest to the longest that was added. Each octave has `parts` ranges of
 * equal width; `parts` is a power of two up to TIMES_PARTS. `from` and `to`: ms; a range begins where the one before it ends. */
void times_ranges(const struct times *times, int parts, void (*tell)(void *user, double from, double to, uint64_t count), void *user);

#endif
