/* Thinning of meshes: fewer triangles, which differ by less than a given distance. */
#ifndef FURROW_VEHICLE_THIN_H
#define FURROW_VEHICLE_THIN_H

#include <stdbool.h>

#include "base/base.h"
#include "soil/soil.h"

/* Takes triangles out of a mesh. Every vertex, and the middle of each edge and triangle that it had, stays within `most` metres of what is left. *thinned: it has
 * fewer now; false: it is as it was. STATUS_MEMORY: as it was. Takes some seconds for a million triangles. */
enum status vehicle_thin(struct soil_mesh *mesh, double most, bool *thinned) FURROW_CHECKED;

#endif
