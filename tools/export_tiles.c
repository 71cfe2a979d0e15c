/* furrow export --tiles: a folder of map and globe tiles, with a page. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "dem/dem.h"
#include "exchange/exchange.h"
#include "export.h"
#include "relief_told.h"

#define LEAFLET "/usr/share/javascript/leaflet"

/* Options that say what one file has, and nothing of tiles. */
static enum status check_options(const struct arguments *arguments)
{
	static const char *const foreign[] = {"o", "mesh", "up", "layer", "level"};
	for (size_t i = 0; i < sizeof foreign / sizeof *foreign; i++)
		if (arguments_text(arguments, foreign[i]) != NULL)
			return fail_with(STATUS_USAGE, "export: --tiles has all zoom levels; leave %s%s out",
					 foreign[i][1] == '\0' ? "-" : "--", foreign[i]);
	return STATUS_OK;
}

static enum status step(void *user, int64_t done, int64_t total)
{
	struct progress *progress = user;
	enum status status = progress_step(progress, done, total);
	if (status == STATUS_INTERRUPTED)
		return fail_with(status, "%s: interrupted; run it again to go on", progress->what);
	return status;
}

/* Reads --window and --window-srs. Of degrees, the tiles have just those: the antimeridian may be their edge. */
static enum status read_window(const struct export_request *asked, const struct store_meta *meta, struct exchange_tiles_params *params)
{
	struct export_request request = *asked;
	struct post_rect rect;
	if (!request.has_window)
		return STATUS_OK;
	params->has_clip = request.window_srs != NULL && strcmp(request.window_srs, DEM_SRS_DEGREES) == 0;
	memcpy(params->clip, request.window, sizeof params->clip);
	if (params->has_clip && request.window[0] > request.window[2])
		return fail_with(STATUS_INPUT, "export: --window %g,%g,%g,%g: crosses the antimeridian, or its corners are swapped; give one that ends at 180, and one that begins at -180, "
				 "each with a folder of its own", request.window[0], request.window[1], request.window[2], request.window[3]);
	TRY(export_place_window(&request, meta));
	TRY(export_find_rect(&request, &meta->extent, &rect));
	params->has_window = true;
	memcpy(params->window, request.window, sizeof params->window);
	return STATUS_OK;
}

/* How heights are coded: --encoding, or --height-step. */
static enum status read_coding(const struct arguments *arguments, struct exchange_tiles_params *params)
{
	int encoding = 0;
	TRY(arguments_number(arguments, "height-step", 1e-4, 100, &params->step));
	if (arguments_text(arguments, "encoding") == NULL)
		return STATUS_OK;
	TRY(arguments_choice(arguments, "encoding", &encoding));
	params->terrarium = encoding == 1;
	return params->step == 0 ? STATUS_OK
				 : fail_with(STATUS_USAGE, "export: --height-step %g: --encoding %s has its own steps; leave one of both out", params->step,
					     arguments_text(arguments, "encoding"));
}

/* Globes have no other heights than those above the ellipsoid. `vertical`: what the store's are above; "": not known. */
static void tell_vertical(const char *directory, const char *vertical)
{
	if (vertical[0] == '\0')
		note("%s: globes take heights as above the ellipsoid, and the store does not know what its heights are above; import with --s-vertical and "
		     "--t-vertical ellipsoid for globes", directory);
	else if (strncmp(vertical, "ellipsoid", strlen("ellipsoid")) != 0)
		note("%s: globes take heights as above the ellipsoid, and those of the store are %s; import with --t-vertical ellipsoid for globes", directory,
		     vertical);
}

/* Tiles of heights have nothing below the zero of their coding. */
static void tell_lowest(const char *path, const struct exchange_tiles_result *made, const struct store_meta *meta, const char *more)
{
	if (meta->low < made->coding_zero)
		note("%s: the lowest ground is at %.6g m, and tiles of heights have nothing below %g m: they have that there%s", path, meta->low, made->coding_zero, more);
}

