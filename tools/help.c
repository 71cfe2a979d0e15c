/* Prints --help of furrow and of each subcommand, in lines of the terminal's width. */
#include "help.h"

#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "fill.h"

enum { WIDTH = 80, WIDTH_MOST = 120, TEXT_AT = 26 };

static int width_of(FILE *out)
{
	struct winsize size;
	if (!isatty(fileno(out)) || ioctl(fileno(out), TIOCGWINSZ, &size) != 0 || size.ws_col < WIDTH)
		return WIDTH;
	return size.ws_col < WIDTH_MOST ? size.ws_col : WIDTH_MOST;
}

int help_brief(const struct command_option *option)
{
	return (int)strcspn(option->help, ";:");
}

void help_overview(FILE *out)
{
	const struct command *command;
	const int width = width_of(out);
	fprintf(out, "furrow " FURROW_VERSION ": %s\n\nusage: furrow COMMAND ...        furrow COMMAND --help explains it\n\n", command_about);
	for (size_t i = 0; (command = command_at(i)) != NULL; i++) {
		struct fill fill = {.out = out, .width = width, .indent = 12, .column = 12};
		fprintf(out, "  %-10s", command->name);
		fill_words(&fill, command->summary);
		fill_end(&fill);
	}
	fputs("\nfurrow --version      the version, and that of MuJoCo\n"
	      "furrow --print KIND   a completion script (bash, zsh, fish), or a manual page\n"
	      "                      (man, man COMMAND)\n\nexit status:\n", out);
	fill_blocks(out, width, command_statuses);
}

/* --- usage --- */

static size_t put_option(char *token, size_t room, size_t used, const struct command_option *option)
{
	if (used < room)
		used += (size_t)snprintf(token + used, room - used, "%s%s%s%s", command_dashes(option), option->name,
					 option->value != NULL ? " " : "", option->value != NULL ? option->value : "");
	return used;
}

/* An option with those in its place, as in "[--slip LIST | --torque LIST]". */
static void fill_group(struct fill *fill, const struct command_option *option, size_t count)
{
	const bool round = option->needed && count > 1, square = !option->needed;
	for (size_t i = 0; i < count; i++) {
		char token[80];
		const bool last = i + 1 == count;
		size_t used = (size_t)snprintf(token, sizeof token, "%s", i > 0 ? "| " : square ? "[" : round ? "(" : "");
		used = put_option(token, sizeof token, used, &option[i]);
		if (last && used < sizeof token)
			snprintf(token + used, sizeof token - used, "%s%s", square ? "]" : round ? ")" : "", option->repeats ? "..." : "");
		fill_word(fill, token, strlen(token));
	}
}

static void fill_arguments(struct fill *fill, const struct command_option *argument)
{
	for (; argument != NULL && argument->name != NULL; argument++) {
		char token[64];
		snprintf(token, sizeof token, argument->needed ? "%s%s" : "[%s]%s", argument->name, argument->repeats ? "..." : "");
		fill_word(fill, token, strlen(token));
	}
}

/* Needed options come first, whatever their order in the table. */
static void fill_options(struct fill *fill, const struct command_option *options, bool needed)
{
	size_t count;
	for (; options != NULL && options->name != NULL; options += count) {
		count = command_group(options);
		if (options->needed == needed)
			fill_group(fill, options, count);
	}
}

static void print_usage(FILE *out, int width, const struct command *command)
{
	const int indent = (int)strlen("usage: furrow  ") + (int)strlen(command->name);
	struct fill fill = {.out = out, .width = width, .indent = indent, .column = indent};
	fprintf(out, "usage: furrow %s ", command->name);
	fill_arguments(&fill, command->arguments);
	fill_options(&fill, command->options, true);
	fill_options(&fill, command->options, false);
	fill_end(&fill);
	if (command->also == NULL)
		return;
	fprintf(out, "       furrow %s ", command->name);
	fill_arguments(&fill, command->also);
	fill_end(&fill);
}

/* --- a row each --- */

static void print_row(FILE *out, int width, const char *left, const struct command_option *row)
{
	char notes[256];
	struct fill fill = {.out = out, .width = width, .indent = TEXT_AT, .column = TEXT_AT};
	if (strlen(left) + 3 > TEXT_AT)
		fprintf(out, "  %s\n%*s", left, TEXT_AT, "");
	else
		fprintf(out, "  %-*s", TEXT_AT - 2, left);
	fill_words(&fill, row->help);
	command_notes(row, notes, sizeof notes);
	fill_words(&fill, notes);
	fill_end(&fill);
}

static void print_arguments(FILE *out, int width, const struct command_option *arguments)
{
	if (arguments != NULL)
		fputs("\narguments:\n", out);
	for (; arguments != NULL && arguments->name != NULL; arguments++)
		print_row(out, width, arguments->name, arguments);
}

static void print_options(FILE *out, int width, const struct command_option *options)
{
	if (options != NULL)
		fputs("\noptions:\n", out);
	for (; options != NULL && options->name != NULL; options++) {
		char left[64];
		put_option(left, sizeof left, 0, options);
		print_row(out, width, left, options);
	}
}

static void print_examples(FILE *out, const char *line)
{
	while (*line != '\0') {
		const size_t length = strcspn(line, "\n");
		fputs("  ", out);
		fwrite(line, 1, length, out);
		putc('\n', out);
		line += length + 1;
	}
}

void help_command(FILE *out, const struct command *command)
{
	const int width = width_of(out);
	struct fill fill = {.out = out, .width = width};
	fill_words(&fill, "furrow");
	fill_words(&fill, command->name);
	fill_words(&fill, "-");
	fill_words(&fill, command->summary);
	fill_end(&fill);
	putc('\n', out);
	print_usage(out, width, command);
	print_arguments(out, width, command->arguments);
	print_options(out, width, command->options);
	if (command->details != NULL) {
		putc('\n', out);
		fill_blocks(out, width, command->details);
	}
	if (command->examples != NULL) {
		fputs("\nexamples:\n", out);
		print_examples(out, command->examples);
	}
	if (command->see != NULL)
		fprintf(out, "\nsee also: %s\n", command->see);
}
