/*
 * Sliding along the lines of a window, in one direction (SOIL.md, "Along lines"). Where soil slides, posts join a pool: they get the heights
 * at which each difference from post to post is the critical one. So a line is at rest when it was walked there and back.
 *
 * The lines of a direction are first compared with the least difference that slides, row by row. Only those in which some soil may slide
 * are walked.
 *
 * Diagonal lines go on at the other side of the window: line i begins at the west in row i, and in each column it has one post. Where it
 * is cut no soil goes over. Its pieces share the limit POPS_MOST, as on the GPU, so that both do the same.
 */
#include <string.h>

#include "soil/sliding/sliding.h"

#define POPS_MOST 512 /* posts that join from before the pool, of all pools of a walk */

/* A piece of a line: posts one behind the other, `step` apart in the field's arrays. */
struct line {
	int32_t *heights;                         /* of the first post; others from it on */
	const int32_t *floors, *critical, *grounds; /* NULL as in the field */
	ptrdiff_t step;
	int32_t limit, tolerance, least;
	int count;
};

/* A pool: posts of a line, first .. last. A post's fall is the sum of the critical differences before it; its level is its height and its
 * fall. All levels are `level`, but those of the last `rest` posts are one more. */
struct pool {
	int first, last, count;
	int32_t level, rest, first_fall, last_fall;
	int32_t lowest, highest; /* levels that posts of the pool had before */
	int32_t bottom;          /* the highest level that a post of the pool has at its floor */
};

SLIDING_INLINED int32_t plus(int32_t a, int32_t b)
{
	return (int32_t)((uint32_t)a + (uint32_t)b);
}

SLIDING_INLINED int32_t minus(int32_t a, int32_t b)
{
	return (int32_t)((uint32_t)a - (uint32_t)b);
}

SLIDING_INLINED int32_t times(int32_t a, int32_t b)
{
	return (int32_t)((uint32_t)a * (uint32_t)b);
}

/* Returns a / b rounded down; b > 0. */
SLIDING_INLINED int32_t quotient(int32_t a, int32_t b)
{
	int32_t q = a / b;
	return q - (times(q, b) > a);
}

/* Returns whether soil may slide from one post to another. It may be wrong of a post that is still. */
SLIDING_INLINED bool may_slide(int32_t high, int32_t low, int32_t least)
{
	return (uint32_t)high - (uint32_t)low - (uint32_t)least - 1u < 1u << 30;
}

/* Returns the critical difference between a post and a lower one beside it. */
SLIDING_INLINED int32_t limit_of(const struct line *line, int high, int low)
{
	int32_t limit = line->critical != NULL ? line->critical[high * line->step] : line->limit;
	if (line->grounds != NULL) {
		int32_t stood = minus(line->grounds[high * line->step], line->grounds[low * line->step]);
		limit = limit > stood ? limit : stood;
	}
	return limit;
}

/* Adds soil to the pool: with a post, by how much that lies above the pool's level. */
SLIDING_INLINED void add_to_pool(struct pool *pool, int32_t soil, int posts)
{
	int32_t sum = plus(pool->rest, soil), mean = quotient(sum, pool->count + posts);
	pool->count += posts;
	pool->rest = minus(sum, times(mean, pool->count));
	pool->level = plus(pool->level, mean);
}

/* A post that may join a pool. */
struct joining {
	int at;
	int32_t fall, own, above, under;
};

/* Returns whether the post before or behind the pool gives soil to it, or takes some. */
SLIDING_INLINED bool joins(const struct line *line, const struct pool *pool, bool back, int pops, struct joining *post)
{
	post->at = back ? pool->first - 1 : pool->last + 1;
	if (back ? post->at < 0 || pops >= POPS_MOST : post->at >= line->count)
		return false;
	int32_t height = line->heights[post->at * line->step];
	int32_t edge = back ? minus(pool->level, pool->first_fall) : minus(plus(pool->level, pool->rest > 0), pool->last_fall);
	bool takes = height != SLIDING_STILL && edge != SLIDING_STILL &&
		     (back ? may_slide(height, edge, line->least) : may_slide(edge, height, line->least));
	if (!takes)
		return false;
	int32_t limit = back ? limit_of(line, post->at, pool->first) : limit_of(line, pool->last, post->at);
	post->fall = back ? minus(pool->first_fall, limit) : plus(pool->last_fall, limit);
	post->own = plus(height, post->fall);
	post->above = minus(post->own, pool->level);
	int32_t highest = pool->highest > post->own ? pool->highest : post->own, lowest = pool->lowest < post->own ? pool->lowest : post->own;
	return (back ? post->above : minus(pool->rest > 0, post->above)) > line->tolerance && minus(highest, lowest) < SLIDING_POOLED_MOST;
}

