/* Part of bear.c: copies the numbers of a block of posts from their arrays. */
#ifndef FURROW_SOIL_BEAR_LANES_H
#define FURROW_SOIL_BEAR_LANES_H

#include "soil/law/bear.h"

#define LANES POSTS_LANES
_Static_assert(LANES == 16, "total_real");
#define EACH_LANE for (int i = 0; i < LANES; i++)

/* The numbers of a block of posts. A copy, since a compiler may read all lanes of it, whatever a choice between two numbers needs. */
struct lane_posts {
#define LANE_WHOLE(name) int32_t name[LANES];
#define LANE_REAL(name) float name[LANES];
	POSTS_LAW_WHOLES_EACH(LANE_WHOLE)
	POSTS_LAW_REALS_EACH(LANE_REAL)
#if SOIL_LAYERED
	POSTS_LAYER_REALS_EACH(LANE_REAL)
#endif
#undef LANE_WHOLE
#undef LANE_REAL
};

SOIL_INLINED void take_lanes(const struct soil_posts *posts, size_t b, struct lane_posts *p)
{
#define LANE_TAKE(name) memcpy(p->name, posts->name + b, sizeof p->name);
	POSTS_LAW_WHOLES_EACH(LANE_TAKE)
	POSTS_LAW_REALS_EACH(LANE_TAKE)
#if SOIL_LAYERED
	POSTS_LAYER_REALS_EACH(LANE_TAKE)
#endif
#undef LANE_TAKE
}

/* --- posts that bear nothing --- */

/*
 * A search and a probe need only posts that the body may touch. If there are others in most blocks, they are left out: their lanes take posts of the blocks
 * that follow. Each lane has its posts in their order, so its sums of real numbers have the same bits.
 */
#define WAITING_BLOCKS 8
#define ALL_LANES ((1u << LANES) - 1)
struct waiting {
	size_t next, end;                /* blocks in which lanes wait lie between */
	uint32_t lanes[WAITING_BLOCKS];  /* a bit for each lane, of block b at b % WAITING_BLOCKS */
};

/* Tells whether leaving them out saves a sixth of the blocks, at least. */
SOIL_CLONED static bool are_sparse(const struct soil_posts *restrict posts, float than)
{
	int32_t counts[LANES] = {0}, fills = 0, blocks = 0;
	for (size_t b = 0; b < posts->count; b += LANES) {
		int32_t any = 0;
		SOIL_WHOLE
		EACH_LANE {
			const int32_t waits = posts->room[b + (size_t)i] > than ? 1 : 0;
			counts[i] += waits;
			any |= waits;
		}
		blocks += any;
	}
	SOIL_WHOLE
	EACH_LANE fills = counts[i] > fills ? counts[i] : fills;
	return 6 * fills <= 5 * blocks;
}

/* Copies the posts of some lanes. */
SOIL_INLINED void take_some(const struct soil_posts *posts, size_t b, uint32_t lanes, struct lane_posts *p)
{
	struct lane_posts all;
	take_lanes(posts, b, &all);
#define LANE_TAKE(name) p->name[i] = (lanes >> i & 1) != 0 ? all.name[i] : p->name[i];
	EACH_LANE {
		POSTS_LAW_WHOLES_EACH(LANE_TAKE)
		POSTS_LAW_REALS_EACH(LANE_TAKE)
#if SOIL_LAYERED
		POSTS_LAYER_REALS_EACH(LANE_TAKE)
#endif
	}
#undef LANE_TAKE
}

/* Takes the next post of each lane whose room is above a height. Returns false if there is none. */
SOIL_CLONED static bool take_waiting(const struct soil_posts *restrict posts, float than, struct waiting *restrict w, struct lane_posts *restrict p)
{
	const size_t blocks = soil_posts_end(posts) / LANES;
	uint32_t open = ALL_LANES;
	for (size_t b = w->next; open != 0 && b < blocks && b < w->next + WAITING_BLOCKS; b++) {
		uint32_t *waits = &w->lanes[b % WAITING_BLOCKS];
		if (b == w->end) {
			*waits = 0;
			for (int i = 0; i < LANES; i++)
				*waits |= posts->room[b * LANES + (size_t)i] > than ? 1u << i : 0;
			w->end++;
		}
		const uint32_t takes = *waits & open;
		if (takes != 0 && open == ALL_LANES)
			take_lanes(posts, b * LANES, p);
		else if (takes != 0)
			take_some(posts, b * LANES, takes, p);
		open &= ~takes;
		*waits &= ~takes;
		w->next += b == w->next && *waits == 0;
	}
	EACH_LANE p->share[i] = (open >> i & 1) != 0 ? 0 : p->share[i];
	return open != ALL_LANES;
}

#endif
