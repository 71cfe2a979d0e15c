#include "resident/resident.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "dem/dem.h"

#define LEVELS 255
#define STRIP 4096 /* posts that are read at once, or one row of a tile if that is more */

struct soil_rasters {
	struct soil_rasters_params params;
	struct raster {
		double low, high;
	} rasters[PAGES_NUMBER_BYTES];
	unsigned readers; /* one for each loader, and one for resident_soil_rasters_at */
	struct reader {
		struct dem_pixels *rasters[PAGES_NUMBER_BYTES];
		double *values; /* of a strip */
	} list[];
};

static size_t strip_posts(const struct soil_rasters *rasters)
{
	size_t row = tile_posts(&rasters->params.meta->extent);
	return row > STRIP ? row : STRIP;
}

static enum status open_reader(struct soil_rasters *rasters, struct reader *reader)
{
	const struct store_meta *meta = rasters->params.meta;
	TRY(mem_make(&reader->values, strip_posts(rasters), sizeof *reader->values, "the rasters of the soil"));
	for (int i = 0; i < rasters->params.count; i++)
		TRY(dem_pixels_open(&(struct dem_placed_params){.path = rasters->params.rasters[i].path, .extent = &meta->extent, .srs = meta->srs,
								.origin = {meta->origin[0],
									   meta->origin[1]}}, DEM_PLACED_NUMBERS, &reader->rasters[i]));
	return STATUS_OK;
}

static enum status find_ranges(struct soil_rasters *rasters)
{
	for (int i = 0; i < rasters->params.count; i++) {
		const struct soil_raster_params *params = &rasters->params.rasters[i];
		const struct dem_numbers_range range = {params->name, params->unit, params->low, params->high, params->above};
		TRY(dem_numbers_extremes(rasters->list[0].rasters[i], &range, &rasters->rasters[i].low, &rasters->rasters[i].high));
	}
	return STATUS_OK;
}

enum status resident_soil_rasters_open(const struct soil_rasters_params *params, struct soil_rasters **out)
{
	unsigned readers = (params->loaders > 0 ? params->loaders : 1) + (params->places ? 1 : 0);
	struct soil_rasters *rasters = mem_calloc(1, sizeof *rasters + readers * sizeof rasters->list[0]);
	TRY_MEM(rasters, "the rasters of the soil");
	rasters->params = *params;
	rasters->readers = readers;
	enum status status = STATUS_OK;
	dem_quiet_begin();
	for (unsigned i = 0; i < readers && status == STATUS_OK; i++)
		status = open_reader(rasters, &rasters->list[i]);
	if (status == STATUS_OK)
		status = find_ranges(rasters);
	dem_quiet_end();
	if (status != STATUS_OK) {
		resident_soil_rasters_close(rasters);
		return status;
	}
	*out = rasters;
	return STATUS_OK;
}

void resident_soil_rasters_close(struct soil_rasters *rasters)
{
	if (rasters == NULL)
		return;
	for (unsigned i = 0; i < rasters->readers; i++) {
		for (int k = 0; k < rasters->params.count; k++)
			dem_pixels_close(rasters->list[i].rasters[k]);
		mem_free(rasters->list[i].values);
	}
	mem_free(rasters);
}

void resident_soil_rasters_range(const struct soil_rasters *rasters, int raster, double *low, double *high)
{
	*low = rasters->rasters[raster].low;
	*high = rasters->rasters[raster].high;
}

/* Returns the level of a value; 0: NaN. */
static uint8_t level_of(const struct raster *raster, double value)
{
	if (isnan(value))
		return 0;
	double span = raster->high - raster->low, steps = span > 0 ? floor((value - raster->low) / span * (LEVELS - 1) + 0.5) : 0;
	return (uint8_t)(1 + fmin(fmax(steps, 0), LEVELS - 1));
}

/* Reads a rectangle with rows of at most a tile's posts. */
static enum status read_posts(const struct soil_rasters *rasters, struct reader *reader, int level, struct post_rect rect, uint8_t *numbers)
{
	int64_t width = rect.x1 - rect.x0, rows = (int64_t)strip_posts(rasters) / width;
	enum status status = STATUS_OK;
	memset(numbers, 0, (size_t)(PAGES_NUMBER_BYTES * width * (rect.y1 - rect.y0)));
	for (int i = 0; i < rasters->params.count; i++)
		for (int64_t y = rect.y0; y < rect.y1 && status == STATUS_OK; y += rows) {
			struct post_rect strip = {rect.x0, y, rect.x1, y + rows < rect.y1 ? y + rows : rect.y1};
			uint8_t *out = numbers + PAGES_NUMBER_BYTES * (y - rect.y0) * width;
			status = dem_numbers_read(reader->rasters[i], level, strip, reader->values);
			for (int64_t k = 0; status == STATUS_OK && k < width * (strip.y1 - strip.y0); k++)
				out[PAGES_NUMBER_BYTES * k + i] = level_of(&rasters->rasters[i], reader->values[k]);
		}
	return status;
}

enum status resident_soil_rasters_read(struct soil_rasters *rasters, unsigned loader, struct tile tile, uint8_t *numbers)
{
	assert(loader < rasters->readers);
	dem_quiet_begin();
	enum status status = read_posts(rasters, &rasters->list[loader], tile.level, tile_post_rect(&rasters->params.meta->extent, tile),
					numbers);
	dem_quiet_end();
	return status;
}

static enum status read_post(struct soil_rasters *rasters, unsigned reader, int level, int64_t x, int64_t y, uint8_t *numbers)
{
	dem_quiet_begin();
	enum status status = read_posts(rasters, &rasters->list[reader], level, (struct post_rect){x, y, x + 1, y + 1}, numbers);
	dem_quiet_end();
	return status;
}

enum status resident_soil_rasters_levels(struct soil_rasters *rasters, int level, int64_t x, int64_t y, uint8_t *numbers)
{
	return read_post(rasters, 0, level, x, y, numbers);
}

enum status resident_soil_rasters_at(struct soil_rasters *rasters, int level, int64_t x, int64_t y, uint8_t *numbers)
{
	assert(rasters->params.places);
	return read_post(rasters, rasters->readers - 1, level, x, y, numbers);
}
