/*
 * Reads the posts of any rectangle at any level, and the height at a point.
 *
 * Two passes over the rectangle read it. The first reads the base, which tells where there is no data; the second reads the
 * deformation. Each pass reads tiles of one stored level, which is the requested level or coarser. It interpolates between posts
 * as the shaders do. Both passes are in one transaction, so all posts are of one commit.
 */
#include "store/internal.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#define SHIFT_MAX 14 /* lattice_interpolate */
#define BESIDE 1e-7  /* of a cell: a point no further from a post is on it */

struct reading {
	struct store_reader *reader;
	enum store_layer layer;
	int level;
	struct post_rect rect; /* asked for: the shape of `values` */
	double *values;
	int32_t *posts; /* one tile */
	int32_t reference;
};

typedef double (*meaning_fn)(const struct reading *reading, double was, int32_t post);

static double base_code(const struct reading *reading, double was, int32_t post)
{
	return height_code_metres(post, reading->reader->store->meta.step);
}

static double base_lattice(const struct reading *reading, double was, int32_t post)
{
	return post == BASE_NODATA ? (double)NAN : reading->reference + lattice_base_metres(post);
}

static double add_metres(const struct reading *reading, double was, int32_t post)
{
	return was + lattice_offset_metres(post);
}

static double add_as_is(const struct reading *reading, double was, int32_t post)
{
	return was + post;
}

static double add_shear(const struct reading *reading, double was, int32_t post)
{
	return was + ldexp(post, -PLANE_SHEAR_BITS);
}

enum plane_shear_part store_shear_part(enum store_layer layer)
{
	return layer == STORE_SHEAR_EAST ? PLANE_SHEAR_EAST : layer == STORE_SHEAR_NORTH ? PLANE_SHEAR_NORTH : PLANE_SHEAR_AMOUNT;
}

/* The tables of each layer: the plane that is added to the base, or read alone. */
static const struct {
	enum row_table table;
	meaning_fn meaning;
} added[STORE_LAYERS] = {
	[STORE_SURFACE] = {ROW_OFFSET, add_metres}, [STORE_OFFSET] = {ROW_OFFSET, add_metres},
	[STORE_UNITS] = {ROW_OFFSET, add_as_is},   [STORE_SOIL] = {ROW_DISTURBANCE, add_as_is},
	[STORE_DEPOSITED] = {ROW_DEPOSITED, add_metres},  [STORE_PLASTIC_SINKAGE] = {ROW_PLASTIC_SINKAGE, add_metres},
	[STORE_SHEAR] = {ROW_SHEAR, add_shear}, [STORE_SHEAR_EAST] = {ROW_SHEAR, add_shear}, [STORE_SHEAR_NORTH] = {ROW_SHEAR, add_shear},
};

/* Returns the part of `rect` that this tile provides. The tile is `shift` levels coarser than the posts of `rect`. Neighbouring
 * tiles share a row or column of posts; the tile to the north or east provides it, if there is one. */
static struct post_rect part_of(const struct reading *reading, struct tile tile, int shift,
				struct post_rect rect)
{
	const struct extent *extent = reading->reader->rows.extent;
	struct post_rect own = tile_post_rect(extent, tile);
	bool last_x = tile.x + 1 == extent_tiles_x(extent, tile.level);
	bool last_y = tile.y + 1 == extent_tiles_y(extent, tile.level);
	own = (struct post_rect){own.x0 << shift, own.y0 << shift, ((own.x1 - 1) << shift) + last_x,
				 ((own.y1 - 1) << shift) + last_y};
	return post_rect_intersect(own, rect);
}

static void take_tile(const struct reading *reading, struct tile tile, int shift, struct post_rect part,
		      meaning_fn meaning)
{
	uint64_t west = (uint64_t)tile.x * reading->reader->rows.extent->cells << shift;
	uint64_t south = (uint64_t)tile.y * reading->reader->rows.extent->cells << shift;
	uint32_t side = tile_posts(reading->reader->rows.extent);
	int64_t width = reading->rect.x1 - reading->rect.x0;
	for (int64_t y = part.y0; y < part.y1; y++) {
		double *row = reading->values + (y - reading->rect.y0) * width - reading->rect.x0;
		for (int64_t x = part.x0; x < part.x1; x++)
			row[x] = meaning(reading, row[x], lattice_finer(reading->posts, side, shift, (uint64_t)x - west,
									(uint64_t)y - south));
	}
}

