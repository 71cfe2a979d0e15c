/*
 * The soil's model on posts beside its closed forms and beside what was measured: a JSON line a figure.
 *
 * Numerical error is posts against the closed form of the same model, at falling spacings; model error is the closed
 * form against the measurement. `bench_validation quick` leaves the finest posts out.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"
#include "deform/reference/reference.h"
#include "validation_bed.h"

#define RADIANS (M_PI / 180)
#define RIM 3 /* posts of ground around what is done */

/* Smooth wheel of MIT's single-wheel rig, three trials averaged; the load was between 22 and 27 N. */
static const struct {
	double slip, millimetres;
} measured[] = {{-0.5, 23.7}, {-0.2, 15.1}, {0, 14.4}, {0.23, 17.9}, {0.5, 22.7}, {0.75, 25.4}, {0.9, 25.7}};
#define MEASURED (sizeof measured / sizeof *measured)
#define RADIUS 0.058
#define WIDTH 0.05
static const double loads[] = {24.5, 22, 27}; /* the middle, and the bounds */

static struct soil_numbers rig_soil(double slip)
{
	return (struct soil_numbers){
		.bekker_kphi = 8e6, .bekker_n = 1.46 + 0.01 * slip, .cohesion = 1e3, .friction_angle = 29 * RADIANS,
		.janosi_shear = 0.021, .elastic_stiffness = 4e7, .unit_weight = 13.03e3, .repose = 29 * RADIANS,
	};
}

static struct soil_pose at(double x, double y, double z, double spacing)
{
	return (struct soil_pose){lattice_offset(x * spacing), lattice_offset(y * spacing), lattice_offset(z), 0, 0, 0, 0};
}

struct rut {
	double sinkage, resistance, drawbar; /* m, N, N */
};

/* Rolls a wheel at a slip until its sinkage stands still; its axle over a post, its middle over one too. */
static struct rut rolled(const struct soil_numbers *soil, double load, double width, double radius, double slip,
			 double spacing)
{
	double deep = reference_arc(soil, load, width, radius, false), contact = radius * sin(acos(1 - deep / radius));
	int samples = (int)(1.5 * contact / spacing) + 1, far = (int)(radius / spacing) + RIM;
	int across = 2 * ((int)(width / 2 / spacing) + RIM) + 1;
	struct deform_forces forces;
	double work = 0;
	struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = radius, .width = width};
	struct deform_contact sweep = {.shape = &wheel, .load = load};
	struct rut rut;
	struct bed *bed = bed_create(2 * far + 1 + samples, across, spacing, soil);
	sweep.from = sweep.to = at(far, across / 2, radius, spacing);
	bed_press(bed, &sweep, &forces, &rut.sinkage, &work);
	sweep.turned = spacing / (radius * (1 - slip));
	for (int i = 1; i <= samples; i++) {
		sweep.from = sweep.to;
		sweep.to = at(far + i, across / 2, radius, spacing);
		bed_press(bed, &sweep, &forces, &rut.sinkage, &work);
	}
	rut.resistance = work / spacing;
	rut.drawbar = forces.force[0];
	bed_destroy(bed);
	return rut;
}

static void rig(const double *spacings, size_t count)
{
	static const struct {
		const char *name;
		double a0, a1;
	} sands[] = {{"loose", 0.18, 0.32}, {"compact", 0.43, 0.32}};
	for (size_t i = 0; i < MEASURED; i++) {
		double slip = measured[i].slip;
		struct soil_numbers soil = rig_soil(slip);
		printf("{\"what\": \"rig\", \"slip\": %g, \"measured_mm\": %g", slip, measured[i].millimetres);
		for (size_t s = 0; s < 2; s++) {
			struct reference_wheel wheel = {RADIUS, WIDTH, slip, sands[s].a0, sands[s].a1};
			printf(", \"wong_reece_%s_mm\": [", sands[s].name);
			for (size_t k = 0; k < 3; k++)
				printf("%s%.4f", k == 0 ? "" : ", ", reference_wong_reece_sinkage(&soil, &wheel, loads[k]) * 1e3);
			double sinkage = reference_wong_reece_sinkage(&soil, &wheel, loads[0]);
			printf("], \"wong_reece_%s_drawbar_n\": %.4f", sands[s].name, reference_wong_reece(&soil, &wheel, sinkage).drawbar);
		}
		printf(", \"scm_mm\": [");
		for (size_t k = 0; k < 3; k++)
			printf("%s%.4f", k == 0 ? "" : ", ", reference_arc(&soil, loads[k], WIDTH, RADIUS, true) * 1e3);
		printf("], \"posts\": {");
		for (size_t k = 0; k < count; k++) {
			struct rut rut = rolled(&soil, loads[0], WIDTH, RADIUS, slip, spacings[k]);
			printf("%s\"%g\": {\"mm\": %.4f, \"drawbar_n\": %.4f, \"resistance_n\": %.4f}", k == 0 ? "" : ", ",
			       spacings[k] * 1e3, rut.sinkage * 1e3, rut.drawbar, rut.resistance);
			fflush(stdout);
		}
		printf("}}\n");
	}
}

