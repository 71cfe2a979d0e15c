/*
 * Slopes that are too steep. Every post looks at its eight neighbours as they all are before the iteration; what
 * leaves one arrives at another.
 */
#include <math.h>

#include "deform/reference/reference.h"

static const int around[8][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}};

double reference_stands(const struct deform_params *params, double distance)
{
	const struct soil_numbers *soil = &params->soils[0];
	if (soil->cohesion == 0)
		return distance * tan(soil->friction_angle);
	/* A higher one is steeper, and what a steeper one stands is less: there is one where they meet. */
	double low = distance * tan(soil->friction_angle), high = low + 1;
	while (high < reference_culmann(soil, atan(high / distance)))
		high *= 2;
	for (int i = 0; i < 200; i++) {
		double middle = (low + high) / 2;
		if (middle > reference_culmann(soil, atan(middle / distance)))
			high = middle;
		else
			low = middle;
	}
	return high;
}

/* The post `k` ways around another, or -1 where nothing slides to. */
static int neighbour(const struct reference_ground *ground, int at, int k)
{
	int x = at % ground->width + around[k][0], y = at / ground->width + around[k][1];
	if (x < ground->written.x0 || x >= ground->written.x1 || y < ground->written.y0 || y >= ground->written.y1)
		return -1;
	int beside = y * ground->width + x;
	return ground->hole[beside] ? -1 : beside;
}

static double difference(const struct reference_ground *ground, int a, int b)
{
	return ground->base[a] + ground->offset[a] - ground->base[b] - ground->offset[b];
}

static bool held(const struct reference_ground *ground, int at)
{
	return (ground->contact[at] & REFERENCE_HELD) != 0;
}

/* An eighth of what is too much, if that is more than is tolerated; no more than an eighth of what lies loose. */
static void slide_excess(const struct reference_ground *ground, const struct deform_params *params,
			 const double stands[2], int at, double *change)
{
	if (held(ground, at))
		return;
	double loose = ground->offset[at] + params->depth;
	for (int k = 0; k < 8; k++) {
		int to = neighbour(ground, at, k);
		if (to < 0 || held(ground, to))
			continue;
		double excess = difference(ground, at, to) - stands[k >= 4];
		if (excess <= params->tolerance)
			continue;
		double moved = fmin(excess, fmax(0, loose)) / 8;
		change[at] -= moved;
		change[to] += moved;
	}
}

/* Sumner's: a share of the mean of the differences that are too steep, split among them. */
static void shed(const struct reference_ground *ground, const struct deform_params *params, int at, double *change)
{
	const struct soil_numbers *soil = &params->soils[0];
	bool starts = false, takes[8];
	double sum = 0;
	int count = 0;
	for (int k = 0; k < 8; k++) {
		int to = neighbour(ground, at, k);
		takes[k] = false;
		if (to < 0)
			continue;
		double distance = ground->spacing * (k >= 4 ? sqrt(2) : 1), lower = difference(ground, at, to);
		double limit = held(ground, at) || held(ground, to) ? soil->theta_in : soil->theta_out;
		starts = starts || lower > distance * tan(soil->theta_stop) + params->tolerance;
		takes[k] = lower > distance * tan(limit) + params->tolerance;
		if (takes[k]) {
			sum += lower;
			count++;
		}
	}
	if (!starts || count == 0)
		return;
	double each = soil->roughness * sum / count / count;
	for (int k = 0; k < 8; k++)
		if (takes[k]) {
			change[at] -= each;
			change[neighbour(ground, at, k)] += each;
		}
}

enum status reference_slide(struct reference_ground *ground, const struct deform_params *params, long iterations,
			    double tolerance, double *moved)
{
	int count = ground->width * ground->height;
	double *change = mem_alloc((size_t)count, sizeof *change);
	if (change == NULL)
		return fail_memory("reference");
	double stands[2] = {0, 0};
	if (params->model != DEFORM_SUMNER) {
		stands[0] = reference_stands(params, ground->spacing);
		stands[1] = reference_stands(params, ground->spacing * sqrt(2));
	}
	*moved = INFINITY;
	for (long i = 0; i < iterations && *moved > tolerance; i++) {
		*moved = 0;
		for (int at = 0; at < count; at++)
			change[at] = 0;
		for (int y = (int)ground->written.y0; y < ground->written.y1; y++)
			for (int x = (int)ground->written.x0; x < ground->written.x1; x++) {
				int at = y * ground->width + x;
				if (ground->hole[at])
					continue;
				if (params->model == DEFORM_SUMNER)
					shed(ground, params, at, change);
				else
					slide_excess(ground, params, stands, at, change);
			}
		for (int at = 0; at < count; at++) {
			ground->offset[at] += change[at];
			*moved = fmax(*moved, fabs(change[at]));
		}
	}
	mem_free(change);
	return STATUS_OK;
}
