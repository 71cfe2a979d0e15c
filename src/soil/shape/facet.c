/* Converts a moving triangle to whole numbers, from which the shader computes its lowest height at a post. */
#include "soil/shape/facet.h"

#include <math.h>
#include <string.h>

#define UNIT (1 << FACET_BITS)
#define ONE_BITS 28       /* fraction bits of times in the motion */
#define COEFFICIENT 30    /* bits of a coefficient that is multiplied by a number of posts */
#define STEEPEST 0x1p46   /* fixed-point units a post: a steeper facet is narrower than 2^-FACET_BITS posts */
#define ASIDE 16          /* an edge that moves less than 2^-FACET_BITS / ASIDE posts aside moves along itself */

enum edge_kind { EDGE_ALONG, EDGE_ENTERS, EDGE_LEAVES };

static int64_t cross(int64_t ax, int64_t ay, int64_t bx, int64_t by)
{
	return ax * by - ay * bx;
}

static int32_t least(int32_t a, int32_t b)
{
	return a < b ? a : b;
}

static int32_t most(int32_t a, int32_t b)
{
	return a > b ? a : b;
}

static double larger(double a, double b)
{
	return a > b ? a : b;
}

/* ldexp(1, n), and below ilogb(v), for normal numbers only. They are faster, and each triangle needs about ten. */
static double power_of_two(int n)
{
	uint64_t bits = (uint64_t)(n + 1023) << 52;
	double v;
	memcpy(&v, &bits, sizeof v);
	return v;
}

static int exponent_of(double v)
{
	uint64_t bits;
	memcpy(&bits, &v, sizeof bits);
	return (int)(bits >> 52 & 0x7ff) - 1023;
}

static int64_t floor_posts(int64_t place)
{
	return place >> FACET_BITS;
}

static int64_t ceil_posts(int64_t place)
{
	return (place + UNIT - 1) >> FACET_BITS;
}

/* Writes at + i di + j dj as whole numbers in 2^-shift, and returns the shift: the largest one that the coefficients allow.
 * Adds one half, so that a shift to the right rounds to nearest. A negative shift means one to the left. */
static int affine_of(double at, double di, double dj, int shift_most, int32_t words[4])
{
	int shift = COEFFICIENT - 1 - exponent_of(larger(fabs(di), fabs(dj)));
	shift = shift < shift_most ? shift : shift_most;
	double scale = power_of_two(shift);
	int64_t whole = llrint(at * scale) + (shift > 0 ? (int64_t)1 << (shift - 1) : 0);
	words[0] = (int32_t)(uint32_t)whole;
	words[1] = (int32_t)(uint32_t)((uint64_t)whole >> 32);
	words[2] = (int32_t)lrint(di * scale);
	words[3] = (int32_t)lrint(dj * scale);
	return shift;
}

/* One edge of a facet in motion. */
struct edge {
	const int32_t *from, *to; /* x, y from the facet's post */
	double z, rise;           /* height of `from`; rise from `from` to `to` */
	enum edge_kind kind;
	int when_shift, side_shift;
};

/* Computes two functionals of the facet's post (i, j). `when`: the time at which the edge passes over the post, counted back from
 * the end of the motion. `side`: the height of the edge at that time. */
static void edge_of(struct edge *edge, const struct facet_motion *motion, int32_t when[4], int32_t side[4])
{
	int64_t x = (int64_t)edge->to[0] - edge->from[0], y = (int64_t)edge->to[1] - edge->from[1];
	int64_t aside = cross(x, y, motion->x, motion->y);
	memset(when, 0, 4 * sizeof *when);
	memset(side, 0, 4 * sizeof *side);
	edge->when_shift = edge->side_shift = 0;
	edge->kind = EDGE_ALONG;
	if ((double)aside * (double)aside * ASIDE * ASIDE < (double)x * (double)x + (double)y * (double)y)
		return;
	double one = power_of_two(ONE_BITS) / (double)aside, unit = UNIT / (double)aside;
	edge->kind = aside > 0 ? EDGE_ENTERS : EDGE_LEAVES;
	edge->when_shift = affine_of(-(double)cross(x, y, -(int64_t)edge->from[0], -(int64_t)edge->from[1]) * one,
				     (double)y * UNIT * one, -(double)x * UNIT * one, COEFFICIENT, when);
	double di = (edge->rise * motion->y - (double)motion->z * (double)y) * unit;
	double dj = ((double)x * motion->z - edge->rise * motion->x) * unit;
	edge->side_shift = affine_of(edge->z - (di * edge->from[0] + dj * edge->from[1]) / UNIT, di, dj, 12, side);
}

/* Returns the change of height at a post over the whole motion, counted back from its end. It is a factor of at most 31 bits,
 * to be multiplied by a time and shifted by *shift. It has the fractions of the facet's plane. */
