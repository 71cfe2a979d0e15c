/*
 * A map raster: the part of a store that a map shows, with a pixel for each post of one level. It has the lightness of the ground
 * and the values of a layer.
 */
#include <math.h>
#include <string.h>

#include "chart/raster.h"

#define RUT 1e-3f /* m: ground that is lowered by so much is a rut */

/* --- values --- */

struct key_list {
	uint64_t *keys;
	size_t count, room;
};

static enum status add_key(struct key_list *list, uint64_t key)
{
	TRY(mem_grow(&list->keys, &list->room, list->count + 1, sizeof *list->keys, "a map's tiles"));
	list->keys[list->count++] = key;
	return STATUS_OK;
}

/* Finds, on one axis, the posts that pixels [first, end) are made of. The terrain's last pixel has all posts that are left. */
static void fine_posts(int shift, int64_t half, int64_t size, int64_t all, int64_t *first, int64_t *end)
{
	bool last = *end == size;
	*first = (*first << shift) - half;
	*end = last ? all : ((*end - 1) << shift) + (half > 0 ? half : 1);
}

/* Returns the posts of `level` that the pixels are made of. */
static struct post_rect fine_rect(const struct rasterizing *s, int level)
{
	int coarse = s->params->level, shift = coarse - level;
	int64_t half = shift > 0 ? (int64_t)1 << (shift - 1) : 0;
	const struct extent *w = s->extent;
	struct post_rect r = s->raster->rect;
	fine_posts(shift, half, extent_posts(w->width, coarse), extent_posts(w->width, level), &r.x0, &r.x1);
	fine_posts(shift, half, extent_posts(w->height, coarse), extent_posts(w->height, level), &r.y0, &r.y1);
	return r;
}

/* Adds the tile if it has an offset somewhere and posts in the map. */
static enum status look_at(struct rasterizing *s, struct tile tile, struct key_list *list)
{
	double low, high;
	bool found = false;
	struct post_rect rect = post_rect_intersect(tile_post_rect(s->extent, tile), fine_rect(s, tile.level));
	if (!extent_has(s->extent, tile) || post_rect_empty(rect))
		return STATUS_OK;
	TRY(store_read_offset_range(s->params->reader, tile, &low, &high, &found));
	return found ? add_key(list, tile_key(tile)) : STATUS_OK;
}

/* Only the working level has the soil's state. There may be soil state where there is no offset. */
struct finding {
	const struct rasterizing *s;
	struct key_list *list;
};

static enum status take_key(void *user, uint64_t key)
{
	const struct finding *finding = user;
	struct tile tile = tile_from_key(key);
	struct post_rect seen = fine_rect(finding->s, tile.level);
	bool outside = post_rect_empty(post_rect_intersect(tile_post_rect(finding->s->extent, tile), seen));
	return outside ? STATUS_OK : add_key(finding->list, key);
}

/* Adds the children of the listed tiles that have an offset in the map, until there are more than `most`. 0: all. */
static enum status find_finer(struct rasterizing *s, const struct key_list *list, int level, uint64_t most, struct key_list *finer)
{
	for (size_t i = 0; i < 4 * list->count && (most == 0 || finer->count <= most); i++) {
		struct tile above = tile_from_key(list->keys[i / 4]);
		TRY(look_at(s, (struct tile){level, 2 * above.x + (i & 1), 2 * above.y + (i >> 1 & 1)}, finer));
	}
	return STATUS_OK;
}

/* Lists the tiles with offsets in the map, of the finest level that has at most `tiles_most` of them. Begins at the map's own
 * level. Looks only below tiles that have offsets. */
static enum status find_tiles(struct rasterizing *s, struct key_list *list)
{
	struct tile first, last;
	int level = s->params->level;
	uint64_t most = s->params->tiles_most;
	if (!tile_range_of(s->extent, level, s->raster->rect, &first, &last))
		return STATUS_OK;
	for (uint32_t y = first.y; y <= last.y; y++)
		for (uint32_t x = first.x; x <= last.x; x++)
			TRY(look_at(s, (struct tile){level, x, y}, list));
	while (level > s->working) {
		struct key_list finer = {NULL, 0, 0};
		const enum status status = find_finer(s, list, --level, most, &finer);
		if (status != STATUS_OK || (most > 0 && finer.count > most)) {
			mem_free(finer.keys);
			return status;
		}
		mem_free(list->keys);
		*list = finer;
	}
	return STATUS_OK;
}

