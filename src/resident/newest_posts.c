/*
 * Reads the newest posts of any rectangle at any level: those of the store, and over them those of the tiles that changed
 * since. A coarser post is a post of the working level. A finer one is interpolated, as the store does it.
 */
#include <math.h>

#include "resident/newest_internal.h"

struct patch {
	struct newest *newest;
	enum store_layer layer;
	int level;             /* asked for */
	struct post_rect rect; /* asked for: the shape of both */
	double *values;
	double *base;          /* NULL: the layer needs none */
	void *posts;           /* of one tile */
};

static const enum plane planes[STORE_LAYERS] = {
	[STORE_SURFACE] = PLANE_OFFSET, [STORE_OFFSET] = PLANE_OFFSET,   [STORE_UNITS] = PLANE_OFFSET, [STORE_SOIL] = PLANE_DISTURBANCE,
	[STORE_HEALED] = PLANE_HEALED, [STORE_RISEN] = PLANE_RISEN, [STORE_GROWN] = PLANE_GROWN,
	[STORE_DEPOSITED] = PLANE_DEPOSITED,  [STORE_PLASTIC_SINKAGE] = PLANE_PLASTIC_SINKAGE, [STORE_SHEAR] = PLANE_SHEAR,
	[STORE_SHEAR_EAST] = PLANE_SHEAR, [STORE_SHEAR_NORTH] = PLANE_SHEAR, [STORE_SETTLED] = PLANE_SETTLED, [STORE_LOOSE] = PLANE_LOOSE, [STORE_DENSITY] = PLANE_DENSITY,
};

/* Turns a plane's posts into those that the layer shows, in the same memory. It goes from the end, so that no value is overwritten
 * before it is read. */
static void widen(enum store_layer layer, size_t count, void *posts)
{
	int32_t *wide = posts;
	for (size_t i = count; plane_bytes(planes[layer]) == 1 && i-- > 0;)
		wide[i] = ((const uint8_t *)posts)[i];
	for (size_t i = 0; i < count && planes[layer] == PLANE_SHEAR; i++)
		wide[i] = plane_shear(wide[i], store_shear_part(layer));
}

/* Returns post (x, y) of the requested level, which the tile has. */
static int32_t post_at(const struct patch *patch, struct post_rect own, int64_t x, int64_t y)
{
	const uint32_t side = tile_posts(patch->newest->extent);
	const int finer = patch->newest->level - patch->level;
	const int32_t *posts = patch->posts;
	if (finer < 0)
		return posts[(size_t)((y << -finer) - own.y0) * side + (size_t)((x << -finer) - own.x0)];
	return lattice_finer(posts, side, finer, (uint64_t)(x - (own.x0 << finer)), (uint64_t)(y - (own.y0 << finer)));
}

static double value_of(enum store_layer layer, int32_t post)
{
	if (planes[layer] == PLANE_SHEAR)
		return ldexp(post, -PLANE_SHEAR_BITS);
	return layer == STORE_UNITS ? post : plane_value(planes[layer], post);
}

/* Returns the requested posts that lie on the tile, edges included. */
static struct post_rect part_of(const struct patch *patch, struct post_rect own)
{
	const int finer = patch->newest->level - patch->level, coarser = -finer;
	if (finer >= 0)
		own = (struct post_rect){own.x0 << finer, own.y0 << finer, ((own.x1 - 1) << finer) + 1, ((own.y1 - 1) << finer) + 1};
	else
		own = (struct post_rect){lattice_align(own.x0, coarser) >> coarser, lattice_align(own.y0, coarser) >> coarser,
					 ((own.x1 - 1) >> coarser) + 1, ((own.y1 - 1) >> coarser) + 1};
	return post_rect_intersect(own, patch->rect);
}

/* A surface is the base plus the newest offset. The base was read with the old offset, so it is read again alone. */
static enum status need_base(struct patch *patch)
{
	const struct post_rect *rect = &patch->rect;
	if (patch->layer != STORE_SURFACE || patch->base != NULL)
		return STATUS_OK;
	TRY(mem_make(&patch->base, (size_t)(rect->x1 - rect->x0) * (size_t)(rect->y1 - rect->y0), sizeof *patch->base, "posts"));
	return store_read_posts(resident_ground_reader(patch->newest->base), STORE_BASE, patch->level, *rect, patch->base);
}

static enum status take_changed(struct patch *patch, struct tile tile)
{
	struct newest *newest = patch->newest;
	const struct post_rect own = tile_post_rect(newest->extent, tile), part = part_of(patch, own);
	const int64_t width = patch->rect.x1 - patch->rect.x0;
	const size_t side = tile_posts(newest->extent);
	if (post_rect_empty(part))
		return STATUS_OK;
	TRY(need_base(patch));
	TRY(resident_newest_plane(newest, tile, planes[patch->layer], patch->posts));
	widen(patch->layer, side * side, patch->posts);
	for (int64_t y = part.y0; y < part.y1; y++)
		for (int64_t x = part.x0; x < part.x1; x++) {
			const size_t at = (size_t)((y - patch->rect.y0) * width + x - patch->rect.x0);
			if (isnan(patch->values[at]))
				continue;
			patch->values[at] = value_of(patch->layer, post_at(patch, own, x, y));
			if (patch->base != NULL)
				patch->values[at] += patch->base[at];
		}
	return STATUS_OK;
}

enum status resident_read_posts(struct newest *newest, enum store_layer layer, int level, struct post_rect rect, double *values)
{
	const struct key_map *changed = &newest->changed.added;
	enum status status = resident_newest_settle(newest);
	if (status == STATUS_OK)
		status = store_read_posts(resident_ground_reader(newest->base), layer, level, rect, values);
	if (status != STATUS_OK || layer == STORE_BASE || changed->keys.count == 0 || post_rect_empty(rect))
		return status;
	if (level > newest->level && !(PLANE_BIT(planes[layer]) & GPU_DRAWN_PLANES))
		return fail_with(STATUS_INPUT, "level %d has no state of the soil; ask for level %d, which is deformed, or a finer one",
				 level, newest->level);
	const size_t side = tile_posts(newest->extent);
	struct patch patch = {.newest = newest, .layer = layer, .level = level, .rect = rect, .values = values};
	TRY(mem_make(&patch.posts, side * side, sizeof(int32_t), "a tile for queries"));
	for (size_t i = 0; i < changed->keys.count && status == STATUS_OK; i++) {
		const struct tile tile = tile_from_key(changed->pairs[i].key);
		if (tile.level == newest->level)
			status = take_changed(&patch, tile);
	}
	mem_free_all(patch.base, patch.posts);
	return status;
}
