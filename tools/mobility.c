/* furrow mobility: where a vehicle can drive, as a raster or as a map. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/aside.h"
#include "dem/dem.h"
#include "export.h"
#include "mobility.h"
#include "soil_given.h"
#include "vehicle/vehicle.h"

#define ROWS 64
#define SIDE_MOST 4096 /* cells of a map */
#define EARTH 9.81

static const struct command_option options[] = {
	{"o", "OUT", .help = "a .tif of one layer, or a map of classes", .files = "tif png svg pdf", .needed = true},
	{"vehicle", "MODEL", .help = "MJCF or URDF of the vehicle; its soil geoms are those that collide", .files = "xml urdf mjcf",
	 .needed = true},
	{"scene", "SCENE", .help = "a scene, with its first vehicle, soil and gravity", .files = "yaml yml json", .instead = true},
	{"soil", "SOIL", .help = "a named soil, a file with a scene's soil as furrow fit-soil writes it, or a scene's soil in braces", .preset = "the scene's"},
	{"gravity", "G", .help = "pull of the body", .unit = "m/s2", .preset = "9.81; the scene's"},
	{"layer", "LAYER", .help = "what is written, see below", .choices = mobility_layers,
	 .preset = "slip in a .tif, class in a map"},
	{"spread", "SHARE", .help = "how far the soil's numbers are uncertain: standard deviation of their logarithms, as in 0.15; or three, of cohesion, friction and "
				    "Bekker's moduli", .preset = "0"},
	{"samples", "N", .help = "soils of the spread", .preset = "12"},
	{"seed", "S", .help = "of the spread", .preset = "1"},
	{"spacing", "M", .help = "distance between the rig's posts", .unit = "m",
	 .preset = "a tenth of a wheel's width or radius, whichever is less"},
	{"window", "X0,Y0,X1,Y1", .help = "the part that is judged, east and north of the south-west post", .unit = "m", .preset = "all"},
	{"window-srs", "SRS", .help = "what --window is in; store: the store's own; degrees: longitude and latitude on its body",
	 .preset = "metres from the south-west post"},
	{"json", .help = "one JSON object: shares, and of each slope and heading the verdict, slip, crab angle, torque, sinkage; of each slope P(GO)"},
	{.name = NULL},
};

struct asked {
	const char *store, *out, *model, *scene;
	struct soil_given soil;
	int layer;
	bool json;
	double gravity, spread[3], spacing; /* spread: of cohesion, friction, stiffness */
	int64_t samples, seed;
	char name[64];           /* of the vehicle */
	struct trials_vehicle vehicle;
	struct mobility_table *table;
	struct mobility_column *columns; /* of the spread's soils */
	struct mobility_curves *curves;
	struct progress progress;
	struct export_request window;
};

/* --- the vehicle --- */

static enum status take_vehicle(const struct scene *scene, struct asked *asked)
{
	struct vehicle_outline outline;
	struct trials_vehicle *vehicle = &asked->vehicle;
	TRY(vehicle_outline(scene, 0, &outline));
	snprintf(asked->name, sizeof asked->name, "%s", outline.name);
	*vehicle = (struct trials_vehicle){.mass = outline.mass, .height = outline.height, .clearance = outline.clearance, .wheel_count = outline.wheel_count};
	for (size_t i = 0; i < outline.wheel_count && i < TRIALS_WHEELS_MOST; i++) {
		const struct vehicle_wheel *wheel = &outline.wheels[i];
		vehicle->wheels[i] = (struct trials_wheel){wheel->x, wheel->y, wheel->radius, wheel->width, wheel->driven, wheel->torque_most};
	}
	const char *problem = trials_vehicle_problem(vehicle);
	return problem == NULL ? STATUS_OK : fail_with(STATUS_INPUT, "mobility: %s: %s", asked->name, problem);
}

/* A scene of the model alone. */
static enum status load_model(const struct asked *asked, struct scene **scene)
{
	char *text = NULL;
	size_t length;
	FILE *stream = open_memstream(&text, &length);
	TRY_MEM(stream, "a scene");
	fprintf(stream, "scene: 1\ntime_step: 0.0001\nend_time: 1\nsoil: {name: dry_sand}\nredistribute: {model: scm}\n"
			"vehicles:\n  - {name: vehicle, model: \"%s\", start: {at: [0, 0]}}\n", asked->model);
	if (fclose(stream) != 0) {
		free(text);
		return fail_memory("a scene");
	}
	enum status status = scene_load_text(text, NULL, NULL, 0, SCENE_COMMAND, scene);
	free(text);
	return status;
}

/* The scene of a model has no name and no lines that its user knows. */
static enum status fail_of_model(enum status status)
{
	char why[512];
	const char *reason = scene_text_reason(failure_message());
	if (status != STATUS_INPUT || reason == failure_message())
		return status;
	snprintf(why, sizeof why, "%s", reason);
	return fail_with(status, "mobility: %.500s", why);
}

