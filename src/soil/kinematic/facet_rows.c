/*
 * The lowest height of a moving triangle at posts of its rows. See facet_rows.h; shaders/lib/facet.glsl tells what the words of a facet hold.
 *
 * Loops run over LANES posts at once, from a multiple of LANES on. Posts that lie beside the facet's columns are left as they are.
 */
#include "soil/kinematic/facet_rows.h"

#include "soil/kinematic/rows.h"

enum { EDGE_ENTERS = 1, EDGE_LEAVES = 2 }; /* kinds of edges, with time counted back */

/* An affine number: its value at the first post of a row, and its change for one post to the east and to the north. Its bits are shifted to the
 * right and to the left. */
struct affine_row {
	uint64_t at, east, north;
	int right, left;
};

/* x, y: the post from which it is given, from the facet's own one. */
SOIL_INLINED struct affine_row affine_from(const int32_t words[4], int shift, int32_t x, int32_t y)
{
	const uint64_t own = (uint64_t)(uint32_t)words[1] << 32 | (uint32_t)words[0];
	const uint64_t east = (uint64_t)(int64_t)words[2], north = (uint64_t)(int64_t)words[3];
	return (struct affine_row){
		own + east * (uint64_t)(int64_t)x + north * (uint64_t)(int64_t)y, east, north, shift > 0 ? shift : 0, shift < 0 ? -shift : 0,
	};
}

/* How far posts are on the left of an edge: at or above 0. */
SOIL_INLINED struct affine_row left_of(const int32_t from[2], const int32_t to[2], int32_t x, int32_t y)
{
	const int64_t ex = (int64_t)to[0] - from[0], ey = (int64_t)to[1] - from[1];
	const int64_t wx = (int64_t)x * 65536 - from[0], wy = (int64_t)y * 65536 - from[1];
	return (struct affine_row){(uint64_t)(ex * wy - ey * wx), (uint64_t)(-ey * 65536), (uint64_t)(ex * 65536), 0, 0};
}

SOIL_INLINED int32_t fraction_at(const struct affine_row *f, uint64_t post, uint64_t more)
{
	const int64_t w = (int64_t)((f->at + post * f->east + more) << f->left) >> f->right, low = w < -(1 << 30) ? -(1 << 30) : w;
	return (int32_t)(low > 1 << 30 ? 1 << 30 : low);
}

/* A facet at the posts of a row. */
struct facet_row {
	struct affine_row plane, inside[3], when[3], side[3];
	int kinds[3];
	uint64_t change;         /* of the plane's height, with its fractions, to the time when the facet is lowest */
	bool later;              /* it is lowest when it leaves */
	int32_t low[2], high[2]; /* limits of its height: in motion, at rest */
};

SOIL_INLINED void north(struct affine_row *f)
{
	f->at += f->north;
}

/* Returns which of LANES posts from `first` on are within the columns and on the left of the edges that count. */
SOIL_INLINED void inside_at(const struct facet_row *r, int32_t first, int32_t columns, bool moving, int64_t in[LANES])
{
	EACH_LANE(i) {
		const int32_t at = first + i;
		in[i] = (at >= 0) & (at < columns);
	}
	for (int k = 0; k < 3; k++) {
		if (moving && r->kinds[k] != 0)
			continue;
		EACH_LANE(i)
			in[i] &= (int64_t)(r->inside[k].at + (uint64_t)(int64_t)(first + i) * r->inside[k].east) >= 0;
	}
}

