/*
 * A bed of flat ground of bearing soil for bench_validation, its south-western post at 0, 0, computed as in a drive (src/bearing). Whatever fails ends
 * the program.
 */
#ifndef FURROW_BENCH_VALIDATION_BED_H
#define FURROW_BENCH_VALIDATION_BED_H

#include "deform/deform.h"

struct bed;

struct bed *bed_create(int width, int height, double spacing, const struct soil_numbers *soil);
void bed_destroy(struct bed *bed);
/* *lower: how far a load sank, m. *work: what the soil's yielding took over the contact, J. Either may be NULL. */
void bed_press(struct bed *bed, const struct deform_contact *contact, struct deform_forces *forces, double *lower, double *work);

#endif
