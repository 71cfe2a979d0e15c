/*
 * Joins several sources to one dataset: GDAL's virtual mosaic of their metres. The source named first is drawn last, so it is on
 * top. Also measures by how much sources disagree where they overlap.
 */
#include "dem_gdal.h"

#define COMPARE_POSTS (1 << 19)

static bool upright(const double place[6])
{
	return place[2] == 0 && place[4] == 0 && place[1] > 0 && place[5] < 0;
}

static enum status sources_agree(const struct gdal_source *sources, size_t count)
{
	for (size_t i = 0; i < count; i++) {
		if (!sources[i].placed)
			return fail_with(STATUS_INPUT, "%s: has no place among other sources; import it alone, "
					 "or give it a place with gdal_translate", sources[i].path);
		if (!upright(sources[i].place))
			return fail_with(STATUS_INPUT, "%s: is rotated or not north up, and cannot be put "
					 "together with others so; straighten it with gdalwarp", sources[i].path);
		bool one = sources[0].srs == NULL || sources[i].srs == NULL
				   ? sources[0].srs == sources[i].srs
				   : OSRIsSame(sources[0].srs, sources[i].srs) != 0;
		if (!one)
			return fail_with(STATUS_INPUT, "%s: is in another SRS than %s; project one to the other's "
					 "with gdalwarp, or name the one both are in with --s-srs",
					 sources[i].path, sources[0].path);
	}
	return STATUS_OK;
}

/* Pixels [x0, x1) x [y0, y1) of `source`, in its own counting, that `other` covers too. */
struct shared {
	double x0, y0, x1, y1;
};

static struct shared window_in(const struct gdal_source *source, double west, double south, double east,
			       double north)
{
	const double *p = source->place;
	return (struct shared){(west - p[0]) / p[1], (north - p[3]) / p[5], (east - p[0]) / p[1],
			       (south - p[3]) / p[5]};
}

static bool is_whole(double v)
{
	return fabs(v - round(v)) < 0.01;
}

/* Reads one strip of the overlap: rows of `mine`, and the same ground in `theirs`. */
static CPLErr read_window(GDALDatasetH dataset, struct shared window, int width, int rows, double *out)
{
	GDALRasterIOExtraArg extra;
	INIT_RASTERIO_EXTRA_ARG(extra);
	double x0 = window.x0, y0 = window.y0, x1 = window.x1, y1 = window.y1;
	if (is_whole(x0) && is_whole(y0) && is_whole(x1) && is_whole(y1)) {
		x0 = round(x0);
		y0 = round(y0);
		x1 = round(x1);
		y1 = round(y1);
	} else {
		extra.eResampleAlg = GRIORA_Bilinear;
		extra.bFloatingPointWindowValidity = TRUE;
		extra.dfXOff = x0;
		extra.dfYOff = y0;
		extra.dfXSize = x1 - x0;
		extra.dfYSize = y1 - y0;
	}
	int from_x = (int)floor(x0), from_y = (int)floor(y0);
	int to_x = (int)ceil(x1), to_y = (int)ceil(y1);
	int limit_x = GDALGetRasterXSize(dataset), limit_y = GDALGetRasterYSize(dataset);
	from_x = from_x < 0 ? 0 : from_x;
	from_y = from_y < 0 ? 0 : from_y;
	to_x = to_x > limit_x ? limit_x : to_x;
	to_y = to_y > limit_y ? limit_y : to_y;
	return GDALRasterIOEx(GDALGetRasterBand(dataset, 1), GF_Read, from_x, from_y, to_x - from_x,
			      to_y - from_y, out, width, rows, GDT_Float64, 0, 0, &extra);
}

static void count_strip(const double *a, const double *b, size_t count, struct dem_grid *grid)
{
	for (size_t i = 0; i < count; i++) {
		if (isnan(a[i]) || isnan(b[i]))
			continue;
		double off = fabs(a[i] - b[i]);
		grid->overlap_posts++;
		grid->overlap_differing += off > 0 ? 1 : 0;
		grid->overlap_difference = off > grid->overlap_difference ? off : grid->overlap_difference;
	}
}

