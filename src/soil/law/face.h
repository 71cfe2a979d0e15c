/*
 * The lower envelope of a body at any place: its height, slope and normal, how it bends, and how much lower it was. The last is of the whole motion.
 * Beside the body these go on from its edge. `kind` is known where a loop over lanes is compiled, so each form has its own loop.
 * own: of an end: 1 if the lower end alone bears, 2 if the higher of its end and its side does at each place. Of a box: 1 + the face below which a post lies,
 * which goes on beside it; 0: the highest face at each place. Of a wall: 1 + its number.
 */
#ifndef FURROW_SOIL_FACE_H
#define FURROW_SOIL_FACE_H

#include "soil/law/form.h"

struct face {
	float height, slope[2], normal[3];
	float end; /* 1: the flat end of a cylinder, which bears by its area in plan */
};

SOIL_INLINED void put_normal(const float slope[2], float normal[3])
{
	const float squares = slope[0] * slope[0] + slope[1] * slope[1], less = least(1, FORM_STEEPEST / sqrtf(most(squares, 1)));
	const float x = slope[0] * less, y = slope[1] * less, up = 1 / sqrtf(1 + x * x + y * y);
	normal[0] = -x * up;
	normal[1] = -y * up;
	normal[2] = up;
}

SOIL_INLINED void rim_face(const struct soil_form *f, float x, float y, struct face *face)
{
	const float far = FORM_STEEPEST_PART * f->radius, ahead = clamped(x, -far, far), strip = half_strip(f, ahead), up = strip * f->by_radius;
	face->height = (f->lean * y - half_strip(f, x)) * f->lift;
	face->slope[0] = ahead / strip * f->lift;
	face->slope[1] = f->lean * f->lift;
	face->normal[0] = -ahead * f->by_radius;
	face->normal[1] = -f->lean * up;
	face->normal[2] = f->level * up;
	face->end = 0;
}

SOIL_INLINED void ball_face(const struct soil_form *f, float x, float y, struct face *face)
{
	const float grows = f->ahead_by * (x + f->skew * y), half[2] = {grows, f->skew * grows + f->aside_by * y};
	const float squares = x * half[0] + y * half[1], below = root(1 - squares);
	const float steep = f->drop / most(below, sqrtf(most(1, squares)) * (1 / FORM_STEEPEST));
	face->height = f->tilt[0] * x + f->tilt[1] * y - f->drop * below;
	face->slope[0] = f->tilt[0] + half[0] * steep;
	face->slope[1] = f->tilt[1] + half[1] * steep;
	face->end = 0;
	put_normal(face->slope, face->normal);
}

SOIL_INLINED float end_height(const struct soil_form *f, float y)
{
	return (low_side(f) * y * f->level - f->half_axis) / most(fabsf(f->lean), 1e-6f);
}

SOIL_INLINED void end_face(const struct soil_form *f, float own, float x, float y, struct face *face)
{
	rim_face(f, x, y, face);
	const float end = end_height(f, y), is = either((own == 1) | (end > face->height), 1, 0);
	face->height = either(is > 0, end, face->height);
	face->slope[0] = either(is > 0, 0, face->slope[0]);
	face->slope[1] = either(is > 0, low_side(f) * f->level / most(fabsf(f->lean), 1e-6f), face->slope[1]);
	face->end = is;
	put_normal(face->slope, face->normal);
}

/* Which part of a capsule is above a place: -1: the lower end, 0: its side, 1: the upper end. */
SOIL_INLINED float capsule_end(const struct soil_form *f, float axial, float strip)
{
	const float middle = strip * f->lean, reach = f->half_axis * f->level;
	return either(axial <= middle - reach, -1, either(axial > middle + reach, 1, 0));
}

