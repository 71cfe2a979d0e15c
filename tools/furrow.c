/* The furrow command: finds the subcommand, prints its one-line error, returns its status. */
#include <signal.h>
#include <stdio.h>
#include <string.h>

#include "command.h"
#include "dem/dem.h"
#include "fleet/fleet.h"

static const struct command *const commands[] = {
	&command_synth,	 &command_import, &command_info,  &command_verify,
	&command_query,	 &command_export, &command_reset, &command_branch,
	&command_snapshot, &command_log, &command_restore, &command_merge, &command_flatten, &command_relink, &command_explain,
	&command_drive,	 &command_report, &command_rig, &command_study, &command_mobility,	  &command_view,   &command_cache_sim,
};

#define COMMANDS (sizeof commands / sizeof *commands)

static void print_overview(FILE *out)
{
	fputs("furrow " FURROW_VERSION ": terrain larger than memory that keeps every rut\n\n"
	      "usage: furrow COMMAND ...        furrow COMMAND --help explains it\n\n",
	      out);
	for (size_t i = 0; i < COMMANDS; i++)
		fprintf(out, "  %-9s %s\n", commands[i]->name, commands[i]->summary);
	fputs("\nexit status: 0 done, 1 failed while running, 2 wrong usage, 3 bad input, 4 no usable GL\n", out);
}

static void print_help(const struct command *command)
{
	printf("furrow %s: %s\n\nusage: furrow %s\n\n", command->name, command->summary, command->usage);
	for (const struct command_option *option = command->options; option->name != NULL; option++) {
		char left[64];
		snprintf(left, sizeof left, "%s%s%s%s", option->name[1] == '\0' ? "-" : "--", option->name,
			 option->value != NULL ? " " : "", option->value != NULL ? option->value : "");
		printf("  %-26s %s\n", left, option->help);
	}
	if (command->details != NULL)
		printf("\n%s", command->details);
}

static int report(enum status status)
{
	if (status != STATUS_OK && fleet_speaks())
		fprintf(stderr, "furrow: %s\n", failure_message());
	return status_exit_code(status);
}

static bool is_help(const char *text)
{
	return strcmp(text, "--help") == 0 || strcmp(text, "-h") == 0;
}

int main(int argc, char **argv)
{
	dem_quiet_process();
	(void)signal(SIGXFSZ, SIG_IGN); /* a file that may not grow is a failed write, which is told */
	if (argc >= 2 && (is_help(argv[1]) || strcmp(argv[1], "help") == 0)) {
		print_overview(stdout);
		return 0;
	}
	if (argc >= 2 && strcmp(argv[1], "--version") == 0) {
		puts("furrow " FURROW_VERSION);
		return 0;
	}
	if (argc < 2) {
		print_overview(stderr);
		return status_exit_code(STATUS_USAGE);
	}
	const struct command *command = NULL;
	for (size_t i = 0; i < COMMANDS; i++)
		if (strcmp(commands[i]->name, argv[1]) == 0)
			command = commands[i];
	if (command == NULL)
		return report(fail_with(STATUS_USAGE, "%s: not a command; see furrow --help", argv[1]));
	for (int i = 2; i < argc && strcmp(argv[i], "--") != 0; i++)
		if (is_help(argv[i])) {
			print_help(command);
			return 0;
		}
	struct arguments *arguments = NULL;
	enum status status = arguments_parse(command, argc - 2, argv + 2, &arguments);
	if (status == STATUS_OK)
		status = command->run(arguments);
	arguments_destroy(arguments);
	if ((fflush(stdout) != 0 || ferror(stdout)) && status == STATUS_OK)
		status = fail_with(STATUS_FAILED, "stdout: cannot be written; check the disk or the pipe");
	return report(status);
}
