/*
 * Makes square posts in metres from the joined sources.
 *
 * A grid that is in metres, square and upright, and whose scale is true to 0.1 %, is not changed. Any other grid is resampled by
 * GDAL's warper. Its kernels ignore posts that are NaN.
 *
 * With posts at most twice as far apart as the source's, a post is a sample of the interpolated surface. With a larger spacing
 * GDAL widens the kernel, so that a post is a mean. In a projected grid the posts lie at whole multiples of the spacing. In a grid
 * that is only resampled they start at the south-west post.
 */
#include "dem_gdal.h"

#include <stdio.h>
#include <stdlib.h>

#define SCALE_TOLERANCE 1e-3
#define SCALE_TOLD 5e-3
#define WARP_MEMORY (64.0 * 1024 * 1024)
#define APPROXIMATION 0.005 /* largest error of GDAL's approximate transformation, pixels of the source */
#define PIECE_PIXELS (16.0 * 1024 * 1024) /* source pixels below one piece of the target */
#define PIECES_MAX 1024     /* pieces of the target; see create() */
#define PROBES 33           /* points along each side of the source that are projected to find the target's extent */

struct warp_plan {
	OGRSpatialReferenceH from, to; /* the SRS of the source and of the target; NULL: none, or the source keeps its own */
	bool project, resample; /* the target has another SRS; its posts are computed by GDAL's warper */
	bool sample;      /* a post is a sample of the interpolated surface; otherwise it is a mean of source posts */
	double spacing;   /* metres between the target's posts */
	double step[2];   /* metres between the source's posts */
	double origin[2]; /* place of the target's south-west post, in its SRS */
	int64_t width, height; /* posts of the target */
};

static double round_to_3_digits(double v)
{
	char text[32];
	snprintf(text, sizeof text, "%.3g", v);
	return strtod(text, NULL);
}

static void post_at(const double place[6], double column, double row, double *x, double *y)
{
	*x = place[0] + (column + 0.5) * place[1] + (row + 0.5) * place[2];
	*y = place[3] + (column + 0.5) * place[4] + (row + 0.5) * place[5];
}

/* Measures the distance of posts along a row and a column, metres. *unfit: the source's SRS is not in true metres, so it must be
 * projected. */
static enum status measure(GDALDatasetH mosaic, const double place[6], OGRSpatialReferenceH srs,
			   const char *name, double step[2], bool *unfit)
{
	double dx = hypot(place[1], place[4]), dy = hypot(place[2], place[5]);
	step[0] = dx;
	step[1] = dy;
	*unfit = false;
	if (srs == NULL)
		return STATUS_OK;
	double x, y;
	post_at(place, (GDALGetRasterXSize(mosaic) - 1) / 2.0, (GDALGetRasterYSize(mosaic) - 1) / 2.0, &x, &y);
	step[0] = dem_srs_ground(srs, x, y, place[1], place[4]);
	step[1] = dem_srs_ground(srs, x, y, place[2], place[5]);
	if (!(step[0] > 0) || !(step[1] > 0))
		return fail_with(STATUS_INPUT, "%s: its middle at %.10g, %.10g is nowhere in its SRS: %s; name the "
				 "right one with --s-srs", name, x, y, dem_gdal_message());
	double unit = OSRIsGeographic(srs) ? 0 : OSRGetLinearUnits(srs, NULL);
	*unfit = fabs(unit - 1) > 1e-12 || fabs(step[0] / dx - 1) > SCALE_TOLERANCE ||
		 fabs(step[1] / dy - 1) > SCALE_TOLERANCE;
	if (!*unfit) {
		step[0] = dx;
		step[1] = dy;
	}
	return STATUS_OK;
}

/* Chooses the SRS of the target and puts it into plan->to, which the caller must destroy. plan->project: the target has another
 * SRS than the source. */
