/*
 * A GeoTIFF in any SRS that lies over the terrain. Each post is transformed in a call of its own. GDAL may choose a transformation
 * by the area that all points of one call cover. But what a post gets must not depend on its neighbours.
 */
#include <math.h>

#include "dem_placed.h"
#include "dem_outside.h"

struct gdal_of_values {
	struct dem_placed raster;
	const struct dem_placed_params *params;
	GDALDatasetH dataset;
	GDALRasterBandH band;
	GDALRasterBandH mask; /* NULL: all pixels are valid */
	unsigned char *masked;
	enum dem_placed_kind kind;
	int64_t most;         /* pixels of a window */
	double scale, offset; /* of a pixel's stored value; classes are as they are stored */
	double pixels[6]; /* the geotransform's inverse */
	OGRCoordinateTransformationH move; /* NULL: none is needed */
	bool local;  /* its coordinates are metres from the store's south-west post */
	double turn; /* the raster's units in a full circle of longitude; 0: x has none */
};

static const char *const names[] = {
	[DEM_PLACED_CLASSES] = "a map of classes",
	[DEM_PLACED_NUMBERS] = "a raster of soil numbers",
};

static void gdal_destroy(struct dem_placed *raster)
{
	struct gdal_of_values *gdal = (struct gdal_of_values *)raster;
	if (gdal->move != NULL)
		OCTDestroyCoordinateTransformation(gdal->move);
	if (gdal->dataset != NULL)
		GDALClose(gdal->dataset);
	mem_free_all(gdal->masked, gdal);
}

static bool lies_in(const struct gdal_of_values *gdal, double x, double y, double pixel[2])
{
	const double *p = gdal->pixels;
	pixel[0] = p[0] + p[1] * x + p[2] * y;
	pixel[1] = p[3] + p[4] * x + p[5] * y;
	return pixel[0] >= 0 && pixel[0] <= (double)gdal->raster.width && pixel[1] >= 0 &&
	       pixel[1] <= (double)gdal->raster.height;
}

/* Longitudes may be counted from elsewhere: 190 in the raster is -170 here. */
static void place_pixel(const struct gdal_of_values *gdal, double *x, double *y)
{
	double plain[2], around[2];
	bool in = lies_in(gdal, *x, *y, plain);
	if (!in && gdal->turn > 0 &&
	    (lies_in(gdal, *x + gdal->turn, *y, around) || lies_in(gdal, *x - gdal->turn, *y, around))) {
		plain[0] = around[0];
		plain[1] = around[1];
	}
	*x = plain[0];
	*y = plain[1];
}

static void gdal_locate(struct dem_placed *raster, size_t count, double *x, double *y)
{
	const struct gdal_of_values *gdal = (const struct gdal_of_values *)raster;
	const struct dem_placed_params *params = gdal->params;
	for (size_t i = 0; i < count; i++) {
		x[i] = (gdal->local ? 0 : params->origin[0]) + x[i] * params->extent->spacing;
		y[i] = (gdal->local ? 0 : params->origin[1]) + y[i] * params->extent->spacing;
		if (gdal->move != NULL && !OCTTransform(gdal->move, 1, &x[i], &y[i], NULL))
			x[i] = y[i] = (double)NAN;
		else
			place_pixel(gdal, &x[i], &y[i]);
	}
}

static enum status gdal_window(struct dem_placed *raster, struct post_rect pixels, double *values)
{
	struct gdal_of_values *gdal = (struct gdal_of_values *)raster;
	int x = (int)pixels.x0, y = (int)pixels.y0, width = (int)(pixels.x1 - pixels.x0),
	    height = (int)(pixels.y1 - pixels.y0);
	CPLErrorReset();
	CPLErr problem =
		GDALRasterIO(gdal->band, GF_Read, x, y, width, height, values, width, height, GDT_Float64, 0, 0);
	if (problem == CE_None && gdal->mask != NULL)
		problem = GDALRasterIO(gdal->mask, GF_Read, x, y, width, height, gdal->masked, width, height, GDT_Byte,
				       0, 0);
	if (problem != CE_None)
		return fail_with(STATUS_INPUT, "%s: reading it failed at column %d, row %d%s; fetch or make that file "
				 "again", gdal->params->path, x, y, dem_gdal_because());
	for (int64_t i = 0; i < (int64_t)width * height; i++)
		values[i] = gdal->mask != NULL && gdal->masked[i] == 0 ? (double)NAN : values[i] * gdal->scale + gdal->offset;
	return STATUS_OK;
}

