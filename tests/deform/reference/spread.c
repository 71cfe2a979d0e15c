/*
 * What a press has lifted is laid down in bands beside the patch that the object touches. A post gets soil in proportion to its
 * weight. The weight is the height of the band's profile at the post's distance from the patch.
 */
#include <math.h>

#include "deform/reference/reference.h"

#define BAND_POSTS 95 /* the widest, of posts */

enum { AHEAD, BEHIND, LEFT, RIGHT, FACES };

/* The patch, in the frame in which the object goes: x ahead, y to the left, from its centre; metres. */
struct patch {
	double ahead[2];                      /* the x axis */
	double low[2], high[2];               /* the rectangle around it */
	double beside;                        /* the most |x| of soil that is laid to the left and right */
	double behind;                        /* a wheel that goes on: the length over which it is, from there behind on; 0: it does not */
	double rolls;                         /* the share that is not pushed */
	double depth, carried, shares[FACES];
	bool around, any;
};

static bool is_written(const struct reference_ground *ground, int x, int y)
{
	return x >= ground->written.x0 && x < ground->written.x1 && y >= ground->written.y0 && y < ground->written.y1;
}

static void place_of(const struct reference_ground *ground, const struct patch *patch, const struct deform_contact *sweep, int at,
		     double place[2])
{
	double x = (double)(ground->left + at % ground->width) * ground->spacing - lattice_offset_metres(sweep->to.x);
	double y = (double)(ground->bottom + at / ground->width) * ground->spacing - lattice_offset_metres(sweep->to.y);
	place[0] = x * patch->ahead[0] + y * patch->ahead[1];
	place[1] = y * patch->ahead[0] - x * patch->ahead[1];
}

/* Of the displaced soil how much is laid, and the tangent of the angle at which it is. */
static double laid(const struct deform_params *params, double *tangent)
{
	const struct soil_numbers *soil = &params->soils[0];
	double angle = params->model == DEFORM_SLIPPAGE ? soil->friction_angle : fmin(soil->theta_out, soil->theta_stop);
	*tangent = fmax(0.01, tan(fmin(angle, M_PI / 4)));
	return params->model == DEFORM_SLIPPAGE ? 1 : 1 - soil->compression;
}

/* To which faces of the rectangle the soil goes. `turned`: a wheel's way along its rim. */
static void share(struct patch *patch, const struct deform_contact *sweep, double spacing)
{
	double way[3] = {lattice_offset_metres(sweep->to.x - sweep->from.x), lattice_offset_metres(sweep->to.y - sweep->from.y),
			 lattice_offset_metres(sweep->to.z - sweep->from.z)};
	double length = deform_is_contact_only(sweep) ? 0 : hypot(way[0], way[1]), heading = sweep->to.yaw, x = 0, y = 0;
	bool wheel = sweep->shape->kind == SOIL_WHEEL, runs = sweep->shape->belt && (length > fabs(way[2]) || sweep->turned != 0);
	if (wheel || runs) {
		double forward = way[0] * cos(heading) + way[1] * sin(heading), rim = sweep->turned * (wheel ? sweep->shape->radius : 1);
		double left = way[1] * cos(heading) - way[0] * sin(heading);
		bool brakes = rim * forward >= 0 && fabs(rim) < fabs(forward);
		if (wheel && length > 0 && length >= fabs(way[2]))
			patch->behind = copysign(fmax(fmax(fabs(forward), spacing), 0.375 * sweep->shape->radius) +
						 left * left / (length * length) * sweep->shape->radius, forward);
		x = length > 0 && brakes ? (forward - rim) / length : 0;
		y = length > 0 ? left / length : 0;
	} else if (length > fabs(way[2])) {
		heading = atan2(way[1], way[0]);
		x = 1;
	} else {
		patch->around = true;
		heading = 0;
	}
	patch->ahead[0] = cos(heading);
	patch->ahead[1] = sin(heading);
	/* A body that rolls lays half to each side. One that pushes lays half ahead, and a quarter to each side of its way. */
	double rolls = patch->rolls = fmax(0, 1 - x * x - y * y);
	patch->shares[AHEAD] = y * y / 4 + (x > 0 ? x * x / 2 : 0);
	patch->shares[BEHIND] = y * y / 4 + (x > 0 ? 0 : x * x / 2);
	patch->shares[LEFT] = rolls / 2 + x * x / 4 + (y > 0 ? y * y / 2 : 0);
	patch->shares[RIGHT] = rolls / 2 + x * x / 4 + (y > 0 ? 0 : y * y / 2);
}

