/*
 * Finds out if the values of a source are radii, distances from the middle of the body. Many products of the Moon and Mars are.
 *
 * No label says so in a way that GDAL passes on. But no height is as large as the body. So values are radii if most of a sample
 * are near the radius of the SRS's sphere. A source that says no unit may have metres or kilometres.
 */
#include "dem_gdal.h"

/* How far a radius is from that of the sphere, as a share of it. Small bodies are far from round; the highest mountains of large ones reach 1.2 %. A wider range
 * would take kilometres for what are heights of 1,500 to 2,000 m on the Moon. */
#define NEAR_SMALL 0.2
#define NEAR_LARGE 0.03
#define LARGE 1e6 /* metres */
#define SAMPLED 64 /* values along each side of the raster */

/* What a sample says if a value is so many metres. */
struct guess {
	double factor, low, high; /* metres; of those values that are near the sphere */
	size_t near;
};

static void guess_add(struct guess *guess, double value, double sphere)
{
	const double radius = value * guess->factor;
	if (!(fabs(radius / sphere - 1) < (sphere < LARGE ? NEAR_SMALL : NEAR_LARGE)))
		return;
	guess->near++;
	guess->low = fmin(guess->low, radius);
	guess->high = fmax(guess->high, radius);
}

/* Adds a sample of the source to both guesses. *values: how many values it has. */
static enum status sample(const struct gdal_source *source, double sphere, struct guess guesses[2], size_t *values)
{
	const int width = source->width < SAMPLED ? source->width : SAMPLED, height = source->height < SAMPLED ? source->height : SAMPLED;
	double *taken = mem_alloc((size_t)width * (size_t)height, sizeof *taken);
	TRY_MEM(taken, source->path);
	CPLErrorReset();
	GDALDatasetH dataset = GDALOpen(source->vrt, GA_ReadOnly);
	bool done = dataset != NULL && GDALRasterIO(GDALGetRasterBand(dataset, 1), GF_Read, 0, 0, source->width, source->height, taken, width,
						    height, GDT_Float64, 0, 0) == CE_None;
	enum status status = done ? STATUS_OK : fail_with(STATUS_INPUT, "%s: reading it failed%s; fetch or make that file again",
							  source->path, dem_gdal_because());
	for (int i = 0; done && i < width * height; i++) {
		*values += !isnan(taken[i]);
		guess_add(&guesses[0], taken[i], sphere);
		guess_add(&guesses[1], taken[i], sphere);
	}
	if (dataset != NULL)
		GDALClose(dataset);
	mem_free(taken);
	return status;
}

enum status dem_radii_find(const struct gdal_source *source, enum dem_radii radii, double unit, bool said, struct dem_radius *out)
{
	*out = (struct dem_radius){0, unit};
	if (radii == DEM_RADII_NO)
		return STATUS_OK;
	OGRErr problem = OGRERR_NONE;
	const double axis = source->srs != NULL ? OSRGetSemiMajor(source->srs, &problem) : 0;
	const double flat = source->srs != NULL ? OSRGetInvFlattening(source->srs, NULL) : 0;
	const bool body = axis > 0 && problem == OGRERR_NONE;
	if (radii == DEM_RADII_AUTO && (!body || (axis > 6.35e6 && axis < 6.4e6))) /* on the Earth nobody does so */
		return STATUS_OK;
	if (!body)
		return fail_with(STATUS_INPUT, "%s: says no SRS, so there is no sphere over which its radii are heights; name it with --s-srs",
				 source->path);
	struct guess guesses[2] = {{1, (double)INFINITY, 0, 0}, {1000, (double)INFINITY, 0, 0}};
	size_t values = 0;
	TRY(sample(source, axis, guesses, &values));
	const struct guess *found = said || guesses[0].near > guesses[1].near ? &guesses[0] : &guesses[1];
	const bool most = 2 * found->near > values;
	if (!most && radii == DEM_RADII_AUTO)
		return STATUS_OK;
	if (!most)
		return fail_with(STATUS_INPUT, "%s: its values are not radii near the %.10g m of its SRS; leave --radii yes out, or name the right "
				 "SRS with --s-srs", source->path, axis);
	if (flat != 0)
		return fail_with(STATUS_INPUT, "%s: its values are radii, and its SRS has an ellipsoid; name one with a sphere with --s-srs, "
				 "as IAU_2015:49900 for Mars, or take them as heights with --radii no", source->path);
	out->sphere = axis;
	out->unit = found->factor * unit;
	note("%s: its values are radii, from about %.10g to %.10g m; taken as heights over the sphere of %.10g m (--radii no takes them as they "
	     "are)", source->path, found->low, found->high, axis);
	return STATUS_OK;
}