/* Takes the vehicle, and of a scene the soil and the gravity that no option gave. */
static enum status take_scene(const struct scene *scene, struct asked *asked)
{
	if (asked->scene != NULL && isnan(asked->gravity))
		asked->gravity = scene->gravity;
	if (isnan(asked->gravity))
		asked->gravity = EARTH;
	if (asked->scene != NULL && asked->soil.text == NULL)
		TRY(soil_given_of_scene(scene, asked->scene, &asked->soil));
	return take_vehicle(scene, asked);
}

static enum status read_vehicle(struct asked *asked)
{
	struct scene *scene = NULL;
	enum status status;
	TRY_OR(done, asked->scene != NULL ? scene_load(asked->scene, NULL, 0, &scene) : load_model(asked, &scene));
	TRY_OR(done, take_scene(scene, asked));
done:
	scene_destroy(scene);
	TRY(status != STATUS_OK && asked->scene == NULL ? fail_of_model(status) : status);
	if (asked->soil.text == NULL)
		return fail_with(STATUS_USAGE, "mobility: --soil is missing; give a named soil (docs/SOILS.md), a file, or numbers in braces");
	return STATUS_OK;
}

static void tell(void *user, const char *text)
{
	(void)user;
	note("%s", text);
}

/* Notes numbers of the soil that are probably in a wrong unit. */
static enum status check_units(const struct asked *asked)
{
	struct scene *scene;
	TRY(scene_soil_alone(asked->soil.text, &scene));
	scene_advise_units(scene, tell, NULL);
	scene_destroy(scene);
	return STATUS_OK;
}

/* --- its tables --- */

static enum status progress_rig(void *user, int64_t done, int64_t total)
{
	struct asked *asked = user;
	return progress_step(&asked->progress, done, total);
}

static enum status friction_of(const char *soil, double *degrees)
{
	const char *key;
	double value;
	struct scene *scene;
	TRY(scene_soil_alone(soil, &scene));
	*degrees = NAN;
	for (size_t i = 0; scene_soil_number(&scene->soils[0], i, &key, &value); i++)
		if (strcmp(key, "friction_angle") == 0)
			*degrees = value;
	scene_destroy(scene);
	return STATUS_OK;
}

/* Fills the curves of a soil. folder: for the rig's files. */
static enum status measure_in(struct asked *asked, const char *folder, const char *soil, const char *what)
{
	double angle;
	TRY(friction_of(soil, &angle));
	const struct mobility_rig rig = {.soil = soil, .friction_angle = angle, .gravity = asked->gravity, .spacing = asked->spacing, .folder = folder,
					 .stop = &interrupted, .progress = progress_rig, .user = asked};
	progress_start(&asked->progress, what, "runs");
	const enum status status = trials_measure_wheels(&asked->vehicle, &rig, asked->curves);
	progress_end(&asked->progress);
	return status;
}

/* Fills the curves. factor: of the soil's numbers; NULL: the soil as it is. */
static enum status measure(struct asked *asked, const double *factor)
{
	const char *soil = asked->soil.text;
	char *varied = NULL;
	if (factor != NULL) {
		soil = varied = scene_soil_varied(asked->soil.text, factor);
		if (varied == NULL)
			return STATUS_INPUT;
	}
	const char *temporary = getenv("TMPDIR");
	char folder[4096];
	snprintf(folder, sizeof folder, "%s/furrow-mobility-XXXXXX", temporary != NULL && *temporary != '\0' ? temporary : "/tmp");
	enum status status;
	TRY_OR(done, mkdtemp(folder) != NULL ? STATUS_OK : fail_with(STATUS_FAILED, "%s: cannot be made; free some disk space", folder));
	status = measure_in(asked, folder, soil, factor == NULL ? "rig" : "rig, spread");
	rmdir(folder);
done:
	mem_free(varied);
	return status;
}

static enum status make_tables(struct asked *asked)
{
	double factors[MOBILITY_SAMPLES_MOST][3];
	trials_spread_factors(asked->spread, asked->seed, (size_t)asked->samples, factors);
	asked->table = mem_calloc(1, sizeof *asked->table);
	asked->columns = mem_calloc((size_t)asked->samples + 1, sizeof *asked->columns);
	asked->curves = mem_calloc(1, sizeof *asked->curves);
	TRY_MEM(asked->table != NULL && asked->columns != NULL && asked->curves != NULL, "tables of slopes");
	TRY(measure(asked, NULL));
	trials_table_make(&asked->vehicle, asked->curves, asked->gravity, asked->table);
	for (int64_t i = 0; i < asked->samples; i++) {
		TRY(measure(asked, factors[i]));
		trials_column_make(&asked->vehicle, asked->curves, asked->gravity, &asked->columns[i]);
	}
	return STATUS_OK;
}

