/*
 * chart: maps, on the CPU. It shades the ground of a store and colours the values of a layer. It lays out a page with the map, its
 * grid, its legend and its names. It writes PNG, SVG and PDF. Cairo draws and Pango sets the text; a build without them has the
 * rasters and the colours, but no pages. No GL.
 *
 * Any thread may call these functions. One thread at a time uses a raster or a pen.
 */
#ifndef FURROW_CHART_H
#define FURROW_CHART_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "base/base.h"
#include "store/store.h"

struct chart_colour {
	uint8_t r, g, b, a; /* sRGB; a: 255 is opaque */
};

/* A PNG that is made row by row. */
struct chart_png {
	uint32_t width, height;
	unsigned bits, channels; /* 8 or 16; 1 or 3; 4: with opacity */
	void (*put)(const void *user, uint32_t y, uint8_t *row); /* fills a row, 0 the lowest; of 16 bits, the high byte first */
	const void *user;
	enum status (*ended)(const void *user); /* after the last row: any but STATUS_OK, and nothing is published; NULL: all is well */
	bool srgb;
	bool small;              /* takes longer, for fewer bytes */
	uint32_t per_metre;      /* dots a metre on paper, which the file says; 0: it says nothing */
};
/* Writes such a picture as PATH.part, then renames it. Removes it on failure. Any thread. */
enum status chart_png_rows(const char *path, const struct chart_png *picture) FURROW_CHECKED;
/* Writes RGBA8 pixels, the bottom row first, to a PNG without alpha, in the same way. */
enum status chart_png_write(const char *path, const uint8_t *pixels, uint32_t width, uint32_t height) FURROW_CHECKED;
enum status chart_png_write_for_print(const char *path, const uint8_t *pixels, uint32_t width, uint32_t height,
				      uint32_t per_metre) FURROW_CHECKED;

/* --- the ground: light and values --- */

/* The sun of a map: several directions, so that its light is soft. Angles are in radians, the azimuth clockwise from north. */
#define CHART_AZIMUTH (M_PI * 315 / 180)
#define CHART_ALTITUDE (M_PI / 4)
#define CHART_SUNS 4
struct chart_sun {
	double toward[CHART_SUNS][3];
};
void chart_sun_of(double azimuth, double altitude, struct chart_sun *sun);
/* Returns the brightness of ground with this slope, 0 to 1; NaN if a slope is NaN. `east`, `north`: rise in metres for each
 * metre. */
double chart_shade(const struct chart_sun *sun, double east, double north);
/* Computes slopes at width x rows posts. `heights` has one more row and column on each side; NaN: nodata. `spacing`: metres
 * between posts. */
void chart_slopes(const double *heights, int64_t width, int64_t rows, double spacing, double *east, double *north);

/* A map raster: one pixel for each post of `level`, row 0 south. */
struct chart_raster {
	uint32_t width, height;
	int level;
	double spacing;        /* metres a pixel */
	struct post_rect rect; /* what is shown: columns and rows of the posts of `level` */
	float *shade;          /* 0 to 1; NaN: nodata */
	/* metres: of the values within the pixel, the one with the largest absolute value; 0: none. Of offsets the deepest rut comes
	 * before the highest heap. Heights: the post's; NaN: nodata */
	float *values;
	double flat;           /* the shade of level ground */
	double inset;          /* metres: spacing of the finest inset in the map; 0: there is none, or the map's posts are no finer than the terrain's */
	double rut;            /* metres: ruts that are narrower are drawn so wide; 0: ruts are as wide as they are */
};
struct chart_raster_params {
	struct store_reader *reader;
	const struct store_meta *meta;
	bool deformed;         /* the store has a working level, `working` */
	int working;
	/* STORE_OFFSET, STORE_DEPOSITED, STORE_PLASTIC_SINKAGE, one of STORE_SHEAR's; or heights: STORE_SURFACE, STORE_BASE. Of STORE_SOIL, STORE_RISEN and STORE_GROWN
	 * the values are shares: how disturbed the ground is, how bent and how torn plants are */
	enum store_layer layer;
	int level;             /* level of the pixels, TILE_LEVEL_MIN to the coarsest */
	struct post_rect rect; /* not empty, within the terrain; held whole in memory, 8 to 12 bytes a pixel */
	struct chart_sun sun;
	double exaggerate;     /* factor of heights for the shading; 1: none */
	/* most offset tiles to read; if there are more, a coarser level is used. 0: no limit. Only for STORE_OFFSET */
	uint64_t tiles_most;
	store_progress_fn progress; /* called to tell progress; if it does not return STATUS_OK, the work stops. May be NULL */
	void *progress_user;
	struct plane_marks marks;   /* for such shares: the time at which they are shown */
};
/* Makes a map raster. On failure `out` is all zero. */
enum status chart_raster_create(const struct chart_raster_params *params, struct chart_raster *out) FURROW_CHECKED;
void chart_raster_finish(struct chart_raster *raster); /* raster may be all zero */
/* Of offsets: sets each pixel to the deepest rut among itself and its neighbours; without a rut to the highest heap. So lines of one pixel become three
 * pixels wide. */
