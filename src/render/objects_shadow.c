/*
 * The parts of an object's shadow: a simple form, and a volume in which it shades the ground. The form is the shape itself, without
 * a wheel's grousers. For a mesh it is the box around it, for a capsule a cylinder, for an ellipsoid a ball. The volume is a box along
 * the sun's rays. It begins on the object's sunny side. It ends where the ray past the object's top has come down by twice the object's
 * height and some metres more. So the ground may fall away from the object.
 */
#include <math.h>
#include <string.h>

#include "render/objects.h"

#define DROP 3.0      /* metres that the volume reaches below twice the object's height: parts of vehicles are so high above the ground */
#define LOWEST 0.0175 /* sine of the sun's height: below 1 degree shadows do not get longer */
#define SPREAD 0.0047 /* metres by which half a shadow's edge widens with each metre: the sun's radius in radians. shadow.frag has it, too */

/* Returns half the form's size along a direction of length 1. */
static double extent(const struct object_shadow *shadow, double axes[3][3], const double along[3])
{
	double part[3];
	for (int i = 0; i < 3; i++)
		part[i] = fabs(axes[i][0] * along[0] + axes[i][1] * along[1] + axes[i][2] * along[2]);
	const float *half = shadow->form;
	if (shadow->kind[0] == 2)
		return half[0];
	if (shadow->kind[0] == 1)
		return part[1] * half[1] + sqrt(fmax(0, 1 - part[1] * part[1])) * half[0];
	return part[0] * half[0] + part[1] * half[1] + part[2] * half[2];
}

/* Fills the form around the object's centre. *middle: the form's own middle, in the object's axes. */
static void form_of(const struct soil_shape *shape, struct object_shadow *shadow, double middle[3])
{
	double half[3] = {shape->radius, shape->radius, shape->radius};
	memset(middle, 0, 3 * sizeof *middle);
	const bool rod = shape->kind == SOIL_CYLINDER || shape->kind == SOIL_CAPSULE;
	shadow->kind[0] = shape->kind == SOIL_SPHERE || shape->kind == SOIL_ELLIPSOID ? 2 : rod || shape->kind == SOIL_WHEEL ? 1 : 0;
	if (rod)
		half[1] = shape->length / 2 + (shape->kind == SOIL_CAPSULE ? shape->radius : 0);
	for (int k = 0; k < 3 && shape->kind == SOIL_ELLIPSOID; k++) /* a ball of its volume */
		half[k] = cbrt(shape->size[0] * shape->size[1] * shape->size[2]);
	if (shape->kind == SOIL_WHEEL) {
		half[1] = shape->width / 2;
		half[0] = half[2] = shape->radius + (shape->grousers > 0 ? shape->grouser_height / 2 : 0);
	}
	for (int k = 0; k < 3 && shape->kind == SOIL_BOX; k++)
		half[k] = shape->size[k] / 2;
	for (int k = 0; k < 3 && shape->kind == SOIL_MESH; k++) {
		half[k] = fmax((shape->mesh->high[k] - shape->mesh->low[k]) / 2, 1e-4);
		middle[k] = (shape->mesh->high[k] + shape->mesh->low[k]) / 2;
	}
	for (int k = 0; k < 3; k++)
		shadow->form[k] = (float)half[k];
	shadow->form[3] = (float)cbrt(half[0] * half[1] * half[2]);
}

/* Fills the axes of the form. A cylinder and a capsule are round about their own z, and their form about its y axis. */
static void axes_of(const struct soil_shape *shape, double axes[3][3], double form[3][3])
{
	bool upright = shape->kind == SOIL_CYLINDER || shape->kind == SOIL_CAPSULE;
	memcpy(form, axes, 9 * sizeof **axes);
	for (int k = 0; k < 3 && upright; k++) {
		form[1][k] = axes[2][k];
		form[2][k] = -axes[1][k];
	}
}

static void row(float to[4], const double axis[3], const double origin[3], double scale)
{
	for (int k = 0; k < 3; k++)
		to[k] = (float)(axis[k] * scale);
	to[3] = (float)(-(axis[0] * origin[0] + axis[1] * origin[1] + axis[2] * origin[2]) * scale);
}

void render_object_shadow_of(const struct soil_shape *shape, double axes[3][3], const double at[3], const double sun[3],
		      struct object_shadow *shadow, double middle[3], double *radius)
{
	double own[3], centre[3], form[3][3], level = hypot(sun[0], sun[1]);
	form_of(shape, shadow, own);
	axes_of(shape, axes, form);
	for (int k = 0; k < 3; k++)
		centre[k] = at[k] + axes[0][k] * own[0] + axes[1][k] * own[1] + axes[2][k] * own[2];
	for (int i = 0; i < 3; i++)
		row(shadow->to_own[i], form[i], centre, 1);

	/* Along the light, level across it, and the third. */
	const double east = level > 0 ? -sun[0] / level : 1, north = level > 0 ? -sun[1] / level : 0;
	const double away[3] = {-sun[0], -sun[1], -sun[2]}, across[3] = {-north, east, 0}, over[3] = {east * sun[2], north * sun[2], level};
	const double upright[3] = {0, 0, 1}, size = (double)shadow->form[3];
	const double along = extent(shadow, form, away), wide = extent(shadow, form, across), thick = extent(shadow, form, over);
	const double drop = 4 * extent(shadow, form, upright) + DROP, length = fmax(drop / fmax(sun[2], LOWEST), along + size);
	/* Beside the form there is shade from the sky, and the shadow's soft edge. */
	const double beside = fmax(0.8 * size, 0.1 * size + SPREAD * length);
	const double half[3] = {(along + beside + length) / 2, wide + beside, thick + beside};
	for (int k = 0; k < 3; k++)
		middle[k] = centre[k] + away[k] * (length - along - beside) / 2;
	row(shadow->to_volume[0], away, middle, 1 / half[0]);
	row(shadow->to_volume[1], across, middle, 1 / half[1]);
	row(shadow->to_volume[2], over, middle, 1 / half[2]);
	*radius = sqrt(half[0] * half[0] + half[1] * half[1] + half[2] * half[2]);
}
