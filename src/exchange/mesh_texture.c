/*
 * What a mesh's vertices have beside their place: where they are in a picture, and the picture.
 *
 * The picture is that of `furrow map`: ruts and heaps in colour over the shaded ground, or heights in colour where there is neither. It has a pixel for each
 * post of its level, which is the finest with at most TEXTURE_SIDE posts on a side. A post is the centre of its pixel.
 */
#include "exchange/mesh.h"

#include <stdlib.h>

static struct chart_raster_params raster_params(const struct exchange_mesh_params *params, enum store_layer layer)
{
	struct chart_raster_params raster = {.reader = params->reader, .meta = params->meta, .deformed = params->deformed, .working = params->working,
		.layer = layer, .rect = params->rect, .exaggerate = 1};
	raster.level = chart_level(&params->meta->extent, params->level, EXCHANGE_TEXTURE_SIDE, &raster.rect);
	chart_sun_of(CHART_AZIMUTH, CHART_ALTITUDE, &raster.sun);
	return raster;
}

static bool has_values(const struct chart_raster *raster)
{
	for (size_t i = 0; i < (size_t)raster->width * raster->height; i++)
		if (raster->values[i] != 0)
			return true;
	return false;
}

static enum status make_raster(const struct exchange_mesh_params *params, struct chart_raster *raster, enum chart_ramp *ramp)
{
	struct chart_raster_params heights = raster_params(params, STORE_SURFACE), ruts = raster_params(params, STORE_OFFSET);
	*ramp = CHART_RAMP_SIGNED;
	if (params->deformed) {
		TRY(chart_raster_create(&ruts, raster));
		if (has_values(raster))
			return STATUS_OK;
		chart_raster_finish(raster);
	}
	*ramp = CHART_RAMP_HEIGHTS;
	return chart_raster_create(&heights, raster);
}

static enum status write_picture(const struct exchange_mesh_params *params, const struct chart_raster *raster, enum chart_ramp ramp,
				 struct exchange_texture *out)
{
	const struct chart_map map = {.raster = raster, .ramp = ramp, .pixels = raster->width > raster->height ? raster->width : raster->height};
	struct chart_ground ground;
	FILE *file = open_memstream(&out->png, &out->bytes);
	if (file == NULL)
		return fail_memory("a mesh's picture");
	enum status status = chart_ground_write(&map, params->path, file, &ground);
	if (fclose(file) != 0 && status == STATUS_OK)
		status = fail_memory("a mesh's picture");
	return status;
}

enum status exchange_texture_create(const struct exchange_mesh_params *params, struct exchange_texture *out)
{
	struct chart_raster raster = {.width = 0};
	enum chart_ramp ramp;
	*out = (struct exchange_texture){.png = NULL};
	TRY(make_raster(params, &raster, &ramp));
	const enum status status = write_picture(params, &raster, ramp, out);
	const double step = raster.spacing / extent_spacing(&params->meta->extent, params->level);
	/* In posts of the mesh, from its first: of the picture's edges. */
	out->west = ((double)raster.rect.x0 - 0.5) * step - (double)params->rect.x0;
	out->south = ((double)raster.rect.y0 - 0.5) * step - (double)params->rect.y0;
	out->width = raster.width * step;
	out->height = raster.height * step;
	chart_raster_finish(&raster);
	if (status != STATUS_OK)
		exchange_texture_finish(out);
	return status;
}

void exchange_texture_place(const struct exchange_texture *texture, int64_t x, int64_t y, double out[2])
{
	out[0] = ((double)x - texture->west) / texture->width;
	out[1] = ((double)y - texture->south) / texture->height;
}

void exchange_texture_finish(struct exchange_texture *texture)
{
	free(texture->png); /* of open_memstream */
	*texture = (struct exchange_texture){.png = NULL};
}
