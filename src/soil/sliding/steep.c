/* Neighbours too far apart in height for 32 bits do not slide. */
#include <stdlib.h>

#include "soil/sliding/sliding.h"

/* Ranges in which no two posts are too far apart: of bases in 2^-18 m; of offsets and of laid soil in 2^-20 m. */
#define NEAR_BASES (1 << 27)
#define NEAR_OFFSETS (1 << 27)

/* What a rectangle of posts has. */
struct range {
	int32_t least, most;    /* bases; the least is one less, so that BASE_NODATA wraps to the greatest number */
	uint32_t offsets, laid; /* bits that are in any offset's amount, and in any laid soil: no value is above them */
};

SOIL_LANES static struct range find(const int32_t *restrict base, const int32_t *restrict offset, const int32_t *restrict deposits, size_t count,
					struct range range)
{
	int32_t least = range.least, most = range.most;
	uint32_t offsets = range.offsets, laid = range.laid;
	SOIL_APART
	for (size_t x = 0; x < count; x++) {
		int32_t own = base[x], low = (int32_t)((uint32_t)own - 1u);
		least = least < low ? least : low;
		most = most > own ? most : own;
		offsets |= (uint32_t)(offset[x] ^ (offset[x] >> 31));
		laid |= (uint32_t)deposits[x];
	}
	return (struct range){least, most, offsets, laid};
}

/* Returns the columns and rows of the planes that the field and a post around it have. */
static struct post_rect around(const struct sliding_field *field)
{
	return post_rect_intersect(post_rect_grown(field->rect, 1), field->planes->rect);
}

/* Returns true if no two posts of the field can be too far apart. */
static bool is_level(const struct sliding_field *field)
{
	const struct soil_planes *planes = field->planes;
	const struct post_rect rect = around(field), all = planes->rect;
	struct range range = {INT32_MAX, INT32_MIN, 0, 0};
	for (int64_t y = rect.y0; y < rect.y1; y++) {
		const size_t at = (size_t)(y - all.y0) * planes->width + (size_t)(rect.x0 - all.x0);
		const uint32_t laid = range.laid;
		/* Where no soil is laid, any row will do. */
		range = find(planes->base + at, planes->offset + at, (field->deposits != NULL ? field->deposits : planes->offset) + at,
			     (size_t)(rect.x1 - rect.x0), range);
		range.laid = field->deposits != NULL ? range.laid : laid;
	}
	return (int64_t)range.most - range.least < NEAR_BASES && range.offsets < NEAR_OFFSETS && range.laid < NEAR_OFFSETS;
}

/* Returns the offset of a post with the soil that is laid on it, as far as its range allows. */
static int32_t offset_with(const struct sliding_field *field, size_t at, bool heap)
{
	const struct soil_planes *planes = field->planes;
	int32_t offset = planes->offset[at], top = offset;
	if (heap && planes->deposited != NULL && planes->deposited[at] > top)
		top = planes->deposited[at];
	uint32_t room = (uint32_t)(top < SLIDING_HIGH ? SLIDING_HIGH - top : 0), laid = field->deposits != NULL ? (uint32_t)field->deposits[at] : 0;
	return offset + (int32_t)(laid < room ? laid : room);
}

static bool is_apart(const struct sliding_field *field, size_t at, size_t beside)
{
	const int32_t *bases = field->planes->base;
	int32_t base = bases[at], other = bases[beside], apart = (int32_t)((uint32_t)base - (uint32_t)other);
	if (other == BASE_NODATA)
		return false;
	bool wrapped = ((base ^ other) & (base ^ apart)) < 0 || apart > 1 << 30 || apart < -(1 << 30);
	int32_t offsets = (int32_t)((uint32_t)offset_with(field, at, true) - (uint32_t)offset_with(field, beside, false)) >> 2;
	return wrapped || llabs((int64_t)apart + offsets) >= SLIDING_APART;
}

void soil_sliding_part_steep(struct sliding_field *field)
{
	const struct soil_planes *planes = field->planes;
	const struct post_rect rect = field->rect, near = around(field);
	if (is_level(field))
		return;
	for (int64_t y = rect.y0; y < rect.y1; y++)
		for (int64_t x = rect.x0; x < rect.x1; x++) {
			size_t at = (size_t)(y - planes->rect.y0) * planes->width + (size_t)(x - planes->rect.x0);
			size_t to = (size_t)(y - rect.y0), column = (size_t)(x - rect.x0);
			bool still = field->stills[to * field->width + column] != 0;
			for (int k = 0; k < 9 && !still; k++) {
				int64_t px = x + k % 3 - 1, py = y + k / 3 - 1;
				bool inside = px >= near.x0 && px < near.x1 && py >= near.y0 && py < near.y1;
				still = inside && k != 4 && is_apart(field, at, at + (size_t)(k % 3) - 1 + (size_t)(k / 3) * planes->width - planes->width);
			}
			if (still) {
				field->stills[to * field->width + column] = 1;
				field->heights[to * field->stride + column] = SLIDING_STILL;
			}
		}
}
