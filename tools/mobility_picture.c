/* furrow mobility, as a map: classes in colour over the hillshade, with shares of the area, a scale bar and north. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "mobility.h"

#define SIDE 800 /* smaller maps are enlarged to about that */
#define PAD 8
#define LINES 6  /* of the legend */
#define BELOW (LINES * (RENDER_LETTER_HEIGHT + 4) + 3 * PAD)
#define ABOVE (RENDER_LETTER_HEIGHT + 2 * PAD)
#define WIDTH_LEAST 330 /* units */

static const struct render_colour ink = {28, 30, 34, 255}, paper = {255, 255, 255, 255}, none = {0, 0, 0, 0};

/* Colours are Okabe's and Ito's, so that every eye tells them apart. */
struct key {
	const char *name;
	struct render_colour colour;
	int which; /* colour's number, as mobility_colour_of gives it */
};
static const struct key classes[] = {
	{"go at every heading", {0, 158, 115, 255}, CLASS_GO},
	{"go at some headings only", {240, 228, 66, 255}, CLASS_SOME},
	{"no-go", {213, 94, 0, 255}, CLASS_NO_GO},
	{"unknown: too steep or too coarse to say", {150, 150, 158, 255}, CLASS_UNKNOWN},
	{NULL, {0, 0, 0, 0}, 0},
};
static const struct key ranges[] = {
	{"0.9 to 1", {0, 158, 115, 255}, 3},
	{"0.5 to 0.9", {86, 180, 233, 255}, 2},
	{"0.1 to 0.5", {240, 228, 66, 255}, 1},
	{"below 0.1", {213, 94, 0, 255}, 0},
	{"unknown", {150, 150, 158, 255}, MOBILITY_RANGES - 1},
	{NULL, {0, 0, 0, 0}, 0},
};

static const struct key *keys_of(const struct mobility_map *map)
{
	return map->layer == LAYER_PROBABILITY ? ranges : classes;
}

static struct render_colour shaded(struct render_colour colour, double shade)
{
	const double light = 0.55 + 0.6 * shade;
	return (struct render_colour){(uint8_t)fmin(255, colour.r * light), (uint8_t)fmin(255, colour.g * light), (uint8_t)fmin(255, colour.b * light), 255};
}

void mobility_picture_row(struct mobility_picture *picture, const struct mobility_map *map, int64_t y, const struct mobility_cell *cells)
{
	struct render_colour colours[MOBILITY_COLOURS] = {{0, 0, 0, 0}};
	for (const struct key *key = keys_of(map); key->name != NULL; key++)
		colours[key->which] = key->colour;
	const int low = picture->low + (int)(y - map->rect.y0) * picture->zoom;
	for (int64_t x = 0; x < map->rect.x1 - map->rect.x0; x++) {
		const struct mobility_cell *cell = &cells[x];
		if (cell->slope.up.reason == MOBILITY_NO_GROUND)
			continue;
		const int left = picture->left + (int)x * picture->zoom;
		render_canvas_box(&picture->canvas, left, low, left + picture->zoom, low + picture->zoom,
				  shaded(colours[mobility_colour_of(cell, map->layer)], isnan(cell->shade) ? 0.7 : cell->shade));
	}
}

static void text(const struct mobility_picture *picture, int x, int y, const char *line)
{
	render_canvas_text(&picture->canvas, x, y, picture->unit, line, ink, none);
}

static void draw_legend(const struct mobility_picture *picture, const struct mobility_map *map)
{
	const int unit = picture->unit, line = (RENDER_LETTER_HEIGHT + 4) * unit;
	int y = picture->low - 2 * PAD * unit - line;
	text(picture, picture->left, y + unit, map->layer == LAYER_PROBABILITY ? "probability of going straight up" : "share of the area");
	for (const struct key *key = keys_of(map); key->name != NULL; key++) {
		char label[64];
		y -= line;
		snprintf(label, sizeof label, "%s: %.1f %%", key->name, 100 * map->colours[key->which]);
		render_canvas_box(&picture->canvas, picture->left, y, picture->left + 2 * line, y + RENDER_LETTER_HEIGHT * unit, key->colour);
		text(picture, picture->left + 2 * line + PAD * unit, y + unit, label);
	}
}

static void draw_scale(const struct mobility_map *map, const struct mobility_picture *picture)
{
	const int unit = picture->unit, right = picture->left + picture->width, y = picture->low - 4 * PAD * unit;
	const double pixel = extent_spacing(&map->meta->extent, map->level) / picture->zoom; /* m */
	const double most = pixel * picture->width / 4, ten = pow(10, floor(log10(most))), times = most / ten;
	const double metres = ten * (times >= 5 ? 5 : times >= 2 ? 2 : 1);
	const int length = (int)lround(metres / pixel);
	char label[32];
	if (metres >= 1000)
		snprintf(label, sizeof label, "%g km", metres / 1000);
	else
		snprintf(label, sizeof label, "%g m", metres);
	render_canvas_box(&picture->canvas, right - length, y, right, y + 3 * unit, ink);
	text(picture, right - length / 2 - render_text_width(label, unit) / 2, y - (RENDER_LETTER_HEIGHT + 4) * unit, label);
	text(picture, right - render_text_width("north is up", unit), y - 2 * (RENDER_LETTER_HEIGHT + 4) * unit, "north is up");
}

enum status mobility_picture_create(const struct mobility_map *map, struct mobility_picture *picture)
{
	const int64_t across = map->rect.x1 - map->rect.x0, up = map->rect.y1 - map->rect.y0, longest = across > up ? across : up;
	*picture = (struct mobility_picture){.zoom = longest < SIDE ? (int)(SIDE / longest) : 1};
	picture->width = (int)across * picture->zoom;
	picture->height = (int)up * picture->zoom;
	picture->unit = (int)fmax(1, ((picture->width > picture->height ? picture->width : picture->height) + 250) / 520);
	const int unit = picture->unit;
	picture->inner = picture->width > WIDTH_LEAST * unit ? picture->width : WIDTH_LEAST * unit;
	picture->left = PAD * unit;
	picture->low = BELOW * unit;
	return render_canvas_create((uint32_t)(picture->inner + 2 * PAD * unit), (uint32_t)(picture->low + picture->height + ABOVE * unit), paper,
				    &picture->canvas);
}

enum status mobility_picture_write(struct mobility_picture *picture, const struct mobility_map *map)
{
	const char *slash = strrchr(map->store, '/');
	char title[256];
	snprintf(title, sizeof title, "%s: %s in %s", slash != NULL ? slash + 1 : map->store, map->vehicle, map->soil);
	const size_t letters = (size_t)(picture->inner / (RENDER_LETTER_WIDTH * picture->unit));
	if (letters < sizeof title)
		title[letters] = '\0';
	text(picture, picture->left, picture->low + picture->height + PAD * picture->unit, title);
	draw_legend(picture, map);
	draw_scale(map, picture);
	return render_canvas_write(&picture->canvas, map->path);
}

void mobility_picture_finish(struct mobility_picture *picture)
{
	render_canvas_finish(&picture->canvas);
}
