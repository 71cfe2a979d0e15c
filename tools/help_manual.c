/* Manual pages of furrow and of its subcommands: the tables as mdoc(7), which groff and mandoc read. */
#include <ctype.h>
#include <string.h>

#include "fill.h"
#include "help.h"

enum { SOURCE_WIDTH = 60 }; /* letters of a line of source; escapes come on top */

/* --- text --- */

/* A character of text. In kept lines all are as they are typed; elsewhere dashes that begin a word are. */
static void put_letter(FILE *out, char letter, bool typed)
{
	switch (letter) {
	case '\\':
		fputs("\\e", out);
		break;
	case '-':
		fputs(typed ? "\\-" : "-", out);
		break;
	case '`':
		fputs("\\(ga", out);
		break;
	case '^':
		fputs("\\(ha", out);
		break;
	case '~':
		fputs("\\(ti", out);
		break;
	case '\'':
		fputs(typed ? "\\(aq" : "'", out);
		break;
	case '"':
		fputs("\\(dq", out);
		break;
	default:
		putc(letter, out);
	}
}

/* A file, a key or an option: it has a letter on both sides of one of "_./", or begins with a dash. */
static bool is_name(const char *word, size_t length)
{
	for (size_t i = 1; i + 1 < length; i++)
		if (strchr("_./", word[i]) != NULL && isalnum((unsigned char)word[i - 1]) && isalnum((unsigned char)word[i + 1]))
			return true;
	return word[0] == '-';
}

/* A word of text, or of a macro's arguments, where names of macros would be called. */
static void put_word(FILE *out, const char *word, size_t length)
{
	bool typed = word[0] == '-';
	if (word[0] == '.' || word[0] == '\'' || (length <= 2 && isupper((unsigned char)word[0])) || strchr(".,:;()[]?!|", word[0]) != NULL)
		fputs("\\&", out);
	if (is_name(word, length))
		fputs("\\%", out); /* is not hyphenated */
	for (size_t i = 0; i < length; i++) {
		put_letter(out, word[i], typed);
		typed = word[i] == '-' || (typed && isalnum((unsigned char)word[i]));
	}
}

/* Running text: each sentence begins a line, and lines are short. */
static void put_text(FILE *out, const char *text, const char *end)
{
	size_t column = 0;
	while (text < end) {
		size_t length = strcspn(text, " \n");
		if (length > (size_t)(end - text))
			length = (size_t)(end - text);
		if (length > 0) {
			const bool breaks = column > 0 && column + length > SOURCE_WIDTH;
			if (column > 0)
				putc(breaks ? '\n' : ' ', out);
			put_word(out, text, length);
			column = (breaks ? 0 : column) + length + 1;
			if (strchr(".?!", text[length - 1]) != NULL) {
				putc('\n', out);
				column = 0;
			}
		}
		text += length + 1;
	}
	if (column > 0)
		putc('\n', out);
}

static void put_string(FILE *out, const char *text)
{
	put_text(out, text, text + strlen(text));
}

static void put_kept(FILE *out, const char *text, const char *end, const char *options)
{
	fprintf(out, ".Bd -literal%s\n", options);
	for (bool begins = true; text < end; text++) {
		if (begins && (*text == '.' || *text == '\''))
			fputs("\\&", out);
		put_letter(out, *text, true);
		begins = *text == '\n';
	}
	fputs("\n.Ed\n", out);
}

static void put_blocks(FILE *out, const char *text)
{
	const char *begin, *end;
	enum block block;
	for (bool first = true; (block = fill_next_block(&text, &begin, &end)) != BLOCK_END; first = false) {
		if (!first && block == BLOCK_PARAGRAPH)
			fputs(".Pp\n", out);
		if (block == BLOCK_KEPT)
			put_kept(out, begin, end, "");
		else
			put_text(out, begin, end);
	}
}

/* --- options --- */

static void put_value(FILE *out, const char *value)
{
	fputs("Ar ", out);
	for (const char *at = value; *at != '\0'; at++)
		if (*at == ' ')
			fputs(" Ar ", out);
		else
			put_letter(out, *at, true);
}

/* "Fl -store Ar STORE": Fl writes a dash. */
static void put_option(FILE *out, const struct command_option *option)
{
	fprintf(out, "Fl %s", command_dashes(option) + 1);
	for (const char *at = option->name; *at != '\0'; at++)
		put_letter(out, *at, true);
	if (option->value == NULL)
		return;
	putc(' ', out);
	put_value(out, option->value);
}

static void put_group(FILE *out, const struct command_option *option, size_t count)
{
	fputs(count == 1 ? ".Bk -words\n" : "", out); /* keeps an option and its value in one line */
	fputs(!option->needed ? ".Oo " : count > 1 ? ".Po " : ".", out);
	for (size_t i = 0; i < count; i++) {
		fputs(i > 0 ? " | " : "", out);
		put_option(out, &option[i]);
	}
	fputs(!option->needed ? " Oc" : count > 1 ? " Pc" : "", out);
	fputs(option->repeats ? " Ns ...\n" : "\n", out);
	fputs(count == 1 ? ".Ek\n" : "", out);
}

static void put_arguments(FILE *out, const struct command_option *argument)
{
	for (; argument != NULL && argument->name != NULL; argument++) {
		fputs(argument->needed ? "." : ".Oo ", out);
		put_value(out, argument->name);
		fprintf(out, "%s%s\n", argument->needed ? "" : " Oc", argument->repeats ? " Ns ..." : "");
	}
}

