/* How much lower a mesh was during its motion, and the lowest places of cells: see fine.h. */
#include "soil/law/fine.h"

#define SAMPLES_MOST 128 /* of a motion */

SOIL_INLINED bool is_drawn(float height)
{
	return height < 0.5f * FINE_NONE;
}

/* Lowers a row to where the mesh was `share` of its motion ago. near, far: the rows of the raster that are there, so many places on. */
SOIL_INLINED void swept_row(const float *restrict near, const float *restrict far, float p, float q, float fell, float share, int32_t from, int32_t to, int32_t by,
			    float *restrict lowest, float *restrict since)
{
	for (int32_t i = from; i < to; i++) {
		const float a = near[i + by], b = near[i + by + 1], c = far[i + by], d = far[i + by + 1];
		const float low = a + p * (b - a), high = c + p * (d - c), height = low + q * (high - low) - fell;
		since[i] = either(height < lowest[i], share, since[i]);
		lowest[i] = least(lowest[i], height);
	}
}

SOIL_CLONED static void swept_to(const struct soil_fine *restrict fine, const float *restrict drawn, const float shift[restrict 2], float fell, float share,
				 float *restrict lowest, float *restrict since)
{
	int32_t whole[2];
	float part[2];
	for (int k = 0; k < 2; k++) {
		whole[k] = (int32_t)(shift[k] + 65536) - 65536;
		part[k] = shift[k] - (float)whole[k];
		part[k] = either(part[k] < 1e-3f, 0, part[k]); /* so that an edge along the motion stays as it is */
	}
	const int32_t right = part[0] > 0 ? whole[0] + 1 : whole[0], upper = part[1] > 0 ? whole[1] + 1 : whole[1];
	const int32_t from = whole[0] < 0 ? -whole[0] : 0, to = right > 0 ? fine->columns - 1 - right : fine->columns - 1;
	for (int32_t row = 0; row < fine->rows; row++) {
		if (row + whole[1] < 0 || row + upper >= fine->rows)
			continue;
		const float *near = drawn + (int64_t)(row + whole[1]) * fine->stride, *far = drawn + (int64_t)(row + upper) * fine->stride;
		const size_t at = (size_t)row * (size_t)fine->stride;
		swept_row(near, far, part[0], part[1], fell, share, from, to, whole[0], lowest + at, since + at);
	}
}

SOIL_CLONED static void put_less(const float *restrict heights, const float *restrict swept, size_t count, float *restrict less)
{
	for (size_t i = 0; i < count; i++)
		less[i] = either(swept[i] < 0.5f * FINE_NONE, most(heights[i] - swept[i], 0), 0);
}

void soil_fine_passed(const struct soil_fine_work *work, const struct soil_fine *fine)
{
	for (int32_t y = 0; y < fine->cells[1]; y++)
		for (int32_t x = 0; x < fine->cells[0]; x++) {
			const int32_t row = y * fine->parts + fine->parts / 2, column = x * fine->parts + fine->parts / 2;
			const float *at = work->swept + row * fine->stride + column;
			float low = at[0];
			if (!is_drawn(low)) {
				low = least(low, column > 0 ? at[-1] : FINE_NONE);
				low = least(low, column < fine->columns - 1 ? at[1] : FINE_NONE);
				low = least(low, row > 0 ? at[-fine->stride] : FINE_NONE);
				low = least(low, row < fine->rows - 1 ? at[fine->stride] : FINE_NONE);
			}
			work->passed[y * fine->cells[0] + x] = low;
		}
}

void soil_fine_less(const struct soil_fine_work *work, struct soil_fine *fine)
{
	put_less(work->heights, work->swept, (size_t)fine->stride * (size_t)fine->rows, work->less);
	fine->moved = 1;
	fine->less = work->less;
	fine->since = work->since;
	fine->passed = work->passed;
}

void soil_fine_swept(const struct soil_fine_work *work, const struct soil_form *form, struct soil_fine *fine)
{
	const float *way = form->way, run = form->passes[0];
	const size_t count = (size_t)fine->stride * (size_t)fine->rows;
	fine->less = fine->since = fine->passed = work->heights;
	fine->moved = 0;
	if (!(run > 0))
		return;
	/* The motion before this one was about the same. A part of it counts: over half a cell. */
	const float before = fabsf(way[2]) <= run ? least(form->half_across / run, 1) : 0;
	/* Samples lie a place apart and at both ends, so none jumps as the motion grows. */
	const float places = run * fine->by_step, each = most(1, places * (1.0f / SAMPLES_MOST)) / places, ends[2] = {1, 1 + before};
	const float turned[2] = {fine->axis[0] * way[0] - fine->axis[1] * way[1], fine->axis[1] * way[0] + fine->axis[0] * way[1]};
	const float *drawn = work->any_wall ? work->walls : work->drawn;
	memcpy(work->swept, drawn, count * sizeof *work->swept);
	memset(work->since, 0, count * sizeof *work->since);
	for (int k = 0; k < 2; k++) {
		const float from = k == 0 ? 0 : 1, length = ends[k] - from;
		const int32_t samples = (int32_t)ceilf(length / each);
		for (int32_t i = 1; i <= samples; i++) {
			const float share = from + least((float)i * each, length), shift[2] = {turned[0] * share * fine->by_step, turned[1] * share * fine->by_step};
			swept_to(fine, drawn, shift, share * way[2], share, work->swept, work->since);
		}
		if (k == 0)
			soil_fine_passed(work, fine);
	}
	soil_fine_less(work, fine);
}

/* --- the lowest places --- */

SOIL_CLONED static void put_lows(const struct soil_fine *restrict fine, const float *restrict places, float *restrict rows, float *restrict lows)
{
	const int32_t columns = fine->cells[0];
	for (int32_t y = 0; y < fine->cells[1]; y++) {
		const float *from = places + (size_t)(y * fine->parts) * (size_t)fine->stride;
		for (int32_t i = 0; i < fine->columns; i++)
			rows[i] = from[i];
		for (int32_t j = 1; j < fine->parts; j++)
			for (int32_t i = 0; i < fine->columns; i++)
				rows[i] = least(rows[i], from[j * fine->stride + i]);
		for (int32_t x = 0; x < columns; x++) {
			float low = rows[x * fine->parts];
			for (int32_t i = 1; i < fine->parts; i++)
				low = least(low, rows[x * fine->parts + i]);
			lows[y * columns + x] = low;
		}
	}
}

/* Each cell takes the lowest of the cells beside it, too. */
SOIL_CLONED static void spread(int32_t columns, int32_t rows, const float *restrict lows, float *restrict out)
{
	for (int32_t y = 0; y < rows; y++)
		for (int32_t x = 0; x < columns; x++) {
			const int32_t at = y * columns + x, west = x > 0 ? 1 : 0, east = x < columns - 1 ? 1 : 0;
			float low = FINE_NONE;
			for (int32_t j = y > 0 ? -1 : 0; j <= (y < rows - 1 ? 1 : 0); j++)
				low = least(low, least(lows[at + j * columns], least(lows[at + j * columns - west], lows[at + j * columns + east])));
			out[at] = low;
		}
}

void soil_fine_lows(const struct soil_fine_work *work, const struct soil_fine *fine)
{
	put_lows(fine, fine->moved > 0 ? work->swept : work->drawn, work->row, work->sums[1]);
	spread(fine->cells[0], fine->cells[1], work->sums[1], work->lows);
}
