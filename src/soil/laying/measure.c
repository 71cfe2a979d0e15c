/* What a contact adds up for the laying of its soil, over rows of posts. */
#include <string.h>

#include "soil/laying/laying.h"
#include "soil/lanes.h"

void soil_measured_begin(struct soil_measured *measured)
{
	*measured = (struct soil_measured){
		.least = {INT32_MAX, INT32_MAX},
		.most = {INT32_MIN, INT32_MIN},
		.highest = INT64_MIN,
		.patch = {INT64_MAX, INT64_MAX, INT64_MIN, INT64_MIN},
	};
}

/* The sums of a row. */
struct sums {
	int64_t carried;
	uint32_t givers, classes;
	int32_t deep;
};

static inline bool touches(uint8_t contact)
{
	return (contact & (SOIL_LOWERED | SOIL_HELD)) != 0;
}

/* Sums a part of a row, of one soil. dug: not NULL. */
SOIL_LANES static struct sums sum_one(const uint8_t *contact, const int32_t *carried, const int32_t *offset, const int32_t *dug, int count,
				      int32_t of_dug, int32_t share)
{
	struct sums sums = {0};
	for (int i = 0; i < count; i++) {
		const bool here = touches(contact[i]);
		const int32_t amount = here ? carried[i] : 0, deep = here ? soil_depth_of(carried[i], offset[i], dug[i], of_dug, share) : 0;
		sums.carried += amount;
		sums.givers += amount > 0;
		sums.deep = deep > sums.deep ? deep : sums.deep;
	}
	sums.classes = sums.givers > 0;
	return sums;
}

/* The same where slip digs nothing. */
SOIL_LANES static struct sums sum_undug(const uint8_t *contact, const int32_t *carried, const int32_t *offset, int count, int32_t share)
{
	struct sums sums = {0};
	for (int i = 0; i < count; i++) {
		const bool here = touches(contact[i]);
		const int32_t amount = here ? carried[i] : 0, deep = here ? soil_depth_of(carried[i], offset[i], 0, 0, share) : 0;
		sums.carried += amount;
		sums.givers += amount > 0;
		sums.deep = deep > sums.deep ? deep : sums.deep;
	}
	sums.classes = sums.givers > 0;
	return sums;
}

/* The same of several soils. */
static struct sums sum_classes(const struct soil_row *row, int first, int last, int32_t of_dug, const struct soil_laid soils[SOIL_CLASSES])
{
	struct sums sums = {0};
	for (int i = first; i <= last; i++) {
		if (!touches(row->contact[i]))
			continue;
		const int soil = row->classes[i] < SOIL_CLASSES ? row->classes[i] : SOIL_CLASSES - 1;
		const int32_t amount = row->carried[i], dug = row->dug != NULL ? row->dug[i] : 0;
		const int32_t deep = soil_depth_of(amount, row->offset[i], dug, of_dug, soils[soil].share);
		sums.carried += amount;
		sums.givers += amount > 0;
		sums.classes |= amount > 0 ? 1u << soil : 0;
		sums.deep = deep > sums.deep ? deep : sums.deep;
	}
	return sums;
}

/* Tells whether the body touches none of the eight posts from here. */
static bool touches_none(const uint8_t *contact)
{
	const uint64_t bits = 0x0101010101010101u * (SOIL_LOWERED | SOIL_HELD);
	uint64_t eight;
	memcpy(&eight, contact, sizeof eight);
	return (eight & bits) == 0;
}

void soil_measure_row(struct soil_measured *measured, const struct soil_laying *laying, const struct soil_laid soils[SOIL_CLASSES],
		      const struct soil_row *row)
{
	int first = 0, last = row->count - 1;
	while (first + 7 <= last && touches_none(row->contact + first))
		first += 8;
	while (first <= last && !touches(row->contact[first]))
		first++;
	while (last - 7 > first && touches_none(row->contact + last - 7))
		last -= 8;
	while (first < last && !touches(row->contact[last]))
		last--;
	if (first > last)
		return;
	const int count = last - first + 1;
	struct sums sums;
	if (row->classes != NULL)
		sums = sum_classes(row, first, last, laying->rolls, soils);
	else if (row->dug != NULL)
		sums = sum_one(row->contact + first, row->carried + first, row->offset + first, row->dug + first, count, laying->rolls, soils[0].share);
	else
		sums = sum_undug(row->contact + first, row->carried + first, row->offset + first, count, soils[0].share);
	soil_measured_add(measured, laying, row->y, row->x + first, row->x + last, sums.carried, sums.givers, sums.classes, sums.deep);
}
