/* furrow export: posts of a store as a GeoTIFF or a PNG. */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "dem/dem.h"
#include "exchange/exchange.h"
#include "export.h"
#include "relief_told.h"
#include "ruts.h"
#include "scene/scene.h"
#include "world_file.h"

static const char *const layer_names[] = {"surface", "base",        "offset",    "deposited", "plastic_sinkage", "shear",
					  "shear_x", "shear_y",     "loose",     "density",   "fixed_point",     "hillshade", "disturbance", "bent", "torn", "imagery", NULL};

/* In the order of enum exchange_up, from its second. */
static const char *const export_axes[] = {"y", "z", NULL};
static const char *const export_encodings[] = {"mapbox", "terrarium", NULL};
static const char *const export_sizes[] = {"256", "512", NULL};

static const struct command_option options[] = {
	{"o", "OUT", .help = "what to write: GeoTIFF, PNG, or 16 bits, little-endian, without a header; .svg, .pdf: a map; .mbtiles: map tiles in one file",
	 .files = "tif png r16 raw svg pdf mbtiles", .needed = true},
	{"mesh", "OUT", .help = "the surface of the window as triangles: .obj, .glb (glTF 2.0) or .stl", .files = "obj glb stl",
	 .instead = true},
	{"up", "AXIS", .help = "with --mesh: the axis that is up; x is east. y: z is south; z: y is north", .choices = export_axes, .preset = "y; of .stl, z"},
	{"tiles", "DIR", .help = "a folder of map tiles, globe tiles and a page that shows them", .files = "/", .instead = true},
	{"layer", "LAYER", .help = "what is written: lengths in metres, shear as shares of the soil's strength, density as a share, disturbance, bent and torn plants as shares, imagery as a .png of colours, fixed_point as Int32 of 2^-20 m", .choices = layer_names,
	 .preset = "surface"},
	{"level", "L", .help = "0: the source's spacing; -k: 2^k times finer; k: coarser",
	 .preset = "0; offset to fixed_point: the deformed level; imagery: its finest"},
	{"window", "X0,Y0,X1,Y1", .help = "east and north of the south-west post", .unit = "m", .preset = "all, or what changed, see below"},
	{"window-srs", "SRS", .help = "what --window is in; store: the store's own; degrees: longitude and latitude on its body", .preset = "metres from the south-west post"},
	{"height-range", "MIN,MAX", .help = "heights that a heightmap's 0 and full scale mean; of a map, its ramp's ends",
	 .unit = "m", .preset = "one metre a unit"},
	{"sun", "AZIMUTH,ALTITUDE", .help = "of a hillshade, clockwise from north and above the horizon", .unit = "degrees",
	 .preset = "315,45"},
	{"exaggerate", "TIMES", .help = "a hillshade as if heights were so many times what they are", .preset = "1"},
	{"since", "REVISION", .help = "with --tiles: only tiles that changed after this revision of the store"},
	{"encoding", "KIND", .help = "of tiles: how heights are coded in colours: mapbox in steps of 0.1 m, terrarium of 4 mm", .choices = export_encodings, .preset = "mapbox"},
	{"height-step", "M", .help = "of tiles: heights in steps of so much: MapLibre's encoding custom, whose factors are in terrain.json", .unit = "m", .preset = "the encoding's"},
	{"tile-size", "PIXELS", .help = "of tiles: pixels along a map tile; 512 also serve as @2x of 256", .choices = export_sizes, .preset = "256"},
	{"fine-globe", .help = "with --tiles: globe tiles down to vertices no further apart than posts, up to four times as many"},
	{"gzip", .help = "with --tiles: globe tiles compressed, a tenth of the bytes; the server or the page has to know"},
	{"jobs", "N", .help = "of tiles: threads", .preset = "all cores"},
	{"leaflet", "DIR", .help = "with --tiles: where leaflet.js and leaflet.css are", .files = "/",
	 .preset = "/usr/share/javascript/leaflet, of libjs-leaflet"},
	{.name = NULL},
};

const char *export_layer_name(int layer)
{
	return layer_names[layer];
}

