/* furrow report: one HTML page of one drive, or of several beside each other. python/furrow/report writes it. */
#include <string.h>
#include <sys/stat.h>

#include "python.h"

#define RUNS 8

extern const struct command command_report;

static const struct command_option options[] = {
	{"o", "FILE.html", .help = "the page", .files = "html", .needed = true},
	{.name = NULL},
};

static enum status check(const struct arguments *arguments, const char *path)
{
	struct stat found;
	if (arguments_count(arguments) > RUNS)
		return fail_with(STATUS_USAGE, "report: %zu folders are too many; give at most %d, or collect them with furrow study",
				 arguments_count(arguments), RUNS);
	if (path == NULL)
		return fail_with(STATUS_USAGE, "report: -o is missing; give the page to write, as in -o report.html");
	if (stat(path, &found) == 0 && !S_ISREG(found.st_mode))
		return fail_with(STATUS_USAGE, "report: %s: is no file; give the page to write, as in -o report.html", path);
	for (size_t i = 0; i < arguments_count(arguments); i++)
		for (size_t k = 0; k < i; k++)
			if (strcmp(arguments_at(arguments, i), arguments_at(arguments, k)) == 0)
				return fail_with(STATUS_USAGE, "report: %s: is given twice; give each folder once", arguments_at(arguments, i));
	return STATUS_OK;
}

static enum status run(const struct arguments *arguments)
{
	TRY(check(arguments, arguments_text(arguments, "o")));
	return python_command(&command_report, arguments);
}

const struct command command_report = {
	.name = "report",
	.summary = "one page of a drive, or of several beside each other",
	.arguments = COMMAND_ARGUMENTS({"DIR", .help = "a folder that furrow drive left; up to eight are compared", .files = "/",
	 .needed = true, .repeats = true}),
	.options = options,
	.details = "The page is one file. It needs no network, and no file beside it: plots and maps are drawn within it, and pictures "
		   "are a part of it.\n\n"
		   "Sections, and the files that they come from. Pictures and four numbers are first, then plots, then tables:\n\n"
		   "  pictures of the drive              its frame-*.png\n"
		   "  what was run, settings, soils,     run.json\n"
		   "    results, step times, volume, notes\n"
		   "  volume over time                   volume.csv\n"
		   "  map of the ground and the ways     the deformed store; else map.png\n"
		   "  ways, seen from above              vehicles.csv, objects.csv or run.json\n"
		   "  cameras                            run.json, and pictures in cameras\n"
		   "  means over the last quarter        objects.csv\n"
		   "  sinkage, slip, traction, drawbar   objects.csv (output.forces in the scene)\n"
		   "    pull, torque, energy\n"
		   "  speed, work, energy of vehicles    vehicles.csv (output.vehicles)\n"
		   "  pull against slip                  objects.csv, vehicles.csv\n"
		   "  digging of bodies with carry       objects.csv, run.json\n"
		   "  rut profile, across the way        the store or overlay that was deformed\n"
		   "  page cache: misses over slots      the trace (drive --trace FILE)\n\n"
		   "If a folder does not have the data for a section, one sentence gives the reason. It needs Python with jinja2, matplotlib and pandas (Debian: python3-jinja2 python3-matplotlib python3-pandas). More: docs/REPORT.md\n",
	.examples = "furrow report out -o report.html\n"
		    "furrow report sand clay -o soils.html\n",
	.see = "furrow-drive(1)",
	.run = run,
};