/* Reads one tile into reading->posts. */
static enum status load_tile(struct reading *reading, enum row_table table, struct tile tile, bool *found)
{
	struct rows *rows = &reading->reader->rows;
	const size_t side = tile_posts(rows->extent);
	struct row row;
	if (table != ROW_BASE) {
		enum status read = store_rows_read(rows, table, tile, reading->posts, &row, found);
		for (size_t i = 0; i < side * side && table == ROW_SHEAR && *found; i++)
			reading->posts[i] = plane_shear(reading->posts[i], store_shear_part(reading->layer));
		return read;
	}
	*found = true;
	enum status status = store_read_base(reading->reader, tile, reading->posts, NULL);
	if (status != STATUS_OK || reading->level >= 0)
		return status;
	const struct store_meta *meta = &reading->reader->store->meta;
	for (size_t i = 0; i < side * side; i++)
		reading->posts[i] = lattice_base_relative(height_code_metres(reading->posts[i], meta->step),
							  reading->reference);
	return STATUS_OK;
}

/* Reads all tiles of level `source` that overlap the rectangle. The rectangle already lies inside the terrain. */
static enum status take_level(struct reading *reading, enum row_table table, int source,
			      struct post_rect rect, meaning_fn meaning)
{
	int shift = source - reading->level;
	assert(shift >= 0);
	if (shift > SHIFT_MAX)
		return fail_with(STATUS_INPUT, "%s: level %d is more than %d levels finer than what is stored; ask "
				 "for a coarser one", reading->reader->rows.path, reading->level, SHIFT_MAX);
	const struct extent *extent = reading->reader->rows.extent;
	/* The last post of the terrain may belong to the last tile. Then no tile begins there. */
	int64_t span = (int64_t)extent->cells << shift;
	uint32_t tiles_x = extent_tiles_x(extent, source), tiles_y = extent_tiles_y(extent, source);
	uint32_t first_x = (uint32_t)(rect.x0 / span), first_y = (uint32_t)(rect.y0 / span);
	first_x = first_x < tiles_x ? first_x : tiles_x - 1;
	first_y = first_y < tiles_y ? first_y : tiles_y - 1;
	for (uint32_t ty = first_y; ty < tiles_y && ty * span < rect.y1; ty++)
		for (uint32_t tx = first_x; tx < tiles_x && tx * span < rect.x1; tx++) {
			struct tile tile = {source, tx, ty};
			struct post_rect part = part_of(reading, tile, shift, rect);
			bool found;
			if (post_rect_empty(part))
				continue;
			enum status status = load_tile(reading, table, tile, &found);
			if (status != STATUS_OK)
				return status;
			if (found)
				take_tile(reading, tile, shift, part, meaning);
		}
	return STATUS_OK;
}

static enum status read_layer(struct reading *reading, enum store_layer layer)
{
	struct store_reader *reader = reading->reader;
	const struct extent *extent = reader->rows.extent;
	int level = reading->level, working = 0;
	struct post_rect all = {0, 0, extent_posts(extent->width, level), extent_posts(extent->height, level)};
	struct post_rect rect = post_rect_intersect(reading->rect, all);
	if (post_rect_empty(rect))
		return STATUS_OK;
	bool deformed;
	enum status status = store_meta_working(reader->db, reader->rows.path, extent, &deformed, &working);
	if (status == STATUS_OK)
		status = take_level(reading, ROW_BASE, level > 0 ? level : 0, rect,
				    level >= 0 ? base_code : base_lattice);
	if (status != STATUS_OK || layer == STORE_BASE)
		return status;
	size_t count = (size_t)(reading->rect.x1 - reading->rect.x0) *
		       (size_t)(reading->rect.y1 - reading->rect.y0);
	for (size_t i = 0; i < count && layer != STORE_SURFACE; i++)
		reading->values[i] = isnan(reading->values[i]) ? (double)NAN : 0;
	if (!deformed)
		return STATUS_OK;
	if (row_is_state(added[layer].table) && level > working)
		return fail_with(STATUS_INPUT, "%s: level %d has no state of the soil; ask for level %d, which is deformed, or a "
				 "finer one", reader->rows.path, level, working);
	return take_level(reading, added[layer].table, level > working ? level : working, rect, added[layer].meaning);
}

