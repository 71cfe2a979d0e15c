/* Reads the lines and numbers of a table; controls.c and pushes.c know its columns. */
#include "vehicle/table.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/input.h"

enum status vehicle_table_wrong(const struct vehicle_table *table, const char *what, const char *allowed)
{
	return fail_with(STATUS_INPUT, "%s: %s: %s:%d: %.64s; allowed: %s", table->where, table->key, table->path, table->line, what, allowed);
}

enum status vehicle_table_open(struct vehicle_table *table)
{
	table->file = input_open(table->path);
	if (table->file == NULL)
		return fail_with(STATUS_INPUT, "%s: %s: %s: %s; name a file that can be read", table->where, table->key, table->path, input_problem());
	return STATUS_OK;
}

void vehicle_table_close(struct vehicle_table *table)
{
	fclose(table->file);
}

enum status vehicle_table_next(struct vehicle_table *table, bool *any)
{
	*any = false;
	while (fgets(table->text, (int)table->most, table->file) != NULL) {
		table->line++;
		const size_t length = strcspn(table->text, "\r\n");
		if (table->text[length] == '\0' && !feof(table->file)) {
			char allowed[48];
			snprintf(allowed, sizeof allowed, "lines of %zu bytes", table->most - 1);
			return vehicle_table_wrong(table, "the line is too long, or has a byte 0", allowed);
		}
		table->text[length] = '\0';
		if (length == 0)
			continue;
		*any = true;
		return STATUS_OK;
	}
	return ferror(table->file) ? vehicle_table_wrong(table, strerror(errno), "a file that can be read") : STATUS_OK;
}

enum status vehicle_table_number(const struct vehicle_table *table, const char *field, double *number)
{
	char *end;
	*number = strtod(field, &end);
	if (end == field || *end != '\0' || !(fabs(*number) <= 1e12))
		return vehicle_table_wrong(table, field, "numbers");
	return STATUS_OK;
}
