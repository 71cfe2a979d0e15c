/* A layer of a store as a map: furrow map, and furrow export of what deformation left. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "export.h"
#include "world_file.h"

#define SIDE_MOST 4096 /* posts, without a size */
#define SIDE 900       /* pixels: smaller maps are enlarged to at least that, without a size */

enum status export_check_picture(const struct export_request *request)
{
	const double *range = request->range;
	const char *command = request->command, *layer = export_layer_name(request->layer);
	if (request->layer == LAYER_QUANTA || request->layer == LAYER_HILLSHADE || request->layer == LAYER_LOOSE || request->layer == LAYER_DENSITY)
		return fail_with(STATUS_USAGE, "%s: a map has no %s; write it as .tif, or --layer offset as a map", command, layer);
	if (request->layer == LAYER_IMAGERY && request->has_range)
		return fail_with(STATUS_USAGE, "%s: --height-range: imagery has colours of its own; leave it out", command);
	if (request->layer <= LAYER_BASE || !request->has_range)
		return STATUS_OK;
	bool has_sign = request->layer == LAYER_OFFSET || request->layer == LAYER_HEAPED || request->layer == LAYER_SHEAR_X ||
			request->layer == LAYER_SHEAR_Y;
	if (has_sign && !(range[0] < 0 && range[1] > 0))
		return fail_with(STATUS_USAGE,
				 "%s: --height-range %g,%g: a map of %s has colours for both signs; give MIN below 0 "
				 "and MAX above",
				 command, range[0], range[1], layer);
	if (!has_sign && range[0] != 0)
		return fail_with(STATUS_USAGE, "%s: --height-range %g,%g: the colours of %s begin at 0; give 0,MAX", command,
				 range[0], range[1], layer);
	return STATUS_OK;
}

static enum chart_ramp ramp_of(int layer)
{
	return layer <= LAYER_BASE      ? CHART_RAMP_HEIGHTS
	       : layer == LAYER_PRESSED || layer == LAYER_BENT ? CHART_RAMP_GREEN
	       : layer == LAYER_SHEAR || layer == LAYER_DISTURBANCE || layer == LAYER_TORN ? CHART_RAMP_ROSE
					: CHART_RAMP_SIGNED;
}

/* What the legend calls a layer. */
static const char *title_of(int layer)
{
	static const char *const titles[] = {[LAYER_SURFACE] = "Height",
					     [LAYER_BASE] = "Height of the base",
					     [LAYER_HEAPED] = "Deposited thickness",
					     [LAYER_PRESSED] = "Plastic sinkage",
					     [LAYER_SHEAR] = "Shear",
					     [LAYER_SHEAR_X] = "Shear, eastward",
					     [LAYER_SHEAR_Y] = "Shear, northward",
					     [LAYER_OFFSET] = "Offset",
					     [LAYER_DISTURBANCE] = "Disturbance",
					     [LAYER_BENT] = "Bent plants",
					     [LAYER_TORN] = "Torn plants",
					     [LAYER_IMAGERY] = "Imagery"};
	return titles[layer];
}

/* Of heights also what they are above, if the store knows: "EGM96 height" is the name of what is above EGM96. */
static void write_layer(int layer, const struct store_meta *meta, char *text, size_t room)
{
	const size_t length = strlen(meta->vertical), ending = strlen(" height");
	const bool named = length > ending && strcmp(meta->vertical + length - ending, " height") == 0;
	if (layer <= LAYER_BASE && length > 0)
		snprintf(text, room, "%s above %.*s", title_of(layer), (int)(named ? length - ending : length), meta->vertical);
	else
		snprintf(text, room, "%s", title_of(layer));
}

/* The side of the window, or of the terrain, from east to west (axis 0) or from south to north. */
static void write_side(const struct export_request *request, const struct extent *extent, int axis, char *text, size_t room)
{
	const double all = extent_side(extent, axis), *window = request->window;
	const double metres = request->has_window ? fmin(window[2 + axis], all) - fmax(window[axis], 0) : all;
	snprintf(text, room, metres >= 1000 ? "%.4g km" : "%.4g m", metres >= 1000 ? metres / 1000 : metres);
}

