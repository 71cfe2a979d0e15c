/*
 * Makes one grid of all sources that GDAL can read. It opens the sources, joins them, and projects them to metres if necessary.
 * The rest of dem reads the grid row by row.
 */
#include "dem_gdal.h"

#include <stdio.h>

struct gdal_grid {
	struct dem_grid grid;
	struct gdal_source *sources;
	size_t source_count;
	char *name; /* of the first source, for messages */
	GDALDatasetH mosaic;
	GDALDatasetH warped; /* the projected or resampled mosaic; NULL if the mosaic is used unchanged */
	/* reads the sources directly. Used instead of the mosaic if nothing is projected and all sources have the same lattice;
	 * otherwise NULL */
	struct dem_layers *layers;
};

static void gdal_destroy(struct dem_grid *grid)
{
	struct gdal_grid *gdal = (struct gdal_grid *)grid;
	dem_layers_destroy(gdal->layers);
	if (gdal->warped != NULL)
		GDALClose(gdal->warped);
	if (gdal->mosaic != NULL)
		GDALClose(gdal->mosaic);
	for (size_t i = 0; i < gdal->source_count; i++)
		dem_source_finish(&gdal->sources[i]);
	mem_free(gdal->sources);
	mem_free(gdal->name);
	mem_free(gdal);
}

/* Reads all of one source to find out if it can be read. */
static bool reads(const struct gdal_source *source)
{
	GDALDatasetH dataset = GDALOpen(source->vrt, GA_ReadOnly);
	float *row = mem_alloc((size_t)source->width, sizeof *row);
	bool good = dataset != NULL && row != NULL;
	for (int y = 0; good && y < source->height; y++)
		good = GDALRasterIO(GDALGetRasterBand(dataset, 1), GF_Read, 0, y, source->width, 1, row, source->width,
				    1, GDT_Float32, 0, 0) == CE_None;
	mem_free(row);
	if (dataset != NULL)
		GDALClose(dataset);
	return good;
}

/* Returns the source that GDAL's message is about: the one it names, or the first one that cannot be read. */
static const char *culprit(const struct gdal_grid *gdal, const char *message)
{
	const char *found = NULL;
	for (size_t i = 0; i < gdal->source_count; i++) {
		const char *path = gdal->sources[i].path;
		if (strstr(message, path) != NULL && (found == NULL || strlen(path) > strlen(found)))
			found = path;
	}
	for (size_t i = 0; found == NULL && i < gdal->source_count; i++)
		if (gdal->source_count == 1 || !reads(&gdal->sources[i]))
			found = gdal->sources[i].path;
	return found != NULL ? found : gdal->name;
}

static enum status refuse_rows(const struct gdal_grid *gdal, int top)
{
	char message[320];
	snprintf(message, sizeof message, "%s", dem_gdal_message());
	return fail_with(STATUS_INPUT, "%s: reading it failed at row %d of the whole: %s; fetch or make that file again",
			 culprit(gdal, message), top, message);
}

static enum status gdal_read(struct dem_grid *grid, struct post_rect rect, double *heights)
{
	struct gdal_grid *gdal = (struct gdal_grid *)grid;
	GDALDatasetH dataset = gdal->warped != NULL ? gdal->warped : gdal->mosaic;
	int width = (int)(rect.x1 - rect.x0), rows = (int)(rect.y1 - rect.y0), top = (int)(grid->height - rect.y1);
	GSpacing line = (GSpacing)width * (GSpacing)sizeof *heights;
	bool done;
	CPLErrorReset();
	if (gdal->layers != NULL) {
		struct post_rect from_north = {rect.x0, top, rect.x1, top + rows};
		enum status status = dem_layers_read(gdal->layers, from_north, heights, &done);
		return status != STATUS_OK || done ? status : refuse_rows(gdal, top);
	}
	/* Its rows come from the north: the last of ours first. */
	done = GDALRasterIOEx(GDALGetRasterBand(dataset, 1), GF_Read, (int)rect.x0, top, width, rows,
			      heights + (int64_t)(rows - 1) * width, width, rows, GDT_Float64, sizeof *heights, -line,
			      NULL) == CE_None;
	return done ? STATUS_OK : refuse_rows(gdal, top);
}

static enum status open_sources(struct gdal_grid *gdal, const struct dem_params *params,
				const struct dem_list *list)
{
	OGRSpatialReferenceH override = NULL;
	if (params->s_srs != NULL) {
		override = dem_srs_parse(params->s_srs);
		if (override == NULL)
			return STATUS_INPUT;
	}
	enum status status = STATUS_OK;
	for (size_t i = 0; status == STATUS_OK && i < list->count; i++) {
		gdal->source_count = i + 1;
		status = dem_source_init(&gdal->sources[i], params, list->paths[i], override, (int)i,
					 &gdal->grid.files);
	}
	if (override != NULL)
		OSRDestroySpatialReference(override);
	return status;
}

/* Returns the unit of heights for all sources, metres: the finest of their units. */
static double common_unit(const struct gdal_source *sources, size_t count)
{
	double unit = sources[0].unit;
	for (size_t i = 1; i < count; i++)
		unit = sources[i].unit < unit ? sources[i].unit : unit;
	return unit;
}

/* Returns true if heights stay whole numbers of `unit`: all sources have that unit, and none is resampled, since their posts coincide. */
static bool all_whole(const struct gdal_source *sources, size_t count, double unit)
{
	bool whole = dem_layers_fit(sources, count);
	for (size_t i = 0; i < count && whole; i++)
		whole = sources[i].whole && sources[i].unit == unit;
	return whole;
}

