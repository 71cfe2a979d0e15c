/*
 * Imagery: pictures that lie over a terrain, brought to its lattice by GDAL's warper.
 *
 *   source -> four bands, in GDAL's memory (no pixel is read) -> warped into a raster in memory whose pixels are posts -> pixels
 *
 * Invariants:
 *   1. A raster in memory has a pixel for each post that is asked for, and its pixel's centre is the post. So what a post gets does not depend on
 *      the rectangle, but for GDAL's approximation of a projection, which is at most an eighth of a pixel off.
 *   2. Sources are warped in reverse order, each over those before it. So the first named wins.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "dem_outside.h"

#define CACHE_BYTES (256 << 20) /* GDAL's, while imagery is open: a row of a source's blocks is used by several calls */
#define EDGE 32                 /* places along a side of a source that are looked at to find its area */
#define AVERAGED 0.75           /* a source with pixels below this share of the target's is averaged */
#define MEASURED 4              /* of them, every so many are looked at to find a pixel's size */
#define OPEN_MOST 200           /* sources that stay open from one call to the next: each is a file */
#define WARP_MB "64"

struct picture {
	const char *path;
	double low[2], high[2]; /* m from the store's south-west post */
	double pixel;           /* m: where it lies on the terrain */
	bool local;             /* its coordinates are metres from there */
	GDALDatasetH source, bands; /* NULL: closed */
};

struct dem_imagery {
	struct dem_imagery_params params;
	char *srs, *vrt_folder;
	struct dem_list list;
	struct picture *pictures;
	OGRSpatialReferenceH target; /* NULL: local metres */
	size_t open;                 /* pictures */
	struct dem_imagery_info info;
};

/* --- one source --- */

/* The bands of red, green, blue and opacity, 1 and up; opacity 0: none. */
struct channels {
	int bands[4];
	bool palette;
};

static enum status find_channels(const struct picture *picture, GDALDatasetH source, struct channels *out)
{
	static const GDALColorInterp colours[4] = {GCI_RedBand, GCI_GreenBand, GCI_BlueBand, GCI_AlphaBand};
	const int count = GDALGetRasterCount(source);
	int found[4] = {0};
	*out = (struct channels){.palette = false};
	for (int band = count; band >= 1; band--) {
		const GDALRasterBandH one = GDALGetRasterBand(source, band);
		for (int c = 0; c < 4; c++)
			found[c] = GDALGetRasterColorInterpretation(one) == colours[c] ? band : found[c];
		if (GDALGetRasterDataType(one) != GDT_Byte && band <= 3)
			return fail_with(STATUS_INPUT, "%s: band %d is %s, and imagery has 8 bits a band; convert it: gdal_translate -ot Byte -scale LOW HIGH %s out.tif",
					 picture->path, band, GDALGetDataTypeName(GDALGetRasterDataType(one)), picture->path);
	}
	const GDALColorInterp first = GDALGetRasterColorInterpretation(GDALGetRasterBand(source, 1));
	if (first >= GCI_HueBand && first <= GCI_YCbCr_CrBand)
		return fail_with(STATUS_INPUT, "%s: its bands are not red, green and blue, but of another model, as cyan or hue; convert it to an RGB picture first", picture->path);
	const bool grey = count - (found[3] != 0) < 3;
	for (int c = 0; c < 3; c++)
		out->bands[c] = grey ? 1 : found[0] != 0 && found[1] != 0 && found[2] != 0 ? found[c] : c + 1;
	out->bands[3] = found[3];
	out->palette = GDALGetRasterColorTable(GDALGetRasterBand(source, 1)) != NULL;
	return STATUS_OK;
}