SOIL_INLINED void capsule_face(const struct soil_form *f, float x, float y, struct face *face)
{
	const float axial = f->along[0] * x + f->along[1] * y, aside = f->along[0] * y - f->along[1] * x, strip = half_strip(f, aside);
	const float end = capsule_end(f, axial, strip), reach = end * f->half_axis;
	/* The ball at an end. */
	const float from[2] = {x - reach * f->level * f->along[0], y - reach * f->level * f->along[1]};
	const float squares = from[0] * from[0] + from[1] * from[1], r2 = f->radius * f->radius, below = root(r2 - squares);
	const float z = most(below, sqrtf(most(r2, squares)) * (1 / FORM_STEEPEST));
	/* The side. */
	const float middle = strip * f->lean, up = most(f->level * strip, f->radius * (1 / FORM_STEEPEST));
	const float side[2] = {-middle * f->along[0] + aside * f->along[1], -middle * f->along[1] - aside * f->along[0]};
	face->height = either(end != 0, reach * f->lean - below, (f->lean * axial - strip) / f->level);
	for (int k = 0; k < 2; k++)
		face->slope[k] = either(end != 0, from[k] / z, -side[k] / up);
	face->end = 0;
	put_normal(face->slope, face->normal);
}

SOIL_INLINED void box_face(const struct soil_form *f, float own, float x, float y, struct face *face)
{
	face->height = -1e9f;
	face->slope[0] = face->slope[1] = face->end = 0;
	for (int k = 0; k < 3; k++) {
		const float height = f->faces[k][0] + f->faces[k][1] * x + f->faces[k][2] * y;
		const bool higher = (height > face->height) & ((own == 0) | (own == (float)(1 + k)));
		face->height = either(higher, height, face->height);
		face->slope[0] = either(higher, f->faces[k][1], face->slope[0]);
		face->slope[1] = either(higher, f->faces[k][2], face->slope[1]);
	}
	put_normal(face->slope, face->normal);
}

/* The lower envelope at a wall: the wall, or what is higher. */
SOIL_INLINED void wall_face(const struct soil_form *f, float own, float x, float y, struct face *face)
{
	const struct soil_box_wall *first = &f->walls[0], *second = &f->walls[1];
	const bool one = own == 1;
	const float n[3] = {either(one, first->normal[0], second->normal[0]), either(one, first->normal[1], second->normal[1]), either(one, first->normal[2], second->normal[2])};
	const float at[2] = {either(one, first->at[0], second->at[0]), either(one, first->at[1], second->at[1])}, low = either(one, first->low, second->low);
	const float height = low - (n[0] * (x - at[0]) + n[1] * (y - at[1])) / n[2];
	box_face(f, 0, x, y, face);
	const bool higher = height >= face->height - 1e-6f;
	face->height = most(height, face->height);
	for (int k = 0; k < 2; k++)
		face->slope[k] = either(higher, -n[k] / n[2], face->slope[k]);
	for (int k = 0; k < 3; k++)
		face->normal[k] = either(higher, n[k], face->normal[k]);
}

/* A place between those of a raster. */
struct fine_place {
	int32_t at;
	float p, q; /* share of the way to the next column, and to the next row */
};

SOIL_INLINED struct fine_place fine_place_at(const struct soil_fine *fine, float x, float y)
{
	const float east = (fine->axis[0] * x - fine->axis[1] * y - fine->x) * fine->by_step, north = (fine->axis[1] * x + fine->axis[0] * y - fine->y) * fine->by_step;
	const float u = clamped(east, 0, (float)fine->columns - 1.001f), v = clamped(north, 0, (float)fine->rows - 1.001f);
	const int32_t column = (int32_t)u, row = (int32_t)v;
	return (struct fine_place){row * fine->stride + column, u - (float)column, v - (float)row};
}

SOIL_INLINED float fine_at(const struct soil_fine *fine, const float *raster, const struct fine_place *place)
{
	const float a = raster[place->at], b = raster[place->at + fine->east], c = raster[place->at + fine->stride], d = raster[place->at + fine->stride + fine->east];
	const float low = a + place->p * (b - a), high = c + place->p * (d - c);
	return low + place->q * (high - low);
}

/* Puts the mean slopes of a raster over the places that are up to `by` places away, to the east and to the north. They change evenly where the body moves
 * over the ground, also across an edge of the mesh. */
