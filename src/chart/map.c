/*
 * A map as it is printed. Its frame has the ground, the grid, the ways and their names; coordinates stand outside it. The title is
 * above. The legend, the scale bar and the arrow are below a broad map and right of a tall one, with the notes under them.
 *
 * Lengths are points (1/72 inch). Words have one size, whatever the map's: the frame is as long as asked for.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "chart/page.h"
#include "dem/dem.h"

#define MARGIN 20.0
#define PANEL 164.0         /* width of what is right of a tall map */
#define PANEL_CLASSES 212.0 /* with classes, whose names are longer than numbers */
#define INNER_LEAST 340.0   /* width of what is below a broad one */
#define TALL 1.25           /* height of a tall map, of its width */
#define TICK 3.0
#define COORDINATES 11.0 /* room for them beside the frame, with ticks */
#define APART 62.0       /* least distance of two lines of the grid */
#define BLOCK 12.0       /* between parts of the legend */
#define WAY_LINES 6      /* of the list of ways below a map */
#define SCALE_MOST 120.0
#define MM (72 / 25.4)

static const struct chart_style title_style = {.kind = CHART_TITLE, .size = 13, .bold = true, .colour = {32, 36, 42, 255}};
static const struct chart_style subtitle_style = {.kind = CHART_TITLE, .size = 8, .colour = {98, 104, 112, 255}};
static const struct chart_style coordinate_style = {.kind = CHART_COORDINATE, .size = 6.8, .colour = {62, 68, 76, 255}};
static const struct chart_style note_style = {.kind = CHART_NOTE, .size = 6.5, .lines = 9, .colour = {98, 104, 112, 255}};

struct layout {
	const struct chart_map *map;
	struct chart_frame frame;
	struct chart_legend legend;
	struct chart_lines grid;
	bool tall;
	double width, height, inner; /* inner: between the margins */
	struct chart_rect panel;     /* of legend, scale and notes */
	double title_height, subtitle_height, notes_height;
	char notes[800];
};

/* --- where all of it is: the frame and its grid first, then the page around them --- */

static void size_frame(struct layout *layout)
{
	const struct chart_map *map = layout->map;
	const struct chart_raster *raster = map->raster;
	const double longest = raster->width > raster->height ? raster->width : raster->height;
	const double size = (map->size > 0 ? map->size : CHART_SIZE) * MM, dots = map->pixels / size;
	struct chart_frame *frame = &layout->frame;
	frame->width = (uint32_t)fmax(1, lround(map->pixels * raster->width / longest));
	frame->height = (uint32_t)fmax(1, lround(map->pixels * raster->height / longest));
	frame->rect = (struct chart_rect){0, 0, frame->width / dots, frame->height / dots};
	frame->scale = frame->rect.x1 / (raster->width * raster->spacing);
	frame->x = (0.5 - (double)raster->rect.x0) * raster->spacing * frame->scale;
	frame->y = frame->rect.y1 - (0.5 - (double)raster->rect.y0) * raster->spacing * frame->scale;
	layout->tall = frame->rect.y1 > TALL * frame->rect.x1;
}

/* By what share distances on the ground differ from those of the map. GDAL, which takes long to load, is asked only where the store says that they
 * do, or does not say. */
static double ground_off(const struct chart_map *map)
{
	if (map->meta->ground_off == 0)
		return 0;
	const struct chart_raster *raster = map->raster;
	const double *origin = map->meta->origin, s = raster->spacing;
	return dem_ground_off(map->meta->srs, (double[2]){origin[0] + (double)raster->rect.x0 * s, origin[1] + (double)raster->rect.y0 * s},
			      (double[2]){origin[0] + (double)(raster->rect.x1 - 1) * s, origin[1] + (double)(raster->rect.y1 - 1) * s});
}

static void write_notes(struct layout *layout)
{
	const struct chart_raster *raster = layout->map->raster;
	const long long every = 1LL << (raster->level > 0 ? raster->level : 0);
	const double off = ground_off(layout->map);
	char length[64], own[64], inset[64] = "", posts[264], ruts[160] = "", scale[160] = "";
	chart_length(raster->spacing / (double)every, length, sizeof length);
	if (every > 1)
		snprintf(posts, sizeof posts, "Drawn from every %lld%s post: posts are %s apart.", every, every % 10 == 2 && every % 100 != 12 ? "nd" : "th", length);
	else if (raster->level < 0 && raster->rut == 0) {
		chart_length(raster->spacing * (double)(1LL << -raster->level), own, sizeof own);
		if (raster->inset > 0)
			chart_length(raster->inset, inset, sizeof inset);
		snprintf(posts, sizeof posts, "Drawn at %s; the terrain's own posts are %s apart%s%s.", length, own, inset[0] != '\0' ? ", those of its inset " : "", inset);
	} else
		snprintf(posts, sizeof posts, raster->rut > 0 ? "Pixels are %s wide." : "Posts are %s apart.", length);
	chart_length(raster->rut, length, sizeof length);
	if (raster->rut > 0)
		snprintf(ruts, sizeof ruts, " Ruts are drawn at least %s wide, so that they are seen.", length);
	if (off != 0)
		snprintf(scale, sizeof scale, " The scale bar has metres of the map: on the ground distances are up to %.2g %% %s.", 100 * fabs(off),
			 off < 0 ? "shorter" : "longer");
	snprintf(layout->notes, sizeof layout->notes, "%s. North is grid north. %s%s%s", layout->grid.system, posts, ruts, scale);
}

