/*
 * Handles spatial reference systems (SRS) for imports. Reads their names, chooses a metric one, measures distances on the ground,
 * and converts points between two of them.
 */
#include "dem_gdal.h"

#include <stdio.h>

#define SCALE_TOLERANCE 1e-3
#define SCALE_TOLD 5e-3
#define GIVEN_MOST (64 << 10) /* bytes of a file that holds the text of an SRS */

/* `more`: what else may be given, for the message. */
static OGRSpatialReferenceH parse(const char *text, const char *more)
{
	OGRSpatialReferenceH srs = OSRNewSpatialReference(NULL);
	text += strspn(text, " \t\r\n"); /* WKT of a file or a here-document often begins with a new line */
	CPLErrorReset();
	const char *problem = dem_srs_text_problem(text);
	if (problem != NULL) {
		if (srs != NULL)
			OSRDestroySpatialReference(srs);
		(void)fail_with(STATUS_INPUT, "SRS \"%.80s\": %s; give an EPSG code, WKT, PROJ or IAU name%s", text, problem, more);
		return NULL;
	}
	if (srs == NULL || OSRSetFromUserInput(srs, text) != OGRERR_NONE) {
		if (srs != NULL)
			OSRDestroySpatialReference(srs);
		(void)fail_with(STATUS_INPUT, "SRS \"%.80s\": not understood%s; give an EPSG code, WKT, PROJ or "
				"IAU name%s", text, dem_gdal_because(), more);
		return NULL;
	}
	OSRSetAxisMappingStrategy(srs, OAMS_TRADITIONAL_GIS_ORDER);
	return srs;
}

OGRSpatialReferenceH dem_srs_parse(const char *text)
{
	return parse(text, "");
}

OGRSpatialReferenceH dem_srs_parse_given(const char *text)
{
	char *held = input_is_file(text) ? mem_calloc(GIVEN_MOST + 1, 1) : NULL;
	FILE *file = held != NULL ? input_open(text) : NULL;
	if (file == NULL) {
		mem_free(held);
		return dem_srs_parse(text);
	}
	(void)fread(held, 1, GIVEN_MOST, file);
	fclose(file);
	OGRSpatialReferenceH srs = dem_srs_parse(held);
	mem_free(held);
	return srs;
}

enum status dem_srs_check(const char *path, OGRSpatialReferenceH srs)
{
	char *wkt = dem_srs_wkt(srs);
	const char *problem = wkt != NULL ? dem_srs_text_problem(wkt) : NULL;
	mem_free(wkt);
	return problem == NULL ? STATUS_OK : fail_with(STATUS_INPUT, "%s: its SRS: %s; name another with --s-srs", path, problem);
}

static bool is_earth(OGRSpatialReferenceH srs)
{
	double radius = OSRGetSemiMajor(srs, NULL);
	return radius > 6.35e6 && radius < 6.4e6;
}

OGRSpatialReferenceH dem_srs_degrees(OGRSpatialReferenceH srs)
{
	if (OSRIsLocal(srs))
		return NULL;
	const bool earth = is_earth(srs);
	OGRSpatialReferenceH degrees = earth ? OSRNewSpatialReference(NULL) : OSRCloneGeogCS(srs);
	if (degrees != NULL && earth && OSRImportFromEPSG(degrees, 4326) != OGRERR_NONE) {
		OSRDestroySpatialReference(degrees);
		return NULL;
	}
	if (degrees != NULL)
		OSRSetAxisMappingStrategy(degrees, OAMS_TRADITIONAL_GIS_ORDER);
	return degrees;
}

OGRSpatialReferenceH dem_srs_parse_beside(const char *text, OGRSpatialReferenceH other)
{
	if (strcmp(text, DEM_SRS_DEGREES) != 0)
		return parse(text, ", or " DEM_SRS_DEGREES);
	OGRSpatialReferenceH degrees = dem_srs_degrees(other);
	if (degrees == NULL)
		(void)fail_with(STATUS_INPUT, "degrees: the reference system is a local one, on no planet; give metres");
	return degrees;
}

