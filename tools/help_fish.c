/* A completion script for fish: a line for each option. */
#include <string.h>

#include "help.h"

static void put_text(FILE *out, const char *text, int length)
{
	putc('\'', out);
	for (int i = 0; i < length; i++) {
		if (text[i] == '\'' || text[i] == '\\')
			putc('\\', out);
		putc(text[i], out);
	}
	putc('\'', out);
}

static void put_begin(FILE *out, const struct command *command)
{
	fprintf(out, "complete -c furrow -n '__fish_seen_subcommand_from %s'", command->name);
}

static void put_files(FILE *out, const char *files)
{
	if (strcmp(files, "/") == 0) {
		fputs(" -a '(__fish_complete_directories)'", out);
	} else if (strcmp(files, "*") == 0) {
		fputs(" -F", out);
	} else {
		fputs(" -a '(", out);
		for (const char *at = files; *at != '\0'; at += strspn(at, " ")) {
			const int length = (int)strcspn(at, " ");
			fprintf(out, "%s__fish_complete_suffix .%.*s", at != files ? "; " : "", length, at);
			at += length;
		}
		fputs(")'", out);
	}
}

static void put_option(FILE *out, const struct command *command, const struct command_option *option)
{
	put_begin(out, command);
	fprintf(out, " -%c %s", option->name[1] == '\0' ? 's' : 'l', option->name);
	if (option->value != NULL)
		fputs(option->files != NULL && strcmp(option->files, "*") == 0 ? " -r" : " -x", out);
	if (help_keys_of(option) == HELP_SETTINGS) {
		fputs(" -a '(__furrow_settings)'", out);
	} else if (option->choices != NULL) {
		fputs(" -a '", out);
		for (const char *const *choice = option->choices; *choice != NULL; choice++)
			fprintf(out, "%s%s", choice != option->choices ? " " : "", *choice);
		putc('\'', out);
	} else if (option->files != NULL) {
		put_files(out, option->files);
	}
	fputs(" -d ", out);
	put_text(out, option->help, help_brief(option));
	putc('\n', out);
}

static void put_arguments(FILE *out, const struct command *command, const struct command_option *argument)
{
	for (; argument != NULL && argument->name != NULL; argument++)
		if (argument->files != NULL || help_keys_of(argument) == HELP_KEYS) {
			put_begin(out, command);
			if (argument->files != NULL)
				put_files(out, argument->files);
			else
				fputs(" -a '(__furrow_keys)'", out);
			fputs(" -d ", out);
			put_text(out, argument->name, (int)strlen(argument->name));
			putc('\n', out);
		}
}

static void put_setting(FILE *out, const char *key, const char *const *words, size_t count)
{
	for (size_t i = 0; i < count; i++)
		fprintf(out, " %s=%s", key, words[i]);
}

/* Functions that print what a setting may be, and keys. */
static void put_functions(FILE *out)
{
	fputs("function __furrow_settings\n    printf '%s\\n'", out);
	help_put_keys(out, HELP_SETTINGS, " ", "=");
	help_put_values(out, put_setting);
	fputs("\nend\nfunction __furrow_keys\n    printf '%s\\n'", out);
	help_put_keys(out, HELP_KEYS, " ", "");
	fputs("\nend\n", out);
}

void help_fish(FILE *out)
{
	const struct command *command;
	fputs("# Completion of furrow for fish. Made by furrow --print fish from the tables that --help prints.\n"
	      "complete -c furrow -f\n"
	      "complete -c furrow -n __fish_use_subcommand -l version -d 'tell the version'\n"
	      "complete -c furrow -n __fish_use_subcommand -l print -x -a 'bash zsh fish man' -d 'a script or page'\n"
	      "complete -c furrow -l help -d 'explain the command'\n", out);
	put_functions(out);
	for (size_t i = 0; (command = command_at(i)) != NULL; i++) {
		fprintf(out, "complete -c furrow -n __fish_use_subcommand -a %s -d ", command->name);
		put_text(out, command->summary, (int)strlen(command->summary));
		putc('\n', out);
	}
	for (size_t i = 0; (command = command_at(i)) != NULL; i++) {
		for (const struct command_option *option = command->options; option != NULL && option->name != NULL; option++)
			put_option(out, command, option);
		put_arguments(out, command, command->arguments);
		if (command->also != NULL) {
			put_begin(out, command);
			fprintf(out, " -a %s\n", command->also->name);
			put_arguments(out, command, command->also + 1);
		}
	}
}
