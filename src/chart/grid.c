/*
 * The grid of a map: lines of round coordinates, and where they meet the frame.
 *
 * Metres are those of the store's system: the origin of the store is added. Local metres have none. Degrees are longitude and latitude on
 * the store's body.
 * Their lines are curves on the map, drawn through CHART_GRID_POINTS points.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "chart/internal.h"
#include "dem/dem.h"

#define LINES_MOST 200 /* of one direction */

/* What a grid is made of. axis 0: lines that run north, of eastings or longitudes. */
struct finding {
	const struct chart_map *map;
	const struct chart_frame *frame;
	struct dem_globe *globe; /* NULL: metres */
	double origin[2];        /* coordinates of the south-west post */
	bool local;              /* they are 0 */
	double low[2], high[2];  /* coordinates in the frame */
	double step[2];
};

/* --- from coordinates to the page --- */

static void to_page(const struct finding *finding, double *x, double *y)
{
	const struct chart_frame *frame = finding->frame;
	if (finding->globe != NULL)
		dem_globe_from_degrees(finding->globe, 1, x, y);
	*x = frame->x + (*x - finding->origin[0]) * frame->scale;
	*y = frame->y - (*y - finding->origin[1]) * frame->scale;
}

/* From a place on the page, points. */
static void to_system(const struct finding *finding, double *x, double *y)
{
	const struct chart_frame *frame = finding->frame;
	*x = finding->origin[0] + (*x - frame->x) / frame->scale;
	*y = finding->origin[1] + (frame->y - *y) / frame->scale;
	if (finding->globe != NULL)
		dem_globe_to_degrees(finding->globe, 1, x, y);
}

/* Finds which coordinates are in the frame: at points along its edges and within it. Returns false if some have none, if they do
 * not go round once, as at a pole, or if all are the same. */
static bool find_bounds(struct finding *finding)
{
	const struct chart_rect *rect = &finding->frame->rect;
	enum { SIDE = 17 };
	double before = NAN;
	for (int axis = 0; axis < 2; axis++) {
		finding->low[axis] = INFINITY;
		finding->high[axis] = -INFINITY;
	}
	for (int i = 0; i < SIDE * SIDE; i++) {
		double at[2] = {rect->x0 + (rect->x1 - rect->x0) * (i % SIDE) / (SIDE - 1),
				rect->y0 + (rect->y1 - rect->y0) * (i / SIDE) / (SIDE - 1)};
		to_system(finding, &at[0], &at[1]);
		if (!isfinite(at[0]) || !isfinite(at[1]))
			return false;
		if (finding->globe != NULL && i % SIDE > 0 && fabs(at[0] - before) > 90)
			return false;
		before = at[0];
		for (int axis = 0; axis < 2; axis++) {
			finding->low[axis] = fmin(finding->low[axis], at[axis]);
			finding->high[axis] = fmax(finding->high[axis], at[axis]);
		}
	}
	/* So far from the origin that numbers cannot tell one edge from the other. */
	if (!(finding->high[0] > finding->low[0]) || !(finding->high[1] > finding->low[1]))
		return false;
	return finding->globe == NULL || finding->high[0] - finding->low[0] < 180;
}

/* --- lines --- */

/* One step for both directions, so that metres make squares. Where a side is shorter than it, its own. */
static void choose_steps(struct finding *finding, double apart)
{
	const struct chart_rect *rect = &finding->frame->rect;
	const double sides[2] = {rect->x1 - rect->x0, rect->y1 - rect->y0};
	double own[2];
	for (int axis = 0; axis < 2; axis++) {
		const double span = finding->high[axis] - finding->low[axis];
		own[axis] = chart_round_step(span / fmax(1, sides[axis] / apart));
	}
	const double common = fmax(own[0], own[1]);
	for (int axis = 0; axis < 2; axis++) {
		const double span = finding->high[axis] - finding->low[axis];
		double step = finding->globe == NULL && common <= span ? common : own[axis];
		/* At least two lines, so that the scale of both directions can be read. */
		while (ceil(finding->low[axis] / step) * step + step > finding->high[axis] && step > span / 8)
			step = chart_round_length(step * 0.6);
		finding->step[axis] = step;
	}
}

static void write_label(const struct finding *finding, struct chart_line *line)
{
	const struct store_meta *meta = finding->map->meta;
	char number[40];
	const double step = finding->step[line->north];
	if (finding->globe == NULL) {
		chart_number(line->value, step, number, sizeof number);
		snprintf(line->label, sizeof line->label, "%s %s", number, finding->local || meta->srs[0] == '\0' ? "m" : line->north ? "N" : "E");
		return;
	}
	double value = line->value;
	if (!line->north)
		value = remainder(value, 360);
	chart_number(fabs(value), step, number, sizeof number);
	const bool zero = fabs(value) < step / 2;
	snprintf(line->label, sizeof line->label, "%s°%s", number,
		 zero          ? ""
		 : line->north ? (value < 0 ? " S" : " N")
		 : value < 0   ? " W"
			       : " E");
}

/* Where the way from a to b crosses `edge` of the axis, within the frame. */
static bool crosses(const double a[2], const double b[2], int axis, double edge, double out[2])
{
	if ((a[axis] - edge) * (b[axis] - edge) > 0 || a[axis] == b[axis])
		return false;
	const double t = (edge - a[axis]) / (b[axis] - a[axis]);
	out[axis] = edge;
	out[1 - axis] = a[1 - axis] + t * (b[1 - axis] - a[1 - axis]);
	return true;
}

