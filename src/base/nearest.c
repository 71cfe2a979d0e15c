/* Counts the changes between two words: optimal string alignment (Damerau, Comm. ACM 7, 1964; Levenshtein, 1966). */
#include "base/nearest.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#define LONGEST 40

static size_t least(size_t a, size_t b)
{
	return a < b ? a : b;
}

static size_t changes_between(const char *a, size_t a_length, const char *b, size_t b_length)
{
	size_t rows[3][LONGEST + 1]; /* of the first i - 2, i - 1 and i letters of a */
	for (size_t j = 0; j <= b_length; j++)
		rows[0][j] = rows[1][j] = j;
	for (size_t i = 1; i <= a_length; i++) {
		size_t *before = rows[(i + 2) % 3], *last = rows[i % 3], *now = rows[(i + 1) % 3];
		now[0] = i;
		for (size_t j = 1; j <= b_length; j++) {
			now[j] = least(least(last[j], now[j - 1]) + 1, last[j - 1] + (a[i - 1] != b[j - 1]));
			if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
				now[j] = least(now[j], before[j - 2] + 1);
		}
	}
	return rows[(a_length + 1) % 3][b_length];
}

struct nearest nearest_begin(const char *word)
{
	return (struct nearest){.word = word, .changes = strlen(word) / 3 + 1};
}

void nearest_offer(struct nearest *nearest, const char *word)
{
	const size_t written = strlen(nearest->word), offered = strlen(word);
	if (written > LONGEST || offered > LONGEST)
		return;
	const size_t changes = changes_between(nearest->word, written, word, offered);
	const char *found = nearest->found, last = written > 0 ? nearest->word[written - 1] : '\0';
	const bool ends_alike = offered > 0 && word[offered - 1] == last && found != NULL && found[strlen(found) - 1] != last;
	if (changes > nearest->changes || (changes == nearest->changes && !ends_alike))
		return;
	nearest->changes = changes;
	nearest->found = word;
}

struct nearest_text nearest_ask(const struct nearest *nearest)
{
	struct nearest_text text = {.text = ""};
	if (nearest->found != NULL)
		snprintf(text.text, sizeof text.text, "; did you mean %s?", nearest->found);
	return text;
}