enum status chart_raster_widen(struct chart_raster *raster) FURROW_CHECKED;

/* Returns the end of a legend for values up to `size` (above 0): the smallest round number that is at least `size`. */
double chart_round_range(double size);

/* --- colours of values --- */

enum chart_ramp { CHART_RAMP_SIGNED, CHART_RAMP_GREEN, CHART_RAMP_ROSE, CHART_RAMP_HEIGHTS };
/* Returns the colour to lay over ground. `t`: -1 to 1 for the signed ramp, 0 to 1 for the others. At 0 it is fully transparent,
 * except that of heights. */
struct chart_colour chart_ramp(enum chart_ramp ramp, double t);
/* Metres, or shares of 1: the ends of a ramp. `low` is below 0 for the signed ramp, 0 for the green and the rose one. */
struct chart_range {
	double low, high;
};

/* --- maps --- */

/* What a path's ending asks for. Returns false if it is none of .png, .svg and .pdf. */
enum chart_format { CHART_PNG, CHART_SVG, CHART_PDF };
bool chart_path_format(const char *path, enum chart_format *format);

/* Writes the name of a WKT's system and its code, as in "WGS 84 / UTM zone 33N (EPSG:32633)". A system without a name
 * is told by its projection and datum: "unnamed, UTM zone 10N on NAD27". `wkt` is not trusted. "": none. */
void chart_system_name(const char *wkt, char *text, size_t room);

/* Returns why this process cannot draw maps and text: it was built without Pango, or there is no font. NULL: it can. */
const char *chart_missing(void);

/* The way of an object or a vehicle. */
struct chart_way {
	const char *name;          /* UTF-8; what is not is replaced */
	const double (*places)[2]; /* metres east and north of the south-west post */
	size_t count;              /* 0: it is not drawn */
	bool vehicle;
};

/* A class of pixels, for maps of classes. */
struct chart_key {
	const char *name;
	struct chart_colour colour;
	double share; /* of the ground: 0 to 1 */
};
#define CHART_NO_CLASS 255

/* Lines of round coordinates. METRES: of the store's system, as its origin has them. LOCAL: metres from the south-west post, as scenes have
 * them. DEGREES: longitude and latitude on the store's body. */
enum chart_grid { CHART_GRID_METRES, CHART_GRID_LOCAL, CHART_GRID_DEGREES, CHART_GRID_NONE };

#define CHART_SIZE 160.0       /* mm: the longer side of a map's frame, if not said otherwise */
#define CHART_SIZE_LEAST 40.0
#define CHART_SIZE_MOST 1200.0
#define CHART_PIXELS_MOST 8192 /* of the frame's longer side */

