/*
 * FURROW_WIDE before a function: it is compiled once more for machines with wider vectors, and the
 * loader chooses. For loops over posts without branches; the results are the same bits.
 */
#ifndef FURROW_BASE_WIDE_H
#define FURROW_BASE_WIDE_H

#include <features.h>

/* What the loader runs to choose would be watched by a sanitizer that is not set up by then: a crash. clang says
 * by another word than gcc that there is one. */
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define FURROW_WATCHED
#endif
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define FURROW_WATCHED
#endif

#if defined(__x86_64__) && defined(__GLIBC__) && !defined(FURROW_WATCHED)
#define FURROW_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define FURROW_WIDE
#endif

#endif
