/* What is known of a shape without a pose or a soil: its limits, its size, how its surface runs. */
#include "soil/soil.h"

#include <math.h>

#include "soil/shape/body.h"

/* Heights within an object are int32 fixed-point units. Half its height and the rise of a contact must fit. */
#define SIZE_MAX_METRES 512.0
#define GROUSERS_MAX 360
#define LARGE 20.0 /* m across: larger bodies are probably given in mm */
#define THINNEST 1000.0 /* an ellipsoid is at most so many times as long as it is thick */

static enum status check_grousers(const struct soil_shape *shape)
{
	if (shape->grousers < 0 || shape->grousers > GROUSERS_MAX)
		return fail_with(STATUS_INPUT, "wheel: %d lugs; give 0 to %d", shape->grousers, GROUSERS_MAX);
	if (shape->grousers > 0 && (!(shape->grouser_height > 0) || !(shape->grouser_thickness > 0)))
		return fail_with(STATUS_INPUT, "wheel: its lugs have no size; give lug_height and lug_thickness above 0");
	double room = 2 * M_PI * shape->radius / (shape->grousers > 0 ? shape->grousers : 1);
	if (shape->grousers > 0 && shape->grouser_thickness > room)
		return fail_with(STATUS_INPUT, "wheel: %d lugs %g m thick do not fit around it; give at most %s m", shape->grousers,
				 shape->grouser_thickness, number_at_most(room, 6).text);
	return STATUS_OK;
}

/* Returns a mesh's width in any attitude, counted from its origin, metres. Windows are cut around the origin. */
static double mesh_across(const struct soil_mesh *mesh)
{
	double squares = 0;
	for (int k = 0; k < 3; k++) {
		double far = fmax(fabs(mesh->low[k]), fabs(mesh->high[k]));
		squares += far * far;
	}
	return 2 * sqrt(squares);
}

enum status soil_shape_check(const struct soil_shape *shape, double spacing)
{
	double least = 2 * shape->radius, most = 2 * shape->radius;
	if (shape->kind == SOIL_WHEEL) {
		TRY(check_grousers(shape));
		least = fmin(least, shape->width);
		most = hypot(2 * soil_body_wheel_radius(shape), shape->width);
	} else if (shape->kind == SOIL_MESH) {
		least = most = mesh_across(shape->mesh); /* a flat mesh has no thickness, and still is a surface */
	} else if (shape->kind == SOIL_BOX) {
		least = fmin(fmin(shape->size[0], shape->size[1]), shape->size[2]);
		most = hypot(hypot(shape->size[0], shape->size[1]), shape->size[2]);
	}
	if (shape->kind == SOIL_CYLINDER || shape->kind == SOIL_CAPSULE) {
		least = shape->kind == SOIL_CYLINDER ? fmin(least, shape->length) : least;
		most = 2 * soil_shape_bound(shape);
	} else if (shape->kind == SOIL_ELLIPSOID) {
		least = 2 * fmin(fmin(shape->size[0], shape->size[1]), shape->size[2]);
		most = 2 * soil_shape_bound(shape);
		if (most > THINNEST * least)
			return fail_with(STATUS_INPUT, "ellipsoid: radii of %g and %g m are too different; give radii of which none is more than %g times "
					 "another", least / 2, most / 2, THINNEST);
	}
	double limit = fmin(SOIL_SHAPE_POSTS * spacing, SIZE_MAX_METRES);
	if (!(least > 0))
		return fail_with(STATUS_INPUT, "shape: it has no width; give sizes above 0");
	if (most > limit)
		return fail_with(STATUS_INPUT, "shape: %g m across is too large for posts %g m apart; give at most %s m, or a "
					       "coarser spacing%s",
				 most, spacing, number_at_most(limit, 6).text, most > LARGE ? "; the unit of a size is m: if it is in mm, give thousandths of it" : "");
	return STATUS_OK;
}

bool soil_only_set_down(const struct soil_pose *from, const struct soil_pose *to)
{
	const int64_t rise = to->z - from->z;
	return (to->x == from->x && to->y == from->y && rise == 0) || rise > BODY_RISE_MAX || rise < -BODY_RISE_MAX;
}

