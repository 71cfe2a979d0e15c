/* furrow query: heights at points, and rays. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "command.h"
#include "dem/dem.h"
#include "json.h"
#include "place.h"
#include "relief_told.h"
#include "resident/resident.h"
#include "store/store.h"

static const struct command_option options[] = {
	{"ray", "X,Y,Z,DX,DY,DZ", .help = "where a ray from there first meets the ground, from above or below", .repeats = true},
	{"srs", "SRS", .help = "what X and Y are in; store: the store's own; degrees: longitude and latitude on its body", .preset = "metres from the south-west post"},
	{"json", .help = "one JSON object: points, each with height, base, offset, surface, normal, nodata, soil (in metres but for dirt, 0 to 255, and bent and torn plants, shares), and local: metres from the south-west post, as scenes and --window take them"},
	{.name = NULL},
};

struct asking {
	struct store_reader *reader;
	struct newest *newest;
	const struct store_meta *meta;
	const char *srs;
	cJSON *points, *rays; /* NULL: print lines */
	cJSON *only;          /* the last one */
	bool guessed;         /* a hint was given */
	struct plane_marks marks; /* the store's time */
};

/* What a line or an option says: so many numbers. */
enum { POINT = 2, RAY = 6 };

static enum status to_local(const struct asking *asking, double *x, double *y)
{
	return place_local(asking->meta, asking->srs, "query", "--srs", x, y);
}

/* From the store's metres to what was asked in. */
static enum status from_local(const struct asking *asking, double *x, double *y)
{
	if (asking->srs == NULL)
		return STATUS_OK;
	*x += asking->meta->origin[0];
	*y += asking->meta->origin[1];
	return strcmp(asking->srs, "store") != 0 ? dem_transform(asking->meta->srs, asking->srs, 1, x, y) : STATUS_OK;
}

/* Tells, once, if a point outside would be inside in other coordinates. */
static void tell_outside(struct asking *asking, double x, double y)
{
	char hint[240];
	if (asking->guessed || !place_guess(asking->meta, asking->srs, "--srs", 1, &x, &y, hint, sizeof hint))
		return;
	asking->guessed = true;
	note("query: %.15g %.15g: is outside the terrain, but %s", x, y, hint);
}

/* Returns the shades that are left of a mark that fades. until: s of the store's time. */
static int32_t left_of(const struct asking *asking, enum plane plane, double until)
{
	return plane_mark_left((int32_t)ldexp(until, PLANE_TIME_BITS), asking->marks.now, plane_mark_whole(&asking->marks, plane));
}

static enum status ask_point(struct asking *asking, double x, double y)
{
	struct store_sample sample;
	double local_x = x, local_y = y;
	TRY(to_local(asking, &local_x, &local_y));
	TRY(store_sample(asking->reader, local_x, local_y, &sample));
	bool nodata = sample.nodata || sample.outside;
	const unsigned healing = (unsigned)left_of(asking, PLANE_HEALED, sample.healed), dirt = sample.disturbance > healing ? sample.disturbance : healing;
	if (sample.outside)
		tell_outside(asking, x, y);
	if (asking->points == NULL) {
		if (nodata)
			printf("%.15g %.15g %s\n", x, y, sample.outside ? "outside" : "nodata");
		else
			printf("%.15g %.15g height %.6f base %.6f offset %.6f dirt %u\n", x, y, sample.height,
			       sample.base, sample.offset, dirt);
		return STATUS_OK;
	}
	struct resident_height surface;
	TRY(resident_newest_heights(asking->newest, &(struct resident_point){local_x, local_y}, 1, &surface));
	cJSON *point = cJSON_CreateObject();
	json_number(point, "x", x);
	json_number(point, "y", y);
	json_pair(point, "local", local_x, local_y);
	json_number(point, "height", nodata ? (double)NAN : sample.height);
	json_number(point, "base", nodata ? (double)NAN : sample.base);
	json_number(point, "offset", nodata ? (double)NAN : sample.offset);
	json_number(point, "surface", surface.height);
	if (isnan(surface.normal[2]))
		cJSON_AddNullToObject(point, "normal");
	else
		json_numbers(point, "normal", surface.normal, 3);
	cJSON_AddBoolToObject(point, "nodata", nodata);
	cJSON_AddBoolToObject(point, "outside", sample.outside);
	cJSON *soil = cJSON_AddObjectToObject(point, "soil");
	json_integer(soil, "dirt", dirt);
	if (sample.planes & PLANE_BIT(PLANE_RISEN)) {
		json_number(soil, "bent", left_of(asking, PLANE_RISEN, sample.risen) / (double)PLANE_MARK_MOST);
		json_number(soil, "torn", left_of(asking, PLANE_GROWN, sample.grown) / (double)PLANE_MARK_MOST);
	}
	const struct {
		enum plane plane;
		double value;
	} state[] = {
		{PLANE_DEPOSITED, sample.deposited}, {PLANE_PLASTIC_SINKAGE, sample.plastic_sinkage}, {PLANE_SETTLED, sample.loose}, {PLANE_DENSITY, sample.density},
	};
	for (size_t i = 0; i < sizeof state / sizeof *state; i++)
		if (sample.planes & PLANE_BIT(state[i].plane))
			json_number(soil, plane_layer(state[i].plane == PLANE_SETTLED ? PLANE_LOOSE : state[i].plane), state[i].value);
	if (sample.planes & PLANE_BIT(PLANE_SHEAR))
		json_numbers(soil, plane_layer(PLANE_SHEAR), sample.shear, 2);
	cJSON_AddItemToArray(asking->points, point);
	asking->only = point;
	return STATUS_OK;
}

