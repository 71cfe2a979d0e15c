/*
 * Joins sources that lie on both sides of a seam of longitude: of 180 degrees, or of 0 where x counts to 360.
 *
 * x is a place on a circle. It is counted from the end of the widest gap between the sources of one SRS, so no source lies across the seam. Each source
 * then lies within one turn from there. The first source stays where it is.
 */
#include "dem_gdal.h"

#include <stdlib.h>

struct span {
	double low, high;
	double turns; /* by which low and high were brought down */
	size_t source;
};

static int by_low(const void *a, const void *b)
{
	const struct span *one = a, *other = b;
	if (one->low != other->low)
		return one->low < other->low ? -1 : 1;
	return one->source < other->source ? -1 : 1;
}

/* Where a source lies in x, brought into one turn from 0. */
static struct span span_of(const struct gdal_source *source, size_t index, double turn)
{
	const double *p = source->place;
	double low = (double)INFINITY, high = -(double)INFINITY;
	for (int corner = 0; corner < 4; corner++) {
		const double x = p[0] + ((corner & 1) != 0 ? source->width : 0) * p[1] + ((corner & 2) != 0 ? source->height : 0) * p[2];
		low = fmin(low, x);
		high = fmax(high, x);
	}
	const double turns = floor(low / turn);
	return (struct span){low - turns * turn, high - turns * turn, turns, index};
}

/* Returns where x is to begin: at the end of the widest gap. `spans` are sorted. */
static double beginning(const struct span *spans, size_t count, double turn)
{
	double reached = spans[0].high, widest = 0, begin = spans[0].low;
	for (size_t i = 1; i < count; i++) {
		if (spans[i].low - reached > widest) {
			widest = spans[i].low - reached;
			begin = spans[i].low;
		}
		reached = fmax(reached, spans[i].high);
	}
	/* The last gap goes from the last source round to the first one. It is taken unless another gap is wider. */
	return spans[0].low + turn - reached >= widest ? spans[0].low : begin;
}

/* The whole turns by which a source is to move so that it begins within one turn from `begin`. */
static double moves(const struct span *at, double begin, double turn)
{
	return (at->low < begin - 1e-9 * turn ? 1 : 0) - at->turns;
}

static void join(struct gdal_source *sources, size_t count, size_t first, struct span *spans, double turn)
{
	size_t known = 0;
	for (size_t i = first; i < count; i++)
		if (sources[i].system == (int)first)
			spans[known++] = span_of(&sources[i], i, turn);
	const struct span own = spans[0]; /* of `first` */
	qsort(spans, known, sizeof *spans, by_low);
	const double begin = beginning(spans, known, turn), stays = moves(&own, begin, turn);
	for (size_t i = 0; i < known; i++)
		sources[spans[i].source].place[0] += (moves(&spans[i], begin, turn) - stays) * turn;
}

enum status dem_turn_join(struct gdal_source *sources, size_t count)
{
	struct span *spans = mem_alloc(count, sizeof *spans);
	TRY_MEM(spans, "opening the sources");
	for (size_t i = 0; i < count; i++) {
		double middle;
		const double turn = sources[i].placed && sources[i].system == (int)i ? dem_srs_turn(sources[i].srs, &middle) : 0;
		if (turn > 0)
			join(sources, count, i, spans, turn);
	}
	mem_free(spans);
	return STATUS_OK;
}