static void towed(void)
{
	static const struct {
		const char *soil;
		double load, width, diameter;
	} wheels[] = {{"lunar", 283, 0.23, 0.81}, {"dry_sand", 5000, 0.3, 1}};
	static const double spacings[] = {0.04, 0.02, 0.01};
	for (size_t i = 0; i < 2; i++) {
		struct soil_numbers soil;
		bench_must(soil_named(wheels[i].soil, &soil));
		double width = wheels[i].width, radius = wheels[i].diameter / 2, load = wheels[i].load;
		double bekker = reference_towed(&soil, load, width, 2 * radius), arc = reference_arc(&soil, load, width, radius, true);
		printf("{\"what\": \"towed\", \"soil\": \"%s\", \"bekker_mm\": %.4f, \"bekker_n\": %.4f, \"arc_mm\": %.4f, "
		       "\"elastic_arc_mm\": %.4f, \"elastic_arc_n\": %.4f, \"posts\": {",
		       wheels[i].soil, bekker * 1e3, reference_resistance(&soil, width, bekker),
		       reference_arc(&soil, load, width, radius, false) * 1e3, arc * 1e3,
		       reference_resistance(&soil, width, arc));
		for (size_t k = 0; k < 3; k++) {
			struct rut rut = rolled(&soil, load, width, radius, 0, spacings[k]);
			printf("%s\"%g\": [%.4f, %.4f]", k == 0 ? "" : ", ", spacings[k] * 1e3, rut.sinkage * 1e3, rut.resistance);
			fflush(stdout);
		}
		printf("}}\n");
	}
}

/* The mean pressure under a square plate that is pushed so deep, Pa: over its own area. */
static double pushed(const struct soil_numbers *soil, double side, double sinkage, double spacing)
{
	struct soil_shape plate = {.kind = SOIL_BOX, .size = {side, side, 1}};
	int posts = (int)(side / spacing) + 2 * RIM;
	struct soil_pose pose = at(posts / 2, posts / 2, 0.5 - sinkage, spacing);
	struct deform_contact sweep = {.shape = &plate, .from = pose, .to = pose};
	struct deform_forces forces;
	struct bed *bed = bed_create(posts, posts, spacing, soil);
	bed_press(bed, &sweep, &forces, NULL, NULL);
	bed_destroy(bed);
	return forces.force[2] / (side * side);
}

static void plates(void)
{
	static const char *const soils[] = {"dry_sand", "sandy_loam_15", "sandy_loam_22", "clayey_38", "heavy_clay_25", "heavy_clay_40",
					    "lean_clay_22", "lete_sand", "upland_loam_51", "snow_us", "snow_sweden", "lunar"};
	static const double millimetres[] = {1, 2, 5, 10, 20, 50, 100, 200}, spacings[] = {1.0 / 64, 1.0 / 256};
	double side = 0.1;
	for (size_t i = 0; i < sizeof soils / sizeof *soils; i++)
		for (size_t k = 0; k < sizeof millimetres / sizeof *millimetres; k++) {
			struct soil_numbers soil;
			bench_must(soil_named(soils[i], &soil));
			double sinkage = millimetres[k] / 1e3;
			printf("{\"what\": \"plate\", \"soil\": \"%s\", \"mm\": %g, \"closed_kpa\": %.6g", soils[i], millimetres[k],
			       reference_bekker(&soil, side, sinkage) / 1e3);
			printf(", \"posts_kpa\": {");
			for (size_t s = 0; s < 2; s++)
				printf("%s\"%g\": %.6g", s == 0 ? "" : ", ", spacings[s] * 1e3, pushed(&soil, side, sinkage, spacings[s]) / 1e3);
			printf("}}\n");
		}
}

/* A wheel with camber by the integral over its rim and lower side wall, at slip 0.2 under 1 kN. Side force: to its right, where it leans to. */
static void leaning(void)
{
	static const struct {
		const char *soil;
		double degrees;
	} rows[] = {{"dry_sand", 0}, {"dry_sand", 1}, {"dry_sand", 3},  {"dry_sand", 9},  {"dry_sand", 23}, {"lunar", 0},
		    {"lunar", 1},    {"lunar", 9},    {"clayey_38", 0}, {"clayey_38", 1}, {"clayey_38", 9}};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		struct soil_numbers soil;
		struct reference_leaning wheel = {.radius = 0.32, .width = 0.24, .camber = rows[i].degrees * RADIANS, .rolls = true, .turned = reference_turned(0.2)};
		bench_must(soil_named(rows[i].soil, &soil));
		wheel.sinkage = reference_leaning_sinkage(&soil, &wheel, 1000);
		const struct reference_wrench got = reference_leaning(&soil, &wheel);
		printf("{\"what\": \"leaning\", \"soil\": \"%s\", \"degrees\": %g, \"mm\": %.4f, \"drawbar_n\": %.4f, \"side_n\": %.4f}\n", rows[i].soil,
		       rows[i].degrees, wheel.sinkage * 1e3, got.force[0], -got.force[1]);
	}
}

int main(int argc, char **argv)
{
	static const double spacings[] = {0.004, 0.002, 0.001};
	plates();
	towed();
	leaning();
	rig(spacings, argc > 1 && strcmp(argv[1], "quick") == 0 ? 2 : 3);
	return 0;
}