/* Lowers LANES posts to the facet in motion. first: the number of the first of them in the row. */
SOIL_INLINED void move(const struct facet_row *r, int32_t first, int32_t columns, int32_t *under)
{
	int64_t in[LANES];
	int32_t begins[LANES], ends[LANES], lowest[LANES];
	inside_at(r, first, columns, true, in);
	EACH_LANE(i) {
		begins[i] = 0;
		ends[i] = ENVELOPE_ONE;
		lowest[i] = fraction_at(&r->plane, (uint64_t)(int64_t)(first + i), r->change);
	}
	for (int k = 0; k < 3; k++) {
		if (r->kinds[k] == EDGE_ENTERS)
			EACH_LANE(i) {
				const int32_t when = fraction_at(&r->when[k], (uint64_t)(int64_t)(first + i), 0);
				const int32_t height = fraction_at(&r->side[k], (uint64_t)(int64_t)(first + i), 0);
				lowest[i] = (!r->later & (when > begins[i])) ? height : lowest[i];
				begins[i] = lane_most(begins[i], when);
			}
		else if (r->kinds[k] == EDGE_LEAVES)
			EACH_LANE(i) {
				const int32_t when = fraction_at(&r->when[k], (uint64_t)(int64_t)(first + i), 0);
				const int32_t height = fraction_at(&r->side[k], (uint64_t)(int64_t)(first + i), 0);
				lowest[i] = (r->later & (when < ends[i])) ? height : lowest[i];
				ends[i] = lane_least(ends[i], when);
			}
	}
	EACH_LANE(i) {
		const int32_t v = lane_clamp(lowest[i], r->low[0], r->high[0]);
		under[i] = ((in[i] != 0) & (begins[i] <= ends[i]) & (v < under[i])) ? v : under[i];
	}
}

/* The same of the facet at rest. */
SOIL_INLINED void stand(const struct facet_row *r, int32_t first, int32_t columns, int32_t *under, int32_t *rest)
{
	int64_t in[LANES];
	inside_at(r, first, columns, false, in);
	EACH_LANE(i) {
		const int32_t height = fraction_at(&r->plane, (uint64_t)(int64_t)(first + i), 0), v = lane_clamp(height, r->low[1], r->high[1]);
		under[i] = ((in[i] != 0) & (v < under[i])) ? v : under[i];
		rest[i] = ((in[i] != 0) & (v < rest[i])) ? v : rest[i];
	}
}

SOIL_LANES void soil_facet_rows(const struct facet *facet, size_t stride, int32_t *under, int32_t *rest)
{
	const int32_t *corners[3] = {facet->corners, facet->corners + 2, facet->third};
	const int32_t x0 = facet->cover[0] & 0xffff, x1 = (int32_t)((uint32_t)facet->cover[0] >> 16), columns = x1 - x0;
	const int32_t y0 = facet->cover[1] & 0xffff, y1 = (int32_t)((uint32_t)facet->cover[1] >> 16);
	const int32_t x = x0 - facet->base[0], y = y0 - facet->base[1], before = x0 % LANES;
	const uint32_t kinds = (uint32_t)facet->cover[2], shifts = (uint32_t)facet->cover[3];
	const bool resting = (kinds & 1) != 0;
	struct facet_row row = {
		.plane = affine_from(facet->plane, (int)(shifts >> 24) - 64, x, y),
		.later = facet->base[2] < 0,
		.low = {facet->third[2] - lane_most(facet->base[3], 0), facet->third[2]},
		.high = {facet->third[3] + lane_most(-facet->base[3], 0), facet->third[3]},
	};
	row.change = row.later ? (uint64_t)(((int64_t)ENVELOPE_ONE * facet->base[2]) >> (kinds >> 8 & 63)) : 0;
	bool moves = row.change != 0 || facet->base[3] != 0 || !resting;
	for (int k = 0; k < 3; k++) {
		row.kinds[k] = (int)(kinds >> (2 + 2 * k) & 3);
		row.inside[k] = left_of(corners[k], corners[(k + 1) % 3], x, y);
		row.when[k] = affine_from(facet->edges[k], (int)(shifts >> (8 * k) & 255) - 64, x, y);
		row.side[k] = affine_from(facet->sides[k], (int)(kinds >> (14 + 6 * k) & 63) - 32, x, y);
		moves = moves || row.kinds[k] != 0;
	}
	for (int32_t at = y0; at < y1; at++) {
		int32_t *lowest = under + (size_t)at * stride + (size_t)(x0 - before), *rests = rest + (size_t)at * stride + (size_t)(x0 - before);
		for (int32_t first = -before; first < columns; first += LANES, lowest += LANES, rests += LANES) {
			if (moves)
				move(&row, first, columns, lowest);
			if (resting)
				stand(&row, first, columns, lowest, rests);
		}
		north(&row.plane);
		for (int k = 0; k < 3; k++) {
			north(&row.inside[k]);
			north(&row.when[k]);
			north(&row.side[k]);
		}
	}
}