/* Returns the smallest panel of the sources. It is smaller if posts are projected, since then they need more source rows. */
static int64_t common_panel(const struct gdal_source *sources, size_t count, bool warped)
{
	int64_t panel = 0;
	for (size_t i = 0; i < count; i++)
		if (sources[i].panel_posts > 0 && (panel == 0 || sources[i].panel_posts < panel))
			panel = sources[i].panel_posts;
	return warped ? panel / 2 : panel;
}

enum status dem_gdal_open(const struct dem_params *params, const struct dem_list *list,
			  struct dem_grid **out)
{
	enum status status = dem_gdal_init(list->paths[0]);
	if (status != STATUS_OK)
		return status;
	struct gdal_grid *gdal = mem_calloc(1, sizeof *gdal);
	if (gdal == NULL)
		return fail_memory("opening the sources");
	gdal->grid.destroy = gdal_destroy;
	gdal->grid.read = gdal_read;
	gdal->sources = mem_calloc(list->count, sizeof *gdal->sources);
	gdal->name = mem_strdup(list->paths[0]);
	status = gdal->sources != NULL && gdal->name != NULL ? open_sources(gdal, params, list)
							     : fail_memory("opening the sources");
	if (status == STATUS_OK)
		status = dem_mosaic(gdal->sources, gdal->source_count, &gdal->grid, &gdal->mosaic);
	double place[6];
	if (status == STATUS_OK && GDALGetGeoTransform(gdal->mosaic, place) != CE_None)
		status = fail_with(STATUS_INPUT, "%s: its place got lost: %s; give it a geotransform", gdal->name,
				   dem_gdal_message());
	if (status == STATUS_OK)
		status = dem_warp(params, gdal->mosaic, place, gdal->sources[0].srs, gdal->name, &gdal->grid,
				  &gdal->warped);
	if (status == STATUS_OK) {
		gdal->grid.unit = common_unit(gdal->sources, gdal->source_count);
		gdal->grid.panel_posts = common_panel(gdal->sources, gdal->source_count, gdal->warped != NULL);
		gdal->grid.whole = gdal->warped == NULL && all_whole(gdal->sources, gdal->source_count, gdal->grid.unit);
		if (gdal->warped == NULL && gdal->source_count > 1 && dem_layers_fit(gdal->sources, gdal->source_count))
			status = dem_layers_create(gdal->sources, gdal->source_count, place, &gdal->layers);
	}
	if (status == STATUS_OK) {
		gdal->grid.vertical = mem_strdup(gdal->sources[0].vertical);
		if (gdal->grid.vertical == NULL)
			status = fail_memory("opening the sources");
	}
	if (status != STATUS_OK) {
		dem_grid_destroy(&gdal->grid);
		return status;
	}
	*out = &gdal->grid;
	return STATUS_OK;
}

bool dem_gdal_knows(const char *path)
{
	/* Without GDAL opening it will say so. */
	return dem_gdal_init(path) != STATUS_OK || GDALIdentifyDriverEx(path, GDAL_OF_RASTER, NULL, NULL) != NULL;
}

const char *dem_gdal_message(void)
{
	static _Thread_local char text[320];
	snprintf(text, sizeof text, "%s", CPLGetLastErrorMsg());
	size_t length = strlen(text);
	while (length > 0 && strchr(". \n", text[length - 1]) != NULL)
		text[--length] = '\0';
	return length > 0 ? text : "no reason given";
}

/* The pixel function of a source's vrt: values to metres. The meaning comes as text: scale, offset,
 * whether single, how many nodata values, and these. A second source is a mask. */
static CPLErr pixels_to_metres(void **sources, int source_count, void *data, int width, int height,
			       GDALDataType from, GDALDataType to, int pixel_space, int line_space,
			       CSLConstList arguments)
{
	const char *text = CSLFetchNameValue(arguments, "meaning");
	if (text == NULL || from != GDT_Float64 || source_count < 1)
		return CE_Failure;
	char *end;
	struct dem_meaning meaning = {.scale = CPLStrtod(text, &end)};
	meaning.offset = CPLStrtod(end, &end);
	meaning.single = CPLStrtod(end, &end) != 0;
	meaning.nodata_count = (size_t)CPLStrtod(end, &end);
	double *nodata = mem_alloc(meaning.nodata_count, sizeof *nodata);
	double *row = mem_alloc((size_t)width, sizeof *row);
	if (nodata == NULL || row == NULL) {
		mem_free(nodata);
		mem_free(row);
		CPLError(CE_Failure, CPLE_OutOfMemory, "out of memory");
		return CE_Failure;
	}
	for (size_t i = 0; i < meaning.nodata_count; i++)
		nodata[i] = CPLStrtod(end, &end);
	meaning.nodata = nodata;
	for (int y = 0; y < height; y++) {
		const double *values = (const double *)sources[0] + (size_t)y * (size_t)width;
		const double *mask = source_count > 1 ?
			(const double *)sources[1] + (size_t)y * (size_t)width : NULL;
		dem_metres(&meaning, values, width, row);
		for (int x = 0; mask != NULL && x < width; x++)
			row[x] = mask[x] == 0 ? (double)NAN : row[x];
		GDALCopyWords(row, GDT_Float64, sizeof *row, (char *)data + (ptrdiff_t)y * line_space, to,
			      pixel_space, width);
	}
	mem_free(nodata);
	mem_free(row);
	return CE_None;
}

void dem_gdal_register(void)
{
	GDALAllRegister();
	GDALSetCacheMax64(DEM_CACHE_BYTES);
	GDALAddDerivedBandPixelFuncWithArgs("furrow_metres", pixels_to_metres, NULL);
}
