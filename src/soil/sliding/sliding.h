/*
 * The inside of sliding: the working field of a window or of a region of blocks. sliding.c has what callers use.
 *
 * A field has the posts in which soil can slide, row by row from the south-west, with one post around them that is still. Heights are
 * 4 base + offset in 32 bits that wrap, so only differences between neighbours matter. All arrays of a field lie in the caller's
 * scratch memory and have the same stride. One thread at a time uses a field; nothing is allocated.
 */
#ifndef FURROW_SOIL_SLIDING_H
#define FURROW_SOIL_SLIDING_H

#include "soil/lanes.h"
#include "soil/sliding/roofs.h"
#include "soil/soil.h"

#define SLIDING_STILL INT32_MIN      /* a height: the post gives no soil and takes none */
#define SLIDING_MOST (1 << 22)       /* most soil that two posts exchange in an iteration, fixed-point units */
#define SLIDING_POOLED_MOST (1 << 22) /* the same along a line */
/* Posts with offsets beyond these do not slide. So eight iterations with eight neighbours, and eight walks along lines, cannot exceed an
 * offset's range. */
#define SLIDING_LOW (-(1 << 30) + (9 << 25))
#define SLIDING_HIGH ((1 << 30) - (9 << 25))
#define SLIDING_APART (3 << 27)      /* largest difference between neighbours, 2^-18 m (1536 m) */

/* Columns of a row, the first and one behind the last. */
struct sliding_span {
	int32_t first, end;
};

static inline bool soil_sliding_is_empty(struct sliding_span span)
{
	return span.first >= span.end;
}

/* Returns the columns from the first of both to the end of both. */
static inline struct sliding_span soil_sliding_both(struct sliding_span a, struct sliding_span b)
{
	if (soil_sliding_is_empty(a) || soil_sliding_is_empty(b))
		return soil_sliding_is_empty(a) ? b : a;
	return (struct sliding_span){a.first < b.first ? a.first : b.first, a.end > b.end ? a.end : b.end};
}

/* Returns the span with a post more on each side, within the limits. */
static inline struct sliding_span soil_sliding_wider(struct sliding_span span, struct sliding_span within)
{
	if (soil_sliding_is_empty(span))
		return (struct sliding_span){0, 0};
	return (struct sliding_span){span.first > within.first ? span.first - 1 : within.first, span.end < within.end ? span.end + 1 : within.end};
}

struct sliding_field {
	const struct soil_sliding *rule;
	const struct soil_planes *planes;
	const int32_t *deposits;   /* laid soil that is not in the offsets yet, as planes' planes; NULL: there is none */
	struct post_rect rect;     /* the field's posts */
	size_t width, height, stride;
	size_t from;               /* place of the first post in the planes */
	int32_t *heights;          /* of the first post; a row of still posts is before it */
	int32_t *grounds;          /* 4 base */
	int32_t *floors;           /* NULL: relaxing soil has no bottom */
	const struct soil_roofs *roofs; /* NULL: no body keeps posts from rising */
	int32_t *ceilings;         /* with roofs: how high soil may bring each post, */
	int32_t *waits;            /* and room for heights of those below a roof, while soil slides along lines. By Sumner's rule: how much each takes from a neighbour */
	int32_t *critical[2];      /* of the soil of each post: axial, diagonal; NULL: `limits` of all posts */
	uint8_t *stills;           /* 1: the post does not slide */
	uint8_t *moved;            /* 1: the post gave or got soil in the last iteration */
	/* NULL: the height of slopes does not count. Over a window: 1: if its slope is high enough, the post may slide. Over blocks: 1: how high its slope
	 * is changed. */
	uint8_t *steeps;
	int32_t *sheds;            /* what each post sheds, and 0 around them (kinematic/shed.h); NULL: another rule counts */
	int32_t *flows[2][4];      /* of two rows: soil that goes to the post in the east, north, north-east, north-west */
	int32_t *ends;             /* lines.c: 4 for each line; NULL: soil does not slide along lines */
	struct sliding_span *dirty; /* of each row, and of one before and one behind: columns that the last iteration changed */
	struct sliding_span *next;
	int32_t limits[2];
	int32_t least[2];          /* no smaller difference slides */
};

/* field.c: carves the arrays out of scratch memory. blocks: of a region, not of a window. Returns the bytes that are used; scratch NULL: only
 * counts. */
