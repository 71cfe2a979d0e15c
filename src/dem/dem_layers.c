/*
 * Reads sources that have the same lattice of posts as one raster. GDAL's mosaic is not used here, since it handles each post
 * alone. Where sources overlap, the source named first is on top.
 */
#include "dem_vertical.h"

#define SAME_LATTICE 1e-6 /* posts */

struct layer {
	GDALDatasetH dataset;
	int64_t column, row; /* of its first pixel among all, from the north-west */
	int width, height;
	bool from_east, from_south; /* as in struct gdal_source */
};

struct dem_layers {
	struct layer *layers;
	size_t count;
	struct dem_lattice lattice; /* of the whole */
	struct dem_lift *lift; /* converts heights; NULL: they stay */
	bool single;           /* heights that are converted are rounded to floats */
	double *posts; /* of one of them, as many as were asked for at most */
	size_t room;
};

static bool same_text(const char *a, const char *b)
{
	return a == NULL || b == NULL ? a == b : strcmp(a, b) == 0;
}

bool dem_layers_fit(const struct gdal_source *a, const struct gdal_source *b)
{
	if (a->system != b->system || !same_text(a->from, b->from) || !same_text(a->to, b->to))
		return false;
	double east = (b->place[0] - a->place[0]) / a->place[1], south = (b->place[3] - a->place[3]) / a->place[5];
	return a->place[1] == b->place[1] && a->place[5] == b->place[5] && a->place[2] == 0 && a->place[4] == 0 &&
	       b->place[2] == 0 && b->place[4] == 0 && fabs(east - rint(east)) < SAME_LATTICE &&
	       fabs(south - rint(south)) < SAME_LATTICE;
}

void dem_layers_destroy(struct dem_layers *layers)
{
	if (layers == NULL)
		return;
	for (size_t i = 0; i < layers->count; i++)
		if (layers->layers[i].dataset != NULL)
			GDALClose(layers->layers[i].dataset);
	dem_lift_destroy(layers->lift);
	mem_free_all(layers->layers, layers->posts, layers);
}

/* Finds the area that all sources cover together. A single source may be rotated. */
static void cover(struct dem_layers *layers, const struct gdal_source *const *sources, size_t count)
{
	const double *first = sources[0]->place;
	int64_t west = 0, north = 0, east = sources[0]->width, south = sources[0]->height;
	for (size_t i = 0; i < count; i++) {
		struct layer *layer = &layers->layers[i];
		layer->column = i == 0 ? 0 : llrint((sources[i]->place[0] - first[0]) / first[1]);
		layer->row = i == 0 ? 0 : llrint((sources[i]->place[3] - first[3]) / first[5]);
		west = layer->column < west ? layer->column : west;
		north = layer->row < north ? layer->row : north;
		east = layer->column + layer->width > east ? layer->column + layer->width : east;
		south = layer->row + layer->height > south ? layer->row + layer->height : south;
	}
	for (size_t i = 0; i < count; i++) {
		layers->layers[i].column -= west;
		layers->layers[i].row -= north;
	}
	/* The south-west post is the first; rows count to the north. */
	double column = (double)west + 0.5, row = (double)south - 0.5;
	layers->lattice = (struct dem_lattice){
		.at = {first[0] + column * first[1] + row * first[2], first[1], -first[2],
		       first[3] + column * first[4] + row * first[5], first[4], -first[5]},
		.width = east - west,
		.height = south - north,
		.srs = sources[0]->srs,
	};
}

static enum status add_lift(struct dem_layers *layers, const struct gdal_source *const *sources, size_t count)
{
	layers->single = true;
	for (size_t i = 0; i < count; i++)
		layers->single = layers->single && !sources[i]->doubles;
	if (sources[0]->from == NULL)
		return STATUS_OK;
	return dem_lift_create(&(struct dem_lift_params){
		.from = sources[0]->from,
		.to = sources[0]->to,
		.lattice = &layers->lattice,
		.name = sources[0]->path,
	}, &layers->lift);
}