/* --- the command --- */

/* Posts at which the slope over the vehicle's length is taken: central differences reach over two spacings. */
static int level_for(const struct extent *extent, double length)
{
	int level = 0;
	while (level < extent_coarsest(extent) && 2 * extent_spacing(extent, level + 1) <= length)
		level++;
	return level;
}

/* Refuses a terrain of which nothing could be known. The rig would take a minute before that is told. */
static enum status check_posts(const struct asked *asked, const struct store_meta *meta)
{
	const double length = trials_vehicle_length(&asked->vehicle);
	if (meta->extent.spacing <= length)
		return STATUS_OK;
	return fail_with(STATUS_INPUT, "mobility: %s: its posts are %g m apart, and %s is %.2g m long, so all would be unknown; give a terrain with posts of "
				       "at most %s m", asked->store, meta->extent.spacing, asked->name, length, number_at_most(length, 2).text);
}

/* Finds the posts that are judged, and their level. A picture has at most SIDE_MOST cells on a side. */
static enum status find_cells(struct asked *asked, const struct store_meta *meta, int *level, struct post_rect *rect)
{
	const int own = level_for(&meta->extent, trials_vehicle_length(&asked->vehicle));
	enum chart_format format;
	const bool picture = chart_path_format(asked->out, &format);
	for (asked->window.level = own; ; asked->window.level++) {
		TRY(export_find_rect(&asked->window, &meta->extent, rect));
		if (!picture || (rect->x1 - rect->x0 <= SIDE_MOST && rect->y1 - rect->y0 <= SIDE_MOST))
			break;
	}
	*level = (int)asked->window.level;
	if (*level > own)
		note("%s: its cells are %g m wide, so that it is no larger than %d; slopes are taken over twice that, not over the vehicle; give a --window or "
		     "a .tif", asked->out, extent_spacing(&meta->extent, *level), SIDE_MOST);
	return STATUS_OK;
}

static enum status draw(struct asked *asked, struct store *store, int level, struct post_rect rect)
{
	const struct store_meta *meta = store_meta(store);
	struct mobility_map map = {.store = asked->store, .path = asked->out, .vehicle = asked->name, .soil = asked->soil.label,
				   .mass = asked->vehicle.mass, .gravity = asked->gravity, .seed = asked->seed, .table = asked->table,
				   .columns = asked->columns, .samples = (size_t)asked->samples, .meta = meta, .layer = (enum mobility_layer)asked->layer,
				   .level = level, .rect = rect};
	memcpy(map.spread, asked->spread, sizeof map.spread);
	chart_sun_of(CHART_AZIMUTH, CHART_ALTITUDE, &map.sun);
	enum status status;
	TRY_OR(done, store_reader_create(store, &map.reader));
	TRY_OR(done, mobility_draw(&map));
	if (asked->json)
		TRY_OR(done, mobility_print_json(&map));
	else
		mobility_print(&map);
done:
	store_reader_destroy(map.reader);
	return status;
}

/* One share for all three numbers, or three. */
static enum status read_spread(const struct arguments *arguments, double spread[3])
{
	const char *given = arguments_text(arguments, "spread");
	bool three = given != NULL && strchr(given, ',') != NULL;
	if (three)
		return arguments_numbers(arguments, "spread", 3, spread, &three);
	enum status status = arguments_number(arguments, "spread", 0, 1, &spread[0]);
	spread[1] = spread[2] = spread[0];
	return status;
}

/* The layer is class, or with a spread probability, where it is not given. */
static enum status read_layer(const struct arguments *arguments, struct asked *asked)
{
	enum chart_format format;
	const bool picture = chart_path_format(asked->out, &format), spread = asked->spread[0] > 0 || asked->spread[1] > 0 || asked->spread[2] > 0;
	asked->layer = !picture ? LAYER_SLIP : spread ? LAYER_PROBABILITY : LAYER_CLASS;
	TRY(arguments_choice(arguments, "layer", &asked->layer));
	if (picture && asked->layer != LAYER_CLASS && asked->layer != LAYER_PROBABILITY)
		return fail_with(STATUS_USAGE, "mobility: --layer %s: is not for a picture; give a .tif, or class or probability", mobility_layers[asked->layer]);
	if (asked->layer == LAYER_PROBABILITY && !spread)
		return fail_with(STATUS_USAGE, "mobility: --layer probability: needs soils that differ; give --spread, as in 0.15");
	asked->samples = spread ? asked->samples : 0;
	return STATUS_OK;
}