static enum status choose_srs(struct warp_plan *plan, const struct dem_params *params, GDALDatasetH mosaic,
			      const double place[6], const char *name, bool unfit)
{
	bool asked = params->t_srs != NULL && strcmp(params->t_srs, "auto") != 0;
	if (asked && plan->from == NULL)
		return fail_with(STATUS_INPUT, "%s: says no SRS to project from; name it with --s-srs", name);
	if (asked) {
		plan->to = dem_srs_parse(params->t_srs);
		if (plan->to == NULL)
			return STATUS_INPUT;
		if (!OSRIsProjected(plan->to) || fabs(OSRGetLinearUnits(plan->to, NULL) - 1) > 1e-12)
			return fail_with(STATUS_INPUT, "target SRS \"%.80s\": is not in metres, and a store is; choose "
					 "a metric projection or auto", params->t_srs);
		if (OSRIsCompound(plan->to))
			OSRStripVertical(plan->to);
	} else if (unfit) {
		double x, y;
		post_at(place, (GDALGetRasterXSize(mosaic) - 1) / 2.0, (GDALGetRasterYSize(mosaic) - 1) / 2.0, &x,
			&y);
		plan->to = dem_srs_metric(plan->from, x, y);
		if (plan->to == NULL)
			return fail_with(STATUS_INPUT, "%s: found no metric projection for it: %s; name one with "
					 "--t-srs", name, dem_gdal_message());
	}
	plan->project = plan->to != NULL && !OSRIsSame(plan->from, plan->to);
	return STATUS_OK;
}

/* Computes the posts of the target: as many as lie within the area of the source's posts. */
static enum status lay_out(struct warp_plan *plan, GDALDatasetH mosaic, const double place[6], const char *name)
{
	int columns = GDALGetRasterXSize(mosaic), rows = GDALGetRasterYSize(mosaic);
	double low[2] = {(double)INFINITY, (double)INFINITY}, high[2] = {-(double)INFINITY, -(double)INFINITY};
	OGRCoordinateTransformationH move = NULL;
	if (plan->project) {
		move = OCTNewCoordinateTransformation(plan->from, plan->to);
		if (move == NULL)
			return fail_with(STATUS_INPUT, "%s: no way to project it: %s; name another target with "
					 "--t-srs", name, dem_gdal_message());
	}
	for (int i = 0; i < PROBES * PROBES; i++) {
		double x, y;
		post_at(place, (columns - 1) * (double)(i % PROBES) / (PROBES - 1),
			(rows - 1) * (double)(i / PROBES) / (PROBES - 1), &x, &y);
		if (move != NULL && !OCTTransform(move, 1, &x, &y, NULL))
			continue;
		if (!isfinite(x) || !isfinite(y))
			continue;
		low[0] = fmin(low[0], x);
		low[1] = fmin(low[1], y);
		high[0] = fmax(high[0], x);
		high[1] = fmax(high[1], y);
	}
	if (move != NULL)
		OCTDestroyCoordinateTransformation(move);
	double s = plan->spacing, count[2];
	for (int i = 0; i < 2; i++) {
		plan->origin[i] = plan->project ? ceil(low[i] / s - 1e-6) * s : low[i];
		count[i] = floor((high[i] - plan->origin[i]) / s + 1e-6) + 1;
		if (!(count[i] >= 2) || count[i] > 2e9)
			return fail_with(STATUS_INPUT, "%s: projected with posts every %g m it is %.0f posts along a "
					 "side; choose another --spacing or --t-srs", name, s, count[i]);
	}
	plan->width = (int64_t)count[0];
	plan->height = (int64_t)count[1];
	return STATUS_OK;
}

static void *make_transformer(const struct warp_plan *plan, GDALDatasetH mosaic, const double target[6])
{
	char **options = CSLSetNameValue(NULL, "SRC_METHOD", "GEOTRANSFORM");
	if (plan->project) {
		char *from = dem_srs_wkt(plan->from), *to = dem_srs_wkt(plan->to);
		if (from != NULL && to != NULL) {
			options = CSLSetNameValue(options, "SRC_SRS", from);
			options = CSLSetNameValue(options, "DST_SRS", to);
		}
		bool whole = from != NULL && to != NULL;
		mem_free(from);
		mem_free(to);
		if (!whole) {
			CSLDestroy(options);
			return NULL;
		}
	}
	void *exact = GDALCreateGenImgProjTransformer2(mosaic, NULL, options);
	CSLDestroy(options);
	if (exact == NULL)
		return NULL;
	GDALSetGenImgProjTransformerDstGeoTransform(exact, target);
	void *close = GDALCreateApproxTransformer(GDALGenImgProjTransform, exact, APPROXIMATION);
	if (close == NULL) {
		GDALDestroyGenImgProjTransformer(exact);
		return NULL;
	}
	GDALApproxTransformerOwnsSubtransformer(close, TRUE);
	return close;
}

/* A rectangle of the target's posts, rows counted from the north. */
struct piece {
	int64_t x, y, width, height;
};

