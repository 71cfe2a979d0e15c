/* furrow mobility, as a map: classes in colour over the hillshade, with shares of the area. */
#include <stdio.h>
#include <string.h>

#include "mobility.h"

#define SIDE 900 /* smaller maps are enlarged to at least that */

/* Colours are Okabe's and Ito's, so that every eye tells them apart. */
struct key {
	const char *name;
	struct chart_colour colour;
	int which; /* colour's number, as mobility_colour_of gives it */
};
static const struct key classes[] = {
	{"go at every heading", {0, 158, 115, 255}, CLASS_GO},
	{"go at some headings only", {240, 228, 66, 255}, CLASS_SOME},
	{"no-go", {213, 94, 0, 255}, CLASS_NO_GO},
	{"unknown: too steep to say", {150, 150, 158, 255}, CLASS_UNKNOWN},
	{NULL, {0, 0, 0, 0}, 0},
};
static const struct key ranges[] = {
	{"0.9 to 1", {0, 158, 115, 255}, 3},
	{"0.5 to 0.9", {86, 180, 233, 255}, 2},
	{"0.1 to 0.5", {240, 228, 66, 255}, 1},
	{"below 0.1", {213, 94, 0, 255}, 0},
	{"unknown", {150, 150, 158, 255}, MOBILITY_RANGES - 1},
	{NULL, {0, 0, 0, 0}, 0},
};

static const struct key *keys_of(const struct mobility_map *map)
{
	return map->layer == LAYER_PROBABILITY ? ranges : classes;
}

void mobility_picture_row(struct mobility_picture *picture, const struct mobility_map *map, int64_t y,
			  const struct mobility_cell *cells)
{
	const size_t width = picture->raster.width, row = (size_t)(y - map->rect.y0) * width;
	const struct key *const keys = keys_of(map);
	for (size_t x = 0; x < width; x++) {
		const struct mobility_cell *cell = &cells[x];
		int key = 0;
		picture->raster.shade[row + x] = (float)cell->shade;
		picture->classes[row + x] = CHART_NO_CLASS;
		if (cell->slope.up.reason == MOBILITY_NO_GROUND)
			continue;
		while (keys[key].which != mobility_colour_of(cell, map->layer))
			key++;
		picture->classes[row + x] = (uint8_t)key;
	}
}

enum status mobility_picture_create(const struct mobility_map *map, struct mobility_picture *picture)
{
	const size_t width = (size_t)(map->rect.x1 - map->rect.x0), height = (size_t)(map->rect.y1 - map->rect.y0);
	*picture = (struct mobility_picture){.raster = {.width = (uint32_t)width,
							.height = (uint32_t)height,
							.level = map->level,
							.rect = map->rect,
							.spacing = extent_spacing(&map->meta->extent, map->level)}};
	picture->raster.shade = mem_alloc(width * height, sizeof *picture->raster.shade);
	picture->classes = mem_alloc(width * height, 1);
	return picture->raster.shade != NULL && picture->classes != NULL ? STATUS_OK : fail_memory("a map");
}

enum status mobility_picture_write(struct mobility_picture *picture, const struct mobility_map *map)
{
	const char *slash = strrchr(map->store, '/');
	const uint32_t width = picture->raster.width, height = picture->raster.height, longest = width > height ? width : height;
	char subtitle[256];
	struct chart_key keys[MOBILITY_COLOURS];
	size_t count = 0;
	for (const struct key *key = keys_of(map); key->name != NULL; key++)
		keys[count++] = (struct chart_key){key->name, key->colour, map->colours[key->which]};
	snprintf(subtitle, sizeof subtitle, "%s in %s", map->vehicle, map->soil);
	const struct chart_map chart = {
		.raster = &picture->raster,
		.meta = map->meta,
		.title = slash != NULL ? slash + 1 : map->store,
		.subtitle = subtitle,
		.layer = map->layer == LAYER_PROBABILITY ? "Probability of going straight up, and share of the area"
							 : "Go or no-go, and share of the area",
		.classes = picture->classes,
		.keys = keys,
		.key_count = count,
		.pixels = longest < SIDE ? (SIDE + longest - 1) / longest * longest
					 : longest, /* a cell is a whole number of pixels */
	};
	return chart_map_write(&chart, map->path, NULL);
}

void mobility_picture_finish(struct mobility_picture *picture)
{
	chart_raster_finish(&picture->raster);
	mem_free(picture->classes);
	picture->classes = NULL;
}
