/*
 * Plans the zoom levels: which there are, the store's level that each one shows, and its tiles.
 *
 *  1. The finest dense zoom level of a map is the first whose pixels are no larger than level 0's spacing. That of a globe is the one
 *     whose samples are nearest to it, since a mesh tile takes 20 bytes a sample; with `fine_globe` it is the first as fine as level 0.
 *  2. Finer ones are sparse: those down to the spacing of the working level have tiles where something drove, those down to the
 *     spacing of an inset have tiles where it lies.
 *     Imagery that is finer than both has dense zoom levels of its own, without heights.
 *  3. The coarsest map shows the terrain within a tile or so. A globe begins at zoom 0, whose two tiles clients ask for always.
 */
#include "exchange/internal.h"

#include <stdlib.h>

#define BLOCK 4 /* a unit of a dense zoom level is a square of so many tiles */

/* Rectangles of the store: west, south, east, north. */
struct rect {
	double metres[4], degrees[4];
};

struct rects {
	const struct exchange_frame *frame;
	struct rect *rects;
	size_t count, room;
};

/* The bounds in degrees, of eight points of the rectangle's edges. */
static void find_degrees(const struct exchange_frame *frame, struct rect *rect)
{
	const double *m = rect->metres;
	double x[] = {m[0], (m[0] + m[2]) / 2, m[2], m[0], m[2], m[0], (m[0] + m[2]) / 2, m[2]};
	double y[] = {m[1], m[1], m[1], (m[1] + m[3]) / 2, (m[1] + m[3]) / 2, m[3], m[3], m[3]};
	exchange_frame_to_degrees(frame, 8, x, y);
	rect->degrees[0] = rect->degrees[1] = INFINITY;
	rect->degrees[2] = rect->degrees[3] = -INFINITY;
	for (int i = 0; i < 8; i++) {
		rect->degrees[0] = fmin(rect->degrees[0], x[i]);
		rect->degrees[1] = fmin(rect->degrees[1], y[i]);
		rect->degrees[2] = fmax(rect->degrees[2], x[i]);
		rect->degrees[3] = fmax(rect->degrees[3], y[i]);
	}
}

static enum status add_tile(void *user, uint64_t key)
{
	struct rects *list = user;
	const struct extent *extent = &list->frame->meta->extent;
	TRY(mem_grow(&list->rects, &list->room, list->count + 1, sizeof *list->rects, "the tiles of a level"));
	struct tile tile = tile_from_key(key);
	double side = extent_spacing(extent, tile.level) * extent->cells;
	struct rect *rect = &list->rects[list->count++];
	*rect = (struct rect){.metres = {tile.x * side, tile.y * side, (tile.x + 1) * side, (tile.y + 1) * side}};
	find_degrees(list->frame, rect);
	return STATUS_OK;
}

static double clamp(double value, double low, double high)
{
	return fmin(fmax(value, low), high);
}

/* The tiles of a zoom level that touch a rectangle in degrees, or for a local map in metres. */
static void tiles_of(const struct exchange_frame *frame, const struct exchange_zoom *zoom, const double box[4], int64_t range[4])
{
	double around = ldexp(1, zoom->z), west, east, first, last, rows = around;
	if (zoom->globe) {
		rows = around;
		west = (box[0] + 180) / 180 * around;
		east = (box[2] + 180) / 180 * around;
		first = (box[1] + 90) / 180 * around;
		last = (box[3] + 90) / 180 * around;
	} else if (frame->globe != NULL) {
		west = (box[0] + 180) / 360 * around;
		east = (box[2] + 180) / 360 * around;
		double south = clamp(box[1], -85.06, 85.06) * M_PI / 180, north = clamp(box[3], -85.06, 85.06) * M_PI / 180;
		first = (1 - asinh(tan(north)) / M_PI) / 2 * around;
		last = (1 - asinh(tan(south)) / M_PI) / 2 * around;
	} else {
		west = box[0] / frame->side * around;
		east = box[2] / frame->side * around;
		first = (1 - box[3] / frame->side) * around;
		last = (1 - box[1] / frame->side) * around;
	}
	double columns = zoom->globe ? 2 * around : around;
	range[0] = (int64_t)clamp(floor(west), 0, columns - 1);
	range[2] = (int64_t)clamp(ceil(east), (double)range[0] + 1, columns);
	range[1] = (int64_t)clamp(floor(first), 0, rows - 1);
	range[3] = (int64_t)clamp(ceil(last), (double)range[1] + 1, rows);
}

