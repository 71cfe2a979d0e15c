/* Gathers the posts that a body may touch: their state from the planes, and what the body covers of their cells. */
#include "soil/law/posts.h"

#include "soil/law/cover.h"
#include "soil/law/cover_fine.h"
#include "soil/law/memory.h"
#include "soil/shape/body.h"

enum {
#define POSTS_COUNT(name) COUNT_##name,
	POSTS_WHOLES_EACH(POSTS_COUNT) POSTS_REALS_EACH(POSTS_COUNT) ARRAYS
#undef POSTS_COUNT
};

size_t soil_posts_bytes(const struct soil_posts *posts)
{
	return ARRAYS * posts->capacity * sizeof(float);
}

enum status soil_posts_need(struct soil_posts *posts, size_t count)
{
	/* Runs of posts are copied in whole blocks, so the last one ends up to a block beyond the last post. */
	if (count + POSTS_LANES <= posts->capacity)
		return STATUS_OK;
	const size_t capacity = (count + count / 2 + 3 * POSTS_LANES - 1) / POSTS_LANES * POSTS_LANES;
	soil_posts_finish(posts);
	char *memory = mem_alloc(ARRAYS * capacity, sizeof(float));
	TRY_MEM(memory, "posts under a body");
	posts->memory = memory;
#define POSTS_PLACE(name) posts->name = (void *)memory, memory += capacity * sizeof(float);
	POSTS_WHOLES_EACH(POSTS_PLACE)
	POSTS_REALS_EACH(POSTS_PLACE)
#undef POSTS_PLACE
	posts->capacity = capacity;
	return STATUS_OK;
}

void soil_posts_finish(struct soil_posts *posts)
{
	mem_free(posts->memory);
	*posts = (struct soil_posts){0};
}

struct post_rect soil_posts_below(const struct soil_law *law, const struct soil_motion *motion)
{
	const double spacing = law->spacing, x = lattice_offset_metres(motion->to.x) + motion->beyond[0], y = lattice_offset_metres(motion->to.y) + motion->beyond[1];
	const double from[2] = {motion->jumped ? x : lattice_offset_metres(motion->from.x), motion->jumped ? y : lattice_offset_metres(motion->from.y)};
	double extent[2];
	soil_body_extent(motion->shape, &motion->to, extent);
	return (struct post_rect){(int64_t)floor((fmin(x, from[0]) - extent[0]) / spacing), (int64_t)floor((fmin(y, from[1]) - extent[1]) / spacing),
				  (int64_t)ceil((fmax(x, from[0]) + extent[0]) / spacing) + 1, (int64_t)ceil((fmax(y, from[1]) + extent[1]) / spacing) + 1};
}

/* --- the planes --- */

/* A walk over the posts below a body, row by row. Places are in the body's frame. */
struct walk {
	struct post_rect below;
	double corner[2], step[2]; /* of the first post from the centre, east and north; from a post to the next one of its row */
	int64_t zero;              /* fixed-point units: the centre above the store's reference */
	double reach;              /* m: how far from its post a place of a cell can be, along an axis */
	double above;              /* m: posts count up to which the body is so much above their ground */
	float springs[2], known;   /* m: soil that sank by z, at most `known`, springs back by less than springs[0] + springs[1] z along the normal */
	int32_t raised;
};

/* Tells by how much at most the soil springs back. It is known only of one soil, and of a body that digs nothing. by_width: of the contact patch. */
static void put_springs(const struct soil_law *law, const struct soil_planes *planes, const struct soil_form *form, double by_width, struct walk *walk)
{
	const struct soil_numbers *soil = &law->soils[0];
	const bool one = planes->classes == NULL && (planes->levels == NULL || law->raster_count == 0);
	const double known = 0.25 * (double)form->radius, k = fmax(soil->bekker_kc * by_width + soil->bekker_kphi, 0);
	if (!one || law->layered || form->digs_most > 0 || !(by_width > 0) || walk->above > 0)
		return;
	walk->known = (float)known;
	const double springs = 1.001 * k * pow(known, soil->bekker_n) / soil->elastic_stiffness;
	walk->springs[soil->bekker_n >= 1] = (float)(soil->bekker_n >= 1 ? springs / known : springs);
}

