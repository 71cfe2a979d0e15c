/*
 * Opens insets, one after the other in the order in which they are laid over each other, and computes their heights.
 *
 *   open -> level, place on the terrain's lattice -> what surrounds it -> feather -> distances -> covered cells -> offset
 */
#include "dem_inset.h"
#include "dem_internal.h"

#include <math.h>
#include <stdlib.h>

#define FEATHER_POSTS 10  /* of what surrounds an inset */
#define SAME 1e-6         /* of a spacing */
#define OFF_LATTICE 1e-2  /* of a spacing */
#define RIM_ROWS 256      /* about as many rows give the offset */

/* --- opening --- */

static enum status open_at(const struct dem_insets_params *params, const struct inset *inset, double spacing, bool fill, struct dem **out)
{
	const struct dem_info *country = dem_info(params->country);
	struct dem_params dem = *params->dem;
	dem.sources = inset->from->paths;
	dem.source_count = inset->from->count;
	dem.apart = false;
	dem.has_window = false;
	dem.window_srs = NULL;
	dem.has_height_range = false;
	dem.t_srs = country->srs[0] != '\0' ? country->srs : NULL;
	dem.spacing = spacing;
	dem.anchor = country->origin;
	dem.fill = fill;
	return dem_open(&dem, out);
}

/* Chooses the level: the coarsest whose spacing is at most the source's. */
static enum status choose_level(const struct dem_insets_params *params, struct inset *inset)
{
	struct dem *own;
	const char *source = inset->info.source;
	const struct dem_info *country = dem_info(params->country);
	const double coarse = params->extent->spacing;
	TRY(open_at(params, inset, 0, false, &own));
	const double spacing = dem_info(own)->spacing;
	const bool placed = (dem_info(own)->srs[0] != '\0') == (country->srs[0] != '\0');
	(void)dem_vertical_note(source, dem_info(own)->vertical, country->sources[0], country->vertical);
	dem_close(own);
	inset->info.level = 0;
	while (ldexp(coarse, inset->info.level) > spacing * (1 + SAME))
		inset->info.level--;
	if (!placed)
		return fail_with(STATUS_INPUT, "%s: it has a reference system and the terrain has none; give the terrain's source one with "
				 "gdal_translate -a_srs", source);
	if (inset->info.level == 0)
		return fail_with(STATUS_INPUT, "%s: its posts are %g m apart, no finer than the terrain's %g m; name it as a source "
				 "instead of an inset", source, spacing, coarse);
	if (inset->info.level < TILE_LEVEL_MIN)
		return fail_with(STATUS_INPUT, "%s: its posts of %g m are more than %d times as fine as the terrain's %g m; resample it to "
				 "%s m, or give the terrain a finer --spacing", source, spacing, 1 << -TILE_LEVEL_MIN, coarse,
				 number_exact(ldexp(coarse, TILE_LEVEL_MIN)).text);
	inset->info.spacing = ldexp(coarse, inset->info.level);
	return STATUS_OK;
}

/* Finds which posts of the terrain it has. */
static enum status place(const struct dem_insets_params *params, struct inset *inset)
{
	const struct dem_info *country = dem_info(params->country), *own = dem_info(inset->dem);
	const struct extent *extent = params->extent;
	const double spacing = inset->info.spacing;
	const double first[2] = {(own->origin[0] - country->origin[0]) / spacing, (own->origin[1] - country->origin[1]) / spacing};
	if (fabs(own->spacing / spacing - 1) > SAME || fabs(first[0] - round(first[0])) > OFF_LATTICE ||
	    fabs(first[1] - round(first[1])) > OFF_LATTICE)
		return fail_with(STATUS_INPUT, "%s: it cannot be laid on the terrain's posts; give it a place with gdal_translate", inset->info.source);
	inset->x = llround(first[0]);
	inset->y = llround(first[1]);
	inset->rect = post_rect_intersect((struct post_rect){inset->x, inset->y, inset->x + own->width, inset->y + own->height},
					  (struct post_rect){0, 0, extent_posts(extent->width, inset->info.level),
							     extent_posts(extent->height, inset->info.level)});
	inset->missing = dem_inset_width(inset->rect) < 3 || inset->rect.y1 - inset->rect.y0 < 3;
	if (inset->missing && inset->from->found) {
		note("%s: left out, since it does not lie in the terrain", inset->info.source);
		return STATUS_OK;
	}
	if (inset->missing)
		return fail_with(STATUS_INPUT, "%s: it does not lie in the terrain; leave it out, or import what lies around it too",
				 inset->info.source);
	inset->info.x = inset->rect.x0;
	inset->info.y = inset->rect.y0;
	inset->info.width = dem_inset_width(inset->rect);
	inset->info.height = inset->rect.y1 - inset->rect.y0;
	inset->info.unit = own->unit;
	return STATUS_OK;
}