/* A rectangle with `more` metres around it, in the units of tiles_of. */
static void box_of(const struct exchange_frame *frame, const struct exchange_zoom *zoom, const struct rect *rect, double more, double box[4])
{
	bool local = !zoom->globe && frame->globe == NULL;
	const double *from = local ? rect->metres : rect->degrees;
	double east = 1, north = 1;
	if (!local)
		exchange_frame_degree(frame, (from[1] + from[3]) / 2, &east, &north);
	box[0] = from[0] - more / east;
	box[1] = from[1] - more / north;
	box[2] = from[2] + more / east;
	box[3] = from[3] + more / north;
}

/* Adds the tiles that touch the rectangles. `ring`: and so many tiles around them. */
static enum status add_tiles(const struct exchange_frame *frame, const struct exchange_zoom *zoom, const struct rects *list, double more,
			     int64_t ring, struct key_set *out)
{
	for (size_t i = 0; i < list->count; i++) {
		double box[4];
		int64_t range[4];
		box_of(frame, zoom, &list->rects[i], more, box);
		tiles_of(frame, zoom, box, range);
		for (int64_t y = range[1] - ring; y < range[3] + ring; y++)
			for (int64_t x = range[0] - ring; x < range[2] + ring; x++) {
				bool here = x >= zoom->x0 && y >= zoom->y0 && x < zoom->x1 && y < zoom->y1;
				if (here && (out == &zoom->tiles || exchange_zoom_has(zoom, x, y)))
					TRY(key_set_add(out, exchange_zoom_key(zoom, x, y)));
			}
	}
	return STATUS_OK;
}

bool exchange_zoom_has(const struct exchange_zoom *zoom, int64_t x, int64_t y)
{
	if (x < zoom->x0 || y < zoom->y0 || x >= zoom->x1 || y >= zoom->y1)
		return false;
	return !zoom->sparse || key_set_has(&zoom->tiles, exchange_zoom_key(zoom, x, y));
}

static int compare_keys(const void *a, const void *b)
{
	uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
	return (x > y) - (x < y);
}

/* In the order of keys, neighbours come after each other. */
static enum status sort_keys(const struct key_set *set, struct exchange_zoom *zoom)
{
	TRY(mem_make(&zoom->order, set->count + 1, sizeof *zoom->order, "the tiles of a zoom level"));
	for (size_t i = 0; i < set->room; i++)
		if (set->keys[i] != UINT64_MAX)
			zoom->order[zoom->count++] = set->keys[i];
	qsort(zoom->order, zoom->count, sizeof *zoom->order, compare_keys);
	zoom->units = (int64_t)((zoom->count + EXCHANGE_UNIT - 1) / EXCHANGE_UNIT);
	return STATUS_OK;
}

static int64_t blocks(int64_t first, int64_t end)
{
	return (end - 1) / BLOCK - first / BLOCK + 1;
}

size_t exchange_zoom_unit(const struct exchange_zoom *zoom, int64_t unit, struct tile tiles[EXCHANGE_UNIT])
{
	size_t count = 0;
	if (zoom->order != NULL) {
		for (size_t i = (size_t)unit * EXCHANGE_UNIT; i < zoom->count && count < EXCHANGE_UNIT; i++)
			tiles[count++] = tile_from_key(zoom->order[i]);
		return count;
	}
	int64_t across = blocks(zoom->x0, zoom->x1);
	int64_t x0 = (zoom->x0 / BLOCK + unit % across) * BLOCK, y0 = (zoom->y0 / BLOCK + unit / across) * BLOCK;
	for (int64_t y = y0; y < y0 + BLOCK; y++)
		for (int64_t x = x0; x < x0 + BLOCK; x++)
			if (exchange_zoom_has(zoom, x, y))
				tiles[count++] = (struct tile){zoom->z, (uint32_t)x, (uint32_t)y};
	return count;
}

/* --- planning --- */

/* Metres between two samples at the middle of the terrain. */
static double step_of(const struct exchange_frame *frame, struct exchange_zoom *zoom)
{
	double around = ldexp(zoom->globe ? 2 * EXCHANGE_CELLS : frame->pixels, zoom->z), latitude = (frame->bounds[1] + frame->bounds[3]) / 2;
	double east, north;
	if (!zoom->globe && frame->globe == NULL)
		return frame->side / around;
	exchange_frame_degree(frame, latitude, &east, &north);
	if (zoom->globe)
		return north * 360 / around;
	return east * 360 / around;
}