enum store_layer export_store_layer(int layer)
{
	static const enum store_layer layers[] = {STORE_SURFACE, STORE_BASE,  STORE_OFFSET, STORE_DEPOSITED,
						  STORE_PLASTIC_SINKAGE, STORE_SHEAR, STORE_SHEAR_EAST, STORE_SHEAR_NORTH, STORE_LOOSE, STORE_DENSITY, STORE_UNITS, STORE_SURFACE, STORE_SOIL, STORE_RISEN, STORE_GROWN, STORE_SURFACE};
	return layers[layer];
}

/* NaN where a height might be taken for the usual value. */
static double nodata_beside(const struct store_meta *meta)
{
	const double usual = -32767, deepest = 2048, highest = 2048; /* that offsets reach */
	bool taken = meta->low - deepest <= usual && usual <= meta->high + highest;
	return taken ? (double)NAN : usual;
}

enum status export_read_light(const struct arguments *arguments, struct export_request *request, bool lit)
{
	double sun[2] = {315, 45};
	bool given;
	TRY(arguments_numbers(arguments, "sun", 2, sun, &given));
	TRY(arguments_number(arguments, "exaggerate", 0.01, 1000, &request->exaggerate));
	if (fabs(sun[0]) > 360 || sun[1] < 10 || sun[1] > 90)
		return fail_with(STATUS_USAGE, "%s: --sun %g,%g: is not in the sky; give degrees from north, and 10 to 90 above "
					       "the horizon", request->command, sun[0], sun[1]);
	if (!lit && (given || arguments_flag(arguments, "exaggerate")))
		return fail_with(STATUS_USAGE, "%s: nothing of layer %s is lit; leave --sun and --exaggerate out", request->command,
				 layer_names[request->layer]);
	chart_sun_of(sun[0] * M_PI / 180, sun[1] * M_PI / 180, &request->sun);
	return STATUS_OK;
}

enum status export_read_layer(const struct arguments *arguments, int *layer)
{
	const char *text = arguments_text(arguments, "layer");
	const char *now = text != NULL ? scene_name_now(text) : "";
	for (int i = 0; layer_names[i] != NULL; i++)
		if (strcmp(layer_names[i], now) == 0) {
			*layer = i;
			return STATUS_OK;
		}
	return arguments_choice(arguments, "layer", layer);
}

/* Endings, and options that mean nothing to a mesh. */
static enum status check_mesh(const struct arguments *arguments, const char *path)
{
	static const char *const foreign[] = {"o", "layer", "height-range", "sun", "exaggerate"};
	for (size_t i = 0; i < sizeof foreign / sizeof *foreign; i++)
		if (arguments_text(arguments, foreign[i]) != NULL)
			return fail_with(STATUS_USAGE, "export: --mesh has the surface's triangles; leave %s%s out", foreign[i][1] == '\0' ? "-" : "--",
					 foreign[i]);
	bool known = dem_path_ends(path, ".obj") || dem_path_ends(path, ".glb") || dem_path_ends(path, ".stl");
	return known ? STATUS_OK : fail_with(STATUS_USAGE, "export: --mesh %s: has another ending; name a .obj, .glb or .stl", path);
}

/* Without --up it is what the format has. */
static enum status read_up(const struct arguments *arguments, struct export_request *request)
{
	int axis = 0;
	request->up = EXCHANGE_UP_FORMAT;
	if (arguments_text(arguments, "up") == NULL)
		return STATUS_OK;
	if (!request->mesh)
		return fail_with(STATUS_USAGE, "export: --up is for --mesh; give --mesh OUT, or leave --up out");
	TRY(arguments_choice(arguments, "up", &axis));
	request->up = EXCHANGE_UP_Y + axis;
	return STATUS_OK;
}

