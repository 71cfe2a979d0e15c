/*
 * Soils by name, and their numbers by key. docs/SOILS.md has this table in SI units, with the sources; a test compares
 * the two.
 *
 * n, k_c, k_phi, c, phi, K: Wong, Theory of Ground Vehicles, 2008, table 2.3, there in kN, kPa, cm and degrees. The weight
 * is that of a usual bulk density of the kind under the gravity beside it. The stiffness of unloading and the damping are those of the soft soil of Project Chrono's
 * demonstrations: Krenn and Hirzinger 2009 leave them open.
 *
 * rock, asphalt, concrete, ice: hard ground, which has friction alone. Rock: the basic friction angle of granite, Barton and Choubey 1977. The others: what tyres
 * have on dry concrete, dry asphalt and ice, Noon 1994, Engineering Analysis of Vehicular Accidents.
 *
 * sand, mud, snow: Sumner, O'Brien and Hodgins 1999. These could not be checked against the paper itself. Its alpha is the share
 * of the soil that is displaced: 0.3, 0.41, 0. Compression here is the share that is lost, 1 - alpha.
 */
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "soil/soil.h"

#define BARE_RIGID 1e30 /* bekker_kphi of rigid ground without a layer: what yields is beyond what springs */
#define HARD_SHEAR 0.002 /* m: what slides on hard ground grips within a few times this: a tread shears, as a tyre's slip curve has it */
/* These are of what lies on hard ground: that gives way, not the ground. */
#define HARD_STIFFNESS 2e8 /* Pa/m: a rigid wheel of 5 kN, 0.8 m by 0.2 m, sinks by 2 mm */
#define HARD_DAMPING 1e5 /* Pa s/m: a wheel's rolling resistance at 5 m/s is below 1 % of its load */
#define HARD_REPOSE 90 /* degrees: no slope slides */
#define SUMNER_SAND {0.8, 0.436, 0.2, 0.8, 0.7}

static const struct row {
	const char *name;
	struct wong {
		double n, k_c, k_phi, c, phi, k_cm, weight; /* as printed; weight kN/m3; n 0: the soil has none of these */
		double density; /* kg/m3 */
	} wong;
	struct sumner {
		double theta_in, theta_out, roughness, theta_stop, compression; /* rad; theta_in 0: the soil has none of these */
	} sumner;
	struct hard {
		double phi, density; /* degrees; kg/m3; phi 0: the soil is not hard ground */
	} hard;
} rows[] = {
	{.name = "dry_sand", .wong = {1.1, 0.99, 1528.43, 1.04, 28, 2, 16, 1631}, .sumner = SUMNER_SAND},
	{.name = "sandy_loam_15", .wong = {0.7, 5.27, 1515.04, 1.72, 29, 2, 15, 1529}},
	{.name = "sandy_loam_22", .wong = {0.2, 2.56, 43.12, 1.38, 38, 2, 16, 1631}},
	{.name = "clayey_38", .wong = {0.5, 13.19, 692.15, 4.14, 13, 2, 16, 1631}},
	{.name = "heavy_clay_25", .wong = {0.13, 12.7, 1555.95, 68.95, 34, 0.6, 18, 1835}},
	{.name = "heavy_clay_40", .wong = {0.11, 1.84, 103.27, 20.69, 6, 3, 17, 1733}},
	{.name = "lean_clay_22", .wong = {0.2, 16.43, 1724.69, 68.95, 20, 0.6, 18, 1835}},
	{.name = "lete_sand", .wong = {0.79, 102, 5301, 1.3, 31.1, 1.2, 16, 1631}},
	{.name = "upland_loam_51", .wong = {1.1, 74.6, 2080, 3.3, 33.7, 2, 15, 1529}},
	{.name = "snow_us", .wong = {1.6, 4.37, 196.72, 1.03, 19.7, 3, 3, 306}},
	{.name = "snow_sweden", .wong = {1.44, 10.55, 66.08, 6, 20.7, 3, 3, 306}},
	{.name = "lunar", .wong = {1, 1.4, 820, 0.17, 35, 1.8, 2.5, 1543.21}},
	{.name = "rock", .hard = {33, 2650}},
	{.name = "asphalt", .hard = {33.02, 2350}}, /* atan 0.65 */
	{.name = "concrete", .hard = {36.87, 2400}}, /* atan 0.75 */
	{.name = "ice", .hard = {5.71, 917}}, /* atan 0.1 */
	{.name = "sand", .sumner = SUMNER_SAND},
	{.name = "mud", .sumner = {1.57, 1.1, 0.2, 1.1, 0.59}},
	{.name = "snow", .sumner = {1.57, 1.57, 0.2, 1.57, 1}},
};
#define ROWS (sizeof rows / sizeof rows[0])