/* Returns true if the outer inset has all posts around the inner one. */
static bool surrounds(const struct inset *outer, const struct inset *inner)
{
	const struct post_rect rect = dem_inset_around(inner->rect, outer->info.level - inner->info.level);
	for (int64_t y = rect.y0; y < rect.y1; y++)
		for (int64_t x = rect.x0; x < rect.x1; x++)
			if (!dem_inset_covers(outer, outer->info.level, x, y))
				return false;
	return true;
}

static void find_around(const struct dem_insets *insets, struct inset *inset)
{
	inset->around = 0;
	for (size_t i = insets->count; i-- > 0 && inset->around == 0;)
		if (insets->list[i].info.level > inset->info.level && surrounds(&insets->list[i], inset))
			inset->around = insets->list[i].info.level;
}

static void choose_feather(const struct dem_insets_params *params, struct inset *inset)
{
	const int64_t shorter = inset->info.width < inset->info.height ? inset->info.width : inset->info.height;
	const double most = (double)(shorter - 1) * inset->info.spacing / 4;
	const double wanted = params->feather >= 0 ? params->feather : FEATHER_POSTS * extent_spacing(params->extent, inset->around);
	inset->info.feather = fmin(wanted, most);
	if (params->feather > most)
		note("%s: a feather of %g m is more than a quarter of its shorter side: made %g m wide", inset->info.source, params->feather, most);
}

static enum status read_rows(void *user, int64_t y, int64_t rows, double *heights)
{
	const struct inset *inset = user;
	const int64_t x0 = inset->rect.x0 - inset->x, y0 = inset->rect.y0 - inset->y + y;
	return dem_read(inset->dem, (struct post_rect){x0, y0, x0 + inset->rim.width, y0 + rows}, heights);
}

/* Covers each cell that may have a post with weight: those of the blocks beside a node within the outline. */
static enum status cover(struct inset *inset)
{
	const struct inset_rim *rim = &inset->rim;
	const int shift = inset->around - inset->info.level;
	const int64_t side = (int64_t)1 << shift;
	const struct post_rect corners = dem_inset_around(inset->rect, shift);
	inset->cells = (struct post_rect){corners.x0, corners.y0, corners.x1 - 1, corners.y1 - 1};
	TRY(mem_zeroed(&inset->covered, dem_inset_posts(inset->cells), 1, "an inset"));
	for (int64_t ny = 0; ny < rim->nodes[1]; ny++)
		for (int64_t nx = 0; nx < rim->nodes[0]; nx++) {
			if (rim->far[ny * rim->nodes[0] + nx] == 0)
				continue;
			const int64_t x = inset->rect.x0 + nx * rim->block, y = inset->rect.y0 + ny * rim->block;
			for (int64_t cy = (y - rim->block) / side; cy * side < y + rim->block; cy++)
				for (int64_t cx = (x - rim->block) / side; cx * side < x + rim->block; cx++)
					inset->covered[(cy - inset->cells.y0) * dem_inset_width(inset->cells) + cx - inset->cells.x0] = 1;
		}
	return STATUS_OK;
}

/* --- the offset of its heights --- */

static int compare(const void *a, const void *b)
{
	const double p = *(const double *)a, q = *(const double *)b;
	return (p > q) - (p < q);
}

static enum status rim_row(struct dem_insets *insets, struct inset *inset, int64_t row, double *own, double *under, double *apart)
{
	const int64_t y = inset->rect.y0 + row;
	TRY(read_rows(inset, row, 1, own));
	TRY(dem_inset_heights(insets, insets->count, inset->info.level, (struct post_rect){inset->rect.x0, y, inset->rect.x1, y + 1}, under));
	for (int64_t x = 0; x < inset->rim.width; x++) {
		const double far = dem_inset_rim_far(&inset->rim, x, row);
		if (far > 0 && far <= inset->info.feather && !isnan(own[x] - under[x]))
			apart[inset->info.rim_posts++] = own[x] - under[x];
	}
	return STATUS_OK;
}

/* Finds the median of how much higher it is than what surrounds it, over posts of its rim. */
static enum status find_offset(struct dem_insets *insets, struct inset *inset)
{
	const int64_t width = inset->rim.width, height = inset->rim.height;
	const int64_t step = height / RIM_ROWS > 0 ? height / RIM_ROWS : 1, rows = (height + step - 1) / step;
	double *apart = mem_alloc((size_t)(rows * width), sizeof *apart), *own = mem_alloc((size_t)(2 * width), sizeof *own);
	enum status status;
	TRY_OR(done, apart != NULL && own != NULL ? STATUS_OK : fail_memory("an inset"));
	for (int64_t row = 0; row < height; row += step)
		TRY_OR(done, rim_row(insets, inset, row, own, own + width, apart));
	if (inset->info.rim_posts > 0) {
		qsort(apart, (size_t)inset->info.rim_posts, sizeof *apart, compare);
		inset->info.offset = apart[inset->info.rim_posts / 2];
	}
done:
	mem_free_all(apart, own);
	return status;
}

