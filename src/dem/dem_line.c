/* Lines of GPX and GeoJSON files, read by GDAL. */
#include <math.h>

#include "dem_gdal.h"

struct reading {
	const char *told;
	size_t number; /* of the line that is wanted, from 1; 0: the only one; or DEM_EVERY_LINE */
	size_t lines;  /* so far */
	size_t room, starts_room;
	bool timeless; /* a point has no time */
	bool gpx;      /* points have attributes lat and lon */
	struct dem_line *line;
};

/* Returns true if points of the line that was begun last are to be kept. */
static bool is_wanted(const struct reading *reading)
{
	return reading->number == DEM_EVERY_LINE || (reading->number == 0 ? reading->lines == 1 : reading->lines == reading->number);
}

static enum status begin_line(struct reading *reading)
{
	struct dem_line *line = reading->line;
	reading->lines++;
	if (!is_wanted(reading))
		return STATUS_OK;
	TRY(mem_grow(&line->starts, &reading->starts_room, line->lines + 1, sizeof *line->starts, "reading a line"));
	line->starts[line->lines++] = line->count;
	return STATUS_OK;
}

static enum status add_point(struct reading *reading, double x, double y, double time)
{
	struct dem_line *line = reading->line;
	if (!is_wanted(reading))
		return STATUS_OK;
	if (!(fabs(x) <= 360 && fabs(y) <= 90) && reading->gpx)
		return fail_with(STATUS_INPUT, "%s: point %zu has lat %.10g and lon %.10g, which is no place%s", reading->told, line->count + 1, y, x,
				 fabs(x) <= 90 && fabs(y) <= 360 ? "; lat and lon are swapped" : "; both are degrees");
	if (!(fabs(x) <= 360 && fabs(y) <= 90))
		return fail_with(STATUS_INPUT, "%s: point %zu, %.10g, %.10g, is no longitude and latitude; both are degrees, longitude first",
				 reading->told, line->count + 1, x, y);
	if (line->count == reading->room) {
		const size_t more = mem_room(reading->room, line->count + 1);
		TRY(mem_resize(&line->points, more, sizeof *line->points, "reading a line"));
		TRY(mem_resize(&line->times, more, sizeof *line->times, "reading a line"));
		reading->room = more;
	}
	line->points[line->count][0] = x;
	line->points[line->count][1] = y;
	line->times[line->count++] = time;
	reading->timeless = reading->timeless || isnan(time);
	return STATUS_OK;
}

/* --- geometries --- */

static enum status add_geometry(struct reading *reading, OGRGeometryH geometry)
{
	const OGRwkbGeometryType type = OGR_GT_Flatten(OGR_G_GetGeometryType(geometry));
	if (type == wkbLineString) {
		const int count = OGR_G_GetPointCount(geometry);
		if (count > 0)
			TRY(begin_line(reading));
		for (int i = 0; i < count; i++)
			TRY(add_point(reading, OGR_G_GetX(geometry, i), OGR_G_GetY(geometry, i), (double)NAN));
		return STATUS_OK;
	}
	if (type != wkbMultiLineString && type != wkbGeometryCollection)
		return STATUS_OK;
	for (int i = 0; i < OGR_G_GetGeometryCount(geometry); i++)
		TRY(add_geometry(reading, OGR_G_GetGeometryRef(geometry, i)));
	return STATUS_OK;
}

static enum status add_layer(struct reading *reading, OGRLayerH layer)
{
	OGRFeatureH feature;
	OGR_L_ResetReading(layer);
	while ((feature = OGR_L_GetNextFeature(layer)) != NULL) {
		OGRGeometryH geometry = OGR_F_GetGeometryRef(feature);
		const enum status status = geometry != NULL ? add_geometry(reading, geometry) : STATUS_OK;
		OGR_F_Destroy(feature);
		TRY(status);
	}
	return STATUS_OK;
}

/* --- GPX: points know their track or route --- */

/* Days from 1970-01-01 to a date of the Gregorian calendar (Fliegel and Van Flandern, Comm. ACM 11, 1968). */
static double days_since_1970(int year, int month, int day)
{
	const int a = (month - 14) / 12;
	const long julian = day - 32075L + 1461L * (year + 4800 + a) / 4 + 367L * (month - 2 - a * 12) / 12 - 3L * ((year + 4900 + a) / 100) / 4;
	return (double)(julian - 2440588);
}

static double time_of(OGRFeatureH feature, int field)
{
	int year, month, day, hour, minute, zone;
	float second;
	if (field < 0 || !OGR_F_IsFieldSetAndNotNull(feature, field) ||
	    !OGR_F_GetFieldAsDateTimeEx(feature, field, &year, &month, &day, &hour, &minute, &second, &zone))
		return (double)NAN;
	/* 0: unknown, 1: local, 100: UTC, and from there quarters of an hour. GPX tells UTC. */
	const double behind = zone > 1 ? (zone - 100) * 900.0 : 0;
	return days_since_1970(year, month, day) * 86400 + hour * 3600 + minute * 60 + round((double)second * 1000) / 1000 - behind;
}