static enum status take_band(struct gdal_of_values *gdal)
{
	const char *path = gdal->params->path;
	int bands = GDALGetRasterCount(gdal->dataset);
	bool alone = bands == 1 || (bands == 2 && GDALGetRasterColorInterpretation(GDALGetRasterBand(gdal->dataset, 2)) ==
						  GCI_AlphaBand);
	if (!alone)
		return fail_with(STATUS_INPUT, "%s: has %d bands, and %s is one; take one out with gdal_translate -b", path, bands,
				 names[gdal->kind]);
	gdal->band = GDALGetRasterBand(gdal->dataset, 1);
	GDALDataType type = GDALGetRasterDataType(gdal->band);
	if (gdal->kind == DEM_PLACED_NUMBERS && GDALDataTypeIsComplex(type))
		return fail_with(STATUS_INPUT, "%s: holds %s, and numbers are real; make them so with gdal_translate -ot Float32", path,
				 GDALGetDataTypeName(type));
	if (gdal->kind == DEM_PLACED_CLASSES && (!GDALDataTypeIsInteger(type) || GDALDataTypeIsComplex(type)))
		return fail_with(STATUS_INPUT, "%s: holds %s, and classes are whole numbers from 0 to 255; make it "
				 "bytes with gdal_translate -ot Byte", path, GDALGetDataTypeName(type));
	gdal->raster.width = GDALGetRasterXSize(gdal->dataset);
	gdal->raster.height = GDALGetRasterYSize(gdal->dataset);
	gdal->scale = 1;
	if (gdal->kind == DEM_PLACED_NUMBERS) {
		int given;
		double scale = GDALGetRasterScale(gdal->band, &given);
		gdal->scale = given ? scale : 1;
		double offset = GDALGetRasterOffset(gdal->band, &given);
		gdal->offset = given ? offset : 0;
	}
	if ((GDALGetMaskFlags(gdal->band) & GMF_ALL_VALID) == 0) {
		gdal->mask = GDALGetMaskBand(gdal->band);
		gdal->masked = mem_alloc((size_t)gdal->most, 1);
		TRY_MEM(gdal->masked, path);
	}
	return STATUS_OK;
}

/* Makes the transform from the store's SRS to the raster's SRS, unless they are the same. */
static enum status take_way(struct gdal_of_values *gdal, OGRSpatialReferenceH srs)
{
	const struct dem_placed_params *params = gdal->params;
	if (params->srs[0] == '\0')
		return fail_with(STATUS_INPUT, "%s: lies on a planet, and the store is local metres; give one without "
				 "an SRS, in metres from the south-west post, or a PNG", params->path);
	TRY(dem_srs_check(params->path, srs));
	OGRSpatialReferenceH store = dem_srs_parse(params->srs);
	if (store == NULL)
		return STATUS_INPUT;
	enum status status = STATUS_OK;
	if (!OSRIsSame(store, srs)) {
		gdal->move = OCTNewCoordinateTransformation(store, srs);
		if (gdal->move == NULL)
			status = fail_with(STATUS_INPUT, "%s: no way from the store's SRS to its own%s; project it with "
					   "gdalwarp", params->path, dem_gdal_because());
	}
	double middle;
	gdal->turn = dem_srs_turn(srs, &middle);
	OSRDestroySpatialReference(store);
	return status;
}

