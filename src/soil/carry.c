/*
 * What soil can carry, by closed forms: shear force, sinkage under a load, load at a sinkage.
 * The last two follow the law of scm on level ground, without the heaps beside the body. They tell before a drive what a soil cannot carry.
 * A drive itself searches the equilibrium over its posts.
 *
 * A wheel that rolls touches the soil ahead of its axle only. There the soil acts across the rim by Bekker's law, and shears along it by
 * Janosi's and Hanamoto's. Where z0 is the sinkage and a the angle from straight down:
 *
 *     W = b R int_0^a1 (p cos(a) + t sin(a)) da,    p = (k_c / b + k_phi) (z0 - R (1 - cos(a)))^n
 *     t = (min(p / c, 1) c + p tan(phi)) (1 - exp(-j / K)),       j = R ((a1 - a) - (1 - s) (sin(a1) - sin(a)))
 *
 * a1 is where the rim enters the soil, at most a quarter of a turn. A box bears as a plate.
 */
#include "soil/soil.h"

#include <math.h>

#define PIECES 64 /* of the rim: the sum is off by less than 0.1 % */

double soil_shear_limit(const struct soil_numbers *soil, const struct soil_interface *interface, double area, double normal)
{
	double adhesion = interface->has_adhesion ? interface->adhesion : soil_own_adhesion(soil->cohesion);
	double angle = interface->has_friction ? interface->friction_angle : soil->friction_angle;
	double touches = soil_touching_share(soil, normal / area);
	return fmin(touches * soil->cohesion * area + normal * tan(soil->friction_angle), touches * adhesion * area + normal * tan(angle));
}

double soil_own_adhesion(double cohesion)
{
	return fmin(fmin(cohesion, 11970 + 0.5 * cohesion), fmin(26334 + 0.2 * cohesion, 28728 + 0.175 * cohesion));
}

double soil_touching_share(const struct soil_numbers *soil, double stress)
{
	return soil->cohesion > 0 ? fmin(fmax(stress, 0) / soil->cohesion, 1) : 1;
}

double soil_sinkage_guess(const struct soil_shape *shape, const struct soil_numbers *soil, double load)
{
	double n = soil->bekker_n, sinkage;
	if (shape->kind == SOIL_BOX) {
		double width = fmin(shape->size[0], shape->size[1]), k = soil->bekker_kc / width + soil->bekker_kphi;
		sinkage = pow(load / (shape->size[0] * shape->size[1] * k), 1 / n);
	} else if (shape->kind == SOIL_MESH) {
		sinkage = 0;
	} else {
		double radius = shape->kind == SOIL_ELLIPSOID ? cbrt(shape->size[0] * shape->size[1] * shape->size[2]) : shape->radius;
		double width = shape->kind == SOIL_WHEEL ? shape->width : shape->kind == SOIL_CYLINDER ? shape->length : radius;
		double k = soil->bekker_kc / width + soil->bekker_kphi;
		sinkage = pow(3 * load / (width * k * fmax(3 - n, 0.1) * sqrt(2 * radius)), 2 / (2 * n + 1));
	}
	double most = soil_shape_reach(shape, 0, 0);
	return sinkage < most ? sinkage : most;
}

static double wheel(const struct soil_shape *shape, const struct soil_interface *interface, double slip, const struct soil_numbers *soil,
		    double sinkage)
{
	const double radius = shape->radius, k = soil->bekker_kc / shape->width + soil->bekker_kphi;
	const double cohesion = fmin(interface->has_adhesion ? interface->adhesion : soil_own_adhesion(soil->cohesion), soil->cohesion);
	const double friction = tan(interface->has_friction ? fmin(interface->friction_angle, soil->friction_angle) : soil->friction_angle);
	const double enters = acos(fmax(1 - sinkage / radius, 0));
	double sum = 0;
	for (int i = 0; i < PIECES; i++) {
		const double a = enters * (i + 0.5) / PIECES, pressure = k * pow(fmax(sinkage - radius * (1 - cos(a)), 0), soil->bekker_n);
		const double sheared = radius * ((enters - a) - (1 - slip) * (sin(enters) - sin(a)));
		const double shear = (soil_touching_share(soil, pressure) * cohesion + pressure * friction) * (1 - exp(-fmax(sheared, 0) / soil->janosi_shear));
		sum += pressure * cos(a) + shear * sin(a);
	}
	return shape->width * radius * sum * enters / PIECES;
}

double soil_load_at(const struct soil_shape *shape, const struct soil_interface *interface, double slip, const struct soil_numbers *soil,
		    double sinkage)
{
	if (shape->kind == SOIL_WHEEL)
		return wheel(shape, interface, slip, soil, sinkage);
	if (shape->kind == SOIL_BOX)
		return shape->size[0] * shape->size[1] * (soil->bekker_kc / fmin(shape->size[0], shape->size[1]) + soil->bekker_kphi) *
		       pow(sinkage, soil->bekker_n);
	return INFINITY;
}
