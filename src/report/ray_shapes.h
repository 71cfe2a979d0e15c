#ifndef FURROW_REPORT_RAY_SHAPES_H
#define FURROW_REPORT_RAY_SHAPES_H

#include "report/report.h"

/* Returns the distance at which a ray meets a shape, m; INFINITY: nowhere. `origin`: m, `way`: of length 1; both along the shape's axes, from its centre. A
 * ray from inside meets the shape from inside. Pure. */
double report_ray_shape(const struct soil_shape *shape, const double origin[3], const double way[3]);

#endif
