/*
 * Heights for globes where the terrain has none: in its holes, and beyond its edges.
 *
 * A globe has a height everywhere. A cover is a coarse grid of the base, with at most COVER_MOST posts along a side, whose holes are
 * filled from their rims. Beyond the edges it goes on with the heights there. It is made of the base alone: a drive does not change it.
 */
#include "exchange/internal.h"

#include <string.h>

#define COVER_MOST 513
#define PASSES 40 /* that smooth what was filled */

/* Makes posts that are not known means of their four neighbours, several times. `was`: the posts as they were given. */
static void smooth(double *posts, const double *was, int64_t width, int64_t height)
{
	for (int pass = 0; pass < PASSES; pass++)
		for (int64_t y = 0; y < height; y++)
			for (int64_t x = 0; x < width; x++) {
				double *p = posts + y * width + x;
				if (!isnan(was[y * width + x]))
					continue;
				*p = (p[x > 0 ? -1 : 0] + p[x + 1 < width ? 1 : 0] + p[y > 0 ? -width : 0] + p[y + 1 < height ? width : 0]) / 4;
			}
}

/* Fills posts that are not known from a grid of half as many, in which each is the mean of what is known of four. */
static enum status fill(double *posts, int64_t width, int64_t height)
{
	const int64_t half[2] = {(width + 1) / 2, (height + 1) / 2};
	const size_t count = (size_t)(width * height);
	size_t known = 0;
	for (size_t i = 0; i < count; i++)
		known += !isnan(posts[i]);
	if (known == count)
		return STATUS_OK;
	if (known == 0) {
		memset(posts, 0, count * sizeof *posts);
		return STATUS_OK;
	}
	double *was = NULL, *coarse = NULL;
	enum status status;
	TRY_OR(done, mem_make(&was, count, sizeof *was, "filling holes"));
	TRY_OR(done, mem_make(&coarse, (size_t)(half[0] * half[1]), sizeof *coarse, "filling holes"));
	memcpy(was, posts, count * sizeof *was);
	for (int64_t y = 0; y < half[1]; y++)
		for (int64_t x = 0; x < half[0]; x++) {
			double sum = 0, parts = 0;
			for (int64_t i = 0; i < 4; i++) {
				const int64_t px = 2 * x + i % 2, py = 2 * y + i / 2;
				if (px >= width || py >= height || isnan(posts[py * width + px]))
					continue;
				sum += posts[py * width + px];
				parts++;
			}
			coarse[y * half[0] + x] = parts > 0 ? sum / parts : (double)NAN;
		}
	TRY_OR(done, fill(coarse, half[0], half[1]));
	for (size_t i = 0; i < count; i++)
		if (isnan(was[i]))
			posts[i] = coarse[(int64_t)i / width / 2 * half[0] + (int64_t)i % width / 2];
	smooth(posts, was, width, height);
done:
	mem_free_all(was, coarse);
	return status;
}

enum status exchange_cover_init(struct exchange_cover *cover, const struct exchange_frame *frame, struct store_reader *reader)
{
	const struct extent *extent = &frame->meta->extent;
	int level = 0;
	while (level < extent_coarsest(extent) && (extent_posts(extent->width, level) > COVER_MOST || extent_posts(extent->height, level) > COVER_MOST))
		level++;
	*cover = (struct exchange_cover){
		.width = extent_posts(extent->width, level),
		.height = extent_posts(extent->height, level),
		.spacing = extent_spacing(extent, level),
	};
	const size_t count = (size_t)(cover->width * cover->height);
	TRY(mem_make(&cover->heights, count, sizeof *cover->heights, "holes and edges"));
	TRY(store_read_posts(reader, STORE_BASE, level, (struct post_rect){0, 0, cover->width, cover->height}, cover->heights));
	return fill(cover->heights, cover->width, cover->height);
}

void exchange_cover_finish(struct exchange_cover *cover)
{
	mem_free(cover->heights);
	cover->heights = NULL;
}

double exchange_cover_at(const struct exchange_cover *cover, double x, double y)
{
	x = fmin(fmax(x / cover->spacing, 0), (double)(cover->width - 1));
	y = fmin(fmax(y / cover->spacing, 0), (double)(cover->height - 1));
	const int64_t px = (int64_t)x, py = (int64_t)y, right = px + 1 < cover->width, up = py + 1 < cover->height ? cover->width : 0;
	const double *p = cover->heights + py * cover->width + px, u = x - (double)px, v = y - (double)py;
	const double south = p[0] + u * (p[right] - p[0]), north = p[up] + u * (p[up + right] - p[up]);
	return south + v * (north - south);
}

double exchange_cover_degrees(const struct exchange_cover *cover, const struct exchange_frame *frame, double longitude, double latitude)
{
	const double *bounds = frame->bounds;
	double past[2] = {bounds[0] - longitude, longitude - bounds[2]}; /* to the west and to the east of the terrain; below 0: not */
	if (past[0] > 0 || past[1] > 0)
		longitude = past[0] - 360 * floor(past[0] / 360) < past[1] - 360 * floor(past[1] / 360) ? bounds[0] : bounds[2];
	latitude = fmin(fmax(latitude, bounds[1]), bounds[3]);
	exchange_frame_from_degrees(frame, 1, &longitude, &latitude);
	return isnan(longitude) || isnan(latitude) ? cover->heights[0] : exchange_cover_at(cover, longitude, latitude);
}
