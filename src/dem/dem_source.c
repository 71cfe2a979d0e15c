/*
 * Opens one source file with GDAL. Finds out what kind of raster it is and where it lies. Makes a VRT that gives its heights in
 * metres.
 */
#include "dem_outside.h"
#include "dem_vertical.h"

#include <stdatomic.h>
#include <stdio.h>

void dem_source_remark(struct gdal_source *source, enum source_remark which, const char *format, ...)
{
	char text[320];
	va_list args;
	va_start(args, format);
	vsnprintf(text, sizeof text, format, args);
	va_end(args);
	mem_free(source->remarks[which]);
	source->remarks[which] = mem_strdup(text);
}

/* GDAL's default is no place; north up, it is one: a corner at 0, 0 and a spacing of 1. */
static bool has_place(GDALDatasetH dataset, double place[6])
{
	if (GDALGetGeoTransform(dataset, place) != CE_None)
		return false;
	return place[0] != 0 || place[1] != 1 || place[2] != 0 || place[3] != 0 || place[4] != 0 ||
	       place[5] != 1;
}

static bool looks_like_degrees(const struct gdal_source *source)
{
	const double *p = source->place, x = p[0] + source->width * p[1], y = p[3] + source->height * p[5];
	return p[2] == 0 && p[4] == 0 && fabs(p[1]) <= 1 && fabs(p[5]) <= 1 && fabs(p[0]) <= 360 && fabs(x) <= 360 && fabs(p[3]) <= 90 &&
	       fabs(y) <= 90 && (fabs(p[0]) > 1 || fabs(p[3]) > 1);
}

#define THREADS_MOST 16 /* that decode blocks of a source */
#define COARSE_DEGREES 0.1 /* between posts: coarser ones are degrees only if the heights say so */
#define STEEP_MOST 50.0 /* no ground differs in height by more than so many times its width */

/* Refuses a place in degrees that would become a terrain much higher than wide. Drops the remark of one with coarse posts that is no higher than wide. */
static enum status judge_degrees(struct gdal_source *source)
{
	const double wide = source->width * fabs(source->place[1]), high = source->height * fabs(source->place[5]);
	double range[2] = {0, 0};
	GDALDatasetH dataset = GDALOpen(source->vrt, GA_ReadOnly);
	if (dataset != NULL) {
		GDALComputeRasterMinMax(GDALGetRasterBand(dataset, 1), TRUE, range);
		GDALClose(dataset);
	}
	const bool coarse = fmax(fabs(source->place[1]), fabs(source->place[5])) >= COARSE_DEGREES;
	if (coarse && !(range[1] - range[0] > fmax(wide, high))) { /* as likely metres */
		mem_free(source->remarks[SOURCE_DEGREES]);
		source->remarks[SOURCE_DEGREES] = NULL;
	}
	if (!(range[1] - range[0] > STEEP_MOST * fmax(wide, high)))
		return STATUS_OK;
	char system[80] = "no SRS is said";
	if (source->srs != NULL) {
		dem_srs_told(source->srs, system, sizeof system - sizeof " is in metres");
		strcat(system, " is in metres");
	}
	return fail_with(STATUS_INPUT, "%s: %s, and its place %.6g, %.6g with posts %.3g apart looks like degrees: as metres it is %.3g m wide and "
			 "its heights differ by %.4g m; give --s-srs EPSG:4326", source->path, system, source->place[0], source->place[3],
			 fabs(source->place[1]), wide, range[1] - range[0]);
}

/* Returns true if the file's metadata say that x is a longitude, as netCDF's and GMT's grids do. */
static bool says_degrees(GDALDatasetH dataset)
{
	CSLConstList items = GDALGetMetadata(dataset, NULL);
	bool found = false;
	for (; items != NULL && *items != NULL && !found; items++) {
		const char *value = strchr(*items, '=');
		found = value != NULL && strstr(*items, "#units=") != NULL &&
			(strcmp(value, "=degrees_east") == 0 || strcmp(value, "=degree_east") == 0 || strcmp(value, "=degrees_E") == 0 || strcmp(value, "=degreesE") == 0);
	}
	return found;
}

