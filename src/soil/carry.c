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

#define HALVINGS 40
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

/* Returns Bekker's pressure at a sinkage, with the elastic limit, Pa. width: of the contact patch, m. */
static double bekker(const struct soil_numbers *soil, double width, double sinkage)
{
	return fmin((soil->bekker_kc / width + soil->bekker_kphi) * pow(sinkage, soil->bekker_n), soil->elastic_stiffness * sinkage);
}

/* Returns the pressure of soil that may lie over another one: law/layers.h. */
static double pressure_at(const struct soil_numbers *soil, double width, double sinkage)
{
	if (soil->over == NULL)
		return (soil->bekker_kc / width + soil->bekker_kphi) * pow(sinkage, soil->bekker_n);
	if (!(sinkage > 0))
		return 0;
	const double own = bekker(soil, width, sinkage), ratio = soil_is_rigid(soil->over) ? 0 : own / bekker(soil->over, width, sinkage);
	const double used = sinkage * fmax(1 - ratio, 0), wide = width * ratio, c = wide + used - soil->thickness, root = sqrt(c * c + 4 * soil->thickness * wide);
	const double left = fmax(c > 0 ? 2 * soil->thickness * wide / (c + root) : (root - c) / 2, 1e-5);
	return own * (left + width) / (left + wide);
}

/* Returns the wheel as which a shape that is no box is guessed. */
static struct soil_shape as_wheel(const struct soil_shape *shape)
{
	const double radius = shape->kind == SOIL_ELLIPSOID ? cbrt(shape->size[0] * shape->size[1] * shape->size[2]) : shape->radius;
	return (struct soil_shape){.kind = SOIL_WHEEL, .radius = radius, .width = shape->kind == SOIL_WHEEL ? shape->width : shape->kind == SOIL_CYLINDER ? shape->length : radius};
}

/* The same as soil_sinkage_guess of a layer. */
static double guess_of_layer(const struct soil_shape *given, const struct soil_numbers *soil, double load)
{
	const struct soil_interface smooth = {.has_friction = true, .has_adhesion = true};
	const struct soil_shape wheel = as_wheel(given), *shape = given->kind == SOIL_BOX ? given : &wheel;
	double low = 0, high = soil_shape_reach(given, 0, 0);
	if (given->kind == SOIL_MESH)
		return 0;
	for (int i = 0; i < HALVINGS; i++) {
		const double middle = (low + high) / 2;
		*(soil_load_at(shape, &smooth, 0, soil, middle) < load ? &low : &high) = middle;
	}
	return low;
}

double soil_sinkage_guess(const struct soil_shape *shape, const struct soil_numbers *given, double load)
{
	struct soil_numbers ended = *given;
	const struct soil_numbers *soil = &ended;
	soil_end_layer(&ended);
	if (soil->over != NULL)
		return guess_of_layer(shape, soil, load);
	if (soil_is_hard(soil)) { /* a spring alone */
		ended.bekker_kc = 0;
		ended.bekker_kphi = soil->elastic_stiffness;
		ended.bekker_n = 1;
	}
	double n = soil->bekker_n, sinkage;
	if (shape->kind == SOIL_BOX) {
		double width = fmin(shape->size[0], shape->size[1]), k = soil->bekker_kc / width + soil->bekker_kphi;
		sinkage = pow(load / (shape->size[0] * shape->size[1] * k), 1 / n);
	} else if (shape->kind == SOIL_MESH) {
		sinkage = 0;
	} else {
		const struct soil_shape wheel = as_wheel(shape);
		const double radius = wheel.radius, width = wheel.width;
		double k = soil->bekker_kc / width + soil->bekker_kphi;
		sinkage = pow(3 * load / (width * k * fmax(3 - n, 0.1) * sqrt(2 * radius)), 2 / (2 * n + 1));
	}
	double most = soil_shape_reach(shape, 0, 0);
	return sinkage < most ? sinkage : most;
}

double soil_stiffens(const struct soil_shape *shape, const struct soil_numbers *given, double sinkage)
{
	const double width = shape->kind == SOIL_BOX ? fmin(shape->size[0], shape->size[1]) : shape->kind == SOIL_MESH ? soil_shape_bound(shape) : as_wheel(shape).width;
	struct soil_numbers soil = *given, springs = {.bekker_kphi = 0}, below = {.bekker_kphi = 0};
	soil_end_layer(&soil);
	if (soil.over == NULL)
		return fmax(soil.elastic_stiffness / given->elastic_stiffness, 1);
	/* The elastic curve is the law of two soils that spring alone. */
	springs.bekker_kphi = springs.elastic_stiffness = soil.elastic_stiffness;
	springs.bekker_n = below.bekker_n = 1;
	springs.thickness = soil.thickness;
	below.bekker_kphi = soil_is_rigid(soil.over) ? INFINITY : soil.over->elastic_stiffness;
	below.elastic_stiffness = soil.over->elastic_stiffness;
	springs.over = &below;
	const double apart = 0.01 * soil.thickness, high = fmin(sinkage, soil_is_rigid(soil.over) ? 0.98 * soil.thickness : sinkage);
	const double rises = pressure_at(&springs, width, high + apart) - pressure_at(&springs, width, fmax(high - apart, 0));
	return fmax(rises / (apart + fmin(high, apart)) / soil.elastic_stiffness, 1);
}

static double wheel(const struct soil_shape *shape, const struct soil_interface *interface, double slip, const struct soil_numbers *soil,
		    double sinkage)
{
	const double radius = shape->radius;
	const double cohesion = fmin(interface->has_adhesion ? interface->adhesion : soil_own_adhesion(soil->cohesion), soil->cohesion);
	const double friction = tan(interface->has_friction ? fmin(interface->friction_angle, soil->friction_angle) : soil->friction_angle);
	const double enters = acos(fmax(1 - sinkage / radius, 0));
	double sum = 0;
	for (int i = 0; i < PIECES; i++) {
		const double a = enters * (i + 0.5) / PIECES, pressure = pressure_at(soil, shape->width, fmax(sinkage - radius * (1 - cos(a)), 0));
		const double sheared = radius * ((enters - a) - (1 - slip) * (sin(enters) - sin(a)));
		const double shear = (soil_touching_share(soil, pressure) * cohesion + pressure * friction) * (1 - exp(-fmax(sheared, 0) / soil->janosi_shear));
		sum += pressure * cos(a) + shear * sin(a);
	}
	return shape->width * radius * sum * enters / PIECES;
}

double soil_load_at(const struct soil_shape *shape, const struct soil_interface *interface, double slip, const struct soil_numbers *given,
		    double sinkage)
{
	struct soil_numbers soil = *given;
	soil_end_layer(&soil);
	if (shape->kind == SOIL_WHEEL)
		return wheel(shape, interface, slip, &soil, sinkage);
	if (shape->kind == SOIL_BOX)
		return shape->size[0] * shape->size[1] * pressure_at(&soil, fmin(shape->size[0], shape->size[1]), sinkage);
	return INFINITY;
}
