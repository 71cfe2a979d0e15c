/*
 * Buckets are log-linear: each octave from TIMES_LEAST up in TIMES_PARTS equal parts. A part is at most
 * 1 / TIMES_PARTS of the values in it, so its middle is within half of that.
 */
#include "base/times.h"

#include <assert.h>
#include <math.h>

static int bucket_of(double ms)
{
	if (ms < TIMES_LEAST)
		return 0;
	if (ms >= TIMES_MOST)
		return TIMES_OCTAVES * TIMES_PARTS - 1;
	int octave;
	double part = frexp(ms / TIMES_LEAST, &octave); /* 0.5 <= part < 1, octave >= 1 */
	return (octave - 1) * TIMES_PARTS + (int)((part - 0.5) * 2 * TIMES_PARTS);
}

static double middle_of(int bucket)
{
	double part = 1 + (bucket % TIMES_PARTS + 0.5) / TIMES_PARTS;
	return TIMES_LEAST * ldexp(part, bucket / TIMES_PARTS);
}

void times_add(struct times *times, double ms)
{
	ms = ms > 0 ? ms : 0;
	times->least = times->count == 0 ? ms : fmin(times->least, ms);
	times->most = fmax(times->most, ms);
	times->sum += ms;
	times->count++;
	times->buckets[bucket_of(ms)]++;
}

double times_mean(const struct times *times)
{
	return times->count > 0 ? times->sum / (double)times->count : (double)NAN;
}

double times_percentile(const struct times *times, double share)
{
	assert(share >= 0 && share <= 1);
	if (times->count == 0)
		return (double)NAN;
	uint64_t rank = (uint64_t)(share * (double)(times->count - 1) + 0.5), seen = 0;
	if (rank == 0)
		return times->least;
	if (rank >= times->count - 1)
		return times->most;
	int bucket = 0;
	while ((seen += times->buckets[bucket]) <= rank)
		bucket++;
	return fmin(fmax(middle_of(bucket), times->least), times->most);
}

/* The least value of a bucket; of the one behind the last: TIMES_MOST. */
static double edge_of(int bucket)
{
	return TIMES_LEAST * ldexp(1 + (double)(bucket % TIMES_PARTS) / TIMES_PARTS, bucket / TIMES_PARTS);
}

void times_ranges(const struct times *times, int parts, void (*tell)(void *user, double from, double to, uint64_t count), void *user)
{
	const int wide = TIMES_PARTS / parts;
	assert(parts > 0 && wide * parts == TIMES_PARTS);
	if (times->count == 0)
		return;
	const int last = bucket_of(times->most) / wide;
	for (int range = bucket_of(times->least) / wide; range <= last; range++) {
		uint64_t count = 0;
		for (int i = 0; i < wide; i++)
			count += times->buckets[range * wide + i];
		tell(user, edge_of(range * wide), edge_of((range + 1) * wide), count);
	}
}
