/* furrow export, of what deformation left to a PNG: a map in false colour. */
#include <stdio.h>
#include <string.h>

#include "export.h"

#define SIDE_MOST 4096
#define SIDE 800 /* smaller maps are enlarged to about that */

enum status export_check_picture(const struct export_request *request)
{
	const double *range = request->range;
	bool has_sign = request->layer == LAYER_OFFSET || request->layer == LAYER_HEAPED || request->layer == LAYER_SHEAR_X ||
			request->layer == LAYER_SHEAR_Y;
	if (request->layer == LAYER_QUANTA)
		return fail_with(STATUS_USAGE, "export: a PNG holds no fixed_point units; write them as .tif, or --layer offset as a map");
	if (request->has_range && has_sign && !(range[0] < 0 && range[1] > 0))
		return fail_with(STATUS_USAGE, "export: --height-range %g,%g: a map of %s has colours for both signs; give MIN below 0 "
					       "and MAX above", range[0], range[1], export_layer_name(request->layer));
	if (request->has_range && !has_sign && range[0] != 0)
		return fail_with(STATUS_USAGE, "export: --height-range %g,%g: the colours of %s begin at 0; give 0,MAX", range[0],
				 range[1], export_layer_name(request->layer));
	return STATUS_OK;
}

/* The pixels of a coarser level that the posts lie in. */
static void coarsen(const struct extent *extent, int level, struct post_rect *rect, int *coarser)
{
	struct post_rect posts = *rect;
	*coarser = level;
	while (rect->x1 - rect->x0 > SIDE_MOST || rect->y1 - rect->y0 > SIDE_MOST) {
		int shift = ++*coarser - level;
		int64_t half = (int64_t)1 << (shift - 1);
		int64_t width = extent_posts(extent->width, *coarser), height = extent_posts(extent->height, *coarser);
		*rect = post_rect_intersect(
			(struct post_rect){(posts.x0 + half) >> shift, (posts.y0 + half) >> shift,
					   ((posts.x1 - 1 + half) >> shift) + 1, ((posts.y1 - 1 + half) >> shift) + 1},
			(struct post_rect){0, 0, width, height});
		if (rect->x0 == rect->x1) /* nearer to a post beyond the last one */
			rect->x0--;
		if (rect->y0 == rect->y1)
			rect->y0--;
	}
}

static enum render_ramp ramp_of(int layer)
{
	return layer == LAYER_PRESSED ? RENDER_RAMP_GREEN : layer == LAYER_SHEAR ? RENDER_RAMP_ROSE : RENDER_RAMP_SIGNED;
}

static enum status draw(const struct export_request *request, const struct render_map_raster *raster)
{
	const char *slash = strrchr(request->store, '/'), *layer = export_layer_name(request->layer);
	char title[256], subtitle[64];
	snprintf(title, sizeof title, "%s: %s", slash != NULL ? slash + 1 : request->store, layer);
	snprintf(subtitle, sizeof subtitle, "%.4g m a post", raster->spacing);
	struct render_map_layout layout = {
		.raster = raster,
		.title = title,
		.subtitle = subtitle,
		.layer = layer,
		.share = request->layer >= LAYER_SHEAR && request->layer <= LAYER_SHEAR_Y,
		.ramp = ramp_of(request->layer),
		.range = {request->range[0], request->range[1]},
		.side = SIDE,
	};
	struct render_canvas canvas = {NULL, 0, 0};
	struct render_placed placed;
	enum status status = render_map_layout_create(&layout, &canvas, &placed);
	if (status == STATUS_OK)
		status = render_map_layout_frame(&layout, &canvas, &placed);
	if (status == STATUS_OK)
		status = render_canvas_write(&canvas, request->path);
	if (status == STATUS_OK)
		printf("%s: a map of %s, %u x %u pixels, of %u x %u posts, %g m apart\n", request->path, layer, canvas.width,
		       canvas.height, raster->width, raster->height, raster->spacing);
	render_canvas_finish(&canvas);
	return status;
}

enum status export_picture(const struct export_request *request, struct store *store)
{
	const struct store_meta *meta = store_meta(store);
	struct store_reader *reader = NULL;
	struct render_map_raster raster = {.width = 0};
	struct progress progress;
	struct render_map_raster_params params = {
		.meta = meta,
		.layer = export_store_layer(request->layer),
		.sun = request->sun,
		.exaggerate = request->exaggerate,
		.progress = progress_step,
		.progress_user = &progress,
	};
	enum status status = export_find_rect(request, &meta->extent, &params.rect);
	if (status != STATUS_OK)
		return status;
	coarsen(&meta->extent, (int)request->level, &params.rect, &params.level);
	params.deformed = store_has_working_level(store, &params.working);
	interrupt_catch();
	status = store_reader_create(store, &reader);
	params.reader = reader;
	progress_start(&progress, request->path, "rows and tiles");
	if (status == STATUS_OK)
		status = render_map_raster_create(&params, &raster);
	progress_end(&progress);
	if (status == STATUS_OK)
		status = draw(request, &raster);
	render_map_raster_finish(&raster);
	store_reader_destroy(reader);
	return status;
}
