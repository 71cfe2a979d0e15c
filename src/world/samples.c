/* Tells about paths that have far more path samples than their way has posts. A body that turns makes a contact for each post that it passes. */
#include <math.h>

#include "world/internal.h"

#define MANY 10000    /* path samples: fewer cost little */
#define MANY_TIMES 10 /* as many as there are posts on the way and rows of the file */
#define DEGREES (180 / M_PI)

/* Returns by how far an object turns at most from one waypoint to the next, rad. */
static double turns_most(const struct scene_path *path)
{
	double most = 0;
	for (size_t i = 1; path->has_attitude && i < path->count; i++) {
		const struct scene_waypoint *a = &path->points[i - 1], *b = &path->points[i];
		most = fmax(most, fmax(fabs(remainder(b->yaw - a->yaw, 2 * M_PI)), fmax(fabs(b->pitch - a->pitch), fabs(b->roll - a->roll))));
	}
	return most;
}

void world_advise_samples(const struct world *world, scene_advice_fn tell, void *user)
{
	const struct scene *scene = world->scene;
	char text[480];
	for (size_t i = 0; i < scene->object_count; i++) {
		const struct body *body = world->bodies[i];
		const struct scene_path *path = &body->object->path;
		if (body->kind != BODY_PATH)
			continue;
		const double samples = (double)world_samples_until(body->track, scene->end_time), way = world_way_at(body->track, scene->end_time);
		const double turn = turns_most(path) * DEGREES;
		if (!(samples > MANY) || !(samples > MANY_TIMES * (way / world->resident.spacing + (double)path->count)) || turn == 0)
			continue;
		snprintf(text, sizeof text, "objects.%.200s.path: has %.0f path samples, each a contact: %.0f times as many as there are posts on its way of %.4g m, since it turns by up "
					    "to %.4g degrees from one row to the next; look at its angles, which are in degrees, or give a coarser spacing", body->object->name,
			 samples, samples / (way / world->resident.spacing + 1), way, turn);
		tell(user, text);
	}
}
