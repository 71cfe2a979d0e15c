/* Monotonic time, for measuring durations and ages. No result may depend on it. */
#ifndef FURROW_BASE_CLOCK_H
#define FURROW_BASE_CLOCK_H

double clock_seconds(void); /* seconds since an arbitrary start, with nanosecond resolution */

#endif
