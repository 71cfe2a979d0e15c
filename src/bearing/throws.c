/* How soil is thrown, and how it flies: see throws.h. */
#include "bearing/throws.h"

#include <math.h>
#include <string.h>

#define UNITS 0x1p20
#define SPEED_MOST 1000.0 /* m/s: a grain leaves no faster */

static double dot(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
	out[0] = a[1] * b[2] - a[2] * b[1];
	out[1] = a[2] * b[0] - a[0] * b[2];
	out[2] = a[0] * b[1] - a[1] * b[0];
}

static void scaled(const double v[3], double by, double out[3])
{
	for (int k = 0; k < 3; k++)
		out[k] = by * v[k];
}

/* Computes how fast the body turns, rad/s, and the radius of its surface. Returns false if it does not turn about an axis that is nearly level. */
static bool turns(const struct soil_motion *motion, double seconds, double axes[3][3], double spin[3], double *radius)
{
	const struct soil_shape *shape = motion->shape;
	const double by = 1 / seconds;
	*radius = soil_shape_reach(shape, motion->to.pitch, motion->to.roll);
	if (shape->kind == SOIL_WHEEL) {
		*radius = shape->radius + (shape->grousers > 0 ? shape->grouser_height : 0);
		scaled(axes[1], motion->turned * by, spin);
		return motion->turned != 0;
	}
	for (int k = 0; k < 3; k++)
		spin[k] = by * (motion->rotated[0] * axes[0][k] + motion->rotated[1] * axes[1][k] + motion->rotated[2] * axes[2][k]);
	return hypot(spin[0], spin[1]) > fabs(spin[2]);
}

/* Finds the run of the surface where it is lowest. Returns false if it does not run. */
static bool runs(const struct soil_motion *motion, double seconds, double axes[3][3], struct bearing_throw *out)
{
	double spin[3], down[3], run[3];
	if (motion->shape->belt) {
		const double ran = soil_shape_ran(motion->shape, motion->turned) / seconds;
		out->radius = soil_shape_reach(motion->shape, 0, 0);
		out->run = fabs(ran);
		scaled(axes[0], ran > 0 ? -1 : 1, out->back);
		memcpy(out->up, axes[2], sizeof out->up);
		memcpy(out->along, axes[1], sizeof out->along);
		return out->run > 0;
	}
	if (!turns(motion, seconds, axes, spin, &out->radius))
		return false;
	const double fast = sqrt(dot(spin, spin));
	scaled(spin, 1 / fast, out->along);
	/* Down, without its part along the axis. */
	for (int k = 0; k < 3; k++)
		down[k] = out->along[2] * out->along[k] - (k == 2);
	scaled(down, 1 / sqrt(dot(down, down)), down);
	cross(spin, down, run);
	out->run = fast * out->radius;
	scaled(run, 1 / fast, out->back);
	scaled(down, -1, out->up);
	return true;
}

static double half_width_of(const struct soil_shape *shape, double radius)
{
	if (shape->kind == SOIL_WHEEL)
		return shape->width / 2;
	if (shape->kind == SOIL_CYLINDER)
		return shape->length / 2;
	return shape->kind == SOIL_BOX ? shape->size[1] / 2 : radius / 2;
}

void bearing_throw_of(const struct soil_motion *motion, double seconds, double gravity, struct bearing_throw *out)
{
	double axes[3][3];
	*out = (struct bearing_throw){.share = 0};
	if (motion->jumped || !(seconds > 0) || !(gravity > 0))
		return;
	const int64_t way[3] = {motion->to.x - motion->from.x, motion->to.y - motion->from.y, motion->to.z - motion->from.z};
	soil_axes(motion->to.yaw, motion->shape->kind == SOIL_WHEEL ? 0 : motion->to.pitch, motion->to.roll, 0, axes);
	if (!runs(motion, seconds, axes, out))
		return;
	for (int k = 0; k < 3; k++)
		out->speed[k] = lattice_offset_metres(way[k]) / seconds;
	out->seconds = seconds;
	out->half_width = half_width_of(motion->shape, out->radius);
	const double slip = out->run + dot(out->speed, out->back);
	if (!(slip * seconds > SOIL_SLIP_LEAST))
		return;
	const double froude = slip * slip / (gravity * out->radius);
	out->share = froude / (froude + THROWN_HALF);
}

/* --- grains --- */

/* Mixes the bits of a number, so that each depends on all. */
static uint64_t mixed(uint64_t v)
{
	v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
	v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
	return v ^ (v >> 31);
}

/* Returns -1 .. 1. */
static double by_chance(uint64_t *state)
{
	*state += 0x9e3779b97f4a7c15u;
	return (double)(mixed(*state) >> 11) * 0x1p-52 - 1;
}

