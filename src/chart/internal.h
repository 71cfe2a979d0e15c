/* Shared by the files of src/chart. Neither Cairo nor Pango is in here: page.h has what draws. */
#ifndef FURROW_CHART_INTERNAL_H
#define FURROW_CHART_INTERNAL_H

#include <assert.h>
#include <stdio.h>

#include "chart/chart.h"

/* --- ramp.c --- */
/* Returns the position of a value on a ramp, -1 to 1, or 0 to 1. Values outside the range give positions outside. */
double chart_ramp_place(enum chart_ramp ramp, const struct chart_range *range, double value);
/* Returns the colour of shaded ground with the colour `over` on it. `shade`: brightness, NaN: nodata. `flat`: the shade at
 * which a colour stays as it is. */
struct chart_colour chart_ground_colour(double shade, double flat, struct chart_colour over);

/* --- png.c --- */
/* Writes to a file that the caller opened. `name`: for messages. */
enum status chart_png_file(FILE *file, const char *name, const struct chart_png *picture) FURROW_CHECKED;

/* --- raster.c --- */
/* Finds the size (absolute value, metres) that at least `share` of all pixels with a value do not exceed. Also finds the lowest
 * and highest value; they are 0 if there is none. */
enum status chart_raster_spread(const struct chart_raster *raster, double share, double *size, double *low,
				double *high) FURROW_CHECKED;

/* --- blend.c --- */
/* Lays a colour over an RGBA pixel. `cover`: 0 to 255, a factor of the colour's own opacity. */
void chart_blend(uint8_t *to, struct chart_colour colour, unsigned cover);

/* --- round.c: numbers that people read --- */
double chart_round_length(double most); /* returns the largest number up to `most` that is 1, 2 or 5 times a power of ten */
/* Returns the smallest number not below `least` that is 1, 2 or 5 times a power of ten. */
double chart_round_step(double least);
/* Writes a number with the digits that a step of `step` needs, groups of three parted by narrow spaces from 10 000 on. The minus
 * sign is the true one. */
void chart_number(double value, double step, char *text, size_t room);
/* Writes a length with its unit, mm, cm, m or km, and at most four digits that count. */
void chart_length(double metres, char *text, size_t room);

/* --- a rectangle on the page: points (1/72 inch) from the upper left corner --- */
struct chart_rect {
	double x0, y0, x1, y1;
};
static inline bool chart_rect_meets(const struct chart_rect *a, const struct chart_rect *b)
{
	return a->x0 < b->x1 && b->x0 < a->x1 && a->y0 < b->y1 && b->y0 < a->y1;
}
static inline bool chart_rect_within(const struct chart_rect *inner, const struct chart_rect *outer)
{
	return inner->x0 >= outer->x0 && inner->y0 >= outer->y0 && inner->x1 <= outer->x1 && inner->y1 <= outer->y1;
}

/* --- join.c: ways that lie on each other --- */
struct chart_joined {
	struct chart_way *ways; /* places are those of the given ways; names also of `names` */
	char **names;           /* NULL: the way's own */
	size_t count;
};
/* Makes one way, "left-1 ... left-10", of those that lie on each other and whose names differ in the number at their end only. */
enum status chart_ways_join(const struct chart_way *ways, size_t count, struct chart_joined *out) FURROW_CHECKED;
void chart_joined_finish(struct chart_joined *joined);

/* --- frame: where the ground lies on the page --- */
struct chart_frame {
	struct chart_rect rect;
	uint32_t width, height; /* pixels of the ground */
	double x, y, scale;     /* a place (e, n), metres: on the page at x + e * scale, y - n * scale */
};

/* --- grid.c --- */
#define CHART_GRID_POINTS 33
struct chart_line {
	bool north;      /* a line of one northing or latitude, which runs east */
	double value;    /* metres of the system, or degrees */
	char label[48];
	size_t count;
	double points[CHART_GRID_POINTS][2]; /* on the page */
	double low[2], high[2]; /* where it meets the frame: its south or west edge, and its north or east edge; NaN: nowhere */
};
struct chart_lines {
	struct chart_line *lines;
	size_t count;
	char system[160]; /* what the coordinates are, for the notes */
};
/* Finds the lines. `apart`: points that two lines of one direction are apart at least. Call chart_grid_finish afterwards, even on
 * failure. Degrees that cannot be computed are told as a note, and metres are taken. */
enum status chart_grid_find(const struct chart_map *map, const struct chart_frame *frame, double apart, struct chart_lines *out)
	FURROW_CHECKED;
void chart_grid_move(struct chart_lines *lines, double dx, double dy); /* moves them on the page */
void chart_grid_finish(struct chart_lines *lines);

/* --- labels.c --- */
/* A name and the point that it belongs to. */
struct chart_label {
	double x, y;          /* the point */
	double width, height; /* of the name */
	/* found: */
	bool shown, led;      /* led: a line leads from the point to the name */
	struct chart_rect rect;
	double lead[2];       /* the end of that line at the name */
};
/* Cells of the page that names should not cover. */
struct chart_cover {
	struct chart_rect rect;
	uint32_t width, height;
	uint8_t *cells;
};
#define CHART_COVER_CELL 3.0 /* points */
enum status chart_cover_create(const struct chart_rect *rect, struct chart_cover *out) FURROW_CHECKED;
void chart_cover_finish(struct chart_cover *cover);
void chart_cover_line(struct chart_cover *cover, const double a[2], const double b[2]);
/* Finds places for names within `rect` so that none meets another, a point, or another's line. Names come in the order of their
 * weight. Those without room are not shown. Pure; the cost grows with the square of `count`. */
void chart_labels_place(struct chart_label *labels, size_t count, const struct chart_rect *rect, const struct chart_cover *cover);

/* --- relief.c --- */
/* Fills pixels of the frame, 0xffRRGGBB, the top row first. `stride`: pixels. */
void chart_relief_fill(const struct chart_map *map, const struct chart_range *range, const struct chart_frame *frame,
		       uint32_t *pixels, size_t stride);
/* Sets the values at the ramp's ends, and notes if values lie outside them. */
enum status chart_relief_range(const struct chart_map *map, struct chart_range *range, double beyond[2]) FURROW_CHECKED;
bool chart_relief_has_holes(const struct chart_map *map);

#endif
