/* Soil that leaves a body which carries it, where another body that carries may be below. */
#ifndef FURROW_SOIL_CARRIED_AROUND_H
#define FURROW_SOIL_CARRIED_AROUND_H

#include "soil/carried.h"

/* Another body that carries: it gets what falls there. Its state changes. */
struct soil_carried_other {
	struct soil_carried *carried;
	struct soil_pose pose; /* to which soil_carried_place moved it */
};

/* With what a body exchanges soil. */
struct soil_carried_around {
	const struct soil_planes *planes;        /* as in soil_carried_settle */
	int32_t reference;
	struct post_rect written;
	const struct soil_carried_other *others; /* `other_count` of them. Of several below a place the highest one gets the soil */
	size_t other_count;
	bool alone;                              /* no soil comes or goes: it slides aboard alone */
};

/* As soil_carried_settle and soil_carried_drop. */
struct post_rect soil_carried_settle_among(struct soil_carried *carried, const struct soil_pose *pose, const struct soil_sliding *rule, const struct soil_carried_around *around);
struct post_rect soil_carried_drop_among(struct soil_carried *carried, const struct soil_pose *pose, const struct soil_carried_around *around);

#endif
