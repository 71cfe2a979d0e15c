/* Converts stored values to metres, or to NaN for nodata. NaN is always nodata. */
#include "dem_internal.h"

#include <math.h>
#include <string.h>
#include <strings.h>

#include "base/wide.h"

/* Holes where values are `nodata`: without branches, so that it becomes vector code. */
FURROW_WIDE static void punch(const double *values, int64_t count, double nodata, bool single, double *metres)
{
	/* No ground is as high as such a tag. -3.4e38 means the lowest float, whose other digits were left out, so values near the
	 * tag are nodata too. */
	double near = !isinf(nodata) && fabs(nodata) > 1e30 ? 1e-3 * fabs(nodata) : -1;
	/* A tag is decimal text, often with fewer digits than the float it means. */
	bool rounds = single && !isinf(nodata);
	float rounded = (float)nodata;
	for (int64_t i = 0; i < count; i++) {
		bool same = (values[i] == nodata) | (rounds & ((float)values[i] == rounded)) |
			    (fabs(values[i] - nodata) <= near);
		metres[i] = same ? (double)NAN : metres[i];
	}
}

static void run_to_metres(const struct dem_meaning *meaning, const double *values, int64_t count, double *metres)
{
	double scale = meaning->scale, offset = meaning->offset;
	for (int64_t i = 0; i < count; i++)
		metres[i] = values[i] * scale;
	for (int64_t i = 0; offset != 0 && i < count; i++) /* zero would make zero of negative zero */
		metres[i] += offset;
	for (int64_t i = 0; meaning->single && i < count; i++)
		metres[i] = (double)(float)metres[i];
	for (size_t i = 0; i < meaning->nodata_count; i++)
		punch(values, count, meaning->nodata[i], meaning->single, metres);
}

void dem_metres(const struct dem_meaning *meaning, const double *values, int64_t count, double *metres)
{
	double run[512]; /* what is written may be what is read */
	for (int64_t i = 0; i < count; i += 512) {
		int64_t length = count - i < 512 ? count - i : 512;
		run_to_metres(meaning, values + i, length, run);
		memcpy(metres + i, run, (size_t)length * sizeof *run);
	}
}

bool dem_unit_exact(double unit)
{
	int exponent;
	return unit > 0 && (unit == rint(unit) || frexp(unit, &exponent) == 0.5);
}

static const struct {
	const char *name; /* of one; more have an s behind it */
	double metres;
} units[] = {
	{"m", 1},
	{"metre", 1},
	{"meter", 1},
	{"mtr", 1},
	{"ft", 0.3048},
	{"foot", 0.3048},
	{"feet", 0.3048},
	{"international foot", 0.3048},
	{"international feet", 0.3048},
	{"us-ft", 1200.0 / 3937.0},
	{"ftus", 1200.0 / 3937.0},
	{"sft", 1200.0 / 3937.0},
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
	{"yd", 0.9144},
	{"yard", 0.9144},
};

/* Returns 0 for a name that is not known. */
static double find_unit(const char *unit)
{
	for (size_t i = 0; i < sizeof units / sizeof units[0]; i++) {
		const size_t length = strlen(units[i].name);
		const char *more = unit + length;
		if (strncasecmp(unit, units[i].name, length) == 0 && (*more == '\0' || strcasecmp(more, "s") == 0))
			return units[i].metres;
	}
	return 0;
}

double dem_unit_metres(const char *unit)
{
	const double metres = find_unit(unit);
	return metres > 0 ? metres : 1;
}

bool dem_unit_known(const char *unit)
{
	return find_unit(unit) > 0;
}
