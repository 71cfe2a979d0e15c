/* furrow mobility: where a vehicle can drive, as a raster or as a map. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "dem/dem.h"
#include "mobility.h"

#define ROWS 64
#define SIDE_MOST 4096 /* cells of a map */
#define EARTH 9.81

static const struct command_option options[] = {
	{"o", "OUT", "a .tif of one layer, or a .png: a map of classes"},
	{"vehicle", "MODEL", "MJCF or URDF of the vehicle; its soil geoms are those that collide"},
	{"scene", "SCENE", "in place of --vehicle: a scene, with its first vehicle, soil and gravity"},
	{"soil", "SOIL", "a named soil, or a scene's soil in braces"},
	{"gravity", "G", "m/s2 (9.81; the scene's)"},
	{"layer", "LAYER", "of a .tif: slip (default; straight up, at constant speed), steepest (heading in degrees: 0 along the slope, 90 straight up), "
			   "class (0 no-go, 1 go, 2 at some headings, 3 unknown), probability (of going straight up) or reason"},
	{"spread", "SHARE", "how far the soil's numbers are uncertain: standard deviation as a share, as in 0.15 (0)"},
	{"samples", "N", "soils of the spread (12)"},
	{"seed", "S", "of the spread (1)"},
	{"spacing", "M", "metres between the rig's posts (a twentieth of a wheel's width or radius)"},
	{NULL, NULL, NULL},
};

enum layer { LAYER_SLIP, LAYER_STEEPEST, LAYER_CLASS, LAYER_PROBABILITY, LAYER_REASON };
static const char *const layers[] = {"slip", "steepest", "class", "probability", "reason", NULL};
static const char *const classes[CLASSES] = {"no-go", "go", "some headings", "unknown"};

struct asked {
	const char *store, *out, *model, *scene, *soil;
	char *soil_text;          /* owned: the scene's soil */
	int layer;
	double gravity, spread, spacing;
	int64_t samples, seed;
	struct vehicle_outline vehicle;
	struct mobility_table *tables;
	struct mobility_curves *curves;
	struct progress progress;
	const char *stage;
};

enum mobility_class mobility_class_of(const struct mobility_slope *slope)
{
	if (slope->every)
		return CLASS_GO;
	if (!isnan(slope->steepest))
		return CLASS_SOME;
	return mobility_is_unknown(slope->up.reason) ? CLASS_UNKNOWN : CLASS_NO_GO;
}

/* --- the vehicle --- */

static enum status take_vehicle(const struct scene *scene, struct asked *asked)
{
	enum status status = vehicle_outline(scene, 0, &asked->vehicle);
	if (status != STATUS_OK)
		return status;
	const char *problem = mobility_vehicle_problem(&asked->vehicle);
	return problem == NULL ? STATUS_OK : fail_with(STATUS_INPUT, "mobility: %s: %s", asked->vehicle.name, problem);
}

