/* Which share of its way a body slides at a place, and how far soil pushes there by the law of faces. Pure. */
#ifndef FURROW_SOIL_SLID_H
#define FURROW_SOIL_SLID_H

#include "soil/law/form.h"

#define SLID_LEAST 0.002f /* a smaller share is none: of a wheel that rolls in whole fixed-point units */
#define SLID_SIDES 0.05f /* a larger share by so much, and the sides push whole */
#define SLID_POWER 0.7f  /* chosen on a smooth wheel of a rig at slip angle 0; from 0.5 to 1 it makes little difference */

/* Gives how a place of the body goes over the ground, and how its surface runs there. The place counts as at the body's lowest level. Both in plan, in the
 * frame, for each metre of the body's recent way. */
SOIL_INLINED void recent_at(const struct soil_form *f, float x, float y, float goes[2], float runs[2])
{
	const struct soil_recent *m = &f->recent;
	const float reach = f->rim_reach;
	goes[0] = m->way[0] * m->along_ground - m->turning[1] * reach - m->turning[2] * y;
	goes[1] = m->way[1] * m->along_ground + m->turning[2] * x + m->turning[0] * reach;
	runs[0] = -m->rolling[1] * reach - m->rolling[2] * y - m->ran * f->belt[1];
	runs[1] = m->rolling[2] * x + m->rolling[0] * reach + m->ran * f->belt[0];
}

/* How a surface that runs over its body slides over the ground. */
struct slide {
	float braked[2];   /* what the body goes beyond what it rolls off, plan */
	float spins;       /* what the surface runs beyond what the body goes */
	float goes, runs;  /* lengths of both */
	float along;       /* part of `runs` along the way */
};

SOIL_INLINED struct slide slide_of(const float goes[2], const float runs[2])
{
	const float ran = sqrtf(runs[0] * runs[0] + runs[1] * runs[1]), by = 1 / most(ran, 1e-12f), back = -(goes[0] * runs[0] + goes[1] * runs[1]);
	const float off = least(ran, most(back * by, 0)), went = sqrtf(goes[0] * goes[0] + goes[1] * goes[1]);
	return (struct slide){{goes[0] + off * runs[0] * by, goes[1] + off * runs[1] * by}, ran - off, went, ran, back / most(went, 1e-12f)};
}

/* Returns the share of the recent way that the body slid at a place, 0 .. 1. A rim that runs faster than the axle goes slides over soil that stays: the law
 * of the lower envelope shears it. So does the drum over grousers. */
SOIL_INLINED float slid_at(const struct soil_form *f, float x, float y)
{
	const struct soil_recent *m = &f->recent;
	float goes[2], runs[2];
	recent_at(f, x, y, goes, runs);
	const struct slide s = slide_of(goes, runs);
	/* A way up or down counts, too: a body that sinks slides little. */
	const float up = m->way[2] * (2 - m->along_ground), way = sqrtf(s.goes * s.goes + up * up);
	const float braked = sqrtf(s.braked[0] * s.braked[0] + s.braked[1] * s.braked[1]), share = braked / most(most(way, s.along), most(0.1f * s.runs, 1e-9f));
	/* Less after a short motion alone. It grows with the cube, so small motions to and fro hardly change what the law of the lower envelope bears. Else
	 * soil would sink while it bears little, and spring back with all of its strength. */
	const float moved = least(most(way, s.runs), 1);
	return moved * moved * moved * least(share, 1);
}

/* Returns by what share soil pushes by the law of faces where so much of the way is slid. The rest is the law of the lower envelope. */
SOIL_INLINED float faces_share(float slid)
{
	const float beyond = (slid - SLID_LEAST) * (1 / (1 - SLID_LEAST));
	return either(beyond > 0, power_of(most(beyond, 1e-9f), SLID_POWER), 0);
}

#endif
