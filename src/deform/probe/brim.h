/* The lower end of a cylinder that leans. */
#ifndef FURROW_DEFORM_PROBE_BRIM_H
#define FURROW_DEFORM_PROBE_BRIM_H

#include "deform/probe/lanes.h"
#include "deform/probe/law.h"
#include "deform/probe/place.h"

/* Computes what the lower end bears beside the cell of lane i, after deform_law_bear. Returns false if it bears nothing. */
bool deform_brim_at(const struct probe_law *law, const struct lanes *lanes, int i, struct probe_place *place);

#endif
