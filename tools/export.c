/* furrow export: posts of a store as a GeoTIFF or a PNG. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "command.h"
#include "dem/dem.h"
#include "store/store.h"

static const struct command_option options[] = {
	{"o", "OUT", "what to write: .tif (GeoTIFF) or .png"},
	{"layer", "LAYER", "surface (default), base, offset, heaped, pressed, shear (metres), quanta (Int32, 2^-20 m) or hillshade"},
	{"level", "L", "0: the source's spacing; -k: 2^k times finer; k: coarser (0; offset to quanta: the deformed level)"},
	{"window", "X0,Y0,X1,Y1", "metres east and north of the south-west post"},
	{"height-range", "MIN,MAX", "metres that a PNG's 0 and full scale mean (one metre a unit)"},
	{NULL, NULL, NULL},
};

/* Those in metres first; of what deformation left: from the offset to the quanta. */
enum layer {
	LAYER_SURFACE,
	LAYER_BASE,
	LAYER_OFFSET,
	LAYER_HEAPED,
	LAYER_PRESSED,
	LAYER_SHEAR,
	LAYER_QUANTA,
	LAYER_HILLSHADE
};
static const char *const layer_names[] = {"surface", "base",   "offset",    "heaped", "pressed",
					  "shear",   "quanta", "hillshade", NULL};

struct request {
	const char *path;
	int layer;
	int64_t level;
	bool png, has_window, has_range;
	double window[4], range[2];
};

/* NaN where a height might be taken for the usual value. */
static double nodata_beside(const struct store_meta *meta)
{
	const double usual = -32767, deepest = 2048, highest = 2048; /* that offsets reach */
	bool taken = meta->low - deepest <= usual && usual <= meta->high + highest;
	return taken ? (double)NAN : usual;
}

static bool is_ruts(const struct request *request)
{
	return request->layer >= LAYER_OFFSET && request->layer <= LAYER_QUANTA;
}

static enum status read_request(const struct arguments *arguments, struct request *request)
{
	request->path = arguments_text(arguments, "o");
	enum status status = arguments_expect(arguments, 1, 1);
	if (status == STATUS_OK && request->path == NULL)
		status = fail_with(STATUS_USAGE, "export: -o is missing; give a file ending in .tif or .png");
	if (status == STATUS_OK)
		status = arguments_choice(arguments, "layer", layer_names, &request->layer);
	if (status == STATUS_OK)
		status = arguments_integer(arguments, "level", TILE_LEVEL_MIN, TILE_LEVEL_MAX, &request->level);
	if (status == STATUS_OK)
		status = arguments_numbers(arguments, "window", 4, request->window, &request->has_window);
	if (status == STATUS_OK)
		status = arguments_numbers(arguments, "height-range", 2, request->range, &request->has_range);
	if (status != STATUS_OK)
		return status;
	request->png = dem_path_ends(request->path, ".png");
	if (request->png && is_ruts(request))
		return fail_with(STATUS_USAGE, "export: a PNG holds no negative metres; write %s as .tif",
				 layer_names[request->layer]);
	if (request->has_range && request->range[0] >= request->range[1])
		return fail_with(STATUS_USAGE, "export: --height-range %g,%g: is empty; give MIN,MAX", request->range[0],
				 request->range[1]);
	return STATUS_OK;
}