SLIDING_INLINED void take(struct pool *pool, const struct joining *post, bool back)
{
	add_to_pool(pool, post->above, 1);
	pool->lowest = pool->lowest < post->own ? pool->lowest : post->own;
	pool->highest = pool->highest > post->own ? pool->highest : post->own;
	if (back) {
		pool->first = post->at;
		pool->first_fall = post->fall;
	} else {
		pool->last = post->at;
		pool->last_fall = post->fall;
	}
}

/* Where relaxing soil has a bottom: returns whether a post joins that would do so otherwise. A pool may come down to the bottom. Then it
 * ends, and *surplus is what it cannot keep. A post before it may give only a part. */
SLIDING_INLINED bool joins_above_bottom(const struct line *line, struct pool *pool, bool back, struct joining *post, int32_t *surplus)
{
	post->under = plus(line->floors[post->at * line->step], post->fall);
	if (!(back ? post->own > post->under : pool->level > pool->bottom))
		return false;
	int32_t level = plus(pool->level, quotient(plus(pool->rest, post->above), pool->count + 1));
	if (level >= (back ? post->under : pool->bottom)) {
		pool->bottom = pool->bottom > post->under ? pool->bottom : post->under;
		return true;
	}
	if (back) {
		line->heights[post->at * line->step] = minus(post->under, post->fall);
		add_to_pool(pool, minus(post->own, post->under), 0);
	} else {
		*surplus = plus(times(minus(pool->level, pool->bottom), pool->count), pool->rest);
		pool->level = pool->bottom;
		pool->rest = 0;
	}
	return false;
}

/* Lets posts before and behind the pool join it as long as soil slides. back: looks before the pool first. Returns soil that the pool cannot
 * keep, for the post behind it. */
SLIDING_INLINED int32_t grow_pool(const struct line *line, struct pool *pool, bool back, int *pops)
{
	int32_t surplus = 0;
	for (bool grows = true; grows;) {
		struct joining post;
		bool takes = joins(line, pool, back, *pops, &post);
		if (takes && line->floors != NULL)
			takes = joins_above_bottom(line, pool, back, &post, &surplus);
		if (takes)
			take(pool, &post, back);
		*pops += takes && back;
		grows = takes || back;
		back = takes;
	}
	return surplus;
}

SLIDING_INLINED void write_pool(const struct line *line, const struct pool *pool)
{
	int32_t fall = pool->last_fall;
	for (int i = pool->last, left = pool->rest; i >= pool->first; i--, left--) {
		line->heights[i * line->step] = minus(plus(pool->level, left > 0), fall);
		fall = minus(fall, i > pool->first ? limit_of(line, i - 1, i) : 0);
	}
}

/* Walks along a line. Returns true if soil slid. */
static bool walk(const struct line *line, int *pops)
{
	bool slid = false, given = false;
	int32_t height = line->heights[0];
	for (int at = 0; at < line->count;) {
		bool found = given;
		while (!found && at + 1 < line->count) {
			int32_t next = line->heights[(at + 1) * line->step];
			found = may_slide(height, next, line->least);
			at += !found;
			height = found ? height : next;
		}
		if (!found)
			break;
		struct pool pool = {.first = at, .last = at, .count = 1, .level = height, .lowest = height, .highest = height,
				    .bottom = line->floors != NULL ? line->floors[at * line->step] : 0};
		int32_t surplus = grow_pool(line, &pool, given, pops);
		write_pool(line, &pool);
		given = surplus > 0;
		slid = slid || given || pool.count > 1;
		at = pool.last + 1;
		height = at < line->count ? plus(line->heights[at * line->step], surplus) : 0;
	}
	return slid;
}

/* --- the lines of a direction --- */

/* What may slide in each piece of a line: bits. */
#define FALLS 1
#define RISES 2

SLIDING_CLONED static void look_row(const int32_t *restrict heights, const int32_t *restrict next, size_t count, int32_t least, uint8_t *restrict pieces)
{
	SLIDING_ROW
	for (size_t x = 0; x < count; x++)
		pieces[x] |= (uint8_t)(may_slide(heights[x], next[x], least) | may_slide(next[x], heights[x], least) << 1);
}

SLIDING_CLONED static uint8_t look_along(const int32_t *restrict heights, size_t count, int32_t least)
{
	uint8_t any = 0;
	SLIDING_ROW
	for (size_t x = 0; x + 1 < count; x++)
		any |= (uint8_t)(may_slide(heights[x], heights[x + 1], least) | may_slide(heights[x + 1], heights[x], least) << 1);
	return any;
}

