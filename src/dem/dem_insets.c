/*
 * Opens insets, one after the other in the order in which they are laid over each other, and computes their heights.
 *
 *   open -> level, place on the terrain's lattice -> what surrounds it -> feather -> distances -> covered cells -> offset
 */
#include "dem_inset.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FEATHER_POSTS 10  /* of what surrounds an inset */
#define SAME 1e-6         /* of a spacing */
#define OFF_LATTICE 1e-2  /* of a spacing */
#define RIM_ROWS 256      /* about as many rows give the offset */

/* --- coordinates --- */

/* Returns the posts of a level `shift` coarser from which a rectangle is interpolated. */
static struct post_rect around(struct post_rect rect, int shift)
{
	const int64_t up = ((int64_t)1 << shift) - 1;
	return (struct post_rect){rect.x0 >> shift, rect.y0 >> shift, ((rect.x1 - 1 + up) >> shift) + 1, ((rect.y1 - 1 + up) >> shift) + 1};
}

static int64_t width_of(struct post_rect rect)
{
	return rect.x1 - rect.x0;
}

static size_t posts_of(struct post_rect rect)
{
	return (size_t)width_of(rect) * (size_t)(rect.y1 - rect.y0);
}

static bool is_covered(const struct inset *inset, int64_t x, int64_t y)
{
	const struct post_rect *cells = &inset->cells;
	return x >= cells->x0 && y >= cells->y0 && x < cells->x1 && y < cells->y1 &&
	       inset->covered[(y - cells->y0) * width_of(*cells) + x - cells->x0] != 0;
}

bool dem_inset_covers(const struct inset *inset, int level, int64_t x, int64_t y)
{
	const int shift = inset->around - level;
	const int64_t part = ((int64_t)1 << shift) - 1, cx = x >> shift, cy = y >> shift;
	const bool west = (x & part) == 0, south = (y & part) == 0; /* on a cell's edge: also in the cell beside it */
	return is_covered(inset, cx, cy) || (west && is_covered(inset, cx - 1, cy)) || (south && is_covered(inset, cx, cy - 1)) ||
	       (west && south && is_covered(inset, cx - 1, cy - 1));
}

struct post_rect dem_inset_covered_rect(const struct inset *inset, int level)
{
	const int shift = inset->around - level;
	const struct post_rect *cells = &inset->cells;
	return (struct post_rect){cells->x0 << shift, cells->y0 << shift, (cells->x1 << shift) + 1, (cells->y1 << shift) + 1};
}

/* --- heights --- */

static bool same_rect(struct post_rect a, struct post_rect b)
{
	return a.x0 == b.x0 && a.y0 == b.y0 && a.x1 == b.x1 && a.y1 == b.y1;
}

/* Posts of the country, which stay in memory until others are read. */
static enum status country_posts(struct dem_insets *insets, struct post_rect rect)
{
	if (insets->posts != NULL && same_rect(rect, insets->held))
		return STATUS_OK;
	double *room = mem_realloc(insets->posts, posts_of(rect), sizeof *room);
	if (room == NULL)
		return fail_memory("an inset");
	insets->posts = room;
	insets->held = (struct post_rect){0, 0, 0, 0};
	enum status status = dem_read(insets->country, rect, room);
	if (status == STATUS_OK)
		insets->held = rect;
	return status;
}

/* Interpolates post (x, y) between posts `shift` levels coarser, of which `coarse` has those of `from`. */
static double between(const double *coarse, struct post_rect from, int shift, int64_t x, int64_t y)
{
	const int64_t part = ((int64_t)1 << shift) - 1, width = width_of(from);
	const double *post = coarse + ((y >> shift) - from.y0) * width + (x >> shift) - from.x0;
	const int64_t east = (x & part) != 0, north = (y & part) != 0 ? width : 0;
	const double corners[4] = {post[0], post[east], post[north], post[north + east]};
	return lattice_bilinear(corners, ldexp((double)(x & part), -shift), ldexp((double)(y & part), -shift), 0);
}

static enum status country_heights(struct dem_insets *insets, int level, struct post_rect rect, double *heights)
{
	const struct post_rect from = around(rect, -level);
	enum status status = country_posts(insets, from);
	for (int64_t y = rect.y0; y < rect.y1 && status == STATUS_OK; y++)
		for (int64_t x = rect.x0; x < rect.x1; x++)
			*heights++ = between(insets->posts, from, -level, x, y);
	return status;
}

