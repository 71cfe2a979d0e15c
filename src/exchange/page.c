/*
 * What lies beside the tiles: index.html with tiles.js and Leaflet, TileJSON for web maps, and layer.json for globes.
 *
 * tiles.js and layer.json list what is there, so that no client asks for a tile that is not.
 */
#include "exchange/internal.h"

#include <stdio.h>
#include <stdlib.h>

#include "exchange/embedded.h"

static const char *const leaflet_files[] = {"leaflet.js", "leaflet.css"};

static enum status read_leaflet(const struct exchange_tiles_params *params, const char *name, struct exchange_bytes *out)
{
	char path[EXCHANGE_PATH];
	bool found = false;
	snprintf(path, sizeof path, "%s/%s", params->leaflet, name);
	TRY(exchange_file_get(path, (size_t)16 << 20, out, &found));
	if (!found)
		return fail_with(STATUS_FAILED, "%s: Leaflet, which the page needs, is not there; install libjs-leaflet, or give its folder with "
				 "--leaflet", path);
	return STATUS_OK;
}

enum status exchange_page_check(const struct exchange_tiles_params *params)
{
	struct exchange_bytes bytes = {.data = NULL};
	enum status status = STATUS_OK;
	for (size_t i = 0; i < 2; i++)
		TRY_OR(done, read_leaflet(params, leaflet_files[i], &bytes));
done:
	exchange_bytes_finish(&bytes);
	return status;
}

static enum status put(const struct exchange_tiles_params *params, const char *name, const struct exchange_bytes *bytes)
{
	char path[EXCHANGE_PATH];
	bool written;
	if (snprintf(path, sizeof path, "%s/%s", params->directory, name) >= (int)sizeof path)
		return fail_with(STATUS_INPUT, "%.80s...: the path is too long; give a shorter one", params->directory);
	return exchange_file_put(path, bytes, &written);
}

/* --- text --- */

struct text {
	struct exchange_bytes bytes;
	enum status status;
};

static void FURROW_PRINTF(2, 3) add(struct text *text, const char *format, ...)
{
	char part[512];
	va_list arguments;
	va_start(arguments, format);
	int length = vsnprintf(part, sizeof part, format, arguments);
	va_end(arguments);
	assert(length >= 0 && (size_t)length < sizeof part);
	if (text->status == STATUS_OK)
		text->status = exchange_bytes_add(&text->bytes, part, (size_t)length);
}

/* Writes a text to a file, and frees it. Returns the text's own failure if it has one. */
static enum status put_text(const struct exchange_tiles_params *params, const char *name, struct text *text)
{
	enum status status = text->status != STATUS_OK ? text->status : put(params, name, &text->bytes);
	exchange_bytes_finish(&text->bytes);
	return status;
}

/* A JSON string, which is also one of JavaScript within a file. */
static void add_string(struct text *text, const char *string)
{
	add(text, "\"");
	for (const char *c = string; *c != '\0'; c++) {
		if (*c == '"' || *c == '\\')
			add(text, "\\%c", *c);
		else if ((unsigned char)*c < ' ')
			add(text, "\\u%04x", (unsigned)*c);
		else
			add(text, "%c", *c);
	}
	add(text, "\"");
}

/* --- lists of tiles --- */

struct listed {
	struct tile *tiles;
	size_t count, room;
};

static enum status list_tile(void *user, struct tile tile)
{
	struct listed *list = user;
	TRY(mem_grow(&list->tiles, &list->room, list->count + 1, sizeof *list->tiles, "a list of tiles"));
	list->tiles[list->count++] = tile;
	return STATUS_OK;
}

/* By zoom, then by rows. */
static int compare_tiles(const void *a, const void *b)
{
	const struct tile *one = a, *two = b;
	if (one->level != two->level)
		return one->level < two->level ? -1 : 1;
	if (one->y != two->y)
		return one->y < two->y ? -1 : 1;
	return (one->x > two->x) - (one->x < two->x);
}