static enum status find_rect(const struct request *request, const struct world *world, struct post_rect *rect)
{
	int level = (int)request->level;
	*rect = (struct post_rect){0, 0, world_posts(world->width, level), world_posts(world->height, level)};
	if (level > world_coarsest(world))
		return fail_with(STATUS_INPUT, "export: level %d is coarser than the store's coarsest; give at most %d",
				 level, world_coarsest(world));
	if (request->has_window) {
		double w[4];
		for (int i = 0; i < 4; i++) {
			w[i] = request->window[i] / world_spacing(world, level);
			if (fabs(w[i]) > 1e15)
				return fail_with(STATUS_INPUT, "export: --window is outside the terrain; give metres inside it");
			/* A post asked for exactly is in, whatever the division rounded. */
			w[i] += (i < 2 ? -1 : 1) * (1e-9 + 4e-16 * fabs(w[i]));
		}
		struct post_rect asked = {
			.x0 = (int64_t)ceil(w[0]),
			.y0 = (int64_t)ceil(w[1]),
			.x1 = (int64_t)floor(w[2]) + 1,
			.y1 = (int64_t)floor(w[3]) + 1,
		};
		*rect = post_rect_intersect(*rect, asked);
	}
	if (post_rect_empty(*rect))
		return fail_with(STATUS_INPUT, "export: no post lies in --window; give X0,Y0,X1,Y1 in metres, inside "
					       "0,0,%g,%g",
				 (double)(world->width - 1) * world->spacing, (double)(world->height - 1) * world->spacing);
	int64_t most = 100000;
	if (rect->x1 - rect->x0 > most || rect->y1 - rect->y0 > 10 * most)
		return fail_with(STATUS_INPUT, "export: %lld x %lld posts are too many for one raster; give a --window or a "
					       "coarser --level",
				 (long long)(rect->x1 - rect->x0), (long long)(rect->y1 - rect->y0));
	return STATUS_OK;
}

/* Grey 1 .. 255 of a surface lit from the north-west, 45 degrees up; 0 where nodata. */
static void hillshade(const double *surface, int64_t width, int64_t rows, double spacing, double *out)
{
	int64_t stride = width + 2;
	for (int64_t y = 0; y < rows; y++)
		for (int64_t x = 0; x < width; x++) {
			const double *p = surface + (y + 1) * stride + x + 1;
			double here = p[0];
			double west = isnan(p[-1]) ? here : p[-1], east = isnan(p[1]) ? here : p[1];
			double south = isnan(p[-stride]) ? here : p[-stride], north = isnan(p[stride]) ? here : p[stride];
			double gx = (east - west) / (2 * spacing), gy = (north - south) / (2 * spacing);
			double light = (0.5 * gx - 0.5 * gy + sqrt(0.5)) / sqrt(1 + gx * gx + gy * gy);
			out[y * width + x] = isnan(here) ? 0 : 1 + 254 * fmax(light, 0);
		}
}

static enum status write_rows(const struct request *request, struct store_reader *reader,
			      const struct world *world, struct post_rect rect, struct dem_writer *writer)
{
	static const enum store_layer store_layers[] = {STORE_SURFACE, STORE_BASE,  STORE_OFFSET, STORE_HEAPED,
							STORE_PRESSED, STORE_SHEAR, STORE_QUANTA, STORE_SURFACE};
	enum { ROWS = 64 };
	int64_t width = rect.x1 - rect.x0, total = rect.y1 - rect.y0, border = request->layer == LAYER_HILLSHADE;
	size_t room = (size_t)(width + 2) * (ROWS + 2);
	double *values = mem_alloc(room, sizeof *values), *shaded = mem_alloc(room, sizeof *shaded);
	enum status status = values != NULL && shaded != NULL ? STATUS_OK : fail_memory("rows to export");
	struct progress progress;
	progress_start(&progress, request->path, "rows");
	double unit = 1, zero = 0;
	if (request->png && request->has_range) {
		unit = (request->range[1] - request->range[0]) / 65535;
		zero = request->range[0];
	}
	for (int64_t y = 0; y < total && status == STATUS_OK; y += ROWS) {
		int64_t rows = total - y < ROWS ? total - y : ROWS;
		struct post_rect part = {rect.x0 - border, rect.y0 + y - border, rect.x1 + border,
					 rect.y0 + y + rows + border};
		double *out = values;
		status = store_read_posts(reader, store_layers[request->layer], (int)request->level, part, values);
		if (status != STATUS_OK)
			break;
		if (request->layer == LAYER_HILLSHADE) {
			hillshade(values, width, rows, world_spacing(world, (int)request->level), shaded);
			out = shaded;
		} else if (request->png) {
			for (int64_t i = 0; i < width * rows; i++) {
				if (isnan(out[i])) {
					status = fail_with(STATUS_INPUT, "%s: a PNG cannot say nodata, and there are holes; write a "
									 ".tif, or import with --fill",
							   request->path);
					break;
				}
				out[i] = (out[i] - zero) / unit;
				if (out[i] < -0.5 || out[i] > 65535.5) {
					status = fail_with(STATUS_INPUT, "%s: a height does not fit a PNG of 16 bits; give "
									 "--height-range, or write a .tif",
							   request->path);
					break;
				}
			}
		}
		if (status == STATUS_OK)
			status = dem_writer_rows(writer, rows, out);
		if (status == STATUS_OK)
			status = progress_step(&progress, y + rows, total);
	}
	progress_end(&progress);
	mem_free(values);
	mem_free(shaded);
	return status;
}