static enum status create_piece(const struct warp_plan *plan, const struct dem_params *params, GDALDatasetH mosaic,
				const char *name, struct piece piece, GDALDatasetH *out)
{
	static const GDALResampleAlg kernels[] = {
		[DEM_BILINEAR] = GRA_Bilinear, [DEM_CUBIC] = GRA_Cubic, [DEM_NEAR] = GRA_NearestNeighbour};
	double s = plan->spacing;
	double target[6] = {plan->origin[0] + ((double)piece.x - 0.5) * s, s, 0,
			    plan->origin[1] + ((double)(plan->height - piece.y) - 0.5) * s, 0, -s};
	CPLErrorReset();
	void *transformer = make_transformer(plan, mosaic, target);
	GDALWarpOptions *options = transformer != NULL ? GDALCreateWarpOptions() : NULL;
	if (options == NULL) {
		if (transformer != NULL)
			GDALDestroyApproxTransformer(transformer);
		return fail_with(STATUS_INPUT, "%s: cannot be projected: %s; name another target with --t-srs", name,
				 dem_gdal_message());
	}
	options->hSrcDS = mosaic;
	options->eResampleAlg = kernels[params->resample];
	options->eWorkingDataType = GDALGetRasterDataType(GDALGetRasterBand(mosaic, 1));
	options->dfWarpMemoryLimit = WARP_MEMORY;
	options->pfnTransformer = GDALApproxTransform;
	options->pTransformerArg = transformer;
	GDALWarpInitDefaultBandMapping(options, 1);
	GDALWarpInitSrcNoDataReal(options, (double)NAN);
	GDALWarpInitDstNoDataReal(options, (double)NAN);
	options->papszWarpOptions = CSLSetNameValue(options->papszWarpOptions, "INIT_DEST", "NO_DATA");
	char threads[24];
	snprintf(threads, sizeof threads, "%lld", (long long)(params->jobs > 1 ? params->jobs : 1));
	options->papszWarpOptions = CSLSetNameValue(options->papszWarpOptions, "NUM_THREADS", threads);
	/* Set the width of the kernel. Otherwise GDAL computes it for each block, and blocks would differ. */
	static const char *const axes[] = {"XSCALE", "YSCALE"};
	for (int i = 0; i < 2; i++) {
		char text[32];
		snprintf(text, sizeof text, "%.17g", plan->sample ? 1 : plan->step[i] / s);
		options->papszWarpOptions = CSLSetNameValue(options->papszWarpOptions, axes[i], text);
	}
	*out = GDALCreateWarpedVRT(mosaic, (int)piece.width, (int)piece.height, target, options);
	GDALDestroyWarpOptions(options);
	if (*out == NULL) {
		GDALDestroyApproxTransformer(transformer);
		return fail_with(STATUS_INPUT, "%s: cannot be projected: %s; name another target with --t-srs", name,
				 dem_gdal_message());
	}
	return STATUS_OK;
}

/* GDAL warps blocks of 512 x 128 posts. For each block it reads all source pixels below it. If these are too many, the target is
 * made of pieces, which are then joined. A piece has about PIECE_PIXELS source pixels below it. It has more if there were more
 * than PIECES_MAX pieces. */
static enum status create(const struct warp_plan *plan, const struct dem_params *params, GDALDatasetH mosaic,
			  const char *name, GDALDatasetH *out)
{
	const double *step = plan->step;
	double under = plan->spacing * plan->spacing / (step[0] * step[1]); /* source pixels a post */
	double most = fmax(PIECE_PIXELS, under * (double)plan->width * (double)plan->height / PIECES_MAX);
	if (plan->sample || under * 512 * 128 <= most)
		return create_piece(plan, params, mosaic, name, (struct piece){0, 0, plan->width, plan->height}, out);
	int64_t side = (int64_t)fmax(1, sqrt(most / under));
	VRTDatasetH whole = VRTCreate((int)plan->width, (int)plan->height);
	GDALDataType type = GDALGetRasterDataType(GDALGetRasterBand(mosaic, 1));
	if (whole == NULL || GDALAddBand(whole, type, NULL) != CE_None) {
		if (whole != NULL)
			GDALClose(whole);
		return fail_memory(name);
	}
	VRTSourcedRasterBandH band = (VRTSourcedRasterBandH)GDALGetRasterBand(whole, 1);
	enum status status = STATUS_OK;
	for (int64_t y = 0; status == STATUS_OK && y < plan->height; y += side)
		for (int64_t x = 0; status == STATUS_OK && x < plan->width; x += side) {
			struct piece piece = {x, y, plan->width - x < side ? plan->width - x : side,
					      plan->height - y < side ? plan->height - y : side};
			int w = (int)piece.width, h = (int)piece.height;
			GDALDatasetH made;
			status = create_piece(plan, params, mosaic, name, piece, &made);
			if (status != STATUS_OK)
				break;
			CPLErr added = VRTAddSimpleSource(band, GDALGetRasterBand(made, 1), 0, 0, w, h, (int)x, (int)y, w, h,
							  NULL, VRT_NODATA_UNSET);
			GDALReleaseDataset(made); /* `whole` keeps its own reference */
			if (added != CE_None)
				status = fail_memory(name);
		}
	if (status != STATUS_OK) {
		GDALClose(whole);
		return status;
	}
	*out = whole;
	return STATUS_OK;
}

