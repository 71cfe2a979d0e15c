/*
 * Joins sources that lie on both sides of a seam of longitude: of 180 degrees, or of 0 where x counts to 360.
 *
 * x is a place on a circle. The widest gap between the sources of one SRS is where nothing lies, so x is counted from its end. Each source
 * then lies within one turn from there. The first source stays where it is.
 */
#include "dem_gdal.h"

#include <stdlib.h>

struct span {
	double low, high;
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
	const double from = floor(low / turn) * turn;
	return (struct span){low - from, high - from, index};
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
	/* The gap that ends at the first one, a turn later. It is the choice if none is wider. */
	return spans[0].low + turn - reached >= widest ? spans[0].low : begin;
}

/* The whole turns by which a source is to move so that it begins within one turn from `begin`. */
static double moves(const struct gdal_source *source, size_t index, double begin, double turn)
{
	const struct span at = span_of(source, index, turn);
	const double low = at.low + (at.low < begin - 1e-9 * turn ? turn : 0);
	const double *p = source->place;
	const double is = fmin(p[0], fmin(p[0] + source->width * p[1], fmin(p[0] + source->height * p[2], p[0] + source->width * p[1] + source->height * p[2])));
	return rint((low - is) / turn);
}

static void join(struct gdal_source *sources, size_t count, size_t first, struct span *spans, double turn)
{
	size_t known = 0;
	for (size_t i = first; i < count; i++)
		if (sources[i].system == (int)first)
			spans[known++] = span_of(&sources[i], i, turn);
	qsort(spans, known, sizeof *spans, by_low);
	const double begin = beginning(spans, known, turn), stays = moves(&sources[first], first, begin, turn);
	for (size_t i = 0; i < known; i++) {
		struct gdal_source *source = &sources[spans[i].source];
		source->place[0] += (moves(source, spans[i].source, begin, turn) - stays) * turn;
	}
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
