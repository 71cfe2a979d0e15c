/*
 * Heights beside a mesh, which go on from its edge: see fine.h. A place that is not drawn has two estimates, along its column and along its row.
 * Each is from the nearest place that is drawn, and the slope there. The nearer one counts more.
 */
#include "soil/law/fine.h"

#define NEVER 1e6f /* places: nothing is drawn in that direction */

SOIL_INLINED bool is_drawn(float height)
{
	return height < 0.5f * FINE_NONE;
}

/* The last drawn place of each column on the way, its slope, and how many places ago it was. */
struct ways {
	float *restrict last, *restrict slope, *restrict away;
};

/* Goes on by a row. before: the row before it, or the same. Replaces estimates that are from farther away. */
SOIL_CLONED static void on_by_row(const float *restrict drawn, const float *restrict before, int32_t columns, const struct ways *restrict ways, float *restrict estimate,
				  float *restrict away)
{
	float *restrict last = ways->last, *restrict slope = ways->slope, *restrict since = ways->away;
	for (int32_t i = 0; i < columns; i++) {
		const bool is = is_drawn(drawn[i]), was = is_drawn(before[i]);
		slope[i] = either(is, either(was, drawn[i] - before[i], 0), slope[i]);
		last[i] = either(is, drawn[i], last[i]);
		since[i] = either(is, 0, since[i] + 1);
		const float height = last[i] + slope[i] * since[i], both = either(since[i] < away[i], height, 0.5f * (height + estimate[i]));
		estimate[i] = either(since[i] <= away[i], both, estimate[i]);
		away[i] = least(away[i], since[i]);
	}
}

static void begin_ways(const struct ways *ways, int32_t columns)
{
	for (int32_t i = 0; i < columns; i++) {
		ways->last[i] = ways->slope[i] = 0;
		ways->away[i] = NEVER;
	}
}

/* Puts the estimates along columns. */
static void along_columns(const struct soil_fine_work *work, const struct soil_fine *fine, float *estimate, float *away)
{
	const struct ways ways = {work->row, work->row + fine->stride, work->row + 2 * fine->stride};
	const float *drawn = work->drawn;
	const int64_t stride = fine->stride, rows = fine->rows;
	for (int64_t i = 0; i < stride * rows; i++) {
		estimate[i] = 0;
		away[i] = 2 * NEVER;
	}
	begin_ways(&ways, fine->columns);
	for (int64_t row = 0; row < rows; row++)
		on_by_row(drawn + row * stride, drawn + (row > 0 ? row - 1 : row) * stride, fine->columns, &ways, estimate + row * stride, away + row * stride);
	begin_ways(&ways, fine->columns);
	for (int64_t row = rows - 1; row >= 0; row--)
		on_by_row(drawn + row * stride, drawn + (row < rows - 1 ? row + 1 : row) * stride, fine->columns, &ways, estimate + row * stride, away + row * stride);
}

/* Puts the estimates along a row, from one end to the other. */
static void along_row(const float *drawn, int32_t first, int32_t end, float *estimate, float *away)
{
	const int32_t way = end > first ? 1 : -1;
	float last = 0, slope = 0, since = NEVER;
	for (int32_t i = first; i != end; i += way) {
		since++;
		if (is_drawn(drawn[i])) {
			slope = i != first && is_drawn(drawn[i - way]) ? drawn[i] - drawn[i - way] : 0;
			last = drawn[i];
			since = 0;
		}
		if (since <= away[i])
			estimate[i] = since < away[i] ? last + slope * since : 0.5f * (estimate[i] + last + slope * since);
		away[i] = least(away[i], since);
	}
}

SOIL_CLONED static void join(const float *restrict drawn, const float *restrict column, const float *restrict column_away, const float *restrict row, const float *restrict row_away,
			     int32_t columns, float bound, float *restrict heights)
{
	for (int32_t i = 0; i < columns; i++) {
		const float a = column_away[i] * column_away[i], b = row_away[i] * row_away[i], ahead = b * b / most(a * a + b * b, 1e-30f);
		const bool any = least(column_away[i], row_away[i]) < 0.5f * NEVER;
		const float height = clamped(ahead * column[i] + (1 - ahead) * row[i], -bound, bound);
		heights[i] = either(is_drawn(drawn[i]), drawn[i], either(any, height, FINE_NONE));
	}
}

/* Continues a row from the one before it, where it has no estimate. inner: the row before that, or the same. */
SOIL_CLONED static void next_row(const float *restrict from, const float *restrict inner, float *restrict to, int32_t columns, float bound)
{
	for (int32_t i = 0; i < columns; i++) {
		const bool known = is_drawn(from[i]), two = is_drawn(inner[i]);
		to[i] = either(!is_drawn(to[i]) & known, clamped(either(two, 2 * from[i] - inner[i], from[i]), -bound, bound), to[i]);
	}
}

void soil_fine_beside(const struct soil_fine_work *work, const struct soil_fine *fine, float bound)
{
	float *heights = work->heights, *estimate = work->less, *away = work->since, *row_estimate = work->row, *row_away = work->row + fine->stride;
	const int64_t stride = fine->stride, rows = fine->rows;
	const float most_height = most(bound, 0);
	along_columns(work, fine, estimate, away);
	for (int64_t row = 0; row < rows; row++) {
		const float *drawn = work->drawn + row * stride;
		for (int32_t i = 0; i < fine->columns; i++)
			row_away[i] = 2 * NEVER;
		along_row(drawn, 0, fine->columns, row_estimate, row_away);
		along_row(drawn, fine->columns - 1, -1, row_estimate, row_away);
		join(drawn, estimate + row * stride, away + row * stride, row_estimate, row_away, fine->columns, most_height, heights + row * stride);
	}
	for (int64_t row = 1; row < rows; row++)
		next_row(heights + (row - 1) * stride, heights + (row > 1 ? row - 2 : row - 1) * stride, heights + row * stride, fine->columns, most_height);
	for (int64_t row = rows - 2; row >= 0; row--)
		next_row(heights + (row + 1) * stride, heights + (row < rows - 2 ? row + 2 : row + 1) * stride, heights + row * stride, fine->columns, most_height);
	for (int64_t i = 0; i < stride * rows; i++)
		heights[i] = either(is_drawn(heights[i]), heights[i], most_height);
}
