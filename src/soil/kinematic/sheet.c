/*
 * A contact of a body with an elastic sheet, over a window. See sheet.h.
 *
 * First the body lets go of what it held at `from`. Where the whole motion goes beyond the yield the sheet's own surface sinks then: a rut. At last the
 * body holds the sheet down at the end of its motion.
 */
#include "soil/kinematic/sheet.h"

#include <string.h>

#include "soil/kinematic/rows.h"
#include "soil/kinematic/sheet_grid.h"
#include "soil/kinematic/under.h"

#define TOUCH 4                /* fixed-point units, as in contact.c */
#define OFFSET_LIMIT (1 << 30)
#define ALIGNED(bytes) (((bytes) + 63) / 64 * 64)

struct post_rect soil_sheet_posts(const struct soil_sheet_contact *contact, int64_t reach, double spacing)
{
	const struct soil_kinematic_contact *body = &contact->body;
	const struct soil_pose *from = &body->from, *to = contact->leaves ? from : &body->to;
	const bool apart = soil_only_set_down(from, to) && (from->x != to->x || from->y != to->y);
	struct post_rect posts = soil_shadow(body->shape, apart ? to : from, to, spacing);
	if (!apart)
		posts = post_rect_around(posts, soil_shadow(body->shape, from, from, spacing));
	/* Others within `reach` of what may change tell whether it does. */
	return post_rect_grown(posts, 2 * reach);
}

/* --- memory --- */

static size_t grid_bytes(size_t width, size_t height)
{
	const size_t posts = (width + 2) * (height + 2);
	return 4 * ALIGNED(posts * sizeof(int32_t)) + ALIGNED(posts) + ALIGNED((width + 2) * sizeof(int32_t));
}

/* A copy of deflections, surfaces and marks. */
static size_t kept_bytes(size_t posts)
{
	return 2 * ALIGNED(posts * sizeof(int32_t)) + ALIGNED(posts);
}

size_t soil_sheet_room(const struct soil_shape *shape, size_t width, size_t height, bool loaded)
{
	const size_t envelope = ALIGNED(soil_under_stride((int64_t)width) * height * sizeof(int32_t));
	const size_t corners = shape->kind == SOIL_MESH ? shape->mesh->vertex_count * sizeof(struct facet_corner) : 0;
	return 64 + grid_bytes(width, height) + 2 * envelope + ALIGNED(corners) + (loaded ? kept_bytes((width + 2) * (height + 2)) : 0);
}

static void *take(char **memory, size_t bytes)
{
	void *taken = *memory;
	*memory += ALIGNED(bytes);
	return taken;
}

/* Places a grid in memory, where all is 0. Returns the memory behind it. */
static char *place(const struct soil_planes *planes, void *scratch, struct sheet_grid *grid)
{
	const size_t width = (size_t)(planes->rect.x1 - planes->rect.x0), height = (size_t)(planes->rect.y1 - planes->rect.y0);
	const size_t stride = width + 2, posts = stride * (height + 2), first = stride + 1;
	char *memory = (char *)(((uintptr_t)scratch + 63) / 64 * 64);
	memset(memory, 0, grid_bytes(width, height));
	*grid = (struct sheet_grid){.width = (int32_t)width, .height = (int32_t)height, .stride = stride, .x0 = planes->rect.x0, .y0 = planes->rect.y0};
	grid->deflection = (int32_t *)take(&memory, posts * sizeof(int32_t)) + first;
	grid->least = (int32_t *)take(&memory, posts * sizeof(int32_t)) + first;
	grid->surface = (int32_t *)take(&memory, posts * sizeof(int32_t)) + first;
	grid->relax = (uint32_t *)take(&memory, posts * sizeof(uint32_t)) + first;
	grid->marks = (uint8_t *)take(&memory, posts) + first;
	grid->row = (int32_t *)take(&memory, stride * sizeof(int32_t)) + 1;
	return memory;
}

/* --- planes --- */

/* Where a post of the grid is, in the grid and in the planes. */
static size_t in_grid(const struct sheet_grid *grid, int64_t x, int64_t y)
{
	return (size_t)(y - grid->y0) * grid->stride + (size_t)(x - grid->x0);
}