static double radians(double degrees)
{
	return degrees * (M_PI / 180);
}

static void take_wong(const struct wong *wong, struct soil_numbers *soil)
{
	soil->bekker_kc = wong->k_c * 1e3;
	soil->bekker_kphi = wong->k_phi * 1e3;
	soil->bekker_n = wong->n;
	soil->cohesion = wong->c * 1e3;
	soil->friction_angle = radians(wong->phi);
	soil->janosi_shear = wong->k_cm / 100;
	soil->elastic_stiffness = SOIL_USUAL_STIFFNESS;
	soil->damping = SOIL_USUAL_DAMPING;
	soil->density = wong->density;
	soil->unit_weight = wong->weight * 1e3;
	soil->repose = radians(wong->phi);
}

static void take_sumner(const struct sumner *sumner, struct soil_numbers *soil)
{
	soil->theta_in = sumner->theta_in;
	soil->theta_out = sumner->theta_out;
	soil->theta_stop = sumner->theta_stop;
	soil->roughness = sumner->roughness;
	soil->compression = sumner->compression;
}

/* Ground that springs, and yields to nothing. */
static void harden(struct soil_numbers *soil)
{
	soil->bekker_kc = 0;
	soil->bekker_kphi = BARE_RIGID;
	soil->bekker_n = 1;
	soil->elastic_stiffness = SOIL_RIGID_STIFFNESS;
}

static void take_hard(const struct hard *hard, struct soil_numbers *soil)
{
	harden(soil);
	soil->elastic_stiffness = HARD_STIFFNESS;
	soil->cohesion = 0;
	soil->friction_angle = radians(hard->phi);
	soil->janosi_shear = HARD_SHEAR;
	soil->damping = HARD_DAMPING;
	soil->density = hard->density;
	soil->repose = radians(HARD_REPOSE);
}

void soil_clear(struct soil_numbers *soil)
{
	const double none = (double)NAN;
	*soil = (struct soil_numbers){
		.bekker_kc = none, .bekker_kphi = none, .bekker_n = none, .cohesion = none, .friction_angle = none,
		.janosi_shear = none, .elastic_stiffness = none, .damping = none, .density = none, .unit_weight = none, .repose = none,
		.theta_in = none, .theta_out = none, .theta_stop = none, .roughness = none, .compression = none, .face_strength = none, .face_cohesion = none, .thickness = none, .compaction = none,
	};
}

void soil_set_rigid(struct soil_numbers *soil)
{
	soil_clear(soil);
	soil->bekker_kphi = INFINITY;
}

bool soil_is_rigid(const struct soil_numbers *soil)
{
	return isinf(soil->bekker_kphi);
}

bool soil_is_hard(const struct soil_numbers *soil)
{
	return soil->bekker_kphi >= BARE_RIGID;
}

void soil_end_layer(struct soil_numbers *soil)
{
	const struct soil_numbers *over = soil->over;
	if (over == NULL || (soil->thickness > 0 && soil->thickness < SOIL_ENDLESS))
		return;
	if (soil->thickness >= SOIL_ENDLESS) {
		soil->over = NULL;
		soil->thickness = (double)NAN;
	} else if (!soil_is_rigid(over)) {
		*soil = *over;
	} else {
		/* It springs, and shears as the layer would. */
		harden(soil);
		soil->over = NULL;
		soil->thickness = (double)NAN;
	}
}

