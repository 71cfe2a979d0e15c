/* furrow fit-soil: a scene's soil from plate, shear and penetration tests. python/furrow/fit.py does it. */
#include <math.h>

#include "deform/deform.h"
#include "python.h"

extern const struct command command_fit_soil;

static const char *const methods[] = {"plain", "wong", NULL};

static const struct command_option options[] = {
	{"o", "FILE.yaml", .help = "a file for the soil, in place of the end of the output", .files = "yaml yml"},
	{"penetration", "FILE.csv", .help = "force or pressure over the depth of a level plate, or of another flat end, that is pushed straight down", .files = "csv"},
	{"area", "M2", .help = "of that plate, where the file has forces and no column area", .unit = "m2"},
	{"page", "FILE.html", .help = "a page with plots of the curves and of their residuals", .files = "html"},
	{"method", "METHOD", .help = "whose kc, kphi and n the soil has: least squares of pressure, or of its logarithm weighted by the square of pressure",
	 .choices = methods, .preset = "plain"},
	{"soil", "NAME", .help = "the named soil that has the numbers that were not measured", .preset = "dry_sand"},
	{"json", .help = "print one JSON object in place of the text"},
	{.name = NULL},
};

/* What is wrong on the command line, and a soil that is not known, is told before Python begins. */
static enum status run(const struct arguments *arguments)
{
	const char *named = arguments_text(arguments, "soil");
	const bool penetration = arguments_text(arguments, "penetration") != NULL;
	struct soil_numbers soil;
	int method = 0;
	double area = 0;
	TRY(arguments_choice(arguments, "method", &method));
	TRY(soil_named(named != NULL ? named : "dry_sand", &soil));
	if (isnan(soil.elastic_stiffness))
		return fail_with(STATUS_INPUT, "fit-soil: --soil: %s has no numbers of Bekker's and Janosi's soils; name one that docs/SOILS.md has there", named);
	TRY(arguments_number(arguments, "area", 1e-9, 1e4, &area));
	if (arguments_count(arguments) == 0 && !penetration)
		return fail_with(STATUS_USAGE, "fit-soil: no test is given; give PLATE.csv, or --penetration FILE.csv");
	if (area > 0 && !penetration)
		return fail_with(STATUS_USAGE, "fit-soil: --area: is that of the plate of --penetration; give both");
	return python_command(&command_fit_soil, arguments);
}

const struct command command_fit_soil = {
	.name = "fit-soil",
	.summary = "a scene's soil from your own plate, shear and penetration tests",
	.arguments = COMMAND_ARGUMENTS({"PLATE.csv", .help = "pressure and sinkage of plates of at least two widths; needed without --penetration", .files = "csv"},
				       {"SHEAR.csv", .help = "shear stress and displacement under some normal stresses", .files = "csv"}),
	.options = options,
	.details = "Fits Bekker's p = (kc / b + kphi) z^n to PLATE.csv, and Janosi's tau = (c + sigma tan phi) (1 - exp(-j / K)) to SHEAR.csv. Prints "
		   "each number with its standard error, the residuals, and a soil: that a scene takes as it is.\n\n"
		   "The first line of a file names its columns, each with its unit at the end:\n\n"
		   "  PLATE.csv:  plate width b          m, cm or mm\n"
		   "              sinkage z              m, cm or mm\n"
		   "              pressure p             Pa, kPa or MPa\n"
		   "  SHEAR.csv:  normal stress sigma    Pa, kPa or MPa\n"
		   "              displacement j         m, cm or mm\n"
		   "              shear stress tau       Pa, kPa or MPa\n"
		   "  --penetration:\n"
		   "              depth z                m, cm or mm\n"
		   "              force F, or pressure p N or kN; Pa, kPa or MPa\n"
		   "              area, if you like      m2, cm2 or mm2\n\n"
		   "One word of each name is enough, as in \"b mm,z mm,p kPa\". The width is a plate's shorter side, or the radius of a round one. Other "
		   "columns, empty lines and lines that begin with # are passed over.\n\n"
		   "The penetration gives face_strength: how strongly the soil presses on faces that slide. p = 0.87574 face_strength z, as 3D-RFT tells of a level "
		   "plate in dry soil.\n\n"
		   "Plates of one width do not tell kc and kphi apart: give plates of two. With one, kc is 0, and kphi is their sum for that width. One normal stress does "
		   "not tell cohesion and friction apart. Then the soil has no cohesion.\n\n"
		   "A drive takes the soil in place of its scene's: furrow drive SCENE -o DIR --set soil=soil.yaml. So do explain and view; rig and mobility "
		   "take it by --soil.\n\n"
		   "It needs the Python package scipy, and --page needs matplotlib and jinja2 (pip install 'furrow[plot]', or all by name).\n\n"
		   "wong weighs as J. Y. Wong (1980). More: docs/SOIL-TESTS.md\n",
	.examples = "furrow fit-soil plate.csv shear.csv -o soil.yaml --page soil.html\n"
		    "furrow fit-soil plate.csv --soil lete_sand --method wong\n"
		    "furrow fit-soil --penetration penetration.csv --area 0.0025 -o soil.yaml\n",
	.see = "furrow-drive(1), furrow-rig(1), scene(5)",
	.run = run,
};
