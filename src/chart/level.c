/* What a map asks for: the format of its file, and the level of its posts. */
#include <string.h>
#include <strings.h>

#include "chart/internal.h"

bool chart_path_format(const char *path, enum chart_format *format)
{
	static const char *const endings[] = {[CHART_PNG] = ".png", [CHART_SVG] = ".svg", [CHART_PDF] = ".pdf"};
	size_t length = strlen(path);
	for (size_t i = 0; i < sizeof endings / sizeof *endings; i++)
		if (length > 4 && strcasecmp(path + length - 4, endings[i]) == 0) {
			*format = (enum chart_format)i;
			return true;
		}
	return false;
}

int chart_level(const struct extent *extent, int from, uint32_t pixels, struct post_rect *rect)
{
	const struct post_rect posts = *rect;
	const int64_t most = pixels > 0 ? pixels : 1;
	const int coarsest = extent_coarsest(extent);
	int level = from;
	while (level < coarsest && (rect->x1 - rect->x0 > most || rect->y1 - rect->y0 > most)) {
		const int shift = ++level - from;
		const int64_t half = (int64_t)1 << (shift - 1);
		const struct post_rect all = {0, 0, extent_posts(extent->width, level), extent_posts(extent->height, level)};
		*rect = post_rect_intersect((struct post_rect){(posts.x0 + half) >> shift, (posts.y0 + half) >> shift,
							       ((posts.x1 - 1 + half) >> shift) + 1,
							       ((posts.y1 - 1 + half) >> shift) + 1},
					    all);
		if (rect->x0 == rect->x1) /* nearer to a post beyond the last one */
			rect->x0--;
		if (rect->y0 == rect->y1)
			rect->y0--;
	}
	return level;
}
