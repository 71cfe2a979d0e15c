#include "resident/soil_map.h"

#include <assert.h>

#include "dem/dem.h"

struct soil_map {
	const struct scene *scene;
	const struct store_meta *meta;
	unsigned count;
	struct dem_classes *rasters[]; /* one a loader */
};

bool soil_map_needed(const struct scene *scene)
{
	return scene->soil_map != NULL && (scene->object_count > 0 || scene_draws_classes(scene));
}

enum status soil_map_open(const struct scene *scene, const struct store_meta *meta, struct soil_map **out)
{
	*out = NULL;
	if (!soil_map_needed(scene))
		return STATUS_OK;
	unsigned count = scene->loaders > 0 ? scene->loaders : 1;
	struct soil_map *map = mem_calloc(1, sizeof *map + count * sizeof map->rasters[0]);
	if (map == NULL)
		return fail_memory("the map of soils");
	map->scene = scene;
	map->meta = meta;
	const struct dem_classes_params params = {
		.path = scene->soil_map,
		.extent = &meta->extent,
		.srs = meta->srs,
		.origin = {meta->origin[0], meta->origin[1]},
	};
	enum status status = STATUS_OK;
	for (; map->count < count && status == STATUS_OK; map->count += status == STATUS_OK)
		status = dem_classes_open(&params, &map->rasters[map->count]);
	if (status != STATUS_OK) {
		soil_map_close(map);
		return status;
	}
	*out = map;
	return STATUS_OK;
}

void soil_map_close(struct soil_map *map)
{
	if (map == NULL)
		return;
	for (unsigned i = 0; i < map->count; i++)
		dem_classes_close(map->rasters[i]);
	mem_free(map);
}

enum status soil_map_read(struct soil_map *map, unsigned loader, struct tile tile, uint8_t *classes)
{
	assert(loader < map->count);
	return dem_classes_read(map->rasters[loader], tile.level, tile_post_rect(&map->meta->extent, tile),
				map->scene->soil_class, 0, classes);
}
