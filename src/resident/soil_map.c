#include "resident/resident.h"

#include <assert.h>

#include "dem/dem.h"

struct soil_map {
	struct soil_map_params params;
	unsigned count;
	struct dem_pixels *at;        /* for resident_soil_map_at; NULL: nobody asks */
	struct dem_pixels *rasters[]; /* one a loader */
};

enum status resident_soil_map_open(const struct soil_map_params *params, struct soil_map **out)
{
	const struct store_meta *meta = params->meta;
	unsigned count = params->loaders > 0 ? params->loaders : 1;
	struct soil_map *map = mem_calloc(1, sizeof *map + count * sizeof map->rasters[0]);
	TRY_MEM(map, "the map of soils");
	map->params = *params;
	const struct dem_placed_params raster = {
		.path = params->path,
		.extent = &meta->extent,
		.srs = meta->srs,
		.origin = {meta->origin[0], meta->origin[1]},
	};
	enum status status = STATUS_OK;
	for (; map->count < count && status == STATUS_OK; map->count += status == STATUS_OK)
		status = dem_pixels_open(&raster, DEM_PLACED_CLASSES, &map->rasters[map->count]);
	if (status == STATUS_OK && params->places)
		status = dem_pixels_open(&raster, DEM_PLACED_CLASSES, &map->at);
	if (status != STATUS_OK) {
		resident_soil_map_close(map);
		return status;
	}
	*out = map;
	return STATUS_OK;
}

void resident_soil_map_close(struct soil_map *map)
{
	if (map == NULL)
		return;
	for (unsigned i = 0; i < map->count; i++)
		dem_pixels_close(map->rasters[i]);
	dem_pixels_close(map->at);
	mem_free(map);
}

static enum status read_rect(const struct soil_map *map, struct dem_pixels *raster, int level,
			     struct post_rect rect, uint8_t *classes)
{
	dem_quiet_begin();
	enum status status = dem_classes_read(raster, level, rect, map->params.classes, 0, classes);
	dem_quiet_end();
	return status;
}

enum status resident_soil_map_read(struct soil_map *map, unsigned loader, struct tile tile,
				   uint8_t *classes)
{
	assert(loader < map->count);
	return read_rect(map, map->rasters[loader], tile.level,
			 tile_post_rect(&map->params.meta->extent, tile), classes);
}

enum status resident_soil_map_rect(struct soil_map *map, int level, struct post_rect rect,
				   uint8_t *classes)
{
	return read_rect(map, map->rasters[0], level, rect, classes);
}

/* A byte has no room for "none" beside 256 values, so a second read tells whether there is a value. */
enum status resident_soil_map_value(struct soil_map *map, int level, int64_t x, int64_t y, int *value)
{
	const struct post_rect post = {x, y, x + 1, y + 1};
	uint8_t same[256], any[256], read = 0, has = 0;
	for (int i = 0; i < 256; i++) {
		same[i] = (uint8_t)i;
		any[i] = 1;
	}
	dem_quiet_begin();
	enum status status;
	TRY_OR(done, dem_classes_read(map->rasters[0], level, post, same, 0, &read));
	if (read == 0)
		TRY_OR(done, dem_classes_read(map->rasters[0], level, post, any, 0, &has));
done:
	dem_quiet_end();
	*value = read > 0 || has > 0 ? read : -1;
	return status;
}

enum status resident_soil_map_at(struct soil_map *map, int level, int64_t x, int64_t y, uint8_t *soil)
{
	assert(map->at != NULL);
	return read_rect(map, map->at, level, (struct post_rect){x, y, x + 1, y + 1}, soil);
}