static int32_t rate_of(double rate, int *shift)
{
	*shift = 0;
	if (rate == 0)
		return 0;
	*shift = COEFFICIENT - 1 - exponent_of(rate) + ONE_BITS;
	*shift = *shift < 62 ? *shift : 62;
	return (int32_t)lrint(rate * power_of_two(*shift - ONE_BITS));
}

/* Finds the posts that the facet is ever above along one axis: first and last, from the anchor. False: none. */
static bool covers(const int32_t at[3], int32_t motion, int64_t posts[2])
{
	int64_t low = least(least(at[0], at[1]), at[2]), high = most(most(at[0], at[1]), at[2]);
	posts[0] = ceil_posts(low - most(motion, 0));
	posts[1] = floor_posts(high - least(motion, 0));
	return posts[0] <= posts[1];
}

/* Clips these posts to a window's side: first in the low half, one behind the last in the high half. False: none is left. */
static bool clipped(const int64_t posts[2], int64_t first, int32_t side, int32_t *word)
{
	int64_t low = posts[0] - first, high = posts[1] + 1 - first;
	low = low > 0 ? low : 0;
	high = high < side ? high : side;
	if (low >= high)
		return false;
	*word = (int32_t)(low | high << 16);
	return true;
}

bool soil_facet_of(const struct facet_corner corners[3], const struct facet_motion *motion, bool resting,
	      const struct facet_window *window, struct facet *facet)
{
	const struct facet_corner *c[3] = {&corners[0], &corners[1], &corners[2]};
	int64_t posts[2][2];
	if (!covers((const int32_t[3]){c[0]->x, c[1]->x, c[2]->x}, motion->x, posts[0]) ||
	    !covers((const int32_t[3]){c[0]->y, c[1]->y, c[2]->y}, motion->y, posts[1]) ||
	    !clipped(posts[0], window->x0, window->width, &facet->cover[0]) ||
	    !clipped(posts[1], window->y0, window->height, &facet->cover[1]))
		return false;
	int64_t area = cross((int64_t)c[1]->x - c[0]->x, (int64_t)c[1]->y - c[0]->y, (int64_t)c[2]->x - c[0]->x,
			     (int64_t)c[2]->y - c[0]->y);
	if (area == 0)
		return false;
	if (area < 0) {
		const struct facet_corner *other = c[1];
		c[1] = c[2];
		c[2] = other;
		area = -area;
	}
	int32_t at[3][2];
	for (int k = 0; k < 3; k++) {
		at[k][0] = (int32_t)(c[k]->x - posts[0][0] * UNIT);
		at[k][1] = (int32_t)(c[k]->y - posts[1][0] * UNIT);
	}
	double x1 = (double)at[1][0] - at[0][0], y1 = (double)at[1][1] - at[0][1], z1 = c[1]->z - c[0]->z;
	double x2 = (double)at[2][0] - at[0][0], y2 = (double)at[2][1] - at[0][1], z2 = c[2]->z - c[0]->z;
	double di = (z1 * y2 - z2 * y1) / (double)area * UNIT, dj = (z2 * x1 - z1 * x2) / (double)area * UNIT;
	if (!(larger(fabs(di), fabs(dj)) < STEEPEST))
		return false;
	int shifts[4], rate_shift;
	uint32_t kinds = resting;
	shifts[3] = affine_of(c[0]->z - (di * at[0][0] + dj * at[0][1]) / UNIT, di, dj, 12, facet->plane);
	for (int k = 0; k < 3; k++) {
		int next = (k + 1) % 3;
		struct edge edge = {.from = at[k], .to = at[next], .z = c[k]->z, .rise = c[next]->z - c[k]->z};
		edge_of(&edge, motion, facet->edges[k], facet->sides[k]);
		shifts[k] = edge.when_shift;
		kinds |= (uint32_t)edge.kind << (2 + 2 * k) | (uint32_t)(edge.side_shift + 32) << (14 + 6 * k);
	}
	double rate = (di * motion->x + dj * motion->y) / UNIT - motion->z;
	facet->base[2] = rate_of(rate * power_of_two(shifts[3]), &rate_shift);
	facet->base[0] = (int32_t)(posts[0][0] - window->x0);
	facet->base[1] = (int32_t)(posts[1][0] - window->y0);
	facet->base[3] = motion->z;
	facet->cover[2] = (int32_t)(kinds | (uint32_t)rate_shift << 8);
	facet->cover[3] = (int32_t)((uint32_t)(shifts[0] + 64) | (uint32_t)(shifts[1] + 64) << 8 |
				    (uint32_t)(shifts[2] + 64) << 16 | (uint32_t)(shifts[3] + 64) << 24);
	for (int k = 0; k < 2; k++) {
		facet->corners[k] = at[0][k];
		facet->corners[2 + k] = at[1][k];
		facet->third[k] = at[2][k];
	}
	facet->third[2] = (int32_t)floor(fmin(fmin(c[0]->z, c[1]->z), c[2]->z));
	facet->third[3] = (int32_t)ceil(fmax(fmax(c[0]->z, c[1]->z), c[2]->z));
	return true;
}
