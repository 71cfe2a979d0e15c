/*
 * One map tile: heights as terrain-RGB, hillshade, and ruts in colour.
 *
 * Ruts are sampled at the finest zoom level. A coarser tile shows, of the four pixels below each of its own, the one with the largest
 * offset. So a rut that is narrower than a pixel is seen at every zoom level. Finer zoom levels have to be complete before coarser ones.
 */
#include "exchange/internal.h"

#include <string.h>

#define SAMPLES(side) ((side) + 2) /* samples along a tile, with those around it, of which slopes are taken */

enum status exchange_maker_init(struct exchange_maker *maker, const struct exchange_tiles_params *params, const struct exchange_zooms *zooms,
				struct exchange_steps *steps, const double range[2])
{
	*maker = (struct exchange_maker){.params = params, .zooms = zooms, .steps = steps, .range = {range[0], range[1]}};
	maker->side = params->pixels > 0 ? (size_t)params->pixels : 256;
	maker->coding = exchange_coding_of(params, store_meta(params->store));
	const size_t samples = SAMPLES(maker->side) * SAMPLES(maker->side), pixels = maker->side * maker->side;
	maker->heights = mem_alloc(samples, sizeof *maker->heights);
	maker->slopes = mem_alloc(2 * samples, sizeof *maker->slopes);
	maker->pixels = mem_alloc(pixels, 3);
	maker->indices = mem_alloc(pixels, 1);
	maker->mesh = mem_alloc(1, sizeof(struct exchange_quantized));
	for (int i = 1; i < 256; i++)
		maker->greys[i] = (struct chart_colour){(uint8_t)i, (uint8_t)i, (uint8_t)i, 255};
	exchange_rut_palette(maker->colours);
	enum status status;
	if (maker->heights == NULL || maker->slopes == NULL || maker->pixels == NULL || maker->indices == NULL || maker->mesh == NULL)
		TRY_OR(failed, fail_memory("a tile"));
	TRY_OR(failed, exchange_sampler_init(&maker->sampler, params));
	return STATUS_OK;
failed:
	exchange_maker_finish(maker);
	return status;
}

void exchange_maker_finish(struct exchange_maker *maker)
{
	exchange_sampler_finish(&maker->sampler);
	mem_free_all(maker->heights, maker->slopes, maker->pixels, maker->indices, maker->mesh, maker->imagery, maker->posts);
	exchange_bytes_finish(&maker->bytes);
	exchange_bytes_finish(&maker->packed);
	maker->heights = maker->slopes = NULL;
	maker->pixels = maker->indices = maker->imagery = maker->posts = NULL;
	maker->mesh = NULL;
}

enum status exchange_maker_put(struct exchange_maker *maker, enum exchange_set set, struct tile tile)
{
	char path[EXCHANGE_PATH];
	bool done;
	if (maker->file != NULL) {
		if (maker->bytes.size == 0)
			return STATUS_OK;
		maker->made[set]++;
		maker->written[set]++;
		return exchange_mbtiles_put(maker->file, tile, &maker->bytes);
	}
	TRY(exchange_tile_path(maker->params->directory, set, tile, path));
	if (maker->bytes.size == 0) {
		TRY(exchange_file_remove(path, &done));
		maker->removed += done;
		return STATUS_OK;
	}
	const bool packs = maker->params->gzip && set == EXCHANGE_MESH;
	if (packs)
		TRY(exchange_gzip(&maker->bytes, &maker->packed));
	maker->made[set]++;
	TRY(exchange_file_put(path, packs ? &maker->packed : &maker->bytes, &done));
	maker->written[set] += done;
	return STATUS_OK;
}

/* --- heights --- */

/* Height = zero + (65536 R + 256 G + B) / parts, as Mapbox's terrain-RGB (-10000, 10), Terrarium's (-32768, 256), or with steps that were asked for.
 * Nodata is the terrain's lowest height: the formats have none. */