static void print_made(const struct exchange_tiles_params *params, const struct exchange_tiles_result *made, const struct store_meta *meta)
{
	const char *directory = params->directory;
	int64_t tiles = 0, written = 0;
	for (int set = 0; set < EXCHANGE_SETS; set++) {
		tiles += made->made[set];
		written += made->written[set];
	}
	printf("%s: revision %lld, zoom %d to %d, globe 0 to %d: %lld terrain, %lld hillshade, %lld ruts, %lld mesh tiles; %lld files written, "
	       "%lld removed; %.1f s on %d threads (%.0f tiles a second)\n",
	       directory, (long long)made->revision, made->zoom[0], made->zoom[1], made->mesh_zoom[1], (long long)made->made[EXCHANGE_TERRAIN],
	       (long long)made->made[EXCHANGE_HILLSHADE], (long long)made->made[EXCHANGE_RUTS], (long long)made->made[EXCHANGE_MESH],
	       (long long)written, (long long)made->removed, made->seconds, made->threads,
	       made->seconds > 0 ? (double)tiles / made->seconds : 0);
	printf("python3 -m http.server -d %s    # then open http://localhost:8000\n", directory);
	if (params->gzip)
		note("%s: globe tiles are compressed: serve .terrain with Content-Encoding: gzip, or unpack them in the page, as EXCHANGE.md has it", directory);
	if (made->made[EXCHANGE_IMAGERY] > 0)
		printf("%s: %lld tiles of imagery, to zoom %d\n", directory, (long long)made->made[EXCHANGE_IMAGERY], made->imagery_zoom);
	if (made->kept > 0)
		note("%s: went on from an export that was cut short", directory);
	if (made->local)
		note("%s: the store is local metres: its map is a square of its own, and its globe tiles lie around longitude 0, latitude 0",
		     directory);
	else if (!made->earth)
		note("%s: degrees are those of %s, not of the Earth: give a client that body's ellipsoid", directory, made->system);
	else
		tell_vertical(directory, meta->vertical);
	tell_lowest(directory, made, meta, ", globe tiles the ground");
	if (meta->holes > 0)
		note("%s: the terrain has holes, which globe tiles fill from their rims; maps leave them out", directory);
	if (fmax(made->mesh_step[0], made->mesh_step[1]) > 1.005 * meta->extent.spacing)
		note("%s: the globe's finest complete level has vertices %.3g x %.3g m apart, and the store has posts every %.3g m: --fine-globe makes one more level, "
		     "with up to four times as many globe tiles", directory, made->mesh_step[0], made->mesh_step[1], meta->extent.spacing);
}

/* Reads what folders and files of tiles have in common. `lit`: hillshades are among them. */
static enum status read_common(const struct arguments *arguments, struct export_request *request, bool lit, struct exchange_tiles_params *params)
{
	const char *path = arguments_at(arguments, 0), *slash = strrchr(path, '/');
	int wide = 0;
	TRY(arguments_integer(arguments, "jobs", 1, 64, &params->jobs));
	TRY(arguments_numbers(arguments, "height-range", 2, params->range, &params->has_range));
	TRY(export_read_light(arguments, request, lit));
	TRY(read_coding(arguments, params));
	if (arguments_text(arguments, "tile-size") != NULL)
		TRY(arguments_choice(arguments, "tile-size", &wide));
	params->pixels = wide ? 512 : 256;
	TRY(export_read_window(arguments, request));
	if (params->has_range && !(params->range[0] < 0 && params->range[1] > 0))
		return fail_with(STATUS_USAGE, "export: --height-range %g,%g: ruts have colours for both signs; give MIN below 0 and MAX above",
				 params->range[0], params->range[1]);
	params->title = slash != NULL ? slash + 1 : path;
	params->sun = request->sun;
	params->exaggerate = request->exaggerate;
	return STATUS_OK;
}

