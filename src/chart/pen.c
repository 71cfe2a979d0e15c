/* Lines of text on pixels that somebody else drew, as on the picture of a window. */
#include <math.h>

#include "chart/page.h"

#define LETTERS 0.82 /* size of the letters, of the line's height */

struct chart_pen {
	struct chart_page page; /* its fonts */
};

enum status chart_pen_create(struct chart_pen **out)
{
	struct chart_pen *pen = mem_calloc(1, sizeof *pen);
	TRY_MEM(pen, "a pen");
	enum status status = chart_page_create(&pen->page);
	if (status != STATUS_OK) {
		mem_free(pen);
		return status;
	}
	*out = pen;
	return STATUS_OK;
}

void chart_pen_destroy(struct chart_pen *pen)
{
	if (pen == NULL)
		return;
	chart_page_finish(&pen->page);
	mem_free(pen);
}

static struct chart_style style_of(int size)
{
	return (struct chart_style){.kind = CHART_LEGEND, .size = LETTERS * size, .colour = {0, 0, 0, 255}};
}

int chart_pen_width(struct chart_pen *pen, int size, const char *text)
{
	const struct chart_style style = style_of(size);
	double width, height;
	chart_text_size(&pen->page, &style, text, &width, &height);
	return (int)ceil(width);
}

/* `cover`: how much of each pixel the letters cover, the top row first. */
static void lay(const struct chart_pixels *pixels, int x, int y, const uint8_t *cover, int width, int height, int stride,
		struct chart_colour colour)
{
	for (int row = 0; row < height; row++) {
		const int64_t to_y = (int64_t)y + height - 1 - row;
		if (to_y < 0 || to_y >= pixels->height)
			continue;
		for (int i = 0; i < width; i++) {
			const int64_t to_x = (int64_t)x + i;
			if (to_x >= 0 && to_x < pixels->width)
				chart_blend(pixels->pixels + 4 * ((size_t)to_y * pixels->width + (size_t)to_x), colour,
					    cover[(size_t)row * (size_t)stride + (size_t)i]);
		}
	}
}

enum status chart_pen_write(struct chart_pen *pen, const struct chart_pixels *pixels, int x, int y, int size, const char *text,
			    struct chart_colour colour)
{
	const struct chart_style style = style_of(size);
	double wide, high;
	chart_text_size(&pen->page, &style, text, &wide, &high);
	const int width = (int)fmin(ceil(wide), pixels->width), height = size;
	if (width < 1 || height < 1)
		return STATUS_OK;
	const int stride = cairo_format_stride_for_width(CAIRO_FORMAT_A8, width);
	uint8_t *cover = mem_calloc((size_t)height, (size_t)stride);
	TRY_MEM(cover, "letters");
	cairo_surface_t *surface = cairo_image_surface_create_for_data(cover, CAIRO_FORMAT_A8, width, height, stride);
	cairo_t *cairo = cairo_create(surface);
	const size_t before = pen->page.unknown.count;
	chart_text_on(&pen->page, cairo, &style, 0, (height - high) / 2, text);
	const cairo_status_t failed = cairo_status(cairo);
	cairo_destroy(cairo);
	cairo_surface_destroy(surface);
	if (pen->page.unknown.count > before)
		chart_unknown_tell(&pen->page.unknown, "text");
	if (failed == CAIRO_STATUS_SUCCESS)
		lay(pixels, x, y, cover, width, height, stride, colour);
	mem_free(cover);
	return failed == CAIRO_STATUS_SUCCESS
		       ? STATUS_OK
		       : fail_with(STATUS_FAILED, "text: %s; make the window smaller", cairo_status_to_string(failed));
}