static enum status add_points(struct reading *reading, OGRLayerH layer, const char *key)
{
	OGRFeatureH feature;
	int before = -1;
	OGR_L_ResetReading(layer);
	while ((feature = OGR_L_GetNextFeature(layer)) != NULL) {
		OGRGeometryH point = OGR_F_GetGeometryRef(feature);
		const int number = OGR_F_GetFieldAsInteger(feature, OGR_F_GetFieldIndex(feature, key));
		enum status status = point != NULL && number != before ? begin_line(reading) : STATUS_OK;
		if (point != NULL && status == STATUS_OK)
			status = add_point(reading, OGR_G_GetX(point, 0), OGR_G_GetY(point, 0), time_of(feature, OGR_F_GetFieldIndex(feature, "time")));
		before = point != NULL ? number : before;
		OGR_F_Destroy(feature);
		TRY(status);
	}
	return STATUS_OK;
}

static enum status read_gpx(struct reading *reading, GDALDatasetH set)
{
	reading->gpx = true;
	OGRLayerH tracks = GDALDatasetGetLayerByName(set, "track_points"), routes = GDALDatasetGetLayerByName(set, "route_points");
	if (tracks != NULL)
		TRY(add_points(reading, tracks, "track_fid"));
	return reading->lines == 0 && routes != NULL ? add_points(reading, routes, "route_fid") : STATUS_OK;
}

/* --- a file --- */

static enum status read_geojson(struct reading *reading, GDALDatasetH set)
{
	OGRLayerH layer = GDALDatasetGetLayer(set, 0);
	OGRSpatialReferenceH srs = layer != NULL ? OGR_L_GetSpatialRef(layer) : NULL;
	if (srs != NULL && !OSRIsGeographic(srs))
		return fail_with(STATUS_INPUT, "%s: it is not in longitude and latitude; convert it: ogr2ogr -t_srs EPSG:4326 OUT.geojson FILE (Mars: "
				 "IAU_2015:49900, the Moon: IAU_2015:30100)",
				 reading->told);
	return layer != NULL ? add_layer(reading, layer) : STATUS_OK;
}

static enum status check_number(const struct reading *reading)
{
	if (reading->lines == 0)
		return fail_with(STATUS_INPUT, "%s: it has no line; give a GPX file with a track or a route, or a GeoJSON file with a LineString",
				 reading->told);
	if (reading->number == 0 && reading->lines > 1)
		return fail_with(STATUS_INPUT, "%s: it has %zu lines; say which: line: 1 to %zu", reading->told, reading->lines, reading->lines);
	if (reading->number != DEM_EVERY_LINE && reading->number > reading->lines)
		return fail_with(STATUS_INPUT, "%s: it has %zu line%s, and line %zu is asked for; give one of them", reading->told, reading->lines,
				 reading->lines > 1 ? "s" : "", reading->number);
	return STATUS_OK;
}

void dem_line_finish(struct dem_line *line)
{
	mem_free_all(line->points, line->times, line->starts);
	*line = (struct dem_line){.count = 0};
}

static enum status read_set(struct reading *reading, GDALDatasetH set)
{
	TRY(GDALDatasetGetLayerByName(set, "track_points") != NULL ? read_gpx(reading, set) : read_geojson(reading, set));
	/* Reading ends at a damaged place as at the end of the file. */
	if (CPLGetLastErrorType() >= CE_Failure)
		return fail_with(STATUS_INPUT, "%s: it is damaged%s; check the file", reading->told, dem_gdal_because());
	return STATUS_OK;
}

enum status dem_line_read(const char *path, const char *told, size_t number, struct dem_line *line)
{
	static const char *const drivers[] = {"GPX", "GeoJSON", NULL};
	struct reading reading = {.told = told, .number = number, .line = line};
	*line = (struct dem_line){.count = 0};
	TRY(dem_gdal_init(told));
	CPLErrorReset();
	GDALDatasetH set = GDALOpenEx(path, GDAL_OF_VECTOR | GDAL_OF_READONLY, drivers, NULL, NULL);
	if (set == NULL)
		return fail_with(STATUS_INPUT, "%s: neither GPX nor GeoJSON%s; check the file", told, dem_gdal_because());
	enum status status = read_set(&reading, set);
	GDALClose(set);
	TRY_OR(failed, status);
	TRY_OR(failed, check_number(&reading));
	if (reading.timeless) {
		mem_free(line->times);
		line->times = NULL;
	}
	return STATUS_OK;
failed:
	dem_line_finish(line);
	return status;
}
