/* The legend: what the colours mean, as a ramp with its numbers or as classes, and the list of ways. */
#include <math.h>
#include <stdio.h>

#include "chart/page.h"

#define RAMP 164.0 /* points: its length */
#define BAR 8.0
#define SWATCH 14.0
#define CLASS_MOST 190.0 /* points: the longest name of a class */
#define LINE 11.5        /* from one line of a list to the next */
#define COLUMN 128.0     /* of the list of ways */
#define SAMPLE 20.0
#define GAP 5.0

static const struct chart_style head = {.kind = CHART_LEGEND, .size = 8, .bold = true, .colour = {32, 36, 42, 255}};
static const struct chart_style line = {.kind = CHART_LEGEND, .size = 7.5, .colour = {32, 36, 42, 255}};
static const struct chart_style number = {.kind = CHART_LEGEND, .size = 7, .colour = {32, 36, 42, 255}};

/* Returns the unit that a range is given in. *of: of metres, or of 1 if values are shares. */
static const char *unit_for(const struct chart_legend *legend, double *of)
{
	const struct chart_range *range = &legend->range;
	const double size = fmax(fabs(range->low), fabs(range->high));
	const bool metres = legend->map->ramp == CHART_RAMP_HEIGHTS || size >= 0.999;
	*of = legend->map->share ? 0.01 : metres ? 1 : size < 0.00999 ? 0.001 : 0.01;
	return legend->map->share ? "%" : metres ? "m" : size < 0.00999 ? "mm" : "cm";
}

static bool has_ramp(const struct chart_legend *legend)
{
	return legend->map->classes == NULL && legend->map->colours == NULL && legend->range.high > legend->range.low;
}

/* Writes the legend's title: what the colours show, and the unit. Returns its style: a title of a ramp breaks at the ramp's width into at most
 * two lines; one of classes stays on one line. */
static struct chart_style write_head(const struct chart_legend *legend, char *text, size_t room)
{
	const struct chart_map *map = legend->map;
	struct chart_style style = head;
	char plain[48];
	double of;
	const char *unit = unit_for(legend, &of);
	if (map->classes != NULL || map->colours != NULL) {
		snprintf(text, room, "%s", map->layer);
		return style;
	}
	if (has_ramp(legend)) {
		snprintf(text, room, "%s, %s", map->layer, unit);
	} else if (map->ramp != CHART_RAMP_HEIGHTS) {
		snprintf(text, room, "%s: no change", map->layer);
	} else {
		chart_number(legend->range.low, 0.01, plain, sizeof plain);
		snprintf(text, room, "%s: %s m everywhere", map->layer, plain);
	}
	style.most = RAMP;
	style.lines = 2;
	return style;
}

static size_t lines_of(const struct chart_legend *legend)
{
	return legend->map->classes != NULL ? legend->map->key_count : 0;
}

void chart_legend_measure(struct chart_page *page, struct chart_legend *legend, double width, double room)
{
	const struct chart_map *map = legend->map;
	size_t ways = 0;
	for (size_t i = 0; i < map->way_count; i++)
		ways += map->ways[i].count > 0;
	char text[160];
	double head_width, head_height;
	const struct chart_style style = write_head(legend, text, sizeof text);
	chart_text_size(page, &style, text, &head_width, &head_height);
	legend->head_height = head_height > 1.5 * LINE ? 2 * LINE - 1 : LINE;
	legend->values_height = legend->head_height +
				(map->classes != NULL ? LINE * (double)map->key_count
				 : has_ramp(legend)   ? BAR + 15
						      : 0) +
				(legend->holes ? LINE + 2 : 0);
	legend->columns = (int)fmax(1, floor((width + GAP) / (COLUMN + GAP)));
	const size_t lines = (size_t)fmax(2, floor((room - LINE) / LINE));
	const size_t most = lines * (size_t)legend->columns;
	legend->listed = ways > most ? most - 1 : ways;
	const size_t entries = legend->listed + (legend->listed < ways);
	legend->ways_width = width;
	legend->ways_height = ways == 0 ? 0 : LINE * (1 + ceil((double)entries / legend->columns));
}

