/*
 * Soil that a body pushes ahead of itself (SOIL.md, "The front that pushes").
 *
 * The front is the line of the posts that give soil away: the first axis of their second moments, weighted by what each gives. Soil moves across this
 * line, to the side to which the body pushes. So along an oblique blade it comes to the trailing end.
 *
 * Lanes, a post wide, lie across the front. The soil of a lane stays in it. It is laid ahead of the lane's patch as a prism against the body, whose
 * surface falls by the soil's angle of repose. So a hollow ahead is filled before the prism rises. What the prism does at the ends of the front is
 * sliding's.
 */
#include <math.h>
#include <stdlib.h>

#include "soil/laying/strips.h"

#define LANE_POSTS 512      /* posts of a lane ahead of the patch, at most */
#define SMOOTHINGS_LEAST 2  /* of what lanes give, each from a lane to those beside it: lanes cut the lattice unevenly */
#define SMOOTHINGS_MOST 1024
#define FLOWS_OFF 4         /* from an angle whose sine is 1 / 4 on soil flows off at the trailing end */
#define OBLIQUE_MOST 0.999
#define HIGHEST 1e4         /* posts: of a heap */
/* Parts of the tangent of the angle of repose by which a heap falls to the ends of the front, and across it. Both together are as steep as repose. */
#define TO_ENDS 0.5
#define ACROSS 0.8660254037844386
#define MIXES 5             /* soil that is pushed mixes along the front, by a standard deviation of this part of its length */
#define NEAR_ENDS (3 << 16) /* 2^-16 post: lanes beside each other exchange soil if their patches end at no more from each other */
#define HALF_POST (1 << 15) /* 2^-16 post: from the last post of a patch to the face of the body, about */
#define BLURRED 0.5         /* posts squared: a front that is no longer than this has no direction */
#define DEEPEST 63          /* halvings of a range of levels, at most */
#define LAID_MOST (1 << 28) /* fixed-point units: the most soil that a post gets */

/* A lane. */
struct lane {
	int64_t gives;
	int64_t room;   /* for soil that lies at the angle of repose to the end of the front, too */
	int32_t ends;   /* where its patch ends, 2^-16 post in the frame of the front */
	int32_t posts;  /* of the patch; 0: none */
};

/* A free post of a lane. */
struct lane_post {
	int64_t key; /* its height as if it lay where the patch ends, along the fall of the prism */
	int32_t at, row, column;
};

struct front {
	const struct laying_field *field;
	const int32_t *offset, *carried; /* of the first post of `written` */
	struct soil_laying frame;        /* its x axis lies across the front */
	int64_t fall;                    /* of the prism, fixed-point units for each post */
	int64_t highest;               /* fixed-point units: struct soil_measured */
	double oblique[2];               /* 1: soil flows off at the right end, the left end */
	int32_t reaches;                 /* 2^-16 post: soil is laid so far ahead of the patch */
	int64_t first;                   /* number of the first lane */
	int count;
	struct lane *lanes;
};

static int64_t lesser(int64_t a, int64_t b)
{
	return a < b ? a : b;
}

size_t soil_front_scratch(size_t width, size_t height)
{
	return (3 * (width + height) + 8) * sizeof(struct lane);
}

/* Finds the direction in which soil moves: east, north. push: unit vector in which the body pushes. */
static void across_front(const struct soil_measured *measured, const double push[2], double ahead[2])
{
	const int64_t *moments = measured->moments;
	ahead[0] = push[0];
	ahead[1] = push[1];
	if (moments[0] <= 0)
		return;
	const double by = 1 / (double)moments[0], x = by * (double)moments[1], y = by * (double)moments[2];
	const double xx = by * (double)moments[3] - x * x, xy = by * (double)moments[4] - x * y, yy = by * (double)moments[5] - y * y;
	const double cosine = xx - yy, sine = 2 * xy, apart = sqrt(cosine * cosine + sine * sine);
	if (!(apart > 0))
		return;
	/* Along the front: half of the angle of (cosine, sine). */
	const double c = sqrt(fmax(0.5 * (1 + cosine / apart), 0)), s = copysign(sqrt(fmax(0.5 * (1 - cosine / apart), 0)), sine);
	const double sign = c * push[1] - s * push[0] < 0 ? -1 : 1, share = apart / (xx + yy + BLURRED);
	const double east = -s * sign * share + (1 - share) * push[0], north = c * sign * share + (1 - share) * push[1], length = hypot(east, north);
	if (length > 0) {
		ahead[0] = east / length;
		ahead[1] = north / length;
	}
}

