/* Signs that no installed font has. Pango draws each as a box with its number, so whoever asked for the text is told. */
#include <string.h>

#include "chart/page.h"

/* Adds a sign, unless it is known already. */
static void add(struct chart_unknown *unknown, gunichar sign)
{
	for (size_t i = 0; i < unknown->count; i++)
		if (unknown->signs[i] == sign)
			return;
	if (unknown->count < CHART_UNKNOWN_MOST)
		unknown->signs[unknown->count++] = sign;
	else
		unknown->more = true;
}

void chart_unknown_add(struct chart_unknown *unknown, PangoLayout *layout)
{
	if (pango_layout_get_unknown_glyphs_count(layout) == 0)
		return;
	PangoLayoutIter *iter = pango_layout_get_iter(layout);
	do {
		const PangoLayoutRun *run = pango_layout_iter_get_run_readonly(iter);
		for (int i = 0; run != NULL && i < run->glyphs->num_glyphs; i++) {
			const PangoGlyph glyph = run->glyphs->glyphs[i].glyph;
			if (glyph != PANGO_GLYPH_INVALID_INPUT && (glyph & PANGO_GLYPH_UNKNOWN_FLAG) != 0)
				add(unknown, glyph & ~PANGO_GLYPH_UNKNOWN_FLAG);
		}
	} while (pango_layout_iter_next_run(iter));
	pango_layout_iter_free(iter);
}

/* Returns Debian's package with a font that has the sign; NULL if none has it. */
static const char *package_of(gunichar sign)
{
	const GUnicodeType type = g_unichar_type(sign);
	if (type == G_UNICODE_PRIVATE_USE || type == G_UNICODE_UNASSIGNED || type == G_UNICODE_CONTROL)
		return NULL;
	switch (g_unichar_get_script(sign)) {
	case G_UNICODE_SCRIPT_HAN:
	case G_UNICODE_SCRIPT_HANGUL:
	case G_UNICODE_SCRIPT_HIRAGANA:
	case G_UNICODE_SCRIPT_KATAKANA:
	case G_UNICODE_SCRIPT_BOPOMOFO:
		return "fonts-noto-cjk";
	default:
		break;
	}
	if ((sign >= 0x3000 && sign < 0x3100) || (sign >= 0xff00 && sign < 0xfff0))
		return "fonts-noto-cjk"; /* marks of those scripts */
	return sign >= 0x1f000 && sign < 0x1fb00 ? "fonts-noto-color-emoji" : "fonts-noto-core";
}

/* Names each package once: "fonts-noto-cjk and fonts-noto-core". "" if there is none. */
static void write_packages(const struct chart_unknown *unknown, GString *text)
{
	for (size_t i = 0; i < unknown->count; i++) {
		const char *package = package_of(unknown->signs[i]);
		if (package != NULL && strstr(text->str, package) == NULL)
			g_string_append_printf(text, "%s%s", text->len > 0 ? " and " : "", package);
	}
}

void chart_unknown_tell(const struct chart_unknown *unknown, const char *what)
{
	if (unknown->count == 0)
		return;
	GString *signs = g_string_new(NULL), *packages = g_string_new(NULL);
	for (size_t i = 0; i < unknown->count; i++) {
		const gunichar sign = unknown->signs[i];
		char letter[8] = "";
		if (g_unichar_isgraph(sign) && g_unichar_type(sign) != G_UNICODE_PRIVATE_USE)
			letter[g_unichar_to_utf8(sign, letter)] = '\0';
		g_string_append_printf(signs, "%s%s%sU+%04X%s", i > 0 ? ", " : "", letter, letter[0] != '\0' ? " (" : "", sign,
				       letter[0] != '\0' ? ")" : "");
	}
	write_packages(unknown, packages);
	note("%s: no installed font has %s%s, so each is drawn as a box with its number; %s%s", what, signs->str,
	     unknown->more ? " and more" : "", packages->len > 0 ? "install a font that has it, as in " : "give a text without it",
	     packages->str);
	g_string_free(signs, true);
	g_string_free(packages, true);
}
