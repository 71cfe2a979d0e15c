/* Parses a command's arguments against its table of options. */
#include "base/nearest.h"
#include "command.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct given {
	const struct command_option *option;
	const char *value;
};

struct arguments {
	const struct command *command;
	const char **positional;
	size_t positional_count;
	struct given *given;
	size_t given_count;
};

bool parse_number_or_infinity(const char *text, double *value)
{
	char *end;
	double number = strtod(text, &end);
	if (end == text || *end != '\0' || isnan(number))
		return false;
	*value = number;
	return true;
}

bool parse_number(const char *text, double *value)
{
	double number;
	if (!parse_number_or_infinity(text, &number) || !isfinite(number))
		return false;
	*value = number;
	return true;
}

static const struct command_option *find_option(const struct command *command, const char *name,
						size_t length)
{
	for (const struct command_option *option = command->options; option != NULL && option->name != NULL; option++)
		if (strlen(option->name) == length && strncmp(option->name, name, length) == 0)
			return option;
	return NULL;
}

static enum status unknown_option(const struct command *command, const char *token, const char *name, size_t length)
{
	char word[48], dashed[64] = "";
	snprintf(word, sizeof word, "%.*s", (int)length, name);
	struct nearest nearest = nearest_begin(word);
	for (const struct command_option *option = command->options; option != NULL && option->name != NULL; option++)
		nearest_offer(&nearest, option->name);
	if (nearest.found != NULL)
		snprintf(dashed, sizeof dashed, "; did you mean %s%s?", nearest.found[1] == '\0' ? "-" : "--", nearest.found);
	return fail_with(STATUS_USAGE, "%s: %.*s is not an option; see furrow %s --help%s", command->name, (int)(length + (size_t)(name - token)), token,
			 command->name, dashed);
}

static enum status take_option(struct arguments *arguments, const char *token, int argc, char **argv, int *at)
{
	const struct command *command = arguments->command;
	const char *name = token + 1 + (token[1] == '-');
	const char *equals = strchr(name, '=');
	size_t length = equals != NULL ? (size_t)(equals - name) : strlen(name);
	const struct command_option *option = find_option(command, name, length);
	if (option == NULL)
		return unknown_option(command, token, name, length);
	const char *value = equals != NULL ? equals + 1 : NULL;
	if (option->value == NULL && value != NULL)
		return fail_with(STATUS_USAGE, "%s: %s takes no value; leave it out", command->name, token);
	if (option->value != NULL && value == NULL) {
		double number;
		const char *next = *at + 1 < argc ? argv[*at + 1] : NULL;
		bool option_next = next != NULL && next[0] == '-' &&
				   (next[1] == '-' || (next[1] >= 'a' && next[1] <= 'z')) &&
				   !parse_number_or_infinity(next, &number);
		if (next == NULL || option_next)
			return fail_with(STATUS_USAGE, "%s: %s needs a value; give %s", command->name, token,
					 option->value);
		value = argv[++*at];
	}
	if (option->files != NULL && value[0] == '\0') /* as of a variable of a shell that is not set */
		return fail_with(STATUS_USAGE, "%s: %s is empty; give %s", command->name, token, option->value);
	arguments->given[arguments->given_count++] = (struct given){option, value};
	return STATUS_OK;
}

/* Positional arguments that a form of the command needs and may have. */
static bool may_have(const struct command_option *form, size_t count, size_t *least)
{
	size_t most = 0;
	*least = 0;
	for (; form != NULL && form->name != NULL; form++) {
		*least += form->needed;
		most = form->repeats ? SIZE_MAX : most + 1;
	}
	return count >= *least && count <= most;
}

/* The arguments and options that a command needs, for a message. */
static void tell_usage(const struct command *command, char *text, size_t room)
{
	size_t used = (size_t)snprintf(text, room, "furrow %s", command->name);
	bool more = false;
	for (const struct command_option *form = command->arguments; form != NULL && form->name != NULL && used < room; form++)
		used += (size_t)snprintf(text + used, room - used, form->needed ? " %s%s" : " [%s]%s", form->name, form->repeats ? "..." : "");
	for (const struct command_option *option = command->options; option != NULL && option->name != NULL && used < room; option++)
		if (option->needed)
			used += (size_t)snprintf(text + used, room - used, " %s%s %s", command_dashes(option), option->name, option->value);
		else
			more = true;
	if (more && used < room)
		(void)snprintf(text + used, room - used, " [options]");
}

static enum status check_count(const struct arguments *arguments)
{
	const struct command *command = arguments->command;
	const size_t count = arguments->positional_count;
	size_t least, ignored;
	const bool also = command->also != NULL && count > 0 && strcmp(arguments->positional[0], command->also->name) == 0;
	char usage[256];
	tell_usage(command, usage, sizeof usage);
	for (size_t i = 0; i < count; i++)
		if (arguments->positional[i][0] == '\0')
			return fail_with(STATUS_USAGE, "%s: an argument is empty; usage: %s", command->name, usage);
	if (may_have(command->arguments, count, &least) || (also && may_have(command->also, count, &ignored)))
		return STATUS_OK;
	if (count < least)
		return fail_with(STATUS_USAGE, "%s: something is missing; usage: %s", command->name, usage);
	return fail_with(STATUS_USAGE, "%s: %s is one argument too many; usage: %s", command->name, arguments->positional[count - 1], usage);
}