static int lane_of(const struct front *front, int32_t place)
{
	return (int)((place >> 16) - front->first);
}

/* Tells whether a post lies in a hollow below the body. The body would touch it if it were as high as the ground beside it. */
static bool is_hollow(const struct front *front, size_t at)
{
	const struct laying_field *field = front->field;
	return (field->patch[at] & SOIL_NEAR) != 0 && 4 * (int64_t)field->base[at] + front->offset[at] + front->carried[at] <= front->highest;
}

/* Adds up what lanes give away, and where their patches end. */
static void find_lanes(struct front *front, const struct soil_measured *measured)
{
	const struct laying_field *field = front->field;
	const struct post_rect all = {field->x0, field->y0, field->x0 + field->width, field->y0 + field->height};
	const struct post_rect patch = post_rect_intersect(post_rect_joined(measured->patch, measured->hollows), all);
	int64_t low = INT64_MAX, high = INT64_MIN;
	for (int corner = 0; corner < 4; corner++) {
		const int64_t lane = soil_laying_place(&front->frame, corner & 1 ? patch.x1 : patch.x0, corner & 2 ? patch.y1 : patch.y0, 1) >> 16;
		low = lane < low ? lane : low;
		high = lane > high ? lane : high;
	}
	front->first = low;
	front->count = (int)(high - low) + 1;
	for (int i = 0; i < front->count; i++)
		front->lanes[i] = (struct lane){.ends = INT32_MIN};
	for (int64_t y = patch.y0; y < patch.y1; y++)
		for (int64_t x = patch.x0; x < patch.x1; x++) {
			const size_t at = (size_t)(y - field->y0) * field->stride + (size_t)(x - field->x0);
			const bool touched = (field->patch[at] & (SOIL_LOWERED | SOIL_HELD)) != 0;
			if (!touched && !is_hollow(front, at))
				continue;
			struct lane *lane = &front->lanes[lane_of(front, soil_laying_place(&front->frame, x, y, 1))];
			const int32_t ahead = soil_laying_place(&front->frame, x, y, 0);
			lane->gives += touched ? ((int64_t)front->carried[at] * field->laying->pushed) >> 16 : 0;
			lane->ends = ahead > lane->ends ? ahead : lane->ends;
			lane->posts++;
		}
}

/* Tells whether lanes exchange soil. */
static bool beside(const struct front *front, int a, int b)
{
	return b >= 0 && b < front->count && front->lanes[a].posts > 0 && front->lanes[b].posts > 0 &&
	       llabs((long long)front->lanes[a].ends - front->lanes[b].ends) <= NEAR_ENDS;
}

/* Each lane gives a quarter of its soil to each lane beside it. */
static void smooth(struct front *front, int64_t *gets)
{
	for (int i = 0; i < front->count; i++)
		gets[i] = 0;
	for (int i = 0; i < front->count; i++) {
		const int64_t part = front->lanes[i].gives / 4, left = beside(front, i, i - 1) ? part : 0, right = beside(front, i, i + 1) ? part : 0;
		gets[i] += front->lanes[i].gives - left - right;
		if (left > 0)
			gets[i - 1] += left;
		if (right > 0)
			gets[i + 1] += right;
	}
	for (int i = 0; i < front->count; i++)
		front->lanes[i].gives = gets[i];
}

/* Adds the post at x, y if it is a free one of the lane. */
static void add_post(const struct front *front, int lane, int64_t x, int64_t y, struct lane_post *posts, int *count)
{
	const struct laying_field *field = front->field;
	const int64_t column = x - field->x0, row = y - field->y0;
	if (column < 0 || row < 0 || column >= field->width || row >= field->height || *count == LANE_POSTS)
		return;
	const int32_t far = soil_laying_place(&front->frame, x, y, 0) - front->lanes[lane].ends;
	if (far <= 0 || far > front->reaches || lane_of(front, soil_laying_place(&front->frame, x, y, 1)) != lane)
		return;
	const size_t at = (size_t)row * field->stride + (size_t)column;
	if ((field->contact[at] & (SOIL_LOWERED | SOIL_HELD)) != 0 || is_hollow(front, at) || field->base[at] == BASE_NODATA)
		return;
	const int64_t height = 4 * (int64_t)field->base[at] + front->offset[at];
	posts[(*count)++] = (struct lane_post){height + ((front->fall * (far - HALF_POST)) >> 16), (int32_t)at, (int32_t)row, (int32_t)column};
}