/* Gives a virtual raster of three or four bands of the source. */
static enum status take_bands(struct picture *picture)
{
	struct channels channels;
	char numbers[4][16];
	char *words[24] = {(char *)(uintptr_t)"-of", (char *)(uintptr_t)"VRT"};
	int count = 2;
	TRY(find_channels(picture, picture->source, &channels));
	if (channels.palette) {
		words[count++] = (char *)(uintptr_t)"-expand";
		words[count++] = (char *)(uintptr_t)"rgba";
	}
	for (int c = 0; c < 4 && !channels.palette && channels.bands[c] != 0; c++) {
		snprintf(numbers[c], sizeof numbers[c], "%d", channels.bands[c]);
		words[count++] = (char *)(uintptr_t)"-b";
		words[count++] = numbers[c];
	}
	if (!channels.palette) {
		words[count++] = (char *)(uintptr_t)"-colorinterp";
		words[count++] = (char *)(uintptr_t)(channels.bands[3] != 0 ? "red,green,blue,alpha" : "red,green,blue");
	}
	GDALTranslateOptions *options = GDALTranslateOptionsNew(words, NULL);
	CPLErrorReset();
	picture->bands = options != NULL ? GDALTranslate("", picture->source, options, NULL) : NULL;
	GDALTranslateOptionsFree(options);
	if (picture->bands == NULL)
		return fail_with(STATUS_INPUT, "%s: its colours cannot be read%s; convert it to a GeoTIFF of red, green and blue with gdal_translate", picture->path,
				 dem_gdal_because());
	return STATUS_OK;
}

static void close_picture(struct dem_imagery *imagery, struct picture *picture)
{
	imagery->open -= picture->source != NULL;
	if (picture->bands != NULL)
		GDALClose(picture->bands);
	if (picture->source != NULL)
		GDALClose(picture->source);
	picture->bands = picture->source = NULL;
}

static enum status open_picture(struct dem_imagery *imagery, struct picture *picture)
{
	if (picture->bands != NULL)
		return STATUS_OK;
	TRY(dem_outside_check(picture->path, imagery->vrt_folder));
	CPLErrorReset();
	picture->source = GDALOpenEx(picture->path, GDAL_OF_RASTER | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR, dem_gdal_drivers(), NULL, NULL);
	if (picture->source == NULL)
		return fail_with(STATUS_INPUT, "%s: cannot be opened as a raster%s; give a whole raster that GDAL reads", picture->path, dem_gdal_because());
	imagery->open++;
	TRY(dem_outside_opened(picture->path, imagery->vrt_folder, picture->source));
	if (GDALGetRasterCount(picture->source) < 1)
		return fail_with(STATUS_INPUT, "%s: no raster band in it; name one of its subdatasets (gdalinfo lists them)", picture->path);
	return take_bands(picture);
}

/* --- where it lies --- */

struct placing {
	const struct dem_imagery *imagery;
	double place[6];
	OGRCoordinateTransformationH move; /* NULL: none is needed */
};

/* Gives where a place of the raster, in pixels from its corner, lies: metres from the store's south-west post. Returns false if nowhere. */
static bool locate(const struct placing *placing, const struct picture *picture, double column, double row, double at[2])
{
	const double *p = placing->place;
	at[0] = p[0] + p[1] * column + p[2] * row;
	at[1] = p[3] + p[4] * column + p[5] * row;
	if (placing->move != NULL && !OCTTransform(placing->move, 1, &at[0], &at[1], NULL))
		return false;
	for (int i = 0; i < 2; i++)
		at[i] -= picture->local ? 0 : placing->imagery->params.origin[i];
	return isfinite(at[0]) && isfinite(at[1]);
}

/* Takes the size of the pixel at this place, if it is smaller. At a pole of degrees a pixel has no width: then its height counts. */
static void measure(const struct placing *placing, struct picture *picture, double column, double row)
{
	double at[2], east[2], north[2];
	if (!locate(placing, picture, column, row, at) || !locate(placing, picture, column + 1, row, east) || !locate(placing, picture, column, row + 1, north))
		return;
	const double width = hypot(east[0] - at[0], east[1] - at[1]), height = hypot(north[0] - at[0], north[1] - at[1]);
	const double pixel = fmax(sqrt(width * height), fmax(width, height) / 2);
	if (pixel > 0 && !(picture->pixel <= pixel))
		picture->pixel = pixel;
}

/* Measures pixels of a source between whose grid places the terrain lies, at nine places of the terrain; `all`: also of those beside the source. */
static void measure_back(const struct placing *placing, struct picture *picture, const double far[2], bool all)
{
	const struct dem_imagery *imagery = placing->imagery;
	const double width = GDALGetRasterXSize(picture->source), height = GDALGetRasterYSize(picture->source);
	double place[6], inverse[6];
	memcpy(place, placing->place, sizeof place);
	OGRCoordinateTransformationH back = placing->move != NULL ? OCTNewCoordinateTransformation(imagery->target, GDALGetSpatialRef(picture->source)) : NULL;
	for (int i = 0; i < 9 && GDALInvGeoTransform(place, inverse) && (back != NULL || placing->move == NULL); i++) {
		double x = far[0] * (i % 3) / 2 + (picture->local ? 0 : imagery->params.origin[0]);
		double y = far[1] * (double)(i / 3) / 2 + (picture->local ? 0 : imagery->params.origin[1]);
		if (back != NULL && !OCTTransform(back, 1, &x, &y, NULL))
			continue;
		const double column = inverse[0] + inverse[1] * x + inverse[2] * y, row = inverse[3] + inverse[4] * x + inverse[5] * y;
		if (all || (column >= 0 && column <= width && row >= 0 && row <= height))
			measure(placing, picture, column, row);
	}
	if (back != NULL)
		OCTDestroyCoordinateTransformation(back);
}

