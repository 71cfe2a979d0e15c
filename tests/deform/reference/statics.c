/*
 * Bodies at rest on scm soil: a plate on a slope, and plates and spheres that settle on level ground.
 * The pressure is p(z) = min(K_s z^n, K_e z), z the sinkage along the ground's normal. Nothing is damped.
 */
#include <math.h>

#include "deform/reference/reference.h"

double reference_yield_crossing(const struct soil_numbers *soil, double width)
{
	double n = soil->bekker_n;
	return n == 1 ? INFINITY : pow(reference_stiffness(soil, width) / soil->elastic_stiffness, 1 / (1 - n));
}

double reference_yield(const struct soil_numbers *soil, double width, double sinkage)
{
	return fmin(reference_bekker(soil, width, sinkage), soil->elastic_stiffness * sinkage);
}

double reference_yield_sinkage(const struct soil_numbers *soil, double width, double pressure)
{
	return fmax(reference_plate(soil, width, pressure), pressure / soil->elastic_stiffness);
}

/* The integral of z^power p(z) from 0 to the sinkage. */
static double integral(const struct soil_numbers *soil, double width, double sinkage, int power)
{
	double n = soil->bekker_n, k = reference_stiffness(soil, width), stiff = soil->elastic_stiffness;
	double kink = fmin(reference_yield_crossing(soil, width), sinkage);
	double bekker = n + power + 1, elastic = power + 2;
	if (n < 1)
		return stiff * pow(kink, elastic) / elastic + k * (pow(sinkage, bekker) - pow(kink, bekker)) / bekker;
	if (n == 1)
		return fmin(k, stiff) * pow(sinkage, elastic) / elastic;
	return k * pow(kink, bekker) / bekker + stiff * (pow(sinkage, elastic) - pow(kink, elastic)) / elastic;
}

double reference_yield_work(const struct soil_numbers *soil, double width, double sinkage)
{
	return integral(soil, width, sinkage, 0);
}

double reference_plate_at_once(const struct soil_numbers *soil, double width, double pressure)
{
	double low = reference_yield_sinkage(soil, width, pressure), high = 2 * low;
	while (reference_yield_work(soil, width, high) < pressure * high)
		high *= 2;
	for (int i = 0; i < 80; i++) {
		double middle = (low + high) / 2;
		if (reference_yield_work(soil, width, middle) < pressure * middle)
			low = middle;
		else
			high = middle;
	}
	return high;
}

double reference_sphere_load(const struct soil_numbers *soil, double radius, double sinkage)
{
	double patch = sqrt(sinkage * (2 * radius - sinkage));
	if (sinkage <= 0)
		return 0;
	return 2 * M_PI * ((radius - sinkage) * integral(soil, patch, sinkage, 0) + integral(soil, patch, sinkage, 1));
}

double reference_sphere(const struct soil_numbers *soil, double load, double radius)
{
	double low = 0, high = radius;
	if (reference_sphere_load(soil, radius, radius) < load)
		return (double)NAN;
	for (int i = 0; i < 80; i++) {
		double middle = (low + high) / 2;
		if (reference_sphere_load(soil, radius, middle) < load)
			low = middle;
		else
			high = middle;
	}
	return high;
}

/* What is left along the slope of a load, and how much of it the soil holds. All of it, up to Coulomb's limit. */
static struct reference_rest at_rest(double normal, double limit, double load, double slope)
{
	double along = load * sin(slope), shear = fmin(along, limit);
	return (struct reference_rest){.normal = normal, .shear = shear, .residual = along - shear,
				       .vertical = normal * cos(slope) + shear * sin(slope)};
}

struct reference_rest reference_rest_flat(const struct soil_numbers *soil, double length, double width, double load,
					  double slope)
{
	const struct soil_interface none = {.has_friction = false};
	const double area = length * width;
	double normal = load * cos(slope);
	if (load * sin(slope) > area * reference_strength(soil, &none, normal / area)) { /* its guide carries it: N cos a + S(N) sin a = W */
		double low = 0, high = load / cos(slope);
		for (int i = 0; i < 80; i++) {
			normal = (low + high) / 2;
			const double carried = normal * cos(slope) + area * reference_strength(soil, &none, normal / area) * sin(slope);
			*(carried < load ? &low : &high) = normal;
		}
	}
	struct reference_rest rest = at_rest(normal, area * reference_strength(soil, &none, normal / area), load, slope);
	rest.sinkage = reference_yield_sinkage(soil, fmin(length, width), normal / area);
	return rest;
}

/* A level box whose upper edge lies `deep` below the ground there, both vertically. */
static struct reference_rest level_at(const struct soil_numbers *soil, double length, double width, double load, double slope,
				      double deep)
{
	double b = fmin(length, width), reach = fmin(length, deep / tan(slope)); /* horizontal */
	double upper = deep * cos(slope), lower = (deep - reach * tan(slope)) * cos(slope);
	double work = reference_yield_work(soil, b, upper) - reference_yield_work(soil, b, fmax(0, lower));
	double normal = width * work / (cos(slope) * sin(slope));
	/* Above the depth at which the pressure is the cohesion it touches in part. */
	double limit = normal * tan(soil->friction_angle);
	if (soil->cohesion > 0) {
		double whole = fmin(fmax(reference_yield_sinkage(soil, b, soil->cohesion), lower), upper);
		double in_part = width * (reference_yield_work(soil, b, whole) - reference_yield_work(soil, b, fmax(0, lower))) / (cos(slope) * sin(slope));
		double wholly = soil->cohesion * width * reach / cos(slope) * (upper - whole) / (upper - lower);
		limit += reference_adhesion(soil->cohesion) / soil->cohesion * (in_part + wholly);
	}
	struct reference_rest rest = at_rest(normal, limit, load, slope);
	rest.sinkage = upper;
	return rest;
}

struct reference_rest reference_rest_level(const struct soil_numbers *soil, double length, double width, double load,
					   double slope)
{
	if (slope <= 0)
		return reference_rest_flat(soil, length, width, load, 0);
	double low = 0, high = length;
	while (level_at(soil, length, width, load, slope, high).vertical < load)
		high *= 2;
	for (int i = 0; i < 100; i++) {
		double middle = (low + high) / 2;
		if (level_at(soil, length, width, load, slope, middle).vertical < load)
			low = middle;
		else
			high = middle;
	}
	return level_at(soil, length, width, load, slope, high);
}