static size_t in_planes(const struct soil_planes *planes, int64_t x, int64_t y)
{
	return (size_t)(y - planes->rect.y0) * planes->width + (size_t)(x - planes->rect.x0);
}

/* Takes the sheet from the planes. inside: posts that may change. */
static void unpack(const struct soil_planes *planes, struct post_rect inside, const struct sheet_grid *grid)
{
	for (int64_t y = planes->rect.y0; y < planes->rect.y1; y++)
		for (int64_t x = planes->rect.x0; x < planes->rect.x1; x++) {
			const size_t from = in_planes(planes, x, y), at = in_grid(grid, x, y);
			const bool ground = planes->base[from] != BASE_NODATA;
			const bool in = x >= inside.x0 && x < inside.x1 && y >= inside.y0 && y < inside.y1;
			planes->contact[from] = ground ? 0 : SOIL_NO_GROUND;
			if (!ground)
				continue;
			const int32_t post = planes->floor[from], deflection = lane_clamp(soil_sheet_deflection(post), 0, SOIL_SHEET_MOST - 1);
			grid->marks[at] = (uint8_t)(SHEET_GROUND | (in ? SHEET_INSIDE : 0) | (soil_sheet_held(post) ? SHEET_OTHER : 0));
			grid->surface[at] = lane_clamp(planes->offset[from], -OFFSET_LIMIT, OFFSET_LIMIT) + deflection;
			grid->deflection[at] = deflection << SHEET_BITS;
		}
}

/* Puts the sheet back. */
static void pack(const struct sheet_grid *grid, const struct soil_planes *planes, struct post_rect inside, struct soil_kinematic_tally *tally,
		 struct post_rect *changed)
{
	struct post_rect found = {INT64_MAX, INT64_MAX, INT64_MIN, INT64_MIN};
	for (int64_t y = inside.y0; y < inside.y1; y++)
		for (int64_t x = inside.x0; x < inside.x1; x++) {
			const size_t to = in_planes(planes, x, y), at = in_grid(grid, x, y);
			if (!(grid->marks[at] & SHEET_GROUND))
				continue;
			const int32_t deflection = (grid->deflection[at] + (1 << (SHEET_BITS - 1))) >> SHEET_BITS;
			const int32_t offset = grid->surface[at] - deflection, post = 2 * deflection + ((grid->marks[at] & (SHEET_OTHER | SHEET_OWN)) != 0);
			if (offset == planes->offset[to] && post == planes->floor[to])
				continue;
			tally->compacted += (int64_t)planes->offset[to] - offset;
			planes->offset[to] = offset;
			planes->floor[to] = post;
			found = post_rect_around(found, (struct post_rect){x, y, x + 1, y + 1});
		}
	*changed = found.x0 < found.x1 ? found : (struct post_rect){inside.x0, inside.y0, inside.x0, inside.y0};
}

/* --- the body --- */

/* The posts below a body, and its lower envelopes there: heights above `height`, fixed-point units. */
struct below {
	struct post_rect posts;
	size_t stride;
	int32_t *under, *rest;
	int64_t zero; /* that height, above the store's reference */
};

static void envelope(const struct soil_kinematic *kinematic, const struct soil_kinematic_contact *body, const struct soil_pose *from, const struct soil_pose *to,
		     const struct soil_planes *planes, char *memory, struct below *below)
{
	const struct under_motion motion = {.shape = body->shape, .from = from, .to = to, .turned = body->turned, .spacing = kinematic->spacing,
					    .posts = post_rect_intersect(soil_shadow(body->shape, from, to, kinematic->spacing), planes->rect)};
	const struct post_rect posts = motion.posts;
	*below = (struct below){.posts = posts, .zero = to->z - (int64_t)kinematic->reference * (1 << OFFSET_BITS)};
	if (post_rect_empty(posts))
		return;
	below->stride = soil_under_stride(posts.x1 - posts.x0);
	const size_t bytes = below->stride * (size_t)(posts.y1 - posts.y0) * sizeof(int32_t);
	below->under = take(&memory, bytes);
	below->rest = take(&memory, bytes);
	soil_under(&motion, (struct facet_corner *)(void *)memory, below->under, below->rest);
}

