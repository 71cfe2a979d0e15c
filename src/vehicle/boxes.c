/*
 * Where two boxes touch.
 *
 * MuJoCo 2.2.2 halves the depth of boxes that stand parallel, and finds one depth of their own size where they only just touch. So boxes have
 * an own search. It finds the axis of least depth among the faces' normals and the edges' products. Then it cuts the one box's face by the
 * other's sides, or finds the nearest places of two edges.
 */
#include <math.h>
#include <string.h>

#include "vehicle/between.h"

#define PARALLEL 1e-6  /* sine of the angle between edges that give no axis */
#define PREFERRED 0.05 /* of the depth: an edge must be better than a face by so much, and by */
#define CLOSER 1e-6    /* of the size of the smaller box */

struct boxes {
	const double *middle[2], *size[2];
	double axes[2][3][3];       /* of each box: unit vectors */
	double way[3];              /* from the first middle to the second */
};

struct axis {
	double gap, normal[3];      /* normal: from the first box to the second */
	int box, face;              /* of a face */
	int edge[2];                /* of two edges; box is -1 */
};

/* --- the axis --- */

/* How far the boxes are apart along a unit vector; below 0: how deep one is in the other. Turns it to point to the second box. */
static double gap_along(const struct boxes *boxes, double normal[3])
{
	double gap = mju_dot3(boxes->way, normal);
	if (gap < 0) {
		mju_scl3(normal, normal, -1);
		gap = -gap;
	}
	for (int b = 0; b < 2; b++)
		for (int i = 0; i < 3; i++)
			gap -= boxes->size[b][i] * fabs(mju_dot3(boxes->axes[b][i], normal));
	return gap;
}

static void find_axis(const struct boxes *boxes, struct axis *best)
{
	double least = INFINITY;
	best->gap = -INFINITY;
	for (int b = 0; b < 2; b++)
		for (int i = 0; i < 3; i++) {
			struct axis axis = {.box = b, .face = i};
			mju_copy3(axis.normal, boxes->axes[b][i]);
			axis.gap = gap_along(boxes, axis.normal);
			least = fmin(least, boxes->size[b][i]);
			if (axis.gap > best->gap + (b == 1 ? CLOSER * least : 0))
				*best = axis;
		}
	const double wanted = best->gap + PREFERRED * fabs(best->gap) + CLOSER * least;
	struct axis edge = {.gap = wanted, .box = -1};
	for (int i = 0; i < 3; i++)
		for (int j = 0; j < 3; j++) {
			double normal[3];
			mju_cross(normal, boxes->axes[0][i], boxes->axes[1][j]);
			if (mju_normalize3(normal) < PARALLEL)
				continue;
			const double gap = gap_along(boxes, normal);
			if (gap <= edge.gap)
				continue;
			edge = (struct axis){.gap = gap, .box = -1, .edge = {i, j}};
			mju_copy3(edge.normal, normal);
		}
	if (edge.gap > wanted)
		*best = edge;
}

/* --- two edges --- */

static int meet_edges(const struct boxes *boxes, const struct axis *axis, struct touch *out)
{
	double at[2][3];
	for (int b = 0; b < 2; b++) {
		mju_copy3(at[b], boxes->middle[b]);
		for (int i = 0; i < 3; i++) {
			const double toward = (b == 0 ? 1 : -1) * mju_dot3(boxes->axes[b][i], axis->normal);
			if (i != axis->edge[b])
				mju_addToScl3(at[b], boxes->axes[b][i], toward > 0 ? boxes->size[b][i] : -boxes->size[b][i]);
		}
	}
	/* The nearest places of two lines. */
	const double *u = boxes->axes[0][axis->edge[0]], *v = boxes->axes[1][axis->edge[1]], both = mju_dot3(u, v);
	double way[3];
	mju_sub3(way, at[1], at[0]);
	const double along[2] = {mju_dot3(way, u), mju_dot3(way, v)}, sine = 1 - both * both;
	mju_addToScl3(at[0], u, (along[0] - both * along[1]) / sine);
	mju_addToScl3(at[1], v, (both * along[0] - along[1]) / sine);
	out->gap = axis->gap;
	mju_copy3(out->normal, axis->normal);
	for (int i = 0; i < 3; i++)
		out->place[i] = (at[0][i] + at[1][i]) / 2;
	return 1;
}

