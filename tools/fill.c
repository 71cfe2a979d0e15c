/* Text in lines of a width. */
#include "fill.h"

#include <stdbool.h>
#include <string.h>

void fill_word(struct fill *fill, const char *word, size_t length)
{
	const bool first = fill->column == fill->indent;
	if (!first && fill->column + 1 + (int)length > fill->width) {
		fprintf(fill->out, "\n%*s", fill->indent, "");
		fill->column = fill->indent;
	} else if (!first) {
		putc(' ', fill->out);
		fill->column++;
	}
	fprintf(fill->out, "%.*s", (int)length, word);
	fill->column += (int)length;
}

static void fill_span(struct fill *fill, const char *text, const char *end)
{
	while (text < end) {
		size_t length = strcspn(text, " \n");
		if (length > (size_t)(end - text))
			length = (size_t)(end - text);
		if (length > 0)
			fill_word(fill, text, length);
		text += length + 1;
	}
}

void fill_words(struct fill *fill, const char *text)
{
	fill_span(fill, text, text + strlen(text));
}

void fill_end(struct fill *fill)
{
	putc('\n', fill->out);
	fill->column = fill->indent;
}

enum block fill_next_block(const char **at, const char **begin, const char **end)
{
	const char *line = *at + strspn(*at, "\n");
	*begin = *end = *at = line;
	if (*line == '\0')
		return BLOCK_END;
	const bool kept = *line == ' ';
	while (*line != '\0' && *line != '\n' && (*line == ' ') == kept) {
		*end = line + strcspn(line, "\n");
		line = *end + (**end == '\n');
		*at = line;
	}
	return kept ? BLOCK_KEPT : BLOCK_PARAGRAPH;
}

void fill_blocks(FILE *out, int width, const char *text)
{
	const char *begin, *end;
	enum block block;
	for (bool first = true; (block = fill_next_block(&text, &begin, &end)) != BLOCK_END; first = false) {
		if (!first)
			putc('\n', out);
		if (block == BLOCK_KEPT) {
			fprintf(out, "%.*s\n", (int)(end - begin), begin);
			continue;
		}
		struct fill fill = {.out = out, .width = width};
		fill_span(&fill, begin, end);
		fill_end(&fill);
	}
}
