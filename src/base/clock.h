/* Monotonic time, for measuring durations and ages. No result may depend on it. */
#ifndef FURROW_BASE_CLOCK_H
#define FURROW_BASE_CLOCK_H

double clock_seconds(void); /* seconds since an arbitrary start, with nanosecond resolution */

/* Returns the processor time that this thread, or the whole process, has used so far, s. */
double clock_thread_seconds(void);
double clock_process_seconds(void);

#endif
