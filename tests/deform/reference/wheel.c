/*
 * Closed forms of terramechanics, to hold the posts to: Bekker's pressure and sinkage, Janosi's and Hanamoto's
 * shear, Bekker's towed wheel, and the stresses along the rim after Wong and Reece, integrated by Simpson's rule.
 */
#include <math.h>

#include "deform/reference/reference.h"

#define PIECES 2000 /* of an integral: even */

double reference_stiffness(const struct soil_numbers *soil, double width)
{
	return fmax(soil->bekker_kc / width + soil->bekker_kphi, 0);
}

double reference_bekker(const struct soil_numbers *soil, double width, double sinkage)
{
	return reference_stiffness(soil, width) * pow(sinkage, soil->bekker_n);
}

double reference_plate(const struct soil_numbers *soil, double width, double pressure)
{
	return pow(pressure / reference_stiffness(soil, width), 1 / soil->bekker_n);
}

double reference_strength(const struct soil_numbers *soil, const struct soil_interface *interface, double pressure)
{
	double touches = soil->cohesion > pressure ? pressure / soil->cohesion : 1;
	double own = touches * soil->cohesion + pressure * tan(soil->friction_angle);
	double rubs = pressure * tan(interface->has_friction ? interface->friction_angle : soil->friction_angle);
	return fmin(own, rubs + touches * (interface->has_adhesion ? interface->adhesion : reference_adhesion(soil->cohesion)));
}

/* Kilopascals of a table of cohesion and adhesion; between its rows by straight lines, and beyond the last one on. */
double reference_adhesion(double cohesion)
{
	static const double table[][2] = {{0, 0}, {23.94, 23.94}, {47.88, 35.91}, {95.76, 45.486}, {191.52, 62.244}};
	const double c = cohesion / 1000;
	size_t row = 1;
	while (row < sizeof table / sizeof table[0] - 1 && c > table[row][0])
		row++;
	const double *low = table[row - 1], *high = table[row];
	return 1000 * (low[1] + (c - low[0]) * (high[1] - low[1]) / (high[0] - low[0]));
}

double reference_janosi(const struct soil_numbers *soil, double pressure, double displacement)
{
	return (soil->cohesion + pressure * tan(soil->friction_angle)) * (1 - exp(-displacement / soil->janosi_shear));
}

double reference_towed(const struct soil_numbers *soil, double load, double width, double diameter)
{
	double n = soil->bekker_n;
	return pow(3 * load / (width * reference_stiffness(soil, width) * (3 - n) * sqrt(diameter)), 2 / (2 * n + 1));
}

double reference_resistance(const struct soil_numbers *soil, double width, double sinkage)
{
	double n = soil->bekker_n;
	return width * reference_stiffness(soil, width) * pow(sinkage, n + 1) / (n + 1);
}

/* Weights of Simpson's rule, 1 4 2 4 ... 1, over 3 pieces. */
static double weight(int i)
{
	return (i == 0 || i == PIECES ? 1.0 : i % 2 == 1 ? 4.0 : 2.0) / (3.0 * PIECES);
}

double reference_arc_load(const struct soil_numbers *soil, double sinkage, double width, double radius, bool rebound)
{
	double front = acos(1 - sinkage / radius), sum = 0;
	double most = reference_bekker(soil, width, sinkage), stays = fmax(0, sinkage - most / soil->elastic_stiffness);
	double behind = acos(1 - (sinkage - stays) / radius);
	for (int i = 0; i <= PIECES && sinkage > 0; i++) {
		/* From the point of contact; with its square the integrand is smooth there, as sqrt(z) is not. */
		double u = (double)i / PIECES, angle = front * (1 - u * u);
		double deep = fmax(0, sinkage - radius * (1 - cos(angle)));
		sum += weight(i) * reference_bekker(soil, width, deep) * radius * cos(angle) * front * 2 * u;
		if (!rebound)
			continue;
		angle = behind * u;
		deep = sinkage - radius * (1 - cos(angle));
		sum += weight(i) * most * fmax(0, deep - stays) / (sinkage - stays) * radius * cos(angle) * behind;
	}
	return width * sum;
}

double reference_arc(const struct soil_numbers *soil, double load, double width, double radius, bool rebound)
{
	double low = 0, high = radius;
	for (int i = 0; i < 60; i++) {
		double middle = (low + high) / 2;
		if (reference_arc_load(soil, middle, width, radius, rebound) < load)
			low = middle;
		else
			high = middle;
	}
	return high;
}

struct reference_wheel_forces reference_wong_reece(const struct soil_numbers *soil, const struct reference_wheel *wheel,
						   double sinkage)
{
	double r = wheel->radius, entry = acos(1 - sinkage / r), leave = 0;
	double most = fmin(fmax(wheel->a0 + wheel->a1 * wheel->slip, 0), 1) * entry;
	struct reference_wheel_forces forces = {0};
	/* In two parts: the stress has a kink where it is greatest. */
	for (int part = 0; part < 2; part++) {
		double from = part == 0 ? leave : most, to = part == 0 ? most : entry;
		for (int i = 0; i <= PIECES && to > from; i++) {
			double u = (double)i / PIECES, angle = to - (to - from) * u * u;
			double like = part == 1 ? angle : entry - (angle - leave) * (entry - most) / (most - leave);
			double normal = reference_stiffness(soil, wheel->width) *
					pow(r * fmax(0, cos(like) - cos(entry)), soil->bekker_n);
			double moved = r * (entry - angle - (1 - wheel->slip) * (sin(entry) - sin(angle)));
			double shear = copysign(reference_janosi(soil, normal, fabs(moved)), moved);
			double piece = weight(i) * (to - from) * 2 * u * r * wheel->width;
			forces.load += piece * (normal * cos(angle) + shear * sin(angle));
			forces.drawbar += piece * (shear * cos(angle) - normal * sin(angle));
			forces.torque += piece * r * shear;
		}
	}
	return forces;
}

double reference_wong_reece_sinkage(const struct soil_numbers *soil, const struct reference_wheel *wheel, double load)
{
	double low = 0, high = wheel->radius;
	for (int i = 0; i < 60; i++) {
		double middle = (low + high) / 2;
		if (reference_wong_reece(soil, wheel, middle).load < load)
			low = middle;
		else
			high = middle;
	}
	return high;
}