static void print_ray(const double asked[RAY], const struct resident_hit *hit)
{
	for (int i = 0; i < RAY; i++)
		printf("%.15g ", asked[i]);
	if (hit->hit)
		printf("distance %.6f at %.15g %.15g %.6f normal %.6f %.6f %.6f%s\n", hit->distance, hit->point[0], hit->point[1],
		       hit->point[2], hit->normal[0], hit->normal[1], hit->normal[2], hit->below ? " below" : "");
	else
		printf("none\n");
}

static enum status ask_ray(struct asking *asking, const double asked[RAY])
{
	struct resident_ray ray = {{asked[0], asked[1], asked[2]}, {asked[3], asked[4], asked[5]}, INFINITY};
	struct resident_hit hit;
	TRY(to_local(asking, &ray.origin[0], &ray.origin[1]));
	TRY(resident_newest_rays(asking->newest, &ray, 1, &hit));
	if (hit.hit)
		TRY(from_local(asking, &hit.point[0], &hit.point[1]));
	if (!hit.hit && !asking->guessed) {
		struct store_sample sample;
		TRY(store_sample(asking->reader, ray.origin[0], ray.origin[1], &sample));
		if (sample.outside)
			tell_outside(asking, asked[0], asked[1]);
	}
	if (asking->rays == NULL) {
		print_ray(asked, &hit);
		return STATUS_OK;
	}
	cJSON *object = cJSON_CreateObject();
	json_numbers(object, "origin", asked, 3);
	json_numbers(object, "direction", asked + 3, 3);
	cJSON_AddBoolToObject(object, "hit", hit.hit);
	if (hit.hit) {
		json_number(object, "distance", hit.distance);
		json_numbers(object, "point", hit.point, 3);
		json_numbers(object, "normal", hit.normal, 3);
		cJSON_AddBoolToObject(object, "below", hit.below);
		json_integer(object, "level", hit.tile.level);
	}
	cJSON_AddItemToArray(asking->rays, object);
	asking->only = object;
	return STATUS_OK;
}

/* Numbers parted by blanks or commas: as many as there are, RAY + 1 for more; 0 if anything is none. */
static size_t read_numbers(const char *text, double values[RAY])
{
	size_t count = 0;
	char *end;
	for (;; text = end + strspn(end, " \t\r\n")) {
		double value = strtod(text, &end);
		if (end == text || !isfinite(value))
			return 0;
		if (count == RAY)
			return RAY + 1;
		values[count++] = value;
		size_t blanks = strspn(end, " \t\r\n");
		if (end[blanks] == '\0')
			return count;
		if (blanks == 0 && *end != ',')
			return 0;
		end += blanks + (end[blanks] == ',');
	}
}

static bool has_direction(const double ray[RAY])
{
	return ray[3] != 0 || ray[4] != 0 || ray[5] != 0;
}

static enum status ask_line(struct asking *asking, const char *line, long number)
{
	double values[RAY];
	if (line[strspn(line, " \t\r\n")] == '\0')
		return STATUS_OK;
	size_t count = read_numbers(line, values);
	if (count == POINT)
		return ask_point(asking, values[0], values[1]);
	if (count == RAY && has_direction(values))
		return ask_ray(asking, values);
	return fail_with(STATUS_INPUT, "stdin:%ld: not a point; give X and Y, as in 120.5 300, or a ray: X Y Z DX DY DZ", number);
}

static enum status ask_lines(struct asking *asking)
{
	char *line = NULL;
	size_t room = 0;
	enum status status = STATUS_OK;
	for (long number = 1; getline(&line, &room, stdin) >= 0; number++)
		TRY_OR(done, ask_line(asking, line, number));
	if (!feof(stdin))
		TRY_OR(done, fail_with(STATUS_INPUT, "stdin: cannot be read; give lines of X Y"));
done:
	free(line);
	return status;
}

