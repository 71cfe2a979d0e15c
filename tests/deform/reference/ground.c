/* A field of posts, and where an object's lower envelope is above it. */
#include <math.h>

#include "deform/reference/reference.h"

enum status reference_ground_init(struct reference_ground *ground, int width, int height, double spacing)
{
	size_t count = (size_t)width * (size_t)height;
	*ground = (struct reference_ground){
		.width = width,
		.height = height,
		.spacing = spacing,
		.written = {0, 0, width, height},
		.base = mem_calloc(count, sizeof(double)),
		.offset = mem_calloc(count, sizeof(double)),
		.heaped = mem_calloc(count, sizeof(double)),
		.pressed = mem_calloc(count, sizeof(double)),
		.dug = mem_calloc(count, sizeof(double)),
		.shear = {mem_calloc(count, sizeof(double)), mem_calloc(count, sizeof(double))},
		.carried = mem_calloc(count, sizeof(double)),
		.contact = mem_calloc(count, sizeof(uint8_t)),
		.hole = mem_calloc(count, sizeof(bool)),
	};
	if (ground->base != NULL && ground->offset != NULL && ground->heaped != NULL && ground->pressed != NULL &&
	    ground->dug != NULL && ground->shear[0] != NULL && ground->shear[1] != NULL && ground->carried != NULL && ground->contact != NULL && ground->hole != NULL)
		return STATUS_OK;
	reference_ground_finish(ground);
	return fail_memory("reference");
}

void reference_ground_finish(struct reference_ground *ground)
{
	mem_free(ground->base);
	mem_free(ground->offset);
	mem_free(ground->heaped);
	mem_free(ground->pressed);
	mem_free(ground->dug);
	mem_free(ground->shear[0]);
	mem_free(ground->shear[1]);
	mem_free(ground->carried);
	mem_free(ground->contact);
	mem_free(ground->hole);
	*ground = (struct reference_ground){0};
}

double reference_volume(const struct reference_ground *ground)
{
	long double height = 0;
	for (int i = 0; i < ground->width * ground->height; i++)
		height += (long double)ground->offset[i] + ground->carried[i];
	return (double)(height * ground->spacing * ground->spacing + ground->compacted);
}

/* No part of the object is further than this from its centre. */
static double reach_of(const struct soil_shape *shape)
{
	double squares = 0;
	switch (shape->kind) {
	case SOIL_WHEEL:
		return hypot(shape->radius + shape->grouser_height, shape->width / 2);
	case SOIL_SPHERE:
		return shape->radius;
	case SOIL_BOX:
		for (int k = 0; k < 3; k++)
			squares += shape->size[k] * shape->size[k] / 4;
		return sqrt(squares);
	case SOIL_MESH:
		for (int k = 0; k < 3; k++) {
			double far = fmax(fabs(shape->mesh->low[k]), fabs(shape->mesh->high[k]));
			squares += far * far;
		}
		return sqrt(squares);
	case SOIL_CYLINDER:
		return hypot(shape->radius, shape->length / 2);
	case SOIL_CAPSULE:
		return shape->radius + shape->length / 2;
	case SOIL_ELLIPSOID:
		return fmax(fmax(shape->size[0], shape->size[1]), shape->size[2]);
	case SOIL_SHAPES:
		break;
	}
	return 0;
}

static double above(const struct deform_contact *sweep, long double x, long double y)
{
	long double z;
	if (!reference_underside(sweep, x, y, &z))
		return INFINITY;
	return (double)(ldexpl((long double)sweep->from.z, -OFFSET_BITS) + z);
}

void reference_undersides(const struct reference_ground *ground, const struct deform_contact *sweep, double *under,
			  double *rest)
{
	struct deform_contact end = *sweep;
	end.from = end.to;
	long double from_x = ldexpl((long double)sweep->from.x, -OFFSET_BITS), to_x = ldexpl((long double)sweep->to.x, -OFFSET_BITS);
	long double from_y = ldexpl((long double)sweep->from.y, -OFFSET_BITS), to_y = ldexpl((long double)sweep->to.y, -OFFSET_BITS);
	long double reach = reach_of(sweep->shape) + ground->spacing;
	for (int i = 0; i < ground->width * ground->height; i++) {
		long double x = (long double)(ground->left + i % ground->width) * ground->spacing;
		long double y = (long double)(ground->bottom + i / ground->width) * ground->spacing;
		under[i] = rest[i] = INFINITY;
		if (x < fminl(from_x, to_x) - reach || x > fmaxl(from_x, to_x) + reach || y < fminl(from_y, to_y) - reach ||
		    y > fmaxl(from_y, to_y) + reach)
			continue;
		under[i] = above(sweep, x - from_x, y - from_y);
		rest[i] = above(&end, x - to_x, y - to_y);
	}
}
