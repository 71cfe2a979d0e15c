/* Parts of furrow edit: where soil comes or goes, as a raster of changes or as a polygon. */
#ifndef FURROW_TOOLS_EDIT_H
#define FURROW_TOOLS_EDIT_H

#include "base/base.h"
#include "store/store.h"

/* edit_polygon.c. Reads a polygon: WKT (POLYGON ((X Y, ...))), or the path of a file of WKT or GeoJSON with one. `srs`: of its coordinates, as place_local takes
 * it. NULL: GeoJSON is in degrees if the store has a reference system, all else in metres from the south-west post. Gives its corners in these
 * metres, count x 2, which the caller frees with mem_free. STATUS_INPUT: no such polygon, or it has a hole. */
enum status edit_polygon_read(const char *given, const struct store_meta *meta, const char *srs, size_t *count, double **xy) FURROW_CHECKED;

/* edit_raster.c. A GeoTIFF of changes of heights, m. */
struct edit_raster;
/* Opens it. *spacing: m between its posts. STATUS_INPUT: it is no GeoTIFF, or is of another reference system than the store. */
enum status edit_raster_open(const char *path, const struct store_meta *meta, struct edit_raster **out, double *spacing) FURROW_CHECKED;
void edit_raster_close(struct edit_raster *raster); /* takes NULL */
/* Reads the changes as 2^-20 m of posts that are `spacing` metres apart. Gives the smallest rectangle around all that are not 0, which is empty if all
 * are. The caller frees *amounts with mem_free. STATUS_INPUT: its pixels are not posts, it goes beyond the terrain, or a change is too large. */
enum status edit_raster_read(struct edit_raster *raster, const struct store_meta *meta, int level, struct post_rect *rect, int32_t **amounts) FURROW_CHECKED;

#endif
