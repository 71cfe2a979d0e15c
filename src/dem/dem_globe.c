/* Converts between an SRS and longitude and latitude, both ways, many points at a time. */
#include "dem_gdal.h"

#include <stdio.h>

struct dem_globe {
	struct dem_globe_info info;
	OGRCoordinateTransformationH to, from; /* degrees */
};

static enum status fill(struct dem_globe *globe, OGRSpatialReferenceH srs)
{
	OGRErr problem = OGRERR_NONE;
	OSRStripVertical(srs); /* heights stay as they are */
	double a = OSRGetSemiMajor(srs, &problem), inverse = OSRGetInvFlattening(srs, NULL);
	globe->info.earth = a > 6.35e6 && a < 6.4e6;
	OGRSpatialReferenceH degrees = problem == OGRERR_NONE ? dem_srs_degrees(srs) : NULL;
	if (degrees != NULL) {
		globe->to = OCTNewCoordinateTransformation(srs, degrees);
		globe->from = OCTNewCoordinateTransformation(degrees, srs);
		globe->info.semi_major = OSRGetSemiMajor(degrees, NULL);
		inverse = OSRGetInvFlattening(degrees, NULL);
		globe->info.flattening = inverse != 0 ? 1 / inverse : 0;
		const char *name = OSRGetName(degrees);
		snprintf(globe->info.name, sizeof globe->info.name, "%s", name != NULL ? name : "");
		OSRDestroySpatialReference(degrees);
	}
	if (globe->to == NULL || globe->from == NULL)
		return fail_with(STATUS_INPUT, "the store's SRS: has no way to longitude and latitude%s; import with another --t-srs",
				 dem_gdal_because());
	return STATUS_OK;
}

enum status dem_globe_create(const char *wkt, struct dem_globe **out)
{
	*out = NULL;
	TRY(dem_gdal_init("degrees of a store with an SRS"));
	OGRSpatialReferenceH srs = dem_srs_parse(wkt);
	if (srs == NULL)
		return STATUS_INPUT;
	if (OSRIsLocal(srs)) {
		OSRDestroySpatialReference(srs);
		return STATUS_OK;
	}
	struct dem_globe *globe = mem_calloc(1, sizeof *globe);
	const enum status status = globe != NULL ? fill(globe, srs) : fail_memory("an SRS");
	OSRDestroySpatialReference(srs);
	if (status != STATUS_OK) {
		dem_globe_destroy(globe);
		return status;
	}
	*out = globe;
	return STATUS_OK;
}

void dem_globe_destroy(struct dem_globe *globe)
{
	if (globe == NULL)
		return;
	if (globe->to != NULL)
		OCTDestroyCoordinateTransformation(globe->to);
	if (globe->from != NULL)
		OCTDestroyCoordinateTransformation(globe->from);
	mem_free(globe);
}

const struct dem_globe_info *dem_globe_info(const struct dem_globe *globe)
{
	return &globe->info;
}

static void convert(OGRCoordinateTransformationH move, size_t count, double *x, double *y)
{
	dem_quiet_begin();
	(void)OCTTransform(move, (int)count, x, y, NULL); /* where it fails, a point is infinite */
	dem_quiet_end();
	for (size_t i = 0; i < count; i++)
		if (!isfinite(x[i]) || !isfinite(y[i]))
			x[i] = y[i] = (double)NAN;
}

void dem_globe_to_degrees(struct dem_globe *globe, size_t count, double *x, double *y)
{
	convert(globe->to, count, x, y);
}

void dem_globe_from_degrees(struct dem_globe *globe, size_t count, double *x, double *y)
{
	convert(globe->from, count, x, y);
}
