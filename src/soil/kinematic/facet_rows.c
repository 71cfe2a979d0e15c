/* The lowest height of a moving triangle at posts of its rows. See facet_rows.h; shaders/lib/facet.glsl tells what the words of a facet hold. */
#include "soil/kinematic/facet_rows.h"

#include "soil/kinematic/rows.h"

enum { EDGE_ENTERS = 1, EDGE_LEAVES = 2 }; /* kinds of edges, with time counted back */

/* An affine number along a row: its value at the row's first post, and its change from post to post. right, left: how it is shifted. */
struct row_affine {
	uint64_t at, step;
	int right, left;
};

static SOIL_INLINED struct row_affine row_of(const int32_t words[4], int shift, int32_t x, int32_t y)
{
	const uint64_t first = (uint64_t)(uint32_t)words[1] << 32 | (uint32_t)words[0];
	return (struct row_affine){
		first + (uint64_t)lane_product(words[2], x) + (uint64_t)lane_product(words[3], y), (uint64_t)(int64_t)words[2],
		shift > 0 ? shift : 0, shift < 0 ? -shift : 0,
	};
}

static SOIL_INLINED int32_t fraction_of(uint64_t v, int right, int left)
{
	const int64_t w = (int64_t)(v << left) >> right, low = w < -(1 << 30) ? -(1 << 30) : w;
	return (int32_t)(low > 1 << 30 ? 1 << 30 : low);
}

/* How far the posts of a row are on the left of an edge: at or above 0. */
static SOIL_INLINED struct row_affine left_of(const int32_t from[2], const int32_t to[2], int32_t x, int32_t y)
{
	const int64_t ex = (int64_t)to[0] - from[0], ey = (int64_t)to[1] - from[1];
	const int64_t wx = (int64_t)x * 65536 - from[0], wy = (int64_t)y * 65536 - from[1];
	return (struct row_affine){(uint64_t)(ex * wy - ey * wx), (uint64_t)(-ey * 65536), 0, 0};
}

/* A facet at the posts of a row. */
struct facet_row {
	struct row_affine plane, inside[3], when[3], side[3];
	int kinds[3];
	int64_t change;          /* of the plane's height, with its fractions, to the time when the facet is lowest */
	bool later;              /* it is lowest when it leaves */
	int32_t low[2], high[2]; /* limits of its height: in motion, at rest */
};

/* Lowers the posts of a row to the facet in motion. `kinds` are told as literals where they are known. */
static SOIL_INLINED void sweep_row(const struct facet_row *r, int32_t count, int32_t *restrict under)
{
	for (int32_t i = 0; i < count; i++) {
		const uint64_t n = (uint64_t)(uint32_t)i;
		int32_t first = 0, last = ENVELOPE_ONE;
		int32_t v = fraction_of(r->plane.at + n * r->plane.step + (uint64_t)r->change, r->plane.right, r->plane.left);
		bool swept = true;
		for (int k = 0; k < 3; k++) {
			const int32_t when = fraction_of(r->when[k].at + n * r->when[k].step, r->when[k].right, r->when[k].left);
			const int32_t height = fraction_of(r->side[k].at + n * r->side[k].step, r->side[k].right, r->side[k].left);
			const bool enters = (r->kinds[k] == EDGE_ENTERS) & (when > first), leaves = (r->kinds[k] == EDGE_LEAVES) & (when < last);
			const bool inside = (int64_t)(r->inside[k].at + n * r->inside[k].step) >= 0;
			first = enters ? when : first;
			last = leaves ? when : last;
			v = (r->later ? leaves : enters) ? height : v;
			swept = swept & ((r->kinds[k] != 0) | inside);
		}
		v = lane_clamp(v, r->low[0], r->high[0]);
		under[i] = swept & (first <= last) & (v < under[i]) ? v : under[i];
	}
}

/* The same of the facet at rest. */
static SOIL_INLINED void rest_row(const struct facet_row *r, int32_t count, int32_t *restrict under, int32_t *restrict rest)
{
	for (int32_t i = 0; i < count; i++) {
		const uint64_t n = (uint64_t)(uint32_t)i;
		const int32_t height = fraction_of(r->plane.at + n * r->plane.step, r->plane.right, r->plane.left);
		const int32_t v = lane_clamp(height, r->low[1], r->high[1]);
		const bool inside = ((int64_t)(r->inside[0].at + n * r->inside[0].step) >= 0) & ((int64_t)(r->inside[1].at + n * r->inside[1].step) >= 0) &
				    ((int64_t)(r->inside[2].at + n * r->inside[2].step) >= 0);
		under[i] = inside & (v < under[i]) ? v : under[i];
		rest[i] = inside & (v < rest[i]) ? v : rest[i];
	}
}

SOIL_CLONED void soil_facet_rows(const struct facet *facet, size_t stride, int32_t *under, int32_t *rest)
{
	const int32_t *corners[3] = {facet->corners, facet->corners + 2, facet->third};
	const int32_t x0 = facet->cover[0] & 0xffff, x1 = (int32_t)((uint32_t)facet->cover[0] >> 16);
	const int32_t y0 = facet->cover[1] & 0xffff, y1 = (int32_t)((uint32_t)facet->cover[1] >> 16);
	const uint32_t kinds = (uint32_t)facet->cover[2], shifts = (uint32_t)facet->cover[3];
	const bool resting = (kinds & 1) != 0;
	struct facet_row row = {
		.later = facet->base[2] < 0,
		.low = {facet->third[2] - lane_most(facet->base[3], 0), facet->third[2]},
		.high = {facet->third[3] + lane_most(-facet->base[3], 0), facet->third[3]},
	};
	row.change = row.later ? ((int64_t)ENVELOPE_ONE * facet->base[2]) >> (kinds >> 8 & 63) : 0;
	bool moves = row.change != 0 || facet->base[3] != 0;
	for (int k = 0; k < 3; k++) {
		row.kinds[k] = (int)(kinds >> (2 + 2 * k) & 3);
		moves = moves || row.kinds[k] != 0;
	}
	for (int32_t y = y0; y < y1; y++) {
		const int32_t x_from = x0 - facet->base[0], y_from = y - facet->base[1];
		int32_t *lowest = under + (size_t)y * stride + (size_t)x0;
		row.plane = row_of(facet->plane, (int)(shifts >> 24) - 64, x_from, y_from);
		for (int k = 0; k < 3; k++) {
			row.inside[k] = left_of(corners[k], corners[(k + 1) % 3], x_from, y_from);
			row.when[k] = row_of(facet->edges[k], (int)(shifts >> (8 * k) & 255) - 64, x_from, y_from);
			row.side[k] = row_of(facet->sides[k], (int)(kinds >> (14 + 6 * k) & 63) - 32, x_from, y_from);
		}
		if (moves || !resting)
			sweep_row(&row, x1 - x0, lowest);
		if (resting)
			rest_row(&row, x1 - x0, lowest, rest + (size_t)y * stride + (size_t)x0);
	}
}
