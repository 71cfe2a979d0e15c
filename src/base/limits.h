/* What to do where the machine's limits end: files, threads, memory, disk. */
#ifndef FURROW_BASE_LIMITS_H
#define FURROW_BASE_LIMITS_H

/* Returns what a user can do about a call that failed with `error` (errno), as the end of a message. It is `otherwise`, unless the
 * cause is a full disk, a limit of the process, or a file system that may only be read. Any thread. */
const char *limits_advice(int error, const char *otherwise);

#endif
