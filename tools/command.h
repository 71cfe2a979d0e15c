/*
 * What a subcommand is: tables of arguments and options, texts, and a function. The parser, --help, the manual pages and the
 * completions of shells all read these tables, so that an option is declared once.
 *
 * A new subcommand is a file NAME.c with `const struct command command_NAME`, its file and its name in meson.build.
 *
 * A token that is wholly a number is a value, never an option, so that `query STORE -3 4` works.
 */
#ifndef FURROW_TOOLS_COMMAND_H
#define FURROW_TOOLS_COMMAND_H

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

struct arguments;

/* An option, or an argument without a dash. The parser reads it; --help, the manual page and the completions are made of it. */
struct command_option {
	const char *name;           /* without dashes, one letter: a single dash; of an argument: what the usage calls it */
	const char *value;          /* what its value is called; NULL: a flag, or an argument */
	const char *help;           /* what it is or does; neither unit nor default */
	const char *unit;           /* of its number, as "m"; NULL: none */
	const char *preset;         /* what it is where it is not given; NULL: nothing to tell */
	const char *const *choices; /* all values that there are, ended by NULL; NULL: not a choice */
	const char *files;          /* endings of files that it names, as in "tif png"; "*": any file; "/": a folder; NULL: no file */
	bool list;                  /* several of `choices`, parted by commas */
	bool needed;                /* an option: the command fails without it, or one in its place */
	bool repeats;
	bool instead;               /* in place of the option before it in the table; never the first */
};

struct command {
	const char *name, *summary;
	const struct command_option *arguments; /* in their order, ended by a NULL name; NULL: none */
	const struct command_option *also;      /* a second form that has these arguments, or NULL; the first is a word
						   that is written as it is */
	const struct command_option *options;   /* ended by a NULL name; NULL: none */
	const char *details;  /* paragraphs, parted by blank lines and filled when printed; lines that begin with a blank are kept; or NULL */
	const char *examples; /* lines of commands, or NULL */
	const char *see;      /* manual pages, as in "scene(5), furrow-log(1)", or NULL */
	enum status (*run)(const struct arguments *arguments);
};

#define COMMAND_ARGUMENTS(...) \
	(const struct command_option[]) \
	{ \
		__VA_ARGS__, {.name = NULL} \
	}
#define COMMAND_STORE {"STORE", .help = "a terrain store, or an overlay", .files = "furrow", .needed = true}
#define COMMAND_SCENE {"SCENE", .help = "what is driven and drawn: a YAML file", .files = "yaml yml json", .needed = true}

/* --- commands.c: the subcommands, in the order of tools/meson.build --- */

/* The nth, or NULL after the last. */
const struct command *command_at(size_t index);
const struct command *command_find(const char *name); /* NULL: there is none */
/* "--" or "-", as the option's name is written. */
const char *command_dashes(const struct command_option *option);
/* The options that stand in for each other from this one on, 1 or more. */
size_t command_group(const struct command_option *option);
/* What --help says of an option after its text, in brackets: unit, choices, default and more; "" for nothing. */
void command_notes(const struct command_option *option, char *text, size_t room);

extern const char command_about[];     /* the program in a line */
extern const char command_statuses[];  /* exit statuses, as `details` of a command */

/* --- arguments.c --- */

/* Parses argv (without the command's name) and counts the positional ones. STATUS_USAGE with what is wrong. */
enum status arguments_parse(const struct command *command, int argc, char **argv,
			    struct arguments **out) FURROW_CHECKED;
void arguments_destroy(struct arguments *arguments);

size_t arguments_count(const struct arguments *arguments); /* positional ones */
const char *arguments_at(const struct arguments *arguments, size_t index);

bool arguments_flag(const struct arguments *arguments, const char *option);
/* The last value given, or NULL. */
const char *arguments_text(const struct arguments *arguments, const char *option);
/* The nth value of a repeated option, or NULL. */
const char *arguments_nth(const struct arguments *arguments, const char *option, size_t nth);

/* Leave *value alone if the option was not given. STATUS_USAGE if not a number from low to high. */
enum status arguments_number(const struct arguments *arguments, const char *option, double low,
			     double high, double *value) FURROW_CHECKED;
enum status arguments_integer(const struct arguments *arguments, const char *option, int64_t low,
			      int64_t high, int64_t *value) FURROW_CHECKED;
/* `count` numbers parted by commas. */
enum status arguments_numbers(const struct arguments *arguments, const char *option, size_t count,
			      double *values, bool *given) FURROW_CHECKED;
/* One of the option's `choices`: its index. */
enum status arguments_choice(const struct arguments *arguments, const char *option, int *value) FURROW_CHECKED;
/* The whole text is one number: a finite one, or one that may be infinite. */
bool parse_number(const char *text, double *value);
bool parse_number_or_infinity(const char *text, double *value);

/* --- while it runs: progress.c --- */
/* Non-zero after Ctrl-C or SIGTERM. */
extern volatile sig_atomic_t interrupted;
void interrupt_catch(void);

/* On stderr: on a terminal one line that changes; in a log or a pipe a line every 10 s, so none of short work. */
struct progress {
	const char *what, *unit;
	double started, shown;
	bool terminal;
};
void progress_start(struct progress *progress, const char *what, const char *unit);
/* STATUS_INTERRUPTED once interrupted; matches the progress callbacks of dem and store. */
enum status progress_step(void *progress, int64_t done, int64_t total);
void progress_end(struct progress *progress);

#endif
