/* furrow query: heights at points. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "command.h"
#include "dem/dem.h"
#include "json.h"
#include "store/store.h"

static const struct command_option options[] = {
	{"srs", "SRS", "what X and Y are in (metres from the south-west post); \"store\": the store's own"},
	{"json", NULL, "one JSON object: points, each with height, base, offset, nodata, soil (in metres but for dirt)"},
	{NULL, NULL, NULL},
};

struct asking {
	struct store_reader *reader;
	const struct store_meta *meta;
	const char *srs;
	cJSON *points; /* NULL: print lines */
	cJSON *only;   /* the last one */
};

static enum status to_local(const struct asking *asking, double *x, double *y)
{
	if (asking->srs == NULL)
		return STATUS_OK;
	if (strcmp(asking->srs, "store") != 0) {
		if (asking->meta->srs[0] == '\0')
			return fail_with(STATUS_INPUT, "query: the store has no reference system; leave --srs out and give "
						       "metres from its south-west post");
		enum status status = dem_transform(asking->srs, asking->meta->srs, 1, x, y);
		if (status != STATUS_OK)
			return status;
	}
	*x -= asking->meta->origin[0];
	*y -= asking->meta->origin[1];
	return STATUS_OK;
}

static enum status ask(struct asking *asking, double x, double y)
{
	struct store_sample sample;
	double local_x = x, local_y = y;
	enum status status = to_local(asking, &local_x, &local_y);
	if (status == STATUS_OK)
		status = store_sample(asking->reader, local_x, local_y, &sample);
	if (status != STATUS_OK)
		return status;
	bool nodata = sample.nodata || sample.outside;
	if (asking->points == NULL) {
		if (nodata)
			printf("%.15g %.15g %s\n", x, y, sample.outside ? "outside" : "nodata");
		else
			printf("%.15g %.15g height %.6f base %.6f offset %.6f dirt %u\n", x, y, sample.height,
			       sample.base, sample.offset, sample.dirt);
		return STATUS_OK;
	}
	cJSON *point = cJSON_CreateObject();
	json_number(point, "x", x);
	json_number(point, "y", y);
	json_number(point, "height", nodata ? (double)NAN : sample.height);
	json_number(point, "base", nodata ? (double)NAN : sample.base);
	json_number(point, "offset", nodata ? (double)NAN : sample.offset);
	cJSON_AddBoolToObject(point, "nodata", nodata);
	cJSON_AddBoolToObject(point, "outside", sample.outside);
	cJSON *soil = cJSON_AddObjectToObject(point, "soil");
	json_integer(soil, "dirt", sample.dirt);
	const struct {
		enum plane plane;
		double value;
	} state[] = {
		{PLANE_HEAPED, sample.heaped}, {PLANE_PRESSED, sample.pressed}, {PLANE_SHEAR, sample.shear},
	};
	for (size_t i = 0; i < sizeof state / sizeof *state; i++)
		if (sample.planes & PLANE_BIT(state[i].plane))
			json_number(soil, plane_name(state[i].plane), state[i].value);
	cJSON_AddItemToArray(asking->points, point);
	asking->only = point;
	return STATUS_OK;
}

static enum status ask_lines(struct asking *asking)
{
	char *line = NULL;
	size_t room = 0;
	enum status status = STATUS_OK;
	for (long number = 1; status == STATUS_OK && getline(&line, &room, stdin) >= 0; number++) {
		double x, y;
		char rest;
		if (line[strspn(line, " \t\r\n")] == '\0')
			continue;
		if (sscanf(line, "%lf%*[ \t,]%lf %c", &x, &y, &rest) != 2 || !isfinite(x) || !isfinite(y))
			status = fail_with(STATUS_INPUT, "stdin:%ld: not a point; give X and Y, as in 120.5 300", number);
		else
			status = ask(asking, x, y);
	}
	free(line);
	if (status == STATUS_OK && !feof(stdin))
		status = fail_with(STATUS_INPUT, "stdin: cannot be read; give lines of X Y");
	return status;
}

static enum status ask_arguments(struct asking *asking, const struct arguments *arguments)
{
	enum status status = STATUS_OK;
	for (size_t i = 1; i + 1 < arguments_count(arguments) && status == STATUS_OK; i += 2) {
		double x, y;
		if (!parse_number(arguments_at(arguments, i), &x) || !parse_number(arguments_at(arguments, i + 1), &y))
			return fail_with(STATUS_USAGE, "query: %s %s: not a point; give X and Y as numbers",
					 arguments_at(arguments, i), arguments_at(arguments, i + 1));
		status = ask(asking, x, y);
	}
	return status;
}

static enum status print_json(const struct asking *asking)
{
	cJSON *object = cJSON_CreateObject();
	if (cJSON_GetArraySize(asking->points) == 1)
		for (cJSON *item = asking->only->child; item != NULL; item = item->next)
			cJSON_AddItemToObject(object, item->string, cJSON_Duplicate(item, true));
	cJSON_AddItemToObject(object, "points", asking->points);
	return json_print(object);
}

static enum status run(const struct arguments *arguments)
{
	struct asking asking = {.srs = arguments_text(arguments, "srs")};
	struct store *store = NULL;
	enum status status = arguments_expect(arguments, 1, SIZE_MAX);
	if (status == STATUS_OK && arguments_count(arguments) % 2 == 0)
		status = fail_with(STATUS_USAGE, "query: an X has no Y; give pairs, as in query world.furrow 120.5 300");
	if (status == STATUS_OK)
		status = store_open(arguments_at(arguments, 0), &(struct store_options){.mode = STORE_READ}, &store);
	if (status != STATUS_OK)
		return status;
	asking.meta = store_meta(store);
	status = store_reader_create(store, &asking.reader);
	if (status == STATUS_OK && arguments_flag(arguments, "json") &&
	    (asking.points = cJSON_CreateArray()) == NULL)
		status = fail_memory("JSON");
	if (status == STATUS_OK)
		status = arguments_count(arguments) > 1 ? ask_arguments(&asking, arguments) : ask_lines(&asking);
	if (status == STATUS_OK && asking.points != NULL)
		status = print_json(&asking);
	else
		cJSON_Delete(asking.points);
	store_reader_destroy(asking.reader);
	store_close(store);
	return status;
}

const struct command command_query = {
	.name = "query",
	.usage = "query STORE [X Y]... [--srs SRS] [--json]",
	.summary = "height, base and offset at points",
	.details = "Without points on the command line, lines of X Y are read from stdin. With --json a single point's\n"
		   "values also stand at the top of the object.\n",
	.options = options,
	.run = run,
};
