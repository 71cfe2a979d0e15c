/*
 * Reads the posts of any rectangle at any level.
 *
 * Passes over the rectangle read it. The first ones read the base, which tells where there is no
 * data; the last reads the deformation. Each pass reads tiles of one stored level, which is the
 * requested level or coarser. It interpolates between posts as the shaders do. Below level 0 there
 * is a pass over the base for each level with insets, from the finest, and one for level 0. Each of
 * them fills the posts that have no height yet, and raises them by relief. Rocks are added last, at
 * every level. All passes are in one transaction, so all posts are of one commit.
 */
#include "store/internal.h"

#include <assert.h>
#include <math.h>

#define SHIFT_MAX 14 /* lattice_interpolate */

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

static double base_code_if_none(const struct reading *reading, double was, int32_t post)
{
	return isnan(was) ? base_code(reading, was, post) : was;
}

static double base_lattice_if_none(const struct reading *reading, double was, int32_t post)
{
	return isnan(was) && post != BASE_NODATA ? reading->reference + lattice_base_metres(post) : was;
}

static double add_metres(const struct reading *reading, double was, int32_t post)
{
	return was + lattice_offset_metres(post);
}

static double add_as_is(const struct reading *reading, double was, int32_t post)
{
	return was + post;
}

static double add_time(const struct reading *reading, double was, int32_t post)
{
	return was + ldexp(post, -PLANE_TIME_BITS);
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
	[STORE_HEALED] = {ROW_HEALED, add_time},   [STORE_RISEN] = {ROW_RISEN, add_time},   [STORE_GROWN] = {ROW_GROWN, add_time},
	[STORE_DEPOSITED] = {ROW_DEPOSITED, add_metres},  [STORE_PLASTIC_SINKAGE] = {ROW_PLASTIC_SINKAGE, add_metres},
	[STORE_SHEAR] = {ROW_SHEAR, add_shear}, [STORE_SHEAR_EAST] = {ROW_SHEAR, add_shear}, [STORE_SHEAR_NORTH] = {ROW_SHEAR, add_shear},
	[STORE_SETTLED] = {ROW_SETTLED, add_metres}, [STORE_LOOSE] = {ROW_LOOSE, add_metres}, [STORE_DENSITY] = {ROW_DENSITY, add_metres},
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

/* `relief` NULL: none. */
static enum status take_tile(const struct reading *reading, struct tile tile, int shift,
			     struct post_rect part, const struct relief *relief, meaning_fn meaning)
{
	uint64_t west = (uint64_t)tile.x * reading->reader->rows.extent->cells << shift;
	uint64_t south = (uint64_t)tile.y * reading->reader->rows.extent->cells << shift;
	uint32_t side = tile_posts(reading->reader->rows.extent);
	int64_t width = reading->rect.x1 - reading->rect.x0;
	int32_t *raised = NULL;
	enum status status = STATUS_OK;
	if (relief != NULL &&
	    (raised = mem_alloc((size_t)(part.x1 - part.x0), sizeof *raised)) == NULL)
		return fail_memory("relief");
	for (int64_t y = part.y0; y < part.y1; y++) {
		double *row = reading->values + (y - reading->rect.y0) * width - reading->rect.x0;
		if (relief != NULL)
			TRY_OR(done, relief_heights(relief, reading->level, tile.level, (struct post_rect){part.x0, y, part.x1, y + 1}, raised));
		for (int64_t x = part.x0; x < part.x1; x++) {
			int32_t post = lattice_finer(reading->posts, side, shift,
						     (uint64_t)x - west, (uint64_t)y - south);
			if (relief != NULL && post != BASE_NODATA)
				post += raised[x - part.x0];
			row[x] = meaning(reading, row[x], post);
		}
	}
done:
	mem_free(raised);
	return status;
}

/* Reads one tile into reading->posts. */
static enum status load_tile(struct reading *reading, enum row_table table, struct tile tile, bool *found)
{
	struct rows *rows = &reading->reader->rows;
	const size_t side = tile_posts(rows->extent);
	struct row row;
	if (table != ROW_BASE) {
		TRY(store_rows_read(rows, table, tile, reading->posts, &row, found));
		for (size_t i = 0; i < side * side && table == ROW_SHEAR && *found; i++)
			reading->posts[i] = plane_shear(reading->posts[i], store_shear_part(reading->layer));
		return STATUS_OK;
	}
	TRY(store_find_base(reading->reader, tile, reading->posts, NULL, found));
	if (!*found || reading->level == tile.level)
		return STATUS_OK;
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
	const struct relief *relief =
		table == ROW_BASE && shift > 0 ? store_relief(reading->reader->store) : NULL;
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
			TRY(load_tile(reading, table, tile, &found));
			if (found)
				TRY(take_tile(reading, tile, shift, part, relief, meaning));
		}
	return STATUS_OK;
}

static bool is_full(const struct reading *reading, struct post_rect rect)
{
	const int64_t width = reading->rect.x1 - reading->rect.x0;
	for (int64_t y = rect.y0; y < rect.y1; y++)
		for (int64_t x = rect.x0; x < rect.x1; x++)
			if (isnan(reading->values[(y - reading->rect.y0) * width + x - reading->rect.x0]))
				return false;
	return true;
}

