/* Plots within a page: lines over two axes, or a histogram. Their colours are the page's, so that they suit its light. */
#ifndef FURROW_TOOLS_HTML_PLOT_H
#define FURROW_TOOLS_HTML_PLOT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

enum { HTML_COLOURS = 8, HTML_DASHES = 4 };

struct html_ground;

struct html_line {
	size_t colour, dash; /* counted from 0; they repeat behind HTML_COLOURS and HTML_DASHES */
	size_t count;
	const double *x, *y; /* NaN in y: the line has a gap there */
	bool steps;          /* y[i] holds from x[i] to x[i + 1]; the last y is not drawn. With an area below it */
	bool dots;           /* a dot at each point */
	bool begins;         /* a dot at the first point */
};

struct html_plot {
	const char *title, *across, *up; /* names of the axes, with their units */
	struct html_line *lines;         /* at least one, with a point that is finite */
	size_t count;
	bool zero;        /* the upward axis has 0 */
	bool logarithmic; /* across; only values above 0 are drawn then */
	bool map;         /* both axes have one scale, and lines may go anywhere; else x never decreases along a line */
	double low, high; /* the upward axis has no more than this; equal: no such limits */
	double upright;   /* NaN: none; else a dashed upright line at this x */
	const char *told; /* what the upright line is */
	const struct html_ground *ground; /* of a map: what lies below the lines; the axes end where it ends. NULL: nothing */
};

/* A picture that lies below a map's lines. */
struct html_ground {
	double low[2], high[2];     /* its edges, in the units of the axes */
	const unsigned char *png;
	size_t length;              /* bytes */
};

/* The style sheet of a page with plots. */
extern const char html_style[];

/* Whether any point of a line is drawn. */
bool html_line_any(const struct html_line *line);
/* Writes bytes as base64 (RFC 4648). */
void html_base64(const unsigned char *bytes, size_t length, FILE *file);
void html_plot_write(const struct html_plot *plot, FILE *file);

#endif