/* True if the two are of bodies that differ by more than ellipsoids of one body do. */
static bool are_of_two_bodies(OGRSpatialReferenceH a, OGRSpatialReferenceH b)
{
	const double radius = OSRGetSemiMajor(a, NULL), other = OSRGetSemiMajor(b, NULL);
	return !OSRIsLocal(a) && !OSRIsLocal(b) && fabs(radius - other) > 0.005 * fmax(radius, other);
}

enum status dem_srs_move(const char *told, OGRSpatialReferenceH from, OGRSpatialReferenceH to, const char *whose, OGRCoordinateTransformationH *move)
{
	CPLErrorReset();
	*move = are_of_two_bodies(from, to) ? NULL : OCTNewCoordinateTransformation(from, to);
	if (*move != NULL)
		return STATUS_OK;
	if (!are_of_two_bodies(from, to))
		return fail_with(STATUS_INPUT, "%s: no way to %s SRS%s; give others", told, whose, dem_gdal_because());
	OGRSpatialReferenceH own = OSRCloneGeogCS(to);
	const char *name = own != NULL ? OSRGetName(own) : NULL;
	enum status status = fail_with(STATUS_INPUT, "%s: is on a body of radius %.0f km, and %s SRS, \"%.80s\", on one of %.0f km; for longitude and latitude there "
				       "give " DEM_SRS_DEGREES, told, OSRGetSemiMajor(from, NULL) / 1000, whose, name != NULL ? name : "",
				       OSRGetSemiMajor(to, NULL) / 1000);
	if (own != NULL)
		OSRDestroySpatialReference(own);
	return status;
}

void dem_srs_told(OGRSpatialReferenceH srs, char *text, size_t size)
{
	const char *authority = OSRGetAuthorityName(srs, NULL), *code = OSRGetAuthorityCode(srs, NULL), *name = OSRGetName(srs);
	if (authority != NULL && code != NULL)
		snprintf(text, size, "%s:%s", authority, code);
	else
		snprintf(text, size, "\"%.60s\"", name != NULL ? name : "unnamed");
}

bool dem_srs_differ(OGRSpatialReferenceH a, OGRSpatialReferenceH b)
{
	OGRSpatialReferenceH pair[2] = {OSRClone(a), OSRClone(b)};
	for (int i = 0; i < 2; i++) {
		if (pair[i] == NULL)
			continue;
		if (OSRIsCompound(pair[i]))
			OSRStripVertical(pair[i]);
		else if (OSRGetAxesCount(pair[i]) > 2)
			(void)OSRDemoteTo2D(pair[i], NULL);
		OSRSetAxisMappingStrategy(pair[i], OAMS_TRADITIONAL_GIS_ORDER);
	}
	const bool differ = pair[0] != NULL && pair[1] != NULL && !OSRIsSame(pair[0], pair[1]);
	for (int i = 0; i < 2; i++)
		if (pair[i] != NULL)
			OSRDestroySpatialReference(pair[i]);
	return differ;
}

char *dem_srs_wkt(OGRSpatialReferenceH srs)
{
	const char *options[] = {"FORMAT=WKT2_2019", "MULTILINE=NO", NULL};
	char *wkt = NULL;
	if (OSRExportToWktEx(srs, &wkt, options) != OGRERR_NONE) {
		CPLFree(wkt);
		return NULL;
	}
	char *copy = mem_strdup(wkt);
	CPLFree(wkt);
	return copy;
}

/* Longitude and latitude in radians on the SRS's own datum, with its ellipsoid. */
static bool on_ellipsoid(OGRSpatialReferenceH srs, int count, double *x, double *y)
{
	OGRSpatialReferenceH globe = OSRCloneGeogCS(srs);
	if (globe == NULL)
		return false;
	OSRSetAxisMappingStrategy(globe, OAMS_TRADITIONAL_GIS_ORDER);
	double radians = OSRGetAngularUnits(globe, NULL);
	bool good = true;
	if (!OSRIsGeographic(srs)) {
		OGRCoordinateTransformationH move = OCTNewCoordinateTransformation(srs, globe);
		good = move != NULL && OCTTransform(move, count, x, y, NULL);
		if (move != NULL)
			OCTDestroyCoordinateTransformation(move);
	}
	OSRDestroySpatialReference(globe);
	for (int i = 0; i < count; i++) {
		x[i] *= radians;
		y[i] *= radians;
		good = good && isfinite(x[i]) && fabs(y[i]) < 1.58;
	}
	return good;
}

