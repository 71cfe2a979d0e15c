/*
 * A walk along a line. Where soil slides, posts join a pool: they get the heights at which each difference from post to post is the critical
 * one. A pool grows by posts before and behind it as long as soil slides. slide_lines.frag does the same.
 */
#include "soil/sliding/sliding.h"

#define POPS_MOST 512 /* posts that join from before the pool, of all pools of a walk */

/* A pool: posts of a line, first .. last. A post's fall is the sum of the critical differences before it; its level is its height and its
 * fall. All levels are `level`, but those of the last `rest` posts are one more. */
struct pool {
	int first, last, count;
	int32_t level, rest, first_fall, last_fall;
	int32_t lowest, highest; /* levels that posts of the pool had before */
	int32_t bottom;          /* the highest level that a post of the pool has at its floor */
};

SOIL_INLINED int32_t plus(int32_t a, int32_t b)
{
	return (int32_t)((uint32_t)a + (uint32_t)b);
}

SOIL_INLINED int32_t minus(int32_t a, int32_t b)
{
	return (int32_t)((uint32_t)a - (uint32_t)b);
}

SOIL_INLINED int32_t times(int32_t a, int32_t b)
{
	return (int32_t)((uint32_t)a * (uint32_t)b);
}

/* Returns a / b rounded down; b > 0. */
SOIL_INLINED int32_t quotient(int32_t a, int32_t b)
{
	int32_t q = a / b;
	return q - (times(q, b) > a);
}

/* Returns the critical difference between a post and a lower one beside it. */
SOIL_INLINED int32_t limit_of(const struct sliding_line *line, int high, int low)
{
	int32_t limit = line->critical != NULL ? line->critical[high * line->step] : line->limit;
	if (line->grounds != NULL) {
		int32_t stood = minus(line->grounds[high * line->step], line->grounds[low * line->step]);
		limit = limit > stood ? limit : stood;
	}
	return limit;
}

/* Adds soil to the pool: with a post, by how much that lies above the pool's level. */
SOIL_INLINED void add_to_pool(struct pool *pool, int32_t soil, int posts)
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
SOIL_INLINED bool joins(const struct sliding_line *line, const struct pool *pool, bool back, int pops, struct joining *post)
{
	post->at = back ? pool->first - 1 : pool->last + 1;
	if (back ? post->at < 0 || pops >= POPS_MOST : post->at >= line->count)
		return false;
	int32_t height = line->heights[post->at * line->step];
	int32_t edge = back ? minus(pool->level, pool->first_fall) : minus(plus(pool->level, pool->rest > 0), pool->last_fall);
	bool takes = height != SLIDING_STILL && edge != SLIDING_STILL &&
		     (back ? sliding_may(height, edge, line->least) : sliding_may(edge, height, line->least));
	if (!takes)
		return false;
	int32_t limit = back ? limit_of(line, post->at, pool->first) : limit_of(line, pool->last, post->at);
	post->fall = back ? minus(pool->first_fall, limit) : plus(pool->last_fall, limit);
	post->own = plus(height, post->fall);
	post->above = minus(post->own, pool->level);
	int32_t highest = pool->highest > post->own ? pool->highest : post->own, lowest = pool->lowest < post->own ? pool->lowest : post->own;
	return (back ? post->above : minus(pool->rest > 0, post->above)) > line->tolerance && minus(highest, lowest) < SLIDING_POOLED_MOST;
}

SOIL_INLINED void take(struct pool *pool, const struct joining *post, bool back)
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
SOIL_INLINED bool joins_above_bottom(const struct sliding_line *line, struct pool *pool, bool back, struct joining *post, int32_t *surplus)
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
SOIL_INLINED int32_t grow_pool(const struct sliding_line *line, struct pool *pool, bool back, int *pops)
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

SOIL_INLINED void write_pool(const struct sliding_line *line, const struct pool *pool)
{
	int32_t fall = pool->last_fall;
	for (int i = pool->last, left = pool->rest; i >= pool->first; i--, left--) {
		line->heights[i * line->step] = minus(plus(pool->level, left > 0), fall);
		fall = minus(fall, i > pool->first ? limit_of(line, i - 1, i) : 0);
	}
}

/* Walks along the part of a line in which soil may slide: no pair of posts falls that begins before `falls.first` or after `falls.last`. A pool
 * takes soil only from pairs that fall, so what lies behind it falls as before. Returns the posts whose heights it wrote, wider by one. */
SOIL_INLINED struct sliding_reach walk_along(const struct sliding_line *line, struct sliding_reach falls, int *pops)
{
	struct sliding_reach wrote = {INT32_MAX, -1};
	bool given = false;
	int at = falls.first;
	int32_t height = line->heights[at * line->step];
	while (given ? at < line->count : at + 1 < line->count && at <= falls.last) {
		bool found = given;
		while (!found && at <= falls.last && at + 1 < line->count) {
			int32_t next = line->heights[(at + 1) * line->step];
			found = sliding_may(height, next, line->least);
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

static struct sliding_reach walk_any(const struct sliding_line *line, struct sliding_reach falls, int *pops)
{
	return walk_along(line, falls, pops);
}

/* The same where relaxing soil has no bottom, and one difference is the critical one of all posts. */
static struct sliding_reach walk_plain(const struct sliding_line *line, struct sliding_reach falls, int *pops)
{
	const struct sliding_line plain = {.heights = line->heights, .step = line->step, .limit = line->limit, .tolerance = line->tolerance, .least = line->least,
				   .count = line->count};
	return walk_along(&plain, falls, pops);
}

struct sliding_reach soil_sliding_walk(const struct sliding_line *line, struct sliding_reach falls, int *pops)
{
	bool plain = line->floors == NULL && line->critical == NULL && line->grounds == NULL;
	return plain ? walk_plain(line, falls, pops) : walk_any(line, falls, pops);
}