static void measure(const struct reference_ground *ground, const struct deform_params *params, const struct deform_contact *sweep,
		    struct patch *patch)
{
	double tangent, share_laid = laid(params, &tangent);
	for (int k = 0; k < 2; k++) {
		patch->low[k] = INFINITY;
		patch->high[k] = -INFINITY;
	}
	for (int i = 0; i < ground->width * ground->height; i++) {
		double place[2];
		if (ground->contact[i] == 0 || ground->hole[i] || !is_written(ground, i % ground->width, i / ground->width))
			continue;
		place_of(ground, patch, sweep, i, place);
		for (int k = 0; k < 2; k++) {
			patch->low[k] = fmin(patch->low[k], place[k] - ground->spacing / 2);
			patch->high[k] = fmax(patch->high[k], place[k] + ground->spacing / 2);
		}
		patch->carried += ground->carried[i];
		double deep = fmin(fmax(-ground->offset[i], 0), 8);
		patch->depth = fmax(patch->depth, fmax(ground->carried[i], share_laid * deep));
		patch->any = true;
	}
	patch->beside = INFINITY;
	if (sweep->shape->kind != SOIL_WHEEL)
		return;
	patch->low[1] = -sweep->shape->width / 2;
	patch->high[1] = sweep->shape->width / 2;
	patch->beside = fmax(sweep->shape->radius / (patch->behind != 0 ? 1 : 2), ground->spacing);
}

/* Lengths are whole 64ths of a post. */
static double whole(const struct reference_ground *ground, double length)
{
	return floor(length * 64 / ground->spacing + 1e-9) * ground->spacing / 64;
}

/* A band holds what the hollow beside it gave away, at the angle of repose. */
static double width_of(const struct reference_ground *ground, const struct deform_params *params, const struct deform_contact *sweep,
		       const struct patch *patch)
{
	const struct soil_shape *shape = sweep->shape;
	double along = patch->high[0] - patch->low[0], across = patch->high[1] - patch->low[1], tangent;
	/* The area beside a metre of contour. */
	double pushed = patch->shares[AHEAD] + patch->shares[BEHIND] - fabs(patch->shares[AHEAD] - patch->shares[BEHIND]);
	double beside = patch->around ? along * across / (2 * (along + across)) : (across * (1 - 2 * pushed) + along * 2 * pushed) / 2;
	double widest = shape->kind == SOIL_WHEEL ? shape->width : shape->radius;
	if (shape->kind == SOIL_MESH)
		widest = soil_shape_bound(shape) / 2;
	if (shape->kind == SOIL_BOX) { /* neither the least nor the largest of its sizes */
		const double *s = shape->size;
		widest = s[0] + s[1] + s[2] - fmin(fmin(s[0], s[1]), s[2]) - fmax(fmax(s[0], s[1]), s[2]);
	}
	laid(params, &tangent);
	double width = fmax(sqrt(4.5 * patch->depth * beside / tangent), fmax(beside / 4, 2 * ground->spacing));
	return fmin(whole(ground, width), ceil(64 * fmin(fmax(widest / ground->spacing, 2), BAND_POSTS)) * ground->spacing / 64);
}

static double profile(const struct reference_ground *ground, double from_edge, double width)
{
	double at = whole(ground, from_edge);
	return fmax(0, fmin(whole(ground, width / 3), fmin(at, width - at)));
}

static double distance_to(const struct reference_ground *ground, int at, double most)
{
	int far = (int)ceil(most / ground->spacing) + 1, x = at % ground->width, y = at / ground->width;
	double least = INFINITY;
	for (int j = y - far; j <= y + far; j++)
		for (int i = x - far; i <= x + far; i++)
			if (i >= 0 && j >= 0 && i < ground->width && j < ground->height && is_written(ground, i, j) &&
			    ground->contact[j * ground->width + i] != 0 && !ground->hole[j * ground->width + i])
				least = fmin(least, hypot(i - x, j - y) * ground->spacing);
	return least - ground->spacing / 2;
}