/* Prints a note if a metre of the target differs much from a metre on the ground. There, ruts and wheels have a wrong size. */
static void note_scale(const struct warp_plan *plan, const char *name)
{
	double worst = 0, s = plan->spacing;
	for (int i = 0; plan->to != NULL && i < 9; i++) {
		double x = plan->origin[0] + i % 3 * 0.5 * (double)(plan->width - 1) * s;
		double y = plan->origin[1] + i / 3 * 0.5 * (double)(plan->height - 1) * s;
		worst = fmax(worst, fabs(dem_srs_ground(plan->to, x, y, s, 0) / s - 1)); /* fmax ignores NaN */
		worst = fmax(worst, fabs(dem_srs_ground(plan->to, x, y, 0, s) / s - 1));
	}
	if (worst > SCALE_TOLD)
		note("%s: in its target SRS distances are up to %.2g %% off those on the ground; import less at once, or choose "
		     "a --t-srs that is true there", name, 100 * worst);
}

static enum status describe(const struct warp_plan *plan, struct dem_grid *grid)
{
	grid->width = plan->width;
	grid->height = plan->height;
	grid->spacing = plan->spacing;
	grid->origin[0] = plan->origin[0];
	grid->origin[1] = plan->origin[1];
	OGRSpatialReferenceH srs = plan->project ? plan->to : plan->from;
	if (srs != NULL && (grid->srs = dem_srs_wkt(srs)) == NULL)
		return fail_memory("the spatial reference system");
	if (plan->project) {
		const char *name = OSRGetName(plan->from);
		char text[256];
		snprintf(text, sizeof text, "%.150s, posts of about %.4g x %.4g m", name != NULL ? name : "unnamed",
			 plan->step[0], plan->step[1]);
		grid->projected = mem_strdup(text);
		if (grid->projected == NULL)
			return fail_memory("the spatial reference system");
	}
	return STATUS_OK;
}

enum status dem_warp(const struct dem_params *params, GDALDatasetH mosaic, const double place[6],
		     OGRSpatialReferenceH srs, const char *name, struct dem_grid *grid,
		     GDALDatasetH *warped)
{
	struct warp_plan plan = {.from = srs};
	double *step = plan.step;
	bool unfit;
	enum status status = measure(mosaic, place, srs, name, step, &unfit);
	if (status == STATUS_OK)
		status = choose_srs(&plan, params, mosaic, place, name, unfit);
	if (status != STATUS_OK)
		goto done;
	bool upright = place[2] == 0 && place[4] == 0 && place[1] > 0 && place[5] < 0;
	bool square = fabs(step[0] / step[1] - 1) < 1e-6;
	/* Posts that are not resampled keep their exact distance. For others it is rounded to 3 digits. */
	double own = square && !plan.project ? step[0] : round_to_3_digits(sqrt(step[0] * step[1]));
	plan.spacing = params->spacing > 0 ? params->spacing : own;
	plan.sample = plan.spacing <= 2 * fmin(step[0], step[1]);
	plan.resample = plan.project || !upright || !square || fabs(plan.spacing / own - 1) > 1e-6;
	if (!plan.resample) {
		plan.width = GDALGetRasterXSize(mosaic);
		plan.height = GDALGetRasterYSize(mosaic);
		post_at(place, 0, (double)(plan.height - 1), &plan.origin[0], &plan.origin[1]);
	} else {
		status = lay_out(&plan, mosaic, place, name);
		if (status == STATUS_OK)
			status = create(&plan, params, mosaic, name, warped);
		if (status == STATUS_OK)
			note_scale(&plan, name);
		if (status == STATUS_OK && params->spacing == 0)
			note("%s: posts of %.6g x %.6g m become square posts of %g m", name, step[0], step[1],
			     plan.spacing);
	}
	if (status == STATUS_OK)
		status = describe(&plan, grid);
done:
	if (plan.to != NULL)
		OSRDestroySpatialReference(plan.to);
	return status;
}