enum status dem_layers_create(const struct gdal_source *const *sources, size_t count, struct dem_layers **out)
{
	struct dem_layers *layers = mem_calloc(1, sizeof *layers);
	if (layers != NULL)
		layers->layers = mem_calloc(count, sizeof *layers->layers);
	if (layers == NULL || layers->layers == NULL) {
		dem_layers_destroy(layers);
		return fail_memory("opening the sources");
	}
	for (size_t i = 0; i < count; i++) {
		const struct gdal_source *source = sources[i];
		layers->count = i + 1;
		layers->layers[i] = (struct layer){GDALOpen(source->vrt, GA_ReadOnly), 0, 0, source->width, source->height, source->from_east, source->from_south};
		if (layers->layers[i].dataset == NULL) {
			dem_layers_destroy(layers);
			return fail_with(STATUS_INPUT, "%s: cannot be read%s; give another raster", source->path,
					 dem_gdal_because());
		}
	}
	cover(layers, sources, count);
	enum status status = add_lift(layers, sources, count);
	if (status != STATUS_OK) {
		dem_layers_destroy(layers);
		return status;
	}
	*out = layers;
	return STATUS_OK;
}

const struct dem_lattice *dem_layers_lattice(const struct dem_layers *layers)
{
	return &layers->lattice;
}

static void lay_over(const double *posts, int64_t count, double *below)
{
	for (int64_t i = 0; i < count; i++)
		below[i] = isnan(posts[i]) ? below[i] : posts[i];
}

/* Reads rows of a layer, the southern one first. */
static bool read_layer(const struct layer *layer, struct post_rect part, double *posts)
{
	int width = (int)(part.x1 - part.x0), rows = (int)(part.y1 - part.y0);
	const GSpacing pixel = sizeof *posts, line = width * pixel;
	int64_t column = part.x0 - layer->column, row = part.y0 - layer->row;
	double *first = posts; /* the raster's first post of the part */
	if (layer->from_south)
		row = layer->height - row - rows;
	else
		first += (int64_t)(rows - 1) * width;
	if (layer->from_east) {
		column = layer->width - column - width;
		first += width - 1;
	}
	return GDALRasterIOEx(GDALGetRasterBand(layer->dataset, 1), GF_Read, (int)column, (int)row, width, rows, first, width, rows, GDT_Float64,
			      layer->from_east ? -pixel : pixel, layer->from_south ? line : -line, NULL) == CE_None;
}

/* Copies a layer's part over `heights`. `rect` counts rows from the north. */
static bool take_layer(struct dem_layers *layers, const struct layer *layer, struct post_rect rect, double *heights)
{
	struct post_rect own = {layer->column, layer->row, layer->column + layer->width, layer->row + layer->height};
	struct post_rect part = post_rect_intersect(own, rect);
	if (post_rect_empty(part))
		return true;
	if (!read_layer(layer, part, layers->posts))
		return false;
	int64_t width = part.x1 - part.x0, above = rect.y1 - part.y1;
	for (int64_t row = 0; row < part.y1 - part.y0; row++)
		lay_over(layers->posts + row * width, width, heights + (above + row) * (rect.x1 - rect.x0) + part.x0 - rect.x0);
	return true;
}

static enum status read_all(struct dem_layers *layers, struct post_rect rect, double *heights, bool *done)
{
	size_t count = (size_t)((rect.x1 - rect.x0) * (rect.y1 - rect.y0));
	struct post_rect from_north = {rect.x0, layers->lattice.height - rect.y1, rect.x1, layers->lattice.height - rect.y0};
	if (layers->count == 1) {
		*done = read_layer(&layers->layers[0], from_north, heights);
		return STATUS_OK;
	}
	*done = true;
	if (count > layers->room) {
		mem_free(layers->posts);
		layers->posts = mem_alloc(count, sizeof *layers->posts);
		layers->room = layers->posts != NULL ? count : 0;
		TRY_MEM(layers->posts, "reading the sources");
	}
	for (size_t i = 0; i < count; i++)
		heights[i] = (double)NAN;
	for (size_t i = layers->count; i-- > 0 && *done;)
		*done = take_layer(layers, &layers->layers[i], from_north, heights);
	return STATUS_OK;
}

enum status dem_layers_read(struct dem_layers *layers, struct post_rect rect, double *heights, bool *done)
{
	TRY(read_all(layers, rect, heights, done));
	return *done && layers->lift != NULL ? dem_lift_run(layers->lift, rect, layers->single, heights) : STATUS_OK;
}
