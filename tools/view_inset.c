/* What furrow view draws beside its line of figures, on the CPU: where vehicles were sent, a graph of the wheels, and the map in a corner. */
#include <math.h>
#include <stdio.h>

#include "view.h"

#define LARGE 1400u   /* as in view_picture.c: a picture wider than this has everything twice as large */
#define MARGIN 8      /* pixels, times the scale, as everything below */
#define LINE 13       /* height of letters */
#define POLE 34       /* height of the mark where a vehicle was sent, at least, */
#define POLE_METRES 1.5
#define GRAPH_WIDTH 300
#define GRAPH_HEIGHT 70 /* of each of the two */
#define TEXTS 74        /* width of what is written beside them */
#define SINKAGE_LEAST 0.01 /* m: of the graph's axis */
#define SLIP_LEAST 0.2
#define MAP_MOST 240
#define MAP_SHARE 0.34 /* of the window's sides */

static const struct chart_colour white = {255, 255, 255, 255}, band = {0, 0, 0, 170}, faint = {255, 255, 255, 60}, red = {230, 40, 30, 255},
				 yellow = {255, 220, 60, 255};
static const struct chart_colour colours[VIEW_WHEELS] = {{86, 180, 233, 255}, {230, 159, 0, 255}, {0, 200, 140, 255}, {240, 228, 66, 255},
							 {230, 110, 60, 255}, {204, 121, 167, 255}, {180, 180, 255, 255}, {200, 200, 200, 255}};

static int scale_of(uint32_t width)
{
	return width > LARGE ? 2 : 1;
}

static void dot(const struct chart_pixels *to, double x, double y, int half, struct chart_colour colour)
{
	const int left = (int)floor(x) - half, low = (int)floor(y) - half;
	chart_box(to, left, low, left + 2 * half + 1, low + 2 * half + 1, colour);
}

static void line(const struct chart_pixels *to, double x0, double y0, double x1, double y1, int half, struct chart_colour colour)
{
	const int steps = (int)fmin(fmax(fmax(fabs(x1 - x0), fabs(y1 - y0)), 1), 20000);
	for (int i = 0; i <= steps; i++)
		dot(to, x0 + (x1 - x0) * i / steps, y0 + (y1 - y0) * i / steps, half, colour);
}

/* --- targets --- */

/* A pole on the ground with a flag, also where a hill is before it. */
static void draw_pole(const struct chart_pixels *to, const struct render_camera *camera, const double foot[3], int scale)
{
	const double head[3] = {foot[0], foot[1], foot[2] + POLE_METRES};
	const int width = (int)to->width, height = (int)to->height;
	double x, y, top_x, top_y;
	if (!view_project(camera, width, height, foot, &x, &y) || !view_project(camera, width, height, head, &top_x, &top_y))
		return;
	if (fabs(x) > 4.0 * width || fabs(y) > 4.0 * height)
		return;
	const double low = height - y, high = fmin(fmax(height - top_y, low + POLE * scale), low + height);
	const int flag = (int)fmin(0.4 * (high - low), 40 * scale);
	line(to, x, low, x, high, scale, white);
	for (int i = 0; i < flag; i++) {
		const int left = (int)floor(x) + scale, wide = 2 * (i < flag / 2 ? i : flag - i);
		chart_box(to, left, (int)high - i - 1, left + wide, (int)high - i, red);
	}
	dot(to, x, low, 2 * scale, red);
}

enum status view_draw_targets(const struct viewer *viewer, struct drive *drive, uint8_t *pixels, uint32_t width, uint32_t height)
{
	const struct chart_pixels to = {pixels, width, height};
	struct render_camera camera;
	view_camera_now(viewer, drive, &camera);
	for (size_t i = 0; i < viewer->track.count; i++) {
		double foot[3];
		struct resident_height ground = {.height = NAN};
		if (!drive_target(drive, i, foot))
			continue;
		const struct resident_point point = {foot[0], foot[1]};
		TRY(drive_heights(drive, &point, 1, &ground));
		foot[2] = ground.height;
		if (isfinite(foot[2]))
			draw_pole(&to, &camera, foot, scale_of(width));
	}
	return STATUS_OK;
}

/* --- the graph --- */

struct axes {
	const struct chart_pixels *to;
	int x, y, width, height; /* from the lower left */
	double low, high;        /* values */
	double from;             /* s, at its left */
};

static double place_of(const struct axes *axes, double value)
{
	return axes->y + (fmin(fmax(value, axes->low), axes->high) - axes->low) / (axes->high - axes->low) * (axes->height - 1);
}

