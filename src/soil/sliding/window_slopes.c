/* Marks posts of a window beside which a slope could slide if it was high enough. Over a window the height of slopes is not known (slopes.c finds it
 * over blocks). */
#include "soil/sliding/sliding.h"

static const int ways[8][2] = {{0, -1}, {-1, 0}, {1, 0}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}}; /* four axial, four diagonal */

/* The rows of a post's neighbours: pairs are as in excess.c, but of all eight. */
SOIL_INLINED void steep_row(const int32_t *restrict heights, const int32_t *restrict grounds, ptrdiff_t stride, size_t width, int32_t rise,
			       uint8_t *restrict steep, bool stood)
{
	SOIL_APART
	for (ptrdiff_t x = 0; x < (ptrdiff_t)width; x++) {
		int32_t own = heights[x], any = 0;
#pragma GCC unroll 8
		for (int k = 0; k < 8; k++) {
			ptrdiff_t at = x + ways[k][0] + ways[k][1] * stride;
			int32_t other = heights[at], difference = (int32_t)((uint32_t)own - (uint32_t)other), sign = difference >> 31;
			int32_t high = (int32_t)(((uint32_t)difference ^ (uint32_t)sign) - (uint32_t)sign), more = 1;
			if (stood) {
				uint32_t risen = (uint32_t)difference - ((uint32_t)grounds[x] - (uint32_t)grounds[at]);
				more = (int32_t)((risen ^ (uint32_t)sign) - (uint32_t)sign);
			}
			any |= (int32_t)(other != SLIDING_STILL) & (int32_t)(high > rise) & (int32_t)(more > 0);
		}
		steep[x] = (uint8_t)(any & (int32_t)(own != SLIDING_STILL));
	}
}

SOIL_LANES static void steep_row_of_one_soil(const struct sliding_field *field, size_t row, uint8_t *steep)
{
	const size_t at = row * field->stride;
	const int32_t rise = field->rule->classes[0].rise[0];
	if (field->grounds != NULL)
		steep_row(field->heights + at, field->grounds + at, (ptrdiff_t)field->stride, field->width, rise, steep, true);
	else
		steep_row(field->heights + at, NULL, (ptrdiff_t)field->stride, field->width, rise, steep, false);
}

/* Returns whether soil could slide between two posts of the field, if the slope of the upper one was high enough. at, to: their places in the
 * field's arrays. from, beside: the same in the planes. */
static bool could_slide(const struct sliding_field *field, size_t at, size_t to, size_t from, size_t beside)
{
	int32_t own = field->heights[at], other = field->heights[to], difference = (int32_t)((uint32_t)own - (uint32_t)other);
	if (own == SLIDING_STILL || other == SLIDING_STILL)
		return false;
	const bool gives = difference > 0;
	uint8_t class = field->planes->classes[gives ? from : beside];
	int32_t high = gives ? difference : (int32_t)(0u - (uint32_t)difference), more = 1;
	if (field->grounds != NULL) {
		uint32_t risen = (uint32_t)difference - ((uint32_t)field->grounds[at] - (uint32_t)field->grounds[to]);
		more = (int32_t)(gives ? risen : 0u - risen);
	}
	return high > field->rule->classes[class < SOIL_CLASSES ? class : SOIL_CLASSES - 1].rise[0] && more > 0;
}

void soil_sliding_steep_row(const struct sliding_field *field, size_t row, uint8_t *steep)
{
	const size_t wide = field->planes->width;
	if (field->planes->classes == NULL) {
		steep_row_of_one_soil(field, row, steep);
		return;
	}
	for (size_t x = 0; x < field->width; x++) {
		const size_t at = row * field->stride + x, from = field->from + row * wide + x;
		bool any = false;
		for (int k = 0; k < 8; k++)
			any = any || could_slide(field, at, at + (size_t)(ways[k][0] + ways[k][1] * (ptrdiff_t)field->stride), from,
						 from + (size_t)(ways[k][0] + ways[k][1] * (ptrdiff_t)wide));
		steep[x] = any;
	}
}
