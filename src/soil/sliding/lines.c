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

/* Posts of a line, or rows of its posts: the first and the last. None: first > last. */
struct reach {
	int32_t first, last;
};

/* Walks along the part of a line in which soil may slide: no pair of posts falls that begins before `falls.first` or after `falls.last`. A pool
 * takes soil only from pairs that fall, so what lies behind it falls as before. Returns the posts whose heights it wrote, wider by one. */
SLIDING_INLINED struct reach walk_along(const struct line *line, struct reach falls, int *pops)
{
	struct reach wrote = {INT32_MAX, -1};
	bool given = false;
	int at = falls.first;
	int32_t height = line->heights[at * line->step];
	while (given ? at < line->count : at + 1 < line->count && at <= falls.last) {
		bool found = given;
		while (!found && at <= falls.last && at + 1 < line->count) {
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
		const bool written = given || surplus > 0 || pool.count > 1;
		write_pool(line, &pool);
		given = surplus > 0;
		if (written) {
			/* The post before it may have given a part. */
			wrote.first = pool.first - 2 < wrote.first ? pool.first - 2 : wrote.first;
			wrote.last = pool.last + 1;
		}
		at = pool.last + 1;
		height = at < line->count ? plus(line->heights[at * line->step], surplus) : 0;
	}
	return wrote;
}

static struct reach walk_any(const struct line *line, struct reach falls, int *pops)
{
	return walk_along(line, falls, pops);
}

/* The same where relaxing soil has no bottom, and one difference is the critical one of all posts. */
static struct reach walk_plain(const struct line *line, struct reach falls, int *pops)
{
	const struct line plain = {.heights = line->heights, .step = line->step, .limit = line->limit, .tolerance = line->tolerance, .least = line->least,
				   .count = line->count};
	return walk_along(&plain, falls, pops);
}

static struct reach walk(const struct line *line, struct reach falls, int *pops)
{
	bool plain = line->floors == NULL && line->critical == NULL && line->grounds == NULL;
	return plain ? walk_plain(line, falls, pops) : walk_any(line, falls, pops);
}

/* --- the lines of a direction --- */

SLIDING_INLINED int32_t least_of(int32_t a, int32_t b)
{
	return a < b ? a : b;
}

SLIDING_INLINED int32_t most_of(int32_t a, int32_t b)
{
	return a > b ? a : b;
}

/* Where pairs of posts may slide there and back, of lines side by side. */
struct ends {
	int32_t *falls_first, *falls_last, *rises_first, *rises_last;
};

/* Compares a row of posts with the next post of each one's line. at: the number of the row. */
SLIDING_CLONED static void look_row(const int32_t *heights, const int32_t *next, size_t count, int32_t least, int32_t at, const struct ends *ends)
{
	int32_t *falls_first = ends->falls_first, *falls_last = ends->falls_last, *rises_first = ends->rises_first, *rises_last = ends->rises_last;
	SLIDING_ROW
	for (size_t x = 0; x < count; x++) {
		bool falls = may_slide(heights[x], next[x], least), rises = may_slide(next[x], heights[x], least);
		falls_first[x] = least_of(falls_first[x], falls ? at : INT32_MAX);
		falls_last[x] = most_of(falls_last[x], falls ? at : -1);
		rises_first[x] = least_of(rises_first[x], rises ? at : INT32_MAX);
		rises_last[x] = most_of(rises_last[x], rises ? at : -1);
	}
}

/* The same of one row along itself. */
SLIDING_CLONED static void look_along(const int32_t *heights, int32_t count, int32_t least, struct reach *fall, struct reach *rise)
{
	int32_t falls_first = INT32_MAX, falls_last = -1, rises_first = INT32_MAX, rises_last = -1;
	SLIDING_ROW
	for (int32_t x = 0; x < count - 1; x++) {
		bool falls = may_slide(heights[x], heights[x + 1], least), rises = may_slide(heights[x + 1], heights[x], least);
		falls_first = least_of(falls_first, falls ? x : INT32_MAX);
		falls_last = most_of(falls_last, falls ? x : -1);
		rises_first = least_of(rises_first, rises ? x : INT32_MAX);
		rises_last = most_of(rises_last, rises ? x : -1);
	}
	*fall = (struct reach){falls_first, falls_last};
	*rise = (struct reach){rises_first, rises_last};
}

static struct reach around(struct reach a, struct reach b)
{
	return (struct reach){least_of(a.first, b.first), most_of(a.last, b.last)};
}

/* Returns where pairs may fall on the way back: `rises` of pairs on the way there, by the post that they begin with. */
static struct reach back_of(struct reach rises, int count)
{
	return (struct reach){most_of(count - 2 - rises.last, 0), least_of(count - 2 - rises.first, count - 2)};
}

/* A piece with `count` posts from (x, y) on. Directions go by (+1, 0), (0, +1), (+1, +1), (+1, -1). */
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

/* Walks there. Returns where pairs may rise then. */
static struct reach walk_there(const struct sliding_field *field, int direction, size_t x, size_t y, int count, struct reach falls, struct reach rises,
			       int *pops)
{
	const struct line line = line_at(field, direction, x, y, count, false);
	return falls.first <= falls.last ? around(rises, walk(&line, falls, pops)) : rises;
}

static void walk_back(const struct sliding_field *field, int direction, size_t x, size_t y, int count, struct reach rises, int *pops)
{
	const struct line line = line_at(field, direction, x, y, count, true);
	if (rises.first <= rises.last)
		walk(&line, back_of(rises, count), pops);
}

static void along_rows(const struct sliding_field *field)
{
	const int count = (int)field->width;
	for (size_t y = 0; y < field->height; y++) {
		struct reach falls, rises;
		int pops = 0, pops_back = 0;
		look_along(field->heights + y * field->stride, count, field->rule->least[0], &falls, &rises);
		rises = walk_there(field, 0, 0, y, count, falls, rises, &pops);
		walk_back(field, 0, 0, y, count, rises, &pops_back);
	}
}

static struct ends ends_of(const struct sliding_field *field)
{
	const size_t count = field->width + field->height;
	const struct ends ends = {field->ends, field->ends + count, field->ends + 2 * count, field->ends + 3 * count};
	for (size_t i = 0; i < count; i++) {
		ends.falls_first[i] = ends.rises_first[i] = INT32_MAX;
		ends.falls_last[i] = ends.rises_last[i] = -1;
	}
	return ends;
}

static struct ends from(struct ends ends, size_t line)
{
	return (struct ends){ends.falls_first + line, ends.falls_last + line, ends.rises_first + line, ends.rises_last + line};
}

static void along_columns(const struct sliding_field *field)
{
	const struct ends ends = ends_of(field);
	const int count = (int)field->height;
	for (size_t y = 0; y + 1 < field->height; y++)
		look_row(field->heights + y * field->stride, field->heights + (y + 1) * field->stride, field->width, field->rule->least[0], (int32_t)y, &ends);
	for (size_t x = 0; x < field->width; x++) {
		int pops = 0, pops_back = 0;
		struct reach falls = {ends.falls_first[x], ends.falls_last[x]}, rises = {ends.rises_first[x], ends.rises_last[x]};
		rises = walk_there(field, 1, x, 0, count, falls, rises, &pops);
		walk_back(field, 1, x, 0, count, rises, &pops_back);
	}
}

/* A piece of a diagonal line. */
struct piece {
	size_t x, y;
	int count;
	size_t number; /* in `ends`; posts of one row have rising numbers */
};

/* Returns the piece of line `line` that begins in column x; of a line to the south-east if `down`. */
static struct piece piece_at(const struct sliding_field *field, size_t line, size_t x, bool down)
{
	size_t height = field->height, way = x % height, y = down ? (line + height - way) % height : (line + way) % height;
	size_t to_side = down ? y + 1 : height - y, left = field->width - x;
	return (struct piece){x, y, (int)(to_side < left ? to_side : left), down ? x + y : x + height - 1 - y};
}

/* Returns the piece of a line that ends before column `end`. */
static struct piece piece_before(const struct sliding_field *field, size_t line, size_t end, bool down)
{
	size_t x = end - 1, y = piece_at(field, line, x, down).y, before = down ? field->height - 1 - y : y;
	return piece_at(field, line, x - (before < x ? before : x), down);
}

/* Finds where pieces fall and rise. Rows become posts of the pieces later. */
static void look_diagonally(const struct sliding_field *field, bool down, struct ends ends)
{
	const int32_t least = field->rule->least[1];
	for (size_t y = 0; y + 1 < field->height; y++) {
		const int32_t *south = field->heights + y * field->stride, *north = south + field->stride;
		/* The line goes from the west: to the north-east from the row in the south, to the south-east from that in the north. */
		const struct ends row = from(ends, down ? y + 1 : field->height - 1 - y);
		look_row(down ? north : south, (down ? south : north) + 1, field->width - 1, least, (int32_t)y + down, &row);
	}
}

/* Returns posts of a piece from rows of the field. */
static struct reach posts_of(const struct piece *piece, int32_t first, int32_t last, bool down)
{
	const int32_t y = (int32_t)piece->y;
	if (first > last)
		return (struct reach){INT32_MAX, -1};
	return down ? (struct reach){y - last, y - first} : (struct reach){first - y, last - y};
}

static void along_diagonals(const struct sliding_field *field, bool down)
{
	const struct ends ends = ends_of(field);
	const int direction = down ? 3 : 2;
	look_diagonally(field, down, ends);
	for (size_t line = 0; line < field->height; line++) {
		int pops = 0, pops_back = 0;
		for (size_t x = 0; x < field->width;) {
			const struct piece piece = piece_at(field, line, x, down);
			const struct reach falls = posts_of(&piece, ends.falls_first[piece.number], ends.falls_last[piece.number], down);
			struct reach rises = posts_of(&piece, ends.rises_first[piece.number], ends.rises_last[piece.number], down);
			rises = walk_there(field, direction, piece.x, piece.y, piece.count, falls, rises, &pops);
			ends.rises_first[piece.number] = rises.first;
			ends.rises_last[piece.number] = rises.last;
			x += (size_t)piece.count;
		}
		for (size_t end = field->width; end > 0;) {
			const struct piece piece = piece_before(field, line, end, down);
			const struct reach rises = {ends.rises_first[piece.number], ends.rises_last[piece.number]};
			walk_back(field, direction, piece.x, piece.y, piece.count, rises, &pops_back);
			end = piece.x;
		}
	}
}

void soil_sliding_along(struct sliding_field *field, int direction)
{
	if (field->width == 0 || field->height == 0)
		return;
	if (direction == 0)
		along_rows(field);
	else if (direction == 1)
		along_columns(field);
	else
		along_diagonals(field, direction == 3);
}