enum status export_tiles(const struct arguments *arguments)
{
	const char *path = arguments_at(arguments, 0), *leaflet = arguments_text(arguments, "leaflet");
	struct export_request request = {.command = "export", .exaggerate = 1};
	struct progress progress;
	struct exchange_tiles_params params = {
		.directory = arguments_text(arguments, "tiles"),
		.since = -1,
		.leaflet = leaflet != NULL ? leaflet : LEAFLET,
		.fine_globe = arguments_flag(arguments, "fine-globe"),
		.gzip = arguments_flag(arguments, "gzip"),
		.progress = step,
		.progress_user = &progress,
	};
	struct exchange_tiles_result made;
	struct store *store = NULL;
	TRY(check_options(arguments));
	TRY(arguments_integer(arguments, "since", 0, INT64_MAX - 1, &params.since));
	TRY(read_common(arguments, &request, true, &params));
	interrupt_catch();
	TRY(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	params.store = store;
	enum status status;
	TRY_OR(done, read_window(&request, store_meta(store), &params));
	progress_start(&progress, params.directory, "tiles");
	relief_tell_missing(path, store);
	status = exchange_tiles(&params, &made);
	progress_end(&progress);
	if (status == STATUS_OK)
		print_made(&params, &made, store_meta(store));
done:
	store_close(store);
	return status;
}

/* The set of tiles that --layer asks for. */
static enum status read_set(const struct arguments *arguments, struct export_request *request, enum exchange_set *set)
{
	TRY(export_read_layer(arguments, &request->layer));
	const int layer = request->layer;
	*set = layer == LAYER_HILLSHADE ? EXCHANGE_HILLSHADE : layer == LAYER_OFFSET ? EXCHANGE_RUTS : layer == LAYER_IMAGERY ? EXCHANGE_IMAGERY : EXCHANGE_TERRAIN;
	return layer == LAYER_SURFACE || layer == LAYER_HILLSHADE || layer == LAYER_OFFSET || layer == LAYER_IMAGERY
		       ? STATUS_OK
		       : fail_with(STATUS_USAGE, "export: an .mbtiles holds surface, hillshade, offset or imagery, not %s; write a .tif", export_layer_name(layer));
}

/* Options of another layer than the one that the file has. */
static enum status check_set(const struct arguments *arguments, enum exchange_set set, const char *layer)
{
	static const struct {
		const char *option;
		enum exchange_set of;
	} options[] = {{"height-range", EXCHANGE_RUTS}, {"encoding", EXCHANGE_TERRAIN}, {"height-step", EXCHANGE_TERRAIN}};
	for (size_t i = 0; i < sizeof options / sizeof *options; i++)
		if (options[i].of != set && arguments_flag(arguments, options[i].option))
			return fail_with(STATUS_USAGE, "export: --%s says nothing of tiles of %s; leave it out", options[i].option, layer);
	return STATUS_OK;
}

/* What tiles of one layer have not, of all that the store has. */
static void tell_left_out(const struct exchange_tiles_params *params, enum exchange_set set, const struct exchange_tiles_result *made, const struct store_meta *meta)
{
	if (made->finer_left_out)
		note("%s: ruts or insets are finer than its zoom levels, which have all tiles: ruts are in an .mbtiles of --layer offset, and --tiles has both", params->directory);
	if (!made->earth)
		note("%s: degrees are those of %s, not of the Earth: give a client that body's ellipsoid", params->directory, made->system);
	if (set == EXCHANGE_TERRAIN)
		tell_lowest(params->directory, made, meta, "");
	if (set == EXCHANGE_TERRAIN && meta->holes > 0)
		note("%s: the terrain has holes, and tiles of heights know none: they have %.6g m there, the lowest ground", params->directory, meta->low);
}

enum status export_mbtiles(const struct arguments *arguments)
{
	static const char *const foreign[] = {"since", "leaflet", "fine-globe", "gzip", "level", "mesh", "up"};
	const char *path = arguments_at(arguments, 0);
	struct export_request request = {.command = "export", .exaggerate = 1};
	struct progress progress;
	struct exchange_tiles_params params = {.directory = arguments_text(arguments, "o"), .since = -1, .progress = step, .progress_user = &progress};
	struct exchange_tiles_result made;
	enum exchange_set set = EXCHANGE_TERRAIN;
	struct store *store = NULL;
	for (size_t i = 0; i < sizeof foreign / sizeof *foreign; i++)
		if (arguments_flag(arguments, foreign[i]))
			return fail_with(STATUS_USAGE, "export: an .mbtiles has all zoom levels of one layer, and no globe and no mesh; leave --%s out", foreign[i]);
	TRY(read_set(arguments, &request, &set));
	TRY(check_set(arguments, set, export_layer_name(request.layer)));
	TRY(read_common(arguments, &request, set == EXCHANGE_HILLSHADE, &params));
	interrupt_catch();
	TRY(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	params.store = store;
	enum status status;
	TRY_OR(done, read_window(&request, store_meta(store), &params));
	progress_start(&progress, params.directory, "tiles");
	relief_tell_missing(path, store);
	status = exchange_mbtiles(&params, set, &made);
	progress_end(&progress);
	TRY_OR(done, status);
	printf("%s: revision %lld, zoom %d to %d: %lld tiles; %.1f s on %d threads\n", params.directory, (long long)made.revision, made.zoom[0], made.zoom[1],
	       (long long)made.made[set], made.seconds, made.threads);
	tell_left_out(&params, set, &made, store_meta(store));
done:
	store_close(store);
	return status;
}