static enum status read_request(const struct arguments *arguments, struct export_request *request)
{
	const char *mesh = arguments_text(arguments, "mesh");
	request->path = mesh != NULL ? mesh : arguments_text(arguments, "o");
	request->mesh = mesh != NULL;
	TRY(mesh != NULL ? check_mesh(arguments, mesh) : STATUS_OK);
	TRY(read_up(arguments, request));
	if (request->path == NULL)
		return fail_with(STATUS_USAGE, "export: -o is missing; give a file ending in .tif, .png or .r16");
	TRY(export_read_layer(arguments, &request->layer));
	TRY(arguments_integer(arguments, "level", TILE_LEVEL_MIN, TILE_LEVEL_MAX, &request->level));
	TRY(export_read_window(arguments, request));
	TRY(arguments_numbers(arguments, "height-range", 2, request->range, &request->has_range));
	enum chart_format format;
	const bool drawn = !request->mesh && chart_path_format(request->path, &format);
	if (request->layer == LAYER_IMAGERY && (request->mesh || !drawn || format != CHART_PNG))
		return fail_with(STATUS_USAGE, "export: %s: imagery is colours; write it as .png, which gdal_translate makes a .tif of", request->path);
	request->png = drawn && format == CHART_PNG;
	request->map = drawn && (!request->png || export_is_ruts(request)); /* a PNG holds no negative metres */
	if (drawn && !request->png && !export_is_ruts(request))
		return fail_with(STATUS_USAGE, "export: %s: heights are a raster; write them as .tif or .png, or as a map by furrow map",
				 request->path);
	request->raw = dem_path_ends(request->path, ".r16") || dem_path_ends(request->path, ".raw");
	if (!request->mesh && !drawn && !request->raw && !dem_path_ends(request->path, ".tif") && !dem_path_ends(request->path, ".tiff"))
		return fail_with(STATUS_USAGE, "%s: no raster that can be written has this ending; name a .tif, a .png, or a raw .r16", request->path);
	if (request->has_range && request->range[0] >= request->range[1])
		return fail_with(STATUS_USAGE, "export: --height-range %g,%g: is empty; give MIN,MAX", request->range[0],
				 request->range[1]);
	if (request->raw && request->layer != LAYER_SURFACE && request->layer != LAYER_BASE)
		return fail_with(STATUS_USAGE, "export: a raw heightmap holds surface or base, not %s; write a .tif", layer_names[request->layer]);
	TRY(export_read_light(arguments, request, request->layer == LAYER_HILLSHADE || request->map));
	return request->map ? export_check_picture(request) : STATUS_OK;
}

