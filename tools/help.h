/* What furrow prints about itself: --help, manual pages and completions of shells, all from the tables of the subcommands. */
#ifndef FURROW_TOOLS_HELP_H
#define FURROW_TOOLS_HELP_H

#include <stdio.h>

#include "command.h"

void help_overview(FILE *out); /* furrow --help */
void help_command(FILE *out, const struct command *command);

/* --- help_manual.c: source of a manual page in mdoc(7) --- */
void help_manual(FILE *out, const struct command *command); /* NULL: furrow(1) */

/* --- help_bash.c, help_zsh.c, help_fish.c: a script for the shell's completion --- */
void help_bash(FILE *out);
void help_zsh(FILE *out);
void help_fish(FILE *out);

/* --- help_keys.c: keys of scenes, which complete an option or an argument --- */
enum help_keys {
	HELP_NO_KEYS,
	HELP_SETTINGS, /* keys that --set takes without the name of an entry, as cache.slots */
	HELP_KEYS,     /* all keys, as objects.sink */
};
enum help_keys help_keys_of(const struct command_option *option);
/* Prints each key between `before` and `after`. */
void help_put_keys(FILE *out, enum help_keys keys, const char *before, const char *after);
/* Calls `put` for each setting whose values are words. */
typedef void (*help_values_fn)(FILE *out, const char *key, const char *const *words, size_t count);
void help_put_values(FILE *out, help_values_fn put);

/* What an option or an argument is, for a list of completions: the first part of its help. Returns its length. */
int help_brief(const struct command_option *option);

#endif
