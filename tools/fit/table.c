/*
 * Reads the rows of a test from a CSV file, which is untrusted.
 *
 * A column is known by a word of its name, and its unit is the last word: `plate width b m`, `z [mm]`, `sinkage_mm`. A column without a unit is
 * refused, since a guess could be wrong by a factor of a thousand. Other columns are passed over.
 */
#include "fit.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { LINE_MOST = 4096, COLUMNS_MOST = 64, WORDS_MOST = 12, FIELDS = 3, GROUP = 0, X = 1, Y = 2 };
#define SAME_GROUP 1e-9 /* of the value */
#define VALUE_MOST 1e12

/* Words of which a column's name has all; ended by NULL. */
struct known {
	enum fit_test test;
	int field;
	const char *words[3];
};

static const struct known known[] = {
	{FIT_PLATE, GROUP, {"width"}}, {FIT_PLATE, GROUP, {"b"}}, {FIT_PLATE, GROUP, {"radius"}}, {FIT_PLATE, GROUP, {"diameter"}},
	{FIT_PLATE, X, {"sinkage"}}, {FIT_PLATE, X, {"z"}},
	{FIT_PLATE, Y, {"pressure"}}, {FIT_PLATE, Y, {"p"}},
	{FIT_SHEAR, GROUP, {"normal"}}, {FIT_SHEAR, GROUP, {"sigma"}},
	{FIT_SHEAR, X, {"displacement"}}, {FIT_SHEAR, X, {"j"}},
	{FIT_SHEAR, Y, {"shear", "stress"}}, {FIT_SHEAR, Y, {"tau"}},
	{FIT_PENETRATION, GROUP, {"area"}},
	{FIT_PENETRATION, X, {"depth"}}, {FIT_PENETRATION, X, {"sinkage"}}, {FIT_PENETRATION, X, {"z"}},
	{FIT_PENETRATION, Y, {"pressure"}}, {FIT_PENETRATION, Y, {"p"}}, {FIT_PENETRATION, Y, {"force"}}, {FIT_PENETRATION, Y, {"f"}},
};

enum quantity { LENGTH, STRESS, AREA, FORCE };

static const struct unit {
	const char *name;
	enum quantity of;
	double size;
} units[] = {{"m", LENGTH, 1}, {"cm", LENGTH, 1e-2}, {"mm", LENGTH, 1e-3}, {"Pa", STRESS, 1}, {"kPa", STRESS, 1e3}, {"MPa", STRESS, 1e6},
	     {"m2", AREA, 1}, {"cm2", AREA, 1e-4}, {"mm2", AREA, 1e-6}, {"N", FORCE, 1}, {"kN", FORCE, 1e3}};
#define COUNT(list) (sizeof list / sizeof *list)

static const char *const names[][FIELDS] = {{"plate width b", "sinkage z", "pressure p"}, {"normal stress sigma", "displacement j", "shear stress tau"},
					     {"area", "depth z", "force or pressure"}};
static const char *const unit_names[] = {[LENGTH] = "m, cm or mm", [STRESS] = "Pa, kPa or MPa", [AREA] = "m2, cm2 or mm2", [FORCE] = "N or kN"};

/* What a column measures. of_force: of a penetration, its name says force. */
static enum quantity quantity_of(enum fit_test test, int field, bool of_force)
{
	if (test == FIT_PENETRATION)
		return field == GROUP ? AREA : field == X ? LENGTH : of_force ? FORCE : STRESS;
	return field == Y || (field == GROUP && test == FIT_SHEAR) ? STRESS : LENGTH;
}

/* Returns true if a table may lack a column. */
static bool may_lack(enum fit_test test, int field)
{
	return test == FIT_PENETRATION && field == GROUP;
}

const char *fit_table_columns(enum fit_test test)
{
	static const char *const columns[] = {"plate width b m, sinkage z m, pressure p kPa", "normal stress sigma kPa, displacement j m, shear stress tau kPa",
					      "depth z m, force N"};
	return columns[test];
}

/* --- columns --- */

struct columns {
	int at[FIELDS]; /* -1: not found */
	double unit[FIELDS];
	bool is_force;  /* what Y is, of a penetration */
};

struct words {
	char text[LINE_MOST];
	const char *list[WORDS_MOST];
	size_t count;
};

static void split(const char *cell, struct words *words)
{
	char *at = words->text;
	snprintf(words->text, sizeof words->text, "%s", cell);
	words->count = 0;
	while (*at != '\0' && words->count < WORDS_MOST) {
		while (*at != '\0' && !isalnum((unsigned char)*at))
			at++;
		if (*at != '\0')
			words->list[words->count++] = at;
		while (isalnum((unsigned char)*at))
			at++;
		if (*at != '\0')
			*at++ = '\0';
	}
}

