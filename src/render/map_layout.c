/*
 * A map as it is printed. The title is above, the map in a frame. A legend, a scale bar and a north arrow are below it.
 *
 * Everything but the map is laid out in units. A unit is a whole number of pixels, and follows from the map's size. A dot of a letter
 * is one unit. A map that is smaller than asked for is enlarged by a whole factor. Then each post is a square, and shades are
 * interpolated.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "render/internal.h"

#define WIDTH_LEAST 330 /* of the part below the map, units */
#define PAD 8
#define LEGEND 150 /* the ramp's length */
#define BAR 7      /* the ramp's height, and the scale bar's */
#define ABOVE (RENDER_LETTER_HEIGHT + 2 * PAD)
#define BELOW (2 * RENDER_LETTER_HEIGHT + BAR + 6 + 2 * PAD)
#define SHARE 0.999 /* part of the values that are within the legend's range */

static const struct render_colour ink = {28, 30, 34, 255}, paper = {255, 255, 255, 255}, faint = {110, 114, 120, 255},
				  none = {0, 0, 0, 0};

static int unit_of(int width, int height)
{
	int side = width > height ? width : height, unit = (side + 250) / 520;
	return unit < 1 ? 1 : unit;
}

double render_round_length(double most)
{
	double ten = pow(10, floor(log10(most) + 1e-9));
	double times = most / ten * (1 + 1e-9);
	return times >= 5 ? 5 * ten : times >= 2 ? 2 * ten : ten;
}

double render_round_range(double size)
{
	static const double ends[] = {1, 1.5, 2, 3, 4, 5, 6, 8, 10};
	double ten = pow(10, floor(log10(size) + 1e-9));
	size_t i = 0;
	while (ends[i] * ten < size * (1 - 1e-6))
		i++;
	return ends[i] * ten;
}

/* --- the map --- */

/* Returns the shade at a pixel of an enlarged map, interpolated between the posts beside it unless one is a hole. */
static double shade_at(const struct render_map_raster *raster, int zoom, int64_t x, int64_t y)
{
	int64_t width = raster->width, px = x / zoom, py = y / zoom;
	double here = raster->shade[py * width + px];
	double u = ((double)x + 0.5) / zoom - 0.5, v = ((double)y + 0.5) / zoom - 0.5;
	int64_t cx = (int64_t)floor(u), cy = (int64_t)floor(v);
	double sum = 0;
	for (int64_t i = 0; i < 4 && !isnan(here); i++) {
		int64_t nx = cx + (i & 1), ny = cy + (i >> 1), top = raster->height - 1;
		nx = nx < 0 ? 0 : nx < width ? nx : width - 1;
		ny = ny < 0 ? 0 : ny < top ? ny : top;
		double shade = raster->shade[ny * width + nx];
		double weight = (i & 1 ? u - (double)cx : 1 - u + (double)cx) * (i >> 1 ? v - (double)cy : 1 - v + (double)cy);
		sum += weight * (isnan(shade) ? here : shade);
	}
	return isnan(here) ? here : sum;
}

static void draw_map(const struct render_map_layout *layout, const struct render_range *range, int zoom,
		     const struct render_canvas *canvas, const struct render_placed *placed)
{
	const struct render_map_raster *raster = layout->raster;
	for (int y = placed->low; y < placed->high; y++)
		for (int x = placed->left; x < placed->right; x++) {
			int64_t mx = x - placed->left, my = y - placed->low;
			size_t pixel = (size_t)(my / zoom) * raster->width + (size_t)(mx / zoom);
			double shade = zoom > 1 ? shade_at(raster, zoom, mx, my) : raster->shade[pixel];
			struct render_colour over = render_ramp(layout->ramp, render_ramp_place(range, raster->values[pixel]));
			struct render_colour colour = render_ground_colour(shade, raster->flat, over);
			/* Sparse hatching means no data. */
			if (isnan(shade) && (x + y) % (12 * placed->unit) < placed->unit)
				colour = (struct render_colour){176, 184, 194, 255};
			memcpy(canvas->pixels + 4 * ((size_t)y * canvas->width + (size_t)x), &colour, sizeof colour);
		}
}

/* Sets the values at the ramp's ends, and notes if values lie outside them. */
static enum status settle_range(const struct render_map_layout *layout, struct render_range *range, bool beyond[2])
{
	double size, low, high;
	enum status status = render_map_raster_spread(layout->raster, SHARE, &size, &low, &high);
	if (status != STATUS_OK)
		return status;
	*range = layout->range;
	if (range->low == 0 && range->high == 0 && size > 0) {
		range->high = render_round_range(size);
		range->low = layout->ramp == RENDER_RAMP_SIGNED ? -range->high : 0;
	}
	beyond[0] = low < range->low * (1 + 1e-9);
	beyond[1] = high > range->high * (1 + 1e-9);
	return STATUS_OK;
}

