/*
 * A page that a map is drawn on, as PNG, SVG or PDF. Lengths are points (1/72 inch), from the upper left corner.
 *
 *     created (text can be measured) -> opened (it has a size, and is drawn on) -> written
 *
 * Text is set without hinting, in one list of families. So each format has the same places, and they do not depend on the pixels.
 */
#ifndef FURROW_CHART_PAGE_H
#define FURROW_CHART_PAGE_H

#include <pango/pangocairo.h>

#include "base/aside.h"
#include "chart/internal.h"

/* Fonts, in the order in which they are looked for. A letter that none of them has is taken from any font that has it. */
#define CHART_FAMILIES "DejaVu Sans, Noto Sans, Liberation Sans, sans-serif"

/* What a text is for; tests and the description of an SVG go by it. */
enum chart_text_kind { CHART_TITLE, CHART_COORDINATE, CHART_NAME, CHART_LEGEND, CHART_NOTE };

struct chart_style {
	enum chart_text_kind kind;
	double size;       /* of the letters, points */
	bool bold, turned; /* turned: it runs upwards */
	double most;       /* the longest that a line may be; longer text is cut with "…", or wrapped; 0: no limit */
	int lines;         /* more than 1: wrapped to so many lines */
	struct chart_colour colour;
	bool halo; /* letters have a white edge */
};

/* What was written, and where. */
struct chart_said {
	enum chart_text_kind kind;
	struct chart_rect rect;
	char *text;
};

/* Signs of a page's texts that no installed font has, each once. */
#define CHART_UNKNOWN_MOST 8
struct chart_unknown {
	gunichar signs[CHART_UNKNOWN_MOST];
	size_t count;
	bool more; /* there are others */
};

struct chart_page {
	PangoFontMap *fonts;
	PangoContext *context;
	PangoFontDescription *face;
	/* from chart_page_open on */
	enum chart_format format;
	double width, height;   /* points */
	double dots;            /* pixels a point, of a PNG */
	uint32_t columns, rows; /* pixels of a PNG */
	uint8_t *pixels;
	cairo_surface_t *surface;
	cairo_t *cairo;
	struct aside aside;
	bool head; /* of an SVG: its description is written */
	int full;  /* errno of a write that failed; 0: none did */
	const char *title;
	struct chart_said *said;
	size_t said_count, said_room;
	bool lacking; /* memory ran out */
	struct chart_unknown unknown;
};

enum status chart_page_create(struct chart_page *page) FURROW_CHECKED;
/* Begins the page. `path` and `title` must stay valid. Nothing is at `path` before chart_page_write. */
enum status chart_page_open(struct chart_page *page, const char *path, enum chart_format format, double width, double height,
			    double dots, const char *title) FURROW_CHECKED;
/* Writes the file, and checks everything that was drawn. */
enum status chart_page_write(struct chart_page *page, const char *path) FURROW_CHECKED;
void chart_page_finish(struct chart_page *page); /* page may be all zero */

void chart_page_colour(struct chart_page *page, struct chart_colour colour);
void chart_page_box(struct chart_page *page, const struct chart_rect *rect, struct chart_colour colour);
/* Draws the ground, `width` x `height` pixels as chart_relief_fill makes them, into the rectangle. */
enum status chart_page_image(struct chart_page *page, uint32_t *pixels, uint32_t width, uint32_t height,
			     const struct chart_rect *rect) FURROW_CHECKED;
/* Returns the nearest place between two pixels of a PNG, so that edges are sharp. */
double chart_page_snap(const struct chart_page *page, double place);

/* --- text.c --- */
/* The size of a text as it is drawn, before it is turned. */
void chart_text_size(struct chart_page *page, const struct chart_style *style, const char *text, double *width, double *height);
/* Draws a text whose upper left corner, when turned too, is (x, y). */
void chart_text(struct chart_page *page, const struct chart_style *style, double x, double y, const char *text);
/* The same on another surface, of which the page remembers nothing. */
void chart_text_on(struct chart_page *page, cairo_t *cairo, const struct chart_style *style, double x, double y, const char *text);
/* Returns a copy in valid UTF-8, of one line, with what is not replaced; freed by g_free. */
char *chart_text_valid(const char *text);

/* --- unknown.c --- */
/* Adds the signs of a layout that no installed font has. */
void chart_unknown_add(struct chart_unknown *unknown, PangoLayout *layout);
/* Tells them in a note that begins with `what`, with what to install. Tells nothing if there are none. */
void chart_unknown_tell(const struct chart_unknown *unknown, const char *what);

/* --- marks.c --- */
/* Draws a bar of a round length, at most `most` points long, from x on; its labels are below it. `metres`: of a point. */
void chart_scale_bar(struct chart_page *page, double x, double y, double most, double metres);
double chart_scale_length(double most, double metres); /* points */
void chart_north(struct chart_page *page, double x, double y); /* the arrow's tip */
#define CHART_NORTH_HEIGHT 26.0

/* --- ways.c --- */
struct chart_pattern {
	struct chart_colour colour;
	double dashes[4];
	int dash_count;
	int shape; /* the mark where it begins: 0 that of an object, 1 that of a vehicle */
};
struct chart_pattern chart_way_pattern(size_t way, bool vehicle);
enum status chart_ways_draw(struct chart_page *page, const struct chart_map *map, const struct chart_frame *frame,
			    struct chart_written *written) FURROW_CHECKED;
void chart_way_sample(struct chart_page *page, size_t way, bool vehicle, double x, double y, double length);

/* --- legend.c --- */
/* What a legend has, and the size of each part. */
struct chart_legend {
	const struct chart_map *map;
	struct chart_range range;
	double beyond[2]; /* as in struct chart_ground */
	bool holes;
	double values_height;               /* of the ramp, or the classes */
	double head_height;                 /* of their title, a part of values_height */
	double ways_height, ways_width;
	int columns;
	size_t listed; /* ways in the list */
};
void chart_legend_measure(struct chart_page *page, struct chart_legend *legend, double width, double room);
void chart_legend_values(struct chart_page *page, const struct chart_legend *legend, double x, double y);
void chart_legend_ways(struct chart_page *page, const struct chart_legend *legend, double x, double y);

/* --- map.c --- */
/* Draws a map, all but its file, and says where its frame is. Call chart_page_finish afterwards, even on failure. */
enum status chart_map_page(const struct chart_map *map, const char *path, struct chart_page *page, struct chart_frame *frame,
			   struct chart_written *written) FURROW_CHECKED;

extern const struct chart_colour chart_ink, chart_faint, chart_paper;

#endif
