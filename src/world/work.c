/* The work that a body on a path does on the soil, from one path sample to the next. */
#include "world/internal.h"

double world_work_between(const struct soil_pose *from, const struct world_force *before, const struct soil_pose *to, const struct world_force *after)
{
	const double moved[3] = {lattice_offset_metres(to->x - from->x), lattice_offset_metres(to->y - from->y), lattice_offset_metres(after->z - before->z)};
	double turns[2][4], rotated[3], soil = 0;
	world_orientation(&(struct soil_pose){.yaw = from->yaw, .pitch = from->pitch, .roll = from->roll}, turns[0]); /* without the turn of a belt */
	world_orientation(&(struct soil_pose){.yaw = to->yaw, .pitch = to->pitch, .roll = to->roll}, turns[1]);
	world_rotation_between(turns[0], turns[1], rotated);
	for (int k = 0; k < 3; k++)
		soil += (before->force[k] + after->force[k]) / 2 * moved[k] + (before->moment[k] + after->moment[k]) / 2 * rotated[k];
	return -soil;
}