SOIL_INLINED void put_raster_slope(const struct soil_form *f, float x, float y, float by, float slope[2])
{
	const struct soil_fine *fine = &f->fine;
	const float away = by * fine->step, over = 0.5f / away, c = fine->axis[0], s = fine->axis[1];
	const float ahead[2] = {c * away, -s * away}, aside[2] = {s * away, c * away}; /* to the east, to the north, in the frame */
	const struct fine_place east = fine_place_at(fine, x + ahead[0], y + ahead[1]), west = fine_place_at(fine, x - ahead[0], y - ahead[1]);
	const struct fine_place north = fine_place_at(fine, x + aside[0], y + aside[1]), south = fine_place_at(fine, x - aside[0], y - aside[1]);
	const float rise[2] = {(fine_at(fine, fine->heights, &east) - fine_at(fine, fine->heights, &west)) * over,
			       (fine_at(fine, fine->heights, &north) - fine_at(fine, fine->heights, &south)) * over};
	slope[0] = c * rise[0] + s * rise[1];
	slope[1] = c * rise[1] - s * rise[0];
}

/* Between the places of a raster the height is bilinear. Two places of a cell bear, so each has the mean slope of half of the cell's length. */
SOIL_INLINED void raster_face(const struct soil_form *f, float x, float y, struct face *face)
{
	const struct fine_place place = fine_place_at(&f->fine, x, y);
	face->height = fine_at(&f->fine, f->fine.heights, &place);
	put_raster_slope(f, x, y, 0.25f * (float)f->fine.parts, face->slope);
	face->end = 0;
	put_normal(face->slope, face->normal);
}

SOIL_INLINED void face_at(const struct soil_form *f, enum soil_form_kind kind, float own, float x, float y, struct face *face)
{
	switch (kind) {
	case FORM_RIM:
		rim_face(f, x, y, face);
		break;
	case FORM_BALL:
		ball_face(f, x, y, face);
		break;
	case FORM_CAPSULE:
		capsule_face(f, x, y, face);
		break;
	case FORM_BOX:
		box_face(f, own, x, y, face);
		break;
	case FORM_WALL:
		wall_face(f, own, x, y, face);
		break;
	case FORM_END:
		end_face(f, own, x, y, face);
		break;
	case FORM_RASTER:
		raster_face(f, x, y, face);
		break;
	}
}

SOIL_INLINED float height_at(const struct soil_form *f, enum soil_form_kind kind, float own, float x, float y)
{
	struct face face = {.height = 0};
	if (kind == FORM_RIM)
		return (f->lean * y - half_strip(f, x)) * f->lift;
	face_at(f, kind, own, x, y, &face); /* what is not used is not computed */
	return face.height;
}

/* Returns true if circles tell how a body of this kind moved over a place. A raster knows it at each of its places. */
SOIL_INLINED bool is_round(enum soil_form_kind kind)
{
	return kind == FORM_RIM || kind == FORM_BALL;
}

/* Gives the square of the radius of the circle through a place, and how far ahead of the circle's middle the place is. */
SOIL_INLINED float ring_squares(const struct soil_form *f, enum soil_form_kind kind, float y)
{
	return kind == FORM_BALL ? most(1 - f->aside_by * y * y, 0) / f->ahead_by : f->radius * f->radius;
}

SOIL_INLINED float ring_ahead(const struct soil_form *f, enum soil_form_kind kind, float x, float y)
{
	return kind == FORM_BALL ? x + f->skew * y : x;
}

/* Returns how much lower a circle is at x than at `inside`, both m ahead of its middle. down: how far below its middle it is at `inside`. */
SOIL_INLINED float lower_by(const struct soil_form *f, float squares, float x, float inside, float down)
{
	return f->lift * ((inside - x) * (inside + x)) / most(root(squares - x * x) + down, 1e-9f);
}

/* The same as lowered_at of a raster. */
SOIL_INLINED float raster_lowered(const struct soil_form *f, float x, float y, float less_before, float *since)
{
	const struct fine_place place = fine_place_at(&f->fine, x, y);
	*since = f->fine.moved * fine_at(&f->fine, f->fine.since, &place);
	return f->fine.moved * most(fine_at(&f->fine, f->fine.less, &place) - less_before, 0) + (1 - f->fine.moved) * most(f->way[2], 0);
}

/* Returns true if lowered_at knows the motion of this kind at any place, not at posts alone. */
SOIL_INLINED bool knows_places(enum soil_form_kind kind)
{
	return is_round(kind) || kind == FORM_RASTER;
}