/* Returns true if the store has this SRS, too. One on no planet has no other way to a store. */
static bool is_of_store(const struct dem_placed_params *params, OGRSpatialReferenceH srs)
{
	OGRSpatialReferenceH store = params->srs[0] != '\0' ? dem_srs_parse(params->srs) : NULL;
	const bool same = store != NULL && OSRIsSame(store, srs);
	if (store != NULL)
		OSRDestroySpatialReference(store);
	return same;
}

static enum status take_place(struct gdal_of_values *gdal)
{
	const char *path = gdal->params->path;
	double place[6];
	if (GDALGetGeoTransform(gdal->dataset, place) != CE_None)
		return fail_with(STATUS_INPUT, "%s: has no place; give it one with gdal_translate -a_ullr, or give a PNG, "
				 "a pixel a post", path);
	bool finite = true;
	for (int i = 0; i < 6; i++)
		finite = finite && isfinite(place[i]);
	if (!finite || !GDALInvGeoTransform(place, gdal->pixels))
		return fail_with(STATUS_INPUT, "%s: its geotransform has no area; give it a place with gdal_translate "
				 "-a_ullr", path);
	OGRSpatialReferenceH srs = GDALGetSpatialRef(gdal->dataset); /* with its axes as the geotransform's */
	/* X and Y are from the south-west post wherever no SRS says otherwise: those of a scene, of a command, and of a raster. */
	gdal->local = srs == NULL || (OSRIsLocal(srs) && !is_of_store(gdal->params, srs));
	return gdal->local || OSRIsLocal(srs) ? STATUS_OK : take_way(gdal, srs);
}

/* Refuses a file that has the ending of a format of polygons. It is not opened: a scene is a stranger's. */
static enum status refuse_vector(const char *path, enum dem_placed_kind kind)
{
	static const struct {
		const char *ending;
		bool degrees; /* always, or nearly so */
	} formats[] = {{".geojson", true}, {".json", true}, {".kml", true}, {".shp", false}, {".gpkg", false}, {".gml", false}, {".fgb", false}, {".dxf", false}};
	for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
		if (dem_path_ends(path, formats[i].ending))
			return fail_with(STATUS_INPUT, "%.120s: is a vector file, and %s is a raster; make it of the polygons: gdal_rasterize -a CLASS -ot Byte -tr %s "
						       "%.120s map.tif (CLASS: the attribute with the values; -tr: a pixel's size, %s)",
					 path, names[kind], formats[i].degrees ? "0.00005 0.00005" : "5 5", path,
					 formats[i].degrees ? "degrees" : "in the unit of its SRS");
	return STATUS_OK;
}

enum status dem_placed_gdal_open(const struct dem_placed_params *params, enum dem_placed_kind kind, int64_t most,
				 struct dem_placed **out)
{
	/* A scene is a stranger's: no format that names further files, or places on the net. */
	static const char *const drivers[] = {"GTiff", NULL};
	TRY(refuse_vector(params->path, kind));
	TRY(dem_gdal_init(params->path));
	TRY(dem_outside_check(params->path, NULL));
	struct gdal_of_values *gdal = mem_calloc(1, sizeof *gdal);
	TRY_MEM(gdal, params->path);
	gdal->params = params;
	gdal->kind = kind;
	gdal->most = most;
	gdal->raster.locate = gdal_locate;
	gdal->raster.window = gdal_window;
	gdal->raster.destroy = gdal_destroy;
	gdal->dataset = GDALOpenEx(params->path, GDAL_OF_RASTER | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR, drivers,
				   NULL, NULL);
	enum status status;
	if (gdal->dataset == NULL)
		TRY_OR(failed, fail_with(STATUS_INPUT, "%s: cannot be opened as %s%s; give a whole GeoTIFF or a grey PNG",
					 params->path, names[kind], dem_gdal_because()));
	TRY_OR(failed, dem_outside_opened(params->path, NULL, gdal->dataset));
	TRY_OR(failed, take_band(gdal));
	TRY_OR(failed, take_place(gdal));
	*out = &gdal->raster;
	return STATUS_OK;
failed:
	gdal_destroy(&gdal->raster);
	return status;
}
