/*
 * Computes synthetic terrain, for tests and examples without elevation data. A height depends only on the post, seed, kind,
 * spacing, relief and the terrain's size.
 *
 * Heights are sums of gradient noise: random slopes at the points of a lattice, interpolated between them. A hash of integers
 * gives the slopes. Each sum has several octaves, each with half the wavelength of the octave before. The longest wavelength
 * follows the terrain's size. The shortest is above the distance of two posts. Only +, -, *, / and sqrt are used, so every machine
 * computes the same bits.
 */
#include "dem/dem.h"

#include <math.h>

#define RUN 256 /* posts of a row that are computed at once */
#define OCTAVES_MAX 24

static uint64_t mix(uint64_t v)
{
	v ^= v >> 32;
	v *= 0xd6e8feb86659fd93ull;
	v ^= v >> 32;
	v *= 0xd6e8feb86659fd93ull;
	v ^= v >> 32;
	return v;
}

/* One octave of noise. `scale`: lattice cells for each post. The shift differs for each octave, so that no two octaves share
 * lattice points. */
struct octave {
	uint64_t seed;
	double scale, shift_x, shift_y;
};

static struct octave octave_make(const struct dem_synth *synth, double wavelength, unsigned number)
{
	uint64_t seed = mix(mix(synth->seed + 0x9e3779b97f4a7c15ull) + number * 0x632be59bd9b4e019ull + 1);
	return (struct octave){
		.seed = seed,
		.scale = synth->spacing / wavelength,
		.shift_x = (double)(seed & 0xffff) / 65536.0,
		.shift_y = (double)(seed >> 16 & 0xffff) / 65536.0,
	};
}

/* One lattice column, for a fixed row of posts. At the distance dx from the column its noise is slope * dx + value. */
struct column {
	double slope, value;
};

static double signed_unit(uint64_t bits)
{
	return (double)(int64_t)(bits & 0xfffff) / 524288.0 - 1.0;
}

static double fade(double t)
{
	return t * t * t * (t * (t * 6 - 15) + 10);
}

static struct column column_at(uint64_t seed, int64_t cx, int64_t cy, double fy, double blend)
{
	uint64_t x = (uint64_t)cx * 0xc2b2ae3d27d4eb4full;
	uint64_t low = mix(seed ^ (x + (uint64_t)cy * 0x165667b19e3779f9ull));
	uint64_t high = mix(seed ^ (x + (uint64_t)(cy + 1) * 0x165667b19e3779f9ull));
	double slope0 = signed_unit(low), slope1 = signed_unit(high);
	double value0 = signed_unit(low >> 24) * fy, value1 = signed_unit(high >> 24) * (fy - 1);
	return (struct column){slope0 + blend * (slope1 - slope0), value0 + blend * (value1 - value0)};
}

/* Computes noise at the posts (x .. x + count - 1, y). It lies within (-1, 1), mostly within (-0.5, 0.5). */
static void noise_run(const struct octave *octave, int64_t x, int64_t y, int count, double *out)
{
	double at_y = (double)y * octave->scale + octave->shift_y, floor_y = floor(at_y);
	double fy = at_y - floor_y, blend = fade(fy);
	int64_t cy = (int64_t)floor_y, known = INT64_MIN;
	struct column west = {0}, east = {0};
	for (int i = 0; i < count;) {
		double cell = floor((double)(x + i) * octave->scale + octave->shift_x);
		int64_t cx = (int64_t)cell;
		if (cx != known) {
			west = cx == known + 1 ? east : column_at(octave->seed, cx, cy, fy, blend);
			east = column_at(octave->seed, cx + 1, cy, fy, blend);
			known = cx;
		}
		/* Find the last post in this cell. A guess that is too far is reduced. If it is too near, the loop continues with
		 * the same cell. */
		double guess = (cell + 1 - octave->shift_x) / octave->scale - (double)x + 1;
		int end = guess < count ? (int)guess : count;
		if (end <= i)
			end = i + 1;
		while (end > i + 1 && (double)(x + end - 1) * octave->scale + octave->shift_x >= cell + 1)
			end--;
		for (; i < end; i++) {
			double fx = (double)(x + i) * octave->scale + octave->shift_x - cell;
			double a = west.slope * fx + west.value;
			double b = east.slope * (fx - 1) + east.value;
			out[i] = a + fade(fx) * (b - a);
		}
	}
}

static double clamp01(double v)
{
	return v < 0 ? 0 : v > 1 ? 1 : v;
}

static double extent_of(const struct dem_synth *synth)
{
	int64_t posts = synth->width > synth->height ? synth->width : synth->height;
	return (double)(posts > 1 ? posts - 1 : 1) * synth->spacing;
}

/* Maps any number to (0, 1) by a smooth, rising curve. */
static double squash(double v)
{
	return 0.5 + 0.5 * v / sqrt(1 + v * v);
}

/* --- ridged mountains: a small ridge is high only where the large ridge is high --- */

static void ridged_run(const struct dem_synth *synth, int64_t x, int64_t y, int count, double *out)
{
	double wavelength = extent_of(synth) / 2, gain = 1, total = 0, noise[RUN], weight[RUN];
	if (wavelength > 6000)
		wavelength = 6000;
	for (int i = 0; i < count; i++) {
		out[i] = 0;
		weight[i] = 1;
	}
	for (unsigned o = 0; o < OCTAVES_MAX; o++) {
		if (o > 0 && wavelength <= 2 * synth->spacing)
			break;
		struct octave octave = octave_make(synth, wavelength, o);
		noise_run(&octave, x, y, count, noise);
		for (int i = 0; i < count; i++) {
			double ridge = 1 - fabs(noise[i]) * 1.9;
			ridge = ridge > 0 ? ridge * ridge * weight[i] : 0;
			out[i] += gain * ridge;
			weight[i] = clamp01(ridge * 1.6);
		}
		total += gain;
		gain *= 0.42;
		wavelength /= 2;
	}
	for (int i = 0; i < count; i++)
		out[i] *= synth->relief / total;
}

