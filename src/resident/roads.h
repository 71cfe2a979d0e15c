/* Used inside resident only. Roads: which posts lie on one, and of what soil. Never changes after it is made, so threads may share it. */
#ifndef FURROW_RESIDENT_ROADS_H
#define FURROW_RESIDENT_ROADS_H

#include "resident/resident.h"

struct roads;

/* Copies the parts. None: *out is NULL. */
enum status resident_roads_create(const struct road_part *parts, size_t count, struct roads **out) FURROW_CHECKED;
void resident_roads_destroy(struct roads *roads); /* takes NULL */
/* Writes the soil of each post of `rect` that lies on a road, and leaves the others. spacing: m, between posts. roads may be NULL. */
void resident_roads_paint(const struct roads *roads, double spacing, struct post_rect rect, uint8_t *classes);

#endif
