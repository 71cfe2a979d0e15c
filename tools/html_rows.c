/* Reads objects.csv and vehicles.csv into curves, and the way since the first row. html_forces.c has what is computed of each row. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "command.h"
#include "html_actuators.h"
#include "html_row.h"

#define CELLS_MOST 2048
#define BODIES_MOST 4096
#define ROWS_MOST 20000000 /* in a file: about 2 GB */

/* How a column is read: where its number goes within a row. */
struct column {
	const char *name;
	size_t offset;
	int cell;     /* -1: the file has none */
	bool may_lack; /* the file may have none, and a cell may be empty: NaN then */
};
#define PLACE(member) offsetof(struct html_row, member)

struct table {
	struct html_run *run;
	struct html_bodies *bodies;
	const char *path;
	struct column *columns;
	size_t count;     /* of columns */
	size_t cells;     /* of a line */
	bool vehicles;
	struct html_actuators actuators;
	uint64_t line, rows;
};

static size_t cut(char *line, char **cells)
{
	size_t count = 0;
	line[strcspn(line, "\r\n")] = '\0';
	for (char *at = line; at != NULL && count < CELLS_MOST;) {
		cells[count++] = at;
		at = strchr(at, ',');
		if (at != NULL)
			*at++ = '\0';
	}
	return count;
}

static enum status wrong(const struct table *table, const char *why)
{
	return fail_with(STATUS_INPUT, "%s:%llu: %s; give a folder that furrow drive left, or remove the file", table->path,
			 (unsigned long long)table->line, why);
}

static enum status find_columns(struct table *table, char **cells, size_t count)
{
	table->cells = count;
	if (count < 2 || strcmp(cells[0], "t") != 0 || strcmp(cells[1], "name") != 0)
		return wrong(table, "does not begin with the columns t and name");
	for (size_t k = 0; k < table->count; k++) {
		table->columns[k].cell = -1;
		for (size_t i = 0; i < count && table->columns[k].cell < 0; i++)
			if (strcmp(cells[i], table->columns[k].name) == 0)
				table->columns[k].cell = (int)i;
		if (table->columns[k].cell < 0 && !table->columns[k].may_lack)
			return wrong(table, "lacks a column that such a file has");
	}
	return table->vehicles ? html_actuators_find(&table->actuators, cells, count) : STATUS_OK;
}

/* NaN, as of slip in the air, is a gap. */
static bool take_number(const char *text, double *value)
{
	char *end;
	*value = strtod(text, &end);
	if (end == text || *end != '\0')
		return false;
	if (!isfinite(*value))
		*value = (double)NAN;
	return true;
}

/* Returns the radius of a wheel; 0 for a shape that does not turn by itself; NaN for a belt, or if run.json has no settings. */
static double radius_of(const struct html_run *run, const char *name)
{
	char prefix[256], key[300];
	double radius;
	const cJSON *value;
	const int length = snprintf(prefix, sizeof prefix, "objects.%s.shape.", name);
	if (length < 0 || (size_t)length >= sizeof prefix)
		return (double)NAN;
	snprintf(key, sizeof key, "%swheel.radius", prefix);
	const char *wheel = html_setting(run, key);
	if (wheel != NULL)
		return parse_number(wheel, &radius) && radius > 0 ? radius : (double)NAN;
	bool shaped = false;
	cJSON_ArrayForEach(value, html_members(run, "scene.values")) {
		if (value->string == NULL || strncmp(value->string, prefix, (size_t)length) != 0)
			continue;
		shaped = true;
		if (strstr(value->string + length, "belt") != NULL || strstr(value->string + length, "wheel") != NULL)
			return (double)NAN;
	}
	return shaped ? 0 : (double)NAN;
}

/* A path has heights only if a file gives it. */
static bool is_flat(const struct html_run *run, const char *name)
{
	char key[300];
	snprintf(key, sizeof key, "objects.%.200s.load", name);
	if (html_setting(run, key) != NULL)
		return false;
	snprintf(key, sizeof key, "objects.%.200s.path.file", name);
	return html_setting(run, key) != NULL;
}

static struct html_body *body_named(struct table *table, const char *name)
{
	struct html_bodies *bodies = table->bodies;
	for (size_t i = 0; i < bodies->count; i++) /* rows come in the same order each time */
		if (strcmp(bodies->list[(i + table->rows) % bodies->count].name, name) == 0)
			return &bodies->list[(i + table->rows) % bodies->count];
	if (bodies->count == BODIES_MOST)
		return NULL;
	struct html_body *body = html_bodies_add(bodies, name);
	if (body == NULL || (body->last = mem_calloc(1, sizeof *body->last)) == NULL)
		return NULL;
	body->last->radius = table->vehicles ? (double)NAN : radius_of(table->run, name);
	body->last->flat = !table->vehicles && is_flat(table->run, name);
	return body;
}

