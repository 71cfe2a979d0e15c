/*
 * How strongly a soil presses on faces, from a penetration test: p = 0.87574 xi_n z, the least squares of pressure through the origin.
 *
 * The model has one number, so that its standard error is sqrt(S / (count - 1) / sum of squares of 0.87574 z).
 */
#include "fit.h"

#include <math.h>
#include <string.h>

enum status fit_penetration_pressures(struct fit_table *table, double area)
{
	const bool column = table->group_count > 0 && table->groups[0] > 0;
	if (!table->is_force && area > 0)
		return fail_with(STATUS_INPUT, "%s: has pressures, and --area is for forces; leave it out", table->path);
	if (column && area > 0)
		return fail_with(STATUS_INPUT, "%s: has a column area, and --area is given too; give one of them", table->path);
	if (table->is_force && !column && !(area > 0))
		return fail_with(STATUS_INPUT, "%s: has forces, and no area; give the plate's area in m2 by --area, or a column area m2", table->path);
	for (size_t i = 0; i < table->count; i++) {
		struct fit_row *row = &table->rows[i];
		row->group = area > 0 ? area : row->group;
		if (table->is_force && !(row->group > 0))
			return fail_with(STATUS_INPUT, "%s:%d: the area is 0; give that of the plate", table->path, row->line);
		row->y = table->is_force ? row->y / row->group : row->y;
	}
	if (area > 0)
		table->groups[0] = area;
	table->is_force = false;
	return STATUS_OK;
}

/* Sums over the rows of one area, or of all. */
struct line {
	double count, x, y, xx, xy, yy;
};

static struct line line_of(const struct fit_table *table, size_t group)
{
	struct line line = {0};
	for (size_t i = 0; i < table->count; i++) {
		const struct fit_row *row = &table->rows[i];
		const double x = FIT_LEVEL_PLATE * row->x;
		if (group < table->group_count && fit_table_group(table, row) != group)
			continue;
		line.count++;
		line.x += x;
		line.y += row->y;
		line.xx += x * x;
		line.xy += x * row->y;
		line.yy += row->y * row->y;
	}
	return line;
}

static struct fit_number through_origin(const struct fit_table *table, size_t group)
{
	const struct line line = line_of(table, group);
	const double value = line.xy / line.xx, left = fmax(line.yy - value * line.xy, 0);
	return (struct fit_number){value, line.count > 1 ? sqrt(left / (line.count - 1) / line.xx) : (double)NAN};
}

static void with_offset(const struct fit_table *table, struct fit_penetration *out)
{
	const struct line line = line_of(table, SIZE_MAX);
	const double spread = line.xx - line.x * line.x / line.count, along = line.xy - line.x * line.y / line.count, up = line.yy - line.y * line.y / line.count;
	const double slope = along / spread, left = fmax(up - slope * along, 0) / (line.count - 2);
	out->slope = (struct fit_number){slope, sqrt(left / spread)};
	out->offset = (struct fit_number){(line.y - slope * line.x) / line.count, sqrt(left * line.xx / line.count / spread)};
}

enum status fit_penetration(const struct fit_table *table, struct fit_penetration *out)
{
	double low = INFINITY, high = 0;
	memset(out, 0, sizeof *out);
	for (size_t i = 0; i < table->count; i++) {
		low = fmin(low, table->rows[i].x);
		high = fmax(high, table->rows[i].x);
	}
	if (table->count < 3)
		return fail_with(STATUS_INPUT, "%s: has %zu rows with a depth above 0, and 3 are needed; give more", table->path, table->count);
	if (!(high > low * (1 + 1e-9)))
		return fail_with(STATUS_INPUT, "%s: all rows have one depth; measure at several", table->path);
	out->strength = through_origin(table, SIZE_MAX);
	if (!(out->strength.value > 0))
		return fail_with(STATUS_INPUT, "%s: has no pressure above 0; check the column", table->path);
	with_offset(table, out);
	for (size_t g = 0; g < table->group_count; g++)
		out->alone[g] = through_origin(table, g);
	struct fit_sums sums = {.squares = 0};
	for (size_t i = 0; i < table->count; i++)
		fit_sums_add(&sums, &table->rows[i], FIT_LEVEL_PLATE * out->strength.value * table->rows[i].x);
	out->quality = fit_sums_end(&sums);
	return STATUS_OK;
}