enum status store_read_posts(struct store_reader *reader, enum store_layer layer, int level,
			     struct post_rect rect, double *values)
{
	const struct extent *extent = reader->rows.extent;
	const struct store_meta *meta = &reader->store->meta;
	if (level < TILE_LEVEL_MIN || level > extent_coarsest(extent))
		return fail_with(STATUS_INPUT, "%s: there is no level %d; give one from %d to %d", reader->rows.path,
				 level, TILE_LEVEL_MIN, extent_coarsest(extent));
	if (post_rect_empty(rect))
		return STATUS_OK;
	if (level < 0 && !isnan(meta->low) && !lattice_fits(meta->low, meta->high))
		return fail_with(STATUS_INPUT, "%s: heights from %g to %g m are more relief than can be divided below level "
				 "0; ask for level 0, or import with another --height-range", reader->rows.path,
				 meta->low, meta->high);
	size_t count = (size_t)(rect.x1 - rect.x0) * (size_t)(rect.y1 - rect.y0);
	for (size_t i = 0; i < count; i++)
		values[i] = (double)NAN;
	struct reading reading = {
		.reader = reader,
		.layer = layer,
		.level = level,
		.rect = rect,
		.values = values,
		.reference = isnan(meta->low) ? 0 : lattice_reference(meta->low, meta->high),
	};
	size_t side = tile_posts(extent);
	reading.posts = mem_alloc(side * side, sizeof *reading.posts);
	if (reading.posts == NULL)
		return fail_memory("a tile");
	bool outermost = sqlite3_get_autocommit(reader->db) != 0; /* store_sample() began one already */
	enum status status = STATUS_OK;
	if (outermost)
		status = store_sql_exec(reader->db, reader->rows.path, "reading it", "BEGIN");
	if (status == STATUS_OK) {
		status = read_layer(&reading, layer);
		if (outermost)
			sqlite3_exec(reader->db, "ROLLBACK", NULL, NULL, NULL); /* only read */
	}
	mem_free(reading.posts);
	return status;
}

/* --- a point --- */

/* Finds the finest level stored at the cell that holds (x, y); cells are of level 0 or finer. Also finds the planes that the tile
 * of the working level has there. */
static enum status level_at(struct store_reader *reader, double x, double y, int *level, unsigned *planes)
{
	const struct extent *extent = reader->rows.extent;
	bool deformed;
	int working;
	*level = 0;
	*planes = 0;
	enum status status = store_meta_working(reader->db, reader->rows.path, extent, &deformed, &working);
	if (status != STATUS_OK || !deformed)
		return status;
	double side = extent_spacing(extent, working) * extent->cells;
	uint32_t tx = (uint32_t)(x / side), ty = (uint32_t)(y / side);
	uint32_t tiles_x = extent_tiles_x(extent, working), tiles_y = extent_tiles_y(extent, working);
	struct tile tile = {working, tx < tiles_x ? tx : tiles_x - 1, ty < tiles_y ? ty : tiles_y - 1};
	for (int plane = 0; plane < PLANES && status == STATUS_OK; plane++) {
		struct row row;
		bool found;
		status = store_rows_head(&reader->rows, row_table_of((enum plane)plane), tile, &row, &found);
		*planes |= found ? PLANE_BIT(plane) : 0;
	}
	if (*planes != 0 && working < 0)
		*level = working;
	return status;
}

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

/* Reads a layer at the nearest post; 0 in a hole. */
static enum status nearest(struct store_reader *reader, enum store_layer layer, int level, struct post_rect cell,
			   double u, double v, double *value)
{
	double posts[4];
	enum status status = store_read_posts(reader, layer, level, cell, posts);
	if (status == STATUS_OK)
		*value = posts[(v >= 0.5) * 2 + (u >= 0.5)];
	if (status == STATUS_OK && isnan(*value))
		*value = 0;
	return status;
}

static enum status sample_inside(struct store_reader *reader, double x, double y, struct store_sample *sample)
{
	int level;
	enum status status = level_at(reader, x, y, &level, &sample->planes);
	if (status != STATUS_OK)
		return status;
	double u, v, base[4], offset[4], disturbance = 0;
	struct post_rect cell = cell_at(reader->rows.extent, level, x, y, &u, &v);
	status = store_read_posts(reader, STORE_BASE, level, cell, base);
	if (status == STATUS_OK)
		status = store_read_posts(reader, STORE_OFFSET, level, cell, offset);
	if (status == STATUS_OK)
		status = nearest(reader, STORE_SOIL, level, cell, u, v, &disturbance);
	const struct {
		enum plane plane;
		enum store_layer layer;
		double *value;
	} state[] = {
		{PLANE_DEPOSITED, STORE_DEPOSITED, &sample->deposited},
		{PLANE_PLASTIC_SINKAGE, STORE_PLASTIC_SINKAGE, &sample->plastic_sinkage},
		{PLANE_SHEAR, STORE_SHEAR_EAST, &sample->shear[0]},
		{PLANE_SHEAR, STORE_SHEAR_NORTH, &sample->shear[1]},
	};
	for (size_t i = 0; i < sizeof state / sizeof *state && status == STATUS_OK; i++)
		if (sample->planes & PLANE_BIT(state[i].plane))
			status = nearest(reader, state[i].layer, level, cell, u, v, state[i].value);
	if (status != STATUS_OK)
		return status;
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
	const struct extent *extent = reader->rows.extent;
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
	enum status status = store_sql_exec(reader->db, reader->rows.path, "reading it", "BEGIN");
	if (status != STATUS_OK)
		return status;
	status = sample_inside(reader, x, y, sample);
	sqlite3_exec(reader->db, "ROLLBACK", NULL, NULL, NULL); /* only read */
	return status;
}
