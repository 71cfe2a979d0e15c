/* Reads the poses of an object over time from a CSV file. See scene_path.h. */
#include "scene/scene_path.h"

#include <string.h>

#include "scene/scene_error.h"
#include "scene/scene_file.h"
#include "scene/scene_read.h"

#define COLUMNS 7
#define RADIANS (3.14159265358979323846 / 180)

static const struct {
	const char *name;
	double low, high;
} columns[COLUMNS] = {
	{"t", 0, 1e9},	       {"x", -1e9, 1e9},	{"y", -1e9, 1e9},      {"z", -1e6, 1e6},
	{"yaw", -36000, 36000}, {"pitch", -36000, 36000}, {"roll", -36000, 36000},
};

struct reader {
	const char *file;
	struct scene_path *path;
	size_t room;
	int line;
	int width; /* columns of every row; 0: not known yet */
};

static enum status refuse(const struct reader *reader, const char *why)
{
	return fail_with(STATUS_INPUT, "%s:%d: %s", reader->file, reader->line, why);
}

/* Cuts the line at its commas, in place, blanks around the fields gone. 0: too many. */
static int split(char *line, char *fields[COLUMNS])
{
	int count = 0;
	for (char *field = line, *comma; field != NULL; field = comma) {
		comma = strchr(field, ',');
		if (comma != NULL)
			*comma++ = '\0';
		if (count == COLUMNS)
			return 0;
		field += strspn(field, " \t");
		size_t length = strlen(field);
		while (length > 0 && strchr(" \t\r", field[length - 1]) != NULL)
			field[--length] = '\0';
		fields[count++] = field;
	}
	return count;
}

static enum status take_row(struct reader *reader, char *const fields[COLUMNS])
{
	struct scene_path *path = reader->path;
	double values[COLUMNS] = {0};
	for (int i = 0; i < reader->width; i++) {
		if (!scene_number_read(fields[i], false, &values[i]))
			return fail_with(STATUS_INPUT, "%s:%d: %s: %s is not a number; allowed: a number",
					 reader->file, reader->line, columns[i].name,
					 scene_quote(fields[i]).text);
		if (!(values[i] >= columns[i].low && values[i] <= columns[i].high))
			return fail_with(STATUS_INPUT,
					 "%s:%d: %s: %.40s is out of range; allowed: %.10g to %.10g",
					 reader->file, reader->line, columns[i].name, fields[i],
					 columns[i].low, columns[i].high);
	}
	if (path->count > 0 && values[0] <= path->points[path->count - 1].t)
		return fail_with(STATUS_INPUT, "%s:%d: t: %.40s does not grow; allowed: above %.10g",
				 reader->file, reader->line, fields[0],
				 path->points[path->count - 1].t);
	TRY(mem_grow(&path->points, &reader->room, path->count + 1, sizeof *path->points, "reading poses"));
	path->points[path->count++] = (struct scene_waypoint){
		.t = values[0], .x = values[1], .y = values[2], .z = values[3],
		.yaw = values[4] * RADIANS, .pitch = values[5] * RADIANS, .roll = values[6] * RADIANS};
	return STATUS_OK;
}

static enum status take_line(struct reader *reader, char *line)
{
	char *fields[COLUMNS];
	line += strspn(line, " \t\r");
	if (line[0] == '\0')
		return STATUS_OK;
	if (strchr(line, ',') == NULL && strpbrk(line, ";\t") != NULL)
		return refuse(reader, "its columns are not parted by commas; write t,x,y with commas between them, and decimal points");
	int count = split(line, fields);
	if (count != 3 && count != 4 && count != 7)
		return refuse(reader, "not 3, 4 or 7 columns; allowed: t,x,y[,z[,yaw,pitch,roll]]");
	if (reader->width == 0) {
		reader->width = count;
		reader->path->has_z = count > 3;
		reader->path->has_attitude = count == 7;
		double number;
		if (!scene_number_read(fields[0], false, &number)) {
			for (int i = 0; i < count; i++)
				if (strcmp(fields[i], columns[i].name) != 0)
					return refuse(reader, "not the names of the columns in their order; allowed: t,x,y[,z[,yaw,pitch,roll]]");
			return STATUS_OK;
		}
	}
	if (count != reader->width)
		return fail_with(STATUS_INPUT, "%s:%d: %d columns; allowed: %d, as in the lines before",
				 reader->file, reader->line, count, reader->width);
	return take_row(reader, fields);
}

enum status scene_path_read(const char *file, const char *told, struct scene_path *path)
{
	struct reader reader = {.file = file, .path = path};
	char *bytes;
	size_t length;
	TRY(scene_file_read(file, told, SCENE_POSES_BYTES, &bytes, &length));
	enum status status = STATUS_OK;
	path->timed = true;
	char *line = bytes, *end = bytes + length;
	if (length >= 3 && memcmp(bytes, "\xef\xbb\xbf", 3) == 0)
		line += 3;
	while (line < end) {
		char *stop = memchr(line, '\n', (size_t)(end - line));
		if (stop == NULL)
			stop = end;
		*stop = '\0';
		reader.line++;
		if (strlen(line) != (size_t)(stop - line))
			TRY_OR(done, refuse(&reader, "a NUL byte; allowed: text"));
		TRY_OR(done, take_line(&reader, line));
		line = stop + 1;
	}
	if (path->count == 0)
		TRY_OR(done, fail_with(STATUS_INPUT, "%s: no pose; allowed: at least one row of t,x,y", file));
done:
	mem_free(bytes);
	return status;
}

void scene_level_pitch(const struct soil_shape *shape, struct scene_path *path)
{
	for (size_t i = 0; i < path->count && shape->kind == SOIL_WHEEL; i++) {
		struct scene_waypoint *point = &path->points[i];
		double axes[3][3];
		if (point->roll == 0)
			continue;
		soil_axes(point->yaw, point->pitch, point->roll, 0, axes);
		soil_wheel_attitude(axes[1], &point->yaw, &point->roll);
		point->pitch = 0;
	}
}
