/* Places as people give them; see place.h. */
#include "place.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "chart/chart.h"
#include "dem/dem.h"

enum status place_local(const struct store_meta *meta, const char *srs, const char *command, const char *option, double *x, double *y)
{
	if (srs == NULL)
		return STATUS_OK;
	if (strcmp(srs, "store") != 0) {
		if (meta->srs[0] == '\0')
			return fail_with(STATUS_INPUT, "%s: the store has no reference system; leave %s out and give metres from its south-west post, or import again "
						       "with --s-srs EPSG:..., if its coordinates are of a system", command, option);
		TRY(dem_transform(srs, meta->srs, 1, x, y));
	}
	*x -= meta->origin[0];
	*y -= meta->origin[1];
	return STATUS_OK;
}

static bool any_inside(const struct store_meta *meta, size_t count, const double *x, const double *y)
{
	const struct extent *extent = &meta->extent;
	for (size_t i = 0; i < count; i++)
		if (extent_holds(extent, x[i] - meta->origin[0], y[i] - meta->origin[1]))
			return true;
	return false;
}

/* Returns true if a place would be inside with x and y exchanged. */
static bool is_exchanged(const struct store_meta *meta, const char *srs, size_t count, const double *x, const double *y)
{
	struct failure kept;
	bool inside = false;
	failure_capture(&kept, STATUS_OK);
	for (size_t i = 0; i < count && !inside; i++) {
		double east = y[i], north = x[i];
		inside = place_local(meta, srs, "query", "--srs", &east, &north) == STATUS_OK && extent_holds(&meta->extent, east, north);
	}
	(void)failure_restore(&kept);
	return inside;
}

bool place_guess(const struct store_meta *meta, const char *srs, const char *option, size_t count, const double *x, const double *y, char *hint,
		 size_t room)
{
	char system[160];
	chart_system_name(meta->srs, system, sizeof system);
	if ((srs == NULL || strcmp(srs, "store") != 0) && any_inside(meta, count, x, y)) {
		snprintf(hint, room, "inside as coordinates of %s; give %s store", system[0] != '\0' ? system : "the terrain's source", option);
		return true;
	}
	if (srs != NULL && strcmp(srs, DEM_SRS_DEGREES) != 0 && is_exchanged(meta, srs, count, x, y)) {
		snprintf(hint, room, "inside with both numbers exchanged; give east, or longitude, first");
		return true;
	}
	struct dem_globe *globe = NULL;
	bool degrees = meta->srs[0] != '\0';
	for (size_t i = 0; i < count; i++)
		degrees = degrees && fabs(x[i]) <= 360 && fabs(y[i]) <= 360;
	if (!degrees || dem_globe_create(meta->srs, &globe) != STATUS_OK || globe == NULL)
		return false;
	bool found = false;
	for (int swapped = 0; swapped < 2 && !found; swapped++) {
		double east[PLACE_POINTS], north[PLACE_POINTS];
		memcpy(swapped ? north : east, x, count * sizeof *x);
		memcpy(swapped ? east : north, y, count * sizeof *y);
		dem_globe_from_degrees(globe, count, east, north);
		found = any_inside(meta, count, east, north);
		if (found)
			snprintf(hint, room, swapped ? "inside as latitude and longitude; give longitude first, and %s degrees"
						     : "inside as longitude and latitude; give %s degrees", option);
	}
	dem_globe_destroy(globe);
	return found;
}
