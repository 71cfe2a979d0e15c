/* Finds the Python package of this command, and an interpreter for it. */
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "python.h"
#include "python_places.h"

#define FEW 64 /* words of a command */

struct words {
	const char *list[FEW];
	char dashed[FEW][32];
	size_t count;
};

static enum status add(struct words *words, const char *word)
{
	if (words->count + 1 == FEW)
		return fail_with(STATUS_USAGE, "%s: too many arguments; give fewer", word);
	words->list[words->count++] = word;
	return STATUS_OK;
}

static enum status add_option(struct words *words, const struct command_option *option, const struct arguments *arguments)
{
	char *dashed = words->dashed[words->count];
	snprintf(dashed, sizeof words->dashed[0], "%s%s", command_dashes(option), option->name);
	if (option->value == NULL)
		return arguments_flag(arguments, option->name) ? add(words, dashed) : STATUS_OK;
	const char *value = arguments_text(arguments, option->name);
	if (value == NULL)
		return STATUS_OK;
	TRY(add(words, dashed));
	return add(words, value);
}

static bool has_package(const char *folder)
{
	char file[PATH_MAX + 32];
	snprintf(file, sizeof file, "%s/furrow/_start.py", folder);
	return access(file, R_OK) == 0;
}

/* Finds the folder that has the package: of a wheel, of the build that this program lies in, or the installed one. */
static enum status find_package(char folder[PATH_MAX])
{
	char program[PATH_MAX];
	const ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
	program[length > 0 ? length : 0] = '\0';
	for (int up = 0; up < 2; up++) { /* a wheel has the program in the package */
		char *slash = strrchr(program, '/');
		if (slash != NULL)
			*slash = '\0';
	}
	if (has_package(program))
		snprintf(folder, PATH_MAX, "%s", program);
	else if (strcmp(program, PYTHON_BUILD) == 0)
		snprintf(folder, PATH_MAX, "%s", PYTHON_BUILD "/python");
	else
		snprintf(folder, PATH_MAX, "%s", PYTHON_INSTALLED);
	return has_package(folder) ? STATUS_OK : fail_with(STATUS_FAILED, "%s: the Python package furrow is not there; install it (docs/INSTALL.md)", folder);
}

static enum status check_needed(const struct command *command, const struct arguments *arguments)
{
	for (const struct command_option *option = command->options; option->name != NULL; option++)
		if (option->needed && arguments_text(arguments, option->name) == NULL)
			return fail_with(STATUS_USAGE, "%s: %s%s is missing; give %s: %s", command->name, command_dashes(option), option->name, option->value, option->help);
	return STATUS_OK;
}

enum status python_command(const struct command *command, const struct arguments *arguments)
{
	struct words words = {.count = 0};
	char folder[PATH_MAX], start[PATH_MAX + 32];
	const char *python = getenv("FURROW_PYTHON");
	TRY(check_needed(command, arguments));
	TRY(find_package(folder));
	if (python == NULL || python[0] == '\0')
		python = PYTHON_FOUND;
	snprintf(start, sizeof start, "%s/furrow/_start.py", folder);
	TRY(add(&words, python));
	TRY(add(&words, start));
	TRY(add(&words, command->name));
	for (const struct command_option *option = command->options; option->name != NULL; option++)
		TRY(add_option(&words, option, arguments));
	TRY(add(&words, "--"));
	for (size_t i = 0; i < arguments_count(arguments); i++)
		TRY(add(&words, arguments_at(arguments, i)));
	if (strcmp(folder, PYTHON_BUILD "/python") == 0)
		setenv("FURROW_LIBRARY", PYTHON_BUILD "/src/libfurrow.so.0", 0);
	fflush(NULL);
	execvp(python, (char *const *)words.list);
	return fail_with(STATUS_FAILED, "%s: %s; name a Python 3 in FURROW_PYTHON", python, strerror(errno));
}