static enum status list_sparse(const struct exchange_zooms *zooms, struct listed *list)
{
	for (size_t k = 0; k < zooms->count; k++) {
		const struct exchange_zoom *zoom = &zooms->zooms[k];
		for (size_t i = 0; i < zoom->tiles.room && zoom->sparse && zoom->globe; i++)
			if (zoom->tiles.keys[i] != UINT64_MAX)
				TRY(list_tile(list, tile_from_key(zoom->tiles.keys[i])));
	}
	return STATUS_OK;
}

static void sort_tiles(struct listed *list)
{
	if (list->count > 0)
		qsort(list->tiles, list->count, sizeof *list->tiles, compare_tiles);
}

/* The end of the run of tiles that begins at index `at`. */
static size_t run_end(const struct listed *list, size_t at)
{
	size_t end = at + 1;
	while (end < list->count && list->tiles[end].level == list->tiles[at].level && list->tiles[end].y == list->tiles[at].y &&
	       list->tiles[end].x == list->tiles[end - 1].x + 1)
		end++;
	return end;
}

/* {z: {y: [x0, x1, ...]}} of sorted tiles. */
static void add_rows(struct text *text, const struct listed *list)
{
	add(text, "{");
	for (size_t at = 0; at < list->count;) {
		struct tile tile = list->tiles[at];
		bool new_zoom = at == 0 || list->tiles[at - 1].level != tile.level, new_row = new_zoom || list->tiles[at - 1].y != tile.y;
		size_t end = run_end(list, at);
		if (new_zoom)
			add(text, "%s\n  %d: {", at > 0 ? "]}," : "", tile.level);
		else if (new_row)
			add(text, "], ");
		if (new_row)
			add(text, "%u: [", tile.y);
		add(text, "%s%u, %u", new_row ? "" : ", ", tile.x, list->tiles[end - 1].x + 1);
		at = end;
	}
	add(text, "%s}", list->count > 0 ? "]}" : "");
}

/* --- the page --- */

#define GRID 16 /* cells along a side of the grid of coordinates */

static void add_numbers(struct text *text, const char *name, const double *values, size_t count)
{
	add(text, "  %s: [", name);
	for (size_t i = 0; i < count; i++) {
		if (isfinite(values[i]))
			add(text, "%s%.3f", i > 0 ? ", " : "", values[i]);
		else
			add(text, "%sNaN", i > 0 ? ", " : ""); /* null would count as 0 */
	}
	add(text, "],\n");
}

/* Coordinates in the store's system on a grid of longitudes and latitudes over the bounds, rows from the south. */
static void add_places(struct text *text, const struct exchange_frame *frame)
{
	double x[(GRID + 1) * (GRID + 1)], y[(GRID + 1) * (GRID + 1)];
	const double *bounds = frame->bounds;
	char system[160];
	for (size_t k = 0; k < sizeof x / sizeof *x; k++) {
		x[k] = bounds[0] + (bounds[2] - bounds[0]) * (double)(k % (GRID + 1)) / GRID;
		y[k] = bounds[1] + (bounds[3] - bounds[1]) * (double)(k / (GRID + 1)) / GRID;
	}
	exchange_frame_from_degrees(frame, sizeof x / sizeof *x, x, y);
	for (size_t k = 0; k < sizeof x / sizeof *x; k++) {
		x[k] += frame->meta->origin[0];
		y[k] += frame->meta->origin[1];
	}
	chart_system_name(frame->meta->srs, system, sizeof system);
	add(text, "  system: ");
	add_string(text, system);
	add(text, ", // of the store: its coordinates at (grid + 1) x (grid + 1) places of the bounds, rows from the south\n  grid: %d,\n", GRID);
	add_numbers(text, "easting", x, sizeof x / sizeof *x);
	add_numbers(text, "northing", y, sizeof y / sizeof *y);
}

