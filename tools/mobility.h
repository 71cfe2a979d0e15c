/* What the files of furrow mobility share. */
#ifndef FURROW_TOOLS_MOBILITY_H
#define FURROW_TOOLS_MOBILITY_H

#include "command.h"
#include "mobility/mobility.h"
#include "render/render.h"
#include "store/store.h"

#define MOBILITY_SAMPLES_MOST 64

/* Classes of a map's cell, and numbers of --layer class. */
enum mobility_class { CLASS_NO_GO, CLASS_GO, CLASS_SOME, CLASS_UNKNOWN, CLASSES };
enum mobility_class mobility_class_of(const struct mobility_slope *slope);

/* One cell of a map, by its post. */
struct mobility_cell {
	struct mobility_slope slope;
	double probability; /* that it goes straight up, of the soils of the spread */
	double shade;       /* 0 to 1; NaN: no ground */
};

struct mobility_map {
	const char *store, *path;      /* as given */
	const char *vehicle, *soil;    /* names for titles */
	const struct mobility_table *tables; /* of the soil, and then of each of the spread */
	size_t table_count;
	struct store_reader *reader;
	const struct store_meta *meta;
	int level;                     /* of the posts, one a cell */
	struct post_rect rect;
	bool coarse;                   /* the terrain's posts are farther apart than the vehicle is long */
	struct render_sun sun;
};

/* Reads rows of cells, from y0 to y1, into (x1 - x0) * (y1 - y0) of them. */
enum status mobility_cells(const struct mobility_map *map, int64_t y0, int64_t y1, struct mobility_cell *cells) FURROW_CHECKED;
/* mobility_picture.c: draws the classes over the hillshade, with a legend, a scale bar and shares of the area. */
enum status mobility_picture(const struct mobility_map *map, const double shares[CLASSES]) FURROW_CHECKED;

#endif