size_t soil_sliding_field_init(struct sliding_field *field, const struct soil_sliding *rule, const struct soil_planes *planes, struct post_rect rect,
			       bool blocks, void *scratch);
/* field.c: computes heights, floors and grounds, and which posts are still. Adds to what is told about laid soil. */
void soil_sliding_begin(struct sliding_field *field, struct soil_slid *slid);
/* roofs.c: places the field's arrays of roofs, and finds how high soil may bring each post. Call it after soil_sliding_begin. */
void soil_sliding_put_roofs(struct sliding_field *field);
/* roofs.c: posts below a roof become still, and slide again. Lines do not know roofs. */
void soil_sliding_close_roofs(struct sliding_field *field);
void soil_sliding_open_roofs(struct sliding_field *field);
/* roofs.c: finds for Sumner's rule how much soil each post takes from a neighbour at most, from the heights as they are. */
void soil_sliding_find_rooms(struct sliding_field *field);
/* steep.c: posts that are too far above or below a neighbour become still. */
void soil_sliding_part_steep(struct sliding_field *field);
/* excess.c: an iteration over the field, less `trim` posts on each side. last: also fills `moved`. */
void soil_sliding_iterate(struct sliding_field *field, size_t trim, bool last);
/* shedding.c: the same by Sumner's rule. The planes must have one post around those that are computed. */
void soil_sliding_shed(struct sliding_field *field, size_t trim, bool last, bool window);
/* excess.c: all posts count as changed. */
void soil_sliding_all_dirty(struct sliding_field *field);
/* excess.c: returns columns of a row. They hold all posts that differ by more than `least` (axial, diagonal) from a neighbour in it or in the
 * next row. There is a post before the row and behind it, and the next row begins `stride` posts later. */
struct sliding_span soil_sliding_steep_span(const int32_t *height, size_t stride, size_t width, const int32_t least[2]);
/* lines.c: soil slides along lines in one direction: x, y, north-east, south-east. */
void soil_sliding_along(struct sliding_field *field, int direction);

/* A piece of a line: posts one behind the other, `step` apart in the field's arrays. */
struct sliding_line {
	int32_t *heights;                           /* of the first post; others from it on */
	const int32_t *floors, *critical, *grounds; /* NULL as in the field */
	ptrdiff_t step;
	int32_t limit, tolerance, least;
	int count;
};

/* Posts of a line, or rows of its posts: the first and the last. None: first > last. */
struct sliding_reach {
	int32_t first, last;
};

/* Returns whether soil may slide from one post to another. It may be wrong of a post that is still. */
SOIL_INLINED bool sliding_may(int32_t high, int32_t low, int32_t least)
{
	return (uint32_t)high - (uint32_t)low - (uint32_t)least - 1u < 1u << 30;
}

/* pools.c: walks along the part of a line in which soil may slide: no pair of posts falls that begins before `falls.first` or after `falls.last`.
 * Returns the pairs whose heights may have changed. pops: counts posts that joined from before a pool; of a whole line, from 0. */
struct sliding_reach soil_sliding_walk(const struct sliding_line *line, struct sliding_reach falls, int *pops);

/* slopes.c: finds the critical differences in slopes, and keeps extents of the field's posts, less `trim` on each side, in planes->slope. Marks in
 * field->steeps posts whose extents changed. Returns false if no soil slides in the field. scratch: soil_sliding_slopes_bytes of it. */
bool soil_sliding_slopes(struct sliding_field *field, size_t trim, void *scratch);
/* slopes.c: sets the least difference that slides where the height of slopes counts. */
void soil_sliding_least_in_slopes(struct sliding_field *field);
size_t soil_sliding_slopes_bytes(const struct soil_sliding *rule, const struct soil_planes *planes);
/* window_slopes.c: marks in `steep` posts of a row beside which a slope could slide if it was high enough. */
void soil_sliding_steep_row(const struct sliding_field *field, size_t row, uint8_t *steep);

/* end.c: writes offsets and thickness of posts of the field, less `trim` on each side. Sets flags of blocks. */
struct sliding_end {
	size_t trim;
	bool window;             /* soil was laid, and the posts at the sides that `borders` names were not looked at */
	bool borders[4];         /* west, south, east, north */
	bool loaded;
	struct post_rect blocks; /* of the words: columns and rows of blocks */
	uint32_t *words;
};
void soil_sliding_end(struct sliding_field *field, const struct sliding_end *end, void *scratch);
size_t soil_sliding_end_bytes(size_t width);

#endif
