/* furrow mobility, as a map: classes in colour over the hillshade, with shares of the area, a scale bar and north. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "mobility.h"

#define SIDE 800 /* smaller maps are enlarged to about that */
#define PAD 8
#define BELOW (CLASSES * (RENDER_LETTER_HEIGHT + 4) + 3 * PAD)
#define ABOVE (RENDER_LETTER_HEIGHT + 2 * PAD)
#define WIDTH_LEAST 330 /* units */

static const struct render_colour ink = {28, 30, 34, 255}, paper = {255, 255, 255, 255}, none = {0, 0, 0, 0};
/* Okabe's and Ito's, so that every eye tells them apart. */
static const struct render_colour colours[CLASSES] = {{213, 94, 0, 255}, {0, 158, 115, 255}, {240, 228, 66, 255}, {150, 150, 158, 255}};
static const char *const names[CLASSES] = {"no-go", "go", "go at some headings", "unknown"};

struct picture {
	int zoom, unit, width, height; /* of the map, pixels */
	int left, low;
	struct render_canvas canvas;
};

static struct render_colour shaded(struct render_colour colour, double shade)
{
	const double light = 0.55 + 0.6 * shade;
	return (struct render_colour){(uint8_t)fmin(255, colour.r * light), (uint8_t)fmin(255, colour.g * light), (uint8_t)fmin(255, colour.b * light), 255};
}

static enum status draw_rows(const struct mobility_map *map, const struct picture *picture)
{
	const int64_t width = map->rect.x1 - map->rect.x0;
	struct mobility_cell *cells = mem_alloc((size_t)width, sizeof *cells);
	enum status status = cells != NULL ? STATUS_OK : fail_memory("cells");
	for (int64_t y = map->rect.y0; y < map->rect.y1 && status == STATUS_OK; y++) {
		status = mobility_cells(map, y, y + 1, cells);
		for (int64_t x = 0; x < width && status == STATUS_OK; x++) {
			const struct mobility_cell *cell = &cells[x];
			if (cell->slope.up.reason == MOBILITY_NO_GROUND)
				continue;
			const int left = picture->left + (int)x * picture->zoom, low = picture->low + (int)(y - map->rect.y0) * picture->zoom;
			render_canvas_box(&picture->canvas, left, low, left + picture->zoom, low + picture->zoom,
					  shaded(colours[mobility_class_of(&cell->slope)], isnan(cell->shade) ? 0.7 : cell->shade));
		}
	}
	mem_free(cells);
	return status;
}

static void text(const struct picture *picture, int x, int y, const char *line)
{
	render_canvas_text(&picture->canvas, x, y, picture->unit, line, ink, none);
}

static void draw_legend(const struct picture *picture, const double shares[CLASSES])
{
	const int unit = picture->unit, line = (RENDER_LETTER_HEIGHT + 4) * unit;
	static const enum mobility_class order[CLASSES] = {CLASS_GO, CLASS_SOME, CLASS_NO_GO, CLASS_UNKNOWN};
	for (int i = 0; i < CLASSES; i++) {
		char label[64];
		const int y = picture->low - 2 * PAD * unit - (i + 1) * line;
		snprintf(label, sizeof label, "%s: %.1f %%", names[order[i]], 100 * shares[order[i]]);
		render_canvas_box(&picture->canvas, picture->left, y, picture->left + 2 * line, y + RENDER_LETTER_HEIGHT * unit, colours[order[i]]);
		text(picture, picture->left + 2 * line + PAD * unit, y + unit, label);
	}
}

static void draw_scale(const struct mobility_map *map, const struct picture *picture)
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

enum status mobility_picture(const struct mobility_map *map, const double shares[CLASSES])
{
	const int64_t across = map->rect.x1 - map->rect.x0, up = map->rect.y1 - map->rect.y0, longest = across > up ? across : up;
	struct picture picture = {.zoom = longest < SIDE ? (int)(SIDE / longest) : 1};
	picture.width = (int)across * picture.zoom;
	picture.height = (int)up * picture.zoom;
	picture.unit = (int)fmax(1, ((picture.width > picture.height ? picture.width : picture.height) + 250) / 520);
	const int unit = picture.unit, inner = picture.width > WIDTH_LEAST * unit ? picture.width : WIDTH_LEAST * unit;
	const char *slash = strrchr(map->store, '/');
	char title[256];
	picture.left = PAD * unit;
	picture.low = BELOW * unit;
	enum status status = render_canvas_create((uint32_t)(inner + 2 * PAD * unit), (uint32_t)(picture.low + picture.height + ABOVE * unit), paper,
						  &picture.canvas);
	if (status != STATUS_OK)
		return status;
	snprintf(title, sizeof title, "%s: %s in %s", slash != NULL ? slash + 1 : map->store, map->vehicle, map->soil);
	const size_t letters = (size_t)(inner / (RENDER_LETTER_WIDTH * unit));
	if (letters < sizeof title)
		title[letters] = '\0';
	text(&picture, picture.left, picture.low + picture.height + PAD * unit, title);
	status = draw_rows(map, &picture);
	draw_legend(&picture, shares);
	draw_scale(map, &picture);
	if (status == STATUS_OK)
		status = render_canvas_write(&picture.canvas, map->path);
	render_canvas_finish(&picture.canvas);
	return status;
}
