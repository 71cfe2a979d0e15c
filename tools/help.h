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

/* What an option or an argument is, for a list of completions: the first part of its help. Returns its length. */
int help_brief(const struct command_option *option);

#endif
