/* A completion script for zsh: _arguments of each subcommand. */
#include <string.h>

#include "help.h"

/* Text within single quotes and, in _arguments, within brackets. */
static void put_text(FILE *out, const char *text, int length)
{
	for (int i = 0; i < length; i++) {
		if (text[i] == '\'')
			fputs("'\\'", out);
		else if (strchr("[]:\\", text[i]) != NULL)
			putc('\\', out);
		putc(text[i], out);
	}
}

static void put_string(FILE *out, const char *text)
{
	put_text(out, text, (int)strlen(text));
}

/* What completes a value: files, words, or nothing. */
static void put_action(FILE *out, const struct command_option *option)
{
	const enum help_keys keys = help_keys_of(option);
	if (keys == HELP_SETTINGS) {
		fputs("_furrow_settings", out);
	} else if (keys == HELP_KEYS) {
		putc('(', out);
		help_put_keys(out, HELP_KEYS, "", " ");
		putc(')', out);
	} else if (option->choices != NULL) {
		fputs(option->list ? "_values -s , word" : "(", out);
		for (const char *const *choice = option->choices; *choice != NULL; choice++)
			fprintf(out, "%s%s", option->list || choice != option->choices ? " " : "", *choice);
		fputs(option->list ? "" : ")", out);
	} else if (option->files != NULL && strcmp(option->files, "/") == 0) {
		fputs("_files -/", out);
	} else if (option->files != NULL && strcmp(option->files, "*") == 0) {
		fputs("_files", out);
	} else if (option->files != NULL) {
		fputs("_files -g \"*.(", out);
		for (const char *at = option->files; *at != '\0'; at++)
			putc(*at == ' ' ? '|' : *at, out);
		fputs(")\"", out);
	} else {
		putc(' ', out);
	}
}

/* Options that exclude each other are named before each. */
static void put_group(FILE *out, const struct command_option *option, size_t count)
{
	for (size_t i = 0; i < count; i++) {
		fputs("\t\t\t'", out);
		for (size_t k = 0; count > 1 && k < count; k++)
			fprintf(out, "%s%s%s%s", k > 0 ? " " : "(", command_dashes(&option[k]), option[k].name, k + 1 < count ? "" : ")");
		fprintf(out, "%s%s%s%s[", option[i].repeats ? "*" : "", command_dashes(&option[i]), option[i].name,
			option[i].value != NULL && option[i].name[1] != '\0' ? "=" : "");
		put_text(out, option[i].help, help_brief(&option[i]));
		putc(']', out);
		if (option[i].value != NULL) {
			putc(':', out);
			put_string(out, option[i].value);
			putc(':', out);
			put_action(out, &option[i]);
		}
		fputs("' \\\n", out);
	}
}

static void put_command(FILE *out, const struct command *command)
{
	size_t count;
	fprintf(out, "\t\t(%s)\n\t\t\t_arguments '--help[explain the command]' \\\n", command->name);
	for (const struct command_option *option = command->options; option != NULL && option->name != NULL; option += count) {
		count = command_group(option);
		put_group(out, option, count);
	}
	for (const struct command_option *argument = command->arguments; argument != NULL && argument->name != NULL; argument++) {
		fprintf(out, "\t\t\t'%s:", argument->repeats ? "*" : argument->needed ? "" : ":");
		put_string(out, argument->name);
		putc(':', out);
		if (command->also != NULL && argument == command->arguments) /* a file, or the word that begins the second form */
			fprintf(out, "_alternative words\\:form\\:\"(%s)\" files\\:file\\:\"_files\"", command->also->name);
		else
			put_action(out, argument);
		fputs("' \\\n", out);
	}
	if (command->also != NULL)
		for (const struct command_option *argument = command->also + 1; argument->name != NULL; argument++) {
			fputs("\t\t\t'::", out);
			put_string(out, argument->name);
			putc(':', out);
			put_action(out, argument);
			fputs("' \\\n", out);
		}
	fputs("\t\t\t&& return 0\n\t\t\t;;\n", out);
}

static void put_setting(FILE *out, const char *key, const char *const *words, size_t count)
{
	fprintf(out, "\t\t(*%s=) compadd --", key);
	for (size_t i = 0; i < count; i++)
		fprintf(out, " %s", words[i]);
	fputs(" ;;\n", out);
}

void help_zsh(FILE *out)
{
	const struct command *command;
	fputs("#compdef furrow\n# Completion of furrow for zsh. Made by furrow --print zsh from the tables that --help prints.\n\n"
	      "_furrow_settings()\n{\n\tif compset -P '*='; then\n\t\tcase $IPREFIX in\n", out);
	help_put_values(out, put_setting);
	fputs("\t\tesac\n\telse\n\t\tcompadd -S '' --", out);
	help_put_keys(out, HELP_SETTINGS, " ", "=");
	fputs("\n\tfi\n}\n\n"
	      "_furrow()\n{\n\tlocal state line\n\tlocal -a commands\n\tcommands=(\n", out);
	for (size_t i = 0; (command = command_at(i)) != NULL; i++) {
		fprintf(out, "\t\t'%s:", command->name);
		put_string(out, command->summary);
		fputs("'\n", out);
	}
	fputs("\t)\n\t_arguments -C '--help[what there is]' '--version[tell the version]' '--print[a script or page]:KIND:(bash zsh fish man)' \\\n"
	      "\t\t'1:command:->command' '*::argument:->argument' && return 0\n"
	      "\tcase $state in\n\t(command) _describe command commands ;;\n\t(argument)\n\t\tcase $line[1] in\n", out);
	for (size_t i = 0; (command = command_at(i)) != NULL; i++)
		put_command(out, command);
	fputs("\t\tesac\n\t\t;;\n\tesac\n}\n\n_furrow \"$@\"\n", out);
}
