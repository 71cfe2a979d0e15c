/*
 * Measures by how much tiles of insets are off: at the inset's posts, and at its sources' own. Only posts count at which an inset is
 * meant to be stored as it is: not where it is blended, and not under another inset.
 */
#include "dem_inset.h"

#include <math.h>

/* Part of a tile that an inset has. */
struct piece {
	const struct dem_insets *insets;
	size_t number; /* of the inset in the list */
	struct post_rect rect; /* posts of the level; one more than is measured to the east and north, if the tile has it */
	double *own, *surface; /* heights of rect: the inset's, and the stored ones, NaN: do not count */
};

static bool is_bare(const struct piece *piece, int64_t x, int64_t y)
{
	const struct inset *inset = &piece->insets->list[piece->number];
	if (dem_inset_rim_weight(&inset->rim, x - inset->rect.x0, y - inset->rect.y0) != 1)
		return false;
	for (size_t i = piece->number + 1; i < piece->insets->count; i++) { /* those that lie over it */
		const struct inset *over = &piece->insets->list[i];
		const int shift = inset->info.level - over->info.level;
		const struct post_rect rect = dem_inset_covered_rect(over, over->info.level);
		if (x << shift >= rect.x0 && x << shift < rect.x1 && y << shift >= rect.y0 && y << shift < rect.y1)
			return false;
	}
	return true;
}

/* `tile`: the posts of the tile, whose codes these are. */
static void compare(struct piece *piece, struct post_rect tile, const int32_t *codes, double step, struct misfit *resampled)
{
	const double lowered = piece->insets->list[piece->number].lowered;
	const struct post_rect *rect = &piece->rect;
	size_t at = 0;
	for (int64_t y = rect->y0; y < rect->y1; y++)
		for (int64_t x = rect->x0; x < rect->x1; x++, at++) {
			const int32_t code = codes[(y - tile.y0) * (tile.x1 - tile.x0) + x - tile.x0];
			const bool counts = code != HEIGHT_CODE_NODATA && !isnan(piece->own[at]) && is_bare(piece, x, y);
			piece->surface[at] = counts ? height_code_metres(code, step) + lowered : (double)NAN;
			if (counts && x < tile.x1 - 1 && y < tile.y1 - 1)
				misfit_add_post(resampled, piece->surface[at] - piece->own[at]);
		}
}

static enum status measure(struct piece *piece, struct post_rect tile, const int32_t *codes, double step, struct misfit *resampled,
			   struct misfit *source)
{
	const struct inset *inset = &piece->insets->list[piece->number];
	const struct post_rect own = {piece->rect.x0 - inset->x, piece->rect.y0 - inset->y, piece->rect.x1 - inset->x, piece->rect.y1 - inset->y};
	struct misfit posts = {0};
	TRY(dem_read(inset->dem, own, piece->own));
	compare(piece, tile, codes, step, &posts);
	misfit_add(resampled, &posts);
	if (!dem_info(inset->dem)->resampled)
		misfit_add(source, &posts);
	else if (posts.posts > 0)
		return dem_misfit_heights(inset->dem, own, piece->surface, (int64_t[]){tile.x1 - 1 - inset->x, tile.y1 - 1 - inset->y}, source);
	return STATUS_OK;
}

enum status dem_inset_misfit(const struct dem_insets *insets, struct tile tile, const int32_t *codes, double step, struct misfit *resampled,
			     struct misfit *source)
{
	const struct post_rect rect = tile_post_rect(&insets->extent, tile);
	for (size_t i = 0; i < insets->count; i++) {
		struct piece piece = {.insets = insets, .number = i, .rect = post_rect_intersect(rect, insets->list[i].rect)};
		if (insets->list[i].info.level != tile.level || post_rect_empty(piece.rect))
			continue;
		const size_t posts = (size_t)((piece.rect.x1 - piece.rect.x0) * (piece.rect.y1 - piece.rect.y0));
		piece.own = mem_alloc(posts, sizeof *piece.own);
		piece.surface = mem_alloc(posts, sizeof *piece.surface);
		const enum status status = piece.own != NULL && piece.surface != NULL ? measure(&piece, rect, codes, step, resampled, source)
										      : fail_memory("comparing with an inset");
		mem_free_all(piece.own, piece.surface);
		TRY(status);
	}
	return STATUS_OK;
}
