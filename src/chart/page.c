/* The page: its surface, what is drawn on it, and its file. */
#include <errno.h>
#include <math.h>
#include <string.h>

#include <cairo-pdf.h>
#include <cairo-svg.h>

#include "chart/page.h"

const struct chart_colour chart_ink = {32, 36, 42, 255}, chart_faint = {98, 104, 112, 255}, chart_paper = {255, 255, 255, 255};

enum status chart_page_create(struct chart_page *page)
{
	*page = (struct chart_page){.fonts = NULL};
	const char *missing = chart_missing();
	if (missing != NULL)
		return fail_with(STATUS_FAILED, "map: %s", missing);
	page->fonts = pango_cairo_font_map_new();
	page->context = pango_font_map_create_context(page->fonts);
	page->face = pango_font_description_from_string(CHART_FAMILIES);
	cairo_font_options_t *options = cairo_font_options_create();
	cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
	cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
	cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
	pango_cairo_context_set_font_options(page->context, options);
	cairo_font_options_destroy(options);
	pango_cairo_context_set_resolution(page->context, 72);
	pango_context_set_round_glyph_positions(page->context, false);
	pango_context_set_language(page->context, pango_language_from_string("en"));
	return STATUS_OK;
}

double chart_page_snap(const struct chart_page *page, double place)
{
	return round(place * page->dots) / page->dots;
}

/* --- SVG: Cairo writes letters as outlines; so that the words can be found and read aloud, they are written before them --- */

static bool put(struct chart_page *page, const void *bytes, size_t length)
{
	if (page->full == 0 && length > 0 && fwrite(bytes, 1, length, page->aside.file) != length)
		page->full = errno != 0 ? errno : EIO;
	return page->full == 0;
}

/* As XML, without characters that XML does not have. */
static void put_words(struct chart_page *page, const char *text)
{
	for (const char *p = text; *p != '\0'; p = g_utf8_next_char(p)) {
		const gunichar c = g_utf8_get_char(p);
		const char *named = c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : NULL;
		if (named != NULL)
			put(page, named, strlen(named));
		else if (c >= 0x20 && (c & 0xfffe) != 0xfffe && (c < 0x7f || c > 0x9f))
			put(page, p, (size_t)(g_utf8_next_char(p) - p));
	}
}

static void put_description(struct chart_page *page)
{
	char *title = chart_text_valid(page->title);
	put(page, "\n<title>", 8);
	put_words(page, title);
	put(page, "</title>\n<desc>", 15);
	for (size_t i = 0; i < page->said_count; i++) {
		put_words(page, page->said[i].text);
		put(page, "\n", 1);
	}
	put(page, "</desc>\n", 8);
	g_free(title);
}

static cairo_status_t take(void *user, const unsigned char *bytes, unsigned int length)
{
	struct chart_page *page = user;
	if (page->format == CHART_SVG && !page->head) {
		/* Cairo writes the first tag in one piece, or letter by letter. */
		const unsigned char *end = NULL, *from = bytes;
		while ((end = memchr(from, '>', length - (size_t)(from - bytes))) != NULL) {
			const bool declaration = end > bytes && end[-1] == '?';
			from = end + 1;
			if (!declaration)
				break;
		}
		if (end != NULL) {
			const size_t head = (size_t)(from - bytes);
			put(page, bytes, head);
			put_description(page);
			page->head = true;
			bytes += head;
			length -= (unsigned int)head;
		}
	}
	return put(page, bytes, length) ? CAIRO_STATUS_SUCCESS : CAIRO_STATUS_WRITE_ERROR;
}

/* --- the surface --- */

static enum status open_picture(struct chart_page *page)
{
	const int stride = cairo_format_stride_for_width(CAIRO_FORMAT_RGB24, (int)page->columns);
	TRY(mem_zeroed(&page->pixels, page->rows, (size_t)stride, "a map"));
	page->surface =
		cairo_image_surface_create_for_data(page->pixels, CAIRO_FORMAT_RGB24, (int)page->columns, (int)page->rows, stride);
	return STATUS_OK;
}

static enum status open_file(struct chart_page *page, const char *path)
{
	TRY(aside_begin(&page->aside, path));
	if (page->format == CHART_SVG) {
		page->surface = cairo_svg_surface_create_for_stream(take, page, page->width, page->height);
		cairo_svg_surface_set_document_unit(page->surface, CAIRO_SVG_UNIT_PT);
		return STATUS_OK;
	}
	page->surface = cairo_pdf_surface_create_for_stream(take, page, page->width, page->height);
	char *title = chart_text_valid(page->title);
	cairo_pdf_surface_set_metadata(page->surface, CAIRO_PDF_METADATA_TITLE, title);
	cairo_pdf_surface_set_metadata(page->surface, CAIRO_PDF_METADATA_CREATOR, "furrow");
	/* The same map is the same file: a date would change it. */
	cairo_pdf_surface_set_metadata(page->surface, CAIRO_PDF_METADATA_CREATE_DATE, "2000-01-01T00:00:00Z");
	g_free(title);
	return STATUS_OK;
}