/* Returns how far an envelope is below a height above the base, `offset`, fixed-point units; at most what fits. */
static int64_t depth_below(const struct below *below, const struct soil_planes *planes, const int32_t *heights, int64_t x, int64_t y, int32_t offset)
{
	const int32_t height = heights[(size_t)(y - below->posts.y0) * below->stride + (size_t)(x - below->posts.x0)];
	const int64_t ground = (int64_t)planes->base[in_planes(planes, x, y)] * 4 - below->zero;
	return height == UNDER_NONE ? INT64_MIN : ground + offset - height;
}

/* Frees the posts that the body held at the end of its last motion: its envelope is below the sheet's own surface there. */
static void let_go(const struct below *below, const struct soil_planes *planes, const struct sheet_grid *grid)
{
	for (int64_t y = below->posts.y0; y < below->posts.y1; y++)
		for (int64_t x = below->posts.x0; x < below->posts.x1; x++) {
			const size_t at = in_grid(grid, x, y);
			if ((grid->marks[at] & (SHEET_OTHER | SHEET_INSIDE)) == (SHEET_OTHER | SHEET_INSIDE) &&
			    depth_below(below, planes, below->rest, x, y, grid->surface[at]) >= -TOUCH)
				grid->marks[at] &= (uint8_t)~SHEET_OTHER;
		}
}

/* Holds the sheet down to the envelope of the body at the end of its motion. */
static void push(const struct below *below, const struct soil_planes *planes, const struct sheet_grid *grid, struct soil_kinematic_tally *tally)
{
	for (int64_t y = below->posts.y0; y < below->posts.y1; y++)
		for (int64_t x = below->posts.x0; x < below->posts.x1; x++) {
			const size_t at = in_grid(grid, x, y);
			const bool may = (grid->marks[at] & (SHEET_GROUND | SHEET_INSIDE)) == (SHEET_GROUND | SHEET_INSIDE);
			const int64_t depth = may ? depth_below(below, planes, below->rest, x, y, grid->surface[at]) : INT64_MIN;
			if (depth <= 0)
				continue;
			const bool refuses = depth >= SOIL_SHEET_MOST || grid->surface[at] - depth < -OFFSET_LIMIT;
			tally->refused += refuses;
			if (refuses || ((grid->marks[at] & SHEET_OTHER) && depth << SHEET_BITS <= grid->deflection[at]))
				continue;
			grid->marks[at] = (uint8_t)((grid->marks[at] & ~SHEET_OTHER) | SHEET_OWN);
			grid->least[at] = (int32_t)depth << SHEET_BITS;
			grid->deflection[at] = lane_most(grid->deflection[at], grid->least[at]);
			planes->contact[in_planes(planes, x, y)] |= SOIL_LOWERED | SOIL_HELD;
		}
}

/* Makes a rut of what is beyond the yield. A post has a rut as deep as its own surface is below the base. The rut grows to a share of what the motion's
 * envelope is deeper than the yield, below the base. So a second contact in the same place adds nothing, and in the end it is that share of the
 * greatest depth. */
static void yield(const struct below *below, const struct soil_planes *planes, const struct sheet_grid *grid, const struct soil_sheet *sheet)
{
	for (int64_t y = below->posts.y0; y < below->posts.y1; y++)
		for (int64_t x = below->posts.x0; x < below->posts.x1; x++) {
			const size_t at = in_grid(grid, x, y);
			const bool may = (grid->marks[at] & (SHEET_GROUND | SHEET_INSIDE)) == (SHEET_GROUND | SHEET_INSIDE);
			const int64_t depth = may ? depth_below(below, planes, below->under, x, y, grid->surface[at]) : INT64_MIN;
			if (depth <= sheet->yield || grid->surface[at] - depth < -OFFSET_LIMIT)
				continue;
			const int64_t rut = grid->surface[at] < 0 ? -(int64_t)grid->surface[at] : 0;
			const int64_t sinks = ((rut + depth - sheet->yield) * sheet->share >> 31) - rut;
			if (sinks <= 0)
				continue;
			const int64_t left = grid->deflection[at] - (sinks << SHEET_BITS);
			grid->surface[at] = (int32_t)(grid->surface[at] - sinks);
			grid->deflection[at] = left > 0 ? (int32_t)left : 0;
			planes->contact[in_planes(planes, x, y)] |= SOIL_LOWERED;
		}
}