/* Finds the size of a pixel on the terrain: the smallest of the places that are looked at. */
static void find_pixel(const struct placing *placing, struct picture *picture, const double far[2])
{
	const double width = GDALGetRasterXSize(picture->source), height = GDALGetRasterYSize(picture->source);
	double at[2];
	picture->pixel = (double)NAN;
	for (int i = 0; i <= EDGE; i += MEASURED)
		for (int j = 0; j <= EDGE; j += MEASURED) {
			const double column = width * i / EDGE, row = height * j / EDGE;
			if (locate(placing, picture, column, row, at) && at[0] >= 0 && at[1] >= 0 && at[0] <= far[0] && at[1] <= far[1])
				measure(placing, picture, column, row);
		}
	for (int all = 0; all < 2; all++)
		if (!(picture->pixel > 0))
			measure_back(placing, picture, far, all == 1);
	if (!(picture->pixel > 0))
		measure(placing, picture, width / 2, height / 2);
}

static void find_area(const struct placing *placing, struct picture *picture)
{
	const double width = GDALGetRasterXSize(picture->source), height = GDALGetRasterYSize(picture->source);
	double at[2];
	for (int i = 0; i < 2; i++) {
		picture->low[i] = (double)INFINITY;
		picture->high[i] = -(double)INFINITY;
	}
	for (int i = 0; i <= EDGE; i++)
		for (int j = 0; j <= EDGE; j++) {
			if (!locate(placing, picture, width * i / EDGE, height * j / EDGE, at))
				continue;
			for (int axis = 0; axis < 2; axis++) {
				picture->low[axis] = fmin(picture->low[axis], at[axis]);
				picture->high[axis] = fmax(picture->high[axis], at[axis]);
			}
		}
}

/* Finds the way from the source's coordinates to those of the store. */
static enum status find_way(const struct dem_imagery *imagery, struct picture *picture, struct placing *placing)
{
	OGRSpatialReferenceH srs = GDALGetSpatialRef(picture->source); /* with its axes as the geotransform's */
	picture->local = srs == NULL || imagery->target == NULL;
	if (srs == NULL)
		return STATUS_OK;
	if (imagery->target == NULL)
		return OSRIsLocal(srs) ? STATUS_OK
				       : fail_with(STATUS_INPUT, "%s: lies on a planet, and the store is local metres; give imagery without an SRS, in metres from the "
						   "south-west post", picture->path);
	TRY(dem_srs_check(picture->path, srs));
	if (OSRIsSame(imagery->target, srs))
		return STATUS_OK;
	placing->move = OCTNewCoordinateTransformation(srs, imagery->target);
	if (placing->move == NULL)
		return fail_with(STATUS_INPUT, "%s: no way from its SRS to the store's%s; project it with gdalwarp", picture->path, dem_gdal_because());
	return STATUS_OK;
}

static enum status place_picture(const struct dem_imagery *imagery, struct picture *picture)
{
	struct placing placing = {.imagery = imagery};
	if (GDALGetGeoTransform(picture->source, placing.place) != CE_None)
		return fail_with(STATUS_INPUT, "%s: has no place; give it one with gdal_translate -a_ullr and -a_srs", picture->path);
	TRY(find_way(imagery, picture, &placing));
	find_area(&placing, picture);
	find_pixel(&placing, picture, (double[2]){extent_side(imagery->params.extent, 0), extent_side(imagery->params.extent, 1)});
	if (placing.move != NULL)
		OCTDestroyCoordinateTransformation(placing.move);
	if (!(picture->pixel > 0) || !(picture->low[0] <= picture->high[0]))
		return fail_with(STATUS_INPUT, "%s: its place has no area on the terrain's map; look at it with gdalinfo", picture->path);
	return STATUS_OK;
}