/* Lays an inset over the heights of its own level. */
static enum status blend(const struct inset *inset, struct post_rect rect, double *heights)
{
	const struct post_rect part = post_rect_intersect(rect, inset->rect);
	if (post_rect_empty(part))
		return STATUS_OK;
	double *own = mem_alloc(posts_of(part), sizeof *own), *from = own;
	if (own == NULL)
		return fail_memory("an inset");
	enum status status = dem_read(inset->dem, (struct post_rect){part.x0 - inset->x, part.y0 - inset->y, part.x1 - inset->x,
								     part.y1 - inset->y}, own);
	for (int64_t y = part.y0; y < part.y1 && status == STATUS_OK; y++) {
		double *to = heights + (y - rect.y0) * width_of(rect) - rect.x0;
		for (int64_t x = part.x0; x < part.x1; x++, from++) {
			const double weight = dem_inset_rim_weight(&inset->rim, x - inset->rect.x0, y - inset->rect.y0), height = *from - inset->lowered;
			if (weight == 0 || isnan(height))
				continue;
			to[x] = weight == 1 || isnan(to[x]) ? height : to[x] + weight * (height - to[x]);
		}
	}
	mem_free(own);
	return status;
}

/* Replaces the heights at posts that a coarser inset covers by what is interpolated between its own. */
static enum status divide(struct dem_insets *insets, size_t depth, int level, struct post_rect rect, double *heights)
{
	const struct inset *inset = &insets->list[depth - 1];
	const int shift = inset->info.level - level;
	const struct post_rect part = post_rect_intersect(rect, dem_inset_covered_rect(inset, level)), from = around(part, shift);
	if (post_rect_empty(part))
		return STATUS_OK;
	double *coarse = mem_alloc(posts_of(from), sizeof *coarse);
	enum status status = coarse != NULL ? dem_inset_heights(insets, depth, inset->info.level, from, coarse) : fail_memory("an inset");
	for (int64_t y = part.y0; y < part.y1 && status == STATUS_OK; y++)
		for (int64_t x = part.x0; x < part.x1; x++)
			if (dem_inset_covers(inset, level, x, y))
				heights[(y - rect.y0) * width_of(rect) + x - rect.x0] = between(coarse, from, shift, x, y);
	mem_free(coarse);
	return status;
}

enum status dem_inset_heights(struct dem_insets *insets, size_t depth, int level, struct post_rect rect, double *heights)
{
	if (depth == 0)
		return country_heights(insets, level, rect, heights);
	enum status status = dem_inset_heights(insets, depth - 1, level, rect, heights);
	if (status != STATUS_OK)
		return status;
	const struct inset *inset = &insets->list[depth - 1];
	return inset->info.level == level ? blend(inset, rect, heights) : divide(insets, depth, level, rect, heights);
}

/* --- opening --- */

static enum status open_at(const struct dem_insets_params *params, const char *source, double spacing, bool fill, struct dem **out)
{
	const struct dem_info *country = dem_info(params->country);
	struct dem_params dem = *params->dem;
	dem.sources = &source;
	dem.source_count = 1;
	dem.s_srs = NULL;
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
	const double coarse = params->extent->spacing;
	enum status status = open_at(params, source, 0, false, &own);
	if (status != STATUS_OK)
		return status;
	const double spacing = dem_info(own)->spacing;
	const bool placed = (dem_info(own)->srs[0] != '\0') == (dem_info(params->country)->srs[0] != '\0');
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
				 "%g m, or give the terrain a finer --spacing", source, spacing, 1 << -TILE_LEVEL_MIN, coarse,
				 ldexp(coarse, TILE_LEVEL_MIN));
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
	if (width_of(inset->rect) < 3 || inset->rect.y1 - inset->rect.y0 < 3)
		return fail_with(STATUS_INPUT, "%s: it does not lie in the terrain; leave it out, or import what lies around it too",
				 inset->info.source);
	inset->info.width = width_of(inset->rect);
	inset->info.height = inset->rect.y1 - inset->rect.y0;
	inset->info.unit = own->unit;
	return STATUS_OK;
}

