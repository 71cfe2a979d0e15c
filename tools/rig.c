/* furrow rig: the single-wheel test: sinkage, drawbar pull, torque and efficiency over slip. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "command.h"
#include "base/aside.h"
#include "base/json.h"
#include "base/limits.h"
#include "python.h"
#include "rig_table.h"
#include "settings.h"
#include "soil_given.h"

#define DEFAULT_SHAPE "wheel: {radius: 0.25, width: 0.2}"
#define DEFAULT_SOIL "dry_sand"
#define DEFAULT_LOAD "1000"
#define DEFAULT_SLIP "-0.4,-0.2,-0.1,0,0.05,0.1,0.2,0.3,0.4,0.5,0.6,0.7,0.8"
#define SOILS_MOST 32

static const struct command_option options[] = {
	{"o", "DIR", .help = "where rig.csv and rig.svg go", .files = "/", .needed = true},
	{"shape", "YAML", .help = "what is carried, as an object's shape in a scene", .preset = DEFAULT_SHAPE},
	{"soil", "LIST", .help = "soils: names, files with a scene's soil as furrow fit-soil writes them, or a scene's soil in braces", .preset = DEFAULT_SOIL},
	{"load", "LIST", .help = "what presses on the soil", .unit = "N", .preset = DEFAULT_LOAD},
	{"depth", "LIST", .help = "of its lowest point below the untouched ground, kept all the way", .unit = "m", .instead = true},
	{"slip-angle", "LIST", .help = "from a wheel's way to its plane, to the left; 90: it goes along its axle", .unit = "degrees", .preset = "0"},
	{"yaw", "LIST", .help = "the same of another shape, as of a blade", .unit = "degrees", .instead = true},
	{"rake", "DEG", .help = "of a blade's front from the level; below 90 its top leans back", .unit = "degrees", .preset = "90"},
	{"slip", "LIST", .help = "of a wheel or a belt: 1 - way / (turn x radius), 1 - way / what the belt runs; -0.2:0.8:0.1 is a range, locked a wheel that does not turn",
	 .preset = DEFAULT_SLIP},
	{"torque", "LIST", .help = "what drives a wheel, or pulls a belt; the slip is found", .unit = "N m; of a belt N",
	 .instead = true},
	{"passes", "N", .help = "objects that follow each other, up to 4, as the axles of a vehicle do; the row is that of the last", .preset = "1"},
	{"spacing", "M", .help = "distance between posts", .unit = "m",
	 .preset = "a twentieth of the wheel's width or radius, whichever is less"},
	{"speed", "M/S", .help = "along its way", .unit = "m/s", .preset = "0.1"},
	{"way", "M", .help = "how far it goes", .unit = "m", .preset = "eight radii, or half lengths"},
	{"compare", "CSV", .help = "measured trials beside it: columns slip, and sinkage or sinkage_mm, drawbar or drag_N, side or lateral_N, torque",
	 .files = "csv"},
	{"set", "KEY=VALUE", .help = "a key of the scene, as in redistribute.slip_sinkage=0", .repeats = true},
	{"json", .help = "print one JSON object in place of the text"},
	{.name = NULL},
};

/* What the command line says, and what came of it. */
struct asked {
	struct rig_params params;
	struct rig_table table;
	struct soil_given given[SOILS_MOST];
	const char *soils[SOILS_MOST], *labels[SOILS_MOST];
	double loads[RIG_VALUES_MOST], depths[RIG_VALUES_MOST], angles[RIG_VALUES_MOST], slips[RIG_VALUES_MOST], torques[RIG_VALUES_MOST];
	size_t room;
	struct progress progress;
};

/* --- soils --- */

