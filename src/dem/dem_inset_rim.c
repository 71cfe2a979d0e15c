/*
 * Finds how far each place of an inset is from its outline, and from the edge of a hole.
 *
 *   posts without data -> nodes beside them -> those connected to the border: the outline; others: holes -> distances
 */
#include "dem_inset.h"

#include <math.h>

#define NODES_MOST (1 << 22)
#define STRIP_POSTS (1 << 20)

enum { NODE_DATA, NODE_HOLE, NODE_OUTSIDE };

static size_t node_at(const struct inset_rim *rim, int64_t x, int64_t y)
{
	return (size_t)(y * rim->nodes[0] + x);
}

/* Marks the nodes of each block that a post without data is in; a post on a block's edge is in two. Where each post is a node, it is
 * marked alone. */
static void mark_row(const struct inset_rim *rim, int64_t y, const double *heights, uint8_t *kinds)
{
	const int64_t b = rim->block, beyond = b > 1 ? 1 : 0;
	for (int64_t x = 0; x < rim->width; x++) {
		if (!isnan(heights[x]))
			continue;
		for (int64_t ny = y / b - (beyond && y % b == 0); ny <= y / b + beyond; ny++)
			for (int64_t nx = x / b - (beyond && x % b == 0); nx <= x / b + beyond; nx++)
				if (nx >= 0 && ny >= 0 && nx < rim->nodes[0] && ny < rim->nodes[1])
					kinds[node_at(rim, nx, ny)] = NODE_HOLE;
	}
}

static enum status mark_holes(const struct inset_rim *rim, inset_rows_fn rows, void *user, uint8_t *kinds)
{
	const int64_t most = STRIP_POSTS / rim->width > 0 ? STRIP_POSTS / rim->width : 1;
	double *heights = mem_alloc((size_t)(most * rim->width), sizeof *heights);
	TRY_MEM(heights, "an inset");
	enum status status = STATUS_OK;
	for (int64_t y = 0; y < rim->height; y += most) {
		const int64_t count = rim->height - y < most ? rim->height - y : most;
		TRY_OR(done, rows(user, y, count, heights));
		for (int64_t row = 0; row < count; row++)
			mark_row(rim, y + row, heights + row * rim->width, kinds);
	}
done:
	mem_free(heights);
	return status;
}

/* Nodes on the border are outside, and those in holes that are connected with one. A last block that is not whole counts as border. */
static enum status mark_outside(const struct inset_rim *rim, uint8_t *kinds)
{
	const int64_t posts[2] = {rim->width, rim->height};
	int64_t *open = mem_alloc((size_t)(rim->nodes[0] * rim->nodes[1]), sizeof *open), count = 0;
	TRY_MEM(open, "an inset");
	for (int64_t y = 0; y < rim->nodes[1]; y++)
		for (int64_t x = 0; x < rim->nodes[0]; x++) {
			const int64_t at[2] = {x, y};
			bool border = false;
			for (int axis = 0; axis < 2; axis++)
				border |= at[axis] == 0 || (at[axis] + 1) * rim->block > posts[axis] - 1;
			if (border && kinds[node_at(rim, x, y)] == NODE_HOLE)
				open[count++] = y * rim->nodes[0] + x;
			if (border)
				kinds[node_at(rim, x, y)] = NODE_OUTSIDE;
		}
	while (count > 0) {
		const int64_t node = open[--count], x = node % rim->nodes[0], y = node / rim->nodes[0];
		for (int i = 0; i < 9; i++) {
			const int64_t nx = x + i % 3 - 1, ny = y + i / 3 - 1;
			if (nx < 0 || ny < 0 || nx >= rim->nodes[0] || ny >= rim->nodes[1] || kinds[node_at(rim, nx, ny)] != NODE_HOLE)
				continue;
			kinds[node_at(rim, nx, ny)] = NODE_OUTSIDE;
			open[count++] = ny * rim->nodes[0] + nx;
		}
	}
	mem_free(open);
	return STATUS_OK;
}

/* --- distances: the lower envelope of parabolas, Felzenszwalb and Huttenlocher 2012, section 2 --- */

struct envelope {
	int64_t *at;        /* where the parabolas stand */
	double *from, *squares; /* where each begins to be the lowest; a copy of the row */
};

/* Replaces count values, `stride` apart, by the least of value + the square of the distance, over all of the row. */
static void lower(const struct envelope *envelope, float *values, int64_t count, int64_t stride)
{
	int64_t last = -1;
	for (int64_t i = 0; i < count; i++) {
		const double value = values[i * stride];
		envelope->squares[i] = value;
		if (isinf(value))
			continue;
		double begins = -INFINITY;
		while (last >= 0) {
			const int64_t other = envelope->at[last];
			begins = (value + (double)(i * i) - envelope->squares[other] - (double)(other * other)) / (2.0 * (double)(i - other));
			if (begins > envelope->from[last])
				break;
			last--;
			begins = -INFINITY;
		}
		envelope->at[++last] = i;
		envelope->from[last] = begins;
	}
	for (int64_t i = 0, use = 0; i < count && last >= 0; i++) {
		while (use < last && envelope->from[use + 1] < (double)i)
			use++;
		const double apart = (double)(i - envelope->at[use]);
		values[i * stride] = (float)(apart * apart + envelope->squares[envelope->at[use]]);
	}
}

