/*
 * Smoothing of the model box: the same as shaders/deform/box.frag. A post takes the mean offset of its neighbourhood if the body has left a post
 * in it. The body has left a post that the contact lowered and that its end pose does not hold.
 *
 * Each post is one number of 64 bits. It adds up its offset, counted from the lowest possible one, COUNT if it has ground, and LEFT if the body has
 * left it. So one sum over a neighbourhood tells the sum of offsets, the number of posts, and whether the body has left one.
 */
#include <string.h>

#include "soil/kinematic/contact.h"
#include "soil/kinematic/rows.h"

#define COUNT ((uint64_t)1 << 40) /* more than the sum of 81 offsets */
#define LEFT ((uint64_t)1 << 48)

/* Fills the numbers of a row's posts. */
static SOIL_LANES void pack(int32_t count, const int32_t *restrict offset, const uint8_t *restrict contact, uint64_t *restrict packed)
{
	for (int32_t i = 0; i < count; i++) {
		const uint32_t bits = contact[i], left = bits & ~(bits >> 1) & SOIL_LOWERED;
		const uint64_t value = ((uint32_t)offset[i] ^ 0x80000000u) | COUNT;
		packed[i] = (bits & SOIL_NO_GROUND ? 0 : value) | left * LEFT;
	}
}

/* Adds a row to the sums of columns, and takes another from them. */
static SOIL_LANES void add(int32_t count, const uint64_t *restrict row, uint64_t *restrict sums)
{
	for (int32_t i = 0; i < count; i++)
		sums[i] += row[i];
}

static SOIL_LANES void take(int32_t count, const uint64_t *restrict row, uint64_t *restrict sums)
{
	for (int32_t i = 0; i < count; i++)
		sums[i] -= row[i];
}

/* Writes the means of a row's posts. sums: of columns, from `radius` columns before the first post on. */
SOIL_INLINED void means(int32_t count, int radius, const uint64_t *restrict sums, const uint8_t *restrict contact, int32_t *restrict offset)
{
	for (int32_t i = 0; i < count; i++) {
		uint64_t sum = 0;
		for (int k = 0; k <= 2 * radius; k++)
			sum += sums[i + k];
		const int32_t counted = (int32_t)(sum >> 40 & 255);
		const int64_t whole = (int64_t)(sum & (COUNT - 1)) + counted / 2;
		/* Exact: a quotient that is no whole number is further from the next one than doubles round here. */
		const double sum_all = (double)(int32_t)(whole >> 20) * 0x1p20 + (double)(int32_t)(whole & 0xfffff);
		const int32_t smooth = (int32_t)(floor(sum_all / (double)(counted > 0 ? counted : 1)) - 0x1p31);
		offset[i] = ((sum >= LEFT) & ((contact[i] & (SOIL_HELD | SOIL_NO_GROUND)) == 0)) ? smooth : offset[i];
	}
}

static SOIL_LANES void means_1(int32_t count, const uint64_t *sums, const uint8_t *contact, int32_t *offset)
{
	means(count, 1, sums, contact, offset);
}

static SOIL_LANES void means_2(int32_t count, const uint64_t *sums, const uint8_t *contact, int32_t *offset)
{
	means(count, 2, sums, contact, offset);
}

static SOIL_LANES void means_3(int32_t count, const uint64_t *sums, const uint8_t *contact, int32_t *offset)
{
	means(count, 3, sums, contact, offset);
}

static SOIL_LANES void means_4(int32_t count, const uint64_t *sums, const uint8_t *contact, int32_t *offset)
{
	means(count, 4, sums, contact, offset);
}

typedef void (*means_fn)(int32_t count, const uint64_t *sums, const uint8_t *contact, int32_t *offset);
static const means_fn of_radius[] = {NULL, means_1, means_2, means_3, means_4};

size_t soil_smooth_room(size_t width, size_t height, int radius)
{
	const size_t around = 2 * (size_t)radius;
	return (width + around) * (height + around + 1) * sizeof(uint64_t);
}

/* Packed numbers of the posts that are read: around the trail, also beyond the planes, where nothing counts. */
struct packed {
	int32_t x0, y0, width, height;
	uint64_t *rows, *sums;
};

static void pack_all(const struct soil_planes *planes, const struct packed *packed)
{
	const int32_t across = (int32_t)(planes->rect.x1 - planes->rect.x0), up = (int32_t)(planes->rect.y1 - planes->rect.y0);
	const int32_t first = lane_most(packed->x0, 0), last = lane_least(packed->x0 + packed->width, across);
	for (int32_t y = 0; y < packed->height; y++) {
		uint64_t *row = packed->rows + (size_t)y * (size_t)packed->width;
		const size_t at = (size_t)(packed->y0 + y) * planes->width + (size_t)first;
		const bool inside = packed->y0 + y >= 0 && packed->y0 + y < up;
		if (!inside || first > packed->x0 || last < packed->x0 + packed->width)
			memset(row, 0, (size_t)packed->width * sizeof *row);
		if (inside)
			pack(last - first, planes->offset + at, planes->contact + at, row + (first - packed->x0));
	}
}

void soil_smooth(const struct soil_kinematic *kinematic, const struct soil_planes *planes, struct smooth_posts trail, void *scratch)
{
	const int32_t r = kinematic->radius, count = trail.x1 - trail.x0;
	struct packed packed = {trail.x0 - r, trail.y0 - r, count + 2 * r, trail.y1 - trail.y0 + 2 * r, scratch, scratch};
	packed.rows += packed.width; /* the sums of columns come first */
	for (int n = 0; n < kinematic->repetitions; n++) {
		pack_all(planes, &packed);
		memset(packed.sums, 0, (size_t)packed.width * sizeof *packed.sums);
		for (int32_t y = 0; y < packed.height; y++) {
			add(packed.width, packed.rows + (size_t)y * (size_t)packed.width, packed.sums);
			if (y < 2 * r)
				continue;
			const size_t at = (size_t)(trail.y0 + y - 2 * r) * planes->width + (size_t)trail.x0;
			of_radius[r](count, packed.sums, planes->contact + at, planes->offset + at);
			take(packed.width, packed.rows + (size_t)(y - 2 * r) * (size_t)packed.width, packed.sums);
		}
	}
}
