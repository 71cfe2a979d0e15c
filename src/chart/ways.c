/*
 * The ways of objects and vehicles: lines with a white edge, a mark where each begins, an arrow where it ends, and names.
 *
 * Ways are told apart by colour, by dashes and by the mark, so that they are distinct in print and to every eye. The colours are
 * Okabe's and Ito's, without those that the ruts have.
 */
#include <math.h>
#include <string.h>

#include "chart/page.h"

#define WIDTH 0.75 /* points: of a way, so that the ruts under it are seen beside it */
#define EDGE 1.45  /* with its white edge */
#define MARK 2.3   /* points: half of a mark */
#define ARROW 5.0
#define BEYOND 20.0    /* points outside the frame at which lines are cut */
#define NAMES_MOST 400 /* names that are tried */
#define NAME_LONGEST 150.0

static const struct chart_colour colours[] = {
	{0, 158, 115, 255}, {0, 0, 0, 255}, {170, 60, 140, 255}, {0, 120, 190, 255}, {150, 105, 0, 255}, {105, 105, 105, 255},
};
#define COLOURS (sizeof colours / sizeof *colours)
static const double dashes[3][4] = {{0}, {5, 2.5}, {1.4, 2.2}};
static const int dash_counts[3] = {0, 2, 2};

struct chart_pattern chart_way_pattern(size_t way, bool vehicle)
{
	const size_t dash = way / COLOURS % 3;
	struct chart_pattern pattern = {.colour = colours[way % COLOURS], .dash_count = dash_counts[dash], .shape = vehicle};
	memcpy(pattern.dashes, dashes[dash], sizeof pattern.dashes);
	return pattern;
}

/* --- lines --- */

/* Cuts the way from a to b at the rectangle. Returns false if none of it is within. */
static bool cut(const struct chart_rect *rect, double a[2], double b[2])
{
	const double low[2] = {rect->x0, rect->y0}, high[2] = {rect->x1, rect->y1}, from[2] = {a[0], a[1]},
		     way[2] = {b[0] - a[0], b[1] - a[1]};
	double s = 0, e = 1;
	for (int axis = 0; axis < 2; axis++) {
		if (way[axis] == 0) {
			if (from[axis] < low[axis] || from[axis] > high[axis])
				return false;
			continue;
		}
		const double p = (low[axis] - from[axis]) / way[axis], q = (high[axis] - from[axis]) / way[axis];
		s = fmax(s, fmin(p, q));
		e = fmin(e, fmax(p, q));
	}
	if (!(s <= e))
		return false;
	for (int axis = 0; axis < 2; axis++) {
		a[axis] = from[axis] + s * way[axis];
		b[axis] = from[axis] + e * way[axis];
	}
	return true;
}

static void on_page(const struct chart_frame *frame, const double place[2], double out[2])
{
	out[0] = frame->x + place[0] * frame->scale;
	out[1] = frame->y - place[1] * frame->scale;
}

/* Makes the way the path of Cairo, and adds it to what names should not cover. Points that nobody sees apart are left out. */
static void trace(cairo_t *cairo, const struct chart_frame *frame, const struct chart_way *way, struct chart_cover *cover)
{
	const struct chart_rect *rect = &frame->rect;
	const struct chart_rect near = {rect->x0 - BEYOND, rect->y0 - BEYOND, rect->x1 + BEYOND, rect->y1 + BEYOND};
	double from[2], pen[2] = {NAN, NAN};
	on_page(frame, way->places[0], from);
	for (size_t i = 1; i < way->count; i++) {
		double to[2], a[2], b[2];
		on_page(frame, way->places[i], to);
		if (i + 1 < way->count && hypot(to[0] - from[0], to[1] - from[1]) < 0.15)
			continue;
		memcpy(a, from, sizeof a);
		memcpy(b, to, sizeof b);
		memcpy(from, to, sizeof from);
		if (!cut(&near, a, b))
			continue;
		if (a[0] != pen[0] || a[1] != pen[1])
			cairo_move_to(cairo, a[0], a[1]);
		cairo_line_to(cairo, b[0], b[1]);
		memcpy(pen, b, sizeof pen);
		if (cover != NULL)
			chart_cover_line(cover, a, b);
	}
}

