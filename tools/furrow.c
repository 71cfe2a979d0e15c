/* The furrow command: finds the subcommand, prints its one-line error, returns its status. */
#include <signal.h>
#include <stdio.h>
#include <string.h>

#include "base/nearest.h"
#include "command.h"
#include "dem/dem.h"
#include "fleet/fleet.h"
#include "help.h"
#include "screen.h"
#include "vehicle/vehicle.h"

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

/* Flushes the output however the command ended. Returns the first failure. */
static enum status close_output(enum status status)
{
	const bool whole = fflush(stdout) == 0 && !ferror(stdout);
	TRY(status);
	return whole ? STATUS_OK : fail_with(STATUS_FAILED, "stdout: cannot be written; check the disk or the pipe");
}

/* furrow --print KIND [COMMAND] */
static enum status print(int count, char **words)
{
	const char *kind = count > 0 ? words[0] : "";
	const struct command *command = count > 1 ? command_find(words[1]) : NULL;
	if (strcmp(kind, "man") == 0 && count <= 2 && (count == 1 || command != NULL))
		help_manual(stdout, command);
	else if (strcmp(kind, "bash") == 0 && count == 1)
		help_bash(stdout);
	else if (strcmp(kind, "zsh") == 0 && count == 1)
		help_zsh(stdout);
	else if (strcmp(kind, "fish") == 0 && count == 1)
		help_fish(stdout);
	else
		return fail_with(STATUS_USAGE, "--print: prints nothing of that name; give bash, zsh, fish, man or man COMMAND");
	return STATUS_OK;
}

static enum status unknown_command(const char *name)
{
	struct nearest nearest = nearest_begin(name);
	const struct command *command;
	for (size_t i = 0; (command = command_at(i)) != NULL; i++)
		nearest_offer(&nearest, command->name);
	return fail_with(STATUS_USAGE, "%s: not a command; see furrow --help%s", name, nearest_ask(&nearest).text);
}

int main(int argc, char **argv)
{
	dem_quiet_process();
	(void)signal(SIGXFSZ, SIG_IGN); /* a file that may not grow is a failed write, which is told */
	if (argc >= 3 && strcmp(argv[1], "help") == 0 && !is_help(argv[2]) && strcmp(argv[2], "help") != 0) {
		const struct command *asked = command_find(argv[2]);
		if (asked == NULL)
			return report(unknown_command(argv[2]));
		help_command(stdout, asked);
		return 0;
	}
	if (argc >= 2 && (is_help(argv[1]) || strcmp(argv[1], "help") == 0)) {
		help_overview(stdout);
		return 0;
	}
	if (argc >= 2 && (strcmp(argv[1], "--version") == 0 || strcmp(argv[1], "-V") == 0 || strcmp(argv[1], "version") == 0)) {
		printf("furrow " FURROW_VERSION "\nvehicles: %s\n", vehicle_engine() != NULL ? vehicle_engine() : "no, this build has no MuJoCo");
		return 0;
	}
	if (argc < 2) {
		help_overview(stderr);
		return status_exit_code(STATUS_USAGE);
	}
	if (strcmp(argv[1], "--print") == 0)
		return report(close_output(print(argc - 2, argv + 2)));
	const struct command *command = command_find(argv[1]);
	if (command == NULL)
		return report(unknown_command(argv[1]));
	for (int i = 2; i < argc && strcmp(argv[i], "--") != 0; i++)
		if (is_help(argv[i])) {
			help_command(stdout, command);
			return 0;
		}
	screen_begin();
	struct arguments *arguments = NULL;
	enum status status = arguments_parse(command, argc - 2, argv + 2, &arguments);
	if (status == STATUS_OK)
		status = command->run(arguments);
	arguments_destroy(arguments);
	const int code = report(close_output(status));
	fleet_leave(); /* after the error is told: a launcher ends all processes when the first one has failed */
	return code;
}