static void find_ends(const struct chart_frame *frame, struct chart_line *line)
{
	const struct chart_rect *rect = &frame->rect;
	const int axis = line->north ? 0 : 1; /* of the edges that it meets */
	const double edges[2] = {line->north ? rect->x0 : rect->y1, line->north ? rect->x1 : rect->y0};
	const double near = 1e-6, least = (line->north ? rect->y0 : rect->x0) - near,
		     most = (line->north ? rect->y1 : rect->x1) + near;
	for (int i = 0; i < 2; i++) {
		double *end = i == 0 ? line->low : line->high;
		bool found = false;
		for (size_t k = 0; k + 1 < line->count && !found; k++)
			found = crosses(line->points[k], line->points[k + 1], axis, edges[i], end) && end[1 - axis] >= least &&
				end[1 - axis] <= most;
		if (!found)
			end[0] = end[1] = NAN;
	}
}

static void make_line(const struct finding *finding, struct chart_line *line)
{
	const int other = line->north ? 0 : 1;
	/* A little beyond the frame, so that curves meet its edges. */
	const double more = 0.02 * (finding->high[other] - finding->low[other]);
	const double from = finding->low[other] - more, to = finding->high[other] + more;
	line->count = finding->globe == NULL ? 2 : CHART_GRID_POINTS;
	size_t kept = 0;
	for (size_t i = 0; i < line->count; i++) {
		double along = from + (to - from) * (double)i / (double)(line->count - 1);
		double x = line->north ? along : line->value, y = line->north ? line->value : along;
		to_page(finding, &x, &y);
		if (!isfinite(x) || !isfinite(y))
			continue;
		line->points[kept][0] = x;
		line->points[kept++][1] = y;
	}
	line->count = kept;
	find_ends(finding->frame, line);
	write_label(finding, line);
}

static enum status make_lines(const struct finding *finding, struct chart_lines *out)
{
	size_t counts[2];
	for (int axis = 0; axis < 2; axis++) {
		const double first = ceil(finding->low[axis] / finding->step[axis] - 1e-9),
			     last = floor(finding->high[axis] / finding->step[axis] + 1e-9);
		counts[axis] = last < first ? 0 : (size_t)fmin(last - first + 1, LINES_MOST);
	}
	out->lines = mem_calloc(counts[0] + counts[1], sizeof *out->lines);
	if (out->lines == NULL && counts[0] + counts[1] > 0)
		return fail_memory("a map's grid");
	for (int axis = 0; axis < 2; axis++)
		for (size_t i = 0; i < counts[axis]; i++) {
			struct chart_line *line = &out->lines[out->count++];
			line->north = axis == 1;
			line->value = (ceil(finding->low[axis] / finding->step[axis] - 1e-9) + (double)i) * finding->step[axis];
			make_line(finding, line);
		}
	return STATUS_OK;
}

static void describe(const struct finding *finding, char *text, size_t room)
{
	char name[128];
	chart_system_name(finding->map->meta->srs, name, sizeof name);
	const bool named = name[0] != '\0' && strcasecmp(name, "unnamed") != 0 && strcasecmp(name, "unknown") != 0;
	if (finding->globe != NULL)
		snprintf(text, room, "Longitude and latitude: %s", dem_globe_info(finding->globe)->name);
	else if (finding->local || (finding->map->meta->srs[0] == '\0' && finding->origin[0] == 0 && finding->origin[1] == 0))
		snprintf(text, room, "Metres east and north of the terrain's south-west post");
	else if (finding->map->meta->srs[0] == '\0')
		snprintf(text, room, "Metres of the terrain's source, which names no system");
	else
		snprintf(text, room, "Coordinates in metres: %s", named ? name : "the store's system, which has no name");
}

enum status chart_grid_find(const struct chart_map *map, const struct chart_frame *frame, double apart, struct chart_lines *out)
{
	struct finding finding = {.map = map, .frame = frame, .local = map->grid == CHART_GRID_LOCAL};
	for (int k = 0; k < 2 && !finding.local; k++)
		finding.origin[k] = map->meta->origin[k];
	*out = (struct chart_lines){NULL, 0, ""};
	if (map->grid == CHART_GRID_DEGREES) {
		if (map->meta->srs[0] != '\0')
			TRY(dem_globe_create(map->meta->srs, &finding.globe));
		if (finding.globe == NULL)
			note("the store has local metres, and no place on a globe: the map's grid is in metres");
	}
	bool found = find_bounds(&finding);
	if (!found && finding.globe != NULL) {
		note("the map has a pole, or places without degrees: its grid is in metres");
		dem_globe_destroy(finding.globe);
		finding.globe = NULL;
		found = find_bounds(&finding);
	}
	enum status status = STATUS_OK;
	if (found && map->grid != CHART_GRID_NONE) {
		choose_steps(&finding, apart);
		status = make_lines(&finding, out);
	}
	describe(&finding, out->system, sizeof out->system);
	dem_globe_destroy(finding.globe);
	return status;
}

void chart_grid_move(struct chart_lines *lines, double dx, double dy)
{
	for (size_t i = 0; i < lines->count; i++) {
		struct chart_line *line = &lines->lines[i];
		for (size_t k = 0; k < line->count; k++) {
			line->points[k][0] += dx;
			line->points[k][1] += dy;
		}
		double *const ends[2] = {line->low, line->high};
		for (int k = 0; k < 2; k++) {
			ends[k][0] += dx;
			ends[k][1] += dy;
		}
	}
}

void chart_grid_finish(struct chart_lines *lines)
{
	mem_free(lines->lines);
	*lines = (struct chart_lines){NULL, 0, ""};
}