static void put_options(FILE *out, const struct command_option *options, bool needed)
{
	size_t count;
	for (; options != NULL && options->name != NULL; options += count) {
		count = command_group(options);
		if (options->needed == needed)
			put_group(out, options, count);
	}
}

static void put_row(FILE *out, const struct command_option *row)
{
	char notes[256];
	command_notes(row, notes, sizeof notes);
	put_string(out, row->help);
	put_string(out, notes);
}

static void put_rows(FILE *out, const char *title, const struct command_option *rows, bool dashes)
{
	if (rows == NULL)
		return;
	fprintf(out, ".Sh %s\n.Bl -tag -width indent\n", title);
	for (; rows->name != NULL; rows++) {
		fputs(".It ", out);
		if (dashes)
			put_option(out, rows);
		else
			put_value(out, rows->name);
		putc('\n', out);
		put_row(out, rows);
	}
	fputs(".El\n", out);
}

/* --- pages --- */

static void put_statuses(FILE *out)
{
	fputs(".Sh EXIT STATUS\n", out);
	put_kept(out, command_statuses, command_statuses + strlen(command_statuses) - 1, "");
	put_string(out, "An error is one line on stderr: furrow: WHAT: WHY; WHAT TO DO.");
}

/* "scene(5), furrow-log(1)" */
static void put_see(FILE *out, const char *see)
{
	fputs(".Sh SEE ALSO\n", out);
	while (*see != '\0') {
		const int name = (int)strcspn(see, "("), length = (int)strcspn(see, ",");
		const bool last = see[length] == '\0';
		fprintf(out, ".Xr %.*s %.*s%s\n", name, see, length - name - 2, see + name + 1, last ? "" : " ,");
		see += last ? length : length + 1 + (int)strspn(see + length + 1, " ");
	}
}

static void put_head(FILE *out, const char *title, const char *name, const char *summary)
{
	fprintf(out, ".\\\" Made by furrow --print man from the tables that --help prints.\n.Dd %s\n.Dt ", FURROW_DATE);
	for (const char *at = title; *at != '\0'; at++)
		putc(toupper((unsigned char)*at), out);
	fprintf(out, " 1\n.Os Furrow " FURROW_VERSION "\n.Sh NAME\n.Nm %s\n.Nd %s\n.Sh SYNOPSIS\n", name, summary);
}

static void put_command(FILE *out, const struct command *command)
{
	char name[64];
	snprintf(name, sizeof name, "furrow-%s", command->name);
	put_head(out, name, name, command->summary);
	fprintf(out, ".Nm \"furrow %s\"\n", command->name);
	put_arguments(out, command->arguments);
	put_options(out, command->options, true);
	put_options(out, command->options, false);
	if (command->also != NULL) {
		fprintf(out, ".Nm \"furrow %s\"\n", command->name);
		put_arguments(out, command->also);
	}
	fputs(".Sh DESCRIPTION\n", out);
	put_blocks(out, command->details);
	put_rows(out, "ARGUMENTS", command->arguments, false);
	put_rows(out, "OPTIONS", command->options, true);
	put_statuses(out);
	if (command->examples != NULL) {
		fputs(".Sh EXAMPLES\n", out);
		put_kept(out, command->examples, command->examples + strlen(command->examples) - 1, "");
	}
	char see[256];
	snprintf(see, sizeof see, "furrow(1)%s%s", command->see != NULL ? ", " : "", command->see != NULL ? command->see : "");
	put_see(out, see);
}

static void put_overview(FILE *out)
{
	const struct command *command;
	put_head(out, "furrow", "furrow", command_about);
	fputs(".Nm\n.Ar COMMAND\n.Op Ar options\n.Nm\n.Op Ar COMMAND\n.Fl -help\n.Nm\n.Fl -version\n.Nm\n.Fl -print\n"
	      ".Ar bash | zsh | fish | man Op Ar COMMAND\n.Sh DESCRIPTION\n", out);
	put_string(out, "A store is a file of elevation tiles, which furrow import makes. A scene is a YAML file that says what drives over it. "
			"furrow drive runs the scene: wheels and other objects change the ground, and the store, or an overlay over it, keeps every rut.");
	fputs(".Pp\n", out);
	put_string(out, "--print writes a completion script for a shell, or the source of a manual page, to stdout. Each comes from the tables that "
			"--help shows.");
	fputs(".Sh COMMANDS\n.Bl -tag -width cache-sim\n", out);
	for (size_t i = 0; (command = command_at(i)) != NULL; i++) {
		fprintf(out, ".It Xr furrow-%s 1\n", command->name);
		put_string(out, command->summary);
	}
	fputs(".El\n", out);
	put_statuses(out);
	fputs(".Sh EXAMPLES\n", out);
	static const char examples[] = "furrow synth -o world.furrow --posts 1025x1025 --spacing 1\n"
				       "furrow explain scene.yaml\n"
				       "furrow drive scene.yaml --overlay ruts.furrow -o out\n"
				       "furrow report out -o report.html\n"
				       "source <(furrow --print bash)";
	put_kept(out, examples, examples + strlen(examples), "");
	put_see(out, "furrow(3), scene(5), store(5)");
}

void help_manual(FILE *out, const struct command *command)
{
	if (command == NULL)
		put_overview(out);
	else
		put_command(out, command);
}
