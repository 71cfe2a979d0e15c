/* The polygon of furrow edit: WKT or GeoJSON, from a text or a file. */
#include "edit.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include <cJSON.h>

#include "dem/dem.h"
#include "place.h"

#define FILE_MOST (16 << 20) /* bytes */

struct corners {
	double *xy;
	size_t count, room;
};

static enum status add(struct corners *corners, double x, double y)
{
	TRY(mem_grow(&corners->xy, &corners->room, 2 * corners->count + 2, sizeof *corners->xy, "a polygon"));
	corners->xy[2 * corners->count] = x;
	corners->xy[2 * corners->count++ + 1] = y;
	return STATUS_OK;
}

static enum status bad(const char *what, const char *why)
{
	return fail_with(STATUS_INPUT, "%.200s: %s; give one polygon, as POLYGON ((X Y, X Y, X Y)) or as GeoJSON", what, why);
}

/* --- WKT --- */

static const char *skip(const char *text)
{
	return text + strspn(text, " \t\r\n");
}

static bool is_wkt(const char *text)
{
	return strncasecmp(skip(text), "POLYGON", 7) == 0;
}

/* Reads "X Y", and numbers behind them, which are not used. */
static bool read_corner(const char **at, double *x, double *y)
{
	char *end;
	*x = strtod(*at, &end);
	if (end == *at)
		return false;
	*at = end;
	*y = strtod(*at, &end);
	if (end == *at)
		return false;
	do
		*at = end;
	while (strtod(*at, &end), end != *at);
	*at = skip(*at);
	return true;
}

static enum status read_wkt(const char *what, const char *text, struct corners *corners)
{
	const char *at = skip(skip(text) + strlen("POLYGON"));
	double x, y;
	at = skip(at + (strncasecmp(at, "ZM", 2) == 0 ? 2 : strncasecmp(at, "Z", 1) == 0 || strncasecmp(at, "M", 1) == 0 ? 1 : 0));
	if (*at != '(' || *skip(at + 1) != '(')
		return bad(what, "it has no ring of corners");
	at = skip(at + 1) + 1;
	do {
		if (!read_corner(&at, &x, &y))
			return bad(what, "a corner is not two numbers");
		TRY(add(corners, x, y));
	} while (*at++ == ',');
	at = skip(at);
	if (at[-1] != ')' && *(at - 1) != ' ' && *(at - 1) != '\n')
		return bad(what, "its ring has no end");
	if (*at == ',')
		return bad(what, "it has a hole, and soil is poured on all of a polygon");
	if (*at != ')' || *skip(at + 1) != '\0')
		return bad(what, "more than a polygon is there");
	return STATUS_OK;
}

/* --- GeoJSON --- */

static const char *type_of(const cJSON *object)
{
	const char *type = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(object, "type"));
	return type != NULL ? type : "";
}

/* Goes from a collection of one feature to that, and from a feature to its geometry. NULL: there is no one polygon. */
static const cJSON *polygon_of(const cJSON *object)
{
	if (strcmp(type_of(object), "FeatureCollection") == 0) {
		const cJSON *features = cJSON_GetObjectItemCaseSensitive(object, "features");
		object = cJSON_GetArraySize(features) == 1 ? cJSON_GetArrayItem(features, 0) : NULL;
	}
	if (strcmp(type_of(object), "Feature") == 0)
		object = cJSON_GetObjectItemCaseSensitive(object, "geometry");
	return strcmp(type_of(object), "Polygon") == 0 ? object : NULL;
}

static enum status read_rings(const char *what, const cJSON *polygon, struct corners *corners)
{
	const cJSON *rings = cJSON_GetObjectItemCaseSensitive(polygon, "coordinates"), *corner;
	if (cJSON_GetArraySize(rings) > 1)
		return bad(what, "it has a hole, and soil is poured on all of a polygon");
	cJSON_ArrayForEach(corner, cJSON_GetArrayItem(rings, 0)) {
		const cJSON *x = cJSON_GetArrayItem(corner, 0), *y = cJSON_GetArrayItem(corner, 1);
		if (!cJSON_IsNumber(x) || !cJSON_IsNumber(y))
			return bad(what, "a corner is not two numbers");
		TRY(add(corners, x->valuedouble, y->valuedouble));
	}
	return STATUS_OK;
}

static enum status read_geojson(const char *what, const char *text, struct corners *corners)
{
	cJSON *root = cJSON_ParseWithOpts(text, NULL, true);
	const cJSON *polygon = polygon_of(root);
	enum status status;
	TRY_OR(done, polygon != NULL ? STATUS_OK : bad(what, root == NULL ? "it is neither WKT of a POLYGON nor JSON" : "it has no Polygon, or several"));
	TRY_OR(done, read_rings(what, polygon, corners));
done:
	cJSON_Delete(root);
	return status;
}

/* --- both --- */

static enum status read_file(const char *path, char **text)
{
	FILE *file = fopen(path, "rb");
	if (file == NULL)
		return fail_with(STATUS_INPUT, "%.200s: %s; give POLYGON ((X Y, ...)), or a file of WKT or GeoJSON", path, strerror(errno));
	*text = mem_alloc(FILE_MOST + 1, 1);
	enum status status = *text != NULL ? STATUS_OK : fail_memory(path);
	if (status == STATUS_OK) {
		const size_t length = fread(*text, 1, FILE_MOST + 1, file);
		if (ferror(file) || length > FILE_MOST)
			status = fail_with(STATUS_INPUT, "%s: cannot be read, or is larger than %d MiB; check the file", path, FILE_MOST >> 20);
		else
			(*text)[length] = '\0';
	}
	fclose(file);
	return status;
}

static enum status to_local(const char *what, const struct store_meta *meta, const char *srs, struct corners *corners)
{
	double *xy = corners->xy;
	if (corners->count > 1 && memcmp(xy, xy + 2 * (corners->count - 1), 2 * sizeof *xy) == 0)
		corners->count--; /* a ring ends where it begins */
	if (corners->count < 3)
		return bad(what, "it has fewer than three corners");
	for (size_t i = 0; i < corners->count; i++)
		TRY(place_local(meta, srs, "edit", "--srs", &xy[2 * i], &xy[2 * i + 1]));
	return STATUS_OK;
}

enum status edit_polygon_read(const char *given, const struct store_meta *meta, const char *srs, size_t *count, double **xy)
{
	struct corners corners = {.xy = NULL};
	char *text = NULL;
	enum status status;
	if (!is_wkt(given))
		TRY_OR(failed, read_file(given, &text));
	const bool wkt = is_wkt(text != NULL ? text : given);
	TRY_OR(failed, wkt ? read_wkt(given, text != NULL ? text : given, &corners) : read_geojson(given, text, &corners));
	if (srs == NULL && !wkt && meta->srs[0] != '\0')
		srs = DEM_SRS_DEGREES;
	TRY_OR(failed, to_local(given, meta, srs, &corners));
	mem_free(text);
	*count = corners.count;
	*xy = corners.xy;
	return STATUS_OK;
failed:
	mem_free_all(text, corners.xy);
	return status;
}