/* Takes a place as longitudes and latitudes of WGS 84. */
static enum status take_degrees(struct gdal_source *source)
{
	source->srs = OSRNewSpatialReference(NULL);
	TRY_MEM(source->srs, source->path);
	if (OSRImportFromEPSG(source->srs, 4326) != OGRERR_NONE)
		return fail_with(STATUS_INPUT, "%s: its units are degrees and it says no SRS%s; name it with --s-srs", source->path, dem_gdal_because());
	OSRSetAxisMappingStrategy(source->srs, OAMS_TRADITIONAL_GIS_ORDER);
	dem_source_remark(source, SOURCE_SYSTEM, "no SRS is said, and the unit of its x is degrees_east: taken as WGS 84; --s-srs names another");
	return STATUS_OK;
}

static enum status place_source(struct gdal_source *source, GDALDatasetH dataset,
				const struct dem_params *params, OGRSpatialReferenceH override)
{
	source->placed = has_place(dataset, source->place);
	if (!source->placed) {
		if (GDALGetGCPCount(dataset) > 0)
			return fail_with(STATUS_INPUT, "%s: placed by ground control points only; project it with "
					 "gdalwarp first", source->path);
		double spacing = params->spacing > 0 ? params->spacing : 1;
		double place[6] = {-spacing / 2, spacing, 0, (source->height - 0.5) * spacing, 0, -spacing};
		memcpy(source->place, place, sizeof place);
		return STATUS_OK;
	}
	double det = source->place[1] * source->place[5] - source->place[2] * source->place[4];
	for (int i = 0; i < 6; i++)
		if (!isfinite(source->place[i]))
			det = 0;
	if (det == 0)
		return fail_with(STATUS_INPUT, "%s: its geotransform is singular; give it a proper one with "
				 "gdal_translate -a_ullr", source->path);
	OGRSpatialReferenceH own = GDALGetSpatialRef(dataset);
	if (own != NULL && override != NULL && dem_srs_differ(own, override)) {
		dem_srs_told(own, source->replaced, sizeof source->replaced);
		dem_source_remark(source, SOURCE_SYSTEM, "the file says %s; --s-srs %.80s is used", source->replaced, params->s_srs);
	}
	own = override != NULL ? override : own;
	if (own == NULL && says_degrees(dataset))
		return take_degrees(source);
	if (own == NULL) {
		if (looks_like_degrees(source))
			dem_source_remark(source, SOURCE_DEGREES, "no SRS is said, and its place %.6g, %.6g with posts %.3g apart looks like degrees; taken as metres. "
			       "If they are degrees, give --s-srs EPSG:4326", source->place[0], source->place[3], fabs(source->place[1]));
		return STATUS_OK;
	}
	if (OSRIsGeocentric(own))
		return fail_with(STATUS_INPUT, "%s: geocentric coordinates are no map; project it first",
				 source->path);
	TRY(dem_srs_check(source->path, own));
	source->srs = OSRClone(own);
	TRY_MEM(source->srs, source->path);
	OSRSetAxisMappingStrategy(source->srs, OAMS_TRADITIONAL_GIS_ORDER);
	if (OSRIsLocal(source->srs)) {
		/* Metres of its own, on no planet. */
		double metres = OSRGetLinearUnits(source->srs, NULL);
		for (int i = 0; i < 6; i++)
			source->place[i] *= metres;
		OSRDestroySpatialReference(source->srs);
		source->srs = NULL;
	} else if (OSRIsProjected(source->srs) && looks_like_degrees(source)) {
		dem_source_remark(source, SOURCE_DEGREES, "its place %.6g, %.6g with posts %.3g apart looks like degrees; taken as the metres or feet of its SRS. "
			       "If they are degrees, give --s-srs EPSG:4326", source->place[0], source->place[3], fabs(source->place[1]));
	}
	return STATUS_OK;
}

