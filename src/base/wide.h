/*
 * FURROW_WIDE before a function compiles it twice, the second time for CPUs with wider vectors. The loader chooses one version.
 * Use it for loops over posts without branches. Both versions give the same bits.
 */
#ifndef FURROW_BASE_WIDE_H
#define FURROW_BASE_WIDE_H

#include <features.h>

/* Not used with sanitizers: the loader chooses before the sanitizer is initialised, and that would crash. gcc and clang name
 * sanitizers differently. */
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
