/* Text in lines of a width. All texts are ASCII. One thread. */
#ifndef FURROW_TOOLS_FILL_H
#define FURROW_TOOLS_FILL_H

#include <stdio.h>

struct fill {
	FILE *out;
	int width, indent; /* columns of a line, and before its text */
	int column;        /* where the line is written next; `indent`: nothing is on it yet */
};

/* A word is not broken. It goes to the next line where it does not fit. */
void fill_word(struct fill *fill, const char *word, size_t length);
/* The words of a text, which blanks part. */
void fill_words(struct fill *fill, const char *text);
void fill_end(struct fill *fill); /* ends the line */

enum block { BLOCK_END, BLOCK_PARAGRAPH, BLOCK_KEPT };

/*
 * Cuts `details` of a command into paragraphs and blocks of lines that are kept as they are. Those begin with blanks.
 * *at goes on; [*begin, *end) is the block, without the newline at its end.
 */
enum block fill_next_block(const char **at, const char **begin, const char **end);
/* Such a text as --help prints it. */
void fill_blocks(FILE *out, int width, const char *text);

#endif