/* Returns true if the outer inset has all posts around the inner one. */
static bool surrounds(const struct inset *outer, const struct inset *inner)
{
	const struct post_rect rect = around(inner->rect, outer->info.level - inner->info.level);
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
	const struct post_rect corners = around(inset->rect, shift);
	inset->cells = (struct post_rect){corners.x0, corners.y0, corners.x1 - 1, corners.y1 - 1};
	inset->covered = mem_calloc(posts_of(inset->cells), 1);
	if (inset->covered == NULL)
		return fail_memory("an inset");
	for (int64_t ny = 0; ny < rim->nodes[1]; ny++)
		for (int64_t nx = 0; nx < rim->nodes[0]; nx++) {
			if (rim->far[ny * rim->nodes[0] + nx] == 0)
				continue;
			const int64_t x = inset->rect.x0 + nx * rim->block, y = inset->rect.y0 + ny * rim->block;
			for (int64_t cy = (y - rim->block) / side; cy * side < y + rim->block; cy++)
				for (int64_t cx = (x - rim->block) / side; cx * side < x + rim->block; cx++)
					inset->covered[(cy - inset->cells.y0) * width_of(inset->cells) + cx - inset->cells.x0] = 1;
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
	enum status status = read_rows(inset, row, 1, own);
	if (status == STATUS_OK)
		status = dem_inset_heights(insets, insets->count, inset->info.level, (struct post_rect){inset->rect.x0, y, inset->rect.x1, y + 1}, under);
	for (int64_t x = 0; x < inset->rim.width && status == STATUS_OK; x++) {
		const double far = dem_inset_rim_far(&inset->rim, x, row);
		if (far > 0 && far <= inset->info.feather && !isnan(own[x] - under[x]))
			apart[inset->info.rim_posts++] = own[x] - under[x];
	}
	return status;
}

/* Finds the median of how much higher it is than what surrounds it, over posts of its rim. */
static enum status find_offset(struct dem_insets *insets, struct inset *inset)
{
	const int64_t width = inset->rim.width, height = inset->rim.height;
	const int64_t step = height / RIM_ROWS > 0 ? height / RIM_ROWS : 1, rows = (height + step - 1) / step;
	double *apart = mem_alloc((size_t)(rows * width), sizeof *apart), *own = mem_alloc((size_t)(2 * width), sizeof *own);
	enum status status = apart != NULL && own != NULL ? STATUS_OK : fail_memory("an inset");
	for (int64_t row = 0; row < height && status == STATUS_OK; row += step)
		status = rim_row(insets, inset, row, own, own + width, apart);
	if (status == STATUS_OK && inset->info.rim_posts > 0) {
		qsort(apart, (size_t)inset->info.rim_posts, sizeof *apart, compare);
		inset->info.offset = apart[inset->info.rim_posts / 2];
	}
	mem_free(apart);
	mem_free(own);
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
	enum status status = open_at(params, inset->info.source, inset->info.spacing, false, &inset->dem);
	if (status == STATUS_OK)
		status = place(params, inset);
	if (status != STATUS_OK)
		return status;
	find_around(insets, inset);
	choose_feather(params, inset);
	inset->rim = (struct inset_rim){.width = inset->info.width, .height = inset->info.height, .spacing = inset->info.spacing,
					.feather = inset->info.feather};
	status = dem_inset_rim_init(&inset->rim, read_rows, inset);
	if (status == STATUS_OK)
		status = cover(inset);
	if (status == STATUS_OK)
		status = find_offset(insets, inset);
	if (status != STATUS_OK)
		return status;
	inset->info.matched = params->match && inset->info.rim_posts > 0;
	inset->lowered = inset->info.matched ? inset->info.offset : 0;
	if (inset->rim.deep == NULL)
		return STATUS_OK;
	dem_close(inset->dem);
	inset->dem = NULL;
	return open_at(params, inset->info.source, inset->info.spacing, true, &inset->dem);
}

static int compare_insets(const void *a, const void *b)
{
	const struct inset *p = a, *q = b;
	if (p->info.level != q->info.level)
		return p->info.level > q->info.level ? -1 : 1;
	return p->named > q->named ? -1 : 1;
}

enum status dem_insets_open(const struct dem_insets_params *params, struct dem_insets **out)
{
	struct dem_insets *insets = mem_calloc(1, sizeof *insets);
	if (insets == NULL)
		return fail_memory("insets");
	insets->country = params->country;
	insets->extent = *params->extent;
	insets->list = mem_calloc(params->count, sizeof *insets->list);
	enum status status = insets->list != NULL ? STATUS_OK : fail_memory("insets");
	for (size_t i = 0; i < params->count && status == STATUS_OK; i++) {
		insets->list[i].named = i;
		insets->list[i].info.source = params->sources[i];
		status = choose_level(params, &insets->list[i]);
	}
	if (status == STATUS_OK && params->count > 1)
		qsort(insets->list, params->count, sizeof *insets->list, compare_insets);
	for (size_t i = 0; i < params->count && status == STATUS_OK; i++) {
		status = prepare(insets, params, &insets->list[i]);
		insets->count += status == STATUS_OK;
		if (status != STATUS_OK)
			inset_finish(&insets->list[i]);
	}
	if (status != STATUS_OK) {
		dem_insets_close(insets);
		return status;
	}
	*out = insets;
	return STATUS_OK;
}

void dem_insets_close(struct dem_insets *insets)
{
	if (insets == NULL)
		return;
	for (size_t i = 0; i < insets->count; i++)
		inset_finish(&insets->list[i]);
	mem_free(insets->list);
	mem_free(insets->posts);
	mem_free(insets);
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
