/* Commands whose work the Python package does. */
#ifndef FURROW_TOOLS_PYTHON_H
#define FURROW_TOOLS_PYTHON_H

#include "command.h"

/* Becomes the package's command of that name, with all arguments and options that were given. Returns only if that fails.
 * FURROW_PYTHON names the interpreter; without it the one that furrow was built with is taken. STATUS_USAGE: an option that is needed was not given.
 * STATUS_FAILED: there is no interpreter, or no package. */
enum status python_command(const struct command *command, const struct arguments *arguments) FURROW_CHECKED;

#endif