/* Returns true if the file says that greater values are deeper. Its vertical axis may say so, a word of netCDF, or a standard name of the CF
 * conventions. A BAG holds elevations, whatever the axis in it says. */
static bool counts_down(GDALDatasetH dataset, GDALRasterBandH band, OGRAxisOrientation way)
{
	const char *positive = GDALGetMetadataItem(band, "positive", NULL), *name = GDALGetMetadataItem(band, "standard_name", NULL);
	const char *driver = GDALGetDriverShortName(GDALGetDatasetDriver(dataset));
	if (driver != NULL && strcmp(driver, "BAG") == 0)
		return false;
	if (positive != NULL)
		return strcmp(positive, "down") == 0;
	return way == OAO_Down || (name != NULL && (strcmp(name, "depth") == 0 || strncmp(name, "depth_below", 11) == 0 || strncmp(name, "sea_floor_depth", 15) == 0));
}

/* Gives the unit of values in metres: --s-unit, or that of the band, of the vertical reference, or else 1. *said: that is known. Takes the
 * vertical part off the SRS. */
static enum status vertical_unit(struct gdal_source *source, const struct dem_params *params, GDALDatasetH dataset, GDALRasterBandH band, double *metres, bool *said)
{
	const char *tag = GDALGetRasterUnitType(band), *unit = params->s_unit != NULL ? params->s_unit : tag;
	const bool tagged = tag != NULL && tag[0] != '\0', projected = source->srs != NULL && OSRIsProjected(source->srs);
	double axis = 0;
	OGRAxisOrientation way = OAO_Up;
	if (source->srs != NULL && OSRIsCompound(source->srs)) {
		axis = OSRGetTargetLinearUnits(source->srs, "COMPD_CS|VERT_CS", NULL);
		(void)OSRGetAxis(source->srs, "COMPD_CS|VERT_CS", 0, &way);
	}
	TRY(dem_vertical_part(source));
	const bool down = params->s_vertical == NULL && counts_down(dataset, band, way);
	if (params->s_vertical != NULL)
		TRY(dem_vertical_unit(params->s_vertical, &axis));
	*said = source->own != NULL || tagged || params->s_unit != NULL;
	*metres = unit != NULL && unit[0] != '\0' ? dem_unit_metres(unit) : axis > 0 ? axis : 1;
	if (down) {
		*metres = -*metres;
		dem_source_remark(source, SOURCE_DOWN, "its values count down%s%.80s: each height is the value times %g", source->vertical[0] != '\0' ? ", by " : "",
				  source->vertical, *metres);
	}
	if (!*said && params->s_vertical == NULL && projected && fabs(OSRGetLinearUnits(source->srs, NULL) - 0.3048) < 1e-5)
		dem_source_remark(source, SOURCE_UNIT, "its SRS is in feet and nothing says the unit of heights; they are taken as metres. Give --s-unit %s if they are feet",
		       OSRGetLinearUnits(source->srs, NULL) == 0.3048 ? "ft" : "us-ft");
	if (tagged && params->s_unit == NULL && !dem_unit_known(tag))
		dem_source_remark(source, SOURCE_UNIT, "the file says that its unit is %.40s, which is not known; its heights are taken as metres. --s-unit names another", tag);
	else if (tagged && params->s_unit != NULL && fabs(*metres) != dem_unit_metres(tag))
		dem_source_remark(source, SOURCE_UNIT, "the file says that its unit is %.40s; --s-unit %s is used", tag, unit);
	else if (tagged && params->s_unit == NULL && axis > 0 && fabs(axis / fabs(*metres) - 1) > 1e-9)
		dem_source_remark(source, SOURCE_UNIT, "the file says that its unit is %.40s; that is used, not the %.10g m of %.80s. --s-unit names another", tag, axis,
		       params->s_vertical != NULL ? params->s_vertical : source->vertical);
	return STATUS_OK;
}