static enum status take_base(struct reading *reading, struct post_rect rect)
{
	const int level = reading->level, finest = store_finest_base(reading->reader->store);
	if (level >= 0)
		return take_level(reading, ROW_BASE, level, rect, base_code);
	for (int from = level > finest ? level : finest; from <= 0; from++) {
		TRY(take_level(reading, ROW_BASE, from, rect, from == level ? base_code_if_none : base_lattice_if_none));
		if (is_full(reading, rect))
			break;
	}
	return STATUS_OK;
}

enum { STRIP = 1 << 16 }; /* posts that get their rocks at once */

/* Adds the rocks to base heights, strip by strip. */
static enum status add_rocks(const struct reading *reading, struct post_rect rect)
{
	const struct rocks *rocks = store_rocks(reading->reader->store);
	const int64_t width = rect.x1 - rect.x0, stride = reading->rect.x1 - reading->rect.x0, rows = width < STRIP ? STRIP / width : 1;
	int32_t *heights = NULL;
	if (rocks == NULL)
		return STATUS_OK;
	TRY(mem_make(&heights, (size_t)(rows * width), sizeof *heights, "rocks"));
	for (int64_t y = rect.y0; y < rect.y1; y += rows) {
		const struct post_rect strip = {rect.x0, y, rect.x1, y + rows < rect.y1 ? y + rows : rect.y1};
		rocks_heights(rocks, reading->level, strip, heights);
		for (int64_t k = 0; k < width * (strip.y1 - y); k++)
			reading->values[(y + k / width - reading->rect.y0) * stride + rect.x0 + k % width - reading->rect.x0] += lattice_base_metres(heights[k]);
	}
	mem_free(heights);
	return STATUS_OK;
}

/* `rect` is the part of the rectangle within the terrain. */
static enum status read_layer(struct reading *reading, struct post_rect rect)
{
	struct store_reader *reader = reading->reader;
	const struct extent *extent = reader->rows.extent;
	const enum store_layer layer = reading->layer;
	int level = reading->level, working = 0;
	bool deformed;
	TRY(store_meta_working(reader->db, reader->rows.path, extent, &deformed, &working));
	TRY(take_base(reading, rect));
	TRY(add_rocks(reading, rect));
	if (layer == STORE_BASE)
		return STATUS_OK;
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

static enum status read_stored(struct reading *reading, struct post_rect rect)
{
	return take_level(reading, ROW_BASE, reading->level, rect, base_code);
}

typedef enum status (*read_fn)(struct reading *reading, struct post_rect rect);

static enum status begin_and_read(struct reading *reading, read_fn read, struct post_rect within)
{
	struct store_reader *reader = reading->reader;
	TRY(store_reader_begin(reader));
	if (sqlite3_get_autocommit(reader->db) == 0) /* store_sample() began a transaction already */
		return read(reading, within);
	TRY(store_sql_exec(reader->db, reader->rows.path, "reading it", "BEGIN"));
	enum status status = read(reading, within);
	sqlite3_exec(reader->db, "ROLLBACK", NULL, NULL, NULL); /* only read */
	return status;
}

static enum status read_in_transaction(struct reading *reading, read_fn read)
{
	const struct extent *extent = &reading->reader->store->meta.extent;
	const struct post_rect *rect = &reading->rect;
	const struct post_rect all = {0, 0, extent_posts(extent->width, reading->level), extent_posts(extent->height, reading->level)};
	const struct post_rect within = post_rect_intersect(*rect, all);
	const size_t count = (size_t)(rect->x1 - rect->x0) * (size_t)(rect->y1 - rect->y0), side = tile_posts(extent);
	for (size_t i = 0; i < count; i++)
		reading->values[i] = (double)NAN;
	if (post_rect_empty(within))
		return STATUS_OK;
	TRY(mem_make(&reading->posts, side * side, sizeof *reading->posts, "a tile"));
	enum status status = begin_and_read(reading, read, within);
	mem_free(reading->posts);
	return store_reader_outdated(reading->reader) ? read_in_transaction(reading, read) : status;
}

enum status store_read_posts(struct store_reader *reader, enum store_layer layer, int level,
			     struct post_rect rect, double *values)
{
	const struct store_meta *meta = &reader->store->meta;
	const struct extent *extent = &meta->extent;
	if (level < TILE_LEVEL_MIN || level > extent_coarsest(extent))
		return fail_with(STATUS_INPUT, "%s: there is no level %d; give one from %d to %d", reader->store->path,
				 level, TILE_LEVEL_MIN, extent_coarsest(extent));
	if (post_rect_empty(rect))
		return STATUS_OK;
	if (level < 0 && !isnan(meta->low) && !lattice_fits(meta->low, meta->high))
		return fail_with(STATUS_INPUT, "%s: heights from %g to %g m are more relief than can be divided below level "
				 "0; ask for level 0, or import with another --height-range", reader->store->path,
				 meta->low, meta->high);
	struct reading reading = {
		.reader = reader,
		.layer = layer,
		.level = level,
		.rect = rect,
		.values = values,
		.reference = isnan(meta->low) ? 0 : lattice_reference(meta->low, meta->high),
	};
	return read_in_transaction(&reading, read_layer);
}

enum status store_read_stored(struct store_reader *reader, int level, struct post_rect rect, double *values)
{
	struct reading reading = {.reader = reader, .layer = STORE_BASE, .level = level, .rect = rect, .values = values};
	return read_in_transaction(&reading, read_stored);
}
