/* Words: Pango sets them, in any script and direction. */
#include <math.h>
#include <string.h>

#include <fontconfig/fontconfig.h>

#include "chart/page.h"

#define HALO 2.2 /* points, half of it outside the letters */

const char *chart_missing(void)
{
	FcFontSet *fonts = FcConfigGetFonts(FcConfigGetCurrent(), FcSetSystem);
	return fonts != NULL && fonts->nfont > 0 ? NULL
						 : "there is no font to draw letters with; install one, as fonts-dejavu-core";
}

char *chart_text_valid(const char *text)
{
	char *valid = g_utf8_make_valid(text, -1);
	for (char *p = valid, *next; *p != '\0'; p = next) {
		const gunichar c = g_utf8_get_char(p);
		next = g_utf8_next_char(p);
		if (g_unichar_iscntrl(c) || c == 0x2028 || c == 0x2029)
			memset(p, ' ', (size_t)(next - p)); /* control characters, and ends of lines and paragraphs */
	}
	return valid;
}

static PangoLayout *layout_of(struct chart_page *page, const struct chart_style *style, const char *valid)
{
	PangoLayout *layout = pango_layout_new(page->context);
	pango_font_description_set_absolute_size(page->face, style->size * PANGO_SCALE);
	pango_font_description_set_weight(page->face, style->bold ? PANGO_WEIGHT_BOLD : PANGO_WEIGHT_NORMAL);
	pango_layout_set_font_description(layout, page->face);
	pango_layout_set_text(layout, valid, -1);
	if (style->most > 0) {
		pango_layout_set_width(layout, (int)(style->most * PANGO_SCALE));
		pango_layout_set_ellipsize(layout, style->lines > 1 ? PANGO_ELLIPSIZE_END : PANGO_ELLIPSIZE_MIDDLE);
		pango_layout_set_wrap(layout, PANGO_WRAP_WORD_CHAR);
		pango_layout_set_height(layout, style->lines > 1 ? -style->lines : -1);
	}
	/* The left edge is the left edge, also of what runs to the left. */
	pango_layout_set_auto_dir(layout, true);
	return layout;
}

/* The rectangle of the lines, without what a set width adds beside them. */
static void extents(PangoLayout *layout, double *left, double *width, double *height)
{
	PangoRectangle logical;
	pango_layout_get_extents(layout, NULL, &logical);
	*left = (double)logical.x / PANGO_SCALE;
	*width = (double)logical.width / PANGO_SCALE;
	*height = (double)logical.height / PANGO_SCALE;
}

void chart_text_size(struct chart_page *page, const struct chart_style *style, const char *text, double *width, double *height)
{
	double left;
	char *valid = chart_text_valid(text);
	PangoLayout *layout = layout_of(page, style, valid);
	extents(layout, &left, width, height);
	g_object_unref(layout);
	g_free(valid);
}

/* Takes over `valid`. */
static void remember(struct chart_page *page, enum chart_text_kind kind, struct chart_rect rect, char *valid)
{
	if (mem_grow(&page->said, &page->said_room, page->said_count + 1, sizeof *page->said, "a map") != STATUS_OK) {
		page->lacking = true;
		g_free(valid);
		return;
	}
	page->said[page->said_count++] = (struct chart_said){kind, rect, valid};
}

/* Sets the layout on `cairo`, and fills its rectangle. */
static void set(struct chart_page *page, cairo_t *cairo, PangoLayout *layout, const struct chart_style *style, double x, double y, struct chart_rect *rect)
{
	double left, width, height;
	extents(layout, &left, &width, &height);
	cairo_save(cairo);
	cairo_translate(cairo, x, style->turned ? y + width : y);
	if (style->turned)
		cairo_rotate(cairo, -M_PI / 2);
	cairo_translate(cairo, -left, 0);
	if (style->halo) {
		cairo_move_to(cairo, 0, 0);
		pango_cairo_layout_path(cairo, layout);
		cairo_set_line_width(cairo, HALO);
		cairo_set_source_rgba(cairo, 1, 1, 1, 0.85);
		cairo_stroke(cairo);
	}
	const struct chart_colour colour = style->colour;
	cairo_set_source_rgba(cairo, colour.r / 255.0, colour.g / 255.0, colour.b / 255.0, colour.a / 255.0);
	cairo_move_to(cairo, 0, 0);
	pango_cairo_show_layout(cairo, layout);
	chart_unknown_add(&page->unknown, layout);
	cairo_restore(cairo);
	*rect = (struct chart_rect){x, y, x + (style->turned ? height : width), y + (style->turned ? width : height)};
}

void chart_text_on(struct chart_page *page, cairo_t *cairo, const struct chart_style *style, double x, double y, const char *text)
{
	struct chart_rect rect;
	char *valid = chart_text_valid(text);
	PangoLayout *layout = layout_of(page, style, valid);
	set(page, cairo, layout, style, x, y, &rect);
	g_object_unref(layout);
	g_free(valid);
}

void chart_text(struct chart_page *page, const struct chart_style *style, double x, double y, const char *text)
{
	struct chart_rect rect;
	char *valid = chart_text_valid(text);
	PangoLayout *layout = layout_of(page, style, valid);
	set(page, page->cairo, layout, style, x, y, &rect);
	g_object_unref(layout);
	remember(page, style->kind, rect, valid);
}