static enum status put_terrain(struct exchange_maker *maker, struct tile tile)
{
	const double lowest = maker->sampler.frame.meta->low, zero = maker->coding.zero, parts = maker->coding.parts;
	const size_t side = maker->side;
	uint8_t *to = maker->pixels;
	for (size_t y = 1; y <= side; y++)
		for (size_t x = 1; x <= side; x++, to += 3) {
			double height = maker->heights[y * SAMPLES(side) + x];
			height = ((isnan(height) ? lowest : height) - zero) * parts;
			const uint32_t units = (uint32_t)(fmin(fmax(height, 0), EXCHANGE_CODE_MOST) + 0.5);
			to[0] = (uint8_t)(units >> 16);
			to[1] = (uint8_t)(units >> 8);
			to[2] = (uint8_t)units;
		}
	maker->bytes.size = 0;
	TRY(exchange_png_encode((int)side, maker->pixels, NULL, &maker->bytes));
	return exchange_maker_put(maker, EXCHANGE_TERRAIN, tile);
}

static enum status put_hillshade(struct exchange_maker *maker, const struct exchange_zoom *zoom, struct tile tile)
{
	const size_t side = maker->side;
	double *east = maker->slopes, *north = maker->slopes + side * side;
	chart_slopes(maker->heights, (int64_t)side, (int64_t)side, 1, east, north);
	for (size_t y = 0; y < side; y++) {
		double step_east, step_north;
		exchange_place_steps(&maker->sampler.frame, zoom, (double)tile.y * (double)side + (double)y, &step_east, &step_north);
		for (size_t x = 0; x < side; x++) {
			size_t at = y * side + x;
			/* Rows of pixels go south. */
			double light = chart_shade(&maker->params->sun, maker->params->exaggerate * east[at] / step_east,
						    -maker->params->exaggerate * north[at] / step_north);
			maker->indices[at] = isnan(light) ? 0 : (uint8_t)(1 + 254 * light);
		}
	}
	maker->bytes.size = 0;
	TRY(exchange_png_encode((int)side, maker->indices, maker->greys, &maker->bytes));
	return exchange_maker_put(maker, EXCHANGE_HILLSHADE, tile);
}

/* --- ruts --- */

uint8_t exchange_rut_index(const double range[2], double offset)
{
	double share = offset < 0 ? offset / -range[0] : offset / range[1];
	if (isnan(offset) || offset == 0)
		return 0;
	/* The least one has a colour, too. */
	int place = (int)fmax(ceil(127 * fmin(fabs(share), 1)), 1);
	return (uint8_t)(128 + (offset < 0 ? -place : place));
}

void exchange_rut_palette(struct chart_colour palette[256])
{
	palette[0] = (struct chart_colour){0, 0, 0, 0};
	for (int i = 1; i < 256; i++)
		palette[i] = i == 128 ? palette[0] : chart_ramp(CHART_RAMP_SIGNED, (i - 128) / 127.0);
}

static int strength(uint8_t index)
{
	return index == 0 ? 0 : index < 128 ? 128 - index : index - 128;
}

/* Takes a tile of the finer zoom level into one quarter of this one. */
static void shrink(size_t side, const uint8_t *fine, uint8_t *quarter)
{
	for (size_t y = 0; y < side / 2; y++)
		for (size_t x = 0; x < side / 2; x++) {
			const uint8_t *p = fine + 2 * y * side + 2 * x;
			const uint8_t four[] = {p[0], p[1], p[side], p[side + 1]};
			uint8_t largest = four[0];
			for (int i = 1; i < 4; i++)
				largest = strength(four[i]) > strength(largest) ? four[i] : largest;
			quarter[y * side + x] = largest;
		}
}

