/* What a motion over level ground slides, for those who tell it before a drive. */
#include "soil/faces/slid.h"
#include "soil/soil.h"

double soil_slid(const struct soil_shape *shape, const double way[2], double runs, double *faces)
{
	const struct soil_form form = {
		.rim_reach = 1,
		.recent = {.way = {(float)way[0], (float)way[1], 0}, .rolling = {0, (float)runs, 0}, .along_ground = 1},
	};
	const float slid = slid_at(&form, 0, 0);
	*faces = (double)faces_share(slid);
	return (double)slid;
}