static int first_within(const struct exchange_frame *frame, bool globe, double spacing)
{
	struct exchange_zoom zoom = {.globe = globe};
	/* A terrain that is true to scale within 0.1 % is as fine as its map. */
	double most = globe && !frame->fine_globe ? spacing * M_SQRT2 : spacing * 1.005;
	while (zoom.z < EXCHANGE_ZOOM_MOST && step_of(frame, &zoom) > most)
		zoom.z++;
	return zoom.z;
}

static int first_map(const struct exchange_frame *frame)
{
	const double *metres = frame->metres;
	double size = fmax(metres[2] - metres[0], metres[3] - metres[1]);
	struct exchange_zoom zoom = {.z = 0};
	while (zoom.z < EXCHANGE_ZOOM_MOST) {
		zoom.z++;
		if (step_of(frame, &zoom) * frame->pixels < size)
			return zoom.z - 1;
	}
	return zoom.z;
}

struct planning {
	struct exchange_zooms *zooms;
	const struct exchange_frame *frame;
	const struct extent *extent;
	struct store *store;
	struct store_reader *reader;
	int finest_base;                 /* level of the finest inset; 0: there is none */
	struct rects deformed, changed;  /* tiles of the working level */
};

/* The first zoom level that is as fine as a level of the store. */
static int zoom_of(const struct planning *planning, bool globe, int level)
{
	return first_within(planning->frame, globe, extent_spacing(planning->extent, level));
}

/* Adds the tiles where insets lie that are at least as fine as a sparse zoom level shows. */
static enum status add_insets(const struct planning *planning, struct exchange_zoom *zoom)
{
	struct rects insets = {planning->frame, NULL, 0, 0};
	int level = -1;
	while (level >= planning->finest_base && zoom_of(planning, zoom->globe, level) < zoom->z)
		level--;
	enum status status = STATUS_OK;
	if (level >= planning->finest_base)
		TRY_OR(done, store_each_base(planning->reader, level, add_tile, &insets));
	TRY_OR(done, add_tiles(planning->frame, zoom, &insets, 0, 0, &zoom->tiles));
done:
	mem_free(insets.rects);
	return status;
}

static enum status plan_tiles(const struct planning *planning, struct exchange_zoom *zoom)
{
	const struct exchange_zooms *zooms = planning->zooms;
	const struct exchange_frame *frame = planning->frame;
	if (zoom->sparse && zooms->deformed && zoom->z <= zoom_of(planning, zoom->globe, zooms->working))
		TRY(add_tiles(frame, zoom, &planning->deformed, 0, 0, &zoom->tiles));
	if (zoom->sparse)
		TRY(add_insets(planning, zoom));
	if (!zoom->globe && zoom->z >= zooms->ruts)
		TRY(add_tiles(frame, zoom, &planning->deformed, 0, 0, &zoom->deformed));
	/* A change shows in the cells around it, and in the slopes of the next samples. */
	double more = 2 * fmax(zoom->step, extent_spacing(planning->extent, zoom->level));
	if (zoom->some)
		TRY(add_tiles(frame, zoom, &planning->changed, more, zoom->globe ? 1 : 0, &zoom->due));
	return STATUS_OK;
}

static enum status plan_zoom(const struct planning *planning, bool globe, int z, int dense, bool some)
{
	struct exchange_zooms *zooms = planning->zooms;
	const struct exchange_frame *frame = planning->frame;
	const struct extent *extent = planning->extent;
	struct exchange_zoom *zoom = &zooms->zooms[zooms->count++];
	*zoom = (struct exchange_zoom){.globe = globe, .z = z, .sparse = z > dense, .some = some};
	zoom->step = step_of(frame, zoom);
	long level = lround(log2(zoom->step / extent->spacing));
	int imagery = 0;
	zoom->imagery = !globe && z > zooms->map[1];
	if (zoom->imagery) {
		store_has_imagery(planning->store, &imagery, NULL);
		zoom->sparse = false;
	}
	long finest = zoom->imagery ? imagery : zoom->sparse ? zooms->finest : 0, coarsest = extent_coarsest(extent);
	zoom->level = (int)(level < finest ? finest : level > coarsest ? coarsest : level);
	int64_t range[4];
	tiles_of(frame, zoom, !globe && frame->globe == NULL ? frame->metres : frame->bounds, range);
	if (globe && z == 0) {
		range[0] = 0;
		range[2] = 2;
	}
	zoom->x0 = range[0], zoom->y0 = range[1], zoom->x1 = range[2], zoom->y1 = range[3];
	zoom->control = exchange_place_control(frame, zoom);
	TRY(plan_tiles(planning, zoom));
	if (zoom->some || zoom->sparse)
		return sort_keys(zoom->some ? &zoom->due : &zoom->tiles, zoom);
	zoom->units = blocks(zoom->x0, zoom->x1) * blocks(zoom->y0, zoom->y1);
	return STATUS_OK;
}