static int32_t speed_units(double v)
{
	return (int32_t)llround(fmax(fmin(v, SPEED_MOST), -SPEED_MOST) * UNITS);
}

int bearing_throw_grains(const struct bearing_throw *how, const int64_t centre[3], double sinkage, int64_t since, int64_t volume, struct bearing_grain grains[THROWN_GRAINS])
{
	const int count = volume < THROWN_GRAINS ? (int)volume : THROWN_GRAINS;
	const double degree = M_PI / 180, leaves = acos(fmax(fmin(1 - sinkage / how->radius, 1), -1));
	const double angle = fmax(fmin(leaves, THROWN_MOST * degree), THROWN_LEAST * degree);
	uint64_t seed = (uint64_t)since;
	for (int k = 0; k < 3; k++)
		seed = mixed(seed ^ (uint64_t)centre[k]);
	for (int i = 0; i < count; i++) {
		struct bearing_grain *grain = &grains[i];
		const double up = angle + THROWN_SPREAD * degree * by_chance(&seed), aside = THROWN_SPREAD * degree * by_chance(&seed);
		const double at = how->half_width * by_chance(&seed), before = 0.5 * (1 + by_chance(&seed)) * how->seconds;
		*grain = (struct bearing_grain){.since = since - llround(before * UNITS), .volume = volume / count + (i < volume % count)};
		for (int k = 0; k < 3; k++) {
			const double back = how->back[k] * cos(aside) + how->along[k] * sin(aside);
			grain->from[k] = centre[k] + llround((how->radius * (back * sin(angle) - how->up[k] * cos(angle)) + at * how->along[k] - before * how->speed[k]) * UNITS);
			grain->velocity[k] = speed_units(how->speed[k] + how->run * (back * cos(up) + how->up[k] * sin(up)));
		}
	}
	return count > 0 ? count : 0;
}

int bearing_fall_grains(const struct bearing_fall *fall, int64_t since, struct bearing_grain grains[FALL_GRAINS])
{
	const int64_t wanted = (fall->volume + fall->most - 1) / fall->most;
	const int count = wanted < FALL_GRAINS ? (int)wanted : FALL_GRAINS;
	uint64_t seed = (uint64_t)since;
	for (int k = 0; k < 3; k++)
		seed = mixed(seed ^ (uint64_t)fall->from[k]);
	for (int i = 0; i < count; i++) {
		struct bearing_grain *grain = &grains[i];
		const double longest = fmin(fall->seconds, (double)since / UNITS), before = 0.5 * (1 + by_chance(&seed)) * longest;
		const double beside[3] = {fall->spread * by_chance(&seed), fall->spread * by_chance(&seed), 0};
		*grain = (struct bearing_grain){.since = since - (int64_t)(before * UNITS), .volume = fall->volume / count + (i < fall->volume % count)};
		for (int k = 0; k < 3; k++) {
			grain->from[k] = fall->from[k] + llround((beside[k] - before * fall->speed[k]) * UNITS);
			grain->velocity[k] = speed_units(fall->speed[k]);
		}
	}
	return count > 0 ? count : 0;
}

void bearing_grain_at(const struct bearing_grain *grain, int32_t gravity, int64_t flown, int64_t place[3])
{
	const int64_t half = (int64_t)1 << (THROWN_BITS - 1);
	for (int k = 0; k < 3; k++)
		place[k] = grain->from[k] + ((grain->velocity[k] * flown + half) >> THROWN_BITS);
	place[2] -= ((((gravity * flown) >> THROWN_BITS) * flown) >> (THROWN_BITS + 1));
}

void bearing_grain_save(const struct bearing_grain *grain, int64_t numbers[GRAIN_NUMBERS])
{
	const int64_t all[GRAIN_NUMBERS] = {grain->from[0], grain->from[1], grain->from[2], grain->velocity[0], grain->velocity[1], grain->velocity[2],
						 grain->since, grain->flown, grain->volume};
	memcpy(numbers, all, sizeof all);
}

bool bearing_grain_load(const int64_t numbers[GRAIN_NUMBERS], struct bearing_grain *grain)
{
	const int64_t far = (int64_t)1 << 60;
	const int32_t fastest = (int32_t)(SPEED_MOST * UNITS);
	bool fits = numbers[6] >= 0 && numbers[7] >= 0 && numbers[7] <= GRAIN_LONGEST && numbers[8] > 0;
	for (int k = 0; k < 3; k++)
		fits = fits && numbers[k] > -far && numbers[k] < far && numbers[3 + k] >= -fastest && numbers[3 + k] <= fastest;
	if (!fits)
		return false;
	*grain = (struct bearing_grain){
		{numbers[0], numbers[1], numbers[2]}, numbers[6], numbers[8], {(int32_t)numbers[3], (int32_t)numbers[4], (int32_t)numbers[5]}, (int32_t)numbers[7],
	};
	return true;
}