/* Only posts are walked over whose neighbours are in the planes, too. */
static struct walk walk_of(const struct soil_law *law, const struct soil_planes *planes, const struct soil_body *body, const struct soil_form *form,
			   int32_t raised, double above)
{
	const struct soil_motion *motion = body->motion;
	const struct post_rect *rect = &planes->rect, inner = {rect->x0 + 1, rect->y0 + 1, rect->x1 - 1, rect->y1 - 1};
	struct walk walk = {.below = post_rect_intersect(soil_posts_below(law, motion), inner), .step = {body->axis[0] * law->spacing, -body->axis[1] * law->spacing}, .raised = raised};
	walk.corner[0] = -(double)soil_body_from_post(motion->to.x, walk.below.x0, law->spacing) - motion->beyond[0];
	walk.corner[1] = -(double)soil_body_from_post(motion->to.y, walk.below.y0, law->spacing) - motion->beyond[1];
	walk.zero = motion->to.z - (int64_t)law->reference * ((int64_t)1 << OFFSET_BITS);
	walk.reach = (double)form->half_across + 0.5 * law->spacing;
	walk.above = above;
	return walk;
}

/* Leaves the columns at which first + column x step is between low and high. */
static void cut(double first, double step, double low, double high, int64_t columns[2])
{
	if (fabs(step) < 1e-9) {
		columns[1] = first < low || first > high ? columns[0] : columns[1];
		return;
	}
	const double by = 1 / step, a = (low - first) * by, b = (high - first) * by, from = (a < b ? a : b) - 1e-6, to = (a < b ? b : a) + 1e-6;
	columns[0] = from > (double)columns[1] ? columns[1] : from > (double)columns[0] ? (int64_t)from : columns[0];
	columns[1] = to < (double)columns[0] - 1 ? columns[0] : to < (double)columns[1] - 1 ? (int64_t)(to + 1) + 1 : columns[1];
}

/* A run of posts of a row in the planes. Planes that are missing are NULL. */
struct run {
	const int32_t *base, *deposited, *sinkage, *shear, *dug, *offset, *settled, *loose, *floor, *density;
	size_t width; /* posts in a row of the planes */
	int32_t index;
};

/* What a row of a rim needs to tell which of its posts count. */
struct marks {
	float x, y, step_x, step_y;  /* of the first post; from each to the next, m */
	float radius, outer, reach, run, fell, above; /* m; reach: of a cell's places from its post along the rim */
	float lean, leans, lift, aside; /* lean, leans: along and across the axis; aside: how much lower the lower envelope can be because it leans, m */
	float rise_reach, by_reach, raised; /* m: how far from its post a place of a cell can be along each axis, of a slope of 1; the body's centre */
	float ran;                   /* m: along the rim since the motion's start */
	float springs[2], known;     /* of struct walk */
	float low, size;             /* -1: its lower end is on the right, 1: on the left; m: so far from the middle the end bears beside no cell */
	int32_t zero;                /* units of bases: the centre above the store's reference */
};

SOIL_INLINED float further(int32_t from, int32_t to)
{
	const float apart = (float)(int32_t)((uint32_t)to - (uint32_t)from);
	return either(apart < 0, -apart, apart);
}

/* Returns the first and, in *end, the end of the posts of a run that may bear a rim. Posts count, too, above which it is not higher than `above`.
 * A post does not bear where the rim is higher than the plastic part of what the post remembers, in all of its cell. Reads whole blocks. */