static enum status add_soil(struct asked *asked, const char *given)
{
	const size_t count = asked->params.soil_count;
	if (*given == '\0')
		return fail_with(STATUS_USAGE, "rig: --soil: a name is missing; give names parted by commas; docs/SOILS.md has them");
	if (count == SOILS_MOST)
		return fail_with(STATUS_USAGE, "rig: --soil: are more than %d soils; give fewer", SOILS_MOST);
	struct soil_given *soil = &asked->given[count];
	TRY(soil_given_take(given, soil));
	/* Files of one name in two folders. */
	for (size_t i = 0; i < count; i++)
		if (strcmp(soil->label, asked->labels[i]) == 0 && strcmp(soil->label, given) != 0) {
			mem_free(soil->label);
			soil->label = mem_strdup(given);
			TRY_MEM(soil->label, "a soil");
		}
	asked->soils[count] = soil->text;
	asked->labels[count] = soil->label;
	asked->params.soil_count++;
	return STATUS_OK;
}

/* Commas within braces part nothing. */
static enum status read_soils(const struct arguments *arguments, struct asked *asked)
{
	const char *given = arguments_text(arguments, "soil");
	char *text = mem_strdup(given != NULL ? given : DEFAULT_SOIL), *begin = text;
	TRY_MEM(text, "soils");
	enum status status = STATUS_OK;
	int depth = 0;
	for (char *at = text; begin != NULL; at++) {
		const char c = *at;
		depth += (c == '{') - (c == '}');
		if (c != '\0' && (c != ',' || depth > 0))
			continue;
		*at = '\0';
		TRY_OR(done, add_soil(asked, begin + strspn(begin, " ")));
		begin = c != '\0' ? at + 1 : NULL;
	}
done:
	mem_free(text);
	return status;
}

/* --- running --- */

static enum status progress_rig(void *user, int64_t done, int64_t total)
{
	struct asked *asked = user;
	return progress_step(&asked->progress, done, total);
}

static enum status keep(void *user, const struct rig_row *row)
{
	struct asked *asked = user;
	struct rig_table *table = &asked->table;
	if (row->pass + 1 < asked->params.passes)
		return STATUS_OK;
	if (table->count == asked->room) {
		const size_t room = asked->room > 0 ? 2 * asked->room : 64;
		struct rig_row *rows = mem_realloc(table->rows, room, sizeof *rows);
		TRY_MEM(rows, "the rig's rows");
		table->rows = rows;
		asked->room = room;
	}
	struct rig_row *kept = &table->rows[table->count++];
	*kept = *row;
	if (row->state == RIG_SUNK) { /* such forces mean nothing, nor does a slip that was found from them */
		kept->drawbar = kept->side = kept->efficiency = kept->overturning = kept->aligning = NAN;
		kept->against = kept->against_least = kept->against_most = kept->heap = kept->heap_volume = NAN;
		*(asked->params.torque_count > 0 ? &kept->slip : &kept->torque) = NAN;
	}
	return STATUS_OK;
}

static void tell_sunk(const struct rig_table *table)
{
	size_t count = 0;
	double deepest = 0;
	for (size_t i = 0; i < table->count; i++)
		if (table->rows[i].state == RIG_SUNK) {
			count++;
			deepest = fmax(deepest, table->rows[i].sinkage);
		}
	if (count > 0)
		note("rig: %zu of %zu rows are sunk, up to %.3g m deep: the soil does not carry the load; bekker_kphi or the load is probably in a wrong unit: "
		     "give N/m^(n+2) and N",
		     count, table->count, deepest);
}

static enum status write_table(const struct rig_table *table, const char *folder)
{
	char path[4096];
	struct aside aside = {.path = NULL};
	snprintf(path, sizeof path, "%s/rig.csv", folder);
	enum status status;
	TRY_OR(done, aside_begin(&aside, path));
	rig_csv_write(table, aside.file);
done:
	return aside_end(&aside, false, status);
}

/* Python draws. Without it there is the table alone, and no plot of another one beside it. */
static enum status write_plot(const struct rig_table *table, const char *folder, bool *missing)
{
	char path[4096];
	struct aside aside = {.path = NULL};
	cJSON *plan = NULL;
	snprintf(path, sizeof path, "%s/rig.svg", folder);
	enum status status;
	TRY_OR(done, aside_begin(&aside, path));
	plan = rig_told_plan(table);
	TRY_OR(done, python_draw("rig", plan, aside.file, missing));
done:
	cJSON_Delete(plan);
	status = aside_end(&aside, false, status);
	if (!*missing)
		return status;
	note("%s: is not drawn: %s", path, failure_message());
	(void)unlink(path);
	return STATUS_OK;
}