/* --- a body with a load --- */

/* A search for the height at which the sheet bears a body. */
struct search {
	const struct soil_sheet *sheet;
	const struct soil_planes *planes;
	struct sheet_grid grid;
	struct below below; /* the body at the height where the search begins */
	int32_t *deflection, *surface; /* as the body finds them */
	uint8_t *marks;
	size_t posts;       /* of the grid, with those around it */
	int64_t deepest;    /* fixed-point units: how far it is below the sheet there, at its deepest post; INT64_MIN: below none */
};

static void keep(struct search *search, char *memory)
{
	const struct sheet_grid *grid = &search->grid;
	const size_t first = grid->stride + 1;
	search->posts = grid->stride * ((size_t)grid->height + 2);
	search->deflection = take(&memory, search->posts * sizeof(int32_t));
	search->surface = take(&memory, search->posts * sizeof(int32_t));
	search->marks = take(&memory, search->posts);
	memcpy(search->deflection, grid->deflection - first, search->posts * sizeof(int32_t));
	memcpy(search->surface, grid->surface - first, search->posts * sizeof(int32_t));
	memcpy(search->marks, grid->marks - first, search->posts);
}

/* Returns how far the body is below the sheet at its deepest post. *below_base: how far below the base. */
static int64_t deepest_of(const struct search *search, int64_t *below_base)
{
	const struct sheet_grid *grid = &search->grid;
	const struct below *below = &search->below;
	int64_t deepest = INT64_MIN;
	*below_base = INT64_MIN;
	for (int64_t y = below->posts.y0; y < below->posts.y1; y++)
		for (int64_t x = below->posts.x0; x < below->posts.x1; x++) {
			const size_t at = in_grid(grid, x, y);
			const bool may = (grid->marks[at] & (SHEET_GROUND | SHEET_INSIDE)) == (SHEET_GROUND | SHEET_INSIDE);
			const int64_t depth = may ? depth_below(below, search->planes, below->rest, x, y, grid->surface[at]) : INT64_MIN;
			if (depth == INT64_MIN)
				continue;
			deepest = depth > deepest ? depth : deepest;
			*below_base = depth - grid->surface[at] > *below_base ? depth - grid->surface[at] : *below_base;
		}
	return deepest;
}

/* Returns the force on the body where its deepest post is so far below the sheet. */
static int64_t force_at(struct search *search, int64_t depth, int64_t *posts)
{
	struct sheet_grid *grid = &search->grid;
	const size_t first = grid->stride + 1;
	struct below lower = search->below;
	struct soil_kinematic_tally unused = {.compacted = 0};
	memcpy(grid->deflection - first, search->deflection, search->posts * sizeof(int32_t));
	memcpy(grid->surface - first, search->surface, search->posts * sizeof(int32_t));
	memcpy(grid->marks - first, search->marks, search->posts);
	memset(grid->least - first, 0, search->posts * sizeof(int32_t));
	lower.zero += search->deepest - depth;
	lower.under = lower.rest;
	if (search->sheet->yield < SOIL_SHEET_MOST)
		yield(&lower, search->planes, grid, search->sheet);
	push(&lower, search->planes, grid, &unused);
	soil_sheet_begin(grid, search->sheet);
	soil_sheet_relax(grid, search->sheet);
	return soil_sheet_force(grid, search->sheet, posts);
}

