/*
 * Writes GeoTIFF files with GDAL, in the layout of cloud-optimized ones: tiles, and overviews.
 *
 * Such a file is written in the order of its bytes, overviews first, and rows come from the south. So rows are collected to a band of
 * tiles and written to PATH.part.rows. At the end GDAL's driver makes PATH.part of that.
 */
#include "dem_vertical.h"

#include <errno.h>
#include <stdio.h>
#include <unistd.h>

struct gdal_sink {
	struct dem_sink sink;
	const struct dem_raster *raster;
	GDALDatasetH dataset; /* of the rows */
	char *rows;           /* its path */
	const char *part;
	double *band;         /* rows of a band of tiles, the northern one first */
	int side;             /* rows of a band; the southernmost one may have fewer */
};

#define BAND_BYTES (48 << 20) /* most bytes of a band, unless one of SIDE_LEAST rows has more */
#define SIDE_LEAST 16
#define SIDE_MOST 256

/* Returns what GDAL said of its last error, without the name of the function that said it ("_tiffWriteProc:No space left on device"). */
static const char *because(void)
{
	const char *said = dem_gdal_because() + 2; /* behind ": " */
	const char *rest = said + strspn(said, "_ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz");
	return *rest == ':' && rest > said && rest[1] != '\0' ? rest + 1 : said;
}

static enum status refuse(const struct dem_raster *raster)
{
	if (CPLGetLastErrorMsg()[0] == '\0')
		return fail_with(STATUS_FAILED, "%s: cannot be written; free some disk space", raster->path);
	return fail_with(STATUS_FAILED, "%s: cannot be written: %s; free some disk space", raster->path, because());
}

static enum status sink_row(struct dem_sink *sink, int64_t y, const double *values)
{
	struct gdal_sink *gdal = (struct gdal_sink *)sink;
	const int width = (int)gdal->raster->width, row = (int)(gdal->raster->height - 1 - y), first = row / gdal->side * gdal->side;
	double *to = gdal->band + (size_t)(row - first) * (size_t)width;
	for (int x = 0; x < width; x++)
		to[x] = dem_raster_value(gdal->raster, values[x]);
	if (row > first)
		return STATUS_OK;
	const int64_t left = gdal->raster->height - first;
	const int rows = left < gdal->side ? (int)left : gdal->side;
	CPLErrorReset();
	if (GDALRasterIO(GDALGetRasterBand(gdal->dataset, 1), GF_Write, 0, first, width, rows, gdal->band, width, rows, GDT_Float64, 0, 0) != CE_None)
		return refuse(gdal->raster);
	return STATUS_OK;
}

static enum status sink_finish(struct dem_sink *sink)
{
	struct gdal_sink *gdal = (struct gdal_sink *)sink;
	CPLErrorReset();
	GDALFlushCache(gdal->dataset);
	if (CPLGetLastErrorType() >= CE_Failure)
		return refuse(gdal->raster);
	/* Numbers that are exact are not mixed. */
	char **options = CSLSetNameValue(NULL, "BIGTIFF", "IF_SAFER");
	options = CSLSetNameValue(options, "COMPRESS", "DEFLATE");
	options = CSLSetNameValue(options, "PREDICTOR", "YES");
	options = CSLSetNameValue(options, "NUM_THREADS", "ALL_CPUS");
	options = CSLSetNameValue(options, "OVERVIEW_RESAMPLING", gdal->raster->type == DEM_INT32 ? "NEAREST" : "AVERAGE");
	GDALDriverH driver = GDALGetDriverByName("COG");
	GDALDatasetH made = driver != NULL ? GDALCreateCopy(driver, gdal->part, gdal->dataset, FALSE, options, NULL, NULL) : NULL;
	CSLDestroy(options);
	if (made == NULL)
		return refuse(gdal->raster);
	/* 3.6's closing returns nothing; what went wrong is the last error. */
	GDALClose(made);
	return CPLGetLastErrorType() >= CE_Failure ? refuse(gdal->raster) : STATUS_OK;
}

static void sink_destroy(struct dem_sink *sink)
{
	struct gdal_sink *gdal = (struct gdal_sink *)sink;
	if (gdal->dataset != NULL)
		GDALClose(gdal->dataset);
	if (gdal->rows != NULL)
		(void)unlink(gdal->rows);
	mem_free_all(gdal->band, gdal->rows, gdal);
}

/* Makes `srs` one with heights above raster->vertical, a name as dem_vertical_part tells it. A GeoTIFF says nothing of a projected
 * SRS with heights above its own ellipsoid. */
static void add_vertical(const struct dem_raster *raster, OGRSpatialReferenceH srs)
{
	PJ_CONTEXT *context = dem_vertical_context();
	struct dem_vertical vertical = {NULL, 0};
	bool added = false;
	if (context != NULL && dem_vertical_init(context, raster->vertical, &vertical) == STATUS_OK && vertical.crs != NULL && vertical.metres == 1) {
		OGRSpatialReferenceH heights = OSRNewSpatialReference(NULL), flat = OSRClone(srs);
		const char *wkt = dem_proj_calls.proj_as_wkt(context, vertical.crs, PJ_WKT2_2019, NULL);
		char both[400];
		snprintf(both, sizeof both, "%.190s + %.160s", flat != NULL && OSRGetName(flat) != NULL ? OSRGetName(flat) : "unnamed", raster->vertical);
		added = heights != NULL && flat != NULL && wkt != NULL && OSRSetFromUserInput(heights, wkt) == OGRERR_NONE &&
			OSRSetCompoundCS(srs, both, flat, heights) == OGRERR_NONE;
		OSRDestroySpatialReference(heights);
		OSRDestroySpatialReference(flat);
	}
	dem_vertical_finish(&vertical);
	if (context != NULL)
		dem_proj_calls.proj_context_destroy(context);
	if (!added)
		note("%s: its SRS cannot say that heights are metres above %s, only its metadata VERTICAL_REFERENCE does, which furrow import "
		     "reads; other programs must be told", raster->path, raster->vertical);
}

