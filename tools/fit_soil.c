/* furrow fit-soil: a scene's soil from plate and shear tests. */
#include "fit_soil.h"

#include <math.h>

#include "base/aside.h"
#include "command.h"
#include "deform/deform.h"

const char *const fit_soil_methods[] = {"plain", "wong", NULL};

static const struct command_option options[] = {
	{"o", "FILE.yaml", .help = "a file for the soil, in place of the end of the output", .files = "yaml yml"},
	{"penetration", "FILE.csv", .help = "force or pressure over the depth of a level plate, or of another flat end, that is pushed straight down", .files = "csv"},
	{"area", "M2", .help = "of that plate, where the file has forces and no column area", .unit = "m2"},
	{"page", "FILE.html", .help = "a page with plots of the curves and of their residuals", .files = "html"},
	{"method", "METHOD", .help = "whose kc, kphi and n the soil has: least squares of pressure, or of its logarithm weighted by the square of pressure",
	 .choices = fit_soil_methods, .preset = "plain"},
	{"soil", "NAME", .help = "the named soil that has the numbers that were not measured", .preset = "dry_sand"},
	{"json", .help = "print one JSON object in place of the text"},
	{.name = NULL},
};

typedef enum status (*write_fn)(const struct fit_soil *fit, FILE *file);

static enum status write_block(const struct fit_soil *fit, FILE *file)
{
	fit_soil_block(fit, file);
	return STATUS_OK;
}

static enum status write_file(const struct fit_soil *fit, const char *path, write_fn write)
{
	struct aside aside = {.path = NULL};
	if (path == NULL)
		return STATUS_OK;
	enum status status;
	TRY_OR(done, aside_begin(&aside, path));
	TRY_OR(done, write(fit, aside.file));
done:
	return aside_end(&aside, true, status);
}

static enum status fit_pushed(const struct arguments *arguments, struct fit_soil *fit)
{
	const char *path = arguments_text(arguments, "penetration");
	double area = 0;
	TRY(arguments_number(arguments, "area", 1e-9, 1e4, &area));
	fit->has_penetration = path != NULL;
	if (path == NULL)
		return area > 0 ? fail_with(STATUS_USAGE, "fit-soil: --area: is that of the plate of --penetration; give both") : STATUS_OK;
	TRY(fit_table_read(path, FIT_PENETRATION, &fit->penetration));
	TRY(fit_penetration_pressures(&fit->penetration, area));
	return fit_penetration(&fit->penetration, &fit->faces);
}

static enum status fit_all(const struct arguments *arguments, struct fit_soil *fit)
{
	fit->has_plate = arguments_count(arguments) > 0;
	fit->has_shear = arguments_count(arguments) > 1;
	if (!fit->has_plate && arguments_text(arguments, "penetration") == NULL)
		return fail_with(STATUS_USAGE, "fit-soil: no test is given; give PLATE.csv, or --penetration FILE.csv");
	if (fit->has_plate)
		TRY(fit_table_read(arguments_at(arguments, 0), FIT_PLATE, &fit->plate));
	if (fit->has_shear)
		TRY(fit_table_read(arguments_at(arguments, 1), FIT_SHEAR, &fit->shear));
	if (fit->has_plate)
		TRY(fit_plates(&fit->plate, &fit->plates));
	if (fit->has_shear)
		TRY(fit_shear(&fit->shear, &fit->strength));
	return fit_pushed(arguments, fit);
}

static enum status tell(const struct arguments *arguments, const struct fit_soil *fit, const char *path)
{
	if (arguments_flag(arguments, "json"))
		return fit_soil_json(fit);
	fit_soil_print(fit);
	if (path == NULL) {
		putchar('\n');
		fit_soil_block(fit, stdout);
	} else {
		printf("\n%s: a soil, for furrow drive SCENE --set soil=%s, and for --soil of furrow rig and furrow mobility\n", path, path);
	}
	return STATUS_OK;
}

static enum status run(const struct arguments *arguments)
{
	struct fit_soil fit = {.named = arguments_text(arguments, "soil")};
	struct soil_numbers soil;
	const char *path = arguments_text(arguments, "o");
	int method = FIT_PLAIN;
	if (fit.named == NULL)
		fit.named = "dry_sand";
	TRY(arguments_choice(arguments, "method", &method));
	TRY(soil_named(fit.named, &soil));
	fit.method = (enum fit_method)method;
	if (isnan(soil.elastic_stiffness))
		return fail_with(STATUS_INPUT, "fit-soil: --soil: %s has no numbers of Bekker's and Janosi's soils; name one that docs/SOILS.md has "
					       "there", fit.named);
	enum status status;
	TRY_OR(done, fit_all(arguments, &fit));
	TRY_OR(done, write_file(&fit, path, write_block));
	TRY_OR(done, write_file(&fit, arguments_text(arguments, "page"), fit_soil_page));
	TRY_OR(done, tell(arguments, &fit, path));
done:
	fit_table_finish(&fit.plate);
	fit_table_finish(&fit.shear);
	fit_table_finish(&fit.penetration);
	return status;
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
		   "wong weighs as J. Y. Wong (1980). More: docs/SOIL-TESTS.md\n",
	.examples = "furrow fit-soil plate.csv shear.csv -o soil.yaml --page soil.html\n"
		    "furrow fit-soil plate.csv --soil lete_sand --method wong\n"
		    "furrow fit-soil --penetration penetration.csv --area 0.0025 -o soil.yaml\n",
	.see = "furrow-drive(1), furrow-rig(1), scene(5)",
	.run = run,
};
