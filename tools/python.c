/* Finds the Python package of this command, and an interpreter for it. Becomes the package's command, or starts it and waits for it. */
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/json.h"
#include "python.h"
#include "python_places.h"

#define FEW 64 /* words of a command */
#define PYTHON_MISSING 127 /* the exit status where a package or the interpreter is not there */

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

/* Finds the folder that has the package: of a wheel, of the build that this program lies in, or the installed one. What is started may call this program: FURROW_PROGRAM. */
static enum status find_package(char folder[PATH_MAX])
{
	char program[PATH_MAX];
	const ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
	program[length > 0 ? length : 0] = '\0';
	if (length > 0)
		setenv("FURROW_PROGRAM", program, 0);
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

/* Finds the interpreter and the package, and begins the words of a command line with them. */
static enum status begin_words(struct words *words, const char *name, char start[PATH_MAX + 32])
{
	char folder[PATH_MAX];
	const char *python = getenv("FURROW_PYTHON");
	TRY(find_package(folder));
	if (python == NULL || python[0] == '\0')
		python = PYTHON_FOUND;
	snprintf(start, PATH_MAX + 32, "%s/furrow/_start.py", folder);
	if (strcmp(folder, PYTHON_BUILD "/python") == 0)
		setenv("FURROW_LIBRARY", PYTHON_BUILD "/src/libfurrow.so.0", 0);
	TRY(add(words, python));
	TRY(add(words, start));
	return add(words, name);
}

enum status python_command(const struct command *command, const struct arguments *arguments)
{
	struct words words = {.count = 0};
	char start[PATH_MAX + 32];
	TRY(check_needed(command, arguments));
	TRY(begin_words(&words, command->name, start));
	for (const struct command_option *option = command->options; option->name != NULL; option++)
		TRY(add_option(&words, option, arguments));
	TRY(add(&words, "--"));
	for (size_t i = 0; i < arguments_count(arguments); i++)
		TRY(add(&words, arguments_at(arguments, i)));
	fflush(NULL);
	execvp(words.list[0], (char *const *)words.list);
	return fail_with(STATUS_FAILED, "%s: %s; name a Python 3 in FURROW_PYTHON", words.list[0], strerror(errno));
}

/* --- a part of a command --- */

/* In the child: never returns. */
static void become_python(const struct words *words, FILE *const files[3])
{
	for (int i = 0; i < 3; i++)
		if (dup2(fileno(files[i]), i) < 0)
			_exit(1);
	execvp(words->list[0], (char *const *)words->list);
	dprintf(STDERR_FILENO, "furrow: %s: %s; name a Python 3 in FURROW_PYTHON\n", words->list[0], strerror(errno));
	_exit(PYTHON_MISSING);
}

/* Passes on what Python told: notes as notes, the last error as this thread's failure, and all else as it is. */
static enum status pass_on(FILE *errors, enum status status)
{
	static const char tells[] = "furrow: ", notes[] = "furrow: note: ";
	char *line = NULL, *error = NULL;
	size_t size = 0;
	rewind(errors);
	while (getline(&line, &size, errors) >= 0) {
		line[strcspn(line, "\n")] = '\0';
		if (strncmp(line, notes, sizeof notes - 1) == 0) {
			note("%s", line + sizeof notes - 1);
		} else if (strncmp(line, tells, sizeof tells - 1) == 0) {
			free(error);
			error = strdup(line + sizeof tells - 1);
		} else {
			fprintf(stderr, "%s\n", line);
		}
	}
	if (status != STATUS_OK)
		status = fail_with(status, "%s", error != NULL ? error : "Python: ended without telling why; look at the lines above");
	free(line);
	free(error);
	return status;
}

static enum status copy_output(FILE *from, FILE *to)
{
	char bytes[16384];
	size_t length;
	rewind(from);
	while ((length = fread(bytes, 1, sizeof bytes, from)) > 0)
		if (fwrite(bytes, 1, length, to) != length)
			break; /* the file's owner looks for its errors */
	return ferror(from) ? fail_with(STATUS_FAILED, "what Python wrote: %s; check the disk of TMPDIR", strerror(errno)) : STATUS_OK;
}

static enum status run_and_wait(const struct words *words, FILE *const files[3], bool *missing)
{
	int ended = 0;
	fflush(NULL);
	const pid_t pid = fork();
	if (pid == 0)
		become_python(words, files);
	if (pid < 0)
		return fail_with(STATUS_FAILED, "fork: %s; end other programs", strerror(errno));
	while (waitpid(pid, &ended, 0) < 0 && errno == EINTR)
		;
	const int code = WIFEXITED(ended) ? WEXITSTATUS(ended) : 1;
	*missing = code == PYTHON_MISSING;
	return pass_on(files[2], code == 0 ? STATUS_OK : code == 3 ? STATUS_INPUT : code == 130 ? STATUS_INTERRUPTED : STATUS_FAILED);
}

enum status python_ask(const char *name, const char *const *given, const char *text, FILE *output, bool *missing)
{
	struct words words = {.count = 0};
	char start[PATH_MAX + 32];
	FILE *files[3] = {NULL, NULL, NULL};
	enum status status = STATUS_OK;
	*missing = true; /* the package itself */
	TRY(begin_words(&words, name, start));
	*missing = false;
	for (; *given != NULL; given++)
		TRY(add(&words, *given));
	for (int i = 0; i < 3 && status == STATUS_OK; i++)
		if ((files[i] = tmpfile()) == NULL)
			status = fail_with(STATUS_FAILED, "a temporary file: %s; name a folder that can be written in TMPDIR", strerror(errno));
	if (status == STATUS_OK && (fputs(text, files[0]) < 0 || fflush(files[0]) != 0))
		status = fail_with(STATUS_FAILED, "a temporary file: %s; make room on its disk", strerror(errno));
	if (status == STATUS_OK) {
		rewind(files[0]);
		status = run_and_wait(&words, files, missing);
	}
	if (status == STATUS_OK && output != NULL)
		status = copy_output(files[1], output);
	for (int i = 0; i < 3; i++)
		if (files[i] != NULL)
			fclose(files[i]);
	return status;
}

enum status python_draw(const char *what, struct cJSON *plan, FILE *file, bool *missing)
{
	char *text = plan != NULL ? json_text(plan) : NULL;
	*missing = false;
	TRY_MEM(text, "a plot");
	const enum status status = python_ask("plot", (const char *const[]){what, NULL}, text, file, missing);
	cJSON_free(text);
	return status;
}