/* Finds the posts between a and b, `extent` metres more on both sides. */
static void span(int64_t a, int64_t b, double extent, double spacing, int64_t *first, int64_t *last)
{
	const double low = lattice_offset_metres(a < b ? a : b) - extent, high = lattice_offset_metres(a > b ? a : b) + extent;
	*first = (int64_t)floor(low / spacing);
	*last = (int64_t)ceil(high / spacing) + 1;
}

struct post_rect soil_shadow(const struct soil_shape *shape, const struct soil_pose *from, const struct soil_pose *to, double spacing)
{
	double extent[2];
	struct post_rect shadow;
	soil_body_extent(shape, to, extent);
	span(from->x, to->x, extent[0], spacing, &shadow.x0, &shadow.x1);
	span(from->y, to->y, extent[1], spacing, &shadow.y0, &shadow.y1);
	return shadow;
}

bool soil_shape_runs(const struct soil_shape *shape)
{
	return shape->kind == SOIL_WHEEL || shape->belt;
}

double soil_shape_rolling(const struct soil_shape *shape)
{
	return shape->radius - shape->tyre.deflection;
}

double soil_shape_ran(const struct soil_shape *shape, double turned)
{
	if (shape->kind == SOIL_WHEEL)
		return soil_shape_rolling(shape) * turned;
	return shape->belt ? turned : 0;
}

double soil_shape_bound(const struct soil_shape *shape)
{
	switch (shape->kind) {
	case SOIL_WHEEL:
		return hypot(soil_body_wheel_radius(shape), shape->width / 2);
	case SOIL_BOX:
		return hypot(hypot(shape->size[0], shape->size[1]), shape->size[2]) / 2;
	case SOIL_MESH:
		return mesh_across(shape->mesh) / 2;
	case SOIL_CYLINDER:
		return hypot(shape->radius, shape->length / 2);
	case SOIL_CAPSULE:
		return shape->radius + shape->length / 2;
	case SOIL_ELLIPSOID:
		return fmax(fmax(shape->size[0], shape->size[1]), shape->size[2]);
	case SOIL_SPHERE:
	case SOIL_SHAPES:
		break;
	}
	return shape->radius;
}

/* As soil_shape_reach. */
static double mesh_reach(const struct soil_mesh *mesh, double pitch, double roll)
{
	const double unit[3] = {2, 2, 2}; /* of which half is one */
	double axes[3][3], lowest = 0;
	soil_body_axes(unit, 0, pitch, roll, axes);
	for (uint32_t i = 0; i < mesh->vertex_count; i++) {
		const float *v = mesh->vertices[i];
		double z = v[0] * axes[0][2] + v[1] * axes[1][2] + v[2] * axes[2][2];
		lowest = i == 0 ? z : fmin(lowest, z);
	}
	return -lowest;
}

double soil_shape_reach(const struct soil_shape *shape, double pitch, double roll)
{
	if (shape->kind == SOIL_MESH)
		return mesh_reach(shape->mesh, pitch, roll);
	double axes[3][3];
	switch (shape->kind) {
	case SOIL_WHEEL: /* its pitch does not count */
		return (shape->radius + (shape->grousers > 0 ? shape->grouser_height : 0)) * fabs(cos(roll)) + shape->width / 2 * fabs(sin(roll));
	case SOIL_BOX:
		soil_body_axes(shape->size, 0, pitch, roll, axes);
		return fabs(axes[0][2]) + fabs(axes[1][2]) + fabs(axes[2][2]);
	case SOIL_ELLIPSOID:
		soil_body_axes(shape->size, 0, pitch, roll, axes); /* half of its half axes */
		return 2 * hypot(hypot(axes[0][2], axes[1][2]), axes[2][2]);
	case SOIL_CYLINDER:
	case SOIL_CAPSULE:
		soil_axes(0, pitch, roll, 0, axes);
		return fabs(axes[2][2]) * shape->length / 2 +
		       shape->radius * (shape->kind == SOIL_CAPSULE ? 1 : hypot(axes[2][0], axes[2][1]));
	case SOIL_SPHERE:
	case SOIL_MESH:
	case SOIL_SHAPES:
		break;
	}
	return shape->radius;
}