/* --- life --- */

static void inset_finish(struct inset *inset)
{
	dem_close(inset->dem);
	dem_inset_rim_finish(&inset->rim);
	mem_free(inset->covered);
}

/* Prepares an inset. Those before it in the list are complete; they count for what surrounds it. */
static enum status prepare(struct dem_insets *insets, const struct dem_insets_params *params, struct inset *inset)
{
	TRY(open_at(params, inset, inset->info.spacing, false, &inset->dem));
	TRY(place(params, inset));
	if (inset->missing)
		return STATUS_OK;
	find_around(insets, inset);
	choose_feather(params, inset);
	inset->rim = (struct inset_rim){.width = inset->info.width, .height = inset->info.height, .spacing = inset->info.spacing,
					.feather = inset->info.feather};
	TRY(dem_inset_rim_init(&inset->rim, read_rows, inset));
	TRY(cover(inset));
	TRY(find_offset(insets, inset));
	inset->info.matched = params->match && inset->info.rim_posts > 0;
	inset->lowered = inset->info.matched ? inset->info.offset : 0;
	if (inset->rim.deep == NULL)
		return STATUS_OK;
	dem_close(inset->dem);
	inset->dem = NULL;
	return open_at(params, inset, inset->info.spacing, true, &inset->dem);
}

static int compare_insets(const void *a, const void *b)
{
	const struct inset *p = a, *q = b;
	if (p->info.level != q->info.level)
		return p->info.level > q->info.level ? -1 : 1;
	return p->named > q->named ? -1 : 1;
}

/* Gives the insets that are left the numbers 0, 1, 2 ... in the order in which the caller named them. */
static void number(struct dem_insets *insets)
{
	for (size_t next = 0; next < insets->count; next++) {
		size_t least = SIZE_MAX;
		for (size_t i = 0; i < insets->count; i++)
			if (insets->list[i].named >= next && (least == SIZE_MAX || insets->list[i].named < insets->list[least].named))
				least = i;
		insets->list[least].named = next;
	}
}

enum status dem_insets_open(const struct dem_insets_params *params, struct dem_insets **out)
{
	struct dem_insets *insets = mem_calloc(1, sizeof *insets);
	TRY_MEM(insets, "insets");
	insets->country = params->country;
	insets->extent = *params->extent;
	insets->list = mem_calloc(params->count, sizeof *insets->list);
	enum status status;
	TRY_OR(failed, insets->list != NULL ? STATUS_OK : fail_memory("insets"));
	for (size_t i = 0; i < params->count; i++) {
		struct inset *inset = &insets->list[i];
		inset->named = i;
		inset->from = &params->sources[i];
		inset->info.source = params->sources[i].paths[0];
		inset->info.paths = params->sources[i].count;
		inset->info.found = params->sources[i].found;
		TRY_OR(failed, choose_level(params, inset));
	}
	if (params->count > 1)
		qsort(insets->list, params->count, sizeof *insets->list, compare_insets);
	for (size_t i = 0; i < params->count; i++) {
		struct inset *inset = &insets->list[insets->count];
		if (insets->count != i)
			*inset = insets->list[i];
		status = prepare(insets, params, inset);
		if (status != STATUS_OK || inset->missing)
			inset_finish(inset);
		else
			insets->count++;
		TRY_OR(failed, status);
	}
	number(insets);
	*out = insets;
	return STATUS_OK;
failed:
	dem_insets_close(insets);
	return status;
}

void dem_insets_close(struct dem_insets *insets)
{
	if (insets == NULL)
		return;
	for (size_t i = 0; i < insets->count; i++)
		inset_finish(&insets->list[i]);
	mem_free_all(insets->list, insets->posts, insets);
}

size_t dem_insets_count(const struct dem_insets *insets)
{
	return insets->count;
}

static const struct inset *named(const struct dem_insets *insets, size_t index)
{
	const struct inset *inset = insets->list;
	while (inset->named != index)
		inset++;
	return inset;
}

const struct dem_inset_info *dem_insets_info(const struct dem_insets *insets, size_t index)
{
	return &named(insets, index)->info;
}

const struct dem_info *dem_insets_files(const struct dem_insets *insets, size_t index)
{
	return dem_info(named(insets, index)->dem);
}
