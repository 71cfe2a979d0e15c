/*
 * Tells by which law the soil acts on the parts of a body, and what a coarse spacing costs where it slides. What a body slides follows from its shape, its
 * slip and how it is turned against its way. The errors were measured by bench/faces_error.py (scene_faces_errors.h).
 */
#include <math.h>
#include <string.h>

#include "scene/scene.h"
#include "scene/scene_faces_errors.h"

#define BRAKED (-0.3) /* a slip below it: of the bench's wheels the locked one is nearest */
static bool has_faces(const struct scene *scene)
{
	return scene->faces == SCENE_FACES_ON;
}

/* Returns true if an object has one place. */
static bool is_fixed(const struct scene_path *path)
{
	for (size_t i = 1; i < path->count; i++)
		if (path->points[i].x != path->points[0].x || path->points[i].y != path->points[0].y || path->points[i].z != path->points[0].z)
			return false;
	return path->count > 0;
}

static void add(struct scene_laws *out, const char *part, double faces)
{
	out->parts[out->count++] = (struct scene_law_part){part, faces};
}

/* How a body moves over the ground. NAN: not known. */
struct moves {
	double slides;  /* share of its way */
	double below;   /* share that 3D-RFT has below it */
	double aside;   /* 1: a wheel's sides move into the soil; 0: they move along it */
};
static const struct moves unknown = {NAN, NAN, NAN};

static void find_parts(const struct scene *scene, const struct soil_shape *shape, const struct moves *moves, struct scene_laws *out)
{
	const bool faces = has_faces(scene), wheel = shape->kind == SOIL_WHEEL;
	*out = (struct scene_laws){.slides = moves->slides, .wheel = wheel, .posts = NAN};
	const double beside = isnan(moves->slides) ? moves->slides : moves->slides > 0;
	add(out, wheel ? "rim" : "underside", faces ? moves->below : 0);
	add(out, wheel ? "sides" : "front and sides", !faces ? 0 : wheel ? moves->aside : beside);
	if (wheel && shape->grousers > 0)
		add(out, "bars", faces ? moves->below : 0); /* part of a drum over their tips */
}

static struct moves moves_of(const struct scene_object *object)
{
	const bool hosted = object->path.count == 0, wheel = object->shape.kind == SOIL_WHEEL;
	const double *turned = object->path.attitude;
	/* A path that gives attitudes may turn a wheel in any way. */
	if (hosted || (object->path.has_attitude && wheel))
		return unknown;
	if (is_fixed(&object->path))
		return (struct moves){0, 0, 0};
	const bool aside = fabs(sin(turned[0])) > 1e-9;
	const double way[2] = {cos(turned[0]), -sin(turned[0])};
	struct moves moves = {.aside = aside};
	moves.slides = soil_slid(&object->shape, way, soil_shape_runs(&object->shape) ? 1 / (1 - object->slip) : 0, &moves.below);
	return moves;
}

/* --- what the spacing costs --- */

static double posts_of_row(bool wheel, size_t row)
{
	return wheel ? scene_faces_wheels[row].posts : scene_faces_blades[row].posts;
}

static int error_of_row(bool wheel, enum scene_faces_wheel kind, size_t row)
{
	return wheel ? scene_faces_wheels[row].errors[kind] : scene_faces_blades[row].error;
}

/* Between two rows it goes with the logarithms of both. */
static int error_of(bool wheel, enum scene_faces_wheel kind, double posts)
{
	size_t row = 0;
	while (row + 1 < SCENE_FACES_ROWS && posts >= posts_of_row(wheel, row + 1))
		row++;
	const int error = error_of_row(wheel, kind, row);
	if (row + 1 == SCENE_FACES_ROWS || posts <= posts_of_row(wheel, row))
		return error;
	const double part = log(posts / posts_of_row(wheel, row)) / log(posts_of_row(wheel, row + 1) / posts_of_row(wheel, row));
	return (int)ceil(error * pow((double)error_of_row(wheel, kind, row + 1) / error, part) - 1e-9);
}

static enum scene_faces_wheel kind_of(const struct soil_shape *shape, double slip, bool turned)
{
	if (shape->grousers > 0)
		return SCENE_FACES_BARS;
	return slip < BRAKED ? SCENE_FACES_LOCKED : turned ? SCENE_FACES_TURNED : SCENE_FACES_ROLLS;
}

static void find_cost(enum scene_faces_wheel kind, double over, double spacing, struct scene_laws *out)
{
	if (!(over > 0) || !(spacing > 0))
		return;
	out->posts = over / spacing;
	out->error = error_of(out->wheel, kind, out->posts);
	out->beyond = out->posts < posts_of_row(out->wheel, 0) * (1 - SPACING_PRINTED);
	for (double finer = spacing / 2; over / finer <= 2 * posts_of_row(out->wheel, SCENE_FACES_ROWS - 1) && out->finer == 0; finer /= 2) {
		out->finer_error = error_of(out->wheel, kind, over / finer);
		if (2 * out->finer_error <= out->error)
			out->finer = finer;
	}
}

/* Returns how deep a body that slides is in the soil, m; 0: not known here. */
static double depth_of(const struct scene *scene, const struct scene_object *object)
{
	if (object->load <= 0 || scene->soil_count == 0)
		return object->path.has_z ? 0 : object->sink;
	double least = INFINITY;
	for (int i = 0; i < scene->soil_count; i++)
		least = fmin(least, soil_sinkage_guess(&object->shape, &scene->soils[i], object->load));
	return least;
}

bool scene_laws_of(const struct scene *scene, const struct scene_object *object, double spacing, struct scene_laws *out)
{
	const struct moves moves = moves_of(object);
	const bool wheel = object->shape.kind == SOIL_WHEEL;
	if (!deform_tells_forces(scene->model))
		return false;
	find_parts(scene, &object->shape, &moves, out);
	if (!is_fixed(&object->path))
		find_cost(kind_of(&object->shape, object->slip, scene_is_turned(object)),
			  wheel ? object->shape.radius : object->path.count == 0 ? 0 : depth_of(scene, object), spacing, out);
	return true;
}

bool scene_laws_of_shape(const struct scene *scene, const struct soil_shape *shape, double spacing, struct scene_laws *out)
{
	if (!deform_tells_forces(scene->model))
		return false;
	find_parts(scene, shape, &unknown, out);
	find_cost(kind_of(shape, 0, true), shape->kind == SOIL_WHEEL ? shape->radius : 0, spacing, out);
	return true;
}