static enum status set_meaning(struct gdal_sink *gdal)
{
	const struct dem_raster *raster = gdal->raster;
	double s = raster->spacing;
	double place[6] = {raster->west - s / 2, s, 0, raster->south + ((double)raster->height - 0.5) * s, 0, -s};
	if (GDALSetGeoTransform(gdal->dataset, place) != CE_None)
		return refuse(raster);
	if (raster->has_nodata &&
	    GDALSetRasterNoDataValue(GDALGetRasterBand(gdal->dataset, 1), raster->nodata) != CE_None)
		return refuse(raster);
	const bool heights = raster->vertical != NULL && raster->vertical[0] != '\0';
	GDALRasterBandH band = GDALGetRasterBand(gdal->dataset, 1);
	if (raster->unit != NULL)
		(void)GDALSetRasterUnitType(band, raster->unit);
	if (raster->band != NULL)
		GDALSetDescription(band, raster->band);
	if (heights)
		(void)GDALSetMetadataItem(gdal->dataset, "VERTICAL_REFERENCE", raster->vertical, NULL);
	if (raster->srs[0] == '\0')
		return STATUS_OK;
	OGRSpatialReferenceH srs = dem_srs_parse(raster->srs);
	if (srs == NULL)
		return STATUS_INPUT;
	if (heights)
		add_vertical(raster, srs);
	CPLErr set = GDALSetSpatialRef(gdal->dataset, srs);
	OSRDestroySpatialReference(srs);
	return set == CE_None ? STATUS_OK : refuse(raster);
}

/* Makes the file of the rows, tiled as they are collected. */
static enum status create_rows(struct gdal_sink *gdal, GDALDataType type)
{
	const struct dem_raster *raster = gdal->raster;
	char side[16];
	FILE *made = dem_part_open(gdal->rows); /* GDAL would write where a link leads to */
	if (made == NULL)
		return fail_with(STATUS_FAILED, "%s: cannot be created: %s; check the folder and its permissions", raster->path, input_problem());
	fclose(made);
	snprintf(side, sizeof side, "%d", gdal->side);
	GDALDriverH driver = GDALGetDriverByName("GTiff");
	char **options = CSLSetNameValue(NULL, "BIGTIFF", "IF_SAFER");
	options = CSLSetNameValue(options, "TILED", "YES");
	options = CSLSetNameValue(options, "BLOCKXSIZE", "256");
	options = CSLSetNameValue(options, "BLOCKYSIZE", side);
	options = CSLSetNameValue(options, "COMPRESS", "DEFLATE");
	options = CSLSetNameValue(options, "ZLEVEL", "1");
	gdal->dataset = driver != NULL ? GDALCreate(driver, gdal->rows, (int)raster->width, (int)raster->height, 1, type, options) : NULL;
	CSLDestroy(options);
	if (gdal->dataset == NULL)
		return fail_with(STATUS_FAILED, "%s: cannot be created%s%s; check the folder and its permissions", raster->path, errno != 0 ? ": " : "",
				 errno != 0 ? strerror(errno) : dem_gdal_because());
	return STATUS_OK;
}

enum status dem_gdal_sink(const struct dem_raster *raster, const char *part, struct dem_sink **out)
{
	static const GDALDataType types[] = {[DEM_FLOAT32] = GDT_Float32, [DEM_FLOAT64] = GDT_Float64, [DEM_INT32] = GDT_Int32,
					     [DEM_UINT8] = GDT_Byte, [DEM_UINT16] = GDT_UInt16};
	TRY(dem_gdal_init(raster->path));
	struct gdal_sink *gdal = mem_calloc(1, sizeof *gdal);
	TRY_MEM(gdal, raster->path);
	gdal->sink = (struct dem_sink){sink_row, sink_finish, sink_destroy};
	gdal->raster = raster;
	gdal->part = part;
	const double line = (double)raster->width * sizeof *gdal->band;
	gdal->side = (int)fmax(SIDE_LEAST, fmin(SIDE_MOST, floor(BAND_BYTES / line / SIDE_LEAST) * SIDE_LEAST));
	const size_t room = strlen(part) + sizeof ".rows";
	gdal->band = mem_alloc((size_t)raster->width, (size_t)gdal->side * sizeof *gdal->band);
	gdal->rows = mem_alloc(room, 1);
	enum status status;
	TRY_OR(failed, gdal->band != NULL && gdal->rows != NULL ? STATUS_OK : fail_memory(raster->path));
	snprintf(gdal->rows, room, "%s.rows", part);
	FILE *made = dem_part_open(part); /* GDAL would write where a link leads to */
	if (made == NULL)
		TRY_OR(failed, fail_with(STATUS_FAILED, "%s: cannot be created: %s; check the folder and its permissions", raster->path,
					 input_problem()));
	fclose(made);
	TRY_OR(failed, create_rows(gdal, types[raster->type]));
	TRY_OR(failed, set_meaning(gdal));
	*out = &gdal->sink;
	return STATUS_OK;
failed:
	sink_destroy(&gdal->sink);
	return status;
}
