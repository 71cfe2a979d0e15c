/*
 * Joins sources that have the same lattice of posts. GDAL's mosaic is not used here, since it handles each post alone. Where
 * sources overlap, the source named first is on top.
 */
#include "dem_gdal.h"

struct layer {
	GDALDatasetH dataset;
	int64_t column, row; /* of its first pixel among all, from the north-west */
	int width, height;
};

struct dem_layers {
	struct layer *layers;
	size_t count;
	double *posts; /* of one of them, as many as were asked for at most */
	size_t room;
};

bool dem_layers_fit(const struct gdal_source *sources, size_t count)
{
	const double *first = sources[0].place;
	bool fit = true;
	for (size_t i = 0; i < count && fit; i++) {
		const double *place = sources[i].place;
		double east = (place[0] - first[0]) / first[1], south = (place[3] - first[3]) / first[5];
		fit = place[1] == first[1] && place[5] == first[5] && place[2] == 0 && place[4] == 0 &&
		      fabs(east - rint(east)) < 1e-6 && fabs(south - rint(south)) < 1e-6;
	}
	return fit;
}

void dem_layers_destroy(struct dem_layers *layers)
{
	if (layers == NULL)
		return;
	for (size_t i = 0; i < layers->count; i++)
		if (layers->layers[i].dataset != NULL)
			GDALClose(layers->layers[i].dataset);
	mem_free(layers->layers);
	mem_free(layers->posts);
	mem_free(layers);
}

enum status dem_layers_create(const struct gdal_source *sources, size_t count, const double place[6],
			      struct dem_layers **out)
{
	struct dem_layers *layers = mem_calloc(1, sizeof *layers);
	if (layers != NULL)
		layers->layers = mem_calloc(count, sizeof *layers->layers);
	if (layers == NULL || layers->layers == NULL) {
		dem_layers_destroy(layers);
		return fail_memory("opening the sources");
	}
	for (size_t i = 0; i < count; i++) {
		const struct gdal_source *source = &sources[i];
		layers->count = i + 1;
		layers->layers[i] = (struct layer){
			.dataset = GDALOpen(source->vrt, GA_ReadOnly),
			.column = llrint((source->place[0] - place[0]) / place[1]),
			.row = llrint((source->place[3] - place[3]) / place[5]),
			.width = source->width,
			.height = source->height,
		};
		if (layers->layers[i].dataset == NULL) {
			dem_layers_destroy(layers);
			return fail_with(STATUS_INPUT, "%s: cannot be read: %s; give another raster", source->path,
					 dem_gdal_message());
		}
	}
	*out = layers;
	return STATUS_OK;
}

static void lay_over(const double *posts, int64_t count, double *below)
{
	for (int64_t i = 0; i < count; i++)
		below[i] = isnan(posts[i]) ? below[i] : posts[i];
}

/* Copies a layer's part in columns x0 .. x1 - 1 and rows y0 .. y1 - 1 (from the north) over `heights`. */
static bool take_layer(struct dem_layers *layers, const struct layer *layer, struct post_rect rect, double *heights)
{
	struct post_rect own = {layer->column, layer->row, layer->column + layer->width, layer->row + layer->height};
	struct post_rect part = post_rect_intersect(own, rect);
	if (post_rect_empty(part))
		return true;
	int width = (int)(part.x1 - part.x0), rows = (int)(part.y1 - part.y0);
	if (GDALRasterIO(GDALGetRasterBand(layer->dataset, 1), GF_Read, (int)(part.x0 - own.x0), (int)(part.y0 - own.y0),
			 width, rows, layers->posts, width, rows, GDT_Float64, 0, 0) != CE_None)
		return false;
	for (int64_t row = 0; row < rows; row++) {
		int64_t up = rect.y1 - 1 - (part.y0 + row); /* ours count from the south */
		lay_over(layers->posts + row * width, width, heights + up * (rect.x1 - rect.x0) + part.x0 - rect.x0);
	}
	return true;
}

enum status dem_layers_read(struct dem_layers *layers, struct post_rect rect, double *heights, bool *done)
{
	size_t count = (size_t)((rect.x1 - rect.x0) * (rect.y1 - rect.y0));
	*done = true;
	if (count > layers->room) {
		mem_free(layers->posts);
		layers->posts = mem_alloc(count, sizeof *layers->posts);
		layers->room = layers->posts != NULL ? count : 0;
		if (layers->posts == NULL)
			return fail_memory("reading the sources");
	}
	for (size_t i = 0; i < count; i++)
		heights[i] = (double)NAN;
	for (size_t i = layers->count; i-- > 0 && *done;)
		*done = take_layer(layers, &layers->layers[i], rect, heights);
	return STATUS_OK;
}