static void describe_unit(struct gdal_source *source, double metres)
{
	const size_t length = strlen(source->vertical);
	if (metres != 1)
		snprintf(source->vertical + length, sizeof source->vertical - length, "%sconverted from units of %.10g m", length > 0 ? ", " : "", metres);
}

static bool fits_float(GDALDataType type)
{
	return type == GDT_Byte || type == GDT_UInt16 || type == GDT_Int16 || type == GDT_Float32;
}

/* Gives the nodata value of the band as it is stored. Returns false if there is none. */
static bool nodata_tag(GDALRasterBandH band, GDALDataType type, double *value)
{
	int has = 0;
	if (type == GDT_Int64)
		*value = (double)GDALGetRasterNoDataValueAsInt64(band, &has);
	else if (type == GDT_UInt64)
		*value = (double)GDALGetRasterNoDataValueAsUInt64(band, &has);
	else
		*value = GDALGetRasterNoDataValue(band, &has);
	return has != 0;
}

struct text {
	char *at, *end;
};

static void text_add(struct text *text, const char *format, ...) FURROW_PRINTF(2, 3);
static void text_add(struct text *text, const char *format, ...)
{
	va_list args;
	va_start(args, format);
	int length = vsnprintf(text->at, (size_t)(text->end - text->at), format, args);
	va_end(args);
	text->at = length < text->end - text->at ? text->at + length : text->end;
}

/* `band`: number of the one that is read; `mask`: its mask. */
static void text_add_source(struct text *text, const char *escaped, int number, bool mask,
			    const struct gdal_source *source, GDALRasterBandH handle)
{
	char band[32];
	snprintf(band, sizeof band, "%s%d", mask ? "mask," : "", number);
	int block_x, block_y;
	GDALGetBlockSize(handle, &block_x, &block_y);
	text_add(text, "<SimpleSource><SourceFilename relativeToVRT=\"0\" shared=\"0\">%s</SourceFilename>", escaped);
	if (source->threads > 1)
		text_add(text, "<OpenOptions><OOI key=\"NUM_THREADS\">%d</OOI></OpenOptions>", source->threads);
	text_add(text, "<SourceBand>%s</SourceBand><SourceProperties RasterXSize=\"%d\" RasterYSize=\"%d\" "
		 "DataType=\"%s\" BlockXSize=\"%d\" BlockYSize=\"%d\"/></SimpleSource>", band,
		 source->width, source->height, GDALGetDataTypeName(GDALGetRasterDataType(handle)), block_x,
		 block_y);
}

/* A row of a raster's blocks is decoded once only if GDAL's cache holds it until it has been read. */
static int64_t panel_of(GDALRasterBandH band)
{
	int block_x, block_y;
	GDALGetBlockSize(band, &block_x, &block_y);
	int64_t column = (int64_t)block_y * GDALGetDataTypeSizeBytes(GDALGetRasterDataType(band));
	bool tiled = block_x < GDALGetRasterBandXSize(band) && block_y > 1;
	return tiled ? DEM_CACHE_BYTES / 2 / column : 0;
}

static bool is_signed_byte(GDALRasterBandH band)
{
	const char *type = GDALGetMetadataItem(band, "PIXELTYPE", "IMAGE_STRUCTURE");
	return GDALGetRasterDataType(band) == GDT_Byte && type != NULL && strcmp(type, "SIGNEDBYTE") == 0;
}

/* Returns what full scale of a band is that a height range may describe; 0: the band says itself what it means. */
static double full_scale(GDALRasterBandH band)
{
	const GDALDataType type = GDALGetRasterDataType(band);
	int has_scale = 0, has_offset = 0;
	const double scale = GDALGetRasterScale(band, &has_scale), offset = GDALGetRasterOffset(band, &has_offset);
	if ((has_scale && scale != 1) || (has_offset && offset != 0) || is_signed_byte(band))
		return 0;
	return type == GDT_Byte ? 255 : type == GDT_UInt16 ? 65535 : 0;
}

