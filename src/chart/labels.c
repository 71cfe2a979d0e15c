/*
 * Places for names on a map. A name is put beside its point: there are eight places around it. If none is free, a line leads from
 * the point to a name farther off. Of the free places the one is taken that covers least of what is drawn, then the earlier one.
 *
 * 1. No name meets another name, a point, or a line that leads to a name.
 * 2. A name lies wholly within the rectangle.
 */
#include <math.h>

#include "chart/internal.h"

#define GAP 4.0       /* points from a point to a name beside it */
#define DOT 3.2       /* points that a point takes to each side */
#define DIRECTIONS 16 /* of names with a line */
#define BESIDE 8
static const double rings[] = {16, 26, 38, 52}; /* lengths of these lines, points */
#define RINGS (sizeof rings / sizeof *rings)
#define CROWD 60 /* with more names than these, lines are short: long ones would make a tangle */
#define PAR 1.0  /* points between two names */

/* --- what names should not cover --- */

enum status chart_cover_create(const struct chart_rect *rect, struct chart_cover *out)
{
	*out = (struct chart_cover){*rect, (uint32_t)((rect->x1 - rect->x0) / CHART_COVER_CELL) + 1,
				    (uint32_t)((rect->y1 - rect->y0) / CHART_COVER_CELL) + 1, NULL};
	return mem_zeroed(&out->cells, (size_t)out->width, out->height, "a map's names");
}

void chart_cover_finish(struct chart_cover *cover)
{
	mem_free(cover->cells);
	cover->cells = NULL;
}

void chart_cover_line(struct chart_cover *cover, const double a[2], const double b[2])
{
	const double length = hypot(b[0] - a[0], b[1] - a[1]);
	const int64_t steps = (int64_t)(length / (CHART_COVER_CELL / 2)) + 1;
	for (int64_t i = 0; i <= steps; i++) {
		const double t = (double)i / (double)steps;
		const double x = (a[0] + t * (b[0] - a[0]) - cover->rect.x0) / CHART_COVER_CELL;
		const double y = (a[1] + t * (b[1] - a[1]) - cover->rect.y0) / CHART_COVER_CELL;
		if (x >= 0 && y >= 0 && x < cover->width && y < cover->height)
			cover->cells[(size_t)y * cover->width + (size_t)x] = 1;
	}
}

/* Cells under a rectangle that something is drawn in. */
static int covered(const struct chart_cover *cover, const struct chart_rect *rect)
{
	int count = 0;
	const int64_t left = (int64_t)fmax((rect->x0 - cover->rect.x0) / CHART_COVER_CELL, 0);
	const int64_t top = (int64_t)fmax((rect->y0 - cover->rect.y0) / CHART_COVER_CELL, 0);
	for (int64_t y = top; y < cover->height && cover->rect.y0 + (double)y * CHART_COVER_CELL < rect->y1; y++)
		for (int64_t x = left; x < cover->width && cover->rect.x0 + (double)x * CHART_COVER_CELL < rect->x1; x++)
			count += cover->cells[(size_t)y * cover->width + (size_t)x];
	return count;
}

/* --- candidates --- */

