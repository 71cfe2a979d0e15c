/*
 * How far off the ground a tile is drawn, for pictures that go by a pixel error (the dissertation's Equation 3).
 *
 * The store has the error of each base tile, over its whole subtree, at the posts. Between posts of level 0 the ground is bilinear, and
 * a tile's triangles are off it (render_view_bend). A surface through some offsets is between the lowest and the highest one. So
 * deformation adds at most the difference of these two, in the subtree.
 *
 * The store knows the offsets from before the drive (view_offsets.c). Only the GPU knows those of this drive. So they are estimated
 * from the object's pose. They go as deep as its lowest point is below the base beside it. If soil is moved, deposits go as high.
 * This is about right, and known at once. The next drive over that store knows it exactly.
 *
 * Invariant: a tile's range of offsets is within that of the tile above it. So with the store's errors, a tile's error is no more
 * than that of the tile above it.
 */
#include <math.h>
#include <stdlib.h>

#include "render/view.h"

#define BASES 16384 /* tiles that one selection asks about, and some more */

struct view_errors {
	struct key_cache bases; /* a: metres */
	struct offset_bounds bounds; /* estimated, of this drive's contacts */
	double low, high;       /* of the contact now */
	double lowest, highest; /* of all contacts of this drive, and of those that are expected */
};

enum status render_view_errors_create(const struct world *world, struct view_errors **out)
{
	const struct scene *scene = world_scene(world);
	struct view_errors *errors = mem_calloc(1, sizeof *errors);
	TRY_MEM(errors, "the view");
	errors->bases.most = BASES;
	errors->bounds.extent = &world_resident(world)->meta->extent;
	for (size_t i = 0; i < scene->object_count; i++) {
		const struct scene_object *object = &scene->objects[i];
		double deep = scene_sinkage_guess(scene, object);
		errors->lowest = fmin(errors->lowest, -deep);
	}
	if (deform_raises(scene->model))
		errors->highest = -errors->lowest;
	errors->low = errors->lowest;
	errors->high = errors->highest;
	*out = errors;
	return STATUS_OK;
}

void render_view_errors_destroy(struct view_errors *errors)
{
	if (errors == NULL)
		return;
	key_cache_finish(&errors->bases);
	resident_bounds_finish(&errors->bounds);
	mem_free(errors);
}

/* --- offsets --- */

enum status render_view_errors_touch(struct view *view, struct tile tile)
{
	return resident_bounds_add(&view->errors->bounds, tile, view->errors->low, view->errors->high);
}

/* Finds how far beside a shape's middle the ground counts, forwards and to the left. Also finds how much higher its lower envelope
 * is there. Metres. */
static void sides(const struct soil_shape *shape, double far[2], double lift[2])
{
	lift[0] = lift[1] = 0;
	switch (shape->kind) {
	case SOIL_WHEEL: /* a wheel is round only along its motion. (0.6, 0.8) is a point of the unit circle */
	case SOIL_SPHERE:
		far[0] = 0.6 * shape->radius;
		lift[0] = shape->radius - 0.8 * shape->radius;
		far[1] = shape->kind == SOIL_WHEEL ? shape->width / 2 : far[0];
		lift[1] = shape->kind == SOIL_WHEEL ? 0 : lift[0];
		return;
	case SOIL_BOX:
		far[0] = shape->size[0] / 2;
		far[1] = shape->size[1] / 2;
		return;
	case SOIL_MESH:
		for (int i = 0; i < 2; i++)
			far[i] = fmax(-shape->mesh->low[i], shape->mesh->high[i]);
		return;
	case SOIL_CYLINDER: /* in any attitude: more than it is */
	case SOIL_CAPSULE:
	case SOIL_ELLIPSOID:
		far[0] = far[1] = 0.6 * soil_shape_bound(shape);
		return;
	case SOIL_SHAPES:
		break;
	}
	far[0] = far[1] = 0;
}

/* Finds how much deeper an object on a slope digs beside its middle than at the middle, metres. */
static enum status rise_beside(struct view *view, const struct world_touch *touch, double *rise)
{
	const struct soil_pose *pose = &touch->pose;
	double far[2], lift[2], c = cos(pose->yaw), s = sin(pose->yaw);
	int64_t middle = 0;
	sides(touch->shape, far, lift);
	*rise = 0;
	for (int i = 0; i < 9; i++) {
		int x = (i + 4) % 9 % 3 - 1, y = (i + 4) % 9 / 3 - 1; /* the middle first */
		double ahead = far[0] * x, aside = far[1] * y;
		int64_t height;
		bool any;
		TRY(resident_ground_height(world_resident(view->world)->ground, pose->x + lattice_offset(ahead * c - aside * s),
					   pose->y + lattice_offset(ahead * s + aside * c), &height, &any));
		if (i == 0)
			middle = height;
		else if (any)
			*rise = fmax(*rise, lattice_offset_metres(height - middle) - lift[0] * abs(x) - lift[1] * abs(y));
	}
	return STATUS_OK;
}

enum status render_view_errors_contact(struct view *view, const struct world_touch *touch)
{
	struct view_errors *errors = view->errors;
	if (touch == NULL) {
		errors->low = errors->lowest;
		errors->high = errors->highest;
		return STATUS_OK;
	}
	double rise;
	TRY(rise_beside(view, touch, &rise));
	const double deep = fmax(touch->depth + rise, 0); /* with a load: as the soil was found to carry it in the step before */
	errors->low = -deep;
	errors->high = deform_raises(world_scene(view->world)->model) ? deep : 0;
	errors->lowest = fmin(errors->lowest, errors->low);
	errors->highest = fmax(errors->highest, errors->high);
	return STATUS_OK;
}

/* --- errors --- */

static enum status base_error(struct view *view, struct tile tile, double *error)
{
	struct key_pair known;
	struct store_range range;
	bool found;
	uint64_t key = tile_key(tile);
	*error = 0;
	TRY(key_cache_find(&view->errors->bases, key, &known, &found));
	if (found) {
		*error = known.a;
		return STATUS_OK;
	}
	if (render_view_lacks_range(view, GROUND_BASE, tile)) {
		/* Errors about halve from level to level. This guess avoids that all is divided until the error is known. */
		TRY(base_error(view, tile_ancestor(tile, tile.level + 1), error));
		*error /= 2;
		return STATUS_OK;
	}
	TRY(resident_ground_base_range(world_resident(view->world)->ground, tile, &range));
	*error = range.error;
	return key_cache_put(&view->errors->bases, key, range.error, 0);
}

enum status render_view_error(struct view *view, struct tile tile, bool expected, double *error)
{
	const struct view_errors *errors = view->errors;
	*error = 0;
	/* No tile is drawn finer than the working level if it has offsets. */
	if ((expected || render_view_is_deformed(view, tile)) && tile.level <= world_resident(view->world)->level)
		return STATUS_OK;
	double low, high;
	TRY(render_view_stored_offsets(view, tile, &low, &high));
	resident_bounds_widen(&errors->bounds, tile, &low, &high);
	double apart = high - low;
	if (expected)
		apart = fmax(apart, errors->highest - errors->lowest);
	if (tile.level > store_finest_base(world_resident(view->world)->store) || world_relief(view->world) != NULL || world_rocks(view->world) != NULL)
		TRY(base_error(view, tile, error));
	double bend = 0;
	if (tile.level <= 0 && tile.level > world_resident(view->world)->level)
		TRY(render_view_bend(view, tile, &bend));
	*error += apart + bend;
	return STATUS_OK;
}