/* Checks that a height range and the band agree. Tells of 8 bits without one. */
static enum status check_range(struct gdal_source *source, const struct dem_params *params, GDALRasterBandH band)
{
	const char *path = source->path;
	const double full = full_scale(band);
	if (source->colours && (params->has_height_range || params->s_unit != NULL))
		return fail_with(STATUS_USAGE, "encoding: %s has its heights in colours, in metres; leave %s out", path, params->has_height_range ? "--height-range" : "--s-unit");
	if (source->colours)
		return STATUS_OK;
	if (params->has_height_range && full == 0)
		return fail_with(STATUS_USAGE, "height range: %s is no heightmap of 8 or 16 bits without a sign, and says itself what it means; leave it out", path);
	if (params->has_height_range && params->s_unit != NULL)
		return fail_with(STATUS_USAGE, "unit %s: --height-range says what the values of %s mean in metres; leave one of them out", params->s_unit, path);
	if (!params->has_height_range && full == 255 && params->s_unit == NULL)
		dem_source_remark(source, SOURCE_UNIT, "its heights have 8 bits, and are taken as 0 to 255 of its unit; --height-range says what 0 and 255 mean");
	return STATUS_OK;
}

/* Returns the value of a pixel whose red, green and blue are `values`. */
static double coded(const double values[3])
{
	return 65536 * values[0] + 256 * values[1] + values[2];
}

/* Adds the values that mean nodata, as the pixel function gets them. Of coded colours --nodata is in metres; a tag counts if all three have it. */
static void text_add_nodata(struct text *text, const struct dem_params *params, GDALDatasetH dataset, GDALRasterBandH band, bool colours, double scale,
			    double offset)
{
	double tags[3] = {0, 0, 0};
	bool tagged = true;
	for (int i = 0; i < (colours ? 3 : 1); i++) {
		GDALRasterBandH one = colours ? GDALGetRasterBand(dataset, i + 1) : band;
		tagged = nodata_tag(one, GDALGetRasterDataType(one), &tags[i]) && !isnan(tags[i]) && tagged;
	}
	text_add(text, " %zu", params->nodata_count + (tagged ? 1 : 0));
	if (tagged)
		text_add(text, " %.17g", colours ? coded(tags) : tags[0]);
	for (size_t i = 0; i < params->nodata_count; i++)
		text_add(text, " %.17g", colours ? rint((params->nodata[i] - offset) / scale) : params->nodata[i]);
}

