/* Replaces the functions that need GDAL in a build without it. */
#include "dem_placed.h"

enum status dem_gdal_open(const struct dem_params *params, struct dem_list *list,
			  struct dem_grid **out)
{
	(void)params;
	(void)out;
	return fail_with(STATUS_INPUT, "%s: this furrow was built without GDAL and reads only PNG and raw "
			 "heightmaps; convert it, or build with GDAL", list->paths[0]);
}

bool dem_gdal_places(const struct dem_params *params, const char *path)
{
	(void)params, (void)path;
	return false;
}

bool dem_gdal_knows(const char *path)
{
	(void)path;
	return false;
}

enum status dem_zip_add(struct dem_list *list, const char *path)
{
	(void)list;
	return fail_with(STATUS_FAILED, "%s: this furrow was built without GDAL and reads no archives; unpack it, or build with GDAL", path);
}

enum status dem_gdal_sink(const struct dem_raster *raster, const char *part, struct dem_sink **out)
{
	(void)part;
	(void)out;
	return fail_with(STATUS_FAILED, "%s: this furrow was built without GDAL and writes only PNG; name a "
			 ".png, or build with GDAL", raster->path);
}

enum status dem_line_read(const char *path, const char *told, size_t number, struct dem_line *line)
{
	(void)path, (void)number, (void)line;
	return fail_with(STATUS_FAILED, "%s: this furrow was built without GDAL and reads no GPX and no GeoJSON; give points, or build with GDAL",
			 told);
}

void dem_line_finish(struct dem_line *line)
{
	(void)line;
}

enum status dem_transform(const char *from_srs, const char *to_wkt, size_t count, double *x, double *y)
{
	(void)to_wkt;
	(void)count;
	(void)x;
	(void)y;
	return fail_with(STATUS_FAILED, "coordinates in \"%.80s\": this furrow was built without GDAL and "
			 "knows no SRS; give local coordinates, or build with GDAL", from_srs);
}

double dem_ground_off(const char *wkt, const double low[2], const double high[2])
{
	(void)wkt, (void)low, (void)high;
	return 0;
}

enum status dem_globe_create(const char *wkt, struct dem_globe **out)
{
	(void)wkt;
	*out = NULL;
	return fail_with(STATUS_FAILED, "degrees of a store with an SRS: this furrow was built without GDAL and knows no SRS; build "
			 "with GDAL");
}

void dem_globe_destroy(struct dem_globe *globe)
{
	(void)globe;
}

/* No handle was ever made. */
const struct dem_globe_info *dem_globe_info(const struct dem_globe *globe)
{
	(void)globe;
	return NULL;
}

void dem_globe_to_degrees(struct dem_globe *globe, size_t count, double *x, double *y)
{
	(void)globe, (void)count, (void)x, (void)y;
}

void dem_globe_from_degrees(struct dem_globe *globe, size_t count, double *x, double *y)
{
	(void)globe, (void)count, (void)x, (void)y;
}

enum status dem_placed_gdal_open(const struct dem_placed_params *params, enum dem_placed_kind kind, int64_t most,
				 struct dem_placed **out)
{
	(void)most;
	(void)out;
	return fail_with(STATUS_INPUT, "%s: this furrow was built without GDAL and reads %s only from PNG; convert it, "
			 "or build with GDAL", params->path, kind == DEM_PLACED_CLASSES ? "classes" : "a soil's numbers");
}

enum status dem_imagery_open(const struct dem_imagery_params *params, struct dem_imagery **out)
{
	*out = NULL;
	return fail_with(STATUS_FAILED, "%s: this furrow was built without GDAL and imports no imagery; build with GDAL", params->sources[0]);
}

void dem_imagery_close(struct dem_imagery *imagery)
{
	(void)imagery;
}

/* No handle was ever made. */
const struct dem_imagery_info *dem_imagery_info(const struct dem_imagery *imagery)
{
	(void)imagery;
	return NULL;
}

enum status dem_imagery_read(struct dem_imagery *imagery, int level, struct post_rect rect, uint8_t *pixels)
{
	(void)imagery, (void)level, (void)rect, (void)pixels;
	return STATUS_FAILED;
}

void dem_network_begin(void)
{
}

void dem_network_end(void)
{
}

void dem_quiet_process(void)
{
}

void dem_quiet_begin(void)
{
}

void dem_quiet_end(void)
{
}