static void stroke(cairo_t *cairo, const struct chart_pattern *pattern)
{
	cairo_set_line_cap(cairo, CAIRO_LINE_CAP_ROUND);
	cairo_set_source_rgba(cairo, 1, 1, 1, 0.4);
	cairo_set_line_width(cairo, EDGE);
	cairo_stroke_preserve(cairo);
	cairo_set_line_cap(cairo, pattern->dash_count > 0 ? CAIRO_LINE_CAP_BUTT : CAIRO_LINE_CAP_ROUND);
	cairo_set_dash(cairo, pattern->dashes, pattern->dash_count, 0);
	cairo_set_line_width(cairo, WIDTH);
	cairo_set_source_rgb(cairo, pattern->colour.r / 255.0, pattern->colour.g / 255.0, pattern->colour.b / 255.0);
	cairo_stroke(cairo);
	cairo_set_dash(cairo, NULL, 0, 0);
	cairo_set_line_cap(cairo, CAIRO_LINE_CAP_BUTT);
}

/* --- marks --- */

static void mark(struct chart_page *page, const struct chart_pattern *pattern, double x, double y)
{
	cairo_t *cairo = page->cairo;
	cairo_new_sub_path(cairo);
	if (pattern->shape != 0)
		cairo_rectangle(cairo, x - MARK * 0.9, y - MARK * 0.9, 1.8 * MARK, 1.8 * MARK);
	else
		cairo_arc(cairo, x, y, MARK, 0, 2 * M_PI);
	cairo_set_source_rgb(cairo, 1, 1, 1);
	cairo_set_line_width(cairo, 1.8);
	cairo_stroke_preserve(cairo);
	chart_page_colour(page, pattern->colour);
	cairo_fill(cairo);
}

/* An arrow at the end of a way that is longer than it. */
static void arrow(struct chart_page *page, const struct chart_pattern *pattern, const struct chart_frame *frame,
		  const struct chart_way *way)
{
	double tip[2], from[2];
	size_t i = way->count - 1;
	on_page(frame, way->places[i], tip);
	do {
		if (i == 0)
			return;
		on_page(frame, way->places[--i], from);
	} while (hypot(tip[0] - from[0], tip[1] - from[1]) < ARROW);
	const double far = hypot(tip[0] - from[0], tip[1] - from[1]), c = (tip[0] - from[0]) / far, s = (tip[1] - from[1]) / far;
	const struct chart_rect *rect = &frame->rect;
	if (!(tip[0] >= rect->x0 && tip[0] <= rect->x1 && tip[1] >= rect->y0 && tip[1] <= rect->y1))
		return;
	cairo_t *cairo = page->cairo;
	cairo_move_to(cairo, tip[0] + 0.4 * ARROW * c, tip[1] + 0.4 * ARROW * s);
	cairo_line_to(cairo, tip[0] - ARROW * (0.6 * c - 0.42 * s), tip[1] - ARROW * (0.6 * s + 0.42 * c));
	cairo_line_to(cairo, tip[0] - ARROW * (0.6 * c + 0.42 * s), tip[1] - ARROW * (0.6 * s - 0.42 * c));
	cairo_close_path(cairo);
	cairo_set_source_rgb(cairo, 1, 1, 1);
	cairo_set_line_width(cairo, 1.2);
	cairo_stroke_preserve(cairo);
	chart_page_colour(page, pattern->colour);
	cairo_fill(cairo);
}

void chart_way_sample(struct chart_page *page, size_t way, bool vehicle, double x, double y, double length)
{
	const struct chart_pattern pattern = chart_way_pattern(way, vehicle);
	cairo_move_to(page->cairo, x + MARK, y);
	cairo_line_to(page->cairo, x + length, y);
	stroke(page->cairo, &pattern);
	mark(page, &pattern, x + MARK, y);
}

/* --- names --- */

static const struct chart_style name_style = {.kind = CHART_NAME, .size = 7.5, .bold = true, .most = NAME_LONGEST, .halo = true};

static bool begins_in(const struct chart_frame *frame, const struct chart_way *way, double out[2])
{
	if (way->count == 0)
		return false;
	on_page(frame, way->places[0], out);
	return out[0] >= frame->rect.x0 && out[0] <= frame->rect.x1 && out[1] >= frame->rect.y0 && out[1] <= frame->rect.y1;
}

