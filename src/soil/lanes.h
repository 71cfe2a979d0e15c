/* How loops over rows of posts are compiled: as vector instructions, for several instruction sets. All of them give the same bits. */
#ifndef FURROW_SOIL_LANES_H
#define FURROW_SOIL_LANES_H

/* A function whose loops gcc turns into vector instructions, whatever the build's optimization is. The program takes the widest
 * instruction set that its processor has (meson.build). */
#if FURROW_CLONES
#define SOIL_LANES __attribute__((optimize("O3"), target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define SOIL_LANES
#endif

#endif
