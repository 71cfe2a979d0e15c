/* What the files of furrow mobility share. */
#ifndef FURROW_TOOLS_MOBILITY_H
#define FURROW_TOOLS_MOBILITY_H

#include "chart/chart.h"
#include "command.h"
#include "dem/dem.h"
#include "trials/trials.h"
#include "store/store.h"

#define MOBILITY_SAMPLES_MOST 64

/* Layers of a raster, in the order of their names. A picture has class or probability. */
enum mobility_layer { LAYER_SLIP, LAYER_STEEPEST, LAYER_CLASS, LAYER_PROBABILITY, LAYER_REASON };
extern const char *const mobility_layers[];

/* Classes of a map's cell, and numbers of --layer class. */
enum mobility_class { CLASS_NO_GO, CLASS_GO, CLASS_SOME, CLASS_UNKNOWN, CLASSES };
extern const char *const mobility_classes[CLASSES];
/* Of a picture of probability: a class for each of four ranges, and unknown. */
#define MOBILITY_RANGES 5
#define MOBILITY_COLOURS 5 /* the more of both */

/* One cell of a map, by its post. */
struct mobility_cell {
	struct mobility_slope slope;
	double probability; /* that it goes straight up, of the soils of the spread. NaN: not known, or no spread */
	double shade;       /* 0 to 1; NaN: no ground */
};
enum mobility_class mobility_class_of(const struct mobility_slope *slope);
/* Returns the colour of a picture of this layer: a class, or a range of probability. */
int mobility_colour_of(const struct mobility_cell *cell, enum mobility_layer layer);

struct mobility_map {
	const char *store, *path;      /* as given */
	const char *vehicle, *soil;    /* names for titles */
	double mass, gravity;          /* kg, m/s2 */
	double spread[3];
	int64_t seed;
	const struct mobility_table *table;    /* of the soil */
	const struct mobility_column *columns; /* of each soil of the spread */
	size_t samples;
	struct store_reader *reader;
	const struct store_meta *meta;
	enum mobility_layer layer;
	int level;                     /* of the posts, one a cell */
	struct post_rect rect;
	struct chart_sun sun;
	/* What mobility_draw counts: shares of the cells that have ground. */
	double shares[CLASSES], colours[MOBILITY_COLOURS];
};

/* mobility_cells.c: judges all cells, once, and writes the raster or the picture. */
enum status mobility_draw(struct mobility_map *map) FURROW_CHECKED;

/* mobility_picture.c: the layer in colours over the hillshade, with shares of the area. */
struct mobility_picture {
	struct chart_raster raster; /* its shade; without values */
	uint8_t *classes;           /* of each cell */
};
enum status mobility_picture_create(const struct mobility_map *map, struct mobility_picture *picture) FURROW_CHECKED;
void mobility_picture_row(struct mobility_picture *picture, const struct mobility_map *map, int64_t y, const struct mobility_cell *cells);
/* Adds the legend, and writes the file. */
enum status mobility_picture_write(struct mobility_picture *picture, const struct mobility_map *map) FURROW_CHECKED;
void mobility_picture_finish(struct mobility_picture *picture);

/* mobility_told.c: what is said at the end, as text or as one JSON object. */
void mobility_print(const struct mobility_map *map);
enum status mobility_print_json(const struct mobility_map *map) FURROW_CHECKED;

#endif
