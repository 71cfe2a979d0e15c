/*
 * The struck capacity of a body: the soil that it holds when a straightedge has levelled it, as SAE J296 measures buckets.
 *
 * The body's upper envelope is sampled on a grid. The straightedge rests on the body along each row, and along each column: its height is the upper convex hull of the
 * envelope there. Over a row it goes from one end of the body to the other, without its gaps. The soil reaches as high as the lower one of both. So a side
 * that is open, or low, holds back no more soil than is behind it.
 */
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "soil/carried.h"

#define CELLS 512 /* along the longer side of the body, in plan */

struct field {
	int columns, rows;
	double cell, low[2];    /* m; of its south-west corner */
	double *tops;           /* m: the envelope in the middle of each cell; -INFINITY: the body is not below it */
	double *rims;           /* the same with the edges of the body's triangles, so that a wall without thickness counts */
	double *struck;         /* height of the straightedge */
	size_t *hull;
};

typedef void (*triangle_fn)(struct field *field, double at[3][3]);

/* Calls `take` with each triangle of the part, in the axes of the whole. */
static void each_triangle(const struct soil_part *part, struct field *field, triangle_fn take)
{
	static const uint8_t faces[12][3] = {{0, 1, 3}, {0, 3, 2}, {4, 7, 5}, {4, 6, 7}, {0, 5, 1}, {0, 4, 5}, {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
	const struct soil_shape *shape = part->shape;
	const bool box = shape->kind == SOIL_BOX;
	const uint32_t count = box ? 12 : shape->kind == SOIL_MESH ? shape->mesh->triangle_count : 0;
	for (uint32_t t = 0; t < count; t++) {
		double at[3][3];
		for (int i = 0; i < 3; i++) {
			double v[3];
			for (int k = 0; k < 3; k++)
				v[k] = box ? shape->size[k] * ((faces[t][i] >> k & 1) != 0 ? 0.5 : -0.5) : (double)shape->mesh->vertices[shape->mesh->triangles[t][i]][k];
			for (int k = 0; k < 3; k++)
				at[i][k] = part->at[k] + v[0] * part->axes[0][k] + v[1] * part->axes[1][k] + v[2] * part->axes[2][k];
		}
		take(field, at);
	}
}

/* Widens the bounds in plan: their high ends are in `tops`, before the planes are made. */
static void bound(struct field *field, double at[3][3])
{
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 2; k++) {
			field->low[k] = fmin(field->low[k], at[i][k]);
			field->tops[k] = fmax(field->tops[k], at[i][k]);
		}
}

static void raise(double *height, double z)
{
	*height = fmax(*height, z);
}

/* Samples an edge twice a cell. */
static void draw_edge(struct field *field, const double a[3], const double b[3])
{
	const int parts = (int)ceil(2 * fmax(fabs(b[0] - a[0]), fabs(b[1] - a[1])) / field->cell) + 1;
	for (int i = 0; i <= parts; i++) {
		const double by = (double)i / parts;
		const int x = (int)floor((a[0] + (b[0] - a[0]) * by - field->low[0]) / field->cell), y = (int)floor((a[1] + (b[1] - a[1]) * by - field->low[1]) / field->cell);
		const int column = x < 0 ? 0 : x < field->columns ? x : field->columns - 1, row = y < 0 ? 0 : y < field->rows ? y : field->rows - 1;
		raise(&field->rims[(size_t)row * (size_t)field->columns + (size_t)column], a[2] + (b[2] - a[2]) * by);
	}
}

static void draw(struct field *field, double at[3][3])
{
	const double ax = at[1][0] - at[0][0], ay = at[1][1] - at[0][1], bx = at[2][0] - at[0][0], by = at[2][1] - at[0][1], twice = ax * by - ay * bx;
	int first[2], last[2];
	for (int k = 0; k < 2; k++) {
		const double low = fmin(at[0][k], fmin(at[1][k], at[2][k])), high = fmax(at[0][k], fmax(at[1][k], at[2][k]));
		first[k] = (int)floor((low - field->low[k]) / field->cell);
		last[k] = (int)ceil((high - field->low[k]) / field->cell);
		first[k] = first[k] < 0 ? 0 : first[k];
		last[k] = last[k] < (k == 0 ? field->columns : field->rows) ? last[k] : (k == 0 ? field->columns : field->rows);
	}
	for (int i = 0; i < 3; i++)
		draw_edge(field, at[i], at[(i + 1) % 3]);
	if (!(fabs(twice) > 1e-12 * field->cell * field->cell))
		return;
	for (int row = first[1]; row < last[1]; row++)
		for (int column = first[0]; column < last[0]; column++) {
			const double x = field->low[0] + (column + 0.5) * field->cell - at[0][0], y = field->low[1] + (row + 0.5) * field->cell - at[0][1];
			const double u = (x * by - y * bx) / twice, v = (ax * y - ay * x) / twice;
			if (u < -1e-9 || v < -1e-9 || u + v > 1 + 1e-9)
				continue;
			const double z = at[0][2] + u * (at[1][2] - at[0][2]) + v * (at[2][2] - at[0][2]);
			const size_t i = (size_t)row * (size_t)field->columns + (size_t)column;
			raise(&field->tops[i], z);
			raise(&field->rims[i], z);
		}
}

/* Lowers `struck` to the upper hull of one row or column: `count` cells, `step` apart. Without the gaps, where the body is not below a cell. */
static void strike_line(struct field *field, size_t from, size_t step, int count)
{
	const double *rims = field->rims;
	size_t *hull = field->hull;
	for (int begin = 0, end; begin < count; begin = end + 1) {
		size_t kept = 0;
		for (end = begin; end < count && rims[from + (size_t)end * step] > -INFINITY; end++) {
			const double z = rims[from + (size_t)end * step];
			while (kept > 1) {
				const size_t b = hull[kept - 1], a = hull[kept - 2];
				const double za = rims[from + a * step], zb = rims[from + b * step];
				if ((zb - za) * (double)((size_t)end - a) > (z - za) * (double)(b - a))
					break;
				kept--;
			}
			hull[kept++] = (size_t)end;
		}
		for (size_t k = 0; k + 1 < kept; k++) {
			const double za = rims[from + hull[k] * step], zb = rims[from + hull[k + 1] * step];
			for (size_t i = hull[k]; i <= hull[k + 1]; i++) {
				double *struck = &field->struck[from + i * step];
				const double z = za + (zb - za) * (double)(i - hull[k]) / (double)(hull[k + 1] - hull[k]);
				*struck = fmin(*struck, z);
			}
		}
		if (kept == 1)
			field->struck[from + hull[0] * step] = rims[from + hull[0] * step];
	}
}

static double volume(struct field *field)
{
	const size_t columns = (size_t)field->columns, rows = (size_t)field->rows;
	double sum = 0;
	for (size_t row = 0; row < rows; row++)
		strike_line(field, row * columns, 1, field->columns);
	for (size_t column = 0; column < columns; column++)
		strike_line(field, column, columns, field->rows);
	for (size_t i = 0; i < rows * columns; i++)
		sum += field->tops[i] > -INFINITY ? fmax(field->struck[i] - field->tops[i], 0) : 0;
	return sum * field->cell * field->cell;
}

/* Makes the grid around all parts. Returns false if there is nothing. */
static bool bounds_of(const struct soil_part *parts, size_t count, struct field *field)
{
	double high[2] = {-INFINITY, -INFINITY};
	field->low[0] = field->low[1] = INFINITY;
	field->tops = high;
	for (size_t i = 0; i < count; i++)
		each_triangle(&parts[i], field, bound);
	field->tops = NULL;
	const double wide = high[0] - field->low[0], deep = high[1] - field->low[1], longest = fmax(wide, deep);
	if (!(longest > 0) || !isfinite(longest))
		return false;
	field->cell = longest / CELLS;
	field->columns = (int)fmax(ceil(wide / field->cell), 1);
	field->rows = (int)fmax(ceil(deep / field->cell), 1);
	return true;
}

enum status soil_struck_capacity(const struct soil_part *parts, size_t count, double *capacity)
{
	struct field field = {0};
	enum status status = STATUS_OK;
	*capacity = 0;
	if (!bounds_of(parts, count, &field))
		return STATUS_OK;
	const size_t cells = (size_t)field.columns * (size_t)field.rows;
	TRY_OR(done, mem_make(&field.tops, cells, sizeof *field.tops, "the capacity of a body"));
	TRY_OR(done, mem_make(&field.rims, cells, sizeof *field.rims, "the capacity of a body"));
	TRY_OR(done, mem_make(&field.struck, cells, sizeof *field.struck, "the capacity of a body"));
	TRY_OR(done, mem_make(&field.hull, (size_t)CELLS + 1, sizeof *field.hull, "the capacity of a body"));
	for (size_t i = 0; i < cells; i++) {
		field.tops[i] = field.rims[i] = -INFINITY;
		field.struck[i] = INFINITY;
	}
	for (size_t i = 0; i < count; i++)
		each_triangle(&parts[i], &field, draw);
	*capacity = volume(&field);
done:
	mem_free_all(field.tops, field.rims, field.struck, field.hull);
	return status;
}
