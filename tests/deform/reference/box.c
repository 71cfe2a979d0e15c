/* The filter `box`, a post at a time, from the words of its definition. */
#include "deform/reference/reference.h"

static bool inside(int x, int y, int width, int height)
{
	return x >= 0 && y >= 0 && x < width && y < height;
}

/* Rounded to nearest, halves up. */
static int64_t rounded(int64_t sum, int64_t count)
{
	int64_t twice = 2 * sum + count, by = 2 * count;
	return twice / by - (twice % by < 0);
}

enum status reference_box(int width, int height, const int32_t *base, const uint8_t *contact, int radius,
			  int32_t *offset)
{
	int32_t *before = mem_alloc((size_t)width * (size_t)height, sizeof *before);
	if (before == NULL)
		return fail_memory("reference");
	for (int i = 0; i < width * height; i++)
		before[i] = offset[i];
	for (int y = 0; y < height; y++)
		for (int x = 0; x < width; x++) {
			int64_t sum = 0, count = 0;
			bool left = false;
			for (int dy = -radius; dy <= radius; dy++)
				for (int dx = -radius; dx <= radius; dx++) {
					if (!inside(x + dx, y + dy, width, height))
						continue;
					int at = (y + dy) * width + x + dx;
					left = left || (contact[at] & 3) == REFERENCE_SWEPT;
					if (base[at] == BASE_NODATA)
						continue;
					sum += before[at];
					count++;
				}
			int at = y * width + x;
			if (left && base[at] != BASE_NODATA && (contact[at] & REFERENCE_HELD) == 0)
				offset[at] = (int32_t)rounded(sum, count);
		}
	mem_free(before);
	return STATUS_OK;
}