static enum status plan(const struct planning *planning, bool some)
{
	struct exchange_zooms *zooms = planning->zooms;
	int working = zooms->deformed && zooms->working < 0 ? zooms->working : 0;
	zooms->finest = working < planning->finest_base ? working : planning->finest_base;
	int dense = zoom_of(planning, false, 0), mesh = zoom_of(planning, true, 0);
	zooms->ruts = zoom_of(planning, false, working);
	zooms->map[1] = planning->frame->whole_only ? dense : zoom_of(planning, false, zooms->finest);
	zooms->mesh[1] = zoom_of(planning, true, zooms->finest);
	zooms->map[0] = first_map(planning->frame);
	zooms->map[0] = zooms->map[0] < dense ? zooms->map[0] : dense;
	zooms->mesh[0] = 0;
	int imagery = 0;
	const bool has = store_has_imagery(planning->store, &imagery, NULL);
	zooms->imagery = !has ? -1 : imagery < zooms->finest ? zoom_of(planning, false, imagery) : zooms->map[1];
	for (int z = zooms->imagery > zooms->map[1] ? zooms->imagery : zooms->map[1]; z >= zooms->map[0]; z--)
		TRY(plan_zoom(planning, false, z, dense, some));
	for (int z = planning->frame->maps_only ? -1 : zooms->mesh[1]; z >= 0; z--)
		TRY(plan_zoom(planning, true, z, mesh, some));
	return STATUS_OK;
}

/* Lists the tiles that hold a deformation, and those that changed after revision `since`; then plans all zoom levels. */
static enum status list_and_plan(struct planning *planning, int64_t since)
{
	struct exchange_zooms *zooms = planning->zooms;
	zooms->deformed = store_has_working_level(planning->store, &zooms->working);
	if (zooms->deformed)
		TRY(store_each_offset(planning->reader, zooms->working, add_tile, &planning->deformed));
	/* Revisions begin at 1; those after INT64_MAX are none. */
	TRY(store_each_changed(planning->reader, since >= 0 ? since : INT64_MAX, add_tile, &planning->changed, &zooms->revision));
	if (since > zooms->revision)
		return fail_with(STATUS_INPUT, "--since %lld: the store's last revision is %lld; give that, or export all tiles again if the store "
				 "was reset", (long long)since, (long long)zooms->revision);
	return plan(planning, since >= 0);
}

enum status exchange_zooms_init(struct exchange_zooms *zooms, const struct exchange_frame *frame, struct store_reader *reader,
				struct store *store, int64_t since)
{
	struct planning planning = {
		.zooms = zooms,
		.frame = frame,
		.extent = &frame->meta->extent,
		.store = store,
		.reader = reader,
		.finest_base = store_finest_base(store),
		.deformed = {frame, NULL, 0, 0},
		.changed = {frame, NULL, 0, 0},
	};
	*zooms = (struct exchange_zooms){.count = 0};
	enum status status = list_and_plan(&planning, since);
	mem_free_all(planning.deformed.rects, planning.changed.rects);
	if (status != STATUS_OK)
		exchange_zooms_finish(zooms);
	return status;
}

void exchange_zooms_finish(struct exchange_zooms *zooms)
{
	for (size_t i = 0; i < zooms->count; i++) {
		key_set_finish(&zooms->zooms[i].tiles);
		key_set_finish(&zooms->zooms[i].deformed);
		key_set_finish(&zooms->zooms[i].due);
		mem_free(zooms->zooms[i].order);
	}
	*zooms = (struct exchange_zooms){.count = 0};
}