enum status arguments_parse(const struct command *command, int argc, char **argv, struct arguments **out)
{
	struct arguments *arguments = mem_calloc(1, sizeof *arguments);
	TRY_MEM(arguments, "arguments");
	arguments->command = command;
	arguments->positional = mem_calloc((size_t)argc + 1, sizeof *arguments->positional);
	arguments->given = mem_calloc((size_t)argc + 1, sizeof *arguments->given);
	enum status status;
	if (arguments->positional == NULL || arguments->given == NULL)
		TRY_OR(failed, fail_memory("arguments"));
	bool only_values = false;
	for (int i = 0; i < argc; i++) {
		double number;
		if (!only_values && strcmp(argv[i], "--") == 0)
			only_values = true;
		else if (only_values || argv[i][0] != '-' || argv[i][1] == '\0' || parse_number(argv[i], &number))
			arguments->positional[arguments->positional_count++] = argv[i];
		else
			TRY_OR(failed, take_option(arguments, argv[i], argc, argv, &i));
	}
	TRY_OR(failed, check_count(arguments));
	*out = arguments;
	return STATUS_OK;
failed:
	arguments_destroy(arguments);
	return status;
}

void arguments_destroy(struct arguments *arguments)
{
	if (arguments == NULL)
		return;
	mem_free_all(arguments->positional, arguments->given, arguments);
}

size_t arguments_count(const struct arguments *arguments)
{
	return arguments->positional_count;
}

const char *arguments_at(const struct arguments *arguments, size_t index)
{
	return index < arguments->positional_count ? arguments->positional[index] : NULL;
}

const char *arguments_nth(const struct arguments *arguments, const char *option, size_t nth)
{
	for (size_t i = 0; i < arguments->given_count; i++)
		if (strcmp(arguments->given[i].option->name, option) == 0 && nth-- == 0)
			return arguments->given[i].value != NULL ? arguments->given[i].value : "";
	return NULL;
}

bool arguments_flag(const struct arguments *arguments, const char *option)
{
	return arguments_nth(arguments, option, 0) != NULL;
}

const char *arguments_text(const struct arguments *arguments, const char *option)
{
	const char *last = NULL, *value;
	for (size_t nth = 0; (value = arguments_nth(arguments, option, nth)) != NULL; nth++)
		last = value;
	return last;
}

static enum status bad_value(const struct arguments *arguments, const char *option, const char *text,
			     const char *allowed)
{
	return fail_with(STATUS_USAGE, "%s: %s%s %s: not a value it takes; give %s",
			 arguments->command->name, option[1] == '\0' ? "-" : "--", option, text, allowed);
}

enum status arguments_number(const struct arguments *arguments, const char *option, double low,
			     double high, double *value)
{
	const char *text = arguments_text(arguments, option);
	if (text == NULL)
		return STATUS_OK;
	double number;
	if (!parse_number(text, &number) || number < low || number > high) {
		char allowed[96];
		snprintf(allowed, sizeof allowed, "a number from %g to %g", low, high);
		return bad_value(arguments, option, text, allowed);
	}
	*value = number;
	return STATUS_OK;
}

enum status arguments_integer(const struct arguments *arguments, const char *option, int64_t low,
			      int64_t high, int64_t *value)
{
	const char *text = arguments_text(arguments, option);
	if (text == NULL)
		return STATUS_OK;
	char *end;
	errno = 0;
	long long number = strtoll(text, &end, 10);
	if (end == text || *end != '\0' || errno != 0 || number < low || number > high) {
		char allowed[96];
		snprintf(allowed, sizeof allowed, "a whole number from %lld to %lld", (long long)low,
			 (long long)high);
		return bad_value(arguments, option, text, allowed);
	}
	*value = number;
	return STATUS_OK;
}

enum status arguments_numbers(const struct arguments *arguments, const char *option, size_t count,
			      double *values, bool *given)
{
	const char *text = arguments_text(arguments, option);
	*given = text != NULL;
	if (text == NULL)
		return STATUS_OK;
	const char *at = text;
	for (size_t i = 0; i < count; i++) {
		char *end;
		values[i] = strtod(at, &end);
		if (end == at || !isfinite(values[i]) || *end != (i + 1 < count ? ',' : '\0')) {
			char allowed[96];
			snprintf(allowed, sizeof allowed, "%zu numbers parted by commas", count);
			return bad_value(arguments, option, text, allowed);
		}
		at = end + 1;
	}
	return STATUS_OK;
}

enum status arguments_choice(const struct arguments *arguments, const char *option, int *value)
{
	const char *text = arguments_text(arguments, option);
	if (text == NULL)
		return STATUS_OK;
	const char *const *names = find_option(arguments->command, option, strlen(option))->choices;
	char allowed[160] = "one of";
	for (int i = 0; names[i] != NULL; i++) {
		if (strcmp(names[i], text) == 0) {
			*value = i;
			return STATUS_OK;
		}
		size_t used = strlen(allowed);
		snprintf(allowed + used, sizeof allowed - used, " %s", names[i]);
	}
	return bad_value(arguments, option, text, allowed);
}