static bool is_mark(enum store_layer layer)
{
	return layer == STORE_HEALED || layer == STORE_RISEN || layer == STORE_GROWN;
}

/* Returns the share that is left of a mark that is gone at a time, in quarter seconds. */
static float left_of(const struct rasterizing *s, enum store_layer layer, int32_t until)
{
	const enum plane plane = layer == STORE_HEALED ? PLANE_HEALED : layer == STORE_RISEN ? PLANE_RISEN : PLANE_GROWN;
	const struct plane_marks *marks = &s->params->marks;
	return (float)plane_mark_left(until, marks->now, plane_mark_whole(marks, plane)) / PLANE_MARK_MOST;
}

static float value_of(const struct rasterizing *s, enum store_layer layer, int32_t post)
{
	if (layer == STORE_SOIL)
		return (float)post / PLANE_MARK_MOST;
	if (is_mark(layer))
		return left_of(s, layer, post);
	if (layer == STORE_SHEAR || layer == STORE_SHEAR_EAST || layer == STORE_SHEAR_NORTH)
		return (float)ldexp(plane_shear(post, store_shear_part(layer)), -PLANE_SHEAR_BITS);
	return (float)lattice_offset_metres(post);
}

/* Whether a pixel shows this offset rather than the other. A rut comes before a heap, even a higher one. Else the larger one comes first. */
static bool is_shown(float offset, float other)
{
	const bool rut = offset <= -RUT;
	return rut != (other <= -RUT) ? rut : fabsf(offset) > fabsf(other);
}

/* Adds the tile's posts to the pixels that they are in. */
static void splat(const struct rasterizing *s, struct tile tile, enum store_layer layer, const int32_t *posts, float *into)
{
	const struct chart_raster *raster = s->raster;
	int shift = s->params->level - tile.level;
	int64_t half = shift > 0 ? (int64_t)1 << (shift - 1) : 0, side = tile_posts(s->extent);
	struct post_rect own = tile_post_rect(s->extent, tile);
	struct post_rect part = post_rect_intersect(own, fine_rect(s, tile.level));
	int64_t last_x = raster->width - 1, last_y = raster->height - 1;
	for (int64_t y = part.y0; y < part.y1; y++) {
		int64_t py = ((y + half) >> shift) - raster->rect.y0;
		float *row = into + (py < last_y ? py : last_y) * raster->width;
		for (int64_t x = part.x0; x < part.x1; x++) {
			float value = value_of(s, layer, posts[(y - own.y0) * side + x - own.x0]);
			int64_t px = ((x + half) >> shift) - raster->rect.x0;
			float *pixel = row + (px < last_x ? px : last_x);
			if (layer == STORE_OFFSET ? is_shown(value, *pixel) : fabsf(value) > fabsf(*pixel))
				*pixel = value;
		}
	}
}

static enum status list_tiles(struct rasterizing *s, enum plane plane, struct key_list *list)
{
	if (plane == PLANE_OFFSET)
		return find_tiles(s, list);
	return store_each_plane(s->params->reader, plane, s->working, take_key, &(struct finding){s, list});
}