/* Finds the depth by regula falsi; the end that stays counts half the next time (Dowell and Jarratt 1971). depth: where the search begins. */
static int64_t find_depth(struct search *search, int64_t load, int64_t depth, struct soil_sheet_rest *rest)
{
	enum { TRIALS = 30 };
	const int64_t near = load / 4000 + 1;
	int64_t low = 0, high = depth, short_of = -load, beyond = force_at(search, high, &rest->posts) - load;
	while (beyond < -near && high < SOIL_SHEET_MOST - 1) {
		low = high;
		short_of = beyond;
		high = 2 * high < SOIL_SHEET_MOST - 1 ? 2 * high : SOIL_SHEET_MOST - 1;
		beyond = force_at(search, high, &rest->posts) - load;
	}
	rest->sunk = beyond < -near;
	for (int i = 0, side = 0; i < TRIALS && beyond > near && high - low > 1; i++) {
		const int64_t guess = low + (int64_t)((double)(high - low) * (double)-short_of / ((double)beyond - (double)short_of));
		const int64_t middle = guess <= low ? low + 1 : guess >= high ? high - 1 : guess;
		const int64_t over = force_at(search, middle, &rest->posts) - load;
		if (over >= -near && over <= near)
			return middle;
		if (over < 0) {
			low = middle;
			short_of = over;
			beyond = side < 0 ? beyond / 2 + near + 1 : beyond;
			side = -1;
		} else {
			high = middle;
			beyond = over;
			short_of = side > 0 ? short_of / 2 : short_of;
			side = 1;
		}
	}
	return high;
}

struct soil_sheet_rest soil_sheet_rest(const struct soil_sheet *sheet, const struct soil_kinematic *kinematic, const struct soil_sheet_contact *contact,
					    double load, double tension, const struct soil_planes *planes, void *scratch)
{
	const struct soil_kinematic_contact *body = &contact->body;
	const struct post_rect inside = post_rect_intersect(soil_sheet_posts(contact, sheet->reach, kinematic->spacing), planes->rect);
	const struct post_rect written = post_rect_intersect(post_rect_grown(soil_sheet_posts(contact, 0, kinematic->spacing), sheet->reach), inside);
	struct search search = {.sheet = sheet, .planes = planes};
	struct soil_sheet_rest rest = {.z = body->to.z};
	int64_t below_base;
	char *memory = place(planes, scratch, &search.grid);
	unpack(planes, written, &search.grid);
	envelope(kinematic, body, &body->from, &body->from, planes, memory, &search.below);
	let_go(&search.below, planes, &search.grid);
	envelope(kinematic, body, &body->to, &body->to, planes, memory, &search.below);
	keep(&search, memory + soil_sheet_room(body->shape, (size_t)search.grid.width, (size_t)search.grid.height, false) - 64 -
			      grid_bytes((size_t)search.grid.width, (size_t)search.grid.height));
	search.deepest = deepest_of(&search, &below_base);
	if (search.deepest == INT64_MIN)
		return rest;
	const double units = ldexp(load / tension, OFFSET_BITS + SHEET_BITS);
	const int64_t least = 64, begin = search.deepest < least ? least : search.deepest < SOIL_SHEET_MOST / 2 ? search.deepest : SOIL_SHEET_MOST / 2;
	const int64_t depth = find_depth(&search, units < 0x1p60 ? (int64_t)units : (int64_t)1 << 60, begin, &rest);
	rest.z -= depth - search.deepest;
	rest.sinkage = below_base + depth - search.deepest > 0 ? below_base + depth - search.deepest : 0;
	return rest;
}

void soil_sheet_run(const struct soil_sheet *sheet, const struct soil_kinematic *kinematic, const struct soil_sheet_contact *contact,
		    const struct soil_planes *planes, void *scratch, struct soil_kinematic_tally *tally, struct post_rect *changed)
{
	const struct soil_kinematic_contact *body = &contact->body;
	const struct post_rect inside = post_rect_intersect(soil_sheet_posts(contact, sheet->reach, kinematic->spacing), planes->rect);
	const struct post_rect written = post_rect_intersect(post_rect_grown(soil_sheet_posts(contact, 0, kinematic->spacing), sheet->reach), inside);
	struct sheet_grid grid;
	struct below below;
	char *memory = place(planes, scratch, &grid);
	unpack(planes, written, &grid);
	envelope(kinematic, body, &body->from, &body->from, planes, memory, &below);
	let_go(&below, planes, &grid);
	if (!contact->leaves) {
		const bool moves = !soil_only_set_down(&body->from, &body->to);
		envelope(kinematic, body, moves ? &body->from : &body->to, &body->to, planes, memory, &below);
		if (sheet->yield < SOIL_SHEET_MOST)
			yield(&below, planes, &grid, sheet);
		push(&below, planes, &grid, tally);
	}
	soil_sheet_begin(&grid, sheet);
	soil_sheet_relax(&grid, sheet);
	pack(&grid, planes, written, tally, changed);
}
