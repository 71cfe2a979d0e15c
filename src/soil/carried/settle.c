/*
 * Soil slides aboard a body, over its edges, and from the ground onto it.
 *
 * An iteration has three parts. Aboard, each pair of neighbouring cells exchanges an eighth of what their difference exceeds the critical one by. It is at most an eighth
 * of what the giver has. All pairs do so at once, as ground slides. Then each cell at an edge exchanges soil with a post: the one beside the body that is nearest to its
 * neighbour. Cells do so one after another, in their order. So do the last units of a cell, which have no eighth. Where soil flies, what leaves the body high above the
 * ground waits in `fell` in place of that.
 */
#include <math.h>
#include <string.h>

#include "soil/carried.h"
#include "soil/shape/body.h"

#define SETTLE_MOST 96          /* iterations of one call */
#define FLOW_MOST (1 << 22)     /* fixed-point units: the most that a pair exchanges */
#define OFFSET_LIMIT ((1 << 30) - (1 << 23))
#define BESIDE 2                /* posts around a cell's place among which one beside the body is looked for */

static const int ways[8][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}, {-1, 0}, {0, -1}, {-1, -1}, {1, -1}}; /* four pairs, and back */

struct settling {
	struct soil_carried *carried;
	const struct soil_pose *pose;
	const struct soil_sliding *rule;   /* NULL: soil is put down, and nothing slides */
	const struct soil_planes *planes;
	int64_t zero;                      /* fixed-point units: of the reference */
	struct post_rect written, changed;
	double c, s;                       /* of the cells' axes */
	int32_t critical[2];
	bool moved;
};

static bool is_covered(const struct soil_carried *carried, long column, long row)
{
	return column >= 0 && row >= 0 && column < carried->side && row < carried->side && carried->tops[row * carried->side + column] != CARRIED_OPEN;
}

/* Tells whether a post lies beside the body: none of the four cells around it is above the body. */
static bool is_beside(const struct settling *st, int64_t x, int64_t y)
{
	const struct soil_carried *carried = st->carried;
	const double east = -(double)soil_body_from_post(st->pose->x, x, carried->spacing), north = -(double)soil_body_from_post(st->pose->y, y, carried->spacing);
	const long column = (long)floor((st->c * east + st->s * north) / carried->spacing) + carried->half;
	const long row = (long)floor((st->c * north - st->s * east) / carried->spacing) + carried->half;
	return !is_covered(carried, column, row) && !is_covered(carried, column + 1, row) && !is_covered(carried, column, row + 1) && !is_covered(carried, column + 1, row + 1);
}

/* Finds the post nearest to a cell's place that may take soil; beside the body if there is one, else below it. -1: there is none. */
static ptrdiff_t post_of(const struct settling *st, int column, int row, int64_t around, bool below)
{
	const struct soil_carried *carried = st->carried;
	const struct soil_planes *planes = st->planes;
	const double along = (column - carried->half) * carried->spacing, across = (row - carried->half) * carried->spacing;
	const double east = st->c * along - st->s * across, north = st->s * along + st->c * across;
	const int64_t x0 = llround((lattice_offset_metres(st->pose->x) + east) / carried->spacing), y0 = llround((lattice_offset_metres(st->pose->y) + north) / carried->spacing);
	ptrdiff_t found = -1;
	double least = INFINITY;
	for (int64_t y = y0 - around; y <= y0 + around; y++)
		for (int64_t x = x0 - around; x <= x0 + around; x++) {
			if (x < st->written.x0 || y < st->written.y0 || x >= st->written.x1 || y >= st->written.y1)
				continue;
			const size_t at = (size_t)(y - planes->rect.y0) * planes->width + (size_t)(x - planes->rect.x0);
			const double apart = hypot((double)-soil_body_from_post(st->pose->x, x, carried->spacing) - east, (double)-soil_body_from_post(st->pose->y, y, carried->spacing) - north);
			if (apart >= least || planes->base[at] == BASE_NODATA || (planes->contact[at] & SOIL_HELD) != 0 || (!below && !is_beside(st, x, y)))
				continue;
			least = apart;
			found = (ptrdiff_t)at;
		}
	return found;
}

static int64_t ground_at(const struct settling *st, ptrdiff_t post)
{
	return st->zero + 4 * (int64_t)st->planes->base[post] + st->planes->offset[post];
}

