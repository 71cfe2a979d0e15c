/*
 * Soil slides aboard a body, over its edges, and from the ground onto it.
 *
 * An iteration has three parts. Aboard, each pair of neighbouring cells exchanges an eighth of what their difference exceeds the critical one by. It is at most an eighth
 * of what the giver has. All pairs do so at once, as ground slides. Then each cell at an edge exchanges soil with what is beside it. That is a cell of another body that
 * carries, if one is below. Else it is the post beside the body that is nearest to its neighbour. Cells do so one after another, in their order. So do the last units of a cell, which have no eighth.
 *
 * Where only a share of a cell is above the body, its middle is nearer to its neighbours and to its edge. So the critical difference is less in proportion. Beside
 * a wall, what exceeds the sill counts, too: only that passes over it.
 * Where soil flies, what leaves the body high above what is below waits in `fell` in place of that.
 */
#include <math.h>
#include <string.h>

#include "soil/carried/around.h"
#include "soil/carried/tops.h"
#include "soil/shape/body.h"

#define SETTLE_MOST 96          /* iterations of one call */
#define REST_BITS 8             /* a slope may be steeper by this binary part of the critical one */
#define FLOW_MOST (1 << 22)     /* fixed-point units: the most that a pair exchanges */
#define OFFSET_LIMIT ((1 << 30) - (1 << 23))
#define BESIDE 2                /* posts around a cell's place among which one beside the body is looked for */

static const int ways[8][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}, {-1, 0}, {0, -1}, {-1, -1}, {1, -1}}; /* four pairs, and back */

