/* What a contact tells of the forces on its body, beside the law: slope of the ground, whether it slides, what its path must add. */
#include <math.h>

#include "bearing/internal.h"

/* Returns the mean slope of the base between two posts along an axis; 0: not known. */
static double slope_between(const struct soil_planes *planes, double spacing, int64_t x0, int64_t y0, int64_t x1, int64_t y1)
{
	const int32_t *base = planes->base;
	const int64_t mx = (x0 + x1) / 2, my = (y0 + y1) / 2;
#define POST(x, y) base[(size_t)((y) - planes->rect.y0) * planes->width + (size_t)((x) - planes->rect.x0)]
	int32_t first = POST(x0, y0), last = POST(x1, y1), middle = POST(mx, my);
#undef POST
	int64_t posts = x1 - x0 + y1 - y0;
	if (first == BASE_NODATA || last == BASE_NODATA) {
		posts = first == BASE_NODATA ? x1 - mx + y1 - my : mx - x0 + my - y0;
		first = first == BASE_NODATA ? middle : first;
		last = last == BASE_NODATA ? middle : last;
	}
	if (first == BASE_NODATA || last == BASE_NODATA || posts <= 0)
		return 0;
	return fmin(fmax(lattice_base_metres((int64_t)last - first) / ((double)posts * spacing), -1e4), 1e4);
}

/* Gives the mean slope of the base under the body: the ground as it was before all drives. */
static void put_slope(const struct bearing *bearing, const struct soil_motion *motion, double slope[2])
{
	const struct soil_planes *planes = &bearing->window.planes;
	const struct post_rect below = post_rect_intersect(soil_shadow(motion->shape, &motion->from, &motion->to, bearing->law.spacing), planes->rect);
	slope[0] = slope[1] = 0;
	if (post_rect_empty(below))
		return;
	const int64_t x0 = below.x0, y0 = below.y0, x1 = below.x1 - 1, y1 = below.y1 - 1, mx = (x0 + x1) / 2, my = (y0 + y1) / 2;
	slope[0] = slope_between(planes, bearing->law.spacing, x0, my, x1, my);
	slope[1] = slope_between(planes, bearing->law.spacing, mx, y0, mx, y1);
}

/* Returns true if a slope is too steep to hold a load: W sin a > c A + W cos a tan phi. c and phi are of the soil below the body's middle, or of the
 * body's surface. */
static bool slides(const struct bearing *bearing, const struct soil_motion *motion, const struct deform_forces *forces)
{
	const struct soil_planes *planes = &bearing->window.planes;
	const double steep = hypot(forces->slope[0], forces->slope[1]), sine = steep / hypot(1, steep);
	const int64_t x = (int64_t)llround(lattice_offset_metres(motion->to.x) / bearing->law.spacing), y = (int64_t)llround(lattice_offset_metres(motion->to.y) / bearing->law.spacing);
	const struct post_rect *rect = &planes->rect;
	size_t at = 0;
	if (x >= rect->x0 && x < rect->x1 && y >= rect->y0 && y < rect->y1)
		at = (size_t)(y - rect->y0) * planes->width + (size_t)(x - rect->x0);
	const struct soil_numbers soil = soil_numbers_at(&bearing->law, planes, at);
	return motion->load * sine > soil_shear_limit(&soil, &motion->interface, forces->area, motion->load * sqrt(1 - sine * sine));
}

/* The force that the path must add to the soil's, so that the body keeps its motion. */
static double residual_of(const struct deform_contact *contact, const struct deform_forces *forces)
{
	const double ahead[2] = {cos(contact->to.yaw), sin(contact->to.yaw)}, *force = forces->force;
	const double rise = forces->slope[0] * ahead[0] + forces->slope[1] * ahead[1], weight = contact->load > 0 ? contact->load : force[2];
	return -(force[0] * ahead[0] + force[1] * ahead[1] + (force[2] - weight) * rise) / hypot(1, rise);
}

void bearing_tell(const struct bearing *bearing, const struct deform_contact *contact, const struct soil_motion *motion, const struct soil_forces *from,
		  struct deform_forces *forces)
{
	static const enum deform_state states[SOIL_STATES] = {DEFORM_TOUCHING, DEFORM_SLIDES, DEFORM_SUNK, DEFORM_AIR};
	*forces = (struct deform_forces){.tag = contact->tag, .sinkage = fmax(from->sinkage, 0), .area = from->area, .pull = from->pull, .z = from->z,
					 .saturated = from->saturated, .state = states[from->state]};
	memcpy(forces->force, from->force, sizeof forces->force);
	memcpy(forces->moment, from->moment, sizeof forces->moment);
	put_slope(bearing, motion, forces->slope);
	if (!(forces->area > 0) && forces->state != DEFORM_SUNK)
		forces->state = DEFORM_AIR;
	if (forces->state == DEFORM_TOUCHING && contact->load > 0 && slides(bearing, motion, forces))
		forces->state = DEFORM_SLIDES;
	if (forces->area > 0)
		forces->residual = residual_of(contact, forces);
}