/* A scene of the model alone. */
static enum status load_model(const struct asked *asked, struct scene **scene)
{
	char *text = NULL;
	size_t length;
	FILE *stream = open_memstream(&text, &length);
	if (stream == NULL)
		return fail_memory("a scene");
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

static enum status read_vehicle(struct asked *asked)
{
	struct scene *scene = NULL;
	enum status status = asked->scene != NULL ? scene_load(asked->scene, NULL, 0, &scene) : load_model(asked, &scene);
	if (status != STATUS_OK)
		return status;
	if (asked->scene != NULL && isnan(asked->gravity))
		asked->gravity = scene->gravity;
	if (asked->scene != NULL && asked->soil == NULL) {
		asked->soil_text = mem_strdup(scene->soil_names[0]);
		asked->soil = asked->soil_text;
	}
	if (isnan(asked->gravity))
		asked->gravity = EARTH;
	status = take_vehicle(scene, asked);
	scene_destroy(scene);
	if (status == STATUS_OK && asked->soil == NULL)
		status = fail_with(STATUS_USAGE, "mobility: --soil is missing; give a named soil (docs/SOILS.md), or numbers in braces");
	return status;
}

/* --- its tables --- */

static enum status progress_rig(void *user, int64_t done, int64_t total)
{
	struct asked *asked = user;
	return progress_step(&asked->progress, done, total);
}

/* A number of a standard normal distribution, by Box and Muller, from a fixed sequence. */
static double normal(uint64_t *state)
{
	double uniform[2];
	for (int i = 0; i < 2; i++) {
		*state = *state * 6364136223846793005u + 1442695040888963407u;
		uniform[i] = ((double)(*state >> 11) + 0.5) * 0x1p-53;
	}
	return sqrt(-2 * log(uniform[0])) * cos(2 * M_PI * uniform[1]);
}

/* Factors are lognormal, so that none is negative. */
static enum status measure(struct asked *asked, size_t table, uint64_t *state)
{
	const char *soil = asked->soil;
	char *varied = NULL;
	if (table > 0) {
		double factor[3];
		for (int i = 0; i < 3; i++)
			factor[i] = exp(asked->spread * normal(state));
		soil = varied = mobility_soil_varied(asked->soil, factor);
		if (varied == NULL)
			return STATUS_INPUT;
	}
	const char *temporary = getenv("TMPDIR");
	char folder[4096];
	snprintf(folder, sizeof folder, "%s/furrow-mobility-XXXXXX", temporary != NULL && *temporary != '\0' ? temporary : "/tmp");
	enum status status = STATUS_OK;
	if (mkdtemp(folder) == NULL)
		status = fail_with(STATUS_FAILED, "%s: cannot be made; free some disk space", folder);
	const struct mobility_rig rig = {.soil = soil, .gravity = asked->gravity, .spacing = asked->spacing, .folder = folder, .stop = &interrupted,
					 .progress = progress_rig, .user = asked};
	progress_start(&asked->progress, table == 0 ? "rig" : "rig, spread", "runs");
	if (status == STATUS_OK) {
		status = mobility_measure(&asked->vehicle, &rig, asked->curves);
		rmdir(folder);
	}
	progress_end(&asked->progress);
	mem_free(varied);
	if (status == STATUS_OK)
		mobility_table_make(&asked->vehicle, asked->curves, asked->gravity, &asked->tables[table]);
	return status;
}

static enum status make_tables(struct asked *asked, size_t count)
{
	uint64_t state = (uint64_t)asked->seed * 0x9e3779b97f4a7c15u + 1;
	asked->tables = mem_calloc(count, sizeof *asked->tables);
	asked->curves = mem_calloc(1, sizeof *asked->curves);
	if (asked->tables == NULL || asked->curves == NULL)
		return fail_memory("tables of slopes");
	enum status status = STATUS_OK;
	for (size_t i = 0; i < count && status == STATUS_OK; i++)
		status = measure(asked, i, &state);
	return status;
}

/* --- cells --- */

/* Posts at which the slope over the vehicle's length is taken: central differences reach over two spacings. */
static int level_for(const struct extent *extent, double length)
{
	int level = 0;
	while (level < extent_coarsest(extent) && 2 * extent_spacing(extent, level + 1) <= length)
		level++;
	return level;
}

enum status mobility_cells(const struct mobility_map *map, int64_t y0, int64_t y1, struct mobility_cell *cells)
{
	const int64_t width = map->rect.x1 - map->rect.x0, rows = y1 - y0;
	const size_t room = (size_t)(width + 2) * (size_t)(rows + 2);
	double *heights = mem_alloc(room, sizeof *heights), *slopes = mem_alloc(2 * room, sizeof *slopes);
	enum status status = heights != NULL && slopes != NULL ? STATUS_OK : fail_memory("cells");
	if (status == STATUS_OK)
		status = store_read_posts(map->reader, STORE_SURFACE, map->level, (struct post_rect){map->rect.x0 - 1, y0 - 1, map->rect.x1 + 1, y1 + 1},
					  heights);
	if (status == STATUS_OK)
		render_slopes(heights, width, rows, extent_spacing(&map->meta->extent, map->level), slopes, slopes + room);
	for (int64_t i = 0; i < width * rows && status == STATUS_OK; i++) {
		struct mobility_cell *cell = &cells[i];
		const double steep = hypot(slopes[i], slopes[room + (size_t)i]), slope = atan(steep) * 180 / M_PI;
		cell->slope = mobility_table_at(&map->tables[0], slope);
		if (map->coarse && !isnan(slope))
			cell->slope = (struct mobility_slope){{MOBILITY_TOO_COARSE, NAN, NAN, NAN}, NAN, false};
		double goes = 0;
		for (size_t t = 0; t < map->table_count; t++)
			goes += mobility_table_at(&map->tables[t], slope).up.reason == MOBILITY_GO;
		cell->probability = isnan(slope) || map->coarse ? (double)NAN : goes / (double)map->table_count;
		cell->shade = render_shade(&map->sun, slopes[i], slopes[room + (size_t)i]);
	}
	mem_free(heights);
	mem_free(slopes);
	return status;
}

static double value_of(const struct mobility_cell *cell, int layer)
{
	switch ((enum layer)layer) {
	case LAYER_SLIP: return cell->slope.up.slip;
	case LAYER_STEEPEST: return cell->slope.steepest;
	case LAYER_CLASS: return cell->slope.up.reason == MOBILITY_NO_GROUND ? (double)NAN : (double)mobility_class_of(&cell->slope);
	case LAYER_PROBABILITY: return cell->probability;
	case LAYER_REASON: break;
	}
	return cell->slope.up.reason == MOBILITY_NO_GROUND ? (double)NAN : (double)cell->slope.up.reason;
}

/* Counts the classes, and writes the layer if there is a writer. */
static enum status go_through(const struct mobility_map *map, int layer, struct dem_writer *writer, double shares[CLASSES])
{
	const int64_t width = map->rect.x1 - map->rect.x0;
	struct mobility_cell *cells = mem_alloc((size_t)width * ROWS, sizeof *cells);
	double *values = mem_alloc((size_t)width * ROWS, sizeof *values), ground = 0;
	struct progress progress;
	enum status status = cells != NULL && values != NULL ? STATUS_OK : fail_memory("cells");
	progress_start(&progress, map->path, "rows");
	for (int64_t y = map->rect.y0; y < map->rect.y1 && status == STATUS_OK; y += ROWS) {
		const int64_t end = y + ROWS < map->rect.y1 ? y + ROWS : map->rect.y1;
		status = mobility_cells(map, y, end, cells);
		for (int64_t i = 0; i < (end - y) * width && status == STATUS_OK; i++) {
			values[i] = value_of(&cells[i], layer);
			if (cells[i].slope.up.reason == MOBILITY_NO_GROUND)
				continue;
			shares[mobility_class_of(&cells[i].slope)]++;
			ground++;
		}
		if (status == STATUS_OK && writer != NULL)
			status = dem_writer_rows(writer, end - y, values);
		if (status == STATUS_OK)
			status = progress_step(&progress, end - map->rect.y0, map->rect.y1 - map->rect.y0);
	}
	progress_end(&progress);
	for (int i = 0; i < CLASSES; i++)
		shares[i] = ground > 0 ? shares[i] / ground : 0;
	mem_free(cells);
	mem_free(values);
	return status;
}

static enum status write_raster(const struct mobility_map *map, int layer, double shares[CLASSES])
{
	const double spacing = extent_spacing(&map->meta->extent, map->level);
	const struct dem_raster raster = {
		.path = map->path,
		.width = map->rect.x1 - map->rect.x0,
		.height = map->rect.y1 - map->rect.y0,
		.type = DEM_FLOAT32,
		.srs = map->meta->srs,
		.west = map->meta->origin[0],
		.south = map->meta->origin[1],
		.spacing = spacing,
		.has_nodata = true,
		.nodata = NAN,
	};
	struct dem_writer *writer = NULL;
	enum status status = dem_writer_create(&raster, &writer);
	if (status == STATUS_OK)
		status = go_through(map, layer, writer, shares);
	if (status == STATUS_OK)
		status = dem_writer_publish(writer);
	dem_writer_destroy(writer);
	return status;
}

/* --- the command --- */

/* The steepest slope of a table at which it goes straight up, or along the slope; NaN: at none. */
static double steepest(const struct mobility_table *table, int heading)
{
	double slope = NAN;
	for (int i = 0; i < MOBILITY_SLOPES && table->verdicts[i][heading].reason == MOBILITY_GO; i++)
		slope = i * MOBILITY_SLOPE_STEP;
	return slope;
}

static const char *ends_by(const struct mobility_table *table, int heading)
{
	for (int i = 0; i < MOBILITY_SLOPES; i++)
		if (table->verdicts[i][heading].reason != MOBILITY_GO)
			return mobility_reason_names[table->verdicts[i][heading].reason];
	return "the table's end";
}

static void print_summary(const struct asked *asked, const struct mobility_map *map, const double shares[CLASSES])
{
	static const char *const ways[] = {"straight up", "along the slope"};
	static const int headings[] = {0, MOBILITY_HEADINGS - 1};
	printf("%s, %g kg, in %s at %g m/s2\n", asked->vehicle.name, asked->vehicle.mass, asked->soil, asked->gravity);
	for (int i = 0; i < 2; i++) {
		const double slope = steepest(&map->tables[0], headings[i]);
		if (isnan(slope))
			printf("%s: not even on level ground (%s)\n", ways[i], ends_by(&map->tables[0], headings[i]));
		else
			printf("%s: up to %.1f degrees, slip %.2f there; steeper: %s\n", ways[i], slope,
			       map->tables[0].verdicts[(int)(slope / MOBILITY_SLOPE_STEP)][headings[i]].slip, ends_by(&map->tables[0], headings[i]));
	}
	for (int i = 0; i < CLASSES; i++)
		printf("%s%s %.1f %%", i > 0 ? ", " : "of the terrain: ", classes[i], 100 * shares[i]);
	printf("\n%s: %lld x %lld cells of %g m\n", map->path, (long long)(map->rect.x1 - map->rect.x0), (long long)(map->rect.y1 - map->rect.y0),
	       extent_spacing(&map->meta->extent, map->level));
}

static enum status draw(struct asked *asked, struct store *store, size_t tables)
{
	const struct store_meta *meta = store_meta(store);
	const double length = mobility_length(&asked->vehicle);
	struct mobility_map map = {.store = asked->store, .path = asked->out, .vehicle = asked->vehicle.name, .soil = asked->soil, .tables = asked->tables,
				   .table_count = tables, .meta = meta, .level = level_for(&meta->extent, length),
				   .coarse = meta->extent.spacing > length};
	double shares[CLASSES] = {0};
	const bool picture = dem_path_ends(asked->out, ".png");
	while (picture && extent_posts(meta->extent.width > meta->extent.height ? meta->extent.width : meta->extent.height, map.level) > SIDE_MOST)
		map.level++;
	map.rect = (struct post_rect){0, 0, extent_posts(meta->extent.width, map.level), extent_posts(meta->extent.height, map.level)};
	render_sun_of(RENDER_AZIMUTH, RENDER_ALTITUDE, &map.sun);
	enum status status = store_reader_create(store, &map.reader);
	if (status == STATUS_OK)
		status = picture ? go_through(&map, LAYER_CLASS, NULL, shares) : write_raster(&map, asked->layer, shares);
	if (status == STATUS_OK && picture)
		status = mobility_picture(&map, shares);
	if (status == STATUS_OK)
		print_summary(asked, &map, shares);
	if (status == STATUS_OK && map.coarse)
		note("%s: its posts are %g m apart, and the vehicle is %g m long: all is unknown; give a finer terrain", asked->store,
		     meta->extent.spacing, length);
	store_reader_destroy(map.reader);
	return status;
}

static enum status read_arguments(const struct arguments *arguments, struct asked *asked)
{
	asked->store = arguments_at(arguments, 0);
	asked->out = arguments_text(arguments, "o");
	asked->model = arguments_text(arguments, "vehicle");
	asked->scene = arguments_text(arguments, "scene");
	asked->soil = arguments_text(arguments, "soil");
	enum status status = arguments_expect(arguments, 1, 1);
	if (status == STATUS_OK && (asked->out == NULL || !(dem_path_ends(asked->out, ".png") || dem_path_ends(asked->out, ".tif"))))
		status = fail_with(STATUS_USAGE, "mobility: -o is missing or ends in neither .tif nor .png; give such a file");
	if (status == STATUS_OK && (asked->model == NULL) == (asked->scene == NULL))
		status = fail_with(STATUS_USAGE, "mobility: --vehicle and --scene are both given, or neither; give one of them");
	if (status == STATUS_OK)
		status = arguments_choice(arguments, "layer", layers, &asked->layer);
	if (status == STATUS_OK)
		status = arguments_number(arguments, "gravity", 1e-3, 1e3, &asked->gravity);
	if (status == STATUS_OK)
		status = arguments_number(arguments, "spread", 0, 1, &asked->spread);
	if (status == STATUS_OK)
		status = arguments_number(arguments, "spacing", 1e-4, 1, &asked->spacing);
	if (status == STATUS_OK)
		status = arguments_integer(arguments, "samples", 1, MOBILITY_SAMPLES_MOST - 1, &asked->samples);
	return status == STATUS_OK ? arguments_integer(arguments, "seed", 0, INT64_MAX, &asked->seed) : status;
}

static enum status run(const struct arguments *arguments)
{
	struct store *store = NULL;
	struct asked asked = {.gravity = NAN, .samples = 12, .seed = 1};
	enum status status = read_arguments(arguments, &asked);
	const size_t tables = asked.spread > 0 ? 1 + (size_t)asked.samples : 1;
	if (status == STATUS_OK)
		status = store_open(asked.store, &(struct store_options){.mode = STORE_READ}, &store);
	if (status == STATUS_OK)
		status = read_vehicle(&asked);
	if (status == STATUS_OK) {
		interrupt_catch();
		status = make_tables(&asked, tables);
	}
	if (status == STATUS_OK)
		status = draw(&asked, store, tables);
	store_close(store);
	mem_free(asked.tables);
	mem_free(asked.curves);
	mem_free(asked.soil_text);
	return status;
}

const struct command command_mobility = {
	.name = "mobility",
	.usage = "mobility STORE --vehicle MODEL|--scene SCENE --soil SOIL -o OUT.tif|OUT.png [--layer LAYER] [--spread SHARE] [--gravity G]",
	.summary = "where a vehicle can drive: slip, steepest heading, go or no-go",
	.details = "The rig measures each kind of wheel under six loads and fifteen slips. On the slope of each cell, taken over the vehicle's length, the\n"
		   "wheels bear what a rigid body on equal springs gives them, all driven wheels slip alike, and the least slip is sought at which\n"
		   "they pull as much as the weight does down the slope. It does not go where no slip pulls enough, a motor is too weak, a wheel has\n"
		   "no load left, it sinks to its belly, or a wheel digs itself in. Unknown is what lies beyond the curves, on ground steeper than the\n"
		   "soil's friction angle, and where the terrain's posts are farther apart than the vehicle is long.\n"
		   "It is for constant speed on ground that is even over the vehicle's length: steps, ditches and rocks are not seen. Map and drives rest\n"
		   "on the same soil model: that they agree says that both are consistent, not that they are true.\n",
	.options = options,
	.run = run,
};
