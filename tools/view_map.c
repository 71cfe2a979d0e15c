/* The map in a corner of the window of furrow view: the shaded ground of the store as it is at first, read once. */
#include <math.h>

#include "view.h"

#define SIDE 240u /* pixels, at most */

static enum status shade(struct view_map *map, struct store *store, struct store_reader *reader)
{
	const struct store_meta *meta = store_meta(store);
	struct chart_raster raster = {.width = 0};
	struct chart_raster_params params = {.reader = reader, .meta = meta, .layer = STORE_BASE, .exaggerate = 1};
	chart_sun_of(CHART_AZIMUTH, CHART_ALTITUDE, &params.sun);
	params.rect = (struct post_rect){0, 0, extent_posts(meta->extent.width, 0), extent_posts(meta->extent.height, 0)};
	params.level = chart_level(&meta->extent, 0, SIDE, &params.rect);
	TRY(chart_raster_create(&params, &raster));
	enum status status;
	TRY_OR(done, mem_make(&map->shade, (size_t)raster.width * raster.height, 1, "a map"));
	for (size_t i = 0; i < (size_t)raster.width * raster.height; i++) /* level ground: a middling grey; nodata: dark */
		map->shade[i] = isnan(raster.shade[i]) ? 20 : (uint8_t)fmin(fmax(170 + 255 * (raster.shade[i] - raster.flat), 40), 255);
	map->width = raster.width;
	map->height = raster.height;
	map->metres = raster.spacing;
done:
	chart_raster_finish(&raster);
	return status;
}

enum status view_map_make(struct view_map *map, const char *path)
{
	struct store *store;
	struct store_reader *reader = NULL;
	TRY(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	enum status status;
	TRY_OR(done, store_reader_create(store, &reader));
	TRY_OR(done, shade(map, store, reader));
done:
	store_reader_destroy(reader);
	store_close(store);
	return status;
}

void view_map_finish(struct view_map *map)
{
	mem_free(map->shade);
}
