/* Looks for a value that is probably an undeclared hole: one that many posts have, far from all other heights. */
#include "intake/internal.h"

#include <math.h>
#include <string.h>

#define LOW (-20480.0) /* m: of the first bin */
#define BIN 16.0       /* m */
#define FEW 9          /* so few posts may be a peak */
#define TAIL 0.005     /* share of the posts at each end that the range of the others leaves out */
#define FAR_LEAST 1000.0 /* m: an extreme this near to the other heights is no hole */
#define FAR_RANGES 3.0   /* nor is one nearer than this many times their range */

static size_t bin_of(double height)
{
	const double bin = (height - LOW) / BIN;
	return bin < 0 ? 0 : bin >= CENSUS_BINS ? CENSUS_BINS - 1 : (size_t)bin;
}

static void take_extreme(struct census_extreme *extreme, double height, bool beyond)
{
	if (beyond)
		*extreme = (struct census_extreme){height, 0};
	extreme->posts += height == extreme->height;
}

void intake_census_add(struct census *census, const double *heights, int64_t count)
{
	for (int64_t i = 0; i < count; i++) {
		const double height = heights[i];
		if (isnan(height))
			continue;
		census->bins[bin_of(height)]++;
		take_extreme(&census->low, height, census->posts == 0 || height < census->low.height);
		take_extreme(&census->high, height, census->posts == 0 || height > census->high.height);
		census->posts++;
	}
}

/* Returns a height that about `count` posts lie below. */
static double quantile(const int64_t *bins, int64_t count)
{
	int64_t below = 0;
	size_t bin = 0;
	while (bin + 1 < CENSUS_BINS && below + bins[bin] <= count)
		below += bins[bin++];
	return LOW + BIN * ((double)bin + 0.5);
}

/* Returns true if the extreme lies far from the range of all other posts. */
static bool is_apart(const struct census *census, const struct census_extreme *extreme)
{
	int64_t bins[CENSUS_BINS];
	const int64_t others = census->posts - extreme->posts, tail = (int64_t)(TAIL * (double)others);
	if (extreme->posts < FEW || others < FEW)
		return false;
	memcpy(bins, census->bins, sizeof bins);
	bins[bin_of(extreme->height)] -= extreme->posts;
	const double low = quantile(bins, tail), high = quantile(bins, others - 1 - tail);
	const double off = fmax(low - extreme->height, extreme->height - high);
	return off > fmax(FAR_LEAST, FAR_RANGES * (high - low));
}

bool intake_census_find(const struct census *census, bool low, double *height)
{
	static const double usual[] = {-9999, -32767, -32768, -99999, 9999, 32767, 65535, 99999};
	const struct census_extreme *extreme = low ? &census->low : &census->high;
	*height = extreme->height;
	for (size_t i = 0; i < sizeof usual / sizeof usual[0] && census->posts > 0; i++)
		if (extreme->height == usual[i])
			return true;
	return census->posts > 0 && is_apart(census, extreme);
}