static void draw_curve(const struct axes *axes, const struct view_track *track, size_t wheel, bool slip)
{
	double before[2] = {NAN, NAN};
	for (size_t i = 0; i < track->samples; i++) {
		const struct view_sample *sample = &track->list[i];
		const double value = slip ? sample->slip[wheel] : sample->sinkage[wheel];
		const double x = axes->x + (sample->time - axes->from) / VIEW_SPAN * (axes->width - 1), y = isfinite(value) ? place_of(axes, value) : (double)NAN;
		if (isfinite(y) && isfinite(before[1]) && before[0] >= axes->x)
			line(axes->to, before[0], before[1], x, y, 0, colours[wheel]);
		else if (isfinite(y) && x >= axes->x)
			dot(axes->to, x, y, 0, colours[wheel]);
		before[0] = x;
		before[1] = y;
	}
}

/* Slip or sinkage of all wheels, with the ends of its axis beside it. */
static enum status draw_axes(const struct viewer *viewer, const struct axes *axes, bool slip, int scale)
{
	const struct view_track *track = &viewer->track;
	const int letters = LINE * scale, beside = axes->x + axes->width + 4 * scale;
	char text[32];
	for (double value = axes->low < 0 && axes->high > 0 ? 0 : axes->low; isfinite(value); value = value == 0 ? (double)NAN : 0)
		if (value >= axes->low && value <= axes->high)
			chart_box(axes->to, axes->x, (int)place_of(axes, value), axes->x + axes->width, (int)place_of(axes, value) + 1, faint);
	for (size_t wheel = 0; wheel < track->wheels; wheel++)
		draw_curve(axes, track, wheel, slip);
	if (viewer->pen == NULL)
		return STATUS_OK;
	snprintf(text, sizeof text, slip ? "%.2g" : "%.3g mm", slip ? axes->high : 1e3 * axes->high);
	TRY(chart_pen_write(viewer->pen, axes->to, beside, axes->y + axes->height - letters, letters, text, white));
	TRY(chart_pen_write(viewer->pen, axes->to, beside, axes->y + (axes->height - letters) / 2, letters, slip ? "slip" : "sinkage", white));
	snprintf(text, sizeof text, slip ? "%.2g" : "%.3g mm", slip ? axes->low : 1e3 * axes->low);
	return chart_pen_write(viewer->pen, axes->to, beside, axes->y, letters, text, white);
}

/* Returns how many letters all names begin with that part them from nothing. */
static size_t shared(const struct view_track *track)
{
	for (size_t letter = 0; track->wheels > 1; letter++)
		for (size_t i = 0; i < track->wheels; i++)
			if (track->names[i][letter] == '\0' || track->names[i][letter] != track->names[0][letter])
				return letter;
	return 0;
}

/* Below the graph each wheel's name in its colour, as many as there is room for. */
static enum status draw_names(const struct viewer *viewer, const struct chart_pixels *to, int x, int y, int most, int scale)
{
	const struct view_track *track = &viewer->track;
	const int letters = LINE * scale;
	const size_t skip = shared(track);
	if (viewer->pen != NULL && track->wheels == 0)
		return chart_pen_write(viewer->pen, to, x, y, letters, "no wheels", white);
	for (size_t i = 0; i < track->wheels && viewer->pen != NULL; i++) {
		const char *name = track->names[i] + (track->names[i][skip] != '\0' ? skip : 0);
		const int wide = chart_pen_width(viewer->pen, letters, name) + 8 * scale;
		if (wide > most)
			break;
		TRY(chart_pen_write(viewer->pen, to, x, y, letters, name, colours[i]));
		x += wide;
		most -= wide;
	}
	return STATUS_OK;
}

enum status view_draw_graph(const struct viewer *viewer, const struct drive *drive, uint8_t *pixels, uint32_t width, uint32_t height)
{
	const struct chart_pixels to = {pixels, width, height};
	const struct view_track *track = &viewer->track;
	const int scale = scale_of(width), margin = MARGIN * scale, letters = LINE * scale;
	const int wide = (int)fmin(GRAPH_WIDTH * scale, 0.8 * width - 3 * margin - TEXTS * scale), high = (int)fmin(GRAPH_HEIGHT * scale, height / 5.0);
	const int x = (int)width - wide - TEXTS * scale - 2 * margin, y = 2 * margin + letters;
	if (!viewer->graph || wide < 20)
		return STATUS_OK;
	double slips[2] = {0, SLIP_LEAST}, deep = SINKAGE_LEAST;
	for (size_t i = 0; i < track->samples; i++)
		for (size_t wheel = 0; wheel < track->wheels; wheel++) {
			const double slip = track->list[i].slip[wheel];
			slips[0] = isfinite(slip) ? fmax(fmin(slips[0], slip), -1) : slips[0];
			slips[1] = isfinite(slip) ? fmin(fmax(slips[1], slip), 1) : slips[1];
			deep = fmax(deep, track->list[i].sinkage[wheel]);
		}
	struct axes axes = {&to, x, y, wide, high, 0, deep, drive_time(drive) - VIEW_SPAN};
	chart_box(&to, x - margin, margin / 2, (int)width - margin / 2, y + 2 * high + 2 * margin, band);
	TRY(draw_axes(viewer, &axes, false, scale));
	axes.y += high + margin;
	axes.low = slips[0];
	axes.high = slips[1];
	TRY(draw_axes(viewer, &axes, true, scale));
	return draw_names(viewer, &to, x, margin, wide + TEXTS * scale, scale);
}