/* `unit`: metres of the source's; `lower`: metres that heights are lowered by. A vrt that was written before is replaced. */
static enum status write_vrt(struct gdal_source *source, const struct dem_params *params, GDALDatasetH dataset, double unit, double lower,
			     int number)
{
	const bool colours = source->colours;
	GDALRasterBandH band = GDALGetRasterBand(dataset, source->band);
	GDALDataType type = GDALGetRasterDataType(band);
	int has_scale = 0, has_offset = 0;
	double scale = GDALGetRasterScale(band, &has_scale), offset = GDALGetRasterOffset(band, &has_offset);
	scale = has_scale && isfinite(scale) && scale != 0 ? scale : 1;
	offset = has_offset && isfinite(offset) ? offset : 0;
	if (params->has_height_range) {
		unit = 1;
		scale = (params->height_max - params->height_min) / full_scale(band);
		offset = params->height_min;
	}
	if (colours) {
		const bool terrarium = params->encoding == DEM_TERRARIUM;
		unit = 1;
		scale = terrarium ? 1.0 / 256 : 0.1;
		offset = terrarium ? -32768 : -10000;
	}
	bool whole = type != GDT_Float32 && type != GDT_Float64;
	source->unit = whole ? fabs(scale * unit) : 0;
	source->whole = whole && dem_unit_exact(source->unit) && fmod(offset * unit - lower, source->unit) == 0;
	source->doubles = !fits_float(type) || (colours && params->encoding == DEM_MAPBOX);
	source->panel_posts = panel_of(band);

	char *escaped = CPLEscapeString(source->name, -1, CPLES_XML);
	size_t bytes = 4096 + 2 * strlen(escaped) + 32 * params->nodata_count;
	char *xml = mem_alloc(bytes, 1);
	if (source->vrt == NULL)
		source->vrt = mem_calloc(64, 1); /* a text even if the rest fails */
	if (xml == NULL || source->vrt == NULL) {
		mem_free(xml);
		CPLFree(escaped);
		return fail_memory(source->path);
	}
	const double *p = source->place;
	struct text text = {xml, xml + bytes};
	text_add(&text, "<VRTDataset rasterXSize=\"%d\" rasterYSize=\"%d\"><GeoTransform>%.17g, %.17g, %.17g, "
		 "%.17g, %.17g, %.17g</GeoTransform><VRTRasterBand dataType=\"%s\" band=\"1\" "
		 "subClass=\"VRTDerivedRasterBand\"><NoDataValue>nan</NoDataValue>"
		 "<PixelFunctionType>furrow_metres</PixelFunctionType><PixelFunctionArguments meaning=\""
		 "%.17g %.17g %d %d", source->width, source->height, p[0], p[1], p[2], p[3], p[4], p[5],
		 source->doubles ? "Float64" : "Float32", scale * unit, offset * unit - lower, !source->doubles,
		 colours ? DEM_STORED_COLOURS : is_signed_byte(band) ? DEM_STORED_SIGNED_BYTE : DEM_STORED_PLAIN);
	text_add_nodata(&text, params, dataset, band, colours, scale, offset);
	text_add(&text, "\"/><SourceTransferType>Float64</SourceTransferType>");
	for (int i = 0; i < (colours ? 3 : 1); i++)
		text_add_source(&text, escaped, source->band + i, false, source, GDALGetRasterBand(dataset, source->band + i));
	if ((GDALGetMaskFlags(band) & (GMF_ALL_VALID | GMF_NODATA)) == 0)
		text_add_source(&text, escaped, source->band, true, source, GDALGetMaskBand(band));
	text_add(&text, "</VRTRasterBand></VRTDataset>");
	CPLFree(escaped);

	static atomic_uint_least64_t made;
	if (source->vrt[0] == '\0')
		snprintf(source->vrt, 64, "/vsimem/furrow/%llu-%d.vrt", (unsigned long long)atomic_fetch_add(&made, 1),
			 number);
	VSILFILE *file = VSIFOpenL(source->vrt, "wb");
	size_t length = strlen(xml);
	bool written = file != NULL && VSIFWriteL(xml, 1, length, file) == length;
	if (file != NULL && VSIFCloseL(file) != 0)
		written = false;
	mem_free(xml);
	return written ? STATUS_OK : fail_memory(source->path);
}

static enum status add_files(GDALDatasetH dataset, const struct gdal_source *source, struct dem_list *files)
{
	if (source->name != source->path) /* what it was unpacked to is nobody's file */
		return STATUS_OK;
	char **names = GDALGetFileList(dataset);
	enum status status = STATUS_OK;
	for (char **name = names; name != NULL && *name != NULL; name++)
		if (strcmp(*name, source->path) != 0)
			TRY_OR(done, dem_list_add(files, *name));
done:
	CSLDestroy(names);
	return status;
}

/* Turns the place of a raster along the axes: it counts from the north and the west then, and its readers turn its posts. */
static void turn_around(struct gdal_source *source)
{
	double *p = source->place;
	source->from_east = p[2] == 0 && p[4] == 0 && p[1] < 0;
	source->from_south = p[2] == 0 && p[4] == 0 && p[5] > 0;
	if (source->from_east) {
		p[0] += source->width * p[1];
		p[1] = -p[1];
	}
	if (source->from_south) {
		p[3] += source->height * p[5];
		p[5] = -p[5];
	}
}

