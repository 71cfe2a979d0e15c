/* The insets that a store says it has, as text: level, x, y, width, height, and the source, parted by blanks; one inset a line. */
#include "store/internal.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int store_inset_line(const struct store_inset *inset, char *text, size_t room)
{
	return snprintf(text, room, "%d %lld %lld %lld %lld %.*s\n", inset->level, (long long)inset->x, (long long)inset->y, (long long)inset->width,
			(long long)inset->height, (int)inset->source_length, inset->source);
}

static bool take_number(const char **text, int64_t low, int64_t high, int64_t *number)
{
	char *end;
	if (**text != '-' && !(**text >= '0' && **text <= '9')) /* strtoll would skip blanks and lines */
		return false;
	errno = 0;
	*number = strtoll(*text, &end, 10);
	if (errno != 0 || *end != ' ' || *number < low || *number > high)
		return false;
	*text = end + 1;
	return true;
}

bool store_inset_next(const char **text, const struct extent *extent, struct store_inset *inset)
{
	int64_t level, size[2];
	const char *at = *text;
	if (!take_number(&at, TILE_LEVEL_MIN, -1, &level))
		return false;
	size[0] = extent_posts(extent->width, (int)level);
	size[1] = extent_posts(extent->height, (int)level);
	if (!take_number(&at, 0, size[0] - 1, &inset->x) || !take_number(&at, 0, size[1] - 1, &inset->y) ||
	    !take_number(&at, 1, size[0] - inset->x, &inset->width) || !take_number(&at, 1, size[1] - inset->y, &inset->height))
		return false;
	inset->level = (int)level;
	inset->source = at;
	inset->source_length = strcspn(at, "\n");
	*text = at + inset->source_length + (at[inset->source_length] == '\n');
	return true;
}
