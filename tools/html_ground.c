/* Reads the store that a drive left, around the ways of the drive, and makes a picture of it. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "html_map.h"
#include "store/store.h"

#define MARGIN 0.08     /* of the longer side */
#define REACH 2.0       /* m around a way that is shown at least */
#define POSTS_LEAST 64  /* of the working level on a side */
#define NARROW 0.4      /* the shorter side is at least so much of the longer one */
#define TILES_MOST 2048 /* tiles of offsets that are read */

static enum status none(struct html_map *map, const char *format, ...) FURROW_PRINTF(2, 3);

static enum status none(struct html_map *map, const char *format, ...)
{
	va_list args;
	va_start(args, format);
	vsnprintf(map->why, sizeof map->why, format, args);
	va_end(args);
	return STATUS_OK;
}

/* Finds the extent of all ways, cut at the terrain's edges. Without a way on the terrain it is the whole terrain. */
static void find_extent(const struct html_run *run, const double size[2], double spacing, double low[2], double high[2])
{
	const struct html_bodies *bodies = html_ways(run);
	for (int axis = 0; axis < 2; axis++) {
		low[axis] = INFINITY;
		high[axis] = -INFINITY;
	}
	for (size_t k = 0; k < bodies->count; k++)
		for (size_t i = 0; i < bodies->list[k].count; i++) {
			const double place[2] = {bodies->list[k].x[i], bodies->list[k].y[i]};
			for (int axis = 0; axis < 2; axis++) {
				const double held = fmin(fmax(place[axis], 0), size[axis]);
				low[axis] = fmin(low[axis], held);
				high[axis] = fmax(high[axis], held);
			}
		}
	for (int axis = 0; axis < 2; axis++)
		if (!(high[axis] >= low[axis])) {
			low[axis] = 0;
			high[axis] = size[axis];
		}
	const double side = fmax(high[0] - low[0], high[1] - low[1]), margin = fmax(MARGIN * side, REACH);
	const double least = fmax(POSTS_LEAST * spacing, NARROW * (side + 2 * margin));
	for (int axis = 0; axis < 2; axis++) {
		const double more = fmax(margin, (least - (high[axis] - low[axis])) / 2);
		low[axis] -= more;
		high[axis] += more;
	}
}

static enum status find_raster(const struct html_run *run, struct store *store, uint32_t pixels, struct chart_raster *raster)
{
	const struct store_meta *meta = store_meta(store);
	const struct extent *extent = &meta->extent;
	const double size[2] = {extent_side(extent, 0), extent_side(extent, 1)};
	struct chart_raster_params params = {.meta = meta, .layer = STORE_OFFSET, .exaggerate = 1, .tiles_most = TILES_MOST};
	double low[2], high[2];
	params.deformed = store_has_working_level(store, &params.working);
	const int from = params.deformed && params.working < 0 ? params.working : 0;
	const double spacing = extent_spacing(extent, from);
	find_extent(run, size, spacing, low, high);
	params.rect = post_rect_intersect((struct post_rect){(int64_t)floor(low[0] / spacing), (int64_t)floor(low[1] / spacing),
							     (int64_t)ceil(high[0] / spacing) + 1, (int64_t)ceil(high[1] / spacing) + 1},
					  (struct post_rect){0, 0, extent_posts(extent->width, from), extent_posts(extent->height, from)});
	params.level = chart_level(extent, from, pixels, &params.rect);
	chart_sun_of(CHART_AZIMUTH, CHART_ALTITUDE, &params.sun);
	struct store_reader *reader = NULL;
	enum status status;
	TRY_OR(done, store_reader_create(store, &reader));
	params.reader = reader;
	TRY_OR(done, chart_raster_create(&params, raster));
	/* Ruts of one pixel are widened, so that ways do not hide them. */
	if (params.deformed && params.level > params.working)
		TRY_OR(done, chart_raster_widen(raster));
done:
	store_reader_destroy(reader);
	return status;
}

static void fill_key(const struct chart_map *chart, struct html_map *map)
{
	for (int i = 0; i < HTML_KEY; i++)
		map->key[i] = chart_ground_key(chart, &map->range, map->range.low + (map->range.high - map->range.low) * (i + 0.5) / HTML_KEY);
}

