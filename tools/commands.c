/* The list of subcommands, and what their tables say. */
#include <stdio.h>
#include <string.h>

#include "command.h"
#include "commands.h"

#define DECLARE(name) extern const struct command command_##name;
#define ENTRY(name) &command_##name,

COMMANDS(DECLARE)
static const struct command *const commands[] = {COMMANDS(ENTRY)};

const char command_about[] = "terrain larger than memory that keeps every rut";
const char command_statuses[] = "  0    done\n"
				"  1    failed while running\n"
				"  2    wrong usage\n"
				"  3    bad input: missing, unreadable, corrupt, unsupported or out of range\n"
				"  4    no usable GL: OpenGL 4.5 core through EGL\n"
				"  130  interrupted by Ctrl-C or SIGTERM\n";

const struct command *command_at(size_t index)
{
	return index < sizeof commands / sizeof *commands ? commands[index] : NULL;
}

const struct command *command_find(const char *name)
{
	const struct command *command;
	for (size_t i = 0; (command = command_at(i)) != NULL; i++)
		if (strcmp(command->name, name) == 0)
			break;
	return command;
}

const char *command_dashes(const struct command_option *option)
{
	return option->name[1] == '\0' ? "-" : "--";
}

size_t command_group(const struct command_option *option)
{
	size_t count = 1;
	while (option[count].name != NULL && option[count].instead)
		count++;
	return count;
}

/* --- notes --- */

struct notes {
	char *text;
	size_t room, used;
};

static void add(struct notes *notes, const char *before, const char *text)
{
	if (notes->used < notes->room)
		notes->used += (size_t)snprintf(notes->text + notes->used, notes->room - notes->used, "%s%s", before, text);
}

static const char *between(const struct notes *notes)
{
	return notes->used > 0 ? "; " : "(";
}

static void add_choices(struct notes *notes, const struct command_option *option)
{
	add(notes, between(notes), option->list ? "some of " : "");
	for (const char *const *choice = option->choices; *choice != NULL; choice++) {
		const char *part = option->list || choice[1] != NULL ? ", " : " or ";
		add(notes, choice == option->choices ? "" : part, *choice);
	}
}

void command_notes(const struct command_option *option, char *text, size_t room)
{
	struct notes notes = {text, room, 0};
	text[0] = '\0';
	if (option->instead) {
		const struct command_option *first = option;
		while (first->instead)
			first--;
		add(&notes, "(instead of ", command_dashes(first));
		add(&notes, "", first->name);
	}
	if (option->unit != NULL)
		add(&notes, between(&notes), option->unit);
	if (option->choices != NULL)
		add_choices(&notes, option);
	if (option->preset != NULL) {
		add(&notes, between(&notes), "default: ");
		add(&notes, "", option->preset);
	}
	if (option->repeats)
		add(&notes, between(&notes), "may be repeated");
	if (notes.used > 0)
		add(&notes, ")", "");
}