/* --- a face and what the other box puts on it --- */

/* Cuts off what of a polygon is beyond `most` along an axis. Returns the number of corners. */
static int cut(double corners[][3], int count, const double middle[3], const double axis[3], double most)
{
	double kept[16][3], beyond[16], from[3];
	int next = 0;
	for (int i = 0; i < count; i++) {
		mju_sub3(from, corners[i], middle);
		beyond[i] = mju_dot3(from, axis) - most;
	}
	for (int i = 0; i < count; i++) {
		const int after = (i + 1) % count;
		if (beyond[i] <= 0)
			mju_copy3(kept[next++], corners[i]);
		if ((beyond[i] < 0 && beyond[after] > 0) || (beyond[i] > 0 && beyond[after] < 0)) {
			const double share = beyond[i] / (beyond[i] - beyond[after]);
			mju_sub3(from, corners[after], corners[i]);
			mju_addScl3(kept[next++], corners[i], from, share);
		}
	}
	memcpy(corners, kept, (size_t)next * sizeof *kept);
	return next;
}

static int meet_face(const struct boxes *boxes, const struct axis *axis, double margin, struct touch *out)
{
	const int one = axis->box, other = 1 - one;
	const double(*mine)[3] = boxes->axes[one], (*its)[3] = boxes->axes[other];
	double outward[3], back[3], corners[16][3], middle[3];
	int face = 0, count = 4, found = 0;
	mju_scl3(outward, axis->normal, one == 0 ? 1 : -1);
	for (int i = 1; i < 3; i++)
		face = fabs(mju_dot3(its[i], outward)) > fabs(mju_dot3(its[face], outward)) ? i : face;
	const double side = mju_dot3(its[face], outward) > 0 ? -1 : 1;
	mju_addScl3(middle, boxes->middle[other], its[face], side * boxes->size[other][face]);
	for (int i = 0; i < 4; i++) {
		const int a = (face + 1) % 3, b = (face + 2) % 3;
		mju_addScl3(corners[i], middle, its[a], i == 0 || i == 3 ? boxes->size[other][a] : -boxes->size[other][a]);
		mju_addToScl3(corners[i], its[b], i < 2 ? boxes->size[other][b] : -boxes->size[other][b]);
	}
	for (int i = 0; i < 3; i++) {
		if (i == axis->face)
			continue;
		mju_scl3(back, mine[i], -1);
		count = cut(corners, count, boxes->middle[one], mine[i], boxes->size[one][i]);
		count = cut(corners, count, boxes->middle[one], back, boxes->size[one][i]);
	}
	for (int i = 0; i < count && found < TOUCHES_MOST; i++) {
		double from[3];
		mju_sub3(from, corners[i], boxes->middle[one]);
		const double gap = mju_dot3(from, outward) - boxes->size[one][axis->face];
		if (gap >= margin)
			continue;
		out[found].gap = gap;
		mju_copy3(out[found].normal, axis->normal);
		mju_addScl3(out[found++].place, corners[i], outward, -gap / 2);
	}
	return found;
}

int vehicle_boxes_touch(const double *const middle[2], const double *const mat[2], const double *const size[2], double margin, struct touch *out)
{
	struct boxes boxes = {.middle = {middle[0], middle[1]}, .size = {size[0], size[1]}};
	struct axis axis;
	for (int b = 0; b < 2; b++)
		for (int i = 0; i < 3; i++)
			for (int k = 0; k < 3; k++)
				boxes.axes[b][i][k] = mat[b][3 * k + i];
	mju_sub3(boxes.way, middle[1], middle[0]);
	find_axis(&boxes, &axis);
	if (axis.gap >= margin)
		return 0;
	return axis.box < 0 ? meet_edges(&boxes, &axis, out) : meet_face(&boxes, &axis, margin, out);
}
