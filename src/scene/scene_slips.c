/* Finds out whether a body of a scene can slip over the ground. Where none can, no soil is dug, and nothing for that is made. */
#include <math.h>

#include "scene/scene.h"

#define TURN_LEAST 1e-9 /* rad: a smaller turn is none */

static bool never_moves(const struct scene_path *path)
{
	for (size_t i = 1; i < path->count; i++) {
		const struct scene_waypoint *a = &path->points[0], *b = &path->points[i];
		if (a->x != b->x || a->y != b->y || a->yaw != b->yaw || a->pitch != b->pitch || a->roll != b->roll)
			return false;
	}
	return true;
}

/* True if the path is one straight line, along which the object only goes ahead. Only of a path in metres more than two points are looked at. */
static bool is_straight(const struct scene *scene, const struct scene_path *path)
{
	const struct scene_waypoint *points = path->points;
	double way = NAN;
	if (path->smooth || path->loop || path->beside[0] != 0 || path->beside[1] != 0)
		return false;
	if (path->count > 2 && (scene->coordinates == SCENE_SRS || path->degrees))
		return false;
	for (size_t i = 1; i < path->count; i++) {
		const double x = points[i].x - points[i - 1].x, y = points[i].y - points[i - 1].y;
		if (x == 0 && y == 0)
			continue;
		const double turn = isnan(way) ? 0 : remainder(atan2(y, x) - way, 2 * M_PI);
		if (!(fabs(turn) <= TURN_LEAST))
			return false;
		way = isnan(way) ? atan2(y, x) : way;
	}
	return true;
}

bool scene_is_turned(const struct scene_object *object)
{
	const double *attitude = object->path.attitude;
	return object->path.has_attitude || attitude[0] != 0 || attitude[1] != 0 || attitude[2] != 0;
}

double scene_sinkage_guess(const struct scene *scene, const struct scene_object *object)
{
	if (!(object->load > 0))
		return object->sink;
	if (!deform_is_elastic(scene->model))
		return soil_sinkage_guess(&object->shape, &scene->soils[0], object->load);
	/* As if the sheet bore it evenly, over its length around half of the body. */
	const double across = sqrt(scene->tension / scene->stiffness) + soil_shape_bound(&object->shape) / 2;
	return fmin(object->load / (scene->stiffness * M_PI * across * across), 4);
}

double scene_slip_way(const struct scene_object *object, double x, double y, double yaw)
{
	return object->path.attitude[0] != 0 ? hypot(x, y) : x * cos(yaw) + y * sin(yaw);
}

/* A wheel that the path lifts or lowers moves against the ground, so it slips too. */
static bool rolls_straight(const struct scene *scene, const struct scene_object *object)
{
	const struct scene_path *path = &object->path;
	return object->shape.kind == SOIL_WHEEL && !object->shape.belt && object->slip == 0 && !scene_is_turned(object) && !path->has_z &&
	       is_straight(scene, path);
}

bool scene_slips(const struct scene *scene)
{
	if (scene_moves_bodies(scene))
		return true;
	for (size_t i = 0; i < scene->object_count; i++) {
		const struct scene_object *object = &scene->objects[i];
		if (object->path.count == 0 || !(never_moves(&object->path) || rolls_straight(scene, object)))
			return true;
	}
	return false;
}

bool scene_throws(const struct scene *scene)
{
	return scene->thrown == SCENE_THROWN_ON && ((scene->slip_sinkage > 0 && scene_slips(scene)) || scene_carries(scene));
}
