/* A completion script for bash. It needs bash 4 and nothing else. */
#include <string.h>

#include "help.h"

static const char head[] =
	"# Files with one of these endings, and folders. \"*\": all files; \"/\": folders alone.\n"
	"_furrow_files()\n"
	"{\n"
	"\tlocal ending\n"
	"\tlocal IFS=$'\\n'\n"
	"\tcompopt -o filenames 2>/dev/null\n"
	"\tCOMPREPLY+=($(compgen -d -- \"$word\"))\n"
	"\tfor ending; do\n"
	"\t\tcase $ending in\n"
	"\t\t/) ;;\n"
	"\t\t'*') COMPREPLY=($(compgen -f -- \"$word\")) ;;\n"
	"\t\t*) COMPREPLY+=($(compgen -f -X \"!*.$ending\" -- \"$word\")) ;;\n"
	"\t\tesac\n"
	"\tdone\n"
	"}\n"
	"\n"
	"_furrow_words()\n"
	"{\n"
	"\tCOMPREPLY+=($(compgen -W \"$*\" -- \"$word\"))\n"
	"}\n"
	"\n"
	"# Of a list that commas part, the last word.\n"
	"_furrow_list()\n"
	"{\n"
	"\tlocal before=\n"
	"\t[[ $word == *,* ]] && before=${word%,*},\n"
	"\tcompopt -o nospace 2>/dev/null\n"
	"\tCOMPREPLY+=($(compgen -P \"$before\" -W \"$*\" -- \"${word##*,}\"))\n"
	"}\n"
	"\n"
	"_furrow_settings()\n"
	"{\n"
	"\tcompopt -o nospace 2>/dev/null\n"
	"\t_furrow_words $_furrow_setting_keys\n"
	"}\n"
	"\n"
	"_furrow()\n"
	"{\n"
	"\tlocal word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command=${COMP_WORDS[1]}\n"
	"\t# bash parts --option=value at the equals sign\n"
	"\tif [[ $word == = ]]; then\n"
	"\t\tword=\n"
	"\telif [[ $before == = ]]; then\n"
	"\t\tbefore=${COMP_WORDS[COMP_CWORD-2]}\n"
	"\tfi\n"
	"\tCOMPREPLY=()\n";

static void put_words(FILE *out, const struct command_option *option)
{
	fputs(option->list ? "_furrow_list" : "_furrow_words", out);
	for (const char *const *choice = option->choices; *choice != NULL; choice++)
		fprintf(out, " %s", *choice);
}

static void put_files(FILE *out, const char *files)
{
	if (strcmp(files, "*") == 0)
		fputs("_furrow_files '*'", out);
	else
		fprintf(out, "_furrow_files %s", files);
}

static void put_values(FILE *out, const struct command *command)
{
	for (const struct command_option *option = command->options; option != NULL && option->name != NULL; option++) {
		if (option->value == NULL)
			continue;
		fprintf(out, "\t'%s %s%s') ", command->name, command_dashes(option), option->name);
		const bool keys = help_keys_of(option) == HELP_SETTINGS;
		if (keys)
			fputs("_furrow_settings", out);
		else if (option->choices != NULL)
			put_words(out, option);
		else if (option->files != NULL)
			put_files(out, option->files);
		fputs(keys || option->choices != NULL || option->files != NULL ? "; return ;;\n" : "return ;;\n", out);
	}
}

/* Words after KEY= of a setting; `before` is its key. */
static void put_setting(FILE *out, const char *key, const char *const *words, size_t count)
{
	fprintf(out, "\t*' %s') _furrow_words", key);
	for (size_t i = 0; i < count; i++)
		fprintf(out, " %s", words[i]);
	fputs("; return ;;\n", out);
}

static void put_arguments(FILE *out, const struct command_option *argument)
{
	for (; argument != NULL && argument->name != NULL; argument++)
		if (help_keys_of(argument) == HELP_KEYS) {
			fputs("\t\t_furrow_words", out);
			help_put_keys(out, HELP_KEYS, " ", "");
			putc('\n', out);
		} else if (argument->files != NULL) {
			fputs("\t\t", out);
			put_files(out, argument->files);
			putc('\n', out);
		}
}

static void put_command(FILE *out, const struct command *command)
{
	fprintf(out, "\t%s)\n\t\tif [[ $word == -* ]]; then\n\t\t\t_furrow_words --help", command->name);
	for (const struct command_option *option = command->options; option != NULL && option->name != NULL; option++)
		fprintf(out, " %s%s", command_dashes(option), option->name);
	fputs("\n\t\t\treturn\n\t\tfi\n", out);
	put_arguments(out, command->arguments);
	if (command->also != NULL) {
		fprintf(out, "\t\t((COMP_CWORD == 2)) && _furrow_words %s\n", command->also->name);
		put_arguments(out, command->also + 1);
	}
	fputs("\t\t;;\n", out);
}

void help_bash(FILE *out)
{
	const struct command *command;
	fputs("# Completion of furrow for bash. Made by furrow --print bash from the tables that --help prints.\n\n_furrow_setting_keys='", out);
	help_put_keys(out, HELP_SETTINGS, "", "= ");
	fprintf(out, "'\n\n%s\tif ((COMP_CWORD == 1)); then\n\t\t_furrow_words --help --version --print", head);
	for (size_t i = 0; (command = command_at(i)) != NULL; i++)
		fprintf(out, " %s", command->name);
	fputs("\n\t\treturn\n\tfi\n\tcase \"$command $before\" in\n\t'--print --print') _furrow_words bash zsh fish man; return ;;\n", out);
	for (size_t i = 0; (command = command_at(i)) != NULL; i++)
		put_values(out, command);
	help_put_values(out, put_setting);
	fputs("\tesac\n\tcase $command in\n", out);
	for (size_t i = 0; (command = command_at(i)) != NULL; i++)
		put_command(out, command);
	fputs("\tesac\n}\n\ncomplete -F _furrow furrow\n", out);
}
