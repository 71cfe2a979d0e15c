/* The scale bar and the arrow to grid north. */

#include "chart/page.h"

#define BAR 3.4 /* points: the bar's height */
#define PARTS 4
#define NUMBERS 7.0 /* points: size of the numbers */

double chart_scale_length(double most, double metres)
{
	return chart_round_length(most * metres) / metres;
}

static void number_at(struct chart_page *page, double x, double y, const char *text)
{
	const struct chart_style style = {.kind = CHART_LEGEND, .size = NUMBERS, .colour = chart_ink};
	double width, height;
	chart_text_size(page, &style, text, &width, &height);
	chart_text(page, &style, x - width / 2, y, text);
}

void chart_scale_bar(struct chart_page *page, double x, double y, double most, double metres)
{
	char text[64];
	const double length = chart_scale_length(most, metres);
	cairo_t *cairo = page->cairo;
	x = chart_page_snap(page, x);
	y = chart_page_snap(page, y);
	for (int part = 0; part < PARTS; part += 2)
		chart_page_box(page, &(struct chart_rect){x + length * part / PARTS, y, x + length * (part + 1) / PARTS, y + BAR},
			       chart_ink);
	chart_page_colour(page, chart_ink);
	cairo_set_line_width(cairo, 0.6);
	cairo_rectangle(cairo, x, y, length, BAR);
	cairo_stroke(cairo);
	number_at(page, x, y + BAR + 1.5, "0");
	chart_length(length * metres, text, sizeof text);
	number_at(page, x + length, y + BAR + 1.5, text);
}

/* A needle whose western half is dark. */
void chart_north(struct chart_page *page, double x, double y)
{
	const struct chart_style style = {.kind = CHART_LEGEND, .size = 8, .bold = true, .colour = chart_ink};
	const double high = 15, half = 4.6, notch = 3.6;
	double width, height;
	cairo_t *cairo = page->cairo;
	chart_text_size(page, &style, "N", &width, &height);
	chart_text(page, &style, x - width / 2, y, "N");
	y += height + 0.5;
	chart_page_colour(page, chart_ink);
	cairo_set_line_width(cairo, 0.7);
	cairo_move_to(cairo, x, y);
	cairo_line_to(cairo, x - half, y + high);
	cairo_line_to(cairo, x, y + high - notch);
	cairo_close_path(cairo);
	cairo_fill(cairo);
	cairo_move_to(cairo, x, y);
	cairo_line_to(cairo, x + half, y + high);
	cairo_line_to(cairo, x, y + high - notch);
	cairo_close_path(cairo);
	cairo_stroke(cairo);
}