/* --- values --- */

static void write_value(struct chart_page *page, double x, double y, double left, double right, const char *text)
{
	double width, height;
	chart_text_size(page, &number, text, &width, &height);
	chart_text(page, &number, fmin(fmax(x - width / 2, left), right - width), y, text);
}

/* A number on the ramp: its place from the left end, and its text. */
struct tick {
	double at;
	char text[128];
};

static double tick_width(struct chart_page *page, const struct tick *tick)
{
	double width, height;
	chart_text_size(page, &number, tick->text, &width, &height);
	return width;
}

/* A number of an end of the ramp: with the digits of the round numbers if it is one, otherwise with those of `fine`. */
static void write_end(double value, double step, double fine, char *text, size_t room)
{
	chart_number(value, fabs(value - nearbyint(value / step) * step) < 1e-7 * step ? step : fine, text, room);
}

/* Both ends, and round numbers between them that have room. */
static void draw_ticks(struct chart_page *page, const struct chart_legend *legend, double x, double y)
{
	const struct chart_range *range = &legend->range;
	double of;
	unit_for(legend, &of);
	const double low = range->low / of, high = range->high / of, span = high - low;
	const double step = chart_round_step(span / 4),
		     fine = chart_round_length(span / 50);
	struct tick ends[2] = {{0, ""}, {RAMP, ""}};
	for (int i = 0; i < 2; i++) {
		char plain[56], most[56];
		write_end(i == 0 ? low : high, step, fine, plain, sizeof plain);
		write_end(legend->beyond[i] / of, step, fine, most, sizeof most);
		if (isnan(legend->beyond[i]))
			snprintf(ends[i].text, sizeof ends[i].text, "%s", plain);
		else
			snprintf(ends[i].text, sizeof ends[i].text, "%s to %s", i == 0 ? most : plain, i == 0 ? plain : most);
	}
	double taken = tick_width(page, &ends[0]) + GAP, limit = RAMP - tick_width(page, &ends[1]) - GAP;
	cairo_set_line_width(page->cairo, 0.6);
	for (double value = ceil(low / step) * step; value <= high + 1e-9 * span; value += step) {
		struct tick tick = {.at = (value - low) / span * RAMP};
		chart_number(value, step, tick.text, sizeof tick.text);
		const double half = tick_width(page, &tick) / 2;
		if (tick.at - half < taken || tick.at + half > limit)
			continue;
		cairo_move_to(page->cairo, x + tick.at, y);
		cairo_line_to(page->cairo, x + tick.at, y + 2.5);
		chart_page_colour(page, chart_ink);
		cairo_stroke(page->cairo);
		write_value(page, x + tick.at, y + 3.5, x, x + RAMP, tick.text);
		taken = tick.at + half + GAP;
	}
	for (int i = 0; i < 2; i++)
		write_value(page, x + ends[i].at, y + 3.5, x, x + RAMP, ends[i].text);
}

static void draw_ramp(struct chart_page *page, const struct chart_legend *legend, double x, double y)
{
	enum { STEPS = 128 };
	const struct chart_map *map = legend->map;
	const double flat = map->raster->flat;
	cairo_pattern_t *pattern = cairo_pattern_create_linear(x, 0, x + RAMP, 0);
	for (int i = 0; i <= STEPS; i++) {
		const double value = legend->range.low + (double)i / STEPS * (legend->range.high - legend->range.low);
		const struct chart_colour over = chart_ramp(map->ramp, chart_ramp_place(map->ramp, &legend->range, value));
		const struct chart_colour colour = chart_ground_colour(flat, flat, over);
		cairo_pattern_add_color_stop_rgb(pattern, (double)i / STEPS, colour.r / 255.0, colour.g / 255.0, colour.b / 255.0);
	}
	cairo_t *cairo = page->cairo;
	cairo_rectangle(cairo, x, y, RAMP, BAR);
	cairo_set_source(cairo, pattern);
	cairo_fill_preserve(cairo);
	cairo_pattern_destroy(pattern);
	chart_page_colour(page, chart_ink);
	cairo_set_line_width(cairo, 0.5);
	cairo_stroke(cairo);
	draw_ticks(page, legend, x, y + BAR);
}

