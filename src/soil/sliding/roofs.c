/*
 * The part of sliding that keeps ground out of bodies. A post below a roof takes at most an eighth of the room that is left, from each of its eight
 * neighbours. So one iteration cannot bring it above the roof, and what a pair exchanges still depends on its two posts alone.
 */
#include "soil/sliding/sliding.h"

#define ROOF_FAR (1 << 30) /* fixed-point units above a post without a roof: more than all iterations can bring it up */
#define ROOF_NEAR (1 << 29)

static size_t stride_of(int64_t width)
{
	return (((size_t)width + 32 + 15) / 16 | 1) * 16;
}

size_t soil_roofs_scratch(const struct soil_planes *planes)
{
	return 2 * stride_of(planes->rect.x1 - planes->rect.x0) * (size_t)(planes->rect.y1 - planes->rect.y0 + 2) * sizeof(int32_t) + 64;
}

void soil_sliding_put_roofs(struct sliding_field *field)
{
	if (field->roofs == NULL)
		return;
	const struct soil_planes *planes = field->planes;
	const size_t posts = field->stride * (field->height + 2);
	int32_t *const first = (int32_t *)(((uintptr_t)field->roofs->scratch + 63) / 64 * 64);
	for (size_t i = 0; i < 2 * posts; i++)
		first[i] = 0;
	field->ceilings = first + field->stride + 16;
	field->waits = field->ceilings + posts;
	for (size_t y = 0; y < field->height; y++) {
		const size_t at = field->from + y * planes->width, to = y * field->stride;
		for (size_t x = 0; x < field->width; x++) {
			const uint32_t ground = (uint32_t)planes->base[at + x] * 4u;
			const int32_t highest = field->roofs->highest[at + x];
			field->ceilings[to + x] = highest == SOIL_ROOF_NONE ? (int32_t)((uint32_t)field->heights[to + x] + ROOF_FAR) : (int32_t)(ground + (uint32_t)highest);
		}
	}
}

/* Tells whether a post is below a roof. */
static bool is_below(const struct sliding_field *field, size_t post, int32_t height)
{
	return height != SLIDING_STILL && (int32_t)((uint32_t)field->ceilings[post] - (uint32_t)height) < ROOF_NEAR;
}

void soil_sliding_close_roofs(struct sliding_field *field)
{
	for (size_t y = 0; y < field->height && field->ceilings != NULL; y++)
		for (size_t post = y * field->stride; post < y * field->stride + field->width; post++) {
			field->waits[post] = field->heights[post];
			if (is_below(field, post, field->heights[post]))
				field->heights[post] = SLIDING_STILL;
		}
}

void soil_sliding_open_roofs(struct sliding_field *field)
{
	for (size_t y = 0; y < field->height && field->ceilings != NULL; y++)
		for (size_t post = y * field->stride; post < y * field->stride + field->width; post++)
			if (is_below(field, post, field->waits[post]))
				field->heights[post] = field->waits[post];
}

void soil_sliding_find_rooms(struct sliding_field *field)
{
	for (size_t y = 0; y < field->height && field->ceilings != NULL; y++)
		for (size_t post = y * field->stride; post < y * field->stride + field->width; post++)
			field->waits[post] = (int32_t)((uint32_t)field->ceilings[post] - (uint32_t)field->heights[post]) >> 3;
}