/* Finds out if a raster's colours code heights, which an inset of one band never does. STATUS_INPUT: they cannot. */
static enum status check_colours(struct gdal_source *source, GDALDatasetH dataset, const struct dem_params *params)
{
	const int count = GDALGetRasterCount(dataset);
	const char *packed = GDALGetMetadataItem(dataset, "COMPRESSION", "IMAGE_STRUCTURE");
	if (params->encoding == DEM_PLAIN || (params->anchor != NULL && count == 1))
		return STATUS_OK;
	bool bytes = count >= 3;
	for (int i = 1; bytes && i <= 3; i++)
		bytes = GDALGetRasterDataType(GDALGetRasterBand(dataset, i)) == GDT_Byte;
	if (!bytes)
		return fail_with(STATUS_INPUT, "%s: has %d band%s, and no red, green and blue of 8 bits that code heights; leave --encoding out, or make colours of a "
				 "palette with gdal_translate -expand rgb", source->path, count, count == 1 ? "" : "s");
	if (packed != NULL && strstr(packed, "JPEG") != NULL)
		return fail_with(STATUS_INPUT, "%s: is packed with loss (%s), which spoils heights that are coded in colours; give a PNG or another lossless raster",
				 source->path, packed);
	source->colours = true;
	return STATUS_OK;
}

/* Returns the threads with which GDAL decodes blocks of a GeoTIFF that are read together. Only what is packed is worth it. */
static int decoding_threads(GDALDatasetH dataset, const struct dem_params *params)
{
	const char *packed = GDALGetMetadataItem(dataset, "COMPRESSION", "IMAGE_STRUCTURE"), *driver = GDALGetDriverShortName(GDALGetDatasetDriver(dataset));
	const bool shared = packed != NULL && driver != NULL && strcmp(driver, "GTiff") == 0;
	return shared && params->jobs > 1 ? (int)fmin((double)params->jobs, THREADS_MOST) : 1;
}

/* Chooses the band that has the heights. */
static enum status choose_band(struct gdal_source *source, GDALDatasetH dataset, const struct dem_params *params)
{
	const int count = GDALGetRasterCount(dataset);
	const char *path = source->path, *what = NULL;
	source->band = 1;
	TRY(check_colours(source, dataset, params));
	if (source->colours)
		return STATUS_OK;
	if (params->band > count && !(params->anchor != NULL && count == 1))
		return fail_with(STATUS_INPUT, "%s: has %d band%s; --band %lld is not there (gdalinfo lists them)", path, count, count == 1 ? "" : "s",
				 (long long)params->band);
	if (params->band > 0 && params->band <= count)
		source->band = (int)params->band;
	else if (count > 1)
		note("%s: has %d bands; its first is taken for heights, and --band names another", path, count);
	GDALRasterBandH band = GDALGetRasterBand(dataset, source->band);
	if (GDALDataTypeIsComplex(GDALGetRasterDataType(band)))
		what = "complex";
	else if (GDALGetRasterColorTable(band) != NULL)
		what = "a palette of colours";
	else if (count >= 3 && GDALGetRasterColorInterpretation(band) == GCI_RedBand)
		what = "the red of a picture";
	if (what == NULL)
		return STATUS_OK;
	return fail_with(STATUS_INPUT, "%s: its band %d is %s, not heights; give an elevation raster, another --band, or --encoding if the colours code heights", path,
			 source->band, what);
}