static enum status gather_ruts(struct exchange_maker *maker, struct tile tile)
{
	const size_t side = maker->side;
	uint8_t *fine = maker->pixels;
	memset(maker->indices, 0, side * side);
	for (uint32_t i = 0; i < 4; i++) {
		struct tile child = {tile.level + 1, 2 * tile.x + i % 2, 2 * tile.y + i / 2};
		char path[EXCHANGE_PATH];
		bool found;
		TRY(exchange_tile_path(maker->params->directory, EXCHANGE_RUTS, child, path));
		TRY(maker->file != NULL ? exchange_mbtiles_get(maker->file, child, &maker->bytes, &found)
					: exchange_file_get(path, (size_t)1 << 20, &maker->bytes, &found));
		if (!found)
			continue;
		TRY(exchange_png_decode(&maker->bytes, (int)side, path, fine));
		shrink(side, fine, maker->indices + (i / 2) * (side / 2) * side + (i % 2) * (side / 2));
	}
	return STATUS_OK;
}

static enum status sample_ruts(struct exchange_maker *maker)
{
	const size_t side = maker->side;
	TRY(exchange_sampler_read(&maker->sampler, STORE_OFFSET, maker->heights));
	for (size_t y = 0; y < side; y++)
		for (size_t x = 0; x < side; x++)
			maker->indices[y * side + x] = exchange_rut_index(maker->range, maker->heights[(y + 1) * SAMPLES(side) + x + 1]);
	return STATUS_OK;
}

static enum status put_ruts(struct exchange_maker *maker, const struct exchange_zoom *zoom, struct tile tile)
{
	bool sampled = zoom->z >= maker->zooms->ruts, any = false;
	maker->bytes.size = 0;
	if (!maker->zooms->deformed || (sampled && !key_set_has(&zoom->deformed, exchange_zoom_key(zoom, tile.x, tile.y))))
		return exchange_maker_put(maker, EXCHANGE_RUTS, tile);
	TRY(sampled ? sample_ruts(maker) : gather_ruts(maker, tile));
	maker->bytes.size = 0;
	for (size_t i = 0; i < maker->side * maker->side && !any; i++)
		any = maker->indices[i] != 0;
	if (any)
		TRY(exchange_png_encode((int)maker->side, maker->indices, maker->colours, &maker->bytes));
	return exchange_maker_put(maker, EXCHANGE_RUTS, tile);
}

static enum status put_ground(struct exchange_maker *maker, const struct exchange_zoom *zoom, struct tile tile)
{
	const size_t side = maker->side;
	const int64_t i0 = (int64_t)tile.x * (int64_t)side - 1, j0 = (int64_t)tile.y * (int64_t)side - 1;
	TRY(exchange_sampler_place(&maker->sampler, zoom, i0, j0, (int64_t)SAMPLES(side), (int64_t)SAMPLES(side)));
	TRY(exchange_sampler_read(&maker->sampler, STORE_SURFACE, maker->heights));
	bool any = false;
	for (size_t y = 1; y <= side && !any; y++)
		for (size_t x = 1; x <= side && !any; x++)
			any = !isnan(maker->heights[y * SAMPLES(side) + x]);
	maker->bytes.size = 0;
	if (any) {
		if (maker->file == NULL || maker->only == EXCHANGE_TERRAIN)
			TRY(put_terrain(maker, tile));
		if (maker->file == NULL || maker->only == EXCHANGE_HILLSHADE)
			TRY(put_hillshade(maker, zoom, tile));
		return maker->file == NULL || maker->only == EXCHANGE_RUTS ? put_ruts(maker, zoom, tile) : STATUS_OK;
	}
	for (int set = EXCHANGE_TERRAIN; set <= EXCHANGE_RUTS; set++)
		TRY(exchange_maker_put(maker, (enum exchange_set)set, tile));
	return STATUS_OK;
}

enum status exchange_map_tile(struct exchange_maker *maker, const struct exchange_zoom *zoom, struct tile tile)
{
	const bool ground = maker->file == NULL || maker->only != EXCHANGE_IMAGERY, colours = maker->file == NULL || maker->only == EXCHANGE_IMAGERY;
	if (ground && !zoom->imagery)
		TRY(put_ground(maker, zoom, tile));
	return colours ? exchange_imagery_tile(maker, zoom, tile) : STATUS_OK;
}