/* Changes the ground at a post by an amount that fits it. */
static void change_ground(struct settling *st, ptrdiff_t post, int32_t amount)
{
	const struct soil_planes *planes = st->planes;
	const int64_t x = planes->rect.x0 + post % (ptrdiff_t)planes->width, y = planes->rect.y0 + post / (ptrdiff_t)planes->width;
	planes->offset[post] += amount;
	if (planes->deposited != NULL)
		planes->deposited[post] += amount;
	st->changed = post_rect_joined(st->changed, (struct post_rect){x, y, x + 1, y + 1});
	st->moved = true;
}

/* Takes soil off the account of classes: of each class its share. to: NULL, or the account to which that is added. */
static void leave(struct soil_carried *carried, int64_t amount, int64_t to[SOIL_CLASSES])
{
	int64_t rest = amount;
	for (int k = 0; k < SOIL_CLASSES && carried->total > 0; k++) {
		const int64_t part = (int64_t)((long double)carried->classes[k] * (long double)amount / (long double)carried->total);
		const int64_t takes = part < rest ? part : rest;
		carried->classes[k] -= takes;
		rest -= takes;
		if (to != NULL)
			to[k] += takes;
	}
	for (int k = 0; k < SOIL_CLASSES && rest > 0; k++) {
		const int64_t takes = carried->classes[k] < rest ? carried->classes[k] : rest;
		carried->classes[k] -= takes;
		rest -= takes;
		if (to != NULL)
			to[k] += takes;
	}
	carried->total -= amount;
}

/* Tells whether soil flies that leaves the body so high above its centre, over a post. */
static bool flies(const struct settling *st, int64_t from, ptrdiff_t post)
{
	return st->carried->fell != NULL && st->pose->z + from - ground_at(st, post) > lattice_offset(SOIL_FALLS_FROM);
}

/* Lets soil leave a cell into the air. Returns how much does. */
static int32_t fly(struct settling *st, size_t cell, int32_t from, int32_t amount)
{
	struct soil_carried *carried = st->carried;
	const int32_t room = OFFSET_LIMIT - carried->fell[cell], all = amount < room ? amount : room > 0 ? room : 0;
	carried->fell_from[cell] = carried->fell[cell] > 0 && carried->fell_from[cell] > from ? carried->fell_from[cell] : from;
	carried->fell[cell] += all;
	carried->fell_total += all;
	leave(carried, all, carried->fell_classes);
	st->moved |= all > 0;
	return all;
}

/* Returns how much soil a post can take, of an amount. */
static int32_t fits(const struct settling *st, ptrdiff_t post, int32_t amount)
{
	const struct soil_planes *planes = st->planes;
	const int32_t highest = planes->deposited != NULL && planes->deposited[post] > planes->offset[post] ? planes->deposited[post] : planes->offset[post];
	const int32_t room = OFFSET_LIMIT - highest;
	return room <= 0 ? 0 : amount < room ? amount : room;
}

/* Puts soil of a cell on the ground. */
static void put_down(struct settling *st, int column, int row, int32_t *soil)
{
	ptrdiff_t post = -1;
	for (int64_t around = BESIDE; post < 0 && around <= st->carried->side; around *= 4)
		post = post_of(st, column, row, around, false);
	if (post < 0)
		post = post_of(st, column, row, BESIDE, true);
	if (post < 0)
		return;
	/* What the body turned away from was on its surface of before. */
	const size_t cell = (size_t)(row * st->carried->side + column);
	const int32_t from = st->carried->before[cell] != CARRIED_OPEN ? st->carried->before[cell] : 0;
	if (!is_covered(st->carried, column, row) && flies(st, from, post)) {
		*soil -= fly(st, cell, from, *soil);
		return;
	}
	const int32_t falls = fits(st, post, *soil);
	*soil -= falls;
	leave(st->carried, falls, NULL);
	change_ground(st, post, falls);
}

static void put_falls(struct settling *st)
{
	struct soil_carried *carried = st->carried;
	for (int row = 0; row < carried->side; row++)
		for (int column = 0; column < carried->side; column++) {
			int32_t *soil = &carried->falls[row * carried->side + column];
			if (*soil > 0)
				put_down(st, column, row, soil);
		}
}

static int64_t height_of(const struct soil_carried *carried, size_t cell)
{
	return (int64_t)carried->tops[cell] + carried->amounts[cell];
}

/* Returns what slides from the higher of two places. over: what their difference exceeds the critical one by; has: what the higher one can give. */
static int32_t flow_of(const struct settling *st, int64_t over, int64_t has)
{
	if (over <= st->rule->tolerance)
		return 0;
	int64_t amount = (over + 7) >> 3;
	amount = amount < has >> 3 ? amount : has >> 3;
	amount = amount < FLOW_MOST ? amount : FLOW_MOST;
	return amount > 0 ? (int32_t)amount : 0;
}