struct settling {
	struct soil_carried *carried;
	const struct soil_pose *pose;
	const struct soil_sliding *rule;   /* NULL: soil is put down, and nothing slides */
	const struct soil_planes *planes;
	const struct soil_carried_around *around;
	int64_t zero;                      /* fixed-point units: of the reference */
	struct post_rect written, changed;
	double c, s;                       /* of the cells' axes */
	int32_t critical[2];
	int32_t rest;                      /* what exceeds the critical difference by no more stays: else the last millimetre takes thousands of iterations */
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

/* What is beside a cell: a post, or a cell of another body as BELOW_OF (number of the body, cell). NOTHING: neither. */
#define NOTHING (-1)
#define OTHERS 32 /* bits of a cell's number */

static ptrdiff_t below_of(size_t other, size_t cell)
{
	return -2 - (ptrdiff_t)((other << OTHERS) | cell);
}

static const struct soil_carried_other *other_of(const struct settling *st, ptrdiff_t beside, size_t *cell)
{
	const size_t code = (size_t)(-2 - beside);
	*cell = code & (((size_t)1 << OTHERS) - 1);
	return &st->around->others[code >> OTHERS];
}

/* Finds the highest cell of another body below a cell's place, whose top is below a height. */
static ptrdiff_t other_below(const struct settling *st, int column, int row, int64_t height)
{
	const struct soil_carried *carried = st->carried;
	const double along = (column - carried->half) * carried->spacing, across = (row - carried->half) * carried->spacing;
	const int64_t x = st->pose->x + lattice_offset(st->c * along - st->s * across), y = st->pose->y + lattice_offset(st->s * along + st->c * across);
	ptrdiff_t found = NOTHING;
	int64_t highest = INT64_MIN;
	for (size_t i = 0; i < st->around->other_count; i++) {
		const struct soil_carried_other *other = &st->around->others[i];
		size_t cell;
		if (!soil_carried_cell(other->carried, &other->pose, x, y, &cell) || other->carried->tops[cell] == CARRIED_OPEN)
			continue;
		const int64_t top = other->pose.z + other->carried->tops[cell];
		if (top >= height || top <= highest)
			continue;
		highest = top;
		found = below_of(i, cell);
	}
	return found;
}

/* Returns the height of what is beside a cell. */
static int64_t height_beside(const struct settling *st, ptrdiff_t beside)
{
	size_t cell;
	if (beside < NOTHING) {
		const struct soil_carried_other *other = other_of(st, beside, &cell);
		return other->pose.z + soil_carried_height(other->carried, cell);
	}
	return st->zero + 4 * (int64_t)st->planes->base[beside] + st->planes->offset[beside];
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

/* Tells whether soil flies that leaves the body so high above its centre, over what is beside. */
static bool flies(const struct settling *st, int64_t from, ptrdiff_t beside)
{
	return st->carried->fell != NULL && st->pose->z + from - height_beside(st, beside) > lattice_offset(SOIL_FALLS_FROM);
}

/* Lets soil leave a cell into the air. Returns how much does. */
static int32_t fly(struct settling *st, size_t cell, int64_t from, int32_t amount)
{
	struct soil_carried *carried = st->carried;
	const int32_t room = OFFSET_LIMIT - carried->fell[cell], all = amount < room ? amount : room > 0 ? room : 0;
	carried->fell_from[cell] = carried->fell[cell] > 0 && carried->fell_from[cell] > from ? carried->fell_from[cell] : (int32_t)from;
	carried->fell[cell] += all;
	carried->fell_total += all;
	leave(carried, all, carried->fell_classes);
	st->moved |= all > 0;
	return all;
}

/* Returns how high above the body's centre soil of a cell leaves the body. */
static int32_t leaves_from(const struct soil_carried *carried, size_t cell)
{
	const struct soil_carried_cells *cells = carried->scratch;
	return cells->lips[cell] != CARRIED_OPEN ? cells->lips[cell] : carried->tops[cell] != CARRIED_OPEN ? carried->tops[cell] : 0;
}

/* Gives soil of this body to what is beside a cell. */
static void give(struct settling *st, ptrdiff_t beside, int32_t amount)
{
	size_t cell;
	if (beside > NOTHING) {
		leave(st->carried, amount, NULL);
		change_ground(st, beside, amount);
		return;
	}
	const struct soil_carried_other *other = other_of(st, beside, &cell);
	leave(st->carried, amount, other->carried->classes);
	other->carried->total += amount;
	other->carried->unsettled = true;
	other->carried->amounts[cell] += amount;
	st->moved = true;
}

/* Returns how much soil a post, or a cell of another body, can take of an amount. */
static int32_t fits(const struct settling *st, ptrdiff_t post, int32_t amount)
{
	const struct soil_planes *planes = st->planes;
	size_t cell;
	if (post < NOTHING) {
		const struct soil_carried_other *other = other_of(st, post, &cell);
		const int32_t left = CARRIED_MOST - other->carried->amounts[cell];
		return left <= 0 ? 0 : amount < left ? amount : left;
	}
	const int32_t highest = planes->deposited != NULL && planes->deposited[post] > planes->offset[post] ? planes->deposited[post] : planes->offset[post];
	const int32_t room = OFFSET_LIMIT - highest;
	return room <= 0 ? 0 : amount < room ? amount : room;
}

/* Puts soil of a cell on what is below it. */
static void put_down(struct settling *st, int column, int row, int32_t *soil)
{
	const int64_t above = st->pose->z + lattice_offset(soil_shape_bound(st->carried->shape));
	ptrdiff_t below = other_below(st, column, row, above);
	for (int64_t around = BESIDE; below == NOTHING && around <= st->carried->side; around *= 4)
		below = post_of(st, column, row, around, false);
	if (below == NOTHING)
		below = post_of(st, column, row, BESIDE, true);
	if (below == NOTHING)
		return;
	/* What the body turned away from was on its surface of before. */
	const size_t cell = (size_t)(row * st->carried->side + column);
	const int32_t from = st->carried->before[cell] != CARRIED_OPEN ? st->carried->before[cell] : 0;
	if (!is_covered(st->carried, column, row) && flies(st, from, below)) {
		*soil -= fly(st, cell, from, *soil);
		return;
	}
	const int32_t falls = fits(st, below, *soil);
	*soil -= falls;
	give(st, below, falls);
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

/* Returns what slides from the higher of two places. over: what their difference exceeds the critical one by; share: of a cell that it fills; has: what the higher one
 * can give. */
static int32_t flow_of(const struct settling *st, int64_t over, int share, int64_t has)
{
	if (over <= st->rest)
		return 0;
	int64_t amount = ((over + 7) >> 3) * share / CARRIED_SHARES;
	amount = amount < has >> 3 ? amount : has >> 3;
	amount = amount < FLOW_MOST ? amount : FLOW_MOST;
	return amount > 0 ? (int32_t)amount : 0;
}

/* Returns the critical difference over a distance, of 2 CARRIED_SHARES. */
static int64_t critical_of(const struct settling *st, bool diagonal, int distance)
{
	return (int64_t)st->critical[diagonal] * distance / (2 * CARRIED_SHARES);
}

/* Returns by how much a cell is too steep beside its neighbour: `way` and back, of the table above. */
static int64_t excess(const struct settling *st, size_t high, size_t low, size_t pair, int way)
{
	const struct soil_carried *carried = st->carried;
	const struct soil_carried_cells *cells = carried->scratch;
	const int64_t height = soil_carried_height(carried, high);
	const int64_t over = height - soil_carried_height(carried, low) - critical_of(st, (way & 3) > 1, cells->shares[high] + cells->shares[low]);
	const int32_t sill = cells->sills[way & 3][pair];
	if (sill == CARRIED_OPEN)
		return over;
	const int64_t above = height - sill - critical_of(st, (way & 3) > 1, cells->shares[high]);
	return over < above ? over : above;
}

/* Returns by how much a cell is too steep beside what is beside the body: above 0: it gives, below 0: it gets. */
static int64_t excess_beside(const struct settling *st, size_t cell, ptrdiff_t beside, bool diagonal)
{
	const struct soil_carried *carried = st->carried;
	const struct soil_carried_cells *cells = carried->scratch;
	const int64_t height = st->pose->z + soil_carried_height(carried, cell), ground = height_beside(st, beside), lip = st->pose->z + cells->lips[cell];
	if (height > ground) {
		const int64_t over = height - ground - st->critical[diagonal], above = height - lip - critical_of(st, diagonal, cells->shares[cell]);
		return over < above ? over : above > 0 ? above : 0;
	}
	const int64_t over = ground - height - st->critical[diagonal], above = ground - lip;
	return over < above ? (over > 0 ? -over : 0) : above > 0 ? -above : 0;
}

/* Soil slides between cells above the body. */
static void slide_aboard(struct settling *st)
{
	struct soil_carried *carried = st->carried;
	const struct soil_carried_cells *cells = carried->scratch;
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
				const bool down = soil_carried_height(carried, a) > soil_carried_height(carried, b);
				const size_t high = down ? a : b, low = down ? b : a;
				const int share = cells->shares[a] < cells->shares[b] ? cells->shares[a] : cells->shares[b];
				const int32_t flow = flow_of(st, excess(st, high, low, a, k), share, carried->amounts[high]);
				carried->changes[high] -= flow;
				carried->changes[low] += flow;
				st->moved |= flow > 0;
			}
		}
	for (size_t i = 0; i < (size_t)side * (size_t)side; i++)
		carried->amounts[i] += carried->changes[i];
}

/* Soil slides between a cell at an edge and what is beside the body. */
static void slide_over(struct settling *st, size_t cell, size_t to, bool diagonal)
{
	struct soil_carried *carried = st->carried;
	const struct soil_carried_cells *cells = carried->scratch;
	const struct soil_planes *planes = st->planes;
	const ptrdiff_t beside = carried->posts[to];
	const int64_t over = excess_beside(st, cell, beside, diagonal);
	if (over > 0 && flies(st, leaves_from(carried, cell), beside)) {
		carried->amounts[cell] -= fly(st, to, leaves_from(carried, cell), flow_of(st, over, cells->shares[cell], carried->amounts[cell]));
		return;
	}
	if (over > 0) {
		const int32_t flow = fits(st, beside, flow_of(st, over, cells->shares[cell], carried->amounts[cell]));
		if (flow == 0)
			return;
		carried->amounts[cell] -= flow;
		give(st, beside, flow);
		return;
	}
	if (over == 0 || beside < NOTHING) /* the other body gives by itself */
		return;
	/* Relaxing soil may have a bottom. */
	const int64_t loose = st->rule->bounded ? (int64_t)(planes->deposited != NULL ? planes->deposited[beside] : 0) + st->rule->depth : INT32_MAX;
	const int32_t flow = flow_of(st, -over, cells->shares[cell], loose), class = planes->classes != NULL ? planes->classes[beside] : 0;
	if (flow == 0 || planes->offset[beside] < -OFFSET_LIMIT || carried->amounts[cell] > OFFSET_LIMIT)
		return;
	carried->amounts[cell] += flow;
	carried->total += flow;
	carried->classes[class < SOIL_CLASSES ? class : SOIL_CLASSES - 1] += flow;
	change_ground(st, beside, -flow);
}

static void slide_edges(struct settling *st)
{
	const struct soil_carried *carried = st->carried;
	const struct soil_carried_cells *cells = carried->scratch;
	const int side = carried->side;
	for (int row = 1; row + 1 < side; row++)
		for (int column = 1; column + 1 < side; column++) {
			const size_t cell = (size_t)(row * side + column);
			if (carried->tops[cell] == CARRIED_OPEN || cells->lips[cell] == CARRIED_OPEN)
				continue;
			for (int k = 0; k < 8; k++) {
				const size_t beside = (size_t)((row + ways[k][1]) * side + column + ways[k][0]);
				if (carried->tops[beside] == CARRIED_OPEN && carried->posts[beside] != NOTHING)
					slide_over(st, cell, beside, ways[k][0] != 0 && ways[k][1] != 0);
			}
		}
}

/* The last seven units of a cell, which have no eighth, go to its lowest neighbour if that is too steep. */
static void slide_crumbs(struct settling *st)
{
	struct soil_carried *carried = st->carried;
	const struct soil_carried_cells *cells = carried->scratch;
	const int side = carried->side;
	for (int row = 1; row + 1 < side; row++)
		for (int column = 1; column + 1 < side; column++) {
			const size_t cell = (size_t)(row * side + column);
			int64_t most = st->rest;
			int lowest = -1;
			if (carried->tops[cell] == CARRIED_OPEN || carried->amounts[cell] == 0 || carried->amounts[cell] >= 8)
				continue;
			for (int k = 0; k < 8; k++) {
				const size_t beside = (size_t)((row + ways[k][1]) * side + column + ways[k][0]);
				const bool open = carried->tops[beside] == CARRIED_OPEN;
				if (open && (cells->lips[cell] == CARRIED_OPEN || carried->posts[beside] == NOTHING || st->around->alone))
					continue;
				const int64_t over = open ? excess_beside(st, cell, carried->posts[beside], ways[k][0] != 0 && ways[k][1] != 0) : excess(st, cell, beside, k < 4 ? cell : beside, k);
				/* Where little of a cell is above the body, few units are high: they must not go to and fro. */
				const int shares = open || cells->shares[beside] > cells->shares[cell] ? cells->shares[cell] : cells->shares[beside];
				if (over < (int64_t)2 * carried->amounts[cell] * CARRIED_SHARES / shares)
					continue;
				lowest = over > most ? k : lowest;
				most = over > most ? over : most;
			}
			if (lowest < 0)
				continue;
			const size_t to = (size_t)((row + ways[lowest][1]) * side + column + ways[lowest][0]);
			const bool open = carried->tops[to] == CARRIED_OPEN;
			if (open && flies(st, leaves_from(carried, cell), carried->posts[to])) {
				carried->amounts[cell] -= fly(st, to, leaves_from(carried, cell), carried->amounts[cell]);
				continue;
			}
			const int32_t all = open ? fits(st, carried->posts[to], carried->amounts[cell]) : carried->amounts[cell];
			carried->amounts[cell] -= all;
			if (open && all > 0)
				give(st, carried->posts[to], all);
			else
				carried->amounts[to] += open ? 0 : all;
			st->moved |= all > 0;
		}
}

/* Finds with what cells around the body exchange soil. */
static void find_posts(struct settling *st)
{
	const struct soil_carried *carried = st->carried;
	for (int row = 0; row < carried->side; row++)
		for (int column = 0; column < carried->side; column++) {
			const size_t cell = (size_t)(row * carried->side + column);
			int64_t top = INT64_MIN;
			for (int k = 0; k < 8 && carried->tops[cell] == CARRIED_OPEN; k++)
				if (is_covered(carried, column + ways[k][0], row + ways[k][1])) {
					const int32_t beside = carried->tops[(row + ways[k][1]) * carried->side + column + ways[k][0]];
					top = beside > top ? beside : top;
				}
			carried->posts[cell] = top > INT64_MIN ? other_below(st, column, row, st->pose->z + top) : NOTHING;
			if (top > INT64_MIN && carried->posts[cell] == NOTHING)
				carried->posts[cell] = post_of(st, column, row, BESIDE, false);
		}
}

static struct settling begin(struct soil_carried *carried, const struct soil_pose *pose, const struct soil_carried_around *around)
{
	const double heading = pose->yaw + carried->heading;
	return (struct settling){
		.carried = carried, .pose = pose, .planes = around->planes, .around = around, .zero = (int64_t)around->reference * ((int64_t)1 << OFFSET_BITS),
		.written = post_rect_intersect(around->written, around->planes->rect), .c = cos(heading), .s = sin(heading), .changed = {0, 0, 0, 0},
	};
}

struct post_rect soil_carried_reach(const struct soil_carried *carried, const struct soil_pose *pose)
{
	return post_rect_grown(soil_shadow(carried->shape, pose, pose, carried->spacing), BESIDE + 3);
}

struct post_rect soil_carried_settle_among(struct soil_carried *carried, const struct soil_pose *pose, const struct soil_sliding *rule, const struct soil_carried_around *around)
{
	struct settling st = begin(carried, pose, around);
	int most = 0;
	for (int k = 1; k < rule->class_count; k++)
		most = carried->classes[k] > carried->classes[most] ? k : most;
	st.rule = rule;
	st.critical[0] = rule->classes[most].critical[0];
	st.critical[1] = rule->classes[most].critical[1];
	st.rest = st.critical[0] >> REST_BITS > rule->tolerance ? st.critical[0] >> REST_BITS : rule->tolerance;
	if (!around->alone) {
		put_falls(&st);
		find_posts(&st);
	}
	for (int i = 0; i < SETTLE_MOST; i++) {
		st.moved = false;
		slide_aboard(&st);
		if (!around->alone)
			slide_edges(&st);
		slide_crumbs(&st);
		if (!st.moved)
			break;
	}
	carried->unsettled = st.moved || (around->alone && carried->total > 0);
	return st.changed;
}

struct post_rect soil_carried_drop_among(struct soil_carried *carried, const struct soil_pose *pose, const struct soil_carried_around *around)
{
	struct settling st = begin(carried, pose, around);
	for (int row = 0; row < carried->side; row++)
		for (int column = 0; column < carried->side; column++) {
			const size_t cell = (size_t)(row * carried->side + column);
			for (int k = 0; k < 2; k++) {
				int32_t *soil = k == 0 ? &carried->falls[cell] : &carried->amounts[cell];
				if (*soil == 0)
					continue;
				ptrdiff_t below = other_below(&st, column, row, st.pose->z + lattice_offset(soil_shape_bound(carried->shape)));
				below = below == NOTHING ? post_of(&st, column, row, 1, true) : below;
				if (below != NOTHING && flies(&st, leaves_from(carried, cell), below)) {
					*soil -= fly(&st, cell, leaves_from(carried, cell), *soil);
					continue;
				}
				const int32_t falls = below != NOTHING ? fits(&st, below, *soil) : 0;
				if (falls == 0)
					continue;
				*soil -= falls;
				give(&st, below, falls);
			}
		}
	carried->unsettled = false;
	return st.changed;
}

struct post_rect soil_carried_settle(struct soil_carried *carried, const struct soil_pose *pose, const struct soil_sliding *rule, const struct soil_planes *planes, int32_t reference,
				     struct post_rect written)
{
	return soil_carried_settle_among(carried, pose, rule, &(struct soil_carried_around){.planes = planes, .reference = reference, .written = written});
}

struct post_rect soil_carried_drop(struct soil_carried *carried, const struct soil_pose *pose, const struct soil_planes *planes, int32_t reference, struct post_rect written)
{
	return soil_carried_drop_among(carried, pose, &(struct soil_carried_around){.planes = planes, .reference = reference, .written = written});
}