/* Draws the picture. A range of 0 and 0: as the values need it. */
static enum status draw(struct html_map *map, struct chart_range range)
{
	const struct chart_raster *raster = &map->raster;
	const uint32_t longest = raster->width > raster->height ? raster->width : raster->height;
	const uint32_t times = longest > 0 && longest * 2 <= map->pixels ? map->pixels / longest : 1; /* posts stay whole pixels */
	const struct chart_map chart = {.raster = raster, .ramp = CHART_RAMP_SIGNED, .range = range, .pixels = longest * times};
	struct chart_ground told;
	size_t length = 0;
	free(map->bytes);
	map->bytes = NULL;
	FILE *file = open_memstream(&map->bytes, &length);
	TRY_MEM(file, "a map");
	enum status status = chart_ground_write(&chart, "a map", file, &told);
	if (fclose(file) != 0 && status == STATUS_OK)
		status = fail_memory("a map");
	TRY(status);
	map->range = told.range;
	map->beyond[0] = !isnan(told.beyond[0]);
	map->beyond[1] = !isnan(told.beyond[1]);
	map->holes = told.holes;
	map->ground.png = (const unsigned char *)map->bytes;
	map->ground.length = length;
	for (int k = 0; k < 2; k++) { /* a pixel's centre is its post */
		map->ground.low[k] = ((double)(k == 0 ? raster->rect.x0 : raster->rect.y0) - 0.5) * raster->spacing;
		map->ground.high[k] = map->ground.low[k] + (k == 0 ? raster->width : raster->height) * raster->spacing;
	}
	fill_key(&chart, map);
	return STATUS_OK;
}

static enum status read_store(const struct html_run *run, struct store *store, const char *path, uint32_t pixels, struct html_map *map)
{
	struct store_run last;
	const struct store_meta *meta = store_meta(store);
	const char *hash = html_string(run, "scene.hash");
	TRY(store_last_run(store, &last));
	if (last.scene_hash == NULL || hash == NULL || strcmp(last.scene_hash, hash) != 0 || (double)last.step != html_number(run, "steps"))
		return none(map, "%.300s was changed after this drive: by another drive, a reset or a restore", path);
	map->pixels = pixels;
	chart_system_name(meta->srs, map->system, sizeof map->system);
	for (int k = 0; k < 2; k++)
		map->origin[k] = meta->origin[k];
	TRY(find_raster(run, store, pixels, &map->raster));
	return draw(map, (struct chart_range){0, 0});
}

enum status html_map_read(const struct html_run *run, uint32_t pixels, struct html_map *out)
{
	const char *path = html_string(run, "store.file");
	struct store *store = NULL;
	*out = (struct html_map){.bytes = NULL};
	if (path == NULL)
		return none(out, "run.json does not name the store; an older furrow made it");
	if (!html_is_file(path))
		return none(out, "%.300s is not there any more", path);
	enum status status;
	TRY_OR(done, store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	TRY_OR(done, read_store(run, store, path, pixels, out));
done:
	store_close(store);
	if (status != STATUS_OK)
		out->ground.png = NULL;
	/* A store that cannot be read does not make the report fail: another program may be writing it. */
	return status == STATUS_INPUT || status == STATUS_FAILED ? none(out, "%.450s", failure_message()) : status;
}

enum status html_maps_share(struct html_map *maps, size_t count)
{
	struct chart_range range = {0, 0};
	for (size_t i = 0; i < count; i++)
		if (maps[i].ground.png != NULL) {
			range.low = fmin(range.low, maps[i].range.low);
			range.high = fmax(range.high, maps[i].range.high);
		}
	if (range.low < 0 && range.high > 0) {
		range.high = fmax(range.high, -range.low);
		range.low = -range.high;
	}
	for (size_t i = 0; i < count; i++) {
		const struct chart_range *own = &maps[i].range;
		if (maps[i].ground.png != NULL && own->high > own->low && (own->low != range.low || own->high != range.high))
			TRY(draw(&maps[i], range));
	}
	return STATUS_OK;
}

void html_map_finish(struct html_map *map)
{
	free(map->bytes);
	chart_raster_finish(&map->raster);
	*map = (struct html_map){.bytes = NULL};
}