/* Lists the free posts of a lane ahead of its patch. */
static int find_posts(const struct front *front, int lane, struct lane_post posts[LANE_POSTS])
{
	const struct soil_laying *frame = &front->frame;
	const int along = abs(frame->axis[0]) < abs(frame->axis[1]); /* 1: row by row; 0: column by column */
	const double axis[2] = {frame->axis[0], frame->axis[1]}, by = 1 / (axis[0] * axis[0] + axis[1] * axis[1]);
	const double middle = ((double)(front->first + lane) + 0.5) * 65536 - frame->at[1];
	const int64_t from[2] = {frame->x, frame->y};
	const double first = (double)front->lanes[lane].ends - frame->at[0], last = first + front->reaches;
	/* Where the middle of the lane begins and ends, posts from the frame's. */
	const double aside[2] = {-axis[1] * middle * by, axis[0] * middle * by}, near = axis[along] * first * by + aside[along], far = axis[along] * last * by + aside[along];
	const int64_t low = (int64_t)floor(fmin(near, far)) - 1, high = (int64_t)ceil(fmax(near, far)) + 1;
	int count = 0;
	for (int64_t line = low; line <= high; line++) {
		const double ahead = ((double)line - aside[along]) / (axis[along] * by), cross = axis[1 - along] * ahead * by + aside[1 - along];
		const int64_t middle_post = (int64_t)floor(cross);
		for (int64_t other = middle_post - 1; other <= middle_post + 2; other++)
			add_post(front, lane, from[0] + (along ? other : line), from[1] + (along ? line : other), posts, &count);
	}
	return count;
}

static int64_t filled(const struct lane_post *posts, int count, int64_t level)
{
	int64_t sum = 0;
	for (int i = 0; i < count; i++)
		sum += level > posts[i].key ? level - posts[i].key : 0;
	return sum;
}

/* Returns how high the ground is where the patch of a lane ends, without the heap ahead of the body. It is as far above or below the base as the lowest post of the
 * lane. */
static int64_t ground_of(const struct front *front, const struct lane_post *posts, int count)
{
	int64_t nearest = INT64_MAX, base = 0, above = INT64_MAX;
	for (int i = 0; i < count; i++) {
		const int64_t at = 4 * (int64_t)front->field->base[posts[i].at], offset = front->offset[posts[i].at], far = posts[i].key - at - offset;
		base = far < nearest ? at : base;
		nearest = lesser(far, nearest);
		above = lesser(offset, above);
	}
	return base + above;
}

/* Returns how much soil a lane takes up to so much above the lower envelope and the ground, where its patch ends. */
static int64_t room_of(const struct front *front, int lane, int64_t high)
{
	struct lane_post posts[LANE_POSTS];
	const int count = find_posts(front, lane, posts);
	if (count == 0)
		return 0;
	const int64_t ground = ground_of(front, posts, count);
	return filled(posts, count, (ground > front->highest ? ground : front->highest) + high);
}

/* Finds the rooms of lanes beside each other, from the first to the last. A heap falls to the ends of the front, so that it stays ahead of the body. Beside the trailing
 * end of an oblique front it need not: there soil flows off. */
static void find_rooms(struct front *front, int first, int last)
{
	for (int i = first; i <= last; i++) {
		const double right = (i - first + 0.5) / (1 - front->oblique[0]), left = (last - i + 0.5) / (1 - front->oblique[1]);
		const int64_t high = (int64_t)(fmin(fmin(right, left), HIGHEST) * TO_ENDS / ACROSS * (double)front->fall);
		front->lanes[i].room = room_of(front, i, lesser(high, front->field->laying->tall));
	}
}

/* What finds no room in a lane goes to the next one, from each end to the middle, and then beyond. Returns what finds none at all. */
static int64_t fill_rooms(struct front *front, int first, int last, int64_t *takes)
{
	const int middle = first + (last - first) / 2;
	int64_t rest = 0;
	for (int side = 0; side < 2; side++) {
		int64_t comes = 0;
		for (int i = side == 0 ? first : last; side == 0 ? i <= middle : i > middle; i += side == 0 ? 1 : -1) {
			const int64_t all = front->lanes[i].gives + comes;
			takes[i] = lesser(all, front->lanes[i].room);
			comes = all - takes[i];
		}
		rest += comes;
	}
	for (int i = first; i <= last; i++) {
		const int64_t part = lesser(front->lanes[i].room - takes[i], rest);
		rest -= part;
		front->lanes[i].gives = takes[i] + part;
	}
	return rest;
}