static bool has_word(const struct words *words, const char *word)
{
	for (size_t i = 0; i < words->count; i++)
		if (strcasecmp(words->list[i], word) == 0)
			return true;
	return false;
}

/* Finds what a column is; -1: something else. */
static int field_of(const struct words *words, enum fit_test test)
{
	for (size_t i = 0; i < COUNT(known); i++) {
		bool all = known[i].test == test;
		for (size_t k = 0; k < 3 && known[i].words[k] != NULL; k++)
			all = all && has_word(words, known[i].words[k]);
		if (all)
			return known[i].field;
	}
	return -1;
}

static const struct unit *unit_of(const struct words *words, enum quantity of)
{
	for (size_t i = 0; i < COUNT(units) && words->count > 1; i++)
		if (units[i].of == of && strcasecmp(words->list[words->count - 1], units[i].name) == 0)
			return &units[i];
	return NULL;
}

static enum status take_column(const char *path, int line, enum fit_test test, const char *cell, int column, struct columns *columns)
{
	struct words words;
	split(cell, &words);
	const int field = field_of(&words, test);
	if (field < 0)
		return STATUS_OK;
	const bool of_force = has_word(&words, "force") || has_word(&words, "f");
	const enum quantity quantity = quantity_of(test, field, of_force);
	const struct unit *unit = unit_of(&words, quantity);
	if (columns->at[field] >= 0)
		return fail_with(STATUS_INPUT, "%s:%d: columns %d and %d are both %s; name one of them otherwise", path, line, columns->at[field] + 1,
				 column + 1, names[test][field]);
	if (unit == NULL)
		return fail_with(STATUS_INPUT, "%s:%d: column %d, %s, does not end with its unit; write %s %s", path, line, column + 1, names[test][field],
				 names[test][field], unit_names[quantity]);
	columns->at[field] = column;
	columns->is_force = columns->is_force || (test == FIT_PENETRATION && field == Y && of_force);
	columns->unit[field] = unit->size;
	/* The width of a round plate is its radius. */
	if (test == FIT_PLATE && field == GROUP && has_word(&words, "diameter"))
		columns->unit[field] /= 2;
	return STATUS_OK;
}

static enum status read_columns(const char *path, int line, enum fit_test test, char *text, struct columns *columns)
{
	char *rest = text, *cell;
	for (int field = 0; field < FIELDS; field++)
		columns->at[field] = -1;
	for (int i = 0; (cell = strsep(&rest, ",")) != NULL; i++) {
		if (i >= COLUMNS_MOST)
			return fail_with(STATUS_INPUT, "%s:%d: has more than %d columns; give fewer", path, line, COLUMNS_MOST);
		TRY(take_column(path, line, test, cell, i, columns));
	}
	for (int field = 0; field < FIELDS; field++)
		if (columns->at[field] < 0 && !may_lack(test, field))
			return fail_with(STATUS_INPUT, "%s:%d: has no column %s; its first line names the columns with their units, as %s", path,
					 line, names[test][field], fit_table_columns(test));
	return STATUS_OK;
}

/* --- rows --- */

static bool read_number(const char *cell, double *value)
{
	char *end;
	cell += strspn(cell, " \t\"");
	if (strspn(cell, "+-.0123456789eE") == 0)
		return false;
	*value = strtod(cell, &end);
	return end != cell && end[strspn(end, " \t\"")] == '\0' && isfinite(*value) && end - cell <= (ptrdiff_t)strspn(cell, "+-.0123456789eE");
}

static enum status read_row(const char *path, int line, enum fit_test test, char *text, const struct columns *columns, struct fit_row *row)
{
	double values[FIELDS] = {0};
	bool found[FIELDS] = {false};
	char *rest = text, *cell;
	for (int i = 0; (cell = strsep(&rest, ",")) != NULL; i++)
		for (int field = 0; field < FIELDS; field++) {
			if (columns->at[field] != i)
				continue;
			if (!read_number(cell, &values[field]))
				return fail_with(STATUS_INPUT, "%s:%d: column %d, %s: \"%.40s\" is no number; give one, with a point and without a unit", path, line,
						 i + 1, names[test][field], cell);
			values[field] *= columns->unit[field];
			found[field] = true;
			if (values[field] < 0 || values[field] > VALUE_MOST)
				return fail_with(STATUS_INPUT, "%s:%d: column %d, %s: %.40s is %s; count %s from 0 upwards", path, line, i + 1, names[test][field], cell,
						 values[field] < 0 ? "below 0" : "too large", field == X ? "downwards or along the way" : "pressure and size");
		}
	for (int field = 0; field < FIELDS; field++)
		if (!found[field] && columns->at[field] >= 0)
			return fail_with(STATUS_INPUT, "%s:%d: has no column %d, %s; each line has one value for each column", path, line, columns->at[field] + 1,
					 names[test][field]);
	if (test == FIT_PLATE && !(values[GROUP] > 0))
		return fail_with(STATUS_INPUT, "%s:%d: the plate's width is 0; give its shorter side, or the radius of a round one", path, line);
	*row = (struct fit_row){values[GROUP], values[X], values[Y], line};
	return STATUS_OK;
}

