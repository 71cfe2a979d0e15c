/*
 * The models in which the ground simply becomes the lower envelope of what is pressed into it: they differ in
 * where the soil goes. `none`: nowhere, all of it is compacted. `slippage`: aside, all of it. `sumner`: a
 * share is compacted, the rest goes aside.
 */
#include "deform/reference/reference.h"

/* A contact and its end are two searches; what they find of one place differs by less than this. */
#define TOUCH 4e-6

static void press(struct reference_ground *ground, const double *under, const double *rest, double compacted)
{
	for (int i = 0; i < ground->width * ground->height; i++) {
		ground->contact[i] = 0;
		ground->carried[i] = 0;
		if (ground->hole[i])
			continue;
		double surface = ground->base[i] + ground->offset[i];
		if (surface >= under[i]) {
			double drop = surface - under[i];
			ground->offset[i] -= drop;
			ground->carried[i] = drop * (1 - compacted);
			ground->compacted += drop * compacted * ground->spacing * ground->spacing;
			ground->contact[i] |= REFERENCE_SWEPT;
			surface = under[i];
		}
		if (surface + TOUCH >= rest[i])
			ground->contact[i] |= REFERENCE_HELD;
	}
}

void reference_none(struct reference_ground *ground, const double *under, const double *rest)
{
	press(ground, under, rest, 1);
}

void reference_slippage(struct reference_ground *ground, const double *under, const double *rest)
{
	press(ground, under, rest, 0);
}

void reference_sumner(struct reference_ground *ground, const struct soil_numbers *soil, const double *under,
		      const double *rest)
{
	press(ground, under, rest, soil->compression);
}
