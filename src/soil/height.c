/* Finds the equilibrium height of a body with a load: where the soil carries it. */
#include <stdlib.h>

#include "soil/contact.h"

/* A bracket begins with at most 2^28 units. At most 5 times it is parted by a geometric mean, and 28 times by the arithmetic one. Before each of
 * these come at most 3 tries that part it worse. So the search always ends, as a rule after a few tries. */
#define TRIES (4 * (5 + 28))
#define NOWHERE INT32_MIN

/* Returns the highest height at which the body touches the ground; NOWHERE: there is none below it. */
static int32_t first_contact(const struct soil_posts *posts)
{
	float highest = -1e9f;
	for (size_t i = 0; i < posts->count; i++)
		highest = most(highest, posts->share[i] > 0 ? posts->room[i] : -1e9f);
	return highest > -1e8f ? (int32_t)ceilf(highest * 1048576.0f) + 1 : NOWHERE;
}

/* Newton's method in the logarithms of force and depth: force is about a power of depth. */
static int32_t stepped(int32_t top, int32_t at, double share, double grows, int32_t depth)
{
	const double z = top - at, power = fmin(fmax(z * grows / fmax(share, 1e-6), 0.1), 1e6);
	const double step = z * exp2(fmin(fmax(-log2(fmax(share, 1e-6)) / power, -20), 20));
	return top - (int32_t)lround(fmin(step, depth));
}

/* Takes force as a power of depth through two tries. Returns the height at which it is the load. */
static int32_t between(int32_t top, int32_t first, int32_t second, double at_first, double at_second)
{
	const double near = top - first > 1 ? top - first : 1, far = top - second > 1 ? top - second : 1, rise = log2(at_second / at_first);
	const double part = fabs(rise) > 1e-9 ? -log2(at_first) / rise : 0.5;
	return top - (int32_t)lround(fmin(near * exp2(log2(far / near) * fmin(fmax(part, -20), 20)), 1e9));
}

/* Returns a height between two depths below the first contact: at the geometric mean if the depths differ much, else at the mean. */
static int32_t middle(int32_t shallow, int32_t deep, int32_t top)
{
	const double least_depth = shallow > 8 ? shallow : 8;
	return top - (deep > 8 * least_depth ? (int32_t)sqrt(least_depth * (double)deep) : shallow + (deep - shallow) / 2);
}

static int32_t clamp_to(int64_t value, int64_t low, int64_t high)
{
	return (int32_t)(value < low ? low : value > high ? high : value);
}

void soil_height_find(struct soil_contact *b, int32_t start, struct soil_height *s)
{
	const double load = fmax(b->motion->load, 1e-6), unit = (double)b->form.spacing * (double)b->form.spacing / (double)BEAR_UNITS_A_PASCAL / load;
	const double reach = soil_shape_reach(b->motion->shape, b->motion->to.pitch, b->motion->to.roll);
	/* A body that pushes a heap first touches that, so it may go deeper below it. */
	const double deepest = (b->form.all_round > 0 ? 3 : 2) * (b->motion->shape->kind == SOIL_MESH ? soil_shape_bound(b->motion->shape) : reach);
	const int32_t depth = (int32_t)fmin(ldexp(deepest, OFFSET_BITS), 0x1p28);
	soil_contact_gather(b, start - (int32_t)fmin(ldexp(0.2 * reach, OFFSET_BITS), 0x1p27));
	int32_t top = first_contact(b->posts);
	if (top == NOWHERE) {
		soil_contact_gather(b, -(1 << 30));
		top = first_contact(b->posts);
	}
	*s = (struct soil_height){.share = 1, .state = top == NOWHERE ? SOIL_AIR : SOIL_SUNK};
	if (top == NOWHERE)
		return;
	int32_t low = top - depth, high = top, before = 0;
	double at_low = 1e30, at_high = 0, at_before = 0, carried = 1;
	int64_t last = 2 * (int64_t)depth;
	struct soil_sums sums;
	int stalls = 0;
	bool done = false;
	s->raised = clamp_to(start, low + 1, high - 1);
	for (s->tries = 0; s->tries < TRIES && !done; s->tries++) {
		soil_contact_gather(b, s->raised);
		soil_contact_evaluate(b, s->raised, 1, &sums, NULL, NULL);
		const double share = (double)sums.force[2] * unit, grows_here = sums.grows * unit * (double)SOIL_UNIT;
		const bool bears = share >= 1;
		s->state = bears ? SOIL_TOUCHING : s->state;
		carried = bears ? share : carried;
		low = bears ? s->raised : low;
		high = bears ? high : s->raised;
		at_low = bears ? share : at_low;
		at_high = bears ? at_high : share;
		const int64_t width = (int64_t)high - low;
		const bool both = at_low < 1e30 && at_high > 1e-6;
		/* The height is found if the next step is shorter than half a unit, or if the bracket is one unit wide. */
		const double gap = abs(s->raised - before) > 1 ? abs(s->raised - before) : 1, chord = s->tries > 0 ? fabs((share - at_before) / gap) : grows_here;
		/* Where half a unit is more than the load, the body may not touch there at all. */
		const bool there = share > 0.5 && fabs(share - 1) <= 0.5 * fmin(grows_here, chord);
		s->state = there ? SOIL_TOUCHING : s->state;
		carried = there ? share : carried;
		done = there || width <= 1;
		/* The first step is one of Newton's method, and so are those that stay in the bracket. */
		const bool known = s->tries > 0 && fmin(share, at_before) > 1e-6 && s->raised != before;
		int32_t next = known ? between(top, before, s->raised, at_before, share) : stepped(top, s->raised, share, grows_here, depth);
		const bool out_of = next <= low || next >= high;
		next = out_of && both ? between(top, high, low, at_high, at_low) : next;
		/* If three steps in a row do not halve the bracket, the next try is in its middle. */
		stalls = 2 * width > last ? stalls + 1 : 0;
		const bool lags = stalls >= 3 || share <= 1e-6 || (out_of && !both && at_low < 1e30);
		stalls = lags ? 0 : stalls;
		last = width;
		before = s->raised;
		at_before = share;
		next = clamp_to(lags ? middle(top - high, top - low, top) : next, low + 1, high - 1 > low + 1 ? high - 1 : low + 1);
		s->raised = there ? s->raised : done ? low : next;
	}
	s->raised = done ? s->raised : low;
	s->share = (float)carried;
}
