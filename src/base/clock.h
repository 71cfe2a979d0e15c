/* Monotonic time, for measuring and for ages; never for anything a result depends on. */
#ifndef FURROW_BASE_CLOCK_H
#define FURROW_BASE_CLOCK_H

double clock_seconds(void); /* since an arbitrary start, nanosecond resolution */

#endif
