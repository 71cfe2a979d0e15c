/* How loops over rows of posts are compiled: as vector instructions, for several instruction sets. All of them give the same bits. */
#ifndef FURROW_SOIL_LANES_H
#define FURROW_SOIL_LANES_H

/* A function whose loops gcc turns into vector instructions, whatever the build's optimization is. The program takes the widest
 * instruction set that its processor has (meson.build). */
#if FURROW_CLONES
#define SOIL_SETS target_clones("arch=x86-64-v4", "avx2", "default")
#define SOIL_LANES __attribute__((optimize("O3"), SOIL_SETS))
/* The same in the law's files, which are compiled with -O3 as a whole (meson.build). */
#define SOIL_CLONED __attribute__((SOIL_SETS, no_sanitize("undefined")))
#else
#define SOIL_LANES
#define SOIL_CLONED
#endif
/* A function that becomes part of each function that calls it. */
#define SOIL_INLINED static inline __attribute__((always_inline))
/* Before a loop of as many turns as a vector has lanes. Without it gcc may write a line for each turn. */
#ifdef __clang__
#define SOIL_WHOLE
#else
#define SOIL_WHOLE _Pragma("GCC unroll 1")
#endif
/* Before a loop: no turn of it needs what another turn wrote, and no two arrays overlap. */
#ifdef __clang__
#define SOIL_APART
#else
#define SOIL_APART _Pragma("GCC ivdep")
#endif

#endif