enum status export_find_rect(const struct export_request *request, const struct extent *extent, struct post_rect *rect)
{
	int level = (int)request->level;
	*rect = (struct post_rect){0, 0, extent_posts(extent->width, level), extent_posts(extent->height, level)};
	if (level > extent_coarsest(extent))
		return fail_with(STATUS_INPUT, "%s: level %d is coarser than the store's coarsest; give at most %d",
				 request->command, level, extent_coarsest(extent));
	if (request->has_window) {
		double w[4];
		for (int i = 0; i < 4; i++) {
			w[i] = request->window[i] / extent_spacing(extent, level);
			if (fabs(w[i]) > 1e15)
				return fail_with(STATUS_INPUT, "%s: --window is outside the terrain; give metres inside it", request->command);
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
	if (request->has_window && (request->window[0] > request->window[2] || request->window[1] > request->window[3]))
		return fail_with(STATUS_INPUT, "%s: --window: its corners are swapped; give X0,Y0,X1,Y1, the south-west corner first", request->command);
	if (post_rect_empty(*rect))
		return fail_with(STATUS_INPUT, "%s: no post lies in --window; give X0,Y0,X1,Y1 in metres, inside "
					       "%s", request->command,
				 number_window(0, 0, (double)(extent->width - 1) * extent->spacing, (double)(extent->height - 1) * extent->spacing).text);
	return STATUS_OK;
}

static enum status check_size(struct post_rect rect)
{
	int64_t most = 100000;
	if (rect.x1 - rect.x0 > most || rect.y1 - rect.y0 > 10 * most)
		return fail_with(STATUS_INPUT, "export: %lld x %lld posts are too many for one raster; give a --window or a "
					       "coarser --level",
				 (long long)(rect.x1 - rect.x0), (long long)(rect.y1 - rect.y0));
	return STATUS_OK;
}

/* Grey 1 .. 255 of slopes, into where those to the east are; NaN where nodata. */
static void shade(const struct export_request *request, double *east, const double *north, int64_t count)
{
	for (int64_t i = 0; i < count; i++) {
		double light = chart_shade(&request->sun, request->exaggerate * east[i], request->exaggerate * north[i]);
		east[i] = isnan(light) ? (double)NAN : 1 + 254 * light;
	}
}

/* Metres as 0 to 65535. Counts holes, which become 0 when they are written, and other posts that do. */
static enum status to_16_bits(const struct export_request *request, double *values, int64_t count, int64_t *holes, int64_t *zeros)
{
	double unit = request->has_range ? (request->range[1] - request->range[0]) / 65535 : 1, zero = request->has_range ? request->range[0] : 0;
	for (int64_t i = 0; i < count; i++) {
		bool hole = isnan(values[i]);
		const double height = values[i];
		*holes += hole;
		values[i] = (height - zero) / unit;
		*zeros += values[i] < 0.5;
		const bool beyond = values[i] < -0.5 || values[i] > 65535.5;
		if (beyond && request->has_range)
			return fail_with(STATUS_INPUT, "%s: a height of %.6g m does not fit the 16 bits of --height-range %g,%g; give a wider one, or write a .tif", request->path, height,
					 request->range[0], request->range[1]);
		if (beyond)
			return fail_with(STATUS_INPUT, "%s: a height does not fit 16 bits; give --height-range, or write a .tif", request->path);
	}
	return STATUS_OK;
}

/* Makes shares of posts that were read: of disturbance the stored number, of a mark that fades when it is gone. */
static enum status read_marks(const struct export_request *request, struct store_reader *reader, struct post_rect part, double *values)
{
	const enum plane plane = request->layer == LAYER_BENT ? PLANE_RISEN : request->layer == LAYER_TORN ? PLANE_GROWN : PLANE_HEALED;
	const size_t count = (size_t)(part.x1 - part.x0) * (size_t)(part.y1 - part.y0);
	const int32_t whole = plane_mark_whole(&request->marks, plane);
	double *healed = NULL;
	if (request->layer == LAYER_DISTURBANCE) {
		TRY(mem_make(&healed, count, sizeof *healed, "rows to export"));
		const enum status status = store_read_posts(reader, STORE_HEALED, (int)request->level, part, healed);
		if (status != STATUS_OK) {
			mem_free(healed);
			return status;
		}
	}
	for (size_t i = 0; i < count; i++) {
		const double until = healed != NULL ? healed[i] : values[i];
		const int32_t left = isnan(until) ? 0 : plane_mark_left((int32_t)ldexp(until, PLANE_TIME_BITS), request->marks.now, whole);
		values[i] = (healed != NULL && values[i] > left ? values[i] : isnan(values[i]) ? (double)NAN : left) / PLANE_MARK_MOST;
	}
	mem_free(healed);
	return STATUS_OK;
}

/* Reads posts of the layer. What lies loose is the loose layer, and what was deposited since a body touched the post. */
static enum status read_posts(const struct export_request *request, struct store_reader *reader, struct post_rect part, double *values)
{
	const enum store_layer layer = export_store_layer(request->layer);
	const size_t count = (size_t)(part.x1 - part.x0) * (size_t)(part.y1 - part.y0);
	enum status status;
	double *others = NULL;
	TRY(store_read_posts(reader, layer, (int)request->level, part, values));
	if (request->layer >= LAYER_DISTURBANCE)
		return read_marks(request, reader, part, values);
	if (request->layer != LAYER_LOOSE)
		return STATUS_OK;
	others = mem_alloc(2 * count, sizeof *others);
	TRY_MEM(others, "rows to export");
	TRY_OR(done, store_read_posts(reader, STORE_DEPOSITED, (int)request->level, part, others));
	TRY_OR(done, store_read_posts(reader, STORE_SETTLED, (int)request->level, part, others + count));
	for (size_t i = 0; i < count; i++)
		values[i] = values[i] > 0 || others[i] > others[count + i] ? fmax(values[i] + others[i] - others[count + i], 0) : values[i];
done:
	mem_free(others);
	return status;
}

static enum status write_rows(const struct export_request *request, struct store_reader *reader,
			      const struct extent *extent, struct post_rect rect, struct dem_writer *writer)
{
	enum { ROWS = 64 };
	int64_t width = rect.x1 - rect.x0, total = rect.y1 - rect.y0, border = request->layer == LAYER_HILLSHADE;
	size_t room = (size_t)(width + 2) * (ROWS + 2);
	double *values = mem_alloc(room, sizeof *values), *slopes = border ? mem_alloc(2 * room, sizeof *slopes) : NULL;
	struct progress progress;
	progress_start(&progress, request->path, "rows");
	int64_t holes = 0, zeros = 0;
	enum status status;
	TRY_OR(done, values != NULL && (!border || slopes != NULL) ? STATUS_OK : fail_memory("rows to export"));
	for (int64_t y = 0; y < total; y += ROWS) {
		int64_t rows = total - y < ROWS ? total - y : ROWS;
		struct post_rect part = {rect.x0 - border, rect.y0 + y - border, rect.x1 + border,
					 rect.y0 + y + rows + border};
		double *out = values;
		TRY_OR(done, read_posts(request, reader, part, values));
		if (request->layer == LAYER_HILLSHADE) {
			chart_slopes(values, width, rows, extent_spacing(extent, (int)request->level), slopes, slopes + room);
			shade(request, slopes, slopes + room, width * rows);
			out = slopes;
		} else if (request->png || request->raw) {
			TRY_OR(done, to_16_bits(request, out, width * rows, &holes, &zeros));
		}
		TRY_OR(done, dem_writer_rows(writer, rows, out));
		TRY_OR(done, progress_step(&progress, y + rows, total));
	}
done:
	progress_end(&progress);
	mem_free_all(values, slopes);
	TRY(status);
	if (holes > 0 && request->png && zeros == 0)
		note("%s: %lld posts have no data; they are 0, which the PNG declares transparent: programs that read that leave them out", request->path, (long long)holes);
	else if (holes > 0)
		note("%s: %lld posts have no data; they are 0, which is the height %g m, too", request->path, (long long)holes,
		     request->has_range ? request->range[0] : 0.0);
	return STATUS_OK;
}

/* Unreal's Landscape has components of sections of 7 to 255 quads; these squares fill whole numbers of components. */
static const int64_t unreal_sides[] = {127, 253, 505, 1009, 2017, 4033, 8129};

/* A raw heightmap that no engine takes as it is: Unreal takes these sides, Unity and Gazebo squares of 2^n + 1. */
static void note_side(const struct export_request *request, struct post_rect rect, double spacing)
{
	const int64_t width = rect.x1 - rect.x0, height = rect.y1 - rect.y0, least = width < height ? width : height;
	int64_t side = 0;
	bool fits = width == height && ((width - 1) & (width - 2)) == 0;
	for (size_t i = 0; i < sizeof unreal_sides / sizeof *unreal_sides; i++) {
		fits = fits || (width == unreal_sides[i] && height == width);
		side = unreal_sides[i] <= least ? unreal_sides[i] : side;
	}
	if (fits || side == 0)
		return;
	const double west = (double)rect.x0 * spacing, south = (double)rect.y0 * spacing, length = (double)(side - 1) * spacing;
	note("%s: %lld x %lld posts are no size of Unreal's Landscape; the nearest that lies within is %lld x %lld: --window %s",
	     request->path, (long long)width, (long long)height, (long long)side, (long long)side,
	     number_window(west, south, west + length, south + length).text);
}

/* So that the error bound of the import holds in the raster too. */
static enum dem_raster_type float_type(const struct store_meta *meta)
{
	return height_code_float_holds(meta->step, fmax(fabs(meta->low), fabs(meta->high))) ? DEM_FLOAT32 : DEM_FLOAT64;
}

/* The surface of the source's level has only few posts of finer ruts. */
static enum status tell_finer_ruts(const struct export_request *request, struct store *store, int working)
{
	double ruts[4];
	bool any;
	if ((request->layer != LAYER_SURFACE && request->layer != LAYER_HILLSHADE) || working >= request->level)
		return STATUS_OK;
	TRY(ruts_window(store, ruts, &any));
	if (any)
		note("%s: at level %d it has one of %lld posts of the ruts, which are %g m apart: for all of them give --level %d --window %s",
		     request->path, (int)request->level, 1LL << 2 * (request->level - working), extent_spacing(&store_meta(store)->extent, working), working,
		     number_window(ruts[0], ruts[1], ruts[2], ruts[3]).text);
	return STATUS_OK;
}

static enum status write_raster(const struct export_request *request, struct store *store)
{
	const struct store_meta *meta = store_meta(store);
	const struct extent *extent = &meta->extent;
	double spacing = extent_spacing(extent, (int)request->level);
	struct post_rect rect;
	TRY(export_find_rect(request, extent, &rect));
	TRY(check_size(rect));
	bool metres = request->layer != LAYER_QUANTA && request->layer != LAYER_HILLSHADE;
	struct dem_raster raster = {
		.path = request->path,
		.width = rect.x1 - rect.x0,
		.height = rect.y1 - rect.y0,
		.type = request->layer == LAYER_HILLSHADE ? DEM_UINT8
			: request->png || request->raw	  ? DEM_UINT16
			: metres			  ? float_type(meta)
							  : DEM_INT32,
		.srs = meta->srs,
		.vertical = request->layer <= LAYER_BASE ? meta->vertical : "",
		.unit = request->layer < LAYER_SHEAR || request->layer == LAYER_LOOSE ? "m" : NULL,
		.band = layer_names[request->layer],
		.west = meta->origin[0] + (double)rect.x0 * spacing,
		.south = meta->origin[1] + (double)rect.y0 * spacing,
		.spacing = spacing,
		.has_nodata = request->layer != LAYER_QUANTA,
		.nodata = metres && !request->png && !request->raw ? nodata_beside(meta) : 0,
	};
	const bool replaces = access(request->path, F_OK) == 0;
	struct dem_writer *writer = NULL;
	struct store_reader *reader = NULL;
	interrupt_catch();
	enum status status;
	TRY_OR(done, store_reader_create(store, &reader));
	TRY_OR(done, dem_writer_create(&raster, &writer));
	TRY_OR(done, write_rows(request, reader, extent, rect, writer));
	TRY_OR(done, dem_writer_publish(writer));
	if (request->png && meta->srs[0] != '\0') /* a PNG has no place of its own */
		TRY_OR(done, world_file_write(request->path, meta, &(struct chart_place){.east = spacing, .south = spacing,
			.west_edge = ((double)rect.x0 - 0.5) * spacing, .north_edge = ((double)rect.y1 - 0.5) * spacing}));
	printf("%s: %s, %lld x %lld posts, %g m apart%s\n", request->path, layer_names[request->layer],
	       (long long)raster.width, (long long)raster.height, spacing, replaces ? "; the file that was there is replaced" : "");
	if (request->raw)
		note_side(request, rect, spacing);
done:
	dem_writer_destroy(writer);
	store_reader_destroy(reader);
	return status;
}

static enum status run(const struct arguments *arguments)
{
	static const char *const tiles_only[] = {"encoding", "height-step", "tile-size", "fine-globe", "gzip", "since", "jobs", "leaflet"};
	struct export_request request = {.command = "export", .layer = LAYER_SURFACE, .exaggerate = 1};
	struct store *store = NULL;
	const char *out = arguments_text(arguments, "o");
	if (arguments_text(arguments, "tiles") != NULL)
		return export_tiles(arguments);
	if (out != NULL && dem_path_ends(out, ".mbtiles"))
		return export_mbtiles(arguments);
	if (out != NULL && dem_path_ends(out, ".pmtiles"))
		return fail_with(STATUS_USAGE, "export: %s: PMTiles are not written; write a .mbtiles, and convert it with pmtiles convert", out);
	for (size_t i = 0; i < sizeof tiles_only / sizeof *tiles_only; i++)
		if (arguments_flag(arguments, tiles_only[i]))
			return fail_with(STATUS_USAGE, "export: --%s is for --tiles; give --tiles DIR, or leave --%s out", tiles_only[i], tiles_only[i]);
	TRY(read_request(arguments, &request));
	request.store = arguments_at(arguments, 0);
	TRY(store_open(request.store, &(struct store_options){.mode = STORE_READ}, &store));
	int working;
	struct store_marks marks;
	enum status status;
	TRY_OR(done, store_marks(store, &marks));
	request.marks = store_marks_at(&marks, marks.time);
	TRY_OR(done, export_place_window(&request, store_meta(store)));
	if (!export_is_ruts(&request))
		relief_tell_missing(request.store, store);
	if (request.layer == LAYER_IMAGERY) {
		TRY_OR(done, export_imagery(&request, arguments_flag(arguments, "level"), store));
		goto done;
	}
	if (export_is_ruts(&request) && !arguments_flag(arguments, "level") && store_has_working_level(store, &working))
		request.level = working;
	TRY_OR(done, export_take_changed(&request, store));
	TRY_OR(done, request.mesh ? export_mesh(&request, store) : request.map ? export_picture(&request, store) : write_raster(&request, store));
	if (!arguments_flag(arguments, "level") && store_has_working_level(store, &working))
		TRY_OR(done, tell_finer_ruts(&request, store, working));
done:
	store_close(store);
	return status;
}

const struct command command_export = {
	.name = "export",
	.summary = "posts of a store as a raster, a mesh, or tiles for maps and globes",
	.arguments = COMMAND_ARGUMENTS(COMMAND_STORE),
	.options = options,
	.details = "Rasters are north up, one pixel a post, and carry the store's reference system: that of a .png is in a world file (.pgw) "
		   "and a .png.aux.xml beside it. Levels finer than what is "
		   "stored are interpolated. Nodata of a hillshade and of a heightmap (.png, .r16, .raw) is 0. GeoTIFFs are compressed, "
		   "without loss. They name unit and layer of the band, and in VERTICAL_REFERENCE what heights are above.\n\n"
		   "Layers offset to fixed_point are 0 where nothing changed, and nodata where there is no ground (fixed_point: 0). "
		   "Where the whole terrain would make a raster of more than half a gigabyte, only the tiles that changed are "
		   "written, and the window is told. Maps have only these tiles, too. --window writes any other part.\n\n"
		   "A .png, .svg or .pdf of offset, deposited, plastic_sinkage or of shear is a map: false colours over the "
		   "hillshade, with a grid, a legend, a scale bar and north (furrow map says more of them). Its pixels are posts, "
		   "small maps enlarged by a whole factor. More than 4096 on a side are drawn at a coarser level, each pixel with "
		   "the largest value of the posts within it, so that narrow ruts are seen.\n\n"
		   "--mesh writes the window's surface in metres from an origin that is told; holes are left out. glTF and OBJ are y up, STL is z up; --up changes OBJ and "
		   "STL. glTF has a picture as of furrow map.\n\n"
		   "--tiles writes terrain-RGB, hillshade and ruts under Z/X/Y, Cesium's quantized-mesh with layer.json, and a "
		   "page that shows them behind any static server: python3 -m http.server -d DIR. Run again after a kill it goes "
		   "on; with --since it writes what changed. --window cuts a part out; of --window-srs degrees tiles end just at those meridians. "
		   "An .mbtiles has those of surface, hillshade or offset in one file. src/exchange/EXCHANGE.md says how to use the tiles.\n",
	.examples = "furrow export world.furrow -o surface.tif\n"
		    "furrow export ruts.furrow -o ruts.png --layer offset\n"
		    "furrow export ruts.furrow --tiles map\n"
		    "furrow export ruts.furrow --tiles map --height-step 0.001 --tile-size 512\n",
	.see = "furrow-import(1)",
	.run = run,
};
