/*
 * The height at a point, and what else the store has there.
 *
 * Heights are bilinear between posts of the finest level there. This is that of an inset, or the working level where something was
 * deformed or there is relief. All is read in one transaction.
 */
#include "store/internal.h"

#include <math.h>

#define BESIDE 1e-7 /* of a cell: a point no further from a post is on it */

/* Rounds a position within a cell to 0 or 1 if it is almost there. Otherwise a rounding error at a post would include the post
 * beside it, which may be a hole. */
static double snapped(double part)
{
	return fabs(part - round(part)) < BESIDE ? round(part) : part;
}

/* Returns the cell of `level` that contains (x, y), and the position within it. */
static struct post_rect cell_at(const struct extent *extent, int level, double x, double y, double *u,
				double *v)
{
	double px = x / extent_spacing(extent, level), py = y / extent_spacing(extent, level);
	int64_t width = extent_posts(extent->width, level), height = extent_posts(extent->height, level);
	int64_t cx = (int64_t)px, cy = (int64_t)py;
	cx = cx < width - 1 ? cx : width - 2;
	cy = cy < height - 1 ? cy : height - 2;
	*u = snapped(px - (double)cx);
	*v = snapped(py - (double)cy);
	return (struct post_rect){cx, cy, cx + 2, cy + 2};
}

/* Finds the finest level at which an inset has all posts with weight around (x, y); 0: none has. */
static enum status base_level_at(struct store_reader *reader, double x, double y, int *level)
{
	for (*level = store_finest_base(reader->store); *level < 0; ++*level) {
		double u, v, corners[4];
		struct post_rect cell = cell_at(reader->rows.extent, *level, x, y, &u, &v);
		TRY(store_read_stored(reader, *level, cell, corners));
		if (!isnan(lattice_bilinear(corners, u, v, 0)))
			break;
	}
	return STATUS_OK;
}

/* Finds the finest level stored at the cell that holds (x, y); cells are of level 0 or finer. Also finds the planes that the tile
 * of the working level has there. */
static enum status level_at(struct store_reader *reader, double x, double y, int *level, unsigned *planes)
{
	const struct extent *extent = reader->rows.extent;
	bool deformed;
	int working;
	*planes = 0;
	const struct relief *relief = store_relief(reader->store);
	TRY(base_level_at(reader, x, y, level));
	if (relief_any(relief) && relief->finest < *level)
		*level = relief->finest;
	if (store_rocks(reader->store) != NULL && store_rocks(reader->store)->finest < *level)
		*level = store_rocks(reader->store)->finest;
	TRY(store_meta_working(reader->db, reader->rows.path, extent, &deformed, &working));
	if (!deformed)
		return STATUS_OK;
	double side = extent_spacing(extent, working) * extent->cells;
	uint32_t tx = (uint32_t)(x / side), ty = (uint32_t)(y / side);
	uint32_t tiles_x = extent_tiles_x(extent, working), tiles_y = extent_tiles_y(extent, working);
	struct tile tile = {working, tx < tiles_x ? tx : tiles_x - 1, ty < tiles_y ? ty : tiles_y - 1};
	for (int plane = 0; plane < PLANES; plane++) {
		struct row row;
		bool found;
		TRY(store_rows_head(&reader->rows, row_table_of((enum plane)plane), tile, &row, &found));
		*planes |= found ? PLANE_BIT(plane) : 0;
	}
	if (*planes != 0 && working < *level)
		*level = working;
	return STATUS_OK;
}

/* Reads a layer at the nearest post; 0 in a hole. */
static enum status nearest(struct store_reader *reader, enum store_layer layer, int level, struct post_rect cell,
			   double u, double v, double *value)
{
	double posts[4];
	TRY(store_read_posts(reader, layer, level, cell, posts));
	*value = posts[(v >= 0.5) * 2 + (u >= 0.5)];
	if (isnan(*value))
		*value = 0;
	return STATUS_OK;
}