/* Reads what an open raster is and where it lies. */
static enum status take_dataset(struct gdal_source *source, GDALDatasetH dataset, const struct dem_params *params,
				OGRSpatialReferenceH override, int number, struct dem_list *files)
{
	const char *path = source->path;
	double unit;
	bool said;
	struct dem_radius radius;
	TRY(dem_outside_opened(source->name, params->vrt_folder, dataset));
	TRY(add_files(dataset, source, files));
	if (GDALGetRasterCount(dataset) < 1)
		return fail_with(STATUS_INPUT, "%s: no raster band in it; name one of its subdatasets "
				 "(gdalinfo lists them)", path);
	TRY(choose_band(source, dataset, params));
	source->threads = decoding_threads(dataset, params);
	source->width = GDALGetRasterXSize(dataset);
	source->height = GDALGetRasterYSize(dataset);
	GDALRasterBandH band = GDALGetRasterBand(dataset, source->band);
	TRY(check_range(source, params, band));
	TRY(place_source(source, dataset, params, override));
	TRY(vertical_unit(source, params, dataset, band, &unit, &said));
	const char *metadata = GDALGetMetadataItem(dataset, "VERTICAL_REFERENCE", NULL);
	if (metadata == NULL) /* DEMs of planets name their geoid or areoid so */
		metadata = GDALGetMetadataItem(dataset, "GEOID", NULL);
	if (source->own == NULL && metadata != NULL)
		TRY(dem_vertical_metadata(source, metadata));
	TRY(write_vrt(source, params, dataset, unit, 0, number));
	if (source->remarks[SOURCE_DEGREES] != NULL)
		TRY(judge_degrees(source));
	TRY(dem_radii_find(source, params->radii, unit, said, &radius));
	if (radius.sphere > 0) {
		mem_free(source->own);
		TRY(mem_text(&source->own, DEM_ELLIPSOID, path));
		snprintf(source->vertical, sizeof source->vertical, "sphere of %.10g m, from radii", radius.sphere);
		TRY(write_vrt(source, params, dataset, radius.unit, radius.sphere, number));
	}
	TRY(dem_vertical_plan(source, params));
	describe_unit(source, unit);
	turn_around(source);
	return STATUS_OK;
}

enum status dem_source_init(struct gdal_source *source, const struct dem_params *params, const char *path,
			    OGRSpatialReferenceH override, int number, struct dem_list *files)
{
	*source = (struct gdal_source){.path = path, .name = path, .unpacked = {.scratch = {.file = -1}}};
	if (dem_unpack_is_packed(path)) {
		TRY(dem_unpack_init(&source->unpacked, path));
		source->name = source->unpacked.name;
	}
	TRY(dem_outside_check(source->name, params->vrt_folder));
	CPLErrorReset();
	GDALDatasetH dataset = GDALOpenEx(source->name, GDAL_OF_RASTER | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR, dem_gdal_drivers(), NULL, NULL);
	if (dataset == NULL)
		return fail_with(STATUS_INPUT, "%s: cannot be opened as a raster%s; give a whole raster that "
				 "GDAL reads", path, dem_gdal_because());
	const enum status status = take_dataset(source, dataset, params, override, number, files);
	GDALClose(dataset);
	return status;
}

bool dem_source_is_placed(const struct dem_params *params, const char *path)
{
	double place[6];
	if (dem_unpack_is_packed(path) || dem_outside_check(path, params->vrt_folder) != STATUS_OK) /* dem_source_init tells */
		return true;
	GDALDatasetH dataset = GDALOpenEx(path, GDAL_OF_RASTER | GDAL_OF_READONLY, dem_gdal_drivers(), NULL, NULL);
	if (dataset == NULL)
		return true;
	bool placed = has_place(dataset, place) || GDALGetGCPCount(dataset) > 0;
	GDALClose(dataset);
	return placed;
}

void dem_source_finish(struct gdal_source *source)
{
	if (source->srs != NULL)
		OSRDestroySpatialReference(source->srs);
	if (source->vrt != NULL)
		VSIUnlink(source->vrt);
	for (int i = 0; i < SOURCE_REMARKS; i++)
		mem_free(source->remarks[i]);
	mem_free_all(source->vrt, source->own, source->from, source->to);
	dem_unpack_finish(&source->unpacked);
}