static enum status add_row(struct fit_table *table, size_t *room, const struct fit_row *row)
{
	if (!(row->x > 0)) {
		table->skipped++;
		return STATUS_OK;
	}
	if (table->count == FIT_ROWS_MOST)
		return fail_with(STATUS_INPUT, "%s:%d: has more than %d rows; give fewer, as every tenth", table->path, row->line, FIT_ROWS_MOST);
	TRY(mem_grow(&table->rows, room, table->count + 1, sizeof *table->rows, "the rows of a test"));
	table->rows[table->count++] = *row;
	return STATUS_OK;
}

/* --- groups --- */

static bool same_group(double a, double b)
{
	return fabs(a - b) <= SAME_GROUP * fmax(fabs(a), fabs(b));
}

size_t fit_table_group(const struct fit_table *table, const struct fit_row *row)
{
	size_t low = 0, high = table->group_count;
	while (low + 1 < high) {
		const size_t middle = low + (high - low) / 2;
		if (table->groups[middle] <= row->group || same_group(table->groups[middle], row->group))
			low = middle;
		else
			high = middle;
	}
	return low;
}

static enum status add_group(struct fit_table *table, const struct fit_row *row)
{
	const double value = row->group;
	size_t at = 0;
	while (at < table->group_count && table->groups[at] < value && !same_group(table->groups[at], value))
		at++;
	if (at < table->group_count && same_group(table->groups[at], value))
		return STATUS_OK;
	if (table->group_count == FIT_GROUPS_MOST)
		return fail_with(STATUS_INPUT, "%s:%d: has more than %d plate widths or normal stresses; round them to those that were set", table->path, row->line,
				 FIT_GROUPS_MOST);
	memmove(table->groups + at + 1, table->groups + at, (table->group_count - at) * sizeof *table->groups);
	table->groups[at] = value;
	table->group_count++;
	return STATUS_OK;
}

/* --- the file --- */

static void trim(char *line)
{
	size_t length = strlen(line);
	while (length > 0 && strchr("\r\n \t", line[length - 1]) != NULL)
		line[--length] = '\0';
}

static enum status take_row(const char *path, int line, enum fit_test test, char *text, const struct columns *columns, struct fit_table *table,
			    size_t *room)
{
	struct fit_row row = {.x = 0};
	TRY(read_row(path, line, test, text, columns, &row));
	TRY(add_row(table, room, &row));
	return row.x > 0 ? add_group(table, &row) : STATUS_OK;
}

static enum status read_lines(FILE *file, enum fit_test test, struct fit_table *table)
{
	char line[LINE_MOST];
	struct columns columns = {.is_force = false};
	size_t room = 0;
	bool named = false;
	for (int number = 1; fgets(line, sizeof line, file) != NULL; number++) {
		if (strchr(line, '\n') == NULL && !feof(file))
			return fail_with(STATUS_INPUT, "%s:%d: the line is longer than %d bytes, or has a byte 0; give a CSV file", table->path, number, LINE_MOST - 2);
		trim(line);
		char *text = number == 1 && strncmp(line, "\xef\xbb\xbf", 3) == 0 ? line + 3 : line;
		if (*text == '\0' || *text == '#')
			continue;
		if (named)
			TRY(take_row(table->path, number, test, text, &columns, table, &room));
		else
			TRY(read_columns(table->path, number, test, text, &columns));
		named = true;
		table->is_force = columns.is_force;
	}
	if (ferror(file))
		return fail_with(STATUS_INPUT, "%s: %s; give a file that can be read", table->path, strerror(errno));
	if (!named)
		return fail_with(STATUS_INPUT, "%s: is empty; its first line names the columns, as %s", table->path, fit_table_columns(test));
	return STATUS_OK;
}

enum status fit_table_read(const char *path, enum fit_test test, struct fit_table *out)
{
	*out = (struct fit_table){.path = path};
	FILE *file = input_open(path);
	if (file == NULL)
		return fail_with(STATUS_INPUT, "%s: %s; give a file that can be read", path, input_problem());
	enum status status = read_lines(file, test, out);
	fclose(file);
	if (status != STATUS_OK)
		fit_table_finish(out);
	return status;
}

void fit_table_finish(struct fit_table *table)
{
	mem_free(table->rows);
	*table = (struct fit_table){.path = table->path};
}