enum status chart_page_open(struct chart_page *page, const char *path, enum chart_format format, double width, double height,
			    double dots, const char *title)
{
	page->format = format;
	page->width = width;
	page->height = height;
	page->dots = dots;
	page->title = title;
	page->columns = (uint32_t)ceil(width * dots - 1e-6);
	page->rows = (uint32_t)ceil(height * dots - 1e-6);
	TRY(format == CHART_PNG ? open_picture(page) : open_file(page, path));
	page->cairo = cairo_create(page->surface);
	if (format == CHART_PNG)
		cairo_scale(page->cairo, dots, dots);
	cairo_set_line_join(page->cairo, CAIRO_LINE_JOIN_ROUND);
	chart_page_colour(page, chart_paper);
	cairo_paint(page->cairo);
	return STATUS_OK;
}

/* --- drawing --- */

void chart_page_colour(struct chart_page *page, struct chart_colour colour)
{
	cairo_set_source_rgba(page->cairo, colour.r / 255.0, colour.g / 255.0, colour.b / 255.0, colour.a / 255.0);
}

void chart_page_box(struct chart_page *page, const struct chart_rect *rect, struct chart_colour colour)
{
	chart_page_colour(page, colour);
	cairo_rectangle(page->cairo, rect->x0, rect->y0, rect->x1 - rect->x0, rect->y1 - rect->y0);
	cairo_fill(page->cairo);
}

enum status chart_page_image(struct chart_page *page, uint32_t *pixels, uint32_t width, uint32_t height,
			     const struct chart_rect *rect)
{
	cairo_surface_t *image = cairo_image_surface_create_for_data((unsigned char *)pixels, CAIRO_FORMAT_RGB24, (int)width,
								     (int)height, (int)(4 * width));
	cairo_t *cairo = page->cairo;
	cairo_save(cairo);
	cairo_translate(cairo, rect->x0, rect->y0);
	cairo_scale(cairo, (rect->x1 - rect->x0) / width, (rect->y1 - rect->y0) / height);
	cairo_set_source_surface(cairo, image, 0, 0);
	/* On a PNG a pixel of the ground is one of the picture. */
	cairo_pattern_set_filter(cairo_get_source(cairo), CAIRO_FILTER_NEAREST);
	cairo_rectangle(cairo, 0, 0, width, height);
	cairo_fill(cairo);
	cairo_restore(cairo);
	const cairo_status_t failed = cairo_surface_status(image);
	cairo_surface_flush(image);
	/* SVG and PDF may keep a reference until they are written: then they keep a copy. */
	cairo_surface_finish(image);
	cairo_surface_destroy(image);
	return failed == CAIRO_STATUS_SUCCESS
		       ? STATUS_OK
		       : fail_with(STATUS_FAILED, "map: %s; draw a smaller one", cairo_status_to_string(failed));
}

/* --- the file --- */

/* From 0x00RRGGBB, the top row first, to RGBA bytes, the bottom row first, in place. */
static void turn_pixels(struct chart_page *page)
{
	const size_t columns = page->columns;
	for (uint32_t low = 0; low < (page->rows + 1) / 2; low++) {
		uint8_t *a = page->pixels + 4 * columns * low, *b = page->pixels + 4 * columns * (page->rows - 1 - low);
		for (size_t x = 0; x < columns; x++, a += 4, b += 4) {
			uint32_t p, q;
			memcpy(&p, a, 4);
			memcpy(&q, b, 4);
			const uint8_t from_p[4] = {(uint8_t)(p >> 16), (uint8_t)(p >> 8), (uint8_t)p, 255};
			const uint8_t from_q[4] = {(uint8_t)(q >> 16), (uint8_t)(q >> 8), (uint8_t)q, 255};
			memcpy(a, from_q, 4);
			memcpy(b, from_p, 4);
		}
	}
}

enum status chart_page_write(struct chart_page *page, const char *path)
{
	cairo_status_t failed = cairo_status(page->cairo);
	cairo_surface_finish(page->surface);
	if (failed == CAIRO_STATUS_SUCCESS)
		failed = cairo_surface_status(page->surface);
	if (page->full != 0)
		return fail_with(STATUS_FAILED, "%s: cannot write the map: %s; check space and permissions of its folder", path,
				 strerror(page->full));
	if (failed != CAIRO_STATUS_SUCCESS)
		return fail_with(STATUS_FAILED, "%s: cannot draw the map: %s; give a smaller --size or a smaller --window", path,
				 cairo_status_to_string(failed));
	if (page->lacking)
		return fail_memory("a map's words");
	if (page->format == CHART_PNG) {
		turn_pixels(page);
		return chart_png_write_for_print(path, page->pixels, page->columns, page->rows,
						 (uint32_t)lround(page->dots * 72 / 0.0254));
	}
	TRY(aside_whole(&page->aside, false));
	return aside_publish(&page->aside);
}

void chart_page_finish(struct chart_page *page)
{
	if (page->cairo != NULL)
		cairo_destroy(page->cairo);
	if (page->surface != NULL) {
		/* An SVG or a PDF that is not written yet is written now: to nowhere. */
		page->full = page->full != 0 || page->aside.file == NULL ? 1 : ECANCELED;
		cairo_surface_destroy(page->surface);
	}
	aside_finish(&page->aside);
	mem_free(page->pixels);
	for (size_t i = 0; i < page->said_count; i++)
		g_free(page->said[i].text);
	mem_free(page->said);
	if (page->face != NULL)
		pango_font_description_free(page->face);
	g_clear_object(&page->context);
	g_clear_object(&page->fonts);
	*page = (struct chart_page){.fonts = NULL};
}