SOIL_CLONED static int32_t mark_run(const struct marks *restrict m, const struct run *restrict run, int32_t count, int32_t *restrict end)
{
	const int32_t *restrict base = run->base, *restrict west = base - 1, *restrict east = base + 1;
	const int32_t *restrict south = base - run->width, *restrict north = base + run->width;
	const int32_t *restrict deposited = run->deposited != NULL ? run->deposited : base, *restrict sinkage = run->sinkage != NULL ? run->sinkage : base;
	const int32_t *restrict settled = run->settled != NULL ? run->settled : deposited, *restrict loose = run->settled != NULL ? run->loose : base;
	const int32_t *restrict floor = run->settled != NULL ? run->floor : base;
	const float leans = run->settled != NULL && m->lean != 0 ? 1 : 0; /* its wall finds the ground below a loose layer */
	const int32_t loosens = run->settled != NULL;
	const float heaps = run->deposited != NULL ? SOIL_UNIT : 0, sinks = run->sinkage != NULL ? SOIL_UNIT : 0, unit = 4 * SOIL_UNIT, r2 = m->radius * m->radius;
	int32_t firsts[POSTS_LANES], lasts[POSTS_LANES], first = INT32_MAX, last = -1;
	for (int32_t lane = 0; lane < POSTS_LANES; lane++) {
		firsts[lane] = INT32_MAX;
		lasts[lane] = -1;
	}
	for (int32_t b = 0; b < count; b += POSTS_LANES)
		for (int32_t lane = 0; lane < POSTS_LANES; lane++) {
			const int32_t i = b + lane;
			const float x = m->x + (float)i * m->step_x, y = m->y + (float)i * m->step_y;
			const int32_t here = base[i];
			const bool holes = (here == BASE_NODATA) | (west[i] == BASE_NODATA) | (east[i] == BASE_NODATA) | (south[i] == BASE_NODATA) | (north[i] == BASE_NODATA);
			const float rise = (most(further(west[i], here), further(here, east[i])) + most(further(south[i], here), further(here, north[i]))) * unit * m->rise_reach;
			const float firm = leans * most(either(floor[i] < 0, -(float)floor[i], (float)floor[i]) - (float)loose[i], 0) * either(loose[i] > 0, SOIL_UNIT, 0);
			const float ground = (float)(int32_t)((uint32_t)here - (uint32_t)m->zero) * unit + (float)deposited[i] * heaps + firm - m->raised;
			/* How low the rim is in this cell, and how much its height differs from that at the post now, and at the motion's start. */
			const float near = most(most(x, -x - m->run) - m->reach, 0), outside = most(m->outer * m->outer - near * near, 0);
			const float deep = sqrtf(outside) * m->lift, lowest = m->lean * y - m->aside - deep - m->fell;
			const bool touches = (ground + rise + m->above > lowest) & (near <= m->outer);
			/* Behind the axle the rim is lower at places that are farther ahead, and was so at the motion's start, but less. */
			const float aside = y - m->leans * root(r2 - x * x);
			const int32_t is_loose = (deposited[i] > settled[i]) | (loosens & (loose[i] > 0)); /* then the rut is not the surface */
			const float inner = most(-x - m->reach, 0), sunk = (float)sinkage[i] * either(is_loose, 0, sinks);
			const float leaves = m->lean * y + sunk - ground - root(r2 - inner * inner) * m->lift;
			const float springs = (m->springs[0] + m->springs[1] * sunk) * (1 + rise * m->by_reach) + 1e-5f; /* vertically */
			const bool behind = (x < -m->ran - m->reach) & (x > -m->radius);
			const bool gone = behind & (sunk > 0) & (sunk <= m->known) & (leaves > springs + 2 * (rise + m->aside)) & !holes & (m->low * aside < m->size);
			const bool counts = (touches | holes) & !gone & (i < count);
			const int32_t here_first = counts ? i : INT32_MAX, here_last = counts ? i : -1;
			firsts[lane] = here_first < firsts[lane] ? here_first : firsts[lane];
			lasts[lane] = here_last > lasts[lane] ? here_last : lasts[lane];
		}
	SOIL_WHOLE
	for (int32_t lane = 0; lane < POSTS_LANES; lane++) {
		first = firsts[lane] < first ? firsts[lane] : first;
		last = lasts[lane] > last ? lasts[lane] : last;
	}
	*end = last + 1;
	return first;
}

/* Leaves the columns of a row at which a rim may bear on the ground, or is not higher above it than walk->above. all: posts of the planes. */
static void cut_rim(const struct walk *walk, const struct soil_body *body, const struct soil_form *form, const struct run *row, size_t all,
		    const double first[2], int64_t columns[2])
{
	const float leans = fabsf(form->lean), aside = form->way[1], run = walk->above > 0 ? form->run : 0, reach = (float)walk->reach;
	const double half = (double)(most(form->half[1], 0.5f * form->step_aside) + leans * form->radius) + 1e-3 * (double)form->spacing;
	const int64_t zero = walk->zero >> (OFFSET_BITS - BASE_BITS);
	cut(first[1], walk->step[1], -half - fmax((double)aside, 0), half - fmin((double)aside, 0), columns);
	cut(first[0], walk->step[0], -body->outer - walk->reach - (double)run, body->outer + walk->reach, columns);
	/* At the end of the planes nothing is left out. */
	const bool ends = (size_t)row->index + (size_t)columns[1] + POSTS_LANES + row->width > all;
	if (columns[1] <= columns[0] || ends || zero < INT32_MIN / 2 || zero > INT32_MAX / 2)
		return;
	const struct marks marks = {
		.x = (float)(first[0] + (double)columns[0] * walk->step[0]), .y = (float)(first[1] + (double)columns[0] * walk->step[1]),
		.step_x = (float)walk->step[0], .step_y = (float)walk->step[1], .radius = form->radius, .outer = (float)body->outer,
		.reach = form->half_across + 0.75f * fabsf(form->cut[1][0]) + 1e-5f, .run = run, .fell = walk->above > 0 ? most(form->way[2], 0) + 1e-5f : 1e-5f,
		.above = (float)walk->above, 
		.lean = form->lean * form->lift, .leans = form->lean, .low = low_side(form), .size = form->lean != 0 ? form->half[1] - 1.5f * form->step_aside : 1e9f, .lift = form->lift,
		.aside = leans * form->lift * (fabsf(aside) + reach + form->step_aside), .rise_reach = reach / form->spacing,
		.raised = (float)lattice_offset_metres(walk->raised), .springs = {walk->springs[0], walk->springs[1]}, .by_reach = 1 / reach, .known = body->outer > (double)form->radius ? 0 : walk->known, .ran = form->way[0], .zero = (int32_t)zero,
	};
	const size_t from = (size_t)columns[0];
	const struct run part = {.base = row->base + from, .deposited = row->deposited != NULL ? row->deposited + from : NULL,
				 .sinkage = row->sinkage != NULL ? row->sinkage + from : NULL, .settled = row->settled != NULL ? row->settled + from : NULL,
				 .loose = row->loose != NULL ? row->loose + from : NULL, .floor = row->floor != NULL ? row->floor + from : NULL, .width = row->width};
	int32_t end;
	const int32_t begins = mark_run(&marks, &part, (int32_t)(columns[1] - columns[0]), &end);
	columns[1] = columns[0] + end;
	columns[0] = end > 0 ? columns[0] + begins : columns[1];
}