static void write_subtitle(const struct export_request *request, const struct extent *extent, char *text, size_t room)
{
	char across[32], up[32];
	write_side(request, extent, 0, across, sizeof across);
	write_side(request, extent, 1, up, sizeof up);
	snprintf(text, room, "%s, %s by %s", request->layer <= LAYER_BASE ? "Heights" : request->layer == LAYER_IMAGERY ? "Imagery" : "What deformation left", across, up);
}

/* Pixels of the frame's longer side. Without a size a post is a whole number of pixels. */
static uint32_t pixels_for(const struct export_request *request, const struct chart_raster *raster)
{
	const uint32_t longest = raster->width > raster->height ? raster->width : raster->height;
	if (request->pixels > 0)
		return request->pixels;
	return longest < SIDE ? (SIDE + longest - 1) / longest * longest : longest;
}

static enum status draw(const struct export_request *request, const struct store_meta *meta, const struct chart_raster *raster, const uint8_t *colours)
{
	const char *slash = strrchr(request->store, '/'), *layer = export_layer_name(request->layer);
	char subtitle[96], head[128];
	struct chart_written written;
	write_layer(request->layer, meta, head, sizeof head);
	write_subtitle(request, &meta->extent, subtitle, sizeof subtitle);
	const struct chart_map map = {
		.raster = raster,
		.meta = meta,
		.title = request->title != NULL ? request->title
			 : slash != NULL        ? slash + 1
						: request->store,
		.subtitle = subtitle,
		.layer = head,
		.colours = colours,
		.share = (request->layer >= LAYER_SHEAR && request->layer <= LAYER_SHEAR_Y) || (request->layer >= LAYER_DISTURBANCE && request->layer <= LAYER_TORN),
		.ramp = ramp_of(request->layer),
		.range = {request->range[0], request->range[1]},
		.grid = request->grid,
		.size = request->size,
		.pixels = pixels_for(request, raster),
	};
	TRY(chart_map_write(&map, request->path, &written));
	if (request->world_file)
		TRY(world_file_write(request->path, meta, &written.place));
	printf("%s: a map of %s, %u x %u %s, of %u x %u posts, %g m apart\n", request->path, layer, written.width,
	       written.height, request->png ? "pixels" : "points", raster->width, raster->height, raster->spacing);
	return STATUS_OK;
}

enum status export_picture(const struct export_request *request, struct store *store)
{
	const struct store_meta *meta = store_meta(store);
	struct store_reader *reader = NULL;
	struct chart_raster raster = {.width = 0};
	uint8_t *colours = NULL;
	struct progress progress;
	struct chart_raster_params params = {
		.meta = meta,
		.layer = export_store_layer(request->layer),
		.sun = request->sun,
		.exaggerate = request->exaggerate,
		.progress = progress_step,
		.progress_user = &progress,
		.marks = request->marks,
	};
	if (request->layer == LAYER_IMAGERY && !store_has_imagery(store, NULL, NULL))
		return fail_with(STATUS_INPUT, "%s: it has no imagery; put some into it: furrow import --imagery ORTHO... -o %s", request->store,
				 shell_path(request->store).text);
	TRY(export_find_rect(request, &meta->extent, &params.rect));
	params.level =
		chart_level(&meta->extent, (int)request->level, request->pixels > 0 ? request->pixels : SIDE_MOST, &params.rect);
	params.deformed = store_has_working_level(store, &params.working);
	interrupt_catch();
	TRY(store_reader_create(store, &reader));
	params.reader = reader;
	progress_start(&progress, request->path, "rows and tiles");
	enum status status = chart_raster_create(&params, &raster);
	progress_end(&progress);
	TRY_OR(done, status);
	if (request->layer == LAYER_IMAGERY) {
		TRY_OR(done, mem_make(&colours, (size_t)raster.width * raster.height, 4, "a map"));
		TRY_OR(done, store_imagery_read_rect(reader, raster.level, raster.rect, colours));
	}
	TRY_OR(done, draw(request, meta, &raster, colours));
done:
	mem_free(colours);
	chart_raster_finish(&raster);
	store_reader_destroy(reader);
	return status;
}