/* --- sums of plain noise --- */

/* Adds octaves with wavelengths from `wavelength` down to `shortest`, metres. Returns the sum of their gains. */
static double add_octaves(const struct dem_synth *synth, double wavelength, double shortest,
			  double persistence, unsigned number, int64_t x, int64_t y, int count,
			  double *out)
{
	double gain = 1, total = 0, noise[RUN];
	if (shortest < 2 * synth->spacing)
		shortest = 2 * synth->spacing;
	for (unsigned o = 0; o < OCTAVES_MAX && (o == 0 || wavelength > shortest); o++) {
		struct octave octave = octave_make(synth, wavelength, number + o);
		noise_run(&octave, x, y, count, noise);
		for (int i = 0; i < count; i++)
			out[i] += gain * noise[i];
		total += gain;
		gain *= persistence;
		wavelength /= 2;
	}
	return total;
}

/* Computes a plain: long, gentle waves, and bumps of a few metres on them. */
static void plain_run(const struct dem_synth *synth, int64_t x, int64_t y, int count, double *out)
{
	double wavelength = extent_of(synth) / 2, bumps[RUN];
	if (wavelength > 3000)
		wavelength = 3000;
	for (int i = 0; i < count; i++)
		out[i] = bumps[i] = 0;
	double total = add_octaves(synth, wavelength, wavelength / 40, 0.4, 0, x, y, count, out);
	double longest = wavelength < 12 ? wavelength : 12;
	if (longest > 2 * synth->spacing)
		add_octaves(synth, longest, 0.5, 0.45, 64, x, y, count, bumps);
	for (int i = 0; i < count; i++)
		out[i] = synth->relief * (0.99 * squash(out[i] * 3.2 / total) + 0.005 + 0.005 * bumps[i]);
}

/* --- dunes --- */

/* Returns the height, 0 .. 1, of a dune at this phase. A period is 1. The windward side is long, the slip face is short, and both
 * ends are smooth. */
static double dune_profile(double phase, double crest)
{
	double t = phase - floor(phase);
	t = t < crest ? t / crest : (1 - t) / (1 - crest);
	return t * t * (3 - 2 * t);
}

static void dunes_run(const struct dem_synth *synth, int64_t x, int64_t y, int count, double *out)
{
	/* On a large terrain the waves are so long that no slip face is steeper than the angle of repose of sand. */
	double extent = extent_of(synth), wavelength = extent / 10, bend[RUN], swell[RUN], broad[RUN];
	if (wavelength > 400)
		wavelength = 400;
	if (wavelength < 8 * synth->relief)
		wavelength = 8 * synth->relief;
	if (wavelength > extent / 3)
		wavelength = extent / 3;
	for (int i = 0; i < count; i++)
		bend[i] = swell[i] = broad[i] = 0;
	add_octaves(synth, 5 * wavelength, wavelength, 0.45, 0, x, y, count, bend);
	add_octaves(synth, 3 * wavelength, 2 * wavelength, 0.5, 32, x, y, count, swell);
	add_octaves(synth, 8 * wavelength, 4 * wavelength, 0.5, 48, x, y, count, broad);
	double along = synth->spacing / wavelength;
	const double wind_x = 0.8, wind_y = 0.6; /* a unit vector: the direction the wind blows to */
	bool ripples = wavelength / 9 > 4 * synth->spacing;
	bool small = wavelength / 61 > 4 * synth->spacing;
	for (int i = 0; i < count; i++) {
		double phase = ((double)(x + i) * wind_x + (double)y * wind_y) * along + 2.4 * bend[i];
		double crest = dune_profile(phase, 0.72);
		double height = 0.7 * crest * clamp01(0.75 + 0.9 * swell[i]);
		/* Ripples lie on the dune. Their crests bend more than the crest of the dune. */
		if (ripples)
			height += 0.03 * crest * dune_profile(9 * phase + 6 * bend[i] + 3 * swell[i], 0.7);
		if (small)
			height += 0.003 * dune_profile(61 * phase + 9 * swell[i], 0.65);
		out[i] = synth->relief * (height + 0.25 * squash(3 * broad[i]));
	}
}

void dem_synth_posts(const struct dem_synth *synth, struct post_rect rect, double *heights)
{
	int64_t width = rect.x1 - rect.x0;
	for (int64_t y = rect.y0; y < rect.y1; y++, heights += width) {
		for (int64_t x = 0; x < width; x += RUN) {
			int count = width - x < RUN ? (int)(width - x) : RUN;
			double *out = heights + x;
			switch (synth->kind) {
			case DEM_SYNTH_RIDGED:
				ridged_run(synth, rect.x0 + x, y, count, out);
				break;
			case DEM_SYNTH_DUNES:
				dunes_run(synth, rect.x0 + x, y, count, out);
				break;
			case DEM_SYNTH_PLAIN:
				plain_run(synth, rect.x0 + x, y, count, out);
				break;
			}
			for (int i = 0; i < count; i++)
				out[i] = synth->relief * clamp01(synth->relief > 0 ? out[i] / synth->relief : 0);
		}
	}
}
