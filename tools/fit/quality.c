#include "fit.h"

#include <math.h>

void fit_sums_add(struct fit_sums *sums, const struct fit_row *row, double model)
{
	const double residual = row->y - model;
	sums->squares += residual * residual;
	sums->sum += row->y;
	if (sums->quality.rows == 0 || fabs(residual) > fabs(sums->quality.largest)) {
		sums->quality.largest = residual;
		sums->quality.largest_line = row->line;
	}
	sums->quality.rows++;
}

struct fit_quality fit_sums_end(const struct fit_sums *sums)
{
	struct fit_quality quality = sums->quality;
	const double rows = (double)quality.rows;
	quality.rms = rows > 0 ? sqrt(sums->squares / rows) : 0;
	quality.goodness = rows > 2 && sums->sum > 0 ? 1 - sqrt(sums->squares / (rows - 2)) / (sums->sum / rows) : (double)NAN;
	return quality;
}