static void add_ramp(struct text *text)
{
	struct chart_colour palette[256];
	exchange_rut_palette(palette);
	add(text, "  ramp: [");
	for (int i = 1; i < 256; i += i == 127 || i == 128 ? 1 : 14)
		add(text, "%s\"rgba(%d, %d, %d, %.3g)\"", i > 1 ? ", " : "", palette[i].r, palette[i].g, palette[i].b, palette[i].a / 255.0);
	add(text, "],\n");
}

/* --- TileJSON --- */

/* The bounds, in degrees, of the tiles of zoom level `whole` and finer ones of a sorted list. All that there is has tiles at `whole`; finer levels,
 * as those of an inset, have some of it. Without such tiles, those of the finest level. */
static void tiles_bounds(const struct listed *list, int whole, double bounds[4])
{
	const int finest = list->tiles[list->count - 1].level, least = whole < finest ? whole : finest;
	double x[2] = {1, 0}, y[2] = {1, 0}; /* shares of the world's side */
	for (size_t i = 0; i < list->count; i++) {
		const struct tile tile = list->tiles[i];
		if (tile.level < least)
			continue;
		x[0] = fmin(x[0], ldexp(tile.x, -tile.level));
		x[1] = fmax(x[1], ldexp(tile.x + 1.0, -tile.level));
		y[0] = fmin(y[0], ldexp(tile.y, -tile.level));
		y[1] = fmax(y[1], ldexp(tile.y + 1.0, -tile.level));
	}
	for (int i = 0; i < 2; i++) {
		bounds[2 * i] = x[i] * 360 - 180;
		bounds[1 + 2 * i] = atan(sinh(M_PI * (1 - 2 * y[1 - i]))) * 180 / M_PI;
	}
}

/* A set of tiles as TileJSON 3.0.0 has it, with the factors of MapLibre's custom encoding. */
static enum status write_tilejson(const struct exchange_tiles_params *params, const struct exchange_frame *frame, const struct exchange_zooms *zooms,
				  const struct exchange_tiles_result *result, enum exchange_set set, const double bounds[4])
{
	static const char *const names[] = {[EXCHANGE_TERRAIN] = "terrain", [EXCHANGE_HILLSHADE] = "hillshade", [EXCHANGE_RUTS] = "ruts", [EXCHANGE_IMAGERY] = "imagery"};
	const struct exchange_coding coding = exchange_coding_of(params, frame->meta);
	struct text text = {.status = STATUS_OK};
	char file[32];
	snprintf(file, sizeof file, "%s.json", names[set]);
	add(&text, "{\n  \"tilejson\": \"3.0.0\",\n  \"name\": ");
	add_string(&text, params->title);
	add(&text, ",\n  \"version\": \"1.0.%s\",\n  \"scheme\": \"xyz\",\n  \"tiles\": [\"%s/{z}/{x}/{y}.%s?v=%s\"],\n", result->version, names[set],
	    set == EXCHANGE_IMAGERY ? "webp" : "png", result->version);
	add(&text, "  \"minzoom\": %d,\n  \"maxzoom\": %d,\n  \"tileSize\": %d,\n", zooms->map[0], set == EXCHANGE_IMAGERY ? zooms->imagery : zooms->map[1], frame->pixels);
	if (set == EXCHANGE_TERRAIN)
		add(&text, "  \"encoding\": \"%s\",\n", exchange_coding_name(params));
	if (set == EXCHANGE_TERRAIN && params->step > 0) /* MapLibre refuses them for an encoding that it knows */
		add(&text, "  \"redFactor\": %.17g, \"greenFactor\": %.17g, \"blueFactor\": %.17g, \"baseShift\": %.17g,\n", 65536 / coding.parts, 256 / coding.parts,
		    1 / coding.parts, -coding.zero);
	add(&text, "  \"bounds\": [%.12g, %.12g, %.12g, %.12g]\n}\n", bounds[0], bounds[1], bounds[2], bounds[3]);
	return put_text(params, file, &text);
}

