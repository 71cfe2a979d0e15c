/* Completions of a scene's keys, from the table by which scenes are read: of --set KEY=VALUE, and of keys alone. */
#include <string.h>

#include "help.h"
#include "scene/scene_row.h"

enum help_keys help_keys_of(const struct command_option *option)
{
	if (option->value != NULL && strcmp(option->value, "KEY=VALUE") == 0)
		return HELP_SETTINGS;
	return option->value == NULL && strcmp(option->name, "KEY") == 0 ? HELP_KEYS : HELP_NO_KEYS;
}

struct words {
	FILE *out;
	const char *before, *after;
};

/* A key as people type it: without [] behind lists. */
static enum status put_key(void *user, const char *path, const struct scene_row *row)
{
	const struct words *words = user;
	fputs(words->before, words->out);
	for (const char *c = path; *c != '\0'; c++)
		if (*c != '[' && *c != ']')
			putc(*c, words->out);
	fputs(words->after, words->out);
	return STATUS_OK;
}

/* Keys in entries of lists are set by the entry's name, which no table knows. */
static enum status put_setting(void *user, const char *path, const struct scene_row *row)
{
	return strchr(path, '[') == NULL && (row->type != ROW_MAPPING || row->form != ROW_POINTER) ? put_key(user, path, row) : STATUS_OK;
}

void help_put_keys(FILE *out, enum help_keys keys, const char *before, const char *after)
{
	/* No visit fails. */
	(void)!scene_row_visit(keys == HELP_SETTINGS ? put_setting : put_key, &(struct words){out, before, after});
}

struct values {
	FILE *out;
	help_values_fn put;
};

static enum status put_values(void *user, const char *path, const struct scene_row *row)
{
	static const struct scene_word switches[] = {{"true", 1}, {"false", 0}, {NULL, 0}};
	const struct values *values = user;
	const struct scene_word *word = row->type == ROW_SWITCH ? switches : row->words;
	const char *words[24];
	size_t count = 0;
	if (word == NULL || strchr(path, '[') != NULL)
		return STATUS_OK;
	for (; word->word != NULL && count < sizeof words / sizeof *words; word++)
		words[count++] = word->word;
	values->put(values->out, path, words, count);
	return STATUS_OK;
}

void help_put_values(FILE *out, help_values_fn put)
{
	(void)!scene_row_visit(put_values, &(struct values){out, put});
}