static enum status compare(const struct gdal_source *first, const struct gdal_source *second,
			   struct dem_grid *grid)
{
	const double *a = first->place, *b = second->place;
	double west = fmax(a[0], b[0]), north = fmin(a[3], b[3]);
	double east = fmin(a[0] + a[1] * first->width, b[0] + b[1] * second->width);
	double south = fmax(a[3] + a[5] * first->height, b[3] + b[5] * second->height);
	struct shared whole = window_in(second, west, south, east, north);
	int64_t x0 = (int64_t)ceil(whole.x0 - 0.01), x1 = (int64_t)floor(whole.x1 + 0.01);
	int64_t y0 = (int64_t)ceil(whole.y0 - 0.01), y1 = (int64_t)floor(whole.y1 + 0.01);
	if (!(east > west) || !(north > south) || x1 <= x0 || y1 <= y0)
		return STATUS_OK;
	int width = (int)(x1 - x0);
	int64_t strip = COMPARE_POSTS / width > 0 ? COMPARE_POSTS / width : 1;
	strip = strip < y1 - y0 ? strip : y1 - y0;
	size_t posts = (size_t)strip * (size_t)width;
	double *mine = mem_alloc(posts, sizeof *mine), *theirs = mem_alloc(posts, sizeof *theirs);
	GDALDatasetH one = GDALOpen(first->vrt, GA_ReadOnly), other = GDALOpen(second->vrt, GA_ReadOnly);
	enum status status = mine != NULL && theirs != NULL ? STATUS_OK : fail_memory("comparing overlaps");
	for (int64_t y = y0; status == STATUS_OK && y < y1; y += strip) {
		int rows = (int)(y1 - y < strip ? y1 - y : strip);
		struct shared at = {(double)x0, (double)y, (double)x1, (double)(y + rows)};
		struct shared there = window_in(first, b[0] + b[1] * at.x0, b[3] + b[5] * at.y1,
						b[0] + b[1] * at.x1, b[3] + b[5] * at.y0);
		if (one == NULL || other == NULL || read_window(other, at, width, rows, mine) != CE_None ||
		    read_window(one, there, width, rows, theirs) != CE_None)
			status = fail_with(STATUS_INPUT, "%s: reading where it overlaps %s failed: %s; check that "
					   "both are whole", second->path, first->path, dem_gdal_message());
		else
			count_strip(mine, theirs, (size_t)rows * (size_t)width, grid);
	}
	if (one != NULL)
		GDALClose(one);
	if (other != NULL)
		GDALClose(other);
	mem_free(mine);
	mem_free(theirs);
	return status;
}

static enum status build(const struct gdal_source *sources, size_t count, GDALDatasetH *out)
{
	/* Bilinear matters only where grids do not fall together. */
	const char *arguments[] = {"-resolution", "highest", "-r", "bilinear", "-vrtnodata", "nan", NULL};
	char **words = CSLDuplicate((char **)(uintptr_t)arguments), **names = NULL;
	for (size_t i = count; i-- > 0;)
		names = CSLAddString(names, sources[i].vrt);
	CPLErrorReset();
	GDALBuildVRTOptions *options = GDALBuildVRTOptionsNew(words, NULL);
	int usage = 0;
	*out = options != NULL ? GDALBuildVRT("", (int)count, NULL, (const char *const *)names, options, &usage)
			       : NULL;
	GDALBuildVRTOptionsFree(options);
	CSLDestroy(names);
	CSLDestroy(words);
	if (*out == NULL)
		return fail_with(STATUS_INPUT, "%s and %zu more: cannot be put together: %s; import fewer at once",
				 sources[0].path, count - 1, dem_gdal_message());
	return STATUS_OK;
}

enum status dem_mosaic(const struct gdal_source *sources, size_t count, struct dem_grid *grid,
		       GDALDatasetH *out)
{
	if (count == 1) {
		*out = GDALOpen(sources[0].vrt, GA_ReadOnly);
		if (*out == NULL)
			return fail_with(STATUS_INPUT, "%s: cannot be read: %s; give another raster",
					 sources[0].path, dem_gdal_message());
		return STATUS_OK;
	}
	enum status status = sources_agree(sources, count);
	for (size_t j = 1; status == STATUS_OK && j < count; j++)
		for (size_t i = 0; status == STATUS_OK && i < j; i++)
			status = compare(&sources[i], &sources[j], grid);
	return status == STATUS_OK ? build(sources, count, out) : status;
}
