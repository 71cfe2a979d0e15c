/* Shades a map raster: by slopes of the base, with those of the offsets added. */
#include <math.h>

#include "chart/raster.h"

enum status chart_raster_tell(struct rasterizing *s, int64_t more)
{
	s->done += more;
	const struct chart_raster_params *params = s->params;
	return params->progress != NULL ? params->progress(params->progress_user, s->done, s->total) : STATUS_OK;
}

struct strip {
	double *heights;      /* with one more post at each side */
	double *east, *north; /* slopes */
	struct post_rect rect;
	int level;
};

/* Computes the base's slopes at the posts of strip->rect. */
static enum status read_slopes(struct rasterizing *s, struct strip *strip)
{
	struct post_rect r = strip->rect, wide = post_rect_grown(r, 1);
	TRY(store_read_posts(s->params->reader, STORE_BASE, strip->level, wide, strip->heights));
	chart_slopes(strip->heights, r.x1 - r.x0, r.y1 - r.y0, extent_spacing(s->extent, strip->level), strip->east,
		      strip->north);
	return STATUS_OK;
}

/* Finds the base's slope at a post of the map; NaN: nodata. */
static void slope_at(const struct rasterizing *s, const struct strip *strip, int64_t x, int64_t y, double *east, double *north)
{
	int shift = strip->level - s->params->level;
	int64_t cx = x >> shift, cy = y >> shift, width = strip->rect.x1 - strip->rect.x0;
	double unit = ldexp(1, -shift), u = (double)(x - (cx << shift)) * unit, v = (double)(y - (cy << shift)) * unit;
	const double weights[4] = {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
	*east = *north = 0;
	for (int64_t i = 0; i < 4; i++) {
		if (weights[i] == 0)
			continue;
		int64_t at = (cy + (i >> 1) - strip->rect.y0) * width + cx + (i & 1) - strip->rect.x0;
		*east += weights[i] * strip->east[at];
		*north += weights[i] * strip->north[at];
	}
}

/* Adds the slope that offsets cause at a pixel, from the pixels around it. For a pixel outside the map, the slope of the other
 * side is used. */
static void add_offset_slope(const struct rasterizing *s, int64_t x, int64_t y, double *east, double *north)
{
	const struct chart_raster *raster = s->raster;
	double around[9];
	for (int64_t i = 0; i < 9; i++) {
		int64_t px = x + i % 3 - 1, py = y + i / 3 - 1;
		bool in = px >= 0 && py >= 0 && px < raster->width && py < raster->height;
		around[i] = in ? s->offset[py * raster->width + px] : (double)NAN;
	}
	double e, n;
	chart_slopes(around, 1, 1, raster->spacing, &e, &n);
	*east += e;
	*north += n;
}

static bool is_flat_around(const struct rasterizing *s, int64_t x, int64_t y)
{
	const struct chart_raster *raster = s->raster;
	if (x < 1 || y < 1 || x + 1 >= raster->width || y + 1 >= raster->height)
		return false;
	const float *p = s->offset + y * raster->width + x;
	int64_t w = raster->width;
	return p[-w - 1] == 0 && p[-w] == 0 && p[-w + 1] == 0 && p[-1] == 0 && p[1] == 0 && p[w - 1] == 0 && p[w] == 0 &&
	       p[w + 1] == 0;
}

static void shade_strip(struct rasterizing *s, const struct strip *strip, struct post_rect part)
{
	struct chart_raster *raster = s->raster;
	for (int64_t y = part.y0; y < part.y1; y++)
		for (int64_t x = part.x0; x < part.x1; x++) {
			double east, north, steeper = s->params->exaggerate;
			int64_t px = x - raster->rect.x0, py = y - raster->rect.y0;
			slope_at(s, strip, x, y, &east, &north);
			if (s->offset != NULL && !is_flat_around(s, px, py))
				add_offset_slope(s, px, py, &east, &north);
			raster->shade[py * raster->width + px] =
				(float)chart_shade(&s->params->sun, steeper * east, steeper * north);
		}
}

/* Shades the map's posts in `rect` by the base's slopes at posts of `level`, which is not finer than the map's. */
static enum status shade(struct rasterizing *s, int level, struct post_rect rect)
{
	const int shift = level - s->params->level;
	int64_t rows = RASTER_STRIP < rect.y1 - rect.y0 ? RASTER_STRIP : rect.y1 - rect.y0;
	size_t width = (size_t)(((rect.x1 - 1) >> shift) + 2 - (rect.x0 >> shift)), high = (size_t)((rows >> shift) + 3);
	struct strip strip = {
		.heights = mem_alloc((width + 2) * (high + 2), sizeof(double)),
		.east = mem_alloc(width * high, sizeof(double)),
		.north = mem_alloc(width * high, sizeof(double)),
		.level = level,
	};
	enum status status;
	TRY_OR(done, strip.heights != NULL && strip.east != NULL && strip.north != NULL ? STATUS_OK
												: fail_memory("rows of a map"));
	for (int64_t y = rect.y0; y < rect.y1; y += rows) {
		struct post_rect part = {rect.x0, y, rect.x1, y + rows < rect.y1 ? y + rows : rect.y1};
		strip.rect = (struct post_rect){rect.x0 >> shift, y >> shift, ((rect.x1 - 1) >> shift) + 2,
						((part.y1 - 1) >> shift) + 2};
		TRY_OR(done, read_slopes(s, &strip));
		shade_strip(s, &strip, part);
		TRY_OR(done, chart_raster_tell(s, part.y1 - part.y0));
	}
done:
	mem_free_all(strip.heights, strip.east, strip.north);
	return status;
}

/* Returns the map's posts on an inset. */
static struct post_rect inset_rect(const struct rasterizing *s, const struct store_inset *inset)
{
	const int finer = inset->level - s->params->level, coarser = -finer;
	struct post_rect r = {inset->x, inset->y, inset->x + inset->width - 1, inset->y + inset->height - 1};
	if (finer >= 0)
		r = (struct post_rect){r.x0 << finer, r.y0 << finer, r.x1 << finer, r.y1 << finer};
	else
		r = (struct post_rect){-(-r.x0 >> coarser), -(-r.y0 >> coarser), r.x1 >> coarser, r.y1 >> coarser};
	return post_rect_intersect((struct post_rect){r.x0, r.y0, r.x1 + 1, r.y1 + 1}, s->raster->rect);
}

/* Shades the insets of a level anew, by their own posts or by the map's, whichever are coarser. */
static enum status shade_insets(struct rasterizing *s, int level)
{
	const int own = s->params->level;
	const char *text = s->params->meta->insets != NULL ? s->params->meta->insets : "";
	struct store_inset inset;
	while (store_inset_next(&text, s->extent, &inset)) {
		const struct post_rect rect = inset_rect(s, &inset);
		if (inset.level != level || post_rect_empty(rect))
			continue;
		s->raster->inset = extent_spacing(s->extent, level);
		s->total += rect.y1 - rect.y0;
		TRY(shade(s, level > own ? level : own, rect));
	}
	return STATUS_OK;
}

enum status chart_raster_shade(struct rasterizing *s)
{
	const int own = s->params->level;
	/* Below level 0 the base is bilinear between posts. Slopes that are interpolated show no cells there, but no inset either. */
	TRY(shade(s, own > 0 ? own : 0, s->raster->rect));
	for (int level = -1; own < 0 && level >= TILE_LEVEL_MIN; level--)
		TRY(shade_insets(s, level));
	return STATUS_OK;
}