/* In these, x is proportional to longitude. */
static bool is_cylindrical(OGRSpatialReferenceH srs)
{
	static const char *const names[] = {"Equirectangular", "Mercator_1SP", "Mercator_2SP", "Cylindrical_Equal_Area", "Miller_Cylindrical",
					    "Popular_Visualisation_Pseudo_Mercator"};
	const char *name = OSRIsProjected(srs) ? OSRGetAttrValue(srs, "PROJECTION", 0) : NULL;
	for (size_t i = 0; name != NULL && i < sizeof names / sizeof *names; i++)
		if (strcmp(name, names[i]) == 0)
			return true;
	return false;
}

double dem_srs_turn(OGRSpatialReferenceH srs, double *middle)
{
	*middle = 0;
	if (srs == NULL)
		return 0;
	if (OSRIsGeographic(srs))
		return 2 * M_PI / OSRGetAngularUnits(srs, NULL);
	if (!is_cylindrical(srs))
		return 0;
	*middle = OSRGetProjParm(srs, "false_easting", 0, NULL);
	const double north = OSRGetProjParm(srs, "false_northing", 0, NULL), step = 1000;
	double x[2] = {*middle - step, *middle + step}, y[2] = {north, north};
	if (!on_ellipsoid(srs, 2, x, y))
		return 0;
	const double turned = remainder(x[1] - x[0], 2 * M_PI);
	return turned > 0 ? 2 * step * 2 * M_PI / turned : 0;
}

double dem_srs_ground(OGRSpatialReferenceH srs, double x, double y, double dx, double dy)
{
	double lon[2] = {x - dx / 2, x + dx / 2}, lat[2] = {y - dy / 2, y + dy / 2};
	OGRErr problem = OGRERR_NONE;
	double a = OSRGetSemiMajor(srs, &problem), inverse = OSRGetInvFlattening(srs, NULL);
	if (problem != OGRERR_NONE || !on_ellipsoid(srs, 2, lon, lat))
		return (double)NAN;
	/* The chord between both places in space, since near a pole longitudes say nothing, and then its arc. */
	const double f = inverse != 0 ? 1 / inverse : 0, e2 = f * (2 - f);
	double at[2][3];
	for (int i = 0; i < 2; i++) {
		const double across = a / sqrt(1 - e2 * sin(lat[i]) * sin(lat[i]));
		at[i][0] = across * cos(lat[i]) * cos(lon[i]);
		at[i][1] = across * cos(lat[i]) * sin(lon[i]);
		at[i][2] = across * (1 - e2) * sin(lat[i]);
	}
	const double chord = hypot(hypot(at[1][0] - at[0][0], at[1][1] - at[0][1]), at[1][2] - at[0][2]);
	return chord < a ? 2 * a * asin(chord / (2 * a)) : (double)NAN;
}

double dem_srs_ground_off(OGRSpatialReferenceH srs, const double low[2], const double high[2])
{
	const double step = 10;
	double worst = 0;
	for (int i = 0; i < 18; i++) {
		const double x = low[0] + i / 2 % 3 * 0.5 * (high[0] - low[0]), y = low[1] + i / 6 * 0.5 * (high[1] - low[1]);
		const double off = dem_srs_ground(srs, x, y, i % 2 == 0 ? step : 0, i % 2 == 0 ? 0 : step) / step - 1;
		worst = fabs(off) > fabs(worst) ? off : worst; /* NaN is not larger */
	}
	return fabs(worst) > SCALE_TOLD ? worst : 0;
}

