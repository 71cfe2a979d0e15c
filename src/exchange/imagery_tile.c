/* One map tile of imagery: a WebP picture, transparent where the imagery has nothing. */
#include "exchange/internal.h"

#include <string.h>

#define BESIDE 1e-6 /* of a pixel: a position no further outside is on the edge */

static enum status reserve(struct exchange_maker *maker, size_t posts)
{
	if (maker->imagery == NULL)
		TRY(mem_make(&maker->imagery, maker->side * maker->side, 4, "a tile"));
	if (posts <= maker->posts_room)
		return STATUS_OK;
	mem_free(maker->posts);
	maker->posts_room = 0;
	TRY(mem_make(&maker->posts, posts, 4, "a tile"));
	maker->posts_room = posts;
	return STATUS_OK;
}

/* Bilinear between four pixels; colours count by their opacity. */
static void blend(const uint8_t *const corners[4], double u, double v, uint8_t *out)
{
	const double weights[4] = {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
	double sums[4] = {0};
	for (int i = 0; i < 4; i++) {
		const double opaque = weights[i] * corners[i][3];
		for (int c = 0; c < 3; c++)
			sums[c] += opaque * corners[i][c];
		sums[3] += opaque;
	}
	out[3] = (uint8_t)(sums[3] + 0.5);
	for (int c = 0; c < 3; c++)
		out[c] = out[3] == 0 ? 0 : (uint8_t)(sums[c] / sums[3] + 0.5);
}

/* Returns true if a pixel has imagery. */
static bool sample(struct exchange_maker *maker)
{
	const struct exchange_sampler *sampler = &maker->sampler;
	const struct post_rect rect = sampler->rect;
	const int64_t width = rect.x1 - rect.x0, height = rect.y1 - rect.y0;
	bool any = false;
	for (size_t k = 0; k < maker->side * maker->side; k++) {
		const double x = sampler->x[k] - (double)rect.x0, y = sampler->y[k] - (double)rect.y0;
		uint8_t *out = maker->imagery + 4 * k;
		memset(out, 0, 4);
		if (!(x >= -BESIDE && y >= -BESIDE && x <= (double)(width - 1) + BESIDE && y <= (double)(height - 1) + BESIDE))
			continue;
		const int64_t px = x > 0 ? (int64_t)x : 0, py = y > 0 ? (int64_t)y : 0;
		const int64_t right = px + 1 < width, up = py + 1 < height ? width : 0;
		const uint8_t *p = maker->posts + 4 * (py * width + px);
		blend((const uint8_t *const[4]){p, p + 4 * right, p + 4 * up, p + 4 * (up + right)}, x > 0 ? x - (double)px : 0, y > 0 ? y - (double)py : 0, out);
		any = any || out[3] != 0;
	}
	return any;
}

static enum status pack(struct exchange_maker *maker, int quality)
{
	void *packed;
	size_t size = 0;
	TRY(store_imagery_pack(maker->imagery, (uint32_t)maker->side, quality, &packed, &size));
	const enum status status = exchange_bytes_add(&maker->bytes, packed, size);
	mem_free(packed);
	return status;
}

enum status exchange_imagery_tile(struct exchange_maker *maker, const struct exchange_zoom *zoom, struct tile tile)
{
	const int64_t side = (int64_t)maker->side;
	const struct post_rect *rect = &maker->sampler.rect;
	int quality = 0;
	maker->bytes.size = 0;
	if (!store_has_imagery(maker->params->store, NULL, &quality))
		return STATUS_OK; /* one of another day goes when the folder is tidied */
	TRY(exchange_sampler_place(&maker->sampler, zoom, (int64_t)tile.x * side, (int64_t)tile.y * side, side, side));
	if (!post_rect_empty(*rect)) {
		TRY(reserve(maker, (size_t)(rect->x1 - rect->x0) * (size_t)(rect->y1 - rect->y0)));
		TRY(store_imagery_read_rect(maker->sampler.reader, zoom->level, *rect, maker->posts));
		if (sample(maker))
			TRY(pack(maker, quality));
	}
	return exchange_maker_put(maker, EXCHANGE_IMAGERY, tile);
}