enum status render_map_layout_create(const struct render_map_layout *layout, struct render_canvas *canvas, struct render_placed *placed)
{
	const struct render_map_raster *raster = layout->raster;
	uint32_t longest = raster->width > raster->height ? raster->width : raster->height;
	int zoom = longest < layout->side ? (int)(layout->side / longest) : 1;
	int width = (int)raster->width * zoom, height = (int)raster->height * zoom;
	*placed = (struct render_placed){.scale = zoom / raster->spacing, .unit = unit_of(width, height)};
	int unit = placed->unit, least = WIDTH_LEAST * unit, side = PAD * unit;
	int whole = (width > least ? width : least) + 2 * side;
	placed->left = (whole - width) / 2;
	placed->right = placed->left + width;
	placed->low = BELOW * unit;
	placed->high = placed->low + height;
	placed->x = placed->left + (0.5 - (double)raster->rect.x0) * zoom;
	placed->y = placed->low + (0.5 - (double)raster->rect.y0) * zoom;
	struct render_range range;
	bool beyond[2];
	enum status status = settle_range(layout, &range, beyond);
	if (status == STATUS_OK)
		status = render_canvas_create((uint32_t)whole, (uint32_t)(placed->high + ABOVE * unit), paper, canvas);
	if (status == STATUS_OK)
		draw_map(layout, &range, zoom, canvas, placed);
	return status;
}

/* --- the frame --- */

static void text(const struct render_canvas *canvas, int x, int y, int unit, const char *line, struct render_colour colour)
{
	render_canvas_text(canvas, x, y, unit, line, colour, none);
}

static bool has_holes(const struct render_map_raster *raster)
{
	size_t pixels = (size_t)raster->width * raster->height, i = 0;
	while (i < pixels && !isnan(raster->shade[i]))
		i++;
	return i < pixels;
}

/* Draws a line of text, cut to a width in pixels. */
static void title(const struct render_canvas *canvas, int x, int y, int unit, const char *line, int width)
{
	char cut[256];
	int most = width / (RENDER_LETTER_WIDTH * unit);
	snprintf(cut, sizeof cut, "%s", line);
	if (most < (int)sizeof cut && most > 3 && (int)render_text_letters(cut) > most)
		snprintf(cut + most - 3, sizeof cut - (size_t)(most - 3), "...");
	text(canvas, x, y, unit, cut, ink);
}

/* Returns the unit that a range is given in. *of: of metres, or of 1 if values are shares. */
static const char *unit_for(const struct render_range *range, bool share, double *of)
{
	double size = fmax(-range->low, range->high);
	*of = share ? 0.01 : size < 0.00999 ? 0.001 : size < 0.999 ? 0.01 : 1;
	return share ? "%" : size < 0.00999 ? "mm" : size < 0.999 ? "cm" : "m";
}

/* Ticks at both ends, at 0, and halfway. */
static void draw_ticks(const struct render_canvas *canvas, int left, int low, int unit, const struct render_range *range,
		       const bool beyond[2], double metres)
{
	double places[5] = {range->low, range->low / 2, 0, range->high / 2, range->high};
	for (int i = range->low < 0 ? 0 : 2; i < 5; i++) {
		char label[32];
		const char *sign = i == 0 && beyond[0] ? "<" : i == 4 && beyond[1] ? ">" : "";
		snprintf(label, sizeof label, "%s%.4g", sign, places[i] / metres);
		int x = left + (int)((places[i] - range->low) / (range->high - range->low) * LEGEND * unit + 0.5);
		render_canvas_box(canvas, x - unit / 2, low - 3 * unit, x - unit / 2 + unit, low, ink);
		text(canvas, x - render_text_width(label, unit) / 2, low - 3 * unit - RENDER_LETTER_HEIGHT * unit, unit, label, ink);
	}
}

static void draw_legend(const struct render_map_layout *layout, const struct render_canvas *canvas, int left, int low, int unit,
			const struct render_range *range, const bool beyond[2])
{
	char line[96];
	int top = low + BAR * unit + 3 * unit;
	double flat = layout->raster->flat, metres;
	if (range->low == 0 && range->high == 0) {
		snprintf(line, sizeof line, "%s: none", layout->layer);
		text(canvas, left, top, unit, line, ink);
		return;
	}
	snprintf(line, sizeof line, "%s, %s", layout->layer, unit_for(range, layout->share, &metres));
	text(canvas, left, top, unit, line, ink);
	render_canvas_box(canvas, left - unit, low - unit, left + LEGEND * unit + unit, low + BAR * unit + unit, ink);
	for (int x = 0; x < LEGEND * unit; x++) {
		double value = range->low + (x + 0.5) / (LEGEND * unit) * (range->high - range->low);
		struct render_colour over = render_ramp(layout->ramp, render_ramp_place(range, value));
		render_canvas_box(canvas, left + x, low, left + x + 1, low + BAR * unit, render_ground_colour(flat, flat, over));
	}
	draw_ticks(canvas, left, low - unit, unit, range, beyond, metres);
}