static void swatch(struct chart_page *page, double x, double y, struct chart_colour colour)
{
	cairo_rectangle(page->cairo, x, y + 1.5, SWATCH, LINE - 4);
	chart_page_colour(page, colour);
	cairo_fill_preserve(page->cairo);
	chart_page_colour(page, chart_faint);
	cairo_set_line_width(page->cairo, 0.4);
	cairo_stroke(page->cairo);
}

static void draw_hatched(struct chart_page *page, double x, double y)
{
	cairo_t *cairo = page->cairo;
	swatch(page, x, y, chart_ground_colour(NAN, 0, (struct chart_colour){0, 0, 0, 0}));
	cairo_save(cairo);
	cairo_rectangle(cairo, x, y + 1.5, SWATCH, LINE - 4);
	cairo_clip(cairo);
	cairo_set_line_width(cairo, 0.6);
	chart_page_colour(page, (struct chart_colour){150, 160, 174, 255});
	for (double at = -LINE; at < SWATCH + LINE; at += 3.5) {
		cairo_move_to(cairo, x + at, y + LINE);
		cairo_line_to(cairo, x + at + LINE, y);
	}
	cairo_stroke(cairo);
	cairo_restore(cairo);
	chart_text(page, &line, x + SWATCH + GAP, y, "no data");
}

void chart_legend_values(struct chart_page *page, const struct chart_legend *legend, double x, double y)
{
	const struct chart_map *map = legend->map;
	char text[160];
	struct chart_style class_style = line;
	const struct chart_style style = write_head(legend, text, sizeof text);
	chart_text(page, &style, x, y, text);
	y += legend->head_height;
	for (size_t i = 0; i < lines_of(legend); i++, y += LINE) {
		swatch(page, x, y, map->keys[i].colour);
		snprintf(text, sizeof text, "%s: %.1f %%", map->keys[i].name, 100 * map->keys[i].share);
		class_style.most = CLASS_MOST;
		chart_text(page, &class_style, x + SWATCH + GAP, y, text);
	}
	if (has_ramp(legend)) {
		draw_ramp(page, legend, x, y + 1);
		y += BAR + 17;
	}
	if (legend->holes)
		draw_hatched(page, x, y);
}

/* --- ways --- */

void chart_legend_ways(struct chart_page *page, const struct chart_legend *legend, double x, double y)
{
	const struct chart_map *map = legend->map;
	struct chart_style style = line;
	size_t drawn = 0, objects = 0, vehicles = 0;
	for (size_t i = 0; i < map->way_count; i++) {
		objects += map->ways[i].count > 0 && !map->ways[i].vehicle;
		vehicles += map->ways[i].count > 0 && map->ways[i].vehicle;
	}
	if (objects + vehicles == 0)
		return;
	chart_text(page, &head, x, y,
		   objects == 0    ? "Ways of vehicles"
		   : vehicles == 0 ? "Ways of objects"
				   : "Ways of objects (●) and vehicles (■)");
	const size_t entries = legend->listed + (legend->listed < objects + vehicles);
	const size_t lines = (entries + (size_t)legend->columns - 1) / (size_t)legend->columns;
	style.most = COLUMN - SAMPLE - GAP;
	y += LINE;
	for (size_t i = 0; i < map->way_count && drawn < legend->listed; i++) {
		if (map->ways[i].count == 0)
			continue;
		const double left = x + (double)(drawn / lines) * (COLUMN + GAP), top = y + (double)(drawn % lines) * LINE;
		chart_way_sample(page, i, map->ways[i].vehicle, left, top + LINE / 2 - 1, SAMPLE);
		chart_text(page, &style, left + SAMPLE + GAP, top, map->ways[i].name);
		drawn++;
	}
	if (entries > legend->listed) {
		char text[48];
		snprintf(text, sizeof text, "and %zu more", objects + vehicles - legend->listed);
		chart_text(page, &style, x + (double)(drawn / lines) * (COLUMN + GAP), y + (double)(drawn % lines) * LINE, text);
	}
}
