/*
 * Tells where the posts of one lattice lie on another lattice, which may be in another SRS.
 *
 * In one SRS the way is linear. Between two, exact points are computed at the corners of square cells of posts, and points in
 * a cell are bilinear between its corners. The middle of each cell is computed exactly, too. Where it is off by too much, all
 * points of that cell are computed exactly. Cells lie at whole multiples of their side, so a point does not depend on the
 * rectangle that is asked for.
 */
#include "dem_gdal.h"

#include <assert.h>

#define CELL_MOST 64      /* posts along the side of a cell */
#define CELL_LEAST 8      /* with smaller cells every point is computed exactly */
#define OFF_CHOSEN 0.005  /* posts of the other lattice: the side of cells is chosen so that probes are off by less */
#define OFF_MOST 0.01     /* posts: a cell whose middle is off by more is computed exactly */
#define ROUNDING 1e-6     /* posts; and as a share of a turn */
#define PROBES 5          /* cells along each side of the lattice that are probed */

struct dem_map {
	struct dem_lattice from;
	double inverse[6];  /* from coordinates to posts of the other lattice */
	double straight[6]; /* from posts to posts, in one SRS */
	OGRCoordinateTransformationH move; /* NULL: one SRS */
	double turn, middle; /* a turn around the planet, and the middle of the other lattice, in its units; turn 0: x has none */
	int64_t width, rows; /* of the other lattice */
	int64_t side;        /* of a cell, posts; 1: every point is computed exactly */
};

bool dem_lattice_invert(const struct dem_lattice *lattice, double inverse[6])
{
	double place[6] = {lattice->at[0], lattice->at[1], lattice->at[2], lattice->at[3], lattice->at[4], lattice->at[5]};
	return GDALInvGeoTransform(place, inverse) != 0;
}

void dem_lattice_point(const struct dem_lattice *lattice, double column, double row, double *x, double *y)
{
	const double *at = lattice->at;
	*x = at[0] + column * at[1] + row * at[2];
	*y = at[3] + column * at[4] + row * at[5];
}

static void apply(const double affine[6], double *x, double *y)
{
	double a = *x, b = *y;
	*x = affine[0] + a * affine[1] + b * affine[2];
	*y = affine[3] + a * affine[4] + b * affine[5];
}

/* Finds a point on a lattice that may reach around the planet. A lattice has the edge of its first posts, and not that of its last. So x on the edge where both
 * ends meet, or a rounding beyond it, is looked for one turn away. A pole on the edge of a row has no other place, so it is put into that row. */
static void place_around(const struct dem_map *map, double *x, double *y)
{
	const double at[2] = {map->middle + remainder(*x - map->middle, map->turn), *y};
	*x = at[0];
	apply(map->inverse, x, y);
	for (int side = -1; side <= 1 && !(*x >= -0.5 && *x < (double)map->width - 0.5); side += 2) {
		double other[2] = {at[0] + side * map->turn, at[1]};
		apply(map->inverse, &other[0], &other[1]);
		if (other[0] >= -0.5 - ROUNDING && other[0] < (double)map->width - 0.5) {
			*x = fmax(other[0], -0.5);
			*y = other[1];
		}
	}
	const double last = (double)map->rows - 0.5;
	if (fabs(fabs(at[1]) - map->turn / 4) < ROUNDING * map->turn && *y > -0.5 - ROUNDING && *y < last + ROUNDING)
		*y = fmin(fmax(*y, -0.5), last - ROUNDING);
}

/* Replaces points of the SRS of `from` by columns and rows of the other lattice. NaN: nowhere on it. */
static void move_points(const struct dem_map *map, int count, double *x, double *y)
{
	(void)OCTTransform(map->move, count, x, y, NULL);
	for (int i = 0; i < count; i++) {
		if (!isfinite(x[i]) || !isfinite(y[i])) {
			x[i] = y[i] = (double)NAN;
			continue;
		}
		if (map->turn > 0)
			place_around(map, &x[i], &y[i]);
		else
			apply(map->inverse, &x[i], &y[i]);
	}
}

