/*
 * Soils by name, and the planes a model keeps.
 *
 * n, k_c, k_phi, c, phi, K: Wong, Theory of Ground Vehicles, 2008, table 2.3, there in kN, kPa, cm and
 * degrees. Unit weight and the stiffness of unloading are not in it: a bulk density of the kind, and the
 * stiffness of the soft soil of Project Chrono's demonstrations (Krenn and Hirzinger 2009 leave it open).
 * sand, mud, snow: Sumner, O'Brien and Hodgins 1999, whose material constants could not be checked
 * against the paper itself; compression here is the share that is lost.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "deform/deform.h"

struct wong {
	const char *name;
	double n, k_c, k_phi, c, phi, k_cm, weight; /* as printed; weight kN/m3 */
};

static const struct wong wong[] = {
	{"dry_sand", 1.1, 0.99, 1528.43, 1.04, 28, 2, 16},
	{"sandy_loam_15", 0.7, 5.27, 1515.04, 1.72, 29, 2, 15},
	{"sandy_loam_22", 0.2, 2.56, 43.12, 1.38, 38, 2, 16},
	{"clayey_38", 0.5, 13.19, 692.15, 4.14, 13, 2, 16},
	{"heavy_clay_25", 0.13, 12.7, 1555.95, 68.95, 34, 0.6, 18},
	{"heavy_clay_40", 0.11, 1.84, 103.27, 20.69, 6, 3, 17},
	{"lean_clay_22", 0.2, 16.43, 1724.69, 68.95, 20, 0.6, 18},
	{"lete_sand", 0.79, 102, 5301, 1.3, 31.1, 1.2, 16},
	{"upland_loam_51", 1.1, 74.6, 2080, 3.3, 33.7, 2, 15},
	{"snow_us", 1.6, 4.37, 196.72, 1.03, 19.7, 3, 3},
	{"snow_sweden", 1.44, 10.55, 66.08, 6, 20.7, 3, 3},
	{"lunar", 1, 1.4, 820, 0.17, 35, 1.8, 2.5},
};

struct sumner {
	const char *name;
	double theta_in, theta_out, roughness, theta_stop, compression;
};

static const struct sumner sumner[] = {
	{"sand", 0.8, 0.436, 0.2, 0.8, 0.3},
	{"mud", 1.57, 1.1, 0.2, 1.1, 0.41},
	{"snow", 1.57, 1.57, 0.2, 1.57, 0},
};

#define COUNT(array) (sizeof(array) / sizeof(array)[0])
#define ELASTIC_STIFFNESS 4e7 /* Pa/m */
#define DAMPING 3e4           /* Pa s/m */

static double radians(double degrees)
{
	return degrees * (M_PI / 180);
}

static struct deform_soil of_wong(const struct wong *row)
{
	return (struct deform_soil){
		.bekker_kc = row->k_c * 1e3,
		.bekker_kphi = row->k_phi * 1e3,
		.bekker_n = row->n,
		.cohesion = row->c * 1e3,
		.friction_angle = radians(row->phi),
		.janosi_shear = row->k_cm / 100,
		.elastic_stiffness = ELASTIC_STIFFNESS,
		.damping = DAMPING,
		.unit_weight = row->weight * 1e3,
		.theta_in = sumner[0].theta_in,
		.theta_out = sumner[0].theta_out,
		.theta_stop = sumner[0].theta_stop,
		.roughness = sumner[0].roughness,
		.compression = sumner[0].compression,
		.repose = radians(row->phi),
	};
}

enum status deform_soil_named(const char *name, struct deform_soil *soil)
{
	char all[512] = "";
	for (size_t i = 0; i < COUNT(wong); i++) {
		if (strcmp(wong[i].name, name) == 0) {
			*soil = of_wong(&wong[i]);
			return STATUS_OK;
		}
		snprintf(all + strlen(all), sizeof all - strlen(all), "%s, ", wong[i].name);
	}
	for (size_t i = 0; i < COUNT(sumner); i++) {
		if (strcmp(sumner[i].name, name) == 0) {
			*soil = of_wong(&wong[i == 2 ? 9 : 0]); /* snow stands on snow_us, the others on dry_sand */
			soil->theta_in = sumner[i].theta_in;
			soil->theta_out = sumner[i].theta_out;
			soil->theta_stop = sumner[i].theta_stop;
			soil->roughness = sumner[i].roughness;
			soil->compression = sumner[i].compression;
			return STATUS_OK;
		}
		snprintf(all + strlen(all), sizeof all - strlen(all), "%s%s", sumner[i].name, i + 1 < COUNT(sumner) ? ", " : "");
	}
	return fail_with(STATUS_INPUT, "soil: there is none by that name; known are: %s", all);
}

unsigned deform_planes(enum deform_model model, bool dirt)
{
	unsigned planes = PLANE_BIT(PLANE_OFFSET) | (dirt ? PLANE_BIT(PLANE_DIRT) : 0);
	if (model == DEFORM_SCM)
		planes |= PLANE_BIT(PLANE_HEAPED) | PLANE_BIT(PLANE_PRESSED) | PLANE_BIT(PLANE_SHEAR);
	return planes;
}