static enum status read_tiles(struct rasterizing *s, enum store_layer layer, enum plane plane, float *into)
{
	struct key_list list = {NULL, 0, 0};
	size_t side = tile_posts(s->extent);
	int32_t *posts = mem_alloc(side * side, sizeof *posts);
	void *planes[PLANES] = {NULL};
	enum status status;
	TRY_MEM(posts, "a tile");
	planes[plane] = posts;
	TRY_OR(done, list_tiles(s, plane, &list));
	s->total += (int64_t)list.count;
	for (size_t i = 0; i < list.count; i++) {
		struct tile tile = tile_from_key(list.keys[i]);
		unsigned present;
		TRY_OR(done, store_read_deformed(s->params->reader, tile, PLANE_BIT(plane), planes, &present));
		for (size_t k = side * side; k-- > 0 && plane == PLANE_DISTURBANCE && present != 0;)
			posts[k] = ((const uint8_t *)posts)[k]; /* from the end, since they lie in the same memory */
		if (present != 0)
			splat(s, tile, layer, posts, into);
		TRY_OR(done, chart_raster_tell(s, 1));
	}
done:
	mem_free_all(list.keys, posts);
	return status;
}

static bool is_heights(enum store_layer layer)
{
	return layer == STORE_SURFACE || layer == STORE_BASE;
}

/* For heights, and for pixels finer than the store has: interpolates, as exports do. */
static enum status read_posts(struct rasterizing *s, enum store_layer layer, float *into)
{
	const struct chart_raster *raster = s->raster;
	double *values = mem_alloc((size_t)raster->width * RASTER_STRIP, sizeof *values);
	TRY_MEM(values, "rows of a map");
	enum status status = STATUS_OK;
	struct post_rect rect = raster->rect;
	for (int64_t y = rect.y0; y < rect.y1; y += RASTER_STRIP) {
		struct post_rect part = {rect.x0, y, rect.x1, y + RASTER_STRIP < rect.y1 ? y + RASTER_STRIP : rect.y1};
		TRY_OR(done, store_read_posts(s->params->reader, layer, s->params->level, part, values));
		size_t count = (size_t)(part.y1 - part.y0) * raster->width;
		float *to = into + (size_t)(y - rect.y0) * raster->width;
		for (size_t i = 0; i < count; i++) {
			float value = isnan(values[i]) && !is_heights(layer) ? 0 : (float)values[i];
			if (layer == STORE_SOIL)
				value /= PLANE_MARK_MOST;
			else if (is_mark(layer))
				value = isnan(values[i]) ? 0 : left_of(s, layer, (int32_t)ldexp(values[i], PLANE_TIME_BITS));
			to[i] = layer == STORE_HEALED ? fmaxf(to[i], value) : value;
		}
	}
done:
	mem_free(values);
	return status;
}

static enum status read_layer(struct rasterizing *s, enum store_layer layer, float *into)
{
	static const enum plane planes[STORE_LAYERS] = {
		[STORE_OFFSET] = PLANE_OFFSET, [STORE_DEPOSITED] = PLANE_DEPOSITED, [STORE_PLASTIC_SINKAGE] = PLANE_PLASTIC_SINKAGE,
		[STORE_SHEAR] = PLANE_SHEAR, [STORE_SHEAR_EAST] = PLANE_SHEAR, [STORE_SHEAR_NORTH] = PLANE_SHEAR,
		[STORE_SETTLED] = PLANE_SETTLED, [STORE_LOOSE] = PLANE_LOOSE, [STORE_DENSITY] = PLANE_DENSITY,
		[STORE_SOIL] = PLANE_DISTURBANCE, [STORE_HEALED] = PLANE_HEALED, [STORE_RISEN] = PLANE_RISEN, [STORE_GROWN] = PLANE_GROWN};
	if (is_heights(layer) || s->params->level < s->working)
		return read_posts(s, layer, into);
	return read_tiles(s, layer, planes[layer], into);
}

/* --- the whole raster --- */

static enum status allocate(struct rasterizing *s)
{
	struct chart_raster *raster = s->raster;
	size_t pixels = (size_t)raster->width * raster->height;
	raster->shade = mem_alloc(pixels, sizeof *raster->shade);
	raster->values = mem_calloc(pixels, sizeof *raster->values);
	bool shared = s->params->layer == STORE_OFFSET, shades = s->deformed && s->params->level <= s->working;
	s->offset = shades ? (shared ? raster->values : mem_calloc(pixels, sizeof *s->offset)) : NULL;
	return raster->shade != NULL && raster->values != NULL && (!shades || s->offset != NULL) ? STATUS_OK
												 : fail_memory("a map");
}