/* Soil slides between cells above the body. */
static void slide_aboard(struct settling *st)
{
	struct soil_carried *carried = st->carried;
	const int side = carried->side;
	memset(carried->changes, 0, (size_t)side * (size_t)side * sizeof *carried->changes);
	for (int row = 0; row < side; row++)
		for (int column = 0; column < side; column++) {
			const size_t a = (size_t)(row * side + column);
			if (carried->tops[a] == CARRIED_OPEN)
				continue;
			for (int k = 0; k < 4; k++) {
				if (!is_covered(carried, column + ways[k][0], row + ways[k][1]))
					continue;
				const size_t b = (size_t)((row + ways[k][1]) * side + column + ways[k][0]);
				if (carried->amounts[a] < 8 && carried->amounts[b] < 8)
					continue;
				const int64_t apart = height_of(carried, a) - height_of(carried, b);
				const size_t high = apart > 0 ? a : b, low = apart > 0 ? b : a;
				const int32_t flow = flow_of(st, (apart > 0 ? apart : -apart) - st->critical[k > 1], carried->amounts[high]);
				carried->changes[high] -= flow;
				carried->changes[low] += flow;
				st->moved |= flow > 0;
			}
		}
	for (size_t i = 0; i < (size_t)side * (size_t)side; i++)
		carried->amounts[i] += carried->changes[i];
}

/* Soil slides between a cell at an edge and a post beside the body. */
static void slide_over(struct settling *st, size_t cell, size_t beside, int diagonal)
{
	struct soil_carried *carried = st->carried;
	const struct soil_planes *planes = st->planes;
	const ptrdiff_t post = carried->posts[beside];
	const int64_t apart = st->pose->z + height_of(carried, cell) - ground_at(st, post);
	if (apart > 0 && flies(st, carried->tops[cell], post)) {
		carried->amounts[cell] -= fly(st, beside, carried->tops[cell], flow_of(st, apart - st->critical[diagonal], carried->amounts[cell]));
		return;
	}
	if (apart > 0) {
		const int32_t flow = fits(st, post, flow_of(st, apart - st->critical[diagonal], carried->amounts[cell]));
		if (flow == 0)
			return;
		carried->amounts[cell] -= flow;
		leave(carried, flow, NULL);
		change_ground(st, post, flow);
		return;
	}
	/* Relaxing soil may have a bottom. */
	const int64_t loose = st->rule->bounded ? (int64_t)(planes->deposited != NULL ? planes->deposited[post] : 0) + st->rule->depth : INT32_MAX;
	const int32_t flow = flow_of(st, -apart - st->critical[diagonal], loose), class = planes->classes != NULL ? planes->classes[post] : 0;
	if (flow == 0 || planes->offset[post] < -OFFSET_LIMIT || carried->amounts[cell] > OFFSET_LIMIT)
		return;
	carried->amounts[cell] += flow;
	carried->total += flow;
	carried->classes[class < SOIL_CLASSES ? class : SOIL_CLASSES - 1] += flow;
	change_ground(st, post, -flow);
}

static void slide_edges(struct settling *st)
{
	const struct soil_carried *carried = st->carried;
	const int side = carried->side;
	for (int row = 1; row + 1 < side; row++)
		for (int column = 1; column + 1 < side; column++) {
			const size_t cell = (size_t)(row * side + column);
			if (carried->tops[cell] == CARRIED_OPEN)
				continue;
			for (int k = 0; k < 8; k++) {
				const size_t beside = (size_t)((row + ways[k][1]) * side + column + ways[k][0]);
				if (carried->tops[beside] == CARRIED_OPEN && carried->posts[beside] >= 0)
					slide_over(st, cell, beside, ways[k][0] != 0 && ways[k][1] != 0);
			}
		}
}