static double text_height(struct chart_page *page, const struct chart_style *style, const char *text)
{
	double width, height;
	chart_text_size(page, style, text, &width, &height);
	return text[0] != '\0' ? height : 0;
}

/* Height of what the panel has. */
static double measure_panel(struct chart_page *page, struct layout *layout, double width, double room)
{
	struct chart_legend *legend = &layout->legend;
	struct chart_style style = note_style;
	chart_legend_measure(page, legend, width, room);
	style.most = width;
	/* Room for the sentence about names that is added when they are placed. */
	layout->notes_height =
		text_height(page, &style, layout->notes) + (layout->map->way_count > 0 ? text_height(page, &style, "x") : 0);
	const double marks = CHART_NORTH_HEIGHT, ways = legend->ways_height > 0 ? legend->ways_height + BLOCK : 0;
	const double values = layout->tall ? legend->values_height + BLOCK + marks : fmax(legend->values_height, marks);
	return values + BLOCK + ways + layout->notes_height;
}

static void arrange(struct chart_page *page, struct layout *layout)
{
	struct chart_frame *frame = &layout->frame;
	const double frame_width = frame->rect.x1, frame_height = frame->rect.y1;
	layout->title_height = text_height(page, &title_style, layout->map->title);
	layout->subtitle_height = text_height(page, &subtitle_style, layout->map->subtitle);
	const double left = MARGIN + COORDINATES, top = MARGIN - 2 + layout->title_height + layout->subtitle_height + 7;
	const double panel = layout->map->classes != NULL ? PANEL_CLASSES : PANEL;
	double right, below;
	if (layout->tall) {
		const double fixed = measure_panel(page, layout, panel, 0) - layout->legend.ways_height;
		const double high = measure_panel(page, layout, panel, fmax(frame_height - fixed, 60));
		layout->panel = (struct chart_rect){left + frame_width + 18, top, left + frame_width + 18 + panel,
						    top + fmax(high, frame_height)};
		right = layout->panel.x1;
		below = fmax(top + frame_height + COORDINATES, top + high);
	} else {
		const double inner = fmax(frame_width, INNER_LEAST);
		const double high = measure_panel(page, layout, inner, 11.5 * (WAY_LINES + 1) + 1),
			     first = top + frame_height + COORDINATES + 10;
		layout->panel = (struct chart_rect){left, first, left + inner, first + high};
		right = layout->panel.x1;
		below = layout->panel.y1;
	}
	layout->width = ceil(right + MARGIN);
	layout->height = ceil(below + MARGIN - 4);
	layout->inner = right - left;
	const double dots = frame->width / frame_width, x = layout->tall ? left : left + (layout->inner - frame_width) / 2;
	/* The ground's pixels are those of the picture. */
	const double dx = round(x * dots) / dots, dy = round(top * dots) / dots;
	frame->rect = (struct chart_rect){dx, dy, dx + frame_width, dy + frame_height};
	frame->x += dx;
	frame->y += dy;
	chart_grid_move(&layout->grid, dx, dy);
}

/* --- the grid --- */

static void draw_lines(struct chart_page *page, const struct layout *layout)
{
	const struct chart_rect *rect = &layout->frame.rect;
	cairo_t *cairo = page->cairo;
	cairo_save(cairo);
	cairo_rectangle(cairo, rect->x0, rect->y0, rect->x1 - rect->x0, rect->y1 - rect->y0);
	cairo_clip(cairo);
	for (size_t i = 0; i < layout->grid.count; i++) {
		const struct chart_line *line = &layout->grid.lines[i];
		for (size_t k = 0; k < line->count; k++)
			cairo_line_to(cairo, line->points[k][0], line->points[k][1]);
		cairo_new_sub_path(cairo);
	}
	cairo_set_source_rgba(cairo, 0.1, 0.15, 0.2, 0.28);
	cairo_set_line_width(cairo, 0.45);
	cairo_stroke(cairo);
	cairo_restore(cairo);
}