static enum status write_raster(const struct request *request, struct store *store)
{
	const struct store_meta *meta = store_meta(store);
	const struct world *world = &meta->world;
	double spacing = world_spacing(world, (int)request->level);
	struct post_rect rect;
	enum status status = find_rect(request, world, &rect);
	if (status != STATUS_OK)
		return status;
	bool metres = request->layer < LAYER_QUANTA;
	struct dem_raster raster = {
		.path = request->path,
		.width = rect.x1 - rect.x0,
		.height = rect.y1 - rect.y0,
		.type = request->layer == LAYER_HILLSHADE ? DEM_UINT8
			: request->png			  ? DEM_UINT16
			: metres			  ? DEM_FLOAT32
							  : DEM_INT32,
		.srs = meta->srs,
		.west = meta->origin[0] + (double)rect.x0 * spacing,
		.south = meta->origin[1] + (double)rect.y0 * spacing,
		.spacing = spacing,
		.has_nodata = request->layer != LAYER_QUANTA,
		.nodata = metres ? nodata_beside(meta) : 0,
	};
	struct dem_writer *writer = NULL;
	struct store_reader *reader = NULL;
	status = store_reader_create(store, &reader);
	interrupt_catch();
	if (status == STATUS_OK)
		status = dem_writer_create(&raster, &writer);
	if (status == STATUS_OK)
		status = write_rows(request, reader, world, rect, writer);
	if (status == STATUS_OK)
		status = dem_writer_publish(writer);
	if (status == STATUS_OK)
		printf("%s: %s, %lld x %lld posts, %g m apart\n", request->path, layer_names[request->layer],
		       (long long)raster.width, (long long)raster.height, spacing);
	dem_writer_destroy(writer);
	store_reader_destroy(reader);
	return status;
}

static enum status run(const struct arguments *arguments)
{
	struct request request = {.layer = LAYER_SURFACE};
	struct store *store = NULL;
	enum status status = read_request(arguments, &request);
	if (status == STATUS_OK)
		status = store_open(arguments_at(arguments, 0), &(struct store_options){.mode = STORE_READ}, &store);
	int working;
	if (status == STATUS_OK && is_ruts(&request) && !arguments_flag(arguments, "level") && store_has_working_level(store, &working))
		request.level = working;
	if (status == STATUS_OK)
		status = write_raster(&request, store);
	store_close(store);
	return status;
}

const struct command command_export = {
	.name = "export",
	.usage = "export STORE -o OUT.tif|OUT.png [--layer surface|base|offset|heaped|pressed|shear|quanta|hillshade] "
		 "[--level L] [--window X0,Y0,X1,Y1]",
	.summary = "posts of a store as a GeoTIFF or a PNG",
	.details = "Rasters are north up, one pixel a post, and carry the store's reference system. Levels finer than\n"
		   "what is stored are interpolated.\n",
	.options = options,
	.run = run,
};