/* Returns the height of the undisturbed surface above the body's centre, fixed-point units. What is too far away is clamped: it touches nothing. */
SOIL_INLINED int32_t ground_of(int32_t base, int32_t deposited, int64_t zero)
{
	const int64_t far = ((int64_t)1 << 30) - ((int64_t)1 << 20), height = (int64_t)base * (1 << (OFFSET_BITS - BASE_BITS)) + deposited - zero;
	return (int32_t)(height < -far ? -far : height > far ? far : height);
}

/* Tells whether a mesh may bear on a post of a row, or is not higher above it than walk->above. A slope counts as at most 2; steeper ground is near. */
static bool mesh_is_near(const struct walk *walk, const struct soil_form *form, const struct run *row, const double first[2], int64_t column)
{
	const float x = (float)(first[0] + (double)column * walk->step[0]), y = (float)(first[1] + (double)column * walk->step[1]);
	const int32_t base = row->base[column];
	if (base == BASE_NODATA)
		return false;
	const double rise = fmax(fabs((double)row->base[column + 1] - base), fabs((double)base - row->base[column - 1])) * lattice_base_metres(1);
	const int32_t loose = row->loose != NULL ? row->loose[column] : 0, floor = loose > 0 ? row->floor[column] : 0, firm = (floor < 0 ? -floor : floor) - loose; /* what walls find */
	const int64_t height = (int64_t)ground_of(base, row->deposited != NULL ? row->deposited[column] : 0, walk->zero) - walk->raised + (loose > 0 && firm > 0 ? firm : 0);
	const float low = soil_cover_fine_low(form, x, y);
	return low < 0.5f * FINE_NONE && (rise >= 2 * (double)form->spacing || (double)low <= lattice_offset_metres(height) + walk->above + 4 * walk->reach);
}

/* The same as cut_rim of a mesh. */
static void cut_mesh(const struct walk *walk, const struct soil_form *form, const struct run *row, const double first[2], int64_t columns[2])
{
	while (columns[0] < columns[1] && !mesh_is_near(walk, form, row, first, columns[0]))
		columns[0]++;
	while (columns[0] < columns[1] && !mesh_is_near(walk, form, row, first, columns[1] - 1))
		columns[1]--;
}

SOIL_INLINED void take(int32_t *restrict to, const int32_t *restrict from)
{
	memcpy(to, from, POSTS_LANES * sizeof *to);
}

SOIL_INLINED void take_if_any(int32_t *restrict to, const int32_t *restrict from)
{
	if (from != NULL)
		take(to, from);
	else
		memset(to, 0, POSTS_LANES * sizeof *to);
}

/* Finds the top layer of the posts of a block: what `loose` and `floor` are, and what it changes in `deposited` and `sinkage`. surface: offsets. */
SOIL_CLONED static void put_tops(struct soil_posts *restrict p, size_t to)
{
	int32_t any = 0;
	for (int i = 0; i < POSTS_LANES; i++) {
		const size_t at = to + (size_t)i;
		const struct memory is = memory_of(p->surface[at], p->deposited[at], p->sinkage[at], p->settled[at], p->loose[at], p->floor[at]);
		p->deposited[at] = is.deposited;
		p->sinkage[at] = is.sinkage;
		p->loose[at] = is.loose;
		p->floor[at] = is.floor;
		any |= is.loose > 0;
	}
	p->floored |= any != 0;
}