enum status html_body_room(struct html_body *body)
{
	if (body->count < body->room)
		return STATUS_OK;
	const size_t room = mem_room(body->room, body->count + 1);
	double **const four[] = {&body->time, &body->way, &body->x, &body->y};
	for (int k = 0; k < 4 + HTML_VALUES; k++)
		TRY(mem_resize(k < 4 ? four[k] : &body->values[k - 4], room, sizeof(double), "the rows of a drive"));
	body->room = room;
	return STATUS_OK;
}

static enum status take_row(struct table *table, const char *name, struct html_row *row)
{
	struct html_body *body = body_named(table, name);
	if (body == NULL)
		return table->bodies->count == BODIES_MOST ? wrong(table, "has too many names") : fail_memory("the rows of a drive");
	const struct html_row *last = body->last;
	if (body->count > 0 && row->time < last->time)
		return wrong(table, "goes back in time");
	TRY(html_body_room(body));
	const size_t at = body->count;
	const double went = at > 0 ? hypot(row->place[0] - last->place[0], row->place[1] - last->place[1]) : 0;
	body->time[at] = row->time;
	body->floor = at > 0 ? body->floor : row->place[2];
	body->rise = row->place[2] - body->floor;
	body->way[at] = at > 0 ? body->way[at - 1] + went : 0;
	body->x[at] = row->place[0];
	body->y[at] = row->place[1];
	if (table->vehicles)
		for (int k = 0; k < HTML_VALUES; k++)
			body->values[k][at] = row->values[k];
	else
		html_forces_take(body, row, went);
	if (!table->vehicles)
		TRY(html_digging_take(body, row));
	body->count++;
	*body->last = *row;
	return STATUS_OK;
}

static enum status take_line(struct table *table, char **cells, size_t count)
{
	struct html_row row = {.moved = false};
	if (count != table->cells)
		return wrong(table, "has not as many columns as the first line");
	if (++table->rows > ROWS_MOST)
		return wrong(table, "is behind the 20 million rows that a report reads");
	for (size_t k = 0; k < table->count; k++) {
		const struct column *column = &table->columns[k];
		double *number = (double *)((char *)&row + column->offset);
		if (column->may_lack && (column->cell < 0 || cells[column->cell][0] == '\0'))
			*number = (double)NAN;
		else if (!take_number(cells[column->cell], number))
			return wrong(table, "has a cell that is no number");
	}
	if (isnan(row.time) || isnan(row.place[0]) || isnan(row.place[1]) || isnan(row.place[2]))
		return wrong(table, "does not tell when or where it is");
	if (table->vehicles) {
		row.values[HTML_SPEED] = hypot(hypot(row.force[0], row.force[1]), row.force[2]); /* where its velocity was read to */
		row.values[HTML_WORK] /= 1e3;
		row.values[HTML_KINETIC] /= 1e3;
		for (int k = HTML_SOIL; k < HTML_VALUES; k++)
			row.values[k] = (double)NAN;
	}
	TRY(take_row(table, cells[1], &row));
	if (!table->vehicles)
		return STATUS_OK;
	return html_actuators_take(&table->actuators, cells, body_named(table, cells[1]), &table->run->actuators);
}

static enum status read_rows(struct table *table, FILE *file)
{
	char *line = NULL, **cells = mem_alloc(CELLS_MOST, sizeof *cells);
	size_t size = 0;
	ssize_t length;
	enum status status;
	TRY_OR(done, cells != NULL ? STATUS_OK : fail_memory("the rows of a drive"));
	while ((length = getline(&line, &size, file)) > 0) {
		table->line++;
		if (line[length - 1] != '\n')
			break; /* a kill may have torn the last line */
		if (strlen(line) != (size_t)length)
			TRY_OR(done, wrong(table, "has a byte 0"));
		else
			TRY_OR(done, table->line == 1 ? find_columns(table, cells, cut(line, cells)) : take_line(table, cells, cut(line, cells)));
	}
	if (ferror(file))
		TRY_OR(done, fail_with(STATUS_INPUT, "%s: %s; give a folder that can be read", table->path, strerror(errno)));
done:
	free(line);
	mem_free(cells);
	return status;
}