/* Keeps heaps from the ends of fronts. */
static void keep_from_ends(struct front *front, int64_t *takes)
{
	for (int first = 0, last; first < front->count; first = last + 1) {
		for (last = first; beside(front, last, last + 1); last++)
			continue;
		if (front->lanes[first].posts == 0)
			continue;
		find_rooms(front, first, last);
		fill_rooms(front, first, last, takes);
	}
}

/* Lays the soil of a lane. Returns what found no room. */
static int64_t lay_lane(const struct front *front, int number, int32_t *deposits, struct soil_lay_result *result)
{
	struct lane_post posts[LANE_POSTS];
	const int count = find_posts(front, number, posts);
	int64_t rest = front->lanes[number].gives;
	if (count == 0)
		return rest;
	int64_t low = INT64_MAX;
	for (int i = 0; i < count; i++)
		low = posts[i].key < low ? posts[i].key : low;
	/* The highest level up to which the soil fills the lane. */
	int64_t high = low + rest + 1;
	for (int halved = 0; halved < DEEPEST && high - low > 1; halved++) {
		const int64_t level = low + (high - low) / 2;
		if (filled(posts, count, level) <= rest)
			low = level;
		else
			high = level;
	}
	int64_t left = rest - filled(posts, count, low);
	for (int i = 0; i < count; i++) {
		int64_t amount = low >= posts[i].key ? low - posts[i].key : 0;
		if (low >= posts[i].key && left > 0) {
			amount++;
			left--;
		}
		amount = amount < LAID_MOST ? amount : LAID_MOST;
		deposits[posts[i].at] = (int32_t)((uint32_t)deposits[posts[i].at] + (uint32_t)amount);
		rest -= amount;
		if (amount > 0)
			result->posts = post_rect_around(result->posts, (struct post_rect){posts[i].column, posts[i].row, posts[i].column + 1, posts[i].row + 1});
	}
	return rest;
}

int64_t soil_lay_front(const struct laying_field *field, const struct soil_measured *measured, const struct soil_laid soils[SOIL_CLASSES],
		       const int32_t *offset, const int32_t *carried, void *scratch, int32_t *deposits, struct soil_lay_result *result, double *left)
{
	struct front front = {.field = field, .offset = offset, .carried = carried, .lanes = scratch};
	double ahead[2];
	across_front(measured, field->laying->push, ahead);
	front.frame = soil_laying_turned(field->laying, ahead);
	front.highest = measured->highest;
	front.reaches = field->laying->widest << 10;
	front.fall = INT64_MAX;
	for (int i = 0; i < SOIL_CLASSES; i++)
		if (measured->classes >> i & 1 && soils[i].fall < front.fall)
			front.fall = soils[i].fall;
	front.fall = (int64_t)(ACROSS * (double)front.fall);
	find_lanes(&front, measured);
	int64_t *gets = (int64_t *)(front.lanes + front.count), laid = 0;
	int wide = 0;
	for (int i = 0; i < front.count; i++)
		wide += front.lanes[i].posts > 0;
	const int64_t smoothings = SMOOTHINGS_LEAST + lesser(2 * wide * wide / (MIXES * MIXES), SMOOTHINGS_MOST);
	for (int64_t i = 0; i < smoothings; i++)
		smooth(&front, gets);
	const double aside = ahead[0] * field->laying->push[1] - ahead[1] * field->laying->push[0]; /* to the left of the front */
	front.oblique[0] = fmin(fmax(aside * FLOWS_OFF, 0), OBLIQUE_MOST);
	front.oblique[1] = fmin(fmax(-aside * FLOWS_OFF, 0), OBLIQUE_MOST);
	keep_from_ends(&front, gets);
	for (int i = 0; i < front.count; i++) {
		if (front.lanes[i].gives == 0)
			continue;
		laid += front.lanes[i].gives - lay_lane(&front, i, deposits, result);
	}
	*left = 0.5 * (1 + front.oblique[1] - front.oblique[0]);
	return laid;
}