/* Makes values (0 or infinite) the distances in metres to the nearest node of value 0. */
static enum status distances(const struct inset_rim *rim, float *values)
{
	const int64_t most = rim->nodes[0] > rim->nodes[1] ? rim->nodes[0] : rim->nodes[1];
	struct envelope envelope = {mem_alloc((size_t)most, sizeof *envelope.at), mem_alloc((size_t)most, sizeof *envelope.from),
				    mem_alloc((size_t)most, sizeof *envelope.squares)};
	const bool whole = envelope.at != NULL && envelope.from != NULL && envelope.squares != NULL;
	for (int64_t x = 0; whole && x < rim->nodes[0]; x++)
		lower(&envelope, values + x, rim->nodes[1], rim->nodes[0]);
	for (int64_t y = 0; whole && y < rim->nodes[1]; y++)
		lower(&envelope, values + y * rim->nodes[0], rim->nodes[0], 1);
	for (int64_t i = 0; whole && i < rim->nodes[0] * rim->nodes[1]; i++)
		values[i] = (float)(sqrt((double)values[i]) * (double)rim->block * rim->spacing);
	mem_free_all(envelope.at, envelope.from, envelope.squares);
	return whole ? STATUS_OK : fail_memory("an inset");
}

static enum status take_distances(struct inset_rim *rim, const uint8_t *kinds)
{
	const size_t count = (size_t)(rim->nodes[0] * rim->nodes[1]);
	bool holes = false;
	for (size_t i = 0; i < count; i++)
		holes |= kinds[i] == NODE_HOLE;
	rim->far = mem_alloc(count, sizeof *rim->far);
	rim->deep = holes ? mem_alloc(count, sizeof *rim->deep) : NULL;
	if (rim->far == NULL || (holes && rim->deep == NULL))
		return fail_memory("an inset");
	for (size_t i = 0; i < count; i++) {
		rim->far[i] = kinds[i] == NODE_OUTSIDE ? 0 : INFINITY;
		if (holes)
			rim->deep[i] = kinds[i] == NODE_HOLE ? INFINITY : 0;
	}
	TRY(distances(rim, rim->far));
	return holes ? distances(rim, rim->deep) : STATUS_OK;
}

enum status dem_inset_rim_init(struct inset_rim *rim, inset_rows_fn rows, void *user)
{
	for (rim->block = 1;; rim->block *= 2) {
		rim->nodes[0] = (rim->width - 1 + rim->block - 1) / rim->block + 1;
		rim->nodes[1] = (rim->height - 1 + rim->block - 1) / rim->block + 1;
		if (rim->nodes[0] * rim->nodes[1] <= NODES_MOST)
			break;
	}
	uint8_t *kinds = mem_calloc((size_t)(rim->nodes[0] * rim->nodes[1]), 1);
	TRY_MEM(kinds, "an inset");
	enum status status;
	TRY_OR(done, mark_holes(rim, rows, user, kinds));
	TRY_OR(done, mark_outside(rim, kinds));
	TRY_OR(done, take_distances(rim, kinds));
done:
	mem_free(kinds);
	return status;
}

void dem_inset_rim_finish(struct inset_rim *rim)
{
	mem_free_all(rim->far, rim->deep);
	rim->far = rim->deep = NULL;
}

/* --- at a post --- */

static double between_nodes(const struct inset_rim *rim, const float *values, int64_t x, int64_t y)
{
	const int64_t b = rim->block, cx = x / b, cy = y / b;
	const double u = (double)(x % b) / (double)b, v = (double)(y % b) / (double)b;
	const float *row = values + node_at(rim, cx, cy);
	const int64_t east = u > 0 ? 1 : 0, north = v > 0 ? rim->nodes[0] : 0;
	return (1 - v) * ((1 - u) * row[0] + u * row[east]) + v * ((1 - u) * row[north] + u * row[north + east]);
}

/* 0 to 1 over the width of the feather, level at both ends. */
static double rise(const struct inset_rim *rim, double metres)
{
	if (metres >= rim->feather)
		return metres > 0 ? 1 : 0;
	const double t = metres / rim->feather;
	return t * t * (3 - 2 * t);
}

double dem_inset_rim_far(const struct inset_rim *rim, int64_t x, int64_t y)
{
	return between_nodes(rim, rim->far, x, y);
}

double dem_inset_rim_weight(const struct inset_rim *rim, int64_t x, int64_t y)
{
	const double weight = rise(rim, dem_inset_rim_far(rim, x, y));
	return rim->deep != NULL ? weight * (1 - rise(rim, between_nodes(rim, rim->deep, x, y))) : weight;
}