/* Draws a bar of a round length in four parts. Its right end is at `right`. */
static void draw_scale(const struct render_canvas *canvas, int right, int low, int unit, int room, double scale)
{
	char line[32];
	double length = render_round_length(room / scale);
	int pixels = (int)(length * scale + 0.5), left = right - pixels, high = low + BAR * unit / 2;
	render_canvas_box(canvas, left, low, right, high, ink);
	for (int part = 0; part < 4; part++) {
		int from = left + pixels * part / 4, to = left + pixels * (part + 1) / 4;
		int edge = unit > 1 ? unit / 2 : 1;
		if (part % 2 == 1 && to - from > 2 * edge)
			render_canvas_box(canvas, from, low + edge, to - (part == 3 ? edge : 0), high - edge, paper);
	}
	double metres = length >= 1000 ? 1000 : length >= 1 ? 1 : length >= 0.01 ? 0.01 : 0.001;
	snprintf(line, sizeof line, "%.4g %s", length / metres, length >= 1000 ? "km" : length >= 1 ? "m" : length >= 0.01 ? "cm" : "mm");
	int x = left + (pixels - render_text_width(line, unit)) / 2, most = right - render_text_width(line, unit);
	text(canvas, x < most ? x : most, high + 2 * unit, unit, line, ink);
}

static enum status draw_north(const struct render_canvas *canvas, int x, int low, int unit)
{
	double high = low + 17.0 * unit, barb = 4.0 * unit, line = 1.4 * unit;
	const double shaft[2][2] = {{x, low}, {x, high}};
	const double head[3][2] = {{x - barb, high - 1.5 * barb}, {x, high}, {x + barb, high - 1.5 * barb}};
	enum status status = render_canvas_path(canvas, shaft, 2, line, ink);
	if (status == STATUS_OK)
		status = render_canvas_path(canvas, head, 3, line, ink);
	text(canvas, x - 5 * unit / 2, low + 20 * unit, unit, "N", ink);
	return status;
}

enum status render_map_layout_frame(const struct render_map_layout *layout, const struct render_canvas *canvas,
			       const struct render_placed *placed)
{
	int unit = placed->unit, width = (int)canvas->width, height = (int)canvas->height, side = PAD * unit;
	struct render_range range;
	bool beyond[2];
	enum status status = settle_range(layout, &range, beyond);
	if (status != STATUS_OK)
		return status;
	/* Cover what the caller drew outside the map. */
	render_canvas_box(canvas, 0, 0, width, placed->low, paper);
	render_canvas_box(canvas, 0, placed->high, width, height, paper);
	render_canvas_box(canvas, 0, placed->low, placed->left, placed->high, paper);
	render_canvas_box(canvas, placed->right, placed->low, width, placed->high, paper);
	render_canvas_box(canvas, placed->left - unit, placed->low - unit, placed->right + unit, placed->low, ink);
	render_canvas_box(canvas, placed->left - unit, placed->high, placed->right + unit, placed->high + unit, ink);
	render_canvas_box(canvas, placed->left - unit, placed->low, placed->left, placed->high, ink);
	render_canvas_box(canvas, placed->right, placed->low, placed->right + unit, placed->high, ink);

	char line[128];
	snprintf(line, sizeof line, "%s%s", has_holes(layout->raster) ? "hatched: no data, " : "", layout->subtitle);
	int above = placed->high + PAD * unit, subtitle = render_text_width(line, unit);
	bool room = render_text_width(layout->title, unit) + subtitle + 4 * side < width;
	title(canvas, side, above, unit, layout->title, width - 2 * side);
	if (room)
		text(canvas, width - side - subtitle, above, unit, line, faint);

	int bar = PAD * unit + (RENDER_LETTER_HEIGHT + 4) * unit;
	draw_legend(layout, canvas, side + 14 * unit, bar, unit, &range, beyond);
	int right = width - side - 20 * unit;
	draw_scale(canvas, right, bar, unit, right - (side + (LEGEND + 40) * unit), placed->scale);
	return draw_north(canvas, width - side - 6 * unit, PAD * unit, unit);
}
