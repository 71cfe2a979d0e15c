/* Finds which of some words a mistyped word was probably meant to be. Pure. */
#ifndef FURROW_BASE_NEAREST_H
#define FURROW_BASE_NEAREST_H

#include <stddef.h>

/* A search. Words must stay valid as long as the search. */
struct nearest {
	const char *word;  /* as it was written */
	const char *found; /* NULL: no word is near enough */
	size_t changes;    /* from `word` to `found` */
};

/* Begins a search for `word`. */
struct nearest nearest_begin(const char *word);
/*
 * Offers a word. It is near if at most a third of the letters of `word` must change. A change adds a letter, leaves one out, replaces one, or swaps two.
 * Of words that are as near as each other the first is kept, or the first that has the same last letter as `word`. Words of more than 40 letters are never
 * near.
 */
void nearest_offer(struct nearest *nearest, const char *word);

/* The end of a message: "; did you mean FOUND?", or "" if no word is near. */
struct nearest_text {
	char text[80];
};
struct nearest_text nearest_ask(const struct nearest *nearest);

#endif
