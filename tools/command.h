/*
 * What a subcommand is: a table of options that both the parser and --help read, and a function.
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

struct command_option {
	const char *name;  /* without dashes; one letter: a single dash */
	const char *value; /* what its value is called in the help; NULL: a flag */
	const char *help;
};

struct command {
	const char *name, *usage, *summary;
	const char *details;                  /* further help, or NULL */
	const struct command_option *options; /* ended by a NULL name */
	enum status (*run)(const struct arguments *arguments);
};

extern const struct command command_synth, command_import, command_info, command_verify, command_query,
	command_export, command_reset, command_branch, command_snapshot, command_log, command_restore, command_merge, command_flatten, command_relink, command_explain, command_drive, command_report, command_rig, command_study, command_mobility, command_view, command_cache_sim;

/* Parses argv (without the command's name). STATUS_USAGE with what is wrong. */
enum status arguments_parse(const struct command *command, int argc, char **argv,
			    struct arguments **out) FURROW_CHECKED;
void arguments_destroy(struct arguments *arguments);

size_t arguments_count(const struct arguments *arguments); /* positional ones */
const char *arguments_at(const struct arguments *arguments, size_t index);
/* STATUS_USAGE unless there are from `least` to `most` positional ones. */
enum status arguments_expect(const struct arguments *arguments, size_t least, size_t most) FURROW_CHECKED;

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
/* One of `names` (ended by NULL): its index. */
enum status arguments_choice(const struct arguments *arguments, const char *option,
			     const char *const *names, int *value) FURROW_CHECKED;
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