static double bilinear(double a, double b, double c, double d, double x, double y)
{
	double south = a + (b - a) * x, north = c + (d - c) * x;
	return south + (north - south) * y;
}

/* A row of cells: their corners and middles. */
struct cells {
	double x[3 * (DEM_BLOCK_SIDE / CELL_LEAST + 2)], y[3 * (DEM_BLOCK_SIDE / CELL_LEAST + 2)];
	int64_t first;
	int count;
};

static void cells_fill(const struct dem_map *map, int64_t side, int64_t first, int count, int64_t row, struct cells *cells)
{
	cells->first = first;
	cells->count = count;
	int n = 0;
	for (int line = 0; line < 2; line++)
		for (int i = 0; i <= count; i++, n++)
			dem_lattice_point(&map->from, (double)((first + i) * side), (double)((row + line) * side), &cells->x[n],
					  &cells->y[n]);
	for (int i = 0; i < count; i++, n++)
		dem_lattice_point(&map->from, ((double)(first + i) + 0.5) * (double)side, ((double)row + 0.5) * (double)side,
				  &cells->x[n], &cells->y[n]);
	move_points(map, n, cells->x, cells->y);
}

/* Returns by how much the bilinear middle of cell number i is off, posts. NaN: a corner or the middle is nowhere. */
static double cell_off(const struct cells *cells, int i)
{
	int south = i, north = cells->count + 1 + i, middle = 2 * (cells->count + 1) + i;
	const double *x = cells->x, *y = cells->y;
	return hypot(bilinear(x[south], x[south + 1], x[north], x[north + 1], 0.5, 0.5) - x[middle],
		     bilinear(y[south], y[south + 1], y[north], y[north + 1], 0.5, 0.5) - y[middle]);
}

static int64_t choose_side(const struct dem_map *map)
{
	struct cells cells;
	for (int64_t side = CELL_MOST; side >= CELL_LEAST; side /= 2) {
		double worst = 0;
		for (int i = 0; i < PROBES * PROBES; i++) {
			int64_t column = (map->from.width - 1) * (i % PROBES) / (PROBES - 1) / side;
			int64_t row = (map->from.height - 1) * (i / PROBES) / (PROBES - 1) / side;
			cells_fill(map, side, column, 1, row, &cells);
			worst = fmax(worst, cell_off(&cells, 0)); /* fmax ignores NaN */
		}
		if (worst <= OFF_CHOSEN)
			return side;
	}
	return 1;
}

enum status dem_map_create(const struct dem_lattice *from, const struct dem_lattice *to, const char *name, struct dem_map **out)
{
	struct dem_map *map = mem_calloc(1, sizeof *map);
	TRY_MEM(map, name);
	map->from = *from;
	map->width = to->width;
	map->rows = to->height;
	map->side = 1;
	enum status status = STATUS_OK;
	if (!dem_lattice_invert(to, map->inverse))
		TRY_OR(failed, fail_with(STATUS_INPUT, "%s: its geotransform is singular; give it a proper one with gdal_translate -a_ullr",
					 name));
	if (from->srs != NULL && to->srs != NULL && !OSRIsSame(from->srs, to->srs)) {
		CPLErrorReset();
		map->move = OCTNewCoordinateTransformation(from->srs, to->srs);
		if (map->move == NULL)
			TRY_OR(failed, fail_with(STATUS_INPUT, "%s: no way to project it%s; name another target with --t-srs", name,
						 dem_gdal_because()));
	}
	if (map->move != NULL) {
		double x, y;
		map->turn = dem_srs_turn(to->srs, &x);
		dem_lattice_point(to, (double)(to->width - 1) / 2, (double)(to->height - 1) / 2, &map->middle, &y);
		map->side = choose_side(map);
	}
	for (int i = 0; i < 3; i++) { /* the images of post (0, 0), and of a step along a row and along a column */
		double x = from->at[i], y = from->at[3 + i];
		apply(map->inverse, &x, &y);
		map->straight[i] = i == 0 ? x : x - map->inverse[0];
		map->straight[3 + i] = i == 0 ? y : y - map->inverse[3];
	}
	*out = map;
	return STATUS_OK;
failed:
	dem_map_destroy(map);
	return status;
}