/* Local metres have no place on the world's map, so they have no TileJSON. Nor have ruts or imagery that are not there: clients would ask for them. */
static enum status write_tilejsons(const struct exchange_tiles_params *params, const struct exchange_frame *frame, const struct exchange_zooms *zooms,
				   const struct exchange_tiles_result *result, const struct listed *ruts, const struct listed *imagery)
{
	char path[EXCHANGE_PATH];
	double bounds[4];
	bool removed;
	if (result->local)
		return STATUS_OK;
	TRY(write_tilejson(params, frame, zooms, result, EXCHANGE_TERRAIN, frame->bounds));
	TRY(write_tilejson(params, frame, zooms, result, EXCHANGE_HILLSHADE, frame->bounds));
	const struct listed *const sets[] = {ruts, imagery};
	static const enum exchange_set kinds[] = {EXCHANGE_RUTS, EXCHANGE_IMAGERY};
	static const char *const files[] = {"ruts.json", "imagery.json"};
	for (size_t i = 0; i < 2; i++) {
		snprintf(path, sizeof path, "%s/%s", params->directory, files[i]);
		if (sets[i]->count == 0) {
			TRY(exchange_file_remove(path, &removed));
			continue;
		}
		tiles_bounds(sets[i], kinds[i] == EXCHANGE_RUTS ? zooms->ruts : zooms->imagery, bounds);
		TRY(write_tilejson(params, frame, zooms, result, kinds[i], bounds));
	}
	return STATUS_OK;
}

static enum status write_page(const struct exchange_tiles_params *params, const struct exchange_frame *frame, const struct exchange_zooms *zooms,
			      const struct exchange_tiles_result *result)
{
	/* The array is only read. */
	const struct exchange_bytes page = {.data = (uint8_t *)(uintptr_t)exchange_page, .size = exchange_page_size};
	const double *bounds = result->local ? frame->metres : frame->bounds;
	const struct exchange_coding coding = exchange_coding_of(params, frame->meta);
	struct listed shades = {NULL, 0, 0}, ruts = {NULL, 0, 0}, imagery = {NULL, 0, 0};
	struct text text = {.status = STATUS_OK};
	enum status status;
	TRY_OR(done, exchange_folder_each(params->directory, EXCHANGE_HILLSHADE, list_tile, &shades));
	TRY_OR(done, exchange_folder_each(params->directory, EXCHANGE_RUTS, list_tile, &ruts));
	sort_tiles(&shades);
	TRY_OR(done, exchange_folder_each(params->directory, EXCHANGE_IMAGERY, list_tile, &imagery));
	sort_tiles(&ruts);
	sort_tiles(&imagery);
	add(&text, "// What the folder has. Written by furrow export --tiles.\nconst FURROW_TILES = {\n  title: ");
	add_string(&text, params->title);
	add(&text, ",\n  revision: %lld, version: \"%s\",\n  local: %s,\n", (long long)result->revision, result->version, result->local ? "true" : "false");
	add(&text, "  side: %.17g, // metres of the square of local tiles\n", frame->side);
	add(&text, "  bounds: [%.12g, %.12g, %.12g, %.12g], // west, south, east, north\n", bounds[0], bounds[1], bounds[2], bounds[3]);
	add(&text, "  range: [%.6g, %.6g], // metres\n", result->range[0], result->range[1]);
	add_ramp(&text);
	add(&text, "  encoding: \"%s\", zero: %.17g, step: %.17g, // of the tiles of heights, metres\n", exchange_coding_name(params), coding.zero, 1 / coding.parts);
	add(&text, "  pixels: %d, // along a tile\n", frame->pixels);
	if (!result->local)
		add_places(&text, frame);
	add(&text, "  coarsest: %d, finest: %d,\n", zooms->map[0], zooms->map[1]);
	add(&text, "  // Tiles that are there: {z: {y: [x0, x1, ...]}}.\n  hillshade: ");
	add_rows(&text, &shades);
	add(&text, ",\n  ruts: ");
	add_rows(&text, &ruts);
	add(&text, ",\n  imagery: ");
	add_rows(&text, &imagery);
	add(&text, ", finest_imagery: %d,\n};\n", zooms->imagery);
	TRY_OR(done, put_text(params, "tiles.js", &text));
	TRY_OR(done, put(params, "index.html", &page));
	TRY_OR(done, write_tilejsons(params, frame, zooms, result, &ruts, &imagery));
done:
	mem_free_all(shades.tiles, ruts.tiles, imagery.tiles);
	return status;
}

