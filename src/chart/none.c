/* No maps and no letters: this build was made without Pango and Cairo. */
#include "chart/internal.h"

#define MISSING "this build draws no maps and no letters; build it where Pango and Cairo are (libpango1.0-dev)"

const char *chart_missing(void)
{
	return MISSING;
}

enum status chart_map_write(const struct chart_map *map, const char *path, struct chart_written *written)
{
	return fail_with(STATUS_FAILED, "map: " MISSING);
}

enum status chart_pen_create(struct chart_pen **out)
{
	return fail_with(STATUS_FAILED, "text: " MISSING);
}

void chart_pen_destroy(struct chart_pen *pen)
{
}

int chart_pen_width(struct chart_pen *pen, int size, const char *text)
{
	return 0;
}

enum status chart_pen_write(struct chart_pen *pen, const struct chart_pixels *pixels, int x, int y, int size, const char *text,
			    struct chart_colour colour)
{
	return fail_with(STATUS_FAILED, "text: " MISSING);
}
