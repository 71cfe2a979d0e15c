/*
 * The forces of scm soil on a rigid wheel with camber, integrated over its surface, in its own frame: x forward, the axle A to its left, U across
 * both. The ground is level and was undisturbed. A place on the rim is at an angle t from its lowest line and at w along the axle; one on the
 * lower side wall is `below` the axle and `ahead` of it.
 *
 * The rim bears p(z) along its normal, and shear over Wong and Reece's displacement. The wall bears what a level face at its depth would, times
 * the sine of the camber.
 */
#include <math.h>

#include "deform/reference/reference.h"

#define SLICES 40
#define ANGLES 300

struct leaning {
	const struct soil_numbers *soil;
	const struct reference_leaning *wheel;
	double s, c, half;
	double height; /* of the axle's middle above the ground */
	double width;  /* b in k_c / b */
	struct reference_wrench sum;
};

/* Adds a force at a place, both in the wheel's frame. */
static void add(struct leaning *l, const double arm[3], const double force[3])
{
	double moment[3];
	for (int k = 0; k < 3; k++)
		moment[k] = arm[(k + 1) % 3] * force[(k + 2) % 3] - arm[(k + 2) % 3] * force[(k + 1) % 3];
	const double *from[2] = {force, moment};
	double *to[2] = {l->sum.force, l->sum.moment};
	for (int i = 0; i < 2; i++) {
		to[i][0] += from[i][0];
		to[i][1] += from[i][1] * l->c - from[i][2] * l->s;
		to[i][2] += from[i][1] * l->s + from[i][2] * l->c;
	}
}

static double strength(const struct soil_numbers *soil, double pressure)
{
	return pressure > 0 ? soil->cohesion + pressure * tan(soil->friction_angle) : 0;
}

/* The stress at a sinkage that was deeper before. */
static double rebounds(const struct leaning *l, double sinkage, double largest)
{
	const double most = reference_yield(l->soil, l->width, largest), stays = fmax(largest - most / l->soil->elastic_stiffness, 0);
	return most * fmin(fmax((sinkage - stays) / (largest - stays), 0), 1);
}

/* A line of the rim along the wheel's way, at w along its axle. */
static void add_line(struct leaning *l, double w, double wide)
{
	const double r = l->wheel->radius, first = acos(fmin((l->height + w * l->s) / (r * l->c), 1)), step = 2 * first / ANGLES;
	for (int k = 0; k < ANGLES; k++) {
		const double t = first - (k + 0.5) * step, sine = sin(t), cosine = cos(t), area = r * step * wide;
		const double sinkage = r * cosine * l->c - l->height - w * l->s, aside = w * l->c + r * cosine * l->s;
		/* The deepest that the rim or the wall was over this place of the ground. */
		const double wall = l->s > 0 ? (-l->half - aside * l->c) / l->s : -INFINITY;
		const double largest = -l->height - fmax((aside * l->s - r) / l->c, wall);
		const double p = l->wheel->rolls && t < 0 ? rebounds(l, sinkage, largest) : reference_yield(l->soil, l->width, sinkage);
		/* The angle at which the rim came to that place. The soil keeps its shear, while the place passes below other lines of the rim. */
		const double came = acos(fmin((l->height * l->c + aside * l->s) / r, 1));
		const double slid = l->wheel->rolls ? r * (came - t - (sin(came) - sine) / l->wheel->turned) : 0;
		const double shear = copysign(strength(l->soil, p) * (1 - exp(-fabs(slid) / l->soil->janosi_shear)), slid);
		add(l, (const double[]){r * sine, w, -r * cosine}, (const double[]){area * (-p * sine + shear * cosine), 0, area * (p * cosine + shear * sine)});
	}
}

/* A line of the wall along the wheel's way. The wheel carries it over the soil from ahead: e is what the soil's shear has become. */
static void add_wall(struct leaning *l, double below, double high)
{
	const double r = l->wheel->radius, reach = sqrt(fmax(r * r - below * below, 0)), step = 2 * reach / ANGLES;
	const double p = reference_yield(l->soil, l->width, below * l->c + l->half * l->s - l->height), counts = l->s * high * step;
	double e[2] = {0, 0};
	for (int k = 0; k < ANGLES && l->wheel->rolls; k++) {
		const double ahead = reach - (k + 0.5) * step;
		/* The wall's motion for each metre of the way, forward and up along the wall; half of it before the middle of a step. */
		const double moves[2] = {1 - l->wheel->turned * below / r, -l->wheel->turned * ahead / r}, size = hypot(moves[0], moves[1]);
		const double stays = exp(-size * step / 2 / l->soil->janosi_shear);
		double middle[2];
		for (int i = 0; i < 2; i++) {
			middle[i] = moves[i] / size + (e[i] - moves[i] / size) * stays;
			e[i] = moves[i] / size + (middle[i] - moves[i] / size) * stays;
		}
		const double shear = counts * strength(l->soil, p);
		add(l, (const double[]){ahead, -l->half, -below}, (const double[]){-shear * middle[0], counts * p, -shear * middle[1]});
	}
	if (!l->wheel->rolls)
		add(l, (const double[]){0, -l->half, -below}, (const double[]){0, l->s * high * 2 * reach * p, 0});
}

struct reference_wrench reference_leaning(const struct soil_numbers *soil, const struct reference_leaning *wheel)
{
	const double s = sin(wheel->camber), c = cos(wheel->camber), half = wheel->width / 2, r = wheel->radius;
	struct leaning l = {.soil = soil, .wheel = wheel, .s = s, .c = c, .half = half, .height = r * c + half * s - wheel->sinkage,
			    .width = 1 / (c * c / wheel->width + s * s / r)};
	for (int i = 0; i < SLICES; i++)
		add_line(&l, half * (2 * (i + 0.5) / SLICES - 1), wheel->width / SLICES);
	const double top = (l.height - half * s) / c; /* where the wall meets the ground */
	for (int i = 0; i < SLICES && s > 0 && top < r; i++)
		add_wall(&l, top + (r - top) * (i + 0.5) / SLICES, (r - top) / SLICES);
	return l.sum;
}

double reference_leaning_sinkage(const struct soil_numbers *soil, const struct reference_leaning *wheel, double load)
{
	struct reference_leaning at = *wheel;
	double low = 0, high = wheel->radius;
	for (int i = 0; i < 24; i++) {
		at.sinkage = (low + high) / 2;
		*(reference_leaning(soil, &at).force[2] < load ? &low : &high) = at.sinkage;
	}
	return high;
}