void dem_map_destroy(struct dem_map *map)
{
	if (map == NULL)
		return;
	if (map->move != NULL)
		OCTDestroyCoordinateTransformation(map->move);
	mem_free(map);
}

bool dem_map_shift(const struct dem_map *map, double *column, double *row)
{
	/* Over the whole lattice the two may drift apart by a hundredth of a post. */
	const double *s = map->straight, most = 0.01;
	double wide = (double)map->from.width, high = (double)map->from.height;
	*column = rint(s[0]);
	*row = rint(s[3]);
	return map->move == NULL && fabs(s[0] - *column) < most && fabs(s[3] - *row) < most && fabs(s[1] - 1) * wide < most &&
	       fabs(s[5] - 1) * high < most && fabs(s[2]) * high < most && fabs(s[4]) * wide < most;
}

static void exact_row(const struct dem_map *map, int64_t x0, int64_t x1, int64_t y, double *columns, double *rows)
{
	for (int64_t x = x0; x < x1; x++)
		dem_lattice_point(&map->from, (double)x, (double)y, &columns[x - x0], &rows[x - x0]);
	move_points(map, (int)(x1 - x0), columns, rows);
}

static void straight_row(const struct dem_map *map, int64_t x0, int64_t x1, int64_t y, double *columns, double *rows)
{
	const double *s = map->straight;
	double column = s[0] + (double)y * s[2], row = s[3] + (double)y * s[5];
	for (int64_t x = x0; x < x1; x++) {
		columns[x - x0] = column + (double)x * s[1];
		rows[x - x0] = row + (double)x * s[4];
	}
}

static void cell_row(const struct dem_map *map, const struct cells *cells, int i, int64_t x0, int64_t x1, int64_t y,
		     double *columns, double *rows)
{
	int south = i, north = cells->count + 1 + i;
	const double *x = cells->x, *z = cells->y;
	double side = (double)map->side, v = (double)(y % map->side) / side;
	double left = x[south] + (x[north] - x[south]) * v, right = x[south + 1] + (x[north + 1] - x[south + 1]) * v;
	double low = z[south] + (z[north] - z[south]) * v, high = z[south + 1] + (z[north + 1] - z[south + 1]) * v;
	int64_t start = (cells->first + i) * map->side;
	for (int64_t at = x0; at < x1; at++) {
		double u = (double)(at - start) / side;
		columns[at - x0] = left + (right - left) * u;
		rows[at - x0] = low + (high - low) * u;
	}
}

void dem_map_rect(const struct dem_map *map, struct post_rect rect, double *columns, double *rows)
{
	int64_t width = rect.x1 - rect.x0, side = map->side;
	assert(width <= DEM_BLOCK_SIDE && rect.x0 >= 0 && rect.y0 >= 0);
	struct cells cells = {.count = 0};
	for (int64_t y = rect.y0; y < rect.y1; y++, columns += width, rows += width) {
		if (map->move == NULL) {
			straight_row(map, rect.x0, rect.x1, y, columns, rows);
			continue;
		}
		if (side == 1) {
			exact_row(map, rect.x0, rect.x1, y, columns, rows);
			continue;
		}
		if (y == rect.y0 || y % side == 0)
			cells_fill(map, side, rect.x0 / side, (int)((rect.x1 - 1) / side - rect.x0 / side) + 1, y / side, &cells);
		for (int i = 0; i < cells.count; i++) {
			int64_t start = (cells.first + i) * side, x0 = start > rect.x0 ? start : rect.x0;
			int64_t x1 = start + side < rect.x1 ? start + side : rect.x1, at = x0 - rect.x0;
			if (cell_off(&cells, i) <= OFF_MOST)
				cell_row(map, &cells, i, x0, x1, y, columns + at, rows + at);
			else
				exact_row(map, x0, x1, y, columns + at, rows + at);
		}
	}
}
