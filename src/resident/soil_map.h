/* The scene's map of soils: which class each post of a tile is of. A handle on the raster for each loader. */
#ifndef FURROW_RUN_SOIL_MAP_H
#define FURROW_RUN_SOIL_MAP_H

#include "scene/scene.h"
#include "store/store.h"

struct soil_map;

/* Whether the scene has a map and anything that would look at it: then all below is made. */
bool soil_map_needed(const struct scene *scene);
/* For the scene's loaders (none: one thread). *out NULL: the scene has no map, or nothing that would look at it. `meta` must outlive it. */
enum status soil_map_open(const struct scene *scene, const struct store_meta *meta, struct soil_map **out) FURROW_CHECKED;
void soil_map_close(struct soil_map *map); /* takes NULL */
/* Loader `loader`'s thread: indices into the scene's soils, (cells + 1)^2. */
enum status soil_map_read(struct soil_map *map, unsigned loader, struct tile tile, uint8_t *classes) FURROW_CHECKED;

#endif