double dem_ground_off(const char *wkt, const double low[2], const double high[2])
{
	if (wkt[0] == '\0' || dem_gdal_init("distances on the ground") != STATUS_OK)
		return 0;
	dem_quiet_begin();
	OGRSpatialReferenceH srs = dem_srs_parse(wkt);
	const double off = srs != NULL ? dem_srs_ground_off(srs, low, high) : 0;
	if (srs != NULL)
		OSRDestroySpatialReference(srs);
	dem_quiet_end();
	return off;
}

/* True if a metre of `srs`, a metric one, is a metre on the ground at (lon, lat) in degrees. */
static bool is_true_at(OGRSpatialReferenceH globe, OGRSpatialReferenceH srs, double lon, double lat)
{
	OGRCoordinateTransformationH move = OCTNewCoordinateTransformation(globe, srs);
	bool good = move != NULL && OCTTransform(move, 1, &lon, &lat, NULL);
	if (move != NULL)
		OCTDestroyCoordinateTransformation(move);
	return good && fabs(dem_srs_ground(srs, lon, lat, 10, 0) / 10 - 1) <= SCALE_TOLERANCE &&
	       fabs(dem_srs_ground(srs, lon, lat, 0, 10) / 10 - 1) <= SCALE_TOLERANCE;
}

static OGRSpatialReferenceH projected_on(OGRSpatialReferenceH globe, const char *name)
{
	OGRSpatialReferenceH srs = OSRClone(globe);
	if (srs != NULL && OSRSetProjCS(srs, name) != OGRERR_NONE) {
		OSRDestroySpatialReference(srs);
		return NULL;
	}
	if (srs != NULL)
		OSRSetAxisMappingStrategy(srs, OAMS_TRADITIONAL_GIS_ORDER);
	return srs;
}

/* Degrees of longitude from which transverse Mercator is no use, and the latitude from which what goes round the body goes round its pole. */
#define WIDE 60.0
#define ROUND_POLE 50.0

/* On any body. Near a pole polar stereographic, with the meridian `heading` along y. Else equirectangular, or where that is not true (it
 * knows spheres only) transverse Mercator through the middle of the data. */
static OGRSpatialReferenceH metric_on_body(OGRSpatialReferenceH globe, double lon, double lat, double heading)
{
	lon = round(lon * 1e4) / 1e4;
	lat = round(lat * 1e4) / 1e4;
	OGRSpatialReferenceH srs = projected_on(globe, "metres around the data");
	if (srs == NULL)
		return NULL;
	if (fabs(lat) > 80) {
		OSRSetPS(srs, lat, heading, 1, 0, 0);
		return srs;
	}
	OSRSetEquirectangular2(srs, 0, lon, lat, 0, 0);
	if (!is_true_at(globe, srs, lon, lat))
		OSRSetTM(srs, lat, lon, 1, 0, 0);
	return srs;
}

/* Returns the meridian that is parallel to y in a polar projection, degrees; 0: srs is not polar. With the same meridian the target's axes are parallel to the source's. */
static double heading_of(OGRSpatialReferenceH srs)
{
	const char *name = OSRIsProjected(srs) ? OSRGetAttrValue(srs, "PROJECTION", 0) : NULL;
	if (name == NULL || strstr(name, "Stereographic") == NULL)
		return 0;
	const double is_absent = 1e9, degrees = OSRGetAngularUnits(srs, NULL) * 180 / M_PI;
	double lon = OSRGetProjParm(srs, "central_meridian", is_absent, NULL);
	if (lon == is_absent)
		lon = OSRGetProjParm(srs, "longitude_of_origin", is_absent, NULL);
	return lon == is_absent ? 0 : lon * degrees;
}

OGRSpatialReferenceH dem_srs_metric_wide(OGRSpatialReferenceH srs, const double low[2], const double high[2])
{
	if (!OSRIsGeographic(srs) || !(high[0] - low[0] > WIDE))
		return NULL;
	OGRSpatialReferenceH found = projected_on(srs, "metres of a large part of the body");
	if (found == NULL)
		return NULL;
	const double lon = (low[0] + high[0]) / 2, lat = (low[1] + high[1]) / 2;
	const bool cap = high[0] - low[0] > 180 && (low[1] >= ROUND_POLE || high[1] <= -ROUND_POLE);
	if (cap)
		OSRSetPS(found, lat, 0, 1, 0, 0);
	else
		OSRSetEquirectangular2(found, 0, lon, lat, 0, 0);
	return found;
}

