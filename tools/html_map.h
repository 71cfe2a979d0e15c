/* The ground of a drive as a picture: its shade, and by how much the drive changed its height. */
#ifndef FURROW_TOOLS_HTML_MAP_H
#define FURROW_TOOLS_HTML_MAP_H

#include "chart/chart.h"
#include "html_plot.h"
#include "html_run.h"

enum { HTML_KEY = 24 }; /* colours of the legend */

struct html_map {
	struct html_ground ground;     /* its png is NULL: there is none, and `why` tells. It is `bytes` */
	char *bytes;
	struct chart_range range;      /* m: values at the ends of the colours; both 0: nothing changed */
	bool beyond[2], holes;
	struct chart_colour key[HTML_KEY]; /* from the lowest value to the highest */
	struct chart_raster raster;
	uint32_t pixels;               /* of the longer side, at most */
	double origin[2];              /* of the south-west post in the store's system */
	char system[160];              /* that system's name and code; "": it has none */
	char why[512];                 /* one sentence */
};

/* `pixels`: of the longer side, at most. A store that cannot be read, or has changed since, gives no picture. */
enum status html_map_read(const struct html_run *run, uint32_t pixels, struct html_map *out) FURROW_CHECKED;
/* Draws the pictures again, with the largest range of all. */
enum status html_maps_share(struct html_map *maps, size_t count) FURROW_CHECKED;
void html_map_finish(struct html_map *map);

#endif
