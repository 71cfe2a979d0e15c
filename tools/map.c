/* furrow map: a layer of a store as a map on a page: PNG, SVG or PDF. */
#include <math.h>

#include "export.h"
#include "relief_told.h"
#include "store/store.h"

#define DPI 150.0
#define DPI_LEAST 36.0
#define DPI_MOST 1200.0
#define PIXELS_LEAST 100.0

/* Those of export's layers of which there are maps, in its order. */
static const char *const layers[] = {"surface", "base",    "offset",  "deposited", "plastic_sinkage",
				     "shear",   "shear_x", "shear_y", "disturbance", "bent", "torn", "imagery", NULL};
/* In the order of enum chart_grid. */
static const char *const grids[] = {"metres", "local", "degrees", "none", NULL};

static const struct command_option options[] = {
	{"o", "OUT", .help = "what to write", .files = "png svg pdf", .needed = true},
	{"layer", "LAYER", .help = "what is shown: heights of the surface or of the base, or what deformation left: lengths, shares of the soil's strength, and shares of disturbance, of bent and of torn plants; or the imagery's colours",
	 .choices = layers, .preset = "surface"},
	{"window", "X0,Y0,X1,Y1", .help = "east and north of the south-west post", .unit = "m", .preset = "all, or what changed, see below"},
	{"window-srs", "SRS", .help = "what --window is in; store: the store's own; degrees: longitude and latitude on its body", .preset = "metres from the south-west post"},
	{"height-range", "MIN,MAX", .help = "values at the ends of the colours", .unit = "m", .preset = "those of the map"},
	{"grid", "GRID", .help = "lines of round coordinates: metres of the store's system, local metres from the south-west post as scenes have them, or degrees of longitude and latitude",
	 .choices = grids, .preset = "metres"},
	{"size", "MM", .help = "length of the frame's longer side", .unit = "mm", .preset = "160"},
	{"dpi", "DPI", .help = "pixels an inch, of a PNG, and of the ground in SVG and PDF", .preset = "150"},
	{"world-file", .help = "of a PNG: OUT.pgw, and OUT.png.aux.xml with the reference system, so that GDAL and QGIS know where the map lies"},
	{"title", "TEXT", .help = "what stands above the map", .preset = "the store's name"},
	{"sun", "AZIMUTH,ALTITUDE", .help = "of the shades, clockwise from north and above the horizon", .unit = "degrees",
	 .preset = "315,45"},
	{"exaggerate", "TIMES", .help = "shades as if heights were so many times what they are", .preset = "1"},
	{.name = NULL},
};

static enum status read_page(const struct arguments *arguments, struct export_request *request)
{
	double dpi = DPI;
	int grid = CHART_GRID_METRES;
	request->size = CHART_SIZE;
	TRY(arguments_number(arguments, "size", CHART_SIZE_LEAST, CHART_SIZE_MOST, &request->size));
	TRY(arguments_number(arguments, "dpi", DPI_LEAST, DPI_MOST, &dpi));
	TRY(arguments_choice(arguments, "grid", &grid));
	const double pixels = request->size / 25.4 * dpi;
	if (pixels > CHART_PIXELS_MOST || pixels < PIXELS_LEAST)
		return fail_with(STATUS_USAGE,
				 "map: --size %g at --dpi %g: is %.0f pixels; give a size and a resolution that make %.0f to %d",
				 request->size, dpi, pixels, PIXELS_LEAST, CHART_PIXELS_MOST);
	request->pixels = (uint32_t)lround(pixels);
	request->grid = (enum chart_grid)grid;
	request->title = arguments_text(arguments, "title");
	return STATUS_OK;
}

static enum status read_request(const struct arguments *arguments, struct export_request *request)
{
	enum chart_format format = CHART_PNG;
	request->store = arguments_at(arguments, 0);
	request->path = arguments_text(arguments, "o");
	if (request->path == NULL || !chart_path_format(request->path, &format))
		return fail_with(STATUS_USAGE, "map: -o is missing or ends in none of .png, .svg and .pdf; give such a file");
	request->png = format == CHART_PNG;
	request->world_file = arguments_flag(arguments, "world-file");
	if (request->world_file && !request->png)
		return fail_with(STATUS_USAGE, "map: --world-file: %s is no PNG; leave it out, or write a .png", request->path);
	TRY(export_read_layer(arguments, &request->layer));
	TRY(export_read_window(arguments, request));
	TRY(arguments_numbers(arguments, "height-range", 2, request->range, &request->has_range));
	if (request->has_range && request->range[0] >= request->range[1])
		return fail_with(STATUS_USAGE, "map: --height-range %g,%g: is empty; give MIN,MAX", request->range[0], request->range[1]);
	TRY(export_read_light(arguments, request, true));
	TRY(export_check_picture(request));
	return read_page(arguments, request);
}

static enum status run(const struct arguments *arguments)
{
	struct export_request request = {.command = "map", .map = true, .layer = LAYER_SURFACE, .exaggerate = 1};
	struct store *store = NULL;
	struct store_marks marks;
	enum status status;
	TRY_OR(done, read_request(arguments, &request));
	if (chart_missing() != NULL)
		TRY_OR(done, fail_with(STATUS_FAILED, "map: %s", chart_missing()));
	TRY_OR(done, store_open(request.store, &(struct store_options){.mode = STORE_READ}, &store));
	TRY_OR(done, store_marks(store, &marks));
	request.marks = store_marks_at(&marks, marks.time);
	TRY_OR(done, export_place_window(&request, store_meta(store)));
	if (request.layer <= LAYER_BASE)
		relief_tell_missing(request.store, store);
	request.level = store_finest(store);
	int finest = 0;
	if (request.layer == LAYER_IMAGERY && store_has_imagery(store, &finest, NULL))
		request.level = finest;
	TRY_OR(done, export_take_changed(&request, store));
	TRY_OR(done, export_picture(&request, store));
done:
	store_close(store);
	return status;
}

const struct command command_map = {
	.name = "map",
	.summary = "a layer of a store as a map: PNG, SVG or PDF",
	.arguments = COMMAND_ARGUMENTS(COMMAND_STORE),
	.options = options,
	.details =
		"The map has the shaded ground with the layer in colours, a grid with its coordinates, a legend, a scale bar "
		"and grid north. Its posts are those of the finest level that has no more of them than the frame has pixels. "
		"Each pixel of offset and of soil has the largest value of the posts within it, so that narrow ruts are seen. Of offset "
		"it has the deepest rut, even beside a higher heap. "
		"Places without data are hatched. Of offset and of soil without --window only the tiles that changed are drawn, and the "
		"window is told.\n\n"
		"Words have the same size on every map. In SVG and PDF words and lines are vectors, the ground is pixels. Degrees "
		"are those of the store's body: WGS 84 on the Earth. With --world-file each pixel of the ground has its place in the "
		"store's system, and so have margins and legend. For the heights themselves use furrow export. furrow drive draws a map with the ways of a drive.\n",
	.examples = "furrow map world.furrow -o heights.pdf\n"
		    "furrow map ruts.furrow -o ruts.png --layer offset --window 40,40,130,110\n"
		    "furrow map world.furrow -o layer.png --world-file\n"
		    "furrow map world.furrow -o site.svg --grid degrees --size 120\n",
	.see = "furrow-drive(1), furrow-export(1)",
	.run = run,
};
