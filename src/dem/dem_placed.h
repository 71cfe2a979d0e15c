/*
 * Used inside dem only. A raster that lies over a store's terrain (PNG, or with GDAL), and what its pixels say at posts.
 *
 *     dem_classes.c, dem_numbers.c  ->  dem_placed.c: pixels around each post  ->  dem_placed_png.c, dem_placed_gdal.c
 */
#ifndef FURROW_DEM_PLACED_H
#define FURROW_DEM_PLACED_H

#include "dem_internal.h"

struct dem_placed {
	/* Converts positions in place. In: posts of level 0, counted from the south-west post. Out: columns and rows of the
	 * raster, counted from its north-west corner. The middle of the first pixel is (0.5, 0.5). NaN: outside of the raster. */
	void (*locate)(struct dem_placed *raster, size_t count, double *x, double *y);
	/* Reads values of pixels; NaN: nodata. Rows from the north; at most `most` pixels. */
	enum status (*window)(struct dem_placed *raster, struct post_rect pixels, double *values);
	void (*destroy)(struct dem_placed *raster);
	int64_t width, height; /* pixels */
};

/* `params` must stay valid longer than the raster. `most`: pixels that are read at once. */
enum status dem_placed_png_open(const struct dem_placed_params *params, enum dem_placed_kind kind, struct dem_placed **out)
	FURROW_CHECKED;
enum status dem_placed_gdal_open(const struct dem_placed_params *params, enum dem_placed_kind kind, int64_t most,
				 struct dem_placed **out) FURROW_CHECKED;

/* --- dem_placed.c: reads the pixels around posts --- */

struct dem_pixels {
	enum dem_placed_kind kind;
	char *srs, *path;
	struct extent extent;
	struct dem_placed_params params; /* of the above */
	struct dem_placed *raster;
	int64_t most_posts, most_pixels; /* of a part; of a window */
	int beside;     /* how many pixels beside its own a post may need */
	double *x, *y;  /* columns and rows of the posts being read; NaN: outside of the raster */
	double *values; /* of a window */
};

/* Some posts of a part, and a window of pixels that has all pixels that they need. */
struct dem_pixels_part {
	const struct dem_pixels *pixels;
	struct post_rect posts;  /* counted from the part's first post */
	int64_t stride, first;   /* posts in a row of the part; index of the part's first post in the result */
	struct post_rect window; /* of pixels. It is empty if all these posts are outside of the raster */
};
typedef enum status (*dem_pixels_fn)(void *user, const struct dem_pixels_part *part);

/* Calls `fill` until each post of `rect` was in one part. A row has at most most_posts. kind: that of the handle. */
enum status dem_pixels_read(struct dem_pixels *pixels, enum dem_placed_kind kind, int level, struct post_rect rect, dem_pixels_fn fill,
			    void *user) FURROW_CHECKED;
/* Returns the pixel that contains a position of the raster, also on its edges. */
int64_t dem_pixel_of(double place, int64_t pixels);
/* Returns a pixel's value; NaN: nodata. The pixel lies in the part's window. */
static inline double dem_pixels_value(const struct dem_pixels_part *part, int64_t column, int64_t row)
{
	const struct post_rect *window = &part->window;
	return part->pixels->values[(row - window->y0) * (window->x1 - window->x0) + column - window->x0];
}

#endif