/* Returns how far ahead of its middle a circle is lowest that moves along ground which rises by `ground` for each metre. */
SOIL_INLINED float bottom_of(const struct soil_form *f, enum soil_form_kind kind, float ring, float ground)
{
	const float rise = kind == FORM_BALL ? ground - f->tilt[0] : ground;
	return ring * rise / sqrtf(f->lift * f->lift + rise * rise);
}

/* The same of a rim, all of whose circles have one radius. */
SOIL_INLINED float rim_bottom(const struct soil_form *f, float ground)
{
	return bottom_of(f, FORM_RIM, sqrtf(f->radius * f->radius), ground);
}

/* Returns how much lower than now a round body was above a place during its last `back` metres. Before its present motion it moved along the
 * ground, which rises by `ground` for each metre. bottom: of a rim, rim_bottom. less_before: by how much less that way lowered it. *since: how many
 * motions ago it was lowest. */
SOIL_INLINED float lowered_at(const struct soil_form *f, enum soil_form_kind kind, float x, float y, float back, float ground, float bottom,
			      float less_before, float *since)
{
	if (kind == FORM_RASTER)
		return raster_lowered(f, x, y, less_before, since);
	const float squares = ring_squares(f, kind, y), ring = sqrtf(squares), ahead = ring_ahead(f, kind, x, y);
	const float rise = kind == FORM_BALL ? ground - f->tilt[0] : ground, at_bottom = kind == FORM_RIM ? bottom : bottom_of(f, kind, ring, ground);
	const float first = ahead + f->run, inside = clamped(ahead, -ring, ring), down = root(squares - ahead * ahead);
	const float within = clamped(least(most(ring * f->sine, ahead), first), -ring, ring);
	const float earlier = clamped(least(most(at_bottom, first), ahead + back), -ring, ring);
	const float less = lower_by(f, squares, within, inside, down) + f->rise * (within - ahead);
	const float before = lower_by(f, squares, earlier, inside, down) + f->rise * (earlier - ahead) + most(earlier - first, 0) * (rise - f->rise) - less_before;
	/* A body that does not go along its circles was lowest at the motion's start, or is so now. */
	const bool runs = f->run > 0;
	*since = either(runs, most(either(before > less, earlier, within) - ahead, 0) / most(f->run, 1e-12f), 1);
	return most(either(runs, most(less, before), f->plunge * f->lift), 0);
}

/* Adds the second derivatives of a ball's height: xx, xy, yy, 1/m. */
SOIL_INLINED void put_bends(const struct soil_form *f, enum soil_form_kind kind, float own, float x, float y, const struct face *face, float bends[3])
{
	bends[0] = bends[1] = bends[2] = 0;
	if (kind == FORM_RIM || kind == FORM_END) {
		const float up = most(half_strip(f, x) * f->by_radius, FORM_UPRIGHT);
		bends[0] = either(face->end > 0, 0, f->lift * f->by_radius / (up * up * up));
	} else if (kind == FORM_CAPSULE) {
		const float axial = f->along[0] * x + f->along[1] * y, aside = f->along[0] * y - f->along[1] * x, strip = half_strip(f, aside);
		const float *n = face->normal, nx = n[0] / n[2], ny = n[1] / n[2], ball = f->by_radius / n[2];
		const float up = most(strip * f->by_radius, FORM_UPRIGHT), side = f->by_radius / (f->level * up * up * up);
		const bool end = capsule_end(f, axial, strip) != 0;
		bends[0] = either(end, ball * (1 + nx * nx), side * f->along[1] * f->along[1]);
		bends[1] = either(end, ball * nx * ny, -side * f->along[0] * f->along[1]);
		bends[2] = either(end, ball * (1 + ny * ny), side * f->along[0] * f->along[0]);
	} else if (kind == FORM_BALL) {
		const float grows = f->ahead_by * (x + f->skew * y), half[2] = {grows, f->skew * grows + f->aside_by * y};
		const float squares = x * half[0] + y * half[1], below = most(root(1 - squares), sqrtf(most(1, squares)) * (1 / FORM_STEEPEST));
		const float by = f->drop / below, more = by / (below * below);
		bends[0] = by * f->ahead_by + more * half[0] * half[0];
		bends[1] = by * f->ahead_by * f->skew + more * half[0] * half[1];
		bends[2] = by * (f->ahead_by * f->skew * f->skew + f->aside_by) + more * half[1] * half[1];
	}
	(void)own;
}

#endif