static void tick(struct chart_page *page, const double at[2], double dx, double dy)
{
	if (isnan(at[0]))
		return;
	cairo_move_to(page->cairo, at[0], at[1]);
	cairo_line_to(page->cairo, at[0] + dx, at[1] + dy);
	cairo_stroke(page->cairo);
}

/* Coordinates stand below and left of the frame. One that has no room beside the one before is left out. */
static void draw_coordinates(struct chart_page *page, const struct layout *layout)
{
	const struct chart_rect *rect = &layout->frame.rect;
	double taken_x = -INFINITY, taken_y = INFINITY;
	cairo_set_line_width(page->cairo, 0.6);
	for (size_t i = 0; i < layout->grid.count; i++) {
		const struct chart_line *line = &layout->grid.lines[i];
		struct chart_style style = coordinate_style;
		double width, height;
		chart_page_colour(page, chart_ink);
		tick(page, line->low, line->north ? -TICK : 0, line->north ? 0 : TICK);
		tick(page, line->high, line->north ? TICK : 0, line->north ? 0 : -TICK);
		if (isnan(line->low[0]))
			continue;
		chart_text_size(page, &style, line->label, &width, &height);
		if (line->north) {
			style.turned = true;
			/* Not beyond the frame's corners, where the others and the title are. */
			const double y = fmax(rect->y0 - 1, fmin(line->low[1] - width / 2, rect->y1 + 1 - width));
			if (y + width > taken_y || y + width > rect->y1 + 2)
				continue;
			chart_text(page, &style, rect->x0 - TICK - 1 - height, y, line->label);
			taken_y = y - 6;
		} else {
			const double x = fmax(4, fmin(line->low[0] - width / 2, layout->width - 4 - width));
			if (x < taken_x)
				continue;
			chart_text(page, &style, x, rect->y1 + TICK + 0.5, line->label);
			taken_x = x + width + 6;
		}
	}
}

/* --- all of it --- */

static void draw_head(struct chart_page *page, const struct layout *layout)
{
	struct chart_style style = title_style;
	const double x = MARGIN + COORDINATES;
	style.most = layout->inner;
	chart_text(page, &style, x, MARGIN - 2, layout->map->title);
	style = subtitle_style;
	style.most = layout->inner;
	if (layout->map->subtitle[0] != '\0')
		chart_text(page, &style, x, MARGIN - 2 + layout->title_height, layout->map->subtitle);
}

static void add_unlabelled(struct layout *layout, const struct chart_written *written)
{
	const size_t used = strlen(layout->notes);
	if (written->unlabelled > 0)
		snprintf(layout->notes + used, sizeof layout->notes - used, " %zu of %zu names have no room on the map.",
			 written->unlabelled, written->names);
}

static void draw_notes(struct chart_page *page, const struct layout *layout, double y)
{
	struct chart_style style = note_style;
	style.most = layout->panel.x1 - layout->panel.x0;
	chart_text(page, &style, layout->panel.x0, y, layout->notes);
}

/* Right of the map: what its colours and lines mean at the top, scale and notes at the bottom. */
static void draw_tall_panel(struct chart_page *page, const struct layout *layout)
{
	const struct chart_legend *legend = &layout->legend;
	const struct chart_rect *panel = &layout->panel;
	const double metres = 1 / layout->frame.scale, bar = chart_scale_length(SCALE_MOST, metres);
	const double notes = panel->y1 - layout->notes_height, marks = notes - BLOCK - CHART_NORTH_HEIGHT;
	chart_legend_values(page, legend, panel->x0, panel->y0);
	chart_legend_ways(page, legend, panel->x0, panel->y0 + legend->values_height + BLOCK);
	chart_scale_bar(page, panel->x0 + 3, marks + 11, SCALE_MOST, metres);
	chart_north(page, panel->x0 + fmax(bar + 32, PANEL - 12), marks);
	draw_notes(page, layout, notes);
}

static void draw_broad_panel(struct chart_page *page, const struct layout *layout)
{
	const struct chart_legend *legend = &layout->legend;
	const struct chart_rect *panel = &layout->panel;
	const double metres = 1 / layout->frame.scale, bar = chart_scale_length(SCALE_MOST, metres), arrow = panel->x1 - 8;
	double y = panel->y0;
	chart_legend_values(page, legend, panel->x0, y);
	chart_scale_bar(page, arrow - 30 - bar, y + 11, SCALE_MOST, metres);
	chart_north(page, arrow, y);
	y += fmax(legend->values_height, CHART_NORTH_HEIGHT) + BLOCK;
	chart_legend_ways(page, legend, panel->x0, y);
	y += legend->ways_height > 0 ? legend->ways_height + BLOCK : 0;
	draw_notes(page, layout, y);
}