/* --- all of them --- */

static bool touches(const struct picture *picture, const double low[2], const double high[2])
{
	bool touch = true;
	for (int i = 0; i < 2; i++)
		touch = touch && picture->high[i] >= low[i] - picture->pixel && picture->low[i] <= high[i] + picture->pixel;
	return touch;
}

static enum status open_all(struct dem_imagery *imagery)
{
	struct dem_imagery_info *info = &imagery->info;
	const double far[2] = {extent_side(imagery->params.extent, 0), extent_side(imagery->params.extent, 1)};
	bool any = false;
	for (size_t i = 0; i < imagery->list.count; i++) {
		struct picture *picture = &imagery->pictures[i];
		picture->path = imagery->list.paths[i];
		TRY(open_picture(imagery, picture));
		TRY(place_picture(imagery, picture));
		close_picture(imagery, picture);
		for (int axis = 0; axis < 2; axis++) {
			info->low[axis] = i == 0 ? picture->low[axis] : fmin(info->low[axis], picture->low[axis]);
			info->high[axis] = i == 0 ? picture->high[axis] : fmax(info->high[axis], picture->high[axis]);
		}
		if (!touches(picture, (double[2]){0, 0}, far)) {
			note("%s: it lies beside the terrain", picture->path);
			continue;
		}
		info->pixel = !any || picture->pixel < info->pixel ? picture->pixel : info->pixel;
		any = true;
	}
	if (!any)
		return fail_with(STATUS_INPUT, "%s: no imagery lies on the terrain: it is at %.0f, %.0f to %.0f, %.0f m from the south-west post; look at its SRS with "
				 "gdalinfo", imagery->list.paths[0], info->low[0], info->low[1], info->high[0], info->high[1]);
	return STATUS_OK;
}

enum status dem_imagery_open(const struct dem_imagery_params *params, struct dem_imagery **out)
{
	struct dem_imagery *imagery = mem_calloc(1, sizeof *imagery);
	TRY_MEM(imagery, "imagery");
	enum status status;
	imagery->params = *params;
	TRY_OR(failed, dem_gdal_init(params->sources[0]));
	GDALSetCacheMax64(CACHE_BYTES);
	TRY_OR(failed, mem_text(&imagery->srs, params->srs, "imagery"));
	if (params->vrt_folder != NULL)
		TRY_OR(failed, mem_text(&imagery->vrt_folder, params->vrt_folder, "imagery"));
	TRY_OR(failed, dem_list_init(&imagery->list, params->sources, params->count));
	imagery->params.sources = NULL;
	if (imagery->srs[0] != '\0') {
		imagery->target = dem_srs_parse(imagery->srs);
		if (imagery->target == NULL)
			TRY_OR(failed, STATUS_INPUT);
	}
	TRY_OR(failed, mem_zeroed(&imagery->pictures, imagery->list.count, sizeof *imagery->pictures, "imagery"));
	TRY_OR(failed, open_all(imagery));
	imagery->info.source_count = imagery->list.count;
	imagery->info.paths = (const char *const *)imagery->list.paths;
	*out = imagery;
	return STATUS_OK;
failed:
	dem_imagery_close(imagery);
	return status;
}

void dem_imagery_close(struct dem_imagery *imagery)
{
	if (imagery == NULL)
		return;
	for (size_t i = 0; imagery->pictures != NULL && i < imagery->list.count; i++)
		close_picture(imagery, &imagery->pictures[i]);
	if (imagery->target != NULL)
		OSRDestroySpatialReference(imagery->target);
	dem_list_finish(&imagery->list);
	mem_free_all(imagery->srs, imagery->vrt_folder, imagery->pictures, imagery);
	GDALSetCacheMax64(DEM_CACHE_BYTES);
}

const struct dem_imagery_info *dem_imagery_info(const struct dem_imagery *imagery)
{
	return &imagery->info;
}

/* --- pixels --- */

/* Makes an empty raster in memory whose pixels are the posts of `rect`. */
static enum status make_canvas(struct post_rect rect, GDALDatasetH *out)
{
	CPLErrorReset();
	*out = GDALCreate(GDALGetDriverByName("MEM"), "", (int)(rect.x1 - rect.x0), (int)(rect.y1 - rect.y0), 4, GDT_Byte, NULL);
	if (*out == NULL)
		return fail_memory("imagery");
	for (int band = 1; band <= 4; band++)
		GDALSetRasterColorInterpretation(GDALGetRasterBand(*out, band), (GDALColorInterp)(GCI_RedBand + band - 1));
	return STATUS_OK;
}