/* --- layer.json --- */

/* Sparse zoom levels list their tiles in runs along rows, dense ones their rectangle. */
static void add_available(struct text *text, const struct exchange_zooms *zooms, const struct listed *sparse)
{
	size_t at = 0;
	add(text, "  \"available\": [");
	for (size_t k = zooms->count; k-- > 0 && zooms->zooms[k].globe;) { /* from the coarsest: zoom 0 */
		const struct exchange_zoom *zoom = &zooms->zooms[k];
		add(text, "%s\n    [", zoom->z > 0 ? "," : "");
		if (!zoom->sparse)
			add(text, "{\"startX\": %lld, \"startY\": %lld, \"endX\": %lld, \"endY\": %lld}", (long long)zoom->x0, (long long)zoom->y0,
			    (long long)zoom->x1 - 1, (long long)zoom->y1 - 1);
		for (bool first = true; at < sparse->count && sparse->tiles[at].level == zoom->z; first = false) {
			struct tile tile = sparse->tiles[at];
			at = run_end(sparse, at);
			add(text, "%s{\"startX\": %u, \"startY\": %u, \"endX\": %u, \"endY\": %u}", first ? "" : ", ", tile.x, tile.y,
			    sparse->tiles[at - 1].x, tile.y);
		}
		add(text, "]");
	}
	add(text, "\n  ]\n");
}

static enum status write_layer(const struct exchange_tiles_params *params, const struct exchange_frame *frame, const struct exchange_zooms *zooms,
			       const struct exchange_tiles_result *result)
{
	struct listed sparse = {NULL, 0, 0};
	struct text text = {.status = list_sparse(zooms, &sparse)};
	sort_tiles(&sparse);
	add(&text, "{\n  \"name\": ");
	add_string(&text, params->title);
	add(&text, ",\n  \"description\": ");
	add_string(&text, result->local ? "local metres, laid out around longitude 0, latitude 0" : result->system);
	add(&text, ",\n  \"version\": \"1.0.%s\",\n  \"format\": \"quantized-mesh-1.0\",\n  \"scheme\": \"tms\",\n", result->version);
	add(&text, "  \"projection\": \"EPSG:4326\",\n  \"extensions\": [\"octvertexnormals\"],\n");
	add(&text, "  \"tiles\": [\"{z}/{x}/{y}.terrain?v={version}\"],\n  \"minzoom\": 0,\n  \"maxzoom\": %d,\n", zooms->mesh[1]);
	add(&text, "  \"bounds\": [%.12g, %.12g, %.12g, %.12g],\n", frame->bounds[0], frame->bounds[1], frame->bounds[2], frame->bounds[3]);
	add_available(&text, zooms, &sparse);
	add(&text, "}\n");
	enum status status = put_text(params, "mesh/layer.json", &text);
	mem_free(sparse.tiles);
	return status;
}

static enum status copy_leaflet(const struct exchange_tiles_params *params)
{
	struct exchange_bytes bytes = {.data = NULL};
	enum status status = STATUS_OK;
	for (size_t i = 0; i < 2; i++) {
		TRY_OR(done, read_leaflet(params, leaflet_files[i], &bytes));
		TRY_OR(done, put(params, leaflet_files[i], &bytes));
	}
done:
	exchange_bytes_finish(&bytes);
	return status;
}

enum status exchange_page_write(const struct exchange_tiles_params *params, const struct exchange_frame *frame,
				const struct exchange_zooms *zooms, const struct exchange_tiles_result *result)
{
	TRY(write_layer(params, frame, zooms, result));
	TRY(copy_leaflet(params));
	return write_page(params, frame, zooms, result);
}
