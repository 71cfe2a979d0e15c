/*
 * An iteration of sliding by Sumner's rule (kinematic/shed.h): first each post sheds, then each takes what its neighbours shed.
 *
 * A row sheds only where some difference is steep enough, so ground at rest costs one look at its heights.
 */
#include <assert.h>
#include <string.h>

#include "soil/kinematic/shed.h"
#include "soil/sliding/sliding.h"

#define PART 64 /* posts that are changed together */

/* Computes what a row sheds, in these columns. */
static void shed_row(const struct sliding_field *field, size_t y, struct sliding_span span)
{
	const struct soil_planes *planes = field->planes;
	const size_t first = (size_t)span.first, at = y * field->stride + first;
	const size_t post = field->from + y * planes->width + first;
	struct soil_shed_rows rows = {.count = span.end - span.first, .classes = planes->classes != NULL ? planes->classes + post : NULL};
	for (int k = 0; k < 3; k++) {
		const ptrdiff_t row = k - 1;
		rows.heights[k] = field->heights + (ptrdiff_t)at + row * (ptrdiff_t)field->stride;
		rows.contacts[k] = planes->contact + (ptrdiff_t)post + row * (ptrdiff_t)planes->width;
		rows.grounds[k] = field->grounds != NULL ? field->grounds + (ptrdiff_t)at + row * (ptrdiff_t)field->stride : NULL;
		rows.rooms[k] = field->ceilings != NULL ? field->waits + (ptrdiff_t)at + row * (ptrdiff_t)field->stride : NULL;
	}
	soil_shed_row(field->rule->shed, &rows, field->sheds + at);
}

/* Each post of these columns takes what its neighbours shed. */
static void take_row(struct sliding_field *field, size_t y, struct sliding_span span, bool last, bool window)
{
	for (int32_t first = span.first; first < span.end; first += PART) {
		const int32_t count = span.end - first < PART ? span.end - first : PART;
		const size_t at = y * field->stride + (size_t)first;
		const int32_t *const sheds[3] = {field->sheds + at - field->stride, field->sheds + at, field->sheds + at + field->stride};
		int32_t *height = field->heights + at, change[PART];
		uint8_t moves[PART];
		const int32_t *rooms[3] = {NULL};
		for (size_t k = 0; k < 3 && field->ceilings != NULL; k++)
			rooms[k] = field->waits + at + k * field->stride - field->stride;
		soil_shed_take_row(count, sheds, rooms[0] != NULL ? rooms : NULL, window, change, last ? moves : NULL);
		for (int32_t i = 0; i < count; i++)
			height[i] = (int32_t)((uint32_t)height[i] + (uint32_t)change[i]);
		if (last)
			memcpy(field->moved + y * field->width + (size_t)first, moves, (size_t)count);
	}
}

void soil_sliding_shed(struct sliding_field *field, size_t trim, bool last, bool window)
{
	const size_t around = trim > 0 ? trim - 1 : 0, top = field->height - around; /* posts that shed: one more on each side */
	const struct sliding_span sheds = {(int32_t)around, (int32_t)(field->width - around)};
	const struct sliding_span takes = {(int32_t)trim, (int32_t)(field->width - trim)};
	struct sliding_span *const shed = field->next + 1; /* columns that shed, of each row, of the one before and the one behind */
	struct sliding_span south = {0, 0};
	assert(field->planes->contact != NULL);
	soil_sliding_find_rooms(field);
	if (last)
		memset(field->moved, 0, field->width * field->height);
	for (size_t y = 0; y < field->height + 2; y++)
		field->next[y] = (struct sliding_span){0, 0};
	for (size_t y = around > 0 ? around - 1 : 0; y < top; y++) {
		const struct sliding_span here = soil_sliding_steep_span(field->heights + y * field->stride, field->stride, field->width, field->least);
		const struct sliding_span span = soil_sliding_wider(soil_sliding_both(here, south), sheds);
		south = here;
		if (y < around)
			continue;
		memset(field->sheds + y * field->stride - 1, 0, (field->width + 2) * sizeof *field->sheds);
		shed[y] = soil_sliding_is_empty(span) || span.first >= sheds.end || span.end <= sheds.first ? (struct sliding_span){0, 0} : span;
		shed[y].first = shed[y].first < sheds.first && !soil_sliding_is_empty(shed[y]) ? sheds.first : shed[y].first;
		shed[y].end = shed[y].end > sheds.end ? sheds.end : shed[y].end;
		if (!soil_sliding_is_empty(shed[y]))
			shed_row(field, y, shed[y]);
	}
	for (size_t y = trim; y < field->height - trim; y++) {
		struct sliding_span span = soil_sliding_wider(soil_sliding_both(soil_sliding_both(shed[(ptrdiff_t)y - 1], shed[y]), shed[y + 1]), takes);
		span.first = span.first < takes.first ? takes.first : span.first;
		span.end = span.end > takes.end ? takes.end : span.end;
		if (!soil_sliding_is_empty(span))
			take_row(field, y, span, last, window);
	}
}
