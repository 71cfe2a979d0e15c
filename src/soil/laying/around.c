/*
 * The strip around a patch, whatever the patch's form is. The weight of a post follows from its distance to the nearest post of the patch,
 * less half a post. Distances are exact: first along each column to the nearest post of the patch in it, once from the south and once from
 * the north. Then the least sum of two squares along each row. Nothing farther than the band is looked at.
 */
#include <math.h>

#include "soil/laying/strips.h"
#include "soil/lanes.h"

#define FARTHEST 128          /* posts: as good as no post of the patch */
#define ABREAST 4             /* columns on each side that one loop looks at */
#define NEITHER (SOIL_LOWERED | SOIL_HELD)

/* The posts that are looked at, in rows and columns of the field. */
struct ring {
	int x0, y0, width, height; /* of all of them */
	int patch_x, patch_width;  /* columns of the patch, from x0 on */
	int far;                   /* posts: as far as the band reaches */
};

/* Distances along columns, from the row before to this one. `before`: of that row; NULL: there is none. */
SOIL_LANES static void from_south(const uint8_t *patch, const int16_t *before, int16_t *apart, int count)
{
	for (int i = 0; i < count; i++) {
		const int16_t next = before != NULL && before[i] < FARTHEST ? (int16_t)(before[i] + 1) : FARTHEST;
		apart[i] = (patch[i] & NEITHER) != 0 ? 0 : next;
	}
}

/* The lesser of these and of the distances from the row after, as squares. `after`: distances of that row, which this row's replace. */
SOIL_LANES static void from_north(const int16_t *apart, int16_t *after, int16_t *squares, int count)
{
	for (int i = 0; i < count; i++) {
		const int16_t next = after[i] < FARTHEST ? (int16_t)(after[i] + 1) : FARTHEST;
		const int16_t least = apart[i] < next ? apart[i] : next;
		after[i] = least;
		squares[i] = (int16_t)(least * least);
	}
}

static inline int16_t lesser(int16_t a, int16_t b)
{
	return a < b ? a : b;
}

/* Lowers squares of distances by what lies `by` to by + ABREAST - 1 columns away on either side. */
SOIL_LANES static void look_aside(const int16_t *squares, int16_t *least, int count, int by)
{
	const int16_t a = (int16_t)(by * by), b = (int16_t)((by + 1) * (by + 1)), c = (int16_t)((by + 2) * (by + 2)), d = (int16_t)((by + 3) * (by + 3));
	const int16_t *west = squares - by, *east = squares + by;
	for (int i = 0; i < count; i++) {
		const int16_t at_a = (int16_t)(lesser(west[i], east[i]) + a), at_b = (int16_t)(lesser(west[i - 1], east[i + 1]) + b);
		const int16_t at_c = (int16_t)(lesser(west[i - 2], east[i + 2]) + c), at_d = (int16_t)(lesser(west[i - 3], east[i + 3]) + d);
		least[i] = lesser(least[i], lesser(lesser(at_a, at_b), lesser(at_c, at_d)));
	}
}

/* The weights of a row. */
SOIL_LANES static void weigh(const int16_t *least, const uint8_t *contact, const int32_t *base, int32_t band, int count, uint16_t *weights,
			     uint32_t *sum_of, uint32_t *heaviest_of)
{
	const int32_t level = band / 3;
	int32_t sum = 0, heaviest = 0;
	for (int i = 0; i < count; i++) {
		/* The root of a number that a float holds exactly. Rounded, it may reach the next whole number. */
		const int32_t square = (int32_t)least[i] << 12, guess = (int32_t)sqrtf((float)square), root = guess - (guess * guess > square);
		const int32_t from_edge = root - 32, from_end = band - from_edge;
		int32_t weight = from_edge < from_end ? from_edge : from_end;
		weight = weight < level ? weight : level;
		weight = weight > 0 ? weight : 0;
		const bool open = (contact[i] & NEITHER) == 0 && base[i] != BASE_NODATA;
		const int32_t gets = open ? weight : 0;
		weights[i] = (uint16_t)gets;
		sum += gets;
		heaviest = gets > heaviest ? gets : heaviest;
	}
	*sum_of = (uint32_t)sum;
	*heaviest_of = (uint32_t)heaviest;
}

static struct ring ring_of(const struct laying_field *field, const struct soil_measured *measured)
{
	const int far = (field->band >> 6) + 1;
	const struct post_rect all = {field->x0, field->y0, field->x0 + field->width, field->y0 + field->height};
	const struct post_rect patch = post_rect_intersect(measured->patch, all);
	const struct post_rect ring = post_rect_intersect(post_rect_grown(patch, far), all);
	return (struct ring){
		.x0 = (int)(ring.x0 - field->x0), .y0 = (int)(ring.y0 - field->y0), .width = (int)(ring.x1 - ring.x0),
		.height = (int)(ring.y1 - ring.y0), .patch_x = (int)(patch.x0 - ring.x0), .patch_width = (int)(patch.x1 - patch.x0), .far = far,
	};
}

void soil_strip_around(const struct laying_field *field, const struct soil_measured *measured, struct strip *strip, struct strip_run *runs)
{
	const struct ring ring = ring_of(field, measured);
	const int columns = ring.patch_width;
	*strip = (struct strip){.face = SOIL_AHEAD, .first_row = ring.y0, .rows = ring.height, .runs = runs};
	const uint8_t *patch = field->patch + ring.x0 + ring.patch_x;
	for (int k = 0; k < ring.height; k++) {
		int16_t *row = field->apart + (size_t)k * (size_t)columns;
		from_south(patch + (size_t)(ring.y0 + k) * field->stride, k > 0 ? row - columns : NULL, row, columns);
	}
	/* From north to south. So of rows with an equally heavy post the first one counts. */
	int16_t *after = field->apart + (size_t)ring.height * (size_t)columns, *aside = after + columns, *least = aside + ring.width + 2 * STRIP_FAR_MOST;
	int16_t *squares = aside + STRIP_FAR_MOST;
	for (int i = 0; i < columns; i++)
		after[i] = FARTHEST;
	for (int i = 0; i < ring.width + 2 * STRIP_FAR_MOST; i++)
		aside[i] = FARTHEST * FARTHEST;
	for (int k = ring.height - 1; k >= 0; k--) {
		const int row = ring.y0 + k;
		uint32_t sum, heaviest;
		from_north(field->apart + (size_t)k * (size_t)columns, after, squares + ring.patch_x, columns);
		for (int i = 0; i < ring.width; i++)
			least[i] = squares[i];
		for (int by = 1; by <= ring.far; by += ABREAST)
			look_aside(squares, least, ring.width, by);
		const size_t at = (size_t)row * field->stride + (size_t)ring.x0;
		weigh(least, field->contact + at, field->base + at, field->band, ring.width,
		      field->weights + (size_t)row * (size_t)field->width + ring.x0, &sum, &heaviest);
		runs[k] = (struct strip_run){ring.x0, ring.width};
		strip->sum += sum;
		if (heaviest > strip->heaviest) {
			strip->heaviest = heaviest;
			strip->heaviest_row = row;
		}
	}
}