/* Copies what the planes have of a block of posts, and where the posts are. */
SOIL_CLONED static void take_block(const struct run *restrict run, const double place[restrict 2], const double step[restrict 2], int64_t zero,
				   struct soil_posts *restrict p, size_t to)
{
	for (int i = 0; i < POSTS_LANES; i++)
		p->index[to + (size_t)i] = run->index + i;
	SOIL_WHOLE
	for (int i = 0; i < POSTS_LANES; i++) {
		p->x[to + (size_t)i] = (float)(place[0] + i * step[0]);
		p->y[to + (size_t)i] = (float)(place[1] + i * step[1]);
	}
	take(p->base + to, run->base);
	take(p->west + to, run->base - 1);
	take(p->east + to, run->base + 1);
	take(p->south + to, run->base - run->width);
	take(p->north + to, run->base + run->width);
	take_if_any(p->deposited + to, run->deposited);
	take_if_any(p->sinkage + to, run->sinkage);
	take_if_any(p->shear + to, run->shear);
	take_if_any(p->digs + to, run->dug);
	take_if_any(p->surface + to, run->offset);
	take_if_any(p->settled + to, run->settled);
	take_if_any(p->loose + to, run->loose);
	take_if_any(p->floor + to, run->floor);
	take_if_any(p->density + to, run->density);
	if (run->settled != NULL)
		put_tops(p, to);
	SOIL_APART
	for (int i = 0; i < POSTS_LANES; i++) {
		const size_t at = to + (size_t)i;
		p->ground[at] = ground_of(p->base[at], p->deposited[at], zero);
		p->surface[at] = ground_of(p->base[at], p->surface[at], zero);
	}
}

/* Copies the same of fewer posts, at the end of the planes. The lanes after them get zeros. */
static void take_few(const struct run *run, size_t count, const double place[2], const double step[2], int64_t zero, struct soil_posts *p, size_t to)
{
	int32_t few[14][POSTS_LANES] = {{0}};
	const int32_t *const from[] = {run->base - run->width, run->base - 1, run->base, run->base + 1, run->base + run->width, run->deposited, run->sinkage, run->shear, run->dug, run->offset,
				       run->settled, run->loose, run->floor, run->density};
	int32_t *const into[] = {p->south, p->west, p->base, p->east, p->north, p->deposited, p->sinkage, p->shear, p->digs, p->surface,
				 p->settled, p->loose, p->floor, p->density};
	for (int k = 0; k < 14; k++) {
		if (from[k] != NULL)
			memcpy(few[k], from[k], count * sizeof **few);
		memcpy(into[k] + to, few[k], sizeof *few);
	}
	if (run->settled != NULL)
		put_tops(p, to);
	for (size_t i = 0; i < POSTS_LANES; i++) {
		p->index[to + i] = run->index + (int32_t)(i < count ? i : count - 1);
		p->x[to + i] = (float)(place[0] + (double)i * step[0]);
		p->y[to + i] = (float)(place[1] + (double)i * step[1]);
		p->ground[to + i] = ground_of(p->base[to + i], p->deposited[to + i], zero);
		p->surface[to + i] = ground_of(p->base[to + i], p->surface[to + i], zero);
	}
}

static const int32_t *after(const int32_t *plane, size_t posts)
{
	return plane != NULL ? plane + posts : NULL;
}

static struct run run_at(const struct soil_planes *planes, size_t at)
{
	return (struct run){after(planes->base, at), after(planes->deposited, at), after(planes->sinkage, at), after(planes->shear, at),
			    after(planes->dug, at), after(planes->offset, at), after(planes->settled, at), after(planes->loose, at), after(planes->floor, at),
			    after(planes->density, at), planes->width, (int32_t)at};
}

/* Copies a run of posts, in whole blocks: the lanes after its end get posts beyond it, which the next run overwrites. */
static void take_run(const struct soil_planes *planes, size_t at, size_t count, const double place[2], const struct walk *walk, struct soil_posts *p)
{
	const size_t all = planes->width * (size_t)(planes->rect.y1 - planes->rect.y0);
	for (size_t i = 0; i < count; i += POSTS_LANES) {
		const struct run run = run_at(planes, at + i);
		const double there[2] = {place[0] + (double)i * walk->step[0], place[1] + (double)i * walk->step[1]};
		if (at + i + planes->width + POSTS_LANES <= all)
			take_block(&run, there, walk->step, walk->zero, p, p->count + i);
		else
			take_few(&run, count - i < POSTS_LANES ? count - i : POSTS_LANES, there, walk->step, walk->zero, p, p->count + i);
	}
	p->count += count;
}

