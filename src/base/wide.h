/*
 * FURROW_WIDE before a function: it is compiled once more for machines with wider vectors, and the
 * loader chooses. For loops over posts without branches; the results are the same bits.
 */
#ifndef FURROW_BASE_WIDE_H
#define FURROW_BASE_WIDE_H

#include <features.h>

#if defined(__x86_64__) && defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define FURROW_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define FURROW_WIDE
#endif

#endif