void soil_law_set_layers(struct soil_law *law)
{
	bool by_raster = false;
	for (int i = 0; i < law->raster_count; i++)
		by_raster = by_raster || law->rasters[i].number == SOIL_THICKNESS;
	law->layered = false;
	for (int i = 0; i < law->soil_count; i++) {
		if (!by_raster)
			soil_end_layer(&law->soils[i]);
		law->layered = law->layered || law->soils[i].over != NULL || soil_is_hard(&law->soils[i]); /* slip digs none of it */
	}
}

const char *soil_name(size_t index)
{
	return index < ROWS ? rows[index].name : NULL;
}

enum status soil_named(const char *name, struct soil_numbers *soil)
{
	char all[512] = "";
	for (size_t i = 0; i < ROWS; i++) {
		if (strcmp(rows[i].name, name) == 0) {
			soil_clear(soil);
			if (rows[i].wong.n > 0)
				take_wong(&rows[i].wong, soil);
			if (rows[i].sumner.theta_in > 0)
				take_sumner(&rows[i].sumner, soil);
			if (rows[i].hard.phi > 0)
				take_hard(&rows[i].hard, soil);
			return STATUS_OK;
		}
		snprintf(all + strlen(all), sizeof all - strlen(all), "%s%s", i > 0 ? ", " : "", rows[i].name);
	}
	return fail_with(STATUS_INPUT, "soil: there is none by that name; known are: %s", all);
}

#define FACE_LEAST 0.3 /* tangents of the friction angle between which the fit was made */
#define FACE_MOST 0.9

double soil_face_strength(const struct soil_numbers *soil)
{
	const double m = fmin(fmax(tan(soil->friction_angle), FACE_LEAST), FACE_MOST);
	return isnan(soil->face_strength) ? soil->unit_weight * m * (89 - m * (386 - m * 894)) : soil->face_strength;
}

#define SAND_MOST 1300.0  /* Pa: soils of no more cohesion are sands: the table's have 170 to 1300 */
#define LOAM_LEAST 1700.0 /* Pa: soils of more are loams and clays: sandy_loam_15 has 1720 */

double soil_face_cohesion(const struct soil_numbers *soil)
{
	const double felt = fmin(fmax((soil->cohesion - SAND_MOST) / (LOAM_LEAST - SAND_MOST), 0), 1);
	return isnan(soil->face_cohesion) ? felt * soil->cohesion : soil->face_cohesion;
}

#define KEY(number, key) [number] = #key,
#define PLACE(number, key) [number] = offsetof(struct soil_numbers, key),
const char *soil_number_key(enum soil_number number)
{
	static const char *const keys[] = {SOIL_NUMBERS_EACH(KEY)};
	return keys[number];
}

double *soil_number_in(struct soil_numbers *soil, enum soil_number number)
{
	static const size_t places[] = {SOIL_NUMBERS_EACH(PLACE)};
	return (double *)((char *)soil + places[number]);
}

double soil_raster_value(const struct soil_raster *raster, uint8_t level)
{
	return level == SOIL_LEVELS ? raster->high
				      : raster->low + (raster->high - raster->low) / (SOIL_LEVELS - 1) * (level - 1);
}

struct soil_numbers soil_numbers_at(const struct soil_law *law, const struct soil_planes *planes, size_t at)
{
	const int class = planes->classes != NULL ? planes->classes[at] : 0;
	struct soil_numbers soil = law->soils[class < law->soil_count ? class : 0];
	for (int i = 0; i < law->raster_count && planes->levels != NULL; i++)
		if (planes->levels[SOIL_RASTERS * at + (size_t)i] != 0)
			*soil_number_in(&soil, law->rasters[i].number) = soil_raster_value(&law->rasters[i], planes->levels[SOIL_RASTERS * at + (size_t)i]);
	if (law->layered)
		soil_end_layer(&soil);
	return soil;
}