static void take_rows(const struct soil_planes *planes, const struct soil_body *body, const struct soil_form *form, const struct walk *walk, struct soil_posts *p)
{
	const struct post_rect *below = &walk->below;
	p->count = 0;
	p->floored = false;
	for (int64_t y = below->y0; y < below->y1; y++) {
		const double north = walk->corner[1] + (double)(y - below->y0) * (double)form->spacing;
		const double first[2] = {body->axis[0] * walk->corner[0] + body->axis[1] * north, body->axis[0] * north - body->axis[1] * walk->corner[0]};
		const size_t at = (size_t)(y - planes->rect.y0) * planes->width + (size_t)(below->x0 - planes->rect.x0);
		int64_t columns[2] = {0, below->x1 - below->x0};
		const struct run row = run_at(planes, at);
		if (form->kind == FORM_RIM)
			cut_rim(walk, body, form, &row, planes->width * (size_t)(planes->rect.y1 - planes->rect.y0), first, columns);
		else if (form->kind == FORM_RASTER)
			cut_mesh(walk, form, &row, first, columns);
		const double place[2] = {first[0] + (double)columns[0] * walk->step[0], first[1] + (double)columns[0] * walk->step[1]};
		if (columns[1] > columns[0])
			take_run(planes, at + (size_t)columns[0], (size_t)(columns[1] - columns[0]), place, walk, p);
	}
}

/* --- numbers --- */

SOIL_INLINED float rise_between(int32_t low, int32_t at, int32_t high, float scale)
{
	const int32_t from = low == BASE_NODATA ? at : low, to = high == BASE_NODATA ? at : high;
	const float rise = (float)(int32_t)((uint32_t)to - (uint32_t)from) * scale;
	return rise * ((low == BASE_NODATA) | (high == BASE_NODATA) ? 1 : 0.5f);
}

/* Computes the numbers of a block from what the planes have. A slope counts as at most 87 degrees. */
SOIL_CLONED static void put_numbers(const float axis[restrict 2], float scale, struct soil_posts *restrict p, size_t b)
{
	const float c = axis[0], s = axis[1];
	SOIL_APART
	for (int i = 0; i < POSTS_LANES; i++) {
		const float rise_x = rise_between(p->west[b + i], p->base[b + i], p->east[b + i], scale);
		const float rise_y = rise_between(p->south[b + i], p->base[b + i], p->north[b + i], scale);
		const float squares = rise_x * rise_x + rise_y * rise_y, by_up = sqrtf(1 + squares), less = FORM_STEEPEST / most(sqrtf(squares), FORM_STEEPEST);
		p->rise_x[b + i] = (c * rise_x + s * rise_y) * less;
		p->rise_y[b + i] = (c * rise_y - s * rise_x) * less;
		p->up[b + i] = most(1 / by_up, FORM_UPRIGHT);
		p->by_up[b + i] = least(by_up, 1 / FORM_UPRIGHT);
	}
	SOIL_APART
	for (int i = 0; i < POSTS_LANES; i++) {
		const float east = (float)(int32_t)(((uint32_t)p->shear[b + i] & 0xffffu) ^ 0x8000u) - 32768, north = (float)(p->shear[b + i] >> 16);
		p->shear_x[b + i] = (c * east + s * north) * 0x1p-15f;
		p->shear_y[b + i] = (c * north - s * east) * 0x1p-15f;
		p->was[b + i] = (float)p->sinkage[b + i] * SOIL_UNIT;
		p->loose_thick[b + i] = (float)p->loose[b + i] * SOIL_UNIT * p->up[b + i];
		p->dug[b + i] = (float)p->digs[b + i] * SOIL_UNIT;
	}
}

static float bounded(double value)
{
	return (float)fmin(value, 1e30);
}

/* Puts the numbers of one soil into the posts from `first` to before `last`. */
SOIL_CLONED static void put_soil(const struct stress_soil *restrict soil, float k_c, float k_phi, float compact, size_t first, size_t last, struct soil_posts *restrict p)
{
	const struct stress_soil s = *soil;
	float *restrict each[] = {p->k_c, p->k_phi, p->n, p->elastic, p->by_elastic, p->cohesion, p->tan_phi, p->modulus, p->by_modulus, p->damping, p->compact};
	const float values[] = {k_c, k_phi, s.n, s.elastic, s.by_elastic, s.cohesion, s.tan_phi, s.modulus, s.by_modulus, s.damping, compact};
	for (int k = 0; k < 11; k++) {
		float *restrict to = each[k];
		const float value = values[k];
		for (size_t i = first; i < last; i++)
			to[i] = value;
	}
}

