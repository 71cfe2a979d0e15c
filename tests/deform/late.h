/*
 * What the GPU sends comes when a test says so. Where GL is software a transfer is over at once, and on hardware nobody
 * knows when; here one that was begun is over `late_by` intervals later, or when somebody waits for the GPU. Executables are
 * linked with --wrap for gpu_buffer_read_into, gpu_staging_idle and gpu_finish. One thread.
 */
#ifndef FURROW_TESTS_DEFORM_LATE_H
#define FURROW_TESTS_DEFORM_LATE_H

#include <stdint.h>

#define LATE_UNTIL_WAITED INT64_MAX

/* 0 at first: as soon as they are there. */
extern int64_t late_by;
/* So many of the next looks at what is under way find it not over, though it is: it came right behind the look. */
extern int late_misses;
/* An interval has passed. */
void late_pass(void);

#endif
