/* Computes the heights of insets over the country: what is blended, and what is interpolated between coarser posts. */
#include "dem_inset.h"

#include <math.h>

static bool is_covered(const struct inset *inset, int64_t x, int64_t y)
{
	const struct post_rect *cells = &inset->cells;
	return x >= cells->x0 && y >= cells->y0 && x < cells->x1 && y < cells->y1 &&
	       inset->covered[(y - cells->y0) * dem_inset_width(*cells) + x - cells->x0] != 0;
}

bool dem_inset_covers(const struct inset *inset, int level, int64_t x, int64_t y)
{
	const int shift = inset->around - level;
	const int64_t part = ((int64_t)1 << shift) - 1, cx = x >> shift, cy = y >> shift;
	const bool west = (x & part) == 0, south = (y & part) == 0; /* on a cell's edge: also in the cell beside it */
	return is_covered(inset, cx, cy) || (west && is_covered(inset, cx - 1, cy)) || (south && is_covered(inset, cx, cy - 1)) ||
	       (west && south && is_covered(inset, cx - 1, cy - 1));
}

struct post_rect dem_inset_covered_rect(const struct inset *inset, int level)
{
	const int shift = inset->around - level;
	const struct post_rect *cells = &inset->cells;
	return (struct post_rect){cells->x0 << shift, cells->y0 << shift, (cells->x1 << shift) + 1, (cells->y1 << shift) + 1};
}

/* --- heights --- */

static bool same_rect(struct post_rect a, struct post_rect b)
{
	return a.x0 == b.x0 && a.y0 == b.y0 && a.x1 == b.x1 && a.y1 == b.y1;
}

/* Posts of the country, which stay in memory until others are read. */
static enum status country_posts(struct dem_insets *insets, struct post_rect rect)
{
	if (insets->posts != NULL && same_rect(rect, insets->held))
		return STATUS_OK;
	TRY(mem_resize(&insets->posts, dem_inset_posts(rect), sizeof *insets->posts, "an inset"));
	insets->held = (struct post_rect){0, 0, 0, 0};
	TRY(dem_read(insets->country, rect, insets->posts));
	insets->held = rect;
	return STATUS_OK;
}

/* Interpolates post (x, y) between posts `shift` levels coarser, of which `coarse` has those of `from`. */
static double between(const double *coarse, struct post_rect from, int shift, int64_t x, int64_t y)
{
	const int64_t part = ((int64_t)1 << shift) - 1, width = dem_inset_width(from);
	const double *post = coarse + ((y >> shift) - from.y0) * width + (x >> shift) - from.x0;
	const int64_t east = (x & part) != 0, north = (y & part) != 0 ? width : 0;
	const double corners[4] = {post[0], post[east], post[north], post[north + east]};
	return lattice_bilinear(corners, ldexp((double)(x & part), -shift), ldexp((double)(y & part), -shift), 0);
}

static enum status country_heights(struct dem_insets *insets, int level, struct post_rect rect, double *heights)
{
	const struct post_rect from = dem_inset_around(rect, -level);
	TRY(country_posts(insets, from));
	for (int64_t y = rect.y0; y < rect.y1; y++)
		for (int64_t x = rect.x0; x < rect.x1; x++)
			*heights++ = between(insets->posts, from, -level, x, y);
	return STATUS_OK;
}

/* Lays an inset over the heights of its own level. */
static enum status blend(const struct inset *inset, struct post_rect rect, double *heights)
{
	const struct post_rect part = post_rect_intersect(rect, inset->rect);
	if (post_rect_empty(part))
		return STATUS_OK;
	double *own = mem_alloc(dem_inset_posts(part), sizeof *own), *from = own;
	TRY_MEM(own, "an inset");
	enum status status;
	const struct post_rect inside = {part.x0 - inset->x, part.y0 - inset->y, part.x1 - inset->x, part.y1 - inset->y};
	TRY_OR(done, dem_read(inset->dem, inside, own));
	for (int64_t y = part.y0; y < part.y1; y++) {
		double *to = heights + (y - rect.y0) * dem_inset_width(rect) - rect.x0;
		for (int64_t x = part.x0; x < part.x1; x++, from++) {
			const double weight = dem_inset_rim_weight(&inset->rim, x - inset->rect.x0, y - inset->rect.y0), height = *from - inset->lowered;
			if (weight == 0 || isnan(height))
				continue;
			to[x] = weight == 1 || isnan(to[x]) ? height : to[x] + weight * (height - to[x]);
		}
	}
done:
	mem_free(own);
	return status;
}

/* Replaces the heights at posts that a coarser inset covers by what is interpolated between its own. */
static enum status divide(struct dem_insets *insets, size_t depth, int level, struct post_rect rect, double *heights)
{
	const struct inset *inset = &insets->list[depth - 1];
	const int shift = inset->info.level - level;
	const struct post_rect part = post_rect_intersect(rect, dem_inset_covered_rect(inset, level)), from = dem_inset_around(part, shift);
	if (post_rect_empty(part))
		return STATUS_OK;
	double *coarse = mem_alloc(dem_inset_posts(from), sizeof *coarse);
	TRY_MEM(coarse, "an inset");
	enum status status;
	TRY_OR(done, dem_inset_heights(insets, depth, inset->info.level, from, coarse));
	for (int64_t y = part.y0; y < part.y1; y++)
		for (int64_t x = part.x0; x < part.x1; x++)
			if (dem_inset_covers(inset, level, x, y))
				heights[(y - rect.y0) * dem_inset_width(rect) + x - rect.x0] = between(coarse, from, shift, x, y);
done:
	mem_free(coarse);
	return status;
}

enum status dem_inset_heights(struct dem_insets *insets, size_t depth, int level, struct post_rect rect, double *heights)
{
	if (depth == 0)
		return country_heights(insets, level, rect, heights);
	TRY(dem_inset_heights(insets, depth - 1, level, rect, heights));
	const struct inset *inset = &insets->list[depth - 1];
	return inset->info.level == level ? blend(inset, rect, heights) : divide(insets, depth, level, rect, heights);
}