static void fill_soil(const struct soil_numbers *soil, size_t first, size_t last, struct soil_posts *p)
{
	const struct stress_soil s = {
		.n = (float)soil->bekker_n, .elastic = bounded(soil->elastic_stiffness), .by_elastic = bounded(1 / soil->elastic_stiffness),
		.cohesion = (float)soil->cohesion, .tan_phi = (float)tan(soil->friction_angle), .modulus = bounded(soil->janosi_shear),
		.by_modulus = bounded(1 / soil->janosi_shear), .damping = (float)soil->damping,
	};
	put_soil(&s, (float)soil->bekker_kc, (float)soil->bekker_kphi, isnan(soil->compaction) ? 0 : (float)soil->compaction, first, last, p);
}

/* Puts what a soil lies over into the same posts. Rigid ground has no shear of its own: the layer keeps its. `thick` is vertical here. */
static void fill_base(const struct soil_numbers *soil, size_t first, size_t last, struct soil_posts *p)
{
	const struct soil_numbers *base = soil->over != NULL ? soil->over : soil, *shears = soil_is_rigid(base) ? soil : base;
	const bool rigid = soil_is_rigid(base);
	float *const each[] = {p->thick, p->base_k_c, p->base_k_phi, p->base_n, p->base_elastic, p->base_cohesion, p->base_tan_phi, p->base_modulus, p->base_damping};
	const float values[] = {
		soil->over != NULL ? (float)soil->thickness : LAYER_NONE, rigid ? 0 : (float)base->bekker_kc, rigid ? 1e30f : (float)base->bekker_kphi, rigid ? 1 : (float)base->bekker_n,
		rigid ? 1e30f : bounded(base->elastic_stiffness), (float)shears->cohesion, (float)tan(shears->friction_angle), bounded(shears->janosi_shear), (float)shears->damping,
	};
	for (size_t k = 0; k < sizeof values / sizeof values[0]; k++)
		for (size_t i = first; i < last; i++)
			each[k][i] = values[k];
}

/* What was laid on a post is of its upper soil, and what was dug there is missing from it. So the undisturbed surface of the top layer tells how much lies
 * over the base. Thickness is along the normal from here on. */
static void put_thickness(struct soil_posts *p)
{
	for (size_t i = 0; i < soil_posts_end(p); i++) {
		const float thick = p->thick[i] + (float)p->deposited[i] * SOIL_UNIT;
		p->left[i] = (thick - (float)p->loose[i] * SOIL_UNIT) * p->up[i];
		p->thick[i] = either(p->thick[i] < LAYER_NONE, most(thick, 0) * p->up[i], LAYER_NONE);
	}
}

static bool same_soil(const struct soil_law *law, const struct soil_planes *planes, size_t a, size_t b)
{
	return (planes->classes == NULL || planes->classes[a] == planes->classes[b]) &&
	       (planes->levels == NULL || law->raster_count == 0 || memcmp(planes->levels + SOIL_RASTERS * a, planes->levels + SOIL_RASTERS * b, SOIL_RASTERS) == 0);
}

/* Neighbours of one soil are filled together. The lanes after the last post have its soil. */
static void put_soils(const struct soil_law *law, const struct soil_planes *planes, struct soil_posts *p)
{
	const bool one = planes->classes == NULL && (planes->levels == NULL || law->raster_count == 0);
	for (size_t first = 0, last; first < p->count; first = last) {
		const size_t at = (size_t)p->index[first];
		for (last = one ? p->count : first + 1; last < p->count && same_soil(law, planes, at, (size_t)p->index[last]);)
			last++;
		const struct soil_numbers soil = soil_numbers_at(law, planes, at);
		const size_t end = last < p->count ? last : soil_posts_end(p);
		fill_soil(&soil, first, end, p);
		if (p->layered)
			fill_base(&soil, first, end, p);
	}
}

/* Makes the numbers of each post those of its layers: dense soil bears more, and a loose layer less. */
SOIL_CLONED static void put_strengths(float loosening, float hardening, struct soil_posts *restrict p, size_t b)
{
	SOIL_APART
	for (int i = 0; i < POSTS_LANES; i++) {
		/* The plane has the share of what lacked before any pass that passes have made. */
		const float compact = p->compact[b + i], made = least((float)p->density[b + i] * SOIL_UNIT, 1);
		const float harder = 1 + hardening * (compact + (1 - compact) * made);
		const bool loose = p->loose[b + i] > 0;
		p->k_c[b + i] *= harder;
		p->k_phi[b + i] *= harder;
		p->cohesion[b + i] *= either(loose, 1, harder);
		p->modulus[b + i] /= either(loose, 1, harder);
		p->by_modulus[b + i] *= either(loose, 1, harder);
		p->eases[b + i] = either(loose, (1 - loosening) / harder, 1);
	}
	/* A loose layer that a body sank into bears as soil that lay there and sank less: k (e z)^n is (1 - loosening) k z^n. */
	if (p->floored)
		for (int i = 0; i < POSTS_LANES; i++) {
			const float floor = (float)p->floor[b + i], less = power_of(1 - loosening, 1 / p->n[b + i]);
			p->floor[b + i] = whole_of(clamped(either(floor < 0, -floor * less, floor), 0, 1.9e9f));
		}
}