struct chart_map {
	const struct chart_raster *raster;
	const struct store_meta *meta;  /* of the raster's store: its SRS and its origin */
	const char *title, *subtitle;   /* above the map, UTF-8 */
	const char *layer;              /* the legend's title */
	/* values */
	enum chart_ramp ramp;
	bool share;                     /* values are shares of 1, not metres */
	struct chart_range range;       /* both 0: chosen; for offsets so that 99.9 % of the values are within it */
	/* or classes: the class of each pixel of the raster, CHART_NO_CLASS: none; raster->values are not used then */
	const uint8_t *classes;
	const struct chart_key *keys;
	size_t key_count;
	/* or colours: 4 bytes for each pixel of the raster, with opacity. Values, range and ramp are not used then */
	const uint8_t *colours;
	const struct chart_way *ways;
	size_t way_count;
	enum chart_grid grid;
	double size;                    /* mm: the longer side of the frame, CHART_SIZE_LEAST to CHART_SIZE_MOST; 0: CHART_SIZE */
	uint32_t pixels;                /* the frame's longer side, 1 to CHART_PIXELS_MOST; of SVG and PDF, the ground's */
};
/* Where the whole picture of a map lies on the ground, with its margins: metres east and north of the south-west post. */
struct chart_place {
	double east, south;           /* metres a pixel, to the right and downwards */
	double west_edge, north_edge; /* of the picture */
};
/* What was written. */
struct chart_written {
	uint32_t width, height;  /* pixels of a PNG; points (1/72 inch) of SVG and PDF */
	struct chart_place place; /* of a PNG */
	size_t names, unlabelled; /* ways that are drawn, and those of them that have no name beside them on the map */
};
/* Draws a map and writes it: under another name first, then renamed. `written` may be NULL. The frame is as long as asked for, text
 * has the same size on every map. A note names signs that no installed font has. STATUS_FAILED: chart_missing(), no memory, or the
 * file cannot be written. */
enum status chart_map_write(const struct chart_map *map, const char *path, struct chart_written *written) FURROW_CHECKED;

/* The ground of a map alone, as pixels. A build without Pango has it, too. */
struct chart_ground {
	struct chart_range range; /* values at the ends of the colours */
	double beyond[2];         /* the lowest and the highest value, if they are outside of it; NaN: they are not */
	bool holes;
};
/* Writes the ground as a PNG into an open file, as small as it can. Of the map it needs raster, ramp, share, range or classes, and pixels: of
 * its longer side. `name`: of the file, for messages. */
enum status chart_ground_write(const struct chart_map *map, const char *name, FILE *file, struct chart_ground *out) FURROW_CHECKED;
/* Returns the colour of a value on level ground. */
struct chart_colour chart_ground_key(const struct chart_map *map, const struct chart_range *range, double value);

/* Returns the level of detail for a map: the finest level, not below `finest`, at which no side has more than `pixels` posts.
 * `rect`: posts of level `from`, which become those of the level. Pure. */
int chart_level(const struct extent *extent, int from, uint32_t pixels, struct post_rect *rect);

/* --- text on pictures --- */

/* RGBA8 pixels, the bottom row first, that belong to the caller. Places are in pixels from the lower left corner. What lies outside
 * is not drawn. */
struct chart_pixels {
	uint8_t *pixels;
	uint32_t width, height;
};
void chart_box(const struct chart_pixels *pixels, int x0, int y0, int x1, int y1, struct chart_colour colour);

/* Sets lines of text on pixels. */
struct chart_pen;
/* STATUS_FAILED: chart_missing(). */
enum status chart_pen_create(struct chart_pen **out) FURROW_CHECKED;
void chart_pen_destroy(struct chart_pen *pen); /* pen may be NULL */
/* Returns the width of a line in pixels. `size`: of the letters, pixels from one line to the next. */
int chart_pen_width(struct chart_pen *pen, int size, const char *text);
/* (x, y): the lower left corner of a line that is `size` pixels high. A note names signs that no installed font has, the first time that
 * they are written. */
enum status chart_pen_write(struct chart_pen *pen, const struct chart_pixels *pixels, int x, int y, int size, const char *text,
			    struct chart_colour colour) FURROW_CHECKED;

#endif