static enum status read_file(struct html_run *run, const char *name, bool vehicles, struct column *columns, size_t count, struct html_bodies *bodies)
{
	char path[4200];
	snprintf(path, sizeof path, "%s/%s", run->folder, name);
	if (!html_is_file(path))
		return STATUS_OK;
	FILE *file = input_open(path);
	if (file == NULL)
		return fail_with(STATUS_INPUT, "%s: %s; give a folder that can be read", path, input_problem());
	struct table table = {.run = run, .bodies = bodies, .path = path, .columns = columns, .count = count, .vehicles = vehicles};
	enum status status = read_rows(&table, file);
	html_actuators_finish(&table.actuators);
	fclose(file);
	bodies->there = table.rows > 0;
	return status;
}

enum status html_rows_objects(struct html_run *run)
{
	struct column columns[] = {
		{"t", PLACE(time), 0, false}, {"x", PLACE(place[0]), 0, false}, {"y", PLACE(place[1]), 0, false}, {"z", PLACE(place[2]), 0, false},
		{"sinkage", PLACE(sinkage), 0, false}, {"slip", PLACE(slip), 0, false}, {"fx", PLACE(force[0]), 0, false}, {"fy", PLACE(force[1]), 0, false},
		{"fz", PLACE(force[2]), 0, false}, {"tx", PLACE(moment[0]), 0, false}, {"ty", PLACE(moment[1]), 0, false}, {"tz", PLACE(moment[2]), 0, false},
		{"load", PLACE(load), 0, true}, {"work", PLACE(work), 0, true}, {"carried", PLACE(carried), 0, true}, {"carried_weight", PLACE(weight), 0, true},
	};
	return read_file(run, "objects.csv", false, columns, sizeof columns / sizeof *columns, &run->objects);
}

enum status html_rows_vehicles(struct html_run *run)
{
	struct column columns[] = {
		{"t", PLACE(time), 0, false}, {"x", PLACE(place[0]), 0, false}, {"y", PLACE(place[1]), 0, false}, {"z", PLACE(place[2]), 0, false},
		{"vx", PLACE(force[0]), 0, false}, {"vy", PLACE(force[1]), 0, false}, {"vz", PLACE(force[2]), 0, false},
		{"work", PLACE(values[HTML_WORK]), 0, false}, {"kinetic", PLACE(values[HTML_KINETIC]), 0, false},
	};
	return read_file(run, "vehicles.csv", true, columns, sizeof columns / sizeof *columns, &run->vehicles);
}

/* Adds the energy of an object's rows to a vehicle's, at the vehicle's times: that of the last row until then. */
static void add_soil(const struct html_body *object, struct html_body *vehicle)
{
	for (size_t i = 0, k = 0; i < vehicle->count; i++) {
		while (k + 1 < object->count && object->time[k + 1] <= vehicle->time[i] * (1 + 1e-9))
			k++;
		vehicle->values[HTML_SOIL][i] = (isnan(vehicle->values[HTML_SOIL][i]) ? 0 : vehicle->values[HTML_SOIL][i]) + object->values[HTML_ENERGY][k];
	}
}

bool html_is_part(const char *object, const char *vehicle)
{
	const size_t length = strlen(vehicle);
	return strncmp(object, vehicle, length) == 0 && object[length] == '.';
}

void html_rows_join(struct html_run *run)
{
	for (size_t v = 0; v < run->vehicles.count; v++) {
		struct html_body *vehicle = &run->vehicles.list[v];
		for (size_t k = 0; k < run->objects.count; k++) {
			const struct html_body *object = &run->objects.list[k];
			if (html_is_part(object->name, vehicle->name) && object->count > 0)
				add_soil(object, vehicle);
		}
	}
}

struct html_body *html_bodies_add(struct html_bodies *bodies, const char *name)
{
	if (mem_resize(&bodies->list, bodies->count + 1, sizeof *bodies->list, "the rows of a drive") != STATUS_OK)
		return NULL;
	bodies->list[bodies->count] = (struct html_body){.name = mem_strdup(name)};
	return bodies->list[bodies->count].name != NULL ? &bodies->list[bodies->count++] : NULL;
}

void html_bodies_finish(struct html_bodies *bodies)
{
	for (size_t i = 0; i < bodies->count; i++) {
		struct html_body *body = &bodies->list[i];
		mem_free_all(body->name, body->time, body->way, body->x, body->y);
		for (int k = 0; k < HTML_VALUES; k++)
			mem_free(body->values[k]);
		mem_free(body->last);
		html_digging_finish(body->digging);
	}
	mem_free(bodies->list);
	*bodies = (struct html_bodies){.count = 0};
}