/* How it is turned, and how it goes. */
static enum status read_motion(const struct arguments *arguments, struct asked *asked)
{
	struct rig_params *params = &asked->params;
	const bool yaw = arguments_text(arguments, "yaw") != NULL;
	if (yaw && arguments_text(arguments, "slip-angle") != NULL)
		return fail_with(STATUS_USAGE, "rig: --yaw: --slip-angle is the same, and is given too; give one of them");
	TRY(rig_list_read(arguments, yaw ? "yaw" : "slip-angle", NULL, asked->angles, &params->angle_count));
	TRY(arguments_number(arguments, "rake", 1, 179, &params->rake));
	TRY(arguments_number(arguments, "speed", 1e-6, 100, &params->speed));
	return arguments_number(arguments, "way", 1e-3, 1000, &params->way);
}

static enum status read_all(const struct arguments *arguments, struct asked *asked, struct settings *settings)
{
	struct rig_params *params = &asked->params;
	const char *shape = arguments_text(arguments, "shape"), *torque = arguments_text(arguments, "torque");
	const char *compare = arguments_text(arguments, "compare");
	int64_t passes = 1;
	params->shape = shape != NULL ? shape : DEFAULT_SHAPE;
	params->folder = arguments_text(arguments, "o");
	if (params->folder == NULL)
		return fail_with(STATUS_USAGE, "rig: -o is missing; give a folder for rig.csv and rig.svg");
	TRY(arguments_number(arguments, "spacing", 1e-4, 10, &params->spacing));
	TRY(arguments_integer(arguments, "passes", 1, RIG_PASSES_MOST, &passes));
	params->passes = (size_t)passes;
	TRY(read_soils(arguments, asked));
	TRY(read_motion(arguments, asked));
	const bool depths = arguments_text(arguments, "depth") != NULL;
	TRY(rig_list_read(arguments, "load", depths ? NULL : DEFAULT_LOAD, asked->loads, &params->load_count));
	TRY(rig_list_read(arguments, "depth", NULL, asked->depths, &params->depth_count));
	TRY(rig_list_read(arguments, "slip", torque == NULL ? DEFAULT_SLIP : NULL, asked->slips, &params->slip_count));
	TRY(rig_list_read(arguments, "torque", NULL, asked->torques, &params->torque_count));
	TRY(settings_take(arguments, settings));
	return compare != NULL ? rig_measured_read(compare, &asked->table.measured, &asked->table.measured_count) : STATUS_OK;
}

/* Writes settings as the rig takes them. */
static enum status join_settings(const struct settings *settings, char **out)
{
	size_t room = 1;
	for (size_t i = 0; i < settings->count; i++)
		room += strlen(settings->list[i].key) + strlen(settings->list[i].value) + 2;
	char *at = *out = mem_alloc(room, 1);
	TRY_MEM(at, "settings");
	*at = '\0';
	for (size_t i = 0; i < settings->count; i++)
		at += sprintf(at, "%s=%s\n", settings->list[i].key, settings->list[i].value);
	return STATUS_OK;
}

static enum status make_folder(const char *path)
{
	if (mkdir(path, 0777) == 0 || errno == EEXIST)
		return STATUS_OK;
	return fail_with(STATUS_FAILED, "%s: %s; %s", path, strerror(errno), limits_advice(errno, "give a folder that can be made"));
}

static enum status run_rig(struct asked *asked)
{
	interrupt_catch();
	progress_start(&asked->progress, "rig", "runs");
	const enum status status = trials_rig_run(&asked->params, &asked->table.found, keep, asked);
	progress_end(&asked->progress);
	return status;
}