static struct chart_colour dark(struct chart_colour colour)
{
	return (struct chart_colour){colour.r * 3 / 5, colour.g * 3 / 5, colour.b * 3 / 5, 255};
}

static void draw_name(struct chart_page *page, const struct chart_label *label, const struct chart_way *way,
		      struct chart_colour colour)
{
	struct chart_style style = name_style;
	if (label->led) {
		cairo_set_line_width(page->cairo, 1.4);
		for (int i = 0; i < 2; i++) {
			cairo_move_to(page->cairo, label->x, label->y);
			cairo_line_to(page->cairo, label->lead[0], label->lead[1]);
			chart_page_colour(page, i == 0 ? (struct chart_colour){255, 255, 255, 190} : chart_ink);
			cairo_stroke(page->cairo);
			cairo_set_line_width(page->cairo, 0.5);
		}
	}
	style.colour = dark(colour);
	chart_text(page, &style, label->rect.x0, label->rect.y0, way->name);
}

/* `which`: the way of each label. */
static void draw_names(struct chart_page *page, const struct chart_map *map, struct chart_label *labels, const size_t *which,
		       size_t count, struct chart_written *written)
{
	for (size_t i = 0; i < count; i++) {
		const struct chart_way *way = &map->ways[which[i]];
		if (labels[i].shown) {
			draw_name(page, &labels[i], way, chart_way_pattern(which[i], way->vehicle).colour);
			written->unlabelled--;
		}
	}
}

static enum status name_ways(struct chart_page *page, const struct chart_map *map, const struct chart_frame *frame,
			     const struct chart_cover *cover, struct chart_written *written)
{
	const struct chart_rect inside = {frame->rect.x0 + 2, frame->rect.y0 + 2, frame->rect.x1 - 2, frame->rect.y1 - 2};
	const size_t room = map->way_count < NAMES_MOST ? map->way_count : NAMES_MOST;
	struct chart_label *labels = mem_calloc(room, sizeof *labels);
	size_t *which = mem_calloc(room, sizeof *which), count = 0;
	enum status status;
	TRY_OR(done, room == 0 || (labels != NULL && which != NULL) ? STATUS_OK : fail_memory("a map's names"));
	for (size_t i = 0; i < map->way_count && count < room; i++) {
		double at[2];
		if (!begins_in(frame, &map->ways[i], at))
			continue;
		labels[count] = (struct chart_label){.x = at[0], .y = at[1]};
		chart_text_size(page, &name_style, map->ways[i].name, &labels[count].width, &labels[count].height);
		which[count++] = i;
	}
	chart_labels_place(labels, count, &inside, cover);
	draw_names(page, map, labels, which, count, written);
done:
	mem_free_all(labels, which);
	return status;
}

enum status chart_ways_draw(struct chart_page *page, const struct chart_map *map, const struct chart_frame *frame,
			    struct chart_written *written)
{
	struct chart_cover cover;
	TRY(chart_cover_create(&frame->rect, &cover));
	cairo_t *cairo = page->cairo;
	cairo_save(cairo);
	cairo_rectangle(cairo, frame->rect.x0, frame->rect.y0, frame->rect.x1 - frame->rect.x0, frame->rect.y1 - frame->rect.y0);
	cairo_clip(cairo);
	for (size_t i = 0; i < map->way_count; i++) {
		const struct chart_way *way = &map->ways[i];
		const struct chart_pattern pattern = chart_way_pattern(i, way->vehicle);
		if (way->count == 0)
			continue;
		trace(cairo, frame, way, &cover);
		stroke(cairo, &pattern);
		arrow(page, &pattern, frame, way);
		written->names++;
	}
	for (size_t i = 0; i < map->way_count; i++) {
		const struct chart_pattern pattern = chart_way_pattern(i, map->ways[i].vehicle);
		double at[2];
		if (begins_in(frame, &map->ways[i], at))
			mark(page, &pattern, at[0], at[1]);
	}
	written->unlabelled = written->names;
	const enum status status = name_ways(page, map, frame, &cover, written);
	cairo_restore(cairo);
	chart_cover_finish(&cover);
	return status;
}
