/* What bench_regions consists of: bodies on tiles, and the ways to compute their contacts; and the dissertation's displacement by a depth buffer. */
#ifndef FURROW_BENCH_REGIONS_H
#define FURROW_BENCH_REGIONS_H

#include "deform/deform.h"
#include "gpu/gpu.h"

#define REGIONS_CELLS 256           /* of a tile */
#define REGIONS_SPACING 0.0625      /* m: a whole number of units of the lattice, so that places can be moved by whole posts */
#define REGIONS_STEPS 32            /* of a run */

enum regions_way { WAY_WINDOW, WAY_BATCH, WAY_FIXED, WAY_DYNAMIC, REGIONS_WAYS };

/* Spheres of `footprint` posts across. `crossing`: share of those that stay on the corner of four tiles; the others stay within a tile. */
struct regions_job {
	enum deform_model model;
	int footprint, bodies, repetitions;
	double crossing;
	int margin; /* posts around the window of a dynamic region; it is moved after so many steps of a post */
};

/* Ground of one way: tiles, all resident. */
struct field;

/* Makes the ground of a job. Several fields can share a gpu. */
struct field *regions_open(struct gpu *gpu, const struct regions_job *job, enum regions_way way);
void regions_close(struct field *field);
/* Returns seconds since some time: of the processor, where GL is software and draws in the calling thread; otherwise of the clock. */
double regions_seconds(struct gpu *gpu);
/* Runs all steps over undeformed ground. Returns the seconds until the GPU has finished. Ends with the ground in the tiles. */
double regions_run(struct field *field);
/* Returns a hash of the offsets of all tiles. */
uint64_t regions_hash(struct field *field);
/* Returns how many bytes of textures a way has beside the tiles: scratch layers, or dynamic regions. */
uint64_t regions_bytes(const struct field *field);

/* regions_below.c: prints a JSON line for each footprint and format of the offset map: error and time, beside those of the lower envelope. */
void regions_below(struct gpu *gpu, const int *footprints, int count, int runs);

#endif