/* The lanes after the last post are copies of it that bear nothing. */
static void end_lanes(struct soil_posts *p)
{
	const size_t last = p->count - 1;
	for (size_t i = p->count; i < soil_posts_end(p); i++) {
#define POSTS_COPY(name) p->name[i] = p->name[last];
		POSTS_WHOLES_EACH(POSTS_COPY)
#undef POSTS_COPY
		p->x[i] = p->x[last];
		p->y[i] = p->y[last];
		p->base[i] = BASE_NODATA;
	}
}

void soil_posts_gather(const struct soil_law *law, const struct soil_planes *planes, const struct soil_body *body, const struct soil_form *form,
		       int32_t raised, double above, double by_width, struct soil_posts *posts)
{
	struct walk walk = walk_of(law, planes, body, form, raised, above);
	const float axis[2] = {(float)body->axis[0], (float)body->axis[1]};
	posts->layered = law->layered;
	put_springs(law, planes, form, by_width, &walk);
	take_rows(planes, body, form, &walk, posts);
	if (posts->count == 0)
		return;
	put_soils(law, planes, posts);
	end_lanes(posts);
	memset(posts->heap, 0, soil_posts_end(posts) * sizeof *posts->heap);
	for (size_t b = 0; b < posts->count; b += POSTS_LANES)
		put_strengths((float)law->loosening, (float)law->hardening, posts, b);
	for (size_t b = 0; b < posts->count; b += POSTS_LANES)
		put_numbers(axis, (float)(lattice_base_metres(1) / law->spacing), posts, b);
	if (posts->layered)
		put_thickness(posts);
	soil_cover(body, form, posts);
}

SOIL_CLONED static void put_width(float by_width, size_t count, const float *restrict k_c, const float *restrict k_phi, float *restrict k)
{
	SOIL_APART
	for (size_t i = 0; i < count; i++)
		k[i] = most(k_c[i] * by_width + k_phi[i], 0); /* k_c may be negative, and a patch small */
}

/* Puts the floors below loose layers, and how much less these bear. */
SOIL_CLONED static void put_floors(struct soil_posts *restrict posts)
{
	float *restrict k = posts->k;
	SOIL_APART
	for (size_t i = 0; i < soil_posts_end(posts); i++) {
		const struct stress_soil s = {.k = k[i], .n = posts->n[i], .elastic = posts->elastic[i], .by_elastic = posts->by_elastic[i]};
		posts->whole[i] = k[i];
		posts->under[i] = plastic_of(&s, (float)posts->floor[i] * SOIL_UNIT);
		k[i] *= posts->eases[i];
	}
}

/* Puts the same of floors that are layers, and how thick they are. */
SOIL_CLONED static void put_layer_floors(struct soil_posts *restrict posts)
{
	SOIL_APART
	for (size_t i = 0; i < soil_posts_end(posts); i++) {
		const struct stress_soil s = {
			.n = posts->n[i], .elastic = posts->elastic[i], .by_elastic = posts->by_elastic[i], .bulb = posts->bulb[i], .base_k = posts->base_k[i],
			.base_n = posts->base_n[i], .base_elastic = posts->base_elastic[i],
		};
		const bool is = (posts->thick[i] < LAYER_NONE) & (posts->loose[i] > 0);
		const float under = layer_under(&s, posts->left[i], posts->whole[i], (float)posts->floor[i] * SOIL_UNIT);
		posts->under[i] = either(is, under, posts->under[i]);
		posts->thick[i] = either(is, most(posts->left[i] + under, 0), posts->thick[i]);
	}
}

void soil_posts_width(float by_width, float bulb, struct soil_posts *posts)
{
	const size_t count = soil_posts_end(posts);
	put_width(by_width, count, posts->k_c, posts->k_phi, posts->k);
	if (posts->floored)
		put_floors(posts);
	if (!posts->layered)
		return;
	put_width(by_width, count, posts->base_k_c, posts->base_k_phi, posts->base_k);
	for (size_t i = 0; i < count; i++)
		posts->bulb[i] = bulb;
	if (posts->floored)
		put_layer_floors(posts);
}