/* `undecided`: a post lies so close to an end of the rectangle that it may count or not. */
static double weight_of(const struct reference_ground *ground, const struct deform_contact *sweep, const struct patch *patch,
			double width, int at, int *face, bool *undecided)
{
	double place[2], near = 0.003 * ground->spacing;
	*face = AHEAD;
	if (ground->contact[at] != 0 || ground->hole[at] || !is_written(ground, at % ground->width, at / ground->width))
		return 0;
	if (patch->around)
		return profile(ground, distance_to(ground, at, width), width);
	place_of(ground, patch, sweep, at, place);
	double along = fmax(place[0] - patch->high[0], patch->low[0] - place[0]);
	double aside = fmax(place[1] - patch->high[1], patch->low[1] - place[1]);
	bool rolls = patch->behind != 0;
	double from_end = patch->beside + (patch->behind > 0 ? place[0] : -place[0]);
	bool ends = fabs(along) < near || fabs(fabs(place[0]) - patch->beside) < near || (rolls && fabs(from_end - fabs(patch->behind)) < near);
	*undecided |= (ends && profile(ground, aside, width) > 0) || (fabs(aside) < near && profile(ground, along, width) > 0);
	if (rolls ? aside > 0 : along <= 0) {
		*face = place[1] > 0 ? LEFT : RIGHT;
		bool there = rolls ? from_end >= 0 && from_end < fabs(patch->behind) : fabs(place[0]) <= patch->beside;
		return there && patch->shares[*face] > 1e-5 ? profile(ground, aside, width) : 0;
	}
	*face = place[0] > 0 ? AHEAD : BEHIND;
	return aside <= 0 && patch->shares[*face] > 1e-5 ? profile(ground, along, width) : 0;
}

enum status reference_spread(struct reference_ground *ground, const struct deform_params *params, const struct deform_contact *sweep,
			     struct reference_laying *laying)
{
	int count = ground->width * ground->height, most = -1;
	struct patch patch = {.any = false};
	double sums[FACES] = {0}, laid_on[FACES], all = 0, area = ground->spacing * ground->spacing;
	*laying = (struct reference_laying){.rate = 0};
	share(&patch, sweep, ground->spacing);
	measure(ground, params, sweep, &patch);
	for (int i = 0; i < count; i++)
		ground->carried[i] = 0;
	if (patch.carried == 0)
		return STATUS_OK;
	double *weights = mem_alloc((size_t)count, sizeof *weights), width = width_of(ground, params, sweep, &patch);
	if (weights == NULL)
		return fail_memory("reference");
	for (int i = 0; i < count; i++) {
		int face;
		weights[i] = weight_of(ground, sweep, &patch, width, i, &face, &laying->undecided);
		sums[face] += weights[i];
	}
	if (patch.around)
		patch.shares[AHEAD] = 1;
	for (int face = 0; face < FACES; face++) {
		laid_on[face] = sums[face] > 0 ? patch.shares[face] * patch.carried : 0;
		all += laid_on[face];
		most = sums[face] > 0 && (most < 0 || patch.shares[face] > patch.shares[most]) ? face : most;
	}
	/* What has no post at its face goes where most goes. */
	if (most >= 0)
		laid_on[most] += patch.carried - all;
	else
		ground->compacted += patch.carried * area;
	ground->confined += most < 0 ? patch.carried * area : 0;
	for (int i = 0; i < count && most >= 0; i++) {
		int face;
		bool ignored = false;
		if (weights[i] == 0)
			continue;
		weight_of(ground, sweep, &patch, width, i, &face, &ignored);
		ground->offset[i] += laid_on[face] * weights[i] / sums[face];
	}
	for (int face = 0; face < FACES; face++)
		laying->rate = sums[face] > 0 ? fmax(laying->rate, laid_on[face] / sums[face]) : laying->rate;
	laying->share = laying->rate / patch.carried;
	laying->width = width;
	mem_free(weights);
	return STATUS_OK;
}