static enum status draw_ground(struct chart_page *page, const struct layout *layout)
{
	const struct chart_frame *frame = &layout->frame;
	uint32_t *pixels = mem_alloc((size_t)frame->width * frame->height, sizeof *pixels);
	TRY_MEM(pixels, "a map");
	chart_relief_fill(layout->map, &layout->legend.range, frame, pixels, frame->width);
	enum status status = chart_page_image(page, pixels, frame->width, frame->height, &frame->rect);
	mem_free(pixels);
	return status;
}

static enum status draw(struct chart_page *page, struct layout *layout, struct chart_written *written)
{
	const struct chart_rect *rect = &layout->frame.rect;
	TRY(draw_ground(page, layout));
	draw_lines(page, layout);
	TRY(chart_ways_draw(page, layout->map, &layout->frame, written));
	chart_page_colour(page, chart_ink);
	cairo_set_line_width(page->cairo, 0.8);
	cairo_rectangle(page->cairo, rect->x0 - 0.4, rect->y0 - 0.4, rect->x1 - rect->x0 + 0.8, rect->y1 - rect->y0 + 0.8);
	cairo_stroke(page->cairo);
	draw_coordinates(page, layout);
	draw_head(page, layout);
	add_unlabelled(layout, written);
	if (layout->tall)
		draw_tall_panel(page, layout);
	else
		draw_broad_panel(page, layout);
	return STATUS_OK;
}

/* A post is in the middle of its pixels. `dots`: pixels a point. */
static struct chart_place place_of(const struct chart_raster *raster, const struct chart_frame *frame, double dots)
{
	struct chart_place place = {
		.east = raster->width * raster->spacing / frame->width,
		.south = raster->height * raster->spacing / frame->height,
	};
	place.west_edge = ((double)raster->rect.x0 - 0.5) * raster->spacing - frame->rect.x0 * dots * place.east;
	place.north_edge = ((double)raster->rect.y1 - 0.5) * raster->spacing + frame->rect.y0 * dots * place.south;
	return place;
}

/* Of ways that are joined. */
static enum status write_page(const struct chart_map *map, const char *path, struct chart_page *page, struct chart_frame *frame,
			      struct chart_written *written)
{
	struct layout layout = {.map = map, .legend = {.map = map}};
	enum chart_format format = CHART_PNG;
	assert(map->pixels >= 1 && map->pixels <= CHART_PIXELS_MOST);
	*written = (struct chart_written){.width = 0};
	if (!chart_path_format(path, &format))
		return fail_with(STATUS_USAGE, "%s: is no map's name; give one that ends in .png, .svg or .pdf", path);
	TRY(chart_page_create(page));
	TRY(chart_relief_range(map, &layout.legend.range, layout.legend.beyond));
	layout.legend.holes = chart_relief_has_holes(map);
	size_frame(&layout);
	const double dots = layout.frame.width / layout.frame.rect.x1;
	enum status status;
	TRY_OR(done, chart_grid_find(map, &layout.frame, APART, &layout.grid));
	write_notes(&layout);
	arrange(page, &layout);
	TRY_OR(done, chart_page_open(page, path, format, layout.width, layout.height, dots, map->title));
	TRY_OR(done, draw(page, &layout, written));
	*frame = layout.frame;
	written->width = format == CHART_PNG ? page->columns : (uint32_t)layout.width;
	written->height = format == CHART_PNG ? page->rows : (uint32_t)layout.height;
	written->place = place_of(map->raster, &layout.frame, dots);
done:
	chart_grid_finish(&layout.grid);
	return status;
}

enum status chart_map_page(const struct chart_map *map, const char *path, struct chart_page *page, struct chart_frame *frame,
			   struct chart_written *written)
{
	struct chart_joined joined;
	struct chart_map drawn = *map;
	*written = (struct chart_written){.width = 0};
	TRY(chart_ways_join(map->ways, map->way_count, &joined));
	drawn.ways = joined.ways;
	drawn.way_count = joined.count;
	const enum status status = write_page(&drawn, path, page, frame, written);
	chart_joined_finish(&joined);
	return status;
}

enum status chart_map_write(const struct chart_map *map, const char *path, struct chart_written *written)
{
	struct chart_page page = {.fonts = NULL};
	struct chart_frame frame;
	struct chart_written unasked;
	enum status status;
	TRY_OR(done, chart_map_page(map, path, &page, &frame, written != NULL ? written : &unasked));
	TRY_OR(done, chart_page_write(&page, path));
	chart_unknown_tell(&page.unknown, path);
done:
	chart_page_finish(&page);
	return status;
}