OGRSpatialReferenceH dem_srs_metric(OGRSpatialReferenceH srs, double x, double y)
{
	const bool earth = is_earth(srs);
	OGRSpatialReferenceH globe = dem_srs_degrees(srs), found = NULL;
	OGRCoordinateTransformationH move = NULL;
	if (globe == NULL)
		goto done;
	move = OCTNewCoordinateTransformation(srs, globe);
	if (move == NULL || !OCTTransform(move, 1, &x, &y, NULL) || !isfinite(x) || fabs(y) > 90)
		goto done;
	if (!earth || fabs(y) > 84) {
		found = metric_on_body(globe, x, y, heading_of(srs));
		goto done;
	}
	int zone = (int)floor((remainder(x, 360) + 180) / 6) + 1;
	zone = zone > 60 ? 60 : zone;
	found = OSRNewSpatialReference(NULL);
	if (found != NULL && OSRImportFromEPSG(found, (y >= 0 ? 32600 : 32700) + zone) != OGRERR_NONE) {
		OSRDestroySpatialReference(found);
		found = NULL;
	}
	if (found != NULL)
		OSRSetAxisMappingStrategy(found, OAMS_TRADITIONAL_GIS_ORDER);
done:
	if (move != NULL)
		OCTDestroyCoordinateTransformation(move);
	if (globe != NULL)
		OSRDestroySpatialReference(globe);
	return found;
}

/* Says why a point has no place. */
static const char *why_nowhere(bool degrees, const double at[2])
{
	if (degrees && fabs(at[0]) <= 90 && fabs(at[1]) > 90 && fabs(at[1]) <= 360)
		return "is no longitude and latitude in degrees; latitude and longitude swapped? give longitude first";
	if (degrees && (fabs(at[0]) > 360 || fabs(at[1]) > 90))
		return "is no longitude and latitude in degrees; metres from the south-west post need no reference system";
	return "is nowhere in the store's SRS; check that x is east (longitude) and comes first";
}

enum status dem_transform(const char *from_srs, const char *to_wkt, size_t count, double *x, double *y)
{
	TRY(dem_gdal_init(from_srs));
	if (to_wkt[0] == '\0')
		return fail_with(STATUS_INPUT, "coordinates in \"%.80s\": the store is local metres and lies on "
				 "no planet; give local coordinates", from_srs);
	/* One of the two may be the other's degrees. */
	const bool back = strcmp(to_wkt, DEM_SRS_DEGREES) == 0;
	char told[120];
	snprintf(told, sizeof told, "coordinates in \"%.80s\"", back ? to_wkt : from_srs);
	OGRSpatialReferenceH known = dem_srs_parse(back ? from_srs : to_wkt), other = NULL;
	OGRCoordinateTransformationH move = NULL;
	enum status status = STATUS_INPUT;
	if (known == NULL || (other = dem_srs_parse_beside(back ? to_wkt : from_srs, known)) == NULL)
		goto done;
	OGRSpatialReferenceH from = back ? known : other, to = back ? other : known;
	TRY_OR(done, dem_srs_move(told, from, to, "the store's", &move));
	for (size_t i = 0; i < count; i++) {
		double at[2] = {x[i], y[i]};
		if (!OCTTransform(move, 1, &x[i], &y[i], NULL) || !isfinite(x[i]) || !isfinite(y[i]))
			TRY_OR(done, fail_with(STATUS_INPUT, "point %.10g, %.10g: %s", at[0], at[1],
					       why_nowhere(!back && strcmp(from_srs, DEM_SRS_DEGREES) == 0, at)));
	}
done:
	if (move != NULL)
		OCTDestroyCoordinateTransformation(move);
	if (other != NULL)
		OSRDestroySpatialReference(other);
	if (known != NULL)
		OSRDestroySpatialReference(known);
	return status;
}