/* Candidate `which` of a label. Returns false after the last. */
static bool candidate(const struct chart_label *label, size_t which, size_t rings_used, struct chart_label *out)
{
	/* Right above, right, left above, left, right below, left below, above, below: shares of the name's size. */
	static const double beside[BESIDE][2] = {{0, -1}, {0, -0.5}, {-1, -1}, {-1, -0.5}, {0, 0}, {-1, 0}, {-0.5, -1}, {-0.5, 0}};
	*out = *label;
	double x = label->x, y = label->y;
	double px, py;
	if (which < BESIDE) {
		px = beside[which][0];
		py = beside[which][1];
		x += px == 0 ? GAP : px == -1 ? -GAP : 0;
		y += px == -0.5 ? (py == 0 ? GAP : -GAP) : py == -0.5 ? 0 : py == 0 ? GAP / 3 : -GAP / 3;
		out->led = false;
	} else {
		which -= BESIDE;
		if (which >= rings_used * DIRECTIONS)
			return false;
		const double turn = 2 * M_PI * ((double)(which % DIRECTIONS) + 0.5) / DIRECTIONS - M_PI / 2,
			     ring = rings[which / DIRECTIONS];
		x += ring * cos(turn);
		y += ring * sin(turn);
		px = cos(turn) > 0 ? 0 : -1;
		py = -0.5;
		out->lead[0] = x;
		out->lead[1] = y;
		x += cos(turn) > 0 ? 1.5 : -1.5;
		out->led = true;
	}
	const double left = x + px * label->width, top = y + py * label->height;
	out->rect = (struct chart_rect){left, top, left + label->width, top + label->height};
	return true;
}

/* --- what is free --- */

static bool line_meets(const double a[2], const double b[2], const struct chart_rect *rect)
{
	double from = 0, to = 1;
	const double low[2] = {rect->x0, rect->y0}, high[2] = {rect->x1, rect->y1};
	for (int axis = 0; axis < 2; axis++) {
		const double way = b[axis] - a[axis];
		if (way == 0) {
			if (a[axis] <= low[axis] || a[axis] >= high[axis])
				return false;
			continue;
		}
		const double p = (low[axis] - a[axis]) / way, q = (high[axis] - a[axis]) / way;
		from = fmax(from, fmin(p, q));
		to = fmin(to, fmax(p, q));
	}
	return from < to;
}

static double side_of(const double a[2], const double b[2], const double p[2])
{
	return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
}

static bool lines_cross(const double a[2], const double b[2], const double c[2], const double d[2])
{
	return side_of(a, b, c) * side_of(a, b, d) < 0 && side_of(c, d, a) * side_of(c, d, b) < 0;
}

static bool is_free(const struct chart_label *labels, size_t count, size_t self, const struct chart_label *label)
{
	const struct chart_rect wide = {label->rect.x0 - PAR, label->rect.y0 - PAR, label->rect.x1 + PAR, label->rect.y1 + PAR};
	const double from[2] = {label->x, label->y};
	for (size_t i = 0; i < count; i++) {
		const struct chart_label *other = &labels[i];
		const double at[2] = {other->x, other->y};
		const struct chart_rect dot = {at[0] - DOT, at[1] - DOT, at[0] + DOT, at[1] + DOT};
		if (chart_rect_meets(&label->rect, &dot) || (label->led && i != self && line_meets(from, label->lead, &dot) &&
							     hypot(at[0] - from[0], at[1] - from[1]) > 2 * DOT))
			return false;
		if (i == self || !other->shown)
			continue;
		if (chart_rect_meets(&wide, &other->rect) || (label->led && line_meets(from, label->lead, &other->rect)))
			return false;
		if (other->led &&
		    (line_meets(at, other->lead, &label->rect) || (label->led && lines_cross(from, label->lead, at, other->lead))))
			return false;
	}
	return true;
}

void chart_labels_place(struct chart_label *labels, size_t count, const struct chart_rect *rect, const struct chart_cover *cover)
{
	for (size_t i = 0; i < count; i++)
		labels[i].shown = false;
	for (size_t i = 0; i < count; i++) {
		struct chart_label tried, best = labels[i];
		int least = INT32_MAX;
		for (size_t which = 0; candidate(&labels[i], which, count > CROWD ? 1 : RINGS, &tried); which++) {
			if (which == BESIDE && least < INT32_MAX)
				break; /* beside it is better than at the end of a line */
			if (!chart_rect_within(&tried.rect, rect) || !is_free(labels, count, i, &tried))
				continue;
			const int cost = covered(cover, &tried.rect);
			if (cost < least) {
				least = cost;
				best = tried;
			}
		}
		best.shown = least < INT32_MAX;
		labels[i] = best;
	}
}