/* A piece with `count` posts from (x, y) on. `to` (+1, 0), (0, +1), (+1, +1), (+1, -1) by direction. */
static struct line line_at(const struct sliding_field *field, int direction, size_t x, size_t y, int count, bool back)
{
	static const int ways[4][2] = {{1, 0}, {0, 1}, {1, 1}, {1, -1}};
	const ptrdiff_t step = ways[direction][0] + ways[direction][1] * (ptrdiff_t)field->stride;
	const ptrdiff_t at = (ptrdiff_t)(y * field->stride + x) + (back ? (count - 1) * step : 0);
	const int diagonal = direction > 1;
	return (struct line){
		.heights = field->heights + at,
		.floors = field->floors != NULL ? field->floors + at : NULL,
		.critical = field->critical[0] != NULL ? field->critical[diagonal] + at : NULL,
		.grounds = field->grounds != NULL ? field->grounds + at : NULL,
		.step = back ? -step : step,
		.limit = field->limits[diagonal],
		.tolerance = field->rule->tolerance,
		.least = field->rule->least[diagonal],
		.count = count,
	};
}

static void along_rows(struct sliding_field *field)
{
	for (size_t y = 0; y < field->height; y++) {
		uint8_t may = look_along(field->heights + y * field->stride, field->width, field->rule->least[0]);
		int pops = 0, pops_back = 0;
		const struct line there = line_at(field, 0, 0, y, (int)field->width, false), back = line_at(field, 0, 0, y, (int)field->width, true);
		bool slid = (may & FALLS) != 0 && walk(&there, &pops);
		if (slid || (may & RISES) != 0)
			walk(&back, &pops_back);
	}
}

static void along_columns(struct sliding_field *field, uint8_t *pieces)
{
	memset(pieces, 0, field->width);
	for (size_t y = 0; y + 1 < field->height; y++)
		look_row(field->heights + y * field->stride, field->heights + (y + 1) * field->stride, field->width, field->rule->least[0], pieces);
	for (size_t x = 0; x < field->width; x++) {
		int pops = 0, pops_back = 0;
		const struct line there = line_at(field, 1, x, 0, (int)field->height, false), back = line_at(field, 1, x, 0, (int)field->height, true);
		bool slid = (pieces[x] & FALLS) != 0 && walk(&there, &pops);
		if (slid || (pieces[x] & RISES) != 0)
			walk(&back, &pops_back);
	}
}

/* A piece of a diagonal line. */
struct piece {
	size_t x, y;
	int count;
};

/* Returns the piece of line `line` that begins in column x; of a line to the south-east if `down`. */
static struct piece piece_at(const struct sliding_field *field, size_t line, size_t x, bool down)
{
	size_t height = field->height, way = x % height, y = down ? (line + height - way) % height : (line + way) % height;
	size_t to_side = down ? y + 1 : height - y, left = field->width - x;
	return (struct piece){x, y, (int)(to_side < left ? to_side : left)};
}

/* Returns the number of a piece in `pieces`. Posts of one row have rising numbers. */
static size_t number_of(const struct sliding_field *field, struct piece piece, bool down)
{
	return down ? piece.x + piece.y : piece.x + field->height - 1 - piece.y;
}

static void look_diagonally(const struct sliding_field *field, bool down, uint8_t *pieces)
{
	const int32_t least = field->rule->least[1];
	memset(pieces, 0, field->width + field->height);
	for (size_t y = 0; y + 1 < field->height; y++) {
		const int32_t *south = field->heights + y * field->stride, *north = south + field->stride;
		/* The line goes from the west: to the north-east from the row in the south, to the south-east from that in the north. */
		if (down)
			look_row(north, south + 1, field->width - 1, least, pieces + y + 1);
		else
			look_row(south, north + 1, field->width - 1, least, pieces + (field->height - 1 - y));
	}
}

static void along_diagonals(struct sliding_field *field, bool down, uint8_t *pieces)
{
	const int direction = down ? 3 : 2;
	look_diagonally(field, down, pieces);
	for (size_t line = 0; line < field->height; line++) {
		int pops = 0;
		for (size_t x = 0; x < field->width;) {
			const struct piece piece = piece_at(field, line, x, down);
			uint8_t *may = &pieces[number_of(field, piece, down)];
			const struct line there = line_at(field, direction, piece.x, piece.y, piece.count, false);
			if ((*may & FALLS) != 0 && walk(&there, &pops))
				*may |= RISES;
			x += (size_t)piece.count;
		}
		pops = 0;
		/* Back from the last piece to the first. */
		for (size_t end = field->width; end > 0;) {
			size_t height = field->height, x = end - 1, row = piece_at(field, line, x, down).y;
			size_t before = down ? height - 1 - row : row;
			x -= before < x ? before : x;
			const struct piece piece = piece_at(field, line, x, down);
			const struct line back = line_at(field, direction, piece.x, piece.y, piece.count, true);
			if ((pieces[number_of(field, piece, down)] & RISES) != 0)
				walk(&back, &pops);
			end = x;
		}
	}
}

void soil_sliding_along(struct sliding_field *field, int direction)
{
	uint8_t *pieces = field->moved; /* free until the last iteration */
	if (field->width == 0 || field->height == 0)
		return;
	if (direction == 0)
		along_rows(field);
	else if (direction == 1)
		along_columns(field, pieces);
	else
		along_diagonals(field, direction == 3, pieces);
}