static enum status run(const struct arguments *arguments)
{
	struct settings settings = {.count = 0};
	struct asked *asked = mem_calloc(1, sizeof *asked);
	TRY_MEM(asked, "the rig");
	struct rig_params *params = &asked->params;
	*params = (struct rig_params){.soils = asked->soils, .loads = asked->loads, .depths = asked->depths, .angles = asked->angles, .slips = asked->slips,
				      .torques = asked->torques, .stop = &interrupted, .progress = progress_rig, .advise = true, .user = asked};
	asked->table.params = params;
	asked->table.soils = asked->labels;
	char *joined = NULL;
	bool missing = false;
	enum status status;
	TRY_OR(done, read_all(arguments, asked, &settings));
	TRY_OR(done, join_settings(&settings, &joined));
	params->settings = joined;
	TRY_OR(done, make_folder(params->folder));
	TRY_OR(done, run_rig(asked));
	TRY_OR(done, write_table(&asked->table, params->folder));
	TRY_OR(done, write_plot(&asked->table, params->folder, &missing));
	tell_sunk(&asked->table);
	if (arguments_flag(arguments, "json")) {
		TRY_OR(done, rig_told_json(&asked->table));
	} else {
		rig_told_print(&asked->table);
		printf(missing ? "\n%s/rig.csv: written\n" : "\n%s/rig.csv, %s/rig.svg: written\n", params->folder, params->folder);
	}
done:
	settings_finish(&settings);
	mem_free(joined);
	mem_free(asked->table.rows);
	mem_free(asked->table.measured);
	for (size_t i = 0; i < SOILS_MOST; i++)
		soil_given_finish(&asked->given[i]);
	mem_free(asked);
	return status;
}

const struct command command_rig = {
	.name = "rig",
	.summary = "the single-wheel test: sinkage, drawbar pull, torque and efficiency over slip",
	.options = options,
	.details = "Carries a wheel, or another object, over level soil in a straight line, once for each soil, load, angle and slip, "
		   "eight radii far. The numbers are means over the last quarter of the way, by the model scm, as furrow drive "
		   "tells them. The bed is made for it and thrown away.\n\n"
		   "At a slip angle the wheel's plane is turned to the left of its way. Drawbar, side force, torque and moments are in the "
		   "wheel's own axes: its plane, and its axle. Slip is 1 - way / (turn x radius) with the whole way. Below 0 the wheel is braked; locked, it does not turn. "
		   "--depth carries a blade, or any shape, at a fixed depth; --rake and --yaw turn it.\n\n"
		   "State: steady; digs: still sinking there, by more than 5 % in an eighth of the way; grows: at a depth the force "
		   "against its way still changes by so much; sunk: the soil does not "
		   "carry the load, and the row has no forces but fz; spins: no slip from -0.9 to 0.95 gives this torque.\n\n"
		   "rig.csv, in m, N, N m and degrees: soil, load, slip, torque, sinkage, drawbar, side, fz, efficiency, deeper, state, slip_angle, "
		   "overturning, aligning, against, against_least, against_most, heap, heap_volume. "
		   "Efficiency is the pull along the way times way over torque times turn. deeper: how much deeper the second half of the "
		   "last quarter is than the first. against: the force against the way, its mean, least and most. heap: the highest soil "
		   "ahead of its centre at the end, above the untouched ground, and its volume. Of a box or a mesh with belt: true, torque is what pulls its belt, in N.\n\n"
		   "rig.svg is drawn by the Python package matplotlib. Without it a note says so, and there is rig.csv alone.\n\n"
		   "With --compare the differences from the measured trials are told, and drawn. A line with a slip_angle_deg belongs to that slip angle, one without to 0.\n",
	.examples = "furrow rig -o bench --soil dry_sand,clayey_38 --load 500,1000\n"
		    "furrow rig -o bench --soil my_sand.yaml,dry_sand\n"
		    "furrow rig -o bench --slip-angle 0,30,90 --slip locked,-0.5,0,0.5\n"
		    "furrow rig -o b --shape 'box: {size: [0.002, 1, 0.4]}' --depth 0.1 --rake 60\n",
	.see = "furrow-mobility(1), scene(5)",
	.run = run,
};