/* --- the map --- */

static void draw_ground(const struct view_map *map, const struct chart_pixels *to)
{
	for (int y = 0; y < (int)(map->zoom * map->height); y++)
		for (int x = 0; x < (int)(map->zoom * map->width); x++) {
			const uint32_t column = (uint32_t)fmin(x / map->zoom, map->width - 1), row = (uint32_t)fmin(y / map->zoom, map->height - 1);
			const uint8_t grey = map->shade[(size_t)row * map->width + column];
			chart_box(to, map->x + x, map->y + y, map->x + x + 1, map->y + y + 1, (struct chart_colour){grey, grey, grey, 255});
		}
}

/* Where a place is, pixels. */
static void on_map(const struct view_map *map, const double place[2], double at[2])
{
	at[0] = map->x + fmin(fmax(place[0] / map->metres + 0.5, 0), map->width - 1e-3) * map->zoom;
	at[1] = map->y + fmin(fmax(place[1] / map->metres + 0.5, 0), map->height - 1e-3) * map->zoom;
}

static void draw_way(const struct view_map *map, const struct chart_pixels *to, const struct view_way *way, const double now[2], struct chart_colour colour)
{
	double at[2], next[2];
	for (size_t i = 0; i < way->count; i++) {
		on_map(map, way->places[i], at);
		on_map(map, i + 1 < way->count ? way->places[i + 1] : now, next);
		line(to, at[0], at[1], next[0], next[1], 0, colour);
	}
}

/* A dot, and a line ahead of it. What is followed is red. */
static void draw_one(const struct viewer *viewer, const struct drive *drive, const struct chart_pixels *to, size_t number, int scale)
{
	const struct view_map *map = &viewer->map;
	const bool followed = viewer->eye.mode == VIEW_MODE_FOLLOW && viewer->eye.object == number;
	const struct chart_colour colour = followed ? red : number < drive_scene(drive)->object_count ? colours[0] : yellow;
	double place[3], yaw, at[2], target[2];
	drive_place(drive, number, place, &yaw);
	draw_way(map, to, &viewer->track.ways[number], place, colour);
	on_map(map, place, at);
	dot(to, at[0], at[1], 3 * scale, (struct chart_colour){0, 0, 0, 255});
	line(to, at[0], at[1], at[0] + 9 * scale * cos(yaw), at[1] + 9 * scale * sin(yaw), 0, (struct chart_colour){0, 0, 0, 255});
	dot(to, at[0], at[1], 3 * scale - 1, colour);
	if (!drive_target(drive, number, target))
		return;
	on_map(map, target, at);
	line(to, at[0] - 3 * scale, at[1] - 3 * scale, at[0] + 3 * scale, at[1] + 3 * scale, scale - 1, red);
	line(to, at[0] - 3 * scale, at[1] + 3 * scale, at[0] + 3 * scale, at[1] - 3 * scale, scale - 1, red);
}

enum status view_draw_map(struct viewer *viewer, const struct drive *drive, uint8_t *pixels, uint32_t width, uint32_t height, int top)
{
	const struct chart_pixels to = {pixels, width, height};
	struct view_map *map = &viewer->map;
	const int scale = scale_of(width), margin = MARGIN * scale;
	map->zoom = 0;
	if (!viewer->shows_map || map->shade == NULL)
		return STATUS_OK;
	const double most = MAP_MOST * scale;
	map->zoom = fmin(fmin(most, MAP_SHARE * width) / map->width, fmin(most, 2 * MAP_SHARE * height) / map->height);
	map->x = (int)width - margin - (int)(map->zoom * map->width);
	map->y = top - margin - (int)(map->zoom * map->height);
	chart_box(&to, map->x - 2 * scale, map->y - 2 * scale, map->x + (int)(map->zoom * map->width) + 2 * scale, top - margin + 2 * scale, band);
	draw_ground(map, &to);
	for (size_t i = 0; i < viewer->track.count; i++)
		draw_one(viewer, drive, &to, i, scale);
	return STATUS_OK;
}