/* What lies loose on a post is its loose layer, and what was deposited since a body touched the post (src/soil/law/memory.h). */
static enum status read_loose(struct store_reader *reader, int level, struct post_rect cell, double u, double v, struct store_sample *sample)
{
	double settled = 0, loose = 0;
	if (sample->planes & PLANE_BIT(PLANE_DENSITY))
		TRY(nearest(reader, STORE_DENSITY, level, cell, u, v, &sample->density));
	if (!(sample->planes & (PLANE_BIT(PLANE_SETTLED) | PLANE_BIT(PLANE_LOOSE))))
		return STATUS_OK;
	TRY(nearest(reader, STORE_SETTLED, level, cell, u, v, &settled));
	TRY(nearest(reader, STORE_LOOSE, level, cell, u, v, &loose));
	sample->loose = loose > 0 || sample->deposited > settled ? fmax(loose + sample->deposited - settled, 0) : 0;
	return STATUS_OK;
}

static enum status sample_inside(struct store_reader *reader, double x, double y, struct store_sample *sample)
{
	int level;
	TRY(level_at(reader, x, y, &level, &sample->planes));
	double u, v, base[4], offset[4], disturbance = 0;
	struct post_rect cell = cell_at(reader->rows.extent, level, x, y, &u, &v);
	TRY(store_read_posts(reader, STORE_BASE, level, cell, base));
	TRY(store_read_posts(reader, STORE_OFFSET, level, cell, offset));
	TRY(nearest(reader, STORE_SOIL, level, cell, u, v, &disturbance));
	const struct {
		enum plane plane;
		enum store_layer layer;
		double *value;
	} state[] = {
		{PLANE_DEPOSITED, STORE_DEPOSITED, &sample->deposited},
		{PLANE_PLASTIC_SINKAGE, STORE_PLASTIC_SINKAGE, &sample->plastic_sinkage},
		{PLANE_SHEAR, STORE_SHEAR_EAST, &sample->shear[0]},
		{PLANE_SHEAR, STORE_SHEAR_NORTH, &sample->shear[1]},
		{PLANE_HEALED, STORE_HEALED, &sample->healed},
		{PLANE_RISEN, STORE_RISEN, &sample->risen},
		{PLANE_GROWN, STORE_GROWN, &sample->grown},
	};
	for (size_t i = 0; i < sizeof state / sizeof *state; i++)
		if (sample->planes & PLANE_BIT(state[i].plane))
			TRY(nearest(reader, state[i].layer, level, cell, u, v, state[i].value));
	TRY(read_loose(reader, level, cell, u, v, sample));
	sample->base = lattice_bilinear(base, u, v, 0);
	sample->nodata = isnan(sample->base);
	if (sample->nodata)
		return STATUS_OK;
	sample->offset = lattice_bilinear(offset, u, v, 0);
	sample->height = sample->base + sample->offset;
	sample->disturbance = (unsigned)disturbance;
	return STATUS_OK;
}

enum status store_sample(struct store_reader *reader, double x, double y, struct store_sample *sample)
{
	const struct extent *extent = &reader->store->meta.extent;
	*sample = (struct store_sample){
		.height = (double)NAN,
		.base = (double)NAN,
		.offset = (double)NAN,
		.nodata = true,
	};
	double east = (double)(extent->width - 1) * extent->spacing, north = (double)(extent->height - 1) * extent->spacing;
	double slack = BESIDE * extent->spacing;
	if (!(x >= -slack && y >= -slack && x <= east + slack && y <= north + slack)) {
		sample->outside = true;
		return STATUS_OK;
	}
	x = fmin(fmax(x, 0), east);
	y = fmin(fmax(y, 0), north);
	TRY(store_reader_begin(reader));
	TRY(store_sql_exec(reader->db, reader->rows.path, "reading it", "BEGIN"));
	enum status status = sample_inside(reader, x, y, sample);
	sqlite3_exec(reader->db, "ROLLBACK", NULL, NULL, NULL); /* only read */
	return store_reader_outdated(reader) ? store_sample(reader, x, y, sample) : status;
}