static enum status read_arguments(const struct arguments *arguments, struct asked *asked)
{
	asked->store = arguments_at(arguments, 0);
	asked->out = arguments_text(arguments, "o");
	asked->model = arguments_text(arguments, "vehicle");
	asked->scene = arguments_text(arguments, "scene");
	asked->json = arguments_flag(arguments, "json");
	enum chart_format format;
	if (asked->out == NULL || !(chart_path_format(asked->out, &format) || dem_path_ends(asked->out, ".tif")))
		return fail_with(STATUS_USAGE, "mobility: -o is missing or ends in neither .tif nor .png, .svg, .pdf; give such a file");
	TRY(aside_check(asked->out));
	if ((asked->model == NULL) == (asked->scene == NULL))
		return fail_with(STATUS_USAGE, "mobility: --vehicle and --scene are both given, or neither; give one of them");
	TRY(arguments_number(arguments, "gravity", 1e-3, 1e3, &asked->gravity));
	TRY(read_spread(arguments, asked->spread));
	for (int i = 0; i < 3; i++)
		if (!(asked->spread[i] >= 0 && asked->spread[i] <= 1))
			return fail_with(STATUS_USAGE, "mobility: --spread: %g is out of range; give 0 to 1", asked->spread[i]);
	TRY(arguments_number(arguments, "spacing", 1e-4, 1, &asked->spacing));
	TRY(arguments_integer(arguments, "samples", 1, MOBILITY_SAMPLES_MOST, &asked->samples));
	TRY(arguments_integer(arguments, "seed", 0, INT64_MAX, &asked->seed));
	TRY(export_read_window(arguments, &asked->window));
	if (arguments_text(arguments, "soil") != NULL)
		TRY(soil_given_take(arguments_text(arguments, "soil"), &asked->soil));
	return read_layer(arguments, asked);
}

static enum status run(const struct arguments *arguments)
{
	struct store *store = NULL;
	struct asked asked = {.gravity = NAN, .samples = 12, .seed = 1, .window = {.command = "mobility"}};
	int level = 0;
	struct post_rect rect = {0, 0, 0, 0};
	enum status status;
	TRY_OR(done, read_arguments(arguments, &asked));
	TRY_OR(done, store_open(asked.store, &(struct store_options){.mode = STORE_READ}, &store));
	TRY_OR(done, read_vehicle(&asked));
	TRY_OR(done, check_posts(&asked, store_meta(store)));
	TRY_OR(done, export_place_window(&asked.window, store_meta(store)));
	TRY_OR(done, find_cells(&asked, store_meta(store), &level, &rect));
	TRY_OR(done, check_units(&asked));
	interrupt_catch();
	TRY_OR(done, make_tables(&asked));
	TRY_OR(done, draw(&asked, store, level, rect));
done:
	store_close(store);
	mem_free(asked.table);
	mem_free(asked.columns);
	mem_free(asked.curves);
	soil_given_finish(&asked.soil);
	return status;
}

const struct command command_mobility = {
	.name = "mobility",
	.summary = "where a vehicle can drive: slip, steepest heading, go or no-go",
	.arguments = COMMAND_ARGUMENTS(COMMAND_STORE),
	.options = options,
	.details = "The rig measures each size of wheel under five loads and at twelve slips, those that follow others in their "
		   "ruts. On the slope of each cell, taken over the vehicle's length, the wheels bear what a rigid body on equal "
		   "springs gives them, all driven wheels slip alike, and the least slip is sought at which they pull as much as "
		   "the weight does down the slope. Across a slope its nose points up the slope, so that the soil's side forces "
		   "hold it.\n\n"
		   "It does not go where no slip pulls enough, it slides down, a motor is too weak, a wheel has no load left, it "
		   "sinks to its belly, or a wheel digs itself in. Unknown is what lies beyond the curves, and ground steeper than "
		   "the soil's friction angle. A terrain whose posts are farther apart than the vehicle is long is refused.\n\n"
		   "Layers:\n\n"
		   "  slip         straight up, at constant speed\n"
		   "  steepest     heading in degrees: 0 along the slope, 90 straight up\n"
		   "  class        0 no-go, 1 go, 2 at some headings, 3 unknown\n"
		   "  reason       why it does not go\n"
		   "  probability  of going straight up, of the soils of the spread\n\n"
		   "With --spread a map shows the probability of going straight up, of a Latin hypercube of soils.\n\n"
		   "It is for constant speed on ground that is even over the vehicle's length: steps, ditches and rocks are not "
		   "seen. For those drive the way with furrow drive. Map and drives rest on the same soil model: that they agree says that both are consistent, not that they "
		   "are true.\n",
	.examples = "furrow mobility site.furrow --vehicle rover.xml --soil lunar -o go.png\n"
		    "furrow mobility site.furrow --scene scene.yaml -o go.tif --window 0,0,400,300\n",
	.see = "furrow-rig(1), scene(5)",
	.run = run,
};