/* Gives the raster its place. local: the picture has no SRS, and its coordinates are metres from the store's south-west post. */
static void place_canvas(const struct dem_imagery *imagery, bool local, double spacing, struct post_rect rect, GDALDatasetH canvas)
{
	const double west = local ? 0 : imagery->params.origin[0], south = local ? 0 : imagery->params.origin[1];
	double place[6] = {west + ((double)rect.x0 - 0.5) * spacing, spacing, 0, south + ((double)rect.y1 - 0.5) * spacing, 0, -spacing};
	GDALSetGeoTransform(canvas, place);
	GDALSetSpatialRef(canvas, local ? NULL : imagery->target);
}

static enum status warp(const struct dem_imagery *imagery, const struct picture *picture, double spacing, GDALDatasetH canvas)
{
	char threads[32];
	snprintf(threads, sizeof threads, "NUM_THREADS=%lld", (long long)imagery->params.jobs);
	char *words[] = {(char *)(uintptr_t)"-r", (char *)(uintptr_t)(picture->pixel < AVERAGED * spacing ? "average" : "bilinear"), (char *)(uintptr_t)"-ovr",
			 (char *)(uintptr_t)"NONE", (char *)(uintptr_t)"-wm", (char *)(uintptr_t)WARP_MB, (char *)(uintptr_t)"-wo", threads, (char *)(uintptr_t)"-wo",
			 (char *)(uintptr_t)"UNIFIED_SRC_NODATA=YES", NULL}; /* a pixel is nodata if all its bands are */
	GDALWarpAppOptions *options = GDALWarpAppOptionsNew(words, NULL);
	GDALDatasetH source = picture->bands;
	int usage = 0;
	CPLErrorReset();
	const bool done = options != NULL && GDALWarp(NULL, canvas, 1, &source, options, &usage) != NULL;
	GDALWarpAppOptionsFree(options);
	if (!done || CPLGetLastErrorType() >= CE_Failure)
		return fail_with(STATUS_INPUT, "%s: reading it failed%s; fetch or make that file again", picture->path, dem_gdal_because());
	return STATUS_OK;
}

/* Takes the pixels, the south row first. A pixel that is not there has no colour. */
static enum status take_pixels(GDALDatasetH canvas, struct post_rect rect, uint8_t *pixels)
{
	const size_t width = (size_t)(rect.x1 - rect.x0), height = (size_t)(rect.y1 - rect.y0);
	for (int band = 0; band < 4; band++) {
		/* A negative step between rows: the raster's first row is the north one. */
		uint8_t *north = pixels + 4 * width * (height - 1) + band;
		if (GDALRasterIOEx(GDALGetRasterBand(canvas, band + 1), GF_Read, 0, 0, (int)width, (int)height, north, (int)width, (int)height, GDT_Byte, 4,
				   -(GSpacing)(4 * width), NULL) != CE_None)
			return fail_memory("imagery");
	}
	for (size_t i = 0; i < width * height; i++)
		if (pixels[4 * i + 3] == 0)
			memset(pixels + 4 * i, 0, 3);
	return STATUS_OK;
}

enum status dem_imagery_read(struct dem_imagery *imagery, int level, struct post_rect rect, uint8_t *pixels)
{
	const double spacing = extent_spacing(imagery->params.extent, level);
	const double low[2] = {(double)rect.x0 * spacing, (double)rect.y0 * spacing};
	const double high[2] = {(double)rect.x1 * spacing, (double)rect.y1 * spacing};
	GDALDatasetH canvas = NULL;
	enum status status;
	TRY_OR(done, make_canvas(rect, &canvas));
	for (size_t i = imagery->list.count; i-- > 0;) {
		struct picture *picture = &imagery->pictures[i];
		if (!touches(picture, low, high)) {
			close_picture(imagery, picture);
			continue;
		}
		TRY_OR(done, open_picture(imagery, picture));
		place_canvas(imagery, picture->local, spacing, rect, canvas);
		TRY_OR(done, warp(imagery, picture, spacing, canvas));
		if (imagery->open > OPEN_MOST)
			close_picture(imagery, picture);
	}
	TRY_OR(done, take_pixels(canvas, rect, pixels));
done:
	if (canvas != NULL)
		GDALClose(canvas);
	return status;
}
