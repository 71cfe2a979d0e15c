/* The soil of each post: by a raster's values, by roads over it, and by rocks over these. */
#include "resident/resident.h"

#include <assert.h>
#include <string.h>

#include "dem/dem.h"
#include "resident/roads.h"

struct soil_map {
	struct soil_map_params params;
	struct roads *roads;          /* NULL: none */
	unsigned count;               /* 0: there is no raster */
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
	enum status status = resident_roads_create(params->parts, params->part_count, &map->roads);
	for (; params->path != NULL && map->count < count && status == STATUS_OK; map->count += status == STATUS_OK)
		status = dem_pixels_open(&raster, DEM_PLACED_CLASSES, &map->rasters[map->count]);
	if (status == STATUS_OK && params->places && params->path != NULL)
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
	resident_roads_destroy(map->roads);
	mem_free(map);
}

/* Writes the soil of rocks where they raise posts, and leaves other posts. Fails only without memory. */
static enum status paint_rocks(const struct soil_map *map, int level, struct post_rect rect, uint8_t *classes)
{
	const size_t count = (size_t)(rect.x1 - rect.x0) * (size_t)(rect.y1 - rect.y0);
	int32_t *heights = NULL;
	if (!rocks_any(map->params.rocks))
		return STATUS_OK;
	TRY(mem_make(&heights, count, sizeof *heights, "rocks"));
	rocks_heights(map->params.rocks, level, rect, heights);
	for (size_t i = 0; i < count; i++)
		classes[i] = heights[i] > 0 ? map->params.rocks_soil : classes[i];
	mem_free(heights);
	return STATUS_OK;
}

/* raster NULL: there is none. */
static enum status read_rect(const struct soil_map *map, struct dem_pixels *raster, int level,
			     struct post_rect rect, uint8_t *classes)
{
	enum status status = STATUS_OK;
	dem_quiet_begin();
	if (raster != NULL)
		status = dem_classes_read(raster, level, rect, map->params.classes, 0, classes);
	else
		memset(classes, 0, (size_t)(rect.x1 - rect.x0) * (size_t)(rect.y1 - rect.y0));
	dem_quiet_end();
	resident_roads_paint(map->roads, extent_spacing(&map->params.meta->extent, level), rect, classes);
	return status == STATUS_OK ? paint_rocks(map, level, rect, classes) : status;
}

static struct dem_pixels *raster_of(const struct soil_map *map, unsigned loader)
{
	assert(map->count == 0 || loader < map->count);
	return map->count > 0 ? map->rasters[loader] : NULL;
}

enum status resident_soil_map_read(struct soil_map *map, unsigned loader, struct tile tile,
				   uint8_t *classes)
{
	return read_rect(map, raster_of(map, loader), tile.level,
			 tile_post_rect(&map->params.meta->extent, tile), classes);
}

enum status resident_soil_map_rect(struct soil_map *map, int level, struct post_rect rect,
				   uint8_t *classes)
{
	return read_rect(map, raster_of(map, 0), level, rect, classes);
}

/* A byte has no room for "none" beside 256 values, so a second read tells whether there is a value. */
enum status resident_soil_map_value(struct soil_map *map, int level, int64_t x, int64_t y, int *value, uint8_t *soil)
{
	const struct post_rect post = {x, y, x + 1, y + 1};
	uint8_t same[256], any[256], read = 0, has = 0;
	int32_t rock;
	*soil = 0;
	rocks_heights(map->params.rocks, level, post, &rock);
	if (rock > 0) {
		*value = SOIL_MAP_ROCK;
		*soil = map->params.rocks_soil;
		return STATUS_OK;
	}
	resident_roads_paint(map->roads, extent_spacing(&map->params.meta->extent, level), post, soil);
	*value = *soil > 0 ? SOIL_MAP_ROAD : SOIL_MAP_NONE;
	if (*soil > 0 || map->count == 0)
		return STATUS_OK;
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
	*value = read > 0 || has > 0 ? read : SOIL_MAP_NONE;
	*soil = *value >= 0 ? map->params.classes[*value] : 0;
	return status;
}

enum status resident_soil_map_at(struct soil_map *map, int level, int64_t x, int64_t y, uint8_t *soil)
{
	assert(map->at != NULL || map->count == 0);
	return read_rect(map, map->at, level, (struct post_rect){x, y, x + 1, y + 1}, soil);
}