static enum status fill(struct rasterizing *s)
{
	const enum store_layer layer = s->params->layer;
	TRY(allocate(s));
	float *values = s->raster->values;
	if (s->deformed || is_heights(layer))
		TRY(read_layer(s, layer, values));
	if (s->deformed && layer == STORE_SOIL) /* the ground is as disturbed as the stronger mark says */
		TRY(read_layer(s, STORE_HEALED, values));
	if (s->offset != NULL && s->offset != values)
		TRY(read_layer(s, STORE_OFFSET, s->offset));
	return chart_raster_shade(s);
}

enum status chart_raster_create(const struct chart_raster_params *params, struct chart_raster *out)
{
	*out = (struct chart_raster){
		.width = (uint32_t)(params->rect.x1 - params->rect.x0),
		.height = (uint32_t)(params->rect.y1 - params->rect.y0),
		.level = params->level,
		.rect = params->rect,
		.spacing = extent_spacing(&params->meta->extent, params->level),
		.flat = chart_shade(&params->sun, 0, 0),
	};
	struct rasterizing s = {.params = params, .extent = &params->meta->extent, .raster = out, .working = params->working,
			      .deformed = params->deformed, .total = out->height};
	if (s.deformed && !is_heights(params->layer) && params->level > params->working)
		out->rut = out->spacing;
	const enum status status = fill(&s);
	if (s.offset != out->values)
		mem_free(s.offset);
	if (status != STATUS_OK)
		chart_raster_finish(out);
	return status;
}

void chart_raster_finish(struct chart_raster *raster)
{
	mem_free_all(raster->shade, raster->values);
	*raster = (struct chart_raster){.width = 0};
}

enum status chart_raster_widen(struct chart_raster *raster)
{
	uint32_t width = raster->width, height = raster->height;
	float *wide = mem_alloc((size_t)width * height, sizeof *wide);
	TRY_MEM(wide, "a map");
	for (uint32_t y = 0; y < height; y++)
		for (uint32_t x = 0; x < width; x++) {
			float shown = 0;
			for (uint32_t py = y > 0 ? y - 1 : 0; py <= y + 1 && py < height; py++)
				for (uint32_t px = x > 0 ? x - 1 : 0; px <= x + 1 && px < width; px++) {
					float value = raster->values[(size_t)py * width + px];
					shown = is_shown(value, shown) ? value : shown;
				}
			wide[(size_t)y * width + x] = shown;
		}
	mem_free(raster->values);
	raster->values = wide;
	raster->rut = 3 * raster->spacing;
	return STATUS_OK;
}

/* Returns the high bits of a value without its sign: the class of its size. A larger class has larger values. */
static uint32_t size_class(float value)
{
	uint32_t bits;
	memcpy(&bits, &value, sizeof bits);
	return (bits & 0x7fffffff) >> 15;
}

enum status chart_raster_spread(const struct chart_raster *raster, double share, double *size, double *low, double *high)
{
	size_t pixels = (size_t)raster->width * raster->height;
	uint32_t *classes = mem_calloc((size_t)1 << 16, sizeof *classes);
	uint64_t count = 0;
	TRY_MEM(classes, "a map's values");
	*size = *low = *high = 0;
	for (size_t i = 0; i < pixels; i++) {
		float value = raster->values[i];
		*low = fmin(*low, value);
		*high = fmax(*high, value);
		count += value != 0;
		classes[size_class(value)] += value != 0;
	}
	double beyond = floor((1 - share) * (double)count);
	uint32_t class = (1 << 16) - 1;
	for (uint64_t above = 0; class > 0; class--) {
		above += classes[class];
		if ((double)above > beyond)
			break;
	}
	/* The largest float in that bin of the histogram. */
	uint32_t bits = (class << 15) | 0x7fff;
	float most;
	memcpy(&most, &bits, sizeof most);
	if (count > 0)
		*size = fmin(most, fmax(-*low, *high));
	mem_free(classes);
	return STATUS_OK;
}
