/* What a stored value means: nodata or metres. NaN is always nodata. */
#include "dem_internal.h"

#include <strings.h>

static bool same_value(double value, double nodata, bool single)
{
	if (value == nodata)
		return true;
	if (isinf(nodata))
		return false;
	/* No ground is that high: -3.4e38 means the lowest float, with all the digits it lacks. */
	if (fabs(nodata) > 1e30)
		return fabs(value - nodata) <= 1e-3 * fabs(nodata);
	if (!single)
		return false;
	/* A tag is decimal text, often with fewer digits than the float it means. */
	return (float)value == (float)nodata;
}

double dem_metres(const struct dem_meaning *meaning, double value)
{
	if (isnan(value))
		return value;
	for (size_t i = 0; i < meaning->nodata_count; i++)
		if (same_value(value, meaning->nodata[i], meaning->single))
			return (double)NAN;
	double metres = value * meaning->scale;
	if (meaning->offset != 0) /* adding a zero would make zero of negative zero */
		metres += meaning->offset;
	return meaning->single ? (double)(float)metres : metres;
}

double dem_unit_metres(const char *unit)
{
	static const struct {
		const char *name;
		double metres;
	} units[] = {
		{"ft", 0.3048},
		{"foot", 0.3048},
		{"feet", 0.3048},
		{"international foot", 0.3048},
		{"international feet", 0.3048},
		{"us-ft", 1200.0 / 3937.0},
		{"ftus", 1200.0 / 3937.0},
		{"sfoot", 1200.0 / 3937.0},
		{"us survey foot", 1200.0 / 3937.0},
		{"us survey feet", 1200.0 / 3937.0},
		{"foot_us", 1200.0 / 3937.0},
		{"km", 1000},
		{"kilometre", 1000},
		{"kilometer", 1000},
		{"dm", 0.1},
		{"decimetre", 0.1},
		{"decimeter", 0.1},
		{"cm", 0.01},
		{"centimetre", 0.01},
		{"centimeter", 0.01},
		{"mm", 0.001},
		{"millimetre", 0.001},
		{"millimeter", 0.001},
		{"fathom", 1.8288},
	};
	for (size_t i = 0; i < sizeof units / sizeof units[0]; i++)
		if (strcasecmp(unit, units[i].name) == 0)
			return units[i].metres;
	return 1;
}