/* The last seven units of a cell, which have no eighth, go to its lowest neighbour if that is too steep. */
static void slide_crumbs(struct settling *st)
{
	struct soil_carried *carried = st->carried;
	const int side = carried->side;
	for (int row = 1; row + 1 < side; row++)
		for (int column = 1; column + 1 < side; column++) {
			const size_t cell = (size_t)(row * side + column);
			int64_t most = st->rule->tolerance;
			int lowest = -1;
			if (carried->tops[cell] == CARRIED_OPEN || carried->amounts[cell] == 0 || carried->amounts[cell] >= 8)
				continue;
			for (int k = 0; k < 8; k++) {
				const size_t beside = (size_t)((row + ways[k][1]) * side + column + ways[k][0]);
				const bool open = carried->tops[beside] == CARRIED_OPEN;
				if (open && carried->posts[beside] < 0)
					continue;
				const int64_t low = open ? ground_at(st, carried->posts[beside]) - st->pose->z : height_of(carried, beside);
				const int64_t over = height_of(carried, cell) - low - st->critical[ways[k][0] != 0 && ways[k][1] != 0];
				lowest = over > most ? k : lowest;
				most = over > most ? over : most;
			}
			if (lowest < 0)
				continue;
			const size_t to = (size_t)((row + ways[lowest][1]) * side + column + ways[lowest][0]);
			const bool open = carried->tops[to] == CARRIED_OPEN;
			if (open && flies(st, carried->tops[cell], carried->posts[to])) {
				carried->amounts[cell] -= fly(st, to, carried->tops[cell], carried->amounts[cell]);
				continue;
			}
			const int32_t all = open ? fits(st, carried->posts[to], carried->amounts[cell]) : carried->amounts[cell];
			carried->amounts[cell] -= all;
			if (open && all > 0) {
				leave(carried, all, NULL);
				change_ground(st, carried->posts[to], all);
			} else {
				carried->amounts[to] += open ? 0 : all;
			}
			st->moved |= all > 0;
		}
}

/* Finds the posts with which cells around the body exchange soil. */
static void find_posts(struct settling *st)
{
	const struct soil_carried *carried = st->carried;
	for (int row = 0; row < carried->side; row++)
		for (int column = 0; column < carried->side; column++) {
			const size_t cell = (size_t)(row * carried->side + column);
			bool edge = false;
			for (int k = 0; k < 8 && carried->tops[cell] == CARRIED_OPEN && !edge; k++)
				edge = is_covered(carried, column + ways[k][0], row + ways[k][1]);
			carried->posts[cell] = edge ? post_of(st, column, row, BESIDE, false) : -1;
		}
}

static struct settling begin(struct soil_carried *carried, const struct soil_pose *pose, const struct soil_planes *planes, int32_t reference, struct post_rect written)
{
	const double heading = pose->yaw + carried->heading;
	return (struct settling){
		.carried = carried, .pose = pose, .planes = planes, .zero = (int64_t)reference * ((int64_t)1 << OFFSET_BITS), .written = post_rect_intersect(written, planes->rect),
		.c = cos(heading), .s = sin(heading), .changed = {0, 0, 0, 0},
	};
}

struct post_rect soil_carried_reach(const struct soil_carried *carried, const struct soil_pose *pose)
{
	return post_rect_grown(soil_shadow(carried->shape, pose, pose, carried->spacing), BESIDE + 3);
}

struct post_rect soil_carried_settle(struct soil_carried *carried, const struct soil_pose *pose, const struct soil_sliding *rule, const struct soil_planes *planes, int32_t reference,
				     struct post_rect written)
{
	struct settling st = begin(carried, pose, planes, reference, written);
	int most = 0;
	for (int k = 1; k < rule->class_count; k++)
		most = carried->classes[k] > carried->classes[most] ? k : most;
	st.rule = rule;
	st.critical[0] = rule->classes[most].critical[0];
	st.critical[1] = rule->classes[most].critical[1];
	put_falls(&st);
	find_posts(&st);
	for (int i = 0; i < SETTLE_MOST; i++) {
		st.moved = false;
		slide_aboard(&st);
		slide_edges(&st);
		slide_crumbs(&st);
		if (!st.moved)
			break;
	}
	carried->unsettled = st.moved;
	return st.changed;
}

struct post_rect soil_carried_drop(struct soil_carried *carried, const struct soil_pose *pose, const struct soil_planes *planes, int32_t reference, struct post_rect written)
{
	struct settling st = begin(carried, pose, planes, reference, written);
	for (int row = 0; row < carried->side; row++)
		for (int column = 0; column < carried->side; column++) {
			const size_t cell = (size_t)(row * carried->side + column);
			for (int k = 0; k < 2; k++) {
				int32_t *soil = k == 0 ? &carried->falls[cell] : &carried->amounts[cell];
				const ptrdiff_t post = *soil > 0 ? post_of(&st, column, row, 1, true) : -1;
				const int32_t from = carried->tops[cell] != CARRIED_OPEN ? carried->tops[cell] : 0;
				if (post >= 0 && flies(&st, from, post)) {
					*soil -= fly(&st, cell, from, *soil);
					continue;
				}
				const int32_t falls = post >= 0 ? fits(&st, post, *soil) : 0;
				if (falls == 0)
					continue;
				*soil -= falls;
				leave(carried, falls, NULL);
				change_ground(&st, post, falls);
			}
		}
	carried->unsettled = false;
	return st.changed;
}
