/*
 * A bed of flat ground for bench_validation, on the GPU or of the reference: soil of the model scm, its south-western
 * post at 0, 0. Whatever fails ends the program.
 */
#ifndef FURROW_BENCH_VALIDATION_BED_H
#define FURROW_BENCH_VALIDATION_BED_H

#include "deform/reference/reference.h"

struct bed;

/* False: there is no GL. Once; bed_close at the end. */
bool bed_open(void);
void bed_close(void);
struct bed *bed_create(bool on_gpu, int width, int height, double spacing, const struct soil_numbers *soil);
void bed_destroy(struct bed *bed);
/* Of the forces the GPU tells no work; its `normal` is the vertical part of all. *lower: how far a load sank. */
void bed_sweep(struct bed *bed, const struct deform_contact *sweep, struct reference_forces *forces, double *lower);

#endif
