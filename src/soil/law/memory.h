/*
 * What a post remembers of loose layers. Soil that was laid on a post, or slid onto it, lies loose on what was there before. SOIL.md has the law.
 *
 * A post has two layers at most. The top one has the planes `deposited` and `sinkage`, as a post without a loose one does. Its undisturbed surface is
 * base + deposited. If it is loose, `loose` is its thickness, and below it is the floor, whose plastic sinkage is `floor`.
 *
 * `settled` is the deposited thickness when a body last touched the post. Soil that slides or is laid raises `deposited` alone. So what `deposited` is
 * more than `settled` came since, and nothing that moves soil has to know of layers. All are fixed-point units. Pure.
 */
#ifndef FURROW_SOIL_MEMORY_H
#define FURROW_SOIL_MEMORY_H

#include "soil/lanes.h"

#include <stdint.h>

/* The layers of a post as a body finds them. */
struct memory {
	int32_t deposited, sinkage; /* of the top layer */
	int32_t loose;              /* thickness of the top layer; 0: it is not loose */
	int32_t floor;              /* plastic sinkage of the floor; below 0: that of a loose layer that a body sank into, which counts as less (put_strengths) */
};

/* Returns the layers of a post from its planes. Soil that came since the last touch makes a new top layer, whose surface is the post's. What was
 * the top layer is its floor then. But a loose top layer joins the new one, without what it remembers, if its floor is near or sank much more. */
SOIL_INLINED struct memory memory_of(int32_t offset, int32_t deposited, int32_t sinkage, int32_t settled, int32_t loose, int32_t floor)
{
	const int32_t came = deposited - settled, was_loose = loose > 0, is_new = came > 0, firm = (sinkage <= loose / 2) & (sinkage >= floor / 4);
	const int32_t thick = offset - settled + loose, less = came < 0 ? came : 0; /* from the floor, which stays, to the surface */
	const int32_t joined = was_loose & !firm ? (thick > came ? thick : came) : came, remains = loose + less > 1 ? loose + less : 1;
	const int32_t below = was_loose ? (firm ? -sinkage : floor) : sinkage;
	return (struct memory){
		.deposited = is_new ? offset : deposited,
		.sinkage = is_new ? 0 : sinkage,
		.loose = is_new ? joined : was_loose ? remains : 0,
		.floor = is_new ? below : was_loose ? floor : 0,
	};
}

#endif