static enum status ask_arguments(struct asking *asking, const struct arguments *arguments)
{
	const char *text;
	for (size_t i = 1; i + 1 < arguments_count(arguments); i += 2) {
		double x, y;
		if (!parse_number(arguments_at(arguments, i), &x) || !parse_number(arguments_at(arguments, i + 1), &y))
			return fail_with(STATUS_USAGE, "query: %s %s: not a point; give X and Y as numbers",
					 arguments_at(arguments, i), arguments_at(arguments, i + 1));
		TRY(ask_point(asking, x, y));
	}
	for (size_t i = 0; (text = arguments_nth(arguments, "ray", i)) != NULL; i++) {
		double ray[RAY];
		if (read_numbers(text, ray) != RAY || !has_direction(ray))
			return fail_with(STATUS_USAGE, "query: --ray %s: not a ray; give X,Y,Z,DX,DY,DZ, where it begins and where it goes",
					 text);
		TRY(ask_ray(asking, ray));
	}
	return STATUS_OK;
}

/* Takes the points and rays. */
static enum status print_json(struct asking *asking)
{
	cJSON *object = cJSON_CreateObject();
	if (cJSON_GetArraySize(asking->points) + cJSON_GetArraySize(asking->rays) == 1)
		for (cJSON *item = asking->only->child; item != NULL; item = item->next)
			cJSON_AddItemToObject(object, item->string, cJSON_Duplicate(item, true));
	cJSON_AddItemToObject(object, "points", asking->points);
	if (cJSON_GetArraySize(asking->rays) > 0)
		cJSON_AddItemToObject(object, "rays", asking->rays);
	else
		cJSON_Delete(asking->rays);
	asking->points = asking->rays = NULL;
	return json_print(object);
}

/* An X has no Y. Who joins them by a comma is told so. */
static enum status no_pairs(const struct arguments *arguments)
{
	const char *last = arguments_at(arguments, arguments_count(arguments) - 1);
	if (strchr(last, ',') != NULL)
		return fail_with(STATUS_USAGE, "query: %.40s: not one number; give X and Y apart, as in query world.furrow 120.5 300", last);
	return fail_with(STATUS_USAGE, "query: %.40s: an X without its Y; give pairs, as in query world.furrow 120.5 300", last);
}

static enum status ask(struct asking *asking, struct store *store, const struct arguments *arguments)
{
	const bool told = arguments_count(arguments) > 1 || arguments_flag(arguments, "ray");
	struct store_marks marks;
	TRY(store_marks(store, &marks));
	asking->marks = store_marks_at(&marks, marks.time);
	TRY(store_reader_create(store, &asking->reader));
	TRY(resident_newest_create(store, NULL, &asking->newest));
	if (arguments_flag(arguments, "json")) {
		asking->points = cJSON_CreateArray();
		asking->rays = cJSON_CreateArray();
		TRY_MEM(asking->points != NULL && asking->rays != NULL, "JSON");
	}
	TRY(told ? ask_arguments(asking, arguments) : ask_lines(asking));
	return asking->points != NULL ? print_json(asking) : STATUS_OK;
}

static enum status run(const struct arguments *arguments)
{
	struct asking asking = {.srs = arguments_text(arguments, "srs")};
	struct store *store = NULL;
	if (arguments_count(arguments) % 2 == 0)
		return no_pairs(arguments);
	TRY(store_open(arguments_at(arguments, 0), &(struct store_options){.mode = STORE_READ}, &store));
	asking.meta = store_meta(store);
	relief_tell_missing(arguments_at(arguments, 0), store);
	enum status status = ask(&asking, store, arguments);
	cJSON_Delete(asking.points);
	cJSON_Delete(asking.rays);
	resident_newest_destroy(asking.newest);
	store_reader_destroy(asking.reader);
	store_close(store);
	return status;
}

const struct command command_query = {
	.name = "query",
	.summary = "height, base and offset at points; where rays meet the ground",
	.arguments = COMMAND_ARGUMENTS(COMMAND_STORE, {"X Y", .help = "a point", .repeats = true}),
	.options = options,
	.details = "Without points or rays on the command line, lines of X Y (a point) and X Y Z DX DY DZ (a ray) are read from "
		   "stdin. With --json a single one's values also stand at the top of the object.\n\n"
		   "height is between the four posts of the cell, at the finest level that is deformed there. surface and normal "
		   "are of the same ground, and so is what rays meet. Beside a hole, where height has no value, surface is that of the triangle "
		   "between the cell's other posts. A ray goes as far as the terrain does; its direction (of any length) and its hit's normal are east, north and up "
		   "of the store. \"below\": it comes from under the ground.\n",
	.examples = "furrow query world.furrow 120.5 300 -3 4\n"
		    "furrow query world.furrow --ray 10,10,500,0,0,-1 --json\n",
	.run = run,
};
