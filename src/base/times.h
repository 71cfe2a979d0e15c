/*
 * How long something took, over and over: a histogram of fixed size, so that a drive of hours keeps no more than
 * one of seconds. Number, mean, least and most are exact; a percentile is within TIMES_ERROR of the value that
 * sorting all of them would give. One thread; no allocation.
 */
#ifndef FURROW_RUN_TIMES_H
#define FURROW_RUN_TIMES_H

#include <stdint.h>

enum { TIMES_OCTAVES = 40, TIMES_PARTS = 128 };

#define TIMES_ERROR (0.5 / TIMES_PARTS) /* of the value */
/* Between these, in ms (61 ns and 18 hours). Beyond, a value counts as the nearest that is not. */
#define TIMES_LEAST 0x1p-14
#define TIMES_MOST (TIMES_LEAST * (double)((uint64_t)1 << TIMES_OCTAVES))

/* All zero is empty. */
struct times {
	uint64_t count;
	double sum, least, most; /* ms */
	uint64_t buckets[TIMES_OCTAVES * TIMES_PARTS];
};

void times_add(struct times *times, double ms); /* 0 or more */
double times_mean(const struct times *times);   /* NaN if empty, as the next */
/* share 0: the least, 1: the most, both exact. */
double times_percentile(const struct times *times, double share);

#endif
