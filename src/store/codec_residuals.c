/* Computes the residuals of a plane, for the encoder: each post minus its prediction from neighbours, as an unsigned number. */
#include "store/codec_residuals.h"

#include "base/wide.h"
#include "store/codec.h"

static uint32_t zigzag(uint32_t value)
{
	return value << 1 ^ (0u - (value >> 31));
}

/* Takes a row without holes. The residuals depend on posts only. `before`: the row before, NULL for row 0. */
FURROW_WIDE static void take_row(const uint32_t *row, const uint32_t *before, uint32_t side, uint32_t first, bool slope,
		     uint32_t *rest)
{
	rest[0] = zigzag(row[0] - (before != NULL ? before[0] : first));
	uint32_t from = 1;
	if (slope) { /* the second post's step is its own */
		rest[1] = zigzag(row[1] - row[0] - (before != NULL ? before[1] - before[0] : 0));
		from = 2;
	}
	if (before == NULL && slope)
		for (uint32_t x = from; x < side; x++)
			rest[x] = zigzag(row[x] - 2 * row[x - 1] + row[x - 2]);
	else if (before == NULL)
		for (uint32_t x = from; x < side; x++)
			rest[x] = zigzag(row[x] - row[x - 1]);
	else if (slope)
		for (uint32_t x = from; x < side; x++)
			rest[x] = zigzag(row[x] - 2 * row[x - 1] + row[x - 2] -
					 (before[x] - 2 * before[x - 1] + before[x - 2]));
	else
		for (uint32_t x = from; x < side; x++)
			rest[x] = zigzag(row[x] - row[x - 1] - (before[x] - before[x - 1]));
}

/* Takes a row that may have holes. A hole's post is its prediction, so later predictions depend on it. */
static void take_row_with_holes(const int32_t *row, const int32_t *before, uint32_t side, uint32_t first,
				bool slope, int32_t *filled, uint32_t *rest)
{
	uint32_t rise = 0, step = 0; /* of the post before: over the row before it, and by how much more */
	for (uint32_t x = 0; x < side; x++) {
		uint32_t under = before != NULL ? (uint32_t)before[x] : first;
		uint32_t guess = under + rise + (slope && x > 1 ? step : 0);
		bool hole = row[x] == CODEC_NODATA;
		uint32_t post = hole ? guess : (uint32_t)row[x];
		rest[x] = hole ? 0 : zigzag(post - guess);
		filled[x] = (int32_t)post;
		step = post - under - rise;
		rise = post - under;
	}
}

FURROW_WIDE static bool row_has_holes(const int32_t *row, uint32_t side)
{
	unsigned any = 0;
	for (uint32_t x = 0; x < side; x++)
		any |= row[x] == CODEC_NODATA;
	return any != 0;
}

void store_residuals_take(const int32_t *posts, uint32_t side, uint32_t first, bool slope, bool holes,
		    int32_t *filled, uint32_t *rest)
{
	const int32_t *before = NULL;
	for (uint32_t y = 0; y < side; y++, posts += side, rest += side) {
		const int32_t *row = posts;
		if (holes && row_has_holes(posts, side)) {
			row = filled + (size_t)y * side;
			take_row_with_holes(posts, before, side, first, slope, filled + (size_t)y * side, rest);
		} else {
			take_row((const uint32_t *)posts, (const uint32_t *)before, side, first, slope, rest);
		}
		before = row;
	}
}
