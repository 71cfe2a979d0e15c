/* Commands, and parts of commands, that the Python package does. */
#ifndef FURROW_TOOLS_PYTHON_H
#define FURROW_TOOLS_PYTHON_H

#include <stdio.h>

#include "command.h"

/* Becomes the package's command of that name, with all arguments and options that were given. Returns only if that fails.
 * FURROW_PYTHON names the interpreter; without it the one that furrow was built with is taken. STATUS_USAGE: an option that is needed was not given.
 * STATUS_FAILED: there is no interpreter, or no package. */
enum status python_command(const struct command *command, const struct arguments *arguments) FURROW_CHECKED;

/* Starts the package's module `name` with the words (ended by NULL) and `text` on its standard input, and waits for it. Copies what it prints to `output`;
 * NULL: drops it. Its notes are told. Returns its failure. *missing: set if it failed because Python or one of its packages is not installed. */
enum status python_ask(const char *name, const char *const *words, const char *text, FILE *output, bool *missing) FURROW_CHECKED;

struct cJSON;
/* Writes a plot as SVG to `file`, by python/furrow/plot.py. `what`: "rig" or "cache". `plan`: what is drawn; NULL counts as no memory. *missing: as python_ask. */
enum status python_draw(const char *what, struct cJSON *plan, FILE *file, bool *missing) FURROW_CHECKED;

#endif
